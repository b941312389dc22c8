!> The motions on which simulations settle, over a window.
!!
!! A simulation that repeats itself after some cycles gives a guess; Newton's method makes the
!! motion exact, and only a stable, admissible one within the limits is an attractor for an atlas.
!! The outcome of the other points is also reported, see vi_survey_outcome.
module vi_survey
   use vi_attractor_known, only: is_free
   use vi_conditions, only: all_conditions, condition_count
   use vi_curve, only: correct, curve_type
   use vi_event_symbols, only: period_type, read_periods, symbol_sequence_type, total_phase
   use vi_exponents, only: is_chaotic
   use vi_forced_system, only: initial_state
   use vi_kinds, only: two_pi, wp
   use vi_motion_family, only: condition_type, edge, repetition
   use vi_symbols, only: standard_symbols
   use vi_orbit, only: by_clearance, by_r, most_impacts, n_parameters, oscillator_parameters
   use vi_oscillator, only: oscillator_type
   use vi_oscillator_families, only: choose_family
   use vi_pattern, only: pattern_type
   use vi_simulate, only: forced_system_type, event_type, new_forced_system, simulate_cycles, &
      state_type
   use vi_simulated_pair, only: new_simulated_pair, simulated_pair_type
   use vi_starts, only: state_start
   use vi_status, only: stat
   use vi_survey_outcome, only: beyond, chaotic, event_limit, no_impacts, &
      not_confirmed, not_settled, periodic, stable_period
   use vi_progress, only: add_expected_work, add_done_work, is_stopped
   implicit none (type, external)
   private

   public :: settle_from, survey

   !> Units of work of a point in the progress counters.
   integer, parameter, public :: survey_work = 5
   !> Longest period in load cycles that the second examination of a point considers, and the factor
   !! by which its transient is longer.
   integer, parameter :: longest_period = 16, longer = 3
   !> Events kept of the end of a simulation, and load cycles between two checks whether to stop if
   !! there are no impacts.
   integer, parameter :: capacity = 4000, between_looks = 10000
   !> Impacts of two periods that repeat each other are nearer than this in phase.
   real(wp), parameter :: same_phase = 1.0e-3_wp
   !> Load cycles of each of ten batches for a Lyapunov exponent, in the first and in the last
   !! check.
   integer, parameter :: short_batch = 20, long_batch = 200

   !> The motion on which a simulation settled. A stable periodic motion has its symbols in standard
   !! order; one within the limits also has its unknowns.
   type, public :: attractor_type
      !> Whether it is a stable periodic motion within the limits.
      logical :: found = .false.
      !> As in vi_survey_outcome.
      integer :: outcome = not_settled
      real(wp) :: r = 0, clearance = 0
      integer :: cycles = 0
      integer, allocatable :: symbols(:)
      !> x_i/D and theta_i of the whole pattern; with rest phase and velocity over D at the last
      !! release, then zeros.
      real(wp), allocatable :: unknowns(:)
   end type attractor_type

   !> The limits of the motions of an atlas, and the largest number of events of a simulation.
   type, public :: limits_type
      integer :: symbols, cycles, max_events
   end type limits_type

