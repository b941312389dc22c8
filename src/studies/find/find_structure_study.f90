!> The study &find of a &structure: every periodic motion that a search finds.
module vi_find_structure_study
   use vi_common_keys, only: max_events_key
   use vi_kinds, only: wp
   use vi_motion, only: yes
   use vi_progress, only: is_stopped
   use vi_status, only: stat, status_text
   use vi_structure, only: load_type, structure_type
   use vi_structure_find, only: chaotic, count_orders, orders_type, quasi_periodic, &
      random_structure_states, search_orders, settle_states, settling_type
   use vi_structure_found, only: found_columns, found_list_type, put_found
   use vi_structure_groups, only: load_frequency, structure_of
   use vi_structure_keys, only: needs_frequency
   use vi_study, only: a_whole, case_type, column_type, key_type, result_type, study_type, wholes
   use vi_text, only: counted, whole
   implicit none (type, external)
   private

   public :: declare_find_structure

   !> Most iterations of a search, and more status codes than there are.
   integer, parameter :: most_tries = 10**6, codes = 99

   type(key_type), parameter :: find_keys(*) = [ &
      key_type('max_impacts', a_whole, default='2', low=0.0_wp, high=8.0_wp, &
      takes='a whole number, 0 <= max_impacts <= 8, with at most 1000000 iterations', &
      meaning='largest number of impacts of an order that is searched'), &
      key_type('max_cycles', a_whole, default='4', low=1.0_wp, high=16.0_wp, &
      meaning='largest number of load cycles in a period'), &
      key_type('guesses', a_whole, default='48', low=1.0_wp, high=10000.0_wp, &
      meaning='sets of impact times for each order and number of cycles'), &
      key_type('states', a_whole, default='24', low=0.0_wp, high=1.0e5_wp, &
      meaning='initial states that are simulated; the first one is rest at q = 0'), &
      key_type('settling', a_whole, default='300', low=0.0_wp, high=1.0e6_wp, &
      meaning='load cycles simulated before a motion is looked for'), &
      key_type('seed', a_whole, default='0', low=0.0_wp, high=real(huge(1), wp), &
      meaning='seed of the states and the times'), &
      max_events_key]

   type(column_type), parameter :: find_columns(*) = [found_columns(:3), &
      column_type('motions', 'settled', wholes, meaning='simulated states that settle on it'), &
      found_columns(4:), &
      column_type('search', 'states', wholes, listed=.false., &
      meaning='initial states that were simulated'), &
      column_type('search', 'without_impacts', wholes, listed=.false., &
      meaning='states after which no impacts are left: all gaps stay open, or some rest for &
      &good'), &
      column_type('search', 'chaotic', wholes, listed=.false., &
      meaning='states whose largest Lyapunov exponent is positive by its error'), &
      column_type('search', 'quasi_periodic', wholes, listed=.false., &
      meaning='states whose largest Lyapunov exponent is zero by its error, where no stable &
      &motion is near'), &
      column_type('search', 'unsettled', wholes, listed=.false., &
      meaning='states on which none of this is decided, or whose motion is not stable'), &
      column_type('search', 'guesses', wholes, listed=.false., &
      meaning='sets of impact times from which Newton''s method started'), &
      column_type('failures', 'status', wholes, listed=.false., &
      meaning='code of what failed in a simulation or an iteration'), &
      column_type('failures', 'count', wholes, listed=.false., meaning='how often it occurred')]

contains

   !> Declares the study.
   subroutine declare_find_structure(study)
      !> The declaration of the study.
      type(study_type), intent(out) :: study

      study%name = 'find_structure'
      study%group = 'find'
      study%of_structure = .true.
      study%meaning = 'search for periodic motions of a structure with gaps'
      study%list => list_find
      study%row = 'impacts'
      study%check => check_find
      study%memory => find_memory
      study%run => run_find
   end subroutine declare_find_structure

   !> Lists the keys and columns.
   pure subroutine list_find(keys, columns)
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) keys = find_keys
      if (present(columns)) columns = find_columns
   end subroutine list_find

   !> Checks the rules that involve several keys.
   subroutine check_find(case)
      !> The case.
      type(case_type), intent(inout) :: case
      real(wp) :: orders
      integer :: gaps, i

      associate (s => case%study)
         if (len(s%fault) > 0) return
         call needs_frequency(case, 'max_cycles')
         gaps = count([(case%parts(i)%name == 'gap', i=1, size(case%parts))])
         orders = count_orders(gaps, s%whole_number('max_impacts'))
         if (orders*s%number('max_cycles')*s%number('guesses') <= most_tries) return
         call s%refuse('max_impacts', 'the orders of impacts on '//counted(gaps, 'gap')// &
            ' with max_cycles = '//whole(s%whole_number('max_cycles'))//' and guesses = '// &
            whole(s%whole_number('guesses'))//' make more iterations')
      end associate
   end subroutine check_find

   !> Bytes for the states, and for the motions of one block of tasks.
   pure real(wp) function find_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case

      bytes = 32.0_wp*case%coordinates*case%study%number('states') + 5.0e4_wp*real( &
         case%coordinates, wp)**2
   end function find_memory

   !> Searches.
   subroutine run_find(case, threads, result, progress)
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
      real(wp), allocatable :: states(:, :)
      integer, allocatable :: labels(:), others(:), status(:), settled(:), order(:), kinds(:)
      integer :: failures(0:codes), first, i, reached, without

      call structure_of(case, structure, load)
      load%frequency = load_frequency(case)
      failures = 0
      associate (s => case%study, n => case%coordinates)
         allocate (states(2*n, s%whole_number('states')))
         allocate (labels(size(states, 2)), others(size(states, 2)), status(size(states, 2)))
         call random_structure_states(structure, load, s%whole_number('seed'), states, first)
         if (size(states, 2) > 0 .and. first /= stat%ok) then
            result%empty = .true.
            call result%fail('a gap is closed at q = 0: simulate from a state with open gaps, or &
               &search with states = 0')
            return
         end if
         call settle_states(structure, load, 0.0_wp, states, settling_type(s%whole_number( &
            'settling'), s%whole_number('max_cycles'), s%whole_number('max_events'), threads), &
            list, labels, others, status, progress)
         settled = [(count(labels == i), i=1, list%n)]
         do i = 1, size(status)
            failures(status(i)) = failures(status(i)) + 1
         end do
         call search_orders(structure, load, orders_type(s%whole_number('max_impacts'), &
            s%whole_number('max_cycles'), s%whole_number('guesses'), s%whole_number('seed'), &
            threads), list, failures, progress)
      end associate
      settled = [settled, spread(0, 1, list%n - size(settled))]
      reached = count(status /= stat%not_computed)
      if (is_stopped(progress)) result%cut = whole(reached)//' of '//counted(size(status), &
         'state')//' and '//whole(sum(failures) - failures(stat%not_computed) - reached)// &
         ' sets of impact times were tried'
      call rank(list, settled, order)
      if (list%n == 0) allocate (list%motions(0))
      call put_found(result, list%motions, order, case%coordinates)
      call result%put('motions', 'settled', settled(order))
      call result%open('search', '', [integer ::])
      call result%put('search', 'states', [reached])
      without = count(status == stat%no_impacts .or. status == stat%permanent_rest)
      call result%put('search', 'without_impacts', [without])
      call result%put('search', 'chaotic', [count(others == chaotic)])
      call result%put('search', 'quasi_periodic', [count(others == quasi_periodic)])
      call result%put('search', 'unsettled', [reached - sum(settled) - without - count(others > 0)])
      call result%put('search', 'guesses', [sum(failures) - failures(stat%not_computed) - reached])
      ! these have columns of their own
      failures([stat%ok, stat%not_computed, stat%no_impacts, stat%permanent_rest]) = 0
      failures(stat%no_period) = failures(stat%no_period) - count(others > 0)
      kinds = pack([(i, i=0, codes)], failures > 0)
      call result%open('failures', 'failure', [size(kinds)])
      call result%put('failures', 'status', kinds)
      call result%put('failures', 'count', failures(kinds))
      do i = 1, size(kinds)
         call result%remark(whole(failures(kinds(i)))//' times: '//status_text(kinds(i)))
      end do
      if (list%n == 0) then
         call result%fail('no periodic motion was found')
      else
         call result%add_note(counted(list%n, 'motion')//', '//whole(count([( &
            list%motions(i)%motion%verdicts%stable == yes, i=1, list%n)]))//' stable; '// &
            whole(sum(settled))//' of '//counted(reached, 'state')//' settled on them')
      end if
   end subroutine run_find

   !> The order of motions: by the number of states that settle on each, then stable ones first.
   pure subroutine rank(list, settled, order)
      !> The motions.
      type(found_list_type), intent(in) :: list
      !> (n) States that settle on each.
      integer, intent(in) :: settled(:)
      !> (n) The places in the list.
      integer, allocatable, intent(out) :: order(:)
      integer :: i, j, one

      order = [(i, i=1, list%n)]
      do i = 2, list%n
         one = order(i)
         do j = i - 1, 1, -1
            if (.not. before(one, order(j))) exit
            order(j + 1) = order(j)
         end do
         order(j + 1) = one
      end do

   contains

      !> Whether a motion comes before another one that was found earlier.
      pure logical function before(later, earlier)
         !> Their places in the list.
         integer, intent(in) :: later, earlier

         before = settled(later) > settled(earlier)
         if (settled(later) == settled(earlier)) before = &
            list%motions(later)%motion%verdicts%stable == yes .and. &
            list%motions(earlier)%motion%verdicts%stable /= yes
      end function before

   end subroutine rank

end module vi_find_structure_study
