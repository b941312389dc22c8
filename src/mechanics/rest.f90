!> Rest: the free mass lies on a wall and moves with the primary mass until the contact force ends.
!!
!! (1 + mu) x'' + 2 xi x' + x = f sin(r t), in closed form. On the wall of side s the contact holds
!! while s x'' <= 0 and is released when s x'' rises through 0.
module vi_rest
   use vi_advance, only: patience, safe_step
   use vi_kinds, only: wp
   use vi_oscillation, only: derivative_bound, derivatives, new_oscillation, oscillation_type
   use vi_parting, only: leading_order
   implicit none (type, external)
   private

   public :: new_rest, release_time

   integer, parameter :: step_budget = 10000000

contains

   !> The joint oscillation of both masses.
   pure function new_rest(xi, mu, r, load, load_phase, x, x_dot) result(rest)
      !> Damping ratio, mass ratio m/M, and frequency ratio Omega/omega.
      real(wp), intent(in) :: xi, mu, r
      !> Amplitude f of the load (1, or 0 for free vibration), and its phase at time 0 (rad).
      real(wp), intent(in) :: load, load_phase
      !> Common position (F0/K) and velocity (omega F0/K) at time 0.
      real(wp), intent(in) :: x, x_dot
      type(oscillation_type) :: rest
      real(wp) :: decay, frequency, elastic, viscous, forced

      decay = xi/(1 + mu)
      frequency = sqrt((1 + mu - xi**2))/(1 + mu)
      elastic = 1 - (1 + mu)*r**2
      viscous = 2*xi*r
      ! without load and damping r may be the joint natural frequency of both masses
      forced = 0
      if (abs(load) > 0) forced = load/hypot(elastic, viscous)
      rest = new_oscillation(decay, frequency, r, forced, &
         load_phase - atan2(viscous, elastic), x, x_dot)
   end function new_rest

   !> When the contact with a wall ends.
   pure subroutine release_time(rest, side, limit, time, complete)
      !> Joint oscillation from `new_rest`; its time 0 is the start of the rest.
      type(oscillation_type), intent(in) :: rest
      !> Wall: +1 right, -1 left.
      integer, intent(in) :: side
      !> Latest time (1/omega) of a release that is reported.
      real(wp), intent(in) :: limit
      !> Time of the release (1/omega after the start); huge if there is none within the limit.
      real(wp), intent(out) :: time
      !> False if the step budget ran out.
      logical, intent(out) :: complete
      real(wp) :: t, step, d(0:5), bound, usual, reach, force, value
      integer :: n, order

      time = huge(1.0_wp)
      complete = .true.
      t = 0
      usual = 3/max(1.0_wp, rest%r)
      reach = usual
      do n = 1, step_budget
         d = derivatives(rest, t)
         bound = derivative_bound(rest, 6, t)
         if (.not. bound > 0) return                              ! both masses stay at rest
         force = -side*d(2)
         step = 0
         if (force > 0) step = safe_step(force, -side*d(3), -side*d(4), -side*d(5), &
            bound, reach)
         if (step <= 2*spacing(t)) then
            call leading_order(rest, t, 3, order, value)
            if (side*value > 0) then
               time = t
               return
            end if
            step = max(step, sqrt(epsilon(1.0_wp))*usual)         ! touches 0: contact holds
         end if
         t = t + step
         if (t > patience) reach = max(usual, 2*step)
         if (t > limit) return
      end do
      complete = .false.
   end subroutine release_time

end module vi_rest
