!> Periodic motions of a structure with stops, friction or rests from presumed instants of their
!! events.
!!
!! Given the events and their instants, the regimes follow, and all else is linear. Unknown are the
!! state just before the first event and the approach speeds of impacts on gaps. Equations: at each
!! event the function that brings it about is at its limit, each approach speed is that of the
!! motion, and the period closes. DGELS solves them; the residual measures how far the instants are
!! from those of a motion. A rest begins at the instant of an impact with R = 0: before one with R
!! above 0 there are infinitely many impacts.
module vi_presumed_events
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_channels, only: row_derivatives
   use vi_exact, only: exact_acceptance
   use vi_kinds, only: two_pi, wp
   use vi_lapack, only: least_squares, least_squares_work
   use vi_modes, only: advance
   use vi_motion, only: no, unknown, yes
   use vi_status, only: stat
   use vi_structure, only: factor_along, linked_elements, load_type, opening_at, regime_type, &
      restitution_of, state_of, structure_type, to_pairs
   use vi_structure_map, only: apply_flight, from_coordinates, to_coordinates
   use vi_structure_return, only: closed_type, keep_period, most_events, one_cycle, settle, &
      settled_type
   use vi_structure_run, only: event_kinds, find_regime, halt_event, impact_event, is_listed, &
      leave_event, let_go_event, new_run, pass_label, press_event, release_event, run_event_type, &
      run_state_type, run_type, slip_down_event, slip_up_event, start_at, stick_event, touch_event
   use vi_structure_variation, only: derivative_of_run
   use vi_text, only: whole
   implicit none (type, external)
   private

   public :: kinds_of, presume, sequence_fault

   !> Affine functions of the unknowns: their derivatives, and their values where all are 0.
   type :: affine_type
      !> (2m, unknowns) Derivatives of the pairs, x before v.
      real(wp), allocatable :: d(:, :)
      !> (m) The pairs.
      real(wp), allocatable :: x(:), v(:)
   end type affine_type

   !> Equations a u = right of the unknowns u.
   type :: equations_type
      !> (equations, unknowns) and (equations); (equations) the size of a limit in each.
      real(wp), allocatable :: a(:, :), right(:), extra(:)
      !> Number of those that are filled in.
      integer :: n = 0
   end type equations_type

