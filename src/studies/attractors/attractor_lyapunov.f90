!> Lyapunov exponents through impacts, accumulations and rests.
!!
!! Four directions are carried from event to event by the exact derivatives and orthonormalised
!! after each. The sums of the logarithms of their lengths, over the time, are the exponents. They
!! belong to the map from impact to impact in (x, x', z', alpha), which has no direction along the
!! flow. They are therefore also the four exponents of the map over one load cycle.
!!
!! The contraction of volume is a check: the flux |y'| dx dx' dz' dalpha through a wall shrinks by
!! exp(-2 xi t) over a flight, and an impact multiplies dx' dz' by R, hence
!! |det P_i| = exp(-2 xi t) R u/v with the departure speed u at the start and the approach speed v
!! at the end of the flight. As u = R v at each impact, the sum of the logarithms telescopes to
!! -2 xi t + 2 sum(log R) + log(u_first/u_last).
module vi_attractor_lyapunov
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_attractor_tangent, only: departure_speed, event_derivative, lapse, restitution_at
   use vi_exponents, only: bump, kaplan_yorke, orthonormalise, scatter
   use vi_forced_system, only: forced_system_type, event_type, impact_event, new_forced_system, &
      release_event, state_type
   use vi_kinds, only: two_pi, wp
   use vi_oscillator, only: oscillator_type
   use vi_simulate, only: simulate_on
   use vi_status, only: stat
   use vi_progress, only: add_expected_work, add_done_work, is_stopped
   use vi_trajectory, only: unpack_state
   implicit none (type, external)
   private

   public :: exponents_on, is_chaotic, largest_exponent, lyapunov_points

   !> Chaos: least values of the largest exponent per load cycle, and of its ratio to its standard
   !! error.
   real(wp), parameter :: least_chaos = 2.0e-3_wp, least_ratio = 4

   !> Directions at an event, and the sums so far.
   type :: tangent_type
      logical :: begun = .false.
      type(event_type) :: event
      real(wp) :: q(4, 4) = 0
      !> Number of directions that are not lost.
      integer :: rank = 4
      !> Difference between the sum of the logarithms and that from the volume, and the time so far.
      real(wp) :: difference = 0, time = 0
      !> Impacts and rests.
      integer :: counts(2) = 0
   end type tangent_type

   integer, parameter :: chunk = 64

