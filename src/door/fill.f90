!> Fills a result with values from a caller after checking them: the values of a study always fit,
!! those of a program in another language may not.
module vi_fill
   use, intrinsic :: iso_c_binding, only: c_int64_t
   use vi_door, only: fill_reals, fill_wholes, open_table, result_of, set_fault
   use vi_kinds, only: wp
   use vi_result, only: complexes, reals, result_type, rows_of, words
   use vi_text, only: line_type, split, whole
   implicit none (type, external)
   private

   public :: is_open_for, put_reals, put_table, put_wholes

contains

   !> Whether a handle refers to a result that can be filled.
   logical function is_open_for(handle)
      !> Handle from `new_result`.
      integer(c_int64_t), intent(in) :: handle
      type(result_type), pointer :: result

      result => result_of(handle)
      is_open_for = associated(result)
      if (is_open_for) is_open_for = allocated(result%tables)
   end function is_open_for

   !> Opens a table; a fault is recorded in the result.
   subroutine put_table(handle, name, dims, sizes, parent, owners, good)
      !> Handle of a result that can be filled.
      integer(c_int64_t), intent(in) :: handle
      !> Name of the table, and its dimensions separated by blanks, the one that varies fastest
      !! first.
      character(*), intent(in) :: name, dims
      !> Sizes of the dimensions.
      integer, intent(in) :: sizes(:)
      !> The parent table; empty if there is none.
      character(*), intent(in) :: parent
      !> The row of the parent, from 1, to which each row belongs.
      integer, intent(in) :: owners(:)
      !> Whether it was opened.
      logical, intent(out) :: good
      type(result_type), pointer :: result
      character(:), allocatable :: fault
      integer :: i, n, place, rows

      result => result_of(handle)
      fault = ''
      n = count([(dims(i:i) /= ' ' .and. (i == 1 .or. dims(max(1, i - 1):max(1, i - 1)) == ' '), &
         i=1, len(dims))])
      rows = rows_in(sizes)
      place = findloc(result%tables%name == parent, .true., 1)
      if (len(name) == 0 .or. len(name) > len(result%row)) then
         fault = 'must have a name of at most 16 letters'
      else if (any(result%tables%name == name)) then
         fault = 'is already open'
      else if (n > 3 .or. n /= size(sizes)) then
         fault = 'has '//whole(n)//' names of dimensions and '//whole(size(sizes))// &
            ' sizes; must be the same number, at most 3'
      else if (rows < 0) then
         fault = 'has a size that is negative or too large'
      else if (len(parent) > 0 .and. place == 0) then
         fault = 'has the parent '//parent//', which is not open'
      else if (len(parent) > 0) then
         if (size(owners) /= rows) then
            fault = 'has '//whole(rows)//' rows and '//whole(size(owners))//' owners'
         else if (any(owners < 1 .or. owners > rows_of(result%tables(place)))) then
            fault = 'has an owner that is not a row of '//parent
         end if
      end if
      good = len(fault) == 0
      if (good) then
         call open_table(handle, name, dims, sizes, parent, owners)
      else
         call set_fault(handle, 'table '//name//': '//fault)
      end if
   end subroutine put_table

   !> Number of rows of a table of these sizes; -1 if no table can have them.
   pure integer function rows_in(sizes) result(rows)
      !> Sizes of its dimensions.
      integer, intent(in) :: sizes(:)
      integer :: i

      rows = 1
      do i = 1, size(sizes)
         if (sizes(i) < 0) rows = -1
         if (rows < 0) return
         if (sizes(i) > 0) then
            if (rows > huge(1)/sizes(i)) then
               rows = -1
               return
            end if
         end if
         rows = rows*sizes(i)
      end do
   end function rows_in

   !> Fills a column of numbers or of complex numbers; a fault is recorded in the result.
   subroutine put_reals(handle, table, name, values, good)
      !> Handle of a result that can be filled.
      integer(c_int64_t), intent(in) :: handle
      !> Names of the table and of the column.
      character(*), intent(in) :: table, name
      !> Row by row; for complex numbers the real and the imaginary part in turn.
      real(wp), intent(in) :: values(:)
      !> Whether it was filled.
      logical, intent(out) :: good

      call check(handle, table, name, size(values), .true., good)
      if (good) call fill_reals(handle, table, name, values)
   end subroutine put_reals

   !> Fills a column of any other kind; a fault is recorded in the result.
   subroutine put_wholes(handle, table, name, values, list, good)
      !> Handle of a result that can be filled.
      integer(c_int64_t), intent(in) :: handle
      !> Names of the table and of the column.
      character(*), intent(in) :: table, name
      !> Row by row; for words their places, 0 for none.
      integer, intent(in) :: values(:)
      !> Words separated by line feeds; empty if the column has none, or if they are declared.
      character(*), intent(in) :: list
      !> Whether it was filled.
      logical, intent(out) :: good
      type(result_type), pointer :: result
      type(line_type), allocatable :: given(:)
      integer :: i, n

      call check(handle, table, name, size(values), .false., good)
      if (.not. good) return
      result => result_of(handle)
      i = result%place(table, name)
      if (result%columns(i)%column%kind == words) then
         n = size(result%columns(i)%words)
         if (len(list) > 0) then
            given = split(list, new_line('a'))
            n = size(given)
         end if
         good = all(values >= 0 .and. values <= n)
      else
         good = len(list) == 0
      end if
      if (good .and. len(list) > 0) then
         call fill_wholes(handle, table, name, values, list)
      else if (good) then
         call fill_wholes(handle, table, name, values)
      else
         call set_fault(handle, 'column '//name//' of '//table//': a value is not the index of a &
            &word, or words are given for a column of another kind')
      end if
   end subroutine put_wholes

   !> Whether a column exists, accepts such values, and gets complete rows.
   subroutine check(handle, table, name, n, are_reals, good)
      !> Handle of a result that can be filled.
      integer(c_int64_t), intent(in) :: handle
      !> Names of the table and of the column.
      character(*), intent(in) :: table, name
      !> Number of values.
      integer, intent(in) :: n
      !> Whether they are floating-point numbers.
      logical, intent(in) :: are_reals
      !> Whether it may be filled.
      logical, intent(out) :: good
      type(result_type), pointer :: result
      character(:), allocatable :: fault
      integer :: i, place, each, rows

      result => result_of(handle)
      fault = ''
      i = result%place(table, name)
      place = findloc(result%tables%name == table, .true., 1)
      if (i == 0) then
         fault = 'is not a column of this study'
      else if (place == 0) then
         fault = 'its table is not open'
      else if (result%columns(i)%table > 0) then
         fault = 'is already filled'
      else
         associate (column => result%columns(i)%column)
            rows = rows_of(result%tables(place))
            each = merge(2, 1, column%kind == complexes)
            if (are_reals .neqv. (column%kind == reals .or. column%kind == complexes)) then
               fault = 'is of a different kind'
            else if (modulo(n, each) > 0 .or. (rows == 0 .and. n > 0)) then
               fault = whole(n)//' values are not a whole number of rows'
            else if (rows > 0) then
               if (n == 0 .or. modulo(n, each*max(1, rows)) > 0 .or. &
                  (len_trim(column%each) == 0 .and. n /= each*rows)) fault = &
                  whole(n)//' values do not fill '//whole(rows)//' rows'
            end if
         end associate
      end if
      good = len(fault) == 0
      if (.not. good) call set_fault(handle, 'column '//name//' of '//table//': '//fault)
   end subroutine check

end module vi_fill
