!> The interface of src/door, and the files of the program: cases in a text, results behind handles.

!> Runs the one case of a namelist text; see vi_door. Who gets the handle frees it, once.
subroutine run_case(n, text, threads, progress, handle, status)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_door, only: run_text
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, threads
   character(kind=c_char), intent(in) :: text(n)
   integer(c_int), intent(inout) :: progress(3)
   integer(c_int64_t), intent(out) :: handle
   integer(c_int), intent(out) :: status
   character(n) :: one_case

   one_case = transfer(text, one_case)
   call run_text(one_case, threads, handle, status, progress)
end subroutine run_case

!> Runs namelist files; `paths` are separated by null characters, and so are the lines of what was
!! said (see vi_log), which is the message of the handle. `only` names the kind of cases to run
!! (blank: all).
subroutine run_namelists(n_paths, paths, n_folder, folder, only, progress, handle, status)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_batch, only: log_type, run_file
   use vi_buffer, only: add
   use vi_door, only: new_text
   use vi_text, only: line_type, split
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n_paths, n_folder
   character(kind=c_char), intent(in) :: paths(n_paths), folder(n_folder), only(16)
   integer(c_int), intent(inout) :: progress(3)
   integer(c_int64_t), intent(out) :: handle
   integer(c_int), intent(out) :: status
   type(log_type) :: log
   type(line_type), allocatable :: files(:)
   character(n_paths) :: all_paths
   character(n_folder) :: one_folder
   character(16) :: kind
   integer :: i

   all_paths = transfer(paths, all_paths)
   one_folder = transfer(folder, one_folder)
   kind = transfer(only, kind)
   allocate (files, source=split(all_paths, achar(0)))
   do i = 1, size(files)
      call run_file(files(i)%text, one_folder, log, trim(kind), progress)
   end do
   call add(log%said, '')
   call new_text(log%said%text(:log%said%n), handle)
   status = log%status
end subroutine run_namelists

!> The cases of a namelist file, each in the form that the header of its result has, as the message
!! of the handle. If the file is wrong, `status` is 2 and the message says why.
subroutine read_namelist(n_path, path, handle, status)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_batch, only: done, wrong
   use vi_buffer, only: add, buffer_type
   use vi_case, only: case_type, echo
   use vi_door, only: new_text
   use vi_read_cases, only: read_cases
   use vi_text, only: join, line_type, printable
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n_path
   character(kind=c_char), intent(in) :: path(n_path)
   integer(c_int64_t), intent(out) :: handle
   integer(c_int), intent(out) :: status
   type(case_type), allocatable :: cases(:)
   type(line_type), allocatable :: lines(:)
   type(buffer_type) :: text
   character(n_path) :: one_path
   character(:), allocatable :: message
   integer :: i

   one_path = transfer(path, one_path)
   call read_cases(one_path, cases, message)
   status = merge(wrong, done, len(message) > 0)
   call add(text, printable(message))
   do i = 1, size(cases)
      if (status == wrong) exit
      call echo(cases(i), lines)
      call add(text, join(lines, achar(10))//achar(10))
   end do
   call new_text(text%text(:text%n), handle)
end subroutine read_namelist

!> The language of namelists and the columns of all results, as JSON.
subroutine describe_language(capacity, text, length)
   use, intrinsic :: iso_c_binding, only: c_char, c_int
   use vi_describe, only: describe_all
   use vi_text, only: join, line_type
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: capacity
   character(kind=c_char), intent(out) :: text(capacity)
   integer(c_int), intent(out) :: length
   type(line_type), allocatable :: lines(:)
   character(:), allocatable :: json
   integer :: i

   call describe_all(lines)
   json = join(lines, new_line('a'))
   length = len(json)
   text = ' '
   do i = 1, min(length, capacity)
      text(i) = json(i:i)
   end do
end subroutine describe_language

!> What a result holds, as JSON: `text` has room for `capacity` bytes, `length` tells how many are
!! wanted.
subroutine describe_result(handle, capacity, text, length)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_door, only: describe => describe_result
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int64_t), intent(in) :: handle
   integer(c_int), intent(in) :: capacity
   character(kind=c_char), intent(out) :: text(capacity)
   integer(c_int), intent(out) :: length
   character(:), allocatable :: json
   integer :: i

   call describe(handle, json)
   length = len(json)
   text = ' '
   do i = 1, min(length, capacity)
      text(i) = json(i:i)
   end do
end subroutine describe_result

!> Frees a result.
subroutine free_result(handle)
   use, intrinsic :: iso_c_binding, only: c_int64_t
   use vi_door, only: free => free_result
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int64_t), intent(in) :: handle

   call free(handle)
end subroutine free_result

!> A result without tables for the case of a namelist text, or for a study and a model
!! (1 oscillator, 2 structure) if no namelist gives the result and the text is blank; see vi_door.
subroutine new_result(n, text, study, model, handle, status)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_door, only: done, new => new_result, new_bare_result
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n
   character(kind=c_char), intent(in) :: text(n), study(24)
   integer(c_int), intent(in) :: model
   integer(c_int64_t), intent(out) :: handle
   integer(c_int), intent(out) :: status
   character(n) :: one_case
   character(24) :: name

   one_case = transfer(text, one_case)
   name = transfer(study, name)
   status = done
   if (len_trim(one_case) == 0) then
      call new_bare_result(trim(name), model, handle)
   else
      call new(one_case, handle, status)
   end if
