!> Stability without eigenvalues: the characteristic polynomial of a 4 x 4 matrix.
module vi_characteristic
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: characteristic, characteristic_slope

contains

   !> The elementary symmetric functions e_1 .. e_4 of the eigenvalues of a matrix.
   pure function characteristic(p) result(e)
      !> The matrix, for example [P].
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

   !> The derivative of a weighted sum of these functions with respect to the entries of the matrix.
   !!
   !! It is differentiated through the minors; powers of the matrix would lose digits where its
   !! entries are large.
   pure function characteristic_slope(p, weights) result(w)
      !> The matrix, and the weights of e_1 .. e_4.
      real(wp), intent(in) :: p(4, 4), weights(4)
      real(wp) :: w(4, 4)
      real(wp) :: m(4, 4), n(4, 4), of_m(4, 4), of_n(4, 4), top, low
      integer :: i, j

      do j = 1, 4
         do i = 1, 4
            m(i, j) = p(1, i)*p(2, j) - p(1, j)*p(2, i)
            n(i, j) = p(3, i)*p(4, j) - p(3, j)*p(4, i)
         end do
      end do
      top = p(1, 1) + p(2, 2)
      low = p(3, 3) + p(4, 4)
      associate (a => weights, a3 => weights(3))
         ! e(4) pairs each minor with the minor of the other columns
         of_m = antisymmetric(a(4)*[n(3, 4), -n(2, 4), n(2, 3), n(1, 4), -n(1, 3), n(1, 2)] &
            + [a(2) + a3*low, -a3*p(3, 2), -a3*p(4, 2), a3*p(3, 1), a3*p(4, 1), 0.0_wp])
         of_n = antisymmetric(a(4)*[m(3, 4), -m(2, 4), m(2, 3), m(1, 4), -m(1, 3), m(1, 2)] &
            + [0.0_wp, a3*p(1, 4), -a3*p(1, 3), a3*p(2, 4), -a3*p(2, 3), a(2) + a3*top])
         w(1, :) = matmul(of_m, p(2, :)) + [a(1) + a(2)*low + a3*n(3, 4), 0.0_wp, &
            -a(2)*p(3, 1) - a3*n(1, 4), -a(2)*p(4, 1) + a3*n(1, 3)]
         w(2, :) = -matmul(of_m, p(1, :)) + [0.0_wp, a(1) + a(2)*low + a3*n(3, 4), &
            -a(2)*p(3, 2) - a3*n(2, 4), -a(2)*p(4, 2) + a3*n(2, 3)]
         w(3, :) = matmul(of_n, p(4, :)) + [-a(2)*p(1, 3) + a3*m(2, 3), &
            -a(2)*p(2, 3) - a3*m(1, 3), a(1) + a(2)*top + a3*m(1, 2), 0.0_wp]
         w(4, :) = -matmul(of_n, p(3, :)) + [-a(2)*p(1, 4) + a3*m(2, 4), &
            -a(2)*p(2, 4) - a3*m(1, 4), 0.0_wp, a(1) + a(2)*top + a3*m(1, 2)]
      end associate
   end function characteristic_slope

   !> The antisymmetric matrix with given entries 12, 13, 14, 23, 24, 34.
   pure function antisymmetric(x) result(a)
      !> These entries.
      real(wp), intent(in) :: x(6)
      real(wp) :: a(4, 4)

      a(:, 1) = [0.0_wp, -x(1), -x(2), -x(3)]
      a(:, 2) = [x(1), 0.0_wp, -x(4), -x(5)]
      a(:, 3) = [x(2), x(4), 0.0_wp, -x(6)]
      a(:, 4) = [x(3), x(5), x(6), 0.0_wp]
   end function antisymmetric

end module vi_characteristic
