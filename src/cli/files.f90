!> Files that are there whole or not at all: written under a temporary name, then renamed.
module vi_files
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
   use vi_text, only: line_type
   implicit none (type, external)
   private

   public :: make_folder, write_file

   interface
      integer(c_int) function c_rename(from, to) bind(c, name='rename')
         import :: c_char, c_int
         implicit none (type, external)
         character(kind=c_char), intent(in) :: from(*), to(*)
      end function c_rename
      integer(c_int) function c_mkdir(path, mode) bind(c, name='mkdir')
         import :: c_char, c_int
         implicit none (type, external)
         character(kind=c_char), intent(in) :: path(*)
         integer(c_int), value :: mode
      end function c_mkdir
      integer(c_int) function c_remove(path) bind(c, name='remove')
         import :: c_char, c_int
         implicit none (type, external)
         character(kind=c_char), intent(in) :: path(*)
      end function c_remove
   end interface

contains

   !> Makes a folder if it is not there, its parents included.
   subroutine make_folder(path)
      character(*), intent(in) :: path
      integer(c_int) :: ignored
      integer :: i

      ! whether it worked shows when a file is written there
      do i = 2, len_trim(path)
         if (path(i:i) == '/') ignored = c_mkdir(path(:i - 1)//c_null_char, int(o'777', c_int))
      end do
      ignored = c_mkdir(trim(path)//c_null_char, int(o'777', c_int))
   end subroutine make_folder

   !> Writes lines to a file; `message` is empty if that went well, and the old file is kept if not.
   subroutine write_file(path, lines, message)
      character(*), intent(in) :: path
      type(line_type), intent(in) :: lines(:)
      character(:), allocatable, intent(out) :: message
      character(:), allocatable :: temporary
      character(200) :: reason
      integer :: unit, status, i, ignored

      message = ''
      temporary = path//'.part'
      open (newunit=unit, file=temporary, status='replace', action='write', iostat=status, &
         iomsg=reason)
      if (status /= 0) then
         message = trim(adjustl(reason(index(reason, ': ', back=.true.) + 1:)))   ! without the path
         return
      end if
      do i = 1, size(lines)
         write (unit, '(a)', iostat=status, iomsg=reason) lines(i)%text
         if (status /= 0) exit
      end do
      if (status == 0) flush (unit, iostat=status, iomsg=reason)        ! a full disk shows here
      close (unit, iostat=i)
      if (status == 0 .and. i /= 0) then
         status = i
         reason = 'the file could not be closed'
      end if
      if (status == 0) then
         if (c_rename(temporary//c_null_char, path//c_null_char) == 0) return
         reason = 'the file could not be renamed from '//temporary
      end if
      message = trim(reason)
      ignored = c_remove(temporary//c_null_char)
   end subroutine write_file

end module vi_files
