!> First variations: how small changes of a state and of the parameters grow from event to event.
!!
!! The state of an event is (x, x', z', alpha) just after it, the free mass being on a wall and
!! alpha the load phase. Everything between events is known in closed form, and so is its
!! derivative; the instant of an event follows from the condition that ends the flight or the rest.
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

   public :: gap_change, new_variation, release, through_contact, through_flight, through_rest, &
      through_stick

   !> Most quantities that are varied.
   integer, parameter, public :: columns = 28

   !> The changes of a state and of two parameters, by each of the first n quantities.
   type, public :: variation_type
      integer :: n = 0
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

      change%n = 4
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
      real(wp), dimension(columns) :: y, instant
      integer :: n

      n = change%n
      o = flight_oscillation(drive, from)
      d = derivatives(o, time)
      rate = from%z_dot - d(1)
      before = 0
      regular = abs(rate) > 8*epsilon(rate)*(abs(from%z_dot) + abs(d(1)))
      if (.not. regular) return
      ! z - x is where the wall is
      y = gap_change(drive, from, time, change)
      instant(:n) = (0.5_wp*side*change%clearance(:n) - y(:n))/rate
      call through_flight(drive, from, time, instant, restitution, change, y, before)
   end subroutine through_contact

   !> A flight of given duration that ends with an impact.
   pure subroutine through_flight(drive, from, time, longer, restitution, change, y, before)
      type(drive_type), intent(in) :: drive
      !> The state with which the flight begins.
      type(moment_type), intent(in) :: from
      !> Duration of the flight in 1/omega, and its changes.
      real(wp), intent(in) :: time, longer(columns)
      !> Of the wall of the impact.
      real(wp), intent(in) :: restitution
      !> In: just after the event that begins the flight. Out: just after the impact.
      type(variation_type), intent(inout) :: change
      !> Changes of z - x at the end, and of z' - x' just before the impact.
      real(wp), dimension(columns), intent(out) :: y, before
      type(oscillation_type) :: o
      real(wp) :: d(0:5)
      real(wp), dimension(columns) :: x, x_dot
      integer :: n

      n = change%n
      o = flight_oscillation(drive, from)
      d = derivatives(o, time)
      y = 0
      before = 0
      associate (mu => drive%osc%mu, z_dot => change%state(3, :n), t => longer(:n))
         call flow(o, 1.0_wp, drive%osc%xi, time, change, x, x_dot)
         y(:n) = change%state(1, :n) + 0.5_wp*from%side*change%clearance(:n) + time*z_dot - x(:n) &
            + (from%z_dot - d(1))*t
         x_dot(:n) = x_dot(:n) + d(2)*t
         before(:n) = z_dot - x_dot(:n)
         change%state(1, :n) = x(:n) + d(1)*t
         change%state(2, :n) = ((1 - mu*restitution)*x_dot(:n) &
            + mu*(1 + restitution)*z_dot)/(1 + mu)                                        ! (11)
         z_dot = ((1 + restitution)*x_dot(:n) + (mu - restitution)*z_dot)/(1 + mu)        ! (12)
         change%state(4, :n) = change%state(4, :n) + time*change%r(:n) + drive%r*t
      end associate
   end subroutine through_flight

   !> Both masses take the velocity of their centre of mass.
   pure subroutine through_stick(drive, change)
      type(drive_type), intent(in) :: drive
      type(variation_type), intent(inout) :: change

      associate (mu => drive%osc%mu, state => change%state, n => change%n)
         state(2, :n) = (state(2, :n) + mu*state(3, :n))/(1 + mu)
         state(3, :n) = state(2, :n)
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

      associate (state => change%state, n => change%n)
         o = new_rest(drive%osc%xi, drive%osc%mu, drive%r, drive%load, from%phase, from%x, &
            from%x_dot)
         call flow(o, 1 + drive%osc%mu, drive%osc%xi, time, change, x, x_dot)
         state(1, :n) = x(:n)
         state(2, :n) = x_dot(:n)
         state(3, :n) = x_dot(:n)
         state(4, :n) = state(4, :n) + time*change%r(:n)
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

      associate (state => change%state, n => change%n)
         ! (1 + mu) x'' = f sin(alpha) - 2 xi x' - x, and its derivative by time
         rate = drive%load*drive%r*cos(at%phase) - at%x_dot
         instant = 0
         regular = abs(rate) > 8*epsilon(rate)*(drive%load*drive%r + abs(at%x_dot))
         if (.not. regular) return
         instant(:n) = -(drive%load*cos(at%phase)*state(4, :n) - 2*drive%osc%xi*state(2, :n) &
            - state(1, :n))/rate
         state(1, :n) = state(1, :n) + at%x_dot*instant(:n)
         state(4, :n) = state(4, :n) + drive%r*instant(:n)
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
      integer :: n

      n = change%n
      call flow(flight_oscillation(drive, from), 1.0_wp, drive%osc%xi, time, change, x, x_dot)
      y = 0
      y(:n) = change%state(1, :n) + 0.5_wp*from%side*change%clearance(:n) &
         + time*change%state(3, :n) - x(:n)
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
      !> Of the first n quantities; the others are left undefined.
      real(wp), dimension(columns), intent(inout) :: x, x_dot
      real(wp) :: s(4), first(0:2), last(0:2), growth, lag, elastic, viscous, by(2), by_r(2)
      integer :: n

      s(2) = exp(-o%decay*time)*sin(o%frequency*time)/o%frequency
      s(1) = exp(-o%decay*time)*cos(o%frequency*time)
      s(4) = s(1) - o%decay*s(2)
      s(1) = s(1) + o%decay*s(2)
      s(3) = -(o%decay**2 + o%frequency**2)*s(2)
      first = forced(0.0_wp)
      last = forced(time)
      ! by the phase of the load
      by = [last(1) - s(1)*first(1) - s(2)*first(2), last(2) - s(3)*first(1) - s(4)*first(2)]/o%r
      n = change%n
      x(:n) = s(1)*change%state(1, :n) + s(2)*change%state(2, :n) + by(1)*change%state(4, :n)
      x_dot(:n) = s(3)*change%state(1, :n) + s(4)*change%state(2, :n) + by(2)*change%state(4, :n)
      if (.not. any(abs(change%r(:n)) > 0)) return
      ! by r: logarithmic derivative of the amplitude, derivative of the lag
      elastic = 1 - mass*o%r**2
      viscous = 2*xi*o%r
      growth = 2*o%r*(mass*elastic - 2*xi**2)/(elastic**2 + viscous**2)
      lag = 2*(xi*elastic + mass*o%r*viscous)/(elastic**2 + viscous**2)
      by = [growth*first(0) - lag*first(1)/o%r, (growth + 1/o%r)*first(1) - lag*first(2)/o%r]
      by_r = [growth*last(0) + (time - lag)*last(1)/o%r, &
         (growth + 1/o%r)*last(1) + (time - lag)*last(2)/o%r]
      x(:n) = x(:n) + (by_r(1) - s(1)*by(1) - s(2)*by(2))*change%r(:n)
      x_dot(:n) = x_dot(:n) + (by_r(2) - s(3)*by(1) - s(4)*by(2))*change%r(:n)

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
