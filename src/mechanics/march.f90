!> First contact of an ordinary flight, found at the price of a few products.
!!
!! A flight is marched over in cells. At the middle of a cell both parts of x follow from those at the
!! start by a table of transition matrices, made once for all flights of a run, and all derivatives by
!! the equation of motion. The cubic Taylor polynomial of y = z - x, as Bernstein coefficients, and a
!! bound on the fourth derivative then prove that a cell has no contact, or that y is monotone in it:
!! then there is one contact at most, and Newton's method cannot miss it. Where neither can be proved
!! (grazing, many contacts on end) the march stops and says from when on `first_contact` of vi_contact,
!! which is always right, has to look.
module vi_march
   use vi_kinds, only: wp
   use vi_oscillator, only: eta
   implicit none (type, external)
   private

   public :: new_march, march

   !> Nodes of the table, and the greatest half width of a cell in nodes.
   integer, parameter :: nodes = 64, widest = 4
   !> Terms of each parity for a step of half a node distance: 0.0625^10/10! = 2.5e-19 is left out.
   integer, parameter :: terms = 5

   !> What the flights of a run have in common.
   type, public :: march_type
      real(wp) :: xi = 0, r = 1
      !> Distance of the nodes, 1/8 of the shortest time scale.
      real(wp) :: h = 0
      !> (:, j): u and v of t = j h, with u = 1, u' = 0 and v = 0, v' = 1 at 0 being the free motions;
      !> cos(r t), sin(r t).
      real(wp) :: table(4, 0:nodes) = 0
      !> Taylor coefficients of the same functions: even and odd ones of u, of v, those of cos, sin.
      real(wp) :: taylor(0:terms - 1, 6) = 0
   end type march_type

   !> A moment of a flight.
   type, public :: moment_type
      !> Free part of x and its derivative.
      real(wp) :: free, free_dot
      !> Forced part: A times the sine and the cosine of its argument.
      real(wp) :: sine, cosine
      real(wp) :: z, z_dot
   end type moment_type

   type, public :: touch_type
      !> +1 or -1; 0 if there is no contact before `time`, and nothing is known about later.
      integer :: side = 0
      real(wp) :: time = 0
      real(wp) :: x = 0, x_dot = 0
   end type touch_type

