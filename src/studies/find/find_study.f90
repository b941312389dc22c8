!> The study &find: every periodic motion at a point that a search finds, stable and unstable.
module vi_find_study
   use vi_common_keys, only: clearance_key, load_key, max_events_key
   use vi_find, only: find_motions, find_request_type, findings_type
   use vi_forced_system, only: event_type, impact_event, new_forced_system, release_event, &
      stick_event
   use vi_found_motion, only: described_type, found_type
   use vi_free_states, only: check_settling, find_pace, is_free, settle_free_states
   use vi_kinds, only: wp
   use vi_motion, only: motion_type, yes
   use vi_motion_study, only: exact_kind, motion_columns, put_motions, put_origin
   use vi_progress, only: is_stopped
   use vi_restitution, only: table_law
   use vi_settled_motion, only: longest, no_impacts, not_stable, settled, unconfirmed, unfinished, &
      wandering
   use vi_settled_states, only: chaotic, outcome_type, quasi_periodic, settle_states, settling_type
   use vi_status, only: stat, status_text
   use vi_structure, only: load_type, structure_type
   use vi_structure_find, only: count_orders, orders_type, random_structure_states, search_orders
   use vi_structure_found, only: found_columns, found_list_type, put_found
   use vi_structure_groups, only: load_frequency, record_end, structure_of
   use vi_structure_keys, only: needs_frequency
   use vi_structure_lines, only: follow_lines
   use vi_study, only: a_whole, case_type, column_type, every_model, key_type, list_for, &
      of_oscillator, of_structure, result_type, study_type, wholes
   use vi_text, only: counted, whole
   use vi_trajectory, only: store_events
   implicit none (type, external)
   private

   public :: declare_find

   type(key_type), parameter :: find_keys(*) = [clearance_key, &
      key_type('max_impacts', a_whole, default='6', low=2.0_wp, high=12.0_wp, &
      meaning='largest number of impacts of a pattern that is searched'), &
      key_type('max_cycles', a_whole, default='2', low=1.0_wp, high=8.0_wp, &
      meaning='largest number of load cycles of a pattern that is searched'), &
      load_key, &
      key_type('guesses', a_whole, default='96', low=0.0_wp, high=1.0e6_wp, &
      meaning='guesses for each pattern'), &
      key_type('states', a_whole, default='24', low=0.0_wp, high=1.0e6_wp, &
      meaning='initial states that are simulated'), &
      key_type('settling', a_whole, default='600', low=0.0_wp, high=1.0e7_wp, &
      meaning='load cycles simulated before the attractor is examined'), &
      key_type('releases', a_whole, default='32', low=0.0_wp, high=1.0e6_wp, &
      meaning='releases from rest, for each wall and number of load cycles, from which &
      &Newton''s method starts')]

   !> Columns of the search.
   type(column_type), parameter :: search_columns(*) = [ &
      column_type('search', 'patterns', wholes, listed=.false., &
      meaning='patterns of sides, each with its load cycles, that were searched'), &
      column_type('search', 'guesses', wholes, listed=.false., &
      meaning='Newton iterations started, over all patterns'), &
      column_type('search', 'inadmissible', wholes, listed=.false., &
      meaning='solutions of the equations that would pass through a wall'), &
      column_type('search', 'releases', wholes, listed=.false., &
      meaning='releases from rest from which Newton''s method was started'), &
      column_type('search', 'states', wholes, listed=.false., &
      meaning='initial states that were simulated'), &
      column_type('search', 'settled', wholes, listed=.false., &
      meaning='states that settled on a stable periodic motion'), &
      column_type('search', 'not_stable', wholes, listed=.false., &
      meaning='states that came close to a motion that is not stable'), &
      column_type('search', 'unconfirmed', wholes, listed=.false., &
      meaning='states that repeated themselves where Newton''s method finds no motion'), &
      column_type('search', 'wandering', wholes, listed=.false., &
      meaning='states that did not repeat themselves'), &
      column_type('search', 'without_impacts', wholes, listed=.false., &
      meaning='states after which no impacts were left'), &
      column_type('search', 'unfinished', wholes, listed=.false., &
      meaning='states whose simulation reached max_events or could not go on'), &
      column_type('search', 'lost', wholes, listed=.false., &
      meaning='solutions that could not be confirmed, or for which rounding hides whether they are &
      &admissible')]

   type(column_type), parameter :: find_columns(*) = [motion_columns, &
      search_columns]

   !> Most iterations of a search, and more status codes than there are.
   integer, parameter :: most_tries = 10**6, codes = 99

   type(key_type), parameter :: structure_keys(*) = [ &
      key_type('max_impacts', a_whole, default='2', low=0.0_wp, high=8.0_wp, &
      takes='a whole number, 0 <= max_impacts <= 8, with at most 1000000 iterations', &
      meaning='largest number of impacts of an order that is searched; none without a periodic &
      &load, or with stops or friction'), &
      key_type('max_cycles', a_whole, default='4', low=1.0_wp, high=16.0_wp, &
      meaning='largest number of load cycles in a period'), &
      key_type('guesses', a_whole, default='48', low=1.0_wp, high=10000.0_wp, &
      meaning='sets of impact times for each order and number of cycles'), &
      key_type('states', a_whole, default='24', low=0.0_wp, high=1.0e5_wp, &
      meaning='initial states that are simulated; the first one is rest at q = 0'), &
      key_type('settling', a_whole, default='300', low=0.0_wp, high=1.0e6_wp, &
      meaning='load cycles simulated before the search for a motion; without a periodic load &
      &natural periods, more if needed'), &
      key_type('seed', a_whole, default='0', low=0.0_wp, high=real(huge(1), wp), &
      meaning='seed of the states and the times')]

   type(column_type), parameter :: structure_columns(*) = [found_columns(:3), &
      column_type('motions', 'settled', wholes, meaning='simulated states that settle on it'), &
      found_columns(4:), &
      column_type('search', 'states', wholes, listed=.false., &
      meaning='initial states that were simulated'), &
      column_type('search', 'without_impacts', wholes, listed=.false., &
      meaning='states after which no impacts are left: all gaps stay open, or some rest &
      &permanently; without a periodic load, those in an equilibrium'), &
      column_type('search', 'chaotic', wholes, listed=.false., &
      meaning='states whose largest Lyapunov exponent is positive and exceeds its error'), &
      column_type('search', 'quasi_periodic', wholes, listed=.false., &
      meaning='states whose largest Lyapunov exponent is zero within its error, with no stable &
      &motion nearby'), &
      column_type('search', 'unsettled', wholes, listed=.false., &
      meaning='states for which none of this was decided, or whose motion is not stable'), &
      column_type('search', 'guesses', wholes, listed=.false., &
      meaning='sets of impact times from which Newton''s method started'), &
      column_type('failures', 'status', wholes, listed=.false., &
      meaning='code of the failure of a simulation or an iteration'), &
      column_type('failures', 'count', wholes, listed=.false., meaning='how often it occurred')]

contains

   !> Declares the study, with its keys and columns.
   pure subroutine declare_find(study, keys, columns)
      !> The study.
      type(study_type), intent(out), optional :: study
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) then
         call list_for(of_oscillator, find_keys, keys)
         call list_for(of_structure, structure_keys, keys)
         call list_for(every_model, [max_events_key], keys)
      end if
      if (present(columns)) then
         call list_for(of_oscillator, find_columns, columns)
         call list_for(of_structure, structure_columns, columns)
      end if
      if (.not. present(study)) return
      study%name = 'find'
      study%meaning = 'search for all periodic motions at a point'
      study%row = 'impacts'
      study%takes_elements = .true.
      study%takes_walls = .true.
      study%check => check_find
      study%memory => find_memory
      study%run => run_find
   end subroutine declare_find

   !> Bytes for all releases, and for the motions on which a state may settle; of a structure for
   !! the states, and for the motions of one block of tasks.
   pure real(wp) function find_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case
      type(found_type) :: one

      associate (s => case%study)
         if (case%model == of_structure) then
            bytes = 32.0_wp*case%coordinates*s%number('states') + 5.0e4_wp*real( &
               case%coordinates, wp)**2
            return
         end if
         bytes = storage_size(one)/8 + 200
         bytes = bytes*(2.0_wp*s%whole_number('releases')*s%whole_number('max_cycles') + &
            real(longest, wp)*s%whole_number('states'))
      end associate
   end function find_memory

   !> Searches at the point of a case.
   subroutine run_find(case, threads, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(find_request_type) :: request
      type(findings_type) :: findings
      type(motion_type), allocatable :: motions(:)
      character(:), allocatable :: text
      integer :: i

      if (case%model == of_structure) then
         call run_structure(case, threads, result, progress)
         return
      end if
      associate (s => case%study)
         request = find_request_type(new_forced_system(case%osc, case%r, s%number('load'), &
            s%number('clearance')), s%whole_number('max_impacts'), s%whole_number('max_cycles'), &
            s%whole_number('guesses'), s%whole_number('states'), s%whole_number('settling'), &
            s%whole_number('max_events'), s%whole_number('releases'), threads)
      end associate
      call find_motions(request, findings, progress)
      if (is_stopped(progress)) result%cut = whole(findings%patterns)//' of '// &
         whole(findings%all_patterns)//' patterns were searched, '//whole(findings%releases)// &
         ' releases and '//whole(sum(findings%outcomes))//' of '//whole(request%states)// &
         ' states were tried'
      allocate (motions(size(findings%motions)))       ! gfortran 12 would not free its own copy
      do i = 1, size(motions)
         motions(i) = findings%motions(i)%motion
      end do
      call put_motions(motions, result)
      call put_origin(case, exact_kind, .false., case%study%number('load'), result)
      call put_events(case%r, findings%motions, result)
      call put_search(findings, result)
      call search_text(findings, text)
      call result%remark('searched: '//text)
      associate (n => size(findings%motions))
         result%empty = n == 0
         if (result%empty) then
            call result%fail('no periodic motion was found')
         else
            call result%add_note(counted(n, 'motion')//', '//whole(count( &
               findings%motions%motion%stable == yes))//' stable')
         end if
      end associate
   end subroutine run_find

   !> Puts the events of motions with rest into the result.
   pure subroutine put_events(r, motions, result)
      !> Frequency ratio.
      real(wp), intent(in) :: r
      !> The motions.
      type(described_type), intent(in) :: motions(:)
      !> The result.
      type(result_type), intent(inout) :: result
      character(*), parameter :: names(7) = [character(12) :: 'time', 'phase', 'x', &
         'x_dot_before', 'x_dot_after', 'z_dot_before', 'z_dot_after']
      integer, parameter :: kinds(3) = [impact_event, stick_event, release_event]
      type(event_type), allocatable :: events(:)
      integer, allocatable :: owners(:), labels(:, :)
      real(wp), allocatable :: values(:, :)
      real(wp) :: begin
      integer :: i, n, first, last

      allocate (events(0), owners(0))
      do i = 1, size(motions)
         if (.not. allocated(motions(i)%events)) cycle
         events = [events, motions(i)%events]
         owners = [owners, spread(i, 1, size(motions(i)%events))]
      end do
      n = size(events)
      allocate (values(7, n), labels(2, n))
      call store_events(events, r, values, labels)
      last = 0
      do i = 1, size(motions)
         if (.not. allocated(motions(i)%events)) cycle
         first = last + 1
         last = last + size(motions(i)%events)
         begin = values(1, first)
         values(1, first:last) = values(1, first:last) - begin
      end do
      call result%open('events', 'event', [n], 'motions', owners)
      do i = 1, size(names)
         call result%put('events', trim(names(i)), values(i, :))
      end do
      call result%put('events', 'kind', [(findloc(kinds, labels(1, i), 1), i=1, n)])
      call result%put('events', 'side', merge(1, 2, labels(2, :) > 0))
   end subroutine put_events

   !> Puts the counts of the search into the result.
   pure subroutine put_search(findings, result)
      !> The motions found, and counts of the search.
      type(findings_type), intent(in) :: findings
      !> The result.
      type(result_type), intent(inout) :: result

      call result%open('search', '', [integer ::])
      call result%put('search', 'patterns', [findings%patterns])
      call result%put('search', 'guesses', [findings%guesses])
      call result%put('search', 'inadmissible', [findings%inadmissible])
      call result%put('search', 'releases', [findings%releases])
      call result%put('search', 'lost', [findings%lost])
      associate (outcomes => findings%outcomes)
         call result%put('search', 'states', [sum(outcomes)])
         call result%put('search', 'settled', [outcomes(settled)])
         call result%put('search', 'not_stable', [outcomes(not_stable)])
         call result%put('search', 'unconfirmed', [outcomes(unconfirmed)])
         call result%put('search', 'wandering', [outcomes(wandering)])
         call result%put('search', 'without_impacts', [outcomes(no_impacts)])
         call result%put('search', 'unfinished', [outcomes(unfinished)])
      end associate
   end subroutine put_search

   !> Describes the search, and so how far its result can be trusted.
   pure subroutine search_text(findings, text)
      !> The motions found, and counts of the search.
      type(findings_type), intent(in) :: findings
      !> The description.
      character(:), allocatable, intent(out) :: text
      integer, parameter :: others(5) = [not_stable, unconfirmed, wandering, no_impacts, unfinished]
      character(*), parameter :: reasons(5) = [character(60) :: &
         'stayed near an unstable motion for a while', &
         'repeated themselves where Newton''s method finds no motion', &
         'did not repeat themselves within 16 load cycles', 'had no more impacts', &
         'reached max_events or could not be simulated to the end']
      character(:), allocatable :: apart
      integer :: i

      apart = ''
      do i = 1, size(others)
         associate (number => findings%outcomes(others(i)))
            if (number == 0) cycle
            if (len(apart) > 0) apart = apart//', '
            apart = apart//whole(number)//' '//trim(reasons(i))
         end associate
      end do
      if (len(apart) > 0) apart = ' ('//apart//')'
      if (findings%lost > 0) apart = apart//'; '//whole(findings%lost)// &
         ' solutions that could not be confirmed are left out'
      text = counted(findings%patterns, 'pattern')//' with '//whole(findings%guesses)// &
         ' guesses (phases spread evenly, the rest from the linear problem; '// &
         whole(findings%inadmissible)//' inadmissible solutions left out), followed along the &
         &lines of constant r and constant clearance, '//whole(findings%releases)// &
         ' releases from rest, and '//whole(sum(findings%outcomes))//' simulated states, of &
         &which '//whole(findings%outcomes(settled))//' settled on a stable periodic motion'// &
         apart//'. A motion with a very small neighbourhood of convergence may have been missed, &
         &most easily one with rest.'
   end subroutine search_text

   !> Checks the rules that involve several keys.
   subroutine check_find(case)
      !> The case.
      type(case_type), intent(inout) :: case
      real(wp) :: orders
      integer :: gaps, i

      associate (s => case%study)
         if (len(s%fault) > 0 .or. case%model /= of_structure) return
         if (record_end(case) >= 0) call needs_frequency(case, 'max_cycles')
         if (is_free(case)) then
            if (s%whole_number('states') == 0) call s%refuse('states', &
               'without a &load with a frequency motions come from simulations alone')
            call check_settling(case)
            return
         end if
         gaps = count([(case%parts(i)%name == 'gap', i=1, size(case%parts))])
         orders = count_orders(gaps, s%whole_number('max_impacts'))
         if (orders*s%number('max_cycles')*s%number('guesses') <= most_tries) return
         call s%refuse('max_impacts', 'the orders of impacts on '//counted(gaps, 'gap')// &
            ' with max_cycles = '//whole(s%whole_number('max_cycles'))//' and guesses = '// &
            whole(s%whole_number('guesses'))//' need more iterations')
      end associate
   end subroutine check_find

   !> Searches motions of a structure.
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
      real(wp), allocatable :: states(:, :)
      type(outcome_type), allocatable :: outcomes(:)
      integer, allocatable :: settled(:), order(:), kinds(:)
      integer :: failures(0:codes), first, i, most_impacts, reached, without
      character(:), allocatable :: fault
      real(wp) :: unit
      type(load_type) :: paced
      type(settling_type) :: how
      logical :: free

      call structure_of(case, structure, load)
      load%frequency = load_frequency(case)
      free = is_free(case)
      paced = load
      if (free) then
         call find_pace(structure, load, unit, paced, fault)
         result%empty = len(fault) > 0
         if (result%empty) call result%fail(fault)
         if (result%empty) return
      end if
      failures = 0
      associate (s => case%study, n => case%coordinates)
         allocate (states(2*n, s%whole_number('states')))
         allocate (outcomes(size(states, 2)))
         call random_structure_states(structure, paced, s%whole_number('seed'), states, first)
         if (size(states, 2) > 0 .and. first /= stat%ok) then
            result%empty = .true.
            if (free) then
               call result%fail('a gap is closed at q = 0: simulate from a state with open gaps')
            else
               call result%fail('a gap is closed at q = 0: simulate from a state with open gaps, &
                  &or search with states = 0')
            end if
            return
         end if
         how = settling_type(s%whole_number('settling'), s%whole_number('max_cycles'), &
            s%whole_number('max_events'), threads)
         if (free) then
            call settle_free_states(structure, load, unit, states, how, list, outcomes, progress)
         else
            call settle_states(structure, load, 0.0_wp, states, how, list, outcomes, progress)
         end if
         settled = [(count(outcomes%label == i), i=1, list%n)]
         do i = 1, size(outcomes)
            failures(outcomes(i)%status) = failures(outcomes(i)%status) + 1
         end do
         most_impacts = s%whole_number('max_impacts')
         ! events of stops and friction are known from simulations alone
         if (any(structure%laws%kind > table_law) .or. structure%moves .or. free) most_impacts = 0
         if (.not. free) call search_orders(structure, load, orders_type(most_impacts, &
            s%whole_number('max_cycles'), s%whole_number('guesses'), s%whole_number('seed'), &
            threads), list, failures, progress)
         ! otherwise only the motions on which states settle are wanted
         if (most_impacts > 0) call follow_lines(structure, load, s%whole_number('guesses'), &
            list, progress)
      end associate
      settled = [settled, spread(0, 1, list%n - size(settled))]
      reached = count(outcomes%status /= stat%not_computed)
      if (is_stopped(progress)) result%cut = whole(reached)//' of '//counted(size(outcomes), &
         'state')//' and '//whole(sum(failures) - failures(stat%not_computed) - reached)// &
         ' sets of impact times were tried'
      call rank(list, settled, order)
      if (list%n == 0) allocate (list%motions(0))
      call put_found(result, list%motions, order, case%coordinates)
      call result%put('motions', 'settled', settled(order))
      if (free) call result%put('motions', 'frequency', list%motions(order)%frequency)
      call result%open('search', '', [integer ::])
      call result%put('search', 'states', [reached])
      without = count(outcomes%status == stat%no_impacts .or. outcomes%status == &
         stat%permanent_rest)
      call result%put('search', 'without_impacts', [without])
      call result%put('search', 'chaotic', [count(outcomes%kind == chaotic)])
      call result%put('search', 'quasi_periodic', [count(outcomes%kind == &
         quasi_periodic)])
      call result%put('search', 'unsettled', [reached - sum(settled) - without - &
         count(outcomes%kind > 0)])
      call result%put('search', 'guesses', [sum(failures) - failures(stat%not_computed) - reached])
      ! these have columns of their own
      failures([stat%ok, stat%not_computed, stat%no_impacts, stat%permanent_rest]) = 0
      failures(stat%no_period) = failures(stat%no_period) - count(outcomes%kind > 0)
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
   end subroutine run_structure

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

end module vi_find_study
