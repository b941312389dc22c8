!> The loops of a zone, traced from places on its boundary.
module vi_borders
   use vi_curve, only: correct, curve_type, distance_from, tangent_at
   use vi_kinds, only: wp
   use vi_loop, only: begins, chained, loop_type, picked, reversed
   use vi_motion_family, only: condition_type, repetition
   use vi_net, only: border_type
   use vi_outline, only: zone_side
   use vi_steps, only: stride_type
   use vi_progress, only: is_stopped
   use vi_trace, only: trace_loop
   implicit none (type, external)
   private

   public :: find_border, is_on_closed_loop, is_own_way_back, trace_border

   !> Largest number of loops, and number of points after which no further loop is begun.
   integer, parameter, public :: most_loops = 400
   integer, parameter :: capacity = 150000
   !> Number of further places from which a curve that could not be closed is traced.
   integer, parameter :: most_again = 1

   !> The zones of a family in a window.
   type, public :: zone_type
      type(loop_type), allocatable :: loops(:)
      integer :: n = 0
      !> The surface of motions over the window.
      type(curve_type) :: surface
      !> Motions found in the window, steps of the net, and borders that were not traced; one more
      !! if a limit of the net was reached.
      integer :: nodes = 0, steps = 0, untraced = 0
      !> Lattice lines of constant r and of constant D.
      integer :: lines(2) = 0
      !> Points traced, including those of loops that were discarded.
      integer :: points = 0
      !> Whether a loop was traced with another distance from motions that repeat themselves.
      logical :: retraced = .false.
      !> Whether each seed is stable and admissible, inside the window, and in no closed loop.
      logical, allocatable :: open_seeds(:)
      !> Whether each seed is a motion of the family inside the window.
      logical, allocatable :: used_seeds(:)
   end type zone_type

   !> Curves that were traced and could not be closed, and how often each was traced again from
   !! another place on it.
   type, public :: open_curves_type
      type(zone_type) :: curves
      integer :: again(most_loops) = 0
   end type open_curves_type

   !> Distances at which a motion counts as one that repeats itself, relative to the first one.
   !! Where a fold begins at such a motion, rounding can spoil the equations at the first distance.
   real(wp), parameter, public :: distances(4) = [1, 3, 10, 30]

