!> Loops over the surface of motions as curves in the plane (r, D).
module vi_outline
   use vi_curve, only: curve_type, equations
   use vi_kinds, only: wp
   use vi_linear, only: eliminate, most
   use vi_loop, only: loop_type
   use vi_motion_family, only: fold, joint
   use vi_rings, only: dense_ring
   implicit none (type, external)
   private

   public :: ring_of, vertices_of, zone_side

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
   pure subroutine ring_of(surface, loop, r, clearance, ring)
      !> The surface of motions over the window.
      type(curve_type), intent(in) :: surface
      !> The loop, closed.
      type(loop_type), intent(in) :: loop
      !> The window.
      real(wp), intent(in) :: r(2), clearance(2)
      !> (2, n): r, D
      real(wp), allocatable, intent(out) :: ring(:, :)

      call dense_ring(vertices_of(surface, loop), r, clearance, loop%side, ring)
   end subroutine ring_of

   !> On which side of a loop its zone lies, as in `loop_type`.
   !!
   !! On the surface, the condition that is zero along the loop increases towards the zone. Nowhere
   !! in the zone does the surface fold over, so a few vertices decide this for the whole loop.
   pure integer function zone_side(surface, loop) result(side)
      !> The surface of motions over the window.
      type(curve_type), intent(in) :: surface
      !> The loop as traced: vertices at motions that repeat themselves have not been moved there.
      type(loop_type), intent(in) :: loop
      integer, parameter :: enough = 24
      integer :: j

      side = 0
      do j = 1, loop%n, max(1, loop%n/enough)
         side = side + side_at(surface, loop, j)
      end do
   end function zone_side

   !> On which side of a loop the zone lies at a vertex: 1 left, -1 right, 0 if that is not known.
   pure integer function side_at(surface, loop, j) result(side)
      !> The surface of motions over the window.
      type(curve_type), intent(in) :: surface
      !> The loop.
      type(loop_type), intent(in) :: loop
      !> Number of the vertex.
      integer, intent(in) :: j
      !> At a fold the projection of the surface is singular; it is examined this far inside.
      real(wp), parameter :: inwards = 1.0e-4_wp
      real(wp), dimension(size(loop%points, 1)) :: place, across, along
      logical :: regular

      side = 0
      if (loop%conditions(j)%kind == joint) return
      place = loop%points(:, j)
      call span_at(surface, loop, j, place, across, along, regular)
      if (regular .and. loop%conditions(j)%kind == fold) then
         place = place + inwards*across/norm2(across)
         call span_at(surface, loop, j, place, across, along, regular)
      end if
      if (.not. regular) return
      associate (m => size(place) - 1)
         side = nint(sign(1.0_wp, along(m)*across(m + 1) - along(m + 1)*across(m)))
      end associate
   end function side_at

   !> Vectors tangent to the surface at a place near a vertex of a loop.
   pure subroutine span_at(surface, loop, j, place, across, along, regular)
      !> The surface of motions over the window.
      type(curve_type), intent(in) :: surface
      !> The loop.
      type(loop_type), intent(in) :: loop
      !> Number of the vertex.
      integer, intent(in) :: j
      !> The place.
      real(wp), intent(in) :: place(:)
      !> Across the loop towards the zone, and along the loop.
      real(wp), intent(out) :: across(:), along(:)
      !> Whether they exist.
      logical, intent(out) :: regular
      real(wp) :: a(most, most), b(2, most), unused
      integer :: n

      n = size(place)
      call equations(surface, [loop%conditions(j)], place, b, a)
      a(:n, n) = loop%tangents(:, j)
      b(:, :n) = 0
      b(1, n - 1) = 1
      b(2, n) = 1
      call eliminate(n, a, b, regular, unused)
      across = b(1, :n)
      along = b(2, :n)
      regular = regular .and. all(abs(b(:, :n)) < huge(1.0_wp))
   end subroutine span_at

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
      call surface%family%wrap_phases(chord)
      length = norm2(chord)
      if (.not. length > 0) return
      cosine = dot_product(chord, loop%tangents(:, j))/length
      length = length*(2 + 1/max(0.5_wp, cosine))/3
   end function arc

end module vi_outline
