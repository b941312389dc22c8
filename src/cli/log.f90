!> Messages and names of results while files run.
module vi_log
   use vi_text, only: append, line_type, printable
   implicit none (type, external)
   private

   public :: add_message

   !> Exit statuses: all done; ran, but something failed or does not exist; the input is wrong.
   integer, parameter, public :: done = 0, failed = 1, wrong = 2

   !> The messages while files run, and the names taken so far.
   type, public :: log_type
      !> The first character of a line is '-' for news and '!' for a fault.
      type(line_type), allocatable :: lines(:)
      !> File names of results, in lower case, with the place that took each.
      type(line_type), allocatable :: names(:), places(:)
      !> The tables (CSV) that were written.
      type(line_type), allocatable :: results(:)
      !> The worst so far: `done`, `failed` or `wrong`.
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

      call append(log%lines, merge('-', '!', status == done)//printable(text))
      log%status = max(log%status, status)
   end subroutine add_message

end module vi_log
