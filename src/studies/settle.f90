!> Vertices of a loop that are a distance from where their curve ends are moved there.
!!
!! Motions of a pattern end where they become one that repeats itself: one with the mirror symmetry
!! (the pitchfork) or of half the pattern (the flip). Among the motions that repeat themselves that
!! one is a regular point, where the map of the shorter period has a multiplier -1, and it is solved
!! for there: the motions of the pattern itself are singular at it.
module vi_settle
   use vi_curve, only: correct, curve_type
   use vi_family, only: repetition_type
   use vi_frame, only: condition_type, edge, flip, grazing, neimark_sacker, repetition, &
      zero_approach
   use vi_kinds, only: wp
   use vi_loop, only: begins, ends, loop_type
   implicit none (type, external)
   private

   public :: settle

   !> Farther than this from the vertex, another motion has been found.
   real(wp), parameter :: reach = 0.3_wp

contains

   !> Moves the vertices that are a distance from a motion that repeats itself onto that motion.
   pure subroutine settle(sheet, loop)
      type(curve_type), intent(in) :: sheet
      type(loop_type), intent(inout) :: loop
      type(curve_type), allocatable :: parents(:)
      real(wp), dimension(size(loop%points, 1)) :: point, tangent
      integer :: i, j, twin
      logical :: good

      if (.not. any(loop%conditions(:loop%n)%kind == repetition)) return
      allocate (parents(size(sheet%frame%repetitions)))
      do i = 1, size(parents)
         call make_parent(sheet, sheet%frame%repetitions(i), parents(i))
      end do
      do j = 1, loop%n
         if (loop%conditions(j)%kind /= repetition) cycle
         i = loop%conditions(j)%index
         twin = twin_of(loop, j)
         point = loop%points(:, j)
         tangent = loop%tangents(:, j)
         good = .false.
         if (.not. halves(parents(i), sheet%frame%repetitions(i))) then
            call extrapolate(sheet, loop, j, twin, point, good)
         else if (twin == j) then
            call settle_point(parents(i), sheet%frame%repetitions(i), point, tangent, good)
         else
            call settle_corner(parents(i), sheet%frame%repetitions(i), loop%conditions(twin), &
               point, good)
            ! another kind of corner, where a fold begins, say: its place along the curve is known
            ! by what it is at some distances
            if (.not. good) call extrapolate(sheet, loop, j, twin, point, good)
            if (good) call settle_point(parents(i), sheet%frame%repetitions(i), point, tangent, &
               good)
         end if
         if (.not. good) cycle
         loop%points(:, j) = point
         loop%points(:, twin) = point
         loop%tangents(:, j) = tangent
      end do
   end subroutine settle

   !> The same vertex on the other piece, if it is a corner, else itself.
   pure integer function twin_of(loop, j) result(twin)
      type(loop_type), intent(in) :: loop
      integer, intent(in) :: j

      twin = j
      if (loop%corner(j) == ends .and. (loop%closed .or. j < loop%n)) twin = modulo(j, loop%n) + 1
      if (loop%corner(j) == begins .and. (loop%closed .or. j > 1)) twin = modulo(j - 2, loop%n) + 1
   end function twin_of

   !> Whether a way to repeat oneself is one after half the period, so that a multiplier -1 of the
   !! shorter one leads to it.
   pure logical function halves(parent, way)
      type(curve_type), intent(in) :: parent
      type(repetition_type), intent(in) :: way

      halves = size(parent%frame%family%sides) == way%shift
   end function halves

   !> The sheet of the motions that repeat themselves in a way; without sides unless after half the
   !! period.
   pure subroutine make_parent(sheet, way, parent)
      type(curve_type), intent(in) :: sheet
      type(repetition_type), intent(in) :: way
      type(curve_type), intent(out) :: parent

      parent%c = sheet%c
      parent%active = sheet%active
      parent%origin = sheet%origin
      parent%scale = sheet%scale
      parent%frame%edges = sheet%frame%edges
      allocate (parent%frame%repetitions(0))
      associate (family => parent%frame%family, sides => sheet%frame%family%sides)
         if (2*way%shift /= size(sides)) then
            allocate (family%sides(0))
            return
         end if
         family%sides = sides(:way%shift)
         family%mirror = way%sign < 0
         family%cycles = sheet%frame%family%cycles
         if (.not. family%mirror) family%cycles = family%cycles/2
      end associate
   end subroutine make_parent

   !> The bifurcation in the plane across the curve through a vertex; out: the motion there, in the
   !! whole pattern, and the tangent of the curve.
   pure subroutine settle_point(parent, way, point, tangent, good)
      type(curve_type), intent(in) :: parent
      type(repetition_type), intent(in) :: way
      real(wp), intent(inout) :: point(:), tangent(:)
      logical, intent(out) :: good
      real(wp), dimension(2*way%shift + 2) :: near, normal, along

      near = half_of(parent, way, point, 1.0_wp)
      normal = half_of(parent, way, tangent, 0.0_wp)
      normal = normal/norm2(normal)
      call solve(parent, [condition_type(flip, 0)], near, good, normal, along)
      if (.not. good) return
      call make_whole(way, near, 1.0_wp, point)
      call make_whole(way, along, 0.0_wp, tangent)
      tangent = tangent/norm2(tangent)
   end subroutine settle_point

   !> The bifurcation where another condition is zero as well.
   pure subroutine settle_corner(parent, way, other, point, good)
      type(curve_type), intent(in) :: parent
      type(repetition_type), intent(in) :: way
      type(condition_type), intent(in) :: other
      real(wp), intent(inout) :: point(:)
      logical, intent(out) :: good
      real(wp) :: near(2*way%shift + 2)
      type(condition_type) :: same

      good = any(other%kind == [edge, grazing, zero_approach, neimark_sacker])
      if (.not. good) return
      same = other
      if (any(other%kind == [grazing, zero_approach]) .and. other%index > way%shift) then
         same%index = other%index - way%shift
         if (way%sign < 0) same%side = -other%side
      end if
      near = half_of(parent, way, point, 1.0_wp)
      call solve(parent, [condition_type(flip, 0), same], near, good)
      if (good) call make_whole(way, near, 1.0_wp, point)
   end subroutine settle_corner

   !> Newton's method for a motion that repeats itself, not far off.
   pure subroutine solve(parent, conditions, point, good, normal, tangent)
      type(curve_type), intent(in) :: parent
      type(condition_type), intent(in) :: conditions(:)
      real(wp), intent(inout) :: point(:)
      logical, intent(out) :: good
      real(wp), intent(in), optional :: normal(:)
      real(wp), intent(out), optional :: tangent(:)
      real(wp) :: start(size(point))
      integer :: iterations

      start = point
      call correct(parent, conditions, point, iterations, normal, tangent)
      good = iterations > 0 .and. maxval(abs(point - start)) < reach
   end subroutine solve

   !> The mean of a motion and of its image, or of their derivatives: half the impacts, and the
   !! parameters.
   pure function half_of(parent, way, point, affine) result(half)
      type(curve_type), intent(in) :: parent
      type(repetition_type), intent(in) :: way
      real(wp), intent(in) :: point(:)
      !> 1 for a motion, 0 for a derivative.
      real(wp), intent(in) :: affine
      real(wp) :: half(2*way%shift + 2)
      integer :: n

      n = size(parent%frame%family%sides)
      half(:n) = 0.5_wp*(point(:n) + way%sign*point(n + 1:2*n))
      half(n + 1:2*n) = 0.5_wp*(point(2*n + 1:3*n) + point(3*n + 1:4*n) - affine*way%phase)
      half(2*n + 1:) = point(4*n + 1:)
   end function half_of

   !> All impacts from the first half of them.
   pure subroutine make_whole(way, half, affine, point)
      type(repetition_type), intent(in) :: way
      real(wp), intent(in) :: half(:), affine
      real(wp), intent(out) :: point(:)

      associate (n => way%shift)
         point = [half(:n), way%sign*half(:n), half(n + 1:2*n), half(n + 1:2*n) &
            + affine*way%phase, half(2*n + 1:)]
      end associate
   end subroutine make_whole

   !> Where a vertex is led to by what it is at some distances, each twice the one before.
   !!
   !! The motion is a smooth function of the distance and the parameters are one of its square. The
   !! shorter the distance, the less of the equations rounding leaves: of the places that three
   !! distances in a row lead to, those that differ least are right.
   pure subroutine extrapolate(sheet, loop, vertex, twin, point, good)
      type(curve_type), intent(in) :: sheet
      type(loop_type), intent(in) :: loop
      !> Of the vertex and, if it is a corner, of the same one on the other piece.
      integer, intent(in) :: vertex, twin
      real(wp), intent(inout) :: point(:)
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
         call correct(sheet, [other], across, iterations, loop%tangents(:, vertex))
         if (iterations == 0) exit
         near(:, i) = across
         if (twin /= vertex) call correct(sheet, [other, loop%conditions(twin)], near(:, i), &
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

end module vi_settle
