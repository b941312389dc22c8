!> Settled motions of a structure along a parameter: at each value the simulation goes on from the
!! last state of the value before it.
module vi_structure_sweep
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   use vi_modes, only: advance
   use vi_progress, only: add_done_work, add_expected_work, is_stopped
   use vi_status, only: stat
   use vi_structure, only: load_type, state_of, structure_type
   use vi_structure_extremes, only: turning_share
   use vi_structure_find, only: open_gaps
   use vi_structure_path, only: changed, structure_path_type
   use vi_structure_return, only: confirmed_cycles, is_steady, most_events, one_cycle, repetition, &
      some_cycles
   use vi_structure_run, only: impact_event, is_far, new_run, run_event_type, run_state_type, &
      run_type, start_at, state_now, stick_event
   implicit none (type, external)
   private

   public :: steady_size, sweep

   !> How each value is examined.
   type, public :: sweep_type
      !> Load cycles before, those that are examined, most impacts that are kept, and events until a
      !! simulation is given up.
      integer :: settling = 0, keep = 3, points = 100, max_events = huge(1)
      !> (outputs, n) Further quantities, as sums of the coordinates.
      real(wp), allocatable :: outputs(:, :)
   end type sweep_type

   !> What was found at a value.
   type, public :: cell_type
      !> Number of the value, and 1 on the way up or 2 on the way down.
      integer :: value = 0, run = 1
      !> `stat%ok`, or why there is nothing.
      integer :: status = stat%not_computed
      !> Load cycles of the period, 0 if none is confirmed; impacts and rests in it, or in all
      !! cycles
      !! that were examined.
      integer :: cycles = 0, impacts = 0, rests = 0
      !> (n + outputs) Least and greatest values of the coordinates and then of the outputs, and
      !! roots of their mean squares.
      real(wp), allocatable, dimension(:) :: q_min, q_max, q_rms
      !> (2n, cycles of a period, or all examined) States at the beginning of load cycles.
      real(wp), allocatable :: strobes(:, :)
      !> (impacts) Gaps, load phases (rad) within a cycle, and approach speeds.
      integer, allocatable :: gaps(:)
      real(wp), allocatable :: phases(:), speeds(:)
   end type cell_type

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

   !> Follows the motion over values of a parameter, one after another.
   subroutine sweep(path, shares, order, runs, q, rate, how, cells, done, progress)
      !> The structure and its load as functions of the parameter.
      type(structure_path_type), intent(in) :: path
      !> (values) The parameter, as shares of the way between its bounds.
      real(wp), intent(in) :: shares(:)
      !> (cells) The number of the value of each cell, in the order of the sweep, and its direction.
      integer, intent(in) :: order(:), runs(:)
      !> (n) Coordinates and velocities at the beginning.
      real(wp), intent(in) :: q(:), rate(:)
      !> How each value is examined.
      type(sweep_type), intent(in) :: how
      !> (cells) What was found.
      type(cell_type), intent(out) :: cells(:)
      !> Number of cells that were reached.
      integer, intent(out) :: done
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(structure_type) :: structure
      type(load_type) :: load
      real(wp) :: here(2*size(q))
      integer :: i

      call add_expected_work(size(cells), progress)
      here = [q, rate]
      do i = 1, size(cells)
         done = i - 1
         if (is_stopped(progress)) return
         call changed(path, [shares(order(i))], structure, load)
         call examine(structure, load, how, here, cells(i), progress)
         cells(i)%value = order(i)
         cells(i)%run = runs(i)
         if (cells(i)%status == stat%not_computed) return
         done = i
         ! after a failure anew
         if (cells(i)%status /= stat%ok) here = [q, rate]
         call add_done_work(1, progress)
      end do
   end subroutine sweep

   !> Settles and examines the motion at one value.
   subroutine examine(structure, load, how, here, cell, progress)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> How it is examined.
      type(sweep_type), intent(in) :: how
      !> (2n) In: coordinates and velocities at load phase 0. Out: those at the end.
      real(wp), intent(inout) :: here(:)
      !> What was found.
      type(cell_type), intent(out) :: cell
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      real(wp), parameter :: near = 1.0e-4_wp, at_rounding = 1.0e-9_wp
      type(run_type) :: run
      type(run_state_type) :: state, before
      type(run_event_type), allocatable :: events(:)
      type(size_type) :: sizes
      real(wp), allocatable :: strobes(:, :)
      integer :: counts(how%keep), rests(how%keep), first, i, k, left, n, repeats
      logical :: exactly

      associate (m => size(here)/2)
         allocate (cell%gaps(0), cell%phases(0), cell%speeds(0), cell%strobes(2*m, 0))
         call new_sizes(how%outputs, sizes)
         allocate (cell%q_min, cell%q_max, cell%q_rms, mold=sizes%low)
         cell%q_min = ieee_value(1.0_wp, ieee_quiet_nan)
         cell%q_max = cell%q_min
         cell%q_rms = cell%q_min
         call new_run(structure, load, run, cell%status)
         if (cell%status /= stat%ok) return
         ! a start that is too far is refused, as in a simulation, not moved into the gaps
         if (is_far(run, here(:m), here(m + 1:))) then
            cell%status = stat%extreme_units
            return
         end if
         call open_gaps(structure, here(:m))
         call start_at(run, 0.0_wp, here(:m), here(m + 1:), state, cell%status)
         if (cell%status /= stat%ok) return
         allocate (events(most_events), strobes(2*m, 0:how%keep))
         left = how%max_events
         call some_cycles(run, state, 0.0_wp, how%settling, left, events, strobes(:, :0), &
            cell%status, progress)
         if (cell%status /= stat%ok) return
         call state_now(run, state, strobes(:m, 0), strobes(m + 1:, 0))
         do i = 1, how%keep
            before = state
            call one_cycle(run, state, 1, 0.0_wp, events, n, cell%status, progress)
            left = left - n
            if (cell%status == stat%ok .and. left < 0) cell%status = stat%event_limit
            if (is_stopped(progress)) cell%status = stat%not_computed
            if (cell%status /= stat%ok) return
            call state_now(run, state, strobes(:m, i), strobes(m + 1:, i))
            call measure_cycle(run, before, events(:n), state, sizes)
            counts(i) = count(events(:n)%kind == impact_event)
            rests(i) = count(events(:n)%kind == stick_event)
            do k = 1, n
               if (events(k)%kind /= impact_event .or. size(cell%gaps) >= how%points) cycle
               cell%gaps = [cell%gaps, events(k)%gap]
               cell%phases = [cell%phases, load%frequency*events(k)%elapsed]
               cell%speeds = [cell%speeds, events(k)%speed]
            end do
         end do
         here = strobes(:, how%keep)
         cell%q_min = sizes%low
         cell%q_max = sizes%high
         cell%q_rms = sqrt(sizes%squares/sizes%time)
         k = (how%keep - 1)/2
         call repetition(strobes(:, how%keep - 2*k:), k, at_rounding, repeats)
         exactly = repeats > 0
         if (.not. exactly) call repetition(strobes(:, how%keep - 2*k:), k, near, repeats)
         call confirm(structure, run, state, repeats, exactly, counts, events, cell%cycles, &
            progress)
         first = 1
         if (cell%cycles > 0) first = how%keep - cell%cycles + 1
         cell%impacts = sum(counts(first:))
         cell%rests = sum(rests(first:))
         cell%strobes = strobes(:, first:how%keep)
      end associate
   end subroutine examine

   !> The shortest period of the motion on which a simulation has settled.
   !!
   !! A simulation that approaches a motion slowly, or leaves one that is not stable, nearly repeats
   !! itself, possibly only after several periods: Newton's method has to confirm a stable motion.
   subroutine confirm(structure, run, state, repeats, exactly, counts, events, cycles, progress)
      !> The structure.
      type(structure_type), intent(in) :: structure
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
      call confirmed_cycles(structure, run, state, 0.0_wp, repeats, exactly, events, cycles, &
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
      real(wp) :: h, share, turned
      integer :: i, j, k, panels

      if (.not. duration > 0) return
      associate (regime => run%regimes(number))
         panels = max(1, ceiling(min(real(most_panels, wp), density*duration/regime%unit)))
         h = duration/panels
         do i = 0, panels
            call values_after(run, number, sizes%outputs, phase, i*h, x, v, q, rate)
            sizes%low = min(sizes%low, q)
            sizes%high = max(sizes%high, q)
            if (i > 0) then
               do j = 1, size(q)
                  if (.not. last_rate(j)*rate(j) < 0) cycle
                  call turning_share(last(j), q(j), h*last_rate(j), h*rate(j), share)
                  call values_after(run, number, sizes%outputs, phase, (i - 1 + share)*h, x, v, &
                     there, rate_there)
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
               call values_after(run, number, sizes%outputs, phase, (i + nodes(k))*h, x, v, q, rate)
               sizes%squares = sizes%squares + weights(k)*h*q**2
            end do
         end do
      end associate
      sizes%time = sizes%time + duration
   end subroutine measure

   !> Coordinates and outputs, and their velocities, in a flight or rest.
   pure subroutine values_after(run, number, outputs, phase, time, x, v, q, rate)
      !> The run, and the number of its regime.
      type(run_type), intent(in) :: run
      integer, intent(in) :: number
      !> (outputs, n) Outputs as sums of the coordinates.
      real(wp), intent(in) :: outputs(:, :)
      !> Load phase (rad) at its beginning, and the time since then.
      real(wp), intent(in) :: phase, time
      !> (m) The pairs at its beginning.
      real(wp), intent(in) :: x(:), v(:)
      !> (n + outputs)
      real(wp), intent(out) :: q(:), rate(:)
      real(wp), dimension(size(x)) :: x_now, v_now
      integer :: i

      associate (regime => run%regimes(number), n => size(outputs, 2))
         call advance(regime%modes, time, x, v, x_now, v_now)
         call state_of(regime, phase + run%load%frequency*time, x_now, v_now, q(:n), rate(:n))
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

   !> Greatest magnitudes and roots of mean squares of the steady motion without impacts; NaN if
   !! there is none.
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
      integer :: status

      largest = ieee_value(1.0_wp, ieee_quiet_nan)
      rms = largest
      call changed(path, [share], structure, load)
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

end module vi_structure_sweep
