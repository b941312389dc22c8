!> Response quantities over a window of time: means, mean squares, extremes, harmonics and energies,
!! in closed form between the events (vi_moments).
!!
!! A wall at e(t) that is pressed with a force p pushes the structure with -p along the direction of
!! its gap, and so puts in the work -p e' in each unit of time, and -e' times the impulse where an
!! accumulation of impacts ends; the caller adds those of the impacts themselves.
module vi_quantities
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   use vi_modes, only: advance
   use vi_moments, only: moments_of, numbers_in, rate_of, rates_in, vector_at
   use vi_restitution, only: pushing_law, stop_law
   use vi_status, only: stat
   use vi_structure, only: is_absorbed, load_type, opening_at, regime_type, state_of, &
      structure_type, to_pairs
   use vi_structure_record, only: forces_at, set_forces
   use vi_structure_run, only: find_regime, let_go_event, new_run, pass_label, press_event, &
      run_type, stick_event
   use vi_structure_trajectory, only: find_parts, find_start
   implicit none (type, external)
   private

   public :: energy, quantities_of, turning_shares

   !> Longest window, in the shortest time scales, and nodes of extremes in one of them.
   real(wp), parameter :: longest = 5.0e5_wp
   real(wp), parameter, public :: density = 4.0_wp

   !> What is summed over a window.
   type :: sums_type
      !> The regime; (4n, b) the signals q, q', q'' and K q + C q', and (n, b) the forces of the
      !! load, by the vector b of vi_moments.
      integer :: number = 0
      real(wp), allocatable :: signals(:, :), forces(:, :)
      !> (b, b) and (b, orders) The integrals of vi_moments in this regime so far.
      real(wp), allocatable :: squares(:, :)
      complex(wp), allocatable :: parts(:, :)
      !> (4n, 4) Integrals of the signals and of their squares, least and greatest values.
      real(wp), allocatable :: numbers(:, :)
      !> (4n, orders) Integrals of the signals times e^(-i k Omega t).
      complex(wp), allocatable :: harmonics(:, :)
      !> Work of the load, of belts and of walls that move, losses of dashpots and of velocities
      !! where rests begin, change of energy, and the loss of friction.
      real(wp) :: energies(5) = 0
      !> Length in the shortest time scales.
      real(wp) :: units = 0
   end type sums_type

