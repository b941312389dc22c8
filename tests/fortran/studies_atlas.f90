!> Rings compared with the circle that they follow; atlases for any threads; laws of surveys.
module studies_atlas
   use checks, only: check
   use vi_atlas, only: atlas_request_type, atlas_type, find_atlas, outcomes_of
   use vi_kinds, only: wp
   use vi_oscillator, only: gain, oscillator_type
   use vi_pattern, only: pattern_type
   use vi_rings, only: dense_ring, winding
   use vi_zone_request, only: zone_request_type
   use vi_survey, only: attractor_type, limits_type, settle_from, survey, survey_work
   use vi_survey_outcome, only: beyond, chaotic, count_outcomes, no_impacts, not_settled, periodic
   use vi_zone, only: find_zone, release_type, simulate_nodes, zone_type, zone_work
   implicit none (type, external)
   private

   public :: test_atlas, test_limits, test_outcomes, test_rings, &
      test_bent_sides, test_shared_simulations

contains

   !> A circle in the plane (r, log D) from a few vertices, in either direction: a zone, and a hole.
   subroutine test_rings()
      integer, parameter :: m = 24
      real(wp), parameter :: pi = acos(-1.0_wp), radius = 0.3_wp
      real(wp) :: vertices(5, m), points(2, 4), distance(2)
      real(wp), allocatable :: ring(:, :)
      integer :: i, way

      points = reshape([1.0_wp, 10.0_wp, 1.0_wp + 0.29_wp, 10.0_wp, 1.0_wp + 0.31_wp, 10.0_wp, &
         1.0_wp, 10*exp(0.31_wp)], [2, 4])
      do way = -1, 1, 2
         do i = 1, m
            associate (angle => way*2*pi*(i - 0.5_wp)/m)
               vertices(:, i) = [1 + radius*cos(angle), 10*exp(radius*sin(angle)), &
                  -way*sin(angle), way*cos(angle), 2*pi*radius/m]
            end associate
         end do
         ! the window has side 1
         call dense_ring(vertices, [0.5_wp, 1.5_wp], 10*exp([-0.5_wp, 0.5_wp]), way, ring)
         do i = 1, size(ring, 2)
            distance = [ring(1, i) - 1, log(ring(2, i)/10)]
            call check(abs(norm2(distance) - radius) < 1.0e-4_wp*radius, 'a ring follows its curve')
         end do
         call check(size(ring, 2) > 10*m, 'a ring is dense')
         call check(all(winding(ring, points) == [1, 1, 0, 0]), 'a zone is inside its ring')
         call dense_ring(vertices, [0.5_wp, 1.5_wp], 10*exp([-0.5_wp, 0.5_wp]), -way, ring)
         call check(all(winding(ring, points) == [-1, -1, 0, 0]), 'a hole goes round the other way')
      end do
      call check(all(winding(ring(:, :0), points) == 0), 'a ring without vertices encloses nothing')
   end subroutine test_rings

   !> A rectangle with one side that leaves or reaches a corner at an angle: the ring passes through
   !! all points of its cubic, in whichever direction it bends.
   subroutine test_bent_sides()
      real(wp), parameter :: r(2) = [0.5_wp, 1.5_wp], clearance(2) = [10.0_wp, 20.0_wp]
      real(wp), parameter :: corners(2, 4) = reshape([0.2_wp, 0.2_wp, 0.8_wp, 0.2_wp, 0.8_wp, &
         0.8_wp, 0.2_wp, 0.8_wp], [2, 4])
      real(wp) :: vertices(5, 8), chord(2), turned(2), place(2), scale(2), low(2), t
      real(wp), allocatable :: ring(:, :)
      integer :: side, axis, way, at_end, bent, k

      low = [r(1), log(clearance(1))]
      scale = [r(2), log(clearance(2))] - low
      do bent = 0, 31
         side = mod(bent, 4) + 1
         axis = 1 + mod(bent/4, 2)
         way = 1 - 2*mod(bent/8, 2)
         at_end = bent/16
         do k = 1, 4
            associate (next => modulo(k, 4) + 1)
               chord = corners(:, next) - corners(:, k)
               ! each corner as the start of a side and as the end of the previous one
               vertices(:, 2*k - 1) = [corners(:, k), chord/norm2(chord), norm2(chord)]
               vertices(:, 2*k) = [corners(:, next), chord/norm2(chord), 0.0_wp]
            end associate
         end do
         associate (tangent => vertices(2 + axis, 2*side - 1 + at_end))
            tangent = tangent + 0.3_wp*way
         end associate
         associate (first => vertices(:, 2*side - 1), last => vertices(:, 2*side))
            chord = last(:2) - first(:2)
            turned = first(5)*(first(3:4) + last(3:4)) - 2*chord
            do k = 1, 8
               vertices(:4, k) = [low + scale*vertices(:2, k), scale*vertices(3:4, k)]
               vertices(2, k) = exp(vertices(2, k))
            end do
            call dense_ring(vertices, r, clearance, 0, ring)
            do k = 0, 70
               t = k/70.0_wp
               ! the deviation from the straight side, at its start or at its end
               place = t*chord + merge(t**2*(t - 1), t*(1 - t)**2, at_end == 1)*turned
               place = [first(1), log(first(2))] + scale*place
               call check(passes(ring, [place(1), exp(place(2))], r, clearance), &
                  'a ring follows its cubics')
            end do
         end associate
      end do
   end subroutine test_bent_sides

   !> Whether a point lies on a polygon, within twice its accuracy.
   pure logical function passes(ring, point, r, clearance)
      !> (2, n), (2): r, D
      real(wp), intent(in) :: ring(:, :), point(2)
      !> The window.
      real(wp), intent(in) :: r(2), clearance(2)

      passes = distance(ring, point, [r(2) - r(1), log(clearance(2)/clearance(1))]) < 2.0e-7_wp
   end function passes

   !> Distance of a point from a polygon.
   pure real(wp) function distance(ring, point, scale)
      !> (2, n) and (2): r, D; (2): units of r and log D.
      real(wp), intent(in) :: ring(:, :), point(2), scale(2)
      real(wp) :: chord(2), offset(2), share
      integer :: i, next

      distance = huge(1.0_wp)
      do i = 1, size(ring, 2)
         next = merge(1, i + 1, i == size(ring, 2))
         chord = [ring(1, next) - ring(1, i), log(ring(2, next)/ring(2, i))]/scale
         offset = [point(1) - ring(1, i), log(point(2)/ring(2, i))]/scale
         share = dot_product(offset, chord)/max(tiny(1.0_wp), dot_product(chord, chord))
         distance = min(distance, norm2(offset - max(0.0_wp, min(1.0_wp, share))*chord))
      end do
   end function distance

   !> The motions on which simulations settle lie in the zones, for any number of threads.
   subroutine test_atlas()
      type(atlas_request_type) :: request
      type(atlas_type) :: one, two
      character(80) :: told
      integer :: progress(3), i, j

      request = atlas_request_type(oscillator_type(0.0114_wp, 0.028_wp, [0.75_wp, 0.75_wp]), &
         [1.0_wp, 1.1_wp], [20.0_wp, 60.0_wp], max_impacts=3, survey=30, guesses=6)
      progress = 0
      call find_atlas(request, one, progress)
      call check(progress(1) == survey_work*request%survey + zone_work*size(one%families) .and. &
         progress(2) == progress(1), 'all points and sheets are counted')
      call check(size(one%attractors) > 10 .and. all(one%explained), 'attractors lie in zones')
      call check(size(one%families) == 3, 'up to three impacts: RL of two kinds, RRL')
      call check(one%families(1)%symmetric .and. .not. one%families(2)%symmetric, &
         'symmetric motions first')
      request%threads = 2
      call find_atlas(request, two)
      call check(size(one%attractors) == size(two%attractors), 'threads find the same attractors')
      do i = 1, min(size(one%attractors), size(two%attractors))
         call check(all(abs(one%attractors(i)%unknowns - two%attractors(i)%unknowns) <= 0), &
            'threads settle on the same attractors')
      end do
      do j = 1, size(one%families)
         associate (a => one%families(j)%zone, b => two%families(j)%zone)
            call check(a%n == b%n .and. a%n > 0, 'threads find the same loops')
            do i = 1, min(a%n, b%n)
               write (told, '(a, 4(1x, i0))') 'threads trace the same vertices:', j, i, &
                  a%loops(i)%n, b%loops(i)%n
               call check(a%loops(i)%n == b%loops(i)%n, trim(told))
               if (a%loops(i)%n == b%loops(i)%n) call check(all(abs(a%loops(i)%points - &
                  b%loops(i)%points) <= 0), 'to the last bit')
            end do
         end associate
      end do
      ! without search and survey there are no seeds
      request%survey = 0
      request%guesses = 0
      call find_atlas(request, two)
      call check(size(two%attractors) == 0 .and. all([(two%families(j)%zone%n == 0, j=1, 3)]), &
         'nothing comes from nothing')
      ! seeds of the survey alone lead to the zones that contain them
      request%survey = 30
      call find_atlas(request, two)
      call check(all(two%explained), 'attractors are seeds')
   end subroutine test_atlas

   !> Simulations made for one pattern with rest give the zones of another pattern to the last
   !! bit, whatever the number of threads that made them.
   subroutine test_shared_simulations()
      integer, parameter :: patterns(3, 2) = reshape([2, -1, 0, 2, -1, -1], [3, 2])
      type(zone_request_type) :: requests(2)
      type(release_type), allocatable :: one(:, :, :), two(:, :, :)
      type(zone_type) :: alone, shared
      real(wp), allocatable :: places(:, :, :)
      real(wp) :: none(8, 0)
      integer :: i, j, k, status

      do j = 1, 2
         requests(j) = zone_request_type(oscillator_type(0.0188_wp, 0.42728_wp, &
            [0.8054_wp, 0.9253_wp]), pattern_type(patterns(:j + 1, j), 1), .false., &
            [0.82_wp, 0.88_wp], [7.0_wp, 12.0_wp], 33, 6)
      end do
      call simulate_nodes(requests(1), [3, 2], 1, one, places)
      call simulate_nodes(requests(2), [3, 2], 2, two, places)
      call check(all(shape(one) == shape(two)), 'one lattice for all patterns with rest')
      call check(all(shape(places) == [2, size(one, 2), size(one, 3)]) .and. &
         all(places(1, :, :) >= 0.82_wp*(1 - 1.0e-12_wp) .and. &
         places(2, :, :) <= 12*(1 + 1.0e-12_wp)), 'nodes lie in the window')
      call check(any(one%cycles > 0), 'some simulations end in a period with rest')
      do j = 1, size(one, 3)
         do i = 1, size(one, 2)
            do k = 1, size(one, 1)
               call check(one(k, i, j)%cycles == two(k, i, j)%cycles, 'threads change no period')
               if (one(k, i, j)%cycles == 0) cycle
               associate (symbols => one(k, i, j)%symbols)
                  call check(size(symbols) <= 3 .and. abs(symbols(size(symbols))) == 2, &
                     'a period ends with a rest')
                  call check(any(symbols > 0) .and. any(symbols < 0), 'a period has both walls')
               end associate
            end do
         end do
      end do
      do j = 1, 2
         call find_zone(requests(j), none(:4 + 2*j, :), alone, status)
         if (j == 1) call find_zone(requests(j), none(:4 + 2*j, :), shared, status, releases=two)
         if (j == 2) call find_zone(requests(j), none(:4 + 2*j, :), shared, status, releases=one)
         call check(alone%n == shared%n .and. (alone%n > 0 .or. j > 1), &
            'as many loops from shared simulations')
         do i = 1, min(alone%n, shared%n)
            call check(alone%loops(i)%n == shared%loops(i)%n, &
               'as many vertices from shared simulations')
            if (alone%loops(i)%n == shared%loops(i)%n) call check(all(abs(alone%loops(i)%points &
               - shared%loops(i)%points) <= 0), 'the same vertices from shared simulations')
         end do
      end do
   end subroutine test_shared_simulations

   !> Every point of a survey is counted once, and its outcome obeys the laws of its motion.
   subroutine test_outcomes()
      real(wp), parameter :: window(2, 2) = reshape([0.8_wp, 1.2_wp, 2.0_wp, 200.0_wp], [2, 2])
      type(oscillator_type) :: osc
      type(attractor_type) :: points(60), same(60), narrow, wide
      type(atlas_request_type) :: request
      type(atlas_type) :: stopped
      integer :: counts(8), progress(3), i, n

      osc = oscillator_type(0.0114_wp, 0.028_wp, [0.75_wp, 0.61_wp])
      call survey(osc, window(:, 1), window(:, 2), 400, limits_type(2, 1, 10000000), 1, points)
      counts = count_outcomes(points%outcome)
      call check(sum(counts) == size(points), 'every point is counted once')
      call check(counts(periodic) == count(points%found), 'periodic: within the limits')
      call check(all(counts([periodic, beyond, no_impacts, chaotic]) > 0), &
         'outcomes are told apart')
      do i = 1, size(points)
         associate (point => points(i))
            if (point%outcome == no_impacts) call check(point%clearance > 2*gain(osc%xi, point%r), &
               'without impacts only where D > 2A')
            if (point%outcome == periodic) call check(size(point%symbols) <= 2 .and. &
               point%cycles == 1, 'within the limits')
            if (point%outcome == beyond) call check(size(point%symbols) > 2 .or. &
               point%cycles > 1, 'beyond the limits')
         end associate
      end do
      call survey(osc, window(:, 1), window(:, 2), 400, limits_type(2, 1, 10000000), 2, same)
      call check(all(same%outcome == points%outcome), 'outcomes do not depend on threads')
      ! motions beyond the limits are the same within wider ones. A survey examines states again
      ! that have not settled, after a simulation whose length depends on the limits: rounding
      ! then decides the state of a transient trajectory. So each state is examined once here
      n = 0
      do i = 1, size(points)
         narrow = attractor_type(r=points(i)%r, clearance=points(i)%clearance)
         wide = narrow
         call settle_from(osc, 1, 400, limits_type(2, 1, 10000000), narrow)
         if (narrow%outcome /= beyond) cycle
         if (size(narrow%symbols) > 8 .or. narrow%cycles > 4) cycle
         n = n + 1
         call settle_from(osc, 1, 400, limits_type(8, 4, 10000000), wide)
         call check(wide%outcome == periodic, 'wider limits hold what was beyond')
         if (wide%outcome /= periodic) cycle
         call check(wide%cycles == narrow%cycles .and. same_symbols(wide%symbols, narrow%symbols), &
            'as the same pattern')
      end do
      call check(n > 5, 'some are beyond the narrow limits alone')
      ! a stop ends the survey, and states that have not started are not settled
      request = atlas_request_type(osc, window(:, 1), window(:, 2), max_impacts=2, survey=60)
      progress = [0, 0, 1]
      call find_atlas(request, stopped, progress)
      counts = outcomes_of(stopped)
      call check(counts(not_settled) == 60, 'a stopped survey has settled nothing')
   end subroutine test_outcomes

   !> A motion is within limits equal to its size, and beyond those with one symbol less; also
   !! one with more symbols than the equations of a family, which the simulation alone confirms.
   subroutine test_limits()
      real(wp), parameter :: places(2, 5) = reshape([0.684420428658572_wp, 1.71679245107618_wp, &
         0.0630533507424860_wp, 0.170730469072553_wp, 1.08898080055573_wp, 5.48269317674957_wp, &
         0.636945682449190_wp, 0.436404317306424_wp, 0.387364031107183_wp, 0.720415225214458_wp], &
         [2, 5])
      integer, parameter :: many = 24
      type(oscillator_type) :: osc
      type(attractor_type) :: wide, other
      integer :: i, less, confirmed(2)

      osc = oscillator_type(0.0114_wp, 0.028_wp, [0.75_wp, 0.61_wp])
      confirmed = 0
      do i = 1, size(places, 2)
         wide = attractor_type(r=places(1, i), clearance=places(2, i))
         call settle_from(osc, 1, 400, limits_type(80, 10, 10000000), wide)
         if (wide%outcome /= periodic) cycle
         associate (kind => merge(1, 2, size(wide%symbols) > many))
            confirmed(kind) = confirmed(kind) + 1
         end associate
         do less = 0, 1
            other = attractor_type(r=places(1, i), clearance=places(2, i))
            call settle_from(osc, 1, 400, limits_type(size(wide%symbols) - less, wide%cycles, &
               10000000), other)
            call check(other%outcome == merge(beyond, periodic, less == 1), &
               'a motion is beyond limits that are less than it')
            call check(other%cycles == wide%cycles, 'cycles do not depend on limits')
            if (.not. any(other%outcome == [beyond, periodic])) cycle
            call check(same_symbols(other%symbols, wide%symbols), 'nor does the pattern')
         end do
      end do
      call check(all(confirmed > 0), 'motions with few and with many symbols')
   end subroutine test_limits

   pure logical function same_symbols(one, other)
      integer, intent(in) :: one(:), other(:)

      same_symbols = size(one) == size(other)
      if (same_symbols) same_symbols = all(one == other)
   end function same_symbols

end module studies_atlas
