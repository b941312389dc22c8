!> First variations: how small changes of a state and of the parameters grow from event to event.
!!
!! The state of an event is (x, x', z', alpha) just after it, the free mass being on a wall and
!! alpha the load phase. Everything between events is known in closed form, and so is its derivative;
!! the instant of an event follows from the condition that ends the flight or the rest.
!!
!! An accumulation of impacts is cut off after an impact with departure speed u: there both masses
!! take the velocity of their common centre of mass, and move on as one. The gap that is neglected
!! lasts for 2 u/(a (1 - R)), a being the acceleration that closes it, and the state after it is
!! wrong by about its integral, of the order u**3/a**2. The derivative is that of the motion so
!! defined; as a map of changes at one instant it is the projection on the common motion, with the
!! dashpot's part in the velocity.
module vi_variation
   use vi_drive, only: drive_type
   use vi_kinds, only: wp
   use vi_oscillation, only: derivatives, new_oscillation, oscillation_type
   use vi_oscillator, only: eta
   use vi_rest, only: new_rest
   implicit none (type, external)
   private

   public :: gap_change, new_variation, release, through_contact, through_rest, through_stick

   !> Quantities that are varied.
   integer, parameter, public :: columns = 4

   !> The changes of a state and of two parameters, by each of the quantities that are varied.
   type, public :: variation_type
      !> Changes of x, x', z' and alpha.
      real(wp) :: state(4, columns) = 0
      !> Changes of r and of the clearance.
      real(wp) :: r(columns) = 0, clearance(columns) = 0
   end type variation_type

   !> The state of an event.
   type, public :: moment_type
      !> Position and velocity of the primary mass, velocity of the free mass.
      real(wp) :: x = 0, x_dot = 0, z_dot = 0
      !> Load phase, whole cycles included.
      real(wp) :: phase = 0
      !> The wall that the free mass is on: +1 or -1.
      integer :: side = 0
   end type moment_type

