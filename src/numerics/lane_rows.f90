!> Products of dense matrices with vectors, and sums of derivatives of pairs, for structures.
!!
!! The loops over rows and over pairs are for vector instructions. Sums are taken in a fixed order,
!! so that the results do not depend on the instructions.
module vi_lane_rows
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: add_product, add_products, add_derivatives

   !> Pairs that are summed side by side; lists of pairs are filled up to a multiple of it.
   integer, parameter, public :: side_by_side = 4

contains

   !> y = y + a x.
   pure subroutine add_product(n, m, a, x, y)
      !> Rows and columns.
      integer, intent(in) :: n, m
      !> The matrix, and x (m).
      real(wp), intent(in) :: a(n, m), x(m)
      !> (n)
      real(wp), intent(inout) :: y(n)
      integer :: i, k

      do k = 1, m - 3, 4
         do i = 1, n
            y(i) = y(i) + ((a(i, k)*x(k) + a(i, k + 1)*x(k + 1)) &
               + (a(i, k + 2)*x(k + 2) + a(i, k + 3)*x(k + 3)))
         end do
      end do
      do k = m - mod(m, 4) + 1, m
         do i = 1, n
            y(i) = y(i) + a(i, k)*x(k)
         end do
      end do
   end subroutine add_product

   !> y = y + a x and z = z + a v.
   pure subroutine add_products(n, m, a, x, v, y, z)
      !> Rows and columns.
      integer, intent(in) :: n, m
      !> The matrix, and x and v (m).
      real(wp), intent(in) :: a(n, m), x(m), v(m)
      !> (n)
      real(wp), intent(inout) :: y(n), z(n)
      integer :: i, k

      do k = 1, m - 3, 4
         do i = 1, n
            y(i) = y(i) + ((a(i, k)*x(k) + a(i, k + 1)*x(k + 1)) &
               + (a(i, k + 2)*x(k + 2) + a(i, k + 3)*x(k + 3)))
            z(i) = z(i) + ((a(i, k)*v(k) + a(i, k + 1)*v(k + 1)) &
               + (a(i, k + 2)*v(k + 2) + a(i, k + 3)*v(k + 3)))
         end do
      end do
      do k = m - mod(m, 4) + 1, m
         do i = 1, n
            y(i) = y(i) + a(i, k)*x(k)
            z(i) = z(i) + a(i, k)*v(k)
         end do
      end do
   end subroutine add_products

   !> Adds derivatives of pairs without constant terms: x' = v, v' = -stiffness x - drag v.
   pure subroutine add_derivatives(n, first, last, stiffness, drag, of_x, of_v, x, v, total)
      !> Number of pairs, a multiple of `side_by_side`.
      integer, intent(in) :: n
      !> Orders of the derivatives that are added.
      integer, intent(in) :: first, last
      !> (n) omega^2 and 2 sigma; factors of x and of v in the sums.
      real(wp), intent(in) :: stiffness(n), drag(n), of_x(n), of_v(n)
      !> (n) In: derivatives of order first - 1. Out: of order last.
      real(wp), intent(inout) :: x(n), v(n)
      !> In and out: the sum over the pairs is added to each order.
      real(wp), intent(inout) :: total(0:last)
      real(wp) :: part(0:side_by_side - 1), before
      integer :: i, j, l

      do i = first, last
         part = 0
         do j = 1, n, side_by_side
            do l = 0, side_by_side - 1
               before = x(j + l)
               x(j + l) = v(j + l)
               v(j + l) = -stiffness(j + l)*before - drag(j + l)*v(j + l)
               part(l) = part(l) + (of_x(j + l)*x(j + l) + of_v(j + l)*v(j + l))
            end do
         end do
         total(i) = total(i) + ((part(0) + part(1)) + (part(2) + part(3)))
      end do
   end subroutine add_derivatives

end module vi_lane_rows
