!> The first event of a flight of a structure: the first gap that closes, or the first force of a
!! closed gap that falls to 0. No event is missed.
!!
!! All rows are watched together in cells of time. Over a cell a row differs from its cubic Hermite
!! interpolant by f''''/24 t^2 (h - t)^2, so that its Bernstein coefficients, with a bound on
!! f'''', prove that most rows stay within their limits. A row in doubt is searched by steps that
!! cannot jump over a zero (vi_advance), up to the first event found so far in the cell.
!!
!! Just after departure from a wall the gap is a small difference of large numbers. There its
!! Taylor series is used: g(t) = t k(t) with k(0) the departure speed.
module vi_channels
   use vi_advance, only: safe_step
   use vi_bernstein, only: sag
   use vi_kinds, only: wp
   use vi_modes, only: advance, bound_on, levels, rates, step_functions
   use vi_structure, only: regime_type
   implicit none (type, external)
   private

   public :: first_event, row_derivatives

   !> How a flight begins: at a wall of a row (+1 upper, -1 lower) with a departure speed, or at no
   !! wall (row 0).
   type, public :: leaving_type
      integer :: row = 0, wall = 0
      real(wp) :: speed = 0
      !> Whether the gap opens from rest, where its second derivative is 0.
      logical :: released = .false.
   end type leaving_type

   !> The event: a row reaches its upper (+1) or lower (-1) limit.
   type, public :: reached_type
      !> 0 if there is none within the limit of time.
      integer :: row = 0, wall = 0
      !> Time after the start of the flight, and approach speed.
      real(wp) :: time = 0, speed = 0
      !> False if the search exceeded its step budget.
      logical :: complete = .true.
   end type reached_type

   integer, parameter :: budget = 10000000
   !> Cells after which the pairs are computed directly again.
   integer, parameter :: cells = 64
   !> Terms of the Taylor series of g.
   integer, parameter :: terms = 9

