!> Periods of simulations that come near to a motion of a pattern without rest.
module vi_seeds
   use vi_event_symbols, only: total_phase
   use vi_forced_system, only: impact_event, initial_state
   use vi_kinds, only: wp
   use vi_orbit, only: by_clearance, by_left, by_mu, by_r, by_right, by_xi
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_simulate, only: event_type, forced_system_type, new_forced_system, simulate_cycles, &
      state_type
   use vi_starts, only: state_start
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: simulate_return

   real(wp), parameter :: two_pi = 2*acos(-1.0_wp)

contains

   !> The period of a simulation that comes nearest to a motion of a pattern without rest.
   subroutine simulate_return(pattern, mirrored, c, start, motion, progress)
      !> Sides of the impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> Whether the mirror image of a motion is a motion as well.
      logical, intent(in) :: mirrored
      !> r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> Number of the initial state, as in `state_start`.
      integer, intent(in) :: start
      !> Guess of x_i/D and theta_i of all impacts (2N); empty if no period has these sides.
      real(wp), allocatable, intent(out) :: motion(:)
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> Periods simulated between two looks, number of looks, and most events for each period, over
      !! the impacts that it should have.
      integer, parameter :: between = 15, looks = 4, most_events = 8
      !> Largest change of x/D and phase (rad) over a period, and the one below which the simulation
      !! has settled.
      real(wp), parameter :: near = 0.3_wp, settled = 1.0e-4_wp
      type(forced_system_type) :: system
      type(state_type) :: state
      type(event_type), allocatable :: events(:)
      real(wp) :: change, least
      integer :: events_left, i, m, n, sign, status, look

      allocate (motion(0))
      m = size(pattern%sides)
      system = new_forced_system(oscillator_type(c(by_xi), c(by_mu), c([by_right, by_left])), &
         c(by_r), 1.0_wp, exp(c(by_clearance)))
      state = initial_state(system, state_start(system%osc, system%r, system%load, &
         system%clearance, start))
      allocate (events(most_events*between*m))
      least = near
      do look = 1, looks
         events_left = size(events)
         call simulate_cycles(system, state, between*pattern%cycles, events_left, events, n, &
            status, progress)
         do i = 1, n - m
            change = abs(total_phase(events(i + m)) - total_phase(events(i)) &
               - two_pi*pattern%cycles) + abs(events(i + m)%x - events(i)%x)/system%clearance
            if (.not. change < least) cycle
            if (any(events(i:i + m)%kind /= impact_event)) cycle
            sign = events(i)%side*pattern%sides(1)
            if (sign < 0 .and. .not. mirrored) cycle
            if (any(sign*events(i:i + m - 1)%side /= pattern%sides)) cycle
            if (events(i + m)%side /= events(i)%side) cycle
            least = change
            motion = [sign*events(i:i + m - 1)%x/system%clearance, &
               total_phase(events(i:i + m - 1)) - system%lag + merge(0.5_wp*two_pi, 0.0_wp, &
               sign < 0)]
         end do
         if (least < settled .or. status /= stat%ok) return
         if (has_settled(events(:n), settled*system%clearance)) return
      end do
   end subroutine simulate_return

   !> Whether the last event of a simulation repeats an earlier one.
   pure logical function has_settled(events, distance)
      !> (n) Events in the order of time.
      type(event_type), intent(in) :: events(:)
      !> Largest difference of positions.
      real(wp), intent(in) :: distance
      !> Largest difference of phases (rad), and number of earlier events examined.
      real(wp), parameter :: same = 1.0e-4_wp
      integer, parameter :: most = 24
      integer :: i, n

      n = size(events)
      has_settled = n == 0
      do i = max(1, n - most), n - 1
         has_settled = abs(events(i)%x - events(n)%x) < distance .and. abs(events(i)%phase &
            - events(n)%phase) < same .and. events(i)%side == events(n)%side
         if (has_settled) return
      end do
   end function has_settled

end module vi_seeds
