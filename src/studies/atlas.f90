!> An atlas: the zones of all patterns in a window, found without being told the patterns.
!!
!! Patterns are enumerated up to a number of impacts and cycles; those with rest come from a survey
!! by simulation, whose attractors also are seeds of the zones. An attractor that lies in no zone of
!! its pattern is sought once more on a finer lattice.
module vi_atlas
   use vi_family, only: can_be_symmetric
   use vi_kinds, only: wp
   use vi_letters, only: standard_letters
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_survey, only: attractor_type, survey
   use vi_zone, only: find_zone, zone_request_type, zone_type
   implicit none (type, external)
   private

   public :: find_atlas

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

   type, public :: atlas_type
      type(sheet_type), allocatable :: sheets(:)
      type(attractor_type), allocatable :: attractors(:)
      !> Whether each attractor lies in a zone of its pattern.
      logical, allocatable :: explained(:)
   end type atlas_type

contains

   !> All zones in a window.
   subroutine find_atlas(request, atlas)
      type(atlas_request_type), intent(in) :: request
      type(atlas_type), intent(out) :: atlas
      logical, allocatable :: again(:)
      integer :: i, j

      allocate (atlas%attractors(request%survey))
      call survey(request%osc, request%r, request%clearance, request%settling, &
         request%max_impacts, request%max_cycles, request%threads, atlas%attractors)
      atlas%attractors = pack(atlas%attractors, atlas%attractors%found)
      call list_sheets(request, atlas)
      allocate (again(size(atlas%sheets)), source=.true.)
      call trace_sheets(request, atlas, again, 1)
      atlas%explained = [(explains(atlas, atlas%attractors(i)), i=1, size(atlas%attractors))]
      do j = 1, size(atlas%sheets)
         again(j) = any([(.not. atlas%explained(i) .and. same_pattern(atlas%sheets(j)%pattern, &
            pattern_of(atlas%attractors(i))), i=1, size(atlas%attractors))])
      end do
      call trace_sheets(request, atlas, again, 2)
      atlas%explained = [(explains(atlas, atlas%attractors(i)), i=1, size(atlas%attractors))]
   end subroutine find_atlas

   !> Finds the zones of some sheets, one task each.
   subroutine trace_sheets(request, atlas, wanted, finer)
      type(atlas_request_type), intent(in) :: request
      type(atlas_type), intent(inout) :: atlas
      logical, intent(in) :: wanted(:)
      !> Times as many lattice lines.
      integer, intent(in) :: finer
      integer :: j, status

      !$omp parallel do schedule(dynamic, 1) num_threads(request%threads) private(status)
      do j = 1, size(atlas%sheets)
         if (wanted(j)) call find_zone(zone_request_type(request%osc, atlas%sheets(j)%pattern, &
            atlas%sheets(j)%symmetric, request%r, request%clearance, &
            lattice(request, atlas%sheets(j)%pattern, finer), request%guesses, request%points), &
            seeds_of(atlas, atlas%sheets(j)%pattern), atlas%sheets(j)%zone, status)
      end do
      !$omp end parallel do
   end subroutine trace_sheets

   !> Lattice lines: a motion with rest is only found inside its zone, which may be narrow.
   pure integer function lattice(request, pattern, finer)
      type(atlas_request_type), intent(in) :: request
      type(pattern_type), intent(in) :: pattern
      integer, intent(in) :: finer

      lattice = min(129, finer*(request%lines - 1) + 1)
      if (any(abs(pattern%sides) == 2)) lattice = max(lattice, 33)
   end function lattice

   !> All patterns up to the limits, and those with rest that the survey met.
   pure subroutine list_sheets(request, atlas)
      type(atlas_request_type), intent(in) :: request
      type(atlas_type), intent(inout) :: atlas
      integer :: letters(request%max_impacts), n, bits, cycles, i

      allocate (atlas%sheets(0))
      do n = 2, request%max_impacts
         do bits = 1, 2**n - 2
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
      symmetric = all(abs(pattern%sides) == 1) .and. can_be_symmetric(pattern, osc%restitution)
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
      logical :: wanted(size(atlas%attractors))
      integer :: i, m

      wanted = [(same_pattern(pattern, pattern_of(atlas%attractors(i))), i=1, size(wanted))]
      allocate (seeds(2 + 2*size(pattern%sides), count(wanted)))
      m = 0
      do i = 1, size(wanted)
         if (.not. wanted(i)) cycle
         m = m + 1
         seeds(:, m) = [atlas%attractors(i)%r, atlas%attractors(i)%clearance, &
            atlas%attractors(i)%unknowns]
      end do
   end function seeds_of

   pure function pattern_of(attractor) result(pattern)
      type(attractor_type), intent(in) :: attractor
      type(pattern_type) :: pattern

      pattern = pattern_type(attractor%letters, attractor%cycles)
   end function pattern_of

   !> Whether an attractor lies in a zone of its pattern.
   pure logical function explains(atlas, attractor)
      type(atlas_type), intent(in) :: atlas
      type(attractor_type), intent(in) :: attractor
      integer :: i, j, turns

      explains = .false.
      do j = 1, size(atlas%sheets)
         if (.not. same_pattern(atlas%sheets(j)%pattern, pattern_of(attractor))) cycle
         turns = 0
         associate (zone => atlas%sheets(j)%zone)
            do i = 1, zone%n
               if (zone%loops(i)%closed) turns = turns + abs(winding(zone, i, &
                  ([attractor%r, log(attractor%clearance)] - zone%sheet%origin)/zone%sheet%scale))
            end do
         end associate
         ! a hole goes round once more
         explains = mod(turns, 2) == 1
         if (explains) return
      end do
   end function explains

   !> How often a loop goes round a point of the unit square.
   pure integer function winding(zone, i, q)
      type(zone_type), intent(in) :: zone
      integer, intent(in) :: i
      real(wp), intent(in) :: q(2)
      real(wp) :: a(2), b(2), side
      integer :: j, m

      winding = 0
      associate (loop => zone%loops(i))
         m = size(loop%points, 1) - 2
         do j = 1, loop%n
            a = loop%points(m + 1:, j)
            b = loop%points(m + 1:, merge(1, j + 1, j == loop%n))
            if ((a(2) <= q(2)) .eqv. (b(2) <= q(2))) cycle
            side = (b(1) - a(1))*(q(2) - a(2)) - (q(1) - a(1))*(b(2) - a(2))
            if (a(2) <= q(2) .and. side > 0) winding = winding + 1
            if (a(2) > q(2) .and. side < 0) winding = winding - 1
         end do
      end associate
   end function winding

end module vi_atlas
