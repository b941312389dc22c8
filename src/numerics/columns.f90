!> Systems of linear equations of any size with several right sides.
module vi_columns
   use vi_eigen_routines, only: dgesv
   use vi_kinds, only: wp
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: solve_columns

contains

   !> Solves the square system matrix.x = right for each column of `right` (DGESV).
   !! A diagonal matrix only divides: separate masses are exact.
   pure subroutine solve_columns(matrix, right, status)
      !> (n, n)
      real(wp), intent(in) :: matrix(:, :)
      !> In: right sides (n, m). Out: the solutions.
      real(wp), intent(inout) :: right(:, :)
      !> `stat%ok` or `stat%singular`.
      integer, intent(out) :: status
      real(wp), allocatable :: factor(:, :)
      integer :: pivot(size(matrix, 1)), i, info, n

      status = stat%ok
      n = size(matrix, 1)
      do i = 1, n
         if (count(abs(matrix(:, i)) > 0) > 1 .or. .not. abs(matrix(i, i)) > 0) exit
      end do
      if (i > n) then
         do i = 1, n
            right(i, :) = right(i, :)/matrix(i, i)
         end do
         return
      end if
      allocate (factor, source=matrix)
      call dgesv(n, size(right, 2), factor, n, pivot, right, n, info)
      if (info /= 0) status = stat%singular
   end subroutine solve_columns

end module vi_columns
