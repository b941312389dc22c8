!> Runs the cases of a namelist file and writes their results.
module vi_batch
   use vi_case, only: case_type
   use vi_chart_study, only: chart_pattern, chart_window_of
   use vi_common_keys, only: state_of
   use vi_files, only: make_folder, same_file, writable, write_file
   use vi_log, only: done, failed, log_type, say, write_table, wrong
   use vi_motion, only: motion_type, yes
   use vi_motion_study, only: find_motions
   use vi_pattern, only: pattern_type, side_letters
   use vi_report, only: csv_lines, describe_verdicts, event_lines, table_lines
   use vi_report_chart, only: chart_lines
   use vi_run_atlas, only: run_atlas
   use vi_run_basins, only: run_basins
   use vi_run_bifurcation, only: run_bifurcation
   use vi_run_branch, only: run_branch
   use vi_run_lyapunov, only: run_lyapunov
   use vi_run_response, only: run_response
   use vi_run_zone, only: run_zone
   use vi_simulate, only: event_type, impact_event, new_drive, state_type, stick_event
   use vi_status, only: stat, status_text
   use vi_read_cases, only: read_cases
   use vi_read_file, only: is_result
   use vi_text, only: append, counted, line_type, lower, whole
   use vi_trajectory, only: simulate_case
   use vi_window, only: chart_window, map_type
   implicit none (type, external)
   private

   public :: done, failed, log_type, run_file, wrong

