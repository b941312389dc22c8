!> The derivative of the period of a structure's motion, [P] of theory section 3: flights in closed
!! form, and at each impact
!!
!!     S = [ J, 0 ; (a+ - J' a-) G^T/v, J' ],   J = I - (1 + R) m M^-1 G G^T
!!
!! with J' = I - (1 + R + R' v) m M^-1 G G^T, accelerations a- and a+, approach speed v. In the
!! pairs
!! [P] has the same eigenvalues as in coordinates and velocities.
module vi_structure_map
   use vi_kinds, only: wp
   use vi_status, only: stat
   use vi_structure, only: opening_at, regime_type, structure_type
   use vi_structure_motion, only: impulse_of, transitions
   implicit none (type, external)
   private

   public :: accelerations, apply_flight, apply_impact, from_coordinates, to_coordinates

contains

   !> Multiplies a derivative of the pairs by that of a flight.
   pure subroutine apply_flight(regime, time, d)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> Duration.
      real(wp), intent(in) :: time
      !> (2m, columns) In and out: derivatives of x, then of v.
      real(wp), intent(inout) :: d(:, :)
      real(wp), dimension(size(d, 1)/2) :: xx, xv, vx, vv, before
      integer :: j, m

      m = size(before)
      call transitions(regime, time, xx, xv, vx, vv)
      do j = 1, size(d, 2)
         before = d(:m, j)
         d(:m, j) = xx*before + xv*d(m + 1:, j)
         d(m + 1:, j) = vx*before + vv*d(m + 1:, j)
      end do
   end subroutine apply_flight

   !> Accelerations q'' of a state.
   pure subroutine accelerations(regime, phase, x, v, acceleration)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> Load phase (rad).
      real(wp), intent(in) :: phase
      !> (m) The pairs.
      real(wp), intent(in) :: x(:), v(:)
      !> (n)
      real(wp), intent(out) :: acceleration(:)
      real(wp), dimension(size(x)) :: x_rate, v_rate
      integer :: h

      associate (modes => regime%modes)
         x_rate = v + modes%drift
         v_rate = modes%force - modes%stiffness*x - 2*modes%damping*v
      end associate
      acceleration = matmul(regime%dx, x_rate) + matmul(regime%dv, v_rate)
      do h = 1, size(regime%steady, 2)
         acceleration = acceleration - (h*regime%frequency)**2*real(regime%steady(:, h)* &
            cmplx(cos(h*phase), sin(h*phase), wp))
      end do
   end subroutine accelerations

   !> Multiplies a derivative of the pairs by that of an impact.
   pure subroutine apply_impact(structure, regime, gap, phase, speed, x, v, x_after, v_after, d, &
      status)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> The gap.
      integer, intent(in) :: gap
      !> Load phase (rad), and approach speed.
      real(wp), intent(in) :: phase, speed
      !> (m) The pairs just before and just after it.
      real(wp), intent(in) :: x(:), v(:), x_after(:), v_after(:)
      !> (2m, columns) In and out: derivatives of x, then of v.
      real(wp), intent(inout) :: d(:, :)
      !> `stat%ok`; `stat%zero_approach` where the speed is not positive. For a negative one the
      !! derivative continues smoothly.
      integer, intent(out) :: status
      real(wp), dimension(size(structure%mass, 1)) :: before, after, jump, turn
      real(wp), dimension(size(regime%modes%stiffness), 2) :: by_position, by_rate, kick, &
         jolt
      real(wp) :: impulse, slope, closing, approaching, opening(0:2)
      integer :: j, m

      m = size(x)
      status = merge(stat%ok, stat%zero_approach, speed > 0)
      if (.not. abs(speed) > 0) return
      call impulse_of(structure, gap, speed, impulse, slope)
      associate (direction => structure%directions(:, gap), mobility => structure%mobility(:, gap))
         call accelerations(regime, phase, x, v, before)
         call accelerations(regime, phase, x_after, v_after, after)
         ! dq jumps by -(1 + R) m M^-1 G (G.dq), and dq' by turn (G.dq) - slope M^-1 G (G.dq'); the
         ! acceleration of a wall that moves is taken from that of the approach
         jump = -impulse/speed*mobility
         opening = opening_at(structure, gap, phase, regime%frequency)
         turn = (after - before + slope*mobility*(dot_product(direction, before) - opening(2))) &
            /speed
         kick(:, 1) = matmul(regime%xd, mobility)
         kick(:, 2) = matmul(regime%vd, mobility)
         jolt(:, 1) = matmul(regime%xq, jump) + matmul(regime%xd, turn)
         jolt(:, 2) = matmul(regime%vq, jump) + matmul(regime%vd, turn)
         by_position(:, 1) = matmul(direction, regime%qx)
         by_position(:, 2) = matmul(direction, regime%qv)
         by_rate(:, 1) = matmul(direction, regime%dx)
         by_rate(:, 2) = matmul(direction, regime%dv)
         do j = 1, size(d, 2)
            closing = dot_product(by_position(:, 1), d(:m, j)) + dot_product(by_position(:, 2), &
               d(m + 1:, j))
            approaching = dot_product(by_rate(:, 1), d(:m, j)) + dot_product(by_rate(:, 2), &
               d(m + 1:, j))
            d(:m, j) = d(:m, j) + closing*jolt(:, 1) - slope*approaching*kick(:, 1)
            d(m + 1:, j) = d(m + 1:, j) + closing*jolt(:, 2) - slope*approaching*kick(:, 2)
         end do
      end associate
   end subroutine apply_impact

   !> Derivatives of coordinates and velocities from those of the pairs.
   pure subroutine to_coordinates(regime, d, p)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (2m, columns) Derivatives of x, then of v.
      real(wp), intent(in) :: d(:, :)
      !> (2n, columns) Derivatives of q, then of q'.
      real(wp), intent(out) :: p(:, :)
      integer :: m, n

      m = size(d, 1)/2
      n = size(p, 1)/2
      p(:n, :) = matmul(regime%qx, d(:m, :)) + matmul(regime%qv, d(m + 1:, :))
      p(n + 1:, :) = matmul(regime%dx, d(:m, :)) + matmul(regime%dv, d(m + 1:, :))
   end subroutine to_coordinates

   !> Derivatives of the pairs from those of coordinates and velocities.
   pure subroutine from_coordinates(regime, p, d)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (2n, columns) Derivatives of q, then of q'.
      real(wp), intent(in) :: p(:, :)
      !> (2m, columns) Derivatives of x, then of v.
      real(wp), intent(out) :: d(:, :)
      integer :: m, n

      m = size(d, 1)/2
      n = size(p, 1)/2
      d(:m, :) = matmul(regime%xq, p(:n, :)) + matmul(regime%xd, p(n + 1:, :))
      d(m + 1:, :) = matmul(regime%vq, p(:n, :)) + matmul(regime%vd, p(n + 1:, :))
   end subroutine from_coordinates

end module vi_structure_map
