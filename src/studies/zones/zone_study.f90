!> The study &zone: where motions of a pattern are stable.
module vi_zone_study
   use vi_common_keys, only: check_window, cycles_key, symmetric_key, window_keys
   use vi_family, only: can_be_symmetric
   use vi_kinds, only: wp
   use vi_orbit, only: most_impacts
   use vi_pattern, only: pattern_type, starred_symbols, starred_pattern
   use vi_zone_request, only: zone_request_type
   use vi_progress, only: is_stopped
   use vi_study, only: a_whole, a_word, case_type, column_type, key_type, result_type, study_type, &
      truths, values_type, wholes, words
   use vi_text, only: counted, exact, whole
   use vi_zone_pieces, only: not_closed, piece_columns, pieces_type, put_pieces, vertex_columns, &
      zone_pieces
   implicit none (type, external)
   private

   public :: declare_zone, list_types

   type(key_type), parameter, public :: lines_key = key_type('lines', a_whole, default='17', &
      low=5.0_wp, high=129.0_wp, &
      meaning='number of lattice lines in each direction; a zone that crosses none can be missed')
   type(key_type), parameter, public :: vertices_key = key_type('max_points', a_whole, &
      default='20000', low=100.0_wp, high=200000.0_wp, &
      meaning='vertices of a loop after which it is left open')

   type(key_type), parameter :: zone_keys(*) = [ &
      key_type('sides', a_word, &
      takes='letters R and L, one for each impact, 2 to 24 of them, each wall &
      &at least once; a star after a symbol for impacts that accumulate and end in rest', &
      meaning='walls of the impacts in order, for example RRL, or RL* with rest on L'), &
      cycles_key, symmetric_key, window_keys, lines_key, &
      key_type('guesses', a_whole, default='12', low=0.0_wp, high=1.0e5_wp, &
      meaning='guesses for motions at every second node each way, a quarter of them at &
      &others; 0: seeds alone'), &
      vertices_key, &
      key_type('seeds', most=100000, may_miss=.true., &
      takes='for each motion r, clearance, then x/D and load phase of all its impacts; with rest &
      &load phase and velocity over D of the last release, then zeros', &
      meaning='motions that are known to exist and that the search could miss')]

   type(column_type), parameter :: zone_columns(*) = [piece_columns, &
      column_type('pieces', 'symmetric', truths, &
      meaning='whether the motions are their own mirror images'), vertex_columns, &
      column_type('open_seeds', 'r', listed=.false., &
      meaning='frequency ratio of a seed around which no boundary could be closed'), &
      column_type('open_seeds', 'clearance', unit='F0/K', listed=.false., &
      meaning='clearance of a seed around which no boundary could be closed')]

contains

   !> Declares the study.
   subroutine declare_zone(study)
      !> The declaration of the study.
      type(study_type), intent(out) :: study

      study%name = 'zone'
      study%meaning = 'find where the motions of a pattern are stable'
      study%list => list_zone
      study%row = 'vertices'
      study%check => check_zone
      study%memory => zone_memory
      study%run => run_zone
   end subroutine declare_zone

   !> Lists the keys and columns.
   pure subroutine list_zone(keys, columns)
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) keys = zone_keys
      if (present(columns)) columns = zone_columns
   end subroutine list_zone

   !> Checks the rules that involve several keys.
   subroutine check_zone(case)
      !> The case.
      type(case_type), intent(inout) :: case
      type(pattern_type) :: pattern
      integer :: n

      if (len(case%study%fault) > 0) return
      pattern = zone_pattern(case%study)
      n = size(pattern%sides)
      if (n < 2 .or. n > most_impacts .or. any(pattern%sides == 0) .or. all(pattern%sides > 0) &
         .or. all(pattern%sides < 0)) then
         call case%study%refuse('sides')
      else if (case%study%is('symmetric', 'yes') .and. .not. can_be_symmetric(pattern, &
         case%osc%restitution)) then
         call case%study%refuse('symmetric', '''yes'' needs equal restitution, an odd number of &
            &cycles and sides whose second half mirrors the first')
      else if (any(abs(pattern%sides) == 2) .and. .not. case%study%is('symmetric', 'both')) then
         call case%study%refuse('symmetric', 'and ''both'' for a pattern with rest, whose motions &
            &are not distinguished')
      else if (modulo(seed_numbers(case%study), 2 + 2*n) > 0) then
         call case%study%refuse('seeds', whole(2 + 2*n)//' numbers each')
      else
         call case%study%set_word('sides', starred_symbols(pattern%sides))
         call check_window(case)
      end if
   end subroutine check_zone

   !> The pattern of a zone.
   pure function zone_pattern(study) result(pattern)
      !> The group.
      type(values_type), intent(in) :: study
      type(pattern_type) :: pattern
      character(:), allocatable :: symbols

      call study%text('sides', symbols)
      pattern = starred_pattern(symbols, study%whole_number('cycles'))
   end function zone_pattern

   !> The request for the search.
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

   !> Bytes for the vertices of a loop that max_points allows, in the search and in the result.
   pure real(wp) function zone_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case
      type(pattern_type) :: pattern

      pattern = zone_pattern(case%study)
      bytes = case%study%whole_number('max_points')*(1600 + 300.0_wp*size(pattern%sides))
   end function zone_memory

   !> Finds the zones of a pattern in a window.
   subroutine run_zone(case, threads, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(pieces_type) :: found
      character(:), allocatable :: what, types

      associate (not_used => threads)    ! a boundary is followed from point to point
      end associate
      call case%study%text('sides', what)
      what = what//'/'//whole(case%study%whole_number('cycles'))
      call zone_pieces(zone_request(case), seeds_of(case), .not. [case%study%is('symmetric', &
         'no'), &
         case%study%is('symmetric', 'yes')], found, progress)
      if (is_stopped(progress)) then
         result%cut = 'it was stopped before all boundaries were followed'
         result%empty = .true.
         return
      end if
      call result%open('families', 'family', [1])
      call put_pieces([found], result)
      if (.not. found%closed) call result%remark(not_closed//' (its loop is 0)')
      call put_open_seeds(case, found%open_seeds, result)
      call remark_unused_seeds(case, found%used_seeds, result)
      result%empty = found%motions == 0 .or. (found%n == 0 .and. found%closed)
      if (found%motions == 0) then
         call result%fail('no motion '//what//' was found anywhere in the window')
      else if (result%empty) then
         call result%fail('no zone: motions '//what// &
            ' were found in the window, but none that is both stable and admissible')
      end if
      if (result%empty) return
      call list_types(found, types)
      call result%add_note(what//', '//counted(found%loops, 'loop')//' in '//counted(found%n, &
         'piece')//types)
      if (.not. found%closed) call result%fail(not_closed)
   end subroutine run_zone

   !> How many numbers are given as seeds.
   pure integer function seed_numbers(study) result(n)
      !> The group.
      type(values_type), intent(in) :: study

      n = 0
      if (study%has('seeds')) n = size(study%numbers('seeds'))
   end function seed_numbers

   !> The seeds: r, D, x_i/D, theta_i of each.
   pure function seeds_of(case) result(seeds)
      !> The case, checked.
      type(case_type), intent(in) :: case
      real(wp), allocatable :: seeds(:, :)
      type(pattern_type) :: pattern
      integer :: n

      pattern = zone_pattern(case%study)
      n = 2 + 2*size(pattern%sides)
      allocate (seeds(n, 0))
      if (case%study%has('seeds')) then
         associate (list => case%study%numbers('seeds'))
            seeds = reshape(list, [n, size(list)/n])
         end associate
      end if
   end function seeds_of

   !> Puts the seeds that no closed boundary encloses into the result, with a remark.
   pure subroutine put_open_seeds(case, is_open, result)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Whether each seed is in no closed loop.
      logical, intent(in) :: is_open(:)
      !> The result.
      type(result_type), intent(inout) :: result
      real(wp), allocatable :: seeds(:, :)
      integer :: i

      allocate (seeds, source=seeds_of(case))
      do i = 1, size(is_open)
         if (is_open(i)) call result%remark('no boundary closes around the seed at r = '// &
            exact(seeds(1, i))//', clearance = '//exact(seeds(2, i)))
      end do
      call result%open('open_seeds', 'seed', [count(is_open)])
      call result%put('open_seeds', 'r', pack(seeds(1, :), is_open))
      call result%put('open_seeds', 'clearance', pack(seeds(2, :), is_open))
   end subroutine put_open_seeds

   !> Reports which seeds are not motions of the pattern, or lie outside the window.
   pure subroutine remark_unused_seeds(case, is_used, result)
      !> The case.
      type(case_type), intent(in) :: case
      !> (seeds) Whether each was used.
      logical, intent(in) :: is_used(:)
      !> The result.
      type(result_type), intent(inout) :: result
      real(wp), allocatable :: seeds(:, :)
      integer :: i

      allocate (seeds, source=seeds_of(case))
      do i = 1, size(is_used)
         if (is_used(i)) cycle
         call result%remark('the seed at r = '//exact(seeds(1, i))//', clearance = '// &
            exact(seeds(2, i))//' was not used: it is no motion of this pattern inside the window, &
            &or one that repeats a shorter one')
      end do
      if (.not. all(is_used)) call result%add_note(whole(count(.not. is_used))//' of '//counted( &
         size(is_used), 'seed')//' not used: no motion of this pattern inside the window, or one &
         &that repeats a shorter one')
   end subroutine remark_unused_seeds

   !> The types of the pieces, each once.
   pure subroutine list_types(found, text)
      !> The pieces.
      type(pieces_type), intent(in) :: found
      !> A colon and their types, separated by commas; empty without pieces.
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
