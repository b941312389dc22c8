!> Evenly spaced numbers.
module vi_spacing
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: even, spaced

contains

   !> Numbers with equal ratios or equal differences, both ends included.
   pure function spaced(low, high, n, geometric) result(axis)
      !> The ends, above 0 for equal ratios.
      real(wp), intent(in) :: low, high
      !> How many, at least 2.
      integer, intent(in) :: n
      !> Whether the ratios are equal, instead of the differences.
      logical, intent(in) :: geometric
      real(wp) :: axis(n)

      if (geometric) then
         axis = exp(even(log(low), log(high), n))
         axis(1) = low
         axis(n) = high
      else
         axis = even(low, high, n)
      end if
   end function spaced

   !> Numbers with equal differences, both ends included.
   pure function even(low, high, n) result(axis)
      !> The ends.
      real(wp), intent(in) :: low, high
      !> How many, at least 2.
      integer, intent(in) :: n
      real(wp) :: axis(n)
      integer :: i

      axis = [(i*((high - low)/(n - 1)) + low, i=0, n - 1)]
      axis(n) = high
   end function even

end module vi_spacing
