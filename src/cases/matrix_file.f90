!> Reads matrices from Matrix Market and NumPy files.
module vi_matrix_file
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   use vi_lines, only: unify_line_ends
   use vi_parse, only: parse_numbers
   use vi_read_file, only: read_bytes
   use vi_text, only: lower, whole
   implicit none (type, external)
   private

   public :: beside, read_matrix

   character(*), parameter :: market = '%%matrixmarket', numpy = char(147)//'NUMPY'
   character, parameter :: line_feed = achar(10)

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

      allocate (numbers(0))
      call read_bytes(path, content, message)
      if (len(message) > 0) return
      if (lower(content(:min(len(market), len(content)))) == market) then
         call read_market(content, most, numbers, message)
      else if (index(content, numpy) == 1) then
         call read_numpy(content, most, numbers, message)
      else
         message = 'it starts neither as a Matrix Market file (%%MatrixMarket) nor as a NumPy file'
      end if
   end subroutine read_matrix

   !> Checks the shape of a matrix.
   pure subroutine check_shape(rows, columns, most, message)
      !> Its shape.
      real(wp), intent(in) :: rows, columns
      !> Largest number of rows.
      integer, intent(in) :: most
      !> Out: what is wrong with it; not changed if nothing is.
      character(:), allocatable, intent(inout) :: message

      if (rows < 1 .or. columns < 1 .or. rows > most .or. columns > most) then
         message = 'it has '//shown(rows)//' rows and '//shown(columns)// &
            ' columns; must be 1 to '//whole(most)
      else if (abs(rows - columns) > 0) then
         message = 'it has '//shown(rows)//' rows and '//shown(columns)//' columns; must be square'
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
   pure subroutine read_market(content, most, numbers, message)
      !> The file.
      character(*), intent(in) :: content
      !> Largest number of rows.
      integer, intent(in) :: most
      !> The n*n numbers, row by row.
      real(wp), allocatable, intent(inout) :: numbers(:)
      !> Out: what is wrong with it; not changed if nothing is.
      character(:), allocatable, intent(inout) :: message
      character(:), allocatable :: text
      real(wp), allocatable :: values(:), matrix(:, :)
      logical, allocatable :: given(:, :)
      logical :: coordinates, symmetric, good, ended
      integer :: at, line, i, j, k, n, entries

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
         message = 'line '//whole(line)//': must hold the numbers of rows'// &
            trim(merge(', columns and entries', ' and columns         ', coordinates))
         return
      end if
      call check_shape(values(1), values(2), most, message)
      if (len(message) > 0) return
      n = nint(values(1))
      entries = n*n
      if (symmetric) entries = n*(n + 1)/2
      if (coordinates) then
         if (values(3) > entries) message = 'line '//whole(line)//': it has more than '// &
            whole(entries)//' entries'
         if (len(message) > 0) return
         entries = nint(values(3))
      end if
      allocate (matrix(n, n), source=0.0_wp)
      allocate (given(n, n), source=.false.)
      i = 0
      j = 1
      do k = 1, entries
         call next_numbers(text, at, line, merge(3, 1, coordinates), values, good)
         good = good .and. size(values) == merge(3, 1, coordinates)
         if (.not. good) then
            message = 'line '//whole(line)//': must hold '//trim(merge('row, column and value', &
               'one number           ', coordinates))//' of entry '//whole(k)//' of '// &
               whole(entries)
            return
         end if
         if (coordinates) then
            good = all(abs(values(:2) - anint(values(:2))) <= 0 .and. values(:2) >= 1 .and. &
               values(:2) <= n)
            if (good) then
               i = nint(values(1))
               j = nint(values(2))
               good = .not. given(i, j)
            end if
            if (.not. good) then
               message = 'line '//whole(line)//': must be another entry of the '//whole(n)// &
                  ' rows and columns'
               return
            end if
         else if (i < n) then
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
      if (.not. ended) message = 'line '//whole(line)//': stands after the last entry'
      numbers = [transpose(matrix)]
   end subroutine read_market

   !> The kind of matrix from the first line of a Matrix Market file.
   pure subroutine read_kind(head, coordinates, symmetric, message)
      !> The line in lower case.
      character(*), intent(in) :: head
      !> Whether entries stand with their row and column, and whether only one triangle is given.
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
      message = 'line 1: must be matrix, coordinate or array, real, general or symmetric'
   end subroutine read_kind

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
      integer :: first, i

      good = .false.
      if (present(ended)) ended = .false.
      allocate (numbers(0))
      do while (at <= len(text))
         first = at
         at = first + index(text(first:), line_feed)
         line = line + 1
         words = text(first:at - 2)
         do i = 1, len(words)
            if (words(i:i) == achar(9)) words(i:i) = ' '
         end do
         if (len_trim(words) == 0) cycle
         if (words(1:1) == '%') cycle
         good = scan(words, '*,') == 0
         if (good) call parse_numbers(words, .false., most, numbers, good)
         return
      end do
      if (present(ended)) ended = .true.
   end subroutine next_numbers

   !> A matrix in NumPy's format, version 1 to 3: 8-byte numbers, row by row or column by column.
   pure subroutine read_numpy(content, most, numbers, message)
      !> The file.
      character(*), intent(in) :: content
      !> Largest number of rows.
      integer, intent(in) :: most
      !> The n*n numbers, row by row, or the n numbers of a diagonal.
      real(wp), allocatable, intent(inout) :: numbers(:)
      !> Out: what is wrong with it; not changed if nothing is.
      character(:), allocatable, intent(inout) :: message
      character(:), allocatable :: head, kind, order, shape
      real(wp), allocatable :: sizes(:)
      integer(int64) :: bits
      integer :: start, length, i, j, n, place
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
         message = 'it has the shape '//shape//'); must be a square matrix, or a list'
         return
      end if
      if (size(sizes) == 1) sizes = [sizes, sizes]
      call check_shape(sizes(1), sizes(2), most, message)
      if (len(message) > 0) return
      n = nint(sizes(1))
      length = n*n
      if (index(shape, ',') == len(shape) .or. index(shape, ',') == 0) length = n
      if (len(content) - start /= 8*length) then
         message = 'it has '//whole(len(content) - start)//' bytes of numbers; must be '// &
            whole(8*length)
         return
      end if
      deallocate (numbers)
      allocate (numbers(length))
      do i = 1, length
         place = i
         if (length > n .and. order == 'True') place = 1 + modulo(i - 1, n)*n + (i - 1)/n
         bits = 0
         do j = 0, 7
            bits = ior(bits, shiftl(int(iachar(content(start + 8*i - j:start + 8*i - j)), int64), &
               8*(7 - j)))
         end do
         if (kind(2:2) == '>') bits = swapped(bits)
         numbers(place) = transfer(bits, 1.0_wp)
      end do
      if (.not. all(abs(numbers) <= huge(1.0_wp))) message = 'it holds a number that is not finite'
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
