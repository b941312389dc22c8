!> A net of curves over the surface of motions in a window, and where they cross the boundary of a
!! zone.
!!
!! The lines of a lattice in the window are followed on every part of the surface that the seeds
!! belong to, through folds as well. A motion where two lines cross is a node; from every node both
!! lines are followed, so that all its connected parts are covered.
module vi_net
   use vi_crossing, only: hidden_zero, innermost_zero, locate
   use vi_curve, only: curve_type
   use vi_kinds, only: wp
   use vi_lattice, only: lattice_type, line_spacing
   use vi_motion_family, only: condition_type, edge, flip, is_inside, repetition
   use vi_net_line, only: leaves, line_of, may_pass, pass, start_type
   use vi_steps, only: begin_walk, can_shorten, exchange, place_type, stride_type, take_step
   use vi_progress, only: is_stopped
   implicit none (type, external)
   private

   public :: new_net, add_seed, cover, cover_from, follow_both, reach_border

   !> Room for crossings of one line with those of the lattice.
   integer, parameter :: crossing_capacity = 1024

   !> A point on the boundary of a zone, and the condition that is zero there.
   type, public :: border_type
      real(wp), allocatable :: point(:)
      type(condition_type) :: condition
   end type border_type

   !> The net over one window.
   type, public :: net_type
      !> The surface: both parameters are active, 0 at the lower corner of the window.
      type(curve_type) :: surface
      type(lattice_type) :: lines
      !> Nodes: place in the lattice, unknowns, and whether its two lines have been followed.
      integer :: n = 0
      integer, allocatable :: lattice(:, :), follower(:), head(:, :)
      real(wp), allocatable :: unknowns(:, :)
      logical, allocatable :: followed(:, :)
      !> Places where lines cross the boundary of a zone.
      type(border_type), allocatable :: borders(:)
      integer :: n_borders = 0
      !> Whether these places are sought, and steps shortened for them.
      logical :: seeks_borders = .true.
      !> Places where a line that does not belong to the lattice has crossed lines of the lattice.
      type(start_type) :: crossings(crossing_capacity)
      integer :: n_crossings = 0
      !> Whether the lattice lines through these places have been followed.
      logical :: crossed(crossing_capacity) = .false.
      !> Nodes and followed crossings that lines of the lattice have met.
      integer :: met = 0
      !> Where lines pass a flip (a pitchfork of symmetric motions); noted if there is room.
      type(start_type), allocatable :: flips(:)
      integer :: n_flips = 0
      !> Steps made, and their largest number.
      integer :: steps = 0, most_steps = 4000000
      !> Whether something was left out because one of the limits was reached.
      logical :: full = .false.
   end type net_type

   !> Room for nodes and borders.
   integer, parameter :: capacity = 40000, border_capacity = 20000
   !> Room for flips.
   integer, parameter :: flip_capacity = 4000

