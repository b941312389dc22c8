!> Small text helpers of the command-line side.
module vi_text
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: append, exact, join, lower, read_lines, shown, split, whole

   !> A line of text.
   type, public :: line_type
      character(:), allocatable :: text
   end type line_type

contains

   !> Adds a line to a growing list.
   pure subroutine append(lines, text)
      type(line_type), allocatable, intent(inout) :: lines(:)
      character(*), intent(in) :: text

      if (.not. allocated(lines)) allocate (lines(0))
      lines = [lines, line_type(text)]
   end subroutine append

   !> The text in lower case (ASCII).
   pure function lower(text) result(lowered)
      character(*), intent(in) :: text
      character(len(text)) :: lowered
      integer :: i

      lowered = text
      do i = 1, len(text)
         if (text(i:i) >= 'A' .and. text(i:i) <= 'Z') lowered(i:i) = achar(iachar(text(i:i)) + 32)
      end do
   end function lower

   !> A number with all its digits (17), so that reading it back gives the same bits.
   pure function exact(value) result(text)
      real(wp), intent(in) :: value
      character(:), allocatable :: text
      character(24) :: buffer

      write (buffer, '(es24.16e3)') value
      text = trim(adjustl(buffer))
   end function exact

   !> A number with a few digits, for messages and printed tables.
   pure function shown(value, format) result(text)
      real(wp), intent(in) :: value
      !> An edit descriptor such as f10.4.
      character(*), intent(in) :: format
      character(:), allocatable :: text
      character(40) :: buffer

      write (buffer, '('//format//')') value
      text = trim(adjustl(buffer))
   end function shown

   !> A whole number.
   pure function whole(value) result(text)
      integer, intent(in) :: value
      character(:), allocatable :: text
      character(12) :: buffer

      write (buffer, '(i0)') value
      text = trim(buffer)
   end function whole

   !> The parts of a text between single separators.
   pure function split(text, separator) result(parts)
      character(*), intent(in) :: text
      character, intent(in) :: separator
      type(line_type), allocatable :: parts(:)
      integer :: i, first, last

      allocate (parts(1 + count([(text(i:i) == separator, i=1, len(text))])))
      first = 1
      do i = 1, size(parts) - 1
         last = first + index(text(first:), separator) - 2
         parts(i)%text = text(first:last)
         first = last + 2
      end do
      parts(size(parts))%text = text(first:)
   end function split

   !> The lines as one text with a separator between them, the inverse of `split`.
   pure function join(lines, separator) result(text)
      type(line_type), intent(in) :: lines(:)
      character, intent(in) :: separator
      character(:), allocatable :: text
      integer :: i, length

      allocate (character(max(0, sum([(len(lines(i)%text) + 1, i=1, size(lines))]) - 1)) :: text)
      length = 0
      do i = 1, size(lines)
         text(length + 1:length + len(lines(i)%text)) = lines(i)%text
         length = length + len(lines(i)%text) + 1
         if (i < size(lines)) text(length:length) = separator
      end do
   end function join

   !> All lines of a text file, without carriage returns; `message` is empty if that went well.
   subroutine read_lines(path, lines, message)
      character(*), intent(in) :: path
      type(line_type), allocatable, intent(out) :: lines(:)
      character(:), allocatable, intent(out) :: message
      character(:), allocatable :: content
      character(200) :: reason
      integer :: unit, length, status, i

      message = ''
      open (newunit=unit, file=path, status='old', action='read', access='stream', &
         form='unformatted', iostat=status, iomsg=reason)
      if (status == 0) then
         inquire (unit=unit, size=length)
         allocate (character(max(0, length)) :: content)
         if (length > 0) read (unit, iostat=status, iomsg=reason) content
         close (unit)
      end if
      if (status /= 0) then
         message = trim(reason(index(reason, ': ', back=.true.) + 1:))    ! without the path
         message = trim(adjustl(message))
         allocate (lines(0))
         return
      end if
      if (len(content) >= 3) then                                 ! a byte order mark is no text
         if (content(:3) == char(239)//char(187)//char(191)) content = content(4:)
      end if
      lines = split(content, achar(10))
      do i = 1, size(lines)
         length = len(lines(i)%text)
         if (length > 0) then
            if (lines(i)%text(length:length) == achar(13)) lines(i)%text = lines(i)%text(:length &
               - 1)
         end if
      end do
   end subroutine read_lines

end module vi_text
