!> The study &branch of a &structure: motions along a parameter, from that of a &motion.
module vi_branch_structure_study
   use vi_branch, only: end_full, end_stopped, end_stuck, end_text
   use vi_branch_study, only: branch_keys
   use vi_branch_table, only: branch_work, follow_both, follow_work
   use vi_condition_names, only: condition_name
   use vi_curve_point, only: curve_type, parameters_of, unknowns_of
   use vi_kinds, only: wp
   use vi_motion_family, only: condition_type, edge, grazing, zero_approach
   use vi_motion_structure_study, only: check_structure_motion, find_structure_motion
   use vi_progress, only: add_expected_work, is_stopped, report_share
   use vi_status, only: stat, status_text
   use vi_steps, only: stride_type
   use vi_structure, only: check_structure, load_type, structure_type
   use vi_structure_family, only: structure_family_type
   use vi_structure_groups, only: load_frequency, structure_of
   use vi_structure_parameter, only: check_parameter, function_keys, parameter_change
   use vi_structure_path, only: change_type, parameter_takes, value_at
   use vi_structure_period, only: structure_motion_type
   use vi_structure_return, only: settled_type
   use vi_structure_start, only: motion_at, phases_at, start_curve
   use vi_structure_tables, only: path_columns, put_path, put_structure, structure_columns
   use vi_study, only: a_word, case_type, column_type, complexes, key_type, result_type, &
      study_type, values_type, verdicts, wholes, words
   use vi_text, only: counted, line_type, number_text, whole
   implicit none (type, external)
   private

   public :: check_structure_start, declare_branch_structure, touch_detail

   type(key_type), parameter :: parameter_key = key_type('parameter', a_word, &
      takes=parameter_takes, meaning='parameter that changes')

   type(column_type), parameter :: branch_columns(*) = [ &
      column_type('points', 'point', wholes, meaning='number of the point along the branch'), &
      column_type('points', 'value', meaning='the parameter'), &
      column_type('points', 'consistent', verdicts, meaning='whether it solves all equations'), &
      column_type('points', 'admissible', verdicts, &
      meaning='whether all gaps stay open between the impacts'), &
      column_type('points', 'stable', verdicts, meaning='whether disturbances decay'), &
      column_type('points', 'multipliers', complexes, each='multiplier', &
      label='multiplier_#_modulus', meaning='eigenvalues of [P], in order of decreasing modulus'), &
      column_type('points', 'residual', &
      meaning='largest relative residual of the equations'), &
      column_type('points', 'q_min', each='coordinate', label='q_min_#', &
      meaning='least value of each coordinate'), &
      column_type('points', 'q_max', each='coordinate', label='q_max_#', &
      meaning='greatest value of each coordinate'), &
      column_type('points', 'phases', each='impact', label='phase_#', unit='rad', &
      meaning='load phases of the impacts'), &
      column_type('points', 'speeds', each='impact', label='speed_#', &
      meaning='approach speeds of the impacts'), &
      column_type('points', 'impulses', each='impact', listed=.false., &
      meaning='impulses of the impacts'), &
      column_type('points', 'special', words, meaning='type of a special point'), &
      column_type('points', 'detail', words, meaning='the impact, flight or bound concerned'), &
      column_type('branch', 'gaps', wholes, each='impact', listed=.false., &
      meaning='gaps of the impacts, from 0'), &
      column_type('branch', 'cycles', wholes, listed=.false., meaning='load cycles in a period'), &
      column_type('branch', 'frequency', listed=.false., &
      meaning='circular frequency of the load at the start'), &
      column_type('branch', 'first_end', words, listed=.false., &
      meaning='why it ends at its first point'), &
      column_type('branch', 'last_end', words, listed=.false., &
      meaning='why it ends at its last point'), path_columns, structure_columns]

