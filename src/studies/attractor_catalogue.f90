!> The attractors at a point (r, D), and the initial states that go to each.
module vi_attractor_catalogue
   use vi_attractor_basin, only: decide, not_reached
   use vi_attractor_known, only: alike, identify, known_type, no_impacts, repeating, within
   use vi_attractor_settled, only: settle_chains
   use vi_attractor_target, only: target_type
   use vi_attractor_wandering, only: group_type, tell_apart
   use vi_drive, only: drive_type
   use vi_kinds, only: wp
   use vi_status, only: stat
   use vi_tally, only: add_sight, is_stopped
   implicit none (type, external)
   private

   public :: label_states

   !> Largest number of attractors: without damping every state may have its own.
   integer, parameter :: most_attractors = 1000
   !> Largest number of rounds of a search for motions, and the least share of the states that a
   !! round has to decide for another round.
   integer, parameter :: rounds = 16
   real(wp), parameter :: lively = 0.02_wp
   !> States that are described at a time, and impacts kept of each.
   integer, parameter :: block = 2000, impacts_kept = 200

   !> The attractors known so far, and the settings of the search.
   type, public :: catalogue_type
      type(drive_type) :: drive
      !> Longest period considered, in load cycles; number of OpenMP threads.
      integer :: max_cycles = 16, threads = 1
      integer :: n = 0
      type(known_type), allocatable :: known(:)
      !> Of attractors that are not periodic.
      type(group_type), allocatable :: groups(:)
   end type catalogue_type

   !> The motions on which some states settle: contents as of `settle_chains`, one link.
   type :: ends_type
      real(wp), allocatable :: values(:, :, :, :), extremes(:, :, :), ends(:, :, :)
      integer, allocatable :: labels(:, :, :, :), found(:, :), periods(:, :, :), status(:, :)
   end type ends_type

