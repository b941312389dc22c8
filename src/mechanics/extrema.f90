!> Certified extrema of the relative position in a flight: none is missed, however narrow.
!!
!! The relative position y = z - x is stationary where g(t) = x'(t) - z' vanishes. From an instant
!! with value g and slope g', and with |g''| <= B, the next zero is no nearer than the positive root
!! h of |g| + (rate of |g|) h - B h^2/2 = 0. Stepping by h therefore never jumps over a zero; near a
!! simple zero h converges to it quadratically, as Newton's method would.
module vi_extrema
   use vi_flight, only: derivative_bound, flight_position, flight_state, flight_type
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: relative_extrema

   !> Steps after which a flight is given up (millions of oscillations between two impacts).
   integer, parameter :: step_budget = 10000000

contains

   !> The least and greatest stationary value of z - x strictly inside a flight.
   !!
   !! The ends of the flight are not stationary points and do not count. Where there is no stationary
   !! point, `lowest` is +huge and `highest` is -huge. With z = z_dot = 0 the answer is that of -x.
   !! A time of a stationary point is resolved to delta = sqrt(epsilon) of the shortest time scale, so
   !! that the error of the value, at most B delta^2/2, is of the order of rounding.
   pure subroutine relative_extrema(flight, lowest, highest, complete)
      type(flight_type), intent(in) :: flight
      real(wp), intent(out) :: lowest, highest
      !> False if the step budget ran out before the end of the flight.
      logical, intent(out) :: complete
      real(wp) :: t, x, g, g_dot, before, bound, rate, root, step, shortest, relative
      integer :: n

      lowest = huge(1.0_wp)
      highest = -huge(1.0_wp)
      complete = .true.
      shortest = max(sqrt(epsilon(1.0_wp))/max(1.0_wp, flight%r), 4*spacing(flight%duration))
      t = 0
      before = 0
      do n = 1, step_budget
         call flight_state(flight, t, x, g, g_dot)
         g = g - flight%z_dot
         bound = derivative_bound(flight, 3, t)
         if (.not. bound > 0) return
         rate = sign(1.0_wp, g)*g_dot
         root = sqrt(rate**2 + 2*bound*abs(g))
         if (.not. abs(g) > 0) then
            step = 0
         else if (rate > 0) then
            step = (rate + root)/bound
         else
            step = 2*abs(g)/(root - rate)          ! the same root, without cancellation
         end if
         ! a step may land on the zero to rounding, and so a last bit beyond it
         if (step < shortest .or. before*g < 0) then
            if (t > shortest .and. t < flight%duration - shortest) then
               relative = flight_position(flight, t) - x
               lowest = min(lowest, relative)
               highest = max(highest, relative)
            end if
            step = max(step, shortest)
         end if
         before = sign(1.0_wp, g)
         t = t + step
         if (.not. t < flight%duration) return
      end do
      complete = .false.
   end subroutine relative_extrema

end module vi_extrema
