!> A result as CSV: a header with the case and the remarks, then one row for each row of one table,
!! with the values of the tables to which it belongs repeated.
module vi_csv
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
   use vi_buffer, only: add, buffer_type
   use vi_kinds, only: wp
   use vi_motion, only: unknown, yes
   use vi_result, only: complexes, filled_type, reals, result_type, rows_of, table_type, truths, &
      verdicts, wholes
   use vi_text, only: append, line_type, whole
   implicit none (type, external)
   private

   public :: cell_count, csv_header, csv_rows, has_rows, row_count

contains

   !> The header; its last line names the columns.
   pure subroutine csv_header(result, case, lines)
      !> The result.
      type(result_type), intent(in) :: result
      !> The echo of its case.
      type(line_type), intent(in) :: case(:)
      !> The header.
      type(line_type), allocatable, intent(out) :: lines(:)
      type(buffer_type) :: buffer
      character(:), allocatable :: label
      integer :: first, i, j

      allocate (lines(0))
      do i = 1, size(case)
         call append(lines, case(i)%text)
      end do
      if (len(result%cut) > 0) call append(lines, '# ! cut short: '//result%cut)
      do i = 1, size(result%remarks)
         call append(lines, '# ! '//result%remarks(i)%text)
      end do
      do i = 1, size(result%columns)
         associate (filled => result%columns(i), column => result%columns(i)%column)
            if (.not. is_listed(filled)) cycle
            label = trim(column%label)
            if (len(label) == 0) label = trim(column%name)
            if (label == '=') label = trim(result%tables(filled%table)%dims(1))
            ! coordinates count from 0, as in the names of keys
            first = merge(0, 1, column%each == 'coordinate')
            do j = first, first + filled%inner - 1
               if (column%kind == complexes .and. .not. is_modulus(filled)) then
                  call add(buffer, ','//numbered(label//'_re', whole(j))//','// &
                     numbered(label//'_im', whole(j)))
               else if (column%each == 'output' .and. j <= size(result%outputs)) then
                  call add(buffer, ','//numbered(label, result%outputs(j)%text))
               else
                  call add(buffer, ','//numbered(label, whole(j)))
               end if
            end do
         end associate
      end do
      call append(lines, buffer%text(2:buffer%n))
   end subroutine csv_header

   !> Whether a column of complex numbers shows their moduli.
   pure logical function is_modulus(filled)
      !> The column.
      type(filled_type), intent(in) :: filled

      is_modulus = index(filled%column%label, 'modulus') > 0
   end function is_modulus

   !> Whether a column is in the CSV; one of outputs is not without outputs.
   pure logical function is_listed(filled)
      !> The column.
      type(filled_type), intent(in) :: filled

      is_listed = filled%column%listed .and. (filled%table > 0 .or. filled%column%each /= 'output')
   end function is_listed

   !> A name with the place within the row inserted.
   pure function numbered(label, place) result(text)
      !> The name, with # where the place is inserted.
      character(*), intent(in) :: label
      !> The place, or the name of an output.
      character(*), intent(in) :: place
      character(len(label) + merge(len(place) - 1, 0, index(label, '#') > 0)) :: text
      integer :: i

      i = index(label, '#')
      text = label
      if (i > 0) text = label(:i - 1)//place//label(i + 1:)
   end function numbered

   !> Largest possible number of rows.
   pure integer function row_count(result) result(n)
      !> The result.
      type(result_type), intent(in) :: result
      integer :: place

      n = 0
      place = findloc(result%tables%name == result%row, .true., 1)
      if (place > 0) n = rows_of(result%tables(place))
   end function row_count

   !> Number of cells of a row; a complex number counts as one.
   pure integer function cell_count(result) result(n)
      !> The result.
      type(result_type), intent(in) :: result
      integer :: i

      n = sum([(merge(result%columns(i)%inner, 0, is_listed(result%columns(i))), &
         i=1, size(result%columns))])
   end function cell_count

   !> Whether each cell of the rows has a value. This is always so for the result of a study; a
   !! result that a caller has filled has to be checked.
   pure logical function has_rows(result)
      !> The result.
      type(result_type), intent(in) :: result
      integer :: rows(size(result%tables)), i, row

      has_rows = .true.
      do row = 1, row_count(result)
         rows = 0
         call find_rows(result%tables, findloc(result%tables%name == result%row, .true., 1), row, &
            rows)
         do i = 1, size(result%columns)
            associate (filled => result%columns(i))
               if (.not. is_listed(filled)) cycle
               has_rows = filled%table > 0
               if (.not. has_rows) return
               has_rows = rows(filled%table) > 0 .and. &
                  rows(filled%table) <= rows_of(result%tables(filled%table))
               if (.not. has_rows) return
            end associate
         end do
      end do
   end function has_rows

   !> Some rows as one text, with a line feed after each.
   pure subroutine csv_rows(result, first, last, text)
      !> The result.
      type(result_type), intent(in) :: result
      !> First and last row.
      integer, intent(in) :: first, last
      !> The rows.
      character(:), allocatable, intent(out) :: text
      type(buffer_type) :: buffer
      integer :: rows(size(result%tables)), i, row, start

      each_row: do row = first, last
         call find_rows(result%tables, findloc(result%tables%name == result%row, .true., 1), row, &
            rows)
         start = buffer%n
         do i = 1, size(result%columns)
            associate (filled => result%columns(i))
               if (.not. is_listed(filled)) cycle
               call add_cells(filled, rows(filled%table), buffer)
               if (filled%column%absent(1) == -huge(1)) cycle
               if (all(filled%k(rows(filled%table)) /= filled%column%absent)) cycle
               buffer%n = start
               cycle each_row
            end associate
         end do
         buffer%text(start + 1:buffer%n - 1) = buffer%text(start + 2:buffer%n)  ! the first comma
         buffer%text(buffer%n:buffer%n) = new_line('a')
      end do each_row
      text = ''
      if (buffer%n > 0) text = buffer%text(:buffer%n)
   end subroutine csv_rows

   !> The row of each table to which a row of one table belongs, through its parent or through one
   !! of its dimensions.
   pure recursive subroutine find_rows(tables, place, row, rows)
      !> Tables of the result.
      type(table_type), intent(in) :: tables(:)
      !> Place of the table.
      integer, intent(in) :: place
      !> Row of that table.
      integer, intent(in) :: row
      !> (tables) In and out: the row of each table; tables to which it does not belong are not
      !! changed.
      integer, intent(inout) :: rows(:)
      integer :: rest, i, j

      rows(place) = row
      associate (table => tables(place))
         rest = row - 1
         do i = 1, table%n_dims
            do j = 1, size(tables)
               if (j == place .or. tables(j)%n_dims /= 1) cycle
               if (tables(j)%dims(1) == table%dims(i)) rows(j) = modulo(rest, table%sizes(i)) + 1
            end do
            rest = rest/table%sizes(i)
         end do
         do j = 1, size(tables)
            if (tables(j)%n_dims == 0) rows(j) = 1
         end do
         if (table%parent > 0) call find_rows(tables, table%parent, table%owners(row), rows)
      end associate
   end subroutine find_rows

   !> Adds the cells of one column, each after a comma.
   pure subroutine add_cells(filled, row, buffer)
      !> The column.
      type(filled_type), intent(in) :: filled
      !> The row of its table.
      integer, intent(in) :: row
      !> The text so far.
      type(buffer_type), intent(inout) :: buffer
      integer :: i

      do i = (row - 1)*filled%inner + 1, row*filled%inner
         select case (filled%column%kind)
         case (reals)
            call add_number(filled%x(i), buffer)
         case (complexes)
            if (is_modulus(filled)) then
               call add_number(abs(cmplx(filled%x(2*i - 1), filled%x(2*i), wp)), buffer)
            else
               call add_number(filled%x(2*i - 1), buffer)
               call add_number(filled%x(2*i), buffer)
            end if
         case (wholes)
            call add(buffer, ','//whole(filled%k(i)))
         case (verdicts)
            call add(buffer, ','//trim(merge('unknown', merge('true   ', 'false  ', &
               filled%k(i) == yes), filled%k(i) == unknown)))
         case (truths)
            call add(buffer, ','//trim(merge('true ', 'false', filled%k(i) == 1)))
         case default
            call add(buffer, ',')
            if (filled%k(i) > 0) call add_word(filled%words(filled%k(i))%text, buffer)
         end select
      end do
   end subroutine add_cells

   !> Adds a word of any characters as one cell: one with commas, quotes or line ends is quoted (RFC
   !! 4180), and one that a spreadsheet would compute as a formula has an apostrophe before it.
   pure subroutine add_word(word, buffer)
      !> The word.
      character(*), intent(in) :: word
      !> The text so far.
      type(buffer_type), intent(inout) :: buffer
      character(*), parameter :: line_ends = achar(10)//achar(13)
      character(len(word) + 1) :: text
      integer :: i, n

      n = len(word)
      text = word
      if (scan(word, '=+-@'//achar(9)//achar(13)) == 1) then
         n = n + 1
         text = ''''//word
      end if
      if (scan(text(:n), ',"'//line_ends) == 0) then
         call add(buffer, text(:n))
         return
      end if
      call add(buffer, '"')
      do i = 1, n
         if (text(i:i) == '"') call add(buffer, '"')
         call add(buffer, text(i:i))
      end do
      call add(buffer, '"')
   end subroutine add_word

   !> Adds a number with all its digits (17) after a comma; numbers that are not finite are written
   !! as Python reads them.
   pure subroutine add_number(value, buffer)
      !> A number.
      real(wp), intent(in) :: value
      !> The text so far.
      type(buffer_type), intent(inout) :: buffer
      character(24) :: digits

      if (ieee_is_finite(value)) then
         write (digits, '(es24.16e3)') value
         call add(buffer, ','//digits(verify(digits, ' '):))
      else if (ieee_is_nan(value)) then
         call add(buffer, ',nan')
      else
         call add(buffer, trim(merge(',inf ', ',-inf', value > 0)))
      end if
   end subroutine add_number

end module vi_csv