contains

   !> An empty net.
   subroutine new_net(surface, lines, net, notes_flips)
      !> The surface of motions over the window.
      type(curve_type), intent(in) :: surface
      !> The lattice.
      type(lattice_type), intent(in) :: lines
      !> Out: without nodes.
      type(net_type), intent(out) :: net
      !> Whether flips are noted.
      logical, intent(in) :: notes_flips
      integer :: n

      n = surface%family%unknown_count()
      net%surface = surface
      net%lines = lines
      allocate (net%lattice(2, capacity), net%follower(capacity), net%unknowns(n, capacity), &
         net%followed(2, capacity), net%borders(border_capacity))
      allocate (net%head(size(lines%axes(1)%at), size(lines%axes(2)%at)), source=0)
      allocate (net%flips(merge(flip_capacity, 0, notes_flips)))
   end subroutine new_net

   !> Adds a node, unless the motion or an image of it is one already.
   pure subroutine add_seed(net, i, j, unknowns, node)
      !> In and out: the net.
      type(net_type), intent(inout) :: net
      !> Place in the lattice.
      integer, intent(in) :: i, j
      !> Unknowns of the motion.
      real(wp), intent(in) :: unknowns(:)
      !> Its index; 0 if there is no room.
      integer, intent(out) :: node

      node = node_at(net, i, j, unknowns)
      if (node > 0) return
      net%full = net%full .or. net%n == capacity
      if (net%n == capacity) return
      net%n = net%n + 1
      node = net%n
      net%lattice(:, node) = [i, j]
      net%unknowns(:, node) = unknowns
      net%followed(:, node) = .false.
      net%follower(node) = net%head(i, j)
      net%head(i, j) = node
   end subroutine add_seed

   !> The node of a motion or of one of its images; 0 if there is none.
   pure integer function node_at(net, i, j, unknowns) result(node)
      !> The net.
      type(net_type), intent(in) :: net
      !> Place in the lattice.
      integer, intent(in) :: i, j
      !> Unknowns of the motion.
      real(wp), intent(in) :: unknowns(:)

      node = net%head(i, j)
      do while (node > 0)
         if (is_image(net, net%unknowns(:, node), unknowns)) return
         node = net%follower(node)
      end do
   end function node_at

   !> Whether two motions are the same or images of each other.
   pure logical function is_image(net, one, other)
      !> The net.
      type(net_type), intent(in) :: net
      !> Unknowns of the motions.
      real(wp), intent(in) :: one(:), other(:)
      real(wp) :: offset(size(one))
      integer :: k

      is_image = .false.
      do k = 0, size(net%surface%family%images)
         offset = other
         if (k > 0) offset = net%surface%family%image_of(net%surface%family%images(k), &
            other)
         offset = one - offset
         call net%surface%family%wrap_phases(offset)
         is_image = maxval(abs(offset)) < 1.0e-6_wp
         if (is_image) return
      end do
   end function is_image

   !> Follows both lines through every node, also through the nodes found on the way.
   subroutine cover(net, first, progress)
      !> In and out: the net.
      type(net_type), intent(inout) :: net
      !> The first node whose lines may not have been followed.
      integer, intent(in) :: first
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      integer :: node, direction

      node = first
      do while (node <= net%n)
         do direction = 1, 2
            if (net%followed(direction, node)) cycle
            net%followed(direction, node) = .true.
            call follow_both(net, start_of(net, node), direction, progress)
         end do
         node = node + 1
      end do
   end subroutine cover

   !> Follows the lines through a motion that is not a node, then the lattice lines that they cross,
   !! and covers the surface from there.
   subroutine cover_from(net, at, unknowns, progress, passing)
      !> In and out: the net.
      type(net_type), intent(inout) :: net
      !> Place of the motion in the window.
      real(wp), intent(in) :: at(2)
      !> Unknowns of the motion.
      real(wp), intent(in) :: unknowns(:)
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> Whether a simulation has only passed by the motion, false by default: then its lines end
      !! where a lattice line that they cross leads to nodes, from which the surface is covered.
      logical, intent(in), optional :: passing
      type(start_type) :: begin
      integer :: before, direction, first, i

      begin = start_type(unknowns, at)
      first = net%n + 1
      do direction = 1, 2
         ! those of previous motions need not all be known
         if (net%n_crossings > size(net%crossings)/4) net%n_crossings = 0
         before = net%n_crossings
         net%crossed(before + 1:) = .false.
         call follow_both(net, begin, direction, progress, passing)
         do i = before + 1, net%n_crossings
            if (net%crossed(i)) cycle
            net%crossed(i) = .true.
            call follow_both(net, net%crossings(i), 3 - direction, progress)
         end do
      end do
      call cover(net, first, progress)
   end subroutine cover_from

   !> Follows a line from a motion inside a zone until it leaves the zone; the place is added to the
   !! borders. Along a closed curve it may not leave: then another line is followed.
   subroutine reach_border(net, at, unknowns, progress)
      !> In and out: the net.
      type(net_type), intent(inout) :: net
      !> Place of the motion in the window.
      real(wp), intent(in) :: at(2)
      !> Unknowns of the motion.
      real(wp), intent(in) :: unknowns(:)
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      integer :: crossings, direction, n, way

      n = net%n_borders
      ! the lattice lines that this line crosses are not followed
      crossings = net%n_crossings
      do direction = 1, 2
         do way = -1, 1, 2
            call follow_line(net, start_type(unknowns, at), direction, way, progress, &
               to_border=.true.)
            net%n_crossings = crossings
            if (net%n_borders > n) return
         end do
      end do
   end subroutine reach_border

   !> A node as the start of a line.
   pure function start_of(net, node) result(begin)
      !> The net.
      type(net_type), intent(in) :: net
      !> Number of the node.
      integer, intent(in) :: node
      type(start_type) :: begin
      integer :: i

      begin = start_type(net%unknowns(:, node), [(net%lines%axes(i)%at(net%lattice(i, node)), &
         i=1, 2)], net%lattice(:, node))
   end function start_of

   !> Follows a line from a motion in both directions, or in one if all of it is known then.
   recursive subroutine follow_both(net, begin, direction, progress, passing)
      !> As in `follow_line`.
      type(net_type), intent(inout) :: net
      type(start_type), intent(in) :: begin
      integer, intent(in) :: direction
      integer, intent(inout), optional :: progress(3)
      logical, intent(in), optional :: passing
      logical :: returned

      call follow_line(net, begin, direction, -1, progress, returned=returned, passing=passing)
      if (.not. returned) call follow_line(net, begin, direction, 1, progress, passing=passing)
   end subroutine follow_both

   !> Follows a line from a motion in one direction, until it leaves the window or its motions are
   !! far from physical.
   recursive subroutine follow_line(net, begin, direction, way, progress, to_border, returned, &
      passing)
      !> In and out: nodes and borders are added.
      type(net_type), intent(inout) :: net
      !> Start of the line.
      type(start_type), intent(in) :: begin
      !> Number of the parameter that changes along the line, and the sign of its change at the
      !! start.
      integer, intent(in) :: direction, way
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> Whether it is followed only until it enters or leaves a zone; false by default.
      logical, intent(in), optional :: to_border
      !> Whether nothing is left in the other direction: it is a closed curve, or known.
      logical, intent(out), optional :: returned
      !> Of a line that does not belong to the lattice: as in `cover_from`; false by default.
      logical, intent(in), optional :: passing
      type(curve_type) :: line
      type(place_type) :: before, now, next
      type(stride_type) :: stride
      type(condition_type) :: none(0)
      real(wp), dimension(size(net%unknowns, 1) + 1) :: along, mark, point
      real(wp) :: share
      integer :: borders, counted, crossings, i, met, taken
      logical :: between, good, known, leaving, left, passes, shorten, to_nodes

      if (present(returned)) returned = .false.
      borders = border_capacity
      if (present(to_border)) borders = merge(net%n_borders, borders, to_border)
      call line_of(net%surface, begin, direction, line)
      along = 0
      along(size(along)) = way
      mark = [begin%unknowns, begin%at(direction)]
      between = begin%lattice(3 - direction) == 0
      to_nodes = .false.
      if (present(passing)) to_nodes = passing .and. between
      ! a line through a given motion takes short steps
      share = merge(0.2_wp, 0.8_wp, between .and. .not. to_nodes)
      stride = stride_type(longest=share*line_spacing(net%lines, direction, mark(size(mark))))
      call begin_walk(line, none, mark, along, 0.2_wp*stride%longest, now, good)
      if (.not. good) return
      before = now
      ! the conditions whose zeros are sought
      counted = merge(size(now%values), flip, net%seeks_borders)
      taken = 0
      leaving = between .and. any(now%values < 0 .and. now%conditions%kind == repetition)
      do while (net%steps < net%most_steps)
         if (is_stopped(progress)) return
         stride%longest = share*line_spacing(net%lines, direction, now%point(size(now%point)))
         call take_step(line, none, stride, now, next, good)
         net%steps = net%steps + 1
         if (.not. good) return
         shorten = .false.
         if (can_shorten(next, 1.0e-4_wp)) shorten = any(hidden_zero(before%values(:counted), &
            now%values(:counted), next%values(:counted), now%came, next%came))
         if (net%seeks_borders .and. .not. shorten .and. can_shorten(next, 1.0e-6_wp)) shorten = &
            may_pass(line, now, next)
         if (shorten) then
            now%step = 0.3_wp*next%came
            cycle
         end if
         if (net%seeks_borders) call note_border(net, line, direction, begin, now, next)
         if (net%n_borders > borders) return
         if (size(net%flips) > 0) call note_flip(net, line, direction, begin, now, next)
         crossings = net%n_crossings
         call note_nodes(net, line, direction, begin, now, next, known)
         if (to_nodes) then
            ! the surface is covered from nodes
            met = net%met
            do i = crossings + 1, net%n_crossings
               if (net%crossed(i)) cycle
               net%crossed(i) = .true.
               call follow_both(net, net%crossings(i), 3 - direction, progress)
            end do
            if (net%met > met) return
         end if
         ! a given motion can be too near to one that repeats itself: move away from there
         left = leaving
         leaving = leaves(next, line)
         ! from a place between two nodes, the rest of a line followed before is known as well
         if (known .and. present(returned)) returned = any(begin%lattice == 0)
         if (known .or. (leaving .and. .not. left)) return
         ! a closed curve between the lattice lines returns to one of its own points
         call pass(line, mark(size(mark)), now, next, point, passes)
         point = point - mark
         call net%surface%family%wrap_phases(point)
         passes = passes .and. maxval(abs(point)) < 1.0e-6_wp
         if (passes .and. present(returned)) returned = .true.
         if (passes) return
         taken = taken + 1
         if (iand(taken, taken - 1) == 0) mark = next%point
         call exchange(before, now)
         call exchange(now, next)
      end do
      net%full = .true.
   end subroutine follow_line

   !> Notes the nodes between two places.
   pure subroutine note_nodes(net, line, direction, begin, now, next, known)
      !> In and out: nodes are added.
      type(net_type), intent(inout) :: net
      !> The line.
      type(curve_type), intent(in) :: line
      !> Number of the parameter that changes along it.
      integer, intent(in) :: direction
      !> Its start.
      type(start_type), intent(in) :: begin
      !> Start and end of the step.
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
         place = begin%lattice
         place(direction) = i
         if (place(3 - direction) == 0) then
            call note_crossing(net, direction, i, begin, point)
            cycle
         end if
         call add_seed(net, place(1), place(2), point(:size(point) - 1), found)
         if (found == 0) cycle
         if (net%followed(direction, found)) known = .true.
         net%followed(direction, found) = .true.
         net%met = net%met + 1
      end do
      if (begin%lattice(3 - direction) == 0 .or. net%n_crossings == 0) return
      ! a crossing lies on one line of the lattice alone, and is no node
      do i = 1, net%n_crossings
         if (net%crossings(i)%lattice(3 - direction) /= begin%lattice(3 - direction)) cycle
         call pass(line, net%crossings(i)%at(direction), now, next, point, passes)
         if (.not. passes) cycle
         if (.not. is_image(net, net%crossings(i)%unknowns, point(:size(point) - 1))) cycle
         if (net%crossed(i)) then
            known = .true.
            net%met = net%met + 1
         end if
         net%crossed(i) = .true.
      end do
   end subroutine note_nodes

   !> Notes where a line that does not belong to the lattice crosses one that does.
   pure subroutine note_crossing(net, direction, level, begin, point)
      !> In and out: the crossing is added, if there is room.
      type(net_type), intent(inout) :: net
      !> The direction of the line off the lattice, and the number of the line it crosses.
      integer, intent(in) :: direction, level
      !> Start of the line.
      type(start_type), intent(in) :: begin
      !> The point of the line at the crossing.
      real(wp), intent(in) :: point(:)

      net%full = net%full .or. net%n_crossings == crossing_capacity
      if (net%n_crossings == crossing_capacity) return
      net%n_crossings = net%n_crossings + 1
      associate (crossing => net%crossings(net%n_crossings))
         crossing = start_type(point(:size(point) - 1), begin%at)
         crossing%at(direction) = net%lines%axes(direction)%at(level)
         crossing%lattice(direction) = level
      end associate
   end subroutine note_crossing

   !> Notes where a multiplier passes -1 within a step.
   pure subroutine note_flip(net, line, direction, begin, now, next)
      !> In and out: the place is added, if there is room.
      type(net_type), intent(inout) :: net
      !> The line.
      type(curve_type), intent(in) :: line
      !> Number of the parameter that changes along it.
      integer, intent(in) :: direction
      !> Its start.
      type(start_type), intent(in) :: begin
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      type(place_type) :: found
      type(condition_type) :: none(0)
      real(wp) :: share
      logical :: good

      if (.not. now%values(flip)*next%values(flip) < 0) return
      net%full = net%full .or. net%n_flips == size(net%flips)
      if (net%n_flips == size(net%flips)) return
      call locate(line, none, now, next, flip, found, share, good)
      if (.not. good) return
      if (any(found%values < 0 .and. found%conditions%kind == edge .and. found%conditions%index == &
         line%active(1))) return
      net%n_flips = net%n_flips + 1
      associate (here => net%flips(net%n_flips), n => size(net%unknowns, 1))
         here = start_type(found%point(:n), begin%at, begin%lattice)
         here%at(direction) = found%point(n + 1)
         here%lattice(direction) = 0
      end associate
   end subroutine note_flip

   !> Notes where a step enters or leaves a zone.
   pure subroutine note_border(net, line, direction, begin, now, next)
      !> In and out: the border is added, if there is room.
      type(net_type), intent(inout) :: net
      !> The line.
      type(curve_type), intent(in) :: line
      !> Number of the parameter that changes along it.
      integer, intent(in) :: direction
      !> Its start.
      type(start_type), intent(in) :: begin
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      type(place_type) :: best
      real(wp) :: q(2)
      integer :: which
      logical :: inside

      inside = is_inside(now%conditions, now%values, line%active(1))
      if (inside .eqv. is_inside(next%conditions, next%values, line%active(1))) return
      net%full = net%full .or. net%n_borders == border_capacity
      if (net%n_borders == border_capacity) return
      call innermost_zero(line, now, next, inside, best, which)
      if (which == 0) return
      q = begin%at
      q(direction) = best%point(size(best%point))
      net%n_borders = net%n_borders + 1
      net%borders(net%n_borders) = border_type([best%point(:size(best%point) - 1), q], &
         best%conditions(which))
   end subroutine note_border

end module vi_net
