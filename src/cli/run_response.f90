!> Runs a case with the response of the primary mass: one row a frequency ratio.
module vi_run_response
   use vi_attractor_response, only: respond
   use vi_processor, only: available_threads
   use vi_response_study, only: r_values, response_clearance
   use vi_case, only: case_type, echo
   use vi_kinds, only: wp
   use vi_log, only: done, failed, log_type, say, write_table
   use vi_status, only: stat, status_text
   use vi_text, only: append, columns, counted, lengthen, line_type, shown, whole
   implicit none (type, external)
   private

   public :: run_response

contains

   !> Finds max|X|/A over the attractors at each frequency ratio and writes its least and greatest.
   subroutine run_response(case, folder, log, written, tally)
      type(case_type), intent(in) :: case
      character(*), intent(in) :: folder
      type(log_type), intent(inout) :: log
      !> False if the result could not be written.
      logical, intent(out) :: written
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      real(wp), allocatable :: r(:), clearance(:), attenuation(:, :), envelope(:, :)
      integer, allocatable :: periods(:, :, :), status(:, :)
      type(line_type), allocatable :: lines(:)
      character(:), allocatable :: text
      integer :: first, j, n, states, lost

      written = .true.
      allocate (r, source=r_values(case))
      n = size(r)
      states = case%study%whole_number('states')
      allocate (clearance(n), source=response_clearance(case))
      allocate (attenuation(states, n), envelope(2, n), periods(4, states, n), status(states, n))
      call respond(case%osc, r, clearance, case%study%number('load'), &
         case%study%whole_number('settling'), case%study%whole_number('keep'), &
         available_threads(), attenuation, envelope, periods, status, tally)
      lost = count(status /= stat%ok)
      if (lost < size(status)) then
         call echo(case, lines)
         call append(lines, 'r,clearance,lowest,highest')
         first = size(lines)
         call lengthen(lines, n)
         do j = 1, n
            text = columns([r(j), clearance(j), envelope(:, j)])
            lines(first + j)%text = text(2:)
         end do
         call write_table(folder//'/'//case%name//'.csv', lines, log, written)
         if (.not. written) return
         call say(log, done, case%name//': max|X|/A from '//shown(minval(envelope(1, :)), 'f12.4') &
            //' to '//shown(maxval(envelope(2, :)), 'f12.4')//' at '//counted(n, 'point'))
      end if
      if (lost > 0) call say(log, failed, case%name//': '//whole(lost)//' of '//counted( &
         size(status), 'simulation')//' failed: '//status_text(maxval(status)))
   end subroutine run_response

end module vi_run_response
