!> The family of a known motion of a structure, and its place in it: where branches and zones start.
module vi_structure_start
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_assess, only: consistency
   use vi_curve_point, only: curve_type, parameters_of, unknowns_of
   use vi_family, only: images_of, new_family, repetition_distance, repetition_type
   use vi_exact, only: exact_acceptance
   use vi_kinds, only: pi, wp
   use vi_columns, only: solve_columns
   use vi_linear, only: most
   use vi_motion, only: no, unknown, yes
   use vi_motion_family, only: condition_type, contact_vanishes, edge, event_vanishes, &
      flight_vanishes, neimark_sacker, zero_approach
   use vi_orbit, only: family_type, most_impacts, n_parameters
   use vi_pattern, only: pattern_type
   use vi_responses, only: offset_pairs
   use vi_status, only: stat
   use vi_spectrum, only: spectrum_type
   use vi_structure, only: check_structure, factor_along, load_type, new_regime, regime_type, &
      restitution_of, state_of, structure_type, to_pairs
   use vi_structure_assess, only: assess_multipliers, structure_verdicts_type
   use vi_structure_extremes, only: coordinate_extremes, extend_extremes
   use vi_structure_together, only: are_multiple, multipliers_beside, set_together, whole_family, &
      whole_member
   use vi_structure_family, only: structure_family_type
   use vi_structure_members, only: member_type, set_flights, set_member, set_sides, &
      structure_members_type, whole_sides
   use vi_structure_resting_family, only: structure_resting_type
   use vi_structure_rests, only: course_type, first, follow_period, keep_regimes, monodromy, &
      release, rests_type, single, switch, symbols_to_state
   use vi_structure_path, only: change_type, is_odd, keeps_matrices, mirror_of, &
      structure_path_type
   use vi_structure_symmetry, only: even_and_odd, find_symmetry
   use vi_structure_motion, only: new_equations, relative, residuals
   use vi_structure_period, only: describe_structure_motion, structure_motion_type
   use vi_structure_return, only: closed_type, settled_type
   use vi_structure_run, only: impact_event, release_event, slip_down_event, slip_up_event, &
      stick_event
   use vi_text, only: counted, whole_text => whole
   implicit none (type, external)
   private

   public :: motion_at, period_at, phases_at, start_curve

   !> A motion nearer than this to one that repeats itself is that one.
   real(wp), parameter :: same = 1.0e-6_wp
   !> Where a bound is a resonance, motions end this share of the range before it. They are
   !! continuous there, but their equations are not.
   real(wp), parameter :: inset = 1.0e-6_wp
   !> Flights within an accumulation that are shorter, over the shortest time scale, are followed by
   !! simulation.
   real(wp), parameter :: short = 0.3_wp

