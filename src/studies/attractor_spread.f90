!> Initial states spread evenly over what motions with impacts may reach: the same ones every time.
module vi_attractor_spread
   use vi_kinds, only: wp
   use vi_oscillator, only: gain, oscillator_type
   implicit none (type, external)
   private

   public :: spread_scale, spread_states

contains

   !> A length to spread states over: that of the motion without impacts, within limits.
   pure real(wp) function spread_scale(xi, r, load, clearance) result(scale)
      real(wp), intent(in) :: xi, r, load, clearance

      scale = min(max(load*gain(xi, r), 0.5_wp*clearance), 3*clearance)
   end function spread_scale

   !> States (5, n) at t = 0, spread in x, x', z - x and z' by an additive recurrence.
   pure function spread_states(osc, r, load, clearance, n) result(states)
      type(oscillator_type), intent(in) :: osc
      real(wp), intent(in) :: r, load, clearance
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

end module vi_attractor_spread
