!> Motions of structures: lists of them, settled simulations, states for their search,
!! and Lyapunov exponents.
module studies_structure_motions
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use checks, only: check
   use random_numbers, only: draw, fill, random_type
   use vi_exponents, only: average_type, exponents_along, exponents_type
   use vi_kinds, only: wp
   use vi_motion, only: no, unknown, yes
   use vi_presumed_events, only: presume, sequence_fault
   use vi_simulated_structure, only: new_simulated_structure, simulated_structure_type
   use vi_status, only: stat
   use vi_structure, only: check_structure, load_type, new_load, new_structure, structure_type
   use vi_structure_find, only: open_gaps, random_structure_states
   use vi_structure_found, only: add_motion, found_list_type
   use vi_structure_period, only: exact, periodic_structure, periodic_structure_arrays, &
      structure_motion_type
   use vi_structure_return, only: settle, settle_on, settled_type
   use vi_structure_run, only: find_regime, new_run, run_type
   use vi_structure_trajectory, only: simulate_structure_arrays
   implicit none (type, external)
   private

   public :: between, cosine_load, test_structure_motions

   real(wp), parameter :: pi = acos(-1.0_wp)

contains

   subroutine test_structure_motions()
      call test_shortest_periods()
      call test_near_motions()
      call test_limits_of_events()
      call test_no_periodic_motion()
      call test_opened_gaps()
      call test_states_without_motion()
      call test_mirrored_states()
      call test_refused_exponents()
      call test_undefined_cycles()
      call test_sums_of_exponents()
      call test_presumed_events()
   end subroutine test_structure_motions

   !> The events of a motion determine it: a gap whose wall moves, a stop that cannot pull, and
   !! friction that reverses.
   subroutine test_presumed_events()
      type(structure_type) :: structure
      type(load_type) :: load
      type(settled_type) :: motion, found
      character(:), allocatable :: text
      real(wp), allocatable :: phases(:)
      real(wp) :: law(7, 3)
      integer, allocatable :: kinds(:)
      integer :: i, status

      law = 0
      law(:5, 1) = [0.6_wp, 10.0_wp, 0.05_wp, 0.02_wp, 0.7_wp]
      law(:4, 2) = [0.8_wp, 4.0_wp, 30.0_wp, 2.0_wp]
      law(:4, 3) = [0.0_wp, 5.0_wp, 0.05_wp, 0.05_wp]
      structure = new_structure(reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.5_wp, 0.1_wp, 0.0_wp, 0.0_wp, &
         0.05_wp, 2.0_wp, -1.0_wp, -1.0_wp, 1.5_wp], [2, 2, 3]), reshape([1.0_wp, 0.0_wp, 0.0_wp, &
         -1.0_wp, 1.0_wp, -1.0_wp], [2, 3]), law)
      load = new_load(1.1_wp, reshape([1.0_wp, 0.2_wp, 0.0_wp, 0.3_wp], [2, 2, 1]), [0.0_wp, &
         0.0_wp])
      call settle(structure, load, 0.0_wp, [0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], 300, 1, 0, motion, &
         status)
      call check(status == stat%ok .and. size(motion%gaps) == 11, 'presumed: a motion')
      if (status /= stat%ok) return
      allocate (phases, source=motion%motion%phases)
      kinds = [(motion%events(i)%kind, i=1, size(phases))]
      call check_structure(structure, status)
      call sequence_fault(structure, motion%gaps, kinds, phases, text)
      call check(len(text) == 0, 'presumed: events that can follow each other')
      call sequence_fault(structure, motion%gaps, cshift(kinds, 1), phases, text)
      call check(len(text) > 0, 'presumed: events that cannot')
      call presume(structure, load, motion%gaps, kinds, phases, 1, .false., found, status)
      call check(status == stat%ok .and. found%motion%residual < 1.0e-13_wp, &
         'presumed: all equations hold')
      call check(maxval(abs(found%motion%states - motion%motion%states)) < 1.0e-10_wp .and. &
         maxval(abs(found%motion%speeds - motion%motion%speeds)) < 1.0e-10_wp, &
         'presumed: the same states and speeds')
      call check(maxval(abs(found%motion%verdicts%multipliers &
         - motion%motion%verdicts%multipliers)) < 1.0e-8_wp, 'presumed: the same multipliers')
      call check(found%motion%verdicts%admissible == yes .and. found%motion%verdicts%stable &
         == yes, 'presumed: the same verdicts')
      phases(1) = phases(1) + 1.0e-4_wp
      call presume(structure, load, motion%gaps, kinds, phases, 1, .false., found, status)
      call check(found%motion%verdicts%consistent == no .and. found%motion%verdicts%stable == &
         unknown, 'presumed: other instants')
      call presume(structure, load, motion%gaps, kinds, phases, 1, .true., found, status)
      call check(status == stat%ok .and. found%motion%verdicts%consistent == yes, &
         'presumed: an exact motion nearby')
   end subroutine test_presumed_events

   !> A motion given over several periods is the same, unless gaps, phases or a rest differ, or
   !! there is no motion of the shorter period.
   subroutine test_shortest_periods()
      type(structure_type) :: structure, own
      type(load_type) :: load
      type(settled_type) :: one, found
      type(structure_motion_type) :: motion
      type(found_list_type) :: list, other
      real(wp) :: late
      integer :: i, parts, place, status

      structure = between(0.0_wp, 50.0_wp, 0.7_wp)
      load = cosine_load(1.9_wp, 1.0_wp)
      call settle(structure, load, 0.0_wp, [0.0_wp], [0.0_wp], 60, 2, 0, one, status)
      call check(status == stat%ok .and. size(one%gaps) == 1 .and. one%cycles == 1, &
         'periods: a motion with one impact')
      if (status /= stat%ok) return
      do parts = 1, 5
         call add_motion(structure, load, times_over(one, parts), list, place)
         call check(place == 1 .and. list%n == 1, 'periods: several periods are the same motion')
         call check(list%motions(1)%cycles == 1 .and. size(list%motions(1)%gaps) == 1 .and. &
            maxval(abs(list%motions(1)%motion%phases - one%motion%phases)) < 1.0e-9_wp, &
            'periods: of which the shortest period is kept')
      end do
      do i = -1, 1, 2
         do parts = 2, 4
            late = i*0.5e-7_wp
            found = times_over(one, parts)
            found%motion%phases(parts) = found%motion%phases(parts) + late
            call add_motion(structure, load, found, list, place)
            call check(place == 1 .and. list%n == 1, 'periods: nearly the same phases')
            found%motion%phases(parts) = found%motion%phases(parts) + 3*late
            call check_kept(found, 'periods: other phases')
         end do
      end do
      found = times_over(one, 2)
      found%gaps = [1, 2]
      call check_kept(found, 'periods: other gaps')
      found = times_over(one, 2)
      found%resting = [1]
      call check_kept(found, 'periods: a rest')
      found = times_over(one, 2)
      found%motion%verdicts%admissible = no
      call add_motion(structure, load, found, other, place)
      call check(place == 0 .and. other%n == 0, 'periods: a motion through a wall')
      ! without damping there is no motion at resonance
      structure%damping = 0
      structure%stiffness = 1.9_wp**2
      own = structure
      call periodic_structure(own, load, one%gaps, one%motion%phases, 1, exact, motion, status)
      call check(status /= stat%ok, 'periods: no motion')
      call check_kept(times_over(one, 2), 'periods: no motion of the shorter period')

   contains

      !> Checks that a motion is kept unchanged.
      subroutine check_kept(found, what)
         type(settled_type), intent(in) :: found
         character(*), intent(in) :: what
         type(found_list_type) :: fresh

         call add_motion(structure, load, found, fresh, place)
         call check(place == 1 .and. fresh%n == 1, what)
         call check(fresh%motions(1)%cycles == found%cycles .and. size(fresh%motions(1)%gaps) == &
            size(found%gaps), what//', as given')
      end subroutine check_kept
   end subroutine test_shortest_periods

   !> The same motion over some of its periods.
   function times_over(one, parts) result(found)
      !> With one impact and without rest.
      type(settled_type), intent(in) :: one
      integer, intent(in) :: parts
      type(settled_type) :: found
      integer :: i

      found = one
      found%cycles = parts*one%cycles
      found%gaps = [(one%gaps, i=1, parts)]
      found%motion%phases = [(one%motion%phases + 2*pi*one%cycles*i, i=0, parts - 1)]
      found%motion%speeds = [(one%motion%speeds, i=1, parts)]
      found%motion%impulses = [(one%motion%impulses, i=1, parts)]
      found%motion%states = spread(one%motion%states(:, 1), 2, parts)
      found%motion%verdicts%consistent = yes
      found%motion%verdicts%admissible = yes
   end function times_over

   !> A motion without rest on which a simulation is said to settle is near the simulated cycles:
   !! phases to 0.05 rad, apart from whole turns, and speeds to 0.05 of the greatest one.
   subroutine test_near_motions()
      type(random_type) :: random
      type(structure_type) :: structure
      type(load_type) :: load
      type(settled_type) :: found
      real(wp) :: start(2), table(5, 50), end_state(2), end_time, apart, faster, long(5, 500), &
         settled(2)
      integer :: accepted, i, labels(2, 50), m, many(2, 500), n, refused, status

      structure = between(0.2_wp, 50.0_wp, 0.7_wp)
      load = cosine_load(1.9_wp, 1.0_wp)
      accepted = 0
      refused = 0
      call simulate_structure_arrays(structure, load, 0.0_wp, [0.0_wp], [0.0_wp], 400*pi/1.9_wp, &
         long, many, n, settled, end_time, status)
      do i = 1, 400
         call fill(random, -1.0_wp, 1.0_wp, start)
         start = settled + start*10.0_wp**draw(random, -3.0_wp, -0.5_wp)
         call settle(structure, load, 0.0_wp, start(:1), start(2:), 0, 1, 1, found, status)
         if (status == stat%no_convergence) refused = refused + 1
         if (status /= stat%ok) cycle
         if (size(found%resting) > 0) cycle
         call simulate_structure_arrays(structure, load, 0.0_wp, start(:1), start(2:), &
            2*pi/1.9_wp, table, labels, n, end_state, end_time, m)
         call check(m == stat%ok .and. n == size(found%gaps), 'near: the same impacts')
         if (n /= size(found%gaps)) cycle
         apart = maxval(abs(modulo(found%motion%phases - 1.9_wp*table(1, :n) + pi, 2*pi) - pi))
         faster = maxval(abs(found%motion%speeds - table(2, :n)))/maxval(table(2, :n))
         call check(apart <= 0.05_wp + 1.0e-9_wp .and. faster <= 0.05_wp + 1.0e-9_wp, &
            'near: a motion that is the simulated one')
         accepted = accepted + 1
      end do
      call check(accepted > 100 .and. refused > 10, 'near: accepted and refused motions')
   end subroutine test_near_motions

   !> A simulation that is to settle is abandoned if it has more events than allowed, in the
   !! cycles before it is examined or in the examined ones.
   subroutine test_limits_of_events()
      integer, parameter :: settling = 7, most_cycles = 2
      type(run_type) :: run
      type(structure_type) :: structure
      type(load_type) :: load
      type(settled_type) :: found
      real(wp) :: end_state(2), end_time, table(5, 200)
      integer :: labels(2, 200), most, n, status

      structure = between(0.2_wp, 0.3_wp, 0.7_wp)
      load = cosine_load(1.9_wp, 1.0_wp)
      call simulate_structure_arrays(structure, load, 0.0_wp, [0.0_wp], [0.1_wp], (settling &
         + 2*most_cycles)*2*pi/1.9_wp, table, labels, n, end_state, end_time, status)
      call check(status == stat%ok .and. n > 15, 'limits: events of a simulation')
      do most = 0, n + 3
         call new_run(structure, load, run, status)
         call settle_on(structure, run, 0.0_wp, [0.0_wp], [0.1_wp], settling, most_cycles, 0, &
            .false., most, found, status)
         call check((status == stat%event_limit) .eqv. most < n, 'limits: more events than allowed')
      end do
   end subroutine test_limits_of_events

   !> If there is no periodic motion the arrays are empty and the status gives the reason; an exact
   !! motion solves its equations.
   subroutine test_no_periodic_motion()
      type(random_type) :: random
      type(structure_type) :: structure
      real(wp) :: phases(2), matrices(2, 2, 3), force(2, 2, 1)
      integer :: i, solved, status, wanted

      matrices = 0
      matrices(:, :, 1) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2])
      matrices(1, 1, 2:) = 1
      force(:, :, 1) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [2, 2])
      do wanted = 0, 2
         structure = between(0.1_wp, 50.0_wp, 0.7_wp)
         structure%mass = 0
         call check_none(structure, cosine_load(2.0_wp, 1.0_wp), [0.3_wp], 1, &
            stat%mass_not_definite)
         structure%mass = 1
         structure%damping = 0
         structure%stiffness = 4
         call check_none(structure, cosine_load(2.0_wp, 1.0_wp), [0.3_wp], 1, stat%resonance)
         ! the load does not resonate, but two of its cycles do
         structure%stiffness = 1
         call check_none(structure, cosine_load(2.0_wp, 1.0_wp), [0.3_wp], 2, stat%resonance)
         ! a force on a mass that no gap and no spring holds
         call check_none(new_structure(matrices, reshape([1.0_wp, 0.0_wp], [2, 1]), &
            reshape([0.1_wp, 0.7_wp], [2, 1])), new_load(2.0_wp, force, [0.0_wp, 1.0_wp]), &
            [0.3_wp], 1, stat%unbalanced)
      end do
      structure = between(0.1_wp, 50.0_wp, 0.7_wp)
      solved = 0
      wanted = exact
      do i = 1, 200
         call fill(random, 0.0_wp, 2*pi, phases)
         phases = [minval(phases), maxval(phases)]
         call check_exact(phases, 0.9_wp)
         call check_exact(phases(:1), 1.9_wp)
      end do
      call check(solved > 200, 'arrays: most random phases lead to a motion')

   contains

      !> Checks that there is no motion.
      subroutine check_none(structure, load, phases, cycles, expected)
         type(structure_type), intent(in) :: structure
         type(load_type), intent(in) :: load
         real(wp), intent(in) :: phases(:)
         integer, intent(in) :: cycles, expected
         real(wp), dimension(2*size(structure%mass, 1), 2*size(structure%mass, 1)) :: p
         real(wp) :: impacts(size(phases), 3), scalars(3), states(size(p, 1), size(phases))
         complex(wp) :: multipliers(size(p, 1))
         integer :: j, verdicts(3)

         call periodic_structure_arrays(structure, load, [(1, j=1, size(phases))], phases, cycles, &
            wanted, impacts, states, p, multipliers, scalars, verdicts, status)
         call check(status == expected, 'arrays: why there is no motion')
         call check(all(abs(impacts) <= 0) .and. all(abs(states) <= 0) .and. all(abs(p) <= 0) &
            .and. all(abs(multipliers) <= 0) .and. all(abs(scalars) <= 0) .and. all(verdicts == &
            unknown), 'arrays: empty without a motion')
      end subroutine check_none

      !> Checks that a motion is exact if there is one.
      subroutine check_exact(phases, frequency)
         real(wp), intent(in) :: phases(:), frequency
         type(structure_type) :: own
         type(structure_motion_type) :: motion
         integer :: j

         own = structure
         call periodic_structure(own, cosine_load(frequency, 1.0_wp), [(1, j=1, size(phases))], &
            phases, 1, exact, motion, status)
         if (status == stat%ok) then
            solved = solved + 1
            call check(motion%residual < 1.0e-9_wp, 'arrays: a motion that is said to be exact is')
         else
            call check_none(structure, cosine_load(frequency, 1.0_wp), phases, 1, status)
         end if
      end subroutine check_exact
   end subroutine test_no_periodic_motion

   !> Coordinates at which a gap is closed by rounding of large terms stay; others move back until
   !! the gap has a twentieth of its opening.
   subroutine test_opened_gaps()
      type(random_type) :: random
      type(structure_type) :: structure
      real(wp) :: far, opening, q(2), start(2)
      integer :: i

      do i = 1, 200
         opening = draw(random, 0.1_wp, 1.0_wp)
         far = draw(random, 1.0e3_wp, 2.0e3_wp)*merge(1, -1, mod(i, 2) == 0)
         structure = new_structure(reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2, 3], [1.0_wp, &
            0.0_wp, 0.0_wp, 1.0_wp]), reshape([1.0_wp, -1.0_wp], [2, 1]), reshape([opening, &
            0.5_wp], [2, 1]))
         start = [far + opening + 5.0e-12_wp, far]
         q = start
         call open_gaps(structure, q)
         call check(all(abs(q - start) <= 0), 'opened: rounding of large terms is no closed gap')
         start(1) = far + opening + 5.0e-9_wp
         q = start
         call open_gaps(structure, q)
         call check(abs(q(1) - q(2) - 0.95_wp*opening) < 1.0e-11_wp, 'opened: a closed gap')
      end do
   end subroutine test_opened_gaps

   !> Without a motion from rest, random states have the size of the openings alone.
   subroutine test_states_without_motion()
      type(structure_type) :: structure
      type(run_type) :: run
      real(wp) :: matrices(2, 2, 3), cosine(2, 2, 1), states(4, 20)
      integer :: i, j, number, status

      ! with the first mass at rest, the second one resonates with the load
      matrices = 0
      matrices(:, :, 1) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2])
      matrices(1, 1, 2) = 0.1_wp
      matrices(:, :, 3) = reshape([2.0_wp, -1.0_wp, -1.0_wp, 2.0_wp], [2, 2])
      cosine(:, :, 1) = reshape([1.0_wp, 0.2_wp, 0.0_wp, 0.0_wp], [2, 2])
      structure = new_structure(matrices, reshape([1.0_wp, 0.0_wp], [2, 1]), reshape([0.0_wp, &
         0.5_wp], [2, 1]))
      call random_structure_states(structure, new_load(sqrt(2.0_wp), cosine, [0.0_wp, 0.0_wp]), 1, &
         states, status)
      call check(status == stat%ok .and. all(abs(states) <= 0), 'states: a rest without a motion')
      call new_run(structure, new_load(sqrt(2.0_wp), cosine, [0.0_wp, 0.0_wp]), run, status)
      do i = 1, 3
         call find_regime(run, [1], number, status)
         call check(status == stat%resonance .and. count([(allocated(run%regimes(j)%closed), j=1, &
            size(run%regimes))]) == 1, 'states: no such rest, however often it is asked for')
      end do
      structure%mass = 0
      structure%openings = 1
      call random_structure_states(structure, new_load(sqrt(2.0_wp), cosine, [0.0_wp, 0.0_wp]), 1, &
         states, status)
      call check(status == stat%ok .and. all(abs(states(:, 1)) <= 0) .and. all(abs(states(:, 2:)) &
         > 0) .and. all(abs(states) < 10), 'states: no mass')
   end subroutine test_states_without_motion

   !> Random states have the sizes of a motion, for any of its signs.
   subroutine test_mirrored_states()
      real(wp) :: phase, states(2, 20, 2)
      integer :: i, k, side, status

      ! with impacts, and without any
      do k = 1, 20
         phase = 0.1_wp*pi*k
         do side = 1, 2
            associate (to => merge(1.0_wp, -1.0_wp, side == 1), wall => merge(0.1_wp, 50.0_wp, &
               mod(k, 2) == 0))
               call random_structure_states(new_structure(reshape([1.0_wp, 0.1_wp, 1.0_wp], [1, &
                  1, 3]), reshape([to], [1, 1]), reshape([wall, 0.7_wp], [2, 1])), &
                  new_load(1.9_wp, to*reshape([cos(phase), sin(phase)], [1, 2, 1]), [0.2_wp*to]), &
                  3, states(:, :, side), status)
            end associate
            call check(status == stat%ok, 'states: of a mirrored motion')
         end do
         call check(all([(abs(abs(states(2, i, 1)) - abs(states(2, i, 2))) <= 1.0e-9_wp* &
            abs(states(2, i, 2)), i=2, size(states, 2))]), 'states: of the same size')
      end do
   end subroutine test_mirrored_states

   !> If a simulation cannot start, or has too many events before its average begins, there are
   !! no exponents; some directions have neither a dimension nor a sum.
   subroutine test_refused_exponents()
      type(structure_type) :: structure
      type(average_type) :: average
      type(exponents_type) :: found
      integer :: progress(3), status, most

      average = average_type(discard=5, cycles=7, batches=3, directions=2, work=1)
      most = huge(1)
      structure = between(0.2_wp, 0.3_wp, 0.7_wp)
      call average_from(structure, cosine_load(1.9_wp, 1.0_wp), [0.3_wp, 0.1_wp], average, most, &
         found, status)
      call check(status == stat%gap_closed .and. .not. allocated(found%exponents), &
         'exponents: none from a closed gap')
      most = 3
      progress = 0
      call average_from(structure, cosine_load(1.9_wp, 1.0_wp), [0.0_wp, 0.1_wp], average, most, &
         found, status, progress)
      call check(status == stat%event_limit .and. .not. allocated(found%exponents) .and. &
         progress(1) == 0, 'exponents: none after a transient with too many events')
      most = huge(1)
      average%directions = 1
      call average_from(structure, cosine_load(1.9_wp, 1.0_wp), [0.0_wp, 0.1_wp], average, most, &
         found, status)
      call check(status == stat%ok .and. size(found%exponents) == 1, 'exponents: of a direction')
      call check(ieee_is_nan(found%dimension) .and. ieee_is_nan(found%error), &
         'exponents: neither a dimension nor a sum')
      structure%mass = 0
      call average_from(structure, cosine_load(1.9_wp, 1.0_wp), [0.0_wp, 0.1_wp], average, most, &
         found, status)
      call check(status == stat%mass_not_definite .and. .not. allocated(found%exponents), &
         'exponents: none without a mass')
   end subroutine test_refused_exponents

   !> A period in which two gaps close at once belongs to no motion; the same holds for a structure
   !! without mass, and for a start in a gap.
   subroutine test_undefined_cycles()
      type(structure_type) :: structure
      type(settled_type) :: found
      integer :: cycles, early, settling, status

      do settling = 0, 3
         do cycles = 0, 2
            structure = new_structure(reshape([1.0_wp, 0.1_wp, 1.0_wp], [1, 1, 3]), &
               reshape([1.0_wp, 1.0_wp], [1, 2]), reshape([0.5_wp, 0.5_wp, 0.5_wp, 0.5_wp], [2, 2]))
            do early = 0, 1
               ! the gaps close within a cycle, or after some
               call settle(structure, cosine_load(1.0_wp, 1.0_wp - 0.6_wp*early), 0.0_wp, &
                  [0.4_wp], [3.0_wp - 3*early], settling, 2, cycles, found, status)
               call check(status == stat%coupled_impacts .or. early == 1, &
                  'undefined: gaps that close at once')
               call check(status /= stat%ok, 'undefined: no motion')
            end do
            call settle(structure, cosine_load(1.0_wp, 1.0_wp), 0.0_wp, [0.6_wp], [0.0_wp], &
               settling, 2, cycles, found, status)
            call check(status == stat%gap_closed, 'undefined: a start in a gap')
            structure%mass = 0
            call settle(structure, cosine_load(1.0_wp, 1.0_wp), 0.0_wp, [0.4_wp], [3.0_wp], &
               settling, 2, cycles, found, status)
            call check(status == stat%mass_not_definite, 'undefined: no mass')
         end do
      end do
   end subroutine test_undefined_cycles

   !> The sum of the exponents has the value given by damping and impacts, even if a mass
   !! leaves a wall the more slowly, the faster it arrives. A limit of events leaves no exponents.
   subroutine test_sums_of_exponents()
      type(random_type) :: random
      type(structure_type) :: structure
      type(average_type) :: average
      type(exponents_type) :: found, less
      integer :: i, status, most

      average = average_type(discard=5, cycles=7, batches=3, directions=2)
      do i = 1, 30
         structure = between(draw(random, 0.1_wp, 0.4_wp), draw(random, 0.1_wp, 0.4_wp), 0.8_wp)
         if (mod(i, 2) == 0) structure = new_structure(reshape([1.0_wp, 0.1_wp, 1.0_wp], [1, 1, &
            3]), reshape([1.0_wp, -1.0_wp], [1, 2]), falling())
         most = huge(1)
         call average_from(structure, cosine_load(draw(random, 1.5_wp, 3.0_wp), 1.0_wp), [0.0_wp, &
            0.1_wp], average, most, found, status)
         call check(status == stat%ok .or. status == stat%budget, 'exponents: of a mass')
         if (status /= stat%ok .or. found%rests > 0) cycle
         call check(found%error >= 0 .and. found%error < 1.0e-10_wp, 'exponents: their sum')
      end do
      ! for the last structure the events are used up somewhere in the batches
      do i = 1, 5
         most = found%impacts - i
         call average_from(structure, cosine_load(2.0_wp, 1.0_wp), [0.0_wp, 0.1_wp], average, &
            most, less, status)
         call check(status == stat%event_limit .and. .not. allocated(less%exponents), &
            'exponents: none where the events are used up')
      end do
   end subroutine test_sums_of_exponents

   !> The exponents of the motion that begins at a state at time 0.
   subroutine average_from(structure, load, state, average, most, found, status, progress)
      type(structure_type), intent(in) :: structure
      type(load_type), intent(in) :: load
      real(wp), intent(in) :: state(:)
      type(average_type), intent(in) :: average
      integer, intent(in) :: most
      type(exponents_type), intent(out) :: found
      integer, intent(out) :: status
      integer, intent(inout), optional :: progress(3)
      type(run_type) :: run
      type(simulated_structure_type) :: motion

      call new_run(structure, load, run, status)
      if (status == stat%ok) call new_simulated_structure(run, 0.0_wp, state, most, motion, status)
      if (status == stat%ok) call exponents_along(motion, average, found, status, progress)
   end subroutine average_from

   !> A mass on a spring between two walls.
   pure type(structure_type) function between(upper, lower, restitution) result(structure)
      real(wp), intent(in) :: upper, lower, restitution

      structure = new_structure(reshape([1.0_wp, 0.1_wp, 1.0_wp], [1, 1, 3]), reshape([1.0_wp, &
         -1.0_wp], [1, 2]), reshape([upper, restitution, lower, restitution], [2, 2]))
   end function between

   !> Openings of two walls, and a law by which the speed after an impact falls beyond some approach
   !! speed.
   pure function falling() result(values)
      real(wp) :: values(7, 2)

      values(:, 1) = [0.3_wp, 2.0_wp, 2.0_wp, 0.0_wp, 1.0_wp, 0.9_wp, 0.1_wp]
      values(:, 2) = values(:, 1)
   end function falling

   !> A load on one mass.
   pure type(load_type) function cosine_load(frequency, force) result(load)
      real(wp), intent(in) :: frequency, force

      load = new_load(frequency, reshape([force, 0.0_wp], [1, 2, 1]), [0.0_wp])
   end function cosine_load

end module studies_structure_motions
