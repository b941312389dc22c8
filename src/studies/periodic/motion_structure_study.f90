!> The study &motion of a &structure: a periodic motion with its multipliers and verdicts.
module vi_motion_structure_study
   use vi_common_keys, only: most_state
   use vi_kinds, only: wp
   use vi_status, only: stat, status_text
   use vi_structure, only: load_type, structure_type
   use vi_structure_groups, only: complete_coordinates, load_frequency, most_coordinates, &
      structure_of
   use vi_structure_keys, only: of_coordinates
   use vi_structure_period, only: eliminated, exact, periodic_structure
   use vi_structure_return, only: settle, settled_type
   use vi_structure_tables, only: put_structure, structure_columns
   use vi_study, only: a_whole, a_word, case_type, column_type, complexes, key_type, result_type, &
      study_type, values_type, verdicts, wholes
   use vi_text, only: counted, number_text, whole
   implicit none (type, external)
   private

   public :: check_structure_motion, declare_motion_structure, find_structure_motion

   integer, parameter :: most_impacts = 1000
   real(wp), parameter :: pi = acos(-1.0_wp), largest_phase = 1.0e6_wp
   character(*), parameter :: settled = 'kind=settled', simulated = ', which simulates'

   type(key_type), parameter :: motion_keys(*) = [ &
      key_type('kind', a_word, default='''exact''', words='periodic exact settled', &
      takes='''periodic'' (phases presumed, the linear equations), ''exact'' (phases guessed) or &
      &''settled'' (simulated until it repeats)', meaning='how the motion is given'), &
      key_type('cycles', a_whole, low=1.0_wp, high=10000.0_wp, may_miss=.true., &
      meaning='load cycles in a period; 1 if it is left out, or with kind = ''settled'' those &
      &that repeat best'), &
      key_type('gaps', a_whole, most=most_impacts, low=0.0_wp, never=settled, why=simulated, &
      takes='the number of a gap, from 0, for each impact, 1 to 1000 of them', &
      meaning='gaps of the impacts in order'), &
      key_type('phases', most=most_impacts, or='phases_over_pi', never=settled, why=simulated, &
      takes='one number for each impact, increasing, within less than a period of each other', &
      unit='rad', meaning='load phases of the impacts'), &
      key_type('phases_over_pi', most=most_impacts, or='phases', never=settled, why=simulated, &
      takes='one number for each impact, increasing, within less than a period of each other', &
      is='phases', factor=pi, unit='pi rad', meaning='load phases of the impacts in units of pi'), &
      key_type('settling', a_whole, default='300', low=0.0_wp, high=1.0e6_wp, only=settled, &
      meaning='load cycles simulated first'), &
      key_type('max_cycles', a_whole, default='16', low=1.0_wp, high=100.0_wp, only=settled, &
      meaning='most load cycles in a period'), &
      key_type('q', most=most_coordinates, may_miss=.true., low=-most_state, high=most_state, &
      only=settled, takes=of_coordinates, &
      meaning='coordinates at the start; 0 if it is left out'), &
      key_type('q_dot', most=most_coordinates, may_miss=.true., low=-most_state, &
      high=most_state, only=settled, takes=of_coordinates, &
      meaning='velocities at the start; 0 if it is left out'), &
      key_type('start', low=0.0_wp, high=1.0e12_wp, default='0', only=settled, &
      meaning='time at the start')]

   type(column_type), parameter :: motion_columns(*) = [ &
      column_type('impacts', 'impact', wholes, meaning='number of the impact'), &
      column_type('impacts', 'gap', wholes, meaning='number of the gap, from 0'), &
      column_type('impacts', 'phase', unit='rad', meaning='load phase'), &
      column_type('impacts', 'speed', meaning='approach speed'), &
      column_type('impacts', 'impulse', meaning='impulse'), &
      column_type('impacts', 'q', each='coordinate', label='q_#', meaning='coordinates'), &
      column_type('impacts', 'q_dot', each='coordinate', label='q_dot_#', &
      meaning='velocities just after the impact'), &
      column_type('motion', 'cycles', wholes, listed=.false., meaning='load cycles in a period'), &
      column_type('motion', 'residual', listed=.false., &
      meaning='largest relative residual of the equations'), &
      column_type('motion', 'determinant', listed=.false., meaning='det[P]'), &
      column_type('motion', 'law', listed=.false., &
      meaning='the value that the damping and the impacts give det[P]'), &
      column_type('motion', 'consistent', verdicts, listed=.false., &
      meaning='whether it solves all equations'), &
      column_type('motion', 'admissible', verdicts, listed=.false., &
      meaning='whether all gaps stay open between the impacts'), &
      column_type('motion', 'stable', verdicts, listed=.false., &
      meaning='whether disturbances decay'), &
      column_type('motion', 'frequency', listed=.false., &
      meaning='circular frequency of the load'), &
      column_type('multipliers', 'multiplier', complexes, listed=.false., &
      meaning='eigenvalues of [P], by decreasing modulus'), &
      column_type('derivative', 'P', each='state', listed=.false., &
      meaning='[P], the derivative of the period of coordinates and velocities'), &
      column_type('rests', 'gap', wholes, listed=.false., meaning='gap that rests, from 0'), &
      column_type('rests', 'begin', unit='rad', listed=.false., &
      meaning='load phase at which it begins to rest'), &
      column_type('rests', 'end', unit='rad', listed=.false., &
      meaning='load phase at which it opens'), structure_columns]

contains

   !> Declares the study.
   subroutine declare_motion_structure(study)
      !> The declaration of the study.
      type(study_type), intent(out) :: study

      study%name = 'motion_structure'
      study%group = 'motion'
      study%of_structure = .true.
      study%meaning = 'find a periodic motion of a structure with gaps'
      study%list => list_motion
      study%row = 'impacts'
      study%check => check_motion
      study%memory => motion_memory
      study%run => run_motion
   end subroutine declare_motion_structure

   !> Lists the keys and columns.
   pure subroutine list_motion(keys, columns)
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) keys = motion_keys
      if (present(columns)) columns = motion_columns
   end subroutine list_motion

   !> Checks the rules that involve several keys.
   subroutine check_motion(case)
      !> The case.
      type(case_type), intent(inout) :: case
      type(values_type) :: group

      group = case%study
      call check_structure_motion(case, group)
      case%study = group
   end subroutine check_motion

   !> Checks a &motion of a case, its own or the one from which its study starts.
   subroutine check_structure_motion(case, group)
      !> The case; its structure and load are used.
      type(case_type), intent(in) :: case
      !> In and out: the group.
      type(values_type), intent(inout) :: group
      integer :: gaps, i

      if (len(group%fault) > 0) return
      if (.not. load_frequency(case) > 0) then
         if (group%is('kind', 'settled')) then
            call group%refuse('kind', 'it goes with a &load that has a frequency')
         else
            call group%refuse('gaps', 'they go with a &load that has a frequency')
         end if
         return
      end if
      if (group%is('kind', 'settled')) then
         call complete_coordinates(group, 'q', case%coordinates)
         call complete_coordinates(group, 'q_dot', case%coordinates)
         return
      end if
      if (.not. group%has('cycles')) call group%set('cycles', [1.0_wp])
      gaps = count([(case%parts(i)%name == 'gap', i=1, size(case%parts))])
      if (any(group%numbers('gaps') >= gaps)) then
         call group%refuse('gaps', 'the structure has '//counted(gaps, 'gap'))
         return
      end if
      call check_phases(group)
      if (.not. group%is('kind', 'periodic')) return
      do i = 1, gaps
         if (.not. any(nint(group%numbers('gaps')) == i - 1)) cycle
         if (.not. case%parts(i)%is('law', 'constant')) call group%refuse('kind', &
            '''exact'' where the restitution of a gap depends on the speed')
      end do
   end subroutine check_structure_motion

   !> Checks that the phases increase within a period.
   subroutine check_phases(study)
      !> The group.
      type(values_type), intent(inout) :: study
      real(wp), allocatable :: phases(:)
      real(wp) :: period
      integer :: i, n

      allocate (phases, source=study%numbers('phases'))
      n = size(study%numbers('gaps'))
      period = 2*pi*study%whole_number('cycles')
      if (size(phases) /= n) then
         call study%refuse('phases', counted(size(phases), 'number')//' for '//counted(n, &
            'impact')//' in gaps')
      else if (any(abs(phases) > largest_phase)) then
         call study%refuse('phases', 'they must be at most '//trim(number_text(largest_phase, &
            .false.))//' rad in magnitude')
      else if (.not. phases(n) - phases(1) < period) then
         call study%refuse('phases', 'the last must be less than a period after the first')
      else
         do i = 2, n
            if (phases(i) < phases(i - 1)) call study%refuse('phases', 'number '//whole(i)// &
               ' is below number '//whole(i - 1))
         end do
      end if
   end subroutine check_phases

   !> Bytes for the matrices of the structure and those that follow from them.
   pure real(wp) function motion_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case
      real(wp) :: impacts

      impacts = 2000
      if (case%study%has('gaps')) impacts = size(case%study%numbers('gaps'))
      bytes = 600.0_wp*real(case%coordinates, wp)**2 + 100*(impacts + case%coordinates)**2
   end function motion_memory

   !> Computes a case.
   subroutine run_motion(case, threads, result, progress)
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
      type(settled_type) :: found
      integer :: status

      associate (not_used => threads)    ! one motion has one thread
      end associate
      if (present(progress)) progress(2) = 1
      call find_structure_motion(case, case%study, .false., structure, load, found, status, &
         progress)
      result%empty = status /= stat%ok
      if (status == stat%not_computed) then
         result%cut = 'it was stopped before a motion was reached'
         return
      end if
      if (status /= stat%ok) then
         call result%fail(status_text(status))
         return
      end if
      call put_motion(result, found, load%frequency)
      call put_structure(result, structure, load)
      call result%add_note(counted(size(found%gaps), 'impact')//' and '// &
         counted(size(found%resting), 'rest')//' in '//counted(found%cycles, 'load cycle'))
   end subroutine run_motion

   !> The motion that a &motion describes.
   subroutine find_structure_motion(case, group, refined, structure, load, found, status, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> The group.
      type(values_type), intent(in) :: group
      !> Whether the phases of a periodic motion are taken as a guess of an exact one.
      logical, intent(in) :: refined
      !> The structure, completed, and its load.
      type(structure_type), intent(out) :: structure
      type(load_type), intent(out) :: load
      !> The motion.
      type(settled_type), intent(out) :: found
      !> As in `settle` or `periodic_structure`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      integer :: cycles

      call structure_of(case, structure, load)
      load%frequency = load_frequency(case)
      if (group%is('kind', 'settled')) then
         cycles = 0
         if (group%has('cycles')) cycles = group%whole_number('cycles')
         call settle(structure, load, group%number('start'), group%numbers('q'), &
            group%numbers('q_dot'), group%whole_number('settling'), &
            group%whole_number('max_cycles'), cycles, found, status, progress)
      else
         found%gaps = nint(group%numbers('gaps')) + 1
         found%cycles = group%whole_number('cycles')
         allocate (found%resting(0), found%rests(2, 0))
         call periodic_structure(structure, load, found%gaps, group%numbers('phases'), &
            found%cycles, merge(eliminated, exact, group%is('kind', 'periodic') .and. &
            .not. refined), found%motion, status)
      end if
   end subroutine find_structure_motion

   !> Fills the tables of the motion.
   pure subroutine put_motion(result, found, frequency)
      !> The result.
      type(result_type), intent(inout) :: result
      !> The motion.
      type(settled_type), intent(in) :: found
      !> Circular frequency of the load.
      real(wp), intent(in) :: frequency
      integer :: i, n

      associate (motion => found%motion, verdicts => found%motion%verdicts)
         n = size(motion%states, 1)/2
         call result%open('impacts', 'impact', [size(found%gaps)])
         call result%put('impacts', 'impact', [(i, i=1, size(found%gaps))])
         call result%put('impacts', 'gap', found%gaps - 1)
         call result%put('impacts', 'phase', motion%phases)
         call result%put('impacts', 'speed', motion%speeds)
         call result%put('impacts', 'impulse', motion%impulses)
         call result%put('impacts', 'q', [motion%states(:n, :)], n)
         call result%put('impacts', 'q_dot', [motion%states(n + 1:, :)], n)
         call result%open('motion', '', [integer ::])
         call result%put('motion', 'cycles', [found%cycles])
         call result%put('motion', 'residual', [motion%residual])
         call result%put('motion', 'determinant', [verdicts%determinant])
         call result%put('motion', 'law', [verdicts%law])
         call result%put('motion', 'consistent', [verdicts%consistent])
         call result%put('motion', 'admissible', [verdicts%admissible])
         call result%put('motion', 'stable', [verdicts%stable])
         call result%put('motion', 'frequency', [frequency])
         call result%open('multipliers', 'multiplier', [2*n])
         call result%put('multipliers', 'multiplier', verdicts%multipliers)
         call result%open('derivative', 'state_row', [2*n])
         call result%put('derivative', 'P', [transpose(verdicts%p)], 2*n)
         call result%open('rests', 'rest', [size(found%resting)])
         call result%put('rests', 'gap', found%resting - 1)
         call result%put('rests', 'begin', found%rests(1, :))
         call result%put('rests', 'end', found%rests(2, :))
      end associate
   end subroutine put_motion

end module vi_motion_structure_study
