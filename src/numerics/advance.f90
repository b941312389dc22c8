!> Conservative advancement: a step along a smooth function that cannot jump over a zero.
module vi_advance
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: safe_step

   !> Time (1/omega) after which longer steps than usual are tried: by then the free part of a
   !! damped oscillation is small, and a slow load may be all that moves the masses.
   real(wp), parameter, public :: patience = 1000

contains

   !> A step within which a function g >= 0 has no zero.
   !!
   !! Over a step of at most H, a bound B on |g''''| gives g(t + h) >= g + g' h + (g''/2 + min(0,
   !! g'''/6 - B H/24) H) h^2, and the first positive zero of this parabola is safe. A large H makes
   !! the parabola pessimistic and a small one limits the step, so H is lowered towards the zero.
   !! Near a simple zero of g the step converges to it with third order. Just after a release g and
   !! its slope are nearly 0, and the lowered H is far too small. The best H is then bracketed by
   !! orders of magnitude between `near`, which is safe as a whole, and `far`, which is not.
   pure real(wp) function safe_step(g, slope, curvature, jerk, bound, limit) result(step)
      !> Value and first three derivatives now; g > 0, or g = 0 where the function starts to rise.
      real(wp), intent(in) :: g, slope, curvature, jerk
      !> Bound on the absolute fourth derivative from now on.
      real(wp), intent(in) :: bound
      !> Longest step that is wanted.
      real(wp), intent(in) :: limit
      real(wp) :: zero, reach, near, far
      integer :: i

      step = 0
      reach = limit
      zero = first_zero(g, slope, 0.5_wp*curvature)
      if (zero < 0.7_wp*limit) reach = min(limit, 1.5_wp*zero)
      if (.not. reach > 0) return
      do i = 1, 30
         zero = first_zero(g, slope, 0.5_wp*curvature &
            + min(0.0_wp, jerk/6 - bound*reach/24)*reach)
         step = max(step, min(zero, reach))
         if (i == 1) then
            ! a second look pays only with a much smaller H
            if (.not. zero < 0.6_wp*reach) return
            far = reach
            reach = 1.5_wp*zero
         else
            if (i == 2 .and. zero < reach) return
            if (zero < reach) then
               far = reach
            else
               near = reach
            end if
            if (.not. near < 0.01_wp*far) return
            reach = sqrt(near)*sqrt(far)
         end if
      end do
   end function safe_step

   !> The first positive zero of g + slope h + c h^2 with g >= 0; huge if there is none.
   pure real(wp) function first_zero(g, slope, c) result(h)
      !> Coefficients of the parabola, g >= 0.
      real(wp), intent(in) :: g, slope, c
      !> Where squares overflow, and a power of 2 by which the coefficients are then multiplied.
      real(wp), parameter :: large = 2.0_wp**(maxexponent(1.0_wp)/2 - 2), &
         small = 2.0_wp**(-maxexponent(1.0_wp)/2 - 16)
      real(wp) :: discriminant, scale

      h = huge(1.0_wp)
      scale = 1
      if (max(abs(slope), abs(c), g) > large) scale = small
      discriminant = (scale*slope)**2 - 4*(scale*c)*(scale*g)
      if (slope < 0) then
         if (discriminant >= 0) h = 2*(scale*g)/(sqrt(discriminant) - scale*slope)
      else if (c < 0) then
         h = (scale*slope + sqrt(discriminant))/(-2*(scale*c))
      end if
   end function first_zero

end module vi_advance
