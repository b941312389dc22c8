!> Bifurcation diagrams: the motions on which simulations settle along a parameter.
!!
!! A run sweeps up or down and carries the state from value to value, or starts at each value from a
!! new state.
module vi_attractor_diagram
   use vi_attractor_settled, only: settle_chains
   use vi_attractor_spread, only: spread_states
   use vi_kinds, only: wp
   use vi_oscillator, only: oscillator_type
   implicit none (type, external)
   private

   public :: diagram, find_windows

   !> Added to x' from value to value, over half the clearance, so that a sweep leaves unstable
   !! motions.
   real(wp), parameter :: kick = 1.0e-9_wp

   !> A system with one varying parameter.
   type, public :: path_type
      type(oscillator_type) :: osc
      !> One element each, or one for each value of the parameter.
      real(wp), allocatable :: r(:), clearance(:)
      real(wp) :: load = 1
      !> The parameter: 1 to 6 for r, D, xi, mu, R1, R2; 5 with `tied` set for both walls.
      integer :: place = 0
      logical :: tied = .false.
      !> In rising order.
      real(wp), allocatable :: values(:)
   end type path_type

   !> The motions on which the runs settle: arrays (..., values, runs), contents as of
   !! `settle_chains`; load cycles of a period are 0 where none is confirmed.
   type, public :: diagram_type
      real(wp), allocatable :: impacts(:, :, :, :)
      integer, allocatable :: labels(:, :, :, :), found(:, :), periods(:, :, :), status(:, :)
      real(wp), allocatable :: extremes(:, :, :)
   end type diagram_type

contains

   !> Simulates all runs.
   subroutine diagram(path, directions, start, settling, keep, points, max_events, threads, &
      result, progress)
      !> The system and the values of its parameter.
      type(path_type), intent(in) :: path
      !> (runs): 1 up, -1 down, 0 with new states at each value.
      integer, intent(in) :: directions(:)
      !> (5): t, x, x', z, z' at the start of sweeps; if empty, a state with large velocities.
      real(wp), intent(in) :: start(:)
      !> Load cycles simulated first, load cycles examined, impacts kept.
      integer, intent(in) :: settling, keep, points
      !> Largest number of events of the simulation at a value, and number of OpenMP threads.
      integer, intent(in) :: max_events, threads
      !> Out: all runs, their values in rising order.
      type(diagram_type), intent(out), target :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      real(wp), allocatable, target :: parameters(:, :, :)
      real(wp), allocatable :: starts(:, :), ends(:, :, :)
      real(wp), pointer :: chain_parameters(:, :, :), impacts(:, :, :, :), extremes(:, :, :)
      integer, pointer :: labels(:, :, :, :), found(:, :), periods(:, :, :), status(:, :)
      integer :: n, runs, links, chains, i, j

      n = size(path%values)
      runs = size(directions)
      ! runs with new states at each value are chains of one link, with the values varying fastest
      links = merge(1, n, all(directions == 0))
      chains = n*runs/links
      allocate (parameters(6, n, runs), starts(5, chains), ends(5, links, chains))
      do j = 1, runs
         parameters(:, :, j) = parameters_along(path, directions(j))
         if (links == n) starts(:, j) = start_of(path, parameters(:, 1, j), start)
      end do
      do i = 1, merge(n, 0, links < n)
         starts(:, i::n) = spread_states(path%osc, parameters(1, i, 1), path%load, &
            parameters(2, i, 1), runs)
      end do
      call enlarge(points, n, runs, result)
      chain_parameters(1:6, 1:links, 1:chains) => parameters
      impacts(1:7, 1:points, 1:links, 1:chains) => result%impacts
      labels(1:2, 1:points, 1:links, 1:chains) => result%labels
      found(1:links, 1:chains) => result%found
      periods(1:4, 1:links, 1:chains) => result%periods
      extremes(1:2, 1:links, 1:chains) => result%extremes
      status(1:links, 1:chains) => result%status
      call settle_chains(chain_parameters, path%load, starts, settling, keep, kick, max_events, &
         threads, impacts, labels, found, periods, extremes, ends, status, progress)
      ! one that seems to repeat itself but is not confirmed has no period
      periods(1, :, :) = max(0, periods(1, :, :))
      do j = 1, runs
         if (directions(j) < 0) call turn_round(result, j)
      end do
   end subroutine diagram

   !> The six parameters at each value, in the order of a run.
   pure function parameters_along(path, direction) result(c)
      !> The system and the values of its parameter.
      type(path_type), intent(in) :: path
      !> 1 up, -1 down, 0 with new states at each value.
      integer, intent(in) :: direction
      real(wp) :: c(6, size(path%values))
      integer :: i, n

      n = size(path%values)
      do i = 1, n
         c(:, i) = [path%r(min(i, size(path%r))), path%clearance(min(i, size(path%clearance))), &
            path%osc%xi, path%osc%mu, path%osc%restitution]
      end do
      c(path%place, :) = path%values
      if (path%tied) c(6, :) = path%values
      if (direction < 0) c = c(:, n:1:-1)
   end function parameters_along

   !> The state at the start of a sweep.
   pure function start_of(path, c, start) result(state)
      !> The system.
      type(path_type), intent(in) :: path
      !> The parameters at its first value.
      real(wp), intent(in) :: c(6)
      !> (5) As given, or empty.
      real(wp), intent(in) :: start(:)
      real(wp) :: state(5)

      if (size(start) > 0) then
         state = start
      else
         state = reshape(spread_states(path%osc, c(1), path%load, c(2), 1), [5])
      end if
   end function start_of

   !> Allocates the arrays of a diagram.
   pure subroutine enlarge(points, n, runs, result)
      !> Impacts kept, values, and runs.
      integer, intent(in) :: points, n, runs
      !> Out: with arrays of undefined contents.
      type(diagram_type), intent(inout) :: result

      allocate (result%impacts(7, points, n, runs), result%labels(2, points, n, runs), &
         result%found(n, runs), result%periods(4, n, runs), result%extremes(2, n, runs), &
         result%status(n, runs))
   end subroutine enlarge

   !> Reverses a run that swept down, so that its values rise.
   pure subroutine turn_round(result, j)
      !> In and out: the runs.
      type(diagram_type), intent(inout) :: result
      !> Number of the run.
      integer, intent(in) :: j
      integer :: n

      n = size(result%found, 1)
      result%impacts(:, :, :, j) = result%impacts(:, :, n:1:-1, j)
      result%labels(:, :, :, j) = result%labels(:, :, n:1:-1, j)
      result%found(:, j) = result%found(n:1:-1, j)
      result%periods(:, :, j) = result%periods(:, n:1:-1, j)
      result%extremes(:, :, j) = result%extremes(:, n:1:-1, j)
      result%status(:, j) = result%status(n:1:-1, j)
   end subroutine turn_round

   !> The ranges of successive values over which a run keeps its period and its number of symbols.
   pure subroutine find_windows(periods, first, last, n)
      !> (4, values)
      integer, intent(in) :: periods(:, :)
      !> (values) First and last value of each of the n windows; the rest is not set.
      integer, intent(out) :: first(:), last(:)
      !> Number of windows.
      integer, intent(out) :: n
      integer :: i
      logical :: goes_on

      n = 0
      goes_on = .false.
      do i = 1, size(periods, 2)
         if (goes_on) goes_on = all(periods(:2, i) == periods(:2, i - 1))
         if (.not. goes_on .and. periods(1, i) > 0) then
            n = n + 1
            first(n) = i
            goes_on = .true.
         end if
         if (goes_on) last(n) = i
      end do
   end subroutine find_windows

end module vi_attractor_diagram
