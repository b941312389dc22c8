!> The study &simulate: a simulation from a state.
module vi_simulate_study
   use vi_common_keys, only: check_start, clearance_key, load_key, state_keys, state_of
   use vi_forced_system, only: least_clearance, new_forced_system, state_time, state_type
   use vi_kinds, only: pi, wp
   use vi_processor, only: has_memory
   use vi_simulate, only: event_type, impact_event, release_event, stick_event
   use vi_status, only: stat, status_text
   use vi_structure, only: load_type, structure_type
   use vi_structure_gaps, only: start_fault
   use vi_structure_groups, only: load_frequency, record_end, record_of, structure_of
   use vi_structure_keys, only: check_start_state, longest, start_keys
   use vi_structure_matrices, only: output_rows
   use vi_structure_run, only: event_kinds, halt_event, hit_event => impact_event, &
      rest_event => stick_event, touch_event
   use vi_structure_tables, only: put_structure, structure_columns
   use vi_structure_trajectory, only: simulate_structure_case
   use vi_study, only: a_whole, case_type, column_type, key_type, list_for, of_oscillator, &
      of_structure, result_type, study_type, truths, values_type, wholes, words
   use vi_text, only: counted, exact, exact_list, number_text, shown, whole
   use vi_trajectory, only: pack_state, simulate_case
   implicit none (type, external)
   private

   public :: declare_simulate

   !> Largest number of events of a result: each takes 64 bytes, and more in the columns.
   real(wp), parameter :: most_kept = 5.0e7_wp
   !> Bytes that an event takes in the columns of the result, with room to make them.
   real(wp), parameter :: event_bytes = 120

   type(key_type), parameter :: simulate_keys(*) = [clearance_key, &
      key_type('cycles', low=0.0_wp, high=1.0e9_wp, &
      takes='a number of load cycles with 0 <= cycles <= 1e9', &
      meaning='load cycles to simulate; fractions are allowed'), &
      key_type('discard', default='0', low=0.0_wp, high=1.0e9_wp, &
      takes='a number of load cycles with 0 <= discard <= 1e9', &
      meaning='load cycles simulated before those that are kept'), &
      load_key, state_keys, &
      key_type('max_events', a_whole, default='10000000', low=1.0_wp, high=most_kept, &
      meaning='events after which the simulation stops')]

   type(column_type), parameter :: simulate_columns(*) = [ &
      column_type('events', 'time', unit='1/omega', meaning='time'), &
      column_type('events', 'kind', words, words='impact,stick,release', meaning='kind'), &
      column_type('events', 'side', words, words='R,L', meaning='wall'), &
      column_type('events', 'phase', unit='rad', meaning='load phase within a load cycle'), &
      column_type('events', 'x', unit='F0/K', meaning='displacement of the primary mass'), &
      column_type('events', 'x_dot_before', unit='omega F0/K', &
      meaning='velocity of the primary mass before the event'), &
      column_type('events', 'x_dot_after', unit='omega F0/K', &
      meaning='velocity of the primary mass after the impact'), &
      column_type('events', 'z_dot_before', unit='omega F0/K', &
      meaning='velocity of the free mass before the impact'), &
      column_type('events', 'z_dot_after', unit='omega F0/K', &
      meaning='velocity of the free mass after the impact'), &
      column_type('final', 'state', each='coordinate', unit='mixed', listed=.false., &
      meaning='the state at the end: t, x, x_dot, z, z_dot'), &
      column_type('run', 'xi', listed=.false., meaning='damping ratio'), &
      column_type('run', 'mu', listed=.false., meaning='mass ratio'), &
      column_type('run', 'R1', listed=.false., &
      meaning='coefficient of restitution of the right wall'), &
      column_type('run', 'R2', listed=.false., &
      meaning='coefficient of restitution of the left wall'), &
      column_type('run', 'M', listed=.false., &
      meaning='primary mass in the units of `units`, if known'), &
      column_type('run', 'K', listed=.false., meaning='stiffness in these units, if known'), &
      column_type('run', 'F0', listed=.false., meaning='load amplitude in these units, if known'), &
      column_type('run', 'units', words, listed=.false., &
      meaning='units of length, force and time, if known'), &
      column_type('run', 'r', listed=.false., meaning='frequency ratio'), &
      column_type('run', 'clearance', unit='F0/K', listed=.false., &
      meaning='clearance d K/F0; d is the whole travel of m between the walls'), &
      column_type('run', 'load', unit='F0', listed=.false., meaning='load amplitude'), &
      column_type('run', 'finished', truths, listed=.false., &
      meaning='whether the end was reached before max_events events'), &
      column_type('moments', 'moment', words, words='initial,initial flight,final,final flight', &
      listed=.false., &
      meaning='the start and the end, and where the flight or rest of each began'), &
      column_type('moments', 'quantities', each='quantity', unit='mixed', listed=.false., &
      meaning='number of the load cycle, phase in it (rad), x, x_dot, z, z_dot, departure speed'), &
      column_type('moments', 'contact', wholes, each='flag', listed=.false., &
      meaning='wall (1 right, -1 left, 0 none), whether the free mass rests on it, whether it was &
      &just released')]

   type(key_type), parameter :: structure_keys(*) = [ &
      key_type('duration', low=0.0_wp, high=longest, may_miss=.true., or='cycles', &
      meaning='time to simulate; without it and cycles, up to the last sample of a record'), &
      key_type('cycles', low=0.0_wp, high=1.0e9_wp, may_miss=.true., or='duration', &
      takes='a number of load cycles with 0 <= cycles <= 1e9', &
      meaning='load cycles to simulate; fractions are allowed'), &
      key_type('discard', default='0', low=0.0_wp, high=longest, &
      meaning='load cycles (if cycles is given, else time) simulated before those that are kept'), &
      start_keys, &
      key_type('max_events', a_whole, default='1000000', low=1.0_wp, high=1.0e8_wp, &
      meaning='events after which the simulation stops')]

   type(column_type), parameter :: own_structure_columns(*) = [ &
      column_type('events', 'time', unit='1/omega', meaning='time'), &
      column_type('events', 'kind', words, words=event_kinds, &
      meaning='kind; touch to press belong to stops, halt to slip_down to friction'), &
      column_type('events', 'gap', wholes, &
      meaning='number of the gap, stop or friction, from 0; friction is numbered after gaps and &
      &stops'), &
      column_type('events', 'speed', unit='omega F0/K', &
      meaning='approach speed; for a stop the rate of its opening'), &
      column_type('events', 'impulse', unit='F0/omega', meaning='impulse'), &
      column_type('events', 'q', unit='F0/K', each='coordinate', label='q_#', &
      meaning='coordinates'), &
      column_type('events', 'q_dot', unit='omega F0/K', each='coordinate', label='q_dot_#', &
      meaning='velocities just after the event'), &
      column_type('events', 'outputs', unit='F0/K', each='output', label='#', meaning='outputs'), &
      column_type('events', 'output_rates', unit='omega F0/K', each='output', label='#_dot', &
      meaning='their velocities just after the event'), &
      column_type('moments', 'moment', words, words='initial,final', listed=.false., &
      meaning='the start and the end'), &
      column_type('moments', 'time', unit='1/omega', listed=.false., meaning='time'), &
      column_type('moments', 'q', unit='F0/K', each='coordinate', listed=.false., &
      meaning='coordinates'), &
      column_type('moments', 'q_dot', unit='omega F0/K', each='coordinate', listed=.false., &
      meaning='velocities'), &
      column_type('rests', 'gap', wholes, listed=.false., &
      meaning='number of a gap that rests from start to end'), &
      column_type('run', 'frequency', unit='omega', listed=.false., &
      meaning='circular frequency of the load; 0 if there is none'), &
      column_type('run', 'loaded', truths, listed=.false., meaning='whether there is a load'), &
      column_type('run', 'finished', truths, listed=.false., &
      meaning='whether the end was reached before max_events events'), &
      column_type('run', 'step', unit='1/omega', listed=.false., &
      meaning='time between the samples of a record; 0 without a record'), &
      column_type('record', 'value', each='channel', listed=.false., &
      meaning='samples of a record, which is linear between them'), &
      column_type('channels', 'weight', each='coordinate', listed=.false., &
      meaning='forces on the coordinates for a value of 1 in a column of the record'), &
      structure_columns]

contains

   !> Declares the study, with its keys and columns.
   pure subroutine declare_simulate(study, keys, columns)
      !> The study.
      type(study_type), intent(out), optional :: study
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) then
         call list_for(of_oscillator, simulate_keys, keys)
         call list_for(of_structure, structure_keys, keys)
      end if
      if (present(columns)) then
         call list_for(of_oscillator, simulate_columns, columns)
         call list_for(of_structure, own_structure_columns, columns)
      end if
      if (.not. present(study)) return
      study%name = 'simulate'
      study%takes_elements = .true.
      study%takes_walls = .true.
      study%meaning = 'simulate from an initial state'
      study%row = 'events'
      study%check => check_simulate
      study%memory => simulate_memory
      study%run => run_simulate
   end subroutine declare_simulate

   !> Checks the rules that involve several keys.
   subroutine check_simulate(case)
      !> The case.
      type(case_type), intent(inout) :: case
      real(wp) :: least

      if (len(case%study%fault) > 0) return
      if (case%model == of_structure) then
         call check_structure(case)
         return
      end if
      associate (s => case%study)
         call check_start(s, s%number('clearance'))
         if (len(s%fault) > 0) return
         least = least_clearance(new_forced_system(case%osc, case%r, s%number('load'), &
            s%number('clearance')), s%number('x'))
         ! what is shown may be rounded down
         if (s%number('clearance') < least) call s%refuse('clearance', 'it must be at least '// &
            shown(1.06_wp*least, 'es9.1')//', a million times the rounding error of the &
            &displacements')
      end associate
   end subroutine check_simulate

   !> Simulates a case.
   subroutine run_simulate(case, threads, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(event_type), allocatable :: events(:)
      type(state_type) :: moments(4)
      real(wp) :: state(5), quantities(7, 4)
      integer :: contact(3, 4), status, i
      character(*), parameter :: names(7) = [character(9) :: 'xi', 'mu', 'R1', 'R2', 'r', &
         'clearance', 'load']
      real(wp) :: values(7)
      logical :: room

      associate (not_used => threads)    ! one simulation has one thread
      end associate
      if (case%model == of_structure) then
         call run_structure(case, result, progress)
         return
      end if
      associate (s => case%study)
         call simulate_case(new_forced_system(case%osc, case%r, s%number('load'), &
            s%number('clearance')), &
            state_of(s), s%number('cycles'), s%number('discard'), s%whole_number('max_events'), &
            moments, events, status, progress)
         values = [case%osc%xi, case%osc%mu, case%osc%restitution, case%r, s%number('clearance'), &
            s%number('load')]
         if (status == stat%more_events .and. size(events) < s%whole_number('max_events')) then
            result%empty = .true.
            call result%fail('max_events = '//whole(s%whole_number('max_events'))//': must be &
               &larger; it was reached within the discarded cycles')
            return
         end if
      end associate
      room = has_memory(event_bytes*size(events))
      if (.not. room) status = stat%no_memory
      if (status == stat%no_memory) then
         result%empty = .true.
         result%no_memory = .true.
         call result%fail(status_text(status)//': the events so far, '//whole(size(events))// &
            ', leave no memory for more; simulate fewer load cycles at a time, or give a smaller &
            &max_events')
         return
      else if (status == stat%not_computed) then
         result%cut = 'the simulation was stopped after '//whole(count(events%kind == &
            impact_event))//' impacts of the cycles kept'
         result%empty = size(events) == 0
         if (result%empty) return
      else if (status /= stat%ok .and. status /= stat%more_events) then
         result%empty = .true.
         call result%fail(status_text(status))
         return
      end if
      associate (final => moments(3))
         state = [state_time(final%cycle, final%phase, case%r), final%x, final%x_dot, final%z, &
            final%z_dot]
      end associate
      call result%open('final', '', [integer ::])
      call result%put('final', 'state', state)
      call result%open('run', '', [integer ::])
      do i = 1, size(names)
         call result%put('run', trim(names(i)), values(i:i))
      end do
      call result%put('run', 'finished', [merge(1, 0, status == stat%ok)])
      call result%open('moments', 'moment', [4])
      call result%put('moments', 'moment', [1, 2, 3, 4])
      do i = 1, 4
         call pack_state(moments(i), quantities(:, i), contact(:, i))
      end do
      call result%put('moments', 'quantities', [quantities])
      call result%put('moments', 'contact', [contact])
      call result%open('events', 'event', [size(events)])
      call result%put('events', 'time', [(state_time(events(i)%cycle, events(i)%phase, case%r), &
         i=1, size(events))])
      call result%put('events', 'kind', events%kind)
      call result%put('events', 'side', merge(1, 2, events%side > 0))
      call result%put('events', 'phase', events%phase)
      call result%put('events', 'x', events%x)
      call result%put('events', 'x_dot_before', events%x_dot_before)
      call result%put('events', 'x_dot_after', events%x_dot_after)
      call result%put('events', 'z_dot_before', events%z_dot_before)
      call result%put('events', 'z_dot_after', events%z_dot_after)
      if (status == stat%more_events) call result%remark('cut short: max_events was reached')
      call result%remark('final state: t, x, x_dot, z, z_dot = '//exact_list(state))
      call result%add_note(counted(count(events%kind == impact_event), &
         'impact')//', '//counted(count( &
         events%kind == stick_event), 'rest'))
      ! this rest began before what is kept
      if (moments(1)%resting .and. .not. any(events%kind == release_event)) call result%add_note( &
         'the free mass rests on '//merge('R', 'L', moments(1)%side > 0)//' all the time')
      if (status == stat%more_events) call result%fail('cut short, max_events was reached')
   end subroutine run_simulate

   !> Checks those of a structure.
   subroutine check_structure(case)
      !> The case.
      type(case_type), intent(inout) :: case
      real(wp) :: end_of_record

      associate (study => case%study)
         call check_start_state(case)
         if (len(study%fault) > 0 .or. study%has('duration')) return
         if (.not. study%has('cycles')) then
            end_of_record = record_end(case)
            if (end_of_record < 0) then
               call study%refuse('duration', 'or give cycles')
               return
            end if
            end_of_record = end_of_record - study%number('start') - study%number('discard')
            if (.not. end_of_record <= longest) then
               call study%refuse('duration', 'the record is longer than that')
            else
               call study%set('duration', [max(0.0_wp, end_of_record)])
            end if
         else if (.not. load_frequency(case) > 0) then
            call study%refuse('cycles', 'it requires a &load with a frequency; otherwise give &
               &duration')
         else if (.not. span(case, 'cycles') <= longest) then
            call study%refuse('cycles', 'they must take at most '//trim(number_text(longest, &
               .false.))//' units of time')
         else if (.not. span(case, 'discard') <= longest) then
            call study%refuse('discard', 'they must take at most '//trim(number_text(longest, &
               .false.))//' units of time')
         end if
      end associate
   end subroutine check_structure

   !> The time of a key that may count load cycles.
   pure real(wp) function span(case, key)
      !> The case.
      type(case_type), intent(in) :: case
      !> The key: `cycles`, `duration` or `discard`.
      character(*), intent(in) :: key

      span = case%study%number(key)
      if (case%study%has('cycles')) span = span*2*pi/load_frequency(case)
   end function span

   !> Bytes for the matrices of a structure and those that follow from them; the events are checked
   !! while they are found.
   pure real(wp) function simulate_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case
      real(wp), allocatable :: samples(:, :), weights(:, :)

      bytes = 0
      if (case%model /= of_structure) return
      call record_of(case, samples, weights)
      ! the case, the load, the run and the result each have a copy of the record
      bytes = 400.0_wp*real(case%coordinates, wp)**2 + 24.0_wp*size(samples, 2)* &
         (case%coordinates + size(samples, 1))
   end function simulate_memory

   !> Simulates a structure.
   subroutine run_structure(case, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(structure_type) :: structure
      type(load_type) :: load
      real(wp), allocatable :: table(:, :)
      integer, allocatable :: labels(:, :)
      real(wp), allocatable :: first_state(:), last_state(:)
      integer, allocatable :: resting(:)
      character(:), allocatable :: text
      real(wp) :: start, first, end_time
      integer :: i, n, most, status
      logical :: room

      call structure_of(case, structure, load)
      start = case%study%number('start')
      most = case%study%whole_number('max_events')
      first = start + span(case, 'discard')
      associate (s => case%study)
         call simulate_structure_case(structure, load, start, s%numbers('q'), s%numbers('q_dot'), &
            first + span(case, trim(merge('cycles  ', 'duration', s%has('cycles')))), most, table, &
            labels, n, last_state, end_time, status, progress, first, first_state, resting)
      end associate
      if (status == stat%event_limit) then
         result%empty = .true.
         call result%fail('max_events = '//whole(most)//': must be larger; it was reached within &
            &the discarded time')
         return
      end if
      ! the table, once more in the columns of the result, and room to make them
      room = has_memory(24.0_wp*size(table, 1)*n)
      if (.not. room) status = stat%no_memory
      if (status == stat%no_memory) then
         result%empty = .true.
         result%no_memory = .true.
         call result%fail(status_text(status)//': the events so far, '//whole(n)// &
            ', leave no memory for more; simulate a shorter time, or give a smaller max_events')
         return
      else if (status == stat%not_computed) then
         result%cut = 'the simulation was stopped after '//counted(count(labels(1, :n) == &
            hit_event), 'impact')
         result%empty = end_time < first
         if (result%empty) return
      else if (status /= stat%ok .and. status /= stat%more_events) then
         result%empty = .true.
         call start_fault(structure, load, case%study%numbers('q'), status, text)
         call result%fail(text)
         return
      end if
      call put_events(result, table(:, :n), labels(:, :n), &
         output_rows(case%system, case%coordinates))
      call put_moments(result, [first, end_time], first_state, last_state)
      call result%open('rests', 'rest', [size(resting)])
      call result%put('rests', 'gap', resting - 1)
      call put_structure(result, structure, load)
      call result%open('run', '', [integer ::])
      call result%put('run', 'frequency', [load_frequency(case)])
      call result%put('run', 'loaded', [merge(1, 0, case%parts(size(case%parts))%name == 'load')])
      call result%put('run', 'finished', [merge(1, 0, status == stat%ok)])
      call result%put('run', 'step', [load%step])
      call put_record(result, case)
      if (status == stat%more_events) call result%remark('cut short: max_events was reached')
      call result%remark('final time: '//exact(end_time))
      call result%add_note(counted(count(labels(1, :n) == hit_event), 'impact')//', '// &
         counted(count(labels(1, :n) == rest_event), 'rest'))
      if (any(labels(1, :n) == touch_event)) call result%add_note(counted(count(labels(1, :n) == &
         touch_event), 'contact')//' with stops')
      if (any(labels(1, :n) == halt_event)) call result%add_note(counted(count(labels(1, :n) == &
         halt_event), 'halt')//' by friction')
      do i = 1, size(resting)
         call result%add_note('gap '//whole(resting(i) - 1)//' rests all the time')
      end do
      if (status == stat%more_events) call result%fail('cut short, max_events was reached')
   end subroutine run_structure

   !> Fills the table of events.
   pure subroutine put_events(result, table, labels, outputs)
      !> The result.
      type(result_type), intent(inout) :: result
      !> (3 + 2n, events) and (2, events), as of `simulate_structure_arrays`.
      real(wp), intent(in) :: table(:, :)
      !> As in `table`.
      integer, intent(in) :: labels(:, :)
      !> (outputs, n) The outputs as rows that give them from the coordinates.
      real(wp), intent(in) :: outputs(:, :)
      integer :: n, m

      n = (size(table, 1) - 3)/2
      m = size(outputs, 1)
      call result%open('events', 'event', [size(labels, 2)])
      call result%put('events', 'time', table(1, :))
      call result%put('events', 'kind', labels(1, :))
      call result%put('events', 'gap', labels(2, :) - 1)
      call result%put('events', 'speed', table(2, :))
      call result%put('events', 'impulse', table(3, :))
      call result%put('events', 'q', [table(4:3 + n, :)], n)
      call result%put('events', 'q_dot', [table(4 + n:, :)], n)
      if (m == 0) return
      call result%put('events', 'outputs', [matmul(outputs, table(4:3 + n, :))], m)
      call result%put('events', 'output_rates', [matmul(outputs, table(4 + n:, :))], m)
   end subroutine put_events

   !> Fills the tables of the record.
   pure subroutine put_record(result, case)
      !> The result.
      type(result_type), intent(inout) :: result
      !> The case.
      type(case_type), intent(in) :: case
      real(wp), allocatable :: samples(:, :), weights(:, :)

      call record_of(case, samples, weights)
      call result%open('record', 'sample', [size(samples, 2)])
      call result%put('record', 'value', [samples], size(samples, 1))
      call result%open('channels', 'channel', [size(samples, 1)])
      call result%put('channels', 'weight', [weights], case%coordinates)
   end subroutine put_record

   !> Fills the table of the start and the end.
   pure subroutine put_moments(result, times, first_state, last_state)
      !> The result.
      type(result_type), intent(inout) :: result
      !> Times of the start and of the end of what is kept.
      real(wp), intent(in) :: times(2)
      !> (2n) Coordinates and velocities at both.
      real(wp), intent(in) :: first_state(:), last_state(:)
      integer :: n

      n = size(first_state)/2
      call result%open('moments', 'moment', [2])
      call result%put('moments', 'moment', [1, 2])
      call result%put('moments', 'time', times)
      call result%put('moments', 'q', [first_state(:n), last_state(:n)])
      call result%put('moments', 'q_dot', [first_state(n + 1:), last_state(n + 1:)])
   end subroutine put_moments

end module vi_simulate_study
