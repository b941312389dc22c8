!> Traces the boundary of a zone, as a closed curve of named pieces.
!!
!! The motions of a family over the plane (r, D) form a surface. On it, a zone is where all
!! conditions are positive. Its boundary is followed along the one condition that is zero; where
!! another one becomes zero there is a corner, and the boundary is followed along that one.
module vi_trace
   use vi_conditions, only: condition_value
   use vi_crossing, only: locate, look_between
   use vi_curve, only: condition_slope, correct, curve_type, distance_from, parameters_of, &
      tangent_at, unknowns_of
   use vi_kinds, only: wp
   use vi_loop, only: begins, ends, loop_type
   use vi_motion_family, only: condition_type, grazing, rest_splits
   use vi_steps, only: begin_walk, can_shorten, exchange, place_type, stride_type, take_step
   use vi_progress, only: is_stopped
   implicit none (type, external)
   private

   public :: trace_loop

   !> A zero nearer than this to the start of a step counts as being at the start.
   real(wp), parameter :: begun = 1.0e-9_wp
   !> Two points of a boundary that are nearer than this to each other are the same.
   real(wp), parameter :: same_place = 1.0e-6_wp

contains

   !> Follows the boundary of a zone from a point where one condition is zero.
   subroutine trace_loop(curve, stride, point, condition, most, way, loop, progress)
      !> The surface, with two active parameters.
      type(curve_type), intent(in) :: curve
      !> Limits on steps.
      type(stride_type), intent(in) :: stride
      !> A point of the boundary: the unknowns, then r and log D in the units of the surface.
      real(wp), intent(in) :: point(:)
      !> The condition that is zero there.
      type(condition_type), intent(in) :: condition
      !> Largest number of points.
      integer, intent(in) :: most
      !> +1: towards larger D at first, or towards larger r where D is constant; -1: in the opposite
      !! direction.
      integer, intent(in) :: way
      !> The boundary; its arrays have room for `most` points.
      type(loop_type), intent(out) :: loop
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(place_type) :: before, now, next, corner
      type(condition_type) :: active
      real(wp) :: reach
      !> Steps tried for each point, and in addition; near a singular point steps can be repeated
      !! without end.
      integer, parameter :: tries = 5, extra = 300
      integer :: which, tried
      logical :: good, met, earlier

      tried = 0
      allocate (loop%points(size(point), most), loop%tangents(size(point), most), &
         loop%conditions(most), loop%corner(most))
      active = condition
      call set_out(curve, active, point, now, good)
      if (.not. good) return
      now%tangent = way*now%tangent
      call append(loop, now, active, 0)
      before = now
      do while (loop%n < most)
         if (is_stopped(progress)) return
         tried = tried + 1
         if (tried > tries*loop%n + extra) return
         call take_step(curve, [active], stride, now, next, good)
         if (.not. good) return
         if (curve%family%jumps) then
            if (hardly_moves(loop)) return
         end if
         call first_violation(curve, active, now, next, 64*stride%shortest, corner, which, met)
         if (which < 0 .and. .not. can_shorten(next, 64*stride%shortest)) return
         ! a violation that could not be located: another one may come before it
         if (which < 0) then
            now%step = 0.3_wp*next%came
            cycle
         end if
         call look_between(curve, [active], before, now, next, .not. same_condition(active, &
            now%conditions), spread(.false., 1, size(now%values)), 1.0e-4_wp, earlier, reach)
         if (earlier) then
            ! the previous step is repeated
            loop%n = loop%n - 1
            now = before
         end if
         if (reach > 0) then
            now%step = reach
            cycle
         end if
         if (closes(curve, loop, now, next, active, met, corner)) then
            loop%closed = .true.
            return
         end if
         if (met) then
            call tangent_at(curve, [active], corner%point, now%tangent, corner%tangent, good)
            if (good) call append(loop, corner, active, ends)
            call turn(curve, active, corner, which, now, good)
            if (.not. good .or. loop%n == most) return
            call append(loop, now, active, begins)
            call close_at_corner(curve, loop)
            if (loop%closed) return
            call cut_return(curve, loop, good)
            if (good) return
            before = now
         else
            call exchange(before, now)
            call exchange(now, next)
            if (loop%n < most - 1 .and. renamed(active, now)) then
               call append(loop, now, active, ends)
               call refresh(now, active)
               call append(loop, now, active, begins)
            else
               call refresh(now, active)
               call append(loop, now, active, 0)
            end if
         end if
      end do
   end subroutine trace_loop

   !> Whether a boundary leads nowhere: near a singular point, as where a bounce of an accumulation
   !! begins to graze, steps have to be so short that it would take all points.
   pure logical function hardly_moves(loop)
      !> The boundary so far.
      type(loop_type), intent(in) :: loop
      !> Number of points that are looked at, and least distance between the first and the last.
      integer, parameter :: many = 200
      real(wp), parameter :: least = 5.0e-3_wp

      hardly_moves = mod(loop%n, many) == 0
      if (hardly_moves) hardly_moves = norm2(loop%points(:, loop%n) - loop%points(:, loop%n + 1 &
         - many)) < least
   end function hardly_moves

   !> The first place of a trace, directed towards larger D or, where D is constant, larger r.
   pure subroutine set_out(curve, active, point, place, good)
      !> The surface.
      type(curve_type), intent(in) :: curve
      !> The condition that is zero along the boundary.
      type(condition_type), intent(in) :: active
      !> A point of the boundary.
      real(wp), intent(in) :: point(:)
      !> The place.
      type(place_type), intent(out) :: place
      !> False if the boundary has no tangent there.
      logical, intent(out) :: good
      real(wp), dimension(size(point)) :: along, start
      integer :: iterations

      along = 0
      along(size(point)) = 1
      call begin_walk(curve, [active], point, along, 1.0e-3_wp, place, good)
      if (.not. good) then
         along(size(point) - 1:) = [1, 0]
         call begin_walk(curve, [active], point, along, 1.0e-3_wp, place, good)
      end if
      if (.not. good) return
      ! the point was located along a line that can be nearly tangent to the boundary
      start = point
      call correct(curve, [active], start, iterations, place%tangent)
      if (iterations == 0 .or. norm2(start - point) > 1.0e-4_wp) return
      along = place%tangent
      call begin_walk(curve, [active], start, along, 1.0e-3_wp, place, good)
   end subroutine set_out

   !> Closes a loop that has reached one of its earlier corners; the points before that corner are
   !! removed.
   pure subroutine close_at_corner(curve, loop)
      !> The surface.
      type(curve_type), intent(in) :: curve
      !> In: ends with a corner. Out: closed, if that corner is an earlier one or its start.
      type(loop_type), intent(inout) :: loop
      real(wp) :: offset(size(loop%points, 1))
      integer :: j, m

      do j = 1, loop%n - 1
         if (j > 1 .and. loop%corner(j) /= begins) cycle
         if (.not. same_condition(loop%conditions(loop%n), loop%conditions(j))) cycle
         offset = loop%points(:, loop%n) - loop%points(:, j)
         call curve%family%wrap_phases(offset)
         if (maxval(abs(offset)) > same_place) cycle
         m = loop%n - j
         loop%points(:, :m) = loop%points(:, j:loop%n - 1)
         loop%tangents(:, :m) = loop%tangents(:, j:loop%n - 1)
         loop%conditions(:m) = loop%conditions(j:loop%n - 1)
         loop%corner(:m) = loop%corner(j:loop%n - 1)
         loop%corner(1) = begins
         loop%n = m
         loop%closed = .true.
         return
      end do
   end subroutine close_at_corner

   !> Removes the way back of a loop that has turned round and reached one of its earlier corners
   !! again: such a loop encloses nothing. Where the surface of motions ends without a condition, as
   !! where impacts that accumulate begin to graze, steps along the boundary may turn round.
   pure subroutine cut_return(curve, loop, returned)
      !> The surface.
      type(curve_type), intent(in) :: curve
      !> In: ends with a corner. Out: if it has turned round, ends where it did so.
      type(loop_type), intent(inout) :: loop
      !> Whether it has.
      logical, intent(out) :: returned
      real(wp) :: offset(size(loop%points, 1)), distance, farthest
      integer :: i, j, m

      returned = .false.
      m = size(offset) - 2
      do j = 1, loop%n - 2
         if (loop%corner(j) /= ends) cycle
         if (.not. same_condition(loop%conditions(loop%n), loop%conditions(j))) cycle
         offset = loop%points(:, loop%n) - loop%points(:, j)
         call curve%family%wrap_phases(offset)
         if (maxval(abs(offset)) > same_place) cycle
         returned = dot_product(loop%tangents(:, loop%n), loop%tangents(:, j)) < 0
         if (.not. returned) cycle
         farthest = -1
         do i = j + 1, loop%n
            distance = norm2(loop%points(m + 1:, i) - loop%points(m + 1:, j))
            if (distance <= farthest) exit
            farthest = distance
         end do
         loop%n = i - 1
         return
      end do
   end subroutine cut_return

   !> Whether a step passes the start of the loop, with the same condition being zero.
   pure logical function closes(curve, loop, now, next, active, met, corner)
      !> The surface.
      type(curve_type), intent(in) :: curve
      !> The loop so far.
      type(loop_type), intent(in) :: loop
      !> Start and end of the step, and the corner on it.
      type(place_type), intent(in) :: now, next, corner
      !> The condition that is zero along the step.
      type(condition_type), intent(in) :: active
      !> Whether there is a corner.
      logical, intent(in) :: met
      real(wp) :: offset(size(now%point)), share, reach

      closes = .false.
      if (loop%n < 2) return
      if (.not. same_condition(active, loop%conditions(1))) return
      offset = loop%points(:, 1) - now%point
      call curve%family%wrap_phases(offset)
      reach = next%came
      if (met) reach = corner%came
      share = dot_product(offset, now%tangent)
      closes = share > 0 .and. share <= reach*(1 + 1.0e-9_wp) .and. &
         norm2(offset - share*now%tangent) < 0.3_wp*share + 1.0e-7_wp
      if (.not. closes .or. share < same_place) return
      ! the two sides of a narrow tongue are also this near to each other
      closes = dot_product(now%tangent, loop%tangents(:, 1)) > 0
      if (closes) closes = distance_from(curve, [active], now%point + share*now%tangent, &
         now%tangent, loop%points(:, 1)) < same_place
   end function closes

   !> Whether two conditions are the same; grazing has to be at about the same share of the flight.
   pure elemental logical function same_condition(a, b)
      !> The conditions.
      type(condition_type), intent(in) :: a, b

      same_condition = (a%kind == b%kind .or. (is_touch(a) .and. is_touch(b))) .and. &
         a%index == b%index .and. a%side == b%side
      if (is_touch(a)) same_condition = same_condition .and. abs(a%share - b%share) < 0.2_wp
   end function same_condition

   !> Whether a condition is a touch, of a wall in a flight or of zero by the contact force of a
   !! rest: where the rest splits, one turns into the other.
   pure elemental logical function is_touch(condition)
      !> The condition.
      type(condition_type), intent(in) :: condition

      is_touch = condition%kind == grazing .or. condition%kind == rest_splits
   end function is_touch

   !> Whether the touch that is zero along a boundary has become one of the other kind at a place.
   pure logical function renamed(active, place)
      !> The condition.
      type(condition_type), intent(in) :: active
      !> The place.
      type(place_type), intent(in) :: place

      renamed = is_touch(active) .and. any(same_condition(active, place%conditions) .and. &
         place%conditions%kind /= active%kind)
   end function renamed

   !> The first condition that a step violates, if any, and where.
   !!
   !! A condition that is zero at the start of the step, at a corner, does not count there. If it is
   !! violated at the end, it has another zero within the step, which a shorter step will show.
   pure subroutine first_violation(curve, active, now, next, shortest, corner, which, met)
      !> The surface.
      type(curve_type), intent(in) :: curve
      !> The condition that is zero along the step.
      type(condition_type), intent(in) :: active
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      !> Length at which a step is not shortened any more.
      real(wp), intent(in) :: shortest
      !> Out: the place of the violation, if `met`.
      type(place_type), intent(inout) :: corner
      !> Number of the violated condition; 0 if none, -1 if it could not be located.
      integer, intent(out) :: which
      !> Whether there is a violation.
      logical, intent(out) :: met
      type(place_type) :: found
      real(wp) :: share, least
      integer :: j
      logical :: good

      which = 0
      met = .false.
      least = huge(1.0_wp)
      do j = 1, size(next%values)
         ! two conditions that a symmetry makes identical differ by rounding
         if (.not. next%values(j) < -merge(1.0e-9_wp, 0.0_wp, curve%family%jumps)) cycle
         if (same_condition(active, next%conditions(j))) cycle
         call locate(curve, [active], now, next, j, found, share, good)
         if (good .and. can_shorten(next, shortest)) good = abs(share)*next%came > begun
         if (.not. good) then
            which = -1
            return
         end if
         if (share >= least) cycle
         least = share
         corner = found
         which = j
         met = .true.
      end do
   end subroutine first_violation

   !> Turns at a corner: follows the new condition in the direction in which the old one increases.
   pure subroutine turn(curve, active, corner, which, now, good)
      !> The surface.
      type(curve_type), intent(in) :: curve
      !> In: the old condition. Out: the new one.
      type(condition_type), intent(inout) :: active
      !> The corner.
      type(place_type), intent(in) :: corner
      !> Number of the new condition.
      integer, intent(in) :: which
      !> Out: the first place along the new condition.
      type(place_type), intent(inout) :: now
      !> False if the boundary could not be followed.
      logical, intent(out) :: good
      type(condition_type) :: old
      real(wp) :: along(size(corner%point)), unused

      old = active
      active = corner%conditions(which)
      call condition_slope(curve, old, corner%point, unused, along)
      call begin_walk(curve, [active], corner%point, along, max(1.0e-4_wp, 0.1_wp*corner%step), &
         now, good)
      if (good) now%tangent = uphill(curve, active, old, now)*now%tangent
   end subroutine turn

   !> +1 if a condition increases along the tangent, -1 if it decreases. This is found from two
   !! points of the curve: the gradient across the curve can be so much larger that rounding hides
   !! the part of the gradient along it.
   pure real(wp) function uphill(curve, active, rising, place)
      !> The surface.
      type(curve_type), intent(in) :: curve
      !> The condition that is zero along the curve, and the condition that may increase.
      type(condition_type), intent(in) :: active, rising
      !> A place on the curve with its tangent.
      type(place_type), intent(in) :: place
      real(wp), parameter :: h = 1.0e-5_wp
      real(wp) :: point(size(place%point)), values(2)
      integer :: i, iterations

      uphill = 1
      do i = 1, 2
         point = place%point + (3 - 2*i)*h*place%tangent
         call correct(curve, [active], point, iterations, place%tangent)
         if (iterations == 0) return
         values(i) = condition_value(curve, unknowns_of(curve, point), &
            parameters_of(curve, point), rising)
      end do
      if (values(2) > values(1)) uphill = -1
   end function uphill

   !> Updates the kind and the time of a touch from the conditions at a place.
   pure subroutine refresh(place, active)
      !> The place.
      type(place_type), intent(in) :: place
      !> In and out: a condition; only a touch changes.
      type(condition_type), intent(inout) :: active
      integer :: j

      if (.not. is_touch(active)) return
      do j = 1, size(place%conditions)
         if (.not. same_condition(active, place%conditions(j))) cycle
         active%kind = place%conditions(j)%kind
         active%share = place%conditions(j)%share
         return
      end do
   end subroutine refresh

   !> Appends a place to a loop.
   pure subroutine append(loop, place, active, corner)
      !> In and out: the loop.
      type(loop_type), intent(inout) :: loop
      !> The place.
      type(place_type), intent(in) :: place
      !> The condition that is zero from there on.
      type(condition_type), intent(in) :: active
      !> `ends`, `begins`, or 0 if it is not a corner.
      integer, intent(in) :: corner

      loop%n = loop%n + 1
      loop%points(:, loop%n) = place%point
      loop%tangents(:, loop%n) = place%tangent
      loop%conditions(loop%n) = active
      loop%corner(loop%n) = corner
   end subroutine append

end module vi_trace
