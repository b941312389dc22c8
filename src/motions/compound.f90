!> Compound matrices: the minors of products of 4 x 4 matrices, without forming the products first.
!!
!! The matrix of the minors of a product is the product of the matrices of minors (Cauchy and
!! Binet). Where a factor is large in one direction only, its minors are no larger than its entries.
!! The minors of the product can then not be computed from the entries of the product, because all
!! their digits cancel.
module vi_compound
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: factor_weights, minors_of_split, product_sums

   !> All minors of one matrix with 1, 2 and 3 rows, each times the same factor.
   type, public :: minors_type
      real(wp) :: scale
      real(wp) :: one(4, 4)
      !> Minors of the rows and columns 12, 13, 14, 23, 24, 34.
      real(wp) :: two(6, 6)
      !> All rows and columns but one: number i leaves out row or column i.
      real(wp) :: three(4, 4)
   end type minors_type

   !> The pairs of rows or columns, and the three of them that leave one out.
   integer, parameter :: pair(2, 6) = reshape([1, 2, 1, 3, 1, 4, 2, 3, 2, 4, 3, 4], [2, 6])
   integer, parameter :: others(3, 4) = reshape([2, 3, 4, 1, 3, 4, 1, 2, 4, 1, 2, 3], [3, 4])
   integer, parameter :: number_of_pair(4, 4) = reshape([0, 1, 2, 3, 1, 0, 4, 5, 2, 4, 0, 6, &
      3, 5, 6, 0], [4, 4])

