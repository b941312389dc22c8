!> The command line of the stand-alone program.
module vi_command
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use vi_batch, only: done, failed, log_type, run_file, wrong
   use vi_text, only: append, line_type
   use vi_version, only: version
   implicit none (type, external)
   private

   public :: run_command

contains

   !> Runs what the arguments ask for and returns the exit status.
   subroutine run_command(status)
      integer, intent(out) :: status
      type(line_type), allocatable :: files(:)
      type(log_type) :: log
      character(:), allocatable :: folder, item
      logical :: files_only
      integer :: i, said, lost, outcome

      status = done
      folder = 'results'
      files_only = .false.
      lost = 0
      allocate (files(0))
      i = 0
      do while (i < command_argument_count())
         i = i + 1
         item = argument(i)
         if ((item == '-h' .or. item == '--help') .and. .not. files_only) then
            call help(output_unit)
            return
         else if (item == '--version') then
            write (output_unit, '(a)') 'vibroimpact-batch '//version
            return
         else if (item == '-o' .and. .not. files_only) then
            i = i + 1
            folder = argument(i)
            if (len(folder) == 0) call refuse('-o: must be followed by a folder', status)
         else if (item == '--' .and. .not. files_only) then
            files_only = .true.
         else if (index(item, '-') == 1 .and. .not. files_only) then
            call refuse(item//': is not an option; must be -o DIR, --help or --version', status)
         else
            call append(files, item)
         end if
         if (status /= done) return
      end do
      if (size(files) == 0) then
         call help(error_unit)
         status = wrong
         return
      end if
      said = 0
      do i = 1, size(files)
         call run_file(files(i)%text, folder, log)
         do said = said + 1, size(log%lines)
            associate (line => log%lines(said)%text)
               if (line(1:1) == '!') then
                  write (error_unit, '(a)') line(2:)
               else
                  write (output_unit, '(a)', iostat=outcome) line(2:)
                  if (outcome /= 0) lost = outcome
               end if
            end associate
         end do
         said = size(log%lines)
      end do
      status = max(log%status, merge(failed, done, lost /= 0))
   end subroutine run_command

   !> An argument of the command; empty if there are not so many.
   function argument(i) result(text)
      integer, intent(in) :: i
      character(:), allocatable :: text
      integer :: length

      length = 0
      if (i <= command_argument_count()) call get_command_argument(i, length=length)
      allocate (character(length) :: text)
      if (length > 0) call get_command_argument(i, text)
   end function argument

   subroutine refuse(message, status)
      character(*), intent(in) :: message
      integer, intent(out) :: status

      write (error_unit, '(a)') message
      status = wrong
   end subroutine refuse

   subroutine help(unit)
      integer, intent(in) :: unit

      write (unit, '(a)') &
         'usage: vibroimpact-batch FILE.nml... [-o DIR]', &
         '', &
         'Computes the motions, simulations, charts, branches, zones, atlases and attractors', &
         'that namelist files ask for and writes each case to DIR/NAME.csv and, if it asks', &
         'for a table, to DIR/NAME.txt (DIR is "results" unless given). A result is itself an', &
         'input that reproduces it.', &
         'Groups: &system, &output and, for each case, &motion, &simulate, &chart, &branch,', &
         '&zone, &atlas, &lyapunov, &bifurcation, &response or &basins; see inputs/README.md.', &
         '', &
         'example: vibroimpact-batch inputs/table1.nml -o results', &
         '', &
         'exit status: 0 done; 1 ran, but a motion failed or does not exist; 2 the input is wrong'
   end subroutine help

end module vi_command
