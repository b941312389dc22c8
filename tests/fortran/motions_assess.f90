!> The verdicts, on motions for which they are known, and the time history.
module motions_assess
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, random_type
   use random_systems, only: pi, random_motion, scale_of
   use vi_assess, only: assess_flights, assess_linear, assess_rest, paper_acceptance, &
      refuse_rounding
   use vi_chain, only: equispaced_chain, periodic_chain
   use vi_doubt, only: greater, modulus_doubt, spread_of_orders, unknowns_doubt, worst_change
   use vi_extrema, only: relative_extrema
   use vi_flight, only: flight_type
   use vi_kinds, only: wp
   use vi_law, only: holds, law_of_motion
   use vi_motion, only: complete_motion, flight_of, motion_type, no, start_motion, unknown, yes
   use vi_oscillator, only: lag, oscillator_type
   use vi_parting, only: leaves_together
   use vi_pattern, only: new_pattern
   use vi_periodic, only: linear_system_type, solve_periodic
   use vi_sample, only: sample_motion
   use vi_stability, only: multipliers, multipliers_of_half, stability_matrix
   use vi_status, only: stat
   use vi_structure, only: check_structure, new_load, new_regime, new_structure, regime_type, &
      structure_type
   use vi_structure_assess, only: by_damping, by_mass, coupling_at_instants, none
   use vi_structure_exact, only: solve_structure_exact
   implicit none (type, external)
   private

   public :: test_assess

   type(random_type) :: random

