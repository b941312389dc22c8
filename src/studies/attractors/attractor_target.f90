!> A periodic motion as a fixed point: one of its events, and the map from there over its period.
module vi_attractor_target
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_attractor_tangent, only: coordinates
   use vi_forced_system, only: forced_system_type, event_type, release_event, state_type
   use vi_kinds, only: two_pi, wp
   use vi_rest_motion, only: release_state
   use vi_simulate, only: simulate
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: difference, over_period, start_target, target_state

   !> A stable periodic motion, and a neighbourhood from which states converge to it.
   type, public :: target_type
      !> The event: a release, or an impact on the wall of this side.
      logical :: release = .false.
      integer :: side = 0
      !> Load cycles and events of a period.
      integer :: cycles = 1, events = 0
      !> State of the event: (x, x', z', alpha); (x, x', alpha) where it leaves both masses with one
      !! velocity, for lack of restitution; (v, alpha) of a release.
      integer :: n = 4
      real(wp) :: middle(4) = 0
      !> The norm is that of `metric` times a difference of states, `inverse` its inverse.
      real(wp), dimension(4, 4) :: metric = 0, inverse = 0
      !> Contraction of P in this norm; radius of the neighbourhood, 0 if there is none.
      real(wp) :: contraction = 1, radius = 0
      !> Half sides of the box around the neighbourhood.
      real(wp) :: box(4) = 0
   end type target_type

contains

   !> An event as a fixed point of the map over a period.
   pure subroutine start_target(system, event, cycles, target)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The event.
      type(event_type), intent(in) :: event
      !> Load cycles of the period.
      integer, intent(in) :: cycles
      !> The motion, without metric and radius.
      type(target_type), intent(out) :: target

      target%release = event%kind == release_event
      target%side = event%side
      target%cycles = cycles
      target%n = size(coordinates(system, event))
      target%middle = state_of(event, target%n)
   end subroutine start_target

   !> The state of an event in the coordinates of a target, the phase last, and zeros.
   pure function state_of(event, n) result(state)
      !> The event.
      type(event_type), intent(in) :: event
      !> The number of coordinates.
      integer, intent(in) :: n
      real(wp) :: state(4)

      state = 0
      select case (n)
      case (2)
         state(:2) = [event%x_dot_after, event%phase]
      case (3)
         state(:3) = [event%x, event%x_dot_after, event%phase]
      case default
         state = [event%x, event%x_dot_after, event%z_dot_after, event%phase]
      end select
   end function state_of

   !> The state of an event minus that of the motion.
   pure function difference(target, event) result(d)
      !> The motion.
      type(target_type), intent(in) :: target
      !> An event of the same kind on the same wall.
      type(event_type), intent(in) :: event
      real(wp) :: d(4)

      d = state_of(event, target%n) - target%middle
      d(target%n) = d(target%n) - two_pi*anint(d(target%n)/two_pi)
   end function difference

   !> The state after the event of the motion plus a difference.
   pure function target_state(system, target, d) result(state)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The motion.
      type(target_type), intent(in) :: target
      !> The difference of states, as from `difference`.
      real(wp), intent(in) :: d(4)
      type(state_type) :: state
      real(wp) :: start(4)

      start = target%middle + d
      if (target%release) then
         state = release_state(system, target%side, [start(2), start(1)])
      else
         state%phase = start(target%n)
         state%x = start(1)
         state%x_dot = start(2)
         state%z_dot = start(target%n - 1)
         state%z = start(1) + 0.5_wp*target%side*system%clearance
         state%side = target%side
         state%speed = target%side*(state%x_dot - state%z_dot)
      end if
   end function target_state

   !> The events of a period that starts from the event of the motion plus a difference.
   pure subroutine over_period(system, target, d, events, n, good)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The motion.
      type(target_type), intent(in) :: target
      !> The difference of states, as from `difference`; 0 for the motion itself.
      real(wp), intent(in) :: d(4)
      !> Out: events 1 to n.
      type(event_type), intent(inout) :: events(:)
      !> Events up to the one that ends the period.
      integer, intent(out) :: n
      !> False if the departure speed is not positive although the wall has restitution, the
      !! simulation fails (for example, if the events have no room), or no event ends the period.
      logical, intent(out) :: good
      type(state_type) :: state, final
      real(wp) :: phase, nearest, off
      integer :: found, i, status

      n = 0
      state = target_state(system, target, d)
      phase = state%phase
      good = target%n < 4 .or. state%speed > 0
      if (.not. good) return
      call simulate(system, state, int(target%cycles, int64), phase + 0.5_wp*two_pi, events, &
         found, final, status)
      good = status == stat%ok
      if (.not. good) return
      nearest = 0.5_wp*two_pi
      do i = 1, found
         if (events(i)%side /= target%side .or. &
            (target%release .neqv. events(i)%kind == release_event)) cycle
         off = abs(two_pi*real(events(i)%cycle - target%cycles, wp) + events(i)%phase - phase)
         if (off >= nearest) cycle
         nearest = off
         n = i
      end do
      good = n > 0
   end subroutine over_period

end module vi_attractor_target