contains

   !> Traces the boundary from a place on it, unless that place already lies on a known loop.
   subroutine trace_border(border, apart, most, keep_open, zone, closed, progress, tried)
      !> The place on the boundary.
      type(border_type), intent(in) :: border
      !> Distance at which a motion counts as one that repeats itself.
      real(wp), intent(in) :: apart
      !> Largest number of points of a loop.
      integer, intent(in) :: most
      !> Whether a curve that cannot be closed is kept.
      logical, intent(in) :: keep_open
      !> In and out: a loop is added, or the border counted as untraced.
      type(zone_type), intent(inout) :: zone
      !> Whether the place lies on a closed loop.
      logical, intent(out) :: closed
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> In and out: curves that could not be closed, if they are not kept. A place on one of them
      !! that has been traced often enough is left out.
      type(open_curves_type), intent(inout), optional :: tried
      type(curve_type) :: surface
      type(loop_type) :: loop, other
      type(border_type) :: begin
      integer :: curve_at, i, loop_at
      logical :: good, stopped

      call find_border(border, zone, loop_at)
      closed = .false.
      if (loop_at > 0) closed = zone%loops(loop_at)%closed
      if (loop_at > 0) return
      if (zone%n == most_loops .or. zone%points > capacity) then
         if (keep_open) zone%untraced = zone%untraced + 1
         return
      end if
      curve_at = 0
      if (present(tried)) then
         call find_border(border, tried%curves, curve_at)
         if (curve_at > 0) then
            if (tried%again(curve_at) == most_again) return
            tried%again(curve_at) = tried%again(curve_at) + 1
         end if
      end if
      surface = zone%surface
      surface%family%apart = apart
      begin = border
      call move_apart(surface, apart, begin, good)
      if (.not. good) return
      call trace(surface, begin, most, 1, loop, progress)
      zone%points = zone%points + loop%n
      if (keep_open .and. .not. loop%closed) then
         call trace(surface, begin, most, -1, other, progress)
         zone%points = zone%points + other%n
         if (other%closed) then
            loop = other
         else
            ! one curve in one direction: the first point is on both
            loop = chained(reversed(picked(other, [(i, i=2, other%n)])), loop)
         end if
      end if
      if (surface%family%jumps) loop%closed = loop%closed .and. .not. is_own_way_back(loop)
      closed = loop%closed
      if (.not. (closed .or. keep_open)) then
         if (present(tried) .and. curve_at == 0 .and. loop%n > 1) call remember(loop, tried)
         return
      end if
      stopped = is_stopped(progress)
      if (loop%n == 0 .or. stopped) then
         zone%untraced = zone%untraced + 1
         return
      end if
      ! the trace may have led from this border to a loop that is already known
      begin%point = loop%points(:, 1)
      begin%condition = loop%conditions(1)
      call find_border(begin, zone, loop_at)
      if (loop_at > 0 .and. closed) return
      zone%retraced = zone%retraced .or. apart > zone%surface%family%apart
      zone%n = zone%n + 1
      ! drop the unused room
      zone%loops(zone%n) = picked(loop, [(i, i=1, loop%n)])
      if (closed) zone%loops(zone%n)%side = zone_side(surface, loop)
   end subroutine trace_border

   !> Whether a closed curve passes one of its corners twice: where motions with rest end without a
   !! condition it may have turned round, and encloses nothing.
   pure logical function is_own_way_back(loop)
      !> The curve.
      type(loop_type), intent(in) :: loop
      !> Corners this near in the window are one.
      real(wp), parameter :: rounding = 1.0e-6_wp
      integer, allocatable :: corners(:)
      integer :: i, j, m

      corners = pack([(i, i=1, loop%n)], loop%corner(:loop%n) == begins)
      m = size(loop%points, 1) - 2
      is_own_way_back = .false.
      do i = 2, size(corners)
         do j = 1, i - 1
            is_own_way_back = is_own_way_back .or. norm2(loop%points(m + 1:, corners(i)) &
               - loop%points(m + 1:, corners(j))) < rounding
         end do
      end do
   end function is_own_way_back

   !> Adds a curve that could not be closed to those that are known.
   pure subroutine remember(loop, tried)
      !> The curve.
      type(loop_type), intent(in) :: loop
      !> In and out: with the curve, if there is room.
      type(open_curves_type), intent(inout) :: tried
      integer :: i

      associate (n => tried%curves%n)
         if (n == size(tried%curves%loops)) return
         n = n + 1
         tried%curves%loops(n) = picked(loop, [(i, i=1, loop%n)])
      end associate
   end subroutine remember

   !> Traces a boundary in one direction.
   subroutine trace(surface, border, most, way, loop, progress)
      !> The surface of motions over the window.
      type(curve_type), intent(in) :: surface
      !> The place on the boundary.
      type(border_type), intent(in) :: border
      !> Largest number of points, and the direction, as in `trace_loop`.
      integer, intent(in) :: most, way
      !> The boundary.
      type(loop_type), intent(out) :: loop
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)

      call trace_loop(surface, stride_type(longest=0.02_wp, turn=0.15_wp), border%point, &
         border%condition, most, way, loop, progress)
   end subroutine trace

   !> Moves a place at one distance from a motion that repeats itself to another distance.
   pure subroutine move_apart(surface, apart, border, good)
      !> The surface of motions over the window.
      type(curve_type), intent(in) :: surface
      !> The new distance.
      real(wp), intent(in) :: apart
      !> In and out: the place; not changed unless its condition is a repetition.
      type(border_type), intent(inout) :: border
      !> Whether it was found.
      logical, intent(out) :: good
      real(wp) :: along(size(border%point)), tangent(size(border%point))
      integer :: iterations

      good = .true.
      if (border%condition%kind /= repetition) return
      if (.not. abs(border%condition%bound - apart) > 0) return
      along = 0
      along(size(along)) = 1
      call tangent_at(surface, [border%condition], border%point, along, tangent, good)
      if (.not. good) return
      border%condition%bound = apart
      call correct(surface, [border%condition], border%point, iterations, tangent)
      good = iterations > 0
   end subroutine move_apart

   !> Whether a place on the boundary lies on a closed loop that is known.
   pure logical function is_on_closed_loop(border, zone) result(closed)
      !> The place.
      type(border_type), intent(in) :: border
      !> The loops known so far.
      type(zone_type), intent(in) :: zone
      integer :: loop_at

      call find_border(border, zone, loop_at)
      closed = .false.
      if (loop_at > 0) closed = zone%loops(loop_at)%closed
   end function is_on_closed_loop

   !> The loop that a place lies on, whichever distance it was traced with.
   pure subroutine find_border(border, zone, found)
      !> The place.
      type(border_type), intent(in) :: border
      !> The loops known so far.
      type(zone_type), intent(in) :: zone
      !> Number of the loop; 0 if none.
      integer, intent(out) :: found
      type(border_type) :: moved
      integer :: i
      logical :: good

      call find_loop(border, zone, found)
      if (found > 0 .or. border%condition%kind /= repetition .or. .not. zone%retraced) return
      do i = 1, size(distances)
         moved = border
         call move_apart(zone%surface, distances(i)*zone%surface%family%apart, moved, good)
         if (good) call find_loop(moved, zone, found)
         if (found > 0) return
      end do
   end subroutine find_border

   !> The loop that a place, or one of its images, lies on.
   pure subroutine find_loop(border, zone, found)
      !> The place.
      type(border_type), intent(in) :: border
      !> The loops known so far.
      type(zone_type), intent(in) :: zone
      !> Number of the loop; 0 if none.
      integer, intent(out) :: found
      type(border_type) :: image
      integer :: j, n

      image = border
      n = size(border%point) - 2
      do j = 0, size(zone%surface%family%images)
         if (j > 0) image%point(:n) = zone%surface%family%image_of( &
            zone%surface%family%images(j), border%point(:n))
         do found = 1, zone%n
            if (lies_on(zone%surface, image, zone%loops(found))) return
         end do
      end do
      found = 0
   end subroutine find_loop

   !> Whether a place on the boundary lies on a loop, along the same condition.
   !!
   !! With rests, stops or friction two conditions can be zero along one curve, as where friction
   !! that changes its direction begins to stick: there a stick of no duration would begin, too.
   !! Then the curve through the place decides alone.
   pure logical function lies_on(surface, border, loop)
      !> The surface of motions over the window.
      type(curve_type), intent(in) :: surface
      !> The place.
      type(border_type), intent(in) :: border
      !> The loop.
      type(loop_type), intent(in) :: loop
      real(wp), dimension(size(border%point)) :: chord, offset
      real(wp) :: apart, share, length
      integer :: i, next
      logical :: alike

      lies_on = .false.
      do i = 1, merge(loop%n, loop%n - 1, loop%closed)
         alike = border%condition%kind == loop%conditions(i)%kind
         if (.not. alike .and. (.not. surface%family%jumps .or. any([border%condition%kind, &
            loop%conditions(i)%kind] == repetition))) cycle
         next = merge(1, i + 1, i == loop%n)
         offset = border%point - loop%points(:, i)
         call surface%family%wrap_phases(offset)
         chord = loop%points(:, next) - loop%points(:, i)
         call surface%family%wrap_phases(chord)
         length = norm2(chord)
         if (.not. length > 0) cycle
         share = dot_product(offset, chord)/length**2
         if (share < -0.01_wp .or. share > 1.01_wp) cycle
         lies_on = norm2(offset - share*chord) < 0.1_wp*length + 1.0e-6_wp
         if (.not. lies_on) cycle
         ! the boundary of a narrow hole or the other side of a narrow tongue is also this near. A
         ! repetition is not tested further: its distance differs from loop to loop
         if (loop%conditions(i)%kind == repetition) return
         apart = distance_from(surface, [loop%conditions(i)], loop%points(:, i) + share*chord, &
            chord/length, border%point)
         lies_on = apart < 1.0e-5_wp .or. (alike .and. apart >= huge(apart))
         if (lies_on) return
      end do
   end function lies_on

end module vi_borders
