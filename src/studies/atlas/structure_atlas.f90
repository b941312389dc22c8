!> The zones of the motions on which simulations of a structure settle, over a plane of two
!! parameters.
!!
!! Simulations at points spread over the plane show motions. Each one without rest that lies in no
!! zone found so far of motions with the same order of impacts is followed to the boundary of its
!! own.
module vi_structure_atlas
   use vi_curve_point, only: curve_type
   use vi_free_states, only: find_pace, settle_free_states
   use vi_kinds, only: wp
   use vi_progress, only: add_done_work, add_expected_work, is_stopped
   use vi_status, only: stat
   use vi_structure, only: load_type, structure_type
   use vi_settled_states, only: chaos => chaotic, outcome_type, settle_states, settling_type
   use vi_structure_find, only: random_structure_states
   use vi_structure_found, only: found_list_type
   use vi_structure_path, only: changed, is_odd, opposite_gap, structure_path_type, value_at
   use vi_structure_return, only: settled_type
   use vi_structure_run, only: impact_event, touch_event
   use vi_structure_start, only: start_curve
   use vi_survey_outcome, only: beyond, chaotic, event_limit, no_impacts, not_confirmed, &
      not_settled, periodic, with_rest
   use vi_zone, only: count_zone, zone_around, zone_type, zone_work
   use vi_zone_pieces, only: add_pieces, pieces_type
   use vi_zone_request, only: zone_request_type
   implicit none (type, external)
   private

   public :: find_structure_atlas

   !> What to search, and the effort.
   type, public :: structure_request_type
      !> Limits of the motions whose zones are traced.
      integer :: max_impacts = 4, max_cycles = 1
      !> Points of the survey, load cycles of the transient at each, and largest number of events.
      integer :: survey = 100, settling = 300, max_events = 10000000
      !> Lattice lines in each direction, largest number of points of a loop, and OpenMP threads.
      integer :: lines = 17, points = 20000, threads = 1
      !> Whether the motions are self-excited; load cycles are then natural periods.
      logical :: free = .false.
   end type structure_request_type

   !> A point of the survey.
   type, public :: survey_point_type
      !> Both parameters, as shares of the way between their bounds.
      real(wp) :: at(2) = 0
      !> As in vi_survey_outcome; 0 if it was not reached.
      integer :: outcome = 0
      !> The motion, if it is periodic.
      type(settled_type) :: motion
      !> Whether it lies in a zone of its family.
      logical :: explained = .false.
   end type survey_point_type

   !> The zone of a motion of the survey.
   type, public :: traced_type
      !> The motion, and its surface over the unit square.
      type(settled_type) :: motion
      type(curve_type) :: surface
      logical :: symmetric = .false.
      type(zone_type) :: zone
      type(pieces_type) :: pieces
   end type traced_type

   !> The unit square; zones have a logarithmic ordinate.
   real(wp), parameter :: square(2) = [0.0_wp, 1.0_wp]
   !> Longest period that is looked for, in load cycles.
   integer, parameter :: longest = 16
   !> Largest number of zones.
   integer, parameter :: most_zones = 500

