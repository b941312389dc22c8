!> The study &zone of a &structure: where a motion is stable, in the plane of two parameters.
module vi_zone_structure_study
   use vi_branch_structure_study, only: check_structure_start, touch_detail
   use vi_curve_point, only: curve_type
   use vi_kinds, only: wp
   use vi_linear, only: most
   use vi_motion_family, only: grazing
   use vi_motion_structure_study, only: find_structure_motion
   use vi_progress, only: add_expected_work, is_stopped
   use vi_status, only: stat, status_text
   use vi_structure, only: check_structure, load_type, structure_type
   use vi_structure_groups, only: load_frequency, structure_of
   use vi_structure_parameter, only: check_parameter, parameter_change, x_function_keys, &
      y_function_keys
   use vi_structure_path, only: change_type, parameter_takes, value_at
   use vi_structure_return, only: settled_type
   use vi_structure_start, only: start_curve
   use vi_structure_tables, only: path_columns, put_path, put_structure, structure_columns
   use vi_study, only: a_word, case_type, column_type, key_type, result_type, study_type, truths, &
      values_type, wholes, words
   use vi_text, only: counted
   use vi_zone, only: zone_around, zone_type, zone_work
   use vi_zone_pieces, only: add_pieces, not_closed, pieces_type, put_pieces
   use vi_zone_request, only: zone_request_type
   use vi_zone_study, only: list_types, lines_key, vertices_key
   implicit none (type, external)
   private

   public :: declare_zone_structure

   type(key_type), parameter :: zone_keys(*) = [ &
      key_type('x', a_word, takes=parameter_takes, meaning='parameter of the abscissa'), &
      key_type('x_low', takes='a number, at most the value that the motion has', option='x', &
      meaning='lower bound of x'), &
      key_type('x_high', takes='a number above x_low, at least the value that the motion has', &
      option='x', meaning='upper bound of x'), &
      key_type('y', a_word, takes=parameter_takes, meaning='parameter of the ordinate'), &
      key_type('y_low', takes='a number, at most the value that the motion has', option='y', &
      meaning='lower bound of y'), &
      key_type('y_high', takes='a number above y_low, at least the value that the motion has', &
      option='y', meaning='upper bound of y'), &
      lines_key, vertices_key, x_function_keys, y_function_keys]

   type(column_type), parameter :: zone_columns(*) = [ &
      column_type('pieces', 'loop', wholes, &
      meaning='number of the closed boundary; 0 if it could not be closed'), &
      column_type('pieces', 'piece', wholes, meaning='number of the piece of the boundary'), &
      column_type('pieces', 'type', words, meaning='condition that is zero along it'), &
      column_type('pieces', 'detail', words, meaning='the impact, flight or bound concerned'), &
      column_type('pieces', 'symmetric', truths, listed=.false., &
      meaning='whether the motions are their own images half a period later'), &
      column_type('vertices', 'x', meaning='parameter of the abscissa'), &
      column_type('vertices', 'y', meaning='parameter of the ordinate'), &
      column_type('vertices', 'corner', truths, meaning='whether pieces meet there'), &
      column_type('vertices', 'speeds', each='impact', label='speed_#', &
      meaning='approach speeds of the impacts'), &
      column_type('vertices', 'phases', each='impact', label='phase_#', unit='rad', &
      meaning='load phases of the impacts'), &
      column_type('rings', 'x', listed=.false., &
      meaning='abscissa along a closed loop, counter-clockwise around a zone'), &
      column_type('rings', 'y', listed=.false., meaning='ordinate along a closed loop'), &
      column_type('families', 'motions', wholes, listed=.false., &
      meaning='motions at nodes of the lattice'), &
      column_type('families', 'steps', wholes, listed=.false., &
      meaning='steps along the lattice lines'), &
      column_type('families', 'untraced', wholes, listed=.false., &
      meaning='places on a boundary from which continuation failed'), &
      column_type('families', 'lines', wholes, each='axis', listed=.false., &
      meaning='lattice lines in each direction'), &
      column_type('families', 'closed', truths, listed=.false., &
      meaning='whether all boundaries that were found are closed'), &
      column_type('motion', 'gaps', wholes, each='impact', listed=.false., &
      meaning='gaps of the impacts, from 0'), &
      column_type('motion', 'cycles', wholes, listed=.false., meaning='load cycles in a period'), &
      column_type('motion', 'frequency', listed=.false., &
      meaning='circular frequency of the load at the start'), path_columns, structure_columns]