contains

   !> The numbers of kinds of events.
   pure function kinds_of(words) result(kinds)
      !> Their names.
      character(*), intent(in) :: words(:)
      integer :: kinds(size(words))
      character(:), allocatable :: names
      integer :: i, j

      names = ','//event_kinds//','
      do i = 1, size(words)
         kinds(i) = count([(names(j:j) == ',', j=1, index(names, ','//trim(words(i))//','))])
      end do
   end function kinds_of

   !> Why events cannot follow each other in a period; empty if they can.
   pure subroutine sequence_fault(structure, gaps, kinds, phases, text)
      !> The structure, checked.
      type(structure_type), intent(in) :: structure
      !> (N) The gap, stop or friction of each event, and its kind.
      integer, intent(in) :: gaps(:), kinds(:)
      !> (N) Their load phases, increasing.
      real(wp), intent(in) :: phases(:)
      !> The reason.
      character(:), allocatable, intent(out) :: text
      integer, allocatable :: closed(:)
      integer :: i, k
      logical :: good

      text = ''
      call set_at_start(structure, gaps, kinds, closed)
      do i = 1, size(gaps)
         if (kinds(i) /= stick_event) cycle
         if (structure%elastic(gaps(i)) .or. structure%rubs(gaps(i))) cycle
         if (.not. structure%restitution(gaps(i)) > 0) cycle
         text = 'a rest begins on gap '//whole(gaps(i) - 1)//', whose restitution is above 0: &
            &infinitely many impacts come before it; use exact or kind = ''settled'''
         return
      end do
      do i = 1, size(structure%openings)
         if (.not. structure%rubs(i) .or. any(gaps == i)) cycle
         if (abs(structure%laws(i)%numbers(3)) > 0) cycle
         text = 'element '//whole(i - 1)//' is friction without a belt and must have an event'
         return
      end do
      do i = 1, size(gaps)
         associate (j => gaps(i), before => any(closed == gaps(i)), &
            other => any(closed == -gaps(i)))
            select case (kinds(i))
            case (impact_event)
               good = .not. (structure%elastic(j) .or. structure%rubs(j) .or. before)
               if (good) good = .not. any([(any(closed == structure%coupled(k)), k= &
                  structure%coupled_begins(j), structure%coupled_begins(j + 1) - 1)])
            case (stick_event)
               ! only the impact on it comes before it at its instant, and what that changes
               good = .not. (structure%elastic(j) .or. structure%rubs(j) .or. before) .and. i > 1
               if (good) good = any(kinds(:i - 1) == impact_event .and. gaps(:i - 1) == j .and. &
                  phases(:i - 1) >= phases(i))
            case (release_event)
               good = .not. (structure%elastic(j) .or. structure%rubs(j)) .and. before
            case (touch_event)
               good = structure%elastic(j) .and. .not. (before .or. other)
            case (leave_event)
               good = structure%elastic(j) .and. (before .or. other)
            case (let_go_event)
               good = structure%push(j) > 0 .and. before
            case (press_event)
               good = structure%push(j) > 0 .and. other
            case (halt_event)
               good = structure%rubs(j) .and. .not. before
            case (slip_up_event)
               good = structure%rubs(j) .and. (before .or. other)
            case (slip_down_event)
               good = structure%rubs(j) .and. .not. other
            case default
               good = .false.
            end select
            if (.not. good) text = 'event number '//whole(i)//' cannot occur at element '// &
               whole(j - 1)//' after the preceding events of the period'
            if (.not. good) return
            call pass_label([kinds(i), j], closed)
         end associate
      end do
   end subroutine sequence_fault

   !> What is closed before the first event: the same as after the last one. Friction without an
   !! event slips against its belt.
   pure subroutine set_at_start(structure, gaps, kinds, closed)
      !> As in `sequence_fault`.
      type(structure_type), intent(in) :: structure
      integer, intent(in) :: gaps(:), kinds(:)
      !> The set, as in `regime_type`.
      integer, allocatable, intent(out) :: closed(:)
      integer :: i

      allocate (closed(0))
      do i = 1, size(structure%openings)
         if (.not. structure%rubs(i) .or. any(gaps == i)) cycle
         if (structure%laws(i)%numbers(3) > 0) call pass_label([slip_down_event, i], closed)
      end do
      do i = 1, size(gaps)
         call pass_label([kinds(i), gaps(i)], closed)
      end do
   end subroutine set_at_start

   !> The motion whose events are presumed.
   subroutine presume(structure, load, gaps, kinds, phases, cycles, refined, found, status, &
      progress)
      !> The structure and its load, with a frequency > 0.
      type(structure_type), intent(in) :: structure
      type(load_type), intent(in) :: load
      !> (N) The gap, stop or friction of each event, and its kind; without `sequence_fault`.
      integer, intent(in) :: gaps(:), kinds(:)
      !> (N) Their load phases (rad), increasing, within less than a period.
      real(wp), intent(in) :: phases(:)
      !> Load cycles in a period.
      integer, intent(in) :: cycles
      !> Whether the instants are a guess of those of an exact motion.
      logical, intent(in) :: refined
      !> The motion.
      type(settled_type), intent(out) :: found
      !> `stat%ok`, `stat%singular` where these events do not determine one motion, or as in
      !! `new_regime` and, of an exact motion, `settle`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(run_type) :: run
      type(run_event_type), allocatable :: events(:)
      type(run_state_type) :: begun, last
      type(equations_type) :: equations
      integer, allocatable :: causes(:)
      real(wp), allocatable :: u(:), p(:, :)
      real(wp) :: largest, residual, time
      integer :: after, n

      call new_run(structure, load, run, status)
      if (status /= stat%ok) return
      n = size(run%structure%mass, 1)
      call place_events(run, gaps, kinds, phases, events, causes, begun, status)
      if (status /= stat%ok) return
      last = begun
      last%cycle = last%cycle + cycles
      allocate (u(2*n + count(kinds == impact_event)), source=0.0_wp)
      call set_equations(run, begun, events, causes, last, equations)
      call solve_scaled(run, equations, u, residual, status)
      if (status /= stat%ok) return
      call fill_states(run, begun, events, last, u)
      if (refined) then
         call between_events(run, events, last, after, time, u(:n), u(n + 1:2*n))
         call settle(structure, load, time, u(:n), u(n + 1:2*n), 0, cycles, cycles, found, status, &
            progress)
         return
      end if
      found%cycles = cycles
      found%motion%residual = residual
      allocate (p(2*n, 2*n), source=ieee_value(1.0_wp, ieee_quiet_nan))
      largest = 1
      found%motion%verdicts%law = p(1, 1)
      if (residual <= exact_acceptance) then
         call derivative_of_run(run, begun, events, last, p, largest, found%motion%verdicts%law, &
            status)
         if (status == stat%zero_approach .or. (status == stat%no_derivative .and. &
            .not. any(events%together))) then
            p = ieee_value(1.0_wp, ieee_quiet_nan)
            status = stat%ok
         end if
         if (status /= stat%ok) return
      end if
      call keep_period(run, begun, events, last, p, largest, .false., found)
      ! as they were given, but that simulations begin at times from 0 on
      found%motion%phases = pack(phases, is_listed(events)) &
         + two_pi*max(0, ceiling(-phases(1)/two_pi))
      associate (verdicts => found%motion%verdicts)
         if (verdicts%consistent == yes) then
            call simulate_events(run, begun, events, last, verdicts%admissible)
         else
            verdicts%stable = unknown
         end if
      end associate
   end subroutine presume

   !> The events without their states, and the place before the first one.
   subroutine place_events(run, gaps, kinds, phases, events, causes, begun, status)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> As in `presume`.
      integer, intent(in) :: gaps(:), kinds(:)
      real(wp), intent(in) :: phases(:)
      !> (N) Kinds, gaps, regimes and times.
      type(run_event_type), allocatable, intent(out) :: events(:)
      !> (N) As of `cause_of`.
      integer, allocatable, intent(out) :: causes(:)
      !> Regime and time just before the first one.
      type(run_state_type), intent(out) :: begun
      !> `stat%ok`, or as in `new_regime`.
      integer, intent(out) :: status
      integer, allocatable :: closed(:)
      type(closed_type), allocatable :: after(:)
      logical :: jumps(size(gaps))
      real(wp) :: first, turns
      integer :: i, j, last

      allocate (events(size(gaps)), causes(size(gaps)), after(size(gaps)))
      call set_at_start(run%structure, gaps, kinds, closed)
      call find_regime(run, closed, begun%regime, status)
      first = two_pi*max(0, ceiling(-phases(1)/two_pi))
      last = begun%regime
      do i = 1, size(gaps)
         if (status /= stat%ok) return
         turns = (phases(i) + first)/two_pi
         events(i)%cycle = floor(turns, int64)
         events(i)%elapsed = max(0.0_wp, phases(i) + first - two_pi*real(events(i)%cycle, wp)) &
            *(run%period/two_pi)
         events(i)%kind = kinds(i)
         events(i)%gap = gaps(i)
         call pass_label([kinds(i), gaps(i)], closed)
         after(i)%set = closed
         jumps(i) = force_jumps(run%structure, run%regimes(last), events(i))
         causes(i) = cause_of(run%structure, run%regimes(last), events, jumps, i)
         call find_regime(run, closed, events(i)%regime, status)
         last = events(i)%regime
         if (causes(i) == 0 .or. kinds(i) == stick_event) cycle
         ! an event already leads to what it brings about
         do j = causes(i), i - 1
            if (status /= stat%ok) return
            call pass_label([kinds(i), gaps(i)], after(j)%set)
            call find_regime(run, after(j)%set, events(j)%regime, status)
         end do
      end do
      begun%cycle = events(1)%cycle
      begun%elapsed = events(1)%elapsed
   end subroutine place_events

   !> The event that brings about another one at its instant, which then has no equation: a rest
   !! begins after an impact on its gap, friction and the force of a stop change with the speeds
   !! that an impact changes, friction that sticks slips and a gap is released where a force jumps.
   !! 0 if there is none.
   pure integer function cause_of(structure, before, events, jumps, i) result(cause)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The regime before the event.
      type(regime_type), intent(in) :: before
      !> The events, whether a force or a velocity jumps at each of them up to this one, and its
      !! number.
      type(run_event_type), intent(in) :: events(:)
      logical, intent(in) :: jumps(:)
      integer, intent(in) :: i
      integer, allocatable :: linked(:)
      integer :: j
      logical :: yields

      cause = 0
      if (any(events(i)%kind == [impact_event, touch_event, leave_event])) return
      yields = any(before%held == events(i)%gap) .and. events(i)%kind /= halt_event
      allocate (linked, source=linked_elements(structure, events(i)%gap, [before%held, &
         pack(events(:i - 1)%gap, events(:i - 1)%cycle == events(i)%cycle .and. &
         events(:i - 1)%elapsed >= events(i)%elapsed)]))
      do j = i - 1, 1, -1
         if (events(j)%cycle /= events(i)%cycle .or. events(j)%elapsed < events(i)%elapsed) return
         select case (events(j)%kind)
         case (impact_event)
            if (events(i)%kind /= stick_event .or. events(j)%gap == events(i)%gap) cause = j
         case (release_event)
            if (events(i)%kind >= slip_up_event) then
               if (abs(factor_along(structure, events(i)%gap, events(j)%gap)) > 0) cause = j
            end if
         case default
         end select
         ! the first of them brings about the others that it acts on
         if (yields .and. jumps(j) .and. any(linked == events(j)%gap)) cause = j
         if (cause > 0 .and. .not. yields) return
      end do
   end function cause_of

   !> Whether a force or a velocity jumps at an event. Those of a stop whose force or depth is 0 do
   !! not, nor does friction that slips at the force at which it stuck.
   pure logical function force_jumps(structure, before, event) result(jumps)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The regime before the event.
      type(regime_type), intent(in) :: before
      !> The event.
      type(run_event_type), intent(in) :: event

      associate (numbers => structure%laws(event%gap)%numbers)
         select case (event%kind)
         case (touch_event, leave_event)
            jumps = any(abs(numbers(2:3)) > 0)
         case (let_go_event, press_event, release_event)
            jumps = .false.
         case (slip_up_event, slip_down_event)
            jumps = all(before%held /= event%gap) .or. numbers(2) > numbers(1)
         case default
            jumps = .true.
         end select
      end associate
   end function force_jumps

   !> The equations of all events, and that the period closes.
   subroutine set_equations(run, begun, events, causes, last, equations)
      !> The run, with the regimes.
      type(run_type), intent(in) :: run
      !> The place before the first event, the events, and the place a period later.
      type(run_state_type), intent(in) :: begun, last
      type(run_event_type), intent(in) :: events(:)
      !> (N) As of `cause_of`.
      integer, intent(in) :: causes(:)
      !> The equations.
      type(equations_type), intent(out) :: equations
      type(affine_type) :: at
      real(wp), allocatable :: p(:, :), q(:), rate(:)
      real(wp) :: start(2*size(run%structure%mass, 1), 2*size(run%structure%mass, 1)), elapsed
      integer(int64) :: cycle
      integer :: hits, i, n, regime, rows, unknowns

      n = size(start, 1)/2
      hits = count(events%kind == impact_event)
      unknowns = 2*n + hits
      rows = count(causes == 0) + hits + 2*n
      allocate (equations%a(rows, unknowns), equations%right(rows), equations%extra(rows), &
         source=0.0_wp)
      allocate (p(2*n, unknowns), q(n), rate(n), source=0.0_wp)
      start = 0
      do i = 1, 2*n
         start(i, i) = 1
      end do
      p(:, :2*n) = start
      regime = begun%regime
      call enter_affine(run, regime, run%load%frequency*begun%elapsed, p, q, rate, at)
      hits = 0
      cycle = begun%cycle
      elapsed = begun%elapsed
      do i = 1, size(events)
         call fly(run%regimes(regime), apart(run, cycle, elapsed, events(i)%cycle, &
            events(i)%elapsed), at)
         cycle = events(i)%cycle
         elapsed = events(i)%elapsed
         if (causes(i) > 0) then
            call change_regime(run, regime, events(i), at)
            regime = events(i)%regime
            cycle
         end if
         if (events(i)%kind == impact_event) hits = hits + 1
         call add_event(run, regime, events(i), 2*n + hits, at, equations)
         regime = events(i)%regime
      end do
      call fly(run%regimes(regime), apart(run, cycle, elapsed, last%cycle, last%elapsed), at)
      call to_coordinates(run%regimes(regime), at%d, p)
      call state_of(run%regimes(regime), run%load%frequency*last%elapsed, at%x, at%v, q, rate)
      p(:, :2*n) = p(:, :2*n) - start
      associate (first => equations%n + 1, final => equations%n + 2*n)
         equations%a(first:final, :) = p
         equations%right(first:final) = -[q, rate]
      end associate
      equations%n = equations%n + 2*n
   end subroutine set_equations

   !> Adds the equations of an event, and advances through it.
   subroutine add_event(run, number, event, unknown_speed, at, equations)
      !> The run.
      type(run_type), intent(in) :: run
      !> The regime before the event, and the event.
      integer, intent(in) :: number
      type(run_event_type), intent(in) :: event
      !> The place of its approach speed among the unknowns, if it is an impact.
      integer, intent(in) :: unknown_speed
      !> In: just before it. Out: just after it.
      type(affine_type), intent(inout) :: at
      !> In and out: the equations.
      type(equations_type), intent(inout) :: equations
      !> Share of the largest terms that a coefficient can have that counts as rounding.
      real(wp), parameter :: rounding = 64*epsilon(1.0_wp)
      real(wp), allocatable :: p(:, :)
      real(wp), dimension(size(run%structure%mass, 1)) :: q, rate
      real(wp) :: coefficients(size(at%d, 2)), d(0:3)
      real(wp) :: impulse, largest, limit, phase, restitution, slope
      integer :: m, n, row, wall

      n = size(q)
      phase = run%load%frequency*event%elapsed
      associate (regime => run%regimes(number), structure => run%structure)
         m = size(at%x)
         call find_limit(structure, regime, event, row, wall, limit)
         call row_derivatives(regime, at%x, at%v, phase, row, d)
         largest = abs(limit)
         coefficients = matmul(regime%position(row, :), at%d(:m, :)) &
            + matmul(regime%velocity(row, :), at%d(m + 1:, :))
         ! after an impact with R = 0 what moves with its gap does not depend on the unknowns
         where (abs(coefficients) <= rounding*(sum(abs(regime%position(row, :)))* &
            maxval(abs(at%d(:m, :)), 1) + sum(abs(regime%velocity(row, :)))* &
            maxval(abs(at%d(m + 1:, :)), 1))) coefficients = 0
         if (.not. maxval(abs(coefficients)) > 0) largest = largest &
            + dot_product(abs(regime%position(row, :)), abs(at%x)) &
            + dot_product(abs(regime%velocity(row, :)), abs(at%v)) &
            + abs(regime%rows%offset(row)) + sum(regime%rows%ripple_size(row, :))
         call add(equations, coefficients, limit - d(0), largest)
         allocate (p(2*n, size(at%d, 2)))
         call to_coordinates(regime, at%d, p)
         call state_of(regime, phase, at%x, at%v, q, rate)
         if (event%kind == impact_event) then
            associate (by_speed => wall*(matmul(regime%rate_position(row, :), at%d(:m, :)) &
               + matmul(regime%rate_velocity(row, :), at%d(m + 1:, :))))
               call add(equations, [by_speed(:unknown_speed - 1), by_speed(unknown_speed) - 1, &
                  by_speed(unknown_speed + 1:)], -wall*d(1), 0.0_wp)
            end associate
            call restitution_of(structure, event%gap, 0.0_wp, restitution, slope)
            impulse = (1 + restitution)*structure%effective(event%gap)
            p(n + 1:, unknown_speed) = p(n + 1:, unknown_speed) - impulse*structure%mobility(:, &
               event%gap)
         end if
      end associate
      call enter_affine(run, event%regime, phase, p, q, rate, at)
   end subroutine add_event

   !> Changes the regime at an event that another one brings about.
   pure subroutine change_regime(run, number, event, at)
      !> The run.
      type(run_type), intent(in) :: run
      !> The regime before the event, and the event.
      integer, intent(in) :: number
      type(run_event_type), intent(in) :: event
      !> In: just before it. Out: just after it.
      type(affine_type), intent(inout) :: at
      real(wp), allocatable :: p(:, :)
      real(wp), dimension(size(run%structure%mass, 1)) :: q, rate
      real(wp) :: phase

      if (event%regime == number) return
      phase = run%load%frequency*event%elapsed
      allocate (p(2*size(q), size(at%d, 2)))
      call to_coordinates(run%regimes(number), at%d, p)
      call state_of(run%regimes(number), phase, at%x, at%v, q, rate)
      call enter_affine(run, event%regime, phase, p, q, rate, at)
   end subroutine change_regime

   !> Adds an equation.
   pure subroutine add(equations, coefficients, right, extra)
      !> In and out: the equations.
      type(equations_type), intent(inout) :: equations
      !> (unknowns), the right side, and the size of a limit in it.
      real(wp), intent(in) :: coefficients(:), right, extra

      equations%n = equations%n + 1
      equations%a(equations%n, :) = coefficients
      equations%right(equations%n) = right
      equations%extra(equations%n) = extra
   end subroutine add

   !> The row of the regime before an event that is at its limit there, and the limit.
   pure subroutine find_limit(structure, regime, event, row, wall, limit)
      !> The structure, the regime and the event.
      type(structure_type), intent(in) :: structure
      type(regime_type), intent(in) :: regime
      type(run_event_type), intent(in) :: event
      !> The row, and +1 for its upper or -1 for its lower limit, which is the third.
      integer, intent(out) :: row, wall
      real(wp), intent(out) :: limit

      associate (j => event%gap)
         row = structure%channel(j)
         wall = 1
         limit = 0
         select case (event%kind)
         case (impact_event)
            wall = structure%wall(j)
            limit = wall*structure%openings(j)
         case (touch_event)
            limit = structure%openings(j)
         case (leave_event)
            wall = -1
            limit = structure%openings(j)
         case (let_go_event)
            row = structure%push(j)
            wall = -1
         case (press_event)
            row = structure%push(j)
         case (release_event)
            ! the force of the wall
            row = structure%channels + findloc(regime%resting, j, dim=1)
            wall = -1
         case default
            if (any(regime%held == j)) then
               ! what holds it is at the stick level
               row = structure%channels + findloc(regime%held, j, dim=1)
               wall = merge(1, -1, event%kind == slip_up_event)
               limit = wall*structure%laws(j)%numbers(2)
            else
               wall = merge(1, -1, any(regime%closed == -j))
            end if
         end select
      end associate
   end subroutine find_limit

   !> Advances affine functions by a flight.
   pure subroutine fly(regime, time, at)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> How long.
      real(wp), intent(in) :: time
      !> In and out.
      type(affine_type), intent(inout) :: at
      real(wp), dimension(size(at%x)) :: x, v

      call advance(regime%modes, time, at%x, at%v, x, v)
      at%x = x
      at%v = v
      call apply_flight(regime, time, at%d)
   end subroutine fly

   !> Affine functions of a state as those of the pairs of a regime.
   pure subroutine enter_affine(run, number, phase, p, q, rate, at)
      !> The run, and the number of the regime.
      type(run_type), intent(in) :: run
      integer, intent(in) :: number
      !> Load phase (rad).
      real(wp), intent(in) :: phase
      !> (2n, unknowns) Derivatives, and (n) coordinates and velocities where all unknowns are 0.
      real(wp), intent(in) :: p(:, :), q(:), rate(:)
      !> The same.
      type(affine_type), intent(inout) :: at

      associate (regime => run%regimes(number))
         if (allocated(at%x)) deallocate (at%x, at%v, at%d)
         allocate (at%x(size(regime%xq, 1)), at%v(size(regime%xq, 1)), &
            at%d(2*size(regime%xq, 1), size(p, 2)))
         call to_pairs(regime, phase, q, rate, at%x, at%v)
         call from_coordinates(regime, p, at%d)
      end associate
   end subroutine enter_affine

   !> Time between two instants.
   pure real(wp) function apart(run, cycle, elapsed, later_cycle, later_elapsed) result(time)
      !> The run.
      type(run_type), intent(in) :: run
      !> Whole periods and remainder of both.
      integer(int64), intent(in) :: cycle, later_cycle
      real(wp), intent(in) :: elapsed, later_elapsed

      time = max(0.0_wp, real(later_cycle - cycle, wp)*run%period + (later_elapsed - elapsed))
   end function apart

   !> Solves the equations by DGELS, each with a largest coefficient of 1 in units of which
   !! velocities last for a radian of the period.
   subroutine solve_scaled(run, equations, u, residual, status)
      !> The run.
      type(run_type), intent(in) :: run
      !> The equations.
      type(equations_type), intent(in) :: equations
      !> The unknowns.
      real(wp), intent(out) :: u(:)
      !> The largest residual, over the sum of the absolute terms of its equation.
      real(wp), intent(out) :: residual
      !> `stat%ok` or `stat%singular`.
      integer, intent(out) :: status
      real(wp), allocatable :: a(:, :), right(:), work(:)
      real(wp) :: columns(size(u)), sizes(size(u)), length, terms
      integer :: i, n

      n = size(run%structure%mass, 1)
      columns(:n) = 1
      columns(n + 1:) = two_pi/run%period
      allocate (a, source=equations%a)
      allocate (right, source=equations%right)
      do i = 1, size(u)
         a(:, i) = a(:, i)*columns(i)
      end do
      do i = 1, size(right)
         length = maxval(abs(a(i, :)))
         if (.not. length > 0) cycle
         a(i, :) = a(i, :)/length
         right(i) = right(i)/length
      end do
      allocate (work(least_squares_work(size(a, 1), size(a, 2))))
      call least_squares(a, right, work, length, status)
      u = 0
      residual = 0
      if (status /= stat%ok) return
      u = columns*right(:size(u))
      ! where a function vanishes because all its terms do, as a speed at an extreme, it is compared
      ! with what motions of this size give
      length = maxval(abs(u)/columns)
      sizes = columns*length
      do i = 1, size(equations%right)
         terms = max(dot_product(abs(equations%a(i, :)), abs(u)) + abs(equations%right(i)) &
            + equations%extra(i), dot_product(abs(equations%a(i, :)), sizes))
         residual = max(residual, abs(dot_product(equations%a(i, :), u) - equations%right(i))/ &
            max(terms, tiny(1.0_wp)))
      end do
   end subroutine solve_scaled

   !> Fills in the states of the events, and those before the first one and a period later.
   subroutine fill_states(run, begun, events, last, u)
      !> The run.
      type(run_type), intent(in) :: run
      !> In and out: filled in.
      type(run_state_type), intent(inout) :: begun, last
      type(run_event_type), intent(inout) :: events(:)
      !> The unknowns.
      real(wp), intent(in) :: u(:)
      real(wp), allocatable :: x(:), v(:), x_now(:), v_now(:)
      real(wp) :: d(0:3), elapsed, limit, opening(0:2), phase, restitution, slope
      integer(int64) :: cycle
      integer :: hits, i, n, number, row, wall

      n = size(run%structure%mass, 1)
      number = begun%regime
      hits = 0
      allocate (x(size(run%regimes(number)%xq, 1)), v(size(run%regimes(number)%xq, 1)))
      call to_pairs(run%regimes(number), run%load%frequency*begun%elapsed, u(:n), u(n + 1:2*n), &
         x, v)
      begun%x = x
      begun%v = v
      cycle = begun%cycle
      elapsed = begun%elapsed
      do i = 1, size(events)
         associate (regime => run%regimes(number), next => run%regimes(events(i)%regime), &
            event => events(i), structure => run%structure)
            phase = run%load%frequency*event%elapsed
            x_now = x
            v_now = v
            call advance(regime%modes, apart(run, cycle, elapsed, event%cycle, event%elapsed), x, &
               v, x_now, v_now)
            cycle = event%cycle
            elapsed = event%elapsed
            allocate (event%q(n), event%rate(n))
            call state_of(regime, phase, x_now, v_now, event%q, event%rate)
            select case (event%kind)
            case (impact_event)
               hits = hits + 1
               event%speed = u(2*n + hits)
               call restitution_of(structure, event%gap, 0.0_wp, restitution, slope)
               event%impulse = (1 + restitution)*structure%effective(event%gap)*event%speed
               event%rate = event%rate - event%impulse*structure%mobility(:, event%gap)
            case (touch_event, leave_event)
               call find_limit(structure, regime, event, row, wall, limit)
               call row_derivatives(regime, x_now, v_now, phase, row, d)
               event%speed = wall*d(1)
            case (let_go_event, press_event)
               opening = opening_at(structure, event%gap, phase, run%load%frequency)
               event%speed = abs(dot_product(structure%directions(:, event%gap), event%rate) &
                  - opening(1))
            case default
            end select
            deallocate (x, v)
            allocate (x(size(next%xq, 1)), v(size(next%xq, 1)))
            call to_pairs(next, phase, event%q, event%rate, x, v)
            event%x = x
            event%v = v
            number = event%regime
         end associate
      end do
      x_now = x
      v_now = v
      call advance(run%regimes(number)%modes, apart(run, cycle, elapsed, last%cycle, &
         last%elapsed), x, v, x_now, v_now)
      last%regime = number
      last%x = x_now
      last%v = v_now
   end subroutine fill_states

   !> The time, coordinates and velocities in the middle of the longest flight, without a rest and,
   !! where there is one, without friction that sticks.
   pure subroutine between_events(run, events, last, after, time, q, rate)
      !> The run.
      type(run_type), intent(in) :: run
      !> The events, and the end of the period.
      type(run_event_type), intent(in) :: events(:)
      type(run_state_type), intent(in) :: last
      !> The event before it.
      integer, intent(out) :: after
      !> The time from the beginning of the load cycle of that event, and (n) the state.
      real(wp), intent(out) :: time, q(:), rate(:)
      real(wp), allocatable :: x(:), v(:)
      real(wp) :: flight, longest
      integer :: i
      logical :: only_free

      only_free = any([(size(run%regimes(events(i)%regime)%held) == 0, i=1, size(events))])
      longest = -1
      after = 1
      do i = 1, size(events)
         if (only_free .and. size(run%regimes(events(i)%regime)%held) > 0) cycle
         if (i < size(events)) then
            flight = apart(run, events(i)%cycle, events(i)%elapsed, events(i + 1)%cycle, &
               events(i + 1)%elapsed)
         else
            flight = apart(run, events(i)%cycle, events(i)%elapsed, last%cycle, last%elapsed)
         end if
         if (flight <= longest) cycle
         longest = flight
         after = i
      end do
      associate (event => events(after))
         x = event%x
         v = event%v
         call advance(run%regimes(event%regime)%modes, 0.5_wp*longest, event%x, event%v, x, v)
         time = event%elapsed + 0.5_wp*longest
         call state_of(run%regimes(event%regime), run%load%frequency*time, x, v, q, rate)
      end associate
   end subroutine between_events

   !> Whether a simulation of one period passes the same events at the same instants.
   subroutine simulate_events(run, begun, events, last, verdict)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> As in `fill_states`, filled in.
      type(run_state_type), intent(in) :: begun, last
      type(run_event_type), intent(in) :: events(:)
      !> The verdict.
      integer, intent(out) :: verdict
      type(run_state_type) :: state
      type(run_event_type), allocatable :: passed(:)
      real(wp), dimension(size(run%structure%mass, 1)) :: q, rate
      real(wp) :: time, within
      !> How far instants may be from the presumed ones, as a share of a period.
      real(wp), parameter :: near = 1.0e-6_wp
      real(wp) :: whole
      logical, allocatable :: taken(:)
      integer :: after, i, j, n, status

      verdict = no
      ! met from behind
      if (any(events%kind == impact_event .and. events%speed < 0)) return
      verdict = unknown
      call between_events(run, events, last, after, time, q, rate)
      call start_at(run, time, q, rate, state, status)
      if (status == stat%gap_closed) verdict = no
      if (status /= stat%ok) return
      allocate (passed(min(most_events, 4*size(events) + 100)))
      within = state%elapsed
      call one_cycle(run, state, int(last%cycle - begun%cycle), within, passed, n, status)
      if (status == stat%no_motion) verdict = no
      if (status /= stat%ok) return
      verdict = merge(yes, no, n == size(events))
      if (verdict == no) return
      whole = run%period*real(last%cycle - begun%cycle, wp)
      allocate (taken(n), source=.false.)
      do i = 1, n
         ! the order of simultaneous events may be another one
         do j = 1, n
            if (taken(j) .or. events(j)%kind /= passed(i)%kind .or. events(j)%gap /= &
               passed(i)%gap) cycle
            ! the simulation begins in cycle 0, that of the event before it
            time = real(passed(i)%cycle + events(after)%cycle - events(j)%cycle, wp)*run%period &
               + (passed(i)%elapsed - events(j)%elapsed)
            if (abs(time - whole*anint(time/whole)) > near*whole) cycle
            taken(j) = .true.
            exit
         end do
      end do
      verdict = merge(yes, no, all(taken))
   end subroutine simulate_events

end module vi_presumed_events
