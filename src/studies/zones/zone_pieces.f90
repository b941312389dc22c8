!> Zones as lists of pieces: successive vertices along which one condition is zero.
module vi_zone_pieces
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_condition_names, only: condition_detail, condition_name
   use vi_curve, only: curve_type
   use vi_family, only: can_be_symmetric
   use vi_kinds, only: wp
   use vi_loop, only: begins, loop_type
   use vi_motion_family, only: condition_type, edge, searched_type
   use vi_net_line, only: start_type
   use vi_outline, only: ring_of
   use vi_zone_request, only: zone_request_type
   use vi_progress, only: add_expected_work
   use vi_structure_start, only: period_at
   use vi_study, only: column_type, result_type, truths, wholes, words
   use vi_text, only: line_type
   use vi_zone, only: find_zone, return_type, zone_type, zone_work
   implicit none (type, external)
   private

   public :: add_pieces, put_pieces, zone_pieces

   character(*), parameter, public :: not_closed = &
      'not closed: a boundary could not be followed until it closes'

   !> Columns of the results of zones and atlases. A family is what one search covers: the motions
   !! of a pattern or, in an atlas, either its symmetric motions or the others.
   type(column_type), parameter, public :: piece_columns(*) = [ &
      column_type('pieces', 'loop', wholes, &
      meaning='number of the closed boundary; 0 if it could not be closed'), &
      column_type('pieces', 'piece', wholes, meaning='number of the piece of the boundary'), &
      column_type('pieces', 'type', words, meaning='condition that is zero along it'), &
      column_type('pieces', 'detail', words, meaning='the impact, flight or bound concerned')], &
      place_columns(*) = [ &
      column_type('vertices', 'r', meaning='frequency ratio'), &
      column_type('vertices', 'clearance', unit='F0/K', &
      meaning='clearance d K/F0; d is the whole travel of m between the walls')], &
      corner_column = column_type('vertices', 'corner', truths, &
      meaning='whether pieces meet there'), &
      vertex_columns(*) = [ &
      column_type('vertices', 'x', each='impact', listed=.false., &
      meaning='x/D of the motion at its impacts; with rest, velocity over D at the last release'), &
      column_type('vertices', 'theta', each='impact', unit='rad', listed=.false., &
      meaning='load phases of the impacts; with rest, of the last release'), &
      column_type('rings', 'r', listed=.false., &
      meaning='frequency ratio along a closed loop, counter-clockwise around a zone'), &
      column_type('rings', 'clearance', unit='F0/K', listed=.false., &
      meaning='clearance along a closed loop')], &
      family_columns(*) = [ &
      column_type('families', 'motions', wholes, listed=.false., &
      meaning='motions at nodes of the lattice'), &
      column_type('families', 'steps', wholes, listed=.false., &
      meaning='steps along the lattice lines'), &
      column_type('families', 'untraced', wholes, listed=.false., &
      meaning='places on a boundary from which continuation failed'), &
      column_type('families', 'lines', wholes, each='axis', listed=.false., &
      meaning='lattice lines in each direction'), &
      column_type('families', 'closed', truths, listed=.false., &
      meaning='whether all boundaries that were found are closed')]

   !> One piece: its first and last vertices are corners, unless the whole loop is one piece.
   type, public :: piece_type
      character(:), allocatable :: name, detail
      !> The condition that is zero along it.
      type(condition_type) :: condition
      logical :: symmetric = .false.
      !> Number of the loop; 0 if it could not be closed.
      integer :: loop = 0
      !> (2, m): r, D
      real(wp), allocatable :: vertices(:, :)
      !> (n, m) each: x_i/D and theta_i of the motion; with rest, velocity over D and load phase at
      !! the last release (n = 1).
      real(wp), allocatable :: x(:, :), theta(:, :)
      !> (m) The period of the motion, if it is self-excited, or 0.
      real(wp), allocatable :: period(:)
      logical, allocatable :: corner(:)
   end type piece_type

   !> A closed loop as a polygon, counter-clockwise around a zone and clockwise around a hole.
   type, public :: ring_type
      !> (2, n): r, D
      real(wp), allocatable :: points(:, :)
   end type ring_type

   !> All pieces and rings of a search, and its counts.
   type, public :: pieces_type
      type(piece_type), allocatable :: pieces(:)
      !> Pieces, loops that are closed, motions found on the lattice.
      integer :: n = 0, loops = 0, motions = 0
      !> One for each loop that is closed.
      type(ring_type), allocatable :: rings(:)
      !> Steps along lattice lines, borders left untraced, and lattice lines of constant r and D.
      integer :: steps = 0, untraced = 0, lines(2) = 0
      !> Whether each seed is stable and admissible, inside the window, and in no closed loop.
      logical, allocatable :: open_seeds(:)
      !> Whether each seed is a motion of one of the families inside the window.
      logical, allocatable :: used_seeds(:)
      !> Whether all boundaries that were found could be closed.
      logical :: closed = .true.
   end type pieces_type