contains

   !> The first event of a flight.
   pure subroutine first_event(regime, x0, v0, phase, leaving, limit, level, reached)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at the start.
      real(wp), intent(in) :: x0(:), v0(:)
      !> Load phase at the start (rad).
      real(wp), intent(in) :: phase
      !> How the flight begins.
      type(leaving_type), intent(in) :: leaving
      !> Latest time of an event that is reported.
      real(wp), intent(in) :: limit
      !> In: level of the first step tried. Out: of the last one.
      integer, intent(inout) :: level
      !> The event.
      type(reached_type), intent(out) :: reached
      real(wp), dimension(size(x0)) :: x, v, x_next, v_next
      real(wp), dimension(size(regime%upper)) :: y, rate, y_next, rate_next, bound, low, high, &
         reserve
      complex(wp) :: turn(size(regime%turns, 1)), turn_next(size(regime%turns, 1))
      integer :: doubtful(size(regime%upper))
      real(wp) :: h, time, found, speed, t, horizon
      real(wp) :: inner(4)
      integer :: i, j, n, steps, wall, row

      call bound_rows(regime, x0, v0, 4, bound)
      t = 0
      horizon = cells*regime%steps%length(level)
      call start_afresh(regime, x0, v0, phase, t, horizon, x, v, turn, y, rate, reserve)
      if (leaving%row > 0) then
         y(leaving%row) = merge(regime%upper(leaving%row), regime%lower(leaving%row), &
            leaving%wall > 0)
         rate(leaving%row) = -leaving%wall*leaving%speed
      end if
      steps = 0
      do while (t < limit)
         steps = steps + 1
         reached%complete = steps < budget
         if (.not. reached%complete) return
         h = regime%steps%length(level)
         if (t + h > horizon) then
            horizon = t + cells*h
            call start_afresh(regime, x0, v0, phase, t, cells*h, x, v, turn, y, rate, reserve)
         end if
         x_next = regime%steps%xx(:, level)*x + regime%steps%xv(:, level)*v &
            + regime%steps%x(:, level)
         v_next = regime%steps%vx(:, level)*x + regime%steps%vv(:, level)*v &
            + regime%steps%v(:, level)
         turn_next = turn*regime%turns(:, level)
         call row_values(regime, x_next, v_next, turn_next, y_next, rate_next)
         high = max(y, y + 0.25_wp*h*rate, 0.5_wp*(y + y_next) + h*(rate - rate_next)/6 &
            + sag(bound, h), y_next - 0.25_wp*h*rate_next, y_next)
         low = min(y, y + 0.25_wp*h*rate, 0.5_wp*(y + y_next) + h*(rate - rate_next)/6 &
            - sag(bound, h), y_next - 0.25_wp*h*rate_next, y_next)
         n = 0
         do i = 1, size(y)
            if (high(i) < regime%upper(i) - reserve(i) .and. &
               low(i) > regime%lower(i) + reserve(i)) cycle
            if (i == leaving%row .and. t <= 0) then
               ! the row starts on its limit and leaves it: the first coefficient does not count
               inner = [y(i) + 0.25_wp*h*rate(i), 0.5_wp*(y(i) + y_next(i)) &
                  + h*(rate(i) - rate_next(i))/6, y_next(i) - 0.25_wp*h*rate_next(i), y_next(i)]
               if (leaving%wall > 0) then
                  inner(2) = inner(2) + sag(bound(i), h)
                  if (maxval(inner) < regime%upper(i) - reserve(i) .and. &
                     low(i) > regime%lower(i) + reserve(i)) cycle
               else
                  inner(2) = inner(2) - sag(bound(i), h)
                  if (minval(inner) > regime%lower(i) + reserve(i) .and. &
                     high(i) < regime%upper(i) - reserve(i)) cycle
               end if
            end if
            n = n + 1
            doubtful(n) = i
         end do
         if (n > 2 .and. level < levels) then
            level = level + 1
            cycle
         end if
         found = min(t + h, limit)
         row = 0
         do j = 1, n
            call search(regime, x0, v0, phase, doubtful(j), leaving, bound(doubtful(j)), t, found, &
               h, &
               wall, time, speed, reached%complete)
            if (.not. reached%complete) return
            if (wall == 0) cycle
            found = time
            row = doubtful(j)
            reached = reached_type(row, wall, time, speed)
         end do
         if (row > 0) return
         t = t + h
         x = x_next
         v = v_next
         turn = turn_next
         y = y_next
         rate = rate_next
         if (n == 0) level = max(1, level - 1)
      end do
   end subroutine first_event

   !> Computes the pairs and rows at a time directly, so that rounding errors of the products do not
   !! add up, and bounds the rounding errors of the rows for some time after it.
   pure subroutine start_afresh(regime, x0, v0, phase, t, duration, x, v, turn, y, rate, reserve)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at the start of the flight.
      real(wp), intent(in) :: x0(:), v0(:)
      !> Load phase there (rad), the time after it, and how long the bound has to hold.
      real(wp), intent(in) :: phase, t, duration
      !> (m) The pairs at that time.
      real(wp), intent(out) :: x(:), v(:)
      !> (harmonics) e^(i h Omega t) then.
      complex(wp), intent(out) :: turn(:)
      !> (rows) Values, rates, and the bound.
      real(wp), intent(out) :: y(:), rate(:), reserve(:)
      integer :: h

      if (t > 0) then
         call advance(regime%modes, t, x0, v0, x, v)
      else
         x = x0
         v = v0
      end if
      do h = 1, size(turn)
         associate (angle => h*(phase + regime%frequency*t))
            turn(h) = cmplx(cos(angle), sin(angle), wp)
         end associate
      end do
      call row_values(regime, x, v, turn, y, rate)
      call rounding(regime, x, v, duration, reserve)
   end subroutine start_afresh

   !> A bound on the rounding errors of the rows over some time.
   pure subroutine rounding(regime, x, v, duration, reserve)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at the beginning.
      real(wp), intent(in) :: x(:), v(:)
      !> How long.
      real(wp), intent(in) :: duration
      !> (rows)
      real(wp), intent(out) :: reserve(:)
      real(wp), parameter :: share = 16*epsilon(1.0_wp)
      real(wp) :: of_x, of_v
      integer :: h, k

      reserve = abs(regime%row_offset)
      do h = 1, size(regime%ripple, 2)
         reserve = reserve + abs(regime%ripple(:, h))
      end do
      do k = 1, size(x)
         associate (stiffness => regime%modes%stiffness(k), force => abs(regime%modes%force(k)), &
            drift => abs(regime%modes%drift(k)), first => regime%first_row(k), &
            last => regime%last_row(k))
            if (stiffness > 0) then
               call bound_on(stiffness, abs(x(k)) + force/stiffness &
                  + 2*regime%modes%damping(k)*drift/stiffness, abs(v(k)) + drift, of_x, of_v)
            else
               of_v = abs(v(k)) + force*duration
               of_x = abs(x(k)) + (of_v + drift)*duration
            end if
            reserve(first:last) = reserve(first:last) + abs(regime%position(first:last, k))*of_x &
               + abs(regime%velocity(first:last, k))*of_v
         end associate
      end do
      reserve = share*reserve
   end subroutine rounding

   !> The rows and their rates.
   pure subroutine row_values(regime, x, v, turn, y, rate)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs.
      real(wp), intent(in) :: x(:), v(:)
      !> (harmonics) e^(i h Omega t).
      complex(wp), intent(in) :: turn(:)
      !> (rows) Values and rates.
      real(wp), intent(out) :: y(:), rate(:)
      complex(wp) :: here
      integer :: h, i, k

      y = regime%row_offset
      rate = regime%rate_offset
      do k = 1, size(x)
         if (regime%by_position) then
            do i = regime%first_row(k), regime%last_row(k)
               y(i) = y(i) + regime%position(i, k)*x(k)
               rate(i) = rate(i) + regime%position(i, k)*v(k)
            end do
         else
            do i = regime%first_row(k), regime%last_row(k)
               y(i) = y(i) + regime%position(i, k)*x(k) + regime%velocity(i, k)*v(k)
               rate(i) = rate(i) + regime%rate_position(i, k)*x(k) + regime%rate_velocity(i, k)*v(k)
            end do
         end if
      end do
      do h = 1, size(turn)
         do i = 1, size(y)
            here = regime%ripple(i, h)*turn(h)
            y(i) = y(i) + here%re
            rate(i) = rate(i) - h*regime%frequency*here%im
         end do
      end do
   end subroutine row_values

   !> Bounds on the absolute derivatives of a given order >= 2 of all rows, from now on.
   pure subroutine bound_rows(regime, x0, v0, order, bound)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs.
      real(wp), intent(in) :: x0(:), v0(:)
      !> Order of the derivative.
      integer, intent(in) :: order
      !> (rows)
      real(wp), intent(out) :: bound(:)
      real(wp), dimension(size(x0)) :: x, v, of_x, of_v
      integer :: h, i, k

      x = x0
      v = v0
      do i = 1, order
         call rates(regime%modes, i, x, v)
      end do
      call bound_on(regime%modes%stiffness, x, v, of_x, of_v)
      bound = 0
      do k = 1, size(x)
         do i = regime%first_row(k), regime%last_row(k)
            bound(i) = bound(i) + abs(regime%position(i, k))*of_x(k) &
               + abs(regime%velocity(i, k))*of_v(k)
         end do
      end do
      do h = 1, size(regime%ripple, 2)
         bound = bound + abs(regime%ripple(:, h))*(h*regime%frequency)**order
      end do
   end subroutine bound_rows

   !> A row and its first three derivatives, computed directly from the start of the flight.
   pure subroutine row_derivatives(regime, x0, v0, phase, row, t, d)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at the start.
      real(wp), intent(in) :: x0(:), v0(:)
      !> Load phase at the start (rad).
      real(wp), intent(in) :: phase
      !> Number of the row.
      integer, intent(in) :: row
      !> Time after the start of the flight.
      real(wp), intent(in) :: t
      !> The derivatives of order 0 to 3.
      real(wp), intent(out) :: d(0:3)
      real(wp) :: u, w, s2, s3, x, v, x_before, omega
      complex(wp) :: here
      integer :: h, i, j, k

      d = 0
      d(0) = regime%row_offset(row)
      do j = regime%begins(row), regime%begins(row + 1) - 1
         k = regime%touched(j)
         associate (stiffness => regime%modes%stiffness(k), damping => regime%modes%damping(k), &
            drift => regime%modes%drift(k), force => regime%modes%force(k))
            if (abs(drift) + abs(force) > 0) then
               call step_functions(stiffness, damping, t, u, w, s2, s3)
            else
               call step_functions(stiffness, damping, t, u, w)
               s2 = 0
            end if
            x = u*x0(k) + w*v0(k) + force*s2 + drift*(w + 2*damping*s2)
            v = (u - 2*damping*w)*v0(k) - stiffness*w*x0(k) + force*w - stiffness*drift*s2
            d(0) = d(0) + regime%position(row, k)*x + regime%velocity(row, k)*v
            do i = 1, 3
               x_before = x
               x = v
               v = -stiffness*x_before - 2*damping*v
               if (i == 1) x = x + drift
               if (i == 1) v = v + force
               d(i) = d(i) + regime%position(row, k)*x + regime%velocity(row, k)*v
            end do
         end associate
      end do
      do h = 1, size(regime%ripple, 2)
         omega = h*regime%frequency
         here = regime%ripple(row, h)*cmplx(cos(h*(phase + regime%frequency*t)), &
            sin(h*(phase + regime%frequency*t)), wp)
         d = d + [here%re, -omega*here%im, -omega**2*here%re, omega**3*here%im]
      end do
   end subroutine row_derivatives

   !> The first time within a cell at which one row reaches a limit.
   pure subroutine search(regime, x0, v0, phase, row, leaving, bound, begin, end, longest, wall, &
      time, speed, complete)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at the start of the flight.
      real(wp), intent(in) :: x0(:), v0(:)
      !> Load phase there (rad).
      real(wp), intent(in) :: phase
      !> The row.
      integer, intent(in) :: row
      !> How the flight begins.
      type(leaving_type), intent(in) :: leaving
      !> Bound on the absolute fourth derivative of the row.
      real(wp), intent(in) :: bound
      !> Times between which to search.
      real(wp), intent(in) :: begin, end
      !> Longest step: the length of the cell, so that a short remainder of the cell is not mistaken
      !! for a contact.
      real(wp), intent(in) :: longest
      !> Limit that is reached: +1 upper, -1 lower; 0 if none is.
      integer, intent(out) :: wall
      !> Time at which it is reached, and approach speed.
      real(wp), intent(out) :: time, speed
      !> False if the search exceeded its step budget.
      logical, intent(out) :: complete
      real(wp) :: k(0:terms - 1), d(0:3), t, h, step, near, fifth
      integer :: i, side

      wall = 0
      speed = 0
      time = end
      complete = .true.
      near = 0
      fifth = 0
      if (row == leaving%row .and. begin <= 0) call gap_series(regime, x0, v0, phase, leaving, k, &
         near, fifth)
      t = begin
      do i = 1, budget
         call row_derivatives(regime, x0, v0, phase, row, t, d)
         if (row == leaving%row .and. t <= 0) d(:1) = [merge(regime%upper(row), &
            regime%lower(row), leaving%wall > 0), -leaving%wall*leaving%speed]
         step = huge(1.0_wp)
         do side = 1, -1, -2
            if (side > 0 .and. regime%upper_gap(row) == 0) cycle
            if (side < 0 .and. regime%lower_gap(row) == 0) cycle
            if (row == leaving%row .and. side == leaving%wall .and. t < near) then
               h = series_step(k, fifth, bound, leaving%released, t, near)
               if (h <= 2*epsilon(1.0_wp)*t) speed = max(0.0_wp, series_speed(k, t))
            else
               h = safe_step(max(0.0_wp, side*(merge(regime%upper(row), regime%lower(row), &
                  side > 0) - d(0))), -side*d(1), -side*d(2), -side*d(3), bound, &
                  longest)
               if (h <= 2*epsilon(1.0_wp)*t) speed = max(0.0_wp, side*d(1))
            end if
            if (h <= 2*epsilon(1.0_wp)*t) then
               wall = side
               time = t
               return
            end if
            step = min(step, h)
         end do
         t = t + step
         if (t > end) return
      end do
      complete = .false.
   end subroutine search

   !> Taylor coefficients of k(t) = g(t)/t, the gap to the wall just left over time, and the time up
   !! to which they are valid.
   pure subroutine gap_series(regime, x0, v0, phase, leaving, k, near, fifth)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at the start.
      real(wp), intent(in) :: x0(:), v0(:)
      !> Load phase at the start (rad).
      real(wp), intent(in) :: phase
      !> The wall that is left.
      type(leaving_type), intent(in) :: leaving
      !> Coefficients.
      real(wp), intent(out) :: k(0:)
      !> Time up to which they are valid, and a bound on the fifth derivative of the gap.
      real(wp), intent(out) :: near, fifth
      real(wp) :: d(0:terms + 1), x, v, x_before, factorial, of_x, of_v, omega
      complex(wp) :: here
      integer :: h, i, j, n

      d = 0
      fifth = 0
      do j = regime%begins(leaving%row), regime%begins(leaving%row + 1) - 1
         n = regime%touched(j)
         x = x0(n)
         v = v0(n)
         do i = 1, terms + 1
            x_before = x
            x = v
            v = -regime%modes%stiffness(n)*x_before - 2*regime%modes%damping(n)*v
            if (i == 1) x = x + regime%modes%drift(n)
            if (i == 1) v = v + regime%modes%force(n)
            if (i <= terms) d(i) = d(i) + regime%position(leaving%row, n)*x &
               + regime%velocity(leaving%row, n)*v
            if (i /= 5 .and. i <= terms) cycle
            call bound_on(regime%modes%stiffness(n), x, v, of_x, of_v)
            of_x = abs(regime%position(leaving%row, n))*of_x &
               + abs(regime%velocity(leaving%row, n))*of_v
            if (i == 5) fifth = fifth + of_x
            if (i > terms) d(i) = d(i) + of_x
         end do
      end do
      do h = 1, size(regime%ripple, 2)
         omega = h*regime%frequency
         here = regime%ripple(leaving%row, h)*cmplx(cos(h*phase), sin(h*phase), wp)
         do i = 1, terms
            here = here*cmplx(0.0_wp, omega, wp)
            d(i) = d(i) + here%re
         end do
         fifth = fifth + abs(regime%ripple(leaving%row, h))*omega**5
         d(terms + 1) = d(terms + 1) + abs(regime%ripple(leaving%row, h))*omega**(terms + 1)
      end do
      k(0) = leaving%speed
      factorial = 1
      do i = 2, terms
         factorial = factorial*i
         k(i - 1) = -leaving%wall*d(i)/factorial
      end do
      if (leaving%released) k(1) = 0
      ! the omitted terms are below the rounding of g = k(0) t + .., or of k(2) t^3 + .. after a
      ! release
      near = 0.25_wp*regime%steps%length(1)
      i = merge(terms - 2, terms, leaving%released)
      x = epsilon(1.0_wp)*merge(abs(k(2)), k(0), leaving%released)*factorial*(terms + 1)
      if (d(terms + 1)*near**i > x) near = (x/d(terms + 1))**(1.0_wp/i)
   end subroutine gap_series

   !> A safe step for the gap to the wall just left, from its series: |k''''| <= B/5 with B the
   !! bound on g'''''.
   pure real(wp) function series_step(k, fifth, fourth, released, t, near) result(step)
      !> Coefficients of g(t)/t; bounds on the fifth and fourth derivative of g.
      real(wp), intent(in) :: k(0:), fifth, fourth
      !> Whether the gap opens from rest.
      logical, intent(in) :: released
      !> Time after the start, and time up to which the series is valid.
      real(wp), intent(in) :: t, near
      real(wp) :: value, slope, curvature, jerk
      integer :: n

      if (t <= 0 .and. released) then
         ! k = k2 t^2 + ..: positive as long as the fourth derivative of the gap cannot outweigh
         ! this term
         step = min(near, 23.9_wp*max(0.0_wp, k(2))/max(fourth, tiny(fourth)))
         return
      end if
      value = 0
      slope = 0
      curvature = 0
      jerk = 0
      do n = ubound(k, 1), 0, -1
         jerk = jerk*t + 3*curvature
         curvature = curvature*t + 2*slope
         slope = slope*t + value
         value = value*t + k(n)
      end do
      step = safe_step(max(0.0_wp, value), slope, curvature, jerk, 0.2_wp*fifth, 2*near)
   end function series_step

   !> Approach speed -g' = -t k' at a zero of k.
   pure real(wp) function series_speed(k, t) result(speed)
      !> Coefficients of g(t)/t.
      real(wp), intent(in) :: k(0:)
      !> Time of the zero.
      real(wp), intent(in) :: t
      integer :: n

      speed = 0
      do n = ubound(k, 1), 1, -1
         speed = speed*t + n*k(n)
      end do
      speed = -t*speed
   end function series_speed

end module vi_channels
