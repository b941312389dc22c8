!> Simulations as plain arrays: states, events, and the time history between them.
module vi_trajectory
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_forced_system, only: initial_state
   use vi_extrema, only: relative_extrema
   use vi_flight, only: flight_position, flight_type, new_flight
   use vi_kinds, only: two_pi, wp
   use vi_oscillation, only: derivatives, oscillation_type
   use vi_oscillator, only: left, right
   use vi_rest, only: new_rest
   use vi_simulate, only: forced_system_type, event_type, simulate, simulate_on, state_time, &
      state_type
   use vi_status, only: stat
   use vi_progress, only: add_expected_work, add_done_work
   implicit none (type, external)
   private

   public :: simulate_case, simulate_arrays, sample_segments, extreme_positions, primary_segment, &
      read_events, store_events, pack_state, unpack_state, initial_state, later

   !> Units of work of a whole simulation in the progress counters.
   integer, parameter :: simulation_work = 1000

contains

   !> As `simulate`, from and to arrays.
   !!
   !! A column of `table` is the record of an event: time, four words of `names`, phase, x, x'
   !! before and after, z' before and after.
   pure subroutine simulate_arrays(system, state, contact, last_cycle, last_phase, names, table, &
      n, final_state, final_contact, status)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> (7) as in `pack_state`. In: the initial state. Out: where the last flight or rest began.
      real(wp), intent(inout) :: state(:)
      !> (3) as in `pack_state`. In and out like `state`.
      integer, intent(inout) :: contact(:)
      !> The end: whole load cycles, and the load phase beyond them (rad).
      real(wp), intent(in) :: last_cycle, last_phase
      !> (4, right and left, kind) Four words that the records have for each wall and kind of event;
      !! they are only copied.
      real(wp), intent(in) :: names(4, 2, 3)
      !> (11, capacity) Out: columns 1 to n are the records; the others keep their values.
      real(wp), intent(inout), contiguous :: table(:, :)
      !> Number of events found.
      integer, intent(out) :: n
      !> (7) as in `pack_state`: the state at the end.
      real(wp), intent(out) :: final_state(:)
      !> (3) as in `pack_state`: the state at the end.
      integer, intent(out) :: final_contact(:)
      !> `stat%ok`, `stat%more_events` if the table is full, or `stat%budget`.
      integer, intent(out) :: status
      integer, parameter :: block = 128
      type(state_type) :: now, final
      type(event_type) :: events(block)
      integer :: i, found

      now = unpack_state(state, contact)
      n = 0
      do
         call simulate(system, now, int(last_cycle, int64), last_phase, &
            events(:min(block, size(table, 2) - n)), found, final, status)
         do i = 1, found
            associate (e => events(i), record => table(:, n + i))
               record(1) = state_time(e%cycle, e%phase, system%r)
               record(2:5) = names(:, merge(right, left, e%side > 0), e%kind)
               record(6:11) = [e%phase, e%x, e%x_dot_before, e%x_dot_after, e%z_dot_before, &
                  e%z_dot_after]
            end associate
         end do
         n = n + found
         if (status /= stat%more_events .or. n == size(table, 2)) exit
      end do
      call pack_state(now, state, contact)
      call pack_state(final, final_state, final_contact)
   end subroutine simulate_arrays

   !> A whole simulation: the discarded cycles, then those that are kept.
   subroutine simulate_case(system, start, duration, discard, max_events, moments, events, &
      status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> t (1/omega), x, x', z, z'.
      real(wp), intent(in) :: start(5)
      !> Load cycles kept and, before them, discarded.
      real(wp), intent(in) :: duration, discard
      !> Largest number of events in the discarded cycles, and again in those that are kept.
      integer, intent(in) :: max_events
      !> The state from which the kept cycles are counted, the state where its flight or rest began,
      !! and the same two states for the end.
      type(state_type), intent(out) :: moments(4)
      !> The events of the cycles that are kept.
      type(event_type), allocatable, intent(out) :: events(:)
      !> `stat%ok`, `stat%more_events` (max_events was reached), `stat%budget`, `stat%no_memory`, or
      !! `stat%not_computed` (stopped by the caller; the final state and the events so far are
      !! those of the simulation).
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; a simulation that is stopped ends early.
      integer, intent(inout), optional :: progress(3)
      type(state_type) :: state, final
      integer :: first

      call add_expected_work(simulation_work, progress)
      first = 0
      if (discard > 0) first = int(simulation_work*(discard/(discard + duration)))
      state = initial_state(system, start)
      final = state
      allocate (events(0))
      status = stat%ok
      if (discard > 0) call gather(system, state, final, discard, max_events, .false., events, &
         status, first, progress)
      moments = [final, state, final, state]
      if (status /= stat%ok) return
      call gather(system, state, final, duration, max_events, .true., events, status, &
         simulation_work - first, progress)
      moments(3:) = [final, state]
   end subroutine simulate_case

   !> Simulates some cycles in chunks and appends the events, if they are kept.
   subroutine gather(system, state, final, cycles, max_events, keep, events, status, work, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: the state where the last flight or rest began, and the state from which the cycles are
      !! counted. Out: the same at the end.
      type(state_type), intent(inout) :: state, final
      !> Load cycles to simulate.
      real(wp), intent(in) :: cycles
      !> Events after which the simulation ends.
      integer, intent(in) :: max_events
      !> Whether the events are appended.
      logical, intent(in) :: keep
      !> In and out: the list of events.
      type(event_type), allocatable, intent(inout) :: events(:)
      !> `stat%ok`, `stat%more_events`, `stat%budget`, `stat%no_memory`, or `stat%not_computed`
      !! (stopped by the caller).
      integer, intent(out) :: status
      !> Units of work of these cycles in the progress counters.
      integer, intent(in) :: work
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      ! largest numbers of events and of load cycles between two reports of progress
      integer, parameter :: chunk = 4096
      integer(int64), parameter :: span = 100000_int64
      type(event_type), allocatable :: chunk_events(:)
      integer(int64) :: last_cycle, first_cycle, cycle
      real(wp) :: last_phase, phase
      logical :: last, good
      integer :: n, kept, left, reported, now

      call later(final, cycles, last_cycle, last_phase)
      left = max_events
      kept = 0
      good = .true.
      allocate (chunk_events(chunk))
      reported = 0
      first_cycle = final%cycle
      do
         last = last_cycle - final%cycle <= span
         cycle = merge(last_cycle, final%cycle + span, last)
         phase = merge(last_phase, final%phase, last)
         call simulate_on(system, state, cycle, phase, chunk_events, n, final, left, status, &
            progress)
         if (keep) call append_events(chunk_events(:n), events, kept, good)
         if (.not. good) exit
         last = last .and. status == stat%ok
         now = merge(work, int(work*((final%cycle - first_cycle)/cycles)), last)
         call add_done_work(now - reported, progress)
         reported = now
         if (last .or. .not. any(status == [stat%ok, stat%more_events])) exit
      end do
      if (status == stat%event_limit) status = stat%more_events
      if (good) call shorten_events(kept, events, good)
      if (.not. good) status = stat%no_memory
   end subroutine gather

   !> Appends events to a list with room for more, which grows by doubling.
   pure subroutine append_events(new, events, n, good)
      !> The events to append.
      type(event_type), intent(in) :: new(:)
      !> In and out: the list; its elements 1 to n are used.
      type(event_type), allocatable, intent(inout) :: events(:)
      !> In and out: number of elements used.
      integer, intent(inout) :: n
      !> False if there is not enough memory; nothing is appended then.
      logical, intent(out) :: good
      type(event_type), allocatable :: longer(:)
      integer :: failed

      good = .true.
      if (n + size(new) > size(events)) then
         allocate (longer(max(2*n, n + size(new))), stat=failed)
         good = failed == 0
         if (.not. good) return
         longer(:n) = events(:n)
         call move_alloc(longer, events)
      end if
      events(n + 1:n + size(new)) = new
      n = n + size(new)
   end subroutine append_events

   !> Removes the elements of a list that are not used.
   pure subroutine shorten_events(n, events, good)
      !> Number of elements used.
      integer, intent(in) :: n
      !> In and out: the list.
      type(event_type), allocatable, intent(inout) :: events(:)
      !> False if there is not enough memory; the list is not changed then.
      logical, intent(out) :: good
      type(event_type), allocatable :: shorter(:)
      integer :: failed

      good = .true.
      if (n == size(events)) return
      allocate (shorter(n), stat=failed)
      good = failed == 0
      if (.not. good) return
      shorter = events(:n)
      call move_alloc(shorter, events)
   end subroutine shorten_events

   !> Cycle and phase a number of load cycles after a state.
   pure subroutine later(state, cycles, cycle, phase)
      !> The state.
      type(state_type), intent(in) :: state
      !> Load cycles to add, not necessarily whole.
      real(wp), intent(in) :: cycles
      !> Whole load cycles at that time.
      integer(int64), intent(out) :: cycle
      !> Load phase beyond them (rad), in [0, 2 pi).
      real(wp), intent(out) :: phase

      cycle = state%cycle + int(cycles, int64)
      phase = state%phase + two_pi*(cycles - aint(cycles))
      if (phase < two_pi) return
      cycle = cycle + 1
      phase = max(0.0_wp, phase - two_pi)
   end subroutine later

   !> Events as columns of `values` and `labels`.
   pure subroutine store_events(events, r, values, labels)
      !> (n) The events.
      type(event_type), intent(in) :: events(:)
      !> Frequency ratio.
      real(wp), intent(in) :: r
      !> (7, at least n) Out: time (1/omega), load phase (rad), x, x' before and after, z' before
      !! and after.
      real(wp), intent(inout) :: values(:, :)
      !> (2, at least n) Out: kind and side.
      integer, intent(inout) :: labels(:, :)
      integer :: i

      do i = 1, size(events)
         associate (e => events(i))
            values(:, i) = [state_time(e%cycle, e%phase, r), e%phase, e%x, e%x_dot_before, &
               e%x_dot_after, e%z_dot_before, e%z_dot_after]
            labels(:, i) = [e%kind, e%side]
         end associate
      end do
   end subroutine store_events

   !> The inverse of `store_events`.
   pure subroutine read_events(values, labels, r, events)
      !> (7, n), (2, n) as in `store_events`.
      real(wp), intent(in) :: values(:, :)
      !> As in `values`.
      integer, intent(in) :: labels(:, :)
      !> Frequency ratio.
      real(wp), intent(in) :: r
      !> (n) The events.
      type(event_type), intent(out) :: events(:)
      integer :: i

      do i = 1, size(events)
         associate (v => values(:, i))
            events(i) = event_type(labels(1, i), labels(2, i), nint((r*v(1) - v(2))/two_pi, &
               int64), v(2), v(3), v(4), v(5), v(6), v(7))
         end associate
      end do
   end subroutine read_events

   !> Least and greatest x over segments, from certified extrema.
   pure subroutine extreme_positions(system, starts, resting, last, x_min, x_max, complete)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Start of each segment, as in `sample_segments`.
      real(wp), intent(in) :: starts(:, :)
      !> Wall of the rest in each segment, as in `sample_segments`.
      integer, intent(in) :: resting(:)
      !> Time of the end of the last segment.
      real(wp), intent(in) :: last
      !> Least and greatest position of the primary mass.
      real(wp), intent(out) :: x_min, x_max
      !> False if a search ran out of steps.
      logical, intent(out) :: complete
      real(wp) :: lowest, highest, duration
      logical :: whole
      integer :: i

      x_min = minval(starts(3, :))
      x_max = maxval(starts(3, :))
      complete = .true.
      do i = 1, size(resting)
         duration = last - starts(1, i)
         if (i < size(resting)) duration = starts(1, i + 1) - starts(1, i)
         call relative_extrema(primary_segment(system, starts(:, i), resting(i), duration), &
            lowest, highest, whole)
         complete = complete .and. whole
         x_min = min(x_min, -highest)
         x_max = max(x_max, -lowest)
      end do
   end subroutine extreme_positions

   !> The primary mass in a segment, as a flight whose free mass stays at 0.
   pure function primary_segment(system, start, resting, duration) result(segment)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Start of the segment, as in `sample_segments`.
      real(wp), intent(in) :: start(:)
      !> The wall of a rest, as in `sample_segments`.
      integer, intent(in) :: resting
      !> Its duration (1/omega).
      real(wp), intent(in) :: duration
      type(flight_type) :: segment

      if (resting /= 0) then
         segment%oscillation_type = new_rest(system%osc%xi, system%osc%mu, system%r, system%load, &
            start(2), start(3), start(4))
         segment%z = 0
         segment%z_dot = 0
         segment%duration = duration
      else
         segment = new_flight(system%osc%xi, system%r, system%amplitude, start(2) - system%lag, &
            start(3), start(4), 0.0_wp, 0.0_wp, duration)
      end if
   end function primary_segment

   !> x, x', z, z', y and load at given times, each from the closed form of its segment.
   !!
   !! A segment begins at an event (or at the start) and lasts until the next; at an event the
   !! velocities are those just after it.
   pure subroutine sample_segments(system, starts, resting, times, values)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> (6, n): time (increasing), phase, x, x', z, z' at the start of each segment.
      real(wp), intent(in) :: starts(:, :)
      !> (n): the side if the free mass rests on that wall during the segment, otherwise 0.
      integer, intent(in) :: resting(:)
      !> (m) Times (1/omega); those before the first segment are extrapolated from it.
      real(wp), intent(in) :: times(:)
      !> (6, m) x, x', z, z', y = z - x, and the load f sin(r t).
      real(wp), intent(out) :: values(:, :)
      type(flight_type) :: flight
      type(oscillation_type) :: rest
      real(wp) :: d(0:5), t, z, z_dot
      integer :: i, j

      do j = 1, size(times)
         i = last_not_after(starts(1, :), times(j))
         t = times(j) - starts(1, i)
         associate (s => starts(:, i))
            if (resting(i) /= 0) then
               rest = new_rest(system%osc%xi, system%osc%mu, system%r, system%load, s(2), s(3), &
                  s(4))
               d = derivatives(rest, t)
               z = d(0) + 0.5_wp*resting(i)*system%clearance
               z_dot = d(1)
            else
               flight = new_flight(system%osc%xi, system%r, system%amplitude, s(2) - system%lag, &
                  s(3), s(4), s(5), s(6), t)
               d = derivatives(flight, t)
               z = flight_position(flight, t)
               z_dot = s(6)
            end if
            values(:, j) = [d(0), d(1), z, z_dot, z - d(0), system%load*sin(s(2) + system%r*t)]
         end associate
      end do
   end subroutine sample_segments

   !> Index of the last element not above a value, at least 1, by bisection.
   pure integer function last_not_after(sorted, value) result(low)
      !> Increasing numbers, and the value.
      real(wp), intent(in) :: sorted(:), value
      integer :: high, middle

      low = 1
      high = size(sorted) + 1
      do while (high - low > 1)
         middle = (low + high)/2
         if (sorted(middle) <= value) then
            low = middle
         else
            high = middle
         end if
      end do
   end function last_not_after

   !> A state as numbers (cycle, phase, x, x', z, z', departure speed) and (side, resting,
   !! released).
   pure subroutine pack_state(state, values, contact)
      !> The state.
      type(state_type), intent(in) :: state
      !> (7) cycle to departure speed
      real(wp), intent(out) :: values(:)
      !> (3) side, resting, released
      integer, intent(out) :: contact(:)

      values = [real(state%cycle, wp), state%phase, state%x, state%x_dot, state%z, state%z_dot, &
         state%speed]
      contact = [state%side, merge(1, 0, state%resting), merge(1, 0, state%released)]
   end subroutine pack_state

   !> The inverse of `pack_state`.
   pure function unpack_state(values, contact) result(state)
      !> (7) as from `pack_state`.
      real(wp), intent(in) :: values(:)
      !> (3) as from `pack_state`.
      integer, intent(in) :: contact(:)
      type(state_type) :: state

      state%cycle = int(values(1), int64)
      state%phase = values(2)
      state%x = values(3)
      state%x_dot = values(4)
      state%z = values(5)
      state%z_dot = values(6)
      state%speed = values(7)
      state%side = contact(1)
      state%resting = contact(2) /= 0
      state%released = contact(3) /= 0
   end function unpack_state

end module vi_trajectory
