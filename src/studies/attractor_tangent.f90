!> How small changes of the state grow from one event of a simulation to the next.
!!
!! The state of an event is (x, x', z', alpha) just after it, the free mass being on a wall and
!! alpha the load phase. From impact to impact the derivative is [P_i]. An accumulation of impacts
!! and the rest after it leave two directions: at the release the primary mass has no acceleration
!! and both masses have one velocity.
module vi_attractor_tangent
   use vi_drive, only: drive_type, event_type, impact_event, stick_event, two_pi
   use vi_impact_map, only: impact_map
   use vi_kinds, only: wp
   use vi_oscillation, only: derivatives
   use vi_oscillator, only: eta, left, right
   use vi_rest, only: new_rest
   implicit none (type, external)
   private

   public :: event_derivative, departure_speed, lapse, orthonormalise, restitution_at

contains

   !> The derivative of the state of an event with respect to that of the event before it.
   pure subroutine event_derivative(drive, before, after, p, regular)
      type(drive_type), intent(in) :: drive
      type(event_type), intent(in) :: before, after
      real(wp), intent(out) :: p(4, 4)
      !> False if there is no derivative: an impact or a release at which nothing approaches.
      logical, intent(out) :: regular

      select case (after%kind)
      case (impact_event)
         call flight_derivative(drive, before, after, p, regular)
      case (stick_event)
         call accumulation_derivative(drive, before, p, regular)
      case default
         call rest_derivative(drive, before, after, p, regular)
      end select
   end subroutine event_derivative

   !> [P_i] of the flight from one event to an impact.
   pure subroutine flight_derivative(drive, before, after, p, regular)
      type(drive_type), intent(in) :: drive
      type(event_type), intent(in) :: before, after
      real(wp), intent(out) :: p(4, 4)
      logical, intent(out) :: regular
      real(wp) :: t, shrink, theta(2)

      t = lapse(drive, before, after)
      shrink = exp(-drive%osc%xi*t)
      theta = [before%phase, after%phase] - drive%lag
      call impact_map(drive%osc%xi, drive%osc%mu, drive%r, restitution_at(drive, after), &
         t*drive%r, shrink*sin(eta(drive%osc%xi)*t), shrink*cos(eta(drive%osc%xi)*t), &
         drive%amplitude*sin(theta), drive%amplitude*cos(theta), before%x, before%x_dot_after, &
         before%z_dot_after, p, regular)
   end subroutine flight_derivative

   !> The end of an accumulation: what vi_simulate does in one step, differentiated.
   !!
   !! It takes T = 2 u/(a (1 - R)), u being the departure speed and a = -s x''.
   pure subroutine accumulation_derivative(drive, before, p, regular)
      type(drive_type), intent(in) :: drive
      !> The last impact.
      type(event_type), intent(in) :: before
      real(wp), intent(out) :: p(4, 4)
      logical, intent(out) :: regular
      real(wp), dimension(4) :: velocity, x_ddot, duration
      real(wp) :: time, lost, mass, acceleration
      integer :: i

      associate (osc => drive%osc, side => before%side)
         mass = 1 + osc%mu
         acceleration = drive%load*sin(before%phase) - 2*osc%xi*before%x_dot_after - before%x
         lost = -side*acceleration*(1 - restitution_at(drive, before))
         regular = abs(lost) > 0
         if (.not. regular) lost = 1
         time = 2*departure_speed(before)/lost
         velocity = [0.0_wp, 1.0_wp, osc%mu, 0.0_wp]/mass
         x_ddot = [-1.0_wp, -2*osc%xi, 0.0_wp, drive%load*cos(before%phase)]
         duration = [0.0_wp, 2.0_wp, -2.0_wp, 0.0_wp]*(side/lost)
         if (abs(acceleration) > 0) duration = duration - time/acceleration*x_ddot
         p = reshape([(merge(1.0_wp, 0.0_wp, modulo(i, 5) == 0), i=0, 15)], [4, 4])
         p(1, :) = p(1, :) + time*velocity + duration* &
            ((before%x_dot_after + osc%mu*before%z_dot_after)/mass)
         p(2, :) = velocity + (acceleration/mass)*duration + (time/mass)*x_ddot
         p(3, :) = p(2, :)
         p(4, :) = p(4, :) + drive%r*duration
      end associate
   end subroutine accumulation_derivative

   !> Rest on a wall, up to the release.
   pure subroutine rest_derivative(drive, before, after, p, regular)
      type(drive_type), intent(in) :: drive
      type(event_type), intent(in) :: before, after
      real(wp), intent(out) :: p(4, 4)
      logical, intent(out) :: regular
      real(wp) :: t, d(0:5), force(4), rate

      t = lapse(drive, before, after)
      p = 0
      associate (osc => drive%osc)
         d = derivatives(new_rest(osc%xi, osc%mu, drive%r, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp), t)
         p(:2, 1) = d(:1)
         d = derivatives(new_rest(osc%xi, osc%mu, drive%r, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp), t)
         p(:2, 2) = d(:1)
         ! a change of the phase adds a load a quarter of a cycle ahead
         d = derivatives(new_rest(osc%xi, osc%mu, drive%r, drive%load, &
            before%phase + 0.25_wp*two_pi, 0.0_wp, 0.0_wp), t)
         p(:2, 4) = d(:1)
         p(4, 4) = 1
         ! the release is where f sin(alpha) - 2 xi x' - x, which is (1 + mu) x'', rises through 0
         force = drive%load*cos(after%phase)*p(4, :) - 2*osc%xi*p(2, :) - p(1, :)
         rate = drive%load*drive%r*cos(after%phase) - after%x_dot_after
         regular = abs(rate) > 8*epsilon(1.0_wp)*(drive%load*drive%r + abs(after%x_dot_after))
         if (.not. regular) return
         p(1, :) = p(1, :) - (after%x_dot_after/rate)*force
         p(3, :) = p(2, :)
         p(4, :) = p(4, :) - (drive%r/rate)*force
      end associate
   end subroutine rest_derivative

   !> Time from one event to a later one.
   pure real(wp) function lapse(drive, before, after)
      type(drive_type), intent(in) :: drive
      type(event_type), intent(in) :: before, after

      lapse = (two_pi*real(after%cycle - before%cycle, wp) + (after%phase - before%phase))/drive%r
   end function lapse

   !> Speed at which the masses part after an event.
   pure real(wp) function departure_speed(event)
      type(event_type), intent(in) :: event

      departure_speed = event%side*(event%x_dot_after - event%z_dot_after)
   end function departure_speed

   !> Coefficient of restitution of the wall of an event.
   pure real(wp) function restitution_at(drive, event) result(restitution)
      type(drive_type), intent(in) :: drive
      type(event_type), intent(in) :: event

      restitution = drive%osc%restitution(merge(right, left, event%side > 0))
   end function restitution_at

   !> Gram and Schmidt, twice; `lengths` is the diagonal of the triangular factor.
   !!
   !! A column that depends on those before it, to rounding, has length 0 and becomes some other
   !! direction, so that the columns are a basis always.
   pure subroutine orthonormalise(q, lengths)
      real(wp), intent(inout) :: q(4, 4)
      real(wp), intent(out) :: lengths(4)
      real(wp) :: whole, rest
      integer :: j, least

      do j = 1, 4
         whole = norm2(q(:, j))
         call project_out(q, j)
         rest = norm2(q(:, j))
         lengths(j) = rest
         if (.not. rest > 4*epsilon(1.0_wp)*whole) then
            lengths(j) = 0
            least = minloc(sum(q(:, :j - 1)**2, dim=2), dim=1)
            q(:, j) = 0
            q(least, j) = 1
            call project_out(q, j)
            rest = norm2(q(:, j))
         end if
         q(:, j) = q(:, j)/rest
         call project_out(q, j)
         q(:, j) = q(:, j)/norm2(q(:, j))
      end do
   end subroutine orthonormalise

   !> Takes the components along the columns before it from a column.
   pure subroutine project_out(q, j)
      real(wp), intent(inout) :: q(4, 4)
      integer, intent(in) :: j
      integer :: i

      do i = 1, j - 1
         q(:, j) = q(:, j) - dot_product(q(:, i), q(:, j))*q(:, i)
      end do
   end subroutine project_out

end module vi_attractor_tangent
