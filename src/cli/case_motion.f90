!> The case of a &motion group, checked.
module vi_case_motion
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use vi_case_type, only: case_type
   use vi_keys, only: complain, forbid, given
   use vi_kinds, only: wp
   use vi_namelist, only: group_type
   use vi_pattern, only: default_restitution, new_pattern
   use vi_raw, only: is_blank, most_impacts, raw_type
   use vi_text, only: counted, lower, shown, whole
   implicit none (type, external)
   private

   public :: take_motion

   integer, parameter :: most_cycles = 10000
   real(wp), parameter :: two_pi = 2*acos(-1.0_wp)

contains

   !> Checks the variables of &motion and puts them into a case.
   subroutine take_motion(group, raw, case, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message

      case%kind = trim(lower(raw%kind))
      case%motion_kind = case%kind
      case%single = lower(raw%precision) == 'single'
      case%acceptance = raw%acceptance
      case%clearance = raw%clearance
      if (all(case%kind /= [character(10) :: 'periodic', 'equispaced', 'exact'])) then
         call complain(group, 'kind', line, message)
      else if (.not. (case%single .or. lower(raw%precision) == 'double')) then
         call complain(group, 'precision', line, message)
      else if (.not. (raw%acceptance >= 0 .and. raw%acceptance <= 1)) then
         call complain(group, 'acceptance', line, message)
      else if (raw%cycles < 1 .or. raw%cycles > most_cycles) then
         call complain(group, 'cycles', line, message)
      else if (case%kind == 'equispaced') then
         call take_equispaced(group, raw, case, line, message)
      else
         call take_periodic(group, raw, case, line, message)
      end if
   end subroutine take_motion

   subroutine take_equispaced(group, raw, case, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      character(18), parameter :: foreign(4) = [character(18) :: 'sides', 'phases', &
         'phases_over_pi', &
         'impact_restitution']
      integer :: i

      do i = 1, size(foreign)
         if (.not. given(group, trim(foreign(i)))) cycle
         call forbid(group, trim(foreign(i)), line, message, &
            'must be left out: it is not for kind = ''equispaced'', which knows it')
         return
      end do
      case%pattern = new_pattern('RL', raw%cycles)
      case%phases = [0.0_wp, raw%cycles*acos(-1.0_wp)]
      case%restitution = case%osc%restitution
      if (.not. (raw%clearance >= 1.0e-12_wp .and. raw%clearance <= 1.0e12_wp)) then
         call complain(group, 'clearance', line, message)
      else if (modulo(raw%cycles, 2) == 0) then
         call complain(group, 'cycles', line, message, 'and must be odd for kind = ''equispaced''')
      else if (abs(case%osc%restitution(1) - case%osc%restitution(2)) > 0) then
         call complain(group, 'kind', line, message, &
            '''equispaced'' needs equal restitution on both walls')
      end if
   end subroutine take_equispaced

   subroutine take_periodic(group, raw, case, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: n

      n = len_trim(raw%sides)
      case%pattern = new_pattern(trim(raw%sides), raw%cycles)
      if (n < 2 .or. n > most_impacts .or. any(case%pattern%sides == 0) .or. &
         abs(sum(case%pattern%sides)) == n) then
         call complain(group, 'sides', line, message)
         return
      end if
      if (case%kind == 'exact') then
         call check_exact(group, raw, case, line, message)
         if (len(message) > 0) return
      else if (given(group, 'clearance')) then
         call forbid(group, 'clearance', line, message, &
            'must be left out: it is not for kind = ''periodic'', which finds the clearance')
         return
      end if
      if (given(group, 'phases') .and. given(group, 'phases_over_pi')) then
         call forbid(group, 'phases', line, message, 'must be left out beside phases_over_pi')
         return
      else if (.not. (given(group, 'phases') .or. given(group, 'phases_over_pi'))) then
         call complain(group, 'phases', line, message, 'give either phases or phases_over_pi')
         return
      end if
      if (given(group, 'phases')) then
         call take_phases(group, 'phases', raw%phases, 1.0_wp, case, line, message)
      else
         call take_phases(group, 'phases_over_pi', raw%phases_over_pi, acos(-1.0_wp), case, line, &
            message)
      end if
      if (len(message) > 0) return
      case%own_restitution = given(group, 'impact_restitution')
      if (case%own_restitution) then
         case%restitution = raw%impact_restitution(:n)
         if (length_of(raw%impact_restitution) /= n .or. &
            .not. all(case%restitution >= 0 .and. case%restitution <= 1)) then
            call complain(group, 'impact_restitution', line, message, counted(n, 'impact') &
               //' are in sides')
         end if
      else
         case%restitution = default_restitution(case%pattern%sides, case%osc%restitution(1), &
            case%osc%restitution(2))
      end if
   end subroutine take_periodic

   !> An exact motion has a given clearance, and satisfies the equations to rounding.
   subroutine check_exact(group, raw, case, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      type(case_type), intent(in) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message

      if (.not. (raw%clearance >= 1.0e-12_wp .and. raw%clearance <= 1.0e12_wp)) then
         call complain(group, 'clearance', line, message)
      else if (case%single) then
         call complain(group, 'precision', line, message, 'and ''double'' for kind = ''exact''')
      else if (given(group, 'acceptance')) then
         call forbid(group, 'acceptance', line, message, &
            'must be left out: it is not for kind = ''exact'', which leaves no residual')
      end if
   end subroutine check_exact

   !> Phases in the given unit into the case, sorted and within the period.
   subroutine take_phases(group, key, values, unit, case, line, message)
      type(group_type), intent(in) :: group
      character(*), intent(in) :: key
      real(wp), intent(in) :: values(:), unit
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: n, i

      n = size(case%pattern%sides)
      if (length_of(values) /= n) then
         call complain(group, key, line, message, counted(length_of(values), 'number')//' for ' &
            //counted(n, 'impact')//' in sides')
         return
      end if
      case%phases = values(:n)*unit
      if (.not. all(ieee_is_finite(case%phases))) then
         call complain(group, key, line, message, 'each must be finite')
      else if (abs(case%phases(1)) > 0) then
         call complain(group, key, line, message, 'the first must be 0, it sets the origin')
      else if (.not. case%phases(n) < two_pi*case%pattern%cycles) then
         call complain(group, key, line, message, 'the last must be below '// &
            shown(two_pi*case%pattern%cycles/unit, 'g0.6'))
      else
         do i = 2, n
            if (case%phases(i) > case%phases(i - 1)) cycle
            call complain(group, key, line, message, 'number '//whole(i) &
               //' is not above number '// &
               whole(i - 1))
            return
         end do
      end if
   end subroutine take_phases

   !> Numbers given in a list.
   pure integer function length_of(values)
      real(wp), intent(in) :: values(:)

      do length_of = size(values), 1, -1
         if (.not. is_blank(values(length_of))) return
      end do
      length_of = 0
   end function length_of

end module vi_case_motion
