!> The derivative of a simulated motion of a structure with respect to its initial state, event by
!! event in closed form: through impacts, rests and releases, and by saltation matrices through
!! contacts with stops and changes of friction. Where a row h of the regime before an event falls to
!! its limit,
!!
!!     S = I + (f+ - f-) grad h^T/h',   h' = grad h.f- + dh/dt
!!
!! with the rates f- and f+ of (q, q') before and after. h' is the rate of h along the motion, with
!! that of the load in a force that holds or pushes. Where friction halts, S takes the direction in
!! which it would slip to 0.
module vi_structure_variation
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_channels, only: row_derivatives, size_of_rate
   use vi_columns, only: solve_columns
   use vi_kinds, only: wp
   use vi_modes, only: advance
   use vi_status, only: stat
   use vi_structure, only: factor_along, linked_elements, opening_at, regime_type, &
      restitution_of, structure_type
   use vi_structure_map, only: accelerations, apply_flight, apply_impact, from_coordinates, &
      to_coordinates
   use vi_structure_motion, only: impulse_of
   use vi_structure_run, only: halt_event, impact_event, leave_event, let_go_event, pass_label, &
      press_event, release_event, run_event_type, run_state_type, run_type, stick_event, &
      time_of_motion, touch_event
   implicit none (type, external)
   private

   public :: add_change, derivative_of_run, limit_of, project, start_tangent, through_event, &
      to_state

   !> Changes of elements at one instant, each at a limit of its own.
   type, public :: changes_type
      !> (2, k) The elements, and how they change.
      integer, allocatable :: elements(:, :)
      !> (columns, k) The changes of the time of each.
      real(wp), allocatable :: later(:, :)
   end type changes_type

   !> Changes of the state, carried along a simulation from event to event.
   type, public :: tangent_type
      !> The regime, and the time as whole periods and the remainder.
      integer :: number = 1
      integer(int64) :: cycle = 0
      real(wp) :: elapsed = 0
      !> (m) The pairs there; (2m, columns) changes of x, then of v.
      real(wp), allocatable :: x(:), v(:), d(:, :)
      !> (columns) Changes of the time of the last event; 0 after an accumulation.
      real(wp), allocatable :: later(:)
      !> Factor of volumes of states since the beginning; 0 once a rest or friction that sticks has
      !! taken a direction away.
      real(wp) :: volume = 1
      !> That of the last event alone.
      real(wp) :: jump = 1
      !> Those of elements at the instant of the last event.
      type(changes_type) :: changed
      !> Whether the derivative is that of one order of changes at one instant.
      logical :: ordered = .false.
      !> The largest sum of the terms of a rate over the rate itself, of functions of which the zero
      !! was an event at which accelerations jump.
      real(wp) :: sharpest = 1
   end type tangent_type

   !> How an element changes: accelerations do not jump; they jump so that changes of several
   !! elements at one instant add up in any order, as where stops are touched or friction halts; or
   !! they jump so that the order matters if forces on one element act on another one by the masses,
   !! or, where friction that stuck slips and at impacts, by dashpots.
   integer, parameter, public :: smooth_change = 0, additive_change = 1, ordered_change = 2, &
      breakaway = 3
   !> Share of the time in which a motion changes by which events at one instant may differ.
   real(wp), parameter, public :: instant = 1.0e-10_wp

contains

   !> The derivative of the final state with respect to the initial one.
   pure subroutine derivative_of_run(run, first, events, last, p, largest, law, status)
      !> The structure, its load and its regimes.
      type(run_type), intent(in) :: run
      !> The state at the beginning.
      type(run_state_type), intent(in) :: first
      !> All events from there.
      type(run_event_type), intent(in) :: events(:)
      !> The state at the end.
      type(run_state_type), intent(in) :: last
      !> (2n, 2n) Derivatives of (q, q') by (q, q').
      real(wp), intent(out) :: p(:, :)
      !> The factor of rounding errors: the largest approach speed over the least one of impacts
      !! outside accumulations, or that of other events; 1 if there are none.
      real(wp), intent(out) :: largest
      !> What det p must be.
      real(wp), intent(out) :: law
      !> `stat%ok`, `stat%zero_approach`, or `stat%no_derivative`: at impacts on coupled gaps at one
      !! instant, or where the derivative is that of one order of changes at one instant.
      integer, intent(out) :: status
      !> Share of velocities that counts as rounding.
      real(wp), parameter :: rounding = 1.0e-12_wp
      type(tangent_type) :: tangent
      integer :: i

      p = 0
      do i = 1, size(p, 1)
         p(i, i) = 1
      end do
      status = stat%ok
      largest = 1
      law = 0
      call start_tangent(run, first, p, tangent)
      do i = 1, size(events)
         call through_event(run, events(i), tangent, status)
         ! presumed events can meet a wall from behind, where the derivative continues smoothly
         if (status == stat%zero_approach .and. events(i)%speed < -rounding*maxval(abs(events(i)% &
            rate))) status = stat%ok
         if (status /= stat%ok) return
      end do
      if (tangent%ordered) status = stat%no_derivative
      call to_state(run, last, tangent)
      call to_coordinates(run%regimes(tangent%number), tangent%d, p)
      largest = max(spread_of_speeds(events), tangent%sharpest)
      law = tangent%volume
   end subroutine derivative_of_run

   !> Begins to carry changes of a state.
   pure subroutine start_tangent(run, first, p, tangent)
      !> The structure, its load and its regimes.
      type(run_type), intent(in) :: run
      !> The state.
      type(run_state_type), intent(in) :: first
      !> (2n, columns) Changes of q, then of q'.
      real(wp), intent(in) :: p(:, :)
      !> The changes there.
      type(tangent_type), intent(out) :: tangent
      real(wp) :: held(size(p, 1), size(p, 2))
      integer :: n

      tangent%number = first%regime
      associate (regime => run%regimes(first%regime))
         if (size(regime%held) > size(regime%resting)) then
            ! friction that sticks keeps its speed
            tangent%volume = 0
            n = size(p, 1)/2
            held = p
            call project(run%structure, regime%held, held(n + 1:, :))
            allocate (tangent%d(2*size(first%x), size(p, 2)))
            allocate (tangent%later(size(p, 2)), source=0.0_wp)
            call from_coordinates(regime, held, tangent%d)
            call set_place(first%cycle, first%elapsed, first%x, first%v, tangent)
            return
         end if
      end associate
      allocate (tangent%d(2*size(first%x), size(p, 2)))
      allocate (tangent%later(size(p, 2)), source=0.0_wp)
      call from_coordinates(run%regimes(first%regime), p, tangent%d)
      call set_place(first%cycle, first%elapsed, first%x, first%v, tangent)
   end subroutine start_tangent

   !> Time and pairs of a tangent.
   pure subroutine set_place(cycle, elapsed, x, v, tangent)
      !> Whole periods, and the remainder.
      integer(int64), intent(in) :: cycle
      !> As in `cycle`.
      real(wp), intent(in) :: elapsed
      !> (m) The pairs.
      real(wp), intent(in) :: x(:), v(:)
      !> In and out: the tangent.
      type(tangent_type), intent(inout) :: tangent

      tangent%cycle = cycle
      tangent%elapsed = elapsed
      tangent%x = x
      tangent%v = v
   end subroutine set_place

   !> Carries changes to the next event and through it.
   !!
   !! A gap is released where its force falls to 0, so that accelerations do not jump, or where an
   !! impact at the same instant makes it pull: then they jump at the time of that impact.
   pure subroutine through_event(run, event, tangent, status)
      !> The structure, its load and its regimes.
      type(run_type), intent(in) :: run
      !> The event.
      type(run_event_type), intent(in) :: event
      !> In: the changes before it. Out: those just after it.
      type(tangent_type), intent(inout) :: tangent
      !> `stat%ok`, `stat%zero_approach`, or `stat%no_derivative` at impacts on coupled gaps at one
      !! instant.
      integer, intent(out) :: status
      real(wp), allocatable :: p(:, :), x_before(:), v_before(:)
      real(wp), dimension(size(run%structure%mass, 1)) :: before, after
      real(wp) :: time
      integer :: j, n

      status = stat%ok
      tangent%jump = 1
      n = size(before)
      time = max(0.0_wp, real(event%cycle - tangent%cycle, wp)*run%period + (event%elapsed - &
         tangent%elapsed))
      if (allocated(tangent%changed%elements)) then
         if (time > instant*time_of_motion(run)) deallocate (tangent%changed%elements, &
            tangent%changed%later)
      end if
      if (event%together) then
         status = stat%no_derivative
         allocate (p(2*n, size(tangent%d, 2)))
         call apply_flight(run%regimes(tangent%number), time, tangent%d)
         call to_coordinates(run%regimes(tangent%number), tangent%d, p)
         deallocate (tangent%d)
         allocate (tangent%d(2*size(event%x), size(p, 2)))
         call from_coordinates(run%regimes(event%regime), p, tangent%d)
         tangent%number = event%regime
         call set_place(event%cycle, event%elapsed, event%x, event%v, tangent)
         return
      end if
      if (is_change(run, event, tangent%number)) then
         call through_change(run, event, time, tangent, status)
         return
      end if
      associate (regime => run%regimes(tangent%number), next => run%regimes(event%regime))
         tangent%volume = tangent%volume*exp(-2*sum(regime%modes%damping)*time)
         if (event%kind == impact_event) then
            tangent%jump = volume_of_impact(run%structure, event)
            tangent%volume = tangent%volume*tangent%jump
            allocate (x_before, source=tangent%x)
            allocate (v_before, source=tangent%v)
            call advance(regime%modes, time, tangent%x, tangent%v, x_before, v_before)
            call apply_flight(regime, time, tangent%d)
            if (abs(event%speed) > 0) tangent%later = -closing_of(regime, &
               run%structure%directions(:, event%gap), tangent%d)/event%speed
            call apply_impact(run%structure, regime, event%gap, run%load%frequency*event%elapsed, &
               event%speed, x_before, v_before, event%x, event%v, tangent%d, status)
            call note_impact(run%structure, regime, event%gap, tangent)
         else
            allocate (p(2*n, size(tangent%d, 2)))
            if (event%kind == release_event) call apply_flight(regime, time, tangent%d)
            call to_coordinates(regime, tangent%d, p)
            if (event%kind == release_event .and. .not. time > 0) then
               associate (phase => run%load%frequency*event%elapsed)
                  call accelerations(regime, phase, tangent%x, tangent%v, before)
                  call accelerations(next, phase, event%x, event%v, after)
               end associate
               do j = 1, size(p, 2)
                  p(n + 1:, j) = p(n + 1:, j) - (after - before)*tangent%later(j)
               end do
            else if (event%kind == release_event .or. time > 0) then
               ! what a rest right after an impact with R = 0 makes slip moves with that impact
               tangent%later = 0
            end if
            ! the accumulation is completed at its last impact, and the rest begins there
            if (event%kind == stick_event) then
               call apply_rest(run%structure, next, event%gap, p)
               tangent%jump = 0
               tangent%volume = 0
            end if
            deallocate (tangent%d)
            allocate (tangent%d(2*size(event%x), size(p, 2)))
            call from_coordinates(next, p, tangent%d)
            if (event%kind == stick_event) call apply_flight(next, time, tangent%d)
         end if
      end associate
      ! the place is set where an impact without approach speed has no derivative, too
      tangent%number = event%regime
      call set_place(event%cycle, event%elapsed, event%x, event%v, tangent)
   end subroutine through_event

   !> Whether an event is one of a stop or of friction, or changes the sense of friction or the
   !! accelerations by it.
   pure logical function is_change(run, event, number)
      !> The structure, its load and its regimes.
      type(run_type), intent(in) :: run
      !> The event.
      type(run_event_type), intent(in) :: event
      !> The number of the regime before it.
      integer, intent(in) :: number
      integer :: j

      select case (event%kind)
      case (stick_event)
         is_change = .false.
      case (impact_event)
         is_change = event%regime /= number
      case (release_event)
         is_change = run%structure%has_friction
         if (is_change) is_change = any([(abs(factor_along(run%structure, j, event%gap)) > 0, j=1, &
            size(run%structure%openings))])
      case default
         is_change = .true.
      end select
   end function is_change

   !> The factor of volumes at an impact, R (R + R' v).
   pure real(wp) function volume_of_impact(structure, event) result(factor)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The impact.
      type(run_event_type), intent(in) :: event
      real(wp) :: restitution, slope

      call restitution_of(structure, event%gap, event%speed, restitution, slope)
      factor = restitution*(restitution + slope*event%speed)
   end function volume_of_impact

   !> Carries changes to the next event and into the regime after it, by the saltation matrix.
   pure subroutine through_change(run, event, time, tangent, status)
      !> The structure, its load and its regimes.
      type(run_type), intent(in) :: run
      !> The event.
      type(run_event_type), intent(in) :: event
      !> Time from the place of the tangent to it.
      real(wp), intent(in) :: time
      !> In: the changes before it. Out: those just after it.
      type(tangent_type), intent(inout) :: tangent
      !> `stat%ok`, or `stat%zero_approach` where a function that falls to its limit has no rate
      !! there and accelerations jump.
      integer, intent(out) :: status
      !> Share of accelerations, and of the terms of a rate, that counts as rounding.
      real(wp), parameter :: rounding = 1.0e-12_wp
      real(wp), dimension(size(run%structure%mass, 1)) :: before, after, jump
      real(wp), allocatable :: p(:, :), x(:), v(:), closing(:)
      real(wp) :: d(0:3), rate, scale, impulse, slope, opening(0:2)
      integer :: j, m, n, row

      status = stat%ok
      ! a further change at one instant is reported after it is made
      if (event%regime == tangent%number .and. .not. time > 0) return
      n = size(before)
      associate (regime => run%regimes(tangent%number), next => run%regimes(event%regime), &
         phase => run%load%frequency*event%elapsed)
         m = size(regime%modes%stiffness)
         allocate (x(m), v(m), p(2*n, size(tangent%d, 2)), closing(size(tangent%d, 2)))
         call advance(regime%modes, time, tangent%x, tangent%v, x, v)
         call apply_flight(regime, time, tangent%d)
         tangent%volume = tangent%volume*exp(-2*sum(regime%modes%damping)*time)
         call to_coordinates(regime, tangent%d, p)
         call accelerations(regime, phase, x, v, before)
         call accelerations(next, phase, event%x, event%v, after)
         jump = after - before
         if (event%kind == impact_event) then
            associate (direction => run%structure%directions(:, event%gap), &
               mobility => run%structure%mobility(:, event%gap))
               if (.not. event%speed > 0) status = stat%zero_approach
               if (abs(event%speed) > 0) then
                  call impulse_of(run%structure, event%gap, event%speed, impulse, slope)
                  closing = matmul(direction, p(:n, :))
                  tangent%later = -closing/event%speed
                  opening = opening_at(run%structure, event%gap, phase, run%load%frequency)
                  jump = jump + slope*mobility*(dot_product(direction, before) - opening(2))
                  do j = 1, size(p, 2)
                     p(n + 1:, j) = p(n + 1:, j) - jump*tangent%later(j) &
                        - slope*mobility*dot_product(direction, p(n + 1:, j))
                     p(:n, j) = p(:n, j) + impulse*tangent%later(j)*mobility
                  end do
                  tangent%jump = volume_of_impact(run%structure, event)
               end if
            end associate
            call note_impact(run%structure, regime, event%gap, tangent)
         else
            call find_row(run, regime, event, phase, x, v, row)
            ! an impact at this instant, and not its own zero, makes a stop let go or press
            if (.not. time > 0 .and. any(event%kind == [let_go_event, press_event])) row = 0
            ! and a force that jumped at this instant, as where a stop is touched, ends a rest
            if (.not. time > 0 .and. event%kind == release_event) then
               if (.not. is_zero(regime, phase, x, v, row)) row = 0
            end if
            scale = maxval(abs(after)) + maxval(abs(before))
            if (row > 0) then
               call row_derivatives(regime, x, v, phase, row, d)
               rate = d(1)
               associate (size_now => size_of_rate(regime, x, v, row, 0.0_wp))
                  if (abs(rate) > rounding*size_now) then
                     closing = matmul(regime%position(row, :), tangent%d(:m, :)) &
                        + matmul(regime%velocity(row, :), tangent%d(m + 1:, :))
                     tangent%later = -closing/rate
                     if (any(abs(jump) > rounding*scale)) tangent%sharpest = &
                        max(tangent%sharpest, size_now/abs(rate))
                     if (row <= run%structure%channels) then
                        call row_derivatives(next, event%x, event%v, phase, row, d)
                        tangent%jump = d(1)/rate
                     end if
                  else
                     if (any(abs(jump) > rounding*scale)) status = stat%zero_approach
                     tangent%later = 0
                  end if
               end associate
            end if
            if (event%kind == halt_event) tangent%jump = 0
            do j = 1, size(p, 2)
               p(n + 1:, j) = p(n + 1:, j) - jump*tangent%later(j)
            end do
            if (row > 0) call note_change(run, event, phase, x, v, any(abs(jump) > &
               rounding*scale), tangent)
         end if
         tangent%volume = tangent%volume*tangent%jump
         if (size(next%held) > 0) call project(run%structure, next%held, p(n + 1:, :))
         deallocate (tangent%d)
         allocate (tangent%d(2*size(event%x), size(p, 2)))
         call from_coordinates(next, p, tangent%d)
      end associate
      tangent%number = event%regime
      call set_place(event%cycle, event%elapsed, event%x, event%v, tangent)
   end subroutine through_change

   !> Notes a change at a limit of its own, and whether its order among others at this instant
   !! matters: of changes that act on each other only those commute that are all smooth or all
   !! additive.
   pure subroutine note_change(run, event, phase, x, v, jumps, tangent)
      !> The structure, its load and its regimes.
      type(run_type), intent(in) :: run
      !> The event.
      type(run_event_type), intent(in) :: event
      !> Load phase (rad), and (m) the pairs just before it.
      real(wp), intent(in) :: phase, x(:), v(:)
      !> Whether accelerations jump.
      logical, intent(in) :: jumps
      !> In and out: the changes, with the number of the regime before the event.
      type(tangent_type), intent(inout) :: tangent
      integer, allocatable :: closed(:)
      integer :: change, k
      logical :: commute, sticks

      associate (regime => run%regimes(tangent%number), next => run%regimes(event%regime), &
         numbers => run%structure%laws(event%gap)%numbers)
         sticks = any(regime%held == event%gap) .and. event%kind > halt_event
         change = smooth_change
         if (jumps .and. .not. (sticks .and. numbers(2) <= numbers(1))) then
            change = merge(breakaway, ordered_change, sticks)
            closed = regime%closed
            call pass_label([event%kind, event%gap], closed)
            if (event%kind <= halt_event .and. size(closed) == size(next%closed)) then
               if (all(closed == next%closed)) change = additive_change
            end if
         end if
         call add_change(run%structure, regime%closed, event%kind, event%gap, change, &
            tangent%later, tangent%changed, commute)
         if (change >= ordered_change) then
            ! what slips by this jump, but is at a limit of its own, too
            do k = 1, size(regime%held)
               if (any(next%held == regime%held(k)) .or. regime%held(k) == event%gap) cycle
               if (is_zero(regime, phase, x, v, run%structure%channels + k)) commute = .false.
            end do
         end if
      end associate
      if (.not. commute) tangent%ordered = .true.
   end subroutine note_change

   !> As `note_change`, of an impact: the impulse changes the velocities that dashpots see.
   pure subroutine note_impact(structure, regime, gap, tangent)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The regime before it.
      type(regime_type), intent(in) :: regime
      !> The gap.
      integer, intent(in) :: gap
      !> In and out: the changes.
      type(tangent_type), intent(inout) :: tangent
      logical :: commute

      if (allocated(tangent%changed%elements)) then
         ! the impacts of an accumulation
         if (any(tangent%changed%elements(1, :) == gap)) return
      end if
      call add_change(structure, regime%closed, impact_event, gap, breakaway, tangent%later, &
         tangent%changed, commute)
      if (.not. commute) tangent%ordered = .true.
   end subroutine note_impact

   !> Adds a change at a limit of its own to those at the same instant.
   pure subroutine add_change(structure, closed, kind, number, change, later, changed, commute)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> What is closed before it, as in `regime_type`.
      integer, intent(in) :: closed(:)
      !> Kind and element of the event, and how the element changes.
      integer, intent(in) :: kind, number, change
      !> (columns) Changes of its time.
      real(wp), intent(in) :: later(:)
      !> In and out: those at this instant.
      type(changes_type), intent(inout) :: changed
      !> Whether the order of these changes does not matter.
      logical, intent(out) :: commute
      integer, allocatable :: between(:), linked(:), through_dashpots(:)
      integer :: k

      commute = .true.
      ! a distance, or the force of a stop that is 0, does not depend on what jumps elsewhere
      if (change == smooth_change .and. kind /= release_event .and. kind <= halt_event) return
      if (.not. allocated(changed%elements)) allocate (changed%elements(2, 0), &
         changed%later(size(later), 0))
      associate (elements => changed%elements(1, :), how => changed%elements(2, :))
         if (size(elements) > 0) then
            between = pack(closed, closed > 0)
            through_dashpots = linked_elements(structure, number, [between, elements], .true.)
            linked = linked_elements(structure, number, [pack(between, .not. &
               structure%elastic(between)), elements])
         end if
         do k = 1, size(elements)
            if (elements(k) == number .or. is_same(changed%later(:, k), later)) cycle
            if (any(linked == elements(k))) then
               commute = commute .and. change < ordered_change .and. how(k) == change
            else if (any(through_dashpots == elements(k))) then
               commute = commute .and. (max(change, how(k)) < breakaway .or. min(change, how(k)) &
                  == smooth_change)
            end if
         end do
      end associate
      changed%elements = reshape([changed%elements, number, change], [2, size(changed%elements, 2) &
         + 1])
      changed%later = reshape([changed%later, later], [size(later), size(changed%elements, 2)])
   end subroutine add_change

   !> Whether two changes are at one instant of all nearby motions, too, as where one direction is
   !! left in which two elements with friction slide.
   pure logical function is_same(later, other) result(same)
      !> (columns) Changes of their times.
      real(wp), intent(in) :: later(:), other(:)
      !> Relative difference that counts as rounding.
      real(wp), parameter :: rounding = 1.0e-8_wp

      same = all(abs(later - other) <= rounding*max(abs(later), abs(other), rounding*maxval( &
         [0.0_wp, abs(later)])))
   end function is_same

   !> The row of a regime that falls to its limit at an event; 0 if it is not there, as where a
   !! force that jumps at the same instant is more than what holds.
   pure subroutine find_row(run, regime, event, phase, x, v, row)
      !> The structure, its load and its regimes.
      type(run_type), intent(in) :: run
      !> The regime before the event.
      type(regime_type), intent(in) :: regime
      !> The event.
      type(run_event_type), intent(in) :: event
      !> Load phase (rad), and (m) the pairs just before it.
      real(wp), intent(in) :: phase, x(:), v(:)
      !> The row.
      integer, intent(out) :: row
      !> Share of a stick level by which a force at it may differ from it.
      real(wp), parameter :: near = 1.0e-9_wp
      real(wp) :: d(0:3)

      associate (structure => run%structure, number => event%gap)
         select case (event%kind)
         case (touch_event, leave_event)
            row = structure%channel(number)
         case (let_go_event, press_event)
            row = structure%push(number)
         case (release_event)
            row = structure%channels + findloc(regime%resting, number, dim=1)
         case default
            row = structure%channel(number)
            if (all(regime%held /= number)) return
            row = structure%channels + findloc(regime%held, number, dim=1)
            call row_derivatives(regime, x, v, phase, row, d)
            if (abs(abs(d(0)) - regime%upper(row)) > near*regime%upper(row)) row = 0
         end select
      end associate
   end subroutine find_row

   !> Whether the force at a gap at rest is at the limit of the rest, by the size of its terms.
   pure logical function is_zero(regime, phase, x, v, row)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> Load phase (rad), and (m) the pairs.
      real(wp), intent(in) :: phase, x(:), v(:)
      !> The row of the force.
      integer, intent(in) :: row
      !> Share of the terms that counts as rounding.
      real(wp), parameter :: near = 1.0e-9_wp
      real(wp) :: d(0:3), terms

      call row_derivatives(regime, x, v, phase, row, d)
      terms = abs(regime%rows%offset(row)) + sum(regime%rows%ripple_size(row, :)) &
         + dot_product(abs(regime%position(row, :)), abs(x)) &
         + dot_product(abs(regime%velocity(row, :)), abs(v))
      is_zero = min(abs(d(0) - regime%upper(row)), abs(d(0) - regime%lower(row))) <= near*terms
   end function is_zero

   !> The row of the regime before an event that is at its limit there, and +1 or -1 for its upper
   !! or lower one; 0 if none is.
   pure subroutine limit_of(run, event, tangent, limit)
      !> The structure, its load and its regimes.
      type(run_type), intent(in) :: run
      !> The event.
      type(run_event_type), intent(in) :: event
      !> The place before it.
      type(tangent_type), intent(in) :: tangent
      !> The row and the limit.
      integer, intent(out) :: limit(2)
      real(wp), dimension(size(tangent%x)) :: x, v
      real(wp) :: d(0:3), phase

      limit = 0
      associate (regime => run%regimes(tangent%number))
         call advance(regime%modes, max(0.0_wp, real(event%cycle - tangent%cycle, wp)*run%period &
            + (event%elapsed - tangent%elapsed)), tangent%x, tangent%v, x, v)
         phase = run%load%frequency*event%elapsed
         if (event%kind == impact_event) then
            limit = [run%structure%channel(event%gap), run%structure%wall(event%gap)]
            return
         end if
         call find_row(run, regime, event, phase, x, v, limit(1))
         if (limit(1) == 0) return
         call row_derivatives(regime, x, v, phase, limit(1), d)
         limit(2) = merge(1, -1, abs(regime%upper(limit(1)) - d(0)) < abs(d(0) &
            - regime%lower(limit(1))))
      end associate
   end subroutine limit_of

   !> How much a gap closes by changes of the pairs.
   pure function closing_of(regime, direction, d) result(closing)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (n) The direction of the gap.
      real(wp), intent(in) :: direction(:)
      !> (2m, columns) Changes of x, then of v.
      real(wp), intent(in) :: d(:, :)
      real(wp) :: closing(size(d, 2))
      integer :: m

      m = size(d, 1)/2
      closing = matmul(matmul(direction, regime%qx), d(:m, :)) + matmul(matmul(direction, &
         regime%qv), d(m + 1:, :))
   end function closing_of

   !> Carries changes to a later state of the same flight or rest.
   pure subroutine to_state(run, last, tangent)
      !> The structure, its load and its regimes.
      type(run_type), intent(in) :: run
      !> The state.
      type(run_state_type), intent(in) :: last
      !> In and out: the changes.
      type(tangent_type), intent(inout) :: tangent
      real(wp) :: time

      time = max(0.0_wp, real(last%cycle - tangent%cycle, wp)*run%period + (last%elapsed &
         - tangent%elapsed))
      associate (regime => run%regimes(tangent%number))
         call apply_flight(regime, time, tangent%d)
         tangent%volume = tangent%volume*exp(-2*sum(regime%modes%damping)*time)
      end associate
      call set_place(last%cycle, last%elapsed, last%x, last%v, tangent)
   end subroutine to_state

   !> The largest approach speed over the least one, without impacts that an accumulation follows.
   pure real(wp) function spread_of_speeds(events) result(spread)
      !> The events.
      type(run_event_type), intent(in) :: events(:)
      real(wp) :: least, largest
      integer :: i, j

      least = huge(1.0_wp)
      largest = 0
      do i = 1, size(events)
         if (events(i)%kind /= impact_event) cycle
         largest = max(largest, events(i)%speed)
         ! the next event of the same gap other than an impact is the end of its accumulation
         do j = i + 1, size(events)
            if (events(j)%gap == events(i)%gap .and. events(j)%kind /= impact_event) exit
         end do
         if (j > size(events)) least = min(least, events(i)%speed)
      end do
      spread = 1
      if (least < largest) spread = largest/least
   end function spread_of_speeds

   !> Multiplies a derivative by that of the end of an accumulation: with the projection Pi onto
   !! velocities that keep the gaps closed,
   !!
   !!     Q = [ Pi, 0 ; Pi M^-1 C M^-1 G m G^T, Pi ]
   pure subroutine apply_rest(structure, regime, gap, p)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The regime of the rest, and the gap that began to rest.
      type(regime_type), intent(in) :: regime
      integer, intent(in) :: gap
      !> (2n, columns) In and out: derivatives of q, then of q'.
      real(wp), intent(inout) :: p(:, :)
      real(wp), allocatable :: carried(:, :)
      integer :: i, n, status

      n = size(p, 1)/2
      allocate (carried(n, 1))
      carried(:, 1) = matmul(structure%damping, structure%mobility(:, gap))
      do i = 1, size(regime%closed)
         associate (j => regime%closed(i))
            if (j < 0) cycle
            if (.not. structure%elastic(j)) cycle
            carried(:, 1) = carried(:, 1) + structure%directions(:, j) &
               *structure%laws(j)%numbers(2)*dot_product(structure%directions(:, j), &
               structure%mobility(:, gap))
         end associate
      end do
      call solve_columns(structure%mass, carried, status)
      do i = 1, size(p, 2)
         p(n + 1:, i) = p(n + 1:, i) + carried(:, 1)*structure%effective(gap)* &
            dot_product(structure%directions(:, gap), p(:n, i))
      end do
      call project(structure, regime%resting, p(:n, :))
      call project(structure, regime%held, p(n + 1:, :))
   end subroutine apply_rest

   !> Removes from vectors the part that closes or opens some gaps, which rest together: they have a
   !! regime, for which the same equations had a solution.
   pure subroutine project(structure, gaps, vectors, speeds)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The gaps.
      integer, intent(in) :: gaps(:)
      !> (n, columns) In and out.
      real(wp), intent(inout) :: vectors(:, :)
      !> (gaps) The rates that are left, if they are not 0.
      real(wp), intent(in), optional :: speeds(:)
      real(wp) :: gram(size(gaps), size(gaps)), parts(size(gaps), size(vectors, 2))
      real(wp), dimension(size(vectors, 1), size(gaps)) :: directions, kicks
      integer :: status

      directions = structure%directions(:, gaps)
      kicks = structure%mobility(:, gaps)
      gram = matmul(transpose(directions), kicks)
      parts = matmul(transpose(directions), vectors)
      if (present(speeds)) parts = parts - spread(speeds, 2, size(parts, 2))
      call solve_columns(gram, parts, status)
      vectors = vectors - matmul(kicks, parts)
   end subroutine project

end module vi_structure_variation
