!> Simulations of structures: their starts and ends, samples, repetitions, accumulations and rests.
module studies_structure_runs
   use, intrinsic :: iso_fortran_env, only: int64
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, fill, random_type
   use studies_structure_motions, only: between, cosine_load
   use vi_kinds, only: wp
   use vi_status, only: stat
   use vi_structure, only: load_type, new_load, new_structure, state_of, structure_type
   use vi_structure_return, only: repetition
   use vi_structure_run, only: impact_event, new_run, release_event, run_event_type, &
      run_state_type, run_type, simulate_structure, start_at, state_now, stick_event
   use vi_structure_trajectory, only: sample_structure_arrays, simulate_structure_arrays, &
      simulate_structure_case
   use vi_structure_variation, only: derivative_of_run
   implicit none (type, external)
   private

   public :: test_structure_runs

   real(wp), parameter :: pi = acos(-1.0_wp)

contains

   subroutine test_structure_runs()
      call test_ends()
      call test_repetition()
      call test_starts_at_a_gap()
      call test_far_starts()
      call test_samples_through_rests()
      call test_ends_of_accumulations()
      call test_mirrored_accumulations()
      call test_gaps_that_close_together()
      call test_spread_of_speeds()
      call test_lattices()
      call test_released_by_an_impact()
      call test_passages()
   end subroutine test_structure_runs

   !> Chains of many gaps: the same events, bit for bit, whether all rows are examined after each
   !! event or only those without a certificate; the latter grow less than the chain.
   subroutine test_lattices()
      integer, parameter :: cells(4) = [21, 30, 60, 120]
      real(wp) :: looks(size(cells))
      integer :: i, kind

      do kind = 1, 4
         do i = 1, merge(size(cells), 2, kind == 1)
            looks(i) = looks_of_lattice(cells(i), kind)
         end do
         if (kind > 1) cycle
         call check(looks(4) < 40, 'lattices: few looks an event')
         call check(looks(4) - looks(2) < 0.18_wp*(cells(4) - cells(2)), &
            'lattices: and hardly more in long chains')
      end do
   end subroutine test_lattices

   !> Examines rows for an event of a chain of hosts, each with a free mass in a slot.
   real(wp) function looks_of_lattice(cells, kind) result(looks)
      !> Number of hosts, and kind: undamped; with a load and losses, with free masses that fall to
      !! rest, and with walls on one side of some.
      integer, intent(in) :: cells, kind
      type(run_type) :: run, plain
      type(run_state_type) :: state, other, bare
      type(run_event_type), allocatable :: events(:), again(:), third(:)
      type(load_type) :: load
      real(wp) :: matrices(2*cells, 2*cells, 3), directions(2*cells, 2*cells), gaps(2, 2*cells), &
         sines(2*cells, 2, 1), constant(2*cells), q(2*cells), rate(2*cells)
      integer :: i, m, most, n, status
      logical :: same

      matrices = 0
      directions = 0
      sines = 0
      constant = 0
      do i = 1, cells
         matrices(i, i, 1) = 1
         matrices(cells + i, cells + i, 1) = 0.3_wp
         if (i < cells) matrices([i, i + 1], [i, i + 1], 3) = matrices([i, i + 1], [i, i + 1], 3) &
            + reshape([1, -1, -1, 1], [2, 2])
         directions([i, cells + i], 2*i - 1) = [-1, 1]
         directions(:, 2*i) = -directions(:, 2*i - 1)
      end do
      gaps(1, :) = 1
      gaps(2, :) = merge(1.0_wp, 0.8_wp, kind == 1)
      if (kind > 1) then
         do i = 1, cells
            matrices(i, i, 3) = matrices(i, i, 3) + 0.5_wp
         end do
         matrices(:cells, :cells, 2) = 0.02_wp*matrices(:cells, :cells, 3)
         sines(1, 2, 1) = 9
         sines(cells/2, 1, 1) = 5
      end if
      if (kind == 3) constant(cells + 1:) = -0.1_wp
      if (kind == 4) gaps(1, 2::6) = 1.0e9_wp
      q = 0
      rate = 0
      rate(1) = -10
      load = new_load(merge(0.0_wp, 1.3_wp, kind == 1), sines(:, :, :merge(0, 1, kind == 1)), &
         constant)
      call new_run(new_structure(matrices, directions, gaps), load, run, status)
      call start_at(run, 0.0_wp, q, rate, state, status)
      call check(status == stat%ok .and. run%regimes(1)%rows%alone, 'lattices: a chain')
      plain = run
      plain%regimes(1)%rows%alone = .false.
      other = state
      bare = state
      bare%bare = .true.
      most = merge(12, 4, kind == 1)*cells
      allocate (events(most), again(most), third(most))
      call simulate_structure(run, state, 10000_int64, 0.0_wp, events, n, status)
      call simulate_structure(plain, other, 10000_int64, 0.0_wp, again, m, status)
      same = n == m .and. n > 2*cells
      do i = 1, min(n, m)
         same = same .and. events(i)%kind == again(i)%kind .and. events(i)%gap == again(i)%gap &
            .and. events(i)%cycle == again(i)%cycle .and. .not. abs(events(i)%elapsed &
            - again(i)%elapsed) > 0 .and. .not. any(abs(events(i)%rate - again(i)%rate) > 0)
      end do
      call check(same, 'lattices: the same events without certificates')
      call simulate_structure(run, bare, 10000_int64, 0.0_wp, third, m, status)
      same = n == m
      do i = 1, min(n, m)
         same = same .and. events(i)%kind == third(i)%kind .and. events(i)%gap == third(i)%gap &
            .and. .not. abs(events(i)%elapsed - third(i)%elapsed) > 0 .and. .not. &
            any(abs(events(i)%x - third(i)%x) + abs(events(i)%v - third(i)%v) > 0)
      end do
      call check(same, 'lattices: the same events without coordinates')
      call check(.not. allocated(third(n)%q), 'lattices: which are then not computed')
      looks = real(state%space%watch%looks, wp)/n
   end function looks_of_lattice

   !> A simulation that reaches its end ends there to the last bit.
   subroutine test_ends()
      type(random_type) :: random
      type(structure_type) :: structure
      type(load_type) :: load
      real(wp), allocatable :: table(:, :), end_state(:)
      integer, allocatable :: labels(:, :)
      real(wp) :: rows(5, 400), at_end(2), end_time, frequency, last
      integer :: i, kinds(2, 400), n, status

      structure = between(0.2_wp, 50.0_wp, 0.7_wp)
      do i = 1, 100
         frequency = draw(random, 0.5_wp, 3.0_wp)
         load = cosine_load(frequency, 1.0_wp)
         last = draw(random, 1.0_wp, 60.0_wp)
         ! the last number below some periods: their number may be rounded up
         if (mod(i, 2) == 0) last = nearest(draw_integer(random, 1, 9)*(2*pi/frequency), -1.0_wp)
         call simulate_structure_case(structure, load, 0.0_wp, [0.0_wp], [0.1_wp], last, 400, &
            table, labels, n, end_state, end_time, status)
         call check(status == stat%ok .and. abs(end_time - last) <= 0, 'ends: of a simulation')
         call simulate_structure_arrays(structure, load, 0.0_wp, [0.0_wp], [0.1_wp], last, rows, &
            kinds, n, at_end, end_time, status)
         call check(status == stat%ok .and. abs(end_time - last) <= 0, 'ends: into arrays')
         call check(all(abs(at_end - end_state) <= 0), 'ends: in the same state')
      end do
   end subroutine test_ends

   !> States that repeat after some cycles do so for any signs, up to the permitted difference.
   subroutine test_repetition()
      integer, parameter :: most = 4
      real(wp), parameter :: near = 1.0e-4_wp
      type(random_type) :: random
      real(wp) :: strobes(4, 0:2*most), cycle(4, 0:most - 1), largest
      integer :: found, i, j, k, period

      do i = 1, 400
         period = draw_integer(random, 1, most)
         do j = 1, 4
            call fill(random, 0.5_wp, 2.0_wp, cycle(j, :))
         end do
         ! coordinates and velocities of one sign
         cycle(:2, :) = cycle(:2, :)*merge(1, -1, mod(i, 2) == 0)
         cycle(3:, :) = cycle(3:, :)*merge(100, -100, mod(i, 4) < 2)
         strobes = reshape([(cycle(:, modulo(j, period)), j=0, 2*most)], shape(strobes))
         call repetition(strobes, most, near, found)
         call check(found == period, 'repetition: after some cycles')
         k = draw_integer(random, 1, 4)
         j = draw_integer(random, 0, 2*most)
         largest = maxval(abs(strobes(merge(1, 3, k < 3):merge(2, 4, k < 3), :)))
         strobes(k, j) = strobes(k, j) + 0.9_wp*near*largest*merge(1, -1, mod(i, 8) < 4)
         call repetition(strobes, most, near, found)
         call check(found == period, 'repetition: up to a small difference')
         strobes(k, j) = strobes(k, j) + near*largest*merge(1, -1, mod(i, 8) < 4)
         call repetition(strobes, most, near, found)
         ! a state that differs rules out the periods that compare it
         call check(found == 0 .or. (found > j .and. found > 2*most - j), &
            'repetition: not beyond it')
      end do
   end subroutine test_repetition

   !> A gap that is less than the rounding of its terms is closed, and rests if its speed is the
   !! rounding of the velocities and the load presses on it, whatever the signs of all of them.
   subroutine test_starts_at_a_gap()
      type(random_type) :: random
      type(run_type) :: run
      type(run_state_type) :: state
      real(wp) :: direction(2), matrices(2, 2, 3), opening, q(2), rate(2), scale, most, reach
      integer :: i, status

      matrices = 0
      do i = 1, 2
         matrices(i, i, :) = [1.0_wp, 0.1_wp, 1.0_wp]
      end do
      do i = 1, 400
         direction = [draw(random, 0.5_wp, 2.0_wp)*merge(1, -1, mod(i, 2) == 0), &
            draw(random, 0.5_wp, 2.0_wp)*merge(1, -1, mod(i, 4) < 2)]
         opening = draw(random, 1.0_wp, 3.0_wp)*merge(1, -1, mod(i, 8) < 4)
         rate = draw(random, 1.0_wp, 2.0_wp)*merge(1, -1, mod(i, 16) < 8)*[1.0_wp, &
            -direction(1)/direction(2)]
         call new_run(new_structure(matrices, reshape(direction, [2, 1]), reshape([opening, &
            0.5_wp], [2, 1])), new_load(0.0_wp, reshape([real(wp) ::], [2, 2, 0]), &
            50*direction), run, status)
         q(1) = draw(random, -2.0_wp, 2.0_wp)
         q(2) = (opening - direction(1)*q(1))/direction(2)
         scale = abs(opening) + sum(abs(direction))*maxval(abs(q))
         call start(0.9e-13_wp, 0)
         call check(status == stat%ok .and. state%regime > 1, 'starts: a gap closed by rounding')
         ! the load and the velocities give the size of the motion where the coordinates do not
         reach = max(maxval(abs(rate)), 50*maxval(abs(direction)))
         most = 8*(dot_product(abs(direction), abs(rate)) + sum(abs(direction))*reach)/ &
            abs(direction(2)*rate(2))
         reach = 0.5_wp*sum(abs(direction))*reach/scale
         call start(0.9e-13_wp*(1 + reach), 0)
         call check(status == stat%ok, 'starts: a gap closed by rounding of the motion')
         call start(1.1e-13_wp*(1 + reach), 0)
         call check(status == stat%gap_closed, 'starts: a start in a gap')
         call start(-0.9e-13_wp, 0)
         call check(status == stat%ok .and. state%regime > 1, 'starts: a gap open by rounding')
         call start(-0.9e-13_wp*(1 + reach), 0)
         call check(status == stat%ok .and. state%regime > 1, &
            'starts: a gap open by rounding of the motion')
         call start(-1.1e-13_wp*(1 + reach), 0)
         call check(status == stat%ok .and. state%regime == 1, 'starts: an open gap')
         call start(0.0_wp, 12)
         call check(status == stat%ok .and. state%regime > 1, 'starts: a speed of rounding')
         call start(0.0_wp, -12)
         call check(status == stat%ok .and. state%regime > 1, 'starts: the opposite one')
         call start(0.0_wp, nint(0.9_wp*most))
         call check(status == stat%ok .and. state%regime > 1, &
            'starts: a speed of rounding of the motion')
         call start(0.0_wp, nint(1.1_wp*most))
         call check(status == stat%ok .and. state%regime == 1, 'starts: a speed')
         call start(0.0_wp, -nint(1.1_wp*most))
         call check(status == stat%ok .and. state%regime == 1, 'starts: the opposite speed')
      end do

   contains

      !> Starts in the gap by a fraction of its terms, with a number of roundings of a velocity.
      subroutine start(share, roundings)
         real(wp), intent(in) :: share
         integer, intent(in) :: roundings

         call start_at(run, 0.0_wp, [q(1), q(2) + share*scale/direction(2)], [rate(1), rate(2)*(1 &
            + roundings*epsilon(share))], state, status)
      end subroutine start
   end subroutine test_starts_at_a_gap

   !> Coordinates and velocities beyond the units of the numbers are refused, for any signs.
   subroutine test_far_starts()
      real(wp) :: table(5, 9), end_state(2), end_time
      integer :: labels(2, 9), n, side, status

      do side = -1, 1, 2
         call simulate_structure_arrays(between(50.0_wp, 50.0_wp, 0.5_wp), cosine_load(0.9_wp, &
            1.0_wp), 0.0_wp, [side*1.0e60_wp], [0.0_wp], 1.0_wp, table, labels, n, end_state, &
            end_time, status)
         call check(status == stat%extreme_units, 'starts: far away')
         call simulate_structure_arrays(between(50.0_wp, 50.0_wp, 0.5_wp), cosine_load(0.9_wp, &
            1.0_wp), 0.0_wp, [0.0_wp], [side*1.0e60_wp], 1.0_wp, table, labels, n, end_state, &
            end_time, status)
         call check(status == stat%extreme_units, 'starts: fast')
      end do
   end subroutine test_far_starts

   !> Samples of trajectories with rests equal the final states of simulations up to these times.
   subroutine test_samples_through_rests()
      integer, parameter :: room = 2000, wanted = 60
      real(wp), parameter :: last = 40.0_wp
      type(structure_type) :: structure
      type(load_type) :: load
      real(wp) :: matrices(2, 2, 3), cosine(2, 2, 1), table(7, room), end_state(4), end_time, &
         starts(5, room + 1), times(wanted), values(4, wanted), other(7, room), largest(4)
      integer :: labels(2, room + 1), again(2, room), i, m, n, status

      matrices(:, :, 1) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.5_wp], [2, 2])
      matrices(:, :, 2) = reshape([0.2_wp, -0.1_wp, -0.1_wp, 0.1_wp], [2, 2])
      matrices(:, :, 3) = reshape([2.0_wp, -1.0_wp, -1.0_wp, 1.0_wp], [2, 2])
      structure = new_structure(matrices, reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2]), &
         reshape([0.1_wp, 0.2_wp, 0.15_wp, 0.1_wp], [2, 2]))
      cosine(:, :, 1) = reshape([1.0_wp, 0.3_wp, 0.0_wp, 0.5_wp], [2, 2])
      load = new_load(0.7_wp, cosine, [0.2_wp, 0.1_wp])
      call simulate_structure_arrays(structure, load, 0.0_wp, [0.0_wp, 0.0_wp], [0.2_wp, 0.0_wp], &
         last, table, labels(:, 2:), n, end_state, end_time, status)
      call check(status == stat%ok .and. count(labels(1, 2:n + 1) == release_event .and. &
         labels(2, 2:n + 1) == 1) > 2 .and. count(labels(1, 2:n + 1) == release_event .and. &
         labels(2, 2:n + 1) == 2) > 2, 'rests: of both gaps')
      if (status /= stat%ok) return
      starts(:, 1) = [0.0_wp, 0.0_wp, 0.0_wp, 0.2_wp, 0.0_wp]
      labels(:, 1) = 0
      starts(1, 2:n + 1) = table(1, :n)
      starts(2:, 2:n + 1) = table(4:, :n)
      times = last*[((i - 0.37_wp)/wanted, i=1, wanted)]
      call sample_structure_arrays(structure, load, starts(:, :n + 1), labels(:, :n + 1), times, &
         values, status)
      call check(status == stat%ok, 'rests: samples')
      largest = maxval(abs(values), dim=2)
      do i = 1, wanted
         call simulate_structure_arrays(structure, load, 0.0_wp, [0.0_wp, 0.0_wp], [0.2_wp, &
            0.0_wp], times(i), other, again, m, end_state, end_time, status)
         call check(all(abs(values(:, i) - end_state) <= 1.0e-9_wp*largest), &
            'rests: samples are states of simulations')
      end do
   end subroutine test_samples_through_rests

   !> A mass that falls on a wall comes to rest after infinitely many impacts at a known time: a
   !! simulation that ends before that time, by however little, has no rest.
   subroutine test_ends_of_accumulations()
      type(random_type) :: random
      type(run_type) :: run
      type(run_state_type) :: state
      type(run_event_type) :: events(200)
      real(wp) :: at, early, force, restitution
      integer :: i, n, status

      do i = 1, 200
         restitution = draw(random, 0.1_wp, 0.6_wp)
         force = draw(random, 0.5_wp, 2.0_wp)
         ! it falls from a distance of 1 and returns with R times the speed
         at = sqrt(2/force)*(1 + 2*restitution/(1 - restitution))
         early = 10.0_wp**draw(random, -12.0_wp, -3.0_wp)*merge(1, -1, mod(i, 2) == 0)
         call new_run(new_structure(reshape([1.0_wp, 0.0_wp, 0.0_wp], [1, 1, 3]), &
            reshape([1.0_wp], [1, 1]), reshape([1.0_wp, restitution], [2, 1])), &
            new_load(0.0_wp, reshape([real(wp) ::], [1, 2, 0]), [force]), run, status)
         call start_at(run, 0.0_wp, [0.0_wp], [0.0_wp], state, status)
         call simulate_structure(run, state, int(at - early, int64), modulo(at - early, 1.0_wp), &
            events, n, status)
         call check(status == stat%ok .and. (count(events(:n)%kind == stick_event) == 1) .eqv. &
            early < 0, 'accumulations: a rest where the end is not before it')
         call check(all(real(events(:n)%cycle, wp) + events(:n)%elapsed <= at - early &
            + 1.0e-14_wp), 'accumulations: no event after the end')
         if (early < 0) call check_close(real(events(n)%cycle, wp) + events(n)%elapsed, at, &
            1.0e-13_wp, 'accumulations: when a rest begins')
      end do
   end subroutine test_ends_of_accumulations

   !> A motion with rests on a wall has its events at the same times on the opposite wall under the
   !! opposite load.
   subroutine test_mirrored_accumulations()
      type(random_type) :: random
      real(wp) :: table(5, 2000), other(5, 2000), end_state(2), end_time, frequency, constant
      integer :: i, labels(2, 2000), m, marks(2, 2000), n, rests, status

      rests = 0
      do i = 1, 40
         frequency = draw(random, 0.5_wp, 2.0_wp)
         constant = draw(random, 0.2_wp, 0.6_wp)
         call simulate_structure_arrays(between(0.1_wp, 50.0_wp, 0.3_wp), loaded(1.0_wp), 0.0_wp, &
            [0.0_wp], [0.1_wp], 30.0_wp, table, labels, n, end_state, end_time, status)
         call check(status == stat%ok, 'mirrored: a simulation')
         call simulate_structure_arrays(between(50.0_wp, 0.1_wp, 0.3_wp), loaded(-1.0_wp), &
            0.0_wp, [0.0_wp], [-0.1_wp], 30.0_wp, other, marks, m, end_state, end_time, status)
         call check(status == stat%ok .and. m == n, 'mirrored: as many events')
         if (m /= n) cycle
         call check(all(labels(1, :n) == marks(1, :n)) .and. all(labels(2, :n) == 1) .and. &
            all(marks(2, :n) == 2), 'mirrored: the same events on the other wall')
         call check(maxval(abs(table(1, :n) - other(1, :n))) <= 1.0e-14_wp*30, &
            'mirrored: at the same times')
         rests = rests + count(labels(1, :n) == stick_event)
      end do
      call check(rests > 100, 'mirrored: some with rests')

   contains

      !> A load that presses on a wall.
      type(load_type) function loaded(side)
         real(wp), intent(in) :: side

         loaded = new_load(frequency, reshape([side, 0.5_wp*side], [1, 2, 1]), [constant*side])
      end function loaded
   end subroutine test_mirrored_accumulations

   !> Two gaps of a mass that close at the same position have no defined outcome, at any position,
   !! and next to a gap that stays open: openings at q = 0 may be negative.
   subroutine test_gaps_that_close_together()
      type(random_type) :: random
      real(wp) :: direction, opening, table(5, 9), end_state(2), end_time
      integer :: i, labels(2, 9), n, status

      do i = 1, 400
         direction = draw(random, 0.5_wp, 2.0_wp)*merge(1, -1, mod(i, 2) == 0)
         opening = draw(random, 0.5_wp, 3.0_wp)*merge(1, -1, mod(i, 4) < 2)
         call simulate_structure_arrays(new_structure(reshape([1.0_wp, 0.1_wp, 1.0_wp], [1, 1, &
            3]), reshape([direction, direction, direction], [1, 3]), reshape([opening, 0.5_wp, &
            opening, 0.5_wp, opening + 5, 0.5_wp], [2, 3])), cosine_load(0.9_wp, 0.3_wp), &
            0.0_wp, [(opening - 1)/direction], [(6*abs(opening - 1) + 6)/direction], 20.0_wp, &
            table, labels, n, end_state, end_time, status)
         call check(status == stat%coupled_impacts .and. n == 0, 'coupled: gaps that close at once')
      end do
   end subroutine test_gaps_that_close_together

   !> The ratio of the greatest approach speed to the least one leaves accumulations out of the
   !! latter.
   subroutine test_spread_of_speeds()
      type(random_type) :: random
      type(run_type) :: run
      type(run_state_type) :: first, last
      type(run_event_type) :: events(300)
      real(wp) :: largest, law, least, p(2, 2), spread
      integer :: i, j, n, status, with(2)

      with = 0
      do i = 1, 200
         call new_run(between(draw(random, 0.0_wp, 1.0_wp), draw(random, 0.0_wp, 1.0_wp), &
            merge(0.8_wp, 0.1_wp, mod(i, 2) == 0)), cosine_load(draw(random, 0.3_wp, 2.0_wp), &
            1.0_wp), run, status)
         call start_at(run, 0.0_wp, [0.0_wp], [0.3_wp], first, status)
         last = first
         call simulate_structure(run, last, int(draw_integer(random, 1, 4), int64), 0.0_wp, &
            events, n, status)
         if (status /= stat%ok) cycle
         call derivative_of_run(run, first, events(:n), last, p, spread, law, status)
         call check(status == stat%ok, 'spread: a derivative')
         call check_close(p(1, 1)*p(2, 2) - p(1, 2)*p(2, 1), law, 1.0e-10_wp*max(1.0_wp, &
            abs(p(1, 1)*p(2, 2))), 'spread: the law of the determinant')
         largest = 0
         least = huge(1.0_wp)
         do j = 1, n
            if (events(j)%kind == impact_event) largest = max(largest, events(j)%speed)
            if (events(j)%kind == impact_event .and. .not. any(events(j + 1:n)%gap == &
               events(j)%gap .and. events(j + 1:n)%kind /= impact_event)) least = min(least, &
               events(j)%speed)
         end do
         call check_close(spread, max(1.0_wp, largest/least), 1.0e-14_wp*spread, &
            'spread: of approach speeds')
         if (spread > 1.1_wp) with(1) = with(1) + 1
         if (any(events(:n)%kind == stick_event)) with(2) = with(2) + 1
      end do
      call check(all(with > 20), 'spread: different speeds, and rests')
   end subroutine test_spread_of_speeds

   !> If an impact makes a contact pull, through a dashpot, it is released at the time of that
   !! impact: the derivative of the simulation contains the jump of accelerations.
   subroutine test_released_by_an_impact()
      real(wp), parameter :: step = 1.0e-5_wp
      type(random_type) :: random
      type(structure_type) :: structure
      type(run_type) :: run
      type(run_state_type) :: first, last
      type(run_event_type) :: events(20)
      real(wp) :: at(4), damping, ends(4, -2:2), law, p(4, 4), slopes(4), spread
      integer :: i, j, k, n, status

      do i = 1, 20
         damping = draw(random, 0.2_wp, 0.8_wp)
         structure = new_structure(reshape([1.0_wp, 0.0_wp, 0.0_wp, draw(random, 0.8_wp, 2.0_wp), &
            damping, -damping, -damping, damping, 0.0_wp, 0.0_wp, 0.0_wp, draw(random, 0.0_wp, &
            0.1_wp)], [2, 2, 3]), reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2]), &
            reshape([0.0_wp, 0.0_wp, 0.6_wp, draw(random, 0.7_wp, 1.0_wp)], [2, 2]))
         call new_run(structure, new_load(0.0_wp, reshape([real(wp) ::], [2, 2, 0]), [0.05_wp, &
            0.0_wp]), run, status)
         at = [0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp]
         call simulate(at)
         call check(any(events(:n)%kind == release_event), 'released by an impact: it is')
         if (.not. any(events(:n)%kind == release_event)) cycle
         associate (after => events(findloc(events(:n)%kind, release_event, dim=1)))
            call check(after%gap == 1 .and. abs(after%elapsed - events(1)%elapsed) <= 0, &
               'released by an impact: at its time')
         end associate
         call derivative_of_run(run, first, events(:n), last, p, spread, law, status)
         ! the first body must not move at the start
         do j = 2, 4, 2
            do k = -2, 2
               at = [0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp]
               at(j) = at(j) + k*step
               call simulate(at)
               ends(:, k) = [last_state()]
            end do
            slopes = (8*(ends(:, 1) - ends(:, -1)) - (ends(:, 2) - ends(:, -2)))/(12*step)
            call check(maxval(abs(p(:, j) - slopes)) <= 1.0e-8_wp*max(1.0_wp, &
               maxval(abs(slopes))), 'released by an impact: the derivative')
         end do
      end do
   contains
      !> Simulates from a state.
      subroutine simulate(from)
         !> Coordinates and velocities.
         real(wp), intent(in) :: from(4)

         call start_at(run, 0.0_wp, from(:2), from(3:), first, status)
         last = first
         call simulate_structure(run, last, 1_int64, 0.5_wp, events, n, status)
      end subroutine simulate

      !> Coordinates and velocities at the end.
      function last_state() result(numbers)
         real(wp) :: numbers(4)

         call state_now(run, last, numbers(:2), numbers(3:))
      end function last_state
   end subroutine test_released_by_an_impact

   !> Coordinates and velocities are continuous where stops are touched and left, also after
   !! hundreds of such events, and whatever number of pairs the structure has.
   subroutine test_passages()
      integer, parameter :: sizes(4) = [1, 2, 8, 9]
      type(random_type) :: random
      type(run_type) :: run
      type(run_state_type) :: state
      type(run_event_type) :: events(400)
      real(wp), allocatable :: directions(:, :), harmonics(:, :, :), matrices(:, :, :), &
         numbers(:), q(:), rate(:), stops(:, :)
      real(wp) :: frequency
      integer :: i, j, n, found, status
      logical :: many

      do i = 1, 3*size(sizes)
         n = sizes(1 + mod(i, size(sizes)))
         allocate (matrices(n, n, 3), directions(n, 3), source=0.0_wp)
         allocate (q(n), rate(n))
         do j = 1, n
            matrices(j, j, 1) = draw(random, 0.5_wp, 2.0_wp)
            matrices(j, j, 2) = draw(random, 0.02_wp, 0.2_wp)
            matrices(j, j, 3) = 2
            if (j > 1) matrices(j, j - 1, 3) = -1
            if (j > 1) matrices(j - 1, j, 3) = -1
         end do
         many = i > 2*size(sizes)
         numbers = [(draw(random, -1.0_wp, 1.0_wp), j=1, 2*n*merge(9, 2, many))]
         harmonics = reshape(numbers, [n, 2, size(numbers)/(2*n)])
         directions(1, 1) = 1
         directions(1, 2) = -1
         directions(n, 3) = 1
         frequency = draw(random, 0.5_wp, 1.5_wp)
         ! elastic stops, one of which is preloaded, and one that cannot pull
         stops = reshape([0.3_wp, 3.0_wp, 40.0_wp, 0.5_wp, 0.1_wp, 0.0_wp, 0.0_wp, 0.2_wp, 4.0_wp, &
            30.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.4_wp, 3.0_wp, 60.0_wp, 0.0_wp, 0.0_wp, &
            0.0_wp, 0.0_wp], [7, 3])
         if (many) then
            ! the first one moves, and a wall without rebound replaces the last one
            stops(2:, 1) = [13.0_wp, 0.02_wp, 0.03_wp, 40.0_wp, 0.5_wp, 0.1_wp]
            stops(2:3, 3) = 0
         end if
         call new_run(new_structure(matrices, directions, stops), new_load(frequency, harmonics, &
            [(0.0_wp, j=1, n)]), run, status)
         q = 0
         rate = 0
         if (status == stat%ok) call start_at(run, 0.0_wp, q, rate, state, status)
         if (status == stat%ok) call simulate_structure(run, state, 10000_int64, 0.0_wp, events, &
            found, status)
         call check(status == stat%more_events .and. found == size(events), 'passages: events')
         if (many) call check(any(events%kind == impact_event), 'passages: impacts on the wall')
         do j = 1, merge(found, 0, status == stat%more_events)
            associate (event => events(j))
               call state_of(run%regimes(event%regime), frequency*event%elapsed, event%x, event%v, &
                  q, rate)
               call check(maxval(abs([q - event%q, rate - event%rate])) <= 1.0e-13_wp &
                  *maxval(abs([event%q, event%rate])), 'passages: q and q'' are continuous')
            end associate
         end do
         deallocate (matrices, directions, harmonics, q, rate)
      end do
   end subroutine test_passages

end module studies_structure_runs
