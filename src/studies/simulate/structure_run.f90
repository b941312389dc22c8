!> Event-by-event simulation of a linear structure with gaps, elastic stops and dry friction.
module vi_structure_run
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_channels, only: bound_second, first_event, leading_term, leaving_type, pace_type, &
      reached_type, row_derivatives, size_of_rate, space_type
   use vi_forced_system, only: state_type
   use vi_kinds, only: two_pi, wp
   use vi_lane_rows, only: subtract
   use vi_lane_rows_wide, only: subtract_wide => subtract
   use vi_modes, only: advance_in_place
   use vi_restitution, only: constant_law, greatest_below
   use vi_simultaneous, only: newton_impulses
   use vi_status, only: stat
   use vi_structure_pair, only: next_impact, pair_type, place_in, place_type, recognise
   use vi_structure_record, only: pass_intervals, set_forces
   use vi_watch, only: keep_watch, most_second
   use vi_structure, only: by_newton, check_structure, coordinate_of, factor_along, is_absorbed, &
      is_extreme, load_type, new_regime, opening_at, refused, regime_type, restitution_of, &
      state_of, structure_type, to_pairs
   implicit none (type, external)
   private

   public :: at_once, find_regime, is_far, is_listed, longest_natural_period, new_run, pass_label, &
      simulate_structure, start_at, state_now, time_of, time_of_motion, whole_periods

   !> Kinds of events. A gap: an impact, and the start and the end of a rest. A stop: it is touched
   !! and left; one that cannot pull lets go while it is closed, and presses again. Friction halts,
   !! that is, sticks, and begins to slip with s > 0 or s < 0, from rest or from the other sense.
   integer, parameter, public :: impact_event = 1, stick_event = 2, release_event = 3, &
      touch_event = 4, leave_event = 5, let_go_event = 6, press_event = 7, halt_event = 8, &
      slip_up_event = 9, slip_down_event = 10

   !> Their names, in this order.
   character(*), parameter, public :: event_kinds = 'impact,stick,release,touch,leave,let_go,&
      &press,halt,slip_up,slip_down'

   !> A structure under a load, with the regimes met so far.
   type, public :: run_type
      type(structure_type) :: structure
      type(load_type) :: load
      !> The regimes, and room for more, of which `closed` is not allocated.
      type(regime_type), allocatable :: regimes(:)
      !> The unit of `cycle`: the period of the load, the time between the samples of a record, or
      !! 1.
      real(wp) :: period = 1
      !> The oscillator of 1983, if the structure is one.
      type(pair_type) :: pair
   end type run_type

   !> What happens to the pairs where a stop is touched or left: those in the regime beyond are
   !! linear in those before it, so that a small structure need not go through its coordinates.
   type, public :: passage_type
      !> The regime that is left, the row and its limit (+1 upper, -1 lower), and the regime beyond.
      integer :: from = 0, row = 0, wall = 0, beyond = 0
      !> Factors of x and v before it, of the real and of the imaginary parts of e^(i h phase), and
      !! of 1, in x and v beyond it, by columns.
      real(wp), allocatable :: factors(:, :)
   end type passage_type

   !> A state: time as whole periods and the remainder, so that its error does not grow.
   type, public :: run_state_type
      integer(int64) :: cycle = 0
      !> In [0, period).
      real(wp) :: elapsed = 0
      !> The regime, and its pairs.
      integer :: regime = 1
      real(wp), allocatable :: x(:), v(:)
      !> Whether contacts must be judged again; gaps that touch without a speed at this instant, and
      !! the one of them that was released because its force fell to 0, or 0.
      logical :: unsettled = .false.
      integer, allocatable :: touching(:)
      integer :: released = 0
      !> Rests and releases at this instant.
      integer :: changes = 0
      !> Friction that changed at this instant, without an event so far.
      integer, allocatable :: pending(:)
      !> While coupled gaps are closed at one instant: the gaps, those of them that still rest, the
      !! number of impacts so far, and (n) the largest velocities.
      integer, allocatable :: together(:), freed(:)
      integer :: impacts = 0
      real(wp), allocatable :: largest(:)
      !> (together) By Newton's law: approach speeds, and impulses without an event so far.
      real(wp), allocatable :: approaches(:), impulses(:)
      !> How the flight begins: the impact just before it, and gaps that part from there without a
      !! speed; the lengths of the cells of the previous search.
      type(leaving_type) :: leaving
      type(leaving_type), allocatable :: partings(:)
      !> Room for one of these, kept so that memory is not allocated again for each event.
      type(leaving_type), allocatable :: spare(:)
      !> Passages met so far, and (harmonics) room for e^(i h phase).
      type(passage_type), allocatable :: passages(:)
      complex(wp), allocatable :: turns(:)
      type(pace_type) :: pace
      !> (regimes) The lengths of cells when a regime was left; of level 0 if it was not so far.
      type(pace_type), allocatable :: paces(:)
      !> (n) Room for coordinates and velocities, and for searches.
      real(wp), allocatable :: q(:), rate(:)
      type(space_type) :: space
      !> Whether impacts may be recorded without coordinates and velocities, which need products of
      !! all coordinates with all modes.
      logical :: bare = .false.
   end type run_state_type

   !> An event, and the pairs, coordinates and velocities just after it; without the last two, if
   !! the state was simulated with `bare`.
   type, public :: run_event_type
      integer :: kind = 0, gap = 0, regime = 1
      integer(int64) :: cycle = 0
      real(wp) :: elapsed = 0, speed = 0, impulse = 0
      real(wp), allocatable :: x(:), v(:), q(:), rate(:)
      !> Whether it is one of several on coupled gaps at one instant.
      logical :: together = .false.
   end type run_event_type

   !> Most pairs of a structure, and most harmonics of its load, of which passages are kept; and
   !! most of these, since each contact searches them and each copy of a state copies them.
   integer, parameter :: few = 8, most_passages = 64
   !> Share of a stick level by which a force that holds may exceed it: rounding.
   real(wp), parameter :: tolerance = 1.0e-12_wp
   !> Largest number of impacts at one instant on coupled gaps.
   integer, parameter :: most_together = 20000
   !> The samples of a record may be 1e-300 apart: time beyond so many stays in the remainder.
   integer(int64), parameter :: most_periods = 2_int64**52

