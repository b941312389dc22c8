!> Structures with gaps: laws of restitution, flights by pairs, and chains.
module mechanics_structure
   use checks, only: check, check_close
   use random_numbers, only: draw, random_type
   use random_systems, only: determinant
   use vi_kinds, only: wp
   use vi_lapack, only: eigenvalues
   use vi_modes, only: advance, step_functions
   use vi_restitution, only: constant_law, friction_law, greatest_below, new_restitution, &
      power_law, pushing_law, restitution_at, restitution_type, table_law
   use vi_status, only: stat
   use vi_structure, only: check_structure, inputs_of, load_type, new_load, new_regime, &
      new_structure, regime_type, renew_regime, state_of, structure_type, to_pairs
   implicit none (type, external)
   private

   public :: test_structure

contains

   subroutine test_structure()
      call test_restitution()
      call test_restitution_at_rest()
      call test_tables()
      call test_first_slopes()
      call test_flight(.false.)
      call test_flight(.true.)
      call test_coinciding()
      call test_responses()
      call test_refusals()
      call test_renewal()
   end subroutine test_structure

   !> Values in [0, 1], and slopes by differences.
   subroutine test_restitution()
      type(restitution_type) :: law
      real(wp), parameter :: h = 1.0e-6_wp
      real(wp) :: value, slope, above, below, unused
      integer :: i, j

      do j = 1, 2
         if (j == 1) then
            law = new_restitution(real(power_law, wp), [0.9_wp, 0.5_wp, 0.25_wp, 2.0_wp])
         else
            law = new_restitution(real(table_law, wp), [3.0_wp, 0.0_wp, 1.0_wp, 2.0_wp, 0.9_wp, &
               0.7_wp, 0.6_wp])
         end if
         do i = 0, 60
            call restitution_at(law, 0.05_wp*i + h, above, unused)
            call restitution_at(law, abs(0.05_wp*i - h), below, unused)
            call restitution_at(law, 0.05_wp*i, value, slope)
            call check(value >= 0 .and. value <= 1, 'R is in [0, 1]')
            if (i > 0) call check_close(slope, (above - below)/(2*h), 1.0e-5_wp, 'slope of R')
         end do
      end do
   end subroutine test_restitution

   !> Tables that rise and fall: the greatest R below a speed, compared with many samples, and the
   !! slope between the points by differences.
   subroutine test_tables()
      integer, parameter :: samples = 1201
      real(wp), parameter :: last = 3.0_wp, h = 1.0e-6_wp
      real(wp) :: values(4), speed, value, slope, greatest, above, below, unused
      type(restitution_type) :: law
      type(random_type) :: random
      integer :: i, j

      do i = 1, 40
         do j = 1, size(values)
            values(j) = draw(random, 0.0_wp, 1.0_wp)
         end do
         ! a table starts at 0 or later; R is constant outside
         law = new_restitution(real(table_law, wp), [4.0_wp, 0.4_wp*mod(i, 2), 1.0_wp, 1.5_wp, &
            2.0_wp, values])
         greatest = 0
         do j = 0, samples
            speed = j*last/samples
            call restitution_at(law, speed, value, slope)
            greatest = max(greatest, value)
            call check_close(greatest_below(law, speed), greatest, 1.0e-4_wp, &
               'the greatest R below a speed')
            if (j == 0) cycle
            call restitution_at(law, speed + h, above, unused)
            call restitution_at(law, speed - h, below, unused)
            call check_close(slope, (above - below)/(2*h), 1.0e-4_wp, 'slope of R between points')
         end do
      end do
   end subroutine test_tables

   !> The slope at speed 0 is that of the parabola through three points, of either sign, but not
   !! beyond 0, nor beyond three times the first chord; of two points it is that of the line.
   subroutine test_first_slopes()
      real(wp), parameter :: seconds(4) = [0.2_wp, 1.0_wp, 3.5_wp, -1.2_wp], &
         expected(4) = [1.4_wp, 1.0_wp, 0.0_wp, 2.1_wp]
      type(restitution_type) :: law
      real(wp) :: chord, value, slope
      integer :: i, k

      do k = -1, 1, 2
         chord = 0.1_wp*k
         do i = 1, size(seconds)
            law = new_restitution(real(table_law, wp), [3.0_wp, 0.0_wp, 1.0_wp, 2.0_wp, 0.5_wp, &
               0.5_wp + chord, 0.5_wp + chord*(1 + seconds(i))])
            call restitution_at(law, 0.0_wp, value, slope)
            call check_close(slope, chord*expected(i), 1e-14_wp, 'tables: the first slope')
         end do
         ! a bend soon after the second point makes the parabola steep
         law = new_restitution(real(table_law, wp), [3.0_wp, 0.0_wp, 1.0_wp, 1.25_wp, 0.5_wp, &
            0.5_wp + chord, 0.5_wp - 2*chord])
         call restitution_at(law, 0.0_wp, value, slope)
         call check_close(slope, 3*chord, 1e-14_wp, 'tables: the first slope is limited')
         law = new_restitution(real(table_law, wp), [2.0_wp, 0.0_wp, 1.0_wp, 0.5_wp, &
            0.5_wp + chord])
         call restitution_at(law, 0.0_wp, value, slope)
         call check_close(slope, chord, 1e-14_wp, 'tables: the slope of a line')
      end do
   end subroutine test_first_slopes

   !> The slope at v = 0 is the limit of difference quotients, which may be infinite.
   subroutine test_restitution_at_rest()
      real(wp), parameter :: exponents(5) = [0.5_wp, 0.9_wp, 1.0_wp, 1.5_wp, 2.0_wp]
      real(wp) :: value, slope, near, unused, quotient(3), h, numbers(4)
      type(restitution_type) :: law
      integer :: i, j, k

      do i = 0, 3
         do j = 1, size(exponents)
            numbers = [merge(0.0_wp, 0.8_wp, i == 1), 0.4_wp, merge(0.0_wp, 0.3_wp, i == 2), &
               exponents(j)]
            law = new_restitution(real(power_law, wp), numbers)
            call restitution_at(law, 0.0_wp, value, slope)
            call check_close(value, numbers(1), 0.0_wp, 'R at v = 0')
            do k = 1, 3
               h = 10.0_wp**(-3*k)
               call restitution_at(law, h, near, unused)
               quotient(k) = (near - value)/h
            end do
            if (abs(quotient(3)) > 1.5_wp*abs(quotient(2))) then
               call check(slope <= -huge(1.0_wp), 'an infinite slope of R at v = 0')
            else
               call check_close(slope, quotient(3), 1.0e-4_wp, 'slope of R at v = 0')
            end if
         end do
      end do
   end subroutine test_restitution_at_rest

   !> Two successive flights are one flight; pairs and coordinates are inverse maps; the energy of
   !! an undamped structure is constant, and the map of the state has the determinant
   !! exp(-trace(M^-1 C) t).
   subroutine test_flight(damped)
      !> Whether damping couples the modes.
      logical, intent(in) :: damped
      integer, parameter :: n = 4
      type(random_type) :: random
      type(structure_type) :: structure
      type(load_type) :: load
      type(regime_type) :: regime, plain
      real(wp) :: matrices(n, n, 3), a(n, n), directions(n, 1), q(n), rate(n), q_back(n), &
         rate_back(n), x(n), v(n), x_half(n), v_half(n), x_all(n), v_all(n), map(2*n, 2*n), &
         state(2*n)
      real(wp), parameter :: time = 0.7_wp
      integer :: i, j, k, status

      do k = 1, 3
         do j = 1, n
            do i = 1, n
               a(i, j) = draw(random, -0.5_wp, 0.5_wp)
            end do
         end do
         matrices(:, :, k) = matmul(a, transpose(a))
         do i = 1, n
            matrices(i, i, k) = matrices(i, i, k) + 0.3_wp
         end do
      end do
      matrices(:, :, 2) = merge(0.1_wp, 0.0_wp, damped)*matrices(:, :, 2)
      directions(:, 1) = [1.0_wp, -1.0_wp, 0.0_wp, 0.0_wp]
      structure = new_structure(matrices, directions, reshape([1.0_wp, 0.5_wp], [2, 1]))
      call check_structure(structure, status)
      call check(status == stat%ok, 'a structure is accepted')
      load = new_load(0.0_wp, reshape([real(wp) ::], [n, 2, 0]), [(0.0_wp, i=1, n)])
      call new_regime(structure, load, [integer ::], regime, status)
      call check(status == stat%ok, 'its motion is found')
      do i = 1, 2*n
         state = 0
         state(i) = 1
         q = state(:n)
         rate = state(n + 1:)
         call to_pairs(regime, 0.0_wp, q, rate, x, v)
         call state_of(regime, 0.0_wp, x, v, q_back, rate_back)
         call check(maxval(abs(q - q_back)) + maxval(abs(rate - rate_back)) < 1.0e-12_wp, &
            'from coordinates to pairs and back')
         call advance(regime%modes, 0.5_wp*time, x, v, x_half, v_half)
         call advance(regime%modes, 0.5_wp*time, x_half, v_half, x_all, v_all)
         call advance(regime%modes, time, x, v, x_half, v_half)
         call check(maxval(abs(x_all - x_half)) + maxval(abs(v_all - v_half)) < 1.0e-12_wp, &
            'two flights are one')
         call state_of(regime, 0.0_wp, x_half, v_half, q_back, rate_back)
         map(:, i) = [q_back, rate_back]
         ! without wide registers, and one coordinate at a time
         plain = regime
         plain%coordinates%wide = .false.
         call state_of(plain, 0.0_wp, x_half, v_half, q, rate)
         call check(all(transfer([q, rate], [0]) == transfer([q_back, rate_back], [0])), &
            'a state with plain registers')
         call check(maxval(abs(q - matmul(regime%qx, x_half) - matmul(regime%qv, v_half))) + &
            maxval(abs(rate - matmul(regime%dx, x_half) - matmul(regime%dv, v_half))) < 1e-13_wp, &
            'a state by the products of matrices')
         if (.not. damped) call check_close(energy(q_back, rate_back), energy(state(:n), &
            state(n + 1:)), 1.0e-12_wp, 'energy is kept')
      end do
      call check_close(determinant(map), exp(-time*2*sum(regime%modes%damping)), 1.0e-11_wp, &
         'the determinant of a flight')
   contains
      !> Kinetic and elastic energy.
      real(wp) function energy(q, rate)
         !> (n) Coordinates and velocities.
         real(wp), intent(in) :: q(n), rate(n)

         energy = 0.5_wp*dot_product(rate, matmul(matrices(:, :, 1), rate)) &
            + 0.5_wp*dot_product(q, matmul(matrices(:, :, 3), q))
      end function energy
   end subroutine test_flight

   !> Two real eigenvalues that meet as damping grows, with their eigenvectors: a flight near there,
   !! compared with the exponential of the matrix.
   subroutine test_coinciding()
      integer, parameter :: n = 2
      real(wp), parameter :: offsets(9) = [-1.0e-3_wp, -1.0e-6_wp, -1.0e-9_wp, -1.0e-12_wp, &
         0.0_wp, 1.0e-12_wp, 1.0e-9_wp, 1.0e-6_wp, 1.0e-3_wp], time = 1.3_wp
      type(structure_type) :: structure
      type(regime_type) :: regime
      complex(wp) :: lambda(2*n)
      real(wp) :: matrices(n, n, 3), a(2*n, 2*n), unit(n, n), range(2), middle, error, &
         map(2*n, 2*n), state(2*n), x(n), v(n), x_now(n), v_now(n)
      integer :: i, k, status

      unit = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [n, n])
      range = [0.1_wp, 3.0_wp]
      do i = 1, 60
         middle = 0.5_wp*sum(range)
         call set_matrices(middle)
         call eigenvalues(a, lambda, status)
         range(merge(1, 2, all(abs(lambda%im) > 0))) = middle
      end do
      do k = 1, size(offsets)
         call set_matrices(range(1)*(1 + offsets(k)))
         structure = new_structure(matrices, reshape([1.0_wp, -1.0_wp], [n, 1]), &
            reshape([1.0_wp, 0.5_wp], [2, 1]))
         call check_structure(structure, status)
         call new_regime(structure, new_load(0.0_wp, reshape([real(wp) ::], [n, 2, 0]), &
            [0.0_wp, 0.0_wp]), [integer ::], regime, status)
         call check(status == stat%ok, 'coinciding eigenvalues')
         do i = 1, 2*n
            state = 0
            state(i) = 1
            call to_pairs(regime, 0.0_wp, state(:n), state(n + 1:), x, v)
            call advance(regime%modes, time, x, v, x_now, v_now)
            call state_of(regime, 0.0_wp, x_now, v_now, map(:n, i), map(n + 1:, i))
         end do
         error = maxval(abs(map - exponential(a, time)))
         call check_close(error, 0.0_wp, 1.0e-9_wp, 'a flight with coinciding eigenvalues')
      end do
   contains
      !> M, C, K and the matrix of the first-order system for a size of the damping.
      subroutine set_matrices(c)
         real(wp), intent(in) :: c

         matrices(:, :, 1) = unit
         matrices(:, :, 2) = c*reshape([2.0_wp, 0.6_wp, 0.6_wp, 0.8_wp], [n, n])
         matrices(:, :, 3) = reshape([2.0_wp, -0.5_wp, -0.5_wp, 1.0_wp], [n, n])
         a = 0
         a(:n, n + 1:) = unit
         a(n + 1:, :n) = -matrices(:, :, 3)
         a(n + 1:, n + 1:) = -matrices(:, :, 2)
      end subroutine set_matrices
   end subroutine test_coinciding

   !> exp(a t): the Taylor series for a short time, squared ten times.
   pure function exponential(a, t) result(e)
      real(wp), intent(in) :: a(:, :), t
      real(wp) :: e(size(a, 1), size(a, 1)), term(size(a, 1), size(a, 1))
      integer :: i

      e = 0
      do i = 1, size(a, 1)
         e(i, i) = 1
      end do
      term = e
      do i = 1, 12
         term = matmul(term, a)*(t/1024/i)
         e = e + term
      end do
      do i = 1, 10
         e = matmul(e, e)
      end do
   end function exponential

   !> Structures whose masses are linearly dependent, whose gaps cannot be closed independently, or
   !! whose frequencies are extreme, are refused.
   subroutine test_refusals()
      integer, parameter :: n = 2
      real(wp), parameter :: unit(n, n) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [n, n]), &
         linked(n, n) = reshape([1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp], [n, n])
      type(structure_type) :: structure
      real(wp), allocatable :: forces(:, :), drifts(:, :)
      integer :: status

      structure = new_structure(reshape([linked, unit, unit], [n, n, 3]), unit, &
         reshape([1.0_wp, 0.5_wp, 2.0_wp, 0.5_wp], [2, 2]))
      call check_structure(structure, status)
      call check(status == stat%mass_not_definite, 'refusals: dependent masses')
      forces = unit
      call inputs_of(linked, unit, unit, forces, drifts, status)
      call check(status == stat%singular, 'refusals: inputs of dependent masses')
      forces = unit
      call inputs_of(2*unit, 3*unit, 5*unit, forces, drifts, status)
      call check(status == stat%ok .and. all(abs(forces - 2.5_wp*unit) <= 0) .and. &
         all(abs(drifts - 1.5_wp*unit) <= 0), 'inputs: xd and vd times the accelerations')
      call expect(reshape([1.0_wp, 1.0_wp, 2.0_wp, 2.0_wp], [n, 2]), stat%dependent_rests)
      call expect(reshape([1.0_wp, 1.0_wp, -1.0_wp, -1.0_wp], [n, 2]), stat%dependent_rests)
      ! in one coordinate, where another one is free
      call expect(reshape([0.0_wp, 1.0_wp, 0.0_wp, -1.0_wp], [n, 2]), stat%dependent_rests)
      call expect(reshape([1.0_wp, 1.0_wp, 1.0_wp, 1.001_wp], [n, 2]), stat%ok)
      call expect(reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp, 1.0_wp], [n, 3]), &
         stat%dependent_rests)
   contains
      !> All gaps at rest.
      subroutine expect(directions, status)
         real(wp), intent(in) :: directions(:, :)
         integer, intent(in) :: status
         type(regime_type) :: regime
         integer :: found, i

         structure = new_structure(reshape([unit, 0*unit, unit], [n, n, 3]), directions, &
            spread([1.0_wp, 0.5_wp], 2, size(directions, 2)))
         call check_structure(structure, found)
         call new_regime(structure, new_load(0.0_wp, reshape([real(wp) ::], [n, 2, 0]), [0.0_wp, &
            0.0_wp]), [(i, i=1, size(directions, 2))], regime, found)
         call check(found == status, 'refusals: gaps at rest')
         if (found == stat%ok) call check(all(abs(matmul(regime%offset, directions) - 1) < &
            1e-9_wp), 'gaps at rest are closed')
      end subroutine expect
   end subroutine test_refusals

   !> Responses of a pair to a unit state, a constant and a growing force, also backwards in time,
   !! compared with the exponential of the matrix: undamped, damped, critical, over-damped, with a
   !! small or tiny stiffness and damping, and without stiffness.
   subroutine test_responses()
      ! frequencies, and decay rates
      real(wp), parameter :: pairs(2, 14) = reshape([1.0_wp, 0.0_wp, 1.0_wp, 0.1_wp, 1.0_wp, &
         0.999999_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1.000001_wp, 1.0_wp, 1.5_wp, 1.0_wp, 6.0_wp, 0.0_wp, &
         0.7_wp, 0.0_wp, 0.0_wp, 0.3_wp, 0.7_wp, 1.0e-2_wp, 0.7_wp, 1.0e-5_wp, 0.7_wp, 1.0e-9_wp, &
         0.7_wp, 1.0e-33_wp, 0.7_wp], [2, 14])
      real(wp) :: a(4, 4), e(4, 4), u, w, s2, s3, omega, sigma, t
      integer :: i, j

      a = 0
      a(1, 2) = 1
      a(2, 3) = 1
      a(3, 4) = 1
      do i = 1, size(pairs, 2)
         omega = pairs(1, i)
         sigma = pairs(2, i)
         do j = 1, 41
            t = min(0.05_wp*1.2_wp**j, 60/(1 + sigma))
            ! where the formula changes, like steps of a table
            if (j == 41) t = 0.25_wp/max(sigma, 0.1_wp)
            a(2, 1) = -omega**2
            a(2, 2) = -2*sigma
            call expect(t)
            ! backwards in time, over which motions grow by at most exp(2 sigma t)
            call expect(-min(t, 3/(0.1_wp + sigma)))
         end do
      end do
   contains
      !> The responses after a time.
      subroutine expect(t)
         real(wp), intent(in) :: t
         real(wp) :: size

         call step_functions(omega**2, sigma, t, u, w, s2, s3)
         ! x, v, and a force that grows from 0
         e = exponential(a, t)
         size = max(1.0_wp, exp(-2*sigma*t))
         call check_close(u, e(1, 1), 1.0e-11_wp*(1 + abs(t))*size, 'responses: of x')
         call check_close(w, e(1, 2), 1.0e-11_wp*(1 + abs(t))*size, 'responses: of v')
         call check_close(s2, e(1, 3), 1.0e-11_wp*(1 + t**2)*size, 'responses: to a force')
         call check_close(s3, e(1, 4), 1.0e-11_wp*(1 + abs(t)**3)*size, &
            'responses: to a growing force')
      end subroutine expect
   end subroutine test_responses

   !> A regime at another load, other openings and other friction has the bits of a new one, for
   !! all that can be closed; with other matrices it is not renewed.
   subroutine test_renewal()
      integer, parameter :: n = 3
      type(random_type) :: random
      type(structure_type) :: structure
      type(load_type) :: load
      type(regime_type) :: regime, expected
      real(wp) :: matrices(n, n, 3), directions(n, 4), laws(6, 4), harmonics(n, 2, 2), constant(n)
      integer, allocatable :: closed(:)
      integer :: i, j, set, status, turn
      logical :: good, searched

      matrices = 0
      directions = 0
      do i = 1, n
         matrices(i, i, :) = [0.5_wp + 0.3_wp*i, 0.1_wp, 2.0_wp]
      end do
      matrices(1, 2, 3) = -1
      matrices(2, 1, 3) = -1
      directions(2:3, 1) = [-1.0_wp, 1.0_wp]
      directions(2:3, 2) = [1.0_wp, -1.0_wp]
      directions(1, 3) = 1
      directions(2, 4) = 1
      laws = 0
      laws(:3, 1) = [0.4_wp, real(constant_law, wp), 0.7_wp]
      laws(:3, 2) = [0.5_wp, real(constant_law, wp), 0.6_wp]
      laws(:5, 3) = [0.3_wp, real(pushing_law, wp), 20.0_wp, 0.4_wp, 0.1_wp]
      laws(:5, 4) = [0.0_wp, real(friction_law, wp), 0.2_wp, 0.25_wp, 0.1_wp]
      do set = 1, 8
         searched = modulo(set, 2) == 0
         select case (set)
         case (1, 2)
            closed = [integer :: ]
         case (3, 4)
            closed = [1]
         case (5)
            closed = [-4, 3]
         case (6)
            closed = [-3, 4]
         case (7)
            closed = [1, 3, 4]
         case default
            closed = [2, 4]
         end select
         do turn = 1, 6
            do j = 1, size(harmonics, 3)
               do i = 1, n
                  harmonics(i, 1, j) = draw(random, -1.0_wp, 1.0_wp)
                  harmonics(i, 2, j) = draw(random, -1.0_wp, 1.0_wp)
                  constant(i) = draw(random, 0.1_wp, 1.0_wp)
               end do
            end do
            do i = 1, 3
               laws(1, i) = draw(random, 0.1_wp, 1.0_wp)
            end do
            laws(3:5, 4) = draw(random, 0.1_wp, 1.0_wp)
            structure = new_structure(matrices, directions, laws)
            call check_structure(structure, status)
            load = new_load(draw(random, 0.5_wp, 3.0_wp), harmonics, constant)
            call new_regime(structure, load, closed, expected, status, searched)
            call check(status == stat%ok, 'renewal: a new regime')
            if (turn == 1) then
               call new_regime(structure, load, closed, regime, status, searched, .true.)
            else
               call renew_regime(structure, load, regime, good)
               call check(good, 'renewal: a regime is renewed')
            end if
            call compare()
         end do
         structure%stiffness(1, 1) = 1.01_wp*structure%stiffness(1, 1)
         call renew_regime(structure, load, regime, good)
         call check(.not. good, 'renewal: not with another stiffness')
      end do
   contains
      !> All that depends on the load, the openings and the friction.
      subroutine compare()
         call check(all([same(regime%offset, expected%offset), same(regime%modes%drift, &
            expected%modes%drift), same(regime%modes%force, expected%modes%force), &
            same(regime%row_offset, expected%row_offset), same(regime%rate_offset, &
            expected%rate_offset), same(regime%upper, expected%upper), same(regime%lower, &
            expected%lower), same([regime%unit, regime%frequency], [expected%unit, &
            expected%frequency])]), 'renewal: constants')
         call check(all([same_waves(regime%steady, expected%steady), same_waves( &
            regime%steady_rate, expected%steady_rate), same_waves(regime%wave_drift, &
            expected%wave_drift), same_waves(regime%wave_force, expected%wave_force), &
            same_waves(regime%ripple, expected%ripple), same_waves(regime%rows%ripple, &
            expected%rows%ripple)]), 'renewal: harmonics')
         call check(all([same(regime%rows%offset, expected%rows%offset), same( &
            regime%rows%rate_offset, expected%rows%rate_offset), same(regime%rows%constant_size, &
            expected%rows%constant_size), same(regime%rows%fastest, expected%rows%fastest), &
            same(regime%coordinates%offset, expected%coordinates%offset), same( &
            regime%coordinates%fastest, expected%coordinates%fastest)]), 'renewal: rows')
         call check(all(regime%upper_gap == expected%upper_gap) .and. all(regime%lower_gap == &
            expected%lower_gap), 'renewal: limits')
         if (searched) call check(same(reshape(regime%steps%map, [size(regime%steps%map)]), &
            reshape(expected%steps%map, [size(expected%steps%map)])) .and. &
            same_waves(regime%turns, expected%turns), 'renewal: tables')
      end subroutine compare

      !> Whether two lists have the same bits.
      logical function same(one, other)
         real(wp), intent(in) :: one(:), other(:)

         same = size(one) == size(other)
         if (same) same = all(transfer(one, [0]) == transfer(other, [0]))
      end function same

      !> The same of amplitudes.
      logical function same_waves(one, other) result(are)
         complex(wp), intent(in) :: one(:, :), other(:, :)

         are = all(shape(one) == shape(other))
         if (are) are = all(transfer(one, [0]) == transfer(other, [0]))
      end function same_waves
   end subroutine test_renewal

end module mechanics_structure
