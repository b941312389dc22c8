!> A net of curves over the sheets of motions in a window, and where they cross the edge of a zone.
!!
!! The lines of a lattice in the window are followed on every sheet that the seeds belong to,
!! through folds as well. Where two lines cross the motion is a node; from every node both lines go
!! on, so that all connected sheets are covered.
module vi_net
   use vi_crossing, only: hidden_zero, innermost_zero
   use vi_curve, only: correct, curve_type
   use vi_frame, only: condition_type, edge, grazing, is_inside, repetition, rest_vanishes, &
      unknown_count, wrap_phases, zero_approach
   use vi_kinds, only: wp
   use vi_lattice, only: lattice_type, line_spacing
   use vi_steps, only: begin_walk, can_shorten, place_type, stride_type, take_step
   use vi_tally, only: is_stopped
   implicit none (type, external)
   private

   public :: new_net, add_seed, cover

   !> A point on the edge of a zone: the condition that is zero there, and a point inside nearby.
   type, public :: border_type
      real(wp), allocatable :: point(:)
      type(condition_type) :: condition
      real(wp) :: inside(2) = 0
   end type border_type

   type, public :: net_type
      !> The sheets: both parameters are active, 0 at the lower corner of the window.
      type(curve_type) :: sheet
      type(lattice_type) :: lines
      !> Nodes: place in the lattice, unknowns, and whether its two lines have been followed.
      integer :: n = 0
      integer, allocatable :: lattice(:, :), follower(:), head(:, :)
      real(wp), allocatable :: unknowns(:, :)
      logical, allocatable :: followed(:, :)
      !> Places where lines cross the edge of a zone.
      type(border_type), allocatable :: borders(:)
      integer :: n_borders = 0
      !> Steps made.
      integer :: steps = 0
   end type net_type

   !> Room for nodes and borders, and steps that may be made.
   integer, parameter :: room = 40000, border_room = 20000, most_steps = 4000000
   !> A motion that would be this far beyond a wall (over d) is not followed any farther.
   real(wp), parameter :: depth = 1.0_wp

