!> Periodic motions of structures, from and to arrays.
module vi_structure_period
   use vi_kinds, only: two_pi, wp
   use vi_motion, only: unknown
   use vi_responses, only: offset_pairs
   use vi_status, only: stat
   use vi_structure, only: check_structure, load_type, new_regime, regime_type, state_of, &
      structure_type
   use vi_structure_assess, only: assess_structure, structure_verdicts_type
   use vi_structure_exact, only: solve_structure_exact
   use vi_structure_motion, only: equations_type, impulse_of, new_equations, relative, residuals, &
      solve_in_full, solve_linear, state_after
   implicit none (type, external)
   private

   public :: describe_structure_motion, periodic_structure, periodic_structure_arrays

   !> What is wanted: the linear problem with the modes eliminated, in full, or the exact motion.
   integer, parameter, public :: eliminated = 0, full = 1, exact = 2

   !> A periodic motion of a structure without rest.
   type, public :: structure_motion_type
      !> (N) Load phases of the impacts (rad), approach speeds, impulses.
      real(wp), allocatable :: phases(:), speeds(:), impulses(:)
      !> (2n, N) Coordinates and velocities just after each impact.
      real(wp), allocatable :: states(:, :)
      !> The largest residual, over the sum of the absolute terms of its equation.
      real(wp) :: residual = 0
      type(structure_verdicts_type) :: verdicts
   end type structure_motion_type

