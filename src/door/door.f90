!> The interface for other languages: a case is passed as the text of a namelist, and its result is
!! returned as tables that are accessed by a handle.
!!
!! A handle is the address of a holder on the heap: there is no list of handles, no lock and no
!! global state, so that threads are independent of each other. The caller frees it, once.
module vi_door
   use, intrinsic :: iso_c_binding, only: c_associated, c_f_pointer, c_int64_t, c_intptr_t, c_loc, &
      c_null_ptr, c_ptr
   use vi_buffer, only: add, add_quoted, buffer_type
   use vi_case, only: case_type, echo, first_line, first_line_in_si, first_line_of_structure, &
      outputs_of, shown_of
   use vi_lines, only: unify_line_ends
   use vi_parse_cases, only: find_name, parse_cases
   use vi_key, only: of_structure
   use vi_kinds, only: wp
   use vi_result, only: column_type, complexes, filled_type, result_type, &
      start_result, table_type, wholes, words
   use vi_study, only: study_type
   use vi_study_list, only: find_study, run_study
   use vi_text, only: line_type, split, whole
   implicit none (type, external)
   private

   public :: bare_text, describe_result, fault_of, fill_reals, fill_wholes, free_result, &
      list_cases, name_after, new_bare_result, new_result, new_text, open_table, result_of, &
      run_text, add_notes_of, set_fault

   !> Status of a result: done; ran, but something failed or does not exist; the case is wrong.
   integer, parameter, public :: done = 0, failed = 1, wrong = 2
   !> Status of an invalid handle (0, or one that was freed), and of a case for which memory or
   !! stack are insufficient.
   integer, parameter, public :: no_result = 3, no_memory = 4
   !> The number at the start of a holder's memory, by which most freed handles are detected.
   integer(c_int64_t), parameter :: mark = 8387236825288893542_c_int64_t

   type :: holder_type
      integer(c_int64_t) :: mark = 0
      !> The fault of the case; empty if there is none.
      character(:), allocatable :: message
      !> Line of the text with the fault; 0 if it has none.
      integer :: line = 0
      !> `done`, `failed` or `wrong`.
      integer :: status = wrong
      type(result_type) :: result
   end type holder_type

   !> The columns of `list_cases`.
   type(column_type), parameter :: case_columns(*) = [ &
      column_type('cases', 'name', words, meaning='name of the result'), &
      column_type('cases', 'study', words, meaning='name of the study'), &
      column_type('cases', 'line', wholes, &
      meaning='line of its name, or otherwise of the group that asks for the result'), &
      column_type('cases', 'text', words, meaning='the complete case as a separate namelist', &
      listed=.false.)]

