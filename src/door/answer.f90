!> Texts of a result.
module vi_answer
   use, intrinsic :: iso_c_binding, only: c_int64_t
   use vi_buffer, only: add, buffer_type
   use vi_csv, only: csv_header, csv_rows, has_rows, row_count
   use vi_door, only: bare_text, describe_result, fault_of, result_of
   use vi_result, only: result_type
   use vi_text, only: line_type
   implicit none (type, external)
   private

   public :: answer, answer_word

   !> Kinds of texts: the fault of the case; the complete case as a namelist; lines on what was
   !! found; lines on what failed or does not exist; remarks for the header of files; how far the
   !! study got if it was stopped; the CSV; the result without its values as JSON.
   integer, parameter, public :: answer_message = 0, answer_case = 1, tell_notes = 2, &
      answer_faults = 3, answer_remarks = 4, answer_cut = 5, answer_csv = 6, answer_json = 7

contains

   !> A text; empty if there is none.
   subroutine answer(handle, what, text)
      !> Handle of a result, from vi_door.
      integer(c_int64_t), intent(in) :: handle
      !> One of the above.
      integer, intent(in) :: what
      !> The text; each of several lines ends with a line feed.
      character(:), allocatable, intent(out) :: text
      type(result_type), pointer :: result
      type(buffer_type) :: buffer
      integer :: i, line, status

      text = ''
      if (what == answer_message) call fault_of(handle, status, text, line)
      if (what == answer_json) call describe_result(handle, text)
      result => result_of(handle)
      if (.not. associated(result)) return
      if (.not. allocated(result%tables)) return        ! the case is wrong
      select case (what)
      case (answer_case)
         call bare_text(result%case, text)
      case (tell_notes, answer_faults)
         do i = 1, size(result%notes)
            if (result%notes(i)%fault .neqv. what == answer_faults) cycle
            call add(buffer, result%notes(i)%text//new_line('a'))
         end do
      case (answer_remarks)
         do i = 1, size(result%remarks)
            call add(buffer, result%remarks(i)%text//new_line('a'))
         end do
      case (answer_cut)
         text = result%cut
      case (answer_csv)
         if (.not. result%empty) call answer_rows(result, text)
      case default
         continue
      end select
      if (buffer%n > 0) text = buffer%text(:buffer%n)
   end subroutine answer

   !> The CSV as one text; empty if a column has no values.
   subroutine answer_rows(result, text)
      !> The result.
      type(result_type), intent(in) :: result
      !> Header and rows.
      character(:), allocatable, intent(inout) :: text
      type(buffer_type) :: buffer
      type(line_type), allocatable :: head(:)
      character(:), allocatable :: rows
      integer :: i

      if (.not. has_rows(result)) return
      call csv_header(result, result%case, head)
      do i = 1, size(head)
         call add(buffer, head(i)%text//new_line('a'))
      end do
      call csv_rows(result, 1, row_count(result), rows)
      call add(buffer, rows)
      text = buffer%text(:buffer%n)
   end subroutine answer_rows

   !> A word of a column of words; empty if there is none.
   subroutine answer_word(handle, column, code, text)
      !> Handle of a result, from vi_door.
      integer(c_int64_t), intent(in) :: handle
      !> Place of the column, from 1.
      integer, intent(in) :: column
      !> Place of the word, from 1.
      integer, intent(in) :: code
      !> The word.
      character(:), allocatable, intent(out) :: text
      type(result_type), pointer :: result

      text = ''
      result => result_of(handle)
      if (.not. associated(result)) return
      if (.not. allocated(result%columns)) return
      if (column < 1 .or. column > size(result%columns) .or. code < 1) return
      if (code <= size(result%columns(column)%words)) text = &
         result%columns(column)%words(code)%text
   end subroutine answer_word

end module vi_answer
