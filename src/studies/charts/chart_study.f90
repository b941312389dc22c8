!> The study &chart: the motions of a pattern on a grid.
module vi_chart_study
   use vi_common_keys, only: most_numbers, cycles_key, symmetric_key, window_keys
   use vi_family, only: can_be_symmetric
   use vi_kinds, only: wp
   use vi_pattern, only: new_pattern, pattern_type, side_symbols
   use vi_motion, only: yes
   use vi_spacing, only: even, spaced
   use vi_status, only: stat
   use vi_text, only: whole
   use vi_chart_grid, only: compute_chart, chart_type, most_points, chart_grid_type
   use vi_study, only: a_whole, a_word, case_type, column_type, complexes, key_type, &
      of_oscillator, result_type, study_type, values_type, verdicts, wholes
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
      may_miss=.true., option='r-list', takes='increasing numbers with 1e-6 <= r <= 1e6', &
      meaning='the frequency ratios, if they are not evenly spaced'), &
      key_type('r_min', low=window_keys(1)%low, high=window_keys(1)%high, never='r', &
      option='r', meaning='first frequency ratio'), &
      key_type('r_max', low=window_keys(2)%low, high=window_keys(2)%high, over='r_min', never='r', &
      option='r', meaning='last frequency ratio'), &
      key_type('r_points', a_whole, low=2.0_wp, high=1.0e6_wp, takes=many, never='r', &
      option='r', meaning='number of frequency ratios'), &
      key_type('clearance', most=most_points, low=window_keys(3)%low, high=window_keys(3)%high, &
      may_miss=.true., option='clearance-list', unit='F0/K', &
      takes='increasing numbers with 1e-12 <= clearance <= 1e12', &
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
      meaning='slots for motions that have no closed form'), &
      key_type('guesses', a_whole, default='32', low=1.0_wp, high=1.0e4_wp, &
      meaning='guesses of a search'), &
      key_type('seeds', a_whole, default='12', low=1.0_wp, high=1.0e4_wp, &
      meaning='searches along each axis'), &
      key_type('multipliers', a_word, words='yes no', may_miss=.true., &
      meaning='''no'' leaves out those of equispaced motions, which take most of the time')]

   type(column_type), parameter :: chart_columns(*) = [ &
      column_type('ratios', 'r', meaning='frequency ratio'), &
      column_type('clearances', 'clearance', unit='F0/K', &
      meaning='clearance d K/F0; d is the whole travel of m between the walls'), &
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
      meaning='least displacement of the primary mass'), &
      column_type('motions', 'x_max', unit='F0/K', &
      meaning='greatest displacement of the primary mass'), &
      column_type('motions', 'tau', unit='rad', listed=.false., meaning='phase of equation (4)'), &
      column_type('motions', 'phases', each='impact', unit='rad', listed=.false., &
      meaning='load phases of the impacts, from the first one'), &
      column_type('motions', 'X', each='impact', unit='F0/K', listed=.false., &
      meaning='displacements of the primary mass at the impacts'), &
      column_type('motions', 'status', wholes, absent=[stat%no_motion, stat%not_computed], &
      meaning='code of what failed; 0: none'), &
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

      if (present(keys)) keys = chart_keys
      if (present(columns)) columns = chart_columns
      if (.not. present(study)) return
      study%name = 'chart'
      study%models = of_oscillator
      study%meaning = 'compute all motions of a pattern on a grid of r and d K/F0'
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
      pattern = chart_pattern(case%study)
      n = size(pattern%sides)
      if (n < 2 .or. n > most_impacts .or. any(pattern%sides == 0) .or. abs(sum(pattern%sides)) &
         == n) then
         call case%study%refuse('sides')
         return
      end if
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
         call case%study%refuse('symmetric', '''yes'' takes equal restitution, an odd number of &
            &cycles and sides whose second half mirrors the first')
      else if (.not. (grid%symmetry > 0 .and. n == 2) .and. points*max(grid%slots, 4)*n > &
         most_numbers) then
         call case%study%refuse(points_key(case%study, 'r'), 'points x slots x impacts must be at &
            &most '//whole(most_numbers))
      else
         call case%study%set_word('sides', side_symbols(pattern%sides))
      end if
   end subroutine check_chart

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
         if (study%has(name)) call study%refuse(name, 'number '//whole(i)//' is not above number ' &
            //whole(i - 1))
         if (.not. study%has(name)) call study%refuse(name//'_max', 'so many between do not differ')
         return
      end do
   end subroutine check_axis

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

end module vi_chart_study
