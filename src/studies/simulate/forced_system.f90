!> The forced system of a simulation, its state, and what follows from them.
module vi_forced_system
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_contact, only: departure_type
   use vi_flight, only: flight_type, new_flight
   use vi_kinds, only: two_pi, wp
   use vi_oscillation, only: oscillation_type
   use vi_oscillator, only: gain, lag, oscillator_type
   use vi_parting, only: leading_order
   use vi_processor, only: runs_wide
   use vi_rest, only: new_rest
   use vi_simulation, only: event_type, forced_system_type, impact_event, release_event, &
      state_type, stick_event
   use vi_transition, only: new_transition
   implicit none (type, external)
   private

   public :: forced_system_type, state_type, event_type, impact_event, stick_event, release_event
   public :: new_forced_system, set_forced_system, initial_state, least_clearance, state_time, &
      flight_from, rest_from, departure_from, stays_together

contains

   !> A system under a load, with its walls.
   pure function new_forced_system(osc, r, load, clearance) result(system)
      !> As in `set_forced_system`.
      type(oscillator_type), intent(in) :: osc
      real(wp), intent(in) :: r, load, clearance
      type(forced_system_type) :: system

      call set_forced_system(osc, r, load, clearance, .true., system)
   end function new_forced_system

   !> Sets a system in place, where many are needed: its tables take 14 kB.
   pure subroutine set_forced_system(osc, r, load, clearance, marched, system)
      !> Oscillator without its load.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio Omega/omega, load amplitude f, and clearance d in the unit of length of f
      !! (D = d K/F0 for f = 1).
      real(wp), intent(in) :: r, load, clearance
      !> Whether it will be simulated: this takes tables.
      logical, intent(in) :: marched
      !> Out: the system.
      type(forced_system_type), intent(inout) :: system

      system%osc = osc
      system%r = r
      system%load = load
      system%clearance = clearance
      system%amplitude = load*gain(osc%xi, r)
      system%lag = lag(osc%xi, r)
      system%wide = runs_wide() /= 0
      call new_transition(osc%xi, r, system%amplitude*cos(system%lag), &
         system%amplitude*sin(system%lag), system%transition, marched)
   end subroutine set_forced_system

   !> Time of a state in 1/omega.
   pure real(wp) function state_time(cycle, phase, r) result(time)
      !> Whole load cycles.
      integer(int64), intent(in) :: cycle
      !> Load phase beyond them (rad), and frequency ratio.
      real(wp), intent(in) :: phase, r

      time = (two_pi*real(cycle, wp) + phase)/r
   end function state_time

   !> A state from t, x, x', z, z'; on a wall it may depart, rest, or be about to collide.
   pure function initial_state(system, start) result(state)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> t (1/omega), x, x', z, z'.
      real(wp), intent(in) :: start(5)
      type(state_type) :: state
      real(wp) :: y, half, phase

      ! the whole cycles follow from the rounded phase, so that both agree at a whole number of them
      phase = system%r*start(1)
      state%phase = modulo(phase, two_pi)
      if (.not. state%phase < two_pi) state%phase = 0
      state%cycle = nint((phase - state%phase)/two_pi, int64)
      state%x = start(2)
      state%x_dot = start(3)
      state%z = start(4)
      state%z_dot = start(5)
      y = state%z - state%x
      half = 0.5_wp*system%clearance
      if (.not. on_wall(y, half)) return
      state%side = merge(1, -1, y > 0)
      state%speed = state%side*(state%x_dot - state%z_dot)
      if (state%speed < 0) then                                      ! collides at once
         state%side = 0
         state%speed = 0
      else if (.not. state%speed > 0) then
         state%resting = stays_together(system, state)
      end if
   end function initial_state

   !> Whether masses that touch and have the same velocity stay in contact.
   !!
   !! They do if the gap would close otherwise: if the first of its derivatives that is not 0 is
   !! negative. If all are 0, no force acts between them, and they move on together.
   pure logical function stays_together(system, state)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state, on a wall and without a speed relative to it.
      type(state_type), intent(in) :: state
      real(wp) :: value
      integer :: order

      ! the gap is d/2 - side (z - x), and z has no acceleration
      call leading_order(flight_from(system, state, 0.0_wp), 0.0_wp, 2, order, value)
      stays_together = .not. state%side*value > 0
   end function stays_together

   !> The least clearance of a simulation: the rounding error of displacements, half of epsilon, is
   !! a millionth of it. The first meeting with a wall is wrong by no more than twice that.
   pure real(wp) function least_clearance(system, x)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Displacement of the primary mass at the start.
      real(wp), intent(in) :: x

      least_clearance = 0.5e6_wp*epsilon(x)*max(system%amplitude, abs(x))
   end function least_clearance

   !> How the flight from a state begins; a state given by the user may begin with an impact.
   pure function departure_from(state, half) result(departure)
      !> The state at the start of the flight.
      type(state_type), intent(in) :: state
      !> Half the clearance.
      real(wp), intent(in) :: half
      type(departure_type) :: departure
      real(wp) :: approach

      departure = departure_type(state%side, state%speed, state%released)
      if (state%side /= 0 .or. .not. on_wall(state%z - state%x, half)) return
      approach = sign(1.0_wp, state%z - state%x)*(state%z_dot - state%x_dot)
      if (approach > 0) departure = departure_type(merge(1, -1, state%z > state%x), -approach)
   end function departure_from

   !> The flight that begins at a state.
   pure function flight_from(system, state, duration) result(flight)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state at the start of the flight, its time 0.
      type(state_type), intent(in) :: state
      !> Time until the end of the flight (1/omega).
      real(wp), intent(in) :: duration
      type(flight_type) :: flight

      flight = new_flight(system%osc%xi, system%r, system%amplitude, state%phase - system%lag, &
         state%x, state%x_dot, state%z, state%z_dot, duration)
   end function flight_from

   !> The joint oscillation of both masses from a state.
   pure function rest_from(system, state) result(rest)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state at the start, time 0; the free mass is on a wall.
      type(state_type), intent(in) :: state
      type(oscillation_type) :: rest

      rest = new_rest(system%osc%xi, system%osc%mu, system%r, system%load, state%phase, state%x, &
         state%x_dot)
   end function rest_from

   !> Whether the relative position of a state given by the user is that of a wall, to rounding.
   elemental logical function on_wall(y, half)
      !> Relative position z - x, and half the clearance.
      real(wp), intent(in) :: y, half

      on_wall = abs(y) > half*(1 - 1.0e-12_wp)
   end function on_wall

end module vi_forced_system