contains

   !> Runs the one case of a namelist.
   subroutine run_text(text, threads, handle, status, progress)
      !> The namelist.
      character(*), intent(in) :: text
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> The result, to be freed with `free_result`; it exists whatever the status.
      integer(c_int64_t), intent(out) :: handle
      !> `done`, `failed` or `wrong`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(holder_type), pointer :: holder
      type(case_type), allocatable :: cases(:)

      call new_holder(text, holder, cases)
      handle = address_of(c_loc(holder))
      call take_one(holder, cases)
      status = wrong
      if (len(holder%message) > 0) return
      call run_study(cases(1), threads, holder%result, progress)
      status = merge(failed, done, any(holder%result%notes%fault))
      if (holder%result%no_memory) status = no_memory
      holder%status = status
   end subroutine run_text

   !> The cases of a namelist as a result: name, study, line and text of each.
   subroutine list_cases(text, handle, status)
      !> The namelist.
      character(*), intent(in) :: text
      !> The result, to be freed with `free_result`; it exists whatever the status.
      integer(c_int64_t), intent(out) :: handle
      !> `done` or `wrong`.
      integer, intent(out) :: status
      type(holder_type), pointer :: holder
      type(case_type), allocatable :: cases(:)
      type(line_type), allocatable :: lines(:), names(:), studies(:), texts(:)
      integer, allocatable :: places(:)
      integer :: i

      call new_holder(text, holder, cases)
      handle = address_of(c_loc(holder))
      status = wrong
      if (len(holder%message) > 0) return
      allocate (lines(0), names(size(cases)), studies(size(cases)), texts(size(cases)), &
         places(size(cases)))
      call start_result(lines, case_columns, 'cases', holder%result)
      do i = 1, size(cases)
         names(i)%text = cases(i)%name
         studies(i)%text = cases(i)%study_name
         places(i) = cases(i)%line
         call echo(cases(i), lines)
         call bare_text(lines, texts(i)%text)
      end do
      call holder%result%open('cases', 'case', [size(cases)])
      call holder%result%put_text('cases', 'name', names)
      call holder%result%put_text('cases', 'study', studies)
      call holder%result%put('cases', 'line', places)
      call holder%result%put_text('cases', 'text', texts)
      status = done
      holder%status = status
   end subroutine list_cases

   !> A holder on the heap with the cases of a text, or with the fault of the text.
   subroutine new_holder(text, holder, cases)
      !> The namelist.
      character(*), intent(in) :: text
      !> The new holder, without a result.
      type(holder_type), pointer, intent(out) :: holder
      !> The cases of the text.
      type(case_type), allocatable, intent(out) :: cases(:)
      character(:), allocatable :: clean

      allocate (holder)
      holder%mark = mark
      call unify_line_ends(text, clean)
      call parse_cases(clean, '', cases, holder%message, holder%line)
   end subroutine new_holder

   !> Sets a fault if the text does not contain exactly one case.
   subroutine take_one(holder, cases)
      !> In: the holder of the text. Out: with a fault unless the text contains exactly one case.
      type(holder_type), intent(inout) :: holder
      !> The cases of the text.
      type(case_type), intent(in) :: cases(:)

      if (len(holder%message) == 0 .and. size(cases) /= 1) holder%message = &
         'the text contains '//whole(size(cases))//' cases; must contain one'
   end subroutine take_one

   !> A case without the leading `#` of its lines, and without text that is not part of the
   !! namelist.
   pure subroutine bare_text(lines, text)
      !> The case, as from `echo`.
      type(line_type), intent(in) :: lines(:)
      !> A namelist, with a line feed after each line.
      character(:), allocatable, intent(out) :: text
      type(buffer_type) :: buffer
      integer :: i

      do i = 1, size(lines)
         if (index(lines(i)%text, '# !') == 1) cycle
         call add(buffer, lines(i)%text(3:)//new_line('a'))
      end do
      text = ''
      if (buffer%n > 0) text = buffer%text(:buffer%n)
   end subroutine bare_text

   !> A result without tables, to be filled with values computed earlier, such as those of a file.
   subroutine new_result(text, handle, status)
      !> The namelist of its case.
      character(*), intent(in) :: text
      !> The result, to be freed with `free_result`; it exists whatever the status.
      integer(c_int64_t), intent(out) :: handle
      !> `done` or `wrong`.
      integer, intent(out) :: status
      type(holder_type), pointer :: holder
      type(case_type), allocatable :: cases(:)
      type(column_type), allocatable :: columns(:)
      type(line_type), allocatable :: lines(:)
      type(study_type) :: study

      call new_holder(text, holder, cases)
      handle = address_of(c_loc(holder))
      call take_one(holder, cases)
      status = merge(wrong, done, len(holder%message) > 0)
      if (status == wrong) return
      holder%status = status
      call echo(cases(1), lines)
      call find_study(cases(1)%study_name, study)
      call study%columns_of(cases(1)%model, columns)
      call start_result(lines, columns, study%row(cases(1)%model), holder%result, &
         outputs_of(cases(1)), shown_of(cases(1)))
   end subroutine new_result

   !> A holder of a text without a result; `describe_result` returns the text as the message.
   subroutine new_text(text, handle)
      !> The text.
      character(*), intent(in) :: text
      !> The result, to be freed with `free_result`.
      integer(c_int64_t), intent(out) :: handle
      type(holder_type), pointer :: holder

      allocate (holder)
      holder%mark = mark
      holder%message = text
      holder%status = done
      handle = address_of(c_loc(holder))
   end subroutine new_text

   !> A result without a case, since no namelist produces it; it has no tables and is to be filled.
   subroutine new_bare_result(name, model, handle)
      !> Name of the study that declares its columns.
      character(*), intent(in) :: name
      !> The model of its system, as in vi_key.
      integer, intent(in) :: model
      !> The result, to be freed with `free_result`.
      integer(c_int64_t), intent(out) :: handle
      type(holder_type), pointer :: holder
      type(study_type) :: study
      type(column_type), allocatable :: columns(:)
      character(:), allocatable :: first

      allocate (holder)
      holder%mark = mark
      holder%message = ''
      holder%status = done
      handle = address_of(c_loc(holder))
      call find_study(name, study)
      call study%columns_of(model, columns)
      first = first_line
      if (model == of_structure) first = first_line_of_structure
      if (name == 'identify') first = first_line_in_si
      call start_result([line_type(first//'no namelist describes how it began')], columns, &
         study%row(model), holder%result)
   end subroutine new_bare_result

   !> Opens a table of a result.
   subroutine open_table(handle, name, dims, sizes, parent, owners)
      !> Handle from `new_result`.
      integer(c_int64_t), intent(in) :: handle
      !> Name of the table, and its dimensions separated by blanks, the one that varies fastest
      !! first.
      character(*), intent(in) :: name, dims
      !> Sizes of the dimensions.
      integer, intent(in) :: sizes(:)
      !> The parent table; empty if there is none.
      character(*), intent(in) :: parent
      !> The row of the parent to which each row belongs.
      integer, intent(in) :: owners(:)
      type(result_type), pointer :: result

      result => result_of(handle)
      if (.not. associated(result)) return
      if (len(parent) > 0) then
         call result%open(name, dims, sizes, parent, owners)
      else
         call result%open(name, dims, sizes)
      end if
   end subroutine open_table

   !> Fills a column of numbers; one that is not declared is ignored.
   subroutine fill_reals(handle, table, name, values)
      !> Handle from `new_result`.
      integer(c_int64_t), intent(in) :: handle
      !> Names of the table and of the column.
      character(*), intent(in) :: table, name
      !> Row by row; for complex numbers the real and the imaginary part in turn.
      real(wp), intent(in) :: values(:)
      type(result_type), pointer :: result
      integer :: i

      result => result_of(handle)
      if (.not. associated(result)) return
      i = result%place(table, name)
      if (i == 0) return
      if (result%columns(i)%column%kind == complexes) then
         call result%put(table, name, cmplx(values(1::2), values(2::2), wp))
      else
         call result%put(table, name, values)
      end if
   end subroutine fill_reals

   !> Fills a column of any other kind; one that is not declared is ignored.
   subroutine fill_wholes(handle, table, name, values, words)
      !> Handle from `new_result`.
      integer(c_int64_t), intent(in) :: handle
      !> Names of the table and of the column.
      character(*), intent(in) :: table, name
      !> Row by row; for words their places.
      integer, intent(in) :: values(:)
      !> Words separated by line feeds, if the column has any; a single one may be empty.
      character(*), intent(in), optional :: words
      type(result_type), pointer :: result

      result => result_of(handle)
      if (.not. associated(result)) return
      if (result%place(table, name) == 0) return
      if (present(words)) then
         call result%put_codes(table, name, values, split(words, new_line('a')))
      else
         call result%put(table, name, values)
      end if
   end subroutine fill_wholes

   !> Sets the remarks of a result that is filled by a caller, and how far it got.
   subroutine add_notes_of(handle, cut, remarks)
      !> Handle from `new_result`.
      integer(c_int64_t), intent(in) :: handle
      !> How far the study got, if it was stopped before its end; otherwise empty.
      character(*), intent(in) :: cut
      !> Lines, each ended by a line feed.
      character(*), intent(in) :: remarks
      type(result_type), pointer :: result
      type(line_type), allocatable :: lines(:)
      integer :: i

      result => result_of(handle)
      if (.not. associated(result)) return
      result%cut = cut
      lines = split(remarks, new_line('a'))
      do i = 1, size(lines) - 1
         call result%remark(lines(i)%text)
      end do
   end subroutine add_notes_of

   !> The case of a result with the name of the file to which it will be written. The result itself
   !! is not changed, since several threads may write it.
   pure subroutine name_after(result, path, case)
      !> The result.
      type(result_type), intent(in) :: result
      !> Path of the file.
      character(*), intent(in) :: path
      !> The echo of the case.
      type(line_type), allocatable, intent(out) :: case(:)
      character(*), parameter :: start = '#   name = '
      character(:), allocatable :: name
      integer :: i

      call find_name(path, 1, 1, name)
      allocate (case, source=result%case)
      do i = 1, size(case)
         if (index(case(i)%text, start) == 1) case(i)%text = start//''''//name//''''
      end do
   end subroutine name_after

   !> The address in a C pointer.
   pure integer(c_int64_t) function address_of(pointer) result(address)
      !> A C pointer.
      type(c_ptr), intent(in) :: pointer

      address = 0
      if (c_associated(pointer)) address = int(transfer(pointer, 0_c_intptr_t), c_int64_t)
   end function address_of

   !> The holder of a handle; null if the handle is invalid.
   function holder_of(handle) result(holder)
      !> Handle from `run_text` or `new_result`.
      integer(c_int64_t), intent(in) :: handle
      type(holder_type), pointer :: holder

      holder => null()
      if (handle == 0) return
      call c_f_pointer(transfer(int(handle, c_intptr_t), c_null_ptr), holder)
      if (holder%mark /= mark) holder => null()
   end function holder_of

   !> The result behind a handle; null if there is none.
   function result_of(handle) result(result)
      !> Handle from `run_text` or `new_result`.
      integer(c_int64_t), intent(in) :: handle
      type(result_type), pointer :: result
      type(holder_type), pointer :: holder

      result => null()
      holder => holder_of(handle)
      if (associated(holder)) result => holder%result
   end function result_of

   !> Status of a result, and the fault of its case.
   subroutine fault_of(handle, status, message, line)
      !> Handle from `run_text` or `new_result`.
      integer(c_int64_t), intent(in) :: handle
      !> `done`, `failed`, `wrong` or `no_result`.
      integer, intent(out) :: status
      !> Empty if nothing is wrong.
      character(:), allocatable, intent(out) :: message
      !> Line of the text with the fault; 0 if there is none.
      integer, intent(out) :: line
      type(holder_type), pointer :: holder

      status = no_result
      line = 0
      message = ''
      holder => holder_of(handle)
      if (.not. associated(holder)) return
      status = holder%status
      line = holder%line
      message = holder%message
   end subroutine fault_of

   !> Records a fault of the values that a caller passed to fill a result.
   subroutine set_fault(handle, message)
      !> Handle from `new_result`.
      integer(c_int64_t), intent(in) :: handle
      !> The fault.
      character(*), intent(in) :: message
      type(holder_type), pointer :: holder

      holder => holder_of(handle)
      if (associated(holder)) holder%message = message
   end subroutine set_fault

   !> Frees a result; arrays that share its memory must not be used afterwards.
   subroutine free_result(handle)
      !> Handle from `run_text` or `new_result`; any other number is ignored.
      integer(c_int64_t), intent(in) :: handle
      type(holder_type), pointer :: holder

      holder => holder_of(handle)
      if (.not. associated(holder)) return
      holder%mark = 0
      deallocate (holder)
   end subroutine free_result

   !> The contents of a result as JSON: message, case, remarks, notes, tables, and columns with the
   !! addresses of their values.
   subroutine describe_result(handle, text)
      !> Handle from `run_text` or `new_result`.
      integer(c_int64_t), intent(in) :: handle
      !> An object; empty if there is no result.
      character(:), allocatable, intent(out) :: text
      type(holder_type), pointer :: holder
      type(buffer_type) :: buffer
      integer :: i

      text = ''
      holder => holder_of(handle)
      if (.not. associated(holder)) return
      call add(buffer, '{"message": ')
      call add_quoted(buffer, holder%message)
      if (allocated(holder%result%tables)) then
         associate (result => holder%result)
            call add(buffer, ', "cut": ')
            call add_quoted(buffer, result%cut)
            call add(buffer, ', "empty": '//trim(merge('true ', 'false', result%empty))// &
               ', "row": ')
            call add_quoted(buffer, trim(result%row))
            call add_lines(buffer, 'case', result%case)
            call add_lines(buffer, 'remarks', result%remarks)
            call add(buffer, ', "notes": [')
            do i = 1, size(result%notes)
               call add(buffer, trim(merge(', [', '[  ', i > 1))//trim(merge('true ', 'false', &
                  result%notes(i)%fault))//', ')
               call add_quoted(buffer, result%notes(i)%text)
               call add(buffer, ']')
            end do
            call add(buffer, '], "tables": [')
            do i = 1, size(result%tables)
               if (i > 1) call add(buffer, ', ')
               call add_table(buffer, result%tables, i)
            end do
            call add(buffer, '], "columns": [')
            do i = 1, size(result%columns)
               if (i > 1) call add(buffer, ', ')
               call add_column(buffer, result%columns(i))
            end do
         end associate
         call add(buffer, ']')
      end if
      call add(buffer, '}')
      text = buffer%text(:buffer%n)
   end subroutine describe_result

   !> Adds lines as a list of strings.
   pure subroutine add_lines(buffer, name, lines)
      !> The text so far.
      type(buffer_type), intent(inout) :: buffer
      !> Name of the list.
      character(*), intent(in) :: name
      !> The items of the list.
      type(line_type), intent(in) :: lines(:)
      integer :: i

      call add(buffer, ', "'//name//'": [')
      do i = 1, size(lines)
         if (i > 1) call add(buffer, ', ')
         call add_quoted(buffer, lines(i)%text)
      end do
      call add(buffer, ']')
   end subroutine add_lines

   !> Adds a table as an object.
   subroutine add_table(buffer, tables, place)
      !> The text so far.
      type(buffer_type), intent(inout) :: buffer
      !> All tables of the result.
      type(table_type), intent(in), target :: tables(:)
      !> Place of the table.
      integer, intent(in) :: place
      integer :: i

      associate (table => tables(place))
         call add(buffer, '{"name": "'//trim(table%name)//'", "dims": [')
         do i = 1, table%n_dims
            if (i > 1) call add(buffer, ', ')
            call add(buffer, '["'//trim(table%dims(i))//'", '//whole(table%sizes(i))//']')
         end do
         call add(buffer, '], "parent": "')
         if (table%parent > 0) call add(buffer, trim(tables(table%parent)%name))
         call add(buffer, '", "owners": ')
      end associate
      if (allocated(tables(place)%owners)) then
         call add_address(buffer, c_loc(tables(place)%owners))
      else
         call add(buffer, '0')
      end if
      call add(buffer, '}')
   end subroutine add_table

   !> Adds a column as an object with the items that its declaration does not contain.
   subroutine add_column(buffer, filled)
      !> The text so far.
      type(buffer_type), intent(inout) :: buffer
      !> The column.
      type(filled_type), intent(in), target :: filled

      associate (column => filled%column)
         call add(buffer, '{"table": "'//trim(column%table)//'", "name": "'//trim(column%name)// &
            '", "inner": '//whole(filled%inner))
      end associate
      call add_lines(buffer, 'words', filled%words)
      call add(buffer, ', "address": ')
      if (allocated(filled%x)) then
         call add_address(buffer, c_loc(filled%x))
      else if (allocated(filled%k)) then
         call add_address(buffer, c_loc(filled%k))
      else
         call add(buffer, 'null')                     ! not filled
      end if
      call add(buffer, '}')
   end subroutine add_column

   !> Adds an address as a whole number.
   pure subroutine add_address(buffer, pointer)
      !> The text so far.
      type(buffer_type), intent(inout) :: buffer
      !> Its address; null for an array without values.
      type(c_ptr), intent(in) :: pointer
      character(20) :: digits

      write (digits, '(i0)') address_of(pointer)
      call add(buffer, trim(digits))
   end subroutine add_address

end module vi_door
