!> A chart as CSV: one row a motion.
module vi_report_chart
   use vi_case, only: case_type, echo
   use vi_chart_study, only: chart_window_of
   use vi_kinds, only: wp
   use vi_report, only: verdict_word
   use vi_status, only: stat
   use vi_text, only: append, columns, exact, line_type, whole
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
      real(wp), allocatable :: r(:), clearance(:)
      integer :: i, j, k, n

      call echo(case, header)
      call append(header, 'r,clearance,slot,consistent,admissible,stable,multiplier_1_modulus,'// &
         'x_max,status')
      n = size(header)
      allocate (lines(n + count(map%status /= stat%no_motion)))
      do i = 1, n
         call move_alloc(header(i)%text, lines(i)%text)
      end do
      r = r_axis(chart_window_of(case%study))
      clearance = clearance_axis(chart_window_of(case%study))
      do k = 1, size(r)
         do j = 1, size(clearance)
            do i = 1, size(map%status, 1)
               if (map%status(i, j, k) == stat%no_motion) cycle
               n = n + 1
               lines(n)%text = exact(r(k))//columns([clearance(j)])//','//whole(i)//','// &
                  verdict_word(map%verdicts(1, i, j, k))//','// &
                  verdict_word(map%verdicts(2, i, j, k))//','// &
                  verdict_word(map%verdicts(3, i, j, k))//columns([map%leading(i, j, k), &
                  map%x_max(i, j, k)])//','//whole(map%status(i, j, k))
            end do
         end do
      end do
   end subroutine chart_lines

end module vi_report_chart
