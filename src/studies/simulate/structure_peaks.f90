!> The peaks of a linear combination y of the coordinates of a structure in free vibration.
!!
!! A half oscillation lasts from one zero of y to the next. Its peak is the greatest |y| in it: a
!! point where y turns in a segment between events, or an event. Points of turning are found between
!! nodes close together as in vi_quantities, and then from the closed form of the segment.
module vi_structure_peaks
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   use vi_modes, only: advance
   use vi_moments, only: rates_in
   use vi_peaks, only: half_type, peak_type, take
   use vi_progress, only: add_done_work, add_expected_work, is_stopped, report_share
   use vi_quantities, only: density, energy, turning_shares
   use vi_status, only: stat
   use vi_structure, only: load_type, state_of, structure_type
   use vi_structure_map, only: accelerations
   use vi_structure_run, only: halt_event, impact_event, new_run, run_event_type, run_state_type, &
      run_type, simulate_structure, stick_event, time_of, touch_event
   use vi_structure_trajectory, only: find_parts, start_run
   implicit none (type, external)
   private

   public :: find_structure_peaks

   !> Units of work of a run in the progress counters.
   integer, parameter :: work = 100

   !> A segment between two events, or a part of it.
   type :: segment_type
      !> Its regime, the time at which it begins, and the pairs there.
      integer :: regime = 1
      real(wp) :: time = 0
      real(wp), allocatable :: x(:), v(:)
   end type segment_type

