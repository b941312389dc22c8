!> A text to which parts are appended without copying it each time.
module vi_buffer
   implicit none (type, external)
   private

   public :: add, add_quoted

   type, public :: buffer_type
      !> The text, followed by unused space.
      character(:), allocatable :: text
      !> Number of characters of the text.
      integer :: n = 0
   end type buffer_type

contains

   !> Adds to a text.
   pure subroutine add(buffer, text)
      !> The text so far.
      type(buffer_type), intent(inout) :: buffer
      !> The text to add.
      character(*), intent(in) :: text
      character(:), allocatable :: longer

      if (.not. allocated(buffer%text)) allocate (character(4000) :: buffer%text)
      if (buffer%n + len(text) > len(buffer%text)) then
         allocate (character(2*len(buffer%text) + len(text)) :: longer)
         longer(:buffer%n) = buffer%text(:buffer%n)
         call move_alloc(longer, buffer%text)
      end if
      buffer%text(buffer%n + 1:buffer%n + len(text)) = text
      buffer%n = buffer%n + len(text)
   end subroutine add

   !> Adds a text as a JSON string.
   pure subroutine add_quoted(buffer, text)
      !> The text so far.
      type(buffer_type), intent(inout) :: buffer
      !> Any text.
      character(*), intent(in) :: text
      character(*), parameter :: figures = '0123456789abcdef'
      integer :: code, i, first

      call add(buffer, '"')
      first = 1                               ! start of the unchanged text not yet added
      do i = 1, len(text)
         code = iachar(text(i:i))
         if (code >= 32 .and. text(i:i) /= '"' .and. text(i:i) /= '\') cycle
         call add(buffer, text(first:i - 1))
         first = i + 1
         if (code < 32) then
            call add(buffer, '\u00'//figures(code/16 + 1:code/16 + 1)// &
               figures(modulo(code, 16) + 1:modulo(code, 16) + 1))
         else
            call add(buffer, '\'//text(i:i))
         end if
      end do
      call add(buffer, text(first:))
      call add(buffer, '"')
   end subroutine add_quoted

end module vi_buffer
