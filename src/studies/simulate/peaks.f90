!> The peaks of the primary mass in free vibration, from the closed form of each flight and rest.
!!
!! A half oscillation lasts from one zero of x to the next. Its peak is the greatest |x| in it: a
!! stationary point of a flight or rest, or an impact that reverses the primary mass. Zeros and
!! stationary points of x = exp(-decay t) C sin(nu t + phi) are known in closed form, so that no
!! peak is missed and no sampling is needed.
module vi_peaks
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_forced_system, only: forced_system_type, event_type, flight_from, impact_event, &
      initial_state, new_forced_system, rest_from, state_time, state_type, stick_event
   use vi_kinds, only: pi, two_pi, wp
   use vi_oscillation, only: derivatives, oscillation_type
   use vi_oscillator, only: eta, oscillator_type
   use vi_simulate, only: simulate_on
   use vi_status, only: stat
   use vi_progress, only: add_expected_work, add_done_work, is_stopped, report_share
   implicit none (type, external)
   private

   public :: find_peaks, take

   !> A peak. Impacts and rests are counted from the previous peak, or from the start.
   type, public :: peak_type
      !> Time (1/omega), displacement of the primary mass, and energy of both masses and the spring,
      !! over K and the square of the unit of length; after the impact if there is one at the peak.
      real(wp) :: time = 0, x = 0, energy = 0
      integer :: impacts = 0, rests = 0
   end type peak_type

   !> The half oscillation that is being followed.
   type, public :: half_type
      !> Sign of x; 0 before the first one.
      real(wp) :: side = 0
      !> Its greatest |x| so far, with impacts and rests since the start of the simulation.
      type(peak_type) :: best
      !> Whether that is a peak: not if the simulation starts beyond it.
      logical :: is_peak = .true.
      !> Impacts and rests since the start of the simulation, and up to the last peak.
      integer :: impacts = 0, rests = 0, impacts_before = 0, rests_before = 0
   end type half_type

   !> The clock of the simulation. With load 0 the frequency ratio has no other meaning; a value
   !! above 1 is at resonance with neither the flights nor the rests.
   real(wp), parameter :: clock = 2
   !> Load cycles of the clock that are simulated at a time: 2 pi/omega.
   integer, parameter :: chunk = 2
   !> Units of work of a run in the progress counters.
   integer, parameter :: work = 100
   !> Sizes that count as rounding: of relative differences, and of angles (rad) beyond the end of a
   !! segment.
   real(wp), parameter :: rounding = 8*epsilon(1.0_wp), margin = 1.0e-12_wp

