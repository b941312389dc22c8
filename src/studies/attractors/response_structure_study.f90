!> The study &response of a &structure: the size of settled motions along the load frequency.
module vi_response_structure_study
   use vi_kinds, only: wp
   use vi_progress, only: add_done_work, add_expected_work, is_stopped
   use vi_spacing, only: even
   use vi_structure, only: load_type, structure_type
   use vi_structure_groups, only: load_frequency, structure_of
   use vi_structure_keys, only: check_start_state, needs_frequency
   use vi_structure_path, only: new_change, structure_path_type
   use vi_structure_sweep, only: cell_type, steady_size
   use vi_structure_sweep_tables, only: cell_columns, check_sweep, put_cells, run_sweep, sweep_keys
   use vi_study, only: case_type, column_type, key_type, result_type, study_type
   implicit none (type, external)
   private

   public :: declare_response_structure

   type(key_type), parameter :: own_keys(*) = [ &
      key_type('low', low=0.0_wp, above=.true., meaning='first circular frequency of the load', &
      option='values'), &
      key_type('high', low=0.0_wp, over='low', meaning='last circular frequency of the load', &
      option='values')]

   type(column_type), parameter :: own_columns(*) = [ &
      column_type('cells', 'largest', each='coordinate', label='largest_#', &
      meaning='greatest magnitude of each coordinate'), &
      column_type('cells', 'rms', each='coordinate', label='rms_#', &
      meaning='root of the mean square of each coordinate'), &
      column_type('cells', 'steady_largest', each='coordinate', label='steady_largest_#', &
      meaning='greatest magnitude of the steady motion without impacts; nan if there is none'), &
      column_type('cells', 'steady_rms', each='coordinate', label='steady_rms_#', &
      meaning='root of the mean square of the steady motion without impacts'), &
      column_type('cells', 'q_min', each='coordinate', listed=.false., &
      meaning='least value of each coordinate'), &
      column_type('cells', 'q_max', each='coordinate', listed=.false., &
      meaning='greatest value of each coordinate')]

contains

   !> Declares the study.
   subroutine declare_response_structure(study)
      !> The declaration of the study.
      type(study_type), intent(out) :: study

      study%name = 'response_structure'
      study%group = 'response'
      study%of_structure = .true.
      study%meaning = 'follow the size of settled motions of a structure over frequency'
      study%list => list_response
      study%row = 'cells'
      study%check => check_response
      study%memory => response_memory
      study%run => run_response
   end subroutine declare_response_structure

   !> Lists the keys and columns.
   pure subroutine list_response(keys, columns)
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) keys = [own_keys, sweep_keys]
      if (present(columns)) columns = [cell_columns, own_columns]
   end subroutine list_response

   !> Checks the rules that involve several keys.
   subroutine check_response(case)
      !> The case.
      type(case_type), intent(inout) :: case

      if (len(case%study%fault) > 0) return
      call check_start_state(case)
      call needs_frequency(case, 'low')
      call check_sweep(case%study, case%coordinates)
   end subroutine check_response

   !> Bytes for all values, in the result too.
   pure real(wp) function response_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case

      associate (s => case%study)
         bytes = 2.0_wp*s%whole_number('values')*(48.0_wp*s%whole_number('keep')* &
            case%coordinates + 500)
      end associate
   end function response_memory

   !> Sweeps.
   subroutine run_response(case, threads, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(structure_path_type) :: path
      type(cell_type), allocatable :: cells(:)
      type(structure_type) :: structure
      type(load_type) :: load
      character(:), allocatable :: message
      real(wp), allocatable :: largest(:, :), rms(:, :), shares(:)
      integer :: i, m, n

      call structure_of(case, structure, load)
      load%frequency = load_frequency(case)
      path%structure = structure
      path%load = load
      allocate (path%changes(1))
      associate (s => case%study)
         call new_change('frequency', [s%number('low'), s%number('high')], structure, load, &
            path%changes(1), message)
         n = case%coordinates
         m = s%whole_number('values')
         allocate (shares, source=even(0.0_wp, 1.0_wp, m))
         allocate (largest(n, m), rms(n, m), source=0.0_wp)
         call add_expected_work(m, progress)
         !$omp parallel do schedule(dynamic, 1) num_threads(threads)
         do i = 1, m
            if (is_stopped(progress)) cycle  ! and the sweep, which is next, reaches no value
            call steady_size(path, shares(i), largest(:, i), rms(:, i))
            call add_done_work(1, progress)
         end do
         !$omp end parallel do
         call run_sweep(s, path, 0, cells, result, progress)
         call put_cells(result, path, s, cells)
      end associate
      call result%put('cells', 'largest', [(max(abs(cells(i)%q_min), cells(i)%q_max), i=1, &
         size(cells))], n)
      call result%put('cells', 'rms', [(cells(i)%q_rms, i=1, size(cells))], n)
      call result%put('cells', 'steady_largest', [largest(:, cells%value)], n)
      call result%put('cells', 'steady_rms', [rms(:, cells%value)], n)
      call result%put('cells', 'q_min', [(cells(i)%q_min, i=1, size(cells))], n)
      call result%put('cells', 'q_max', [(cells(i)%q_max, i=1, size(cells))], n)
   end subroutine run_response

end module vi_response_structure_study
