!> The time history of a periodic motion.
module vi_sample
   use vi_flight, only: flight_position, flight_state, flight_type
   use vi_kinds, only: two_pi, wp
   use vi_motion, only: flight_of, motion_type
   use vi_oscillator, only: lag
   implicit none (type, external)
   private

   public :: sample_motion

contains

   !> x, x', z, z', y = z - x and the load sin(r t + tau + lag) at any times, from the closed form.
   !!
   !! Time is 0 at the first impact; at an impact the velocities are those just after it.
   pure subroutine sample_motion(motion, times, values)
      !> A complete motion.
      type(motion_type), intent(in) :: motion
      !> (m) Any times, counted from the first impact (1/omega).
      real(wp), intent(in) :: times(:)
      !> (6, m) x, z, y in F0/K; velocities in omega F0/K; load between -1 and 1.
      real(wp), intent(out) :: values(:, :)
      type(flight_type) :: flights(size(motion%phases))
      real(wp) :: start(size(motion%phases)), period, t, x, x_dot, x_ddot, z, load_phase
      integer :: i, j

      period = two_pi*motion%pattern%cycles/motion%r
      start = motion%phases/motion%r
      load_phase = motion%tau + lag(motion%osc%xi, motion%r)
      do i = 1, size(start)
         flights(i) = flight_of(motion, i)
      end do
      do j = 1, size(times)
         t = modulo(times(j), period)
         if (.not. t < period) t = 0                     ! a tiny negative time rounds to the period
         i = max(1, count(start <= t))
         call flight_state(flights(i), t - start(i), x, x_dot, x_ddot)
         z = flight_position(flights(i), t - start(i))
         values(:, j) = [x, x_dot, z, flights(i)%z_dot, z - x, sin(motion%r*times(j) + load_phase)]
      end do
   end subroutine sample_motion

end module vi_sample
