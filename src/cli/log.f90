!> What is said while files run, and the results on their way to the disk.
module vi_log
   use vi_files, only: writable, write_file
   use vi_text, only: append, line_type, printable
   implicit none (type, external)
   private

   public :: say, write_table

   !> Exit statuses: all done; ran, but something failed or is not there; the input is wrong.
   integer, parameter, public :: done = 0, failed = 1, wrong = 2

   !> What is said while files run: a line for each case, and the names taken so far.
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
   subroutine say(log, status, text)
      type(log_type), intent(inout) :: log
      integer, intent(in) :: status
      character(*), intent(in) :: text

      call append(log%lines, merge('-', '!', status == done)//printable(text))
      log%status = max(log%status, status)
   end subroutine say

   !> Writes a table (CSV), whole or not at all.
   subroutine write_table(path, lines, log, written)
      character(*), intent(in) :: path
      type(line_type), intent(in) :: lines(:)
      type(log_type), intent(inout) :: log
      logical, intent(out) :: written
      character(:), allocatable :: message

      call write_file(path, lines, message)
      written = len(message) == 0
      if (written) then
         call append(log%results, path)
      else
         call say(log, wrong, path//': '//message//writable)
      end if
   end subroutine write_table

end module vi_log
