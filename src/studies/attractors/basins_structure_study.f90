!> The study &basins of a &structure: the attractor on which each initial state settles.
module vi_basins_structure_study
   use vi_basin_tables, only: find_shares, open_states, set_axes, tell_apart
   use vi_common_keys, only: most_numbers, check_product, max_events_key, most_state
   use vi_kinds, only: wp
   use vi_progress, only: is_stopped
   use vi_status, only: stat, status_text
   use vi_structure, only: load_type, structure_type
   use vi_structure_find, only: chaotic, quasi_periodic, random_structure_states, settle_states, &
      settling_type
   use vi_structure_found, only: found_columns, found_list_type, put_found
   use vi_structure_groups, only: load_frequency, structure_of
   use vi_structure_keys, only: check_start_state, needs_frequency, place_in_state, start_keys
   use vi_structure_return, only: settled_type
   use vi_study, only: a_whole, a_word, case_type, column_type, key_type, result_type, study_type, &
      values_type, wholes, words
   use vi_text, only: counted, line_type, shown, whole
   implicit none (type, external)
   private

   public :: declare_basins_structure

   character(*), parameter :: random = ': it is for a plane', axes_taken = 'two of ''q_0'', &
      &''q_1'', ... (coordinates, from 0) and ''q_dot_0'', ''q_dot_1'', ... (velocities), or &
      &states = N instead of a plane'
   type(key_type), parameter :: basins_keys(*) = [ &
      key_type('states', a_whole, may_miss=.true., low=1.0_wp, high=real(most_numbers, wp), &
      meaning='number of random states, instead of a plane'), &
      key_type('seed', a_whole, default='0', low=0.0_wp, high=real(huge(1), wp), only='states', &
      meaning='seed of the random states'), &
      key_type('axes', a_word, least=2, most=2, never='states', why=random, takes=axes_taken, &
      option='plane', meaning='axes of the plane of initial states'), &
      key_type('low', least=2, most=2, low=-most_state, high=most_state, never='states', &
      why=random, takes='two numbers from -1e100 to 1e100, one for each axis', option='plane', &
      meaning='first value along each axis'), &
      key_type('high', least=2, most=2, low=-most_state, high=most_state, over='low', &
      never='states', why=random, &
      takes='two numbers from -1e100 to 1e100, one for each axis', option='plane', &
      meaning='last value along each axis'), &
      key_type('values', a_whole, least=2, most=2, low=2.0_wp, high=1.0e5_wp, never='states', &
      why=random, takes='two whole numbers, one for each axis, each with 2 <= values <= 100000', &
      option='plane', meaning='number of values along each axis'), &
      start_keys, &
      key_type('settling', a_whole, default='1000', low=0.0_wp, high=1.0e6_wp, &
      meaning='load cycles simulated before a motion is looked for, unless it repeats to rounding &
      &before'), &
      key_type('max_cycles', a_whole, default='16', low=1.0_wp, high=100.0_wp, &
      meaning='longest period considered, in load cycles'), &
      max_events_key]

   !> Labels of states without an attractor.
   integer, parameter :: undecided = 0, not_reached = -1, event_limited = -2, closed = -3
   character(14), parameter :: other_names(0:3) = [character(14) :: 'no impacts', 'chaotic', &
      'quasi-periodic', 'permanent rest']

   type(column_type), parameter :: basins_columns(*) = [ &
      column_type('states', 'q', each='coordinate', label='q_#', &
      meaning='coordinates of the initial state'), &
      column_type('states', 'q_dot', each='coordinate', label='q_dot_#', meaning='velocities'), &
      column_type('states', 'label', wholes, &
      meaning='number of its attractor; -1 not decided, -2 not reached, -3 not decided before &
      &max_events, -4 a gap is closed there'), &
      column_type('states', 'attractor', words, meaning='name of its attractor'), &
      column_type('first', 'place', label='=', listed=.false., meaning='along the first axis'), &
      column_type('second', 'place', label='=', listed=.false., meaning='along the second axis'), &
      column_type('attractors', 'name', words, label='=', listed=.false., &
      meaning='impacts and load cycles of a periodic motion, or the kind of the attractor'), &
      column_type('attractors', 'fraction', listed=.false., &
      meaning='share of the states that were reached and have no closed gap'), &
      column_type('attractors', 'standard_error', listed=.false., &
      meaning='standard error of the fraction'), &
      column_type('attractors', 'number', wholes, listed=.false., &
      meaning='its number among the motions, from 0; -1 if it is not periodic or has no impacts')]

contains

   !> Declares the study.
   subroutine declare_basins_structure(study)
      !> The declaration of the study.
      type(study_type), intent(out) :: study

      study%name = 'basins_structure'
      study%group = 'basins'
      study%of_structure = .true.
      study%meaning = 'find the basins of the attractors of a structure with gaps'
      study%list => list_basins
      study%row = 'states'
      study%check => check_basins
      study%memory => basins_memory
      study%run => run_basins
   end subroutine declare_basins_structure

   !> Lists the keys and columns.
   pure subroutine list_basins(keys, columns)
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) keys = basins_keys
      if (.not. present(columns)) return
      columns = [basins_columns, found_columns]
      ! the CSV has a row for each state, not for each impact
      columns(size(basins_columns) + 1:)%listed = .false.
   end subroutine list_basins

   !> Checks the rules that involve several keys.
   subroutine check_basins(case)
      !> The case.
      type(case_type), intent(inout) :: case
      integer :: i, places(2)

      associate (s => case%study)
         if (len(s%fault) > 0) return
         call check_start_state(case)
         call needs_frequency(case, 'max_cycles')
         if (len(s%fault) > 0 .or. .not. s%has('axes')) return
         places = [(place_in_state(s%word('axes', i), case%coordinates), i=1, 2)]
         if (any(places == 0) .or. places(1) == places(2)) call s%refuse('axes', 'there are '// &
            counted(case%coordinates, 'coordinate'))
         call check_product(s, 'values', s%whole_numbers('values'), 'together at most '// &
            whole(most_numbers)//' states')
      end associate
   end subroutine check_basins

   !> Number of states.
   pure integer function count_states(study) result(n)
      !> The group.
      type(values_type), intent(in) :: study

      if (study%has('states')) then
         n = study%whole_number('states')
      else
         n = product(study%whole_numbers('values'))
      end if
   end function count_states

   !> Bytes for the states, in the result too, and for the motions of one block of them.
   pure real(wp) function basins_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case

      bytes = (48.0_wp*case%coordinates + 100)*count_states(case%study) + 5.0e4_wp* &
         real(case%coordinates, wp)**2
   end function basins_memory

   !> Finds the attractor on which each state settles.
   subroutine run_basins(case, threads, result, progress)
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
      integer, allocatable :: kinds(:), labels(:), numbers(:), status(:)
      integer :: first, i, lost, n, reached

      call structure_of(case, structure, load)
      load%frequency = load_frequency(case)
      n = case%coordinates
      first = stat%ok
      associate (s => case%study)
         allocate (states(2*n, count_states(s)))
         allocate (kinds(size(states, 2)), labels(size(states, 2)), status(size(states, 2)))
         if (s%has('states')) then
            call random_structure_states(structure, load, s%whole_number('seed'), states, first)
         else
            states = spread([s%numbers('q'), s%numbers('q_dot')], 2, size(states, 2))
            call set_axes(s, [(place_in_state(s%word('axes', i), n), i=1, 2)], states)
         end if
         if (first /= stat%ok) then
            result%empty = .true.
            call result%fail('a gap is closed at q = 0, about which random states lie; give a &
               &plane')
            return
         end if
         call settle_states(structure, load, s%number('start'), states, settling_type( &
            s%whole_number('settling'), s%whole_number('max_cycles'), &
            s%whole_number('max_events'), threads), list, labels, kinds, status, &
            progress)
      end associate
      call number_attractors(list, kinds, status, labels, numbers, names)
      reached = count(labels /= not_reached .and. labels /= closed)
      if (is_stopped(progress)) result%cut = whole(count(labels /= not_reached))//' of '// &
         counted(size(labels), 'state')//' were reached'
      call open_states(case%study, 'initial', size(labels), result)
      call result%put('states', 'q', [states(:n, :)], n)
      call result%put('states', 'q_dot', [states(n + 1:, :)], n)
      call result%put('states', 'label', labels - 1)
      call result%put_codes('states', 'attractor', max(0, labels), names)
      call put_attractors(result, list, labels, numbers, names, n)
      lost = count(labels == undecided .or. labels == event_limited)
      result%empty = count(labels > 0) == 0
      i = findloc(status /= stat%ok .and. status /= stat%not_computed, .true., 1)
      if (result%empty .and. i == 0) call result%fail('no state settles')
      if (result%empty .and. i > 0) call result%fail('no state settles: '//status_text(status(i)))
      if (.not. result%empty .and. lost > 0) call result%fail(whole(lost)//' of '// &
         counted(reached, 'state')//' not decided')
   end subroutine run_basins

   !> Numbers the attractors by decreasing share: motions, the one without impacts, all that are
   !! chaotic, all that are quasi-periodic, and rests that never end.
   pure subroutine number_attractors(list, kinds, status, labels, numbers, names)
      !> The motions on which states settle.
      type(found_list_type), intent(in) :: list
      !> (states) The kind of a motion that is not periodic, and what became of each.
      integer, intent(in) :: kinds(:), status(:)
      !> (states) In: the number of the motion of each, or 0. Out: that of its attractor, or the
      !! label of states without.
      integer, intent(inout) :: labels(:)
      !> (attractors) The number of the motion of each; 0 if it is none of the list.
      integer, allocatable, intent(out) :: numbers(:)
      !> (attractors) Their names.
      type(line_type), allocatable, intent(out) :: names(:)
      integer :: counts(list%n + size(other_names)), new(size(counts)), i, j, n

      where (status == stat%no_impacts) labels = list%n + 1
      where (kinds == chaotic) labels = list%n + 1 + chaotic
      where (kinds == quasi_periodic) labels = list%n + 1 + quasi_periodic
      where (status == stat%permanent_rest) labels = list%n + size(other_names)
      do i = 1, size(counts)
         counts(i) = count(labels == i)
      end do
      n = count(counts > 0)
      allocate (numbers(n), names(n))
      do i = 1, n
         j = maxloc(counts, 1)
         counts(j) = 0
         new(j) = i
         numbers(i) = merge(j, 0, j <= list%n)
         if (j <= list%n) then
            call name_motion(list%motions(j), names(i)%text)
         else
            names(i)%text = trim(other_names(j - list%n - 1))
         end if
      end do
      do i = 1, size(labels)
         if (labels(i) > 0) labels(i) = new(labels(i))
         if (status(i) == stat%not_computed) labels(i) = not_reached
         if (status(i) == stat%event_limit) labels(i) = event_limited
         if (status(i) == stat%gap_closed) labels(i) = closed
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
   pure subroutine put_attractors(result, list, labels, numbers, names, n)
      !> The result.
      type(result_type), intent(inout) :: result
      !> The motions.
      type(found_list_type), intent(inout) :: list
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
      call result%open('attractors', 'attractor', [size(names)])
      call result%put_text('attractors', 'name', names)
      call result%put('attractors', 'fraction', shares)
      call result%put('attractors', 'standard_error', errors)
      call result%put('attractors', 'number', [(merge(count(numbers(:i) > 0) - 1, -1, &
         numbers(i) > 0), i=1, size(numbers))])
   end subroutine put_attractors

end module vi_basins_structure_study
