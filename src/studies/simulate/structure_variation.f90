!> The derivative of a simulated motion of a structure by its initial state, event by event in
!! closed
!! form, through impacts, rests and releases.
module vi_structure_variation
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_columns, only: solve_columns
   use vi_kinds, only: wp
   use vi_modes, only: advance
   use vi_status, only: stat
   use vi_structure, only: regime_type, structure_type
   use vi_structure_map, only: accelerations, apply_flight, apply_impact, from_coordinates, &
      to_coordinates
   use vi_structure_run, only: impact_event, release_event, run_event_type, run_state_type, &
      run_type, &
      stick_event
   implicit none (type, external)
   private

   public :: derivative_of_run, start_tangent, through_event, to_state

   !> Changes of the state, carried along a simulation from event to event.
   type, public :: tangent_type
      !> The regime, and the time as whole periods and the remainder.
      integer :: number = 1
      integer(int64) :: cycle = 0
      real(wp) :: elapsed = 0
      !> (m) The pairs there; (2m, columns) changes of x, then of v.
      real(wp), allocatable :: x(:), v(:), d(:, :)
      !> (columns) Changes of the time of the last event, if it is an impact.
      real(wp), allocatable :: later(:)
   end type tangent_type

contains

   !> The derivative of the final state by the initial one.
   pure subroutine derivative_of_run(run, first, events, last, p, largest, status)
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
      !> The largest approach speed over the least one of impacts outside accumulations; 1 if there
      !! are none.
      real(wp), intent(out) :: largest
      !> `stat%ok` or `stat%zero_approach`.
      integer, intent(out) :: status
      type(tangent_type) :: tangent
      integer :: i

      p = 0
      do i = 1, size(p, 1)
         p(i, i) = 1
      end do
      status = stat%ok
      largest = 1
      call start_tangent(run, first, p, tangent)
      do i = 1, size(events)
         call through_event(run, events(i), tangent, status)
         if (status /= stat%ok) return
      end do
      call to_state(run, last, tangent)
      call to_coordinates(run%regimes(tangent%number), tangent%d, p)
      largest = spread_of_speeds(events)
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

      tangent%number = first%regime
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
      !> `stat%ok` or `stat%zero_approach`.
      integer, intent(out) :: status
      real(wp), allocatable :: p(:, :), x_before(:), v_before(:)
      real(wp), dimension(size(run%structure%mass, 1)) :: before, after
      real(wp) :: time
      integer :: j, n

      status = stat%ok
      n = size(before)
      time = max(0.0_wp, real(event%cycle - tangent%cycle, wp)*run%period + (event%elapsed - &
         tangent%elapsed))
      associate (regime => run%regimes(tangent%number), next => run%regimes(event%regime))
         if (event%kind == impact_event) then
            allocate (x_before, source=tangent%x)
            allocate (v_before, source=tangent%v)
            call advance(regime%modes, time, tangent%x, tangent%v, x_before, v_before)
            call apply_flight(regime, time, tangent%d)
            if (event%speed > 0) tangent%later = -closing_of(regime, run%structure%directions(:, &
               event%gap), tangent%d)/event%speed
            call apply_impact(run%structure, regime, event%gap, run%load%frequency*event%elapsed, &
               event%speed, x_before, v_before, event%x, event%v, tangent%d, status)
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
            else
               tangent%later = 0
            end if
            ! the accumulation is completed at its last impact, and the rest begins there
            if (event%kind == stick_event) call apply_rest(run%structure, next%resting, &
               event%gap, p)
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

      call apply_flight(run%regimes(tangent%number), max(0.0_wp, real(last%cycle - tangent%cycle, &
         wp)*run%period + (last%elapsed - tangent%elapsed)), tangent%d)
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
   pure subroutine apply_rest(structure, resting, gap, p)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The gaps that rest from now on, and the one that began to.
      integer, intent(in) :: resting(:), gap
      !> (2n, columns) In and out: derivatives of q, then of q'.
      real(wp), intent(inout) :: p(:, :)
      real(wp), allocatable :: carried(:, :)
      integer :: i, n, status

      n = size(p, 1)/2
      allocate (carried(n, 1))
      carried(:, 1) = matmul(structure%damping, structure%mobility(:, gap))
      call solve_columns(structure%mass, carried, status)
      do i = 1, size(p, 2)
         p(n + 1:, i) = p(n + 1:, i) + carried(:, 1)*structure%effective(gap)* &
            dot_product(structure%directions(:, gap), p(:n, i))
      end do
      call project(structure, resting, p(:n, :))
      call project(structure, resting, p(n + 1:, :))
   end subroutine apply_rest

   !> Removes from vectors the part that closes or opens some gaps, which rest together: they have a
   !! regime, for which the same equations had a solution.
   pure subroutine project(structure, gaps, vectors)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The gaps.
      integer, intent(in) :: gaps(:)
      !> (n, columns) In and out.
      real(wp), intent(inout) :: vectors(:, :)
      real(wp) :: gram(size(gaps), size(gaps)), parts(size(gaps), size(vectors, 2))
      real(wp), dimension(size(vectors, 1), size(gaps)) :: directions, kicks
      integer :: status

      directions = structure%directions(:, gaps)
      kicks = structure%mobility(:, gaps)
      gram = matmul(transpose(directions), kicks)
      parts = matmul(transpose(directions), vectors)
      call solve_columns(gram, parts, status)
      vectors = vectors - matmul(kicks, parts)
   end subroutine project

end module vi_structure_variation
