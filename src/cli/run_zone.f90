!> Runs a case with a zone.
module vi_run_zone
   use vi_case, only: case_type
   use vi_log, only: done, failed, log_type, say, write_table
   use vi_report_zone, only: not_closed, zone_lines
   use vi_text, only: counted, line_type, whole
   use vi_zone_pieces, only: pieces_type, zone_pieces
   use vi_zone_study, only: zone_request
   implicit none (type, external)
   private

   public :: run_zone

contains

   !> Finds the zones of a case and writes their boundaries; a window without any is said to be so.
   subroutine run_zone(case, folder, log, written, tally)
      type(case_type), intent(in) :: case
      character(*), intent(in) :: folder
      type(log_type), intent(inout) :: log
      !> False if the result could not be written.
      logical, intent(out) :: written
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      type(pieces_type) :: found
      type(line_type), allocatable :: lines(:)
      character(:), allocatable :: what, types

      written = .true.
      call case%study%text('sides', what)
      what = what//'/'//whole(case%study%whole_number('cycles'))
      call zone_pieces(zone_request(case), .not. [case%study%is('symmetric', 'no'), &
         case%study%is('symmetric', 'yes')], found, tally)
      if (found%motions == 0) then
         call say(log, failed, case%name//': no motion '//what//' was found anywhere in the window')
         return
      else if (found%n == 0 .and. found%closed) then
         call say(log, failed, case%name//': no zone: motions '//what// &
            ' were found in the window, but none that is both stable and admissible')
         return
      end if
      call zone_lines(case, found, lines)
      call write_table(folder//'/'//case%name//'.csv', lines, log, written)
      if (.not. written) return
      call list_types(found, types)
      call say(log, done, case%name//': '//what//', '//counted(found%loops, 'loop')//' in '// &
         counted(found%n, 'piece')//types)
      if (.not. found%closed) call say(log, failed, case%name//': '//not_closed)
   end subroutine run_zone

   !> The types of the pieces, each once.
   pure subroutine list_types(found, text)
      type(pieces_type), intent(in) :: found
      character(:), allocatable, intent(out) :: text
      integer :: i

      text = ''
      do i = 1, found%n
         associate (name => found%pieces(i)%name)
            if (index(text//',', ' '//name//',') > 0) cycle
            text = text//trim(merge(':', ',', len(text) == 0))//' '//name
         end associate
      end do
   end subroutine list_types

end module vi_run_zone
