!> Zones of stable, admissible motions of a pattern in a window of the plane (r, D).
!!
!! Seeds from Newton's method are spread over the window, a net covers the sheets they lie on, and
!! from every place where it enters or leaves a zone the boundary is traced, unless it is known.
module vi_zone
   use vi_conditions, only: apart, condition_type, edge
   use vi_curve, only: correct, curve_type
   use vi_exact, only: setting_type
   use vi_family, only: image_of, kinship, new_family
   use vi_kinds, only: wp
   use vi_loop, only: loop_type, trace_loop, wrap
   use vi_net, only: add_seed, border_type, cover, net_type, new_net
   use vi_orbit, only: by_clearance, by_r
   use vi_oscillator, only: left, oscillator_type, right
   use vi_pattern, only: default_restitution, pattern_type
   use vi_search, only: search_pattern
   use vi_status, only: stat
   use vi_steps, only: stride_type
   implicit none (type, external)
   private

   public :: find_zone

   !> What to look for and how hard.
   type, public :: zone_request_type
      type(oscillator_type) :: osc
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
      integer :: i

      call make_sheet(request, zone%sheet, status)
      allocate (zone%loops(most_loops), zone%inside(2, most_loops))
      if (status /= stat%ok .or. is_neutral(request%osc)) return
      call new_net(zone%sheet, request%lines, net)
      do i = 1, size(seeds, 2)
         call plant(net, request, seeds(1, i), seeds(2, i), seeds(3:, i))
      end do
      call cover(net, 1)
      call search_window(request, net)
      zone%nodes = net%n
      zone%steps = net%steps
      do i = 1, net%n_borders
         call trace_border(net%borders(i), request%points, zone)
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
         call new_family(request%pattern, request%symmetric, abs(walls(1) - walls(2)) <= 0, &
            sheet%frame%family, sheet%frame%repetitions, possible)
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

   !> Searches motions at a few nodes of the lattice and follows the sheets they lie on.
   pure subroutine search_window(request, net)
      type(zone_request_type), intent(in) :: request
      type(net_type), intent(inout) :: net
      type(setting_type) :: setting
      real(wp) :: found(2*size(request%pattern%sides), 64), q(2), c(2)
      integer :: i, j, k, n_found, tried, every, first, skip

      setting = setting_type(request%osc, 1.0_wp, 1.0_wp, 1.0_wp, request%pattern, &
         default_restitution(request%pattern%sides, request%osc%restitution(right), &
         request%osc%restitution(left)))
      every = 2
      skip = 0
      do j = 1, request%lines, every
         do i = 1, request%lines, every
            q = [i - 1, j - 1]/real(request%lines - 1, wp)
            c = net%sheet%origin + net%sheet%scale*q
            setting%r = c(1)
            setting%clearance = exp(c(2))
            call search_pattern(setting, request%guesses, found, n_found, tried, skip)
            skip = skip + request%guesses
            found(:size(request%pattern%sides), :n_found) = &
               found(:size(request%pattern%sides), :n_found)/setting%clearance
            first = net%n + 1
            do k = 1, n_found
               call plant_node(net, request, i, j, found(:, k))
            end do
            call cover(net, first)
         end do
      end do
   end subroutine search_window

   !> Brings a motion to the nearest node of the lattice, if that is possible, and adds it.
   pure subroutine plant(net, request, r, clearance, whole)
      type(net_type), intent(inout) :: net
      type(zone_request_type), intent(in) :: request
      real(wp), intent(in) :: r, clearance
      real(wp), intent(in) :: whole(:)
      real(wp) :: q(2)
      integer :: place(2)

      q = ([r, log(clearance)] - net%sheet%origin)/net%sheet%scale
      place = 1 + nint(q*(net%lines - 1))
      if (any(place < 1) .or. any(place > net%lines)) return
      call plant_node(net, request, place(1), place(2), whole, q)
   end subroutine plant

   !> Adds a motion of the whole pattern to a node, if it belongs to the family.
   pure subroutine plant_node(net, request, i, j, whole, from)
      type(net_type), intent(inout) :: net
      type(zone_request_type), intent(in) :: request
      integer, intent(in) :: i, j
      real(wp), intent(in) :: whole(:)
      !> Where it comes from, if not from the node itself.
      real(wp), intent(in), optional :: from(2)
      real(wp) :: point(size(net%unknowns, 1) + 2), q(2), start(2)
      type(condition_type) :: fixed(2)
      integer :: n, total, iterations, node, part

      n = size(net%unknowns, 1)
      total = size(request%pattern%sides)
      point(:n) = [whole(:n/2), whole(total + 1:total + n/2)]
      q = [i - 1, j - 1]/real(net%lines - 1, wp)
      start = q
      if (present(from)) start = from
      do part = 1, merge(4, 1, present(from))
         point(n + 1:) = start + (q - start)*part/merge(4, 1, present(from))
         fixed = [(condition_type(edge, node, 1, bound=net%sheet%origin(node) &
            + net%sheet%scale(node)*point(n + node)), node=1, 2)]
         call correct(net%sheet, fixed, point, iterations)
         if (iterations == 0) return
      end do
      do part = 1, size(net%sheet%frame%repetitions)
         if (kinship(net%sheet%frame%family, net%sheet%frame%repetitions(part), point(:n)) &
            < 10*apart) return
      end do
      call add_seed(net, i, j, point(:n), node)
   end subroutine plant_node

   !> Traces the boundary from a place on it, unless it is on a loop already.
   pure subroutine trace_border(border, most, zone)
      type(border_type), intent(in) :: border
      integer, intent(in) :: most
      type(zone_type), intent(inout) :: zone
      type(loop_type) :: loop
      type(border_type) :: begin

      if (is_known(border, zone)) return
      if (zone%n == most_loops .or. zone%points > room) then
         zone%untraced = zone%untraced + 1
         return
      end if
      call trace_loop(zone%sheet, stride_type(longest=0.03_wp, turn=0.15_wp), border%point, &
         border%condition, most, loop)
      zone%points = zone%points + loop%n
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
      zone%loops(zone%n) = loop
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
               if (lies_on(image, zone%loops(i))) return
            end do
         end do
      end do
      is_known = .false.
   end function is_known

   !> Whether a place on the boundary lies on a loop, along the same condition.
   pure logical function lies_on(border, loop)
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
         call wrap(offset)
         chord = loop%points(:, next) - loop%points(:, i)
         call wrap(chord)
         length = norm2(chord)
         if (.not. length > 0) cycle
         share = dot_product(offset, chord)/length**2
         if (share < -0.01_wp .or. share > 1.01_wp) cycle
         lies_on = norm2(offset - share*chord) < 0.1_wp*length + 1.0e-6_wp
         if (lies_on) return
      end do
   end function lies_on

end module vi_zone
