!> A chart over a window of the plane, by the method that its pattern allows.
module vi_window
   !$ use omp_lib, only: omp_get_max_threads
   use vi_chart, only: equispaced_chart, exact_chart
   use vi_exact, only: setting_type
   use vi_kinds, only: wp
   use vi_likeness, only: allows_symmetry
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: default_restitution, pattern_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: chart_window

   real(wp), parameter :: pi = acos(-1.0_wp)
   !> Limits of a chart: points, and points x room x impacts.
   integer, parameter, public :: most_points = 1000000, most_numbers = 12500000

   !> A grid over the plane (r, D), and how it is searched.
   type, public :: window_type
      !> Frequency ratios and clearances, both increasing.
      real(wp), allocatable :: r(:), clearance(:)
      !> 1: only motions that are their own mirror image, -1: only others, 0: both.
      integer :: symmetry = 0
      !> Slots for exact motions, guesses of a search, and searches along each axis.
      integer :: room = 4, guesses = 32, seeds = 12
      !> Whether the multipliers of equispaced motions are wanted, which take most of the time.
      logical :: multipliers = .true.
   end type window_type

   !> The motions of a window, with the axes (slot, clearance, r) last.
   type, public :: map_type
      !> (N, ...) phases and displacements at the impacts; (4, ...) multipliers, by falling modulus.
      real(wp), allocatable :: phases(:, :, :, :), x(:, :, :, :)
      complex(wp), allocatable :: multipliers(:, :, :, :)
      !> Phase of equation (4), and the extreme displacements.
      real(wp), allocatable :: tau(:, :, :), x_min(:, :, :), x_max(:, :, :)
      !> (3, ...) consistent, admissible, stable; and the status.
      integer, allocatable :: verdicts(:, :, :, :), status(:, :, :)
      !> (m, n) motions found at each point, with those for which there was no room.
      integer, allocatable :: found(:, :)
   end type map_type

contains

   !> All motions of a pattern in a window: the equispaced pair first, if it is wanted.
   subroutine chart_window(osc, pattern, window, map, tally)
      !> The system.
      type(oscillator_type), intent(in) :: osc
      !> Without rest.
      type(pattern_type), intent(in) :: pattern
      !> The grid.
      type(window_type), intent(in) :: window
      !> What was found; of points that a stop left out the status is `not_computed`.
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
      associate (i => size(pattern%sides), k => pair + room, m => size(window%clearance), &
         n => size(window%r))
         allocate (map%phases(i, k, m, n), map%x(i, k, m, n), map%multipliers(4, k, m, n), &
            map%tau(k, m, n), map%x_min(k, m, n), map%x_max(k, m, n), map%verdicts(3, k, m, n), &
            map%status(k, m, n))
         allocate (map%found(m, n), source=0)
      end associate
      if (pair > 0) call add_pair(osc, pattern, window, threads, map, tally)
      if (room > 0) call add_exact(setting_type(osc, 1.0_wp, 1.0_wp, 1.0_wp, pattern, &
         default_restitution(pattern%sides, osc%restitution(1), osc%restitution(2))), window, &
         pair, kind, threads, map, tally)
   end subroutine chart_window

   !> The equispaced pair in the first two slots.
   subroutine add_pair(osc, pattern, window, threads, map, tally)
      !> With equal walls.
      type(oscillator_type), intent(in) :: osc
      !> RL or LR, of an odd number of cycles.
      type(pattern_type), intent(in) :: pattern
      !> The grid.
      type(window_type), intent(in) :: window
      !> Number of OpenMP threads.
      integer, intent(in) :: threads
      !> With room for all slots.
      type(map_type), intent(inout) :: map
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      real(wp), allocatable :: scalars(:, :, :, :)

      allocate (scalars(4, 2, size(window%clearance), size(window%r)))
      call equispaced_chart(osc, window%r, window%clearance, pattern%cycles, window%multipliers, &
         threads, scalars, map%multipliers(:, :2, :, :), map%verdicts(:, :2, :, :), &
         map%status(:2, :, :), tally)
      if (pattern%sides(1) < 0) then
         ! counted from the left wall: half a period later
         scalars(1, :, :, :) = -scalars(1, :, :, :)
         scalars(2, :, :, :) = scalars(2, :, :, :) - sign(pi, scalars(2, :, :, :))
      end if
      map%x(1, :2, :, :) = scalars(1, :, :, :)
      map%x(2, :2, :, :) = -scalars(1, :, :, :)
      map%tau(:2, :, :) = scalars(2, :, :, :)
      map%x_min(:2, :, :) = scalars(3, :, :, :)
      map%x_max(:2, :, :) = scalars(4, :, :, :)
      map%phases(1, :2, :, :) = 0*scalars(1, :, :, :)                      ! NaN where there is none
      map%phases(2, :2, :, :) = pattern%cycles*pi + 0*scalars(1, :, :, :)
      map%found = map%found + count(map%status(:2, :, :) == stat%ok, 1)
   end subroutine add_pair

   !> Exact motions, found by a flood, in the slots after those of the pair.
   subroutine add_exact(setting, window, pair, kind, threads, map, tally)
      !> The system and the pattern; r and clearance do not matter.
      type(setting_type), intent(in) :: setting
      !> The grid.
      type(window_type), intent(in) :: window
      !> Slots of the pair, the symmetry that is wanted, and threads.
      integer, intent(in) :: pair, kind, threads
      !> With room for all slots.
      type(map_type), intent(inout) :: map
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      real(wp), allocatable :: impacts(:, :, :, :, :), scalars(:, :, :, :)
      integer, allocatable :: found(:, :), rows(:), columns(:), points(:, :)
      integer :: i, j

      associate (m => size(window%clearance), n => size(window%r), room => window%room)
         allocate (impacts(size(setting%pattern%sides), 6, room, m, n), scalars(6, room, m, n), &
            found(m, n))
         rows = spread_indices(m, window%seeds)
         columns = spread_indices(n, window%seeds)
      end associate
      allocate (points(2, size(rows)*size(columns)))
      do i = 1, size(columns)
         do j = 1, size(rows)
            points(:, (i - 1)*size(rows) + j) = [rows(j), columns(i)]
         end do
      end do
      call exact_chart(setting, window%r, window%clearance, points, window%guesses, kind, &
         threads, map%phases(:, pair + 1:, :, :), impacts, scalars, map%multipliers(:, pair + 1:, &
         :, :), map%verdicts(:, pair + 1:, :, :), map%status(pair + 1:, :, :), found, tally)
      map%x(:, pair + 1:, :, :) = impacts(:, 1, :, :, :)
      map%tau(pair + 1:, :, :) = scalars(3, :, :, :)
      map%x_min(pair + 1:, :, :) = scalars(5, :, :, :)
      map%x_max(pair + 1:, :, :) = scalars(6, :, :, :)
      map%found = map%found + found
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
