!> The derivatives of a simulated trajectory: of all its events and of its end, with respect to its
!! initial state and all parameters.
module vi_trajectory_gradient
   use vi_attractor_tangent, only: departure_speed, lapse, moment_of, restitution_at
   use vi_forced_system, only: event_type, forced_system_type, impact_event, state_time, &
      state_type, stick_event
   use vi_kinds, only: wp
   use vi_variation, only: columns, moment_type, of_load, release, through_contact, through_rest, &
      through_span, through_stick, variation_type
   implicit none (type, external)
   private

   public :: trajectory_gradient

   !> Number of quantities that are varied: t, x, x', z, z' at the start, r, clearance, xi, mu, R1,
   !! R2 and the load amplitude.
   integer, parameter, public :: varied = 12
   !> Approach speed, over the velocities, that counts as zero.
   real(wp), parameter :: touching = 1.0e-10_wp
   !> Places of quantities, as far as they are needed.
   integer, parameter :: by_t = 1, by_x = 2, by_x_dot = 3, by_z = 4, by_z_dot = 5, by_r = 6, &
      by_clearance = 7

contains

   !> The derivatives of events and of the end of a trajectory.
   pure subroutine trajectory_gradient(system, start, finish, events, by_events, by_finish, good)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The states at its start and at its end, a given number of load cycles later.
      type(state_type), intent(in) :: start, finish
      !> (n) All its events.
      type(event_type), intent(in) :: events(:)
      !> (12, 6, n) Derivatives of time, x, x' before and after, z' before and after; only those of
      !! the first `good` events are set.
      real(wp), intent(out) :: by_events(:, :, :)
      !> (12, 5) Derivatives of t, x, x', z, z' at the end; 0 unless all events are good.
      real(wp), intent(out) :: by_finish(:, :)
      !> Number of events up to the first one that has no derivatives, an impact without approach
      !! speed or a release where the contact force does not pass through 0.
      integer, intent(out) :: good
      type(variation_type) :: change
      type(moment_type) :: at
      type(event_type) :: before
      real(wp), dimension(columns) :: relative, until, y, unused
      logical :: regular, resting
      integer :: i, m

      m = varied
      call begin(system, start, change, at, before)
      until = change%state(4, :)
      resting = start%resting
      by_events = 0
      by_finish = 0
      do good = 0, size(events) - 1
         i = good + 1
         associate (e => events(i), by => by_events(:, :, i), state => change%state)
            regular = .true.
            if (e%kind == impact_event) then
               by(:, 5) = state(3, :m)
               if (touches(before, e)) return
               call through_contact(system, at, lapse(system, before, e), e%side, &
                  restitution_at(system, e), change, relative, regular)
               if (.not. regular) return
               by(:, 3) = by(:, 5) - relative(:m)
               change%inside = 0
            else if (e%kind == stick_event) then
               ! for the derivative, the common motion begins with the last impact
               call through_stick(system, at, change)
               at%x_dot = (at%x_dot + system%osc%mu*at%z_dot)/(1 + system%osc%mu)
               call through_rest(system, at, lapse(system, before, e), change)
            else
               call through_rest(system, at, lapse(system, before, e), change)
               call release(system, moment_of(e), change, unused, regular)
               if (.not. regular) return
            end if
            resting = e%kind == stick_event
            by(:, 1) = (state(4, :m) - state_time(e%cycle, e%phase, system%r)*change%r(:m))/system%r
            by(:, 2) = state(1, :m)
            by(:, 4) = state(2, :m)
            by(:, 6) = state(3, :m)
            if (e%kind /= impact_event) by(:, [3, 5]) = by(:, [4, 6])
            before = e
            at = moment_of(e)
         end associate
      end do
      associate (e => before, state => change%state)
         e%cycle = finish%cycle - e%cycle
         e%phase = finish%phase - e%phase
         call through_span(system, at, state_time(e%cycle, e%phase, system%r), resting, until, &
            change, y)
         by_finish(:, 1) = (until(:m) - state_time(finish%cycle, finish%phase, system%r) &
            *change%r(:m))/system%r
         by_finish(:, 2) = state(1, :m)
         by_finish(:, 3) = state(2, :m)
         by_finish(:, 4) = state(1, :m) + y(:m)
         by_finish(:, 5) = state(3, :m)
      end associate
   end subroutine trajectory_gradient

   !> Whether an impact has no approach speed, other than one of impacts that accumulate.
   pure logical function touches(before, event)
      !> The event before it, and the impact.
      type(event_type), intent(in) :: before, event
      real(wp) :: small

      small = touching*(abs(event%z_dot_before) + abs(event%x_dot_before))
      touches = abs(event%z_dot_before - event%x_dot_before) <= small
      if (before%side == event%side) touches = touches .and. departure_speed(before) > 10*small
   end function touches

   !> The start of a trajectory, and the changes there.
   pure subroutine begin(system, start, change, at, before)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The initial state.
      type(state_type), intent(in) :: start
      !> With the changes at the start.
      type(variation_type), intent(out) :: change
      !> The state as that of an event, on no wall unless the free mass rests.
      type(moment_type), intent(out) :: at
      !> The start as an event, of which only the time is used.
      type(event_type), intent(out) :: before
      integer :: k

      change%n = varied
      change%with_others = .true.
      change%state(1, by_x) = 1
      change%state(2, by_x_dot) = 1
      change%state(3, by_z_dot) = 1
      change%state(4, by_t) = system%r
      change%state(4, by_r) = state_time(start%cycle, start%phase, system%r)
      change%r(by_r) = 1
      change%clearance(by_clearance) = 1
      do k = 1, of_load
         change%others(k, by_clearance + k) = 1
      end do
      at = moment_type(start%x, start%x_dot, start%z_dot, start%phase, 0)
      before = event_type(0, 0, start%cycle, start%phase, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp)
      if (start%resting) then
         ! both masses move as one
         at%side = start%side
         change%state(3, :) = change%state(2, :)
      else
         change%inside(by_z) = 1
         change%inside(by_x) = -1
      end if
   end subroutine begin

end module vi_trajectory_gradient
