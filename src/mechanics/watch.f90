!> Rows of a structure that cannot come near a limit for some time, and need not be evaluated.
!!
!! A certificate of a row is a time up to which it stays away from its limits by more than a
!! distance, and a bound on its rate. It follows from its value and its first two derivatives and
!! bounds on the second and third. An impulse adds a motion of its own: certificates keep their
!! times, and their distances shrink by a bound on that motion. Rows far from the impulse hardly
!! change, as the first derivatives of that motion are 0.
!!
!! A row without a certificate is evaluated in an order of sums that is fast for a single row.
!! Where this does not prove that it stays within its limits for a cell, it is evaluated as if all
!! rows were, with the same bits.
module vi_watch
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   use vi_lane_groups, only: accelerate, bound_free_pairs, certify, group, list_uncovered, &
      lower_slack, stack, sum_bounds
   use vi_lane_groups_wide, only: accelerate_wide => accelerate, &
      bound_free_pairs_wide => bound_free_pairs, certify_wide => certify, &
      list_uncovered_wide => list_uncovered, lower_slack_wide => lower_slack, &
      stack_wide => stack, sum_bounds_wide => sum_bounds
   use vi_lane_rows, only: mark_doubts
   use vi_rows, only: add_ripple, bound_of_row, free_sums, rough_values, rows_type, values_of_row
   use vi_series, only: order
   use vi_structure, only: regime_type
   implicit none (type, external)
   private

   public :: begin_watch, keep_watch, leave_row, list_doubts, look_at_rows, most_second, rounding, &
      set_at_limit

   !> How a flight begins: at a wall of a row (+1 upper, -1 lower) with a departure speed, or at no
   !! wall (row 0).
   type, public :: leaving_type
      integer :: row = 0, wall = 0
      real(wp) :: speed = 0
      !> The order of the first derivative of the distance to the limit that is not 0: 1 with a
      !! speed; `never` for a row that stays on its limit, which is not watched.
      integer :: order = 1
   end type leaving_type

   !> Certificates of rows, kept from one flight to the next by `keep_watch`.
   type, public :: watch_type
      !> Whether a flight begins with an impact that `keep_watch` knows.
      logical :: kept = .false.
      !> (rows) Time since the beginning of the flight, below 0 for none; distance; a third of the
      !! largest rate.
      real(wp), allocatable, dimension(:) :: due, slack, speed
      !> Bounds on the second and third derivatives of rows, as factors of their norms, and the
      !! parts of all rows that are due to the load.
      real(wp) :: curving(2) = 0, of_ripple(2) = 0
      !> Bounds on the fourth derivatives and on the rounding errors of the rows.
      real(wp) :: most_fourth = 0, reserve = 0
      !> Roots of sums of squares of bounds on the pairs.
      real(wp) :: root_x = 0, root_v = 0
      !> How often a row was evaluated for a cell, roughly or as if all rows were.
      integer(int64) :: looks = 0
      !> (rows) Whether the bound on the fourth derivative is known.
      logical, allocatable :: bounded(:)
      !> (rows) The rows without a certificate; (rows, 10) room for these; (m) the rates of v;
      !! (group, m) the pairs of blocks at the beginning and at the end of a cell.
      integer, allocatable :: list(:)
      real(wp), allocatable :: room(:, :), rates(:), stacked(:, :)
   end type watch_type

   !> The order of a function of which no derivative differs from 0.
   integer, parameter, public :: never = order + 1
   !> Rounding errors of rows as a share of the sizes of their terms.
   real(wp), parameter, public :: rounding_share = 16*epsilon(1.0_wp)
   !> The longest certificate, as a multiple of the shortest time scale; the share of the time found
   !! for which a certificate is given, so that it outlasts some impulses.
   real(wp), parameter :: longest = 1, share = 0.8_wp
   !> Derivatives of the motion after an impulse that are summed.
   integer, parameter :: terms = 6

