!> The equispaced pair: existence, number, symmetry, and the fold where both coincide.
module motions_equispaced
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, draw_log, random_type
   use random_systems, only: mismatch, random_frequency, random_oscillator, scale_of
   use vi_equispaced, only: solve_equispaced
   use vi_kinds, only: wp
   use vi_motion, only: motion_type
   use vi_oscillator, only: gain, oscillator_type
   use vi_pattern, only: new_pattern
   use vi_periodic, only: linear_system_type, solve_periodic
   use vi_sample, only: sample_motion
   use vi_stability, only: multipliers
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: test_equispaced

   type(random_type) :: random

contains

   subroutine test_equispaced()
      call test_motions()
      call test_fold()
      call test_table_1()
      call test_resonance()
   end subroutine test_equispaced

   !> An oscillator with one coefficient of restitution, a frequency ratio and an odd number of
   !! cycles.
   subroutine random_pair(osc, r, cycles)
      type(oscillator_type), intent(out) :: osc
      real(wp), intent(out) :: r
      integer, intent(out) :: cycles

      call random_oscillator(random, osc)
      osc%restitution = osc%restitution(1)
      r = random_frequency(random)
      cycles = 2*draw_integer(random, 0, 1) + 1
   end subroutine random_pair

   !> Each motion satisfies the equations of motion at the given clearance and is its own mirror
   !! image.
   subroutine test_motions()
      type(oscillator_type) :: osc
      type(linear_system_type) :: system
      type(motion_type) :: motions(2)
      real(wp) :: r, clearance, times(2), period, values(6, 2), scale
      integer :: i, j, cycles, found

      found = 0
      do i = 1, 3000
         call random_pair(osc, r, cycles)
         clearance = gain(osc%xi, r)*draw_log(random, 0.01_wp, 10.0_wp)
         call solve_equispaced(osc, r, clearance, cycles, system, motions)
         call check(motions(1)%status == motions(2)%status, 'none or both')
         do j = 1, 2
            if (motions(j)%status /= stat%ok) then
               call check(motions(j)%status == stat%no_motion, 'what does not exist says so')
               cycle
            end if
            found = found + 1
            scale = scale_of(motions(j))
            call check_close(motions(j)%clearance, clearance, 1e-14_wp*clearance, 'given clearance')
            call check_close(motions(j)%amplitude, gain(osc%xi, r), 0.0_wp, &
               'the point is on the circle')
            call check_close(mismatch(motions(j)), 0.0_wp, 1e-11_wp*scale, 'equispaced: flights')
            call check_close(motions(j)%x(2), -motions(j)%x(1), 0.0_wp, 'x_2 = -x_1')
            period = 2*acos(-1.0_wp)*cycles/r
            times(1) = draw(random, 0.0_wp, 0.5_wp*period)
            times(2) = times(1) + 0.5_wp*period
            call sample_motion(motions(j), times, values)
            call check_close(maxval(abs(values(:, 1) + values(:, 2))), 0.0_wp, 1e-11_wp*scale, &
               'mirror symmetry: everything changes sign after half a period')
         end do
      end do
      call check(found > 1000, 'many motions were examined')
   end subroutine test_motions

   !> Below a largest clearance there are two motions, above it none; where they meet, a
   !! multiplier is 1.
   subroutine test_fold()
      type(oscillator_type) :: osc
      type(linear_system_type) :: system
      type(motion_type) :: motions(2)
      complex(wp) :: lambda(4)
      real(wp) :: r, low, high, middle
      integer :: i, n, cycles, status

      do i = 1, 200
         call random_pair(osc, r, cycles)
         low = 1e-3_wp*gain(osc%xi, r)
         high = 1e6_wp*gain(osc%xi, r)
         n = number(low)
         if (n /= 2) cycle
         n = number(high)
         if (n /= 0) cycle
         do n = 1, 100
            middle = 0.5_wp*(low + high)
            if (number(middle) > 0) low = middle
            if (number(middle) == 0) high = middle
         end do
         call check(number(low*(1 - 1e-9_wp)) == 2, 'two motions below the fold')
         call check(number(0.5_wp*low) == 2, 'two motions far below the fold')
         call check(number(low*(1 + 1e-9_wp)) == 0, 'none above the fold')
         call solve_equispaced(osc, r, low*(1 - 1e-12_wp), cycles, system, motions)
         call check_close(motions(1)%x(1), motions(2)%x(1), 1e-4_wp*scale_of(motions(1)), &
            'the two motions meet at the fold')
         call multipliers(motions(1), lambda, status)
         if (status /= stat%ok .or. .not. maxval(abs(lambda)) < 100) cycle
         call check_close(minval(abs(lambda - 1)), 0.0_wp, 0.02_wp, 'a multiplier is 1 at the fold')
      end do

   contains

      integer function number(clearance)
         real(wp), intent(in) :: clearance

         call solve_equispaced(osc, r, clearance, cycles, system, motions)
         number = count(motions%status == stat%ok)
      end function number

   end subroutine test_fold

   !> All three columns of Table 1, as recomputed from first principles.
   subroutine test_table_1()
      type(oscillator_type), parameter :: osc = oscillator_type(0.005_wp, 0.042_wp, &
         [0.75_wp, 0.75_wp])
      real(wp), parameter :: pi = acos(-1.0_wp)
      real(wp), parameter :: largest(3) = [3.8284_wp, 12.0742_wp, 0.9347_wp]
      type(linear_system_type) :: system
      type(motion_type) :: motions(3)
      complex(wp) :: lambda(4)
      integer :: i, status

      call solve_equispaced(osc, 0.94_wp, 37.0_wp, 1, system, motions(:2))
      if (motions(1)%x(1) < motions(2)%x(1)) motions(:2) = motions([2, 1])
      call check_close(motions(1)%x(1), 16.171_wp, 5e-4_wp, 'Table 1: x_1, equispaced 1')
      call check_close(motions(2)%x(1), -5.095_wp, 5e-4_wp, 'Table 1: x_1, equispaced 2')
      call check_close(motions(1)%tau/pi, 0.6550_wp, 5e-5_wp, 'Table 1: tau, equispaced 1')
      call check_close(motions(2)%tau/pi, -0.5579_wp, 5e-5_wp, 'Table 1: tau, equispaced 2')
      call solve_periodic(osc, 0.94_wp, new_pattern('RL', 1), osc%restitution, &
         [0.0_wp, 1.37_wp*pi], system, motions(3))
      call check_close(motions(3)%clearance, 38.220989_wp, 5e-7_wp, &
         'Table 1: clearance, unequispaced')
      do i = 1, 3
         call multipliers(motions(i), lambda, status)
         call check(status == stat%ok, 'Table 1: multipliers')
         call check_close(abs(lambda(1)), largest(i), 5e-5_wp, 'Table 1: largest modulus')
         call check_close(product(abs(lambda)), 0.29595_wp, 5e-6_wp, 'Table 1: det[P]')
      end do
   end subroutine test_table_1

   !> Undamped, with an odd number of free half periods between impacts: the free motion resonates
   !! with the impacts, and no finite motion balances them.
   subroutine test_resonance()
      type(linear_system_type) :: system
      type(motion_type) :: motions(2)
      real(wp) :: mu, restitution, clearance
      integer :: i, n

      do i = 1, 300
         n = draw_integer(random, 1, 6)
         mu = draw_log(random, 1e-3_wp, 1.0_wp)
         restitution = draw(random, 0.1_wp, 0.9_wp)
         clearance = draw_log(random, 1e-3_wp, 1e2_wp)
         call solve_equispaced(oscillator_type(0.0_wp, mu, restitution), 1.0_wp/(2*n + 1), &
            clearance, 1, system, motions)
         call check(all(motions%status /= stat%ok), 'undamped resonance has no equispaced motion')
      end do
   end subroutine test_resonance

end module motions_equispaced
