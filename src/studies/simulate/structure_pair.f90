!> The oscillator of 1983 among structures: a host on a spring and a dashpot under one harmonic
!! load, and a free particle between two walls of the host. Its impacts are found by the
!! procedures of the oscillator, which give the same motion several times as fast.
module vi_structure_pair
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_forced_system, only: event_type, forced_system_type, new_forced_system, state_type
   use vi_kinds, only: two_pi, wp
   use vi_oscillator, only: at_resonance, oscillator_type
   use vi_restitution, only: constant_law
   use vi_simulate, only: fly_on
   use vi_status, only: stat
   use vi_structure, only: load_type, structure_type
   implicit none (type, external)
   private

   public :: place_in, next_impact, recognise

   !> The pair, in its own units.
   type, public :: pair_type
      !> Whether the structure is one; otherwise nothing else is set.
      logical :: known = .false.
      type(forced_system_type) :: system
      !> Coordinates of host and particle; gaps at the right and the left wall.
      integer :: host = 1, particle = 2, gaps(2) = [1, 2]
      !> F0/K, and omega F0/K, in the units of the structure.
      real(wp) :: length = 1, velocity = 1
      !> omega, and the phase of the load, as a sine, at time 0 (rad).
      real(wp) :: omega = 1, lead = 0
      !> Change of a channel per change of the relative position: the absolute component of G_j.
      real(wp) :: factor = 1
   end type pair_type

   !> Where the pair is: just after an impact. In the units of the structure.
   type, public :: place_type
      integer(int64) :: cycle = 0
      !> Time after the last whole cycle of the load.
      real(wp) :: elapsed = 0
      !> Coordinates and velocities, those of the host first; the parts of the host's that are due
      !! to the free vibration.
      real(wp) :: q(2) = 0, rate(2) = 0, free(2) = 0
      !> The gap, approach speed, and departure speed.
      integer :: gap = 1
      real(wp) :: approach = 0, departure = 0
   end type place_type

