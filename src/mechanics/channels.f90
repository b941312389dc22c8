!> The first event of a flight of a structure: the first gap that closes, or the first force of a
!! closed gap that falls to 0. No event is missed.
!!
!! All rows are watched together in cells of time. Over a cell a row differs from its cubic Hermite
!! interpolant by f''''/24 t^2 (h - t)^2, so that its Bernstein coefficients, with a bound on
!! f'''', prove that most rows stay within their limits. A row in doubt is searched by steps that
!! cannot jump over a zero, up to the first event found so far in the cell.
!!
!! Rows that, by a certificate, stay away from their limits during the cell are skipped, with the
!! same result (vi_watch).
!!
!! A row in doubt is evaluated by its Taylor series about the beginning of the cell, as far as the
!! omitted terms are below rounding (vi_series).
module vi_channels
   use vi_kinds, only: wp
   use vi_lane_groups, only: add_derivatives, bound_pairs, sizes_of_free_pairs, sizes_of_pairs
   use vi_lane_groups_wide, only: add_derivatives_wide => add_derivatives, &
      bound_pairs_wide => bound_pairs, sizes_of_free_pairs_wide => sizes_of_free_pairs, &
      sizes_of_pairs_wide => sizes_of_pairs
   use vi_lane_rows, only: mark_doubts, side_by_side, start_free_series, start_series, step_pairs
   use vi_lane_rows_wide, only: mark_doubts_wide => mark_doubts, &
      start_free_series_wide => start_free_series, start_series_wide => start_series, &
      step_pairs_wide => step_pairs
   use vi_modes, only: advance, advance_pair, bound_on, levels
   use vi_rows, only: add_ripple, bound_values, row_values, rows_type
   use vi_series, only: follow, new_opening, opening_type, order, series_type, step_budget, &
      tolerated
   use vi_structure, only: regime_type
   use vi_watch, only: begin_watch, leave_row, leaving_type, list_doubts, look_at_rows, never, &
      rounding, rounding_share, set_at_limit, watch_type
   implicit none (type, external)
   private

   public :: bound_fourth, bound_second, first_event, leading_term, leaving_type, never, &
      row_derivatives, size_of_rate

   !> The lengths of cells, kept by the caller from one flight to the next, and where a search that
   !! was interrupted goes on.
   type, public :: pace_type
      !> Level of the first step tried, and after how many cells longer steps are tried.
      integer :: level = 8, hold = 0
      !> Time up to which an interrupted search has found that there is no event; 0 for a flight
      !! that has not been searched.
      real(wp) :: from = 0
      !> Cells of an interrupted search so far, those without doubt, and the level of the longest.
      integer :: cells = 0, clear = 0, longest = levels
      !> Time of the state from which it bounded the fourth derivatives.
      real(wp) :: bounded = 0
   end type pace_type

   !> The event: a row reaches its upper (+1) or lower (-1) limit.
   type, public :: reached_type
      !> 0 if there is none within the limit of time.
      integer :: row = 0, wall = 0
      !> Time after the start of the flight, and approach speed; a bound on the rounding errors of
      !! the row.
      real(wp) :: time = 0, speed = 0, reserve = 0
      !> False if the search exceeded its step budget.
      logical :: complete = .true.
      !> Whether the search was interrupted: it goes on from the pace that it returned.
      logical :: interrupted = .false.
      !> Steps that it took since it began or went on, of cells and within them.
      integer :: steps = 0
   end type reached_type

   !> Cells after which the pairs are computed directly again.
   integer, parameter :: cells = 64
   !> Steps within a cell after which the bounds on fourth derivatives are computed again.
   integer, parameter :: many = 256
   !> 1/i, and 1/i!. An index of implied loops would be a variable that all threads share.
   real(wp), parameter :: numbers(order + 1) = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, &
      15, 16, 17, 18, 19, 20, 21], &
      inverse(order + 1) = 1/numbers, inverse_factorial(0:order) = 1/gamma(numbers)

   !> Room for a search.
   type, public :: space_type
      real(wp), allocatable :: pairs(:, :), work(:, :), values(:, :)
      complex(wp), allocatable :: turns(:, :)
      integer, allocatable :: doubtful(:, :)
      type(watch_type) :: watch
   end type space_type

