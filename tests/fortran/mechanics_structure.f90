!> Structures with gaps: laws of restitution, flights by pairs, and chains.
module mechanics_structure
   use checks, only: check, check_close
   use random_numbers, only: draw, random_type
   use random_systems, only: determinant
   use vi_kinds, only: wp
   use vi_modes, only: advance
   use vi_restitution, only: new_restitution, power_law, restitution_at, restitution_type, table_law
   use vi_status, only: stat
   use vi_structure, only: check_structure, load_type, new_load, new_regime, new_structure, &
      regime_type, state_of, structure_type, to_pairs
   implicit none (type, external)
   private

   public :: test_structure

contains

   subroutine test_structure()
      call test_restitution()
      call test_restitution_at_rest()
      call test_flight(.false.)
      call test_flight(.true.)
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
      type(regime_type) :: regime
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
         if (.not. damped) call check_close(energy(q_back, rate_back), energy(q, rate), &
            1.0e-12_wp, 'energy is kept')
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

end module mechanics_structure
