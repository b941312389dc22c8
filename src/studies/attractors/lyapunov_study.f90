!> The study &lyapunov: all Lyapunov exponents, at a point or along a line of points.
module vi_lyapunov_study
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_common_keys, only: check_parameter, check_start, clearance_key, load_key, &
      max_events_key, parameter_of, parameter_values, resonance, spacing_key, state_keys, &
      state_of, window_keys
   use vi_exponents, only: average_type, exponents_along, exponents_type
   use vi_forced_system, only: initial_state, new_forced_system
   use vi_kinds, only: two_pi, wp
   use vi_oscillator, only: at_resonance
   use vi_progress, only: add_expected_work, is_stopped
   use vi_simulated_pair, only: new_simulated_pair, simulated_pair_type
   use vi_simulated_structure, only: new_simulated_structure, simulated_structure_type
   use vi_status, only: stat, status_text
   use vi_structure, only: load_type, structure_type
   use vi_structure_gaps, only: start_fault
   use vi_structure_groups, only: load_frequency, most_coordinates, record_end, structure_of
   use vi_structure_keys, only: check_start_state, start_keys
   use vi_structure_run, only: new_run, run_type
   use vi_study, only: a_whole, a_word, case_type, column_type, every_model, key_type, list_for, &
      of_oscillator, of_parameter, of_structure, result_type, study_type, wholes
   use vi_text, only: counted, shown, whole
   implicit none (type, external)
   private

   public :: declare_lyapunov

   character(*), parameter :: with = 'parameter', range_takes = 'a number in the range of the &
      &parameter (1e-6 <= r <= 1e6, 1e-12 <= clearance <= 1e12)'
   !> The points of an oscillator, and its averages.
   type(key_type), parameter :: point_keys(*) = [ &
      key_type('clearance', most=1000000, low=clearance_key%low, high=clearance_key%high, &
      never='parameter=clearance', why='=: it is the parameter', unit='F0/K', &
      meaning='clearance d K/F0 (d is the whole travel of m), one number or one for each point'), &
      key_type('r', most=1000000, low=window_keys(1)%low, high=window_keys(1)%high, &
      may_miss=.true., never=with, option='r-list', unit='omega', &
      meaning='frequency ratios of points that are not evenly &
      &spaced on a line, one number or one for each point'), &
      key_type('shape', a_whole, most=3, low=1.0_wp, high=1.0e6_wp, may_miss=.true., only='r', &
      meaning='shape of the points as an array of two or three dimensions; the last index varies &
      &fastest'), &
      key_type('parameter', a_word, may_miss=.true., words='r clearance', &
      takes='''r'' or ''clearance'', with low, high and values', &
      option='-', meaning='parameter that varies along a line of points'), &
      key_type('low', only=with, option='-', unit=of_parameter, &
      meaning='first value of the parameter', &
      takes=range_takes), &
      key_type('high', only=with, over='low', option='-', unit=of_parameter, &
      meaning='last value of the parameter', &
      takes=range_takes), &
      key_type('values', a_whole, low=2.0_wp, high=1.0e6_wp, only=with, option='-', &
      meaning='number of values'), &
      key_type('spacing', a_word, default=spacing_key%default, words=spacing_key%words, &
      takes='''linear'' or ''geometric'' (of the values), with parameter', only=with, &
      meaning='spacing of the values'), &
      key_type('cycles', a_whole, default='10000', low=4.0_wp, high=1.0e9_wp, &
      takes='a whole number, 2 batches <= cycles <= 1e9', &
      meaning='load cycles averaged over'), &
      key_type('discard', a_whole, default='1000', low=0.0_wp, high=1.0e9_wp, &
      meaning='load cycles simulated before the average begins')]

   !> The averages of a structure.
   type(key_type), parameter :: structure_keys(*) = [ &
      key_type('cycles', a_whole, default='2000', low=4.0_wp, high=1.0e9_wp, &
      takes='a whole number, 2 batches <= cycles <= 1e9', &
      meaning='load cycles averaged over; units of time if the load has no frequency'), &
      key_type('discard', a_whole, default='300', low=0.0_wp, high=1.0e9_wp, &
      meaning='load cycles simulated before the average begins')]

   type(key_type), parameter :: further_keys(*) = [ &
      key_type('batches', a_whole, default='20', low=2.0_wp, high=1000.0_wp, &
      meaning='parts of the cycles whose scatter gives the standard errors'), &
      key_type('directions', a_whole, low=1.0_wp, high=2.0_wp*most_coordinates, may_miss=.true., &
      takes='a whole number, 1 <= directions <= 2n with n coordinates', &
      meaning='number of exponents, the greatest first; all 2n if it is left out', &
      model=of_structure), &
      max_events_key]

   type(column_type), parameter :: point_columns(*) = [ &
      column_type('points', 'r', meaning='frequency ratio'), &
      column_type('points', 'clearance', unit='F0/K', &
      meaning='clearance d K/F0; d is the whole travel of m between the walls'), &
      column_type('points', 'per_cycle', each='direction', label='exponent_#', &
      unit='1/load cycle', meaning='Lyapunov exponents per load cycle, the greatest first'), &
      column_type('points', 'error_per_cycle', each='direction', label='error_#', &
      unit='1/load cycle', meaning='standard errors of per_cycle'), &
      column_type('points', 'dimension', meaning='Kaplan-Yorke dimension'), &
      column_type('points', 'identity_error', unit='omega', &
      meaning='error of the sum of the exponents per unit of time (the sum is known from damping &
      &and impacts)'), &
      column_type('points', 'impacts', wholes, meaning='impacts in the cycles averaged over'), &
      column_type('points', 'rests', wholes, meaning='rests in the cycles averaged over'), &
      column_type('points', 'exponents', each='direction', unit='omega', listed=.false., &
      meaning='Lyapunov exponents per unit of time, the greatest first'), &
      column_type('points', 'standard_error', each='direction', unit='omega', listed=.false., &
      meaning='standard errors of exponents'), &
      column_type('points', 'status', wholes, listed=.false., &
      meaning='code of the failure; 0: none')]

   type(column_type), parameter :: structure_columns(*) = [ &
      column_type('exponents', 'number', wholes, meaning='number of the exponent'), &
      column_type('exponents', 'per_cycle', unit='1/load cycle', &
      meaning='Lyapunov exponent per load cycle (per unit of time if the load has no frequency), &
      &the greatest first'), &
      column_type('exponents', 'error_per_cycle', unit='1/load cycle', &
      meaning='standard error of per_cycle'), &
      column_type('exponents', 'exponent', unit='omega', &
      meaning='Lyapunov exponent per unit of time'), &
      column_type('exponents', 'standard_error', unit='omega', &
      meaning='standard error of exponent'), &
      column_type('run', 'dimension', listed=.false., &
      meaning='Kaplan-Yorke dimension; nan unless all 2n exponents are computed'), &
      column_type('run', 'identity_error', listed=.false., &
      meaning='error of the sum of all exponents per unit of time (known from damping and &
      &impacts); nan if some are missing, or with rest or stick'), &
      column_type('run', 'impacts', wholes, listed=.false., &
      meaning='impacts in the cycles averaged over; with stops or friction all events'), &
      column_type('run', 'rests', wholes, listed=.false., &
      meaning='rests in the cycles averaged over')]

contains

   !> Declares the study, with its keys and columns.
   pure subroutine declare_lyapunov(study, keys, columns)
      !> The study.
      type(study_type), intent(out), optional :: study
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) then
         call list_for(of_oscillator, point_keys, keys)
         call list_for(of_structure, structure_keys, keys)
         call list_for(every_model, further_keys(:2), keys)
         call list_for(of_oscillator, state_keys, keys)
         call list_for(of_oscillator, [load_key], keys)
         call list_for(of_structure, start_keys, keys)
         call list_for(every_model, further_keys(3:), keys)
      end if
      if (present(columns)) then
         call list_for(of_oscillator, point_columns, columns)
         call list_for(of_structure, structure_columns, columns)
      end if
      if (.not. present(study)) return
      study%name = 'lyapunov'
      study%meaning = 'compute all Lyapunov exponents at a point or along a line'
      study%row = [character(9) :: 'points', 'exponents']
      study%takes_elements = .true.
      study%takes_walls = .true.
      study%check => check_lyapunov
      study%memory => lyapunov_memory
      study%run => run_lyapunov
   end subroutine declare_lyapunov

   !> Checks the rules that involve several keys.
   subroutine check_lyapunov(case)
      !> The case.
      type(case_type), intent(inout) :: case

      associate (study => case%study)
         if (case%model == of_structure) then
            if (len(study%fault) == 0) call check_start_state(case)
            if (record_end(case) >= 0) call study%refuse('cycles', 'the load must be periodic or &
               &constant, not a record')
         else
            call check_parameter(case)
         end if
         if (len(study%fault) > 0) return
         if (study%whole_number('cycles') < 2*study%whole_number('batches')) call &
            study%refuse('cycles', 'batches is '//whole(study%whole_number('batches')))
         if (case%model == of_structure) then
            if (.not. study%has('directions')) call study%set('directions', [2.0_wp* &
               case%coordinates])
            if (study%whole_number('directions') > 2*case%coordinates) call &
               study%refuse('directions', 'the structure has '//counted( &
               case%coordinates, 'coordinate'))
            return
         end if
         call check_points(case)
         ! the clearance may vary from point to point: the smallest one counts
         if (study%has('clearance')) then
            call check_start(study, minval(study%numbers('clearance')))
         else
            call check_start(study, study%number('low'))
         end if
      end associate
   end subroutine check_lyapunov

   !> Checks that lists of points fit together.
   subroutine check_points(case)
      !> The case.
      type(case_type), intent(inout) :: case
      integer :: n

      n = count_points(case)
      associate (study => case%study)
         if (study%has('clearance')) then
            if (all(size(study%numbers('clearance')) /= [1, n])) call study%refuse('clearance', &
               'one number, or '//whole(n)//', one for each r')
         end if
         if (.not. study%has('r')) return
         if (all(size(study%numbers('r')) /= [1, n])) call study%refuse('r', 'one number, or '// &
            whole(n)//' as for clearance')
         if (any(at_resonance(case%osc%xi, study%numbers('r')))) call &
            study%refuse('r', resonance//'among the values')
         if (.not. study%has('shape')) return
         if (abs(product(study%numbers('shape')) - n) > 0) call study%refuse('shape', &
            'their product must be the number of points, '//whole(n))
      end associate
   end subroutine check_points

   !> Number of points.
   pure integer function count_points(case) result(n)
      !> The case.
      type(case_type), intent(in) :: case

      n = 1
      if (case%study%has('parameter')) then
         n = case%study%whole_number('values')
      else if (case%study%has('r')) then
         n = max(size(case%study%numbers('r')), size(case%study%numbers('clearance')))
      end if
   end function count_points

   !> The points of a line or a list, or the single point of the case.
   pure subroutine list_points(case, r, clearance)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> The points (n).
      real(wp), allocatable, intent(out) :: r(:), clearance(:)
      integer :: n

      n = count_points(case)
      allocate (r(n), source=case%r)
      allocate (clearance(n))
      associate (study => case%study)
         if (study%has('r')) call spread_out(study%numbers('r'), r)
         if (study%has('clearance')) call spread_out(study%numbers('clearance'), clearance)
      end associate
      if (parameter_of(case) == 'r') r = parameter_values(case)
      if (parameter_of(case) == 'clearance') clearance = parameter_values(case)
   end subroutine list_points

   !> One number for each point, or one for all.
   pure subroutine spread_out(given, values)
      !> The numbers of the case: one, or one for each point.
      real(wp), intent(in) :: given(:)
      !> The number at each point.
      real(wp), intent(out) :: values(:)

      values = given(1)
      if (size(given) == size(values)) values = given
   end subroutine spread_out

   !> Bytes for all points, about 100 numbers each; of a structure for its matrices and those that
   !! follow from them, and the batches.
   pure real(wp) function lyapunov_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case

      if (case%model == of_structure) then
         bytes = 800.0_wp*real(case%coordinates, wp)**2 + 16.0_wp*case%coordinates* &
            case%study%whole_number('batches')
      else
         bytes = 800.0_wp*count_points(case)
      end if
   end function lyapunov_memory

   !> Computes the exponents of a case.
   subroutine run_lyapunov(case, threads, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      real(wp), allocatable :: r(:), clearance(:), cycle_times(:, :), exponents(:, :), &
         deviations(:, :)
      type(exponents_type), allocatable :: found(:)
      integer, allocatable :: status(:), done(:)
      character(:), allocatable :: reason
      integer :: i, j, n, lost

      if (case%model == of_structure) then
         call run_structure(case, result, progress)
         return
      end if
      call list_points(case, r, clearance)
      n = size(r)
      allocate (found(n), status(n))
      associate (s => case%study)
         call add_expected_work(n*(s%whole_number('batches') + 1), progress)
         !$omp parallel do schedule(dynamic, 1) num_threads(threads)
         do j = 1, n
            status(j) = stat%not_computed
            if (.not. is_stopped(progress)) call exponents_at(case, r(j), clearance(j), found(j), &
               status(j), progress)
         end do
         !$omp end parallel do
      end associate
      ! only the points that were completed before a stop
      done = pack([(j, j=1, n)], status /= stat%not_computed)
      if (size(done) < n) result%cut = whole(size(done))//' of '//whole(n)//' points were reached'
      allocate (cycle_times, source=spread(two_pi/r(done), 1, 4))
      allocate (exponents, deviations, mold=cycle_times)
      do i = 1, size(done)
         exponents(:, i) = found(done(i))%exponents
         deviations(:, i) = found(done(i))%deviations
      end do
      call open_points(case, size(done), result)
      call result%put('points', 'r', r(done))
      call result%put('points', 'clearance', clearance(done))
      call result%put('points', 'per_cycle', [exponents*cycle_times])
      call result%put('points', 'error_per_cycle', [deviations*cycle_times])
      call result%put('points', 'dimension', found(done)%dimension)
      call result%put('points', 'identity_error', found(done)%error)
      call result%put('points', 'impacts', found(done)%impacts)
      call result%put('points', 'rests', found(done)%rests)
      call result%put('points', 'exponents', [exponents])
      call result%put('points', 'standard_error', [deviations])
      call result%put('points', 'status', status(done))
      n = size(done)
      lost = count(status(done) /= stat%ok)
      result%empty = lost == n
      if (.not. result%empty) call result%add_note(counted(n, 'point')//', '//whole(count( &
         exponents(1, :) > 3*deviations(1, :)))//' with a positive exponent')
      if (lost == 0) return
      status = status(done)
      j = findloc(status /= stat%ok, .true., 1)
      if (status(j) == stat%no_motion) then
         reason = 'no impacts in a batch'
      else
         reason = status_text(status(j))
      end if
      call result%fail('no exponents at '//whole(lost)//' of '//counted(n, 'point')//': '//reason)
   end subroutine run_lyapunov

   !> The exponents at a point; NaN where there are none.
   subroutine exponents_at(case, r, clearance, found, status, progress)
      !> The case.
      type(case_type), intent(in) :: case
      !> The point.
      real(wp), intent(in) :: r, clearance
      !> The exponents.
      type(exponents_type), intent(out) :: found
      !> As of `exponents_along`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(simulated_pair_type) :: motion

      associate (s => case%study, system => new_forced_system(case%osc, r, case%study%number( &
         'load'), clearance))
         motion = new_simulated_pair(system, initial_state(system, state_of(s)), &
            s%whole_number('max_events'))
         call exponents_along(motion, average_of(case), found, status, progress)
      end associate
      if (status == stat%ok) return
      found%dimension = ieee_value(r, ieee_quiet_nan)
      found%exponents = spread(found%dimension, 1, motion%dimensions)
      found%deviations = found%exponents
   end subroutine exponents_at

   !> How long to average.
   pure type(average_type) function average_of(case) result(average)
      !> The case.
      type(case_type), intent(in) :: case

      associate (s => case%study)
         average%batches = s%whole_number('batches')
         average%cycles = s%whole_number('cycles')/average%batches
         average%discard = s%whole_number('discard')
         if (s%has('directions')) average%directions = s%whole_number('directions')
      end associate
      average%work = 1
   end function average_of

   !> Opens the table of the points: a single point, a list, or an array.
   pure subroutine open_points(case, n, result)
      !> The case.
      type(case_type), intent(in) :: case
      !> Number of points that were computed.
      integer, intent(in) :: n
      !> The result.
      type(result_type), intent(inout) :: result
      character(*), parameter :: axes(3) = [character(23) :: 'point', 'point_1 point_0', &
         'point_2 point_1 point_0']

      if (len(result%cut) == 0 .and. case%study%has('shape')) then
         associate (shape => case%study%whole_numbers('shape'))
            call result%open('points', trim(axes(size(shape))), shape(size(shape):1:-1))
         end associate
      else if (n == 1 .and. .not. (case%study%has('r') .or. case%study%has('parameter'))) then
         call result%open('points', '', [integer ::])
      else
         call result%open('points', 'point', [n])
      end if
   end subroutine open_points

   !> Computes all exponents of a structure by one simulation.
   subroutine run_structure(case, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(structure_type) :: structure
      type(load_type) :: load
      type(run_type) :: run
      type(simulated_structure_type) :: motion
      type(average_type) :: average
      type(exponents_type) :: found
      character(:), allocatable :: cycle, text
      integer :: i, status

      call structure_of(case, structure, load)
      load%frequency = load_frequency(case)
      average = average_of(case)
      call add_expected_work(average%batches + 1, progress)
      call new_run(structure, load, run, status)
      associate (s => case%study)
         if (status == stat%ok) call new_simulated_structure(run, s%number('start'), &
            [s%numbers('q'), s%numbers('q_dot')], s%whole_number('max_events'), motion, status)
      end associate
      if (status == stat%ok) call exponents_along(motion, average, found, status, progress)
      result%empty = status /= stat%ok
      if (status == stat%not_computed) then
         result%cut = 'the simulation was stopped before its end'
      else if (status /= stat%ok) then
         call start_fault(structure, load, case%study%numbers('q'), status, text)
         call result%fail('no exponents: '//text)
      end if
      if (result%empty) return
      call result%open('exponents', 'direction', [average%directions])
      call result%put('exponents', 'number', [(i, i=1, average%directions)])
      call result%put('exponents', 'per_cycle', found%exponents*found%period)
      call result%put('exponents', 'error_per_cycle', found%deviations*found%period)
      call result%put('exponents', 'exponent', found%exponents)
      call result%put('exponents', 'standard_error', found%deviations)
      call result%open('run', '', [integer ::])
      call result%put('run', 'dimension', [found%dimension])
      call result%put('run', 'identity_error', [found%error])
      call result%put('run', 'impacts', [found%impacts])
      call result%put('run', 'rests', [found%rests])
      cycle = merge('load cycle  ', 'unit of time', load%frequency > 0)
      call result%add_note('greatest exponent '//shown(found%exponents(1)*found%period, 'f14.6')// &
         ' +- '//shown(found%deviations(1)*found%period, 'f14.6')//' per '//trim(cycle))
   end subroutine run_structure

end module vi_lyapunov_study