contains

   !> The survey, and the zones of its motions.
   subroutine find_structure_atlas(request, path, points, families, n, progress)
      !> The request.
      type(structure_request_type), intent(in) :: request
      !> The structure and its load, and both parameters.
      type(structure_path_type), intent(in) :: path
      !> The points of the survey.
      type(survey_point_type), allocatable, intent(out) :: points(:)
      !> The zones; the first n are there.
      type(traced_type), allocatable, intent(out) :: families(:)
      integer, intent(out) :: n
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      integer :: i

      allocate (points(request%survey), families(min(request%survey, most_zones)))
      n = 0
      !$omp parallel do schedule(dynamic, 1) num_threads(request%threads)
      do i = 1, size(points)
         if (.not. is_stopped(progress)) call settle_at(request, path, i, points(i), progress)
      end do
      !$omp end parallel do
      do i = 1, size(points)
         if (is_stopped(progress)) return
         if (points(i)%outcome == periodic) call trace(request, path, points(i), families, n, &
            progress)
      end do
   end subroutine find_structure_atlas

   !> The motion on which a random state settles at a point of the survey.
   subroutine settle_at(request, path, number, point, progress)
      !> The request.
      type(structure_request_type), intent(in) :: request
      !> The structure and its load, and both parameters.
      type(structure_path_type), intent(in) :: path
      !> Number of the point; the points fill the square evenly (an additive recurrence).
      integer, intent(in) :: number
      !> The point.
      type(survey_point_type), intent(inout) :: point
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      real(wp), parameter :: plastic = 1.324717957244746_wp
      type(structure_type) :: structure
      type(load_type) :: load, paced
      type(found_list_type) :: list
      type(settling_type) :: how
      character(:), allocatable :: fault
      real(wp) :: states(2*size(path%structure%mass, 1), 2), unit
      type(outcome_type) :: one(1)
      integer :: ready

      point%at = modulo(0.5_wp + number/[plastic, plastic**2], 1.0_wp)
      call changed(path, point%at, structure, load)
      point%outcome = not_settled
      fault = ''
      paced = load
      if (request%free) call find_pace(structure, load, unit, paced, fault)
      if (len(fault) > 0) return
      call random_structure_states(structure, paced, number, states, ready)
      if (ready /= stat%ok) return
      how = settling_type(request%settling, max(longest, request%max_cycles), request%max_events, &
         1, .false.)
      if (request%free) then
         call settle_free_states(structure, load, unit, states(:, 2:), how, list, one, progress)
      else
         call settle_states(structure, load, 0.0_wp, states(:, 2:), how, list, one, progress)
      end if
      if (one(1)%status == stat%not_computed) then
         point%outcome = 0
      else if (one(1)%label > 0) then
         point%motion = list%motions(one(1)%label)
         point%outcome = beyond
         if (contacts_of(point%motion) <= request%max_impacts .and. point%motion%cycles <= &
            request%max_cycles) point%outcome = periodic
         if (size(point%motion%resting) > 0) point%outcome = with_rest
      else if (one(1)%kind == chaos) then
         point%outcome = chaotic
      else if (any(one(1)%status == [stat%no_impacts, stat%permanent_rest])) then
         point%outcome = no_impacts
      else if (one(1)%status == stat%event_limit) then
         point%outcome = event_limit
      else if (any(one(1)%status == [stat%not_stable, stat%no_convergence, stat%singular])) then
         point%outcome = not_confirmed
      end if
   end subroutine settle_at

   !> Impacts and contacts with stops in a period: how they end, and friction, do not count.
   pure integer function contacts_of(found) result(contacts)
      !> The motion.
      type(settled_type), intent(in) :: found

      contacts = size(found%gaps)
      if (allocated(found%events)) contacts = count(found%events%kind == impact_event .or. &
         found%events%kind == touch_event)
   end function contacts_of

   !> Traces the zone of a motion of the survey, unless it lies in one that is known.
   subroutine trace(request, path, point, families, n, progress)
      !> The request.
      type(structure_request_type), intent(in) :: request
      !> The structure and its load, and both parameters.
      type(structure_path_type), intent(in) :: path
      !> In and out: the point.
      type(survey_point_type), intent(inout) :: point
      !> In and out: the zones, and their number.
      type(traced_type), intent(inout) :: families(:)
      integer, intent(inout) :: n
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(structure_path_type) :: there
      type(zone_request_type) :: window
      type(settled_type) :: start
      type(curve_type) :: surface
      real(wp), allocatable :: unknowns(:)
      character(:), allocatable :: message
      logical :: mirrored, undecided
      integer :: i

      there = path
      call changed(path, point%at, there%structure, there%load)
      there%changes%start = [(value_at(path%changes(i), point%at(i)), i=1, 2)]
      start = point%motion
      ! a self-excited motion has its own frequency
      if (request%free) there%load%frequency = start%frequency
      call start_curve(there%structure, there%load, start, there%changes, surface, unknowns, &
         mirrored, message)
      if (len(message) > 0) return
      undecided = .false.
      do i = 1, n
         if (families(i)%symmetric .neqv. surface%family%symmetric) cycle
         if (.not. has_order(path, point%motion, families(i)%motion)) cycle
         point%explained = is_inside(families(i)%zone, point%at)
         if (point%explained) return
         undecided = undecided .or. .not. families(i)%pieces%closed
      end do
      ! the point may lie in a zone whose boundary is not closed
      if (undecided .or. n == size(families)) return
      n = n + 1
      call add_expected_work(zone_work, progress)
      associate (family => families(n))
         family%motion = point%motion
         family%surface = surface
         family%symmetric = surface%family%symmetric
         window = zone_request_type(symmetric=family%symmetric, r=square, clearance=exp(square), &
            lines=request%lines, points=request%points)
         call zone_around(window, surface, unknowns, family%zone, progress)
         call add_pieces(family%zone, window, mirrored, family%pieces)
         point%explained = is_inside(family%zone, point%at)
      end associate
      ! one that was stopped is incomplete
      if (is_stopped(progress)) n = n - 1
      call add_done_work(0, progress)
   end subroutine trace

   !> Whether a point lies in a zone.
   pure logical function is_inside(zone, at)
      !> The zone.
      type(zone_type), intent(in) :: zone
      !> The point in the unit square.
      real(wp), intent(in) :: at(2)

      is_inside = any(count_zone(zone, square, exp(square), reshape([at(1), exp(at(2))], &
         [2, 1])) > 0)
   end function is_inside

   !> Whether a motion has the order of impacts of another one, or of its mirror image; with stops
   !! or friction the order and the kinds of events.
   pure logical function has_order(path, motion, other)
      !> The structure and its load, and both parameters.
      type(structure_path_type), intent(in) :: path
      !> The motions.
      type(settled_type), intent(in) :: motion, other
      integer :: i, images(size(motion%gaps)), turn

      has_order = .false.
      if (motion%cycles /= other%cycles .or. size(motion%gaps) /= size(other%gaps)) return
      if (allocated(motion%events) .neqv. allocated(other%events)) return
      if (allocated(motion%events)) then
         do turn = 1, size(motion%gaps)
            has_order = all(cshift(motion%events%gap, turn) == other%events%gap) .and. &
               all(cshift(motion%events%kind, turn) == other%events%kind)
            if (has_order) return
         end do
         return
      end if
      images = motion%gaps
      if (is_odd(path)) images = [(opposite_gap(path%structure, motion%gaps(i)), &
         i=1, size(motion%gaps))]
      do turn = 1, size(motion%gaps)
         has_order = all(cshift(motion%gaps, turn) == other%gaps) .or. &
            all(cshift(images, turn) == other%gaps)
         if (has_order) return
      end do
   end function has_order

end module vi_structure_atlas
