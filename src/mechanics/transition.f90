!> Tables that advance the two parts of x in time, common to all flights of a run.
!!
!! Both are linear in the state from which they start: the free part is u(t) times its position plus
!! v(t) times its velocity, the forced part rotates by cos(r t), sin(r t). These four functions are
!! kept at nodes, as polynomials around 0, and as cubics in cells between nodes. From the cubics and
!! a bound on the fourth derivative vi_march proves that a cell has no contact, or that y is
!! monotone in it.
module vi_transition
   use vi_kinds, only: pi, wp
   use vi_oscillator, only: eta
   implicit none (type, external)
   private

   public :: idle_time, moment_after, new_transition

   !> Sizes of cells: their half widths are 1, 2, 4 and 8 nodes.
   integer, parameter, public :: largest = 3
   !> Nodes of the table, and cells of all sizes in it.
   integer, parameter, public :: nodes = 3*2**(largest + 1)
   !> Cells of all sizes, and the first one of each size.
   integer, parameter :: cells = nodes - nodes/2**(largest + 1)
   integer, parameter, public :: first_cell(0:largest) = nodes - nodes/[1, 2, 4, 8]
   !> Terms of a step from the nearest node, which is not longer than the distance between nodes:
   !! 0.125^12/12! = 3e-20 is left out.
   integer, parameter, public :: terms = 12
   !> A flight in which a gap closes after this share of the shortest time scale is left to
   !! vi_bounce.
   real(wp), parameter, public :: shortest_flight = 0.1_wp

   !> The four functions are u and v, the free motions with u = 1, u' = 0 and v = 0, v' = 1 at 0,
   !! and cos(r t), sin(r t).
   type, public :: transition_type
      real(wp) :: xi = 0, r = 1
      !> 2 xi, r^2 and 1/(1 - xi^2).
      real(wp) :: two_xi = 0, r2 = 1, inverse = 1
      !> The component of the forced part in phase with the load, and the one that lags it by a
      !! quarter of a cycle: A cos(lag), A sin(lag).
      real(wp) :: in_phase = 0, behind = 0
      !> Amplitudes of the derivatives of the forced part of orders 0, 4 and 5.
      real(wp) :: forced(0:2) = 0
      !> Distance between the nodes, 1/8 of the shortest time scale, and its inverse.
      real(wp) :: h = 0, inverse_h = 0
      !> The functions at t = j h.
      real(wp) :: table(4, 0:nodes)
      !> (function, power): their Taylor coefficients around 0.
      real(wp) :: taylor(4, 0:terms - 1)
      !> Those of powers 2 to 5, (power, function).
      real(wp) :: higher(4, 4)
      !> (Bernstein coefficient, function, cell): cubics near the functions and their derivatives.
      real(wp) :: position(4, 4, 0:cells - 1), velocity(4, 4, 0:cells - 1)
      !> (.., size): the same for (f(t) - f(0) - f'(0) t)/t in a cell at the start.
      real(wp) :: departure(4, 4, 0:largest)
      !> (size): error of the cubics over the bound on the derivative of order 4.
      real(wp) :: error(0:largest)
   end type transition_type

   !> The state at one instant of a flight.
   type, public :: moment_type
      !> Free part of x and its derivative.
      real(wp) :: free = 0, free_dot = 0
      !> Forced part: A times the sine and the cosine of its argument.
      real(wp) :: sine = 0, cosine = 0
      real(wp) :: z = 0, z_dot = 0
   end type moment_type

contains

   !> The tables for a damping, a frequency ratio, and the forced part, A cos(lag) and A sin(lag).
   pure subroutine new_transition(xi, r, in_phase, behind, m, marched)
      !> Damping ratio, frequency ratio, and the components A cos(lag) and A sin(lag) of the forced
      !! motion (F0/K).
      real(wp), intent(in) :: xi, r, in_phase, behind
      !> Out: all tables filled.
      type(transition_type), intent(inout) :: m
      !> Whether vi_march will use them, true if it is left out: vi_bounce needs no tables.
      logical, intent(in), optional :: marched
      integer :: n

      m%xi = xi
      m%r = r
      m%two_xi = 2*xi
      m%r2 = r**2
      m%inverse = 1/((1 - xi)*(1 + xi))
      m%in_phase = in_phase
      m%behind = behind
      m%forced = hypot(in_phase, behind)*[1.0_wp, r**4, r**5]
      m%h = 0.125_wp/max(1.0_wp, r)
      m%inverse_h = 1/m%h
      if (present(marched)) then
         if (.not. marched) return
      end if
      do n = 0, nodes
         m%table(:, n) = later(m, n*m%h)
      end do
      m%taylor(:, 0) = [1, 0, 1, 0]
      m%taylor(:, 1) = [0.0_wp, 1.0_wp, 0.0_wp, r]
      do n = 2, terms - 1
         m%taylor(:2, n) = -(2*xi*(n - 1)*m%taylor(:2, n - 1) + m%taylor(:2, n - 2))/(n*(n - 1))
         m%taylor(3:, n) = -r**2*m%taylor(3:, n - 2)/(n*(n - 1))
      end do
      m%higher = transpose(m%taylor(:, 2:5))
      do n = 0, largest
         call set_cubics(m, n)
      end do
   end subroutine new_transition

   !> The four functions u, v, cos(r t), sin(r t) at any time.
   pure function later(m, t) result(f)
      !> Only xi and r are read.
      type(transition_type), intent(in) :: m
      !> Time (1/omega).
      real(wp), intent(in) :: t
      real(wp) :: f(4)
      real(wp) :: frequency, shrink

      frequency = eta(m%xi)
      shrink = exp(-m%xi*t)
      f(2) = shrink*sin(frequency*t)/frequency
      f(1) = shrink*cos(frequency*t) + m%xi*f(2)
      f(3) = cos(m%r*t)
      f(4) = sin(m%r*t)
   end function later

   !> The cubics through the values at the Chebyshev nodes of every cell of a size.
   !!
   !! Their error is at most B w^4/(4! 2^3), w being half the width of the cell and B a bound on the
   !! derivative of order 4.
   pure subroutine set_cubics(m, size)
      !> In: with `table` filled. Out: its cubics and error factor of this size are set too.
      type(transition_type), intent(inout) :: m
      !> Size of the cells, 0 to `largest`: half a cell is 2**size nodes wide.
      integer, intent(in) :: size
      real(wp), parameter :: place(4) = [-cos(pi/8), -cos(3*pi/8), cos(3*pi/8), cos(pi/8)]
      real(wp) :: x(4, 4), v(4, 4), q(4, 4), t, w
      integer :: i

      w = 2**size*m%h
      m%error(size) = w**4/192*(1 + 16*epsilon(1.0_wp))
      do i = 1, 4
         x(:, i) = later(m, w*place(i))
         v(:, i) = [-x(2, i), x(1, i) - 2*m%xi*x(2, i), -m%r*x(4, i), m%r*x(3, i)]
         t = w + w*place(i)
         q(:, i) = (later(m, t) - [1.0_wp, t, 1.0_wp, m%r*t])/t
      end do
      m%departure(:, :, size) = bernstein(q, place(3:4))
      x = bernstein(x, place(3:4))
      v = bernstein(v, place(3:4))
      do i = 0, nodes/2**(size + 1) - 1
         associate (middle => m%table(:, (2*i + 1)*2**size))
            m%position(:, :, first_cell(size) + i) = shifted(x, middle, m%xi)
            m%velocity(:, :, first_cell(size) + i) = shifted(v, middle, m%xi)
         end associate
      end do
   end subroutine set_cubics

   !> Bernstein coefficients (.., function) of cubics with given values (function, place).
   pure function bernstein(f, place) result(b)
      !> f(function, place): values at -place(2), -place(1), place(1), place(2) of [-1, 1].
      real(wp), intent(in) :: f(4, 4), place(2)
      real(wp) :: b(4, 4)
      real(wp) :: even(4, 0:2), odd(4, 3)

      even(:, 2) = 0.5_wp*((f(:, 4) + f(:, 1)) - (f(:, 3) + f(:, 2)))/(place(2)**2 - place(1)**2)
      even(:, 0) = 0.5_wp*(f(:, 4) + f(:, 1)) - even(:, 2)*place(2)**2
      odd(:, 3) = 0.5_wp*((f(:, 4) - f(:, 1))/place(2) - (f(:, 3) - f(:, 2))/place(1)) &
         /(place(2)**2 - place(1)**2)
      odd(:, 1) = 0.5_wp*(f(:, 4) - f(:, 1))/place(2) - odd(:, 3)*place(2)**2
      b(1, :) = even(:, 0) + even(:, 2) - (odd(:, 1) + odd(:, 3))
      b(2, :) = even(:, 0) - even(:, 2)/3 - (odd(:, 1)/3 - odd(:, 3))
      b(3, :) = even(:, 0) - even(:, 2)/3 + (odd(:, 1)/3 - odd(:, 3))
      b(4, :) = even(:, 0) + even(:, 2) + (odd(:, 1) + odd(:, 3))
   end function bernstein

   !> Cubics of a cell whose middle is a transition f later than the start.
   pure function shifted(b, f, xi) result(c)
      !> b(coefficient, function): cubics of a cell whose middle is at time 0; f: the four functions
      !! at the new middle; damping ratio.
      real(wp), intent(in) :: b(4, 4), f(4), xi
      real(wp) :: c(4, 4)

      c(:, 1) = f(1)*b(:, 1) - f(2)*b(:, 2)
      c(:, 2) = f(2)*b(:, 1) + (f(1) - 2*xi*f(2))*b(:, 2)
      c(:, 3) = f(3)*b(:, 3) - f(4)*b(:, 4)
      c(:, 4) = f(4)*b(:, 3) + f(3)*b(:, 4)
   end function shifted

   !> The state a time t after another one.
   pure function moment_after(m, from, t) result(to)
      !> Tables of the run; only xi and r are read.
      type(transition_type), intent(in) :: m
      !> State at time 0.
      type(moment_type), intent(in) :: from
      !> Time (1/omega) from there, of any length.
      real(wp), intent(in) :: t
      type(moment_type) :: to
      real(wp) :: f(4)

      f = later(m, min(t, huge(1.0_wp)*epsilon(1.0_wp)))
      to%free = f(1)*from%free + f(2)*from%free_dot
      to%free_dot = f(1)*from%free_dot - f(2)*(from%free + m%two_xi*from%free_dot)
      to%sine = f(3)*from%sine + f(4)*from%cosine
      to%cosine = f(3)*from%cosine - f(4)*from%sine
      to%z = from%z + from%z_dot*t
      to%z_dot = from%z_dot
   end function moment_after

   !> How long no contact is possible: the time (1/omega) for which both walls are out of reach even
   !! at the greatest amplitude of x; 0 where that is not certain.
   pure real(wp) function idle_time(m, at, half) result(time)
      !> Tables of the run.
      type(transition_type), intent(in) :: m
      !> State at the time in question.
      type(moment_type), intent(in) :: at
      !> Half the clearance (F0/K).
      real(wp), intent(in) :: half
      real(wp) :: reserve, speed

      time = 0
      reserve = half - m%forced(0) - sqrt(at%free**2 + m%inverse*(at%free_dot + m%xi*at%free)**2)
      if (.not. reserve > abs(at%z)) return
      reserve = reserve - sign(1.0_wp, at%z_dot)*at%z
      speed = abs(at%z_dot)
      time = huge(1.0_wp)
      if (reserve < speed*(huge(1.0_wp)*epsilon(1.0_wp))) time = reserve/speed
   end function idle_time

end module vi_transition
