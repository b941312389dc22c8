!> A simulated motion of a structure and small changes of it, carried from event to event.
!!
!! Between events the state, with the load as further coordinates, moves by a matrix exponential. At
!! the events changes follow the closed forms of impacts, of the ends of accumulations and of
!! changes of the regime (saltation). All of it is analytic: imaginary parts of 1e-30 of parameters
!! and of the start give the derivatives of the state at each event, and of the matrix that carries
!! changes there, without errors of differences.
module vi_structure_gradient
   use vi_columns, only: solve_columns
   use vi_kinds, only: wp
   use vi_restitution, only: power_law, restitution_at, table_law
   use vi_status, only: stat
   use vi_structure, only: acts_on, check_structure, factor_along, is_absorbed, linked_elements, &
      load_type, new_load, new_structure, structure_type
   use vi_structure_path, only: set_entry
   use vi_structure_run, only: halt_event, impact_event, leave_event, let_go_event, pass_label, &
      press_event, release_event, slip_up_event, stick_event, touch_event
   use vi_structure_trajectory, only: closed_at_start
   use vi_structure_variation, only: add_change, breakaway, changes_type, instant, ordered_change, &
      smooth_change
   implicit none (type, external)
   private

   public :: gradient_arrays

   !> The imaginary step.
   real(wp), parameter :: imaginary = 1.0e-30_wp
   !> Relative error of a motion that counts as exact; approach speed, over the largest velocity, at
   !! a graze.
   real(wp), parameter :: exact = 1.0e-8_wp, touching = 1.0e-9_wp

   !> A structure under a load with complex entries. Its clock shows time, or the load phase.
   type :: system_type
      !> (n, n) C, and (n, gaps) G_j and M^-1 G_j.
      complex(wp), allocatable, dimension(:, :) :: damping, directions, mobility
      !> (n, 2n) Accelerations by the state, and (n, n) by forces.
      complex(wp), allocatable, dimension(:, :) :: by_state, by_force
      !> (gaps) Openings, R at speed 0, effective masses; (3, gaps) the numbers of stops and
      !! friction.
      complex(wp), allocatable, dimension(:) :: openings, first, effective
      complex(wp), allocatable :: numbers(:, :)
      !> (n, 1 + 2 harmonics) Constant force, cosines and sines.
      complex(wp), allocatable :: forces(:, :)
      !> (1 + 2 harmonics, gaps, 0:2) The openings at an instant, and their first and second rates
      !! by time, as coefficients of the coordinates of the load.
      complex(wp), allocatable :: walls(:, :, :)
      !> The structure, with its laws of restitution, and the load.
      type(structure_type) :: structure
      type(load_type) :: load
      !> Omega, how fast the clock runs, and a factor of the record.
      complex(wp) :: frequency = 0, pace = 1, scale = 1
   end type system_type

   !> A simulated motion.
   type, public :: events_type
      !> (1 + 2n, events + 1) Time and state at the start and just after each event, (2, events + 1)
      !! kind and gap, and (events + 1) approach speeds; the time at the end.
      real(wp), allocatable :: starts(:, :), speeds(:)
      integer, allocatable :: labels(:, :)
      real(wp) :: end = 0
      !> Of a period, the clock of which shows the load phase, the gap of the impact just before the
      !! start; 0 of any other motion.
      integer :: first = 0
      !> What is closed at the start, as in `regime_type`.
      integer, allocatable :: closed(:)
      !> The event after the first flight in which a gap closes without an impact, 0 if none does;
      !! (2n) the largest coordinate n times, and the largest velocity.
      integer :: touched = 0
      real(wp), allocatable :: sizes(:)
   end type events_type


   !> What is carried.
   type :: carried_type
      !> (2n + 3, events) Time or phase, approach speed, impulse, and state just after each event;
      !! (2n + 3, 2n, events) their derivatives with respect to the state at the start.
      complex(wp), allocatable :: values(:, :), slopes(:, :, :)
      !> (2n) State at the end at a fixed time, its derivatives (2n, 2n) and its rate; (2n) the rate
      !! at the start.
      complex(wp), allocatable :: state(:), matrix(:, :), rate(:), first_rate(:)
      !> Events that have derivatives, and why the next one has none: `stat%graze` or
      !! `stat%no_derivative`.
      integer :: good = 0, code = 0
   end type carried_type

