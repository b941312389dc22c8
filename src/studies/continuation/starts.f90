!> Starting values of a search at a point: initial states and releases from rest, spread evenly.
module vi_starts
   use vi_kinds, only: two_pi, wp
   use vi_oscillator, only: gain, oscillator_type
   implicit none (type, external)
   private

   public :: release_start, state_start

contains

   !> Estimate of the greatest |x| that a motion with impacts has.
   !!
   !! Where the free mass rests on a wall for a long time, the two masses move as one, and their
   !! resonance is below that of the primary mass alone. Every second start allows for this.
   pure real(wp) function reach_of(osc, r, load, clearance, i) result(reach)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio, load amplitude f, clearance.
      real(wp), intent(in) :: r, load, clearance
      !> The number of the start.
      integer, intent(in) :: i
      real(wp) :: heavier

      reach = gain(osc%xi, r)
      heavier = sqrt(1 + osc%mu)
      if (modulo(i, 2) == 0) reach = max(reach, gain(osc%xi/heavier, r*heavier))
      reach = 1.5_wp*max(min(load*reach, 3*clearance), 0.1_wp*clearance)
   end function reach_of

   !> Initial state number i >= 1: t, x, x', z, z'. The states evenly fill a box about the motion
   !! without impacts (an additive recurrence).
   pure function state_start(osc, r, load, clearance, i) result(state)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio, load amplitude f, clearance.
      real(wp), intent(in) :: r, load, clearance
      !> Number of the start, from 1.
      integer, intent(in) :: i
      real(wp) :: state(5)
      real(wp) :: golden, reach, u(5)
      integer :: j

      golden = 1
      do j = 1, 40
         golden = (1 + golden)**(1.0_wp/6)
      end do
      reach = reach_of(osc, r, load, clearance, i)
      u = [(modulo(0.5_wp + i/golden**j, 1.0_wp), j=1, 5)]
      state(1) = two_pi*u(5)/r
      state(2) = reach*(2*u(1) - 1)
      state(3) = reach*max(1.0_wp, r)*(2*u(2) - 1)
      state(4) = state(2) + 0.499_wp*clearance*(2*u(3) - 1)
      state(5) = 2*reach*max(1.0_wp, r)*(2*u(4) - 1)
   end function state_start

   !> Release number i >= 0 on a wall: (phase, v). The releases are spread over the phase and the
   !! possible velocities.
   !!
   !! At a release x'' = 0, and the contact force ends if the jerk f r cos(phase) - v has the sign
   !! of the wall.
   pure function release_start(osc, r, load, clearance, side, i) result(release)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio, load amplitude f, clearance.
      real(wp), intent(in) :: r, load, clearance
      !> Wall: +1 right, -1 left; number of the start, from 0.
      integer, intent(in) :: side, i
      real(wp) :: release(2)
      real(wp), parameter :: golden = 1.324717957244746_wp

      release(1) = two_pi*modulo(0.5_wp + i/golden, 1.0_wp)
      release(2) = load*r*cos(release(1)) - 2*side*reach_of(osc, r, load, clearance, i) &
         *max(1.0_wp, r)*modulo(0.5_wp + i/golden**2, 1.0_wp)
   end function release_start

end module vi_starts
