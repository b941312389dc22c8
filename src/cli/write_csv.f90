!> A result as a CSV file, which is written completely or not at all.
module vi_write_csv
   use vi_csv, only: cell_count, csv_header, csv_rows, row_count
   use vi_files, only: add_text, close_file, give_up, new_file_type, open_file
   use vi_progress, only: is_stopped
   use vi_result, only: result_type
   use vi_text, only: line_type
   implicit none (type, external)
   private

   public :: write_csv

   !> Rows that are formatted at a time: at most so many, and at most so many cells in them.
   integer, parameter :: most_rows = 4096, most_cells = 100000

contains

   !> Writes a result as CSV.
   subroutine write_csv(result, path, message, progress, flag, case)
      !> The result.
      type(result_type), intent(in) :: result
      !> The file.
      character(*), intent(in) :: path
      !> Empty if it was written; otherwise the reason.
      character(:), allocatable, intent(out) :: message
      !> Progress counters, see vi_progress; without them the file is always completed.
      integer, intent(inout), optional :: progress(3)
      !> Value of the flag of the counters from which the file is given up; 1 if absent.
      integer, intent(in), optional :: flag
      !> The echo of the case, if it differs from that of the result.
      type(line_type), intent(in), optional :: case(:)
      type(new_file_type) :: file
      type(line_type), allocatable :: head(:)
      character(:), allocatable :: text
      integer :: block, i, rows

      call open_file(path, file)
      if (present(case)) then
         call csv_header(result, case, head)
      else
         call csv_header(result, result%case, head)
      end if
      do i = 1, size(head)
         call add_text(file, head(i)%text//new_line('a'))
      end do
      rows = row_count(result)
      block = max(1, min(most_rows, most_cells/max(1, cell_count(result))))
      do i = 1, rows, block
         if (is_stopped(progress, flag)) then
            call give_up(file, 'interrupted')
            exit
         end if
         call csv_rows(result, i, min(rows, i + block - 1), text)
         call add_text(file, text)
      end do
      call close_file(file, message)
   end subroutine write_csv

end module vi_write_csv
