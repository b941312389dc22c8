!> Motions side by side in lanes, compared with the scalar procedures and with laws.
module motions_lanes
   use checks, only: check, check_close
   use motions_characteristic, only: is_contraction
   use random_numbers, only: draw, draw_log, random_type
   use random_systems, only: pi, random_frequency, random_motion, random_phases
   use vi_characteristic, only: characteristic
   use vi_new_plan, only: new_plan
   use vi_impact_map, only: impact_maps
   use vi_kinds, only: wp
   use vi_lane_least_squares, only: lane_least_squares
   use vi_lane_motion, only: lane_chain
   use vi_lane_spectrum, only: lane_circle, lane_polynomial, lane_radius
   use vi_lane_verdicts, only: lane_verdicts
   use vi_lane_verdicts_wide, only: lane_verdicts_wide => lane_verdicts
   use vi_lanes, only: largest_angle, largest_exponent, shrinkage, sine_cosine, sines_cosines
   use vi_lapack, only: eigenvalues, least_squares, least_squares_work
   use vi_motion, only: motion_type
   use vi_periodic, only: linear_system_type, solve_periodic
   use vi_plan, only: lanes, plan_type, unsure
   use vi_processor, only: runs_wide
   use vi_stability, only: stability_matrix
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: test_lanes

   type(random_type) :: random

