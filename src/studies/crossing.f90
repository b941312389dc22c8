!> Zeros of a condition on a step along a curve of motions.
module vi_crossing
   use vi_curve, only: correct, curve_type
   use vi_frame, only: condition_type, grazing, is_inside, rest_splits, rest_vanishes
   use vi_kinds, only: wp
   use vi_steps, only: place_type, survey
   implicit none (type, external)
   private

   public :: hidden_zero, innermost_zero, locate

contains

   !> Whether a condition may have changed sign twice within the last two steps.
   !!
   !! This is assumed if the parabola through three successive values has its extremum inside these
   !! steps, on the other side of zero.
   pure elemental logical function hidden_zero(before, now, next, first, second, margin) &
      result(hidden)
      !> Three successive values of the condition.
      real(wp), intent(in) :: before, now, next
      !> Lengths of the steps between them.
      real(wp), intent(in) :: first, second
      !> The extremum also counts if it is less than this share of the middle value.
      real(wp), intent(in), optional :: margin
      real(wp) :: slope, curvature, at, extreme

      hidden = .false.
      if (before*now <= 0 .or. now*next <= 0) return
      if (.not. (first > 0 .and. second > 0)) return
      curvature = ((next - now)/second - (now - before)/first)/(first + second)
      slope = (next - now)/second - curvature*second
      if (.not. abs(curvature) > 0) return
      at = -0.5_wp*slope/curvature
      if (at < -first .or. at > second) return
      extreme = now + at*(slope + curvature*at)
      hidden = extreme*now < 0
      if (present(margin)) hidden = extreme*now < margin*now**2
   end function hidden_zero

   !> The point of a step where a further condition is zero, by Newton's method or else bisection.
   pure subroutine locate(curve, conditions, from, to, which, place, share, good)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Conditions that are zero along the curve.
      type(condition_type), intent(in) :: conditions(:)
      !> Start and end of the step.
      type(place_type), intent(in) :: from, to
      !> Index of the condition that changes its sign.
      integer, intent(in) :: which
      !> Out: the place where the condition is zero, if it is found.
      type(place_type), intent(inout) :: place
      !> Share of the step.
      real(wp), intent(out) :: share
      !> Whether it is found.
      logical, intent(out) :: good
      type(condition_type) :: extra(1)
      type(place_type) :: low, high
      real(wp) :: near
      integer :: i, iterations

      ! the details of a touch are taken from the end where the gap is less
      extra(1) = to%conditions(which)
      if (any(extra(1)%kind == [grazing, rest_splits, rest_vanishes]) .and. &
         from%values(which) < to%values(which)) then
         extra(1) = from%conditions(which)
      end if
      low = from
      high = to
      do i = 1, 60
         near = low%values(which)/(low%values(which) - high%values(which))
         if (mod(i, 3) == 0 .or. .not. abs(near) <= 1) near = 0.5_wp
         place%point = low%point + near*(high%point - low%point)
         call correct(curve, [conditions, extra], place%point, iterations)
         share = dot_product(from%tangent, place%point - from%point)/from_length(from, to)
         good = iterations > 0 .and. share > -1.0e-6_wp .and. share < 1 + 1.0e-6_wp .and. &
            norm2(place%point - from%point) < 2*to%came
         if (good) exit
         if (norm2(high%point - low%point) < 1.0e-12_wp) exit
         ! narrow the bracket
         place%point = low%point + near*(high%point - low%point)
         call correct(curve, conditions, place%point, iterations, from%tangent)
         if (iterations == 0) exit
         call survey(curve, place)
         if (place%values(which)*low%values(which) > 0) then
            low%point = place%point
            low%values = place%values
         else
            high%point = place%point
            high%values = place%values
         end if
      end do
      if (.not. good) return
      place%tangent = from%tangent
      place%came = share*to%came
      place%step = to%step
      call survey(curve, place)
      place%conditions(which) = extra(1)
   end subroutine locate

   !> Length of a step along the tangent at its start.
   pure real(wp) function from_length(from, to) result(length)
      !> Start and end of the step.
      type(place_type), intent(in) :: from, to

      length = dot_product(from%tangent, to%point - from%point)
   end function from_length

   !> The zero nearest to the inside end of a step.
   !!
   !! A condition that is violated at a zero of another one was met at the inside end, so it is zero
   !! in between, even if it has the same sign at both ends: a step may pass two of its zeros.
   pure subroutine innermost_zero(curve, now, next, inside, best, which)
      !> The curve, with one active parameter.
      type(curve_type), intent(in) :: curve
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      !> Whether the step begins inside.
      logical, intent(in) :: inside
      !> Out: the place of the zero, if one is found.
      type(place_type), intent(inout) :: best
      !> The condition that is zero there; 0 if none was found.
      integer, intent(out) :: which
      integer, parameter :: most_passes = 4
      type(place_type) :: low, high, found
      type(condition_type) :: none(0)
      real(wp) :: share, nearest
      integer :: j, pass
      logical :: good

      low = now
      high = next
      which = 0
      do pass = 1, most_passes
         nearest = huge(1.0_wp)
         do j = 1, size(now%values)
            if (.not. low%values(j)*high%values(j) < 0) cycle
            call locate(curve, none, low, high, j, found, share, good)
            if (.not. good) cycle
            if (.not. inside) share = 1 - share
            if (share >= nearest) cycle
            nearest = share
            which = j
            best = found
         end do
         if (.not. nearest < huge(1.0_wp)) return
         if (is_inside(best%conditions, best%values + 1.0e-9_wp, curve%active(1))) return
         if (inside) then
            high = best
         else
            low = best
         end if
      end do
   end subroutine innermost_zero

end module vi_crossing
