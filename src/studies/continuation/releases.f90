!> What simulations at a point show of motions: their last releases, from which motions with rest
!! are found, and the period that comes nearest to a motion of a pattern without rest.
module vi_releases
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_event_symbols, only: last_of_period, period_type, read_periods, total_phase
   use vi_forced_system, only: impact_event, initial_state
   use vi_kinds, only: two_pi, wp
   use vi_oscillator, only: left, right
   use vi_pattern, only: pattern_type
   use vi_rest_family, only: last_release, set_system
   use vi_simulate, only: event_type, forced_system_type, simulate_cycles, &
      simulate_on, state_type
   use vi_starts, only: state_start
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: simulate_releases, simulate_return

   !> Load cycles simulated to find a release.
   integer, parameter :: settling = 60
   !> Largest number of simulations at a point for motions with rest.
   integer, parameter, public :: most_simulations = 6
   !> Largest difference in phase (rad) between the symbols of two successive periods.
   real(wp), parameter :: about = 0.05_wp

   !> The last releases of a simulation, from the right wall and from the left one: load phase and
   !! asinh(v/D) (2, 2), and whether they exist.
   type, public :: release_type
      real(wp) :: at(2, 2) = 0
      logical :: there(2) = .false.
      !> Whether one of them is in the second half of the simulation.
      logical :: late = .false.
      !> The period up to the last release that nearly repeats the previous one: its load cycles, 0
      !! if there is none among the lengths examined, and its symbols.
      integer :: cycles = 0
      integer, allocatable :: symbols(:)
   end type release_type

contains

   !> The last releases of simulations from some initial states; they do not depend on the family.
   subroutine simulate_releases(c, releases, longest, progress, longer)
      !> r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> (simulations) Out: the last releases of each; none if it failed.
      type(release_type), intent(out) :: releases(:)
      !> Symbols and load cycles of the longest period sought at the end; none is sought if absent.
      integer, intent(in), optional :: longest(2)
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> Factor of the load cycles simulated; 1 by default.
      integer, intent(in), optional :: longer
      integer, parameter :: chunk = 4000
      type(forced_system_type) :: system
      type(state_type) :: state, final
      type(event_type), allocatable :: events(:)
      integer :: k, n, part, parts, status, events_left

      parts = 1
      if (present(longer)) parts = longer
      call set_system(c, .true., system)
      allocate (events(chunk))
      do k = 1, size(releases)
         state = initial_state(system, state_start(system%osc, system%r, system%load, &
            system%clearance, k))
         events_left = 10*chunk
         do part = 1, parts
            status = stat%more_events
            do while (status == stat%more_events)
               call simulate_on(system, state, int(part*settling, int64), 0.0_wp, events, n, &
                  final, events_left, status, progress)
            end do
            ! where accumulations are long, the limit of events is reached after fewer load cycles
            if (.not. any(status == [stat%ok, stat%event_limit])) then
               releases(k)%there = .false.
               exit
            end if
            call note_release(1, events(:n), system%clearance, releases(k)%at(:, right), &
               releases(k)%there(right))
            call note_release(-1, events(:n), system%clearance, releases(k)%at(:, left), &
               releases(k)%there(left))
            if (status == stat%event_limit .or. part == parts) exit
            if (repeats_itself(system, events(:n))) exit
         end do
         if (present(longest) .and. any(status == [stat%ok, stat%event_limit])) call read_end( &
            events(:n), longest, releases(k))
      end do
   end subroutine simulate_releases

   !> The last release from a wall, unless a part of a simulation has none.
   pure subroutine note_release(side, events, clearance, at, there)
      !> As in `last_release`.
      integer, intent(in) :: side
      type(event_type), intent(in) :: events(:)
      real(wp), intent(in) :: clearance
      !> In: the last release of the parts before, if there is one. Out: of this part, too.
      real(wp), intent(inout) :: at(2)
      logical, intent(inout) :: there
      real(wp) :: later(2)
      logical :: found

      call last_release(side, events, clearance, later, found)
      if (found) at = later
      there = there .or. found
   end subroutine note_release

   !> Whether the state at the last event of a simulation repeats an earlier one, so that nothing
   !! else follows. With little damping it has to do so more exactly.
   pure logical function repeats_itself(system, events) result(repeats)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> (n) Events in the order of time.
      type(event_type), intent(in) :: events(:)
      !> Largest difference of a phase (rad), of positions over D and of velocities over D omega.
      real(wp), parameter :: same = 1.0e-7_wp
      real(wp) :: limit
      integer :: i

      repeats = .false.
      if (size(events) == 0) return
      limit = same*min(1.0_wp, 100*system%osc%xi)
      associate (last => events(size(events)), d => system%clearance)
         do i = size(events) - 1, 1, -1
            ! impacts of one accumulation are as near to each other
            if (events(i)%cycle == last%cycle) cycle
            repeats = events(i)%kind == last%kind .and. events(i)%side == last%side .and. &
               abs(events(i)%phase - last%phase) < limit .and. abs(events(i)%x - last%x) < limit*d &
               .and. abs(events(i)%x_dot_after - last%x_dot_after) < limit*d .and. &
               abs(events(i)%z_dot_after - last%z_dot_after) < limit*d
            if (repeats) return
         end do
      end associate
   end function repeats_itself

   !> The period up to the last release that nearly repeats the previous one.
   pure subroutine read_end(events, longest, release)
      !> (n) Last events of a simulation, in the order of time.
      type(event_type), intent(in) :: events(:)
      !> Largest number of symbols, and of load cycles.
      integer, intent(in) :: longest(2)
      !> In: with its releases. Out: `late`, `cycles` and `symbols` are set.
      type(release_type), intent(inout) :: release
      type(period_type), allocatable :: periods(:)

      if (.not. any(release%there)) return
      release%late = 2*events(last_of_period(events))%cycle >= settling
      call read_periods(events, longest(2), longest(1), about, periods)
      if (size(periods) == 0) return
      associate (period => periods(size(periods)))
         ! a period without rest does not belong to the motion of the release
         if (all(abs(period%reading%symbols) == 1)) return
         release%cycles = period%cycles
         release%symbols = period%reading%symbols
      end associate
   end subroutine read_end

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
      call set_system(c, .true., system)
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
         ! it settles on the period kept, or on a motion with other sides
         if (has_settled(events(:n), system%clearance)) return
      end do
   end subroutine simulate_return

   !> Whether the last event of a simulation nearly repeats an earlier one.
   pure logical function has_settled(events, clearance)
      !> (n) Events in the order of time.
      type(event_type), intent(in) :: events(:)
      !> The clearance.
      real(wp), intent(in) :: clearance
      !> Largest difference of x/D and of phases (rad), and number of earlier events examined.
      real(wp), parameter :: same = 1.0e-2_wp
      integer, parameter :: most = 24
      integer :: i, n

      n = size(events)
      has_settled = n == 0
      do i = max(1, n - most), n - 1
         has_settled = abs(events(i)%x - events(n)%x) < same*clearance .and. abs(events(i)%phase &
            - events(n)%phase) < same .and. events(i)%side == events(n)%side
         if (has_settled) return
      end do
   end function has_settled

end module vi_releases
