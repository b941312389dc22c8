!> Laws of zone boundaries: displaced with the parameters, traced with less memory, mirrored.
module studies_boundaries
   use checks, only: check, check_close
   use vi_boundary_shift, only: shift_boundary, shift_found, shift_types
   use vi_condition_names, only: condition_name
   use vi_kinds, only: wp
   use vi_loop, only: ends, loop_type
   use vi_motion_family, only: condition_type, edge, grazing, repetition, zero_approach
   use vi_orbit, only: by_xi
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_repetition_vertices, only: move_to_repetition
   use vi_status, only: stat
   use vi_steps, only: stride_type
   use vi_trace, only: trace_loop
   use vi_zone, only: find_zone, zone_type
   use vi_zone_request, only: zone_request_type
   implicit none (type, external)
   private

   public :: test_boundaries

contains

   subroutine test_boundaries()
      type(zone_request_type) :: requests(6)
      type(zone_type) :: zone
      real(wp), allocatable :: none(:, :)
      integer :: i, j, status, displaced(size(shift_types)), corners

      requests(1) = request_of([1, -1], .true., [0.9_wp, 1.1_wp], [10.0_wp, 60.0_wp], 0.75_wp)
      requests(2) = request_of([1, -1], .false., [0.9_wp, 1.1_wp], [10.0_wp, 60.0_wp], 0.75_wp)
      requests(3) = request_of([1, 1, -1], .false., [0.9_wp, 1.1_wp], [10.0_wp, 60.0_wp], 0.7_wp)
      requests(4) = request_of([1, 1, -1, -1], .false., [0.3_wp, 0.5_wp], [0.3_wp, 60.0_wp], &
         0.25_wp)
      requests(5) = request_of([1, -1], .false., [0.15_wp, 0.3_wp], [0.3_wp, 60.0_wp], 0.25_wp)
      requests(6) = zone_request_type(oscillator_type(0.0188_wp, 0.42728_wp, [0.8054_wp, &
         0.9253_wp]), pattern_type([2, -1], 1), .false., [0.82_wp, 0.88_wp], [7.0_wp, 12.0_wp], &
         33, 6)
      displaced = 0
      corners = 0
      do i = 1, size(requests)
         allocate (none(2 + 2*size(requests(i)%pattern%sides), 0))
         call find_zone(requests(i), none, zone, status)
         deallocate (none)
         call check(zone%n > 0, 'boundaries: there are zones')
         do j = 1, zone%n
            call check_room(zone, zone%loops(j))
            call check_displaced(requests(i), zone, zone%loops(j), displaced)
            if (any(i == [2, 4, 5])) call check_image(zone, zone%loops(j), corners)
         end do
         if (zone%n > 0) call check_nothing(zone, zone%loops(1))
      end do
      call check(all(displaced([1, 2, 3, 5, 6, 7]) > 0), 'boundaries: nearly all types occur')
      call check(corners > 1, 'boundaries: pitchforks end where a flight of either half touches')
   end subroutine test_boundaries

   !> A pattern in a window.
   pure function request_of(sides, symmetric, r, clearance, wall) result(request)
      integer, intent(in) :: sides(:)
      logical, intent(in) :: symmetric
      real(wp), intent(in) :: r(2), clearance(2), wall
      type(zone_request_type) :: request

      request%osc = oscillator_type(0.0114_wp, 0.028_wp, [wall, wall])
      request%pattern = pattern_type(sides, 1)
      request%symmetric = symmetric
      request%r = r
      request%clearance = clearance
      request%lines = 9
      request%guesses = 6
   end function request_of

   !> With less memory a trace ends earlier, with its arrays full, and is otherwise the same.
   subroutine check_room(zone, loop)
      type(zone_type), intent(in) :: zone
      type(loop_type), intent(in) :: loop
      type(loop_type) :: long, short
      integer :: most, from

      do from = 1, loop%n - 1, loop%n/3
         if (loop%corner(from) /= 0) cycle
         call trace_loop(zone%surface, stride_type(longest=0.02_wp, turn=0.15_wp), &
            loop%points(:, from), loop%conditions(from), loop%n/2, 1, long)
         if (long%closed) cycle
         do most = 1, min(25, long%n)
            call trace_loop(zone%surface, stride_type(longest=0.02_wp, turn=0.15_wp), &
               loop%points(:, from), loop%conditions(from), most, 1, short)
            call check(short%n == most .and. .not. short%closed, 'less room: all of it is used')
            call check(all(abs(short%points(:, :short%n) - long%points(:, :short%n)) <= 0), &
               'less room: the same vertices')
         end do
      end do
   end subroutine check_room

   !> A condition on a parameter that is constant over the window has no boundary.
   subroutine check_nothing(zone, loop)
      type(zone_type), intent(in) :: zone
      type(loop_type), intent(in) :: loop
      type(loop_type) :: traced
      integer :: way

      do way = -1, 1, 2
         call trace_loop(zone%surface, stride_type(), loop%points(:, 1), condition_type(edge, &
            by_xi, 1, bound=zone%surface%c(by_xi)), 100, way, traced)
         call check(traced%n == 0 .and. .not. traced%closed, 'no boundary of a constant')
      end do
   end subroutine check_nothing

   !> Vertices of all kinds: if no parameter changes they stay, and small changes displace them
   !! in proportion to the derivatives.
   subroutine check_displaced(request, zone, loop, displaced)
      type(zone_request_type), intent(in) :: request
      type(zone_type), intent(in) :: zone
      type(loop_type), intent(in) :: loop
      !> Vertices that were displaced in all directions, by type.
      integer, intent(inout) :: displaced(:)
      integer, parameter :: every = 11, m = 6
      real(wp), parameter :: h = 1.0e-5_wp
      real(wp), allocatable :: x(:, :), theta(:, :), places(:, :), normals(:, :), slopes(:, :), &
         shifts(:, :)
      integer, allocatable :: types(:), outcomes(:, :), status(:), kept(:)
      real(wp) :: changes(m, 1 + 2*m)
      real(wp), allocatable :: whole(:)
      integer :: j, k, n, v, compared

      n = zone%surface%family%unknown_count()
      allocate (types, source=[(findloc(shift_types, condition_name(loop%conditions(k)%kind, &
         loop%conditions(k)%index, request%symmetric, .true.), dim=1), k=1, loop%n)])
      kept = pack([(k, k=1, loop%n)], types > 0 .and. loop%corner == 0 .and. &
         loop%conditions%kind /= repetition)
      kept = kept(::every)
      types = types(kept)
      v = size(kept)
      allocate (places(2, v), normals(2, v), slopes(m, v), shifts(1 + 2*m, v), outcomes(1 + 2*m, &
         v), status(v))
      k = merge(1, size(request%pattern%sides), zone%surface%family%jumps)
      allocate (x(k, v), theta(k, v))
      do j = 1, v
         associate (point => loop%points(:, kept(j)), surface => zone%surface)
            places(:, j) = surface%origin + surface%scale*point(n + 1:)
            places(2, j) = exp(places(2, j))
            whole = surface%family%whole_of(point(:n))
            x(:, j) = whole(:size(whole)/2)
            theta(:, j) = whole(size(whole)/2 + 1:)
         end associate
      end do
      changes = spread([1.0_wp, 1.0_wp, request%osc%xi, request%osc%mu, &
         request%osc%restitution], 2, 1 + 2*m)
      do k = 1, m
         changes(k, 2*k) = merge(exp(h), changes(k, 1) + h, k <= 2)
         changes(k, 2*k + 1) = merge(exp(-h), changes(k, 1) - h, k <= 2)
      end do
      call shift_boundary(request, types, 0*types, places, x, theta, changes, 1, normals, slopes, &
         shifts, outcomes, status)
      compared = 0
      do j = 1, v
         call check(status(j) == stat%ok, 'displaced: a vertex')
         if (status(j) /= stat%ok) cycle
         call check(outcomes(1, j) == shift_found, 'displaced: it is found without a change')
         ! near a corner another condition can fail after a change, or the motion no longer exists
         if (.not. all(outcomes(:, j) == shift_found)) cycle
         displaced(types(j)) = displaced(types(j)) + 1
         call check_close(norm2(normals(:, j)/zone%surface%scale), 1.0_wp, 1.0e-12_wp, &
            'displaced: a unit normal')
         call check_close(shifts(1, j), 0.0_wp, 1.0e-9_wp, 'displaced: not without a change')
         do k = 1, m
            ! near the end of a fold even these changes are not small
            if (abs(shifts(2*k, j) + shifts(2*k + 1, j)) > 0.1_wp*h*(1 + norm2(slopes(:, j)))) cycle
            compared = compared + 1
            call check_close(shifts(2*k, j) - shifts(2*k + 1, j), 2*h*slopes(k, j), &
               5.0e-2_wp*h*(1 + norm2(slopes(:, j))), 'displaced: in proportion to derivatives')
         end do
      end do
      call check(compared >= 5*count(all(outcomes == shift_found, 1)), &
         'displaced: nearly all in proportion')
   end subroutine check_displaced

   !> The mirror image of a boundary, traced along the other half of its motions, is moved onto the
   !! symmetric motions in the same way as the boundary itself.
   subroutine check_image(zone, loop, corners)
      type(zone_type), intent(in) :: zone
      type(loop_type), intent(in) :: loop
      !> Corners where a flight of the second half touches.
      integer, intent(inout) :: corners
      type(loop_type) :: moved, image
      integer :: k, n, twin

      n = zone%surface%family%unknown_count()
      moved = loop
      image = loop
      associate (family => zone%surface%family, way => zone%surface%family%repetitions(1))
         do k = 1, loop%n
            image%points(:n, k) = family%image_of(way, loop%points(:n, k))
            image%tangents(:n, k) = family%image_of(way, loop%points(:n, k) &
               + loop%tangents(:n, k)) - image%points(:n, k)
            associate (c => image%conditions(k))
               if (all(c%kind /= [grazing, zero_approach])) cycle
               c%index = modulo(c%index - 1 - way%shift, n/2) + 1
               c%side = -c%side
            end associate
         end do
         call move_to_repetition(zone%surface, moved)
         call move_to_repetition(zone%surface, image)
         do k = 1, loop%n
            if (loop%conditions(k)%kind /= repetition) cycle
            call check_close(norm2(image%points(n + 1:, k) - moved%points(n + 1:, k)), 0.0_wp, &
               1.0e-8_wp, 'images: the same place')
            call check_close(norm2(image%points(:n, k) - family%image_of(way, &
               moved%points(:n, k))), 0.0_wp, 1.0e-7_wp, 'images: the image of the motion')
            if (loop%conditions(k)%index == 1) call check_close(norm2(image%points(:n, k) &
               - moved%points(:n, k)), 0.0_wp, 1.0e-7_wp, 'images: a motion that is its own image')
            if (loop%corner(k) == 0) cycle
            twin = modulo(merge(k, k - 2, loop%corner(k) == ends), loop%n) + 1
            call check(all(abs(moved%points(:, twin) - moved%points(:, k)) <= 0), &
               'images: a corner is moved as one')
            if (loop%conditions(twin)%kind == grazing) corners = corners + 1
         end do
      end associate
   end subroutine check_image

end module studies_boundaries
