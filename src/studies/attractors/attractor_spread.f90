!> Initial states spread evenly or at random over the range that motions with impacts may reach.
!! They are the same in every run.
module vi_attractor_spread
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   use vi_oscillator, only: gain, oscillator_type
   use vi_philox, only: philox
   implicit none (type, external)
   private

   public :: placed_state, random_states, spread_states

contains

   !> A length over which states are spread: the amplitude of the motion without impacts, within
   !! limits.
   pure real(wp) function spread_scale(xi, r, load, clearance) result(scale)
      !> Damping ratio, frequency ratio, load amplitude f, clearance.
      real(wp), intent(in) :: xi, r, load, clearance

      scale = min(max(load*gain(xi, r), 0.5_wp*clearance), 3*clearance)
   end function spread_scale

   !> The state at t = 0 at a place in the box of `random_states`.
   pure function placed_state(xi, r, load, clearance, place) result(state)
      !> Damping ratio, frequency ratio, load amplitude f, clearance.
      real(wp), intent(in) :: xi, r, load, clearance
      !> x, x', z - x and z' from -1 to 1.
      real(wp), intent(in) :: place(4)
      real(wp) :: state(5), scale

      scale = spread_scale(xi, r, load, clearance)
      state = [0.0_wp, scale*place(1), scale*place(2), scale*place(1) + 0.5_wp*clearance*place(3), &
         scale*place(4)]
   end function placed_state

   !> States (5, n) at t = 0, spread in x, x', z - x and z' by an additive recurrence.
   pure function spread_states(osc, r, load, clearance, n) result(states)
      !> Oscillator; only xi is read.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio, load amplitude f, clearance.
      real(wp), intent(in) :: r, load, clearance
      !> Number of states.
      integer, intent(in) :: n
      real(wp) :: states(5, n)
      real(wp) :: golden, scale, u(4)
      integer :: i, j

      golden = 1
      do j = 1, 60
         golden = (1 + golden)**(1.0_wp/5)
      end do
      scale = spread_scale(osc%xi, r, load, clearance)
      do i = 1, n
         u = 2*[(modulo(0.5_wp + i/golden**j, 1.0_wp), j=1, 4)] - 1
         states(:, i) = [0.0_wp, scale*u(1), scale*u(2), scale*u(1) + 0.499_wp*clearance*u(3), &
            scale*u(4)]
      end do
   end function spread_states

   !> Random states (5, n) at t = 0, uniform in a box: x, x' and z' from -scale to scale, z - x
   !! between the walls. A state depends only on the seed and its index.
   pure function random_states(xi, r, load, clearance, n, seed) result(states)
      !> Damping ratio, frequency ratio, load amplitude f, clearance.
      real(wp), intent(in) :: xi, r, load, clearance
      !> Number of states, and the seed.
      integer, intent(in) :: n, seed
      real(wp) :: states(5, n)
      integer :: i

      do i = 1, n
         ! odd multiples of 2**-32 from -1 to 1, exactly: as many on either side of 0
         states(:, i) = placed_state(xi, r, load, clearance, (2*philox([int(i - 1, int64), &
            0_int64, 0_int64, 0_int64], [int(seed, int64), 0_int64]) + 1)*2.0_wp**(-32) - 1)
      end do
   end function random_states

end module vi_attractor_spread
