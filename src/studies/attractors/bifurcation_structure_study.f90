!> The study &bifurcation of a &structure: settled motions along a parameter.
module vi_bifurcation_structure_study
   use vi_kinds, only: wp
   use vi_structure, only: load_type, structure_type
   use vi_structure_groups, only: load_frequency, structure_of
   use vi_structure_keys, only: check_start_state, needs_frequency
   use vi_structure_parameter, only: function_keys, parameter_change
   use vi_structure_path, only: change_type, parameter_takes, structure_path_type
   use vi_structure_sweep, only: cell_type
   use vi_structure_sweep_tables, only: cell_columns, check_sweep, put_cells, run_sweep, sweep_keys
   use vi_study, only: a_whole, a_word, case_type, column_type, key_type, result_type, study_type, &
      values_type, wholes
   implicit none (type, external)
   private

   public :: declare_bifurcation_structure

   type(key_type), parameter :: own_keys(*) = [ &
      key_type('parameter', a_word, takes=parameter_takes, meaning='parameter that changes'), &
      key_type('low', meaning='first value of the parameter', takes='a finite number', &
      option='values'), &
      key_type('high', over='low', meaning='last value of the parameter', &
      takes='a finite number', option='values'), &
      key_type('points', a_whole, default='100', low=0.0_wp, high=4096.0_wp, &
      meaning='impacts kept at each value')]

   type(column_type), parameter :: strobe_columns(*) = [ &
      column_type('strobes', 'q', each='coordinate', label='q_#', &
      meaning='coordinates at the beginning of a load cycle'), &
      column_type('strobes', 'q_dot', each='coordinate', label='q_dot_#', meaning='velocities'), &
      column_type('impacts', 'gap', wholes, listed=.false., meaning='number of the gap, from 0'), &
      column_type('impacts', 'phase', unit='rad', listed=.false., &
      meaning='load phase within a load cycle'), &
      column_type('impacts', 'speed', listed=.false., meaning='approach speed')]

contains

   !> Declares the study.
   subroutine declare_bifurcation_structure(study)
      !> The declaration of the study.
      type(study_type), intent(out) :: study

      study%name = 'bifurcation_structure'
      study%group = 'bifurcation'
      study%of_structure = .true.
      study%meaning = 'sweep settled motions of a structure along a parameter'
      study%list => list_bifurcation
      study%row = 'strobes'
      study%check => check_bifurcation
      study%memory => bifurcation_memory
      study%run => run_bifurcation
   end subroutine declare_bifurcation_structure

   !> Lists the keys and columns.
   pure subroutine list_bifurcation(keys, columns)
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) keys = [own_keys(:3), sweep_keys, own_keys(4:), function_keys]
      if (present(columns)) columns = [cell_columns, strobe_columns]
   end subroutine list_bifurcation

   !> Checks the rules that involve several keys.
   subroutine check_bifurcation(case)
      !> The case.
      type(case_type), intent(inout) :: case
      type(structure_path_type) :: path
      character(:), allocatable :: message
      character(9), parameter :: keys(0:2) = [character(9) :: 'parameter', 'low', 'high']
      integer :: bound

      if (len(case%study%fault) > 0) return
      call check_start_state(case)
      call needs_frequency(case, 'parameter')
      call check_sweep(case%study, case%coordinates)
      if (len(case%study%fault) > 0) return
      call find_path(case, path, message, bound)
      if (len(message) > 0) call case%study%refuse(trim(keys(bound)), message)
   end subroutine check_bifurcation

   !> The structure and its load as functions of the parameter.
   subroutine find_path(case, path, message, bound)
      !> The case.
      type(case_type), intent(in) :: case
      !> The path.
      type(structure_path_type), intent(out) :: path
      !> What is wrong with the parameter; empty if nothing is.
      character(:), allocatable, intent(out) :: message
      !> The bound with which that is wrong, 1 or 2; 0 if it is another key.
      integer, intent(out) :: bound
      type(change_type) :: change
      type(structure_type) :: structure
      type(load_type) :: load

      call structure_of(case, structure, load)
      load%frequency = load_frequency(case)
      call parameter_change(case%study, 'parameter', '', structure, load, change, message, bound)
      path%structure = structure
      path%load = load
      allocate (path%changes(1))
      path%changes(1) = change
   end subroutine find_path

   !> Bytes for the states and impacts of all values, in the result too.
   pure real(wp) function bifurcation_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case

      associate (s => case%study)
         bytes = 2.0_wp*s%whole_number('values')*(48.0_wp*s%whole_number('keep')*case%coordinates &
            + 60.0_wp*s%whole_number('points') + 500)
      end associate
   end function bifurcation_memory

   !> Sweeps.
   subroutine run_bifurcation(case, threads, result, progress)
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
      character(:), allocatable :: message
      integer, allocatable :: owners(:)
      integer :: bound, i, n

      associate (not_used => threads)    ! the state is carried from value to value
      end associate
      n = case%coordinates
      call find_path(case, path, message, bound)
      call run_sweep(case%study, path, case%study%whole_number('points'), cells, result, progress)
      call put_cells(result, path, case%study, cells)
      owners = [(spread(i, 1, size(cells(i)%strobes, 2)), i=1, size(cells))]
      call result%open('strobes', 'strobe', [size(owners)], 'cells', owners)
      call result%put('strobes', 'q', [(cells(i)%strobes(:n, :), i=1, size(cells))], n)
      call result%put('strobes', 'q_dot', [(cells(i)%strobes(n + 1:, :), i=1, size(cells))], n)
      owners = [(spread(i, 1, size(cells(i)%gaps)), i=1, size(cells))]
      call result%open('impacts', 'impact', [size(owners)], 'cells', owners)
      call result%put('impacts', 'gap', [(cells(i)%gaps - 1, i=1, size(cells))])
      call result%put('impacts', 'phase', [(cells(i)%phases, i=1, size(cells))])
      call result%put('impacts', 'speed', [(cells(i)%speeds, i=1, size(cells))])
   end subroutine run_bifurcation

end module vi_bifurcation_structure_study
