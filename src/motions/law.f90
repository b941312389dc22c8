!> The audit of [P]: its determinant must be exp(-4 pi xi k/r) times the product of all R_i^2.
!!
!! The law holds for every periodic motion, and no step of the computation of [P] uses it. A verdict
!! on stability is given only if [P] obeys it, to the rounding of its entries and the errors of the
!! motion.
module vi_law
   use vi_kinds, only: pi, wp
   use vi_motion, only: motion_type
   implicit none (type, external)
   private

   public :: holds, law_of_motion

   !> Safety factors: on the rounding of the entries, and on the errors of the motion. Of 3000
   !! random motions without a residual none had more than twice the rounding of the entries.
   real(wp), parameter :: caution = 1000.0_wp, share = 100.0_wp

   interface holds
      module procedure matrix_holds, motion_holds
   end interface holds

contains

   !> Whether [P] of a motion obeys the law.
   pure logical function motion_holds(motion, p)
      !> A complete motion.
      type(motion_type), intent(in) :: motion
      !> Its [P].
      real(wp), intent(in) :: p(4, 4)
      real(wp) :: clear, error

      ! an error of the speeds is larger in proportion to a small approach speed
      clear = minval(abs(motion%z_dot_before - motion%x_dot_before) &
         /max(abs(motion%z_dot_before), abs(motion%x_dot_before), tiny(1.0_wp)))
      error = motion%residual + motion%rounding + epsilon(1.0_wp)
      motion_holds = matrix_holds(p, law_of_motion(motion), error/max(clear, tiny(1.0_wp)))
   end function motion_holds

   !> Whether the determinant of a matrix is as the law says.
   pure logical function matrix_holds(p, law, error) result(good)
      !> The matrix.
      real(wp), intent(in) :: p(4, 4)
      !> Its determinant by the law, and the relative error of the motion.
      real(wp), intent(in) :: law, error
      real(wp) :: determinant, size

      good = .false.
      ! its powers would overflow
      if (.not. maxval(abs(p)) < huge(1.0_wp)**0.24_wp) return
      determinant = expansion(p, -1)
      size = expansion(abs(p), 1)
      good = abs(determinant - law) <= caution*epsilon(1.0_wp)*size + share*error*law
   end function matrix_holds

   !> det[P] by the law.
   pure real(wp) function law_of_motion(motion) result(law)
      !> Oscillator, r, pattern and restitution are read.
      type(motion_type), intent(in) :: motion

      law = exp(-4*pi*motion%osc%xi*motion%pattern%cycles/motion%r)*product(motion%restitution)**2
   end function law_of_motion

   !> The determinant, by the minors of the rows 1, 2 and 3, 4; or the sum of all its terms, which
   !! no scaling of rows and columns changes relative to it.
   pure real(wp) function expansion(p, sign) result(e)
      !> The matrix.
      real(wp), intent(in) :: p(4, 4)
      !> -1 for the determinant; +1 for the same sum with positive signs.
      integer, intent(in) :: sign
      integer :: s

      s = sign
      e = minor(1, 1, 2)*minor(3, 3, 4) + s*minor(1, 1, 3)*minor(3, 2, 4) &
         + minor(1, 1, 4)*minor(3, 2, 3) + minor(1, 2, 3)*minor(3, 1, 4) &
         + s*minor(1, 2, 4)*minor(3, 1, 3) + minor(1, 3, 4)*minor(3, 1, 2)

   contains

      !> A minor of two successive rows.
      pure real(wp) function minor(row, i, j)
         !> The first row, and both columns.
         integer, intent(in) :: row, i, j

         minor = p(row, i)*p(row + 1, j) + s*p(row, j)*p(row + 1, i)
      end function minor

   end function expansion

end module vi_law
