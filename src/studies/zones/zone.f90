!> Zones of stable, admissible motions of a pattern in a window of the plane (r, D).
!!
!! Newton's method finds motions at points spread over the window, and a net of lines covers the
!! surface on which they lie. Where a line enters or leaves a zone the boundary is traced, unless it
!! is known.
module vi_zone
   use vi_borders, only: distances, is_on_closed_loop, is_own_way_back, most_loops, &
      open_curves_type, trace_border, zone_type
   use vi_conditions, only: all_conditions, condition_count
   use vi_curve, only: correct, curve_type, parameters_of
   use vi_join, only: join_loose_ends, set_apart
   use vi_kinds, only: wp
   use vi_lattice, only: even_lattice, lattice_type, nearest_lines, new_lattice
   use vi_motion_family, only: condition_type, edge, repeats, repetition, searched_type
   use vi_net, only: add_seed, border_type, cover, cover_from, follow_both, net_type, new_net, &
      reach_border
   use vi_net_line, only: line_of, start_type
   use vi_orbit, only: by_clearance, by_left, by_r, by_right, n_parameters
   use vi_outline, only: ring_of, zone_side
   use vi_rings, only: winding
   use vi_pattern, only: pattern_type
   use vi_releases, only: most_simulations, release_type, simulate_releases, simulate_return
   use vi_repetition_vertices, only: leave_repetition, move_to_repetition
   use vi_zone_request, only: is_neutral, make_surface, zone_request_type
   use vi_status, only: stat
   use vi_progress, only: is_stopped, report_share
   implicit none (type, external)
   private

   public :: count_zone, find_zone, place_at_node, release_type, simulate_nodes, zone_around, &
      zone_type

   !> Units of work of one zone in the progress counters.
   integer, parameter, public :: zone_work = 1000

   !> A motion known beforehand.
   type :: seed_type
      !> Unknowns of the family, and its place in the window.
      real(wp), allocatable :: unknowns(:)
      real(wp) :: at(2) = 0
      !> Whether it belongs to the family and lies in the window; whether it is also stable and
      !! admissible; whether it could be continued to a node of the lattice.
      logical :: there = .false., inside = .false., at_node = .false.
      !> Of a seed inside a zone: the place at which a line from it leaves the zone, and whether the
      !! loop there is closed.
      type(border_type), allocatable :: border
      logical :: enclosed = .false.
   end type seed_type

   !> A simulation at a point of the window, in the units of the lattice.
   type, public :: return_type
      real(wp) :: at(2) = 0
      !> x_i/D and theta_i of all impacts of the period that comes nearest to a motion of the
      !! pattern; empty if none has its sides, not allocated before the simulation.
      real(wp), allocatable :: motion(:)
   end type return_type

   !> Largest distance of a seed, and of a period of a simulation, from a motion of the family.
   real(wp), parameter :: same = 1.0e-3_wp, near = 1.0_wp