contains

   !> The changes of a state by its own four components.
   pure function new_variation() result(change)
      type(variation_type) :: change
      integer :: i

      do i = 1, 4
         change%state(i, i) = 1
      end do
   end function new_variation

   !> A flight that ends with an impact on a wall.
   pure subroutine through_contact(drive, from, time, side, restitution, change, before, regular)
      type(drive_type), intent(in) :: drive
      !> The state with which the flight begins.
      type(moment_type), intent(in) :: from
      !> Duration of the flight in 1/omega.
      real(wp), intent(in) :: time
      !> The wall of the impact, +1 or -1, and its coefficient of restitution.
      integer, intent(in) :: side
      real(wp), intent(in) :: restitution
      !> In: just after the event that begins the flight. Out: just after the impact.
      type(variation_type), intent(inout) :: change
      !> Changes of the relative velocity z' - x' just before the impact.
      real(wp), intent(out) :: before(columns)
      !> False if the impact has no approach speed.
      logical, intent(out) :: regular
      type(oscillation_type) :: o
      real(wp) :: d(0:5), rate
      real(wp), dimension(columns) :: x, x_dot, instant

      associate (mu => drive%osc%mu, state => change%state)
         o = flight_oscillation(drive, from)
         d = derivatives(o, time)
         rate = from%z_dot - d(1)
         before = 0
         regular = abs(rate) > 8*epsilon(rate)*(abs(from%z_dot) + abs(d(1)))
         if (.not. regular) return
         call flow(o, 1.0_wp, drive%osc%xi, time, change, x, x_dot)
         ! z - x is where the wall is
         instant = (0.5_wp*(side - from%side)*change%clearance - (state(1, :) - x) &
            - time*state(3, :))/rate
         x_dot = x_dot + d(2)*instant
         before = state(3, :) - x_dot
         state(1, :) = x + d(1)*instant
         state(2, :) = ((1 - mu*restitution)*x_dot + mu*(1 + restitution)*state(3, :))/(1 + mu) ! (11)
         state(3, :) = ((1 + restitution)*x_dot + (mu - restitution)*state(3, :))/(1 + mu)      ! (12)
         state(4, :) = state(4, :) + time*change%r + drive%r*instant
      end associate
   end subroutine through_contact

   !> Both masses take the velocity of their centre of mass.
   pure subroutine through_stick(drive, change)
      type(drive_type), intent(in) :: drive
      type(variation_type), intent(inout) :: change

      associate (mu => drive%osc%mu, state => change%state)
         state(2, :) = (state(2, :) + mu*state(3, :))/(1 + mu)
         state(3, :) = state(2, :)
      end associate
   end subroutine through_stick

   !> Both masses as one, for a given time.
   pure subroutine through_rest(drive, from, time, change)
      type(drive_type), intent(in) :: drive
      !> The state with which the common motion begins.
      type(moment_type), intent(in) :: from
      real(wp), intent(in) :: time
      type(variation_type), intent(inout) :: change
      type(oscillation_type) :: o
      real(wp), dimension(columns) :: x, x_dot

      associate (state => change%state)
         o = new_rest(drive%osc%xi, drive%osc%mu, drive%r, drive%load, from%phase, from%x, &
            from%x_dot)
         call flow(o, 1 + drive%osc%mu, drive%osc%xi, time, change, x, x_dot)
         state(1, :) = x
         state(2, :) = x_dot
         state(3, :) = x_dot
         state(4, :) = state(4, :) + time*change%r
      end associate
   end subroutine through_rest

   !> The end of a rest, where the acceleration of both masses rises through 0 on the wall's side.
   pure subroutine release(drive, at, change, instant, regular)
      type(drive_type), intent(in) :: drive
      !> The state at the release.
      type(moment_type), intent(in) :: at
      !> In: at the time of the release. Out: at the release.
      type(variation_type), intent(inout) :: change
      !> Changes of the instant of the release.
      real(wp), intent(out) :: instant(columns)
      !> False if the contact force does not fall through 0 there.
      logical, intent(out) :: regular
      real(wp) :: rate

      associate (state => change%state)
         ! (1 + mu) x'' = f sin(alpha) - 2 xi x' - x, and its derivative by time
         rate = drive%load*drive%r*cos(at%phase) - at%x_dot
         instant = 0
         regular = abs(rate) > 8*epsilon(rate)*(drive%load*drive%r + abs(at%x_dot))
         if (.not. regular) return
         instant = -(drive%load*cos(at%phase)*state(4, :) - 2*drive%osc%xi*state(2, :) &
            - state(1, :))/rate
         state(1, :) = state(1, :) + at%x_dot*instant
         state(4, :) = state(4, :) + drive%r*instant
      end associate
   end subroutine release

   !> Changes of the relative position z - x a given time after the beginning of a flight.
   pure function gap_change(drive, from, time, change) result(y)
      type(drive_type), intent(in) :: drive
      type(moment_type), intent(in) :: from
      real(wp), intent(in) :: time
      type(variation_type), intent(in) :: change
      real(wp) :: y(columns)
      real(wp), dimension(columns) :: x, x_dot

      call flow(flight_oscillation(drive, from), 1.0_wp, drive%osc%xi, time, change, x, x_dot)
      y = change%state(1, :) + 0.5_wp*from%side*change%clearance + time*change%state(3, :) - x
   end function gap_change

   !> The primary mass in the flight that begins at an event.
   pure function flight_oscillation(drive, from) result(o)
      type(drive_type), intent(in) :: drive
      type(moment_type), intent(in) :: from
      type(oscillation_type) :: o

      o = new_oscillation(drive%osc%xi, eta(drive%osc%xi), drive%r, drive%amplitude, &
         from%phase - drive%lag, from%x, from%x_dot)
   end function flight_oscillation

   !> Changes of x and x' of an oscillation after a given time.
   pure subroutine flow(o, mass, xi, time, change, x, x_dot)
      type(oscillation_type), intent(in) :: o
      !> What moves, over the primary mass, and the damping ratio of the primary mass alone.
      real(wp), intent(in) :: mass, xi
      real(wp), intent(in) :: time
      !> At the start.
      type(variation_type), intent(in) :: change
      real(wp), dimension(columns), intent(out) :: x, x_dot
      real(wp) :: s(4), first(0:2), last(0:2), growth, lag, elastic, viscous, by(2), by_r(2)

      s(2) = exp(-o%decay*time)*sin(o%frequency*time)/o%frequency
      s(1) = exp(-o%decay*time)*cos(o%frequency*time)
      s(4) = s(1) - o%decay*s(2)
      s(1) = s(1) + o%decay*s(2)
      s(3) = -(o%decay**2 + o%frequency**2)*s(2)
      first = forced(0.0_wp)
      last = forced(time)
      ! by the phase of the load
      by = [last(1) - s(1)*first(1) - s(2)*first(2), last(2) - s(3)*first(1) - s(4)*first(2)]/o%r
      x = s(1)*change%state(1, :) + s(2)*change%state(2, :) + by(1)*change%state(4, :)
      x_dot = s(3)*change%state(1, :) + s(4)*change%state(2, :) + by(2)*change%state(4, :)
      if (.not. any(abs(change%r) > 0)) return
      ! by r: logarithmic derivative of the amplitude, derivative of the lag
      elastic = 1 - mass*o%r**2
      viscous = 2*xi*o%r
      growth = 2*o%r*(mass*elastic - 2*xi**2)/(elastic**2 + viscous**2)
      lag = 2*(xi*elastic + mass*o%r*viscous)/(elastic**2 + viscous**2)
      by = [growth*first(0) - lag*first(1)/o%r, (growth + 1/o%r)*first(1) - lag*first(2)/o%r]
      by_r = [growth*last(0) + (time - lag)*last(1)/o%r, &
         (growth + 1/o%r)*last(1) + (time - lag)*last(2)/o%r]
      x = x + (by_r(1) - s(1)*by(1) - s(2)*by(2))*change%r
      x_dot = x_dot + (by_r(2) - s(3)*by(1) - s(4)*by(2))*change%r

   contains

      !> The forced part, its velocity and its acceleration.
      pure function forced(t) result(f)
         real(wp), intent(in) :: t
         real(wp) :: f(0:2)

         f(0) = o%amplitude*sin(o%r*t + o%phase)
         f(1) = o%amplitude*o%r*cos(o%r*t + o%phase)
         f(2) = -o%r**2*f(0)
      end function forced

   end subroutine flow

end module vi_variation
