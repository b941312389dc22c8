!> The study &motion: a motion from its phases (eq. 26), from its clearance, or the equispaced pair.
module vi_motion_study
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
   use vi_chain, only: equispaced_chain, exact_chain, periodic_chain, refine
   use vi_common_keys, only: cycles_key, most_state
   use vi_kinds, only: pi, wp
   use vi_motion, only: motion_type, start_motion, unknown, yes
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: default_restitution, new_pattern, pattern_type, side_symbols, &
      starred_symbols
   use vi_periodic, only: linear_system_type
   use vi_precision, only: equispaced_in_single, periodic_in_single
   use vi_result, only: rows_of
   use vi_stability, only: leading_kind
   use vi_status, only: stat, status_text
   use vi_presumed_events, only: kinds_of, presume, sequence_fault
   use vi_structure, only: check_structure, load_type, structure_type
   use vi_structure_found, only: derivative_columns, impact_columns
   use vi_structure_groups, only: complete_coordinates, load_frequency, most_coordinates, &
      record_end, structure_of
   use vi_structure_keys, only: of_coordinates
   use vi_structure_period, only: eliminated, exact, periodic_structure
   use vi_structure_return, only: self_excited, settle, settled_type
   use vi_structure_tables, only: put_structure, structure_columns
   use vi_study, only: a_whole, a_word, case_type, column_type, complexes, key_type, list_for, &
      of_oscillator, of_structure, result_type, study_type, values_type, verdicts, wholes, words
   use vi_text, only: counted, line_type, number_text, shown, whole
   implicit none (type, external)
   private

   public :: check_motion, check_structure_motion, declare_motion, find_motions, &
      find_structure_motion, motion_request, put_motions, put_origin

   integer, parameter :: most_impacts = 1000

   character(*), parameter :: known = ', which determines it', equispaced = 'kind=equispaced'
   type(key_type), parameter :: motion_keys(*) = [ &
      key_type('kind', a_word, default='''periodic''', words='periodic equispaced exact', &
      takes='''periodic'' (phases given), ''equispaced'' (clearance given) or ''exact'' &
      &(clearance given, phases guessed)', meaning='how the motion is given'), &
      cycles_key, &
      key_type('clearance', low=1.0e-12_wp, high=1.0e12_wp, never='kind=periodic', &
      why=', which finds the clearance', unit='F0/K', &
      meaning='clearance d K/F0; d is the whole travel of m between the walls'), &
      key_type('sides', a_word, never=equispaced, why=known, &
      takes='letters R and L, one for each impact, 2 to 1000 of them, each wall at least once', &
      meaning='walls of the impacts in order, for example RRL'), &
      key_type('phases', most=most_impacts, or='phases_over_pi', never=equispaced, why=known, &
      takes='one number for each impact, increasing from 0 to below 2 pi cycles', unit='rad', &
      meaning='load phases of the impacts, relative to the first one'), &
      key_type('phases_over_pi', most=most_impacts, or='phases', never=equispaced, why=known, &
      takes='one number for each impact, increasing from 0 to below 2 cycles', is='phases', &
      factor=pi, unit='pi rad', &
      meaning='load phases of the impacts in units of pi, relative to the first one'), &
      key_type('positions', most=most_impacts, only='kind=exact', may_miss=.true., &
      unit='F0/K', takes='one number for each impact, each with |x| <= 1e12', &
      meaning='guessed displacements of the primary mass at the impacts; by default from equations &
      &(26), (30)'), &
      key_type('tau', low=-1.0e6_wp, high=1.0e6_wp, only='positions', may_miss=.true., &
      unit='rad', meaning='guessed phase of equation (4)'), &
      key_type('impact_restitution', most=most_impacts, low=0.0_wp, high=1.0_wp, &
      never=equispaced, why=known, may_miss=.true., &
      takes='one number for each impact, each with 0 <= R <= 1', &
      meaning='a coefficient of restitution for each impact; by default that of the wall'), &
      key_type('precision', a_word, default='''double''', words='double single', &
      meaning='arithmetic; ''single'' only with given phases or kind = ''equispaced'''), &
      key_type('acceptance', default='0.03', low=0.0_wp, high=1.0_wp, never='kind=exact', &
      why=', which leaves no residual', &
      meaning='largest relative residual that counts as consistent')]

   !> Columns of the motions and their impacts. At impacts a motion has the paper's X and Z; tables
   !! show them as the coordinates x and z of all other studies.
   type(column_type), parameter :: oscillator_columns(*) = [ &
      column_type('motions', 'motion', wholes, meaning='number of the motion'), &
      column_type('impacts', 'impact', wholes, meaning='number of the impact'), &
      column_type('impacts', 'side', words, words='R,L,R*,L*', &
      meaning='wall; with a star where impacts accumulate there and end in rest'), &
      column_type('impacts', 'restitution', meaning='coefficient of restitution'), &
      column_type('impacts', 'phase', unit='rad', meaning='load phase, relative to the first &
      &impact'), &
      column_type('impacts', 'X', label='x', unit='F0/K', &
      meaning='displacement of the primary mass'), &
      column_type('impacts', 'Z', label='z', unit='F0/K', &
      meaning='displacement of the free mass'), &
      column_type('impacts', 'X_dot_before', label='x_dot_before', unit='omega F0/K', &
      meaning='velocity of the primary mass before the impact'), &
      column_type('impacts', 'X_dot_after', label='x_dot_after', unit='omega F0/K', &
      meaning='velocity of the primary mass after the impact'), &
      column_type('impacts', 'Z_dot_before', label='z_dot_before', unit='omega F0/K', &
      meaning='velocity of the free mass before the impact'), &
      column_type('impacts', 'Z_dot_after', label='z_dot_after', unit='omega F0/K', &
      meaning='velocity of the free mass after the impact'), &
      column_type('motions', 'r', meaning='frequency ratio'), &
      column_type('motions', 'clearance', unit='F0/K', &
      meaning='clearance d K/F0; d is the whole travel of m between the walls'), &
      column_type('motions', 'A', unit='F0/K', meaning='amplitude of the motion without impacts'), &
      column_type('motions', 'tau', unit='rad', meaning='load phase of the first impact'), &
      column_type('motions', 'residual', meaning='relative residual of (26), (30)'), &
      column_type('motions', 'consistent', verdicts, meaning='whether it solves all equations'), &
      column_type('motions', 'admissible', verdicts, &
      meaning='whether it stays between the walls'), &
      column_type('motions', 'stable', verdicts, meaning='whether disturbances decay'), &
      column_type('motions', 'x_min', unit='F0/K', &
      meaning='smallest displacement of the primary mass'), &
      column_type('motions', 'x_max', unit='F0/K', &
      meaning='greatest displacement of the primary mass'), &
      column_type('motions', 'attenuation', meaning='max|X|/A'), &
      column_type('motions', 'multipliers', complexes, each='multiplier', label='multiplier_#', &
      meaning='eigenvalues of [P], in order of decreasing modulus'), &
      column_type('motions', 'sides', words, listed=.false., &
      meaning='walls in the order of impacts'), &
      column_type('motions', 'cycles', wholes, listed=.false., &
      meaning='load cycles of the period'), &
      column_type('motions', 'status', wholes, listed=.false., &
      meaning='code of the failure; 0: none'), &
      column_type('motions', 'kind', words, words='periodic,equispaced,exact', listed=.false., &
      meaning='how it was found: from given phases, as equispaced, or exactly'), &
      column_type('motions', 'precision', words, words='double,single', listed=.false., &
      meaning='arithmetic'), &
      column_type('motions', 'load', unit='F0', listed=.false., meaning='load amplitude'), &
      column_type('motions', 'xi', listed=.false., meaning='damping ratio'), &
      column_type('motions', 'mu', listed=.false., meaning='mass ratio'), &
      column_type('motions', 'R1', listed=.false., &
      meaning='coefficient of restitution of the right wall'), &
      column_type('motions', 'R2', listed=.false., &
      meaning='coefficient of restitution of the left wall'), &
      column_type('motions', 'M', listed=.false., &
      meaning='primary mass in the units of `units`, if known'), &
      column_type('motions', 'K', listed=.false., meaning='stiffness in these units, if known'), &
      column_type('motions', 'F0', listed=.false., &
      meaning='load amplitude in these units, if known'), &
      column_type('motions', 'units', words, listed=.false., &
      meaning='units of length, force and time, if known'), &
      column_type('impacts', 'guess', unit='rad', listed=.false., &
      meaning='guessed load phase of an exact motion, if the linear equations were solved first')]

   !> Columns of the events of motions with rest.
   type(column_type), parameter :: event_columns(*) = [ &
      column_type('events', 'time', unit='1/omega', listed=.false., &
      meaning='time since the first event of the period'), &
      column_type('events', 'kind', words, words='impact,stick,release', listed=.false., &
      meaning='kind of the event of a motion with rest'), &
      column_type('events', 'side', words, words='R,L', listed=.false., meaning='wall'), &
      column_type('events', 'phase', unit='rad', listed=.false., &
      meaning='load phase within a load cycle'), &
      column_type('events', 'x', unit='F0/K', listed=.false., &
      meaning='displacement of the primary mass'), &
      column_type('events', 'x_dot_before', unit='omega F0/K', listed=.false., &
      meaning='velocity of the primary mass before the event'), &
      column_type('events', 'x_dot_after', unit='omega F0/K', listed=.false., &
      meaning='velocity of the primary mass after the impact'), &
      column_type('events', 'z_dot_before', unit='omega F0/K', listed=.false., &
      meaning='velocity of the free mass before the impact'), &
      column_type('events', 'z_dot_after', unit='omega F0/K', listed=.false., &
      meaning='velocity of the free mass after the impact')]

   type(column_type), parameter, public :: motion_columns(*) = [oscillator_columns, event_columns]

   !> The words of the column `kind`, and the place of the last one.
   character(24), parameter :: kinds(3) = [character(24) :: 'periodic', 'equispaced', 'exact']
   integer, parameter, public :: exact_kind = 3

   !> The data of a group &motion.
   type, public :: motion_request_type
      !> 'periodic', 'equispaced' or 'exact'.
      character(24) :: kind = ''
      type(pattern_type) :: pattern
      !> Load phases and coefficients of restitution (n).
      real(wp), allocatable :: phases(:), restitution(:)
      !> If a whole motion is guessed: displacements at the impacts (n), otherwise (0), and tau.
      real(wp), allocatable :: positions(:)
      real(wp) :: tau = 0
      real(wp) :: clearance = 0, acceptance = 0
      logical :: single = .false.
   end type motion_request_type

   real(wp), parameter :: largest_phase = 1.0e6_wp
   character(*), parameter :: settled = 'kind=settled', simulated = ', which finds it by simulation'

   type(key_type), parameter :: structure_keys(*) = [ &
      key_type('kind', a_word, default='''exact''', words='periodic exact settled', &
      takes='''periodic'' (phases presumed, the linear equations), ''exact'' (phases guessed) or &
      &''settled'' (simulated until it repeats)', meaning='how the motion is given'), &
      key_type('cycles', a_whole, low=1.0_wp, high=10000.0_wp, may_miss=.true., &
      meaning='load cycles in a period; 1 if it is left out; with kind = ''settled'' the number &
      &that repeats best'), &
      key_type('gaps', a_whole, most=most_impacts, low=0.0_wp, never=settled, why=simulated, &
      takes='the number of a gap, stop or friction, from 0, for each event, 1 to 1000 of them', &
      meaning='gaps of the impacts in order; with kinds the gap, stop or friction of each event'), &
      key_type('kinds', a_word, most=most_impacts, may_miss=.true., never=settled, why=simulated, &
      words='impact stick release touch leave let_go press halt slip_up slip_down', &
      takes='the kind of each event in gaps: impact, stick, release of a gap; touch, leave, &
      &let_go, press of a stop; halt, slip_up, slip_down of friction, numbered after gaps and &
      &stops', &
      meaning='with stops, friction or rests: what happens in each event'), &
      key_type('phases', most=most_impacts, or='phases_over_pi', never=settled, why=simulated, &
      takes='one number for each event, not decreasing, within less than a period of each other', &
      unit='rad', meaning='load phases of the impacts, or of the events in kinds'), &
      key_type('phases_over_pi', most=most_impacts, or='phases', never=settled, why=simulated, &
      takes='one number for each event, not decreasing, within less than a period of each other', &
      is='phases', factor=pi, unit='pi rad', &
      meaning='load phases of the impacts, or of the events in kinds, in units of pi'), &
      key_type('settling', a_whole, default='300', low=0.0_wp, high=1.0e6_wp, only=settled, &
      meaning='load cycles simulated first'), &
      key_type('max_cycles', a_whole, default='16', low=1.0_wp, high=100.0_wp, only=settled, &
      meaning='largest number of load cycles in a period'), &
      key_type('q', most=most_coordinates, may_miss=.true., low=-most_state, high=most_state, &
      only=settled, takes=of_coordinates, &
      meaning='coordinates at the start; 0 if it is left out'), &
      key_type('q_dot', most=most_coordinates, may_miss=.true., low=-most_state, &
      high=most_state, only=settled, takes=of_coordinates, &
      meaning='velocities at the start; 0 if it is left out'), &
      key_type('start', low=0.0_wp, high=1.0e12_wp, default='0', only=settled, &
      meaning='time at the start'), &
      key_type('duration', low=0.0_wp, above=.true., high=1.0e12_wp, only=settled, &
      may_miss=.true., &
      takes='a number with 0 < duration <= 1e12, without a &load or with a constant one', &
      meaning='for a self-excited motion: time to simulate first, after which it must repeat'), &
      key_type('period', low=0.0_wp, above=.true., high=1.0e12_wp, only=settled, &
      may_miss=.true., &
      takes='a number with 0 < period <= 1e12, without a &load or with a constant one', &
      meaning='for a self-excited motion near the state at the start: its approximate period')]

   type(column_type), parameter :: own_structure_columns(*) = [impact_columns, &
      column_type('motion', 'cycles', wholes, listed=.false., meaning='load cycles in a period'), &
      column_type('motion', 'residual', listed=.false., &
      meaning='largest relative residual of the equations'), &
      column_type('motion', 'determinant', listed=.false., meaning='det[P]'), &
      column_type('motion', 'law', listed=.false., &
      meaning='value of det[P] that follows from damping and impacts'), &
      column_type('motion', 'consistent', verdicts, listed=.false., &
      meaning='whether it solves all equations'), &
      column_type('motion', 'admissible', verdicts, listed=.false., &
      meaning='whether all gaps stay open between the impacts'), &
      column_type('motion', 'stable', verdicts, listed=.false., &
      meaning='whether disturbances decay'), &
      column_type('motion', 'frequency', unit='omega', listed=.false., &
      meaning='circular frequency of the load'), &
      derivative_columns, structure_columns]

contains

   !> Declares the study, with its keys and columns.
   pure subroutine declare_motion(study, keys, columns)
      !> The study.
      type(study_type), intent(out), optional :: study
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) then
         call list_for(of_oscillator, motion_keys, keys)
         call list_for(of_structure, structure_keys, keys)
      end if
      if (present(columns)) then
         call list_for(of_oscillator, motion_columns, columns)
         call list_for(of_structure, own_structure_columns, columns)
      end if
      if (.not. present(study)) return
      study%name = 'motion'
      study%meaning = 'compute periodic motions from their load phases or their clearance'
      study%row = 'impacts'
      study%check => check_case
      study%memory => motion_memory
      study%takes_elements = .true.
      study%takes_walls = .true.
      study%run => run_motion
   end subroutine declare_motion

   !> Checks the rules that involve several keys.
   subroutine check_case(case)
      !> The case.
      type(case_type), intent(inout) :: case
      type(values_type) :: group

      if (case%model == of_structure) then
         group = case%study
         call check_structure_motion(case, group)
         case%study = group
      else
         call check_motion(case%osc, case%study)
      end if
   end subroutine check_case

   !> Checks the rules that involve several keys.
   subroutine check_motion(osc, values)
      !> The system.
      type(oscillator_type), intent(in) :: osc
      !> The group; complete on return.
      type(values_type), intent(inout) :: values
      type(pattern_type) :: pattern
      character(:), allocatable :: symbols
      integer :: n, given

      if (len(values%fault) > 0) return
      if (values%is('kind', 'equispaced')) then
         if (modulo(values%whole_number('cycles'), 2) == 0) call values%refuse('cycles', &
            'it must be odd for kind = ''equispaced''')
         if (abs(osc%restitution(1) - osc%restitution(2)) > 0) call values%refuse('kind', &
            '''equispaced'' requires equal restitution on both walls')
         return
      end if
      call values%text('sides', symbols)
      pattern = new_pattern(symbols, 1)
      n = size(pattern%sides)
      if (n < 2 .or. n > most_impacts .or. any(pattern%sides == 0) .or. abs(sum(pattern%sides)) &
         == n) then
         call values%refuse('sides')
         return
      end if
      call values%set_word('sides', side_symbols(pattern%sides))
      if (values%is('kind', 'exact') .and. values%is('precision', 'single')) call values%refuse( &
         'precision', 'it must be ''double'' for kind = ''exact''')
      call check_phases(values, n)
      if (values%has('positions')) then
         given = size(values%numbers('positions'))
         if (given /= n) call values%refuse('positions', counted(n, 'impact')//' are in sides')
         if (any(abs(values%numbers('positions')) > 1.0e12_wp)) call values%refuse('positions')
         if (.not. values%has('tau')) call values%refuse('positions', 'tau must be given too')
      end if
      if (.not. values%has('impact_restitution')) return
      given = size(values%numbers('impact_restitution'))
      if (given /= n) call values%refuse('impact_restitution', counted(n, &
         'impact')//' are in sides')
   end subroutine check_motion

   !> Checks that the phases begin with 0 and increase within the period.
   subroutine check_phases(values, n)
      !> The group.
      type(values_type), intent(inout) :: values
      !> Number of impacts in the period.
      integer, intent(in) :: n
      real(wp), allocatable :: phases(:)
      real(wp) :: period, unit
      integer :: i

      allocate (phases, source=values%numbers('phases'))
      unit = merge(pi, 1.0_wp, values%given('phases_over_pi'))
      period = 2*pi*values%whole_number('cycles')
      if (size(phases) /= n) then
         call values%refuse('phases', counted(size(phases), 'number')//' for '//counted(n, &
            'impact')//' in sides')
      else if (abs(phases(1)) > 0) then
         call values%refuse('phases', 'the first must be 0: it is the origin')
      else if (.not. phases(n) < period) then
         call values%refuse('phases', 'the last must be below '//shown(period/unit, 'g0.6'))
      else
         do i = 2, n
            if (phases(i) <= phases(i - 1)) call values%refuse('phases', 'number '//whole(i)// &
               ' must be above number '//whole(i - 1))
         end do
      end if
   end subroutine check_phases

   !> Converts a checked group to the data of its motion.
   pure subroutine motion_request(osc, values, request)
      !> The system.
      type(oscillator_type), intent(in) :: osc
      !> The group.
      type(values_type), intent(in) :: values
      !> The data of the motion.
      type(motion_request_type), intent(out) :: request
      character(:), allocatable :: symbols

      symbols = 'RL'
      if (values%has('sides')) call values%text('sides', symbols)
      request%kind = values%word('kind')
      request%pattern = new_pattern(symbols, values%whole_number('cycles'))
      if (request%kind == 'equispaced') then
         request%phases = [0.0_wp, request%pattern%cycles*pi]
      else
         request%phases = values%numbers('phases')
      end if
      if (values%has('impact_restitution')) then
         request%restitution = values%numbers('impact_restitution')
      else
         request%restitution = default_restitution(request%pattern%sides, osc%restitution(1), &
            osc%restitution(2))
      end if
      allocate (request%positions(0))
      if (values%has('positions')) then
         request%positions = values%numbers('positions')
         request%tau = values%number('tau')
      end if
      if (values%has('clearance')) request%clearance = values%number('clearance')
      if (values%has('acceptance')) request%acceptance = values%number('acceptance')
      request%single = values%is('precision', 'single')
   end subroutine motion_request

   !> The motions of a group: two of the equispaced kind, else one.
   subroutine find_motions(case, values, motions)
      !> The case with its system.
      type(case_type), intent(in) :: case
      !> The group &motion, checked.
      type(values_type), intent(in) :: values
      !> The motions, each with its status.
      type(motion_type), allocatable, intent(out) :: motions(:)
      type(linear_system_type) :: system
      type(motion_request_type) :: wanted

      call motion_request(case%osc, values, wanted)
      allocate (motions(merge(2, 1, wanted%kind == 'equispaced')))
      associate (osc => case%osc, r => case%r, w => wanted)
         select case (w%kind)
         case ('equispaced')
            if (w%single) then
               call equispaced_in_single(osc, r, w%clearance, w%pattern%cycles, w%acceptance, &
                  .true., motions)
            else
               call equispaced_chain(osc, r, w%clearance, w%pattern%cycles, w%acceptance, .true., &
                  system, motions)
            end if
         case ('exact')
            if (size(w%positions) > 0) then
               call solve_near(osc, r, w, motions(1))
            else
               call exact_chain(osc, r, w%clearance, w%pattern, w%restitution, w%phases, system, &
                  motions(1))
            end if
         case default
            if (w%single) then
               call periodic_in_single(osc, r, w%pattern, w%restitution, w%phases, w%acceptance, &
                  .true., motions(1))
            else
               call periodic_chain(osc, r, w%pattern, w%restitution, w%phases, w%acceptance, &
                  .true., system, motions(1))
            end if
         end select
      end associate
   end subroutine find_motions

   !> The exact motion near a guess of all impact positions and phases.
   subroutine solve_near(osc, r, wanted, motion)
      !> The system.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio.
      real(wp), intent(in) :: r
      !> The data of the motion, with `positions`.
      type(motion_request_type), intent(in) :: wanted
      !> The motion, with its verdicts and status.
      type(motion_type), intent(out) :: motion

      call start_motion(motion, osc, r, wanted%pattern, wanted%restitution, wanted%phases)
      motion%clearance = wanted%clearance
      motion%x = wanted%positions
      motion%tau = wanted%tau
      call refine(wanted%clearance, motion)
   end subroutine solve_near

   !> Computes the motions of a case.
   subroutine run_motion(case, threads, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(motion_type), allocatable :: motions(:)
      character(:), allocatable :: text
      logical :: none
      integer :: i

      associate (not_used => threads)    ! one motion has one thread
      end associate
      if (case%model == of_structure) then
         call run_structure(case, result, progress)
         return
      end if
      call find_motions(case, case%study, motions)
      call put_motions(motions, result)
      associate (s => case%study)
         call put_origin(case, findloc(kinds, s%word('kind'), 1), s%is('precision', 'single'), &
            1.0_wp, result)
         if (s%is('kind', 'exact') .and. .not. s%has('positions') .and. motions(1)%status == &
            stat%ok) call result%put('impacts', 'guess', s%numbers('phases'))
      end associate
      none = all(motions%status /= stat%ok)
      if (none) then
         call result%remark(status_text(motions(1)%status))
         call result%fail(status_text(motions(1)%status))
      end if
      do i = 1, size(motions)
         if (motions(i)%status == stat%ok) then
            call describe_verdicts(motions(i), text)
            call result%add_note(text)
         else if (.not. none) then
            call result%remark('motion '//whole(i)//': '//status_text(motions(i)%status))
         end if
      end do
   end subroutine run_motion

   !> Puts motions into the result; one that failed has no impacts, and NaN for numbers. Their
   !! origin is added by `put_origin`.
   pure subroutine put_motions(motions, result)
      !> The motions.
      type(motion_type), intent(in) :: motions(:)
      !> The result.
      type(result_type), intent(inout) :: result
      type(line_type), allocatable :: sides(:)
      integer, allocatable :: owners(:), numbers(:), walls(:)
      real(wp), allocatable :: impacts(:, :)
      real(wp) :: numbers_of(7, size(motions))
      complex(wp) :: multipliers(4, size(motions))
      character(*), parameter :: names(8) = [character(12) :: 'restitution', 'phase', 'X', 'Z', &
         'X_dot_before', 'X_dot_after', 'Z_dot_before', 'Z_dot_after'], motion_names(7) = &
         [character(11) :: 'clearance', 'A', 'tau', 'residual', 'x_min', 'x_max', 'attenuation']
      integer :: i, j, m, n, total

      n = size(motions)
      total = sum([(merge(size(motions(i)%pattern%sides), 0, motions(i)%status == stat%ok), &
         i=1, n)])
      allocate (sides(n), owners(total), numbers(total), walls(total), impacts(8, total))
      numbers_of = ieee_value(1.0_wp, ieee_quiet_nan)
      multipliers = cmplx(ieee_value(1.0_wp, ieee_quiet_nan), ieee_value(1.0_wp, &
         ieee_quiet_nan), wp)
      total = 0
      do i = 1, n
         sides(i)%text = ''
         if (motions(i)%status /= stat%ok) cycle
         associate (motion => motions(i))
            sides(i)%text = starred_symbols(motion%pattern%sides)
            m = size(motion%x)
            owners(total + 1:total + m) = i
            numbers(total + 1:total + m) = [(j, j=1, m)]
            walls(total + 1:total + m) = merge(1, 2, motion%pattern%sides > 0) &
               + 2*(abs(motion%pattern%sides) - 1)
            impacts(:, total + 1:total + m) = transpose(reshape([motion%restitution, &
               motion%phases, motion%x, motion%z, motion%x_dot_before, motion%x_dot_after, &
               motion%z_dot_before, motion%z_dot_after], [m, 8]))
            numbers_of(:6, i) = [motion%clearance, motion%amplitude, motion%tau, &
               motion%residual, motion%x_min, motion%x_max]
            if (motion%amplitude > 0) numbers_of(7, i) = max(-motion%x_min, &
               motion%x_max)/motion%amplitude
            where (.not. ieee_is_nan(motion%multipliers%re)) multipliers(:, i) = motion%multipliers
            total = total + m
         end associate
      end do
      call result%open('motions', 'motion', [n])
      call result%put('motions', 'motion', [(i, i=1, n)])
      do i = 1, 7
         call result%put('motions', trim(motion_names(i)), numbers_of(i, :))
      end do
      call result%put('motions', 'consistent', motions%consistent)
      call result%put('motions', 'admissible', motions%admissible)
      call result%put('motions', 'stable', motions%stable)
      call result%put('motions', 'multipliers', [multipliers])
      call result%put_text('motions', 'sides', sides)
      call result%put('motions', 'cycles', motions%pattern%cycles)
      call result%put('motions', 'status', motions%status)
      call result%open('impacts', 'impact', [total], 'motions', owners)
      call result%put('impacts', 'impact', numbers)
      call result%put('impacts', 'side', walls)
      do i = 1, 8
         call result%put('impacts', trim(names(i)), impacts(i, :))
      end do
   end subroutine put_motions

   !> Puts the origin of the motions into the result.
   pure subroutine put_origin(case, kind, single, load, result)
      !> The case, with the system of the motions.
      type(case_type), intent(in) :: case
      !> Place of a word of the column `kind`.
      integer, intent(in) :: kind
      !> Whether the motions were computed in single precision.
      logical, intent(in) :: single
      !> Load amplitude (F0).
      real(wp), intent(in) :: load
      !> The result, with its motions.
      type(result_type), intent(inout) :: result
      character(*), parameter :: names(6) = [character(4) :: 'r', 'load', 'xi', 'mu', 'R1', 'R2']
      real(wp) :: values(6)
      integer :: i, n

      n = rows_of(result%tables(findloc(result%tables%name == 'motions', .true., 1)))
      values = [case%r, load, case%osc%xi, case%osc%mu, case%osc%restitution]
      do i = 1, size(names)
         call result%put('motions', trim(names(i)), spread(values(i), 1, n))
      end do
      call result%put('motions', 'kind', spread(kind, 1, n))
      call result%put('motions', 'precision', spread(merge(2, 1, single), 1, n))
   end subroutine put_origin

   !> The verdicts of a motion in words.
   pure subroutine describe_verdicts(motion, text)
      !> The motion.
      type(motion_type), intent(in) :: motion
      !> Its verdicts, and the modulus of its leading multiplier.
      character(:), allocatable, intent(out) :: text

      text = verdict_text(motion%consistent, 'consistent')//', '//verdict_text(motion%admissible, &
         'admissible') &
         //', '//trim(merge('stable?  ', merge('stable   ', 'unstable ', motion%stable == yes), &
         motion%stable == unknown))
      if (ieee_is_nan(motion%multipliers(1)%re)) then
         text = text//' (no multipliers)'
      else
         text = text//' (max|lambda| = '//shown(abs(motion%multipliers(1)), 'g0.4')// &
            ', '//trim(leading_kind(motion%multipliers))//')'
      end if
   end subroutine describe_verdicts

   !> A verdict in words.
   pure function verdict_text(verdict, word) result(text)
      !> `yes`, `no` or `unknown`.
      integer, intent(in) :: verdict
      !> The adjective.
      character(*), intent(in) :: word
      character(len(word) + merge(0, merge(1, 4, verdict == unknown), verdict == yes)) :: text

      text = word
      if (verdict == unknown) text = word//'?'
      if (verdict /= unknown .and. verdict /= yes) text = 'not '//word
   end function verdict_text

   !> Checks a &motion of a case, its own or the one from which its study starts.
   subroutine check_structure_motion(case, group)
      !> The case; its structure and load are used.
      type(case_type), intent(in) :: case
      !> In and out: the group.
      type(values_type), intent(inout) :: group
      integer :: gaps, i

      if (len(group%fault) > 0) return
      if (load_frequency(case) > 0) then
         if (group%has('duration')) call group%refuse('duration', 'the &load has a frequency')
         if (group%has('period')) call group%refuse('period', 'the &load has a frequency')
         if (len(group%fault) > 0) return
      else if (.not. is_free(case, group)) then
         if (group%is('kind', 'settled')) then
            call group%refuse('kind', 'it requires a &load with a frequency, or for a &
               &self-excited motion a duration or period')
         else
            call group%refuse('gaps', 'they require a &load with a frequency')
         end if
         return
      end if
      if (group%is('kind', 'settled')) then
         call complete_coordinates(group, 'q', case%coordinates)
         call complete_coordinates(group, 'q_dot', case%coordinates)
         return
      end if
      if (.not. group%has('cycles')) call group%set('cycles', [1.0_wp])
      gaps = count([(case%parts(i)%name /= 'load', i=1, size(case%parts))])
      if (any(group%numbers('gaps') >= gaps)) then
         call group%refuse('gaps', 'the structure has '//counted(gaps, trim(merge( &
            'gap, stop or friction element', 'gap                          ', has_elements(case)))))
         return
      end if
      call check_structure_phases(group)
      if (len(group%fault) == 0) call check_kinds(case, group)
      if (len(group%fault) > 0 .or. .not. group%is('kind', 'periodic')) return
      do i = 1, gaps
         if (case%parts(i)%name /= 'gap') cycle
         if (.not. any(nint(group%numbers('gaps')) == i - 1)) cycle
         if (.not. case%parts(i)%is('law', 'constant')) call group%refuse('kind', &
            '''exact'' where the restitution of a gap depends on the speed')
      end do
   end subroutine check_structure_motion

   !> Checks the kinds of events of a structure with stops or friction.
   subroutine check_kinds(case, group)
      !> The case; its structure is used.
      type(case_type), intent(in) :: case
      !> In and out: the group.
      type(values_type), intent(inout) :: group
      type(structure_type) :: structure
      type(load_type) :: load
      character(*), parameter :: of_friction = ' halt slip_up slip_down'
      character(:), allocatable :: text
      integer :: first, i, status

      if (.not. has_elements(case)) then
         if (.not. group%has('kinds')) return
         if (all([(group%word('kinds', i) == 'impact', i=1, group%count_words('kinds'))])) then
            call group%refuse('kinds', 'all events are impacts; leave it out')
            return
         end if
      end if
      associate (phases => group%numbers('phases'), n => size(group%numbers('gaps')))
         if (.not. group%has('kinds')) then
            call group%refuse('kinds', 'it is required with a &stop or a &friction')
         else if (group%count_words('kinds') /= n) then
            call group%refuse('kinds', counted(n, 'event')//' are in gaps')
         else
            first = 1
            do i = 2, n
               if (phases(i) > phases(i - 1)) first = i
               if (i == first .or. is_one('release slip_up slip_down', i)) cycle
               if (is_one(of_friction, i) .and. is_one('impact'//of_friction, i - 1)) cycle
               if (is_one('impact', first) .and. is_one('stick let_go press'//of_friction, i)) cycle
               if (is_one('release', first) .and. is_one(of_friction, i)) cycle
               call group%refuse('phases', 'of simultaneous events, all after the first must be &
                  &release, slip_up, slip_down or halt, or stick, let_go or press after an impact')
            end do
         end if
      end associate
      if (len(group%fault) > 0) return
      call structure_of(case, structure, load)
      call check_structure(structure, status)
      ! a fault of the structure is found when it is used
      if (status /= stat%ok) return
      call sequence_fault(structure, nint(group%numbers('gaps')) + 1, kinds_in(group), &
         group%numbers('phases'), text)
      if (len(text) > 0) call group%refuse('kinds', text)

   contains

      !> Whether the kind of an event is one of the words of a text.
      pure logical function is_one(words, event)
         !> The words, with a space between two.
         character(*), intent(in) :: words
         !> The event, from 1.
         integer, intent(in) :: event

         is_one = index(' '//words//' ', ' '//trim(group%word('kinds', event))//' ') > 0
      end function is_one

   end subroutine check_kinds

   !> The kinds of the events of a group.
   function kinds_in(group) result(kinds)
      !> The group.
      type(values_type), intent(in) :: group
      integer, allocatable :: kinds(:)
      character(24), allocatable :: words(:)
      integer :: i

      allocate (words(group%count_words('kinds')))
      do i = 1, size(words)
         words(i) = group%word('kinds', i)
      end do
      kinds = kinds_of(words)
   end function kinds_in

   !> Whether a motion is one without a periodic load, whose period is unknown.
   logical function is_free(case, group)
      !> The case; its load is used.
      type(case_type), intent(in) :: case
      !> The group.
      type(values_type), intent(in) :: group

      is_free = .false.
      if (load_frequency(case) > 0 .or. record_end(case) >= 0) return
      is_free = group%has('duration') .or. group%has('period')
   end function is_free

   !> Whether a structure has stops or friction in addition to its gaps.
   pure logical function has_elements(case)
      !> The case.
      type(case_type), intent(in) :: case
      integer :: i

      has_elements = any([(case%parts(i)%name == 'stop' .or. case%parts(i)%name == 'friction', &
         i=1, size(case%parts))])
   end function has_elements

   !> Checks that the phases increase within a period.
   subroutine check_structure_phases(study)
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
               ' must not be below number '//whole(i - 1))
         end do
      end if
   end subroutine check_structure_phases

   !> Bytes for the matrices of a structure and those that follow from them.
   pure real(wp) function motion_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case
      real(wp) :: impacts

      bytes = 0
      if (case%model /= of_structure) return
      impacts = 2000
      if (case%study%has('gaps')) impacts = size(case%study%numbers('gaps'))
      bytes = 600.0_wp*real(case%coordinates, wp)**2 + 100*(impacts + case%coordinates)**2
   end function motion_memory

   !> Computes the motion of a structure.
   subroutine run_structure(case, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(structure_type) :: structure
      type(load_type) :: load
      type(settled_type) :: found
      character(6) :: kind
      integer :: status

      if (present(progress)) progress(2) = 1
      call find_structure_motion(case, case%study, .false., structure, load, found, status, &
         progress)
      result%empty = status /= stat%ok
      if (status == stat%not_computed) then
         result%cut = 'the computation was stopped before a motion was found'
         return
      end if
      if (status /= stat%ok) then
         call result%fail(status_text(status))
         return
      end if
      call put_structure_motion(result, found, load%frequency)
      call put_structure(result, structure, load)
      kind = 'impact'
      if (has_elements(case)) kind = 'event'
      call result%add_note(counted(size(found%gaps), trim(kind))//' and '// &
         counted(size(found%resting), 'rest')//' in '//counted(found%cycles, 'load cycle'))
   end subroutine run_structure

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
      if (is_free(case, group)) then
         call find_self_excited(group, structure, load, found, status, progress)
      else if (group%is('kind', 'settled')) then
         cycles = 0
         if (group%has('cycles')) cycles = group%whole_number('cycles')
         call settle(structure, load, group%number('start'), group%numbers('q'), &
            group%numbers('q_dot'), group%whole_number('settling'), &
            group%whole_number('max_cycles'), cycles, found, status, progress)
      else if (group%has('kinds')) then
         call presume(structure, load, nint(group%numbers('gaps')) + 1, kinds_in(group), &
            group%numbers('phases'), group%whole_number('cycles'), refined .or. &
            group%is('kind', 'exact'), found, status, progress)
      else
         found%gaps = nint(group%numbers('gaps')) + 1
         found%cycles = group%whole_number('cycles')
         allocate (found%resting(0), found%rests(2, 0))
         call periodic_structure(structure, load, found%gaps, group%numbers('phases'), &
            found%cycles, merge(eliminated, exact, group%is('kind', 'periodic') .and. &
            .not. refined), found%motion, status)
      end if
   end subroutine find_structure_motion

   !> The self-excited motion that a &motion describes.
   subroutine find_self_excited(group, structure, load, found, status, progress)
      !> The group.
      type(values_type), intent(in) :: group
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> In: constant forces. Out: with the frequency of the motion.
      type(load_type), intent(inout) :: load
      !> The motion.
      type(settled_type), intent(out) :: found
      !> As in `self_excited`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      real(wp) :: duration, frequency, period

      duration = 0
      period = 0
      if (group%has('duration')) duration = group%number('duration')
      if (group%has('period')) period = group%number('period')
      call self_excited(structure, load, group%numbers('q'), group%numbers('q_dot'), duration, &
         period, found, frequency, status, progress)
      load%frequency = frequency
   end subroutine find_self_excited

   !> Fills the tables of the motion.
   pure subroutine put_structure_motion(result, found, frequency)
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
   end subroutine put_structure_motion

end module vi_motion_study