contains

   !> Declares the study.
   subroutine declare_zone_structure(study)
      !> The declaration of the study.
      type(study_type), intent(out) :: study

      study%name = 'zone_structure'
      study%group = 'zone'
      study%of_structure = .true.
      study%meaning = 'find where a motion of a structure is stable'
      study%starts_from = 'motion'
      study%list => list_zone
      study%row = 'vertices'
      study%check => check_zone
      study%check_start => check_structure_start
      study%memory => zone_memory
      study%run => run_zone
   end subroutine declare_zone_structure

   !> Lists the keys and columns.
   pure subroutine list_zone(keys, columns)
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) keys = zone_keys
      if (present(columns)) columns = zone_columns
   end subroutine list_zone

   !> Checks both parameters.
   subroutine check_zone(case)
      !> The case, with `start`.
      type(case_type), intent(inout) :: case
      type(structure_type) :: structure
      type(load_type) :: load
      type(change_type) :: changes(2)
      type(values_type) :: group
      integer :: i, j, status

      if (len(case%study%fault) > 0) return
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
                  'y', 'it changes what x changes')
            end do
         end do
      end if
      case%study = group
   end subroutine check_zone

   !> Bytes for the vertices of a loop that max_points allows, in the search and in the result.
   pure real(wp) function zone_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case

      bytes = case%study%whole_number('max_points')*(1600 + 300.0_wp*most)
   end function zone_memory

   !> Finds the zone of a motion.
   subroutine run_zone(case, threads, result, progress)
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
      type(settled_type) :: motion
      type(change_type) :: changes(2)
      type(curve_type) :: surface
      type(zone_request_type) :: request
      type(zone_type) :: zone
      type(pieces_type) :: found, families(1)
      character(*), parameter :: columns_of_vertices(4) = ['x     ', 'y     ', 'speeds', 'phases']
      real(wp), allocatable :: start(:)
      character(:), allocatable :: message, types
      logical :: mirrored
      integer :: status

      associate (not_used => threads)    ! a boundary is followed from point to point
      end associate
      call add_expected_work(zone_work, progress)
      result%empty = .true.
      call find_structure_motion(case, case%start, .true., structure, load, motion, status, &
         progress)
      if (status == stat%not_computed) then
         result%cut = 'it was stopped before a motion was reached'
         return
      end if
      if (status /= stat%ok) then
         call result%fail(status_text(status))
         return
      end if
      call parameter_change(case%study, 'x', 'x_', structure, load, changes(1), message)
      call parameter_change(case%study, 'y', 'y_', structure, load, changes(2), message)
      call start_curve(structure, load, motion, changes, surface, start, mirrored, message)
      if (len(message) > 0) then
         call result%fail(message)
         return
      end if
      ! the window is the unit square; zones have a logarithmic ordinate
      request = zone_request_type(symmetric=surface%family%symmetric, r=[0.0_wp, 1.0_wp], &
         clearance=exp([0.0_wp, 1.0_wp]), lines=case%study%whole_number('lines'), &
         points=case%study%whole_number('max_points'))
      call zone_around(request, surface, start, zone, progress)
      if (is_stopped(progress)) then
         result%cut = 'it was stopped before all boundaries were followed'
         return
      end if
      call add_pieces(zone, request, mirrored, found)
      call in_parameters(case, surface, changes, found)
      call result%open('families', 'family', [1])
      families(1) = found
      call put_pieces(families, result, columns_of_vertices)
      call result%open('motion', 'one', [1])
      call result%put('motion', 'gaps', motion%gaps - 1)
      call result%put('motion', 'cycles', [motion%cycles])
      call result%put('motion', 'frequency', [load%frequency])
      call put_path(result, changes)
      call put_structure(result, structure, load)
      if (.not. found%closed) call result%remark(not_closed//' (its loop is 0)')
      result%empty = found%n == 0
      if (result%empty) then
         call result%fail('no zone: no motion of this family is both stable and admissible on the &
            &lines of the lattice')
         return
      end if
      call list_types(found, types)
      call result%add_note(counted(found%loops, 'loop')//' in '//counted(found%n, 'piece')//types)
      if (.not. found%closed) call result%fail(not_closed)
   end subroutine run_zone

   !> Brings the pieces from the unit square to the parameters.
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
            if (piece%condition%kind == grazing .and. piece%condition%share >= 1) piece%name = &
               'simultaneous'
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

end module vi_zone_structure_study
