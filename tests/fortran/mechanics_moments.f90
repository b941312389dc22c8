!> Integrals over a flight of a structure, compared with Gauss's rule on short panels: pairs with
!! any damping, of frequency 0, at a resonance, with harmonics, constant and growing forces, for
!! short and long times.
module mechanics_moments
   use checks, only: check
   use random_numbers, only: draw, fill, random_type
   use vi_kinds, only: wp
   use vi_moments, only: moments_of, numbers_in, rate_of, vector_at
   use vi_status, only: stat
   use vi_structure, only: check_structure, new_load, new_regime, new_structure, &
      regime_type, structure_type
   implicit none (type, external)
   private

   public :: test_moments

   type(random_type) :: random

contains

   subroutine test_moments()
      real(wp), parameter :: drags(6) = [0.0_wp, 0.2_wp, 1.0_wp, 2.0_wp, &
         2.0_wp*(1 + 1.0e-9_wp), 40.0_wp]
      integer :: i, j

      do i = 1, size(drags)
         do j = 1, 8
            call test_one(1.0_wp, drags(i), 10.0_wp**(j - 6))
            call test_one(0.0_wp, drags(i), 10.0_wp**(j - 6))
         end do
      end do
   end subroutine test_moments

   !> A body with a given spring and drag next to one of frequency 2.1, in resonance with the third
   !! multiple of the load frequency, under growing forces.
   subroutine test_one(stiffness, drag, time)
      real(wp), intent(in) :: stiffness, drag, time
      real(wp), parameter :: node = sqrt(3/5.0_wp)
      real(wp) :: matrices(2, 2, 3), harmonics(2, 2, 2), x(2), v(2), phase, t, step, size_of
      real(wp), allocatable :: b(:), squares(:, :), wanted(:, :), rates(:, :), near(:, :)
      complex(wp), allocatable :: parts(:, :), sums(:, :)
      type(structure_type) :: structure
      type(regime_type) :: regime
      integer :: i, j, k, n, panels, status

      matrices = 0
      matrices(:, :, 1) = reshape([1, 0, 0, 1], [2, 2])
      matrices(1, 1, 2:) = [drag, stiffness]
      matrices(2, 2, 3) = 2.1_wp**2
      call fill(random, -1.0_wp, 1.0_wp, x)
      call fill(random, -1.0_wp, 1.0_wp, v)
      harmonics = 0.3_wp
      harmonics(2, :, :) = 0.1_wp
      structure = new_structure(matrices, reshape([1.0_wp, 0.0_wp], [2, 1]), reshape([9.0_wp, &
         0.5_wp], [2, 1]))
      call check_structure(structure, status)
      call new_regime(structure, new_load(0.7_wp, harmonics, [0.3_wp, -0.2_wp]), [integer :: ], &
         regime, status)
      call check(status == stat%ok, 'moments: the regime')
      ! in the form of a record
      regime%modes%kind = 4
      regime%modes%force_rate = [0.4_wp, -0.3_wp]
      regime%modes%drift_rate = [0.1_wp, 0.2_wp]
      phase = draw(random, 0.0_wp, 6.0_wp)
      n = numbers_in(regime)
      allocate (b(n), squares(n, n), wanted(n, n), parts(n, 4), sums(n, 4), rates(n, 1), near(n, 2))
      call vector_at(regime, x, v, phase, 0.0_wp, b)
      call moments_of(regime, b, time, squares, parts)
      wanted = 0
      sums = 0
      panels = max(2, ceiling(60*time*max(1.0_wp, drag/8)))
      step = time/panels
      do i = 1, panels
         do j = -1, 1
            t = (i - 0.5_wp + 0.5_wp*j*node)*step
            call vector_at(regime, x, v, phase, t, b)
            wanted = wanted + step*merge(8, 5, j == 0)/18*spread(b, 1, n)*spread(b, 2, n)
            do k = 1, 4
               sums(:, k) = sums(:, k) + step*merge(8, 5, j == 0)/18*b*exp(cmplx(0.0_wp, &
                  -k*0.7_wp*t, wp))
            end do
         end do
      end do
      do i = 1, n
         do j = 1, n
            size_of = sqrt(squares(i, i)*squares(j, j)) + tiny(1.0_wp)
            call check(abs(squares(i, j) - wanted(i, j)) <= 1.0e-7_wp*size_of, 'moments: squares')
         end do
         call check(all(abs(parts(i, :) - sums(i, :)) <= 1.0e-7_wp*sqrt(time*squares(i, i))), &
            'moments: harmonics')
      end do
      ! the derivative of b
      step = 1.0e-5_wp
      do j = 1, 2
         call vector_at(regime, x, v, phase, time + (2*j - 3)*step, near(:, j))
      end do
      call vector_at(regime, x, v, phase, time, b)
      rates = rate_of(regime, reshape(b, [n, 1]))
      call check(maxval(abs((near(:, 2) - near(:, 1))/(2*step) - rates(:, 1))) <= 1.0e-5_wp*(1 + &
         drag)**3*maxval(abs(b)), 'moments: the rate')
      ! W' = A W + W A^T with the end and the start: exact except for rounding
      wanted = rate_of(regime, squares)
      wanted = wanted + transpose(wanted)
      call vector_at(regime, x, v, phase, 0.0_wp, near(:, 1))
      do i = 1, n
         do j = 1, n
            size_of = sqrt(squares(i, i)*squares(j, j))*(1 + drag)**2 + b(i)**2 + b(j)**2 &
               + near(i, 1)**2 + near(j, 1)**2 + maxval(abs(squares(n - 1:, n - 1:)))
            call check(abs(wanted(i, j) - (b(i)*b(j) - near(i, 1)*near(j, 1))) <= 1.0e-12_wp* &
               size_of, 'moments: the balance of a flight')
         end do
      end do
   end subroutine test_one

end module mechanics_moments