contains

   !> The attractor of each state (0, `not_reached`: as in `decide`), by falling share of all.
   subroutine label_states(catalogue, starts, cycles, probes, labels, events, tally)
      !> In: drive, longest period and threads.
      type(catalogue_type), intent(inout) :: catalogue
      !> (5, m): t, x, x', z, z'
      real(wp), intent(in) :: starts(:, :)
      !> Load cycles in which a state should be decided, and states simulated first.
      integer, intent(in) :: cycles, probes
      !> (m) Number of the attractor, 0 or `not_reached`.
      integer, intent(out) :: labels(:)
      !> Number of events simulated to decide.
      real(wp), intent(out) :: events
      !> Progress counters, see vi_tally.
      integer, intent(inout), optional :: tally(3)
      real(wp), allocatable :: ends(:, :), after(:, :)
      integer, allocatable :: open_ones(:), found(:), counts(:)
      integer :: i, known, round

      allocate (catalogue%known(most_attractors), catalogue%groups(0))
      labels = 0
      events = 0
      allocate (ends, source=starts)
      allocate (open_ones, source=[(i, i=1, size(labels))])
      call add_sight(size(labels), tally)
      call discover(catalogue, starts(:, some(size(labels), probes)), cycles/2, tally)
      do round = 1, rounds
         allocate (found(size(open_ones)), counts(size(open_ones)), after(5, size(open_ones)))
         call decide_known(catalogue, ends, cycles, found, counts, after, tally)
         events = events + sum(real(counts, wp))
         labels(open_ones) = merge(found, max(found, 0), round == 1)  ! later on all were reached
         call keep_open(found, after, open_ones, ends)
         known = count(found > 0)
         deallocate (found, counts, after)
         if (is_stopped(tally) .or. size(open_ones) == 0) exit
         i = catalogue%n
         call discover(catalogue, ends(:, some(size(open_ones), 2*probes)), 0, tally)
         if (catalogue%n == i .and. .not. known > lively*(known + size(open_ones))) exit
         call add_sight(size(open_ones), tally)
      end do
      do i = 1, size(open_ones), block
         if (is_stopped(tally)) exit
         associate (own => open_ones(i:min(i + block - 1, size(open_ones))))
            call describe(catalogue, ends(:, i:i + size(own) - 1), labels, own, tally)
         end associate
      end do
      call order_by_share(catalogue, labels)
   end subroutine label_states

   !> Some of n places, spread evenly, each once.
   pure function some(n, wanted) result(places)
      !> Number of places, and how many of them.
      integer, intent(in) :: n, wanted
      integer, allocatable :: places(:)
      integer :: i, m

      m = min(n, wanted)
      allocate (places(m))
      places = [(1 + int(real(i, wp)*(n - 1)/max(1, m - 1)), i=0, m - 1)]
   end function some

   !> Keeps only the states that are not decided, with their present values.
   pure subroutine keep_open(found, after, open_ones, ends)
      !> (m) Number of the attractor of each state; not above 0 if it is not decided.
      integer, intent(in) :: found(:)
      !> (5, m) The states at the end of the simulation.
      real(wp), intent(in) :: after(:, :)
      !> In: numbers (m) of the states among all. Out: those of the states kept.
      integer, allocatable, intent(inout) :: open_ones(:)
      !> Out: (5, states kept).
      real(wp), allocatable, intent(inout) :: ends(:, :)
      integer, allocatable :: still(:), left(:)
      integer :: i

      still = pack([(i, i=1, size(found))], found <= 0)
      left = open_ones(still)
      call move_alloc(left, open_ones)
      deallocate (ends)
      allocate (ends(5, size(still)))
      ends = after(:, still)
   end subroutine keep_open

   !> Simulates states until they have settled.
   subroutine settle(catalogue, starts, settling, room, found, tally)
      !> Drive, longest period and threads are read.
      type(catalogue_type), intent(in) :: catalogue
      !> (5, m): t, x, x', z, z'
      real(wp), intent(in) :: starts(:, :)
      !> Load cycles of the transient, and impacts kept.
      integer, intent(in) :: settling, room
      !> The motions on which the states settle.
      type(ends_type), intent(out) :: found
      !> Progress counters, see vi_tally.
      integer, intent(inout), optional :: tally(3)
      real(wp), allocatable :: parameters(:, :, :)
      integer :: m, j

      m = size(starts, 2)
      allocate (parameters(6, 1, m), found%values(7, room, 1, m), found%labels(2, room, 1, m), &
         found%found(1, m), found%periods(4, 1, m), found%extremes(2, 1, m), found%ends(5, 1, m), &
         found%status(1, m))
      associate (drive => catalogue%drive)
         do j = 1, m
            parameters(:, 1, j) = [drive%r, drive%clearance, drive%osc%xi, drive%osc%mu, &
               drive%osc%restitution]
         end do
         call settle_chains(parameters, drive%load, starts, settling, 2*catalogue%max_cycles + 1, &
            0.0_wp, catalogue%threads, found%values, found%labels, found%found, found%periods, &
            found%extremes, found%ends, found%status, tally)
      end associate
   end subroutine settle

   !> Adds the periodic motions on which some states settle.
   subroutine discover(catalogue, starts, settling, tally)
      !> In and out: the attractors known so far.
      type(catalogue_type), intent(inout) :: catalogue
      !> (5, m): t, x, x', z, z'
      real(wp), intent(in) :: starts(:, :)
      !> Load cycles of the transient.
      integer, intent(in) :: settling
      !> Progress counters, see vi_tally.
      integer, intent(inout), optional :: tally(3)
      type(ends_type) :: found
      type(known_type) :: new
      integer :: i, j, n, seen(size(starts, 2))
      logical :: good

      call settle(catalogue, starts, settling, 1, found, tally)
      n = 0
      do j = 1, size(starts, 2)
         if (found%status(1, j) /= stat%ok .or. found%periods(1, 1, j) == 0 .or. &
            found%periods(3, 1, j) == 0 .or. catalogue%n == most_attractors) cycle
         ! a state with the same numbers as one before is on the same motion
         do i = 1, n
            if (all(found%periods(:2, 1, seen(i)) == found%periods(:2, 1, j)) .and. &
               maxval(abs(found%extremes(:, 1, seen(i)) - found%extremes(:, 1, j))) < &
               1.0e-3_wp*catalogue%drive%clearance) exit
         end do
         if (i <= n) cycle
         n = n + 1
         seen(n) = j
         call identify(catalogue%drive, found%ends(:, 1, j), found%periods(1, 1, j), &
            catalogue%threads, new, good)
         if (.not. good) cycle
         do i = 1, catalogue%n
            if (alike(new, catalogue%known(i), catalogue%drive%clearance)) exit
         end do
         if (i > catalogue%n) call add(catalogue, new)
      end do
   end subroutine discover

   !> Adds an attractor.
   subroutine add(catalogue, new)
      !> In and out: the attractors known so far, with room for one more.
      type(catalogue_type), intent(inout) :: catalogue
      !> The attractor.
      type(known_type), intent(in) :: new

      catalogue%n = catalogue%n + 1
      catalogue%known(catalogue%n) = new
   end subroutine add

   !> The known periodic motion to which each state comes near.
   subroutine decide_known(catalogue, starts, cycles, found, counts, after, tally)
      !> The attractors known so far.
      type(catalogue_type), intent(in) :: catalogue
      !> (5, m): t, x, x', z, z'
      real(wp), intent(in) :: starts(:, :)
      !> Largest number of load cycles simulated.
      integer, intent(in) :: cycles
      !> (m) Number of the attractor, 0 or `not_reached`; (m) events simulated.
      integer, intent(out) :: found(:), counts(:)
      !> (5, m) The states at the end of the simulation.
      real(wp), intent(out) :: after(:, :)
      !> Progress counters, see vi_tally.
      integer, intent(inout), optional :: tally(3)
      type(target_type), allocatable :: targets(:)
      integer, allocatable :: owners(:)
      integer :: i, n

      n = 0
      do i = 1, catalogue%n
         n = n + size(catalogue%known(i)%targets)
      end do
      allocate (targets(n), owners(not_reached:n))
      owners(:) = [not_reached, (0, i=0, n)]
      n = 0
      do i = 1, catalogue%n
         associate (own => catalogue%known(i)%targets)
            targets(n + 1:n + size(own)) = own
            owners(n + 1:n + size(own)) = i
            n = n + size(own)
         end associate
      end do
      associate (drive => catalogue%drive)
         call decide(drive%osc, drive%r, drive%load, drive%clearance, targets, starts, cycles, &
            catalogue%threads, found, counts, after, tally)
      end associate
      found = owners(found)
   end subroutine decide_known

   !> Determines the attractors of states that come near to no known motion.
   subroutine describe(catalogue, starts, labels, members, tally)
      !> In and out: the attractors known so far.
      type(catalogue_type), intent(inout) :: catalogue
      !> (5, m): t, x, x', z, z'
      real(wp), intent(in) :: starts(:, :)
      !> (all states) In and out: the numbers of the attractors of these states are set.
      integer, intent(inout) :: labels(:)
      !> (m) The numbers of the states among all.
      integer, intent(in) :: members(:)
      !> Progress counters, see vi_tally.
      integer, intent(inout), optional :: tally(3)
      type(ends_type) :: found
      type(known_type) :: new
      integer :: i, j, kind, n

      call settle(catalogue, starts, 0, impacts_kept, found, tally)
      do j = 1, size(members)
         if (found%status(1, j) /= stat%ok) cycle
         new%state = within(found%ends(:, 1, j), catalogue%drive%clearance)
         associate (period => found%periods(:, 1, j))
            if (period(1) == 0) then
               n = found%found(1, j)
               i = catalogue%n + 1
               if (i > most_attractors) cycle
               call tell_apart(catalogue%drive, found%values(:, :n, 1, j), &
                  found%labels(2, :n, 1, j), new, catalogue%groups, i, labels(members(j)))
               if (labels(members(j)) == i) call add_described(catalogue, new)
               cycle
            end if
            kind = merge(no_impacts, repeating, period(3) == 0)
            do i = 1, catalogue%n
               associate (known => catalogue%known(i))
                  if (known%kind /= kind) cycle
                  if (kind == no_impacts) exit
                  if (known%cycles == period(1) .and. size(known%letters) == period(2)) exit
               end associate
            end do
            new%kind = kind
            new%cycles = merge(0, period(1), kind == no_impacts)
            new%largest = 0
            if (allocated(new%letters)) deallocate (new%letters)
            allocate (new%letters(merge(0, period(2), kind == no_impacts)), source=0)
            if (i > catalogue%n) call add_described(catalogue, new)
            if (i <= catalogue%n) labels(members(j)) = i
         end associate
      end do
   end subroutine describe

   !> Adds an attractor that has no neighbourhood, if there is room.
   subroutine add_described(catalogue, new)
      !> In and out: the attractors known so far.
      type(catalogue_type), intent(inout) :: catalogue
      !> The attractor; its arrays are allocated if they are not.
      type(known_type), intent(inout) :: new

      if (catalogue%n == most_attractors) return
      if (.not. allocated(new%targets)) allocate (new%targets(0))
      if (.not. allocated(new%letters)) allocate (new%letters(0))
      call add(catalogue, new)
   end subroutine add_described

   !> Renumbers the attractors by falling share; those to which no state goes are removed.
   subroutine order_by_share(catalogue, labels)
      !> In and out: the attractors.
      type(catalogue_type), intent(inout) :: catalogue
      !> In and out: the number of the attractor of each state.
      integer, intent(inout) :: labels(:)
      type(known_type), allocatable :: sorted(:)
      integer :: counts(catalogue%n), place(not_reached:catalogue%n), i, n

      do i = 1, catalogue%n
         counts(i) = count(labels == i)
      end do
      place = [not_reached, (0, i=0, catalogue%n)]
      allocate (sorted(catalogue%n))
      do n = 1, catalogue%n
         i = maxloc(counts, 1)
         if (counts(i) <= 0) exit
         sorted(n) = catalogue%known(i)
         place(i) = n
         counts(i) = 0
      end do
      catalogue%n = n - 1
      catalogue%known(:n - 1) = sorted(:n - 1)
      labels = place(labels)
   end subroutine order_by_share

end module vi_attractor_catalogue
