!> The attractors at a point (r, D), and the initial states in the basin of each.
module vi_attractor_list
   use vi_attractor_basin, only: decide, event_limited, not_reached
   use vi_attractor_known, only: alike, identify, known_type, no_impacts, repeating, &
      shortest_period, within
   use vi_attractor_settled, only: settle_chains
   use vi_attractor_target, only: target_type
   use vi_attractor_wandering, only: group_type, separate_groups
   use vi_forced_system, only: forced_system_type
   use vi_kinds, only: wp
   use vi_status, only: stat
   use vi_progress, only: add_expected_work, is_stopped
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

   !> The attractors known so far, and the settings of the search.
   type, public :: attractor_list_type
      type(forced_system_type) :: system
      !> Longest period considered, in load cycles; largest number of events of a simulation; number
      !! of OpenMP threads.
      integer :: max_cycles = 16, max_events = 10000000, threads = 1
      integer :: n = 0
      type(known_type), allocatable :: known(:)
      !> Cells of the attractors that are not periodic.
      type(group_type), allocatable :: groups(:)
   end type attractor_list_type

   !> The motions on which some states settle: contents as in `settle_chains`, one link.
   type :: ends_type
      real(wp), allocatable :: values(:, :, :, :), extremes(:, :, :), ends(:, :, :)
      integer, allocatable :: labels(:, :, :, :), found(:, :), periods(:, :, :), status(:, :)
   end type ends_type

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
      integer :: i, known, round

      allocate (list%known(most_attractors), list%groups(0))
      labels = 0
      events = 0
      allocate (ends, source=starts)
      allocate (open_ones, source=[(i, i=1, size(labels))])
      call add_expected_work(size(labels), progress)
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
      do i = 1, size(open_ones), block
         if (is_stopped(progress)) exit
         associate (own => open_ones(i:min(i + block - 1, size(open_ones))))
            call describe(list, ends(:, i:i + size(own) - 1), labels, own, progress)
         end associate
      end do
      call order_by_share(list, labels)
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
   subroutine find_ends(list, starts, settling, capacity, found, progress)
      !> System, longest period, limit of events and threads are read.
      type(attractor_list_type), intent(in) :: list
      !> (5, m): t, x, x', z, z'
      real(wp), intent(in) :: starts(:, :)
      !> Load cycles of the transient, and impacts kept.
      integer, intent(in) :: settling, capacity
      !> The motions on which the states settle.
      type(ends_type), intent(out) :: found
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      real(wp), allocatable :: parameters(:, :, :)
      integer :: m, j

      m = size(starts, 2)
      allocate (parameters(6, 1, m), found%values(7, capacity, 1, m), found%labels(2, capacity, 1, &
         m), &
         found%found(1, m), found%periods(4, 1, m), found%extremes(2, 1, m), found%ends(5, 1, m), &
         found%status(1, m))
      associate (system => list%system)
         do j = 1, m
            parameters(:, 1, j) = [system%r, system%clearance, system%osc%xi, system%osc%mu, &
               system%osc%restitution]
         end do
         call settle_chains(parameters, system%load, starts, settling, 2*list%max_cycles + 1, &
            0.0_wp, list%max_events, list%threads, found%values, found%labels, found%found, &
            found%periods, found%extremes, found%ends, found%status, progress)
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
      type(ends_type) :: found
      type(known_type) :: new
      integer :: i, j, n, seen(size(starts, 2))
      logical :: good

      call find_ends(list, starts, settling, 1, found, progress)
      n = 0
      do j = 1, size(starts, 2)
         if (found%status(1, j) /= stat%ok .or. found%periods(1, 1, j) == 0 .or. &
            found%periods(3, 1, j) == 0 .or. list%n == most_attractors) cycle
         ! a state with the same numbers as an earlier one is on the same motion
         do i = 1, n
            if (all(found%periods(:2, 1, seen(i)) == found%periods(:2, 1, j)) .and. &
               maxval(abs(found%extremes(:, 1, seen(i)) - found%extremes(:, 1, j))) < &
               1.0e-3_wp*list%system%clearance) exit
         end do
         if (i <= n) cycle
         n = n + 1
         seen(n) = j
         call identify(list%system, found%ends(:, 1, j), found%periods(1, 1, j), &
            list%threads, new, good, progress)
         if (.not. good) cycle
         do i = 1, list%n
            if (alike(new, list%known(i), list%system%clearance)) exit
         end do
         if (i > list%n) call add(list, new)
      end do
   end subroutine discover

   !> Adds an attractor.
   subroutine add(list, new)
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
   subroutine describe(list, starts, labels, members, progress)
      !> In and out: the attractors known so far.
      type(attractor_list_type), intent(inout) :: list
      !> (5, m): t, x, x', z, z'
      real(wp), intent(in) :: starts(:, :)
      !> (all states) In and out: the numbers of the attractors of these states are set.
      integer, intent(inout) :: labels(:)
      !> (m) The numbers of the states among all.
      integer, intent(in) :: members(:)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(ends_type) :: found
      type(known_type) :: new
      integer :: i, j, kind, n

      call find_ends(list, starts, 0, impacts_kept, found, progress)
      do j = 1, size(members)
         if (found%status(1, j) == stat%event_limit) labels(members(j)) = event_limited
         if (found%status(1, j) /= stat%ok) cycle
         new%state = within(found%ends(:, 1, j), list%system%clearance)
         associate (period => found%periods(:, 1, j))
            if (period(1) == 0) then
               n = found%found(1, j)
               i = list%n + 1
               if (i > most_attractors) cycle
               call separate_groups(list%system, found%values(:, :n, 1, j), &
                  found%labels(2, :n, 1, j), new, list%groups, i, list%max_events, &
                  labels(members(j)), progress)
               if (labels(members(j)) == i) call add_described(list, new)
               cycle
            end if
            kind = merge(no_impacts, repeating, period(3) == 0)
            if (kind == repeating) then
               i = place_of(list, found%ends(:, 1, j), period(1))
               if (i > 0) labels(members(j)) = i
               if (i > 0) cycle
            end if
            do i = 1, list%n
               associate (known => list%known(i))
                  if (known%kind /= kind) cycle
                  if (kind == no_impacts) exit
                  if (known%cycles == period(1) .and. size(known%symbols) == period(2)) exit
               end associate
            end do
            new%kind = kind
            new%cycles = merge(0, period(1), kind == no_impacts)
            new%largest = 0
            if (allocated(new%symbols)) deallocate (new%symbols)
            allocate (new%symbols(merge(0, period(2), kind == no_impacts)), source=0)
            if (i > list%n) call add_described(list, new)
            if (i <= list%n) labels(members(j)) = i
         end associate
      end do
   end subroutine describe

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
   subroutine add_described(list, new)
      !> In and out: the attractors known so far.
      type(attractor_list_type), intent(inout) :: list
      !> The attractor; its arrays are allocated if they are not yet.
      type(known_type), intent(inout) :: new

      if (list%n == most_attractors) return
      if (.not. allocated(new%targets)) allocate (new%targets(0))
      if (.not. allocated(new%symbols)) allocate (new%symbols(0))
      call add(list, new)
   end subroutine add_described

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
