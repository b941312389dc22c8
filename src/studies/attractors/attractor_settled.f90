!> The motion on which a simulation of the oscillator settles: last impacts, period if any, extreme
!! positions.
module vi_attractor_settled
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_attractor_known, only: is_free, known_type, shortest_period
   use vi_forced_system, only: forced_system_type, event_type, impact_event, state_time, &
      state_type, stick_event
   use vi_event_symbols, only: symbol_endings
   use vi_kinds, only: wp
   use vi_simulate, only: simulate_on
   use vi_simulated_motion, only: cell_type, examination_type
   use vi_status, only: stat
   use vi_trajectory, only: extreme_positions, later, store_events
   implicit none (type, external)
   private

   public :: advance, segments_between, settle_on

   !> Events kept of a simulation: room at first, and the most.
   integer, parameter :: capacity = 4096, most_events = 262144
   !> States one period apart count as the same within this share of the clearance.
   real(wp), parameter :: same = 1.0e-5_wp

contains

   !> Simulates the transient, and examines the load cycles after it.
   subroutine settle_on(system, state, how, cell, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: state at the start. Out: state at the end, or after the transient where it fails.
      type(state_type), intent(inout) :: state
      !> How it is examined.
      type(examination_type), intent(in) :: how
      !> In: empty. Out: what was found.
      type(cell_type), intent(inout) :: cell
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(event_type), allocatable :: events(:)
      type(state_type) :: begin, last(0:how%keep)
      integer :: first(0:how%keep), i, left, n

      allocate (events(capacity))
      left = how%max_events
      state%cycle = 0
      last(0) = state
      ! states are compared at a phase unrelated to that of the start, which may be an impact
      call advance(system, state, last(0), how%settling + 0.6180339887_wp, events, n, left, &
         cell%status, progress)
      first = 1
      do i = 1, how%keep
         if (cell%status /= stat%ok) exit
         begin = state
         do
            last(i) = last(i - 1)
            call advance(system, state, last(i), 1.0_wp, events(first(i - 1):), n, left, &
               cell%status, progress)
            if (cell%status /= stat%more_events .or. size(events) >= most_events) exit
            call enlarge(events)
            left = left + n
            state = begin
         end do
         first(i) = first(i - 1) + n
      end do
      state = last(0)
      if (cell%status /= stat%ok) return
      n = first(how%keep) - 1
      call find_period(system, last, events(:n), first, cell%cycles)
      call keep_impacts(events(:n), system%r, how%points, cell)
      i = how%keep - merge(cell%cycles, how%keep, cell%cycles > 0)
      associate (period => events(first(i):n), final => last(how%keep))
         cell%impacts = count(period%kind == impact_event)
         cell%rests = count(period%kind == stick_event)
         cell%symbols = count(symbol_endings(period, .true.) /= 0)
         cell%strobes = reshape([final%phase/system%r, final%x, final%x_dot, final%z, &
            final%z_dot], [5, 1])
         call find_extremes(system, last(i), final, period, cell)
         if (cell%status == stat%ok) state = final
      end associate
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
   !! nearly repeats itself, but is not stable.
   pure subroutine find_period(system, last, events, first, cycles)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> (0:keep) The states a load cycle apart.
      type(state_type), intent(in) :: last(0:)
      !> The events between the first and the last of these states.
      type(event_type), intent(in) :: events(:)
      !> (0:keep) The number of the first event after each state.
      integer, intent(in) :: first(0:)
      !> Load cycles of the period; 0 if none is confirmed.
      integer, intent(out) :: cycles
      integer :: k, keep, n, period, symbols, times

      cycles = 0
      keep = ubound(last, 1)
      do k = 1, (keep - 1)/2
         if (alike(last(keep), last(keep - k), system%clearance) .and. alike(last(keep - k), &
            last(keep - 2*k), system%clearance)) exit
      end do
      if (2*k > keep - 1) return
      if (first(keep) == first(keep - k)) then
         if (is_free(system, last(keep))) cycles = 1
         return
      end if
      do times = 1, 2
         if (2*k*times > keep - 1) return
         call confirm(system, last(keep), k*times, period, symbols)
         if (period == 0) cycle
         ! the simulation may still touch a wall more or less often than the motion
         n = count(symbol_endings(events(first(keep - period):), .true.) /= 0)
         cycles = merge(period, 0, n == symbols)
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

   !> Extreme positions of the primary mass between two states.
   pure subroutine find_extremes(system, begin, finish, events, cell)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The states at both ends.
      type(state_type), intent(in) :: begin, finish
      !> The events in between.
      type(event_type), intent(in) :: events(:)
      !> Out: least and greatest x; status `stat%budget` if a search ran out of steps.
      type(cell_type), intent(inout) :: cell
      ! there may be too many events for a stack
      real(wp), allocatable :: starts(:, :)
      integer, allocatable :: resting(:)
      logical :: complete

      allocate (starts(6, 0:size(events)), resting(0:size(events)))
      call segments_between(system, begin, events, starts, resting)
      call extreme_positions(system, starts, resting, &
         state_time(finish%cycle, finish%phase, system%r), cell%extent(1, 1), &
         cell%extent(1, 2), complete)
      if (.not. complete) cell%status = stat%budget
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

   !> Keeps the first impacts.
   pure subroutine keep_impacts(events, r, points, cell)
      !> The events that were examined.
      type(event_type), intent(in) :: events(:)
      !> Frequency ratio.
      real(wp), intent(in) :: r
      !> Most impacts that are kept.
      integer, intent(in) :: points
      !> Out: with the impacts.
      type(cell_type), intent(inout) :: cell
      type(event_type), allocatable :: impacts(:)
      integer, allocatable :: labels(:, :)

      if (points == 0) return
      impacts = pack(events, events%kind == impact_event)
      associate (n => min(size(impacts), points))
         deallocate (cell%hits)
         allocate (cell%hits(7, n), labels(2, n))
         call store_events(impacts(:n), r, cell%hits, labels)
      end associate
      cell%gaps = labels(2, :)
   end subroutine keep_impacts

end module vi_attractor_settled
