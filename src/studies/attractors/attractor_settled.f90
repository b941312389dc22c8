!> The motions on which simulations settle: last impacts, period if any, extreme positions.
!!
!! Simulations form chains. Along a chain the parameters change from link to link and the state is
!! carried over, so that a chain is a sweep; chains of one link are independent initial states.
module vi_attractor_settled
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_attractor_known, only: is_free, known_type, shortest_period
   use vi_forced_system, only: forced_system_type, event_type, impact_event, initial_state, &
      new_forced_system, state_time, state_type, stick_event
   use vi_event_symbols, only: symbol_endings
   use vi_kinds, only: wp
   use vi_oscillator, only: oscillator_type
   use vi_simulate, only: simulate_on
   use vi_status, only: stat
   use vi_progress, only: add_expected_work, add_done_work, is_stopped
   use vi_trajectory, only: extreme_positions, later, store_events
   implicit none (type, external)
   private

   public :: advance, segments_between, settle_chains

   !> Events kept of a simulation: room at first, and the most.
   integer, parameter :: capacity = 4096, most_events = 262144
   !> States one period apart count as the same within this share of the clearance.
   real(wp), parameter :: same = 1.0e-5_wp

   !> The end of a simulation.
   type :: settled_type
      !> Load cycles of the period of the motion, 0 if none is confirmed, and minus the cycles after
      !! which the simulation seems to repeat itself if no stable motion is confirmed there;
      !! symbols,
      !! impacts and rests in it, or in all cycles examined.
      integer :: period = 0, symbols = 0, impacts = 0, rests = 0
      real(wp) :: x_min = 0, x_max = 0
      !> Events of the last cycles.
      integer :: n = 0
      type(event_type), allocatable :: events(:)
      integer :: status = stat%ok
   end type settled_type

