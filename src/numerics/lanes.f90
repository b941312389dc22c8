!> Sines, cosines and exponentials of many numbers at a time, one number per lane.
!!
!! Plain loops over `lanes` numbers, which compilers turn into vector instructions. Nothing here
!! calls a library, so a lane's result has the same bits whatever the other lanes hold.
module vi_lanes
   use vi_kinds, only: wp
   use vi_plan, only: lanes
   implicit none (type, external)
   private

   public :: sine_cosine, sines_cosines, shrinkage

   !> Largest angle whose sine is as good as a library's; callers must treat larger angles
   !! differently.
   real(wp), parameter, public :: largest_angle = 1.0e5_wp
   !> Largest exponent of `shrinkage`.
   real(wp), parameter, public :: largest_exponent = 600.0_wp

   !> Adding it and then subtracting it rounds to an integer.
   real(wp), parameter :: rounder = 1.5_wp*2.0_wp**52
   !> pi and ln 2 in parts; small multiples of the leading parts are exact.
   real(wp), parameter :: pi_parts(3) = [3.14159265346825122833_wp, 1.21542010126079319532e-10_wp, &
      4.04453249759190126308e-21_wp]
   real(wp), parameter :: inverse_pi = 0.318309886183790671538_wp
   real(wp), parameter :: ln2_parts(2) = [6.93147180369123816490e-1_wp, &
      1.90821492927058770002e-10_wp]
   real(wp), parameter :: inverse_ln2 = 1.44269504088896340736_wp

contains

   !> Sines and cosines.
   pure subroutine sine_cosine(x, sine, cosine)
      !> Angles (rad), one per lane; |x| <= `largest_angle`.
      real(wp), intent(in) :: x(lanes)
      !> Their sines and cosines.
      real(wp), intent(out) :: sine(lanes), cosine(lanes)
      integer :: l

      do l = 1, lanes
         call turn(x(l), sine(l), cosine(l))
      end do
   end subroutine sine_cosine

   !> As `sine_cosine`, of any number of angles, with the same bits.
   pure subroutine sines_cosines(n, x, sine, cosine)
      !> Their number.
      integer, intent(in) :: n
      !> As in `sine_cosine`.
      real(wp), intent(in) :: x(n)
      real(wp), intent(out) :: sine(n), cosine(n)
      integer :: l

      do l = 1, n
         call turn(x(l), sine(l), cosine(l))
      end do
   end subroutine sines_cosines

   !> A sine and a cosine: the nearest multiple of pi is subtracted from x, and a Taylor series
   !! about 0 is summed.
   pure subroutine turn(x, sine, cosine)
      !> The angle, and its sine and cosine.
      real(wp), intent(in) :: x
      real(wp), intent(out) :: sine, cosine
      integer :: k
      !> The series of sin(y)/y and cos(y) in powers of y^2, for |y| up to pi/2.
      real(wp), parameter :: s(10) = [((-1)**k/gamma(2*k + 2.0_wp), k=1, 10)]
      real(wp), parameter :: c(11) = [((-1)**k/gamma(2*k + 1.0_wp), k=1, 11)]
      real(wp) :: turns, y, q, flip

      turns = (x*inverse_pi + rounder) - rounder
      y = ((x - turns*pi_parts(1)) - turns*pi_parts(2)) - turns*pi_parts(3)
      flip = 1 - 2*abs(turns - 2*((0.5_wp*turns + rounder) - rounder))
      q = y*y
      sine = flip*(y + y*(q*(s(1) + q*(s(2) + q*(s(3) + q*(s(4) + q*(s(5) + q*(s(6) &
         + q*(s(7) + q*(s(8) + q*(s(9) + q*s(10))))))))))))
      cosine = flip*(1 + q*(c(1) + q*(c(2) + q*(c(3) + q*(c(4) + q*(c(5) + q*(c(6) &
         + q*(c(7) + q*(c(8) + q*(c(9) + q*(c(10) + q*c(11))))))))))))
   end subroutine turn

   !> exp(-x) for 0 <= x <= `largest_exponent`.
   pure subroutine shrinkage(x, y)
      !> Exponents, one per lane, 0 <= x <= `largest_exponent`.
      real(wp), intent(in) :: x(lanes)
      !> exp(-x) of each lane.
      real(wp), intent(out) :: y(lanes)
      integer :: k
      real(wp), parameter :: e(13) = [(1/gamma(k + 1.0_wp), k=1, 13)]
      real(wp) :: halvings, f, shifted
      integer(selected_int_kind(18)) :: bits
      integer :: l

      do l = 1, lanes
         shifted = rounder - x(l)*inverse_ln2
         halvings = shifted - rounder
         f = (-x(l) - halvings*ln2_parts(1)) - halvings*ln2_parts(2)
         ! the last bits of `shifted` hold the integer itself, the exponent in 2**halvings
         bits = ishft(transfer(shifted, bits) + 1023, 52)
         y(l) = transfer(bits, f)*(1 + f*(e(1) + f*(e(2) + f*(e(3) + f*(e(4) + f*(e(5) + f*(e(6) &
            + f*(e(7) + f*(e(8) + f*(e(9) + f*(e(10) + f*(e(11) + f*(e(12) + f*e(13))))))))))))))
      end do
   end subroutine shrinkage

end module vi_lanes
