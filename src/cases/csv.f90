!> A result as CSV: a header with the case and the remarks, then one row for each row of one table,
!! with the values of the tables to which it belongs repeated. Numbers are shown in the units of the
!! result; the case in the header stays dimensionless, so that it is an input with the same digits.
module vi_csv
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
   use vi_buffer, only: add, buffer_type
   use vi_kinds, only: wp
   use vi_motion, only: unknown, yes
   use vi_result, only: complexes, filled_type, reals, result_type, rows_of, table_type, truths, &
      verdicts, wholes
   use vi_text, only: append, line_type, whole
   use vi_units, only: show_frequency, show_unit
   use vi_version, only: version
   implicit none (type, external)
   private

   public :: cell_count, csv_header, csv_rows, has_rows, row_count

   !> The first words of the meaning of a frequency ratio, and the unit of columns of several units.
   character(*), parameter :: ratio = 'frequency ratio', mixed = 'mixed'

contains

   !> The header; its last line names the columns.
   pure subroutine csv_header(result, case, lines)
      !> The result.
      type(result_type), intent(in) :: result
      !> The echo of its case.
      type(line_type), intent(in) :: case(:)
      !> The header.
      type(line_type), allocatable, intent(out) :: lines(:)
      type(buffer_type) :: buffer, units
      character(:), allocatable :: label, unit
      real(wp) :: scale
      logical :: by_row
      integer :: first, i, j

      allocate (lines(0))
      if (is_shown(result)) then
         do i = 1, size(result%columns)
            if (.not. is_listed(result%columns(i))) cycle
            call show_column(result, i, label, scale, unit, by_row)
            if (by_row) unit = unit//' if clearance'
            if (len(unit) > 0) call add(units, ', '//label//' '//unit)
         end do
         label = ''
         if (units%n > 0) label = ';'//units%text(2:units%n)
         call append(lines, '# ! vibroimpact '//version//label)
         label = 'in F0/K and 1/omega'
         if (case(2)%text == '# &structure') label = 'in its own scales (M, K and F0)'
         call append(lines, '# ! the case is '//label//'; this file is an input too')
      end if
      do i = merge(2, 1, is_shown(result)), size(case)
         call append(lines, case(i)%text)
      end do
      if (len(result%cut) > 0) call append(lines, '# ! cut short: '//result%cut)
      do i = 1, size(result%remarks)
         call append(lines, '# ! '//result%remarks(i)%text)
      end do
      do i = 1, size(result%columns)
         associate (filled => result%columns(i), column => result%columns(i)%column)
            if (.not. is_listed(filled)) cycle
            call show_column(result, i, label, scale, unit, by_row)
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

   !> Whether the numbers are shown in physical units.
   pure logical function is_shown(result)
      !> The result.
      type(result_type), intent(in) :: result

      is_shown = len_trim(result%shown%names(1)) > 0
   end function is_shown

   !> The label of a column, and how its numbers are shown.
   pure subroutine show_column(result, place, label, scale, unit, by_row)
      !> The result.
      type(result_type), intent(in) :: result
      !> Place of the column.
      integer, intent(in) :: place
      !> Its label, with # for the place within the row.
      character(:), allocatable, intent(out) :: label
      !> The factor of its numbers, and their unit.
      real(wp), intent(out) :: scale
      character(:), allocatable, intent(out) :: unit
      !> Whether the factor applies only to rows named clearance.
      logical, intent(out) :: by_row
      character(:), allocatable :: own
      logical :: is_ratio

      associate (filled => result%columns(place), column => result%columns(place)%column)
         label = trim(column%label)
         if (len(label) == 0) label = trim(column%name)
         own = trim(column%unit)
         by_row = .false.
         is_ratio = column%meaning(:len(ratio)) == ratio .and. column%kind == reals
         if (label == '=') then
            label = trim(result%tables(filled%table)%dims(1))
            is_ratio = is_ratio .or. label == 'r'
            if (own == mixed) own = trim(unit_of(label))
         end if
         scale = 1
         unit = own
         if (own == mixed) unit = ''
         if (.not. is_shown(result)) return
         if (is_ratio) then
            call show_frequency(result%shown, scale, unit)
            if (label == 'r' .or. index(label, 'r_') == 1) label = 'frequency'//label(2:)
         else if (own == mixed) then
            by_row = result%place(column%table, 'name') > 0
            if (by_row) call show_unit('F0/K', result%shown, scale, unit)
         else
            call show_unit(own, result%shown, scale, unit)
         end if
      end associate
   end subroutine show_column

   !> The unit of a parameter.
   pure character(4) function unit_of(parameter) result(unit)
      !> Its name.
      character(*), intent(in) :: parameter

      unit = ''
      if (parameter == 'clearance') unit = 'F0/K'
      if (parameter == 'load') unit = 'F0'
   end function unit_of

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
      character(:), allocatable :: label, unit
      real(wp) :: scales(size(result%columns)), scale
      logical :: by_row(size(result%columns))
      integer :: rows(size(result%tables)), i, row, start

      scales = 1
      by_row = .false.
      do i = 1, size(result%columns)
         if (is_listed(result%columns(i))) call show_column(result, i, label, scales(i), unit, &
            by_row(i))
      end do
      each_row: do row = first, last
         call find_rows(result%tables, findloc(result%tables%name == result%row, .true., 1), row, &
            rows)
         start = buffer%n
         do i = 1, size(result%columns)
            associate (filled => result%columns(i))
               if (.not. is_listed(filled)) cycle
               scale = scales(i)
               if (by_row(i)) then
                  if (.not. is_clearance(result, filled, rows(filled%table))) scale = 1
               end if
               call add_cells(filled, rows(filled%table), scale, buffer)
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

   !> Whether a row is that of a parameter called clearance.
   pure logical function is_clearance(result, filled, row)
      !> The result.
      type(result_type), intent(in) :: result
      !> A column of its table.
      type(filled_type), intent(in) :: filled
      !> The row of the table.
      integer, intent(in) :: row

      is_clearance = .false.
      associate (names => result%columns(result%place(filled%column%table, 'name')))
         if (names%k(row) > 0) is_clearance = names%words(names%k(row))%text == 'clearance'
      end associate
   end function is_clearance

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
   pure subroutine add_cells(filled, row, scale, buffer)
      !> The column.
      type(filled_type), intent(in) :: filled
      !> The row of its table.
      integer, intent(in) :: row
      !> The factor that shows its numbers in their unit.
      real(wp), intent(in) :: scale
      !> The text so far.
      type(buffer_type), intent(inout) :: buffer
      integer :: i

      do i = (row - 1)*filled%inner + 1, row*filled%inner
         select case (filled%column%kind)
         case (reals)
            call add_number(filled%x(i), scale, buffer)
         case (complexes)
            if (is_modulus(filled)) then
               call add_number(abs(cmplx(filled%x(2*i - 1), filled%x(2*i), wp)), 1.0_wp, &
                  buffer)
            else
               call add_number(filled%x(2*i - 1), 1.0_wp, buffer)
               call add_number(filled%x(2*i), 1.0_wp, buffer)
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

   !> Adds a number times a factor after a comma: with all digits (17) where the factor is 1, else
   !! with the 15 that rounding leaves, so that 4 mm are 4.00000000000000E+000. Numbers that are not
   !! finite are written as Python reads them.
   pure subroutine add_number(number, scale, buffer)
      !> The number, and the factor.
      real(wp), intent(in) :: number, scale
      !> The text so far.
      type(buffer_type), intent(inout) :: buffer
      character(24) :: digits
      real(wp) :: value

      value = number
      if (abs(scale - 1) > 0) value = scale*number
      if (.not. ieee_is_finite(value)) then
         if (ieee_is_nan(value)) then
            call add(buffer, ',nan')
         else
            call add(buffer, trim(merge(',inf ', ',-inf', value > 0)))
         end if
         return
      end if
      if (abs(scale - 1) > 0) then
         write (digits, '(es22.14e3)') value
      else
         write (digits, '(es24.16e3)') value
      end if
      call add(buffer, ','//trim(digits(verify(digits, ' '):)))
   end subroutine add_number

end module vi_csv
