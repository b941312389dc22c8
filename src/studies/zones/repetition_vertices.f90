!> Motions near those that repeat themselves within the period of their pattern.
!!
!! The vertices of a loop that lie at a small distance from the bifurcation are moved onto it, and
!! motions of the pattern are found from the bifurcation.
!!
!! The motions of a pattern end where they become a motion that repeats itself: one with the mirror
!! symmetry (the pitchfork) or of half the pattern (the flip). The equations of the pattern itself
!! are singular there. In the family of the motions that repeat themselves it is a regular point,
!! where the map of the shorter period has a multiplier -1, so it is computed in that family.
module vi_repetition_vertices
   use vi_curve, only: correct, curve_type, equations, point_size
   use vi_family, only: repetition_type
   use vi_kinds, only: wp
   use vi_linear, only: eliminate, most
   use vi_loop, only: begins, ends, loop_type
   use vi_motion_family, only: condition_type, edge, flip, grazing, neimark_sacker, &
      repetition, zero_approach
   implicit none (type, external)
   private

   public :: leave_repetition, move_to_repetition

   !> A motion that is farther than this from the vertex counts as another one.
   real(wp), parameter :: reach = 0.3_wp

contains

   !> A motion of a pattern, on a line, near a bifurcation at which such motions begin: one that
   !! repeats itself after half the impacts, where a multiplier of that half is -1.
   pure subroutine leave_repetition(line, which, half, at, point, good)
      !> The line, of motions of the pattern.
      type(curve_type), intent(in) :: line
      !> Number of the repetition.
      integer, intent(in) :: which
      !> Unknowns of the motion at the bifurcation: those of the first half of the impacts.
      real(wp), intent(in) :: half(:)
      !> Its place on the line.
      real(wp), intent(in) :: at
      !> The motion, and its place on the line.
      real(wp), intent(out) :: point(:)
      !> Whether it was found.
      logical, intent(out) :: good
      !> Distances from the motion that repeats itself, over the least one that counts as another.
      integer, parameter :: distances(2) = [3, 20]
      real(wp) :: a(most, most), b(2, most), away(size(point) - 1), start(size(point)), unused
      integer :: i, j, n, iterations
      type(condition_type) :: none(0)

      n = line%family%unknown_count()
      associate (way => line%family%repetitions(which), h => size(half)/2)
         start(:n) = [half(:h), way%sign*half(:h), half(h + 1:), half(h + 1:) + way%phase]
         start(n + 1) = at
         ! the vector that the singular equations of the motion map to 0, by bordered equations
         call equations(line, none, start, b, a)
         a(n + 1, :n) = [(cos(1.7_wp*i), i=1, n)]
         a(:n, n + 1) = [(sin(2.3_wp*i), i=1, n)]
         a(n + 1, n + 1) = 0
         b(:, :n) = 0
         b(:, n + 1) = 1
         call eliminate(n + 1, a, b, good, unused)
         if (.not. good) return
         away = b(1, :n)
         away = line%family%image_of(way, start(:n) + away) - (start(:n) + away)
         good = norm2(away) > 0 .and. all(abs(away) <= huge(1.0_wp))
         if (.not. good) return
         away = away/norm2(away)
         do j = 1, size(distances)
            associate (distance => distances(j)*line%family%apart)
               point = start
               point(:n) = point(:n) + 0.5_wp*distance*away
               call correct(line, [condition_type(repetition, which, bound=distance)], point, &
                  iterations)
               good = iterations > 0 .and. norm2(point(:n) - start(:n)) < 2*distance
            end associate
            if (good) return
         end do
      end associate
   end subroutine leave_repetition

   !> Moves the vertices at the distance `apart` from a motion that repeats itself onto that motion.
   subroutine move_to_repetition(surface, loop)
      !> The surface of motions over the window.
      type(curve_type), intent(in) :: surface
      !> In: as traced. Out: with moved vertices and tangents.
      type(loop_type), intent(inout) :: loop
      type(curve_type), allocatable :: parents(:)
      real(wp), dimension(size(loop%points, 1)) :: point, tangent
      integer :: i, j, twin
      logical :: good

      allocate (parents(size(surface%family%repetitions)))
      do i = 1, size(parents)
         associate (way => surface%family%repetitions(i))
            if (.not. way%halves) cycle
            parents(i) = surface
            call parents(i)%family%halve(way)
         end associate
      end do
      do j = 1, loop%n
         if (loop%conditions(j)%kind /= repetition) cycle
         i = loop%conditions(j)%index
         twin = twin_of(loop, j)
         point = loop%points(:, j)
         tangent = loop%tangents(:, j)
         good = .false.
         if (.not. allocated(parents(i)%family)) then
            call extrapolate(surface, loop, j, twin, point, good)
         else if (twin == j) then
            call move_point(parents(i), surface%family%repetitions(i), point, tangent, good)
         else
            call move_corner(parents(i), surface%family%repetitions(i), loop%conditions(twin), &
               point, good)
            ! another kind of corner, for example where a fold begins: its place along the curve is
            ! extrapolated from those at some distances
            if (.not. good) call extrapolate(surface, loop, j, twin, point, good)
            if (good) call move_point(parents(i), surface%family%repetitions(i), point, tangent, &
               good)
         end if
         if (.not. good) cycle
         loop%points(:, j) = point
         loop%points(:, twin) = point
         loop%tangents(:, j) = tangent
      end do
   end subroutine move_to_repetition

   !> The number of the same vertex on the other piece, if it is a corner, otherwise its own number.
   pure integer function twin_of(loop, j) result(twin)
      !> The loop.
      type(loop_type), intent(in) :: loop
      !> Number of the vertex.
      integer, intent(in) :: j

      twin = j
      if (loop%corner(j) == ends .and. (loop%closed .or. j < loop%n)) twin = modulo(j, loop%n) + 1
      if (loop%corner(j) == begins .and. (loop%closed .or. j > 1)) twin = modulo(j - 2, loop%n) + 1
   end function twin_of

   !> The bifurcation in the plane through a vertex orthogonal to the curve.
   pure subroutine move_point(parent, way, point, tangent, good)
      !> The surface of the motions that repeat themselves.
      type(curve_type), intent(in) :: parent
      !> The repetition.
      type(repetition_type), intent(in) :: way
      !> In: the vertex. Out: the motion at the bifurcation, with all impacts of the pattern, and
      !! the unit tangent of the curve.
      real(wp), intent(inout) :: point(:), tangent(:)
      !> Whether it was found.
      logical, intent(out) :: good
      real(wp), allocatable :: near(:), normal(:), along(:)

      allocate (near, source=half_of(parent, way, point, 1.0_wp))
      allocate (normal, source=half_of(parent, way, tangent, 0.0_wp))
      normal = normal/norm2(normal)
      allocate (along(size(near)))
      call solve(parent, [condition_type(flip, 0)], near, good, normal, along)
      if (.not. good) return
      call make_whole(way, near, 1.0_wp, point)
      call make_whole(way, along, 0.0_wp, tangent)
      tangent = tangent/norm2(tangent)
   end subroutine move_point

   !> The point of the bifurcation at which another condition is zero as well.
   pure subroutine move_corner(parent, way, other, point, good)
      !> The surface of the motions that repeat themselves.
      type(curve_type), intent(in) :: parent
      !> The repetition.
      type(repetition_type), intent(in) :: way
      !> The other condition.
      type(condition_type), intent(in) :: other
      !> In: the vertex. Out: the motion, with all impacts of the pattern.
      real(wp), intent(inout) :: point(:)
      !> Whether it was found.
      logical, intent(out) :: good
      real(wp), allocatable :: near(:)
      type(condition_type) :: same

      good = any(other%kind == [edge, grazing, zero_approach, neimark_sacker])
      if (.not. good) return
      same = other
      if (any(other%kind == [grazing, zero_approach]) .and. other%index > way%shift) then
         same%index = other%index - way%shift
         if (way%sign < 0) same%side = parent%family%image_of_side(other%side)
      end if
      allocate (near, source=half_of(parent, way, point, 1.0_wp))
      call solve(parent, [condition_type(flip, 0), same], near, good)
      if (good) call make_whole(way, near, 1.0_wp, point)
   end subroutine move_corner

   !> Newton's method for a motion that repeats itself, near a given one.
   pure subroutine solve(parent, conditions, point, good, normal, tangent)
      !> The surface of the motions that repeat themselves.
      type(curve_type), intent(in) :: parent
      !> Conditions that are to be zero.
      type(condition_type), intent(in) :: conditions(:)
      !> In: a guess. Out: the motion, if `good`.
      real(wp), intent(inout) :: point(:)
      !> Whether it was found near the guess.
      logical, intent(out) :: good
      !> Unit normal of the plane in which the motion is to lie.
      real(wp), intent(in), optional :: normal(:)
      !> Unit tangent of the curve there.
      real(wp), intent(out), optional :: tangent(:)
      real(wp) :: start(size(point))
      integer :: iterations

      start = point
      call correct(parent, conditions, point, iterations, normal, tangent)
      good = iterations > 0 .and. maxval(abs(point - start)) < reach
   end subroutine solve

   !> The mean of a motion and its image, or of their derivatives: the first half of the impacts,
   !! and the parameters.
   pure function half_of(parent, way, point, affine) result(half)
      !> The surface of the motions that repeat themselves.
      type(curve_type), intent(in) :: parent
      !> The repetition.
      type(repetition_type), intent(in) :: way
      !> The motion, or a derivative of it, with all impacts.
      real(wp), intent(in) :: point(:)
      !> 1 for a motion, 0 for a derivative.
      real(wp), intent(in) :: affine
      real(wp) :: half(point_size(parent))
      integer :: n, free

      n = way%shift
      free = size(half) - 2*n - 2
      half(:n) = 0.5_wp*(point(:n) + way%sign*point(n + 1:2*n))
      half(n + 1:2*n) = 0.5_wp*(point(2*n + 1:3*n) + point(3*n + 1:4*n) - affine*way%phase)
      ! an image has the opposite displacements of free modes, but for the first ones
      half(2*n + 1:2*n + free) = point(4*n + 1:4*n + free)
      half(2*n + free + 1:) = point(size(point) - 1:)
   end function half_of

   !> All impacts of a motion that repeats itself from the first half of them.
   pure subroutine make_whole(way, half, affine, point)
      !> The repetition.
      type(repetition_type), intent(in) :: way
      !> The first half of the impacts, and the parameters; 1 for a motion, 0 for a derivative.
      real(wp), intent(in) :: half(:), affine
      !> The motion or derivative, with all impacts.
      real(wp), intent(out) :: point(:)

      associate (n => way%shift, free => size(half) - 2*way%shift - 2)
         point(:4*n) = [half(:n), way%sign*half(:n), half(n + 1:2*n), half(n + 1:2*n) &
            + affine*way%phase]
         point(4*n + 1:) = 0
         point(4*n + 1:4*n + free) = half(2*n + 1:2*n + free)
         point(size(point) - 1:) = half(size(half) - 1:)
      end associate
   end subroutine make_whole

   !> Extrapolates a vertex to distance 0 from its places at some distances, each twice the previous
   !! one.
   !!
   !! The unknowns are a smooth function of the distance, and the parameters are one of its square.
   !! The shorter the distance, the more rounding affects the equations. Every three successive
   !! distances give one estimate; the one that differs least from the previous estimate is taken.
   pure subroutine extrapolate(surface, loop, vertex, twin, point, good)
      !> The surface of the pattern.
      type(curve_type), intent(in) :: surface
      !> The loop as traced.
      type(loop_type), intent(in) :: loop
      !> Number of the vertex and, if it is a corner, of the same one on the other piece, otherwise
      !! the same number.
      integer, intent(in) :: vertex, twin
      !> Out: the extrapolated vertex, if `good`.
      real(wp), intent(inout) :: point(:)
      !> Whether there is an estimate.
      logical, intent(out) :: good
      integer, parameter :: most_distances = 8
      real(wp), parameter :: weights(3) = [8, -6, 1]/3.0_wp
      real(wp), parameter :: weights_of_squares(3) = [64, -20, 1]/45.0_wp
      real(wp), dimension(size(point)) :: across, limit
      real(wp) :: near(size(point), most_distances), before(2), least, change
      type(condition_type) :: other
      integer :: i, m, iterations
      logical :: known(most_distances)

      m = size(point) - 2
      other = loop%conditions(vertex)
      known = .false.
      across = loop%points(:, vertex)
      do i = 1, most_distances
         ! across the curve, then along it
         call correct(surface, [other], across, iterations, loop%tangents(:, vertex))
         if (iterations == 0) exit
         near(:, i) = across
         if (twin /= vertex) call correct(surface, [other, loop%conditions(twin)], near(:, i), &
            iterations)
         known(i) = iterations > 0
         if (other%bound > 0.25_wp) exit
         other%bound = 2*other%bound
      end do
      good = .false.
      least = huge(least)
      before = 0
      do i = 1, most_distances - 2
         if (.not. all(known(i:i + 2))) cycle
         limit(:m) = matmul(near(:m, i:i + 2), weights)
         limit(m + 1:) = matmul(near(m + 1:, i:i + 2), weights_of_squares)
         change = norm2(limit(m + 1:) - before)
         if (.not. good .or. change < least) point = limit
         if (good) least = min(least, change)
         good = .true.
         before = limit(m + 1:)
      end do
   end subroutine extrapolate

end module vi_repetition_vertices
