!> Boundaries of zones as lists of points, and operations on them.
module vi_loop
   use vi_kinds, only: wp
   use vi_motion_family, only: condition_type
   implicit none (type, external)
   private

   public :: chained, picked, reversed

   !> A corner as the end of a piece and as the beginning of the next.
   integer, parameter, public :: ends = 1, begins = 2

   !> A boundary, or the part of it that could be followed.
   type, public :: loop_type
      !> Points (2n + 2, m), and the condition that is zero from each to the next.
      real(wp), allocatable :: points(:, :), tangents(:, :)
      type(condition_type), allocatable :: conditions(:)
      !> `ends` or `begins` if a point is a corner, where two conditions are zero, otherwise 0; a
      !! corner is listed twice.
      integer, allocatable :: corner(:)
      integer :: n = 0
      !> False if the curve could not be followed to its start.
      logical :: closed = .false.
      !> Of a closed curve: positive if the zone lies on its left in the plane (r, log D), negative
      !! if on its right, 0 if that is not known.
      integer :: side = 0
   end type loop_type

contains

   !> The same curve in the opposite direction.
   pure function reversed(loop) result(turned)
      !> The curve.
      type(loop_type), intent(in) :: loop
      type(loop_type) :: turned
      integer :: i

      turned = picked(loop, [(i, i=loop%n, 1, -1)])
      turned%tangents = -turned%tangents
      where (turned%corner > 0) turned%corner = ends + begins - turned%corner
   end function reversed

   !> Some points of a curve, in a given order.
   pure function picked(loop, order) result(some)
      !> The curve.
      type(loop_type), intent(in) :: loop
      !> Numbers of the points.
      integer, intent(in) :: order(:)
      type(loop_type) :: some
      integer :: i

      some%n = size(order)
      some%closed = loop%closed
      allocate (some%points(size(loop%points, 1), some%n), some%conditions(some%n), &
         some%corner(some%n))
      allocate (some%tangents, mold=some%points)
      do i = 1, some%n
         some%points(:, i) = loop%points(:, order(i))
         some%tangents(:, i) = loop%tangents(:, order(i))
         some%conditions(i) = loop%conditions(order(i))
         some%corner(i) = loop%corner(order(i))
      end do
   end function picked

   !> A curve followed by another one.
   pure function chained(first, second) result(whole)
      !> The curves.
      type(loop_type), intent(in) :: first, second
      type(loop_type) :: whole
      integer :: n

      n = first%n
      whole%n = n + second%n
      allocate (whole%points(size(first%points, 1), whole%n), whole%conditions(whole%n), &
         whole%corner(whole%n))
      allocate (whole%tangents, mold=whole%points)
      whole%points(:, :n) = first%points(:, :n)
      whole%points(:, n + 1:) = second%points(:, :second%n)
      whole%tangents(:, :n) = first%tangents(:, :n)
      whole%tangents(:, n + 1:) = second%tangents(:, :second%n)
      whole%conditions(:n) = first%conditions(:n)
      whole%conditions(n + 1:) = second%conditions(:second%n)
      whole%corner(:n) = first%corner(:n)
      whole%corner(n + 1:) = second%corner(:second%n)
   end function chained

end module vi_loop