contains

   !> The curve or surface through a motion, and the point there.
   subroutine start_curve(structure, load, start, changes, curve, point, mirrored, message, halves)
      !> The structure at the start.
      type(structure_type), intent(in) :: structure
      !> Its load.
      type(load_type), intent(in) :: load
      !> In and out: the motion; of impacts at one instant the first one becomes the first of the
      !! period.
      type(settled_type), intent(inout) :: start
      !> The one or two parameters that change.
      type(change_type), intent(in) :: changes(:)
      !> The curve: each parameter is 0 at its lower bound and 1 at the upper one.
      type(curve_type), intent(out) :: curve
      !> The unknowns of the motion, and the parameters.
      real(wp), allocatable, intent(out) :: point(:)
      !> Whether motions of this pattern can be their own images although this one is not.
      logical, intent(out) :: mirrored
      !> Why there is no such family; empty if there is one.
      character(:), allocatable, intent(out) :: message
      !> Whether half a period of a motion with stops or friction that is its own mirror image is
      !! followed, which distinguishes its pitchforks from folds; not by default.
      logical, intent(in), optional :: halves
      type(structure_members_type) :: s
      type(structure_family_type) :: whole
      type(structure_type) :: complete
      type(regime_type) :: regime
      type(pattern_type) :: pattern
      type(family_type) :: family
      type(repetition_type), allocatable :: repetitions(:)
      type(repetition_type) :: image
      real(wp), allocatable :: unknowns(:), shares(:)
      type(settled_type) :: found
      integer, allocatable :: pairs(:)
      integer :: i, n, status
      logical :: half, odd, possible, symmetric

      mirrored = .false.
      message = ''
      if (size(start%resting) > 0 .or. allocated(start%events)) then
         half = .false.
         if (present(halves)) half = halves
         call start_resting(structure, load, start, changes, half, curve, point, mirrored, message)
         return
      end if
      s%path%structure = structure
      call check_structure(s%path%structure, status)
      s%path%load = load
      s%path%changes = changes
      call set_together(s, start, found, message)
      if (len(message) > 0) return
      n = size(found%gaps)
      complete = s%path%structure
      call new_regime(complete, s%path%load, [integer :: ], regime, status)
      regime%frequency = load%frequency
      allocate (pairs, source=offset_pairs(regime))
      if (n > most_impacts .or. 2*n + size(pairs) + 2 > most) then
         message = 'the motion has '//counted(n, 'impact')//', and at most '// &
            whole_text(min(most_impacts, (most - 2 - size(pairs))/2))//' can be followed'
         return
      end if
      s%speed = maxval(found%motion%speeds)
      s%length = s%speed/load%frequency
      s%p = size(pairs)
      allocate (s%free(size(complete%mass, 1), s%p))
      s%free = regime%qx(:, pairs)
      do i = 1, s%p
         ! a displacement is the unit, whatever the unit of mass
         s%free(:, i) = s%free(:, i)/maxval(abs(s%free(:, i)))
      end do
      call set_sides(s)
      pattern%sides = complete%channel(found%gaps)*complete%wall(found%gaps)
      pattern%cycles = found%cycles
      shares = [((changes(i)%start - changes(i)%low)/(changes(i)%high - changes(i)%low), &
         i=1, size(changes))]
      odd = is_odd(s%path)
      call new_family(pattern, .false., odd, family, repetitions, possible)
      mirrored = .false.
      if (size(repetitions) > 0) mirrored = repetitions(1)%sign < 0
      if (.not. mirrored) call add_symmetry(found%gaps, s, family, repetitions)
      call unknowns_of_motion(s, family, regime, found, shares, unknowns)
      if (allocated(s%impact_of)) call check_parting(s, family, unknowns, shares, message)
      if (len(message) > 0) return
      symmetric = .false.
      do i = 1, size(repetitions)
         if (repetition_distance(family, repetitions(i), unknowns) > same) cycle
         if (repetitions(i)%sign > 0) then
            message = 'the motion repeats itself within its '//counted(found%cycles, &
               'load cycle')//'; start from the shorter period'
            return
         end if
         symmetric = .true.
      end do
      if (symmetric) then
         unknowns = [unknowns(:n/2), unknowns(n + 1:n + n/2), unknowns(2*n + 1:2*n + s%even)]
         repetitions = pack(repetitions, repetitions%sign > 0)
         repetitions%halves = .false.
         family%mirror = .true.
         family%sides = family%sides(:n/2)
      end if
      mirrored = .false.
      if (size(repetitions) > 0) mirrored = repetitions(1)%sign < 0
      whole%impacts = family
      whole%symmetric = family%mirror
      whole%slack = 0.1_wp
      whole%repetitions = repetitions
      if (keeps_matrices(s%path)) then
         allocate (s%regime)
         call new_regime(s%path%structure, s%path%load, [integer :: ], s%regime, status, .false., &
            .true.)
         if (status /= stat%ok) deallocate (s%regime)
      end if
      whole%members = s
      image = repetition_type(phase=pi)
      if (allocated(s%symmetry)) image = repetition_type(0, -1.0_wp, family%cycles*image%phase, &
         s%even)
      if (odd .and. .not. allocated(s%symmetry)) image%sign = -1
      whole%images = images_of(family, image)
      allocate (curve%family, source=whole)
      call set_bounds(curve, size(changes))
      do i = 1, size(curve%edges)
         call avoid_resonance(s, family, unknowns, shares, curve%edges(i))
      end do
      point = [unknowns, shares]
   end subroutine start_curve

   !> The parameters of a curve, from 0 at their lower bounds to 1 at the upper ones.
   pure subroutine set_bounds(curve, parameters)
      !> In and out: the curve.
      type(curve_type), intent(inout) :: curve
      !> How many there are.
      integer, intent(in) :: parameters
      integer :: i

      curve%active = [(i, i=1, parameters)]
      curve%origin = spread(0.0_wp, 1, parameters)
      curve%scale = spread(1.0_wp, 1, parameters)
      allocate (curve%edges(2*parameters))
      do i = 1, parameters
         curve%edges(2*i - 1) = condition_type(edge, i, 1, bound=0.0_wp)
         curve%edges(2*i) = condition_type(edge, i, -1, bound=1.0_wp)
      end do
   end subroutine set_bounds

   !> The curve or surface through a motion with rests, and the point there.
   subroutine start_resting(structure, load, start, changes, half, curve, point, mirrored, message)
      !> As in `start_curve`.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> In: the motion. Out: of its impacts, those that are symbols of the family.
      type(settled_type), intent(inout) :: start
      !> As in `start_curve`.
      type(change_type), intent(in) :: changes(:)
      !> As `halves` in `start_curve`.
      logical, intent(in) :: half
      !> As in `start_curve`.
      type(curve_type), intent(out) :: curve
      !> As in `start_curve`.
      real(wp), allocatable, intent(out) :: point(:)
      !> As in `start_curve`.
      logical, intent(out) :: mirrored
      !> As in `start_curve`.
      character(:), allocatable, intent(out) :: message
      type(structure_resting_type) :: family
      real(wp), allocatable :: phases(:), unknowns(:), shares(:)
      integer, allocatable :: impacts(:)
      type(regime_type) :: regime
      integer :: i, m, n, status
      logical :: good

      message = ''
      mirrored = .false.
      associate (s => family%rests)
         s%path%structure = structure
         call check_structure(s%path%structure, status)
         s%path%load = load
         s%path%changes = changes
         s%cycles = start%cycles
         n = size(structure%mass, 1)
         s%speed = maxval(start%motion%speeds)
         if (allocated(start%events)) s%speed = max(maxval(abs(start%motion%states(n + 1:, :))), &
            load%frequency*maxval(abs(start%motion%states(:n, :))))
         s%length = s%speed/load%frequency
         s%free = start%free
         if (s%free .and. .not. allocated(start%events)) then
            message = 'a self-excited motion without friction cannot be followed'
            return
         end if
         if (allocated(start%events)) then
            call new_regime(s%path%structure, load, [integer :: ], regime, status)
            call read_events(s, start, size(changes) > 1, regime%unit*load%frequency, &
               min(most_impacts, most - 2 - 2*n), unknowns, message)
            if (len(message) > 0) return
            call set_repetitions(family, [unknowns(2*n + 1:), unknowns(2*n + 1) + 2*pi*s%cycles], &
               mirrored, message)
            if (len(message) > 0) return
            start%gaps = pack(s%gaps, s%kinds /= release)
            start%resting = pack(s%gaps, s%kinds == release)
            ! phases from the event that begins the period
            if (s%free) unknowns(2*n + 1:) = unknowns(2*n + 1:) - unknowns(2*n + 1)
            if (half .and. size(family%repetitions) + size(start%resting) == 0) call &
               take_half(family, unknowns)
            ! the end of what is followed is unknown
            if (s%free) unknowns(2*n + 1) = s%whole_turn()
            call finish_resting(family, unknowns, changes, curve, point)
            return
         end if
         call new_regime(s%path%structure, load, [integer :: ], regime, status)
         call read_symbols(s, start, regime%unit*load%frequency, min(most_impacts, most - 2 &
            - 2*n), phases, impacts, message)
         if (len(message) > 0) return
         m = size(s%kinds)
         s%first_gap = s%gaps(m)
         call set_repetitions(family, phases, mirrored, message)
         if (len(message) > 0) return
         shares = shares_of(changes)
         allocate (unknowns(2*n + m))
         i = findloc(s%kinds /= release, .true., dim=1, back=.true.)
         associate (state => start%motion%states(:, impacts(i)))
            call symbols_to_state(s, phases, shares, i, state(:n), state(n + 1:), unknowns, good)
         end associate
         if (.not. good) then
            message = 'the impacts before a rest do not accumulate as in the simulation'
            return
         end if
         impacts = pack(impacts, impacts > 0)
         start%gaps = start%gaps(impacts)
         start%resting = pack(s%gaps, s%kinds == release)
      end associate
      call finish_resting(family, unknowns, changes, curve, point)
   end subroutine start_resting

   !> Keeps only the first half of the symbols of a motion with stops or friction, if it is its own
   !! mirror image.
   pure subroutine take_half(family, unknowns)
      !> In and out: the family.
      type(structure_resting_type), intent(inout) :: family
      !> In and out: the unknowns of the motion.
      real(wp), allocatable, intent(inout) :: unknowns(:)
      real(wp) :: apart(size(family%rests%kinds)/2)
      integer :: i, m, n

      associate (s => family%rests)
         m = size(s%kinds)/2
         n = size(unknowns) - size(s%kinds)
         if (m == 0 .or. modulo(size(s%kinds), 2) /= 0 .or. modulo(s%cycles, 2) == 0) return
         if (.not. is_odd(s%path, friction=.true.)) return
         apart = unknowns(n + m + 1:) - unknowns(n + 1:n + m) - pi*s%cycles
         if (any(abs(apart) > same) .or. any(s%kinds(:m) /= s%kinds(m + 1:))) return
         if (any(s%gaps(m + 1:) /= [(mirror_of(s%path%structure, s%gaps(i)), i=1, m)])) return
         s%halved = .true.
         s%kinds = s%kinds(:m)
         s%gaps = s%gaps(:m)
         s%rows = s%rows(:m)
         s%walls = s%walls(:m)
         s%stuck = s%stuck(:m)
         call keep_first(s%closed, m)
         unknowns = unknowns(:n + m)
         family%symmetric = .true.
      end associate
   contains
      !> Keeps the sets from 0 to a number.
      pure subroutine keep_first(sets, last)
         !> In and out: the sets.
         type(closed_type), allocatable, intent(inout) :: sets(:)
         !> The last one.
         integer, intent(in) :: last
         type(closed_type), allocatable :: kept(:)

         allocate (kept(0:last))
         kept = sets(0:last)
         call move_alloc(kept, sets)
      end subroutine keep_first
   end subroutine take_half

   !> The parameters of a motion, as shares of the way between their bounds.
   pure function shares_of(changes) result(shares)
      !> The parameters.
      type(change_type), intent(in) :: changes(:)
      real(wp) :: shares(size(changes))
      integer :: i

      shares = [((changes(i)%start - changes(i)%low)/(changes(i)%high - changes(i)%low), &
         i=1, size(changes))]
   end function shares_of

   !> The curve or surface of a family with rests, or with stops and friction.
   subroutine finish_resting(family, unknowns, changes, curve, point)
      !> In and out: the family.
      type(structure_resting_type), intent(inout) :: family
      !> The unknowns of the motion at the start.
      real(wp), intent(in) :: unknowns(:)
      !> The parameters.
      type(change_type), intent(in) :: changes(:)
      !> As in `start_curve`.
      type(curve_type), intent(out) :: curve
      !> As in `start_curve`.
      real(wp), allocatable, intent(out) :: point(:)

      family%jumps = .true.
      allocate (family%images(0))
      call keep_regimes(family%rests, shares_of(changes))
      allocate (curve%family, source=family)
      call set_bounds(curve, size(changes))
      point = [unknowns, shares_of(changes)]
   end subroutine finish_resting

   !> The events of a motion with stops or friction, in order from after the one that is followed
   !! by the longest flight in which nothing rests or sticks.
   subroutine read_events(s, start, is_surface, scale, most_symbols, unknowns, message)
      !> In and out: the family; symbols and what is closed after them are set.
      type(rests_type), intent(inout) :: s
      !> In and out: the motion; without rests the sequence of its events is set.
      type(settled_type), intent(inout) :: start
      !> Whether more than one parameter changes.
      logical, intent(in) :: is_surface
      !> The shortest time scale, as a load phase (rad).
      real(wp), intent(in) :: scale
      !> Most symbols.
      integer, intent(in) :: most_symbols
      !> The unknowns of the motion.
      real(wp), allocatable, intent(out) :: unknowns(:)
      !> What is wrong; empty if nothing is.
      character(:), allocatable, intent(out) :: message
      !> Events nearer than this (rad) are at one instant.
      real(wp), parameter :: instant = 1.0e-8_wp
      integer, allocatable :: order(:), all_events(:), ends(:)
      real(wp), allocatable :: phases(:), flights(:)
      logical, allocatable :: free(:)
      real(wp) :: first_phase, whole
      integer :: begin, i, j, m

      message = ''
      whole = 2*pi*s%cycles
      associate (events => start%events, structure => s%path%structure)
         ! changes at one instant are reported one by one
         order = pack([(i, i=1, size(events))], [.not. is_repeated(1, size(events)), &
            (.not. is_repeated(i, i - 1), i=2, size(events))])
         m = size(order)
         phases = [((real(events(order(i))%cycle - events(order(1))%cycle, wp)*2*pi + &
            events(order(i))%elapsed*s%path%load%frequency), i=1, m)]
         flights = [phases(2:), phases(1) + whole] - phases
         free = [(.not. any(holds(start%closed(order(i))%set)), i=1, m)]
         if (.not. any(free)) free = [(.not. any(holds(start%closed(order(i))%set) .and. .not. &
            structure%rubs(abs(start%closed(order(i))%set))), i=1, m)]
         begin = maxloc(flights, dim=1, mask=free)
         order = cshift(order, begin)
         first_phase = phases(begin)
         phases = [phases(begin + 1:), phases(:begin) + whole]
         call find_accumulations(s, start, scale, most_symbols, order, phases, ends, message)
         if (len(message) > 0) return
         m = size(order)
         if (m > most_symbols) message = 'the motion has '//counted(m, 'event')//'; at most '// &
            whole_text(most_symbols)//' can be followed'
         if (any(start%limits(1, order) == 0)) message = 'a jump of a force makes friction stick &
            &or slip; such motions cannot be followed'
         if (len(message) > 0) return
         ! an accumulation ends where the rest begins
         flights = [phases(2:), phases(1) + whole] - [(phases(i) + phase_between(order(i), &
            ends(i)), i=1, m)]
         if (any(flights < instant)) then
            message = 'two events occur at the same instant; such motions with stops or friction &
               &cannot be followed'
            return
         end if
         phases = [first_phase, phases(:m - 1)]
         phases = phases - 2*pi*floor(phases(1)/(2*pi))
         s%kinds = merge(single, switch, events(order)%kind == impact_event)
         where (events(order)%kind == release_event) s%kinds = release
         where (ends /= order) s%kinds = first
         s%gaps = events(order)%gap
         s%rows = start%limits(1, order)
         s%walls = start%limits(2, order)
         allocate (s%closed(0:m), s%stuck(m), s%bounces(m))
         s%closed(0) = start%closed(ends(m))
         s%closed(1:) = start%closed(ends)
         s%bounces(:) = start%closed(order)
         if (is_surface .and. any([(s%kinds(i) == first .and. rubs_in_bounces(i), i=1, m)])) then
            message = 'impacts accumulate on a gap along which friction acts; of such motions &
               &branches can be followed, but no zones and charts'
            return
         end if
         do i = 1, m
            allocate (s%stuck(i)%set(0))
            associate (event => events(order(i)), set => s%closed(i)%set)
               if (all(event%kind /= [slip_up_event, slip_down_event]) .or. s%rows(i) > &
                  structure%channels) cycle
               s%stuck(i)%set = [pack(set, set < event%gap .and. abs(set) /= event%gap), &
                  event%gap, pack(set, set > event%gap)]
            end associate
         end do
         s%first_gap = s%gaps(m)
         unknowns = [events(order(m))%q/s%length, events(order(m))%rate/s%speed, phases]
         if (size(start%resting) > 0) return
         all_events = cshift([(i, i=1, size(events))], order(1) - 1)
         allocate (start%sequence(3, size(events)))
         do i = 1, size(events)
            start%sequence(:, i) = [events(all_events(i))%kind, events(all_events(i))%gap, &
               count([(any(all_events(:i) == order(j)), j=1, m)])]
         end do
      end associate
   contains
      !> Whether an event reports a change that was made at the one before it.
      pure logical function is_repeated(i, before)
         !> Both events.
         integer, intent(in) :: i, before

         associate (events => start%events)
            is_repeated = i /= before .and. events(i)%regime == events(before)%regime .and. &
               events(i)%cycle == events(before)%cycle .and. .not. abs(events(i)%elapsed &
               - events(before)%elapsed) > 0
         end associate
      end function is_repeated

      !> Whether friction turns in the bounces of an accumulation.
      pure logical function rubs_in_bounces(symbol)
         !> The symbol.
         integer, intent(in) :: symbol
         real(wp) :: restitution, slope
         integer :: j

         call restitution_of(s%path%structure, s%gaps(symbol), 0.0_wp, restitution, slope)
         rubs_in_bounces = restitution > 0 .and. any([(abs(factor_along(s%path%structure, j, &
            s%gaps(symbol))) > 0, j=1, size(s%path%structure%openings))])
      end function rubs_in_bounces

      !> Which of what is closed is a gap that rests or friction that sticks.
      pure function holds(set)
         !> What is closed.
         integer, intent(in) :: set(:)
         logical :: holds(size(set))

         holds = set > 0 .and. .not. s%path%structure%elastic(abs(set))
      end function holds

      !> The load phase (rad) from one event to another one at its instant or after it.
      pure real(wp) function phase_between(from, to) result(phase)
         !> Numbers of the events.
         integer, intent(in) :: from, to

         associate (events => start%events)
            phase = real(events(to)%cycle - events(from)%cycle, wp)*2*pi + (events(to)%elapsed &
               - events(from)%elapsed)*s%path%load%frequency
            if (to < from) phase = phase + whole
         end associate
      end function phase_between
   end subroutine read_events

   !> Leaves out the events within accumulations: of each the first impact remains.
   subroutine find_accumulations(s, start, scale, most_symbols, order, phases, ends, message)
      !> The family.
      type(rests_type), intent(in) :: s
      !> The motion.
      type(settled_type), intent(in) :: start
      !> As of `read_events`.
      real(wp), intent(in) :: scale
      integer, intent(in) :: most_symbols
      !> In and out: numbers of events in order, and their load phases (rad).
      integer, allocatable, intent(inout) :: order(:)
      real(wp), allocatable, intent(inout) :: phases(:)
      !> The events at which accumulations end in rest; of other events themselves.
      integer, allocatable, intent(out) :: ends(:)
      !> What is wrong; empty if nothing is.
      character(:), allocatable, intent(inout) :: message
      integer, allocatable :: impacts(:)
      logical :: left(size(order))
      integer :: i, k
      real(wp) :: threshold

      threshold = short
      do
         left = .true.
         ends = order
         do i = 1, size(order)
            if (start%events(order(i))%kind /= stick_event) cycle
            allocate (impacts(0))
            do k = i - 1, 1, -1
               if (.not. is_bounce(order(k), start%events(order(i))%gap)) exit
               if (start%events(order(k))%kind == impact_event) impacts = [k, impacts]
            end do
            if (size(impacts) == 0) then
               message = 'an event of another gap, a stop or friction occurs during an &
                  &accumulation; such motions cannot be followed'
               return
            end if
            k = size(impacts)
            do while (k > 1)
               if (phases(impacts(k)) - phases(impacts(k - 1)) >= threshold*scale) exit
               k = k - 1
            end do
            ! one impact at least comes before
            if (k == 1 .and. size(impacts) > 1) k = 2
            ends(impacts(k)) = order(i)
            left(impacts(k) + 1:i) = .false.
            deallocate (impacts)
         end do
         if (count(left) <= most_symbols .or. threshold > 1.0e3_wp) exit
         threshold = 2*threshold
      end do
      order = pack(order, left)
      phases = pack(phases, left)
      ends = pack(ends, left)
   contains
      !> Whether an event is an impact on a gap, or friction along it turns.
      pure logical function is_bounce(number, gap)
         !> The event, and the gap.
         integer, intent(in) :: number, gap

         associate (event => start%events(number))
            is_bounce = event%kind == impact_event .and. event%gap == gap
            if (event%kind == slip_up_event .or. event%kind == slip_down_event) is_bounce = &
               abs(factor_along(s%path%structure, event%gap, gap)) > 0
         end associate
      end function is_bounce
   end subroutine find_accumulations

   !> The ways in which motions with rests can repeat themselves, or be their own mirror images,
   !! half a period later.
   pure subroutine set_repetitions(family, phases, mirrored, message)
      !> In and out: the family.
      type(structure_resting_type), intent(inout) :: family
      !> (0:N) Load phases of the symbols of the motion (rad).
      real(wp), intent(in) :: phases(0:)
      !> Whether they can be their own mirror images, although this one is not.
      logical, intent(out) :: mirrored
      !> Why the motion is not followed; empty if it is.
      character(:), allocatable, intent(inout) :: message
      character(:), allocatable :: turn
      integer, allocatable :: sides(:)
      integer :: m, parts

      mirrored = .false.
      allocate (family%repetitions(0))
      associate (s => family%rests)
         m = size(s%kinds)
         sides = s%path%structure%channel(s%gaps)*s%path%structure%wall(s%gaps)
         if (allocated(s%rows)) sides = s%rows*s%walls
         do parts = 2, m
            if (modulo(m, parts) > 0) cycle
            if (any(s%kinds /= cshift(s%kinds, m/parts))) cycle
            associate (step => m/parts, next => cshift(sides, m/parts))
               mirrored = parts == 2 .and. modulo(s%cycles, 2) == 1 .and. all(sides == -next) &
                  .and. is_odd(s%path)
               if (.not. mirrored .and. (any(sides /= next) .or. (modulo(s%cycles, parts) > 0 &
                  .and. .not. s%free))) cycle
               if (any(abs(phases(step:) - phases(:m - step) - 2*pi*s%cycles/parts) > same)) then
                  if (parts == 2) family%repetitions = [repetition_type(step, merge(-1.0_wp, &
                     1.0_wp, mirrored), pi*s%cycles)]
               else if (mirrored) then
                  mirrored = .false.
               else
                  turn = counted(s%cycles, 'load cycle')
                  if (s%free) turn = 'period'
                  message = 'the motion repeats itself within its '//turn//'; start from the &
                     &shorter period'
                  return
               end if
               if (parts == 2) exit
            end associate
         end do
      end associate
   end subroutine set_repetitions

   !> The symbols of a motion with rests, in order from after a release.
   subroutine read_symbols(s, start, scale, most_symbols, phases, impacts, message)
      !> In and out: the family; symbols and the gaps that rest at the beginning are set.
      type(rests_type), intent(inout) :: s
      !> The motion.
      type(settled_type), intent(in) :: start
      !> The shortest time scale, as a load phase (rad).
      real(wp), intent(in) :: scale
      !> Most symbols.
      integer, intent(in) :: most_symbols
      !> (0:N) Load phases of the symbols (rad), that of the last one also at the beginning.
      real(wp), allocatable, intent(out) :: phases(:)
      !> (N) The impact of the motion that each symbol is; 0 for a release.
      integer, allocatable, intent(out) :: impacts(:)
      !> What is wrong; empty if nothing is.
      character(:), allocatable, intent(out) :: message
      !> Events nearer than this (rad) are at one instant.
      real(wp), parameter :: instant = 1.0e-8_wp
      real(wp), allocatable :: at(:)
      integer, allocatable :: kind(:), gap(:), number(:), order(:), left(:), resting(:)
      real(wp) :: longest, threshold, whole
      integer :: begin, i, j, k, m, n, last

      message = ''
      whole = 2*pi*s%cycles
      n = size(start%gaps)
      m = size(start%resting)
      ! all events; sticks have kind 0
      at = [start%motion%phases, start%rests(1, :), start%rests(2, :)]
      kind = [spread(single, 1, n), spread(0, 1, m), spread(release, 1, m)]
      gap = [start%gaps, start%resting, start%resting]
      number = [(i, i=1, n), spread(0, 1, 2*m)]
      at = start%motion%phases(1) + modulo(at - start%motion%phases(1), whole)
      allocate (order(size(at)))
      do i = 1, size(at)
         order(i) = count(at < at(i)) + count(.not. (at(:i) < at(i) .or. at(:i) > at(i)))
      end do
      at(order) = at
      kind(order) = kind
      gap(order) = gap
      number(order) = number
      n = size(at)
      ! of all releases, the one with the longest flight after it begins the period
      begin = 0
      longest = 0
      do i = 1, n
         if (kind(i) /= release) cycle
         associate (flight => modulo(at(modulo(i, n) + 1) - at(i), whole))
            if (flight <= longest) cycle
            longest = flight
            begin = i
         end associate
      end do
      if (begin == 0) then
         message = 'a rest never ends'
         return
      end if
      at = [at(begin + 1:), at(:begin) + whole]
      kind = cshift(kind, begin)
      gap = cshift(gap, begin)
      number = cshift(number, begin)
      ! the gaps that rest then: their last change before is that they began to
      resting = [integer ::]
      do i = minval(gap), maxval(gap)
         k = findloc(gap == i .and. kind /= single, .true., dim=1, back=.true.)
         if (k == 0) cycle
         if (kind(k) == 0) resting = [resting, i]
      end do
      threshold = short
      do
         left = [(1, i=1, n)]
         s%kinds = kind
         do i = 1, n
            if (kind(i) /= 0) cycle
            ! back to the first impact whose accumulation is simulated
            do k = i - 1, 1, -1
               if (kind(k) /= single .or. gap(k) /= gap(i)) exit
            end do
            j = i - 1
            do while (j - 1 > k .and. at(max(1, j)) - at(max(1, j - 1)) < threshold*scale)
               j = j - 1
            end do
            ! one impact at least comes before
            if (j == k + 1 .and. j < i - 1) j = j + 1
            if (j < k + 1) then
               message = 'an event of another gap occurs during an accumulation; such motions &
                  &cannot be followed'
               return
            end if
            s%kinds(j) = first
            left(j + 1:i) = 0
         end do
         last = count(left > 0)
         if (last <= most_symbols .or. threshold > 1.0e3_wp) exit
         threshold = 2*threshold
      end do
      if (last > most_symbols) then
         message = 'the motion has '//counted(last, 'impact, accumulation or release')// &
            '; at most '//whole_text(most_symbols)//' can be followed'
         return
      end if
      do i = 1, n
         j = modulo(i, n) + 1
         if (at(j) - at(i) + merge(whole, 0.0_wp, j == 1) > instant) cycle
         ! without restitution a rest begins at its impact
         if (kind(i) == single .and. kind(j) == 0 .and. gap(i) == gap(j)) cycle
         if (left(i) == 0 .and. left(j) == 0) cycle
         message = 'two events occur at the same instant; such motions with rests cannot be &
            &followed'
         return
      end do
      s%kinds = pack(s%kinds, left > 0)
      s%gaps = pack(gap, left > 0)
      impacts = pack(number, left > 0)
      allocate (s%closed(0:last))
      s%closed(0) = closed_type(resting)
      do i = 1, last
         if (s%kinds(i) == first) resting = [pack(resting, resting < s%gaps(i)), s%gaps(i), &
            pack(resting, resting > s%gaps(i))]
         if (s%kinds(i) == release) resting = pack(resting, resting /= s%gaps(i))
         s%closed(i) = closed_type(resting)
      end do
      phases = [at(n) - whole, pack(at, left > 0)]
      phases = phases - 2*pi*floor(phases(2)/(2*pi))
   end subroutine read_symbols

   !> Adds the symmetry other than the mirror that exchanges both halves of the impacts, if there is
   !! one.
   subroutine add_symmetry(gaps, s, family, repetitions)
      !> The gaps of the impacts.
      integer, intent(in) :: gaps(:)
      !> In and out: the structure, without a symmetry; its displacements become even and odd ones.
      type(structure_members_type), intent(inout) :: s
      !> In and out: the impacts; sides of opposite sign are then those of exchanged gaps.
      type(family_type), intent(inout) :: family
      !> In and out: the ways in which a motion can repeat itself; the symmetry becomes the first.
      type(repetition_type), allocatable, intent(inout) :: repetitions(:)
      type(repetition_type), allocatable :: others(:)
      real(wp), allocatable :: matrix(:, :)
      integer, allocatable :: image(:)
      integer :: i

      if (mod(size(gaps), 2) /= 0) return
      call find_symmetry(s%path, gaps, cshift(gaps, size(gaps)/2), family%cycles, matrix, image)
      if (.not. allocated(matrix)) return
      call move_alloc(matrix, s%symmetry)
      call even_and_odd(s%path%structure%mass, s%symmetry, s%free, s%even)
      deallocate (s%gap_of)
      allocate (s%gap_of(-size(image):size(image)), source=0)
      do i = 1, size(image)
         s%gap_of([-i, i]) = [image(i), i]
      end do
      associate (half => size(gaps)/2)
         do i = 1, half
            family%sides(i) = findloc(s%gap_of, gaps(i), dim=1) + lbound(s%gap_of, 1) - 1
         end do
         ! a gap that is its own image has both sides
         family%sides(half + 1:) = -family%sides(:half)
         allocate (others, source=repetitions)
         deallocate (repetitions)
         allocate (repetitions(size(others) + 1))
         repetitions(1) = repetition_type(half, -1.0_wp, pi*family%cycles, s%even, &
            halves=.true.)
         repetitions(2:) = others
      end associate
   end subroutine add_symmetry

   !> Checks that each crossing of the unit circle by disturbances that part impacts at one instant
   !! will be seen.
   pure subroutine check_parting(s, family, unknowns, shares, message)
      !> The structure.
      type(structure_members_type), intent(in) :: s
      !> The impacts.
      type(family_type), intent(in) :: family
      !> The motion at the start, and the parameters there as shares.
      real(wp), intent(in) :: unknowns(:), shares(:)
      !> In and out: what is wrong, if anything is.
      character(:), allocatable, intent(inout) :: message
      type(member_type) :: member
      complex(wp), allocatable :: multipliers(:)
      logical :: good

      call set_member(s, family, unknowns, shares, member)
      if (.not. member%exists) return
      call set_flights(family, member)
      call multipliers_beside(s, member, multipliers, good)
      if (.not. good) return
      if (are_multiple(multipliers)) message = 'gaps close at the same instant, and several &
         &multipliers of disturbances that separate these impacts are always equal, as for three &
         &equal units; such motions cannot be followed'
   end subroutine check_parting

   !> Moves a bound at which there are no motions of the family a little inwards.
   pure subroutine avoid_resonance(s, family, unknowns, shares, bound)
      !> The structure.
      type(structure_members_type), intent(in) :: s
      !> The impacts.
      type(family_type), intent(in) :: family
      !> The motion at the start, and the parameters there as shares.
      real(wp), intent(in) :: unknowns(:), shares(:)
      !> In and out: the bound.
      type(condition_type), intent(inout) :: bound
      type(member_type) :: member
      real(wp) :: place(size(shares))

      place = shares
      place(bound%index) = bound%bound
      call set_member(s, family, unknowns, place, member)
      if (.not. member%exists) bound%bound = bound%bound + bound%side*inset
   end subroutine avoid_resonance

   !> The load phases of the impacts of a period at a point of a curve, which are continuous along
   !! it.
   pure function phases_at(curve, point) result(phases)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> The point.
      real(wp), intent(in) :: point(:)
      real(wp), allocatable :: phases(:), whole(:)

      allocate (whole, source=curve%family%whole_of(unknowns_of(curve, point)))
      allocate (phases, source=whole(size(whole)/2 + 1:))
   end function phases_at

   !> The period of a self-excited motion at a point of a curve; 0 of others.
   pure real(wp) function period_at(curve, point) result(period)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> The point.
      real(wp), intent(in) :: point(:)

      period = 0
      select type (known => curve%family)
      type is (structure_resting_type)
         if (known%rests%free) period = merge(2, 1, known%rests%halved)*known%rests%end_of_turn( &
            unknowns_of(curve, point))/known%rests%path%load%frequency
      end select
   end function period_at

   !> The motion at a point of a curve, with its verdicts.
   pure subroutine motion_at(curve, point, condition, motion, extremes, rests)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> The point.
      real(wp), intent(in) :: point(:)
      !> The condition that is zero there; on a bound the parameter is exactly that bound.
      type(condition_type), intent(in) :: condition
      !> The motion.
      type(structure_motion_type), intent(out) :: motion
      !> (n, 2) Least and greatest value of each coordinate.
      real(wp), intent(out) :: extremes(:, :)
      !> (2, m) Load phases (rad) at which each rest begins and ends.
      real(wp), allocatable, intent(out) :: rests(:, :)
      type(family_type) :: family
      type(member_type) :: member, all
      real(wp), allocatable :: value(:), scale(:)
      real(wp) :: c(n_parameters)
      integer :: n, status

      c = parameters_of(curve, point)
      if (condition%kind == edge) c(condition%index) = condition%bound
      allocate (rests(2, 0))
      select type (known => curve%family)
      type is (structure_resting_type)
         call resting_motion(known, unknowns_of(curve, point), c, condition, motion, extremes, &
            rests)
         if (known%rests%halved) call add_image(known%rests, motion, extremes)
      type is (structure_family_type)
         call set_member(known%members, known%impacts, unknowns_of(curve, point), &
            c(:size(known%members%path%changes)), member, .true.)
         family = known%impacts
         if (allocated(known%members%impact_of)) then
            call set_flights(family, member)
            call whole_member(known%members, member, all)
            member = all
            associate (equations => all%equations)
               call new_equations(all%structure, all%regime, equations%gaps, equations%times, &
                  equations%period, member%equations, status)
            end associate
            family = whole_family(known%members, family)
         end if
         motion%speeds = member%speeds
         n = 2*size(member%speeds) + size(member%offsets)
         allocate (value(n), scale(n))
         call residuals(member%structure, member%equations, member%speeds, member%offsets, value, &
            scale)
         motion%residual = relative(value, scale)
         call describe_structure_motion(member%structure, member%regime, member%equations, &
            member%offsets, motion)
         if (allocated(member%symmetry)) then
            ! the extremes of a motion are not those of its image
            family%sides = whole_sides(known%impacts)
            family%mirror = .false.
         end if
         if (condition%kind == zero_approach) call without_derivative(motion%verdicts)
         call set_flights(family, member)
         call coordinate_extremes(family, member, extremes)
      end select
   end subroutine motion_at

   !> The motion with rests at a point of a curve, with its verdicts.
   pure subroutine resting_motion(family, unknowns, c, condition, motion, extremes, rests)
      !> The family.
      type(structure_resting_type), intent(in) :: family
      !> The unknowns, and the parameters as shares.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> The condition that is zero there; kind 0 if none.
      type(condition_type), intent(in) :: condition
      !> The motion: of its impacts, those that are symbols of the family.
      type(structure_motion_type), intent(out) :: motion
      !> (n, 2) Least and greatest value of each coordinate.
      real(wp), intent(out) :: extremes(:, :)
      !> As in `motion_at`.
      real(wp), allocatable, intent(out) :: rests(:, :)
      type(course_type) :: course
      type(condition_type) :: found(family%condition_count())
      type(spectrum_type) :: spectrum
      real(wp) :: last, values(size(found)), unit(2*size(extremes, 1))
      real(wp), allocatable :: speeds(:)
      integer, allocatable :: impacts(:)
      integer :: i, j, k, m, n
      logical :: good

      associate (s => family%rests)
         n = size(extremes, 1)
         m = size(s%kinds)
         extremes(:, 1) = huge(1.0_wp)
         extremes(:, 2) = -huge(1.0_wp)
         impacts = pack([(i, i=1, m)], s%kinds /= release)
         allocate (rests(2, m - size(impacts)), source=ieee_value(1.0_wp, ieee_quiet_nan))
         motion%phases = family%phases_of(unknowns)
         motion%phases = motion%phases(impacts)
         allocate (motion%verdicts%p(2*n, 2*n), motion%verdicts%multipliers(2*n), &
            motion%states(2*n, size(impacts)))
         call without_derivative(motion%verdicts)
         motion%states = motion%verdicts%p(1, 1)
         motion%speeds = motion%states(1, :)
         motion%impulses = motion%states(1, :)
         motion%residual = huge(1.0_wp)
         call follow_period(s, unknowns, c(:size(s%path%changes)), .true., course)
         if (.not. course%exists) return
         motion%speeds = course%speeds(impacts)
         motion%impulses = course%impulses(impacts)
         motion%residual = maxval(abs(course%residuals))
         do i = 1, course%parts
            associate (part => course%segments(i))
               if (part%duration > 0) call extend_extremes(course%run%regimes(part%regime), &
                  part%x, part%v, part%time, part%duration, extremes)
               j = findloc(impacts, part%symbol, dim=1)
               if (j == 0) cycle
               if (part%number == 1 .or. .not. abs(motion%states(1, j)) <= huge(1.0_wp)) call &
                  state_of(course%run%regimes(part%regime), course%run%load%frequency*part%time, &
                  part%x, part%v, motion%states(:n, j), motion%states(n + 1:, j))
            end associate
         end do
         k = 0
         last = s%end_of_turn(unknowns)
         do i = 1, m
            if (s%kinds(i) /= release) cycle
            k = k + 1
            rests(2, k) = merge(last, unknowns(2*n + 1 + modulo(i, m)), i == m)
            do j = 1, m
               associate (before => modulo(i - j - 1, m) + 1)
                  if (s%kinds(before) /= first .or. s%gaps(before) /= s%gaps(i)) cycle
                  rests(1, k) = course%begins(before)
                  if (before > i) rests(2, k) = rests(2, k) + last - s%begin_of(unknowns)
                  exit
               end associate
            end do
         end do
         ! of a self-excited motion shares of the period
         if (s%free) rests = (s%whole_turn()/last)*rests
         associate (verdicts => motion%verdicts)
            verdicts%consistent = consistency(motion%residual, exact_acceptance)
            call family%set_conditions(unknowns, c, values, found, spectrum)
            verdicts%admissible = unknown
            if (any(values(4:) < 0 .and. .not. (found(4:)%kind == condition%kind .and. &
               found(4:)%index == condition%index))) then
               verdicts%admissible = no
            else if (verdicts%consistent == yes .and. (condition%kind == 0 .or. &
               condition%kind <= neimark_sacker .or. condition%kind == edge)) then
               verdicts%admissible = yes
            end if
            if (condition%kind == zero_approach) return
            if (condition%kind == event_vanishes .or. is_touch_with_preload(s, condition)) then
               ! the instant of the event has no derivative
               i = verdicts%admissible
               call without_derivative(verdicts)
               verdicts%admissible = i
               return
            end if
            unit = [spread(s%length, 1, n), spread(s%speed, 1, n)]
            call monodromy(s, course, verdicts%p, good)
            if (.not. good) call without_derivative(verdicts)
            if (.not. good) return
            do i = 1, 2*n
               verdicts%p(:, i) = unit*verdicts%p(:, i)/unit(i)
            end do
            verdicts%multipliers = 0
            verdicts%law = course%volume
            if (s%halved) then
               ! the second half is the image of the first one
               verdicts%p = matmul(verdicts%p, verdicts%p)
               verdicts%law = course%volume**2
            end if
            ! as of a motion found by simulation, see vi_structure_return
            speeds = pack(abs(course%speeds), s%kinds < release)
            if (size(speeds) == 0) speeds = [s%speed]
            call assess_multipliers(1.0e-12_wp*max(1.0_wp, maxval(speeds)/max(tiny(1.0_wp), &
               minval(speeds))), verdicts, s%free)
         end associate
      end associate
   end subroutine resting_motion

   !> Whether a stop with a preload is only just touched, or left: its force jumps there, and a
   !! multiplier is infinite, as where a rigid wall is only just touched.
   pure logical function is_touch_with_preload(s, condition) result(is_one)
      !> The family.
      type(rests_type), intent(in) :: s
      !> The condition that is zero; kind 0 if none.
      type(condition_type), intent(in) :: condition

      is_one = condition%kind == contact_vanishes .or. condition%kind == flight_vanishes
      if (is_one) is_one = abs(s%path%structure%laws(s%gaps(condition%index))%numbers(3)) > 0
   end function is_touch_with_preload

   !> Adds the second half of a motion that is its own mirror image, by its events and extremes.
   pure subroutine add_image(s, motion, extremes)
      !> The family.
      type(rests_type), intent(in) :: s
      !> In: half a period, with the verdicts on the whole. Out: the whole.
      type(structure_motion_type), intent(inout) :: motion
      !> (n, 2) In: the extremes of the half. Out: those of the whole.
      real(wp), intent(inout) :: extremes(:, :)
      real(wp), allocatable :: states(:, :)
      integer :: m

      m = size(motion%phases)
      allocate (states(size(motion%states, 1), 2*m))
      states(:, :m) = motion%states
      ! that of the last symbol is the one just after its image, which begins the half
      states(:, m) = -states(:, m)
      states(:, m + 1:) = -states(:, :m)
      call move_alloc(states, motion%states)
      motion%phases = [motion%phases, motion%phases + s%whole_turn()]
      motion%speeds = [motion%speeds, motion%speeds]
      motion%impulses = [motion%impulses, motion%impulses]
      extremes = reshape([min(extremes(:, 1), -extremes(:, 2)), max(extremes(:, 2), &
         -extremes(:, 1))], shape(extremes))
   end subroutine add_image

   !> The verdicts on a motion where an impact has no approach speed: it is not an impact, and the
   !! period has no derivative. The computed one contains a rounding error divided by another.
   pure subroutine without_derivative(verdicts)
      !> In and out: the verdicts.
      type(structure_verdicts_type), intent(inout) :: verdicts

      verdicts%p = ieee_value(1.0_wp, ieee_quiet_nan)
      verdicts%multipliers = cmplx(verdicts%p(:, 1), 0.0_wp, wp)
      verdicts%determinant = verdicts%p(1, 1)
      verdicts%stable = unknown
      if (verdicts%consistent == yes) verdicts%admissible = no
   end subroutine without_derivative

   !> The unknowns of a motion.
   subroutine unknowns_of_motion(s, family, regime, found, shares, unknowns)
      !> The structure, with its units.
      type(structure_members_type), intent(in) :: s
      !> The impacts.
      type(family_type), intent(in) :: family
      !> The regime at the start.
      type(regime_type), intent(in) :: regime
      !> The motion.
      type(settled_type), intent(in) :: found
      !> The parameters at the start.
      real(wp), intent(in) :: shares(:)
      !> The unknowns.
      real(wp), allocatable, intent(out) :: unknowns(:)
      type(member_type) :: member
      real(wp), dimension(size(regime%modes%stiffness)) :: x, v
      real(wp) :: shift(s%p, 1)
      integer :: pairs(s%p), n, status

      n = size(found%gaps)
      allocate (unknowns(2*n + s%p), source=0.0_wp)
      unknowns(:n) = sign(1, family%sides)*found%motion%speeds/s%speed
      unknowns(n + 1:2*n) = found%motion%phases
      if (s%p == 0) return
      ! at the start the displacements are those of the modes themselves, but for their unit
      call set_member(s, family, unknowns, shares, member)
      if (.not. member%exists) return
      call set_flights(family, member)
      associate (state => found%motion%states(:, 1))
         call to_pairs(regime, found%motion%phases(1), state(:size(x)), state(size(x) + 1:), x, v)
      end associate
      pairs = offset_pairs(regime)
      shift(:, 1) = x(pairs) - member%x_after(pairs, 1)
      if (allocated(s%symmetry)) then
         call solve_columns(member%turn, shift, status)
         if (status == stat%ok) unknowns(2*n + 1:) = shift(:, 1)
      else
         unknowns(2*n + 1:) = maxval(abs(regime%qx(:, pairs)), dim=1)*shift(:, 1)/s%length
      end if
   end subroutine unknowns_of_motion

end module vi_structure_start
