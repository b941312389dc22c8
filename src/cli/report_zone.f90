!> Zones as CSV: one row a vertex.
module vi_report_zone
   use vi_case, only: case_type, echo
   use vi_text, only: append, exact, line_type, whole
   use vi_zone_pieces, only: pieces_type
   implicit none (type, external)
   private

   public :: truth, zone_lines

   character(*), parameter, public :: not_closed = &
      'not closed: a boundary could not be followed until it closes'

contains

   !> The vertices of all pieces; header as in `csv_lines`.
   pure subroutine zone_lines(case, found, lines)
      type(case_type), intent(in) :: case
      type(pieces_type), intent(in) :: found
      type(line_type), allocatable, intent(out) :: lines(:)
      type(line_type), allocatable :: head(:)
      character(:), allocatable :: start
      integer :: i, j, n

      call echo(case, head)
      if (.not. found%closed) call append(head, '# ! '//not_closed//' (its loop is 0)')
      call append(head, 'loop,piece,type,detail,symmetric,r,clearance,corner')
      n = size(head)
      allocate (lines(n + sum([(size(found%pieces(i)%corner), i=1, found%n)])))
      do i = 1, n
         call move_alloc(head(i)%text, lines(i)%text)
      end do
      do i = 1, found%n
         associate (piece => found%pieces(i))
            start = whole(piece%loop)//','//whole(i)//','//piece%name//','//piece%detail//','// &
               truth(piece%symmetric)//','
            do j = 1, size(piece%corner)
               n = n + 1
               lines(n)%text = start//exact(piece%vertices(1, j))//','// &
                  exact(piece%vertices(2, j))//','//truth(piece%corner(j))
            end do
         end associate
      end do
   end subroutine zone_lines

   !> A logical value as true or false.
   pure function truth(value) result(word)
      logical, intent(in) :: value
      character(merge(4, 5, value)) :: word

      word = merge('true ', 'false', value)
   end function truth

end module vi_report_zone
