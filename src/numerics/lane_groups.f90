!> A few rows of a dense matrix at a time, as many as a vector register has lanes, how long they
!! stay away from limits, and bounds on pairs.
!!
!! The loops are for vector instructions, also where they have conditions, and the sums of a group
!! stay in registers. They are taken in the order of vi_lane_rows, so that the results do not depend
!! on how rows are evaluated.
module vi_lane_groups
   use vi_kinds, only: wp
   use vi_plan, only: lanes
   implicit none (type, external)
   private

   public :: add_group, bound_group, bound_pairs, certify, sizes_of_pairs, sum_bounds

   !> Rows of a group.
   integer, parameter, public :: group = 4

contains

   !> y = y + a x and z = z + a v with a group of rows, in the order of `add_products` of
   !! vi_lane_rows.
   pure subroutine add_group(m, a, x, v, y, z)
      !> Columns.
      integer, intent(in) :: m
      !> The rows of the matrix; x and v (m).
      real(wp), intent(in) :: a(group, m), x(m), v(m)
      !> The sums.
      real(wp), intent(inout) :: y(group), z(group)
      real(wp) :: p(group), q(group)
      integer :: k

      p = y
      q = z
      do k = 1, m - 3, 4
         p = p + ((a(:, k)*x(k) + a(:, k + 1)*x(k + 1)) &
            + (a(:, k + 2)*x(k + 2) + a(:, k + 3)*x(k + 3)))
         q = q + ((a(:, k)*v(k) + a(:, k + 1)*v(k + 1)) &
            + (a(:, k + 2)*v(k + 2) + a(:, k + 3)*v(k + 3)))
      end do
      do k = m - mod(m, 4) + 1, m
         p = p + a(:, k)*x(k)
         q = q + a(:, k)*v(k)
      end do
      y = p
      z = q
   end subroutine add_group

   !> y = y + |a| x with a group of rows.
   pure subroutine bound_group(m, a, x, y)
      !> Columns.
      integer, intent(in) :: m
      !> The rows of the matrix, and x (m).
      real(wp), intent(in) :: a(group, m), x(m)
      !> The sums.
      real(wp), intent(inout) :: y(group)
      real(wp) :: p(group)
      integer :: k

      p = y
      do k = 1, m - 3, 4
         p = p + ((abs(a(:, k))*x(k) + abs(a(:, k + 1))*x(k + 1)) &
            + (abs(a(:, k + 2))*x(k + 2) + abs(a(:, k + 3))*x(k + 3)))
      end do
      do k = m - mod(m, 4) + 1, m
         p = p + abs(a(:, k))*x(k)
      end do
      y = p
   end subroutine bound_group

   !> How long rows stay away from their limits, from their values and rates now and bounds on
   !! their second derivatives from now on.
   pure subroutine certify(n, y, rate, norm, root, more, margin, upper, lower, longest, share, h, &
      span, slack, speed, left)
      !> Number of rows, at most `group`.
      integer, intent(in) :: n
      !> (n) Values and rates.
      real(wp), dimension(n), intent(in) :: y, rate
      !> The bounds: norm (n) times root, and a further part.
      real(wp), intent(in) :: norm(n), root, more
      !> Distance from the limits that is not used, and the limits (n).
      real(wp), intent(in) :: margin, upper(n), lower(n)
      !> The longest time of use, the share of the time found that is returned, and the length of a
      !! cell.
      real(wp), intent(in) :: longest, share, h
      !> The time, not above 0 if there is none; the distance from the limits that is left then, and
      !! the largest rate up to then.
      real(wp), intent(out) :: span, slack, speed
      !> The distance from the limits to which the Bernstein coefficients of the cell come at most,
      !! without the part that is due to the fourth derivative.
      real(wp), intent(out) :: left
      !> A row without a limit has a distance of this.
      !! The smallest sum of rates makes a time that is a number.
      real(wp), parameter :: far = 1.0e100_wp, small = 1.0e-200_wp
      real(wp), dimension(group) :: above, below, bend, rise, fall, time
      integer :: i

      ! loops may compute with all lanes of a register
      above = 0
      below = 0
      bend = 0
      rise = 0
      fall = 0
      time = 0
      do i = 1, n
         bend(i) = norm(i)*root + more
         above(i) = min(upper(i) - y(i) - margin, far)
         below(i) = min(y(i) - lower(i) - margin, far)
         rise(i) = max(rate(i), 0.0_wp)
         fall(i) = max(-rate(i), 0.0_wp)
         ! where the distance is rate t + bend t^2/2
         time(i) = min(2*above(i)/(rise(i) + sqrt(rise(i)*rise(i) &
            + 2*bend(i)*max(above(i), 0.0_wp)) + small), 2*below(i)/(fall(i) &
            + sqrt(fall(i)*fall(i) + 2*bend(i)*max(below(i), 0.0_wp)) + small))
      end do
      span = longest
      do i = 1, n
         ! written so that a NaN is kept
         span = merge(span, share*time(i), span <= share*time(i))
      end do
      do i = 1, n
         time(i) = min(above(i) - rise(i)*h, below(i) - fall(i)*h) - 0.75_wp*bend(i)*h*h
      end do
      span = max(span, -1.0_wp)                      ! rows beyond a limit: no square overflows
      left = far
      do i = 1, n
         left = merge(left, time(i), left <= time(i))
      end do
      slack = far
      speed = 0
      do i = 1, n
         slack = min(slack, min(above(i) - rise(i)*span, below(i) - fall(i)*span) &
            - 0.5_wp*bend(i)*span*span)
         speed = max(speed, (rise(i) + fall(i)) + bend(i)*span)
      end do
   end subroutine certify

   !> Bounds on the absolute fourth derivatives of pairs, from now on: v^2 + omega^2 x^2 never
   !! grows, and above critical damping neither does x exceed the other bound of `bound_on` in
   !! vi_modes.
   pure subroutine bound_pairs(n, stiffness, damping, inverse, drift, drift_rate, force, &
      force_rate, x0, v0, of_x, of_v)
      !> Number of pairs.
      integer, intent(in) :: n
      !> (n) omega^2, sigma, and 1/omega; as in `modes_type` of vi_modes.
      real(wp), dimension(n), intent(in) :: stiffness, damping, inverse
      !> (n) The constant terms, and the rates at which they grow.
      real(wp), dimension(n), intent(in) :: drift, drift_rate, force, force_rate
      !> (n) The pairs now.
      real(wp), intent(in) :: x0(n), v0(n)
      !> (n) The bounds.
      real(wp), intent(out) :: of_x(n), of_v(n)
      real(wp) :: drag, x1, v1, x2, v2, x3, v3, x4, v4, slow
      integer :: k

      do k = 1, n
         drag = 2*damping(k)
         x1 = v0(k) + drift(k)
         v1 = -stiffness(k)*x0(k) - drag*v0(k) + force(k)
         x2 = v1 + drift_rate(k)
         v2 = -stiffness(k)*x1 - drag*v1 + force_rate(k)
         x3 = v2
         v3 = -stiffness(k)*x2 - drag*v2
         x4 = v3
         v4 = -stiffness(k)*x3 - drag*v3
         of_v(k) = sqrt(v4*v4 + stiffness(k)*x4*x4)
         of_x(k) = merge(of_v(k)*inverse(k), abs(x4), stiffness(k) > 0)
         ! v4 + drag x4 = -omega^2 x3
         slow = abs(x4) + stiffness(k)*abs(x3)/merge(drag, 1.0_wp, drag*drag > 4*stiffness(k))
         of_x(k) = merge(slow, of_x(k), drag*drag > 4*stiffness(k) .and. slow < of_x(k))
      end do
   end subroutine bound_pairs

   !> Sums over pairs of the squares of bounds on |x| and |v| over some time.
   pure subroutine sizes_of_pairs(n, duration, stiffness, damping, inverse, drift, drift_rate, &
      force, force_rate, x, v, sum_x, sum_v)
      !> Number of pairs.
      integer, intent(in) :: n
      !> How long.
      real(wp), intent(in) :: duration
      !> (n) As in `bound_pairs`.
      real(wp), dimension(n), intent(in) :: stiffness, damping, inverse
      !> (n) As in `bound_pairs`.
      real(wp), dimension(n), intent(in) :: drift, drift_rate, force, force_rate
      !> (n) The pairs at the beginning.
      real(wp), intent(in) :: x(n), v(n)
      !> The sums.
      real(wp), intent(out) :: sum_x, sum_v
      real(wp) :: f, p, of_x, of_v, squares(lanes, 2), part(0:group - 1, 2)
      integer :: j, k, l, m

      part = 0
      do k = 0, n - 1, lanes
         m = min(lanes, n - k)
         do j = 1, m
            f = abs(force(k + j)) + duration*abs(force_rate(k + j))
            p = abs(drift(k + j)) + duration*abs(drift_rate(k + j))
            ! v^2 + omega^2 x^2 never grows, x without the part due to the constant terms
            of_x = abs(x(k + j)) + (f + 2*damping(k + j)*p)*inverse(k + j)**2
            of_v = (abs(v(k + j)) + p)**2 + stiffness(k + j)*of_x**2
            ! within the time, |x| from v = 1 is at most the time, and from x = 1 at most 1; at
            ! frequency 0 that is all, and at a tiny frequency it is far less
            f = abs(v(k + j)) + f*duration
            p = abs(x(k + j)) + (f + p)*duration
            f = f + stiffness(k + j)*p*duration
            squares(j, 1) = merge(of_v*inverse(k + j)**2, p**2, stiffness(k + j) > 0 .and. &
               of_v*inverse(k + j)**2 < p**2)
            squares(j, 2) = merge(of_v, f**2, stiffness(k + j) > 0 .and. of_v < f**2)
         end do
         l = group*((m + group - 1)/group)
         squares(m + 1:l, :) = 0
         do j = 1, l, group
            part(:, 1) = part(:, 1) + squares(j:j + group - 1, 1)
            part(:, 2) = part(:, 2) + squares(j:j + group - 1, 2)
         end do
      end do
      sum_x = (part(0, 1) + part(1, 1)) + (part(2, 1) + part(3, 1))
      sum_v = (part(0, 2) + part(1, 2)) + (part(2, 2) + part(3, 2))
   end subroutine sizes_of_pairs

   !> Sums over pairs of the squares of bounds on their second and fourth derivatives, from now on,
   !! where the constant terms do not grow.
   pure subroutine sum_bounds(n, stiffness, damping, inverse, drift, force, x0, v0, of_x, second, &
      fourth)
      !> Number of pairs.
      integer, intent(in) :: n
      !> (n) omega^2, sigma, 1/omega and the constant terms, as in `modes_type` of vi_modes.
      real(wp), dimension(n), intent(in) :: stiffness, damping, inverse, drift, force
      !> (n) The pairs now, and the bounds on the fourth derivatives of x.
      real(wp), intent(in) :: x0(n), v0(n), of_x(n)
      !> The sums.
      real(wp), intent(out) :: second, fourth
      real(wp), dimension(0:group - 1) :: of_second, of_fourth
      real(wp) :: x2, v2
      integer :: j, k, l

      of_second = 0
      of_fourth = 0
      do k = 1, n - group + 1, group
         do l = 0, group - 1
            j = k + l
            x2 = -stiffness(j)*x0(j) - 2*damping(j)*v0(j) + force(j)
            v2 = (-stiffness(j)*(v0(j) + drift(j)) - 2*damping(j)*x2)*inverse(j)
            of_second(l) = of_second(l) + (x2*x2 + v2*v2)
            of_fourth(l) = of_fourth(l) + of_x(j)*of_x(j)
         end do
      end do
      second = (of_second(0) + of_second(1)) + (of_second(2) + of_second(3))
      fourth = (of_fourth(0) + of_fourth(1)) + (of_fourth(2) + of_fourth(3))
      do j = n - mod(n, group) + 1, n
         x2 = -stiffness(j)*x0(j) - 2*damping(j)*v0(j) + force(j)
         v2 = (-stiffness(j)*(v0(j) + drift(j)) - 2*damping(j)*x2)*inverse(j)
         second = second + (x2*x2 + v2*v2)
         fourth = fourth + of_x(j)*of_x(j)
      end do
   end subroutine sum_bounds

end module vi_lane_groups