contains

   !> The quantities of a trajectory.
   pure subroutine quantities_of(structure, load, starts, labels, window, numbers, harmonics, &
      energies, share, status)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> As in `sample_structure_arrays`. If the first label is that of an event, no other gap rests
      !! there.
      real(wp), intent(in) :: starts(:, :)
      !> As in `starts`.
      integer, intent(in) :: labels(:, :)
      !> Times at which the window begins and ends.
      real(wp), intent(in) :: window(2)
      !> (4n, 4) Mean, root of the mean square, least and greatest value of q, q', q'' and K q +
      !! C q'. The mean of q'' contains the impulses.
      real(wp), intent(out) :: numbers(:, :)
      !> (4n, orders) Complex amplitudes at the multiples of the load frequency; those of q''
      !! contain the impulses.
      complex(wp), intent(out) :: harmonics(:, :)
      !> Work of the load, of belts and of walls that move, but not in impacts, losses of dashpots
      !! and of velocities where rests begin, the change of energy, and the loss of friction.
      real(wp), intent(out) :: energies(5)
      !> The part of the window that would not be too long; less than 1 if nothing was computed.
      real(wp), intent(out) :: share
      !> `stat%ok`, or as in `sample_structure_arrays`.
      integer, intent(out) :: status
      type(run_type) :: run
      type(sums_type) :: sums
      real(wp), dimension(size(structure%mass, 1)) :: q, rate, before
      type(load_type) :: own
      integer, allocatable :: resting(:)
      real(wp) :: begin, end, impulse, opening(0:2), whole
      integer :: h, j, number

      numbers = 0
      harmonics = 0
      energies = 0
      rate = 0
      share = 1
      whole = window(2) - window(1)
      own = load
      if (load%frequency > 0 .and. size(structure%motion, 1) > size(load%sine, 2)) then
         ! the harmonics of walls count, too
         h = size(structure%motion, 1)
         own%cosine = reshape([load%cosine], [size(q), h], pad=[0.0_wp])
         own%sine = reshape([load%sine], [size(q), h], pad=[0.0_wp])
      end if
      call new_run(structure, own, run, status)
      if (status /= stat%ok) return
      allocate (resting(0))
      if (labels(1, 1) == 0) then
         call find_start(run, starts(:, 1), number, status)
         if (status /= stat%ok) return
         resting = run%regimes(number)%closed
      end if
      sums%numbers = numbers
      sums%numbers(:, 3) = huge(whole)
      sums%numbers(:, 4) = -huge(whole)
      sums%harmonics = harmonics
      do j = 1, size(starts, 2)
         begin = starts(1, j)
         if (begin > window(2)) exit
         call pass_label(labels(:, j), resting)
         end = window(2)
         if (j < size(starts, 2)) end = min(end, starts(1, j + 1))
         if (j < size(starts, 2) .and. end <= window(1)) cycle
         call find_regime(run, resting, number, status)
         if (status /= stat%ok) return
         before = rate
         q = starts(2:size(q) + 1, j)
         rate = starts(size(q) + 2:, j)
         if (begin > window(1)) then
            call add_jump(load%frequency*begin, rate - before, sums)
            if (labels(1, j) == stick_event) then
               sums%energies(3) = sums%energies(3) + 0.5_wp*dot_product(before - rate, &
                  matmul(structure%mass, before + rate))
               if (run%structure%moves) then
                  associate (gap => labels(2, j))
                     opening = opening_at(run%structure, gap, load%frequency*begin, load%frequency)
                     impulse = run%structure%effective(gap)*dot_product(structure%directions(:, &
                        gap), before - rate)
                  end associate
                  sums%energies([1, 3]) = sums%energies([1, 3]) - impulse*opening(1)
               end if
            end if
            ! a stop that does not touch relaxes by its dashpot
            if (labels(1, j) == let_go_event) sums%energies(2) = sums%energies(2) &
               + energy_of_stop(run, labels(2, j), begin, q)
            if (labels(1, j) == press_event) sums%energies(2) = sums%energies(2) &
               - energy_of_stop(run, labels(2, j), begin, q)
         else
            call pass(run, number, begin, window(1), .false., q, rate, sums)
            begin = window(1)
            sums%energies(4) = -energy(run, resting, begin, q, rate)
         end if
         if (end > begin .or. .not. whole > 0) call pass(run, number, begin, end, .true., q, rate, &
            sums)
      end do
      share = longest/max(longest, sums%units)
      if (share < 1) return
      call settle(run, sums)
      energies = sums%energies
      energies(4) = energies(4) + energy(run, resting, window(2), q, rate)
      numbers = sums%numbers
      harmonics = sums%harmonics
      if (.not. whole > 0) then
         numbers(:, 1) = numbers(:, 4)
         numbers(:, 2) = abs(numbers(:, 4))
         harmonics = cmplx(ieee_value(whole, ieee_quiet_nan), 0.0_wp, wp)
         return
      end if
      numbers(:, 1) = numbers(:, 1)/whole
      numbers(:, 2) = sqrt(max(0.0_wp, numbers(:, 2)/whole))
      harmonics = 2*harmonics/whole
   end subroutine quantities_of

   !> Adds a jump of the velocities to the integrals of the accelerations.
   pure subroutine add_jump(phase, jump, sums)
      !> The load phase, and the jump (n).
      real(wp), intent(in) :: phase, jump(:)
      !> In and out: the sums.
      type(sums_type), intent(inout) :: sums
      integer :: k, n

      n = size(jump)
      associate (mean => sums%numbers(2*n + 1:3*n, 1), parts => sums%harmonics(2*n + 1:3*n, :))
         mean = mean + jump
         do k = 1, size(parts, 2)
            parts(:, k) = parts(:, k) + jump*exp(cmplx(0.0_wp, -k*phase, wp))
         end do
      end associate
   end subroutine add_jump

   !> The energy of masses and springs, those of stops that press too.
   pure real(wp) function energy(run, closed, time, q, rate)
      !> The run, what is closed, and the time.
      type(run_type), intent(in) :: run
      integer, intent(in) :: closed(:)
      real(wp), intent(in) :: time
      !> (n) Coordinates and velocities.
      real(wp), intent(in) :: q(:), rate(:)
      integer :: i

      energy = 0.5_wp*(dot_product(rate, matmul(run%structure%mass, rate)) + dot_product(q, &
         matmul(run%structure%stiffness, q)))
      do i = 1, size(closed)
         if (closed(i) > 0) energy = energy + energy_of_stop(run, closed(i), time, q)
      end do
   end function energy

   !> The energy of a stop that presses; 0 of other elements.
   pure real(wp) function energy_of_stop(run, number, time, q) result(energy)
      !> The run, the number of the element, and the time.
      type(run_type), intent(in) :: run
      integer, intent(in) :: number
      real(wp), intent(in) :: time
      !> (n) Coordinates.
      real(wp), intent(in) :: q(:)
      real(wp) :: depth, opening(0:2)

      energy = 0
      associate (law => run%structure%laws(number), frequency => run%load%frequency)
         if (law%kind /= stop_law .and. law%kind /= pushing_law) return
         opening = opening_at(run%structure, number, frequency*time, frequency)
         depth = dot_product(run%structure%directions(:, number), q) - opening(0)
         energy = depth*(law%numbers(3) + 0.5_wp*law%numbers(1)*depth)
      end associate
   end function energy_of_stop

   !> Passes a part of a flight or rest, interval by interval of a record.
   pure subroutine pass(run, number, begin, end, counts, q, rate, sums)
      !> In and out: the run, whose forces are set.
      type(run_type), intent(inout) :: run
      !> The regime.
      integer, intent(in) :: number
      !> Times between which it is passed.
      real(wp), intent(in) :: begin, end
      !> Whether it belongs to the window.
      logical, intent(in) :: counts
      !> (n) In: coordinates and velocities at the beginning. Out: those at the end.
      real(wp), intent(inout) :: q(:), rate(:)
      !> In and out: the sums.
      type(sums_type), intent(inout) :: sums
      real(wp), dimension(size(run%regimes(number)%xq, 1)) :: x, v, x_end, v_end
      integer(int64) :: cycle, last_cycle
      real(wp) :: elapsed, last_elapsed, length
      logical :: recorded

      call find_parts(run, begin, cycle, elapsed)
      call find_parts(run, end, last_cycle, last_elapsed)
      call to_pairs(run%regimes(number), run%load%frequency*elapsed, q, rate, x, v)
      do
         recorded = .false.
         if (run%load%step > 0) recorded = cycle < min(last_cycle, size(run%load%record, 2, int64) &
            - 1)
         length = real(last_cycle - cycle, wp)*run%period + (last_elapsed - elapsed)
         if (recorded) length = run%period - elapsed
         if (run%load%step > 0) call set_forces(run%regimes(number), run%load, cycle, elapsed)
         if (counts) call add_part(run, number, cycle, elapsed, length, x, v, sums)
         call advance(run%regimes(number)%modes, max(0.0_wp, length), x, v, x_end, v_end)
         x = x_end
         v = v_end
         if (.not. recorded) exit
         cycle = cycle + 1
         elapsed = 0
      end do
      if (end > begin) call state_of(run%regimes(number), run%load%frequency*last_elapsed, x, v, &
         q, rate)
   end subroutine pass

   !> Adds a part without corners of the forces.
   pure subroutine add_part(run, number, cycle, elapsed, length, x, v, sums)
      !> The run.
      type(run_type), intent(in) :: run
      !> The regime.
      integer, intent(in) :: number
      !> The time at the beginning, as whole periods and the remainder, and the length.
      integer(int64), intent(in) :: cycle
      real(wp), intent(in) :: elapsed, length
      !> (m) The pairs at the beginning.
      real(wp), contiguous, intent(in) :: x(:), v(:)
      !> In and out: the sums.
      type(sums_type), intent(inout) :: sums
      real(wp) :: b(numbers_in(run%regimes(number)))
      real(wp), allocatable :: squares(:, :)
      complex(wp), allocatable :: parts(:, :)
      real(wp) :: phase
      integer :: k

      associate (regime => run%regimes(number))
         sums%units = sums%units + max(0.0_wp, length)*rates_in(regime)
         if (sums%units > longest) return
         phase = run%load%frequency*elapsed
         if (number /= sums%number .or. run%load%step > 0) then
            call settle(run, sums)
            call set_signals(run, number, cycle, elapsed, sums)
         end if
         allocate (squares(size(sums%squares, 1), size(sums%squares, 1)), &
            parts(size(sums%parts, 1), size(sums%parts, 2)))
         call vector_at(regime, x, v, phase, 0.0_wp, b)
         call find_extremes(regime, phase, max(0.0_wp, length), x, v, sums)
         if (length > 0) then
            call moments_of(regime, b, length, squares, parts)
            sums%squares = sums%squares + squares
            do k = 1, size(parts, 2)
               sums%parts(:, k) = sums%parts(:, k) + parts(:, k)*exp(cmplx(0.0_wp, -k*phase, wp))
            end do
         end if
      end associate
   end subroutine add_part

   !> The signals of a regime.
   pure subroutine set_signals(run, number, cycle, elapsed, sums)
      !> The run.
      type(run_type), intent(in) :: run
      !> The regime.
      integer, intent(in) :: number
      !> The time, as whole periods and the remainder.
      integer(int64), intent(in) :: cycle
      real(wp), intent(in) :: elapsed
      !> In and out: the sums.
      type(sums_type), intent(inout) :: sums
      real(wp), allocatable :: unit(:, :)
      real(wp) :: force(size(run%load%constant)), growth(size(force))
      integer :: i, m, n

      n = size(force)
      sums%number = number
      associate (regime => run%regimes(number), load => run%load, rows => numbers_in( &
         run%regimes(number)))
         m = 2*size(regime%modes%stiffness)
         if (allocated(sums%signals)) deallocate (sums%signals, sums%forces, sums%squares, &
            sums%parts)
         allocate (sums%signals(4*n, rows), sums%forces(n, rows), sums%squares(rows, rows), &
            source=0.0_wp)
         allocate (sums%parts(rows, size(sums%harmonics, 2)), source=(0.0_wp, 0.0_wp))
         sums%signals(:n, :m/2) = regime%qx
         sums%signals(:n, m/2 + 1:m) = regime%qv
         sums%signals(:n, m + 1:rows - 2) = reshape([regime%steady%re, -regime%steady%im], &
            [n, rows - 2 - m])
         sums%signals(:n, rows - 1) = regime%offset
         associate (of_q => sums%signals(:n, :), of_rate => sums%signals(n + 1:2*n, :))
            of_rate(:, :m/2) = regime%dx
            of_rate(:, m/2 + 1:m) = regime%dv
            of_rate(:, m + 1:rows - 2) = reshape([regime%steady_rate%re, -regime%steady_rate%im], &
               [n, rows - 2 - m])
            allocate (unit(rows, rows), source=0.0_wp)
            do i = 1, rows
               unit(i, i) = 1
            end do
            sums%signals(2*n + 1:3*n, :) = matmul(of_rate, rate_of(regime, unit))
            sums%signals(3*n + 1:, :) = matmul(run%structure%stiffness, of_q) &
               + matmul(run%structure%damping, of_rate)
         end associate
         sums%forces(:, m + 1:rows - 2) = reshape([load%cosine, load%sine], [n, rows - 2 - m])
         sums%forces(:, rows - 1) = load%constant
         if (load%step > 0) then
            call forces_at(load, cycle, elapsed, force, growth)
            sums%forces(:, rows - 1) = load%constant + force
            sums%forces(:, rows) = growth
         end if
      end associate
   end subroutine set_signals

   !> Applies the signals to the integrals in a regime.
   pure subroutine settle(run, sums)
      !> The run.
      type(run_type), intent(in) :: run
      !> In and out: the sums.
      type(sums_type), intent(inout) :: sums
      real(wp), allocatable :: products(:, :), rates(:, :)
      integer :: n

      if (.not. allocated(sums%signals)) return
      n = size(run%structure%mass, 1)
      products = matmul(sums%signals, sums%squares)
      rates = matmul(products(n + 1:2*n, :), transpose(sums%signals(n + 1:2*n, :)))
      sums%numbers(:, 1) = sums%numbers(:, 1) + products(:, size(products, 2) - 1)
      sums%numbers(:, 2) = sums%numbers(:, 2) + sum(products*sums%signals, 2)
      sums%harmonics = sums%harmonics + matmul(sums%signals, sums%parts)
      sums%energies(:2) = sums%energies(:2) + [sum(products(n + 1:2*n, :)*sums%forces), &
         sum(run%structure%damping*rates)]
      if (run%structure%has_stops .or. run%structure%has_friction) call add_elements(run, &
         products, rates, sums)
      if (run%structure%moves) call add_walls(run, sums)
      sums%squares = 0
      sums%parts = 0
   end subroutine settle

   !> Adds the energy that stops and friction dissipate and belts supply in a regime.
   !!
   !! Friction that slips dissipates h |s| in each unit of time. It acts on the structure with -h
   !! sgn(s) D, and its belt supplies -h sgn(s) V; where friction sticks, its belt supplies -phi V
   !! by the force phi that holds it.
   pure subroutine add_elements(run, products, rates, sums)
      !> The run.
      type(run_type), intent(in) :: run
      !> (4n, b) Integrals of the signals times b; (n, n) those of products of velocities.
      real(wp), intent(in) :: products(:, :), rates(:, :)
      !> In and out: the sums.
      type(sums_type), intent(inout) :: sums
      real(wp) :: slid, time
      integer :: j, k, n, one, row

      n = size(run%structure%mass, 1)
      one = size(products, 2) - 1
      time = sums%squares(one, one)
      associate (regime => run%regimes(sums%number), structure => run%structure)
         do j = 1, size(structure%openings)
            associate (numbers => structure%laws(j)%numbers, direction => structure%directions(:, &
               j), closed => any(regime%closed == j))
               if (structure%elastic(j)) then
                  ! what moves with its wall is added there
                  if (closed .and. .not. any(abs(structure%motion(:, j)) > 0)) sums%energies(2) = &
                     sums%energies(2) + numbers(2)*dot_product(direction, matmul(rates, direction))
               else if (structure%rubs(j)) then
                  k = findloc(regime%held, j, dim=1)
                  if (k > 0) then
                     row = structure%channels + k
                     sums%energies(1) = sums%energies(1) - numbers(3)*dot_product([ &
                        regime%position(row, :), regime%velocity(row, :), &
                        regime%ripple(row, :)%re, -regime%ripple(row, :)%im, &
                        regime%row_offset(row)], sums%squares(:one, one))
                  else if (.not. is_absorbed(structure, j, regime%resting)) then
                     slid = dot_product(direction, products(n + 1:2*n, one)) - numbers(3)*time
                     if (any(regime%closed == -j)) slid = -slid
                     sums%energies(5) = sums%energies(5) + numbers(1)*slid
                     sums%energies(1) = sums%energies(1) - merge(-1, 1, any(regime%closed == -j)) &
                        *numbers(1)*numbers(3)*time
                  end if
               end if
            end associate
         end do
      end associate
   end subroutine add_elements

   !> Adds the work of moving walls while gaps rest on them and stops are pressed, and the energy
   !! that the dashpots of these stops dissipate.
   pure subroutine add_walls(run, sums)
      !> The run.
      type(run_type), intent(in) :: run
      !> In and out: the sums.
      type(sums_type), intent(inout) :: sums
      real(wp), dimension(size(sums%signals, 2)) :: closing, force, place, speed
      integer :: h, harmonics, i, j, m, n, one

      n = size(run%structure%mass, 1)
      one = size(sums%signals, 2) - 1
      associate (regime => run%regimes(sums%number), structure => run%structure)
         m = 2*size(regime%modes%stiffness)
         harmonics = size(regime%steady, 2)
         do i = 1, size(regime%closed)
            j = regime%closed(i)
            if (j < 0) cycle
            if (structure%rubs(j) .or. .not. any(abs(structure%motion(:, j)) > 0)) cycle
            ! e and e' by b
            place = 0
            speed = 0
            place(one) = structure%openings(j)
            do h = 1, size(structure%motion, 1)
               associate (motion => structure%motion(h, j), pace => h*regime%frequency)
                  place([m + h, m + harmonics + h]) = [motion%re, -motion%im]
                  speed([m + h, m + harmonics + h]) = -pace*[motion%im, motion%re]
               end associate
            end do
            force = 0
            if (structure%elastic(j)) then
               associate (numbers => structure%laws(j)%numbers, direction => &
                  structure%directions(:, j))
                  closing = matmul(direction, sums%signals(n + 1:2*n, :)) - speed
                  force = numbers(1)*(matmul(direction, sums%signals(:n, :)) - place) &
                     + numbers(2)*closing
                  force(one) = force(one) + numbers(3)
                  sums%energies(2) = sums%energies(2) + numbers(2)*dot_product(closing, &
                     matmul(sums%squares, closing))
               end associate
            else
               associate (row => structure%channels + findloc(regime%held, j, dim=1))
                  force(:one) = [regime%position(row, :), regime%velocity(row, :), &
                     regime%ripple(row, :)%re, -regime%ripple(row, :)%im, regime%row_offset(row)]
               end associate
            end if
            sums%energies(1) = sums%energies(1) - dot_product(force, matmul(sums%squares, speed))
         end do
      end associate
   end subroutine add_walls

   !> The least and greatest values of the signals in a part: at nodes close together, and where
   !! cubics through values and slopes turn between them, from the closed form there.
   pure subroutine find_extremes(regime, phase, length, x, v, sums)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> The load phase at the beginning, and the length.
      real(wp), intent(in) :: phase, length
      !> (m) The pairs at the beginning.
      real(wp), contiguous, intent(in) :: x(:), v(:)
      !> In and out: the sums.
      type(sums_type), intent(inout) :: sums
      !> Share of the range of a signal by which cubics may miss an extreme.
      real(wp), parameter :: doubt = 1.0e-3_wp
      real(wp), dimension(size(sums%signals, 1)) :: values, slopes, old, old_slopes
      real(wp) :: b(size(sums%signals, 2), 2), h, shares(2), value
      integer :: i, j, k, nodes

      nodes = max(1, ceiling(density*length*rates_in(regime)))
      h = length/nodes
      associate (least => sums%numbers(:, 3), greatest => sums%numbers(:, 4))
         do i = 0, nodes
            old = values
            old_slopes = slopes
            call place(regime, phase, x, v, i*h, b)
            values = matmul(sums%signals, b(:, 1))
            slopes = h*matmul(sums%signals, b(:, 2))
            least = min(least, values)
            greatest = max(greatest, values)
            if (i == 0) cycle
            do j = 1, size(values)
               shares = turning_shares(old(j), values(j), old_slopes(j), slopes(j))
               do k = 1, 2
                  if (.not. (shares(k) > 0 .and. shares(k) < 1)) cycle
                  value = old(j) + shares(k)*(old_slopes(j) + shares(k)*(3*(values(j) - old(j)) &
                     - 2*old_slopes(j) - slopes(j) + shares(k)*(2*(old(j) - values(j)) &
                     + old_slopes(j) + slopes(j))))
                  if (abs(2*value - least(j) - greatest(j)) < (1 - 2*doubt)*(greatest(j) &
                     - least(j))) cycle
                  value = turn_of(regime, phase, x, v, sums%signals(j, :), (i - 1)*h, shares(k), h)
                  least(j) = min(least(j), value)
                  greatest(j) = max(greatest(j), value)
               end do
            end do
         end do
      end associate
   end subroutine find_extremes

   !> Where a cubic turns between two nodes at a distance of 1: shares of the way, NaN or outside of
   !! it if there are none.
   pure function turning_shares(a, b, slope_a, slope_b) result(shares)
      !> Values and slopes at both nodes.
      real(wp), intent(in) :: a, b, slope_a, slope_b
      real(wp) :: shares(2), c2, c3, root

      shares = -1
      c2 = 3*(b - a) - 2*slope_a - slope_b
      c3 = 3*(2*(a - b) + slope_a + slope_b)
      root = c2**2 - c3*slope_a
      if (root < 0) return
      ! the slope is slope_a + 2 c2 s + c3 s^2
      root = -(c2 + sign(sqrt(root), c2))
      if (abs(root) > 0) shares(1) = slope_a/root
      if (abs(c3) > 0) shares(2) = root/c3
   end function turning_shares

   !> The value of a signal where it turns.
   pure real(wp) function turn_of(regime, phase, x, v, signal, begin, share, h) result(value)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> As in `find_extremes`.
      real(wp), intent(in) :: phase
      real(wp), contiguous, intent(in) :: x(:), v(:)
      !> The signal by b.
      real(wp), intent(in) :: signal(:)
      !> The node before, the share of the way to the next one, and the way.
      real(wp), intent(in) :: begin, share, h
      real(wp) :: b(size(signal), 3), bend, t
      integer :: i

      t = begin + share*h
      do i = 1, 4
         call place(regime, phase, x, v, t, b)
         bend = dot_product(signal, b(:, 3))
         if (i == 4 .or. .not. abs(bend) > 0) exit
         t = min(begin + h, max(begin, t - dot_product(signal, b(:, 2))/bend))
      end do
      value = dot_product(signal, b(:, 1))
   end function turn_of

   !> The vector b and its first derivatives at a time.
   pure subroutine place(regime, phase, x, v, t, b)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> As in `find_extremes`, and the time.
      real(wp), intent(in) :: phase
      real(wp), contiguous, intent(in) :: x(:), v(:)
      real(wp), intent(in) :: t
      !> (b, derivatives of order 0 on)
      real(wp), intent(out) :: b(:, :)
      integer :: i

      call vector_at(regime, x, v, phase, t, b(:, 1))
      do i = 2, size(b, 2)
         b(:, i:i) = rate_of(regime, b(:, i - 1:i - 1))
      end do
   end subroutine place

end module vi_quantities
