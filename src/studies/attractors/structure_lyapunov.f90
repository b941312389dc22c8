!> Lyapunov exponents of a structure, through impacts, accumulations and rests.
!!
!! Directions are carried from event to event by the exact derivatives and orthonormalised after
!! each. The logarithms of their growth over whole periods of the load give the exponents of the map
!! over a period. The contraction of volume is a check: the sum of all logarithms is that of
!! exp(-tr(M^-1 C) t) and of R (R + R' v) over the impacts.
module vi_structure_lyapunov
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_exponents, only: bump, kaplan_yorke, orthonormalise, scatter
   use vi_kinds, only: wp
   use vi_progress, only: add_done_work, add_expected_work, is_stopped
   use vi_status, only: stat
   use vi_structure, only: load_type, restitution_of, structure_type
   use vi_structure_map, only: from_coordinates, to_coordinates
   use vi_structure_run, only: impact_event, new_run, run_event_type, run_state_type, run_type, &
      simulate_structure, start_at, state_now, stick_event
   use vi_structure_variation, only: start_tangent, tangent_type, through_event, to_state
   implicit none (type, external)
   private

   public :: structure_exponents

   !> What an average needs: how long, and when it is given up.
   type, public :: average_type
      !> Periods of the load before the first batch and in each; batches that count, at least 2.
      integer :: discard = 0, cycles = 0, batches = 2
      !> Number of directions, at most 2n; largest number of events.
      integer :: directions = 0, max_events = huge(1)
   end type average_type

   !> The exponents of a simulation.
   type, public :: exponents_type
      !> (directions) Per unit of time, the greatest first; -inf for directions that are lost. Their
      !! standard errors from the scatter of the batches.
      real(wp), allocatable :: exponents(:), deviations(:)
      !> Dimension of Kaplan and Yorke, and the error of the sum of the exponents per unit of time;
      !! NaN unless all directions are carried, and the error also if some are lost.
      real(wp) :: dimension = 0, error = 0
      !> Mean rate at which volumes contract, for each of the 2n directions; of those that are lost
      !! only what the damping contributes.
      real(wp) :: contraction = 0
      !> Impacts and rests in the batches that count; unit of time of a period.
      integer :: impacts = 0, rests = 0
      real(wp) :: period = 0
   end type exponents_type

   !> The directions, and what they have done in the present period.
   type :: growth_type
      type(tangent_type) :: tangent
      !> (directions) Logarithms of their growth; number of directions that are not lost.
      real(wp), allocatable :: logs(:)
      integer :: rank = 0
      !> What the impacts make of the logarithm of the volume; numbers of impacts and rests.
      real(wp) :: shrinking = 0
      integer :: impacts = 0, rests = 0
   end type growth_type

   integer, parameter :: chunk = 64

contains

   !> The exponents of the motion that begins at a state.
   subroutine structure_exponents(structure, load, start, q, rate, average, found, status, &
      progress, finish)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> Time, coordinates (n) and velocities (n) at the start.
      real(wp), intent(in) :: start, q(:), rate(:)
      !> How long to average.
      type(average_type), intent(in) :: average
      !> The exponents.
      type(exponents_type), intent(out) :: found
      !> `stat%ok`; `stat%event_limit`, `stat%not_computed` if it was stopped, or a status of the
      !! simulation.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      !> (2n) Coordinates and velocities at the end, whole periods of the load after the start.
      real(wp), intent(inout), optional :: finish(:)
      type(run_type) :: run
      type(run_state_type) :: state
      type(run_event_type), allocatable :: events(:)
      type(growth_type) :: growth
      real(wp), allocatable :: sums(:), parts(:, :)
      real(wp) :: weights, part_weights(average%batches), difference, shrinking
      integer :: batch, i, left, n

      n = size(q)
      call add_expected_work(average%batches + 1, progress)
      call new_run(structure, load, run, status)
      if (status /= stat%ok) return
      call start_at(run, start, q, rate, state, status)
      if (status /= stat%ok) return
      found%period = run%period
      left = average%max_events
      allocate (events(chunk))
      allocate (growth%logs(average%directions), source=0.0_wp)
      growth%rank = average%directions
      call begin(run, state, growth)
      ! the directions settle in the transient and in a batch that does not count
      do i = 1, average%discard + average%cycles
         ! a rest in the transient may have lost directions that the attractor has
         if (i == average%discard + 1 .and. growth%rank < average%directions) call begin(run, &
            state, growth)
         call one_period(run, state, events, left, growth, status, progress)
         if (status /= stat%ok) return
      end do
      call add_done_work(1, progress)
      growth%impacts = 0
      growth%rests = 0
      allocate (sums(average%directions), parts(average%directions, average%batches), source=0.0_wp)
      weights = 0
      part_weights = 0
      difference = 0
      shrinking = 0
      do batch = 1, average%batches
         do i = 1, average%cycles
            growth%logs = 0
            growth%shrinking = 0
            call one_period(run, state, events, left, growth, status, progress)
            if (status /= stat%ok) return
            difference = difference + sum(growth%logs) - growth%shrinking + 2*sum( &
               run%regimes(1)%modes%damping)*run%period
            shrinking = shrinking + growth%shrinking
            associate (of_part => bump((i - 0.5_wp)/average%cycles), of_all => bump((i - 0.5_wp + &
               (batch - 1)*real(average%cycles, wp))/(real(average%cycles, wp)*average%batches)))
               parts(:, batch) = parts(:, batch) + of_part*growth%logs
               part_weights(batch) = part_weights(batch) + of_part
               sums = sums + of_all*growth%logs
               weights = weights + of_all
            end associate
         end do
         call add_done_work(1, progress)
      end do
      allocate (found%exponents, source=sums/(weights*run%period))
      allocate (found%deviations(average%directions))
      call scatter(parts/spread(part_weights*run%period, 1, average%directions), growth%rank, &
         found%exponents, found%deviations)
      found%impacts = growth%impacts
      found%rests = growth%rests
      found%contraction = (2*sum(run%regimes(1)%modes%damping) - shrinking/(run%period* &
         average%cycles*real(average%batches, wp)))/(2*n)
      if (present(finish)) call state_now(run, state, finish(:n), finish(n + 1:))
      found%dimension = ieee_value(1.0_wp, ieee_quiet_nan)
      found%error = found%dimension
      if (average%directions < 2*n) return
      found%dimension = kaplan_yorke(found%exponents)
      if (growth%rank == 2*n) found%error = abs(difference)/(run%period*average%cycles* &
         real(average%batches, wp))
   end subroutine structure_exponents

   !> Directions at a state; none is along a single coordinate, which could be independent of all
   !! others.
   pure subroutine begin(run, state, growth)
      !> The run.
      type(run_type), intent(in) :: run
      !> The state.
      type(run_state_type), intent(in) :: state
      !> In and out: with its number of directions.
      type(growth_type), intent(inout) :: growth
      real(wp), allocatable :: p(:, :)
      real(wp) :: lengths(size(growth%logs))
      integer :: i, j

      allocate (p(2*size(run%structure%mass, 1), size(growth%logs)))
      do j = 1, size(p, 2)
         do i = 1, size(p, 1)
            p(i, j) = cos(real(i*j, wp))
         end do
      end do
      call orthonormalise(p, lengths)
      call start_tangent(run, state, p, growth%tangent)
      growth%rank = min(size(growth%logs), 2*size(state%x))
   end subroutine begin

   !> Simulates a period of the load, and carries the directions along.
   subroutine one_period(run, state, events, left, growth, status, progress)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> Room for events.
      type(run_event_type), intent(inout) :: events(:)
      !> In and out: events until it is given up.
      integer, intent(inout) :: left
      !> In and out: the directions, and what is added to their sums.
      type(growth_type), intent(inout) :: growth
      !> As of `structure_exponents`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      integer(int64) :: last
      real(wp) :: elapsed
      integer :: i, n, ended

      last = state%cycle + 1
      elapsed = state%elapsed
      do
         call simulate_structure(run, state, last, elapsed, events, n, ended, .true.)
         status = merge(stat%ok, ended, ended == stat%more_events)
         left = left - n
         do i = 1, n
            call follow(run, events(i), growth)
         end do
         if (status == stat%ok .and. left < 0) status = stat%event_limit
         if (is_stopped(progress)) status = stat%not_computed
         if (status /= stat%ok) return
         if (ended /= stat%more_events) exit
      end do
      call to_state(run, state, growth%tangent)
      call measure(run, growth)
   end subroutine one_period

   !> Carries the directions through an event.
   subroutine follow(run, event, growth)
      !> The run.
      type(run_type), intent(in) :: run
      !> The event.
      type(run_event_type), intent(in) :: event
      !> In and out: the directions.
      type(growth_type), intent(inout) :: growth
      real(wp) :: restitution, slope, factor
      integer :: status

      call through_event(run, event, growth%tangent, status)
      if (event%kind == impact_event .and. status == stat%ok) then
         call restitution_of(run%structure, event%gap, event%speed, restitution, slope)
         factor = abs(restitution*(restitution + slope*event%speed))
         if (factor > 0) then
            growth%shrinking = growth%shrinking + log(factor)
         else
            growth%rank = min(growth%rank, 2*size(run%structure%mass, 1) - 1)
         end if
      end if
      if (event%kind == impact_event) growth%impacts = growth%impacts + 1
      if (event%kind == stick_event) growth%rests = growth%rests + 1
      ! at rest there are fewer pairs
      growth%rank = min(growth%rank, 2*size(event%x))
      call measure(run, growth)
   end subroutine follow

   !> Adds the logarithms of the growth of the directions, and makes these orthonormal in the pairs
   !! of the structure without rest.
   subroutine measure(run, growth)
      !> The run.
      type(run_type), intent(in) :: run
      !> In and out: the directions.
      type(growth_type), intent(inout) :: growth
      real(wp), allocatable :: p(:, :), free(:, :)
      real(wp) :: lengths(size(growth%logs))

      associate (d => growth%tangent%d, regime => run%regimes(growth%tangent%number))
         if (growth%tangent%number == 1) then
            call orthonormalise(d, lengths)
         else
            allocate (p(2*size(run%structure%mass, 1), size(d, 2)))
            allocate (free(2*size(run%regimes(1)%xq, 1), size(d, 2)))
            call to_coordinates(regime, d, p)
            call from_coordinates(run%regimes(1), p, free)
            call orthonormalise(free, lengths)
            call to_coordinates(run%regimes(1), free, p)
            call from_coordinates(regime, p, d)
         end if
      end associate
      associate (rank => growth%rank)
         growth%logs(:rank) = growth%logs(:rank) + log(max(lengths(:rank), tiny(1.0_wp)))
      end associate
   end subroutine measure

end module vi_structure_lyapunov
