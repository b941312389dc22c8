!> Laws on the surface of motions of one pattern over a window: zeros of conditions on a step, the
!! lines of a net, steps of a branch, and displaced boundaries.
module studies_surfaces
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, draw_log, random_type
   use vi_branch, only: branch_type, follow_branch
   use vi_boundary_shift, only: shift_boundary, shift_lost
   use vi_conditions, only: all_conditions, condition_count, condition_value
   use vi_crossing, only: innermost_zero, locate
   use vi_curve, only: curve_type, parameters_of, unknowns_of
   use vi_kinds, only: wp
   use vi_loop, only: loop_type
   use vi_lattice, only: density, even_lattice, lattice_type, new_lattice
   use vi_motion_family, only: condition_type, grazing, is_inside, neimark_sacker, repetition
   use vi_net, only: add_seed, cover_from, net_type, new_net
   use vi_net_line, only: line_of, start_type
   use vi_orbit, only: n_parameters
   use vi_oscillator, only: gain, oscillator_type
   use vi_pattern, only: pattern_type
   use vi_releases, only: release_type, simulate_releases
   use vi_repetition_vertices, only: move_to_repetition
   use vi_search, only: search_pattern
   use vi_status, only: stat
   use vi_steps, only: begin_walk, place_type, stride_type, take_step
   use vi_zone_request, only: make_surface, zone_request_type
   implicit none (type, external)
   private

   public :: test_surfaces

   !> The middle of a window that is not larger than the units.
   real(wp), parameter :: middle(2) = 0.5_wp

   character(4), parameter :: patterns(4) = [character(4) :: 'RL', 'RRL', 'RLL', 'RRLL']

   type(random_type) :: random

