!> The keys of sweeps of structures along a parameter, and their tables in a result.
module vi_structure_sweep_tables
   use vi_common_keys, only: check_product, most_numbers
   use vi_kinds, only: wp
   use vi_progress, only: is_stopped
   use vi_spacing, only: even
   use vi_status, only: stat, status_text
   use vi_structure_path, only: structure_path_type, value_at
   use vi_structure_sweep, only: cell_type, sweep, sweep_type
   use vi_study, only: a_whole, a_word, column_type, key_type, result_type, values_type, &
      wholes, words
   use vi_text, only: counted, whole
   implicit none (type, external)
   private

   public :: check_sweep, put_cells, run_sweep, shares_of, value_count

   !> The keys of all sweeps of structures.
   type(key_type), parameter, public :: sweep_keys(*) = [ &
      key_type('values', a_whole, low=2.0_wp, high=1.0e6_wp, never='list', option='values', &
      meaning='number of values, evenly spaced'), &
      key_type('list', least=2, most=1000000, may_miss=.true., takes='two or more increasing &
      &numbers in the range of the parameter', &
      meaning='values of the parameter, if they are not evenly spaced'), &
      key_type('sweep', a_word, default='''both''', words='up down both', &
      meaning='up, down, or up and then down; the state is carried from value to value')]

   !> The columns of what was found at each value.
   type(column_type), parameter, public :: cell_columns(*) = [ &
      column_type('cells', 'value', meaning='value of the parameter'), &
      column_type('cells', 'run', words, words='up,down', meaning='direction of the sweep'), &
      column_type('cells', 'cycles', wholes, &
      meaning='load cycles of the period; 0 if none is confirmed'), &
      column_type('cells', 'impacts', wholes, &
      meaning='impacts of a period, or without a period in all cycles examined'), &
      column_type('cells', 'rests', wholes, meaning='rests, counted in the same way'), &
      column_type('cells', 'status', wholes, listed=.false., &
      meaning='code of what failed; 0: none')]

contains

   !> Number of values.
   pure integer function value_count(study) result(n)
      !> The group.
      type(values_type), intent(in) :: study

      if (study%has('list')) then
         n = size(study%numbers('list'))
      else
         n = study%whole_number('values')
      end if
   end function value_count

   !> The values, as shares of the way from the first to the last one.
   pure function shares_of(study) result(shares)
      !> The group.
      type(values_type), intent(in) :: study
      real(wp) :: shares(value_count(study))

      if (study%has('list')) then
         associate (list => study%numbers('list'), n => size(shares))
            shares = (list - list(1))/(list(n) - list(1))
         end associate
      else
         shares = even(0.0_wp, 1.0_wp, size(shares))
      end if
   end function shares_of

   !> Checks the values and their number.
   subroutine check_sweep(study, coordinates)
      !> The group.
      type(values_type), intent(inout) :: study
      !> Number of coordinates.
      integer, intent(in) :: coordinates

      if (study%has('list')) then
         associate (list => study%numbers('list'))
            if (any(list(2:) <= list(:size(list) - 1))) call study%refuse('list')
         end associate
      end if
      call check_product(study, trim(merge('list  ', 'values', study%has('list'))), &
         [2*value_count(study), study%whole_number('keep'), 2*coordinates], 'together with keep &
         &and the coordinates at most '//whole(most_numbers)//' numbers')
   end subroutine check_sweep

   !> Sweeps over the values of a case.
   subroutine run_sweep(study, path, points, outputs, cells, result, progress)
      !> The group.
      type(values_type), intent(in) :: study
      !> The structure and its load as functions of the parameter.
      type(structure_path_type), intent(in) :: path
      !> Impacts that are kept at each value.
      integer, intent(in) :: points
      !> (outputs, n) Outputs whose sizes are measured, as sums of the coordinates.
      real(wp), intent(in) :: outputs(:, :)
      !> What was found, as far as it was reached.
      type(cell_type), allocatable, intent(out) :: cells(:)
      !> In and out: marked if it was stopped.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(cell_type), allocatable :: all_cells(:)
      integer, allocatable :: order(:), runs(:)
      integer :: done, first, i, last, n

      n = value_count(study)
      allocate (order(2*n), runs(2*n))
      order(:n) = [(i, i=1, n)]
      order(n + 1:) = order(n:1:-1)
      runs(:n) = 1
      runs(n + 1:) = 2
      first = merge(n + 1, 1, study%is('sweep', 'down'))
      last = merge(n, 2*n, study%is('sweep', 'up'))
      allocate (all_cells(first:last))
      call sweep(path, shares_of(study), order(first:last), runs(first:last), &
         study%numbers('q'), study%numbers('q_dot'), sweep_type(study%whole_number('settling'), &
         study%whole_number('keep'), points, study%whole_number('max_events'), outputs), &
         all_cells, done, progress)
      allocate (cells, source=all_cells(first:first + done - 1))
      if (is_stopped(progress) .and. done < size(all_cells)) result%cut = whole(done)//' of '// &
         counted(size(all_cells), 'value')//' were reached'
   end subroutine run_sweep

   !> Fills the table of the cells, with notes.
   pure subroutine put_cells(result, path, study, cells)
      !> The result.
      type(result_type), intent(inout) :: result
      !> The path.
      type(structure_path_type), intent(in) :: path
      !> The group.
      type(values_type), intent(in) :: study
      !> What was found.
      type(cell_type), intent(in) :: cells(:)
      real(wp), allocatable :: shares(:)
      integer :: i, lost

      allocate (shares, source=shares_of(study))
      call result%open('cells', 'cell', [size(cells)])
      call result%put('cells', 'value', [(value_at(path%changes(1), shares(cells(i)%value)), &
         i=1, size(cells))])
      call result%put('cells', 'run', cells%run)
      call result%put('cells', 'cycles', cells%cycles)
      call result%put('cells', 'impacts', cells%impacts)
      call result%put('cells', 'rests', cells%rests)
      call result%put('cells', 'status', cells%status)
      lost = count(cells%status /= stat%ok)
      result%empty = lost == size(cells)
      if (.not. result%empty) call result%add_note(counted(size(cells), 'value')//', '// &
         whole(count(cells%cycles > 0))//' with a period')
      if (lost == 0) return
      i = findloc(cells%status /= stat%ok, .true., 1)
      call result%fail(whole(lost)//' of '//counted(size(cells), 'value')//' failed: '// &
         status_text(cells(i)%status))
   end subroutine put_cells

end module vi_structure_sweep_tables