contains

   !> Whether a structure is such a pair.
   pure subroutine recognise(structure, load, pair)
      !> The structure, checked.
      type(structure_type), intent(in) :: structure
      !> Its load.
      type(load_type), intent(in) :: load
      !> The pair.
      type(pair_type), intent(out) :: pair
      real(wp) :: mass, stiffness, force, xi, r
      integer :: h, p

      if (size(structure%mass, 1) /= 2 .or. size(structure%openings) /= 2) return
      if (structure%channels /= 1 .or. size(load%sine, 2) /= 1 .or. load%step > 0) return
      if (structure%moves) return
      h = merge(1, 2, structure%stiffness(1, 1) > 0)
      p = 3 - h
      associate (m => structure%mass, c => structure%damping, k => structure%stiffness, &
         g => structure%directions)
         ! nothing but the mass of the particle, and nothing between the two
         if (any(abs([m(1, 2), m(2, 1), c(1, 2), c(2, 1), k(1, 2), k(2, 1), c(p, p), k(p, p)]) &
            > 0)) return
         if (abs(g(1, 1) + g(2, 1)) > 0 .or. any(abs(structure%openings) <= 0) .or. &
            abs(structure%openings(1) - structure%openings(2)) > 0) return
         if (any(structure%laws%kind /= constant_law)) return
         force = hypot(load%cosine(h, 1), load%sine(h, 1))
         if (any(abs([load%constant, load%cosine(p, 1), load%sine(p, 1)]) > 0)) return
         mass = m(h, h)
         stiffness = k(h, h)
         if (.not. (stiffness > 0 .and. load%frequency > 0 .and. force > 0)) return
         pair%omega = sqrt(stiffness/mass)
         xi = c(h, h)/(2*sqrt(stiffness*mass))
         r = load%frequency/pair%omega
         if (.not. xi < 0.99_wp .or. at_resonance(xi, r)) return
         pair%host = h
         pair%particle = p
         pair%gaps = merge([1, 2], [2, 1], g(p, 1) > 0)
         pair%length = force/stiffness
         pair%velocity = pair%omega*pair%length
         pair%lead = modulo(atan2(load%cosine(h, 1), load%sine(h, 1)), two_pi)
         pair%factor = abs(g(p, 1))
         pair%system = new_forced_system(oscillator_type(xi, m(p, p)/mass, &
            structure%restitution(pair%gaps)), r, 1.0_wp, &
            2*structure%openings(1)/(pair%factor*pair%length))
         pair%known = .true.
      end associate
   end subroutine recognise

   !> The state of the oscillator just after an impact.
   pure function place_in(pair, place) result(state)
      !> The pair.
      type(pair_type), intent(in) :: pair
      !> The place; its free part and approach speed are not used.
      type(place_type), intent(in) :: place
      type(state_type) :: state

      state%cycle = place%cycle
      state%phase = pair%system%r*pair%omega*place%elapsed + pair%lead
      if (state%phase >= two_pi) then
         state%phase = state%phase - two_pi
         state%cycle = state%cycle + 1
      end if
      state%x = place%q(1)/pair%length
      state%x_dot = place%rate(1)/pair%velocity
      state%z = place%q(2)/pair%length
      state%z_dot = place%rate(2)/pair%velocity
      state%side = merge(1, -1, place%gap == pair%gaps(1))
      state%speed = place%departure/(pair%factor*pair%velocity)
   end function place_in

   !> The next impact, unless impacts may accumulate from here on.
   pure subroutine next_impact(pair, remaining, state, place, found)
      !> The pair.
      type(pair_type), intent(in) :: pair
      !> Time to the end, in the units of the structure.
      real(wp), intent(in) :: remaining
      !> In: just after an impact. Out: just after the next one, if it is found.
      type(state_type), intent(inout) :: state
      !> Out: the same in the units of the structure, if it is found.
      type(place_type), intent(inout) :: place
      !> Whether it is found before the end.
      logical, intent(out) :: found
      !> A departure speed below this share of the closing acceleration may lead to a rest.
      real(wp), parameter :: slow = 0.5e-6_wp
      type(event_type) :: event
      real(wp) :: s, c
      integer :: status

      s = sin(state%phase)
      c = cos(state%phase)
      associate (system => pair%system)
         found = state%speed > max(0.0_wp, -slow*state%side*(s - 2*system%osc%xi*state%x_dot &
            - state%x))
         if (.not. found) return
         status = stat%ok
         call fly_on(system, state, s, c, remaining*pair%omega, event, found, status)
         found = found .and. status == stat%ok
         if (found) call place_of(pair, state, event, place)
      end associate
   end subroutine next_impact

   !> An impact in the units of the structure.
   pure subroutine place_of(pair, state, event, place)
      !> The pair.
      type(pair_type), intent(in) :: pair
      !> The state just after it.
      type(state_type), intent(in) :: state
      !> The impact.
      type(event_type), intent(in) :: event
      !> The place.
      type(place_type), intent(inout) :: place
      real(wp) :: s, c, angle, restitution

      place%cycle = state%cycle
      angle = state%phase - pair%lead
      if (angle < 0) then
         angle = angle + two_pi
         place%cycle = place%cycle - 1
      end if
      place%elapsed = angle/(pair%system%r*pair%omega)
      place%q = pair%length*[state%x, state%z]
      place%rate = pair%velocity*[state%x_dot, state%z_dot]
      s = sin(state%phase)
      c = cos(state%phase)
      associate (m => pair%system%transition)
         place%free(1) = pair%length*(state%x - (m%in_phase*s - m%behind*c))
         place%free(2) = pair%velocity*(state%x_dot - m%r*(m%in_phase*c + m%behind*s))
      end associate
      place%gap = pair%gaps(merge(1, 2, state%side > 0))
      restitution = pair%system%osc%restitution(merge(1, 2, state%side > 0))
      place%departure = pair%factor*pair%velocity*state%speed
      ! the departure speed has full relative accuracy
      place%approach = pair%factor*pair%velocity*state%side*(event%z_dot_before - &
         event%x_dot_before)
      if (restitution > 0) place%approach = place%departure/restitution
   end subroutine place_of

end module vi_structure_pair
