!> The verdicts on stability, and little else, for very many points with given phases.
!!
!! Points are computed side by side (vi_lane_verdicts). If those procedures are unsure about a
!! point, it is computed by the reference chain, that is, with LAPACK.
module vi_flags
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_chain, only: periodic_chain
   use vi_kinds, only: wp
   use vi_lane_verdicts, only: lane_verdicts
   use vi_lane_verdicts_wide, only: lane_verdicts_wide => lane_verdicts
   use vi_motion, only: motion_type
   use vi_new_plan, only: new_plan
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_periodic, only: linear_system_type
   use vi_plan, only: lanes, most_impacts, plan_type, unsure
   use vi_processor, only: runs_wide
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: stability_flags

   !> Room for one block of points, and for one point of the reference chain.
   type :: workspace_type
      real(wp), allocatable :: phases(:, :), system(:, :, :), x(:, :), flight(:, :, :)
      type(linear_system_type) :: linear
      type(motion_type) :: motion
   end type workspace_type

contains

   !> The verdicts of `periodic_chain` on the motions with given phases (m, N) at ratios r (m).
   subroutine stability_flags(osc, r, pattern, restitution, phases, acceptance, with_radius, &
      threads, wide, consistent, stable, radius, status, referred)
      !> Oscillator; `restitution` is read instead of its coefficients of restitution.
      type(oscillator_type), intent(in) :: osc
      !> (m) Frequency ratios; (N) coefficient of restitution of each impact; (m, N) phases (rad),
      !! one row for each point, the first phase 0.
      real(wp), intent(in) :: r(:), restitution(:), phases(:, :)
      !> Sides of the N impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> Largest relative residual that counts as consistent.
      real(wp), intent(in) :: acceptance
      !> Whether the spectral radius of [P] is also wanted.
      logical, intent(in) :: with_radius
      !> Number of OpenMP threads, at least 1.
      integer, intent(in) :: threads
      !> Whether wide registers may be used if the processor has them; the results are identical.
      logical, intent(in) :: wide
      !> (m) 1, 0, or -1 for unknown; and a code of vi_status.
      integer, intent(out) :: consistent(:), stable(:), status(:)
      !> (m) Spectral radius; NaN where it is not wanted or the motion failed.
      real(wp), intent(out) :: radius(:)
      !> Number of points computed by the reference chain.
      integer, intent(out) :: referred
      type(plan_type) :: plan
      type(workspace_type) :: workspace
      integer :: k, first, last, n
      logical :: wide_here

      n = size(restitution)
      referred = 0
      wide_here = .false.
      if (wide) wide_here = runs_wide() /= 0
      if (n <= most_impacts) plan = new_plan(osc, pattern, restitution, acceptance)
      !$omp parallel do schedule(dynamic, 16) num_threads(threads) private(workspace, first, last) &
      !$omp& reduction(+:referred)
      do k = 1, (size(r) + lanes - 1)/lanes
         first = (k - 1)*lanes + 1
         last = min(k*lanes, size(r))
         if (n <= most_impacts) then
            call block(plan, r(first:last), phases(first:last, :), with_radius, wide_here, &
               workspace, consistent(first:last), stable(first:last), radius(first:last))
         else
            stable(first:last) = unsure
         end if
         call refer(osc, r(first:last), pattern, restitution, phases(first:last, :), acceptance, &
            with_radius, workspace, consistent(first:last), stable(first:last), &
            radius(first:last), status(first:last), referred)
      end do
      !$omp end parallel do
   end subroutine stability_flags

   !> One block of at most `lanes` points; unused lanes repeat the last point.
   pure subroutine block(plan, r, phases, with_radius, wide, workspace, consistent, stable, radius)
      !> Data that all points share.
      type(plan_type), intent(in) :: plan
      !> (m) Frequency ratios, and (m, N) phases (rad) of the points.
      real(wp), intent(in) :: r(:), phases(:, :)
      !> Whether the spectral radius is wanted, and whether the procedures for wide registers are
      !! called.
      logical, intent(in) :: with_radius, wide
      !> Scratch, kept between calls.
      type(workspace_type), intent(inout) :: workspace
      !> (m) 1, 0 or `unsure`.
      integer, intent(out) :: consistent(:), stable(:)
      !> (m) Spectral radius; NaN if it is not wanted.
      real(wp), intent(out) :: radius(:)
      real(wp) :: ratio(lanes), spectral(lanes)
      integer :: verdict(lanes, 2), i, m

      if (.not. allocated(workspace%x)) then
         allocate (workspace%phases(lanes, plan%n), workspace%system(lanes, 2*plan%n, plan%n + 3), &
            workspace%x(lanes, plan%n + 2), workspace%flight(lanes, 7, plan%n))
      end if
      m = size(r)
      ratio(:m) = r
      ratio(m + 1:) = r(m)
      do i = 1, plan%n
         workspace%phases(:m, i) = phases(:, i)
         workspace%phases(m + 1:, i) = phases(m, i)
      end do
      if (wide) then
         call lane_verdicts_wide(plan, plan%n, 2*plan%n, ratio, workspace%phases, with_radius, &
            workspace%system, workspace%x, workspace%flight, verdict(:, 1), verdict(:, 2), spectral)
      else
         call lane_verdicts(plan, plan%n, 2*plan%n, ratio, workspace%phases, with_radius, &
            workspace%system, workspace%x, workspace%flight, verdict(:, 1), verdict(:, 2), spectral)
      end if
      consistent = verdict(:m, 1)
      stable = verdict(:m, 2)
      radius = ieee_value(1.0_wp, ieee_quiet_nan)
      if (with_radius) radius = spectral(:m)
   end subroutine block

   !> Computes the unsure points of a block by the reference chain.
   subroutine refer(osc, r, pattern, restitution, phases, acceptance, with_radius, workspace, &
      consistent, stable, radius, status, referred)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      !> (m) Frequency ratios; (N) coefficients of restitution; (m, N) phases (rad); largest
      !! relative residual that counts as consistent.
      real(wp), intent(in) :: r(:), restitution(:), phases(:, :), acceptance
      !> Sides of the N impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> Whether the spectral radius is wanted.
      logical, intent(in) :: with_radius
      !> Scratch, kept between calls.
      type(workspace_type), intent(inout) :: workspace
      !> In: verdicts (m) of the block, and the points referred so far. Out: without `unsure`, and
      !! with those of this block.
      integer, intent(inout) :: consistent(:), stable(:), referred
      !> (m) In: those of the block. Out: those of the referred points are replaced; NaN if they
      !! failed.
      real(wp), intent(inout) :: radius(:)
      !> (m) Codes of vi_status; `stat%ok` for points that are not referred.
      integer, intent(out) :: status(:)
      integer :: j

      status = stat%ok
      do j = 1, size(r)
         if (min(consistent(j), stable(j)) > unsure) cycle
         referred = referred + 1
         call periodic_chain(osc, r(j), pattern, restitution, phases(j, :), acceptance, .false., &
            workspace%linear, workspace%motion)
         consistent(j) = workspace%motion%consistent
         stable(j) = workspace%motion%stable
         status(j) = workspace%motion%status
         radius(j) = ieee_value(1.0_wp, ieee_quiet_nan)
         if (with_radius .and. status(j) == stat%ok) radius(j) = &
            abs(workspace%motion%multipliers(1))
      end do
   end subroutine refer

end module vi_flags