contains

   subroutine test_surfaces()
      call test_windows()
      call test_lost_vertices()
      call test_vertices_of_nothing()
      call test_zeros()
      call test_lattices()
      call test_nets()
      call test_full_nets()
      call test_branches()
      call test_blind_steps()
      call test_full_searches()
      call test_many_impacts()
      call test_other_repetitions()
   end subroutine test_surfaces

   !> Lines of constant r are nowhere farther apart than their density allows. Where they are not
   !! evenly spaced, the integral of the density (Simpson's rule) is the same between any two. One
   !! further line lies on each resonance r = 1/n.
   subroutine test_lattices()
      real(wp), parameter :: windows(2, 6) = reshape([0.1_wp, 0.6_wp, 0.3_wp, 0.9_wp, 0.5_wp, &
         1.5_wp, 0.9137_wp, 1.1_wp, 1.02_wp, 3.0_wp, 1.5_wp, 6.0_wp], [2, 6])
      integer, parameter :: steps = 200
      type(random_type) :: own
      type(lattice_type) :: lattice
      real(wp), allocatable :: parts(:), at(:)
      integer :: i, j, k, lines

      do i = 1, size(windows, 2)
         lines = draw_integer(own, 2, 33)
         lattice = new_lattice(lines, [windows(:, i), 0.0_wp, 1.0_wp], [1.0_wp, 1.0_wp])
         at = windows(1, i) + lattice%axes(1)%at
         do j = ceiling(1/windows(2, i)), floor(1/windows(1, i))
            call check(minval(abs(at - 1.0_wp/j)) < 1.0e-6_wp, 'a line lies on each resonance')
         end do
         associate (inner => at(2:size(at) - 1))
            at = [at(1), pack(inner, abs(1/inner - nint(1/inner)) > 1.0e-9_wp), at(size(at))]
         end associate
         allocate (parts(size(at) - 1))
         do j = 1, size(parts)
            associate (h => (at(j + 1) - at(j))/steps)
               parts(j) = h/3*sum([(merge(1, merge(4, 2, mod(k, 2) == 1), k == 0 .or. k == steps) &
                  *density(at(j) + k*h), k=0, steps)])
            end associate
         end do
         call check_close(at(size(at)), windows(2, i), 1.0e-13_wp, 'lines from bound to bound')
         ! at most eight times as many lines as requested
         if (size(at) < 8*(lines - 1)) call check(all(parts*(lines - 1) <= 16*(1 + 1.0e-6_wp)), &
            'lines are as near as their density asks')
         associate (apart => at(2:) - at(:size(at) - 1))
            call check(maxval(apart) <= 1.001_wp*minval(apart) .or. maxval(parts) <= minval(parts) &
               *(1 + 1.0e-6_wp), 'lines are even in r, or in the integral of their density')
         end associate
         deallocate (parts)
      end do
   end subroutine test_lattices

   pure function sides_of(text) result(sides)
      character(*), intent(in) :: text
      integer, allocatable :: sides(:)
      integer :: i

      sides = [(merge(1, -1, text(i:i) == 'R'), i=1, len_trim(text))]
   end function sides_of

   !> A small window is the unit square, for any size: steps along its lines are fractions of it.
   !! In a large one a unit does not depend on the size: steps are as short as in another one.
   subroutine test_windows()
      type(zone_request_type) :: request
      type(curve_type) :: small, large, larger
      real(wp), parameter :: square(2) = 1, zero(4) = 0
      real(wp) :: r, clearance, width(2), q(2)
      real(wp), allocatable :: c(:)
      integer :: i, status

      request%osc = oscillator_type(0.01_wp, 0.05_wp, [0.7_wp, 0.6_wp])
      request%pattern = pattern_type(sides_of('RL'), 1)
      do i = 1, 200
         r = draw(random, 0.3_wp, 2.0_wp)
         clearance = draw_log(random, 0.1_wp, 100.0_wp)
         width = [draw_log(random, 1.0e-4_wp, 0.3_wp), draw_log(random, 1.0e-4_wp, 4.0_wp)]
         call resize(width, small)
         c = parameters_of(small, [zero, square])
         call check_close(c(1), request%r(2), 1e-14_wp*r, 'windows: r at the upper corner')
         call check_close(c(2), log(request%clearance(2)), 1e-13_wp, 'windows: and the clearance')
         width = [draw(random, 0.5_wp, 2.0_wp), draw(random, 5.0_wp, 8.0_wp)]
         call resize(width, large)
         call resize(2*width, larger)
         q(1) = draw(random, 0.0_wp, 1.0_wp)
         q(2) = draw(random, 0.0_wp, 1.0_wp)
         call check_close(norm2(parameters_of(large, [zero, q]) - parameters_of(larger, &
            [zero, q])), 0.0_wp, 0.0_wp, 'windows: units of large ones')
      end do

   contains

      subroutine resize(by, surface)
         real(wp), intent(in) :: by(2)
         type(curve_type), intent(out) :: surface

         request%r = [r, r + by(1)]
         request%clearance = clearance*[1.0_wp, exp(by(2))]
         call make_surface(request, surface, status)
         call check(status == stat%ok, 'windows: a pattern with motions')
      end subroutine resize

   end subroutine test_windows

   !> A vertex that is not found is marked as lost and has no number: a condition that the
   !! family does not have, a pattern without such motions, and vertices left out by a stop.
   subroutine test_lost_vertices()
      integer, parameter :: fold = 1, rest_vanishes = 7
      type(zone_request_type) :: request
      real(wp) :: normals(2, 1), slopes(6, 1), shifts(3, 1)
      real(wp), parameter :: theta(3, 1) = reshape([0.0_wp, 2.0_wp, 4.0_wp], [3, 1]), &
         x(3, 1) = reshape([0.3_wp, 0.2_wp, -0.4_wp], [3, 1]), places(2, 1) = reshape([0.9_wp, &
         6.0_wp], [2, 1])
      integer :: outcomes(3, 1), status(1), progress(3), i
      real(wp) :: changes(6, 3)

      request%osc = oscillator_type(0.01_wp, 0.05_wp, [0.7_wp, 0.7_wp])
      request%r = [0.8_wp, 1.1_wp]
      request%clearance = [2.0_wp, 20.0_wp]
      request%pattern = pattern_type(sides_of('RRL'), 1)
      changes = spread([1.0_wp, 1.0_wp, 0.01_wp, 0.05_wp, 0.7_wp, 0.7_wp], 2, 3)
      do i = 1, 3
         progress = 0
         if (i == 3) progress(3) = 1
         request%symmetric = i == 2
         outcomes = -99
         call shift_boundary(request, [merge(rest_vanishes, fold, i == 1)], [0], places, x, theta, &
            changes, 1, normals, slopes, shifts, outcomes, status, progress)
         call check(status(1) == merge(stat%not_computed, stat%no_motion, i == 3), &
            'lost vertices: the reason')
         call check(all(outcomes == shift_lost), 'lost vertices are said to be lost')
         call check(all(ieee_is_nan(shifts)) .and. all(ieee_is_nan(normals)) .and. &
            all(ieee_is_nan(slopes)), 'lost vertices have no numbers')
      end do
   end subroutine test_lost_vertices

   !> Lines over the surfaces of random patterns: if a condition has different signs at two motions
   !! of a line, it is zero in between, and both ends lead to the same zero.
   subroutine test_zeros()
      type(zone_request_type) :: request
      type(curve_type) :: surface, line
      real(wp), allocatable :: found(:, :)
      integer :: i, k, status, zeros, borders, hidden

      zeros = 0
      borders = 0
      hidden = 0
      do i = 1, 300
         call random_request(i, request)
         call make_surface(request, surface, status)
         call surface%family%motions_at(parameters_at(surface, middle), 6, 0, found)
         do k = 1, size(found, 2)
            call line_of(surface, start_type(found(:, k), middle), 1 + mod(i + k, 2), line)
            line%family%every_crossing = mod(i, 2) == 0
            call walk(line, [found(:, k), 0.5_wp], zeros, borders, hidden)
         end do
      end do
      call check(zeros > 1000 .and. borders > 100, 'zeros: many are found')
      call check(hidden > 0, 'zeros: some are passed twice in one step')
   end subroutine test_zeros

   !> r, log(D), xi, mu, R1, R2 at a point of a surface.
   pure function parameters_at(surface, at) result(c)
      type(curve_type), intent(in) :: surface
      real(wp), intent(in) :: at(2)
      real(wp) :: c(n_parameters)
      integer :: i

      c = parameters_of(surface, [(0.0_wp, i=1, surface%family%unknown_count()), at])
   end function parameters_at

   !> Vertices without a motion: a pattern with more unknowns than the arrays hold together with
   !! all parameters, and a point with no motion of the pattern nearby.
   subroutine test_vertices_of_nothing()
      integer, parameter :: most = 24, fold = 1
      type(zone_request_type) :: request
      real(wp) :: normals(2, 1), slopes(6, 1), shifts(1, 1), changes(6, 1), x(most, 1), &
         theta(most, 1)
      integer :: outcomes(1, 1), status(1), i, n

      request%osc = oscillator_type(0.01_wp, 0.05_wp, [0.7_wp, 0.6_wp])
      request%r = [0.8_wp, 1.1_wp]
      request%clearance = [2.0_wp, 20.0_wp]
      changes(:, 1) = [1.0_wp, 1.0_wp, 0.01_wp, 0.05_wp, 0.7_wp, 0.6_wp]
      do n = 2, most, 22
         request%pattern = pattern_type([(1, i=1, n - 1), -1], 1)
         x(:, 1) = [(0.1_wp*i, i=1, most)]
         theta(:, 1) = [(6.0_wp*i/n, i=1, most)]
         call shift_boundary(request, [fold], [0], reshape([0.9_wp, 6.0_wp], [2, 1]), x(:n, :), &
            theta(:n, :), changes, 1, normals, slopes, shifts, outcomes, status)
         call check(status(1) == merge(stat%singular, stat%no_motion, n == 2), &
            'vertices of nothing: the reason')
         call check(outcomes(1, 1) == shift_lost .and. ieee_is_nan(shifts(1, 1)) .and. &
            all(ieee_is_nan(normals)), 'vertices of nothing: no numbers')
      end do
   end subroutine test_vertices_of_nothing

   !> A pattern of up to four impacts near resonance, and a window about a clearance at which it may
   !! have motions.
   subroutine random_request(i, request)
      integer, intent(in) :: i
      type(zone_request_type), intent(out) :: request
      real(wp) :: r, clearance, walls(2)

      r = draw(random, 0.7_wp, 1.3_wp)
      walls(1) = draw(random, 0.5_wp, 0.8_wp)
      walls(2) = merge(walls(1), draw(random, 0.5_wp, 0.8_wp), mod(i, 3) == 0)
      request%osc = oscillator_type(draw(random, 0.005_wp, 0.1_wp), draw_log(random, 0.02_wp, &
         0.3_wp), walls)
      request%pattern = pattern_type(sides_of(patterns(draw_integer(random, 1, 4))), 1)
      clearance = draw_log(random, 0.2_wp, 3.0_wp)*gain(request%osc%xi, r)
      request%r = [r - 0.15_wp, r + 0.15_wp]
      request%clearance = clearance*[0.4_wp, 2.5_wp]
   end subroutine random_request

   !> A net that begins at a motion inside a zone leaves the zone on both lines through it, in both
   !! directions.
   subroutine test_nets()
      type(zone_request_type) :: request
      type(curve_type) :: surface
      type(condition_type), allocatable :: conditions(:)
      real(wp), allocatable :: found(:, :), values(:)
      real(wp), parameter :: at(2) = [0.55_wp, 0.45_wp]
      real(wp) :: c(n_parameters)
      integer :: i, k, n, nets, status

      nets = 0
      do i = 1, 300
         call random_request(i, request)
         call make_surface(request, surface, status)
         c = parameters_at(surface, at)
         call surface%family%motions_at(c, 6, 0, found)
         n = condition_count(surface)
         allocate (values(n), conditions(n))
         do k = 1, size(found, 2)
            call all_conditions(surface, found(:, k), c, values, conditions)
            if (.not. all(values > 0)) cycle
            nets = nets + 1
            call check_net(surface, at, found(:, k))
         end do
         deallocate (values, conditions)
      end do
      call check(nets > 5, 'nets: motions inside zones')
   end subroutine test_nets

   !> A net without room for another node, border or crossing, or without steps left, reports that
   !! it is full and keeps its contents.
   subroutine test_full_nets()
      type(zone_request_type) :: request
      type(curve_type) :: surface
      type(net_type), allocatable :: net
      type(lattice_type) :: lines
      real(wp), allocatable :: found(:, :)
      real(wp), parameter :: at(2) = [0.55_wp, 0.45_wp]
      integer :: kept(3), limit, node, status

      request%osc = oscillator_type(0.0114_wp, 0.028_wp, [0.75_wp, 0.75_wp])
      request%pattern = pattern_type(sides_of('RL'), 1)
      request%symmetric = .true.
      request%r = [0.97_wp, 1.03_wp]
      request%clearance = [40.0_wp, 60.0_wp]
      call make_surface(request, surface, status)
      call surface%family%motions_at(parameters_at(surface, at), 6, 0, found)
      call check(size(found, 2) > 0, 'full nets: a motion to begin with')
      do limit = 0, 4
         if (allocated(net)) deallocate (net)
         allocate (net)
         lines = even_lattice(3)
         ! more lines than there is room for crossings
         if (limit == 4) lines%axes(1)%at = [(node/1200.0_wp, node=0, 1200)]
         call new_net(surface, lines, net, .false.)
         if (limit == 1) net%n = size(net%follower)
         if (limit == 2) net%n_borders = size(net%borders)
         if (limit == 3) net%steps = huge(net%steps)
         kept = [net%n, net%n_borders, net%steps]
         call cover_from(net, at, found(:, 1))
         call check(net%full .eqv. limit > 0, 'full nets: they say so')
         call check((net%n == kept(1)) .eqv. any(limit == [1, 3]), 'full nets: nodes')
         call check((net%n_borders == kept(2)) .eqv. any(limit == [2, 3]), 'full nets: borders')
         call check((net%steps == kept(3)) .eqv. limit == 3, 'full nets: steps')
         call check(net%n_crossings <= size(net%crossings), 'full nets: crossings')
         if (limit /= 1) cycle
         call add_seed(net, 1, 1, found(:, 1), node)
         call check(node == 0 .and. net%n == kept(1), 'full nets: no room for a seed')
      end do
   end subroutine test_full_nets

   subroutine check_net(surface, at, unknowns)
      type(curve_type), intent(in) :: surface
      real(wp), intent(in) :: at(2), unknowns(:)
      type(net_type), save :: net, passing
      integer :: direction, i
      logical :: below, above

      call new_net(surface, even_lattice(3), net, .false.)
      call new_net(surface, even_lattice(3), passing, .false.)
      call cover_from(net, at, unknowns)
      call cover_from(passing, at, unknowns, passing=.true.)
      call check(passing%n == net%n .and. all((passing%head > 0) .eqv. (net%head > 0)) .and. &
         passing%steps < net%steps, 'nets: the same nodes in fewer steps beside a motion passed by')
      do direction = 1, 2
         below = .false.
         above = .false.
         do i = 1, net%n_borders
            associate (q => net%borders(i)%point(size(unknowns) + 1:))
               ! of this line, not of one of the lattice
               if (abs(q(3 - direction) - at(3 - direction)) > 0) cycle
               below = below .or. q(direction) < at(direction)
               above = above .or. q(direction) > at(direction)
            end associate
         end do
         call check(below .and. above, 'nets: both ways out of a zone')
      end do
   end subroutine check_net

   !> A step without evaluation of the conditions ends where it ends with evaluation; their values
   !! exist only with it.
   subroutine test_blind_steps()
      type(zone_request_type) :: request
      type(curve_type) :: surface, line
      type(place_type) :: now
      type(place_type), allocatable :: next, seeing, blind
      type(condition_type) :: none(0)
      real(wp), allocatable :: found(:, :)
      logical :: good(3)
      integer :: i, k, status, steps

      steps = 0
      do i = 1, 60
         call random_request(i, request)
         call make_surface(request, surface, status)
         call surface%family%motions_at(parameters_at(surface, middle), 6, 0, found)
         do k = 1, size(found, 2)
            call line_of(surface, start_type(found(:, k), middle), 2, line)
            call begin_walk(line, none, [found(:, k), middle(2)], [0*found(:, k), 1.0_wp], &
               0.05_wp, now, good(1))
            if (.not. good(1)) cycle
            if (allocated(next)) deallocate (next, seeing, blind)
            allocate (next, seeing, blind)
            call take_step(line, none, stride_type(), now, next, good(1))
            call take_step(line, none, stride_type(), now, seeing, good(2), blind=.false.)
            call take_step(line, none, stride_type(), now, blind, good(3), blind=.true.)
            call check(all(good .eqv. good(1)), 'blind steps: all end or none')
            if (.not. good(1)) cycle
            steps = steps + 1
            call check_close(norm2(seeing%point - next%point), 0.0_wp, 0.0_wp, 'seeing steps')
            call check_close(norm2(blind%point - next%point), 0.0_wp, 0.0_wp, 'blind steps')
            call check_close(norm2(seeing%values - next%values), 0.0_wp, 0.0_wp, &
               'seeing steps: the conditions')
            call check_close(seeing%step, next%step, 0.0_wp, 'seeing steps: the next length')
            call check_close(blind%step, blind%came, 0.0_wp, 'blind steps: the next length')
            call check(.not. allocated(blind%values), 'blind steps: no conditions')
         end do
      end do
      call check(steps > 50, 'blind steps: some end')
   end subroutine test_blind_steps

   !> A search ends when there is no room for another motion; with less room it finds the first of
   !! the motions that it finds with more.
   subroutine test_full_searches()
      type(pattern_type) :: pattern
      real(wp), parameter :: c(n_parameters) = [0.95_wp, log(30.0_wp), 0.0114_wp, 0.028_wp, &
         0.75_wp, 0.75_wp]
      real(wp) :: found(4, 20), fewer(4, 20)
      integer :: n, m, tried, tried_all, room

      pattern = pattern_type(sides_of('RL'), 1)
      n = 0
      call search_pattern(pattern, c, 60, found, n, tried_all, 0)
      call check(n > 2 .and. n < size(found, 2), 'full searches: several motions')
      do room = 0, n
         m = 0
         fewer = -1
         call search_pattern(pattern, c, 60, fewer(:, :room), m, tried, 0)
         call check(m == room, 'full searches: all room is used')
         call check_close(norm2(fewer(:, :room) - found(:, :room)), 0.0_wp, 0.0_wp, &
            'full searches: the first motions')
         call check(tried <= tried_all .and. (tried > 0 .eqv. room > 0), &
            'full searches: no guess without room')
      end do
   end subroutine test_full_searches

   !> A simulation that ends with the largest number of impacts keeps its last releases.
   subroutine test_many_impacts()
      real(wp), parameter :: few(n_parameters) = [0.9_wp, log(5.0_wp), 0.0114_wp, 0.028_wp, &
         0.75_wp, 0.61_wp], many(n_parameters) = [0.9_wp, log(1.0e-4_wp), 0.0_wp, 0.028_wp, &
         0.99_wp, 0.99_wp]
      type(release_type) :: releases(1)

      call simulate_releases(few, releases, [6, 3])
      call check(any(releases(1)%there), 'releases: after few impacts')
      call simulate_releases(many, releases, [6, 3])
      call check(any(releases(1)%there), 'releases: the last ones before the limit of impacts')
      call check(.not. releases(1)%late .and. releases(1)%cycles == 0, 'releases: and no period')
   end subroutine test_many_impacts

   !> A vertex at a motion that repeats itself after a third of the period is not a regular point of
   !! the motions of half the period. If it cannot be found from greater distances either, the
   !! loop stays as traced.
   subroutine test_other_repetitions()
      type(zone_request_type) :: request
      type(curve_type) :: surface
      type(loop_type) :: loop
      real(wp), allocatable :: points(:, :), tangents(:, :)
      integer :: i, k, n, status

      request%osc = oscillator_type(0.0114_wp, 0.028_wp, [0.75_wp, 0.7_wp])
      request%pattern = pattern_type(sides_of('RLRLRL'), 3)
      request%r = [0.9_wp, 1.1_wp]
      request%clearance = [20.0_wp, 40.0_wp]
      call make_surface(request, surface, status)
      n = surface%family%unknown_count() + 2
      loop%n = 3
      allocate (loop%points(n, 3), loop%tangents(n, 3), source=0.0_wp)
      loop%points(1:6, :) = 0.3_wp
      loop%tangents(n, :) = 1
      loop%corner = [0, 0, 0]
      do i = 1, size(surface%family%repetitions)
         loop%points(7:12, :) = spread([0.0_wp, 3.0_wp, 6.2_wp, 9.3_wp, 12.4_wp, 15.5_wp], 2, 3)
         loop%points(n, :) = [0.1_wp, 0.2_wp, 0.3_wp]
         loop%conditions = [(condition_type(repetition, i, bound=surface%family%apart), k=1, 3)]
         points = loop%points
         tangents = loop%tangents
         call move_to_repetition(surface, loop)
         call check(all(abs(loop%points - points) <= 0) .and. &
            all(abs(loop%tangents - tangents) <= 0), 'vertices that no motion is near stay')
      end do
      call check(any(2*surface%family%repetitions%shift /= 6), 'repetitions after a third')
   end subroutine test_other_repetitions

   !> Special points that account for the multipliers that cross the unit circle need no short
   !! steps: a pair crosses it at a Neimark-Sacker point, and none crosses it where a gap closes.
   subroutine test_branches()
      integer, parameter :: most = 400, work = 100
      type(zone_request_type) :: request
      type(curve_type) :: surface, line
      type(branch_type) :: branch
      real(wp), allocatable :: found(:, :)
      integer :: i, j, k, status, way, reported, passed(2), slowly(2)

      passed = 0
      slowly = 0
      do i = 1, 60
         call random_request(i, request)
         call make_surface(request, surface, status)
         surface%family%every_crossing = .true.
         surface%family%apart = 1.0e-5_wp
         call surface%family%motions_at(parameters_at(surface, middle), 6, 0, found)
         do k = 1, size(found, 2)
            call line_of(surface, start_type(found(:, k), middle), 2, line)
            do way = -1, 1, 2
               reported = 0
               call follow_branch(line, stride_type(longest=0.05_wp, turn=0.3_wp), [found(:, k), &
                  middle(2)], way, most, branch, work, reported)
               do j = 2, branch%n - 1
                  associate (points => branch%points, &
                     kind => findloc([neimark_sacker, grazing], branch%special(j)%kind, dim=1))
                     if (kind == 0) cycle
                     passed(kind) = passed(kind) + 1
                     if (norm2(points(:, j) - points(:, j - 1)) + norm2(points(:, j + 1) &
                        - points(:, j)) < 1.0e-4_wp) slowly(kind) = slowly(kind) + 1
                  end associate
               end do
            end do
         end do
      end do
      call check(all(passed > 10), 'branches: points of both kinds')
      call check(all(4*slowly < passed), 'branches: most are passed without short steps')
   end subroutine test_branches

   !> A few long steps in both directions along a line.
   subroutine walk(line, point, zeros, borders, hidden)
      type(curve_type), intent(in) :: line
      real(wp), intent(in) :: point(:)
      !> Zeros, and ends of zones, that are found on the steps; zeros where the condition has one
      !! sign at both ends of the step.
      integer, intent(inout) :: zeros, borders, hidden
      type(place_type) :: now, next
      type(condition_type) :: none(0)
      real(wp) :: along(size(point))
      logical :: good
      integer :: i, j, way

      do way = -1, 1, 2
         along = 0
         along(size(along)) = way
         call begin_walk(line, none, point, along, 0.1_wp, now, good)
         if (.not. good) return
         do i = 1, 12
            call take_step(line, none, stride_type(longest=0.2_wp, turn=1.0_wp), now, next, good)
            if (.not. good) exit
            if (next%came > 1.0e-3_wp) then
               do j = 1, size(now%values)
                  if (.not. now%values(j)*next%values(j) < 0) cycle
                  ! elsewhere its sign jumps where another multiplier crosses the unit circle
                  if (now%conditions(j)%kind == neimark_sacker .and. .not. &
                     line%family%every_crossing) cycle
                  call check_zero(line, now, next, j)
                  zeros = zeros + 1
               end do
               call check_innermost(line, now, next, borders, hidden)
            end if
            now = next
         end do
      end do
   end subroutine walk

   !> The zero of a condition that changes its sign on a step, from either end.
   subroutine check_zero(line, now, next, j)
      type(curve_type), intent(in) :: line
      type(place_type), intent(in) :: now, next
      integer, intent(in) :: j
      type(place_type) :: from, to, place, other
      type(condition_type) :: none(0)
      real(wp) :: share, share_back, scale
      logical :: good, good_back

      from = next
      from%tangent = -next%tangent
      to = now
      to%came = next%came
      call locate(line, none, now, next, j, place, share, good)
      call locate(line, none, from, to, j, other, share_back, good_back)
      call check(good .and. good_back, 'zeros: where a condition has two signs it is zero')
      if (.not. (good .and. good_back)) return
      if (now%conditions(j)%kind /= grazing) call check_close(norm2(place%point - other%point), &
         0.0_wp, 1.0e-6_wp, 'zeros: the same one from either end')
      scale = max(abs(now%values(j)), abs(next%values(j)))
      call check_close(condition_value(line, unknowns_of(line, place%point), &
         parameters_of(line, place%point), place%conditions(j)), 0.0_wp, 1.0e-9_wp*(1 + scale), &
         'zeros: of the condition')
      call check_close(place%came, dot_product(now%tangent, place%point - now%point) &
         /dot_product(now%tangent, next%point - now%point)*next%came, 1.0e-12_wp, &
         'zeros: how far along the step')
      call check_close(share*next%came, place%came, 1.0e-12_wp, 'zeros: as a share of it')
   end subroutine check_zero

   !> Where a step leaves or enters a zone: one condition is zero and all others are met.
   subroutine check_innermost(line, now, next, borders, hidden)
      type(curve_type), intent(in) :: line
      type(place_type), intent(in) :: now, next
      integer, intent(inout) :: borders, hidden
      type(place_type) :: best
      logical :: inside
      integer :: which

      inside = is_inside(now%conditions, now%values, line%active(1))
      if (inside .eqv. is_inside(next%conditions, next%values, line%active(1))) return
      call innermost_zero(line, now, next, inside, best, which)
      call check(which > 0, 'borders: a step into or out of a zone passes its end')
      if (which == 0) return
      borders = borders + 1
      if (now%values(which)*next%values(which) > 0) hidden = hidden + 1
      call check_close(best%values(which), 0.0_wp, 1.0e-8_wp, 'borders: one condition is zero')
      call check(is_inside(best%conditions, best%values + 1.0e-8_wp, line%active(1)), &
         'borders: all others are met')
   end subroutine check_innermost

end module studies_surfaces
