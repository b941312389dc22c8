!> A result as a CSV file, which is written completely or not at all.
module vi_write_csv
   use vi_csv, only: csv_header, csv_rows, row_count
   use vi_files, only: add_text, close_file, new_file_type, open_file
   use vi_result, only: result_type
   use vi_text, only: line_type
   implicit none (type, external)
   private

   public :: write_csv

   !> Rows that are formatted at a time.
   integer, parameter :: block = 4096

contains

   !> Writes a result as CSV.
   subroutine write_csv(result, path, message)
      !> The result.
      type(result_type), intent(in) :: result
      !> The file.
      character(*), intent(in) :: path
      !> Empty if it was written; otherwise the reason.
      character(:), allocatable, intent(out) :: message
      type(new_file_type) :: file
      type(line_type), allocatable :: head(:)
      character(:), allocatable :: text
      integer :: i, rows

      call open_file(path, file)
      call csv_header(result, head)
      do i = 1, size(head)
         call add_text(file, head(i)%text//new_line('a'))
      end do
      rows = row_count(result)
      do i = 1, rows, block
         call csv_rows(result, i, min(rows, i + block - 1), text)
         call add_text(file, text)
      end do
      call close_file(file, message)
   end subroutine write_csv

end module vi_write_csv
