!> Small text helpers of the command-line side.
module vi_text
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: append, brief, columns, counted, detab, exact, is_result, join, last_part, lengthen, &
      lower, printable, read_lines, shown, split, whole

   !> A line of text.
   type, public :: line_type
      character(:), allocatable :: text
   end type line_type

   !> Bytes that a namelist file may have.
   integer, parameter :: largest = 64*1024*1024

contains

   !> Adds a line to a growing list.
   pure subroutine append(lines, text)
      type(line_type), allocatable, intent(inout) :: lines(:)
      character(*), intent(in) :: text

      call lengthen(lines, 1)
      lines(size(lines))%text = text
   end subroutine append

   !> Adds room for more lines.
   pure subroutine lengthen(lines, more)
      type(line_type), allocatable, intent(inout) :: lines(:)
      integer, intent(in) :: more
      type(line_type), allocatable :: longer(:)
      integer :: i, n

      ! not [lines, line_type(text)]: gfortran 12 loses the memory of such a constructor
      n = 0
      if (allocated(lines)) n = size(lines)
      allocate (longer(n + more))
      do i = 1, n
         call move_alloc(lines(i)%text, longer(i)%text)
      end do
      call move_alloc(longer, lines)
   end subroutine lengthen

   !> The text with blanks for tabs.
   pure function detab(text) result(clean)
      character(*), intent(in) :: text
      character(len(text)) :: clean
      integer :: i

      clean = text
      do i = 1, len(text)
         if (text(i:i) == achar(9)) clean(i:i) = ' '
      end do
   end function detab

   !> The text, safe for a terminal: a question mark for each byte of a control character.
   pure function printable(text) result(clean)
      character(*), intent(in) :: text
      character(len(text)) :: clean
      integer :: i, n

      clean = text
      i = 1
      do while (i <= len(text))
         n = letter_length(text(i:min(len(text), i + 3)))
         if (n == 0) clean(i:i) = '?'
         i = i + max(1, n)
      end do
   end function printable

   !> Bytes of the letter that a text begins with, UTF-8 or else Latin-1; 0 of a control character.
   pure integer function letter_length(text) result(n)
      character(*), intent(in) :: text
      integer :: bytes(len(text)), i

      bytes = [(iachar(text(i:i)), i=1, len(text))]
      n = merge(1, 0, (bytes(1) >= 32 .and. bytes(1) <= 126) .or. bytes(1) >= 160)
      if (bytes(1) < 194 .or. bytes(1) > 244) return
      i = 2 + count(bytes(1) >= [224, 240])
      if (i > len(text)) return
      if (any(bytes(2:i) < 128 .or. bytes(2:i) > 191)) return
      n = merge(0, i, bytes(1) == 194 .and. bytes(2) < 160)
   end function letter_length

   !> A message without the middle of a value of thousands of letters, which would fill screens.
   pure function brief(text) result(short)
      character(*), intent(in) :: text
      character(:), allocatable :: short
      integer, parameter :: kept = 300

      short = text
      if (len(text) > 2*kept + 5) short = text(:kept)//' ... '//text(len(text) - kept + 1:)
   end function brief

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

   !> Numbers as columns of a table, each behind a comma; what is not finite as Python reads it.
   pure function columns(values) result(text)
      real(wp), intent(in) :: values(:)
      character(:), allocatable :: text
      integer :: i

      text = ''
      do i = 1, size(values)
         if (ieee_is_finite(values(i))) then
            text = text//','//exact(values(i))
         else if (ieee_is_nan(values(i))) then
            text = text//',nan'
         else
            text = text//trim(merge(',inf ', ',-inf', values(i) > 0))
         end if
      end do
   end function columns

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

   !> A number of things: "1 impact", "2 impacts".
   pure function counted(number, thing) result(text)
      integer, intent(in) :: number
      character(*), intent(in) :: thing
      character(:), allocatable :: text

      text = whole(number)//' '//thing
      if (number /= 1) text = text//'s'
   end function counted

   !> All lines of a text file or pipe; `message` is empty if that went well.
   subroutine read_lines(path, lines, message)
      character(*), intent(in) :: path
      type(line_type), allocatable, intent(out) :: lines(:)
      character(:), allocatable, intent(out) :: message
      character(:), allocatable :: content
      integer :: i

      call read_text(path, content, message)
      if (len(content) >= 3) then                                 ! a byte order mark is no text
         if (content(:3) == char(239)//char(187)//char(191)) content = content(4:)
      end if
      lines = split(content, achar(10))
      do i = 1, size(lines)
         associate (length => len(lines(i)%text))
            if (length > 0) then
               if (lines(i)%text(length:length) == achar(13)) lines(i)%text = &
                  lines(i)%text(:length - 1)
            end if
         end associate
      end do
   end subroutine read_lines

   !> Whether a file is a result of ours, which starts with #.
   logical function is_result(path)
      character(*), intent(in) :: path
      type(line_type), allocatable :: lines(:)
      character(:), allocatable :: message

      call read_lines(path, lines, message)
      is_result = .false.
      if (size(lines) > 0) is_result = index(lines(1)%text, '#') == 1
   end function is_result

   !> The content of a text file or pipe, line feeds between its lines.
   subroutine read_text(path, content, message)
      character(*), intent(in) :: path
      character(:), allocatable, intent(out) :: content, message
      character(len(path) + 300) :: reason
      character(65536) :: part
      character(:), allocatable :: longer
      integer :: unit, status, n, length
      logical :: folder

      message = ''
      content = ''
      inquire (file=path//'/.', exist=folder)
      if (folder) then
         message = 'Is a directory'
         return
      end if
      open (newunit=unit, file=path, status='old', action='read', iostat=status, iomsg=reason)
      if (status /= 0) then
         message = last_part(reason)
         return
      end if
      length = 0
      do
         read (unit, '(a)', advance='no', size=n, iostat=status, iomsg=reason) part
         if (status /= 0 .and. .not. is_iostat_eor(status)) exit
         if (length + n + 1 > len(content)) then
            allocate (character(2*(length + n + 1)) :: longer)
            longer(:length) = content(:length)
            call move_alloc(longer, content)
         end if
         content(length + 1:length + n) = part(:n)
         length = length + n
         if (is_iostat_eor(status)) then
            length = length + 1
            content(length:length) = achar(10)
         end if
         if (length > largest) then
            message = 'is larger than 64 MB'
            exit
         end if
      end do
      if (len(message) == 0 .and. .not. is_iostat_end(status)) message = last_part(reason)
      close (unit)
      content = content(:length)
   end subroutine read_text

   !> What a message of the runtime says after the path that it repeats.
   pure function last_part(reason) result(text)
      character(*), intent(in) :: reason
      character(:), allocatable :: text

      text = trim(adjustl(reason(index(reason, ': ', back=.true.) + 1:)))
   end function last_part

end module vi_text
