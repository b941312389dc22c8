!> The interface for C: converts C arguments to those of vi_door, and back. vibroimpact.h documents
!! each procedure.
module vi_c_door
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_int, &
      c_int32_t, c_int64_t, c_loc, c_null_char, c_null_ptr, c_ptr, c_size_t
   use vi_describe, only: describe_all
   use vi_door, only: done, failed, fault_of, free_result, list_cases, new_result, no_result, &
      result_of, run_text, add_notes_of, wrong
   use vi_fill, only: is_open_for, put_reals, put_table, put_wholes
   use vi_processor, only: available_threads
   use vi_result, only: filled_type, result_type, rows_of, table_type
   use vi_answer, only: answer, answer_word
   use vi_text, only: join, line_type
   use vi_version, only: version
   use vi_write_csv, only: write_csv
   use vi_csv, only: has_rows
   implicit none (type, external)
   private

   public :: c_case_list, c_column, c_describe, c_find, c_free, c_line, c_new, c_open, &
      c_put_reals, c_put_wholes, c_put_words, c_run, c_say, c_status, c_table, c_text, c_version, &
      c_word, c_write

   !> Largest number of threads.
   integer, parameter :: most_threads = 1024

   !> The struct vibroimpact_table of the header.
   type, bind(c), public :: c_table_type
      character(kind=c_char) :: name(17)
      character(kind=c_char) :: dims(17, 3)
      integer(c_int32_t) :: n_dims
      integer(c_int32_t) :: sizes(3)
      integer(c_int32_t) :: rows
      integer(c_int32_t) :: parent
      type(c_ptr) :: owners
   end type c_table_type

   !> The struct vibroimpact_column of the header.
   type, bind(c), public :: c_column_type
      character(kind=c_char) :: table(17)
      character(kind=c_char) :: name(25)
      character(kind=c_char) :: each(17)
      character(kind=c_char) :: unit(17)
      character(kind=c_char) :: label(29)
      character(kind=c_char) :: meaning(161)
      integer(c_int32_t) :: kind
      integer(c_int32_t) :: listed
      integer(c_int32_t) :: place
      integer(c_int32_t) :: table_place
      integer(c_int32_t) :: n_dims
      integer(c_int32_t) :: shape(4)
      integer(c_int32_t) :: n_words
      type(c_ptr) :: x
      type(c_ptr) :: k
   end type c_column_type

   interface
      !> Number of characters of a C string.
      pure integer(c_size_t) function strlen(text) bind(c)
         import :: c_ptr, c_size_t
         implicit none (type, external)
         !> A text that ends with a null character.
         type(c_ptr), value, intent(in) :: text
      end function strlen
   end interface