contains

   !> The table and polynomials for a damping and a frequency ratio.
   pure function new_march(xi, r) result(m)
      real(wp), intent(in) :: xi, r
      type(march_type) :: m
      real(wp) :: u(0:2*terms - 1), v(0:2*terms - 1), c(0:2*terms - 1)
      integer :: n

      m%xi = xi
      m%r = r
      m%h = 0.125_wp/max(1.0_wp, r)
      do n = 0, nodes
         m%table(:, n) = transition(m, n*m%h)
      end do
      u(0:1) = [1, 0]
      v(0:1) = [0, 1]
      c(0:1) = [1.0_wp, r]
      do n = 2, 2*terms - 1
         u(n) = -(2*xi*(n - 1)*u(n - 1) + u(n - 2))/(n*(n - 1))
         v(n) = -(2*xi*(n - 1)*v(n - 1) + v(n - 2))/(n*(n - 1))
         c(n) = -r**2*c(n - 2)/(n*(n - 1))
      end do
      m%taylor(:, 1) = u(0::2)
      m%taylor(:, 2) = u(1::2)
      m%taylor(:, 3) = v(0::2)
      m%taylor(:, 4) = v(1::2)
      m%taylor(:, 5) = c(0::2)
      m%taylor(:, 6) = c(1::2)
   end function new_march

   !> u, v, cos(r t) and sin(r t) after any time.
   pure function transition(m, t) result(row)
      type(march_type), intent(in) :: m
      real(wp), intent(in) :: t
      real(wp) :: row(4)
      real(wp) :: frequency, shrink

      frequency = eta(m%xi)
      shrink = exp(-m%xi*t)
      row(2) = shrink*sin(frequency*t)/frequency
      row(1) = shrink*cos(frequency*t) + m%xi*row(2)
      row(3) = cos(m%r*t)
      row(4) = sin(m%r*t)
   end function transition

   !> The moment that a row of transitions leads to, a time t later.
   pure function moved(m, from, row, t) result(to)
      type(march_type), intent(in) :: m
      type(moment_type), intent(in) :: from
      real(wp), intent(in) :: row(4), t
      type(moment_type) :: to

      to%free = row(1)*from%free + row(2)*from%free_dot
      to%free_dot = row(1)*from%free_dot - row(2)*(from%free + 2*m%xi*from%free_dot)
      to%sine = row(3)*from%sine + row(4)*from%cosine
      to%cosine = row(3)*from%cosine - row(4)*from%sine
      to%z = from%z + from%z_dot*t
      to%z_dot = from%z_dot
   end function moved

   !> x and its first five derivatives.
   pure function derivatives(m, at) result(d)
      type(march_type), intent(in) :: m
      type(moment_type), intent(in) :: at
      real(wp) :: d(0:5)
      real(wp) :: f2, f3, f4, f5, r2

      r2 = m%r**2
      f2 = -2*m%xi*at%free_dot - at%free
      f3 = -2*m%xi*f2 - at%free_dot
      f4 = -2*m%xi*f3 - f2
      f5 = -2*m%xi*f4 - f3
      d(0) = at%free + at%sine
      d(1) = at%free_dot + m%r*at%cosine
      d(2) = f2 - r2*at%sine
      d(3) = f3 - r2*(m%r*at%cosine)
      d(4) = f4 + r2*(r2*at%sine)
      d(5) = f5 + r2*(r2*(m%r*at%cosine))
   end function derivatives

   !> A bound on the fourth derivative of x from a moment on.
   pure real(wp) function bound_after(m, at) result(bound)
      type(march_type), intent(in) :: m
      type(moment_type), intent(in) :: at
      real(wp) :: turned

      turned = (at%free_dot + m%xi*at%free)**2/((1 - m%xi)*(1 + m%xi))
      bound = sqrt(at%free**2 + turned) + sqrt(at%sine**2 + at%cosine**2)*m%r**4
      bound = bound*(1 + 16*epsilon(1.0_wp))
   end function bound_after

   !> Marches from the wall just left, with a departure speed > 0, to the first contact.
   !!
   !! Returns without a side at the limit, or where a contact can neither be excluded nor isolated.
   pure subroutine march(m, start, half, side, speed, limit, touch)
      type(march_type), intent(in) :: m
      type(moment_type), intent(in) :: start
      !> Half the clearance.
      real(wp), intent(in) :: half
      !> The wall just left, and how fast.
      integer, intent(in) :: side
      real(wp), intent(in) :: speed, limit
      type(touch_type), intent(out) :: touch
      type(moment_type) :: here
      real(wp) :: bound, d(0:5), base, toward
      integer :: a, k, left
      logical :: clear, monotone

      here = start
      base = 0
      a = 0
      left = side
      bound = bound_after(m, here)
      k = first_width(m, derivatives(m, here), side, speed, bound)
      do while (k > 0)
         if (a + 2*k > nodes) then
            base = base + a*m%h
            here = moved(m, start, transition(m, base), base)
            bound = bound_after(m, here)
            a = 0
         end if
         if (base + a*m%h > limit) exit
         d = relative(m, here, a + k)
         call inspect(d, k*m%h, bound, half, left, clear, monotone)
         if (.not. (clear .or. monotone)) then
            k = k/2
            cycle
         end if
         if (.not. clear) then
            toward = sign(1.0_wp, d(1))
            if (toward*end_position(m, here, a + 2*k) >= half) then
               call pinpoint(m, here, half, toward, a, k, d, touch)
               touch%time = base + touch%time
               return
            end if
         end if
         a = a + 2*k
         k = min(2*k, widest)
         left = 0
      end do
      touch%time = base + a*m%h
   end subroutine march

   !> Half width of the first cell, in nodes: the wall just left is not hit again within it; or 0.
   !!
   !! The gap to that wall is t k(t) with k >= v + k1 t + k2 t^2 - B t^3/24, here in Bernstein form.
   pure integer function first_width(m, d, side, speed, bound) result(k)
      type(march_type), intent(in) :: m
      real(wp), intent(in) :: d(0:5)
      integer, intent(in) :: side
      real(wp), intent(in) :: speed, bound
      real(wp) :: t, middle, last

      k = widest
      do while (k > 0)
         t = 2*k*m%h
         middle = speed + side*d(2)*t/4
         last = speed + side*t*(d(2)/2 + d(3)*t/6)
         if (min(speed, middle, last) > bound*t**3/24) return
         k = k/2
      end do
   end function first_width

   !> y = z - x and its derivatives at a node.
   pure function relative(m, here, j) result(y)
      type(march_type), intent(in) :: m
      type(moment_type), intent(in) :: here
      integer, intent(in) :: j
      real(wp) :: y(0:5)
      type(moment_type) :: at

      at = moved(m, here, m%table(:, j), j*m%h)
      y = -derivatives(m, at)
      y(0) = at%z + y(0)
      y(1) = at%z_dot + y(1)
   end function relative

   !> y at a node.
   pure real(wp) function end_position(m, here, j) result(y)
      type(march_type), intent(in) :: m
      type(moment_type), intent(in) :: here
      integer, intent(in) :: j
      type(moment_type) :: at

      at = moved(m, here, m%table(:, j), j*m%h)
      y = at%z - (at%free + at%sine)
   end function end_position

   !> Whether a cell has no contact, and whether y is monotone in it.
   pure subroutine inspect(y, w, bound, half, left, clear, monotone)
      !> y and its derivatives in the middle.
      real(wp), intent(in) :: y(0:5)
      !> Half width of the cell.
      real(wp), intent(in) :: w
      !> Bound on the fourth derivative.
      real(wp), intent(in) :: bound, half
      !> A wall that is known to be out of question, or 0.
      integer, intent(in) :: left
      logical, intent(out) :: clear, monotone
      real(wp) :: p1, p2, p3, b(4), q1, q2, c(3), reserve, slope

      p1 = y(1)*w
      p2 = y(2)*w**2/2
      p3 = y(3)*w**3/6
      b(1) = y(0) + p2 - (p1 + p3)
      b(2) = y(0) - p2/3 - (p1/3 - p3)
      b(3) = y(0) - p2/3 + (p1/3 - p3)
      b(4) = y(0) + p2 + (p1 + p3)
      reserve = half - bound*w**4/24
      clear = (left > 0 .or. max(b(1), b(2), b(3), b(4)) < reserve) &
         .and. (left < 0 .or. min(b(1), b(2), b(3), b(4)) > -reserve)
      monotone = .false.
      if (clear) return
      q1 = y(2)*w
      q2 = y(3)*w**2/2
      c = [y(1) - q1 + q2, y(1) - q2, y(1) + q1 + q2]
      c = sign(1.0_wp, y(1))*c
      slope = bound*w**3/6
      ! a slope that falls to less than an eighth is left to smaller cells, so that Newton is safe
      monotone = min(c(1), c(2), c(3)) - slope > (max(c(1), c(2), c(3)) + slope)/8
   end subroutine inspect

   !> The one contact in a cell in which y is monotone.
   pure subroutine pinpoint(m, here, half, toward, a, k, middle, touch)
      type(march_type), intent(in) :: m
      type(moment_type), intent(in) :: here
      real(wp), intent(in) :: half
      !> The wall.
      real(wp), intent(in) :: toward
      !> First node of the cell and its half width in nodes.
      integer, intent(in) :: a, k
      !> y and its derivatives in the middle.
      real(wp), intent(in) :: middle(0:5)
      type(touch_type), intent(inout) :: touch
      real(wp) :: t, shift, last, w, y(0:5), d(0:5), value, slope
      integer :: i

      w = k*m%h
      call revert(middle, toward*half, shift, last)
      shift = min(max(shift, -w), w)
      value = middle(0) - toward*half + shift*(middle(1) + shift*(middle(2)/2 + shift*(middle(3)/6 &
         + shift*(middle(4)/24 + shift*middle(5)/120))))
      slope = middle(1) + shift*(middle(2) + shift*(middle(3)/2 + shift*(middle(4)/6 &
         + shift*middle(5)/24)))
      shift = shift - value/slope
      do i = 1, 20
         t = (a + k)*m%h + min(max(shift, -w), w)
         call evaluate(m, here, t, d, y)
         call revert(y, toward*half, shift, last)
         if (abs(last) <= 8e-13_wp*m%h .and. abs(shift) <= 0.008_wp*m%h) then
            touch%side = nint(toward)
            touch%time = max(0.0_wp, t + shift)
            touch%x = d(0) + shift*(d(1) + shift*(d(2)/2 + shift*(d(3)/6 + shift*d(4)/24)))
            touch%x_dot = d(1) + shift*(d(2) + shift*(d(3)/2 + shift*(d(4)/6 + shift*d(5)/24)))
            return
         end if
         shift = t + shift - (a + k)*m%h
      end do
      touch%time = a*m%h
   end subroutine pinpoint

   !> x, y and their derivatives at any time covered by the table.
   pure subroutine evaluate(m, here, t, d, y)
      type(march_type), intent(in) :: m
      type(moment_type), intent(in) :: here
      real(wp), intent(in) :: t
      real(wp), intent(out) :: d(0:5), y(0:5)
      type(moment_type) :: at
      real(wp) :: e, e2, e4, row(4)
      integer :: j

      j = int(t/m%h + 0.5_wp)
      e = t - j*m%h
      e2 = e*e
      e4 = e2*e2
      row(1) = sum_even(m%taylor(:, 1)) + e*sum_even(m%taylor(:, 2))
      row(2) = sum_even(m%taylor(:, 3)) + e*sum_even(m%taylor(:, 4))
      row(3) = sum_even(m%taylor(:, 5))
      row(4) = e*sum_even(m%taylor(:, 6))
      at = moved(m, moved(m, here, m%table(:, j), j*m%h), row, e)
      at%z = here%z + here%z_dot*t
      d = derivatives(m, at)
      y = -d
      y(0) = at%z + y(0)
      y(1) = at%z_dot + y(1)
   contains
      !> A polynomial in e^2.
      pure real(wp) function sum_even(c)
         real(wp), intent(in) :: c(0:terms - 1)

         sum_even = (c(0) + c(1)*e2) + e4*((c(2) + c(3)*e2) + e4*c(4))
      end function sum_even
   end subroutine evaluate

   !> Where y reaches a value, to fourth order in the distance; `last` is the term of that order.
   pure subroutine revert(y, value, shift, last)
      real(wp), intent(in) :: y(0:5), value
      real(wp), intent(out) :: shift, last
      real(wp) :: inverse, e, a, b, c

      inverse = 1/y(1)
      e = (value - y(0))*inverse
      a = y(2)*inverse/2
      b = y(3)*inverse/6
      c = y(4)*inverse/24
      last = (5*a*(b - a*a) - c)*(e*e)*(e*e)
      shift = e - e*e*(a - (2*a*a - b)*e) + last
   end subroutine revert

end module vi_march
