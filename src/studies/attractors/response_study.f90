!> The study &response: the greatest displacement of the primary mass along the frequency ratio.
module vi_response_study
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_attractor_spread, only: spread_states
   use vi_chains, only: settle_chains
   use vi_common_keys, only: check_product, clearance_key, keep_key, max_events_key, most_numbers, &
      resonance, settling_key, window_keys
   use vi_kinds, only: wp
   use vi_oscillator, only: at_resonance, gain
   use vi_progress, only: add_done_work, add_expected_work, is_stopped
   use vi_simulated_motion, only: cell_type, examination_type
   use vi_simulated_pair, only: new_pair_chains, pair_chains_type
   use vi_spacing, only: even
   use vi_status, only: stat, status_text
   use vi_structure, only: load_type, structure_type
   use vi_structure_groups, only: load_frequency, output_rows, structure_of
   use vi_structure_keys, only: check_start_state, needs_frequency, start_keys
   use vi_structure_parameter, only: bounds_of
   use vi_structure_path, only: new_change, structure_path_type
   use vi_structure_settled, only: steady_size
   use vi_structure_sweep_tables, only: cell_columns, check_sweep, run_sweep, shares_of, &
      sweep_keys, value_count
   use vi_study, only: a_whole, case_type, column_type, every_model, key_type, list_for, &
      of_oscillator, of_structure, result_type, study_type, wholes
   use vi_text, only: counted, shown, whole
   implicit none (type, external)
   private

   public :: declare_response

   type(key_type), parameter :: response_keys(*) = [ &
      key_type('r', most=1000000, low=window_keys(1)%low, high=window_keys(1)%high, &
      may_miss=.true., option='r-list', unit='omega', &
      meaning='frequency ratios, if they are not evenly spaced'), &
      key_type('r_min', low=window_keys(1)%low, high=window_keys(1)%high, never='r', &
      option='r', unit='omega', meaning='first frequency ratio'), &
      key_type('r_max', low=window_keys(1)%low, high=window_keys(1)%high, over='r_min', never='r', &
      option='r', unit='omega', meaning='last frequency ratio'), &
      key_type('r_points', a_whole, low=2.0_wp, high=1.0e6_wp, never='r', option='r', &
      meaning='number of frequency ratios'), &
      key_type('clearance', most=1000000, low=clearance_key%low, high=clearance_key%high, &
      or='inverse_clearance', unit='F0/K', &
      meaning='clearance d K/F0 (d is the whole travel of m), one number or one for each r'), &
      key_type('inverse_clearance', most=1000000, low=1.0e-12_wp, high=1.0e12_wp, &
      or='clearance', unit='K/F0', meaning='F0/(d K), one number or one for each r'), &
      key_type('states', a_whole, default='24', low=1.0_wp, high=1.0e6_wp, &
      meaning='initial states at each frequency ratio, spread evenly'), &
      key_type('settling', a_whole, default='600', low=0.0_wp, high=1.0e7_wp, &
      meaning='load cycles simulated before the motion is examined')]

   type(key_type), parameter :: load_key = key_type('load', default='1', low=0.0_wp, &
      above=.true., high=1.0e12_wp, unit='F0', meaning='load amplitude')

   type(column_type), parameter :: response_columns(*) = [ &
      column_type('points', 'r', meaning='frequency ratio'), &
      column_type('points', 'clearance', unit='F0/K', &
      meaning='clearance d K/F0; d is the whole travel of m between the walls'), &
      column_type('points', 'lowest', &
      meaning='smallest max|X|/A of the attractors; nan if all simulations failed'), &
      column_type('points', 'highest', meaning='greatest max|X|/A of the attractors'), &
      column_type('runs', 'attenuation', meaning='max|X|/A', listed=.false.), &
      column_type('runs', 'cycles', wholes, listed=.false., &
      meaning='load cycles of the period; 0 if none is confirmed'), &
      column_type('runs', 'symbols', wholes, listed=.false., &
      meaning='impacts of a period, each accumulation counted as one'), &
      column_type('runs', 'impacts', wholes, listed=.false., meaning='impacts of a period'), &
      column_type('runs', 'rests', wholes, listed=.false., meaning='rests of a period'), &
      column_type('runs', 'status', wholes, listed=.false., meaning='code of the failure; 0: none')]

   type(key_type), parameter :: structure_keys(*) = [ &
      key_type('low', low=0.0_wp, above=.true., never='list', option='values', &
      meaning='first circular frequency of the load'), &
      key_type('high', low=0.0_wp, over='low', never='list', option='values', &
      meaning='last circular frequency of the load')]

   type(column_type), parameter :: structure_columns(*) = [ &
      column_type('cells', 'largest', unit='F0/K', each='coordinate', label='largest_#', &
      meaning='greatest magnitude of each coordinate'), &
      column_type('cells', 'rms', unit='F0/K', each='coordinate', label='rms_#', &
      meaning='root mean square of each coordinate'), &
      column_type('cells', 'steady_largest', unit='F0/K', each='coordinate', &
      label='steady_largest_#', &
      meaning='greatest magnitude of the steady motion without impacts, stops and friction; nan if &
      &there is none'), &
      column_type('cells', 'steady_rms', unit='F0/K', each='coordinate', label='steady_rms_#', &
      meaning='root mean square of the steady motion without impacts'), &
      column_type('cells', 'output_largest', unit='F0/K', each='output', label='largest_#', &
      meaning='greatest magnitude of each output'), &
      column_type('cells', 'output_rms', unit='F0/K', each='output', label='rms_#', &
      meaning='root mean square of each output'), &
      column_type('cells', 'steady_output_largest', unit='F0/K', each='output', &
      label='steady_largest_#', &
      meaning='greatest magnitude of each output in the steady motion without impacts'), &
      column_type('cells', 'steady_output_rms', unit='F0/K', each='output', label='steady_rms_#', &
      meaning='root mean square of each output in the steady motion without impacts'), &
      column_type('cells', 'output_min', unit='F0/K', each='output', listed=.false., &
      meaning='smallest value of each output'), &
      column_type('cells', 'output_max', unit='F0/K', each='output', listed=.false., &
      meaning='greatest value of each output'), &
      column_type('cells', 'q_min', unit='F0/K', each='coordinate', listed=.false., &
      meaning='smallest value of each coordinate'), &
      column_type('cells', 'q_max', unit='F0/K', each='coordinate', listed=.false., &
      meaning='greatest value of each coordinate')]

contains

   !> Declares the study, with its keys and columns.
   pure subroutine declare_response(study, keys, columns)
      !> The study.
      type(study_type), intent(out), optional :: study
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) then
         call list_for(of_oscillator, response_keys, keys)
         call list_for(of_structure, structure_keys, keys)
         call list_for(of_structure, sweep_keys, keys)
         call list_for(of_structure, [settling_key], keys)
         call list_for(every_model, [keep_key], keys)
         call list_for(of_oscillator, [load_key], keys)
         call list_for(of_structure, start_keys(:2), keys)
         call list_for(every_model, [max_events_key], keys)
      end if
      if (present(columns)) then
         call list_for(of_oscillator, response_columns, columns)
         call list_for(of_structure, cell_columns, columns)
         call list_for(of_structure, structure_columns, columns)
      end if
      if (.not. present(study)) return
      study%name = 'response'
      study%meaning = 'compute the amplitude of settled motions against the load frequency'
      study%row = [character(6) :: 'points', 'cells']
      study%takes_elements = .true.
      study%takes_walls = .true.
      study%check => check_response
      study%memory => response_memory
      study%run => run_response
   end subroutine declare_response

   !> Checks the rules that involve several keys.
   subroutine check_response(case)
      !> The case.
      type(case_type), intent(inout) :: case
      character(:), allocatable :: key
      integer :: n

      associate (study => case%study)
         if (len(study%fault) > 0) return
         if (case%model == of_structure) then
            call check_start_state(case)
            key = trim(merge('list', 'low ', study%has('list')))
            call needs_frequency(case, key)
            call check_sweep(study, case%coordinates)
            if (study%has('list')) then
               if (.not. all(study%numbers('list') > 0)) call study%refuse('list')
            end if
            return
         end if
         n = size(r_values(case))
         key = trim(merge('r    ', 'r_min', study%has('r')))
         if (any(at_resonance(case%osc%xi, r_values(case)))) call study%refuse(key, resonance// &
            'among the values')
         key = trim(clearance_name(case))
         if (all(size(study%numbers(key)) /= [1, n])) call study%refuse(key, 'one number, or '// &
            whole(n)//', one for each r')
         call check_product(study, 'states', [n, study%whole_number('states')], &
            'r_points x states must be at most '//whole(most_numbers))
      end associate
   end subroutine check_response

   !> The frequency ratios.
   pure function r_values(case) result(r)
      !> The case.
      type(case_type), intent(in) :: case
      real(wp), allocatable :: r(:)

      if (case%study%has('r')) then
         r = case%study%numbers('r')
      else
         r = even(case%study%number('r_min'), case%study%number('r_max'), &
            case%study%whole_number('r_points'))
      end if
   end function r_values

   !> The key that gives the clearance or its inverse, padded with blanks.
   pure function clearance_name(case) result(name)
      !> The case.
      type(case_type), intent(in) :: case
      character(17) :: name

      name = merge('clearance        ', 'inverse_clearance', case%study%has('clearance'))
   end function clearance_name

   !> The clearance at each frequency ratio.
   pure function clearance_values(case, n) result(clearance)
      !> The case.
      type(case_type), intent(in) :: case
      !> Number of frequency ratios.
      integer, intent(in) :: n
      real(wp) :: clearance(n)

      associate (given => case%study%numbers(trim(clearance_name(case))))
         clearance = given(1)
         if (size(given) == n) clearance = given
      end associate
      if (case%study%has('inverse_clearance')) clearance = 1/clearance
   end function clearance_values

   !> Bytes for all simulations, about 120 numbers each, or for all values of a structure, in the
   !! result too.
   pure real(wp) function response_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case

      associate (s => case%study)
         if (case%model == of_structure) then
            bytes = 2.0_wp*value_count(s)*(48.0_wp*s%whole_number('keep')* &
               case%coordinates + 500)
         else
            bytes = 1000.0_wp*size(r_values(case))*s%whole_number('states')
         end if
      end associate
   end function response_memory

   !> Finds max|X|/A of the attractors at each frequency ratio, and its least and greatest value.
   subroutine run_response(case, threads, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(cell_type), allocatable :: cells(:, :)
      real(wp), allocatable :: r(:), clearance(:), attenuation(:, :), envelope(:, :)
      integer, allocatable :: done(:)
      integer :: n, states, lost, i, j

      if (case%model == of_structure) then
         call run_structure(case, threads, result, progress)
         return
      end if
      allocate (r, source=r_values(case))
      n = size(r)
      states = case%study%whole_number('states')
      allocate (clearance, source=clearance_values(case, n))
      call simulate_states(case, r, clearance, threads, cells, progress)
      ! only the points that were completed before a stop
      done = pack([(i, i=1, n)], all(cells%status /= stat%not_computed, 1))
      if (size(done) < n) result%cut = whole(size(done))//' of '//whole(n)//' points were reached'
      n = size(done)
      allocate (attenuation(states, n), envelope(2, n), source=ieee_value(1.0_wp, ieee_quiet_nan))
      do i = 1, n
         associate (these => cells(:, done(i)), each => attenuation(:, i), size_alone => &
            case%study%number('load')*gain(case%osc%xi, r(done(i))))
            do j = 1, states
               if (these(j)%status == stat%ok) each(j) = max(-these(j)%extent(1, 1), &
                  these(j)%extent(1, 2))/size_alone
            end do
            if (any(these%status == stat%ok)) envelope(:, i) = [minval(each, these%status == &
               stat%ok), maxval(each, these%status == stat%ok)]
         end associate
      end do
      call result%open('points', 'r', [n])
      call result%put('points', 'r', r(done))
      call result%put('points', 'clearance', clearance(done))
      call result%put('points', 'lowest', envelope(1, :))
      call result%put('points', 'highest', envelope(2, :))
      call result%open('runs', 'state r', [states, n])
      call result%put('runs', 'attenuation', [attenuation])
      call result%put('runs', 'cycles', [cells(:, done)%cycles])
      call result%put('runs', 'symbols', [cells(:, done)%symbols])
      call result%put('runs', 'impacts', [cells(:, done)%impacts])
      call result%put('runs', 'rests', [cells(:, done)%rests])
      call result%put('runs', 'status', [cells(:, done)%status])
      associate (good => cells(:, done)%status == stat%ok)
         lost = count(.not. good)
         result%empty = lost == n*states
         if (.not. result%empty) call result%add_note('max|X|/A from '// &
            shown(minval(attenuation, good), 'f12.4')//' to '//shown(maxval(attenuation, good), &
            'f12.4')//' at '//counted(n, 'point'))
      end associate
      if (lost > 0) call result%fail(whole(lost)//' of '//counted(n*states, 'simulation')// &
         ' failed: '//status_text(maxval(cells(:, done)%status)))
   end subroutine run_response

   !> The motions on which evenly spread states settle at each frequency ratio.
   subroutine simulate_states(case, r, clearance, threads, cells, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> (n) each
      real(wp), intent(in) :: r(:), clearance(:)
      !> Number of OpenMP threads.
      integer, intent(in) :: threads
      !> (states, n) What was found.
      type(cell_type), allocatable, intent(out) :: cells(:, :)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(pair_chains_type) :: each
      integer :: i, states

      associate (s => case%study, osc => case%osc)
         states = s%whole_number('states')
         allocate (cells(states, size(r)))
         each = new_pair_chains(1, size(cells), s%number('load'), 0.0_wp)
         do i = 1, size(r)
            each%parameters(:, 1, (i - 1)*states + 1:i*states) = spread([r(i), clearance(i), &
               osc%xi, osc%mu, osc%restitution], 2, states)
            each%starts(:, (i - 1)*states + 1:i*states) = spread_states(osc, r(i), each%load, &
               clearance(i), states)
         end do
         call settle_chains(each, examination_type(s%whole_number('settling'), &
            s%whole_number('keep'), 0, s%whole_number('max_events'), .false.), threads, cells, &
            progress)
      end associate
   end subroutine simulate_states

   !> Sweeps of a structure.
   subroutine run_structure(case, threads, result, progress)
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
      real(wp), allocatable :: largest(:, :), outputs(:, :), rms(:, :), shares(:)
      integer, allocatable :: order(:)
      integer :: i, k, m, n

      call structure_of(case, structure, load)
      load%frequency = load_frequency(case)
      path%structure = structure
      path%load = load
      allocate (path%changes(1))
      associate (s => case%study)
         call new_change('frequency', bounds_of(s, ''), structure, load, path%changes(1), message)
         n = case%coordinates
         allocate (shares, source=shares_of(s))
         m = size(shares)
         allocate (outputs, source=output_rows(case%system, n))
         k = n + size(outputs, 1)
         allocate (largest(k, m), rms(k, m), source=0.0_wp)
         call add_expected_work(m, progress)
         !$omp parallel do schedule(dynamic, 1) num_threads(threads)
         do i = 1, m
            if (is_stopped(progress)) cycle  ! and the sweep, which is next, reaches no value
            call steady_size(path, shares(i), outputs, largest(:, i), rms(:, i))
            call add_done_work(1, progress)
         end do
         !$omp end parallel do
         call run_sweep(s, path, 0, .false., outputs, cells, order, result, progress)
      end associate
      call put_sizes('', 1, n)
      if (k > n) call put_sizes('output_', n + 1, k)

   contains

      !> Puts the sizes of coordinates or outputs.
      subroutine put_sizes(prefix, first, last)
         !> What the names of the columns begin with; q_min and q_max are of coordinates.
         character(*), intent(in) :: prefix
         !> The first one and the last one.
         integer, intent(in) :: first, last
         character(:), allocatable :: of

         of = 'q_'
         if (len(prefix) > 0) of = prefix
         associate (m => last - first + 1)
            call result%put('cells', prefix//'largest', [(max(abs(cells(i)%extent(first:last, 1)), &
               cells(i)%extent(first:last, 2)), i=1, size(cells))], m)
            call result%put('cells', prefix//'rms', [(cells(i)%extent(first:last, 3), &
               i=1, size(cells))], m)
            call result%put('cells', 'steady_'//prefix//'largest', [largest(first:last, order)], m)
            call result%put('cells', 'steady_'//prefix//'rms', [rms(first:last, order)], m)
            call result%put('cells', of//'min', [(cells(i)%extent(first:last, 1), &
               i=1, size(cells))], m)
            call result%put('cells', of//'max', [(cells(i)%extent(first:last, 2), &
               i=1, size(cells))], m)
         end associate
      end subroutine put_sizes

   end subroutine run_structure

end module vi_response_study
