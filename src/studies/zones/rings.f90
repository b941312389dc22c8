!> Closed curves in the plane (r, D): dense polygons, and their winding numbers.
!!
!! Both are computed in the plane (r, log D).
module vi_rings
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: dense_ring, winding

   !> Largest distance of a polygon from its curve, with the window as the unit square.
   real(wp), parameter :: sag = 1.0e-7_wp

contains

   !> A polygon along a loop, counter-clockwise around a zone and clockwise around a hole.
   !!
   !! Between two vertices the curve is the cubic that has their derivatives.
   pure subroutine dense_ring(vertices, r, clearance, side, ring)
      !> (5, m): r, D, derivatives of r and log D with respect to length, length to the next vertex.
      real(wp), intent(in) :: vertices(:, :)
      !> The window: lowest and highest r, lowest and highest D.
      real(wp), intent(in) :: r(2), clearance(2)
      !> Positive if the zone lies on the left of the loop, negative if on its right; if 0, the loop
      !! does not bound a hole.
      integer, intent(in) :: side
      !> (2, n): r, D
      real(wp), allocatable, intent(out) :: ring(:, :)
      real(wp) :: low(2), scale(2), here(2), a(2), b(2), chord(2), t
      integer :: parts(size(vertices, 2)), i, k, m, n

      m = size(vertices, 2)
      low = [r(1), log(clearance(1))]
      scale = [r(2), log(clearance(2))] - low
      do i = 1, m
         call cubic(i, here, a, b, chord)
         parts(i) = merge(max(1, ceiling(sqrt(max(maxval(abs(a - chord)), maxval(abs(b - chord))) &
            /(4*sag)))), 0, vertices(5, i) > 0)
      end do
      if (sum(parts) == 0) parts = 1
      allocate (ring(2, sum(parts)))
      n = 0
      do i = 1, m
         call cubic(i, here, a, b, chord)
         do k = 0, parts(i) - 1
            t = real(k, wp)/parts(i)
            n = n + 1
            ring(:, n) = low + scale*(here + t*(a + t*(3*chord - 2*a - b + t*(a + b - 2*chord))))
            ring(2, n) = exp(ring(2, n))
         end do
      end do
      if (side < 0 .or. (side == 0 .and. area(ring) < 0)) ring = ring(:, n:1:-1)

   contains

      !> The cubic from a vertex to the next one.
      pure subroutine cubic(i, here, a, b, chord)
         !> Number of the vertex.
         integer, intent(in) :: i
         !> Place of the vertex, derivatives at both ends, and chord, with the window as the unit
         !! square.
         real(wp), dimension(2), intent(out) :: here, a, b, chord
         integer :: j

         j = merge(1, i + 1, i == m)
         here = ([vertices(1, i), log(vertices(2, i))] - low)/scale
         chord = ([vertices(1, j), log(vertices(2, j))] - low)/scale - here
         a = vertices(5, i)*vertices(3:4, i)/scale
         b = vertices(5, i)*vertices(3:4, j)/scale
      end subroutine cubic

   end subroutine dense_ring

   !> Area inside a polygon, positive if it goes counter-clockwise.
   pure real(wp) function area(ring)
      !> (2, n): r, D
      real(wp), intent(in) :: ring(:, :)
      real(wp) :: a(2), b(2)
      integer :: i

      area = 0
      do i = 2, size(ring, 2) - 1
         a = [ring(1, i) - ring(1, 1), log(ring(2, i)/ring(2, 1))]
         b = [ring(1, i + 1) - ring(1, 1), log(ring(2, i + 1)/ring(2, 1))]
         area = area + 0.5_wp*(a(1)*b(2) - a(2)*b(1))
      end do
   end function area

   !> Winding numbers of a polygon around points, counter-clockwise.
   pure function winding(ring, points) result(turns)
      !> (2, n), (2, m): r, D
      real(wp), intent(in) :: ring(:, :), points(:, :)
      integer :: turns(size(points, 2))
      real(wp) :: log_d(size(ring, 2)), low(2), high(2), x, y, side
      integer :: i, j, next

      turns = 0
      log_d = log(ring(2, :))
      low = minval(ring, 2)
      high = maxval(ring, 2)
      do i = 1, size(points, 2)
         if (.not. (all(points(:, i) >= low) .and. all(points(:, i) <= high))) cycle
         x = points(1, i)
         y = log(points(2, i))
         do j = 1, size(ring, 2)
            next = merge(1, j + 1, j == size(ring, 2))
            if ((log_d(j) <= y) .eqv. (log_d(next) <= y)) cycle
            side = (ring(1, next) - ring(1, j))*(y - log_d(j)) &
               - (x - ring(1, j))*(log_d(next) - log_d(j))
            if (log_d(j) <= y .and. side > 0) turns(i) = turns(i) + 1
            if (log_d(j) > y .and. side < 0) turns(i) = turns(i) - 1
         end do
      end do
   end function winding

end module vi_rings
