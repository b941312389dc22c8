!> Runs the cases of a namelist file and writes their results.
module vi_batch
   use vi_case, only: case_type
   use vi_dictionary, only: dictionary_type, find_text, include_text
   use vi_files, only: make_folder, same_file, writable, write_file
   use vi_log, only: add_message, add_result, done, failed, log_type, wrong
   use vi_printout, only: print_motions
   use vi_processor, only: available_threads
   use vi_progress, only: is_stopped
   use vi_read_cases, only: read_cases
   use vi_read_file, only: is_result
   use vi_result, only: result_type
   use vi_study_list, only: run_study
   use vi_text, only: lengthen, line_type, lower, whole
   use vi_write_csv, only: write_csv
   implicit none (type, external)
   private

   public :: done, failed, log_type, run_file, wrong

   !> Numbers added to the flag that stops a study (see vi_progress) while cases are read, and while
   !! a file is written: a signal then does not stop a study.
   integer, parameter :: reading = -8
   integer, parameter, public :: writing = 2
   !> The flag after a signal during the writing of a file, which is then given up.
   integer, parameter, public :: give_up_file = 4

contains

   !> Runs all cases of one file; none runs if the file has a fault.
   subroutine run_file(path, folder, log, only, progress)
      !> The namelist file.
      character(*), intent(in) :: path
      !> Folder of the results; created if it does not exist.
      character(*), intent(in) :: folder
      !> In and out: messages, names of results, and the worst status so far.
      type(log_type), intent(inout) :: log
      !> The only study whose cases are run; if absent or empty, all cases are run.
      character(*), intent(in), optional :: only
      !> Progress counters, see vi_progress; studies of single motions do not use them.
      integer, intent(inout), optional :: progress(3)
      type(case_type), allocatable :: cases(:)
      character(:), allocatable :: message
      logical :: written
      integer :: i

      message = ''
      if (len_trim(path) < len(path) .or. len(path) == 0) message = path// &
         ': cannot be read: a path must not end with a blank'
      call change_flag(reading, progress)
      if (len(message) == 0) call read_cases(path, cases, message)
      call change_flag(-reading, progress)
      if (len(message) == 0 .and. present(only)) call keep(path, only, cases, message)
      if (len(message) == 0) call take_names(path, folder, cases, log, message)
      if (len(message) > 0) then
         call add_message(log, wrong, message)
         return
      end if
      call make_folder(folder, message)
      if (len(message) > 0) then
         call add_message(log, wrong, folder//': '//message)
         return
      end if
      do i = 1, size(cases)
         if (is_stopped(progress)) then
            call add_message(log, failed, &
               cases(i)%name//': not run, since the program was interrupted')
            cycle
         end if
         call run_case(cases(i), folder, log, written, progress)
         if (.not. written) return                     ! the next result could not be written either
      end do
   end subroutine run_file

   !> Runs one case, writes its result and logs what was found.
   subroutine run_case(case, folder, log, written, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Folder of the results.
      character(*), intent(in) :: folder
      !> In and out: messages are added.
      type(log_type), intent(inout) :: log
      !> False if a result could not be written.
      logical, intent(out) :: written
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(result_type) :: result
      type(line_type), allocatable :: lines(:)
      character(:), allocatable :: path, message, printed, table
      integer :: i

      call run_study(case, available_threads(), result, progress)
      path = folder//'/'//case%name
      printed = ''
      table = ''
      message = ''
      call change_flag(writing, progress)
      if (case%study_name == 'motion' .and. .not. case%output%is('format', 'csv')) then
         printed = path//'.txt'
         call print_motions(case%name, result, lines)
         call write_file(printed, lines, message)
         if (len(message) > 0) message = printed//': '//message
      end if
      if (len(message) == 0 .and. .not. result%empty .and. .not. (case%study_name == 'motion' &
         .and. case%output%is('format', 'table'))) then
         table = path//'.csv'
         call write_csv(result, table, message, progress, give_up_file)
         if (len(message) > 0) message = table//': '//message
      end if
      written = len(message) == 0
      if (.not. written .and. present(progress)) written = is_stopped(progress, give_up_file)
      call end_writing(progress)
      if (written .and. len(message) > 0) then
         call add_message(log, failed, case%name//': interrupted; its file was not written')
         return
      end if
      if (.not. written) then
         call add_message(log, wrong, message//writable)
         return
      end if
      if (len(result%cut) > 0) call add_message(log, failed, &
         case%name//': interrupted: '//result%cut)
      do i = 1, size(result%notes)
         call add_message(log, merge(failed, done, result%notes(i)%fault), case%name//': '// &
            result%notes(i)%text)
      end do
      if (len(printed) > 0) call add_message(log, done, case%name//': '//printed)
      if (len(table) == 0) return
      call add_result(log, table)
      call add_message(log, done, case%name//': '//table)
   end subroutine run_case

   !> Changes the flag that stops a study.
   subroutine change_flag(change, progress)
      !> What is added to it.
      integer, intent(in) :: change
      !> Progress counters; nothing is done without them.
      integer, intent(inout), optional :: progress(3)

      if (.not. present(progress)) return
      !$omp atomic update
      progress(3) = progress(3) + change
   end subroutine change_flag

   !> Sets the flag to its value without a file that is written: 1 if there was a signal, else 0.
   subroutine end_writing(progress)
      !> Progress counters; nothing is done without them.
      integer, intent(inout), optional :: progress(3)

      if (.not. present(progress)) return
      !$omp atomic update
      progress(3) = min(progress(3), writing + 1)
      call change_flag(-writing, progress)
   end subroutine end_writing

   !> Keeps the cases of one study; there must be at least one.
   subroutine keep(path, only, cases, message)
      !> The file, for the message; name of the study, or empty for all.
      character(*), intent(in) :: path, only
      !> In: all cases. Out: those of this kind.
      type(case_type), allocatable, intent(inout) :: cases(:)
      !> Out: set if there is none; otherwise not changed.
      character(:), allocatable, intent(inout) :: message
      type(case_type), allocatable :: kept(:)
      integer :: i, n

      if (len(only) == 0) return
      n = count([(cases(i)%study%name == only, i=1, size(cases))])
      if (n == 0) message = path//': must contain a group &'//only//'; there is none'
      allocate (kept(n))
      n = 0
      do i = 1, size(cases)
         if (cases(i)%study%name /= only) cycle
         n = n + 1
         kept(n) = cases(i)
      end do
      call move_alloc(kept, cases)
   end subroutine keep

   !> Reserves the names of the results; two cases with the same name would overwrite each other.
   subroutine take_names(path, folder, cases, log, message)
      !> The namelist file, and the folder of the results.
      character(*), intent(in) :: path, folder
      !> The cases.
      type(case_type), intent(in) :: cases(:)
      !> In and out: the names are added, unless there is a fault.
      type(log_type), intent(inout) :: log
      !> Out: the fault; not changed if there is none.
      character(:), allocatable, intent(inout) :: message
      type(dictionary_type) :: names
      character(:), allocatable :: result
      logical :: overwrites
      integer :: i, j

      do i = 1, size(cases)
         associate (name => cases(i)%name, place => path//':'//whole(cases(i)%line))
            call find_text(log%names, lower(name), j)
            if (j > 0) message = place//': &output name = '''//name// &
               ''': is already the name of the case at '//log%places(j)%text//'; must be another'
            call include_text(names, lower(name), j)
            if (j < i) message = place//': &output name = '''//name// &
               ''': is already the name of the case at '//path//':'//whole(cases(j)%line)// &
               '; must be another'
            result = folder//'/'//name
            ! a result may be run and written to its own file: the same bytes are written again
            overwrites = same_file(path, result//'.txt')
            if (.not. overwrites) overwrites = same_file(path, result//'.csv')
            if (overwrites) overwrites = .not. is_result(path)
            if (overwrites) message = place//': &output name = '''//name//''': its result would &
               &overwrite this input; must be another name or folder'
         end associate
         if (len(message) > 0) return
      end do
      call lengthen(log%places, size(cases))
      do i = 1, size(cases)
         call include_text(log%names, lower(cases(i)%name), j)
         log%places(j)%text = path//':'//whole(cases(i)%line)
      end do
   end subroutine take_names

end module vi_batch
