!> Tests of numerics: linear algebra in both kinds, and the status codes.
program test_numerics
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: real32
   use checks, only: check, check_close, finish
   use numerics_signs, only: test_signs
   use random_numbers, only: draw, draw_integer, draw_log, fill, random_type
   use random_systems, only: determinant, misfit
   use vi_advance, only: safe_step
   use vi_bernstein, only: sag, stays_within
   use vi_kinds, only: wp
   use vi_kinds_single, only: sp => wp
   use vi_lane_rows, only: add_product, add_products, mark_doubts
   use vi_linear, only: eliminate, most
   use vi_lapack, only: eigenvalues, eigenvector, least_squares, least_squares_work, solve
   use vi_lapack_single, only: solve_single => solve
   use vi_lapack_routines, only: geev, gels, gesv
   use vi_processor, only: available_threads, has_memory, usable_threads
   use vi_spacing, only: even, spaced
   use vi_status, only: stat, status_text
   use vi_unit_circle, only: all_inside, locate_spectrum, near_circle, some_outside
   implicit none (type, external)

   type(random_type) :: random

   call test_kinds()
   call test_solve()
   call test_least_squares()
   call test_eliminate()
   call test_eigenvalues()
   call test_known_eigenvalues()
   call test_triangles()
   call test_eigenvector()
   call test_drivers()
   call test_unit_circle()
   call test_between_nodes()
   call test_worst_quartics()
   call test_products()
   call test_units()
   call test_steps_after_a_release()
   call test_huge_matrices()
   call test_numbers_of_threads()
   call test_spacing()
   call test_status()
   call test_not_finite()
   call test_signs()
   call finish()

