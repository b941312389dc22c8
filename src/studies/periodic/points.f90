!> The reference chain at many points: plain arrays in and out, one status code for each point.
!!
!! Points are on the last axis (m). The rows of the results are
!!
!! - `impacts` (n, 6, m): x, z, x_dot_before, x_dot_after, z_dot_before, z_dot_after of each impact;
!! - `scalars` (6, m): clearance, A, tau, residual, x_min, x_max;
!! - `multipliers` (4, m), by decreasing modulus;
!! - `verdicts` (3, m): consistent, admissible, stable, each 1, 0, or -1 for unknown.
!!
!! What could not be computed is NaN.
module vi_points
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_assess, only: assess_exact, assess_flights, refuse_rounding
   use vi_chain, only: equispaced_chain, periodic_chain
   use vi_exact, only: member, setting_type, solve_exact
   use vi_kinds, only: wp
   use vi_motion, only: motion_type, start_motion
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_periodic, only: linear_system_type
   use vi_precision, only: equispaced_in_single, periodic_in_single
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: periodic_points, equispaced_points, exact_point, member_point, recall, store_motion

contains

   !> Motions with given phases (n, m) at frequency ratios r (m).
   pure subroutine periodic_points(osc, r, pattern, restitution, phases, acceptance, single, &
      flights, impacts, scalars, multipliers, verdicts, status)
      !> Oscillator; `restitution` is read instead of its coefficients of restitution.
      type(oscillator_type), intent(in) :: osc
      !> (m) Frequency ratios Omega/omega.
      real(wp), intent(in) :: r(:)
      !> Sides of the n impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> Coefficient of restitution of each impact (n), and its phase at each point (n, m; rad,
      !! increasing from 0).
      real(wp), intent(in) :: restitution(:), phases(:, :)
      !> Largest relative residual that counts as consistent.
      real(wp), intent(in) :: acceptance
      !> Whether to compute in single precision, and whether to examine the flights.
      logical, intent(in) :: single, flights
      !> (n, 6, m), (6, m) as above; NaN at a failed point, x_min and x_max also if the flights are
      !! not examined.
      real(wp), intent(out) :: impacts(:, :, :), scalars(:, :)
      !> (4, m), by decreasing modulus; NaN at a failed point.
      complex(wp), intent(out) :: multipliers(:, :)
      !> (3, m) consistent, admissible, stable: 1, 0, -1 for unknown; (m) codes of vi_status.
      integer, intent(out) :: verdicts(:, :), status(:)
      type(linear_system_type) :: system
      type(motion_type) :: motion
      integer :: j

      do j = 1, size(r)
         if (single) then
            call periodic_in_single(osc, r(j), pattern, restitution, phases(:, j), acceptance, &
               flights, motion)
         else
            call periodic_chain(osc, r(j), pattern, restitution, phases(:, j), acceptance, &
               flights, system, motion)
         end if
         call store_motion(motion, flights, impacts(:, :, j), scalars(:, j), multipliers(:, j), &
            verdicts(:, j), status(j))
      end do
   end subroutine periodic_points

   !> Both equispaced motions at each (r, clearance); the results have 2m columns, two per point.
   pure subroutine equispaced_points(osc, r, clearance, cycles, acceptance, single, flights, &
         impacts, scalars, multipliers, verdicts, status)
      !> Oscillator; its two coefficients of restitution are equal.
      type(oscillator_type), intent(in) :: osc
      !> (m) Frequency ratios Omega/omega, and (m) clearances D = d K/F0.
      real(wp), intent(in) :: r(:), clearance(:)
      !> Load cycles k in a period, odd.
      integer, intent(in) :: cycles
      !> Largest relative residual that counts as consistent.
      real(wp), intent(in) :: acceptance
      !> Whether to compute in single precision, and whether to examine the flights.
      logical, intent(in) :: single, flights
      !> (2, 6, 2m), (6, 2m) as above; NaN where a motion does not exist.
      real(wp), intent(out) :: impacts(:, :, :), scalars(:, :)
      !> (4, 2m), by decreasing modulus; NaN where a motion does not exist.
      complex(wp), intent(out) :: multipliers(:, :)
      !> (3, 2m) consistent, admissible, stable: 1, 0, -1 for unknown; (2m) codes of vi_status.
      integer, intent(out) :: verdicts(:, :), status(:)
      type(linear_system_type) :: system
      type(motion_type) :: motions(2)
      integer :: i, j, column

      do j = 1, size(r)
         if (single) then
            call equispaced_in_single(osc, r(j), clearance(j), cycles, acceptance, flights, motions)
         else
            call equispaced_chain(osc, r(j), clearance(j), cycles, acceptance, flights, system, &
               motions)
         end if
         do i = 1, 2
            column = 2*(j - 1) + i
            call store_motion(motions(i), flights, impacts(:, :, column), scalars(:, column), &
               multipliers(:, column), verdicts(:, column), status(column))
         end do
      end do
   end subroutine equispaced_points

   !> An exact motion from a guess of x_i and theta_i.
   pure subroutine exact_point(setting, x, theta, most, phases, impacts, scalars, multipliers, &
      verdicts, status, iterations)
      !> Given data: oscillator, r, load, clearance, pattern, restitution.
      type(setting_type), intent(in) :: setting
      !> (n) Guess: positions x_i (F0/K) and theta_i = alpha_i + tau (rad).
      real(wp), intent(in) :: x(:), theta(:)
      !> Largest number of Newton iterations.
      integer, intent(in) :: most
      !> (n) Phases alpha_i (rad), (n, 6) and (6) as above; the last two are NaN if the iteration
      !! failed.
      real(wp), intent(out) :: phases(:), impacts(:, :), scalars(:)
      !> (4) By decreasing modulus; NaN if the iteration failed.
      complex(wp), intent(out) :: multipliers(:)
      !> (3) consistent, admissible, stable: 1, 0, -1 for unknown; a code of vi_status; Newton
      !! iterations made.
      integer, intent(out) :: verdicts(:), status, iterations
      type(motion_type) :: motion
      real(wp) :: x_now(size(x)), theta_now(size(x)), none(2*size(x), 0)

      x_now = x
      theta_now = theta
      call solve_exact(setting, x_now, theta_now, most, none, motion, iterations)
      call assess_exact(motion)
      call refuse_rounding(motion)
      call assess_flights(motion)
      phases = motion%phases
      call store_motion(motion, .true., impacts, scalars, multipliers, verdicts, status)
   end subroutine exact_point

   !> The motion given by unknowns that solve the equations.
   pure subroutine member_point(setting, x, theta, phases, impacts, scalars, multipliers, &
      verdicts, status)
      !> Given data: oscillator, r, load, clearance, pattern, restitution.
      type(setting_type), intent(in) :: setting
      !> (n) Positions x_i (F0/K) and theta_i = alpha_i + tau (rad) that solve the equations.
      real(wp), intent(in) :: x(:), theta(:)
      !> (n) Phases alpha_i (rad), (n, 6) and (6) as above.
      real(wp), intent(out) :: phases(:), impacts(:, :), scalars(:)
      !> (4) By decreasing modulus.
      complex(wp), intent(out) :: multipliers(:)
      !> (3) consistent, admissible, stable: 1, 0, -1 for unknown; a code of vi_status.
      integer, intent(out) :: verdicts(:), status
      type(motion_type) :: motion

      call member(setting, x, theta, motion)
      call assess_exact(motion)
      call assess_flights(motion)
      phases = motion%phases
      call store_motion(motion, .true., impacts, scalars, multipliers, verdicts, status)
   end subroutine member_point

   !> Writes one motion into its place.
   pure subroutine store_motion(motion, flights, impacts, scalars, multipliers, verdicts, status)
      !> The motion, finished or failed.
      type(motion_type), intent(in) :: motion
      !> Whether its flights were examined; if not, x_min and x_max are NaN.
      logical, intent(in) :: flights
      !> (n, 6), (6) as above; NaN if the motion failed.
      real(wp), intent(out) :: impacts(:, :), scalars(:)
      !> (4) By decreasing modulus; NaN if the motion failed.
      complex(wp), intent(out) :: multipliers(:)
      !> (3) consistent, admissible, stable: 1, 0, -1 for unknown; a code of vi_status.
      integer, intent(out) :: verdicts(:), status
      real(wp) :: nan

      nan = ieee_value(1.0_wp, ieee_quiet_nan)
      status = motion%status
      verdicts = [motion%consistent, motion%admissible, motion%stable]
      if (status /= stat%ok) then
         impacts = nan
         scalars = nan
         multipliers = cmplx(nan, nan, wp)
         return
      end if
      impacts(:, 1) = motion%x
      impacts(:, 2) = motion%z
      impacts(:, 3) = motion%x_dot_before
      impacts(:, 4) = motion%x_dot_after
      impacts(:, 5) = motion%z_dot_before
      impacts(:, 6) = motion%z_dot_after
      scalars = [motion%clearance, motion%amplitude, motion%tau, motion%residual, motion%x_min, &
         motion%x_max]
      if (.not. flights) scalars(5:6) = nan
      multipliers = motion%multipliers
   end subroutine store_motion

   !> The motion whose rows `store_motion` wrote: everything its flights need, without verdicts.
   pure function recall(osc, r, pattern, restitution, phases, impacts, amplitude, &
      tau) result(motion)
      !> Oscillator without its load.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio Omega/omega.
      real(wp), intent(in) :: r
      !> Sides of the n impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> Coefficient of restitution (n) and phase (n, rad) of each impact, rows of
      !! `store_motion` (n, 6), amplitude A (F0/K) and phase tau (rad).
      real(wp), intent(in) :: restitution(:), phases(:), impacts(:, :), amplitude, tau
      type(motion_type) :: motion

      call start_motion(motion, osc, r, pattern, restitution, phases)
      motion%x = impacts(:, 1)
      motion%z = impacts(:, 2)
      motion%x_dot_before = impacts(:, 3)
      motion%x_dot_after = impacts(:, 4)
      motion%z_dot_before = impacts(:, 5)
      motion%z_dot_after = impacts(:, 6)
      motion%amplitude = amplitude
      motion%tau = tau
   end function recall

end module vi_points
