!> Whether a function stays positive between nodes, from its values and slopes there.
module vi_bernstein
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: sag, stays_above

contains

   !> Whether s f >= -level is certain from the first node to the last one (and > inside).
   !!
   !! f differs from its cubic Hermite interpolant by f/24 t^2 (h - t)^2. With a bound on |f|
   !! g = level + s f is nowhere below a quartic, and a polynomial is nowhere below the least of its
   !! Bernstein coefficients, which are written here. False means: not certain.
   pure logical function stays_above(s, level, f, rise, dip)
      !> 1 or -1.
      real(wp), intent(in) :: s, level
      !> At the nodes (n): f, and its derivative times the distance of the nodes.
      real(wp), intent(in) :: f(:), rise(:)
      !> `sag` for that distance.
      real(wp), intent(in) :: dip
      real(wp), parameter :: sixth = 1/6.0_wp
      real(wp) :: g, g_next, least
      integer :: j

      g = level + s*f(1)
      least = g
      do j = 1, size(f) - 1
         g_next = level + s*f(j + 1)
         least = min(least, g_next, g + 0.25_wp*s*rise(j), g_next - 0.25_wp*s*rise(j + 1), &
            0.5_wp*(g + g_next) + sixth*s*(rise(j) - rise(j + 1)) - dip)
         g = g_next
      end do
      stays_above = least >= 0
   end function stays_above

   !> What the interpolation over a distance h can hide from the middle coefficient.
   elemental real(wp) function sag(bound, h)
      !> Bound on the absolute fourth derivative.
      real(wp), intent(in) :: bound, h

      sag = bound*(h*h)**2/144
   end function sag

end module vi_bernstein
