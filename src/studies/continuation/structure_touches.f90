!> Where the gaps of a structure, or other rows with limits, are least within a flight or a rest.
module vi_structure_touches
   use vi_kinds, only: wp
   use vi_modes, only: advance
   use vi_motion_family, only: condition_type
   use vi_rows, only: row_values, rows_type
   use vi_structure, only: regime_type
   implicit none (type, external)
   private

   public :: least_gap, rows_at, touch_value

   !> The least gap counts up to this value, in units of length.
   real(wp), parameter, public :: wide = 1

contains

   !> The least gap within a flight: at stationary points, and at its end of channels that are not
   !! in contact there. Gaps that rest are left out.
   !!
   !! With stops and friction, where accelerations jump, what has a limit is looked at just after
   !! the beginning, too.
   pure subroutine least_gap(regime, x, v, time, duration, begins, ends, units, touch, gap, last)
      !> The regime of the flight or rest.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at the beginning, the time there, and the duration.
      real(wp), intent(in) :: x(:), v(:), time, duration
      !> What is at its limit at the beginning and at the end: gaps, and the friction along them.
      integer, intent(in) :: begins(:), ends(:)
      !> (rows) The unit of each.
      real(wp), intent(in) :: units(:)
      !> In and out: the channel, with the sign of the wall, and the share of the duration are set.
      type(condition_type), intent(inout) :: touch
      !> The gap, in its unit; negative beyond the wall.
      real(wp), intent(out) :: gap
      !> With stops and friction: the row that ends the flight, with the sign of its limit.
      integer, intent(in), optional :: last
      !> Nodes per time unit of the structure, and limits on their number.
      integer, parameter :: density = 3, least = 12, most = 4000
      real(wp), allocatable, dimension(:, :) :: y, rate
      real(wp) :: value, step, h
      type(condition_type) :: here
      integer :: i, k, nodes, number, row, wall
      logical :: holds

      nodes = max(least, min(most, ceiling(density*duration/regime%unit)))
      associate (rows => size(regime%upper))
         allocate (y(rows, 0:nodes), rate(rows, 0:nodes))
      end associate
      do k = 0, nodes
         call rows_at(regime, regime%rows, x, v, time, k*duration/nodes, y(:, k), rate(:, k))
      end do
      h = duration/nodes
      gap = wide
      touch%side = 0
      touch%share = 0
      do row = 1, size(y, 1)
         do i = 1, 2
            wall = 3 - 2*i
            number = abs(merge(regime%upper_gap(row), regime%lower_gap(row), wall > 0))
            if (number == 0 .or. any(regime%resting == number)) cycle
            holds = row > size(units) - size(regime%held)
            do k = 0, nodes
               here = touch
               here%side = wall*row
               if (k == 0 .and. present(last)) then
                  ! a force that rises to the limit at which it ends the flight is below it as
                  ! long as the flight has a duration
                  if ((here%side /= last .or. wall*rate(row, 0) < 0) .and. (holds .or. &
                     all(begins /= number))) then
                     value = gap_at(regime, units(row), here%side, y(row, 0))
                     here%share = 0
                     if (value < gap) then
                        gap = value
                        touch = here
                     end if
                  end if
               end if
               ! an impact leaves its wall; without restitution its speed is 0, up to rounding
               if (k == 0 .and. any(begins == number)) cycle
               if (k < nodes) then
                  ! the gap has a minimum between two nodes
                  if (wall*rate(row, k) > 0 .and. wall*rate(row, k + 1) <= 0) then
                     step = rate(row, k)/(rate(row, k) - rate(row, k + 1))
                     ! cubic interpolation decides which minima are refined
                     value = hermite(y(row, k), y(row, k + 1), h*rate(row, k), h*rate(row, k + 1), &
                        step)
                     value = gap_at(regime, units(row), here%side, value)
                     if (value < gap + 0.1_wp) then
                        here%share = (k + step)/nodes
                        value = touch_value(regime, x, v, time, duration, units, here)
                        if (value < gap) then
                           gap = value
                           touch = here
                        end if
                     end if
                  end if
                  cycle
               end if
               ! the next impact comes first: before it all other gaps are open
               if (any(ends == number) .and. .not. holds) cycle
               if (present(last)) then
                  if (here%side == last) cycle
               end if
               here%share = 1
               value = gap_at(regime, units(row), here%side, y(row, k))
               if (value >= gap) cycle
               gap = value
               touch = here
            end do
         end do
      end do
   end subroutine least_gap

   !> Cubic interpolation between two nodes.
   pure real(wp) function hermite(a, b, slope_a, slope_b, t) result(value)
      !> Values and slopes at both ends, and the share of the way.
      real(wp), intent(in) :: a, b, slope_a, slope_b, t

      value = a + t*(slope_a + t*(3*(b - a) - 2*slope_a - slope_b + t*(2*(a - b) + slope_a &
         + slope_b)))
   end function hermite

   !> A gap in its unit.
   pure real(wp) function gap_at(regime, unit, side, y) result(gap)
      !> The regime, and the unit.
      type(regime_type), intent(in) :: regime
      real(wp), intent(in) :: unit
      !> The channel with the sign of the wall.
      integer, intent(in) :: side
      !> The position of the channel.
      real(wp), intent(in) :: y

      if (side > 0) then
         gap = regime%upper(side) - y
      else
         gap = y - regime%lower(-side)
      end if
      gap = gap/unit
   end function gap_at

   !> The gap at the stationary point near a given share of the flight; at its ends, the gap there.
   pure real(wp) function touch_value(regime, x, v, time, duration, units, touch) result(gap)
      !> The regime of the flight or rest.
      type(regime_type), intent(in) :: regime
      !> As of `least_gap`.
      real(wp), intent(in) :: x(:), v(:), time, duration, units(:)
      !> Channel and wall, and approximate share of the duration.
      type(condition_type), intent(in) :: touch
      real(wp), dimension(size(regime%upper)) :: y, rate, ahead, unused
      real(wp) :: t, step, limit, h
      integer :: i, row

      row = abs(touch%side)
      gap = wide
      if (row == 0) return
      t = touch%share*duration
      if (touch%share > 0 .and. touch%share < 1) then
         limit = 0.2_wp*regime%unit
         h = 1.0e-3_wp*regime%unit
         do i = 1, 8
            call rows_at(regime, regime%rows, x, v, time, t, y, rate)
            call rows_at(regime, regime%rows, x, v, time, t + h, unused, ahead)
            step = ahead(row) - rate(row)
            if (.not. abs(step) > 0) exit
            step = -h*rate(row)/step
            t = t + max(-limit, min(limit, step))
            ! an error of the time changes the gap by its square
            if (abs(step) < 1.0e-9_wp*regime%unit) exit
         end do
      end if
      call rows_at(regime, regime%rows, x, v, time, t, y, rate)
      gap = gap_at(regime, units(row), touch%side, y(row))
   end function touch_value

   !> The values and rates of rows at a time after the beginning of a flight.
   pure subroutine rows_at(regime, rows, x, v, time, t, y, rate)
      !> The regime of the flight or rest.
      type(regime_type), intent(in) :: regime
      !> Its rows: those of the channels, or of the coordinates.
      type(rows_type), intent(in) :: rows
      !> (m) The pairs at the beginning, and the time there.
      real(wp), intent(in) :: x(:), v(:), time
      !> Time since then.
      real(wp), intent(in) :: t
      !> (rows) Values and rates.
      real(wp), contiguous, intent(out) :: y(:), rate(:)
      real(wp), dimension(size(x)) :: x_then, v_then
      complex(wp) :: turn(size(regime%ripple, 2))
      real(wp) :: phase
      integer :: h

      call advance(regime%modes, t, x, v, x_then, v_then)
      phase = regime%frequency*(time + t)
      do h = 1, size(turn)
         turn(h) = cmplx(cos(h*phase), sin(h*phase), wp)
      end do
      call row_values(rows, regime%frequency, x_then, v_then, turn, y, rate)
   end subroutine rows_at

end module vi_structure_touches
