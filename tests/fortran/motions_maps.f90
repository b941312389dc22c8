!> [P_i] compared with differences of the map, and the laws of its determinant and eigenvalues.
module motions_maps
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, random_type
   use random_systems, only: determinant, pi, random_frequency, random_motion, random_oscillator
   use vi_flight, only: flight_position, flight_state, flight_type, new_flight
   use vi_impact, only: impact
   use vi_impact_map, only: impact_maps
   use vi_kinds, only: wp
   use vi_law, only: holds
   use vi_motion, only: motion_type, start_motion
   use vi_oscillator, only: gain, oscillator_type
   use vi_pattern, only: new_pattern
   use vi_stability, only: multipliers, stability_matrix
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: test_maps

   type(random_type) :: random

contains

   subroutine test_maps()
      call test_differences()
      call test_flux()
      call test_determinant()
      call test_audit()
      call test_order_of_maps()
      call test_multipliers()
      call test_zero_approach()
   end subroutine test_maps

   !> From the state (x, x', z', alpha) just after one impact to the state just after the next.
   !!
   !! The relative position is y(1) at the start and y(2) at the end; the time is found within
   !! `width` of `guess`, by Newton's method between two bounds.
   function next_state(motion, state, y, guess, width) result(next)
      type(motion_type), intent(in) :: motion
      real(wp), intent(in) :: state(4), y(2), guess, width
      real(wp) :: next(4), low, high, t, x(3), gap, rate, start
      type(flight_type) :: flight
      integer :: i

      flight = new_flight(motion%osc%xi, motion%r, motion%amplitude, state(4) + motion%tau, &
         state(1), state(2), state(1) + y(1), state(3), guess)
      low = guess - width
      high = guess + width
      call flight_state(flight, low, x(1), x(2), x(3))
      start = flight_position(flight, low) - x(1) - y(2)
      t = guess
      do i = 1, 100
         call flight_state(flight, t, x(1), x(2), x(3))
         gap = flight_position(flight, t) - x(1) - y(2)
         rate = state(3) - x(2)
         if (gap*start > 0) then
            low = t
         else
            high = t
         end if
         if (.not. abs(gap) > 1e-15_wp*(1 + abs(x(1)))) exit
         t = t - gap/rate
         if (t <= low .or. t >= high) t = 0.5_wp*(low + high)
         if (high - low < 1e-15_wp*guess) exit
      end do
      next(1) = x(1)
      call impact(motion%osc%mu, motion%restitution(2), x(2), state(3), next(2), next(3))
      next(4) = state(4) + motion%r*t
   end function next_state

   !> Two impacts with any state at the first; the second wall is placed where the flight ends.
   subroutine random_half(motion, y, approach)
      type(motion_type), intent(out) :: motion
      real(wp), intent(out) :: y(2), approach
      type(oscillator_type) :: osc
      type(flight_type) :: flight
      real(wp) :: r, phases(2), x(3)

      call random_oscillator(random, osc)
      r = random_frequency(random)
      phases(1) = draw(random, 0.0_wp, 2.0_wp)
      phases(2) = phases(1) + draw(random, 0.3_wp, 4.0_wp)
      call start_motion(motion, osc, r, new_pattern('RL', 1), osc%restitution, phases)
      motion%amplitude = min(gain(osc%xi, r), 3.0_wp)
      motion%tau = draw(random, -pi, pi)
      motion%x = draw(random, -2.0_wp, 2.0_wp)
      motion%x_dot_after = draw(random, -2.0_wp, 2.0_wp)
      motion%z_dot_after = draw(random, -4.0_wp, 4.0_wp)
      flight = new_flight(osc%xi, r, motion%amplitude, phases(1) + motion%tau, motion%x(1), &
         motion%x_dot_after(1), motion%x(1) - 0.5_wp, motion%z_dot_after(1), &
         (phases(2) - phases(1))/r)
      call flight_state(flight, flight%duration, x(1), x(2), x(3))
      y = [-0.5_wp, flight_position(flight, flight%duration) - x(1)]
      approach = motion%z_dot_after(1) - x(2)
   end subroutine random_half

   !> Every column of [P_i] is the derivative of the map, for any restitution and damping.
   subroutine test_differences()
      type(motion_type) :: motion
      real(wp) :: p(4, 4, 2), y(2), approach, h, state(4), column(4), ahead(4, 4), guess, width
      logical :: regular
      integer :: i, j, k, examined

      examined = 0
      do i = 1, 1500
         call random_half(motion, y, approach)
         if (abs(approach) < 0.5_wp) cycle
         examined = examined + 1
         call impact_maps(motion, p, regular)
         call check(regular, 'a map with approach is regular')
         guess = (motion%phases(2) - motion%phases(1))/motion%r
         ! the relative speed keeps its sign within this time, and the impact stays within it
         width = 0.5_wp*abs(approach)/(8 + motion%amplitude*motion%r**2)
         h = 0.02_wp*width*min(1.0_wp, abs(approach))/((1 + motion%r)*(1 + guess))
         do j = 1, 4
            do k = 1, 4
               state = [motion%x(1), motion%x_dot_after(1), motion%z_dot_after(1), motion%phases(1)]
               state(j) = state(j) + h*k
               ahead(:, k) = next_state(motion, state, y, guess, width)
               state(j) = state(j) - 2*h*k
               ahead(:, k) = ahead(:, k) - next_state(motion, state, y, guess, width)
            end do
            ! central differences of eighth order
            column = (672*ahead(:, 1) - 168*ahead(:, 2) + 32*ahead(:, 3) - 3*ahead(:, 4))/(840*h)
            call check_close(maxval(abs(column - p(:, j, 1))), 0.0_wp, &
               2e-8_wp*(1 + maxval(abs(p))), 'P_i is the derivative of the map')
         end do
      end do
      call check(examined > 1000, 'many maps were examined')
   end subroutine test_differences

   !> The flow contracts volume by exp(-2 xi t), an impact multiplies it by -R, and the flux through
   !! the two sections is volume times relative speed.
   subroutine test_flux()
      type(motion_type) :: motion
      real(wp) :: p(4, 4, 2), y(2), approach, leaving, expected
      logical :: regular
      integer :: i

      do i = 1, 5000
         call random_half(motion, y, approach)
         if (abs(approach) < 0.1_wp) cycle
         call impact_maps(motion, p, regular)
         leaving = motion%z_dot_after(1) - motion%x_dot_after(1)
         expected = -motion%restitution(2)*leaving/approach &
            *exp(-2*motion%osc%xi*(motion%phases(2) - motion%phases(1))/motion%r)
         call check_close(determinant(p(:, :, 1)), expected, &
            1e-10_wp*(1 + maxval(abs(p(:, :, 1)))**2), 'det P_i')
      end do
   end subroutine test_flux

   !> det[P] = exp(-4 pi xi k/r) times the product of all R^2, for every periodic motion.
   subroutine test_determinant()
      type(motion_type) :: motion
      real(wp) :: p(4, 4), expected, speed
      integer :: i, status, examined

      examined = 0
      do i = 1, 5000
         call random_motion(random, 2, motion)
         speed = minval(abs(motion%z_dot_before - motion%x_dot_before))
         if (speed < 1e-2_wp*maxval(abs(motion%z_dot_before))) cycle
         call stability_matrix(motion, p, status)
         call check(status == stat%ok, 'a motion with approach has a stability matrix')
         if (maxval(abs(p)) > 100) cycle
         examined = examined + 1
         expected = exp(-4*pi*motion%osc%xi*motion%pattern%cycles/motion%r) &
            *product(motion%restitution**2)
         call check_close(determinant(p), expected, 1e-10_wp*(1 + maxval(abs(p))**2), 'det[P]')
      end do
      call check(examined > 1000, 'many determinants were examined')
   end subroutine test_determinant

   !> [P] passes the audit in any units, and fails it with an entry that is twice as large.
   subroutine test_audit()
      type(motion_type) :: motion
      real(wp) :: p(4, 4), corrupt(4, 4), scale(4), slope, law
      integer :: examined, status, i, j, k, l

      examined = 0
      do k = 1, 1000
         call random_motion(random, 2, motion)
         call stability_matrix(motion, p, status)
         if (status /= stat%ok) cycle
         call check(holds(motion, p), '[P] of a motion passes the audit')
         law = determinant(p)
         do l = 1, 4
            scale(l) = 10**draw(random, -8.0_wp, 8.0_wp)
         end do
         do j = 1, 4
            do i = 1, 4
               corrupt(i, j) = p(i, j)*scale(i)/scale(j)
            end do
         end do
         call check(holds(corrupt, law, 1.0e-12_wp), 'units do not matter to the audit')
         if (.not. (law > 1.0e-3_wp .and. maxval(abs(p)) < 30)) cycle
         do j = 1, 4
            do i = 1, 4
               ! the contribution of this entry to the determinant, which is linear in it
               corrupt = p
               corrupt(i, j) = 0
               slope = law - determinant(corrupt)
               if (.not. abs(slope) > 0.1_wp*law) cycle
               corrupt(i, j) = 2*p(i, j)
               examined = examined + 1
               call check(.not. holds(motion, corrupt), 'a wrong entry of [P] fails the audit')
            end do
         end do
      end do
      call check(examined > 100, 'many wrong entries were examined')
   end subroutine test_audit

   !> [P] carries a small change through the impacts in the order in which they happen.
   subroutine test_order_of_maps()
      type(motion_type) :: motion
      real(wp) :: parts(4, 4, 5), p(4, 4), change(4), at_end(4)
      logical :: regular
      integer :: i, j, n, status

      do i = 1, 1000
         n = draw_integer(random, 3, 5)
         call random_motion(random, n, motion)
         call impact_maps(motion, parts(:, :, :n), regular)
         call stability_matrix(motion, p, status)
         if (status /= stat%ok .or. maxval(abs(parts(:, :, :n))) > 1e4_wp) cycle
         do j = 1, 4
            change(j) = draw(random, -1.0_wp, 1.0_wp)
         end do
         at_end = matmul(p, change)
         do j = 1, n
            change = matmul(parts(:, :, j), change)
         end do
         call check_close(maxval(abs(at_end - change)), 0.0_wp, 1e-12_wp*norm2(p) &
            *maxval(abs(parts(:, :, :n))), 'impacts act in their order')
      end do
   end subroutine test_order_of_maps

   !> Multipliers decrease in modulus, conjugates are adjacent, and they are those of [P].
   subroutine test_multipliers()
      type(motion_type) :: motion
      complex(wp) :: lambda(4)
      real(wp) :: p(4, 4), norm
      integer :: i, j, n, status

      do i = 1, 2000
         n = draw_integer(random, 2, 5)
         call random_motion(random, n, motion)
         call stability_matrix(motion, p, status)
         if (status /= stat%ok) cycle
         norm = norm2(p)
         if (.not. norm < 1e30_wp) cycle
         call multipliers(motion, lambda, status)
         call check(status == stat%ok, 'multipliers are found')
         call check(all(abs(lambda(:3)) >= abs(lambda(2:))), 'multipliers fall in modulus')
         call check_close(real(sum(lambda)), sum([(p(j, j), j=1, 4)]), 1e-13_wp*norm, &
            'trace of [P]')
         call check_close(aimag(sum(lambda)), 0.0_wp, 0.0_wp, 'complex multipliers come in pairs')
         p = matmul(p, p)
         call check_close(real(sum(lambda**2)), sum([(p(j, j), j=1, 4)]), 1e-12_wp*norm**2, &
            'trace of [P]^2')
         do j = 1, 4
            if (abs(aimag(lambda(j))) > 0) call check(any(abs(lambda(max(1, j - 1):min(4, j + 1)) &
               - conjg(lambda(j))) <= 0), 'conjugates are neighbours')
         end do
      end do
   end subroutine test_multipliers

   !> An approach speed of zero gives a status, and no division by zero.
   subroutine test_zero_approach()
      type(motion_type) :: motion
      complex(wp) :: lambda(4)
      real(wp) :: p(4, 4, 2), q(4, 4)
      logical :: regular
      integer :: status

      call start_motion(motion, oscillator_type(0.1_wp, 0.2_wp, 0.5_wp), 1.3_wp, &
         new_pattern('RL', 1), [0.5_wp, 0.5_wp], [0.0_wp, pi])
      motion%x = 0
      motion%x_dot_after = 0
      motion%z_dot_after = 0
      call impact_maps(motion, p, regular)
      call check(.not. regular, 'rest has no impact map')
      call stability_matrix(motion, q, status)
      call check(status == stat%zero_approach, 'rest has no stability matrix')
      call multipliers(motion, lambda, status)
      call check(status == stat%zero_approach, 'rest has no multipliers')
      motion%z_dot_after(2) = 1
      call impact_maps(motion, p, regular)
      call check(.not. regular, 'one impact without approach is enough')
      call check_close(sum(motion%length), 2*pi, 1e-14_wp, 'the motion is as it was')
   end subroutine test_zero_approach

end module motions_maps
