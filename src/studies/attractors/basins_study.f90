!> The study &basins: the attractor that each initial state approaches.
module vi_basins_study
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
   use vi_attractor_basin, only: event_limited, not_reached
   use vi_attractor_integrity, only: largest_disc, uncertain_pairs, uncertainty_exponent
   use vi_attractor_known, only: ball, known_type, no_impacts, periodic, repeating, resting
   use vi_attractor_list, only: attractor_list_type, label_states
   use vi_attractor_spread, only: random_states
   use vi_basin_tables, only: check_uneven, find_shares, is_even, open_states, plane_sizes, &
      plane_values, set_axes, tell_apart, uneven_keys
   use vi_common_keys, only: clearance_key, half_gap, load_key, max_events_key, &
      most_numbers, most_state, state_keys
   use vi_forced_system, only: new_forced_system
   use vi_free_states, only: check_settling, find_pace, is_free, settle_free_states
   use vi_kinds, only: wp
   use vi_pattern, only: starred_symbols
   use vi_progress, only: is_stopped
   use vi_settled_states, only: chaotic, outcome_type, quasi_periodic, settle_states, settling_type
   use vi_status, only: stat, status_text
   use vi_structure, only: load_type, structure_type
   use vi_structure_find, only: random_structure_states
   use vi_structure_found, only: found_columns, found_list_type, put_found
   use vi_structure_groups, only: load_frequency, structure_of
   use vi_structure_keys, only: check_start_state, needs_frequency, place_in_state, start_keys
   use vi_structure_return, only: settled_type
   use vi_study, only: a_whole, a_word, case_type, column_type, every_model, key_type, list_for, &
      of_axes, of_axis, of_oscillator, of_state, of_structure, result_type, study_type, &
      values_type, wholes, words
   use vi_text, only: counted, exact, exact_list, line_type, shown, whole
   implicit none (type, external)
   private

   public :: declare_basins

   !> Coordinates of a state; y is z - x.
   character(5), parameter :: axis_names(5) = [character(5) :: 't', 'x', 'x_dot', 'y', &
      'z_dot']

   character(*), parameter :: beside = 'states list', random = ': it applies only to a plane', &
      even_steps = ': it applies only to a plane with even steps', listed = beside//' &
      &first_values', &
      structure_listed = 'states first_values'
   character(*), parameter :: ordered = 'two or more increasing or decreasing numbers from -1e100 &
      &to 1e100', along_axis(2) = [character(70) :: &
      'values along the first axis, if they are not evenly spaced', &
      'values along the second axis, if either axis is not evenly spaced']
   type(key_type), parameter :: first_keys(*) = [ &
      key_type('states', a_whole, may_miss=.true., low=1.0_wp, high=real(most_numbers, wp), &
      meaning='number of random states, instead of a plane'), &
      key_type('list', least=5, most=5*most_numbers, may_miss=.true., never='states', &
      low=-most_state, high=most_state, &
      takes='numbers from -1e100 to 1e100: t, x, x_dot, z and z_dot of each state', unit=of_state, &
      meaning='t, x, x_dot, z and z_dot of each state, instead of a plane', &
      model=of_oscillator), &
      key_type('seed', a_whole, default='0', low=0.0_wp, high=real(huge(1), wp), only='states', &
      meaning='seed of the random states')]

   !> The plane of an oscillator, and how its attractors are found.
   type(key_type), parameter :: basins_keys(*) = [ &
      key_type('axes', a_word, least=2, most=2, words='x x_dot y z_dot t', never=beside, &
      why=random, takes='two of ''x'', ''x_dot'', ''y'' (z - x), ''z_dot'' and ''t'', or states = &
      &N instead of a plane', option='plane', meaning='axes of the plane of initial states'), &
      key_type('low', least=2, most=2, low=-most_state, high=most_state, &
      never=listed, why=even_steps, &
      takes='two numbers from -1e100 to 1e100, one for each axis', option='plane', &
      unit=of_axes, meaning='first value along each axis'), &
      key_type('high', least=2, most=2, low=-most_state, high=most_state, &
      over='low', never=listed, why=even_steps, &
      takes='two numbers from -1e100 to 1e100, one for each axis', option='plane', &
      unit=of_axes, meaning='last value along each axis'), &
      key_type('values', a_whole, least=2, most=2, low=2.0_wp, high=1.0e5_wp, never=listed, &
      why=even_steps, &
      takes='two whole numbers, one for each axis, each with 2 <= values <= 100000', &
      option='plane', meaning='number of values along each axis'), &
      key_type('first_values', least=2, most=100000, may_miss=.true., low=-most_state, &
      high=most_state, only='axes', takes=ordered, unit=of_axis(1), meaning=along_axis(1)), &
      key_type('second_values', least=2, most=100000, may_miss=.true., low=-most_state, &
      high=most_state, only='first_values', takes=ordered, unit=of_axis(2), &
      meaning=along_axis(2)), &
      key_type('t', default='0', low=-most_state, high=most_state, &
      never=beside, why=random, unit='1/omega', meaning='time, unless it is an axis'), &
      key_type('x', default='0', low=-most_state, high=most_state, &
      never=beside, why=random, unit='F0/K', &
      meaning='displacement of the primary mass, unless it is an axis'), &
      key_type('x_dot', default='0', low=-most_state, high=most_state, &
      never=beside, why=random, unit='omega F0/K', &
      meaning='velocity of the primary mass, unless it is an axis'), &
      key_type('y', default='0', low=-most_state, high=most_state, &
      never=beside, why=random, unit='F0/K', &
      meaning='z - x, unless it is an axis'), &
      key_type('z_dot', default='0', low=-most_state, high=most_state, &
      never=beside, why=random, unit='omega F0/K', &
      meaning='velocity of the free mass, unless it is an axis'), &
      key_type('cycles', a_whole, default='1000', low=1.0_wp, high=1.0e7_wp, &
      meaning='load cycles after which an undecided state is examined again'), &
      key_type('probes', a_whole, default='200', low=1.0_wp, high=1.0e6_wp, &
      meaning='states simulated first to find attractors')]

   type(key_type), parameter :: max_cycles_key = key_type('max_cycles', a_whole, default='16', &
      low=1.0_wp, high=100.0_wp, meaning='longest period considered, in load cycles')

   type(column_type), parameter :: state_columns(*) = [ &
      column_type('states', 't', unit='1/omega', meaning='time of the initial state'), &
      column_type('states', 'x', unit='F0/K', meaning='displacement of the primary mass'), &
      column_type('states', 'x_dot', unit='omega F0/K', meaning='velocity of the primary mass'), &
      column_type('states', 'z', unit='F0/K', meaning='displacement of the free mass'), &
      column_type('states', 'z_dot', unit='omega F0/K', meaning='velocity of the free mass')]

   type(column_type), parameter :: attractor_columns(*) = [ &
      column_type('first', 'place', label='=', unit='mixed', listed=.false., &
      meaning='along the first axis'), &
      column_type('second', 'place', label='=', unit='mixed', listed=.false., &
      meaning='along the second axis'), &
      column_type('attractors', 'kind', words, listed=.false., meaning='kind'), &
      column_type('attractors', 'cycles', wholes, listed=.false., &
      meaning='load cycles of the period; 0 if there is none'), &
      column_type('attractors', 'growth', listed=.false., &
      meaning='greatest modulus of the multipliers, or largest exponent per load cycle'), &
      column_type('attractors', 'radius', unit='mixed', listed=.false., &
      meaning='radius, in the norm of this attractor, of the neighbourhood in which states are &
      &assigned to it; 0: none'), &
      column_type('attractors', 'contraction', listed=.false., &
      meaning='factor by which the derivative over a period contracts in that norm'), &
      column_type('attractors', 'state', each='coordinate', unit='mixed', listed=.false., &
      meaning='a state on it: t, x, x_dot, z, z_dot'), &
      column_type('attractors', 'disc_radius', unit='mixed', listed=.false., &
      meaning='radius of the largest disc in the plane inside the basin'), &
      column_type('attractors', 'disc_centre', each='axis', unit='mixed', listed=.false., &
      meaning='centre of that disc along both axes'), &
      column_type('pairs', 'distance', listed=.false., &
      meaning='distance between the states of a pair along an axis, in cells of the plane'), &
      column_type('pairs', 'uncertain', listed=.false., &
      meaning='share of the pairs whose states end on different attractors'), &
      column_type('run', 'events', listed=.false., meaning='events simulated to decide'), &
      column_type('run', 'uncertainty_exponent', listed=.false., meaning='exponent a: the share of &
      &pairs with different attractors is ~ distance**a; nan without a boundary')]

   type(column_type), parameter :: shared_columns(*) = [ &
      column_type('states', 'label', wholes, &
      meaning='number of its attractor; -1 not decided, -2 not reached, -3 not decided before &
      &max_events, -4 a gap is closed there'), &
      column_type('states', 'attractor', words, meaning='name of its attractor'), &
      column_type('attractors', 'name', words, label='=', listed=.false., &
      meaning='sides or impacts and load cycles of a periodic motion, or the kind of the &
      &attractor'), &
      column_type('attractors', 'fraction', listed=.false., &
      meaning='share of the states that were reached and have no closed gap'), &
      column_type('attractors', 'standard_error', listed=.false., &
      meaning='standard error of the fraction')]

   character(14), parameter :: kinds(6) = [character(14) :: 'periodic', 'rest', 'quasi-periodic', &
      'chaotic', 'no impacts', 'periodic?']

   !> The plane of a structure.
   character(*), parameter :: axes_taken = 'two of ''q_0'', &
      &''q_1'', ... (coordinates, from 0) and ''q_dot_0'', ''q_dot_1'', ... (velocities), or &
      &states = N instead of a plane'
   type(key_type), parameter :: structure_keys(*) = [ &
      key_type('axes', a_word, least=2, most=2, never='states', why=random, takes=axes_taken, &
      option='plane', meaning='axes of the plane of initial states'), &
      key_type('low', least=2, most=2, low=-most_state, high=most_state, never=structure_listed, &
      why=even_steps, takes='two numbers from -1e100 to 1e100, one for each axis', option='plane', &
      meaning='first value along each axis'), &
      key_type('high', least=2, most=2, low=-most_state, high=most_state, over='low', &
      never=structure_listed, why=even_steps, &
      takes='two numbers from -1e100 to 1e100, one for each axis', option='plane', &
      meaning='last value along each axis'), &
      key_type('values', a_whole, least=2, most=2, low=2.0_wp, high=1.0e5_wp, &
      never=structure_listed,       why=even_steps, &
      takes='two whole numbers, one for each axis, each with 2 <= values <= 100000', &
      option='plane', meaning='number of values along each axis'), &
      key_type('first_values', least=2, most=100000, may_miss=.true., low=-most_state, &
      high=most_state, only='axes', takes=ordered, meaning=along_axis(1)), &
      key_type('second_values', least=2, most=100000, may_miss=.true., low=-most_state, &
      high=most_state, only='first_values', takes=ordered, &
      meaning=along_axis(2)), &
      start_keys, &
      key_type('settling', a_whole, default='1000', low=0.0_wp, high=1.0e6_wp, &
      meaning='load cycles simulated before the search for a motion, unless it repeats to rounding &
      &earlier; without a periodic load natural periods, more if needed')]

   !> Labels of states without an attractor.
   integer, parameter :: undecided = 0, closed = -3
   character(14), parameter :: other_names(0:3) = [character(14) :: 'no impacts', 'chaotic', &
      'quasi-periodic', 'permanent rest']

   type(column_type), parameter :: structure_state_columns(*) = [ &
      column_type('states', 'q', unit='F0/K', each='coordinate', label='q_#', &
      meaning='coordinates of the initial state'), &
      column_type('states', 'q_dot', unit='omega F0/K', each='coordinate', label='q_dot_#', &
      meaning='velocities')]

   type(column_type), parameter :: structure_attractor_columns(*) = [ &
      column_type('first', 'place', label='=', listed=.false., meaning='along the first axis'), &
      column_type('second', 'place', label='=', listed=.false., meaning='along the second axis'), &
      column_type('attractors', 'number', wholes, listed=.false., &
      meaning='its number among the motions, from 0; -1 if it is not periodic or has no impacts')]

contains

   !> Declares the study, with its keys and columns.
   pure subroutine declare_basins(study, keys, columns)
      !> The study.
      type(study_type), intent(out), optional :: study
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) then
         call list_for(of_oscillator, [clearance_key], keys)
         call list_for(every_model, first_keys, keys)
         call list_for(of_oscillator, basins_keys, keys)
         call list_for(of_structure, structure_keys, keys)
         call list_for(every_model, [max_cycles_key], keys)
         call list_for(of_oscillator, [load_key], keys)
         call list_for(every_model, [max_events_key], keys)
      end if
      if (present(columns)) then
         call list_for(of_oscillator, state_columns, columns)
         call list_for(of_structure, structure_state_columns, columns)
         call list_for(every_model, shared_columns, columns)
         call list_for(of_oscillator, attractor_columns, columns)
         call list_for(of_structure, structure_attractor_columns, columns)
         call list_for(of_structure, found_columns, columns)
         ! the CSV has a row for each state, not for each impact
         columns(size(columns) - size(found_columns) + 1:)%listed = .false.
      end if
      if (.not. present(study)) return
      study%name = 'basins'
      study%meaning = 'find the attractors at a point and the basin of each'
      study%row = 'states'
      study%takes_elements = .true.
      study%takes_walls = .true.
      study%check => check_basins
      study%memory => basins_memory
      study%run => run_basins
   end subroutine declare_basins

   !> Checks the rules that involve several keys.
   subroutine check_basins(case)
      !> The case; coordinates that are axes lose their values.
      type(case_type), intent(inout) :: case
      real(wp), allocatable :: axis(:)
      character(13) :: names(2)
      integer :: i

      if (case%model == of_structure) then
         call check_structure(case)
         return
      end if
      associate (study => case%study)
         if (study%has('list')) call check_list(study)
         if (len(study%fault) > 0 .or. .not. study%has('axes')) return
         if (study%word('axes', 1) == study%word('axes', 2)) call study%refuse('axes')
         call check_uneven(study)
         if (len(study%fault) > 0) return
         do i = 1, 2
            if (study%word('axes', i) /= 'y') cycle
            axis = plane_values(study, i)
            names = [character(13) :: 'low', 'high']
            if (.not. is_even(study)) names = uneven_keys(i)
            if (-axis(1) > reach(study)) call study%refuse(trim(names(1)), &
               'y must be within half the clearance')
            if (axis(size(axis)) > reach(study)) call study%refuse(trim(names(2)), &
               'y must be within half the clearance')
         end do
         do i = 1, 2
            call study%forbid(trim(study%word('axes', i)), ': it is an axis')
            call study%drop(trim(study%word('axes', i)))
         end do
         if (.not. study%has('y')) return
         if (abs(study%number('y')) > reach(study)) call study%refuse('y', &
            'y must be within half the clearance')
      end associate
   end subroutine check_basins

   !> Checks a list of states.
   subroutine check_list(study)
      !> The group.
      type(values_type), intent(inout) :: study
      real(wp), allocatable :: list(:)
      integer :: n, i, status

      if (len(study%fault) > 0) return
      ! without room for copies there is none for the states, which the estimate of memory reports
      allocate (list(3*study%count_numbers()), stat=status)
      if (status /= 0) return
      deallocate (list)
      list = study%numbers('list')
      n = size(list)/5
      i = 0
      if (5*n == size(list)) i = findloc(abs(list(4::5) - list(2::5)) <= reach(study), .false., 1)
      if (5*n /= size(list)) then
         call study%refuse('list', 'five of each')
      else if (i > 0) then
         call study%refuse('list', 'z - x must be within half the clearance, but is not in state &
            &'//whole(i))
      end if
   end subroutine check_list

   !> Largest distance of the free mass from the middle.
   pure real(wp) function reach(study)
      !> The group.
      type(values_type), intent(in) :: study

      reach = half_gap(study%number('clearance'))
   end function reach

   !> The states: t, x, x', z, z' of each.
   pure function initial_states(case) result(states)
      !> The case, checked.
      type(case_type), intent(in) :: case
      real(wp), allocatable :: states(:, :)

      associate (s => case%study)
         if (s%has('states')) then
            states = random_states(case%osc%xi, case%r, s%number('load'), s%number('clearance'), &
               s%whole_number('states'), s%whole_number('seed'))
         else if (s%has('list')) then
            states = reshape(s%numbers('list'), [5, size(s%numbers('list'))/5])
         else
            states = plane_states(s)
         end if
      end associate
   end function initial_states

   !> The states (5, n m) of the plane; the second axis varies fastest.
   pure function plane_states(study) result(states)
      !> The group.
      type(values_type), intent(in) :: study
      real(wp), allocatable :: states(:, :)
      integer :: i

      allocate (states(5, product(plane_sizes(study))))
      do i = 1, 5
         if (study%has(trim(axis_names(i)))) states(i, :) = study%number(trim(axis_names(i)))
      end do
      call set_axes(study, [(findloc(axis_names == study%word('axes', i), .true., 1), i=1, 2)], &
         states)
      states(4, :) = states(4, :) + states(2, :)
   end function plane_states

   !> Bytes for all states, about 60 numbers each, and for those simulated first; of a structure for
   !! the states, in the result too, and for the motions of one block of them.
   pure real(wp) function basins_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case
      real(wp) :: states

      associate (s => case%study)
         if (s%has('states')) then
            states = s%whole_number('states')
         else if (s%has('list')) then
            states = 0.2_wp*size(s%numbers('list'))
         else
            states = product(real(plane_sizes(s), wp))
         end if
         if (case%model == of_structure) then
            bytes = (48.0_wp*case%coordinates + 100)*states + 5.0e4_wp*real(case%coordinates, wp)**2
         else
            bytes = 500*states + 1000*min(2.0_wp*s%whole_number('probes'), states)
         end if
      end associate
   end function basins_memory

   !> Finds the attractor that each state approaches.
   subroutine run_basins(case, threads, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(attractor_list_type) :: list
      type(line_type), allocatable :: names(:)
      real(wp), allocatable :: states(:, :), shares(:), errors(:)
      integer, allocatable :: labels(:)
      character(:), allocatable :: text
      real(wp) :: events
      integer :: i, n, reached, lost, limited

      if (case%model == of_structure) then
         call run_structure(case, threads, result, progress)
         return
      end if
      associate (s => case%study)
         list%system = new_forced_system(case%osc, case%r, s%number('load'), s%number('clearance'))
         list%max_cycles = s%whole_number('max_cycles')
         list%max_events = s%whole_number('max_events')
         list%threads = threads
         allocate (states, source=initial_states(case))
         n = size(states, 2)
         allocate (labels(n))
         call label_states(list, states, s%whole_number('cycles'), s%whole_number('probes'), &
            labels, events, progress)
      end associate
      reached = count(labels /= not_reached)
      limited = count(labels == event_limited)
      lost = count(labels == 0) + limited
      if (is_stopped(progress) .and. any(labels <= 0)) then
         result%cut = whole(reached)//' of '//whole(n)//' states were reached'
         if (lost > 0) result%cut = result%cut//', '//whole(lost)//' of them not decided yet'
      end if
      call find_names(list, names)
      call open_states(case%study, 'state', n, result)
      do i = 1, 5
         call result%put('states', trim(state_keys(i)%name), states(i, :))
      end do
      call result%put('states', 'label', labels - 1)
      call result%put_codes('states', 'attractor', max(0, labels), names)
      call result%open('run', '', [integer ::])
      call result%put('run', 'events', [events])
      allocate (shares(list%n), errors(list%n))
      call find_shares(labels, reached, names, shares, errors, text)
      call put_attractors(case, list, names, labels, shares, errors, result)
      ! what was cut short may hold states whose attractor was still watched: their labels are kept
      result%empty = lost == reached .and. (reached == 0 .or. len(result%cut) == 0)
      if (.not. result%empty) call result%add_note(text)
      if (lost == 0) return
      text = ''
      if (limited > 0) text = ', '//whole(limited)//' of them because max_events was reached'
      call result%fail(whole(lost)//' of '//counted(reached, 'state')//' not decided'//text)
   end subroutine run_basins

   !> Puts the attractors into the result, with remarks.
   pure subroutine put_attractors(case, list, names, labels, shares, errors, result)
      !> The case.
      type(case_type), intent(in) :: case
      !> The attractors.
      type(attractor_list_type), intent(in) :: list
      !> Names of the attractors.
      type(line_type), intent(in) :: names(:)
      !> (states) Number of the attractor of each state.
      integer, intent(in) :: labels(:)
      !> (attractors) Their shares of the states, with standard errors.
      real(wp), intent(in) :: shares(:), errors(:)
      !> The result.
      type(result_type), intent(inout) :: result
      type(line_type), allocatable :: words(:)
      character(:), allocatable :: text
      real(wp) :: states(5, list%n), balls(2, list%n), growth(list%n)
      integer :: i, n

      n = list%n
      allocate (words(size(kinds)))
      do i = 1, size(kinds)
         words(i)%text = trim(kinds(i))
      end do
      call result%open('attractors', 'attractor', [n])
      call result%put_text('attractors', 'name', names)
      associate (known => list%known(:n))
         do i = 1, n
            states(:, i) = known(i)%state
            balls(:, i) = ball(known(i))
            growth(i) = known(i)%largest
            if (any(known(i)%kind == [no_impacts, repeating])) growth(i) = ieee_value(1.0_wp, &
               ieee_quiet_nan)
            text = whole(i - 1)//': '//names(i)%text//' ('//trim(kinds(known(i)%kind))// &
               '), share '//exact(shares(i))
            call add_details(known(i), text)
            call result%remark(text)
         end do
         call result%put_codes('attractors', 'kind', known%kind, words)
         call result%put('attractors', 'cycles', known%cycles)
      end associate
      call result%put('attractors', 'growth', growth)
      call result%put('attractors', 'radius', balls(1, :))
      call result%put('attractors', 'contraction', balls(2, :))
      call result%put('attractors', 'fraction', shares)
      call result%put('attractors', 'standard_error', errors)
      call result%put('attractors', 'state', [states])
      call remark_safety(case, errors, labels, result)
   end subroutine put_attractors

   !> Adds remarks on the errors of the shares, and, for a complete plane, on the uncertainty
   !! exponent and the largest discs.
   pure subroutine remark_safety(case, errors, labels, result)
      !> The case.
      type(case_type), intent(in) :: case
      !> (attractors) The standard errors of their shares.
      real(wp), intent(in) :: errors(:)
      !> (states) Number of the attractor of each state.
      integer, intent(in) :: labels(:)
      !> The result.
      type(result_type), intent(inout) :: result
      integer, allocatable :: plane(:, :)
      real(wp), allocatable :: pairs(:, :)
      character(:), allocatable :: text
      real(wp) :: exponent, radii(size(errors)), centres(2, size(errors))
      integer :: sizes(2), i

      exponent = ieee_value(exponent, ieee_quiet_nan)
      if (case%study%has('values') .and. len(result%cut) == 0) then
         sizes = case%study%whole_numbers('values')
         plane = reshape(labels, [sizes(2), sizes(1)])
         pairs = uncertain_pairs(plane)
         exponent = uncertainty_exponent(pairs)
         call result%open('pairs', 'pair', [size(pairs, 2)])
         call result%put('pairs', 'distance', pairs(1, :))
         call result%put('pairs', 'uncertain', pairs(2, :))
      end if
      call result%put('run', 'uncertainty_exponent', [exponent])
      do i = 1, size(errors)
         text = whole(i - 1)//': standard error of the share '//exact(errors(i))
         if (allocated(plane)) then
            call find_disc(case%study, plane, i, radii(i), centres(:, i))
            text = text//', radius of the largest disc '//exact(radii(i))//' about '// &
               trim(case%study%word('axes', 1))//', '//trim(case%study%word('axes', 2))//' = '// &
               exact_list(centres(:, i))
         end if
         call result%remark(text)
      end do
      if (.not. allocated(plane)) return
      call result%put('attractors', 'disc_radius', radii)
      call result%put('attractors', 'disc_centre', [centres])
      if (.not. ieee_is_nan(exponent)) call result%remark('uncertainty exponent '//exact(exponent))
   end subroutine remark_safety

   !> The largest disc of the plane inside a basin.
   pure subroutine find_disc(study, plane, i, radius, centre)
      !> The group.
      type(values_type), intent(in) :: study
      !> (second axis, first axis) Number of the attractor of each state, and the one in question.
      integer, intent(in) :: plane(:, :), i
      !> Radius and centre of the disc.
      real(wp), intent(out) :: radius, centre(2)
      real(wp) :: low(2), high(2), cells(2), first(size(plane, 2)), second(size(plane, 1))
      integer :: place(2), n(2)

      low = study%numbers('low')
      high = study%numbers('high')
      n = study%whole_numbers('values')
      first = plane_values(study, 1)
      second = plane_values(study, 2)
      cells = (high(2:1:-1) - low(2:1:-1))/(n(2:1:-1) - 1)
      call largest_disc(plane, i, cells, radius, place)
      centre = [first(place(2)), second(place(1))]
   end subroutine find_disc

   !> Adds details of an attractor to a text.
   pure subroutine add_details(known, text)
      !> The attractor.
      type(known_type), intent(in) :: known
      !> In and out: the text to which they are added.
      character(:), allocatable, intent(inout) :: text
      real(wp) :: numbers(2)

      select case (known%kind)
      case (periodic, resting)
         numbers = ball(known)
         text = text//', greatest multiplier '//exact(known%largest)//', radius '// &
            exact(numbers(1))
      case (no_impacts, repeating)
      case default
         text = text//', largest exponent per load cycle '//exact(known%largest)
      end select
      text = text//'; t, x, x_dot, z, z_dot = '//exact_list(known%state)
   end subroutine add_details

   !> Names of the attractors: sides and load cycles, or the kind; equal names are numbered.
   pure subroutine find_names(list, names)
      !> The attractors.
      type(attractor_list_type), intent(in) :: list
      !> (attractors) Their names.
      type(line_type), allocatable, intent(out) :: names(:)
      integer :: i

      allocate (names(list%n))
      do i = 1, list%n
         associate (known => list%known(i))
            select case (known%kind)
            case (periodic, resting)
               names(i)%text = starred_symbols(known%symbols)//'/'//whole(known%cycles)
            case (repeating)
               names(i)%text = whole(size(known%symbols))//'/'//whole(known%cycles)//'?'
            case default
               names(i)%text = trim(kinds(known%kind))
            end select
         end associate
      end do
      call tell_apart(names)
   end subroutine find_names

   !> Checks those of a structure.
   subroutine check_structure(case)
      !> The case.
      type(case_type), intent(inout) :: case
      integer :: i, places(2)

      associate (s => case%study)
         if (len(s%fault) > 0) return
         call check_start_state(case)
         if (.not. is_free(case)) call needs_frequency(case, 'max_cycles')
         call check_settling(case)
         if (len(s%fault) > 0 .or. .not. s%has('axes')) return
         places = [(place_in_state(s%word('axes', i), case%coordinates), i=1, 2)]
         if (any(places == 0) .or. places(1) == places(2)) call s%refuse('axes', &
            'the structure has '//counted(case%coordinates, 'coordinate'))
         call check_uneven(s)
      end associate
   end subroutine check_structure

   !> Number of states.
   pure integer function count_states(study) result(n)
      !> The group.
      type(values_type), intent(in) :: study

      if (study%has('states')) then
         n = study%whole_number('states')
      else
         n = product(plane_sizes(study))
      end if
   end function count_states

   !> Finds the attractor of a structure on which each state settles.
   subroutine run_structure(case, threads, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(structure_type) :: structure
      type(load_type) :: load
      type(found_list_type) :: list
      type(line_type), allocatable :: names(:)
      real(wp), allocatable :: states(:, :)
      type(outcome_type), allocatable :: outcomes(:)
      integer, allocatable :: labels(:), numbers(:)
      character(:), allocatable :: fault
      type(load_type) :: paced
      type(settling_type) :: how
      real(wp) :: unit
      integer :: first, i, lost, n, reached
      logical :: free

      call structure_of(case, structure, load)
      load%frequency = load_frequency(case)
      free = is_free(case)
      fault = ''
      paced = load
      if (free) call find_pace(structure, load, unit, paced, fault)
      n = case%coordinates
      first = stat%ok
      associate (s => case%study)
         allocate (states(2*n, count_states(s)))
         allocate (outcomes(size(states, 2)))
         if (len(fault) > 0) then
            ! nothing is simulated
         else if (s%has('states')) then
            call random_structure_states(structure, paced, s%whole_number('seed'), states, first)
         else
            states = spread([s%numbers('q'), s%numbers('q_dot')], 2, size(states, 2))
            call set_axes(s, [(place_in_state(s%word('axes', i), n), i=1, 2)], states)
         end if
         if (first /= stat%ok) fault = 'a gap is closed at q = 0, around which random states are &
            &drawn; give a plane'
         if (len(fault) > 0) then
            result%empty = .true.
            call result%fail(fault)
            return
         end if
         how = settling_type(s%whole_number('settling'), s%whole_number('max_cycles'), &
            s%whole_number('max_events'), threads)
         if (free) then
            call settle_free_states(structure, load, unit, states, how, list, outcomes, progress)
         else
            call settle_states(structure, load, s%number('start'), states, how, list, outcomes, &
               progress)
         end if
      end associate
      call number_attractors(list, outcomes, free, labels, numbers, names)
      reached = count(labels /= not_reached .and. labels /= closed)
      if (is_stopped(progress)) result%cut = whole(count(labels /= not_reached))//' of '// &
         counted(size(labels), 'state')//' were reached'
      call open_states(case%study, 'initial', size(labels), result)
      call result%put('states', 'q', [states(:n, :)], n)
      call result%put('states', 'q_dot', [states(n + 1:, :)], n)
      call result%put('states', 'label', labels - 1)
      call result%put_codes('states', 'attractor', max(0, labels), names)
      call put_structure_attractors(result, list, free, labels, numbers, names, n)
      lost = count(labels == undecided .or. labels == event_limited)
      result%empty = count(labels > 0) == 0 .and. (reached == 0 .or. len(result%cut) == 0)
      i = findloc(outcomes%status /= stat%ok .and. outcomes%status /= stat%not_computed, &
         .true., 1)
      if (result%empty .and. i == 0) call result%fail('no state settles')
      if (result%empty .and. i > 0) call result%fail('no state settles: '// &
         status_text(outcomes(i)%status))
      if (.not. result%empty .and. lost > 0) call result%fail(whole(lost)//' of '// &
         counted(reached, 'state')//' not decided')
   end subroutine run_structure

   !> Numbers the attractors by decreasing share: motions, the one without impacts, those that are
   !! chaotic or quasi-periodic, and rests that never end.
   pure subroutine number_attractors(list, outcomes, free, labels, numbers, names)
      !> The motions on which states settle.
      type(found_list_type), intent(in) :: list
      !> (states) What became of each.
      type(outcome_type), intent(in) :: outcomes(:)
      !> Whether the motions are self-excited: without one, states end in an equilibrium.
      logical, intent(in) :: free
      !> (states) The number of the attractor of each, or the label of states without.
      integer, allocatable, intent(out) :: labels(:)
      !> (attractors) The number of the motion of each; 0 if it is none of the list.
      integer, allocatable, intent(out) :: numbers(:)
      !> (attractors) Their names.
      type(line_type), allocatable, intent(out) :: names(:)
      integer, allocatable :: counts(:), kinds(:), new(:)
      integer :: i, j, n

      ! attractors that were not distinguished are one of each kind
      allocate (kinds(0:size(other_names) - 1 + maxval([0, outcomes%group])))
      kinds = [(i, i=0, size(kinds) - 1)]
      labels = outcomes%label
      where (outcomes%status == stat%no_impacts) labels = list%n + 1
      where (outcomes%status == stat%permanent_rest) labels = list%n + size(other_names)
      do i = 1, size(outcomes)
         associate (one => outcomes(i))
            if (one%kind == 0) cycle
            j = merge(size(other_names) - 1 + one%group, one%kind, one%group > 0)
            kinds(j) = one%kind
            labels(i) = list%n + 1 + j
         end associate
      end do
      counts = [(count(labels == i), i=1, list%n + size(kinds))]
      n = count(counts > 0)
      allocate (numbers(n), names(n), new(size(counts)))
      do i = 1, n
         j = maxloc(counts, 1)
         counts(j) = 0
         new(j) = i
         numbers(i) = merge(j, 0, j <= list%n)
         if (j <= list%n) then
            call name_motion(list%motions(j), names(i)%text)
         else
            names(i)%text = trim(other_names(kinds(j - list%n - 1)))
            if (free .and. j == list%n + 1) names(i)%text = 'equilibrium'
         end if
      end do
      do i = 1, size(labels)
         if (labels(i) > 0) labels(i) = new(labels(i))
         if (outcomes(i)%status == stat%not_computed) labels(i) = not_reached
         if (outcomes(i)%status == stat%event_limit) labels(i) = event_limited
         if (outcomes(i)%status == stat%gap_closed) labels(i) = closed
      end do
      call tell_apart(names)
   end subroutine number_attractors

   !> The name of a motion: impacts and load cycles of its period.
   pure subroutine name_motion(motion, name)
      !> The motion.
      type(settled_type), intent(in) :: motion
      !> Its name.
      character(:), allocatable, intent(out) :: name

      name = whole(size(motion%gaps))
      if (size(motion%resting) > 0) name = 'rest'
      name = name//'/'//whole(motion%cycles)
   end subroutine name_motion

   !> Fills the tables of the attractors and their motions, with remarks.
   pure subroutine put_structure_attractors(result, list, free, labels, numbers, names, n)
      !> The result.
      type(result_type), intent(inout) :: result
      !> The motions.
      type(found_list_type), intent(inout) :: list
      !> Whether they are self-excited.
      logical, intent(in) :: free
      !> (states) Number of the attractor of each.
      integer, intent(in) :: labels(:)
      !> (attractors) The number of the motion of each; 0 if there is none.
      integer, intent(in) :: numbers(:)
      !> (attractors) Their names.
      type(line_type), intent(in) :: names(:)
      !> Number of coordinates.
      integer, intent(in) :: n
      real(wp), dimension(size(names)) :: shares, errors
      character(:), allocatable :: text
      integer, allocatable :: periodic(:)
      integer :: i, reached

      reached = max(1, count(labels /= not_reached .and. labels /= closed))
      call find_shares(labels, reached, names, shares, errors, text)
      do i = 1, size(names)
         call result%remark(whole(i - 1)//': '//names(i)%text//', share '//shown(shares(i), &
            'f12.6'))
      end do
      call result%add_note(text)
      ! in the order of the attractors
      periodic = pack(numbers, numbers > 0)
      if (.not. allocated(list%motions)) allocate (list%motions(0))
      call put_found(result, list%motions, periodic, n)
      if (free) call result%put('motions', 'frequency', list%motions(periodic)%frequency)
      call result%open('attractors', 'attractor', [size(names)])
      call result%put_text('attractors', 'name', names)
      call result%put('attractors', 'fraction', shares)
      call result%put('attractors', 'standard_error', errors)
      call result%put('attractors', 'number', [(merge(count(numbers(:i) > 0) - 1, -1, &
         numbers(i) > 0), i=1, size(numbers))])
   end subroutine put_structure_attractors

end module vi_basins_study
