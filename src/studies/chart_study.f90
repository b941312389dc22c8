!> The study &chart: the motions of a pattern on a grid.
module vi_chart_study
   use vi_case, only: case_type
   use vi_common_keys, only: cycles_key, symmetric_key, window_keys
   use vi_key, only: a_whole, a_word, key_type
   use vi_kinds, only: wp
   use vi_likeness, only: allows_symmetry
   use vi_pattern, only: new_pattern, pattern_type, side_letters
   use vi_motion, only: yes
   use vi_result, only: column_type, result_type, verdicts, wholes
   use vi_status, only: stat
   use vi_text, only: whole
   use vi_values, only: values_type
   use vi_window, only: chart_window, clearance_axis, map_type, most_numbers, most_points, r_axis, &
      window_type
   implicit none (type, external)
   private

   public :: check_chart, run_chart

   integer, parameter :: most_impacts = 12
   character(*), parameter :: many = &
      'a whole number of at least 2, with r_points x clearance_points <= 1000000'

   type(key_type), parameter, public :: chart_keys(*) = [ &
      key_type('sides', a_word, &
      takes='letters R and L, one an impact, 2 to 12 of them, each wall at least once', &
      meaning='walls of the impacts in order, as RRL'), &
      cycles_key, window_keys(1:2), &
      key_type('r_points', a_whole, low=2.0_wp, high=1.0e6_wp, takes=many, option='r', &
      meaning='number of frequency ratios'), &
      window_keys(3:4), &
      key_type('clearance_points', a_whole, low=2.0_wp, high=1.0e6_wp, takes=many, &
      option='clearance', meaning='number of clearances'), &
      key_type('spacing', a_word, default='''linear''', words='linear geometric', &
      takes='''linear'' or ''geometric'' (of the clearances)', &
      meaning='spacing of the clearances'), &
      symmetric_key, &
      key_type('room', a_whole, default='4', low=1.0_wp, high=32.0_wp, &
      meaning='slots for motions that have no closed form'), &
      key_type('guesses', a_whole, default='32', low=1.0_wp, high=1.0e4_wp, &
      meaning='guesses of a search'), &
      key_type('seeds', a_whole, default='12', low=1.0_wp, high=1.0e4_wp, &
      meaning='searches along each axis')]

   type(column_type), parameter, public :: chart_columns(*) = [ &
      column_type('ratios', 'r', meaning='frequency ratio'), &
      column_type('clearances', 'clearance', unit='F0/K', meaning='clearance d K/F0'), &
      column_type('slots', 'slot', wholes, meaning='number of the motion at its point'), &
      column_type('motions', 'consistent', verdicts, meaning='whether it solves all equations'), &
      column_type('motions', 'admissible', verdicts, &
      meaning='whether it stays between the walls'), &
      column_type('motions', 'stable', verdicts, meaning='whether disturbances decay'), &
      column_type('motions', 'leading', label='multiplier_1_modulus', &
      meaning='greatest modulus of the multipliers'), &
      column_type('motions', 'x_max', unit='F0/K', &
      meaning='greatest displacement of the primary mass'), &
      column_type('motions', 'status', wholes, absent=stat%no_motion, &
      meaning='code of what failed; 0: none')]

contains

   !> Checks what depends on several keys.
   subroutine check_chart(case)
      !> The case.
      type(case_type), intent(inout) :: case
      type(pattern_type) :: pattern
      type(window_type) :: window
      real(wp) :: points
      integer :: n

      if (len(case%study%fault) > 0) return
      pattern = chart_pattern(case%study)
      window = chart_window_of(case%study)
      n = size(pattern%sides)
      points = real(window%r_points, wp)*window%clearance_points
      if (n < 2 .or. n > most_impacts .or. any(pattern%sides == 0) .or. abs(sum(pattern%sides)) &
         == n) then
         call case%study%refuse('sides')
      else if (points > most_points) then
         call case%study%refuse('clearance_points', 'r_points is '//whole(window%r_points))
      else if (window%symmetry > 0 .and. .not. allows_symmetry(case%osc, pattern)) then
         call case%study%refuse('symmetric', '''yes'' takes equal restitution, an odd number of &
            &cycles and sides whose second half mirrors the first')
      else if (.not. (window%symmetry > 0 .and. n == 2) .and. points*max(window%room, 4)*n > &
         most_numbers) then
         call case%study%refuse('r_points', 'points x room x impacts must be at most '// &
            whole(most_numbers))
      else
         call case%study%set_word('sides', side_letters(pattern%sides))
      end if
   end subroutine check_chart

   !> The pattern of a chart.
   pure function chart_pattern(study) result(pattern)
      !> The group.
      type(values_type), intent(in) :: study
      type(pattern_type) :: pattern
      character(:), allocatable :: letters

      call study%text('sides', letters)
      pattern = new_pattern(letters, study%whole_number('cycles'))
   end function chart_pattern

   !> The grid, and how it is searched.
   pure function chart_window_of(study) result(window)
      !> The group.
      type(values_type), intent(in) :: study
      type(window_type) :: window

      window = window_type(study%number('r_min'), study%number('r_max'), &
         study%number('clearance_min'), study%number('clearance_max'), &
         study%whole_number('r_points'), study%whole_number('clearance_points'), &
         study%is('spacing', 'geometric'), 0, study%whole_number('room'), &
         study%whole_number('guesses'), study%whole_number('seeds'))
      if (study%is('symmetric', 'yes')) window%symmetry = 1
      if (study%is('symmetric', 'no')) window%symmetry = -1
   end function chart_window_of

   !> Finds the motions of a pattern on a grid.
   subroutine run_chart(case, result, tally)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> The result, started.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_tally.
      integer, intent(inout), optional :: tally(3)
      type(map_type) :: map
      type(pattern_type) :: pattern
      type(window_type) :: window
      character(:), allocatable :: what
      integer :: i, slots, m, n

      pattern = chart_pattern(case%study)
      window = chart_window_of(case%study)
      call chart_window(case%osc, pattern, window, map, tally)
      what = side_letters(pattern%sides)//'/'//whole(pattern%cycles)
      slots = size(map%status, 1)
      m = size(map%status, 2)
      n = size(map%status, 3)
      call result%open('ratios', 'r', [n])
      call result%put('ratios', 'r', r_axis(window))
      call result%open('clearances', 'clearance', [m])
      call result%put('clearances', 'clearance', clearance_axis(window))
      call result%open('slots', 'slot', [slots])
      call result%put('slots', 'slot', [(i, i=1, slots)])
      call result%open('motions', 'slot clearance r', [slots, m, n])
      call result%put('motions', 'consistent', [map%verdicts(1, :, :, :)])
      call result%put('motions', 'admissible', [map%verdicts(2, :, :, :)])
      call result%put('motions', 'stable', [map%verdicts(3, :, :, :)])
      call result%put('motions', 'leading', [map%leading])
      call result%put('motions', 'x_max', [map%x_max])
      call result%put('motions', 'status', [map%status])
      result%empty = all(map%status /= stat%ok)
      if (result%empty) then
         call result%fail('no motion '//what//' was found anywhere in the window')
      else
         call result%say(whole(count(map%status == stat%ok))//' motions '//what//' at '//whole( &
            count(any(map%status == stat%ok, 1)))//' of '//whole(m*n)//' points, '//whole(count( &
            all(map%verdicts == yes, 1)))//' admissible and stable')
      end if
   end subroutine run_chart

end module vi_chart_study
