!> Zones of stable, admissible motions of a pattern in a window of the plane (r, D).
!!
!! Seeds from Newton's method are spread over the window, a net covers the sheets they lie on, and
!! from every place where it enters or leaves a zone the boundary is traced, unless it is known.
module vi_zone
   use vi_curve, only: correct, curve_type, parameters_of
   use vi_family, only: image_of, kinship, new_family
   use vi_frame, only: condition_type, edge, frame_type, wrap_phases
   use vi_kinds, only: wp
   use vi_loop, only: loop_type, trace_loop
   use vi_net, only: add_seed, border_type, cover, net_type, new_net
   use vi_orbit, only: by_clearance, by_r
   use vi_oscillator, only: left, oscillator_type, right
   use vi_pattern, only: pattern_type
   use vi_rest_family, only: new_rest_family
   use vi_seeds, only: motions_at, part_of
   use vi_settle, only: settle
   use vi_status, only: stat
   use vi_steps, only: stride_type
   implicit none (type, external)
   private

   public :: find_zone

   !> What to look for and how hard.
   type, public :: zone_request_type
      type(oscillator_type) :: osc
      !> Sides; +2 and -2 for accumulation and rest.
      type(pattern_type) :: pattern
      logical :: symmetric = .false.
      real(wp) :: r(2) = 0, clearance(2) = 0
      !> Lattice lines each way, guesses at each node where motions are searched.
      integer :: lines = 17, guesses = 12
      !> Most points of a loop.
      integer :: points = 20000
   end type zone_request_type

   type, public :: zone_type
      type(loop_type), allocatable :: loops(:)
      integer :: n = 0
      !> The sheets, with the window as the unit square.
      type(curve_type) :: sheet
      !> A point inside, beside each loop (2, n).
      real(wp), allocatable :: inside(:, :)
      !> Motions found in the window, steps of the net, and borders left untraced.
      integer :: nodes = 0, steps = 0, untraced = 0
      !> Points traced, those of loops that were dropped included.
      integer :: points = 0
   end type zone_type

   !> Loops kept, and points after which no further loop is begun.
   integer, parameter :: most_loops = 400, room = 150000

