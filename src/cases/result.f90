!> A result: named tables of columns, remarks, and notes on what was found and what failed.
!!
!! A study declares its columns as a constant table, opens the tables that it fills, and puts the
!! columns into them. All file formats are written from these by code that is independent of the
!! study. Tables are relational: each row of a child table names its row of the parent table, and a
!! column that depends on one dimension alone is in a table of that dimension.
module vi_result
   use vi_dictionary, only: dictionary_type, include_text
   use vi_key, only: every_model
   use vi_kinds, only: wp
   use vi_text, only: append, line_type, split
   use vi_units, only: shown_type
   implicit none (type, external)
   private

   public :: list_columns, rows_of, start_result

   !> Kinds of values: a number, a whole number, a word (its place in a list of words), a verdict as
   !! in vi_motion, a truth (1 for true, 0 for false), or a complex number.
   integer, parameter, public :: reals = 1, wholes = 2, words = 3, verdicts = 4, truths = 5, &
      complexes = 6

   !> Their names for programs.
   character(8), parameter, public :: column_kinds(complexes) = [character(8) :: 'real', 'whole', &
      'word', 'verdict', 'truth', 'complex']

   !> The declaration of a column; the order of the declarations is that of the CSV.
   type, public :: column_type
      character(16) :: table = ''
      character(24) :: name = ''
      integer :: kind = reals
      !> Name of the dimension within a row, if a row has several values: impact, multiplier.
      character(16) :: each = ''
      character(16) :: unit = ''
      character(160) :: meaning = ''
      !> The words of a column of words, separated by commas; empty if the study sets them later.
      character(160) :: words = ''
      !> Whether it is in the CSV, and its name there, if that differs: = stands for the name of the
      !! dimension of its table, # for the place within the row. A complex number has two columns,
      !! the real and the imaginary part, unless the name ends with modulus.
      logical :: listed = .true.
      character(28) :: label = ''
      !> A row with one of these values is not in the CSV.
      integer :: absent(2) = -huge(1)
      !> The model whose results have it. A column that differs for both is declared twice.
      integer :: model = every_model
   end type column_type

   !> A table: the size of its rows.
   type, public :: table_type
      character(16) :: name = ''
      !> Names of its dimensions, the one that varies fastest first; a table without dimensions has
      !! one row.
      character(16) :: dims(3) = ''
      integer :: n_dims = 0, sizes(3) = 1
      !> Place of its parent table, and the row of the parent to which each row belongs.
      integer :: parent = 0
      integer, allocatable :: owners(:)
   end type table_type

   !> A column with its values: rows of the table, and within a row the places of `each`.
   type, public :: filled_type
      !> An allocatable component, since gfortran 12 otherwise warns about its default values.
      type(column_type), allocatable :: column
      !> Place of its table; 0 while it has no values, as without outputs.
      integer :: table = 0
      !> Values in a row.
      integer :: inner = 1
      !> Numbers; for complex numbers the real and the imaginary part in turn.
      real(wp), allocatable :: x(:)
      !> Values of all other kinds.
      integer, allocatable :: k(:)
      !> The words, by their places.
      type(line_type), allocatable :: words(:)
   end type filled_type

   !> A line for the user: a fault, or something found.
   type, public :: note_type
      logical :: fault = .false.
      character(:), allocatable :: text
   end type note_type

   type, public :: result_type
      !> The complete case as a namelist, each line after `#`.
      type(line_type), allocatable :: case(:)
      !> Remarks for the header of a file.
      type(line_type), allocatable :: remarks(:)
      type(note_type), allocatable :: notes(:)
      type(table_type), allocatable :: tables(:)
      type(filled_type), allocatable :: columns(:)
      !> Name of the table whose rows are those of the CSV.
      character(16) :: row = ''
      !> Names of the outputs of a structure, for columns with a value for each of them.
      type(line_type), allocatable :: outputs(:)
      !> The units in which the CSV shows its numbers.
      type(shown_type) :: shown
      !> Whether there is nothing to write to a file, and whether this is due to lack of memory.
      logical :: empty = .false., no_memory = .false.
      !> How far the study got, if it was stopped before its end; otherwise empty.
      character(:), allocatable :: cut
   contains
      procedure :: fail, get_reals, get_wholes, open, place, put_codes, put_complexes, &
         put_reals, put_text, put_wholes, remark, add_note
      generic :: put => put_reals, put_wholes, put_complexes
   end type result_type