contains

   !> All zones of a pattern in a window.
   subroutine find_zone(request, seeds, zone, status, progress, releases, pitchforks, returns, &
      searched)
      !> The request.
      type(zone_request_type), intent(in) :: request
      !> Motions known beforehand, in the whole pattern: r, D, x_i/D, theta_i (2 + 2N, m).
      real(wp), intent(in) :: seeds(:, :)
      !> The loops found; those of a stopped search are incomplete.
      type(zone_type), intent(out) :: zone
      !> `stat%ok`, or `stat%no_motion` if the pattern cannot have such motions.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; a zone that was stopped has untraced borders.
      integer, intent(inout), optional :: progress(3)
      !> Results of `simulate_nodes` for the same lattice; all patterns with rest can share them.
      type(release_type), intent(in), optional :: releases(:, :, :)
      !> The pitchforks that lines of the same lattice meet on the symmetric motions of the pattern.
      !! In: those found in the zone of these motions, if that is known. Out: for a zone of
      !! symmetric motions, those found.
      type(start_type), allocatable, intent(inout), optional :: pitchforks(:)
      !> Simulations in the window, which all families of the pattern share; some are added.
      type(return_type), allocatable, intent(inout), optional :: returns(:)
      !> As in `search_window`.
      type(searched_type), allocatable, intent(inout), optional :: searched(:, :, :)
      type(net_type) :: net
      type(seed_type), allocatable :: items(:)
      integer :: i, reported

      allocate (items(size(seeds, 2)))
      call make_surface(request, zone%surface, status)
      call make_room(size(items), zone)
      reported = 0
      if (status /= stat%ok .or. is_neutral(request%osc)) then
         call report_share(1.0_wp, zone_work, reported, progress)
         return
      end if
      call new_net(zone%surface, new_lattice(request%lines, [request%r, log(request%clearance)], &
         zone%surface%scale), net, request%symmetric .and. present(pitchforks))
      zone%lines = shape(net%head)
      do i = 1, size(items)
         call prepare_seed(net, [seeds(1, i), log(seeds(2, i))], seeds(3:, i), items(i))
      end do
      call cover(net, 1, progress)
      ! gfortran evaluates the bounds of an absent array that is passed on
      if (present(releases)) then
         call search(request, net, reported, progress, pitchforks, releases)
      else
         call search(request, net, reported, progress, pitchforks, searched=searched)
      end if
      if (present(returns) .and. request%simulations > 0) call search_by_simulation(request, net, &
         items, returns, progress)
      if (request%symmetric .and. present(pitchforks)) pitchforks = net%flips(:net%n_flips)
      call finish(request, net, items, zone, reported, progress)
   end subroutine find_zone

   !> The zones on the surface of motions that a known motion belongs to.
   subroutine zone_around(request, surface, point, zone, progress)
      !> The request: its window, lines and points are used.
      type(zone_request_type), intent(in) :: request
      !> The surface over the window, and the known motion on it.
      type(curve_type), intent(in) :: surface
      real(wp), intent(in) :: point(:)
      !> The loops found; those of a stopped search are incomplete.
      type(zone_type), intent(out) :: zone
      !> Progress counters, see vi_progress; a zone that was stopped has untraced borders.
      integer, intent(inout), optional :: progress(3)
      type(net_type) :: net
      type(seed_type) :: items(1)
      integer :: n, reported

      zone%surface = surface
      call make_room(1, zone)
      reported = 0
      call new_net(surface, even_lattice(request%lines), net, .false.)
      zone%lines = shape(net%head)
      n = size(point) - 2
      items(1)%at = point(n + 1:)
      items(1)%unknowns = point(:n)
      call place_at_node(net, items(1)%at, point(:n), nearest_lines(net%lines, items(1)%at), &
         items(1)%at_node)
      call cover(net, 1, progress)
      call report_share(0.5_wp, zone_work, reported, progress)
      call finish(request, net, items, zone, reported, progress)
   end subroutine zone_around

   !> Makes room for the loops of a zone.
   pure subroutine make_room(seeds, zone)
      !> Number of seeds.
      integer, intent(in) :: seeds
      !> In and out: with room.
      type(zone_type), intent(inout) :: zone

      allocate (zone%loops(most_loops))
      allocate (zone%open_seeds(seeds), zone%used_seeds(seeds), source=.false.)
   end subroutine make_room

   !> Traces the boundaries of a net, and completes the zone.
   subroutine finish(request, net, items, zone, reported, progress)
      !> The request.
      type(zone_request_type), intent(in) :: request
      !> In and out: the net.
      type(net_type), intent(inout) :: net
      !> In and out: the seeds.
      type(seed_type), intent(inout) :: items(:)
      !> In and out: the zone, complete.
      type(zone_type), intent(inout) :: zone
      !> Units of work reported so far; in and out.
      integer, intent(inout) :: reported
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      integer :: i

      call trace_borders(request, net, items, zone, reported, progress)
      zone%nodes = net%n
      zone%steps = net%steps
      do i = 1, size(items)
         if (items(i)%enclosed) cycle
         if (zone%surface%family%jumps) items(i)%enclosed = is_enclosed(request, zone, items(i))
         ! curves have been joined
         if (allocated(items(i)%border)) items(i)%enclosed = items(i)%enclosed .or. &
            is_on_closed_loop(items(i)%border, zone)
      end do
      do i = 1, zone%n
         associate (loop => zone%loops(i))
            ! a loop that was closed by a joint
            if (loop%closed .and. loop%side == 0) loop%side = zone_side(zone%surface, loop)
            call move_to_repetition(zone%surface, loop)
         end associate
      end do
      associate (open => items%inside .and. .not. items%enclosed, n => size(zone%open_seeds))
         zone%open_seeds = open(:n)
         zone%used_seeds = items(:n)%there .or. items(:n)%at_node
         ! a motion that a simulation showed
         zone%untraced = zone%untraced + count(open(n + 1:))
      end associate
      if (is_stopped(progress)) zone%untraced = zone%untraced + 1
      if (net%full) zone%untraced = zone%untraced + 1
      call report_share(1.0_wp, zone_work, reported, progress)
   end subroutine finish

   !> Traces the boundary from all places found on it; then also from where lines from the seeds
   !! leave their zones. Where such a line meets a boundary that was not known, the lines through
   !! that seed are followed as well.
   subroutine trace_borders(request, net, seeds, zone, reported, progress)
      !> The request.
      type(zone_request_type), intent(in) :: request
      !> In and out: the net; the lines through seeds are added.
      type(net_type), intent(inout) :: net
      !> In and out: what is known of the seeds.
      type(seed_type), intent(inout) :: seeds(:)
      !> In and out: loops are added.
      type(zone_type), intent(inout) :: zone
      !> Units of work reported so far; in and out.
      integer, intent(inout) :: reported
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(open_curves_type) :: tried
      logical, allocatable :: is_open(:)
      logical :: closed, jumps, known
      integer :: i, first, pass

      allocate (is_open(0), tried%curves%loops(most_loops))
      tried%curves%surface = zone%surface
      jumps = net%surface%family%jumps
      call trace_further()
      ! lines through seeds would not close what ends where motions with rest jump
      if (jumps) call keep_open(request, net, is_open, zone, progress)
      do i = 1, size(seeds)
         if (jumps) seeds(i)%enclosed = is_enclosed(request, zone, seeds(i))
         if (seeds(i)%enclosed) cycle
         if (.not. seeds(i)%there) call examine(net, seeds(i), same)
         if (.not. seeds(i)%there .or. (seeds(i)%at_node .and. .not. seeds(i)%inside)) cycle
         if (seeds(i)%inside) then
            first = net%n_borders + 1
            call reach_border(net, seeds(i)%at, seeds(i)%unknowns, progress)
            if (net%n_borders >= first) then
               seeds(i)%border = net%borders(first)
               known = is_on_closed_loop(seeds(i)%border, zone)
               call trace_further()
               seeds(i)%enclosed = .not. is_open(first)
               if (known) cycle
            end if
         end if
         ! a simulation has only passed by a motion that is not stable or not admissible
         call cover_from(net, seeds(i)%at, seeds(i)%unknowns, progress, passing=.not. &
            seeds(i)%inside .and. i > size(zone%open_seeds))
         call trace_further()
      end do
      if (jumps) then
         call keep_open(request, net, is_open, zone, progress)
         return
      end if
      if (size(net%surface%family%repetitions) > 0) then
         do pass = 2, size(distances)
            do i = 1, net%n_borders
               if (.not. is_open(i)) cycle
               if (is_stopped(progress)) exit
               call trace_border(net%borders(i), distances(pass)*net%surface%family%apart, &
                  request%points, .false., zone, closed, progress)
               is_open(i) = .not. closed
            end do
         end do
      end if
      call keep_open(request, net, is_open, zone, progress)

   contains

      !> Traces the boundary from the places that have been added.
      subroutine trace_further()
         integer :: j, n

         n = size(is_open)
         is_open = [is_open, [(.true., j=n + 1, net%n_borders)]]
         do j = n + 1, net%n_borders
            if (is_stopped(progress)) return
            call trace_border(net%borders(j), net%surface%family%apart, request%points, .false., &
               zone, closed, progress, tried)
            is_open(j) = .not. closed
            if (n == 0) call report_share(0.5_wp + 0.5_wp*j/net%n_borders, zone_work, reported, &
               progress)
         end do
      end subroutine trace_further
   end subroutine trace_borders

   !> Keeps boundaries that cannot be closed. Their loose ends are joined; those of motions with
   !! rest are set apart.
   subroutine keep_open(request, net, is_open, zone, progress)
      !> The request.
      type(zone_request_type), intent(in) :: request
      !> The net.
      type(net_type), intent(in) :: net
      !> Whether each place on the boundary is on no closed loop.
      logical, intent(in) :: is_open(:)
      !> In and out: loops are added.
      type(zone_type), intent(inout) :: zone
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      logical :: closed
      integer :: before, i

      before = zone%n
      do i = 1, size(is_open)
         if (.not. is_open(i)) cycle
         if (is_stopped(progress)) exit
         call trace_border(net%borders(i), net%surface%family%apart, request%points, .true., zone, &
            closed, progress)
      end do
      if (zone%n == before) return
      call join_loose_ends(zone)
      if (.not. net%surface%family%jumps) return
      call set_apart(zone, net%borders(:size(is_open)), is_open, request%points, progress)
      do i = 1, zone%n
         ! a joint may have closed a curve that has turned round
         zone%loops(i)%closed = zone%loops(i)%closed .and. .not. is_own_way_back(zone%loops(i))
      end do
   end subroutine keep_open

   !> Whether closed loops enclose a seed. Those of a zone with rest may be parts of it, with a
   !! border that no line from the seed meets.
   pure logical function is_enclosed(request, zone, seed)
      !> The request; its window is used.
      type(zone_request_type), intent(in) :: request
      !> The loops.
      type(zone_type), intent(in) :: zone
      !> The seed.
      type(seed_type), intent(in) :: seed
      real(wp), allocatable :: ring(:, :)
      real(wp) :: point(2, 1)
      integer :: turns(1), i

      point(:, 1) = zone%surface%origin + zone%surface%scale*seed%at
      point(2, 1) = exp(point(2, 1))
      turns = 0
      do i = 1, zone%n
         if (.not. zone%loops(i)%closed) cycle
         call ring_of(zone%surface, zone%loops(i), request%r, request%clearance, ring)
         turns = turns + winding(ring, point)
      end do
      is_enclosed = turns(1) > 0
   end function is_enclosed

   !> Searches for motions at the nodes of the lattice and follows the surface on which they lie.
   !!
   !! The first pass takes every second node in each direction with all guesses; the second pass
   !! takes the other nodes with few guesses, since near resonance motions may exist on a strip of
   !! the window that the first pass misses. Motions with rest are found by simulation; if none is
   !! found, the second pass simulates longer at a few nodes, since with little damping the first
   !! one ends long before the motion is reached.
   subroutine search_window(request, net, reported, progress, releases, symmetric, searched)
      !> The request.
      type(zone_request_type), intent(in) :: request
      !> In and out: nodes and borders are added.
      type(net_type), intent(inout) :: net
      !> Units of work reported so far; in and out.
      integer, intent(inout) :: reported
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> (simulations, r, D) of `simulate_nodes`.
      type(release_type), intent(in), optional :: releases(:, :, :)
      !> In and out: the net of the symmetric motions of the pattern, to which the guesses lead too.
      type(net_type), intent(inout), optional :: symmetric
      !> (r, D, pass) The motions found from guesses in the same lattice, which all families of the
      !! pattern share; those that are missing are added.
      type(searched_type), allocatable, intent(inout), optional :: searched(:, :, :)
      !> Share of the motions found that lie on parts of the surface not followed so far, from which
      !! further parts are expected.
      real(wp), parameter :: many = 0.05_wp
      real(wp), allocatable :: found(:, :)
      real(wp) :: q(2), c(n_parameters)
      !> How much longer motions with rest are simulated where none was found.
      integer, parameter :: longer = 10
      type(searched_type) :: here
      integer :: i, j, k, all_found(2), guesses, new(2), pass, passes, skip, stride
      logical :: chosen, simulated

      if (present(searched)) then
         if (.not. allocated(searched)) allocate (searched(size(net%head, 1), size(net%head, 2), &
            most_passes(request%pattern)))
      end if
      skip = 0
      all_found = 0
      new = 0
      simulated = net%surface%family%simulated
      ! simulations that are given are not repeated
      passes = merge(1, 2, simulated .and. present(releases))
      stride = 2
      pass = 0
      do while (pass < passes)
         pass = pass + 1
         if (simulated .and. pass == 2) then
            ! with little damping, simulations reach the motions late
            if (net%n > 0) exit
            stride = 4
         end if
         guesses = merge(request%guesses, request%guesses/4, mod(pass, 2) == 1 .or. simulated)
         do j = 1, size(net%lines%axes(2)%at)
            do i = 1, size(net%lines%axes(1)%at)
               chosen = mod(i, stride) == 1 .and. mod(j, stride) == 1
               if (chosen .neqv. (mod(pass, 2) == 1 .or. simulated)) cycle
               q = [net%lines%axes(1)%at(i), net%lines%axes(2)%at(j)]
               c = parameters_of(net%surface, [(0.0_wp, k=1, size(net%unknowns, 1)), q])
               if (present(searched)) call move_alloc(searched(i, j, pass)%motions, here%motions)
               if (present(releases)) then
                  call net%surface%family%motions_at(c, guesses, skip, found, &
                     releases(:, i, j), progress)
               else
                  call net%surface%family%motions_at(c, guesses, skip, found, progress=progress, &
                     longer=merge(longer, 1, simulated .and. pass == 2), searched=here)
               end if
               if (present(searched)) then
                  call move_alloc(here%motions, searched(i, j, pass)%motions)
               else if (allocated(here%motions)) then
                  deallocate (here%motions)
               end if
               skip = skip + guesses
               call add_found(net, found, [i, j], all_found(1), new(1), progress)
               if (present(symmetric)) call add_found(symmetric, reshape([( &
                  symmetric%surface%family%part_of(c, net%surface%family%whole_of(found(:, k))), &
                  k=1, size(found, 2))], [size(symmetric%unknowns, 1), size(found, 2)]), [i, j], &
                  all_found(2), new(2), progress)
               if (is_stopped(progress)) return
            end do
            call report_share(0.5_wp*(pass - 1 + j/real(size(net%head, 2), wp))/passes, zone_work, &
               reported, progress)
         end do
         ! the more impacts, the fewer guesses lead to a motion
         if (simulated .or. pass == 1 .or. all(new < many*all_found)) cycle
         if (all(new == 0) .and. request%simulations == 0) cycle
         passes = min(pass + 1, most_passes(request%pattern))
      end do
   end subroutine search_window

   !> Largest number of passes of a search from guesses.
   pure integer function most_passes(pattern)
      !> The pattern.
      type(pattern_type), intent(in) :: pattern

      most_passes = max(2, size(pattern%sides)/2)
   end function most_passes

   !> Adds motions found at a node of the lattice, and covers the surface from there.
   subroutine add_found(net, found, place, all_found, new, progress)
      !> In and out: nodes and borders are added.
      type(net_type), intent(inout) :: net
      !> (unknowns, m) The motions, or guesses of them.
      real(wp), intent(in) :: found(:, :)
      !> Numbers of the lattice lines of the node.
      integer, intent(in) :: place(2)
      !> In and out: numbers of all motions found, and of those that were no nodes yet.
      integer, intent(inout) :: all_found, new
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      integer :: first, i, k
      logical :: at_node

      first = net%n + 1
      do k = 1, size(found, 2)
         call place_at_node(net, [(net%lines%axes(i)%at(place(i)), i=1, 2)], found(:, k), place, &
            at_node)
         if (at_node) all_found = all_found + 1
      end do
      new = new + net%n - first + 1
      call cover(net, first, progress)
   end subroutine add_found

   !> Searches for motions by simulation at points spread evenly over the lattice.
   !!
   !! As long as a simulation shows a motion that the net does not have, there are more of them.
   subroutine search_by_simulation(request, net, items, returns, progress)
      !> The request.
      type(zone_request_type), intent(in) :: request
      !> In and out: nodes and borders are added.
      type(net_type), intent(inout) :: net
      !> In and out: the motions shown are added.
      type(seed_type), allocatable, intent(inout) :: items(:)
      !> In and out: those that are missing are added; not allocated if there are none.
      type(return_type), allocatable, intent(inout) :: returns(:)
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> Factor of the number of simulations, and most of them over the number at first.
      integer, parameter :: growth = 3, most = 9
      type(seed_type) :: seed
      real(wp) :: c(n_parameters)
      integer :: first, i, j, k, wanted
      logical :: is_new

      if (.not. allocated(returns)) allocate (returns(most*request%simulations))
      c = net%surface%c
      wanted = request%simulations
      i = 0
      do while (wanted <= size(returns))
         is_new = .false.
         do while (i < wanted)
            i = i + 1
            if (.not. allocated(returns(i)%motion)) then
               if (is_stopped(progress)) return
               returns(i)%at = [(lattice_place(net%lines%axes(j)%at, i, j), j=1, 2)]
               c = parameters_of(net%surface, [(0.0_wp, k=1, size(net%unknowns, 1)), &
                  returns(i)%at])
               call simulate_return(request%pattern, abs(c(by_right) - c(by_left)) <= 0, c, i, &
                  returns(i)%motion, progress)
            end if
            if (size(returns(i)%motion) == 0) cycle
            first = net%n + 1
            seed = seed_type(at=returns(i)%at, unknowns=net%surface%family%part_of(c, &
               returns(i)%motion))
            call examine(net, seed, near)
            if (.not. seed%there) cycle
            call place_at_node(net, seed%at, seed%unknowns, nearest_lines(net%lines, seed%at), &
               seed%at_node)
            items = [items, seed]
            is_new = is_new .or. net%n >= first
            call cover(net, first, progress)
         end do
         if (.not. is_new .and. net%n > size(net%head)/2) return
         wanted = growth*wanted
      end do
   end subroutine search_by_simulation

   !> A coordinate of point number i of a sequence that fills the lattice evenly.
   pure real(wp) function lattice_place(at, i, j) result(place)
      !> Coordinates of the lattice lines.
      real(wp), intent(in) :: at(:)
      !> Number of the point, and of the coordinate (1 or 2).
      integer, intent(in) :: i, j
      real(wp), parameter :: golden = 1.324717957244746_wp
      real(wp) :: share
      integer :: k

      share = modulo(0.5_wp + i/golden**j, 1.0_wp)*(size(at) - 1)
      k = min(int(share), size(at) - 2)
      place = at(k + 1) + (share - k)*(at(k + 2) - at(k + 1))
   end function lattice_place

   !> Searches the window, then follows the surface from every flip and pitchfork at which motions
   !! of the pattern begin, on the lattice lines of the motions that repeat themselves.
   recursive subroutine search(request, net, reported, progress, pitchforks, releases, searched)
      !> The request.
      type(zone_request_type), intent(in) :: request
      !> In and out: nodes and borders are added.
      type(net_type), intent(inout) :: net
      !> Units of work reported so far; in and out.
      integer, intent(inout) :: reported
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> The pitchforks of the symmetric motions, if they are known.
      type(start_type), allocatable, intent(in), optional :: pitchforks(:)
      !> (simulations, r, D) of `simulate_nodes`.
      type(release_type), intent(in), optional :: releases(:, :, :)
      !> As in `search_window`.
      type(searched_type), allocatable, intent(inout), optional :: searched(:, :, :)
      type(zone_request_type) :: shorter
      type(net_type), allocatable :: of_shorter
      integer :: done, i
      logical :: known, shared

      known = present(pitchforks)
      if (known) known = allocated(pitchforks)
      ! the progress of these searches is not reported
      done = zone_work
      associate (ways => net%surface%family%repetitions)
         shared = size(ways) > 0 .and. .not. known
         if (shared) shared = ways(1)%sign < 0
         if (shared) then
            call begin_shorter(1)
            call search_window(request, net, reported, progress, symmetric=of_shorter)
         else if (present(releases)) then
            call search_window(request, net, reported, progress, releases)
         else
            call search_window(request, net, reported, progress, searched=searched)
         end if
         do i = 1, size(ways)
            ! other multipliers of the shorter period than -1 start no motions of this pattern
            if (.not. ways(i)%halves) cycle
            if (ways(i)%sign < 0 .and. known) then
               call cover_from_flips(net, i, pitchforks, progress)
               cycle
            end if
            if (ways(i)%sign > 0) then
               call begin_shorter(i)
               call search(shorter, of_shorter, done, progress)
            end if
            call cover_from_flips(net, i, of_shorter%flips(:of_shorter%n_flips), progress)
            net%full = net%full .or. of_shorter%full
            deallocate (of_shorter)
         end do
      end associate

   contains

      !> Begins a net of the motions that repeat themselves in one way, for their flips alone.
      subroutine begin_shorter(which)
         !> Number of the way.
         integer, intent(in) :: which
         type(curve_type) :: surface
         integer :: status

         shorter = request
         associate (way => net%surface%family%repetitions(which))
            shorter%symmetric = way%sign < 0
            if (.not. shorter%symmetric) shorter%pattern = &
               pattern_type(request%pattern%sides(:way%shift), request%pattern%cycles/2)
         end associate
         call make_surface(shorter, surface, status)
         allocate (of_shorter)
         call new_net(surface, net%lines, of_shorter, .true.)
         of_shorter%seeks_borders = .false.
      end subroutine begin_shorter
   end subroutine search

   !> Follows the surface from motions that begin at flips or pitchforks.
   subroutine cover_from_flips(net, which, flips, progress)
      !> In and out: nodes and borders are added.
      type(net_type), intent(inout) :: net
      !> Number of the repetition, and motions that repeat themselves so, each on a lattice line.
      integer, intent(in) :: which
      type(start_type), intent(in) :: flips(:)
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(start_type) :: begin
      type(curve_type) :: line
      real(wp) :: point(size(net%unknowns, 1) + 1)
      integer :: direction, first, i
      logical :: good

      first = net%n + 1
      do i = 1, size(flips)
         if (is_stopped(progress)) return
         begin = flips(i)
         direction = merge(1, 2, begin%lattice(1) == 0)
         call line_of(net%surface, begin, direction, line)
         call leave_repetition(line, which, begin%unknowns, begin%at(direction), point, good)
         if (.not. good) cycle
         begin%unknowns = point(:size(point) - 1)
         begin%at(direction) = point(size(point))
         call follow_both(net, begin, direction, progress)
      end do
      call cover(net, first, progress)
   end subroutine cover_from_flips

   !> The simulations at the nodes of the lattice for patterns with rest.
   subroutine simulate_nodes(request, longest, threads, releases, places, progress)
      !> The request; its window and lattice are used.
      type(zone_request_type), intent(in) :: request
      !> Symbols and load cycles of the longest period sought at the end of a simulation.
      integer, intent(in) :: longest(2)
      !> Number of OpenMP threads; each column of nodes is a task.
      integer, intent(in) :: threads
      !> (simulations, r, D)
      type(release_type), allocatable, intent(out) :: releases(:, :, :)
      !> (2, r, D): r and D of the nodes.
      real(wp), allocatable, intent(out) :: places(:, :, :)
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(curve_type) :: surface
      real(wp) :: c(n_parameters)
      type(lattice_type) :: lines
      integer :: i, j, k, n(2), status

      call make_surface(request, surface, status)
      lines = new_lattice(request%lines, [request%r, log(request%clearance)], surface%scale)
      n = [size(lines%axes(1)%at), size(lines%axes(2)%at)]
      allocate (releases(min(request%guesses, most_simulations), n(1), n(2)), places(2, n(1), n(2)))
      !$omp parallel do schedule(dynamic, 1) num_threads(threads) private(i, k, c)
      do j = 1, n(2)
         do i = 1, n(1)
            c = parameters_of(surface, [(0.0_wp, k=1, surface%family%unknown_count()), &
               lines%axes(1)%at(i), lines%axes(2)%at(j)])
            places(:, i, j) = [c(by_r), exp(c(by_clearance))]
            if (is_stopped(progress)) exit
            call simulate_releases(c, releases(:, i, j), longest, progress)
         end do
      end do
      !$omp end parallel do
   end subroutine simulate_nodes

   !> Prepares a seed, and adds it as a node of the lattice if that is possible.
   pure subroutine prepare_seed(net, place, whole, seed)
      !> In and out: the seed is added.
      type(net_type), intent(inout) :: net
      !> r and log D, and the unknowns in the whole pattern.
      real(wp), intent(in) :: place(2), whole(:)
      !> The seed.
      type(seed_type), intent(out) :: seed
      integer :: i

      seed%at = (place - net%surface%origin)/net%surface%scale
      seed%unknowns = net%surface%family%part_of(parameters_of(net%surface, &
         [(0.0_wp, i=1, net%surface%family%unknown_count()), seed%at]), whole)
      call place_at_node(net, seed%at, seed%unknowns, nearest_lines(net%lines, seed%at), &
         seed%at_node)
   end subroutine prepare_seed

   !> Computes the motion of a seed at its own place: whether it belongs to the family and is inside
   !! a zone.
   pure subroutine examine(net, seed, reach)
      !> The net.
      type(net_type), intent(in) :: net
      !> In and out: `there`, `inside` and the unknowns are set.
      type(seed_type), intent(inout) :: seed
      !> Its largest distance from the motion.
      real(wp), intent(in) :: reach
      type(condition_type) :: conditions(condition_count(net%surface))
      real(wp) :: point(size(seed%unknowns) + 2), values(size(conditions)), place(2)
      integer :: i, n, iterations

      associate (surface => net%surface)
         place = surface%origin + surface%scale*seed%at
         if (any(seed%at < 0) .or. any(place > surface%edges([2, 4])%bound)) return
         n = size(seed%unknowns)
         point = [seed%unknowns, seed%at]
         call correct(surface, [(condition_type(edge, i, 1, bound=place(i)), i=1, 2)], point, &
            iterations)
         if (iterations == 0) return
         if (maxval(abs(point(:n) - seed%unknowns)) > reach) return
         if (repeats(net%surface%family, point(:n), 1.0e-6_wp)) return
         seed%there = .true.
         seed%unknowns = point(:n)
         call all_conditions(surface, point(:n), parameters_of(surface, point), values, &
            conditions)
         seed%inside = all(values > 0 .or. conditions%kind == repetition)
      end associate
   end subroutine examine

   !> Continues a motion to a node of the lattice and adds it there, if it belongs to the family.
   pure subroutine place_at_node(net, from, unknowns, place, at_node)
      !> In and out: the node is added.
      type(net_type), intent(inout) :: net
      !> Place in the window at which it is known.
      real(wp), intent(in) :: from(2)
      !> Unknowns of the motion.
      real(wp), intent(in) :: unknowns(:)
      !> Numbers of the lattice lines of the node.
      integer, intent(in) :: place(2)
      !> Whether it is a node now.
      logical, intent(out) :: at_node
      real(wp) :: point(size(unknowns) + 2), q(2)
      type(condition_type) :: fixed(2)
      integer :: n, i, iterations, node, part, parts

      at_node = .false.
      if (any(place < 1) .or. any(place > shape(net%head))) return
      n = size(unknowns)
      q = [net%lines%axes(1)%at(place(1)), net%lines%axes(2)%at(place(2))]
      point(:n) = unknowns
      parts = merge(1, 4, all(abs(q - from) <= 0))
      do part = 1, parts
         point(n + 1:) = from + (q - from)*part/parts
         fixed = [(condition_type(edge, i, 1, bound=net%surface%origin(i) &
            + net%surface%scale(i)*point(n + i)), i=1, 2)]
         call correct(net%surface, fixed, point, iterations)
         if (iterations == 0) return
      end do
      if (repeats(net%surface%family, point(:n), 10*net%surface%family%apart)) return
      call add_seed(net, place(1), place(2), point(:n), node)
      at_node = node > 0
   end subroutine place_at_node

   !> Number of stable, admissible motions at each point.
   pure function count_zone(zone, r, clearance, points) result(counts)
      !> The loops; only closed ones count.
      type(zone_type), intent(in) :: zone
      !> The window.
      real(wp), intent(in) :: r(2), clearance(2)
      !> (2, m): r, D
      real(wp), intent(in) :: points(:, :)
      integer :: counts(size(points, 2))
      real(wp), allocatable :: ring(:, :)
      integer :: i

      counts = 0
      do i = 1, zone%n
         if (.not. zone%loops(i)%closed) cycle
         call ring_of(zone%surface, zone%loops(i), r, clearance, ring)
         counts = counts + winding(ring, points)
      end do
   end function count_zone

end module vi_zone
