!> Files that are written completely or not at all: under a temporary name first, then renamed.
module vi_files
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_int, c_int64_t, &
      c_new_line, c_null_char, c_null_ptr, c_ptr, c_size_t
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_text, only: last_part, line_type
   implicit none (type, external)
   private

   public :: add_text, close_file, give_up, is_folder, make_folder, open_file, print_line, &
      same_file, write_file

   interface
      integer(c_int) function c_rename(from, to) bind(c, name='rename')
         import :: c_char, c_int
         implicit none (type, external)
         !> Paths, each ended by a null character.
         character(kind=c_char), intent(in) :: from(*), to(*)
      end function c_rename
      integer(c_int) function c_mkdir(path, mode) bind(c, name='mkdir')
         import :: c_char, c_int
         implicit none (type, external)
         !> Path, ended by a null character.
         character(kind=c_char), intent(in) :: path(*)
         integer(c_int), value :: mode
      end function c_mkdir
      integer(c_int) function c_remove(path) bind(c, name='remove')
         import :: c_char, c_int
         implicit none (type, external)
         !> Path, ended by a null character.
         character(kind=c_char), intent(in) :: path(*)
      end function c_remove
      ! POSIX since 2024, and in the C libraries of Linux, macOS and the BSDs before
      integer(c_int) function c_getentropy(number, length) bind(c, name='getentropy')
         import :: c_int, c_int64_t, c_size_t
         implicit none (type, external)
         !> Random bytes.
         integer(c_int64_t), intent(out) :: number
         !> Their number.
         integer(c_size_t), value :: length
      end function c_getentropy
      type(c_ptr) function c_realpath(path, buffer) bind(c, name='realpath')
         import :: c_char, c_ptr
         implicit none (type, external)
         !> Path, ended by a null character.
         character(kind=c_char), intent(in) :: path(*)
         type(c_ptr), value :: buffer
      end function c_realpath
      integer(c_size_t) function c_strlen(text) bind(c, name='strlen')
         import :: c_ptr, c_size_t
         implicit none (type, external)
         type(c_ptr), value :: text
      end function c_strlen
      ! its result is a signed integer of the size of c_size_t
      integer(c_size_t) function c_write(channel, text, length) bind(c, name='write')
         import :: c_char, c_int, c_size_t
         implicit none (type, external)
         integer(c_int), value :: channel
         !> At least `length` bytes.
         character(kind=c_char), intent(in) :: text(*)
         integer(c_size_t), value :: length
      end function c_write
      subroutine c_perror(text) bind(c, name='perror')
         import :: c_char
         implicit none (type, external)
         !> Beginning of the message, ended by a null character.
         character(kind=c_char), intent(in) :: text(*)
      end subroutine c_perror
      subroutine c_free(address) bind(c, name='free')
         import :: c_ptr
         implicit none (type, external)
         type(c_ptr), value :: address
      end subroutine c_free
   end interface

   !> A file that is being written.
   type, public :: new_file_type
      private
      character(:), allocatable :: path, temporary
      !> The first error; empty if there is none.
      character(:), allocatable :: message
      integer :: unit = 0
      integer(int64) :: length = 0
      logical :: opened = .false.
   end type new_file_type

   !> The requirement on the folder of results, as the end of a message.
   character(*), parameter, public :: writable = &
      '; the folder and the disk must be writable'

