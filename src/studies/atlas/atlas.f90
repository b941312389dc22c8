!> An atlas: the zones of all patterns in a window.
!!
!! Patterns are enumerated up to a number of impacts and cycles. Those with rest come from a survey
!! by simulation, whose attractors also serve as seeds of the zones, and from the simulations at the
!! nodes of the lattice with which the searches for zones with rest begin. If an attractor lies in
!! no zone of its pattern, that pattern is searched again on a finer lattice. The outcomes of
!! the other points of the survey are kept with the zones.
module vi_atlas
   use vi_family, only: can_be_symmetric
   use vi_kinds, only: wp
   use vi_symbols, only: standard_symbols
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_zone_request, only: zone_request_type
   use vi_survey, only: attractor_type, limits_type, settle_from, survey
   use vi_survey_outcome, only: count_outcomes, outcome_names
   use vi_progress, only: add_expected_work, is_stopped
   use vi_zone, only: count_zone, find_zone, release_type, simulate_nodes, zone_type, zone_work
   implicit none (type, external)
   private

   public :: find_atlas, outcomes_of

   !> What to search, and the effort.
   type, public :: atlas_request_type
      type(oscillator_type) :: osc
      real(wp) :: r(2) = 0, clearance(2) = 0
      integer :: max_impacts = 5, max_cycles = 1
      !> Points of the survey, and load cycles of the transient at each.
      integer :: survey = 400, settling = 400
      integer :: lines = 17, guesses = 24, points = 20000, threads = 1
      !> Largest number of events of a simulation of the survey.
      integer :: max_events = 10000000
   end type atlas_request_type

   !> One pattern's motions, symmetric or not, and where they are stable and admissible.
   type, public :: family_type
      type(pattern_type) :: pattern
      logical :: symmetric = .false.
      !> Whether the search for its zone was completed.
      logical :: searched = .false.
      type(zone_type) :: zone
   end type family_type

   !> The zones of all patterns in a window, and the results of the survey.
   type, public :: atlas_type
      type(family_type), allocatable :: families(:)
      !> Every point of the survey, and those with a motion within the limits.
      type(attractor_type), allocatable :: points(:), attractors(:)
      !> Attractors with rest of patterns that the survey did not find, one of each pattern.
      type(attractor_type), allocatable :: sighted(:)
      !> Whether each attractor lies in a zone of its pattern.
      logical, allocatable :: explained(:)
   end type atlas_type

   !> A pattern with rest that simulations at nodes appear to repeat.
   type :: sight_type
      type(pattern_type) :: pattern
      !> Number of such simulations. For the first, second, fourth, eighth and so on: the number of
      !! the simulation at its node, and the two lattice lines of the node.
      integer :: n = 0, nodes(3, bit_size(0)) = 0
   end type sight_type

