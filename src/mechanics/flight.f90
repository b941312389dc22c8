!> The motion of both masses between two impacts, in closed form.
module vi_flight
   use vi_kinds, only: wp
   use vi_oscillator, only: eta
   implicit none (type, external)
   private

   public :: new_flight, flight_state, flight_position, derivative_bound

   !> One flight. Its clock starts at 0 at the impact that begins it (time unit 1/omega).
   type, public :: flight_type
      real(wp) :: xi, eta, r
      !> Free motion exp(-xi t) (a sin(eta t) + b cos(eta t)), equations (5), (6).
      real(wp) :: a, b
      !> Forced motion A sin(r t + phase).
      real(wp) :: amplitude, phase
      !> Position and velocity of the free mass at the start.
      real(wp) :: z, z_dot
      real(wp) :: duration
   end type flight_type

contains

   !> A flight from the state just after an impact.
   pure function new_flight(xi, r, amplitude, phase, x, x_dot, z, z_dot, duration) result(flight)
      real(wp), intent(in) :: xi, r
      !> Forced motion: A, and the argument of its sine at the start, alpha_i + tau.
      real(wp), intent(in) :: amplitude, phase
      !> State at the start: x and z positions, x_dot and z_dot velocities.
      real(wp), intent(in) :: x, x_dot, z, z_dot
      real(wp), intent(in) :: duration
      type(flight_type) :: flight

      flight%xi = xi
      flight%eta = eta(xi)
      flight%r = r
      flight%amplitude = amplitude
      flight%phase = phase
      flight%b = x - amplitude*sin(phase)                                                     ! (6)
      flight%a = (x_dot - amplitude*r*cos(phase) + xi*flight%b)/flight%eta                    ! (5)
      flight%z = z
      flight%z_dot = z_dot
      flight%duration = duration
   end function new_flight

   !> Position, velocity and acceleration of the primary mass at time t: equations (2), (27).
   pure subroutine flight_state(flight, t, x, x_dot, x_ddot)
      type(flight_type), intent(in) :: flight
      real(wp), intent(in) :: t
      real(wp), intent(out) :: x, x_dot, x_ddot
      real(wp) :: decay, s, c, free, free_dot, forced, forced_dot

      decay = exp(-flight%xi*t)
      s = decay*sin(flight%eta*t)
      c = decay*cos(flight%eta*t)
      free = flight%a*s + flight%b*c
      free_dot = flight%eta*(flight%a*c - flight%b*s) - flight%xi*free
      forced = flight%amplitude*sin(flight%r*t + flight%phase)
      forced_dot = flight%amplitude*flight%r*cos(flight%r*t + flight%phase)
      x = free + forced
      x_dot = free_dot + forced_dot
      x_ddot = -2*flight%xi*free_dot - free - flight%r**2*forced
   end subroutine flight_state

   !> Position of the free mass at time t.
   elemental real(wp) function flight_position(flight, t) result(z)
      type(flight_type), intent(in) :: flight
      real(wp), intent(in) :: t

      z = flight%z + flight%z_dot*t
   end function flight_position

   !> A bound on the absolute n-th derivative of x from time t on.
   !!
   !! The free part is Re(c exp(lambda t)) with |c| = |(a, b)| and |lambda| = 1 in units of omega, so
   !! each derivative keeps its amplitude; the forced part gains a factor r.
   pure real(wp) function derivative_bound(flight, n, t) result(bound)
      type(flight_type), intent(in) :: flight
      integer, intent(in) :: n
      real(wp), intent(in) :: t

      bound = hypot(flight%a, flight%b)*exp(-flight%xi*t) + abs(flight%amplitude)*flight%r**n
   end function derivative_bound

end module vi_flight