contains

   !> An empty net.
   pure subroutine new_net(sheet, lines, net)
      type(curve_type), intent(in) :: sheet
      type(lattice_type), intent(in) :: lines
      type(net_type), intent(out) :: net
      integer :: n

      n = unknown_count(sheet%frame)
      net%sheet = sheet
      net%lines = lines
      allocate (net%lattice(2, room), net%follower(room), net%unknowns(n, room), &
         net%followed(2, room), net%borders(border_room))
      allocate (net%head(size(lines%axes(1)%at), size(lines%axes(2)%at)), source=0)
   end subroutine new_net

   !> Adds a node; one that is there already is not added again.
   pure subroutine add_seed(net, i, j, unknowns, node)
      type(net_type), intent(inout) :: net
      !> Place in the lattice.
      integer, intent(in) :: i, j
      real(wp), intent(in) :: unknowns(:)
      !> Its index; 0 if there is no room.
      integer, intent(out) :: node
      real(wp) :: offset(size(unknowns))

      node = net%head(i, j)
      do while (node > 0)
         offset = net%unknowns(:, node) - unknowns
         call wrap_phases(net%sheet%frame, offset)
         if (maxval(abs(offset)) < 1.0e-6_wp) return
         node = net%follower(node)
      end do
      if (net%n == room) return
      net%n = net%n + 1
      node = net%n
      net%lattice(:, node) = [i, j]
      net%unknowns(:, node) = unknowns
      net%followed(:, node) = .false.
      net%follower(node) = net%head(i, j)
      net%head(i, j) = node
   end subroutine add_seed

   !> Follows both lines through every node, until all have been.
   subroutine cover(net, first, tally)
      type(net_type), intent(inout) :: net
      !> The first node whose lines may not have been followed.
      integer, intent(in) :: first
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      integer :: node, direction, way

      node = first
      do while (node <= net%n)
         do direction = 1, 2
            if (net%followed(direction, node)) cycle
            net%followed(direction, node) = .true.
            do way = -1, 1, 2
               call follow_line(net, node, direction, way, tally)
            end do
         end do
         node = node + 1
      end do
   end subroutine cover

   !> Follows a line from a node one way, until it leaves the window or what is physical.
   subroutine follow_line(net, node, direction, way, tally)
      type(net_type), intent(inout) :: net
      !> The parameter that changes along the line is `direction`.
      integer, intent(in) :: node, direction, way
      integer, intent(inout), optional :: tally(3)
      type(curve_type) :: line
      type(place_type) :: before, now, next
      type(stride_type) :: stride
      type(condition_type) :: none(0)
      real(wp), dimension(size(net%unknowns, 1) + 1) :: along, mark, point
      integer :: taken
      logical :: good, known, passes

      call line_of(net, node, direction, line)
      along = 0
      along(size(along)) = way
      mark = [net%unknowns(:, node), net%lines%axes(direction)%at(net%lattice(direction, node))]
      stride = stride_type(longest=0.8_wp*line_spacing(net%lines, direction, mark(size(mark))))
      call begin_walk(line, none, mark, along, 0.2_wp*stride%longest, now, good)
      if (.not. good) return
      before = now
      taken = 0
      do while (net%steps < most_steps)
         if (is_stopped(tally)) return
         stride%longest = 0.8_wp*line_spacing(net%lines, direction, now%point(size(now%point)))
         call take_step(line, none, stride, now, next, good)
         net%steps = net%steps + 1
         if (.not. good) return
         if (can_shorten(next, 1.0e-4_wp) .and. (any(hidden_zero(before%values, now%values, &
            next%values, now%came, next%came)) .or. may_pass(now%values, next%values))) then
            now%step = 0.3_wp*next%came
            cycle
         end if
         call note_border(net, line, direction, node, now, next)
         call note_nodes(net, line, direction, node, now, next, known)
         if (known .or. leaves(next, line, net%sheet%frame%resting)) return
         ! a closed curve between the lattice's lines comes back to a place of its own
         call pass(line, mark(size(mark)), now, next, point, passes)
         point = point - mark
         call wrap_phases(net%sheet%frame, point)
         if (passes .and. maxval(abs(point)) < 1.0e-6_wp) return
         taken = taken + 1
         if (iand(taken, taken - 1) == 0) mark = next%point
         before = now
         now = next
      end do
   end subroutine follow_line

   !> Whether a step may pass through a zone: what is violated at its start is met at its end, and
   !! something else is violated there.
   pure logical function may_pass(now, next)
      real(wp), intent(in) :: now(:), next(:)

      may_pass = any(now < 0) .and. any(next < 0) .and. .not. any(now < 0 .and. next < 0)
   end function may_pass

   !> The curve of one lattice line.
   pure subroutine line_of(net, node, direction, line)
      type(net_type), intent(in) :: net
      integer, intent(in) :: node, direction
      type(curve_type), intent(out) :: line
      integer :: other

      other = 3 - direction
      associate (sheet => net%sheet)
         line = sheet
         line%active = sheet%active([direction])
         line%origin = sheet%origin([direction])
         line%scale = sheet%scale([direction])
         line%c(sheet%active(other)) = sheet%origin(other) + sheet%scale(other)* &
            net%lines%axes(other)%at(net%lattice(other, node))
      end associate
   end subroutine line_of

   !> Whether a line has left the window, or the motion is no longer physical by far.
   pure logical function leaves(place, line, resting)
      type(place_type), intent(in) :: place
      type(curve_type), intent(in) :: line
      !> Whether the motions have rest: without it their letters are others.
      logical, intent(in) :: resting

      associate (v => place%values, kind => place%conditions%kind)
         leaves = any(v < 0 .and. (kind == zero_approach .or. kind == repetition)) .or. &
            any(v < 0 .and. kind == edge .and. place%conditions%index == line%active(1)) .or. &
            any(v < -depth .and. kind == grazing) .or. &
            (resting .and. any(v < 0 .and. kind == rest_vanishes))
      end associate
   end function leaves

   !> Notes the nodes between two places.
   pure subroutine note_nodes(net, line, direction, node, now, next, known)
      type(net_type), intent(inout) :: net
      type(curve_type), intent(in) :: line
      integer, intent(in) :: direction, node
      type(place_type), intent(in) :: now, next
      !> Whether the line has been here before.
      logical, intent(out) :: known
      real(wp) :: point(size(now%point))
      integer :: i, place(2), found
      logical :: passes

      known = .false.
      do i = 1, size(net%lines%axes(direction)%at)
         call pass(line, net%lines%axes(direction)%at(i), now, next, point, passes)
         if (.not. passes) cycle
         place = net%lattice(:, node)
         place(direction) = i
         call add_seed(net, place(1), place(2), point(:size(point) - 1), found)
         if (found == 0) cycle
         if (net%followed(direction, found)) known = .true.
         net%followed(direction, found) = .true.
      end do
   end subroutine note_nodes

   !> Where a step passes a level of the line's parameter, if it does.
   pure subroutine pass(line, level, now, next, point, passes)
      type(curve_type), intent(in) :: line
      real(wp), intent(in) :: level
      type(place_type), intent(in) :: now, next
      real(wp), intent(out) :: point(:)
      logical, intent(out) :: passes
      type(condition_type) :: at
      real(wp) :: a, b
      integer :: iterations

      a = now%point(size(point))
      b = next%point(size(point))
      point = now%point
      passes = (level - a)*(level - b) < 0 .and. .not. abs(level - a) < 1.0e-9_wp
      if (.not. passes) return
      point = now%point + (level - a)/(b - a)*(next%point - now%point)
      at = condition_type(edge, line%active(1), 1, bound=line%origin(1) + line%scale(1)*level)
      call correct(line, [at], point, iterations)
      passes = iterations > 0
   end subroutine pass

   !> Notes where a step enters or leaves a zone.
   pure subroutine note_border(net, line, direction, node, now, next)
      type(net_type), intent(inout) :: net
      type(curve_type), intent(in) :: line
      integer, intent(in) :: direction, node
      type(place_type), intent(in) :: now, next
      type(place_type) :: best
      real(wp) :: other, q(2)
      integer :: j, which
      logical :: inside

      inside = is_inside(now%conditions, now%values, line%active(1))
      if (inside .eqv. is_inside(next%conditions, next%values, line%active(1))) return
      if (net%n_borders == border_room) return
      call innermost_zero(line, now, next, inside, best, which)
      if (which == 0) return
      other = net%lines%axes(3 - direction)%at(net%lattice(3 - direction, node))
      net%n_borders = net%n_borders + 1
      associate (border => net%borders(net%n_borders), n => size(net%unknowns, 1))
         allocate (border%point(n + 2))
         q(direction) = best%point(n + 1)
         q(3 - direction) = other
         border%point(:n) = best%point(:n)
         border%point(n + 1:) = q
         border%condition = best%conditions(which)
         border%inside(3 - direction) = other
         border%inside(direction) = merge(now%point(n + 1), next%point(n + 1), inside)
         ! on an edge of the window it would lie on the loop
         do j = 1, 2
            associate (far => net%lines%axes(j)%at(size(net%head, j)))
               border%inside(j) = max(1.0e-6_wp, min(far - 1.0e-6_wp, border%inside(j)))
            end associate
         end do
      end associate
   end subroutine note_border

end module vi_net
