!> The reference chain at many points: plain arrays in, plain arrays out, one status code a point.
!!
!! Points are on the last axis (m). The rows of the results are
!!
!! - `impacts` (n, 6, m): x, z, x_dot_before, x_dot_after, z_dot_before, z_dot_after of each impact;
!! - `scalars` (6, m): clearance, A, tau, residual, x_min, x_max;
!! - `multipliers` (4, m), by falling modulus;
!! - `verdicts` (3, m): consistent, admissible, stable, each 1, 0, or -1 for unknown.
!!
!! What could not be computed is NaN.
module vi_points
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_assess, only: assess_exact, assess_flights
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
      flights, &
         impacts, scalars, multipliers, verdicts, status)
      type(oscillator_type), intent(in) :: osc
      real(wp), intent(in) :: r(:)
      type(pattern_type), intent(in) :: pattern
      real(wp), intent(in) :: restitution(:), phases(:, :)
      real(wp), intent(in) :: acceptance
      !> Whether to compute in single precision, and whether to examine the flights.
      logical, intent(in) :: single, flights
      real(wp), intent(out) :: impacts(:, :, :), scalars(:, :)
      complex(wp), intent(out) :: multipliers(:, :)
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
               flights, &
               system, motion)
         end if
         call store_motion(motion, flights, impacts(:, :, j), scalars(:, j), multipliers(:, j), &
            verdicts(:, j), status(j))
      end do
   end subroutine periodic_points

   !> Both equispaced motions at each (r, clearance); the results have 2m columns, two a point.
   pure subroutine equispaced_points(osc, r, clearance, cycles, acceptance, single, flights, &
         impacts, scalars, multipliers, verdicts, status)
      type(oscillator_type), intent(in) :: osc
      real(wp), intent(in) :: r(:), clearance(:)
      integer, intent(in) :: cycles
      real(wp), intent(in) :: acceptance
      logical, intent(in) :: single, flights
      real(wp), intent(out) :: impacts(:, :, :), scalars(:, :)
      complex(wp), intent(out) :: multipliers(:, :)
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
      verdicts, &
         status, iterations)
      type(setting_type), intent(in) :: setting
      real(wp), intent(in) :: x(:), theta(:)
      !> Most iterations.
      integer, intent(in) :: most
      real(wp), intent(out) :: phases(:), impacts(:, :), scalars(:)
      complex(wp), intent(out) :: multipliers(:)
      integer, intent(out) :: verdicts(:), status, iterations
      type(motion_type) :: motion
      real(wp) :: x_now(size(x)), theta_now(size(x)), none(2*size(x), 0)

      x_now = x
      theta_now = theta
      call solve_exact(setting, x_now, theta_now, most, none, motion, iterations)
      call assess_exact(motion)
      call assess_flights(motion)
      phases = motion%phases
      call store_motion(motion, .true., impacts, scalars, multipliers, verdicts, status)
   end subroutine exact_point

   !> The motion of unknowns that solve the equations.
   pure subroutine member_point(setting, x, theta, phases, impacts, scalars, multipliers, &
      verdicts, status)
      type(setting_type), intent(in) :: setting
      real(wp), intent(in) :: x(:), theta(:)
      real(wp), intent(out) :: phases(:), impacts(:, :), scalars(:)
      complex(wp), intent(out) :: multipliers(:)
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
      type(motion_type), intent(in) :: motion
      logical, intent(in) :: flights
      real(wp), intent(out) :: impacts(:, :), scalars(:)
      complex(wp), intent(out) :: multipliers(:)
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

   !> The motion whose rows `store_motion` wrote, as far as its flights are concerned.
   pure function recall(osc, r, pattern, restitution, phases, impacts, amplitude, &
      tau) result(motion)
      type(oscillator_type), intent(in) :: osc
      real(wp), intent(in) :: r
      type(pattern_type), intent(in) :: pattern
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
