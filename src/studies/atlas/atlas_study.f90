!> The study &atlas: the zones of all patterns in a window.
module vi_atlas_study
   use vi_atlas, only: atlas_request_type, atlas_type, family_type, find_atlas, outcomes_of
   use vi_common_keys, only: check_window, max_events_key, window_keys
   use vi_family, only: can_be_symmetric
   use vi_free_states, only: find_pace, is_free
   use vi_kinds, only: wp
   use vi_pattern, only: starred_symbols
   use vi_zone_request, only: zone_request_type
   use vi_survey_outcome, only: beyond, count_outcomes, not_settled, outcome_names, periodic
   use vi_progress, only: is_stopped
   use vi_structure, only: check_structure, load_type, structure_type
   use vi_structure_atlas, only: find_structure_atlas, structure_request_type, &
      survey_point_type, traced_type
   use vi_structure_groups, only: load_frequency, structure_of
   use vi_structure_keys, only: needs_frequency
   use vi_structure_parameter, only: parameter_change, x_function_keys, y_function_keys
   use vi_structure_path, only: changed, structure_path_type, value_at
   use vi_structure_tables, only: put_path, put_structure, set_unit
   use vi_study, only: a_whole, case_type, column_type, every_model, key_type, list_for, &
      of_oscillator, of_structure, result_type, study_type, truths, wholes, words
   use vi_text, only: counted, exact, line_type, whole, whole_width
   use vi_zone_pieces, only: add_pieces, corner_column, family_columns, not_closed, piece_columns, &
      pieces_type, place_columns, put_pieces, vertex_columns
   use vi_zone_study, only: check_plane, gaps_followed, in_parameters, lines_key, plane_columns, &
      plane_keys, &
      plane_type, structure_place_columns, structure_vertex_columns, vertex_names, vertices_key
   implicit none (type, external)
   private

   public :: declare_atlas

   type(key_type), parameter :: limit_keys(*) = [ &
      key_type('max_impacts', a_whole, default='5', low=2.0_wp, high=8.0_wp, &
      meaning='largest number of impacts; an accumulation counts as one', model=of_oscillator), &
      key_type('max_cycles', a_whole, default='1', low=1.0_wp, high=4.0_wp, &
      meaning='largest number of load cycles of a pattern', model=of_oscillator), &
      key_type('max_impacts', a_whole, default='4', low=1.0_wp, high=24.0_wp, &
      meaning='largest number of impacts and contacts with stops of a motion whose zone is &
      &traced', model=of_structure), &
      key_type('max_cycles', a_whole, default='1', low=1.0_wp, high=16.0_wp, &
      meaning='largest number of load cycles in its period', model=of_structure), &
      key_type('survey', a_whole, default='400', low=0.0_wp, high=1.0e6_wp, &
      meaning='points of the window at which simulations are run until they settle', &
      model=of_oscillator), &
      key_type('survey', a_whole, default='100', low=1.0_wp, high=1.0e5_wp, &
      meaning='points of the window at which simulations are run until they settle', &
      model=of_structure), &
      key_type('settling', a_whole, default='400', low=1.0_wp, high=1.0e6_wp, &
      meaning='load cycles simulated at each point before its motion is examined')]
   type(key_type), parameter :: guesses_key = key_type('guesses', a_whole, default='24', &
      low=0.0_wp, high=1.0e5_wp, &
      meaning='guesses for motions at every second node in each direction, for each pattern')

   type(column_type), parameter :: symmetric_column = column_type('families', 'symmetric', truths, &
      meaning='whether the motions are their own mirror images')
   type(column_type), parameter :: atlas_columns(*) = [ &
      column_type('families', 'sides', words, meaning='walls in the order of impacts'), &
      column_type('families', 'cycles', wholes, meaning='load cycles of the period'), &
      symmetric_column, &
      piece_columns, place_columns, corner_column, vertex_columns, family_columns, &
      column_type('pieces', 'symmetric', truths, listed=.false., &
      meaning='whether the motions are their own mirror images'), &
      column_type('points', 'r', listed=.false., &
      meaning='frequency ratio of a point of the survey'), &
      column_type('points', 'clearance', unit='F0/K', listed=.false., &
      meaning='clearance of a point of the survey'), &
      column_type('points', 'outcome', words, words='periodic,beyond the limits,without impacts,&
      &chaotic,not settled,not confirmed,event limit reached', listed=.false., &
      meaning='outcome of the simulation at the point'), &
      column_type('points', 'sides', words, listed=.false., &
      meaning='walls of a periodic motion in the order of impacts'), &
      column_type('points', 'cycles', wholes, listed=.false., &
      meaning='load cycles of the period; 0 if it has none'), &
      column_type('points', 'explained', truths, listed=.false., &
      meaning='whether it lies in a zone of its pattern')]

   type(column_type), parameter :: structure_columns(*) = [ &
      column_type('families', 'order', words, &
      meaning='gaps of the impacts in order, from 0; with stops or friction those of all events'), &
      column_type('families', 'cycles', wholes, meaning='load cycles of the period'), &
      symmetric_column, piece_columns, structure_place_columns, corner_column, &
      structure_vertex_columns, family_columns, &
      column_type('points', 'x', listed=.false., meaning='abscissa of a point of the survey'), &
      column_type('points', 'y', listed=.false., meaning='ordinate of a point of the survey'), &
      column_type('points', 'outcome', words, words='periodic,beyond the limits,without impacts,&
      &chaotic,not settled,not confirmed,event limit reached,with rest', listed=.false., &
      meaning='outcome of the simulation at the point'), &
      column_type('points', 'impacts', wholes, listed=.false., &
      meaning='impacts in the period; 0 if it has none'), &
      column_type('points', 'cycles', wholes, listed=.false., &
      meaning='load cycles of the period; 0 if it has none'), &
      column_type('points', 'explained', truths, listed=.false., &
      meaning='whether it lies in a zone of its motion'), plane_columns]

   !> The region where the motion without impacts exists, in closed form: D > 2A.
   character(*), parameter :: without_impacts = 'without impacts, the free mass at rest: where &
      &clearance > 2/sqrt((1 - r^2)^2 + (2 xi r)^2)'

contains

   !> Declares the study, with its keys and columns.
   pure subroutine declare_atlas(study, keys, columns)
      !> The study.
      type(study_type), intent(out), optional :: study
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) then
         call list_for(of_structure, plane_keys, keys)
         call list_for(every_model, limit_keys, keys)
         call list_for(of_oscillator, window_keys, keys)
         call list_for(every_model, [lines_key], keys)
         call list_for(of_oscillator, [guesses_key], keys)
         call list_for(every_model, [vertices_key, max_events_key], keys)
         call list_for(of_structure, x_function_keys, keys)
         call list_for(of_structure, y_function_keys, keys)
      end if
      if (present(columns)) then
         call list_for(of_oscillator, atlas_columns, columns)
         call list_for(of_structure, structure_columns, columns)
      end if
      if (.not. present(study)) return
      study%name = 'atlas'
      study%meaning = 'find the zones of all patterns in a window'
      study%row = 'vertices'
      study%takes_elements = .true.
      study%takes_walls = .true.
      study%check => check_atlas
      study%memory => atlas_memory
      study%run => run_atlas
   end subroutine declare_atlas

   !> Checks the rules that involve several keys.
   subroutine check_atlas(case)
      !> The case.
      type(case_type), intent(inout) :: case

      if (case%model == of_structure) then
         if (len(case%study%fault) == 0 .and. .not. is_free(case)) call needs_frequency(case, 'x')
         if (len(case%study%fault) == 0) call check_plane(case)
         return
      end if
      call check_window(case)
   end subroutine check_atlas

   !> The request for the search.
   pure function atlas_request(case, threads) result(request)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      type(atlas_request_type) :: request

      associate (s => case%study)
         request = atlas_request_type(case%osc, [s%number('r_min'), s%number('r_max')], [s%number( &
            'clearance_min'), s%number('clearance_max')], s%whole_number('max_impacts'), &
            s%whole_number('max_cycles'), s%whole_number('survey'), s%whole_number('settling'), &
            s%whole_number('lines'), s%whole_number('guesses'), s%whole_number('max_points'), &
            threads, s%whole_number('max_events'))
      end associate
   end function atlas_request

   !> Bytes for the points of the survey, a few hundred numbers each.
   pure real(wp) function atlas_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case

      bytes = 2000.0_wp*case%study%whole_number('survey')
   end function atlas_memory

   !> Finds all zones in a window, and reports the outcomes of the survey and the attractors that
   !! lie in no zone.
   subroutine run_atlas(case, threads, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(atlas_request_type) :: request
      type(atlas_type) :: atlas
      type(pieces_type), allocatable :: found(:)
      type(line_type), allocatable :: sides(:)
      character(:), allocatable :: outcomes, patterns
      logical, allocatable :: lost(:)
      integer :: j
      logical :: stopped

      if (case%model == of_structure) then
         call run_structure(case, threads, result, progress)
         return
      end if
      request = atlas_request(case, threads)
      call find_atlas(request, atlas, progress)
      stopped = is_stopped(progress)
      if (stopped) then
         result%cut = whole(count(atlas%families%searched))//' of '// &
            whole(size(atlas%families))//' families of motions were searched'
         result%empty = .not. any(atlas%families%searched)
         if (result%empty) return
         call keep_searched(atlas)
      end if
      allocate (found(size(atlas%families)), sides(size(atlas%families)))
      do j = 1, size(found)
         associate (family => atlas%families(j))
            call add_pieces(family%zone, zone_request_type(case%osc, family%pattern, &
               family%symmetric, request%r, request%clearance), .not. family%symmetric .and. &
               can_be_symmetric(family%pattern, case%osc%restitution), found(j))
            sides(j)%text = starred_symbols(family%pattern%sides)
         end associate
      end do
      ! if stopped, an attractor outside all zones may belong to a zone that was not searched
      lost = .not. (atlas%explained .or. stopped)
      call survey_text(outcomes_of(atlas), outcomes)
      call result%open('families', 'family', [size(found)])
      call result%put_text('families', 'sides', sides)
      call result%put('families', 'cycles', [(atlas%families(j)%pattern%cycles, j=1, size(found))])
      call result%put('families', 'symmetric', [(merge(1, 0, atlas%families(j)%symmetric), &
         j=1, size(found))])
      call put_pieces(found, result)
      call put_points(atlas, result)
      result%empty = all(found%n == 0) .and. all(found%closed) .and. .not. (any(lost) .or. stopped)
      if (result%empty) then
         call result%fail('no zone: neither search nor survey found a stable, &
            &admissible motion within the limits in the window; '//outcomes)
         return
      end if
      call remark_survey(atlas, found, outcomes, lost, result)
      call result%add_note(counted(count(found%loops > 0), &
         'zone')//', '//counted(sum(found%loops), &
         'loop')//', '//counted(size(atlas%explained), 'attractor')//' surveyed')
      call result%add_note(outcomes)
      do j = 1, size(found)
         if (.not. found(j)%closed) call result%fail(pattern_text( &
            atlas%families(j)%pattern%sides, atlas%families(j)%pattern%cycles)//' '//not_closed)
      end do
      if (.not. any(lost)) return
      call list_patterns(atlas, patterns)
      call result%fail(whole(count(lost))//' of '//counted(size(atlas%explained), &
         'attractor')//' in no zone of the pattern:'//patterns)
   end subroutine run_atlas

   !> Finds the zones of the motions of a structure that a survey shows.
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
      type(structure_path_type) :: path
      type(survey_point_type), allocatable :: points(:)
      type(traced_type), allocatable :: families(:)
      type(pieces_type), allocatable :: found(:)
      character(:), allocatable :: fault, outcomes, message
      type(line_type), allocatable :: orders(:)
      integer, allocatable :: followed(:), gaps(:, :)
      type(structure_type) :: centre
      type(load_type) :: load, paced
      real(wp) :: unit
      integer :: i, j, lost, n, status

      call structure_of(case, plane%structure, plane%load)
      plane%load%frequency = load_frequency(case)
      call check_structure(plane%structure, status)
      call parameter_change(case%study, 'x', 'x_', plane%structure, plane%load, plane%changes(1), &
         message)
      call parameter_change(case%study, 'y', 'y_', plane%structure, plane%load, plane%changes(2), &
         message)
      path%structure = plane%structure
      path%load = plane%load
      path%changes = plane%changes
      associate (s => case%study)
         call find_structure_atlas(structure_request_type(s%whole_number('max_impacts'), &
            s%whole_number('max_cycles'), s%whole_number('survey'), s%whole_number('settling'), &
            s%whole_number('max_events'), s%whole_number('lines'), s%whole_number('max_points'), &
            threads, is_free(case)), path, points, families, n, progress)
      end associate
      if (is_stopped(progress)) then
         result%cut = counted(n, 'zone')//' of a survey of '//counted(size(points), 'point')// &
            ' were found'
         result%empty = n == 0
         if (result%empty) return
      else if (is_free(case) .and. all(points%outcome == not_settled)) then
         call changed(path, [0.5_wp, 0.5_wp], centre, load)
         call find_pace(centre, load, unit, paced, fault)
         result%empty = len(fault) > 0
         if (result%empty) call result%fail(fault)
         if (result%empty) return
      end if
      allocate (found(n), orders(n), gaps(maxval([1, (size(gaps_followed(families(i)%motion)), &
         i=1, n)]), n))
      gaps = -1
      do i = 1, n
         found(i) = families(i)%pieces
         call in_parameters(case, families(i)%surface, plane%changes, found(i))
         orders(i)%text = ''
         followed = gaps_followed(families(i)%motion)
         do j = 1, size(followed)
            gaps(j, i) = followed(j) - 1
            if (j > 1) orders(i)%text = orders(i)%text//' '
            orders(i)%text = orders(i)%text//whole(gaps(j, i))
         end do
      end do
      call survey_text(count_outcomes(points%outcome), outcomes)
      call result%open('families', 'family', [n])
      call result%put_text('families', 'order', orders)
      call result%put('families', 'cycles', [(families(i)%motion%cycles, i=1, n)])
      call result%put('families', 'symmetric', [(merge(1, 0, families(i)%symmetric), i=1, n)])
      call put_pieces(found, result, vertex_names)
      call set_unit(result, 'vertices', 'x', case%study%word('x'))
      call set_unit(result, 'vertices', 'y', case%study%word('y'))
      call put_survey(plane, points, result)
      call result%open('motion', 'one', [n], 'families', [(i, i=1, n)])
      call result%put('motion', 'gaps', [gaps])
      call result%put('motion', 'cycles', [(families(i)%motion%cycles, i=1, n)])
      call result%put('motion', 'frequency', spread(plane%load%frequency, 1, n))
      call put_path(result, plane%changes)
      call put_structure(result, plane%structure, plane%load)
      call result%remark(outcomes)
      result%empty = n == 0
      if (result%empty) then
         call result%fail('no zone: the survey found no stable motion within the limits; '// &
            outcomes)
         return
      end if
      call result%add_note(counted(n, 'zone')//', '//counted(sum(found%loops), 'loop')//', '// &
         outcomes)
      lost = count(points%outcome == periodic .and. .not. points%explained)
      if (.not. all(found%closed)) call result%fail(not_closed)
      if (lost > 0 .and. len(result%cut) == 0) call result%fail(counted(lost, 'motion')// &
         ' of the survey in no zone')
   end subroutine run_structure

   !> Puts the points of the survey of a structure into the result.
   pure subroutine put_survey(plane, points, result)
      !> The plane.
      type(plane_type), intent(in) :: plane
      !> The points; those that were not reached are left out.
      type(survey_point_type), intent(in) :: points(:)
      !> The result.
      type(result_type), intent(inout) :: result
      integer, allocatable :: order(:), impacts(:), cycles(:)
      integer :: i

      order = pack([(i, i=1, size(points))], points%outcome > 0)
      allocate (impacts(size(order)), cycles(size(order)), source=0)
      do i = 1, size(order)
         associate (motion => points(order(i))%motion)
            if (.not. allocated(motion%gaps)) cycle
            impacts(i) = size(motion%gaps)
            cycles(i) = motion%cycles
         end associate
      end do
      call result%open('points', 'point', [size(order)])
      call result%put('points', 'x', [(value_at(plane%changes(1), points(order(i))%at(1)), &
         i=1, size(order))])
      call result%put('points', 'y', [(value_at(plane%changes(2), points(order(i))%at(2)), &
         i=1, size(order))])
      call result%put('points', 'outcome', points(order)%outcome)
      call result%put('points', 'impacts', impacts)
      call result%put('points', 'cycles', cycles)
      call result%put('points', 'explained', merge(1, 0, points(order)%explained))
   end subroutine put_survey

   !> Removes the families whose zones were not completed.
   subroutine keep_searched(atlas)
      !> In and out: the atlas.
      type(atlas_type), intent(inout) :: atlas
      type(family_type), allocatable :: kept(:)
      integer :: i, n

      allocate (kept(count(atlas%families%searched)))
      n = 0
      do i = 1, size(atlas%families)
         if (.not. atlas%families(i)%searched) cycle
         n = n + 1
         kept(n) = atlas%families(i)
      end do
      call move_alloc(kept, atlas%families)
   end subroutine keep_searched

   !> Puts the points of the survey into the result.
   pure subroutine put_points(atlas, result)
      !> The atlas.
      type(atlas_type), intent(in) :: atlas
      !> The result.
      type(result_type), intent(inout) :: result
      type(line_type), allocatable :: sides(:)
      integer :: explained(size(atlas%points)), cycles(size(atlas%points)), i, found

      allocate (sides(size(atlas%points)))
      explained = 0
      cycles = 0
      found = 0
      do i = 1, size(atlas%points)
         associate (point => atlas%points(i))
            sides(i)%text = ''
            if (point%outcome /= periodic .and. point%outcome /= beyond) cycle
            sides(i)%text = starred_symbols(point%symbols)
            cycles(i) = point%cycles
            if (.not. point%found) cycle
            found = found + 1
            explained(i) = merge(1, 0, atlas%explained(found))
         end associate
      end do
      call result%open('points', 'point', [size(sides)])
      call result%put('points', 'r', atlas%points%r)
      call result%put('points', 'clearance', atlas%points%clearance)
      call result%put('points', 'outcome', atlas%points%outcome)
      call result%put_text('points', 'sides', sides)
      call result%put('points', 'cycles', cycles)
      call result%put('points', 'explained', explained)
   end subroutine put_points

   !> Adds remarks on the outcomes of the survey, and on what is missing.
   pure subroutine remark_survey(atlas, found, outcomes, lost, result)
      !> The atlas.
      type(atlas_type), intent(in) :: atlas
      !> The pieces of each family.
      type(pieces_type), intent(in) :: found(:)
      !> The outcomes of the survey, in words.
      character(*), intent(in) :: outcomes
      !> Of each attractor, whether it should lie in a zone and does not: these are listed.
      logical, intent(in) :: lost(:)
      !> The result.
      type(result_type), intent(inout) :: result
      integer :: i, j

      call result%remark(outcomes)
      call result%remark(without_impacts)
      do j = 1, size(found)
         if (.not. found(j)%closed) call result%remark(pattern_text( &
            atlas%families(j)%pattern%sides, atlas%families(j)%pattern%cycles)//': '//not_closed// &
            ' (its loop is 0)')
      end do
      do i = 1, size(lost)
         if (.not. lost(i)) cycle
         associate (item => atlas%attractors(i))
            call result%remark('in no zone of its pattern: '//pattern_text(item%symbols, &
               item%cycles)//' at r = '//exact(item%r)//', clearance = '//exact(item%clearance))
         end associate
      end do
      do i = 1, size(atlas%points)
         associate (item => atlas%points(i))
            if (item%outcome == beyond) call result%remark('beyond the limits: '//pattern_text( &
               item%symbols, item%cycles)//' at r = '//exact(item%r)//', clearance = '// &
               exact(item%clearance))
         end associate
      end do
   end subroutine remark_survey

   !> The outcomes of the points of the survey, in words.
   pure subroutine survey_text(counts, text)
      !> (outcomes) Number of points of each.
      integer, intent(in) :: counts(:)
      !> The numbers of points of each outcome, in words.
      character(:), allocatable, intent(out) :: text
      integer :: i

      text = 'survey of '//counted(sum(counts), 'point')
      do i = 1, size(counts)
         if (counts(i) == 0) cycle
         text = text//merge(': ', ', ', sum(counts(:i - 1)) == 0)//whole(counts(i))//' '// &
            trim(outcome_names(i))
      end do
   end subroutine survey_text

   !> The patterns of the attractors that lie in no zone, each once.
   pure subroutine list_patterns(atlas, text)
      !> The atlas.
      type(atlas_type), intent(in) :: atlas
      !> The short names, separated by commas; empty if there are none.
      character(:), allocatable, intent(out) :: text
      character(:), allocatable :: name
      integer :: i

      text = ''
      do i = 1, size(atlas%attractors)
         if (atlas%explained(i)) cycle
         name = ' '//pattern_text(atlas%attractors(i)%symbols, atlas%attractors(i)%cycles)
         if (index(text//',', name//',') > 0) cycle
         text = text//trim(merge(',', ' ', len(text) > 0))//name
      end do
   end subroutine list_patterns

   !> Short name of a pattern: RRL/1.
   pure function pattern_text(sides, cycles) result(text)
      !> Sides of the impacts, and the load cycles k of a period.
      integer, intent(in) :: sides(:), cycles
      character(size(sides) + count(abs(sides) > 1) + 1 + whole_width(cycles)) :: text

      text = starred_symbols(sides)//'/'//whole(cycles)
   end function pattern_text

end module vi_atlas_study
