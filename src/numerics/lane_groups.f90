!> Single rows of a dense matrix, how long they stay away from limits, and bounds on pairs.
!!
!! The loops are for vector instructions, also where they have conditions. A row is multiplied with
!! as many vectors at a time as a register has lanes, so that the sums stay in registers. They are
!! taken in the order of vi_lane_rows, so that the results do not depend on how rows are evaluated.
module vi_lane_groups
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: accelerate, add_derivatives, add_rows, add_stacked, bound_free_pairs, bound_pairs, &
      bound_row, certify, list_uncovered, lower_slack, sizes_of_free_pairs, sizes_of_pairs, stack, &
      sum_bounds

   !> Numbers that are summed side by side.
   integer, parameter, public :: group = 4

contains

   !> Writes as many vectors as a group has members side by side.
   pure subroutine stack(m, x, v, x_next, v_next, stacked)
      !> Their length.
      integer, intent(in) :: m
      !> (m) The vectors.
      real(wp), dimension(m), intent(in) :: x, v, x_next, v_next
      !> The vectors as rows.
      real(wp), intent(out) :: stacked(group, m)
      integer :: k, l

      do k = 1, m - group + 1, group
         do l = 0, group - 1
            stacked(1, k + l) = x(k + l)
            stacked(2, k + l) = v(k + l)
            stacked(3, k + l) = x_next(k + l)
            stacked(4, k + l) = v_next(k + l)
         end do
      end do
      do k = m - mod(m, group) + 1, m
         stacked(:, k) = [x(k), v(k), x_next(k), v_next(k)]
      end do
   end subroutine stack

   !> Adds the products of a row with vectors that are stacked, in the order of `add_products` of
   !! vi_lane_rows.
   pure subroutine add_stacked(m, a, stacked, y)
      !> Columns.
      integer, intent(in) :: m
      !> The row, and the vectors.
      real(wp), intent(in) :: a(m), stacked(group, m)
      !> The sums.
      real(wp), intent(inout) :: y(group)
      real(wp) :: p(group)
      integer :: k

      p = y
      do k = 1, m - 3, 4
         p = p + ((stacked(:, k)*a(k) + stacked(:, k + 1)*a(k + 1)) &
            + (stacked(:, k + 2)*a(k + 2) + stacked(:, k + 3)*a(k + 3)))
      end do
      do k = m - mod(m, 4) + 1, m
         p = p + stacked(:, k)*a(k)
      end do
      y = p
   end subroutine add_stacked

   !> Adds the products of the moduli of a row with a vector, in the same order.
   pure subroutine bound_row(m, a, x, y)
      !> Columns.
      integer, intent(in) :: m
      !> The row, and the vector.
      real(wp), intent(in) :: a(m), x(m)
      !> The sum.
      real(wp), intent(inout) :: y
      integer :: k

      do k = 1, m - 3, 4
         y = y + ((abs(a(k))*x(k) + abs(a(k + 1))*x(k + 1)) &
            + (abs(a(k + 2))*x(k + 2) + abs(a(k + 3))*x(k + 3)))
      end do
      do k = m - mod(m, 4) + 1, m
         y = y + abs(a(k))*x(k)
      end do
   end subroutine bound_row

   !> Adds the products of rows of a list with x, v and w, in an order of sums of their own: only
   !! for bounds.
   pure subroutine add_rows(listed, list, before, n, m, a, x, v, w, y, rate, second)
      !> Number of rows of the list, and the rows.
      integer, intent(in) :: listed, list(listed)
      !> Number of rows before the first one of the matrix, and its numbers of rows and columns.
      integer, intent(in) :: before, n, m
      !> The transposed matrix; x, v and w (m).
      real(wp), intent(in) :: a(m, n), x(m), v(m), w(m)
      !> (listed) The sums; rows that are not in the matrix stay as they are.
      real(wp), dimension(listed), intent(inout) :: y, rate, second
      real(wp), dimension(0:group - 1) :: p, q, r
      integer :: i, j, k, l

      do j = 1, listed
         i = list(j) - before
         if (i < 1 .or. i > n) cycle
         p = 0
         q = 0
         r = 0
         do k = 1, m - group + 1, group
            do l = 0, group - 1
               p(l) = p(l) + a(k + l, i)*x(k + l)
               q(l) = q(l) + a(k + l, i)*v(k + l)
               r(l) = r(l) + a(k + l, i)*w(k + l)
            end do
         end do
         do k = m - mod(m, group) + 1, m
            p(0) = p(0) + a(k, i)*x(k)
            q(0) = q(0) + a(k, i)*v(k)
            r(0) = r(0) + a(k, i)*w(k)
         end do
         y(j) = y(j) + ((p(0) + p(1)) + (p(2) + p(3)))
         rate(j) = rate(j) + ((q(0) + q(1)) + (q(2) + q(3)))
         second(j) = second(j) + ((r(0) + r(1)) + (r(2) + r(3)))
      end do
   end subroutine add_rows

   !> Adds derivatives of pairs without constant terms: x' = v, v' = -stiffness x - drag v.
   pure subroutine add_derivatives(n, first, last, bare, stiffness, drag, of_x, of_v, x, v, total)
      !> Number of pairs, a multiple of `group`.
      integer, intent(in) :: n
      !> Orders of the derivatives that are added.
      integer, intent(in) :: first, last
      !> Whether all of drag and of of_v are 0.
      logical, intent(in) :: bare
      !> (n) omega^2 and 2 sigma; factors of x and of v in the sums.
      real(wp), intent(in) :: stiffness(n), drag(n), of_x(n), of_v(n)
      !> (n) In: derivatives of order first - 1. Out: of order last.
      real(wp), intent(inout) :: x(n), v(n)
      !> In and out: the sum over the pairs is added to each order.
      real(wp), intent(inout) :: total(0:last)
      real(wp), dimension(0:group - 1) :: part, second, third, fourth
      real(wp) :: a, b, before, c, fall
      integer :: begin, i, j, l

      begin = first
      if (bare) begin = last + 1 - mod(last + 1 - first, 4)
      ! four orders at a time: v, -stiffness x, and these times -stiffness
      do i = first, begin - 1, 4
         part = 0
         second = 0
         third = 0
         fourth = 0
         do j = 1, n, group
            do l = 0, group - 1
               fall = -stiffness(j + l)
               a = fall*x(j + l)
               b = v(j + l)
               c = fall*b
               part(l) = part(l) + of_x(j + l)*b
               second(l) = second(l) + of_x(j + l)*a
               third(l) = third(l) + of_x(j + l)*c
               a = fall*a
               fourth(l) = fourth(l) + of_x(j + l)*a
               x(j + l) = a
               v(j + l) = fall*c
            end do
         end do
         total(i) = total(i) + ((part(0) + part(1)) + (part(2) + part(3)))
         total(i + 1) = total(i + 1) + ((second(0) + second(1)) + (second(2) + second(3)))
         total(i + 2) = total(i + 2) + ((third(0) + third(1)) + (third(2) + third(3)))
         total(i + 3) = total(i + 3) + ((fourth(0) + fourth(1)) + (fourth(2) + fourth(3)))
      end do
      do i = begin, last
         part = 0
         do j = 1, n, group
            do l = 0, group - 1
               before = x(j + l)
               x(j + l) = v(j + l)
               v(j + l) = -stiffness(j + l)*before - drag(j + l)*v(j + l)
               part(l) = part(l) + (of_x(j + l)*x(j + l) + of_v(j + l)*v(j + l))
            end do
         end do
         total(i) = total(i) + ((part(0) + part(1)) + (part(2) + part(3)))
      end do
   end subroutine add_derivatives

   !> The rates of v of pairs.
   pure subroutine accelerate(n, stiffness, damping, force, x, v, w)
      !> Number of pairs.
      integer, intent(in) :: n
      !> (n) As in `bound_pairs`, and the pairs.
      real(wp), dimension(n), intent(in) :: stiffness, damping, force, x, v
      !> (n) The rates.
      real(wp), intent(out) :: w(n)
      integer :: k

      do k = 1, n
         w(k) = force(k) - stiffness(k)*x(k) - 2*damping(k)*v(k)
      end do
   end subroutine accelerate

   !> How long rows stay away from their limits, from their values and first two derivatives now
   !! and bounds on their second and third derivatives from now on.
   pure subroutine certify(n, y, rate, second, norm, upper, lower, root, more, margin, sag, &
      longest, share, h, span, slack, speed, doubt)
      !> Number of rows.
      integer, intent(in) :: n
      !> (n) Values and derivatives, and the limits.
      real(wp), dimension(n), intent(in) :: y, rate, second, norm, upper, lower
      !> The bounds on the second and third derivatives: norm (n) times root, and a further part.
      real(wp), intent(in) :: root(2), more(2)
      !> Distance from the limits that is not used, and what the fourth derivative adds to
      !! Bernstein coefficients of the cell.
      real(wp), intent(in) :: margin, sag
      !> How far the derivatives are followed, the share of the time found that is returned, and the
      !! length of the cell.
      real(wp), intent(in) :: longest, share, h
      !> (n) The time, not above 0 if there is none; the distance from the limits that is left then,
      !! and the largest rate up to then.
      real(wp), dimension(n), intent(out) :: span, slack, speed
      !> (n) 0 where no Bernstein coefficient of the cell reaches a limit, else 1.
      real(wp), intent(out) :: doubt(n)
      !> A row without a limit has a distance of this.
      !! The smallest sum of rates makes a time that is a number.
      real(wp), parameter :: far = 1.0e100_wp, small = 1.0e-200_wp
      real(wp) :: above, below, bend, fall, first, fourth, horizon, last, most, rise, third, time, &
         twist
      integer :: i, turn

      do i = 1, n
         bend = norm(i)*root(1) + more(1)
         twist = norm(i)*root(2) + more(2)
         above = min(upper(i) - y(i) - margin, far)
         below = min(y(i) - lower(i) - margin, far)
         ! the coefficients less y, with a remainder of at most 7/24 h^3 times the bound
         first = 0.25_wp*h*rate(i)
         third = 0.5_wp*h*rate(i) + h*h*second(i)/12
         fourth = 0.75_wp*h*rate(i) + 0.25_wp*h*h*second(i)
         last = h*rate(i) + 0.5_wp*h*h*second(i)
         most = 0.3_wp*h*h*h*twist + sag
         ! written so that a NaN is in doubt
         doubt(i) = merge(0.0_wp, 1.0_wp, above > most .and. below > most &
            .and. max(max(first, third), max(fourth, last)) + most < above &
            .and. max(max(-first, -third), max(-fourth, -last)) + most < below)
         ! a distance g is at least g - rate t - rise t^2/2 up to a horizon; a nearer one allows a
         ! smaller bound
         horizon = longest
         rise = 0
         fall = 0
         time = 0
         do turn = 1, 2
            rise = min(bend, max(second(i), 0.0_wp) + twist*horizon/3)
            fall = min(bend, max(-second(i), 0.0_wp) + twist*horizon/3)
            time = min(2*above/(rate(i) + sqrt(rate(i)*rate(i) + 2*rise*max(above, 0.0_wp)) &
               + small), 2*below/(sqrt(rate(i)*rate(i) + 2*fall*max(below, 0.0_wp)) - rate(i) &
               + small))
            time = merge(time, horizon, .not. time > horizon)
            if (turn == 1) horizon = min(horizon, 1.5_wp*max(time, 0.0_wp))
         end do
         time = max(share*time, -1.0_wp)             ! rows beyond a limit: no square overflows
         span(i) = time
         slack(i) = min(min(above, below), min(above - rate(i)*time - 0.5_wp*rise*time*time, &
            below + rate(i)*time - 0.5_wp*fall*time*time))
         speed(i) = abs(rate(i)) + min(bend, abs(second(i)) + 0.5_wp*twist*horizon)*max(time, &
            0.0_wp)
      end do
   end subroutine certify

   !> Which rows no certificate keeps away from their limits in a cell.
   pure subroutine list_uncovered(n, end, h, margin, due, slack, speed, marks, list, listed)
      !> Number of rows.
      integer, intent(in) :: n
      !> The end and the length of the cell, and a distance that has to be left.
      real(wp), intent(in) :: end, h, margin
      !> (n) The certificates.
      real(wp), dimension(n), intent(in) :: due, slack, speed
      !> (n) Room.
      real(wp), intent(out) :: marks(n)
      !> (n) The rows, and their number.
      integer, intent(out) :: list(n), listed
      integer :: i, j

      do i = 1, n
         ! written so that a NaN is not covered
         marks(i) = merge(0.0_wp, 1.0_wp, slack(i) > h*speed(i) + margin)
         marks(i) = merge(marks(i), 1.0_wp, end <= due(i))
      end do
      listed = 0
      do j = 1, n - group + 1, group
         if (.not. marks(j) + marks(j + 1) + (marks(j + 2) + marks(j + 3)) > 0) cycle
         do i = j, j + group - 1
            list(listed + 1) = i
            listed = listed + merge(1, 0, marks(i) > 0)
         end do
      end do
      do i = n - mod(n, group) + 1, n
         if (.not. marks(i) > 0) cycle
         listed = listed + 1
         list(listed) = i
      end do
   end subroutine list_uncovered

   !> Lowers certificates by what an impulse may change.
   pure subroutine lower_slack(n, time, impulse, margin, reach, due, slack, speed)
      !> Number of rows.
      integer, intent(in) :: n
      !> Length of the flight before the impulse, the impulse, and the rounding error of the pairs.
      real(wp), intent(in) :: time, impulse, margin
      !> (n) Bounds on the change of rates by an impulse of 1.
      real(wp), intent(in) :: reach(n)
      !> (n) In and out: the certificates.
      real(wp), dimension(n), intent(inout) :: due, slack, speed
      integer :: i

      do i = 1, n
         due(i) = due(i) - time
         slack(i) = slack(i) - impulse*reach(i)*max(due(i), 0.0_wp) - margin
         speed(i) = speed(i) + impulse*reach(i)/3
      end do
   end subroutine lower_slack

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

   !> `bound_pairs` (of_x) and `sum_bounds` of pairs without damping and constant terms, with the
   !! same bits.
   pure subroutine bound_free_pairs(n, stiffness, inverse, x0, v0, of_x, second, third, fourth)
      !> Number of pairs.
      integer, intent(in) :: n
      !> (n) omega^2, and 1/omega or 0; the pairs now.
      real(wp), dimension(n), intent(in) :: stiffness, inverse, x0, v0
      !> (n) The bounds on the fourth derivatives of x.
      real(wp), intent(out) :: of_x(n)
      !> The sums.
      real(wp), intent(out) :: second, third, fourth
      real(wp), dimension(0:group - 1) :: of_second, of_third, of_fourth
      integer :: k, l

      of_second = 0
      of_third = 0
      of_fourth = 0
      do k = 1, n - group + 1, group
         do l = 0, group - 1
            call add_bounds(stiffness(k + l), inverse(k + l), x0(k + l), v0(k + l), of_x(k + l), &
               of_second(l), of_third(l), of_fourth(l))
         end do
      end do
      third = (of_third(0) + of_third(1)) + (of_third(2) + of_third(3))
      second = (of_second(0) + of_second(1)) + (of_second(2) + of_second(3))
      fourth = (of_fourth(0) + of_fourth(1)) + (of_fourth(2) + of_fourth(3))
      do k = n - mod(n, group) + 1, n
         call add_bounds(stiffness(k), inverse(k), x0(k), v0(k), of_x(k), second, third, fourth)
      end do
   end subroutine bound_free_pairs

   !> Adds those of a pair.
   pure subroutine add_bounds(stiffness, inverse, x0, v0, of_x, second, third, fourth)
      !> As in `bound_free_pairs`.
      real(wp), intent(in) :: stiffness, inverse, x0, v0
      real(wp), intent(out) :: of_x
      !> In and out: the sums.
      real(wp), intent(inout) :: second, third, fourth
      real(wp) :: x2, x3, x4, v2, v4

      x2 = stiffness*x0
      x3 = stiffness*v0
      v2 = x3*inverse
      x4 = stiffness*x2
      v4 = stiffness*x3
      of_x = sqrt(v4*v4 + stiffness*x4*x4)*inverse
      second = second + (x2*x2 + v2*v2)
      third = third + (x3*x3 + stiffness*x2*x2)
      fourth = fourth + of_x*of_x
   end subroutine add_bounds

   !> `sizes_of_pairs` of pairs without damping and constant terms, with the same bits.
   pure subroutine sizes_of_free_pairs(n, bent, duration, stiffness, inverse, x, v, sum_x, sum_v)
      !> Number of pairs, and of those up to the last one that is no free mass.
      integer, intent(in) :: n, bent
      !> How long.
      real(wp), intent(in) :: duration
      !> (n) omega^2, and 1/omega or 0; the pairs at the beginning.
      real(wp), dimension(n), intent(in) :: stiffness, inverse, x, v
      !> The sums.
      real(wp), intent(out) :: sum_x, sum_v
      real(wp), dimension(0:group - 1) :: of_x, of_v
      integer :: k, l, whole

      of_x = 0
      of_v = 0
      whole = min(group*((bent + group - 1)/group), n - mod(n, group))
      do k = 1, whole, group
         do l = 0, group - 1
            call add_free_sizes(duration, stiffness(k + l), inverse(k + l), x(k + l), v(k + l), &
               of_x(l), of_v(l))
         end do
      end do
      do k = whole + 1, n - group + 1, group
         do l = 0, group - 1
            of_x(l) = of_x(l) + (abs(x(k + l)) + abs(v(k + l))*duration)**2
            of_v(l) = of_v(l) + v(k + l)**2
         end do
      end do
      do k = n - mod(n, group) + 1, n
         call add_free_sizes(duration, stiffness(k), inverse(k), x(k), v(k), of_x(0), of_v(0))
      end do
      sum_x = (of_x(0) + of_x(1)) + (of_x(2) + of_x(3))
      sum_v = (of_v(0) + of_v(1)) + (of_v(2) + of_v(3))
   end subroutine sizes_of_free_pairs

   !> Adds those of a pair.
   pure subroutine add_free_sizes(duration, stiffness, inverse, x, v, sum_x, sum_v)
      !> As in `sizes_of_free_pairs`.
      real(wp), intent(in) :: duration, stiffness, inverse, x, v
      !> In and out: the sums.
      real(wp), intent(inout) :: sum_x, sum_v
      real(wp) :: energy, f, of_x, p

      energy = v*v + stiffness*(x*x)
      p = abs(x) + abs(v)*duration
      f = abs(v) + stiffness*p*duration
      of_x = energy*(inverse*inverse)
      p = p*p
      f = f*f
      sum_x = sum_x + merge(of_x, p, stiffness > 0 .and. of_x < p)
      sum_v = sum_v + merge(energy, f, stiffness > 0 .and. energy < f)
   end subroutine add_free_sizes

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
      real(wp), dimension(0:group - 1) :: of_x, of_v
      integer :: k, l

      of_x = 0
      of_v = 0
      do k = 1, n - group + 1, group
         do l = 0, group - 1
            call add_sizes(duration, stiffness(k + l), damping(k + l), inverse(k + l), &
               drift(k + l), drift_rate(k + l), force(k + l), force_rate(k + l), x(k + l), &
               v(k + l), of_x(l), of_v(l))
         end do
      end do
      do k = n - mod(n, group) + 1, n
         call add_sizes(duration, stiffness(k), damping(k), inverse(k), drift(k), drift_rate(k), &
            force(k), force_rate(k), x(k), v(k), of_x(0), of_v(0))
      end do
      sum_x = (of_x(0) + of_x(1)) + (of_x(2) + of_x(3))
      sum_v = (of_v(0) + of_v(1)) + (of_v(2) + of_v(3))
   end subroutine sizes_of_pairs

   !> Adds those of a pair.
   pure subroutine add_sizes(duration, stiffness, damping, inverse, drift, drift_rate, force, &
      force_rate, x, v, sum_x, sum_v)
      !> As in `sizes_of_pairs`.
      real(wp), intent(in) :: duration, stiffness, damping, inverse, drift, drift_rate, force, &
         force_rate, x, v
      !> In and out: the sums.
      real(wp), intent(inout) :: sum_x, sum_v
      real(wp) :: f, p, of_x, of_v

      f = abs(force) + duration*abs(force_rate)
      p = abs(drift) + duration*abs(drift_rate)
      ! v^2 + omega^2 x^2 never grows, x without the part due to the constant terms
      of_x = abs(x) + (f + 2*damping*p)*inverse**2
      of_v = (abs(v) + p)**2 + stiffness*of_x**2
      ! within the time, |x| from v = 1 is at most the time, and from x = 1 at most 1; at
      ! frequency 0 that is all, and at a tiny frequency it is far less
      f = abs(v) + f*duration
      p = abs(x) + (f + p)*duration
      f = f + stiffness*p*duration
      of_x = of_v*inverse**2
      sum_x = sum_x + merge(of_x, p**2, stiffness > 0 .and. of_x < p**2)
      sum_v = sum_v + merge(of_v, f**2, stiffness > 0 .and. of_v < f**2)
   end subroutine add_sizes

   !> Sums over pairs of the squares of bounds on their second, third and fourth derivatives, from
   !! now on, where the constant terms do not grow.
   pure subroutine sum_bounds(n, stiffness, damping, inverse, drift, force, x0, v0, of_x, second, &
      third, fourth)
      !> Number of pairs.
      integer, intent(in) :: n
      !> (n) omega^2, sigma, 1/omega and the constant terms, as in `modes_type` of vi_modes.
      real(wp), dimension(n), intent(in) :: stiffness, damping, inverse, drift, force
      !> (n) The pairs now, and the bounds on the fourth derivatives of x.
      real(wp), intent(in) :: x0(n), v0(n), of_x(n)
      !> The sums.
      real(wp), intent(out) :: second, third, fourth
      real(wp), dimension(0:group - 1) :: of_second, of_third, of_fourth
      real(wp) :: x2, x3, v2
      integer :: j, k, l

      of_second = 0
      of_third = 0
      of_fourth = 0
      do k = 1, n - group + 1, group
         do l = 0, group - 1
            j = k + l
            x2 = -stiffness(j)*x0(j) - 2*damping(j)*v0(j) + force(j)
            x3 = -stiffness(j)*(v0(j) + drift(j)) - 2*damping(j)*x2
            v2 = x3*inverse(j)
            of_second(l) = of_second(l) + (x2*x2 + v2*v2)
            of_third(l) = of_third(l) + (x3*x3 + stiffness(j)*x2*x2)
            of_fourth(l) = of_fourth(l) + of_x(j)*of_x(j)
         end do
      end do
      third = (of_third(0) + of_third(1)) + (of_third(2) + of_third(3))
      second = (of_second(0) + of_second(1)) + (of_second(2) + of_second(3))
      fourth = (of_fourth(0) + of_fourth(1)) + (of_fourth(2) + of_fourth(3))
      do j = n - mod(n, group) + 1, n
         x2 = -stiffness(j)*x0(j) - 2*damping(j)*v0(j) + force(j)
         x3 = -stiffness(j)*(v0(j) + drift(j)) - 2*damping(j)*x2
         v2 = x3*inverse(j)
         second = second + (x2*x2 + v2*v2)
         third = third + (x3*x3 + stiffness(j)*x2*x2)
         fourth = fourth + of_x(j)*of_x(j)
      end do
   end subroutine sum_bounds

end module vi_lane_groups