contains

   !> Declares the study.
   subroutine declare_branch_structure(study)
      !> The declaration of the study.
      type(study_type), intent(out) :: study

      study%name = 'branch_structure'
      study%group = 'branch'
      study%of_structure = .true.
      study%meaning = 'follow a motion of a structure along a parameter'
      study%starts_from = 'motion'
      study%list => list_branch
      study%row = 'points'
      study%check => check_branch
      study%check_start => check_structure_start
      study%memory => branch_memory
      study%run => run_branch
   end subroutine declare_branch_structure

   !> Lists the keys and columns.
   pure subroutine list_branch(keys, columns)
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) keys = [parameter_key, branch_keys(2:), function_keys]
      if (present(columns)) columns = branch_columns
   end subroutine list_branch

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
   subroutine check_branch(case)
      !> The case, with `start`.
      type(case_type), intent(inout) :: case
      type(structure_type) :: structure
      type(load_type) :: load
      type(change_type) :: change
      type(values_type) :: group
      integer :: status

      if (len(case%study%fault) > 0) return
      call structure_of(case, structure, load)
      load%frequency = load_frequency(case)
      call check_structure(structure, status)
      group = case%study
      call check_parameter(group, 'parameter', '', structure, load, change)
      case%study = group
   end subroutine check_branch

   !> Bytes for the points that max_points allows, in both directions and in the result.
   pure real(wp) function branch_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case
      integer :: impacts

      impacts = 24
      if (case%start%has('gaps')) impacts = size(case%start%numbers('gaps'))
      bytes = case%study%whole_number('max_points')*(2000 + 300.0_wp*(impacts + case%coordinates))
   end function branch_memory

   !> Follows the motion of a case.
   subroutine run_branch(case, threads, result, progress)
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
      type(change_type) :: change
      type(curve_type) :: curve
      type(condition_type), allocatable :: conditions(:)
      type(structure_motion_type), allocatable :: motions(:)
      real(wp), allocatable :: start(:), points(:, :), extremes(:, :, :)
      character(:), allocatable :: message
      integer :: i, n, reasons(2), reported, status
      logical :: cut, mirrored

      associate (not_used => threads)    ! a branch is followed from point to point
      end associate
      call add_expected_work(branch_work, progress)
      result%empty = .true.
      call find_structure_motion(case, case%start, .true., structure, load, found, status, &
         progress)
      if (status == stat%not_computed) then
         result%cut = 'it was stopped before a motion was reached'
         return
      end if
      if (status /= stat%ok) then
         call result%fail(status_text(status))
         return
      end if
      call parameter_change(case%study, 'parameter', '', structure, load, change, message)
      call start_curve(structure, load, found, [change], curve, start, mirrored, message)
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
      allocate (motions(n), extremes(case%coordinates, n, 2))
      do i = 1, n
         call motion_at(curve, points(:, i), conditions(i), motions(i), extremes(:, i, :))
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
      call put_branch(result, curve, found, load%frequency, points(:, :n), conditions(:n), &
         motions(:n), extremes(:, :n, :), reasons, mirrored, change, case%study%word('parameter'))
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
   end subroutine run_branch

   !> Fills the tables of a branch.
   subroutine put_branch(result, curve, found, frequency, points, conditions, motions, extremes, &
      reasons, mirrored, change, name)
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
      !> Why it ends, at its first and at its last point.
      integer, intent(in) :: reasons(2)
      !> Whether a motion that repeats itself in the first way is its own image.
      logical, intent(in) :: mirrored
      !> The parameter, and its name.
      type(change_type), intent(in) :: change
      character(*), intent(in) :: name
      type(line_type) :: special(size(motions)), detail(size(motions)), ends(2)
      character(14), parameter :: names(8) = [character(14) :: 'fold', 'pitchfork', &
         'branch_point', 'flip', 'neimark_sacker', 'grazing', 'zero_approach', 'simultaneous']
      character(:), allocatable :: text
      real(wp) :: values(size(motions)), phases(size(found%gaps), size(motions))
      real(wp), parameter :: turn = 2*acos(-1.0_wp)
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
            if (condition%kind == grazing .and. condition%share >= 1) special(i)%text = &
               'simultaneous'
            call touch_detail(curve, condition, [trim(name)], detail(i)%text)
            if (condition%kind == edge) values(i) = value_at(change, condition%bound)
         end associate
      end do
      call result%open('points', 'point', [n])
      call result%put('points', 'point', [(i, i=1, n)])
      call result%put('points', 'value', values)
      call result%put('points', 'consistent', [(motions(i)%verdicts%consistent, i=1, n)])
      call result%put('points', 'admissible', [(motions(i)%verdicts%admissible, i=1, n)])
      call result%put('points', 'stable', [(motions(i)%verdicts%stable, i=1, n)])
      call result%put('points', 'multipliers', [(motions(i)%verdicts%multipliers, i=1, n)])
      call result%put('points', 'residual', motions%residual)
      call result%put('points', 'q_min', [extremes(:, :, 1)])
      call result%put('points', 'q_max', [extremes(:, :, 2)])
      ! continuous along the branch, and none below 0
      call result%put('points', 'phases', [phases - turn*min(0, floor(minval(phases)/turn))])
      call result%put('points', 'speeds', [(motions(i)%speeds, i=1, n)])
      call result%put('points', 'impulses', [(motions(i)%impulses, i=1, n)])
      call result%put_text('points', 'special', special)
      call result%put_text('points', 'detail', detail)
      call result%open('branch', 'branch', [1])
      call result%put('branch', 'gaps', found%gaps - 1)
      call result%put('branch', 'cycles', [found%cycles])
      call result%put('branch', 'frequency', [frequency])
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
   end subroutine put_branch

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
      case (zero_approach)
         text = 'impact '//whole(number)
      case (edge)
         text = trim(merge('lowest ', 'highest', condition%side > 0))//' '// &
            trim(names(condition%index))
      case default
         text = ''
      end select
   end subroutine touch_detail

end module vi_branch_structure_study
