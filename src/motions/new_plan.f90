!> Plans (vi_plan) from an oscillator and a pattern.
module vi_new_plan
   use vi_impact, only: impact, primary_velocities
   use vi_kinds, only: pi, wp
   use vi_motion, only: rounding_margin, worst_rounding
   use vi_oscillator, only: eta, oscillator_type
   use vi_pattern, only: pattern_type
   use vi_plan, only: plan_type
   implicit none (type, external)
   private

   public :: new_plan

contains

   !> The data that all points share.
   pure type(plan_type) function new_plan(osc, pattern, restitution, acceptance) result(plan)
      !> Oscillator; its walls' coefficients are not read, `restitution` is.
      type(oscillator_type), intent(in) :: osc
      !> Sides of the N impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> Coefficient of restitution of each impact (N), and the largest relative residual that
      !! counts as consistent.
      real(wp), intent(in) :: restitution(:), acceptance
      real(wp), parameter :: first(2) = [1, 0], second(2) = [0, 1]
      integer :: i

      plan%n = size(restitution)
      plan%xi = osc%xi
      plan%frequency = eta(osc%xi)
      plan%period = 2*pi*pattern%cycles
      plan%acceptance = acceptance
      plan%accepted = worst_rounding/(2*epsilon(1.0_wp)*rounding_margin)
      plan%squares = product(restitution)**2
      do i = 1, plan%n
         plan%y(i) = 0.5_wp*pattern%sides(i)                                              ! (18)
         call primary_velocities(osc%mu, restitution(i), first, second, plan%x_dot_before(:, i), &
            plan%x_dot_after(:, i))
         call impact(osc%mu, restitution(i), first, second, plan%x_row(:, i), plan%z_row(:, i))
      end do
   end function new_plan

end module vi_new_plan
