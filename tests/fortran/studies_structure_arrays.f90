!> Simulations and settled motions of structures, as arrays.
module studies_structure_arrays
   use checks, only: check
   use random_numbers, only: draw, fill, random_type
   use vi_kinds, only: wp
   use vi_motion, only: unknown
   use vi_status, only: stat
   use vi_structure, only: load_type, new_load, new_structure, structure_type
   use vi_structure_return, only: settle, settle_arrays, settled_type
   use vi_structure_run, only: stick_event
   use vi_structure_trajectory, only: sample_structure_arrays, simulate_structure_arrays
   implicit none (type, external)
   private

   public :: test_structure_arrays

   real(wp), parameter :: pi = acos(-1.0_wp)

contains

   subroutine test_structure_arrays()
      call test_capacity()
      call test_refused_starts()
      call test_samples_of_a_record()
      call test_refused_samples()
      call test_settled_arrays()
      call test_rest_through_all_impacts()
   end subroutine test_structure_arrays

   !> A mass on a spring that returns from a wall at its rest position without loss hits it every
   !! half period. The arrays may be filled with events; then they end with the last one.
   subroutine test_capacity()
      integer, parameter :: bounces = 300
      real(wp) :: table(5, bounces + 10), end_state(2), end_time
      integer :: labels(2, bounces + 10), i, n, room, status

      do room = bounces - 1, size(labels, 2)
         call simulate_structure_arrays(on_spring([1.0_wp, 0.0_wp, 1.0_wp], 1.0_wp), no_load(1), &
            0.0_wp, [-1.0_wp], [0.0_wp], bounces*pi, table(:, :room), labels(:, :room), n, &
            end_state, end_time, status)
         call check(n == min(room, bounces), 'arrays: all impacts, or as many as there is room for')
         call check(all([(abs(table(1, i) - (i - 0.5_wp)*pi) < 1.0e-10_wp*i .and. &
            abs(table(2, i) - 1) < 1.0e-10_wp*i .and. abs(table(3, i) - 2) < 1.0e-10_wp*i, &
            i=1, n)]), 'arrays: time, speed and impulse of each')
         if (room > bounces) then
            call check(status == stat%ok .and. abs(end_time - bounces*pi) <= 0, &
               'arrays: the end is reached')
            call check(maxval(abs(end_state - [-1, 0])) < 1.0e-9_wp, 'arrays: the state there')
         else
            call check(status == stat%more_events .and. abs(end_time - table(1, n)) <= 0, &
               'arrays: it ends with the event that fills them')
            call check(maxval(abs(end_state - table(4:, n))) <= 1.0e-14_wp, &
               'arrays: just after this event')
         end if
      end do
   end subroutine test_capacity

   !> A structure without mass and a start in a gap are refused, and the state stays.
   subroutine test_refused_starts()
      real(wp) :: table(5, 3), end_state(2), end_time
      integer :: labels(2, 3), n, status

      call simulate_structure_arrays(on_spring([0.0_wp, 0.0_wp, 1.0_wp], 1.0_wp), no_load(1), &
         2.0_wp, [-1.0_wp], [0.5_wp], 3.0_wp, table, labels, n, end_state, end_time, status)
      call check(status == stat%mass_not_definite .and. n == 0, 'arrays: no mass')
      call check(maxval(abs(end_state - [-1.0_wp, 0.5_wp])) <= 0 .and. abs(end_time - 2) <= 0, &
         'arrays: the start remains')
      call simulate_structure_arrays(on_spring([1.0_wp, 0.0_wp, 1.0_wp], 1.0_wp), no_load(1), &
         2.0_wp, [1.0_wp], [0.5_wp], 3.0_wp, table, labels, n, end_state, end_time, status)
      call check(status == stat%gap_closed .and. n == 0, 'arrays: a start in a gap')
   end subroutine test_refused_starts

   !> Between events, samples of a trajectory under a record are the final states of simulations up
   !! to these times, wherever they start and whether or not the record has ended.
   subroutine test_samples_of_a_record()
      integer, parameter :: samples = 12, room = 200, wanted = 40
      real(wp), parameter :: step = 0.7_wp, start = 0.3_wp, last = 12.0_wp
      type(random_type) :: random
      type(structure_type) :: structure
      type(load_type) :: load
      real(wp) :: record(2, samples), matrices(2, 2, 3), table(7, room), end_state(4), end_time, &
         starts(5, room + 1), times(wanted), values(4, wanted), other(7, room), largest(4)
      integer :: labels(2, room + 1), again(2, room), across, i, n, m, status, trial

      across = 0
      do trial = 1, 20
         matrices = 0
         matrices(:, :, 1) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.5_wp], [2, 2])
         matrices(:, :, 2) = reshape([0.2_wp, -0.1_wp, -0.1_wp, 0.1_wp], [2, 2])
         matrices(:, :, 3) = reshape([2.0_wp, -1.0_wp, -1.0_wp, 1.0_wp], [2, 2])
         structure = new_structure(matrices, reshape([1.0_wp, 0.0_wp], [2, 1]), &
            reshape([draw(random, 0.05_wp, 0.5_wp), 0.8_wp], [2, 1]))
         call fill(random, -2.0_wp, 2.0_wp, record(1, :))
         call fill(random, -2.0_wp, 2.0_wp, record(2, :))
         load = new_load(0.0_wp, reshape([real(wp) ::], [2, 2, 0]), [0.0_wp, 0.0_wp], step, record)
         call simulate_structure_arrays(structure, load, start, [0.0_wp, 0.1_wp], [0.2_wp, &
            0.0_wp], last, table, labels(:, 2:), n, end_state, end_time, status)
         call check(status == stat%ok .and. n > 0, 'samples: a simulation under a record')
         starts(:, 1) = [start, 0.0_wp, 0.1_wp, 0.2_wp, 0.0_wp]
         labels(:, 1) = 0
         starts(1, 2:n + 1) = table(1, :n)
         starts(2:, 2:n + 1) = table(4:, :n)
         ! the first time is in the interval of the start, or in a later one
         times = start + (last - start)*[((i - draw(random, 0.1_wp, 0.9_wp))/wanted, i=1, wanted)]
         call sample_structure_arrays(structure, load, starts(:, :n + 1), labels(:, :n + 1), &
            times, values, status)
         call check(status == stat%ok, 'samples: of a trajectory under a record')
         largest = maxval(abs(values), dim=2)
         do i = 1, wanted
            call simulate_structure_arrays(structure, load, start, [0.0_wp, 0.1_wp], [0.2_wp, &
               0.0_wp], times(i), other, again, m, end_state, end_time, status)
            call check(all(abs(values(:, i) - end_state) <= 1.0e-9_wp*largest), &
               'samples: the state in which a simulation up to the same time ends')
         end do
         across = across + count([(any(times > starts(1, i) .and. floor(times/step) > &
            floor(starts(1, i)/step)), i=1, n + 1)])
      end do
      call check(across > 20, 'samples: some are in later intervals of the record')
   end subroutine test_samples_of_a_record

   !> Samples need a mass, a start within bounds, and a motion while gaps rest; a gap may be closed
   !! at the start.
   subroutine test_refused_samples()
      type(structure_type) :: structure
      real(wp) :: values(2, 1), of_two(4, 2), matrices(2, 2, 3), cosine(2, 2, 1)
      integer :: status

      call sample_structure_arrays(on_spring([0.0_wp, 0.0_wp, 1.0_wp], 1.0_wp), no_load(1), &
         reshape([0.0_wp, -1.0_wp, 0.0_wp], [3, 1]), reshape([0, 0], [2, 1]), [1.0_wp], values, &
         status)
      call check(status == stat%mass_not_definite, 'samples: no mass')
      call sample_structure_arrays(on_spring([1.0_wp, 0.0_wp, 1.0_wp], 1.0_wp), no_load(1), &
         reshape([0.0_wp, -1.0e41_wp, 0.0_wp], [3, 1]), reshape([0, 0], [2, 1]), [1.0_wp], &
         values, status)
      call check(status == stat%extreme_units, 'samples: a start that is too far')
      call sample_structure_arrays(on_spring([1.0_wp, 0.0_wp, 1.0_wp], 1.0_wp), no_load(1), &
         reshape([0.0_wp, 2.0_wp, 0.0_wp], [3, 1]), reshape([0, 0], [2, 1]), [0.25_wp], values, &
         status)
      call check(status == stat%ok .and. maxval(abs(values(:, 1) - 2*[cos(0.25_wp), &
         -sin(0.25_wp)])) < 1.0e-14_wp, 'samples: a start in a gap is none of an event')
      ! with the first mass at rest, the second one resonates with the load
      matrices = 0
      matrices(:, :, 1) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2])
      matrices(1, 1, 2) = 0.1_wp
      matrices(:, :, 3) = reshape([2.0_wp, -1.0_wp, -1.0_wp, 2.0_wp], [2, 2])
      structure = new_structure(matrices, reshape([1.0_wp, 0.0_wp], [2, 1]), reshape([0.1_wp, &
         0.5_wp], [2, 1]))
      cosine(:, :, 1) = reshape([1.0_wp, 0.2_wp, 0.0_wp, 0.0_wp], [2, 2])
      call sample_structure_arrays(structure, new_load(sqrt(2.0_wp), cosine, [0.0_wp, 0.0_wp]), &
         reshape([0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.1_wp, 0.0_wp, 0.0_wp, &
         0.0_wp], [5, 2]), reshape([0, 0, stick_event, 1], [2, 2]), [0.5_wp, 1.5_wp], of_two, &
         status)
      call check(status == stat%resonance .and. any(abs(of_two(:, 1)) > 0) .and. &
         all(abs(of_two(:, 2)) <= 0), 'samples: up to a rest that has no motion')
   end subroutine test_refused_samples

   !> The arrays of a settled motion equal those of the motion; if there is no room for its impacts,
   !! only their number is known.
   subroutine test_settled_arrays()
      type(structure_type) :: structure
      type(load_type) :: load
      type(settled_type) :: found
      real(wp), allocatable :: impacts(:, :), states(:, :), rests(:, :)
      integer, allocatable :: labels(:, :)
      real(wp) :: cosine(1, 2, 1), p(2, 2), scalars(3)
      complex(wp) :: multipliers(2)
      integer :: counts(3), less, n, status, verdicts(3)

      structure = on_spring([1.0_wp, 0.1_wp, 1.0_wp], 0.1_wp)
      cosine = reshape([1.0_wp, 0.0_wp], [1, 2, 1])
      load = new_load(1.0_wp, cosine, [0.3_wp])
      call settle(structure, load, 0.0_wp, [0.0_wp], [0.0_wp], 5, 2, 0, found, status)
      call check(status == stat%ok .and. size(found%gaps) > 2 .and. size(found%resting) == 1, &
         'settled: a motion with rest')
      if (status /= stat%ok) return
      do less = -1, 1
         n = size(found%gaps) - less
         allocate (labels(2, n), impacts(n, 3), states(2, n), rests(2, n))
         call settle_arrays(structure, load, 0.0_wp, [0.0_wp, 0.0_wp], 5, 2, 0, counts, labels, &
            impacts, states, rests, p, multipliers, scalars, verdicts, status)
         call check(all(counts == [size(found%gaps), found%cycles, 1]), 'settled: its numbers')
         if (less > 0) then
            call check(status == stat%more_events .and. all(labels == 0) .and. &
               all(abs(impacts) <= 0) .and. all(verdicts == unknown), 'settled: no room')
         else
            n = size(found%gaps)
            call check(status == stat%ok .and. all(labels(1, :n) == found%gaps) .and. &
               all(labels(1, n + 1:) == 0) .and. labels(2, 1) == 1 .and. all(labels(2, 2:) == 0), &
               'settled: gaps of impacts and rests')
            call check(all(abs(impacts(:n, 1) - found%motion%phases) <= 0) .and. &
               all(abs(impacts(:n, 2) - found%motion%speeds) <= 0) .and. &
               all(abs(impacts(:n, 3) - found%motion%impulses) <= 0) .and. &
               all(abs(states(:, :n) - found%motion%states) <= 0) .and. &
               all(abs(rests(:, :1) - found%rests) <= 0), 'settled: impacts and rests')
            associate (known => found%motion%verdicts)
               call check(all(abs(p - known%p) <= 0) .and. all(abs(multipliers - &
                  known%multipliers) <= 0) .and. all(abs(scalars - [found%motion%residual, &
                  known%determinant, known%law]) <= 0) .and. all(verdicts == [known%consistent, &
                  known%admissible, known%stable]), 'settled: the derivative and verdicts')
            end associate
         end if
         deallocate (labels, impacts, states, rests)
      end do
      structure%mass = 0
      allocate (labels(2, 9), impacts(9, 3), states(2, 9), rests(2, 9))
      call settle_arrays(structure, load, 0.0_wp, [0.0_wp, 0.0_wp], 5, 2, 0, counts, labels, &
         impacts, states, rests, p, multipliers, scalars, verdicts, status)
      call check(status == stat%mass_not_definite .and. all(counts == 0), 'settled: no mass')
   end subroutine test_settled_arrays

   !> If a gap rests permanently while another one is hit, there is no flight from which a
   !! period could begin. The motion without this rest, in the gap, is not the simulated one.
   subroutine test_rest_through_all_impacts()
      type(settled_type) :: found
      real(wp) :: matrices(2, 2, 3), cosine(2, 2, 1), q(2)
      integer :: i, status

      matrices = 0
      do i = 1, 2
         matrices(i, i, :) = [1.0_wp, 0.1_wp, 1.0_wp]
      end do
      cosine(:, :, 1) = reshape([0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp], [2, 2])
      q = 0
      call settle(new_structure(matrices, reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2]), &
         reshape([0.0_wp, 0.5_wp, 0.5_wp, 0.8_wp], [2, 2])), new_load(1.0_wp, cosine, [1.0_wp, &
         0.0_wp]), 0.0_wp, q, q, 100, 2, 0, found, status)
      call check(status == stat%no_motion, 'settled: a rest through all impacts')
   end subroutine test_rest_through_all_impacts

   !> A mass on a spring, with a wall at its rest position.
   pure type(structure_type) function on_spring(values, restitution) result(structure)
      !> M, C and K; the coefficient of restitution of the wall.
      real(wp), intent(in) :: values(3), restitution

      structure = new_structure(reshape(values, [1, 1, 3]), reshape([1.0_wp], [1, 1]), &
         reshape([0.0_wp, restitution], [2, 1]))
   end function on_spring

   !> No load on some coordinates.
   pure type(load_type) function no_load(n) result(load)
      !> Their number.
      integer, intent(in) :: n
      integer :: i

      load = new_load(0.0_wp, reshape([real(wp) ::], [n, 2, 0]), [(0.0_wp, i=1, n)])
   end function no_load

end module studies_structure_arrays
