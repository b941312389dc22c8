!> Runs a case with a bifurcation diagram: one row an impact.
module vi_run_bifurcation
   use vi_attractor_diagram, only: diagram, diagram_type, find_windows, path_type
   use vi_bifurcation_study, only: start_state
   use vi_common_keys, only: parameter_of, parameter_place, parameter_values
   use vi_case, only: case_type, echo
   use vi_kinds, only: wp
   use vi_log, only: done, failed, log_type, say, write_table
   use vi_pattern, only: side_letters
   use vi_processor, only: available_threads
   use vi_status, only: stat, status_text
   use vi_text, only: append, columns, counted, exact, lengthen, line_type, whole, whole_width
   implicit none (type, external)
   private

   public :: run_bifurcation

contains

   !> Sweeps, or starts anew at each value, and writes the impacts that are left.
   subroutine run_bifurcation(case, folder, log, written, tally)
      type(case_type), intent(in) :: case
      character(*), intent(in) :: folder
      type(log_type), intent(inout) :: log
      !> False if the result could not be written.
      logical, intent(out) :: written
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      type(path_type) :: path
      type(diagram_type) :: found
      type(line_type), allocatable :: lines(:)
      integer, allocatable :: directions(:)
      integer :: windows, lost

      written = .true.
      path = path_of(case)
      directions = directions_of(case)
      associate (s => case%study)
         call diagram(path, directions, start_state(case), s%whole_number('settling'), &
            s%whole_number('keep'), s%whole_number('points'), available_threads(), found, tally)
      end associate
      lost = count(found%status /= stat%ok)
      if (lost < size(found%status)) then
         call diagram_lines(case, path%values, directions, found, lines, windows)
         call write_table(folder//'/'//case%name//'.csv', lines, log, written)
         if (.not. written) return
         call say(log, done, case%name//': '//counted(size(directions), 'run')//' of '//whole( &
            size(path%values))//' values, '//counted(sum(found%found), 'impact')//', '// &
            counted(windows, 'periodic window'))
      end if
      if (lost > 0) call say(log, failed, case%name//': '//whole(lost)//' of '//counted( &
         size(found%status), 'simulation')//' failed: '//status_text(maxval(found%status)))
   end subroutine run_bifurcation

   !> The system with its values of the parameter.
   pure function path_of(case) result(path)
      type(case_type), intent(in) :: case
      type(path_type) :: path

      path%osc = case%osc
      allocate (path%r(1), source=case%r)
      allocate (path%clearance(1), source=0.0_wp)
      if (case%study%has('clearance')) path%clearance = case%study%number('clearance')
      path%load = case%study%number('load')
      allocate (path%values, source=parameter_values(case))
      call parameter_place(trim(parameter_of(case)), path%place, path%tied)
   end function path_of

   !> Of the runs: 1 up, -1 down, 0 anew at each value.
   pure function directions_of(case) result(directions)
      type(case_type), intent(in) :: case
      integer, allocatable :: directions(:)

      select case (case%study%word('sweep'))
      case ('up')
         directions = [1]
      case ('down')
         directions = [-1]
      case ('both')
         directions = [1, -1]
      case default
         allocate (directions(case%study%whole_number('states')), source=0)
      end select
   end function directions_of

   !> The impacts by run and value; header as in `csv_lines`, with the windows N/k.
   pure subroutine diagram_lines(case, values, directions, found, lines, windows)
      type(case_type), intent(in) :: case
      real(wp), intent(in) :: values(:)
      integer, intent(in) :: directions(:)
      type(diagram_type), intent(in) :: found
      type(line_type), allocatable, intent(out) :: lines(:)
      integer, intent(out) :: windows
      character(:), allocatable :: start
      integer :: first(size(values)), last(size(values)), i, j, k, n

      call echo(case, lines)
      windows = 0
      do j = 1, size(directions)
         call find_windows(found%periods(:, :, j), first, last, n)
         do i = 1, n
            call append(lines, '# ! '//run_name(directions, j)//': '//label(found%periods(:, &
               first(i), j))//' from '//exact(values(first(i)))//' to '//exact(values(last(i))))
         end do
         windows = windows + n
      end do
      call append(lines, &
         'run,'//trim(parameter_of(case))//',label,side,phase,x,x_dot_before,x_dot_after,'// &
         'z_dot_before,z_dot_after')
      n = size(lines)
      call lengthen(lines, sum(found%found))
      do j = 1, size(directions)
         do i = 1, size(values)
            start = run_name(directions, j)//','//exact(values(i))//','//label(found%periods(:, i, &
               j))//','
            do k = 1, found%found(i, j)
               n = n + 1
               lines(n)%text = start//side_letters(found%labels(2:2, k, i, j))//columns( &
                  found%impacts(2:, k, i, j))
            end do
         end do
      end do
   end subroutine diagram_lines

   pure function run_name(directions, j) result(text)
      integer, intent(in) :: directions(:), j
      character(len_trim(padded_name(directions, j))) :: text

      text = padded_name(directions, j)
   end function run_name

   !> The same with blanks behind it.
   pure function padded_name(directions, j) result(text)
      integer, intent(in) :: directions(:), j
      character(20) :: text

      select case (directions(j))
      case (1)
         text = 'up'
      case (-1)
         text = 'down'
      case default
         text = 'state '//whole(j)
      end select
   end function padded_name

   !> N/k; empty where no period was seen.
   pure function label(period) result(text)
      !> Load cycles, letters, impacts, rests.
      integer, intent(in) :: period(4)
      character(merge(whole_width(period(1)) + whole_width(period(2)) + 1, 0, &
         period(1) > 0)) :: text

      if (period(1) > 0) text = whole(period(2))//'/'//whole(period(1))
   end function label

end module vi_run_bifurcation
