!> Reads files, also one file in several threads.
!!
!! Fortran connects a file to one unit at a time, so that a second thread could not open it; the
!! streams of the C library are independent.
module vi_read_file
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_null_char, c_ptr, c_size_t
   use vi_lines, only: unify_line_ends
   implicit none (type, external)
   private

   public :: is_result, read_bytes, read_text

   interface
      type(c_ptr) function c_fopen(path, mode) bind(c, name='fopen')
         import :: c_char, c_ptr
         implicit none (type, external)
         !> The file and 'r', each ended by a null character.
         character(kind=c_char), intent(in) :: path(*), mode(*)
      end function c_fopen
      integer(c_size_t) function c_fread(bytes, width, number, stream) bind(c, name='fread')
         import :: c_char, c_ptr, c_size_t
         implicit none (type, external)
         integer(c_size_t), value :: width, number
         !> The bytes read; the rest is undefined.
         character(kind=c_char), intent(out) :: bytes(width*number)
         type(c_ptr), value :: stream
      end function c_fread
      integer(c_int) function c_ferror(stream) bind(c, name='ferror')
         import :: c_int, c_ptr
         implicit none (type, external)
         type(c_ptr), value :: stream
      end function c_ferror
      integer(c_int) function c_fclose(stream) bind(c, name='fclose')
         import :: c_int, c_ptr
         implicit none (type, external)
         type(c_ptr), value :: stream
      end function c_fclose
      subroutine last_error(text, capacity) bind(c, name='vibroimpact_last_error')
         import :: c_char, c_size_t
         implicit none (type, external)
         integer(c_size_t), value :: capacity
         !> The message of the last error, ended by a null character.
         character(kind=c_char), intent(out) :: text(capacity)
      end subroutine last_error
   end interface

   !> Largest number of bytes of a namelist file.
   integer, parameter :: largest = 64*1024*1024

contains

   !> The content of a text file or pipe.
   subroutine read_text(path, text, message)
      !> The file.
      character(*), intent(in) :: path
      !> Its lines, separated by line feeds.
      character(:), allocatable, intent(out) :: text
      !> Why it cannot be read; empty if it can.
      character(:), allocatable, intent(out) :: message
      character(:), allocatable :: content

      call read_bytes(path, content, message)
      call unify_line_ends(content, text)
   end subroutine read_text

   !> Whether a file is a result of this program, which starts with #.
   logical function is_result(path)
      !> The file.
      character(*), intent(in) :: path
      character(:), allocatable :: text, message

      call read_text(path, text, message)
      is_result = index(text, '#') == 1
   end function is_result

   !> The content of a file or pipe.
   subroutine read_bytes(path, content, message)
      !> The file.
      character(*), intent(in) :: path
      !> Its bytes.
      character(:), allocatable, intent(out) :: content
      !> Why it cannot be read; empty if it can.
      character(:), allocatable, intent(out) :: message
      character(65536) :: part
      character(:), allocatable :: longer
      type(c_ptr) :: stream
      integer(c_int) :: ignored
      integer :: n, length
      logical :: folder

      message = ''
      content = ''
      inquire (file=path//'/.', exist=folder)
      if (folder) then
         message = 'Is a directory'
         return
      end if
      stream = c_fopen(path//c_null_char, 'r'//c_null_char)
      if (.not. c_associated(stream)) then
         call explain(message)
         return
      end if
      length = 0
      do
         n = int(c_fread(part, 1_c_size_t, len(part, c_size_t), stream))
         if (c_ferror(stream) /= 0) call explain(message)
         if (length + n > len(content)) then
            allocate (character(2*(length + n)) :: longer)
            longer(:length) = content(:length)
            call move_alloc(longer, content)
         end if
         content(length + 1:length + n) = part(:n)
         length = length + n
         if (length > largest) message = 'is larger than 64 MB'
         if (n < len(part) .or. len(message) > 0) exit
      end do
      ignored = c_fclose(stream)
      content = content(:length)
   end subroutine read_bytes

   !> Why the last call of the C library failed.
   subroutine explain(message)
      !> Message of the operating system.
      character(:), allocatable, intent(out) :: message
      character(200) :: text

      call last_error(text, len(text, c_size_t))
      message = text(:index(text, c_null_char) - 1)
   end subroutine explain

end module vi_read_file
