!> The cases of a namelist file, checked.
module vi_read_cases
   use vi_case, only: case_type
   use vi_parse_cases, only: parse_cases
   use vi_read_file, only: read_text
   use vi_text, only: brief
   implicit none (type, external)
   private

   public :: read_cases

contains

   !> All cases of a namelist file; `message` names file, line, key and remedy of the first fault.
   subroutine read_cases(path, cases, message)
      !> The file.
      character(*), intent(in) :: path
      !> Its cases, in order.
      type(case_type), allocatable, intent(out) :: cases(:)
      !> Empty if there is no fault.
      character(:), allocatable, intent(out) :: message
      character(:), allocatable :: text

      call read_text(path, text, message)
      if (len(message) == 0) then
         call parse_cases(text, path, cases, message)
      else
         message = path//': '//brief('cannot be read: '//message)
      end if
      if (.not. allocated(cases)) allocate (cases(0))
   end subroutine read_cases

end module vi_read_cases