contains

   !> The first event of a flight.
   pure recursive subroutine first_event(regime, x0, v0, phase, leaving, limit, pace, reached, &
      space, patience, partings)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at the start.
      real(wp), contiguous, intent(in) :: x0(:), v0(:)
      !> Load phase at the start (rad).
      real(wp), intent(in) :: phase
      !> How the flight begins.
      type(leaving_type), intent(in) :: leaving
      !> Latest time of an event that is reported.
      real(wp), intent(in) :: limit
      !> In: how to begin. Out: how to begin the next flight.
      type(pace_type), intent(inout) :: pace
      !> The event.
      type(reached_type), intent(out) :: reached
      !> Kept by the caller, so that memory is not allocated again for each flight.
      type(space_type), intent(inout) :: space
      !> Steps after which the search is interrupted; if absent, it never is. A search that goes on
      !! finds the event that it would have found without.
      integer, intent(in), optional :: patience
      !> Further rows that leave a limit at the start.
      type(leaving_type), intent(in), optional :: partings(:)
      integer :: most

      most = huge(most)
      if (present(patience)) most = patience
      call make_room(regime, space)
      if (.not. present(partings)) then
         call search_cells(regime, size(x0), size(regime%upper), size(regime%turns, 1), x0, v0, &
            phase, 1, [leaving], limit, most, pace, space%pairs, space%work, space%values, &
            space%turns, space%doubtful, space%watch, reached)
      else if (leaving%row > 0) then
         call first_event(regime, x0, v0, phase, leaving_type(), limit, pace, reached, space, &
            patience, [leaving, partings])
      else
         call search_cells(regime, size(x0), size(regime%upper), size(regime%turns, 1), x0, v0, &
            phase, size(partings), partings, limit, most, pace, space%pairs, space%work, &
            space%values, space%turns, space%doubtful, space%watch, reached)
      end if
   end subroutine first_event

   !> Allocates what a search needs.
   pure subroutine make_room(regime, space)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> In and out: allocated, if it does not fit.
      type(space_type), intent(inout) :: space
      logical :: fits

      associate (pairs => size(regime%modes%stiffness), rows => size(regime%upper), &
         harmonics => size(regime%turns, 1))
         fits = allocated(space%pairs)
         if (fits) fits = size(space%pairs, 1) >= pairs .and. size(space%values, 1) >= rows .and. &
            size(space%turns, 1) >= harmonics
         if (fits) return
         if (allocated(space%pairs)) deallocate (space%pairs, space%work, space%values, &
            space%turns, space%doubtful)
         allocate (space%pairs(pairs, 6), space%work(pairs + side_by_side, 8), &
            space%values(rows, 8), space%turns(harmonics, 2), &
            space%doubtful(2, rows))
      end associate
   end subroutine make_room

   !> The first event of a flight, cell by cell.
   pure subroutine search_cells(regime, m, rows, harmonics, x0, v0, phase, starts, leaving, &
      limit, most, pace, pairs, work, values, turns, doubtful, watch, reached)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> Number of pairs, of rows, and of harmonics of the load.
      integer, intent(in) :: m, rows, harmonics
      !> (m) The pairs at the start.
      real(wp), intent(in) :: x0(m), v0(m)
      !> As in `first_event`.
      real(wp), intent(in) :: phase
      !> How the flight begins: rows that leave a limit, and their number.
      integer, intent(in) :: starts
      type(leaving_type), intent(in) :: leaving(starts)
      !> As in `first_event`.
      real(wp), intent(in) :: limit
      !> Steps after which the search is interrupted.
      integer, intent(in) :: most
      !> As in `first_event`.
      type(pace_type), intent(inout) :: pace
      !> Pairs at the beginning and at the end of a cell (m, 1 to 4, in turns), and room for two
      !! bounds.
      real(wp), intent(inout) :: pairs(m, 6)
      !> Room for pairs.
      real(wp), intent(inout) :: work(m + side_by_side, 8)
      !> Rows and rates at the beginning and at the end of a cell (rows, 1 to 4, in turns), the
      !! bounds on their fourth derivatives (rows, 5) and on rounding errors (rows, 6), and room.
      real(wp), intent(inout) :: values(rows, 8)
      !> (harmonics) e^(i h Omega t) at the beginning and at the end of a cell.
      complex(wp), intent(inout) :: turns(harmonics, 2)
      !> The rows in doubt, as in `find_doubts`.
      integer, intent(inout) :: doubtful(2, rows)
      !> The certificates of rows that need no look.
      type(watch_type), intent(inout) :: watch
      !> The event.
      type(reached_type), intent(out) :: reached
      real(wp) :: bounded, brief, found, h, horizon, speed, t, time
      integer :: clear, hold, j, level, longest, n, next, now, row, steps, taken, wall
      logical :: crowded, fresh, alone, small

      ! where a cell costs less than a search, long cells in doubt are divided, not searched
      small = m*rows <= 64
      brief = 1/max(regime%rows%most_fastest, tiny(1.0_wp))
      alone = regime%rows%alone .and. .not. regime%rows%grows
      bounded = pace%bounded
      if (bounded > 0) then
         call pairs_at(regime, m, harmonics, x0, v0, phase, bounded, pairs(:, 1), pairs(:, 2), &
            turns(:, 1))
         call bound_fourth_of_pairs(regime, m, pairs(:, 1), pairs(:, 2), pairs(:, 5), pairs(:, 6))
      else if (.not. (alone .and. regime%modes%conserves)) then
         call bound_fourth_of_pairs(regime, m, x0, v0, pairs(:, 5), pairs(:, 6))
      end if
      if (alone) then
         call begin_watch(regime, x0, v0, pairs(:, 5), watch)
         do j = 1, starts
            call leave_row(leaving(j)%row, watch)
         end do
      else
         call bound_rows(regime, pairs(:, 5), pairs(:, 6), values(:, 5))
      end if
      level = pace%level
      hold = pace%hold
      t = pace%from
      horizon = t + cells*regime%steps%length(level)
      now = 1
      call start_afresh(regime, m, rows, harmonics, starts, leaving, x0, v0, phase, t, &
         cells*regime%steps%length(level), alone, 1, pairs, turns, values, watch)
      fresh = .true.
      steps = pace%cells
      clear = pace%clear
      longest = pace%longest
      do while (t < limit)
         steps = steps + 1
         reached%complete = steps < step_budget
         if (.not. reached%complete) return
         h = regime%steps%length(level)
         next = 3 - now
         if (t + h > horizon .and. reached%steps >= most) then
            ! here all is computed directly, whether the search is interrupted or not
            pace = pace_type(level, hold, t, steps - 1, clear, longest, bounded)
            reached%interrupted = .true.
            return
         end if
         reached%steps = reached%steps + 1
         if (t + h > horizon) then
            horizon = t + cells*h
            call start_afresh(regime, m, rows, harmonics, starts, leaving, x0, v0, phase, t, &
               cells*h, alone, now, pairs, turns, values, watch)
            fresh = .true.
         end if
         if (regime%modes%wide) then
            call step_pairs_wide(m, regime%steps%map(:, :, level), pairs(:, 2*now - 1), &
               pairs(:, 2*now), pairs(:, 2*next - 1), pairs(:, 2*next))
         else
            call step_pairs(m, regime%steps%map(:, :, level), pairs(:, 2*now - 1), &
               pairs(:, 2*now), pairs(:, 2*next - 1), pairs(:, 2*next))
         end if
         if (regime%rows%grows) call add_growth(regime, level, t, pairs(:, 2*next - 1), &
            pairs(:, 2*next))
         do j = 1, harmonics
            turns(j, next) = turns(j, now)*regime%turns(j, level)
         end do
         n = 0
         if (alone) then
            call look_at_rows(regime, m, rows, harmonics, starts, leaving, t, h, now, pairs, &
               turns, values, watch, doubtful, n)
         else
            call row_values(regime%rows, regime%frequency, pairs(:, 2*next - 1), &
               pairs(:, 2*next), turns(:, next), values(:, 2*next - 1), values(:, 2*next), t + h)
            if (regime%rows%wide) then
               call mark_doubts_wide(rows, h, values(:, 2*now - 1), values(:, 2*now), &
                  values(:, 2*next - 1), values(:, 2*next), values(:, 5), values(:, 6), &
                  regime%upper, regime%lower, values(:, 7), values(:, 8))
            else
               call mark_doubts(rows, h, values(:, 2*now - 1), values(:, 2*now), &
                  values(:, 2*next - 1), values(:, 2*next), values(:, 5), values(:, 6), &
                  regime%upper, regime%lower, values(:, 7), values(:, 8))
            end if
            if (any(values(:, 7) + values(:, 8) > 0)) call list_doubts(regime, rows, 0, rows, &
               starts, leaving, t, h, now, values, doubtful, n)
         end if
         if (n > merge(0, 2, small .and. h > brief) .and. level < levels) then
            level = level + 1
            hold = 2
            cycle
         end if
         ! a search begins from pairs computed directly, so that rounding errors stay small
         if (n > 0 .and. .not. fresh) call pairs_at(regime, m, harmonics, x0, v0, phase, t, &
            pairs(:, 2*now - 1), pairs(:, 2*now), turns(:, now))
         found = min(t + h, limit)
         row = 0
         crowded = .false.
         do j = 1, n
            call search(regime, x0, v0, phase, pairs(:, 2*now - 1), pairs(:, 2*now), &
               turns(:, now), doubtful(:, j), departure_of(doubtful(1, j), starts, leaving), &
               values(doubtful(1, j), 5), t, found, h, &
               work, wall, time, speed, taken, reached%complete)
            reached%steps = reached%steps + taken
            crowded = crowded .or. taken > many
            if (.not. reached%complete) return
            if (wall == 0) cycle
            found = time
            row = doubtful(1, j)
            reached = reached_type(row, wall, time, speed, values(row, 6), steps=reached%steps)
         end do
         pace = pace_type(level)
         if (n == 0) clear = clear + 1
         if (n == 0) longest = min(longest, level)
         ! the next flight is likely to be of a similar length
         if (clear > 1) pace = pace_type(longest, 2)
         if (row > 0) return
         t = t + h
         now = next
         fresh = .false.
         if (crowded .and. .not. (alone .or. regime%rows%grows)) then
            ! what is left of a damped motion may be far below the bound of its beginning
            bounded = t
            call pairs_at(regime, m, harmonics, x0, v0, phase, t, pairs(:, 2*now - 1), &
               pairs(:, 2*now), turns(:, now))
            call bound_fourth_of_pairs(regime, m, pairs(:, 2*now - 1), pairs(:, 2*now), &
               pairs(:, 5), pairs(:, 6))
            call bound_rows(regime, pairs(:, 5), pairs(:, 6), values(:, 5))
         end if
         hold = hold - 1
         if (n == 0 .and. hold < 0) level = max(1, level - 1)
      end do
   end subroutine search_cells

   !> Computes the pairs, and rows that are all looked at, at a time directly, so that rounding
   !! errors of the products do not add up, and bounds the rounding errors of the rows for some time
   !! after it.
   pure subroutine start_afresh(regime, m, rows, harmonics, starts, leaving, x0, v0, phase, t, &
      duration, alone, at, pairs, turns, values, watch)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> Number of pairs, of rows, and of harmonics of the load.
      integer, intent(in) :: m, rows, harmonics
      !> The rows that leave a limit, and their number.
      integer, intent(in) :: starts
      type(leaving_type), intent(in) :: leaving(starts)
      !> The pairs at the start of the flight.
      real(wp), intent(in) :: x0(m), v0(m)
      !> Load phase there (rad), the time after it, and how long the bound has to hold.
      real(wp), intent(in) :: phase, t, duration
      !> Whether single rows are looked at, not all.
      logical, intent(in) :: alone
      !> Which of the columns.
      integer, intent(in) :: at
      !> As in `search_cells`.
      real(wp), intent(inout) :: pairs(m, 6), values(rows, 8)
      complex(wp), intent(inout) :: turns(harmonics, 2)
      type(watch_type), intent(inout) :: watch

      associate (x => pairs(:, 2*at - 1), v => pairs(:, 2*at))
         call pairs_at(regime, m, harmonics, x0, v0, phase, t, x, v, turns(:, at))
         if (.not. alone) then
            call row_values(regime%rows, regime%frequency, x, v, turns(:, at), &
               values(:, 2*at - 1), values(:, 2*at), t)
            if (t <= 0) call set_at_limit(starts, leaving, regime, 1, rows, values(:, 2*at - 1), &
               values(:, 2*at))
         end if
         call find_roots(regime, m, x, v, t + duration, watch%root_x, watch%root_v)
      end associate
      if (alone) then
         watch%reserve = rounding_share*(regime%rows%most_constant + regime%rows%most_norm &
            *watch%root_x)
      else
         call rounding(regime%rows, 1, rows, watch%root_x, watch%root_v, values(:, 6))
      end if
   end subroutine start_afresh

   !> How a row begins.
   pure function departure_of(row, starts, leaving) result(departure)
      !> The row.
      integer, intent(in) :: row
      !> The rows that leave a limit, and their number.
      integer, intent(in) :: starts
      type(leaving_type), intent(in) :: leaving(starts)
      type(leaving_type) :: departure
      integer :: i

      do i = 1, starts
         if (leaving(i)%row == row) departure = leaving(i)
      end do
   end function departure_of

   !> Adds what growing forces change in a step.
   pure subroutine add_growth(regime, level, t, x, v)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> Level of the step, and the time after the start of the flight at its beginning.
      integer, intent(in) :: level
      real(wp), intent(in) :: t
      !> (m) In and out: the pairs after the step.
      real(wp), intent(inout) :: x(:), v(:)
      integer :: k

      associate (steps => regime%steps, modes => regime%modes)
         do k = 1, size(x)
            ! the tables hold the response to 1 and to the time since the beginning of the step
            associate (f => modes%force(k) + t*modes%force_rate(k), f_rate => modes%force_rate(k), &
               p => modes%drift(k) + t*modes%drift_rate(k), p_rate => modes%drift_rate(k), &
               s2 => steps%s2(k, level), s3 => steps%s3(k, level), w => steps%map(k, 2, level), &
               drag => 2*modes%damping(k))
               x(k) = x(k) + f*s2 + f_rate*s3 + p*(w + drag*s2) + p_rate*(s2 + drag*s3)
               v(k) = v(k) + f*w + f_rate*s2 - modes%stiffness(k)*(p*s2 + p_rate*s3)
            end associate
         end do
      end associate
   end subroutine add_growth

   !> The pairs and the harmonics at a time, computed directly.
   pure subroutine pairs_at(regime, m, harmonics, x0, v0, phase, t, x, v, turn)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> Number of pairs, and of harmonics of the load.
      integer, intent(in) :: m, harmonics
      !> The pairs at the start of the flight.
      real(wp), intent(in) :: x0(m), v0(m)
      !> Load phase there (rad), and the time after it.
      real(wp), intent(in) :: phase, t
      !> The pairs at that time.
      real(wp), intent(out) :: x(m), v(m)
      !> e^(i h Omega t) then.
      complex(wp), intent(out) :: turn(harmonics)
      integer :: h

      if (t > 0) then
         call advance(regime%modes, t, x0, v0, x, v)
      else
         x = x0
         v = v0
      end if
      do h = 1, harmonics
         turn(h) = turned(h*(phase + regime%frequency*t))
      end do
   end subroutine pairs_at

   !> e^(i angle).
   pure complex(wp) function turned(angle)
      !> The angle.
      real(wp), intent(in) :: angle

      turned = cmplx(cos(angle), sin(angle), wp)
   end function turned

   !> Roots of sums of squares of bounds on |x| and |v| over some time.
   pure subroutine find_roots(regime, m, x, v, duration, root_x, root_v)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> Number of pairs.
      integer, intent(in) :: m
      !> The pairs at the beginning.
      real(wp), intent(in) :: x(m), v(m)
      !> How long.
      real(wp), intent(in) :: duration
      !> The roots.
      real(wp), intent(out) :: root_x, root_v
      real(wp) :: sum_x, sum_v

      associate (modes => regime%modes)
         if (modes%conserves .and. modes%wide) then
            call sizes_of_free_pairs_wide(m, modes%bent, duration, modes%stiffness, &
               modes%inverse, x, v, sum_x, sum_v)
         else if (modes%conserves) then
            call sizes_of_free_pairs(m, modes%bent, duration, modes%stiffness, modes%inverse, x, &
               v, sum_x, sum_v)
         else if (modes%wide) then
            call sizes_of_pairs_wide(m, duration, modes%stiffness, modes%damping, modes%inverse, &
               modes%drift, modes%drift_rate, modes%force, modes%force_rate, x, v, sum_x, sum_v)
         else
            call sizes_of_pairs(m, duration, modes%stiffness, modes%damping, modes%inverse, &
               modes%drift, modes%drift_rate, modes%force, modes%force_rate, x, v, sum_x, sum_v)
         end if
      end associate
      root_x = sqrt(sum_x)
      root_v = sqrt(sum_v)
   end subroutine find_roots

   !> Bounds on the absolute fourth derivatives of all rows, from now on.
   pure subroutine bound_fourth(regime, m, x0, v0, of_x, of_v, bound)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> Number of pairs.
      integer, intent(in) :: m
      !> (m) The pairs at the start.
      real(wp), intent(in) :: x0(m), v0(m)
      !> (m) Bounds on the derivatives of the pairs.
      real(wp), intent(out) :: of_x(m), of_v(m)
      !> (rows)
      real(wp), contiguous, intent(out) :: bound(:)

      call bound_fourth_of_pairs(regime, m, x0, v0, of_x, of_v)
      call bound_rows(regime, of_x, of_v, bound)
   end subroutine bound_fourth

   !> Bounds on the absolute fourth derivatives of the pairs, from now on.
   pure subroutine bound_fourth_of_pairs(regime, m, x0, v0, of_x, of_v)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> Number of pairs.
      integer, intent(in) :: m
      !> (m) The pairs at the start.
      real(wp), intent(in) :: x0(m), v0(m)
      !> (m) The bounds.
      real(wp), intent(out) :: of_x(m), of_v(m)

      associate (modes => regime%modes)
         if (modes%wide) then
            call bound_pairs_wide(modes%bent, modes%stiffness, modes%damping, modes%inverse, &
               modes%drift, modes%drift_rate, modes%force, modes%force_rate, x0, v0, of_x, of_v)
         else
            call bound_pairs(modes%bent, modes%stiffness, modes%damping, modes%inverse, &
               modes%drift, modes%drift_rate, modes%force, modes%force_rate, x0, v0, of_x, of_v)
         end if
         of_x(modes%bent + 1:) = 0
         of_v(modes%bent + 1:) = 0
      end associate
   end subroutine bound_fourth_of_pairs

   !> Bounds on the absolute fourth derivatives of all rows from those of the pairs.
   pure subroutine bound_rows(regime, of_x, of_v, bound)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) Bounds on the derivatives of the pairs.
      real(wp), contiguous, intent(in) :: of_x(:), of_v(:)
      !> (rows)
      real(wp), contiguous, intent(out) :: bound(:)

      call bound_values(regime%rows, of_x, of_v, bound)
      call add_ripple(regime%rows, regime%frequency, 0, size(bound), bound)
   end subroutine bound_rows

   !> A row and its first three derivatives at the start of a flight.
   pure subroutine row_derivatives(regime, x0, v0, phase, row, d)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at the start.
      real(wp), intent(in) :: x0(:), v0(:)
      !> Load phase at the start (rad).
      real(wp), intent(in) :: phase
      !> Number of the row.
      integer, intent(in) :: row
      !> The derivatives of order 0 to 3.
      real(wp), intent(out) :: d(0:3)
      complex(wp) :: here
      integer :: h, i

      call free_derivatives(regime, x0, v0, row, d)
      do h = 1, size(regime%ripple, 2)
         here = regime%ripple(row, h)*turned(h*phase)
         do i = 0, 3
            d(i) = d(i) + here%re
            here = here*cmplx(0.0_wp, h*regime%frequency, wp)
         end do
      end do
   end subroutine row_derivatives

   !> The lowest derivative of a row at the start of a flight that is not 0 to rounding.
   !!
   !! All terms of a derivative are also added up without regard to their signs, from those of the
   !! state on: rounding is in proportion to these sums. A row at 0 with a rate that the next
   !! derivative reverses before the row has left 0 by more than rounding only touches 0: its rate
   !! counts as 0.
   pure subroutine leading_term(regime, x0, v0, phase, row, first, last, sense)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at the start.
      real(wp), intent(in) :: x0(:), v0(:)
      !> Load phase at the start (rad).
      real(wp), intent(in) :: phase
      !> Number of the row.
      integer, intent(in) :: row
      !> The lowest order that is considered.
      integer, intent(in) :: first
      !> The order of the derivative; `never` if all are 0.
      integer, intent(out) :: last
      !> Its sign; 0 if all are 0.
      integer, intent(out) :: sense
      real(wp), parameter :: share = 64*epsilon(1.0_wp)
      real(wp), dimension(regime%rows%begins(row + 1) - regime%rows%begins(row)) :: x, v, x_size, &
         v_size, before
      complex(wp) :: here(size(regime%ripple, 2))
      real(wp) :: total, sizes, near, rate
      integer :: h

      near = 0
      rate = 0
      associate (rows => regime%rows, modes => regime%modes)
         associate (begin => rows%begins(row), end => rows%begins(row + 1) - 1)
            associate (k => rows%touched(begin:end), of_x => rows%of_x(begin:end), of_v => &
               rows%of_v(begin:end), stiffness => rows%stiffness(begin:end), &
               drag => rows%drag(begin:end))
               x = x0(k)
               v = v0(k)
               ! a mode with hardly any part in the state has the rounding of the others
               x_size = maxval([0.0_wp, pack(abs(x), abs(of_x) + abs(of_v) > 0)])
               v_size = maxval([0.0_wp, pack(abs(v), abs(of_x) + abs(of_v) > 0)])
               do h = 1, size(here)
                  here(h) = regime%ripple(row, h)*turned(h*phase)
               end do
               total = rows%offset(row)
               sizes = abs(total)
               ! the sample and the constant load may cancel each other
               if (allocated(regime%base_offset)) sizes = abs(regime%base_offset(row)) &
                  + abs(total - regime%base_offset(row))
               do last = 0, order
                  if (last == 1) then
                     total = rows%offset_rate(row)
                     sizes = abs(total)
                  else if (last > 1) then
                     total = 0
                     sizes = 0
                  end if
                  total = total + sum(of_x*x + of_v*v) + sum(here%re)
                  sizes = sizes + sum(abs(of_x)*x_size + abs(of_v)*v_size)
                  do h = 1, size(here)
                     sizes = sizes + rows%ripple_size(row, h)*(h*regime%frequency)**last
                     here(h) = here(h)*cmplx(0.0_wp, h*regime%frequency, wp)
                  end do
                  sense = 0
                  if (abs(total) > share*sizes) sense = merge(1, -1, total > 0)
                  if (last == 0) near = share*sizes
                  if (last == 2 .and. abs(rate) > 0) then
                     if (sense*rate < 0 .and. rate**2 <= 2*near*abs(total)) return
                     exit
                  end if
                  if (last == 1 .and. first <= 1 .and. sense /= 0) then
                     rate = total
                  else if (last >= first .and. sense /= 0) then
                     return
                  end if
                  before = x
                  x = v
                  v = -stiffness*before - drag*v
                  before = x_size
                  x_size = v_size
                  v_size = stiffness*before + drag*v_size
                  if (last == 0) then
                     x = x + modes%drift(k)
                     v = v + modes%force(k)
                     x_size = x_size + abs(modes%drift(k))
                     v_size = v_size + abs(modes%force(k))
                     if (allocated(regime%base_force)) then
                        x_size = x_size + 2*abs(regime%base_drift(k))
                        v_size = v_size + 2*abs(regime%base_force(k))
                     end if
                  else if (last == 1) then
                     x = x + modes%drift_rate(k)
                     v = v + modes%force_rate(k)
                     x_size = x_size + abs(modes%drift_rate(k))
                     v_size = v_size + abs(modes%force_rate(k))
                  end if
               end do
               sense = 0
               if (last < never) sense = merge(1, -1, rate > 0)
               last = merge(1, never, last < never)
            end associate
         end associate
      end associate
   end subroutine leading_term

   !> The sum of the moduli of the terms of a row's rate, at any time of an oscillation about now:
   !! its rounding errors are in proportion.
   pure real(wp) function size_of_rate(regime, x0, v0, row, time) result(total)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs.
      real(wp), intent(in) :: x0(:), v0(:)
      !> Number of the row.
      integer, intent(in) :: row
      !> Time since the forces of the regime were set.
      real(wp), intent(in) :: time
      real(wp) :: of_x, of_v
      integer :: h, j, k

      associate (rows => regime%rows, modes => regime%modes)
         total = abs(rows%offset_rate(row))
         do j = rows%begins(row), rows%begins(row + 1) - 1
            k = rows%touched(j)
            of_x = abs(v0(k)) + modes%omega(k)*abs(x0(k)) + abs(modes%drift(k))
            of_v = rows%drag(j)*abs(v0(k)) + abs(modes%force(k)) + time*abs(modes%force_rate(k))
            if (rows%fastest(row) > 0) of_x = of_x + of_v/rows%fastest(row)
            of_v = of_v + modes%omega(k)*of_x
            total = total + abs(rows%of_x(j))*of_x + abs(rows%of_v(j))*of_v
         end do
         do h = 1, size(regime%ripple, 2)
            total = total + rows%ripple_size(row, h)*(h*regime%frequency)
         end do
      end associate
   end function size_of_rate

   !> A bound on the absolute second derivative of a row at the start of a flight, at any phase of
   !! the load.
   pure real(wp) function bound_second(regime, x0, v0, row) result(bound)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at the start.
      real(wp), intent(in) :: x0(:), v0(:)
      !> Number of the row.
      integer, intent(in) :: row
      real(wp) :: x1, v1
      integer :: h, j, k

      bound = 0
      associate (rows => regime%rows, modes => regime%modes)
         do j = rows%begins(row), rows%begins(row + 1) - 1
            k = rows%touched(j)
            x1 = v0(k) + modes%drift(k)
            v1 = -rows%stiffness(j)*x0(k) - rows%drag(j)*v0(k) + modes%force(k)
            bound = bound + (rows%of_x(j)*(v1 + modes%drift_rate(k)) + rows%of_v(j) &
               *(modes%force_rate(k) - rows%stiffness(j)*x1 - rows%drag(j)*v1))
         end do
      end associate
      bound = abs(bound)
      do h = 1, size(regime%ripple, 2)
         bound = bound + regime%rows%ripple_size(row, h)*(h*regime%frequency)**2
      end do
   end function bound_second

   !> A row and its first three derivatives at the start of a flight, without the harmonics of the
   !! load.
   pure subroutine free_derivatives(regime, x0, v0, row, d)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at the start.
      real(wp), intent(in) :: x0(:), v0(:)
      !> Number of the row.
      integer, intent(in) :: row
      !> The derivatives of order 0 to 3.
      real(wp), intent(out) :: d(0:3)
      real(wp) :: x1, v1, x2, v2, v3
      integer :: j, k

      d = [regime%rows%offset(row), regime%rows%offset_rate(row), 0.0_wp, 0.0_wp]
      associate (rows => regime%rows, modes => regime%modes)
         do j = rows%begins(row), rows%begins(row + 1) - 1
            k = rows%touched(j)
            associate (x => x0(k), v => v0(k), stiffness => rows%stiffness(j), &
               drag => rows%drag(j), of_x => rows%of_x(j), of_v => rows%of_v(j))
               x1 = v + modes%drift(k)
               v1 = -stiffness*x - drag*v + modes%force(k)
               x2 = v1 + modes%drift_rate(k)
               v2 = -stiffness*x1 - drag*v1 + modes%force_rate(k)
               v3 = -stiffness*x2 - drag*v2
               d = d + [of_x*x + of_v*v, of_x*x1 + of_v*v1, of_x*x2 + of_v*v2, of_x*v2 + of_v*v3]
            end associate
         end do
      end associate
   end subroutine free_derivatives

   !> The first time within a cell at which one row reaches a limit.
   pure subroutine search(regime, x0, v0, phase, x, v, turn, doubt, leaving, bound, begin, end, &
      longest, work, wall, time, speed, steps, complete)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at the start of the flight.
      real(wp), contiguous, intent(in) :: x0(:), v0(:)
      !> Load phase there (rad).
      real(wp), intent(in) :: phase
      !> (m) The pairs at the beginning of the cell.
      real(wp), contiguous, intent(in) :: x(:), v(:)
      !> (harmonics) e^(i h Omega t) there.
      complex(wp), intent(in) :: turn(:)
      !> The row, and which limits it may reach, as in `find_doubts`.
      integer, intent(in) :: doubt(2)
      !> How the row begins.
      type(leaving_type), intent(in) :: leaving
      !> Bound on the absolute fourth derivative of the row.
      real(wp), intent(in) :: bound
      !> Times between which to search: begin is the beginning of the cell.
      real(wp), intent(in) :: begin, end
      !> Longest step: the length of the cell, so that a short remainder of the cell is not mistaken
      !! for a contact.
      real(wp), intent(in) :: longest
      !> (m + side_by_side, 8) Room for pairs.
      real(wp), contiguous, intent(inout) :: work(:, :)
      !> Limit that is reached: +1 upper, -1 lower; 0 if none is.
      integer, intent(out) :: wall
      !> Time at which it is reached, and approach speed.
      real(wp), intent(out) :: time, speed
      !> Steps that it took.
      integer, intent(out) :: steps
      !> False if the search exceeded its step budget.
      logical, intent(out) :: complete
      type(series_type) :: series
      type(opening_type) :: opening

      time = begin
      steps = 0
      associate (row => doubt(1))
         opening%upper = regime%upper(row)
         opening%lower = regime%lower(row)
         if (row == leaving%row .and. begin <= 0 .and. (doubt(2) == 3 .or. &
            doubt(2) == merge(1, 2, leaving%wall > 0))) then
            opening%wall = leaving%wall
            opening%speed = leaving%speed
            opening%order = leaving%order
            opening%fourth = bound
            call expand(regime, x, v, turn, row, bound, begin, -1.0_wp, work, series)
            call new_opening(series, opening)
         else
            call expand(regime, x, v, turn, row, bound, begin, end - begin, work, series)
         end if
         do
            call follow(series, opening, doubt(2), bound, longest, end, time, steps, wall, speed)
            complete = steps < step_budget
            if (wall /= 0 .or. time > end .or. .not. complete) return
            call expand_at(regime, x0, v0, phase, row, bound, time, end - time, work, series)
         end do
      end associate
   end subroutine search

   !> The Taylor series of a row about a time, from pairs computed directly.
   pure subroutine expand_at(regime, x0, v0, phase, row, bound, t, wanted, work, series)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at the start of the flight.
      real(wp), contiguous, intent(in) :: x0(:), v0(:)
      !> Load phase there (rad).
      real(wp), intent(in) :: phase
      !> The row, and the bound on its absolute fourth derivative.
      integer, intent(in) :: row
      real(wp), intent(in) :: bound
      !> The time, and how far the series is wanted.
      real(wp), intent(in) :: t, wanted
      !> (m + side_by_side, 8) Room for pairs.
      real(wp), contiguous, intent(inout) :: work(:, :)
      !> The series.
      type(series_type), intent(out) :: series
      complex(wp) :: turn(size(regime%ripple, 2))
      integer :: h, j

      ! the pairs beyond those of the row are not used, except for the first one with factors of 0
      work(:min(1, size(x0)), 3:4) = 0
      do j = regime%rows%begins(row), regime%rows%begins(row + 1) - 1
         associate (k => regime%rows%touched(j))
            if (abs(regime%rows%of_x(j)) + abs(regime%rows%of_v(j)) > 0) then
               call advance_pair(regime%modes, k, t, x0(k), v0(k), work(k, 3), work(k, 4))
            end if
         end associate
      end do
      do h = 1, size(turn)
         turn(h) = turned(h*(phase + regime%frequency*t))
      end do
      call expand(regime, work(:, 3), work(:, 4), turn, row, bound, t, wanted, work, series)
   end subroutine expand_at

   !> The Taylor series of a row about a time.
   pure subroutine expand(regime, x0, v0, turn, row, bound, t, wanted, work, series)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at that time; only those of the row are used.
      real(wp), contiguous, intent(in) :: x0(:), v0(:)
      !> (harmonics) e^(i h Omega t) then.
      complex(wp), intent(in) :: turn(:)
      !> The row, and the bound on its absolute fourth derivative.
      integer, intent(in) :: row
      real(wp), intent(in) :: bound
      !> The time, and how far the series is wanted; below 0 with as many terms as possible.
      real(wp), intent(in) :: t, wanted
      !> (m + side_by_side, 8) Room for pairs.
      real(wp), contiguous, intent(inout) :: work(:, :)
      !> The series.
      type(series_type), intent(out) :: series
      real(wp) :: total(0:order), term, tolerance, size_now
      complex(wp) :: here
      integer :: begin, begun, h, i, j, k, n

      begin = regime%rows%begins(row)
      n = regime%rows%begins(row + 1) - begin
      total = 0
      total(0) = regime%rows%offset(row) + t*regime%rows%offset_rate(row)
      total(1) = regime%rows%offset_rate(row)
      size_now = abs(total(0))
      associate (rows => regime%rows, modes => regime%modes, x => work(:, 1), v => work(:, 2))
         ! of a row without pairs, as of a gap at rest, the offset is all
         if (n > 0 .and. rows%bare .and. modes%conserves .and. rows%wide) then
            call start_free_series_wide(n, size(x0), rows%runs(row), rows%touched(begin), &
               modes%stiffness, rows%of_x(begin), x0, v0, x, v, work(:, 5:6), total, size_now)
         else if (n > 0 .and. rows%bare .and. modes%conserves) then
            call start_free_series(n, size(x0), rows%runs(row), rows%touched(begin), &
               modes%stiffness, rows%of_x(begin), x0, v0, x, v, work(:, 5:6), total, size_now)
         else if (n > 0 .and. rows%wide) then
            call start_series_wide(n, size(x0), rows%runs(row), t, rows%touched(begin), &
               modes%stiffness, modes%damping, modes%drift, modes%drift_rate, modes%force, &
               modes%force_rate, rows%of_x(begin), rows%of_v(begin), x0, v0, x, v, work(:, 5:8), &
               total, size_now)
         else if (n > 0) then
            call start_series(n, size(x0), rows%runs(row), t, rows%touched(begin), &
               modes%stiffness, modes%damping, modes%drift, modes%drift_rate, modes%force, &
               modes%force_rate, rows%of_x(begin), rows%of_v(begin), x0, v0, x, v, work(:, 5:8), &
               total, size_now)
         end if
         begun = 2
         if (rows%grows) then
            call add_terms(rows, row, 2, 2, x, v, total)
            do j = 1, n
               k = rows%touched(begin + j - 1)
               x(j) = x(j) + modes%drift_rate(k)
               v(j) = v(j) + modes%force_rate(k)
               total(2) = total(2) + rows%of_x(begin + j - 1)*modes%drift_rate(k) &
                  + rows%of_v(begin + j - 1)*modes%force_rate(k)
            end do
            begun = 3
         end if
         do h = 1, size(turn)
            size_now = size_now + regime%rows%ripple_size(row, h)
         end do
         tolerance = 0.5_wp*epsilon(1.0_wp)*size_now
         series%last = order
         series%reach = -1
         if (wanted >= 0) then
            ! how many terms a bound on the omitted ones demands
            term = bound*wanted**4/24
            do i = 5, order + 1
               if (term <= tolerance) exit
               term = term*(rows%fastest(row)*wanted)*inverse(i)
            end do
            if (term <= tolerance) then
               series%last = max(3, i - 2)
               series%reach = wanted
            end if
         end if
         if (series%reach < 0) then
            call add_terms(rows, row, begun, 5, x, v, total)
            series%fifth = bound_of(regime, row, work(:n, 1), work(:n, 2), 5)
            call add_terms(rows, row, 6, order, x, v, total)
         else
            call add_terms(rows, row, begun, series%last, x, v, total)
         end if
      end associate
      do h = 1, size(turn)
         here = regime%ripple(row, h)*turn(h)
         total(0) = total(0) + here%re
         do i = 1, series%last
            here = here*cmplx(0.0_wp, h*regime%frequency, wp)
            total(i) = total(i) + here%re
         end do
      end do
      series%centre = t
      if (series%reach < 0) then
         series%beyond = bound_of(regime, row, work(:n, 1), work(:n, 2), order) &
            *regime%rows%fastest(row)
         series%reach = tolerated(tolerance, series%beyond, order + 1)
      end if
      series%c(:series%last) = total(:series%last)*inverse_factorial(:series%last)
   end subroutine expand

   !> Adds derivatives of a row, without what constant terms add to them.
   pure subroutine add_terms(rows, row, first, last, x, v, total)
      !> The rows, and the number of the row.
      type(rows_type), intent(in) :: rows
      integer, intent(in) :: row
      !> Orders of the derivatives that are added.
      integer, intent(in) :: first, last
      !> In: derivatives of its pairs of order first - 1. Out: of order last.
      real(wp), contiguous, intent(inout) :: x(:), v(:)
      !> In and out: the derivatives of the row.
      real(wp), intent(inout) :: total(0:last)

      associate (i => rows%begins(row), j => rows%begins(row + 1) - 1)
         if (rows%wide) then
            call add_derivatives_wide(j - i + 1, first, last, rows%bare, rows%stiffness(i:j), &
               rows%drag(i:j), rows%of_x(i:j), rows%of_v(i:j), x, v, total)
         else
            call add_derivatives(j - i + 1, first, last, rows%bare, rows%stiffness(i:j), &
               rows%drag(i:j), rows%of_x(i:j), rows%of_v(i:j), x, v, total)
         end if
      end associate
   end subroutine add_terms

   !> A bound on the absolute derivative of a row of a given order >= 2, from now on.
   pure real(wp) function bound_of(regime, row, x, v, n) result(bound)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> The row.
      integer, intent(in) :: row
      !> Derivatives of that order of its pairs.
      real(wp), intent(in) :: x(:), v(:)
      !> The order.
      integer, intent(in) :: n
      real(wp) :: of_x, of_v
      integer :: h, j

      bound = 0
      do j = 1, size(x)
         associate (i => regime%rows%begins(row) + j - 1)
            call bound_on(regime%rows%stiffness(i), regime%rows%drag(i), x(j), v(j), of_x, &
               of_v)
            bound = bound + abs(regime%rows%of_x(i))*of_x + abs(regime%rows%of_v(i))*of_v
         end associate
      end do
      do h = 1, size(regime%ripple, 2)
         bound = bound + regime%rows%ripple_size(row, h)*(h*regime%frequency)**n
      end do
   end function bound_of

end module vi_channels
