!> A systematic search for the periodic motions at a point, stable and unstable.
!!
!! For each pattern of sides Newton's method starts from guesses, and the motions found are
!! continued along the lines of constant r and of constant D through the point. Newton's method on
!! the return map of releases adds motions with rest. Simulations from initial states that are
!! spread evenly add the motions on which they settle, with any number of impacts and load cycles.
module vi_find
   use vi_forced_system, only: forced_system_type
   use vi_found_motion, only: are_same, found_type, in_standard_form, mirrored, new_found, &
      new_resting, describe_motion, described_type, scale_of
   use vi_kinds, only: wp
   use vi_motion, only: no, yes
   use vi_orbit, only: oscillator_parameters
   use vi_passages, only: begin_lines, birth_type, follow_birth, lines_type
   use vi_pattern, only: pattern_type, starred_symbols
   use vi_pattern_list, only: side_patterns
   use vi_settled_motion, only: longest, n_outcomes, settle_on
   use vi_starts, only: release_start, state_start
   use vi_status, only: stat
   use vi_progress, only: add_expected_work, add_done_work, is_stopped, report_share
   implicit none (type, external)
   private

   public :: find_motions

   !> Units of work of a search in the progress counters, and its parts.
   integer, parameter, public :: all_work = 1000000
   integer, parameter :: pattern_work = 900000, release_work = 50000, state_work = 50000
   !> Largest number of events of a period with rest in the search.
   integer, parameter :: few_events = 200

   !> What to search, and the effort.
   type, public :: find_request_type
      type(forced_system_type) :: system
      !> Limits of the patterns that are searched.
      integer :: max_impacts = 6, max_cycles = 2
      !> Guesses for each pattern; initial states simulated, load cycles of the transient, and
      !! largest number of events of a simulation; releases for each wall and number of cycles;
      !! OpenMP threads.
      integer :: guesses = 96, states = 24, settling = 600, max_events = 10000000, &
         releases = 32, threads = 1
   end type find_request_type

   !> The motions found, and counts of the search.
   type, public :: findings_type
      !> The motions, stable ones first.
      type(described_type), allocatable :: motions(:)
      !> Number of patterns searched, and of all patterns; Newton iterations started from guesses;
      !! solutions that would pass through a wall; releases from which Newton's method was started;
      !! solutions that could not be confirmed, or whose admissibility cannot be decided because of
      !! rounding.
      integer :: patterns = 0, all_patterns = 0, guesses = 0, inadmissible = 0, releases = 0, &
         lost = 0
      !> Number of states of each outcome, as in vi_settled_motion.
      integer :: outcomes(n_outcomes) = 0
      !> Motions while they are gathered, each once (n).
      type(found_type), allocatable, private :: gathered(:)
      integer, private :: n = 0
   end type findings_type

   !> The motions that one task has found, and whether it was begun.
   type :: batch_type
      type(found_type), allocatable :: motions(:)
      logical :: begun = .false.
      integer :: n = 0, tried = 0, inadmissible = 0, lost = 0, outcome = 0
   end type batch_type

