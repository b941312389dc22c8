!> Branches: a family of motions along one parameter, with its special points.
!!
!! Pseudo-arclength continuation follows the branch around folds. At a special point, one of the
!! conditions of stability or admissibility changes sign; it is located by Newton's method with
!! that condition as a further equation. A branch ends at a motion that repeats itself within its
!! period, or that is symmetric; such motions form a branch of their own.
module vi_branch
   use vi_crossing, only: locate, look_between
   use vi_curve, only: curve_type, distance_from
   use vi_kinds, only: wp
   use vi_motion_family, only: condition_type, contact_vanishes, edge, event_vanishes, &
      events_meet, flight_vanishes, fold, grazing, is_exchange, neimark_sacker, repetition, &
      rest_splits, rest_vanishes, stick_begins, stick_vanishes, zero_approach
   use vi_spectrum, only: is_neutral_saddle, outside_circle
   use vi_steps, only: begin_walk, can_shorten, place_type, stride_type, take_step
   use vi_progress, only: is_stopped, report_share
   implicit none (type, external)
   private

   public :: end_text, follow_branch

   !> Why a branch ends.
   integer, parameter, public :: end_bound = 1, end_repetition = 2, end_closed = 3, end_stuck = 4, &
      end_full = 5, end_stopped = 6, end_simultaneous = 7, end_rest = 8, end_exchange = 9, &
      end_stick_begins = 10, end_stick = 11, end_contact = 12, end_event = 13, &
      end_flight = 14

   !> A step this short is not repeated to search for hidden special points.
   real(wp), parameter :: least_step = 1.0e-6_wp

   !> A branch in one direction along a family, from its start.
   type, public :: branch_type
      !> Points (2n + 1, m) in order along the branch; the start is number `start`.
      real(wp), allocatable :: points(:, :)
      !> The condition that is zero at a special point; kind 0 at the others.
      type(condition_type), allocatable :: special(:)
      integer :: n = 0
      !> The reason why it ends: one of the codes above.
      integer :: reason = end_full
   end type branch_type

