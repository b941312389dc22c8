!> Structures under a record: forces that are linear between samples.
!!
!! Within an interval between two samples the motion is closed form, and no flight crosses a sample.
!! Intervals without an event are passed one by one with one table.
module vi_structure_record
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   use vi_lane_rows, only: add_product, add_products
   use vi_modes, only: advance_in_place, modes_type
   use vi_structure, only: load_type, regime_type
   implicit none (type, external)
   private

   public :: advance_recorded, bound_interval, forces_at, modal_forces, pass_intervals, rows_now, &
      set_forces

contains

   !> The forces of a record at a time, and the rates at which they change from there.
   pure subroutine forces_at(load, cycle, elapsed, force, rate)
      !> The load, with a record.
      type(load_type), intent(in) :: load
      !> Whole intervals before the time, and the remainder.
      integer(int64), intent(in) :: cycle
      real(wp), intent(in) :: elapsed
      !> (n)
      real(wp), intent(out) :: force(:), rate(:)

      force = 0
      rate = 0
      if (cycle >= size(load%record, 2) - 1) return
      associate (from => load%record(:, cycle + 1), to => load%record(:, cycle + 2))
         rate = (to - from)/load%step
         force = from + elapsed*rate
      end associate
   end subroutine forces_at

   !> Sets the forces of a regime for a flight that begins at a given time.
   pure subroutine set_forces(regime, load, cycle, elapsed)
      !> In and out: the regime.
      type(regime_type), intent(inout) :: regime
      !> The load, with a record.
      type(load_type), intent(in) :: load
      !> Whole intervals before the time, and the remainder.
      integer(int64), intent(in) :: cycle
      real(wp), intent(in) :: elapsed
      real(wp) :: force(size(load%constant)), rate(size(load%constant))
      integer :: m, n, rows

      call forces_at(load, cycle, elapsed, force, rate)
      m = size(regime%base_force)
      n = size(force)
      rows = size(regime%base_offset)
      associate (modes => regime%modes, r => regime%rows)
         modes%drift(:) = regime%base_drift
         modes%drift_rate(:) = 0
         modes%force(:) = regime%base_force
         modes%force_rate(:) = 0
         call add_product(m, n, regime%to_force, force, modes%force)
         call add_product(m, n, regime%to_force, rate, modes%force_rate)
         r%grows = .true.
         r%offset(:) = regime%base_offset
         r%offset_rate(:) = 0
         if (regime%drifts) then
            call add_product(m, n, regime%to_drift, force, modes%drift)
            call add_product(m, n, regime%to_drift, rate, modes%drift_rate)
         end if
         if (size(regime%held) > 0) then
            call add_product(rows, n, regime%to_rows, force, r%offset)
            call add_product(rows, n, regime%to_rows, rate, r%offset_rate)
         end if
         r%rate_offset(:) = r%offset_rate
         r%rate_offset_rate(:) = 0
         call add_product(rows, m, regime%position, modes%drift, r%rate_offset)
         call add_product(rows, m, regime%position, modes%drift_rate, r%rate_offset_rate)
         if (.not. r%by_position) then
            call add_product(rows, m, regime%velocity, modes%force, r%rate_offset)
            call add_product(rows, m, regime%velocity, modes%force_rate, r%rate_offset_rate)
         end if
      end associate
   end subroutine set_forces

   !> Passes whole intervals that are proved to be without an event.
   pure subroutine pass_intervals(regime, load, cycle, last, x, v)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> The load, with a record.
      type(load_type), intent(in) :: load
      !> In: the interval that begins. Out: the one whose beginning is reached.
      integer(int64), intent(inout) :: cycle
      !> The interval at whose beginning to stop.
      integer(int64), intent(in) :: last
      !> (m) In and out: the pairs at the beginning of the interval.
      real(wp), contiguous, intent(inout) :: x(:), v(:)
      !> x, v, p, f of the pairs, and rows and rates, at the beginning and at the end, in turns.
      real(wp) :: pairs(size(x), 4, 2), values(size(regime%upper), 2, 2), &
         direct(size(regime%upper)), bounds(4), length
      integer :: m, next, now

      if (.not. cycle < min(last, int(size(load%record, 2) - 1, int64))) return
      length = load%step
      direct = 0
      m = size(x)
      now = 1
      pairs(:, 1, now) = x
      pairs(:, 2, now) = v
      call modal_forces(regime, load%record(:, cycle + 1), pairs(:, 3, now), pairs(:, 4, now))
      call rows_now(regime, load%record(:, cycle + 1), pairs(:, :, now), values(:, :, now))
      do while (cycle < min(last, int(size(load%record, 2) - 1, int64)))
         next = 3 - now
         associate (to => load%record(:, cycle + 2))
            call modal_forces(regime, to, pairs(:, 3, next), pairs(:, 4, next))
            call pass_one(m, regime%interval%map, length, pairs(:, 1, now), pairs(:, 2, now), &
               pairs(:, 3, now), pairs(:, 4, now), pairs(:, 3, next), pairs(:, 4, next), &
               pairs(:, 1, next), pairs(:, 2, next))
            call rows_now(regime, to, pairs(:, :, next), values(:, :, next))
            call bound_interval(regime%modes, m, length, pairs(:, :, now), pairs(:, :, next), &
               bounds)
            if (size(regime%held) > 0) direct = matmul(regime%to_rows, &
               to - load%record(:, cycle + 1))/length
            if (.not. all_clear(regime, direct, length, values(:, 1, now), values(:, 2, now), &
               values(:, 1, next), values(:, 2, next), bounds)) exit
         end associate
         now = next
         cycle = cycle + 1
      end do
      x = pairs(:, 1, now)
      v = pairs(:, 2, now)
   end subroutine pass_intervals

   !> p and f of all pairs at a sample.
   pure subroutine modal_forces(regime, force, p, f)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (n) The forces.
      real(wp), contiguous, intent(in) :: force(:)
      !> (m)
      real(wp), contiguous, intent(out) :: p(:), f(:)

      f = regime%base_force
      call add_product(size(f), size(force), regime%to_force, force, f)
      p = regime%base_drift
      if (regime%drifts) call add_product(size(p), size(force), regime%to_drift, force, p)
   end subroutine modal_forces

   !> The pairs after an interval.
   pure subroutine pass_one(m, map, length, x, v, p, f, p_next, f_next, x_next, v_next)
      !> Number of pairs.
      integer, intent(in) :: m
      !> The table of an interval, as in `interval_type`, and its length.
      real(wp), intent(in) :: map(12, m), length
      !> The pairs, p and f at its beginning; p and f at its end.
      real(wp), dimension(m), intent(in) :: x, v, p, f, p_next, f_next
      !> The pairs at its end.
      real(wp), intent(out) :: x_next(m), v_next(m)
      real(wp) :: f_rate, inverse, p_rate
      integer :: k

      inverse = 1/length
      do k = 1, m
         f_rate = (f_next(k) - f(k))*inverse
         p_rate = (p_next(k) - p(k))*inverse
         x_next(k) = map(1, k)*x(k) + map(2, k)*v(k) + map(3, k)*f(k) + map(4, k)*f_rate &
            + map(5, k)*p(k) + map(6, k)*p_rate
         v_next(k) = map(7, k)*x(k) + map(8, k)*v(k) + map(9, k)*f(k) + map(10, k)*f_rate &
            + map(11, k)*p(k) + map(12, k)*p_rate
      end do
   end subroutine pass_one

   !> The rows at a sample, and their rates without the part due to the change of forces.
   pure subroutine rows_now(regime, force, pairs, values)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (n) The forces.
      real(wp), contiguous, intent(in) :: force(:)
      !> (m, 4) x, v, p and f of the pairs.
      real(wp), contiguous, intent(in) :: pairs(:, :)
      !> (rows, 2) The rows and their rates.
      real(wp), contiguous, intent(out) :: values(:, :)
      integer :: m, rows

      rows = size(values, 1)
      m = size(pairs, 1)
      values(:, 1) = regime%base_offset
      values(:, 2) = 0
      if (size(regime%held) > 0) call add_product(rows, size(force), regime%to_rows, force, &
         values(:, 1))
      if (regime%rows%by_position) then
         call add_products(rows, m, regime%position, pairs(:, 1), pairs(:, 2), values(:, 1), &
            values(:, 2))
      else
         call add_product(rows, m, regime%position, pairs(:, 1), values(:, 1))
         call add_product(rows, m, regime%velocity, pairs(:, 2), values(:, 1))
         call add_rates(regime, pairs(:, 1), pairs(:, 2), pairs(:, 3), pairs(:, 4), values(:, 2))
      end if
   end subroutine rows_now

   !> Adds the rates of rows that depend on v.
   pure subroutine add_rates(regime, x, v, p, f, rate)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs, p and f.
      real(wp), dimension(:), contiguous, intent(in) :: x, v, p, f
      !> (rows) In and out: the rates.
      real(wp), contiguous, intent(inout) :: rate(:)
      real(wp) :: x_rate(size(x)), v_rate(size(x))

      x_rate = v + p
      v_rate = f - regime%modes%stiffness*x - 2*regime%modes%damping*v
      call add_product(size(rate), size(x), regime%position, x_rate, rate)
      call add_product(size(rate), size(x), regime%velocity, v_rate, rate)
   end subroutine add_rates

   !> Roots of sums of squares over the pairs.
   pure subroutine bound_interval(modes, m, length, now, next, bounds)
      !> The pairs, and their number.
      type(modes_type), intent(in) :: modes
      integer, intent(in) :: m
      !> Length of the interval.
      real(wp), intent(in) :: length
      !> x, v, p and f at its beginning and at its end.
      real(wp), dimension(m, 4), intent(in) :: now, next
      !> Of bounds on the fourth derivatives of x and of v; of the sizes of x and of v.
      real(wp), intent(out) :: bounds(4)
      real(wp) :: a, b, inverse, of_x, of_v, p_rate, f_rate, size_x, size_v, squares
      integer :: k

      inverse = 1/length
      of_x = 0
      of_v = 0
      size_x = 0
      size_v = 0
      do k = 1, m
         associate (stiffness => modes%stiffness(k), drag => 2*modes%damping(k), x => now(k, 1), &
            v => now(k, 2), p => now(k, 3), f => now(k, 4))
            p_rate = (next(k, 3) - p)*inverse
            f_rate = (next(k, 4) - f)*inverse
            ! derivatives of order 1 to 4
            a = f - stiffness*x - drag*v
            b = f_rate - stiffness*(v + p) - drag*a
            a = a + p_rate
            squares = -stiffness*a - drag*b
            a = b
            b = squares
            squares = -stiffness*a - drag*b
            a = b
            b = squares
            size_x = size_x + (abs(x) + length*abs(v))**2
            size_v = size_v + (abs(v) + length*(abs(f) + abs(next(k, 4))))**2
            squares = b**2 + stiffness*a**2
            of_v = of_v + squares
            of_x = of_x + merge(squares*modes%inverse(k)**2, a**2, stiffness > 0)
         end associate
      end do
      bounds = sqrt([of_x, of_v, size_x, size_v])
   end subroutine bound_interval

   !> Whether all rows stay within their limits over an interval: as in vi_channels, by Bernstein
   !! coefficients, and with the inequality of Cauchy and Schwarz for sums of bounds.
   pure logical function all_clear(regime, direct, length, y, rate, y_next, rate_next, bounds)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (rows) The part of the rates due to the change of forces.
      real(wp), contiguous, intent(in) :: direct(:)
      !> Length of the interval.
      real(wp), intent(in) :: length
      !> (rows) Values and the other part of the rates, at both ends.
      real(wp), dimension(:), contiguous, intent(in) :: y, rate, y_next, rate_next
      !> As in `bound_interval`.
      real(wp), intent(in) :: bounds(4)
      real(wp), parameter :: share = 16*epsilon(1.0_wp)
      real(wp) :: middle, reserve, second, third, fourth
      integer :: i

      all_clear = .false.
      do i = 1, size(y)
         associate (rows => regime%rows)
            middle = (rows%position_norm(i)*bounds(1) + rows%velocity_norm(i)*bounds(2)) &
               *(length*length)**2/144
            reserve = share*(rows%constant_size(i) + abs(y(i)) + abs(y_next(i)) &
               + rows%position_norm(i)*bounds(3) + rows%velocity_norm(i)*bounds(4))
         end associate
         second = y(i) + 0.25_wp*length*(rate(i) + direct(i))
         third = 0.5_wp*(y(i) + y_next(i)) + length/6*(rate(i) - rate_next(i))
         fourth = y_next(i) - 0.25_wp*length*(rate_next(i) + direct(i))
         associate (upper => regime%upper(i) - reserve, lower => regime%lower(i) + reserve)
            if (.not. (max(y(i), second, third + middle, fourth, y_next(i)) < upper .and. &
               min(y(i), second, third - middle, fourth, y_next(i)) > lower)) return
         end associate
      end do
      all_clear = .true.
   end function all_clear

   !> Advances pairs over any number of intervals, without regard to gaps.
   pure subroutine advance_recorded(regime, load, cycle, elapsed, to_cycle, to_elapsed, x, v)
      !> In and out: the regime, whose forces are set.
      type(regime_type), intent(inout) :: regime
      !> The load, with a record.
      type(load_type), intent(in) :: load
      !> The time: whole intervals before it, and the remainder.
      integer(int64), intent(in) :: cycle
      real(wp), intent(in) :: elapsed
      !> The time to reach, not before it.
      integer(int64), intent(in) :: to_cycle
      real(wp), intent(in) :: to_elapsed
      !> (m) In and out: the pairs.
      real(wp), contiguous, intent(inout) :: x(:), v(:)
      real(wp), dimension(size(x)) :: x_next, v_next, p, f, p_next, f_next
      real(wp) :: begin
      integer(int64) :: now

      now = cycle
      begin = elapsed
      if (now < to_cycle .and. begin > 0 .and. now < size(load%record, 2) - 1) then
         call fly(regime, load, now, begin, load%step - begin, x, v)
         now = now + 1
         begin = 0
      end if
      if (now < min(to_cycle, int(size(load%record, 2) - 1, int64))) then
         call modal_forces(regime, load%record(:, now + 1), p, f)
         do while (now < min(to_cycle, int(size(load%record, 2) - 1, int64)))
            call modal_forces(regime, load%record(:, now + 2), p_next, f_next)
            call pass_one(size(x), regime%interval%map, load%step, x, v, p, f, p_next, f_next, &
               x_next, v_next)
            x = x_next
            v = v_next
            p = p_next
            f = f_next
            now = now + 1
         end do
      end if
      call fly(regime, load, now, begin, real(to_cycle - now, wp)*load%step + to_elapsed - begin, &
         x, v)
   end subroutine advance_recorded

   !> Advances pairs directly.
   pure subroutine fly(regime, load, cycle, elapsed, time, x, v)
      !> In and out: the regime, whose forces are set.
      type(regime_type), intent(inout) :: regime
      !> The load, with a record.
      type(load_type), intent(in) :: load
      !> When it begins.
      integer(int64), intent(in) :: cycle
      real(wp), intent(in) :: elapsed
      !> How long, within an interval.
      real(wp), intent(in) :: time
      !> (m) In and out: the pairs.
      real(wp), contiguous, intent(inout) :: x(:), v(:)

      if (.not. time > 0) return
      call set_forces(regime, load, cycle, elapsed)
      call advance_in_place(regime%modes, time, x, v)
   end subroutine fly

end module vi_structure_record