contains

   !> A v = lambda v for the eigenvalue nearest to a number, which is one of all eigenvalues.
   subroutine test_eigenvector()
      real(wp) :: a(4, 4), copy(4, 4), v(4), near
      complex(wp) :: lambda, all_of_them(4)
      integer :: i, status, real_ones

      real_ones = 0
      do i = 1, 2000
         call random_matrix(a)
         near = merge(1, -1, modulo(i, 2) == 0)
         copy = a
         call eigenvalues(copy, all_of_them, status)
         copy = a
         call eigenvector(copy, near, lambda, v, status)
         call check(status == stat%ok, 'eigenvector: status')
         call check_close(abs(lambda - near), minval(abs(all_of_them - near)), 1.0e-9_wp, &
            'eigenvector: of the nearest eigenvalue')
         if (abs(lambda%im) > 0) cycle
         real_ones = real_ones + 1
         call check_close(norm2(v), 1.0_wp, 1.0e-12_wp, 'eigenvector: length')
         call check(norm2(matmul(a, v) - lambda%re*v) < 1.0e-11_wp*(1 + norm2(a)), &
            'eigenvector: equation')
      end do
      call check(real_ones > 500, 'eigenvector: real ones')
   end subroutine test_eigenvector

   !> A matrix with an entry that is infinite or not a number has no eigenvalues: this is reported,
   !! and does not end the program.
   subroutine test_not_finite()
      real(wp) :: a(4, 4), copy(4, 4), v(4)
      complex(wp) :: lambda(4)
      integer :: i, j, k, status

      do k = 1, 2
         do j = 1, 4
            do i = 1, 4
               call random_matrix(a)
               a(i, j) = ieee_value(a(i, j), merge(ieee_quiet_nan, ieee_positive_inf, k == 1))
               copy = a
               call eigenvalues(copy, lambda, status)
               call check(status == stat%not_finite .and. all(abs(lambda) <= 0), &
                  'not finite: eigenvalues')
               call eigenvector(a, 1.0_wp, lambda(1), v, status)
               call check(status == stat%not_finite .and. all(abs(v) <= 0), &
                  'not finite: an eigenvector')
            end do
         end do
      end do
   end subroutine test_not_finite

   !> The test of Schur and Cohn agrees with the eigenvalues wherever it decides.
   subroutine test_unit_circle()
      real(wp) :: a(4, 4), copy(4, 4), largest
      complex(wp) :: lambda(4)
      integer :: i, place, status, seen(-1:1)

      seen = 0
      do i = 1, 20000
         call random_matrix(a)
         ! half of the spectra near the circle, the others at any distance from it
         copy = a
         call eigenvalues(copy, lambda, status)
         a = a*10.0_wp**merge(draw(random, -1.5_wp, 1.5_wp), draw(random, -1.0e-5_wp, 1.0e-5_wp), &
            modulo(i, 2) == 0)/maxval(abs(lambda))
         copy = a
         call eigenvalues(copy, lambda, status)
         largest = maxval(abs(lambda))
         place = locate_spectrum(a)
         seen(place) = seen(place) + 1
         if (place == near_circle) cycle
         call check(largest < 1 .eqv. place == all_inside, 'the spectrum lies inside the circle')
         call check(largest > 1 .eqv. place == some_outside, 'the spectrum lies outside the circle')
      end do
      call check(seen(all_inside) > 1000 .and. seen(some_outside) > 1000, 'both sides were seen')
      a = 0
      do i = 1, 4
         a(i, i) = 1
      end do
      call check(locate_spectrum(a) == near_circle, 'on the circle it cannot tell')
   end subroutine test_unit_circle

   !> Products of matrices of every shape, with numbers beyond the ends that must not be used.
   subroutine test_products()
      real(wp) :: a(40*40), x(60), v(60), y(50), z(50), wanted(50, 2)
      integer :: i, m, n

      do i = 1, 400
         n = draw_integer(random, 1, 40)
         m = draw_integer(random, 1, 40)
         a = 1e100_wp
         x = 1e100_wp
         v = 1e100_wp
         call fill(random, -1.0_wp, 1.0_wp, a(:n*m))
         call fill(random, -1.0_wp, 1.0_wp, x(:m))
         call fill(random, -1.0_wp, 1.0_wp, v(:m))
         call fill(random, -1.0_wp, 1.0_wp, y)
         call fill(random, -1.0_wp, 1.0_wp, z)
         wanted(:, 1) = y
         wanted(:, 2) = z
         wanted(:n, 1) = y(:n) + matmul(reshape(a(:n*m), [n, m]), x(:m))
         wanted(:n, 2) = z(:n) + matmul(reshape(a(:n*m), [n, m]), v(:m))
         call add_products(n, m, a, x, v, y, z)
         call check_close(maxval(abs(y - wanted(:, 1))), 0.0_wp, 1e-13_wp, 'products: the first')
         call check_close(maxval(abs(z - wanted(:, 2))), 0.0_wp, 1e-13_wp, 'products: the second')
         y(:n) = wanted(:n, 2)
         call add_product(n, m, a, v, y)
         wanted(:n, 2) = wanted(:n, 2) + matmul(reshape(a(:n*m), [n, m]), v(:m))
         call check_close(maxval(abs(y(:n) - wanted(:n, 2))), 0.0_wp, 1e-13_wp, 'products: one')
      end do
   end subroutine test_products

   !> A step to a zero does not depend on the unit of the function, however large or small.
   subroutine test_units()
      real(wp) :: numbers(5), step, other, unit
      integer :: i

      do i = 1, 2000
         call fill(random, -1.0_wp, 1.0_wp, numbers)
         numbers([1, 5]) = abs(numbers([1, 5]))
         if (mod(i, 2) == 0) numbers([1, 3]) = numbers([1, 3])*1e-3_wp
         unit = 2.0_wp**draw_integer(random, -300, 1000)
         step = safe_step(numbers(1), numbers(2), numbers(3), numbers(4), numbers(5), 2.0_wp)
         other = safe_step(unit*numbers(1), unit*numbers(2), unit*numbers(3), unit*numbers(4), &
            unit*numbers(5), 2.0_wp)
         call check_close(other, step, 8*epsilon(1.0_wp)*step, 'steps: of any unit')
      end do
   end subroutine test_units

   !> Just after a release t^2 (k - t^2) is nearly 0, and so is its slope: a few safe steps lead to
   !! its zero at sqrt(k), however small it is, and none goes beyond it.
   subroutine test_steps_after_a_release()
      real(wp) :: k, t, zero
      integer :: i, n

      do i = 0, 24
         k = 10.0_wp**(-i)
         zero = sqrt(k)
         t = 1e-3_wp*k
         do n = 1, 200
            t = t + safe_step(max(0.0_wp, t**2*(k - t**2)), 2*k*t - 4*t**3, 2*k - 12*t**2, -24*t, &
               24.0_wp, 1.0_wp)
            if (.not. t < zero*(1 - 4*epsilon(t))) exit
         end do
         call check(n <= 200, 'steps: few after a release')
         call check_close(t, zero, 8*epsilon(t)*zero, 'steps: up to the zero')
      end do
   end subroutine test_steps_after_a_release

   !> At least one thread, and at most the requested number.
   subroutine test_numbers_of_threads()
      integer :: available, usable
      integer :: wanted

      do wanted = -1, 100
         call check(usable_threads(wanted) >= 1, 'threads: at least one')
         call check(usable_threads(wanted) <= max(1, wanted), 'threads: no more than wanted')
         call check(usable_threads(wanted) >= usable_threads(wanted - 1), 'threads: as wanted')
      end do
      available = available_threads()
      usable = usable_threads(available)
      call check(available >= 1, 'threads: one at least')
      call check(usable == available, 'threads: those available can be used')
      call check(has_memory(1.0e3_wp), 'memory: some')
      call check(.not. has_memory(1.0e18_wp), 'memory: more than there is')
      call check(.not. has_memory(1.0e300_wp), 'memory: more than a number of bytes')
   end subroutine test_numbers_of_threads

   !> A matrix whose trace exceeds 4 has an eigenvalue outside the circle, whatever its sign.
   subroutine test_huge_matrices()
      real(wp) :: a(4, 4), factor
      integer :: i, j

      do i = 1, 500
         do j = 1, 4
            call fill(random, -1.0_wp, 1.0_wp, a(:, j))
         end do
         if (abs(a(1, 1) + a(2, 2) + a(3, 3) + a(4, 4)) < 0.1_wp) cycle
         ! up to this value the trace is accurate enough
         factor = draw_log(random, 1e2_wp, 0.99e8_wp)
         call check(locate_spectrum(factor*a) == some_outside .and. &
            locate_spectrum(-factor*a) == some_outside, 'outside the circle by the trace')
      end do
   end subroutine test_huge_matrices

   !> No function is certain to stay below a level that the worst function with its values and
   !! slopes, a quartic, exceeds between two nodes.
   subroutine test_worst_quartics()
      integer, parameter :: fine = 50
      real(wp), dimension(1) :: y, rate, y_next, rate_next, bound, reserve, upper, lower, above, &
         below
      real(wp) :: b(4), h, s, dip, largest, level, far
      integer :: i, j

      far = 1.0e3_wp
      do i = 1, 20000
         h = draw_log(random, 0.1_wp, 10.0_wp)
         call fill(random, -1.5_wp, 0.5_wp, b)
         ! the bound for which the quartic lies above the cubic by s^2 (1 - s)^2
         bound = 24/h**4
         dip = sag(bound(1), h)
         largest = -far
         do j = 0, fine
            s = real(j, wp)/fine
            largest = max(largest, (1 - s)**3*b(1) + 3*s*(1 - s)**2*b(2) + 3*s**2*(1 - s)*b(3) &
               + s**3*b(4) + (s*(1 - s))**2)
         end do
         y = b(1)
         rate = 3*(b(2) - b(1))/h
         y_next = b(4)
         rate_next = 3*(b(4) - b(3))/h
         reserve = draw_log(random, 1e-3_wp, 1.0_wp)
         level = largest - 1e-9_wp
         upper = level + reserve
         lower = -far
         call mark_doubts(1, h, y, rate, y_next, rate_next, bound, reserve, upper, lower, above, &
            below)
         call check(above(1) > 0 .and. .not. below(1) > 0, 'cells: a limit that is exceeded')
         call mark_doubts(1, h, -y, -rate, -y_next, -rate_next, bound, reserve, -lower, -upper, &
            above, below)
         call check(below(1) > 0 .and. .not. above(1) > 0, 'cells: and a lower one')
         ! a level far enough above all coefficients is certain
         upper = max(maxval(b), 0.5_wp*(b(2) + b(3)) + dip) + reserve + 1e-9_wp
         call mark_doubts(1, h, y, rate, y_next, rate_next, bound, reserve, upper, lower, above, &
            below)
         call check(.not. above(1) > 0, 'cells: a limit that is clearly not exceeded')
         call check(.not. stays_within(far + level, far + [y, y_next], h*[rate, rate_next], dip), &
            'between nodes: a level that is exceeded')
      end do
   end subroutine test_worst_quartics

   !> Bounds certified between nodes hold on a fine grid, and clear cases are certified.
   subroutine test_between_nodes()
      integer, parameter :: n = 16, fine = 100
      real(wp) :: f(0:n), rise(0:n), h, w, phase, level, largest
      integer :: i, j, certain, doubtful

      certain = 0
      doubtful = 0
      do i = 1, 2000
         w = draw(random, 0.5_wp, 3.5_wp)
         phase = draw(random, 0.0_wp, 6.3_wp)
         h = 3.0_wp/n
         do j = 0, n
            f(j) = sin(w*j*h + phase)
            rise(j) = h*w*cos(w*j*h + phase)
         end do
         largest = maxval([(abs(sin(w*j*(h/fine) + phase)), j=0, n*fine)])
         level = largest + draw(random, -5.0e-2_wp, 5.0e-2_wp)
         if (stays_within(level, f, rise, sag(w**4, h))) then
            certain = certain + 1
            call check(largest <= level, 'what is certain is true')
         else
            doubtful = doubtful + 1
            ! the coefficients lie within h^2/8 max|f''| of a polynomial
            call check(largest > level - sag(w**4, h) - (w*h)**2/8, 'what is clear is certain')
         end if
         call check(stays_within(level, -f, -rise, sag(w**4, h)) .eqv. &
            stays_within(level, f, rise, sag(w**4, h)), 'both signs are alike')
      end do
      call check(certain > 100 .and. doubtful > 100, 'both answers were seen')
   end subroutine test_between_nodes

   subroutine test_kinds()
      call check(sp == real32, 'the second build computes in 32 bits')
      call check(precision(1.0_wp) > 2*precision(1.0_sp), &
         'the first build in more than twice as many')
   end subroutine test_kinds

   !> A x = b holds in both kinds; a matrix without full rank is reported.
   subroutine test_solve()
      real(wp) :: a(4, 4), lu(4, 4), b(4), x(4)
      real(sp) :: narrow(4, 4), narrow_x(4)
      integer :: i, j, status, overlooked

      overlooked = 0
      do i = 1, 2000
         call random_matrix(a)
         call fill(random, -1.0_wp, 1.0_wp, b)
         lu = a
         x = b
         call solve(lu, x, status)
         call check(status == stat%ok, 'a random matrix has full rank')
         call check_close(maxval(abs(matmul(a, x) - b)), 0.0_wp, 1e-14_wp*(1 + maxval(abs(x))), &
            'A x = b')
         narrow = real(a, sp)
         narrow_x = real(b, sp)
         call solve_single(narrow, narrow_x, status)
         call check_close(maxval(abs(matmul(a, real(narrow_x, wp)) - b)), 0.0_wp, &
            1e-5_wp*(1 + maxval(abs(x))), 'A x = b in single precision')
         j = draw_integer(random, 1, 4)
         lu = a
         lu(:, j) = 0
         x = b
         call solve(lu, x, status)
         call check(status == stat%singular, 'a column of zeros is singular')
         lu = a
         lu(j, :) = 2*a(modulo(j, 4) + 1, :)
         x = b
         call solve(lu, x, status)
         if (status /= stat%singular) overlooked = overlooked + 1
      end do
      ! rounding may hide the loss of rank, but rarely
      call check(overlooked <= 20, 'two parallel rows are singular')
   end subroutine test_solve

   !> The residual is orthogonal to every column, its norm is returned, and rank loss is reported.
   subroutine test_least_squares()
      real(wp), allocatable :: a(:, :), qr(:, :), b(:), x(:), work(:), rest(:)
      real(wp) :: residual
      integer :: i, n, status

      do i = 1, 500
         n = draw_integer(random, 2, 12)
         allocate (a(2*n, n + 2), b(2*n))
         call random_matrix(a)
         call fill(random, -1.0_wp, 1.0_wp, b)
         qr = a
         x = b
         allocate (work(least_squares_work(2*n, n + 2)))
         call least_squares(qr, x, work, residual, status)
         call check(status == stat%ok, 'a random least squares problem has full rank')
         rest = misfit(a, x(:n + 2), b)
         call check_close(residual, norm2(rest), 1e-12_wp*(1 + maxval(abs(x))), &
            'norm of the residual')
         call check_close(maxval(abs(matmul(transpose(a), rest))), 0.0_wp, &
            1e-12_wp*(1 + maxval(abs(x))), 'the residual is orthogonal to the columns')
         qr = a
         qr(:, n + 2) = qr(:, 1) - 3*qr(:, 2)
         x = b
         call least_squares(qr, x, work, residual, status)
         call check(status == stat%singular, 'dependent columns are singular')
         deallocate (a, b, work)
      end do
   end subroutine test_least_squares

   !> Both solutions, the sign of the determinant, and the scaled size of the right side; a singular
   !! system is reported.
   subroutine test_eliminate()
      real(wp) :: a(most, most), copy(most, most), b(2, most), right(2, most), residual, wanted
      logical :: regular
      integer :: i, j, n, orientation

      do i = 1, 500
         n = draw_integer(random, 1, merge(most, 8, mod(i, 50) == 0))
         a = huge(1.0_wp)
         call random_matrix(a(:n, :n))
         call random_matrix(b)
         do j = 1, n
            a(:n, j) = a(:n, j)*10.0_wp**draw_integer(random, -9, 9)
         end do
         copy = a
         right = b
         wanted = maxval([(abs(b(1, j))/maxval(abs(a(:n, j))), j=1, n)])
         call eliminate(n, a, b, regular, residual, orientation)
         call check(regular, 'eliminate: a random matrix is regular')
         call check_close(residual, wanted, 1e-14_wp*wanted, 'eliminate: residual')
         call check(orientation == nint(sign(1.0_wp, determinant(copy(:n, :n)))), &
            'eliminate: orientation')
         do j = 1, n
            call check(all(abs(matmul(b(:, :n), copy(:n, j)) - right(:, j)) <= &
               1e-12_wp*maxval(abs(copy(:n, j)))*(1 + maxval(abs(b(:, :n))))), &
               'eliminate: solution')
         end do
         ! two equivalent equations
         if (n == 1) cycle
         a = copy
         a(:n, n) = 2*a(:n, 1)
         b = right
         call eliminate(n, a, b, regular, residual, orientation)
         call check(.not. regular .and. orientation == 0, 'eliminate: dependent equations')
         ! an equation without coefficients: the residual is that of the equations before it
         a = copy
         a(:n, n) = 0
         b = right
         wanted = maxval([(abs(b(1, j))/maxval(abs(a(:n, j))), j=1, n - 1)])
         call eliminate(n, a, b, regular, residual, orientation)
         call check(.not. regular .and. orientation == 0, 'eliminate: an empty equation')
         call check_close(residual, wanted, 1e-14_wp*wanted, 'eliminate: residual before it')
         a = copy
         a(:n, 1) = 0
         residual = 7
         call eliminate(n, a, b, regular, residual)
         call check_close(residual, 0.0_wp, 0.0_wp, 'eliminate: no equation before it')
      end do
   end subroutine test_eliminate

   !> Sum, sum of squares and product of the eigenvalues are invariants of the matrix.
   subroutine test_eigenvalues()
      real(wp) :: a(4, 4), copy(4, 4), square(4, 4)
      complex(wp) :: lambda(4)
      integer :: i, j, status

      do i = 1, 2000
         call random_matrix(a)
         copy = a
         call eigenvalues(copy, lambda, status)
         call check(status == stat%ok, 'eigenvalues are found')
         square = matmul(a, a)
         call check_close(abs(sum(lambda) - sum([(a(j, j), j=1, 4)])), 0.0_wp, 1e-13_wp, 'trace')
         call check_close(abs(sum(lambda**2) - sum([(square(j, j), j=1, 4)])), 0.0_wp, 1e-13_wp, &
            'trace of the square')
         call check_close(abs(product(lambda) - determinant(a)), 0.0_wp, 1e-13_wp, 'determinant')
      end do
   end subroutine test_eigenvalues

   !> Results equal those of the drivers, also with scaling and eigenvalues isolated by balancing.
   subroutine test_drivers()
      real(wp) :: a(6, 4), b(6), c(6, 4), d(6), work(300), unused(1, 1), unit
      real(wp) :: p(4, 4), q(4, 4), real_part(4), imaginary_part(4), residual
      complex(wp) :: lambda(4)
      integer :: i, pivot(4), info, status

      do i = 1, 1000
         call random_matrix(p)
         if (mod(i, 3) == 0) p(2:, 1) = 0
         if (mod(i, 5) == 0) p(4, :3) = 0
         unit = 1
         if (mod(i, 7) == 0) unit = 2.0_wp**(maxexponent(unit) - 10)
         if (mod(i, 7) == 1) unit = 2.0_wp**(minexponent(unit) + 60)
         p = p*unit
         q = p
         call geev('N', 'N', 4, q, 4, real_part, imaginary_part, unused, 1, unused, 1, work, &
            size(work), info)
         q = p
         call eigenvalues(q, lambda, status)
         call check(status == stat%ok, 'drivers: eigenvalues')
         call check_close(maxval(abs(lambda/unit - cmplx(real_part/unit, imaginary_part/unit, &
            wp))), 0.0_wp, 1.0e-13_wp, 'drivers: xGEEV')
         call random_matrix(p)
         a(:4, :) = p
         call random_matrix(p)
         a(5:, :) = p(:2, :)
         b = a(:, 1) + p(1, 1)
         c = a*unit
         d = b*unit
         call gels('N', 6, 4, 1, c, 6, d, 6, work, size(work), info)
         c = a*unit
         b = b*unit
         call least_squares(c, b, work, residual, status)
         call check_close(maxval(abs(b(:4) - d(:4))), 0.0_wp, 1.0e-12_wp*(1 + maxval(abs(d(:4)))), &
            'drivers: xGELS')
         q = p
         d = a(:, 2)
         call gesv(4, 1, q, 4, pivot, d, 4, info)
         b = a(:, 2)
         call solve(p, b(:4), status)
         call check_close(maxval(abs(b(:4) - d(:4))), 0.0_wp, 1.0e-12_wp*(1 + maxval(abs(d(:4)))), &
            'drivers: xGESV')
      end do
   end subroutine test_drivers

   !> A similarity transform of a known block diagonal matrix keeps its eigenvalues.
   subroutine test_known_eigenvalues()
      real(wp) :: d(4, 4), t(4, 4), inverse(4, 4), copy(4, 4), column(4)
      complex(wp) :: lambda(4), expected(4)
      integer :: i, j, status

      do i = 1, 500
         d = 0
         d(1, 1) = draw(random, -1.0_wp, 1.0_wp)
         d(2, 2) = draw(random, 2.0_wp, 3.0_wp)
         d(3, 3) = draw(random, -1.0_wp, 1.0_wp)
         d(3, 4) = draw(random, 1.0_wp, 2.0_wp)
         d(4, 3) = -d(3, 4)
         d(4, 4) = d(3, 3)
         expected = [cmplx(d(1, 1), 0, wp), cmplx(d(2, 2), 0, wp), cmplx(d(3, 3), d(3, 4), wp), &
            cmplx(d(3, 3), -d(3, 4), wp)]
         call random_matrix(t)
         do j = 1, 4
            t(j, j) = t(j, j) + 4                  ! well conditioned
         end do
         do j = 1, 4
            copy = t
            column = 0
            column(j) = 1
            call solve(copy, column, status)
            inverse(:, j) = column
         end do
         copy = matmul(matmul(inverse, d), t)
         call eigenvalues(copy, lambda, status)
         do j = 1, 4
            call check_close(minval(abs(lambda - expected(j))), 0.0_wp, 1e-12_wp, &
               'known eigenvalue')
         end do
      end do
   end subroutine test_known_eigenvalues

   !> The eigenvalues of a triangle are its diagonal, exactly, in any order of the unknowns.
   subroutine test_triangles()
      integer, parameter :: orders(4, 4) = reshape([1, 2, 3, 4, 4, 3, 2, 1, 2, 4, 1, 3, 3, 1, 4, &
         2], [4, 4])
      real(wp) :: a(4, 4)
      complex(wp) :: lambda(4)
      integer :: i, j, k, status

      do k = 1, size(orders, 2)
         do j = 1, 4
            do i = 1, 4
               a(orders(i, k), orders(j, k)) = merge(draw(random, 0.5_wp, 2.0_wp), 0.0_wp, i < j)
            end do
            a(orders(j, k), orders(j, k)) = j - 2
         end do
         call eigenvalues(a, lambda, status)
         call check(status == stat%ok .and. all(abs(lambda%im) <= 0), 'triangle: real')
         do j = 1, 4
            call check(count(abs(lambda%re - (j - 2)) <= 0) == 1, 'triangle: its diagonal')
         end do
      end do
   end subroutine test_triangles

   !> Equal differences or ratios, and both ends to the last bit.
   subroutine test_spacing()
      real(wp) :: low, high, place
      real(wp) :: axis(40), ratios(40)
      integer :: i, j, n

      do i = 1, 300
         n = draw_integer(random, 2, 40)
         low = draw(random, 0.1_wp, 1.0_wp)
         high = draw(random, 1.0_wp, 100.0_wp)
         axis(:n) = even(low, high, n)
         ratios(:n) = spaced(low, high, n, .true.)
         call check(.not. any(abs(axis(:n) - spaced(low, high, n, .false.)) > 0), 'spacing: even')
         call check(.not. any(abs([axis(1) - low, axis(n) - high, ratios(1) - low, ratios(n) &
            - high]) > 0), 'spacing: both ends')
         do j = 1, n
            place = real(j - 1, wp)/(n - 1)
            call check_close(axis(j), low + place*(high - low), 1e-14_wp*high, &
               'spacing: equal differences')
            call check_close(ratios(j), low*(high/low)**place, 1e-13_wp*high, &
               'spacing: equal ratios')
         end do
      end do
   end subroutine test_spacing

   !> Every code has its own text, within the 200 characters of the interface.
   subroutine test_status()
      integer, parameter :: codes(*) = [stat%ok, stat%singular, stat%free_amplitude, stat%no_load, &
         stat%zero_approach, stat%lapack_failed, stat%not_finite, stat%no_motion, &
         stat%more_events, stat%budget, stat%no_convergence, stat%lost_digits, stat%not_computed, &
         stat%event_limit, stat%no_memory, stat%mass_not_definite, stat%negative_stiffness, &
         stat%defective, stat%resonance, stat%coupled_impacts, stat%gap_closed, &
         stat%no_impacts, stat%no_period, stat%extreme_units, &
         stat%not_stable, stat%fold, stat%graze, stat%not_exact, stat%coincident, &
         stat%not_smooth, stat%no_extremum, stat%shorter_period, stat%symmetric, &
         stat%dependent_rests, stat%unbalanced, stat%too_stiff, &
         stat%permanent_rest, stat%narrow_gap, stat%stop_holds, &
         stat%friction_rests, stat%friction_undecided, stat%permanent_stick, &
         stat%no_derivative, stat%endless_sequence, stat%gains_energy, stat%dependent_friction]
      character(:), allocatable :: text, nonsense
      integer :: i, j

      nonsense = status_text(-1)
      do i = 1, size(codes)
         text = status_text(codes(i))
         call check(len_trim(text) > 0 .and. len(text) <= 200, 'a text of 1 to 200 characters')
         call check(text /= nonsense, 'every code has a text')
         do j = 1, i - 1
            call check(codes(i) /= codes(j), 'codes differ')
            call check(status_text(codes(j)) /= text, 'texts differ')
         end do
      end do
      call check(status_text(maxval(codes) + 1) == nonsense, 'no code after the last')
      call check(stat%ok == 0, 'success is 0')
   end subroutine test_status

   subroutine random_matrix(matrix)
      real(wp), intent(out) :: matrix(:, :)
      integer :: i

      do i = 1, size(matrix, 2)
         call fill(random, -1.0_wp, 1.0_wp, matrix(:, i))
      end do
   end subroutine random_matrix

end program test_numerics