contains

   !> All zones in a window.
   subroutine find_atlas(request, atlas, progress)
      !> The request.
      type(atlas_request_type), intent(in) :: request
      !> The zones and the results of the survey.
      type(atlas_type), intent(out) :: atlas
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(release_type), allocatable :: releases(:, :, :)
      real(wp), allocatable :: places(:, :, :)
      logical, allocatable :: again(:)
      integer :: i, j, announced

      ! the work on patterns without rest is known before the survey begins
      allocate (atlas%attractors(0), atlas%sighted(0))
      call list_families(request, atlas)
      announced = zone_work*size(atlas%families)
      call add_expected_work(announced, progress)
      call survey_window(request, atlas, progress)
      call list_families(request, atlas)
      if (any_rests(request, atlas, progress)) call sight_rests(request, atlas, releases, progress)
      if (.not. allocated(releases)) allocate (releases(0, 0, 0))
      call list_families(request, atlas)
      allocate (again(size(atlas%families)), source=.true.)
      call add_expected_work(zone_work*size(again) - announced, progress)
      call trace_families(request, atlas, again, 1, releases, progress)
      call explain(request, atlas)
      again = .false.
      do j = 1, size(atlas%families)
         do i = 1, size(atlas%attractors)
            again(j) = again(j) .or. (.not. atlas%explained(i) .and. &
               is_of(atlas%attractors(i), atlas%families(j)%pattern))
         end do
         ! on the same lattice nothing else would be found
         again(j) = again(j) .and. lattice(request, atlas%families(j)%pattern, 2) /= &
            lattice(request, atlas%families(j)%pattern, 1)
      end do
      if (.not. any(again)) return
      call add_expected_work(zone_work*count(again), progress)
      if (any([(again(j) .and. rests(atlas%families(j)%pattern), j=1, size(again))])) then
         call simulate_lattice(request, 2, releases, places, progress)
      end if
      call trace_families(request, atlas, again, 2, releases, progress)
      call explain(request, atlas)
   end subroutine find_atlas

   !> Number of points of the survey of each outcome.
   pure function outcomes_of(atlas) result(counts)
      !> The atlas.
      type(atlas_type), intent(in) :: atlas
      integer :: counts(size(outcome_names))

      counts = count_outcomes(atlas%points%outcome)
   end function outcomes_of

   !> The survey by simulation, and its attractors within the limits.
   subroutine survey_window(request, atlas, progress)
      !> The request.
      type(atlas_request_type), intent(in) :: request
      !> In and out: points and attractors are set.
      type(atlas_type), intent(inout) :: atlas
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      integer :: i, n

      allocate (atlas%points(request%survey))
      call survey(request%osc, request%r, request%clearance, request%settling, &
         limits_of(request), request%threads, atlas%points, progress)
      deallocate (atlas%attractors)
      allocate (atlas%attractors(count(atlas%points%found)))
      n = 0
      do i = 1, size(atlas%points)
         if (.not. atlas%points(i)%found) cycle
         n = n + 1
         atlas%attractors(n) = atlas%points(i)
      end do
   end subroutine survey_window

   !> The limits of the motions of an atlas.
   pure type(limits_type) function limits_of(request) result(limits)
      !> The request.
      type(atlas_request_type), intent(in) :: request

      limits = limits_type(request%max_impacts, request%max_cycles, request%max_events)
   end function limits_of

   !> The simulations at the nodes of a lattice, which all searches for zones with rest share.
   subroutine simulate_lattice(request, finer, releases, places, progress)
      !> The request.
      type(atlas_request_type), intent(in) :: request
      !> Factor of the number of lattice spacings.
      integer, intent(in) :: finer
      !> (simulations, r, D) as in `simulate_nodes`.
      type(release_type), allocatable, intent(out) :: releases(:, :, :)
      !> (2, r, D): r and D of the nodes.
      real(wp), allocatable, intent(out) :: places(:, :, :)
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(family_type) :: family

      family%pattern = pattern_type([2, -2], 1)         ! any with rest will do
      call simulate_nodes(zone_request(request, family, finer), [request%max_impacts, &
         request%max_cycles], request%threads, releases, places, progress)
   end subroutine simulate_lattice

   !> Whether the free mass rests on a wall in the survey's motions within the limits or,
   !! if not, in the second half of a simulation at any node of the lattice.
   logical function any_rests(request, atlas, progress)
      !> The request.
      type(atlas_request_type), intent(in) :: request
      !> The atlas; its families are read.
      type(atlas_type), intent(in) :: atlas
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(atlas_request_type) :: sparse
      type(release_type), allocatable :: releases(:, :, :)
      real(wp), allocatable :: places(:, :, :)
      integer :: i, j, k

      any_rests = any([(rests(atlas%families(i)%pattern), i=1, size(atlas%families))])
      if (any_rests) return
      sparse = request
      sparse%guesses = min(1, request%guesses)
      call simulate_lattice(sparse, 1, releases, places, progress)
      any_rests = any([(((releases(k, i, j)%late, k=1, size(releases, 1)), &
         i=1, size(releases, 2)), j=1, size(releases, 3))])
   end function any_rests

   !> Searches the simulations at nodes for patterns with rest that the survey has not found.
   !!
   !! For each pattern that simulations appear to repeat at their end, a few simulations are
   !! continued for as long as those of the survey. The pattern is accepted if Newton's method
   !! confirms the motion that one of them has reached by then.
   subroutine sight_rests(request, atlas, releases, progress)
      !> The request.
      type(atlas_request_type), intent(in) :: request
      !> In: with the families listed. Out: with the attractors `sighted`.
      type(atlas_type), intent(inout) :: atlas
      !> (simulations, r, D) as in `simulate_nodes`.
      type(release_type), allocatable, intent(out) :: releases(:, :, :)
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(sight_type), allocatable :: sights(:)
      type(attractor_type), allocatable :: tried(:)
      real(wp), allocatable :: places(:, :, :)
      integer, allocatable :: nodes(:, :)
      integer :: i, j

      call simulate_lattice(request, 1, releases, places, progress)
      call list_sights(request, atlas, releases, sights)
      nodes = reshape([(sights(i)%nodes(:, :kept(sights(i))), i=1, size(sights))], &
         [3, sum([(kept(sights(i)), i=1, size(sights))])])
      allocate (tried(size(nodes, 2)))
      !$omp parallel do schedule(dynamic, 1) num_threads(request%threads)
      do i = 1, size(tried)
         associate (at => places(:, nodes(2, i), nodes(3, i)))
            tried(i) = attractor_type(r=at(1), clearance=at(2))
            if (is_stopped(progress)) cycle
            call settle_from(request%osc, nodes(1, i), request%settling, limits_of(request), &
               tried(i), progress)
         end associate
      end do
      !$omp end parallel do
      do i = 1, size(tried)
         if (.not. tried(i)%found) cycle
         if (.not. any(abs(tried(i)%symbols) == 2)) cycle
         if (is_listed(atlas%families, pattern_type(tried(i)%symbols, tried(i)%cycles))) cycle
         if (any([(is_of(atlas%sighted(j), pattern_type(tried(i)%symbols, tried(i)%cycles)), &
            j=1, size(atlas%sighted))])) cycle
         atlas%sighted = [atlas%sighted, tried(i)]
      end do
   end subroutine sight_rests

   !> The patterns not listed so far that simulations at nodes appear to repeat, and those nodes.
   pure subroutine list_sights(request, atlas, releases, sights)
      !> The request.
      type(atlas_request_type), intent(in) :: request
      !> The atlas; its families are read.
      type(atlas_type), intent(in) :: atlas
      !> (simulations, r, D) as in `simulate_nodes`.
      type(release_type), intent(in) :: releases(:, :, :)
      !> The patterns.
      type(sight_type), allocatable, intent(out) :: sights(:)
      type(pattern_type) :: pattern
      integer :: i, j, k, m, shift
      logical :: mirrored

      allocate (sights(0))
      do j = 1, size(releases, 3)
         do i = 1, size(releases, 2)
            do k = 1, size(releases, 1)
               associate (one => releases(k, i, j))
                  if (one%cycles == 0) cycle
                  pattern = pattern_type(one%symbols, one%cycles)
                  call standard_symbols(one%symbols, equal_walls(request%osc), pattern%sides, &
                     shift, mirrored)
               end associate
               if (is_listed(atlas%families, pattern)) cycle
               do m = 1, size(sights)
                  if (same_pattern(sights(m)%pattern, pattern)) exit
               end do
               if (m > size(sights)) sights = [sights, sight_type(pattern)]
               sights(m)%n = sights(m)%n + 1
               if (popcnt(sights(m)%n) == 1) sights(m)%nodes(:, 1 + trailz(sights(m)%n)) = [k, i, j]
            end do
         end do
      end do
   end subroutine list_sights

   !> Number of simulations of a pattern that are kept: those with numbers 1, 2, 4, 8 and so on.
   pure integer function kept(sight)
      !> The pattern.
      type(sight_type), intent(in) :: sight

      kept = bit_size(sight%n) - leadz(sight%n)
   end function kept

   !> Whether both walls have the same coefficient of restitution.
   pure logical function equal_walls(osc)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc

      equal_walls = abs(osc%restitution(1) - osc%restitution(2)) <= 0
   end function equal_walls

   !> Whether one of the families has a given pattern.
   pure logical function is_listed(families, pattern)
      !> The families.
      type(family_type), intent(in) :: families(:)
      !> The pattern, in standard order.
      type(pattern_type), intent(in) :: pattern
      integer :: i

      is_listed = any([(same_pattern(families(i)%pattern, pattern), i=1, size(families))])
   end function is_listed

   !> Finds the zones of the wanted families; each family is one task.
   subroutine trace_families(request, atlas, wanted, finer, releases, progress)
      !> The request.
      type(atlas_request_type), intent(in) :: request
      !> In and out: the zones of the wanted families are set.
      type(atlas_type), intent(inout) :: atlas
      !> (families) Whether each is to be searched.
      logical, intent(in) :: wanted(:)
      !> Factor of the number of lattice spacings.
      integer, intent(in) :: finer
      !> (simulations, r, D) as in `simulate_nodes`, for the same number of lines.
      type(release_type), intent(in) :: releases(:, :, :)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      integer :: j

      ! patterns with rest and long patterns take longest, so they come first
      !$omp parallel do schedule(dynamic, 1) num_threads(request%threads)
      do j = size(atlas%families), 1, -1
         if (.not. wanted(j)) cycle
         if (is_stopped(progress)) cycle
         call trace_family(request, seeds_of(atlas, atlas%families(j)%pattern), finer, releases, &
            atlas%families(j), progress)
      end do
      !$omp end parallel do
   end subroutine trace_families

   !> Finds the zones of a family.
   subroutine trace_family(request, seeds, finer, releases, family, progress)
      !> The request.
      type(atlas_request_type), intent(in) :: request
      !> (2 + 2N, m) Its motions that are known.
      real(wp), intent(in) :: seeds(:, :)
      !> As in `trace_families`.
      integer, intent(in) :: finer
      !> As in `trace_families`.
      type(release_type), intent(in) :: releases(:, :, :)
      !> In and out: the family.
      type(family_type), intent(inout) :: family
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(zone_type) :: zone
      integer :: status

      ! a family without motions has an empty zone, whatever the status
      if (rests(family%pattern)) then
         call find_zone(zone_request(request, family, finer), seeds, zone, status, progress, &
            releases)
      else
         call find_zone(zone_request(request, family, finer), seeds, zone, status, progress)
      end if
      ! an incomplete zone is discarded; one that an earlier search found is kept
      if (is_stopped(progress)) return
      family%zone = zone
      family%searched = .true.
   end subroutine trace_family

   !> The request for the zone of a family.
   pure function zone_request(request, family, finer) result(one)
      !> The request.
      type(atlas_request_type), intent(in) :: request
      !> The family.
      type(family_type), intent(in) :: family
      !> Factor of the number of lattice spacings.
      integer, intent(in) :: finer
      type(zone_request_type) :: one

      one = zone_request_type(request%osc, family%pattern, family%symmetric, request%r, &
         request%clearance, lattice(request, family%pattern, finer), request%guesses, &
         request%points)
   end function zone_request

   !> Whether a pattern has rests.
   pure logical function rests(pattern)
      !> The pattern.
      type(pattern_type), intent(in) :: pattern

      rests = any(abs(pattern%sides) == 2)
   end function rests

   !> Number of lattice lines. Patterns with rest have more: such a motion is found only inside its
   !! zone, which may be narrow.
   pure integer function lattice(request, pattern, finer)
      !> The request.
      type(atlas_request_type), intent(in) :: request
      !> The pattern.
      type(pattern_type), intent(in) :: pattern
      !> Factor of the number of lattice spacings.
      integer, intent(in) :: finer

      lattice = min(129, finer*(request%lines - 1) + 1)
      if (rests(pattern)) lattice = max(lattice, 33)
   end function lattice

   !> All patterns up to the limits, shortest first, and those with rest that have been found.
   subroutine list_families(request, atlas)
      !> The request.
      type(atlas_request_type), intent(in) :: request
      !> In: with its attractors. Out: with its families, without zones.
      type(atlas_type), intent(inout) :: atlas
      integer :: symbols(request%max_impacts), n, bits, cycles, i

      if (allocated(atlas%families)) deallocate (atlas%families)
      allocate (atlas%families(0))
      do n = 2, request%max_impacts
         do bits = 2**n - 2, 1, -1
            symbols(:n) = [(merge(1, -1, btest(bits, n - i)), i=1, n)]
            do cycles = 1, request%max_cycles
               call add_families(request%osc, pattern_type(symbols(:n), cycles), atlas%families)
            end do
         end do
      end do
      do i = 1, size(atlas%attractors)
         if (any(abs(atlas%attractors(i)%symbols) == 2)) call add_families(request%osc, &
            pattern_type(atlas%attractors(i)%symbols, atlas%attractors(i)%cycles), atlas%families)
      end do
      do i = 1, size(atlas%sighted)
         call add_families(request%osc, pattern_type(atlas%sighted(i)%symbols, &
            atlas%sighted(i)%cycles), atlas%families)
      end do
   end subroutine list_families

   !> Adds the families of a pattern, first the symmetric motions and then the others, if the
   !! pattern is in standard order and not listed yet.
   subroutine add_families(osc, pattern, families)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      !> The pattern.
      type(pattern_type), intent(in) :: pattern
      !> In and out: the families.
      type(family_type), allocatable, intent(inout) :: families(:)
      type(family_type), allocatable :: longer(:)
      integer :: standard(size(pattern%sides)), shift, i, n, more
      logical :: mirrored, symmetric

      call standard_symbols(pattern%sides, equal_walls(osc), standard, shift, mirrored)
      if (any(standard /= pattern%sides)) return
      if (is_listed(families, pattern)) return
      n = size(families)
      symmetric = can_be_symmetric(pattern, osc%restitution)
      more = merge(2, 1, symmetric)
      allocate (longer(n + more))
      longer(:n) = families
      do i = n + 1, n + more
         longer(i)%pattern = pattern
      end do
      longer(n + 1)%symmetric = symmetric
      call move_alloc(longer, families)
   end subroutine add_families

   !> Whether two patterns are the same.
   pure logical function same_pattern(a, b)
      !> The patterns.
      type(pattern_type), intent(in) :: a, b

      same_pattern = a%cycles == b%cycles .and. size(a%sides) == size(b%sides)
      if (same_pattern) same_pattern = all(a%sides == b%sides)
   end function same_pattern

   !> The attractors of a pattern as seeds: r, D and the unknowns of the whole pattern (2 + 2N, m).
   pure function seeds_of(atlas, pattern) result(seeds)
      !> The atlas.
      type(atlas_type), intent(in) :: atlas
      !> The pattern.
      type(pattern_type), intent(in) :: pattern
      real(wp), allocatable :: seeds(:, :)
      type(attractor_type), allocatable :: items(:)
      integer :: i, m

      allocate (items, source=[atlas%attractors, atlas%sighted])
      allocate (seeds(2 + 2*size(pattern%sides), count([(is_of(items(i), pattern), &
         i=1, size(items))])))
      m = 0
      do i = 1, size(items)
         if (.not. is_of(items(i), pattern)) cycle
         m = m + 1
         seeds(:, m) = [items(i)%r, items(i)%clearance, items(i)%unknowns]
      end do
   end function seeds_of

   !> Whether an attractor has a pattern.
   pure logical function is_of(attractor, pattern)
      !> The attractor.
      type(attractor_type), intent(in) :: attractor
      !> The pattern.
      type(pattern_type), intent(in) :: pattern

      is_of = attractor%cycles == pattern%cycles .and. &
         size(attractor%symbols) == size(pattern%sides)
      if (is_of) is_of = all(attractor%symbols == pattern%sides)
   end function is_of

   !> Sets which attractors lie in a zone of their pattern, of its symmetric motions or the others.
   pure subroutine explain(request, atlas)
      !> The request; its window is used.
      type(atlas_request_type), intent(in) :: request
      !> In and out: `explained` is set.
      type(atlas_type), intent(inout) :: atlas
      integer, allocatable :: mine(:)
      integer :: i, j

      associate (items => atlas%attractors)
         if (.not. allocated(atlas%explained)) allocate (atlas%explained(size(items)))
         atlas%explained = .false.
         do j = 1, size(atlas%families)
            mine = pack([(i, i=1, size(items))], &
               [(is_of(items(i), atlas%families(j)%pattern), i=1, size(items))])
            if (size(mine) == 0) cycle
            atlas%explained(mine) = atlas%explained(mine) .or. count_zone(atlas%families(j)%zone, &
               request%r, request%clearance, &
               reshape([(items(mine(i))%r, items(mine(i))%clearance, i=1, size(mine))], &
               [2, size(mine)])) > 0
         end do
      end associate
   end subroutine explain

end module vi_atlas
