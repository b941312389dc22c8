!> Flights from impact to impact, at the cost of a few multiplications.
!!
!! The flight is divided into cells of time. In a cell y = z - x and y' are cubics to within a
!! proven error, and Bernstein coefficients bound a cubic from both sides. They prove that a cell
!! has no contact, or that y is monotone in it. A monotone y has one contact or none, depending on
!! its value at the end of the cell, and Newton's method finds it. Where neither can be proved in
!! the smallest cell (grazing, many contacts in succession), the march stops and returns the time
!! from which on `first_contact` has to search.
!!
!! This file is compiled twice, the second time for wide registers, with the same bits.
module vi_march
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: two_pi, wp
   use vi_oscillator, only: left_wall => left, right_wall => right
   use vi_simulation, only: event_type, forced_system_type, impact_event, state_type
   use vi_transition, only: first_cell, idle_time, largest, moment_after, moment_type, nodes, &
      shortest_flight, transition_type
   implicit none (type, external)
   private

   public :: bounds_after, direction, fly, march, moment_of, sine_cosine

   !> Cells after which a flight is left to `first_contact`, whose steps grow where a slow load
   !! alone moves the primary mass.
   integer, parameter :: cell_budget = 100000
   !> Adding it and then subtracting it rounds to an integer, which the last bits of the sum hold.
   real(wp), parameter :: rounder = 1.5_wp*2.0_wp**52

   !> Result of a march: the first contact, or the time up to which there is none.
   type, public :: touch_type
      !> Wall, +1 right or -1 left; 0 if there is no contact before `time` and nothing is known
      !! about later times.
      integer :: side = 0
      !> Time after the start of the flight (1/omega).
      real(wp) :: time = 0
      !> Position (F0/K) and velocity (omega F0/K) of the primary mass at the contact.
      real(wp) :: x = 0, x_dot = 0
   end type touch_type

