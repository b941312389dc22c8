!> The attractors at a point (r, D), and the initial states in the basin of each.
module vi_attractor_list
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_attractor_basin, only: decide, event_limited, not_reached
   use vi_attractor_cells, only: group_type, owner_of
   use vi_attractor_known, only: alike, chaotic, identify, is_free, known_type, no_impacts, &
      periodic, quasi_periodic, repeating, shortest_period, within
   use vi_attractor_neighbourhood, only: find_neighbourhoods
   use vi_attractor_target, only: target_state, target_type
   use vi_attractor_wandering, only: find_cells, group_of, measure_kind, search_near
   use vi_chains, only: settle_chains
   use vi_event_symbols, only: symbol_endings
   use vi_forced_system, only: event_type, forced_system_type, initial_state, state_type
   use vi_kinds, only: wp
   use vi_simulate, only: simulate_cycles
   use vi_simulated_motion, only: cell_type, examination_type
   use vi_simulated_pair, only: new_pair_chains, pair_chains_type
   use vi_status, only: stat
   use vi_progress, only: add_done_work, add_expected_work, is_stopped
   implicit none (type, external)
   private

   public :: label_states

   !> Largest number of attractors: without damping every state may have its own.
   integer, parameter :: most_attractors = 1000
   !> Largest number of rounds of a search for motions, and the least share of the states that a
   !! round must decide for another round to follow.
   integer, parameter :: rounds = 16
   real(wp), parameter :: lively = 0.02_wp
   !> States that are described at a time, and impacts kept of each.
   integer, parameter :: block = 2000, impacts_kept = 200
   !> Largest number of attractors that are not periodic; states that are followed without a
   !! decision
   !! before the others are left undecided too.
   integer, parameter :: most_groups = 30, most_undecided = 8
   !> Load cycles of the first average of a state that is followed, which doubles from one to the
   !! next, and those after which it is left undecided; decay of a disturbance, as a logarithm, by
   !! which a motion that is approached must have been reached.
   integer, parameter :: first_average = 4000, most_followed = 200000
   !> Events for which a motion that seems chaotic or quasi-periodic must go on, and its most load
   !! cycles: a chaotic transient ends at random. Other states in the same cells that are watched
   !! as long again, all together.
   real(wp), parameter :: watched = 2.0e6_wp
   integer, parameter :: watched_cycles = 4000000, most_peers = 7
   real(wp), parameter :: decay = 40
   !> Least units of work that stand for the states that are followed and watched.
   integer, parameter :: least_room = 8
   !> Load cycles after which a motion that repeats itself to rounding, but is not confirmed, counts
   !! as
   !! an attractor of its own.
   integer, parameter :: least_repeated = 12000

   !> The attractors known so far, and the settings of the search.
   type, public :: attractor_list_type
      type(forced_system_type) :: system
      !> Longest period considered, in load cycles; largest number of events of a simulation; number
      !! of OpenMP threads.
      integer :: max_cycles = 16, max_events = 10000000, threads = 1
      integer :: n = 0
      type(known_type), allocatable :: known(:)
      !> Cells of the attractors that are not periodic, and those of transients.
      type(group_type), allocatable :: groups(:), transients(:)
   end type attractor_list_type

