!> The case of a &simulate group, checked.
module vi_case_simulation
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use vi_case_type, only: case_type
   use vi_keys, only: complain
   use vi_kinds, only: wp
   use vi_namelist, only: group_type
   use vi_raw, only: raw_type
   implicit none (type, external)
   private

   public :: take_simulation

contains

   !> Checks the variables of &simulate and puts them into a case.
   subroutine take_simulation(group, raw, case, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      character(5), parameter :: names(5) = [character(5) :: 't', 'x', 'x_dot', 'z', 'z_dot']
      integer :: i

      case%clearance = raw%clearance
      case%duration = raw%duration
      case%discard = raw%discard
      case%load = raw%load
      case%start = [raw%t, raw%x, raw%x_dot, raw%z, raw%z_dot]
      case%max_events = raw%max_events
      if (.not. (raw%clearance >= 1.0e-12_wp .and. raw%clearance <= 1.0e12_wp)) then
         call complain(group, 'clearance', line, message)
      else if (.not. (raw%duration >= 0 .and. raw%duration <= 1.0e9_wp)) then
         call complain(group, 'cycles', line, message)
      else if (.not. (raw%discard >= 0 .and. raw%discard <= 1.0e9_wp)) then
         call complain(group, 'discard', line, message)
      else if (.not. (raw%load >= 0 .and. raw%load <= 1.0e12_wp)) then
         call complain(group, 'load', line, message)
      else if (raw%max_events < 1 .or. raw%max_events > 1000000000) then
         call complain(group, 'max_events', line, message)
      else
         do i = 1, 5
            if (ieee_is_finite(case%start(i))) cycle
            call complain(group, trim(names(i)), line, message)
            return
         end do
         if (abs(raw%z - raw%x) > 0.5_wp*raw%clearance*(1 + 1.0e-9_wp)) call complain(group, 'z', &
            line, &
            message, 'z - x must be within half the clearance')
      end if
   end subroutine take_simulation

end module vi_case_simulation