contains

   !> Runs the one case of a text.
   integer(c_int) function c_run(text, threads, progress, handle) result(status) &
      bind(c, name='vibroimpact_run')
      !> The namelist.
      type(c_ptr), value, intent(in) :: text
      !> Number of OpenMP threads; 0 for all that are available.
      integer(c_int), value, intent(in) :: threads
      !> Three progress counters, see vi_progress, or null.
      integer(c_int), intent(inout), optional :: progress(3)
      !> The result.
      integer(c_int64_t), intent(inout), optional :: handle
      character(:), allocatable :: characters
      integer :: workers

      status = no_result
      if (.not. present(handle)) return
      call take(text, characters)
      workers = min(threads, most_threads)
      if (workers < 1) workers = available_threads()
      call run_text(characters, workers, handle, status, progress)
   end function c_run

   !> Lists the cases of a text.
   integer(c_int) function c_case_list(text, handle) result(status) &
      bind(c, name='vibroimpact_cases')
      !> The namelist.
      type(c_ptr), value, intent(in) :: text
      !> The result, with a table of the cases.
      integer(c_int64_t), intent(inout), optional :: handle
      character(:), allocatable :: characters

      status = no_result
      if (.not. present(handle)) return
      call take(text, characters)
      call list_cases(characters, handle, status)
   end function c_case_list

   !> Makes a result without tables.
   integer(c_int) function c_new(text, handle) result(status) bind(c, name='vibroimpact_new')
      !> The namelist of its case.
      type(c_ptr), value, intent(in) :: text
      !> The result.
      integer(c_int64_t), intent(inout), optional :: handle
      character(:), allocatable :: characters

      status = no_result
      if (.not. present(handle)) return
      call take(text, characters)
      call new_result(characters, handle, status)
   end function c_new

   !> Status of a result.
   integer(c_int) function c_status(handle) result(status) bind(c, name='vibroimpact_status')
      !> The result.
      integer(c_int64_t), value, intent(in) :: handle
      character(:), allocatable :: message
      integer :: line

      call fault_of(handle, status, message, line)
   end function c_status

   !> Line of a fault.
   integer(c_int) function c_line(handle) result(line) bind(c, name='vibroimpact_line')
      !> The result.
      integer(c_int64_t), value, intent(in) :: handle
      character(:), allocatable :: message
      integer :: status

      call fault_of(handle, status, message, line)
   end function c_line

   !> A text of a result.
   integer(c_size_t) function c_text(handle, what, out, capacity) result(n) &
      bind(c, name='vibroimpact_text')
      !> The result.
      integer(c_int64_t), value, intent(in) :: handle
      !> Kind of text, one of the codes of vi_answer.
      integer(c_int), value, intent(in) :: what
      !> Buffer for the text.
      type(c_ptr), value, intent(in) :: out
      !> Number of bytes of the buffer.
      integer(c_size_t), value, intent(in) :: capacity
      character(:), allocatable :: characters

      call answer(handle, what, characters)
      call give(characters, out, capacity, n)
   end function c_text

   !> Writes a result as CSV.
   integer(c_int) function c_write(handle, path, out, capacity) result(status) &
      bind(c, name='vibroimpact_write')
      !> The result.
      integer(c_int64_t), value, intent(in) :: handle
      !> Path of the file.
      type(c_ptr), value, intent(in) :: path
      !> Buffer for a message.
      type(c_ptr), value, intent(in) :: out
      !> Number of bytes of the buffer.
      integer(c_size_t), value, intent(in) :: capacity
      type(result_type), pointer :: result
      character(:), allocatable :: characters, message
      integer(c_size_t) :: n

      call find_result(handle, result)
      status = no_result
      message = 'there is no result'
      call take(path, characters)
      if (associated(result)) then
         status = failed
         if (result%empty) then
            message = 'the result is empty: there is nothing to write'
         else if (.not. has_rows(result)) then
            message = 'a column of the file has no values'
         else
            call write_csv(result, characters, message)
            if (len(message) > 0) message = characters//': '//message
            status = merge(done, failed, len(message) == 0)
         end if
      end if
      call give(message, out, capacity, n)
   end function c_write

   !> A table by its place.
   integer(c_int) function c_table(handle, place, info) result(status) &
      bind(c, name='vibroimpact_table')
      !> The result.
      integer(c_int64_t), value, intent(in) :: handle
      !> Place of the table or column, from 0.
      integer(c_int), value, intent(in) :: place
      !> The table.
      type(c_table_type), intent(inout), optional :: info
      type(result_type), pointer :: result

      status = no_result
      call find_result(handle, result)
      if (.not. associated(result) .or. .not. present(info)) return
      if (place < 0 .or. place >= size(result%tables)) return
      call describe_table(result%tables(place + 1), info)
      status = done
   end function c_table

   !> Fills the struct of a table.
   subroutine describe_table(table, info)
      !> The table.
      type(table_type), intent(in), target :: table
      !> The struct of C that is filled.
      type(c_table_type), intent(inout) :: info
      integer :: i

      call put_name(table%name, info%name)
      do i = 1, 3
         call put_name(table%dims(i), info%dims(:, i))
      end do
      info%n_dims = table%n_dims
      info%sizes = table%sizes
      info%rows = rows_of(table)
      info%parent = table%parent - 1
      info%owners = c_null_ptr
      if (allocated(table%owners)) info%owners = c_loc(table%owners)
   end subroutine describe_table

   !> A column by its place.
   integer(c_int) function c_column(handle, place, info) result(status) &
      bind(c, name='vibroimpact_column')
      !> The result.
      integer(c_int64_t), value, intent(in) :: handle
      !> Place of the table or column, from 0.
      integer(c_int), value, intent(in) :: place
      !> The column.
      type(c_column_type), intent(inout), optional :: info
      type(result_type), pointer :: result

      status = no_result
      call find_result(handle, result)
      if (.not. associated(result) .or. .not. present(info)) return
      if (place < 0 .or. place >= size(result%columns)) return
      call describe_column(result, result%columns(place + 1), place, info)
      status = done
   end function c_column

   !> A column by its name.
   integer(c_int) function c_find(handle, table, name, info) result(status) &
      bind(c, name='vibroimpact_find')
      !> The result.
      integer(c_int64_t), value, intent(in) :: handle
      !> Name of the table.
      type(c_ptr), value, intent(in) :: table
      !> Name of the column.
      type(c_ptr), value, intent(in) :: name
      !> The column.
      type(c_column_type), intent(inout), optional :: info
      type(result_type), pointer :: result
      character(:), allocatable :: table_name, column_name

      status = no_result
      call find_result(handle, result)
      if (.not. associated(result)) return
      call take(table, table_name)
      call take(name, column_name)
      status = c_column(handle, result%place(table_name, column_name) - 1, info)
   end function c_find

   !> Fills the struct of a column.
   subroutine describe_column(result, filled, place, info)
      !> The result.
      type(result_type), intent(in) :: result
      !> The column.
      type(filled_type), intent(in), target :: filled
      !> Place of the column, from 0.
      integer, intent(in) :: place
      !> The struct of C that is filled.
      type(c_column_type), intent(inout) :: info
      integer :: own

      associate (column => filled%column)
         call put_name(column%table, info%table)
         call put_name(column%name, info%name)
         call put_name(column%each, info%each)
         call put_name(column%unit, info%unit)
         call put_name(column%label, info%label)
         call put_name(column%meaning, info%meaning)
         info%kind = column%kind
         info%listed = merge(1, 0, column%listed)
         own = merge(1, 0, len_trim(column%each) > 0)
      end associate
      info%place = place
      info%table_place = filled%table - 1
      info%shape = 1
      info%n_dims = own
      if (own == 1) info%shape(1) = filled%inner
      if (filled%table > 0) then
         associate (table => result%tables(filled%table))
            info%n_dims = own + table%n_dims
            info%shape(own + 1:own + table%n_dims) = table%sizes(:table%n_dims)
         end associate
      end if
      info%n_words = size(filled%words)
      info%x = c_null_ptr
      info%k = c_null_ptr
      if (allocated(filled%x)) info%x = c_loc(filled%x)
      if (allocated(filled%k)) info%k = c_loc(filled%k)
   end subroutine describe_column

   !> A word of a column of words.
   integer(c_size_t) function c_word(handle, column, code, out, capacity) result(n) &
      bind(c, name='vibroimpact_word')
      !> The result.
      integer(c_int64_t), value, intent(in) :: handle
      !> Place of the column, from 0.
      integer(c_int), value, intent(in) :: column
      !> Number of the word in the column, from 1.
      integer(c_int), value, intent(in) :: code
      !> Buffer for the text.
      type(c_ptr), value, intent(in) :: out
      !> Number of bytes of the buffer.
      integer(c_size_t), value, intent(in) :: capacity
      character(:), allocatable :: characters

      characters = ''
      if (column >= 0 .and. column < huge(1)) call answer_word(handle, column + 1, code, characters)
      call give(characters, out, capacity, n)
   end function c_word

   !> Opens a table.
   integer(c_int) function c_open(handle, name, dims, n_dims, sizes, parent, n_owners, owners) &
      result(status) bind(c, name='vibroimpact_open')
      !> The result.
      integer(c_int64_t), value, intent(in) :: handle
      !> Name of the table.
      type(c_ptr), value, intent(in) :: name
      !> Names of the dimensions, separated by blanks.
      type(c_ptr), value, intent(in) :: dims
      !> Number of dimensions.
      integer(c_int), value, intent(in) :: n_dims
      !> Sizes of the dimensions.
      type(c_ptr), value, intent(in) :: sizes
      !> Name of the parent, or null.
      type(c_ptr), value, intent(in) :: parent
      !> Number of owners.
      integer(c_int), value, intent(in) :: n_owners
      !> Row of the parent, from 1, to which each row belongs.
      type(c_ptr), value, intent(in) :: owners
      character(:), allocatable :: table_name, dim_names, parent_name
      integer(c_int), pointer :: all_sizes(:), all_owners(:)
      logical :: good

      status = no_result
      if (.not. is_open_for(handle)) return
      call take(name, table_name)
      call take(dims, dim_names)
      call take(parent, parent_name)
      call wholes_at(sizes, n_dims, all_sizes)
      call wholes_at(owners, n_owners, all_owners)
      call put_table(handle, table_name, dim_names, all_sizes, parent_name, all_owners, good)
      if (.not. c_associated(sizes)) deallocate (all_sizes)
      if (.not. c_associated(owners)) deallocate (all_owners)
      status = merge(done, wrong, good)
   end function c_open

   !> Fills a column of numbers.
   integer(c_int) function c_put_reals(handle, table, name, n, values) result(status) &
      bind(c, name='vibroimpact_put_reals')
      !> The result.
      integer(c_int64_t), value, intent(in) :: handle
      !> Name of the table.
      type(c_ptr), value, intent(in) :: table
      !> Name of the column.
      type(c_ptr), value, intent(in) :: name
      !> Number of values.
      integer(c_int), value, intent(in) :: n
      !> Row by row.
      real(c_double), intent(in), optional :: values(n)
      character(:), allocatable :: table_name, column_name
      logical :: good

      status = no_result
      if (.not. is_open_for(handle)) return
      call take(table, table_name)
      call take(name, column_name)
      if (present(values)) then
         call put_reals(handle, table_name, column_name, values, good)
      else
         call put_reals(handle, table_name, column_name, [real(c_double) ::], good)
      end if
      status = merge(done, wrong, good)
   end function c_put_reals

   !> Fills a column of whole numbers, truths or verdicts, or of declared words.
   integer(c_int) function c_put_wholes(handle, table, name, n, values) result(status) &
      bind(c, name='vibroimpact_put_wholes')
      !> The result.
      integer(c_int64_t), value, intent(in) :: handle
      !> Name of the table.
      type(c_ptr), value, intent(in) :: table
      !> Name of the column.
      type(c_ptr), value, intent(in) :: name
      !> Number of values.
      integer(c_int), value, intent(in) :: n
      !> Row by row.
      integer(c_int), intent(in), optional :: values(n)

      status = c_put_words(handle, table, name, n, values, c_null_ptr)
   end function c_put_wholes

   !> Fills a column of words.
   integer(c_int) function c_put_words(handle, table, name, n, codes, list) result(status) &
      bind(c, name='vibroimpact_put_words')
      !> The result.
      integer(c_int64_t), value, intent(in) :: handle
      !> Name of the table.
      type(c_ptr), value, intent(in) :: table
      !> Name of the column.
      type(c_ptr), value, intent(in) :: name
      !> Number of values.
      integer(c_int), value, intent(in) :: n
      !> Place of the word of each row, from 1; 0 for none.
      integer(c_int), intent(in), optional :: codes(n)
      !> The words, separated by line feeds.
      type(c_ptr), value, intent(in) :: list
      character(:), allocatable :: table_name, column_name, characters
      logical :: good

      status = no_result
      if (.not. is_open_for(handle)) return
      call take(table, table_name)
      call take(name, column_name)
      call take(list, characters)
      if (present(codes)) then
         call put_wholes(handle, table_name, column_name, codes, characters, good)
      else
         call put_wholes(handle, table_name, column_name, [integer(c_int) ::], characters, good)
      end if
      status = merge(done, wrong, good)
   end function c_put_words

   !> Sets the remarks of a result that the caller has filled, and how far the study got.
   integer(c_int) function c_say(handle, cut, remarks) result(status) &
      bind(c, name='vibroimpact_say')
      !> The result.
      integer(c_int64_t), value, intent(in) :: handle
      !> How far the study got, or null.
      type(c_ptr), value, intent(in) :: cut
      !> Lines, each ended by a line feed, or null.
      type(c_ptr), value, intent(in) :: remarks
      character(:), allocatable :: how_far, lines

      status = no_result
      if (.not. is_open_for(handle)) return
      call take(cut, how_far)
      call take(remarks, lines)
      call add_notes_of(handle, how_far, lines)
      status = done
   end function c_say

   !> The language of namelists and the columns of all results as JSON.
   integer(c_size_t) function c_describe(out, capacity) result(n) bind(c, &
      name='vibroimpact_describe')
      !> Buffer for the text.
      type(c_ptr), value, intent(in) :: out
      !> Number of bytes of the buffer.
      integer(c_size_t), value, intent(in) :: capacity
      type(line_type), allocatable :: lines(:)

      call describe_all(lines)
      call give(join(lines, new_line('a')), out, capacity, n)
   end function c_describe

   !> The version of the library.
   integer(c_size_t) function c_version(out, capacity) result(n) bind(c, name='vibroimpact_version')
      !> Buffer for the text.
      type(c_ptr), value, intent(in) :: out
      !> Number of bytes of the buffer.
      integer(c_size_t), value, intent(in) :: capacity

      call give(version, out, capacity, n)
   end function c_version

   !> Frees a result.
   subroutine c_free(handle) bind(c, name='vibroimpact_free')
      !> The result.
      integer(c_int64_t), value, intent(in) :: handle

      call free_result(handle)
   end subroutine c_free

   !> The result behind a handle; null if there is none, or if its case is wrong.
   subroutine find_result(handle, result)
      !> The result.
      integer(c_int64_t), intent(in) :: handle
      !> The result with its tables.
      type(result_type), pointer, intent(out) :: result

      result => null()
      if (is_open_for(handle)) result => result_of(handle)
   end subroutine find_result

   !> A C array of whole numbers; for a null pointer an empty array, which the caller has to free.
   subroutine wholes_at(address, n, values)
      !> Address of the first number.
      type(c_ptr), intent(in) :: address
      !> Number of values.
      integer(c_int), intent(in) :: n
      !> The numbers.
      integer(c_int), pointer, intent(out) :: values(:)

      if (c_associated(address)) then
         call c_f_pointer(address, values, [max(0, n)])
      else
         allocate (values(0))
      end if
   end subroutine wholes_at

   !> A C string; empty for a null pointer.
   subroutine take(pointer, text)
      !> A text that ends with a null character, or a null pointer.
      type(c_ptr), intent(in) :: pointer
      !> The text.
      character(:), allocatable, intent(out) :: text
      character(kind=c_char), pointer :: characters(:)
      integer :: i, n

      n = 0
      if (c_associated(pointer)) n = int(strlen(pointer))
      allocate (character(n) :: text)
      if (n == 0) return
      call c_f_pointer(pointer, characters, [n])
      do i = 1, n
         text(i:i) = characters(i)
      end do
   end subroutine take

   !> Copies a text to a C buffer: as much of it as fits, followed by a null character.
   subroutine give(text, out, capacity, n)
      !> The text.
      character(*), intent(in) :: text
      !> Buffer for the text, or null.
      type(c_ptr), intent(in) :: out
      !> Number of bytes of the buffer; huge numbers look negative here.
      integer(c_size_t), intent(in) :: capacity
      !> Bytes of the whole text, without the null character.
      integer(c_size_t), intent(out) :: n
      character(kind=c_char), pointer :: characters(:)
      integer :: i, kept

      n = len(text, c_size_t)
      if (capacity == 0 .or. .not. c_associated(out)) return
      kept = int(n)
      if (capacity > 0) kept = int(min(n, capacity - 1))
      call c_f_pointer(out, characters, [kept + 1])
      do i = 1, kept
         characters(i) = text(i:i)
      end do
      characters(kept + 1) = c_null_char
   end subroutine give

   !> Copies a name to a field of a struct.
   pure subroutine put_name(name, field)
      !> The name, padded with blanks.
      character(*), intent(in) :: name
      !> The field, one character longer for the null character.
      character(kind=c_char), intent(inout) :: field(:)
      integer :: i

      field = c_null_char
      do i = 1, min(len_trim(name), size(field) - 1)
         field(i) = name(i:i)
      end do
   end subroutine put_name

end module vi_c_door
