!> The conditions under which a motion of a structure is stable and admissible, as numbers that are
!! positive where they are met; for `vi_conditions`.
!!
!! With multipliers lambda_i, the numbers of fold, flip and Neimark-Sacker have the signs of the
!! products of all 1 - lambda_i, of all 1 + lambda_i, and of all 1 - lambda_i lambda_j with i < j.
!! Their magnitude is that of the two least factors, which does not underflow for large structures;
!! of two, since two multipliers that meet are not smooth, unlike their symmetric functions.
module vi_structure_conditions
   use vi_family, only: add_distance_slope, repetition_distance
   use vi_frame, only: condition_at, condition_type, edge, flip, fold, frame_type, grazing, &
      neimark_sacker, repetition, zero_approach
   use vi_kinds, only: wp
   use vi_modes, only: advance
   use vi_rows, only: row_values
   use vi_spectrum, only: outside_circle, spectrum_type
   use vi_structure_family, only: flight_duration, member_multipliers, member_type, move_member, &
      set_flights, set_member
   use vi_structure_together, only: multipliers_beside
   implicit none (type, external)
   private

   public :: structure_condition, structure_conditions, structure_slope

   !> The least gap counts up to this value, in units of length of the family.
   real(wp), parameter :: wide = 1

contains

   !> The values of all conditions; -1 where there is no such motion.
   pure subroutine structure_conditions(frame, unknowns, c, values, found, spectrum)
      !> The family, its repetitions, and its edges.
      type(frame_type), intent(in) :: frame
      !> Unknowns of the motion, and the parameters as shares.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> (m) Value of each condition, positive where it is met.
      real(wp), intent(out) :: values(:)
      !> (m) The conditions; grazing with its wall and the share of the flight.
      type(condition_type), intent(out) :: found(:)
      !> The multipliers.
      type(spectrum_type), intent(out) :: spectrum
      type(member_type) :: member
      real(wp) :: three(3, 0:1)
      integer :: j

      call set_member(frame%structure, frame%family, unknowns, c(:size( &
         frame%structure%path%changes)), member)
      values = -1
      if (member%exists) then
         call set_flights(frame%family, member)
         call stability_values(frame, unknowns, member, three, spectrum)
         if (.not. frame%every_crossing .and. all(three > 0)) then
            ! only stable motions are inside
            if (outside_circle(spectrum, 0) > 0) three(neimark_sacker, 0) = &
               -three(neimark_sacker, 0)
         end if
      end if
      do j = 1, size(values)
         found(j) = condition_at(frame, j)
         associate (condition => found(j))
            if (condition%kind == edge) then
               values(j) = condition%side*(c(condition%index) - condition%bound)
            else if (.not. member%exists) then
               values(j) = -1
            else if (condition%kind == grazing) then
               call gap_of_flight(frame, member, condition, values(j))
            else if (condition%kind <= neimark_sacker) then
               values(j) = three(condition%kind, min(condition%index, 1))
            else
               values(j) = simple_value(frame, unknowns, member, condition)
            end if
         end associate
      end do
   end subroutine structure_conditions

   !> The value of one condition; for grazing, at the stationary point given in it.
   pure real(wp) function structure_condition(frame, unknowns, c, condition) result(value)
      !> The family, its repetitions, and its edges.
      type(frame_type), intent(in) :: frame
      !> Unknowns of the motion, and the parameters as shares.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> The condition, not an edge.
      type(condition_type), intent(in) :: condition
      type(member_type) :: member

      call set_member(frame%structure, frame%family, unknowns, c(:size( &
         frame%structure%path%changes)), member)
      call value_of_member(frame, unknowns, member, condition, value)
   end function structure_condition

   !> The value of one condition, and its derivatives by central differences.
   pure subroutine structure_slope(frame, unknowns, c, condition, active, member, value, slope)
      !> The family, its repetitions, and its edges.
      type(frame_type), intent(in) :: frame
      !> (m) Unknowns of the motion, and the parameters as shares.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> The condition, not an edge.
      type(condition_type), intent(in) :: condition
      !> The parameters of which the derivatives are wanted.
      integer, intent(in) :: active(:)
      !> In and out: the member with these unknowns and parameters; its flights are others on
      !! return.
      type(member_type), intent(inout) :: member
      !> The value.
      real(wp), intent(out) :: value
      !> (m + active) The derivatives by the unknowns and by these parameters.
      real(wp), intent(out) :: slope(:)
      real(wp), parameter :: h = 1.0e-6_wp
      type(member_type) :: near
      real(wp) :: moved(size(unknowns)), shares(size(frame%structure%path%changes)), both(2)
      integer :: i, j, m

      m = size(unknowns)
      shares = c(:size(shares))
      slope = 0
      do j = 1, size(active)
         do i = 1, 2
            shares(active(j)) = c(active(j)) + (3 - 2*i)*h
            call set_member(frame%structure, frame%family, unknowns, shares, near)
            call value_of_member(frame, unknowns, near, condition, both(i))
         end do
         shares(active(j)) = c(active(j))
         slope(m + j) = (both(1) - both(2))/(2*h)
      end do
      call value_of_member(frame, unknowns, member, condition, value)
      if (.not. member%exists) return
      if (condition%kind == zero_approach) then
         slope(condition%index) = sign(1, frame%family%sides(condition%index))
      else if (condition%kind == repetition) then
         call add_distance_slope(frame%family, frame%repetitions(condition%index), unknowns, &
            1.0_wp, slope)
      else
         do j = 1, m
            do i = 1, 2
               moved = unknowns
               moved(j) = unknowns(j) + (3 - 2*i)*h
               call move_member(frame%structure, frame%family, moved, member)
               call value_of_member(frame, moved, member, condition, both(i))
            end do
            slope(j) = (both(1) - both(2))/(2*h)
         end do
         call move_member(frame%structure, frame%family, unknowns, member)
      end if
   end subroutine structure_slope

   !> The value of one condition of a member; -1 if there is none.
   pure subroutine value_of_member(frame, unknowns, member, condition, value)
      !> The family, and its repetitions.
      type(frame_type), intent(in) :: frame
      !> Unknowns of the motion.
      real(wp), intent(in) :: unknowns(:)
      !> In and out: the member; its flights are set if they are needed.
      type(member_type), intent(inout) :: member
      !> The condition, not an edge.
      type(condition_type), intent(in) :: condition
      !> The value.
      real(wp), intent(out) :: value
      type(spectrum_type) :: spectrum
      real(wp) :: three(3, 0:1)

      value = -1
      if (.not. member%exists) return
      select case (condition%kind)
      case (fold, flip, neimark_sacker)
         call set_flights(frame%family, member)
         call stability_values(frame, unknowns, member, three, spectrum)
         value = three(condition%kind, min(condition%index, 1))
      case (grazing)
         call set_flights(frame%family, member)
         value = touch_value(frame, member, condition)
      case default
         value = simple_value(frame, unknowns, member, condition)
      end select
   end subroutine value_of_member

   !> The value of an approach speed or of the distance to a motion that repeats itself.
   pure real(wp) function simple_value(frame, unknowns, member, condition) result(value)
      !> The family, and its repetitions.
      type(frame_type), intent(in) :: frame
      !> Unknowns of the motion.
      real(wp), intent(in) :: unknowns(:)
      !> The motion.
      type(member_type), intent(in) :: member
      !> The condition.
      type(condition_type), intent(in) :: condition

      if (condition%kind == zero_approach) then
         value = member%speeds(condition%index)/frame%structure%speed
      else
         value = repetition_distance(frame%family, frame%repetitions(condition%index), unknowns) &
            - condition%bound
      end if
   end function simple_value

   !> The numbers of fold, flip and Neimark-Sacker.
   pure subroutine stability_values(frame, unknowns, member, values, spectrum)
      !> The family, and its repetitions.
      type(frame_type), intent(in) :: frame
      !> Unknowns of the motion.
      real(wp), intent(in) :: unknowns(:)
      !> The motion, with its flights.
      type(member_type), intent(in) :: member
      !> (3, 0:1) The numbers of the family, and those of disturbances after which its impacts at
      !! one instant occur one by one; 0 where an impact has no approach speed.
      real(wp), intent(out) :: values(:, 0:)
      !> The multipliers.
      type(spectrum_type), intent(out) :: spectrum
      complex(wp), allocatable :: beside(:)
      real(wp) :: signs(size(frame%family%sides))
      integer :: i

      values = 0
      call member_multipliers(frame%family, member, spectrum%multipliers, spectrum%regular)
      if (.not. spectrum%regular) return
      ! where an approach speed passes zero, a multiplier passes infinity and another one zero
      signs = sign(1.0_wp, member%speeds(:size(signs)))
      call numbers_of(spectrum%multipliers, product(signs), values(:, 0))
      values(:, 1) = 1
      associate (s => frame%structure)
         if (allocated(s%impact_of)) then
            call multipliers_beside(s, member, beside, spectrum%regular)
            if (.not. spectrum%regular) return
            call numbers_of(beside, product([(signs(modulo(s%impact_of(i) - 1, size(signs)) + 1), &
               i=1, size(s%impact_of))])*product(sign(1.0_wp, member%speeds)), values(:, 1))
            spectrum%multipliers = [spectrum%multipliers, beside]
         end if
      end associate
      ! a multiplier approaches 1 where the motion repeats itself, as the square of the distance
      do i = 1, size(frame%repetitions)
         values(fold, 0) = values(fold, 0)/max(0.1_wp*frame%apart, &
            repetition_distance(frame%family, frame%repetitions(i), unknowns))**2
      end do
   end subroutine stability_values

   !> The three numbers of some multipliers.
   pure subroutine numbers_of(lambda, continued, values)
      !> The multipliers; conjugate ones are in succession.
      complex(wp), intent(in) :: lambda(:)
      !> -1 where an odd number of them has passed infinity.
      real(wp), intent(in) :: continued
      !> Those of fold, flip and Neimark-Sacker.
      real(wp), intent(out) :: values(3)
      real(wp) :: least(2, 3)
      logical :: one, two
      integer :: i, j

      values = 1
      least = huge(1.0_wp)
      do i = 1, size(lambda)
         one = .not. abs(lambda(i)%im) > 0
         call include(lambda(i), one, values(fold), least(:, fold))
         call include(-lambda(i), one, values(flip), least(:, flip))
         do j = i + 1, size(lambda)
            two = one .and. .not. abs(lambda(j)%im) > 0
            ! DGEEV gives conjugate pairs in succession
            if (j == i + 1 .and. lambda(i)%im > 0) two = .true.
            call include(lambda(i)*lambda(j), two, values(neimark_sacker), &
               least(:, neimark_sacker))
         end do
      end do
      values = values*product(least, 1, least < huge(1.0_wp))
      values([fold, flip]) = continued*values([fold, flip])
   end subroutine numbers_of

   !> Includes a factor 1 - z in the sign of a product and among its two least factors.
   pure subroutine include(z, alone, sign_of, least)
      !> z.
      complex(wp), intent(in) :: z
      !> Whether z is real; otherwise the conjugate factor follows, and their product is positive.
      logical, intent(in) :: alone
      !> In and out: the sign, and the two least |1 - z|/(1 + |z|) in ascending order.
      real(wp), intent(inout) :: sign_of, least(2)
      real(wp) :: factor

      factor = abs(1 - z)/(1 + abs(z))
      if (alone) then
         factor = abs(1 - z%re)/(1 + abs(z%re))
         if (z%re > 1) sign_of = -sign_of
      end if
      if (factor < least(1)) then
         least = [factor, least(1)]
      else
         least(2) = min(least(2), factor)
      end if
   end subroutine include

   !> The least gap within a flight: at stationary points, and at its end of channels that are not
   !! in contact there.
   pure subroutine gap_of_flight(frame, member, touch, gap)
      !> The family.
      type(frame_type), intent(in) :: frame
      !> The motion, with its flights.
      type(member_type), intent(in) :: member
      !> In: the flight. Out: also the channel, with the sign of the wall, and the share of the
      !! duration.
      type(condition_type), intent(inout) :: touch
      !> The gap, in units of length; negative beyond the wall.
      real(wp), intent(out) :: gap
      !> Nodes per time unit of the structure, and limits on their number.
      integer, parameter :: density = 3, least = 12, most = 4000
      real(wp), allocatable, dimension(:, :) :: y, rate
      real(wp) :: duration, value, share, step, h
      type(condition_type) :: here
      integer :: i, k, nodes, row, wall

      duration = flight_duration(member, touch%index)
      nodes = max(least, min(most, ceiling(density*duration/member%regime%unit)))
      associate (rows => size(member%regime%upper))
         allocate (y(rows, 0:nodes), rate(rows, 0:nodes))
      end associate
      do k = 0, nodes
         call rows_at(member, touch%index, k*duration/nodes, y(:, k), rate(:, k))
      end do
      h = duration/nodes
      gap = wide
      touch%side = 0
      touch%share = 0
      do row = 1, size(y, 1)
         do i = 1, 2
            wall = 3 - 2*i
            if (.not. is_wall(member, row, wall)) cycle
            do k = 0, nodes
               here = touch
               here%side = wall*row
               here%share = k/real(nodes, wp)
               ! an impact leaves its wall; without restitution its speed is 0, up to rounding
               if (k == 0 .and. in_contact(member, touch%index, here%side)) cycle
               if (k < nodes) then
                  ! the gap has a minimum between two nodes
                  if (wall*rate(row, k) > 0 .and. wall*rate(row, k + 1) <= 0) then
                     step = rate(row, k)/(rate(row, k) - rate(row, k + 1))
                     share = (k + step)/nodes
                     ! cubic interpolation decides which minima are refined
                     value = hermite(y(row, k), y(row, k + 1), h*rate(row, k), h*rate(row, k + 1), &
                        step)
                     value = gap_at(frame, member, here%side, value)
                     if (value < gap + 0.1_wp) then
                        here%share = share
                        value = touch_value(frame, member, here)
                        if (value < gap) then
                           gap = value
                           touch = here
                        end if
                     end if
                     here%share = k/real(nodes, wp)
                  end if
               end if
               if (k < nodes) cycle
               ! the next impact comes first: before it all other gaps are open
               if (in_contact(member, touch%index + 1, here%side)) cycle
               value = gap_at(frame, member, here%side, y(row, k))
               if (value >= gap) cycle
               gap = value
               touch = here
            end do
         end do
      end do
   end subroutine gap_of_flight

   !> Cubic interpolation between two nodes.
   pure real(wp) function hermite(a, b, slope_a, slope_b, t) result(value)
      !> Values and slopes at both ends, and the share of the way.
      real(wp), intent(in) :: a, b, slope_a, slope_b, t

      value = a + t*(slope_a + t*(3*(b - a) - 2*slope_a - slope_b + t*(2*(a - b) + slope_a &
         + slope_b)))
   end function hermite

   !> Whether a channel has a wall on one side.
   pure logical function is_wall(member, row, wall)
      !> The motion.
      type(member_type), intent(in) :: member
      !> The channel, and +1 or -1 for its upper or lower wall.
      integer, intent(in) :: row, wall

      is_wall = merge(member%regime%upper_gap(row), member%regime%lower_gap(row), wall > 0) > 0
   end function is_wall

   !> Whether an impact of the family, or the one after the last, is on a wall.
   pure logical function in_contact(member, impact, side)
      !> The motion.
      type(member_type), intent(in) :: member
      !> Number of the impact, from 1 to n + 1.
      integer, intent(in) :: impact
      !> The channel with the sign of the wall.
      integer, intent(in) :: side

      associate (structure => member%structure, gap => member%equations%gaps(modulo(impact - 1, &
         size(member%equations%gaps)) + 1))
         in_contact = structure%channel(gap)*structure%wall(gap) == side
      end associate
   end function in_contact

   !> A gap in units of length.
   pure real(wp) function gap_at(frame, member, side, y) result(gap)
      !> The family.
      type(frame_type), intent(in) :: frame
      !> The motion.
      type(member_type), intent(in) :: member
      !> The channel with the sign of the wall.
      integer, intent(in) :: side
      !> The position of the channel.
      real(wp), intent(in) :: y

      if (side > 0) then
         gap = member%regime%upper(side) - y
      else
         gap = y - member%regime%lower(-side)
      end if
      gap = gap/frame%structure%length
   end function gap_at

   !> The gap at the stationary point near a given share of the flight; at its ends, the gap there.
   pure real(wp) function touch_value(frame, member, touch) result(gap)
      !> The family.
      type(frame_type), intent(in) :: frame
      !> The motion, with its flights.
      type(member_type), intent(in) :: member
      !> Flight, channel and wall, and approximate share of its duration.
      type(condition_type), intent(in) :: touch
      real(wp), dimension(size(member%regime%upper)) :: y, rate, ahead, unused
      real(wp) :: duration, t, step, limit, h
      integer :: i, row

      row = abs(touch%side)
      gap = wide
      if (row == 0) return
      duration = flight_duration(member, touch%index)
      t = touch%share*duration
      if (touch%share > 0 .and. touch%share < 1) then
         limit = 0.2_wp*member%regime%unit
         h = 1.0e-3_wp*member%regime%unit
         do i = 1, 8
            call rows_at(member, touch%index, t, y, rate)
            call rows_at(member, touch%index, t + h, unused, ahead)
            step = ahead(row) - rate(row)
            if (.not. abs(step) > 0) exit
            step = -h*rate(row)/step
            t = t + max(-limit, min(limit, step))
            ! an error of the time changes the gap by its square
            if (abs(step) < 1.0e-9_wp*member%regime%unit) exit
         end do
      end if
      call rows_at(member, touch%index, t, y, rate)
      gap = gap_at(frame, member, touch%side, y(row))
   end function touch_value

   !> Positions and rates of all channels at a time after an impact.
   pure subroutine rows_at(member, i, t, y, rate)
      !> The motion, with its flights.
      type(member_type), intent(in) :: member
      !> Number of the impact.
      integer, intent(in) :: i
      !> Time since then.
      real(wp), intent(in) :: t
      !> (rows) Positions and rates.
      real(wp), contiguous, intent(out) :: y(:), rate(:)
      real(wp), dimension(size(member%x_after, 1)) :: x, v
      complex(wp) :: turn(size(member%regime%ripple, 2))
      real(wp) :: phase
      integer :: h

      associate (regime => member%regime)
         call advance(regime%modes, t, member%x_after(:, i), member%v_after(:, i), x, v)
         phase = regime%frequency*(member%equations%times(i) + t)
         do h = 1, size(turn)
            turn(h) = cmplx(cos(h*phase), sin(h*phase), wp)
         end do
         call row_values(regime%rows, regime%frequency, x, v, turn, y, rate)
      end associate
   end subroutine rows_at

end module vi_structure_conditions