contains

   !> All motions at a point; the result does not depend on the number of threads. A search that is
   !! stopped returns the motions found from the patterns, releases and states that were begun.
   subroutine find_motions(request, findings, progress)
      !> The request.
      type(find_request_type), intent(in) :: request
      !> The motions found.
      type(findings_type), intent(out) :: findings
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      real(wp) :: scale

      call add_expected_work(all_work, progress)
      scale = scale_of(request%system)
      allocate (findings%gathered(64))
      call from_patterns(request, scale, findings, progress)
      call from_releases(request, scale, findings, progress)
      call from_states(request, scale, findings, progress)
      call verify(request, findings)
      call describe_all(request, findings)
   end subroutine find_motions

   !> Adds the motions of all patterns without rest.
   subroutine from_patterns(request, scale, findings, progress)
      !> The request.
      type(find_request_type), intent(in) :: request
      !> Unit of positions, as `length_scale`.
      real(wp), intent(in) :: scale
      !> In and out: motions are added.
      type(findings_type), intent(inout) :: findings
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(pattern_type), allocatable :: patterns(:)
      type(lines_type), allocatable :: lines(:)
      type(batch_type), allocatable :: batches(:)
      real(wp) :: c(6)
      integer :: i, total

      allocate (patterns, source=side_patterns(request%max_impacts, request%max_cycles, &
         walls_alike(request%system)))
      findings%all_patterns = size(patterns)
      allocate (batches(size(patterns)), lines(size(patterns)))
      total = sum([(size(patterns(i)%sides)**2, i=1, size(patterns))])
      associate (system => request%system, osc => request%system%osc)
         ! without load, the clearance over the load is set so large that there are no motions
         c = oscillator_parameters(osc, system%r, &
            system%clearance/max(system%load, system%clearance*1.0e-300_wp))
      end associate
      !$omp parallel do schedule(dynamic, 1) num_threads(request%threads)
      do i = 1, size(patterns)
         if (is_stopped(progress)) cycle
         batches(i)%begun = .true.
         call begin_lines(patterns(i), c, request%guesses, request%max_impacts, lines(i), &
            batches(i)%tried, progress)
         call add_done_work(int(real(pattern_work, wp)*size(patterns(i)%sides)**2/total), progress)
      end do
      !$omp end parallel do
      findings%patterns = count(batches%begun)
      if (.not. is_stopped(progress)) call follow_births(request, patterns, lines)
      !$omp parallel do schedule(dynamic, 1) num_threads(request%threads)
      do i = 1, size(patterns)
         if (.not. batches(i)%begun) cycle
         call keep_admissible(request%system, patterns(i), lines(i)%unknowns(:, :lines(i)%n), &
            batches(i))
      end do
      !$omp end parallel do
      do i = 1, size(patterns)
         findings%guesses = findings%guesses + batches(i)%tried
         findings%inadmissible = findings%inadmissible + batches(i)%inadmissible
         findings%lost = findings%lost + batches(i)%lost
         call add_batch(request%system, batches(i), scale, findings)
      end do
   end subroutine from_patterns

   !> Follows the lines that begin where motions of other patterns graze, and the lines that begin
   !! on those.
   subroutine follow_births(request, patterns, lines)
      !> The request.
      type(find_request_type), intent(in) :: request
      !> All patterns searched.
      type(pattern_type), intent(in) :: patterns(:)
      !> (as `patterns`) In and out: the lines of each pattern.
      type(lines_type), intent(inout) :: lines(:)
      integer, parameter :: rounds = 3
      type(birth_type), allocatable :: births(:)
      integer, allocatable :: owners(:)
      integer :: taken(size(lines)), i, j, n, round

      taken = 0
      do round = 1, rounds
         n = sum(lines%n_births - taken)
         allocate (births(n), owners(n))
         n = 0
         do i = 1, size(lines)
            do j = taken(i) + 1, lines(i)%n_births
               n = n + 1
               births(n) = lines(i)%births(j)
               owners(n) = place_of(births(n)%pattern, patterns)
            end do
            taken(i) = lines(i)%n_births
         end do
         !$omp parallel do schedule(dynamic, 1) num_threads(request%threads) private(j)
         do i = 1, size(lines)
            do j = 1, n
               if (owners(j) == i) call follow_birth(lines(i), births(j))
            end do
         end do
         !$omp end parallel do
         deallocate (births, owners)
      end do
   end subroutine follow_births

   !> Place of a pattern in a list; 0 if it is not in it.
   pure integer function place_of(pattern, patterns) result(place)
      !> The pattern, and the list.
      type(pattern_type), intent(in) :: pattern, patterns(:)

      do place = size(patterns), 1, -1
         if (patterns(place)%cycles /= pattern%cycles) cycle
         if (size(patterns(place)%sides) /= size(pattern%sides)) cycle
         if (all(patterns(place)%sides == pattern%sides)) return
      end do
   end function place_of

   !> The admissible motions among those of one pattern.
   pure subroutine keep_admissible(system, pattern, unknowns, batch)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The pattern.
      type(pattern_type), intent(in) :: pattern
      !> x_i/D and theta_i of each (2N, m).
      real(wp), intent(in) :: unknowns(:, :)
      !> Out: the admissible motions, and the numbers of inadmissible and of undecided ones.
      type(batch_type), intent(inout) :: batch
      type(found_type) :: found
      integer :: i, n

      n = size(pattern%sides)
      allocate (batch%motions(size(unknowns, 2)))
      do i = 1, size(unknowns, 2)
         call new_found(system, pattern, system%clearance*unknowns(:n, i), unknowns(n + 1:, i), &
            found)
         if (found%status == stat%ok .and. found%admissible == yes) then
            batch%n = batch%n + 1
            batch%motions(batch%n) = found
         else if (found%status == stat%ok .and. found%admissible == no) then
            batch%inadmissible = batch%inadmissible + 1
         else
            batch%lost = batch%lost + 1
         end if
      end do
   end subroutine keep_admissible

   !> Adds the motions with rest that Newton's method finds from releases.
   subroutine from_releases(request, scale, findings, progress)
      !> The request.
      type(find_request_type), intent(in) :: request
      !> Unit of positions, as `length_scale`.
      real(wp), intent(in) :: scale
      !> In and out: motions are added.
      type(findings_type), intent(inout) :: findings
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(batch_type), allocatable :: batches(:)
      integer :: i, n, cycles, side, reported

      n = request%releases
      allocate (batches(2*n*request%max_cycles))
      !$omp parallel do schedule(dynamic, 1) num_threads(request%threads) private(cycles, side)
      do i = 1, size(batches)
         if (is_stopped(progress)) cycle
         batches(i)%begun = .true.
         cycles = (i - 1)/(2*n) + 1
         side = merge(1, -1, modulo(i - 1, 2*n) < n)
         allocate (batches(i)%motions(1))
         associate (system => request%system, found => batches(i)%motions(1))
            call new_resting(system, side, cycles, release_start(system%osc, system%r, &
               system%load, system%clearance, side, modulo(i - 1, n)), few_events, found)
            batches(i)%n = merge(1, 0, found%status == stat%ok)
         end associate
      end do
      !$omp end parallel do
      findings%releases = count(batches%begun)
      do i = 1, size(batches)
         call add_batch(request%system, batches(i), scale, findings)
      end do
      reported = 0
      call report_share(1.0_wp, release_work, reported, progress)
   end subroutine from_releases

   !> Adds the motions on which simulations settle.
   subroutine from_states(request, scale, findings, progress)
      !> The request.
      type(find_request_type), intent(in) :: request
      !> Unit of positions, as `length_scale`.
      real(wp), intent(in) :: scale
      !> In and out: motions are added.
      type(findings_type), intent(inout) :: findings
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(batch_type), allocatable :: batches(:)
      integer :: i

      allocate (batches(request%states))
      !$omp parallel do schedule(dynamic, 1) num_threads(request%threads)
      do i = 1, size(batches)
         if (is_stopped(progress)) cycle
         allocate (batches(i)%motions(longest))
         associate (system => request%system, batch => batches(i))
            call settle_on(system, state_start(system%osc, system%r, system%load, &
               system%clearance, i), request%settling, request%max_events, scale, batch%outcome, &
               batch%motions, batch%n, progress)
         end associate
         call add_done_work(state_work/size(batches), progress)
      end do
      !$omp end parallel do
      do i = 1, n_outcomes
         findings%outcomes(i) = count(batches%outcome == i)
      end do
      do i = 1, size(batches)
         call add_batch(request%system, batches(i), scale, findings)
      end do
   end subroutine from_states

   !> Whether both walls have the same coefficient of restitution.
   pure logical function walls_alike(system)
      !> The forced system.
      type(forced_system_type), intent(in) :: system

      walls_alike = abs(system%osc%restitution(1) - system%osc%restitution(2)) <= 0
   end function walls_alike

   !> Adds the motions that are not known yet, with their mirror images if the walls are alike.
   pure subroutine add_batch(system, batch, scale, findings)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The motions of one task.
      type(batch_type), intent(in) :: batch
      !> Unit of positions, as `length_scale`.
      real(wp), intent(in) :: scale
      !> In and out: motions are added.
      type(findings_type), intent(inout) :: findings
      type(found_type) :: once
      integer :: i

      do i = 1, batch%n
         once = in_standard_form(batch%motions(i), scale)
         call add(once, scale, findings)
         if (walls_alike(system)) call add(in_standard_form(mirrored(once), scale), scale, findings)
      end do
   end subroutine add_batch

   !> Adds a motion in standard form, if it is not known yet.
   pure subroutine add(motion, scale, findings)
      !> The motion.
      type(found_type), intent(in) :: motion
      !> Unit of positions, as `length_scale`.
      real(wp), intent(in) :: scale
      !> In and out: the motion is added.
      type(findings_type), intent(inout) :: findings
      type(found_type), allocatable :: more(:)
      integer :: i

      do i = 1, findings%n
         if (are_same(motion, findings%gathered(i), scale)) return
      end do
      if (findings%n == size(findings%gathered)) then
         allocate (more(2*findings%n))
         more(:findings%n) = findings%gathered
         call move_alloc(more, findings%gathered)
      end if
      findings%n = findings%n + 1
      findings%gathered(findings%n) = motion
   end subroutine add

   !> Computes each motion again in its standard form, with its verdicts; motions that do not
   !! converge then, or are not admissible, are counted and left out.
   subroutine verify(request, findings)
      !> The request.
      type(find_request_type), intent(in) :: request
      !> In and out: the motions.
      type(findings_type), intent(inout) :: findings
      type(found_type) :: again
      integer :: i, n
      logical :: kept, refuted

      !$omp parallel do schedule(dynamic, 1) num_threads(request%threads) private(again, n)
      do i = 1, findings%n
         associate (motion => findings%gathered(i))
            n = size(motion%pattern%sides)
            if (n == 0) cycle
            call new_found(request%system, motion%pattern, motion%unknowns(:n), &
               motion%unknowns(n + 1:), again)
            motion%status = again%status
            motion%admissible = again%admissible
            if (again%status == stat%ok) motion = again
         end associate
      end do
      !$omp end parallel do
      n = 0
      do i = 1, findings%n
         associate (motion => findings%gathered(i))
            kept = motion%status == stat%ok .and. motion%admissible == yes
            refuted = motion%status == stat%ok .and. motion%admissible == no
         end associate
         if (refuted) findings%inadmissible = findings%inadmissible + 1
         if (.not. (kept .or. refuted)) findings%lost = findings%lost + 1
         if (.not. kept) cycle
         n = n + 1
         if (n < i) findings%gathered(n) = findings%gathered(i)
      end do
      findings%n = n
   end subroutine verify

   !> The motions with their descriptions, in order.
   subroutine describe_all(request, findings)
      !> The request.
      type(find_request_type), intent(in) :: request
      !> In: the motions that were gathered. Out: with their descriptions.
      type(findings_type), intent(inout) :: findings
      type(described_type), allocatable :: described(:)
      integer, allocatable :: order(:)
      integer :: i, j, n

      allocate (described(findings%n))
      !$omp parallel do schedule(dynamic, 1) num_threads(request%threads)
      do i = 1, findings%n
         call describe_motion(request%system, findings%gathered(i), described(i))
      end do
      !$omp end parallel do
      order = pack([(i, i=1, size(described))], described%motion%status == stat%ok)
      findings%lost = findings%lost + size(described) - size(order)
      ! insertion sort: equal motions keep their order
      do i = 2, size(order)
         n = order(i)
         do j = i, 2, -1
            if (.not. comes_before(described(n), described(order(j - 1)))) exit
            order(j) = order(j - 1)
         end do
         order(j) = n
      end do
      ! not source=described(order): gfortran 12 counts its places from 0 and keeps a copy
      allocate (findings%motions(size(order)))
      do i = 1, size(order)
         findings%motions(i) = described(order(i))
      end do
   end subroutine describe_all

   !> Whether a motion is listed before another: stable ones first, then by load cycles, impacts,
   !! sides, and position.
   pure logical function comes_before(one, other) result(before)
      !> The motions, with their impacts.
      type(described_type), intent(in) :: one, other
      real(wp), parameter :: places = 1.0e6_wp
      character(:), allocatable :: symbols, others
      integer :: ranks(3, 2), i

      associate (a => one%motion, b => other%motion)
         ranks(:, 1) = [merge(0, 1, a%stable == yes), a%pattern%cycles, size(a%pattern%sides)]
         ranks(:, 2) = [merge(0, 1, b%stable == yes), b%pattern%cycles, size(b%pattern%sides)]
         do i = 1, 3
            before = ranks(i, 1) < ranks(i, 2)
            if (ranks(i, 1) /= ranks(i, 2)) return
         end do
         symbols = starred_symbols(a%pattern%sides)
         others = starred_symbols(b%pattern%sides)
         before = llt(symbols, others)
         if (symbols /= others) return
         before = anint(places*a%x(1)) > anint(places*b%x(1))
      end associate
   end function comes_before

end module vi_find
