!> The same chain in single precision, for a caller that works in double precision.
!!
!! Every number of the computation is rounded to 32 bits and every LAPACK call is the S routine;
!! only the given data and the finished motion are converted. Besides the kinds, this is the only
!! file that deals with two precisions.
module vi_precision
   use vi_chain_single, only: equispaced_chain_single => equispaced_chain, &
      periodic_chain_single => periodic_chain
   use vi_kinds, only: pi, wp
   use vi_kinds_single, only: sp => wp
   use vi_motion, only: motion_type, start_motion
   use vi_motion_single, only: motion_type_single => motion_type
   use vi_oscillator, only: oscillator_type
   use vi_oscillator_single, only: oscillator_type_single => oscillator_type
   use vi_pattern, only: pattern_type
   use vi_pattern_single, only: pattern_type_single => pattern_type
   use vi_periodic_single, only: linear_system_type_single => linear_system_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: periodic_in_single, equispaced_in_single

contains

   !> `periodic_chain` in single precision.
   pure subroutine periodic_in_single(osc, r, pattern, restitution, phases, acceptance, flights, &
      motion)
      !> Oscillator; its walls' coefficients are not read, `restitution` is.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio Omega/omega.
      real(wp), intent(in) :: r
      !> Sides of the N impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> Coefficient of restitution (N), and phase (N, rad, increasing from 0) of each impact.
      real(wp), intent(in) :: restitution(:), phases(:)
      !> Largest relative residual that counts as consistent.
      real(wp), intent(in) :: acceptance
      !> Whether the flights are examined too: `admissible`, `x_min`, `x_max`.
      logical, intent(in) :: flights
      !> Out: the motion in double precision with the digits of single precision, or its status.
      type(motion_type), intent(inout) :: motion
      type(linear_system_type_single) :: system
      type(motion_type_single) :: narrow

      call periodic_chain_single(narrowed(osc), real(r, sp), &
         pattern_type_single(pattern%sides, pattern%cycles), real(restitution, sp), &
         real(phases, sp), real(acceptance, sp), flights, system, narrow)
      call widen(narrow, osc, r, restitution, phases, motion)
   end subroutine periodic_in_single

   !> `equispaced_chain` in single precision.
   pure subroutine equispaced_in_single(osc, r, clearance, cycles, acceptance, flights, motions)
      !> Oscillator; its two coefficients of restitution are equal.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio Omega/omega, and clearance D = d K/F0.
      real(wp), intent(in) :: r, clearance
      !> Load cycles k in a period, odd.
      integer, intent(in) :: cycles
      !> Largest relative residual that counts as consistent.
      real(wp), intent(in) :: acceptance
      !> Whether the flights are examined too: `admissible`, `x_min`, `x_max`.
      logical, intent(in) :: flights
      !> Out: both motions, as in `periodic_in_single`.
      type(motion_type), intent(inout) :: motions(2)
      type(linear_system_type_single) :: system
      type(motion_type_single) :: narrow(2)
      integer :: i

      call equispaced_chain_single(narrowed(osc), real(r, sp), real(clearance, sp), cycles, &
         real(acceptance, sp), flights, system, narrow)
      do i = 1, 2
         call widen(narrow(i), osc, r, osc%restitution, [0.0_wp, cycles*pi], motions(i))
         if (narrow(i)%status == stat%ok) motions(i)%clearance = clearance
      end do
   end subroutine equispaced_in_single

   !> The oscillator with its numbers rounded to single precision.
   pure function narrowed(osc) result(narrow)
      !> Oscillator in double precision.
      type(oscillator_type), intent(in) :: osc
      type(oscillator_type_single) :: narrow

      narrow = oscillator_type_single(real(osc%xi, sp), real(osc%mu, sp), real(osc%restitution, sp))
   end function narrowed

   !> Converts a finished motion to double precision; the given data keep all their digits.
   pure subroutine widen(narrow, osc, r, restitution, phases, motion)
      !> The finished motion.
      type(motion_type_single), intent(in) :: narrow
      !> Oscillator as given.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio, coefficients of restitution and phases (N) as given.
      real(wp), intent(in) :: r, restitution(:), phases(:)
      !> Out: the motion, or its status.
      type(motion_type), intent(inout) :: motion

      call start_motion(motion, osc, r, pattern_type(narrow%pattern%sides, narrow%pattern%cycles), &
         restitution, phases)
      motion%status = narrow%status
      if (motion%status /= stat%ok) return
      motion%clearance = real(narrow%clearance, wp)
      motion%x = real(narrow%x, wp)
      motion%z = real(narrow%z, wp)
      motion%x_dot_before = real(narrow%x_dot_before, wp)
      motion%x_dot_after = real(narrow%x_dot_after, wp)
      motion%z_dot_before = real(narrow%z_dot_before, wp)
      motion%z_dot_after = real(narrow%z_dot_after, wp)
      motion%amplitude = real(narrow%amplitude, wp)
      motion%tau = real(narrow%tau, wp)
      motion%residual = real(narrow%residual, wp)
      motion%multipliers = cmplx(narrow%multipliers, kind=wp)
      motion%x_min = real(narrow%x_min, wp)
      motion%x_max = real(narrow%x_max, wp)
      motion%consistent = narrow%consistent
      motion%admissible = narrow%admissible
      motion%stable = narrow%stable
   end subroutine widen

end module vi_precision
