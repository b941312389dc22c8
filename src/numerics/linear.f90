!> Small systems of linear equations, for which the overhead of library calls would dominate.
module vi_linear
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: eliminate

   !> Most unknowns: those of a motion with 24 impacts, and two parameters.
   integer, parameter, public :: most = 50

contains

   !> Solves n equations for two right sides by Gaussian elimination with scaled partial pivoting.
   pure subroutine eliminate(n, a, b, regular, residual, orientation)
      !> Number of equations and unknowns, at most `most`.
      integer, intent(in) :: n
      !> In: equation i is a(:, i) . x = b(:, i). Out: overwritten.
      real(wp), intent(inout) :: a(most, most)
      !> In: both right sides, b(k, i) for equation i. Out: both solutions, b(k, j) for unknown j.
      real(wp), intent(inout) :: b(2, most)
      !> False if the matrix is singular to rounding; b is then not a solution. If the equations
      !! contain a NaN, this may be true, and the solution then contains a NaN too.
      logical, intent(out) :: regular
      !> Largest entry of the first right side, each relative to the largest coefficient of its
      !! equation.
      real(wp), intent(out) :: residual
      !> The sign of the determinant, +1 or -1; 0 for a singular matrix.
      integer, intent(out), optional :: orientation
      real(wp) :: swap, factor, largest
      integer :: i, j, k, parity

      regular = .false.
      if (present(orientation)) orientation = 0
      residual = 0
      do i = 1, n
         factor = maxval(abs(a(:n, i)))
         if (.not. (factor > 0 .and. factor <= huge(factor))) return
         factor = 1/factor
         a(:n, i) = a(:n, i)*factor
         b(:, i) = b(:, i)*factor
         residual = max(residual, abs(b(1, i)))
      end do
      parity = 1
      do k = 1, n
         j = k
         largest = abs(a(k, k))
         do i = k + 1, n
            if (abs(a(k, i)) > largest) then
               j = i
               largest = abs(a(k, i))
            end if
         end do
         if (.not. largest > 1.0e-14_wp) return
         if (j /= k) then
            parity = -parity
            do i = k, n
               swap = a(i, k)
               a(i, k) = a(i, j)
               a(i, j) = swap
            end do
            b(:, [k, j]) = b(:, [j, k])
         end if
         if (a(k, k) < 0) parity = -parity
         a(k, k) = 1/a(k, k)
         do i = k + 1, n
            factor = a(k, i)*a(k, k)
            a(k + 1:n, i) = a(k + 1:n, i) - factor*a(k + 1:n, k)
            b(:, i) = b(:, i) - factor*b(:, k)
         end do
      end do
      do k = n, 1, -1
         do i = k + 1, n
            b(:, k) = b(:, k) - a(i, k)*b(:, i)
         end do
         b(:, k) = b(:, k)*a(k, k)
      end do
      regular = .true.
      if (present(orientation)) orientation = parity
   end subroutine eliminate

end module vi_linear