contains

   subroutine test_assess()
      call test_ballistic()
      call test_penetration()
      call test_against_samples()
      call test_acceptance()
      call test_corners()
      call test_stability_verdict()
      call test_cancelling_product()
      call test_no_approach()
      call test_rest_verdicts()
      call test_sample()
      call test_coupling_at_instants()
      call test_coupling_by_both()
      call test_coupling_in_turned_axes()
      call test_law()
      call test_leaving_together()
      call test_doubts_in_other_units()
      call test_neutral_motion()
      call test_worst_change()
      call test_structure_resonance()
   end subroutine test_assess

   !> A primary mass that hardly moves (high frequency) and a mass that moves to and fro:
   !! admissible, and with R = 1 at both walls and mu = 0 the free mass keeps its speed.
   subroutine test_ballistic()
      type(oscillator_type), parameter :: osc = oscillator_type(0.1_wp, 0.0_wp, 1.0_wp)
      type(linear_system_type) :: system
      type(motion_type) :: motions(2)
      real(wp) :: speed
      integer :: i

      call equispaced_chain(osc, 0.5_wp, 1e-2_wp, 1, paper_acceptance, .true., system, motions)
      do i = 1, 2
         if (motions(i)%status /= stat%ok) cycle
         speed = abs(motions(i)%z_dot_after(1))
         call check_close(abs(motions(i)%z_dot_before(1)), speed, 1e-12_wp, &
            'mu = 0, R = 1: speed is kept')
         call check_close(motions(i)%x_dot_before(1), motions(i)%x_dot_after(1), 1e-12_wp, &
            'mu = 0: the primary mass feels no impact')
         call check_close(motions(i)%x_max, motions(i)%amplitude, 1e-12_wp, 'mu = 0: x_max is A')
         call check_close(motions(i)%x_min, -motions(i)%amplitude, 1e-12_wp, 'mu = 0: x_min is -A')
      end do
      call check(any(motions%status == stat%ok), 'mu = 0 has equispaced motions')
      call equispaced_chain(osc, 0.5_wp, 1e-2_wp, 1, paper_acceptance, .false., system, motions)
      call check(all(motions%admissible == unknown), 'equispaced: flights were not examined')
   end subroutine test_ballistic

   !> A constructed motion: x = A sin(r t), and a free mass that crosses the slot in a
   !! straight line. In a narrow slot it reaches the far wall too early.
   subroutine test_penetration()
      type(motion_type) :: motion
      real(wp) :: half
      integer :: i, expected

      ! at r = 1/2 the steady motion alone: x = A sin(r t + tau) after both impacts, A = gain
      do i = 1, 2
         call start_motion(motion, oscillator_type(0.0_wp, 0.0_wp, 1.0_wp), 0.5_wp, &
            new_pattern('RL', 1), [1.0_wp, 1.0_wp], [0.0_wp, pi])
         motion%amplitude = 4.0_wp/3
         motion%tau = 0
         half = merge(1.0_wp, 3.0_wp, i == 1)
         motion%clearance = 2*half
         motion%x = 0
         motion%z = [half, -half]
         motion%x_dot_after = motion%amplitude*motion%r*[1, -1]
         motion%x_dot_before = motion%x_dot_after
         ! from wall to wall in half a period, as a straight line
         motion%z_dot_after = 2*half*motion%r/pi*[-1, 1]
         motion%z_dot_before = -motion%z_dot_after
         call assess_flights(motion)
         expected = merge(no, yes, i == 1)
         call check(motion%z_dot_before(1) - motion%x_dot_before(1) > 0 .eqv. i == 2, &
            'approach of the hand-built motion')
         call check(motion%admissible == expected, &
            'a wall that is passed makes a motion inadmissible')
         call check_close(motion%x_max, motion%amplitude, 1e-14_wp, &
            'x_max of the hand-built motion')
         call check_close(motion%x_min, -motion%amplitude, 1e-14_wp, &
            'x_min of the hand-built motion')
         if (i == 2) cycle
         ! the same with approach at the impacts: the only fault is that a wall is passed
         motion%x_dot_before = motion%z_dot_before - [1, -1]
         call assess_flights(motion)
         call check(motion%admissible == no, 'penetration alone makes a motion inadmissible')
      end do
   end subroutine test_penetration

   !> `admissible`, x_min and x_max compared with a time history of 2000 points per motion.
   subroutine test_against_samples()
      integer, parameter :: m = 2000
      type(motion_type) :: motion
      real(wp) :: times(m), values(6, m), period, half, rounding, slack
      logical :: approaches
      integer :: i, j, found(no:yes)

      found = 0
      do i = 1, 600
         call random_motion(random, draw_integer(random, 2, 4), motion)
         call assess_flights(motion)
         period = 2*pi*motion%pattern%cycles/motion%r
         times = [(period*j/m, j=0, m - 1)]
         call sample_motion(motion, times, values)
         half = 0.5_wp*motion%clearance
         rounding = 1e-11_wp*scale_of(motion)
         approaches = all(motion%pattern%sides*(motion%z_dot_before - motion%x_dot_before) > 0)
         if (motion%admissible == yes) then
            call check(approaches, 'admissible: the masses approach each other')
            ! with more than two impacts a flight does not quite end at the wall
            if (size(motion%x) == 2) call check(all(abs(values(5, :)) <= half + rounding), &
               'admissible: no sample is outside')
         else if (approaches) then
            slack = passed_by(motion)
            call check(slack >= 0, 'not admissible: a wall is passed')
         end if
         if (size(motion%x) > 2) cycle
         call check(motion%x_min <= minval(values(1, :)) + rounding, 'x_min')
         call check(motion%x_max >= maxval(values(1, :)) - rounding, 'x_max')
         slack = 1e-4_wp*scale_of(motion)*(1 + motion%r**2)*(1 + period)**2
         call check(motion%x_min >= minval(values(1, :)) - slack, 'x_min is reached')
         call check(motion%x_max <= maxval(values(1, :)) + slack, 'x_max is reached')
         found(motion%admissible) = found(motion%admissible) + 1
      end do
      call check(all(found > 20), 'both verdicts came up often')
   end subroutine test_against_samples

   !> The largest distance by which the free mass passes a wall.
   real(wp) function passed_by(motion)
      type(motion_type), intent(in) :: motion
      type(flight_type) :: flight
      real(wp) :: lowest, highest
      logical :: complete
      integer :: i

      passed_by = -huge(1.0_wp)
      do i = 1, size(motion%x)
         flight = flight_of(motion, i)
         call relative_extrema(flight, lowest, highest, complete)
         passed_by = max(passed_by, highest - 0.5_wp*motion%clearance, &
            -lowest - 0.5_wp*motion%clearance)
      end do
   end function passed_by

   !> `consistent` compares the residual with the caller's limit, which is included.
   subroutine test_acceptance()
      type(motion_type) :: motion
      integer :: i, n

      do i = 1, 300
         n = draw_integer(random, 3, 5)
         call random_motion(random, n, motion)
         call check(motion%consistent == unknown .and. motion%admissible == unknown .and. &
            motion%stable == unknown, 'solvers give no verdicts')
         call assess_linear(motion, motion%residual)
         call check(motion%consistent == yes, 'the accepted residual itself is accepted')
         call check(motion%admissible == unknown, 'flights were not examined')
         call assess_linear(motion, 0.999_wp*motion%residual)
         call check(motion%consistent == no, 'a larger residual is not')
      end do
      motion%status = stat%singular
      motion%consistent = unknown
      call assess_linear(motion, 1.0_wp)
      call check(motion%consistent == unknown, 'a failed motion gets no verdict')
   end subroutine test_acceptance

   !> R = 0, R = 1, mu = 0 and xi = 0, each alone and together: multipliers obey det[P].
   subroutine test_corners()
      type(oscillator_type) :: osc
      type(linear_system_type) :: system
      type(motion_type) :: motion
      real(wp) :: expected
      integer :: bits

      do bits = 0, 15
         osc%xi = merge(0.0_wp, 0.05_wp, btest(bits, 0))
         osc%mu = merge(0.0_wp, 0.1_wp, btest(bits, 1))
         osc%restitution = merge(0.0_wp, 0.6_wp, btest(bits, 2))
         if (btest(bits, 3)) osc%restitution(2) = 1
         call periodic_chain(osc, 0.8_wp, new_pattern('RL', 1), osc%restitution, &
            [0.0_wp, 1.3_wp*pi], paper_acceptance, .true., system, motion)
         call check(motion%status == stat%ok, 'corner: status')
         call check(motion%consistent == yes, 'corner: consistent')
         call check(motion%admissible /= unknown .and. (motion%stable /= unknown .or. &
            abs(abs(motion%multipliers(1)) - 1) < 1e-12_wp), 'corner: verdicts')
         expected = exp(-4*pi*osc%xi/0.8_wp)*product(osc%restitution**2)
         call check_close(product(abs(motion%multipliers)), expected, &
            1e-10_wp*(1 + abs(motion%multipliers(1))**3), 'corner: det[P]')
      end do
   end subroutine test_corners

   !> `stable` means that every multiplier is inside the unit circle.
   subroutine test_stability_verdict()
      type(motion_type) :: motion
      integer :: i, found(no:yes)

      found = 0
      do i = 1, 2000
         call random_motion(random, 2, motion)
         call assess_linear(motion, paper_acceptance)
         if (motion%stable == unknown) cycle
         found(motion%stable) = found(motion%stable) + 1
         call check((motion%stable == yes) .eqv. abs(motion%multipliers(1)) < 1, 'stable')
      end do
      call check(all(found > 20), 'stable and unstable motions came up often')
   end subroutine test_stability_verdict

   !> Where digits cancel in the product of the [P_i], rounding changes the multipliers more than
   !! the errors of the motion show: with 50 digits the leading one is outside by 7e-14.
   subroutine test_cancelling_product()
      type(motion_type) :: motion
      type(linear_system_type) :: system

      call solve_periodic(oscillator_type(0.29788814797669283_wp, 2.0968310992757824e-3_wp, &
         0.5_wp), 0.23382205255169919_wp, new_pattern('LLR', 3), spread(0.42226646020290526_wp, 1, &
         3), [0.0_wp, 3.4881738149192136_wp, 10.336533420465331_wp], system, motion)
      call assess_linear(motion, paper_acceptance)
      call check(abs(abs(motion%multipliers(1)) - 1) < 1e-11_wp, 'cancelling product: near 1')
      call check(motion%stable == unknown, 'cancelling product: stability is unknown')
   end subroutine test_cancelling_product

   !> An impact without approach: the motion is returned, with unknown stability.
   subroutine test_no_approach()
      type(motion_type) :: motion

      call start_motion(motion, oscillator_type(0.1_wp, 0.2_wp, 0.5_wp), 1.3_wp, &
         new_pattern('RL', 1), [0.5_wp, 0.5_wp], [0.0_wp, pi])
      motion%x = 0
      motion%z = 0
      motion%x_dot_after = 0
      motion%z_dot_after = 0
      motion%x_dot_before = 0
      motion%z_dot_before = 0
      call assess_linear(motion, paper_acceptance)
      call check(motion%status == stat%ok, 'no approach: the motion stands')
      call check(motion%stable == unknown, 'no approach: stability is unknown')
      call assess_flights(motion)
      call check(motion%admissible == no, 'no approach: not admissible')
      ! a solution without load is not a motion
      call complete_motion(motion, [1.0_wp, -1.0_wp], 0.0_wp, 0.0_wp, 1.0_wp)
      call check(motion%status == stat%no_load, 'A = 0 is no motion')
   end subroutine test_no_approach

   !> A motion with rest is stable if both multipliers are inside the unit circle, unknown if
   !! rounding may move the leading one across it, and not admissible if its period does not close.
   subroutine test_rest_verdicts()
      type(motion_type) :: motion
      real(wp) :: map(2, 2)
      integer :: i

      map = reshape([0.9_wp, 0.0_wp, 0.3_wp, 0.2_wp], [2, 2])
      motion%residual = 1e-12_wp
      motion%multipliers = [0.9_wp, 0.2_wp, 0.0_wp, 0.0_wp]
      call assess_rest(map, 0.0_wp, motion)
      call check(all([motion%consistent, motion%admissible, motion%stable] == yes), 'rest: stable')
      call move_to(1.1_wp)
      call assess_rest(map, 0.0_wp, motion)
      call check(motion%stable == no, 'rest: unstable')
      call move_to(1 + 1e-13_wp)
      call assess_rest(map, 0.0_wp, motion)
      call check(motion%stable == unknown, 'rest: on the circle')
      call move_to(1 - 1e-5_wp)
      call assess_rest(map, 1e-8_wp, motion)
      call check(motion%stable == yes, 'rest: near the circle, but certain')
      call assess_rest(map, 1e-5_wp, motion)
      call check(motion%stable == unknown, 'rest: near the circle, and not certain')
      ! the same with the other sign, as at a doubling of the period
      call move_to(-1 + 1e-5_wp)
      call assess_rest(map, 1e-8_wp, motion)
      call check(motion%stable == yes, 'rest: near -1, but certain')
      call assess_rest(map, 1e-5_wp, motion)
      call check(motion%stable == unknown, 'rest: near -1, and not certain')
      call move_to(-1.1_wp)
      call assess_rest(map, 0.0_wp, motion)
      call check(motion%stable == no, 'rest: beyond -1')
      ! the conditions lose digits to a large entry of either sign
      call move_to(0.9_wp)
      map(2, 1) = 0
      do i = -1, 1, 2
         map(1, 2) = i*1e4_wp
         call assess_rest(map, 0.0_wp, motion)
         call check(motion%stable == unknown, 'rest: a large entry')
         map(1, 2) = i*1e3_wp
         call assess_rest(map, 0.0_wp, motion)
         call check(motion%stable == yes, 'rest: an entry that is not as large')
      end do
      ! far from the circle the uncertainty does not matter; on it, to rounding, the map does not
      do i = -1, 1, 2
         call move_to(0.9_wp*i)
         call assess_rest(map, 1.0_wp, motion)
         call check(motion%stable == yes, 'rest: far from the circle')
         motion%multipliers(1) = i*(1 - 1e-13_wp)
         call assess_rest(map, 0.0_wp, motion)
         call check(motion%stable == unknown, 'rest: a multiplier on the circle')
      end do
      motion%stable = yes
      motion%status = stat%no_motion
      call assess_rest(2*map, 0.0_wp, motion)
      call check(motion%stable == yes, 'rest: no verdicts on what is no motion')
      motion%status = stat%ok
      motion%residual = 1e-8_wp
      call assess_rest(map, 0.0_wp, motion)
      call check(motion%consistent == no .and. motion%admissible == unknown, 'rest: not closed')
   contains
      subroutine move_to(leading)
         real(wp), intent(in) :: leading

         map(1, 1) = leading
         motion%multipliers(1) = leading
      end subroutine move_to
   end subroutine test_rest_verdicts

   !> The time history passes through the impacts, is periodic, and has the velocities after an
   !! impact at the time of the impact.
   subroutine test_sample()
      type(motion_type) :: motion
      real(wp), parameter :: brief = 1e-9_wp
      real(wp) :: values(6, 2), later(6, 2), times(2), period, scale, t
      integer :: i, j

      do i = 1, 1000
         call random_motion(random, 2, motion)
         scale = scale_of(motion)*(1 + motion%r**2)
         period = 2*pi*motion%pattern%cycles/motion%r
         do j = 1, 2
            t = motion%phases(j)/motion%r
            times = [t, t - brief]
            call sample_motion(motion, times, values)
            call check_close(values(1, 1), motion%x(j), 1e-13_wp*scale, 'sample at an impact: x')
            call check_close(values(3, 1), motion%z(j), 1e-13_wp*scale, 'sample at an impact: z')
            call check_close(values(2, 1), motion%x_dot_after(j), 1e-13_wp*scale, &
               'velocity after: x')
            call check_close(values(4, 1), motion%z_dot_after(j), 0.0_wp, 'velocity after: z')
            call check_close(values(2, 2), motion%x_dot_before(j), 1e-8_wp*scale, &
               'velocity before: x')
            call check_close(values(4, 2), motion%z_dot_before(j), 1e-13_wp*scale, &
               'velocity before: z')
            call check_close(values(1, 2), motion%x(j), 1e-8_wp*scale, 'x is continuous')
            call check_close(values(3, 2), motion%z(j), 1e-8_wp*scale, 'z is continuous')
         end do
         times(1) = draw(random, 0.0_wp, period)
         times(2) = draw(random, -period, period)
         call sample_motion(motion, times, values)
         call sample_motion(motion, times + 3*period, later)
         call check_close(maxval(abs(values([1, 3, 5, 6], :) - later([1, 3, 5, 6], :))), 0.0_wp, &
            1e-11_wp*scale*(1 + period), 'the time history is periodic')
         call check_close(values(5, 1), values(3, 1) - values(1, 1), 0.0_wp, 'y = z - x')
         ! a whole period later is the period itself by rounding
         times = [0.0_wp, -tiny(1.0_wp)]
         call sample_motion(motion, times, later)
         call check(all(abs(later(:5, 1) - later(:5, 2)) <= 0), 'just before the first impact')
         times(1) = draw(random, 0.0_wp, period)
         call sample_motion(motion, times, values)
         call check_close(values(6, 1), sin(motion%r*times(1) + motion%tau &
            + lag(motion%osc%xi, motion%r)), 1e-12_wp, 'load')
      end do
   end subroutine test_sample

   !> Two masses, each at a separate wall: simultaneous impacts are coupled by the mass matrix,
   !! otherwise by the damping, whatever the signs.
   subroutine test_coupling_at_instants()
      real(wp), parameter :: both(3) = [-0.2_wp, 0.0_wp, 0.2_wp]
      type(structure_type) :: structure
      real(wp) :: matrices(2, 2, 3)
      integer :: i, j, k, status

      do i = 1, size(both)
         do j = 1, size(both)
            matrices = reshape([1.0_wp, both(i), both(i), 2.0_wp, 0.3_wp, both(j), both(j), &
               0.5_wp, 1.0_wp, 0.1_wp, 0.1_wp, 1.0_wp], [2, 2, 3])
            structure = new_structure(matrices, reshape([1.0_wp, 0.0_wp, 0.0_wp, -1.0_wp], &
               [2, 2]), reshape([1.0_wp, 0.5_wp, 1.0_wp, 0.5_wp], [2, 2]))
            call check_structure(structure, status)
            call check(status == stat%ok, 'a structure is accepted')
            k = merge(by_mass, merge(by_damping, none, abs(both(j)) > 0), abs(both(i)) > 0)
            call check(coupling_at_instants(structure, [1, 2], [1, 1]) == k, 'two at one instant')
            call check(coupling_at_instants(structure, [1, 2], [1, 2]) == none, &
               'one after the other')
            call check(coupling_at_instants(structure, [1, 2, 1], [1, 2, 2]) == k, &
               'only the last two')
         end do
      end do
   end subroutine test_coupling_at_instants

   !> Of three masses two are coupled by mass, and each of them by damping with the third one:
   !! only the coupling by mass counts for the impacts.
   subroutine test_coupling_by_both()
      integer, parameter :: orders(3, 6) = reshape([1, 2, 3, 1, 3, 2, 2, 1, 3, 2, 3, 1, 3, 1, 2, &
         3, 2, 1], [3, 6])
      type(structure_type) :: structure
      real(wp) :: matrices(3, 3, 3), directions(3, 3)
      integer :: i, status

      matrices = 0
      directions = 0
      do i = 1, 3
         matrices(i, i, :) = [1.0_wp, 0.3_wp, 1.0_wp]
         directions(i, i) = 1
      end do
      matrices(1, 2, 1) = 0.2_wp
      matrices(2, 1, 1) = 0.2_wp
      matrices(1:2, 3, 2) = -0.1_wp
      matrices(3, 1:2, 2) = -0.1_wp
      structure = new_structure(matrices, directions, spread([1.0_wp, 0.5_wp], 2, 3))
      call check_structure(structure, status)
      call check(status == stat%ok, 'three masses are accepted')
      do i = 1, size(orders, 2)
         call check(coupling_at_instants(structure, orders(:, i), [1, 1, 1]) == by_mass, &
            'coupled by mass and by damping')
         call check(coupling_at_instants(structure, orders(:, i), [1, 2, 2]) == merge(by_mass, &
            by_damping, orders(1, i) == 3), 'the last two of three')
      end do
   end subroutine test_coupling_by_both

   !> Two uncoupled masses, in axes rotated by any angle: the terms of their coupling cancel except
   !! for rounding, which does not count. A small additional coupling counts.
   subroutine test_coupling_in_turned_axes()
      type(structure_type) :: structure
      real(wp) :: turn(2, 2), matrices(2, 2, 3), part(2, 2), angle
      integer :: i, k, kind, status, expected

      do i = 1, 600
         angle = draw(random, 0.0_wp, 2*pi)
         turn = reshape([cos(angle), -sin(angle), sin(angle), cos(angle)], [2, 2])
         kind = mod(i, 3)
         expected = merge(by_mass, merge(by_damping, none, kind == 2), kind == 1)
         do k = 1, 3
            part = reshape([1.0_wp, 0.0_wp, 0.0_wp, merge(1.0_wp, 0.5_wp, k == 1)], [2, 2])
            if (k == kind) part(1, 2) = 1e-3_wp*(-1)**i
            part(2, 1) = part(1, 2)
            matrices(:, :, k) = matmul(transpose(turn), matmul(part, turn))
            matrices(2, 1, k) = matrices(1, 2, k)
         end do
         structure = new_structure(matrices, transpose(turn), spread([1.0_wp, 0.5_wp], 2, 2))
         call check_structure(structure, status)
         call check(status == stat%ok, 'turned axes: accepted')
         call check(coupling_at_instants(structure, [1, 2], [1, 1]) == expected, &
            'turned axes: coupling')
      end do
   end subroutine test_coupling_in_turned_axes

   !> The law allows the error of the motion over its relative approach speed, whatever the signs
   !! of the speeds and of the entries; it has no verdict for huge entries.
   subroutine test_law()
      real(wp), parameter :: error = 1e-6_wp, speeds(2, 6) = reshape([1.0_wp, 1e-6_wp, 1.0_wp, &
         -1e-6_wp, 1e-6_wp, 1.0_wp, -1e-6_wp, 1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp, 0.5_wp], [2, 6])
      type(motion_type) :: motion
      real(wp) :: p(4, 4), law, clear
      integer :: i, j, k

      call start_motion(motion, oscillator_type(0.1_wp, 0.2_wp, 0.5_wp), 1.3_wp, &
         new_pattern('RL', 1), [0.5_wp, 0.5_wp], [0.0_wp, pi])
      motion%residual = error
      motion%rounding = 0
      law = law_of_motion(motion)
      do i = 1, size(speeds, 2)
         do k = -1, 1, 2
            motion%z_dot_before = k*speeds(1, i)
            motion%x_dot_before = k*speeds(2, i)
            clear = abs(speeds(1, i) - speeds(2, i))/maxval(abs(speeds(:, i)))
            do j = -1, 1, 2
               call set_determinant(law*(1 + 50*j*error/clear))
               call check(holds(motion, p), 'law: within the error')
               call set_determinant(law*(1 + 200*j*error/clear))
               call check(.not. holds(motion, p), 'law: beyond the error')
            end do
         end do
      end do
      do k = -1, 1, 2
         p = 0
         p(1, 2) = k*1e100_wp
         call check(.not. holds(p, 0.0_wp, 0.0_wp), 'law: a huge entry')
      end do
   contains
      !> A matrix with entries of both signs.
      subroutine set_determinant(wanted)
         real(wp), intent(in) :: wanted

         p = 0
         p(1, 1) = -wanted
         p(2, 2) = -1
         p(3, 3) = 1
         p(4, 4) = 1
         p(1, 4) = -0.5_wp
      end subroutine set_determinant
   end subroutine test_law

   !> Masses leave together if their velocities differ by rounding of the largest velocity, of
   !! either sign, after the impact or before it.
   subroutine test_leaving_together()
      real(wp), parameter :: unit = epsilon(1.0_wp)
      integer :: j, k

      do k = -1, 1, 2
         do j = -1, 1, 2
            call check(leaves_together(k*1.0_wp, k*(1 + 10*j*unit), 0.0_wp) .and. &
               leaves_together(10*j*unit, 0.0_wp, k*1.0_wp), 'together: to rounding')
            call check(.not. leaves_together(k*1.0_wp, k*(1 + 20*j*unit), 0.0_wp) .and. &
               .not. leaves_together(20*j*unit, 0.0_wp, k*1.0_wp), 'together: not quite')
            ! only one of them moves
            call check(.not. leaves_together(k*1.0_wp, 0.0_wp, j*1.0_wp) .and. &
               .not. leaves_together(0.0_wp, k*1.0_wp, j*1.0_wp), 'together: not at all')
         end do
         call check(leaves_together(k*1.0_wp, k*1.0_wp, 0.0_wp), 'together: exactly')
      end do
   end subroutine test_leaving_together

   !> Without damping and mass ratio a free oscillation that fits into the period changes nothing:
   !! the equations of the motion are singular, so that nothing about it is certain.
   subroutine test_neutral_motion()
      type(motion_type) :: motion
      real(wp) :: p(4, 4), half
      complex(wp) :: lambda(4)
      integer :: i, status

      do i = 1, 2
         call start_motion(motion, oscillator_type(0.0_wp, 0.0_wp, 1.0_wp), 0.5_wp, &
            new_pattern('RL', 1), [1.0_wp, 1.0_wp], [0.0_wp, pi])
         motion%amplitude = 4.0_wp/3
         motion%tau = 0
         ! in the second motion the masses meet without approach
         half = merge(3.0_wp, 0.5_wp*pi*motion%amplitude, i == 1)
         motion%clearance = 2*half
         motion%x = 0
         motion%z = [half, -half]
         motion%x_dot_after = motion%amplitude*motion%r*[1, -1]
         motion%x_dot_before = motion%x_dot_after
         motion%z_dot_after = 2*half*motion%r/pi*[-1, 1]
         motion%z_dot_before = -motion%z_dot_after
         call stability_matrix(motion, p, status)
         call check(status == merge(stat%ok, stat%zero_approach, i == 1), 'neutral: approach')
         call multipliers(motion, lambda, status)
         motion%multipliers = lambda
         call check(unknowns_doubt(motion) > 1e6_wp, 'neutral: no position is certain')
         call check_refusals(motion)
         call check(modulus_doubt(motion) >= huge(1.0_wp), 'neutral: no multiplier is certain')
         call check((spread_of_orders(motion, abs(lambda(1))) >= huge(1.0_wp)) .eqv. i == 2, &
            'neutral: no maps without approach')
      end do
      call check(greater(1.0_wp, 2.0_wp) <= 2 .and. greater(2.0_wp, 1.0_wp) >= 2 .and. &
         greater(-1.0_wp, -2.0_wp) >= -1, 'the greater of two numbers')
      ! the derivative of half a period may be infinite
      p = huge(1.0_wp)
      p(2, 3) = ieee_value(1.0_wp, ieee_positive_inf)
      call multipliers_of_half(p, lambda, status)
      call check(status == stat%not_finite .and. all(abs(lambda) <= 0), 'no multipliers of it')
   contains
      !> If too few digits are left a motion with a verdict is refused, but not next to a fold.
      subroutine check_refusals(uncertain)
         type(motion_type), intent(in) :: uncertain
         type(motion_type) :: other
         integer :: k

         do k = 1, 4
            other = uncertain
            other%status = merge(stat%no_motion, stat%ok, k == 2)
            other%stable = merge(unknown, yes, k == 3)
            other%multipliers = [-1.0_wp, 0.5_wp, merge(1.0005_wp, 0.3_wp, k == 4), 0.0_wp]
            call refuse_rounding(other)
            call check(other%status == merge(stat%lost_digits, merge(stat%no_motion, stat%ok, &
               k == 2), k == 1), 'neutral: refused')
         end do
      end subroutine check_refusals
   end subroutine test_neutral_motion

   !> x + y = a and x - y = b, each with an error: the worst change is that of the unknown that
   !! changes most in its unit.
   subroutine test_worst_change()
      real(wp), parameter :: rounding(2) = [0.5_wp, 0.25_wp], units(2) = [1.0_wp, 3.0_wp], &
         sums(2, 2) = reshape([1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp], [2, 2])
      real(wp) :: change(2)
      logical :: regular

      call worst_change(sums, rounding, units, change, regular)
      call check(regular .and. all(abs(change - [0.375_wp, 0.125_wp]) < 1e-15_wp), &
         'the worst change of the first unknown')
      call worst_change(sums, rounding, units([2, 1]), change, regular)
      call check(regular .and. all(abs(change - [0.125_wp, 0.375_wp]) < 1e-15_wp), &
         'the worst change of the second unknown')
      call worst_change(abs(sums), rounding, units, change, regular)
      call check(.not. regular .and. all(abs(change) <= 0), 'no change of singular equations')
   end subroutine test_worst_change

   !> A mass without damping whose natural period fits into that of the motion, or nearly fits.
   subroutine test_structure_resonance()
      type(structure_type) :: structure
      type(regime_type) :: regime
      real(wp) :: times(1), speeds(1), offsets(0), residual, period
      integer :: i, status, steps

      structure = new_structure(reshape([1.0_wp, 0.0_wp, 1.0_wp], [1, 1, 3]), reshape([1.0_wp], &
         [1, 1]), reshape([1.0_wp, 0.5_wp], [2, 1]))
      call check_structure(structure, status)
      call new_regime(structure, new_load(2.0_wp, reshape([1.0_wp, 0.0_wp], [1, 2, 1]), [0.0_wp]), &
         [integer ::], regime, status)
      do i = 1, 2
         period = 2*pi*merge(1.0_wp, 1.25_wp, i == 1)
         times = 0.3_wp
         speeds = 1
         call solve_structure_exact(structure, regime, [1], times, period, speeds, offsets, 50, &
            residual, steps, status)
         call check((status == stat%resonance) .eqv. i == 1, 'a period that resonates')
      end do
   end subroutine test_structure_resonance

   !> The estimated errors of a motion do not depend on the unit of length.
   subroutine test_doubts_in_other_units()
      real(wp), parameter :: units(2) = [1024.0_wp, 2.0_wp**(-12)]
      type(motion_type) :: motion, other
      integer :: i, j

      do i = 1, 100
         call random_motion(random, draw_integer(random, 2, 4), motion)
         call assess_linear(motion, paper_acceptance)
         do j = 1, size(units)
            other = motion
            other%x = units(j)*motion%x
            other%z = units(j)*motion%z
            other%x_dot_before = units(j)*motion%x_dot_before
            other%x_dot_after = units(j)*motion%x_dot_after
            other%z_dot_before = units(j)*motion%z_dot_before
            other%z_dot_after = units(j)*motion%z_dot_after
            other%amplitude = units(j)*motion%amplitude
            other%clearance = units(j)*motion%clearance
            call check_close(unknowns_doubt(other), unknowns_doubt(motion), &
               1e-6_wp*unknowns_doubt(motion), 'the doubt in unknowns, in another unit of length')
            ! a difference of moduli, in which rounding differs
            call check_close(modulus_doubt(other), modulus_doubt(motion), &
               0.3_wp*modulus_doubt(motion) + 1e-12_wp, &
               'the doubt in a modulus, in another unit of length')
         end do
      end do
   end subroutine test_doubts_in_other_units

end module motions_assess
