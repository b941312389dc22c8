!> Vertices of a loop that are a distance from where their curve ends are moved there.
module vi_settle
   use vi_curve, only: correct, curve_type
   use vi_frame, only: condition_type, edge, repetition
   use vi_kinds, only: wp
   use vi_loop, only: begins, ends, loop_type
   implicit none (type, external)
   private

   public :: settle

contains

   !> Moves the vertices that are a distance from a motion that repeats itself onto that motion.
   !!
   !! The motion is a smooth function of the distance and the parameters are one of its square: what
   !! they are at 1/2, 1 and 3/2 of it tells where they lead.
   pure subroutine settle(sheet, loop)
      type(curve_type), intent(in) :: sheet
      type(loop_type), intent(inout) :: loop
      real(wp), parameter :: weights(3) = [3, -3, 1]
      real(wp), parameter :: weights_of_squares(3) = [1.5_wp, -0.6_wp, 0.1_wp]
      real(wp) :: near(size(loop%points, 1), 3)
      integer :: i, j, twin, m
      logical :: good(3)

      m = size(near, 1) - 2
      do j = 1, loop%n
         if (loop%conditions(j)%kind /= repetition) cycle
         twin = j
         if (loop%corner(j) == ends) twin = modulo(j, loop%n) + 1
         if (loop%corner(j) == begins) twin = modulo(j - 2, loop%n) + 1
         do i = 1, 3
            call place_at(sheet, loop, j, twin, 0.5_wp*i, near(:, i), good(i))
         end do
         if (.not. all(good)) cycle
         near(:m, 1) = matmul(near(:m, :), weights)
         near(m + 1:, 1) = matmul(near(m + 1:, :), weights_of_squares)
         loop%points(:, j) = near(:, 1)
         loop%points(:, twin) = near(:, 1)
      end do
   end subroutine settle

   !> Where a vertex would be if another distance counted as none.
   pure subroutine place_at(sheet, loop, vertex, twin, share, point, good)
      type(curve_type), intent(in) :: sheet
      type(loop_type), intent(in) :: loop
      !> Of the vertex and, if it is a corner, of the same one on the other piece.
      integer, intent(in) :: vertex, twin
      !> The other distance, by that of the loop.
      real(wp), intent(in) :: share
      real(wp), intent(out) :: point(:)
      logical, intent(out) :: good
      type(condition_type) :: other
      integer :: iterations

      point = loop%points(:, vertex)
      other = loop%conditions(vertex)
      other%bound = share*other%bound
      if (loop%conditions(twin)%kind == edge) then
         call correct(sheet, [other, loop%conditions(twin)], point, iterations)
      else
         call correct(sheet, [other], point, iterations, loop%tangents(:, vertex))
      end if
      good = iterations > 0
   end subroutine place_at

end module vi_settle
