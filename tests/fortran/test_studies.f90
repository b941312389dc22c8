!> Tests of studies: many points in one call, and the same in single precision.
program test_studies
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use checks, only: check, check_close, finish
   use random_numbers, only: draw_integer, draw_log, random_type
   use random_systems, only: pi, random_frequency, random_motion, random_oscillator, &
      random_phases, random_sides
   use studies_atlas, only: test_atlas, test_limits, test_outcomes, test_rings, &
      test_bent_sides, test_shared_simulations
   use studies_attractors, only: test_attractors
   use studies_boundaries, only: test_boundaries
   use studies_branches, only: test_branches
   use studies_conditions, only: test_conditions
   use studies_families, only: test_families
   use studies_found, only: test_found
   use studies_joints, only: test_condition_names, test_corners_at_joints, test_joints, &
      test_short_curves
   use studies_symbols, only: test_symbols
   use studies_rest, only: test_rest
   use studies_rows, only: test_largest, test_rows
   use studies_spans, only: test_spans
   use studies_states, only: test_states
   use studies_steps, only: test_steps
   use studies_surfaces, only: test_surfaces
   use studies_switching, only: test_switching
   use studies_trajectories, only: test_trajectories
   use studies_structures, only: test_structures
   use studies_structure_conditions, only: test_structure_conditions
   use studies_structure_arrays, only: test_structure_arrays
   use studies_structure_motions, only: test_structure_motions
   use studies_structure_pair, only: test_structure_pair
   use studies_structure_runs, only: test_structure_runs
   use studies_structure_slopes, only: test_structure_slopes
   use vi_assess, only: paper_acceptance
   use vi_branch_switching, only: at_grazing, most_switched, switch_branch
   use vi_chain, only: equispaced_chain, periodic_chain
   use vi_flags, only: stability_flags
   use vi_kinds, only: wp
   use vi_kinds_single, only: sp => wp
   use vi_motion, only: motion_type, unknown, yes
   use vi_orbit, only: by_clearance
   use vi_oscillator, only: gain, oscillator_type
   use vi_pattern, only: new_pattern, pattern_type
   use vi_periodic, only: linear_system_type
   use vi_plan, only: most_impacts
   use vi_points, only: equispaced_points, periodic_points, recall
   use vi_precision, only: equispaced_in_single, periodic_in_single
   use vi_sample, only: sample_motion
   use vi_status, only: stat
   implicit none (type, external)

   !> Results of `m` points of `n` impacts.
   type :: results_type
      real(wp), allocatable :: impacts(:, :, :), scalars(:, :)
      complex(wp), allocatable :: multipliers(:, :)
      integer, allocatable :: verdicts(:, :), status(:)
   end type results_type

   type(random_type) :: random

   call test_batch()
   call test_equispaced_batch()
   call test_failed_point()
   call test_recall()
   call test_flags()
   call test_single()
   call test_rings()
   call test_bent_sides()
   call test_joints()
   call test_short_curves()
   call test_corners_at_joints()
   call test_condition_names()
   call test_atlas()
   call test_outcomes()
   call test_limits()
   call test_shared_simulations()
   call test_boundaries()
   call test_branches()
   call test_conditions()
   call test_found()
   call test_switching_away_from_a_graze()
   call test_switching()
   call test_symbols()
   call test_rest()
   call test_rows()
   call test_largest()
   call test_spans()
   call test_states()
   call test_steps()
   call test_surfaces()
   call test_trajectories()
   call test_structures()
   call test_structure_arrays()
   call test_structure_motions()
   call test_structure_pair()
   call test_structure_runs()
   call test_structure_slopes()
   call test_families()
   call test_structure_conditions()
   call test_attractors()
   call finish()

