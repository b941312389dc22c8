!> What simulations settle on, over a window.
!!
!! A simulation that repeats itself after some cycles gives a guess; Newton's method makes the
!! motion exact, and only a stable, admissible one within the limits is an attractor for an atlas.
!! What became of the others is told, too: see vi_survey_outcome.
module vi_survey
   use vi_conditions, only: all_conditions
   use vi_curve, only: correct, curve_type
   use vi_event_letters, only: last_of_period, mismatch, read_window, reading_type, total_phase
   use vi_family, only: new_family
   use vi_frame, only: condition_count, condition_type, edge, repetition, unknown_count
   use vi_kinds, only: wp
   use vi_letters, only: standard_letters
   use vi_orbit, only: by_clearance, by_r, most_impacts, n_parameters
   use vi_oscillator, only: left, oscillator_type, right
   use vi_pattern, only: pattern_type
   use vi_rest_family, only: follow_letters, new_rest_family
   use vi_simulate, only: drive_type, event_type, new_drive, simulate_cycles, state_type
   use vi_status, only: stat
   use vi_survey_outcome, only: beyond, chaotic, event_limit, is_chaotic, is_free, no_impacts, &
      not_confirmed, not_settled, periodic, stable_period
   use vi_tally, only: add_sight, add_work, is_stopped
   implicit none (type, external)
   private

   public :: settle_from, survey

   !> What a point counts in a tally of work.
   integer, parameter, public :: survey_work = 5
   !> Longest period that is looked for at last, in load cycles, and how many times as long
   !! as before a simulation then goes on first.
   integer, parameter :: longest_period = 16, longer = 3
   !> Events kept of the end of a simulation, events of one at most, and load cycles between two
   !! looks at whether to stop.
   integer, parameter :: room = 4000, most_events = 4000000, between_looks = 10000
   !> Impacts of two periods that repeat each other are nearer than this in phase.
   real(wp), parameter :: same_phase = 1.0e-3_wp
   !> Load cycles of each of ten batches for a Lyapunov exponent, at first and at last.
   integer, parameter :: short_batch = 20, long_batch = 200
   real(wp), parameter :: two_pi = 2*acos(-1.0_wp)

   !> What a simulation settled on. A stable periodic motion has its letters in standard order;
   !! one within the limits also its unknowns.
   type, public :: attractor_type
      !> Whether it is one within the limits.
      logical :: found = .false.
      !> As in vi_survey_outcome.
      integer :: outcome = not_settled
      real(wp) :: r = 0, clearance = 0
      integer :: cycles = 0
      integer, allocatable :: letters(:)
      !> x_i/D and theta_i of the whole pattern; with rest phase and velocity over D at the last
      !> release, then zeros.
      real(wp), allocatable :: unknowns(:)
   end type attractor_type

   !> The limits of the motions that an atlas is about.
   type :: limits_type
      integer :: letters, cycles
   end type limits_type

