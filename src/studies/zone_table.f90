!> Zones as plain arrays: the vertices of all loops, one after the other.
module vi_zone_table
   use vi_curve, only: curve_type
   use vi_family, only: whole_unknowns
   use vi_kinds, only: wp
   use vi_loop, only: loop_type
   use vi_outline, only: ring_of, vertices_of
   use vi_rings, only: winding
   use vi_sheet, only: zone_request_type
   use vi_status, only: stat
   use vi_tally, only: add_sight
   use vi_zone, only: find_zone, zone_type, zone_work
   implicit none (type, external)
   private

   public :: append_zone, count_zone, zone_arrays

contains

   !> `find_zone` between arrays.
   subroutine zone_arrays(request, seeds, vertices, unknowns, labels, n, loops, inside, &
      n_loops, open_seeds, work, status, tally)
      type(zone_request_type), intent(in) :: request
      real(wp), intent(in) :: seeds(:, :)
      !> (5, room): r, D, the derivatives of r and log D by the length of the curve, and its length
      !> to the next vertex of the loop.
      real(wp), intent(out) :: vertices(:, :)
      !> (2N, room): x_i/D and theta_i; with rest phase and velocity over D at the last release.
      real(wp), intent(out) :: unknowns(:, :)
      !> (4, room): kind of the condition from here on, its index, its side, and
      !> at a corner 1 (a piece ends) or 2 (one begins).
      integer, intent(out) :: labels(:, :)
      !> Vertices.
      integer, intent(out) :: n
      !> (2, room of loops): vertices of each loop, 1 if it is closed.
      integer, intent(out) :: loops(:, :)
      !> (2, room of loops): r, D of a point inside beside the loop.
      real(wp), intent(out) :: inside(:, :)
      integer, intent(out) :: n_loops
      !> (m) 1 for each seed that is stable and admissible in the window, and around which no
      !! boundary could be closed.
      integer, intent(out) :: open_seeds(:)
      !> Motions found, steps of the net, borders left untraced, lattice lines of constant r and D.
      integer, intent(out) :: work(5)
      !> `stat%more_events` if there was no room for all.
      integer, intent(out) :: status
      !> As of vi_tally, in units of `zone_work`.
      integer, intent(inout), optional :: tally(3)
      type(zone_type) :: zone

      call add_sight(zone_work, tally)
      vertices = 0
      unknowns = 0
      labels = 0
      loops = 0
      inside = 0
      n = 0
      n_loops = 0
      open_seeds = 0
      work = 0
      call find_zone(request, seeds, zone, status, tally)
      if (status /= stat%ok) return
      work = [zone%nodes, zone%steps, zone%untraced, zone%lines]
      open_seeds = merge(1, 0, zone%open_seeds)
      call append_zone(zone, vertices, unknowns, labels, n, loops, inside, n_loops, status)
   end subroutine zone_arrays

   !> Writes the loops of a zone after those that are there already; contents as of `zone_arrays`.
   pure subroutine append_zone(zone, vertices, unknowns, labels, n, loops, inside, n_loops, status)
      type(zone_type), intent(in) :: zone
      real(wp), intent(inout) :: vertices(:, :)
      !> As many rows as the pattern has unknowns, or more.
      real(wp), intent(inout) :: unknowns(:, :)
      integer, intent(inout) :: labels(:, :)
      !> Vertices written so far.
      integer, intent(inout) :: n
      integer, intent(inout) :: loops(:, :)
      real(wp), intent(inout) :: inside(:, :)
      !> Loops written so far.
      integer, intent(inout) :: n_loops
      !> `stat%more_events` if there was no room for all.
      integer, intent(out) :: status
      integer :: i

      status = stat%ok
      do i = 1, zone%n
         associate (loop => zone%loops(i), sheet => zone%sheet)
            if (n + loop%n > size(vertices, 2) .or. n_loops == size(loops, 2)) then
               status = stat%more_events
               return
            end if
            n_loops = n_loops + 1
            loops(:, n_loops) = [loop%n, merge(1, 0, loop%closed)]
            inside(:, n_loops) = inside_of(zone, i)
            call write_loop(sheet, loop, vertices(:, n + 1:n + loop%n), &
               unknowns(:, n + 1:n + loop%n), labels(:, n + 1:n + loop%n))
            n = n + loop%n
         end associate
      end do
   end subroutine append_zone

   pure subroutine write_loop(sheet, loop, vertices, unknowns, labels)
      type(curve_type), intent(in) :: sheet
      type(loop_type), intent(in) :: loop
      real(wp), intent(inout) :: vertices(:, :), unknowns(:, :)
      integer, intent(inout) :: labels(:, :)
      real(wp), allocatable :: whole(:)
      integer :: j, m

      m = size(loop%points, 1) - 2
      vertices = vertices_of(sheet, loop)
      do j = 1, loop%n
         if (sheet%frame%resting) then
            unknowns(:2, j) = [loop%points(1, j), sinh(loop%points(2, j))]
         else
            whole = whole_unknowns(sheet%frame%family, loop%points(:m, j))
            unknowns(:size(whole), j) = whole
         end if
         labels(:, j) = [loop%conditions(j)%kind, loop%conditions(j)%index, &
            loop%conditions(j)%side, loop%corner(j)]
      end do
   end subroutine write_loop

   !> A point inside, beside a loop: r, D.
   pure function inside_of(zone, i) result(point)
      type(zone_type), intent(in) :: zone
      integer, intent(in) :: i
      real(wp) :: point(2)

      point = zone%sheet%origin + zone%sheet%scale*zone%inside(:, i)
      point(2) = exp(point(2))
   end function inside_of

   !> How many stable, admissible motions there are at points.
   pure function count_zone(zone, r, clearance, points) result(counts)
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
         call ring_of(zone%sheet, zone%loops(i), zone%inside(:, i), r, clearance, ring)
         counts = counts + winding(ring, points)
      end do
   end function count_zone

end module vi_zone_table