contains

   !> The peaks of free vibrations from one state, for several clearances.
   subroutine find_peaks(osc, clearances, start, max_events, threads, peaks, counts, status, &
      progress)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      !> (n) Clearances, in the unit of length of the start.
      real(wp), intent(in) :: clearances(:)
      !> x, x', y = z - x and z' at the start.
      real(wp), intent(in) :: start(4)
      !> Largest number of events of a run, and number of OpenMP threads; the result does not depend
      !! on the latter.
      integer, intent(in) :: max_events, threads
      !> (most, n) Out: the peaks; a run ends with its last one.
      type(peak_type), intent(inout) :: peaks(:, :)
      !> (n) Number of peaks found, fewer than `most` if the oscillation ends earlier.
      integer, intent(out) :: counts(:)
      !> (n) `stat%ok`, `stat%event_limit`, `stat%budget`, or
      !! `stat%not_computed` if the computation was stopped before the end of the run.
      integer, intent(out) :: status(:)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      integer :: j

      call add_expected_work(work*size(clearances), progress)
      counts = 0
      status = stat%not_computed
      !$omp parallel do schedule(dynamic, 1) num_threads(threads)
      do j = 1, size(clearances)
         if (is_stopped(progress)) cycle
         call follow(new_forced_system(osc, clock, 0.0_wp, clearances(j)), start, max_events, &
            peaks(:, j), counts(j), status(j), progress)
      end do
      !$omp end parallel do
   end subroutine find_peaks

   !> The peaks of one free vibration.
   subroutine follow(system, start, max_events, peaks, n, status, progress)
      !> The system, with load 0.
      type(forced_system_type), intent(in) :: system
      !> x, x', y and z' at the start.
      real(wp), intent(in) :: start(4)
      !> Largest number of events.
      integer, intent(in) :: max_events
      !> (most) Out: the peaks.
      type(peak_type), intent(inout) :: peaks(:)
      !> Number of peaks found.
      integer, intent(out) :: n
      !> As in `find_peaks`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      integer, parameter :: capacity = 128
      !> Number of periods of the slowest oscillation, that of both masses together, allowed for
      !! each peak before a run ends.
      real(wp), parameter :: patience = 4
      type(event_type) :: events(capacity)
      type(state_type) :: state, begin, final
      type(half_type) :: half
      real(wp) :: longest
      integer(int64) :: last
      integer :: i, found, left, reported

      n = 0
      left = max_events
      reported = 0
      longest = patience*two_pi*(size(peaks) + 1)*sqrt(1 + system%osc%mu)/eta(system%osc%xi)
      state = initial_state(system, [0.0_wp, start(1), start(2), start(1) + start(3), start(4)])
      begin = state
      half%is_peak = .not. start(1)*start(2) < 0
      if (.not. start(1)*start(2) > 0) call take(point(system, begin, half), half, peaks, n)
      last = chunk
      do
         call simulate_on(system, state, last, 0.0_wp, events, found, final, left, status, progress)
         if (status == stat%not_computed) return
         do i = 1, found
            call walk(system, begin, state_time(events(i)%cycle, events(i)%phase, system%r), half, &
               peaks, n)
            call pass(system, events(i), half, peaks, n, begin)
         end do
         if (n == size(peaks)) exit
         if (status == stat%ok) then
            call walk(system, begin, state_time(last, 0.0_wp, system%r), half, peaks, n)
            if (n == size(peaks) .or. state_time(last, 0.0_wp, system%r) > longest) exit
            begin = final
            state = final
            last = last + chunk
         else if (status /= stat%more_events) then
            exit
         end if
         if (is_stopped(progress)) then
            status = stat%not_computed
            return
         end if
         call report_share(real(n, wp)/size(peaks), work, reported, progress)
      end do
      if (n == size(peaks)) status = stat%ok
      call add_done_work(work - reported, progress)
   end subroutine follow

   !> Counts an event, at which the next segment begins; the event may be a peak.
   pure subroutine pass(system, event, half, peaks, n, begin)
      !> The system.
      type(forced_system_type), intent(in) :: system
      !> The event.
      type(event_type), intent(in) :: event
      !> In and out: the half oscillation in progress.
      type(half_type), intent(inout) :: half
      !> (most) In and out: the peaks.
      type(peak_type), intent(inout) :: peaks(:)
      !> In and out: their number.
      integer, intent(inout) :: n
      !> Out: the state just after it, as far as `walk` needs it.
      type(state_type), intent(inout) :: begin

      if (event%kind == impact_event) half%impacts = half%impacts + 1
      if (event%kind == stick_event) half%rests = half%rests + 1
      begin%cycle = event%cycle
      begin%phase = event%phase
      begin%x = event%x
      begin%x_dot = event%x_dot_after
      begin%z_dot = event%z_dot_after
      begin%resting = event%kind == stick_event
      ! the primary mass is reversed
      if (event%x*event%x_dot_before >= 0 .and. event%x*event%x_dot_after <= 0) call take( &
         point(system, begin, half), half, peaks, n)
   end subroutine pass

   !> The start of a segment as a point that may be a peak.
   pure type(peak_type) function point(system, begin, half)
      !> The system.
      type(forced_system_type), intent(in) :: system
      !> The state.
      type(state_type), intent(in) :: begin
      !> The half oscillation in progress.
      type(half_type), intent(in) :: half

      point = peak_type(state_time(begin%cycle, begin%phase, system%r), begin%x, &
         0.5_wp*(begin%x**2 &
         + begin%x_dot**2 + system%osc%mu*begin%z_dot**2), half%impacts, half%rests)
   end function point

   !> Takes the stationary points of x in a flight or rest, or in a part of it, into account.
   pure subroutine walk(system, begin, end_time, half, peaks, n)
      !> The system.
      type(forced_system_type), intent(in) :: system
      !> The state at the start of the segment.
      type(state_type), intent(in) :: begin
      !> Time (1/omega) at its end.
      real(wp), intent(in) :: end_time
      !> In and out: the half oscillation in progress.
      type(half_type), intent(inout) :: half
      !> (most) In and out: the peaks.
      type(peak_type), intent(inout) :: peaks(:)
      !> In and out: their number.
      integer, intent(inout) :: n
      type(oscillation_type) :: o
      type(peak_type) :: here
      real(wp) :: time, duration, first, last, top, kinetic, d(0:5)
      integer :: k

      time = state_time(begin%cycle, begin%phase, system%r)
      duration = end_time - time
      if (begin%resting) then
         o = rest_from(system, begin)
         kinetic = 0
      else
         associate (flight => flight_from(system, begin, duration))
            o = flight%oscillation_type
         end associate
         kinetic = 0.5_wp*system%osc%mu*begin%z_dot**2
      end if
      ! the amplitude is close to underflow: the oscillation has ended
      if (.not. hypot(o%a, o%b) > sqrt(tiny(1.0_wp))) return
      ! x and -x have the same stationary points, to the last bit
      first = atan2(o%b, o%a)
      if (o%b < 0 .or. (.not. o%b > 0 .and. o%a < 0)) first = atan2(-o%b, -o%a)
      last = first + o%frequency*duration + margin
      top = atan2(o%frequency, o%decay)
      do k = floor((first - margin - top)/pi), floor((last - top)/pi)
         if (k*pi + top < first - margin) cycle
         here%time = (k*pi + top - first)/o%frequency
         d = derivatives(o, here%time)
         here = peak_type(time + here%time, d(0), 0.5_wp*d(0)**2 + kinetic, half%impacts, &
            half%rests)
         call take(here, half, peaks, n)
      end do
   end subroutine walk

   !> Takes a point into account: it continues the half oscillation in progress, or completes it.
   pure subroutine take(here, half, peaks, n)
      !> The point, with impacts and rests since the start of the simulation.
      type(peak_type), intent(in) :: here
      !> In and out: the half oscillation in progress.
      type(half_type), intent(inout) :: half
      !> (most) In and out: the peaks.
      type(peak_type), intent(inout) :: peaks(:)
      !> In and out: their number, at most the size of `peaks`.
      integer, intent(inout) :: n
      logical :: higher

      if (abs(here%x) <= rounding*abs(half%best%x)) return           ! a zero, to rounding
      if (here%x*half%side > 0) then
         if (abs(here%x) < abs(half%best%x)*(1 - rounding)) return
         higher = abs(here%x) > abs(half%best%x)*(1 + rounding)
         ! of an event at the peak, the state after it counts
         if (.not. higher .and. here%time > half%best%time*(1 + margin)) return
         half%best = here
         half%is_peak = half%is_peak .or. higher
         return
      end if
      if (abs(half%side) > 0 .and. half%is_peak) then
         if (n == size(peaks)) return
         n = n + 1
         peaks(n) = half%best
         peaks(n)%impacts = half%best%impacts - half%impacts_before
         peaks(n)%rests = half%best%rests - half%rests_before
         half%impacts_before = half%best%impacts
         half%rests_before = half%best%rests
      end if
      if (abs(half%side) > 0) half%is_peak = .true.
      half%side = sign(1.0_wp, here%x)
      half%best = here
   end subroutine take

end module vi_peaks