contains

   !> A structure under a load, ready to be simulated.
   pure subroutine new_run(structure, load, run, status, searched)
      !> M, C, K, gaps.
      type(structure_type), intent(in) :: structure
      !> The load.
      type(load_type), intent(in) :: load
      !> Out: the run.
      type(run_type), intent(out) :: run
      !> `stat%ok`, or as in `new_regime`.
      integer, intent(out) :: status
      !> As in `new_regime`.
      logical, intent(in), optional :: searched

      run%structure = structure
      run%load = load
      if (load%frequency > 0) run%period = two_pi/load%frequency
      if (load%step > 0) run%period = load%step
      call check_structure(run%structure, status)
      if (status /= stat%ok) return
      allocate (run%regimes(1))
      call new_regime(run%structure, load, [integer :: ], run%regimes(1), status, searched)
      if (status == stat%ok) call recognise(run%structure, load, run%pair)
   end subroutine new_run

   !> The longest natural period of a structure with all gaps open and all friction slipping, or of
   !! the softest stop where nothing else pulls it back; 0 if there is none.
   pure subroutine longest_natural_period(structure, load, period, status)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Constant forces.
      type(load_type), intent(in) :: load
      !> The period.
      real(wp), intent(out) :: period
      !> As of `new_run`.
      integer, intent(out) :: status
      type(run_type) :: run
      real(wp) :: square
      integer :: j

      period = 0
      call new_run(structure, load, run, status)
      if (status /= stat%ok) return
      associate (squares => run%regimes(1)%modes%stiffness)
         square = minval(squares, squares > 0)
         if (.not. any(squares > 0)) then
            do j = 1, size(run%structure%laws)
               if (run%structure%elastic(j)) square = min(square, &
                  run%structure%laws(j)%numbers(1)/run%structure%effective(j))
            end do
         end if
      end associate
      if (square > 0 .and. square < huge(square)) period = two_pi/sqrt(square)
   end subroutine longest_natural_period

   !> Whole periods at a time, not more than `most_periods`.
   pure integer(int64) function whole_periods(run, time)
      !> The run.
      type(run_type), intent(in) :: run
      !> The time.
      real(wp), intent(in) :: time

      whole_periods = floor(min(time/run%period, real(most_periods, wp)), int64)
   end function whole_periods

   !> Whether the numbers of a state are beyond those with which a simulation can begin.
   pure logical function is_far(run, q, rate)
      !> The run.
      type(run_type), intent(in) :: run
      !> (n) Coordinates and velocities.
      real(wp), intent(in) :: q(:), rate(:)

      is_far = is_extreme(max(maxval(abs(q)), run%regimes(1)%unit*maxval(abs(rate))))
   end function is_far

   !> A state from coordinates and velocities.
   pure subroutine start_at(run, time, q, rate, state, status)
      !> In and out: the regime of closed gaps is added.
      type(run_type), intent(inout) :: run
      !> Time, coordinates (n), velocities (n).
      real(wp), intent(in) :: time, q(:), rate(:)
      !> The state.
      type(run_state_type), intent(out) :: state
      !> `stat%ok`, `stat%extreme_units`, or `stat%gap_closed` if a gap is negative.
      integer, intent(out) :: status
      !> Share of the size of a gap that counts as rounding of a state computed elsewhere.
      real(wp), parameter :: rounding = 1.0e-13_wp
      real(wp) :: gap, phase, speed, scale, opening(0:2)
      integer, allocatable :: closed(:), level(:), halted(:), orders(:), pressed(:), slipping(:)
      integer :: j, n

      n = size(q)
      if (is_far(run, q, rate)) then
         status = stat%extreme_units
         return
      end if
      state%cycle = whole_periods(run, time)
      state%elapsed = max(0.0_wp, time - real(state%cycle, wp)*run%period)
      allocate (closed(0), level(0), halted(0), pressed(0), slipping(0))
      status = stat%ok
      phase = run%load%frequency*state%elapsed
      do j = 1, size(run%structure%openings)
         associate (direction => run%structure%directions(:, j))
            opening = opening_at(run%structure, j, phase, run%load%frequency)
            gap = opening(0) - dot_product(direction, q)
            speed = dot_product(direction, rate) - opening(1)
            if (run%structure%rubs(j)) then
               speed = speed - run%structure%laws(j)%numbers(3)
               scale = dot_product(abs(direction), abs(rate)) &
                  + abs(run%structure%laws(j)%numbers(3))
               if (abs(speed) > 8*epsilon(1.0_wp)*scale) scale = scale + sum(abs(direction))* &
                  reach_of(run, rate)/time_of_motion(run)
               if (abs(speed) <= 8*epsilon(1.0_wp)*scale) halted = [halted, j]
               if (speed < -8*epsilon(1.0_wp)*scale) slipping = [slipping, j]
               cycle
            end if
            scale = abs(opening(0)) + sum(abs(direction))*maxval(abs(q))
            if (abs(gap) > rounding*scale) scale = scale + 0.5_wp*sum(abs(direction))* &
               reach_of(run, rate)
            if (gap > rounding*scale) cycle
            if (gap < -rounding*scale .and. run%structure%elastic(j)) pressed = [pressed, j]
            if (gap < -rounding*scale .and. run%structure%elastic(j)) cycle
            if (gap < -rounding*scale) status = stat%gap_closed
            ! a state at the end of a simulation that rests has a speed of rounding
            scale = dot_product(abs(direction), abs(rate)) + abs(opening(1))
            if (abs(speed) > 8*epsilon(1.0_wp)*scale) scale = scale + sum(abs(direction))* &
               reach_of(run, rate)/time_of_motion(run)
            ! a stop that is met with a speed is touched in the first search
            if (.not. abs(speed) <= 8*epsilon(1.0_wp)*scale) cycle
            if (run%structure%elastic(j)) then
               level = [level, j]
            else
               closed = [closed, j]
            end if
         end associate
      end do
      if (status /= stat%ok) return
      allocate (state%q(n), state%rate(n), orders(size(closed)))
      pressed = without_force(run, pressed, phase, q, rate)
      do j = 1, size(closed)
         pressed = merged(pressed, closed(j))
      end do
      do j = 1, size(slipping)
         pressed = merged(pressed, -slipping(j))
      end do
      do j = 1, size(halted)
         pressed = merged(pressed, halted(j))
      end do
      call enter(run, pressed, phase, q, rate, state, status)
      do j = 1, size(level)
         if (status == stat%ok) call enter_stop(run, level(j), phase, q, rate, state, status)
      end do
      if (status == stat%ok .and. size(halted) > 0) call settle_friction(run, halted, phase, q, &
         rate, state, status)
      if (status /= stat%ok .or. size(closed) == 0) return
      call settle_contacts(run, closed, phase, q, rate, state, orders, status)
      if (status /= stat%ok) return
      ! the first search lists those that part
      state%touching = closed
      state%unsettled = .true.
   end subroutine start_at

   !> Stops that are closed, as a set in which those that would have to pull are negative.
   pure function without_force(run, stops, phase, q, rate) result(closed)
      !> The run.
      type(run_type), intent(in) :: run
      !> The stops.
      integer, intent(in) :: stops(:)
      !> The load phase (rad), and (n) coordinates and velocities.
      real(wp), intent(in) :: phase, q(:), rate(:)
      integer, allocatable :: closed(:)
      real(wp) :: opening(0:2)
      integer :: i, j

      allocate (closed(0))
      do i = 1, size(stops)
         j = stops(i)
         opening = opening_at(run%structure, j, phase, run%load%frequency)
         associate (law => run%structure%laws(j)%numbers, &
            direction => run%structure%directions(:, j))
            if (run%structure%push(j) > 0 .and. law(3) + law(1)*(dot_product(direction, q) &
               - opening(0)) + law(2)*(dot_product(direction, rate) - opening(1)) < 0) j = -j
         end associate
         closed = merged(closed, j)
      end do
   end function without_force

   !> Makes a stop press that the structure touches without a speed, if the structure begins to move
   !! into it.
   pure subroutine enter_stop(run, number, phase, q, rate, state, status)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> Number of the stop, which is open and at its limit.
      integer, intent(in) :: number
      !> The load phase (rad), and (n) coordinates and velocities.
      real(wp), intent(in) :: phase, q(:), rate(:)
      !> In and out: regime and pairs.
      type(run_state_type), intent(inout) :: state
      !> `stat%ok`, `stat%stop_holds` where it would hold the structure there, or as in
      !! `new_regime`.
      integer, intent(out) :: status
      integer :: order, sense

      status = stat%ok
      associate (row => run%structure%channel(number))
         call leading_term(run%regimes(state%regime), state%x, state%v, phase, row, 1, order, sense)
         if (sense <= 0) return
         call enter(run, merged(run%regimes(state%regime)%closed, number), phase, q, rate, state, &
            status)
         if (status /= stat%ok) return
         call leading_term(run%regimes(state%regime), state%x, state%v, phase, row, 1, order, sense)
         if (sense < 0) status = stat%stop_holds
      end associate
   end subroutine enter_stop

   !> A length of the size of a motion, of which the rounding errors of its coordinates are a share:
   !! at an impact all coordinates may be 0, and with R = 0 all velocities.
   pure real(wp) function reach_of(run, rate) result(reach)
      !> The run.
      type(run_type), intent(in) :: run
      !> (n) Velocities.
      real(wp), intent(in) :: rate(:)
      real(wp) :: time, force
      integer :: i

      time = time_of_motion(run)
      reach = maxval(abs(rate))*time
      do i = 1, size(rate)
         force = abs(run%load%constant(i)) + sum(hypot(run%load%cosine(i, :), run%load%sine(i, :)))
         if (run%load%step > 0) force = force + maxval(abs(run%load%record(i, :)))
         reach = max(reach, force/run%structure%mass(i, i)*time**2)
      end do
   end function reach_of

   !> A time of the size of those in which a motion changes.
   pure real(wp) function time_of_motion(run) result(time)
      !> The run.
      type(run_type), intent(in) :: run

      time = run%regimes(1)%unit
      if (run%load%frequency > 0) time = max(time, run%period)
   end function time_of_motion

   !> Whether an event follows another one by nothing but rounding of times, so that it is at the
   !! same instant: what left its limit without a speed there has not left it by more than rounding.
   pure logical function at_once(run, time)
      !> The run.
      type(run_type), intent(in) :: run
      !> The time between them.
      real(wp), intent(in) :: time

      at_once = time <= 128*epsilon(1.0_wp)*time_of_motion(run)
   end function at_once

   !> The gaps that rest, the stops that are closed and the friction that sticks after an event.
   pure subroutine pass_label(label, closed)
      !> (2) Kind and gap of the event.
      integer, intent(in) :: label(:)
      !> In and out: the set, as in `regime_type`.
      integer, allocatable, intent(inout) :: closed(:)

      if (label(1) == 0 .or. label(1) == impact_event) return
      closed = pack(closed, abs(closed) /= label(2))
      select case (label(1))
      case (stick_event, touch_event, press_event, halt_event)
         closed = sorted_with(closed, label(2))
      case (let_go_event, slip_down_event)
         closed = sorted_with(closed, -label(2))
      case default
      end select
   end subroutine pass_label

   !> A set in ascending order with one more member.
   pure function sorted_with(set, one) result(larger)
      !> The set, and the new member.
      integer, intent(in) :: set(:), one
      integer, allocatable :: larger(:)

      larger = [pack(set, set < one), one, pack(set, set > one)]
   end function sorted_with

   !> Finds which gaps that touch without a speed rest, and puts a state into their regime.
   !!
   !! A gap that rests must push: the first derivative of its force that is not 0, from the force
   !! itself on, is positive. One that does not must part: the same holds for its opening. A gap of
   !! which neither has such a derivative rests. As powers of 1/s in the Laplace transform, forces
   !! and openings obey a linear complementarity problem over an ordered field. The principal minors
   !! of its matrix are positive, as those of G^T M^-1 G are, so it has one solution, and changing
   !! the first gap that is wrong, one at a time, finds it (Murty's method).
   pure subroutine settle_contacts(run, touching, phase, q, rate, state, orders, status)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> The gaps, in ascending order.
      integer, intent(in) :: touching(:)
      !> The load phase (rad), and (n) coordinates and velocities.
      real(wp), intent(in) :: phase, q(:), rate(:)
      !> In: time, and a regime and pairs from which to begin. Out: the regime and pairs.
      type(run_state_type), intent(inout) :: state
      !> (touching) The order of the first derivative that is not 0, of the force of a gap that
      !! rests, and of the opening of another.
      integer, intent(out) :: orders(:)
      !> `stat%ok`, or as in `new_regime`.
      integer, intent(out) :: status
      integer :: changes, wrong

      do changes = 1, huge(changes) - 1
         ! rounding may contradict itself where both are almost 0: then the gap rests
         call find_wrong(run, touching, phase, state, changes > 2**min(size(touching) + 2, 20), &
            orders, wrong)
         status = stat%ok
         if (wrong == 0) return
         associate (closed => run%regimes(state%regime)%closed)
            if (any(closed == wrong)) then
               call enter(run, opened(run%structure, closed, wrong), phase, q, rate, state, status)
            else
               call enter(run, merged(closed, wrong), phase, q, rate, state, status)
            end if
         end associate
         if (status /= stat%ok) return
      end do
   end subroutine settle_contacts

   !> The first gap of those that touch that rests but pulls, or does not rest and would close.
   pure subroutine find_wrong(run, touching, phase, state, only_add, orders, wrong)
      !> The run.
      type(run_type), intent(in) :: run
      !> The gaps.
      integer, intent(in) :: touching(:)
      !> The load phase (rad).
      real(wp), intent(in) :: phase
      !> The state.
      type(run_state_type), intent(in) :: state
      !> Whether each gap that rests is right: a derivative of its force below 0 is rounding.
      logical, intent(in) :: only_add
      !> (touching) As in `settle_contacts`, up to the wrong gap.
      integer, intent(out) :: orders(:)
      !> The gap; 0 if all are right.
      integer, intent(out) :: wrong
      integer :: i, sense

      orders = 0
      wrong = 0
      associate (regime => run%regimes(state%regime), structure => run%structure)
         do i = 1, size(touching)
            associate (gap => touching(i))
               if (any(regime%resting == gap)) then
                  call leading_term(regime, state%x, state%v, phase, structure%channels &
                     + findloc(regime%resting, gap, dim=1), 0, orders(i), sense)
                  if (sense < 0 .and. .not. only_add) wrong = gap
                  do while (sense < 0 .and. only_add)
                     call leading_term(regime, state%x, state%v, phase, structure%channels &
                        + findloc(regime%resting, gap, dim=1), orders(i) + 1, orders(i), sense)
                  end do
               else if (is_stuck(structure, regime%held, gap)) then
                  ! its opening has no derivative but rounding
                  wrong = gap
               else
                  call leading_term(regime, state%x, state%v, phase, structure%channel(gap), &
                     merge(3, 2, gap == state%released), orders(i), sense)
                  if (.not. -structure%wall(gap)*sense > 0) wrong = gap
               end if
            end associate
            if (wrong > 0) return
         end do
      end associate
   end subroutine find_wrong

   !> Whether friction that sticks keeps a gap as it is.
   pure logical function is_stuck(structure, held, gap)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> What is held, as in `regime_type`, and the gap, which is not.
      integer, intent(in) :: held(:), gap
      integer :: i

      is_stuck = structure%has_friction
      if (is_stuck) is_stuck = any([(abs(factor_along(structure, held(i), gap)) > 0, i=1, &
         size(held))])
   end function is_stuck

   !> Puts a state into the regime of closed gaps.
   pure subroutine enter(run, closed, phase, q, rate, state, status)
      !> In and out: the regime is added.
      type(run_type), intent(inout) :: run
      !> The gaps and stops, as in `regime_type`.
      integer, intent(in) :: closed(:)
      !> The load phase (rad), and (n) coordinates and velocities.
      real(wp), contiguous, intent(in) :: q(:), rate(:)
      real(wp), intent(in) :: phase
      !> In: time. Out: regime and pairs; what leaves limits that the regime lacks is not listed any
      !! more.
      type(run_state_type), intent(inout) :: state
      !> `stat%ok`, or as in `new_regime`.
      integer, intent(out) :: status
      integer :: i, number

      call find_regime(run, closed, number, status)
      if (status /= stat%ok) return
      if (number /= state%regime) call change_pace(state, number)
      state%regime = number
      state%space%watch%kept = .false.
      if (run%load%step > 0) call set_forces(run%regimes(number), run%load, state%cycle, &
         state%elapsed)
      associate (regime => run%regimes(number))
         if (allocated(state%x)) then
            if (size(state%x) /= size(regime%xq, 1)) deallocate (state%x, state%v)
         end if
         if (.not. allocated(state%x)) allocate (state%x(size(regime%xq, 1)), &
            state%v(size(regime%xq, 1)))
         call to_pairs(regime, phase, q, rate, state%x, state%v)
         if (.not. allocated(state%partings)) return
         ! rows of forces have other numbers in each regime
         state%partings = pack(state%partings, [(state%partings(i)%row <= run%structure%channels &
            .and. has_limit(regime, state%partings(i)), i=1, size(state%partings))])
      end associate
   end subroutine enter

   !> Goes on with the cells of an earlier flight in the regime that is entered: flights in contact
   !! may be far shorter than those between contacts.
   pure subroutine change_pace(state, next)
      !> In and out: the state, still in the regime that is left.
      type(run_state_type), intent(inout) :: state
      !> Number of the regime that is entered.
      integer, intent(in) :: next
      type(pace_type), allocatable :: more(:)

      if (.not. allocated(state%paces)) allocate (state%paces(0))
      if (max(state%regime, next) > size(state%paces)) then
         allocate (more(max(state%regime, next)), source=pace_type(level=0))
         more(:size(state%paces)) = state%paces
         call move_alloc(more, state%paces)
      end if
      state%paces(state%regime) = state%pace
      if (state%paces(next)%level > 0) state%pace = state%paces(next)
   end subroutine change_pace

   !> Whether a regime has the limit that a row leaves.
   pure logical function has_limit(regime, leaving)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> The row.
      type(leaving_type), intent(in) :: leaving

      has_limit = .false.
      if (leaving%row > size(regime%upper)) return
      has_limit = merge(regime%upper(leaving%row), -regime%lower(leaving%row), leaving%wall > 0) &
         < huge(1.0_wp)
   end function has_limit

   !> Judges again which gaps rest after a jump of forces or speeds, and makes one change.
   !!
   !! Each change is an event; the next call makes the next one, if there is any. After the last one
   !! the rows that leave their limits without a speed are listed: gaps that part, and forces that
   !! rise from 0.
   pure subroutine judge_contacts(run, state, event, changed, status)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> The change.
      type(run_event_type), intent(inout) :: event
      !> Whether there is one.
      logical, intent(out) :: changed
      !> `stat%ok`, or as in `new_regime`.
      integer, intent(out) :: status
      type(run_state_type) :: next
      real(wp), dimension(size(run%structure%mass, 1)) :: q, rate
      integer, allocatable :: gaps(:), orders(:)
      real(wp) :: phase
      integer :: i, wrong
      logical :: only_add

      changed = .false.
      status = stat%ok
      phase = run%load%frequency*state%elapsed
      allocate (gaps, source=run%regimes(state%regime)%resting)
      if (allocated(state%touching)) then
         do i = 1, size(state%touching)
            if (all(gaps /= state%touching(i))) gaps = merged(gaps, state%touching(i))
         end do
      end if
      allocate (orders(size(gaps)))
      only_add = state%changes > 2**min(size(gaps) + 2, 20)
      call find_wrong(run, gaps, phase, state, only_add, orders, wrong)
      if (wrong == 0) then
         state%unsettled = .false.
         call list_partings(run, gaps, orders, phase, state)
         return
      end if
      call state_now(run, state, q, rate)
      if (size(gaps) > 1 .and. .not. only_add) then
         next%cycle = state%cycle
         next%elapsed = state%elapsed
         next%regime = state%regime
         next%released = state%released
         allocate (next%x, source=state%x)
         allocate (next%v, source=state%v)
         call settle_contacts(run, gaps, phase, q, rate, next, orders, status)
         if (status /= stat%ok) return
         associate (before => run%regimes(state%regime)%resting, &
            after => run%regimes(next%regime)%resting)
            ! releases first, so that all sets on the way are parts of the first or of the last one
            wrong = 0
            do i = size(gaps), 1, -1
               if (any(after == gaps(i)) .and. all(before /= gaps(i))) wrong = gaps(i)
            end do
            do i = size(gaps), 1, -1
               if (any(before == gaps(i)) .and. all(after /= gaps(i))) wrong = gaps(i)
            end do
         end associate
      end if
      changed = wrong > 0
      if (changed) then
         call change_contact(run, merge(release_event, stick_event, &
            any(run%regimes(state%regime)%resting == wrong)), wrong, phase, q, rate, state, event, &
            status)
      else
         ! what seems wrong is rounding
         state%unsettled = .false.
         call list_partings(run, gaps, orders, phase, state)
      end if
   end subroutine judge_contacts

   !> Lists the rows that leave their limits at this instant without an impact.
   pure subroutine list_partings(run, gaps, orders, phase, state)
      !> The run.
      type(run_type), intent(in) :: run
      !> Gaps that touch, and the orders of `settle_contacts`.
      integer, intent(in) :: gaps(:), orders(:)
      !> The load phase (rad).
      real(wp), intent(in) :: phase
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      type(leaving_type), allocatable :: leaving(:)
      real(wp) :: d(0:3)
      integer :: i

      allocate (leaving(size(gaps)))
      associate (regime => run%regimes(state%regime), structure => run%structure)
         do i = 1, size(gaps)
            if (any(regime%resting == gaps(i))) then
               leaving(i) = leaving_type(structure%channels + findloc(regime%resting, gaps(i), &
                  dim=1), -1, 0.0_wp, orders(i))
               if (orders(i) /= 1) cycle
               call row_derivatives(regime, state%x, state%v, phase, leaving(i)%row, d)
               leaving(i)%speed = d(1)
            else
               leaving(i) = leaving_type(structure%channel(gaps(i)), structure%wall(gaps(i)), &
                  0.0_wp, orders(i))
            end if
         end do
      end associate
      leaving = pack(leaving, orders > 0)
      if (run%structure%has_stops .or. run%structure%has_friction) leaving = &
         [partings_of_elements(run, state), leaving]
      if (run%structure%simultaneous /= refused) leaving = [departures(run, state, gaps), leaving]
      call move_alloc(leaving, state%partings)
   end subroutine list_partings

   !> What stops and friction leave at this instant, in the regime of the state.
   pure function partings_of_elements(run, state) result(partings)
      !> The run.
      type(run_type), intent(in) :: run
      !> The state.
      type(run_state_type), intent(in) :: state
      type(leaving_type), allocatable :: partings(:)
      logical, allocatable :: leaves(:)
      real(wp) :: d(0:3)
      integer :: i, sense

      allocate (partings(0))
      if (.not. allocated(state%partings)) return
      associate (regime => run%regimes(state%regime), phase => run%load%frequency*state%elapsed)
         partings = pack(state%partings, [(is_own_row(run, regime, state%partings(i)%row, &
            state%partings(i)%wall), i=1, size(state%partings))])
         allocate (leaves(size(partings)), source=.true.)
         do i = 1, size(partings)
            associate (one => partings(i))
               if (.not. run%structure%rubs(gap_of(regime, one%row, one%wall))) cycle
               ! a gap that rests or is released at this instant changes how it begins to slip
               call leading_term(regime, state%x, state%v, phase, one%row, 1, one%order, sense)
               leaves(i) = .not. sense*one%wall > 0
               one%speed = 0
               if (one%order /= 1) cycle
               call row_derivatives(regime, state%x, state%v, phase, one%row, d)
               one%speed = abs(d(1))
            end associate
         end do
      end associate
      partings = pack(partings, leaves)
   end function partings_of_elements

   !> Gaps that part with a speed after impacts of coupled gaps at this instant.
   pure function departures(run, state, others) result(partings)
      !> The run, and the state.
      type(run_type), intent(in) :: run
      type(run_state_type), intent(in) :: state
      !> Gaps that do not count.
      integer, intent(in) :: others(:)
      type(leaving_type), allocatable :: partings(:)
      logical, allocatable :: parts(:)
      integer :: i

      allocate (partings(0))
      if (.not. allocated(state%partings)) return
      allocate (parts(size(state%partings)))
      associate (regime => run%regimes(state%regime))
         do i = 1, size(parts)
            associate (one => state%partings(i))
               parts(i) = one%row <= run%structure%channels .and. one%speed > 0 .and. &
                  .not. is_own_row(run, regime, one%row, one%wall)
               if (parts(i)) parts(i) = all(others /= gap_of(regime, one%row, one%wall))
            end associate
         end do
      end associate
      partings = pack(state%partings, parts)
   end function departures

   !> Whether a limit of a row is that of a stop or of friction that slips.
   pure logical function is_own_row(run, regime, row, wall) result(is)
      !> The run.
      type(run_type), intent(in) :: run
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> The row, and its upper (+1) or lower (-1) limit.
      integer, intent(in) :: row, wall

      is = (run%structure%has_stops .or. run%structure%has_friction) .and. &
         row <= run%structure%channels
      if (is) is = run%structure%elastic(max(1, gap_of(regime, row, wall))) .or. &
         run%structure%rubs(max(1, gap_of(regime, row, wall)))
   end function is_own_row

   !> A gap begins or ceases to rest.
   pure subroutine change_contact(run, kind, gap, phase, q, rate, state, event, status)
      !> In and out: the regime is added.
      type(run_type), intent(inout) :: run
      !> `stick_event` or `release_event`, and the gap.
      integer, intent(in) :: kind, gap
      !> The load phase (rad), and (n) coordinates and velocities.
      real(wp), intent(in) :: phase, q(:), rate(:)
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> The change.
      type(run_event_type), intent(inout) :: event
      !> `stat%ok`, or as in `new_regime`.
      integer, intent(out) :: status
      real(wp) :: opening(0:2)

      opening = opening_at(run%structure, gap, phase, run%load%frequency)
      associate (before => run%regimes(state%regime)%closed, structure => run%structure)
         if (kind == release_event) then
            call enter(run, opened(structure, before, gap), phase, q, rate, state, status)
         else
            ! without what rounding leaves of its speed
            call enter(run, merged(before, gap), phase, q, rate - structure%mobility(:, gap) &
               *structure%effective(gap)*(dot_product(structure%directions(:, gap), rate) &
               - opening(1)), state, status)
         end if
      end associate
      if (status /= stat%ok) return
      state%changes = state%changes + 1
      if (kind == release_event .and. run%structure%has_friction) call slip_away(run, gap, phase, &
         state)
      call touch(state, gap)
      call state_now(run, state, state%q, state%rate)
      call note(state, kind, gap, 0.0_wp, 0.0_wp, state%q, state%rate, event)
   end subroutine change_contact

   !> What is closed after a gap opens: friction along it slips to the side of its opening.
   pure function opened(structure, closed, gap) result(left)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> What is closed, and the gap.
      integer, intent(in) :: closed(:), gap
      integer, allocatable :: left(:)
      real(wp) :: factor
      integer :: j

      left = pack(closed, closed /= gap)
      if (.not. structure%has_friction) return
      do j = 1, size(structure%openings)
         factor = factor_along(structure, j, gap)
         if (.not. abs(factor) > 0) cycle
         left = replaced(left, j, merge(-j, 0, factor > 0))
      end do
   end function opened

   !> Lists friction along a gap that was released.
   pure subroutine slip_away(run, gap, phase, state)
      !> The run.
      type(run_type), intent(in) :: run
      !> The gap.
      integer, intent(in) :: gap
      !> The load phase (rad).
      real(wp), intent(in) :: phase
      !> In and out: the state after the release.
      type(run_state_type), intent(inout) :: state
      integer :: j, order, sense

      do j = 1, size(run%structure%openings)
         if (.not. abs(factor_along(run%structure, j, gap)) > 0) cycle
         associate (closed => run%regimes(state%regime)%closed)
            call tell_later(state, j)
            call leading_term(run%regimes(state%regime), state%x, state%v, phase, &
               run%structure%channel(j), 1, order, sense)
            call part(run, state, run%structure%channel(j), merge(1, -1, any(closed == -j)), order)
         end associate
      end do
   end subroutine slip_away

   !> Notes that friction or a stop changed at this instant, to be reported as an event.
   pure subroutine tell_later(state, number)
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> The friction or the stop.
      integer, intent(in) :: number

      if (.not. allocated(state%pending)) allocate (state%pending(0))
      if (all(state%pending /= number)) state%pending = [state%pending, number]
   end subroutine tell_later

   !> Notes that a gap touches without a speed, so that contacts are judged again.
   pure subroutine touch(state, gap)
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> The gap.
      integer, intent(in) :: gap

      state%unsettled = .true.
      if (.not. allocated(state%touching)) allocate (state%touching(0))
      if (all(state%touching /= gap)) state%touching = [state%touching, gap]
   end subroutine touch

   !> Forgets what holds only at the instant at which a flight began.
   pure subroutine leave_instant(state)
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state

      state%leaving = leaving_type()
      state%released = 0
      state%changes = 0
      if (allocated(state%touching)) deallocate (state%touching)
      if (.not. allocated(state%partings)) return
      if (size(state%partings) == 1) call move_alloc(state%partings, state%spare)
      if (allocated(state%partings)) deallocate (state%partings)
   end subroutine leave_instant

   !> Finds whether friction at s = 0 sticks or slips, and puts a state into that regime.
   !!
   !! What sticks must be held by at most its stick level; else it slips to the side to which it is
   !! driven. What began to slip must go on to that side. One changes at a time, first the one that
   !! exceeds its stick level by the largest factor.
   pure subroutine settle_friction(run, halted, phase, q, rate, state, status)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> The friction.
      integer, intent(in) :: halted(:)
      !> The load phase (rad), and (n) coordinates and velocities.
      real(wp), intent(in) :: phase, q(:), rate(:)
      !> In: a regime and pairs from which to begin. Out: the regime and pairs.
      type(run_state_type), intent(inout) :: state
      !> `stat%ok`, `stat%friction_undecided`, or as in `new_regime`.
      integer, intent(out) :: status
      integer, allocatable :: closed(:)
      integer :: changes, i, order, sense, wrong, to
      real(wp) :: force, most

      status = stat%ok
      do changes = 1, 2**min(size(halted) + 3, 12)
         wrong = 0
         to = 0
         most = 1 + tolerance
         associate (regime => run%regimes(state%regime), structure => run%structure)
            do i = 1, size(halted)
               if (all(regime%held /= halted(i))) cycle
               force = holding_force(run, state, halted(i), phase)
               if (abs(force) <= most*structure%laws(halted(i))%numbers(2)) cycle
               wrong = halted(i)
               to = merge(0, -wrong, force > 0)
               most = abs(force)/max(structure%laws(wrong)%numbers(2), tiny(1.0_wp))
            end do
            do i = 1, size(halted)
               if (wrong /= 0 .or. any(regime%closed == halted(i))) cycle
               if (is_absorbed(structure, halted(i), regime%resting)) cycle
               call leading_term(regime, state%x, state%v, phase, structure%channel(halted(i)), 1, &
                  order, sense)
               if (sense == merge(-1, 1, any(regime%closed == -halted(i)))) cycle
               wrong = halted(i)
               to = wrong
            end do
            if (wrong == 0) return
            closed = replaced(regime%closed, wrong, to)
         end associate
         call enter(run, closed, phase, q, rate, state, status)
         if (status /= stat%ok) return
      end do
      status = stat%friction_undecided
   end subroutine settle_friction

   !> The force that holds friction that sticks.
   pure real(wp) function holding_force(run, state, number, phase) result(force)
      !> The run.
      type(run_type), intent(in) :: run
      !> The state.
      type(run_state_type), intent(in) :: state
      !> The friction.
      integer, intent(in) :: number
      !> The load phase (rad).
      real(wp), intent(in) :: phase
      real(wp) :: d(0:3)

      associate (regime => run%regimes(state%regime))
         call row_derivatives(regime, state%x, state%v, phase, run%structure%channels &
            + findloc(regime%held, number, dim=1), d)
      end associate
      force = d(0)
   end function holding_force

   !> Reports friction that changed at this instant as an event, and decides again which friction
   !! sticks.
   !!
   !! A force of a load, a stop or other friction that jumps may exceed the stick level.
   pure subroutine judge_friction(run, state, event, changed, status)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> The change.
      type(run_event_type), intent(inout) :: event
      !> Whether there is one.
      logical, intent(out) :: changed
      !> `stat%ok`, or as in `settle_friction`.
      integer, intent(out) :: status
      integer, allocatable :: sticks(:)
      real(wp) :: phase, speed
      integer :: i

      status = stat%ok
      changed = .false.
      phase = run%load%frequency*state%elapsed
      if (.not. allocated(state%pending)) then
         associate (regime => run%regimes(state%regime))
            allocate (sticks, source=regime%held(size(regime%resting) + 1:))
         end associate
         do i = 1, size(sticks)
            changed = changed .or. abs(holding_force(run, state, sticks(i), phase)) > &
               run%structure%laws(sticks(i))%numbers(2)*(1 + tolerance)
         end do
         if (.not. changed) return
         call settle_all(run, sticks, phase, state, status)
         if (status /= stat%ok) return
      end if
      changed = .false.
      do while (size(state%pending) > 0)
         ! friction along a gap that rests again at this instant has no part in the motion
         changed = .not. is_absorbed(run%structure, state%pending(1), &
            run%regimes(state%regime)%resting)
         if (changed) then
            call state_now(run, state, state%q, state%rate)
            associate (number => state%pending(1))
               speed = 0
               if (.not. run%structure%rubs(number)) speed = speed_of_stop(run, number, state)
               call note(state, kind_of_friction(run, state, number), number, speed, 0.0_wp, &
                  state%q, state%rate, event)
            end associate
         end if
         state%pending = state%pending(2:)
         if (changed) exit
      end do
      if (size(state%pending) == 0) deallocate (state%pending)
   end subroutine judge_friction

   !> Settles friction at s = 0, lists what slips from there, and what changed.
   pure subroutine settle_all(run, halted, phase, state, status, before)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> The friction.
      integer, intent(in) :: halted(:)
      !> The load phase (rad).
      real(wp), intent(in) :: phase
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> `stat%ok`, or as in `settle_friction`.
      integer, intent(out) :: status
      !> What was closed before, if that is not what is now.
      integer, intent(in), optional :: before(:)
      integer, allocatable :: old(:)
      integer :: i, order, sense

      if (present(before)) then
         allocate (old, source=before)
      else
         allocate (old, source=run%regimes(state%regime)%closed)
      end if
      call state_now(run, state, state%q, state%rate)
      call settle_friction(run, halted, phase, state%q, state%rate, state, status)
      if (status /= stat%ok) return
      associate (closed => run%regimes(state%regime)%closed, structure => run%structure)
         if (allocated(state%partings)) state%partings = pack(state%partings, &
            state%partings%row <= structure%channels)
         if (.not. allocated(state%pending)) allocate (state%pending(0))
         do i = 1, size(halted)
            associate (number => halted(i))
               if ((any(closed == number) .neqv. any(old == number)) .or. (any(closed == -number) &
                  .neqv. any(old == -number))) call tell_later(state, number)
               if (any(closed == number)) cycle
               call leading_term(run%regimes(state%regime), state%x, state%v, phase, &
                  structure%channel(number), 1, order, sense)
               call part(run, state, structure%channel(number), merge(1, -1, any(closed == &
                  -number)), order)
            end associate
         end do
      end associate
      state%unsettled = state%unsettled .or. allocated(state%touching)
      if (size(run%regimes(state%regime)%resting) > 0) state%unsettled = .true.
   end subroutine settle_all

   !> The kind of the event with which friction came into its state.
   pure integer function kind_of_friction(run, state, number) result(kind)
      !> The run.
      type(run_type), intent(in) :: run
      !> The state.
      type(run_state_type), intent(in) :: state
      !> The friction.
      integer, intent(in) :: number

      kind = slip_up_event
      if (.not. run%structure%rubs(number)) then
         ! a stop that an impact changes
         kind = merge(press_event, let_go_event, any(run%regimes(state%regime)%closed == number))
         return
      end if
      if (any(run%regimes(state%regime)%closed == number)) kind = halt_event
      if (any(run%regimes(state%regime)%closed == -number)) kind = slip_down_event
   end function kind_of_friction

   !> Advances to where friction ceases to slip: it sticks, or slips to the other side.
   pure subroutine end_slip(run, state, reached, event, passes, status)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> In: at the start of the flight. Out: where s = 0.
      type(run_state_type), intent(inout) :: state
      !> The limit that is reached.
      type(reached_type), intent(in) :: reached
      !> The event.
      type(run_event_type), intent(inout) :: event
      !> Whether there is an event; none if it goes on to the same side.
      logical, intent(out) :: passes
      !> `stat%ok`, or as in `settle_friction`.
      integer, intent(out) :: status
      integer, allocatable :: before(:), halted(:)
      real(wp) :: phase
      integer :: number

      number = gap_of(run%regimes(state%regime), reached%row, reached%wall)
      call move(run, state, reached%time)
      if (.not. at_once(run, reached%time)) call leave_instant(state)
      phase = run%load%frequency*state%elapsed
      call state_now(run, state, state%q, state%rate)
      allocate (before, source=run%regimes(state%regime)%closed)
      ! without what rounding leaves of s
      associate (structure => run%structure)
         state%rate = state%rate - structure%mobility(:, number)*structure%effective(number) &
            *(dot_product(structure%directions(:, number), state%rate) &
            - structure%laws(number)%numbers(3))
      end associate
      call enter(run, replaced(before, number, number), phase, state%q, state%rate, state, status)
      passes = .false.
      if (status /= stat%ok) return
      associate (regime => run%regimes(state%regime))
         allocate (halted, source=regime%held(size(regime%resting) + 1:))
      end associate
      ! the one that halts comes first
      halted = [number, pack(halted, halted /= number)]
      call settle_all(run, halted, phase, state, status, before)
      if (status == stat%ok) call judge_friction(run, state, event, passes, status)
   end subroutine end_slip

   !> Advances to where friction that sticks begins to slip.
   pure subroutine begin_slip(run, state, reached, event, passes, status)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> In: at the start of the flight. Out: where it begins to slip.
      type(run_state_type), intent(inout) :: state
      !> The limit that is reached.
      type(reached_type), intent(in) :: reached
      !> The event.
      type(run_event_type), intent(inout) :: event
      !> Whether it slips; otherwise the force only touches its limit.
      logical, intent(out) :: passes
      !> `stat%ok`, or as in `settle_friction`.
      integer, intent(out) :: status
      integer, allocatable :: before(:), halted(:)
      real(wp) :: phase
      integer :: number, order, sense
      logical :: grazes

      status = stat%ok
      grazes = only_touches(run, state, reached)
      associate (regime => run%regimes(state%regime))
         number = -gap_of(regime, reached%row, reached%wall)
         allocate (before, source=regime%closed)
         allocate (halted, source=regime%held(size(regime%resting) + 1:))
         halted = [number, pack(halted, halted /= number)]
      end associate
      call move(run, state, reached%time)
      if (.not. at_once(run, reached%time)) call leave_instant(state)
      phase = run%load%frequency*state%elapsed
      call leading_term(run%regimes(state%regime), state%x, state%v, phase, reached%row, 1, order, &
         sense)
      passes = .not. grazes .or. reached%wall*sense > 0
      if (.not. passes) then
         call part(run, state, reached%row, reached%wall, order)
         return
      end if
      call state_now(run, state, state%q, state%rate)
      call enter(run, replaced(before, number, merge(0, -number, reached%wall > 0)), phase, &
         state%q, state%rate, state, status)
      if (status /= stat%ok) return
      call leading_term(run%regimes(state%regime), state%x, state%v, phase, &
         run%structure%channel(number), 1, order, sense)
      if (reached%wall*sense <= 0) status = stat%friction_undecided
      if (status == stat%ok) call settle_all(run, halted, phase, state, status, before)
      if (status == stat%ok) call judge_friction(run, state, event, passes, status)
   end subroutine begin_slip

   !> The friction whose speed impulses on gaps change.
   pure function rubs_with(structure, gaps) result(rubbing)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The gaps.
      integer, intent(in) :: gaps(:)
      integer, allocatable :: rubbing(:)
      real(wp), parameter :: no_coupling = 1.0e-12_wp
      integer :: i, j

      allocate (rubbing(0))
      if (.not. structure%has_friction) return
      do j = 1, size(structure%openings)
         if (.not. structure%rubs(j)) cycle
         if (any([(abs(dot_product(structure%directions(:, j), structure%mobility(:, gaps(i)))) &
            *sqrt(structure%effective(gaps(i))*structure%effective(j)) > no_coupling, i=1, &
            size(gaps))])) rubbing = [rubbing, j]
      end do
   end function rubs_with

   !> Puts a state just after an impact into the regime in which friction has the sign of s.
   pure subroutine rub(run, rubbing, sizes, phase, state, status)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> The friction whose speeds jumped.
      integer, intent(in) :: rubbing(:)
      !> (n) The largest velocities during the impact, of which rounding is a share.
      real(wp), intent(in) :: sizes(:)
      !> The load phase (rad).
      real(wp), intent(in) :: phase
      !> In and out: the state, with q and q' after the impact.
      type(run_state_type), intent(inout) :: state
      !> `stat%ok`, or as in `settle_friction`.
      integer, intent(out) :: status
      integer, allocatable :: before(:), closed(:), halted(:)
      real(wp) :: scale, speed
      integer :: i, to

      allocate (before, source=run%regimes(state%regime)%closed)
      allocate (closed, source=before)
      associate (structure => run%structure)
         do i = 1, size(rubbing)
            associate (number => rubbing(i), belt => structure%laws(rubbing(i))%numbers(3), &
               direction => structure%directions(:, rubbing(i)))
               speed = dot_product(direction, state%rate) - belt
               scale = 64*epsilon(1.0_wp)*(dot_product(abs(direction), sizes) + abs(belt))
               to = merge(number, 0, abs(speed) <= scale)
               if (speed < -scale) to = -number
               closed = replaced(closed, number, to)
            end associate
         end do
      end associate
      call enter(run, closed, phase, state%q, state%rate, state, status)
      if (status /= stat%ok) return
      associate (regime => run%regimes(state%regime))
         allocate (halted, source=regime%held(size(regime%resting) + 1:))
      end associate
      call settle_all(run, halted, phase, state, status, before)
      if (status /= stat%ok) return
      associate (after => run%regimes(state%regime)%closed)
         do i = 1, size(rubbing)
            if (any(halted == rubbing(i))) cycle
            if ((any(after == -rubbing(i)) .neqv. any(before == -rubbing(i))) .or. any(before == &
               rubbing(i))) call tell_later(state, rubbing(i))
         end do
      end associate
      if (size(state%pending) == 0) deallocate (state%pending)
   end subroutine rub

   !> The number of the regime of a set of closed gaps and stops; the regime is made if it is new.
   pure subroutine find_regime(run, set, number, status, searched, renewed)
      !> In and out: with its regimes.
      type(run_type), intent(inout) :: run
      !> The set, as in `regime_type`.
      integer, intent(in) :: set(:)
      !> Its number.
      integer, intent(out) :: number
      !> `stat%ok`, or as in `new_regime`.
      integer, intent(out) :: status
      !> As in `new_regime`.
      logical, intent(in), optional :: searched, renewed
      type(regime_type), allocatable :: more(:)
      integer :: n

      status = stat%ok
      n = size(run%regimes)
      do number = 1, n
         if (.not. allocated(run%regimes(number)%closed)) exit
         associate (known => run%regimes(number)%closed)
            if (size(known) /= size(set)) cycle
            if (all(known == set)) return
         end associate
      end do
      if (number > n) then
         ! all of them are copied, so there is room for several more
         allocate (more(2*n + 6))
         more(:n) = run%regimes
         call move_alloc(more, run%regimes)
      end if
      call new_regime(run%structure, run%load, set, run%regimes(number), status, searched, renewed)
      ! one that failed is incomplete
      if (status /= stat%ok) deallocate (run%regimes(number)%closed)
   end subroutine find_regime

   !> Simulates to a time, or until the list of events is full.
   !!
   !! A flight of millions of steps may be interrupted: a further call goes on with its search, and
   !! gives the same results as one call.
   pure subroutine simulate_structure(run, state, last_cycle, last_elapsed, events, n, status, &
      interruptible)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> In: the start. Out: the end, or just after the last event if the list is full or the
      !! search for the next one was interrupted.
      type(run_state_type), intent(inout) :: state
      !> Whole periods at the end, and the remainder.
      integer(int64), intent(in) :: last_cycle
      !> As in `last_cycle`.
      real(wp), intent(in) :: last_elapsed
      !> The events, in the order of time.
      type(run_event_type), intent(inout) :: events(:)
      !> Their number.
      integer, intent(out) :: n
      !> `stat%ok`, `stat%more_events`, `stat%budget`, `stat%coupled_impacts`, or as of
      !! `hit_together` and `new_regime`. `stat%more_events` also if a search was interrupted.
      integer, intent(out) :: status
      !> Whether a search may be interrupted, so that the caller can stop; not by default.
      logical, intent(in), optional :: interruptible
      !> Steps before a search is interrupted, each times the pairs and rows that it computes; they
      !! take about 0.1 s.
      integer, parameter :: patience = 1000000
      !> Rounding of times between two samples.
      real(wp), parameter :: at_sample = 16*epsilon(1.0_wp)
      type(reached_type) :: reached
      real(wp) :: limit, remaining
      integer :: most
      logical :: changed, goes_on, in_parts

      n = 0
      status = stat%ok
      in_parts = .false.
      ! the state may not be that of the last impact
      state%space%watch%kept = .false.
      if (present(interruptible)) in_parts = interruptible
      do
         goes_on = state%pace%from > 0
         if (run%pair%known .and. .not. goes_on) call pass_impacts(run, state, last_cycle, &
            last_elapsed, events, n)
         if (.not. goes_on) call begin_interval(run, state, last_cycle)
         remaining = real(last_cycle - state%cycle, wp)*run%period + (last_elapsed - state%elapsed)
         limit = remaining
         if (run%load%step > 0) then
            if (state%cycle < size(run%load%record, 2) - 1) limit = min(remaining, &
               run%period - state%elapsed)
         end if
         if (n == size(events)) then
            status = stat%more_events
            return
         end if
         changed = .false.
         if (allocated(state%together)) call hit_together(run, state, events(n + 1), changed, &
            status)
         if (status /= stat%ok) return
         if (state%unsettled .and. .not. changed) call judge_contacts(run, state, events(n + 1), &
            changed, status)
         if (status /= stat%ok) return
         if ((run%structure%has_friction .or. allocated(state%pending)) .and. .not. (changed .or. &
            goes_on)) call judge_friction(run, state, events(n + 1), changed, status)
         if (status /= stat%ok) return
         if (state%leaving%row > 0 .and. .not. (changed .or. goes_on)) call accumulate(run, state, &
            limit, events(n + 1), changed, status)
         if (status /= stat%ok) return
         if (changed) then
            n = n + 1
            cycle
         end if
         most = huge(most)
         if (in_parts) most = patience/(1 + size(state%x)*size(run%regimes(state%regime)%upper))
         call first_event(run%regimes(state%regime), state%x, state%v, &
            run%load%frequency*state%elapsed, state%leaving, limit, state%pace, reached, &
            state%space, most, state%partings)
         if (.not. reached%complete) status = stat%budget
         if (reached%interrupted) status = stat%more_events
         if (status /= stat%ok) return
         ! a force that falls to 0 at a sample is judged there, by how it goes on
         if (reached%row > run%structure%channels .and. limit < remaining .and. &
            limit - reached%time <= at_sample*run%period) reached%row = 0
         if (reached%row == 0 .and. limit < remaining) then
            ! to the next sample
            call move(run, state, limit)
            if (state%elapsed > 0.5_wp*run%period) state%cycle = state%cycle + 1
            state%elapsed = 0
            call leave_instant(state)
            ! the force of the record may jump
            state%unsettled = size(run%regimes(state%regime)%resting) > 0
            cycle
         end if
         if (reached%row == 0) exit
         if (reached%row > run%structure%channels + size(run%regimes(state%regime)%resting)) then
            call begin_slip(run, state, reached, events(n + 1), changed, status)
            if (.not. changed .and. status == stat%ok) cycle
         else if (reached%row > run%structure%channels) then
            call touch_zero(run, state, reached, changed)
            if (changed) cycle
            call release(run, state, reached, events(n + 1), status)
         else if (is_own_row(run, run%regimes(state%regime), reached%row, reached%wall)) then
            if (run%structure%rubs(gap_of(run%regimes(state%regime), reached%row, &
               reached%wall))) then
               call end_slip(run, state, reached, events(n + 1), changed, status)
            else
               call pass_stop(run, state, reached, events(n + 1), changed, status)
            end if
            if (.not. changed .and. status == stat%ok) cycle
         else
            call collide(run, state, reached, events(n + 1), status)
            if (status == stat%coupled_impacts .and. run%structure%simultaneous /= refused) then
               status = stat%ok
               call begin_together(run, state, reached)
               cycle
            end if
         end if
         if (status /= stat%ok) return
         n = n + 1
      end do
      if (remaining > 0) call leave_instant(state)
      call move(run, state, remaining)
      if (run%load%step > 0 .and. remaining > 0) state%unsettled = &
         size(run%regimes(state%regime)%resting) > 0
      state%cycle = last_cycle
      state%elapsed = last_elapsed
   end subroutine simulate_structure

   !> Passes impacts of the oscillator of 1983, up to one from which another search has to go on.
   pure subroutine pass_impacts(run, state, last_cycle, last_elapsed, events, n)
      !> The run.
      type(run_type), intent(in) :: run
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> As in `simulate_structure`.
      integer(int64), intent(in) :: last_cycle
      !> As in `simulate_structure`.
      real(wp), intent(in) :: last_elapsed
      !> In and out: the events.
      type(run_event_type), intent(inout) :: events(:)
      !> In and out: their number.
      integer, intent(inout) :: n
      type(place_type) :: place
      type(state_type) :: here
      logical :: found

      if (state%leaving%row == 0 .or. state%unsettled .or. state%regime /= 1) return
      associate (regime => run%regimes(1), structure => run%structure, h => run%pair%host, &
         p => run%pair%particle)
         call state_now(run, state, state%q, state%rate)
         place = place_type(state%cycle, state%elapsed, state%q([h, p]), state%rate([h, p]), &
            gap=gap_of(regime, 1, state%leaving%wall), departure=state%leaving%speed)
         here = place_in(run%pair, place)
         do while (n < size(events))
            call next_impact(run%pair, real(last_cycle - place%cycle, wp)*run%period &
               + (last_elapsed - place%elapsed), here, place, found)
            if (.not. found) return
            n = n + 1
            state%cycle = place%cycle
            state%elapsed = place%elapsed
            state%q([h, p]) = place%q
            state%rate([h, p]) = place%rate
            ! the particle has no part that is due to the load
            state%x(h) = regime%xq(h, h)*place%free(1)
            state%v(h) = regime%vd(h, h)*place%free(2)
            state%x(p) = regime%xq(p, p)*place%q(2)
            state%v(p) = regime%vd(p, p)*place%rate(2)
            state%leaving = leaving_type(1, structure%wall(place%gap), place%departure)
            call note(state, impact_event, place%gap, place%approach, (place%approach &
               + place%departure)*structure%effective(place%gap), state%q, state%rate, events(n))
         end do
      end associate
   end subroutine pass_impacts

   !> With a record: passes intervals without events, and sets the forces of the flight.
   pure subroutine begin_interval(run, state, last_cycle)
      !> In and out: the run.
      type(run_type), intent(inout) :: run
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> The last interval.
      integer(int64), intent(in) :: last_cycle

      integer(int64) :: first

      if (.not. run%load%step > 0) return
      if (.not. state%elapsed > 0 .and. state%leaving%row == 0 .and. .not. state%unsettled) then
         first = state%cycle
         call pass_intervals(run%regimes(state%regime), run%load, state%cycle, last_cycle, &
            state%x, state%v)
         if (state%cycle > first) then
            call leave_instant(state)
            state%unsettled = size(run%regimes(state%regime)%resting) > 0
         end if
      end if
      call set_forces(run%regimes(state%regime), run%load, state%cycle, state%elapsed)
   end subroutine begin_interval

   !> Advances time and pairs.
   pure subroutine move(run, state, time)
      !> The run.
      type(run_type), intent(in) :: run
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> Time to advance.
      real(wp), intent(in) :: time
      integer(int64) :: cycles

      if (time > 0) call advance_in_place(run%regimes(state%regime)%modes, time, state%x, state%v)
      state%elapsed = state%elapsed + time
      if (state%elapsed < run%period) return
      cycles = min(whole_periods(run, state%elapsed), most_periods - state%cycle)
      state%cycle = state%cycle + cycles
      state%elapsed = max(0.0_wp, state%elapsed - real(cycles, wp)*run%period)
   end subroutine move

   !> Puts a state just after impacts into the regime of the stops and the friction whose forces
   !! they change.
   pure subroutine follow_impacts(run, gaps, sizes, state, changed, status)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> The gaps that were hit at this instant.
      integer, intent(in) :: gaps(:)
      !> As of `rub`.
      real(wp), intent(in) :: sizes(:)
      !> In and out: the state, with q and q' after the impacts.
      type(run_state_type), intent(inout) :: state
      !> Whether the regime was chosen again.
      logical, intent(out) :: changed
      !> `stat%ok`, or as in `settle_friction`.
      integer, intent(out) :: status
      integer, allocatable :: rubbing(:)
      real(wp) :: phase

      phase = run%load%frequency*state%elapsed
      call press_anew(run, gaps, phase, state, changed, status)
      if (status /= stat%ok) return
      rubbing = rubs_with(run%structure, gaps)
      if (size(rubbing) == 0) return
      changed = .true.
      call rub(run, rubbing, sizes, phase, state, status)
   end subroutine follow_impacts

   !> Lets go of stops that impacts make pull, and presses those that they make push: their forces
   !! jump by their dashpots, and do not pass 0.
   pure subroutine press_anew(run, gaps, phase, state, presses, status)
      !> In and out: the regime is added.
      type(run_type), intent(inout) :: run
      !> The gaps, and the load phase (rad).
      integer, intent(in) :: gaps(:)
      real(wp), intent(in) :: phase
      !> In and out: the state, with q and q' after the impacts.
      type(run_state_type), intent(inout) :: state
      !> Whether there are such stops.
      logical, intent(out) :: presses
      !> `stat%ok`, or as in `new_regime`.
      integer, intent(out) :: status
      integer, allocatable :: changed(:), closed(:), now(:)
      integer :: i, j, k

      status = stat%ok
      presses = .false.
      if (.not. any(run%structure%push > 0)) return
      allocate (closed, source=run%regimes(state%regime)%closed)
      allocate (changed(0))
      do i = 1, size(closed)
         j = abs(closed(i))
         if (.not. run%structure%push(j) > 0) cycle
         if (.not. any([(is_moved(j, gaps(k)), k=1, size(gaps))])) cycle
         now = without_force(run, [j], phase, state%q, state%rate)
         if (now(1) /= closed(i)) changed = [changed, j]
      end do
      presses = size(changed) > 0
      if (.not. presses) return
      do i = 1, size(changed)
         j = merge(-changed(i), changed(i), any(closed == changed(i)))
         closed = replaced(closed, changed(i), j)
         call tell_later(state, changed(i))
      end do
      call enter(run, closed, phase, state%q, state%rate, state, status)
   contains
      !> Whether an impulse on a gap changes the speed of a stop.
      pure logical function is_moved(number, gap)
         !> Numbers of the stop and of the gap.
         integer, intent(in) :: number, gap

         associate (direction => run%structure%directions(:, number), &
            mobility => run%structure%mobility(:, gap))
            is_moved = abs(dot_product(direction, mobility)) > 64*epsilon(1.0_wp)* &
               dot_product(abs(direction), abs(mobility))
         end associate
      end function is_moved
   end subroutine press_anew

   !> Advances to an impact and through it.
   !!
   !! With a speed that is nothing but rounding the gap only touches, whatever its coefficient of
   !! restitution is: no impulse is exchanged, and contacts are judged again.
   pure subroutine collide(run, state, reached, event, status)
      !> The run.
      type(run_type), intent(inout) :: run
      !> In: at the start of the flight. Out: just after the impact.
      type(run_state_type), intent(inout) :: state
      !> The limit that is reached.
      type(reached_type), intent(in) :: reached
      !> The impact.
      type(run_event_type), intent(inout) :: event
      !> `stat%ok`, or `stat%coupled_impacts` where its outcome is not defined; as in
      !! `settle_friction`.
      integer, intent(out) :: status
      real(wp) :: impulse, restitution, slope
      integer :: j, gap
      logical :: bare, changes, pushes

      status = stat%ok
      ! whether the end of a contact is decided by a force
      pushes = run%structure%has_stops
      if (pushes) pushes = any(run%structure%push > 0)
      bare = state%bare .and. run%regimes(state%regime)%coordinates%by_position .and. &
         run%structure%simultaneous == refused .and. .not. (run%structure%has_friction .or. pushes)
      associate (regime => run%regimes(state%regime), structure => run%structure, q => state%q, &
         rate => state%rate)
         gap = gap_of(regime, reached%row, reached%wall)
         if (only_touches(run, state, reached)) then
            call move(run, state, reached%time)
            call state_now(run, state, q, rate)
            if (.not. at_once(run, reached%time)) call leave_instant(state)
            state%leaving = leaving_type()
            state%released = 0
            call touch(state, gap)
            call note(state, impact_event, gap, reached%speed, 0.0_wp, q, rate, event)
            return
         end if
         do j = 1, size(regime%resting)
            if (are_coupled(structure, gap, regime%resting(j))) status = stat%coupled_impacts
         end do
         if (at_once(run, reached%time) .and. state%leaving%row > 0) then
            if (are_coupled(structure, gap, gap_of(regime, state%leaving%row, &
               state%leaving%wall))) status = stat%coupled_impacts
         end if
         if (at_once(run, reached%time) .and. allocated(state%touching)) then
            do j = 1, size(state%touching)
               if (are_coupled(structure, gap, state%touching(j))) status = stat%coupled_impacts
            end do
         end if
         call move(run, state, reached%time)
         if (bare) then
            call coupled_coordinates(run, gap, state)
         else
            call state_now(run, state, q, rate)
         end if
         if (closes_another(run, run%load%frequency*state%elapsed, q, rate, gap)) status = &
            stat%coupled_impacts
         if (status /= stat%ok) return
         if (.not. at_once(run, reached%time)) call leave_instant(state)
         ! an impact at the same instant changes how a stop is left
         if ((structure%has_stops .or. structure%has_friction) .and. allocated(state%partings)) then
            state%partings = pack(state%partings, [(.not. is_own_row(run, regime, &
               state%partings(j)%row, state%partings(j)%wall), j=1, size(state%partings))])
         end if
         call restitution_of(structure, gap, reached%speed, restitution, slope)
         impulse = (1 + restitution)*structure%effective(gap)*reached%speed
         if (regime%kicks_x) call kick(regime%modes%wide, impulse, regime%kick_x(:, gap), state%x)
         call kick(regime%modes%wide, impulse, regime%kick_v(:, gap), state%v)
         ! the forces of a record change from one interval to the next
         if (.not. run%load%step > 0) call keep_watch(regime, gap, reached%row, impulse, &
            reached%time, state%space%watch)
         if (.not. bare) call kick(regime%modes%wide, impulse, structure%mobility(:, gap), rate)
         state%leaving = leaving_type(reached%row, reached%wall, restitution*reached%speed)
         state%released = 0
         if (.not. state%leaving%speed > 0) then
            state%leaving = leaving_type()
            call touch(state, gap)
         end if
         ! dashpots may change the forces of other contacts
         if (size(regime%resting) > 0 .or. allocated(state%touching)) state%unsettled = .true.
         call note(state, impact_event, gap, reached%speed, impulse, q, rate, event, bare)
      end associate
      if (.not. (pushes .or. run%structure%has_friction)) return
      call follow_impacts(run, [gap], abs(state%rate) + impulse*abs(run%structure%mobility(:, &
         gap)), state, changes, status)
      if (status /= stat%ok .or. .not. changes) return
      call note(state, impact_event, gap, reached%speed, impulse, state%q, state%rate, event)
   end subroutine collide

   !> Finds the gaps that are closed where an impact is coupled with others.
   !!
   !! A gap that is coupled with one of them and closed, whether it closes, rests or has just been
   !! left, is one of them.
   pure subroutine begin_together(run, state, reached)
      !> The run.
      type(run_type), intent(in) :: run
      !> In and out: the state, moved to the instant by `collide`.
      type(run_state_type), intent(inout) :: state
      !> The limit that is reached.
      type(reached_type), intent(in) :: reached
      type(leaving_type) :: leaving
      integer, allocatable :: gaps(:)
      logical :: known(size(run%structure%openings))
      integer :: i, j, k
      logical :: kept

      associate (regime => run%regimes(state%regime), structure => run%structure)
         known = .false.
         known(regime%resting) = .true.
         if (.not. at_once(run, reached%time)) then
            call leave_instant(state)
         else
            if (state%leaving%row > 0) known(gap_of(regime, state%leaving%row, &
               state%leaving%wall)) = .true.
            if (allocated(state%touching)) known(state%touching) = .true.
            if (allocated(state%partings)) then
               do i = 1, size(state%partings)
                  if (state%partings(i)%row > structure%channels) cycle
                  known(gap_of(regime, state%partings(i)%row, state%partings(i)%wall)) = .true.
               end do
            end if
         end if
         allocate (gaps, source=[gap_of(regime, reached%row, reached%wall)])
         i = 1
         do while (i <= size(gaps))
            do k = structure%coupled_begins(gaps(i)), structure%coupled_begins(gaps(i) + 1) - 1
               j = structure%coupled(k)
               if (any(gaps == j)) cycle
               if (known(j) .or. is_closed(run, state, j)) gaps = [gaps, j]
            end do
            i = i + 1
         end do
         ! in ascending order, in which ties are decided
         known = .false.
         known(gaps) = .true.
         state%together = pack([(i, i=1, size(known))], known)
         state%freed = pack(regime%resting, known(regime%resting))
         state%largest = abs(state%rate)
         state%impacts = 0
         leaving = state%leaving
         state%leaving = leaving_type()
         state%released = 0
         if (allocated(state%touching)) state%touching = pack(state%touching, .not. &
            known(state%touching))
         if (allocated(state%partings)) then
            ! impulses change how stops and friction are left
            state%partings = pack(state%partings, [(.not. (is_own_row(run, regime, &
               state%partings(i)%row, state%partings(i)%wall) .or. any(structure%channel( &
               state%together) == state%partings(i)%row)), i=1, size(state%partings))])
         end if
         if (leaving%row > 0) then
            kept = .not. known(gap_of(regime, leaving%row, leaving%wall))
            if (kept) call part(run, state, leaving%row, leaving%wall, 1, leaving%speed)
         end if
      end associate
      state%space%watch%kept = .false.
   end subroutine begin_together

   !> Whether a gap is closed, apart from rounding.
   pure logical function is_closed(run, state, gap)
      !> The run.
      type(run_type), intent(in) :: run
      !> The state, with its coordinates.
      type(run_state_type), intent(in) :: state
      !> The gap.
      integer, intent(in) :: gap
      real(wp) :: opening(0:2)

      opening = opening_at(run%structure, gap, run%load%frequency*state%elapsed, &
         run%load%frequency)
      associate (direction => run%structure%directions(:, gap))
         is_closed = opening(0) - dot_product(direction, state%q) <= 8*epsilon(1.0_wp) &
            *(abs(opening(0)) + dot_product(abs(direction), abs(state%q)))
      end associate
   end function is_closed

   !> One event of impacts on coupled gaps at one instant: first those that rest are released.
   !!
   !! In sequence the gap that closes fastest is hit, until none closes: rigid bodies collide in
   !! pairs (I. Han and B. J. Gilmore, Journal of Mechanical Design 115, 1993; A. P. Ivanov, On
   !! multiple impact, 1995). By Newton's law each event has one of the impulses that act at once;
   !! the law is applied again if gaps that parted close by it.
   pure subroutine hit_together(run, state, event, changed, status)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> The event.
      type(run_event_type), intent(inout) :: event
      !> Whether there is one; otherwise all these gaps part or touch without a speed.
      logical, intent(out) :: changed
      !> `stat%ok`, `stat%endless_sequence`, as in `newton_impulses`, or as in `settle_friction`.
      integer, intent(out) :: status
      real(wp), dimension(size(state%together)) :: speeds, rounding
      real(wp) :: phase, opening(0:2), restitution, slope, impulse, approach, least
      integer :: i, j

      status = stat%ok
      changed = .true.
      ! hops that follow each other ever faster end where they are rounding of the motion
      least = reach_of(run, state%largest)/time_of_motion(run)
      phase = run%load%frequency*state%elapsed
      if (size(state%freed) > 0) then
         i = state%freed(1)
         state%freed = state%freed(2:)
         call enter(run, opened(run%structure, run%regimes(state%regime)%closed, i), phase, &
            state%q, state%rate, state, status)
         if (status /= stat%ok) return
         do j = 1, size(run%structure%openings)
            if (abs(factor_along(run%structure, j, i)) > 0) call tell_later(state, j)
         end do
         call note(state, release_event, i, 0.0_wp, 0.0_wp, state%q, state%rate, event)
         event%together = .true.
         return
      end if
      do i = 1, size(speeds)
         associate (gap => state%together(i))
            opening = opening_at(run%structure, gap, phase, run%load%frequency)
            speeds(i) = dot_product(run%structure%directions(:, gap), state%rate) - opening(1)
            rounding(i) = 64*epsilon(1.0_wp)*(dot_product(abs(run%structure%directions(:, gap)), &
               max(state%largest, least)) + abs(opening(1)))
         end associate
      end do
      if (allocated(state%impulses)) then
         if (.not. any(state%impulses > 0)) deallocate (state%impulses)
      end if
      if (.not. allocated(state%impulses)) then
         if (.not. any(speeds > rounding)) then
            changed = .false.
            call part_together(run, state, speeds, rounding, status)
            return
         end if
         state%impacts = state%impacts + 1
         if (state%impacts > most_together) status = stat%endless_sequence
         if (status /= stat%ok) return
         state%approaches = speeds
         allocate (state%impulses(size(speeds)), source=0.0_wp)
         if (run%structure%simultaneous == by_newton) then
            where (abs(speeds) <= rounding) state%approaches = 0
            call newton_impulses(run%structure, state%together, state%approaches, rounding, &
               state%impulses, status)
            if (status /= stat%ok) return
         else
            i = maxloc(speeds - rounding, 1)
            call restitution_of(run%structure, state%together(i), speeds(i), restitution, slope)
            state%impulses(i) = (1 + restitution)*run%structure%effective(state%together(i)) &
               *speeds(i)
         end if
      end if
      i = findloc(state%impulses > 0, .true., 1)
      impulse = state%impulses(i)
      approach = state%approaches(i)
      state%impulses(i) = 0
      associate (regime => run%regimes(state%regime), structure => run%structure, &
         gap => state%together(i))
         if (regime%kicks_x) call kick(regime%modes%wide, impulse, regime%kick_x(:, gap), state%x)
         call kick(regime%modes%wide, impulse, regime%kick_v(:, gap), state%v)
         call kick(regime%modes%wide, impulse, structure%mobility(:, gap), state%rate)
         state%largest = max(state%largest, abs(state%rate))
         call note(state, impact_event, gap, approach, impulse, state%q, state%rate, event)
      end associate
      event%together = .true.
   end subroutine hit_together

   !> Ends impacts on coupled gaps: they part, or touch without a speed.
   pure subroutine part_together(run, state, speeds, rounding, status)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> (together) The speeds at which the gaps close, and those that are rounding.
      real(wp), intent(in) :: speeds(:), rounding(:)
      !> `stat%ok`, or as in `settle_friction`.
      integer, intent(out) :: status
      integer, allocatable :: gaps(:)
      integer :: i
      logical :: changes

      call move_alloc(state%together, gaps)
      deallocate (state%freed)
      do i = 1, size(gaps)
         if (abs(speeds(i)) <= rounding(i)) then
            call touch(state, gaps(i))
         else if (count(abs(speeds) > rounding) == 1) then
            ! its impacts may accumulate
            state%leaving = leaving_type(run%structure%channel(gaps(i)), &
               run%structure%wall(gaps(i)), -speeds(i))
         else
            call part(run, state, run%structure%channel(gaps(i)), run%structure%wall(gaps(i)), 1, &
               -speeds(i))
         end if
      end do
      if (size(run%regimes(state%regime)%resting) > 0) state%unsettled = .true.
      if (allocated(state%touching)) state%unsettled = .true.
      call follow_impacts(run, gaps, state%largest, state, changes, status)
   end subroutine part_together

   !> Subtracts what an impulse changes.
   pure subroutine kick(wide, impulse, by, x)
      !> Whether the processor has wide registers.
      logical, intent(in) :: wide
      !> The impulse, and the change by an impulse of -1.
      real(wp), intent(in) :: impulse
      real(wp), contiguous, intent(in) :: by(:)
      !> In and out: what is changed.
      real(wp), contiguous, intent(inout) :: x(:)

      if (wide) then
         call subtract_wide(size(x), impulse, by, x)
      else
         call subtract(size(x), impulse, by, x)
      end if
   end subroutine kick

   !> Advances to the limit of a stop, and into the regime beyond it.
   !!
   !! With a speed that is nothing but rounding the first derivative that is not 0 decides whether
   !! the limit is passed at all.
   pure subroutine pass_stop(run, state, reached, event, passes, status)
      !> In and out: the regime is added.
      type(run_type), intent(inout) :: run
      !> In: at the start of the flight. Out: at the limit, and beyond it if it is passed.
      type(run_state_type), intent(inout) :: state
      !> The limit that is reached.
      type(reached_type), intent(in) :: reached
      !> The event.
      type(run_event_type), intent(inout) :: event
      !> Whether the limit is passed; otherwise there is no event.
      logical, intent(out) :: passes
      !> `stat%ok`, `stat%stop_holds` where the stop would hold the structure at this limit, or as
      !! in `new_regime`.
      integer, intent(out) :: status
      real(wp) :: phase, speed
      integer :: kind, number, order, sense, to
      logical :: grazes

      status = stat%ok
      associate (regime => run%regimes(state%regime), structure => run%structure)
         number = gap_of(regime, reached%row, reached%wall)
         grazes = only_touches(run, state, reached)
         call move(run, state, reached%time)
         phase = run%load%frequency*state%elapsed
         if (.not. allocated(state%turns)) allocate (state%turns(size(regime%steady, 2)))
         call state_of(regime, phase, state%x, state%v, state%q, state%rate, state%turns)
         if (.not. at_once(run, reached%time)) call leave_instant(state)
         if (grazes) then
            call leading_term(regime, state%x, state%v, phase, reached%row, 1, order, sense)
            passes = reached%wall*sense > 0
            if (.not. passes) then
               call part(run, state, reached%row, reached%wall, order)
               return
            end if
         end if
         passes = .true.
         if (reached%row /= structure%channel(number)) then
            kind = merge(press_event, let_go_event, reached%wall > 0)
            to = merge(number, -number, kind == press_event)
         else
            kind = merge(touch_event, leave_event, reached%wall > 0)
            to = merge(number, 0, kind == touch_event)
         end if
      end associate
      call enter_beyond(run, reached, number, to, phase, state, status)
      if (status /= stat%ok) return
      ! the limit that was passed is left on its other side
      associate (regime => run%regimes(state%regime), row => reached%row, &
         structure => run%structure)
         if (grazes) then
            call leading_term(regime, state%x, state%v, phase, row, 1, order, sense)
            if (reached%wall*sense < 0) status = stat%stop_holds
            if (status /= stat%ok) return
            call part(run, state, row, -reached%wall, order)
         else
            call part(run, state, row, -reached%wall, 1, reached%speed)
         end if
         if (kind == touch_event .and. structure%push(number) > 0) then
            ! without a preload and a speed the force begins at 0
            call leading_term(regime, state%x, state%v, phase, structure%push(number), 0, order, &
               sense)
            if (order > 0) call part(run, state, structure%push(number), -1, order)
         end if
         if (size(regime%resting) > 0 .or. allocated(state%touching)) state%unsettled = .true.
         speed = reached%speed
         if (row /= structure%channel(number)) speed = speed_of_stop(run, number, state)
         call note(state, kind, number, speed, 0.0_wp, state%q, state%rate, event)
      end associate
   end subroutine pass_stop

   !> Puts a state at the limit of a stop into the regime beyond it.
   pure subroutine enter_beyond(run, reached, number, to, phase, state, status)
      !> In and out: the regime is added.
      type(run_type), intent(inout) :: run
      !> The limit, the stop, and how the stop is closed beyond it, as in `replaced`.
      type(reached_type), intent(in) :: reached
      integer, intent(in) :: number, to
      !> The load phase (rad).
      real(wp), intent(in) :: phase
      !> In and out: the state, with its coordinates, its velocities and e^(i h phase).
      type(run_state_type), intent(inout) :: state
      !> As of `enter`.
      integer, intent(out) :: status
      integer :: before, i

      status = stat%ok
      if (allocated(state%passages) .and. .not. allocated(state%partings)) then
         do i = 1, size(state%passages)
            associate (known => state%passages(i))
               if (known%from /= state%regime .or. known%row /= reached%row .or. &
                  known%wall /= reached%wall) cycle
               call change_pace(state, known%beyond)
               state%regime = known%beyond
               state%space%watch%kept = .false.
               call pass_pairs(size(state%x), size(state%turns), known%factors, state%turns, &
                  state%x, state%v)
               return
            end associate
         end do
      end if
      before = state%regime
      call enter(run, replaced(run%regimes(before)%closed, number, to), phase, state%q, &
         state%rate, state, status)
      ! with a record the constant terms change, and what leaves other limits is listed again
      if (status /= stat%ok .or. run%load%step > 0 .or. allocated(state%partings)) return
      if (max(size(state%x), size(state%turns)) > few .or. &
         size(state%x) /= size(run%regimes(before)%qx, 2)) return
      if (allocated(state%passages)) then
         if (size(state%passages) >= most_passages) return
      end if
      call keep_passage(run%regimes(before), run%regimes(state%regime), passage_type(before, &
         reached%row, reached%wall, state%regime), state%passages)
   end subroutine enter_beyond

   !> Keeps how the pairs of two regimes follow from each other.
   pure subroutine keep_passage(before, after, passage, passages)
      !> The regimes, with equally many pairs.
      type(regime_type), intent(in) :: before, after
      !> The limit between them.
      type(passage_type), intent(in) :: passage
      !> In and out: the passage is added.
      type(passage_type), allocatable, intent(inout) :: passages(:)

      if (.not. allocated(passages)) allocate (passages(0))
      passages = [passages, passage]
      associate (m => size(before%qx, 2), harmonics => size(before%steady, 2), &
         jump => reshape(before%offset - after%offset, [size(before%offset), 1]), &
         steady => before%steady - after%steady, steady_rate => before%steady_rate &
         - after%steady_rate)
         allocate (passages(size(passages))%factors(2*(m + harmonics) + 1, 2*m))
         associate (factors => passages(size(passages))%factors)
            factors(:, :m) = transpose(reshape([matmul(after%xq, before%qx) + matmul(after%xd, &
               before%dx), matmul(after%xq, before%qv) + matmul(after%xd, before%dv), &
               matmul(after%xq, steady%re) + matmul(after%xd, steady_rate%re), &
               -matmul(after%xq, steady%im) - matmul(after%xd, steady_rate%im), &
               matmul(after%xq, jump)], [m, size(factors, 1)]))
            factors(:, m + 1:) = transpose(reshape([matmul(after%vq, before%qx) &
               + matmul(after%vd, before%dx), matmul(after%vq, before%qv) + matmul(after%vd, &
               before%dv), matmul(after%vq, steady%re) + matmul(after%vd, steady_rate%re), &
               -matmul(after%vq, steady%im) - matmul(after%vd, steady_rate%im), &
               matmul(after%vq, jump)], [m, size(factors, 1)]))
         end associate
      end associate
   end subroutine keep_passage

   !> The pairs beyond the limit of a stop.
   pure subroutine pass_pairs(m, harmonics, factors, turns, x, v)
      !> Numbers of pairs and of harmonics, at most `few`.
      integer, intent(in) :: m, harmonics
      !> As in `passage_type`, and e^(i h phase).
      real(wp), intent(in) :: factors(2*(m + harmonics) + 1, 2*m)
      complex(wp), intent(in) :: turns(harmonics)
      !> In and out: the pairs.
      real(wp), intent(inout) :: x(m), v(m)
      real(wp) :: before(4*few + 1), of_x, of_v
      integer :: i, k

      do i = 1, m
         before(i) = x(i)
         before(m + i) = v(i)
      end do
      do i = 1, harmonics
         before(2*m + i) = turns(i)%re
         before(2*m + harmonics + i) = turns(i)%im
      end do
      before(2*(m + harmonics) + 1) = 1
      do i = 1, m
         of_x = 0
         of_v = 0
         do k = 1, 2*(m + harmonics) + 1
            of_x = of_x + factors(k, i)*before(k)
            of_v = of_v + factors(k, m + i)*before(k)
         end do
         x(i) = of_x
         v(i) = of_v
      end do
   end subroutine pass_pairs

   !> The speed at which a stop is pressed or left.
   pure real(wp) function speed_of_stop(run, number, state) result(speed)
      !> The run.
      type(run_type), intent(in) :: run
      !> The stop.
      integer, intent(in) :: number
      !> The state, with its velocities.
      type(run_state_type), intent(in) :: state
      real(wp) :: wall(0:2)

      wall = opening_at(run%structure, number, run%load%frequency*state%elapsed, &
         run%load%frequency)
      speed = abs(dot_product(run%structure%directions(:, number), state%rate) - wall(1))
   end function speed_of_stop

   !> Lists a row that leaves a limit, if the regime has this limit.
   pure subroutine part(run, state, row, wall, order, speed)
      !> The run.
      type(run_type), intent(in) :: run
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> The row, its limit, and the order of the first derivative that is not 0.
      integer, intent(in) :: row, wall, order
      !> The rate at which it leaves, if it is known.
      real(wp), intent(in), optional :: speed
      type(leaving_type) :: leaving
      real(wp) :: d(0:3)

      leaving = leaving_type(row, wall, 0.0_wp, order)
      if (.not. has_limit(run%regimes(state%regime), leaving)) return
      if (present(speed)) then
         leaving%speed = speed
      else if (order == 1) then
         call row_derivatives(run%regimes(state%regime), state%x, state%v, &
            run%load%frequency*state%elapsed, row, d)
         leaving%speed = abs(d(1))
      end if
      if (allocated(state%partings)) then
         state%partings = [pack(state%partings, state%partings%row /= row), leaving]
      else
         if (allocated(state%spare)) call move_alloc(state%spare, state%partings)
         if (.not. allocated(state%partings)) allocate (state%partings(1))
         state%partings(1) = leaving
      end if
   end subroutine part

   !> Whether the speed of an impact is nothing but rounding.
   pure logical function only_touches(run, state, reached)
      !> The run.
      type(run_type), intent(in) :: run
      !> The state at the start of the flight, and the impact.
      type(run_state_type), intent(in) :: state
      type(reached_type), intent(in) :: reached

      ! most speeds are far above what the rounding error of the distance amounts to
      associate (fastest => run%regimes(state%regime)%rows%fastest(reached%row))
         only_touches = .not. (fastest > 0 .and. reached%speed > fastest*reached%reserve)
      end associate
      if (only_touches) only_touches = has_no_speed()
   contains
      !> Whether it is rounding, from the terms of the speed.
      pure logical function has_no_speed()
         real(wp), parameter :: share = 8*epsilon(1.0_wp)
         real(wp), dimension(size(state%x)) :: x, v

         associate (regime => run%regimes(state%regime))
            x = state%x
            v = state%v
            call advance_in_place(regime%modes, reached%time, x, v)
            has_no_speed = reached%speed <= share*size_of_rate(regime, x, v, reached%row, &
               reached%time)
         end associate
      end function has_no_speed
   end function only_touches

   !> The gap at a wall of a row.
   pure integer function gap_of(regime, row, wall) result(gap)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> The row, and its upper (+1) or lower (-1) limit.
      integer, intent(in) :: row, wall

      gap = merge(regime%upper_gap(row), regime%lower_gap(row), wall > 0)
   end function gap_of

   !> Whether an impulse on one gap changes the speed of another.
   pure logical function are_coupled(structure, one, other)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Two gaps.
      integer, intent(in) :: one, other

      are_coupled = any(structure%coupled(structure%coupled_begins(one): &
         structure%coupled_begins(one + 1) - 1) == other)
   end function are_coupled

   !> Whether a gap that is coupled with the one that closes is closing at the same instant.
   pure logical function closes_another(run, phase, q, rate, gap)
      !> The run.
      type(run_type), intent(in) :: run
      !> The load phase (rad), and (n) coordinates and velocities just before the impact.
      real(wp), intent(in) :: phase, q(:), rate(:)
      !> The gap that closes.
      integer, intent(in) :: gap
      real(wp) :: speed, opening, size_now, wall(0:2)
      integer :: i, j, k

      closes_another = .false.
      associate (structure => run%structure)
         do i = structure%coupled_begins(gap), structure%coupled_begins(gap + 1) - 1
            j = structure%coupled(i)
            wall = opening_at(structure, j, phase, run%load%frequency)
            speed = -wall(1)
            opening = wall(0)
            size_now = abs(opening)
            do k = structure%begins(j), structure%begins(j + 1) - 1
               associate (at => structure%at(k), direction => structure%part(k))
                  speed = speed + direction*rate(at)
                  opening = opening - direction*q(at)
                  size_now = size_now + abs(direction*q(at))
               end associate
            end do
            closes_another = speed > 0 .and. opening <= 8*epsilon(1.0_wp)*size_now
            if (closes_another) return
         end do
      end associate
   end function closes_another

   !> The coordinates and velocities of which `closes_another` needs to know.
   pure subroutine coupled_coordinates(run, gap, state)
      !> The run.
      type(run_type), intent(in) :: run
      !> The gap that closes.
      integer, intent(in) :: gap
      !> In and out: the state; its other coordinates and velocities are not set.
      type(run_state_type), intent(inout) :: state
      integer :: before, i, j, k

      before = 0
      associate (structure => run%structure)
         do i = structure%coupled_begins(gap), structure%coupled_begins(gap + 1) - 1
            j = structure%coupled(i)
            ! the other limit of the same row has the same coordinates
            if (before > 0) then
               if (structure%channel(j) == before) cycle
            end if
            before = structure%channel(j)
            do k = structure%begins(j), structure%begins(j + 1) - 1
               associate (at => structure%at(k))
                  call coordinate_of(run%regimes(state%regime), at, run%load%frequency &
                     *state%elapsed, state%x, state%v, state%q(at), state%rate(at))
               end associate
            end do
         end do
      end associate
   end subroutine coupled_coordinates

   !> Completes an accumulation of impacts, if what remains of it is short enough.
   !!
   !! With departure speed u and a gap that closes with acceleration a > 0, the remaining impacts
   !! take T = 2u/(a (1 - R)), to first order; with R(v) T is 2/a times the sum of their departure
   !! speeds. They affect the structure only through u itself: the rest begins at once from the
   !! velocities without the part that closes the gap, with an error of order u^3.
   pure subroutine accumulate(run, state, remaining, event, stuck, status)
      !> In and out: the regime is added.
      type(run_type), intent(inout) :: run
      !> In: just after an impact with a departure speed. Out: at rest, if the accumulation is
      !! completed.
      type(run_state_type), intent(inout) :: state
      !> Time to the end.
      real(wp), intent(in) :: remaining
      !> The start of the rest.
      type(run_event_type), intent(inout) :: event
      !> Whether it is completed.
      logical, intent(out) :: stuck
      !> `stat%ok`, or as in `new_regime`.
      integer, intent(out) :: status
      type(reached_type) :: reached
      real(wp), allocatable :: q(:), rate(:)
      real(wp) :: d(0:3), closing, duration, longest, lost, opening(0:2), phase, time_error, unit
      type(pace_type) :: pace
      integer :: gap

      stuck = .false.
      status = stat%ok
      phase = run%load%frequency*state%elapsed
      longest = 1.0e-6_wp
      time_error = 1.0e-16_wp
      if (run%structure%has_friction) then
         ! where friction turns in a hop, its height is a difference of coordinates: the lowest hops
         ! would have the rounding errors of these
         gap = gap_of(run%regimes(state%regime), state%leaving%row, state%leaving%wall)
         if (size(rubs_with(run%structure, [gap])) > 0) then
            longest = 1.0e-5_wp
            time_error = 1.0e-10_wp
         end if
      end if
      associate (regime => run%regimes(state%regime), leaving => state%leaving)
         ! most departures are too fast, whatever the phase
         if (state%space%watch%kept) then
            if (2*leaving%speed > longest*regime%unit*most_second(state%space%watch, regime%rows, &
               leaving%row)) return
         end if
         if (2*leaving%speed > longest*regime%unit*bound_second(regime, state%x, state%v, &
            leaving%row)) return
         call row_derivatives(regime, state%x, state%v, phase, leaving%row, d)
         closing = leaving%wall*d(2)
         if (.not. closing > 0) return
         gap = gap_of(regime, leaving%row, leaving%wall)
         unit = regime%unit
         ! with a law R(v) no accumulation is completed unless R stays below 1 as v falls to 0
         lost = closing*(1 - greatest_below(run%structure%laws(gap), leaving%speed))
         if (.not. 2*leaving%speed <= longest*unit*lost) return
         duration = 2*leaving%speed/lost
         if (run%structure%has_friction) call hop_with_friction(run%structure, gap, leaving%speed, &
            closing, duration, status)
         if (status /= stat%ok .or. .not. closing > 0) return
         if (run%structure%has_friction .and. duration > longest*unit) return
         if (run%structure%laws(gap)%kind /= constant_law) then
            duration = 2*total_of_speeds(run%structure, gap, leaving%speed)/closing
         end if
         if (abs(d(3))*duration**2 > time_error*unit*closing) return
         if (duration > remaining) return
         allocate (q(size(regime%offset)), rate(size(regime%offset)))
         call state_of(regime, phase, state%x, state%v, q, rate)
      end associate
      ! no gap that rests is coupled with this one by mass, or its impact would have been refused
      associate (structure => run%structure)
         opening = opening_at(structure, gap, phase, run%load%frequency)
         rate = rate - structure%mobility(:, gap)*structure%effective(gap)* &
            (dot_product(structure%directions(:, gap), rate) - opening(1))
      end associate
      call enter(run, merged(run%regimes(state%regime)%closed, gap), phase, q, rate, state, status)
      if (status /= stat%ok) return
      state%leaving = leaving_type()
      stuck = .true.
      state%unsettled = .true.
      pace = state%pace
      call first_event(run%regimes(state%regime), state%x, state%v, phase, state%leaving, &
         duration, pace, reached, state%space, partings=state%partings)
      if (reached%row == 0) then
         call leave_instant(state)
         call move(run, state, duration)
      end if
      call state_now(run, state, q, rate)
      call note(state, stick_event, gap, 0.0_wp, 0.0_wp, q, rate, event)
   end subroutine accumulate

   !> An accumulation of impacts on a gap along which friction acts.
   !!
   !! With closing accelerations a on the way up and b = a - 2h/m on the way down, each departure
   !! speed is R sqrt(b/a) times the one before it.
   pure subroutine hop_with_friction(structure, gap, speed, closing, duration, status)
      !> The structure, and the gap.
      type(structure_type), intent(in) :: structure
      integer, intent(in) :: gap
      !> Departure speed.
      real(wp), intent(in) :: speed
      !> In: a. Out: b; not above 0 if friction ends a hop before it comes down.
      real(wp), intent(inout) :: closing
      !> In: the time to the end without friction. Out: with it.
      real(wp), intent(inout) :: duration
      !> `stat%ok`, or `stat%friction_rests` where friction is not along the gap, has a speed, or
      !! acts along a gap whose wall moves, or R is a law.
      integer, intent(out) :: status
      integer, allocatable :: rubbing(:)
      real(wp) :: down, ratio, weakest
      integer :: i

      status = stat%ok
      allocate (rubbing, source=rubs_with(structure, [gap]))
      if (size(rubbing) == 0) return
      down = closing
      weakest = closing
      do i = 1, size(rubbing)
         associate (factor => abs(factor_along(structure, rubbing(i), gap)), &
            law => structure%laws(rubbing(i))%numbers)
            if (.not. factor > 0) status = stat%friction_rests
            down = down - 2*law(1)*factor/structure%effective(gap)
            weakest = weakest - (law(1) + law(2))*factor/structure%effective(gap)
         end associate
      end do
      if (structure%laws(gap)%kind /= constant_law) status = stat%friction_rests
      if (status /= stat%ok) return
      if (weakest > 0) then
         ratio = structure%restitution(gap)*sqrt(down/closing)
         duration = speed*(1/closing + 1/sqrt(closing*down))/(1 - ratio)
         closing = down
      else
         closing = 0
      end if
   end subroutine hop_with_friction

   !> The sum of the departure speeds of an accumulation, each R(v) times the one before it.
   pure real(wp) function total_of_speeds(structure, gap, first) result(total)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The gap.
      integer, intent(in) :: gap
      !> The first departure speed.
      real(wp), intent(in) :: first
      integer, parameter :: most = 10000
      real(wp) :: speed, restitution, slope
      integer :: i

      total = 0
      speed = first
      do i = 1, most
         total = total + speed
         call restitution_of(structure, gap, speed, restitution, slope)
         speed = restitution*speed
         if (.not. speed > epsilon(1.0_wp)*total) return
      end do
      ! what remains is a geometric series, whose R hardly changes any more
      call restitution_of(structure, gap, speed, restitution, slope)
      total = total + speed/(1 - restitution)
   end function total_of_speeds

   !> What is closed, in ascending order, after a stop or friction changes.
   pure function replaced(set, number, to) result(changed)
      !> What was closed, and the number of the stop or the friction.
      integer, intent(in) :: set(:), number
      !> How it is in the set now: as itself, as -number, or not at all (0).
      integer, intent(in) :: to
      integer :: changed(count(abs(set) /= number) + merge(1, 0, to /= 0))
      integer :: i, n
      logical :: waits

      n = 0
      waits = to /= 0
      do i = 1, size(set)
         if (abs(set(i)) == number) cycle
         if (waits .and. set(i) > to) then
            n = n + 1
            changed(n) = to
            waits = .false.
         end if
         n = n + 1
         changed(n) = set(i)
      end do
      if (waits) changed(n + 1) = to
   end function replaced

   !> A set with one more member.
   pure function merged(set, one) result(larger)
      !> In ascending order, and a number that is not in it.
      integer, intent(in) :: set(:), one
      integer :: larger(size(set) + 1)

      larger = [pack(set, set < one), one, pack(set, set > one)]
   end function merged

   !> Advances to the time at which a contact force falls to 0, if it only touches 0.
   pure subroutine touch_zero(run, state, reached, touches)
      !> In and out: the run, with the forces of a record.
      type(run_type), intent(inout) :: run
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> The limit that is reached.
      type(reached_type), intent(in) :: reached
      !> Whether it only touches; otherwise the state is not changed.
      logical, intent(out) :: touches
      real(wp), dimension(size(state%x)) :: x, v
      integer :: order, sense

      associate (regime => run%regimes(state%regime), elapsed => state%elapsed + reached%time)
         x = state%x
         v = state%v
         call advance_in_place(regime%modes, reached%time, x, v)
         if (run%load%step > 0) call set_forces(regime, run%load, state%cycle, elapsed)
         call leading_term(regime, x, v, run%load%frequency*elapsed, reached%row, 1, order, sense)
         if (run%load%step > 0) call set_forces(regime, run%load, state%cycle, state%elapsed)
         touches = sense >= 0 .and. elapsed > state%elapsed
      end associate
      if (.not. touches) return
      call move(run, state, reached%time)
      call leave_instant(state)
      state%unsettled = .true.
   end subroutine touch_zero

   !> Advances to a release and through it.
   pure subroutine release(run, state, reached, event, status)
      !> In and out: the regime is added.
      type(run_type), intent(inout) :: run
      !> In: at rest. Out: just released.
      type(run_state_type), intent(inout) :: state
      !> The limit that is reached.
      type(reached_type), intent(in) :: reached
      !> The release.
      type(run_event_type), intent(inout) :: event
      !> `stat%ok`, or as in `new_regime`.
      integer, intent(out) :: status
      real(wp) :: q(size(run%structure%mass, 1)), rate(size(run%structure%mass, 1)), phase
      integer :: gap, i

      if (.not. at_once(run, reached%time)) call leave_instant(state)
      call move(run, state, reached%time)
      phase = run%load%frequency*state%elapsed
      gap = -run%regimes(state%regime)%lower_gap(reached%row)
      call state_of(run%regimes(state%regime), phase, state%x, state%v, q, rate)
      ! its force is 0, and so is the acceleration of its opening, unless the record ends here
      state%released = merge(gap, 0, state%elapsed > 0 .or. .not. run%load%step > 0)
      if (run%structure%has_friction) then
         ! a force that falls from the stick to the slip level makes it jump
         do i = 1, size(run%structure%openings)
            if (.not. abs(factor_along(run%structure, i, gap)) > 0) cycle
            associate (numbers => run%structure%laws(i)%numbers)
               if (numbers(2) > numbers(1)) state%released = 0
            end associate
         end do
      end if
      call change_contact(run, release_event, gap, phase, q, rate, state, event, status)
   end subroutine release

   !> Records an event.
   pure subroutine note(state, kind, gap, speed, impulse, q, rate, event, bare)
      !> The state just after it.
      type(run_state_type), intent(in) :: state
      !> Kind and gap.
      integer, intent(in) :: kind, gap
      !> Approach speed and impulse.
      real(wp), intent(in) :: speed, impulse
      !> (n) Coordinates and velocities.
      real(wp), intent(in) :: q(:), rate(:)
      !> The record.
      type(run_event_type), intent(inout) :: event
      !> Whether coordinates and velocities are left out; by default they are not.
      logical, intent(in), optional :: bare
      logical :: whole

      whole = .true.
      if (present(bare)) whole = .not. bare
      event%kind = kind
      event%together = .false.
      event%gap = gap
      event%regime = state%regime
      event%cycle = state%cycle
      event%elapsed = state%elapsed
      event%speed = speed
      event%impulse = impulse
      call keep(size(state%x), state%x, event%x)
      call keep(size(state%v), state%v, event%v)
      if (.not. whole) return
      call keep(size(q), q, event%q)
      call keep(size(rate), rate, event%rate)
   end subroutine note

   !> Copies numbers as one piece of memory.
   pure subroutine keep(n, from, to)
      !> How many.
      integer, intent(in) :: n
      !> The numbers.
      real(wp), intent(in) :: from(n)
      !> In and out: allocated again only if their number changes.
      real(wp), allocatable, intent(inout) :: to(:)

      if (allocated(to)) then
         if (size(to) /= n) deallocate (to)
      end if
      if (.not. allocated(to)) allocate (to(n))
      to(:) = from
   end subroutine keep

   !> Coordinates and velocities of a state.
   pure subroutine state_now(run, state, q, rate)
      !> The run.
      type(run_type), intent(in) :: run
      !> The state.
      type(run_state_type), intent(in) :: state
      !> (n)
      real(wp), contiguous, intent(out) :: q(:), rate(:)

      call state_of(run%regimes(state%regime), run%load%frequency*state%elapsed, state%x, state%v, &
         q, rate)
   end subroutine state_now

   !> Whether an event is one of those that a motion lists: all but the start and the end of a rest.
   elemental logical function is_listed(event)
      !> The event.
      type(run_event_type), intent(in) :: event

      is_listed = event%kind /= stick_event .and. event%kind /= release_event
   end function is_listed

   !> Time of an event.
   pure real(wp) function time_of(run, event) result(time)
      !> The run.
      type(run_type), intent(in) :: run
      !> The event.
      type(run_event_type), intent(in) :: event

      time = real(event%cycle, wp)*run%period + event%elapsed
   end function time_of

end module vi_structure_run