contains

   subroutine test_lanes()
      call test_functions()
      call test_equations()
      call test_spectra()
      call test_equal_products()
      call test_maps(2)
      call test_maps(3)
      call test_maps(5)
   end subroutine test_lanes

   !> The functions agree with the intrinsic ones to two units in the last place of 1.
   subroutine test_functions()
      real(wp), dimension(lanes) :: x, sine, cosine, some, others
      integer :: i, l

      do i = 1, 2000
         do l = 1, lanes
            x(l) = draw_log(random, 1.0e-6_wp, largest_angle)*sign(1, mod(l, 2) - 1)
         end do
         if (i == 1) x(:4) = [0.0_wp, 0.5_wp*pi, pi, 1.5_wp*pi]
         call sine_cosine(x, sine, cosine)
         call check_close(maxval(abs(sine - sin(x))), 0.0_wp, 2*epsilon(1.0_wp), 'lanes: sine')
         call check_close(maxval(abs(cosine - cos(x))), 0.0_wp, 2*epsilon(1.0_wp), 'lanes: cosine')
         l = 1 + mod(i, lanes)
         call sines_cosines(l, x, some, others)
         call check(all(abs(some(:l) - sine(:l)) + abs(others(:l) - cosine(:l)) <= 0), &
            'lanes: as many sines and cosines as are wanted')
         x = min(abs(x), largest_exponent)
         call shrinkage(x, sine)
         call check_close(maxval(abs(sine/exp(-x) - 1)), 0.0_wp, 4*epsilon(1.0_wp), 'lanes: exp')
      end do
   end subroutine test_functions

   !> Overdetermined systems, compared with QR by LAPACK.
   subroutine test_equations()
      integer, parameter :: m = 7, n = 4
      real(wp) :: system(lanes, m, n + 1), a(m, n), b(m), work(least_squares_work(m, n))
      real(wp) :: x(lanes, n), residual(lanes), total(lanes), quality(lanes), rest, size_b
      real(wp) :: copy(lanes, m, n + 1)
      integer :: i, j, k, l, status

      do k = 1, 200
         do j = 1, n + 1
            do i = 1, m
               do l = 1, lanes
                  system(l, i, j) = draw(random, -1.0_wp, 1.0_wp)
               end do
            end do
         end do
         copy = system
         call lane_least_squares(m, n, system, x, residual, total, quality)
         do l = 1, lanes
            a = copy(l, :, :n)
            b = copy(l, :, n + 1)
            size_b = norm2(b)
            call least_squares(a, b, work, rest, status)
            call check_close(maxval(abs(x(l, :) - b(:n))), 0.0_wp, &
               1.0e-14_wp*(1 + maxval(abs(b(:n))))/quality(l)**2, 'lanes: least squares')
            call check_close(sqrt(residual(l)), rest, 1.0e-14_wp/quality(l), 'lanes: residual')
            call check_close(sqrt(total(l)), size_b, 1.0e-14_wp, 'lanes: right side')
         end do
      end do
      copy(:, :, 2) = copy(:, :, 1)
      call lane_least_squares(m, n, copy, x, residual, total, quality)
      call check(.not. any(quality > 1.0e-12_wp), 'lanes: dependent columns')
   end subroutine test_equations

   !> Polynomial, Jury's conditions and radius of matrices of every size, compared with eigenvalues.
   subroutine test_spectra()
      real(wp) :: p(lanes, 4, 4), e(lanes, 4), largest(lanes), terms(lanes), least(lanes), &
         radius(lanes), &
         slope(lanes), doubt(lanes), one(4, 4), e_twice(lanes, 4), twice(lanes, 2), scale, noise
      complex(wp) :: lambda(4)
      integer :: i, j, k, l, status, given

      given = 0
      do k = 1, 1000
         scale = draw_log(random, 0.3_wp, 30.0_wp)
         do j = 1, 4
            do i = 1, 4
               do l = 1, lanes
                  p(l, i, j) = draw(random, -scale, scale)
               end do
            end do
         end do
         call lane_polynomial(p, e, largest, terms)
         call lane_circle(e, largest, least, doubt)
         call lane_radius(e, radius, slope)
         ! all terms of a coefficient have the same degree
         call lane_polynomial(2*p, e_twice, twice(:, 1), twice(:, 2))
         call check(.not. any(abs(twice(:, 1) - 2*largest) > 0 &
            .or. abs(twice(:, 2) - 16*terms) > 0 &
            .or. maxval(abs(e_twice - e*spread([2, 4, 8, 16], 1, lanes)), 2) > 0), &
            'lanes: a matrix twice as large')
         call check(all(abs(e(:, 4)) <= terms*(1 + 1e-14_wp)), 'lanes: terms of the determinant')
         do l = 1, lanes
            one = p(l, :, :)
            call check_close(maxval(abs(e(l, :) - characteristic(one))), 0.0_wp, &
               1.0e-13_wp*max(1.0_wp, scale)**4, 'lanes: polynomial')
            call eigenvalues(one, lambda, status)
            if (abs(maxval(abs(lambda)) - 1) > 1.0e-9_wp) call check((least(l) > 0) .eqv. &
               is_contraction(e(l, :)), 'lanes: inside the circle')
            if (.not. slope(l) > 0) cycle
            noise = largest(l)**3*(radius(l) + largest(l))/(slope(l)*radius(l))
            if (.not. noise < 1.0e4_wp) cycle
            given = given + 1
            call check_close(radius(l), maxval(abs(lambda)), &
               100*(1 + noise)*epsilon(1.0_wp)*radius(l), &
               'lanes: radius')
            ! the polynomial's derivative at a zero is the product of the distances to the others
            j = maxloc(abs(lambda), 1)
            if (count(abs(lambda) > (1 - 1e-6_wp)*abs(lambda(j))) > merge(2, 1, &
               abs(lambda(j)%im) > 0)) cycle
            call check_close(slope(l), product(abs(lambda(j) - lambda), [(i /= j, i=1, 4)]), &
               1.0e-6_wp*slope(l) + 1.0e-12_wp*radius(l)**3, 'lanes: slope at the radius')
         end do
      end do
      call check(given > 20000, 'lanes: most radii are given')
   end subroutine test_spectra

   !> Radii where both pairs of multipliers have nearly the same product, as with little damping.
   subroutine test_equal_products()
      real(wp) :: e(lanes, 4), radius(lanes), slope(lanes), wanted(lanes), f(2, 2), noise, largest
      complex(wp) :: root
      integer :: i, k, l, given

      given = 0
      do k = 1, 300
         do l = 1, lanes
            ! x^2 + f(1, i) x + f(2, i)
            f(1, :) = [draw(random, -2.0_wp, 2.0_wp), draw(random, -2.0_wp, 2.0_wp)]
            f(2, 1) = draw(random, -1.0_wp, 1.0_wp)
            f(2, 2) = f(2, 1)*(1 - draw_log(random, 1e-14_wp, 0.1_wp))
            e(l, :) = [-f(1, 1) - f(1, 2), f(2, 1) + f(2, 2) + f(1, 1)*f(1, 2), &
               -f(1, 1)*f(2, 2) - f(1, 2)*f(2, 1), f(2, 1)*f(2, 2)]
            wanted(l) = 0
            do i = 1, 2
               root = sqrt(cmplx(0.25_wp*f(1, i)**2 - f(2, i), 0.0_wp, wp))
               wanted(l) = max(wanted(l), abs(root + 0.5_wp*f(1, i)), &
                  abs(root - 0.5_wp*f(1, i)))
            end do
         end do
         call lane_radius(e, radius, slope)
         do l = 1, lanes
            if (.not. slope(l) > 0) cycle
            largest = max(1.0_wp, radius(l))
            noise = largest**3*(radius(l) + largest)/(slope(l)*radius(l))
            if (.not. noise < 1.0e3_wp) cycle
            given = given + 1
            call check_close(radius(l), wanted(l), 100*(1 + noise)*epsilon(1.0_wp)*radius(l), &
               'lanes: radius of equal products')
         end do
      end do
      call check(given > 8700, 'lanes: most of these radii are given')
   end subroutine test_equal_products

   !> [P] equals that of the scalar procedures; its determinant is the product of the multipliers,
   !! and of two-impact motions exp(-4 pi xi k/r) R_1^2 R_2^2; both builds give the same bits.
   !!
   !! The quality does not account for digits that cancel in the product of the [P_i]. They are lost
   !! in proportion to the product of the moduli of the [P_i] over [P]: up to 10^4 for five impacts.
   !! Both methods lose them: for two million motions they differed by at most 19 epsilon/quality
   !! times that, and neither was nearer to 50-digit arithmetic than the other.
   subroutine test_maps(n)
      integer, intent(in) :: n
      type(motion_type) :: motion
      type(linear_system_type) :: linear
      type(plan_type) :: plan
      real(wp) :: r(lanes), phases(lanes, n), system(lanes, 2*n, n + 3), x(lanes, n + 2), &
         flight(lanes, 7, n), p(lanes, 4, 4), reference(4, 4), e(lanes, 4), largest(lanes), &
         terms(lanes), &
         residual(lanes), quality(lanes), radius(lanes, 2), unit(4), error, parts(4, 4, n), sums(4)
      complex(wp) :: lambda(4)
      integer :: decided, i, j, l, status, verdicts(lanes, 2, 2)
      logical :: regular

      decided = 0
      do i = 1, 300
         call random_motion(random, n, motion)
         plan = new_plan(motion%osc, motion%pattern, motion%restitution, 0.03_wp)
         do l = 1, lanes
            r(l) = random_frequency(random)
            call random_phases(random, motion%pattern%cycles, phases(l, :))
         end do
         call lane_chain(plan, n, 2*n, r, phases, system, x, flight, p, residual, quality)
         call lane_polynomial(p, e, largest, terms)
         do l = 1, lanes
            call solve_periodic(motion%osc, r(l), motion%pattern, motion%restitution, &
               phases(l, :), linear, motion)
            if (motion%status /= stat%ok .or. .not. quality(l) > 1.0e-4_wp) cycle
            call stability_matrix(motion, reference, status)
            unit = [1.0_wp, 1.0_wp, 1.0_wp, 1/motion%clearance]
            do j = 1, 4
               reference(:, j) = reference(:, j)*unit(j)/unit
            end do
            call impact_maps(motion, parts, regular)
            sums = unit
            do j = 1, n
               sums = matmul(abs(parts(:, :, j)), sums)
            end do
            error = 1.0e-13_wp/quality(l)
            call check_close(maxval(abs(p(l, :, :) - reference)), 0.0_wp, &
               3.0e-14_wp/quality(l)*maxval(sums/unit), 'lanes: [P]')
            call check_close(sqrt(residual(l)), motion%residual, 1.0e-12_wp/quality(l), &
               'lanes: residual of the motion')
            call eigenvalues(reference, lambda, status)
            call check_close(abs(e(l, 4) - product(lambda)), 0.0_wp, error*largest(l)**4, &
               'lanes: determinant and multipliers')
            if (n == 2) call check_close(e(l, 4), exp(-4*pi*plan%xi*motion%pattern%cycles/r(l)) &
               *product(motion%restitution**2), error*largest(l)**4, 'lanes: determinant')
         end do
         call lane_verdicts(plan, n, 2*n, r, phases, .true., system, x, flight, &
            verdicts(:, 1, 1), verdicts(:, 2, 1), radius(:, 1))
         call check(all(verdicts(:, :, 1) >= unsure .and. verdicts(:, :, 1) <= 1), &
            'lanes: verdicts are yes, no or unsure')
         decided = decided + count(verdicts(:, 2, 1) /= unsure)
         ! two impacts have as many unknowns as equations: they are consistent to any accuracy
         plan%acceptance = 0
         call lane_verdicts(plan, n, 2*n, r, phases, .false., system, x, flight, &
            verdicts(:, 1, 2), verdicts(:, 2, 2), radius(:, 2))
         call check(all(verdicts(:, 1, 2) == merge(1, 0, n == 2) .or. (n > 2 .and. &
            verdicts(:, 1, 2) == unsure)), 'lanes: nothing is accepted but what is exact')
         call check(all(verdicts(:, 2, 2) == verdicts(:, 2, 1) .or. verdicts(:, 2, 1) == unsure), &
            'lanes: stability does not depend on the radius that is wanted')
         if (n > 2) call check_near_acceptance()
         plan%acceptance = 0.03_wp
         if (runs_wide() == 0) cycle
         call lane_verdicts_wide(plan, n, 2*n, r, phases, .true., system, x, flight, &
            verdicts(:, 1, 2), verdicts(:, 2, 2), radius(:, 2))
         call check(all(verdicts(:, :, 1) == verdicts(:, :, 2)), 'lanes: the same verdicts')
         call check(all(transfer(radius(:, 1), [0]) == transfer(radius(:, 2), [0])), &
            'lanes: the same bits')
      end do
      call check(decided > 0.75_wp*300*lanes, 'lanes: most are stable or unstable')
   contains
      !> For more than two impacts a residual next to the acceptance limit decides nothing.
      subroutine check_near_acceptance()
         real(wp), parameter :: apart(5) = [-1.1e-9_wp, -0.9e-9_wp, 0.0_wp, 0.9e-9_wp, 1.1e-9_wp]
         integer :: k

         do k = 1, size(apart)
            plan%acceptance = sqrt(residual(1)) + apart(k)
            call lane_verdicts(plan, n, 2*n, r, phases, .false., system, x, flight, &
               verdicts(:, 1, 2), verdicts(:, 2, 2), radius(:, 2))
            call check(verdicts(1, 1, 2) == merge(unsure, merge(1, 0, k == 5), abs(k - 3) < 2), &
               'lanes: near the acceptance limit')
         end do
      end subroutine check_near_acceptance
   end subroutine test_maps

end module motions_lanes
