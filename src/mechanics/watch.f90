!> Rows of a structure that cannot come near a limit for some time, and need not be evaluated.
!!
!! A certificate of a group of rows is a time up to which they stay away from their limits by more
!! than a distance, and a bound on their rates. It follows from their values and rates and a bound
!! on their second derivatives. An impulse adds a motion of its own: certificates keep their times,
!! and their distances shrink by a bound on that motion. Rows far from the impulse hardly change,
!! as the first derivatives of that motion are 0.
module vi_watch
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   use vi_lane_groups, only: certify, group, sum_bounds
   use vi_lane_groups_wide, only: certify_wide => certify, sum_bounds_wide => sum_bounds
   use vi_lane_rows, only: mark_doubts
   use vi_lane_rows_wide, only: mark_doubts_wide => mark_doubts
   use vi_rows, only: add_ripple, bound_of_group, free_sums, group_values, rows_type
   use vi_series, only: order
   use vi_structure, only: regime_type
   implicit none (type, external)
   private

   public :: begin_watch, keep_watch, leave_group, list_doubts, look_at_groups, most_second, &
      rounding, set_at_limit

   !> How a flight begins: at a wall of a row (+1 upper, -1 lower) with a departure speed, or at no
   !! wall (row 0).
   type, public :: leaving_type
      integer :: row = 0, wall = 0
      real(wp) :: speed = 0
      !> The order of the first derivative of the distance to the limit that is not 0: 1 with a
      !! speed; `never` for a row that stays on its limit, which is not watched.
      integer :: order = 1
   end type leaving_type

   !> Certificates of groups of rows, kept from one flight to the next by `keep_watch`.
   type, public :: watch_type
      !> Whether a flight begins with an impact that `keep_watch` knows.
      logical :: kept = .false.
      !> (groups) Time since the beginning of the flight, below 0 for none; distance; a third of the
      !! largest rate.
      real(wp), allocatable, dimension(:) :: due, slack, speed
      !> A bound on the second derivatives of rows, as a factor of their norms, and the part of all
      !! rows that is due to the load.
      real(wp) :: second = 0, ripple_second = 0
      !> Bounds on the fourth derivatives and on the rounding errors of the rows.
      real(wp) :: most_fourth = 0, reserve = 0
      !> Roots of sums of squares of bounds on the pairs.
      real(wp) :: root_x = 0, root_v = 0
      !> How often a row was looked at.
      integer(int64) :: looks = 0
      !> (groups, 2) Whether the values of the rows at the beginning and at the end of a cell, in
      !! turns, are known; (groups) the bounds on their fourth derivatives and on
      !! their rounding errors.
      logical, allocatable :: valued(:, :), bounded(:), weighed(:)
   end type watch_type

   !> The order of a function of which no derivative differs from 0.
   integer, parameter, public :: never = order + 1
   !> Rounding errors of rows as a share of the sizes of their terms.
   real(wp), parameter, public :: rounding_share = 16*epsilon(1.0_wp)
   !> The longest certificate, as a multiple of the shortest time scale; the share of the time found
   !! for which a certificate is given, so that it outlasts some impulses.
   real(wp), parameter :: longest = 1, share = 0.7_wp
   !> Derivatives of the motion after an impulse that are summed.
   integer, parameter :: terms = 6

