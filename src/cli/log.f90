!> Messages and names of results while files run.
module vi_log
   use vi_buffer, only: add, buffer_type
   use vi_dictionary, only: dictionary_type
   use vi_text, only: line_type, printable
   implicit none (type, external)
   private

   public :: add_message, add_result

   !> Exit statuses: all done; ran, but something failed or does not exist; the input is wrong.
   integer, parameter, public :: done = 0, failed = 1, wrong = 2

   !> The messages while files run, and the names taken so far.
   type, public :: log_type
      !> Lines, each ended by a null character. The first character of a line gives its kind: '-'
      !! information, '!' a fault, '>' the path of a table (CSV) that was written.
      type(buffer_type) :: said
      !> File names of results, in lower case, with the place of the case that uses each.
      type(dictionary_type) :: names
      type(line_type), allocatable :: places(:)
      !> The worst status so far: `done`, `failed` or `wrong`.
      integer :: status = done
   end type log_type

contains

   !> Adds a line to the log and remembers the worst status.
   subroutine add_message(log, status, text)
      !> In and out: the log.
      type(log_type), intent(inout) :: log
      !> `done`, `failed` or `wrong`.
      integer, intent(in) :: status
      !> The message; control characters are replaced.
      character(*), intent(in) :: text

      call add(log%said, merge('-', '!', status == done)//printable(text)//achar(0))
      log%status = max(log%status, status)
   end subroutine add_message

   !> Adds a table that was written to the log.
   pure subroutine add_result(log, path)
      !> In and out: the log.
      type(log_type), intent(inout) :: log
      !> Path of the table.
      character(*), intent(in) :: path

      call add(log%said, '>'//path//achar(0))
   end subroutine add_result

end module vi_log