contains

   !> The exponents at m points, from batches of time; a batch before them is not counted.
   subroutine lyapunov_points(osc, r, load, clearance, states, contacts, discard, cycles, batches, &
      max_events, threads, exponents, deviations, dimensions, counts, errors, status, progress)
      !> Oscillator, the same at all points.
      type(oscillator_type), intent(in) :: osc
      !> (m) each
      real(wp), intent(in) :: r(:), load(:), clearance(:)
      !> (7, m), (3, m): initial states as in `pack_state`.
      real(wp), intent(in) :: states(:, :)
      !> (3, m): of the initial states, as in `pack_state`.
      integer, intent(in) :: contacts(:, :)
      !> Load cycles before the first batch, and in each batch.
      integer, intent(in) :: discard, cycles
      !> Batches that count, at least 2, largest number of events at a point, and number of OpenMP
      !! threads.
      integer, intent(in) :: batches, max_events, threads
      !> (4, m): per unit of time, -inf for directions that are lost; standard errors from the
      !! scatter of the batches.
      real(wp), intent(out) :: exponents(:, :), deviations(:, :)
      !> (m): Kaplan-Yorke dimensions.
      real(wp), intent(out) :: dimensions(:)
      !> (2, m): impacts and rests.
      integer, intent(out) :: counts(:, :)
      !> (m): difference between the sum of the logarithms and that from the volume, per unit of
      !! time.
      real(wp), intent(out) :: errors(:)
      !> (m): `stat%no_motion` if a batch has too few events, `stat%event_limit` if there are too
      !! many, `stat%not_computed` if stopped first.
      integer, intent(out) :: status(:)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      integer :: j

      call add_expected_work(size(r)*(batches + 1), progress)
      !$omp parallel do schedule(dynamic, 1) num_threads(threads)
      do j = 1, size(r)
         if (is_stopped(progress)) then
            status(j) = stat%not_computed
            cycle
         end if
         call exponents_of(new_forced_system(osc, r(j), load(j), clearance(j)), &
            unpack_state(states(:, j), contacts(:, j)), discard, cycles, batches, max_events, &
            exponents(:, j), deviations(:, j), dimensions(j), counts(:, j), errors(j), 1, &
            status(j), progress)
      end do
      !$omp end parallel do
   end subroutine lyapunov_points

   !> The largest exponent per load cycle of one trajectory, and its standard error.
   subroutine largest_exponent(system, start, discard, cycles, batches, max_events, largest, &
      deviation, status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> State at the start.
      type(state_type), intent(in) :: start
      !> Load cycles before the first batch, which is not counted, and in each.
      integer, intent(in) :: discard, cycles
      !> Batches that count, at least 2, and largest number of events.
      integer, intent(in) :: batches, max_events
      !> The exponent per load cycle, and its standard error; NaN if the status is not `stat%ok`.
      real(wp), intent(out) :: largest, deviation
      !> As in `lyapunov_points`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      real(wp) :: exponents(4), deviations(4), dimension, error
      integer :: counts(2)

      call exponents_of(system, start, discard, cycles, batches, max_events, exponents, &
         deviations, dimension, counts, error, 0, status, progress)
      largest = exponents(1)*(two_pi/system%r)
      deviation = deviations(1)*(two_pi/system%r)
   end subroutine largest_exponent

   !> The exponents of one trajectory, and their standard errors from its batches.
   subroutine exponents_of(system, start, discard, cycles, batches, max_events, exponents, &
      deviations, dimension, counts, error, work, status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> State at the start.
      type(state_type), intent(in) :: start
      !> Load cycles before the first batch, load cycles in each batch, and batches that count.
      integer, intent(in) :: discard, cycles, batches
      !> Largest number of events.
      integer, intent(in) :: max_events
      !> Exponents per unit of time, -inf in lost directions; their standard errors; Kaplan-Yorke
      !! dimension. NaN if the status is not `stat%ok`.
      real(wp), intent(out) :: exponents(4), deviations(4), dimension
      !> Impacts and rests.
      integer, intent(out) :: counts(2)
      !> As `errors` in `lyapunov_points`.
      real(wp), intent(out) :: error
      !> Units of work of a batch in the progress counters.
      integer, intent(in) :: work
      !> As in `lyapunov_points`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(state_type) :: state
      real(wp) :: each(4, 0:batches)
      integer :: left, rank

      state = start
      left = max_events
      call carry_along(system, state, discard, cycles, left, each, rank, counts, error, work, &
         status, progress)
      if (status /= stat%ok) then
         exponents = ieee_value(error, ieee_quiet_nan)
         deviations = exponents
         dimension = exponents(1)
         return
      end if
      exponents = each(:, 0)
      call scatter(each(:, 1:), rank, exponents, deviations)
      dimension = kaplan_yorke(exponents)
   end subroutine exponents_of

   !> The exponents per load cycle of a trajectory that goes on, and their standard errors.
   subroutine exponents_on(system, state, cycles, batches, left, exponents, deviations, rank, &
      status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: state at the start. Out: at the end.
      type(state_type), intent(inout) :: state
      !> Load cycles of each batch, and batches that count, at least 2; one more is before them.
      integer, intent(in) :: cycles, batches
      !> In: number of events that the simulation may still have. Out: minus those found.
      integer, intent(inout) :: left
      !> The exponents per load cycle, the greatest first, and their standard errors; those of lost
      !! directions are -inf. Undefined if the status is not `stat%ok`.
      real(wp), intent(out) :: exponents(4), deviations(4)
      !> Directions that are not lost.
      integer, intent(out) :: rank
      !> As in `lyapunov_points`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      real(wp) :: each(4, 0:batches), error
      integer :: counts(2)

      call carry_along(system, state, 0, cycles, left, each, rank, counts, error, 0, status, &
         progress)
      exponents = each(:, 0)
      call scatter(each(:, 1:), rank, exponents, deviations)
      exponents = exponents*(two_pi/system%r)
      deviations = deviations*(two_pi/system%r)
   end subroutine exponents_on

   !> The averages over all batches together and over each batch, along a trajectory.
   subroutine carry_along(system, state, discard, cycles, left, exponents, rank, counts, error, &
      work, status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: state at the start. Out: at the end.
      type(state_type), intent(inout) :: state
      !> Load cycles before the first batch, and in each.
      integer, intent(in) :: discard, cycles
      !> As in `simulate_on`.
      integer, intent(inout) :: left
      !> (4, 1 + batches): of all batches together, then of each.
      real(wp), intent(out) :: exponents(:, :)
      !> Directions that are not lost; impacts and rests.
      integer, intent(out) :: rank, counts(2)
      !> As `errors` in `lyapunov_points`.
      real(wp), intent(out) :: error
      !> Units of work of a batch in the progress counters.
      integer, intent(in) :: work
      !> As in `lyapunov_points`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(state_type) :: final
      type(event_type) :: events(chunk)
      type(tangent_type) :: tangent
      integer(int64) :: first, last
      integer :: n, batch, i
      real(wp) :: begin, done
      real(wp) :: sums(5, 2)

      exponents = 0
      begin = state%phase
      last = state%cycle + discard
      do
         call simulate_on(system, state, last, begin, events, n, final, left, status, &
            progress)
         if (status /= stat%more_events) exit
      end do
      first = last + cycles
      sums = 0
      do batch = 1, size(exponents, 2)
         if (status /= stat%ok) exit
         last = last + cycles
         sums(:, 2) = 0
         do
            call simulate_on(system, state, last, begin, events, n, final, left, status, &
               progress)
            do i = 1, n
               done = real(events(i)%cycle - first, wp) + (events(i)%phase - begin)/two_pi
               call carry(system, events(i), [bump(done/(cycles*(size(exponents, 2) - 1))), &
                  bump((done + cycles)/cycles - (batch - 1))], tangent, sums)
            end do
            if (is_stopped(progress)) status = stat%not_computed
            if (status /= stat%more_events) exit
         end do
         call add_done_work(work, progress)
         if (batch == 1) then
            tangent%counts = 0                        ! not counted: the directions still settle
            tangent%difference = 0
            tangent%time = 0
            cycle
         end if
         if (.not. sums(5, 2) > 0) then
            if (status == stat%ok) status = stat%no_motion
            exit
         end if
         exponents(:, batch) = sums(:4, 2)/sums(5, 2)
      end do
      state = final
      if (status == stat%ok) exponents(:, 1) = sums(:4, 1)/sums(5, 1)
      rank = tangent%rank
      counts = tangent%counts
      error = abs(tangent%difference)/max(tangent%time, tiny(1.0_wp))
   end subroutine carry_along

   !> Carries the directions to the next event and adds the logarithms of their growth.
   pure subroutine carry(system, event, weights, tangent, sums)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The event.
      type(event_type), intent(in) :: event
      !> Weights in the average over all batches together, and over this batch.
      real(wp), intent(in) :: weights(2)
      !> In: at the previous event. Out: at this event.
      type(tangent_type), intent(inout) :: tangent
      !> (.., average): weighted sums of the four logarithms and of the time.
      real(wp), intent(inout) :: sums(5, 2)
      real(wp) :: p(4, 4), lengths(4)
      logical :: regular
      integer :: j

      if (.not. tangent%begun) then
         tangent%begun = .true.
         tangent%q = reshape([(merge(1.0_wp, 0.0_wp, modulo(j, 5) == 0), j=0, 15)], [4, 4])
         tangent%event = event
         return
      end if
      call event_derivative(system, tangent%event, event, p, regular)
      if (regular) then
         tangent%q = matmul(p, tangent%q)
         call orthonormalise(tangent%q, lengths)
         if (event%kind == release_event) tangent%rank = min(tangent%rank, 2)
         if (event%kind == impact_event .and. .not. restitution_at(system, event) > 0) then
            tangent%rank = min(tangent%rank, 3)
         end if
         do j = 1, tangent%rank
            sums(j, :) = sums(j, :) + weights*log(max(lengths(j), tiny(1.0_wp)))
         end do
         sums(5, :) = sums(5, :) + weights*lapse(system, tangent%event, event)
         call compare(system, event, lengths, tangent)
      end if
      tangent%time = tangent%time + lapse(system, tangent%event, event)
      if (event%kind == impact_event) tangent%counts(1) = tangent%counts(1) + 1
      if (event%kind == release_event) tangent%counts(2) = tangent%counts(2) + 1
      tangent%event = event
   end subroutine carry

   !> Adds, over a flight, to the difference between the logarithms and those from the volume.
   pure subroutine compare(system, event, lengths, tangent)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The impact that ends the flight.
      type(event_type), intent(in) :: event
      !> Growth of each direction over the flight.
      real(wp), intent(in) :: lengths(4)
      !> In and out: the sum of the differences.
      type(tangent_type), intent(inout) :: tangent
      real(wp) :: speeds(2), restitution

      if (event%kind /= impact_event .or. tangent%event%kind == release_event) return
      restitution = restitution_at(system, event)
      speeds = [departure_speed(tangent%event), departure_speed(event)]
      if (.not. minval([restitution, speeds, lengths]) > 0) return
      tangent%difference = tangent%difference + sum(log(lengths)) + 2*system%osc%xi* &
         lapse(system, tangent%event, event) - 2*log(restitution) - log(speeds(1)/speeds(2))
   end subroutine compare

   !> Whether the largest Lyapunov exponent of a trajectory is positive by more than its error.
   subroutine is_chaotic(system, state, cycles, max_events, chaos, status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> State at the start.
      type(state_type), intent(in) :: state
      !> Load cycles of each of ten batches, and largest number of events of all.
      integer, intent(in) :: cycles, max_events
      !> Whether the trajectory is chaotic; false also if the simulation failed.
      logical, intent(out) :: chaos
      !> As in `lyapunov_points`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      real(wp) :: largest, deviation

      call largest_exponent(system, state, 0, cycles, 10, max_events, largest, deviation, status, &
         progress)
      chaos = status == stat%ok
      if (chaos) chaos = largest > least_chaos .and. largest > least_ratio*deviation
   end subroutine is_chaotic

end module vi_attractor_lyapunov
