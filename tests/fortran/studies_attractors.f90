!> Laws of parts of studies of attractors: random states, and the integrity of a plane.
module studies_attractors
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use, intrinsic :: iso_fortran_env, only: int64
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, random_type
   use vi_attractor_integrity, only: largest_disc, uncertain_pairs, uncertainty_exponent
   use vi_attractor_known, only: identify, known_type, resting
   use vi_attractor_list, only: attractor_list_type, label_states
   use vi_attractor_neighbourhood, only: factorise
   use vi_attractor_spread, only: random_states
   use vi_attractor_tangent, only: period_derivative
   use vi_attractor_target, only: difference, over_period, target_type
   use vi_forced_system, only: event_type, forced_system_type, initial_state, new_forced_system, &
      state_type
   use vi_kinds, only: wp
   use vi_lapack, only: eigenvalues
   use vi_oscillator, only: gain, oscillator_type
   use vi_philox, only: philox
   use vi_simulate, only: simulate, simulate_on
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: test_attractors

   type(random_type) :: random

contains

   subroutine test_attractors()
      call test_known_words()
      call test_random_states()
      call test_uniform()
      call test_pairs()
      call test_disc()
      call test_metric()
      call test_parts(0.9_wp, 8)
      call test_parts(2.0e-6_wp, 2)
      call test_few_cycles()
      call test_plastic_impacts([0.0_wp, 0.0_wp])
      call test_plastic_impacts([0.0_wp, 0.2_wp])
      call test_plastic_impacts([0.2_wp, 0.0_wp])
   end subroutine test_attractors

   !> After an impact without restitution a state has three coordinates. The derivative over the
   !! period is that of the map, has the same multipliers from either wall, and all states of a
   !! neighbourhood return to the motion.
   subroutine test_plastic_impacts(restitution)
      !> R1 and R2.
      real(wp), intent(in) :: restitution(2)
      real(wp), parameter :: small = 1.0e-5_wp, zero(4) = 0
      type(forced_system_type) :: system
      type(known_type) :: known
      type(state_type) :: state, final
      type(event_type) :: events(2048)
      real(wp) :: p(4, 4), d(4), change(4), ends(5)
      complex(wp) :: lambda(4)
      integer :: n, status, i, j
      logical :: good

      system = new_forced_system(oscillator_type(0.1144_wp, 0.38_wp, restitution), 1.07_wp, &
         1.0_wp, 6.9_wp)
      state = initial_state(system, [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp])
      call simulate(system, state, 400_int64, 0.0_wp, events, n, final, status)
      ends = [final%phase/system%r, final%x, final%x_dot, final%z, final%z_dot]
      call identify(system, ends, 1, 1, known, good)
      call check(good .and. size(known%targets) == 2, 'a motion with two impacts is found')
      if (.not. (good .and. size(known%targets) == 2)) return
      do i = 1, 2
         associate (t => known%targets(i))
            call check(t%n == merge(3, 4, restitution(merge(1, 2, t%side > 0)) <= 0), &
               'three coordinates without restitution')
            call over_period(system, t, zero, events, n, good)
            call check(good, 'the period is simulated')
            call period_derivative(system, 1, events(:n), p, good)
            call check(good, 'it has a derivative')
            do j = 1, t%n
               d = 0
               d(j) = small
               call over_period(system, t, d, events, n, good)
               change = difference(t, events(n))
               call over_period(system, t, -d, events, n, good)
               change = (change - difference(t, events(n)))/(2*small)
               call check_close(maxval(abs(p(:, j) - change)), 0.0_wp, 1.0e-6_wp, &
                  'the derivative of the map over a period')
            end do
            call check(all(abs(p(t%n + 1:, :)) <= 0) .and. all(abs(p(:, t%n + 1:)) <= 0), 'no more')
            call eigenvalues(p, lambda, status)
            call check_close(maxval(abs(lambda)), known%largest, 1.0e-8_wp, 'from either wall')
            call check(t%radius > 0 .and. t%contraction < 1, 'a neighbourhood')
            ! from its surface to the motion
            do j = 1, t%n
               d = t%radius*t%inverse(:, j)
               call over_period(system, t, d, events, n, good)
               call check(good .and. norm2(matmul(t%metric, difference(t, events(n)))) &
                  < t%contraction*t%radius*1.1_wp, 'a state comes nearer to the motion')
            end do
         end associate
      end do
   end subroutine test_plastic_impacts

   !> States that end on a known motion have its number, even if few load cycles decide.
   subroutine test_few_cycles()
      integer, parameter :: n = 8
      type(attractor_list_type) :: list, again
      real(wp) :: starts(5, n), events
      integer :: labels(n), cycles

      do cycles = 2, 402, 400
         list = again
         list%system = new_forced_system(oscillator_type(0.1_wp, 0.09899_wp, [0.3_wp, 0.3_wp]), &
            1.132_wp, 1.0_wp, 0.9767_wp)
         starts = random_states(0.1_wp, 1.132_wp, 1.0_wp, 0.9767_wp, n, 84)
         call label_states(list, starts, cycles, 1, labels, events)
         call check(list%n == 1 .and. all(labels == 1), 'all states on one attractor')
         if (list%n == 1) call check(list%known(1)%kind == resting, 'a confirmed motion with rest')
      end do
   end subroutine test_few_cycles

   !> The metric is a root of the matrix in units of the coordinates; the inverse is its inverse.
   subroutine test_metric()
      type(target_type) :: target
      real(wp) :: a(4, 4), m(4, 4), scale(4), unit(4, 4)
      logical :: good
      integer :: i, j, k, n

      unit = 0
      do i = 1, 4
         unit(i, i) = 1
      end do
      do k = 1, 200
         n = merge(2, 4, mod(k, 2) == 0)
         do j = 1, 4
            scale(j) = 10.0_wp**draw(random, -3.0_wp, 3.0_wp)
            do i = 1, 4
               a(i, j) = draw(random, -1.0_wp, 1.0_wp)
            end do
         end do
         m = matmul(transpose(a), a) + unit
         call factorise(m, n, scale, target, good)
         call check(good, 'metric: of a positive matrix')
         call check(maxval(abs(matmul(target%metric(:n, :n), target%inverse(:n, :n)) &
            - unit(:n, :n))) < 1e-13_wp, 'metric: times inverse')
         call check(maxval(abs(target%metric(n + 1:, :))) <= 0 .or. n == 4, 'metric: of n states')
         do j = 1, n
            do i = 1, n
               call check_close(scale(i)*scale(j)*dot_product(target%metric(:, i), &
                  target%metric(:, j)), m(i, j), 1e-13_wp*(1 + maxval(abs(m))), 'metric: a root')
            end do
         end do
         m(n, n) = -m(n, n)
         call factorise(m, n, scale, target, good)
         call check(.not. good, 'metric: none of an indefinite matrix')
      end do
   end subroutine test_metric

   !> A simulation in parts, without a search for one event more after each part, equals that in
   !! one part; under a slow load one call takes several spans of time.
   subroutine test_parts(r, most)
      !> Frequency ratio, and largest number of load cycles.
      real(wp), intent(in) :: r
      integer, intent(in) :: most
      integer, parameter :: room = 4000
      type(forced_system_type) :: system
      type(state_type) :: state, final, last
      type(event_type) :: whole(room), part(7)
      integer :: cycles, found, i, left, n, status

      system = new_forced_system(oscillator_type(0.0114_wp, 0.028_wp, [0.75_wp, 0.61_wp]), r, &
         1.0_wp, 6.0_wp)
      do cycles = 1, most
         state = initial_state(system, [0.0_wp, 1.0_wp, 0.0_wp, 1.0_wp, 0.5_wp])
         left = room
         call simulate_on(system, state, int(cycles, int64), 0.0_wp, whole, n, last, left, status)
         call check(status == stat%ok .and. n > 0, 'a simulation in one part')
         state = initial_state(system, [0.0_wp, 1.0_wp, 0.0_wp, 1.0_wp, 0.5_wp])
         left = n + 1
         i = 0
         do
            call simulate_on(system, state, int(cycles, int64), 0.0_wp, part, found, final, left, &
               status, looks_on=.false.)
            call check(found <= size(part), 'room for events of a part')
            call check(all(part(:found)%cycle == whole(i + 1:i + found)%cycle) .and. &
               .not. any(abs(part(:found)%phase - whole(i + 1:i + found)%phase) > 0), &
               'events of a part')
            i = i + found
            if (status /= stat%more_events) exit
         end do
         call check(i == n .and. status == stat%ok .and. .not. abs(final%x - last%x) > 0, &
            'the end of a simulation in parts')
         state = initial_state(system, [0.0_wp, 1.0_wp, 0.0_wp, 1.0_wp, 0.5_wp])
         left = n - 1
         do
            call simulate_on(system, state, int(cycles, int64), 0.0_wp, part, found, final, left, &
               status, looks_on=.false.)
            if (status /= stat%more_events) exit
         end do
         call check(status == stat%event_limit, 'a limit of events in parts')
      end do
   end subroutine test_parts

   !> The known answers that come with Random123, the library of the authors of Philox.
   subroutine test_known_words()
      integer(int64), parameter :: all_ones = int(z'FFFFFFFF', int64)

      call check(all(philox(spread(0_int64, 1, 4), spread(0_int64, 1, 2)) == &
         [int(z'6627E8D5', int64), int(z'E169C58D', int64), int(z'BC57AC4C', int64), &
         int(z'9B00DBD8', int64)]), 'known words of zeros')
      call check(all(philox(spread(all_ones, 1, 4), spread(all_ones, 1, 2)) == &
         [int(z'408F276D', int64), int(z'41C83B0E', int64), int(z'A20BC7C6', int64), &
         int(z'6D5451FD', int64)]), 'known words of ones')
      call check(all(philox([int(z'243F6A88', int64), int(z'85A308D3', int64), &
         int(z'13198A2E', int64), int(z'03707344', int64)], [int(z'A4093822', int64), &
         int(z'299F31D0', int64)]) == [int(z'D16CFE09', int64), int(z'94FDCCEB', int64), &
         int(z'5001E420', int64), int(z'24126EA1', int64)]), 'known words of digits of pi')
   end subroutine test_known_words

   !> States are in their box, the first do not depend on their number, and all depend on the seed.
   subroutine test_random_states()
      real(wp) :: states(5, 200), more(5, 1000), others(5, 200), scale, xi, r, load, clearance
      integer :: i

      do i = 1, 50
         xi = draw(random, 0.001_wp, 0.9_wp)
         r = draw(random, 0.1_wp, 3.0_wp)
         load = draw(random, 0.0_wp, 2.0_wp)
         clearance = 10**draw(random, -2.0_wp, 2.0_wp)
         states = random_states(xi, r, load, clearance, 200, i)
         more = random_states(xi, r, load, clearance, 1000, i)
         others = random_states(xi, r, load, clearance, 200, i - 1)
         scale = min(max(load*gain(xi, r), 0.5_wp*clearance), 3*clearance)
         call check(all(abs(states(1, :)) <= 0), 'random states are at t = 0')
         call check(all(abs(more([2, 3, 5], :)) < scale), 'random states are in their box')
         call check(all(abs(more(4, :) - more(2, :)) < 0.5_wp*clearance*(1 + 1.0e-12_wp)), &
            'random states are between the walls')
         call check(maxval(abs(more([2, 3, 5], :))) > 0.99_wp*scale, 'random states fill their box')
         call check(all(abs(states - more(:, :200)) <= 0), 'more states begin with those of fewer')
         call check(all(abs(states(2:, :) - others(2:, :)) > 0), 'another seed, other states')
      end do
   end subroutine test_random_states

   !> 4**4 equal boxes contain equally many states within statistical scatter; successive states
   !! are independent.
   subroutine test_uniform()
      integer, parameter :: n = 100000, each = 4, boxes = each**4
      real(wp), allocatable :: states(:, :), u(:, :)
      real(wp) :: chi_square
      integer :: counts(0:boxes - 1), i, j, place

      allocate (states(5, n), u(4, n))
      do i = 0, 3
         states = random_states(0.5_wp, 1.0_wp, 0.0_wp, 2.0_wp, n, i)   ! a box from -1 to 1
         u = states(2:, :)
         u(3, :) = u(3, :) - u(1, :)
         counts = 0
         do j = 1, n
            place = dot_product(each**[0, 1, 2, 3], int(each*0.5_wp*(u(:, j) + 1)))
            counts(place) = counts(place) + 1
         end do
         chi_square = sum((counts - real(n, wp)/boxes)**2)/(real(n, wp)/boxes)
         call check(abs(chi_square - (boxes - 1)) < 4*sqrt(2.0_wp*(boxes - 1)), &
            'random states are uniform')
         do j = 1, 4
            ! the product of two independent numbers has the variance 1/9
            call check(abs(sum(u(j, 2:)*u(j, :n - 1))) < 4*sqrt(n/9.0_wp), &
               'neighbours are independent')
            call check(abs(sum(u(j, :)*u(modulo(j, 4) + 1, :))) < 4*sqrt(n/9.0_wp), &
               'coordinates are independent')
         end do
      end do
   end subroutine test_uniform

   !> All pairs are counted; the exponent is 1 for a straight boundary, 0 for noise, else NaN.
   subroutine test_pairs()
      integer, parameter :: side = 1280
      integer :: labels(61, 40), different, i, j, s, m, n
      integer, allocatable :: half(:, :)
      real(wp), allocatable :: pairs(:, :)

      do j = 1, size(labels, 2)
         do i = 1, size(labels, 1)
            labels(i, j) = draw_integer(random, 0, 2)
         end do
      end do
      m = size(labels, 1)
      n = size(labels, 2)
      allocate (pairs, source=uncertain_pairs(labels))
      call check(all(nint(pairs(1, :)) == [1, 2, 3, 4]), 'distances up to an eighth of the plane')
      do s = 1, 4
         different = 0
         do j = 1, n
            do i = 1, m
               if (i + s <= m) different = different + merge(0, 1, labels(i, j) == labels(i + s, j))
               if (j + s <= n) different = different + merge(0, 1, labels(i, j) == labels(i, j + s))
            end do
         end do
         call check_close(pairs(2, s), real(different, wp)/((m - s)*n + m*(n - s)), 0.0_wp, &
            'the share of pairs')
      end do
      call check(abs(uncertainty_exponent(pairs)) < 0.03_wp, 'noise has the exponent 0')
      ! not exact: there are fewer pairs far apart, as s/(side - s)
      allocate (half(side, side))
      do j = 1, side
         half(:, j) = [(merge(1, 0, 3*i + j > 2*side), i=1, side)]
      end do
      call check(abs(uncertainty_exponent(uncertain_pairs(half)) - 1) < 0.01_wp, &
         'a straight boundary has the exponent 1')
      half = 7
      call check(ieee_is_nan(uncertainty_exponent(uncertain_pairs(half))), 'no boundary, none')
      call check(ieee_is_nan(uncertainty_exponent(uncertain_pairs(half(:7, :)))), 'a narrow plane')
   end subroutine test_pairs

   !> The disc compared with all pairs of states, with the edge one cell beyond the last ones.
   subroutine test_disc()
      integer, allocatable :: labels(:, :)
      real(wp) :: cells(2), radius
      integer :: i, m, n, label, place(2)

      do i = 1, 400
         m = draw_integer(random, 1, 24)
         n = draw_integer(random, 1, 24)
         ! cells with a ratio of width to height from about 1/1000 to 1000
         cells = [10**draw(random, -3.0_wp, 3.0_wp), draw(random, 0.5_wp, 2.0_wp)]
         allocate (labels(m, n))
         call paint(labels)
         do label = 0, 2
            call largest_disc(labels, label, cells, radius, place)
            call check_close(radius, distance_at(labels, label, cells, place), 1.0e-12_wp*radius, &
               'the disc is inside the basin')
            call check_close(radius, widest(labels, label, cells), 1.0e-12_wp*radius, &
               'no disc inside the basin is larger')
         end do
         deallocate (labels)
      end do
   end subroutine test_disc

   !> Patches of labels; some planes have a single label, some are noise.
   subroutine paint(labels)
      integer, intent(out) :: labels(:, :)
      integer :: i, j, blot, size_of, first(2)

      labels = 0
      do blot = 1, draw_integer(random, 0, 40)
         first = [(draw_integer(random, 1, size(labels, i)), i=1, 2)]
         size_of = draw_integer(random, 0, 6)
         do j = first(2), min(first(2) + size_of, size(labels, 2))
            do i = first(1), min(first(1) + size_of, size(labels, 1))
               labels(i, j) = modulo(blot, 3)
            end do
         end do
      end do
   end subroutine paint

   real(wp) function widest(labels, label, cells)
      integer, intent(in) :: labels(:, :), label
      real(wp), intent(in) :: cells(2)
      integer :: i, j

      widest = 0
      do j = 1, size(labels, 2)
         do i = 1, size(labels, 1)
            widest = max(widest, distance_at(labels, label, cells, [i, j]))
         end do
      end do
   end function widest

   !> Distance from a state to the nearest one with a different label, by comparing all.
   real(wp) function distance_at(labels, label, cells, place) result(distance)
      integer, intent(in) :: labels(:, :), label, place(2)
      real(wp), intent(in) :: cells(2)
      integer :: i, j
      logical :: inside(0:size(labels, 1) + 1, 0:size(labels, 2) + 1)

      inside = .false.
      inside(1:size(labels, 1), 1:size(labels, 2)) = labels == label
      distance = huge(1.0_wp)
      do j = 0, size(labels, 2) + 1
         do i = 0, size(labels, 1) + 1
            if (.not. inside(i, j)) distance = min(distance, norm2(cells*([i, j] - place)))
         end do
      end do
   end function distance_at

end module studies_attractors