contains

   !> The peaks of a free vibration.
   subroutine find_structure_peaks(structure, load, q, rate, along, unit, max_events, peaks, n, &
      status, progress)
      !> The structure, and constant forces.
      type(structure_type), intent(in) :: structure
      type(load_type), intent(in) :: load
      !> (n) Coordinates and velocities at the start, and the row that gives y from the coordinates.
      real(wp), intent(in) :: q(:), rate(:), along(:)
      !> The longest natural period.
      real(wp), intent(in) :: unit
      !> Largest number of events.
      integer, intent(in) :: max_events
      !> (most) Out: the peaks.
      type(peak_type), intent(inout) :: peaks(:)
      !> Number of peaks found, fewer than `most` if the oscillation ends earlier.
      integer, intent(out) :: n
      !> `stat%ok`, `stat%event_limit`, `stat%not_computed` if it was stopped, or as of `start_run`
      !! and `simulate_structure`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      integer, parameter :: capacity = 128
      !> Natural periods allowed for each peak before a run ends.
      real(wp), parameter :: patience = 4
      type(run_event_type), allocatable :: events(:)
      type(run_type) :: run
      type(run_state_type) :: state
      type(segment_type) :: segment
      type(half_type) :: half
      real(wp) :: elapsed, fastest, last, y(0:1)
      integer(int64) :: cycle
      integer :: found, i, left, reported
      logical :: rests

      n = 0
      reported = 0
      left = max_events
      call add_expected_work(work, progress)
      call new_run(structure, load, run, status)
      if (status == stat%ok) call start_run(run, 0.0_wp, q, rate, state, status)
      if (status /= stat%ok) return
      allocate (events(capacity))
      call begin_segment(segment, state%regime, 0.0_wp, state%x, state%v)
      y = [dot_product(along, q), dot_product(along, rate)]
      half%is_peak = .not. y(0)*y(1) < 0
      if (.not. y(0)*y(1) > 0) call take_point(run, segment, along, 0.0_wp, half, peaks, n)
      fastest = maxval(abs(rate))
      last = unit
      do
         call find_parts(run, last, cycle, elapsed)
         call simulate_structure(run, state, cycle, elapsed, events(:min(capacity, left)), found, &
            status, .true.)
         left = left - found
         do i = 1, found
            call walk(run, segment, time_of(run, events(i)) - segment%time, along, half, peaks, n)
            select case (events(i)%kind)
            case (impact_event, touch_event)
               half%impacts = half%impacts + 1
            case (stick_event, halt_event)
               half%rests = half%rests + 1
            case default
            end select
            call begin_segment(segment, events(i)%regime, time_of(run, events(i)), events(i)%x, &
               events(i)%v)
            call take_point(run, segment, along, 0.0_wp, half, peaks, n)
            fastest = max(fastest, maxval(abs(events(i)%rate)))
         end do
         if (n == size(peaks)) exit
         if (status == stat%ok) then
            call walk(run, segment, last - segment%time, along, half, peaks, n)
            call begin_segment(segment, state%regime, last, state%x, state%v)
            if (n == size(peaks) .or. last > patience*unit*(size(peaks) + 1)) exit
            call check_rest(run, segment, unit, fastest, rests)
            if (found == 0 .and. rests) then
               ! the half oscillation in progress is the last one
               call take(peak_type(last, -sign(huge(last), half%side)), half, peaks, n)
               exit
            end if
            last = last + unit
         else if (status /= stat%more_events) then
            exit
         end if
         if (left == 0) status = stat%event_limit
         if (left == 0) exit
         if (is_stopped(progress)) status = stat%not_computed
         if (status == stat%not_computed) return
         call report_share(real(n, wp)/size(peaks), work, reported, progress)
      end do
      if (n == size(peaks)) status = stat%ok
      call add_done_work(work - reported, progress)
   end subroutine find_structure_peaks

   !> Begins a segment.
   pure subroutine begin_segment(segment, regime, time, x, v)
      !> The segment.
      type(segment_type), intent(inout) :: segment
      !> As in `segment_type`.
      integer, intent(in) :: regime
      real(wp), intent(in) :: time, x(:), v(:)

      segment%regime = regime
      segment%time = time
      segment%x = x
      segment%v = v
   end subroutine begin_segment

   !> Whether a structure is in equilibrium, or stuck in one; records the largest velocity.
   pure subroutine check_rest(run, segment, unit, fastest, rests)
      !> The run, and the state.
      type(run_type), intent(in) :: run
      type(segment_type), intent(in) :: segment
      !> A time in which velocities change.
      real(wp), intent(in) :: unit
      !> In and out: the largest velocity so far.
      real(wp), intent(inout) :: fastest
      !> The answer.
      logical, intent(out) :: rests
      !> Share of the largest velocity that counts as rest.
      real(wp), parameter :: still = 1.0e-13_wp
      real(wp), dimension(size(run%structure%mass, 1)) :: q, rate, change

      call state_of(run%regimes(segment%regime), 0.0_wp, segment%x, segment%v, q, rate)
      call accelerations(run%regimes(segment%regime), 0.0_wp, segment%x, segment%v, change)
      fastest = max(fastest, maxval(abs(rate)))
      rests = max(maxval(abs(rate)), unit*maxval(abs(change))) <= still*fastest
   end subroutine check_rest

   !> y and its derivatives at a time of a segment, with coordinates and velocities if wanted.
   pure subroutine follow(run, segment, t, along, y, q, rate)
      !> The run, the segment, and the time from its beginning.
      type(run_type), intent(in) :: run
      type(segment_type), intent(in) :: segment
      real(wp), intent(in) :: t
      !> The row that gives y.
      real(wp), intent(in) :: along(:)
      !> y, y' and y''.
      real(wp), intent(out) :: y(0:2)
      !> (n)
      real(wp), contiguous, intent(out) :: q(:), rate(:)
      real(wp), dimension(size(segment%x)) :: x, v
      real(wp) :: change(size(along))

      associate (regime => run%regimes(segment%regime))
         call advance(regime%modes, t, segment%x, segment%v, x, v)
         call state_of(regime, 0.0_wp, x, v, q, rate)
         call accelerations(regime, 0.0_wp, x, v, change)
      end associate
      y = [dot_product(along, q), dot_product(along, rate), dot_product(along, change)]
   end subroutine follow

   !> Takes a point of a segment into account.
   pure subroutine take_point(run, segment, along, t, half, peaks, n)
      !> The run, the segment, the row that gives y, and the time from its beginning.
      type(run_type), intent(in) :: run
      type(segment_type), intent(in) :: segment
      real(wp), intent(in) :: along(:), t
      !> In and out: the half oscillation in progress, the peaks, and their number.
      type(half_type), intent(inout) :: half
      type(peak_type), intent(inout) :: peaks(:)
      integer, intent(inout) :: n
      real(wp) :: y(0:2), q(size(along)), rate(size(along))

      call follow(run, segment, t, along, y, q, rate)
      call take(peak_type(segment%time + t, y(0), energy(run, run%regimes(segment%regime)%closed, &
         segment%time + t, q, rate), half%impacts, half%rests), half, peaks, n)
   end subroutine take_point

   !> Takes the points into account at which y turns in a segment, or in a part of it.
   pure subroutine walk(run, segment, length, along, half, peaks, n)
      !> The run, the segment, its length, and the row that gives y.
      type(run_type), intent(in) :: run
      type(segment_type), intent(in) :: segment
      real(wp), intent(in) :: length, along(:)
      !> As of `take_point`.
      type(half_type), intent(inout) :: half
      type(peak_type), intent(inout) :: peaks(:)
      integer, intent(inout) :: n
      !> Share of the way between nodes by which a point of turning may lie beyond: rounding.
      real(wp), parameter :: margin = 1.0e-6_wp
      real(wp) :: h, old(0:2), shares(2), t, y(0:2), q(size(along)), rate(size(along))
      integer :: i, j, k, nodes

      if (.not. length > 0) return
      nodes = max(1, ceiling(density*length*rates_in(run%regimes(segment%regime))))
      h = length/nodes
      do i = 0, nodes
         if (i > 0) old = y
         call follow(run, segment, i*h, along, y, q, rate)
         if (i == 0) cycle
         shares = turning_shares(old(0), y(0), h*old(1), h*y(1))
         do j = 1, 2
            t = merge(minval(shares), maxval(shares), j == 1)
            if (.not. (t > -margin .and. t < 1 + margin)) cycle
            t = h*(i - 1 + t)
            do k = 1, 4
               call turn(t)
            end do
            call take_point(run, segment, along, t, half, peaks, n)
         end do
      end do

   contains

      !> A step of Newton's method towards the point of turning.
      pure subroutine turn(t)
         !> In and out: the time.
         real(wp), intent(inout) :: t
         real(wp) :: now(0:2), at(size(along)), speeds(size(along))

         call follow(run, segment, t, along, now, at, speeds)
         if (.not. abs(now(2)) > 0) return
         t = t - now(1)/now(2)
         t = max(0.0_wp, h*(i - 1 - margin), min(length, h*(i + margin), t))
      end subroutine turn

   end subroutine walk

end module vi_structure_peaks
