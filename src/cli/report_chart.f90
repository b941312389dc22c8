!> A chart as CSV: one row a motion.
module vi_report_chart
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use vi_case_type, only: case_type
   use vi_echo, only: echo
   use vi_kinds, only: wp
   use vi_report, only: verdict_word
   use vi_status, only: stat
   use vi_text, only: append, exact, line_type, whole
   use vi_window, only: clearance_axis, map_type, r_axis
   implicit none (type, external)
   private

   public :: chart_lines

contains

   !> The motions of a chart, by r, clearance and slot; a slot that holds none has no row.
   pure subroutine chart_lines(case, map, lines)
      type(case_type), intent(in) :: case
      type(map_type), intent(in) :: map
      type(line_type), allocatable, intent(out) :: lines(:)
      type(line_type), allocatable :: header(:)
      real(wp) :: r(case%window%r_points), clearance(case%window%clearance_points)
      integer :: i, j, k, n

      call echo(case, header)
      call append(header, 'r,clearance,slot,consistent,admissible,stable,multiplier_1_modulus,'// &
         'x_max,status')
      n = size(header)
      allocate (lines(n + count(map%status /= stat%no_motion)))
      do i = 1, n
         call move_alloc(header(i)%text, lines(i)%text)
      end do
      r = r_axis(case%window)
      clearance = clearance_axis(case%window)
      do k = 1, size(r)
         do j = 1, size(clearance)
            do i = 1, size(map%status, 1)
               if (map%status(i, j, k) == stat%no_motion) cycle
               n = n + 1
               lines(n)%text = exact(r(k))//','//exact(clearance(j))//','//whole(i)//','// &
                  verdict_word(map%verdicts(1, i, j, k))//','// &
                  verdict_word(map%verdicts(2, i, j, k))//','// &
                  verdict_word(map%verdicts(3, i, j, k))//','//shown(map%leading(i, j, k))//','// &
                  shown(map%x_max(i, j, k))//','//whole(map%status(i, j, k))
            end do
         end do
      end do
   end subroutine chart_lines

   !> A number with all its digits, or nan.
   pure function shown(value) result(text)
      real(wp), intent(in) :: value
      character(:), allocatable :: text

      if (ieee_is_nan(value)) then
         text = 'nan'
      else
         text = exact(value)
      end if
   end function shown

end module vi_report_chart
