!> Keys that several studies share, and the checks that go with them.
module vi_common_keys
   use vi_kinds, only: wp
   use vi_orbit, only: by_right, n_parameters
   use vi_oscillator, only: at_resonance
   use vi_spacing, only: spaced
   use vi_text, only: exact, number_text
   use vi_study, only: a_whole, a_word, case_type, key_type, values_type
   implicit none (type, external)
   private

   public :: check_parameter, check_product, check_start, check_window, &
      half_gap, parameter_of, parameter_place, parameter_range, parameter_values, state_of, &
      turn_upwards

   real(wp), parameter, public :: least_r = 1.0e-6_wp, most_r = 1.0e6_wp, least_gap = 1.0e-12_wp, &
      most_gap = 1.0e12_wp
   !> Most numbers in a list or a table.
   integer, parameter, public :: most_numbers = 12500000
   !> Largest coordinate or velocity of a state: squares and products of any two are finite.
   real(wp), parameter, public :: most_state = 1.0e100_wp

   !> The parameters that a study can vary, in the order of the core, with their ranges.
   character(11), parameter, public :: parameters(7) = [character(11) :: 'r', 'clearance', 'xi', &
      'mu', 'R1', 'R2', 'restitution']
   type(key_type), parameter :: ranges(7) = [ &
      key_type('r', low=least_r, high=most_r), &
      key_type('clearance', low=least_gap, high=most_gap), &
      key_type('xi', low=0.0_wp, high=1.0_wp, below=.true.), &
      key_type('mu', low=0.0_wp, high=1.0e6_wp), &
      key_type('R1', low=0.0_wp, high=1.0_wp), &
      key_type('R2', low=0.0_wp, high=1.0_wp), &
      key_type('restitution', low=0.0_wp, high=1.0_wp)]

   type(key_type), parameter, public :: clearance_key = key_type('clearance', low=least_gap, &
      high=most_gap, unit='F0/K', &
      meaning='clearance d K/F0; d is the whole travel of m between the walls')
   type(key_type), parameter, public :: load_key = key_type('load', low=0.0_wp, high=1.0e12_wp, &
      default='1', unit='F0', &
      meaning='load amplitude, in units of the load that defines the unit of length')
   !> Of a structure the number is compared at the ends of load cycles wherever a simulation goes on
   !! by whole cycles (`vi_structure_return`), so that up to a cycle more may be simulated.
   type(key_type), parameter, public :: max_events_key = key_type('max_events', a_whole, &
      default='10000000', low=1.0_wp, high=1.0e9_wp, &
      meaning='impacts, rests, releases, contacts and slips after which a simulation is abandoned')
   !> How long a motion settles, and how long it is then examined.
   type(key_type), parameter, public :: settling_key = key_type('settling', a_whole, &
      default='300', low=0.0_wp, high=1.0e7_wp, &
      meaning='load cycles simulated at each value before the motion is examined')
   type(key_type), parameter, public :: keep_key = key_type('keep', a_whole, default='33', &
      low=3.0_wp, high=1.0e4_wp, &
      meaning='load cycles examined afterwards; periods of up to half of them are detected')
   type(key_type), parameter, public :: cycles_key = key_type('cycles', a_whole, default='1', &
      low=1.0_wp, high=1.0e4_wp, meaning='load cycles in a period')
   type(key_type), parameter, public :: symmetric_key = key_type('symmetric', a_word, &
      default='''both''', words='yes no both', takes='''yes'' (only motions that are their own &
      &mirror image), ''no'' (only others) or ''both''', &
      meaning='only motions that are their own mirror image, only others, or both')
   type(key_type), parameter, public :: spacing_key = key_type('spacing', a_word, &
      default='''linear''', words='linear geometric', takes='''linear'' or ''geometric'' (of the &
      &values)')

   !> The window of zones and charts.
   type(key_type), parameter, public :: window_keys(4) = [ &
      key_type('r_min', low=least_r, high=most_r, option='r', unit='omega', &
      meaning='first frequency ratio'), &
      key_type('r_max', low=least_r, high=most_r, over='r_min', option='r', unit='omega', &
      meaning='last frequency ratio'), &
      key_type('clearance_min', low=least_gap, high=most_gap, option='clearance', unit='F0/K', &
      meaning='first clearance d K/F0; d is the whole travel of m between the walls'), &
      key_type('clearance_max', low=least_gap, high=most_gap, over='clearance_min', &
      option='clearance', unit='F0/K', meaning='last clearance d K/F0')]

   !> An initial state.
   type(key_type), parameter, public :: state_keys(5) = [ &
      key_type('t', default='0', low=-most_state, high=most_state, unit='1/omega', &
      meaning='time; the load phase is r t'), &
      key_type('x', default='0', low=-most_state, high=most_state, &
      option='state', unit='F0/K', meaning='displacement of the primary mass'), &
      key_type('x_dot', default='0', low=-most_state, high=most_state, &
      option='state', unit='omega F0/K', meaning='velocity of the primary mass'), &
      key_type('z', default='0', low=-most_state, high=most_state, &
      option='state', unit='F0/K', meaning='displacement of the free mass'), &
      key_type('z_dot', default='0', low=-most_state, high=most_state, &
      option='state', unit='omega F0/K', meaning='velocity of the free mass')]

   character(*), parameter, public :: parameter_words = 'r clearance xi mu R1 R2 restitution'
   character(*), parameter, public :: parameter_takes = '''r'', ''clearance'', ''xi'', ''mu'', &
      &''R1'', ''R2'' or ''restitution'' (both walls)'
   character(*), parameter, public :: range_takes = 'a number in the range of the parameter (1e-6 &
      &<= r <= 1e6, 1e-12 <= clearance <= 1e12, 0 <= xi < 1, 0 <= mu <= 1e6, 0 <= R <= 1)'
   character(*), parameter, public :: resonance = &
      'r = 1 with xi = 0 (resonance without damping) must not be '