contains

   !> Adds columns for a model to a list.
   pure subroutine list_columns(model, columns, list)
      !> `every_model` or a model.
      integer, intent(in) :: model
      !> The columns.
      type(column_type), intent(in) :: columns(:)
      !> In and out: the list; it need not be allocated.
      type(column_type), allocatable, intent(inout) :: list(:)
      type(column_type), allocatable :: longer(:)
      integer :: n

      n = 0
      if (allocated(list)) n = size(list)
      allocate (longer(n + size(columns)))
      if (n > 0) longer(:n) = list
      longer(n + 1:) = columns
      if (model /= every_model) longer(n + 1:)%model = model
      call move_alloc(longer, list)
   end subroutine list_columns

   !> An empty result with its declared columns.
   pure subroutine start_result(case, columns, row, result, outputs, shown)
      !> The echo of the case.
      type(line_type), intent(in) :: case(:)
      !> The columns as the study declares them.
      type(column_type), intent(in) :: columns(:)
      !> The table whose rows are those of the CSV.
      character(*), intent(in) :: row
      !> The result, without values.
      type(result_type), intent(out) :: result
      !> Names of the outputs of a structure.
      type(line_type), intent(in), optional :: outputs(:)
      !> The units in which the CSV shows its numbers; none if absent.
      type(shown_type), intent(in), optional :: shown
      integer :: i

      if (present(shown)) result%shown = shown
      allocate (result%case, source=case)
      result%cut = ''
      allocate (result%remarks(0), result%notes(0), result%tables(0), &
         result%columns(size(columns)), result%outputs(0))
      if (present(outputs)) result%outputs = outputs
      do i = 1, size(columns)
         result%columns(i)%column = columns(i)
         call split_words(columns(i)%words, ',', result%columns(i)%words)
      end do
      result%row = row
   end subroutine start_result

   !> The words between separators.
   pure subroutine split_words(text, separator, list)
      !> Words.
      character(*), intent(in) :: text
      !> The character between two words.
      character, intent(in) :: separator
      !> The words, one per line.
      type(line_type), allocatable, intent(out) :: list(:)

      if (len_trim(text) > 0) then
         list = split(trim(text), separator)
      else
         allocate (list(0))
      end if
   end subroutine split_words

   !> Opens a table.
   pure subroutine open(result, name, dims, sizes, parent, owners)
      !> The result.
      class(result_type), intent(inout) :: result
      !> Name of the table.
      character(*), intent(in) :: name
      !> Names of its dimensions, separated by blanks, the one that varies fastest first.
      character(*), intent(in) :: dims
      !> Sizes of the dimensions.
      integer, intent(in) :: sizes(:)
      !> The parent table, which is open already.
      character(*), intent(in), optional :: parent
      !> The row of the parent to which each row belongs.
      integer, intent(in), optional :: owners(:)
      type(table_type), allocatable :: longer(:)
      type(line_type), allocatable :: list(:)
      integer :: n, i

      n = size(result%tables)
      allocate (longer(n + 1))
      longer(:n) = result%tables
      associate (table => longer(n + 1))
         table%name = name
         call split_words(dims, ' ', list)
         table%n_dims = size(list)
         do i = 1, size(list)
            table%dims(i) = list(i)%text
            table%sizes(i) = sizes(i)
         end do
         if (present(parent)) table%parent = findloc(longer%name == parent, .true., 1)
         if (present(owners)) table%owners = owners
      end associate
      call move_alloc(longer, result%tables)
   end subroutine open

   !> Place of a column that is about to be filled.
   pure subroutine find(result, table, name, values, i)
      !> The result.
      type(result_type), intent(inout) :: result
      !> Names of the table and of the column.
      character(*), intent(in) :: table, name
      !> Number of values, `inner` for each row.
      integer, intent(in) :: values
      !> Place of the column.
      integer, intent(out) :: i

      i = result%place(table, name)
      associate (filled => result%columns(i))
         filled%table = findloc(result%tables%name == table, .true., 1)
         if (rows_of(result%tables(filled%table)) > 0) filled%inner = &
            values/rows_of(result%tables(filled%table))
      end associate
   end subroutine find

   !> Place of a column; 0 if there is none of this name.
   pure integer function place(result, table, name)
      !> The result.
      class(result_type), intent(in) :: result
      !> Names of the table and of the column.
      character(*), intent(in) :: table, name

      do place = size(result%columns), 1, -1
         if (result%columns(place)%column%table == table .and. &
            result%columns(place)%column%name == name) return
      end do
   end function place

   !> Number of rows of a table.
   pure integer function rows_of(table) result(rows)
      !> A table.
      type(table_type), intent(in) :: table

      rows = product(table%sizes)
   end function rows_of

   !> Fills a column of numbers.
   pure subroutine put_reals(result, table, name, values, inner)
      !> The result.
      class(result_type), intent(inout) :: result
      !> Names of the table and of the column.
      character(*), intent(in) :: table, name
      !> Row by row.
      real(wp), intent(in) :: values(:)
      !> Number of values in a row, for a table that may have no rows.
      integer, intent(in), optional :: inner
      integer :: i

      call find(result, table, name, size(values), i)
      if (present(inner)) result%columns(i)%inner = inner
      result%columns(i)%x = values
   end subroutine put_reals

   !> Fills a column of complex numbers.
   pure subroutine put_complexes(result, table, name, values)
      !> The result.
      class(result_type), intent(inout) :: result
      !> Names of the table and of the column.
      character(*), intent(in) :: table, name
      !> Row by row.
      complex(wp), intent(in) :: values(:)
      integer :: i

      call find(result, table, name, size(values), i)
      allocate (result%columns(i)%x(2*size(values)))
      result%columns(i)%x(1::2) = values%re
      result%columns(i)%x(2::2) = values%im
   end subroutine put_complexes

   !> Fills a column of whole numbers, verdicts, logical values (1, 0) or places of declared words.
   pure subroutine put_wholes(result, table, name, values)
      !> The result.
      class(result_type), intent(inout) :: result
      !> Names of the table and of the column.
      character(*), intent(in) :: table, name
      !> Row by row.
      integer, intent(in) :: values(:)
      integer :: i

      call find(result, table, name, size(values), i)
      result%columns(i)%k = values
   end subroutine put_wholes

   !> Fills a column of words by their places in a list.
   pure subroutine put_codes(result, table, name, codes, list)
      !> The result.
      class(result_type), intent(inout) :: result
      !> Names of the table and of the column.
      character(*), intent(in) :: table, name
      !> Row by row; 0 for no word.
      integer, intent(in) :: codes(:)
      !> The words.
      type(line_type), intent(in) :: list(:)
      integer :: i

      call result%put_wholes(table, name, codes)
      i = result%place(table, name)
      result%columns(i)%words = list
   end subroutine put_codes

   !> Fills a column of words; each is kept once.
   pure subroutine put_text(result, table, name, lines)
      !> The result.
      class(result_type), intent(inout) :: result
      !> Names of the table and of the column.
      character(*), intent(in) :: table, name
      !> Row by row.
      type(line_type), intent(in) :: lines(:)
      type(dictionary_type) :: list
      integer :: codes(size(lines)), i

      allocate (list%texts(0))
      do i = 1, size(lines)
         call include_text(list, lines(i)%text, codes(i))
      end do
      call result%put_codes(table, name, codes, list%texts(:list%n))
   end subroutine put_text

   !> The numbers of a column, row by row.
   pure subroutine get_reals(result, table, name, values)
      !> The result.
      class(result_type), intent(in) :: result
      !> Names of the table and of the column.
      character(*), intent(in) :: table, name
      !> A copy of them; for complex numbers the real and the imaginary part in turn.
      real(wp), allocatable, intent(out) :: values(:)

      values = result%columns(result%place(table, name))%x
   end subroutine get_reals

   !> The whole numbers of a column, or its codes.
   pure subroutine get_wholes(result, table, name, values)
      !> The result.
      class(result_type), intent(in) :: result
      !> Names of the table and of the column.
      character(*), intent(in) :: table, name
      !> A copy of them.
      integer, allocatable, intent(out) :: values(:)

      values = result%columns(result%place(table, name))%k
   end subroutine get_wholes

   !> Adds a line to the header of files.
   pure subroutine remark(result, text)
      !> The result.
      class(result_type), intent(inout) :: result
      !> The line.
      character(*), intent(in) :: text

      call append(result%remarks, text)
   end subroutine remark

   !> Adds a line on what was found.
   pure subroutine add_note(result, text)
      !> The result.
      class(result_type), intent(inout) :: result
      !> The line.
      character(*), intent(in) :: text

      call append_note(result, .false., text)
   end subroutine add_note

   !> Adds a line on what failed or does not exist.
   pure subroutine fail(result, text)
      !> The result.
      class(result_type), intent(inout) :: result
      !> The line.
      character(*), intent(in) :: text

      call append_note(result, .true., text)
   end subroutine fail

   !> Adds a note.
   pure subroutine append_note(result, fault, text)
      !> The result.
      class(result_type), intent(inout) :: result
      !> Whether something failed.
      logical, intent(in) :: fault
      !> The line.
      character(*), intent(in) :: text
      type(note_type), allocatable :: longer(:)
      integer :: n

      n = size(result%notes)
      allocate (longer(n + 1))
      longer(:n) = result%notes
      longer(n + 1)%fault = fault
      longer(n + 1)%text = text
      call move_alloc(longer, result%notes)
   end subroutine append_note

end module vi_result
