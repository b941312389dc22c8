!> An atlas: the zones of all patterns in a window, found without being told the patterns.
!!
!! Patterns are enumerated up to a number of impacts and cycles; those with rest come from a survey
!! by simulation, whose attractors also are seeds of the zones. An attractor that lies in no zone of
!! its pattern is sought once more on a finer lattice. What became of the other points of the survey
!! is kept beside the zones.
module vi_atlas
   use vi_family, only: can_be_symmetric
   use vi_kinds, only: wp
   use vi_letters, only: standard_letters
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_sheet, only: zone_request_type
   use vi_survey, only: attractor_type, survey
   use vi_survey_outcome, only: count_outcomes, outcome_names
   use vi_tally, only: add_sight
   use vi_zone, only: find_zone, release_type, simulate_nodes, zone_type, zone_work
   use vi_zone_table, only: count_zone
   implicit none (type, external)
   private

   public :: find_atlas, outcomes_of

   type, public :: atlas_request_type
      type(oscillator_type) :: osc
      real(wp) :: r(2) = 0, clearance(2) = 0
      integer :: max_impacts = 5, max_cycles = 1
      !> Points of the survey, and load cycles simulated at each before it is looked at.
      integer :: survey = 400, settling = 400
      integer :: lines = 17, guesses = 24, points = 20000, threads = 1
   end type atlas_request_type

   !> One pattern's motions, symmetric or not, and where they are stable and admissible.
   type, public :: sheet_type
      type(pattern_type) :: pattern
      logical :: symmetric = .false.
      type(zone_type) :: zone
   end type sheet_type

   !> The zones of all patterns in a window, and what the survey settled on.
   type, public :: atlas_type
      type(sheet_type), allocatable :: sheets(:)
      !> Every point of the survey, and those with a motion within the limits.
      type(attractor_type), allocatable :: points(:), attractors(:)
      !> Whether each attractor lies in a zone of its pattern.
      logical, allocatable :: explained(:)
   end type atlas_type

