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
   !! The parameters go with the square of the distance, so those at the distance and at half of it
   !! tell where they lead.
   pure subroutine settle(sheet, loop)
      type(curve_type), intent(in) :: sheet
      type(loop_type), intent(inout) :: loop
      type(condition_type) :: half
      real(wp) :: near(size(loop%points, 1))
      integer :: j, twin, m, iterations

      m = size(near) - 2
      do j = 1, loop%n
         half = loop%conditions(j)
         if (half%kind /= repetition) cycle
         half%bound = 0.5_wp*half%bound
         near = loop%points(:, j)
         twin = j
         if (loop%corner(j) == ends) twin = modulo(j, loop%n) + 1
         if (loop%corner(j) == begins) twin = modulo(j - 2, loop%n) + 1
         if (loop%conditions(twin)%kind == edge) then
            call correct(sheet, [half, loop%conditions(twin)], near, iterations)
         else
            call correct(sheet, [half], near, iterations, loop%tangents(:, j))
         end if
         if (iterations == 0) cycle
         near(:m) = 2*near(:m) - loop%points(:m, j)
         near(m + 1:) = (4*near(m + 1:) - loop%points(m + 1:, j))/3
         loop%points(:, j) = near
         loop%points(:, twin) = near
      end do
   end subroutine settle

end module vi_settle