contains

   !> Chains of simulations; each chain is a separate task.
   subroutine settle_chains(parameters, load, starts, settling, keep, kick, max_events, threads, &
      values, labels, found, periods, extremes, ends, status, progress)
      !> (6, links, chains): r, D, xi, mu, R1, R2
      real(wp), intent(in) :: parameters(:, :, :)
      !> Load amplitude f.
      real(wp), intent(in) :: load
      !> (5, chains): t, x, x', z, z'
      real(wp), intent(in) :: starts(:, :)
      !> Load cycles simulated first, and those that are kept.
      integer, intent(in) :: settling, keep
      !> Added to x' from link to link, over half the clearance, so that a sweep leaves unstable
      !! motions.
      real(wp), intent(in) :: kick
      !> Largest number of events of the simulation of a link, and number of OpenMP threads.
      integer, intent(in) :: max_events, threads
      !> (7, capacity, links, chains): the kept impacts as in `store_events`.
      real(wp), intent(inout) :: values(:, :, :, :)
      !> (2, capacity, links, chains): kind and side of the kept impacts; (links, chains): their
      !! number.
      integer, intent(inout) :: labels(:, :, :, :), found(:, :)
      !> (4, links, chains): load cycles of the period (0 or negative if none is confirmed, see
      !! `settled_type`), symbols, impacts, rests.
      integer, intent(inout) :: periods(:, :, :)
      !> (2, links, chains): least and greatest x; NaN where it was not computed.
      real(wp), intent(inout) :: extremes(:, :, :)
      !> (5, links, chains): states at the end, as `starts`.
      real(wp), intent(inout) :: ends(:, :, :)
      !> (links, chains): codes of vi_status; `stat%not_computed` from the link at which the study
      !! was stopped.
      integer, intent(inout) :: status(:, :)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(settled_type) :: settled
      type(state_type) :: state
      type(forced_system_type) :: system
      integer :: i, j

      call add_expected_work(size(parameters, 2)*size(starts, 2), progress)
      status = stat%not_computed
      found = 0
      periods = 0
      extremes = ieee_value(load, ieee_quiet_nan)
      !$omp parallel do schedule(dynamic, 1) num_threads(threads) private(settled, state, system, i)
      do j = 1, size(starts, 2)
         do i = 1, size(parameters, 2)
            if (is_stopped(progress)) exit
            associate (c => parameters(:, i, j))
               system = new_forced_system(oscillator_type(c(3), c(4), c(5:6)), c(1), load, c(2))
            end associate
            if (i == 1) then
               state = initial_state(system, starts(:, j))
            else
               state = carried(system, state, parameters(2, max(1, i - 1), j), kick)
            end if
            call settle_on(system, state, settling, keep, max_events, settled, progress)
            if (settled%status == stat%not_computed) exit
            call store(settled, values(:, :, i, j), labels(:, :, i, j), system%r, found(i, j))
            periods(:, i, j) = [settled%period, settled%symbols, settled%impacts, settled%rests]
            extremes(:, i, j) = [settled%x_min, settled%x_max]
            ends(:, i, j) = [state%phase/system%r, state%x, state%x_dot, state%z, state%z_dot]
            status(i, j) = settled%status
            call add_done_work(1, progress)
         end do
      end do
      !$omp end parallel do
   end subroutine settle_chains

   !> A state with new parameters: the free mass keeps its relative position between the walls.
   pure function carried(system, state, clearance, kick) result(next)
      !> The system with the new parameters.
      type(forced_system_type), intent(in) :: system
      !> The state with the old ones.
      type(state_type), intent(in) :: state
      !> The old clearance.
      real(wp), intent(in) :: clearance
      !> Added to x', over half the clearance.
      real(wp), intent(in) :: kick
      type(state_type) :: next
      real(wp) :: y, half

      half = 0.5_wp*system%clearance
      y = (state%z - state%x)*(system%clearance/clearance)
      if (state%side /= 0) y = state%side*half
      y = max(-half, min(half, y))
      next = initial_state(system, [state%phase/system%r, state%x, state%x_dot + kick*half, &
         state%x + y, state%z_dot + merge(kick*half, 0.0_wp, state%side /= 0)])
   end function carried

   !> Simulates the transient, and examines the load cycles after it. Where it fails, nothing of the
   !! simulation before is left.
   subroutine settle_on(system, state, settling, keep, max_events, settled, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: state at the start. Out: state at the end.
      type(state_type), intent(inout) :: state
      !> Load cycles of the transient, and those examined.
      integer, intent(in) :: settling, keep
      !> Largest number of events of all of them.
      integer, intent(in) :: max_events
      !> Out: the end of the simulation; its arrays are reused.
      type(settled_type), intent(inout) :: settled
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(state_type) :: begin, last(0:keep)
      integer :: n, first(0:keep), i, k
      integer :: left, stored

      if (.not. allocated(settled%events)) allocate (settled%events(capacity))
      settled%period = 0
      settled%symbols = 0
      settled%impacts = 0
      settled%rests = 0
      settled%x_min = ieee_value(settled%x_min, ieee_quiet_nan)
      settled%x_max = settled%x_min
      settled%n = 0
      left = max_events
      state%cycle = 0
      last(0) = state
      ! states are compared at a phase unrelated to that of the start, which may be an impact
      call advance(system, state, last(0), settling + 0.6180339887_wp, settled%events, n, left, &
         settled%status, progress)
      first = 1
      stored = 0
      n = 0
      do i = 1, keep
         if (settled%status /= stat%ok) exit
         begin = state
         do
            last(i) = last(i - 1)
            call advance(system, state, last(i), 1.0_wp, settled%events(first(i - 1):), n, left, &
               settled%status, progress)
            if (settled%status /= stat%more_events .or. size(settled%events) >= most_events) exit
            call enlarge(settled%events)
            left = left + n
            state = begin
         end do
         first(i) = first(i - 1) + n
         stored = stored + n
      end do
      if (settled%status == stat%ok) then
         settled%n = stored
         call find_period(system, last, settled%events(:stored), first, settled)
         k = merge(settled%period, keep, settled%period > 0)
         call read_period(settled, first(keep - k), settled%n)
         call find_extremes(system, last(keep - k), last(keep), &
            settled%events(first(keep - k):settled%n), settled)
      end if
      state = last(merge(keep, 0, settled%status == stat%ok))
   end subroutine settle_on

   !> Doubles the room for events.
   pure subroutine enlarge(events)
      !> In and out: the events.
      type(event_type), allocatable, intent(inout) :: events(:)
      type(event_type), allocatable :: more(:)
      integer :: i

      allocate (more(2*size(events)))
      do i = 1, size(events)
         more(i) = events(i)
      end do
      call move_alloc(more, events)
   end subroutine enlarge

   !> The shortest period of the motion on which a simulation has settled.
   !!
   !! A simulation that approaches a motion slowly, as near a flip, or leaves one that is not stable
   !! nearly repeats itself, possibly only after several periods. Newton's method has to confirm a
   !! stable motion there, and its shortest period counts. Near a flip the shorter period also
   !! nearly
   !! repeats itself, but is not stable.
   pure subroutine find_period(system, last, events, first, settled)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> (0:keep) The states a load cycle apart.
      type(state_type), intent(in) :: last(0:)
      !> The events between the first and the last of these states.
      type(event_type), intent(in) :: events(:)
      !> (0:keep) The number of the first event after each state.
      integer, intent(in) :: first(0:)
      !> In and out: its period is set.
      type(settled_type), intent(inout) :: settled
      integer :: k, keep, period, symbols, times

      keep = ubound(last, 1)
      do k = 1, (keep - 1)/2
         if (alike(last(keep), last(keep - k), system%clearance) .and. alike(last(keep - k), &
            last(keep - 2*k), system%clearance)) exit
      end do
      if (2*k > keep - 1) return
      settled%period = -k
      if (first(keep) == first(keep - k)) then
         if (is_free(system, last(keep))) settled%period = 1
         return
      end if
      do times = 1, 2
         if (2*k*times > keep - 1) return
         call confirm(system, last(keep), k*times, period, symbols)
         if (period == 0) cycle
         ! the simulation may still touch a wall more or less often than the motion
         if (count(symbol_endings(events(first(keep - period):), .true.) /= 0) /= symbols) return
         settled%period = period
         return
      end do
   end subroutine find_period

   !> The shortest period of the stable motion near a state, 0 if there is none, and its symbols.
   pure subroutine confirm(system, state, cycles, period, symbols)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state.
      type(state_type), intent(in) :: state
      !> Load cycles of one or more periods.
      integer, intent(in) :: cycles
      !> Load cycles of the shortest one, and number of its symbols.
      integer, intent(out) :: period, symbols
      type(known_type) :: known
      logical :: good

      period = 0
      symbols = 0
      call shortest_period(system, [state%phase/system%r, state%x, state%x_dot, state%z, &
         state%z_dot], cycles, known, good)
      if (.not. good) return
      period = known%cycles
      symbols = size(known%symbols)
   end subroutine confirm

   !> Simulates some load cycles; the last events are kept as far as there is room.
   subroutine advance(system, state, final, cycles, events, n, left, status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> State at the start of the last flight or rest, and state from which the cycles are counted.
      type(state_type), intent(inout) :: state, final
      !> Load cycles to simulate; a single one ends with the status `stat%more_events` if there is
      !! not enough room.
      real(wp), intent(in) :: cycles
      !> Out: the last n events.
      type(event_type), intent(inout) :: events(:)
      !> Number of events kept.
      integer, intent(out) :: n
      !> As in `simulate_on`.
      integer, intent(inout) :: left
      !> As in `simulate_on`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      integer(int64) :: cycle
      real(wp) :: phase

      call later(final, cycles, cycle, phase)
      do
         call simulate_on(system, state, cycle, phase, events, n, final, left, status, progress)
         if (status /= stat%more_events .or. .not. cycles > 1) exit
      end do
   end subroutine advance

   !> Whether two states at one phase are the same.
   pure logical function alike(a, b, clearance)
      !> The states.
      type(state_type), intent(in) :: a, b
      !> The clearance, unit of the comparison.
      real(wp), intent(in) :: clearance

      alike = maxval(abs([a%x - b%x, a%x_dot - b%x_dot, a%z - b%z, a%z_dot - b%z_dot])) <= &
         same*clearance
   end function alike

   !> Counts symbols, impacts and rests of a period; its first event follows its last one.
   pure subroutine read_period(settled, first, last)
      !> In: with its events. Out: symbols, impacts and rests are set.
      type(settled_type), intent(inout) :: settled
      !> Numbers of the first and last event of the period.
      integer, intent(in) :: first, last

      associate (events => settled%events(first:last))
         settled%impacts = count(events%kind == impact_event)
         settled%rests = count(events%kind == stick_event)
         settled%symbols = count(symbol_endings(events, .true.) /= 0)
      end associate
   end subroutine read_period

   !> Extreme positions of the primary mass between two states.
   pure subroutine find_extremes(system, begin, finish, events, settled)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The states at both ends.
      type(state_type), intent(in) :: begin, finish
      !> The events in between.
      type(event_type), intent(in) :: events(:)
      !> Out: x_min and x_max; status `stat%budget` if a search ran out of steps.
      type(settled_type), intent(inout) :: settled
      ! there may be too many events for a stack
      real(wp), allocatable :: starts(:, :)
      integer, allocatable :: resting(:)
      logical :: complete

      allocate (starts(6, 0:size(events)), resting(0:size(events)))
      call segments_between(system, begin, events, starts, resting)
      call extreme_positions(system, starts, resting, &
         state_time(finish%cycle, finish%phase, system%r), settled%x_min, settled%x_max, complete)
      if (.not. complete) settled%status = stat%budget
   end subroutine find_extremes

   !> Where the segments between events begin.
   pure subroutine segments_between(system, begin, events, starts, resting)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state before the events.
      type(state_type), intent(in) :: begin
      !> (n) The events.
      type(event_type), intent(in) :: events(:)
      !> (6, 0:n) As in `sample_segments`, but z is 0 after an event.
      real(wp), intent(out) :: starts(:, 0:)
      !> (0:n) As in `sample_segments`.
      integer, intent(out) :: resting(0:)
      integer :: i

      starts(:, 0) = [state_time(begin%cycle, begin%phase, system%r), begin%phase, begin%x, &
         begin%x_dot, begin%z, begin%z_dot]
      resting(0) = merge(begin%side, 0, begin%resting)
      do i = 1, size(events)
         associate (e => events(i))
            starts(:, i) = [state_time(e%cycle, e%phase, system%r), e%phase, e%x, e%x_dot_after, &
               0.0_wp, e%z_dot_after]
            resting(i) = merge(e%side, 0, e%kind == stick_event)
         end associate
      end do
   end subroutine segments_between

   !> Stores the kept impacts as columns, as many as there is room for.
   pure subroutine store(settled, values, labels, r, n)
      !> The end of a simulation.
      type(settled_type), intent(in) :: settled
      !> (7, capacity) Out: as in `store_events`.
      real(wp), intent(inout) :: values(:, :)
      !> (2, capacity) Out: as in `store_events`.
      integer, intent(inout) :: labels(:, :)
      !> Frequency ratio.
      real(wp), intent(in) :: r
      !> Number of impacts stored.
      integer, intent(out) :: n
      type(event_type), allocatable :: impacts(:)

      impacts = pack(settled%events(:settled%n), settled%events(:settled%n)%kind == impact_event)
      n = min(size(impacts), size(values, 2))
      call store_events(impacts(:n), r, values(:, :n), labels(:, :n))
   end subroutine store

end module vi_attractor_settled
