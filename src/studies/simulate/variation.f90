!> First variations: how small changes of a state and of the parameters grow from event to event.
!!
!! The state of an event is (x, x', z', alpha) just after it, the free mass being on a wall and
!! alpha the load phase. Everything between events is known in closed form, and so is its
!! derivative; the instant of an event follows from the condition that ends the flight or the rest.
!! "Change" always means the derivative with respect to one of the quantities that are varied.
!!
!! An accumulation of impacts is cut off after an impact with departure speed u: there both masses
!! take the velocity of their common centre of mass, and move together from then on. The neglected
!! gap lasts for 2 u/(a (1 - R)), where a is the acceleration that closes it. The error of the state
!! after it is about the integral of that gap, of the order u**3/a**2. The derivative is that of the
!! motion so defined; as a map of changes at one instant it is the projection on the common motion,
!! with the dashpot's part in the velocity.
module vi_variation
   use vi_forced_system, only: forced_system_type
   use vi_kinds, only: wp
   use vi_oscillation, only: oscillation_type
   use vi_oscillator, only: eta
   use vi_rest, only: new_rest
   implicit none (type, external)
   private

   public :: contact_derivative, gap_change, release, through_contact, through_flight, &
      through_rest, through_span, through_stick

   !> Largest number of quantities that are varied.
   integer, parameter, public :: columns = 28
   !> Number of parameters besides r and the clearance: xi, mu, R1, R2, load amplitude; their
   !! places.
   integer, parameter :: others = 5
   integer, parameter, public :: of_xi = 1, of_mu = 2, of_right = 3, of_left = 4, of_load = 5

   !> The changes of a state with respect to its own four components.
   real(wp), parameter, public :: identity(4, 4) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      1.0_wp], [4, 4])

   !> The changes of a state and of two parameters with respect to each of the first n quantities.
   type, public :: variation_type
      integer :: n = 0
      !> Changes of x, x', z' and alpha.
      real(wp) :: state(4, columns) = 0
      !> Changes of r and of the clearance.
      real(wp) :: r(columns) = 0, clearance(columns) = 0
      !> Changes of xi, mu, R1, R2 and the load amplitude, if any of them changes.
      logical :: with_others = .false.
      real(wp) :: others(others, columns) = 0
      !> Where a flight begins between the walls (side 0): changes of z - x there.
      real(wp) :: inside(columns) = 0
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

   !> The effect of an oscillation over a given time on small changes.
   type :: flow_type
      real(wp) :: time
      !> Derivatives of x and x' at the end with respect to x and x' at the start, the load phase at
      !! the start, and r.
      real(wp) :: by_x(2), by_x_dot(2), by_phase(2), by_r(2)
      !> The same with respect to xi, mu, R1, R2 and the load amplitude.
      real(wp) :: by_others(2, others)
      !> Velocity and acceleration at the end.
      real(wp) :: x_dot, x_ddot
   end type flow_type

