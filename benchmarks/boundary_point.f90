!> The cost of a point of the traced boundary of a zone.
!!
!! `boundary_point SIDES SYMMETRIC KIND ROUNDS`, say `boundary_point RL 0 2 5`, prints microseconds
!! of CPU per vertex of the loops, where all conditions are checked, per point of the longest
!! piece, where only the condition of that kind is evaluated, and per step
!! of the net; a line for each round. With the name of a file it instead reads points of such a
!! piece from there (u_i, theta_i, r, log D) and prints how far the curve is from them.
program boundary_point
   use vi_curve, only: correct, tangent_at
   use vi_kinds, only: wp
   use vi_loop, only: begins, loop_type
   use vi_lattice, only: new_lattice
   use vi_motion_family, only: condition_type
   use vi_net, only: add_seed, cover, net_type, new_net
   use vi_orbit, only: by_clearance, by_r
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: new_pattern
   use vi_steps, only: begin_walk, exchange, place_type, stride_type, take_step
   use vi_zone_request, only: zone_request_type
   use vi_trace, only: trace_loop
   use vi_zone, only: find_zone, zone_type
   implicit none (type, external)

   type(zone_request_type) :: request
   type(zone_type) :: zone
   character(200) :: text
   type(stride_type), parameter :: stride = stride_type(longest=0.02_wp, turn=0.15_wp)
   integer :: status, kind, rounds, i
   real(wp) :: seeds(0, 0)

   call get_command_argument(1, text)
   request%osc = oscillator_type(0.0114_wp, 0.028_wp, [0.75_wp, 0.75_wp])
   request%pattern = new_pattern(trim(text), 1)
   call get_command_argument(2, text)
   request%symmetric = text == '1'
   request%r = [0.8_wp, 1.2_wp]
   request%clearance = [2.0_wp, 200.0_wp]
   call find_zone(request, seeds, zone, status)
   if (status /= 0 .or. zone%n == 0) error stop 'no zone'
   call get_command_argument(3, text)
   read (text, *) kind
   call get_command_argument(4, text)
   read (text, *) rounds
   if (command_argument_count() > 4) then
      call compare
   else
      do i = 1, rounds
         print '(*(f0.3, 1x))', time_of_loops(), time_of_locus(), time_of_net()
      end do
   end if

contains

   !> Microseconds per vertex of the loops of the zone, traced again.
   real(wp) function time_of_loops() result(time)
      type(loop_type) :: loop
      real(wp) :: begin, end
      integer :: vertices, k, turn

      call cpu_time(begin)
      vertices = 0
      do turn = 1, 5
         do k = 1, zone%n
            call trace_loop(zone%surface, stride, zone%loops(k)%points(:, 1), &
               zone%loops(k)%conditions(1), request%points, 1, loop)
            if (.not. loop%closed) error stop 'a loop that was closed is open'
            vertices = vertices + loop%n
         end do
      end do
      call cpu_time(end)
      time = 1.0e6_wp*(end - begin)/vertices
   end function time_of_loops

   !> Microseconds per point from the middle of the longest piece of a kind to its end.
   real(wp) function time_of_locus() result(time)
      type(place_type) :: now, next
      type(condition_type) :: condition(1)
      real(wp) :: begin, end, clearances(2)
      integer :: points, turn, loop, first, last, m
      logical :: good

      call find_piece(loop, first, last)
      associate (l => zone%loops(loop))
         m = size(l%points, 1)
         condition = l%conditions(first)
         clearances = [minval(l%points(m, first:last)), maxval(l%points(m, first:last))]
         call cpu_time(begin)
         points = 0
         do turn = 1, 200
            call begin_walk(zone%surface, condition, l%points(:, (first + last)/2), &
               l%tangents(:, (first + last)/2), stride%longest, now, good)
            do while (good .and. now%point(m) > clearances(1) .and. now%point(m) < clearances(2))
               call take_step(zone%surface, condition, stride, now, next, good, blind=.true.)
               call exchange(now, next)
               points = points + 1
            end do
            if (.not. good) error stop 'the piece could not be followed'
         end do
         call cpu_time(end)
      end associate
      time = 1.0e6_wp*(end - begin)/points
   end function time_of_locus

   !> The longest run of vertices of one kind: its loop, the first vertex and the last.
   subroutine find_piece(loop, first, last)
      integer, intent(out) :: loop, first, last
      integer :: j, k, begin

      first = 0
      last = -1
      do k = 1, zone%n
         begin = 1
         do j = 1, zone%loops(k)%n
            if (zone%loops(k)%corner(j) == begins) begin = j
            if (zone%loops(k)%conditions(j)%kind /= kind .or. j - begin <= last - first) cycle
            loop = k
            first = begin
            last = j
         end do
      end do
      if (last < 0) error stop 'no such piece'
   end subroutine find_piece

   !> Microseconds per step of a net from the motions at the middle of the window.
   real(wp) function time_of_net() result(time)
      type(net_type) :: net
      real(wp), allocatable :: found(:, :)
      real(wp) :: c(6), begin, end
      integer :: k, m, node

      call new_net(zone%surface, new_lattice(request%lines, [request%r, log(request%clearance)], &
         zone%surface%scale), net, .false.)
      c = zone%surface%c
      m = request%lines/2 + 1
      c([by_r, by_clearance]) = zone%surface%origin + zone%surface%scale*0.5_wp
      call zone%surface%family%motions_at(c, 4*request%guesses, 0, found)
      do k = 1, size(found, 2)
         call add_seed(net, m, m, found(:, k), node)
      end do
      call cpu_time(begin)
      call cover(net, 1)
      call cpu_time(end)
      time = 1.0e6_wp*(end - begin)/net%steps
   end function time_of_net

   !> How far the points of a file are from the curve along which a condition of a kind is zero.
   subroutine compare
      real(wp), allocatable :: point(:), there(:), along(:), tangent(:)
      real(wp) :: farthest
      integer :: unit, iterations, n, ios
      logical :: regular

      call get_command_argument(5, text)
      open (newunit=unit, file=trim(text), status='old', action='read')
      allocate (there(size(zone%loops(1)%points, 1)), along(size(zone%loops(1)%points, 1)), &
         tangent(size(zone%loops(1)%points, 1)))
      farthest = 0
      n = 0
      do
         read (unit, *, iostat=ios) there
         if (ios /= 0) exit
         associate (r => there(size(there) - 1:))
            r = (r - zone%surface%origin)/zone%surface%scale
         end associate
         along = 0
         along(size(along)) = 1
         call tangent_at(zone%surface, [condition_type(kind)], there, along, tangent, regular)
         point = there
         call correct(zone%surface, [condition_type(kind)], point, iterations, tangent)
         if (iterations == 0) error stop 'Newton''s method does not converge'
         farthest = max(farthest, maxval(abs(point - there)))
         n = n + 1
      end do
      close (unit)
      print '(i0, 1x, es9.2)', n, farthest
   end subroutine compare

end program boundary_point
