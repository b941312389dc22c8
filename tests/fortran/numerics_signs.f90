!> Independence of signs: bounds, sizes and verdicts of mirrored input, and numbers of both
!! signs compared with independent formulas.
module numerics_signs
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, draw_log, fill, random_type
   use vi_advance, only: safe_step
   use vi_bernstein, only: stays_within
   use vi_columns, only: solve_columns
   use vi_kinds, only: wp
   use vi_lane_peak, only: raise
   use vi_lane_groups, only: bound_pairs, sizes_of_pairs
   use vi_lane_spectrum, only: lane_circle, lane_polynomial, lane_radius
   use vi_lapack, only: eigenvalues, least_squares, least_squares_work, solve
   use vi_lapack_routines, only: geev, gels
   use vi_linear, only: eliminate, most
   use vi_plan, only: lanes
   use vi_status, only: stat
   use vi_unit_circle, only: locate_spectrum, near_circle
   implicit none (type, external)
   private

   public :: test_signs

   type(random_type) :: random

contains

   subroutine test_signs()
      call test_polynomials()
      call test_conditions()
      call test_radii()
      call test_sizes_of_pairs()
      call test_bounds_of_pairs()
      call test_coefficients()
      call test_circle()
      call test_columns()
      call test_permutations()
      call test_pivots()
      call test_extreme_entries()
      call test_falling_steps()
   end subroutine test_signs

   !> 1 or -1.
   real(wp) function either_sign()
      either_sign = merge(1, -1, draw(random, -1.0_wp, 1.0_wp) > 0)
   end function either_sign

   !> Rows and columns of either sign change the sign of each term of the determinant, but neither
   !! the sum of the moduli nor the largest entry; each equals a plain formula.
   subroutine test_polynomials()
      real(wp) :: p(lanes, 4, 4), e(lanes, 4), largest(lanes), terms(lanes), wanted, size(4, 4)
      integer :: i, j, k, l, m, n, others(2)

      do k = 1, 100
         do j = 1, 4
            do i = 1, 4
               ! single large entries too
               do l = 1, lanes
                  p(l, i, j) = draw_log(random, 1e-2_wp, 1.0_wp)*either_sign()
               end do
            end do
         end do
         call lane_polynomial(p, e, largest, terms)
         do l = 1, lanes
            wanted = 0
            do m = 1, 3
               do n = m + 1, 4
                  others = pack([1, 2, 3, 4], [1, 2, 3, 4] /= m .and. [1, 2, 3, 4] /= n)
                  wanted = wanted + abs(p(l, 1, m)*p(l, 2, n) - p(l, 1, n)*p(l, 2, m)) &
                     *abs(p(l, 3, others(1))*p(l, 4, others(2)) &
                     - p(l, 3, others(2))*p(l, 4, others(1)))
               end do
            end do
            call check_close(terms(l), wanted, 1e-14_wp*wanted, 'signs: terms of a determinant')
            size = abs(p(l, :, :))
            wanted = max(maxval(size(:3, :3)), size(4, 4), &
               sqrt(maxval(size(4, :3))*maxval(size(:3, 4))))
            call check_close(largest(l), wanted, 1e-14_wp*wanted, 'signs: largest entry')
         end do
      end do
   end subroutine test_polynomials

   !> Jury's conditions from the zeros: 1 - |e_4|, the polynomial at 1 and at -1, and products.
   subroutine test_conditions()
      real(wp) :: e(lanes, 4), largest(lanes), least(lanes), noise(lanes), wanted
      complex(wp) :: z(lanes, 4), product_of_pairs
      integer :: i, j, k, l, leading

      leading = 0
      do k = 1, 1000
         do l = 1, lanes
            z(l, :) = random_zeros()
            largest(l) = draw_log(random, 0.1_wp, 10.0_wp)
         end do
         e = from_zeros(z)
         call lane_circle(e, largest, least, noise)
         do l = 1, lanes
            product_of_pairs = 1
            do i = 1, 3
               do j = i + 1, 4
                  product_of_pairs = product_of_pairs*(1 - z(l, i)*z(l, j))
               end do
            end do
            wanted = min(product_of_pairs%re, real(product(1 - z(l, :))), &
               real(product(1 + z(l, :))), 1 - e(l, 4)**2 - abs(e(l, 3) - e(l, 1)*e(l, 4)))
            if (1 + e(l, 4) < wanted) leading = leading + 1
            wanted = min(wanted, 1 - abs(e(l, 4)))
            call check_close(least(l), wanted, 1e-13_wp, 'signs: the least condition')
            wanted = 100*epsilon(wanted)*max(1.0_wp, largest(l)**3)*(1 + sum(abs(e(l, :3))))
            call check_close(noise(l), wanted, 1e-12_wp*wanted, 'signs: noise of the conditions')
         end do
      end do
      call check(leading > 0, 'signs: a negative product was the least condition')
   end subroutine test_conditions

   !> Zeros of a real polynomial: real ones and conjugate pairs.
   function random_zeros() result(z)
      complex(wp) :: z(4)
      real(wp) :: part(2)
      integer :: i

      do i = 1, 3, 2
         call fill(random, -1.1_wp, 1.1_wp, part)
         z(i) = cmplx(part(1), 0, wp)
         z(i + 1) = cmplx(part(2), 0, wp)
         if (draw(random, -1.0_wp, 1.0_wp) > 0) cycle
         z(i) = 0.8_wp*cmplx(part(1), part(2), wp)
         z(i + 1) = conjg(z(i))
      end do
   end function random_zeros

   !> The elementary symmetric functions of four zeros.
   pure function from_zeros(z) result(e)
      complex(wp), intent(in) :: z(lanes, 4)
      real(wp) :: e(lanes, 4)

      e(:, 1) = real((z(:, 1) + z(:, 2)) + (z(:, 3) + z(:, 4)))
      e(:, 2) = real(z(:, 1)*z(:, 2) + z(:, 3)*z(:, 4) + (z(:, 1) + z(:, 2))*(z(:, 3) + z(:, 4)))
      e(:, 3) = real(z(:, 1)*z(:, 2)*(z(:, 3) + z(:, 4)) + z(:, 3)*z(:, 4)*(z(:, 1) + z(:, 2)))
      e(:, 4) = real(product(z, 2))
   end function from_zeros

   !> Well separated zeros: the radius is the largest modulus, and the slope the product of the
   !! distances to the others; of the mirrored zeros both are the same to the last bit.
   subroutine test_radii()
      real(wp) :: e(lanes, 4), radius(lanes), slope(lanes), mirrored(lanes, 2), wanted, near
      complex(wp) :: z(lanes, 4)
      integer :: i, j, k, l, given, wanted_ones

      given = 0
      wanted_ones = 0
      do k = 1, 1000
         do l = 1, lanes
            z(l, :) = random_zeros()
         end do
         e = from_zeros(z)
         call lane_radius(e, radius, slope)
         e(:, [1, 3]) = -e(:, [1, 3])
         call lane_radius(e, mirrored(:, 1), mirrored(:, 2))
         call check(all(abs(mirrored(:, 1) - radius) <= 0 .and. abs(mirrored(:, 2) - slope) <= 0), &
            'signs: radius and slope of mirrored zeros')
         do l = 1, lanes
            near = huge(1.0_wp)
            do i = 1, 3
               near = min(near, minval(abs(z(l, i) - z(l, i + 1:))))
            end do
            j = maxloc(abs(z(l, :)), 1)
            if (near < 0.1_wp .or. abs(z(l, j)) < 0.3_wp) cycle
            wanted_ones = wanted_ones + 1
            ! the iteration does not converge where pairs have nearly the same product
            if (.not. slope(l) > 0) cycle
            given = given + 1
            call check_close(radius(l), abs(z(l, j)), 1e-10_wp, 'signs: radius')
            ! the slope is that at another zero where two moduli are equal
            if (count(abs(abs(z(l, :)) - abs(z(l, j))) < 1e-6_wp) > merge(2, 1, &
               abs(z(l, j)%im) > 0)) cycle
            wanted = abs(product(z(l, j) - z(l, :), [(i /= j, i=1, 4)]))
            call check_close(slope(l), wanted, 1e-9_wp, 'signs: slope')
         end do
      end do
      call check(given > 0.97_wp*wanted_ones, 'signs: most radii are given')
   end subroutine test_radii

   !> Bounds over a time are those of the moduli of all numbers.
   subroutine test_sizes_of_pairs()
      integer, parameter :: n = 4
      real(wp), dimension(n) :: omega, damping, inverse
      real(wp) :: duration, plus(n, 6), any_sign(n, 6), sums(2, 2)
      integer :: i, j, k, l

      do k = 1, 2000
         duration = draw_log(random, 1e-2_wp, 1e2_wp)
         do j = 1, n
            omega(j) = draw_log(random, 1e-3_wp, 1e1_wp)
            damping(j) = omega(j)*draw(random, 0.0_wp, 2.0_wp)
            inverse(j) = 1/omega(j)
            if (mod(j + k, 3) == 0) omega(j) = 0
            if (mod(j + k, 3) == 0) inverse(j) = 0
            do i = 1, 6
               plus(j, i) = draw_log(random, 1e-3_wp, 1.0_wp)
            end do
         end do
         any_sign = plus
         ! numbers of one kind alone, then of all kinds
         do l = 1, 6
            if (l == mod(k, 7) .or. mod(k, 7) == 0) any_sign(:, l) = [(either_sign()*plus(j, l), &
               j=1, n)]
         end do
         call sizes_of_pairs(n, duration, omega**2, damping, inverse, plus(:, 1), plus(:, 2), &
            plus(:, 3), plus(:, 4), plus(:, 5), plus(:, 6), sums(1, 1), sums(2, 1))
         call sizes_of_pairs(n, duration, omega**2, damping, inverse, any_sign(:, 1), &
            any_sign(:, 2), any_sign(:, 3), any_sign(:, 4), any_sign(:, 5), any_sign(:, 6), &
            sums(1, 2), sums(2, 2))
         call check(all(abs(sums(:, 1) - sums(:, 2)) <= 0), 'signs: sizes of pairs')
      end do
   end subroutine test_sizes_of_pairs

   !> The bounds on fourth derivatives are those of the mirrored motion, with any damping.
   subroutine test_bounds_of_pairs()
      integer, parameter :: n = 4
      real(wp), dimension(n) :: omega, damping, inverse
      real(wp) :: numbers(n, 6), bounds(n, 4)
      integer :: i, j, k

      do k = 1, 1000
         do j = 1, n
            omega(j) = draw_log(random, 1e-2_wp, 1e1_wp)
            damping(j) = omega(j)*draw_log(random, 1e-2_wp, 1e2_wp)
            inverse(j) = 1/omega(j)
            if (mod(j + k, 3) == 0) omega(j) = 0
            if (mod(j + k, 3) == 0) inverse(j) = 0
         end do
         do i = 1, 6
            call fill(random, -1.0_wp, 1.0_wp, numbers(:, i))
         end do
         call bound_pairs(n, omega**2, damping, inverse, numbers(:, 1), numbers(:, 2), &
            numbers(:, 3), numbers(:, 4), numbers(:, 5), numbers(:, 6), bounds(:, 1), bounds(:, 2))
         numbers = -numbers
         call bound_pairs(n, omega**2, damping, inverse, numbers(:, 1), numbers(:, 2), &
            numbers(:, 3), numbers(:, 4), numbers(:, 5), numbers(:, 6), bounds(:, 3), bounds(:, 4))
         call check(all(abs(bounds(:, :2) - bounds(:, 3:)) <= 0) .and. all(bounds >= 0), &
            'signs: bounds of pairs')
      end do
   end subroutine test_bounds_of_pairs

   !> The bound between two nodes is the largest coefficient, of either sign, of the cubic raised to
   !! a quartic; the one in the middle is larger by the dip.
   subroutine test_coefficients()
      real(wp) :: b(0:3), c(0:4), dip, level, f(2), rise(2)
      real(wp), dimension(lanes) :: highest, first, second, dips
      real(wp) :: rises(lanes, 2)
      integer :: i, place, seen(-5:5)

      seen = 0
      do i = 1, 5000
         call fill(random, -1.0_wp, 1.0_wp, b)
         dip = merge(0.0_wp, draw(random, 0.0_wp, 0.3_wp), mod(i, 2) == 0)
         c = [b(0), (b(0) + 3*b(1))/4, (b(1) + b(2))/2, (3*b(2) + b(3))/4, b(3)]
         c(2) = sign(abs(c(2)) + dip, c(2))
         place = maxloc(abs(c), 1)
         level = abs(c(place - 1))
         place = nint(sign(real(place, wp), c(place - 1)))
         seen(place) = seen(place) + 1
         f = [b(0), b(3)]
         rise = 3*[b(1) - b(0), b(3) - b(2)]
         call check(stays_within(level + 1e-14_wp, f, rise, dip) .and. &
            .not. stays_within(level - 1e-14_wp, f, rise, dip), 'signs: largest coefficient')
         highest = 0
         first = f(1)
         second = f(2)
         rises(:, 1) = rise(1)
         rises(:, 2) = rise(2)
         dips = dip
         call raise(highest, first, rises(:, 1), second, rises(:, 2), dips)
         call check_close(maxval(abs(highest - level)), 0.0_wp, 1e-14_wp, 'signs: raised to it')
      end do
      seen(0) = 100
      call check(all(seen >= 100), 'signs: each coefficient was the largest with either sign')
   end subroutine test_coefficients

   !> There is no verdict on a matrix with an eigenvalue on the circle or with a huge entry,
   !! whatever the signs.
   subroutine test_circle()
      real(wp) :: a(4, 4)
      integer :: i, j, k, order(4)

      do k = 1, 2000
         ! a triangle, with its rows and columns in any order
         order = random_order(4)
         a = 0
         do j = 1, 4
            do i = 1, j
               a(order(i), order(j)) = draw(random, -0.9_wp, 0.9_wp)
            end do
         end do
         a(order(1), order(1)) = either_sign()
         call check(locate_spectrum(a) == near_circle, 'signs: an eigenvalue on the circle')
         a(order(1), order(1)) = 0.5_wp
         a(order(1), order(2)) = either_sign()*draw_log(random, 51.0_wp, 1e12_wp)
         call check(locate_spectrum(a) == near_circle, 'signs: a large entry')
         ! the trace is not accurate enough then
         a(order(1), order(1)) = either_sign()*9
         a(order(1), order(2)) = either_sign()*draw_log(random, 1.01e8_wp, 1e12_wp)
         call check(locate_spectrum(a) == near_circle, 'signs: a huge entry')
      end do
   end subroutine test_circle

   !> The numbers 1 to n in any order.
   function random_order(n) result(order)
      integer, intent(in) :: n
      integer :: order(n)
      integer :: i, j

      order = [(i, i=1, n)]
      do i = n, 2, -1
         j = draw_integer(random, 1, i)
         order([i, j]) = order([j, i])
      end do
   end function random_order

   !> A few entries of either sign off the diagonal, or only a negative diagonal.
   subroutine test_columns()
      real(wp) :: a(3, 3), wanted(3, 2), right(3, 2)
      integer :: i, j, k, status

      do k = 1, 500
         a = 0
         do i = 1, 3
            a(i, i) = either_sign()*draw(random, 1.0_wp, 2.0_wp)
         end do
         if (mod(k, 3) > 0) then
            i = draw_integer(random, 1, 3)
            j = 1 + modulo(i + mod(k, 2), 3)
            a(i, j) = either_sign()*draw(random, 0.1_wp, 2.0_wp)
         end if
         do j = 1, 2
            call fill(random, -1.0_wp, 1.0_wp, wanted(:, j))
         end do
         right = matmul(a, wanted)
         call solve_columns(a, right, status)
         call check(status == stat%ok, 'signs: status of columns')
         call check_close(maxval(abs(right - wanted)), 0.0_wp, 1e-14_wp, 'signs: columns')
      end do
      a(:, 3) = 0
      call solve_columns(a, right, status)
      call check(status == stat%singular, 'signs: a column of zeros')
   end subroutine test_columns

   !> Permutations with entries of either sign, exactly; each pivot but one is 0.
   subroutine test_permutations()
      real(wp) :: a(most, most), b(2, most), right(2, most), sign_of_it, residual
      integer :: i, j, k, n, order(6), orientation
      logical :: regular

      n = 6
      do k = 1, 500
         order = random_order(n)
         a = 0
         b = 0
         sign_of_it = 1
         do i = 1, n
            a(order(i), i) = either_sign()
            sign_of_it = sign_of_it*a(order(i), i)
            do j = i + 1, n
               if (order(i) > order(j)) sign_of_it = -sign_of_it
            end do
         end do
         do j = 1, 2
            call fill(random, -1.0_wp, 1.0_wp, b(j, :n))
         end do
         right = b
         call eliminate(n, a, b, regular, residual, orientation)
         call check(regular .and. orientation == nint(sign_of_it), 'signs: a permutation')
         call check_close(residual, maxval(abs(right(1, :n))), 0.0_wp, 'signs: its residual')
      end do
   end subroutine test_permutations

   !> The smallest and the largest pivot in modulus, of triangles with a diagonal of either sign.
   subroutine test_pivots()
      real(wp) :: a(4, 4), copy(4, 4), b(4), pivots(2), wanted(2), residual, &
         work(least_squares_work(4, 4))
      integer :: i, k, status

      do k = 1, 200
         a = 0
         do i = 1, 4
            call fill(random, -1.0_wp, 1.0_wp, a(:i, i))
            a(i, i) = either_sign()*draw_log(random, 1e-3_wp, 1e3_wp)
         end do
         wanted = [minval([(abs(a(i, i)), i=1, 4)]), maxval([(abs(a(i, i)), i=1, 4)])]
         copy = a
         call fill(random, -1.0_wp, 1.0_wp, b)
         call solve(copy, b, status, pivots)
         call check(status == stat%ok .and. all(abs(pivots - wanted) <= 0), 'signs: pivots')
         call least_squares(a, b, work, residual, status, pivots)
         call check(status == stat%ok .and. all(abs(pivots - wanted) <= 1e-14_wp*wanted), &
            'signs: pivots of least squares')
      end do
   end subroutine test_pivots

   !> With one extreme entry of either sign the answers are those of the LAPACK drivers, which
   !! scale, to the last bit.
   subroutine test_extreme_entries()
      integer, parameter :: m = 6, n = 4
      real(wp) :: a(m, n), b(m), copy(m, n), x(m), work(least_squares_work(m, n) + 200), residual, &
         p(n, n), q(n, n), real_part(n), imaginary_part(n), unused(1, 1), extreme
      complex(wp) :: lambda(n)
      integer :: i, j, k, info, status

      do k = 1, 400
         do j = 1, n
            call fill(random, -1.0_wp, 1.0_wp, a(:, j))
         end do
         call fill(random, -1.0_wp, 1.0_wp, b)
         extreme = either_sign()*draw_log(random, 1e294_wp, 1e300_wp)
         i = draw_integer(random, 1, n)
         j = draw_integer(random, 1, n)
         p = a(:n, :)
         p(i, j) = extreme
         if (mod(k, 2) == 0) then
            b(i) = extreme
         else
            a(i, j) = extreme
         end if
         copy = a
         x = b
         call gels('N', m, n, 1, copy, m, x, m, work, size(work), info)
         call least_squares(a, b, work, residual, status)
         call check(all(abs(b(:n) - x(:n)) <= 0), 'signs: least squares with an extreme entry')
         q = p
         call geev('N', 'N', n, q, n, real_part, imaginary_part, unused, 1, unused, 1, work, &
            size(work), info)
         call eigenvalues(p, lambda, status)
         call check(status == stat%ok .and. all(abs(lambda%re - real_part) <= 0 .and. &
            abs(lambda%im - imaginary_part) <= 0), 'signs: eigenvalues with an extreme entry')
      end do
   end subroutine test_extreme_entries

   !> Parabolas that fall with a huge curvature or slope: the step ends at the zero.
   subroutine test_falling_steps()
      real(wp) :: g, fall, zero
      integer :: k

      do k = 1, 500
         g = draw_log(random, 1e100_wp, 1e150_wp)
         fall = draw_log(random, 1e200_wp, 1e300_wp)
         zero = sqrt(g)/sqrt(fall)
         call check_close(safe_step(g, 0.0_wp, -2*fall, 0.0_wp, 0.0_wp, 2*zero), zero, &
            8*epsilon(zero)*zero, 'signs: a huge negative curvature')
         zero = g/fall
         call check_close(safe_step(g, -fall, 0.0_wp, 0.0_wp, 0.0_wp, 2*zero), zero, &
            8*epsilon(zero)*zero, 'signs: a huge negative slope')
      end do
   end subroutine test_falling_steps

end module numerics_signs
