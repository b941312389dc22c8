!> Test framework: count checks, print those that fail, stop with the outcome.
module checks
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: check, check_close, finish

   !> The largest number of failures to print, since a law may fail for thousands of systems.
   integer, parameter :: printed = 25
   integer :: passed = 0, failed = 0

contains

   !> Counts a check by whether it holds.
   subroutine check(condition, what)
      logical, intent(in) :: condition
      character(*), intent(in) :: what
      integer :: asked

      if (condition) then
         passed = passed + 1
      else
         failed = failed + 1
         if (failed <= printed) print '(2a)', 'FAILED: ', what
         ! a mutant is killed by its first failure
         call get_environment_variable('STOP_AT_FAILURE', length=asked)
         if (asked > 0) stop 1, quiet=.true.
      end if
   end subroutine check

   !> Counts whether |a - b| <= tolerance. NaN is close to no number.
   subroutine check_close(a, b, tolerance, what)
      real(wp), intent(in) :: a, b, tolerance
      character(*), intent(in) :: what
      character(100) :: numbers
      logical :: near

      ! tested first, because builds that trap invalid operations stop at a comparison with NaN
      near = .not. (ieee_is_nan(a) .or. ieee_is_nan(b) .or. ieee_is_nan(tolerance))
      if (near) near = abs(a - b) <= tolerance
      if (near) then
         passed = passed + 1
         return
      end if
      write (numbers, '(3(a, es24.16))') ': ', a, ' is not', b, ' within', tolerance
      call check(.false., what // trim(numbers))
   end subroutine check_close

   !> Prints the closing line and ends the program.
   subroutine finish()
      print '(i0, a, i0, a)', passed, ' passed, ', failed, ' failed'
      if (failed > 0 .or. passed == 0) stop 1, quiet=.true.
   end subroutine finish

end module checks