contains

   !> The reason why a branch ends, in words.
   pure function end_text(reason) result(text)
      !> One of the codes above.
      integer, intent(in) :: reason
      character(len_trim(padded_end(reason))) :: text

      text = padded_end(reason)
   end function end_text

   !> As `end_text`, padded with blanks.
   pure function padded_end(reason) result(text)
      !> One of the codes above.
      integer, intent(in) :: reason
      character(40) :: text

      select case (reason)
      case (end_bound)
         text = 'bound of the parameter'
      case (end_repetition)
         text = 'meets a motion that repeats itself'
      case (end_simultaneous)
         text = 'two impacts at one instant'
      case (end_rest)
         text = 'a rest vanishes'
      case (end_exchange)
         text = 'two events at one instant'
      case (end_stick_begins)
         text = 'friction begins to stick'
      case (end_stick)
         text = 'a stick vanishes'
      case (end_contact)
         text = 'a contact vanishes'
      case (end_flight)
         text = 'a flight vanishes'
      case (end_event)
         text = 'a halt or a slip vanishes'
      case (end_closed)
         text = 'closed'
      case (end_full)
         text = 'full'
      case (end_stopped)
         text = 'stopped'
      case default
         text = 'cannot be followed'
      end select
   end function padded_end

   !> Follows a family in one direction from a point, until it leaves the bounds of the parameter.
   subroutine follow_branch(curve, stride, point, way, most, branch, work, reported, progress)
      !> The curve, with one active parameter and edges at its bounds.
      type(curve_type), intent(in) :: curve
      !> Limits on steps.
      type(stride_type), intent(in) :: stride
      !> The motion at the start: unknowns, then the parameter over its range (0 to 1).
      real(wp), intent(in) :: point(:)
      !> +1 or -1: the direction in which the parameter changes first, or at a fold another
      !! coordinate.
      integer, intent(in) :: way
      !> Largest number of points.
      integer, intent(in) :: most
      !> The branch; its arrays have room for `most` points.
      type(branch_type), intent(out) :: branch
      !> Units of work of this branch in the progress counters, see vi_progress.
      integer, intent(in) :: work
      !> In: units reported so far. Out: with those reported here.
      integer, intent(inout) :: reported
      !> Progress counters.
      integer, intent(inout), optional :: progress(3)
      type(condition_type) :: none(0)
      type(place_type) :: before, now, next
      real(wp) :: along(size(point)), reach
      !> Number of points up to `before` and up to `now`.
      integer :: n(2)
      integer :: i
      logical :: good, done, unsure, earlier

      allocate (branch%points(size(point), most), branch%special(most))
      branch%reason = end_stuck
      do i = size(point), 1, -1
         ! at a fold the parameter does not change at first
         along = 0
         along(i) = way
         call begin_walk(curve, none, point, along, 0.1_wp*stride%longest, now, good)
         if (good) exit
      end do
      if (.not. good) return
      call append(branch, now, condition_type())
      if (on_bound(curve, now, way)) then
         branch%special(1) = curve%edges((3 + way)/2)
         branch%reason = end_bound
         return
      end if
      before = now
      n = [branch%n, branch%n]
      do while (branch%n + size(now%values) < most)
         if (is_stopped(progress)) then
            branch%reason = end_stopped
            return
         end if
         call take_step(curve, none, stride, now, next, good)
         if (.not. good) return
         if (is_too_far(now, next, stride%shortest)) then
            now%step = 0.3_wp*next%came
            cycle
         end if
         call look_between(curve, none, before, now, next, sought_between(now, next), &
            at_end(now, next), least_step, earlier, reach)
         if (earlier) then
            ! the previous step is repeated
            branch%n = n(1)
            n(2) = n(1)
            now = before
         end if
         if (reach > 0) then
            now%step = reach
            cycle
         end if
         call note_special(curve, now, next, branch, done, unsure)
         if (unsure) then
            now%step = 0.3_wp*next%came
            cycle
         end if
         if (done .or. beyond(next)) return
         if (closes(curve, branch, now, next)) then
            branch%reason = end_closed
            call append_point(branch, point, condition_type())
            return
         end if
         call append(branch, next, condition_type())
         call report_share(max(covered(branch), branch%n/real(most, wp)), work, reported, progress)
         n = [n(2), branch%n]
         before = now
         now = next
      end do
      branch%reason = end_full
   end subroutine follow_branch

   !> Whether a step has to be repeated with a shorter length: the multipliers change much, or it
   !! goes too far beyond one of the bounds.
   pure logical function is_too_far(now, next, shortest)
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      !> Least length of a step.
      real(wp), intent(in) :: shortest

      is_too_far = .false.
      if (can_shorten(next, 1.0e-5_wp)) is_too_far = changes_much(now, next)
      ! values beyond a bound are not used: they may be meaningless
      if (can_shorten(next, shortest)) is_too_far = is_too_far .or. leaps_over(next)
   end function is_too_far

   !> (conditions) Whether two special points of each are sought within a step.
   pure function sought_between(now, next) result(sought)
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      logical :: sought(size(now%values))

      sought = now%conditions%kind /= repetition .and. now%values*next%values > 0 .and. .not. &
         stays_on_circle(now, next)
   end function sought_between

   !> (conditions) Whether each approaches zero at an end of the branch: the first step has none
   !! before it, and the last one none after it.
   pure function at_end(now, next)
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      logical :: at_end(size(now%values))

      at_end = (is_end(next) .and. abs(next%values) < abs(now%values)) .or. &
         (.not. now%came > 0 .and. abs(now%values) < abs(next%values))
   end function at_end

   !> Whether a branch ends within the step to a place.
   pure logical function is_end(place)
      !> The end of the step.
      type(place_type), intent(in) :: place

      is_end = any(place%values < 0 .and. (place%conditions%kind == edge .or. &
         place%conditions%kind == repetition))
   end function is_end

   !> (conditions) Whether it is the one of Neimark-Sacker and is zero but for rounding at both ends
   !! of a step: a pair of multipliers lies on the unit circle, such as that of a host that neither
   !! dampers nor impacts affect.
   pure function stays_on_circle(now, next) result(stays)
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      logical :: stays(size(now%values))
      real(wp), parameter :: rounding = 1.0e-10_wp

      stays = now%conditions%kind == neimark_sacker .and. &
         max(abs(now%values), abs(next%values)) < rounding
   end function stays_on_circle

   !> Whether the multipliers change so much within a step that some may have crossed the unit
   !! circle and come back.
   pure logical function changes_much(now, next)
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      real(wp), parameter :: most_change = 0.5_wp

      changes_much = .false.
      if (.not. (now%spectrum%regular .and. next%spectrum%regular)) return
      changes_much = norm2(next%spectrum%e(:3) - now%spectrum%e(:3)) > most_change
   end function changes_much

   !> Whether the special points within a step account for the numbers of multipliers outside the
   !! unit circle at its ends; otherwise there are more special points.
   pure logical function explained(now, next, found, order)
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      !> (conditions) The place where each condition is zero, where that is known.
      type(place_type), intent(in) :: found(:)
      !> The conditions that are zero, in order along the step.
      integer, intent(in) :: order(:)
      integer :: i, kind, outside, beyond, most
      logical, allocatable :: possible(:), reached(:)

      explained = .true.
      if (.not. (now%spectrum%regular .and. next%spectrum%regular)) return
      ! rounding decides on which side of the circle they are
      if (any(stays_on_circle(now, next))) return
      most = 4
      if (allocated(now%spectrum%multipliers)) most = size(now%spectrum%multipliers)
      allocate (possible(0:most), reached(0:most))
      ! where an approach speed passes zero, a multiplier passes infinity
      if (any(now%values*next%values < 0 .and. now%conditions%kind == zero_approach)) return
      possible = .false.
      possible(outside_circle(now%spectrum, 0)) = .true.
      do i = 1, size(order)
         kind = now%conditions(order(i))%kind
         if (kind > neimark_sacker) cycle
         ! the multipliers that cross are outside either before or after the crossing
         outside = outside_circle(found(order(i))%spectrum, kind)
         beyond = outside + merge(2, 1, kind == neimark_sacker)
         reached = .false.
         if (possible(outside)) reached(beyond) = .true.
         if (possible(beyond)) reached(outside) = .true.
         possible = reached
      end do
      explained = possible(outside_circle(next%spectrum, 0))
   end function explained

   !> The share of the range between the start and a bound that the branch has covered.
   pure real(wp) function covered(branch)
      !> The branch so far.
      type(branch_type), intent(in) :: branch
      real(wp) :: start, now

      start = branch%points(size(branch%points, 1), 1)
      now = branch%points(size(branch%points, 1), branch%n)
      ! the bounds lie at 0 and 1
      covered = abs(now - start)/max(epsilon(start), merge(1 - start, start, now > start))
   end function covered

   !> Whether a walk begins on the bound of the parameter that lies in its direction.
   pure logical function on_bound(curve, start, way)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> The start of the walk.
      type(place_type), intent(in) :: start
      !> +1 or -1: the direction in which the parameter changes.
      integer, intent(in) :: way

      ! the edges are the last two conditions: lowest, highest
      on_bound = start%values(size(start%values) + (way - 1)/2) <= 1.0e-14_wp*curve%scale(1)
   end function on_bound

   !> Whether a place lies beyond a bound of the parameter.
   pure logical function beyond(place)
      !> The place.
      type(place_type), intent(in) :: place

      beyond = any(place%conditions%kind == edge .and. place%values < 0)
   end function beyond

   !> Whether a step has gone so far beyond a bound that the bound could not be located on it.
   pure logical function leaps_over(place)
      !> The end of the step.
      type(place_type), intent(in) :: place

      leaps_over = beyond(place) .and. abs(place%point(size(place%point)) - 0.5_wp) > 0.5_wp + &
         0.02_wp*max(place%came, 1.0e-6_wp)
   end function leaps_over

   !> Appends the special points within a step, in order.
   pure subroutine note_special(curve, now, next, branch, done, unsure)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      !> In and out: the special points are appended.
      type(branch_type), intent(inout) :: branch
      !> Whether one of them ends the branch.
      logical, intent(out) :: done
      !> Whether there may be more of them, which a shorter step can reveal; nothing is appended
      !! then.
      logical, intent(out) :: unsure
      type(condition_type) :: none(0)
      type(place_type) :: found(size(now%values))
      real(wp) :: share(size(now%values)), least
      logical, dimension(size(now%values)) :: crossed, turns
      logical :: good, short, beside, vanishes
      integer :: order(size(now%values)), i, j, n

      done = .false.
      unsure = .false.
      short = .not. can_shorten(next, least_step)
      ! a start on a bound may lie outside by rounding: entering the range is not an event
      crossed = now%values*next%values < 0 .and. (next%values < 0 .or. now%conditions%kind /= &
         edge) .and. .not. stays_on_circle(now, next)
      turns = now%conditions%kind == contact_vanishes .or. now%conditions%kind == flight_vanishes
      beside = nearly_repeats(now, next)
      ! the parameter turns back there, and a multiplier may pass infinity
      vanishes = any(crossed .and. now%conditions%kind == event_vanishes)
      if (vanishes) then
         unsure = any(crossed .and. now%conditions%kind <= neimark_sacker) .and. .not. short
         if (unsure) return
         where (now%conditions%kind <= neimark_sacker) crossed = .false.
      else if (beside) then
         ! the difference of the parameter from the bifurcation is of second order in the distance
         crossed(fold) = .false.
      else if ((crossed(fold) .neqv. turns_back(now, next)) .neqv. any( &
         crossed .and. turns)) then
         ! the parameter turns back at folds, and where a contact or a flight becomes a touch
         unsure = .not. short
         if (unsure) return
         ! the end of the step is on another curve
         done = .not. (crossed(fold) .or. next%leapt)
         if (done) return
         crossed(fold) = .false.
      end if
      share = 0
      do j = 1, size(crossed)
         if (.not. crossed(j)) cycle
         call locate(curve, none, now, next, j, found(j), share(j), good)
         unsure = .not. good .and. .not. short
         if (unsure) return
         crossed(j) = good
         if (good .and. now%conditions(j)%kind == neimark_sacker) crossed(j) = .not. &
            is_neutral_saddle(found(j)%spectrum)
      end do
      do j = 1, size(crossed)
         if (crossed(j)) crossed(j) = .not. is_end_of_approach(found, crossed, j)
      end do
      n = 0
      do while (any(crossed))
         least = minval(share, crossed)
         j = findloc(crossed .and. share <= least, .true., dim=1)
         crossed(j) = .false.
         n = n + 1
         order(n) = j
      end do
      if (.not. (short .or. beside .or. vanishes)) unsure = .not. explained(now, next, found, &
         order(:n))
      if (unsure) return
      do i = 1, n
         j = order(i)
         ! what rounding puts before the bound, but lies beyond it
         if (found(j)%conditions(j)%kind /= edge .and. beyond(found(j))) cycle
         call append(branch, found(j), found(j)%conditions(j))
         select case (found(j)%conditions(j)%kind)
         case (edge)
            branch%reason = end_bound
            done = .true.
         case (repetition)
            branch%reason = end_repetition
            done = .true.
         case (grazing)
            ! at the end of a flight another gap closes: beyond it, its impact comes first
            done = is_exchange(found(j)%conditions(j))
            if (done) branch%reason = merge(end_exchange, end_simultaneous, &
               any(now%conditions%kind == stick_begins .or. now%conditions%kind == events_meet &
               .or. now%conditions%kind == event_vanishes))
         case (rest_splits)
            ! a rest ends at another event: beyond it, it ends before
            done = is_exchange(found(j)%conditions(j))
            if (done) branch%reason = end_exchange
         case (rest_vanishes)
            ! beyond it the accumulation is not completed
            branch%reason = end_rest
            done = .true.
         case (events_meet, stick_begins, stick_vanishes, contact_vanishes, flight_vanishes, &
            event_vanishes)
            ! beyond it the events are others
            associate (kind => found(j)%conditions(j)%kind)
               branch%reason = end_exchange
               if (kind == stick_begins) branch%reason = end_stick_begins
               if (kind == stick_vanishes) branch%reason = end_stick
               if (kind == contact_vanishes) branch%reason = end_contact
               if (kind == flight_vanishes) branch%reason = end_flight
               if (kind == event_vanishes) branch%reason = end_event
            end associate
            done = .true.
         case default
            done = .false.
         end select
         if (done) return
      end do
   end subroutine note_special

   !> Whether a step begins or ends so near to a motion that repeats itself that rounding decides
   !! how the parameter changes.
   pure logical function nearly_repeats(now, next) result(beside)
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      real(wp), parameter :: near = 3.0e-4_wp

      beside = any(now%conditions%kind == repetition .and. &
         min(abs(now%values), abs(next%values)) < near)
   end function nearly_repeats

   !> Whether the parameter changes its direction within a step.
   pure logical function turns_back(now, next)
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next

      associate (n => size(now%tangent))
         turns_back = now%tangent(n)*next%tangent(n) < 0
      end associate
   end function turns_back

   !> Whether a grazing touch belongs to an impact whose approach speed becomes zero at the same
   !! point, or to a halt or a slip that vanishes.
   !!
   !! There the flight before or after that impact ends or begins with a touch: it is one event, not
   !! two.
   pure logical function is_end_of_approach(found, crossed, j) result(same)
      !> (conditions) The place where each condition is zero, where that is known.
      type(place_type), intent(in) :: found(:)
      !> (conditions) Whether each condition is zero within the step.
      logical, intent(in) :: crossed(:)
      !> Index of the touch.
      integer, intent(in) :: j
      !> A touch this near to an end of its flight, as a share of it, is distinguished from the
      !! impact there by a distance of `far` at least, any other touch by `near`.
      real(wp), parameter :: beside = 1.0e-3_wp, far = 1.0e-3_wp, near = 1.0e-6_wp
      integer :: behind, i, n
      real(wp) :: share

      same = .false.
      if (found(j)%conditions(j)%kind /= grazing) return
      ! a condition for each event
      n = count(found(j)%conditions%kind == zero_approach .or. found(j)%conditions%kind == &
         stick_begins .or. found(j)%conditions%kind == event_vanishes)
      share = found(j)%conditions(j)%share
      do i = 1, size(crossed)
         if (.not. crossed(i)) cycle
         if (all(found(i)%conditions(i)%kind /= [zero_approach, event_vanishes])) cycle
         ! 0: the flight begins with the impact, 1: it ends with it
         behind = modulo(found(i)%conditions(i)%index - found(j)%conditions(j)%index, n)
         same = any(behind == [0, 1]) .and. norm2(found(i)%point - found(j)%point) < merge(far, &
            near, abs(share - behind) < beside .and. share < 1)
         if (same) return
      end do
   end function is_end_of_approach

   !> Whether a step returns to the start of the branch.
   pure logical function closes(curve, branch, now, next)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> The branch so far.
      type(branch_type), intent(in) :: branch
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      real(wp) :: offset(size(now%point)), share

      closes = .false.
      if (branch%n < 4) return
      offset = branch%points(:, 1) - now%point
      call curve%family%wrap_phases(offset)
      share = dot_product(offset, now%tangent)
      closes = share > 0 .and. share <= next%came .and. &
         norm2(offset - share*now%tangent) < 0.2_wp*share + 1.0e-9_wp
      if (closes) closes = distance_from(curve, [condition_type ::], now%point + &
         share*now%tangent, now%tangent, branch%points(:, 1)) < 1.0e-6_wp
   end function closes

   !> Appends a place to a branch.
   pure subroutine append(branch, place, special)
      !> In and out: the branch.
      type(branch_type), intent(inout) :: branch
      !> The place.
      type(place_type), intent(in) :: place
      !> The condition that is zero there; kind 0 if none.
      type(condition_type), intent(in) :: special

      call append_point(branch, place%point, special)
   end subroutine append

   !> Appends a point to a branch.
   pure subroutine append_point(branch, point, special)
      !> In and out: the branch.
      type(branch_type), intent(inout) :: branch
      !> The point.
      real(wp), intent(in) :: point(:)
      !> The condition that is zero there; kind 0 if none.
      type(condition_type), intent(in) :: special

      branch%n = branch%n + 1
      branch%points(:, branch%n) = point
      branch%special(branch%n) = special
   end subroutine append_point

end module vi_branch