end subroutine new_result

!> Opens a table: `names` are its own, its parent's (blank if it has none) and its dimensions'.
subroutine open_table(handle, names, n, sizes, m, owners)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_door, only: open_one => open_table
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int64_t), intent(in) :: handle
   character(kind=c_char), intent(in) :: names(96)
   integer(c_int), intent(in) :: n, sizes(n), m, owners(m)
   character(96) :: line

   line = transfer(names, line)
   call open_one(handle, trim(line(:16)), trim(line(33:)), sizes, trim(line(17:32)), owners)
end subroutine open_table

!> Fills a column of numbers: `names` are its table's and its own.
subroutine fill_reals(handle, names, n, values)
   use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_int64_t
   use vi_door, only: fill => fill_reals
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int64_t), intent(in) :: handle
   character(kind=c_char), intent(in) :: names(40)
   integer(c_int), intent(in) :: n
   real(c_double), intent(in) :: values(n)
   character(40) :: line

   line = transfer(names, line)
   call fill(handle, trim(line(:16)), trim(line(17:)), values)
end subroutine fill_reals

!> Fills a column of all else; `words` with a line feed behind each, one blank if there are none.
subroutine fill_wholes(handle, names, n, values, m, words)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_door, only: fill => fill_wholes
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int64_t), intent(in) :: handle
   character(kind=c_char), intent(in) :: names(40)
   integer(c_int), intent(in) :: n, values(n), m
   character(kind=c_char), intent(in) :: words(m)
   character(40) :: line
   character(m) :: list
   integer :: last

   line = transfer(names, line)
   list = transfer(words, list)
   ! a word may consist of blanks, or be empty; a line feed stands behind each
   last = index(list, new_line('a'), back=.true.)
   if (last > 0) then
      call fill(handle, trim(line(:16)), trim(line(17:)), values, list(:last - 1))
   else
      call fill(handle, trim(line(:16)), trim(line(17:)), values)
   end if
end subroutine fill_wholes

!> Says what there is to say of a result: a line on how it was cut short (or none), then remarks; a
!! line feed stands behind each.
subroutine add_notes_of(handle, n, text)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_door, only: add_notes => add_notes_of
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int64_t), intent(in) :: handle
   integer(c_int), intent(in) :: n
   character(kind=c_char), intent(in) :: text(n)
   character(n) :: lines
   integer :: first

   lines = transfer(text, lines)
   first = index(lines, new_line('a'))
   call add_notes(handle, lines(:first - 1), lines(first + 1:))
end subroutine add_notes_of

!> Writes a result as CSV; `message` says what went wrong, with blanks behind it.
subroutine write_result(handle, n, path, progress, message)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_door, only: name_after, result_of
   use vi_result, only: result_type
   use vi_text, only: line_type
   use vi_write_csv, only: write_csv
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int64_t), intent(in) :: handle
   integer(c_int), intent(in) :: n
   character(kind=c_char), intent(in) :: path(n)
   integer(c_int), intent(inout) :: progress(3)
   character(kind=c_char), intent(out) :: message(400)
   type(result_type), pointer :: result
   type(line_type), allocatable :: case(:)
   character(n) :: name
   character(400) :: line
   character(:), allocatable :: reason

   name = transfer(path, name)
   result => result_of(handle)
   call name_after(result, name, case)
   call write_csv(result, name, reason, progress, case=case)
   line = reason
   message = transfer(line, message)
end subroutine write_result

!> Writes the motions of a result as a printout; `message` as of `write_result`.
subroutine write_printout(handle, n, path, message)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_door, only: result_of
   use vi_files, only: write_file
   use vi_parse_cases, only: find_name
   use vi_printout, only: print_motions
   use vi_result, only: result_type
   use vi_text, only: line_type
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int64_t), intent(in) :: handle
   integer(c_int), intent(in) :: n
   character(kind=c_char), intent(in) :: path(n)
   character(kind=c_char), intent(out) :: message(400)
   type(result_type), pointer :: result
   type(line_type), allocatable :: lines(:)
   character(n) :: name
   character(400) :: line
   character(:), allocatable :: stem, reason

   name = transfer(path, name)
   result => result_of(handle)
   call find_name(name, 1, 1, stem)
   call print_motions(stem, result, lines)
   call write_file(name, lines, reason)
   line = reason
   message = transfer(line, message)
end subroutine write_printout

!> The sentence for a status code, as `length` bytes of `text`.
subroutine status_text(code, text, length)
   use, intrinsic :: iso_c_binding, only: c_char, c_int
   use vi_status, only: sentence => status_text
   implicit none (type, external)
   integer(c_int), intent(in) :: code
   character(kind=c_char), intent(out) :: text(200)
   integer(c_int), intent(out) :: length
   character(200) :: line

   line = sentence(code)
   text = transfer(line, text)
   length = len_trim(line)
end subroutine status_text
