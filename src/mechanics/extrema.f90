!> Certified extrema of the relative position in a flight: none is missed, however narrow.
!!
!! The relative position y = z - x is stationary where g(t) = x'(t) - z' vanishes. Conservative
!! advancement along |g| never jumps over such an instant.
module vi_extrema
   use vi_advance, only: patience, safe_step
   use vi_flight, only: flight_position, flight_type
   use vi_kinds, only: wp
   use vi_oscillation, only: derivative_bounds, derivatives
   implicit none (type, external)
   private

   public :: relative_extrema

   !> Steps after which the search in a flight is abandoned (millions of oscillations between two
   !! impacts).
   integer, parameter :: step_budget = 10000000

contains

   !> The least and greatest stationary value of z - x strictly inside a flight.
   !!
   !! The ends of the flight are not stationary points and do not count. Where there is no
   !! stationary point, `lowest` is +huge and `highest` is -huge. With z = z_dot = 0 the result is
   !! that for -x. A time of a stationary point is resolved to delta = sqrt(epsilon) of the shortest
   !! time scale, so that the error of the value, at most |x''| delta^2/2, is of the order of
   !! rounding.
   pure subroutine relative_extrema(flight, lowest, highest, complete, lowest_at, highest_at, begin)
      !> Closed-form motion of both masses between two impacts.
      type(flight_type), intent(in) :: flight
      !> Least stationary value of z - x (F0/K), +huge if there is none.
      real(wp), intent(out) :: lowest
      !> Greatest stationary value of z - x (F0/K), -huge if there is none.
      real(wp), intent(out) :: highest
      !> False if the step budget ran out before the end of the flight.
      logical, intent(out) :: complete
      !> Times of these values (1/omega after the start); -1 where there is none.
      real(wp), intent(out), optional :: lowest_at, highest_at
      !> Time (1/omega) at which the search starts, with no stationary point before it; 0 by
      !! default.
      real(wp), intent(in), optional :: begin
      real(wp) :: t, d(0:5), g, direction, before, bound, step, shortest, usual, longest, relative
      real(wp) :: bounds(2), shrink
      integer :: n

      lowest = huge(1.0_wp)
      highest = -huge(1.0_wp)
      complete = .true.
      if (present(lowest_at)) lowest_at = -1
      if (present(highest_at)) highest_at = -1
      shortest = max(sqrt(epsilon(1.0_wp))/max(1.0_wp, flight%r), 4*spacing(flight%duration))
      usual = max(3/max(1.0_wp, flight%r), 2*shortest)
      longest = usual
      bounds = derivative_bounds(flight, 5)
      t = 0
      if (present(begin)) t = begin
      before = 0
      do n = 1, step_budget
         shrink = exp(-flight%decay*t)
         d = derivatives(flight, t, shrink)
         g = d(1) - flight%z_dot
         bound = bounds(1)*shrink + bounds(2)
         if (.not. bound > 0) return
         direction = sign(1.0_wp, g)
         step = 0
         if (abs(g) > 0) step = safe_step(abs(g), direction*d(2), direction*d(3), direction*d(4), &
            bound, longest)
         ! within rounding, a step may land on the zero or one last bit beyond it
         if (step < shortest .or. direction*before < 0) then
            if (t > shortest .and. t < flight%duration - shortest) then
               relative = flight_position(flight, t) - d(0)
               if (present(lowest_at) .and. relative < lowest) lowest_at = t
               if (present(highest_at) .and. relative > highest) highest_at = t
               lowest = min(lowest, relative)
               highest = max(highest, relative)
            end if
            step = max(step, shortest)
         end if
         before = direction
         t = t + step
         if (t > patience) longest = max(usual, 2*step)
         if (.not. t < flight%duration) return
      end do
      complete = .false.
   end subroutine relative_extrema

end module vi_extrema
