!> Atlases as CSV: one row a vertex.
module vi_report_atlas
   use vi_atlas, only: atlas_type, outcomes_of
   use vi_case, only: case_type, echo
   use vi_pattern, only: starred_letters
   use vi_report_zone, only: not_closed, truth
   use vi_survey_outcome, only: beyond, outcome_names
   use vi_text, only: append, counted, exact, line_type, whole, whole_width
   use vi_zone_pieces, only: pieces_type
   implicit none (type, external)
   private

   public :: atlas_lines, pattern_text, survey_text

   !> Where the motion without impacts exists, in closed form: D > 2A.
   character(*), parameter :: without_impacts = 'without impacts, the free mass at rest: where &
      &clearance > 2/sqrt((1 - r^2)^2 + (2 xi r)^2)'

contains

   !> The vertices of all pieces of all zones; header as in `csv_lines`, with what is missing.
   pure subroutine atlas_lines(case, atlas, found, lines)
      type(case_type), intent(in) :: case
      type(atlas_type), intent(in) :: atlas
      !> The pieces of each sheet.
      type(pieces_type), intent(in) :: found(:)
      type(line_type), allocatable, intent(out) :: lines(:)
      type(line_type), allocatable :: head(:)
      character(:), allocatable :: said
      integer :: i, j, n

      call echo(case, head)
      call survey_text(atlas, said)
      call append(head, '# ! '//said)
      call append(head, '# ! '//without_impacts)
      do j = 1, size(found)
         if (.not. found(j)%closed) call append(head, '# ! '// &
            pattern_text(atlas%sheets(j)%pattern%sides, atlas%sheets(j)%pattern%cycles)//': '// &
            not_closed//' (its loop is 0)')
      end do
      do i = 1, size(atlas%attractors)
         if (atlas%explained(i)) cycle
         associate (item => atlas%attractors(i))
            call append(head, '# ! in no zone of its pattern: '//pattern_text(item%letters, &
               item%cycles)//' at r = '//exact(item%r)//', clearance = '//exact(item%clearance))
         end associate
      end do
      do i = 1, size(atlas%points)
         associate (item => atlas%points(i))
            if (item%outcome == beyond) call append(head, '# ! beyond the limits: '//pattern_text( &
               item%letters, item%cycles)//' at r = '//exact(item%r)//', clearance = '// &
               exact(item%clearance))
         end associate
      end do
      call append(head, 'sides,cycles,symmetric,loop,piece,type,detail,r,clearance,corner')
      n = size(head)
      allocate (lines(n + sum([((size(found(j)%pieces(i)%corner), i=1, found(j)%n), &
         j=1, size(found))])))
      do i = 1, n
         call move_alloc(head(i)%text, lines(i)%text)
      end do
      do j = 1, size(found)
         associate (pattern => atlas%sheets(j)%pattern)
            call write_sheet(starred_letters(pattern%sides)//','//whole(pattern%cycles)//','// &
               truth(atlas%sheets(j)%symmetric)//',', found(j), lines, n)
         end associate
      end do
   end subroutine atlas_lines

   !> What became of the points of the survey.
   pure subroutine survey_text(atlas, text)
      type(atlas_type), intent(in) :: atlas
      character(:), allocatable, intent(out) :: text
      integer :: counts(size(outcome_names)), i

      counts = outcomes_of(atlas)
      text = 'survey of '//counted(sum(counts), 'point')
      do i = 1, size(counts)
         if (counts(i) == 0) cycle
         text = text//merge(': ', ', ', sum(counts(:i - 1)) == 0)//whole(counts(i))//' '// &
            trim(outcome_names(i))
      end do
   end subroutine survey_text

   pure subroutine write_sheet(name, found, lines, n)
      !> What all rows begin with.
      character(*), intent(in) :: name
      type(pieces_type), intent(in) :: found
      type(line_type), intent(inout) :: lines(:)
      !> Lines written so far.
      integer, intent(inout) :: n
      character(:), allocatable :: start
      integer :: i, j

      do i = 1, found%n
         associate (piece => found%pieces(i))
            start = name//whole(piece%loop)//','//whole(i)//','//piece%name//','//piece%detail//','
            do j = 1, size(piece%corner)
               n = n + 1
               lines(n)%text = start//exact(piece%vertices(1, j))//','// &
                  exact(piece%vertices(2, j))//','//truth(piece%corner(j))
            end do
         end associate
      end do
   end subroutine write_sheet

   !> Short name of a pattern: RRL/1.
   pure function pattern_text(sides, cycles) result(text)
      integer, intent(in) :: sides(:), cycles
      character(size(sides) + count(abs(sides) > 1) + 1 + whole_width(cycles)) :: text

      text = starred_letters(sides)//'/'//whole(cycles)
   end function pattern_text

end module vi_report_atlas
