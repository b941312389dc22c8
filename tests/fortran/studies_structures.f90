!> Periodic motions of structures: the determinant of [P], and motions with rest.
module studies_structures
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, draw_log, fill, random_type
   use vi_kinds, only: wp
   use vi_modes, only: modes_type
   use vi_motion, only: unknown, yes
   use vi_responses, only: offset_pairs
   use vi_status, only: stat
   use vi_structure, only: check_structure, load_type, new_load, new_regime, new_structure, &
      regime_type, structure_type
   use vi_structure_assess, only: assess_multipliers, structure_verdicts_type
   use vi_structure_exact, only: solve_structure_exact
   use vi_structure_found, only: same_impacts
   use vi_structure_path, only: is_odd, same_law, structure_path_type
   use vi_structure_period, only: eliminated, exact, full, periodic_structure, &
      structure_motion_type
   use vi_structure_record, only: bound_interval, modal_forces, rows_now
   use vi_structure_return, only: settle, settled_type
   use vi_structure_run, only: new_run, run_event_type, run_state_type, run_type, &
      simulate_structure, start_at
   use vi_structure_trajectory, only: simulate_structure_case
   implicit none (type, external)
   private

   public :: test_structures

   real(wp), parameter :: pi = acos(-1.0_wp)

contains

   subroutine test_structures()
      call test_pair()
      call test_coupled_damping()
      call test_rest()
      call test_not_odd()
      call test_newton_step()
      call test_audit()
      call test_doubts_of_verdicts()
      call test_same_impacts()
      call test_long_flight()
      call test_bounds_of_intervals()
      call test_rates_of_rows()
   end subroutine test_structures

   !> A flight of hundreds of thousands of cycles before the first impact: in parts it gives
   !! the same event with the same bits as at once, and a simulation with a stop request ends
   !! before its end.
   subroutine test_long_flight()
      type(structure_type) :: structure
      type(run_type) :: run
      type(run_state_type) :: state, other
      type(run_event_type) :: events(2), again(2)
      real(wp), allocatable :: table(:, :), end_state(:)
      integer, allocatable :: labels(:, :)
      real(wp), parameter :: far = 6.0e6_wp, q(2) = [0.0_wp, 0.0_wp], rate(2) = [1.0_wp, 1.0e-6_wp]
      real(wp) :: matrices(2, 2, 3), time
      integer :: calls, n, m, progress(3), status

      matrices = 0
      matrices(1, 1, :) = [1.0_wp, 0.0_wp, 1.0_wp]
      matrices(2, 2, 1) = 1
      structure = new_structure(matrices, reshape([-1.0_wp, 1.0_wp], [2, 1]), &
         reshape([far*rate(2) - 1, 1.0_wp], [2, 1]))
      call new_run(structure, new_load(0.0_wp, reshape([real(wp) ::], [2, 2, 0]), [0.0_wp, &
         0.0_wp]), run, status)
      call start_at(run, 0.0_wp, q, rate, state, status)
      call check(status == stat%ok, 'a long flight')
      other = state
      call simulate_structure(run, state, int(far, int64), 0.0_wp, events, n, status)
      call check(status == stat%ok .or. status == stat%more_events, 'a long flight at once')
      do calls = 1, 1000
         call simulate_structure(run, other, int(far, int64), 0.0_wp, again, m, status, .true.)
         if (m > 0 .or. status /= stat%more_events) exit
         call check(other%pace%from < far, 'a long flight in parts')
      end do
      call check(calls > 1, 'a long flight is interrupted')
      call check(n > 0 .and. m > 0, 'a long flight ends with an impact')
      call check(all(transfer([events(1)%elapsed, events(1)%speed, events(1)%q, events(1)%rate], &
         [0]) == transfer([again(1)%elapsed, again(1)%speed, again(1)%q, again(1)%rate], [0])) &
         .and. events(1)%cycle == again(1)%cycle, 'a long flight in parts has the same bits')
      progress = [0, 0, 1]
      call simulate_structure_case(structure, new_load(0.0_wp, reshape([real(wp) ::], [2, 2, 0]), &
         [0.0_wp, 0.0_wp]), 0.0_wp, q, rate, 0.5_wp*far, 100, table, labels, n, end_state, time, &
         status, progress)
      call check(status == stat%not_computed .and. n == 0, 'a long flight stops when told')
   end subroutine test_long_flight

   !> A wrong entry of [P] changes the determinant, and the stability verdict is withdrawn.
   subroutine test_audit()
      type(structure_type) :: structure
      type(load_type) :: load
      type(structure_motion_type) :: motion
      type(structure_verdicts_type) :: verdicts
      integer :: i, j, status

      call oscillator([0.75_wp, 0.75_wp], 0.042_wp, 0.005_wp, 37.0_wp, structure)
      load = sine_load(0.94_wp)
      call periodic_structure(structure, load, [1, 2], [0.517272128279_wp, 1.899298624085_wp]*pi, &
         1, exact, motion, status)
      do j = 1, 4
         do i = 1, 4
            verdicts = motion%verdicts
            verdicts%stable = unknown
            verdicts%p(i, j) = verdicts%p(i, j)*(1 + 1.0e-5_wp)
            call assess_multipliers(0.0_wp, verdicts)
            call check(verdicts%stable == unknown, 'a wrong entry of [P] fails the audit')
         end do
      end do
      verdicts = motion%verdicts
      verdicts%stable = unknown
      call assess_multipliers(0.0_wp, verdicts)
      call check(verdicts%stable == yes, 'the right [P] passes it')
   end subroutine test_audit

   !> The determinant may differ from its law by 1000 times the rounding of the product of the norms
   !! of the columns. Near the unit circle the leading multiplier, whose condition is the product of
   !! its unit eigenvectors, has to be away from it by 100 times the rounding of [P].
   subroutine test_doubts_of_verdicts()
      real(wp), parameter :: rounding = 1.0e-7_wp
      real(wp), parameter :: eigenvalues(4) = [0.5_wp, -0.8_wp, 0.3_wp, 0.6_wp]
      real(wp) :: p(4, 4), allowed, part
      integer :: i, k

      do k = 1, 4
         ! columns of other norms; the determinant is that of the diagonal
         p = 0
         do i = 1, 4
            p(i, i) = eigenvalues(i)
         end do
         p(1, 2:) = [1.5_wp, -2.0_wp, 3.0_wp]*k
         p(2, 3:) = [0.7_wp, 4.0_wp]
         p = cshift(cshift(p, k, dim=1), k, dim=2)
         allowed = 1.0e3_wp*(rounding + epsilon(1.0_wp))*product(norm2(p, dim=1)) &
            + 1.0e-9_wp*abs(product(eigenvalues))
         call check(verdict(p, product(eigenvalues) + 0.99_wp*allowed) == yes .and. &
            verdict(p, product(eigenvalues) - 0.99_wp*allowed) == yes, &
            'a determinant within its rounding passes')
         call check(verdict(p, product(eigenvalues) + 1.01_wp*allowed) == unknown .and. &
            verdict(p, product(eigenvalues) - 1.01_wp*allowed) == unknown, &
            'a determinant beyond it does not')
      end do
      ! the eigenvectors of 1 - gap are (1, 0) and (1, c/(1 - gap - 0.5))
      do k = 0, 3
         p = 0
         p(3, 3) = 0.1_wp
         p(4, 4) = -0.2_wp
         p(2, 2) = 0.5_wp
         p(1, 2) = real(k, wp)
         part = 100*(rounding + epsilon(1.0_wp))*hypot(norm2(p), 1.0_wp)*hypot(1.0_wp, 2*p(1, 2))
         p(1, 1) = 1 - 1.01_wp*part
         call check(verdict(p, product([(p(i, i), i=1, 4)])) == yes, &
            'a multiplier away from the circle is stable')
         p(1, 1) = 1 - 0.99_wp*part
         call check(verdict(p, product([(p(i, i), i=1, 4)])) == unknown, &
            'one within rounding of it is not')
      end do
      p(1, 1) = ieee_value(1.0_wp, ieee_positive_inf)
      call check(verdict(p, 0.0_wp) == unknown, 'nothing is known where [P] is not finite')

   contains

      !> The verdict on [P] with a law of its determinant.
      pure integer function verdict(p, law)
         real(wp), intent(in) :: p(4, 4), law
         type(structure_verdicts_type) :: verdicts

         verdicts%p = p
         verdicts%law = law
         call assess_multipliers(rounding, verdicts)
         verdict = verdicts%stable
      end function verdict
   end subroutine test_doubts_of_verdicts

   !> Motions have the same impacts if gaps, phases and speeds agree in some order and after some
   !! load cycles: phases to 1e-6 rad, speeds to 1e-6 of the largest one.
   subroutine test_same_impacts()
      integer, parameter :: gaps(3) = [2, 1, 1], cycles = 3
      real(wp), parameter :: phases(3) = [0.4_wp, 2.5_wp, 9.1_wp]
      real(wp), parameter :: speeds(3) = [0.7_wp, 0.1_wp, 2.0_wp]
      real(wp) :: others(3), small
      integer :: i, turn

      do turn = -cycles, 2*cycles
         do i = 0, 2
            others = phases + 2*pi*turn
            call check(alike(cshift(gaps, i), cshift(others, i), cshift(speeds, i), cycles), &
               'impacts in another order and other cycles are the same')
            call check(.not. alike(cshift(gaps, i), cshift(others, i) + 0.1_wp, cshift(speeds, i), &
               cycles), 'impacts that are all late are others')
         end do
      end do
      call check(.not. alike(gaps, phases + 2*pi/3, speeds, cycles), 'so by a third of a cycle')
      do i = 1, 3
         others = 0
         others(i) = 0.9e-6_wp
         call check(alike(gaps, phases + others, speeds, cycles) .and. &
            alike(gaps, phases, speeds + 2*others, cycles), 'small differences do not count')
         call check(alike(gaps, phases - others, speeds - 2*others, cycles), 'nor do negative ones')
         others(i) = 1.1e-6_wp
         call check(.not. alike(gaps, phases + others, speeds, cycles), 'another phase')
         call check(.not. alike(gaps, phases - others, speeds, cycles), 'another phase before it')
         call check(.not. alike(gaps, phases, speeds + 2*others, cycles), 'another speed')
         call check(.not. alike(gaps, phases, speeds - 2*others, cycles), 'another, lower speed')
         call check(.not. alike(cshift(gaps, i) + [0, 0, 1], phases, speeds, cycles), 'another gap')
      end do
      call check(.not. same_impacts(gaps, phases, speeds, gaps(:2), phases(:2), speeds(:2), &
         cycles, .false.), 'one impact less')
      call check(same_impacts(gaps(:0), phases(:0), speeds(:0), gaps(:0), phases(:0), speeds(:0), &
         cycles, .false.), 'motions without impacts')
      ! of accumulations only impacts with more than 1e-3 of the largest speed count
      do i = 1, 2
         small = merge(0.999e-3_wp, 1.001e-3_wp, i == 1)*maxval(speeds)
         call check(same_impacts([gaps, 1], [phases, 9.5_wp], [speeds, small], gaps, phases, &
            speeds, cycles, .true.) .eqv. i == 1, 'the last impacts of an accumulation')
         call check(same_impacts(gaps, phases, speeds, [gaps, 1], [phases, 9.5_wp], &
            [speeds, small], cycles, .true.) .eqv. i == 1, 'the last impacts of the other one')
      end do
      call check(.not. same_impacts([gaps, 1], [phases, 9.5_wp], [speeds, 1.0e-9_wp], gaps, &
         phases, speeds, cycles, .false.), 'without accumulations all impacts count')

   contains

      !> Whether other impacts are the same.
      pure logical function alike(other_gaps, other_phases, other_speeds, cycles)
         integer, intent(in) :: other_gaps(:), cycles
         real(wp), intent(in) :: other_phases(:), other_speeds(:)

         alike = same_impacts(gaps, phases, speeds, other_gaps, other_phases, other_speeds, &
            cycles, .false.)
      end function alike
   end subroutine test_same_impacts

   !> The third column of Table 1 of the 1983 paper, from its two masses: the same in three ways.
   subroutine test_pair()
      type(structure_type) :: structure
      type(load_type) :: load
      type(structure_motion_type) :: motion, found
      ! 12 digits by an independent program
      real(wp), parameter :: phases(2) = [0.517272128279_wp, 1.899298624085_wp]*pi
      integer :: wanted, status

      call oscillator([0.75_wp, 0.75_wp], 0.042_wp, 0.005_wp, 37.0_wp, structure)
      load = sine_load(0.94_wp)
      call periodic_structure(structure, load, [1, 2], phases, 1, exact, motion, status)
      call check(status == stat%ok, 'an exact motion of two masses')
      associate (verdicts => motion%verdicts)
         call check(all([verdicts%consistent, verdicts%admissible, verdicts%stable] == yes), &
            'the motion of Table 1 is consistent, admissible and stable')
         call check_close(verdicts%determinant, verdicts%law, 1.0e-12_wp, 'det[P]')
         call check_close(verdicts%law, exp(-4*pi*0.005_wp/0.94_wp)*0.75_wp**4, 1.0e-13_wp, &
            'the law of det[P]')
      end associate
      do wanted = eliminated, full
         call oscillator([0.75_wp, 0.75_wp], 0.042_wp, 0.005_wp, 37.0_wp, structure)
         call periodic_structure(structure, load, [1, 2], motion%phases, 1, wanted, found, status)
         call check(status == stat%ok, 'linear equations at the phases of a motion')
         call check(maxval(abs(found%states - motion%states)) < 1.0e-10_wp, &
            'the linear equations give the exact motion')
      end do
   end subroutine test_pair

   !> Modes that damping couples: a spring and a dashpot between host and particle.
   subroutine test_coupled_damping()
      type(structure_type) :: structure
      type(load_type) :: load
      type(settled_type) :: found
      real(wp) :: matrices(2, 2, 3), nothing(2)
      integer :: status

      matrices(:, :, 1) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.2_wp], [2, 2])
      matrices(:, :, 2) = reshape([0.15_wp, -0.1_wp, -0.1_wp, 0.1_wp], [2, 2])
      matrices(:, :, 3) = reshape([1.1_wp, -0.1_wp, -0.1_wp, 0.1_wp], [2, 2])
      structure = new_structure(matrices, reshape([-1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp], [2, 2]), &
         reshape([0.5_wp, 0.0_wp, 0.8_wp, 0.6_wp, 0.0_wp, 0.7_wp], [3, 2]))
      load = sine_load(0.9_wp)
      nothing = 0
      call settle(structure, load, 0.0_wp, nothing, nothing, 300, 8, 0, found, status)
      call check(status == stat%ok, 'a motion with damping that couples the modes')
      if (status /= stat%ok) return
      associate (verdicts => found%motion%verdicts)
         call check(verdicts%consistent == yes .and. verdicts%admissible == yes, &
            'it is consistent and admissible')
         if (size(found%resting) == 0) call check_close(verdicts%determinant, verdicts%law, &
            1.0e-10_wp, 'its det[P]')
      end associate
   end subroutine test_coupled_damping

   !> Accumulation and rest on one wall: two multipliers vanish.
   subroutine test_rest()
      type(structure_type) :: structure
      type(settled_type) :: found
      real(wp) :: nothing(2)
      integer :: status

      call oscillator([0.75_wp, 0.61_wp], 0.028_wp, 0.0114_wp, 6.0_wp, structure)
      nothing = 0
      call settle(structure, sine_load(0.9_wp), 0.0_wp, nothing, nothing, 200, 8, 0, found, status)
      call check(status == stat%ok, 'a motion with rest')
      if (status /= stat%ok) return
      call check(all(found%resting == 2) .and. size(found%resting) == 1, &
         'it rests on its left wall')
      call check(all(found%rests(2, :) > found%rests(1, :)), 'and is released later')
      associate (moduli => abs(found%motion%verdicts%multipliers))
         call check(all(moduli(3:) < 1.0e-10_wp), 'two multipliers vanish')
         call check(moduli(1) < 1 .and. found%motion%verdicts%stable == yes, 'it is stable')
      end associate
   end subroutine test_rest

   !> A step of Newton's method from a poor guess shortens no flight to less than half of it, and
   !! a longer step is reduced so that it shortens some flight to exactly a half.
   subroutine test_newton_step()
      type(random_type) :: random
      type(structure_type) :: structure
      type(regime_type) :: regime
      type(load_type) :: load
      real(wp) :: times(2), before(2), flights(2), speeds(2), period, residual, least
      real(wp), allocatable :: offsets(:)
      integer :: halved, i, status, steps

      call oscillator([0.75_wp, 0.61_wp], 0.042_wp, 0.05_wp, 6.0_wp, structure)
      load = sine_load(0.94_wp)
      call check_structure(structure, status)
      call new_regime(structure, load, [integer ::], regime, status)
      call check(status == stat%ok, 'newton: a structure')
      allocate (offsets(size(offset_pairs(regime))))
      period = 2*pi/load%frequency
      halved = 0
      do i = 1, 300
         before(1) = draw(random, 0.0_wp, 0.4_wp*period)
         before(2) = before(1) + draw(random, 0.1_wp, 0.9_wp)*period
         times = before
         offsets = 0
         speeds = [draw_log(random, 0.01_wp, 10.0_wp), draw_log(random, 0.01_wp, 10.0_wp)]
         call solve_structure_exact(structure, regime, [1, 2], times, period, speeds, offsets, 0, &
            residual, steps, status)
         if (status /= stat%no_convergence) cycle
         flights = [times(2) - times(1), times(1) + period - times(2)] &
            /[before(2) - before(1), before(1) + period - before(2)]
         least = minval(flights)
         call check(least > 0.5_wp - 1.0e-12_wp, 'newton: no flight is shorter than half of it')
         if (least < 0.5_wp + 1.0e-12_wp) halved = halved + 1
      end do
      call check(halved > 50, 'newton: some flights are halved')
   end subroutine test_newton_step

   !> Motions have mirror images between opposite gaps with equal openings and laws, under a load
   !! with odd harmonics only, and not if any of these differs, by either sign.
   subroutine test_not_odd()
      type(random_type) :: random
      type(structure_path_type) :: path
      real(wp) :: gaps(7, 2), matrices(2, 2, 3), harmonics(2, 2, 3), part
      integer :: i, j, kind

      matrices = 0
      do i = 1, 2
         matrices(i, i, :) = [1.0_wp, 0.1_wp, 1.0_wp]
      end do
      allocate (path%changes(0))
      do i = 1, 80
         harmonics = 0
         call fill(random, -1.0_wp, 1.0_wp, harmonics(:, 1, 1))
         call fill(random, -1.0_wp, 1.0_wp, harmonics(:, 2, 3))
         part = draw_log(random, 1.0e-6_wp, 0.1_wp)*merge(1, -1, mod(i, 2) == 0)
         j = draw_integer(random, 1, 2)
         ! a table of the restitution at two speeds, or a constant one
         gaps = spread([0.5_wp, 2.0_wp, 2.0_wp, 0.0_wp, 1.0_wp, 0.8_wp, 0.5_wp], 2, 2)
         if (mod(i, 4) < 2) gaps(2:, :) = spread([0.0_wp, 0.8_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
            0.0_wp], 2, 2)
         do kind = 0, 8
            path%structure = new_structure(matrices, reshape([1.0_wp, -0.5_wp, -1.0_wp, 0.5_wp], &
               [2, 2]), gaps)
            path%load = new_load(1.3_wp, harmonics, [0.0_wp, 0.0_wp])
            select case (kind)
            case (1)
               path%load%constant(j) = part
            case (2)
               path%load%cosine(j, 2) = part
            case (3)
               path%load%sine(j, 2) = part
            case (4)
               path%structure%directions(j, 1) = path%structure%directions(j, 1) + part
            case (5)
               path%structure%openings(j) = path%structure%openings(j) + part
            case (6)
               path%structure%laws(j)%numbers(1) = path%structure%laws(j)%numbers(1) + part
            case (7)
               if (mod(i, 4) < 2) cycle
               path%structure%laws(j)%speeds(2) = path%structure%laws(j)%speeds(2) + part
            case (8)
               if (mod(i, 4) < 2) cycle
               path%structure%laws(j)%values(2) = path%structure%laws(j)%values(2) + part
            case default
               ! unchanged
            end select
            call check(is_odd(path) .eqv. kind == 0, 'mirror images of motions')
            call check((same_law(path%structure, 1, 2) .eqv. kind < 6) .and. &
               (same_law(path%structure, 2, 1) .eqv. kind < 6), 'laws of gaps')
         end do
      end do
   end subroutine test_not_odd

   !> The oscillator of 1983 as a structure of two masses.
   subroutine oscillator(restitution, mu, xi, clearance, structure)
      !> R of the right and the left wall; mass ratio, damping ratio, clearance.
      real(wp), intent(in) :: restitution(2), mu, xi, clearance
      !> The structure.
      type(structure_type), intent(out) :: structure
      real(wp) :: matrices(2, 2, 3), gaps(3, 2)

      matrices = 0
      matrices(1, 1, :) = [1.0_wp, 2*xi, 1.0_wp]
      matrices(2, 2, 1) = mu
      gaps = 0
      gaps(1, :) = 0.5_wp*clearance
      gaps(3, :) = restitution
      structure = new_structure(matrices, reshape([-1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp], [2, 2]), gaps)
   end subroutine oscillator

   !> A unit sine on the first coordinate.
   pure function sine_load(frequency) result(load)
      !> Omega.
      real(wp), intent(in) :: frequency
      type(load_type) :: load
      real(wp) :: harmonics(2, 2, 1), constant(2)

      harmonics = 0
      harmonics(1, 2, 1) = 1
      constant = 0
      load = new_load(frequency, harmonics, constant)
   end function sine_load

   !> Under a constant force the rows of a record change as their rates predict. They are linear in
   !! the pairs, so a step of any length along their derivatives shows it. If damping
   !! does not couple the modes, rows depend on positions alone.
   subroutine test_rates_of_rows()
      integer, parameter :: n = 3
      type(random_type) :: random
      type(structure_type) :: structure
      type(regime_type) :: regime
      real(wp), allocatable :: pairs(:, :), moved(:, :), values(:, :), after(:, :)
      real(wp) :: matrices(n, n, 3), part(n, n), force(n), step
      integer :: i, j, kinds(2), status

      kinds = 0
      do i = 1, 60
         do j = 1, 3
            call fill(random, -1.0_wp, 1.0_wp, part(:, 1))
            call fill(random, -1.0_wp, 1.0_wp, part(:, 2))
            call fill(random, -1.0_wp, 1.0_wp, part(:, 3))
            matrices(:, :, j) = matmul(part, transpose(part))
         end do
         do j = 1, n
            matrices(j, j, 1) = matrices(j, j, 1) + 1
         end do
         if (mod(i, 3) == 0) matrices(:, :, 2) = 0.3_wp*matrices(:, :, 3)
         structure = new_structure(matrices, reshape([-1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, -1.0_wp, &
            1.0_wp], [n, 2]), reshape([0.5_wp, 0.7_wp, 0.6_wp, 0.4_wp], [2, 2]))
         call check_structure(structure, status)
         call new_regime(structure, new_load(0.0_wp, reshape([real(wp) ::], [n, 2, 0]), [0.0_wp, &
            0.0_wp, 0.0_wp], 1.0_wp, part), [(1, j=1, mod(i, 2))], regime, status)
         if (status /= stat%ok) cycle
         associate (rows => size(regime%base_offset), m => size(regime%modes%stiffness))
            allocate (pairs(m, 4), moved(m, 4), values(rows, 2), after(rows, 2))
         end associate
         call fill(random, -1.0_wp, 1.0_wp, force)
         call fill(random, -1.0_wp, 1.0_wp, pairs(:, 1))
         call fill(random, -1.0_wp, 1.0_wp, pairs(:, 2))
         call modal_forces(regime, force, pairs(:, 3), pairs(:, 4))
         step = draw_log(random, 0.01_wp, 1.0_wp)
         moved = pairs
         moved(:, 1) = pairs(:, 1) + step*(pairs(:, 2) + pairs(:, 3))
         moved(:, 2) = pairs(:, 2) + step*(pairs(:, 4) - regime%modes%stiffness*pairs(:, 1) &
            - 2*regime%modes%damping*pairs(:, 2))
         call rows_now(regime, force, pairs, values)
         call rows_now(regime, force, moved, after)
         associate (scale => maxval(abs(values)) + maxval(abs(after)))
            call check(all(abs(after(:, 1) - values(:, 1) - step*values(:, 2)) <= 1.0e-12_wp &
               *scale), 'records: rates of rows are the derivatives of the rows')
         end associate
         j = merge(1, 2, regime%rows%by_position)
         kinds(j) = kinds(j) + 1
         deallocate (pairs, moved, values, after)
      end do
      call check(all(kinds >= 10), 'records: rows with and without velocities')
   end subroutine test_rates_of_rows

   !> Between two samples of a record, fourth differences of x and v, computed by the Runge-Kutta
   !! method, are within the bounds on fourth derivatives, and reach those of an undamped pair
   !! over one cycle.
   subroutine test_bounds_of_intervals()
      integer, parameter :: steps = 400
      type(random_type) :: random
      type(modes_type) :: modes
      real(wp), allocatable :: now(:, :), next(:, :), x(:, :), v(:, :)
      real(wp) :: bounds(4), length, h, largest(4), sizes(2)
      integer :: i, j, m

      do i = 1, 60
         m = merge(1, draw_integer(random, 2, 4), mod(i, 2) == 0)
         allocate (modes%stiffness(m), modes%damping(m), modes%inverse(m), now(m, 4), next(m, 4), &
            x(m, -2:steps + 2), v(m, -2:steps + 2))
         do j = 1, m
            modes%stiffness(j) = merge(0.0_wp, draw_log(random, 0.1_wp, 10.0_wp), &
               mod(i + j, 5) == 0)
            modes%damping(j) = merge(0.0_wp, draw(random, 0.0_wp, 0.5_wp), mod(i, 2) == 0)
            modes%inverse(j) = merge(1/sqrt(max(modes%stiffness(j), tiny(1.0_wp))), 0.0_wp, &
               modes%stiffness(j) > 0)
         end do
         length = 2*pi*merge(maxval(modes%inverse), draw(random, 0.1_wp, 1.0_wp), mod(i, 2) == 0 &
            .and. all(modes%stiffness > 0))
         do j = 1, 4
            call fill(random, -1.0_wp, 1.0_wp, now(:, j))
            call fill(random, -1.0_wp, 1.0_wp, next(:, j))
         end do
         h = length/steps
         call integrate()
         call bound_interval(modes, m, length, now, next, bounds)
         largest = 0
         do j = 0, steps
            largest(1) = max(largest(1), norm2(difference(x(:, j - 2:j + 2))))
            largest(2) = max(largest(2), norm2(difference(v(:, j - 2:j + 2))))
            largest(3) = max(largest(3), norm2(x(:, j)))
            largest(4) = max(largest(4), norm2(v(:, j)))
         end do
         ! an error of h^2 and rounding
         call check(all(largest(:2) <= 1.01_wp*bounds(:2) + 1.0e-13_wp*largest(3:)/h**4), &
            'records: fourth derivatives are within their bounds')
         if (mod(i, 2) == 0 .and. modes%stiffness(1) > 0) call check(all(largest(:2) >= 0.98_wp &
            *bounds(:2)), 'records: the bounds are reached')
         ! the sizes are at least those at the start, and grow by no more than the rates allow
         call check(all(bounds(3:) >= (1 - 1.0e-12_wp)*[norm2(now(:, 1)), norm2(now(:, 2))]) &
            .and. bounds(3) >= 0.5_wp*length*norm2(now(:, 2)) .and. bounds(4) >= 0.5_wp*length &
            *norm2([now(:, 4), next(:, 4)]), 'records: sizes are not too small')
         call check(bounds(3) <= (1 + 1.0e-12_wp)*(norm2(now(:, 1)) + length*norm2(now(:, 2))) &
            .and. bounds(4) <= (1 + 1.0e-12_wp)*(norm2(now(:, 2)) + length*(norm2(now(:, 4)) &
            + norm2(next(:, 4)))), 'records: sizes are not too large')
         sizes = bounds(3:)
         call bound_interval(modes, m, length, abs(now), abs(next), bounds)
         call check(all(abs(sizes - bounds(3:)) <= 0), 'records: sizes do not depend on signs')
         deallocate (modes%stiffness, modes%damping, modes%inverse, now, next, x, v)
      end do

   contains

      !> x and v from two steps before the interval to two steps after it.
      subroutine integrate()
         real(wp) :: dx(m, 4), dv(m, 4), at_x(m), at_v(m)
         real(wp), parameter :: parts(4) = [0.0_wp, 0.5_wp, 0.5_wp, 1.0_wp], &
            weights(4) = [1.0_wp, 2.0_wp, 2.0_wp, 1.0_wp]/6
         integer :: i, k, way

         do way = -1, 1, 2
            x(:, 0) = now(:, 1)
            v(:, 0) = now(:, 2)
            do i = 0, merge(1, steps + 1, way < 0)
               do k = 1, 4
                  at_x = x(:, way*i)
                  at_v = v(:, way*i)
                  if (k > 1) at_x = at_x + way*h*parts(k)*dx(:, k - 1)
                  if (k > 1) at_v = at_v + way*h*parts(k)*dv(:, k - 1)
                  associate (share => way*(i + parts(k))/steps)
                     dx(:, k) = at_v + now(:, 3) + share*(next(:, 3) - now(:, 3))
                     dv(:, k) = now(:, 4) + share*(next(:, 4) - now(:, 4)) - modes%stiffness*at_x &
                        - 2*modes%damping*at_v
                  end associate
               end do
               x(:, way*(i + 1)) = x(:, way*i) + way*h*matmul(dx, weights)
               v(:, way*(i + 1)) = v(:, way*i) + way*h*matmul(dv, weights)
            end do
         end do
      end subroutine integrate

      !> The fourth derivative at the third of five positions.
      function difference(values) result(fourth)
         real(wp), intent(in) :: values(:, :)
         real(wp) :: fourth(m)

         fourth = matmul(values, [1.0_wp, -4.0_wp, 6.0_wp, -4.0_wp, 1.0_wp])/h**4
      end function difference
   end subroutine test_bounds_of_intervals

end module studies_structures
