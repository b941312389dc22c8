!> The type that every solver returns: a periodic motion with impacts.
module vi_motion
   use vi_flight, only: flight_type, new_flight
   use vi_impact, only: primary_velocities
   use vi_kinds, only: two_pi, wp
   use vi_oscillator, only: eta, gain, oscillator_type
   use vi_pattern, only: pattern_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: start_motion, set_phases, complete_motion, flight_of

   !> Values of the three verdicts of a motion.
   integer, parameter, public :: no = 0, yes = 1, unknown = -1

   !> Lengths in F0/K, velocities in omega F0/K, angles in radians; arrays have one entry per
   !! impact.
   type, public :: motion_type
      type(oscillator_type) :: osc
      type(pattern_type) :: pattern
      !> Frequency ratio Omega/omega, and clearance d K/F0.
      real(wp) :: r = 0, clearance = 0
      !> Coefficient of restitution R_i and phase alpha_i (alpha_1 = 0) of each impact.
      real(wp), allocatable :: restitution(:), phases(:)
      !> Quantities that follow from the phases alone: their sines and cosines, the phase from each
      !! impact to the next, and the coefficients C_1i, C_2i of (9), (10) of that flight.
      real(wp), allocatable :: sine(:), cosine(:), length(:), c1(:), c2(:)
      !> Positions of both masses, and their velocities just before and after each impact.
      real(wp), allocatable, dimension(:) :: x, z, x_dot_before, x_dot_after, z_dot_before, &
         z_dot_after
      !> Amplitude A of the motion without impacts, and phase tau of (4).
      real(wp) :: amplitude = 0, tau = 0
      !> Relative 2-norm of (26), (30): |left - right|/|right|.
      real(wp) :: residual = 0
      !> Estimated error of positions, phases and clearance that rounding causes, relative to the
      !! largest of them; 0 where it is not estimated.
      real(wp) :: rounding = 0
      !> Eigenvalues of [P], in order of decreasing modulus.
      complex(wp) :: multipliers(4) = 0
      !> Extreme positions of the primary mass over the period.
      real(wp) :: x_min = 0, x_max = 0
      !> Set by `assess` alone: `yes`, `no` or `unknown`.
      integer :: consistent = unknown, admissible = unknown, stable = unknown
      !> A code of vi_status; unless it is `stat%ok`, the fields after `phases` are meaningless.
      integer :: status = stat%ok
   end type motion_type

   !> Largest relative rounding error that a motion may have: six digits are left, three in single
   !! precision.
   real(wp), parameter, public :: worst_rounding = max(1.0e-6_wp, 1.0e4_wp*epsilon(1.0_wp))

   !> Whether the effects of rounding are estimated. Single precision shows them: there the
   !! computation is that of 1983.
   logical, parameter, public :: audited = precision(1.0_wp) >= 15

   !> Safety factor on the estimate `rounding` of a motion.
   real(wp), parameter, public :: rounding_margin = 10

