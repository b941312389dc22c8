!> Loops over the surface of motions as curves in the plane (r, D).
module vi_outline
   use vi_curve, only: curve_type
   use vi_frame, only: wrap_phases
   use vi_kinds, only: wp
   use vi_loop, only: loop_type
   use vi_rings, only: dense_ring
   implicit none (type, external)
   private

   public :: ring_of, vertices_of

contains

   !> (5, n): r, D, the derivatives of r and log D with respect to the length of the curve, and the
   !! length to the next vertex.
   pure function vertices_of(surface, loop) result(vertices)
      !> The surface of motions over the window.
      type(curve_type), intent(in) :: surface
      !> The loop.
      type(loop_type), intent(in) :: loop
      real(wp) :: vertices(5, loop%n)
      integer :: j, m

      m = size(loop%points, 1) - 2
      do j = 1, loop%n
         vertices(:2, j) = surface%origin + surface%scale*loop%points(m + 1:, j)
         vertices(2, j) = exp(vertices(2, j))
         vertices(3:4, j) = surface%scale*loop%tangents(m + 1:, j)
         vertices(5, j) = arc(surface, loop, j)
      end do
   end function vertices_of

   !> A closed loop as a polygon, counter-clockwise around a zone and clockwise around a hole.
   pure subroutine ring_of(surface, loop, inside, r, clearance, ring)
      !> The surface of motions over the window.
      type(curve_type), intent(in) :: surface
      !> The loop.
      type(loop_type), intent(in) :: loop
      !> A point inside, close to the loop, in the units of the surface.
      real(wp), intent(in) :: inside(2)
      !> The window.
      real(wp), intent(in) :: r(2), clearance(2)
      !> (2, n): r, D
      real(wp), allocatable, intent(out) :: ring(:, :)
      real(wp) :: place(2)

      place = surface%origin + surface%scale*inside
      call dense_ring(vertices_of(surface, loop), r, clearance, [place(1), exp(place(2))], ring)
   end subroutine ring_of

   !> Length of a loop from a vertex to the next, to fourth order.
   pure real(wp) function arc(surface, loop, j) result(length)
      !> The surface of motions over the window.
      type(curve_type), intent(in) :: surface
      !> The loop.
      type(loop_type), intent(in) :: loop
      !> Number of the vertex.
      integer, intent(in) :: j
      real(wp) :: chord(size(loop%points, 1)), cosine
      integer :: next

      next = merge(1, j + 1, j == loop%n)
      chord = loop%points(:, next) - loop%points(:, j)
      call wrap_phases(surface%frame, chord)
      length = norm2(chord)
      if (.not. length > 0) return
      cosine = dot_product(chord, loop%tangents(:, j))/length
      length = length*(2 + 1/max(0.5_wp, cosine))/3
   end function arc

end module vi_outline