contains

   !> The motions on which simulations settle, at points spread evenly over a window.
   subroutine survey(osc, r, clearance, settling, limits, threads, attractors, progress)
      !> Oscillator, the same at all points.
      type(oscillator_type), intent(in) :: osc
      !> The window.
      real(wp), intent(in) :: r(2), clearance(2)
      !> Load cycles of the transient.
      integer, intent(in) :: settling
      !> Limits of the motions kept.
      type(limits_type), intent(in) :: limits
      !> Number of OpenMP threads.
      integer, intent(in) :: threads
      !> (points) Out: the outcome of each point.
      type(attractor_type), intent(inout) :: attractors(:)
      !> As in vi_progress, in units of `survey_work`; points after a stop are not settled.
      integer, intent(inout), optional :: progress(3)
      real(wp) :: u(5), c(2), golden
      integer :: i, j

      call add_expected_work(survey_work*size(attractors), progress)
      golden = 1
      do j = 1, 40
         golden = (1 + golden)**(1.0_wp/6)
      end do
      !$omp parallel do schedule(dynamic, 1) num_threads(threads) private(u, c)
      do i = 1, size(attractors)
         u = [(modulo(0.5_wp + i/golden**j, 1.0_wp), j=1, 5)]
         c = [r(1) + (r(2) - r(1))*u(1), clearance(1)*(clearance(2)/clearance(1))**u(2)]
         attractors(i) = attractor_type(r=c(1), clearance=c(2))
         if (is_stopped(progress)) cycle
         call settle_point(osc, u(3:5), settling, limits, attractors(i), progress)
         call add_done_work(survey_work, progress)
      end do
      !$omp end parallel do
   end subroutine survey

   !> The motion on which one simulation settles.
   !!
   !! It is examined after the transient. A trajectory that is then neither periodic nor certainly
   !! chaotic is examined again, after a longer transient and for longer periods.
   subroutine settle_point(osc, u, settling, limits, attractor, progress)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      !> Three numbers in [0, 1) for the initial state.
      real(wp), intent(in) :: u(3)
      !> Load cycles of the transient.
      integer, intent(in) :: settling
      !> Limits of the motions kept.
      type(limits_type), intent(in) :: limits
      !> In: the point (r, clearance). Out: the outcome.
      type(attractor_type), intent(inout) :: attractor
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(forced_system_type) :: system
      type(state_type) :: state
      type(simulated_pair_type) :: motion
      real(wp) :: size_x
      logical :: chaos
      integer :: status

      system = new_forced_system(osc, attractor%r, 1.0_wp, attractor%clearance)
      size_x = min(system%amplitude, 3*attractor%clearance)
      state%x = size_x*(2*u(1) - 1)
      state%x_dot = size_x*(2*u(2) - 1)
      state%z = state%x + 0.499_wp*attractor%clearance*(2*u(3) - 1)
      call look(osc, system, settling, limits%cycles, limits, state, attractor, progress)
      if (attractor%outcome /= not_settled .and. attractor%outcome /= not_confirmed) return
      if (is_stopped(progress)) return
      motion = new_simulated_pair(system, state, limits%max_events)
      call is_chaotic(motion, short_batch, chaos, status, progress)
      if (.not. chaos .and. status /= stat%event_limit) then
         call look(osc, system, longer*settling, longest_period, limits, state, attractor, progress)
         if (attractor%outcome /= not_settled) return
         motion = new_simulated_pair(system, state, limits%max_events)
         call is_chaotic(motion, long_batch, chaos, status, progress)
      end if
      if (chaos) attractor%outcome = chaotic
      if (status == stat%event_limit) attractor%outcome = event_limit
   end subroutine settle_point

   !> The motion that a simulation from a given state has reached after some load cycles, if it
   !! repeats itself by then.
   subroutine settle_from(osc, start, settling, limits, attractor, progress)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      !> Number of the initial state, as in `state_start`.
      integer, intent(in) :: start
      !> Load cycles of the transient.
      integer, intent(in) :: settling
      !> Limits of the motions kept.
      type(limits_type), intent(in) :: limits
      !> In: the point (r, clearance). Out: the outcome.
      type(attractor_type), intent(inout) :: attractor
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(forced_system_type) :: system
      type(state_type) :: state

      system = new_forced_system(osc, attractor%r, 1.0_wp, attractor%clearance)
      state = initial_state(system, state_start(osc, attractor%r, 1.0_wp, attractor%clearance, &
         start))
      call look(osc, system, settling, limits%cycles, limits, state, attractor, progress)
   end subroutine settle_from

   !> Simulates the transient, then examines the cycles after it.
   subroutine look(osc, system, settling, longest, limits, state, attractor, progress)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      !> The forced system of this point.
      type(forced_system_type), intent(in) :: system
      !> Load cycles of the transient, and of the longest period considered.
      integer, intent(in) :: settling, longest
      !> Limits of the motions kept.
      type(limits_type), intent(in) :: limits
      !> In: at the start. Out: at the end.
      type(state_type), intent(inout) :: state
      !> In: the point. Out: the outcome; `not_settled` also if it was stopped.
      type(attractor_type), intent(inout) :: attractor
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(event_type), allocatable :: events(:)         ! too large for some stacks
      type(period_type), allocatable :: periods(:)
      integer, allocatable :: symbols(:)
      logical :: shorter
      integer :: i, n, left, status

      allocate (events(capacity))
      left = limits%max_events
      attractor%outcome = not_settled
      call run(system, state, settling, left, events, n, status, progress)
      if (status == stat%ok) call run(system, state, 2*longest + 2, left, events, n, status, &
         progress)
      if (status /= stat%ok) then
         if (status /= stat%not_computed) attractor%outcome = event_limit
         return
      end if
      if (n == 0) then
         if (is_free(system, state)) attractor%outcome = no_impacts
         return
      end if
      call read_periods(events(:n), longest, size(events), same_phase, periods)
      do i = 1, size(periods)
         associate (period => periods(i), cycles => periods(i)%cycles)
            attractor%outcome = not_confirmed
            if (period%reading%n <= limits%symbols .and. cycles <= limits%cycles) then
               call identify(osc, system, events, period%reading, cycles, attractor)
               if (attractor%found) attractor%outcome = periodic
               if (attractor%found) return
            end if
            call stable_period(system, state, cycles, symbols, shorter)
            if (shorter) then
               attractor%outcome = not_settled
            else if (size(symbols) > 0) then
               call name_it(osc, symbols, cycles, limits, attractor)
            end if
            ! near a flip the shorter period also nearly repeats itself, but is not stable
            if (shorter .or. size(symbols) > 0) return
         end associate
      end do
   end subroutine look

   !> Simulates some load cycles and keeps the last events.
   subroutine run(system, state, cycles, left, events, n, status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: at the start. Out: at the end.
      type(state_type), intent(inout) :: state
      !> Load cycles to simulate.
      integer, intent(in) :: cycles
      !> As in `simulate_on`.
      integer, intent(inout) :: left
      !> Out: the last n events.
      type(event_type), intent(inout) :: events(:)
      !> Number of events kept; the status is that of `simulate_on`.
      integer, intent(out) :: n, status
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      integer :: done, step

      done = 0
      do
         step = min(cycles - done, between_looks)
         call simulate_cycles(system, state, step, left, events, n, status, progress)
         done = done + step
         if (status /= stat%ok .or. done == cycles) exit
         if (is_stopped(progress)) then
            status = stat%not_computed
            exit
         end if
      end do
   end subroutine run

   !> Records the pattern of a stable motion beyond the limits; one within the limits, which the
   !! equations of its family have not confirmed, becomes periodic if its symbols were read
   !! correctly.
   pure subroutine name_it(osc, symbols, cycles, limits, attractor)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      !> Symbols of the period, beginning with any of them.
      integer, intent(in) :: symbols(:)
      !> Load cycles of the period.
      integer, intent(in) :: cycles
      !> Limits of the motions kept.
      type(limits_type), intent(in) :: limits
      !> In and out: the outcome is changed.
      type(attractor_type), intent(inout) :: attractor
      integer :: standard(size(symbols)), shift
      logical :: mirrored

      call standard_symbols(symbols, abs(osc%restitution(1) - osc%restitution(2)) <= 0, standard, &
         shift, mirrored)
      if (size(symbols) > limits%symbols .or. cycles > limits%cycles) then
         attractor%outcome = beyond
         attractor%cycles = cycles
         attractor%symbols = standard
      else if (allocated(attractor%symbols)) then
         if (size(symbols) == size(attractor%symbols)) attractor%found = &
            all(standard == attractor%symbols)
         if (attractor%found) attractor%outcome = periodic
      end if
   end subroutine name_it

   !> The exact motion of a window of events, in standard order, if it is stable and admissible.
   subroutine identify(osc, system, events, reading, cycles, attractor)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The events.
      type(event_type), intent(in) :: events(:)
      !> Symbols of one period among them.
      type(symbol_sequence_type), intent(in) :: reading
      !> Load cycles of the period.
      integer, intent(in) :: cycles
      !> In: the point. Out: symbols, cycles and unknowns; `found` if it is confirmed.
      type(attractor_type), intent(inout) :: attractor
      integer :: order(reading%n), shift, n, i, side
      logical :: mirrored, resting
      real(wp) :: theta(reading%n), x(reading%n)

      n = reading%n
      if (allocated(attractor%symbols)) deallocate (attractor%symbols, attractor%unknowns)
      allocate (attractor%symbols(n))
      call standard_symbols(reading%symbols(:n), abs(osc%restitution(1) - osc%restitution(2)) &
         <= 0, attractor%symbols, shift, mirrored)
      side = merge(-1, 1, mirrored)
      order = cshift([(i, i=1, n)], shift)
      attractor%cycles = cycles
      resting = any(abs(attractor%symbols) == 2)
      allocate (attractor%unknowns(2*n), source=0.0_wp)
      if (resting) then
         i = reading%last(order(findloc(abs(attractor%symbols), 2, dim=1, back=.true.)))
         attractor%unknowns(:2) = [events(i)%phase + merge(0.5_wp*two_pi, 0.0_wp, mirrored), &
            side*events(i)%x_dot_after/system%clearance]
      else
         do i = 1, n
            x(i) = side*events(reading%first(order(i)))%x/system%clearance
            theta(i) = total_phase(events(reading%first(order(i)))) - system%lag
            if (order(i) < order(1)) theta(i) = theta(i) + two_pi*cycles
         end do
         theta = theta - two_pi*floor(theta(1)/two_pi) + merge(0.5_wp*two_pi, 0.0_wp, mirrored)
         attractor%unknowns = [x, theta]
      end if
      call polish(osc, attractor, resting)
   end subroutine identify

   !> Newton's method for a motion, and whether it is stable and admissible.
   subroutine polish(osc, attractor, resting)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      !> In: the point, symbols, cycles and approximate unknowns. Out: exact unknowns and `found`,
      !! if it is confirmed.
      type(attractor_type), intent(inout) :: attractor
      !> Whether the pattern has rests.
      logical, intent(in) :: resting
      type(curve_type) :: surface
      type(condition_type) :: fixed(2)
      type(condition_type), allocatable :: conditions(:)
      real(wp), allocatable :: point(:), values(:)
      real(wp) :: c(n_parameters)
      logical :: possible
      integer :: n, iterations

      if (size(attractor%symbols) > most_impacts) return
      allocate (surface%edges(0))
      call choose_family(pattern_type(attractor%symbols, attractor%cycles), .false., .true., &
         surface%family, possible)
      c = oscillator_parameters(osc, attractor%r, attractor%clearance)
      surface%c = c
      surface%active = [by_r, by_clearance]
      surface%origin = c(:2)
      surface%scale = [1.0_wp, 1.0_wp]
      fixed = [condition_type(edge, by_r, 1, bound=c(1)), &
         condition_type(edge, by_clearance, 1, bound=c(2))]
      n = surface%family%unknown_count()
      point = [surface%family%part_of(c, attractor%unknowns), 0.0_wp, 0.0_wp]
      call correct(surface, fixed, point, iterations)
      if (iterations == 0) return
      allocate (values(condition_count(surface)), conditions(condition_count(surface)))
      call all_conditions(surface, point(:n), c, values, conditions)
      ! a motion that repeats itself may still be stable
      if (.not. all(values > 0 .or. conditions%kind == repetition)) return
      if (resting) then
         attractor%unknowns(:2) = [point(1), sinh(point(2))]
      else
         attractor%unknowns(:n) = point(:n)
      end if
      attractor%found = .true.
   end subroutine polish

end module vi_survey
