!> A chart over a window of the plane, by the method that its pattern allows.
module vi_chart_grid
   use vi_chart, only: equispaced_chart, exact_chart
   use vi_exact, only: setting_type
   use vi_family, only: can_be_symmetric
   use vi_kinds, only: pi, wp
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: default_restitution, pattern_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: compute_chart

   !> Most points of a chart.
   integer, parameter, public :: most_points = 1000000

   !> A grid over the plane (r, D), and how it is searched.
   type, public :: chart_grid_type
      !> Frequency ratios and clearances, both increasing.
      real(wp), allocatable :: r(:), clearance(:)
      !> 1: only motions that are their own mirror image, -1: only others, 0: both.
      integer :: symmetry = 0
      !> Slots for exact motions, guesses of a search, and searches along each axis.
      integer :: slots = 4, guesses = 32, seeds = 12
      !> Whether the multipliers of equispaced motions are wanted, which take most of the time.
      logical :: multipliers = .true.
   end type chart_grid_type

   !> The motions of a grid, with the axes (slot, clearance, r) last.
   type, public :: chart_type
      !> (N, ...) phases and displacements at the impacts; (4, ...) multipliers, by decreasing
      !! modulus.
      real(wp), allocatable :: phases(:, :, :, :), x(:, :, :, :)
      complex(wp), allocatable :: multipliers(:, :, :, :)
      !> Phase of equation (4), and the extreme displacements.
      real(wp), allocatable :: tau(:, :, :), x_min(:, :, :), x_max(:, :, :)
      !> (3, ...) consistent, admissible, stable; and the status.
      integer, allocatable :: verdicts(:, :, :, :), status(:, :, :)
      !> (m, n) number of motions found at each point, including those without a slot.
      integer, allocatable :: found(:, :)
   end type chart_type

