!> Flights of one duration: the free and the forced oscillation at fixed nodes, computed once.
!!
!! Every flight is a linear combination of these. A bound on its fourth derivative bounds it between
!! the nodes; if the bound cannot decide, the caller has to use another method.
module vi_nodes
   use vi_bernstein, only: sag, stays_within
   use vi_kinds, only: pi, wp
   use vi_oscillator, only: eta
   implicit none (type, external)
   private

   public :: find_largest, new_nodes

   !> Nodes in half a load cycle or half a free oscillation; a flight that needs more than
   !! `most_nodes` has none.
   integer, parameter :: density = 8
   integer, parameter, public :: most_nodes = 240

   !> The nodes of flights of one duration; n = 0 if they would be too many.
   type, public :: nodes_type
      real(wp) :: xi = 0, r = 1, step = 0
      integer :: n = 0
      !> (4, 0:n): exp(-xi t) sin(eta t), exp(-xi t) cos(eta t), sin(r t), cos(r t) at the nodes,
      !! and their derivatives times the step.
      real(wp), allocatable :: position(:, :), rise(:, :)
   end type nodes_type

contains

   !> The nodes of flights of a given duration.
   pure subroutine new_nodes(xi, r, duration, nodes)
      !> Damping ratio, frequency ratio, and duration of the flights (1/omega).
      real(wp), intent(in) :: xi, r, duration
      !> Out: the nodes; the arrays are reallocated.
      type(nodes_type), intent(inout) :: nodes
      real(wp) :: t, h, shrink, s, c, wanted
      integer :: j

      nodes%xi = xi
      nodes%r = r
      nodes%n = 0
      wanted = density*duration*max(1.0_wp, r)/pi
      if (wanted > most_nodes) return
      nodes%n = ceiling(wanted)
      nodes%step = duration/nodes%n
      if (allocated(nodes%position)) deallocate (nodes%position, nodes%rise)
      allocate (nodes%position(4, 0:nodes%n), nodes%rise(4, 0:nodes%n))
      h = eta(xi)
      do j = 0, nodes%n
         t = j*nodes%step
         shrink = exp(-xi*t)
         s = shrink*sin(h*t)
         c = shrink*cos(h*t)
         nodes%position(:, j) = [s, c, sin(r*t), cos(r*t)]
         nodes%rise(:, j) = nodes%step*[h*c - xi*s, -h*s - xi*c, r*cos(r*t), -r*sin(r*t)]
      end do
   end subroutine new_nodes

   !> The largest |x| of a flight: the stationary point near the node with the largest |x|, and a
   !! proof that |x| is nowhere larger.
   pure subroutine find_largest(nodes, parts, bound, x, x_rise, largest, certain)
      !> The nodes.
      type(nodes_type), intent(in) :: nodes
      !> Coefficients of the four functions, and a bound on the fourth derivative of x.
      real(wp), intent(in) :: parts(4), bound
      !> x and its rise at the nodes (0:n); at both ends |x| is the same.
      real(wp), intent(in) :: x(0:), x_rise(0:)
      !> Largest |x|; has no meaning unless `certain`.
      real(wp), intent(out) :: largest
      !> False where the proof failed.
      logical, intent(out) :: certain
      real(wp) :: shift, peak, level, dip
      integer :: j, n, top

      n = nodes%n
      dip = sag(bound, nodes%step)
      ! |x| is the same at both ends, and may be larger just after the start or just before the end
      top = n
      do j = n - 1, 1, -1
         if (abs(x(j)) > abs(x(top))) top = j
      end do
      if (top == n .and. x(n)*x_rise(n) >= 0) top = 0
      peak = x(top)
      shift = 0
      if (top > 0 .or. x(0)*x_rise(0) > 0) call climb(nodes, parts, top, shift, peak)
      largest = abs(peak)
      level = largest + 100*epsilon(1.0_wp)*(bound + largest)
      ! the stationary point lies between the nodes j and j + 1
      j = merge(top, top - 1, shift > 0)
      if (shift < 0) shift = nodes%step + shift
      certain = j >= 0 .and. j < n .and. shift >= 0 .and. shift <= nodes%step
      if (abs(shift) <= 0) then
         certain = stays_within(level, x, x_rise, dip)
      else if (certain) then
         certain = stays_within(level, x(:j), x_rise(:j), dip) .and. &
            stays_within(level, x(j + 1:), x_rise(j + 1:), dip) .and. &
            stays_within(level, [x(j), peak], [x_rise(j)*(shift/nodes%step), 0.0_wp], &
            sag(bound, shift)) .and. &
            stays_within(level, [peak, x(j + 1)], [0.0_wp, x_rise(j + 1)*(1 - shift/nodes%step)], &
            sag(bound, nodes%step - shift))
      end if
   end subroutine find_largest

   !> The stationary point of x near a node, by Newton's method.
   pure subroutine climb(nodes, parts, j, shift, x)
      !> The nodes.
      type(nodes_type), intent(in) :: nodes
      !> Coefficients of the four functions.
      real(wp), intent(in) :: parts(4)
      !> Number of the node.
      integer, intent(in) :: j
      !> Time from the node to the stationary point (1/omega), of either sign, and x there.
      real(wp), intent(out) :: shift, x
      !> Terms of the Taylor series about the node; the remainder is below rounding.
      integer, parameter :: terms = 11
      real(wp), parameter :: inverse_factorial(0:terms) = 1/gamma([1.0_wp, 2.0_wp, 3.0_wp, &
         4.0_wp, 5.0_wp, 6.0_wp, 7.0_wp, 8.0_wp, 9.0_wp, 10.0_wp, 11.0_wp, 12.0_wp])
      real(wp) :: free(0:terms), forced(0:terms), c(0:terms), slope, curvature
      integer :: i, n, last

      associate (p => parts, q => nodes%position(:, j), v => nodes%rise(:, j))
         free(0:1) = [p(1)*q(1) + p(2)*q(2), (p(1)*v(1) + p(2)*v(2))/nodes%step]
         forced(0:1) = [p(3)*q(3) + p(4)*q(4), (p(3)*v(3) + p(4)*v(4))/nodes%step]
      end associate
      do n = 2, terms
         free(n) = -2*nodes%xi*free(n - 1) - free(n - 2)
         forced(n) = -nodes%r**2*forced(n - 2)
      end do
      c = (free + forced)*inverse_factorial
      shift = 0
      do i = 1, 8
         ! the first steps need only a few terms
         last = merge(4, terms, i <= 2)
         slope = last*c(last)
         curvature = 0
         do n = last - 1, 1, -1
            curvature = curvature*shift + slope
            slope = slope*shift + n*c(n)
         end do
         if (.not. abs(slope) < nodes%step*abs(curvature)) exit
         shift = shift - slope/curvature
         if (i > 2 .and. abs(slope) <= 1.0e-5_wp*abs(curvature)*nodes%step) exit
      end do
      x = c(terms)
      do n = terms - 1, 0, -1
         x = x*shift + c(n)
      end do
   end subroutine climb

end module vi_nodes
