!> The largest |x| of many flights over the same nodes, one flight per lane, as in vi_nodes.
module vi_lane_peak
   use vi_kinds, only: wp
   use vi_plan, only: lanes
   implicit none (type, external)
   private

   public :: find_largest, raise

   !> Terms of a Taylor series about a node; the omitted terms are below rounding.
   integer, parameter :: terms = 11
   real(wp), parameter :: sixth = 1/6.0_wp

contains

   !> The largest |x|: the stationary point near the node with the largest |x|, and a proof that |x|
   !! is nowhere larger.
   pure subroutine find_largest(n, step, xi, r, position, rise, bound, parts, x, x_rise, largest, &
      certain)
      !> Number of the last node; the first one is 0.
      integer, intent(in) :: n
      !> Time between the nodes (1/omega); damping ratio; frequency ratio; the tables of vi_nodes;
      !! bound on the fourth derivative of x; parts(lane, :): coefficients of the four functions; x
      !! at the nodes (F0/K), and its derivative there times `step`.
      real(wp), intent(in) :: step, xi, r, position(4, 0:n), rise(4, 0:n), bound(lanes), &
         parts(lanes, 4), x(lanes, 0:n), x_rise(lanes, 0:n)
      !> Largest |x| of each lane (F0/K).
      real(wp), intent(out) :: largest(lanes)
      !> False where the proof failed; `largest` is then meaningless.
      logical, intent(out) :: certain(lanes)
      real(wp), dimension(lanes) :: shift, peak, highest, best
      real(wp) :: node(lanes, 4)
      integer :: top(lanes), segment(lanes), j, l

      ! both ends have the same |x|, which may rise further inside the flight at either end
      top = merge(n, 0, x(:, n)*x_rise(:, n) < 0)
      best = abs(x(:, n))
      do j = n - 1, 1, -1
         do l = 1, lanes
            top(l) = merge(j, top(l), abs(x(l, j)) > best(l))
            best(l) = max(best(l), abs(x(l, j)))
         end do
      end do
      call at_node(n, position, rise, parts, top, node)
      call climb(step, xi, r, node, shift, peak)
      do l = 1, lanes
         if (top(l) == 0 .and. .not. x(l, 0)*x_rise(l, 0) > 0) then
            shift(l) = 0
            peak(l) = x(l, 0)
         end if
         ! the stationary point lies between two nodes: the segment after node `segment`
         segment(l) = merge(top(l), top(l) - 1, shift(l) > 0)
         shift(l) = merge(shift(l) + step, shift(l), shift(l) < 0)
         certain(l) = segment(l) >= 0 .and. segment(l) < n .and. shift(l) <= step
         if (abs(shift(l)) <= 0) then
            certain(l) = .true.
            segment(l) = n
         end if
      end do
      largest = abs(peak)
      call prove(n, step, bound, x, x_rise, segment, shift, peak, highest)
      certain = certain .and. highest <= largest + 100*epsilon(1.0_wp)*(bound + largest)
   end subroutine find_largest

   !> A proven upper bound on |x|, given its stationary point.
   pure subroutine prove(n, step, bound, x, x_rise, segment, shift, peak, highest)
      !> Number of the last node; the first one is 0.
      integer, intent(in) :: n
      !> Time between the nodes (1/omega); bound on the fourth derivative of x; x at the nodes
      !! (F0/K), and its derivative there times `step`.
      real(wp), intent(in) :: step, bound(lanes), x(lanes, 0:n), x_rise(lanes, 0:n)
      !> The stationary point lies at time `shift` after this node; n if it is a node itself.
      integer, intent(in) :: segment(lanes)
      !> Time from that node to the stationary point (1/omega), and x there (F0/K).
      real(wp), intent(in) :: shift(lanes), peak(lanes)
      !> The bound on |x| over all nodes and segments (F0/K).
      real(wp), intent(out) :: highest(lanes)
      real(wp), dimension(lanes) :: none, dip, rest, top, before, after
      real(wp) :: ends(lanes, 4)
      integer :: j, l

      dip = bound*(step*step)**2/144
      highest = 0
      ends = 0
      do j = 0, n - 1
         rest = highest
         call raise(rest, x(:, j), x_rise(:, j), x(:, j + 1), x_rise(:, j + 1), dip)
         do l = 1, lanes
            highest(l) = merge(highest(l), rest(l), segment(l) == j)
            ends(l, 1) = merge(x(l, j), ends(l, 1), segment(l) == j)
            ends(l, 2) = merge(x_rise(l, j), ends(l, 2), segment(l) == j)
            ends(l, 3) = merge(x(l, j + 1), ends(l, 3), segment(l) == j)
            ends(l, 4) = merge(x_rise(l, j + 1), ends(l, 4), segment(l) == j)
         end do
      end do
      ! both parts of the segment; without a stationary point in it there are none
      none = 0
      top = merge(0.0_wp, peak, segment == n)
      before = merge(0.0_wp, shift, segment == n)
      after = merge(0.0_wp, step - shift, segment == n)
      ends(:, 2) = ends(:, 2)*(before/step)
      ends(:, 4) = ends(:, 4)*(after/step)
      dip = bound*(before*before)**2/144
      call raise(highest, ends(:, 1), ends(:, 2), top, none, dip)
      dip = bound*(after*after)**2/144
      call raise(highest, top, none, ends(:, 3), ends(:, 4), dip)
   end subroutine prove

   !> Raises `highest` to at least the largest |f| between two nodes, as in vi_bernstein.
   pure subroutine raise(highest, f, rise, f_next, rise_next, dip)
      !> In: any bound. Out: raised where |f| may be larger in the segment.
      real(wp), intent(inout) :: highest(lanes)
      !> f at both nodes, and its derivative there times the distance between them; `dip`: `sag` of
      !! vi_bernstein for that distance.
      real(wp), intent(in), dimension(lanes) :: f, rise, f_next, rise_next, dip

      highest = max(highest, abs(f), abs(f + 0.25_wp*rise), &
         abs(0.5_wp*(f + f_next) + sixth*(rise - rise_next)) + dip, &
         abs(f_next - 0.25_wp*rise_next), abs(f_next))
   end subroutine raise

   !> The free and the forced part of x at a node, and their derivatives times `step`.
   pure subroutine at_node(n, position, rise, parts, top, node)
      !> Number of the last node, and the required node of each lane.
      integer, intent(in) :: n, top(lanes)
      !> The tables of vi_nodes, and the coefficients of the four functions.
      real(wp), intent(in) :: position(4, 0:n), rise(4, 0:n), parts(lanes, 4)
      !> node(lane, :): free part, its derivative times `step`, forced part, its derivative times
      !! `step`.
      real(wp), intent(out) :: node(lanes, 4)
      integer :: l

      do l = 1, lanes
         associate (p => position(:, top(l)), v => rise(:, top(l)))
            node(l, 1) = parts(l, 1)*p(1) + parts(l, 2)*p(2)
            node(l, 2) = parts(l, 1)*v(1) + parts(l, 2)*v(2)
            node(l, 3) = parts(l, 3)*p(3) + parts(l, 4)*p(4)
            node(l, 4) = parts(l, 3)*v(3) + parts(l, 4)*v(4)
         end associate
      end do
   end subroutine at_node

   !> The stationary point of x near a node by Newton's method: its time from there, and x.
   !!
   !! Where the method fails, the proof that follows fails too.
   pure subroutine climb(step, xi, r, node, shift, x)
      !> Time between the nodes (1/omega), damping ratio, frequency ratio, and the node from
      !! `at_node`.
      real(wp), intent(in) :: step, xi, r, node(lanes, 4)
      !> Time from the node to the stationary point (1/omega), of either sign, and x there (F0/K).
      real(wp), intent(out) :: shift(lanes), x(lanes)
      integer :: i, last, n, l
      real(wp), parameter :: inverse_factorial(0:terms) = [(1/gamma(i + 1.0_wp), i=0, terms)]
      real(wp) :: free(lanes, 0:terms), forced(lanes, 0:terms), c(lanes, 0:terms)
      real(wp), dimension(lanes) :: slope, curvature

      free(:, 0) = node(:, 1)
      free(:, 1) = node(:, 2)/step
      forced(:, 0) = node(:, 3)
      forced(:, 1) = node(:, 4)/step
      do n = 2, terms
         free(:, n) = -2*xi*free(:, n - 1) - free(:, n - 2)
         forced(:, n) = -r**2*forced(:, n - 2)
      end do
      do n = 0, terms
         c(:, n) = (free(:, n) + forced(:, n))*inverse_factorial(n)
      end do
      shift = 0
      do i = 1, 4
         ! the first steps need only a few terms
         last = merge(4, terms, i <= 2)
         do l = 1, lanes
            slope(l) = last*c(l, last)
            curvature(l) = 0
         end do
         do n = last - 1, 1, -1
            curvature = curvature*shift + slope
            slope = slope*shift + n*c(:, n)
         end do
         shift = shift - slope/curvature
      end do
      x = c(:, terms)
      do n = terms - 1, 0, -1
         x = x*shift + c(:, n)
      end do
   end subroutine climb

end module vi_lane_peak
