!> The motion on which a simulation of a structure settles: last impacts, period if any, extremes
!! and mean squares of the coordinates. With stops or friction every event counts as an impact but
!! rests and releases.
module vi_structure_settled
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   use vi_modes, only: advance
   use vi_progress, only: is_stopped
   use vi_restitution, only: friction_law
   use vi_simulated_motion, only: cell_type, examination_type
   use vi_status, only: stat
   use vi_structure, only: load_type, state_of, structure_type
   use vi_structure_extremes, only: turning_share
   use vi_structure_path, only: changed, structure_path_type
   use vi_structure_return, only: confirmed_cycles, is_steady, most_events, one_cycle, repetition, &
      some_cycles
   use vi_structure_run, only: is_listed, new_run, run_event_type, run_state_type, run_type, &
      state_now, stick_event
   implicit none (type, external)
   private

   public :: settle_structure, steady_size

   !> Extremes and integrals of squares of the coordinates and outputs, and the time so far.
   type :: size_type
      real(wp), allocatable :: outputs(:, :)
      real(wp), allocatable, dimension(:) :: low, high, squares
      real(wp) :: time = 0
   end type size_type

   !> Panels per unit of time of the structure, and their most in a flight.
   integer, parameter :: density = 4, most_panels = 100000
   !> Nodes and weights of Gauss for four points in [0, 1].
   real(wp), parameter :: nodes(4) = 0.5_wp + 0.5_wp*[-0.861136311594052575_wp, &
      -0.339981043584856265_wp, 0.339981043584856265_wp, 0.861136311594052575_wp]
   real(wp), parameter :: weights(4) = 0.5_wp*[0.347854845137453857_wp, 0.652145154862546143_wp, &
      0.652145154862546143_wp, 0.347854845137453857_wp]

