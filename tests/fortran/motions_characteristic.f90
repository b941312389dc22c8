!> The characteristic polynomial compared with eigenvalues.
module motions_characteristic
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, fill, random_type
   use vi_characteristic, only: characteristic
   use vi_kinds, only: wp
   use vi_lapack, only: eigenvalues
   use vi_spectrum, only: is_neutral_saddle, outside_circle, pair_product, spectrum_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: test_characteristic, is_contraction

   type(random_type) :: random

contains

   subroutine test_characteristic()
      real(wp) :: p(4, 4), copy(4, 4), e(4), column(4), size_p, largest
      complex(wp) :: z(4), sums(0:4), products
      type(spectrum_type) :: spectrum
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
         call take_sums(e, spectrum)
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
         call check_close(abs(products - pair_product(spectrum)), 0.0_wp, &
            1.0e-11_wp*size_p**3, &
            'characteristic: the product over pairs')
         largest = maxval(abs(z))
         if (minval(abs(abs(z) - 1)) < 1.0e-9_wp) cycle
         call check(outside_circle(spectrum, 0) == count(abs(z) > 1), &
            'characteristic: how many are outside')
         call check(is_contraction(e) .eqv. largest < 1, 'characteristic: a contraction')
         if (largest < 1) inside = inside + 1
      end do
      call check(inside > 1000 .and. inside < 9000, 'characteristic: both kinds come up')
      do i = 1, 3000
         call check_critical()
      end do
   end subroutine test_characteristic

   !> Multipliers on the circle, as at a crossing, and the number of the others outside.
   subroutine check_critical()
      complex(wp) :: z(4), sums(0:4)
      real(wp) :: e(4), t
      type(spectrum_type) :: spectrum
      integer :: j, kind, critical
      logical :: saddle

      kind = draw_integer(random, 1, 3)
      critical = merge(2, 1, kind == 3)
      saddle = .false.
      t = 0
      select case (kind)
      case (1, 2)
         z(1) = 3 - 2*kind
         z(2) = draw(random, -3.0_wp, 3.0_wp)
      case default
         ! a pair with product 1: complex, or real, which is not a Neimark-Sacker point
         t = draw(random, -4.0_wp, 4.0_wp)
         saddle = abs(t) > 2
         z(1) = 0.5_wp*(t + sqrt(cmplx(t**2 - 4, 0, wp)))
         z(2) = 1/z(1)
      end select
      z(3:4) = cmplx(draw(random, -2.0_wp, 2.0_wp), draw(random, 0.0_wp, 1.0_wp), wp)
      z(4) = conjg(z(3))
      sums = 0
      sums(0) = 1
      do j = 1, 4
         sums(1:) = sums(1:) + z(j)*sums(:3)
      end do
      e = real(sums(1:), wp)
      if (minval(abs(abs(z(critical + 1:)) - 1)) < 1.0e-6_wp .or. abs(e(4) - 1) < 1.0e-3_wp) return
      if (abs(abs(t) - 2) < 1.0e-3_wp .and. kind == 3) return
      call take_sums(e, spectrum)
      if (kind == 3) call check(is_neutral_saddle(spectrum) .eqv. saddle, &
         'characteristic: a pair of real ones with product 1')
      if (.not. saddle) call check(outside_circle(spectrum, kind) == &
         count(abs(z(critical + 1:)) > 1), 'characteristic: how many others are outside')
   end subroutine check_critical

   !> A spectrum from its sums. A function of this type would have a result that gfortran 12 at -O3
   !! mistakes for uninitialized.
   pure subroutine take_sums(e, spectrum)
      !> In the form of `characteristic`.
      real(wp), intent(in) :: e(4)
      !> The spectrum.
      type(spectrum_type), intent(out) :: spectrum

      ! by name: flang 19 shifts an array that starts at 0 when a structure constructor fills it
      spectrum%e(0) = 1
      spectrum%e(1:4) = e
      spectrum%product = e(4)
      spectrum%regular = .true.
   end subroutine take_sums

   !> Whether all eigenvalues lie inside the unit circle, by Jury's conditions.
   pure logical function is_contraction(e)
      !> In the form of `characteristic`.
      real(wp), intent(in) :: e(4)
      type(spectrum_type) :: spectrum

      call take_sums(e, spectrum)
      is_contraction = abs(e(4)) < 1 .and. 1 + e(2) + e(4) > abs(e(1) + e(3)) .and. &
         abs(e(3) - e(1)*e(4)) < 1 - e(4)**2 .and. pair_product(spectrum) > 0
   end function is_contraction

end module motions_characteristic