contains

   !> Begins a flight.
   pure subroutine begin_watch(regime, x0, v0, of_x, watch)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs, and bounds on their fourth derivatives.
      real(wp), contiguous, intent(in) :: x0(:), v0(:), of_x(:)
      !> In and out: the certificates.
      type(watch_type), intent(inout) :: watch
      real(wp) :: second, fourth
      integer :: h
      logical :: fits

      associate (groups => regime%rows%groups, modes => regime%modes, rows => regime%rows)
         fits = allocated(watch%due)
         if (fits) fits = size(watch%due) == groups
         if (.not. fits) then
            if (allocated(watch%due)) deallocate (watch%due, watch%slack, watch%speed, &
               watch%valued, watch%bounded, watch%weighed)
            allocate (watch%due(groups), watch%slack(groups), watch%speed(groups), &
               watch%valued(groups, 2), watch%bounded(groups), watch%weighed(groups))
         end if
         if (.not. (fits .and. watch%kept)) watch%due = -1
         watch%kept = .false.
         watch%bounded = .false.
         if (modes%wide) then
            call sum_bounds_wide(modes%bent, modes%stiffness, modes%damping, modes%inverse, &
               modes%drift, modes%force, x0, v0, of_x, second, fourth)
         else
            call sum_bounds(modes%bent, modes%stiffness, modes%damping, modes%inverse, &
               modes%drift, modes%force, x0, v0, of_x, second, fourth)
         end if
         ! by the inequality of Cauchy and Schwarz
         watch%second = sqrt(second)
         watch%ripple_second = 0
         watch%most_fourth = rows%most_norm*sqrt(fourth)
         do h = 1, size(regime%ripple, 2)
            watch%ripple_second = watch%ripple_second + rows%most_ripple(h)*(h*regime%frequency)**2
            watch%most_fourth = watch%most_fourth + rows%most_ripple(h)*(h*regime%frequency)**4
         end do
      end associate
   end subroutine begin_watch

   !> Whether the certificate of a group shows that none of its rows comes near a limit in a cell.
   !!
   !! The Bernstein coefficients of the cell differ from a value of the row within it by at most a
   !! third of its largest rate times the length, and by a share of the fourth derivative.
   pure logical function covers(watch, g, t, h)
      !> The certificates, and the number of the group.
      type(watch_type), intent(in) :: watch
      integer, intent(in) :: g
      !> The beginning and the length of the cell.
      real(wp), intent(in) :: t, h

      covers = t + h <= watch%due(g) .and. watch%slack(g) > h*watch%speed(g) &
         + (h*h)**2/144*watch%most_fourth + 2*watch%reserve
   end function covers

   !> Ends the certificate of the group of a row that leaves a limit.
   pure subroutine leave_group(row, watch)
      !> The row, 0 for none.
      integer, intent(in) :: row
      !> In and out: the certificates.
      type(watch_type), intent(inout) :: watch

      if (row > 0) watch%due((row - 1)/group + 1) = -1
   end subroutine leave_group

   !> Certifies a group of rows from a time on, if they are not near a limit.
   pure subroutine certify_group(regime, g, t, h, n, y, rate, watch, clear)
      !> The regime, and the number of the group.
      type(regime_type), intent(in) :: regime
      integer, intent(in) :: g
      !> The time after the beginning of the flight, and the length of a cell that begins then.
      real(wp), intent(in) :: t, h
      !> Number of rows of the group, and their values and rates then.
      integer, intent(in) :: n
      real(wp), intent(in) :: y(n), rate(n)
      !> In and out: the certificates.
      type(watch_type), intent(inout) :: watch
      !> Whether no row comes near a limit in the cell.
      logical, intent(out) :: clear
      real(wp) :: left, span

      associate (first => (g - 1)*group + 1)
         if (regime%modes%wide) then
            call certify_wide(n, y, rate, regime%rows%position_norm(first), watch%second, &
               watch%ripple_second, 2*watch%reserve, regime%upper(first), regime%lower(first), &
               longest*regime%unit, share, h, span, watch%slack(g), watch%speed(g), left)
         else
            call certify(n, y, rate, regime%rows%position_norm(first), watch%second, &
               watch%ripple_second, 2*watch%reserve, regime%upper(first), regime%lower(first), &
               longest*regime%unit, share, h, span, watch%slack(g), watch%speed(g), left)
         end if
      end associate
      watch%due(g) = t + span
      watch%speed(g) = watch%speed(g)/3
      clear = left > (h*h)**2/144*watch%most_fourth + 2*watch%reserve
   end subroutine certify_group

   !> Looks at the groups of rows that no certificate covers, for rows that may reach a limit.
   pure subroutine look_at_groups(regime, m, rows, harmonics, starts, leaving, t, h, now, pairs, &
      turns, values, watch, doubtful, n)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> Number of pairs, of rows, and of harmonics of the load.
      integer, intent(in) :: m, rows, harmonics
      !> The rows that leave a limit, and their number.
      integer, intent(in) :: starts
      type(leaving_type), intent(in) :: leaving(starts)
      !> Beginning and length of the cell.
      real(wp), intent(in) :: t, h
      !> The columns of the beginning of the cell.
      integer, intent(in) :: now
      !> As in `search_cells` of vi_channels.
      real(wp), intent(in) :: pairs(m, 6)
      complex(wp), intent(in) :: turns(harmonics, 2)
      real(wp), intent(inout) :: values(rows, 8)
      type(watch_type), intent(inout) :: watch
      !> In and out: the rows, and which limits they may reach: 1 the upper one, 2 the lower one, 3
      !! both. Their number.
      integer, intent(inout) :: doubtful(2, rows), n
      integer :: before, g, here, next
      logical :: clear

      next = 3 - now
      do g = 1, regime%rows%groups
         watch%valued(g, next) = .false.
         if (covers(watch, g, t, h)) cycle
         before = (g - 1)*group
         here = min(group, rows - before)
         associate (i => before + 1)
            if (.not. watch%valued(g, now)) then
               call group_values(regime%rows, regime%frequency, g, here, pairs(:, 2*now - 1), &
                  pairs(:, 2*now), turns(:, now), values(i, 2*now - 1), values(i, 2*now))
               if (t <= 0) call set_at_limit(starts, leaving, regime, i, before + here, &
                  values(i, 2*now - 1), values(i, 2*now))
               watch%valued(g, now) = .true.
            end if
            call certify_group(regime, g, t, h, here, values(i, 2*now - 1), values(i, 2*now), &
               watch, clear)
            if (clear) cycle
            if (.not. watch%bounded(g)) then
               call bound_of_group(regime%rows, g, here, pairs(:, 5), values(i, 5))
               call add_ripple(regime%rows, regime%frequency, before, here, values(i, 5))
               watch%bounded(g) = .true.
            end if
            if (.not. watch%weighed(g)) call rounding(regime%rows, i, before + here, &
               watch%root_x, watch%root_v, values(:, 6))
            watch%weighed(g) = .true.
            call group_values(regime%rows, regime%frequency, g, here, pairs(:, 2*next - 1), &
               pairs(:, 2*next), turns(:, next), values(i, 2*next - 1), values(i, 2*next))
            watch%valued(g, next) = .true.
            watch%looks = watch%looks + here
            if (regime%rows%wide) then
               call mark_doubts_wide(here, h, values(i, 2*now - 1), values(i, 2*now), &
                  values(i, 2*next - 1), values(i, 2*next), values(i, 5), values(i, 6), &
                  regime%upper(i), regime%lower(i), values(i, 7), values(i, 8))
            else
               call mark_doubts(here, h, values(i, 2*now - 1), values(i, 2*now), &
                  values(i, 2*next - 1), values(i, 2*next), values(i, 5), values(i, 6), &
                  regime%upper(i), regime%lower(i), values(i, 7), values(i, 8))
            end if
         end associate
         call list_doubts(regime, rows, before, here, starts, leaving, t, h, now, values, &
            doubtful, n)
      end do
   end subroutine look_at_groups

   !> Lists the rows of a range that are marked: not proved to stay within their limits over a cell.
   pure subroutine list_doubts(regime, rows, before, here, starts, leaving, t, h, now, values, &
      doubtful, n)
      !> The regime, its number of rows, and in the range the number of rows before it and in it.
      type(regime_type), intent(in) :: regime
      integer, intent(in) :: rows, before, here
      !> How the flight begins: rows that leave a limit, and their number.
      integer, intent(in) :: starts
      type(leaving_type), intent(in) :: leaving(starts)
      !> Beginning and length of the cell, and the columns of its beginning.
      real(wp), intent(in) :: t, h
      integer, intent(in) :: now
      !> As in `search_cells` of vi_channels, with the marks.
      real(wp), intent(inout) :: values(rows, 8)
      !> As in `look_at_groups`.
      integer, intent(inout) :: doubtful(2, rows), n
      real(wp) :: limit, next(4)
      integer :: i, j, side

      associate (y => values(:, 2*now - 1), rate => values(:, 2*now), &
         y_next => values(:, 5 - 2*now), rate_next => values(:, 6 - 2*now), &
         bound => values(:, 5), reserve => values(:, 6), &
         above => values(:, 7), below => values(:, 8))
         do j = 1, starts
            i = leaving(j)%row
            if (i <= before .or. i > before + here) cycle
            if (leaving(j)%order >= never) then
               above(i) = 0
               below(i) = 0
            else if (t <= 0) then
               ! where a row starts on its limit and leaves it, the first coefficient does not count
               side = leaving(j)%wall
               limit = merge(regime%upper(i), -regime%lower(i), side > 0) - reserve(i)
               next = [side*(y(i) + 0.25_wp*h*rate(i)), side*(0.5_wp*(y(i) + y_next(i)) &
                  + h/6*(rate(i) - rate_next(i))) + (h*h)**2/144*bound(i), &
                  side*(y_next(i) - 0.25_wp*h*rate_next(i)), side*y_next(i)]
               if (side > 0) above(i) = merge(0.0_wp, 1.0_wp, all(next < limit))
               if (side < 0) below(i) = merge(0.0_wp, 1.0_wp, all(next < limit))
            end if
         end do
         do i = before + 1, before + here
            if (above(i) + below(i) <= 0) cycle
            n = n + 1
            doubtful(:, n) = [i, merge(1, 0, above(i) > 0) + merge(2, 0, below(i) > 0)]
         end do
      end associate
   end subroutine list_doubts

   !> Sets the rows of a range that leave a limit at the start.
   pure subroutine set_at_limit(starts, leaving, regime, first, last, y, rate)
      !> The rows that leave a limit, and their number.
      integer, intent(in) :: starts
      type(leaving_type), intent(in) :: leaving(starts)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> The range.
      integer, intent(in) :: first, last
      !> (first to last) In and out: values and rates.
      real(wp), intent(inout) :: y(first:last), rate(first:last)
      integer :: j

      do j = 1, starts
         associate (row => leaving(j)%row, wall => leaving(j)%wall)
            if (row < first .or. row > last) cycle
            y(row) = merge(regime%upper(row), regime%lower(row), wall > 0)
            rate(row) = -wall*leaving(j)%speed
         end associate
      end do
   end subroutine set_at_limit

   !> Bounds on the rounding errors of a range of rows.
   pure subroutine rounding(rows, first, last, root_x, root_v, reserve)
      !> The rows, and the range.
      type(rows_type), intent(in) :: rows
      integer, intent(in) :: first, last
      !> As of `find_roots`.
      real(wp), intent(in) :: root_x, root_v
      !> (rows) In and out: the bounds of the range.
      real(wp), intent(inout) :: reserve(size(rows%offset))
      integer :: i

      ! by the inequality of Cauchy and Schwarz
      do i = first, last
         reserve(i) = rounding_share*(rows%constant_size(i) &
            + rows%position_norm(i)*root_x + rows%velocity_norm(i)*root_v)
      end do
   end subroutine rounding

   !> Keeps the certificates through a flight and an impact at its end.
   pure subroutine keep_watch(regime, gap, channel, impulse, time, watch)
      !> In and out: the regime.
      type(regime_type), intent(inout) :: regime
      !> The gap, its channel, the impulse, and the length of the flight.
      integer, intent(in) :: gap, channel
      real(wp), intent(in) :: impulse, time
      !> In and out: the certificates.
      type(watch_type), intent(inout) :: watch
      integer :: g

      if (regime%rows%groups == 0) return
      watch%kept = .true.
      if (.not. allocated(regime%reach)) then
         allocate (regime%reach(regime%rows%groups, size(regime%upper)), source=-1.0_wp)
         allocate (regime%bend(size(regime%upper)), source=0.0_wp)
      end if
      if (regime%reach(1, channel) < 0) then
         call find_reach(regime, gap, regime%reach(:, channel))
         regime%bend(channel) = sqrt(sum((regime%modes%stiffness*regime%kick_x(:, gap) &
            + 2*regime%modes%damping*regime%kick_v(:, gap))**2))
      end if
      watch%second = watch%second + impulse*regime%bend(channel)
      do g = 1, size(watch%due)
         watch%due(g) = watch%due(g) - time
         ! the pairs are also rounded
         watch%slack(g) = watch%slack(g) - impulse*regime%reach(g, channel) &
            *max(watch%due(g), 0.0_wp) - 2*watch%reserve
         watch%speed(g) = watch%speed(g) + impulse*regime%reach(g, channel)/3
      end do
   end subroutine keep_watch

   !> A bound on the absolute second derivative of a row just after an impact that `keep_watch`
   !! knows, and from then on.
   pure real(wp) function most_second(watch, rows, row)
      !> The certificates.
      type(watch_type), intent(in) :: watch
      !> The rows, and the number of the row.
      type(rows_type), intent(in) :: rows
      integer, intent(in) :: row

      most_second = (rows%position_norm(row)*watch%second + watch%ripple_second)*(1 + 1.0e-9_wp)
   end function most_second

   !> Bounds on the rates of the rows of each group after an impulse of 1 on a gap, for the time of
   !! the longest certificate: the Taylor series of each rate, term by term, and its remainder.
   pure subroutine find_reach(regime, gap, reach)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> The gap.
      integer, intent(in) :: gap
      !> (groups) The bounds.
      real(wp), intent(out) :: reach(:)
      real(wp), dimension(size(regime%kick_x, 1)) :: before, x, v
      real(wp), dimension(size(regime%upper)) :: d, total
      real(wp) :: factor
      integer :: g, i

      x = regime%kick_x(:, gap)
      v = regime%kick_v(:, gap)
      total = 0
      factor = 1
      do i = 1, terms
         if (any(abs(v) > 0)) then
            call free_sums(regime%rows, v, d)
            total = total + factor*abs(d)
         end if
         before = x
         x = v
         v = -regime%modes%stiffness*before - 2*regime%modes%damping*v
         factor = factor*(longest*regime%unit)/i
      end do
      ! v^2 + omega^2 x^2 never grows
      total = (total + factor*regime%rows%position_norm*sqrt(sum(v**2 &
         + regime%modes%stiffness*x**2)))*(1 + 1.0e-9_wp)
      do g = 1, size(reach)
         reach(g) = maxval(total((g - 1)*group + 1:min(g*group, size(total))))
      end do
   end subroutine find_reach

end module vi_watch
