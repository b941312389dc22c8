!> The line ends of a text as stored in a file.
module vi_lines
   implicit none (type, external)
   private

   public :: unify_line_ends

contains

   !> Replaces the ends of lines (a line feed, a carriage return, or the two together) by line
   !! feeds, and removes a byte order mark.
   pure subroutine unify_line_ends(text, clean)
      !> The content of a file.
      character(*), intent(in) :: text
      !> The same text with a line feed between two lines.
      character(:), allocatable, intent(out) :: clean
      character, parameter :: line_feed = achar(10), carriage_return = achar(13)
      character(:), allocatable :: copied
      character :: this, before
      integer :: first, i, n

      first = 1
      if (index(text(:min(3, len(text))), char(239)//char(187)//char(191)) == 1) first = 4
      allocate (character(len(text)) :: copied)
      n = 0
      before = ' '
      do i = first, len(text)
         this = text(i:i)
         if (this /= line_feed .or. before /= carriage_return) then
            n = n + 1
            copied(n:n) = merge(line_feed, this, this == carriage_return)
         end if
         before = this
      end do
      clean = copied(:n)
   end subroutine unify_line_ends

end module vi_lines