contains

   !> The minors of a matrix whose rows 1 to 3 are base + column(i)*last, and whose fourth row is
   !! `last`.
   pure function minors_of_split(base, column, last, scale) result(m)
      !> Rows 1 to 3 without their multiples of the last row.
      real(wp), intent(in) :: base(3, 4)
      !> Factors of the fourth row in rows 1 to 3, and the fourth row.
      real(wp), intent(in) :: column(3), last(4)
      !> A factor of all minors, so small that its product with the last row is not large.
      real(wp), intent(in) :: scale
      type(minors_type) :: m
      real(wp) :: row(4), own(6), with(6, 3)
      integer :: a, c, i

      m%scale = scale
      row = scale*last
      do a = 1, 3
         m%one(a, :) = scale*base(a, :) + column(a)*row
         with(:, a) = minors_of_rows(base(a, :), row)
      end do
      m%one(4, :) = row
      do i = 1, 6
         a = pair(1, i)
         c = pair(2, i)
         if (c == 4) then
            m%two(i, :) = with(:, a)
         else
            own = minors_of_rows(base(a, :), base(c, :))
            m%two(i, :) = scale*own + column(c)*with(:, a) - column(a)*with(:, c)
            ! rows a, c and 4, stored under the number of the row that is left out
            m%three(6 - a - c, :) = bordered(own, row)
            if (i == 1) m%three(4, :) = scale*bordered(own, base(3, :))
         end if
      end do
      m%three(4, :) = m%three(4, :) + column(1)*m%three(1, :) - column(2)*m%three(2, :) &
         + column(3)*m%three(3, :)
   end function minors_of_split

   !> The minors of two rows.
   pure function minors_of_rows(a, b) result(m)
      !> The two rows.
      real(wp), intent(in) :: a(4), b(4)
      real(wp) :: m(6)

      m = a(pair(1, :))*b(pair(2, :)) - a(pair(2, :))*b(pair(1, :))
   end function minors_of_rows

   !> The minors of three rows, from those of the first two.
   pure function bordered(m, c) result(d)
      !> Minors of the first two rows (columns 12, 13, 14, 23, 24, 34), and the third row.
      real(wp), intent(in) :: m(6), c(4)
      real(wp) :: d(4)

      d = [m(4)*c(4) - m(5)*c(3) + m(6)*c(2), m(2)*c(4) - m(3)*c(3) + m(6)*c(1), &
         m(1)*c(4) - m(3)*c(2) + m(5)*c(1), m(1)*c(3) - m(2)*c(2) + m(4)*c(1)]
   end function bordered

   !> The sums of the principal minors, with 1, 2 and 3 rows, of the product last * .. * first.
   pure function product_sums(factors) result(sums)
      !> Minors of each factor, the first factor (applied first) first.
      type(minors_type), intent(in) :: factors(:)
      real(wp) :: sums(3)
      type(minors_type) :: all
      integer :: i

      all = factors(1)
      do i = 2, size(factors)
         all = times(factors(i), all)
      end do
      sums = [trace(all%one), trace(all%two), trace(all%three)]
   end function product_sums

   !> The minors of a product.
   pure function times(left, right) result(both)
      !> Minors of the left and the right factor.
      type(minors_type), intent(in) :: left, right
      type(minors_type) :: both

      both%scale = left%scale*right%scale
      both%one = matmul(left%one, right%one)
      both%two = matmul(left%two, right%two)
      both%three = matmul(left%three, right%three)
   end function times

   !> The trace of a square matrix.
   pure real(wp) function trace(a)
      !> The matrix (n, n).
      real(wp), intent(in) :: a(:, :)
      integer :: i

      trace = 0
      do i = 1, size(a, 1)
         trace = trace + a(i, i)
      end do
   end function trace

   !> The derivative of a weighted sum of these three numbers with respect to the entries of each
   !! factor, with the scales of the minors fixed.
   pure subroutine factor_weights(factors, weights, slopes)
      !> Minors of each factor, the first factor (applied first) first.
      type(minors_type), intent(in) :: factors(:)
      !> Weights of the three sums of `product_sums`.
      real(wp), intent(in) :: weights(3)
      !> (4, 4, factors) Derivative with respect to each entry of each factor.
      real(wp), intent(out) :: slopes(:, :, :)
      type(minors_type) :: before(size(factors)), after, rest
      integer :: i, n

      n = size(factors)
      before(1) = unit_minors()
      do i = 2, n
         before(i) = times(factors(i - 1), before(i - 1))
      end do
      after = unit_minors()
      do i = n, 1, -1
         ! the trace of factor * rest
         rest = times(before(i), after)
         slopes(:, :, i) = weights(1)*factors(i)%scale*transpose(rest%one) &
            + weights(2)*by_pairs(factors(i)%one, transpose(rest%two)) &
            + weights(3)*by_threes(factors(i)%two, transpose(rest%three))
         after = times(after, factors(i))
      end do
   end subroutine factor_weights

   !> The minors of the unit matrix.
   pure function unit_minors() result(m)
      type(minors_type) :: m
      integer :: i

      m%scale = 1
      m%one = 0
      m%two = 0
      m%three = 0
      do i = 1, 6
         m%two(i, i) = 1
      end do
      do i = 1, 4
         m%one(i, i) = 1
         m%three(i, i) = 1
      end do
   end function unit_minors

   !> The derivative of a weighted sum of the minors of two rows with respect to the entries.
   pure function by_pairs(p, w) result(slope)
      !> The matrix, and the weights of its minors of two rows (rows, columns).
      real(wp), intent(in) :: p(4, 4), w(6, 6)
      real(wp) :: slope(4, 4)
      integer :: i, j

      slope = 0
      do j = 1, 6
         do i = 1, 6
            associate (a => pair(1, i), c => pair(2, i), k => pair(1, j), l => pair(2, j))
               slope(a, k) = slope(a, k) + w(i, j)*p(c, l)
               slope(c, l) = slope(c, l) + w(i, j)*p(a, k)
               slope(a, l) = slope(a, l) - w(i, j)*p(c, k)
               slope(c, k) = slope(c, k) - w(i, j)*p(a, l)
            end associate
         end do
      end do
   end function by_pairs

   !> The derivative of a weighted sum of the minors of three rows with respect to the entries.
   pure function by_threes(two, w) result(slope)
      !> Minors of two rows of the matrix, and the weights of its minors of three rows (rows,
      !! columns).
      real(wp), intent(in) :: two(6, 6), w(4, 4)
      real(wp) :: slope(4, 4)
      integer :: i, j, a, k, row, column

      slope = 0
      do j = 1, 4
         do i = 1, 4
            do k = 1, 3
               column = number_of_pair(others(mod(k, 3) + 1, j), others(mod(k + 1, 3) + 1, j))
               do a = 1, 3
                  row = number_of_pair(others(mod(a, 3) + 1, i), others(mod(a + 1, 3) + 1, i))
                  ! the complementary minor of entry (a, k), with its sign
                  slope(others(a, i), others(k, j)) = slope(others(a, i), others(k, j)) &
                     + merge(w(i, j), -w(i, j), mod(a + k, 2) == 0)*two(row, column)
               end do
            end do
         end do
      end do
   end function by_threes

end module vi_compound
