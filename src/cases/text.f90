!> Text: lines, numbers as text, and text that is safe for a terminal.
!!
!! The length of each function result follows from the arguments: gfortran keeps the length of a
!! result that is `character(:), allocatable` in a static variable of the caller, which threads
!! share.
module vi_text
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: append, brief, counted, exact, exact_list, join, last_part, lengthen, &
      letter_length, lower, number_text, printable, shown, split, whole, whole_width

   !> A line of text.
   type, public :: line_type
      character(:), allocatable :: text
   end type line_type

   !> Length up to which `brief` keeps a message whole, and characters that it keeps of longer ones.
   integer, parameter :: longest = 805, head = 200, tail = 400

contains

   !> Adds a line to a growing list.
   pure subroutine append(lines, text)
      !> In and out: the list.
      type(line_type), allocatable, intent(inout) :: lines(:)
      !> The new line.
      character(*), intent(in) :: text

      call lengthen(lines, 1)
      lines(size(lines))%text = text
   end subroutine append

   !> Adds empty lines to a list.
   pure subroutine lengthen(lines, more)
      !> In and out: the list, which need not be allocated; the new lines have no text.
      type(line_type), allocatable, intent(inout) :: lines(:)
      !> Number of lines to add.
      integer, intent(in) :: more
      type(line_type), allocatable :: longer(:)
      integer :: i, n

      ! not [lines, line_type(text)]: gfortran 12 leaks the memory of such a constructor
      n = 0
      if (allocated(lines)) n = size(lines)
      allocate (longer(n + more))
      do i = 1, n
         call move_alloc(lines(i)%text, longer(i)%text)
      end do
      call move_alloc(longer, lines)
   end subroutine lengthen

   !> The text, safe for a terminal: a question mark for each byte of a control character.
   pure function printable(text) result(clean)
      !> Any, in UTF-8 or Latin-1.
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

   !> Number of bytes of the first character of a text, in UTF-8 or else Latin-1; 0 for a control
   !! character.
   pure integer function letter_length(text) result(n)
      !> At least one byte, and up to four.
      character(*), intent(in) :: text
      integer :: bytes(len(text)), i

      bytes = [(iachar(text(i:i)), i=1, len(text))]
      n = merge(1, 0, (bytes(1) >= 32 .and. bytes(1) <= 126) .or. bytes(1) >= 160)
      if (bytes(1) < 194 .or. bytes(1) > 244) return
      i = 2 + count(bytes(1) >= [224, 240])
      if (i > len(text)) return
      if (any(bytes(2:i) < 128 .or. bytes(2:i) > 191)) return
      ! characters in more bytes than needed, surrogates, and numbers above the last character
      if (any(bytes(1) == [224, 237, 240, 244] .and. ([bytes(2) < 160, bytes(2) > 159, &
         bytes(2) < 144, bytes(2) > 143]))) return
      n = merge(0, i, bytes(1) == 194 .and. bytes(2) < 160)
   end function letter_length

   !> A message, shortened in the middle if it is very long: what the user wrote comes first in it.
   pure function brief(text) result(short)
      !> The message.
      character(*), intent(in) :: text
      character(merge(len(text), head + tail + 5, len(text) <= longest)) :: short

      short = text
      if (len(text) > longest) short = text(:head)//' ... '//text(len(text) - tail + 1:)
   end function brief

   !> The text in lower case (ASCII).
   pure function lower(text) result(lowered)
      !> A text.
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
      !> Any number, NaN and infinity included.
      real(wp), intent(in) :: value
      character(exact_width(value)) :: text
      character(24) :: buffer

      write (buffer, '(es24.16e3)') value
      text = adjustl(buffer)
   end function exact

   !> Number of characters of `exact`.
   pure integer function exact_width(value) result(width)
      !> Any number.
      real(wp), intent(in) :: value
      character(24) :: buffer

      if (ieee_is_finite(value)) then
         width = merge(24, 23, sign(1.0_wp, value) < 0)
      else
         write (buffer, '(es24.16e3)') value
         width = len_trim(adjustl(buffer))
      end if
   end function exact_width

   !> Numbers with all their digits, as a list.
   pure function exact_list(values) result(text)
      !> The numbers, at least one.
      real(wp), intent(in) :: values(:)
      character(list_width(values)) :: text
      integer :: i, last, width

      last = exact_width(values(1))
      text(:last) = exact(values(1))
      do i = 2, size(values)
         ! not text(last + 1:), which would fill the rest of a long text with blanks each time
         width = exact_width(values(i))
         text(last + 1:last + 2 + width) = ', '//exact(values(i))
         last = last + 2 + width
      end do
   end function exact_list

   !> Number of characters of `exact_list`.
   pure integer function list_width(values) result(width)
      !> The numbers.
      real(wp), intent(in) :: values(:)
      integer :: i

      width = sum([(exact_width(values(i)) + 2, i=1, size(values))]) - 2
   end function list_width

   !> A number with a few digits, for messages and printed tables.
   pure function shown(value, format) result(text)
      !> The number.
      real(wp), intent(in) :: value
      !> An edit descriptor such as f10.4.
      character(*), intent(in) :: format
      character(len_trim(formatted(value, format))) :: text

      text = formatted(value, format)
   end function shown

   !> The number as `shown`, padded with blanks.
   pure function formatted(value, format) result(text)
      !> The number.
      real(wp), intent(in) :: value
      !> An edit descriptor such as f10.4.
      character(*), intent(in) :: format
      character(40) :: text

      write (text, '('//format//')') value
      text = adjustl(text)
   end function formatted

   !> A number in a short form, with the fewest digits that give the same number when it is read:
   !! 1e-6, 0.75, 1000; padded with blanks.
   pure function number_text(value, is_whole, most) result(text)
      !> Any finite number.
      real(wp), intent(in) :: value
      !> Whether it is a whole number, which never gets an exponent.
      logical, intent(in) :: is_whole
      !> Largest number of digits; by default as many as are needed.
      integer, intent(in), optional :: most
      character(24) :: text
      character(24) :: buffer
      character(17) :: figures
      real(wp) :: again
      integer :: n, power, limit

      if (is_whole) then
         write (text, '(i0)') nint(value)
         return
      end if
      limit = 17
      if (present(most)) limit = most
      do n = 1, limit
         write (buffer, '(es24.'//whole(n - 1)//'e3)') abs(value)
         read (buffer, '(f24.0)') again
         if (again >= abs(value) .and. again <= abs(value)) exit
      end do
      n = min(n, limit)
      buffer = adjustl(buffer)
      read (buffer(index(buffer, 'E') + 1:), '(i4)') power
      figures = buffer(1:1)//buffer(3:index(buffer, 'E') - 1)
      n = max(1, verify(figures, ' 0', back=.true.))
      if (abs(value) <= 0) then
         text = '0'
      else if (power >= 0 .and. power < 5) then
         figures(n + 1:) = repeat('0', 16)
         text = figures(:power + 1)
         if (n > power + 1) text = figures(:power + 1)//'.'//figures(power + 2:n)
      else if (power < 0 .and. power > -4) then
         text = '0.'//repeat('0', -power - 1)//figures(:n)
      else
         text = figures(1:1)
         if (n > 1) text = figures(1:1)//'.'//figures(2:n)
         text = trim(text)//'e'//whole(power)
      end if
      if (value < 0) text = '-'//trim(text)
   end function number_text

   !> A whole number as text.
   pure function whole(value) result(text)
      !> The number.
      integer, intent(in) :: value
      character(whole_width(value)) :: text
      integer :: i, rest

      ! digit by digit: a formatted write takes forty times as long
      rest = value
      do i = len(text), 1, -1
         text(i:i) = achar(iachar('0') + abs(mod(rest, 10)))
         rest = rest/10
      end do
      if (value < 0) text(1:1) = '-'
   end function whole

   !> Number of characters of `whole`.
   pure integer function whole_width(value) result(width)
      !> The number.
      integer, intent(in) :: value
      integer :: rest

      width = merge(2, 1, value < 0)
      rest = value/10
      do while (rest /= 0)
         width = width + 1
         rest = rest/10
      end do
   end function whole_width

   !> The parts of a text between single separators.
   pure function split(text, separator) result(parts)
      !> The text.
      character(*), intent(in) :: text
      !> A single character; two in succession enclose an empty part.
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
      !> The lines, all allocated.
      type(line_type), intent(in) :: lines(:)
      !> A single character.
      character, intent(in) :: separator
      character(joined_width(lines)) :: text
      integer :: i, length

      length = 0
      do i = 1, size(lines)
         text(length + 1:length + len(lines(i)%text)) = lines(i)%text
         length = length + len(lines(i)%text) + 1
         if (i < size(lines)) text(length:length) = separator
      end do
   end function join

   !> Number of characters of `join`.
   pure integer function joined_width(lines) result(width)
      !> The lines.
      type(line_type), intent(in) :: lines(:)
      integer :: i

      width = max(0, sum([(len(lines(i)%text) + 1, i=1, size(lines))]) - 1)
   end function joined_width

   !> A number of things: "1 impact", "2 impacts".
   pure function counted(number, thing) result(text)
      !> The number.
      integer, intent(in) :: number
      !> The singular; the plural is formed with an s.
      character(*), intent(in) :: thing
      character(whole_width(number) + len(thing) + merge(1, 2, number == 1)) :: text

      text = whole(number)//' '//thing//'s'                        ! for one thing the s is cut off
   end function counted

   !> A message of the runtime library without the path at its beginning.
   pure function last_part(reason) result(text)
      !> The message.
      character(*), intent(in) :: reason
      character(len_trim(adjustl(reason(index(reason, ': ', back=.true.) + 1:)))) :: text

      text = adjustl(reason(index(reason, ': ', back=.true.) + 1:))
   end function last_part

end module vi_text