contains

   !> If a flight touches no wall, a motion with one more impact is found only by chance; if
   !! so, it is admissible.
   subroutine test_switching_away_from_a_graze()
      type(motion_type) :: motion, found(most_switched)
      integer :: i, n, none

      none = 0
      do i = 1, 200
         call random_motion(random, 2, motion)
         n = 99
         call switch_branch(motion, at_grazing, 1, 3 - 2*draw_integer(random, 1, 2), by_clearance, &
            .false., found, n)
         call check(n >= 0 .and. n <= most_switched, 'switching: as many as were found')
         if (n == 0) none = none + 1
         if (n > 0) call check(size(found(1)%x) == 3 .and. found(1)%admissible == yes, &
            'switching: one more impact')
      end do
      call check(none > 100, 'switching: mostly nothing is found')
   end subroutine test_switching_away_from_a_graze

   pure function empty_results(n, m) result(results)
      integer, intent(in) :: n, m
      type(results_type) :: results

      allocate (results%impacts(n, 6, m), results%scalars(6, m), results%multipliers(4, m), &
         results%verdicts(3, m), results%status(m))
   end function empty_results

   !> Equal bit for bit, including not-a-number.
   elemental logical function same(a, b)
      real(wp), intent(in) :: a, b

      same = ieee_is_nan(a) .and. ieee_is_nan(b)
      if (.not. (ieee_is_nan(a) .or. ieee_is_nan(b))) same = a >= b .and. a <= b
   end function same

   !> Whether column j of one result is column i of another.
   pure logical function same_point(a, j, b, i)
      type(results_type), intent(in) :: a, b
      integer, intent(in) :: i, j

      same_point = all(same(a%impacts(:, :, j), b%impacts(:, :, i))) .and. &
         all(same(a%scalars(:, j), b%scalars(:, i))) .and. &
         all(same(real(a%multipliers(:, j)), real(b%multipliers(:, i)))) .and. &
         all(same(aimag(a%multipliers(:, j)), aimag(b%multipliers(:, i)))) .and. &
         all(a%verdicts(:, j) == b%verdicts(:, i)) .and. a%status(j) == b%status(i)
   end function same_point

   !> Many points in one call have the bits of single calls, in any order and precision.
   subroutine test_batch()
      integer, parameter :: m = 12
      type(oscillator_type) :: osc
      type(pattern_type) :: pattern
      type(results_type) :: many, one, reversed
      real(wp), allocatable :: phases(:, :), restitution(:)
      real(wp) :: r(m)
      logical :: single, flights
      integer :: i, j, n

      do i = 1, 100
         n = draw_integer(random, 2, 6)
         single = mod(i, 2) == 0
         flights = mod(i, 3) > 0
         call random_oscillator(random, osc)
         pattern = new_pattern(repeat('R', n), draw_integer(random, 1, 2))
         call random_sides(random, pattern%sides)
         allocate (phases(n, m))
         restitution = spread(0.7_wp, 1, n)
         do j = 1, m
            r(j) = random_frequency(random)
            call random_phases(random, pattern%cycles, phases(:, j))
         end do
         many = points(osc, r, pattern, restitution, phases, single, flights)
         reversed = points(osc, r(m:1:-1), pattern, restitution, phases(:, m:1:-1), single, flights)
         do j = 1, m
            one = points(osc, r(j:j), pattern, restitution, phases(:, j:j), single, flights)
            call check(same_point(many, j, one, 1), 'a batch is many single calls')
            call check(same_point(many, j, reversed, m + 1 - j), &
               'the order of points does not matter')
            if (many%status(j) /= stat%ok) cycle
            call check((many%verdicts(2, j) == unknown .and. &
               all(ieee_is_nan(many%scalars(5:6, j)))) &
               .neqv. flights, 'flights are examined on request alone')
         end do
         deallocate (phases)
      end do
   end subroutine test_batch

   pure function points(osc, r, pattern, restitution, phases, single, flights) result(results)
      type(oscillator_type), intent(in) :: osc
      type(pattern_type), intent(in) :: pattern
      real(wp), intent(in) :: r(:), restitution(:), phases(:, :)
      logical, intent(in) :: single, flights
      type(results_type) :: results

      results = empty_results(size(phases, 1), size(r))
      call periodic_points(osc, r, pattern, restitution, phases, paper_acceptance, single, &
         flights, results%impacts, results%scalars, results%multipliers, results%verdicts, &
         results%status)
   end function points

   !> Verdicts on motions with about the largest number of impacts that is computed side by side.
   subroutine test_flags()
      integer, parameter :: m = 70
      type(oscillator_type) :: osc
      type(pattern_type) :: pattern
      type(linear_system_type) :: system
      type(motion_type) :: motion
      real(wp), allocatable :: phases(:, :), restitution(:)
      real(wp) :: r(m), radius(m)
      integer :: consistent(m), stable(m), status(m), i, j, k, n, referred

      do i = 1, 12
         n = most_impacts - 2 + mod(i, 4)
         osc = oscillator_type(0.01_wp*i, 0.02_wp, [0.7_wp, 0.6_wp])
         pattern = new_pattern(repeat('R', n), n/2)
         call random_sides(random, pattern%sides)
         allocate (phases(m, n))
         restitution = osc%restitution(merge(1, 2, pattern%sides > 0))
         do j = 1, m
            r(j) = random_frequency(random)
            call random_phases(random, pattern%cycles, phases(j, :))
         end do
         call stability_flags(osc, r, pattern, restitution, phases, paper_acceptance, mod(i, 2) == &
            0, 2, i > 6, consistent, stable, radius, status, referred)
         call check(merge(referred < m, referred == m, n <= most_impacts), &
            'flags: most points are not referred')
         do j = 1, m
            call periodic_chain(osc, r(j), pattern, restitution, phases(j, :), paper_acceptance, &
               .false., system, motion)
            call check(status(j) == motion%status .and. consistent(j) == motion%consistent .and. &
               stable(j) == motion%stable, 'flags: verdicts of the reference chain')
            k = merge(1, 0, mod(i, 2) == 0 .and. motion%status == stat%ok)
            call check((k == 0) .eqv. ieee_is_nan(radius(j)), 'flags: a radius where it is wanted')
            if (k == 1) call check_close(radius(j), abs(motion%multipliers(1)), &
               1e-9_wp*radius(j), 'flags: radius')
         end do
         deallocate (phases)
      end do
   end subroutine test_flags

   !> Equispaced points equal those of the chain, two columns per point; missing motions are NaN.
   subroutine test_equispaced_batch()
      integer, parameter :: m = 200
      type(oscillator_type) :: osc
      type(linear_system_type) :: system
      type(motion_type) :: motions(2)
      type(results_type) :: many
      real(wp) :: r(m), clearance(m)
      integer :: i, j, column, missing

      osc = oscillator_type(0.01_wp, 0.05_wp, [0.8_wp, 0.8_wp])
      do j = 1, m
         r(j) = random_frequency(random)
         clearance(j) = gain(osc%xi, r(j))*draw_log(random, 0.1_wp, 100.0_wp)
      end do
      many = empty_results(2, 2*m)
      call equispaced_points(osc, r, clearance, 1, paper_acceptance, .false., .true., &
         many%impacts, many%scalars, many%multipliers, many%verdicts, many%status)
      missing = 0
      do j = 1, m
         call equispaced_chain(osc, r(j), clearance(j), 1, paper_acceptance, .true., system, &
            motions)
         do i = 1, 2
            column = 2*(j - 1) + i
            call check(many%status(column) == motions(i)%status, 'equispaced points: status')
            if (motions(i)%status == stat%ok) then
               call check(all(same(many%impacts(:, 1, column), motions(i)%x)), &
                  'equispaced points: x')
               call check(same(many%scalars(6, column), motions(i)%x_max), &
                  'equispaced points: x_max')
            else
               missing = missing + 1
               call check_all_nan(many, column)
            end if
         end do
      end do
      call check(missing > 10 .and. missing < 2*m - 10, 'motions that exist, and that do not')
      many = empty_results(2, 2*m)
      call equispaced_points(osc, r, clearance, 1, paper_acceptance, .true., .true., &
         many%impacts, many%scalars, many%multipliers, many%verdicts, many%status)
      do j = 1, m
         call equispaced_in_single(osc, r(j), clearance(j), 1, paper_acceptance, .true., motions)
         do i = 1, 2
            column = 2*(j - 1) + i
            call check(many%status(column) == motions(i)%status, 'in single precision: status')
            if (motions(i)%status == stat%ok) then
               call check(all(same(many%impacts(:, 1, column), motions(i)%x)), &
                  'in single precision: x')
               call check(all(abs(motions(i)%x - narrowed_number(motions(i)%x)) <= 0), &
                  'in single precision: x has no more than 32 bits')
            else
               call check_all_nan(many, column)
            end if
         end do
      end do
   end subroutine test_equispaced_batch

   subroutine check_all_nan(results, j)
      type(results_type), intent(in) :: results
      integer, intent(in) :: j

      call check(all(ieee_is_nan(results%impacts(:, :, j))), 'a failed point has no impacts')
      call check(all(ieee_is_nan(results%scalars(:, j))), 'a failed point has no scalars')
      call check(all(ieee_is_nan(real(results%multipliers(:, j)))), &
         'a failed point has no multipliers')
      call check(all(results%verdicts(:, j) == unknown), 'a failed point has no verdicts')
   end subroutine check_all_nan

   !> One failed point among others keeps its status and NaN; the others do not change.
   subroutine test_failed_point()
      type(oscillator_type), parameter :: osc = oscillator_type(0.005_wp, 0.042_wp, &
         [0.75_wp, 0.75_wp])
      type(results_type) :: with, without
      real(wp) :: phases(2, 5)
      integer :: i, j

      phases(1, :) = 0
      phases(2, :) = pi*[1.2_wp, 1.37_wp, 1.0_wp, 1.4_wp, 0.7_wp]
      do i = 1, 2
         with = points(osc, spread(0.94_wp, 1, 5), new_pattern('RL', 1), osc%restitution, phases, &
            i == 2, .true.)
         without = points(osc, spread(0.94_wp, 1, 4), new_pattern('RL', 1), osc%restitution, &
            phases(:, [1, 2, 4, 5]), i == 2, .true.)
         call check(with%status(3) == stat%free_amplitude, 'the failed point keeps its status')
         call check_all_nan(with, 3)
         do j = 1, 4
            call check(without%status(j) == stat%ok, 'the other points are computed')
            call check(same_point(with, merge(j, j + 1, j <= 2), without, j), &
               'other points do not notice')
         end do
      end do
   end subroutine test_failed_point

   !> A stored motion gives the time history of the original.
   subroutine test_recall()
      type(motion_type) :: motion, copy
      real(wp) :: times(50), values(6, 50), again(6, 50), impacts(2, 6)
      integer :: i, j

      do i = 1, 300
         call random_motion(random, 2, motion)
         impacts = reshape([motion%x, motion%z, motion%x_dot_before, motion%x_dot_after, &
            motion%z_dot_before, motion%z_dot_after], [2, 6])
         copy = recall(motion%osc, motion%r, motion%pattern, motion%restitution, motion%phases, &
            impacts, motion%amplitude, motion%tau)
         times = [(0.37_wp*j, j=1, 50)]
         call sample_motion(motion, times, values)
         call sample_motion(copy, times, again)
         call check(all(same(values, again)), 'a recalled motion has the same time history')
      end do
   end subroutine test_recall

   !> In 32 bits the motion is the same, to the digits that 32 bits and the condition of the
   !! problem allow.
   !!
   !! The condition is estimated from the effect of rounding the data on the double precision
   !! result.
   subroutine test_single()
      type(motion_type) :: motion, narrow, rounded
      type(linear_system_type) :: system
      real(wp) :: scale, error, data_error
      integer :: i, n, agreeing, examined

      agreeing = 0
      examined = 0
      do i = 1, 1000
         n = draw_integer(random, 2, 5)
         call random_motion(random, n, motion)
         associate (m => motion)
            call periodic_in_single(m%osc, m%r, m%pattern, m%restitution, m%phases, &
               paper_acceptance, .false., narrow)
            call periodic_chain(narrowed(m%osc), narrowed_number(m%r), m%pattern, &
               narrowed_number(m%restitution), narrowed_number(m%phases), paper_acceptance, &
               .false., system, rounded)
         end associate
         if (narrow%status /= stat%ok .or. rounded%status /= stat%ok) cycle
         scale = maxval(abs(motion%x)) + motion%clearance
         error = maxval(abs(narrow%x - motion%x))/scale
         data_error = maxval(abs(rounded%x - motion%x))/scale
         examined = examined + 1
         if (error < 30*data_error + 1e-5_wp) agreeing = agreeing + 1
         call check(all(abs(narrow%x - real(narrow%x, sp)) <= 0), 'x has no more than 32 bits')
         call check(all(abs(narrow%phases - motion%phases) <= 0), 'given phases keep their digits')
      end do
      call check(examined > 800, 'single precision solves most systems')
      call check(agreeing > 0.95_wp*examined, 'single precision agrees to its digits')
   end subroutine test_single

   elemental real(wp) function narrowed_number(x)
      real(wp), intent(in) :: x

      narrowed_number = real(real(x, sp), wp)
   end function narrowed_number

   pure type(oscillator_type) function narrowed(osc)
      type(oscillator_type), intent(in) :: osc

      narrowed = oscillator_type(narrowed_number(osc%xi), narrowed_number(osc%mu), &
         narrowed_number(osc%restitution))
   end function narrowed

end program test_studies