contains

   !> Makes a folder and its parents, if they do not exist, and checks that files can be written to
   !! it.
   subroutine make_folder(path, message)
      !> The folder.
      character(*), intent(in) :: path
      !> Empty if files can be written to it; otherwise the reason and the requirement.
      character(:), allocatable, intent(out) :: message
      character(:), allocatable :: temporary
      integer(c_int) :: ignored
      integer :: unit, i
      logical :: taken

      message = ''
      do i = 2, len(path)
         if (path(i:i) == '/') ignored = c_mkdir(path(:i - 1)//c_null_char, int(o'777', c_int))
      end do
      ignored = c_mkdir(path//c_null_char, int(o'777', c_int))
      if (is_folder(path)) then
         call open_temporary(path//'/', unit, temporary, message)
         if (len(message) > 0) then
            message = message//writable
         else
            close (unit, status='delete')
         end if
         return
      end if
      message = 'cannot be created'//writable
      do i = 2, len(path) + 1
         if (i <= len(path)) then
            if (path(i:i) /= '/') cycle
         end if
         inquire (file=path(:i - 1), exist=taken)
         if (taken) taken = .not. is_folder(path(:i - 1))
         if (taken) message = path(:i - 1)//' is a file; must be a folder'
      end do
   end subroutine make_folder

   !> Whether a folder exists.
   logical function is_folder(path)
      !> The folder.
      character(*), intent(in) :: path

      inquire (file=path//'/.', exist=is_folder)
   end function is_folder

   !> Writes a line to standard output by the C library; the Fortran runtime does not report a full
   !! disk.
   subroutine print_line(text, printed)
      !> The line.
      character(*), intent(in) :: text
      !> Whether it was written; if not, the reason has been printed.
      logical, intent(out) :: printed
      character(:), allocatable :: left
      integer(c_size_t) :: n

      left = text//c_new_line
      printed = .true.
      do while (len(left) > 0)
         n = c_write(1_c_int, left, len(left, c_size_t))
         printed = n > 0
         if (.not. printed) exit
         left = left(n + 1:)
      end do
      if (.not. printed) call c_perror('standard output'//c_null_char)
   end subroutine print_line

   !> Writes lines to a file; if that fails, the old file is kept.
   subroutine write_file(path, lines, message)
      !> The file.
      character(*), intent(in) :: path
      !> Its lines.
      type(line_type), intent(in) :: lines(:)
      !> Empty if it was written; otherwise the reason.
      character(:), allocatable, intent(out) :: message
      type(new_file_type) :: file
      integer :: i

      call open_file(path, file)
      do i = 1, size(lines)
         call add_text(file, lines(i)%text//new_line('a'))
      end do
      call close_file(file, message)
   end subroutine write_file

   !> Opens a new file under a temporary name.
   subroutine open_file(path, file)
      !> The final name of the file.
      character(*), intent(in) :: path
      !> The file; errors are reported when it is closed.
      type(new_file_type), intent(out) :: file

      file%path = path
      file%message = ''
      call open_temporary(path, file%unit, file%temporary, file%message)
      file%opened = len(file%message) == 0
   end subroutine open_file

   !> Adds a text to a file.
   subroutine add_text(file, text)
      !> The file.
      type(new_file_type), intent(inout) :: file
      !> The text, including its line feeds.
      character(*), intent(in) :: text
      character(300) :: reason
      integer :: status

      if (len(file%message) > 0) return
      write (file%unit, iostat=status, iomsg=reason) text
      file%length = file%length + len(text)
      if (status /= 0) file%message = last_part(reason)
   end subroutine add_text

   !> Stops writing a file, which is then removed when it is closed.
   subroutine give_up(file, reason)
      !> The file.
      type(new_file_type), intent(inout) :: file
      !> Why it is not completed.
      character(*), intent(in) :: reason

      if (len(file%message) == 0) file%message = reason
   end subroutine give_up

   !> Closes a file and gives it its name; if that fails, the old file is kept.
   subroutine close_file(file, message)
      !> The file.
      type(new_file_type), intent(inout) :: file
      !> Empty if it was written; otherwise the reason.
      character(:), allocatable, intent(out) :: message
      character(300) :: reason
      integer(int64) :: written
      integer(c_int) :: ignored
      integer :: status

      message = file%message
      if (.not. file%opened) return
      close (file%unit, iostat=status, iomsg=reason)
      ! the runtime does not report every failed write: a full disk shows in the size
      inquire (file=file%temporary, size=written)
      if (len(message) > 0) then
         continue
      else if (status /= 0) then
         message = last_part(reason)
      else if (written /= file%length) then
         message = 'the disk is full, or the file could not be written completely'
      else if (c_rename(file%temporary//c_null_char, file%path//c_null_char) /= 0) then
         message = 'the temporary file could not be renamed'
      else
         return
      end if
      ignored = c_remove(file%temporary//c_null_char)
   end subroutine close_file

   !> Opens a new file next to another one, under a random name that nobody can foresee. A file that
   !! has this name all the same is kept, and another name is tried.
   subroutine open_temporary(path, unit, temporary, message)
      !> The other file.
      character(*), intent(in) :: path
      !> Unit of the new file.
      integer, intent(out) :: unit
      !> Its name.
      character(:), allocatable, intent(out) :: temporary
      !> Out: the reason, if it could not be opened; otherwise not changed.
      character(:), allocatable, intent(inout) :: message
      character(len(path) + 300) :: reason
      character(16) :: digits
      integer(c_int64_t) :: number
      integer :: status, i
      logical :: taken

      reason = 'no name for a temporary file was found'
      do i = 1, 1000
         if (c_getentropy(number, 8_c_size_t) /= 0) exit
         write (digits, '(z16.16)') number
         temporary = path//'.'//digits//'.part'
         open (newunit=unit, file=temporary, status='new', action='write', access='stream', &
            form='unformatted', iostat=status, iomsg=reason)
         if (status == 0) return
         inquire (file=temporary, exist=taken)
         if (.not. taken) exit
      end do
      message = last_part(reason)
   end subroutine open_temporary

   !> Whether two paths denote the same existing file.
   logical function same_file(one, other)
      !> The paths.
      character(*), intent(in) :: one, other
      character(:), allocatable :: a, b

      call resolve(one, a)
      call resolve(other, b)
      same_file = len(a) > 0 .and. len(a) == len(b)
      if (same_file) same_file = a == b
   end function same_file

   !> The absolute path without links; empty if there is no such file.
   subroutine resolve(path, absolute)
      !> The path.
      character(*), intent(in) :: path
      !> The absolute path.
      character(:), allocatable, intent(out) :: absolute
      character(kind=c_char), pointer :: text(:)
      type(c_ptr) :: address
      integer :: i, n

      absolute = ''
      address = c_realpath(path//c_null_char, c_null_ptr)
      if (.not. c_associated(address)) return
      n = int(c_strlen(address))
      call c_f_pointer(address, text, [n])
      absolute = repeat(' ', n)
      do i = 1, n
         absolute(i:i) = text(i)
      end do
      call c_free(address)
   end subroutine resolve

end module vi_files
