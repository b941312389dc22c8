!> Whether a function stays within limits between nodes, from its values and slopes there.
module vi_bernstein
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: sag, stays_within

contains

   !> Whether |f| <= level is certain from the first node to the last one.
   !!
   !! f differs from its cubic Hermite interpolant by f''''/24 t^2 (h - t)^2. With a bound on f''''
   !! it lies between two quartics. Each of these lies between its least and its greatest Bernstein
   !! coefficient, which are evaluated here. False means that it is not certain.
   pure logical function stays_within(level, f, rise, dip)
      !> Bound >= 0 on |f| that is to be proved.
      real(wp), intent(in) :: level
      !> At the nodes (n): f, and its derivative times the distance between the nodes.
      real(wp), intent(in) :: f(:), rise(:)
      !> `sag` for that distance.
      real(wp), intent(in) :: dip
      real(wp), parameter :: sixth = 1/6.0_wp
      real(wp) :: largest
      integer :: j

      largest = abs(f(1))
      do j = 1, size(f) - 1
         largest = max(largest, abs(f(j) + 0.25_wp*rise(j)), &
            abs(0.5_wp*(f(j) + f(j + 1)) + sixth*(rise(j) - rise(j + 1))) + dip, &
            abs(f(j + 1) - 0.25_wp*rise(j + 1)), abs(f(j + 1)))
      end do
      stays_within = largest <= level
   end function stays_within

   !> Largest error of the middle Bernstein coefficient that the interpolation over a distance h can
   !! cause.
   elemental real(wp) function sag(bound, h)
      !> Bound on the absolute fourth derivative, and the distance between the nodes.
      real(wp), intent(in) :: bound, h

      sag = bound*(h*h)**2/144
   end function sag

end module vi_bernstein
