!> Charts: the motions of one pattern on a grid of frequency ratios and clearances.
!!
!! Results have a column for each r, which holds a place for each clearance and each slot. Every
!! column or point is one task that writes to its own place, so the results are identical to the
!! last bit for any number of threads.
module vi_chart
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_equispaced_row, only: new_row, row_pairs, row_type, summary_type
   use vi_exact, only: setting_type
   use vi_grid_continuation, only: seed_grid, sweep_grid
   use vi_kinds, only: wp
   use vi_likeness, only: length_scale
   use vi_motion, only: unknown
   use vi_oscillator, only: oscillator_type
   use vi_points, only: exact_point
   use vi_chart_slots, only: assign_slots
   use vi_processor, only: runs_wide
   use vi_status, only: stat
   use vi_progress, only: add_expected_work, add_done_work, is_stopped
   implicit none (type, external)
   private

   public :: equispaced_chart, exact_chart

   !> Largest number of Newton iterations from a solution.
   integer, parameter :: polish = 10

contains

   !> Both equispaced motions at every point of a grid; a slot holds one of them throughout.
   subroutine equispaced_chart(osc, r, clearance, cycles, with_multipliers, threads, scalars, &
      multipliers, verdicts, status, progress)
      !> Oscillator with equal coefficients of restitution.
      type(oscillator_type), intent(in) :: osc
      !> (n) and (m): frequency ratios and clearances of the grid.
      real(wp), intent(in) :: r(:), clearance(:)
      !> Load cycles k in a period, odd.
      integer, intent(in) :: cycles
      !> Whether the multipliers are wanted, or only the verdict on them; they take the most time.
      logical, intent(in) :: with_multipliers
      !> Number of OpenMP threads.
      integer, intent(in) :: threads
      !> (4, 2, m, n): x_1, tau, x_min, x_max
      real(wp), intent(out) :: scalars(:, :, :, :)
      !> (4, 2, m, n), by decreasing modulus
      complex(wp), intent(out) :: multipliers(:, :, :, :)
      !> (3, 2, m, n): consistent, admissible, stable
      integer, intent(out) :: verdicts(:, :, :, :)
      !> (2, m, n) Codes of vi_status.
      integer, intent(out) :: status(:, :, :)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(row_type) :: row
      type(summary_type), allocatable :: pairs(:, :)
      logical :: wide
      integer :: i, j, k

      wide = runs_wide() /= 0
      call add_expected_work(size(r), progress)
      !$omp parallel do schedule(dynamic, 1) num_threads(threads) private(row, pairs, i, j)
      do k = 1, size(r)
         if (is_stopped(progress)) then
            status(:, :, k) = stat%not_computed
            verdicts(:, :, :, k) = unknown
            scalars(:, :, :, k) = ieee_value(1.0_wp, ieee_quiet_nan)
            multipliers(:, :, :, k) = cmplx(scalars(1, 1, 1, k), scalars(1, 1, 1, k), wp)
            cycle
         end if
         if (.not. allocated(pairs)) allocate (pairs(2, size(clearance)))
         call new_row(osc, r(k), cycles, row)
         call row_pairs(row, clearance, with_multipliers, wide, pairs)
         do j = 1, size(clearance)
            do i = 1, 2
               call store(pairs(i, j), scalars(:, i, j, k), multipliers(:, i, j, k), &
                  verdicts(:, i, j, k), status(i, j, k))
            end do
         end do
         call add_done_work(1, progress)
      end do
      !$omp end parallel do
   end subroutine equispaced_chart

   !> The exact motions of a pattern at every point of a grid, continued from some of its points.
   subroutine exact_chart(setting, r, clearance, points, guesses, symmetry, threads, phases, &
      impacts, scalars, multipliers, verdicts, status, found, progress)
      !> Given data; its r and clearance are not read.
      type(setting_type), intent(in) :: setting
      !> (n) and (m): frequency ratios and clearances of the grid.
      real(wp), intent(in) :: r(:), clearance(:)
      !> (2, p) points of the search, guesses at each, which motions, and OpenMP threads, as in
      !! `seed_grid`.
      integer, intent(in) :: points(:, :), guesses, symmetry, threads
      !> (N, capacity, m, n), (N, 6, capacity, m, n), (6, capacity, m, n) as in vi_points; NaN in
      !! empty slots.
      real(wp), intent(out) :: phases(:, :, :, :), impacts(:, :, :, :, :), scalars(:, :, :, :)
      !> (4, capacity, m, n) By decreasing modulus; NaN in empty slots.
      complex(wp), intent(out) :: multipliers(:, :, :, :)
      !> (3, capacity, m, n); (capacity, m, n) codes of vi_status, `stat%no_motion` in empty slots;
      !! (m, n) number of motions found, including those without a slot.
      integer, intent(out) :: verdicts(:, :, :, :), status(:, :, :), found(:, :)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      real(wp), allocatable :: unknowns(:, :, :, :)
      integer, allocatable :: marks(:, :, :, :), counts(:, :, :)
      integer :: gained, i, last, sweeps, left

      associate (keep => 4*max(size(status, 1), 4), m => size(clearance), n => size(r))
         allocate (unknowns(2*size(phases, 1), keep, m, n), source=0.0_wp)
         allocate (marks(2, keep, m, n), counts(2, m, n), source=0)
      end associate
      ! a continuation over the grid crosses the grid in about as many sweeps as it has lines
      sweeps = size(r) + size(clearance)
      left = 2*sweeps
      call add_expected_work(size(points, 2) + left + size(r), progress)
      do i = 1, size(points, 2), 4*threads
         if (is_stopped(progress)) exit
         last = min(i + 4*threads - 1, size(points, 2))
         call seed_grid(setting, r, clearance, points(:, i:last), guesses, symmetry, threads, &
            unknowns, marks, counts)
         call add_done_work(last - i + 1, progress)
      end do
      do while (.not. is_stopped(progress))
         call sweep_grid(setting, r, clearance, max(1, sweeps/20), symmetry, threads, unknowns, &
            marks, counts, gained, progress)
         if (gained == 0) exit
         call add_done_work(min(left, max(1, sweeps/20)), progress)
         left = left - min(left, max(1, sweeps/20))
      end do
      call add_done_work(left, progress)
      found = counts(2, :, :)
      call finish_chart(setting, r, clearance, threads, unknowns, marks(1, :, :, :), found, &
         phases, impacts, scalars, multipliers, verdicts, status, progress)
      if (is_stopped(progress)) where (status == stat%no_motion) status = stat%not_computed
   end subroutine exact_chart

   !> Puts the motions found into slots, and computes them again with their verdicts.
   subroutine finish_chart(setting, r, clearance, threads, unknowns, ranks, found, phases, &
      impacts, scalars, multipliers, verdicts, status, progress)
      !> Given data; its r and clearance are not read.
      type(setting_type), intent(in) :: setting
      !> (n) and (m): frequency ratios and clearances of the grid.
      real(wp), intent(in) :: r(:), clearance(:)
      !> Number of OpenMP threads.
      integer, intent(in) :: threads
      !> (2N, keep, m, n) x_i (F0/K) and theta_i (rad) of the motions found.
      real(wp), intent(in) :: unknowns(:, :, :, :)
      !> (keep, m, n) ranks of the motions, as in vi_grid_continuation; (m, n) number of motions at
      !! each point.
      integer, intent(in) :: ranks(:, :, :), found(:, :)
      !> (N, capacity, m, n), (N, 6, capacity, m, n), (6, capacity, m, n), (4, capacity, m, n): as
      !! in vi_points
      real(wp), intent(out) :: phases(:, :, :, :), impacts(:, :, :, :, :), scalars(:, :, :, :)
      !> (4, capacity, m, n) By decreasing modulus; NaN in empty slots.
      complex(wp), intent(out) :: multipliers(:, :, :, :)
      !> (3, capacity, m, n) consistent, admissible, stable; (capacity, m, n) codes of vi_status,
      !! `stat%no_motion` in empty slots.
      integer, intent(out) :: verdicts(:, :, :, :), status(:, :, :)
      !> Progress counters, see vi_progress. A request to stop is ignored here, because the results
      !! of the search would be lost.
      integer, intent(inout), optional :: progress(3)
      integer :: slots(size(ranks, 1), size(ranks, 2), size(ranks, 3))
      type(setting_type) :: here
      real(wp) :: nan, scale(size(clearance), size(r))
      integer :: i, j, k, s, n, iterations

      n = size(phases, 1)
      nan = ieee_value(1.0_wp, ieee_quiet_nan)
      phases = nan
      impacts = nan
      scalars = nan
      multipliers = cmplx(nan, nan, wp)
      verdicts = unknown
      status = stat%no_motion
      do k = 1, size(r)
         scale(:, k) = length_scale(setting%osc, r(k), clearance)
      end do
      call assign_slots(setting%pattern, scale, unknowns, ranks, found, size(status, 1), slots)
      !$omp parallel do schedule(dynamic, 1) num_threads(threads) private(here, i, j, s, iterations)
      do k = 1, size(r)
         do j = 1, size(clearance)
            here = setting
            here%r = r(k)
            here%clearance = clearance(j)
            do i = 1, found(j, k)
               s = slots(i, j, k)
               if (s == 0) cycle
               call exact_point(here, unknowns(:n, i, j, k), unknowns(n + 1:, i, j, k), polish, &
                  phases(:, s, j, k), impacts(:, :, s, j, k), scalars(:, s, j, k), multipliers(:, &
                  s, j, k), verdicts(:, s, j, k), status(s, j, k), iterations)
            end do
         end do
         call add_done_work(1, progress)
      end do
      !$omp end parallel do
   end subroutine finish_chart

   !> Writes one motion into its place.
   pure subroutine store(summary, scalars, multipliers, verdicts, status)
      !> The motion, or its status.
      type(summary_type), intent(in) :: summary
      !> (4) x_1, tau, x_min, x_max; NaN if the motion does not exist.
      real(wp), intent(out) :: scalars(:)
      !> (4) By decreasing modulus; NaN if the motion does not exist.
      complex(wp), intent(out) :: multipliers(:)
      !> (3) consistent, admissible, stable; a code of vi_status.
      integer, intent(out) :: verdicts(:), status
      real(wp) :: nan

      status = summary%status
      verdicts = [summary%consistent, summary%admissible, summary%stable]
      if (status == stat%ok) then
         scalars = [summary%x, summary%tau, summary%x_min, summary%x_max]
         multipliers = summary%multipliers
      else
         nan = ieee_value(1.0_wp, ieee_quiet_nan)
         scalars = nan
         multipliers = cmplx(nan, nan, wp)
      end if
   end subroutine store

end module vi_chart
