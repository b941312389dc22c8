!> Zones as lists of pieces: the runs of vertices along which one condition is zero.
module vi_zone_pieces
   use vi_condition_names, only: condition_detail, condition_name
   use vi_family, only: can_be_symmetric
   use vi_frame, only: edge
   use vi_kinds, only: wp
   use vi_loop, only: begins, loop_type
   use vi_result, only: result_type
   use vi_sheet, only: zone_request_type
   use vi_tally, only: add_sight
   use vi_text, only: line_type
   use vi_zone, only: find_zone, zone_type, zone_work
   implicit none (type, external)
   private

   public :: add_pieces, put_pieces, zone_pieces

   character(*), parameter, public :: not_closed = &
      'not closed: a boundary could not be followed until it closes'

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
      logical :: closed = .true.
   end type pieces_type

contains

   !> The zones of a pattern: of symmetric motions, of the others, or of both, in this order.
   subroutine zone_pieces(request, families, found, tally)
      type(zone_request_type), intent(in) :: request
      !> Whether symmetric motions and whether others are wanted.
      logical, intent(in) :: families(2)
      type(pieces_type), intent(out) :: found
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      type(zone_request_type) :: one
      type(zone_type) :: zone
      real(wp) :: none(2 + 2*size(request%pattern%sides), 0)
      logical :: possible, wanted(2)
      integer :: i, status

      possible = can_be_symmetric(request%pattern, request%osc%restitution)
      one = request
      ! simulation finds a motion with rest only inside its zone, which may be narrow
      if (any(abs(one%pattern%sides) == 2)) one%lines = max(33, one%lines)
      wanted = families .and. [possible, .true.]
      call add_sight(zone_work*count(wanted), tally)
      do i = 1, 2
         if (.not. wanted(i)) cycle
         one%symmetric = i == 1
         call find_zone(one, none, zone, status, tally)
         call add_pieces(zone, one%symmetric, possible .and. .not. one%symmetric, found)
      end do
   end subroutine zone_pieces

   !> Adds the pieces of one family.
   pure subroutine add_pieces(zone, symmetric, mirrored, found)
      type(zone_type), intent(in) :: zone
      !> The motions are their own mirror images; they are not, but others of the pattern are.
      logical, intent(in) :: symmetric, mirrored
      type(pieces_type), intent(inout) :: found
      integer :: j

      if (.not. allocated(found%pieces)) allocate (found%pieces(16))
      found%motions = found%motions + zone%nodes
      ! a full list of loops may have lost some
      found%closed = found%closed .and. zone%untraced == 0 .and. zone%n < size(zone%loops)
      do j = 1, zone%n
         call split(zone, zone%loops(j), symmetric, mirrored, found)
      end do
   end subroutine add_pieces

   !> Splits a loop at its corners, which are there twice: where a piece ends and where one begins.
   pure subroutine split(zone, loop, symmetric, mirrored, found)
      type(zone_type), intent(in) :: zone
      type(loop_type), intent(in) :: loop
      logical, intent(in) :: symmetric, mirrored
      type(pieces_type), intent(inout) :: found
      integer, allocatable :: starts(:), run(:)
      integer :: i, j, m, number

      if (loop%closed) found%loops = found%loops + 1
      found%closed = found%closed .and. loop%closed
      number = merge(found%loops, 0, loop%closed)
      m = count(loop%corner(2:loop%n) == begins)
      allocate (starts(m + 2), source=[1, pack([(j, j=2, loop%n)], loop%corner(2:loop%n) == &
         begins), loop%n + 1])
      m = size(starts) - 1
      if (loop%closed .and. m > 1 .and. loop%corner(1) /= begins) then
         ! the loop begins within a piece
         run = [(j, j=starts(m), loop%n), (j, j=1, starts(2) - 1)]
         m = m - 1
      else
         run = [(j, j=1, starts(2) - 1)]
         if (loop%closed .and. m == 1) run = [run, 1]
      end if
      do i = 1, m
         if (i > 1) run = [(j, j=starts(i), starts(i + 1) - 1)]
         call append(zone, loop, run, number, symmetric, mirrored, found)
      end do
   end subroutine split

   pure subroutine append(zone, loop, run, number, symmetric, mirrored, found)
      type(zone_type), intent(in) :: zone
      type(loop_type), intent(in) :: loop
      integer, intent(in) :: run(:), number
      logical, intent(in) :: symmetric, mirrored
      type(pieces_type), intent(inout) :: found
      type(piece_type), allocatable :: longer(:)
      integer :: j, m

      if (found%n == size(found%pieces)) then
         allocate (longer(2*found%n))
         longer(:found%n) = found%pieces
         call move_alloc(longer, found%pieces)
      end if
      found%n = found%n + 1
      associate (piece => found%pieces(found%n), &
         condition => loop%conditions(run(min(2, size(run)))))
         piece%name = trim(condition_name(condition%kind, condition%index, symmetric, mirrored))
         if (condition%kind == edge) piece%name = 'window'
         piece%detail = trim(condition_detail(condition%kind, condition%index, condition%side))
         piece%symmetric = symmetric
         piece%loop = number
         piece%corner = loop%corner(run) > 0
         allocate (piece%vertices(2, size(run)))
         m = size(loop%points, 1) - 2
         do j = 1, size(run)
            piece%vertices(:, j) = zone%sheet%origin + zone%sheet%scale*loop%points(m + 1:, run(j))
            piece%vertices(2, j) = exp(piece%vertices(2, j))
         end do
      end associate
   end subroutine append

   !> Puts the pieces of sheets into the result; if there is a table of sheets, they belong to it.
   pure subroutine put_pieces(found, result)
      !> The pieces of each sheet.
      type(pieces_type), intent(in) :: found(:)
      !> The result.
      type(result_type), intent(inout) :: result
      type(line_type), allocatable :: names(:), details(:)
      integer, allocatable :: owners(:), numbers(:), loops(:), symmetric(:), vertex_owners(:), &
         corners(:)
      real(wp), allocatable :: vertices(:, :)
      integer :: i, j, k, m, n

      k = sum(found%n)
      n = sum([((size(found(j)%pieces(i)%corner), i=1, found(j)%n), j=1, size(found))])
      allocate (names(k), details(k), owners(k), numbers(k), loops(k), symmetric(k), &
         vertex_owners(n), corners(n), vertices(2, n))
      k = 0
      n = 0
      do j = 1, size(found)
         do i = 1, found(j)%n
            associate (piece => found(j)%pieces(i))
               k = k + 1
               m = size(piece%corner)
               owners(k) = j
               numbers(k) = i
               loops(k) = piece%loop
               names(k)%text = piece%name
               details(k)%text = piece%detail
               symmetric(k) = merge(1, 0, piece%symmetric)
               vertex_owners(n + 1:n + m) = k
               corners(n + 1:n + m) = merge(1, 0, piece%corner)
               vertices(:, n + 1:n + m) = piece%vertices
               n = n + m
            end associate
         end do
      end do
      if (any(result%tables%name == 'sheets')) then
         call result%open('pieces', 'piece', [k], 'sheets', owners)
      else
         call result%open('pieces', 'piece', [k])
         call result%put('pieces', 'symmetric', symmetric)
      end if
      call result%put('pieces', 'loop', loops)
      call result%put('pieces', 'piece', numbers)
      call result%put_text('pieces', 'type', names)
      call result%put_text('pieces', 'detail', details)
      call result%open('vertices', 'vertex', [n], 'pieces', vertex_owners)
      call result%put('vertices', 'r', vertices(1, :))
      call result%put('vertices', 'clearance', vertices(2, :))
      call result%put('vertices', 'corner', corners)
   end subroutine put_pieces

end module vi_zone_pieces
