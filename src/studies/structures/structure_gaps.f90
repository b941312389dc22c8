!> The groups &gap of a structure, with their laws of restitution, and its groups &stop and
!! &friction.
module vi_structure_gaps
   use vi_key, only: a_word, key_type
   use vi_kinds, only: wp
   use vi_restitution, only: constant_law, friction_law, power_law, pushing_law, stop_law, &
      table_law
   use vi_status, only: stat, status_text
   use vi_structure, only: check_structure, find_narrow, load_type, new_regime, regime_type, &
      structure_type
   use vi_structure_matrices, only: most_coordinates
   use vi_text, only: number_text, shown, whole
   use vi_values, only: values_type
   implicit none (type, external)
   private

   public :: check_gap, gaps_of, harmonics_of, narrow_gap, start_fault

   !> Largest modulus of a number of a direction, or of a mode shape.
   real(wp), parameter, public :: most_direction = 1.0e40_wp
   !> Most harmonics of the motion of a wall.
   integer, parameter :: most_harmonics = 100
   character(*), parameter :: of_wall = 'amplitudes of cos(Omega t), then of cos(2 Omega t), ... &
      &that are added to the opening, with Omega of the load', of_wall_sine = &
      'amplitudes of sin(Omega t), then of sin(2 Omega t), ... that are added to the opening'
   !> Largest stiffness, damping or preload of a stop.
   real(wp), parameter :: most_stop = 1.0e100_wp

   type(key_type), parameter, public :: gap_keys(*) = [ &
      key_type('direction', most=most_coordinates, low=-most_direction, high=most_direction, &
      takes='one number from -1e40 to 1e40 for each coordinate (with modes for each point), not &
      &all 0', &
      meaning='the gap closes in this direction: opening - direction.q >= 0'), &
      key_type('opening', meaning='opening of the gap at q = 0; negative if it is closed there'), &
      key_type('cosine', most=most_harmonics, may_miss=.true., meaning=of_wall), &
      key_type('sine', most=most_harmonics, may_miss=.true., meaning=of_wall_sine), &
      key_type('restitution', low=0.0_wp, high=1.0_wp, default='1', never='law=table', &
      meaning='coefficient of restitution; with law = ''power'' its value at low &
      &approach speeds'), &
      key_type('law', a_word, default='''constant''', words='constant power table', &
      meaning='how the coefficient of restitution depends on the approach speed'), &
      key_type('law_speed', low=0.0_wp, above=.true., only='law=power', &
      meaning='approach speed v0 of R (1 + (v/v0)^k)^(-p/k)'), &
      key_type('law_exponent', low=0.0_wp, only='law=power', &
      meaning='p, the exponent at high approach speeds'), &
      key_type('law_sharpness', low=0.0_wp, above=.true., default='2', only='law=power', &
      meaning='k, the sharpness of the corner at v0'), &
      key_type('law_speeds', most=most_coordinates, least=2, low=0.0_wp, only='law=table', &
      takes='at least two ascending numbers >= 0', meaning='approach speeds of a table'), &
      key_type('law_values', most=most_coordinates, least=2, low=0.0_wp, high=1.0_wp, &
      only='law=table', takes='one number from 0 to 1 for each of law_speeds', &
      meaning='coefficients of restitution at these speeds')]

   type(key_type), parameter, public :: stop_keys(*) = [ &
      key_type('direction', most=most_coordinates, low=-most_direction, high=most_direction, &
      takes=gap_keys(1)%takes, &
      meaning='the stop is pressed in this direction, by direction.q - opening where it is > 0'), &
      key_type('opening', &
      meaning='opening of the stop at q = 0; negative if it is pressed there'), &
      key_type('cosine', most=most_harmonics, may_miss=.true., meaning=of_wall), &
      key_type('sine', most=most_harmonics, may_miss=.true., meaning=of_wall_sine), &
      key_type('stiffness', low=0.0_wp, high=most_stop, meaning='stiffness of its spring'), &
      key_type('damping', low=0.0_wp, high=most_stop, default='0', &
      meaning='damping of its dashpot'), &
      key_type('preload', low=0.0_wp, high=most_stop, default='0', &
      meaning='preload: the force that acts as soon as contact is made'), &
      key_type('release', a_word, default='''gap''', words='gap force', &
      meaning='contact ends when the gap opens, or when the force vanishes, so that the stop &
      &cannot pull')]

   type(key_type), parameter, public :: friction_keys(*) = [ &
      key_type('direction', most=most_coordinates, low=-most_direction, high=most_direction, &
      takes=gap_keys(1)%takes, meaning='friction acts against direction.q_dot - speed'), &
      key_type('slip', low=0.0_wp, high=most_stop, meaning='force while it slips'), &
      key_type('stick', low=0.0_wp, high=most_stop, may_miss=.true., &
      takes='a number from slip to 1e100', &
      meaning='largest force while it sticks; slip if it is left out'), &
      key_type('speed', low=-most_stop, high=most_stop, default='0', meaning='speed of a belt')]

contains

   !> Checks a gap, a stop or friction.
   pure subroutine check_gap(gap, points)
      !> The group.
      type(values_type), intent(inout) :: gap
      !> Number of coordinates, or of points.
      integer, intent(in) :: points

      if (size(gap%numbers('direction')) /= points) then
         call gap%refuse('direction', 'it has '//whole(size(gap%numbers('direction')))//', not '// &
            whole(points))
      else if (all(abs(gap%numbers('direction')) <= 0)) then
         call gap%refuse('direction')
      end if
      if (gap%name == 'friction') then
         if (.not. gap%has('stick')) call gap%set('stick', [gap%number('slip')])
         if (gap%number('stick') < gap%number('slip')) call gap%refuse('stick')
         return
      end if
      if (gap%name == 'stop') then
         if (gap%number('stiffness') + gap%number('damping') + gap%number('preload') > 0) return
         call gap%refuse('stiffness', 'stiffness, damping or preload must be above 0')
         return
      end if
      if (.not. gap%has('law_speeds')) return
      associate (speeds => gap%numbers('law_speeds'))
         if (any(speeds(2:) <= speeds(:size(speeds) - 1))) call gap%refuse('law_speeds')
         if (size(gap%numbers('law_values')) /= size(speeds)) call gap%refuse('law_values', &
            'there are '//whole(size(speeds))//' law_speeds')
      end associate
   end subroutine check_gap

   !> Gaps, stops and friction as `new_structure` takes them.
   pure subroutine gaps_of(gaps, n, directions, gap_values, shapes)
      !> The groups.
      type(values_type), intent(in) :: gaps(:)
      !> Number of coordinates.
      integer, intent(in) :: n
      !> (n, gaps) Their directions.
      real(wp), allocatable, intent(out) :: directions(:, :)
      !> (numbers, gaps) Opening and law of each.
      real(wp), allocatable, intent(out) :: gap_values(:, :)
      !> (n, points) Shapes of modes at the points to which directions refer, if they do.
      real(wp), intent(in), optional :: shapes(:, :)
      real(wp), allocatable :: direction(:), law(:)
      integer :: i, j

      allocate (directions(n, size(gaps)), source=0.0_wp)
      allocate (gap_values(6 + 2*most_points(gaps) + 2*maxval([0, (harmonics_of(gaps(i)), i=1, &
         size(gaps))]), size(gaps)), source=0.0_wp)
      do i = 1, size(gaps)
         direction = gaps(i)%numbers('direction')
         if (present(shapes)) then
            ! point by point, so that the digits do not depend on a library
            do j = 1, size(direction)
               directions(:, i) = directions(:, i) + direction(j)*shapes(:, j)
            end do
         else
            directions(:, i) = direction
         end if
         call law_of(gaps(i), law)
         if (gaps(i)%name /= 'friction') gap_values(1, i) = gaps(i)%number('opening')
         associate (h => harmonics_of(gaps(i)))
            gap_values(2, i) = law(1) + 10*h
            if (h > 0) gap_values(3:2 + 2*h, i) = [transpose(reshape([amplitudes(gaps(i), &
               'cosine', h), amplitudes(gaps(i), 'sine', h)], [h, 2]))]
            gap_values(3 + 2*h:1 + 2*h + size(law), i) = law(2:)
         end associate
      end do
   end subroutine gaps_of

   !> Number of harmonics with which the wall of a gap or a stop moves.
   pure integer function harmonics_of(gap) result(number)
      !> The group.
      type(values_type), intent(in) :: gap

      number = 0
      if (gap%name == 'friction' .or. gap%name == 'load') return
      if (gap%has('cosine')) number = size(gap%numbers('cosine'))
      if (gap%has('sine')) number = max(number, size(gap%numbers('sine')))
   end function harmonics_of

   !> Amplitudes of a wall, with zeros for further harmonics.
   pure function amplitudes(gap, key, harmonics) result(numbers)
      !> The group, and its key.
      type(values_type), intent(in) :: gap
      character(*), intent(in) :: key
      !> Number of harmonics.
      integer, intent(in) :: harmonics
      real(wp) :: numbers(harmonics)

      numbers = 0
      if (gap%has(key)) numbers(:size(gap%numbers(key))) = gap%numbers(key)
   end function amplitudes

   !> The largest number of points of the tables of restitution of some gaps.
   pure integer function most_points(gaps) result(most)
      !> The gaps.
      type(values_type), intent(in) :: gaps(:)
      integer :: i

      most = 0
      do i = 1, size(gaps)
         if (gaps(i)%name /= 'gap') cycle
         if (gaps(i)%has('law_speeds')) most = max(most, size(gaps(i)%numbers('law_speeds')))
      end do
   end function most_points

   !> The law of restitution of a gap, or that of a stop or of friction, as `new_structure` takes
   !! it.
   pure subroutine law_of(gap, law)
      !> The gap.
      type(values_type), intent(in) :: gap
      !> Kind and numbers.
      real(wp), allocatable, intent(out) :: law(:)

      if (gap%name == 'friction') then
         law = [real(friction_law, wp), gap%number('slip'), gap%number('stick'), &
            gap%number('speed')]
      else if (gap%name == 'stop') then
         law = [real(merge(pushing_law, stop_law, gap%is('release', 'force')), wp), &
            gap%number('stiffness'), gap%number('damping'), gap%number('preload')]
      else if (gap%is('law', 'power')) then
         law = [real(power_law, wp), gap%number('restitution'), gap%number('law_speed'), &
            gap%number('law_exponent'), gap%number('law_sharpness')]
      else if (gap%is('law', 'table')) then
         law = [real(table_law, wp), real(size(gap%numbers('law_speeds')), wp), &
            gap%numbers('law_speeds'), gap%numbers('law_values')]
      else
         law = [real(constant_law, wp), gap%number('restitution')]
      end if
   end subroutine law_of

   !> A gap that is too narrow for a simulation from a state, as in `find_narrow`.
   pure subroutine narrow_gap(structure, load, q, gap, least)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      type(load_type), intent(in) :: load
      !> (n) The coordinates at the start.
      real(wp), intent(in) :: q(:)
      !> As in `find_narrow`.
      integer, intent(out) :: gap
      real(wp), intent(out) :: least
      type(structure_type) :: complete
      type(regime_type) :: regime
      integer :: status

      gap = 0
      least = 0
      complete = structure
      call check_structure(complete, status)
      if (status == stat%ok) call new_regime(complete, load, [integer ::], regime, status, .false.)
      if (status == stat%ok) call find_narrow(complete, regime, q, gap, least)
   end subroutine narrow_gap

   !> Why a simulation failed; where a gap is less than closed at its start or too narrow, with that
   !! gap.
   pure subroutine start_fault(structure, load, q, status, text)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      type(load_type), intent(in) :: load
      !> (n) The coordinates at the start; empty for 0.
      real(wp), intent(in) :: q(:)
      !> The status of the simulation.
      integer, intent(in) :: status
      !> The text.
      character(:), allocatable, intent(out) :: text
      real(wp) :: apart(size(structure%openings)), least
      integer :: gap, other

      text = status_text(status)
      if (status == stat%gap_closed .and. .not. structure%moves) then
         apart = structure%openings
         if (size(q) > 0) apart = apart - matmul(q, structure%directions)
         where (structure%laws%kind > table_law) apart = huge(1.0_wp)
         gap = minloc(apart, dim=1)
         text = text//': gap '//whole(gap - 1)//' is '//trim(number_text(apart(gap), .false., 6)) &
            //', must be >= 0'
         call find_opposite(structure, apart, gap, other)
         if (other > 0) then
            if (apart(gap) + apart(other) < 0) text = text//'; gaps '//whole(min(gap, other) - 1) &
               //' and '//whole(max(gap, other) - 1)//' face each other and overlap: the sum of &
               &their openings is '//trim(number_text(apart(gap) + apart(other), .false., 6)) &
               //', must be >= 0'
         end if
      else if (status == stat%narrow_gap) then
         call narrow_gap(structure, load, q, gap, least)
         ! what is shown may be rounded down
         text = text//': that of gap '//whole(gap - 1)//', or its sum with that of the opposite &
            &gap, must be at least '//shown(1.06_wp*least, 'es9.1')
      end if
   end subroutine start_fault

   !> The gap that faces another one, the least open one of several; 0 if there is none.
   pure subroutine find_opposite(structure, apart, gap, other)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> (gaps) How far each is open.
      real(wp), intent(in) :: apart(:)
      !> The gap, and the one that faces it.
      integer, intent(in) :: gap
      integer, intent(out) :: other
      integer :: j

      associate (directions => structure%directions)
         other = minloc(apart, dim=1, mask=[(all(abs(directions(:, j) + directions(:, gap)) <= 0), &
            j=1, size(apart))])
      end associate
   end subroutine find_opposite

end module vi_structure_gaps
