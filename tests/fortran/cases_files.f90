!> Texts of files: whatever is written in any format is read back, and errors are named by line.
module cases_files
   use, intrinsic :: ieee_arithmetic, only: ieee_negative_inf, ieee_value
   use checks, only: check
   use random_numbers, only: draw, draw_integer, random_type
   use vi_case, only: check_output, output_keys
   use vi_key, only: a_whole, key_type
   use vi_kinds, only: wp
   use vi_matrix_file, only: beside, read_matrix, read_samples
   use vi_namelist, only: group_type, scan_namelist
   use vi_read_file, only: is_result, read_text
   use vi_result, only: words
   use vi_text, only: exact, join, line_type, printable, split, whole
   use vi_values, only: read_values, values_type
   implicit none (type, external)
   private

   public :: test_files

   character, parameter :: line_feed = achar(10), tab = achar(9)
   character(*), parameter :: path = 'test_cases.file', market = '%%MatrixMarket matrix '
   type(random_type) :: random

contains

   subroutine test_files()
      integer :: i

      do i = 1, 60
         call test_split(i)
         call test_namelist(i)
         call test_matrix(draw_integer(random, 1, 5), mod(i, 2) == 0)
         call test_samples(merge(1500, i, i == 60), draw_integer(random, 1, 4), mod(i, 4))
      end do
      call test_open_group()
      call test_wrong_matrices()
      call test_wrong_numpy()
      call test_wrong_samples()
      call test_infinite_numbers()
      call test_comments_between()
      call test_paths()
      call test_texts()
      call test_lists_in_parts()
      call test_near_zero()
      call test_printable()
      call test_whole()
      call test_names()
      open (newunit=i, file=path)
      close (i, status='delete')
   end subroutine test_files

   !> A text consists of its parts with the separators between them.
   subroutine test_split(n)
      integer, intent(in) :: n
      type(line_type), allocatable :: parts(:)
      character(n) :: text
      integer :: i

      do i = 1, n
         text(i:i) = merge(';', 'x', draw_integer(random, 1, 3) == 1)
      end do
      allocate (parts, source=split(text, ';'))
      call check(join(parts, ';') == text, 'parts that are joined are the text')
      call check(all([(index(parts(i)%text, ';') == 0, i=1, size(parts))]), &
         'no part holds a separator')
   end subroutine test_split

   !> A whole number has the digits of a formatted write.
   subroutine test_whole()
      integer, parameter :: numbers(*) = [0, 7, -7, 10, -10, 99, 100, -1234567890, huge(1), &
         -huge(1), -huge(1) - 1]
      character(12) :: written
      integer :: i

      do i = 1, size(numbers)
         write (written, '(i0)') numbers(i)
         call check(whole(numbers(i)) == trim(written) .and. len(whole(numbers(i))) == &
            len_trim(written), 'digits of a whole number')
      end do
   end subroutine test_whole

   !> Groups that are written with comments and in any layout, in a file and in a result.
   subroutine test_namelist(n_groups)
      integer, intent(in) :: n_groups
      type(group_type), allocatable :: groups(:)
      character(:), allocatable :: text, message
      character(*), parameter :: gaps(*) = [character(12) :: ' ', '', line_feed, &
         '! = / '' '//line_feed, tab//line_feed//line_feed]
      integer :: lines(0:3, n_groups), counts(n_groups), form, i, j, line

      text = ''
      do i = 1, n_groups
         call add_gap(text)
         lines(0, i) = line_of(text)
         text = text//'&'//merge('G', 'g', mod(i, 2) == 0)//whole(i)//' '
         counts(i) = draw_integer(random, 0, 3)
         do j = 1, counts(i)
            call add_gap(text)
            lines(j, i) = line_of(text)
            text = text//'K'//whole(j)//'('//whole(i)//')'
            call add_gap(text)
            text = text//'= '//whole(10*i + j)//', ''a = /!'''
            if (draw_integer(random, 1, 2) == 1) text = text//','
            text = text//' '
         end do
         text = text//trim(merge('/   ', '&end', mod(i, 3) > 0))//line_feed
      end do
      do form = 1, 2
         if (form == 2) text = '#'//with_sharps(text)//line_feed//'1,2,3'
         call scan_namelist(text, groups, line, message)
         call check(message == '' .and. line == 0 .and. size(groups) == n_groups, 'all groups')
         do i = 1, min(n_groups, size(groups))
            call check(groups(i)%name == 'g'//whole(i) .and. groups(i)%line == lines(0, i) .and. &
               size(groups(i)%items) == counts(i), 'name and line of a group')
            do j = 1, min(counts(i), size(groups(i)%items))
               associate (item => groups(i)%items(j))
                  call check(item%target == 'k'//whole(j)//'('//whole(i)//')' .and. &
                     item%key == 'k'//whole(j), 'name of a key')
                  call check(item%value == whole(10*i + j)//', ''a = /!''', 'value of a key')
                  call check(item%line == lines(j, i), 'line of a key')
               end associate
            end do
         end do
      end do

   contains

      !> Adds blanks, line ends or a comment.
      subroutine add_gap(to)
         character(:), allocatable, intent(inout) :: to

         to = to//' '//trim(gaps(draw_integer(random, 1, size(gaps))))
      end subroutine add_gap

   end subroutine test_namelist

   !> A name at the end of the text is named as it is.
   subroutine test_open_group()
      type(group_type), allocatable :: groups(:)
      character(:), allocatable :: message
      integer :: line

      call scan_namelist('&g x = 1 /'//line_feed//' &abc', groups, line, message)
      call check(index(message, '&abc: ') == 1 .and. line == 2, message)
   end subroutine test_open_group

   !> Number of the last line of a text.
   pure integer function line_of(text)
      character(*), intent(in) :: text
      integer :: i

      line_of = 1 + count([(text(i:i) == line_feed, i=1, len(text))])
   end function line_of

   !> A text with # at the beginning of each line but the first.
   pure function with_sharps(text) result(marked)
      character(*), intent(in) :: text
      character(len(text) + line_of(text) - 1) :: marked
      integer :: i, n

      n = 0
      do i = 1, len(text)
         n = n + 1
         marked(n:n) = text(i:i)
         if (text(i:i) == line_feed) then
            n = n + 1
            marked(n:n) = '#'
         end if
      end do
   end function with_sharps

   !> One matrix in all forms of both formats.
   subroutine test_matrix(n, symmetric)
      integer, intent(in) :: n
      logical, intent(in) :: symmetric
      character(:), allocatable :: list, entries, kind, bytes
      character :: order
      real(wp) :: matrix(n, n)
      integer :: i, j

      do j = 1, n
         do i = 1, n
            matrix(i, j) = draw(random, -1.0_wp, 1.0_wp)
            if (symmetric) matrix(j, i) = matrix(i, j)
         end do
      end do
      list = ''
      entries = ''
      do j = 1, n
         do i = merge(j, 1, symmetric), n
            list = list//exact(matrix(i, j))//line_feed//'% comment'//line_feed//line_feed
            entries = whole(i)//tab//whole(j)//' '//exact(matrix(i, j))//line_feed//entries
         end do
      end do
      kind = trim(merge('symmetric', 'general  ', symmetric))
      call write_file(market//'array real '//kind//achar(13)//line_feed//whole(n)//' '//whole(n) &
         //line_feed//list)
      call check_matrix(matrix, 'column by column')
      i = n**2
      if (symmetric) i = n*(n + 1)/2
      call write_file(market//' coordinate'//tab//'real '//kind//line_feed//'%'//line_feed &
         //whole(n)//' '//whole(n)//' '//whole(i)//line_feed//entries)
      call check_matrix(matrix, 'entry by entry')
      do i = 1, 2
         bytes = ''
         order = merge('F', 'T', i == 1)
         do j = 1, n*n
            associate (row => 1 + (j - 1)/n, column => 1 + modulo(j - 1, n))
               bytes = bytes//bytes_of(merge(matrix(row, column), matrix(column, row), i == 1), &
                  i == 1)
            end associate
         end do
         call write_numpy(merge('<', '>', i == 1), trim(merge('False', 'True ', i == 1)), &
            '('//whole(n)//', '//whole(n)//')', bytes, i)
         call check_matrix(matrix, 'NumPy, fortran_order '//order)
      end do
      bytes = ''
      do j = 1, n
         bytes = bytes//bytes_of(matrix(j, 1), .true.)
      end do
      call write_numpy('<', 'True', '('//whole(n)//',)', bytes, 3)
      call check_matrix(matrix(:, :1), 'a list')
      call write_numpy('<', 'True', '('//whole(n)//')', bytes, 3)
      call check_matrix(matrix(:, :1), 'a list without the comma of Python')
   end subroutine test_matrix

   !> The eight bytes of a number, the lowest first or last.
   pure function bytes_of(value, lowest_first) result(bytes)
      real(wp), intent(in) :: value
      logical, intent(in) :: lowest_first
      character(8) :: bytes, given
      integer :: i

      given = transfer(value, given)
      if (iachar(transfer(1, 'a')) == 1 .eqv. lowest_first) then
         bytes = given
      else
         bytes = ''
         do i = 1, 8
            bytes(i:i) = given(9 - i:9 - i)
         end do
      end if
   end function bytes_of

   !> Writes a file in a given version of NumPy's format.
   subroutine write_numpy(first, order, shape_text, bytes, version)
      character(*), intent(in) :: first, order, shape_text, bytes
      integer, intent(in) :: version

      call write_numpy_of(first//'f8', order, shape_text, bytes, version)
   end subroutine write_numpy

   !> The same with numbers of any kind.
   subroutine write_numpy_of(kind, order, shape_text, bytes, version)
      character(*), intent(in) :: kind, order, shape_text, bytes
      integer, intent(in) :: version
      character(:), allocatable :: head

      head = '{''descr'': '''//kind//''', ''fortran_order'': '//order//', ''shape'': '// &
         shape_text//', }'//repeat(' ', 300)//line_feed
      call write_file(char(147)//'NUMPY'//char(version)//char(0)//char(modulo(len(head), 256))// &
         char(len(head)/256)//repeat(char(0), merge(0, 2, version == 1))//head//bytes)
   end subroutine write_numpy_of

   !> Reads the file as the rows of a matrix.
   subroutine check_matrix(matrix, what)
      real(wp), intent(in) :: matrix(:, :)
      character(*), intent(in) :: what
      real(wp), allocatable :: numbers(:)
      character(:), allocatable :: message

      call read_matrix(path, 5, numbers, message)
      call check(message == '', what//' '//message)
      call check(size(numbers) == size(matrix), 'size of a matrix '//what)
      if (size(numbers) == size(matrix)) call check(all(abs(numbers - [transpose(matrix)]) <= 0), &
         'numbers of a matrix '//what)
   end subroutine check_matrix

   !> Samples in a table with or without names and times, with each kind of line end.
   subroutine test_samples(n, m, form)
      integer, intent(in) :: n, m, form
      character(:), allocatable :: text, message, ending
      real(wp) :: table(m, n), time(n)
      real(wp), allocatable :: numbers(:), times(:)
      integer :: i, j, columns

      ending = line_feed
      if (mod(n, 3) == 0) ending = achar(13)//line_feed
      if (mod(n, 3) == 1) ending = achar(13)
      text = ''
      if (form == 0) text = char(239)//char(187)//char(191)
      if (mod(n, 2) == 0) text = text//'# a comment'//ending//ending//' % another'//ending
      if (form == 1) text = text//'"Time (s)", x, 2'//ending
      if (form == 2) text = text//'t'//tab//'x'//ending
      if (form == 3) text = text//'torque 1'//ending
      do i = 1, n
         time(i) = draw(random, 0.0_wp, 1.0_wp)
         if (form == 1 .or. form == 2) call add(text, exact(time(i))//',')
         do j = 1, m
            table(j, i) = draw(random, -1.0_wp, 1.0_wp)
            call add(text, exact(table(j, i))//merge(tab, ' ', form == 2))
         end do
         if (i < n .or. mod(n, 2) == 0) call add(text, ending)
      end do
      call write_file(text)
      call read_samples(path, m, (m + 1)*n, numbers, columns, times, message)
      call check(message == '', 'samples: '//message)
      call check(columns == m .and. size(numbers) == m*n .and. &
         size(times) == merge(n, 0, form == 1 .or. form == 2), 'shape of a table of samples')
      if (size(numbers) == m*n) call check(all(abs(numbers - [table]) <= 0), 'numbers of samples')
      if (size(times) == n) call check(all(abs(times - time) <= 0), 'times of samples')
   end subroutine test_samples

   !> Adds to a text. The stack that a compiler uses for the result is free again after the call.
   subroutine add(text, more)
      character(:), allocatable, intent(inout) :: text
      character(*), intent(in) :: more

      text = text//more
   end subroutine add

   !> The first invalid line is named, with its requirement.
   subroutine test_wrong_matrices()
      character(*), parameter :: outside(*) = [character(5) :: '3 1', '1 3', '0 1', '1 0', &
         '1.5 1', '1 1.5']
      integer :: i

      call refuse_matrix('array real general|2 2|1|x|y|4|', &
         'line 4: must contain one number of entry 2 of 4')
      call refuse_matrix('array real general|2 2|1|2|3|', &
         'line 6: must contain one number of entry 4 of 4')
      call refuse_matrix('array real general|1 1|1|%|2|', &
         'line 5: there must be nothing after the last entry')
      call refuse_matrix('array real general|1.5 1|1|', &
         'line 2: must contain the numbers of rows and columns')
      call refuse_matrix('array real symmetric|1 2|1|2|', &
         'line 2: must be square, since it is symmetric')
      call refuse_matrix('array real general|1 2|1|2|', &
         'it has 1 rows and 2 columns; must be square')
      call refuse_matrix('array real general|6 6|1|', &
         'it has 6 rows and 6 columns; must be 1 to 5')
      call refuse_matrix('coordinate real general|2 2 2|1 1 3|1 1 4|2 2 5|', &
         'line 4: must give a row and a column, not given before, within 2 rows and 2 columns')
      call refuse_matrix('coordinate real symmetric|2 2 2|2 1 3|1 2 4|', &
         'line 4: must give a row and a column, not given before, within 2 rows and 2 columns')
      do i = 1, size(outside)
         call refuse_matrix('coordinate real general|2 2 1|'//outside(i)//' 3|', &
            'line 3: must give a row and a column, not given before, within 2 rows and 2 columns')
      end do
      call refuse_matrix('coordinate real general|2 2 5|1 1 3|', &
         'line 2: it has more than 4 entries')
      call refuse_matrix('coordinate real general|2 2|1 1 3|', &
         'line 2: must contain the numbers of rows, columns and entries')
      call refuse_matrix('array complex general|1 1|1|', &
         'line 1: must declare a matrix that is coordinate or array, real, and general or &
         &symmetric')
      call refuse_matrix('array complex general|x|', &
         'line 1: must declare a matrix that is coordinate or array, real, and general or &
         &symmetric')
      call refuse_matrix('array real general|2 2|1|2|3,|4|', &
         'line 5: must contain one number of entry 3 of 4')
      call refuse_matrix('array real general|2*2|1|2|3|4|', &
         'line 2: must contain the numbers of rows and columns')
      call refuse_matrix('array real general|-1 1|1|', &
         'line 2: must contain the numbers of rows and columns')
      call refuse_matrix('array real general|0 0|', 'it has 0 rows and 0 columns; must be 1 to 5')
      call refuse_matrix('array real general|1e99 1|', &
         'it has 1000000000 rows and 1 columns; must be 1 to 5')
      call write_file('1 0'//line_feed//'0 1')
      call check_refused('it starts neither as a Matrix Market file (%%MatrixMarket) nor as a &
         &NumPy file')
      call write_file('')
      call check_refused('it starts neither as a Matrix Market file (%%MatrixMarket) nor as a &
         &NumPy file')
   end subroutine test_wrong_matrices

   !> Errors in a file in NumPy's format: its header may extend to its end.
   subroutine test_wrong_numpy()
      call refuse_numpy('True', '(1,)', 0, 'it has 0 bytes of numbers; must be 8')
      call refuse_numpy('True', '(2)', 3, 'it has 24 bytes of numbers; must be 16')
      call refuse_numpy('False', '(2, 2)', 3, 'it has 24 bytes of numbers; must be 32')
      call refuse_numpy('False', '(2, 3)', 6, 'it has 2 rows and 3 columns; must be square')
      call refuse_numpy('False', '(2, 3)', 5, 'it has 2 rows and 3 columns; must be square')
      call refuse_numpy('False', '(0, 0)', 0, 'it has 0 rows and 0 columns; must be 1 to 5')
      call refuse_numpy('False', '(1, 1, 1)', 1, &
         'it has the shape (1,1,1); must be a square matrix, or a list')
      call refuse_numpy('true', '(1, 1)', 1, &
         'it has the shape (1,1); must be a square matrix, or a list')
      call write_file(char(147)//'NUMPY'//char(1)//char(0)//char(5)//char(0)//'{   ')
      call check_refused('its header is damaged, or its version is not 1, 2 or 3')
      ! a header of 16 million characters
      call write_file(char(147)//'NUMPY'//char(2)//repeat(char(0), 4)//char(1)//'{}')
      call check_refused('its header is damaged, or its version is not 1, 2 or 3')
      call write_file(char(147)//'NUMPY'//char(4)//repeat(char(0), 5)//'{}')
      call check_refused('its header is damaged, or its version is not 1, 2 or 3')
      call write_numpy_of('<f4', 'False', '(1,)', repeat(char(0), 4), 1)
      call check_refused('it holds ''<f4''; must be float64 (''<f8'')')
      call write_file(char(147)//'NUMPY'//char(1)//char(0)//char(2)//char(0)//'{}')
      call check_refused('it holds ; must be float64 (''<f8'')')
   end subroutine test_wrong_numpy

   !> The first number that is not finite is named by its place, from files in either order.
   subroutine test_infinite_numbers()
      integer :: order, at, columns
      character(:), allocatable :: bytes, message, expected
      real(wp), allocatable :: numbers(:), times(:)
      real(wp) :: infinite

      infinite = ieee_value(1.0_wp, ieee_negative_inf)
      do order = 1, 2
         do at = 1, 4
            bytes = repeat(bytes_of(1.0_wp, .true.), at - 1)//bytes_of(infinite, .true.)// &
               repeat(bytes_of(1.0_wp, .true.), 4 - at)
            call write_numpy('<', trim(merge('True ', 'False', order == 1)), '(2, 2)', bytes, order)
            ! the files hold the numbers column by column, or row by row
            expected = 'it contains a number that is not finite, in row '//whole(merge(1 &
               + mod(at - 1, 2), 1 + (at - 1)/2, order == 1))//', column '//whole(merge(1 &
               + (at - 1)/2, 1 + mod(at - 1, 2), order == 1))
            call check_refused(expected)
            call write_numpy('<', 'False', trim(merge('(4,)  ', '(4, 1)', order == 1)), bytes, 1)
            call read_samples(path, 2, 6, numbers, columns, times, message)
            call check(message == 'it contains a number that is not finite, number '//whole(at), &
               'a list with a number that is not finite: '//message)
         end do
      end do
   end subroutine test_infinite_numbers

   !> The message about a file in NumPy's format with a given number of values.
   subroutine refuse_numpy(order, shape_text, n, expected)
      character(*), intent(in) :: order, shape_text, expected
      integer, intent(in) :: n

      call write_numpy('<', order, shape_text, repeat(bytes_of(1.0_wp, .true.), n), 1)
      call check_refused(expected)
   end subroutine refuse_numpy

   !> The message about a Matrix Market file whose lines end with |.
   subroutine refuse_matrix(text, expected)
      character(*), intent(in) :: text, expected

      call write_file(market//join(split(text, '|'), line_feed))
      call check_refused(expected)
   end subroutine refuse_matrix

   !> The message about the file.
   subroutine check_refused(expected)
      character(*), intent(in) :: expected
      character(:), allocatable :: message
      real(wp), allocatable :: numbers(:)

      call read_matrix(path, 5, numbers, message)
      call check(message == expected, expected//', not '//message)
   end subroutine check_refused

   !> The first error in a table of samples is named: at most 2 columns and 6 numbers.
   subroutine test_wrong_samples()
      call refuse_samples('1 2|3|4 5|', &
         'line 2: must contain 2 finite numbers, like the lines before')
      call refuse_samples('#|1 2 3 4|1 2|', 'line 2: must contain finite numbers, at most 2')
      call refuse_samples('1||2|', 'line 2: must contain 1 finite number, like the lines before')
      call refuse_samples('1 2|3 4|5 6|7 8|x|', 'it has more than 6 numbers')
      call refuse_samples('1 2|3 nan|', &
         'line 2: must contain 2 finite numbers, like the lines before')
      call refuse_samples('2*1|', 'line 1: must contain finite numbers, at most 2')
      ! a first line of names is skipped, but these words are meant as numbers
      call refuse_samples('NaN 1|2 3|', 'line 1: must contain finite numbers, at most 2')
      call refuse_samples('Infinity 1|2 3|', 'line 1: must contain finite numbers, at most 2')
      call refuse_samples('"|1 2|', 'line 1: must contain finite numbers, at most 2')
      call refuse_samples('x y|', 'it contains no numbers')
      call refuse_samples('time|1|2|', 'it has only a column of times')
      call refuse_samples('# 1|', 'it contains no numbers')
      call refuse_samples('# 1', 'it contains no numbers')
      call refuse_samples('', 'it contains no numbers')
      call refuse_samples('1|2|3|4|5|6|7|', 'it has more than 6 numbers')
      call refuse_samples('1 2|# 3 4|% 5 6|3 4|5|', &
         'line 5: must contain 2 finite numbers, like the lines before')
      call refuse_samples('1 2 |3*4|', &
         'line 2: must contain 2 finite numbers, like the lines before')
      call refuse_samples(market//'array real general|4 2|1|2|3|4|5|6|7|8|', &
         'it has more than 6 numbers')
      call refuse_samples(market//'array real general|1 3|1|2|3|', &
         'it has 1 rows and 3 columns; must be 1 to 6 rows and 1 to 2 columns')
      call refuse_samples(market//'array real general|7 1|1|2|3|4|5|6|7|', &
         'it has 7 rows and 1 columns; must be 1 to 6 rows and 1 to 2 columns')
   end subroutine test_wrong_samples

   !> Comments may appear between the samples, up to the allowed number of values.
   subroutine test_comments_between()
      real(wp), allocatable :: numbers(:), times(:)
      character(:), allocatable :: message
      integer :: columns, i

      call write_file(join(split('# x|1 2|# 3 4|%|3,4||# 5||', '|'), line_feed))
      call read_samples(path, 2, 4, numbers, columns, times, message)
      call check(message == '' .and. columns == 2 .and. size(numbers) == 4 .and. size(times) == 0, &
         'comments between samples: '//message)
      if (size(numbers) == 4) call check(all(abs(numbers - [1, 2, 3, 4]) <= 0), &
         'samples between comments')
      call write_file(market//join(split('array real general|3 2|1|3|5|2|4|6|', '|'), line_feed))
      call read_samples(path, 2, 6, numbers, columns, times, message)
      call check(message == '' .and. columns == 2 .and. size(numbers) == 6, &
         'as many numbers as allowed')
      if (size(numbers) == 6) call check(all(abs(numbers - [(i, i=1, 6)]) <= 0), 'row by row')
   end subroutine test_comments_between

   !> A path is relative to the folder of the file that names it, unless it is absolute.
   subroutine test_paths()
      call check_path('', 'm.mtx', 'm.mtx')
      call check_path('case.nml', 'm.mtx', 'm.mtx')
      call check_path('a/case.nml', 'm.mtx', 'a/m.mtx')
      call check_path('/a/b/case.nml', '../m.mtx', '/a/b/../m.mtx')
      call check_path('a\case.nml', 'm.mtx', 'a\m.mtx')
      call check_path('a/case.nml', '/m.mtx', '/m.mtx')
      call check_path('a/case.nml', '\m.mtx', '\m.mtx')
      call check_path('a/case.nml', 'c:m.mtx', 'c:m.mtx')
      call check_path('a/case.nml', 'cc:m.mtx', 'a/cc:m.mtx')
      call check_path('a/case.nml', 'm', 'a/m')
      call check_path('a/case.nml', '', 'a/')
   end subroutine test_paths

   subroutine check_path(file, name, expected)
      character(*), intent(in) :: file, name, expected
      character(:), allocatable :: full

      call beside(file, name, full)
      call check(full == expected .and. len(full) == len(expected), expected//', not '//full)
   end subroutine check_path

   !> A text file has line feeds at the ends of its lines, whatever it had; a folder and a missing
   !! file are not texts.
   subroutine test_texts()
      character(:), allocatable :: text, message

      call write_file('#a'//achar(13)//line_feed//'b'//achar(13)//'c'//line_feed)
      call read_text(path, text, message)
      call check(message == '' .and. text == '#a'//line_feed//'b'//line_feed//'c'//line_feed, &
         'a text')
      call check(is_result(path), 'a result begins with #')
      call write_file(' #')
      call check(.not. is_result(path), 'a blank before it')
      call write_file(repeat('0123456789', 20000)//'!')
      call read_text(path, text, message)
      call check(message == '' .and. len(text) == 200001 .and. index(text, '!') == 200001 .and. &
         index(text, '90') == 10, 'a long text')
      call read_text('.', text, message)
      call check(message == 'Is a directory' .and. len(text) == 0, 'a folder')
      call check(.not. is_result('.'), 'a folder is no result')
      call read_text(path//'.missing', text, message)
      call check(len(message) > 0 .and. len(text) == 0, 'a missing file')
      call check(.not. is_result(path//'.missing'), 'a missing file is no result')
   end subroutine test_texts

   !> The message about a table whose lines end with |.
   subroutine refuse_samples(text, expected)
      character(*), intent(in) :: text, expected
      character(:), allocatable :: message
      real(wp), allocatable :: numbers(:), times(:)
      integer :: columns

      call write_file(join(split(text, '|'), line_feed))
      call read_samples(path, 2, 6, numbers, columns, times, message)
      call check(message == expected, expected//', not '//message)
      call check(columns == 0, 'a table that is refused has no columns')
   end subroutine refuse_samples

   !> A list may be given in parts in any order, without gaps, and each position once.
   subroutine test_lists_in_parts()
      call check_list('n(3:4) = 3, 4|n(1) = 1|n(2) = 2|n(5:) = 5, 6', 6, '', 0)
      call check_list('n = 1, 2|n(3) = 3', 3, '', 0)
      call check_list('n(3) = 3|n(1) = 1', 0, 'must be', 0)
      call check_list('n(2) = 2|n(9) = 9|n(1:2) = 1, 2', 0, 'was given before, in line 1', 3)
   end subroutine test_lists_in_parts

   !> Reads assignments in lines that end with |: the numbers 1 to n, or an error.
   subroutine check_list(text, n, fault, line)
      character(*), intent(in) :: text, fault
      integer, intent(in) :: n, line
      type(group_type), allocatable :: groups(:)
      type(values_type) :: values
      character(:), allocatable :: message
      integer, allocatable :: numbers(:)
      integer :: at, i

      call scan_namelist('&g '//join(split(text, '|'), line_feed)//' /', groups, at, message)
      call check(message == '', text)
      call read_values('g', [key_type('n', a_whole, low=1.0_wp, most=9)], groups(1), values)
      call check(index(values%fault, fault) > 0 .and. (fault == '') .eqv. values%fault == '', &
         text//': '//values%fault)
      if (line > 0) call check(values%fault_line == line, 'line of the fault')
      if (n == 0 .or. values%fault /= '') return
      allocate (numbers, source=values%whole_numbers('n'))
      call check(size(numbers) == n, 'length of a list in parts')
      if (size(numbers) == n) call check(all(numbers == [(i, i=1, n)]), 'numbers of such a list')
   end subroutine check_list

   !> Only a number that would be rounded to 0 is reported as such.
   subroutine test_near_zero()
      character(8), parameter :: texts(*) = [character(8) :: '1e-5000', '-.1d-999', 'xe-999', &
         '1e-5x', '1e5000', '1x-999', 'e-999']
      integer :: i

      do i = 1, size(texts)
         call check_fault(key_type('x'), 'x = '//trim(texts(i)), 'close to 0', i <= 2)
      end do
      call check_fault(key_type('x', a_whole), 'x = 1e-999', 'near 0', .false.)
   end subroutine test_near_zero

   !> A control character becomes a question mark; all others of Latin-1 and UTF-8 are kept.
   subroutine test_printable()
      character(*), parameter :: letters = char(195)//char(188)//char(226)//char(130)//char(172) &
         //char(240)//char(159)//char(152)//char(128)
      integer :: i

      do i = 0, 255
         call check(printable(char(i)//'a') == merge('?', char(i), i < 32 .or. (i > 126 .and. &
            i < 160))//'a', 'a byte of a text for a terminal')
      end do
      call check(printable(letters) == letters, 'letters of two to four bytes')
   end subroutine test_printable

   !> Names of results: no hidden files, no paths, no invisible characters.
   subroutine test_names()
      character(*), parameter :: wide = char(226)//char(129)
      integer :: i

      call check_name('a.b_1-c', .true.)
      call check_name('.a', .false.)
      call check_name('a/b', .false.)
      call check_name('a b', .false.)
      call check_name(repeat('a', 100), .true.)
      call check_name(repeat('a', 101), .false.)
      call check_name(char(195)//char(164), .true.)                           ! U+00E4, a letter
      call check_name(char(227)//char(129)//char(130), .true.)                ! U+3042, a letter
      call check_name(char(194)//char(160), .false.)                          ! no-break space
      call check_name(char(227)//char(128)//char(128), .false.)               ! ideographic space
      call check_name('a'//char(239)//char(187)//char(191), .false.)          ! byte order mark
      do i = 128, 191                                   ! U+2040 to U+207F
         call check_name(wide//char(i), i > 175)
         call check_name(char(226)//char(128)//char(i), .false.)
      end do
   end subroutine test_names

   !> A name is accepted or refused.
   subroutine check_name(name, accepted)
      character(*), intent(in) :: name
      logical, intent(in) :: accepted
      type(group_type), allocatable :: groups(:)
      type(values_type) :: values
      character(:), allocatable :: message
      integer :: line

      call scan_namelist('&output name = '''//name//''' /', groups, line, message)
      call read_values('output', output_keys, groups(1), values)
      call check_output(values)
      call check((values%fault == '') .eqv. accepted, 'the name '//name)
   end subroutine check_name

   !> An assignment is refused, and the reason contains given words, or does not.
   subroutine check_fault(key, text, words, holds)
      type(key_type), intent(in) :: key
      character(*), intent(in) :: text, words
      logical, intent(in) :: holds
      type(group_type), allocatable :: groups(:)
      type(values_type) :: values
      character(:), allocatable :: message
      integer :: line

      call scan_namelist('&g '//text//' /', groups, line, message)
      call read_values('g', [key], groups(1), values)
      call check(values%fault /= '' .and. (index(values%fault, words) > 0 .eqv. holds), &
         text//': '//values%fault)
   end subroutine check_fault

   !> Writes the file for the next read.
   subroutine write_file(text)
      character(*), intent(in) :: text
      integer :: unit

      open (newunit=unit, file=path, access='stream', form='unformatted', status='replace', &
         action='write')
      write (unit) text
      close (unit)
   end subroutine write_file

end module cases_files
