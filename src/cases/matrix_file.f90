!> Reads matrices from Matrix Market and NumPy files, and tables of samples also from CSV files.
module vi_matrix_file
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   use vi_lines, only: unify_line_ends
   use vi_parse, only: parse_numbers
   use vi_read_file, only: read_bytes
   use vi_text, only: counted, lower, whole
   implicit none (type, external)
   private

   public :: beside, read_matrix, read_samples

   character(*), parameter :: market = '%%matrixmarket', numpy = char(147)//'NUMPY'
   character, parameter :: line_feed = achar(10)

   !> Which shapes a table may have.
   type :: limits_type
      !> Largest numbers of rows, of columns, and of numbers.
      integer :: rows = 0, columns = 0, numbers = 0
      logical :: square = .false.
   end type limits_type

contains

   !> A path relative to the folder of a file.
   pure subroutine beside(file, path, full)
      !> The file; empty for the working directory.
      character(*), intent(in) :: file
      !> A path, which may be absolute.
      character(*), intent(in) :: path
      !> The path as seen from the working directory.
      character(:), allocatable, intent(out) :: full

      full = path
      if (index(path, '/') == 1 .or. index(path, '\') == 1) return
      if (len(path) > 1) then
         if (path(2:2) == ':') return                   ! a drive
      end if
      full = file(:scan(file, '/\', back=.true.))//path
   end subroutine beside

   !> Reads a matrix; a file with a list is its diagonal.
   subroutine read_matrix(path, most, numbers, message)
      !> The file.
      character(*), intent(in) :: path
      !> Largest number of rows.
      integer, intent(in) :: most
      !> The n*n numbers of a square matrix, row by row, or the n numbers of its diagonal.
      real(wp), allocatable, intent(out) :: numbers(:)
      !> What is wrong with the file; empty if nothing is.
      character(:), allocatable, intent(out) :: message
      character(:), allocatable :: content
      integer :: columns
      logical :: found

      call read_bytes(path, content, message)
      allocate (numbers(0))
      if (len(message) > 0) return
      call read_binary_or_market(content, limits_type(most, most, most**2, .true.), numbers, &
         columns, message, found)
      if (.not. found) message = 'it starts neither as a Matrix Market file (%%MatrixMarket) nor &
         &as a NumPy file'
   end subroutine read_matrix

   !> Reads a table of samples; a file with a list has one column.
   subroutine read_samples(path, most_columns, most, numbers, columns, times, message)
      !> The file.
      character(*), intent(in) :: path
      !> Largest numbers of columns and of numbers.
      integer, intent(in) :: most_columns, most
      !> Row by row, one row for each sample.
      real(wp), allocatable, intent(out) :: numbers(:)
      !> Number of columns.
      integer, intent(out) :: columns
      !> The times of the samples, if the file has a column `time`; else empty.
      real(wp), allocatable, intent(out) :: times(:)
      !> What is wrong with the file; empty if nothing is.
      character(:), allocatable, intent(out) :: message
      character(:), allocatable :: content
      logical :: found

      call read_bytes(path, content, message)
      allocate (numbers(0), times(0))
      columns = 0
      if (len(message) > 0) return
      call read_binary_or_market(content, limits_type(most, most_columns, most), numbers, columns, &
         message, found)
      if (.not. found) call read_csv(content, most_columns, most, numbers, columns, times, message)
   end subroutine read_samples

   !> Reads a file in the format of Matrix Market or of NumPy.
   pure subroutine read_binary_or_market(content, limits, numbers, columns, message, found)
      !> The file.
      character(*), intent(in) :: content
      !> The shapes that are allowed.
      type(limits_type), intent(in) :: limits
      !> The numbers, row by row; of a list in a square file only its diagonal.
      real(wp), allocatable, intent(inout) :: numbers(:)
      !> Number of columns.
      integer, intent(out) :: columns
      !> Out: what is wrong with it; not changed if nothing is.
      character(:), allocatable, intent(inout) :: message
      !> Whether it has one of the formats.
      logical, intent(out) :: found

      columns = 0
      found = .true.
      if (lower(content(:min(len(market), len(content)))) == market) then
         call read_market(content, limits, numbers, columns, message)
      else if (index(content, numpy) == 1) then
         call read_numpy(content, limits, numbers, columns, message)
      else
         found = .false.
      end if
   end subroutine read_binary_or_market

   !> Samples as text: numbers with commas or blanks between them, a line for each sample. Lines
   !! that start with # or % are comments; the first other line may hold names.
   pure subroutine read_csv(content, most_columns, most, numbers, columns, times, message)
      !> The file.
      character(*), intent(in) :: content
      !> Largest numbers of columns and of numbers.
      integer, intent(in) :: most_columns, most
      !> The numbers, row by row.
      real(wp), allocatable, intent(inout) :: numbers(:)
      !> In: 0. Out: number of columns, without that of the times, if nothing is wrong.
      integer, intent(inout) :: columns
      !> The times, if the first name is time or t; else empty.
      real(wp), allocatable, intent(inout) :: times(:)
      !> Out: what is wrong with it; not changed if nothing is.
      character(:), allocatable, intent(inout) :: message
      character(:), allocatable :: text, words
      real(wp), allocatable :: values(:), table(:)
      integer :: at, empty, line, n, rows, width
      logical :: good, timed

      call unify_line_ends(content, text)
      text = text//line_feed
      at = 1
      line = 0
      call skip_names(text, at, line, timed)
      allocate (table(1024))
      rows = 0
      width = 0
      n = 0
      empty = 0
      do while (at <= len(text))
         call next_line(text, at, line, words)
         if (len_trim(words) == 0) then
            empty = line
            cycle
         end if
         if (scan(words(1:1), '#%') > 0) cycle
         good = scan(words, '*') == 0 .and. (empty == 0 .or. rows == 0)
         if (good) call parse_numbers(words, .false., most_columns + 1, values, good)
         if (good .and. width > 0) good = size(values) == width
         if (.not. good) then
            if (empty > 0 .and. rows > 0) line = empty
            message = 'line '//whole(line)//': must contain '
            if (width > 0) message = message//counted(width, 'finite number')// &
               ', like the lines before'
            if (width == 0) message = message//'finite numbers, at most '//whole(most_columns)
            return
         end if
         width = size(values)
         rows = rows + 1
         if (rows > most/width) then
            message = 'it has more than '//whole(most)//' numbers'
            return
         end if
         if (n + width > size(table)) table = [table, table]
         table(n + 1:n + width) = values
         n = n + width
      end do
      if (rows == 0) then
         message = 'it contains no numbers'
         return
      end if
      columns = width
      if (timed) columns = width - 1
      if (timed) times = table(1:n:width)
      if (columns == 0) message = 'it has only a column of times'
      deallocate (numbers)
      allocate (numbers(columns*rows))
      do at = 1, rows
         numbers((at - 1)*columns + 1:at*columns) = table(at*width - columns + 1:at*width)
      end do
   end subroutine read_csv

   !> Skips comments and a line of names.
   pure subroutine skip_names(text, at, line, timed)
      !> The file, with a line feed at its end.
      character(*), intent(in) :: text
      !> In and out: position where a line begins, and the number of the line before.
      integer, intent(inout) :: at, line
      !> Whether the first name is time or t; a unit may follow it.
      logical, intent(out) :: timed
      character(*), parameter :: byte_order_mark = char(239)//char(187)//char(191)
      character, parameter :: quote = achar(39)
      character(:), allocatable :: name
      integer :: first, last

      timed = .false.
      if (index(text, byte_order_mark) == 1) at = at + len(byte_order_mark)
      do while (at <= len(text))
         first = at + verify(text(at:), ' '//achar(9)) - 1
         last = at + index(text(at:), line_feed) - 2
         if (first <= last) then
            if (scan(text(first:first), '#%') == 0) exit
         end if
         at = last + 2
         line = line + 1
      end do
      if (at > len(text)) return
      ! a first word that begins with a letter is a name, unless it is meant as a number
      name = lower(text(first:last))
      if (scan(name(1:1), '"'//quote) > 0) name = name(2:)
      if (len(name) == 0) return
      if (scan(name(1:1), 'abcdefghijklmnopqrstuvwxyz') == 0) return
      if (index(name, 'nan') == 1 .or. index(name, 'inf') == 1) return
      timed = index(name, 'time') == 1
      if (name(1:1) == 't' .and. .not. timed) timed = verify(name(2:min(2, len(name))), &
         ' ,"([;'//quote//achar(9)) == 0
      at = last + 2
      line = line + 1
   end subroutine skip_names

   !> Checks the shape of a table.
   pure subroutine check_shape(rows, columns, limits, message)
      !> Its shape.
      real(wp), intent(in) :: rows, columns
      !> The shapes that are allowed.
      type(limits_type), intent(in) :: limits
      !> Out: what is wrong with it; not changed if nothing is.
      character(:), allocatable, intent(inout) :: message

      if (rows < 1 .or. columns < 1 .or. rows > limits%rows .or. columns > limits%columns) then
         message = 'it has '//shown(rows)//' rows and '//shown(columns)//' columns; must be 1 to '
         if (limits%square) message = message//whole(limits%rows)
         if (.not. limits%square) message = message//whole(limits%rows)//' rows and 1 to '// &
            whole(limits%columns)//' columns'
      else if (limits%square .and. abs(rows - columns) > 0) then
         message = 'it has '//shown(rows)//' rows and '//shown(columns)//' columns; must be square'
      else if (rows*columns > limits%numbers) then
         message = 'it has more than '//whole(limits%numbers)//' numbers'
      end if
   end subroutine check_shape

   !> A whole number for a message.
   pure function shown(value) result(text)
      !> Any number.
      real(wp), intent(in) :: value
      character(len(whole(int(max(-1.0e9_wp, min(1.0e9_wp, value)))))) :: text

      text = whole(int(max(-1.0e9_wp, min(1.0e9_wp, value))))
   end function shown

   !> A matrix in the format of Matrix Market: real, general or symmetric, coordinate or array.
   pure subroutine read_market(content, limits, numbers, columns, message)
      !> The file.
      character(*), intent(in) :: content
      !> The shapes that are allowed.
      type(limits_type), intent(in) :: limits
      !> The numbers, row by row.
      real(wp), allocatable, intent(inout) :: numbers(:)
      !> In: 0. Out: number of columns, if nothing is wrong.
      integer, intent(inout) :: columns
      !> Out: what is wrong with it; not changed if nothing is.
      character(:), allocatable, intent(inout) :: message
      character(:), allocatable :: text
      real(wp), allocatable :: values(:), matrix(:, :)
      logical, allocatable :: given(:, :)
      logical :: coordinates, symmetric, good, ended
      integer :: at, line, i, j, k, rows, entries

      call unify_line_ends(content, text)
      text = text//line_feed
      at = index(text, line_feed)
      call read_kind(lower(text(:at - 1)), coordinates, symmetric, message)
      if (len(message) > 0) return
      at = at + 1
      line = 1
      call next_numbers(text, at, line, 3, values, good)
      good = good .and. size(values) == merge(3, 2, coordinates)
      if (good) good = all(abs(values - anint(values)) <= 0 .and. values >= 0)
      if (.not. good) then
         message = 'line '//whole(line)//': must contain the numbers of rows'// &
            trim(merge(', columns and entries', ' and columns         ', coordinates))
         return
      end if
      call check_shape(values(1), values(2), limits, message)
      if (symmetric .and. abs(values(1) - values(2)) > 0) message = 'line '//whole(line)// &
         ': must be square, since it is symmetric'
      if (len(message) > 0) return
      rows = nint(values(1))
      columns = nint(values(2))
      entries = rows*columns
      if (symmetric) entries = rows*(rows + 1)/2
      if (coordinates) then
         if (values(3) > entries) message = 'line '//whole(line)//': it has more than '// &
            whole(entries)//' entries'
         if (len(message) > 0) return
         entries = nint(values(3))
      end if
      allocate (matrix(rows, columns), source=0.0_wp)
      allocate (given(rows, columns), source=.false.)
      i = 0
      j = 1
      do k = 1, entries
         call next_numbers(text, at, line, merge(3, 1, coordinates), values, good)
         good = good .and. size(values) == merge(3, 1, coordinates)
         if (.not. good) then
            message = 'line '//whole(line)//': must contain '//trim(merge('row, column and value', &
               'one number           ', coordinates))//' of entry '//whole(k)//' of '// &
               whole(entries)
            return
         end if
         if (coordinates) then
            good = all(abs(values(:2) - anint(values(:2))) <= 0 .and. values(:2) >= 1 .and. &
               values(:2) <= [rows, columns])
            if (good) then
               i = nint(values(1))
               j = nint(values(2))
               good = .not. given(i, j)
            end if
            if (.not. good) then
               message = 'line '//whole(line)//': must give a row and a column, not given before, &
                  &within '// &
                  whole(rows)//' rows and '//whole(columns)//' columns'
               return
            end if
         else if (i < rows) then
            i = i + 1                                   ! column by column
         else
            j = j + 1
            i = merge(j, 1, symmetric)
         end if
         matrix(i, j) = values(size(values))
         given(i, j) = .true.
         if (symmetric) matrix(j, i) = matrix(i, j)
         if (symmetric) given(j, i) = .true.
      end do
      call next_numbers(text, at, line, 1, values, good, ended)
      if (.not. ended) message = 'line '//whole(line)//': there must be nothing after the last &
         &entry'
      numbers = [transpose(matrix)]
   end subroutine read_market

   !> The kind of matrix from the first line of a Matrix Market file.
   pure subroutine read_kind(head, coordinates, symmetric, message)
      !> The line in lower case.
      character(*), intent(in) :: head
      !> Whether entries are listed with row and column, and whether only one triangle is given.
      logical, intent(out) :: coordinates, symmetric
      !> Out: what is wrong with it; not changed if nothing is.
      character(:), allocatable, intent(inout) :: message
      character(:), allocatable :: words
      integer :: i

      words = ' '
      do i = len(market) + 1, len(head)
         if (head(i:i) /= ' ' .and. head(i:i) /= achar(9)) then
            words = words//head(i:i)
         else if (words(len(words):) /= ' ') then
            words = words//' '
         end if
      end do
      words = trim(words)
      coordinates = index(words, ' matrix coordinate ') == 1
      symmetric = index(words, ' symmetric') == len(words) - 9
      if (any(words == [character(40) :: ' matrix coordinate real general', &
         ' matrix coordinate real symmetric', ' matrix array real general', &
         ' matrix array real symmetric', ' matrix coordinate integer general', &
         ' matrix coordinate integer symmetric', ' matrix array integer general', &
         ' matrix array integer symmetric'])) return
      message = 'line 1: must declare a matrix that is coordinate or array, real, and general or &
         &symmetric'
   end subroutine read_kind

   !> The next line; tabs become blanks.
   pure subroutine next_line(text, at, line, words)
      !> The file, with a line feed at its end.
      character(*), intent(in) :: text
      !> In and out: position where a line begins, and the number of the line before.
      integer, intent(inout) :: at, line
      !> The line.
      character(:), allocatable, intent(out) :: words
      integer :: first, i

      first = at
      at = first + index(text(first:), line_feed)
      line = line + 1
      words = text(first:at - 2)
      do i = 1, len(words)
         if (words(i:i) == achar(9)) words(i:i) = ' '
      end do
   end subroutine next_line

   !> The numbers of the next line that is neither empty nor a comment.
   pure subroutine next_numbers(text, at, line, most, numbers, good, ended)
      !> The file, with a line feed at its end.
      character(*), intent(in) :: text
      !> In and out: position where a line begins.
      integer, intent(inout) :: at
      !> In: number of the line before. Out: number of the line that was read.
      integer, intent(inout) :: line
      !> Largest number of values.
      integer, intent(in) :: most
      !> The numbers.
      real(wp), allocatable, intent(out) :: numbers(:)
      !> False at the end of the file, or where the line holds something else.
      logical, intent(out) :: good
      !> Whether this is the end of the file.
      logical, intent(out), optional :: ended
      character(:), allocatable :: words

      good = .false.
      if (present(ended)) ended = .false.
      allocate (numbers(0))
      do while (at <= len(text))
         call next_line(text, at, line, words)
         if (len_trim(words) == 0) cycle
         if (words(1:1) == '%') cycle
         good = scan(words, '*,') == 0
         if (good) call parse_numbers(words, .false., most, numbers, good)
         return
      end do
      if (present(ended)) ended = .true.
   end subroutine next_numbers

   !> A matrix in NumPy's format, version 1 to 3: 8-byte numbers, row by row or column by column.
   pure subroutine read_numpy(content, limits, numbers, columns, message)
      !> The file.
      character(*), intent(in) :: content
      !> The shapes that are allowed.
      type(limits_type), intent(in) :: limits
      !> The numbers, row by row, or those of a list.
      real(wp), allocatable, intent(inout) :: numbers(:)
      !> In: 0. Out: number of columns, if nothing is wrong.
      integer, intent(inout) :: columns
      !> Out: what is wrong with it; not changed if nothing is.
      character(:), allocatable, intent(inout) :: message
      character(:), allocatable :: head, kind, order, shape
      real(wp), allocatable :: sizes(:)
      integer(int64) :: bits
      integer :: start, length, i, j, rows, place
      logical :: good

      length = -1
      start = 0
      if (len(content) >= 12) then
         select case (iachar(content(7:7)))
         case (1)
            start = 10
            length = iachar(content(9:9)) + 256*iachar(content(10:10))
         case (2, 3)
            start = 12
            if (iachar(content(12:12)) == 0) length = iachar(content(9:9)) + &
               256*(iachar(content(10:10)) + 256*iachar(content(11:11)))
         case default
            continue
         end select
      end if
      if (length < 0 .or. length > len(content) - start) then
         message = 'its header is damaged, or its version is not 1, 2 or 3'
         return
      end if
      head = content(start + 1:start + length)
      start = start + length
      call find_item(head, 'descr', ',', kind)
      call find_item(head, 'fortran_order', ',', order)
      call find_item(head, 'shape', ')', shape)
      if (kind /= '''<f8''' .and. kind /= '''>f8''') then
         message = 'it holds '//kind//'; must be float64 (''<f8'')'
         return
      end if
      good = (order == 'True' .or. order == 'False') .and. index(shape, '(') == 1
      allocate (sizes(0))
      if (good) then
         i = len(shape)
         if (shape(i:i) == ',') i = i - 1
         call parse_numbers(shape(2:i), .true., 2, sizes, good)
      end if
      if (.not. good) then
         message = 'it has the shape '//shape//'); must be a '//trim(merge('square matrix', &
            'table        ', limits%square))//', or a list'
         return
      end if
      if (size(sizes) == 1) sizes = [sizes(1), merge(sizes(1), 1.0_wp, limits%square)]
      call check_shape(sizes(1), sizes(2), limits, message)
      if (len(message) > 0) return
      rows = nint(sizes(1))
      columns = nint(sizes(2))
      length = rows*columns
      if (index(shape, ',') == len(shape) .or. index(shape, ',') == 0) length = rows
      if (len(content) - start /= 8*length) then
         message = 'it has '//whole(len(content) - start)//' bytes of numbers; must be '// &
            whole(8*length)
         return
      end if
      deallocate (numbers)
      allocate (numbers(length))
      do i = 1, length
         place = i
         if (length > rows .and. order == 'True') place = 1 + modulo(i - 1, rows)*columns &
            + (i - 1)/rows
         bits = 0
         do j = 0, 7
            bits = ior(bits, shiftl(int(iachar(content(start + 8*i - j:start + 8*i - j)), int64), &
               8*(7 - j)))
         end do
         if (kind(2:2) == '>') bits = swapped(bits)
         numbers(place) = transfer(bits, 1.0_wp)
      end do
      i = findloc(abs(numbers) <= huge(1.0_wp), .false., 1)
      if (i == 0) return
      message = 'it contains a number that is not finite, in row '//whole(1 + (i - 1)/columns)// &
         ', column '//whole(1 + modulo(i - 1, columns))
      if (length == rows) message = 'it contains a number that is not finite, number '//whole(i)
   end subroutine read_numpy

   !> The same bytes in the opposite order.
   pure integer(int64) function swapped(bits)
      !> Eight bytes.
      integer(int64), intent(in) :: bits
      integer :: i

      swapped = 0
      do i = 0, 7
         swapped = ior(swapped, shiftl(ibits(bits, 8*i, 8), 8*(7 - i)))
      end do
   end function swapped

   !> The value of a name in the header of a NumPy file, up to a character; empty if there is none.
   pure subroutine find_item(head, name, last, text)
      !> The header.
      character(*), intent(in) :: head
      !> The name.
      character(*), intent(in) :: name
      !> The character after the value.
      character, intent(in) :: last
      !> The value without blanks.
      character(:), allocatable, intent(out) :: text
      integer :: i, first

      text = ''
      first = index(head, ''''//name//''':')
      if (first == 0) return
      do i = first + len(name) + 3, len(head)
         if (head(i:i) == last) return
         if (head(i:i) /= ' ') text = text//head(i:i)
      end do
   end subroutine find_item

end module vi_matrix_file