contains

   !> A flight that ends with an impact on a wall.
   pure subroutine through_contact(system, from, time, side, restitution, change, before, regular)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state with which the flight begins.
      type(moment_type), intent(in) :: from
      !> Duration of the flight in 1/omega.
      real(wp), intent(in) :: time
      !> The wall of the impact: +1 right, -1 left.
      integer, intent(in) :: side
      !> Coefficient of restitution of that wall.
      real(wp), intent(in) :: restitution
      !> In: just after the event that begins the flight. Out: just after the impact.
      type(variation_type), intent(inout) :: change
      !> Changes of the relative velocity z' - x' just before the impact.
      real(wp), intent(out) :: before(columns)
      !> False if the impact has no approach speed.
      logical, intent(out) :: regular

      before = 0
      if (change%with_others) then
         call vary_contact(system, from, time, side, restitution, change%n, change%state, &
            change%r, change%clearance, before, regular, change%others, change%inside)
      else
         call vary_contact(system, from, time, side, restitution, change%n, change%state, &
            change%r, change%clearance, before, regular)
      end if
   end subroutine through_contact

   !> The derivative of the state just after an impact with respect to that just after the previous
   !! event.
   pure subroutine contact_derivative(system, from, time, side, restitution, p, regular)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state with which the flight begins.
      type(moment_type), intent(in) :: from
      !> Duration of the flight in 1/omega.
      real(wp), intent(in) :: time
      !> The wall of the impact: +1 right, -1 left.
      integer, intent(in) :: side
      !> Coefficient of restitution of that wall.
      real(wp), intent(in) :: restitution
      !> (new, old) Derivative of (x, x', z', alpha); undefined where `regular` is false.
      real(wp), intent(out) :: p(4, 4)
      !> False if the impact has no approach speed.
      logical, intent(out) :: regular
      real(wp), parameter :: none(4) = 0
      real(wp) :: unused(4)

      p = identity
      call vary_contact(system, from, time, side, restitution, 4, p, none, none, unused, regular)
   end subroutine contact_derivative

   !> A flight that ends with an impact on a wall, varied with respect to the first n quantities.
   pure subroutine vary_contact(system, from, time, side, restitution, n, state, r, clearance, &
      before, regular, others, inside)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state with which the flight begins.
      type(moment_type), intent(in) :: from
      !> Duration of the flight in 1/omega.
      real(wp), intent(in) :: time
      !> The wall of the impact: +1 right, -1 left.
      integer, intent(in) :: side
      !> Coefficient of restitution of that wall.
      real(wp), intent(in) :: restitution
      !> Number of quantities that are varied.
      integer, intent(in) :: n
      !> In: changes just after the event that begins the flight. Out: just after the impact.
      real(wp), intent(inout) :: state(4, n)
      !> Changes of r and of the clearance.
      real(wp), dimension(n), intent(in) :: r, clearance
      !> Changes of z' - x' just before the impact.
      real(wp), intent(inout) :: before(n)
      !> False if the impact has no approach speed.
      logical, intent(out) :: regular
      !> Changes of xi, mu, R1, R2, load amplitude, and of z - x at the start, as in
      !! `variation_type`.
      real(wp), intent(in), optional :: others(:, :), inside(:)
      type(flow_type) :: flow
      real(wp) :: rate, k(4), x, x_dot, longer, y
      integer :: i

      flow = flight_flow(system, from, time, any(abs(r) > 0), present(others))
      rate = from%z_dot - flow%x_dot
      regular = abs(rate) > 8*epsilon(rate)*(abs(from%z_dot) + abs(flow%x_dot))
      if (.not. regular) return
      k = shares(system%osc%mu, restitution)
      do i = 1, n
         call carry(flow, state(:, i), r(i), x, x_dot)
         if (present(others)) call carry_others(flow, others(:, i), x, x_dot)
         y = gap_by(from%side, time, state(:, i), clearance(i), x)
         if (present(others)) y = y + inside(i)
         ! z - x changes like the position of the wall
         longer = (0.5_wp*side*clearance(i) - y)/rate
         call strike(system%r, flow, k, longer, x, x_dot, r(i), state(:, i), before(i))
         if (present(others)) call change_law(system%osc%mu, restitution, side, flow%x_dot, &
            from%z_dot, others(:, i), state(:, i))
      end do
   end subroutine vary_contact

   !> The effect of mu and R on the velocities after an impact, varied with respect to one quantity.
   pure subroutine change_law(mu, restitution, side, x_dot, z_dot, others, state)
      !> Mass ratio, and coefficient of restitution of the wall: +1 right, -1 left.
      real(wp), intent(in) :: mu, restitution
      !> The wall of the impact.
      integer, intent(in) :: side
      !> Velocities of both masses just before the impact.
      real(wp), intent(in) :: x_dot, z_dot
      !> Changes of xi, mu, R1, R2, load amplitude.
      real(wp), intent(in) :: others(:)
      !> In: the change just after the impact with the law unchanged. Out: with its change.
      real(wp), intent(inout) :: state(4)
      real(wp) :: wall

      wall = others(merge(of_right, of_left, side > 0))
      ! the impulse over the relative velocity is mu (1 + R)/(1 + mu) of the primary mass
      state(2) = state(2) + (z_dot - x_dot)*((1 + restitution)*others(of_mu)/(1 + mu) + mu*wall) &
         /(1 + mu)
      state(3) = state(3) + (z_dot - x_dot)*((1 + restitution)*others(of_mu)/(1 + mu) - wall) &
         /(1 + mu)
   end subroutine change_law

   !> A flight of given duration that ends with an impact.
   pure subroutine through_flight(system, from, time, longer, restitution, change, y, before)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state with which the flight begins.
      type(moment_type), intent(in) :: from
      !> Duration of the flight in 1/omega, and its changes.
      real(wp), intent(in) :: time, longer(columns)
      !> Coefficient of restitution of the wall of the impact.
      real(wp), intent(in) :: restitution
      !> In: just after the event that begins the flight. Out: just after the impact.
      type(variation_type), intent(inout) :: change
      !> Changes of z - x at the end, and of z' - x' just before the impact.
      real(wp), dimension(columns), intent(out) :: y, before
      type(flow_type) :: flow
      real(wp) :: k(4), x, x_dot
      integer :: i

      flow = flight_flow(system, from, time, any(abs(change%r(:change%n)) > 0), .false.)
      k = shares(system%osc%mu, restitution)
      y = 0
      before = 0
      associate (state => change%state, r => change%r, clearance => change%clearance)
         do i = 1, change%n
            call carry(flow, state(:, i), r(i), x, x_dot)
            y(i) = gap_by(from%side, time, state(:, i), clearance(i), x) &
               + (from%z_dot - flow%x_dot)*longer(i)
            call strike(system%r, flow, k, longer(i), x, x_dot, r(i), state(:, i), before(i))
         end do
      end associate
   end subroutine through_flight

   !> The coefficients of the impact law (11), (12): velocities after an impact from those before
   !! it.
   pure function shares(mu, restitution) result(k)
      !> Mass ratio m/M, and coefficient of restitution of the wall.
      real(wp), intent(in) :: mu, restitution
      !> Coefficients of x' and z' in the new x', then in the new z'.
      real(wp) :: k(4)

      k = [1 - mu*restitution, mu*(1 + restitution), 1 + restitution, mu - restitution]/(1 + mu)
   end function shares

   !> The impact at the end of a flight, varied with respect to one quantity.
   pure subroutine strike(r, flow, k, longer, x, x_dot, by_r, state, before)
      !> Frequency ratio.
      real(wp), intent(in) :: r
      !> The effect of the flight on small changes.
      type(flow_type), intent(in) :: flow
      !> The `shares`.
      real(wp), intent(in) :: k(4)
      !> Change of the duration of the flight, and of x and x' at the end of its former duration.
      real(wp), intent(in) :: longer, x, x_dot
      !> Change of r.
      real(wp), intent(in) :: by_r
      !> In: just after the event that begins the flight. Out: just after the impact.
      real(wp), intent(inout) :: state(4)
      !> Change of z' - x' just before the impact.
      real(wp), intent(out) :: before
      real(wp) :: arrival, z_dot

      z_dot = state(3)
      arrival = x_dot + flow%x_ddot*longer
      before = z_dot - arrival
      state(1) = x + flow%x_dot*longer
      state(2) = k(1)*arrival + k(2)*z_dot
      state(3) = k(3)*arrival + k(4)*z_dot
      state(4) = state(4) + flow%time*by_r + r*longer
   end subroutine strike

   !> Both masses take the velocity of their centre of mass.
   pure subroutine through_stick(system, from, change)
      !> The forced system; mu is read.
      type(forced_system_type), intent(in) :: system
      !> The state just before.
      type(moment_type), intent(in) :: from
      !> In: just before. Out: with the common velocity as x'; `through_rest` sets z', too.
      type(variation_type), intent(inout) :: change

      associate (mu => system%osc%mu, state => change%state, n => change%n)
         state(2, :n) = (state(2, :n) + mu*state(3, :n))/(1 + mu) + (from%z_dot - from%x_dot) &
            *change%others(of_mu, :n)/(1 + mu)**2
      end associate
   end subroutine through_stick

   !> The common motion of both masses for a given time.
   pure subroutine through_rest(system, from, time, change)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state with which the common motion begins.
      type(moment_type), intent(in) :: from
      !> Duration (1/omega).
      real(wp), intent(in) :: time
      !> In: at the start. Out: after that time.
      type(variation_type), intent(inout) :: change
      type(flow_type) :: flow
      real(wp) :: x, x_dot
      integer :: i

      flow = rest_flow(system, from, time, change)
      associate (state => change%state, r => change%r)
         do i = 1, change%n
            call carry(flow, state(:, i), r(i), x, x_dot)
            if (change%with_others) call carry_others(flow, change%others(:, i), x, x_dot)
            state(:, i) = [x, x_dot, x_dot, state(4, i) + time*r(i)]
         end do
      end associate
   end subroutine through_rest

   !> A flight, or the common motion of both masses, until a load phase.
   pure subroutine through_span(system, from, time, resting, until, change, y)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state with which the motion begins.
      type(moment_type), intent(in) :: from
      !> Its duration (1/omega).
      real(wp), intent(in) :: time
      !> Whether the free mass rests on the wall.
      logical, intent(in) :: resting
      !> Changes of the load phase at its end.
      real(wp), intent(in) :: until(columns)
      !> In: at the start. Out: at the end.
      type(variation_type), intent(inout) :: change
      !> Changes of z - x at the end.
      real(wp), intent(out) :: y(columns)
      type(flow_type) :: flow
      real(wp) :: x, x_dot, longer
      integer :: i

      if (resting) then
         flow = rest_flow(system, from, time, change)
      else
         flow = flight_flow(system, from, time, .true., change%with_others)
      end if
      y = 0
      associate (state => change%state, r => change%r)
         do i = 1, change%n
            call carry(flow, state(:, i), r(i), x, x_dot)
            call carry_others(flow, change%others(:, i), x, x_dot)
            longer = (until(i) - state(4, i) - time*r(i))/system%r
            if (resting) then
               y(i) = 0.5_wp*from%side*change%clearance(i)
            else
               y(i) = gap_by(from%side, time, state(:, i), change%clearance(i), x) &
                  + change%inside(i) + (from%z_dot - flow%x_dot)*longer
            end if
            state(1, i) = x + flow%x_dot*longer
            state(2, i) = x_dot + flow%x_ddot*longer
            if (resting) state(3, i) = state(2, i)
            state(4, i) = until(i)
         end do
      end associate
   end subroutine through_span

   !> The end of a rest, where the acceleration of both masses rises through 0 on the wall's side.
   pure subroutine release(system, at, change, instant, regular)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
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
         ! (1 + mu) x'' = f sin(alpha) - 2 xi x' - x, and its time derivative
         rate = system%load*system%r*cos(at%phase) - at%x_dot
         instant = 0
         regular = abs(rate) > 8*epsilon(rate)*(system%load*system%r + abs(at%x_dot))
         if (.not. regular) return
         instant(:n) = -(system%load*cos(at%phase)*state(4, :n) - 2*system%osc%xi*state(2, :n) &
            - state(1, :n) + sin(at%phase)*change%others(of_load, :n) &
            - 2*at%x_dot*change%others(of_xi, :n))/rate
         state(1, :n) = state(1, :n) + at%x_dot*instant(:n)
         state(4, :n) = state(4, :n) + system%r*instant(:n)
      end associate
   end subroutine release

   !> Changes of the relative position z - x a given time after the beginning of a flight.
   pure function gap_change(system, from, time, change) result(y)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state with which the flight begins.
      type(moment_type), intent(in) :: from
      !> Time after the start of the flight (1/omega).
      real(wp), intent(in) :: time
      !> Changes at the start of the flight.
      type(variation_type), intent(in) :: change
      real(wp) :: y(columns)
      type(flow_type) :: flow
      real(wp) :: x, x_dot
      integer :: i

      flow = flight_flow(system, from, time, any(abs(change%r(:change%n)) > 0), .false.)
      y = 0
      do i = 1, change%n
         call carry(flow, change%state(:, i), change%r(i), x, x_dot)
         y(i) = gap_by(from%side, time, change%state(:, i), change%clearance(i), x)
      end do
   end function gap_change

   !> Change of z - x a given time after the beginning of a flight, with respect to one quantity.
   pure real(wp) function gap_by(side, time, state, clearance, x) result(y)
      !> The wall on which the flight begins.
      integer, intent(in) :: side
      !> Time after the beginning of the flight (1/omega).
      real(wp), intent(in) :: time
      !> Changes of the state at the beginning, of the clearance, and of x after that time.
      real(wp), intent(in) :: state(4), clearance, x

      y = state(1) + 0.5_wp*side*clearance + time*state(3) - x
   end function gap_by

   !> The motion of the primary mass, and its derivatives, in the flight that begins at an event.
   pure function flight_flow(system, from, time, with_r, with_others) result(flow)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state with which the flight begins.
      type(moment_type), intent(in) :: from
      !> Time after the start of the flight (1/omega).
      real(wp), intent(in) :: time
      !> Whether r changes, and whether other parameters do.
      logical, intent(in) :: with_r, with_others
      type(flow_type) :: flow

      flow = new_flow(oscillation_type(decay=system%osc%xi, frequency=eta(system%osc%xi), &
         a=0.0_wp, &
         b=0.0_wp, r=system%r, amplitude=system%amplitude, phase=from%phase - system%lag), from%x, &
         from%x_dot, 1.0_wp, system%osc%xi, time, with_r, with_others)
      ! the primary mass moves alone
      flow%by_others(:, of_mu) = 0
   end function flight_flow

   !> The motion of both masses at rest on each other, and its derivatives.
   pure function rest_flow(system, from, time, change) result(flow)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state with which the rest begins.
      type(moment_type), intent(in) :: from
      !> Time after its start (1/omega).
      real(wp), intent(in) :: time
      !> The quantities that are varied.
      type(variation_type), intent(in) :: change
      type(flow_type) :: flow

      flow = new_flow(new_rest(system%osc%xi, system%osc%mu, system%r, system%load, from%phase, &
         from%x, from%x_dot), from%x, from%x_dot, 1 + system%osc%mu, system%osc%xi, time, &
         any(abs(change%r(:change%n)) > 0), change%with_others)
   end function rest_flow

   !> An oscillation over a given time.
   pure function new_flow(o, x, x_dot, mass, xi, time, with_r, with_others) result(flow)
      !> Its constants; the free part is not used.
      type(oscillation_type), intent(in) :: o
      !> State at the start.
      real(wp), intent(in) :: x, x_dot
      !> Moving mass over the primary mass, and the damping ratio of the primary mass alone.
      real(wp), intent(in) :: mass, xi
      !> Duration (1/omega).
      real(wp), intent(in) :: time
      !> Whether r changes, and whether other parameters do; if not, the derivatives with respect to
      !! them are left at 0.
      logical, intent(in) :: with_r, with_others
      type(flow_type) :: flow
      type(oscillation_type) :: unit
      real(wp) :: shrink, s, c, first(0:2), last(0:2), free(2), growth, lag, elastic, viscous, &
         by(2), square

      shrink = exp(-o%decay*time)
      s = shrink*sin(o%frequency*time)/o%frequency
      c = shrink*cos(o%frequency*time)
      flow%time = time
      flow%by_x = [c + o%decay*s, -(o%decay**2 + o%frequency**2)*s]
      flow%by_x_dot = [s, c - o%decay*s]
      first = forced(o, 0.0_wp)
      last = forced(o, time)
      free = flow%by_x*(x - first(0)) + flow%by_x_dot*(x_dot - first(1))
      flow%x_dot = free(2) + last(1)
      flow%x_ddot = last(2) - 2*o%decay*free(2) - (o%decay**2 + o%frequency**2)*free(1)
      flow%by_phase = (last(1:2) - flow%by_x*first(1) - flow%by_x_dot*first(2))/o%r
      flow%by_r = 0
      flow%by_others = 0
      if (with_others) then
         elastic = 1 - mass*o%r**2
         viscous = 2*xi*o%r
         square = max(tiny(square), elastic**2 + viscous**2)
         ! decay rate xi/mass and stiffness 1/mass; the forced part by its amplitude and lag
         flow%by_others(:, of_xi) = changed(1/mass, 0.0_wp, -2*o%r*viscous/square, &
            2*o%r*elastic/square)
         flow%by_others(:, of_mu) = changed(-xi/mass**2, -1/mass**2, o%r**2*elastic/square, &
            o%r**2*viscous/square)
         unit = o
         unit%amplitude = 0
         if (square > tiny(square)) unit%amplitude = 1/sqrt(square)
         first = forced(unit, 0.0_wp)
         last = forced(unit, time)
         flow%by_others(:, of_load) = last(:1) - flow%by_x*first(0) - flow%by_x_dot*first(1)
         first = forced(o, 0.0_wp)
         last = forced(o, time)
      end if
      if (.not. with_r) return
      ! logarithmic derivative of the amplitude, derivative of the lag
      elastic = 1 - mass*o%r**2
      viscous = 2*xi*o%r
      growth = 2*o%r*(mass*elastic - 2*xi**2)/(elastic**2 + viscous**2)
      lag = 2*(xi*elastic + mass*o%r*viscous)/(elastic**2 + viscous**2)
      by = [growth*first(0) - lag*first(1)/o%r, (growth + 1/o%r)*first(1) - lag*first(2)/o%r]
      flow%by_r = [growth*last(0) + (time - lag)*last(1)/o%r, &
         (growth + 1/o%r)*last(1) + (time - lag)*last(2)/o%r] - flow%by_x*by(1) &
         - flow%by_x_dot*by(2)
   contains
      !> Change of x and x' at the end with the constants of the oscillation.
      pure function changed(decay, stiffness, growth, lag) result(by)
         !> Changes of the decay rate and of the squared frequency without damping, of the logarithm
         !! of the forced amplitude, and of its lag.
         real(wp), intent(in) :: decay, stiffness, growth, lag
         real(wp) :: by(2)
         real(wp) :: by_s, by_c, turn, total, f(2)

         total = o%decay**2 + o%frequency**2
         turn = (time*c - s)/o%frequency**2
         by_s = -time*s*decay - o%decay*turn*decay + 0.5_wp*turn*stiffness
         by_c = (-time*c + o%decay*time*s)*decay - 0.5_wp*time*s*stiffness
         f = [growth*first(0) - lag*first(1)/o%r, growth*first(1) - lag*first(2)/o%r]
         by = [by_c + o%decay*by_s + decay*s, -stiffness*s - total*by_s]*(x - first(0)) &
            + [by_s, by_c - o%decay*by_s - decay*s]*(x_dot - first(1)) &
            + [growth*last(0) - lag*last(1)/o%r, growth*last(1) - lag*last(2)/o%r] &
            - flow%by_x*f(1) - flow%by_x_dot*f(2)
      end function changed
   end function new_flow

   !> The forced part, its velocity and its acceleration.
   pure function forced(o, time) result(f)
      !> Constants of the oscillation; only the forced part is read.
      type(oscillation_type), intent(in) :: o
      !> Time (1/omega).
      real(wp), intent(in) :: time
      real(wp) :: f(0:2)

      f(0) = o%amplitude*sin(o%r*time + o%phase)
      f(1) = o%amplitude*o%r*cos(o%r*time + o%phase)
      f(2) = -o%r**2*f(0)
   end function forced

   !> Changes of x and x' at the end of an oscillation, with respect to one quantity.
   pure subroutine carry(flow, state, r, x, x_dot)
      !> The oscillation over its time.
      type(flow_type), intent(in) :: flow
      !> Changes of the state at the start, and of r.
      real(wp), intent(in) :: state(4), r
      !> Changes of x and x' at the end.
      real(wp), intent(out) :: x, x_dot

      x = flow%by_x(1)*state(1) + flow%by_x_dot(1)*state(2) + flow%by_phase(1)*state(4) &
         + flow%by_r(1)*r
      x_dot = flow%by_x(2)*state(1) + flow%by_x_dot(2)*state(2) + flow%by_phase(2)*state(4) &
         + flow%by_r(2)*r
   end subroutine carry

   !> Adds to these the changes with the other parameters.
   pure subroutine carry_others(flow, others, x, x_dot)
      !> The oscillation over its time.
      type(flow_type), intent(in) :: flow
      !> Changes of xi, mu, R1, R2, load amplitude.
      real(wp), intent(in) :: others(:)
      !> In and out: changes of x and x' at the end.
      real(wp), intent(inout) :: x, x_dot

      x = x + dot_product(flow%by_others(1, :), others)
      x_dot = x_dot + dot_product(flow%by_others(2, :), others)
   end subroutine carry_others

end module vi_variation
