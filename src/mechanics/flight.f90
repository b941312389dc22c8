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

      flight%oscillation_type = new_oscillation(xi, eta(xi), r, amplitude, phase, x, x_dot)
      flight%z = z
      flight%z_dot = z_dot
      flight%duration = duration
   end function new_flight

   !> Position, velocity and acceleration of the primary mass at time t: equations (2), (27).
   pure subroutine flight_state(flight, t, x, x_dot, x_ddot)
      type(flight_type), intent(in) :: flight
      real(wp), intent(in) :: t
      real(wp), intent(out) :: x, x_dot, x_ddot
      real(wp) :: d(0:5)

      d = derivatives(flight, t)
      x = d(0)
      x_dot = d(1)
      x_ddot = d(2)
   end subroutine flight_state

   !> Position of the free mass at time t.
   elemental real(wp) function flight_position(flight, t) result(z)
      type(flight_type), intent(in) :: flight
      real(wp), intent(in) :: t

      z = flight%z + flight%z_dot*t
   end function flight_position

end module vi_flight
