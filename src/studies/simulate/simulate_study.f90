!> The study &simulate: a simulation from a state.
module vi_simulate_study
   use vi_common_keys, only: check_start, clearance_key, load_key, state_keys, state_of
   use vi_forced_system, only: least_clearance, new_forced_system, state_time, state_type
   use vi_kinds, only: wp
   use vi_processor, only: has_memory
   use vi_simulate, only: event_type, impact_event, release_event, stick_event
   use vi_status, only: stat, status_text
   use vi_study, only: a_whole, case_type, column_type, key_type, result_type, study_type, truths, &
      wholes, words
   use vi_text, only: counted, exact_list, shown, whole
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
      meaning='load cycles simulated before the ones that are kept'), &
      load_key, state_keys, &
      key_type('max_events', a_whole, default='10000000', low=1.0_wp, high=most_kept, &
      meaning='events after which the simulation is cut short')]

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
      meaning='load cycle, load phase above it (rad), x, x_dot, z, z_dot, departure speed'), &
      column_type('moments', 'contact', wholes, each='flag', listed=.false., &
      meaning='wall (1 right, -1 left, 0 none), whether the free mass rests on it, whether it was &
      &released just then')]

contains

   !> Declares the study.
   subroutine declare_simulate(study)
      !> The declaration of the study.
      type(study_type), intent(out) :: study

      study%name = 'simulate'
      study%meaning = 'simulate from an initial state'
      study%list => list_simulate
      study%row = 'events'
      study%check => check_simulate
      study%run => run_simulate
   end subroutine declare_simulate

   !> Lists the keys and columns.
   pure subroutine list_simulate(keys, columns)
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) keys = simulate_keys
      if (present(columns)) columns = simulate_columns
   end subroutine list_simulate

   !> Checks the rules that involve several keys.
   subroutine check_simulate(case)
      !> The case.
      type(case_type), intent(inout) :: case
      real(wp) :: least

      if (len(case%study%fault) > 0) return
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
               &more; it was reached within the discarded cycles')
            return
         end if
      end associate
      room = has_memory(event_bytes*size(events))
      if (.not. room) status = stat%no_memory
      if (status == stat%no_memory) then
         result%empty = .true.
         result%no_memory = .true.
         call result%fail(status_text(status)//': the events so far, '//whole(size(events))// &
            ', leave no room for more; simulate fewer load cycles at a time, or give a smaller &
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

end module vi_simulate_study
