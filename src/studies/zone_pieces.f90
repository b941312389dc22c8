!> Zones as lists of pieces: the runs of vertices along which one condition is zero.
module vi_zone_pieces
   use vi_condition_names, only: condition_detail, condition_name
   use vi_family, only: can_be_symmetric
   use vi_frame, only: edge
   use vi_kinds, only: wp
   use vi_loop, only: begins
   use vi_status, only: stat
   use vi_zone, only: zone_request_type
   use vi_zone_table, only: zone_arrays
   implicit none (type, external)
   private

   public :: zone_pieces

   !> One piece: its first and last vertices are corners, unless the whole loop is one piece.
   type, public :: piece_type
      character(:), allocatable :: name, detail
      logical :: symmetric = .false.
      !> The loop; 0 if that could not be closed.
      integer :: loop = 0
      !> (2, m): r, D
      real(wp), allocatable :: vertices(:, :)
      logical, allocatable :: corner(:)
   end type piece_type

   !> What was found.
   type, public :: pieces_type
      type(piece_type), allocatable :: pieces(:)
      !> Pieces, loops that are closed, motions found on the lattice.
      integer :: n = 0, loops = 0, motions = 0
      !> Whether all boundaries that were found could be closed.
      logical :: complete = .true.
   end type pieces_type

   !> Room for vertices and loops of one family.
   integer, parameter :: room = 200000, loop_room = 400

contains

   !> The zones of a pattern: of symmetric motions, of the others, or of both, in this order.
   pure subroutine zone_pieces(request, families, found)
      type(zone_request_type), intent(in) :: request
      !> Whether symmetric motions and whether others are wanted.
      logical, intent(in) :: families(2)
      type(pieces_type), intent(out) :: found
      type(zone_request_type) :: one
      real(wp) :: none(2 + 2*size(request%pattern%sides), 0)
      real(wp), allocatable :: vertices(:, :), unknowns(:, :), inside(:, :)
      integer, allocatable :: labels(:, :), loops(:, :)
      logical :: possible
      integer :: i, j, n, n_loops, first, work(3), status

      allocate (found%pieces(16), vertices(5, room), unknowns(size(none, 1) - 2, room), &
         inside(2, loop_room), labels(4, room), loops(2, loop_room))
      possible = can_be_symmetric(request%pattern, request%osc%restitution)
      one = request
      ! simulation finds a motion with rest only inside its zone, which may be narrow
      if (any(abs(one%pattern%sides) == 2)) one%lines = max(33, one%lines)
      do i = 1, 2
         one%symmetric = i == 1
         if (.not. families(i) .or. (one%symmetric .and. .not. possible)) cycle
         call zone_arrays(one, none, vertices, unknowns, labels, n, loops, inside, n_loops, work, &
            status)
         found%motions = found%motions + work(1)
         found%complete = found%complete .and. status /= stat%more_events .and. work(3) == 0
         first = 1
         do j = 1, n_loops
            n = first + loops(1, j) - 1
            call split(vertices(:2, first:n), labels(:, first:n), loops(2, j) == 1, &
               one%symmetric, possible .and. .not. one%symmetric, found)
            first = n + 1
         end do
      end do
   end subroutine zone_pieces

   !> Splits a loop at its corners, which are there twice: where a piece ends and where one begins.
   pure subroutine split(vertices, labels, closed, symmetric, mirrored, found)
      real(wp), intent(in) :: vertices(:, :)
      integer, intent(in) :: labels(:, :)
      logical, intent(in) :: closed, symmetric, mirrored
      type(pieces_type), intent(inout) :: found
      integer, allocatable :: starts(:), run(:)
      integer :: i, j, m, n

      n = size(labels, 2)
      if (closed) found%loops = found%loops + 1
      found%complete = found%complete .and. closed
      starts = [1, pack([(j, j=2, n)], labels(4, 2:) == begins), n + 1]
      m = size(starts) - 1
      if (closed .and. m > 1 .and. labels(4, 1) /= begins) then
         ! the loop begins within a piece
         run = [(j, j=starts(m), n), (j, j=1, starts(2) - 1)]
         m = m - 1
      else
         run = [(j, j=1, starts(2) - 1)]
         if (closed .and. m == 1) run = [run, 1]
      end if
      do i = 1, m
         if (i > 1) run = [(j, j=starts(i), starts(i + 1) - 1)]
         call append(vertices(:, run), labels(:, run), merge(found%loops, 0, closed), symmetric, &
            mirrored, found)
      end do
   end subroutine split

   pure subroutine append(vertices, labels, loop, symmetric, mirrored, found)
      real(wp), intent(in) :: vertices(:, :)
      integer, intent(in) :: labels(:, :), loop
      logical, intent(in) :: symmetric, mirrored
      type(pieces_type), intent(inout) :: found
      type(piece_type), allocatable :: longer(:)
      integer :: label(4)

      if (found%n == size(found%pieces)) then
         allocate (longer(2*found%n))
         longer(:found%n) = found%pieces
         call move_alloc(longer, found%pieces)
      end if
      found%n = found%n + 1
      label = labels(:, min(2, size(labels, 2)))
      associate (piece => found%pieces(found%n))
         piece%name = condition_name(label(1), label(2), symmetric, mirrored)
         if (label(1) == edge) piece%name = 'window'
         piece%detail = condition_detail(label(1), label(2), label(3))
         piece%symmetric = symmetric
         piece%loop = loop
         piece%vertices = vertices
         piece%corner = labels(4, :) > 0
      end associate
   end subroutine append

end module vi_zone_pieces