contains

   !> Puts the given data into a motion and allocates the rest; the arrays are kept between calls.
   pure subroutine start_motion(motion, osc, r, pattern, restitution, phases)
      !> Out: with the given data, arrays for the rest, and all verdicts `unknown`. In: its arrays
      !! are reused where their sizes fit.
      type(motion_type), intent(inout) :: motion
      !> Oscillator without its load.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio Omega/omega.
      real(wp), intent(in) :: r
      !> Sides of the N impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> Coefficient of restitution (N), and phase (N, rad, increasing from 0) of each impact.
      real(wp), intent(in) :: restitution(:), phases(:)
      integer :: n

      n = size(phases)
      motion%osc = osc
      motion%r = r
      call copy_pattern(pattern, motion%pattern)
      motion%restitution = restitution
      call set_phases(motion, phases)
      if (allocated(motion%x)) then
         if (size(motion%x) /= n) deallocate (motion%x, motion%z, motion%x_dot_before, &
            motion%x_dot_after, motion%z_dot_before, motion%z_dot_after)
      end if
      if (.not. allocated(motion%x)) allocate (motion%x(n), motion%z(n), motion%x_dot_before(n), &
         motion%x_dot_after(n), motion%z_dot_before(n), motion%z_dot_after(n))
      motion%consistent = unknown
      motion%admissible = unknown
      motion%stable = unknown
      motion%rounding = 0
      motion%status = stat%ok
   end subroutine start_motion

   !> Copies a pattern; the array of the copy is not allocated again if it has the right size.
   pure subroutine copy_pattern(pattern, copy)
      !> The original.
      type(pattern_type), intent(in) :: pattern
      !> Out: equal to the original.
      type(pattern_type), intent(inout) :: copy

      copy%sides = pattern%sides
      copy%cycles = pattern%cycles
   end subroutine copy_pattern

   !> Sets the impact phases and what follows from them alone.
   pure subroutine set_phases(motion, phases)
      !> In: with oscillator, r and pattern. Out: phases, sine, cosine, length, c1, c2 are set.
      type(motion_type), intent(inout) :: motion
      !> (N) Phase of each impact (rad), increasing.
      real(wp), intent(in) :: phases(:)
      real(wp) :: shrink, t, frequency, angle
      integer :: i, n

      n = size(phases)
      if (allocated(motion%length)) then
         if (size(motion%length) /= n) deallocate (motion%sine, motion%cosine, motion%length, &
            motion%c1, motion%c2)
      end if
      if (.not. allocated(motion%length)) allocate (motion%sine(n), motion%cosine(n), &
         motion%length(n), motion%c1(n), motion%c2(n))
      motion%phases = phases
      motion%length(:n - 1) = phases(2:) - phases(:n - 1)
      motion%length(n) = phases(1) + two_pi*motion%pattern%cycles - phases(n)           ! (25)
      frequency = eta(motion%osc%xi)
      do i = 1, n
         angle = phases(i)
         motion%sine(i) = sin(angle)
         motion%cosine(i) = cos(angle)
         t = motion%length(i)/motion%r
         angle = frequency*t
         shrink = exp(-motion%osc%xi*t)
         motion%c1(i) = shrink*sin(angle)                                                   ! (9)
         motion%c2(i) = shrink*cos(angle)                                                   ! (10)
      end do
   end subroutine set_phases

   !> Fills positions and velocities from the unknowns of (26), (30), scaled to F0/K = 1.
   !!
   !! The unknowns may be in any unit of length; `unit_clearance` is the clearance in that unit.
   pure subroutine complete_motion(motion, x, a_cos_tau, a_sin_tau, unit_clearance)
      !> In: with the given data. Out: positions, velocities, amplitude, tau and clearance are set;
      !! on failure only the status is.
      type(motion_type), intent(inout) :: motion
      !> x_i (N), A cos(tau), A sin(tau), and the clearance, all in one unit of length.
      real(wp), intent(in) :: x(:), a_cos_tau, a_sin_tau, unit_clearance
      real(wp) :: amplitude, scale
      integer :: n, i

      n = size(x)
      amplitude = hypot(a_cos_tau, a_sin_tau)
      ! A below the rounding of the solution counts as 0
      if (.not. amplitude > n*epsilon(1.0_wp)*max(maxval(abs(x)), unit_clearance)) then
         motion%status = stat%no_load
         return
      end if
      ! x is a small remainder: the free vibration nearly cancels a forced one of this amplitude
      if (amplitude*epsilon(1.0_wp) > worst_rounding*max(maxval(abs(x)), unit_clearance)) then
         motion%status = stat%lost_digits
         return
      end if
      motion%amplitude = gain(motion%osc%xi, motion%r)
      motion%tau = atan2(a_sin_tau, a_cos_tau)
      scale = motion%amplitude/amplitude
      motion%clearance = scale*unit_clearance
      motion%x = scale*x
      motion%z = motion%x + 0.5_wp*motion%clearance*motion%pattern%sides                ! (17), (18)
      do i = 1, n
         motion%z_dot_after(i) = motion%r*(motion%z(modulo(i, n) + 1) - motion%z(i)) &
            /motion%length(i)                                                               ! (16)
         motion%z_dot_before(modulo(i, n) + 1) = motion%z_dot_after(i)                      ! (19)
      end do
      call primary_velocities(motion%osc%mu, motion%restitution, motion%z_dot_before, &
         motion%z_dot_after, motion%x_dot_before, motion%x_dot_after)
   end subroutine complete_motion

   !> The flight that begins at impact i.
   pure function flight_of(motion, i) result(flight)
      !> A complete motion.
      type(motion_type), intent(in) :: motion
      !> Number of the impact that begins the flight, 1 to N.
      integer, intent(in) :: i
      type(flight_type) :: flight

      flight = new_flight(motion%osc%xi, motion%r, motion%amplitude, motion%phases(i) &
         + motion%tau, motion%x(i), motion%x_dot_after(i), motion%z(i), motion%z_dot_after(i), &
         motion%length(i)/motion%r)
   end function flight_of

end module vi_motion