contains

   !> Flies from impact to impact until the array of events is full or the next flight is not an
   !! ordinary one: it begins in a rest or within the clearance, it may be a bounce or belong to an
   !! accumulation, no contact is found, or the end comes before it.
   pure subroutine fly(system, state, last_cycle, last_phase, events, n)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: the state. Out: just after the last impact that is found.
      type(state_type), intent(inout) :: state
      !> The end: whole load cycles, and the load phase beyond them (rad).
      integer(int64), intent(in) :: last_cycle
      real(wp), intent(in) :: last_phase
      !> Out: the impacts, after the elements 1 to n, which keep their values.
      type(event_type), intent(inout) :: events(:)
      !> Number of elements used, in and out.
      integer, intent(inout) :: n
      type(touch_type) :: touch
      real(wp) :: half, limit, share, phase, x, x_dot, z, z_dot, speed, s, c, closing, remaining, &
         turned, wall, approach
      integer(int64) :: cycle, turns
      integer :: side

      if (state%side == 0 .or. state%resting .or. state%released) return
      half = 0.5_wp*system%clearance
      share = system%osc%mu/(1 + system%osc%mu)
      limit = max(shortest_flight/(3*max(1.0_wp, system%r)), 1.0e-6_wp)
      cycle = state%cycle
      phase = state%phase
      x = state%x
      x_dot = state%x_dot
      z = state%z
      z_dot = state%z_dot
      side = state%side
      speed = state%speed
      do while (n < size(events))
         call sine_cosine(phase, s, c)
         ! the acceleration with which the gap closes, as for a bounce and for an accumulation
         closing = -side*(system%load*s - 2*system%osc%xi*x_dot - x)
         if (.not. speed > max(0.0_wp, limit*closing)) exit
         remaining = (two_pi*real(last_cycle - cycle, wp) + (last_phase - phase))/system%r
         call march(system%transition, s, c, x, x_dot, z, z_dot, half, side, speed, remaining, &
            touch)
         if (touch%side == 0 .or. touch%time > remaining) exit
         side = touch%side
         wall = side
         phase = phase + system%r*touch%time
         turns = merge(1, 0, phase >= two_pi)
         turned = merge(two_pi, 0.0_wp, phase >= two_pi)
         if (phase >= 2*two_pi) then
            turns = int(phase/two_pi, int64)
            turned = two_pi*real(turns, wp)
         end if
         cycle = cycle + turns
         phase = phase - turned
         n = n + 1
         approach = max(0.0_wp, wall*(z_dot - touch%x_dot))
         x = touch%x
         z = x + wall*half
         associate (event => events(n))
            event%kind = impact_event
            event%side = side
            event%cycle = cycle
            event%phase = phase
            event%x = x
            event%x_dot_before = touch%x_dot
            event%z_dot_before = touch%x_dot + wall*approach
            ! as in vi_simulate: the departure speed keeps all its digits
            speed = system%osc%restitution(merge(right_wall, left_wall, side > 0))*approach
            x_dot = touch%x_dot + share*(wall*(approach + speed))
            z_dot = x_dot - wall*speed
            event%x_dot_after = x_dot
            event%z_dot_after = z_dot
         end associate
      end do
      state%cycle = cycle
      state%phase = phase
      state%x = x
      state%x_dot = x_dot
      state%z = z
      state%z_dot = z_dot
      state%side = side
      state%speed = speed
   end subroutine fly

   !> Sine and cosine of a load phase, from those of the nearest of 64 angles; the error is below
   !! 1.5 units in the last place of 1.
   pure subroutine sine_cosine(phase, s, c)
      !> Load phase (rad), 0 to 2 pi.
      real(wp), intent(in) :: phase
      !> Its sine and cosine.
      real(wp), intent(out) :: s, c
      integer, parameter :: angles = 64
      integer :: k
      real(wp), parameter :: step = two_pi/angles
      ! from angles of the first quadrant, which are rounded least
      real(wp), parameter :: first_sines(16) = [(sin(k*step), k=0, 15)], &
         first_cosines(16) = [(cos(k*step), k=0, 15)], &
         sines(0:angles - 1) = [first_sines, first_cosines, -first_sines, -first_cosines], &
         cosines(0:angles - 1) = [first_cosines, -first_sines, -first_cosines, first_sines]
      !> The angle between two of them, in two parts: small multiples of the first one are exact.
      real(wp), parameter :: parts(2) = [aint(step*2.0_wp**40)/2.0_wp**40, &
         1.602090094746574242618e-13_wp]
      real(wp) :: shifted, turns, y, q, sine, versine

      shifted = phase*(angles/two_pi) + rounder
      turns = shifted - rounder
      k = int(iand(transfer(shifted, 0_int64), int(angles - 1, int64)))
      y = (phase - turns*parts(1)) - turns*parts(2)
      q = y*y
      sine = y + (y*q)*((q*(1/120.0_wp) - 1/6.0_wp) - (q*q)*(1/5040.0_wp))
      versine = q*((0.5_wp - q*(1/24.0_wp)) + (q*q)*(1/720.0_wp - q*(1/40320.0_wp)))
      s = sines(k) + (cosines(k)*sine - sines(k)*versine)
      c = cosines(k) - (sines(k)*sine + cosines(k)*versine)
   end subroutine sine_cosine

   !> Marches from the wall just left, with a departure speed > 0, to the first contact.
   !!
   !! Returns side 0 if there is no contact within the limit, or where it cannot decide.
   pure subroutine march(m, s, c, x, x_dot, z, z_dot, half, side, speed, limit, touch)
      !> Tables of the run.
      type(transition_type), intent(in) :: m
      !> At the start: sine and cosine of the load phase, positions (F0/K) and velocities (omega
      !! F0/K) of the primary and the free mass.
      real(wp), intent(in) :: s, c, x, x_dot, z, z_dot
      !> Half the clearance (F0/K).
      real(wp), intent(in) :: half
      !> The wall just left: +1 right, -1 left.
      integer, intent(in) :: side
      !> Departure speed relative to that wall (omega F0/K), and the latest time (1/omega) that is
      !! examined.
      real(wp), intent(in) :: speed, limit
      !> The contact; with side 0, the time up to which there is none.
      type(touch_type), intent(out) :: touch
      type(moment_type) :: here
      real(wp) :: base, idle, bounds(0:2), lower, upper, toward, y
      integer :: a, k, middle, n, size
      logical :: free

      here = moment_of(m, s, c, x, x_dot, z, z_dot)
      base = 0
      a = 0
      ! in the first cell the wall just left is known not to be hit
      upper = merge(huge(half), half, side > 0)
      lower = -merge(huge(half), half, side < 0)
      bounds = bounds_after(m, here)
      size = first_size(m, here, side, speed, bounds(2))
      do n = 1, cell_budget
         if (a >= nodes) then
            ! from the start, not from `here`, which would gather rounding errors
            base = base + a*m%h
            a = 0
            here = moment_after(m, moment_of(m, s, c, x, x_dot, z, z_dot), base)
            idle = idle_time(m, here, half)
            if (idle > 0) here = moment_after(m, moment_of(m, s, c, x, x_dot, z, z_dot), &
               base + idle)
            base = base + idle
            bounds = bounds_after(m, here)
         end if
         if (size < 0 .or. base + a*m%h > limit) exit
         k = 2**size
         y = position(m, here, a + 2*k)
         free = y > lower .and. y < upper
         if (free) free = clear(m, here, lower, upper, a, size, bounds(1))
         if (.not. free) then
            toward = direction(m, here, a, size, bounds(2))
            if (toward*y >= half) then
               middle = a + k
               if (size == largest) then
                  k = k/2
                  middle = a + merge(k, 3*k, toward*position(m, here, a + 2*k) >= half)
               end if
               call pinpoint(m, here, toward, half, middle, k*m%h, touch)
               touch%time = base + touch%time
               if (touch%side /= 0) return
               toward = 0
            end if
            if (.not. abs(toward) > 0) then
               size = size - 1
               cycle
            end if
         end if
         a = a + 2*k
         if (size < largest .and. iand(a, 4*k - 1) == 0) size = size + 1
         upper = half
         lower = -half
      end do
      touch%time = base + a*m%h
   end subroutine march

   !> Size of the largest first cell in which the wall just left is certainly not hit again; -1 if
   !! that is not certain for any size.
   !!
   !! The gap to that wall is t k(t), with k'''' at most a fifth of the bound on x'''''.
   pure integer function first_size(m, at, side, speed, bound) result(size)
      !> Tables of the run.
      type(transition_type), intent(in) :: m
      !> State at the start of the flight.
      type(moment_type), intent(in) :: at
      !> The wall just left: +1 right, -1 left.
      integer, intent(in) :: side
      !> Departure speed (omega F0/K), and a bound on the fifth derivative of x.
      real(wp), intent(in) :: speed, bound
      real(wp) :: k(4)

      do size = largest, 0, -1
         k = side*combined(m%departure(:, :, size), at)
         if (speed + min(k(1), k(2), k(3), k(4)) > 0.2_wp*bound*m%error(size)) return
      end do
   end function first_size

   !> y = z - x (F0/K) at a node of the table.
   pure real(wp) function position(m, here, j) result(y)
      !> Tables of the run.
      type(transition_type), intent(in) :: m
      !> State at node 0.
      type(moment_type), intent(in) :: here
      !> Number of the node, 0 to `nodes`.
      integer, intent(in) :: j

      associate (f => m%table(:, j))
         y = (here%z + here%z_dot*(j*m%h)) - ((f(1)*here%free + f(2)*here%free_dot) &
            + (f(3)*here%sine + f(4)*here%cosine))
      end associate
   end function position

   !> Whether a cell is proved to have no contact.
   pure logical function clear(m, here, lower, upper, a, size, bound)
      !> Tables of the run.
      type(transition_type), intent(in) :: m
      !> State at node 0.
      type(moment_type), intent(in) :: here
      !> y at the walls (F0/K).
      real(wp), intent(in) :: lower, upper
      !> First node and size of the cell.
      integer, intent(in) :: a, size
      !> Bound on the fourth derivative of x.
      real(wp), intent(in) :: bound
      real(wp) :: x(4), z, step, error

      x = combined(m%position(:, :, first_cell(size) + ishft(a, -size - 1)), here)
      z = here%z + here%z_dot*(a*m%h)
      step = here%z_dot*(2**(size + 1)*m%h*(1.0_wp/3))
      x = (z + step*[0, 1, 2, 3]) - x
      error = bound*m%error(size)
      clear = max(x(1), x(2), x(3), x(4)) < upper - error .and. &
         min(x(1), x(2), x(3), x(4)) > lower + error
   end function clear

   !> The sign of y' if it is the same throughout a cell, otherwise 0.
   !!
   !! A slope that may fall below an eighth of its maximum is left to smaller cells, so that
   !! Newton's method is safe.
   pure real(wp) function direction(m, here, a, size, bound)
      !> Tables of the run.
      type(transition_type), intent(in) :: m
      !> State at node 0.
      type(moment_type), intent(in) :: here
      !> First node and size of the cell.
      integer, intent(in) :: a, size
      !> Bound on the fifth derivative of x.
      real(wp), intent(in) :: bound
      real(wp) :: v(4), error

      v = here%z_dot - combined(m%velocity(:, :, first_cell(size) + ishft(a, -size - 1)), here)
      direction = sign(1.0_wp, v(1))
      v = direction*v
      error = bound*m%error(size)
      if (.not. min(v(1), v(2), v(3), v(4)) - error > &
         0.125_wp*(max(v(1), v(2), v(3), v(4)) + error)) direction = 0
   end function direction

   !> Bernstein coefficients of the cubic in a cell: the cubics of the four functions, weighted by
   !! the components of a state.
   pure function combined(matrix, at) result(b)
      !> (coefficient, function): cubics of the four functions in the cell, from the tables.
      real(wp), intent(in) :: matrix(4, 4)
      !> State at node 0.
      type(moment_type), intent(in) :: at
      real(wp) :: b(4)

      b = (matrix(:, 1)*at%free + matrix(:, 2)*at%free_dot) &
         + (matrix(:, 3)*at%sine + matrix(:, 4)*at%cosine)
   end function combined

   !> The one contact in a cell in which y is monotone.
   !!
   !! A series reversion about the middle of the cell, to fifth order, nearly always leads to a time
   !! that is almost right, and another one there, to third order, to the contact. Otherwise
   !! Newton's method comes between them.
   pure subroutine pinpoint(m, here, toward, half, centre, w, touch)
      !> Tables of the run.
      type(transition_type), intent(in) :: m
      !> State at node 0.
      type(moment_type), intent(in) :: here
      !> The wall, +1 right or -1 left, and half the clearance (F0/K).
      real(wp), intent(in) :: toward, half
      !> Middle node of the cell.
      integer, intent(in) :: centre
      !> Half the width of the cell (1/omega).
      real(wp), intent(in) :: w
      !> In: side 0. Out: the contact, its time counted from node 0; unchanged if Newton's
      !! method fails.
      type(touch_type), intent(inout) :: touch
      type(moment_type) :: at
      real(wp) :: time, origin, t, e, last, b(4), c(4), x, x_dot, inverse
      integer :: n, node

      at = moved(m, here, m%table(:, centre))
      time = centre*m%h
      inverse = 1/(here%z_dot - (at%free_dot + m%r*at%cosine))
      e = (((toward*half - here%z) - here%z_dot*time) + (at%free + at%sine))*inverse
      b = combined(m%higher, at)*inverse
      t = (e + b(1)*(e*e)) + (e*e)*((e*(2*b(1)**2 + b(2)) &
         + (e*e)*(5*b(1)*(b(1)**2 + b(2)) + b(3))) &
         + (e*(e*e))*((b(1)**2*(14*b(1)**2 + 21*b(2)) + 3*b(2)**2) + (6*b(1)*b(3) + b(4))))
      do n = 1, 20
         ! the contact is in the cell
         if (.not. abs(t) <= w) t = sign(w, t)
         time = centre*m%h + t
         ! the time of a short flight needs full relative accuracy: it is counted from the start
         t = time*m%inverse_h + rounder
         if (time <= m%h) t = rounder
         node = int(iand(transfer(t, 0_int64), 63_int64))
         origin = (t - rounder)*m%h
         t = time - origin
         at = moved(m, moved(m, here, m%table(:, node)), nearby(m, t))
         x = at%free + at%sine
         x_dot = at%free_dot + m%r*at%cosine
         inverse = 1/(here%z_dot - x_dot)
         e = (((toward*half - here%z) - here%z_dot*time) + x)*inverse
         c = combined(m%higher, at)
         b = c*inverse
         last = (e*e)*(e*e)*(5*b(1)*(b(1)**2 + b(2)) + b(3))
         e = e + (e*e)*(b(1) + e*(2*b(1)**2 + b(2)))
         if (abs(e) <= 2e-3_wp*m%h .and. abs(last) <= 1e-15_wp*m%h) then
            touch%side = int(toward)
            touch%time = max(0.0_wp, origin + (t + e))
            touch%x = x + e*(x_dot + e*(c(1) + e*(c(2) + e*c(3))))
            touch%x_dot = x_dot + e*(2*c(1) + e*(3*c(2) + 4*e*c(3)))
            return
         end if
         t = (time + e) - centre*m%h
      end do
   end subroutine pinpoint

   !> Both parts of x a time later, like `moment_after`; the free mass is left at 0.
   pure function moved(m, from, f) result(to)
      !> Tables of the run; only 2 xi is read.
      type(transition_type), intent(in) :: m
      !> State at time 0.
      type(moment_type), intent(in) :: from
      !> The four functions at that time.
      real(wp), intent(in) :: f(4)
      type(moment_type) :: to

      to%free = f(1)*from%free + f(2)*from%free_dot
      to%free_dot = f(1)*from%free_dot - f(2)*(from%free + m%two_xi*from%free_dot)
      to%sine = f(3)*from%sine + f(4)*from%cosine
      to%cosine = f(3)*from%cosine - f(4)*from%sine
   end function moved

   !> The four functions by their Taylor series, for times no longer than the distance of nodes.
   pure function nearby(m, t) result(f)
      !> Tables of the run; only the Taylor coefficients are read.
      type(transition_type), intent(in) :: m
      !> Time (1/omega), of either sign.
      real(wp), intent(in) :: t
      real(wp) :: f(4)
      real(wp) :: t2, t4

      t2 = t*t
      t4 = t2*t2
      associate (c => m%taylor)
         f = ((c(:, 0) + c(:, 1)*t) + t2*(c(:, 2) + c(:, 3)*t)) &
            + t4*(((c(:, 4) + c(:, 5)*t) + t2*(c(:, 6) + c(:, 7)*t)) &
            + t4*((c(:, 8) + c(:, 9)*t) + t2*(c(:, 10) + c(:, 11)*t)))
      end associate
   end function nearby

   !> The state at a phase of the load.
   pure function moment_of(m, s, c, x, x_dot, z, z_dot) result(at)
      !> Tables of the run; only r and the forced part are read.
      type(transition_type), intent(in) :: m
      !> Sine and cosine of the load phase, positions (F0/K) and velocities (omega F0/K) of the
      !! primary and the free mass.
      real(wp), intent(in) :: s, c, x, x_dot, z, z_dot
      type(moment_type) :: at

      at%sine = m%in_phase*s - m%behind*c
      at%cosine = m%in_phase*c + m%behind*s
      at%free = x - at%sine
      at%free_dot = x_dot - m%r*at%cosine
      at%z = z
      at%z_dot = z_dot
   end function moment_of

   !> Bounds on the derivatives of x of orders 0, 4 and 5 from a given state on.
   !!
   !! A derivative does not change the amplitude of the free part, and multiplies that of the forced
   !! part by r.
   pure function bounds_after(m, at) result(bounds)
      !> Tables of the run.
      type(transition_type), intent(in) :: m
      !> State from which the bounds hold.
      type(moment_type), intent(in) :: at
      real(wp) :: bounds(0:2)

      bounds = sqrt(at%free**2 + m%inverse*(at%free_dot + m%xi*at%free)**2)
      bounds = (bounds + m%forced)*(1 + 16*epsilon(1.0_wp))
   end function bounds_after

end module vi_march
