!> A chart over a window of the plane, by the method that its pattern allows.
module vi_window
   !$ use omp_lib, only: omp_get_max_threads
   use vi_chart, only: equispaced_chart, exact_chart
   use vi_exact, only: setting_type
   use vi_kinds, only: wp
   use vi_likeness, only: allows_symmetry
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: default_restitution, pattern_type
   implicit none (type, external)
   private

   public :: chart_window, clearance_axis, even, r_axis, spaced

   !> Limits of a chart: points, and points x room x impacts.
   integer, parameter, public :: most_points = 1000000, most_numbers = 12500000

   !> A grid over the plane (r, D), and how it is searched.
   type, public :: window_type
      real(wp) :: r_min = 0, r_max = 0, clearance_min = 0, clearance_max = 0
      integer :: r_points = 0, clearance_points = 0
      !> Whether the clearances have equal ratios instead of equal differences.
      logical :: geometric = .false.
      !> 1: only motions that are their own mirror image, -1: only others, 0: both.
      integer :: symmetry = 0
      !> Slots for exact motions, guesses of a search, and searches along each axis.
      integer :: room = 4, guesses = 32, seeds = 12
   end type window_type

   !> The motions of a window: slots, clearances, frequency ratios.
   type, public :: map_type
      !> Modulus of the leading multiplier, greatest x.
      real(wp), allocatable :: leading(:, :, :), x_max(:, :, :)
      !> (3, ...) consistent, admissible, stable; and the status.
      integer, allocatable :: verdicts(:, :, :, :), status(:, :, :)
   end type map_type

