!> Joins the loose ends of boundaries that could not be closed.
module vi_join
   use vi_borders, only: zone_type
   use vi_frame, only: condition_type, frame_type, joint, wrap_phases
   use vi_kinds, only: wp
   use vi_loop, only: begins, chained, ends, loop_type, picked, reversed
   implicit none (type, external)
   private

   public :: join_loose_ends

   !> Loose ends are joined if they are this near in the window, whose sides are 1 (of r and log D),
   !! and their motions are as near as those on both sides of a fold there.
   real(wp), parameter :: join_distance = 1.0e-4_wp, join_motions = 5*sqrt(join_distance)

contains

   !> Joins pairs of loose ends, the nearest ones first, until no two are near each other.
   pure subroutine join_loose_ends(zone)
      !> In and out: the loops; joined ones are merged or closed.
      type(zone_type), intent(inout) :: zone
      integer :: i, j, a, b, best(2), side(2)
      real(wp) :: nearest, distance

      do
         nearest = join_distance
         best = 0
         do i = 1, zone%n
            if (zone%loops(i)%closed) cycle
            do j = i, zone%n
               if (zone%loops(j)%closed) cycle
               do a = 1, 2
                  do b = 1, 2
                     if (i == j .and. a >= b) cycle
                     distance = between(zone, i, a, j, b)
                     if (distance > nearest) cycle
                     nearest = distance
                     best = [i, j]
                     side = [a, b]
                  end do
               end do
            end do
         end do
         if (best(1) == 0) return
         call join(zone, best, side)
      end do
   end subroutine join_loose_ends

   !> Distance of two loose ends in the window; huge if their motions differ, or if both belong to
   !! one very short curve.
   pure real(wp) function between(zone, i, end_of_i, j, end_of_j) result(distance)
      !> The loops.
      type(zone_type), intent(in) :: zone
      !> The loops, and which end of each: 1 the first, 2 the last.
      integer, intent(in) :: i, end_of_i, j, end_of_j
      real(wp) :: offset(size(zone%loops(i)%points, 1))
      integer :: m

      distance = huge(distance)
      associate (a => zone%loops(i), b => zone%loops(j))
         ! a curve hardly larger than the join distance does not enclose a zone
         if (i == j) then
            m = size(offset) - 2
            offset(:2) = maxval(abs(a%points(m + 1:, :a%n) - spread(a%points(m + 1:, 1), 2, &
               a%n)), 2)
            if (.not. maxval(offset(:2)) > 10*join_distance) return
         end if
         offset = a%points(:, merge(1, a%n, end_of_i == 1)) &
            - b%points(:, merge(1, b%n, end_of_j == 1))
      end associate
      call wrap_phases(zone%surface%frame, offset)
      m = size(offset) - 2
      if (maxval(abs(offset(:m))) < join_motions) distance = norm2(offset(m + 1:))
   end function between

   !> Joins two loops, or one with itself.
   pure subroutine join(zone, which, side)
      !> In and out: the loops.
      type(zone_type), intent(inout) :: zone
      !> The loops and their ends, as in `between`.
      integer, intent(in) :: which(2), side(2)
      type(loop_type) :: whole
      integer :: k

      if (which(1) == which(2)) then
         call add_joint(zone%surface%frame, zone%loops(which(1)))
         zone%loops(which(1))%closed = .true.
         return
      end if
      whole = zone%loops(which(1))
      if (side(1) == 1) whole = reversed(whole)
      call add_joint(zone%surface%frame, whole, zone%loops(which(2)), side(2) == 2)
      zone%loops(which(1)) = whole
      do k = which(2), zone%n - 1
         zone%loops(k) = zone%loops(k + 1)
      end do
      zone%n = zone%n - 1
   end subroutine join

   !> Adds a straight piece from the last point of a curve to the first point of another curve, and
   !! that curve; without another curve, to its own first point.
   pure subroutine add_joint(frame, loop, next, turn)
      !> The family.
      type(frame_type), intent(in) :: frame
      !> In: the curve. Out: with the piece, and the other curve.
      type(loop_type), intent(inout) :: loop
      !> The other curve.
      type(loop_type), intent(in), optional :: next
      !> Whether the other curve is reversed.
      logical, intent(in), optional :: turn
      type(loop_type) :: second, between_them
      integer :: i

      ! at a corner that could not be turned, one vertex stands for both pieces
      if (loop%corner(loop%n) == begins) loop = picked(loop, [(i, i=1, loop%n - 1)])
      if (present(next)) then
         second = next
         if (turn) second = reversed(next)
         if (second%corner(1) == ends) second = picked(second, [(i, i=2, second%n)])
      else
         if (loop%corner(1) == ends) loop = picked(loop, [(i, i=2, loop%n)])
         second = loop
      end if
      loop%corner(loop%n) = ends
      second%corner(1) = begins
      between_them = chained(picked(loop, [loop%n]), picked(second, [1]))
      between_them%conditions = condition_type(joint)
      between_them%corner = [begins, ends]
      associate (across => between_them%tangents)
         across(:, 1) = between_them%points(:, 2) - between_them%points(:, 1)
         call wrap_phases(frame, across(:, 1))
         if (norm2(across(:, 1)) > 0) across(:, 1) = across(:, 1)/norm2(across(:, 1))
         across(:, 2) = across(:, 1)
      end associate
      if (present(next)) then
         loop = chained(chained(loop, between_them), second)
      else
         loop%corner(1) = begins
         loop = chained(loop, between_them)
      end if
   end subroutine add_joint

end module vi_join
