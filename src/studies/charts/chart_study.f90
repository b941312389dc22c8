!> The study &chart: the motions of a pattern on a grid.
module vi_chart_study
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_branch_study, only: check_structure_start
   use vi_common_keys, only: cycles_key, most_numbers, symmetric_key, turn_upwards, window_keys
   use vi_curve_point, only: curve_type
   use vi_family, only: can_be_symmetric
   use vi_kinds, only: two_pi, wp
   use vi_lattice, only: even_lattice, lattice_type, nearest_lines
   use vi_motion, only: unknown, yes
   use vi_motion_family, only: condition_type
   use vi_net, only: cover, cover_from, net_type, new_net
   use vi_pattern, only: new_pattern, pattern_type, side_symbols
   use vi_progress, only: add_done_work, add_expected_work, is_stopped
   use vi_spacing, only: even, spaced
   use vi_status, only: stat
   use vi_structure_parameter, only: x_function_keys, y_function_keys
   use vi_structure_path, only: change_type, value_at
   use vi_structure_period, only: structure_motion_type
   use vi_structure_start, only: motion_at, period_at, phases_at
   use vi_structure_tables, only: set_unit
   use vi_text, only: counted, whole
   use vi_chart_grid, only: compute_chart, chart_type, most_points, chart_grid_type
   use vi_study, only: a_whole, a_word, case_type, column_type, complexes, every_model, key_type, &
      list_for, of_oscillator, of_structure, result_type, study_type, values_type, verdicts, wholes
   use vi_zone, only: place_at_node
   use vi_zone_study, only: check_plane, plane_columns, plane_keys, plane_type, put_plane, &
      start_surface
   implicit none (type, external)
   private

   public :: declare_chart

   integer, parameter :: most_impacts = 12
   character(*), parameter :: many = &
      'a whole number of at least 2, with r_points x clearance_points <= 1000000'

   type(key_type), parameter :: chart_keys(*) = [ &
      key_type('sides', a_word, &
      takes='letters R and L, one for each impact, 2 to 12 of them, each wall at least once', &
      meaning='walls of the impacts in order, for example RRL'), &
      cycles_key, &
      key_type('r', most=most_points, low=window_keys(1)%low, high=window_keys(1)%high, &
      may_miss=.true., option='r-list', &
      takes='increasing or decreasing numbers with 1e-6 <= r <= 1e6', &
      unit='omega', meaning='the frequency ratios, if they are not evenly spaced'), &
      key_type('r_min', low=window_keys(1)%low, high=window_keys(1)%high, never='r', &
      option='r', unit='omega', meaning='first frequency ratio'), &
      key_type('r_max', low=window_keys(2)%low, high=window_keys(2)%high, over='r_min', never='r', &
      option='r', unit='omega', meaning='last frequency ratio'), &
      key_type('r_points', a_whole, low=2.0_wp, high=1.0e6_wp, takes=many, never='r', &
      option='r', meaning='number of frequency ratios'), &
      key_type('clearance', most=most_points, low=window_keys(3)%low, high=window_keys(3)%high, &
      may_miss=.true., option='clearance-list', unit='F0/K', &
      takes='increasing or decreasing numbers with 1e-12 <= clearance <= 1e12', &
      meaning='the clearances d K/F0 (d is the whole travel of m), if not evenly spaced'), &
      key_type('clearance_min', low=window_keys(3)%low, high=window_keys(3)%high, unit='F0/K', &
      never='clearance', option='clearance', &
      meaning='first clearance d K/F0; d is the whole travel of m between the walls'), &
      key_type('clearance_max', low=window_keys(4)%low, high=window_keys(4)%high, unit='F0/K', &
      over='clearance_min', never='clearance', option='clearance', &
      meaning='last clearance d K/F0'), &
      key_type('clearance_points', a_whole, low=2.0_wp, high=1.0e6_wp, takes=many, &
      never='clearance', option='clearance', meaning='number of clearances'), &
      key_type('spacing', a_word, default='''linear''', words='linear geometric', &
      takes='''linear'' or ''geometric'' (of the clearances)', never='clearance', &
      meaning='spacing of the clearances'), &
      symmetric_key, &
      key_type('slots', a_whole, default='4', low=1.0_wp, high=32.0_wp, &
      meaning='number of slots for motions without closed form at each point'), &
      key_type('guesses', a_whole, default='32', low=1.0_wp, high=1.0e4_wp, &
      meaning='guesses in each search'), &
      key_type('seeds', a_whole, default='12', low=1.0_wp, high=1.0e4_wp, &
      meaning='number of searches along each axis'), &
      key_type('multipliers', a_word, words='yes no', may_miss=.true., &
      meaning='''no'' skips the multipliers of equispaced motions, which take most of the time')]

   !> Largest number of points along an axis of a structure.
   integer, parameter :: most_lines = 129
   character(*), parameter :: increasing = 'increasing or decreasing numbers from one end of the &
      &range to the other'
   type(key_type), parameter :: structure_keys(*) = [ &
      key_type('x_values', least=2, most=most_lines, may_miss=.true., takes=increasing, &
      option='x-list', meaning='the values of x, if they are not evenly spaced'), &
      key_type('x_points', a_whole, default='33', low=2.0_wp, high=real(most_lines, wp), &
      never='x_values', option='x', meaning='number of values of x, evenly spaced'), &
      key_type('y_values', least=2, most=most_lines, may_miss=.true., takes=increasing, &
      option='y-list', meaning='the values of y, if they are not evenly spaced'), &
      key_type('y_points', a_whole, default='33', low=2.0_wp, high=real(most_lines, wp), &
      never='y_values', option='y', meaning='number of values of y, evenly spaced')]

   type(column_type), parameter :: chart_columns(*) = [ &
      column_type('ratios', 'r', meaning='frequency ratio', model=of_oscillator), &
      column_type('clearances', 'clearance', unit='F0/K', &
      meaning='clearance d K/F0; d is the whole travel of m between the walls', &
      model=of_oscillator), &
      column_type('abscissas', 'x', meaning='parameter of the abscissa', model=of_structure), &
      column_type('ordinates', 'y', meaning='parameter of the ordinate', model=of_structure), &
      column_type('slots', 'slot', wholes, meaning='number of the motion at its point'), &
      column_type('motions', 'consistent', verdicts, meaning='whether it solves all equations'), &
      column_type('motions', 'admissible', verdicts, &
      meaning='whether it stays between the walls'), &
      column_type('motions', 'stable', verdicts, meaning='whether disturbances decay'), &
      column_type('motions', 'leading', label='multiplier_1_modulus', &
      meaning='greatest modulus of the multipliers'), &
      column_type('motions', 'multipliers', complexes, each='multiplier', listed=.false., &
      meaning='eigenvalues of [P], in order of decreasing modulus'), &
      column_type('motions', 'x_min', unit='F0/K', listed=.false., &
      meaning='smallest displacement of the primary mass', model=of_oscillator), &
      column_type('motions', 'x_max', unit='F0/K', &
      meaning='greatest displacement of the primary mass', model=of_oscillator), &
      column_type('motions', 'tau', unit='rad', listed=.false., meaning='phase of equation (4)', &
      model=of_oscillator), &
      column_type('motions', 'q_min', unit='F0/K', each='coordinate', label='q_min_#', &
      listed=.false., &
      meaning='smallest value of each coordinate', model=of_structure), &
      column_type('motions', 'q_max', unit='F0/K', each='coordinate', label='q_max_#', &
      meaning='greatest value of each coordinate', model=of_structure), &
      column_type('motions', 'phases', each='impact', unit='rad', listed=.false., &
      meaning='load phases of the impacts; for an oscillator from the first impact'), &
      column_type('motions', 'X', each='impact', unit='F0/K', listed=.false., &
      meaning='displacements of the primary mass at the impacts', model=of_oscillator), &
      column_type('motions', 'speeds', unit='omega F0/K', each='impact', listed=.false., &
      meaning='approach speeds of the impacts', model=of_structure), &
      column_type('motions', 'period', unit='1/omega', listed=.false., &
      meaning='period of a self-excited motion', &
      model=of_structure), &
      column_type('motions', 'status', wholes, absent=[stat%no_motion, stat%not_computed], &
      meaning='code of the failure; 0: none'), &
      column_type('points', 'found', wholes, listed=.false., &
      meaning='number of motions at the point, including those without a slot')]

contains

   !> Declares the study, with its keys and columns.
   pure subroutine declare_chart(study, keys, columns)
      !> The study.
      type(study_type), intent(out), optional :: study
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) then
         call list_for(of_oscillator, chart_keys, keys)
         call list_for(of_structure, plane_keys, keys)
         call list_for(of_structure, structure_keys, keys)
         call list_for(of_structure, x_function_keys, keys)
         call list_for(of_structure, y_function_keys, keys)
      end if
      if (present(columns)) then
         call list_for(every_model, chart_columns, columns)
         call list_for(of_structure, plane_columns, columns)
      end if
      if (.not. present(study)) return
      study%name = 'chart'
      study%meaning = 'compute the motions of a pattern on a grid of two parameters'
      study%starts_from(of_structure) = 'motion'
      study%takes_elements = .true.
      study%takes_walls = .true.
      study%check_start => check_structure_start
      study%row = 'motions'
      study%check => check_chart
      study%memory => chart_memory
      study%run => run_chart
   end subroutine declare_chart

   !> Checks the rules that involve several keys.
   subroutine check_chart(case)
      !> The case.
      type(case_type), intent(inout) :: case
      type(pattern_type) :: pattern
      type(chart_grid_type) :: grid
      real(wp) :: points
      integer :: n

      if (len(case%study%fault) > 0) return
      if (case%model == of_structure) then
         call check_values(case%study, 'x')
         call check_values(case%study, 'y')
         if (len(case%study%fault) == 0) call check_plane(case)
         return
      end if
      pattern = chart_pattern(case%study)
      n = size(pattern%sides)
      if (n < 2 .or. n > most_impacts .or. any(pattern%sides == 0) .or. abs(sum(pattern%sides)) &
         == n) then
         call case%study%refuse('sides')
         return
      end if
      call turn_upwards(case%study, 'r', [character(1) ::])
      call turn_upwards(case%study, 'clearance', [character(1) ::])
      points = real(points_of(case%study, 'r'), wp)*points_of(case%study, 'clearance')
      if (points > most_points) then
         call case%study%refuse(points_key(case%study, 'clearance'), trim(points_key(case%study, &
            'r'))//' is '//whole(points_of(case%study, 'r')))
         return
      end if
      grid = chart_grid_of(case%study)
      call check_axis(case%study, 'r', grid%r)
      call check_axis(case%study, 'clearance', grid%clearance)
      if (grid%symmetry > 0 .and. .not. can_be_symmetric(pattern, case%osc%restitution)) then
         call case%study%refuse('symmetric', '''yes'' requires equal restitution, an odd number of &
            &cycles and sides whose second half mirrors the first')
      else if (.not. (grid%symmetry > 0 .and. n == 2) .and. points*max(grid%slots, 4)*n > &
         most_numbers) then
         call case%study%refuse(points_key(case%study, 'r'), 'points x slots x impacts must be at &
            &most '//whole(most_numbers))
      else
         call case%study%set_word('sides', side_symbols(pattern%sides))
      end if
   end subroutine check_chart

   !> Checks the values of an axis of a structure, which begin and end with its range.
   pure subroutine check_values(study, name)
      !> The group.
      type(values_type), intent(inout) :: study
      !> `x` or `y`.
      character(*), intent(in) :: name
      real(wp), allocatable :: values(:)
      integer :: i

      call turn_upwards(study, name//'_values', [character(1) ::])
      if (len(study%fault) > 0 .or. .not. study%has(name//'_values')) return
      values = study%numbers(name//'_values')
      do i = 2, size(values)
         if (values(i) > values(i - 1)) cycle
         call study%refuse(name//'_values', 'number '//whole(i)//' must be above number '// &
            whole(i - 1))
         return
      end do
      if (abs(values(1) - study%number(name//'_low')) > 0 .or. abs(values(size(values)) - &
         study%number(name//'_high')) > 0) call study%refuse(name//'_values')
   end subroutine check_values

   !> The lattice of a chart of a structure, in shares of the ranges.
   pure type(lattice_type) function chart_lattice(study) result(lattice)
      !> The group.
      type(values_type), intent(in) :: study
      character, parameter :: names(2) = ['x', 'y']
      real(wp), allocatable :: values(:)
      integer :: i

      lattice = even_lattice(points_of_axis(study, 'x'), points_of_axis(study, 'y'))
      do i = 1, 2
         if (.not. study%has(names(i)//'_values')) cycle
         values = study%numbers(names(i)//'_values')
         lattice%axes(i)%at = (values - values(1))/(values(size(values)) - values(1))
      end do
   end function chart_lattice

   !> The values of an axis of a chart of a structure.
   pure subroutine axis_values(study, name, change, at, values)
      !> The group.
      type(values_type), intent(in) :: study
      !> `x` or `y`.
      character(*), intent(in) :: name
      !> Its parameter.
      type(change_type), intent(in) :: change
      !> The values in shares of its range.
      real(wp), intent(in) :: at(:)
      !> The values.
      real(wp), allocatable, intent(out) :: values(:)
      integer :: i

      if (study%has(name//'_values')) then
         values = study%numbers(name//'_values')
      else
         values = [(value_at(change, at(i)), i=1, size(at))]
      end if
   end subroutine axis_values

   !> Checks that the numbers along an axis increase.
   pure subroutine check_axis(study, name, axis)
      !> The group.
      type(values_type), intent(inout) :: study
      !> `r` or `clearance`.
      character(*), intent(in) :: name
      !> Its values.
      real(wp), intent(in) :: axis(:)
      integer :: i

      do i = 2, size(axis)
         if (axis(i) > axis(i - 1)) cycle
         if (study%has(name)) call study%refuse(name, 'number '//whole(i)//' must be above number &
            &' &
            //whole(i - 1))
         if (.not. study%has(name)) call study%refuse(name//'_max', &
            'the range has not that many distinct values')
         return
      end do
   end subroutine check_axis

   !> Number of values along an axis of a structure.
   pure integer function points_of_axis(study, name) result(n)
      !> The group.
      type(values_type), intent(in) :: study
      !> `x` or `y`.
      character(*), intent(in) :: name

      if (study%has(name//'_values')) then
         n = size(study%numbers(name//'_values'))
      else
         n = study%whole_number(name//'_points')
      end if
   end function points_of_axis

   !> Number of points along an axis.
   pure integer function points_of(study, name) result(n)
      !> The group.
      type(values_type), intent(in) :: study
      !> `r` or `clearance`.
      character(*), intent(in) :: name

      if (study%has(name)) then
         n = size(study%numbers(name))
      else
         n = study%whole_number(name//'_points')
      end if
   end function points_of

   !> The key that sets the number of points along an axis.
   pure function points_key(study, name) result(key)
      !> The group.
      type(values_type), intent(in) :: study
      !> `r` or `clearance`.
      character(*), intent(in) :: name
      character(16) :: key

      key = name
      if (.not. study%has(name)) key = name//'_points'
   end function points_key

   !> The pattern of a chart.
   pure function chart_pattern(study) result(pattern)
      !> The group.
      type(values_type), intent(in) :: study
      type(pattern_type) :: pattern
      character(:), allocatable :: symbols

      call study%text('sides', symbols)
      pattern = new_pattern(symbols, study%whole_number('cycles'))
   end function chart_pattern

   !> The grid, and how it is searched.
   pure function chart_grid_of(study) result(grid)
      !> The group.
      type(values_type), intent(in) :: study
      type(chart_grid_type) :: grid

      if (study%has('r')) then
         grid%r = study%numbers('r')
      else
         grid%r = even(study%number('r_min'), study%number('r_max'), points_of(study, 'r'))
      end if
      if (study%has('clearance')) then
         grid%clearance = study%numbers('clearance')
      else
         grid%clearance = spaced(study%number('clearance_min'), study%number('clearance_max'), &
            points_of(study, 'clearance'), study%is('spacing', 'geometric'))
      end if
      grid%slots = study%whole_number('slots')
      grid%guesses = study%whole_number('guesses')
      grid%seeds = study%whole_number('seeds')
      if (study%has('multipliers')) grid%multipliers = study%is('multipliers', 'yes')
      if (study%is('symmetric', 'yes')) grid%symmetry = 1
      if (study%is('symmetric', 'no')) grid%symmetry = -1
   end function chart_grid_of

   !> Bytes for all points: three copies of the numbers of each possible motion.
   pure real(wp) function chart_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case
      type(pattern_type) :: pattern

      associate (s => case%study)
         if (case%model == of_structure) then
            ! a few motions at each point, with their derivatives
            bytes = 4.0_wp*points_of_axis(s, 'x')*points_of_axis(s, 'y')*(4000 + 100.0_wp* &
               case%coordinates**2)
            return
         end if
         pattern = chart_pattern(s)
         bytes = 3.0_wp*points_of(s, 'r')*points_of(s, 'clearance')*(s%whole_number('slots') + 2)* &
            (16*size(pattern%sides) + 150)
      end associate
   end function chart_memory

   !> Finds the motions of a pattern on a grid.
   subroutine run_chart(case, threads, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(chart_type) :: chart
      type(pattern_type) :: pattern
      type(chart_grid_type) :: grid
      character(:), allocatable :: what
      integer :: i, slots, m, n, reached

      if (case%model == of_structure) then
         call run_structure(case, threads, result, progress)
         return
      end if
      pattern = chart_pattern(case%study)
      grid = chart_grid_of(case%study)
      call compute_chart(case%osc, pattern, grid, threads, chart, progress)
      what = side_symbols(pattern%sides)//'/'//whole(pattern%cycles)
      slots = size(chart%status, 1)
      m = size(chart%status, 2)
      n = size(chart%status, 3)
      call result%open('ratios', 'r', [n])
      call result%put('ratios', 'r', grid%r)
      call result%open('clearances', 'clearance', [m])
      call result%put('clearances', 'clearance', grid%clearance)
      call result%open('slots', 'slot', [slots])
      call result%put('slots', 'slot', [(i, i=1, slots)])
      call result%open('motions', 'slot clearance r', [slots, m, n])
      call result%put('motions', 'consistent', [chart%verdicts(1, :, :, :)])
      call result%put('motions', 'admissible', [chart%verdicts(2, :, :, :)])
      call result%put('motions', 'stable', [chart%verdicts(3, :, :, :)])
      call result%put('motions', 'leading', [abs(chart%multipliers(1, :, :, :))])
      call result%put('motions', 'multipliers', [chart%multipliers])
      call result%put('motions', 'x_min', [chart%x_min])
      call result%put('motions', 'x_max', [chart%x_max])
      call result%put('motions', 'tau', [chart%tau])
      call result%put('motions', 'phases', [chart%phases])
      call result%put('motions', 'X', [chart%x])
      call result%put('motions', 'status', [chart%status])
      call result%open('points', 'clearance r', [m, n])
      call result%put('points', 'found', [chart%found])
      reached = count(any(chart%status /= stat%not_computed, 1))
      if (reached < m*n) then
         result%cut = whole(reached)//' of '//whole(m*n)//' points were reached'
         ! a search that was stopped does not know where there are no motions
         if (.not. (grid%symmetry > 0 .and. size(pattern%sides) == 2)) result%cut = &
            'motions were found at '//whole(reached)//' of '//whole(m*n)//' points so far'
      end if
      result%empty = all(chart%status /= stat%ok)
      if (result%empty) then
         call result%fail('no motion '//what//' was found anywhere in the window')
      else
         call result%add_note(whole(count(chart%status == &
            stat%ok))//' motions '//what//' at '//whole( &
            count(any(chart%status == stat%ok, 1)))//' of '//whole(m*n)//' points, '//whole(count( &
            all(chart%verdicts == yes, 1)))//' admissible and stable')
      end if
   end subroutine run_chart

   !> Finds the motions of a structure on a grid: where the lines of a lattice cross on the surface
   !! of motions about a given one.
   subroutine run_structure(case, threads, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(plane_type) :: plane
      type(curve_type) :: surface
      type(net_type) :: net
      type(structure_motion_type), allocatable :: motions(:)
      real(wp), allocatable :: start(:), extremes(:, :, :)
      logical :: at_node, mirrored
      integer :: i, m

      call add_expected_work(2, progress)
      call start_surface(case, plane, surface, start, mirrored, result, progress)
      if (.not. allocated(start)) return
      m = size(start) - 2
      call new_net(surface, chart_lattice(case%study), net, .false.)
      call place_at_node(net, start(m + 1:), start(:m), nearest_lines(net%lines, start(m + 1:)), &
         at_node)
      if (at_node) then
         call cover(net, 1, progress)
      else
         call cover_from(net, start(m + 1:), start(:m), progress)
      end if
      call add_done_work(1, progress)
      allocate (motions(net%n), extremes(case%coordinates, 2, net%n))
      !$omp parallel do schedule(dynamic, 1) num_threads(threads)
      do i = 1, net%n
         block
            !> What a chart does not show of a motion.
            real(wp), allocatable :: rests(:, :)

            call motion_at(surface, point_of(net, i), condition_type(), motions(i), &
               extremes(:, :, i), rests)
         end block
      end do
      !$omp end parallel do
      call add_done_work(1, progress)
      if (is_stopped(progress)) result%cut = 'motions were found at '//whole(count(net%head > 0)) &
         //' of '//whole(size(net%head))//' points so far'
      result%empty = net%n == 0
      if (result%empty .and. len(result%cut) > 0) return
      if (net%full) call result%remark('there are more motions than can be stored')
      if (result%empty) then
         call result%fail('no motion of this family was found on any line of the grid')
         return
      end if
      call put_motions(case%study, plane, net, motions, extremes, result)
      call put_plane(plane, result)
      call result%add_note(counted(net%n, 'motion')//' at '//whole(count(net%head > 0))//' of '// &
         whole(size(net%head))//' points, '//whole(count([(motions(i)%verdicts%admissible == yes &
         .and. motions(i)%verdicts%stable == yes, i=1, net%n)]))//' admissible and stable')
   end subroutine run_structure

   !> The point of the surface at a node of a net.
   pure function point_of(net, node) result(point)
      !> The net.
      type(net_type), intent(in) :: net
      !> Number of the node.
      integer, intent(in) :: node
      real(wp) :: point(size(net%unknowns, 1) + 2)

      associate (place => net%lattice(:, node))
         point = [net%unknowns(:, node), net%lines%axes(1)%at(place(1)), &
            net%lines%axes(2)%at(place(2))]
      end associate
   end function point_of

   !> Puts the motions at the nodes of a net into the result, those of least leading multiplier
   !! first.
   subroutine put_motions(study, plane, net, motions, extremes, result)
      !> The group.
      type(values_type), intent(in) :: study
      !> The plane.
      type(plane_type), intent(in) :: plane
      !> The net.
      type(net_type), intent(in) :: net
      !> (nodes) The motions.
      type(structure_motion_type), intent(in) :: motions(:)
      !> (coordinates, 2, nodes) Least and greatest coordinates.
      real(wp), intent(in) :: extremes(:, :, :)
      !> The result.
      type(result_type), intent(inout) :: result
      real(wp), allocatable, dimension(:, :, :, :) :: q_min, q_max, phases, speeds
      real(wp), allocatable :: leading(:, :, :), of_node(:), period(:, :, :), values(:)
      complex(wp), allocatable :: multipliers(:, :, :, :)
      integer, allocatable :: verdicts_of(:, :, :, :), status(:, :, :), found(:, :), slot(:)
      real(wp) :: nan
      integer :: i, impacts, j, m, n, slots

      nan = ieee_value(1.0_wp, ieee_quiet_nan)
      n = size(net%head, 1)
      m = size(net%head, 2)
      impacts = size(plane%motion%gaps)
      allocate (of_node(net%n), slot(net%n))
      do i = 1, net%n
         of_node(i) = abs(motions(i)%verdicts%multipliers(1))
         if (.not. of_node(i) >= 0) of_node(i) = huge(1.0_wp)
      end do
      allocate (found(m, n), source=0)
      do i = 1, net%n
         slot(i) = 1
         j = net%head(net%lattice(1, i), net%lattice(2, i))
         do while (j > 0)
            if (of_node(j) < of_node(i) .or. (j < i .and. .not. of_node(j) > of_node(i))) slot(i) &
               = slot(i) + 1
            j = net%follower(j)
         end do
         associate (at => net%lattice(:, i))
            found(at(2), at(1)) = found(at(2), at(1)) + 1
         end associate
      end do
      slots = maxval(slot)
      associate (modes => size(motions(1)%verdicts%multipliers), k => size(extremes, 1))
         allocate (multipliers(modes, slots, m, n), source=cmplx(nan, nan, wp))
         allocate (q_min(k, slots, m, n), q_max(k, slots, m, n), source=nan)
      end associate
      allocate (phases(impacts, slots, m, n), speeds(impacts, slots, m, n), source=nan)
      allocate (leading(slots, m, n), period(slots, m, n), source=nan)
      allocate (verdicts_of(3, slots, m, n), source=unknown)
      allocate (status(slots, m, n), source=stat%no_motion)
      do i = 1, net%n
         associate (x => net%lattice(1, i), y => net%lattice(2, i), s => slot(i), &
            v => motions(i)%verdicts)
            multipliers(:, s, y, x) = v%multipliers
            leading(s, y, x) = abs(v%multipliers(1))
            period(s, y, x) = period_at(net%surface, point_of(net, i))
            verdicts_of(:, s, y, x) = [v%consistent, v%admissible, v%stable]
            q_min(:, s, y, x) = extremes(:, 1, i)
            q_max(:, s, y, x) = extremes(:, 2, i)
            associate (at => phases_at(net%surface, point_of(net, i)))
               phases(:, s, y, x) = at - two_pi*floor(minval(at)/two_pi)
            end associate
            speeds(:, s, y, x) = motions(i)%speeds
            status(s, y, x) = stat%ok
         end associate
      end do
      call result%open('abscissas', 'x', [n])
      call axis_values(study, 'x', plane%changes(1), net%lines%axes(1)%at, values)
      call result%put('abscissas', 'x', values)
      call set_unit(result, 'abscissas', 'x', study%word('x'))
      call set_unit(result, 'ordinates', 'y', study%word('y'))
      call result%open('ordinates', 'y', [m])
      call axis_values(study, 'y', plane%changes(2), net%lines%axes(2)%at, values)
      call result%put('ordinates', 'y', values)
      call result%open('slots', 'slot', [slots])
      call result%put('slots', 'slot', [(i, i=1, slots)])
      call result%open('motions', 'slot y x', [slots, m, n])
      call result%put('motions', 'consistent', [verdicts_of(1, :, :, :)])
      call result%put('motions', 'admissible', [verdicts_of(2, :, :, :)])
      call result%put('motions', 'stable', [verdicts_of(3, :, :, :)])
      call result%put('motions', 'leading', [leading])
      call result%put('motions', 'multipliers', [multipliers])
      call result%put('motions', 'q_min', [q_min])
      call result%put('motions', 'q_max', [q_max])
      call result%put('motions', 'phases', [phases])
      call result%put('motions', 'speeds', [speeds])
      if (plane%motion%free) call result%put('motions', 'period', [period])
      call result%put('motions', 'status', [status])
      call result%open('points', 'y x', [m, n])
      call result%put('points', 'found', [found])
   end subroutine put_motions

end module vi_chart_study