contains

   !> The frequency ratios of the grid.
   pure function r_axis(window) result(axis)
      !> The grid.
      type(window_type), intent(in) :: window
      real(wp) :: axis(window%r_points)

      axis = even(window%r_min, window%r_max, window%r_points)
   end function r_axis

   !> The clearances of the grid.
   pure function clearance_axis(window) result(axis)
      !> The grid.
      type(window_type), intent(in) :: window
      real(wp) :: axis(window%clearance_points)

      axis = spaced(window%clearance_min, window%clearance_max, size(axis), window%geometric)
   end function clearance_axis

   !> Numbers with equal ratios or equal differences, both ends included.
   pure function spaced(low, high, n, geometric) result(axis)
      !> The ends, above 0 for equal ratios.
      real(wp), intent(in) :: low, high
      !> How many, at least 2.
      integer, intent(in) :: n
      !> Whether the ratios are equal, instead of the differences.
      logical, intent(in) :: geometric
      real(wp) :: axis(n)

      if (geometric) then
         axis = exp(even(log(low), log(high), n))
         axis(1) = low
         axis(n) = high
      else
         axis = even(low, high, n)
      end if
   end function spaced

   !> Numbers with equal differences, both ends included.
   pure function even(low, high, n) result(axis)
      !> The ends.
      real(wp), intent(in) :: low, high
      !> How many, at least 2.
      integer, intent(in) :: n
      real(wp) :: axis(n)
      integer :: i

      axis = [(i*((high - low)/(n - 1)) + low, i=0, n - 1)]
      axis(n) = high
   end function even

   !> All motions of a pattern in a window: the equispaced pair first, if it is wanted.
   subroutine chart_window(osc, pattern, window, map, tally)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      !> Sides of the impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> The grid, and how it is searched.
      type(window_type), intent(in) :: window
      !> The motions: the equispaced pair in slots 1 and 2, if it is wanted, then exact motions.
      type(map_type), intent(out) :: map
      !> Progress counters, see vi_tally.
      integer, intent(inout), optional :: tally(3)
      integer :: pair, room, kind, threads
      logical :: closed_form

      threads = 1
      !$ threads = omp_get_max_threads()
      closed_form = size(pattern%sides) == 2 .and. allows_symmetry(osc, pattern)
      pair = merge(2, 0, closed_form .and. window%symmetry >= 0)
      room = merge(0, window%room, closed_form .and. window%symmetry > 0)
      kind = merge(-1, window%symmetry, closed_form)
      if (.not. allows_symmetry(osc, pattern)) kind = 0
      associate (m => window%clearance_points, n => window%r_points)
         allocate (map%leading(pair + room, m, n), map%x_max(pair + room, m, n), map%verdicts(3, &
            pair + room, m, n), map%status(pair + room, m, n))
      end associate
      if (pair > 0) call add_pair(osc, pattern, window, threads, map, tally)
      if (room > 0) call add_exact(setting_type(osc, 1.0_wp, 1.0_wp, 1.0_wp, pattern, &
         default_restitution(pattern%sides, osc%restitution(1), osc%restitution(2))), window, &
         pair, kind, threads, map, tally)
   end subroutine chart_window

   !> Computes the equispaced pair in slots 1 and 2.
   subroutine add_pair(osc, pattern, window, threads, map, tally)
      !> Oscillator with equal coefficients of restitution.
      type(oscillator_type), intent(in) :: osc
      !> The pattern; its load cycles are read.
      type(pattern_type), intent(in) :: pattern
      !> The grid.
      type(window_type), intent(in) :: window
      !> Number of OpenMP threads.
      integer, intent(in) :: threads
      !> In and out: slots 1 and 2 are set.
      type(map_type), intent(inout) :: map
      !> Progress counters, see vi_tally.
      integer, intent(inout), optional :: tally(3)
      real(wp), allocatable :: scalars(:, :, :, :)
      complex(wp), allocatable :: multipliers(:, :, :, :)

      associate (m => window%clearance_points, n => window%r_points)
         allocate (scalars(4, 2, m, n), multipliers(4, 2, m, n))
      end associate
      call equispaced_chart(osc, r_axis(window), clearance_axis(window), pattern%cycles, .true., &
         threads, scalars, multipliers, map%verdicts(:, :2, :, :), map%status(:2, :, :), &
         tally)
      map%leading(:2, :, :) = abs(multipliers(1, :, :, :))
      map%x_max(:2, :, :) = scalars(4, :, :, :)
   end subroutine add_pair

   !> Computes exact motions in the other slots.
   subroutine add_exact(setting, window, pair, kind, threads, map, tally)
      !> Given data; its r and clearance are not read.
      type(setting_type), intent(in) :: setting
      !> The grid, and how it is searched.
      type(window_type), intent(in) :: window
      !> Slots before these; 1 for symmetric motions only, -1 for others only, 0 for both; OpenMP
      !! threads.
      integer, intent(in) :: pair, kind, threads
      !> In and out: the slots after `pair` are set.
      type(map_type), intent(inout) :: map
      !> Progress counters, see vi_tally.
      integer, intent(inout), optional :: tally(3)
      real(wp), allocatable :: phases(:, :, :, :), impacts(:, :, :, :, :), scalars(:, :, :, :)
      complex(wp), allocatable :: multipliers(:, :, :, :)
      integer, allocatable :: found(:, :), rows(:), columns(:), points(:, :)
      integer :: i, j

      associate (m => window%clearance_points, n => window%r_points, room => window%room, &
         impact => size(setting%pattern%sides))
         allocate (phases(impact, room, m, n), impacts(impact, 6, room, m, n), scalars(6, room, &
            m, n), multipliers(4, room, m, n), found(m, n))
         rows = spread_indices(m, window%seeds)
         columns = spread_indices(n, window%seeds)
      end associate
      allocate (points(2, size(rows)*size(columns)))
      do i = 1, size(columns)
         do j = 1, size(rows)
            points(:, (i - 1)*size(rows) + j) = [rows(j), columns(i)]
         end do
      end do
      call exact_chart(setting, r_axis(window), clearance_axis(window), points, window%guesses, &
         kind, threads, phases, impacts, scalars, multipliers, map%verdicts(:, pair + 1:, :, :), &
         map%status(pair + 1:, :, :), found, tally)
      map%leading(pair + 1:, :, :) = abs(multipliers(1, :, :, :))
      map%x_max(pair + 1:, :, :) = scalars(6, :, :, :)
   end subroutine add_exact

   !> At most `most` indices spread evenly over 1..n, both ends included (one alone: the middle).
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

end module vi_window
