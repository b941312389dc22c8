!> The linear problem: its solutions satisfy the laws of flights and impacts.
module motions_linear
   use checks, only: check, check_close
   use random_numbers, only: draw_integer, random_type
   use random_systems, only: misfit, mismatch, pi, random_frequency, random_motion, &
      random_oscillator, random_phases, random_sides, scale_of
   use vi_impact, only: impact
   use vi_kinds, only: wp
   use vi_motion, only: motion_type, start_motion
   use vi_oscillator, only: gain, oscillator_type
   use vi_pattern, only: default_restitution, new_pattern, pattern_type, side_symbols
   use vi_periodic, only: assemble, linear_system_type, solve_periodic
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: test_linear

   type(random_type) :: random

contains

   subroutine test_linear()
      call test_pattern()
      call test_two_impacts()
      call test_least_squares()
      call test_repeated()
      call test_free_amplitude()
      call test_no_load()
   end subroutine test_linear

   !> Conversions between symbols and sides are inverse; durations are positive and fill the period.
   subroutine test_pattern()
      type(pattern_type) :: pattern
      type(motion_type) :: motion
      real(wp), allocatable :: phases(:), length(:)
      integer, allocatable :: sides(:)
      integer :: i, n, cycles

      do i = 1, 1000
         n = draw_integer(random, 2, 9)
         cycles = draw_integer(random, 1, 4)
         allocate (sides(n), phases(n))
         call random_sides(random, sides)
         pattern = new_pattern(side_symbols(sides), cycles)
         call check(all(pattern%sides == sides) .and. pattern%cycles == cycles, 'symbols and sides')
         call random_phases(random, cycles, phases)
         call start_motion(motion, oscillator_type(0.1_wp, 0.2_wp, 0.5_wp), 1.3_wp, pattern, &
            spread(0.5_wp, 1, n), phases)
         call check(all(motion%length > 0), 'durations are positive')
         call check_close(sum(motion%length), 2*pi*cycles, 1e-14_wp*cycles, &
            'durations fill the period')
         length = motion%length
         call start_motion(motion, motion%osc, motion%r, pattern, motion%restitution, &
            phases + 0.7_wp)
         call check_close(maxval(abs(motion%length - length)), 0.0_wp, 1e-14_wp*cycles, &
            'the origin of phase does not matter')
         deallocate (length)
         deallocate (sides, phases)
      end do
      pattern = new_pattern('rLx', 1)
      call check(all(pattern%sides == [1, -1, 0]), 'small symbols, and symbols that are no wall')
      call check_close(default_restitution(1, 0.3_wp, 0.4_wp), 0.3_wp, 0.0_wp, 'right wall')
      call check_close(default_restitution(-1, 0.3_wp, 0.4_wp), 0.4_wp, 0.0_wp, 'left wall')
   end subroutine test_pattern

   !> Whether position at the walls, momentum and restitution hold at every impact.
   subroutine check_impacts(motion, what)
      type(motion_type), intent(in) :: motion
      character(*), intent(in) :: what
      real(wp) :: x_dot, z_dot, scale
      integer :: i

      scale = scale_of(motion)
      do i = 1, size(motion%x)
         call check_close(motion%z(i) - motion%x(i), &
            0.5_wp*motion%pattern%sides(i)*motion%clearance, &
            1e-14_wp*scale, what // ': impacts are at the walls')
         call check_close(motion%x_dot_after(i) + motion%osc%mu*motion%z_dot_after(i), &
            motion%x_dot_before(i) + motion%osc%mu*motion%z_dot_before(i), &
            1e-13_wp*scale*(1 + motion%osc%mu), what // ': momentum')
         call check_close(motion%z_dot_after(i) - motion%x_dot_after(i), &
            -motion%restitution(i)*(motion%z_dot_before(i) - motion%x_dot_before(i)), &
            1e-13_wp*scale, what // ': restitution')
         call impact(motion%osc%mu, motion%restitution(i), motion%x_dot_before(i), &
            motion%z_dot_before(i), x_dot, z_dot)
         call check_close(x_dot, motion%x_dot_after(i), 1e-13_wp*scale, what // ': impact, x_dot')
         call check_close(z_dot, motion%z_dot_after(i), 1e-13_wp*scale, what // ': impact, z_dot')
      end do
   end subroutine check_impacts

   !> N = 2: each flight ends with the position and velocity at which the next impact begins.
   subroutine test_two_impacts()
      type(motion_type) :: motion
      integer :: i

      do i = 1, 5000
         call random_motion(random, 2, motion)
         call check_close(mismatch(motion), 0.0_wp, 1e-12_wp*scale_of(motion), &
            'two impacts: flights meet the impacts')
         call check_impacts(motion, 'two impacts')
         call check_close(motion%amplitude, gain(motion%osc%xi, motion%r), 0.0_wp, 'the load is 1')
         call check_close(motion%residual, 0.0_wp, 0.0_wp, 'a square system has no residual')
         call check(motion%clearance > 0, 'a clearance is positive')
      end do
   end subroutine test_two_impacts

   !> N > 2: the error of the equations is orthogonal to their columns, and `residual` measures it.
   subroutine test_least_squares()
      type(motion_type) :: motion
      type(linear_system_type) :: system
      real(wp), allocatable :: unknowns(:), rest(:)
      real(wp) :: unit, across
      integer :: i, n

      do i = 1, 1500
         n = draw_integer(random, 3, 9)
         call random_motion(random, n, motion)
         call check_impacts(motion, 'more impacts')
         call assemble(motion, system)
         unit = 1/motion%clearance
         if (allocated(unknowns)) deallocate (unknowns)
         allocate (unknowns(n + 2))
         unknowns(:) = [motion%x*unit, motion%amplitude*cos(motion%tau)*unit, &
            motion%amplitude*sin(motion%tau)*unit]
         rest = misfit(system%matrix, unknowns, system%rhs)
         across = maxval(abs(matmul(transpose(system%matrix), rest)))
         call check_close(across, 0.0_wp, &
            1e-13_wp*norm2(system%matrix)**2*(norm2(unknowns) + norm2(system%rhs)), &
            'least squares: the error is orthogonal to the columns')
         call check_close(motion%residual, norm2(rest)/norm2(system%rhs), &
            1e-13_wp*(1 + norm2(system%matrix)*norm2(unknowns)/norm2(system%rhs)), &
            'least squares: residual')
      end do
   end subroutine test_least_squares

   !> A motion with two impacts, repeated: N = 4, 6 are then consistent and give the same motion.
   subroutine test_repeated()
      type(motion_type) :: once, motion
      type(pattern_type) :: pattern
      type(linear_system_type) :: system
      real(wp), allocatable :: phases(:), restitution(:)
      integer :: i, j, times

      do i = 1, 1000
         call random_motion(random, 2, once)
         times = draw_integer(random, 2, 3)
         pattern = pattern_type([(once%pattern%sides, j=1, times)], times*once%pattern%cycles)
         phases = [(once%phases + 2*pi*once%pattern%cycles*(j - 1), j=1, times)]
         restitution = [(once%restitution, j=1, times)]
         call solve_periodic(once%osc, once%r, pattern, restitution, phases, system, motion)
         ! a subharmonic may leave the repeated problem (nearly) undetermined
         if (motion%status == stat%singular .or. motion%status == stat%no_load) cycle
         call check(motion%status == stat%ok, 'repeated motion: status')
         call check_close(motion%residual, 0.0_wp, 1e-12_wp, 'repeated motion: consistent')
         if (abs(motion%clearance - once%clearance) > 1e-8_wp*once%clearance) cycle
         call check_close(mismatch(motion), 0.0_wp, 1e-7_wp*scale_of(motion), &
            'repeated motion: flights')
         call check_close(maxval(abs(motion%x - [(once%x, j=1, times)])), 0.0_wp, &
            1e-7_wp*scale_of(once), 'repeated motion: positions')
      end do
   end subroutine test_repeated

   !> Equal durations and equal restitution leave A free; with unequal restitution they do not.
   subroutine test_free_amplitude()
      type(motion_type) :: motion
      type(oscillator_type) :: osc
      type(linear_system_type) :: system
      real(wp) :: r, phases(2)
      integer :: i, cycles

      do i = 1, 2000
         call random_oscillator(random, osc)
         r = random_frequency(random)
         cycles = 2*draw_integer(random, 0, 2) + 1
         phases = [0.0_wp, cycles*pi]
         osc%restitution(2) = osc%restitution(1)
         call solve_periodic(osc, r, new_pattern('RL', cycles), osc%restitution, phases, system, &
            motion)
         call check(motion%status == stat%free_amplitude, 'equal durations leave A free')
      end do
   end subroutine test_free_amplitude

   !> Without load only rest is periodic, so no clearance is determined.
   subroutine test_no_load()
      type(motion_type) :: motion
      type(linear_system_type) :: system

      ! two impacts in two cycles, equally spaced: each flight sees the same load phase, A = 0
      call solve_periodic(oscillator_type(0.0_wp, 0.0_wp, 1.0_wp), 1.7_wp, new_pattern('RL', 2), &
         [1.0_wp, 1.0_wp], [0.0_wp, 2*pi], system, motion)
      call check(motion%status /= stat%ok, 'a motion without load is not given a clearance')
   end subroutine test_no_load

end module motions_linear
