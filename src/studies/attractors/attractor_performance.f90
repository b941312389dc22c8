!> How well many systems perform: what a design limits, on the attractor of each initial state.
!!
!! A simulation that almost repeats itself is refined to the nearby periodic motion; the figures are
!! those of the closed form over its period. Where no period is found they are those over the last
!! load cycles.
module vi_attractor_performance
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_attractor_known, only: known_type, shortest_period
   use vi_attractor_settled, only: advance, segments_between
   use vi_attractor_spread, only: placed_state
   use vi_attractor_target, only: over_period, target_state
   use vi_extrema, only: relative_extrema
   use vi_flight, only: flight_type, new_flight
   use vi_forced_system, only: event_type, forced_system_type, impact_event, initial_state, &
      new_forced_system, state_time, state_type
   use vi_kinds, only: two_pi, wp
   use vi_oscillation, only: combination, derivatives, square_integral
   use vi_oscillator, only: oscillator_type
   use vi_progress, only: add_done_work, add_expected_work, is_stopped
   use vi_simulate, only: free_mass_later, simulate, simulate_on, state_after, state_later
   use vi_status, only: stat
   use vi_trajectory, only: later, primary_segment
   implicit none (type, external)
   private

   public :: perform

   !> Rows of the figures: greatest |x|, root mean square of x, greatest |x''| and |x + 2 xi x'|
   !! (acceleration and transmitted force, except the impulses), greatest approach speed, greatest
   !! modulus of the multipliers (NaN without a period or without impacts); the distances to
   !! boundaries: least approach speed, and least distance from a wall that the free mass approaches
   !! without an impact (both inf where there is none, and 0 with rest); amplitude A.
   integer, parameter, public :: displacement = 1, rms = 2, acceleration = 3, force = 4, &
      speed = 5, multiplier = 6, least_speed = 7, least_gap = 8, amplitude = 9, figures = 9

   !> Events kept of a simulation.
   integer, parameter :: capacity = 2048
   !> Load cycles between two looks at the state, and the longest period that is looked for.
   integer, parameter :: chunk = 8, longest = 8
   !> States one period apart are refined to a periodic motion within this share of the clearance.
   real(wp), parameter :: near = 2.0e-3_wp
   !> A run that almost repeats itself is on a known motion within this share of the clearance, as
   !! far as Newton's method may go from a state that has settled.
   real(wp), parameter :: attracted = 1.0e-2_wp
   !> Turns of the free mass within this share of the clearance are one, found twice.
   real(wp), parameter :: same = 1.0e-9_wp
   !> Damping ratio times load cycles after which a transient without impacts is below 1e-4, and the
   !! largest number of load cycles simulated until then.
   real(wp), parameter :: decayed = 1.5_wp
   integer, parameter :: longest_decay = 100000
   !> Runs that a thread takes at once, and motions of a system that it keeps for the next ones.
   integer, parameter :: at_once = 16, most_kept = 4

   !> A motion with the period of the load that an earlier run of the same system has reached. Of
   !! longer periods a run has its own, as the state that it lists depends on when it came there.
   type :: kept_type
      !> A state on it at the phase of the marks.
      type(state_type) :: strobe
      !> Its figures, a state on it, load cycles of its period, and impacts in it.
      real(wp) :: found(figures) = 0, end(5) = 0
      integer :: counts(2) = 0
   end type kept_type

   !> A state noted while a simulation settles. Most are only compared by z, which needs no sine.
   type :: mark_type
      !> Whether `state` is that at the instant noted; else it is the one after the last event
      !! before it.
      logical :: known = .false.
      type(state_type) :: state
      !> The instant: whole load cycles, and the load phase beyond them (rad).
      integer(int64) :: cycle = 0
      real(wp) :: phase = 0
      !> z then (F0/K).
      real(wp) :: z = 0
   end type mark_type

