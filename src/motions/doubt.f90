!> The error that rounding may cause in the leading multiplier of an exact motion.
!!
!! The unknowns x_i, theta_i solve the equations to rounding. Near a fold or a pitchfork the
!! Jacobian of the equations is nearly singular, so that the errors of the unknowns, and of the
!! multipliers, are far larger than rounding.
module vi_doubt
   use vi_exact, only: member, newton_equations, setting_type
   use vi_impact_map, only: impact_maps
   use vi_kinds, only: wp
   use vi_lapack, only: eigenvalues, solve
   use vi_motion, only: motion_type
   use vi_oscillator, only: gain
   use vi_stability, only: multipliers
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: greater, modulus_doubt, spread_of_orders, unknowns_doubt, worst_change

   !> Assumed error of a residual, over the sum of the residual itself and the rounding of its
   !! terms.
   real(wp), parameter, public :: caution = 4.0_wp

contains

   !> Possible error of the modulus of the leading multiplier; huge where nothing is certain.
   !!
   !! Of all changes of the unknowns that rounding of the residuals can cause, the largest is
   !! applied, forward and backward. Near a singular Jacobian all large changes have the same
   !! direction. The rounding of the multipliers themselves is included: the product of the [P_i]
   !! may begin with any impact, and each order is rounded differently.
   pure real(wp) function modulus_doubt(motion) result(doubt)
      !> An exact motion with its multipliers.
      type(motion_type), intent(in) :: motion
      type(setting_type) :: setting
      type(motion_type) :: other
      complex(wp) :: lambda(4)
      real(wp), dimension(2*size(motion%x)) :: unknowns, change
      real(wp) :: modulus
      integer :: n, side, status
      logical :: regular

      n = size(motion%x)
      modulus = abs(motion%multipliers(1))
      setting = setting_of(motion)
      unknowns = [motion%x, motion%phases + motion%tau]
      call change_of_unknowns(setting, unknowns, motion%amplitude, change, regular)
      doubt = huge(1.0_wp)
      if (.not. regular) return
      doubt = spread_of_orders(motion, modulus)
      do side = -1, 1, 2
         call member(setting, unknowns(:n) + side*change(:n), &
            unknowns(n + 1:) + side*change(n + 1:), other)
         call multipliers(other, lambda, status)
         if (status /= stat%ok) then
            doubt = huge(1.0_wp)
            return
         end if
         doubt = greater(doubt, abs(abs(lambda(1)) - modulus))
      end do
   end function modulus_doubt

   !> Estimated error of the unknowns of an exact motion: positions relative to the largest of them
   !! and the clearance, and phases.
   pure real(wp) function unknowns_doubt(motion) result(doubt)
      !> An exact motion.
      type(motion_type), intent(in) :: motion
      real(wp) :: jacobian(2*size(motion%x), 2*size(motion%x)), pivots(2)
      real(wp), dimension(2*size(motion%x)) :: unknowns, residual, rounding
      integer :: i, n, status

      n = size(motion%x)
      unknowns = [motion%x, motion%phases + motion%tau]
      call newton_equations(setting_of(motion), unknowns, residual, jacobian)
      rounding = rounding_of(motion%amplitude*(1 + motion%r), unknowns, residual, jacobian)
      jacobian(:, :n) = jacobian(:, :n)*max(motion%clearance, maxval(abs(motion%x)))
      do i = 1, 2*n
         jacobian(i, :) = jacobian(i, :)/rounding(i)
      end do
      call solve(jacobian, residual, status, pivots)
      doubt = huge(1.0_wp)
      if (pivots(1) > 0) doubt = 1/pivots(1)
   end function unknowns_doubt

   !> The given data of an exact motion.
   pure type(setting_type) function setting_of(motion) result(setting)
      !> The motion.
      type(motion_type), intent(in) :: motion

      setting = setting_type(motion%osc, motion%r, motion%amplitude/gain(motion%osc%xi, motion%r), &
         motion%clearance, motion%pattern, motion%restitution)
   end function setting_of

   !> Possible errors of the residuals.
   pure function rounding_of(speed, unknowns, residual, jacobian) result(rounding)
      !> Position and velocity of the forced motion; unknowns, residuals and their derivatives.
      real(wp), intent(in) :: speed, unknowns(:), residual(:), jacobian(:, :)
      real(wp) :: rounding(size(residual))
      integer :: i

      do i = 1, size(residual)
         rounding(i) = caution*(epsilon(1.0_wp)*(dot_product(abs(jacobian(i, :)), abs(unknowns)) &
            + speed) + abs(residual(i)))
      end do
   end function rounding_of

   !> The worst change of the unknowns x_i, theta_i of an exact motion.
   pure subroutine change_of_unknowns(setting, unknowns, amplitude, change, regular)
      !> Given data of the motion: oscillator, r, load, clearance, pattern, restitution.
      type(setting_type), intent(in) :: setting
      !> x_i (F0/K) and theta_i = alpha_i + tau (rad) (2N), and the amplitude A of the forced
      !! motion.
      real(wp), intent(in) :: unknowns(:), amplitude
      !> (2N) Change of x_i and theta_i.
      real(wp), intent(out) :: change(:)
      !> False if the Jacobian is singular to rounding.
      logical, intent(out) :: regular
      real(wp) :: jacobian(size(unknowns), size(unknowns))
      real(wp), dimension(size(unknowns)) :: residual, rounding, units
      integer :: n

      n = size(unknowns)
      call newton_equations(setting, unknowns, residual, jacobian)
      rounding = rounding_of(amplitude*(1 + setting%r), unknowns, residual, jacobian)
      units(:n/2) = setting%clearance
      units(n/2 + 1:) = 1
      call worst_change(jacobian, rounding, units, change, regular)
   end subroutine change_of_unknowns

   !> The largest change of the unknowns that rounding of the residuals can cause.
   pure subroutine worst_change(jacobian, rounding, units, change, regular)
      !> Derivatives of the residuals (n) with respect to the unknowns (n).
      real(wp), intent(in) :: jacobian(:, :)
      !> Possible error of each residual (n), and the units in which the unknowns are compared (n).
      real(wp), intent(in) :: rounding(:), units(:)
      !> (n)
      real(wp), intent(out) :: change(:)
      !> False if the Jacobian is singular to rounding.
      logical, intent(out) :: regular
      real(wp), dimension(size(rounding), size(rounding)) :: factors, answers
      real(wp) :: total(size(rounding))
      integer :: i, j, n, status, worst

      n = size(rounding)
      regular = .false.
      change = 0
      do j = 1, n
         factors = jacobian
         answers(:, j) = 0
         answers(j, j) = rounding(j)
         call solve(factors, answers(:, j), status)
         if (status /= stat%ok) return
      end do
      do i = 1, n
         total(i) = sum(abs(answers(i, :)))
      end do
      if (.not. all(total <= huge(1.0_wp))) return
      worst = maxloc(total/units, 1)
      do j = 1, n
         change = change + sign(1.0_wp, answers(worst, j))*answers(:, j)
      end do
      regular = .true.
   end subroutine worst_change

   !> Largest difference of the modulus between the products of the [P_i] that begin with each
   !! impact.
   pure real(wp) function spread_of_orders(motion, modulus) result(spread)
      !> An exact motion.
      type(motion_type), intent(in) :: motion
      !> Modulus of the leading multiplier from the product that begins with the first impact.
      real(wp), intent(in) :: modulus
      real(wp) :: p(4, 4, size(motion%x)), product(4, 4)
      complex(wp) :: lambda(4)
      integer :: i, j, n, status
      logical :: regular

      n = size(motion%x)
      spread = 0
      call impact_maps(motion, p, regular)
      if (.not. regular) spread = huge(1.0_wp)
      do j = 2, n
         product = p(:, :, j)
         do i = j + 1, j + n - 1
            product = matmul(p(:, :, modulo(i - 1, n) + 1), product)
         end do
         call eigenvalues(product, lambda, status)
         if (status /= stat%ok .or. .not. all(abs(lambda) <= huge(1.0_wp))) spread = huge(1.0_wp)
         spread = greater(spread, abs(maxval(abs(lambda)) - modulus))
      end do
   end function spread_of_orders

   !> The greater of two numbers; huge if one of them is not a number, which max would skip.
   elemental real(wp) function greater(a, b)
      !> The numbers.
      real(wp), intent(in) :: a, b

      greater = huge(1.0_wp)
      if (a <= b) greater = b
      if (a > b) greater = a
   end function greater

end module vi_doubt
