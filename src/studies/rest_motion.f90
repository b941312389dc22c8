!> Periodic motions in which impacts accumulate and the free mass comes to rest on a wall.
!!
!! Where the rest ends both masses have one velocity v and the primary mass has no acceleration, so
!! x = f sin(phase) - 2 xi v: the state at a release is two numbers (phase, v), and the motion is a
!! fixed point of a map of the plane. Its two eigenvalues and two zeros, which the accumulation
!! brings, are the multipliers.
module vi_rest_motion
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   use vi_lapack, only: eigenvalues, solve
   use vi_simulate, only: drive_type, event_type, release_event, simulate, state_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: release_state, return_map, solve_rest_motion

   real(wp), parameter :: two_pi = 2*acos(-1.0_wp)

contains

   !> From one release on a wall to the release k load cycles later.
   pure subroutine return_map(drive, side, cycles, start, finish, events, n, status)
      type(drive_type), intent(in) :: drive
      integer, intent(in) :: side, cycles
      !> (phase, v) at the release; `finish` has the phase less 2 pi k.
      real(wp), intent(in) :: start(2)
      real(wp), intent(out) :: finish(2)
      !> Events of the period, the last one the release; room for one more period is needed.
      type(event_type), intent(inout) :: events(:)
      integer, intent(out) :: n
      !> `stat%ok`, or `stat%no_motion` if there is no release near that time.
      integer, intent(out) :: status
      type(state_type) :: state, final
      real(wp) :: lapse, nearest, horizon
      integer :: i, found

      finish = 0
      n = 0
      ! most releases come back at once: what is farther ahead than one that is found is not nearer
      horizon = 0.1_wp
      do while (n == 0)
         state = release_state(drive, side, start)
         call simulate(drive, state, int(cycles, int64), start(1) + horizon, events, found, final, &
            status)
         if (status /= stat%ok) return
         nearest = horizon
         do i = 1, found
            if (events(i)%kind /= release_event .or. events(i)%side /= side) cycle
            lapse = two_pi*real(events(i)%cycle - cycles, wp) + events(i)%phase - start(1)
            if (abs(lapse) >= nearest) cycle
            nearest = abs(lapse)
            n = i
            finish = [start(1) + lapse, events(i)%x_dot_after]
         end do
         if (horizon > 1) exit
         horizon = 0.5_wp*two_pi
      end do
      if (n == 0) status = stat%no_motion
   end subroutine return_map

   !> The state at a release. The phase may lie a little outside [0, 2 pi).
   pure function release_state(drive, side, start) result(state)
      type(drive_type), intent(in) :: drive
      integer, intent(in) :: side
      real(wp), intent(in) :: start(2)
      type(state_type) :: state

      state%phase = start(1)
      state%x_dot = start(2)
      state%z_dot = start(2)
      state%x = drive%load*sin(start(1)) - 2*drive%osc%xi*start(2)
      state%z = state%x + 0.5_wp*side*drive%clearance
      state%side = side
      state%released = .true.
   end function release_state

   !> Newton's method for a fixed point of the return map.
   !!
   !! The derivative is a difference quotient of order four with steps of 1e-4, which is right to
   !! 1e-11: the map is smooth, since accumulations are completed and not cut off.
   pure subroutine solve_rest_motion(drive, side, cycles, point, lambda, residual, events, n, &
      status)
      type(drive_type), intent(in) :: drive
      integer, intent(in) :: side, cycles
      !> In: a guess of (phase, v) at the release. Out: the fixed point.
      real(wp), intent(inout) :: point(2)
      !> Multipliers by falling modulus, the last two 0.
      complex(wp), intent(out) :: lambda(4)
      !> Greatest change of phase and v/D over a period.
      real(wp), intent(out) :: residual
      type(event_type), intent(inout) :: events(:)
      integer, intent(out) :: n
      integer, intent(out) :: status
      integer, parameter :: most = 30
      real(wp) :: image(2), jacobian(2, 2), matrix(2, 2), step(2), scale(2)
      complex(wp) :: pair(2)
      integer :: i

      lambda = 0
      residual = huge(1.0_wp)
      scale = [1.0_wp, drive%clearance]
      do i = 1, most
         call return_map(drive, side, cycles, point, image, events, n, status)
         if (status /= stat%ok) return
         residual = maxval(abs(image - point)/scale)
         call differentiate(drive, side, cycles, point, scale, jacobian, events, status)
         if (status /= stat%ok) return
         if (residual < 1.0e-12_wp) exit
         matrix = -jacobian
         matrix(1, 1) = matrix(1, 1) + 1
         matrix(2, 2) = matrix(2, 2) + 1
         step = image - point
         call solve(matrix, step, status)
         if (status /= stat%ok) return
         if (maxval(abs(step)/scale) < 1.0e-14_wp .and. residual < 1.0e-10_wp) exit
         point = point + step*min(1.0_wp, 0.3_wp/maxval(abs(step)/scale))
      end do
      status = merge(stat%ok, stat%no_convergence, residual < 1.0e-10_wp)
      if (status /= stat%ok) return
      point(1) = modulo(point(1), two_pi)
      call return_map(drive, side, cycles, point, image, events, n, status)
      if (status /= stat%ok) return
      call eigenvalues(jacobian, pair, status)
      if (abs(pair(2)) > abs(pair(1))) pair = pair([2, 1])
      lambda(:2) = pair
   end subroutine solve_rest_motion

   !> The derivative of the return map, columns by phase and v.
   pure subroutine differentiate(drive, side, cycles, point, scale, jacobian, events, status)
      type(drive_type), intent(in) :: drive
      integer, intent(in) :: side, cycles
      real(wp), intent(in) :: point(2), scale(2)
      real(wp), intent(out) :: jacobian(2, 2)
      type(event_type), intent(inout) :: events(:)
      integer, intent(out) :: status
      real(wp), parameter :: h = 1.0e-4_wp
      real(wp), parameter :: weight(4) = [1, -8, 8, -1]/12.0_wp
      real(wp), parameter :: offset(4) = [-2, -1, 1, 2]*h
      real(wp) :: moved(2), image(2)
      integer :: i, j, n

      jacobian = 0
      do j = 1, 2
         do i = 1, 4
            moved = point
            moved(j) = moved(j) + offset(i)*scale(j)
            call return_map(drive, side, cycles, moved, image, events, n, status)
            if (status /= stat%ok) return
            jacobian(:, j) = jacobian(:, j) + weight(i)*image/(h*scale(j))
         end do
      end do
   end subroutine differentiate

end module vi_rest_motion