contains

   !> Begins a flight.
   pure subroutine begin_watch(regime, x0, v0, of_x, watch)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs.
      real(wp), contiguous, intent(in) :: x0(:), v0(:)
      !> (m) In and out: bounds on their fourth derivatives, computed here if no pair is damped or
      !! has constant terms.
      real(wp), contiguous, intent(inout) :: of_x(:)
      !> In and out: the certificates.
      type(watch_type), intent(inout) :: watch
      real(wp) :: second, third, fourth
      integer :: h
      logical :: fits

      associate (n => size(regime%upper), modes => regime%modes, rows => regime%rows)
         fits = allocated(watch%due)
         if (fits) fits = size(watch%due) == n .and. size(watch%rates) == size(x0)
         if (.not. fits) then
            if (allocated(watch%due)) deallocate (watch%due, watch%slack, watch%speed, &
               watch%bounded, watch%list, watch%room, watch%rates, watch%stacked)
            allocate (watch%due(n), watch%slack(n), watch%speed(n), watch%bounded(n), &
               watch%list(n), watch%room(n, 10), watch%rates(size(x0)), &
               watch%stacked(group, size(x0)))
         end if
         if (.not. (fits .and. watch%kept)) watch%due = -1
         watch%kept = .false.
         watch%bounded = .false.
         watch%rates(modes%bent + 1:) = 0
         if (modes%conserves) of_x(modes%bent + 1:) = 0
         if (modes%conserves .and. modes%wide) then
            call bound_free_pairs_wide(modes%bent, modes%stiffness, modes%inverse, x0, v0, of_x, &
               second, third, fourth)
         else if (modes%conserves) then
            call bound_free_pairs(modes%bent, modes%stiffness, modes%inverse, x0, v0, of_x, &
               second, third, fourth)
         else if (modes%wide) then
            call sum_bounds_wide(modes%bent, modes%stiffness, modes%damping, modes%inverse, &
               modes%drift, modes%force, x0, v0, of_x, second, third, fourth)
         else
            call sum_bounds(modes%bent, modes%stiffness, modes%damping, modes%inverse, &
               modes%drift, modes%force, x0, v0, of_x, second, third, fourth)
         end if
         ! by the inequality of Cauchy and Schwarz
         watch%curving = sqrt([second, third])
         watch%of_ripple = 0
         watch%most_fourth = rows%most_bent_norm*sqrt(fourth)*(1 + 1.0e-9_wp)
         do h = 1, size(regime%ripple, 2)
            watch%of_ripple = watch%of_ripple + rows%most_ripple(h)*(h*regime%frequency)**[2, 3]
            watch%most_fourth = watch%most_fourth + rows%most_ripple(h)*(h*regime%frequency)**4
         end do
      end associate
   end subroutine begin_watch

   !> Ends the certificate of a row that leaves a limit.
   pure subroutine leave_row(row, watch)
      !> The row, 0 for none.
      integer, intent(in) :: row
      !> In and out: the certificates.
      type(watch_type), intent(inout) :: watch

      if (row > 0) watch%due(row) = -1
   end subroutine leave_row

   !> Looks at the rows that no certificate covers, for those that may reach a limit.
   !!
   !! The Bernstein coefficients of a cell differ from a value of the row within it by at most a
   !! third of its largest rate times the length, and by a share of the fourth derivative.
   pure subroutine look_at_rows(regime, m, rows, harmonics, starts, leaving, t, h, now, pairs, &
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
      real(wp) :: margin, sag
      integer :: j, listed
      logical :: stacked

      sag = (h*h)**2/144*watch%most_fourth
      margin = sag + 2*watch%reserve
      if (regime%modes%wide) then
         call list_uncovered_wide(rows, t + h, h, margin, watch%due, watch%slack, watch%speed, &
            watch%room(:, 1), watch%list, listed)
      else
         call list_uncovered(rows, t + h, h, margin, watch%due, watch%slack, watch%speed, &
            watch%room(:, 1), watch%list, listed)
      end if
      if (listed == 0) return
      call certify_listed(regime, m, harmonics, starts, leaving, listed, t, h, sag, &
         pairs(:, 2*now - 1), pairs(:, 2*now), turns(:, now), watch)
      stacked = .false.
      do j = 1, listed
         if (.not. watch%room(j, 10) > 0) cycle
         if (.not. stacked .and. regime%modes%wide) then
            call stack_wide(regime%rows%dense, pairs(:, 2*now - 1), pairs(:, 2*now), &
               pairs(:, 5 - 2*now), pairs(:, 6 - 2*now), watch%stacked)
         else if (.not. stacked) then
            call stack(regime%rows%dense, pairs(:, 2*now - 1), pairs(:, 2*now), &
               pairs(:, 5 - 2*now), pairs(:, 6 - 2*now), watch%stacked)
         end if
         stacked = .true.
         call look_at_row(regime, m, rows, harmonics, starts, leaving, t, h, now, watch%list(j), &
            pairs, turns, values, watch, doubtful, n)
      end do
   end subroutine look_at_rows

   !> Certifies the rows of the list from a time on, if they are not near a limit.
   pure subroutine certify_listed(regime, m, harmonics, starts, leaving, listed, t, h, sag, x, v, &
      turn, watch)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> Number of pairs, of harmonics of the load, of rows that leave a limit, and of rows of the
      !! list; how the former begin.
      integer, intent(in) :: m, harmonics, starts, listed
      type(leaving_type), intent(in) :: leaving(starts)
      !> The time after the beginning of the flight, the length of a cell that begins then, and what
      !! the fourth derivative adds to its Bernstein coefficients.
      real(wp), intent(in) :: t, h, sag
      !> The pairs then, and e^(i h Omega t).
      real(wp), intent(in) :: x(m), v(m)
      complex(wp), intent(in) :: turn(harmonics)
      !> In and out: the certificates; its room has in column 10 above 0 the rows that may come near
      !! a limit in the cell.
      type(watch_type), intent(inout) :: watch
      real(wp) :: margin
      integer :: j

      associate (modes => regime%modes, unit => regime%unit, room => watch%room)
         ! also for the rounding errors of the derivatives
         margin = 3*watch%reserve + 2*rounding_share*regime%rows%most_norm*(watch%root_x &
            + unit*watch%root_v)*max(1.0_wp, (h/unit)**2)
         if (modes%wide) then
            call accelerate_wide(modes%bent, modes%stiffness, modes%damping, modes%force, x, v, &
               watch%rates)
         else
            call accelerate(modes%bent, modes%stiffness, modes%damping, modes%force, x, v, &
               watch%rates)
         end if
         call rough_values(regime%rows, regime%frequency, listed, watch%list, x, v, watch%rates, &
            turn, room(:, 1), room(:, 2), room(:, 3))
         call pick(listed, watch%list, size(regime%upper), regime%rows%bent_norm, room(:, 4))
         call pick(listed, watch%list, size(regime%upper), regime%upper, room(:, 5))
         call pick(listed, watch%list, size(regime%upper), regime%lower, room(:, 6))
         watch%looks = watch%looks + listed
         if (modes%wide) then
            call certify_wide(listed, room(:, 1), room(:, 2), room(:, 3), room(:, 4), room(:, 5), &
               room(:, 6), watch%curving, watch%of_ripple, margin, sag, longest*unit/share, share, &
               h, room(:, 7), room(:, 8), room(:, 9), room(:, 10))
         else
            call certify(listed, room(:, 1), room(:, 2), room(:, 3), room(:, 4), room(:, 5), &
               room(:, 6), watch%curving, watch%of_ripple, margin, sag, longest*unit/share, share, &
               h, room(:, 7), room(:, 8), room(:, 9), room(:, 10))
         end if
         call keep_certificates(listed, watch%list, size(watch%due), t, room(:, 7), room(:, 8), &
            room(:, 9), watch%due, watch%slack, watch%speed)
         if (starts /= 1 .or. t > 0) return
         j = findloc(watch%list(:listed), leaving(1)%row, 1)
         if (j == 0 .or. leaving(1)%order /= 1) return
         if (departs(leaving(1), room(j, 5), room(j, 6), room(j, 1), room(j, 2), room(j, 3), &
            room(j, 4)*watch%curving(2) + watch%of_ripple(2), margin, sag, h)) room(j, 10) = 0
      end associate
   end subroutine certify_listed

   !> Whether no Bernstein coefficient of the first cell, but the first one, reaches a limit for a
   !! row that leaves one with a speed: `list_doubts` then finds the same.
   pure logical function departs(leaving, upper, lower, y, rate, second, third, margin, sag, h)
      !> How the row begins, and its limits.
      type(leaving_type), intent(in) :: leaving
      real(wp), intent(in) :: upper, lower
      !> Its value and first two derivatives, and a bound on the third one.
      real(wp), intent(in) :: y, rate, second, third
      !> As in `certify` of vi_lane_groups.
      real(wp), intent(in) :: margin, sag, h
      real(wp) :: bend, fast, high, low, most, slow, width

      ! distances from the limit; it has been reached up to rounding
      associate (limit => merge(upper, lower, leaving%wall > 0))
         low = min(0.0_wp, leaving%wall*(limit - y))
         high = max(0.0_wp, leaving%wall*(limit - y))
      end associate
      slow = h*min(leaving%speed, -leaving%wall*rate)
      fast = h*max(leaving%speed, -leaving%wall*rate)
      bend = -leaving%wall*h*h*second
      width = upper - lower - margin
      most = 0.3_wp*h*h*h*third + sag
      departs = 0.25_wp*slow > margin &
         .and. low + min(0.5_wp*slow + bend/12, 0.75_wp*slow + 0.25_wp*bend, slow &
         + 0.5_wp*bend) > most + margin &
         .and. high + max(0.25_wp*fast, 0.5_wp*fast + bend/12, 0.75_wp*fast + 0.25_wp*bend, fast &
         + 0.5_wp*bend) + most < width
   end function departs

   !> Picks the numbers of some rows.
   pure subroutine pick(n, list, rows, all, some)
      !> Number of rows that are wanted, and which; number of all rows.
      integer, intent(in) :: n, list(n), rows
      !> The numbers of all rows, and of those that are wanted.
      real(wp), intent(in) :: all(rows)
      real(wp), intent(out) :: some(n)
      integer :: j

      do j = 1, n
         some(j) = all(list(j))
      end do
   end subroutine pick

   !> Keeps the certificates of some rows.
   pure subroutine keep_certificates(n, list, rows, t, span, left, most, due, slack, speed)
      !> Number of rows that have them, and which; number of all rows.
      integer, intent(in) :: n, list(n), rows
      !> The time from which on they hold.
      real(wp), intent(in) :: t
      !> (n) How long, the distance that is left, and the largest rate.
      real(wp), dimension(n), intent(in) :: span, left, most
      !> (rows) In and out: the certificates.
      real(wp), dimension(rows), intent(inout) :: due, slack, speed
      integer :: j

      do j = 1, n
         due(list(j)) = t + span(j)
         slack(list(j)) = left(j)
         speed(list(j)) = most(j)/3
      end do
   end subroutine keep_certificates

   !> Looks at a row, as if all rows were looked at.
   pure subroutine look_at_row(regime, m, rows, harmonics, starts, leaving, t, h, now, i, pairs, &
      turns, values, watch, doubtful, n)
      !> As in `look_at_rows`.
      type(regime_type), intent(in) :: regime
      integer, intent(in) :: m, rows, harmonics, starts
      type(leaving_type), intent(in) :: leaving(starts)
      real(wp), intent(in) :: t, h
      integer, intent(in) :: now
      !> The number of the row.
      integer, intent(in) :: i
      !> As in `look_at_rows`.
      real(wp), intent(in) :: pairs(m, 6)
      complex(wp), intent(in) :: turns(harmonics, 2)
      real(wp), intent(inout) :: values(rows, 8)
      type(watch_type), intent(inout) :: watch
      integer, intent(inout) :: doubtful(2, rows), n
      real(wp) :: sums(group)
      integer :: before

      call values_of_row(regime%rows, regime%frequency, i, watch%stacked, pairs(:, 2*now - 1), &
         pairs(:, 2*now), pairs(:, 5 - 2*now), pairs(:, 6 - 2*now), turns(:, now), &
         turns(:, 3 - now), sums)
      values(i, 2*now - 1) = sums(1)
      values(i, 2*now) = sums(2)
      values(i, 5 - 2*now) = sums(3)
      values(i, 6 - 2*now) = sums(4)
      if (t <= 0) call set_at_limit(starts, leaving, regime, i, i, values(i:i, 2*now - 1), &
         values(i:i, 2*now))
      call rounding(regime%rows, i, i, watch%root_x, watch%root_v, values(:, 6))
      watch%looks = watch%looks + 1
      ! what is no doubt with a larger bound is none
      if (.not. watch%bounded(i)) values(i, 5) = watch%most_fourth
      before = n
      do
         call mark_doubts(1, h, values(i, 2*now - 1), values(i, 2*now), values(i, 5 - 2*now), &
            values(i, 6 - 2*now), values(i, 5), values(i, 6), regime%upper(i), regime%lower(i), &
            values(i, 7), values(i, 8))
         if (.not. values(i, 7) + values(i, 8) > 0) return
         call list_doubts(regime, rows, i - 1, 1, starts, leaving, t, h, now, values, doubtful, n)
         if (n == before .or. watch%bounded(i)) exit
         values(i, 5) = bound_of_row(regime%rows, i, pairs(:, 5))
         call add_ripple(regime%rows, regime%frequency, i - 1, 1, values(i:i, 5))
         watch%bounded(i) = .true.
         n = before
      end do
   end subroutine look_at_row

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
      !> As in `look_at_rows`.
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

      if (.not. regime%rows%alone) return
      watch%kept = .true.
      if (.not. allocated(regime%reach)) then
         allocate (regime%reach(size(regime%upper), size(regime%upper)), source=-1.0_wp)
         allocate (regime%bend(size(regime%upper)), source=0.0_wp)
      end if
      if (regime%reach(1, channel) < 0) then
         call find_reach(regime, gap, regime%reach(:, channel))
         regime%bend(channel) = sqrt(sum((regime%modes%stiffness*regime%kick_x(:, gap) &
            + 2*regime%modes%damping*regime%kick_v(:, gap))**2))
      end if
      watch%curving(1) = watch%curving(1) + impulse*regime%bend(channel)
      ! the pairs are also rounded
      if (regime%modes%wide) then
         call lower_slack_wide(size(watch%due), time, impulse, 2*watch%reserve, &
            regime%reach(:, channel), watch%due, watch%slack, watch%speed)
      else
         call lower_slack(size(watch%due), time, impulse, 2*watch%reserve, &
            regime%reach(:, channel), watch%due, watch%slack, watch%speed)
      end if
   end subroutine keep_watch

   !> A bound on the absolute second derivative of a row just after an impact that `keep_watch`
   !! knows, and from then on.
   pure real(wp) function most_second(watch, rows, row)
      !> The certificates.
      type(watch_type), intent(in) :: watch
      !> The rows, and the number of the row.
      type(rows_type), intent(in) :: rows
      integer, intent(in) :: row

      most_second = (rows%bent_norm(row)*watch%curving(1) + watch%of_ripple(1)) &
         *(1 + 1.0e-9_wp)
   end function most_second

   !> Bounds on the rates of the rows after an impulse of 1 on a gap, for the time of
   !! the longest certificate: the Taylor series of each rate, term by term, and its remainder.
   pure subroutine find_reach(regime, gap, reach)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> The gap.
      integer, intent(in) :: gap
      !> (rows) The bounds.
      real(wp), intent(out) :: reach(:)
      real(wp), dimension(size(regime%kick_x, 1)) :: before, x, v
      real(wp), dimension(size(regime%upper)) :: d
      real(wp) :: factor
      integer :: i

      x = regime%kick_x(:, gap)
      v = regime%kick_v(:, gap)
      reach = 0
      factor = 1
      do i = 1, terms
         if (any(abs(v) > 0)) then
            call free_sums(regime%rows, v, d)
            reach = reach + factor*abs(d)
         end if
         before = x
         x = v
         v = -regime%modes%stiffness*before - 2*regime%modes%damping*v
         factor = factor*(longest*regime%unit)/i
      end do
      ! v^2 + omega^2 x^2 never grows
      reach = (reach + factor*regime%rows%bent_norm*sqrt(sum(v**2 &
         + regime%modes%stiffness*x**2)))*(1 + 1.0e-9_wp)
   end subroutine find_reach

end module vi_watch