contains

   !> All motions of a pattern in a window: the equispaced pair first, if it is wanted.
   subroutine compute_chart(osc, pattern, grid, threads, chart, progress)
      !> The system.
      type(oscillator_type), intent(in) :: osc
      !> The pattern, without rest.
      type(pattern_type), intent(in) :: pattern
      !> The grid.
      type(chart_grid_type), intent(in) :: grid
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> The motions found; points that were not reached before a stop have the status
      !! `not_computed`.
      type(chart_type), intent(out) :: chart
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      integer :: pair, slots, kind
      logical :: closed_form

      closed_form = size(pattern%sides) == 2 .and. can_be_symmetric(pattern, osc%restitution)
      pair = merge(2, 0, closed_form .and. grid%symmetry >= 0)
      slots = merge(0, grid%slots, closed_form .and. grid%symmetry > 0)
      kind = merge(-1, grid%symmetry, closed_form)
      if (.not. can_be_symmetric(pattern, osc%restitution)) kind = 0
      associate (i => size(pattern%sides), k => pair + slots, m => size(grid%clearance), &
         n => size(grid%r))
         allocate (chart%phases(i, k, m, n), chart%x(i, k, m, n), chart%multipliers(4, k, m, n), &
            chart%tau(k, m, n), chart%x_min(k, m, n), chart%x_max(k, m, n), chart%verdicts(3, k, &
            m, n), chart%status(k, m, n))
         allocate (chart%found(m, n), source=0)
      end associate
      if (pair > 0) call add_pair(osc, pattern, grid, threads, chart, progress)
      if (slots > 0) call add_exact(setting_type(osc, 1.0_wp, 1.0_wp, 1.0_wp, pattern, &
         default_restitution(pattern%sides, osc%restitution(1), osc%restitution(2))), grid, &
         pair, kind, threads, chart, progress)
   end subroutine compute_chart

   !> The equispaced pair in the first two slots.
   subroutine add_pair(osc, pattern, grid, threads, chart, progress)
      !> The system, with equal walls.
      type(oscillator_type), intent(in) :: osc
      !> RL or LR, of an odd number of cycles.
      type(pattern_type), intent(in) :: pattern
      !> The grid.
      type(chart_grid_type), intent(in) :: grid
      !> Number of OpenMP threads.
      integer, intent(in) :: threads
      !> The chart, with all slots.
      type(chart_type), intent(inout) :: chart
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      real(wp), allocatable :: scalars(:, :, :, :)

      allocate (scalars(4, 2, size(grid%clearance), size(grid%r)))
      call equispaced_chart(osc, grid%r, grid%clearance, pattern%cycles, grid%multipliers, &
         threads, scalars, chart%multipliers(:, :2, :, :), chart%verdicts(:, :2, :, :), &
         chart%status(:2, :, :), progress)
      if (pattern%sides(1) < 0) then
         ! counted from the left wall: half a period later
         scalars(1, :, :, :) = -scalars(1, :, :, :)
         scalars(2, :, :, :) = scalars(2, :, :, :) - sign(pi, scalars(2, :, :, :))
      end if
      chart%x(1, :2, :, :) = scalars(1, :, :, :)
      chart%x(2, :2, :, :) = -scalars(1, :, :, :)
      chart%tau(:2, :, :) = scalars(2, :, :, :)
      chart%x_min(:2, :, :) = scalars(3, :, :, :)
      chart%x_max(:2, :, :) = scalars(4, :, :, :)
      chart%phases(1, :2, :, :) = 0*scalars(1, :, :, :)                      ! NaN: no motion
      chart%phases(2, :2, :, :) = pattern%cycles*pi + 0*scalars(1, :, :, :)
      chart%found = chart%found + count(chart%status(:2, :, :) == stat%ok, 1)
   end subroutine add_pair

   !> Exact motions, found by a continuation over the grid, in the slots after those of the pair.
   subroutine add_exact(setting, grid, pair, kind, threads, chart, progress)
      !> The system and the pattern; r and clearance are not read.
      type(setting_type), intent(in) :: setting
      !> The grid.
      type(chart_grid_type), intent(in) :: grid
      !> Number of slots of the pair, the symmetry that is wanted, and number of OpenMP threads.
      integer, intent(in) :: pair, kind, threads
      !> The chart, with all slots.
      type(chart_type), intent(inout) :: chart
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      real(wp), allocatable :: impacts(:, :, :, :, :), scalars(:, :, :, :)
      integer, allocatable :: found(:, :), rows(:), columns(:), points(:, :)
      integer :: i, j

      associate (m => size(grid%clearance), n => size(grid%r), slots => grid%slots)
         allocate (impacts(size(setting%pattern%sides), 6, slots, m, n), scalars(6, slots, m, n), &
            found(m, n))
         rows = spread_indices(m, grid%seeds)
         columns = spread_indices(n, grid%seeds)
      end associate
      allocate (points(2, size(rows)*size(columns)))
      do i = 1, size(columns)
         do j = 1, size(rows)
            points(:, (i - 1)*size(rows) + j) = [rows(j), columns(i)]
         end do
      end do
      call exact_chart(setting, grid%r, grid%clearance, points, grid%guesses, kind, &
         threads, chart%phases(:, pair + 1:, :, :), impacts, scalars, chart%multipliers(:, pair + &
         1:, &
         :, :), chart%verdicts(:, pair + 1:, :, :), chart%status(pair + 1:, :, :), found, progress)
      chart%x(:, pair + 1:, :, :) = impacts(:, 1, :, :, :)
      chart%tau(pair + 1:, :, :) = scalars(3, :, :, :)
      chart%x_min(pair + 1:, :, :) = scalars(5, :, :, :)
      chart%x_max(pair + 1:, :, :) = scalars(6, :, :, :)
      chart%found = chart%found + found
   end subroutine add_exact

   !> At most `most` indices spread evenly over 1..n, including both ends (the middle if only one).
   pure function spread_indices(n, most) result(indices)
      !> Last index, and largest number of indices.
      integer, intent(in) :: n, most
      integer, allocatable :: indices(:)
      integer :: i, steps

      steps = min(n, most) - 1
      if (steps == 0) then
         indices = [n/2 + 1]
      else
         indices = [((2*i*(n - 1) + steps)/(2*steps) + 1, i=0, steps)]
      end if
   end function spread_indices

end module vi_chart_grid
