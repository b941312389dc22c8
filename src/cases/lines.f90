!> The lines of a text as files hold it.
module vi_lines
   use vi_text, only: line_type, split
   implicit none (type, external)
   private

   public :: split_lines

contains

   !> The lines of a text, which may end with a line feed, a carriage return, or the two together; a
   !! byte order mark is no text.
   pure subroutine split_lines(text, lines)
      !> The content of a file.
      character(*), intent(in) :: text
      !> Its lines.
      type(line_type), allocatable, intent(out) :: lines(:)
      character(*), parameter :: line_feed = achar(10), carriage_return = achar(13)
      character(:), allocatable :: clean
      character :: this, before
      integer :: first, i, n

      first = 1
      if (index(text, char(239)//char(187)//char(191)) == 1) first = 4
      allocate (character(len(text)) :: clean)
      n = 0
      before = ' '
      do i = first, len(text)
         this = text(i:i)
         if (this /= line_feed .or. before /= carriage_return) then
            n = n + 1
            clean(n:n) = merge(line_feed, this, this == carriage_return)
         end if
         before = this
      end do
      lines = split(clean(:n), line_feed)
   end subroutine split_lines

end module vi_lines
