!> Random oscillators, patterns and motions, including corners of the parameter ranges.
module random_systems
   use random_numbers, only: draw, draw_integer, draw_log, random_type
   use vi_flight, only: flight_state, flight_type, new_flight
   use vi_kinds, only: wp
   use vi_motion, only: flight_of, motion_type
   use vi_oscillator, only: gain, oscillator_type
   use vi_pattern, only: pattern_type
   use vi_periodic, only: linear_system_type, solve_periodic
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: random_oscillator, random_frequency, random_phases, random_sides, random_flight, &
      random_motion, scale_of, mismatch, determinant, misfit

   real(wp), parameter, public :: pi = acos(-1.0_wp)

contains

   !> Every range including its ends: xi = 0, mu = 0, R = 0 and R = 1 are frequent.
   subroutine random_oscillator(random, osc)
      type(random_type), intent(inout) :: random
      type(oscillator_type), intent(out) :: osc
      integer :: i

      select case (draw_integer(random, 1, 8))
      case (1)
         osc%xi = 0
      case (2)
         osc%xi = draw(random, 0.1_wp, 0.95_wp)
      case default
         osc%xi = draw_log(random, 1e-3_wp, 0.1_wp)
      end select
      osc%mu = 0
      if (draw_integer(random, 1, 8) > 1) osc%mu = draw_log(random, 1e-3_wp, 3.0_wp)
      do i = 1, 2
         select case (draw_integer(random, 1, 10))
         case (1)
            osc%restitution(i) = 0
         case (2)
            osc%restitution(i) = 1
         case default
            osc%restitution(i) = draw(random, 0.1_wp, 1.0_wp)
         end select
      end do
   end subroutine random_oscillator

   !> A frequency ratio away from undamped resonance.
   real(wp) function random_frequency(random)
      type(random_type), intent(inout) :: random

      do
         random_frequency = draw_log(random, 0.2_wp, 5.0_wp)
         if (abs(random_frequency - 1) > 1e-2_wp) exit
      end do
   end function random_frequency

   !> Phases from 0, with gaps in ratios of at most 1 to 20.
   subroutine random_phases(random, cycles, phases)
      type(random_type), intent(inout) :: random
      integer, intent(in) :: cycles
      real(wp), intent(out) :: phases(:)
      real(wp) :: total, gap
      integer :: i

      total = 0
      do i = 1, size(phases)
         phases(i) = total
         gap = draw(random, 0.05_wp, 1.0_wp)
         total = total + gap
      end do
      phases = phases*(2*pi*cycles/total)
   end subroutine random_phases

   !> Sides that are not all the same.
   subroutine random_sides(random, sides)
      type(random_type), intent(inout) :: random
      integer, intent(out) :: sides(:)
      integer :: i

      do
         do i = 1, size(sides)
            sides(i) = 2*draw_integer(random, 0, 1) - 1
         end do
         if (abs(sum(sides)) < size(sides)) exit
      end do
   end subroutine random_sides

   !> A flight that need not belong to any motion.
   subroutine random_flight(random, flight)
      type(random_type), intent(inout) :: random
      type(flight_type), intent(out) :: flight
      type(oscillator_type) :: osc
      real(wp) :: r, amplitude, phase, x, x_dot, z, z_dot, duration

      call random_oscillator(random, osc)
      r = random_frequency(random)
      amplitude = draw(random, 0.0_wp, 2.0_wp)*min(gain(osc%xi, r), 10.0_wp)
      phase = draw(random, 0.0_wp, 2*pi)
      x = draw(random, -3.0_wp, 3.0_wp)
      x_dot = draw(random, -3.0_wp, 3.0_wp)
      z = draw(random, -3.0_wp, 3.0_wp)
      z_dot = draw(random, -3.0_wp, 3.0_wp)
      duration = draw_log(random, 1e-2_wp, 30.0_wp)
      flight = new_flight(osc%xi, r, amplitude, phase, x, x_dot, z, z_dot, duration)
   end subroutine random_flight

   !> A motion with n impacts whose linear problem has a solution.
   !!
   !! For n = 2 it satisfies all equations of motion, but the flights may pass through the walls.
   !! The coefficients of restitution differ from impact to impact.
   subroutine random_motion(random, n, motion)
      type(random_type), intent(inout) :: random
      integer, intent(in) :: n
      type(motion_type), intent(out) :: motion
      type(oscillator_type) :: osc
      type(pattern_type) :: pattern
      type(linear_system_type) :: system
      real(wp) :: r, restitution(n), phases(n)
      integer :: i

      allocate (pattern%sides(n))
      do
         call random_oscillator(random, osc)
         r = random_frequency(random)
         pattern%cycles = draw_integer(random, 1, 3)
         call random_sides(random, pattern%sides)
         call random_phases(random, pattern%cycles, phases)
         do i = 1, n
            restitution(i) = osc%restitution(draw_integer(random, 1, 2))
         end do
         call solve_periodic(osc, r, pattern, restitution, phases, system, motion)
         if (motion%status == stat%ok) exit
      end do
   end subroutine random_motion

   !> The largest number of a motion, for relative tolerances.
   pure real(wp) function scale_of(motion)
      type(motion_type), intent(in) :: motion

      scale_of = max(maxval(abs(motion%x)), motion%clearance, &
         motion%amplitude*max(1.0_wp, motion%r), &
         maxval(abs(motion%x_dot_before)), maxval(abs(motion%x_dot_after)), &
         maxval(abs(motion%z_dot_before)), maxval(abs(motion%z_dot_after)))
   end function scale_of

   !> The errors by which the flights of a motion miss the impacts that end them.
   pure real(wp) function mismatch(motion)
      type(motion_type), intent(in) :: motion
      type(flight_type) :: flight
      real(wp) :: x, x_dot, x_ddot
      integer :: i, next

      mismatch = 0
      do i = 1, size(motion%phases)
         next = modulo(i, size(motion%phases)) + 1
         flight = flight_of(motion, i)
         call flight_state(flight, flight%duration, x, x_dot, x_ddot)
         mismatch = max(mismatch, abs(x - motion%x(next)), abs(x_dot - motion%x_dot_before(next)), &
            abs(flight%z + flight%z_dot*flight%duration - motion%z(next)), &
            abs(motion%z_dot_before(next) - motion%z_dot_after(i)))
      end do
   end function mismatch

   !> b - A x. (gfortran 12 overruns an allocatable array that b - matmul(a, x) would have to
   !! enlarge.)
   pure function misfit(a, x, b) result(rest)
      real(wp), intent(in) :: a(:, :), x(:), b(:)
      real(wp) :: rest(size(b))

      rest = matmul(a, x)
      rest = b - rest
   end function misfit

   !> Determinant by elimination with row pivots.
   pure real(wp) function determinant(matrix)
      real(wp), intent(in) :: matrix(:, :)
      real(wp) :: a(size(matrix, 1), size(matrix, 1)), row(size(matrix, 1))
      integer :: i, j, pivot

      a = matrix
      determinant = 1
      do i = 1, size(a, 1)
         pivot = i - 1 + maxloc(abs(a(i:, i)), dim=1)
         if (.not. abs(a(pivot, i)) > 0) then
            determinant = 0
            return
         end if
         if (pivot /= i) then
            row = a(i, :)
            a(i, :) = a(pivot, :)
            a(pivot, :) = row
            determinant = -determinant
         end if
         determinant = determinant*a(i, i)
         do j = i + 1, size(a, 1)
            a(j, i:) = a(j, i:) - a(j, i)/a(i, i)*a(i, i:)
         end do
      end do
   end function determinant

end module random_systems
