!> Exact motions of one pattern on a grid: found at a few points, then continued to their
!! neighbours.
!!
!! A sweep visits every point next to one that gained motions in the previous sweep, and starts
!! Newton's method there from these. Each point reads only results from before the sweep and writes
!! only its own, so the results are identical to the last bit for any number of threads.
!!
!! The state of the continuation, with the clearances as rows j and the frequency ratios as columns
!! k:
!!
!! - `unknowns` (2N, keep, m, n): x_i, theta_i of each motion;
!! - `marks` (2, keep, m, n): its rank, and the neighbour it came from (0 if none);
!! - `counts` (2, m, n): motions at the point before the last sweep, and now.
module vi_grid_continuation
   use vi_assess, only: assess_exact, assess_flights
   use vi_exact, only: setting_type, solve_exact
   use vi_kinds, only: wp
   use vi_likeness, only: distance, is_repeated, is_symmetric, length_scale, same
   use vi_motion, only: motion_type, yes
   use vi_orbit, only: oscillator_parameters
   use vi_search, only: search_pattern
   use vi_status, only: stat
   use vi_progress, only: is_stopped
   implicit none (type, external)
   private

   public :: seed_grid, sweep_grid

   !> Ranks: the equations are solved; also admissible; also stable.
   integer, parameter, public :: solved = 0, admissible = 1, admissible_stable = 2
   !> Neighbours of (j, k), and for each the number of (j, k) among its own neighbours.
   integer, parameter, public :: steps(2, 4) = reshape([1, 0, -1, 0, 0, 1, 0, -1], [2, 4])
   integer, parameter :: back(4) = [2, 1, 4, 3]
   !> Largest number of Newton iterations from a neighbour, and of motions found by a search at a
   !! point.
   integer, parameter :: most_iterations = 15, most_found = 24

