!> Zones of stable, admissible motions of a pattern in a window of the plane (r, D).
!!
!! Seeds from Newton's method are spread over the window, a net covers the sheets they lie on, and
!! from every place where it enters or leaves a zone the boundary is traced, unless it is known.
module vi_zone
   use vi_curve, only: correct, curve_type, parameters_of
   use vi_family, only: image_of, kinship
   use vi_frame, only: condition_type, edge, frame_type, unknown_count, wrap_phases
   use vi_kinds, only: wp
   use vi_lattice, only: nearest_lines, new_lattice
   use vi_loop, only: loop_type, trace_loop
   use vi_net, only: add_seed, border_type, cover, net_type, new_net
   use vi_seeds, only: motions_at, part_of
   use vi_settle, only: settle
   use vi_sheet, only: is_neutral, make_sheet, zone_request_type
   use vi_status, only: stat
   use vi_steps, only: stride_type
   use vi_tally, only: is_stopped, tell_share
   implicit none (type, external)
   private

   public :: find_zone

   !> What one zone counts in a tally of work.
   integer, parameter, public :: zone_work = 1000

   !> The zones of a family in a window.
   type, public :: zone_type
      type(loop_type), allocatable :: loops(:)
      integer :: n = 0
      !> The sheets over the window.
      type(curve_type) :: sheet
      !> A point inside, beside each loop (2, n).
      real(wp), allocatable :: inside(:, :)
      !> Motions found in the window, steps of the net, and borders left untraced.
      integer :: nodes = 0, steps = 0, untraced = 0
      !> Lattice lines of constant r and of constant D.
      integer :: lines(2) = 0
      !> Points traced, those of loops that were dropped included.
      integer :: points = 0
   end type zone_type

   !> Loops kept, and points after which no further loop is begun.
   integer, parameter :: most_loops = 400, room = 150000

