!> Random numbers that are the same with every compiler and on every machine.
module random_numbers
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: fill, draw, draw_log, draw_integer

   !> Multiplicative congruential generator of Park and Miller: products fit in 64 bits.
   type, public :: random_type
      integer(int64) :: state = 20240229_int64
   end type random_type

   integer(int64), parameter :: multiplier = 48271_int64, modulus = 2147483647_int64

contains

   !> A number between low and high, with 53 random bits.
   !!
   !! One call per statement: the order of two calls in one expression is not defined.
   real(wp) function draw(random, low, high)
      type(random_type), intent(inout) :: random
      real(wp), intent(in) :: low, high
      real(wp) :: fine

      random%state = mod(multiplier*random%state, modulus)
      fine = real(random%state, wp)/real(modulus, wp)
      random%state = mod(multiplier*random%state, modulus)
      draw = low + (high - low)*((real(random%state, wp) + fine)/real(modulus, wp))
   end function draw

   !> An array of such numbers.
   subroutine fill(random, low, high, numbers)
      type(random_type), intent(inout) :: random
      real(wp), intent(in) :: low, high
      real(wp), intent(out) :: numbers(:)
      integer :: i

      do i = 1, size(numbers)
         numbers(i) = draw(random, low, high)
      end do
   end subroutine fill

   !> A number whose logarithm is uniformly distributed; 0 < low < high.
   real(wp) function draw_log(random, low, high)
      type(random_type), intent(inout) :: random
      real(wp), intent(in) :: low, high

      draw_log = exp(draw(random, log(low), log(high)))
   end function draw_log

   !> A whole number, low <= number <= high.
   integer function draw_integer(random, low, high)
      type(random_type), intent(inout) :: random
      integer, intent(in) :: low, high
      real(wp) :: number

      number = draw(random, real(low, wp), real(high + 1, wp))
      draw_integer = min(int(floor(number)), high)
   end function draw_integer

end module random_numbers
