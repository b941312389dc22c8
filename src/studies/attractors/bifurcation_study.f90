!> The study &bifurcation: the impacts after the transient along a parameter.
module vi_bifurcation_study
   use vi_attractor_spread, only: spread_states
   use vi_chains, only: settle_chains
   use vi_common_keys, only: check_parameter, check_product, check_start, clearance_key, keep_key, &
      load_key, max_events_key, most_numbers, most_state, parameter_of, parameter_place, &
      parameter_takes, parameter_values, parameter_words, range_takes, resonance, settling_key, &
      spacing_key, state_keys, state_of, window_keys
   use vi_kinds, only: wp
   use vi_oscillator, only: at_resonance
   use vi_restitution, only: table_law
   use vi_simulated_motion, only: cell_type, examination_type
   use vi_simulated_pair, only: new_pair_chains, pair_chains_type
   use vi_status, only: stat, status_text
   use vi_structure, only: load_type, structure_type
   use vi_structure_groups, only: load_frequency, output_rows, structure_of
   use vi_structure_keys, only: check_start_state, needs_frequency, start_keys
   use vi_structure_parameter, only: function_keys, parameter_change
   use vi_structure_path, only: change_type, structure_path_type, structure_takes => parameter_takes
   use vi_structure_run, only: event_kinds
   use vi_structure_sweep_tables, only: cell_columns, check_sweep, run_sweep, sweep_keys, &
      value_count
   use vi_study, only: a_whole, a_word, case_type, column_type, every_model, key_type, list_for, &
      of_oscillator, of_parameter, of_structure, result_type, study_type, truths, &
      values_type, wholes, words
   use vi_text, only: append, counted, exact, line_type, whole, whole_width
   implicit none (type, external)
   private

   public :: declare_bifurcation

   !> Added to x' from value to value, over half the clearance, so that a sweep leaves unstable
   !! motions.
   real(wp), parameter :: kick = 1.0e-9_wp

   character(*), parameter :: own = '=: sweep = ''states'' uses other initial states', states = &
      'sweep=states'
   type(key_type), parameter :: path_keys(*) = [ &
      key_type('clearance', most=1000000, low=clearance_key%low, high=clearance_key%high, &
      never='parameter=clearance', why='=: it is the parameter', unit='F0/K', &
      meaning='clearance d K/F0 (d is the whole travel of m), one number or one for each value'), &
      key_type('r', most=1000000, low=window_keys(1)%low, high=window_keys(1)%high, &
      may_miss=.true., never='parameter=r', why='=: it is the parameter', option='r-list', &
      unit='omega', meaning='frequency ratio at each value, if it changes with the parameter'), &
      key_type('parameter', a_word, words=parameter_words, takes=parameter_takes, &
      meaning='parameter that changes'), &
      key_type('list', least=2, most=1000000, may_miss=.true., takes='two or more increasing &
      &or decreasing numbers in the range of the parameter', unit=of_parameter, &
      meaning='values of the parameter, if they are not evenly spaced'), &
      key_type('low', never='list', takes=range_takes, option='values', &
      unit=of_parameter, meaning='first value of the parameter'), &
      key_type('high', over='low', never='list', takes=range_takes, option='values', &
      unit=of_parameter, meaning='last value of the parameter'), &
      key_type('values', a_whole, low=2.0_wp, high=1.0e6_wp, never='list', option='values', &
      meaning='number of values'), &
      key_type('spacing', a_word, default=spacing_key%default, words=spacing_key%words, &
      takes=spacing_key%takes, never='list', meaning='spacing of the values'), &
      key_type('sweep', a_word, default='''both''', words='up down both states', &
      meaning='up, down, both: the state is carried from value to value; states: each value starts &
      &anew from many states'), &
      key_type('states', a_whole, default='12', low=1.0_wp, high=1.0e6_wp, only=states, &
      meaning='initial states at each value, spread evenly')]

   type(key_type), parameter :: impact_keys(*) = [ &
      key_type('points', a_whole, default='100', low=1.0_wp, high=4096.0_wp, &
      meaning='impacts kept for each run and value'), &
      key_type('t', may_miss=.true., low=-most_state, high=most_state, never=states, &
      why=own, unit='1/omega', meaning=state_keys(1)%meaning), &
      key_type('x', may_miss=.true., low=-most_state, high=most_state, never=states, &
      why=own, option='state', unit='F0/K', meaning=state_keys(2)%meaning), &
      key_type('x_dot', may_miss=.true., low=-most_state, high=most_state, never=states, &
      why=own, option='state', unit='omega F0/K', meaning=state_keys(3)%meaning), &
      key_type('z', may_miss=.true., low=-most_state, high=most_state, never=states, &
      why=own, option='state', unit='F0/K', meaning=state_keys(4)%meaning), &
      key_type('z_dot', may_miss=.true., low=-most_state, high=most_state, never=states, &
      why=own, option='state', unit='omega F0/K', &
      meaning=state_keys(5)%meaning), load_key]

   type(column_type), parameter :: bifurcation_columns(*) = [ &
      column_type('runs', 'run', words, &
      meaning='direction of the sweep (up or down), or number of the initial state'), &
      column_type('values', 'value', label='=', unit='mixed', meaning='value of the parameter'), &
      column_type('values', 'r_along', listed=.false., &
      meaning='frequency ratio at each value, unless it is the parameter'), &
      column_type('values', 'clearance_along', unit='F0/K', listed=.false., &
      meaning='clearance at each value, unless it is the parameter'), &
      column_type('cells', 'label', words, &
      meaning='impacts / load cycles of the period; empty if none is confirmed'), &
      column_type('impacts', 'side', words, words='R,L', meaning='wall'), &
      column_type('impacts', 'phase', unit='rad', meaning='load phase within a load cycle'), &
      column_type('impacts', 'x', unit='F0/K', meaning='displacement of the primary mass'), &
      column_type('impacts', 'x_dot_before', unit='omega F0/K', &
      meaning='velocity of the primary mass before the impact'), &
      column_type('impacts', 'x_dot_after', unit='omega F0/K', &
      meaning='velocity of the primary mass after the impact'), &
      column_type('impacts', 'z_dot_before', unit='omega F0/K', &
      meaning='velocity of the free mass before the impact'), &
      column_type('impacts', 'z_dot_after', unit='omega F0/K', &
      meaning='velocity of the free mass after the impact'), &
      column_type('cells', 'cycles', wholes, listed=.false., &
      meaning='load cycles of the period; 0 if none is confirmed'), &
      column_type('cells', 'symbols', wholes, listed=.false., &
      meaning='impacts of a period, each accumulation counted as one'), &
      column_type('cells', 'impacts', wholes, listed=.false., meaning='impacts of a period'), &
      column_type('cells', 'rests', wholes, listed=.false., meaning='rests of a period'), &
      column_type('cells', 'x_min', unit='F0/K', listed=.false., &
      meaning='smallest displacement of the primary mass'), &
      column_type('cells', 'x_max', unit='F0/K', listed=.false., &
      meaning='greatest displacement of the primary mass'), &
      column_type('cells', 'status', wholes, listed=.false., &
      meaning='code of the failure; 0: none'), &
      column_type('windows', 'run', words, listed=.false., &
      meaning='run in which one period persists'), &
      column_type('windows', 'low', unit='mixed', listed=.false., &
      meaning='first value of the parameter'), &
      column_type('windows', 'high', unit='mixed', listed=.false., &
      meaning='last value of the parameter'), &
      column_type('windows', 'label', words, listed=.false., &
      meaning='impacts / load cycles of the period'), &
      column_type('windows', 'cut', truths, listed=.false., &
      meaning='whether it is next to a value that was not reached')]

   type(key_type), parameter :: structure_path_keys(*) = [ &
      key_type('parameter', a_word, takes=structure_takes, meaning='parameter that changes'), &
      key_type('low', never='list', meaning='first value of the parameter', &
      takes='a finite number', option='values'), &
      key_type('high', over='low', never='list', meaning='last value of the parameter', &
      takes='a finite number', option='values'), &
      key_type('label', a_word, may_miss=.true., only='parameter=function', takes='a word', &
      meaning='name of the parameter in tables and pictures')]

   type(key_type), parameter :: structure_impact_keys(*) = [ &
      key_type('points', a_whole, default='100', low=0.0_wp, high=4096.0_wp, &
      meaning='impacts kept at each value')]

   type(column_type), parameter :: structure_columns(*) = [ &
      column_type('strobes', 'q', unit='F0/K', each='coordinate', label='q_#', &
      meaning='coordinates at the beginning of a load cycle'), &
      column_type('strobes', 'q_dot', unit='omega F0/K', each='coordinate', label='q_dot_#', &
      meaning='velocities'), &
      column_type('strobes', 'outputs', unit='F0/K', each='output', label='#', &
      meaning='outputs at the beginning of a load cycle'), &
      column_type('impacts', 'gap', wholes, listed=.false., meaning='number of the gap, from 0'), &
      column_type('impacts', 'phase', unit='rad', listed=.false., &
      meaning='load phase within a load cycle'), &
      column_type('impacts', 'speed', unit='omega F0/K', listed=.false., &
      meaning='approach speed'), &
      column_type('impacts', 'kind', words, words=event_kinds, listed=.false., &
      meaning='kind of the event, only with stops or friction')]

contains

   !> Declares the study, with its keys and columns.
   pure subroutine declare_bifurcation(study, keys, columns)
      !> The study.
      type(study_type), intent(out), optional :: study
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) then
         call list_for(of_oscillator, path_keys, keys)
         call list_for(of_structure, structure_path_keys, keys)
         call list_for(of_structure, sweep_keys, keys)
         call list_for(every_model, [settling_key], keys)
         call list_for(every_model, [keep_key], keys)
         call list_for(of_oscillator, impact_keys, keys)
         call list_for(of_structure, start_keys(:2), keys)
         call list_for(every_model, [max_events_key], keys)
         call list_for(of_structure, structure_impact_keys, keys)
         call list_for(of_structure, function_keys, keys)
      end if
      if (present(columns)) then
         call list_for(of_oscillator, bifurcation_columns, columns)
         call list_for(of_structure, cell_columns, columns)
         call list_for(of_structure, structure_columns, columns)
      end if
      if (.not. present(study)) return
      study%name = 'bifurcation'
      study%meaning = 'sweep a parameter up and down, or from many states'
      study%row = [character(7) :: 'impacts', 'strobes']
      study%takes_elements = .true.
      study%takes_walls = .true.
      study%check => check_bifurcation
      study%memory => bifurcation_memory
      study%run => run_bifurcation
   end subroutine declare_bifurcation

   !> Checks the rules that involve several keys.
   subroutine check_bifurcation(case)
      !> The case; a state that is given in part is completed with zeros.
      type(case_type), intent(inout) :: case
      real(wp), allocatable :: clearance(:)
      integer :: runs, n, i

      if (case%model == of_structure) then
         call check_structure(case)
         return
      end if
      call check_parameter(case)
      associate (study => case%study)
         if (len(study%fault) > 0) return
         n = size(parameter_values(case))
         runs = merge(2, 1, study%is('sweep', 'both'))
         if (study%has('states')) runs = study%whole_number('states')
         call check_product(study, 'points', [n, runs, study%whole_number('points')], &
            'values x runs x points must be at most '//whole(most_numbers))
         call check_lists(case, n)
         if (.not. any([(study%has(trim(state_keys(i)%name)), i=1, 5)])) return
         do i = 1, 5
            if (.not. study%has(trim(state_keys(i)%name))) call &
               study%set(trim(state_keys(i)%name), &
               [0.0_wp])
         end do
         allocate (clearance, source=along(case, 'clearance', n))
         if (study%is('sweep', 'up')) clearance = clearance(1)
         if (study%is('sweep', 'down')) clearance = clearance(n)
         call check_start(study, min(clearance(1), clearance(n)))
      end associate
   end subroutine check_bifurcation

   !> Checks the keys that may have one number for each value.
   subroutine check_lists(case, n)
      !> The case.
      type(case_type), intent(inout) :: case
      !> Number of values of the parameter.
      integer, intent(in) :: n
      character(9), parameter :: names(2) = [character(9) :: 'clearance', 'r']
      real(wp), allocatable :: values(:)
      real(wp) :: xi
      integer :: i

      associate (study => case%study)
         do i = 1, 2
            if (.not. study%has(trim(names(i)))) cycle
            if (all(size(study%numbers(trim(names(i)))) /= [1, n])) call &
               study%refuse(trim(names(i)), 'one number, or '//whole(n)//', one for each value')
         end do
         if (.not. study%has('r')) return
         xi = case%osc%xi
         values = parameter_values(case)
         if (parameter_of(case) == 'xi') xi = values(1)
         if (any(at_resonance(xi, study%numbers('r')))) call study%refuse('r', resonance// &
            'among the values')
      end associate
   end subroutine check_lists

   !> The clearance or the frequency ratio at each value, as it is given.
   pure function along(case, name, n) result(values)
      !> The case.
      type(case_type), intent(in) :: case
      !> Name of the key.
      character(*), intent(in) :: name
      !> Number of values of the parameter.
      integer, intent(in) :: n
      real(wp) :: values(n)

      if (case%study%has(name)) then
         associate (given => case%study%numbers(name))
            values = given(1)
            if (size(given) == n) values = given
         end associate
      else if (name == 'r') then
         values = case%r
      else
         values = parameter_values(case)
      end if
   end function along

   !> Bytes for all runs and values, in the result too: of an oscillator three copies of the impacts
   !! kept and about 90 numbers each, of a structure the states and impacts.
   pure real(wp) function bifurcation_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case
      integer :: runs

      associate (s => case%study)
         if (case%model == of_structure) then
            bytes = 2.0_wp*value_count(s)*(48.0_wp*s%whole_number('keep')* &
               case%coordinates + 60.0_wp*s%whole_number('points') + 500)
         else
            runs = size(directions_of(case))
            bytes = (200.0_wp*s%whole_number('points') + 700)*size(parameter_values(case))*runs
         end if
      end associate
   end function bifurcation_memory

   !> Sweeps, or starts from many states at each value, and keeps the impacts after the transient.
   subroutine run_bifurcation(case, threads, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(cell_type), allocatable :: cells(:, :)
      real(wp), allocatable :: values(:)
      type(line_type), allocatable :: names(:), labels(:)
      integer, allocatable :: directions(:)
      integer :: impacts, windows, reached, lost, m, n, i, j

      if (case%model == of_structure) then
         call run_structure(case, result, progress)
         return
      end if
      allocate (values, source=parameter_values(case))
      allocate (directions, source=directions_of(case))
      m = size(values)
      n = size(directions)
      allocate (cells(m, n))
      call settle_runs(case, values, directions, threads, cells, progress)
      allocate (names(n), labels(m*n))
      do j = 1, n
         names(j)%text = run_name(directions, j)
         do i = 1, m
            labels((j - 1)*m + i)%text = label(cells(i, j))
         end do
      end do
      call result%open('runs', 'run', [n])
      call result%put_text('runs', 'run', names)
      call result%open('values', trim(parameter_of(case)), [m])
      call result%put('values', 'value', values)
      call result%put('values', 'r_along', along(case, 'r', m))
      call result%put('values', 'clearance_along', along(case, 'clearance', m))
      call result%open('cells', trim(parameter_of(case))//' run', [m, n])
      call result%put_text('cells', 'label', labels)
      call result%put('cells', 'cycles', [cells%cycles])
      call result%put('cells', 'symbols', [cells%symbols])
      call result%put('cells', 'impacts', [cells%impacts])
      call result%put('cells', 'rests', [cells%rests])
      call result%put('cells', 'x_min', [((cells(i, j)%extent(1, 1), i=1, m), j=1, n)])
      call result%put('cells', 'x_max', [((cells(i, j)%extent(1, 2), i=1, m), j=1, n)])
      call result%put('cells', 'status', [cells%status])
      call put_impacts(cells, result, impacts)
      call put_windows(values, directions, cells, result, windows)
      reached = count(cells%status /= stat%not_computed)
      if (reached < m*n) result%cut = whole(reached)//' of '//whole(m*n)// &
         ' simulations were reached'
      lost = reached - count(cells%status == stat%ok)
      result%empty = lost == reached
      if (.not. result%empty) call result%add_note(counted(n, &
         'run')//' of '//whole(m)//' values, '// &
         counted(impacts, 'impact')//', '//counted(windows, 'periodic window'))
      if (lost > 0) call result%fail(whole(lost)//' of '//counted(reached, 'simulation')// &
         ' failed: '//status_text(maxval(cells%status, cells%status /= stat%not_computed)))
   end subroutine run_bifurcation

   !> Simulates all runs.
   subroutine settle_runs(case, values, directions, threads, cells, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> The values of the parameter.
      real(wp), intent(in) :: values(:)
      !> (runs) As of `directions_of`.
      integer, intent(in) :: directions(:)
      !> Number of OpenMP threads.
      integer, intent(in) :: threads
      !> (values, runs) The motions on which the runs settle.
      type(cell_type), contiguous, intent(out) :: cells(:, :)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(pair_chains_type) :: runs
      type(cell_type) :: spare
      real(wp) :: c(6, size(values))
      integer :: i, j, m, n, place
      logical :: sweeps, tied

      m = size(values)
      n = size(directions)
      sweeps = any(directions /= 0)
      c(1, :) = along(case, 'r', m)
      c(2, :) = along(case, 'clearance', m)
      c(3:, :) = spread([case%osc%xi, case%osc%mu, case%osc%restitution], 2, m)
      call parameter_place(trim(parameter_of(case)), place, tied)
      c(place, :) = values
      if (tied) c(6, :) = values
      associate (s => case%study)
         ! runs with new states at each value are chains of one link, the values varying fastest
         runs = new_pair_chains(merge(m, 1, sweeps), merge(n, m*n, sweeps), s%number('load'), kick)
         runs%parameters = reshape(spread(c, 3, n), shape(runs%parameters))
         do j = 1, merge(n, 0, sweeps)
            if (directions(j) < 0) runs%parameters(:, :, j) = c(:, m:1:-1)
            runs%starts(:, j:j) = spread_states(case%osc, runs%parameters(1, 1, j), runs%load, &
               runs%parameters(2, 1, j), 1)
            if (s%has('t')) runs%starts(:, j) = state_of(s)
         end do
         do i = 1, merge(0, m, sweeps)
            runs%starts(:, i::m) = spread_states(case%osc, c(1, i), runs%load, c(2, i), n)
         end do
         call settle_chains(runs, examination_type(s%whole_number('settling'), &
            s%whole_number('keep'), s%whole_number('points'), s%whole_number('max_events'), &
            .false.), threads, cells, progress)
      end associate
      ! in rising order
      do j = 1, n
         do i = 1, merge(m/2, 0, directions(j) < 0)
            spare = cells(i, j)
            cells(i, j) = cells(m + 1 - i, j)
            cells(m + 1 - i, j) = spare
         end do
      end do
   end subroutine settle_runs

   !> Puts the impacts of all runs and values into the result.
   pure subroutine put_impacts(cells, result, n)
      !> (values, runs) The motions on which the runs settle.
      type(cell_type), intent(in) :: cells(:, :)
      !> In: with the tables of runs and values. Out: with the impacts.
      type(result_type), intent(inout) :: result
      !> Number of impacts.
      integer, intent(out) :: n
      integer, allocatable :: owners(:), sides(:)
      real(wp), allocatable :: impacts(:, :)
      character(*), parameter :: names(6) = [character(12) :: 'phase', 'x', 'x_dot_before', &
         'x_dot_after', 'z_dot_before', 'z_dot_after']
      integer :: i, j, first

      n = sum([((size(cells(i, j)%gaps), i=1, size(cells, 1)), j=1, size(cells, 2))])
      allocate (owners(n), sides(n), impacts(6, n))
      first = 0
      do j = 1, size(cells, 2)
         do i = 1, size(cells, 1)
            n = size(cells(i, j)%gaps)
            owners(first + 1:first + n) = (j - 1)*size(cells, 1) + i
            sides(first + 1:first + n) = merge(1, 2, cells(i, j)%gaps > 0)
            impacts(:, first + 1:first + n) = cells(i, j)%hits(2:, :)
            first = first + n
         end do
      end do
      n = first
      call result%open('impacts', 'impact', [n], 'cells', owners)
      call result%put('impacts', 'side', sides)
      do i = 1, size(names)
         call result%put('impacts', trim(names(i)), impacts(i, :))
      end do
   end subroutine put_impacts

   !> Puts the ranges of values over which each run has one period into the result, with remarks:
   !! first the ranges whose ends are known, then those next to values that were not reached.
   pure subroutine put_windows(values, directions, cells, result, windows)
      !> Values of the parameter.
      real(wp), intent(in) :: values(:)
      !> Direction of each run: 1 up, -1 down, 0 with new states at each value.
      integer, intent(in) :: directions(:)
      !> (values, runs) The motions on which the runs settle.
      type(cell_type), intent(in) :: cells(:, :)
      !> The result.
      type(result_type), intent(inout) :: result
      !> Number of ranges with known ends.
      integer, intent(out) :: windows
      type(line_type), allocatable :: runs(:), labels(:)
      integer, allocatable :: all_first(:), all_last(:), cut(:)
      integer :: first(size(values)), last(size(values)), i, j, n

      allocate (runs(0), labels(0), all_first(0), all_last(0), cut(0))
      do j = 1, size(directions)
         call find_windows(cells(:, j), first, last, n)
         do i = 1, n
            call append(runs, run_name(directions, j))
            call append(labels, label(cells(first(i), j)))
            cut = [cut, merge(1, 0, any(cells(max(1, first(i) - 1):min(last(i) + 1, &
               size(values)), j)%status == stat%not_computed))]
         end do
         all_first = [all_first, first(:n)]
         all_last = [all_last, last(:n)]
      end do
      do i = 1, size(cut)
         if (cut(i) == 0) call result%remark(runs(i)%text//': '//labels(i)%text//' from '// &
            exact(values(all_first(i)))//' to '//exact(values(all_last(i))))
      end do
      do i = 1, size(cut)
         if (cut(i) == 1) call result%remark(runs(i)%text//': '//labels(i)%text// &
            ' at least from '//exact(values(all_first(i)))//' to '// &
            exact(values(all_last(i)))//', next to values that were not reached')
      end do
      windows = count(cut == 0)
      call result%open('windows', 'window', [size(cut)])
      call result%put_text('windows', 'run', runs)
      call result%put('windows', 'low', values(all_first))
      call result%put('windows', 'high', values(all_last))
      call result%put_text('windows', 'label', labels)
      call result%put('windows', 'cut', cut)
   end subroutine put_windows

   !> The ranges of successive values over which a run keeps its period and its number of symbols.
   pure subroutine find_windows(cells, first, last, n)
      !> (values) What was found along the run.
      type(cell_type), intent(in) :: cells(:)
      !> (values) First and last value of each of the n windows; the rest is not set.
      integer, intent(out) :: first(:), last(:)
      !> Number of windows.
      integer, intent(out) :: n
      integer :: i
      logical :: goes_on

      n = 0
      goes_on = .false.
      do i = 1, size(cells)
         associate (last => cells(max(1, i - 1)))
            goes_on = goes_on .and. cells(i)%cycles == last%cycles .and. cells(i)%symbols == &
               last%symbols
         end associate
         if (.not. goes_on .and. cells(i)%cycles > 0) then
            n = n + 1
            first(n) = i
            goes_on = .true.
         end if
         if (goes_on) last(n) = i
      end do
   end subroutine find_windows

   !> The direction of each run: 1 up, -1 down, 0 with new states at each value.
   pure function directions_of(case) result(directions)
      !> The case, checked.
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

   !> The name of a run.
   pure function run_name(directions, j) result(text)
      !> Directions of all runs, and number of the run.
      integer, intent(in) :: directions(:), j
      character(len_trim(padded_name(directions, j))) :: text

      text = padded_name(directions, j)
   end function run_name

   !> The name of a run, padded with blanks.
   pure function padded_name(directions, j) result(text)
      !> Directions of all runs, and number of the run.
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

   !> Symbols and load cycles of a period as N/k; empty where no period is confirmed.
   pure function label(cell) result(text)
      !> The motion.
      type(cell_type), intent(in) :: cell
      character(merge(whole_width(cell%cycles) + whole_width(cell%symbols) + 1, 0, &
         cell%cycles > 0)) :: text

      if (cell%cycles > 0) text = whole(cell%symbols)//'/'//whole(cell%cycles)
   end function label

   !> Checks the rules that involve several keys.
   subroutine check_structure(case)
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
      call structure_path(case, path, message, bound)
      if (len(message) == 0) return
      if (bound > 0 .and. case%study%has('list')) then
         call case%study%refuse('list', message)
      else
         call case%study%refuse(trim(keys(bound)), message)
      end if
   end subroutine check_structure

   !> The structure and its load as functions of the parameter.
   subroutine structure_path(case, path, message, bound)
      !> The case.
      type(case_type), intent(in) :: case
      !> The path.
      type(structure_path_type), intent(out) :: path
      !> What is wrong with the parameter; empty if nothing is.
      character(:), allocatable, intent(out) :: message
      !> The bound that is wrong, 1 or 2; 0 if another key is.
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
   end subroutine structure_path

   !> Sweeps of a structure, from value to value.
   subroutine run_structure(case, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(structure_path_type) :: path
      type(cell_type), allocatable :: cells(:)
      character(:), allocatable :: message
      integer, allocatable :: order(:), owners(:)
      real(wp), allocatable :: outputs(:, :)
      integer :: bound, i, n

      n = case%coordinates
      call structure_path(case, path, message, bound)
      allocate (outputs, source=output_rows(case%system, n))
      ! outputs are given at the beginning of load cycles alone
      call run_sweep(case%study, path, case%study%whole_number('points'), .true., outputs(:0, :), &
         cells, order, result, progress)
      owners = [(spread(i, 1, size(cells(i)%strobes, 2)), i=1, size(cells))]
      call result%open('strobes', 'strobe', [size(owners)], 'cells', owners)
      call result%put('strobes', 'q', [(cells(i)%strobes(:n, :), i=1, size(cells))], n)
      call result%put('strobes', 'q_dot', [(cells(i)%strobes(n + 1:, :), i=1, size(cells))], n)
      if (size(outputs, 1) > 0) call result%put('strobes', 'outputs', [(matmul(outputs, &
         cells(i)%strobes(:n, :)), i=1, size(cells))], size(outputs, 1))
      owners = [(spread(i, 1, size(cells(i)%gaps)), i=1, size(cells))]
      call result%open('impacts', 'impact', [size(owners)], 'cells', owners)
      call result%put('impacts', 'gap', [(cells(i)%gaps - 1, i=1, size(cells))])
      call result%put('impacts', 'phase', [(cells(i)%hits(1, :), i=1, size(cells))])
      call result%put('impacts', 'speed', [(cells(i)%hits(2, :), i=1, size(cells))])
      if (any(path%structure%laws%kind > table_law)) call result%put('impacts', 'kind', &
         [(cells(i)%kinds, i=1, size(cells))])
   end subroutine run_structure

end module vi_bifurcation_study