contains

   !> The attractor of each state (or its label as in `decide`), numbered by decreasing share of the
   !! states.
   subroutine label_states(list, starts, cycles, probes, labels, events, progress)
      !> In: system, longest period and threads.
      type(attractor_list_type), intent(inout) :: list
      !> (5, m): t, x, x', z, z'
      real(wp), intent(in) :: starts(:, :)
      !> Load cycles within which a state should be decided, and number of states simulated first.
      integer, intent(in) :: cycles, probes
      !> (m) Number of the attractor, 0, `event_limited` or `not_reached`.
      integer, intent(out) :: labels(:)
      !> Number of events simulated to decide.
      real(wp), intent(out) :: events
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      real(wp), allocatable :: ends(:, :), after(:, :)
      integer, allocatable :: open_ones(:), found(:), counts(:)
      integer :: i, known, room, round

      ! how long motions must be watched is not known before: the bar leaves room for it
      room = max(least_room, size(labels)/8)
      allocate (list%known(most_attractors), list%groups(0), list%transients(0))
      labels = 0
      events = 0
      allocate (ends, source=starts)
      allocate (open_ones, source=[(i, i=1, size(labels))])
      call add_expected_work(size(labels) + room, progress)
      call discover(list, starts(:, some(size(labels), probes)), cycles/2, progress)
      do round = 1, rounds
         allocate (found(size(open_ones)), counts(size(open_ones)), after(5, size(open_ones)))
         call decide_known(list, ends, cycles, found, counts, after, progress)
         events = events + sum(real(counts, wp))
         labels(open_ones) = merge(0, found, found == not_reached .and. round > 1)
         call keep_open(found, after, open_ones, ends)
         known = count(found > 0)
         deallocate (found, counts, after)
         if (is_stopped(progress) .or. size(open_ones) == 0) exit
         i = list%n
         call discover(list, ends(:, some(size(open_ones), 2*probes)), 0, progress)
         if (list%n == i .and. .not. known > lively*(known + size(open_ones))) exit
         call add_expected_work(size(open_ones), progress)
      end do
      call examine(list, ends, cycles*min(round, rounds), labels, open_ones, progress)
      call order_by_share(list, labels)
      call add_done_work(room, progress)
   end subroutine label_states

   !> Some of n places, spread evenly and without repetition.
   pure function some(n, wanted) result(places)
      !> Number of places, and how many of them are wanted.
      integer, intent(in) :: n, wanted
      integer, allocatable :: places(:)
      integer :: i, m

      m = min(n, wanted)
      allocate (places(m))
      places = [(1 + int(real(i, wp)*(n - 1)/max(1, m - 1)), i=0, m - 1)]
   end function some

   !> Keeps only the undecided states, with their present values.
   pure subroutine keep_open(found, after, open_ones, ends)
      !> (m) Number of the attractor of each state, or its label as in `decide`.
      integer, intent(in) :: found(:)
      !> (5, m) The states at the end of the simulation.
      real(wp), intent(in) :: after(:, :)
      !> In: numbers (m) of the states among all. Out: those of the states kept.
      integer, allocatable, intent(inout) :: open_ones(:)
      !> Out: (5, states kept).
      real(wp), allocatable, intent(inout) :: ends(:, :)
      integer, allocatable :: still(:), left(:)
      integer :: i

      still = pack([(i, i=1, size(found))], found <= 0 .and. found /= event_limited)
      left = open_ones(still)
      call move_alloc(left, open_ones)
      deallocate (ends)
      allocate (ends(5, size(still)))
      ends = after(:, still)
   end subroutine keep_open

   !> Simulates states until they have settled.
   subroutine find_ends(list, starts, settling, points, found, progress)
      !> System, longest period, limit of events and threads are read.
      type(attractor_list_type), intent(in) :: list
      !> (5, m): t, x, x', z, z'
      real(wp), intent(in) :: starts(:, :)
      !> Load cycles of the transient, and most impacts that are kept.
      integer, intent(in) :: settling, points
      !> (m) The motions on which the states settle.
      type(cell_type), allocatable, intent(out) :: found(:)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(pair_chains_type) :: each

      allocate (found(size(starts, 2)))
      associate (system => list%system)
         each = new_pair_chains(1, size(found), system%load, 0.0_wp)
         each%parameters = spread(reshape([system%r, system%clearance, system%osc%xi, &
            system%osc%mu, system%osc%restitution], [6, 1]), 3, size(found))
         each%starts = starts
         call settle_chains(each, examination_type(settling, 2*list%max_cycles + 1, points, &
            list%max_events, .false.), list%threads, found, progress)
      end associate
   end subroutine find_ends

   !> Adds the periodic motions on which some states settle.
   subroutine discover(list, starts, settling, progress)
      !> In and out: the attractors known so far.
      type(attractor_list_type), intent(inout) :: list
      !> (5, m): t, x, x', z, z'
      real(wp), intent(in) :: starts(:, :)
      !> Load cycles of the transient.
      integer, intent(in) :: settling
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(cell_type), allocatable :: found(:)
      type(known_type) :: new
      integer :: i, j, n, seen(size(starts, 2))
      logical :: good

      call find_ends(list, starts, settling, 0, found, progress)
      n = 0
      do j = 1, size(starts, 2)
         if (found(j)%status /= stat%ok .or. found(j)%cycles == 0 .or. found(j)%impacts == 0 .or. &
            list%n == most_attractors) cycle
         ! a state with the same numbers as an earlier one is on the same motion
         do i = 1, n
            associate (one => found(seen(i)), other => found(j))
               if (one%cycles == other%cycles .and. one%symbols == other%symbols .and. &
                  maxval(abs(one%extent(1, :2) - other%extent(1, :2))) < &
                  1.0e-3_wp*list%system%clearance) exit
            end associate
         end do
         if (i <= n) cycle
         n = n + 1
         seen(n) = j
         call identify(list%system, found(j)%strobes(:, 1), found(j)%cycles, list%threads, new, &
            good, progress)
         if (.not. good) cycle
         do i = 1, list%n
            if (alike(new, list%known(i), list%system%clearance)) exit
         end do
         if (i > list%n) call add(list, new)
      end do
   end subroutine discover

   !> Adds an attractor.
   pure subroutine add(list, new)
      !> In and out: the attractors known so far, with room for one more.
      type(attractor_list_type), intent(inout) :: list
      !> The attractor.
      type(known_type), intent(in) :: new

      list%n = list%n + 1
      list%known(list%n) = new
   end subroutine add

   !> The known periodic motion that each state approaches.
   subroutine decide_known(list, starts, cycles, found, counts, after, progress)
      !> The attractors known so far.
      type(attractor_list_type), intent(in) :: list
      !> (5, m): t, x, x', z, z'
      real(wp), intent(in) :: starts(:, :)
      !> Largest number of load cycles simulated.
      integer, intent(in) :: cycles
      !> (m) Number of the attractor, or the label as in `decide`; (m) events simulated.
      integer, intent(out) :: found(:), counts(:)
      !> (5, m) The states at the end of the simulation.
      real(wp), intent(out) :: after(:, :)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(target_type), allocatable :: targets(:)
      integer, allocatable :: owners(:)
      integer :: i, n

      n = sum([(size(list%known(i)%targets), i=1, list%n)])
      allocate (targets(n), owners(event_limited:n))
      owners(:) = [event_limited, not_reached, (0, i=0, n)]
      n = 0
      do i = 1, list%n
         associate (own => list%known(i)%targets)
            targets(n + 1:n + size(own)) = own
            owners(n + 1:n + size(own)) = i
            n = n + size(own)
         end associate
      end do
      associate (system => list%system)
         call decide(system%osc, system%r, system%load, system%clearance, targets, starts, cycles, &
            list%max_events, list%threads, found, counts, after, progress)
      end associate
      found = owners(found)
   end subroutine decide_known

   !> Determines the attractors of states that approach no known motion.
   !!
   !! One state is followed until it is decided. What is found then may explain the others, once
   !! they
   !! have been simulated for as long.
   subroutine examine(list, ends, simulated, labels, open_ones, progress)
      !> In and out: the attractors known so far.
      type(attractor_list_type), intent(inout) :: list
      !> In: (5, m) t, x, x', z, z' of each. Out: changed.
      real(wp), allocatable, intent(inout) :: ends(:, :)
      !> Load cycles for which they were simulated.
      integer, intent(in) :: simulated
      !> (all states) In and out: the numbers of the attractors of these states are set.
      integer, intent(inout) :: labels(:)
      !> In: (m) the numbers of the states among all. Out: those of states that are not decided.
      integer, allocatable, intent(inout) :: open_ones(:)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      integer, allocatable :: found(:), counts(:)
      real(wp), allocatable :: after(:, :)
      integer :: before, undecided, i, spent

      before = simulated
      undecided = 0
      do
         do i = 1, size(open_ones), block
            if (is_stopped(progress)) return
            associate (last => min(i + block - 1, size(open_ones)))
               call describe(list, ends(:, i:last), labels, open_ones(i:last), progress)
            end associate
         end do
         call drop_decided(labels, open_ones, ends)
         if (size(open_ones) == 0 .or. undecided == most_undecided) return
         call follow_on(list, ends, before, labels(open_ones(1)), spent, progress)
         if (is_stopped(progress)) return
         if (labels(open_ones(1)) == 0) undecided = undecided + 1
         open_ones = open_ones(2:)
         ends = ends(:, 2:)
         if (spent <= before .or. size(open_ones) == 0) cycle
         call add_expected_work(size(open_ones), progress)
         allocate (found(size(open_ones)), counts(size(open_ones)), after(5, size(open_ones)))
         call decide_known(list, ends, spent, found, counts, after, progress)
         labels(open_ones) = merge(0, found, found == not_reached)
         call keep_open(found, after, open_ones, ends)
         deallocate (found, counts, after)
         before = before + spent
      end do
   end subroutine examine

   !> Keeps only the states that are not decided.
   pure subroutine drop_decided(labels, open_ones, ends)
      !> (all states) Numbers of their attractors.
      integer, intent(in) :: labels(:)
      !> In: (m) the numbers of the states among all, 0 for one that cannot be decided. Out: those
      !! of
      !! the states kept.
      integer, allocatable, intent(inout) :: open_ones(:)
      !> In and out: (5, m) their present values.
      real(wp), allocatable, intent(inout) :: ends(:, :)
      integer, allocatable :: still(:)
      integer :: i

      still = pack([(i, i=1, size(open_ones))], open_ones > 0)
      still = pack(still, labels(open_ones(still)) == 0)
      open_ones = open_ones(still)
      ends = ends(:, still)
   end subroutine drop_decided

   !> Determines the attractors of states that have settled, or whose impacts are those of a known
   !! attractor that is not periodic.
   subroutine describe(list, starts, labels, members, progress)
      !> In and out: the attractors known so far.
      type(attractor_list_type), intent(inout) :: list
      !> (5, m): t, x, x', z, z'
      real(wp), intent(in) :: starts(:, :)
      !> (all states) In and out: the numbers of the attractors of these states are set.
      integer, intent(inout) :: labels(:)
      !> (m) In: the numbers of the states among all. Out: 0 for a state whose simulation failed.
      integer, intent(inout) :: members(:)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(cell_type), allocatable :: found(:)
      integer :: j

      call find_ends(list, starts, 0, impacts_kept, found, progress)
      do j = 1, size(members)
         if (found(j)%status == stat%event_limit) labels(members(j)) = event_limited
         if (found(j)%status /= stat%ok) members(j) = 0
         if (members(j) == 0) cycle
         if (found(j)%cycles > 0) then
            call place_settled(list, found(j), labels(members(j)), progress)
         else if (size(found(j)%gaps) > 0) then
            labels(members(j)) = group_of(list%system, found(j)%hits, found(j)%gaps, list%groups)
         end if
      end do
   end subroutine describe

   !> The attractor of a state that has settled; it may be a new one.
   subroutine place_settled(list, found, label, progress)
      !> In and out: the attractors known so far.
      type(attractor_list_type), intent(inout) :: list
      !> The motion on which it has settled; its period is confirmed.
      type(cell_type), intent(in) :: found
      !> The number of the attractor; 0 if there is no room for it.
      integer, intent(out) :: label
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(known_type) :: new
      logical :: good

      label = 0
      associate (end => found%strobes(:, 1), cycles => found%cycles)
         if (found%impacts == 0) then
            call add_free(list, end, label)
            return
         end if
         label = place_of(list, end, cycles)
         if (label > 0 .or. list%n == most_attractors) return
         call identify(list%system, end, cycles, list%threads, new, good, progress)
      end associate
      if (.not. good) return
      call add(list, new)
      label = list%n
   end subroutine place_settled

   !> The attractor without impacts.
   pure subroutine add_free(list, end, label)
      !> In and out: the attractors known so far.
      type(attractor_list_type), intent(inout) :: list
      !> t, x, x', z, z' of a state on it.
      real(wp), intent(in) :: end(5)
      !> Its number; 0 if there is no room for it.
      integer, intent(out) :: label
      type(known_type) :: new

      do label = 1, list%n
         if (list%known(label)%kind == no_impacts) return
      end do
      new%kind = no_impacts
      new%state = within(end, list%system%clearance)
      call add_described(list, new, label)
   end subroutine add_free

   !> Follows one state until its attractor is known.
   !!
   !! Motions near it are looked for by Newton's method. Where it does not reach one, the kind of
   !! its
   !! attractor follows from its largest exponent, as soon as this is certain.
   subroutine follow_on(list, starts, before, label, spent, progress)
      !> In and out: the attractors known so far.
      type(attractor_list_type), intent(inout) :: list
      !> (5, m) t, x, x', z, z' of the state, and of others that are not decided.
      real(wp), intent(in) :: starts(:, :)
      !> Load cycles for which they were simulated.
      integer, intent(in) :: before
      !> The number of the attractor, `event_limited`, or 0 if it cannot be decided.
      integer, intent(out) :: label
      !> Load cycles for which states with the same attractor may have to be simulated.
      integer, intent(out) :: spent
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(known_type) :: motion, new
      type(state_type) :: state
      real(wp) :: end(5)
      integer(int64) :: first
      integer :: average, kind, left, lost, repeats, status, settling
      logical :: good, settled

      label = 0
      spent = 0
      left = list%max_events
      lost = left
      settled = .false.
      average = first_average
      end = within(starts(:, 1), list%system%clearance)
      do while (spent + average <= most_followed)
         state = initial_state(list%system, end)
         first = state%cycle
         call search_near(list%system, state, list%max_cycles, left, motion, good, repeats, &
            status, progress)
         end = numbers_of(list%system, state)
         if (status == stat%ok .and. is_free(list%system, state)) then
            call add_free(list, end, label)
            spent = max(spent, int(state%cycle - first))
         end if
         if (status == stat%ok .and. good) call approach(list, motion, end, left, spent, label, &
            progress)
         ! it is on what is not looked for, such as a longer period
         if (settled .and. label == 0 .and. repeats == 0 .and. status == stat%ok) then
            spent = 0
            return
         end if
         if (label == 0 .and. status == stat%ok) then
            state = initial_state(list%system, end)
            lost = left
            call measure_kind(list%system, state, average, before + spent, left, kind, &
               new%largest, settling, status, progress)
            spent = spent + average
            end = numbers_of(list%system, state)
            ! the impacts may have ended meanwhile
            if (status == stat%no_motion) status = stat%ok
         end if
         if (status == stat%event_limit .or. left <= 0) label = event_limited
         if (is_stopped(progress)) return
         if (status /= stat%ok .or. label /= 0) return
         if (any(kind == [chaotic, quasi_periodic])) then
            ! here, where there are impacts: it may end in a phase without them
            new%state = end
            new%kind = kind
            call watch(list, new, starts(:, 2:), int(min(real(watched_cycles, wp), min(watched, &
               1.0_wp*left)*average/max(1, lost - left))), settling, left, spent, label, progress)
            return
         end if
         if (repeats > 0 .and. before + spent > least_repeated) then
            call add_repeating(list, state, repeats, left, label, progress)
            return
         end if
         settled = kind == periodic
         average = 2*average
      end do
   end subroutine follow_on

   !> Simulates a state until it has reached a motion near it, or has certainly missed it.
   subroutine approach(list, motion, end, left, spent, label, progress)
      !> In and out: the attractors known so far; the motion is added.
      type(attractor_list_type), intent(inout) :: list
      !> In: the motion. Out: with its neighbourhoods, if it is new.
      type(known_type), intent(inout) :: motion
      !> In: t, x, x', z, z'. Out: at the end.
      real(wp), intent(inout) :: end(5)
      !> In and out: events that the simulation may still have, and load cycles simulated.
      integer, intent(inout) :: left, spent
      !> The number of the attractor that was reached, `event_limited`, or 0.
      integer, intent(out) :: label
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      integer :: i

      label = 0
      do i = 1, list%n
         if (alike(motion, list%known(i), list%system%clearance)) exit
      end do
      if (i > most_attractors) return
      if (i > list%n) then
         associate (system => list%system)
            call find_neighbourhoods(system%osc, system%r, system%load, system%clearance, &
               motion%targets, list%threads, progress)
            ! the state may still be far from it
            motion%state = numbers_of(system, target_state(system, motion%targets(1), [0.0_wp, &
               0.0_wp, 0.0_wp, 0.0_wp]))
         end associate
         call add(list, motion)
      end if
      call wait_for(list, end, min(most_followed, ceiling(min(1.0e9_wp, decay*motion%cycles/ &
         max(tiny(decay), -log(motion%largest))))), left, spent, label, progress)
   end subroutine approach

   !> Simulates a state until it has reached a known motion; finally tests whether it is on another
   !! one.
   subroutine wait_for(list, end, cycles, left, spent, label, progress)
      !> In and out: the attractors known so far.
      type(attractor_list_type), intent(inout) :: list
      !> In: t, x, x', z, z'. Out: at the end.
      real(wp), intent(inout) :: end(5)
      !> Largest number of load cycles.
      integer, intent(in) :: cycles
      !> In and out: events that the simulation may still have, and load cycles simulated.
      integer, intent(inout) :: left, spent
      !> The number of the attractor that was reached, `event_limited`, or 0.
      integer, intent(out) :: label
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(cell_type), allocatable :: found(:)
      real(wp) :: ends(5, 1)
      integer :: labels(1), counts(1)

      call decide_known(list, reshape(end, [5, 1]), cycles, labels, counts, ends, progress)
      left = left - counts(1)
      spent = spent + cycles
      label = labels(1)
      if (label == not_reached) label = 0
      if (label /= 0) return
      ! it may lie on a motion without a neighbourhood
      call find_ends(list, ends, 0, 0, found, progress)
      if (found(1)%status == stat%ok .and. found(1)%cycles > 0) call place_settled(list, found(1), &
         label, progress)
      end = within(ends(:, 1), list%system%clearance)
   end subroutine wait_for

   !> Watches a motion that is not periodic, and adds its attractor, unless its impacts are those of
   !! a known one.
   !!
   !! It may be a transient, which ends at random: then other states in the same cells may settle
   !! even if this one does not.
   subroutine watch(list, new, others, cycles, settling, left, spent, label, progress)
      !> In and out: the attractors known so far.
      type(attractor_list_type), intent(inout) :: list
      !> The attractor, with a state on it.
      type(known_type), intent(inout) :: new
      !> (5, m) t, x, x', z, z' of other states that are not decided.
      real(wp), intent(in) :: others(:, :)
      !> Load cycles for which it is watched, and after which any motion nearby has settled.
      integer, intent(in) :: cycles, settling
      !> In and out: events that the simulation may still have, and load cycles simulated.
      integer, intent(inout) :: left, spent
      !> The number of the attractor that was reached; 0 if it is not decided, or `event_limited`.
      integer, intent(out) :: label
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(group_type) :: own
      type(state_type) :: state
      real(wp) :: end(5)
      integer :: known, status

      label = 0
      state = initial_state(list%system, new%state)
      call find_cells(list%system, state, left, list%groups, own, known, status, progress)
      if (status == stat%event_limit) label = event_limited
      if (status /= stat%ok) return
      end = new%state
      call wait_for(list, end, cycles, left, spent, label, progress)
      if (is_stopped(progress) .or. label == event_limited) return
      if (label == 0 .and. owner_of(own, list%transients) == 0) then
         label = known
         if (label > 0) return
         if (.not. peers_settle(list, own, others, cycles, progress)) then
            spent = settling
            if (.not. is_stopped(progress)) call add_group(list, new, own, label)
            return
         end if
      end if
      own%owner = 1
      call append(list%transients, own)
   end subroutine watch

   !> Whether other states with impacts in the same cells settle.
   logical function peers_settle(list, own, others, cycles, progress) result(settle)
      !> The attractors known so far.
      type(attractor_list_type), intent(in) :: list
      !> The cells.
      type(group_type), intent(in) :: own
      !> (5, m) t, x, x', z, z' of states that are not decided.
      real(wp), intent(in) :: others(:, :)
      !> Load cycles for which they are watched all together.
      integer, intent(in) :: cycles
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(cell_type), allocatable :: found(:)
      type(group_type) :: groups(1)
      real(wp), allocatable :: after(:, :), peers(:, :)
      integer, allocatable :: counts(:), labels(:), places(:)
      integer :: i

      settle = .false.
      allocate (places, source=some(size(others, 2), 2*most_peers))
      if (size(places) == 0) return
      groups(1) = own
      groups%owner = 1
      allocate (peers(5, size(places)))
      peers = others(:, places)
      call find_ends(list, peers, 0, impacts_kept, found, progress)
      places = pack([(i, i=1, size(places))], [(group_of(list%system, found(i)%hits, &
         found(i)%gaps, groups) == 1, i=1, size(places))])
      places = places(:min(size(places), most_peers))
      if (is_stopped(progress)) return
      if (size(places) == 0) return
      allocate (labels(size(places)), counts(size(places)), after(5, size(places)))
      call decide_known(list, peers(:, places), cycles/size(places), labels, counts, after, &
         progress)
      settle = any(labels > 0)
      if (settle) return
      ! it may be on a motion that is not known yet
      call find_ends(list, after, 0, 0, found, progress)
      settle = any(found%status == stat%ok .and. found%cycles > 0)
   end function peers_settle

   !> Adds an attractor that is not periodic, if there is room.
   subroutine add_group(list, new, own, label)
      !> In and out: the attractors known so far.
      type(attractor_list_type), intent(inout) :: list
      !> The attractor, with a state on it.
      type(known_type), intent(inout) :: new
      !> Its cells.
      type(group_type), intent(inout) :: own
      !> Its number; 0 if there is no room.
      integer, intent(out) :: label

      label = 0
      if (size(list%groups) == most_groups) return
      call add_described(list, new, label)
      own%owner = label
      call append(list%groups, own)
   end subroutine add_group

   !> Adds a group to others; gfortran 12 would damage an array constructor of groups.
   pure subroutine append(groups, own)
      !> In and out: the groups.
      type(group_type), allocatable, intent(inout) :: groups(:)
      !> The group.
      type(group_type), intent(in) :: own
      type(group_type), allocatable :: more(:)

      allocate (more(size(groups) + 1))
      more(:size(groups)) = groups
      more(size(more)) = own
      call move_alloc(more, groups)
   end subroutine append

   !> The state as t, x, x', z, z'.
   pure function numbers_of(system, state) result(numbers)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state.
      type(state_type), intent(in) :: state
      real(wp) :: numbers(5)

      numbers = within([state%phase/system%r, state%x, state%x_dot, state%z, state%z_dot], &
         system%clearance)
   end function numbers_of

   !> The number of the known periodic motion on which a state lies, although the simulation has not
   !! reached its neighbourhood; 0 if there is none.
   pure integer function place_of(list, end, cycles) result(i)
      !> The attractors known so far.
      type(attractor_list_type), intent(in) :: list
      !> t, x, x', z, z'
      real(wp), intent(in) :: end(5)
      !> Load cycles of the period with which the state repeats itself.
      integer, intent(in) :: cycles
      type(known_type) :: motion
      logical :: good

      call shortest_period(list%system, end, cycles, motion, good)
      do i = merge(list%n, 0, good), 1, -1
         if (alike(motion, list%known(i), list%system%clearance)) return
      end do
   end function place_of

   !> Adds an attractor that has no neighbourhood, if there is room.
   pure subroutine add_described(list, new, label)
      !> In and out: the attractors known so far.
      type(attractor_list_type), intent(inout) :: list
      !> The attractor; its arrays are allocated if they are not yet.
      type(known_type), intent(inout) :: new
      !> Its number; 0 if there is no room.
      integer, intent(out) :: label

      label = 0
      if (list%n == most_attractors) return
      if (.not. allocated(new%targets)) allocate (new%targets(0))
      if (.not. allocated(new%symbols)) allocate (new%symbols(0))
      call add(list, new)
      label = list%n
   end subroutine add_described

   !> Adds an attractor that repeats itself although no stable motion is confirmed, unless one with
   !! as many load cycles and symbols is known.
   subroutine add_repeating(list, state, cycles, left, label, progress)
      !> In and out: the attractors known so far.
      type(attractor_list_type), intent(inout) :: list
      !> In: a state on it. Out: a period later.
      type(state_type), intent(inout) :: state
      !> Load cycles of its period.
      integer, intent(in) :: cycles
      !> In and out: events that the simulation may still have.
      integer, intent(inout) :: left
      !> Its number; 0 if it is not decided.
      integer, intent(out) :: label
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      integer, parameter :: room = 2048
      type(event_type), allocatable :: events(:)
      type(known_type) :: new
      integer :: n, status

      label = 0
      new%kind = repeating
      new%cycles = cycles
      new%state = numbers_of(list%system, state)
      allocate (events(room))
      call simulate_cycles(list%system, state, cycles, left, events, n, status, progress)
      if (status /= stat%ok) return
      allocate (new%symbols(count(symbol_endings(events(:n), .true.) /= 0)), source=0)
      do label = 1, list%n
         associate (known => list%known(label))
            if (known%kind == repeating .and. known%cycles == cycles .and. size(known%symbols) == &
               size(new%symbols)) return
         end associate
      end do
      call add_described(list, new, label)
   end subroutine add_repeating

   !> Renumbers the attractors by decreasing share; those that no state approaches are removed.
   subroutine order_by_share(list, labels)
      !> In and out: the attractors.
      type(attractor_list_type), intent(inout) :: list
      !> In and out: the number of the attractor of each state.
      integer, intent(inout) :: labels(:)
      type(known_type), allocatable :: sorted(:)
      integer :: counts(list%n), place(event_limited:list%n), i, n

      do i = 1, list%n
         counts(i) = count(labels == i)
      end do
      place = [event_limited, not_reached, (0, i=0, list%n)]
      allocate (sorted(list%n))
      do n = 1, list%n
         i = maxloc(counts, 1)
         if (counts(i) <= 0) exit
         sorted(n) = list%known(i)
         place(i) = n
         counts(i) = 0
      end do
      list%n = n - 1
      list%known(:n - 1) = sorted(:n - 1)
      labels = place(labels)
   end subroutine order_by_share

end module vi_attractor_list