contains

   !> Runs all cases of one file; nothing runs unless the whole file is right.
   subroutine run_file(path, folder, log, only, tally)
      character(*), intent(in) :: path
      !> Where results go; made if it is not there.
      character(*), intent(in) :: folder
      type(log_type), intent(inout) :: log
      !> The one kind of cases that is run; without it, or if it is empty, all are.
      character(*), intent(in), optional :: only
      !> As of vi_tally; of all but single motions.
      integer, intent(inout), optional :: tally(3)
      type(case_type), allocatable :: cases(:)
      character(:), allocatable :: message
      logical :: written
      integer :: i

      if (.not. allocated(log%lines)) allocate (log%lines(0), log%names(0), log%places(0), &
         log%results(0))
      message = ''
      if (len_trim(path) < len(path) .or. len(path) == 0) message = path// &
         ': cannot be read: a path must not end with a blank'
      if (len(message) == 0) call read_cases(path, cases, message)
      if (len(message) == 0 .and. present(only)) call keep(path, only, cases, message)
      if (len(message) == 0) call take_names(path, folder, cases, log, message)
      if (len(message) > 0) then
         call say(log, wrong, message)
         return
      end if
      call make_folder(folder, message)
      if (len(message) > 0) then
         call say(log, wrong, folder//': '//message)
         return
      end if
      do i = 1, size(cases)
         call run_case(cases(i), folder, log, written, tally)
         if (.not. written) return                     ! the next one would not be written either
      end do
   end subroutine run_file

   !> Runs one case, and names the table that it wrote.
   subroutine run_case(case, folder, log, written, tally)
      type(case_type), intent(in) :: case
      character(*), intent(in) :: folder
      type(log_type), intent(inout) :: log
      !> False if a result could not be written.
      logical, intent(out) :: written
      integer, intent(inout), optional :: tally(3)
      type(motion_type), allocatable :: motions(:)
      integer :: i, known

      known = size(log%results)
      select case (case%study%name)
      case ('simulate')
         call run_simulation(case, folder, log, written, tally)
      case ('chart')
         call run_chart(case, folder, log, written, tally)
      case ('zone')
         call run_zone(case, folder, log, written, tally)
      case ('atlas')
         call run_atlas(case, folder, log, written, tally)
      case ('lyapunov')
         call run_lyapunov(case, folder, log, written, tally)
      case ('bifurcation')
         call run_bifurcation(case, folder, log, written, tally)
      case ('basins')
         call run_basins(case, folder, log, written, tally)
      case ('response')
         call run_response(case, folder, log, written, tally)
      case ('branch')
         call find_motions(case, case%start, motions)
         call run_branch(case, motions, folder, log, written, tally)
      case default
         call find_motions(case, case%study, motions)
         call write_results(case, motions, folder, log, written)
      end select
      do i = known + 1, size(log%results)
         call say(log, done, case%name//': '//log%results(i)%text)
      end do
   end subroutine run_case

   !> Keeps the cases of one kind, of which there has to be one.
   subroutine keep(path, only, cases, message)
      character(*), intent(in) :: path, only
      type(case_type), allocatable, intent(inout) :: cases(:)
      character(:), allocatable, intent(inout) :: message
      type(case_type), allocatable :: kept(:)
      integer :: i, n

      if (len(only) == 0) return
      n = count([(cases(i)%study%name == only, i=1, size(cases))])
      if (n == 0) message = path//': must hold a group &'//only//'; there is none'
      allocate (kept(n))
      n = 0
      do i = 1, size(cases)
         if (cases(i)%study%name /= only) cycle
         n = n + 1
         kept(n) = cases(i)
      end do
      call move_alloc(kept, cases)
   end subroutine keep

   !> Reserves the names of the results; two cases with one name would overwrite each other.
   subroutine take_names(path, folder, cases, log, message)
      character(*), intent(in) :: path, folder
      type(case_type), intent(in) :: cases(:)
      type(log_type), intent(inout) :: log
      character(:), allocatable, intent(inout) :: message
      character(:), allocatable :: result
      logical :: overwrites
      integer :: i, j

      do i = 1, size(cases)
         associate (name => cases(i)%name, place => path//':'//whole(cases(i)%line))
            do j = 1, size(log%names)
               if (log%names(j)%text == lower(name)) message = place//': &output name = '''// &
                  name//''': is already the name of the case at '//log%places(j)%text// &
                  '; must be another'
            end do
            do j = 1, i - 1
               if (lower(cases(j)%name) == lower(name)) message = place//': &output name = '''// &
                  name//''': is already the name of the case at '//path//':'// &
                  whole(cases(j)%line)//'; must be another'
            end do
            result = folder//'/'//name
            ! a result may be run into its own place: it writes the same bytes again
            overwrites = same_file(path, result//'.txt')
            if (.not. overwrites) overwrites = same_file(path, result//'.csv')
            if (overwrites) overwrites = .not. is_result(path)
            if (overwrites) message = place//': &output name = '''//name//''': its result would &
               &overwrite this input; must be another name or folder'
         end associate
         if (len(message) > 0) return
      end do
      do i = 1, size(cases)
         call append(log%names, lower(cases(i)%name))
         call append(log%places, path//':'//whole(cases(i)%line))
      end do
   end subroutine take_names

   !> Simulates a case and writes its events.
   subroutine run_simulation(case, folder, log, written, tally)
      type(case_type), intent(in) :: case
      character(*), intent(in) :: folder
      type(log_type), intent(inout) :: log
      !> False if the result could not be written.
      logical, intent(out) :: written
      integer, intent(inout), optional :: tally(3)
      type(event_type), allocatable :: events(:)
      type(state_type) :: state
      type(line_type), allocatable :: lines(:)
      integer :: status

      associate (s => case%study)
         call simulate_case(new_drive(case%osc, case%r, s%number('load'), s%number('clearance')), &
            state_of(s), s%number('cycles'), s%number('discard'), s%whole_number('max_events'), &
            state, events, status, tally)
      end associate
      written = .true.
      if (status /= stat%ok .and. status /= stat%more_events) then
         call say(log, failed, case%name//': '//status_text(status))
         return
      end if
      call event_lines(case, events, state, status == stat%ok, lines)
      call write_table(folder//'/'//case%name//'.csv', lines, log, written)
      if (.not. written) return
      call say(log, done, case%name//': '//counted(count(events%kind == impact_event), &
         'impact')//', '//counted(count(events%kind == stick_event), 'rest'))
      if (status /= stat%ok) call say(log, failed, case%name//': cut short, max_events was reached')
   end subroutine run_simulation

   !> Charts a case and writes its motions; a chart without any is said to be empty, not written.
   subroutine run_chart(case, folder, log, written, tally)
      type(case_type), intent(in) :: case
      character(*), intent(in) :: folder
      type(log_type), intent(inout) :: log
      !> False if the result could not be written.
      logical, intent(out) :: written
      integer, intent(inout), optional :: tally(3)
      type(map_type) :: map
      type(pattern_type) :: pattern
      type(line_type), allocatable :: lines(:)
      character(:), allocatable :: what

      pattern = chart_pattern(case%study)
      call chart_window(case%osc, pattern, chart_window_of(case%study), map, tally)
      written = .true.
      what = side_letters(pattern%sides)//'/'//whole(pattern%cycles)
      if (all(map%status /= stat%ok)) then
         call say(log, failed, case%name//': no motion '//what//' was found anywhere in the window')
         return
      end if
      call chart_lines(case, map, lines)
      call write_table(folder//'/'//case%name//'.csv', lines, log, written)
      if (.not. written) return
      call say(log, done, case%name//': '//whole(count(map%status == stat%ok))//' motions '// &
         what//' at '//whole(count(any(map%status == stat%ok, 1)))//' of '// &
         whole(size(map%status, 2)*size(map%status, 3))//' points, '// &
         whole(count(all(map%verdicts == yes, 1)))//' admissible and stable')
   end subroutine run_chart

   subroutine write_results(case, motions, folder, log, written)
      type(case_type), intent(in) :: case
      type(motion_type), intent(in) :: motions(:)
      character(*), intent(in) :: folder
      type(log_type), intent(inout) :: log
      !> False if a result could not be written.
      logical, intent(out) :: written
      type(line_type), allocatable :: lines(:)
      character(:), allocatable :: message, path, text
      integer :: i

      message = ''
      path = folder//'/'//case%name
      if (.not. case%output%is('format', 'csv')) then
         call table_lines(case, motions, lines)
         call write_file(path//'.txt', lines, message)
         if (len(message) > 0) message = path//'.txt: '//message
      end if
      if (.not. case%output%is('format', 'table') .and. len(message) == 0) then
         call csv_lines(case, motions, lines)
         call write_file(path//'.csv', lines, message)
         if (len(message) > 0) message = path//'.csv: '//message
      end if
      written = len(message) == 0
      if (.not. written) then
         call say(log, wrong, message//writable)
         return
      end if
      if (.not. case%output%is('format', 'table')) call append(log%results, path//'.csv')
      if (all(motions%status /= stat%ok)) call say(log, failed, case%name//': '// &
         status_text(motions(1)%status))
      do i = 1, size(motions)
         if (motions(i)%status /= stat%ok) cycle
         call describe_verdicts(motions(i), text)
         call say(log, done, case%name//': '//text)
      end do
      if (.not. case%output%is('format', 'csv')) call say(log, done, case%name//': '//path//'.txt')
   end subroutine write_results

end module vi_batch