contains

   !> All zones of a pattern in a window.
   subroutine find_zone(request, seeds, zone, status, tally)
      type(zone_request_type), intent(in) :: request
      !> Motions known beforehand, in the whole pattern: r, D, x_i/D, theta_i (2 + 2N, m).
      real(wp), intent(in) :: seeds(:, :)
      type(zone_type), intent(out) :: zone
      !> `stat%ok`, or `stat%no_motion` if the pattern cannot have such motions.
      integer, intent(out) :: status
      !> As of vi_tally; a zone that is stopped has borders left untraced.
      integer, intent(inout), optional :: tally(3)
      type(net_type) :: net
      real(wp) :: q(2)
      integer, allocatable :: unclosed(:)
      logical :: closed
      integer :: i, k, n_unclosed, told

      call make_sheet(request, zone%sheet, status)
      allocate (zone%loops(most_loops), zone%inside(2, most_loops))
      told = 0
      if (status /= stat%ok .or. is_neutral(request%osc)) then
         call tell_share(1.0_wp, zone_work, told, tally)
         return
      end if
      call new_net(zone%sheet, new_lattice(request%lines, [request%r, log(request%clearance)], &
         zone%sheet%scale), net)
      zone%lines = shape(net%head)
      do i = 1, size(seeds, 2)
         q = ([seeds(1, i), log(seeds(2, i))] - zone%sheet%origin)/zone%sheet%scale
         call plant(net, q, part_of(zone%sheet%frame, parameters_of(zone%sheet, &
            [(0.0_wp, k=1, unknown_count(zone%sheet%frame)), q]), seeds(3:, i)), &
            nearest_lines(net%lines, q))
      end do
      call cover(net, 1, tally)
      call search_window(request, net, told, tally)
      zone%nodes = net%n
      zone%steps = net%steps
      ! what cannot be closed from one place often can be from another
      allocate (unclosed(net%n_borders))
      n_unclosed = 0
      do i = 1, net%n_borders
         if (is_stopped(tally)) exit
         call trace_border(net%borders(i), request%points, .false., zone, closed, tally)
         call tell_share(0.5_wp + 0.5_wp*i/net%n_borders, zone_work, told, tally)
         if (closed) cycle
         n_unclosed = n_unclosed + 1
         unclosed(n_unclosed) = i
      end do
      do i = 1, n_unclosed
         if (is_stopped(tally)) exit
         call trace_border(net%borders(unclosed(i)), request%points, .true., zone, closed, tally)
      end do
      do i = 1, zone%n
         call settle(zone%sheet, zone%loops(i))
      end do
      if (is_stopped(tally)) zone%untraced = zone%untraced + 1
      call tell_share(1.0_wp, zone_work, told, tally)
   end subroutine find_zone

   !> Searches motions at the nodes of the lattice and follows the sheets they lie on.
   !!
   !! At every second node each way with all guesses, then at the others with few: near resonance
   !! motions may exist on a strip of the window that the first pass steps over.
   subroutine search_window(request, net, told, tally)
      type(zone_request_type), intent(in) :: request
      type(net_type), intent(inout) :: net
      integer, intent(inout) :: told
      integer, intent(inout), optional :: tally(3)
      real(wp), allocatable :: found(:, :)
      real(wp) :: q(2)
      integer :: i, j, k, first, guesses, pass, passes, skip

      skip = 0
      ! motions with rest are looked for by simulation, which takes longer and finds them at once
      passes = merge(1, 2, net%sheet%frame%resting)
      do pass = 1, passes
         guesses = merge(request%guesses, request%guesses/4, pass == 1)
         do j = 1, size(net%lines%axes(2)%at)
            do i = 1, size(net%lines%axes(1)%at)
               if ((mod(i, 2) == 1 .and. mod(j, 2) == 1) .neqv. pass == 1) cycle
               q = [net%lines%axes(1)%at(i), net%lines%axes(2)%at(j)]
               call motions_at(net%sheet%frame, request%pattern, parameters_of(net%sheet, &
                  [(0.0_wp, k=1, size(net%unknowns, 1)), q]), guesses, skip, found)
               skip = skip + guesses
               first = net%n + 1
               do k = 1, size(found, 2)
                  call plant(net, q, found(:, k), [i, j])
               end do
               call cover(net, first, tally)
               if (is_stopped(tally)) return
            end do
            call tell_share(0.5_wp*(pass - 1 + j/real(size(net%head, 2), wp))/passes, zone_work, &
               told, tally)
         end do
      end do
   end subroutine search_window

   !> Brings a motion to a node of the lattice and adds it, if it belongs to the family.
   pure subroutine plant(net, from, unknowns, place)
      type(net_type), intent(inout) :: net
      !> Where in the window it comes from.
      real(wp), intent(in) :: from(2)
      real(wp), intent(in) :: unknowns(:)
      integer, intent(in) :: place(2)
      real(wp) :: point(size(unknowns) + 2), q(2)
      type(condition_type) :: fixed(2)
      integer :: n, iterations, node, part, parts

      if (any(place < 1) .or. any(place > shape(net%head))) return
      n = size(unknowns)
      q = [net%lines%axes(1)%at(place(1)), net%lines%axes(2)%at(place(2))]
      point(:n) = unknowns
      parts = merge(1, 4, all(abs(q - from) <= 0))
      do part = 1, parts
         point(n + 1:) = from + (q - from)*part/parts
         fixed = [(condition_type(edge, node, 1, bound=net%sheet%origin(node) &
            + net%sheet%scale(node)*point(n + node)), node=1, 2)]
         call correct(net%sheet, fixed, point, iterations)
         if (iterations == 0) return
      end do
      associate (frame => net%sheet%frame)
         do part = 1, size(frame%repetitions)
            if (kinship(frame%family, frame%repetitions(part), point(:n)) < 10*frame%apart) return
         end do
      end associate
      call add_seed(net, place(1), place(2), point(:n), node)
   end subroutine plant

   !> Traces the boundary from a place on it, unless it is on a loop already.
   subroutine trace_border(border, most, keep_open, zone, closed, tally)
      type(border_type), intent(in) :: border
      integer, intent(in) :: most
      !> Whether a curve that cannot be closed is kept.
      logical, intent(in) :: keep_open
      type(zone_type), intent(inout) :: zone
      !> Whether the place lies on a closed loop.
      logical, intent(out) :: closed
      integer, intent(inout), optional :: tally(3)
      type(loop_type) :: loop
      type(border_type) :: begin

      closed = is_known(border, zone)
      if (closed) return
      if (zone%n == most_loops .or. zone%points > room) then
         zone%untraced = zone%untraced + 1
         return
      end if
      call trace_loop(zone%sheet, stride_type(longest=0.02_wp, turn=0.15_wp), border%point, &
         border%condition, most, loop, tally)
      zone%points = zone%points + loop%n
      closed = loop%closed
      if (.not. (closed .or. keep_open)) return
      if (loop%n < 3) then
         zone%untraced = zone%untraced + 1
         return
      end if
      ! a loop that the border only leads to can have been there before
      begin = border
      begin%point = loop%points(:, 1)
      begin%condition = loop%conditions(1)
      if (is_known(begin, zone)) return
      zone%n = zone%n + 1
      associate (kept => zone%loops(zone%n), n => loop%n)
         ! without the room that is left
         kept = loop_type(loop%points(:, :n), loop%tangents(:, :n), loop%conditions(:n), &
            loop%corner(:n), n, loop%closed)
      end associate
      zone%inside(:, zone%n) = border%inside
   end subroutine trace_border

   !> Whether a place lies on a loop that has been traced, or its image does.
   !!
   !! Images of a motion under a symmetry of the pattern have the same zone.
   pure logical function is_known(border, zone)
      type(border_type), intent(in) :: border
      type(zone_type), intent(in) :: zone
      type(border_type) :: image
      integer :: i, j, k, n

      is_known = .true.
      image = border
      n = size(border%point) - 2
      do j = 0, size(zone%sheet%frame%repetitions)
         do k = 1, merge(1, n/2, j == 0)
            if (j > 0) image%point(:n) = image_of(zone%sheet%frame%family, &
               zone%sheet%frame%repetitions(j), image%point(:n))
            do i = 1, zone%n
               if (lies_on(zone%sheet%frame, image, zone%loops(i))) return
            end do
         end do
      end do
      is_known = .false.
   end function is_known

   !> Whether a place on the boundary lies on a loop, along the same condition.
   pure logical function lies_on(frame, border, loop)
      type(frame_type), intent(in) :: frame
      type(border_type), intent(in) :: border
      type(loop_type), intent(in) :: loop
      real(wp), dimension(size(border%point)) :: chord, offset
      real(wp) :: share, length
      integer :: i, next

      lies_on = .false.
      do i = 1, loop%n
         if (border%condition%kind /= loop%conditions(i)%kind) cycle
         next = merge(1, i + 1, i == loop%n)
         offset = border%point - loop%points(:, i)
         call wrap_phases(frame, offset)
         chord = loop%points(:, next) - loop%points(:, i)
         call wrap_phases(frame, chord)
         length = norm2(chord)
         if (.not. length > 0) cycle
         share = dot_product(offset, chord)/length**2
         if (share < -0.01_wp .or. share > 1.01_wp) cycle
         lies_on = norm2(offset - share*chord) < 0.1_wp*length + 1.0e-6_wp
         if (lies_on) return
      end do
   end function lies_on

end module vi_zone
