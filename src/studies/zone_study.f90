!> The study &zone: where motions of a pattern are stable.
module vi_zone_study
   use vi_case, only: case_type
   use vi_common_keys, only: check_window, cycles_key, symmetric_key, window_keys
   use vi_family, only: can_be_symmetric
   use vi_key, only: a_whole, a_word, key_type
   use vi_kinds, only: wp
   use vi_orbit, only: most_impacts
   use vi_pattern, only: pattern_type, starred_letters, starred_pattern
   use vi_result, only: column_type, result_type, truths, wholes, words
   use vi_sheet, only: zone_request_type
   use vi_text, only: counted, whole
   use vi_values, only: values_type
   use vi_zone_pieces, only: not_closed, pieces_type, put_pieces, zone_pieces
   implicit none (type, external)
   private

   public :: check_zone, run_zone

   type(key_type), parameter, public :: lines_key = key_type('lines', a_whole, default='17', &
      low=5.0_wp, high=129.0_wp, meaning='lattice lines each way; what touches none can be missed')
   type(key_type), parameter, public :: vertices_key = key_type('max_points', a_whole, &
      default='20000', low=100.0_wp, high=200000.0_wp, &
      meaning='vertices of a loop, after which it is left open')

   type(key_type), parameter, public :: zone_keys(*) = [ &
      key_type('sides', a_word, takes='letters R and L, one an impact, 2 to 24 of them, each wall &
      &at least once; a star after a letter for impacts that accumulate and end in rest', &
      meaning='the walls in the order of impacts'), &
      cycles_key, symmetric_key, window_keys, lines_key, &
      key_type('guesses', a_whole, default='12', low=0.0_wp, high=1.0e5_wp, &
      meaning='guesses for motions at every second node each way, a quarter of them at others'), &
      vertices_key]

   type(column_type), parameter, public :: zone_columns(*) = [ &
      column_type('pieces', 'loop', wholes, &
      meaning='number of the closed boundary; 0 if it could not be closed'), &
      column_type('pieces', 'piece', wholes, meaning='number of the piece of the boundary'), &
      column_type('pieces', 'type', words, meaning='condition that is zero along it'), &
      column_type('pieces', 'detail', words, meaning='which impact, flight or bound'), &
      column_type('pieces', 'symmetric', truths, &
      meaning='whether the motions are their own mirror images'), &
      column_type('vertices', 'r', meaning='frequency ratio'), &
      column_type('vertices', 'clearance', unit='F0/K', meaning='clearance d K/F0'), &
      column_type('vertices', 'corner', truths, meaning='whether pieces meet there')]

contains

   !> Checks what depends on several keys.
   subroutine check_zone(case)
      !> The case.
      type(case_type), intent(inout) :: case
      type(pattern_type) :: pattern
      integer :: n

      if (len(case%study%fault) > 0) return
      pattern = zone_pattern(case%study)
      n = size(pattern%sides)
      if (n < 2 .or. n > most_impacts .or. any(pattern%sides == 0) .or. all(pattern%sides > 0) &
         .or. &
         all(pattern%sides < 0)) then
         call case%study%refuse('sides')
      else if (case%study%is('symmetric', 'yes') .and. .not. can_be_symmetric(pattern, &
         case%osc%restitution)) then
         call case%study%refuse('symmetric', '''yes'' needs equal restitution, an odd number of &
            &cycles and sides whose second half mirrors the first')
      else
         call case%study%set_word('sides', starred_letters(pattern%sides))
         call check_window(case)
      end if
   end subroutine check_zone

   !> The pattern of a zone.
   pure function zone_pattern(study) result(pattern)
      !> The group.
      type(values_type), intent(in) :: study
      type(pattern_type) :: pattern
      character(:), allocatable :: letters

      call study%text('sides', letters)
      pattern = starred_pattern(letters, study%whole_number('cycles'))
   end function zone_pattern

   !> What is asked of the search.
   pure function zone_request(case) result(request)
      !> The case, checked.
      type(case_type), intent(in) :: case
      type(zone_request_type) :: request

      associate (s => case%study)
         request = zone_request_type(case%osc, zone_pattern(s), .false., [s%number('r_min'), &
            s%number('r_max')], [s%number('clearance_min'), s%number('clearance_max')], &
            s%whole_number('lines'), s%whole_number('guesses'), s%whole_number('max_points'))
      end associate
   end function zone_request

   !> Finds the zones of a pattern in a window.
   subroutine run_zone(case, result, tally)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Started.
      type(result_type), intent(inout) :: result
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      type(pieces_type) :: found
      character(:), allocatable :: what, types

      call case%study%text('sides', what)
      what = what//'/'//whole(case%study%whole_number('cycles'))
      call zone_pieces(zone_request(case), .not. [case%study%is('symmetric', 'no'), &
         case%study%is('symmetric', 'yes')], found, tally)
      result%empty = found%motions == 0 .or. (found%n == 0 .and. found%closed)
      if (found%motions == 0) then
         call result%fail('no motion '//what//' was found anywhere in the window')
      else if (result%empty) then
         call result%fail('no zone: motions '//what// &
            ' were found in the window, but none that is both stable and admissible')
      end if
      if (result%empty) return
      call put_pieces([found], result)
      call list_types(found, types)
      call result%say(what//', '//counted(found%loops, 'loop')//' in '//counted(found%n, &
         'piece')//types)
      if (found%closed) return
      call result%remark(not_closed//' (its loop is 0)')
      call result%fail(not_closed)
   end subroutine run_zone

   !> The types of the pieces, each once.
   pure subroutine list_types(found, text)
      type(pieces_type), intent(in) :: found
      character(:), allocatable, intent(out) :: text
      integer :: i

      text = ''
      do i = 1, found%n
         associate (name => found%pieces(i)%name)
            if (index(text//',', ' '//name//',') > 0) cycle
            text = text//trim(merge(':', ',', len(text) == 0))//' '//name
         end associate
      end do
   end subroutine list_types

end module vi_zone_study
