!> The characteristic polynomial against eigenvalues.
module motions_characteristic
   use checks, only: check, check_close
   use random_numbers, only: draw, fill, random_type
   use vi_characteristic, only: characteristic, resolvent
   use vi_kinds, only: wp
   use vi_lapack, only: eigenvalues
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: test_characteristic, is_contraction

   type(random_type) :: random

contains

   subroutine test_characteristic()
      real(wp) :: p(4, 4), copy(4, 4), e(4), column(4), size_p, largest
      complex(wp) :: z(4), sums(0:4), products
      integer :: i, j, k, status, inside

      inside = 0
      do i = 1, 10000
         size_p = draw(random, 0.2_wp, 1.5_wp)
         do j = 1, 4
            call fill(random, -size_p, size_p, column)
            p(:, j) = column
         end do
         copy = p
         call eigenvalues(copy, z, status)
         call check(status == stat%ok, 'characteristic: eigenvalues')
         e = characteristic(p)
         ! prod (1 + z_j t) by powers of t
         sums = 0
         sums(0) = 1
         do j = 1, 4
            sums(1:) = sums(1:) + z(j)*sums(:3)
         end do
         size_p = max(1.0_wp, size_p)**4
         call check_close(maxval(abs(sums(1:) - e)), 0.0_wp, 1.0e-12_wp*size_p, &
            'characteristic: the symmetric functions')
         products = 1
         do j = 1, 4
            do k = j + 1, 4
               products = products*(1 - z(j)*z(k))
            end do
         end do
         call check_close(abs(products - resolvent(e)), 0.0_wp, 1.0e-11_wp*size_p**3, &
            'characteristic: the resolvent')
         largest = maxval(abs(z))
         if (abs(largest - 1) < 1.0e-9_wp) cycle
         call check(is_contraction(e) .eqv. largest < 1, 'characteristic: a contraction')
         if (largest < 1) inside = inside + 1
      end do
      call check(inside > 1000 .and. inside < 9000, 'characteristic: both kinds come up')
   end subroutine test_characteristic

   !> Whether all eigenvalues lie inside the unit circle, by Jury's conditions.
   pure logical function is_contraction(e)
      !> As `characteristic` gives them.
      real(wp), intent(in) :: e(4)

      is_contraction = abs(e(4)) < 1 .and. 1 + e(2) + e(4) > abs(e(1) + e(3)) .and. &
         abs(e(3) - e(1)*e(4)) < 1 - e(4)**2 .and. resolvent(e) > 0
   end function is_contraction

end module motions_characteristic