contains

   !> All zones in a window.
   subroutine find_atlas(request, atlas, tally)
      type(atlas_request_type), intent(in) :: request
      type(atlas_type), intent(out) :: atlas
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      logical, allocatable :: again(:)
      integer :: i, j, announced

      ! the zones of patterns without rest are in sight before the survey begins
      allocate (atlas%attractors(0))
      call list_sheets(request, atlas)
      announced = zone_work*size(atlas%sheets)
      call add_sight(announced, tally)
      call survey_window(request, atlas, tally)
      deallocate (atlas%sheets)
      call list_sheets(request, atlas)
      allocate (again(size(atlas%sheets)), source=.true.)
      call add_sight(zone_work*size(again) - announced, tally)
      call trace_sheets(request, atlas, again, 1, tally)
      call explain(request, atlas)
      again = .false.
      do j = 1, size(atlas%sheets)
         do i = 1, size(atlas%attractors)
            again(j) = again(j) .or. (.not. atlas%explained(i) .and. &
               is_of(atlas%attractors(i), atlas%sheets(j)%pattern))
         end do
         ! on the same lattice nothing else would be found
         again(j) = again(j) .and. lattice(request, atlas%sheets(j)%pattern, 2) /= &
            lattice(request, atlas%sheets(j)%pattern, 1)
      end do
      if (.not. any(again)) return
      call add_sight(zone_work*count(again), tally)
      call trace_sheets(request, atlas, again, 2, tally)
      call explain(request, atlas)
   end subroutine find_atlas

   !> How many points of the survey there are of each outcome.
   pure function outcomes_of(atlas) result(counts)
      type(atlas_type), intent(in) :: atlas
      integer :: counts(size(outcome_names))

      counts = count_outcomes(atlas%points%outcome)
   end function outcomes_of

   !> What simulations settle on, and the attractors within the limits.
   subroutine survey_window(request, atlas, tally)
      type(atlas_request_type), intent(in) :: request
      type(atlas_type), intent(inout) :: atlas
      integer, intent(inout), optional :: tally(3)
      integer :: i, n

      allocate (atlas%points(request%survey))
      call survey(request%osc, request%r, request%clearance, request%settling, &
         request%max_impacts, request%max_cycles, request%threads, atlas%points, tally)
      deallocate (atlas%attractors)
      allocate (atlas%attractors(count(atlas%points%found)))
      n = 0
      do i = 1, size(atlas%points)
         if (.not. atlas%points(i)%found) cycle
         n = n + 1
         atlas%attractors(n) = atlas%points(i)
      end do
   end subroutine survey_window

   !> Finds the zones of some sheets, one task each.
   subroutine trace_sheets(request, atlas, wanted, finer, tally)
      type(atlas_request_type), intent(in) :: request
      type(atlas_type), intent(inout) :: atlas
      logical, intent(in) :: wanted(:)
      !> Times as many lattice lines.
      integer, intent(in) :: finer
      integer, intent(inout), optional :: tally(3)
      type(release_type), allocatable :: releases(:, :, :)
      integer :: j, status

      do j = 1, size(atlas%sheets)
         if (.not. wanted(j) .or. .not. rests(atlas%sheets(j)%pattern)) cycle
         call simulate_nodes(zone_request(request, atlas%sheets(j), finer), request%threads, &
            releases, tally)
         exit
      end do
      ! patterns with rest and long ones take longest: they come first
      !$omp parallel do schedule(dynamic, 1) num_threads(request%threads) private(status)
      do j = size(atlas%sheets), 1, -1
         if (.not. wanted(j)) cycle
         ! a sheet without motions has an empty zone, whatever the status
         if (rests(atlas%sheets(j)%pattern)) then
            call find_zone(zone_request(request, atlas%sheets(j), finer), seeds_of(atlas, &
               atlas%sheets(j)%pattern), atlas%sheets(j)%zone, status, tally, releases)
         else
            call find_zone(zone_request(request, atlas%sheets(j), finer), seeds_of(atlas, &
               atlas%sheets(j)%pattern), atlas%sheets(j)%zone, status, tally)
         end if
      end do
      !$omp end parallel do
   end subroutine trace_sheets

   !> What to look for as the zone of a sheet.
   pure function zone_request(request, sheet, finer) result(one)
      type(atlas_request_type), intent(in) :: request
      type(sheet_type), intent(in) :: sheet
      !> Times as many lattice lines.
      integer, intent(in) :: finer
      type(zone_request_type) :: one

      one = zone_request_type(request%osc, sheet%pattern, sheet%symmetric, request%r, &
         request%clearance, lattice(request, sheet%pattern, finer), request%guesses, &
         request%points)
   end function zone_request

   pure logical function rests(pattern)
      type(pattern_type), intent(in) :: pattern

      rests = any(abs(pattern%sides) == 2)
   end function rests

   !> Lattice lines: a motion with rest is only found inside its zone, which may be narrow.
   pure integer function lattice(request, pattern, finer)
      type(atlas_request_type), intent(in) :: request
      type(pattern_type), intent(in) :: pattern
      integer, intent(in) :: finer

      lattice = min(129, finer*(request%lines - 1) + 1)
      if (rests(pattern)) lattice = max(lattice, 33)
   end function lattice

   !> All patterns up to the limits, shortest first, and those with rest that the survey met.
   pure subroutine list_sheets(request, atlas)
      type(atlas_request_type), intent(in) :: request
      type(atlas_type), intent(inout) :: atlas
      integer :: letters(request%max_impacts), n, bits, cycles, i

      allocate (atlas%sheets(0))
      do n = 2, request%max_impacts
         do bits = 2**n - 2, 1, -1
            letters(:n) = [(merge(1, -1, btest(bits, n - i)), i=1, n)]
            do cycles = 1, request%max_cycles
               call add_sheets(request%osc, pattern_type(letters(:n), cycles), atlas%sheets)
            end do
         end do
      end do
      do i = 1, size(atlas%attractors)
         if (any(abs(atlas%attractors(i)%letters) == 2)) call add_sheets(request%osc, &
            pattern_type(atlas%attractors(i)%letters, atlas%attractors(i)%cycles), atlas%sheets)
      end do
   end subroutine list_sheets

   !> Adds a pattern in standard order that is not there yet: symmetric motions, then the others.
   pure subroutine add_sheets(osc, pattern, sheets)
      type(oscillator_type), intent(in) :: osc
      type(pattern_type), intent(in) :: pattern
      type(sheet_type), allocatable, intent(inout) :: sheets(:)
      type(sheet_type), allocatable :: longer(:)
      integer :: standard(size(pattern%sides)), shift, i, n, more
      logical :: mirrored, symmetric

      call standard_letters(pattern%sides, abs(osc%restitution(1) - osc%restitution(2)) <= 0, &
         standard, shift, mirrored)
      if (any(standard /= pattern%sides)) return
      n = size(sheets)
      do i = 1, n
         if (same_pattern(sheets(i)%pattern, pattern)) return
      end do
      symmetric = can_be_symmetric(pattern, osc%restitution)
      more = merge(2, 1, symmetric)
      allocate (longer(n + more))
      longer(:n) = sheets
      do i = n + 1, n + more
         longer(i)%pattern = pattern
      end do
      longer(n + 1)%symmetric = symmetric
      call move_alloc(longer, sheets)
   end subroutine add_sheets

   pure logical function same_pattern(a, b)
      type(pattern_type), intent(in) :: a, b

      same_pattern = a%cycles == b%cycles .and. size(a%sides) == size(b%sides)
      if (same_pattern) same_pattern = all(a%sides == b%sides)
   end function same_pattern

   !> The attractors of a pattern as seeds: r, D and the unknowns of the whole pattern (2 + 2N, m).
   pure function seeds_of(atlas, pattern) result(seeds)
      type(atlas_type), intent(in) :: atlas
      type(pattern_type), intent(in) :: pattern
      real(wp), allocatable :: seeds(:, :)
      integer :: i, m

      associate (items => atlas%attractors)
         allocate (seeds(2 + 2*size(pattern%sides), count([(is_of(items(i), pattern), &
            i=1, size(items))])))
         m = 0
         do i = 1, size(items)
            if (.not. is_of(items(i), pattern)) cycle
            m = m + 1
            seeds(:, m) = [items(i)%r, items(i)%clearance, items(i)%unknowns]
         end do
      end associate
   end function seeds_of

   pure logical function is_of(attractor, pattern)
      type(attractor_type), intent(in) :: attractor
      type(pattern_type), intent(in) :: pattern

      is_of = attractor%cycles == pattern%cycles .and. &
         size(attractor%letters) == size(pattern%sides)
      if (is_of) is_of = all(attractor%letters == pattern%sides)
   end function is_of

   !> Finds out which attractors lie in a zone of their pattern, of its symmetric motions or others.
   pure subroutine explain(request, atlas)
      type(atlas_request_type), intent(in) :: request
      type(atlas_type), intent(inout) :: atlas
      integer, allocatable :: mine(:)
      integer :: i, j

      associate (items => atlas%attractors)
         if (.not. allocated(atlas%explained)) allocate (atlas%explained(size(items)))
         atlas%explained = .false.
         do j = 1, size(atlas%sheets)
            mine = pack([(i, i=1, size(items))], &
               [(is_of(items(i), atlas%sheets(j)%pattern), i=1, size(items))])
            if (size(mine) == 0) cycle
            atlas%explained(mine) = atlas%explained(mine) .or. count_zone(atlas%sheets(j)%zone, &
               request%r, request%clearance, &
               reshape([(items(mine(i))%r, items(mine(i))%clearance, i=1, size(mine))], &
               [2, size(mine)])) > 0
         end do
      end associate
   end subroutine explain

end module vi_atlas
