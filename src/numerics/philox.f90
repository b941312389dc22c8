!> Counter-based random numbers: Philox4x32-10 of Salmon, Moraes, Dror and Shaw, Parallel random
!! numbers: as easy as 1, 2, 3 (SC11, 2011). Any word can be computed without those before it.
module vi_philox
   use, intrinsic :: iso_fortran_env, only: int64
   implicit none (type, external)
   private

   public :: philox

   integer, parameter :: rounds = 10
   integer(int64), parameter :: word = int(z'FFFFFFFF', int64), half_word = int(z'FFFF', int64)
   integer(int64), parameter :: factors(2) = [int(z'D2511F53', int64), int(z'CD9E8D57', int64)]
   integer(int64), parameter :: steps(2) = [int(z'9E3779B9', int64), int(z'BB67AE85', int64)]

contains

   !> Four random words of 32 bits from a counter and a key.
   pure function philox(counter, key) result(c)
      !> Words of 32 bits.
      integer(int64), intent(in) :: counter(4), key(2)
      integer(int64) :: c(4), k(2), products(2, 2)
      integer :: i

      c = counter
      k = key
      do i = 1, rounds
         products(:, 1) = product_of(factors(1), c(1))
         products(:, 2) = product_of(factors(2), c(3))
         c = [ieor(ieor(products(1, 2), c(2)), k(1)), products(2, 2), &
            ieor(ieor(products(1, 1), c(4)), k(2)), products(2, 1)]
         k = iand(k + steps, word)
      end do
   end function philox

   !> High and low word of a product, half a word at a time, so that no step overflows a signed
   !! 64-bit integer.
   pure function product_of(a, b) result(words)
      !> Factors, words of 32 bits.
      integer(int64), intent(in) :: a, b
      integer(int64) :: words(2), low, high

      low = a*iand(b, half_word)
      high = a*ishft(b, -16) + ishft(low, -16)
      words = [ishft(high, -16), ior(ishft(iand(high, half_word), 16), iand(low, half_word))]
   end function product_of

end module vi_philox