contains

   !> All zones of a pattern in a window.
   pure subroutine find_zone(request, seeds, zone, status)
      type(zone_request_type), intent(in) :: request
      !> Motions known beforehand, in the whole pattern: r, D, x_i/D, theta_i (2 + 2N, m).
      real(wp), intent(in) :: seeds(:, :)
      type(zone_type), intent(out) :: zone
      !> `stat%ok`, or `stat%no_motion` if the pattern cannot have such motions.
      integer, intent(out) :: status
      type(net_type) :: net
      real(wp) :: q(2)
      integer, allocatable :: unclosed(:)
      logical :: closed
      integer :: i, n_unclosed

      call make_sheet(request, zone%sheet, status)
      allocate (zone%loops(most_loops), zone%inside(2, most_loops))
      if (status /= stat%ok .or. is_neutral(request%osc)) return
      call new_net(zone%sheet, request%lines, net)
      do i = 1, size(seeds, 2)
         q = ([seeds(1, i), log(seeds(2, i))] - zone%sheet%origin)/zone%sheet%scale
         call plant(net, q, part_of(zone%sheet%frame, seeds(3:, i)), 1 + nint(q*(net%lines - 1)))
      end do
      call cover(net, 1)
      call search_window(request, net)
      zone%nodes = net%n
      zone%steps = net%steps
      ! what cannot be closed from one place often can be from another
      allocate (unclosed(net%n_borders))
      n_unclosed = 0
      do i = 1, net%n_borders
         call trace_border(net%borders(i), request%points, .false., zone, closed)
         if (closed) cycle
         n_unclosed = n_unclosed + 1
         unclosed(n_unclosed) = i
      end do
      do i = 1, n_unclosed
         call trace_border(net%borders(unclosed(i)), request%points, .true., zone, closed)
      end do
      do i = 1, zone%n
         call settle(zone%sheet, zone%loops(i))
      end do
   end subroutine find_zone

   !> Whether no motion of an oscillator is asymptotically stable: nothing dissipates.
   !!
   !! Without impacts on it (mu = 0) the primary mass loses by damping alone, the other by impacts.
   pure logical function is_neutral(osc)
      type(oscillator_type), intent(in) :: osc
      logical :: undamped, elastic

      undamped = osc%xi <= 0
      elastic = all(osc%restitution >= 1)
      is_neutral = (undamped .and. elastic) .or. (osc%mu <= 0 .and. (undamped .or. elastic))
   end function is_neutral

   !> The family in the window, both parameters active.
   pure subroutine make_sheet(request, sheet, status)
      type(zone_request_type), intent(in) :: request
      type(curve_type), intent(out) :: sheet
      integer, intent(out) :: status
      real(wp) :: low(2), high(2)
      logical :: possible
      integer :: i

      associate (osc => request%osc, walls => request%osc%restitution)
         sheet%frame%resting = any(abs(request%pattern%sides) == 2)
         if (sheet%frame%resting) then
            sheet%frame%rest = new_rest_family(request%pattern%sides, request%pattern%cycles)
            allocate (sheet%frame%repetitions(0))
            possible = .not. request%symmetric
         else
            call new_family(request%pattern, request%symmetric, abs(walls(1) - walls(2)) <= 0, &
               sheet%frame%family, sheet%frame%repetitions, possible)
         end if
         status = merge(stat%ok, stat%no_motion, possible)
         low = [request%r(1), log(request%clearance(1))]
         high = [request%r(2), log(request%clearance(2))]
         sheet%c = [low, osc%xi, osc%mu, walls(right), walls(left)]
      end associate
      sheet%active = [by_r, by_clearance]
      sheet%origin = low
      sheet%scale = high - low
      allocate (sheet%frame%edges(4))
      do i = 1, 2
         sheet%frame%edges(2*i - 1) = condition_type(edge, i, 1, bound=low(i))
         sheet%frame%edges(2*i) = condition_type(edge, i, -1, bound=high(i))
      end do
   end subroutine make_sheet

   !> Searches motions at the nodes of the lattice and follows the sheets they lie on.
   !!
   !! At every second node each way with all guesses, then at the others with few: near resonance
   !! motions may exist on a strip of the window that the first pass steps over.
   pure subroutine search_window(request, net)
      type(zone_request_type), intent(in) :: request
      type(net_type), intent(inout) :: net
      real(wp), allocatable :: found(:, :)
      real(wp) :: q(2)
      integer :: i, j, k, first, guesses, pass, skip

      skip = 0
      ! motions with rest are looked for by simulation, which takes longer and finds them at once
      do pass = 1, merge(1, 2, net%sheet%frame%resting)
         guesses = merge(request%guesses, request%guesses/4, pass == 1)
         do j = 1, request%lines
            do i = 1, request%lines
               if ((mod(i, 2) == 1 .and. mod(j, 2) == 1) .neqv. pass == 1) cycle
               q = [i - 1, j - 1]/real(request%lines - 1, wp)
               call motions_at(net%sheet%frame, request%pattern, parameters_of(net%sheet, &
                  [(0.0_wp, k=1, size(net%unknowns, 1)), q]), guesses, skip, found)
               skip = skip + guesses
               first = net%n + 1
               do k = 1, size(found, 2)
                  call plant(net, q, found(:, k), [i, j])
               end do
               call cover(net, first)
            end do
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

      if (any(place < 1) .or. any(place > net%lines)) return
      n = size(unknowns)
      q = (place - 1)/real(net%lines - 1, wp)
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
   pure subroutine trace_border(border, most, keep_open, zone, closed)
      type(border_type), intent(in) :: border
      integer, intent(in) :: most
      !> Whether a curve that cannot be closed is kept.
      logical, intent(in) :: keep_open
      type(zone_type), intent(inout) :: zone
      !> Whether the place lies on a closed loop.
      logical, intent(out) :: closed
      type(loop_type) :: loop
      type(border_type) :: begin

      closed = is_known(border, zone)
      if (closed) return
      if (zone%n == most_loops .or. zone%points > room) then
         zone%untraced = zone%untraced + 1
         return
      end if
      call trace_loop(zone%sheet, stride_type(longest=0.02_wp, turn=0.15_wp), border%point, &
         border%condition, most, loop)
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
