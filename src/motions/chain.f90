!> From parameters to an assessed motion: the whole chain of the 1983 theory in one call.
module vi_chain
   use vi_assess, only: assess_exact, assess_flights, assess_linear, refuse_rounding
   use vi_equispaced, only: solve_equispaced
   use vi_exact, only: setting_type, solve_exact
   use vi_kinds, only: wp
   use vi_motion, only: motion_type, rounding_margin, worst_rounding
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_periodic, only: linear_system_type, solve_periodic
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: periodic_chain, equispaced_chain, exact_chain, refine

   !> Most Newton iterations.
   integer, parameter :: most_iterations = 50

contains

   !> The motion with given impact phases, with its verdicts. Arguments as in `solve_periodic`.
   pure subroutine periodic_chain(osc, r, pattern, restitution, phases, acceptance, flights, &
      system, motion)
      !> Oscillator; its walls' coefficients are not read, `restitution` is.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio Omega/omega.
      real(wp), intent(in) :: r
      !> Sides of the N impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> Coefficient of restitution (N), and phase (N, rad, increasing from 0, below 2 pi k) of each
      !! impact.
      real(wp), intent(in) :: restitution(:), phases(:)
      !> Largest relative residual of (26), (30) that counts as consistent.
      real(wp), intent(in) :: acceptance
      !> Whether the flights are examined too: `admissible`, `x_min`, `x_max`.
      logical, intent(in) :: flights
      !> Scratch, kept between calls.
      type(linear_system_type), intent(inout) :: system
      !> Out: the motion with its verdicts, or its status; its arrays are reused between calls.
      type(motion_type), intent(inout) :: motion

      call solve_periodic(osc, r, pattern, restitution, phases, system, motion)
      if (motion%status == stat%ok) motion%status = merge(stat%ok, stat%lost_digits, &
         rounding_margin*motion%rounding <= worst_rounding)
      call assess_linear(motion, acceptance)
      if (flights) call assess_flights(motion)
   end subroutine periodic_chain

   !> Both equispaced motions, with their verdicts. Arguments as in `solve_equispaced`.
   pure subroutine equispaced_chain(osc, r, clearance, cycles, acceptance, flights, system, motions)
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
      !> Scratch, kept between calls.
      type(linear_system_type), intent(inout) :: system
      !> Out: both motions with their verdicts; status `stat%no_motion` where one does not exist.
      type(motion_type), intent(inout) :: motions(2)
      integer :: i

      call solve_equispaced(osc, r, clearance, cycles, system, motions)
      do i = 1, 2
         call assess_linear(motions(i), acceptance)
         if (flights) call assess_flights(motions(i))
      end do
   end subroutine equispaced_chain

   !> The exact motion at a given clearance near guessed phases, with its verdicts.
   !!
   !! The linear equations for these phases give the rest of the guess.
   pure subroutine exact_chain(osc, r, clearance, pattern, restitution, phases, system, motion)
      !> Oscillator; its walls' coefficients are not read, `restitution` is.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio Omega/omega, and clearance D = d K/F0.
      real(wp), intent(in) :: r, clearance
      !> Sides of the N impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> Coefficient of restitution (N), and guessed phase (N, rad, increasing from 0) of each
      !! impact.
      real(wp), intent(in) :: restitution(:), phases(:)
      !> Scratch, kept between calls.
      type(linear_system_type), intent(inout) :: system
      !> Out: the exact motion with its verdicts, or its status.
      type(motion_type), intent(inout) :: motion

      call solve_periodic(osc, r, pattern, restitution, phases, system, motion)
      if (motion%status == stat%ok) call refine(clearance, motion)
   end subroutine exact_chain

   !> The exact motion at a given clearance near another motion, with its verdicts.
   pure subroutine refine(clearance, motion)
      !> Clearance D = d K/F0 of the motion that is wanted.
      real(wp), intent(in) :: clearance
      !> In: the guess. Out: the motion.
      type(motion_type), intent(inout) :: motion
      real(wp) :: x(size(motion%x)), theta(size(motion%x)), none(2*size(motion%x), 0)
      type(setting_type) :: setting
      integer :: iterations

      x = motion%x*(clearance/motion%clearance)
      theta = motion%phases + motion%tau
      setting = setting_type(motion%osc, motion%r, 1.0_wp, clearance, motion%pattern, &
         motion%restitution)
      call solve_exact(setting, x, theta, most_iterations, none, motion, iterations)
      call assess_exact(motion)
      call refuse_rounding(motion)
      call assess_flights(motion)
   end subroutine refine

end module vi_chain
