!> The case of a &chart group, checked.
module vi_case_chart
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_case_type, only: case_type
   use vi_keys, only: complain
   use vi_kinds, only: wp
   use vi_likeness, only: allows_symmetry
   use vi_namelist, only: group_type
   use vi_pattern, only: new_pattern
   use vi_raw, only: raw_type
   use vi_text, only: lower, shown, whole
   use vi_window, only: most_numbers, most_points
   implicit none (type, external)
   private

   public :: take_chart

   integer, parameter :: most_impacts = 12

contains

   !> Checks the variables of &chart and puts them into a case.
   subroutine take_chart(group, raw, case, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: n

      case%window = raw%window
      n = len_trim(raw%sides)
      case%pattern = new_pattern(trim(raw%sides), raw%cycles)
      if (n < 2 .or. n > most_impacts .or. any(case%pattern%sides == 0) .or. &
         abs(sum(case%pattern%sides)) == n) then
         call complain(group, 'sides', line, message)
      else if (raw%cycles < 1 .or. raw%cycles > 10000) then
         call complain(group, 'cycles', line, message)
      else
         call check_window(group, raw, line, message)
         if (len(message) == 0) call check_choices(group, raw, case, line, message)
      end if
   end subroutine take_chart

   subroutine check_window(group, raw, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message

      associate (w => raw%window)
         if (.not. (w%r_min >= 1.0e-6_wp .and. w%r_min <= 1.0e6_wp)) then
            call complain(group, 'r_min', line, message)
         else if (.not. (w%r_max > w%r_min .and. w%r_max <= 1.0e6_wp)) then
            call complain(group, 'r_max', line, message, 'r_min is '//shown(w%r_min, 'g0.10'))
         else if (.not. (w%clearance_min >= 1.0e-12_wp .and. w%clearance_min <= 1.0e12_wp)) then
            call complain(group, 'clearance_min', line, message)
         else if (.not. (w%clearance_max > w%clearance_min .and. w%clearance_max <= 1.0e12_wp)) then
            call complain(group, 'clearance_max', line, message, &
               'clearance_min is '//shown(w%clearance_min, 'g0.10'))
         else if (w%r_points < 2 .or. w%r_points > most_points) then
            call complain(group, 'r_points', line, message)
         else if (w%clearance_points < 2 .or. &
            int(w%r_points, int64)*w%clearance_points > most_points) then
            call complain(group, 'clearance_points', line, message)
         end if
      end associate
   end subroutine check_window

   subroutine check_choices(group, raw, case, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      character(4), parameter :: choices(-1:1) = ['no  ', 'both', 'yes ']

      case%window%symmetry = findloc(choices == lower(raw%symmetric), .true., 1) - 2
      case%window%geometric = lower(raw%spacing) == 'geometric'
      associate (w => case%window)
         if (.not. (w%geometric .or. lower(raw%spacing) == 'linear')) then
            call complain(group, 'spacing', line, message)
         else if (w%symmetry == -2) then
            call complain(group, 'symmetric', line, message)
         else if (w%symmetry > 0 .and. .not. allows_symmetry(case%osc, case%pattern)) then
            call complain(group, 'symmetric', line, message, '''yes'' takes equal restitution, an &
               &odd number of cycles and sides whose second half mirrors the first')
         else if (w%room < 1 .or. w%room > 32) then
            call complain(group, 'room', line, message)
         else if (w%guesses < 1 .or. w%guesses > 10000) then
            call complain(group, 'guesses', line, message)
         else if (w%seeds < 1 .or. w%seeds > 10000) then
            call complain(group, 'seeds', line, message)
         else if (.not. (w%symmetry > 0 .and. size(case%pattern%sides) == 2) .and. &
            int(w%r_points, int64)*w%clearance_points*max(w%room, 4)*size(case%pattern%sides) > &
            most_numbers) then
            call complain(group, 'r_points', line, message, &
               'points x room x impacts must be at most '//whole(most_numbers))
         end if
      end associate
   end subroutine check_choices

end module vi_case_chart
