!> Tests of cases: values as they are written, and the descriptions of keys.
program test_cases
   use cases_files, only: test_files
   use cases_results, only: test_results
   use checks, only: check, check_close, finish
   use random_numbers, only: draw, draw_integer, random_type
   use vi_buffer, only: add_quoted, buffer_type
   use vi_key, only: a_whole, a_word, describe_key, key_type
   use vi_kinds, only: wp
   use vi_parse, only: parse_numbers, parse_subscript, parse_words
   use vi_text, only: exact, line_type, lower, number_text
   implicit none (type, external)

   type(random_type) :: random

   call test_numbers_read_back()
   call test_forms_of_printed_numbers()
   call test_forms_of_numbers()
   call test_lists()
   call test_words()
   call test_subscripts()
   call test_descriptions()
   call test_quoted()
   call test_files()
   call test_results()
   call finish()

contains

   !> Texts in JSON: only quotation marks, backslashes and control characters are changed.
   subroutine test_quoted()
      type(buffer_type) :: buffer
      character(4) :: code
      character(:), allocatable :: expected
      integer :: i

      do i = 0, 255
         write (code, '(z4.4)') i
         expected = char(i)
         if (i < 32) expected = '\u'//lower(code)
         if (any(char(i) == ['"', '\'])) expected = '\'//char(i)
         buffer = buffer_type()
         call add_quoted(buffer, 'a'//char(i)//'b'//char(i))
         call check(buffer%text(:buffer%n) == '"a'//expected//'b'//expected//'"', 'a text in JSON')
      end do
   end subroutine test_quoted

   !> A number printed with all digits or with the fewest reads back as the same number.
   subroutine test_numbers_read_back()
      real(wp), allocatable :: values(:)
      real(wp) :: value
      logical :: good
      integer :: i

      do i = 1, 5000
         value = draw(random, -1.0_wp, 1.0_wp)*10.0_wp**draw_integer(random, -300, 300)
         if (mod(i, 3) == 0) value = draw_integer(random, -100000, 100000)/10.0_wp**mod(i, 5)
         call parse_numbers(exact(value), .false., 1, values, good)
         call check(good .and. size(values) == 1, 'a number with all digits is read')
         call check(abs(values(1) - value) <= 0, 'all digits give the same bits')
         call parse_numbers(trim(number_text(value, .false.)), .false., 1, values, good)
         call check(good .and. size(values) == 1, 'a number with few digits is read')
         call check(abs(values(1) - value) <= 0, 'few digits give the same bits')
      end do
   end subroutine test_numbers_read_back

   !> From 0.001 to below 100000 a number is printed without exponent and without surplus digits.
   subroutine test_forms_of_printed_numbers()
      character(12), parameter :: forms(*) = [character(12) :: '0', '0.001', '0.0012', '0.5', '1', &
         '10', '12.5', '12345.678', '99999', '1e5', '1.23456e5', '1.5e300', '9.99e-4', '1e-4', &
         '1e-300']
      real(wp), allocatable :: values(:)
      logical :: good
      integer :: i

      do i = 1, size(forms)
         call parse_numbers(trim(forms(i)), .false., 1, values, good)
         call check(good .and. number_text(values(1), .false.) == forms(i), trim(forms(i))// &
            ' is printed so')
         if (i > 1) call check(number_text(-values(1), .false.) == '-'//forms(i), '-'// &
            trim(forms(i))//' is printed so')
      end do
      call check(number_text(2.0_wp/3, .false., 3) == '0.667', 'as many digits as are asked for')
      call check(number_text(2.0e6_wp/3, .false., 1) == '7e5', 'one digit has no point')
      call check(number_text(3.0_wp, .true.) == '3', 'a whole number is printed whole')
   end subroutine test_forms_of_printed_numbers

   !> Texts that are numbers, and similar texts that are not.
   subroutine test_forms_of_numbers()
      character(8), parameter :: right(*) = [character(8) :: '1', '1.', '.5', '-1.5d-3', '+7', &
         '1E5', &
         '0e9', '1d0', '00.1', '0e999', '9.9e307', '.001e310']
      character(8), parameter :: wrong(*) = [character(8) :: '2+1', '2-1', '1e-5000', '1e400', &
         '1e308', '.01e310', &
         '1.5.2', &
         '.', '1e', '0x10', 'nan', 'inf', '1e+', '+', '1 2', '1,', ',1', ',', '', '1_8', '3*', &
         '*3', &
         '0*1', '-1*1', '1;2', 'e5', '1e1.5']
      real(wp), allocatable :: values(:)
      logical :: good
      integer :: i

      do i = 1, size(right)
         call parse_numbers(trim(right(i)), .false., 1, values, good)
         call check(good .and. size(values) == 1, trim(right(i))//' is a number')
         call parse_numbers(trim(right(i)), .true., 1, values, good)
         call check(good .eqv. verify(trim(right(i)), '+0123456789') == 0, trim(right(i))// &
            ' is a whole number only if it has no point and no exponent')
      end do
      do i = 1, size(wrong)
         call parse_numbers(trim(wrong(i)), .false., 1, values, good)
         call check(.not. good, trim(wrong(i))//' is not one number')
      end do
   end subroutine test_forms_of_numbers

   !> Lists with commas, blanks and repeats.
   subroutine test_lists()
      real(wp), allocatable :: values(:)
      logical :: good

      call parse_numbers(' 1, 2  3 ,4', .true., 4, values, good)
      call check(good .and. all(nint(values) == [1, 2, 3, 4]), 'commas and blanks')
      call parse_numbers('2*0.5, 3*1', .false., 5, values, good)
      call check(good .and. size(values) == 5, 'repeats')
      call check_close(sum(values), 4.0_wp, 0.0_wp, 'repeats')
      call parse_numbers('2*0.5, 3*1', .false., 4, values, good)
      call check(.not. good, 'more than there is room for')
      call parse_numbers('1,, 2', .false., 4, values, good)
      call check(.not. good, 'nothing between two commas')
      call parse_numbers('99999999999*1', .false., 4, values, good)
      call check(.not. good, 'more repeats than any list has')
   end subroutine test_lists

   !> Words in either kind of quotes.
   subroutine test_words()
      type(line_type), allocatable :: words(:)
      logical :: good

      call parse_words('''it''''s'' "a ""b"" "', 2, words, good)
      call check(good .and. size(words) == 2, 'two words')
      call check(words(1)%text == 'it''s' .and. words(2)%text == 'a "b"', 'doubled quotes')
      call check(len(words(2)%text) == 5, 'blanks behind a word')
      call parse_words('''a'' b', 2, words, good)
      call check(.not. good, 'a word without quotes')
      call parse_words('''a', 2, words, good)
      call check(.not. good, 'a quote that is not closed')
      call parse_words('''a'', ''b'', ''c''', 2, words, good)
      call check(.not. good, 'more words than there is room for')
   end subroutine test_words

   !> The positions given by a subscript.
   subroutine test_subscripts()
      character(6), parameter :: texts(*) = [character(6) :: '', '(2)', '(2:4)', '(3:)', '(:2)', &
         '(:)']
      integer, parameter :: places(2, 6) = reshape([1, 9, 2, 9, 2, 4, 3, 9, 1, 2, 1, 9], [2, 6])
      character(6), parameter :: wrong(*) = [character(6) :: '(0)', '(10)', '(4:2)', '(1,1)', &
         '(::1)', &
         '()', '(', '(a)', '%x', '(1.0)']
      integer :: first, last, i
      logical :: good

      do i = 1, size(texts)
         call parse_subscript(trim(texts(i)), 9, first, last, good)
         call check(good .and. first == places(1, i) .and. last == places(2, i), &
            'subscript '//texts(i))
      end do
      do i = 1, size(wrong)
         call parse_subscript(trim(wrong(i)), 9, first, last, good)
         call check(.not. good, 'no subscript '//wrong(i))
      end do
      call parse_subscript('(1)', 1, first, last, good)
      call check(.not. good, 'subscript of what is no list')
   end subroutine test_subscripts

   !> The description of the values of a key, from its row.
   subroutine test_descriptions()
      type(key_type), parameter :: keys(*) = [ &
         key_type('low', low=1.0e-6_wp, high=1.0_wp, above=.true., below=.true.), &
         key_type('high', over='low'), &
         key_type('n', a_whole, low=1.0_wp, high=12500000.0_wp), &
         key_type('kind', a_word, words='a b c')]
      character(60), parameter :: texts(*) = [character(60) :: &
         'a number with 1e-6 < low < 1, and low below high', &
         'a finite number, and low below high', &
         'a whole number with 1 <= n <= 12500000', '''a'', ''b'' or ''c''']
      character(:), allocatable :: text
      integer :: i

      do i = 1, size(keys)
         call describe_key(keys, i, text)
         call check(text == texts(i), text)
      end do
   end subroutine test_descriptions

end program test_cases
