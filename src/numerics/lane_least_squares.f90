!> Least squares for many small systems at a time, one system per lane, by Householder QR.
module vi_lane_least_squares
   use vi_kinds, only: wp
   use vi_plan, only: lanes
   implicit none (type, external)
   private

   public :: lane_least_squares

contains

   !> Minimises the 2-norm of a x - b in every lane.
   pure subroutine lane_least_squares(m, n, a, x, residual, total, quality)
      !> Number of equations and of unknowns, m >= n.
      integer, intent(in) :: m, n
      !> In: the matrix, and b in the last column. Out: overwritten.
      real(wp), intent(inout) :: a(lanes, m, n + 1)
      !> Solution; x(l, :) belongs to lane l.
      real(wp), intent(out) :: x(lanes, n)
      !> Squares of the 2-norms of a x - b and of b.
      real(wp), intent(out) :: residual(lanes), total(lanes)
      !> Ratio of the smallest to the largest diagonal entry of R in modulus; 0 without full rank.
      real(wp), intent(out) :: quality(lanes)
      real(wp), dimension(lanes) :: largest, inverse, diagonal
      integer :: i, j

      quality = huge(1.0_wp)
      largest = 0
      ! the diagonal entry of the column is not needed again: 1/diagonal is stored there
      do j = 1, n
         if (j < m) then
            call reflect(j, m, n + 1 - j, a(1, 1, j), diagonal, inverse)
         else
            diagonal = a(:, j, j)
            inverse = 1/apart(diagonal)
         end if
         a(:, j, j) = inverse
         quality = min(quality, abs(diagonal))
         largest = max(largest, abs(diagonal))
      end do
      quality = quality/apart(largest)
      do i = n, 1, -1
         x(:, i) = a(:, i, n + 1)
         do j = i + 1, n
            x(:, i) = x(:, i) - a(:, i, j)*x(:, j)
         end do
         x(:, i) = x(:, i)*a(:, i, i)
      end do
      residual = 0
      do i = n + 1, m
         residual = residual + a(:, i, n + 1)**2
      end do
      total = residual
      do i = 1, n
         total = total + a(:, i, n + 1)**2
      end do
   end subroutine lane_least_squares

   !> A number bounded away from 0, so that a lane without full rank raises no exception.
   elemental real(wp) function apart(x)
      !> Any number, 0 included.
      real(wp), intent(in) :: x

      apart = sign(max(abs(x), tiny(x)), x)
   end function apart

   !> Reflects the first column, from an entry on, onto that entry, and the k other columns with it.
   pure subroutine reflect(top, m, k, a, diagonal, inverse)
      !> Row of the entry that is kept, rows, and number of columns after the first one.
      integer, intent(in) :: top, m, k
      !> In: the columns 0 to k of each lane. Out: reflected; column 0 holds the Householder vector.
      real(wp), intent(inout) :: a(lanes, m, 0:k)
      !> The entry after the reflection, and its reciprocal.
      real(wp), intent(out) :: diagonal(lanes), inverse(lanes)
      real(wp) :: share(lanes), sum(lanes)
      integer :: i, j

      sum = a(:, top, 0)**2
      do i = top + 1, m
         sum = sum + a(:, i, 0)**2
      end do
      diagonal = -sign(sqrt(sum), a(:, top, 0))
      a(:, top, 0) = a(:, top, 0) - diagonal
      share = 1/apart(diagonal*a(:, top, 0))
      inverse = a(:, top, 0)*share
      do j = 1, k
         sum = a(:, top, 0)*a(:, top, j)
         do i = top + 1, m
            sum = sum + a(:, i, 0)*a(:, i, j)
         end do
         sum = sum*share
         do i = top, m
            a(:, i, j) = a(:, i, j) + a(:, i, 0)*sum
         end do
      end do
   end subroutine reflect

end module vi_lane_least_squares