contains

   !> The zones of a pattern: of symmetric motions, of the others, or of both, in this order.
   subroutine zone_pieces(request, seeds, families, found, progress)
      !> The request; `symmetric` is not used.
      type(zone_request_type), intent(in) :: request
      !> Known motions, as in `find_zone`.
      real(wp), intent(in) :: seeds(:, :)
      !> Whether symmetric motions and whether others are wanted.
      logical, intent(in) :: families(2)
      !> The pieces.
      type(pieces_type), intent(out) :: found
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(zone_request_type) :: one
      type(zone_type) :: zone
      logical :: possible, wanted(2)
      type(start_type), allocatable :: pitchforks(:)
      type(return_type), allocatable :: returns(:)
      type(searched_type), allocatable :: searched(:, :, :)
      integer :: i, status

      possible = can_be_symmetric(request%pattern, request%osc%restitution)
      one = request
      ! simulation finds a motion with rest only inside its zone, which may be narrow
      if (any(abs(one%pattern%sides) == 2)) one%lines = max(33, one%lines)
      ! the more impacts, the fewer guesses lead to a motion; without guesses, only seeds count
      if (all(abs(one%pattern%sides) == 1) .and. one%guesses > 0) one%simulations = &
         3*size(one%pattern%sides)**2
      wanted = families .and. [possible, .true.]
      call add_expected_work(zone_work*count(wanted), progress)
      do i = 1, 2
         if (.not. wanted(i)) cycle
         one%symmetric = i == 1
         call find_zone(one, seeds, zone, status, progress, pitchforks=pitchforks, &
            returns=returns, searched=searched)
         call add_pieces(zone, one, possible .and. .not. one%symmetric, found)
         if (.not. allocated(found%open_seeds)) allocate (found%open_seeds(size(seeds, 2)), &
            found%used_seeds(size(seeds, 2)), source=.false.)
         found%open_seeds = found%open_seeds .or. zone%open_seeds
         found%used_seeds = found%used_seeds .or. zone%used_seeds
      end do
   end subroutine zone_pieces

   !> Adds the pieces of one family.
   pure subroutine add_pieces(zone, request, mirrored, found)
      !> The zones of one family.
      type(zone_type), intent(in) :: zone
      !> The request: its window, and whether the motions are their own mirror images.
      type(zone_request_type), intent(in) :: request
      !> Whether these motions are not symmetric while others of the pattern are.
      logical, intent(in) :: mirrored
      !> In and out: the pieces are added.
      type(pieces_type), intent(inout) :: found
      integer :: j

      if (.not. allocated(found%pieces)) allocate (found%pieces(16), found%rings(0))
      found%motions = found%motions + zone%nodes
      found%steps = found%steps + zone%steps
      found%untraced = found%untraced + zone%untraced
      if (all(found%lines == 0)) found%lines = zone%lines
      ! a full list of loops may have lost some
      found%closed = found%closed .and. zone%untraced == 0 .and. zone%n < size(zone%loops) .and. &
         .not. any(zone%open_seeds)
      do j = 1, zone%n
         call split(zone, zone%loops(j), request%symmetric, mirrored, found)
         if (zone%loops(j)%closed) call add_ring(zone, j, request, found)
      end do
   end subroutine add_pieces

   !> Adds a closed loop as a polygon.
   pure subroutine add_ring(zone, j, request, found)
      !> The zone.
      type(zone_type), intent(in) :: zone
      !> Place of the loop.
      integer, intent(in) :: j
      !> The request.
      type(zone_request_type), intent(in) :: request
      !> In: with the previous rings. Out: with this ring.
      type(pieces_type), intent(inout) :: found
      type(ring_type), allocatable :: longer(:)
      integer :: n

      n = size(found%rings)
      allocate (longer(n + 1))
      longer(:n) = found%rings
      call ring_of(zone%surface, zone%loops(j), request%r, request%clearance, longer(n + 1)%points)
      call move_alloc(longer, found%rings)
   end subroutine add_ring

   !> Splits a loop at its corners, which are listed twice: where a piece ends and where one begins.
   pure subroutine split(zone, loop, symmetric, mirrored, found)
      !> The zones of one family.
      type(zone_type), intent(in) :: zone
      !> The loop.
      type(loop_type), intent(in) :: loop
      !> As in `add_pieces`: whether its motions are symmetric, or only others of the pattern.
      logical, intent(in) :: symmetric, mirrored
      !> In and out: the pieces are added.
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

   !> Appends one piece of a loop.
   pure subroutine append(zone, loop, run, number, symmetric, mirrored, found)
      !> The zones of one family.
      type(zone_type), intent(in) :: zone
      !> The loop.
      type(loop_type), intent(in) :: loop
      !> Numbers of the vertices of the piece, and of the loop (0 if it is not closed).
      integer, intent(in) :: run(:), number
      !> As in `add_pieces`.
      logical, intent(in) :: symmetric, mirrored
      !> In and out: the piece is added.
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
         piece%condition = condition
         piece%name = trim(condition_name(condition%kind, condition%index, symmetric, mirrored))
         piece%detail = trim(condition_detail(condition%kind, condition%index, condition%side))
         if (condition%kind == edge) then
            piece%name = 'window'
            if (.not. is_of_window(zone%surface%edges, condition)) then
               piece%name = 'cut'
               piece%detail = piece%detail(index(piece%detail, ' ') + 1:)
            end if
         end if
         piece%symmetric = symmetric
         piece%loop = number
         piece%corner = loop%corner(run) > 0
         allocate (piece%vertices(2, size(run)))
         m = size(loop%points, 1) - 2
         do j = 1, size(run)
            piece%vertices(:, j) = zone%surface%origin + zone%surface%scale*loop%points(m + 1:, &
               run(j))
            piece%vertices(2, j) = exp(piece%vertices(2, j))
         end do
         call write_motions(zone%surface, loop, run, piece)
      end associate
   end subroutine append

   !> Whether a bound on a parameter is an edge of the window.
   pure logical function is_of_window(edges, bound) result(is_edge)
      !> The edges, and the bound.
      type(condition_type), intent(in) :: edges(:), bound

      is_edge = any(edges%index == bound%index .and. edges%side == bound%side .and. &
         .not. abs(edges%bound - bound%bound) > 0)
   end function is_of_window

   !> Writes the motions at the vertices of a piece.
   pure subroutine write_motions(surface, loop, run, piece)
      !> The surface of the loop.
      type(curve_type), intent(in) :: surface
      !> The loop.
      type(loop_type), intent(in) :: loop
      !> Its vertices on the piece.
      integer, intent(in) :: run(:)
      !> The piece.
      type(piece_type), intent(inout) :: piece
      real(wp), allocatable :: whole(:)
      integer :: j, m, n

      m = size(loop%points, 1) - 2
      allocate (piece%period(size(run)))
      do j = 1, size(run)
         piece%period(j) = period_at(surface, loop%points(:, run(j)))
         whole = surface%family%whole_of(loop%points(:m, run(j)))
         n = size(whole)/2
         if (j == 1) allocate (piece%x(n, size(run)), piece%theta(n, size(run)))
         piece%x(:, j) = whole(:n)
         piece%theta(:, j) = whole(n + 1:)
      end do
   end subroutine write_motions

   !> Puts the pieces of families into the result, and their rings.
   pure subroutine put_pieces(found, result, names)
      !> The pieces of each family.
      type(pieces_type), intent(in) :: found(:)
      !> The result.
      type(result_type), intent(inout) :: result
      !> Columns of both parameters, and of both unknowns of an impact; by default those of the
      !! oscillator.
      character(*), intent(in), optional :: names(4)
      character(*), parameter :: of_oscillator(4) = ['r        ', 'clearance', &
         'x        ', 'theta    ']
      character(24) :: columns(4)
      type(line_type), allocatable :: types(:), details(:)
      integer, allocatable :: owners(:), numbers(:), loops(:), symmetric(:), vertex_owners(:), &
         corners(:)
      real(wp), allocatable :: vertices(:, :), x(:, :), theta(:, :), period(:)
      integer :: i, j, k, m, n, most

      columns = of_oscillator
      if (present(names)) columns = names
      k = sum(found%n)
      n = 0
      most = 1
      do j = 1, size(found)
         do i = 1, found(j)%n
            n = n + size(found(j)%pieces(i)%corner)
            most = max(most, size(found(j)%pieces(i)%x, 1))
         end do
      end do
      allocate (types(k), details(k), owners(k), numbers(k), loops(k), symmetric(k), &
         vertex_owners(n), corners(n), vertices(2, n), period(n))
      allocate (x(most, n), theta(most, n), source=ieee_value(1.0_wp, ieee_quiet_nan))
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
               types(k)%text = piece%name
               details(k)%text = piece%detail
               symmetric(k) = merge(1, 0, piece%symmetric)
               vertex_owners(n + 1:n + m) = k
               corners(n + 1:n + m) = merge(1, 0, piece%corner)
               vertices(:, n + 1:n + m) = piece%vertices
               x(:size(piece%x, 1), n + 1:n + m) = piece%x
               theta(:size(piece%x, 1), n + 1:n + m) = piece%theta
               period(n + 1:n + m) = piece%period
               n = n + m
            end associate
         end do
      end do
      call result%put('families', 'motions', found%motions)
      call result%put('families', 'steps', found%steps)
      call result%put('families', 'untraced', found%untraced)
      call result%put('families', 'lines', [(found(j)%lines, j=1, size(found))])
      call result%put('families', 'closed', merge(1, 0, found%closed))
      call result%open('pieces', 'piece', [k], 'families', owners)
      call result%put('pieces', 'symmetric', symmetric)
      call result%put('pieces', 'loop', loops)
      call result%put('pieces', 'piece', numbers)
      call result%put_text('pieces', 'type', types)
      call result%put_text('pieces', 'detail', details)
      call result%open('vertices', 'vertex', [n], 'pieces', vertex_owners)
      call result%put('vertices', trim(columns(1)), vertices(1, :))
      call result%put('vertices', trim(columns(2)), vertices(2, :))
      call result%put('vertices', 'corner', corners)
      call result%put('vertices', trim(columns(3)), [x])
      call result%put('vertices', trim(columns(4)), [theta])
      if (any(period > 0)) call result%put('vertices', 'period', period)
      call put_rings(found, result, columns(:2))
   end subroutine put_pieces

   !> Puts the closed loops into the result.
   pure subroutine put_rings(found, result, names)
      !> The pieces of each family.
      type(pieces_type), intent(in) :: found(:)
      !> The result.
      type(result_type), intent(inout) :: result
      !> Columns of both parameters.
      character(*), intent(in) :: names(2)
      integer, allocatable :: owners(:), point_owners(:)
      real(wp), allocatable :: points(:, :)
      integer :: i, j, k, m, n

      k = sum(found%loops)
      n = 0
      do j = 1, size(found)
         do i = 1, found(j)%loops
            n = n + size(found(j)%rings(i)%points, 2)
         end do
      end do
      allocate (owners(k), point_owners(n), points(2, n))
      k = 0
      n = 0
      do j = 1, size(found)
         do i = 1, found(j)%loops
            k = k + 1
            m = size(found(j)%rings(i)%points, 2)
            owners(k) = j
            point_owners(n + 1:n + m) = k
            points(:, n + 1:n + m) = found(j)%rings(i)%points
            n = n + m
         end do
      end do
      call result%open('loops', 'ring', [k], 'families', owners)
      call result%open('rings', 'ring_point', [n], 'loops', point_owners)
      call result%put('rings', trim(names(1)), points(1, :))
      call result%put('rings', trim(names(2)), points(2, :))
   end subroutine put_rings

end module vi_zone_pieces
