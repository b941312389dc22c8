!> The study &branch: motions along a parameter, from those of a &motion.
module vi_branch_study
   use vi_branch, only: end_full, end_stopped, end_stuck, end_text
   use vi_branch_of, only: branch_of, points_type
   use vi_branch_table, only: branch_work, follow_both, follow_work
   use vi_chain, only: periodic_chain, refine
   use vi_common_keys, only: parameter_of, parameter_place, parameter_range, parameter_takes, &
      parameter_words, parameters, resonance
   use vi_condition_names, only: condition_detail, condition_name, name_length
   use vi_curve_point, only: curve_type, parameters_of, unknowns_of
   use vi_kinds, only: two_pi, wp
   use vi_motion, only: motion_type
   use vi_motion_family, only: condition_type, contact_vanishes, edge, event_vanishes, &
      flight_vanishes, grazing, is_exchange, repetition, rest_splits, rest_vanishes, &
      stick_begins, stick_vanishes, zero_approach
   use vi_motion_study, only: check_motion, check_structure_motion, find_motions, &
      find_structure_motion, motion_request, motion_request_type
   use vi_orbit, only: by_clearance, by_r, by_right, by_xi, most_impacts
   use vi_oscillator, only: at_resonance
   use vi_periodic, only: linear_system_type
   use vi_progress, only: add_done_work, add_expected_work, is_stopped, report_share
   use vi_status, only: stat, status_text
   use vi_steps, only: stride_type
   use vi_structure, only: check_structure, load_type, structure_type
   use vi_structure_family, only: structure_family_type
   use vi_structure_groups, only: load_frequency, structure_of
   use vi_structure_parameter, only: check_parameter, function_keys, parameter_change
   use vi_structure_path, only: change_type, structure_takes => parameter_takes, value_at
   use vi_structure_period, only: structure_motion_type
   use vi_structure_resting_family, only: structure_resting_type
   use vi_structure_rests, only: release, rests_type
   use vi_structure_return, only: settled_type
   use vi_structure_run, only: event_kinds
   use vi_structure_start, only: motion_at, period_at, phases_at, start_curve
   use vi_structure_tables, only: path_columns, put_path, put_structure, set_unit, &
      structure_columns
   use vi_study, only: a_whole, a_word, case_type, column_type, complexes, every_model, key_type, &
      list_for, of_oscillator, of_parameter, of_structure, result_type, study_type, truths, &
      values_type, verdicts, wholes, words
   use vi_text, only: counted, line_type, number_text, whole
   use vi_units, only: show_frequency, show_unit, shown_in, shown_type
   implicit none (type, external)
   private

   public :: check_structure_start, declare_branch, touch_detail

   type(key_type), parameter :: branch_keys(*) = [ &
      key_type('parameter', a_word, words=parameter_words, takes=parameter_takes, &
      meaning='parameter that changes', model=of_oscillator), &
      key_type('parameter', a_word, takes=structure_takes, meaning='parameter that changes', &
      model=of_structure), &
      key_type('low', takes='a number, at most the value of the starting motion', &
      option='bounds', unit=of_parameter, meaning='lower bound of the parameter'), &
      key_type('high', takes='a number above low, at least the value of the starting motion', &
      option='bounds', unit=of_parameter, meaning='upper bound of the parameter'), &
      key_type('longest_step', default='0.05', low=1.0e-6_wp, high=1.0_wp, &
      meaning='longest step along the branch, with the parameter scaled to 0 at low and &
      &1 at high'), &
      key_type('max_points', a_whole, default='4000', low=10.0_wp, high=1.0e5_wp, &
      meaning='points in each direction after which the branch is cut off')]

   type(column_type), parameter :: branch_columns(*) = [ &
      column_type('branches', 'branch', wholes, meaning='number of the branch', &
      model=of_oscillator), &
      column_type('branches', 'symmetric', truths, listed=.false., &
      meaning='whether its motions are their own mirror images half a period later', &
      model=of_oscillator), &
      column_type('branches', 'first_end', words, listed=.false., &
      meaning='why it ends at its first point', model=of_oscillator), &
      column_type('branches', 'last_end', words, listed=.false., &
      meaning='why it ends at its last point', model=of_oscillator), &
      column_type('branches', 'start_clearance', unit='F0/K', listed=.false., &
      meaning='clearance of the starting motion', model=of_oscillator), &
      column_type('branches', 'start_tau', unit='rad', listed=.false., &
      meaning='tau of the starting motion', model=of_oscillator), &
      column_type('branches', 'start_phases', each='impact', unit='rad', listed=.false., &
      meaning='load phases of the impacts of the starting motion', model=of_oscillator), &
      column_type('branches', 'start_X', each='impact', unit='F0/K', listed=.false., &
      meaning='displacements of the primary mass at its impacts', model=of_oscillator), &
      column_type('points', 'point', wholes, meaning='number of the point along the branch'), &
      column_type('points', 'r', meaning='frequency ratio', model=of_oscillator), &
      column_type('points', 'clearance', unit='F0/K', &
      meaning='clearance d K/F0; d is the whole travel of m between the walls', &
      model=of_oscillator), &
      column_type('points', 'xi', meaning='damping ratio', model=of_oscillator), &
      column_type('points', 'mu', meaning='mass ratio', model=of_oscillator), &
      column_type('points', 'R1', meaning='coefficient of restitution of the right wall', &
      model=of_oscillator), &
      column_type('points', 'R2', meaning='coefficient of restitution of the left wall', &
      model=of_oscillator), &
      column_type('points', 'value', meaning='the parameter', model=of_structure), &
      column_type('points', 'period', unit='1/omega', listed=.false., &
      meaning='period of a self-excited motion', &
      model=of_structure), &
      column_type('points', 'consistent', verdicts, meaning='whether it solves all equations'), &
      column_type('points', 'admissible', verdicts, &
      meaning='whether all gaps stay open between the impacts'), &
      column_type('points', 'stable', verdicts, meaning='whether disturbances decay'), &
      column_type('points', 'multipliers', complexes, each='multiplier', &
      label='multiplier_#_modulus', meaning='eigenvalues of [P], in order of decreasing modulus'), &
      column_type('points', 'A', unit='F0/K', meaning='amplitude of the motion without impacts', &
      model=of_oscillator), &
      column_type('points', 'tau', unit='rad', meaning='load phase of the first impact', &
      model=of_oscillator), &
      column_type('points', 'residual', meaning='largest relative residual of the equations'), &
      column_type('points', 'x_min', unit='F0/K', &
      meaning='smallest displacement of the primary mass', model=of_oscillator), &
      column_type('points', 'x_max', unit='F0/K', &
      meaning='greatest displacement of the primary mass', model=of_oscillator), &
      column_type('points', 'attenuation', meaning='max|X|/A', model=of_oscillator), &
      column_type('points', 'q_min', unit='F0/K', each='coordinate', label='q_min_#', &
      meaning='smallest value of each coordinate', model=of_structure), &
      column_type('points', 'q_max', unit='F0/K', each='coordinate', label='q_max_#', &
      meaning='greatest value of each coordinate', model=of_structure), &
      column_type('points', 'phases', each='impact', label='phase_#', unit='rad', &
      meaning='load phases of the impacts; for an oscillator from the first impact'), &
      column_type('points', 'X', each='impact', label='x_#', unit='F0/K', &
      meaning='displacements of the primary mass at the impacts', model=of_oscillator), &
      column_type('points', 'Z', each='impact', unit='F0/K', listed=.false., &
      meaning='displacements of the free mass at the impacts', model=of_oscillator), &
      column_type('points', 'X_dot_before', each='impact', unit='omega F0/K', listed=.false., &
      meaning='velocities of the primary mass before the impacts', model=of_oscillator), &
      column_type('points', 'X_dot_after', each='impact', unit='omega F0/K', listed=.false., &
      meaning='velocities of the primary mass after the impacts', model=of_oscillator), &
      column_type('points', 'Z_dot_before', each='impact', unit='omega F0/K', listed=.false., &
      meaning='velocities of the free mass before the impacts', model=of_oscillator), &
      column_type('points', 'Z_dot_after', each='impact', unit='omega F0/K', listed=.false., &
      meaning='velocities of the free mass after the impacts', model=of_oscillator), &
      column_type('points', 'speeds', unit='omega F0/K', each='impact', label='speed_#', &
      meaning='approach speeds of the impacts', model=of_structure), &
      column_type('points', 'impulses', unit='F0/omega', each='impact', listed=.false., &
      meaning='impulses of the impacts', model=of_structure), &
      column_type('points', 'rest_begin', each='rest', unit='rad', listed=.false., &
      meaning='load phase at which each rest begins', model=of_structure), &
      column_type('points', 'rest_end', each='rest', unit='rad', listed=.false., &
      meaning='load phase at which each rest ends', model=of_structure), &
      column_type('points', 'q', unit='F0/K', each='coordinate', listed=.false., &
      meaning='coordinates just after the first impact, with rests', model=of_structure), &
      column_type('points', 'q_dot', unit='omega F0/K', each='coordinate', listed=.false., &
      meaning='velocities just after the first impact, with rests', model=of_structure), &
      column_type('points', 'special', words, meaning='type of a special point'), &
      column_type('points', 'detail', words, meaning='the impact, flight or bound concerned'), &
      column_type('points', 'special_impact', wholes, listed=.false., &
      meaning='number of the impact without approach speed, or before the touching flight; 0: &
      &none', model=of_oscillator), &
      column_type('points', 'special_side', words, words='R,L', listed=.false., &
      meaning='wall at which the motion grazes', model=of_oscillator), &
      column_type('branch', 'gaps', wholes, each='impact', listed=.false., &
      meaning='gaps of the impacts, from 0', model=of_structure), &
      column_type('events', 'impact', wholes, listed=.false., &
      meaning='with stops or friction: number of the impact at whose instant each event comes', &
      model=of_structure), &
      column_type('events', 'gap', wholes, listed=.false., &
      meaning='gap, stop or friction of each event, from 0', model=of_structure), &
      column_type('events', 'kind', words, words=event_kinds, listed=.false., &
      meaning='what happens in each event', model=of_structure), &
      column_type('branch', 'resting', wholes, each='rest', listed=.false., &
      meaning='gaps that rest, from 0', model=of_structure), &
      column_type('branch', 'cycles', wholes, listed=.false., meaning='load cycles in a period', &
      model=of_structure), &
      column_type('branch', 'frequency', unit='omega', listed=.false., &
      meaning='circular frequency of the load at the start', model=of_structure), &
      column_type('branch', 'first_end', words, listed=.false., &
      meaning='why it ends at its first point', model=of_structure), &
      column_type('branch', 'last_end', words, listed=.false., &
      meaning='why it ends at its last point', model=of_structure)]

contains

   !> Declares the study, with its keys and columns.
   pure subroutine declare_branch(study, keys, columns)
      !> The study.
      type(study_type), intent(out), optional :: study
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) then
         call list_for(every_model, branch_keys, keys)
         call list_for(of_structure, function_keys, keys)
      end if
      if (present(columns)) then
         call list_for(every_model, branch_columns, columns)
         call list_for(of_structure, path_columns, columns)
         call list_for(of_structure, structure_columns, columns)
      end if
      if (.not. present(study)) return
      study%name = 'branch'
      study%meaning = 'follow motions along a parameter'
      study%starts_from = 'motion'
      study%row = 'points'
      study%takes_elements = .true.
      study%takes_walls = .true.
      study%check => check_branch
      study%check_start => check_branch_start
      study%memory => branch_memory
      study%run => run_branch
   end subroutine declare_branch

   !> Checks the &motion that a branch starts from.
   subroutine check_branch_start(case, line)
      !> A case with a `start`, in which a fault is recorded.
      type(case_type), intent(inout) :: case
      !> Line of the group &branch.
      integer, intent(in) :: line
      type(motion_request_type) :: wanted

      if (case%model == of_structure) then
         call check_structure_start(case, line)
         return
      end if
      call check_motion(case%osc, case%start)
      if (len(case%start%fault) > 0) return
      call motion_request(case%osc, case%start, wanted)
      if (size(wanted%phases) > most_impacts) then
         call blame(case%start, 'has '//whole(size(wanted%phases))//' impacts; must have at most ' &
            //whole(most_impacts), line)
      else if (case%start%has('impact_restitution')) then
         call blame(case%start, 'has impact_restitution; must not have it', line)
      else if (wanted%single) then
         call blame(case%start, 'has precision = ''single''; must be ''double''', line)
      end if
   end subroutine check_branch_start

   !> Records a fault of the start.
   pure subroutine blame(start, text, line)
      !> The group.
      type(values_type), intent(inout) :: start
      !> What is wrong with the motion, and what is required.
      character(*), intent(in) :: text
      !> Line of the group &branch.
      integer, intent(in) :: line

      start%fault = '&branch: the &motion before it '//text
      start%fault_line = line
   end subroutine blame

   !> Checks the rules that involve several keys, or the motion that the branch starts from.
   subroutine check_branch(case)
      !> The case, with `start`.
      type(case_type), intent(inout) :: case
      real(wp) :: start(2), low, high, least, most, scale
      character(40) :: text
      character(:), allocatable :: limits, unit
      type(shown_type) :: shown
      integer :: place, core_place
      logical :: tied

      if (len(case%study%fault) > 0) return
      if (case%model == of_structure) then
         call check_structure_branch(case)
         return
      end if
      place = findloc(parameters == case%study%word('parameter'), .true., 1)
      call parameter_place(trim(parameters(place)), core_place, tied)
      if (tied .and. abs(case%osc%restitution(1) - case%osc%restitution(2)) > 0) call &
         case%study%refuse('parameter', '''restitution'' requires equal restitution on both walls')
      if (len(case%study%fault) > 0) return
      start = start_value(case, place)
      low = case%study%number('low')
      high = case%study%number('high')
      call parameter_range(place, least, most, text)
      limits = trim(text)
      if (start(1) <= start(2)) limits = limits//', and the motion has '//trim(parameters(place)) &
         //' = '//trim(number_text(start(1), .false., 10))
      if (case%system%has('force')) then
         call case%system%text('unit_names', unit)
         shown = shown_in(case%system%number('mass'), case%system%number('stiffness'), &
            case%system%number('force'), unit, '')
      end if
      if (start(1) <= start(2) .and. len_trim(shown%names(1)) > 0 .and. &
         (place == by_r .or. place == by_clearance)) then
         if (place == by_r) call show_frequency(shown, scale, unit)
         if (place == by_clearance) call show_unit('F0/K', shown, scale, unit)
         limits = limits//' ('//trim(number_text(scale*start(1), .false., 6))//' '//unit//')'
      end if
      if (.not. (low >= least .and. low <= start(1))) then
         call case%study%refuse('low', limits)
      else if (.not. (high <= most .and. high >= start(2) .and. high > low)) then
         call case%study%refuse('high', limits)
      else if ((place == by_r .and. at_resonance(case%osc%xi, max(low, min(high, 1.0_wp)))) .or. &
         (place == by_xi .and. at_resonance(low, case%r))) then
         call case%study%refuse('low', resonance//'between low and high')
      end if
   end subroutine check_branch

   !> The least and the greatest value of the parameter at the start.
   function start_value(case, place) result(value)
      !> The case, with `start`.
      type(case_type), intent(in) :: case
      !> Place of the parameter among `parameters`.
      integer, intent(in) :: place
      real(wp) :: value(2)
      type(linear_system_type) :: system
      type(motion_request_type) :: wanted
      type(motion_type) :: motion

      select case (place)
      case (by_r)
         value = case%r
      case (by_clearance)
         call motion_request(case%osc, case%start, wanted)
         value = wanted%clearance
         if (wanted%kind /= 'periodic') return
         ! the clearance follows from the phases; without a motion any bounds are accepted
         call periodic_chain(case%osc, case%r, wanted%pattern, wanted%restitution, wanted%phases, &
            wanted%acceptance, .false., system, motion)
         value = [huge(1.0_wp), -huge(1.0_wp)]
         if (motion%status == stat%ok) value = motion%clearance
      case (by_xi)
         value = case%osc%xi
      case (by_xi + 1)
         value = case%osc%mu
      case default
         value = case%osc%restitution(merge(2, 1, place == by_right + 1))
      end select
   end function start_value

   !> Follows the branches of the motions of a case.
   subroutine run_branch(case, threads, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(motion_type), allocatable :: motions(:)
      type(points_type), allocatable :: branches(:)
      type(motion_type), allocatable :: starts(:)
      type(motion_type) :: start
      character(:), allocatable :: text
      integer :: i, n, place
      logical :: tied

      associate (not_used => threads)    ! branches are followed one after the other
      end associate
      if (case%model == of_structure) then
         call run_structure(case, result, progress)
         return
      end if
      call find_motions(case, case%start, motions)
      call parameter_place(trim(parameter_of(case)), place, tied)
      allocate (branches(size(motions)), starts(size(motions)))
      n = 0
      call add_expected_work(branch_work*size(motions), progress)
      do i = 1, size(motions)
         ! at least one branch is followed, so that there is something to keep
         if (n > 0) then
            if (is_stopped(progress)) exit
         end if
         start = motions(i)
         if (start%status == stat%ok .and. .not. case%start%is('kind', 'exact')) then
            call refine(start%clearance, start)
         end if
         if (start%status /= stat%ok) then
            ! if neither motion of a pair exists, this is reported only once
            if (i == 1 .or. any(motions%status == stat%ok)) then
               call result%fail(status_text(start%status))
            end if
            call add_done_work(branch_work, progress)
            cycle
         end if
         n = n + 1
         call branch_of(start, place, tied, [case%study%number('low'), case%study%number('high')], &
            case%study%number('longest_step'), case%study%whole_number('max_points'), &
            branches(n), progress)
         starts(n) = start
         if (branches(n)%n > 0) cycle
         call result%fail( &
            'the branch cannot be followed from this motion: it is at a singular point')
         n = n - 1
      end do
      result%empty = n == 0
      if (n == 0) return
      call put_starts(branches(:n), starts(:n), result)
      call put_points(branches(:n), result)
      if (any([(any(branches(i)%reasons == end_stopped), i=1, n)])) then
         call describe_cut(branches(:n), size(motions), case%study%word('parameter'), place, result)
      end if
      do i = 1, n
         call result%remark('branch '//whole(i)//': first end: '//end_text( &
            branches(i)%reasons(1))//'; last end: '//end_text(branches(i)%reasons(2)))
         call summarize(branches(i), text)
         call result%add_note(text)
         if (any(branches(i)%reasons == end_full)) then
            call result%fail('cut short, max_points was reached')
         else if (any(branches(i)%reasons == end_stuck)) then
            call result%fail('cut short, the branch cannot be followed further')
         end if
      end do
   end subroutine run_branch

   !> Bytes for the points that max_points allows, in both directions and in the result.
   pure real(wp) function branch_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case
      character(:), allocatable :: symbols
      integer :: impacts, motions

      if (case%model == of_structure) then
         impacts = 24
         if (case%start%has('gaps')) impacts = size(case%start%numbers('gaps'))
         bytes = case%study%whole_number('max_points')*(2000 + 300.0_wp*(impacts + &
            case%coordinates))
         return
      end if
      ! equispaced: two impacts, and two motions
      impacts = 2
      motions = 2
      if (.not. case%start%is('kind', 'equispaced')) then
         call case%start%text('sides', symbols)
         impacts = len(symbols)
         motions = 1
      end if
      bytes = 2.0_wp*motions*case%study%whole_number('max_points')*(1600 + 300.0_wp*impacts)
   end function branch_memory

   !> Puts the columns of each branch as a whole.
   pure subroutine put_starts(branches, starts, result)
      !> The branches, with their points.
      type(points_type), intent(in) :: branches(:)
      !> The motion from which each starts.
      type(motion_type), intent(in) :: starts(:)
      !> The result.
      type(result_type), intent(inout) :: result
      type(line_type) :: first(size(branches)), last(size(branches))
      integer :: i, n

      n = size(branches)
      do i = 1, n
         first(i)%text = end_text(branches(i)%reasons(1))
         last(i)%text = end_text(branches(i)%reasons(2))
      end do
      call result%open('branches', 'branch', [n])
      call result%put('branches', 'branch', [(i, i=1, n)])
      call result%put('branches', 'symmetric', merge(1, 0, branches%symmetric))
      call result%put_text('branches', 'first_end', first)
      call result%put_text('branches', 'last_end', last)
      call result%put('branches', 'start_clearance', starts%clearance)
      call result%put('branches', 'start_tau', starts%tau)
      call result%put('branches', 'start_phases', [(starts(i)%phases, i=1, n)])
      call result%put('branches', 'start_X', [(starts(i)%x, i=1, n)])
   end subroutine put_starts

   !> Describes how far each stopped branch was followed, and how many branches were not begun.
   pure subroutine describe_cut(branches, wanted, name, place, result)
      !> The branches, with their points.
      type(points_type), intent(in) :: branches(:)
      !> Number of motions that were to be followed.
      integer, intent(in) :: wanted
      !> Name of the parameter.
      character(*), intent(in) :: name
      !> Its place in the core.
      integer, intent(in) :: place
      !> The result.
      type(result_type), intent(inout) :: result
      character(:), allocatable :: text
      integer :: i, n

      text = ''
      do i = 1, size(branches)
         if (all(branches(i)%reasons /= end_stopped)) cycle
         n = branches(i)%n
         if (len(text) > 0) text = text//'; '
         if (wanted > 1) text = text//'branch '//whole(i)//': '
         text = text//trim(name)//' from '//trim(number_text(minval(branches(i)%parameters(place, &
            :n)), .false., 6))//' to '//trim(number_text(maxval(branches(i)%parameters(place, &
            :n)), .false., 6))//' was reached'
      end do
      n = wanted - size(branches)
      if (n > 0) text = text//'; '//whole(n)//' not begun'
      result%cut = text
   end subroutine describe_cut

   !> Puts the points of all branches into the result, in order along each.
   pure subroutine put_points(branches, result)
      !> The branches, with their points.
      type(points_type), intent(in) :: branches(:)
      !> The result.
      type(result_type), intent(inout) :: result
      type(line_type), allocatable :: special(:), detail(:)
      integer, allocatable :: owners(:), numbers(:), flags(:, :)
      integer, allocatable :: touched(:), walls(:)
      real(wp), allocatable :: parameters(:, :), scalars(:, :), phases(:, :), of_impacts(:, :, :)
      complex(wp), allocatable :: multipliers(:, :)
      character(*), parameter :: parameter_names(6) = [character(9) :: 'r', 'clearance', 'xi', &
         'mu', 'R1', 'R2'], scalar_names(2:6) = [character(8) :: 'A', 'tau', 'residual', 'x_min', &
         'x_max'], impact_names(6) = [character(12) :: 'X', 'Z', 'X_dot_before', 'X_dot_after', &
         'Z_dot_before', 'Z_dot_after'], verdict_names(3) = [character(10) :: 'consistent', &
         'admissible', 'stable']
      integer :: i, j, k, n, impacts

      n = sum(branches%n)
      impacts = size(branches(1)%phases, 1)
      allocate (special(n), detail(n), owners(n), numbers(n), flags(3, n), parameters(6, n), &
         scalars(6, n), phases(impacts, n), of_impacts(impacts, n, 6), multipliers(4, n), &
         touched(n), walls(n))
      n = 0
      do i = 1, size(branches)
         associate (branch => branches(i), m => branches(i)%n)
            owners(n + 1:n + m) = i
            numbers(n + 1:n + m) = [(k, k=1, m)]
            flags(:, n + 1:n + m) = branch%verdicts(:, :m)
            parameters(:, n + 1:n + m) = branch%parameters(:, :m)
            scalars(:, n + 1:n + m) = branch%scalars(:, :m)
            phases(:, n + 1:n + m) = branch%phases(:, :m)
            do j = 1, 6
               of_impacts(:, n + 1:n + m, j) = branch%impacts(:, j, :m)
            end do
            call locate_special(branch, touched(n + 1:n + m), walls(n + 1:n + m))
            multipliers(:, n + 1:n + m) = branch%multipliers(:, :m)
            do k = 1, m
               special(n + k)%text = trim(special_name(branch, k))
               detail(n + k)%text = trim(condition_detail(branch%special(1, k), &
                  branch%special(2, k), branch%special(3, k)))
            end do
            n = n + m
         end associate
      end do
      call result%open('points', 'point', [n], 'branches', owners)
      call result%put('points', 'point', numbers)
      do i = 1, 6
         call result%put('points', trim(parameter_names(i)), parameters(i, :))
      end do
      do i = 1, 3
         call result%put('points', trim(verdict_names(i)), flags(i, :))
      end do
      call result%put('points', 'multipliers', [multipliers])
      do i = 2, 6
         call result%put('points', trim(scalar_names(i)), scalars(i, :))
      end do
      call result%put('points', 'attenuation', max(-scalars(5, :), scalars(6, :))/scalars(2, :))
      call result%put('points', 'phases', [phases])
      do i = 1, 6
         call result%put('points', trim(impact_names(i)), [of_impacts(:, :, i)])
      end do
      call result%put('points', 'special_impact', touched)
      call result%put('points', 'special_side', walls)
      call result%put_text('points', 'special', special)
      call result%put_text('points', 'detail', detail)
   end subroutine put_points

   !> The impact and the wall to which each special point belongs; 0 if none.
   pure subroutine locate_special(branch, impact, wall)
      !> The branch, with its points.
      type(points_type), intent(in) :: branch
      !> (n) number of the impact, and 1 or 2 for the right or left wall.
      integer, intent(out) :: impact(:), wall(:)
      integer :: family

      ! an index above the number of the family's own impacts belongs to no impact
      family = size(branch%phases, 1)
      if (branch%symmetric) family = family/2
      associate (kind => branch%special(1, :branch%n), place => branch%special(2, :branch%n), &
         side => branch%special(3, :branch%n))
         impact = merge(place, 0, kind /= 0 .and. kind /= edge .and. kind /= repetition .and. &
            place <= family)
         wall = merge(merge(1, 2, side > 0), 0, kind == grazing)
      end associate
   end subroutine locate_special

   !> The type of a special point; blank for another point.
   pure function special_name(branch, k) result(name)
      !> The branch.
      type(points_type), intent(in) :: branch
      !> Number of the point.
      integer, intent(in) :: k
      character(name_length) :: name

      name = ''
      if (branch%special(1, k) > 0) name = condition_name(branch%special(1, k), &
         branch%special(2, k), branch%symmetric, branch%mirrored)
   end function special_name

   !> Points, special points and ends in words.
   pure subroutine summarize(branch, text)
      !> The branch.
      type(points_type), intent(in) :: branch
      !> Numbers of points and of special points, and the ends.
      character(:), allocatable, intent(out) :: text
      character(14), parameter :: names(6) = [character(14) :: 'fold', 'pitchfork', 'flip', &
         'neimark_sacker', 'grazing', 'zero_approach']
      integer :: i, k, count

      text = counted(branch%n, 'point')
      do i = 1, size(names)
         count = 0
         do k = 1, branch%n
            if (special_name(branch, k) == names(i)) count = count + 1
         end do
         if (count > 0) text = text//', '//whole(count)//' '//trim(names(i))
      end do
      text = text//'; ends: '//end_text(branch%reasons(1))//', '//end_text(branch%reasons(2))
   end subroutine summarize

   !> Checks the &motion that a study of a structure starts from.
   subroutine check_structure_start(case, line)
      !> A case with a `start`, in which a fault is recorded.
      type(case_type), intent(inout) :: case
      !> Line of the group of the study.
      integer, intent(in) :: line
      type(values_type) :: group

      associate (not_used => line)    ! the faults belong to the &motion
      end associate
      group = case%start
      call check_structure_motion(case, group)
      case%start = group
   end subroutine check_structure_start

   !> Checks the parameter and its bounds.
   subroutine check_structure_branch(case)
      !> The case, with `start`.
      type(case_type), intent(inout) :: case
      type(structure_type) :: structure
      type(load_type) :: load
      type(change_type) :: change
      type(values_type) :: group
      integer :: status

      call structure_of(case, structure, load)
      load%frequency = load_frequency(case)
      call check_structure(structure, status)
      group = case%study
      call check_parameter(group, 'parameter', '', structure, load, change)
      case%study = group
   end subroutine check_structure_branch

   !> Follows the motion of a structure.
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
      type(change_type) :: change
      type(curve_type) :: curve
      type(condition_type), allocatable :: conditions(:)
      type(structure_motion_type), allocatable :: motions(:)
      real(wp), allocatable :: start(:), points(:, :), extremes(:, :, :), rest(:, :), rests(:, :, :)
      character(:), allocatable :: message
      integer :: i, n, reasons(2), reported, status
      logical :: cut, mirrored

      call add_expected_work(branch_work, progress)
      result%empty = .true.
      call find_structure_motion(case, case%start, .true., structure, load, found, status, &
         progress)
      if (status == stat%not_computed) then
         result%cut = 'the computation was stopped before a motion was found'
         return
      end if
      if (status /= stat%ok) then
         call result%fail(status_text(status))
         return
      end if
      call parameter_change(case%study, 'parameter', '', structure, load, change, message)
      call start_curve(structure, load, found, [change], curve, start, mirrored, message, &
         halves=.true.)
      if (len(message) > 0) then
         call result%fail(message)
         return
      end if
      curve%family%apart = 1.0e-5_wp
      curve%family%every_crossing = .true.
      call follow_both(curve, stride_type(longest=case%study%number('longest_step'), turn=0.3_wp), &
         start, case%study%whole_number('max_points'), points, conditions, reasons, progress)
      reported = follow_work
      cut = is_stopped(progress)
      n = size(conditions)
      if (n == 0 .or. (n == 1 .and. .not. cut)) then
         call result%fail('the branch cannot be followed from this motion: it is at a singular &
            &point, or its bounds are too far apart')
         return
      end if
      allocate (motions(n), extremes(case%coordinates, n, 2), rests(2, size(found%resting), n))
      do i = 1, n
         call motion_at(curve, points(:, i), conditions(i), motions(i), extremes(:, i, :), &
            rest)
         rests(:, :, i) = rest
         call report_share((follow_work + (branch_work - follow_work)*i/real(n, wp))/branch_work, &
            branch_work, reported, progress)
         if (is_stopped(progress) .and. .not. cut .and. i < n) then
            reasons(2) = end_stopped
            n = i
            exit
         end if
      end do
      call report_share(1.0_wp, branch_work, reported, progress)
      result%empty = .false.
      call put_structure_branch(result, curve, found, load%frequency, points(:, :n), &
         conditions(:n), motions(:n), extremes(:, :n, :), rests(:, :, :n), reasons, mirrored, &
         change, case%study%word('parameter'))
      call set_unit(result, 'points', 'value', case%study%word('parameter'))
      call put_path(result, [change])
      call put_structure(result, structure, load)
      if (any(reasons == end_stopped)) then
         result%cut = trim(case%study%word('parameter'))//' from '//trim(number_text(value_of( &
            minval(points(size(start), :n))), .false., 6))//' to '//trim(number_text(value_of( &
            maxval(points(size(start), :n))), .false., 6))//' was reached'
      end if
      call result%remark('first end: '//end_text(reasons(1))//'; last end: '//end_text(reasons(2)))
      if (any(reasons == end_full)) then
         call result%fail('cut short, max_points was reached')
      else if (any(reasons == end_stuck)) then
         call result%fail('cut short, the branch cannot be followed further')
      end if
   contains
      !> The parameter at a coordinate of a point.
      pure real(wp) function value_of(share)
         !> The last coordinate of the point.
         real(wp), intent(in) :: share

         value_of = value_at(change, share)
      end function value_of
   end subroutine run_structure

   !> Fills the tables of a branch of a structure.
   subroutine put_structure_branch(result, curve, found, frequency, points, conditions, motions, &
      extremes, rests, reasons, mirrored, change, name)
      !> The result.
      type(result_type), intent(inout) :: result
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> The motion at the start.
      type(settled_type), intent(in) :: found
      !> The load frequency there.
      real(wp), intent(in) :: frequency
      !> (size of a point, n) The points.
      real(wp), intent(in) :: points(:, :)
      !> (n) The condition that is zero at each point; kind 0 if none.
      type(condition_type), intent(in) :: conditions(:)
      !> (n) The motions.
      type(structure_motion_type), intent(in) :: motions(:)
      !> (coordinates, n, 2) Least and greatest coordinates.
      real(wp), intent(in) :: extremes(:, :, :)
      !> (2, m, n) Load phases (rad) at which each rest begins and ends.
      real(wp), intent(in) :: rests(:, :, :)
      !> Why it ends, at its first and at its last point.
      integer, intent(in) :: reasons(2)
      !> Whether a motion that repeats itself in the first way is its own image.
      logical, intent(in) :: mirrored
      !> The parameter, and its name.
      type(change_type), intent(in) :: change
      character(*), intent(in) :: name
      type(line_type) :: special(size(motions)), detail(size(motions)), ends(2)
      character(name_length), parameter :: names(15) = [character(name_length) :: 'fold', &
         'pitchfork', 'branch_point', 'flip', 'neimark_sacker', 'grazing', 'zero_approach', &
         'simultaneous', 'rest_vanishes', 'rest_splits', 'stick_begins', 'stick_vanishes', &
         'contact_vanishes', 'flight_vanishes', 'event_vanishes']
      character(:), allocatable :: text
      real(wp) :: values(size(motions)), phases(size(found%gaps), size(motions)), &
         shift(size(motions))
      integer :: i, k, n

      n = size(motions)
      do i = 1, n
         phases(:, i) = phases_at(curve, points(:, i))
         values(i) = value_at(change, points(size(points, 1), i))
         associate (condition => conditions(i))
            special(i)%text = ''
            detail(i)%text = ''
            if (condition%kind == 0) cycle
            special(i)%text = trim(condition_name(condition%kind, condition%index, &
               curve%family%symmetric, mirrored))
            if (is_exchange(condition)) special(i)%text = 'simultaneous'
            call touch_detail(curve, condition, [trim(name)], detail(i)%text)
            if (condition%kind == edge) values(i) = value_at(change, condition%bound)
         end associate
      end do
      call result%open('points', 'point', [n])
      call result%put('points', 'point', [(i, i=1, n)])
      call result%put('points', 'value', values)
      if (found%free) call result%put('points', 'period', [(period_at(curve, points(:, i)), &
         i=1, n)])
      call result%put('points', 'consistent', [(motions(i)%verdicts%consistent, i=1, n)])
      call result%put('points', 'admissible', [(motions(i)%verdicts%admissible, i=1, n)])
      call result%put('points', 'stable', [(motions(i)%verdicts%stable, i=1, n)])
      call result%put('points', 'multipliers', [(motions(i)%verdicts%multipliers, i=1, n)])
      call result%put('points', 'residual', motions%residual)
      call result%put('points', 'q_min', [extremes(:, :, 1)])
      call result%put('points', 'q_max', [extremes(:, :, 2)])
      ! continuous along the branch, and none below 0
      shift = -two_pi*min(0, floor(minval(phases)/two_pi))
      call result%put('points', 'phases', [phases + shift(1)])
      call result%put('points', 'speeds', [(motions(i)%speeds, i=1, n)])
      call result%put('points', 'impulses', [(motions(i)%impulses, i=1, n)])
      call result%put_text('points', 'special', special)
      call result%put_text('points', 'detail', detail)
      call result%open('branch', 'branch', [1])
      call result%put('branch', 'gaps', found%gaps - 1)
      if (size(found%resting) > 0) then
         ! in the same cycle as the phases
         call result%put('points', 'rest_begin', [rests(1, :, :) + spread(shift, 1, &
            size(found%resting))])
         call result%put('points', 'rest_end', [rests(2, :, :) + spread(shift, 1, &
            size(found%resting))])
         call result%put('branch', 'resting', found%resting - 1)
      end if
      if (size(found%resting) > 0 .or. allocated(found%events)) then
         call result%put('points', 'q', [(motions(i)%states(:size(extremes, 1), 1), i=1, n)])
         call result%put('points', 'q_dot', [(motions(i)%states(size(extremes, 1) + 1:, 1), &
            i=1, n)])
      end if
      call result%put('branch', 'cycles', [found%cycles])
      call result%put('branch', 'frequency', [frequency])
      if (allocated(found%sequence)) then
         call result%open('events', 'event', [size(found%sequence, 2)])
         call result%put('events', 'impact', found%sequence(3, :))
         call result%put('events', 'gap', found%sequence(2, :) - 1)
         call result%put('events', 'kind', found%sequence(1, :))
      end if
      ends(1)%text = end_text(reasons(1))
      ends(2)%text = end_text(reasons(2))
      call result%put_text('branch', 'first_end', ends(1:1))
      call result%put_text('branch', 'last_end', ends(2:2))
      text = counted(n, 'point')
      do i = 1, size(names)
         k = count([(special(k)%text == names(i), k=1, n)])
         if (k > 0) text = text//', '//whole(k)//' '//trim(names(i))
      end do
      call result%add_note(text//'; ends: '//ends(1)%text//', '//ends(2)%text)
   end subroutine put_structure_branch

   !> The flight and gap, the impact or the bound that a condition concerns.
   pure subroutine touch_detail(curve, condition, names, text)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> The condition.
      type(condition_type), intent(in) :: condition
      !> The parameters.
      character(*), intent(in) :: names(:)
      !> The text; empty if there is nothing to say.
      character(:), allocatable, intent(out) :: text
      integer :: gap, number

      text = ''
      number = condition%index
      gap = 0
      select type (family => curve%family)
      type is (structure_resting_type)
         associate (structure => family%rests%path%structure)
            gap = findloc(structure%channel*structure%wall, condition%side, dim=1)
            if (condition%kind == rest_vanishes) gap = family%rests%gaps(number)
            if (condition%kind == rest_splits) gap = condition%side - structure%channels
            if (any(condition%kind == [stick_begins, stick_vanishes, contact_vanishes, &
               flight_vanishes, event_vanishes])) gap = family%rests%gaps(number)
            if (condition%kind == grazing .and. allocated(family%rests%rows)) then
               if (.not. (structure%rubs(max(1, gap)) .or. structure%elastic(max(1, gap)))) gap = &
                  -gap
               if (gap >= 0) call element_detail(family%rests, condition, text)
               if (gap >= 0) return
               gap = -gap
            end if
            number = count(family%rests%kinds(:number) /= release)
         end associate
      type is (structure_family_type)
         associate (s => family%members)
            if (allocated(s%impact_of)) number = findloc(s%impact_of, number, dim=1, &
               back=condition%kind == grazing)
            gap = findloc(s%path%structure%channel*s%path%structure%wall, condition%side, dim=1)
            if (allocated(s%impact_of) .and. gap > 0) gap = s%path%kept(gap)
         end associate
      end select
      select case (condition%kind)
      case (grazing)
         text = 'flight '//whole(number)//' touches gap '//whole(gap - 1)
         if (condition%share >= 1) text = 'gap '//whole(gap - 1)// &
            ' closes at the end of flight '//whole(number)
      case (rest_vanishes, rest_splits)
         text = 'rest of gap '//whole(gap - 1)
      case (stick_begins, stick_vanishes)
         text = 'friction '//whole(gap - 1)
      case (event_vanishes)
         text = 'friction '//whole(gap - 1)//' in event '//whole(number)
      case (contact_vanishes, flight_vanishes)
         text = 'stop '//whole(gap - 1)
      case (zero_approach)
         text = 'impact '//whole(number)
      case (edge)
         text = trim(merge('lowest ', 'highest', condition%side > 0))//' '// &
            trim(names(condition%index))
      case default
         text = ''
      end select
   end subroutine touch_detail

   !> What a stop or friction would do within a flight.
   pure subroutine element_detail(rests, condition, text)
      !> The family.
      type(rests_type), intent(in) :: rests
      !> The condition: a row is at its limit.
      type(condition_type), intent(in) :: condition
      !> The text.
      character(:), allocatable, intent(out) :: text
      integer, allocatable :: held(:)
      integer :: number, row

      row = abs(condition%side)
      associate (structure => rests%path%structure, set => rests%closed(condition%index)%set)
         if (row > structure%channels) then
            held = pack(set, set > 0 .and. structure%rubs(abs(set)))
            text = 'friction '//whole(held(row - structure%channels) - 1)//merge( &
               ' slips         ', ' does not stick', condition%share > 0)
         else
            number = findloc(structure%channel == row .or. structure%push == row, .true., dim=1)
            text = 'stop '//whole(number - 1)//' is touched'
            if (structure%rubs(number)) then
               text = 'friction '//whole(number - 1)//' halts'
            else if (row /= structure%channel(number)) then
               text = 'stop '//whole(number - 1)//merge(' presses', ' lets go', condition%side > 0)
            else if (condition%side < 0) then
               text = 'stop '//whole(number - 1)//' is left'
            end if
         end if
      end associate
      text = trim(text)//' in flight '//whole(condition%index)
   end subroutine element_detail

end module vi_branch_study
