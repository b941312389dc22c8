!> Stability without eigenvalues: the characteristic polynomial of a 4 x 4 matrix.
module vi_characteristic
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: characteristic, is_contraction, resolvent

contains

   !> The elementary symmetric functions of the eigenvalues of a matrix.
   pure function characteristic(p) result(e)
      real(wp), intent(in) :: p(4, 4)
      real(wp) :: e(4)
      real(wp) :: m12, m13, m14, m23, m24, m34, n12, n13, n14, n23, n24, n34

      ! 2 x 2 minors of rows 1, 2 and of rows 3, 4
      m12 = p(1, 1)*p(2, 2) - p(1, 2)*p(2, 1)
      m13 = p(1, 1)*p(2, 3) - p(1, 3)*p(2, 1)
      m14 = p(1, 1)*p(2, 4) - p(1, 4)*p(2, 1)
      m23 = p(1, 2)*p(2, 3) - p(1, 3)*p(2, 2)
      m24 = p(1, 2)*p(2, 4) - p(1, 4)*p(2, 2)
      m34 = p(1, 3)*p(2, 4) - p(1, 4)*p(2, 3)
      n12 = p(3, 1)*p(4, 2) - p(3, 2)*p(4, 1)
      n13 = p(3, 1)*p(4, 3) - p(3, 3)*p(4, 1)
      n14 = p(3, 1)*p(4, 4) - p(3, 4)*p(4, 1)
      n23 = p(3, 2)*p(4, 3) - p(3, 3)*p(4, 2)
      n24 = p(3, 2)*p(4, 4) - p(3, 4)*p(4, 2)
      n34 = p(3, 3)*p(4, 4) - p(3, 4)*p(4, 3)
      e(1) = p(1, 1) + p(2, 2) + p(3, 3) + p(4, 4)
      e(2) = m12 + n34 + p(1, 1)*(p(3, 3) + p(4, 4)) + p(2, 2)*(p(3, 3) + p(4, 4)) &
         - p(1, 3)*p(3, 1) - p(1, 4)*p(4, 1) - p(2, 3)*p(3, 2) - p(2, 4)*p(4, 2)
      e(3) = p(3, 3)*m12 - p(3, 2)*m13 + p(3, 1)*m23 + p(4, 4)*m12 - p(4, 2)*m14 + p(4, 1)*m24 &
         + p(1, 1)*n34 - p(1, 3)*n14 + p(1, 4)*n13 + p(2, 2)*n34 - p(2, 3)*n24 + p(2, 4)*n23
      e(4) = m12*n34 - m13*n24 + m14*n23 + m23*n14 - m24*n13 + m34*n12
   end function characteristic

   !> Whether all eigenvalues lie inside the unit circle, by Jury's conditions.
   pure logical function is_contraction(e)
      !> As `characteristic` gives them.
      real(wp), intent(in) :: e(4)

      is_contraction = abs(e(4)) < 1 .and. 1 + e(2) + e(4) > abs(e(1) + e(3)) .and. &
         abs(e(3) - e(1)*e(4)) < 1 - e(4)**2 .and. resolvent(e) > 0
   end function is_contraction

   !> The product of all 1 - lambda_i lambda_j, i < j: the resolvent cubic at 1 + e4.
   pure real(wp) function resolvent(e)
      real(wp), intent(in) :: e(4)

      associate (d => 1 + e(4))
         resolvent = ((d - e(2))*d + e(1)*e(3) - 4*e(4))*d &
            - (e(1)**2*e(4) - 4*e(2)*e(4) + e(3)**2)
      end associate
   end function resolvent

end module vi_characteristic
