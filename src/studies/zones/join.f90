!> The loose ends of boundaries that could not be closed: they are joined, or set apart in strips of
!! the window, so that the rest of the boundary closes along these.
module vi_join
   use vi_borders, only: find_border, trace_border, zone_type
   use vi_kinds, only: wp
   use vi_loop, only: begins, chained, ends, loop_type, picked, reversed
   use vi_motion_family, only: condition_type, joint, motion_family_type
   use vi_net, only: border_type
   use vi_progress, only: is_stopped
   implicit none (type, external)
   private

   public :: join_loose_ends, set_apart

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
      call zone%surface%family%wrap_phases(offset)
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
         call add_joint(zone%surface%family, zone%loops(which(1)))
         zone%loops(which(1))%closed = .true.
         return
      end if
      whole = zone%loops(which(1))
      if (side(1) == 1) whole = reversed(whole)
      call add_joint(zone%surface%family, whole, zone%loops(which(2)), side(2) == 2)
      zone%loops(which(1)) = whole
      do k = which(2), zone%n - 1
         zone%loops(k) = zone%loops(k + 1)
      end do
      zone%n = zone%n - 1
   end subroutine join

   !> Adds a straight piece from the last point of a curve to the first point of another curve, and
   !! that curve; without another curve, to its own first point.
   pure subroutine add_joint(family, loop, next, turn)
      !> The family.
      class(motion_family_type), intent(in) :: family
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
         call family%wrap_phases(across(:, 1))
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

   !> Sets loose ends apart in strips of the window, and traces the boundary again in the parts
   !! between the strips, each of which is a window of its own.
   !!
   !! In the strips the open boundary is kept as it is.
   subroutine set_apart(zone, borders, is_open, most, progress)
      !> In and out: the loops; open ones are replaced by closed ones, and by the parts that are
      !! left of them.
      type(zone_type), intent(inout) :: zone
      !> Places on the boundary, and whether each is on no closed loop.
      type(border_type), intent(in) :: borders(:)
      logical, intent(in) :: is_open(:)
      !> Largest number of points of a loop.
      integer, intent(in) :: most
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> Largest share of the window in strips, and largest number of rounds: the loose ends that
      !! are left after one come into the strips of the next.
      real(wp), parameter :: most_apart = 0.25_wp
      integer, parameter :: rounds = 4
      type(zone_type), allocatable :: before, trial
      real(wp), allocatable :: loose(:, :), bounds(:), other(:)
      real(wp) :: far(2)
      integer :: axis, i, k, m, round
      logical :: closed

      allocate (loose(2, 0))
      call add_loose_ends(zone, loose)
      if (size(loose, 2) == 0) return
      before = zone
      m = size(borders(1)%point) - 2
      associate (edges => zone%surface%edges)
         far = [((edges(2*k)%bound - zone%surface%origin(k))/zone%surface%scale(k), k=1, 2)]
      end associate
      do round = 1, rounds
         if (is_stopped(progress)) return
         axis = 1
         call parts_between(loose(1, :), far(1), bounds)
         call parts_between(loose(2, :), far(2), other)
         if (covered(other)/far(2) > covered(bounds)/far(1)) then
            axis = 2
            bounds = other
         end if
         if (covered(bounds) < (1 - most_apart)*far(axis)) return
         trial = before
         call drop_open(trial)
         trial%points = 0
         do k = 1, size(bounds), 2
            associate (surface => trial%surface, low => trial%surface%edges(2*axis - 1), &
               high => trial%surface%edges(2*axis))
               low%bound = surface%origin(axis) + surface%scale(axis)*bounds(k)
               high%bound = surface%origin(axis) + surface%scale(axis)*bounds(k + 1)
            end associate
            do i = 1, size(borders)
               if (.not. is_open(i)) cycle
               associate (at => borders(i)%point(m + axis))
                  if (at < bounds(k) .or. at > bounds(k + 1)) cycle
               end associate
               call trace_border(borders(i), trial%surface%family%apart, most, .true., trial, &
                  closed, progress)
            end do
         end do
         trial%surface%edges = before%surface%edges
         i = size(loose, 2)
         call add_loose_ends(trial, loose)
         if (size(loose, 2) == i) exit
      end do
      if (round > rounds .and. trial%n == 0) return
      zone = trial
      zone%points = zone%points + before%points
      do i = 1, before%n
         if (.not. before%loops(i)%closed) call keep_rest(before%loops(i), bounds, axis, trial, &
            zone)
      end do
   end subroutine set_apart

   !> Adds the places of the loose ends of a zone.
   pure subroutine add_loose_ends(zone, loose)
      !> The zone.
      type(zone_type), intent(in) :: zone
      !> (2, n) In and out: places in the window.
      real(wp), allocatable, intent(inout) :: loose(:, :)
      integer :: i, m

      do i = 1, zone%n
         associate (loop => zone%loops(i))
            if (loop%closed) cycle
            m = size(loop%points, 1) - 2
            loose = reshape([loose, loop%points(m + 1:, 1), loop%points(m + 1:, loop%n)], &
               [2, size(loose, 2) + 2])
         end associate
      end do
   end subroutine add_loose_ends

   !> The intervals between strips around loose ends.
   pure subroutine parts_between(loose, far, bounds)
      !> A coordinate of the loose ends, and its greatest value in the window; the least is 0.
      real(wp), intent(in) :: loose(:), far
      !> Out: where each interval begins and ends, in ascending order.
      real(wp), allocatable, intent(out) :: bounds(:)
      !> Half the width of a strip, and least width of an interval, over that of the window.
      real(wp), parameter :: margin = 2.0e-3_wp, least = 1.0e-2_wp
      logical :: left(size(loose))
      real(wp) :: begin, finish
      integer :: next

      allocate (bounds(0))
      left = .true.
      begin = 0
      do
         finish = far
         if (any(left)) finish = minval(loose, left) - margin*far
         if (finish - begin > least*far) bounds = [bounds, begin, finish]
         if (.not. any(left)) exit
         next = minloc(loose, 1, left)
         begin = loose(next) + margin*far
         left(next) = .false.
      end do
   end subroutine parts_between

   !> Total length of some intervals.
   pure real(wp) function covered(bounds)
      !> Where each begins and ends.
      real(wp), intent(in) :: bounds(:)

      covered = sum(bounds(2::2)) - sum(bounds(1::2))
   end function covered

   !> Removes the loops that are not closed.
   pure subroutine drop_open(zone)
      !> In and out: the zone.
      type(zone_type), intent(inout) :: zone
      integer :: i, n

      n = 0
      do i = 1, zone%n
         if (.not. zone%loops(i)%closed) cycle
         n = n + 1
         if (n == i) cycle
         zone%loops(n) = zone%loops(i)
      end do
      zone%n = n
   end subroutine drop_open

   !> Keeps the parts of an open boundary that lie in strips, or on no loop that was traced between
   !! them.
   pure subroutine keep_rest(loop, bounds, axis, traced, zone)
      !> The boundary.
      type(loop_type), intent(in) :: loop
      !> The intervals between the strips, and their coordinate in the window.
      real(wp), intent(in) :: bounds(:)
      integer, intent(in) :: axis
      !> The zone with the loops traced there.
      type(zone_type), intent(in) :: traced
      !> In and out: the parts are added.
      type(zone_type), intent(inout) :: zone
      !> A place this near to an edge lies on it.
      real(wp), parameter :: rounding = 1.0e-9_wp
      integer :: interval(loop%n), first, found, i, last
      real(wp) :: at

      do i = 1, loop%n
         at = loop%points(size(loop%points, 1) - 2 + axis, i)
         interval(i) = findloc(at > bounds(1::2) - rounding .and. at < bounds(2::2) + rounding, &
            .true., dim=1)
      end do
      first = 1
      do while (first <= loop%n)
         last = first
         do while (last < loop%n)
            if (interval(last + 1) /= interval(first)) exit
            last = last + 1
         end do
         found = 0
         if (interval(first) > 0) then
            i = (first + last)/2
            call find_border(border_type(loop%points(:, i), loop%conditions(i)), traced, found)
         end if
         if (found == 0 .and. zone%n < size(zone%loops)) then
            zone%n = zone%n + 1
            zone%loops(zone%n) = picked(loop, [(i, i=max(1, first - 1), min(loop%n, last + 1))])
         end if
         first = last + 1
      end do
   end subroutine keep_rest

end module vi_join
