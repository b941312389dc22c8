!> Members of a family of periodic motions of a structure.
!!
!! The unknowns of a motion are, for each impact, its approach speed with the sign of the wall, and
!! its load phase; then the displacements of modes of frequency 0, whose mean positions are free. A
!! motion that is its own image half a period later, by the mirror or another symmetry of the
!! structure, is described by its first half. The speeds and phases correspond to (u_i, theta_i) of
!! the oscillator, so that both families have the same symmetries.
module vi_structure_members
   use vi_family, only: whole_unknowns
   use vi_kinds, only: two_pi, wp
   use vi_lapack_routines, only: geev
   use vi_modes, only: advance
   use vi_orbit, only: family_type
   use vi_responses, only: jumps_of, offset_pairs
   use vi_status, only: stat
   use vi_structure, only: check_structure, load_type, new_regime, regime_type, renew_regime, &
      structure_type
   use vi_structure_map, only: apply_flight, apply_impact
   use vi_structure_motion, only: equations_type, impulse_of, new_equations, residuals, since, &
      state_after
   use vi_structure_path, only: change_again, changed, changed_whole, structure_path_type
   implicit none (type, external)
   private

   public :: flight_duration, free_unknowns, member_equations, member_multipliers, &
      move_member, of_family, set_flights, set_member, set_sides, whole_sides

   !> What the members of a family have in common, besides the impacts (`family_type`, where a side
   !! is the number of a channel with the sign of its wall; with a symmetry other than the mirror,
   !! sides of opposite sign are those of gaps that it exchanges).
   type, public :: structure_members_type
      type(structure_path_type) :: path
      !> Units of speed and of length.
      real(wp) :: speed = 1, length = 1
      !> (n, p) Displacements of the modes of frequency 0 at the start.
      real(wp), allocatable :: free(:, :)
      !> Most pairs whose frequency is 0; how many of their displacements a symmetric motion has.
      integer :: p = 0, even = 0
      !> (-m:m) The gap of each side; 0 if there is none.
      integer, allocatable :: gap_of(:)
      !> (n, n) The symmetry q(t + T/2) = S q(t) that motions of the pattern can have, if it is not
      !! the mirror, -1.
      real(wp), allocatable :: symmetry(:, :)
      !> Where several gaps close at one instant along the whole family (vi_structure_together): the
      !! gaps of all impacts of a period and, for each, the impact of the family.
      integer, allocatable :: gaps(:), impact_of(:)
      !> (n, l) With the columns of `path%part`, a basis of all that these impacts reach one by one.
      real(wp), allocatable :: beside(:, :)
      !> Whether a symmetry exchanges the gaps that close together.
      logical :: exchanged = .false.
      !> The regime at the start, if those elsewhere can be renewed from it.
      type(regime_type), allocatable :: regime
   end type structure_members_type

   !> One member.
   type, public :: member_type
      !> False if the structure has no such motions there, as at a resonance.
      logical :: exists = .false.
      type(structure_type) :: structure
      type(regime_type) :: regime
      type(equations_type) :: equations
      !> (N) Approach speeds, (p) offsets.
      real(wp), allocatable :: speeds(:), offsets(:)
      !> (p, p) Offsets due to the unknown displacements.
      real(wp), allocatable :: turn(:, :)
      !> (2m, 2m) The symmetry of a symmetric motion in the pairs, if it is not the mirror.
      real(wp), allocatable :: symmetry(:, :)
      !> (m, n + 1) The pairs just before and just after the impacts of the family and the next one,
      !! if `set_flights` was called; the first columns of the former are not set.
      real(wp), allocatable, dimension(:, :) :: x_before, v_before, x_after, v_after
      !> The whole structure, where the family is only a part of its motions.
      type(structure_type) :: whole_structure
      type(regime_type) :: whole_regime
   end type member_type

