!> The case of a &response group, checked.
module vi_case_response
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_case_attractor, only: check_number, check_whole
   use vi_case_type, only: case_type
   use vi_keys, only: complain, forbid, given
   use vi_kinds, only: wp
   use vi_namelist, only: group_type
   use vi_raw, only: is_blank
   use vi_text, only: whole
   use vi_window, only: even, most_numbers
   implicit none (type, external)
   private

   public :: response_clearance, take_response

contains

   !> Checks the variables of &response, which are in the case.
   subroutine take_response(group, case, line, message)
      type(group_type), intent(in) :: group
      type(case_type), intent(in) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message

      associate (a => case%attractor)
         call check_number(group, 'r_min', a%r_min, 1.0e-6_wp, 1.0e6_wp, line, message)
         call check_number(group, 'r_max', a%r_max, nearest(a%r_min, 1.0_wp), 1.0e6_wp, line, &
            message)
         call check_whole(group, 'r_points', a%r_points, 2, 1000000, line, message)
         if (len(message) == 0 .and. case%osc%xi <= 0) then
            if (any(abs(even(a%r_min, a%r_max, a%r_points) - 1) <= 0)) call complain(group, &
               'r_min', line, message, &
               'r = 1 with xi = 0 (resonance without damping) must not be among the values')
         end if
         if (len(message) == 0 .and. given(group, 'inverse_clearance')) then
            call forbid(group, 'clearance', line, message, &
               'must be left out beside inverse_clearance')
            call check_number(group, 'inverse_clearance', a%inverse_clearance, 1.0e-12_wp, &
               1.0e12_wp, line, message)
         else
            call check_number(group, 'clearance', a%clearance, 1.0e-12_wp, 1.0e12_wp, line, message)
         end if
         call check_number(group, 'load', a%load, tiny(1.0_wp), 1.0e12_wp, line, message)
         call check_whole(group, 'states', a%states, 1, 1000000, line, message)
         if (len(message) == 0 .and. int(a%r_points, int64)*a%states > most_numbers) call &
            complain(group, 'states', line, message, 'r_points x states must be at most '//whole( &
            most_numbers))
         call check_whole(group, 'settling', a%settling, 0, 10**7, line, message)
         call check_whole(group, 'keep', a%keep, 3, 10**4, line, message)
      end associate
   end subroutine take_response

   !> The clearance of a case that has it or its inverse.
   pure real(wp) function response_clearance(case) result(clearance)
      type(case_type), intent(in) :: case

      clearance = case%attractor%clearance
      associate (inverse => case%attractor%inverse_clearance)
         if (.not. is_blank(inverse)) clearance = 1/inverse
      end associate
   end function response_clearance

end module vi_case_response
