!> The study &chart: the motions of a pattern on a grid.
module vi_chart_study
   use vi_case, only: case_type
   use vi_common_keys, only: cycles_key, symmetric_key, window_keys
   use vi_key, only: a_whole, a_word, key_type
   use vi_kinds, only: wp
   use vi_likeness, only: allows_symmetry
   use vi_pattern, only: new_pattern, pattern_type, side_letters
   use vi_text, only: whole
   use vi_values, only: values_type
   use vi_window, only: most_numbers, most_points, window_type
   implicit none (type, external)
   private

   public :: chart_pattern, chart_window_of, check_chart

   integer, parameter :: most_impacts = 12
   character(*), parameter :: many = &
      'a whole number of at least 2, with r_points x clearance_points <= 1000000'

   type(key_type), parameter, public :: chart_keys(*) = [ &
      key_type('sides', a_word, &
      takes='letters R and L, one an impact, 2 to 12 of them, each wall at least once', &
      meaning='the walls in the order of impacts'), &
      cycles_key, window_keys(1:2), &
      key_type('r_points', a_whole, low=2.0_wp, high=1.0e6_wp, takes=many, &
      meaning='frequency ratios'), &
      window_keys(3:4), &
      key_type('clearance_points', a_whole, low=2.0_wp, high=1.0e6_wp, takes=many, &
      meaning='clearances'), &
      key_type('spacing', a_word, default='''linear''', words='linear geometric', &
      takes='''linear'' or ''geometric'' (of the clearances)', meaning='of the clearances'), &
      symmetric_key, &
      key_type('room', a_whole, default='4', low=1.0_wp, high=32.0_wp, &
      meaning='slots for motions that have no closed form'), &
      key_type('guesses', a_whole, default='32', low=1.0_wp, high=1.0e4_wp, &
      meaning='guesses of a search'), &
      key_type('seeds', a_whole, default='12', low=1.0_wp, high=1.0e4_wp, &
      meaning='searches along each axis')]

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

end module vi_chart_study