contains

   !> Number of unknowns besides two for each impact: none in a family of mirror images.
   pure integer function free_unknowns(s, family)
      !> The structure.
      type(structure_members_type), intent(in) :: s
      !> The impacts.
      type(family_type), intent(in) :: family

      free_unknowns = merge(s%even, s%p, family%mirror)
   end function free_unknowns

   !> Numbers the sides as the channels, with the signs of their walls.
   pure subroutine set_sides(s)
      !> In and out: the structure, whose channels are set.
      type(structure_members_type), intent(inout) :: s
      integer :: i

      associate (structure => s%path%structure)
         allocate (s%gap_of(-structure%channels:structure%channels), source=0)
         s%gap_of(structure%channel*structure%wall) = [(i, i=1, size(structure%channel))]
      end associate
   end subroutine set_sides

   !> The sides of all impacts of a period.
   pure function whole_sides(family) result(sides)
      !> The impacts.
      type(family_type), intent(in) :: family
      integer :: sides(size(family%sides)*merge(2, 1, family%mirror))

      sides(:size(family%sides)) = family%sides
      if (family%mirror) sides(size(family%sides) + 1:) = -family%sides
   end function whole_sides

   !> The member with given unknowns at given parameters.
   pure subroutine set_member(s, family, unknowns, shares, member, searched)
      !> The structure.
      type(structure_members_type), intent(in) :: s
      !> The impacts.
      type(family_type), intent(in) :: family
      !> Its unknowns.
      real(wp), intent(in) :: unknowns(:)
      !> Each parameter, as a share of the way between its bounds.
      real(wp), intent(in) :: shares(:)
      !> The member.
      type(member_type), intent(out) :: member
      !> Whether contacts will be searched in its flights; not by default.
      logical, intent(in), optional :: searched
      type(load_type) :: load
      real(wp), allocatable :: rows(:, :)
      integer, allocatable :: pairs(:)
      logical :: with_tables, known
      integer :: status

      with_tables = .false.
      if (present(searched)) with_tables = searched
      known = allocated(s%regime) .and. .not. with_tables
      if (known) then
         member%structure = s%path%structure
         load = s%path%load
         call change_again(s%path, shares, member%structure, load)
         status = stat%ok
      else
         call changed(s%path, shares, member%structure, load)
         call check_structure(member%structure, status)
      end if
      if (status /= stat%ok .or. .not. load%frequency > 0) return
      if (known) then
         member%regime = s%regime
         call renew_regime(member%structure, load, member%regime, known)
      end if
      if (.not. known) call new_regime(member%structure, load, [integer :: ], member%regime, &
         status, with_tables)
      if (status /= stat%ok) return
      member%regime%frequency = load%frequency
      allocate (pairs, source=offset_pairs(member%regime))
      if (size(pairs) /= s%p) return
      rows = member%regime%xq(pairs, :)
      member%turn = s%length*matmul(rows, s%free)
      if (family%mirror .and. allocated(s%symmetry)) call set_symmetry(s%symmetry, member)
      if (allocated(s%impact_of)) then
         call changed_whole(s%path, shares, member%whole_structure, load)
         call check_structure(member%whole_structure, status)
         if (status == stat%ok) call new_regime(member%whole_structure, load, [integer :: ], &
            member%whole_regime, status, with_tables)
         if (status /= stat%ok) return
         member%whole_regime%frequency = load%frequency
      end if
      call set_unknowns(s, family, unknowns, member)
   end subroutine set_member

   !> The symmetry of a member in its pairs.
   pure subroutine set_symmetry(symmetry, member)
      !> (n, n) S.
      real(wp), intent(in) :: symmetry(:, :)
      !> In and out: its regime is set.
      type(member_type), intent(inout) :: member
      integer :: m

      associate (regime => member%regime)
         m = size(regime%xq, 1)
         allocate (member%symmetry(2*m, 2*m))
         member%symmetry(:m, :m) = matmul(regime%xq, matmul(symmetry, regime%qx)) &
            + matmul(regime%xd, matmul(symmetry, regime%dx))
         member%symmetry(:m, m + 1:) = matmul(regime%xq, matmul(symmetry, regime%qv)) &
            + matmul(regime%xd, matmul(symmetry, regime%dv))
         member%symmetry(m + 1:, :m) = matmul(regime%vq, matmul(symmetry, regime%qx)) &
            + matmul(regime%vd, matmul(symmetry, regime%dx))
         member%symmetry(m + 1:, m + 1:) = matmul(regime%vq, matmul(symmetry, regime%qv)) &
            + matmul(regime%vd, matmul(symmetry, regime%dv))
      end associate
   end subroutine set_symmetry

   !> The times, speeds and offsets of a member, and its equations.
   pure subroutine set_unknowns(s, family, unknowns, member)
      !> The structure.
      type(structure_members_type), intent(in) :: s
      !> The impacts.
      type(family_type), intent(in) :: family
      !> Its unknowns.
      real(wp), intent(in) :: unknowns(:)
      !> In and out: its structure and regime are set.
      type(member_type), intent(inout) :: member
      real(wp), allocatable :: whole(:)
      integer :: sides(size(family%sides)*merge(2, 1, family%mirror))
      integer :: i, n, status

      member%exists = .false.
      sides = whole_sides(family)
      n = size(sides)
      allocate (whole, source=whole_unknowns(family, unknowns))
      associate (frequency => member%regime%frequency)
         call new_equations(member%structure, member%regime, [(s%gap_of(sides(i)), i=1, n)], &
            whole(n + 1:2*n)/frequency, two_pi*family%cycles/frequency, &
            member%equations, status)
      end associate
      if (status /= stat%ok) return
      allocate (member%speeds(n), member%offsets(s%p))
      call move_member(s, family, unknowns, member)
      member%exists = .true.
   end subroutine set_unknowns

   !> Another member at the same parameters, without its equations.
   pure subroutine move_member(s, family, unknowns, member)
      !> The structure.
      type(structure_members_type), intent(in) :: s
      !> The impacts.
      type(family_type), intent(in) :: family
      !> Its unknowns.
      real(wp), intent(in) :: unknowns(:)
      !> In and out: a member at these parameters; of its equations the times alone are set, and its
      !! flights are not set.
      type(member_type), intent(inout) :: member
      real(wp), allocatable :: whole(:)
      integer :: n

      n = size(member%speeds)
      allocate (whole, source=whole_unknowns(family, unknowns))
      member%equations%times = whole(n + 1:2*n)/member%regime%frequency
      member%speeds = s%speed*sign(1, whole_sides(family))*whole(:n)
      associate (free => unknowns(2*size(family%sides) + 1:))
         member%offsets = 0
         if (size(free) > 0) member%offsets = matmul(member%turn(:, :size(free)), free)
      end associate
   end subroutine move_member

   !> The equations of a member among those of a period: of symmetric motions those of the first
   !! half, and the balances of the displacements that they can have.
   pure function of_family(family, member, whole, equations) result(part)
      !> The impacts.
      type(family_type), intent(in) :: family
      !> The member.
      type(member_type), intent(in) :: member
      !> The values of all equations, or their derivatives.
      real(wp), intent(in) :: whole(:)
      !> Number of equations of the member.
      integer, intent(in) :: equations
      real(wp) :: part(equations)
      integer :: k, n, m

      n = size(family%sides)
      m = size(member%speeds)
      part = [whole(:n), whole(m + 1:m + n), whole(2*m + 1:2*m + equations - 2*n)]
      if (.not. family%mirror) return
      do k = 1, equations - 2*n
         part(2*n + k) = dot_product(member%turn(:, k), whole(2*m + 1:))/norm2(member%turn(:, k))
      end do
   end function of_family

   !> The equations of a member: gaps, approach speeds, and balances of modes of frequency 0.
   pure subroutine member_equations(s, family, member, value, jacobian)
      !> The structure.
      type(structure_members_type), intent(in) :: s
      !> The impacts.
      type(family_type), intent(in) :: family
      !> The member.
      type(member_type), intent(in) :: member
      !> Residuals, as many as there are unknowns.
      real(wp), intent(out) :: value(:)
      !> (unknowns, unknowns) Derivative of residual j with respect to unknown i, if wanted.
      real(wp), intent(out), optional :: jacobian(:, :)
      real(wp), dimension(2*size(member%speeds) + size(member%offsets)) :: whole, scale
      real(wp), dimension(size(whole), size(whole)) :: by
      real(wp) :: rows(size(value), size(whole))
      integer :: i, k, m, n

      n = size(family%sides)
      m = size(member%speeds)
      if (.not. present(jacobian)) then
         call residuals(member%structure, member%equations, member%speeds, member%offsets, whole, &
            scale)
         value = of_family(family, member, whole, size(value))
         return
      end if
      call residuals(member%structure, member%equations, member%speeds, member%offsets, whole, &
         scale, by)
      value = of_family(family, member, whole, size(value))
      do i = 1, size(whole)
         rows(:, i) = of_family(family, member, by(:, i), size(value))
      end do
      do i = 1, n
         jacobian(i, :) = sign(1, family%sides(i))*s%speed*rows(:, m + i)
         jacobian(n + i, :) = rows(:, i)/member%regime%frequency
         if (.not. family%mirror) cycle
         jacobian(i, :) = jacobian(i, :) + sign(1, family%sides(i))*s%speed*rows(:, m + n + i)
         jacobian(n + i, :) = jacobian(n + i, :) + rows(:, n + i)/member%regime%frequency
      end do
      do k = 1, size(value) - 2*n
         jacobian(2*n + k, :) = 0
         do i = 1, size(member%offsets)
            jacobian(2*n + k, :) = jacobian(2*n + k, :) + member%turn(i, k)*rows(:, 2*m + i)
         end do
      end do
   end subroutine member_equations

   !> The pairs at the impacts of a member: from those after the first one by flights and impulses.
   pure subroutine set_flights(family, member)
      !> The impacts.
      type(family_type), intent(in) :: family
      !> In and out: the pairs are set.
      type(member_type), intent(inout) :: member
      real(wp), dimension(size(member%regime%modes%stiffness)) :: in_x, in_v
      real(wp) :: impulse, slope
      integer :: i, m, n, next

      n = size(family%sides)
      m = size(in_x)
      if (.not. allocated(member%x_after)) allocate (member%x_before(m, n + 1), &
         member%v_before(m, n + 1), member%x_after(m, n + 1), member%v_after(m, n + 1))
      call state_after(member%structure, member%regime, member%equations, member%speeds, &
         member%offsets, 1, member%x_after(:, 1), member%v_after(:, 1))
      do i = 1, n
         call advance(member%regime%modes, flight_duration(member, i), member%x_after(:, i), &
            member%v_after(:, i), member%x_before(:, i + 1), member%v_before(:, i + 1))
         next = modulo(i, size(member%speeds)) + 1
         associate (gap => member%equations%gaps(next))
            call impulse_of(member%structure, gap, member%speeds(next), impulse, slope)
            call jumps_of(member%structure, member%regime, gap, in_x, in_v)
         end associate
         member%x_after(:, i + 1) = member%x_before(:, i + 1) + impulse*in_x
         member%v_after(:, i + 1) = member%v_before(:, i + 1) + impulse*in_v
      end do
   end subroutine set_flights

   !> Duration of the flight after an impact.
   pure real(wp) function flight_duration(member, i)
      !> The member.
      type(member_type), intent(in) :: member
      !> Number of the impact.
      integer, intent(in) :: i

      flight_duration = since(member%equations%times, member%equations%period, &
         modulo(i, size(member%speeds)) + 1, i)
   end function flight_duration

   !> The multipliers of a member, without those of modes on which its impacts do not act; of a
   !! symmetric motion those of the map of half a period, with the symmetry.
   pure subroutine member_multipliers(family, member, multipliers, good)
      !> The impacts.
      type(family_type), intent(in) :: family
      !> The member, with its flights.
      type(member_type), intent(in) :: member
      !> (2m) The multipliers.
      complex(wp), allocatable, intent(out) :: multipliers(:)
      !> False if an impact has no approach speed, or DGEEV failed.
      logical, intent(out) :: good
      real(wp), dimension(2*size(member%x_after, 1), 2*size(member%x_after, 1)) :: d
      real(wp), dimension(size(member%x_after, 1)) :: in_x, in_v
      real(wp), dimension(size(d, 1)) :: re, im
      real(wp), allocatable :: part(:, :)
      real(wp) :: unused(1, 1), work(66*size(d, 1)), speed
      logical :: moved(size(d, 1))
      integer :: i, j, n, next, info, status

      n = size(family%sides)
      moved = .false.
      d = 0
      do i = 1, size(d, 1)
         d(i, i) = 1
      end do
      do i = 1, n
         next = modulo(i, size(member%speeds)) + 1
         call apply_flight(member%regime, flight_duration(member, i), d)
         ! beyond a zero of the approach speed the map continues smoothly
         speed = member%speeds(next)
         good = abs(speed) > 0
         if (.not. good) return
         call apply_impact(member%structure, member%regime, member%equations%gaps(next), &
            member%regime%frequency*member%equations%times(next), speed, &
            member%x_before(:, i + 1), member%v_before(:, i + 1), member%x_after(:, i + 1), &
            member%v_after(:, i + 1), d, status)
      end do
      do i = 1, size(member%equations%gaps)
         call jumps_of(member%structure, member%regime, member%equations%gaps(i), in_x, in_v)
         moved(:size(in_x)) = moved(:size(in_x)) .or. abs(in_x) + abs(in_v) > 0
      end do
      moved(pack([(i, i=1, size(in_x))], .not. member%regime%modes%stiffness > 0)) = &
         .not. member%equations%apart
      moved(size(in_x) + 1:) = moved(:size(in_x))
      if (allocated(member%symmetry)) then
         d = matmul(member%symmetry, d)
      else if (family%mirror) then
         d = -d
      end if
      good = all(abs(d) <= huge(1.0_wp))
      if (.not. good) return
      allocate (part(count(moved), count(moved)))
      part = reshape(pack(d, spread(moved, 1, size(moved)) .and. spread(moved, 2, size(moved))), &
         shape(part))
      j = size(part, 1)
      call geev('N', 'N', j, part, j, re, im, unused, 1, unused, 1, work, size(work), info)
      good = info == 0
      allocate (multipliers(j))
      multipliers = cmplx(re(:j), im(:j), wp)
   end subroutine member_multipliers

end module vi_structure_members
