!> The growth of small changes of the state from one event of a simulation to the next.
!!
!! The state of an event is (x, x', z', alpha) just after it, the free mass being on a wall and
!! alpha the load phase. From impact to impact the derivative is [P_i]. An accumulation of impacts
!! and the rest after it leave two directions: at the release the primary mass has no acceleration
!! and both masses have one velocity.
module vi_attractor_tangent
   use vi_forced_system, only: forced_system_type, event_type, impact_event, release_event, &
      stick_event
   use vi_kinds, only: two_pi, wp
   use vi_oscillator, only: left, right
   use vi_variation, only: columns, contact_derivative, identity, moment_type, release, &
      through_rest, through_stick, variation_type
   implicit none (type, external)
   private

   public :: coordinates, event_derivative, departure_speed, lapse, moment_of, period_derivative, &
      restitution_at

contains

   !> The derivative of the state of an event with respect to that of the event before it.
   pure subroutine event_derivative(system, before, after, p, regular)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Two successive events.
      type(event_type), intent(in) :: before, after
      !> (new, old) Derivative of (x, x', z', alpha); undefined where `regular` is false.
      real(wp), intent(out) :: p(4, 4)
      !> False if there is no derivative: an impact without approach speed, or a release where the
      !! contact force does not pass through 0.
      logical, intent(out) :: regular

      if (after%kind == impact_event) then
         call contact_derivative(system, moment_of(before), lapse(system, before, after), &
            after%side, restitution_at(system, after), p, regular)
      else
         call rest_derivative(system, before, after, p, regular)
      end if
   end subroutine event_derivative

   !> Which of (x, x', z', alpha) give the state of an event: two at a release, where x depends on
   !! them; three where an impact leaves both masses with one velocity, for lack of restitution.
   pure function coordinates(system, event) result(places)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The event.
      type(event_type), intent(in) :: event
      integer, allocatable :: places(:)

      if (event%kind == release_event) then
         allocate (places, source=[2, 4])
      else if (restitution_at(system, event) > 0) then
         allocate (places, source=[1, 2, 3, 4])
      else
         allocate (places, source=[1, 2, 4])
      end if
   end function coordinates

   !> The derivative of the map over a period, in the `coordinates` of the event that ends it.
   pure subroutine period_derivative(system, cycles, events, p, good)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Load cycles of the period.
      integer, intent(in) :: cycles
      !> (n) Events of a period; the last one ends it.
      type(event_type), intent(in) :: events(:)
      !> (4, 4); the rows and columns of the coordinates come first, and the rest is 0.
      real(wp), intent(out) :: p(4, 4)
      !> False if an event has no derivative.
      logical, intent(out) :: good
      type(event_type) :: before
      real(wp) :: step(4, 4), whole(4, 4)
      integer, allocatable :: places(:)
      integer :: i, n

      before = events(size(events))
      before%cycle = before%cycle - cycles
      whole = identity
      allocate (places, source=coordinates(system, before))
      n = size(places)
      if (n < 4) whole(3, 2) = 1                        ! z' is x'
      if (n == 2) then                                  ! x = f sin(alpha) - 2 xi x'
         whole(1, 2) = -2*system%osc%xi
         whole(1, 4) = system%load*cos(before%phase)
      end if
      good = .true.
      p = 0
      do i = 1, size(events)
         call event_derivative(system, before, events(i), step, good)
         if (.not. good) return
         whole = matmul(step, whole)
         before = events(i)
      end do
      p(:n, :n) = whole(places, places)
   end subroutine period_derivative

   !> As `event_derivative`, for the beginning or the end of a rest.
   pure subroutine rest_derivative(system, before, after, p, regular)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Two successive events, the later one a stick or a release.
      type(event_type), intent(in) :: before, after
      !> (new, old) Derivative of (x, x', z', alpha); undefined where `regular` is false.
      real(wp), intent(out) :: p(4, 4)
      !> False if a release has no derivative.
      logical, intent(out) :: regular
      type(variation_type) :: change
      type(moment_type) :: from
      real(wp) :: time, unused(columns)

      change%n = 4
      change%state(:, :4) = identity
      from = moment_of(before)
      time = lapse(system, before, after)
      regular = .true.
      if (after%kind == stick_event) then
         ! for the derivative, the common motion begins with the last impact
         call through_stick(system, from, change)
         from%x_dot = (from%x_dot + system%osc%mu*from%z_dot)/(1 + system%osc%mu)
         from%z_dot = from%x_dot
         call through_rest(system, from, time, change)
      else
         call through_rest(system, from, time, change)
         call release(system, moment_of(after), change, unused, regular)
      end if
      p = change%state(:, :4)
   end subroutine rest_derivative

   !> The state just after an event.
   pure function moment_of(event) result(moment)
      !> The event.
      type(event_type), intent(in) :: event
      type(moment_type) :: moment

      moment = moment_type(event%x, event%x_dot_after, event%z_dot_after, event%phase, event%side)
   end function moment_of

   !> Time from one event to a later one.
   pure real(wp) function lapse(system, before, after)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The events.
      type(event_type), intent(in) :: before, after

      lapse = (two_pi*real(after%cycle - before%cycle, wp) + (after%phase - before%phase))/system%r
   end function lapse

   !> Speed at which the masses separate after an event.
   pure real(wp) function departure_speed(event)
      !> The event.
      type(event_type), intent(in) :: event

      departure_speed = event%side*(event%x_dot_after - event%z_dot_after)
   end function departure_speed

   !> Coefficient of restitution of the wall of an event.
   pure real(wp) function restitution_at(system, event) result(restitution)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The event.
      type(event_type), intent(in) :: event

      restitution = system%osc%restitution(merge(right, left, event%side > 0))
   end function restitution_at

end module vi_attractor_tangent
