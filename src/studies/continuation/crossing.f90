!> Zeros of a condition on a step along a curve of motions.
module vi_crossing
   use vi_conditions, only: condition_value
   use vi_curve, only: correct, curve_type, parameters_of, unknowns_of
   use vi_kinds, only: wp
   use vi_motion_family, only: condition_type, grazing, is_inside, neimark_sacker, rest_splits, &
      rest_vanishes
   use vi_steps, only: can_shorten, place_type, survey
   implicit none (type, external)
   private

   public :: hidden_zero, innermost_zero, locate, look_between, may_dip

contains

   !> Whether a condition may have changed sign twice within the last two steps.
   !!
   !! This is assumed if the parabola through three successive values has its extremum inside these
   !! steps, on the other side of zero.
   pure elemental logical function hidden_zero(before, now, next, first, second, margin) &
      result(hidden)
      !> Three successive values of the condition.
      real(wp), intent(in) :: before, now, next
      !> Lengths of the steps between them.
      real(wp), intent(in) :: first, second
      !> The extremum also counts if it is less than this share of the middle value.
      real(wp), intent(in), optional :: margin
      real(wp) :: slope, curvature, at, extreme

      hidden = .false.
      if (before*now <= 0 .or. now*next <= 0) return
      if (.not. (first > 0 .and. second > 0)) return
      curvature = ((next - now)/second - (now - before)/first)/(first + second)
      slope = (next - now)/second - curvature*second
      if (.not. abs(curvature) > 0) return
      at = -0.5_wp*slope/curvature
      if (at < -first .or. at > second) return
      extreme = now + at*(slope + curvature*at)
      hidden = extreme*now < 0
      if (present(margin)) hidden = extreme*now < margin*now**2
   end function hidden_zero

   !> Whether a condition with one sign at three successive places may be zero twice between two of
   !! them: a value that is convex, seen from zero, lies above the continued chord of the other two.
   !!
   !! The value has to be least at the place in the middle, since it rises again after the two
   !! zeros. The chord is taken as twice as steep as it is.
   pure elemental logical function may_dip(outer, near, far, outer_step, step)
      !> Values: at the other place, at the place in the middle, and at the end of the step.
      real(wp), intent(in) :: outer, near, far
      !> Lengths of the other step and of the step in question.
      real(wp), intent(in) :: outer_step, step

      may_dip = outer*near > 0 .and. near*far > 0 .and. abs(near) < abs(outer) .and. &
         abs(near) <= abs(far) .and. outer_step > 0 .and. step > 0
      if (may_dip) may_dip = 2*(abs(outer) - abs(near))*step >= abs(near)*outer_step
   end function may_dip

   !> Looks for a place within the last two steps where a condition has another sign than at their
   !! ends: it is zero twice within one step there.
   pure subroutine look_between(curve, conditions, before, now, next, sought, anyway, shortest, &
      earlier, reach)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Conditions that are zero along the curve.
      type(condition_type), intent(in) :: conditions(:)
      !> Start of the previous step, start and end of this step.
      type(place_type), intent(in) :: before, now, next
      !> (conditions) Which ones are looked at, and which ones within this step even if the value at
      !! the other place does not suggest it.
      logical, intent(in) :: sought(:), anyway(:)
      !> Length at which a step is not shortened any more.
      real(wp), intent(in) :: shortest
      !> Whether the place lies in the previous step.
      logical, intent(out) :: earlier
      !> Length of the step to that place; 0 if there is none.
      real(wp), intent(out) :: reach
      logical, dimension(size(sought)) :: first, second
      logical :: found
      integer :: j

      first = sought .and. can_shorten(now, shortest) .and. may_dip(next%values, now%values, &
         before%values, next%came, now%came)
      second = sought .and. can_shorten(next, shortest) .and. (anyway .or. may_dip(before%values, &
         now%values, next%values, now%came, next%came))
      earlier = .false.
      found = .false.
      do j = 1, size(sought)
         if (first(j)) call find_dip(curve, conditions, before, now, j, reach, found)
         earlier = found
         if (second(j) .and. .not. found) call find_dip(curve, conditions, now, next, j, reach, &
            found)
         if (found) return
      end do
      reach = 0
   end subroutine look_between

   !> A place within a step where a condition has another sign than at both ends.
   !!
   !! Such a place is sought where the value approaches zero at the start of the step and departs
   !! from it at the end. A convex value lies above its tangents: the search ends where they
   !! intersect on the same side of zero.
   pure subroutine find_dip(curve, conditions, from, to, which, reach, found)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Conditions that are zero along the curve.
      type(condition_type), intent(in) :: conditions(:)
      !> Start and end of the step.
      type(place_type), intent(in) :: from, to
      !> Index of the condition.
      integer, intent(in) :: which
      !> Length of the step to that place.
      real(wp), intent(out) :: reach
      !> Whether there is one.
      logical, intent(out) :: found
      integer, parameter :: most_places = 12
      !> What is nearer to an end of the step than this share of it is not distinguished from that
      !! end.
      real(wp), parameter :: margin = 0.02_wp
      type(place_type) :: place
      real(wp), dimension(2) :: at, value, rate
      real(wp) :: cosine, length, meet, sign_of, slope
      integer :: i, iterations, side

      found = .false.
      reach = 0
      length = from_length(from, to)
      cosine = dot_product(from%tangent, to%tangent)
      if (.not. (length > 0 .and. cosine > 0)) return
      sign_of = sign(1.0_wp, from%values(which))
      rate(1) = sign_of*rate_along(curve, from, which)
      if (.not. rate(1) < 0) return
      rate(2) = sign_of*rate_along(curve, to, which)/cosine
      at = [0.0_wp, length]
      value = sign_of*[from%values(which), to%values(which)]
      allocate (place%tangent, mold=from%tangent)
      do i = 1, most_places
         if (.not. rate(2) > 0) return
         meet = (value(2) - value(1) + rate(1)*at(1) - rate(2)*at(2))/(rate(1) - rate(2))
         if (value(1) + rate(1)*(meet - at(1)) > 0) return
         reach = least_of_cubic(at, value, rate)
         if (reach < margin*length .or. reach > (1 - margin)*length) return
         place%point = between(from, to, reach, length, cosine)
         call correct(curve, conditions, place%point, iterations, from%tangent, place%tangent)
         if (iterations == 0) return
         call survey(curve, place)
         if (curve%family%has_other_symbols(place%values)) return
         found = sign_of*place%values(which) < 0
         if (found) return
         slope = sign_of*rate_along(curve, place, which)/dot_product(from%tangent, place%tangent)
         side = merge(1, 2, slope < 0)
         at(side) = reach
         value(side) = sign_of*place%values(which)
         rate(side) = slope
      end do
   end subroutine find_dip

   !> The derivative of a condition along the curve at a place.
   pure real(wp) function rate_along(curve, place, which) result(rate)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> The place, with its tangent and its conditions.
      type(place_type), intent(in) :: place
      !> Index of the condition.
      integer, intent(in) :: which
      real(wp), parameter :: h = 1.0e-6_wp

      rate = (at(h) - at(-h))/(2*h)
   contains
      !> The value at a point of the tangent.
      pure real(wp) function at(step)
         !> Distance from the place.
         real(wp), intent(in) :: step
         real(wp) :: point(size(place%point))

         point = place%point + step*place%tangent
         at = condition_value(curve, unknowns_of(curve, point), parameters_of(curve, point), &
            place%conditions(which))
      end function at
   end function rate_along

   !> The least value of the cubic through two values with given derivatives, well inside.
   pure real(wp) function least_of_cubic(at, value, rate) result(least)
      !> Places, values, and derivatives: the first negative, the second positive.
      real(wp), intent(in) :: at(2), value(2), rate(2)
      real(wp) :: chord, root, share, width

      width = at(2) - at(1)
      chord = 3*(value(1) - value(2))/width + rate(1) + rate(2)
      root = sqrt(chord**2 - rate(1)*rate(2))
      share = (root + chord - rate(1))/(rate(2) - rate(1) + 2*root)
      least = at(1) + width*max(0.1_wp, min(0.9_wp, share))
   end function least_of_cubic

   !> A point of the cubic through both ends of a step with the tangents there.
   pure function between(from, to, reach, length, cosine) result(point)
      !> Start and end of the step.
      type(place_type), intent(in) :: from, to
      !> Distances along the tangent at the start: of the point, and of the end.
      real(wp), intent(in) :: reach, length
      !> Cosine of the angle between the tangents.
      real(wp), intent(in) :: cosine
      real(wp) :: point(size(from%point)), t

      t = reach/length
      point = from%point + t**2*(3 - 2*t)*(to%point - from%point) + length*t*(1 - t)*((1 - t) &
         *from%tangent - t/cosine*to%tangent)
   end function between

   !> The point of a step where a further condition is zero, by Newton's method or else bisection.
   pure subroutine locate(curve, conditions, from, to, which, place, share, good)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Conditions that are zero along the curve.
      type(condition_type), intent(in) :: conditions(:)
      !> Start and end of the step.
      type(place_type), intent(in) :: from, to
      !> Index of the condition that changes its sign.
      integer, intent(in) :: which
      !> Out: the place where the condition is zero, if it is found.
      type(place_type), intent(inout) :: place
      !> Share of the step.
      real(wp), intent(out) :: share
      !> Whether it is found.
      logical, intent(out) :: good
      !> Share of the step on which a value changes by much less than on all of it, if it does not
      !! jump.
      real(wp), parameter :: narrow = 1.0e-3_wp
      type(condition_type) :: extra(1)
      real(wp), dimension(size(from%point)) :: low, high
      real(wp) :: at_low, at_high, length, near
      integer :: i, iterations
      logical :: may_jump

      may_jump = from%conditions(which)%kind == neimark_sacker .and. &
         .not. curve%family%every_crossing
      ! the details of a touch are taken from the end where the gap is less
      extra(1) = to%conditions(which)
      if (any(extra(1)%kind == [grazing, rest_splits, rest_vanishes]) .and. &
         from%values(which) < to%values(which)) then
         extra(1) = from%conditions(which)
      end if
      low = from%point
      high = to%point
      at_low = from%values(which)
      at_high = to%values(which)
      do i = 1, 60
         near = at_low/(at_low - at_high)
         if (mod(i, 3) == 0 .or. .not. abs(near) <= 1) near = 0.5_wp
         place%point = low + near*(high - low)
         call correct(curve, [conditions, extra], place%point, iterations)
         share = dot_product(from%tangent, place%point - from%point)/from_length(from, to)
         good = iterations > 0 .and. share > -1.0e-6_wp .and. share < 1 + 1.0e-6_wp .and. &
            norm2(place%point - from%point) < 2*to%came
         if (good) exit
         length = norm2(high - low)
         if (length < 1.0e-12_wp) exit
         ! where a flip makes it negative, the value of Neimark-Sacker jumps and has no zero
         if (may_jump .and. length < narrow*norm2(to%point - from%point) .and. abs(at_low) > &
            0.5_wp*abs(from%values(which)) .and. abs(at_high) > 0.5_wp*abs(to%values(which))) exit
         ! narrow the bracket
         place%point = low + near*(high - low)
         call correct(curve, conditions, place%point, iterations, from%tangent)
         if (iterations == 0) exit
         call survey(curve, place)
         if (place%values(which)*at_low > 0) then
            low = place%point
            at_low = place%values(which)
         else
            high = place%point
            at_high = place%values(which)
         end if
      end do
      if (.not. good) return
      place%tangent = from%tangent
      place%came = share*to%came
      place%step = to%step
      call survey(curve, place)
      place%conditions(which) = extra(1)
   end subroutine locate

   !> Length of a step along the tangent at its start.
   pure real(wp) function from_length(from, to) result(length)
      !> Start and end of the step.
      type(place_type), intent(in) :: from, to

      length = dot_product(from%tangent, to%point - from%point)
   end function from_length

   !> The zero nearest to the inside end of a step.
   !!
   !! A condition that is violated at a zero of another one was met at the inside end, so it is zero
   !! in between, even if it has the same sign at both ends: a step may pass two of its zeros.
   pure subroutine innermost_zero(curve, now, next, inside, best, which)
      !> The curve, with one active parameter.
      type(curve_type), intent(in) :: curve
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      !> Whether the step begins inside.
      logical, intent(in) :: inside
      !> Out: the place of the zero, if one is found.
      type(place_type), intent(inout) :: best
      !> The condition that is zero there; 0 if none was found.
      integer, intent(out) :: which
      integer, parameter :: most_passes = 4
      type(place_type) :: low, high, found
      type(condition_type) :: none(0)
      real(wp), dimension(size(now%values)) :: at, inner, outer
      logical :: left(size(now%values))
      real(wp) :: share, nearest
      integer :: j, pass
      logical :: good

      low = now
      high = next
      which = 0
      inner = merge(now%values, next%values, inside)
      outer = merge(next%values, now%values, inside)
      at = 0
      do pass = 1, most_passes
         nearest = huge(1.0_wp)
         left = .true.
         do
            ! of the conditions violated at the place found last, the one that appears to be zero
            ! nearest to the inside end
            left = left .and. inner*outer < 0
            if (.not. any(left)) exit
            where (left) at = inner/(inner - outer)
            j = minloc(at, 1, left)
            left(j) = .false.
            call locate(curve, none, low, high, j, found, share, good)
            if (.not. good) cycle
            if (.not. inside) share = 1 - share
            if (share >= nearest) cycle
            nearest = share
            which = j
            best = found
            if (is_inside(best%conditions, best%values + 1.0e-9_wp, curve%active(1))) return
            outer = best%values
         end do
         if (.not. nearest < huge(1.0_wp)) return
         if (inside) then
            high = best
         else
            low = best
         end if
      end do
   end subroutine innermost_zero

end module vi_crossing
