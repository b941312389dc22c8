!> A short bounce from a wall back to the same wall, as in an accumulation of impacts.
!!
!! The gap to the wall is g(t) = t k(t), k being a Taylor series that begins with the departure
!! speed, so that ever shorter bounces keep their relative accuracy.
module vi_bounce
   use vi_kinds, only: wp
   use vi_march, only: bounds_after, moment_of
   use vi_transition, only: longest => shortest_flight, transition_type
   implicit none (type, external)
   private

   public :: bounce, falls, series

   !> Terms of the series; for times up to `longest` (over the shortest time scale) the omitted ones
   !! are below 0.1^10/10! = 3e-17 of the amplitude.
   integer, parameter :: terms = 9

contains

   !> The next contact, if the flight is proved to be such a bounce; otherwise a time of 0.
   pure subroutine bounce(m, load, s, c, x, x_dot, side, speed, clearance, time, approach)
      !> Tables for the flight's damping, frequency ratio and forced motion.
      type(transition_type), intent(in) :: m
      !> Load amplitude over F0, and the sine and cosine of its phase at the start.
      real(wp), intent(in) :: load, s, c
      !> Position (F0/K) and velocity (omega F0/K) of the primary mass at the start.
      real(wp), intent(in) :: x, x_dot
      !> The wall just left: +1 right, -1 left.
      integer, intent(in) :: side
      !> Departure speed > 0 relative to that wall (omega F0/K).
      real(wp), intent(in) :: speed
      !> Distance from this wall to the other one (F0/K), which the bounce must not reach.
      real(wp), intent(in) :: clearance
      !> Time of the next contact with the same wall (1/omega after the start); 0 if the flight is
      !! not proved to be a bounce.
      real(wp), intent(out) :: time
      !> Approach speed at that contact (omega F0/K); 0 where `time` is 0.
      real(wp), intent(out) :: approach
      real(wp) :: k(0:terms - 1), t, end, step, value, slope
      integer :: i, n

      time = 0
      approach = 0
      ! a gap with constant acceleration closes after -k(0)/k(1)
      value = -0.5_wp*side*(load*s - m%two_xi*x_dot - x)
      if (.not. longest*value > 1.5_wp*speed*max(1.0_wp, m%r)) return
      t = speed/value
      end = 1.5_wp*t
      k = series(m, load, s, c, x, x_dot, side, speed)
      if (.not. falls(m, k, end, s, c, x, x_dot) .or. end*speed >= clearance) return
      do i = 1, 20
         value = 0
         slope = 0
         do n = terms - 1, 0, -1
            slope = slope*t + value
            value = value*t + k(n)
         end do
         step = -value/slope
         t = min(max(t + step, 0.0_wp), end)
         if (abs(step) <= 2*epsilon(1.0_wp)*t) exit
      end do
      if (i > 20) return
      time = t
      approach = max(0.0_wp, -t*slope)
   end subroutine bounce

   !> The coefficients of k, from the equation of motion.
   pure function series(m, load, s, c, x, x_dot, side, speed) result(k)
      !> Tables; only 2 xi, r and r^2 are read.
      type(transition_type), intent(in) :: m
      !> Load amplitude, sine and cosine of its phase, position and velocity of the primary mass at
      !! the start, departure speed, as in `bounce`.
      real(wp), intent(in) :: load, s, c, x, x_dot, speed
      !> The wall just left: +1 right, -1 left.
      integer, intent(in) :: side
      real(wp) :: k(0:terms - 1)
      real(wp) :: d(0:terms), push(0:terms), factorial
      integer :: n

      d(0:1) = [x, x_dot]
      push(0:1) = load*[s, m%r*c]
      k(0) = speed
      factorial = side
      do n = 2, terms
         push(n) = -m%r2*push(n - 2)
         d(n) = push(n - 2) - m%two_xi*d(n - 1) - d(n - 2)
         factorial = factorial*n
         k(n - 1) = d(n)/factorial
      end do
   end function series

   !> Whether k is proved to decrease from time 0 to `end` and to pass zero.
   !!
   !! |k''''| is at most a fifth of a bound on the fifth derivative of x.
   pure logical function falls(m, k, end, s, c, x, x_dot)
      !> Tables for the flight's damping, frequency ratio and forced motion.
      type(transition_type), intent(in) :: m
      !> Taylor coefficients from `series`, the end of the time span (1/omega), the sine and cosine
      !! of the load phase, position and velocity of the primary mass at the start.
      real(wp), intent(in) :: k(0:), end, s, c, x, x_dot
      real(wp) :: bounds(0:2), bound, steepest

      bounds = bounds_after(m, moment_of(m, s, c, x, x_dot, 0.0_wp, 0.0_wp))
      bound = 0.2_wp*bounds(2)
      steepest = max(k(1), k(1) + end*k(2), k(1) + end*(2*k(2) + 3*end*k(3)))
      falls = steepest + bound*end**3/6 < 0 .and. &
         k(0) + end*(k(1) + end*(k(2) + end*k(3))) + bound*end**4/24 < 0
   end function falls

end module vi_bounce
