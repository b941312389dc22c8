!> The motion of both masses between two impacts, in closed form.
module vi_flight
   use vi_kinds, only: wp
   use vi_oscillation, only: derivatives, new_oscillation, oscillation_type
   use vi_oscillator, only: eta
   implicit none (type, external)
   private

   public :: new_flight, flight_state, flight_position

   !> One flight: the oscillation of the primary mass, and the free mass in uniform motion.
   !!
   !! Its clock starts at 0 at the impact that begins it (time unit 1/omega).
   type, extends(oscillation_type), public :: flight_type
      !> Position (F0/K) and velocity (omega F0/K) of the free mass at the start.
      real(wp) :: z, z_dot
      !> Time until the next impact (1/omega).
      real(wp) :: duration
   end type flight_type

contains

   !> A flight from the state just after an impact.
   pure function new_flight(xi, r, amplitude, phase, x, x_dot, z, z_dot, duration) result(flight)
      !> Damping ratio.
      real(wp), intent(in) :: xi
      !> Frequency ratio Omega/omega.
      real(wp), intent(in) :: r
      !> Forced motion: amplitude A (F0/K), and the argument of its sine at the start, alpha_i + tau
      !! (rad).
      real(wp), intent(in) :: amplitude, phase
      !> State just after the impact: positions x and z (F0/K), velocities x_dot and z_dot (omega
      !! F0/K).
      real(wp), intent(in) :: x, x_dot, z, z_dot
      !> Time until the next impact (1/omega).
      real(wp), intent(in) :: duration
      type(flight_type) :: flight

      flight%oscillation_type = new_oscillation(xi, eta(xi), r, amplitude, phase, x, x_dot)
      flight%z = z
      flight%z_dot = z_dot
      flight%duration = duration
   end function new_flight

   !> Position, velocity and acceleration of the primary mass at time t: equations (2), (27).
   pure subroutine flight_state(flight, t, x, x_dot, x_ddot)
      !> Closed-form motion of both masses.
      type(flight_type), intent(in) :: flight
      !> Time after the start of the flight (1/omega).
      real(wp), intent(in) :: t
      !> Position (F0/K), velocity (omega F0/K) and acceleration (omega^2 F0/K).
      real(wp), intent(out) :: x, x_dot, x_ddot
      real(wp) :: d(0:5)

      d = derivatives(flight, t)
      x = d(0)
      x_dot = d(1)
      x_ddot = d(2)
   end subroutine flight_state

   !> Position of the free mass at time t.
   elemental real(wp) function flight_position(flight, t) result(z)
      !> Closed-form motion of both masses.
      type(flight_type), intent(in) :: flight
      !> Time after the start of the flight (1/omega).
      real(wp), intent(in) :: t

      z = flight%z + flight%z_dot*t
   end function flight_position

end module vi_flight
