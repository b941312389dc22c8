!> Results as rows and as CSV, numbers with all digits, and dictionaries of texts.
module cases_results
   use, intrinsic :: ieee_arithmetic, only: ieee_negative_inf, ieee_positive_inf, ieee_quiet_nan, &
      ieee_value
   use checks, only: check
   use vi_csv, only: cell_count, csv_header, csv_rows, has_rows, row_count
   use vi_dictionary, only: dictionary_type, find_text, include_text
   use vi_kinds, only: wp
   use vi_motion, only: no, unknown, yes
   use vi_result, only: column_type, complexes, result_type, start_result, truths, verdicts, &
      wholes, words
   use vi_text, only: exact, last_part, line_type, whole
   implicit none (type, external)
   private

   public :: test_results

   character, parameter :: line_feed = achar(10), tab = achar(9)

contains

   subroutine test_results()
      call test_rows()
      call test_dictionary()
      call test_exact()
      call test_csv()
   end subroutine test_results

   !> A result that a caller has filled has rows if each listed column has a value in each row:
   !! it is in the table of the rows, in one to which they belong, or in one without dimensions.
   subroutine test_rows()
      character(8), parameter :: tables(4) = [character(8) :: 'items', 'groups', 'run', 'others']
      type(result_type) :: result
      logical :: listed, filled
      integer :: i, first, k

      do i = 0, 15
         listed = btest(i, 0)
         filled = btest(i, 1)
         do k = 1, size(tables)
            call start_result([line_type ::], [column_type('items', 'number'), &
               column_type(tables(k), 'other', listed=listed)], 'items', result)
            ! the order of the tables does not matter, except that parents come first
            do first = 1, 2
               if (first == 1 .eqv. btest(i, 2)) call result%open('run', '', [integer ::])
               if (first == 1 .eqv. btest(i, 3)) call result%open('others', 'other', [3])
               if (first == 1) call result%open('groups', 'group', [2])
            end do
            call result%open('items', 'item', [3], 'groups', [1, 2, 2])
            call result%put('items', 'number', [1.0_wp, 2.0_wp, 3.0_wp])
            if (filled) call result%put(tables(k), 'other', [(1.0_wp, first=1, merge(3, merge(2, &
               1, tables(k) == 'groups'), tables(k) == 'items' .or. tables(k) == 'others'))])
            call check(has_rows(result) .eqv. .not. listed .or. (filled .and. tables(k) /= &
               'others'), 'rows have a value of each column that is listed')
         end do
      end do
   end subroutine test_rows

   !> Texts are found at the positions at which they were added, however many there are.
   subroutine test_dictionary()
      integer, parameter :: n = 300
      type(dictionary_type) :: dictionary
      integer :: i, place

      call find_text(dictionary, 'a1', place)
      call check(place == 0, 'no text in an empty list')
      do i = 1, n
         call find_text(dictionary, 'a'//whole(i), place)
         call check(place == 0, 'a text that is not there')
         call include_text(dictionary, 'a'//whole(i), place)
         call check(place == i .and. dictionary%n == i, 'a new text is the last one')
         call include_text(dictionary, 'a'//whole((i + 1)/2), place)
         call check(place == (i + 1)/2 .and. dictionary%n == i, 'a text is kept once')
      end do
      do i = 1, n
         call find_text(dictionary, 'a'//whole(i), place)
         call check(place == i, 'a text is found')
         call find_text(dictionary, 'a'//whole(i)//' ', place)
         call check(place == 0, 'trailing blanks count')
      end do
   end subroutine test_dictionary

   !> Numbers with all digits, including those that are not finite, and the end of a message.
   subroutine test_exact()
      character(30) :: text

      call check(exact(0.1_wp) == '1.0000000000000001E-001', 'exact: 0.1')
      call check(exact(-2.0_wp) == '-2.0000000000000000E+000', 'exact: -2')
      call check(exact(ieee_value(1.0_wp, ieee_quiet_nan)) == 'NaN' .and. &
         len(exact(ieee_value(1.0_wp, ieee_quiet_nan))) == 3, 'exact: not a number')
      ! compilers write either
      text = exact(ieee_value(1.0_wp, ieee_negative_inf))
      call check(any(text == ['-Infinity', '-Inf     ']) .and. &
         len(exact(ieee_value(1.0_wp, ieee_negative_inf))) == len_trim(text), 'exact: infinite')
      call check(last_part('Cannot open a: b:  No such file ') == 'No such file' .and. &
         len(last_part('Cannot open a: b:  No such file ')) == 12, 'the last part of a message')
      call check(last_part('No such file') == 'No such file', 'a message in one part')
   end subroutine test_exact

   !> A result with columns of all kinds as CSV: header and rows, of one table and its parents,
   !! without columns that are not listed and rows that are marked to be left out.
   subroutine test_csv()
      type(result_type) :: result
      type(line_type), allocatable :: lines(:)
      character(*), parameter :: head(6) = [character(80) :: '# &case', '# /', &
         '# ! cut short: half', '# ! first', '# ! second', 'item,x,y_re,y_im,'// &
         '|y|_modulus,n,sure,open,kind,of group,q0,q1,m1,m2']
      character(:), allocatable :: text, expected
      real(wp), allocatable :: numbers(:)
      integer, allocatable :: places(:)
      integer :: i

      call start_result([line_type('# unused')], [column_type('items', 'i', wholes, label='='), &
         column_type('items', 'x'), column_type('items', 'y', complexes), &
         column_type('items', 'z', complexes, label='|y|_modulus'), &
         column_type('items', 'n', wholes, absent=[7, 9]), &
         column_type('items', 'sure', verdicts), column_type('items', 'open', truths), &
         column_type('items', 'kind', words, words='one,two'), &
         column_type('groups', 'g', label='of group'), &
         column_type('items', 'hidden', listed=.false.), &
         column_type('run', 'q', wholes, each='coordinate', label='q#'), &
         column_type('groups', 'm', wholes, each='place', label='m#')], 'items', result)
      call result%open('run', '', [integer ::])
      call result%open('groups', 'group', [2])
      call result%open('items', 'item', [5], 'groups', [1, 1, 1, 2, 2])
      call result%put('items', 'i', [1, 2, 3, 4, 5])
      call result%put('items', 'x', [1.5_wp, ieee_value(1.0_wp, ieee_quiet_nan), &
         ieee_value(1.0_wp, ieee_positive_inf), ieee_value(1.0_wp, ieee_negative_inf), -0.25_wp])
      call result%put('items', 'y', [((3.0_wp, -4.0_wp), i=1, 5)])
      call result%put('items', 'z', [((3.0_wp, -4.0_wp), i=1, 5)])
      call result%put('items', 'n', [-3, 7, 0, 8, 9])
      call result%put('items', 'sure', [yes, no, no, unknown, yes])
      call result%put('items', 'open', [1, 0, 0, 1, 1])
      call result%put('items', 'kind', [2, 1, 0, 1, 2])
      call result%put('groups', 'g', [10.0_wp, 20.0_wp])
      call result%put('run', 'q', [5, 6])
      call result%put('groups', 'm', [1, 2, 3, 4])
      call result%put('items', 'hidden', [(0.0_wp, i=1, 5)])
      call result%remark('first')
      call result%remark('second')
      result%cut = 'half'
      call csv_header(result, [line_type('# &case'), line_type('# /')], lines)
      call check(size(lines) == size(head), 'csv: lines of the header')
      do i = 1, min(size(lines), size(head))
         call check(lines(i)%text == head(i) .and. len(lines(i)%text) == len_trim(head(i)), &
            'csv: '//lines(i)%text)
      end do
      call check(row_count(result) == 5 .and. cell_count(result) == 13, 'csv: size')
      call csv_rows(result, 1, 5, text)
      expected = ''
      call add_row('1,1.5000000000000000E+000', '-3,true,true,two', '1.', '1,2')
      call add_row('3,inf', '0,false,false,', '1.', '1,2')
      call add_row('4,-inf', '8,unknown,true,one', '2.', '3,4')
      call check(text == expected, 'csv: rows '//text)
      result%columns(5)%column%absent = -huge(1)
      call csv_rows(result, 2, 2, text)
      expected = ''
      call add_row('2,nan', '7,false,false,one', '1.', '1,2')
      call check(text == expected, 'csv: a row '//text)
      call csv_rows(result, 3, 2, text)
      call check(text == '', 'csv: no rows')
      result%cut = ''
      call csv_header(result, [line_type ::], lines)
      call check(size(lines) == 3, 'csv: a header of a result that is not cut')
      call result%get_reals('items', 'y', numbers)
      call check(size(numbers) == 10 .and. all(abs(numbers(1::2) - 3) <= 0) .and. &
         all(abs(numbers(2::2) + 4) <= 0), 'the parts of complex numbers')
      call result%get_wholes('groups', 'm', places)
      call check(size(places) == 4, 'all whole numbers')
      if (size(places) == 4) call check(all(places == [1, 2, 3, 4]), 'whole numbers')
   contains
      !> Adds a row to the expected text.
      subroutine add_row(first, middle, group, last)
         character(*), intent(in) :: first, middle, group, last

         expected = expected//first//',3.0000000000000000E+000,-4.0000000000000000E+000,'// &
            '5.0000000000000000E+000,'//middle//','//group//'0000000000000000E+001,5,6,'// &
            last//line_feed
      end subroutine add_row
   end subroutine test_csv

end module cases_results
