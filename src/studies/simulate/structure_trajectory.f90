!> Trajectories of structures, from and to arrays.
module vi_structure_trajectory
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   use vi_modes, only: advance
   use vi_processor, only: has_memory
   use vi_progress, only: add_expected_work, is_stopped, report_share
   use vi_status, only: stat
   use vi_structure_map, only: accelerations
   use vi_structure_record, only: advance_recorded, set_forces
   use vi_structure, only: find_narrow, load_type, regime_type, state_of, structure_type, to_pairs
   use vi_structure_run, only: find_regime, impact_event, new_run, pass_label, release_event, &
      run_event_type, run_state_type, run_type, simulate_structure, start_at, state_now, &
      stick_event, time_of, whole_periods
   implicit none (type, external)
   private

   public :: closed_at_start, complete_rests, find_parts, find_start, resting_at_start, &
      sample_structure_arrays, simulate_structure_arrays, simulate_structure_case, start_run

   !> Events between two looks at the progress counters.
   integer, parameter :: chunk = 256
   !> Units of work of a whole simulation in the progress counters.
   integer, parameter :: simulation_work = 1000

contains

   !> Simulates a structure from a state to a final time, or until there are too many events.
   pure subroutine simulate_structure_arrays(structure, load, start, q, rate, last, table, labels, &
      n, end_state, end_time, status, first, first_state, resting)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> Time, coordinates (n) and velocities (n) at the start; time at the end.
      real(wp), intent(in) :: start, q(:), rate(:), last
      !> (3 + 2n, capacity) Out: time, approach speed and impulse of each event, and coordinates and
      !! velocities just after it.
      real(wp), intent(inout) :: table(:, :)
      !> (2, capacity) Out: kind and gap of each.
      integer, intent(inout) :: labels(:, :)
      !> Number of events.
      integer, intent(out) :: n
      !> (2n) Coordinates and velocities at the end, or just after the last event if the table is
      !! full; the time there.
      real(wp), contiguous, intent(out) :: end_state(:)
      real(wp), intent(out) :: end_time
      !> `stat%ok`, `stat%narrow_gap`, or as in `start_at` and `simulate_structure`;
      !! `stat%event_limit` where there are more events before `first` than the table has columns.
      integer, intent(out) :: status
      !> Time from which events are kept, `start` if it is left out; (2n) coordinates and velocities
      !! there; (gaps) whether each gap rests from then on to the end.
      real(wp), intent(in), optional :: first
      real(wp), contiguous, intent(out), optional :: first_state(:)
      integer, intent(out), optional :: resting(:)
      type(run_type) :: run
      type(run_state_type) :: state
      type(run_event_type), allocatable :: events(:)
      integer(int64) :: last_cycle
      integer, allocatable :: begun(:)
      real(wp) :: last_elapsed
      integer :: i, left, m

      n = 0
      m = size(q)
      end_state = [q, rate]
      end_time = start
      if (present(first_state)) first_state = end_state
      if (present(resting)) resting = 0
      call new_run(structure, load, run, status)
      if (status /= stat%ok) return
      call start_run(run, start, q, rate, state, status)
      if (status /= stat%ok) return
      allocate (events(chunk))
      if (present(first)) then
         left = size(labels, 2)
         do while (first > start)
            call pass_events(run, state, first, left, events, status)
            if (status /= stat%more_events) exit
         end do
         end_time = real(state%cycle, wp)*run%period + state%elapsed
         ! what is given is kept to the last digit
         if (first > start) call state_now(run, state, end_state(:m), end_state(m + 1:))
         if (status /= stat%ok) return
         end_time = first
      end if
      if (present(first_state)) first_state = end_state
      begun = run%regimes(state%regime)%resting
      call find_parts(run, last, last_cycle, last_elapsed)
      do
         call simulate_structure(run, state, last_cycle, last_elapsed, &
            events(:min(chunk, size(labels, 2) - n)), i, status)
         call store(run, events(:i), table(:, n + 1:n + i), labels(:, n + 1:n + i))
         n = n + i
         if (status /= stat%more_events .or. n == size(labels, 2)) exit
      end do
      call state_now(run, state, end_state(:m), end_state(m + 1:))
      end_time = real(state%cycle, wp)*run%period + state%elapsed
      if (status == stat%ok) end_time = last
      if (present(resting)) resting(without(begun, labels(:, :n))) = 1
   end subroutine simulate_structure_arrays

   !> A state from coordinates and velocities, where no gap is too narrow.
   pure subroutine start_run(run, start, q, rate, state, status)
      !> In and out: the regime of closed gaps is added.
      type(run_type), intent(inout) :: run
      !> Time, coordinates (n) and velocities (n) at the start.
      real(wp), intent(in) :: start, q(:), rate(:)
      !> The state.
      type(run_state_type), intent(out) :: state
      !> `stat%ok`, `stat%narrow_gap`, or as in `start_at`.
      integer, intent(out) :: status
      real(wp) :: least
      integer :: gap

      call start_at(run, start, q, rate, state, status)
      if (status /= stat%ok) return
      call find_narrow(run%structure, run%regimes(1), q, gap, least)
      if (gap > 0) status = stat%narrow_gap
   end subroutine start_run

   !> A time as whole periods and the remainder.
   pure subroutine find_parts(run, time, cycle, elapsed)
      !> The run.
      type(run_type), intent(in) :: run
      !> The time.
      real(wp), intent(in) :: time
      !> Whole periods, and the remainder.
      integer(int64), intent(out) :: cycle
      real(wp), intent(out) :: elapsed

      cycle = whole_periods(run, time)
      elapsed = max(0.0_wp, time - real(cycle, wp)*run%period)
   end subroutine find_parts

   !> Simulates to a time from which events are kept, or some events further.
   pure subroutine pass_events(run, state, first, left, events, status)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> The time.
      real(wp), intent(in) :: first
      !> In and out: events after which the simulation is given up.
      integer, intent(inout) :: left
      !> Room for events.
      type(run_event_type), intent(inout) :: events(:)
      !> `stat%ok` at that time, `stat%more_events` before it, `stat%event_limit` if none is left,
      !! or as in `simulate_structure`.
      integer, intent(out) :: status
      integer(int64) :: cycle
      real(wp) :: elapsed
      integer :: n

      call find_parts(run, first, cycle, elapsed)
      state%bare = .true.
      call simulate_structure(run, state, cycle, elapsed, events(:min(size(events), left)), n, &
         status, .true.)
      state%bare = .false.
      left = left - n
      if (status == stat%more_events .and. left == 0) status = stat%event_limit
   end subroutine pass_events

   !> The members of a set of resting gaps that no event releases.
   pure function without(set, labels) result(rest)
      !> The set; (2, events) kind and gap of each event.
      integer, intent(in) :: set(:), labels(:, :)
      integer, allocatable :: rest(:)
      integer :: i

      rest = pack(set, [(.not. any(labels(1, :) == release_event .and. labels(2, :) == set(i)), &
         i=1, size(set))])
   end function without

   !> As `simulate_structure_arrays`, with arrays that grow, and until it is stopped.
   subroutine simulate_structure_case(structure, load, start, q, rate, last, most, table, labels, &
      n, end_state, end_time, status, progress, first, first_state, resting)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> Time, coordinates (n) and velocities (n) at the start; time at the end.
      real(wp), intent(in) :: start, q(:), rate(:), last
      !> Largest number of events.
      integer, intent(in) :: most
      !> (3 + 2n, at least events) and (2, at least events), as in `simulate_structure_arrays`.
      real(wp), allocatable, intent(out) :: table(:, :)
      !> As in `table`.
      integer, allocatable, intent(out) :: labels(:, :)
      !> Number of events.
      integer, intent(out) :: n
      !> (2n) Coordinates and velocities at the end, or just after the last event if the end is not
      !! reached; the time there.
      real(wp), allocatable, intent(out) :: end_state(:)
      !> As in `end_state`.
      real(wp), intent(out) :: end_time
      !> As of `simulate_structure_arrays`; `stat%no_memory`, or `stat%not_computed` if it was
      !! stopped.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      !> Time from which events are kept, `start` if it is left out; (2n) coordinates and velocities
      !! there; the gaps that rest from then on to the end.
      real(wp), intent(in), optional :: first
      real(wp), allocatable, intent(out), optional :: first_state(:)
      integer, allocatable, intent(out), optional :: resting(:)
      type(run_type) :: run
      type(run_state_type) :: state
      type(run_event_type), allocatable :: events(:)
      integer(int64) :: last_cycle
      integer, allocatable :: begun(:)
      real(wp) :: last_elapsed
      integer :: i, left, m, reported
      logical :: room

      n = 0
      m = size(q)
      reported = 0
      end_state = [q, rate]
      end_time = start
      if (present(first_state)) first_state = end_state
      if (present(resting)) allocate (resting(0))
      allocate (table(3 + 2*m, min(most, chunk)), labels(2, min(most, chunk)))
      call add_expected_work(simulation_work, progress)
      call new_run(structure, load, run, status)
      if (status /= stat%ok) return
      call start_run(run, start, q, rate, state, status)
      if (status /= stat%ok) return
      allocate (events(chunk))
      if (present(first)) then
         left = most
         do while (first > start)
            call pass_events(run, state, first, left, events, status)
            end_time = real(state%cycle, wp)*run%period + state%elapsed
            if (status /= stat%more_events) exit
            call report_share((end_time - start)/(last - start), simulation_work, reported, &
               progress)
            if (is_stopped(progress)) status = stat%not_computed
            if (status == stat%not_computed) exit
         end do
         ! what is given is kept to the last digit
         if (first > start) call state_now(run, state, end_state(:m), end_state(m + 1:))
         if (present(first_state)) first_state = end_state
         if (status /= stat%ok) return
         end_time = first
      end if
      begun = run%regimes(state%regime)%resting
      call find_parts(run, last, last_cycle, last_elapsed)
      do
         if (n == size(labels, 2)) then
            call lengthen(min(most, 2*n), table, labels, room)
            if (.not. room) status = stat%no_memory
            if (.not. room) return
         end if
         call simulate_structure(run, state, last_cycle, last_elapsed, &
            events(:min(chunk, size(labels, 2) - n)), i, status, .true.)
         call store(run, events(:i), table(:, n + 1:n + i), labels(:, n + 1:n + i))
         n = n + i
         if (status /= stat%more_events .or. n == most) exit
         end_time = real(state%cycle, wp)*run%period + state%elapsed
         if (last > start) call report_share((end_time - start)/(last - start), simulation_work, &
            reported, progress)
         if (is_stopped(progress)) status = stat%not_computed
         if (status == stat%not_computed) exit
      end do
      call report_share(1.0_wp, simulation_work, reported, progress)
      call state_now(run, state, end_state(:m), end_state(m + 1:))
      end_time = real(state%cycle, wp)*run%period + state%elapsed
      if (status == stat%ok) end_time = last
      if (present(resting)) resting = without(begun, labels(:, :n))
   end subroutine simulate_structure_case

   !> Makes room for more events.
   subroutine lengthen(n, table, labels, room)
      !> New number of columns.
      integer, intent(in) :: n
      !> In and out: the arrays.
      real(wp), allocatable, intent(inout) :: table(:, :)
      !> As in `table`.
      integer, allocatable, intent(inout) :: labels(:, :)
      !> Whether there is room.
      logical, intent(out) :: room
      real(wp), allocatable :: longer(:, :)
      integer, allocatable :: more(:, :)
      integer :: old

      old = size(labels, 2)
      room = has_memory((8.0_wp*size(table, 1) + 8)*n)
      if (.not. room) return
      allocate (longer(size(table, 1), n), more(2, n))
      longer(:, :old) = table
      more(:, :old) = labels
      call move_alloc(longer, table)
      call move_alloc(more, labels)
   end subroutine lengthen

   !> Writes events into arrays.
   pure subroutine store(run, events, table, labels)
      !> The run.
      type(run_type), intent(in) :: run
      !> The events.
      type(run_event_type), intent(in) :: events(:)
      !> As in `simulate_structure_arrays`.
      real(wp), intent(inout) :: table(:, :)
      !> As in `simulate_structure_arrays`.
      integer, intent(inout) :: labels(:, :)
      integer :: i, n

      n = (size(table, 1) - 3)/2
      do i = 1, size(events)
         table(:3, i) = [time_of(run, events(i)), events(i)%speed, events(i)%impulse]
         table(4:3 + n, i) = events(i)%q
         table(4 + n:, i) = events(i)%rate
         labels(:, i) = [events(i)%kind, events(i)%gap]
      end do
   end subroutine store

   !> Coordinates, velocities and, if wanted, accelerations of a trajectory at given times.
   pure subroutine sample_structure_arrays(structure, load, starts, labels, times, values, status)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> (1 + 2n, segments) Time, coordinates and velocities at which segments begin: the start, and
      !! after each event.
      real(wp), intent(in) :: starts(:, :)
      !> (2, segments) Kind and gap of the event; 0 for the start.
      integer, intent(in) :: labels(:, :)
      !> Times in ascending order, none before the first segment.
      real(wp), intent(in) :: times(:)
      !> (2n or 3n, times) Coordinates, velocities and accelerations, just after an event.
      real(wp), contiguous, intent(out) :: values(:, :)
      !> `stat%ok`, or as in `new_regime` and `start_at`.
      integer, intent(out) :: status
      type(run_type) :: run
      integer, allocatable :: closed(:)
      type(run_state_type) :: state
      integer :: i, j, n, number
      logical :: fresh

      n = size(structure%mass, 1)
      values = 0
      call new_run(structure, load, run, status)
      if (status /= stat%ok) return
      call find_start(run, starts(:, 1), number, status)
      if (status /= stat%ok) return
      j = 1
      closed = run%regimes(number)%closed
      fresh = .true.
      do i = 1, size(times)
         do while (j < size(starts, 2))
            if (starts(1, j + 1) > times(i)) exit
            j = j + 1
            call pass_label(labels(:, j), closed)
            call find_regime(run, closed, number, status)
            if (status /= stat%ok) return
            fresh = .true.
         end do
         if (load%step > 0) then
            if (fresh) call start_segment(run, number, starts(:, j), state)
            fresh = .false.
            call sample_recorded(run, state, times(i), values(:, i))
            cycle
         end if
         call sample_one(run, number, starts(:, j), times(i), values(:, i))
      end do
   end subroutine sample_structure_arrays

   !> The regime in which a trajectory starts: gaps may be at rest from the start. In a motion that
   !! is not admissible they may be negative.
   pure subroutine find_start(run, start, number, status)
      !> In and out: the regime of closed gaps is added.
      type(run_type), intent(inout) :: run
      !> (1 + 2n) Time, coordinates and velocities.
      real(wp), intent(in) :: start(:)
      !> Its number.
      integer, intent(out) :: number
      !> `stat%ok`, or as in `start_at`.
      integer, intent(out) :: status
      type(run_state_type) :: first
      integer :: n

      n = (size(start) - 1)/2
      call start_at(run, start(1), start(2:n + 1), start(n + 2:), first, status)
      if (status == stat%gap_closed) status = stat%ok
      number = first%regime
   end subroutine find_start

   !> The gaps that rest from the start of a trajectory.
   pure subroutine resting_at_start(structure, load, start, rests, status)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> (1 + 2n) Time, coordinates and velocities.
      real(wp), intent(in) :: start(:)
      !> (gaps) Whether each rests.
      logical, intent(out) :: rests(:)
      !> `stat%ok`, or as in `new_regime` and `start_at`.
      integer, intent(out) :: status
      type(run_type) :: run
      integer :: number

      rests = .false.
      call new_run(structure, load, run, status)
      if (status == stat%ok) call find_start(run, start, number, status)
      if (status == stat%ok) rests(run%regimes(number)%resting) = .true.
   end subroutine resting_at_start

   !> What is closed from the start of a trajectory.
   pure subroutine closed_at_start(structure, load, start, closed, status)
      !> As of `resting_at_start`.
      type(structure_type), intent(in) :: structure
      type(load_type), intent(in) :: load
      real(wp), intent(in) :: start(:)
      !> The set, as in `regime_type`.
      integer, allocatable, intent(out) :: closed(:)
      !> As of `resting_at_start`.
      integer, intent(out) :: status
      type(run_type) :: run
      integer :: number

      call new_run(structure, load, run, status)
      if (status == stat%ok) call find_start(run, start, number, status)
      if (status == stat%ok) closed = run%regimes(number)%closed
   end subroutine closed_at_start

   !> Fills in the states at which rests begin and end in a motion of which the impacts are known.
   !!
   !! A rest begins with the last impact of its accumulation, as in a simulation. Nothing is
   !! searched for: unstable motions, and those that pass through a wall, are completed too.
   pure subroutine complete_rests(structure, load, labels, starts, status)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> (2, segments) As in `sample_structure_arrays`; no gap rests at the start.
      integer, intent(in) :: labels(:, :)
      !> (1 + 2n, segments) In: times, and coordinates and velocities at the start and just after
      !! impacts. Out: those where rests begin and end, too.
      real(wp), intent(inout) :: starts(:, :)
      !> `stat%ok`, or as in `new_regime`.
      integer, intent(out) :: status
      type(run_type) :: run
      integer, allocatable :: resting(:)
      integer :: j, n, before, after

      n = size(structure%mass, 1)
      call new_run(structure, load, run, status)
      if (status /= stat%ok) return
      allocate (resting(0))
      before = 1
      do j = 2, size(starts, 2)
         call pass_label(labels(:, j), resting)
         call find_regime(run, resting, after, status)
         if (status /= stat%ok) return
         if (labels(1, j) == stick_event) then
            if (labels(2, j - 1) == labels(2, j) .and. labels(1, j - 1) == impact_event .or. &
               j == 2) before = after
         end if
         if (labels(1, j) /= impact_event) call sample_one(run, before, starts(:, j - 1), &
            starts(1, j), starts(2:, j))
         before = after
      end do
   end subroutine complete_rests

   !> The state at the beginning of a segment under a record.
   pure subroutine start_segment(run, number, start, state)
      !> The run.
      type(run_type), intent(in) :: run
      !> The regime.
      integer, intent(in) :: number
      !> (1 + 2n) Time, coordinates and velocities.
      real(wp), intent(in) :: start(:)
      !> The state.
      type(run_state_type), intent(out) :: state
      integer :: m, n

      n = size(run%structure%mass, 1)
      m = size(run%regimes(number)%xq, 1)
      state%regime = number
      state%cycle = whole_periods(run, start(1))
      state%elapsed = max(0.0_wp, start(1) - real(state%cycle, wp)*run%period)
      allocate (state%x(m), state%v(m))
      call to_pairs(run%regimes(number), 0.0_wp, start(2:n + 1), start(n + 2:), state%x, state%v)
   end subroutine start_segment

   !> The state at a time under a record.
   pure subroutine sample_recorded(run, state, time, values)
      !> In and out: the run, whose forces are set.
      type(run_type), intent(inout) :: run
      !> In: a state before the time. Out: one at the last sample of the record before it.
      type(run_state_type), intent(inout) :: state
      !> The time.
      real(wp), intent(in) :: time
      !> (2n or 3n) As of `sample_structure_arrays`.
      real(wp), contiguous, intent(out) :: values(:)
      real(wp), dimension(size(state%x)) :: x, v
      real(wp) :: elapsed
      integer(int64) :: cycle

      cycle = whole_periods(run, time)
      elapsed = max(0.0_wp, time - real(cycle, wp)*run%period)
      associate (regime => run%regimes(state%regime))
         if (cycle > state%cycle) then
            call advance_recorded(regime, run%load, state%cycle, state%elapsed, cycle, 0.0_wp, &
               state%x, state%v)
            state%cycle = cycle
            state%elapsed = 0
         end if
         x = state%x
         v = state%v
         call advance_recorded(regime, run%load, cycle, state%elapsed, cycle, elapsed, x, v)
         call set_forces(regime, run%load, cycle, elapsed)
         call values_of(regime, 0.0_wp, x, v, values)
      end associate
   end subroutine sample_recorded

   !> Coordinates, velocities and, if wanted, accelerations from the pairs.
   pure subroutine values_of(regime, phase, x, v, values)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> Load phase (rad).
      real(wp), intent(in) :: phase
      !> (m) The pairs.
      real(wp), contiguous, intent(in) :: x(:), v(:)
      !> (2n or 3n)
      real(wp), contiguous, intent(out) :: values(:)
      integer :: n

      n = size(regime%offset)
      call state_of(regime, phase, x, v, values(:n), values(n + 1:2*n))
      if (size(values) > 2*n) call accelerations(regime, phase, x, v, values(2*n + 1:))
   end subroutine values_of

   !> The state at a time of a segment.
   pure subroutine sample_one(run, number, start, time, values)
      !> The run.
      type(run_type), intent(in) :: run
      !> The regime.
      integer, intent(in) :: number
      !> (1 + 2n) Time, coordinates and velocities at its start.
      real(wp), intent(in) :: start(:)
      !> The time.
      real(wp), intent(in) :: time
      !> (2n or 3n) As of `sample_structure_arrays`.
      real(wp), contiguous, intent(out) :: values(:)
      real(wp), dimension(size(run%regimes(number)%xq, 1)) :: x, v, x_now, v_now
      integer :: n

      n = (size(start) - 1)/2
      associate (regime => run%regimes(number))
         call to_pairs(regime, phase_at(run, start(1)), start(2:n + 1), start(n + 2:), x, v)
         call advance(regime%modes, time - start(1), x, v, x_now, v_now)
         call values_of(regime, phase_at(run, time), x_now, v_now, values)
      end associate
   end subroutine sample_one

   !> The load phase, less whole periods: as of the events, whose times are sums of whole periods
   !! and a remainder. Omega t would lose the digits that these sums keep.
   pure real(wp) function phase_at(run, time) result(phase)
      !> The run.
      type(run_type), intent(in) :: run
      !> The time.
      real(wp), intent(in) :: time

      phase = run%load%frequency*(time - real(whole_periods(run, time), wp)*run%period)
   end function phase_at

end module vi_structure_trajectory
