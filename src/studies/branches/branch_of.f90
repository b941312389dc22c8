!> The branch of a motion, from its start to its table.
module vi_branch_of
   use vi_branch_table, only: branch_arrays, branch_request_type
   use vi_family, only: can_be_symmetric
   use vi_kinds, only: wp
   use vi_likeness, only: length_scale, mirrors_itself => is_symmetric
   use vi_motion, only: motion_type
   use vi_orbit, only: by_left, by_right, oscillator_parameters
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: branch_of, is_symmetric

   !> The points of a branch; arrays as in vi_branch_table, points on the last axis.
   type, public :: points_type
      !> Whether the motions are their own mirror images, and whether motions of the pattern can be
      !! symmetric although these are not.
      logical :: symmetric = .false., mirrored = .false.
      integer :: n = 0
      real(wp), allocatable :: parameters(:, :), phases(:, :), impacts(:, :, :), scalars(:, :)
      complex(wp), allocatable :: multipliers(:, :)
      integer, allocatable :: verdicts(:, :), codes(:), special(:, :)
      !> The reasons why it ends, at its first and at its last point, as in vi_branch.
      integer :: reasons(2) = 0
      integer :: status = stat%ok
   end type points_type

contains

   !> Follows a motion in both directions along a parameter.
   subroutine branch_of(motion, parameter, tied, bounds, longest, most, points, progress)
      !> The exact motion at the start.
      type(motion_type), intent(in) :: motion
      !> Place of the parameter in the core (`by_r` .. `by_left`).
      integer, intent(in) :: parameter
      !> Whether R2 always equals R1.
      logical, intent(in) :: tied
      !> Lowest and highest value of the parameter (clearance, not its logarithm), and the longest
      !! step, with the bounds at 0 and 1.
      real(wp), intent(in) :: bounds(2), longest
      !> Largest number of points in each direction.
      integer, intent(in) :: most
      !> The branch.
      type(points_type), intent(out) :: points
      !> Progress counters, see vi_progress; the caller has already added the work.
      integer, intent(inout), optional :: progress(3)
      type(branch_request_type) :: request
      integer :: n, capacity

      associate (osc => motion%osc, p => points)
         p%mirrored = can_be_symmetric(motion%pattern, osc%restitution)
         p%symmetric = is_symmetric(motion) .and. (tied .or. .not. any(parameter == [by_right, &
            by_left]))
         p%mirrored = p%mirrored .and. .not. p%symmetric
         request = branch_request_type(motion%pattern, p%symmetric, oscillator_parameters(osc, &
            motion%r, motion%clearance), parameter, tied, bounds, longest)
         n = size(motion%x)
         capacity = 2*most
         allocate (p%parameters(6, capacity), p%phases(n, capacity), p%impacts(n, 6, capacity), &
            p%scalars(6, capacity), p%multipliers(4, capacity), p%verdicts(3, capacity), &
            p%codes(capacity), p%special(3, capacity))
         call branch_arrays(request, [motion%x/motion%clearance, motion%phases + motion%tau], &
            p%parameters, p%phases, p%impacts, p%scalars, p%multipliers, p%verdicts, p%codes, &
            p%special, p%n, p%reasons, p%status, progress)
      end associate
   end subroutine branch_of

   !> Whether a motion is its own mirror image half a period later.
   pure logical function is_symmetric(motion)
      !> The motion.
      type(motion_type), intent(in) :: motion

      is_symmetric = can_be_symmetric(motion%pattern, motion%osc%restitution)
      if (is_symmetric) is_symmetric = mirrors_itself(motion%pattern, length_scale(motion%osc, &
         motion%r, motion%clearance), [motion%x, motion%phases + motion%tau])
   end function is_symmetric

end module vi_branch_of