contains

   !> Simulates the transient, and examines the load cycles after it.
   subroutine settle_structure(run, state, outputs, how, cell, progress)
      !> In and out: the structure under its load; regimes are added.
      type(run_type), intent(inout) :: run
      !> In: state at load phase 0. Out: state at the end.
      type(run_state_type), intent(inout) :: state
      !> (outputs, n) Outputs whose sizes are measured, as sums of the coordinates.
      real(wp), intent(in) :: outputs(:, :)
      !> How it is examined.
      type(examination_type), intent(in) :: how
      !> In: empty. Out: what was found.
      type(cell_type), intent(inout) :: cell
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      real(wp), parameter :: near = 1.0e-4_wp, at_rounding = 1.0e-9_wp
      type(run_state_type), allocatable :: before
      type(run_event_type), allocatable :: events(:)
      type(size_type) :: sizes
      real(wp), allocatable :: strobes(:, :)
      real(wp) :: hits(2, how%points)
      integer :: counts(how%keep), gaps(how%points), kinds(how%points), rests(how%keep), first, i, &
         k, kept, left, m, n, repeats
      logical :: exactly

      m = size(run%structure%mass, 1)
      allocate (events(most_events), strobes(2*m, 0:how%keep))
      left = how%max_events
      call some_cycles(run, state, 0.0_wp, how%settling, left, events, strobes(:, :0), &
         cell%status, progress)
      if (cell%status /= stat%ok) return
      call state_now(run, state, strobes(:m, 0), strobes(m + 1:, 0))
      call new_sizes(outputs, sizes)
      kept = 0
      do i = 1, how%keep
         before = state
         call one_cycle(run, state, 1, 0.0_wp, events, n, cell%status, progress)
         left = left - n
         if (cell%status == stat%ok .and. left < 0) cell%status = stat%event_limit
         if (is_stopped(progress)) cell%status = stat%not_computed
         if (cell%status /= stat%ok) exit
         call state_now(run, state, strobes(:m, i), strobes(m + 1:, i))
         call measure_cycle(run, before, events(:n), state, sizes)
         counts(i) = count(is_listed(events(:n)))
         rests(i) = count(events(:n)%kind == stick_event)
         do k = 1, n
            if (.not. is_listed(events(k)) .or. kept >= how%points) cycle
            kept = kept + 1
            gaps(kept) = events(k)%gap
            kinds(kept) = events(k)%kind
            hits(:, kept) = [run%load%frequency*events(k)%elapsed, events(k)%speed]
         end do
      end do
      cell%gaps = gaps(:kept)
      cell%kinds = kinds(:kept)
      cell%hits = hits(:, :kept)
      if (cell%status /= stat%ok) return
      cell%extent(:, 1) = sizes%low
      cell%extent(:, 2) = sizes%high
      cell%extent(:, 3) = sqrt(sizes%squares/sizes%time)
      k = (how%keep - 1)/2
      call repetition(strobes(:, how%keep - 2*k:), k, at_rounding, repeats)
      exactly = repeats > 0
      if (.not. exactly) call repetition(strobes(:, how%keep - 2*k:), k, near, repeats)
      call confirm(run, state, repeats, exactly, counts, events, cell%cycles, progress)
      first = 1
      if (cell%cycles > 0) first = how%keep - cell%cycles + 1
      cell%impacts = sum(counts(first:))
      cell%rests = sum(rests(first:))
      cell%strobes = strobes(:, merge(first, how%keep, how%strobes):how%keep)
   end subroutine settle_structure

   !> The shortest period of the motion on which a simulation has settled.
   !!
   !! A simulation that approaches a motion slowly, or leaves one that is not stable, nearly repeats
   !! itself, possibly only after several periods: Newton's method has to confirm a stable motion.
   subroutine confirm(run, state, repeats, exactly, counts, events, cycles, progress)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> The state at the end.
      type(run_state_type), intent(in) :: state
      !> Load cycles after which it repeats itself; 0 if it does not.
      integer, intent(in) :: repeats
      !> Whether it does so to rounding.
      logical, intent(in) :: exactly
      !> (cycles examined) Impacts in each.
      integer, intent(in) :: counts(:)
      !> Room for events.
      type(run_event_type), intent(inout) :: events(:)
      !> Load cycles of the period; 0 if it is not confirmed.
      integer, intent(out) :: cycles
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      integer :: impacts, n

      cycles = 0
      if (repeats == 0) return
      n = size(counts)
      if (sum(counts(n - repeats + 1:)) == 0) then
         if (is_steady(run, state)) cycles = 1
         return
      end if
      call confirmed_cycles(run%structure, run, state, 0.0_wp, repeats, exactly, events, cycles, &
         impacts, progress)
      ! the simulation may still hit a gap more or less often than the motion
      if (impacts >= 0 .and. sum(counts(n - cycles + 1:)) /= impacts) cycles = 0
   end subroutine confirm

   !> Adds the flights and rests of a load cycle.
   pure subroutine measure_cycle(run, before, events, after, sizes)
      !> The run.
      type(run_type), intent(in) :: run
      !> The states at its beginning and its end.
      type(run_state_type), intent(in) :: before, after
      !> Its events.
      type(run_event_type), intent(in) :: events(:)
      !> In and out: the sums.
      type(size_type), intent(inout) :: sizes
      integer(int64) :: cycle
      real(wp) :: elapsed
      integer :: i, number
      real(wp), allocatable :: x(:), v(:)

      number = before%regime
      cycle = before%cycle
      elapsed = before%elapsed
      allocate (x, source=before%x)
      allocate (v, source=before%v)
      do i = 1, size(events)
         associate (event => events(i))
            call measure(run, number, run%load%frequency*elapsed, real(event%cycle - cycle, wp)* &
               run%period + (event%elapsed - elapsed), x, v, sizes)
            number = event%regime
            cycle = event%cycle
            elapsed = event%elapsed
            x = event%x
            v = event%v
         end associate
      end do
      call measure(run, number, run%load%frequency*elapsed, real(after%cycle - cycle, wp)* &
         run%period + (after%elapsed - elapsed), x, v, sizes)
   end subroutine measure_cycle

   !> Adds a flight or rest: extremes where cubics through nodes close together turn,
   !! squares by Gauss's rule.
   pure subroutine measure(run, number, phase, duration, x, v, sizes)
      !> The run, and the number of its regime.
      type(run_type), intent(in) :: run
      integer, intent(in) :: number
      !> Load phase (rad) at its beginning, and its duration.
      real(wp), intent(in) :: phase, duration
      !> (m) The pairs at its beginning.
      real(wp), intent(in) :: x(:), v(:)
      !> In and out: the sums.
      type(size_type), intent(inout) :: sizes
      real(wp), dimension(size(sizes%low)) :: q, rate, last, last_rate, there, rate_there
      real(wp) :: pairs(size(x), 2)
      real(wp) :: h, share, turned
      integer :: i, j, k, panels

      if (.not. duration > 0) return
      associate (regime => run%regimes(number))
         panels = max(1, ceiling(min(real(most_panels, wp), density*duration/regime%unit)))
         h = duration/panels
         do i = 0, panels
            call values_after(run, number, sizes%outputs, phase, i*h, x, v, pairs, q, &
               rate)
            sizes%low = min(sizes%low, q)
            sizes%high = max(sizes%high, q)
            if (i > 0) then
               do j = 1, size(q)
                  if (.not. last_rate(j)*rate(j) < 0) cycle
                  call turning_share(last(j), q(j), h*last_rate(j), h*rate(j), share)
                  call values_after(run, number, sizes%outputs, phase, (i - 1 + share)*h, x, v, &
                     pairs, there, rate_there)
                  ! the velocity that is left there changes the extreme by its square
                  turned = there(j) - 0.5_wp*rate_there(j)**2*h/(rate(j) - last_rate(j))
                  sizes%low(j) = min(sizes%low(j), turned)
                  sizes%high(j) = max(sizes%high(j), turned)
               end do
            end if
            last = q
            last_rate = rate
            if (i == panels) exit
            do k = 1, size(nodes)
               call values_after(run, number, sizes%outputs, phase, (i + nodes(k))*h, x, v, &
                  pairs, q, rate)
               sizes%squares = sizes%squares + weights(k)*h*q**2
            end do
         end do
      end associate
      sizes%time = sizes%time + duration
   end subroutine measure

   !> Coordinates and outputs, and their velocities, in a flight or rest.
   pure subroutine values_after(run, number, outputs, phase, time, x, v, pairs, q, &
      rate)
      !> The run, and the number of its regime.
      type(run_type), intent(in) :: run
      integer, intent(in) :: number
      !> (outputs, n) Outputs as sums of the coordinates.
      real(wp), intent(in) :: outputs(:, :)
      !> Load phase (rad) at its beginning, and the time since then.
      real(wp), intent(in) :: phase, time
      !> (m) The pairs at its beginning.
      real(wp), intent(in) :: x(:), v(:)
      !> (m, 2) Room for the pairs then.
      real(wp), contiguous, intent(inout) :: pairs(:, :)
      !> (n + outputs)
      real(wp), contiguous, intent(out) :: q(:), rate(:)
      integer :: i

      associate (regime => run%regimes(number), n => size(outputs, 2))
         call advance(regime%modes, time, x, v, pairs(:, 1), pairs(:, 2))
         call state_of(regime, phase + run%load%frequency*time, pairs(:, 1), pairs(:, 2), q(:n), &
            rate(:n))
         do i = 1, size(outputs, 1)
            q(n + i) = dot_product(outputs(i, :), q(:n))
            rate(n + i) = dot_product(outputs(i, :), rate(:n))
         end do
      end associate
   end subroutine values_after

   !> Extremes and integrals over no time.
   pure subroutine new_sizes(outputs, sizes)
      !> (outputs, n) Outputs as sums of the coordinates.
      real(wp), intent(in) :: outputs(:, :)
      !> The sums.
      type(size_type), intent(out) :: sizes

      allocate (sizes%outputs, source=outputs)
      associate (m => sum(shape(outputs)))
         allocate (sizes%squares(m), source=0.0_wp)
         allocate (sizes%low(m), source=huge(1.0_wp))
         allocate (sizes%high(m), source=-huge(1.0_wp))
      end associate
   end subroutine new_sizes

   !> Greatest magnitudes and roots of mean squares of the steady motion without impacts, contacts
   !! with stops and friction; NaN if there is none.
   subroutine steady_size(path, share, outputs, largest, rms)
      !> The structure and its load as functions of the parameter.
      type(structure_path_type), intent(in) :: path
      !> The parameter, as a share of the way between its bounds.
      real(wp), intent(in) :: share
      !> (outputs, n) Outputs as sums of the coordinates.
      real(wp), intent(in) :: outputs(:, :)
      !> (n + outputs)
      real(wp), intent(out) :: largest(:), rms(:)
      type(structure_type) :: structure
      type(load_type) :: load
      type(run_type) :: run
      type(size_type) :: sizes
      real(wp), allocatable :: x(:), v(:)
      integer :: i, status

      largest = ieee_value(1.0_wp, ieee_quiet_nan)
      rms = largest
      call changed(path, [share], structure, load)
      do i = 1, size(structure%laws)
         ! without slip and stick levels friction does not act
         if (structure%laws(i)%kind == friction_law) structure%laws(i)%numbers(:2) = 0
      end do
      call new_run(structure, load, run, status)
      if (status /= stat%ok) return
      call new_sizes(outputs, sizes)
      associate (modes => run%regimes(1)%modes)
         ! the pairs that stay where they are
         v = -modes%drift
         x = modes%force + 2*modes%damping*modes%drift
         if (any(abs(x) > 0 .and. .not. modes%stiffness > 0)) return
         where (modes%stiffness > 0) x = x/modes%stiffness
      end associate
      call measure(run, 1, 0.0_wp, run%period, x, v, sizes)
      largest = max(abs(sizes%low), sizes%high)
      rms = sqrt(sizes%squares/sizes%time)
   end subroutine steady_size

end module vi_structure_settled