contains

   !> A periodic motion from presumed load phases of its impacts.
   pure subroutine periodic_structure(structure, load, gaps, phases, cycles, wanted, motion, status)
      !> In: M, C, K, gaps. Out: completed.
      type(structure_type), intent(inout) :: structure
      !> The load; its frequency is > 0.
      type(load_type), intent(in) :: load
      !> (N) The gaps of the impacts.
      integer, intent(in) :: gaps(:)
      !> (N) Their load phases (rad), in ascending order, within less than a period.
      real(wp), intent(in) :: phases(:)
      !> Load cycles in a period; what is wanted.
      integer, intent(in) :: cycles, wanted
      !> The motion.
      type(structure_motion_type), intent(out) :: motion
      !> `stat%ok`, or as in `new_regime`, `new_equations`, `solve_structure_exact`.
      integer, intent(out) :: status
      integer, parameter :: most_steps = 60
      type(regime_type) :: regime
      type(equations_type) :: equations
      real(wp), allocatable :: times(:), offsets(:), x(:), v(:)
      real(wp), allocatable :: value(:), scale(:)
      real(wp) :: period
      integer :: n, steps

      call check_structure(structure, status)
      if (status /= stat%ok) return
      call new_regime(structure, load, [integer :: ], regime, status)
      if (status /= stat%ok) return
      ! the terms of the load count from its phase, so Omega is that of the load without harmonics
      ! too
      regime%frequency = load%frequency
      n = size(gaps)
      period = cycles*two_pi/load%frequency
      times = phases/load%frequency
      allocate (motion%speeds(n), offsets(size(offset_pairs(regime))), &
         x(size(structure%mass, 1)), v(size(structure%mass, 1)))
      call new_equations(structure, regime, gaps, times, period, equations, status)
      if (status /= stat%ok) return
      if (wanted == full) then
         call solve_in_full(structure, regime, equations, motion%speeds, x, v, status)
         if (status /= stat%ok) return
         call offsets_of(structure, regime, equations, motion%speeds, x, offsets)
         allocate (value(2*n + size(offsets)), scale(2*n + size(offsets)))
         call residuals(structure, equations, motion%speeds, offsets, value, scale)
         motion%residual = relative(value, scale)
      else
         call solve_linear(structure, equations, motion%speeds, offsets, motion%residual, status)
         if (status /= stat%ok) return
         if (wanted == exact) then
            call solve_structure_exact(structure, regime, gaps, times, period, motion%speeds, &
               offsets, most_steps, motion%residual, steps, status)
            if (status /= stat%ok) return
            ! its status depends on the regime, the gaps and the period, not on the times
            call new_equations(structure, regime, gaps, times, period, equations, status)
         end if
      end if
      call describe_structure_motion(structure, regime, equations, offsets, motion)
   end subroutine periodic_structure

   !> Completes a motion: phases, impulses, states, multipliers and verdicts.
   pure subroutine describe_structure_motion(structure, regime, equations, offsets, motion)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Its regime without resting gaps.
      type(regime_type), intent(in) :: regime
      !> The equations of the motion.
      type(equations_type), intent(in) :: equations
      !> (p) Offsets.
      real(wp), intent(in) :: offsets(:)
      !> In: approach speeds and residual. Out: complete.
      type(structure_motion_type), intent(inout) :: motion
      real(wp), dimension(size(regime%modes%stiffness)) :: x, v
      real(wp) :: slope
      integer :: i

      motion%phases = regime%frequency*equations%times
      ! whole cycles later the load is the same, and simulations begin at times from 0 on
      if (motion%phases(1) < 0) motion%phases = motion%phases &
         + two_pi*ceiling(-motion%phases(1)/two_pi)
      allocate (motion%impulses(size(motion%speeds)), motion%states(2*size(x), size(motion%speeds)))
      do i = 1, size(motion%speeds)
         call impulse_of(structure, equations%gaps(i), motion%speeds(i), motion%impulses(i), slope)
         call state_after(structure, regime, equations, motion%speeds, offsets, i, x, v)
         associate (state => motion%states(:, i))
            call state_of(regime, motion%phases(i), x, v, state(:size(x)), state(size(x) + 1:))
         end associate
      end do
      call assess_structure(structure, regime, equations, motion%speeds, offsets, motion%residual, &
         motion%verdicts)
   end subroutine describe_structure_motion

   !> A periodic motion as arrays.
   pure subroutine periodic_structure_arrays(given, load, gaps, phases, cycles, wanted, impacts, &
      states, p, multipliers, scalars, verdicts, status)
      !> The structure and its load.
      type(structure_type), intent(in) :: given
      !> As in `given`.
      type(load_type), intent(in) :: load
      !> As in `periodic_structure`.
      integer, intent(in) :: gaps(:), cycles, wanted
      !> (N) Load phases (rad).
      real(wp), intent(in) :: phases(:)
      !> (N, 3) Load phases, approach speeds, impulses.
      real(wp), intent(out) :: impacts(:, :)
      !> (2n, N) Coordinates and velocities just after each impact.
      real(wp), intent(out) :: states(:, :)
      !> (2n, 2n) The derivative of the period; NaN if there is none.
      real(wp), intent(out) :: p(:, :)
      !> (2n) Its eigenvalues.
      complex(wp), intent(out) :: multipliers(:)
      !> The residual, det[P], and the value that it must have.
      real(wp), intent(out) :: scalars(3)
      !> Consistent, admissible, stable.
      integer, intent(out) :: verdicts(3)
      !> As in `periodic_structure`.
      integer, intent(out) :: status
      type(structure_type) :: structure
      type(structure_motion_type) :: motion

      impacts = 0
      states = 0
      p = 0
      multipliers = 0
      scalars = 0
      verdicts = unknown
      structure = given
      call periodic_structure(structure, load, gaps, phases, cycles, wanted, motion, status)
      if (status /= stat%ok) return
      impacts(:, 1) = motion%phases
      impacts(:, 2) = motion%speeds
      impacts(:, 3) = motion%impulses
      states = motion%states
      p = motion%verdicts%p
      multipliers = motion%verdicts%multipliers
      scalars = [motion%residual, motion%verdicts%determinant, motion%verdicts%law]
      verdicts = [motion%verdicts%consistent, motion%verdicts%admissible, motion%verdicts%stable]
   end subroutine periodic_structure_arrays

   !> The offsets that belong to a state just after the first impact.
   pure subroutine offsets_of(structure, regime, equations, speeds, first, offsets)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Its regime without resting gaps.
      type(regime_type), intent(in) :: regime
      !> The equations.
      type(equations_type), intent(in) :: equations
      !> (N) Approach speeds.
      real(wp), intent(in) :: speeds(:)
      !> (m) x of all pairs just after the first impact.
      real(wp), intent(in) :: first(:)
      !> (p) The offsets.
      real(wp), intent(out) :: offsets(:)
      real(wp) :: x(size(first)), v(size(first))

      offsets = 0
      call state_after(structure, regime, equations, speeds, offsets, 1, x, v)
      offsets = pack(first - x, .not. regime%modes%stiffness > 0)
   end subroutine offsets_of

end module vi_structure_period