contains

   !> What simulations at points spread evenly over a window settle on.
   subroutine survey(osc, r, clearance, settling, most_letters, most_cycles, threads, attractors, &
      tally)
      type(oscillator_type), intent(in) :: osc
      !> The window.
      real(wp), intent(in) :: r(2), clearance(2)
      !> Load cycles before an attractor is looked at.
      integer, intent(in) :: settling
      !> Limits of the motions kept.
      integer, intent(in) :: most_letters, most_cycles
      integer, intent(in) :: threads
      type(attractor_type), intent(inout) :: attractors(:)
      !> As of vi_tally, in units of `survey_work`; points after a stop are not settled.
      integer, intent(inout), optional :: tally(3)
      real(wp) :: u(5), c(2), golden
      integer :: i, j

      call add_sight(survey_work*size(attractors), tally)
      golden = 1
      do j = 1, 40
         golden = (1 + golden)**(1.0_wp/6)
      end do
      !$omp parallel do schedule(dynamic, 1) num_threads(threads) private(u, c)
      do i = 1, size(attractors)
         u = [(modulo(0.5_wp + i/golden**j, 1.0_wp), j=1, 5)]
         c = [r(1) + (r(2) - r(1))*u(1), clearance(1)*(clearance(2)/clearance(1))**u(2)]
         attractors(i) = attractor_type(r=c(1), clearance=c(2))
         if (is_stopped(tally)) cycle
         call settle(osc, u(3:5), settling, limits_type(most_letters, most_cycles), attractors(i), &
            tally)
         call add_work(survey_work, tally)
      end do
      !$omp end parallel do
   end subroutine survey

   !> What one simulation settles on.
   !!
   !! It is looked at after the cycles asked for. What is neither periodic then nor chaotic without
   !! doubt is looked at once more, later and for longer periods.
   subroutine settle(osc, u, settling, limits, attractor, tally)
      type(oscillator_type), intent(in) :: osc
      !> Three numbers in [0, 1) for the initial state.
      real(wp), intent(in) :: u(3)
      integer, intent(in) :: settling
      type(limits_type), intent(in) :: limits
      !> In: the point.
      type(attractor_type), intent(inout) :: attractor
      integer, intent(inout), optional :: tally(3)
      type(drive_type) :: drive
      type(state_type) :: state
      real(wp) :: size_x
      logical :: chaos

      drive = new_drive(osc, attractor%r, 1.0_wp, attractor%clearance)
      size_x = min(abs(drive%amplitude), 3*attractor%clearance)
      state%x = size_x*(2*u(1) - 1)
      state%x_dot = size_x*(2*u(2) - 1)
      state%z = state%x + 0.499_wp*attractor%clearance*(2*u(3) - 1)
      call look(osc, drive, settling, limits%cycles, limits, state, attractor, tally)
      if (attractor%outcome /= not_settled .and. attractor%outcome /= not_confirmed) return
      if (is_stopped(tally)) return
      call is_chaotic(drive, state, short_batch, chaos)
      if (.not. chaos) then
         call look(osc, drive, longer*settling, longest_period, limits, state, attractor, tally)
         if (attractor%outcome /= not_settled) return
         call is_chaotic(drive, state, long_batch, chaos)
      end if
      if (chaos) attractor%outcome = chaotic
   end subroutine settle

   !> What a simulation from a state is on after some load cycles, if it repeats itself by then.
   subroutine settle_from(osc, state, settling, most_letters, most_cycles, attractor, tally)
      type(oscillator_type), intent(in) :: osc
      type(state_type), intent(in) :: state
      integer, intent(in) :: settling
      !> As of `survey`.
      integer, intent(in) :: most_letters, most_cycles
      !> In: the point.
      type(attractor_type), intent(inout) :: attractor
      integer, intent(inout), optional :: tally(3)
      type(state_type) :: final

      final = state
      call look(osc, new_drive(osc, attractor%r, 1.0_wp, attractor%clearance), settling, &
         most_cycles, limits_type(most_letters, most_cycles), final, attractor, tally)
   end subroutine settle_from

   !> Simulates, then looks at the cycles after that.
   subroutine look(osc, drive, settling, longest, limits, state, attractor, tally)
      type(oscillator_type), intent(in) :: osc
      type(drive_type), intent(in) :: drive
      !> Load cycles simulated first, and of the longest period that is looked for.
      integer, intent(in) :: settling, longest
      type(limits_type), intent(in) :: limits
      !> Out: that at the end.
      type(state_type), intent(inout) :: state
      type(attractor_type), intent(inout) :: attractor
      integer, intent(inout), optional :: tally(3)
      type(event_type) :: events(room)
      type(reading_type) :: now, before
      integer, allocatable :: letters(:)
      real(wp) :: end_phase
      logical :: shorter
      integer :: n, k, last, status

      attractor%outcome = not_settled
      call run(drive, state, settling, events, n, status, tally)
      if (status == stat%ok) call run(drive, state, 2*longest + 2, events, n, status, tally)
      if (status /= stat%ok) then
         if (status /= stat%not_computed) attractor%outcome = event_limit
         return
      end if
      if (n == 0) then
         if (is_free(drive, state)) attractor%outcome = no_impacts
         return
      end if
      last = last_of_period(events(:n))
      do k = 1, longest
         ! a thousandth of a cycle: the event one period before belongs to the window before
         end_phase = total_phase(events(last)) + 1.0e-3_wp*two_pi
         call read_window(events(:last), end_phase - two_pi*k, end_phase, now)
         call read_window(events(:last), end_phase - 2*two_pi*k, end_phase - two_pi*k, before)
         if (.not. mismatch(events, now, before, k) < same_phase) cycle
         attractor%outcome = not_confirmed
         if (now%n <= limits%letters .and. k <= limits%cycles) then
            call identify(osc, drive, events, now, k, attractor)
            if (attractor%found) attractor%outcome = periodic
            if (attractor%found) return
         end if
         call stable_period(drive, state, k, letters, shorter)
         if (shorter) then
            attractor%outcome = not_settled
         else if (size(letters) > 0) then
            call name_it(osc, letters, k, limits, attractor)
         end if
         return
      end do
   end subroutine look

   !> Simulates some cycles from a state; out: the state there, and the last events.
   subroutine run(drive, state, cycles, events, n, status, tally)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(inout) :: state
      integer, intent(in) :: cycles
      type(event_type), intent(inout) :: events(:)
      !> Status `stat%more_events` if there are too many, `stat%not_computed` if it was stopped.
      integer, intent(out) :: n, status
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      integer :: done, step, left

      left = most_events
      done = 0
      do
         step = min(cycles - done, between_looks)
         call simulate_cycles(drive, state, step, left, events, n, status)
         done = done + step
         if (status /= stat%ok .or. done == cycles) exit
         if (is_stopped(tally)) then
            status = stat%not_computed
            exit
         end if
      end do
   end subroutine run

   !> Notes the pattern of a stable motion that is beyond the limits, or else was read right though
   !! the equations of its family do not confirm it.
   pure subroutine name_it(osc, letters, cycles, limits, attractor)
      type(oscillator_type), intent(in) :: osc
      !> Of the period, from any of them on.
      integer, intent(in) :: letters(:)
      integer, intent(in) :: cycles
      type(limits_type), intent(in) :: limits
      type(attractor_type), intent(inout) :: attractor
      integer :: standard(size(letters)), shift
      logical :: mirrored

      call standard_letters(letters, abs(osc%restitution(1) - osc%restitution(2)) <= 0, standard, &
         shift, mirrored)
      if (size(letters) > limits%letters .or. cycles > limits%cycles) then
         attractor%outcome = beyond
         attractor%cycles = cycles
         attractor%letters = standard
      else if (allocated(attractor%letters)) then
         if (size(letters) == size(attractor%letters)) attractor%found = &
            all(standard == attractor%letters)
         if (attractor%found) attractor%outcome = periodic
      end if
   end subroutine name_it

   !> The exact motion that a window is about, in standard order, if it is stable and admissible.
   pure subroutine identify(osc, drive, events, reading, cycles, attractor)
      type(oscillator_type), intent(in) :: osc
      type(drive_type), intent(in) :: drive
      type(event_type), intent(in) :: events(:)
      type(reading_type), intent(in) :: reading
      integer, intent(in) :: cycles
      type(attractor_type), intent(inout) :: attractor
      integer :: order(reading%n), shift, n, i, side
      logical :: mirrored, resting
      real(wp) :: theta(reading%n), x(reading%n)

      n = reading%n
      if (allocated(attractor%letters)) deallocate (attractor%letters, attractor%unknowns)
      allocate (attractor%letters(n))
      call standard_letters(reading%letters(:n), abs(osc%restitution(1) - osc%restitution(2)) &
         <= 0, attractor%letters, shift, mirrored)
      side = merge(-1, 1, mirrored)
      order = cshift([(i, i=1, n)], shift)
      attractor%cycles = cycles
      resting = any(abs(attractor%letters) == 2)
      allocate (attractor%unknowns(2*n), source=0.0_wp)
      if (resting) then
         i = reading%last(order(findloc(abs(attractor%letters), 2, dim=1, back=.true.)))
         attractor%unknowns(:2) = [events(i)%phase + merge(0.5_wp*two_pi, 0.0_wp, mirrored), &
            side*events(i)%x_dot_after/drive%clearance]
      else
         do i = 1, n
            x(i) = side*events(reading%first(order(i)))%x/drive%clearance
            theta(i) = total_phase(events(reading%first(order(i)))) - drive%lag
            if (order(i) < order(1)) theta(i) = theta(i) + two_pi*cycles
         end do
         theta = theta - two_pi*floor(theta(1)/two_pi) + merge(0.5_wp*two_pi, 0.0_wp, mirrored)
         attractor%unknowns = [x, theta]
      end if
      call polish(osc, attractor, resting)
   end subroutine identify

   !> Newton's method at the point, and the verdict.
   pure subroutine polish(osc, attractor, resting)
      type(oscillator_type), intent(in) :: osc
      type(attractor_type), intent(inout) :: attractor
      logical, intent(in) :: resting
      type(curve_type) :: sheet
      type(condition_type) :: fixed(2)
      type(condition_type), allocatable :: conditions(:)
      real(wp), allocatable :: point(:), values(:)
      real(wp) :: c(n_parameters)
      logical :: possible
      integer :: n, iterations

      if (size(attractor%letters) > most_impacts) return
      allocate (sheet%frame%edges(0))
      sheet%frame%resting = resting
      if (resting) then
         sheet%frame%rest = new_rest_family(attractor%letters, attractor%cycles)
         allocate (sheet%frame%repetitions(0))
      else
         call new_family(pattern_type(attractor%letters, attractor%cycles), .false., .true., &
            sheet%frame%family, sheet%frame%repetitions, possible)
      end if
      c = [attractor%r, log(attractor%clearance), osc%xi, osc%mu, osc%restitution(right), &
         osc%restitution(left)]
      sheet%c = c
      sheet%active = [by_r, by_clearance]
      sheet%origin = c(:2)
      sheet%scale = [1.0_wp, 1.0_wp]
      fixed = [condition_type(edge, by_r, 1, bound=c(1)), &
         condition_type(edge, by_clearance, 1, bound=c(2))]
      n = unknown_count(sheet%frame)
      allocate (point(n + 2), source=0.0_wp)
      point(:min(n, size(attractor%unknowns))) = &
         attractor%unknowns(:min(n, size(attractor%unknowns)))
      if (resting) then
         call follow_letters(sheet%frame%rest, [point(1), asinh(point(2))], c, point(:n), possible)
         if (.not. possible) return
      end if
      call correct(sheet, fixed, point, iterations)
      if (iterations == 0) return
      allocate (values(condition_count(sheet%frame)), conditions(condition_count(sheet%frame)))
      call all_conditions(sheet%frame, point(:n), c, values, conditions)
      ! one that repeats itself is stable all the same
      if (any(values <= 0 .and. conditions%kind /= repetition)) return
      if (resting) then
         attractor%unknowns(:2) = [point(1), sinh(point(2))]
      else
         attractor%unknowns(:n) = point(:n)
      end if
      attractor%found = .true.
   end subroutine polish

end module vi_survey
