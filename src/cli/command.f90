!> The command line of the stand-alone program.
module vi_command
   use, intrinsic :: iso_fortran_env, only: error_unit
   use vi_batch, only: done, failed, log_type, run_file, wrong
   use vi_describe, only: describe_all, describe_group, list_groups
   use vi_files, only: is_folder, print_line
   use vi_study, only: name_length, study_type
   use vi_study_list, only: list_studies
   use vi_text, only: append, line_type, lower
   use vi_version, only: version
   implicit none (type, external)
   private

   public :: run_command

   !> The help before the list of studies, and after it.
   character(89), parameter :: before(*) = [character(89) :: &
      'usage: vibroimpact-batch FILE.nml... [-o DIR]', &
      '', &
      'Computes the cases of namelist files and writes each to DIR/NAME.csv and, if a table is', &
      'requested, to DIR/NAME.txt (DIR is "results" unless given). A result is itself an input', &
      'that reproduces it.', &
      'Groups: &system, or &structure with its parts, &output, and one for each case;', &
      'see inputs/README.md.']
   character(89), parameter :: after(*) = [character(89) :: &
      '--keys GROUP describes the keys of a group, --describe all of them as JSON.', &
      '', &
      'example: vibroimpact-batch inputs/table1.nml -o results', &
      '', &
      'exit status: 0 done; 1 ran, but a motion failed or does not exist; 2 the input is wrong']

contains

   !> Does what the arguments request and returns the exit status.
   subroutine run_command(progress, status)
      !> Progress counters, see vi_progress.
      integer, intent(inout) :: progress(3)
      !> Exit status: `done`, `failed` or `wrong`.
      integer, intent(out) :: status
      type(line_type), allocatable :: files(:), lines(:)
      type(log_type) :: log
      character(:), allocatable :: folder, item
      logical :: files_only, lost, printed
      integer :: i, j, first, last

      status = done
      folder = 'results'
      files_only = .false.
      lost = .false.
      allocate (files(0))
      i = 0
      do while (i < command_argument_count())
         i = i + 1
         call get_argument(i, item)
         if ((item == '-h' .or. item == '--help') .and. .not. files_only) then
            call describe_use(lines)
            call print_lines(lines, status)
            return
         else if (item == '--version') then
            call append(lines, 'vibroimpact-batch '//version)
            call print_lines(lines, status)
            return
         else if (item == '--describe' .and. .not. files_only) then
            call describe_all(lines)
            call print_lines(lines, status)
            return
         else if (item == '--keys' .and. .not. files_only) then
            call get_argument(i + 1, item)
            call print_keys(item, status)
            return
         else if (item == '-o' .and. .not. files_only) then
            i = i + 1
            call get_argument(i, folder)
            call check_folder(folder, status)
         else if (item == '--' .and. .not. files_only) then
            files_only = .true.
         else if (index(item, '-') == 1 .and. .not. files_only) then
            call refuse(item//': is not an option; must be -o DIR, --keys GROUP, --describe, &
               &--help or --version', status)
         else
            call append(files, item)
         end if
         if (status /= done) return
      end do
      if (size(files) == 0) then
         call describe_use(lines)
         write (error_unit, '(a)') (lines(j)%text, j=1, size(lines))
         status = wrong
         return
      end if
      first = 1
      do i = 1, size(files)
         call run_file(files(i)%text, folder, log, progress=progress)
         do while (first <= log%said%n)
            last = first + index(log%said%text(first:), achar(0)) - 2
            if (log%said%text(first:first) == '!') then
               write (error_unit, '(a)') log%said%text(first + 1:last)
            else if (log%said%text(first:first) == '-' .and. .not. lost) then
               call print_line(log%said%text(first + 1:last), printed)
               lost = .not. printed
            end if
            first = last + 2
         end do
      end do
      status = max(log%status, merge(failed, done, lost))
   end subroutine run_command

   !> The help: how the program is used, and the studies.
   subroutine describe_use(lines)
      !> Its lines.
      type(line_type), allocatable, intent(out) :: lines(:)
      type(study_type), allocatable :: studies(:)
      integer :: i

      do i = 1, size(before)
         call append(lines, trim(before(i)))
      end do
      call list_studies(studies)
      do i = 1, size(studies)
         call append(lines, '  &'//studies(i)%name//'  '//trim(studies(i)%meaning))
      end do
      do i = 1, size(after)
         call append(lines, trim(after(i)))
      end do
   end subroutine describe_use

   !> A command-line argument; empty if there are fewer.
   subroutine get_argument(i, text)
      !> Number of the argument, from 1.
      integer, intent(in) :: i
      !> The argument.
      character(:), allocatable, intent(out) :: text
      integer :: length

      length = 0
      if (i <= command_argument_count()) call get_command_argument(i, length=length)
      allocate (character(length) :: text)
      if (length > 0) call get_command_argument(i, text)
   end subroutine get_argument

   !> Prints a text, such as the help, instead of running a file.
   subroutine print_lines(lines, status)
      !> The lines.
      type(line_type), intent(in) :: lines(:)
      !> Exit status of the program.
      integer, intent(out) :: status
      logical :: printed
      integer :: i

      do i = 1, size(lines)
         call print_line(lines(i)%text, printed)
         status = merge(done, failed, printed)
         if (.not. printed) return
      end do
   end subroutine print_lines

   !> Describes the keys of a group.
   subroutine print_keys(name, status)
      !> The group, with or without its &.
      character(*), intent(in) :: name
      !> Exit status of the program.
      integer, intent(out) :: status
      type(line_type), allocatable :: lines(:)
      character(name_length), allocatable :: names(:)
      character(:), allocatable :: group, list
      integer :: i

      call list_groups(names)
      group = lower(name(1 + index(name(:min(1, len(name))), '&'):))
      if (any(names == group)) then
         call describe_group(group, lines)
         call print_lines(lines, status)
      else
         list = trim(names(1))
         do i = 2, size(names)
            list = list//', '//trim(names(i))
         end do
         call refuse('--keys '//name//': must be followed by one of '//list, status)
      end if
   end subroutine print_keys

   !> Checks the folder of -o: a name that looks like that of a file is rejected, unless it exists
   !! or ends with a slash.
   subroutine check_folder(folder, status)
      !> The argument after -o.
      character(*), intent(in) :: folder
      !> Out: `wrong` if it is rejected; otherwise not changed.
      integer, intent(inout) :: status
      character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyz'
      character(:), allocatable :: name, suffix
      logical :: there

      inquire (file=folder, exist=there)                ! a file of this name is rejected later
      if (.not. there) there = is_folder(folder)    ! not all compilers inquire about folders
      name = lower(folder(index(folder, '/', back=.true.) + 1:))
      suffix = name(index(name, '.', back=.true.) + 1:)
      if (len(folder) == 0) then
         call refuse('-o: must be followed by a folder', status)
      else if (there .or. len(name) == 0) then
         return
      else if (folder == '-' .or. (index(name, '.', back=.true.) > 1 .and. &
         scan(suffix(:min(1, len(suffix))), letters) == 1 .and. len(suffix) <= 5 .and. &
         verify(suffix, letters//'0123456789') == 0)) then
         call refuse('-o '//folder//': must be a folder; for a folder of this name, &
            &write -o '//folder//'/', &
            status)
      end if
   end subroutine check_folder

   !> Prints an error in the command line.
   subroutine refuse(message, status)
      !> The fault.
      character(*), intent(in) :: message
      !> Out: `wrong`.
      integer, intent(out) :: status

      write (error_unit, '(a)') message
      status = wrong
   end subroutine refuse

end module vi_command
