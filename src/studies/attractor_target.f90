!> A periodic motion as a fixed point: one of its events, and the map from there over its period.
module vi_attractor_target
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_forced_system, only: forced_system_type, event_type, release_event, state_type, two_pi
   use vi_kinds, only: wp
   use vi_rest_motion, only: release_state
   use vi_simulate, only: simulate
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: difference, over_period, target_state

   !> A stable periodic motion, and a neighbourhood from which states converge to it.
   type, public :: target_type
      !> The event: a release, or an impact on the wall of this side.
      logical :: release = .false.
      integer :: side = 0
      !> Load cycles and events of a period.
      integer :: cycles = 1, events = 0
      !> State of the event: (x, x', z', alpha), or (v, alpha) of a release.
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

   !> The state of an event minus that of the motion.
   pure function difference(target, event) result(d)
      !> The motion.
      type(target_type), intent(in) :: target
      !> An event of the same kind on the same wall.
      type(event_type), intent(in) :: event
      real(wp) :: d(4)
      real(wp) :: phase

      phase = event%phase - target%middle(target%n)
      phase = phase - two_pi*anint(phase/two_pi)
      if (target%n == 4) then
         d = [event%x - target%middle(1), event%x_dot_after - target%middle(2), &
            event%z_dot_after - target%middle(3), phase]
      else
         d = [event%x_dot_after - target%middle(1), phase, 0.0_wp, 0.0_wp]
      end if
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
         state%phase = start(4)
         state%x = start(1)
         state%x_dot = start(2)
         state%z_dot = start(3)
         state%z = start(1) + 0.5_wp*target%side*system%clearance
         state%side = target%side
         state%speed = target%side*(start(2) - start(3))
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
      !> False if the departure speed is not positive, the simulation fails (for example, if the
      !! events have no room), or no event ends the period.
      logical, intent(out) :: good
      type(state_type) :: state, final
      real(wp) :: phase, nearest, off
      integer :: found, i, status

      n = 0
      state = target_state(system, target, d)
      phase = state%phase
      good = target%release .or. state%speed > 0
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