contains

   !> The figures of many systems, each from one initial state.
   !!
   !! Of runs of one system that follow each other, one that comes to the motion of another with the
   !! period of the load takes the figures of that: it is near it twice, a period apart, or less
   !! near it and almost repeats itself. Which runs share figures does not depend on the number of
   !! threads.
   subroutine perform(parameters, places, settling, keep, max_events, threads, found, ends, &
      counts, status, progress, wanted)
      !> (6, n): r, D, xi, mu, R1, R2
      real(wp), intent(in) :: parameters(:, :)
      !> (4, n): initial state, as in `placed_state`
      real(wp), intent(in) :: places(:, :)
      !> Load cycles after which a simulation counts as settled, and those examined then, at least
      !! one.
      integer, intent(in) :: settling, keep
      !> Largest number of events of a simulation, and number of OpenMP threads.
      integer, intent(in) :: max_events, threads
      !> (figures, n): rows as above, with the unit of length F0/K; NaN where it failed, and in rows
      !! that are not wanted.
      real(wp), intent(out) :: found(:, :)
      !> (5, n): t, x, x', z, z' of a state on the attractor; NaN where it failed.
      real(wp), intent(out) :: ends(:, :)
      !> (2, n): load cycles of the period (0 if there is none), and impacts in it or in the cycles
      !! examined.
      integer, intent(out) :: counts(:, :)
      !> (n): codes of vi_status; `stat%not_computed` if it was stopped before.
      integer, intent(out) :: status(:)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      !> (figures): rows that are computed; all by default. Extremes and integrals over chaotic
      !! motions take longer than their simulation.
      logical, intent(in), optional :: wanted(:)
      type(event_type), allocatable :: events(:)
      type(forced_system_type) :: system
      type(kept_type) :: kept(most_kept)
      logical :: begun, rows(figures)
      integer :: j, n

      rows = .true.
      if (present(wanted)) rows = wanted
      call add_expected_work(size(status), progress)
      status = stat%not_computed
      counts = 0
      found = ieee_value(1.0_wp, ieee_quiet_nan)
      ends = found(1, 1)
      !$omp parallel num_threads(threads) private(begun, events, kept, n, system)
      allocate (events(capacity))
      begun = .false.
      n = 0
      !$omp do schedule(dynamic, at_once)
      do j = 1, size(status)
         if (is_stopped(progress)) cycle
         associate (c => parameters(:, j))
            ! the tables of flights depend on r and xi alone
            if (begun) begun = .not. abs(c(1) - system%r) + abs(c(3) - system%osc%xi) > 0
            if (.not. begun) system = new_forced_system(oscillator_type(c(3), c(4), c(5:6)), c(1), &
               1.0_wp, c(2))
            begun = .true.
            system%osc%mu = c(4)
            system%osc%restitution = c(5:6)
            system%clearance = c(2)
            if (modulo(j, at_once) == 1) then
               n = 0
            else if (any(abs(c - parameters(:, j - 1)) > 0)) then
               n = 0
            end if
         end associate
         call perform_one(system, placed_state(system%osc%xi, system%r, system%load, &
            system%clearance, places(:, j)), settling, keep, max_events, rows, events, &
            kept, n, found(:, j), ends(:, j), counts(:, j), status(j), progress)
         found(:, j) = merge(found(:, j), ieee_value(1.0_wp, ieee_quiet_nan), rows)
         call add_done_work(1, progress)
      end do
      !$omp end do
      !$omp end parallel
   end subroutine perform

   !> The figures of one system from one initial state.
   subroutine perform_one(system, start, settling, keep, max_events, wanted, events, kept, &
      motions, found, end, counts, status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> t, x, x', z, z'
      real(wp), intent(in) :: start(5)
      !> As in `perform`.
      integer, intent(in) :: settling, keep, max_events
      !> (figures): rows that are computed.
      logical, intent(in) :: wanted(figures)
      !> Room for events.
      type(event_type), intent(inout) :: events(:)
      !> In and out: periodic motions of the system that are known, and their number.
      type(kept_type), intent(inout) :: kept(most_kept)
      integer, intent(inout) :: motions
      !> Out: as in `perform`.
      real(wp), intent(inout) :: found(:), end(:)
      !> Out: as in `perform`.
      integer, intent(inout) :: counts(:)
      !> Status.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(state_type) :: state, mark
      type(mark_type) :: marks(0:2*longest)
      integer :: i, k, n, left, done, filled
      logical :: good, quiet, repeats

      state = initial_state(system, start)
      state%cycle = 0
      mark = state
      left = max_events
      ! states are compared at a phase unrelated to that of the start, which may be an impact
      call advance(system, state, mark, 0.6180339887_wp, events, n, left, status, progress)
      if (status /= stat%ok) return
      filled = 0
      marks(0) = mark_at(mark)
      done = 0
      quiet = .false.
      ! without impacts only the dashpot ends the transient
      do while (done < settling .or. (quiet .and. done < longest_decay .and. &
         done*system%osc%xi < decayed*system%r))
         call pass_chunk(system, state, mark, marks, events, quiet, left, status, progress)
         if (status /= stat%ok) return
         done = done + chunk
         filled = min(filled + chunk, 2*longest)
         do i = 1, motions
            call find_kept(system, marks(:1), near, kept(i), found, end, counts, good)
            if (good) return
         end do
         do k = 1, filled/2
            call compare(system, marks(0), marks(k), near, repeats)
            if (repeats) call compare(system, marks(k), marks(2*k), near, repeats)
            if (.not. repeats) cycle
            do i = 1, motions
               call find_kept(system, marks(:1), attracted, kept(i), found, end, counts, good)
               if (good) return
            end do
            ! a motion that is approached from both sides in turn looks like one of twice its period
            do i = 1, k
               if (modulo(k, i) /= 0) cycle
               call refine(system, mark, i, wanted, events, found, end, counts, good)
               if (good) call keep_motion(system, mark, found, end, counts, events, kept, motions)
               if (good) return
            end do
            exit
         end do
      end do
      call examine_cycles(system, state, mark, keep, left, wanted, events, found, counts, status, &
         progress)
      if (status == stat%ok) end = numbers_of(system, mark)
   end subroutine perform_one

   !> Passes some load cycles, and notes the state after each.
   !!
   !! A simulation that ends after each cycle would search the flight twice that goes on there. The
   !! states in between follow from the events, as they would have been at an end.
   subroutine pass_chunk(system, state, mark, marks, events, quiet, left, status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In and out: at the start of the last flight or rest before the mark; the mark.
      type(state_type), intent(inout) :: state, mark
      !> In and out: the last marks, the latest first.
      type(mark_type), intent(inout) :: marks(0:)
      !> Room for events.
      type(event_type), intent(inout) :: events(:)
      !> Whether there was no event.
      logical, intent(out) :: quiet
      !> Events that are left.
      integer, intent(inout) :: left
      !> Status.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(state_type) :: begin, here, final
      integer(int64) :: cycle
      real(wp) :: phase
      integer :: i, j, n, before

      before = left
      begin = state
      do i = ubound(marks, 1), chunk, -1
         marks(i) = marks(i - chunk)
      end do
      call later(mark, real(chunk, wp), cycle, phase)
      call simulate_on(system, state, cycle, phase, events, n, final, left, status, progress)
      if (status == stat%ok) then
         quiet = n == 0
         here = begin
         j = 0
         do i = 1, chunk
            call later(mark, real(i, wp), cycle, phase)
            do while (j < n)
               if (events(j + 1)%cycle > cycle .or. (events(j + 1)%cycle == cycle .and. &
                  events(j + 1)%phase > phase)) exit
               j = j + 1
               here = state_after(system, events(j))
            end do
            marks(chunk - i) = mark_after(system, here, cycle, phase)
         end do
         mark = final
         return
      end if
      if (status /= stat%more_events) return
      ! there is room for the events of a cycle, or for the last ones of it
      left = before
      state = begin
      quiet = .true.
      do i = 1, chunk
         call advance(system, state, mark, 1.0_wp, events, n, left, status, progress)
         if (status /= stat%ok) return
         quiet = quiet .and. n == 0
         marks(chunk - i) = mark_at(mark)
      end do
   end subroutine pass_chunk

   !> Takes the figures of a known motion if a run is on it: near it at two marks a period apart.
   pure subroutine find_kept(system, marks, within, known, found, end, counts, good)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In and out: the last two marks, the latest first.
      type(mark_type), intent(inout) :: marks(0:1)
      !> How near, over the clearance.
      real(wp), intent(in) :: within
      !> The motion.
      type(kept_type), intent(in) :: known
      !> Out: as in `perform`.
      real(wp), intent(inout) :: found(:), end(:)
      !> Out: as in `perform`.
      integer, intent(inout) :: counts(:)
      !> Whether it is.
      logical, intent(out) :: good
      type(mark_type) :: strobe

      strobe = mark_at(known%strobe)
      call compare(system, marks(0), strobe, within, good)
      if (good) call compare(system, marks(1), strobe, within, good)
      if (.not. good) return
      found = known%found
      end = known%end
      counts = known%counts
   end subroutine find_kept

   !> Keeps a motion for the next runs, with its state at the phase of the marks.
   pure subroutine keep_motion(system, mark, found, end, counts, events, kept, motions)
      !> The forced system, and a mark.
      type(forced_system_type), intent(in) :: system
      type(state_type), intent(in) :: mark
      !> The motion, as in `perform`.
      real(wp), intent(in) :: found(:), end(:)
      integer, intent(in) :: counts(:)
      !> Room for events.
      type(event_type), intent(inout) :: events(:)
      !> In and out: with the motion, if it has the period of the load and there is room.
      type(kept_type), intent(inout) :: kept(most_kept)
      integer, intent(inout) :: motions
      type(state_type) :: begin, strobe
      integer :: n, status

      if (counts(1) /= 1 .or. motions == most_kept) return
      begin = initial_state(system, end)
      begin%cycle = 0
      call simulate(system, begin, merge(1_int64, 0_int64, begin%phase > mark%phase), mark%phase, &
         events, n, strobe, status)
      if (status /= stat%ok) return
      motions = motions + 1
      kept(motions) = kept_type(strobe, found, end, counts)
   end subroutine keep_motion

   !> A mark at a state.
   pure type(mark_type) function mark_at(state) result(mark)
      !> The state.
      type(state_type), intent(in) :: state

      mark = mark_type(.true., state, state%cycle, state%phase, state%z)
   end function mark_at

   !> A mark at a time before which there is no further event.
   pure type(mark_type) function mark_after(system, state, cycle, phase) result(mark)
      !> The forced system, and the state after the last event.
      type(forced_system_type), intent(in) :: system
      type(state_type), intent(in) :: state
      !> Whole load cycles at that time, and the load phase beyond them (rad).
      integer(int64), intent(in) :: cycle
      real(wp), intent(in) :: phase

      if (state%resting) then
         mark = mark_at(state_later(system, state, cycle, phase))
      else
         mark = mark_type(.false., state, cycle, phase, free_mass_later(system, state, cycle, &
            phase))
      end if
   end function mark_after

   !> Whether two marks are near each other; their states are computed if z alone does not decide.
   pure subroutine compare(system, one, other, within, are_near)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In and out: the marks.
      type(mark_type), intent(inout) :: one, other
      !> How near, over the clearance.
      real(wp), intent(in) :: within
      !> Whether they are.
      logical, intent(out) :: are_near

      are_near = abs(one%z - other%z)/system%clearance < within
      if (.not. are_near) return
      call complete_mark(system, one)
      call complete_mark(system, other)
      are_near = distance(one%state, other%state, system%clearance) < within
   end subroutine compare

   !> Computes the state of a mark.
   pure subroutine complete_mark(system, mark)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In and out: the mark.
      type(mark_type), intent(inout) :: mark

      if (mark%known) return
      mark%state = state_later(system, mark%state, mark%cycle, mark%phase)
      mark%known = .true.
   end subroutine complete_mark

   !> The figures of the stable periodic motion near a state.
   pure subroutine refine(system, mark, cycles, wanted, events, found, end, counts, good)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state.
      type(state_type), intent(in) :: mark
      !> Load cycles of one or more periods.
      integer, intent(in) :: cycles
      !> As in `perform`.
      logical, intent(in) :: wanted(figures)
      !> Room for events.
      type(event_type), intent(inout) :: events(:)
      !> Out: as in `perform`.
      real(wp), intent(inout) :: found(:), end(:)
      !> Out: as in `perform`.
      integer, intent(inout) :: counts(:)
      !> False if there is none.
      logical, intent(out) :: good
      type(known_type) :: known
      type(state_type) :: begin
      real(wp), parameter :: none(4) = 0
      integer :: n

      call shortest_period(system, numbers_of(system, mark), cycles, known, good)
      if (.not. good) return
      call over_period(system, known%targets(1), none, events, n, good)
      if (.not. good) return
      begin = target_state(system, known%targets(1), none)
      call measure(system, begin, two_pi*known%cycles/system%r, events(:n), wanted, found, good)
      end = numbers_of(system, begin)
      found(multiplier) = known%largest
      counts = [known%cycles, count(events(:n)%kind == impact_event)]
   end subroutine refine

   !> The figures over the next load cycles.
   subroutine examine_cycles(system, state, mark, keep, left, wanted, events, found, counts, &
      status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: state at the start of the last flight or rest before the mark. Out: at the end.
      type(state_type), intent(inout) :: state
      !> The state from which the cycles are counted.
      type(state_type), intent(in) :: mark
      !> Load cycles.
      integer, intent(in) :: keep
      !> Events that are left.
      integer, intent(inout) :: left
      !> As in `perform`.
      logical, intent(in) :: wanted(figures)
      !> Room for events.
      type(event_type), intent(inout) :: events(:)
      !> Out: as in `perform`.
      real(wp), intent(inout) :: found(:)
      !> Out: as in `perform`.
      integer, intent(inout) :: counts(:)
      !> Status.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      real(wp) :: part(figures), squares
      type(state_type) :: begin, final
      integer :: i, n
      logical :: good

      counts = 0
      found(:force) = 0
      found(speed) = 0
      found([least_speed, least_gap]) = ieee_value(1.0_wp, ieee_positive_inf)
      squares = 0
      final = mark
      do i = 1, keep
         begin = final
         call advance(system, state, final, 1.0_wp, events, n, left, status, progress)
         if (status /= stat%ok) exit
         call measure(system, begin, two_pi/system%r, events(:n), wanted, part, good)
         if (.not. good) status = stat%budget
         if (.not. good) exit
         found(:force) = max(found(:force), part(:force))
         found(speed) = max(found(speed), part(speed))
         found([least_speed, least_gap]) = min(found([least_speed, least_gap]), &
            part([least_speed, least_gap]))
         squares = squares + part(rms)**2
         counts(2) = counts(2) + count(events(:n)%kind == impact_event)
      end do
      found(rms) = sqrt(squares/keep)
      found(amplitude) = system%amplitude
      if (status /= stat%ok) found = ieee_value(1.0_wp, ieee_quiet_nan)
   end subroutine examine_cycles

   !> The figures between a state and a later time.
   pure subroutine measure(system, begin, lapse, events, wanted, found, complete)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state.
      type(state_type), intent(in) :: begin
      !> Time from there to the end (1/omega).
      real(wp), intent(in) :: lapse
      !> Events in between.
      type(event_type), intent(in) :: events(:)
      !> As in `perform`.
      logical, intent(in) :: wanted(figures)
      !> As in `perform`, except the multiplier.
      real(wp), intent(inout) :: found(:)
      !> False if a search ran out of steps.
      logical, intent(out) :: complete
      type(flight_type) :: x, other
      real(wp) :: starts(6, 0:size(events)), times(0:size(events) + 1), square, w(0:2, 3)
      integer, parameter :: rows(3) = [displacement, acceleration, force]
      integer :: resting(0:size(events)), i, j

      ! x, x'' and x + 2 xi x'
      w(:, 1) = [1.0_wp, 0.0_wp, 0.0_wp]
      w(:, 2) = [0.0_wp, 0.0_wp, 1.0_wp]
      w(:, 3) = [1.0_wp, 2*system%osc%xi, 0.0_wp]
      call segments_between(system, begin, events, starts, resting)
      times(:size(events)) = starts(1, :)
      times(size(events) + 1) = starts(1, 0) + lapse
      complete = .true.
      found(rows) = 0
      square = 0
      do i = 0, size(events)
         ! where rest begins at the instant of an impact, no flight lies in between
         if (.not. times(i + 1) > times(i)) cycle
         x = primary_segment(system, starts(:, i), resting(i), times(i + 1) - times(i))
         if (wanted(rms)) square = square + square_integral(x%oscillation_type, x%duration)
         other = x
         do j = 1, 3
            if (.not. wanted(rows(j))) cycle
            other%oscillation_type = combination(x%oscillation_type, w(:, j))
            call raise(other, found(rows(j)), complete)
         end do
      end do
      found(rms) = sqrt(max(0.0_wp, square)/lapse)
      found(speed) = 0
      found([least_speed, least_gap]) = ieee_value(1.0_wp, ieee_positive_inf)
      do i = 1, size(events)
         starts(5, i) = starts(3, i) + 0.5_wp*events(i)%side*system%clearance   ! z at the wall
         associate (e => events(i), approach => abs(events(i)%z_dot_before - &
            events(i)%x_dot_before))
            ! the approach speed of a stick or release is 0, and so is the least speed with rest
            found(speed) = max(found(speed), approach)
            found(least_speed) = min(found(least_speed), approach)
         end associate
      end do
      do i = 0, size(events)
         if (.not. (wanted(least_gap) .and. times(i + 1) > times(i))) cycle
         call narrow(system, starts(:, i), times(i + 1) - times(i), found(least_gap), complete)
      end do
      ! accumulations and rests have other boundaries
      if (any(resting /= 0)) found([least_speed, least_gap]) = 0
      found(amplitude) = system%amplitude
   end subroutine measure

   !> Lowers a distance to the least one from a wall at a turn of the free mass in a flight.
   pure subroutine narrow(system, start, duration, gap, complete)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> (6) Time, phase, x, x', z, z' at the start.
      real(wp), intent(in) :: start(:)
      !> Duration of the flight (1/omega).
      real(wp), intent(in) :: duration
      !> In and out: the distance (F0/K).
      real(wp), intent(inout) :: gap
      !> In and out: set to false if the search ran out of steps.
      logical, intent(inout) :: complete
      real(wp) :: lowest, highest
      logical :: whole, several

      call relative_extrema(new_flight(system%osc%xi, system%r, system%amplitude, start(2) - &
         system%lag, start(3), start(4), start(5), start(6), duration), lowest, highest, whole)
      complete = complete .and. whole
      if (lowest > highest) return
      ! a single turn is a greatest value of z - x if that is above the one at the start; several
      ! alternate, so that the lowest is a least value and the highest a greatest one
      several = highest - lowest > same*system%clearance
      associate (first => start(5) - start(3))
         if (several .or. lowest < first) gap = min(gap, lowest + 0.5_wp*system%clearance)
         if (several .or. highest > first) gap = min(gap, 0.5_wp*system%clearance - highest)
      end associate
   end subroutine narrow

   !> Raises a figure to the greatest absolute value in a segment, its ends included.
   pure subroutine raise(segment, figure, complete)
      !> The segment.
      type(flight_type), intent(in) :: segment
      !> In and out: the figure.
      real(wp), intent(inout) :: figure
      !> In and out: set to false if the search ran out of steps.
      logical, intent(inout) :: complete
      real(wp) :: lowest, highest, first(0:5), last(0:5)
      logical :: whole

      call relative_extrema(segment, lowest, highest, whole)
      complete = complete .and. whole
      first = derivatives(segment, 0.0_wp)
      last = derivatives(segment, segment%duration)
      figure = max(figure, abs(first(0)), abs(last(0)), -lowest, highest)
   end subroutine raise

   !> t, x, x', z, z' of a state.
   pure function numbers_of(system, state) result(numbers)
      !> The forced system, and the state.
      type(forced_system_type), intent(in) :: system
      !> As in `system`.
      type(state_type), intent(in) :: state
      real(wp) :: numbers(5)

      numbers = [state_time(state%cycle, state%phase, system%r), state%x, state%x_dot, state%z, &
         state%z_dot]
   end function numbers_of

   !> The distance of two states at one phase over the clearance.
   pure real(wp) function distance(a, b, clearance)
      !> The states, and the clearance.
      type(state_type), intent(in) :: a, b
      !> As in `a`.
      real(wp), intent(in) :: clearance

      distance = maxval(abs([a%x - b%x, a%x_dot - b%x_dot, a%z - b%z, a%z_dot - b%z_dot]))/clearance
   end function distance

end module vi_attractor_performance
