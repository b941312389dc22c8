!> First contact of an ordinary flight, at the cost of a few multiplications.
!!
!! The flight is divided into cells of time. In a cell y = z - x and y' are cubics to within a
!! proven error, and Bernstein coefficients bound a cubic from both sides. They prove that a cell
!! has no contact, or that y is monotone in it. A monotone y has one contact or none, depending on
!! its value at the end of the cell, and Newton's method finds it. Where neither can be proved in
!! the smallest cell (grazing, many contacts in succession), the march stops and returns the time
!! from which on `first_contact` has to search.
module vi_march
   use vi_kinds, only: wp
   use vi_transition, only: bounds_after, first_cell, idle_time, largest, moment_after, &
      moment_of, moment_type, nodes, transition_type
   implicit none (type, external)
   private

   public :: direction, march

   !> Cells after which a flight is left to `first_contact`, whose steps grow where a slow load
   !! alone moves the primary mass.
   integer, parameter :: cell_budget = 100000
   real(wp), parameter :: sixth = 1.0_wp/6, by_24 = 1.0_wp/24, by_120 = 1.0_wp/120

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
      type(moment_type) :: start, here
      real(wp) :: base, idle, bounds(0:2), toward
      integer :: a, k, n, size, left

      here = moment_of(m, s, c, x, x_dot)
      here%z = z
      here%z_dot = z_dot
      start = here
      base = 0
      a = 0
      left = side
      bounds = bounds_after(m, here)
      size = first_size(m, here, side, speed, bounds(2))
      do n = 1, cell_budget
         if (a >= nodes) then
            base = base + a*m%h
            a = 0
            here = moment_after(m, start, base)
            idle = idle_time(m, here, half)
            if (idle > 0) here = moment_after(m, start, base + idle)
            base = base + idle
            bounds = bounds_after(m, here)
         end if
         if (size < 0 .or. base + a*m%h > limit) exit
         k = 2**size
         if (.not. clear(m, here, half, left, a, size, bounds(1))) then
            toward = direction(m, here, a, size, bounds(2))
            if (.not. abs(toward) > 0) then
               size = size - 1
               cycle
            end if
            if (toward*position(m, here, a + 2*k) >= half) then
               if (size == largest) then
                  k = k/2
                  if (toward*position(m, here, a + 2*k) < half) a = a + 2*k
               end if
               call pinpoint(m, here, half, toward, a + k, k*m%h, touch)
               touch%time = base + touch%time
               return
            end if
         end if
         a = a + 2*k
         if (size < largest .and. iand(a, 4*k - 1) == 0) size = size + 1
         left = 0
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
         k = combined(m%departure(:, :, size), at)
         if (side < 0) k = -k
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
   pure logical function clear(m, here, half, left, a, size, bound)
      !> Tables of the run.
      type(transition_type), intent(in) :: m
      !> State at node 0.
      type(moment_type), intent(in) :: here
      !> Half the clearance (F0/K).
      real(wp), intent(in) :: half
      !> A wall that is known not to be hit in this cell (+1, -1), or 0; first node of the cell;
      !! size of the cell.
      integer, intent(in) :: left, a, size
      !> Bound on the fourth derivative of x.
      real(wp), intent(in) :: bound
      real(wp) :: x(4), z, step, reserve

      x = combined(m%position(:, :, first_cell(size) + ishft(a, -size - 1)), here)
      z = here%z + here%z_dot*(a*m%h)
      step = here%z_dot*(2**(size + 1)*m%h*(1.0_wp/3))
      x = (z + step*[0, 1, 2, 3]) - x
      reserve = half - bound*m%error(size)
      clear = (left > 0 .or. max(x(1), x(2), x(3), x(4)) < reserve) &
         .and. (left < 0 .or. min(x(1), x(2), x(3), x(4)) > -reserve)
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
   pure subroutine pinpoint(m, here, half, toward, centre, w, touch)
      !> Tables of the run.
      type(transition_type), intent(in) :: m
      !> State at node 0.
      type(moment_type), intent(in) :: here
      !> Half the clearance (F0/K).
      real(wp), intent(in) :: half
      !> The wall: +1 right, -1 left.
      real(wp), intent(in) :: toward
      !> Middle node of the cell.
      integer, intent(in) :: centre
      !> Half the width of the cell (1/omega).
      real(wp), intent(in) :: w
      !> In: side 0. Out: the contact, its time counted from node 0; if Newton's method fails, side
      !! 0 and the start of the cell.
      type(touch_type), intent(inout) :: touch
      type(moment_type) :: middle, at
      real(wp) :: origin, t, s, s2, last, x_dot, y(0:5)
      integer :: i

      origin = centre*m%h
      middle = moved(m, here, m%table(:, centre), origin)
      at = middle
      t = 0
      do i = 1, 20
         y = forward(m, at)
         call revert(y, toward*half, s, last)
         if (abs(last) <= 8e-13_wp*m%h .and. abs(s) <= 0.016_wp*m%h) then
            if (origin + t > m%h .or. .not. origin > 0) then
               touch%side = merge(1, -1, toward > 0)
               touch%time = max(0.0_wp, origin + (t + s))
               x_dot = at%free_dot + m%r*at%cosine
               s2 = s*s
               touch%x_dot = (x_dot - s*y(2)) - s2*((0.5_wp*y(3) + s*sixth*y(4)) + s2*(by_24*y(5)))
               touch%x = ((at%free + at%sine) + s*x_dot) - s2*((0.5_wp*y(2) + s*sixth*y(3)) &
                  + s2*(by_24*y(4) + s*by_120*y(5)))
               return
            end if
            ! the time of a short flight needs full relative accuracy: it is counted from the start
            middle = here
            t = origin + t
            origin = 0
         end if
         t = min(max(t + s, -origin, -w), w)
         at = moved(m, middle, nearby(m, t), t)
      end do
      touch%time = centre*m%h - w
   end subroutine pinpoint

   !> The time shift after which y reaches a value, by series reversion to fifth order.
   pure subroutine revert(y, value, shift, last)
      !> y and its first five derivatives, and the value (F0/K).
      real(wp), intent(in) :: y(0:5), value
      !> Time (1/omega) from there to the value, and the term of fifth order in it, an estimate of
      !! the error.
      real(wp), intent(out) :: shift, last
      real(wp) :: inverse, e, e2, a, b, c, d

      inverse = 1/y(1)
      e = (value - y(0))*inverse
      a = 0.5_wp*y(2)*inverse
      b = sixth*y(3)*inverse
      c = by_24*y(4)*inverse
      d = by_120*y(5)*inverse
      e2 = e*e
      last = (e*e2)*e2*(((14*a*a - 21*b)*(a*a) + 3*b*b) + (6*a*c - d))
      shift = (e + e2*(((2*a*a - b)*e - a) + e2*(5*a*(b - a*a) - c))) + last
   end subroutine revert

   !> The state a time t later, like `moment_after`, with the four functions given.
   pure function moved(m, from, f, t) result(to)
      !> Tables of the run; only 2 xi is read.
      type(transition_type), intent(in) :: m
      !> State at time 0.
      type(moment_type), intent(in) :: from
      !> The four functions at time t, and t (1/omega).
      real(wp), intent(in) :: f(4), t
      type(moment_type) :: to

      to%free = f(1)*from%free + f(2)*from%free_dot
      to%free_dot = f(1)*from%free_dot - f(2)*(from%free + m%two_xi*from%free_dot)
      to%sine = f(3)*from%sine + f(4)*from%cosine
      to%cosine = f(3)*from%cosine - f(4)*from%sine
      to%z = from%z + from%z_dot*t
      to%z_dot = from%z_dot
   end function moved

   !> The four functions by their Taylor series, for times within half the shortest time scale (the
   !! largest cells are longer than that).
   pure function nearby(m, t) result(f)
      !> Tables of the run; only the Taylor coefficients are read.
      type(transition_type), intent(in) :: m
      !> Time (1/omega), of either sign.
      real(wp), intent(in) :: t
      real(wp) :: f(4)
      real(wp) :: t2, t4, p(6)

      t2 = t*t
      t4 = t2*t2
      associate (c => m%taylor)
         p = ((c(:, 0) + c(:, 1)*t2) + t4*(c(:, 2) + c(:, 3)*t2)) &
            + (t4*t4)*((c(:, 4) + c(:, 5)*t2) + t4*(c(:, 6) + c(:, 7)*t2))
      end associate
      f = [p(1) + t*p(2), p(3) + t*p(4), p(5), t*p(6)]
   end function nearby

   !> y = z - x and its first five derivatives at a state.
   pure function forward(m, at) result(y)
      !> Tables of the run; only xi and r are read.
      type(transition_type), intent(in) :: m
      !> State of both masses.
      type(moment_type), intent(in) :: at
      real(wp) :: y(0:5)
      real(wp) :: f2, f3, f4, f5, p2, p3

      f2 = -(m%two_xi*at%free_dot + at%free)
      f3 = -(m%two_xi*f2 + at%free_dot)
      f4 = -(m%two_xi*f3 + f2)
      f5 = -(m%two_xi*f4 + f3)
      p2 = m%r2*at%sine
      p3 = m%r2*(m%r*at%cosine)
      y(0) = at%z - (at%free + at%sine)
      y(1) = at%z_dot - (at%free_dot + m%r*at%cosine)
      y(2) = p2 - f2
      y(3) = p3 - f3
      y(4) = -(f4 + m%r2*p2)
      y(5) = -(f5 + m%r2*p3)
   end function forward

end module vi_march
