!> Runs a case with an atlas.
module vi_run_atlas
   use vi_atlas, only: atlas_type, find_atlas
   use vi_atlas_study, only: atlas_request
   use vi_case, only: case_type
   use vi_family, only: can_be_symmetric
   use vi_log, only: done, failed, log_type, say, write_table
   use vi_processor, only: available_threads
   use vi_report_atlas, only: atlas_lines, pattern_text, survey_text
   use vi_report_zone, only: not_closed
   use vi_text, only: counted, line_type, whole
   use vi_zone_pieces, only: add_pieces, pieces_type
   implicit none (type, external)
   private

   public :: run_atlas

contains

   !> Finds all zones in a window and writes their boundaries; says what became of the points of the
   !! survey, and which attractors lie in no zone.
   subroutine run_atlas(case, folder, log, written, tally)
      type(case_type), intent(in) :: case
      character(*), intent(in) :: folder
      type(log_type), intent(inout) :: log
      !> False if the result could not be written.
      logical, intent(out) :: written
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      type(atlas_type) :: atlas
      type(pieces_type), allocatable :: found(:)
      type(line_type), allocatable :: lines(:)
      character(:), allocatable :: said, patterns
      integer :: j, lost

      written = .true.
      call find_atlas(atlas_request(case, available_threads()), atlas, tally)
      allocate (found(size(atlas%sheets)))
      do j = 1, size(found)
         associate (sheet => atlas%sheets(j))
            call add_pieces(sheet%zone, sheet%symmetric, .not. sheet%symmetric .and. &
               can_be_symmetric(sheet%pattern, case%osc%restitution), found(j))
         end associate
      end do
      lost = count(.not. atlas%explained)
      call survey_text(atlas, said)
      if (all(found%n == 0) .and. all(found%closed) .and. lost == 0) then
         call say(log, failed, case%name//': no zone: neither search nor survey found a stable, &
            &admissible motion within the limits in the window; '//said)
         return
      end if
      call atlas_lines(case, atlas, found, lines)
      call write_table(folder//'/'//case%name//'.csv', lines, log, written)
      if (.not. written) return
      call say(log, done, case%name//': '//counted(count(found%loops > 0), 'zone')//', '// &
         counted(sum(found%loops), 'loop')//', '//counted(size(atlas%explained), 'attractor')// &
         ' surveyed')
      call say(log, done, case%name//': '//said)
      do j = 1, size(found)
         if (.not. found(j)%closed) call say(log, failed, case%name//': '//pattern_text( &
            atlas%sheets(j)%pattern%sides, atlas%sheets(j)%pattern%cycles)//' '//not_closed)
      end do
      if (lost == 0) return
      call list_patterns(atlas, patterns)
      call say(log, failed, case%name//': '//whole(lost)//' of '//counted(size(atlas%explained), &
         'attractor')//' in no zone of the pattern:'//patterns)
   end subroutine run_atlas

   !> The patterns of attractors in no zone, each once.
   pure subroutine list_patterns(atlas, text)
      type(atlas_type), intent(in) :: atlas
      character(:), allocatable, intent(out) :: text
      character(:), allocatable :: name
      integer :: i

      text = ''
      do i = 1, size(atlas%attractors)
         if (atlas%explained(i)) cycle
         name = ' '//pattern_text(atlas%attractors(i)%letters, atlas%attractors(i)%cycles)
         if (index(text//',', name//',') > 0) cycle
         text = text//trim(merge(',', ' ', len(text) > 0))//name
      end do
   end subroutine list_patterns

end module vi_run_atlas