contains

   !> Checks the parameter of a study along a range of values.
   subroutine check_parameter(case)
      !> The case, with `parameter`, `low`, `high`, `values` and `spacing` in its study, or a
      !! `list`.
      type(case_type), intent(inout) :: case
      integer :: place
      logical :: geometric

      if (.not. case%study%has('parameter') .or. len(case%study%fault) > 0) return
      place = findloc(parameters == case%study%word('parameter'), .true., 1)
      if (case%study%has('list')) then
         call turn_upwards(case%study, 'list', [character(9) :: 'r', 'clearance'])
         call check_list(case, place)
         return
      end if
      associate (low => case%study%number('low'), high => case%study%number('high'))
         geometric = case%study%is('spacing', 'geometric')
         if (.not. in_range(low, place)) then
            call case%study%refuse('low')
         else if (.not. in_range(high, place)) then
            call case%study%refuse('high')
         else if (geometric .and. low <= 0) then
            call case%study%refuse('low', 'above 0 with spacing = ''geometric''')
         else if (.not. rise(parameter_values(case))) then
            call case%study%refuse('values', 'there are not that many distinct values between &
               &'//exact(low)// &
               ' and '//exact(high))
         else if (parameters(place) == 'r') then
            if (any(at_resonance(case%osc%xi, parameter_values(case)))) call &
               case%study%refuse('low', resonance//'among the values')
         else if (parameters(place) == 'xi' .and. at_resonance(low, case%r)) then
            call case%study%refuse('low', resonance//'among the values')
         end if
      end associate
   end subroutine check_parameter

   !> Reverses a list that falls throughout, so that a case does not depend on its direction.
   pure subroutine turn_upwards(study, name, others)
      !> The group.
      type(values_type), intent(inout) :: study
      !> The key of the list.
      character(*), intent(in) :: name
      !> Keys with one number for each of its values, which are reversed together with it.
      character(*), intent(in) :: others(:)
      real(wp), allocatable :: list(:), other(:)
      integer :: i

      if (len(study%fault) > 0 .or. .not. study%has(name)) return
      list = study%numbers(name)
      if (size(list) < 2 .or. any(list(2:) >= list(:size(list) - 1))) return
      call study%set(name, list(size(list):1:-1))
      do i = 1, size(others)
         if (others(i) == name .or. .not. study%has(trim(others(i)))) cycle
         other = study%numbers(trim(others(i)))
         if (size(other) == size(list)) call study%set(trim(others(i)), other(size(other):1:-1))
      end do
   end subroutine turn_upwards

   !> Checks a list of values of a parameter.
   subroutine check_list(case, place)
      !> The case, with `list` in its study.
      type(case_type), intent(inout) :: case
      !> Place of the parameter in `parameters`.
      integer, intent(in) :: place

      associate (values => case%study%numbers('list'))
         if (.not. (rise(values) .and. in_range(minval(values), place) .and. &
            in_range(maxval(values), place))) then
            call case%study%refuse('list')
         else if (parameters(place) == 'r') then
            if (any(at_resonance(case%osc%xi, values))) call case%study%refuse('list', resonance// &
               'among the values')
         else if (parameters(place) == 'xi' .and. at_resonance(values(1), case%r)) then
            call case%study%refuse('list', resonance//'among the values')
         end if
      end associate
   end subroutine check_list

   !> Whether a value is in the range of a parameter.
   pure logical function in_range(value, place)
      !> A number.
      real(wp), intent(in) :: value
      !> Place of the parameter in `parameters`.
      integer, intent(in) :: place

      in_range = value >= ranges(place)%low .and. value <= ranges(place)%high
      if (ranges(place)%below) in_range = in_range .and. value < ranges(place)%high
   end function in_range

   !> The ends of the range of a parameter, and the range in words, padded with blanks.
   pure subroutine parameter_range(place, low, high, text)
      !> Place of the parameter in `parameters`.
      integer, intent(in) :: place
      !> Least and greatest allowed value.
      real(wp), intent(out) :: low, high
      !> Such as 0 <= xi < 1.
      character(40), intent(out) :: text

      low = ranges(place)%low
      high = ranges(place)%high
      text = trim(number_text(low, .false.))//' <= '//trim(ranges(place)%name)//' '//trim(merge( &
         '< ', '<=', ranges(place)%below))//' '//number_text(high, .false.)
      if (ranges(place)%below) high = nearest(high, -1.0_wp)
   end subroutine parameter_range

   !> Whether each number is above the previous one.
   pure logical function rise(values)
      !> Some numbers.
      real(wp), intent(in) :: values(:)

      rise = all(values(2:) > values(:size(values) - 1))
   end function rise

   !> The parameter of a study; blank if it has none.
   pure character(24) function parameter_of(case)
      !> The case.
      type(case_type), intent(in) :: case

      parameter_of = case%study%word('parameter')
   end function parameter_of

   !> The values of the parameter.
   pure function parameter_values(case) result(values)
      !> The case, with `low`, `high`, `values` and `spacing` in its study, or a `list`.
      type(case_type), intent(in) :: case
      real(wp), allocatable :: values(:)

      if (case%study%has('list')) then
         values = case%study%numbers('list')
         return
      end if
      values = spaced(case%study%number('low'), case%study%number('high'), &
         case%study%whole_number('values'), case%study%is('spacing', 'geometric'))
   end function parameter_values

   !> The place of a parameter in the core, and whether it stands for both walls.
   pure subroutine parameter_place(name, place, tied)
      !> One of `parameters`.
      character(*), intent(in) :: name
      !> Place of the parameter in the core.
      integer, intent(out) :: place
      !> Whether both walls change.
      logical, intent(out) :: tied

      place = findloc(parameters == name, .true., 1)
      tied = place > n_parameters
      if (tied) place = by_right
   end subroutine parameter_place

   !> Checks that a window does not contain the resonance of an undamped system.
   pure subroutine check_window(case)
      !> The case, with `window_keys` in its study.
      type(case_type), intent(inout) :: case

      if (len(case%study%fault) > 0 .or. .not. at_resonance(case%osc%xi, 1.0_wp)) return
      if (case%study%number('r_min') <= 1 .and. case%study%number('r_max') >= 1) call &
         case%study%refuse('r_min', 'r = 1 must not be in the window when xi = 0 (resonance &
         &without damping)')
   end subroutine check_window

   !> Largest distance of the free mass from the middle, with a margin for the rounding of a
   !! computed state.
   pure real(wp) function half_gap(clearance)
      !> The clearance.
      real(wp), intent(in) :: clearance

      half_gap = 0.5_wp*clearance*(1 + 1.0e-9_wp)
   end function half_gap

   !> The initial state: t, x, x', z, z'.
   pure function state_of(study) result(state)
      !> The group, with a value for each of `state_keys`.
      type(values_type), intent(in) :: study
      real(wp) :: state(5)
      integer :: i

      do i = 1, 5
         state(i) = study%number(trim(state_keys(i)%name))
      end do
   end function state_of

   !> Checks that the free mass starts between the walls.
   pure subroutine check_start(study, clearance)
      !> The group, with `state_keys`.
      type(values_type), intent(inout) :: study
      !> The smallest clearance.
      real(wp), intent(in) :: clearance

      if (len(study%fault) > 0) return
      if (abs(study%number('z') - study%number('x')) > half_gap(clearance)) call study%refuse('z', &
         'z - x must be within half the clearance')
   end subroutine check_start

   !> Checks that a result does not get too large.
   pure subroutine check_product(study, key, factors, words)
      !> The study.
      type(values_type), intent(inout) :: study
      !> The key that the message names.
      character(*), intent(in) :: key
      !> The factors.
      integer, intent(in) :: factors(:)
      !> The limit in words.
      character(*), intent(in) :: words

      if (product(real(factors, wp)) > most_numbers) call study%refuse(key, words)
   end subroutine check_product

end module vi_common_keys