contains

   !> A structure and a load with the derivatives with respect to a parameter as imaginary parts.
   pure subroutine new_system(structure, load, by, load_by, record_by, by_phase, system, status)
      !> The structure, checked, and its load.
      type(structure_type), intent(in) :: structure
      type(load_type), intent(in) :: load
      !> The derivatives of all their entries, and that of a factor of the record.
      type(structure_type), intent(in) :: by
      type(load_type), intent(in) :: load_by
      real(wp), intent(in) :: record_by
      !> Whether the clock shows the load phase.
      logical, intent(in) :: by_phase
      !> The system.
      type(system_type), intent(out) :: system
      !> `stat%ok` or `stat%singular`.
      integer, intent(out) :: status
      complex(wp), allocatable :: right(:, :)
      integer :: h, i, k, n

      n = size(structure%mass, 1)
      system%structure = structure
      system%numbers = reshape([((with(structure%laws(i)%numbers(k), by%laws(i)%numbers(k)), k=1, &
         3), i=1, size(structure%openings))], [3, size(structure%openings)])
      system%load = load
      system%damping = with(structure%damping, by%damping)
      system%directions = with(structure%directions, by%directions)
      system%openings = with(structure%openings, by%openings)
      system%first = with(structure%restitution, by%restitution)
      system%forces = reshape([with(load%constant, load_by%constant), with(load%cosine, &
         load_by%cosine), with(load%sine, load_by%sine)], [n, 1 + 2*size(load%sine, 2)])
      system%frequency = with(load%frequency, load_by%frequency)
      if (by_phase) system%pace = system%frequency
      system%scale = with(1.0_wp, record_by)
      ! walls do not move under a record, which has two coordinates
      associate (harmonics => merge(0, size(load%sine, 2), load%step > 0))
         allocate (system%walls(merge(2, 1 + 2*harmonics, load%step > 0), &
            size(structure%openings), 0:2), source=(0.0_wp, 0.0_wp))
         system%walls(1, :, 0) = system%openings
         do h = 1, min(harmonics, size(structure%motion, 1))
            associate (cosines => 1 + h, sines => 1 + harmonics + h)
               system%walls(cosines, :, 0) = with(structure%motion(h, :)%re, by%motion(h, :)%re)
               system%walls(sines, :, 0) = -with(structure%motion(h, :)%im, by%motion(h, :)%im)
               system%walls(cosines, :, 1) = h*system%frequency*system%walls(sines, :, 0)
               system%walls(sines, :, 1) = -h*system%frequency*system%walls(cosines, :, 0)
               system%walls([cosines, sines], :, 2) = -(h*system%frequency)**2 &
                  *system%walls([cosines, sines], :, 0)
            end associate
         end do
      end associate
      allocate (right(n, 3*n), source=(0.0_wp, 0.0_wp))
      right(:, :n) = -with(structure%stiffness, by%stiffness)
      right(:, n + 1:2*n) = -system%damping
      do i = 1, n
         right(i, 2*n + i) = 1
      end do
      call solve_complex(with(structure%mass, by%mass), right, status)
      system%by_state = right(:, :2*n)
      system%by_force = right(:, 2*n + 1:)
      system%mobility = matmul(system%by_force, system%directions)
      system%effective = 1/sum(system%directions*system%mobility, 1)
   end subroutine new_system

   !> A number with a derivative.
   elemental complex(wp) function with(number, by)
      !> Both.
      real(wp), intent(in) :: number, by

      with = cmplx(number, imaginary*by, wp)
   end function with

   !> Solves equations to first order in the imaginary parts.
   pure subroutine solve_complex(matrix, right, status)
      !> (n, n)
      complex(wp), intent(in) :: matrix(:, :)
      !> In: right sides (n, columns). Out: the solutions.
      complex(wp), intent(inout) :: right(:, :)
      !> `stat%ok` or `stat%singular`.
      integer, intent(out) :: status
      real(wp), allocatable :: re(:, :), im(:, :)

      allocate (re, source=real(right, wp))
      call solve_columns(real(matrix, wp), re, status)
      allocate (im, source=aimag(right) - matmul(aimag(matrix), re))
      if (status == stat%ok) call solve_columns(real(matrix, wp), im, status)
      right(:, :) = cmplx(re, im, wp)
   end subroutine solve_complex

   !> The product of a column and a row.
   pure function outer(column, row) result(product)
      !> Both.
      complex(wp), intent(in) :: column(:), row(:)
      complex(wp) :: product(size(column), size(row))
      integer :: j

      do j = 1, size(row)
         product(:, j) = column*row(j)
      end do
   end function outer

   !> The coordinates of the load: 1, cosines and sines, or the time in an interval of the record.
   pure function load_at(system, clock, interval) result(values)
      !> The system.
      type(system_type), intent(in) :: system
      !> The clock, and the number of the interval from 0.
      real(wp), intent(in) :: clock
      integer, intent(in) :: interval
      complex(wp), allocatable :: values(:)
      complex(wp) :: angle
      integer :: h

      if (system%load%step > 0) then
         values = [(1.0_wp, 0.0_wp), cmplx(clock - interval*system%load%step, 0.0_wp, wp)]
         return
      end if
      angle = clock*system%frequency/system%pace
      values = [(1.0_wp, 0.0_wp), (cos(h*angle), h=1, size(system%load%sine, 2)), &
         (sin(h*angle), h=1, size(system%load%sine, 2))]
   end function load_at

   !> The directions of some gaps, as rows, and what impulses on them change, as columns.
   pure subroutine set_contacts(system, gaps, rows, kicks)
      !> The system.
      type(system_type), intent(in) :: system
      !> The gaps.
      integer, intent(in) :: gaps(:)
      !> (gaps, n) and (n, gaps)
      complex(wp), allocatable, intent(out) :: rows(:, :), kicks(:, :)
      integer :: j

      allocate (rows(size(gaps), size(system%by_force, 1)), kicks(size(system%by_force, 1), &
         size(gaps)))
      do j = 1, size(gaps)
         rows(j, :) = system%directions(:, gaps(j))
         kicks(:, j) = system%mobility(:, gaps(j))
      end do
   end subroutine set_contacts

   !> The gaps that rest, and then the friction that sticks.
   pure function held_of(structure, closed) result(held)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> What is closed.
      integer, intent(in) :: closed(:)
      integer, allocatable :: held(:), resting(:)
      logical :: sticks(size(closed))
      integer :: i

      allocate (resting, source=pack(closed, closed > 0))
      if (structure%has_stops .or. structure%has_friction) resting = pack(resting, .not. &
         (structure%elastic(resting) .or. structure%rubs(resting)))
      do i = 1, size(closed)
         sticks(i) = closed(i) > 0
         if (sticks(i)) sticks(i) = structure%rubs(closed(i))
         ! along a gap at rest it is part of what the gap does
         if (sticks(i)) sticks(i) = .not. is_absorbed(structure, closed(i), resting)
      end do
      allocate (held, source=[resting, pack(closed, sticks)])
   end function held_of

   !> Adds what stops that press and friction that slips do to the rate of the velocities.
   pure subroutine add_elements(system, closed, rate)
      !> The system.
      type(system_type), intent(in) :: system
      !> What is closed.
      integer, intent(in) :: closed(:)
      !> (2n + load, 2n + load) In and out: the matrix of the rate.
      complex(wp), intent(inout) :: rate(:, :)
      integer :: j, n

      n = size(system%by_force, 1)
      do j = 1, size(system%openings)
         associate (structure => system%structure, force => system%mobility(:, j), &
            numbers => system%numbers(:, j), row => system%directions(:, j), &
            constant => rate(n + 1:2*n, 2*n + 1))
            if (structure%elastic(j)) then
               if (all(closed /= j)) cycle
               rate(n + 1:2*n, :n) = rate(n + 1:2*n, :n) - numbers(1)*outer(force, row)
               rate(n + 1:2*n, n + 1:2*n) = rate(n + 1:2*n, n + 1:2*n) &
                  - numbers(2)*outer(force, row)
               rate(n + 1:2*n, 2*n + 1:) = rate(n + 1:2*n, 2*n + 1:) + outer(force, &
                  numbers(1)*system%walls(:, j, 0) + numbers(2)*system%walls(:, j, 1))
               constant = constant - numbers(3)*force
            else if (structure%rubs(j)) then
               if (any(closed == j)) cycle
               if (is_absorbed(structure, j, held_of(structure, closed))) cycle
               constant = constant + merge(1, -1, any(closed == -j))*numbers(1)*force
            end if
         end associate
      end do
   end subroutine add_elements

   !> The matrix of the rate of the state and the load, and the contact forces of gaps that rest,
   !! and of friction that sticks, by them.
   pure subroutine set_rate(system, closed, interval, rate, contact, status)
      !> The system.
      type(system_type), intent(in) :: system
      !> What is closed, and the number of the interval of a record.
      integer, intent(in) :: closed(:), interval
      !> (2n + load, 2n + load), and (held, 2n + load).
      complex(wp), allocatable, intent(out) :: rate(:, :), contact(:, :)
      !> `stat%ok` or `stat%singular`.
      integer, intent(out) :: status
      complex(wp), allocatable, dimension(:, :) :: forces, kicks, rows
      integer, allocatable :: held(:)
      integer :: h, i, n, harmonics

      n = size(system%by_force, 1)
      allocate (held, source=held_of(system%structure, closed))
      harmonics = size(system%load%sine, 2)
      if (.not. system%load%step > 0) then
         allocate (forces, source=system%forces)
      else
         allocate (forces(n, 2), source=(0.0_wp, 0.0_wp))
         forces(:, 1) = system%forces(:, 1)
         associate (record => system%load%record)
            if (interval >= 0 .and. interval < size(record, 2) - 1) then
               forces(:, 1) = forces(:, 1) + system%scale*record(:, interval + 1)
               forces(:, 2) = system%scale*(record(:, interval + 2) - record(:, interval + 1)) &
                  /system%load%step
            end if
         end associate
      end if
      allocate (rate(2*n + size(forces, 2), 2*n + size(forces, 2)), source=(0.0_wp, 0.0_wp))
      do i = 1, n
         rate(i, n + i) = 1
      end do
      rate(n + 1:2*n, :2*n) = system%by_state
      rate(n + 1:2*n, 2*n + 1:) = matmul(system%by_force, forces)
      call add_elements(system, closed, rate)
      call set_contacts(system, held, rows, kicks)
      allocate (contact, source=matmul(rows, rate(n + 1:2*n, :)))
      contact(:, 2*n + 1:) = contact(:, 2*n + 1:) - transpose(system%walls(:, held, 2))
      status = stat%ok
      if (size(held) > 0) call solve_complex(matmul(rows, kicks), contact, status)
      rate(n + 1:2*n, :) = rate(n + 1:2*n, :) - matmul(kicks, contact)
      if (system%load%step > 0) rate(2*n + 2, 2*n + 1) = 1
      do h = 1, harmonics
         rate(2*n + 1 + h, 2*n + 1 + harmonics + h) = -h*system%frequency
         rate(2*n + 1 + harmonics + h, 2*n + 1 + h) = h*system%frequency
      end do
      rate = rate/system%pace
   end subroutine set_rate

   !> exp(A) - 1, by a Taylor polynomial of A over a power of 2, in powers of A^4, squared again.
   pure subroutine set_growth(matrix, growth)
      !> A, and the exponential less 1.
      complex(wp), intent(in) :: matrix(:, :)
      complex(wp), allocatable, intent(out) :: growth(:, :)
      complex(wp), allocatable, dimension(:, :) :: a, a2, a3, a4
      integer :: i, squarings

      squarings = max(0, exponent(maxval(sum(abs(matrix), 1))) + 2)
      allocate (a, source=matrix*0.5_wp**squarings)
      allocate (a2, source=matmul(a, a))
      allocate (a3, source=matmul(a2, a))
      allocate (a4, source=matmul(a2, a2))
      growth = a/362880.0_wp + a2/3628800.0_wp + a3/39916800.0_wp + a4/479001600.0_wp
      growth = a/120.0_wp + a2/720.0_wp + a3/5040.0_wp + a4/40320.0_wp + matmul(a4, growth)
      growth = a + a2/2.0_wp + a3/6.0_wp + a4/24.0_wp + matmul(a4, growth)
      do i = 1, squarings
         growth = 2*growth + matmul(growth, growth)
      end do
   end subroutine set_growth

   !> The impulse of an impact, and its derivative with respect to the approach speed.
   pure subroutine strike(system, gap, speed, impulse, slope)
      !> The system.
      type(system_type), intent(in) :: system
      !> The gap.
      integer, intent(in) :: gap
      !> Approach speed.
      complex(wp), intent(in) :: speed
      !> Both.
      complex(wp), intent(out) :: impulse, slope
      complex(wp) :: ratio, base, value, rate
      real(wp) :: r, step, low, slopes(3)

      value = system%first(gap)
      rate = 0
      associate (law => system%structure%laws(gap))
         if (law%kind == power_law) then
            associate (v0 => law%numbers(2), p => law%numbers(3), k => law%numbers(4))
               ratio = speed/v0
               base = 1 + ratio**k
               value = value*base**(-p/k)
               rate = -p*value/base*ratio**(k - 1)/v0
            end associate
         else if (law%kind == table_law) then
            ! R is a cubic between the points of the table, and its slope a parabola
            step = 1.0e-4_wp*law%speeds(size(law%speeds))
            low = max(0.0_wp, speed%re - step)
            call restitution_at(law, low, r, slopes(1))
            call restitution_at(law, speed%re + step, r, slopes(3))
            call restitution_at(law, speed%re, r, slopes(2))
            value = cmplx(r, slopes(2)*speed%im, wp)
            rate = cmplx(slopes(2), (slopes(3) - slopes(1))/(speed%re + step - low)*speed%im, wp)
         end if
      end associate
      impulse = (1 + value)*system%effective(gap)*speed
      slope = (1 + value + rate*speed)*system%effective(gap)
   end subroutine strike

   !> Takes a state and its small changes to where a gap begins to rest, at the end of an
   !! accumulation on it.
   !!
   !! The rest of its gap is closed by impulses at this instant, and dashpots resist that motion.
   pure subroutine stop_on(system, closed, gap, load, state, matrix, status)
      !> The system.
      type(system_type), intent(in) :: system
      !> What is closed from now on, and the gap that began to rest.
      integer, intent(in) :: closed(:), gap
      !> The coordinates of the load at this instant.
      complex(wp), intent(in) :: load(:)
      !> (2n) and (2n, 2n) In and out.
      complex(wp), intent(inout) :: state(:), matrix(:, :)
      !> `stat%ok` or `stat%singular`.
      integer, intent(out) :: status
      complex(wp), allocatable, dimension(:, :) :: damping, kicks, parts, rows
      complex(wp) :: carried(size(state)/2), closing(size(matrix, 2))
      integer, allocatable :: held(:)
      integer :: i, n

      n = size(state)/2
      allocate (damping, source=system%damping)
      do i = 1, size(closed)
         if (closed(i) < 0) cycle
         if (system%structure%elastic(closed(i))) damping = damping + system%numbers(2, &
            closed(i))*outer(system%directions(:, closed(i)), system%directions(:, closed(i)))
      end do
      carried = system%effective(gap)*matmul(system%by_force, matmul(damping, &
         system%mobility(:, gap)))
      closing = matmul(system%directions(:, gap), matrix(:n, :))
      state(n + 1:) = state(n + 1:) + carried*(sum(system%directions(:, gap)*state(:n)) &
         - sum(system%walls(:, gap, 0)*load))
      matrix(n + 1:, :) = matrix(n + 1:, :) + outer(carried, closing)
      ! velocities, and next to them their changes; friction that sticks holds them alone
      allocate (held, source=held_of(system%structure, closed))
      call set_contacts(system, held, rows, kicks)
      allocate (parts, source=matmul(rows, reshape([state(n + 1:), matrix(n + 1:, :)], [n, 1 &
         + size(matrix, 2)])))
      parts(:, 1) = parts(:, 1) - merge(system%numbers(3, held), matmul(load, system%walls(:, &
         held, 1)), system%structure%rubs(held))
      call solve_complex(matmul(rows, kicks), parts, status)
      if (status /= stat%ok) return
      state(n + 1:) = state(n + 1:) - matmul(kicks, parts(:, 1))
      matrix(n + 1:, :) = matrix(n + 1:, :) - matmul(kicks, parts(:, 2:))
      held = pack(held, .not. system%structure%rubs(held))
      call set_contacts(system, held, rows, kicks)
      parts = matmul(rows, reshape([state(:n), matrix(:n, :)], [n, 1 + size(matrix, 2)]))
      parts(:, 1) = parts(:, 1) - matmul(load, system%walls(:, held, 0))
      call solve_complex(matmul(rows, kicks), parts, status)
      state(:n) = state(:n) - matmul(kicks, parts(:, 1))
      matrix(:n, :) = matrix(:n, :) - matmul(kicks, parts(:, 2:))
   end subroutine stop_on

   !> Whether an impact and one on another gap are at one instant and act on each other, by the
   !! masses, or by dashpots, so that the order of both matters to first order.
   pure logical function is_coupled(structure, events, i)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The motion, and the number of the impact.
      type(events_type), intent(in) :: events
      integer, intent(in) :: i
      real(wp) :: time
      integer :: gap, j, kind, n, other

      is_coupled = .false.
      n = size(structure%mass, 1)
      gap = events%labels(2, i + 1)
      do j = i - 1, max(0, i - size(structure%openings)), -1
         kind = events%labels(1, j + 1)
         other = events%labels(2, j + 1)
         if (j == 0) then
            if (events%first == 0) return
            kind = impact_event
            other = events%first
         end if
         time = events%starts(1, i + 1) - events%starts(1, j + 1)
         if (abs(events%speeds(i + 1))*time > touching*dot_product(abs(structure%directions(:, &
            gap)), events%sizes(:n))) return
         if (kind /= impact_event .or. other == gap) cycle
         is_coupled = acts_on(structure, gap, other, by_dashpots=.true.)
         if (is_coupled) return
      end do
   end function is_coupled

   !> The end of the part of a flight within one interval of a record.
   pure subroutine next_part(load, begin, last, interval, end)
      !> The load.
      type(load_type), intent(in) :: load
      !> The time at which the part begins, and the end of the flight.
      real(wp), intent(in) :: begin, last
      !> The number of the interval from 0; 0 without a record.
      integer, intent(out) :: interval
      !> The time at which the part ends.
      real(wp), intent(out) :: end
      integer :: samples

      interval = 0
      end = last
      if (.not. load%step > 0) return
      samples = size(load%record, 2)
      interval = floor(min(begin/load%step, real(samples, wp))) + 1
      if (.not. interval*load%step > begin) interval = interval + 1
      if (interval < samples) end = min(last, interval*load%step)
      interval = floor(min(0.5_wp*(begin + end)/load%step, real(samples, wp)))
   end subroutine next_part

   !> Carries the motion, complex in its small changes, from its start through all events.
   pure subroutine carry_changes(system, events, start, columns, carried, status)
      !> The system.
      type(system_type), intent(in) :: system
      !> The motion, the real part.
      type(events_type), intent(in) :: events
      !> (2n) The state at the start.
      complex(wp), intent(in) :: start(:)
      !> 2n, or 0 if no derivatives with respect to the start are wanted.
      integer, intent(in) :: columns
      !> What is carried.
      type(carried_type), intent(out) :: carried
      !> `stat%ok`, `stat%singular` where gaps that depend on each other rest, or `stat%not_exact`.
      integer, intent(out) :: status
      complex(wp), parameter :: i_unit = (0.0_wp, 1.0_wp)
      complex(wp), allocatable, dimension(:, :) :: growth, turned, rate, contact, matrix, &
         touched_by
      complex(wp), allocatable, dimension(:) :: whole, moved, step, condition, after, load_then
      complex(wp), dimension(columns) :: row, by_start, by_speed, left_by, struck_by
      complex(wp) :: impulse, slope, speed
      real(wp) :: clock, closing, end, high, later, left, low, parting, residual, size_of, struck, &
         struck_later, instants(size(system%openings)), touched(size(system%openings))
      type(changes_type) :: changed
      integer, allocatable :: before(:), closed(:)
      real(wp) :: short, accelerations(size(start)/2)
      integer :: freed, gap, i, interval, kind, left_gap, n, number
      logical :: forced

      n = size(start)/2
      number = size(events%labels, 2) - 1
      allocate (carried%values(2*n + 3, number), carried%matrix(2*n, columns), &
         carried%slopes(2*n + 3, columns, number), touched_by(columns, size(touched)))
      carried%values = 0
      carried%slopes = 0
      carried%matrix = 0
      touched_by = 0
      carried%state = start
      carried%rate = 0*start
      carried%first_rate = carried%rate
      do i = 1, columns
         carried%matrix(i, i) = 1
      end do
      carried%good = number
      touched = 0
      instants = -huge(struck)
      struck = -huge(struck)
      struck_later = 0
      struck_by = 0
      left = 0
      left_by = 0
      parting = 0
      left_gap = 0
      short = instant*maxval(events%sizes(:n))/maxval(events%sizes(n + 1:))
      allocate (after, source=start)
      closed = events%closed
      status = stat%ok
      do i = 1, number + 1
         low = events%starts(1, i)
         kind = 0
         gap = 0
         end = events%end
         if (i <= number) then
            kind = events%labels(1, i + 1)
            gap = events%labels(2, i + 1)
            end = events%starts(1, i + 1)
         end if
         if (kind == impact_event) then
            if (is_coupled(system%structure, events, i)) carried%code = stat%no_derivative
            carried%good = i - 1
            if (carried%code /= stat%ok) return
         else if (kind == stick_event) then
            ! small changes rest from the last impact on
            call pass_label([kind, gap], closed)
            call stop_on(system, closed, gap, load_at(system, low*system%pace%re, 0), &
               carried%state, carried%matrix, status)
            if (status /= stat%ok) return
         end if
         moved = 0*start
         turned = 0*carried%matrix
         load_then = load_at(system, low*system%pace%re, 0)
         do
            call next_part(system%load, low, end, interval, high)
            call set_rate(system, closed, interval, rate, contact, status)
            if (status /= stat%ok) return
            whole = [carried%state, load_at(system, low*system%pace%re, interval)]
            if (i == 1 .and. .not. low > events%starts(1, 1)) carried%first_rate = matmul( &
               rate(:2*n, :), whole)
            call set_growth(rate*((high - low)*system%pace%re), growth)
            step = matmul(growth(:2*n, :), whole)
            matrix = matmul(growth(:2*n, :2*n), carried%matrix)
            carried%state = carried%state + step
            carried%matrix = carried%matrix + matrix
            moved = moved + step
            turned = turned + matrix
            low = high
            if (.not. low < end) exit
         end do
         clock = end*system%pace%re
         whole = [carried%state, load_at(system, clock, interval)]
         carried%rate = matmul(rate(:2*n, :), whole)
         carried%good = i - 1
         if (i == events%touched) carried%code = stat%graze
         if (i > number .or. carried%code /= stat%ok) return
         ! the change of the clock at the event, in imaginary steps and by the state at the start
         later = touched(gap)
         row = touched_by(:, gap)
         condition = 0*whole
         residual = 0
         by_start = row
         forced = .false.
         if (kind == impact_event) then
            condition(:n) = system%directions(:, gap)
            condition(2*n + 1:) = -system%walls(:, gap, 0)
            residual = aimag(sum(condition*whole))
            by_start = matmul(condition(:2*n), carried%matrix)
            if (left_gap == gap) then
               ! without the digits that cancel in the short hops of an accumulation
               residual = left + aimag(sum(condition(:2*n)*moved))
               if (system%structure%moves) residual = residual + aimag(sum(condition(2*n + 1:) &
                  *(whole(2*n + 1:) - load_then)))
               by_start = left_by + matmul(condition(:2*n), turned)
            end if
         else if (kind /= stick_event) then
            call set_condition(system, closed, [kind, gap], contact, condition)
            residual = aimag(sum(condition*whole))
            by_start = matmul(condition(:2*n), carried%matrix)
            size_of = sum(abs(condition)*abs(whole))
            if (kind /= release_event) size_of = sum(abs(condition(:2*n))*events%sizes) &
               + sum(abs(condition(2*n + 1:)*whole(2*n + 1:)))
            forced = abs(real(sum(condition*whole))) > exact*size_of .and. (kind == release_event &
               .or. kind >= let_go_event)
            freed = 0
            if (kind >= halt_event) freed = freed_by(system%structure, gap, instants, clock)
            if (freed > 0) then
               forced = .true.
               later = touched(freed)
               row = touched_by(:, freed)
            else if (forced) then
               ! what holds it, or its speed, jumped at another event or at the end of a record
               later = 0
               row = 0*row
               if (.not. abs(struck - clock) > 0) later = struck_later
               if (.not. abs(struck - clock) > 0) row = struck_by
            end if
         end if
         if (kind >= slip_up_event .and. .not. forced) then
            if (meets_another(system, events, i, short, closed, contact, whole)) carried%code = &
               stat%no_derivative
         end if
         if (kind /= stick_event .and. .not. forced) then
            closing = real(sum(condition*matmul(rate, whole)))
            size_of = touching*sum(abs(condition)*abs(matmul(rate, whole)))
            if (any(kind == [impact_event, touch_event, leave_event])) size_of = &
               touching*sum(abs(condition(:n))*events%sizes(n + 1:))/system%pace%re
            if (.not. (left_gap == gap .and. abs(parting) < 10*size_of) .and. &
               .not. abs(closing) > size_of) carried%code = stat%graze
            if (carried%code /= stat%ok) return
            later = -residual/closing
         end if
         matrix = carried%matrix + i_unit*later*matmul(rate(:2*n, :2*n), carried%matrix)
         whole = whole + i_unit*later*matmul(rate, whole)
         after = matmul(rate, whole)
         if (kind /= stick_event .and. .not. forced) then
            by_start = by_start + i_unit*later*matmul(matmul(condition, rate(:, :2*n)), &
               carried%matrix)
            row = -by_start/sum(condition*after)
         end if
         matrix = matrix + outer(after(:2*n), row)
         carried%values(1, i) = clock + i_unit*later
         carried%slopes(1, :, i) = row
         if (kind == impact_event .or. kind == release_event) then
            touched(gap) = later
            touched_by(:, gap) = row
            instants(gap) = clock
         end if
         if (kind == impact_event) then
            speed = sum(system%directions(:, gap)*whole(n + 1:2*n)) &
               - sum(system%walls(:, gap, 1)*whole(2*n + 1:))
            by_speed = matmul(system%directions(:, gap), matrix(n + 1:, :)) &
               - sum(system%walls(:, gap, 1)*after(2*n + 1:))*row
            call strike(system, gap, speed, impulse, slope)
            whole(n + 1:2*n) = whole(n + 1:2*n) - impulse*system%mobility(:, gap)
            matrix(n + 1:, :) = matrix(n + 1:, :) - slope*outer(system%mobility(:, gap), by_speed)
            carried%values(2:3, i) = [speed, impulse]
            carried%slopes(2, :, i) = by_speed
            carried%slopes(3, :, i) = slope*by_speed
         else if (kind >= touch_event .and. kind < halt_event) then
            speed = sum(system%directions(:, gap)*whole(n + 1:2*n)) &
               - sum(system%walls(:, gap, 1)*whole(2*n + 1:))
            carried%values(2, i) = sign(1.0_wp, speed%re)*speed
            carried%slopes(2, :, i) = sign(1.0_wp, speed%re)*(matmul(system%directions(:, gap), &
               matrix(n + 1:, :)) - sum(system%walls(:, gap, 1)*after(2*n + 1:))*row)
         end if
         ! the force of friction along a gap may jump when that is released
         if (kind == impact_event .or. (kind == release_event .and. system%structure%has_friction) &
            .or. (kind > release_event .and. .not. forced)) then
            struck = clock
            struck_later = later
            struck_by = row
         end if
         carried%values(4:, i) = whole(:2*n)
         carried%slopes(4:, :, i) = matrix
         associate (recorded => events%starts(2:, i + 1))
            if (.not. all(abs(real(whole(:2*n)) - recorded) < exact*events%sizes)) status = &
               stat%not_exact
            if (status /= stat%ok) return
            ! back to the fixed time of the event, with the rate after it
            whole(:2*n) = cmplx(recorded, aimag(whole(:2*n)), wp)
         end associate
         if (allocated(changed%elements)) then
            if (end - events%starts(1, i) > short) deallocate (changed%elements, changed%later)
         end if
         if (allocated(before)) deallocate (before)
         allocate (before, source=closed)
         accelerations = real(after(n + 1:2*n))
         if (kind /= stick_event .and. kind > 0) call pass_label([kind, gap], closed)
         if (kind == impact_event) call slip_at_once(system%structure, events, i, closed)
         call set_rate(system, closed, interval, rate, contact, status)
         if (status /= stat%ok) return
         after = matmul(rate, whole)
         accelerations = abs(real(after(n + 1:2*n)) - accelerations)
         if (kind > stick_event) call note_change(system%structure, before, kind, gap, forced, &
            any(accelerations > touching*maxval(abs(real(after)))), [later, real(row)], changed, &
            carried%code)
         if (carried%code /= stat%ok) return
         matrix = matrix - outer(after(:2*n), row)
         left_gap = 0
         if (kind == impact_event) then
            left_gap = gap
            speed = sum(condition*after)
            parting = real(speed)
            left = -later*parting
            left_by = -speed*row - i_unit*later*matmul(matmul(condition, rate(:, :2*n)), matrix)
         end if
         carried%matrix = matrix - i_unit*later*matmul(rate(:2*n, :2*n), matrix)
         carried%state = whole(:2*n) - i_unit*later*after(:2*n)
      end do
   end subroutine carry_changes

   !> Notes a change of an element, or that the last one brings about a further one, and whether the
   !! order of changes at one instant matters: to their instants and speeds it does so even where
   !! the state after them does not depend on it.
   pure subroutine note_change(structure, closed, kind, number, forced, jumps, later, changed, &
      code)
      !> The structure, and what is closed before the event.
      type(structure_type), intent(in) :: structure
      integer, intent(in) :: closed(:)
      !> Kind and element of the event.
      integer, intent(in) :: kind, number
      !> Whether another event at this instant brings it about; whether accelerations jump.
      logical, intent(in) :: forced, jumps
      !> The changes of its time, by the parameter and by the state at the start.
      real(wp), intent(in) :: later(:)
      !> In and out: the changes at this instant.
      type(changes_type), intent(inout) :: changed
      !> In and out: `stat%no_derivative` if it does.
      integer, intent(inout) :: code
      integer :: change
      logical :: commute

      commute = .true.
      if (.not. forced) then
         change = smooth_change
         if (jumps) change = merge(breakaway, ordered_change, any(closed == number))
         call add_change(structure, closed, kind, number, change, later, changed, commute)
      else if (allocated(changed%elements)) then
         changed%elements(2, :) = breakaway
         call add_change(structure, closed, kind, changed%elements(1, size(changed%elements, 2)), &
            breakaway, changed%later(:, size(changed%elements, 2)), changed, commute)
      end if
      if (.not. commute) code = stat%no_derivative
   end subroutine note_change

   !> Whether friction breaks away where other friction that would follow it is at its own limit.
   pure logical function meets_another(system, events, i, short, closed, contact, whole) &
      result(meets)
      !> The system.
      type(system_type), intent(in) :: system
      !> The motion, and the number of the event.
      type(events_type), intent(in) :: events
      integer, intent(in) :: i
      !> The longest time between events at one instant.
      real(wp), intent(in) :: short
      !> What is closed before it, and the forces there, as of `set_rate`.
      integer, intent(in) :: closed(:)
      complex(wp), intent(in) :: contact(:, :)
      !> (2n + load) State and load before it.
      complex(wp), intent(in) :: whole(:)
      complex(wp) :: condition(size(whole))
      integer, allocatable :: linked(:)
      integer :: j

      meets = .false.
      associate (gap => events%labels(2, i + 1))
         associate (numbers => system%structure%laws(gap)%numbers)
            if (all(closed /= gap) .or. .not. numbers(2) > numbers(1)) return
         end associate
         linked = linked_elements(system%structure, gap, pack(closed, closed > 0), .true.)
      end associate
      do j = i + 2, size(events%labels, 2)
         if (events%starts(1, j) - events%starts(1, i + 1) > short) return
         associate (kind => events%labels(1, j), number => events%labels(2, j))
            if (kind < slip_up_event .or. all(linked /= number)) cycle
            call set_condition(system, closed, [kind, number], contact, condition)
            meets = abs(real(sum(condition*whole))) <= exact*sum(abs(condition)*abs(whole))
         end associate
         if (meets) return
      end do
   end function meets_another

   !> A gap of which an impact or the release at an instant changes how friction slips; 0 if there
   !! is none. Uncoupled friction that changes at that instant, too, is at a limit of its own.
   pure integer function freed_by(structure, number, instants, clock) result(gap)
      !> The structure, and the number of the friction.
      type(structure_type), intent(in) :: structure
      integer, intent(in) :: number
      !> (gaps) When each was hit or released last, and the instant.
      real(wp), intent(in) :: instants(:), clock
      integer :: j

      gap = 0
      do j = 1, size(instants)
         if (abs(instants(j) - clock) > 0) cycle
         if (acts_on(structure, j, number)) gap = j
      end do
   end function freed_by

   !> Lets friction slip that stuck before an impact and has a speed after it: a rest may begin
   !! before that event is reported.
   pure subroutine slip_at_once(structure, events, i, closed)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The motion, and the number of the impact.
      type(events_type), intent(in) :: events
      integer, intent(in) :: i
      !> In and out: what is closed.
      integer, allocatable, intent(inout) :: closed(:)
      integer :: j

      do j = i + 2, size(events%labels, 2)
         if (events%starts(1, j) > events%starts(1, i + 1)) return
         associate (kind => events%labels(1, j), number => events%labels(2, j))
            if (kind < slip_up_event .or. all(closed /= number)) cycle
            if (acts_on(structure, events%labels(2, i + 1), number)) call pass_label( &
               events%labels(:, j), closed)
         end associate
      end do
   end subroutine slip_at_once

   !> The function of the state and the load that is 0 at an event.
   pure subroutine set_condition(system, closed, label, contact, condition)
      !> The system.
      type(system_type), intent(in) :: system
      !> What is closed before it, and its kind and gap.
      integer, intent(in) :: closed(:), label(2)
      !> As of `set_rate`.
      complex(wp), intent(in) :: contact(:, :)
      !> (2n + load)
      complex(wp), intent(out) :: condition(:)
      integer :: i, n

      n = size(system%by_force, 1)
      condition = 0
      associate (gap => label(2), row => system%directions(:, label(2)), &
         numbers => system%numbers(:, label(2)), constant => condition(2*n + 1), &
         held => held_of(system%structure, closed))
         select case (label(1))
         case (touch_event, leave_event)
            condition(:n) = row
            condition(2*n + 1:) = -system%walls(:, gap, 0)
         case (let_go_event, press_event)
            condition(:n) = numbers(1)*row
            condition(n + 1:2*n) = numbers(2)*row
            condition(2*n + 1:) = -numbers(1)*system%walls(:, gap, 0) &
               - numbers(2)*system%walls(:, gap, 1)
            constant = constant + numbers(3)
         case (release_event)
            condition = contact(findloc(held, gap, 1), :)
            do i = 1, size(system%openings)
               ! friction along it holds, too
               constant = constant + abs(factor_along(system%structure, i, gap)) &
                  *system%numbers(2, i)
            end do
         case default
            if (any(held == gap)) then
               condition = contact(findloc(held, gap, 1), :)
               constant = constant - merge(1, -1, label(1) == slip_up_event)*numbers(2)
            else
               condition(n + 1:2*n) = row
               constant = -numbers(3)
            end if
         end select
      end associate
   end subroutine set_condition

   !> The derivatives of a simulated motion with respect to its start and to parameters.
   pure subroutine gradient_arrays(structure, load, entries, by_entries, by_record, by_start, &
      events, values, finals, matrices, slopes, rates, opens, good, code, status)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      type(load_type), intent(in) :: load
      !> (3, m) Entries, as of vi_structure_path; (m, 0:parameters) their derivatives, and those of
      !! a factor of the record; 0 for number 0.
      integer, intent(in) :: entries(:, :)
      real(wp), intent(in) :: by_entries(:, 0:), by_record(0:)
      !> (2n, 0:parameters) The derivatives of the start.
      real(wp), intent(in) :: by_start(:, 0:)
      !> In: the motion. Out: with the gaps that rest at its start.
      type(events_type), intent(inout) :: events
      !> (2n + 3, events, 0:parameters), (2n, 0:parameters) and (2n, 2n, 0:parameters) Derivatives
      !! of the values at the events, of the state at the end, and, of a period, of the matrix
      !! there; number 0 is the matrix itself.
      real(wp), intent(out) :: values(:, :, 0:), finals(:, 0:), matrices(:, :, 0:)
      !> (2n + 3, 2n, events) Those of the values by the state at the start; (2n, 2) the rates of
      !! the state at the start and at the end.
      real(wp), intent(out) :: slopes(:, :, :), rates(:, :)
      !> (0:parameters) Whether a gap that rests at the start would not stay closed.
      logical, intent(out) :: opens(0:)
      !> As in `carried_type`.
      integer, intent(out) :: good, code
      !> `stat%ok`, or as in `carry_changes` and `sample_structure_arrays`.
      integer, intent(out) :: status
      type(structure_type) :: checked, by
      type(load_type) :: load_by, driving
      type(system_type) :: system
      type(carried_type) :: carried
      integer, allocatable :: held(:)
      integer :: i, j, n, number

      n = size(structure%mass, 1)
      values = 0
      finals = 0
      matrices = 0
      slopes = 0
      rates = 0
      opens = .false.
      good = 0
      code = 0
      checked = structure
      call check_structure(checked, status)
      if (status /= stat%ok) return
      call closed_at_start(structure, load, events%starts(:, 1), events%closed, status)
      if (status /= stat%ok) return
      allocate (held, source=held_of(checked, events%closed))
      ! a wall can move with more harmonics than the load has
      driving = load
      if (structure%moves) then
         associate (harmonics => max(size(load%sine, 2), size(structure%motion, 1)))
            driving%cosine = reshape([load%cosine], [n, harmonics], pad=[0.0_wp])
            driving%sine = reshape([load%sine], [n, harmonics], pad=[0.0_wp])
         end associate
      end if
      number = size(events%labels, 2) - 1
      do i = 0, ubound(by_entries, 2)
         by = new_structure(reshape([(0.0_wp, j=1, 3*n*n)], [n, n, 3]), 0*structure%directions, &
            reshape([(0.0_wp, j=1, 2*size(structure%openings))], [2, size(structure%openings)]))
         do j = 1, size(structure%openings)
            by%laws(j)%numbers = 0
         end do
         by%motion = 0*structure%motion
         load_by = new_load(0.0_wp, reshape([(0.0_wp, j=1, 2*size(driving%sine))], [n, 2, &
            size(driving%sine, 2)]), 0*load%constant)
         do j = 1, size(entries, 2)
            if (abs(by_entries(j, i)) > 0) call set_entry(by, load_by, entries(:, j), &
               by_entries(j, i))
         end do
         associate (q => events%starts(2:n + 1, 1), rate => events%starts(n + 2:, 1))
            do j = 1, size(held)
               associate (k => held(j))
                  if (checked%rubs(k)) then
                     opens(i) = opens(i) .or. abs(dot_product(rate, by%directions(:, k)) &
                        - by%laws(k)%numbers(3)) > 0
                  else
                     opens(i) = opens(i) .or. abs(dot_product(q, by%directions(:, k)) &
                        - by%openings(k)) + abs(dot_product(rate, by%directions(:, k))) > 0
                     ! a wall that moves is elsewhere, or has another speed
                     opens(i) = opens(i) .or. any(abs(by%motion(:, k)) > 0) .or. &
                        (abs(load_by%frequency) > 0 .and. any(abs(structure%motion(:, k)) > 0))
                  end if
               end associate
            end do
         end associate
         call new_system(checked, driving, by, load_by, by_record(i), events%first > 0, system, &
            status)
         if (status /= stat%ok) return
         call carry_changes(system, events, with(events%starts(2:, 1), by_start(:, i)), &
            merge(2*n, 0, events%first > 0 .or. i == 0), carried, status)
         if (status /= stat%ok) return
         values(:, :number, i) = aimag(carried%values)/imaginary
         finals(:, i) = aimag(carried%state)/imaginary
         if (i == 0) then
            good = carried%good
            code = carried%code
            matrices(:, :, 0) = real(carried%matrix, wp)
            slopes(:, :, :number) = real(carried%slopes, wp)
            rates(:, 1) = real(carried%first_rate, wp)
            rates(:, 2) = real(carried%rate, wp)
         else if (events%first > 0) then
            matrices(:, :, i) = aimag(carried%matrix)/imaginary
         end if
      end do
   end subroutine gradient_arrays

end module vi_structure_gradient