contains

   !> Searches for motions at some points of the grid.
   subroutine seed_grid(setting, r, clearance, points, guesses, symmetry, threads, unknowns, &
      marks, counts)
      !> Given data; its r and clearance are not read.
      type(setting_type), intent(in) :: setting
      !> (n) and (m): frequency ratios and clearances of the grid.
      real(wp), intent(in) :: r(:), clearance(:)
      !> (2, p): j, k of each point.
      integer, intent(in) :: points(:, :)
      !> Guesses at each point.
      integer, intent(in) :: guesses
      !> 1: only motions that are their own mirror image, -1: only others, 0: both.
      integer, intent(in) :: symmetry
      !> Number of OpenMP threads.
      integer, intent(in) :: threads
      !> (2N, keep, m, n) In and out: motions are added.
      real(wp), intent(inout) :: unknowns(:, :, :, :)
      !> (2, keep, m, n) and (2, m, n), as above. In and out.
      integer, intent(inout) :: marks(:, :, :, :), counts(:, :, :)
      type(setting_type) :: here
      real(wp) :: found(size(unknowns, 1), most_found)
      integer :: i, p, n_found, tried

      !$omp parallel do schedule(dynamic, 1) num_threads(threads) &
      !$omp private(here, found, i, n_found, tried)
      do p = 1, size(points, 2)
         associate (j => points(1, p), k => points(2, p))
            here = at(setting, r(k), clearance(j))
            n_found = 0
            call search_pattern(here%pattern, oscillator_parameters(here%osc, here%r, &
               here%clearance/here%load), guesses, found, n_found, tried, 0)
            do i = 1, n_found
               found(:size(found, 1)/2, i) = here%clearance*found(:size(found, 1)/2, i)
               call try_guess(here, found(:, i), 0, symmetry, unknowns(:, :, j, k), marks(:, :, &
                  j, k), counts(2, j, k))
            end do
         end associate
      end do
      !$omp end parallel do
   end subroutine seed_grid

   !> Continues the newest motions for a number of sweeps, or until no point gains one.
   subroutine sweep_grid(setting, r, clearance, sweeps, symmetry, threads, unknowns, marks, &
      counts, gained, progress)
      !> Given data; its r and clearance are not read.
      type(setting_type), intent(in) :: setting
      !> (n) and (m): frequency ratios and clearances of the grid.
      real(wp), intent(in) :: r(:), clearance(:)
      !> Largest number of sweeps; symmetry as in `seed_grid`; OpenMP threads.
      integer, intent(in) :: sweeps, symmetry, threads
      !> (2N, keep, m, n) In and out: motions are added.
      real(wp), intent(inout) :: unknowns(:, :, :, :)
      !> (2, keep, m, n) and (2, m, n), as above. In and out.
      integer, intent(inout) :: marks(:, :, :, :), counts(:, :, :)
      !> Motions gained in the last sweep: 0 when the continuation is complete.
      integer, intent(out) :: gained
      !> As in vi_progress: a stop leaves the points that are not visited yet as they are.
      integer, intent(inout), optional :: progress(3)
      integer :: before(2, size(clearance), size(r)), s, j, k

      gained = 0
      do s = 1, sweeps
         before = counts
         !$omp parallel do collapse(2) schedule(dynamic, 32) num_threads(threads)
         do k = 1, size(r)
            do j = 1, size(clearance)
               if (is_stopped(progress)) cycle
               call visit(setting, r, clearance, j, k, symmetry, before, unknowns, marks, &
                  counts(2, j, k))
            end do
         end do
         !$omp end parallel do
         counts(1, :, :) = before(2, :, :)
         gained = sum(counts(2, :, :) - counts(1, :, :))
         if (gained == 0) return
         if (is_stopped(progress)) return
      end do
   end subroutine sweep_grid

   !> Starts Newton's method at a point from the newest motions of its four neighbours.
   pure subroutine visit(setting, r, clearance, j, k, symmetry, before, unknowns, marks, n_here)
      !> Given data; its r and clearance are not read.
      type(setting_type), intent(in) :: setting
      !> (n) and (m): frequency ratios and clearances of the grid.
      real(wp), intent(in) :: r(:), clearance(:)
      !> The point; symmetry as in `seed_grid`; `counts` before this sweep.
      integer, intent(in) :: j, k, symmetry, before(:, :, :)
      !> (2N, keep, m, n) In and out: motions of the point are added.
      real(wp), intent(inout) :: unknowns(:, :, :, :)
      !> (2, keep, m, n) and motions at the point. In and out.
      integer, intent(inout) :: marks(:, :, :, :), n_here
      real(wp) :: guess(size(unknowns, 1))
      integer :: side, i, jj, kk

      do side = 1, 4
         jj = j + steps(1, side)
         kk = k + steps(2, side)
         if (.not. on_grid(jj, kk, before)) cycle
         do i = before(1, jj, kk) + 1, before(2, jj, kk)
            ! skip a motion that came from this point
            if (marks(2, i, jj, kk) == back(side)) cycle
            call extrapolate(length_scale(setting%osc, r(kk), clearance(jj)), jj, kk, steps(:, &
               side), unknowns(:, i, jj, kk), before, unknowns, guess)
            call try_guess(at(setting, r(k), clearance(j)), guess, side, symmetry, unknowns(:, :, &
               j, k), marks(:, :, j, k), n_here)
         end do
      end do
   end subroutine visit

   !> A guess by linear extrapolation from a motion at (j, k) and the same motion one step further
   !! away, if there is one; otherwise the motion itself.
   pure subroutine extrapolate(scale, j, k, step, near, before, unknowns, guess)
      !> Unit of positions, as `length_scale`.
      real(wp), intent(in) :: scale
      !> The neighbour; the step from the point to it; `counts` before this sweep.
      integer, intent(in) :: j, k, step(2), before(:, :, :)
      !> (2N) the motion there; (2N, keep, m, n) all motions.
      real(wp), intent(in) :: near(:), unknowns(:, :, :, :)
      !> (2N) Guess at the point.
      real(wp), intent(out) :: guess(:)
      !> Motions at two neighbouring points that are further apart than this are different ones.
      real(wp), parameter :: reach = 0.2_wp
      real(wp) :: gap(size(near)), least, item
      integer :: i, jj, kk

      guess = near
      jj = j + step(1)
      kk = k + step(2)
      if (.not. on_grid(jj, kk, before)) return
      least = reach
      do i = 1, before(2, jj, kk)
         gap = near - unknowns(:, i, jj, kk)
         item = max(maxval(abs(gap(:size(gap)/2)))/scale, &
            maxval(abs(gap(size(gap)/2 + 1:))))
         if (item >= least) cycle
         least = item
         guess = near + gap
      end do
   end subroutine extrapolate

   !> Whether a point belongs to the grid.
   pure logical function on_grid(j, k, counts)
      !> The point, and the (2, m, n) counts of the grid; only their shape is read.
      integer, intent(in) :: j, k, counts(:, :, :)

      on_grid = j >= 1 .and. k >= 1 .and. j <= size(counts, 2) .and. k <= size(counts, 3)
   end function on_grid

   !> Newton's method from a guess; a motion that is new at the point is added.
   pure subroutine try_guess(setting, guess, origin, symmetry, unknowns, marks, n_here)
      !> Given data at the point.
      type(setting_type), intent(in) :: setting
      !> (2N) x_i (F0/K), theta_i (rad).
      real(wp), intent(in) :: guess(:)
      !> Number of the neighbour it came from, 0 if none; symmetry as in `seed_grid`.
      integer, intent(in) :: origin, symmetry
      !> (2N, keep) In and out: motions of the point.
      real(wp), intent(inout) :: unknowns(:, :)
      !> (2, keep) and number of motions of the point. In and out.
      integer, intent(inout) :: marks(:, :), n_here
      type(motion_type) :: motion
      real(wp) :: u(size(guess)), none(size(guess), 0), scale
      integer :: n, i, iterations, rank

      n = size(guess)/2
      u = guess
      call solve_exact(setting, u(:n), u(n + 1:), most_iterations, none, motion, iterations)
      if (motion%status /= stat%ok) return
      u(n + 1:) = u(n + 1:) + (motion%tau - u(n + 1))
      scale = length_scale(setting%osc, setting%r, setting%clearance)
      do i = 1, n_here
         if (distance(setting%pattern, scale, unknowns(:, i), u) < same) return
      end do
      if (is_repeated(setting%pattern, scale, u)) return
      if (symmetry /= 0) then
         if (is_symmetric(setting%pattern, scale, u) .neqv. symmetry > 0) return
      end if
      call assess_exact(motion)
      call assess_flights(motion)
      rank = solved
      if (motion%admissible == yes) rank = merge(admissible_stable, admissible, &
         motion%stable == yes)
      ! the last quarter of the room is kept for admissible stable motions, the third quarter for
      ! admissible ones
      if (n_here >= (size(marks, 2)*(rank + 2))/4) return
      n_here = n_here + 1
      unknowns(:, n_here) = u
      marks(:, n_here) = [rank, origin]
   end subroutine try_guess

   !> The given data at another point.
   pure function at(setting, r, clearance) result(here)
      !> Given data.
      type(setting_type), intent(in) :: setting
      !> Frequency ratio and clearance of the point.
      real(wp), intent(in) :: r, clearance
      type(setting_type) :: here

      here = setting
      here%r = r
      here%clearance = clearance
   end function at

end module vi_grid_continuation
