!> Whether a function stays positive between two points, from its values and slopes there.
module vi_bernstein
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: stays_positive

contains

   !> Whether g >= 0 is certain on an interval of length h, and g > 0 inside it.
   !!
   !! g differs from its cubic Hermite interpolant by g''''(s)/24 t^2 (h - t)^2. With a bound B on
   !! |g''''| it is nowhere below a quartic whose Bernstein coefficients are given here, and a
   !! polynomial is nowhere below the least of those. False means: not certain.
   elemental logical function stays_positive(g, slope, g_end, slope_end, h, bound, rounding)
      real(wp), intent(in) :: g, slope, g_end, slope_end, h, bound
      !> What rounding may have changed in g; so much below 0 still counts as 0.
      real(wp), intent(in) :: rounding

      stays_positive = min(g, g + 0.25_wp*h*slope, 0.5_wp*(g + g_end) + h*(slope - slope_end)/6 &
         - bound*h**4/144, g_end - 0.25_wp*h*slope_end, g_end) >= -rounding
   end function stays_positive

end module vi_bernstein
