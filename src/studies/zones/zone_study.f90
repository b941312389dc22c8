!> The study &zone: where motions of a pattern are stable.
module vi_zone_study
   use vi_common_keys, only: check_window, cycles_key, symmetric_key, window_keys
   use vi_branch_study, only: check_structure_start, touch_detail
   use vi_curve_point, only: curve_type
   use vi_family, only: can_be_symmetric
   use vi_kinds, only: pi, wp
   use vi_linear, only: most
   use vi_motion_family, only: fold, is_exchange
   use vi_motion_study, only: find_structure_motion
   use vi_orbit, only: most_impacts
   use vi_pattern, only: pattern_type, starred_pattern, starred_symbols
   use vi_progress, only: add_expected_work, is_stopped
   use vi_status, only: stat, status_text
   use vi_structure, only: check_structure, load_type, structure_type
   use vi_structure_groups, only: load_frequency, structure_of
   use vi_structure_parameter, only: check_parameter, parameter_change, x_function_keys, &
      y_function_keys
   use vi_structure_path, only: change_type, parameter_takes, value_at
   use vi_structure_return, only: settled_type
   use vi_structure_run, only: run_event_type
   use vi_structure_start, only: start_curve
   use vi_structure_tables, only: path_columns, put_path, put_structure, set_unit, &
      structure_columns
   use vi_study, only: a_whole, a_word, case_type, column_type, every_model, key_type, list_for, &
      of_oscillator, of_structure, result_type, study_type, truths, values_type, wholes, words
   use vi_text, only: counted, exact, whole
   use vi_zone, only: zone_around, zone_type, zone_work
   use vi_zone_pieces, only: add_pieces, corner_column, family_columns, not_closed, piece_columns, &
      pieces_type, place_columns, put_pieces, vertex_columns, zone_pieces
   use vi_zone_request, only: zone_request_type
   implicit none (type, external)
   private

   public :: check_plane, declare_zone, gaps_followed, in_parameters, put_plane, start_surface

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
      cycles_key, symmetric_key, window_keys]
   type(key_type), parameter :: guesses_key = key_type('guesses', a_whole, default='12', &
      low=0.0_wp, high=1.0e5_wp, meaning='guesses at every second node in each direction, a &
      &quarter as many at others; 0: only seeds')
   type(key_type), parameter :: seeds_key = key_type('seeds', most=100000, may_miss=.true., &
      takes='for each motion r, clearance, then x/D and load phase of all its impacts; with rest &
      &load phase and velocity over D of the last release, then zeros', &
      meaning='motions that are known to exist and that the search could miss')

   type(column_type), parameter :: symmetric_column = column_type('pieces', 'symmetric', truths, &
      meaning='whether the motions are their own mirror images')
   type(column_type), parameter :: seed_columns(*) = [ &
      column_type('open_seeds', 'r', listed=.false., &
      meaning='frequency ratio of a seed around which no boundary could be closed'), &
      column_type('open_seeds', 'clearance', unit='F0/K', listed=.false., &
      meaning='clearance of a seed around which no boundary could be closed')]

   !> The plane of two parameters of a structure.
   type(key_type), parameter, public :: plane_keys(*) = [ &
      key_type('x', a_word, takes=parameter_takes, meaning='parameter of the abscissa'), &
      key_type('x_low', takes='a number, at most the given value of the parameter', option='x', &
      meaning='lower bound of x'), &
      key_type('x_high', takes='a number above x_low, at least the given value of the parameter', &
      option='x', meaning='upper bound of x'), &
      key_type('y', a_word, takes=parameter_takes, meaning='parameter of the ordinate'), &
      key_type('y_low', takes='a number, at most the given value of the parameter', option='y', &
      meaning='lower bound of y'), &
      key_type('y_high', takes='a number above y_low, at least the given value of the parameter', &
      option='y', meaning='upper bound of y')]

   type(column_type), parameter, public :: structure_place_columns(*) = [ &
      column_type('pieces', 'symmetric', truths, listed=.false., &
      meaning='whether the motions are their own images half a period later'), &
      column_type('vertices', 'x', meaning='parameter of the abscissa'), &
      column_type('vertices', 'y', meaning='parameter of the ordinate')]

   type(column_type), parameter, public :: structure_vertex_columns(*) = [ &
      column_type('vertices', 'speeds', unit='omega F0/K', each='impact', label='speed_#', &
      meaning='approach speeds of the impacts'), &
      column_type('vertices', 'phases', each='impact', label='phase_#', unit='rad', &
      meaning='load phases of the impacts'), &
      column_type('vertices', 'period', unit='1/omega', listed=.false., &
      meaning='period of a self-excited motion'), &
      column_type('rings', 'x', listed=.false., &
      meaning='abscissa along a closed loop, counter-clockwise around a zone'), &
      column_type('rings', 'y', listed=.false., meaning='ordinate along a closed loop')]

   !> The columns of the vertices of the pieces of a structure.
   character(*), parameter, public :: vertex_names(4) = ['x     ', 'y     ', 'speeds', 'phases']

   !> The columns of the motion at the start, and of the structure there.
   type(column_type), parameter, public :: plane_columns(*) = [ &
      column_type('motion', 'gaps', wholes, each='impact', listed=.false., &
      meaning='gaps of the impacts, from 0'), &
      column_type('motion', 'resting', wholes, each='rest', listed=.false., &
      meaning='gaps that rest, from 0'), &
      column_type('motion', 'cycles', wholes, listed=.false., meaning='load cycles in a period'), &
      column_type('motion', 'frequency', unit='omega', listed=.false., &
      meaning='circular frequency of the load at the start'), path_columns, structure_columns]

   !> A motion of a structure, and two parameters that change.
   type, public :: plane_type
      type(structure_type) :: structure
      type(load_type) :: load
      type(settled_type) :: motion
      type(change_type) :: changes(2)
      !> Whether the motion has stops or friction, and is its own mirror image half a period later:
      !! the pitchforks of such motions are not distinguished from folds.
      logical :: is_mirrored = .false.
   end type plane_type

contains

   !> Declares the study, with its keys and columns.
   pure subroutine declare_zone(study, keys, columns)
      !> The study.
      type(study_type), intent(out), optional :: study
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) then
         call list_for(of_oscillator, zone_keys, keys)
         call list_for(of_structure, plane_keys, keys)
         call list_for(every_model, [lines_key], keys)
         call list_for(of_oscillator, [guesses_key], keys)
         call list_for(every_model, [vertices_key], keys)
         call list_for(of_oscillator, [seeds_key], keys)
         call list_for(of_structure, x_function_keys, keys)
         call list_for(of_structure, y_function_keys, keys)
      end if
      if (present(columns)) then
         call list_for(every_model, piece_columns, columns)
         call list_for(of_oscillator, [symmetric_column], columns)
         call list_for(of_oscillator, place_columns, columns)
         call list_for(of_structure, structure_place_columns, columns)
         call list_for(every_model, [corner_column], columns)
         call list_for(of_oscillator, vertex_columns, columns)
         call list_for(of_oscillator, seed_columns, columns)
         call list_for(of_structure, structure_vertex_columns, columns)
         call list_for(of_structure, plane_columns, columns)
         call list_for(every_model, family_columns, columns)
      end if
      if (.not. present(study)) return
      study%name = 'zone'
      study%meaning = 'find where the motions of a pattern are stable'
      study%starts_from(of_structure) = 'motion'
      study%takes_elements = .true.
      study%takes_walls = .true.
      study%check_start => check_structure_start
      study%row = 'vertices'
      study%check => check_zone
      study%memory => zone_memory
      study%run => run_zone
   end subroutine declare_zone

   !> Checks the rules that involve several keys.
   subroutine check_zone(case)
      !> The case.
      type(case_type), intent(inout) :: case
      type(pattern_type) :: pattern
      integer :: n

      if (len(case%study%fault) > 0) return
      if (case%model == of_structure) then
         call check_plane(case)
         return
      end if
      pattern = zone_pattern(case%study)
      n = size(pattern%sides)
      if (n < 2 .or. n > most_impacts .or. any(pattern%sides == 0) .or. all(pattern%sides > 0) &
         .or. all(pattern%sides < 0)) then
         call case%study%refuse('sides')
      else if (case%study%is('symmetric', 'yes') .and. .not. can_be_symmetric(pattern, &
         case%osc%restitution)) then
         call case%study%refuse('symmetric', '''yes'' requires equal restitution, an odd number of &
            &cycles and sides whose second half mirrors the first')
      else if (any(abs(pattern%sides) == 2) .and. .not. case%study%is('symmetric', 'both')) then
         call case%study%refuse('symmetric', 'it must be ''both'' for a pattern with rest, whose &
            &motions are not distinguished by symmetry')
      else if (modulo(seed_numbers(case%study), 2 + 2*n) > 0) then
         call case%study%refuse('seeds', whole(2 + 2*n)//' numbers for each motion')
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
      integer :: impacts

      impacts = most
      if (case%model /= of_structure) then
         pattern = zone_pattern(case%study)
         impacts = size(pattern%sides)
      end if
      bytes = case%study%whole_number('max_points')*(1600 + 300.0_wp*impacts)
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
      character(:), allocatable :: none, what

      associate (not_used => threads)    ! a boundary is followed from point to point
      end associate
      if (case%model == of_structure) then
         call run_structure(case, result, progress)
         return
      end if
      call case%study%text('sides', what)
      what = what//'/'//whole(case%study%whole_number('cycles'))
      call zone_pieces(zone_request(case), seeds_of(case), .not. [case%study%is('symmetric', &
         'no'), &
         case%study%is('symmetric', 'yes')], found, progress)
      if (is_stopped(progress)) then
         result%cut = 'the computation was stopped before all boundaries were followed'
         result%empty = .true.
         return
      end if
      call result%open('families', 'family', [1])
      call put_pieces([found], result)
      if (.not. found%closed) call result%remark(not_closed//' (its loop is 0)')
      call put_open_seeds(case, found%open_seeds, result)
      call remark_unused_seeds(case, found%used_seeds, result)
      none = 'no zone: motions '//what//' were found in the window, but none that is both stable &
         &and admissible'
      if (found%motions == 0) none = 'no motion '//what//' was found anywhere in the window'
      result%empty = found%motions == 0 .or. (found%n == 0 .and. found%closed)
      call tell_pieces(found, what//', ', none, result)
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
            exact(seeds(2, i))//' was not used: it is not a motion of this pattern inside the &
            &window, or it repeats a shorter motion')
      end do
      if (.not. all(is_used)) call result%add_note(whole(count(.not. is_used))//' of '//counted( &
         size(is_used), 'seed')//' not used: not a motion of this pattern inside the window, or &
         &one that repeats a shorter motion')
   end subroutine remark_unused_seeds

   !> Notes how many pieces were found, and their types, each once.
   pure subroutine tell_pieces(found, what, none, result)
      !> The pieces.
      type(pieces_type), intent(in) :: found
      !> The motions that have these zones, followed by a comma; may be empty.
      character(*), intent(in) :: what
      !> The fault if there are none.
      character(*), intent(in) :: none
      !> The result, empty if there are none.
      type(result_type), intent(inout) :: result
      character(:), allocatable :: types
      integer :: i

      if (result%empty) then
         call result%fail(none)
         return
      end if
      types = ''
      do i = 1, found%n
         associate (name => found%pieces(i)%name)
            if (index(types//',', ' '//name//',') > 0) cycle
            types = types//trim(merge(':', ',', len(types) == 0))//' '//name
         end associate
      end do
      call result%add_note(what//counted(found%loops, 'loop')//' in '//counted(found%n, 'piece')// &
         types)
      if (.not. found%closed) call result%fail(not_closed)
   end subroutine tell_pieces

   !> Checks both parameters of a plane.
   subroutine check_plane(case)
      !> The case, with `start`.
      type(case_type), intent(inout) :: case
      type(structure_type) :: structure
      type(load_type) :: load
      type(change_type) :: changes(2)
      type(values_type) :: group
      integer :: i, j, status

      call structure_of(case, structure, load)
      load%frequency = load_frequency(case)
      call check_structure(structure, status)
      group = case%study
      call check_parameter(group, 'x', 'x_', structure, load, changes(1))
      call check_parameter(group, 'y', 'y_', structure, load, changes(2))
      if (len(group%fault) == 0) then
         do i = 1, size(changes(1)%entries, 2)
            do j = 1, size(changes(2)%entries, 2)
               if (all(changes(1)%entries(:, i) == changes(2)%entries(:, j))) call group%refuse( &
                  'y', 'it changes the same parameter as x')
            end do
         end do
      end if
      case%study = group
   end subroutine check_plane

   !> The surface of motions over a plane of two parameters, which is the unit square.
   subroutine start_surface(case, plane, surface, start, mirrored, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> The motion at the start, with its structure.
      type(plane_type), intent(out) :: plane
      !> The surface.
      type(curve_type), intent(out) :: surface
      !> Unknowns and parameters of the motion; not allocated if there is none.
      real(wp), allocatable, intent(out) :: start(:)
      !> As of `start_curve`.
      logical, intent(out) :: mirrored
      !> The result, empty so far; says why there is none.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      character(:), allocatable :: message
      integer :: status

      result%empty = .true.
      mirrored = .false.
      associate (structure => plane%structure, load => plane%load, motion => plane%motion, &
         changes => plane%changes)
         call find_structure_motion(case, case%start, .true., structure, load, motion, status, &
            progress)
         if (status == stat%not_computed) then
            result%cut = 'the computation was stopped before a motion was found'
            return
         end if
         if (status /= stat%ok) then
            call result%fail(status_text(status))
            return
         end if
         plane%is_mirrored = is_own_image(motion, load)
         call parameter_change(case%study, 'x', 'x_', structure, load, changes(1), message)
         call parameter_change(case%study, 'y', 'y_', structure, load, changes(2), message)
         call start_curve(structure, load, motion, changes, surface, start, mirrored, message, &
            plane%is_mirrored)
         if (len(message) == 0) return
      end associate
      if (allocated(start)) deallocate (start)
      call result%fail(message)
   end subroutine start_surface

   !> Whether a motion with stops or friction is -q half a period later.
   pure logical function is_own_image(found, load) result(is)
      !> The motion.
      type(settled_type), intent(in) :: found
      !> Its load.
      type(load_type), intent(in) :: load
      real(wp), parameter :: near = 1.0e-6_wp
      real(wp), allocatable :: apart(:), states(:, :), late(:, :)
      integer :: half, n

      half = size(found%gaps)/2
      is = allocated(found%events) .and. modulo(size(found%gaps), 2) == 0 .and. &
         modulo(found%cycles, 2) == 1 .and. half > 0
      if (.not. is) return
      apart = found%motion%phases(half + 1:) - found%motion%phases(:half) - pi*found%cycles
      states = found%motion%states
      n = size(states, 1)/2
      states(n + 1:, :) = states(n + 1:, :)/load%frequency
      late = cshift(states, half, 2)
      is = all(abs(apart) < near) .and. all(abs(states + late) <= near*maxval(abs(states)))
   end function is_own_image

   !> The gaps of the events of a motion that count as events of their own: what changes at one
   !! instant together is one event.
   pure function gaps_followed(motion) result(gaps)
      !> The motion.
      type(settled_type), intent(in) :: motion
      integer, allocatable :: gaps(:)
      integer :: i

      allocate (gaps, source=motion%gaps)
      ! with rests these are already those of the family
      if (.not. allocated(motion%events) .or. size(motion%resting) > 0) return
      associate (events => motion%events)
         gaps = pack(events%gap, [(size(events) == 1 .or. .not. at_once(events(merge(i - 1, &
            size(events), i > 1)), events(i)), i=1, size(events))])
      end associate
   contains
      !> Whether an event is at the instant of the one before it, and in its regime.
      pure logical function at_once(before, event)
         !> The events.
         type(run_event_type), intent(in) :: before, event

         at_once = before%regime == event%regime .and. before%cycle == event%cycle .and. &
            .not. abs(before%elapsed - event%elapsed) > 0
      end function at_once
   end function gaps_followed

   !> Puts the motion at the start and its structure into the result.
   subroutine put_plane(plane, result)
      !> The motion and its structure.
      type(plane_type), intent(in) :: plane
      !> The result.
      type(result_type), intent(inout) :: result

      call result%open('motion', 'one', [1])
      call result%put('motion', 'gaps', gaps_followed(plane%motion) - 1)
      if (size(plane%motion%resting) > 0) call result%put('motion', 'resting', &
         plane%motion%resting - 1)
      call result%put('motion', 'cycles', [plane%motion%cycles])
      call result%put('motion', 'frequency', [plane%load%frequency])
      call put_path(result, plane%changes)
      call put_structure(result, plane%structure, plane%load)
   end subroutine put_plane

   !> Finds the zone of a motion of a structure.
   subroutine run_structure(case, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(plane_type) :: plane
      type(curve_type) :: surface
      type(zone_request_type) :: request
      type(zone_type) :: zone
      type(pieces_type) :: found, families(1)
      real(wp), allocatable :: start(:)
      logical :: mirrored
      integer :: i

      call add_expected_work(zone_work, progress)
      call start_surface(case, plane, surface, start, mirrored, result, progress)
      if (.not. allocated(start)) return
      ! the window is the unit square; zones have a logarithmic ordinate
      request = zone_request_type(symmetric=surface%family%symmetric, r=[0.0_wp, 1.0_wp], &
         clearance=exp([0.0_wp, 1.0_wp]), lines=case%study%whole_number('lines'), &
         points=case%study%whole_number('max_points'))
      call zone_around(request, surface, start, zone, progress)
      if (is_stopped(progress)) then
         result%cut = 'the computation was stopped before all boundaries were followed'
         return
      end if
      call add_pieces(zone, request, mirrored, found)
      if (plane%is_mirrored .and. .not. request%symmetric .and. &
         any([(found%pieces(i)%condition%kind == fold, i=1, found%n)])) then
         call result%fail('the motion is its own mirror image half a period later, and pitchforks &
            &of such motions with stops or friction are not followed; a smaller window may have &
            &none')
         return
      end if
      call in_parameters(case, surface, plane%changes, found)
      call result%open('families', 'family', [1])
      families(1) = found
      call put_pieces(families, result, vertex_names)
      call set_unit(result, 'vertices', 'x', case%study%word('x'))
      call set_unit(result, 'vertices', 'y', case%study%word('y'))
      call put_plane(plane, result)
      if (.not. found%closed) call result%remark(not_closed//' (its loop is 0)')
      result%empty = found%n == 0
      call tell_pieces(found, '', 'no zone: no motion of this family is both stable and admissible &
         &on the lines of the lattice', result)
   end subroutine run_structure

   !> Converts the pieces from the unit square to values of the parameters.
   pure subroutine in_parameters(case, surface, changes, found)
      !> The case.
      type(case_type), intent(in) :: case
      !> The surface.
      type(curve_type), intent(in) :: surface
      !> The parameters.
      type(change_type), intent(in) :: changes(2)
      !> In and out: the pieces.
      type(pieces_type), intent(inout) :: found
      character(:), allocatable :: text, x, y
      character(32) :: names(2)
      integer :: i, j

      call case%study%text('x', x)
      call case%study%text('y', y)
      names = [character(32) :: x, y]
      do i = 1, found%n
         associate (piece => found%pieces(i))
            call touch_detail(surface, piece%condition, names, text)
            piece%detail = text
            if (piece%name == 'cut') piece%detail = names(piece%condition%index)
            if (is_exchange(piece%condition)) piece%name = 'simultaneous'
            do j = 1, size(piece%vertices, 2)
               call to_parameters(piece%vertices(:, j))
            end do
         end associate
      end do
      do i = 1, size(found%rings)
         do j = 1, size(found%rings(i)%points, 2)
            call to_parameters(found%rings(i)%points(:, j))
         end do
      end do
   contains
      !> A place in the plane of the parameters.
      pure subroutine to_parameters(place)
         !> In: the share of x, and the exponential of that of y. Out: both parameters.
         real(wp), intent(inout) :: place(2)
         real(wp), parameter :: rounding = 1.0e-13_wp
         real(wp) :: share(2)
         integer :: axis

         share = [place(1), log(place(2))]
         do axis = 1, 2
            associate (bounds => surface%edges(2*axis - 1:2*axis)%bound)
               ! places on the border are exactly there
               if (abs(share(axis) - bounds(1)) < rounding) share(axis) = 0
               if (abs(share(axis) - bounds(2)) < rounding) share(axis) = 1
            end associate
            place(axis) = value_at(changes(axis), share(axis))
         end do
      end subroutine to_parameters
   end subroutine in_parameters

end module vi_zone_study
