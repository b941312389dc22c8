!> Curves of motions: Newton's method and tangents.
!!
!! With one active parameter, the motions of a family form a curve; with two active parameters, the
!! motions on which one condition is zero (for example, a fold) form a curve.
module vi_curve
   use vi_conditions, only: condition_value
   use vi_curve_point, only: curve_type, parameters_of, point_size, to_point, unknowns_of
   use vi_family, only: repetition_distance
   use vi_frame, only: condition_type, edge, neimark_sacker, unknown_count, wrap_phases
   use vi_kinds, only: wp
   use vi_linear, only: eliminate, most
   use vi_orbit, only: by_clearance, by_left, by_right, n_parameters, orbit_by_parameter, &
      orbit_slopes, orbit_type, set_orbit, span_of
   use vi_rest_conditions, only: measure_in_period, touching_in
   use vi_rest_family, only: measure_type, rest_period, rest_period_type
   use vi_structure_conditions, only: structure_slope
   use vi_structure_family, only: member_equations, member_type, set_member
   use vi_structure_slopes, only: equations_by_parameter
   use vi_slopes, only: has_slope, value_and_slope
   implicit none (type, external)
   private

   public :: correct, distance_from, condition_slope, equations, tangent_at
   public :: curve_type, parameters_of, point_size, unknowns_of

   !> How Newton's method converged.
   type, public :: correction_type
      !> Largest absolute component of each of the first two steps.
      real(wp) :: moved(2) = 0
      !> The sign of the determinant of the equations, where the last one is the direction of
      !! travel. It is constant along a curve, and changes only where curves cross.
      integer :: orientation = 0
   end type correction_type

   integer, parameter :: most_iterations = 8
   !> Residual due to rounding, relative to the coefficients of an equation.
   real(wp), parameter :: rounding = 1.0e-13_wp
   !> A residual that makes Newton's method fail: the period has other symbols.
   real(wp), parameter :: at_fault = huge(1.0_wp)

contains

   !> Newton's method for a point on which conditions are zero and, if there is one condition
   !! fewer than active parameters, which lies in a given plane.
   !!
   !! Equations: those of the motion, the conditions, and normal . (point - start) = 0.
   pure subroutine correct(curve, conditions, point, iterations, normal, tangent, correction)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Conditions that are zero at the point: as many as there are active parameters, or one
      !! fewer with `normal`.
      type(condition_type), intent(in) :: conditions(:)
      !> In: a guess. Out: the last iterate.
      real(wp), intent(inout) :: point(:)
      !> Iterations used; 0 if they did not converge.
      integer, intent(out) :: iterations
      !> Unit normal of the plane through the guess in which the point is to lie.
      real(wp), intent(in), optional :: normal(:)
      !> The unit tangent at the point, on the side of the normal. It comes from the last iteration,
      !! whose step is negligible.
      real(wp), intent(out), optional :: tangent(:)
      !> How the iteration converged.
      type(correction_type), intent(out), optional :: correction
      real(wp) :: a(most, most), b(2, most), start(most), moved, before, residual
      logical :: regular, done
      integer :: i, n, orientation

      n = size(point)
      start(:n) = point
      iterations = 0
      moved = huge(moved)
      do i = 1, most_iterations
         call equations(curve, conditions, point, b, a)
         if (present(normal)) then
            a(:n, n) = normal
            b(:, n) = [dot_product(normal, point - start(:n)), 1.0_wp]
         end if
         call eliminate(n, a, b, regular, residual, orientation)
         if (.not. regular) return
         before = moved
         moved = maxval(abs(b(1, :n)))
         ! written so that a NaN, which maxval skips, ends the iteration
         if (.not. all(abs(b(1, :n)) < 0.5_wp)) return
         if (present(correction)) then
            if (i == 1) correction%moved(1) = moved
            if (i == 2) correction%moved(2) = moved
            correction%orientation = orientation
         end if
         point = point - b(1, :n)
         ! the error after this step is below rounding; where a fold starts at a pitchfork the
         ! residuals are below rounding before the point is known that well
         done = moved < 1.0e-8_wp
         ! quadratic convergence: the ratio of the next step to this one is the square of the ratio
         ! of this one to the previous one; near a singular point the next step is not yet
         ! negligible
         if (done .and. .not. curve%frame%resting .and. i < most_iterations) then
            done = moved*(moved/before)**2 < 1.0e-13_wp .or. moved > 0.5_wp*before
            ! motions that repeat themselves are such singular points
            if (i == 1 .and. moved >= 1.0e-11_wp) done = .not. nearly_repeats(curve, point)
         end if
         if (done .or. (residual < rounding .and. moved < 1.0e-4_wp .and. &
            moved > 0.9_wp*before)) then
            if (in_order(curve, point)) iterations = i
            if (present(tangent)) tangent = b(2, :n)/norm2(b(2, :n))
            return
         end if
      end do
   end subroutine correct

   !> Whether a motion is near one that repeats itself within its period.
   pure logical function nearly_repeats(curve, point)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> A point of it.
      real(wp), intent(in) :: point(:)
      integer :: j

      nearly_repeats = .false.
      associate (frame => curve%frame)
         do j = 1, size(frame%repetitions)
            nearly_repeats = nearly_repeats .or. repetition_distance(frame%family, &
               frame%repetitions(j), point(:unknown_count(frame))) < 10*frame%apart
         end do
      end associate
   end function nearly_repeats

   !> Distance of a point from the place where a curve crosses the plane through it; huge if
   !! Newton's method does not find the curve there.
   pure real(wp) function distance_from(curve, conditions, guess, normal, point)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Conditions that are zero along it.
      type(condition_type), intent(in) :: conditions(:)
      !> Approximate place of the crossing; it is moved into the plane.
      real(wp), intent(in) :: guess(:)
      !> Unit normal of the plane.
      real(wp), intent(in) :: normal(:)
      !> The point.
      real(wp), intent(in) :: point(:)
      real(wp), dimension(size(point)) :: place, offset
      integer :: iterations

      offset = point - guess
      call wrap_phases(curve%frame, offset)
      place = guess + dot_product(offset, normal)*normal
      distance_from = huge(1.0_wp)
      call correct(curve, conditions, place, iterations, normal)
      if (iterations == 0) return
      offset = point - place
      call wrap_phases(curve%frame, offset)
      distance_from = norm2(offset)
   end function distance_from

   !> Whether the impacts are in the order of time; the equations have other roots as well.
   pure logical function in_order(curve, point)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> A root of its equations.
      real(wp), intent(in) :: point(:)
      real(wp) :: slack
      integer :: n

      in_order = .true.
      if (curve%frame%resting) return
      n = size(curve%frame%family%sides)
      ! impacts on two gaps of a structure may change their order, which is located like a touch
      slack = merge(0.1_wp, 0.0_wp, allocated(curve%frame%structure))
      in_order = all(point(n + 2:2*n) > point(n + 1:2*n - 1) - slack) .and. point(2*n) &
         - point(n + 1) < span_of(curve%frame%family) + slack
   end function in_order

   !> Residuals of the motion and of the conditions, each with its gradient; the second right-hand
   !! sides are 0.
   pure subroutine equations(curve, conditions, point, b, a)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Conditions that are to be zero.
      type(condition_type), intent(in) :: conditions(:)
      !> A guess.
      real(wp), intent(in) :: point(:)
      !> Out: b(1, j): residual j, b(2, :): 0; a(:, j): gradient of residual j with respect to the
      !! coordinates.
      real(wp), intent(inout) :: b(2, most), a(most, most)
      type(orbit_type) :: o
      real(wp) :: c(n_parameters), slope(most)
      integer :: n, j, k

      n = unknown_count(curve%frame)
      b(2, :size(point)) = 0
      if (curve%frame%resting) then
         call rest_equations(curve, conditions, point, b, a)
         return
      else if (allocated(curve%frame%structure)) then
         call structure_equations(curve, conditions, point, b, a)
         return
      end if
      c = parameters_of(curve, point)
      call set_orbit(curve%frame%family, point(:n), c, o)
      call orbit_slopes(o, a, b(1, :n))
      do j = 1, n
         call to_point(curve, a(:, j))
      end do
      do k = 1, size(curve%active)
         if (curve%active(k) <= by_clearance) cycle
         slope(:n) = orbit_by_parameter(o, curve%active(k))
         if (curve%tied .and. curve%active(k) == by_right) slope(:n) = slope(:n) &
            + orbit_by_parameter(o, by_left)
         a(n + k, :n) = curve%scale(k)*slope(:n)
      end do
      do j = 1, size(conditions)
         call orbit_slope(curve, conditions(j), point, c, o, b(1, n + j), a(:, n + j))
      end do
   end subroutine equations

   !> As `equations`, for motions with rest.
   pure subroutine rest_equations(curve, conditions, point, b, a)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Conditions that are to be zero.
      type(condition_type), intent(in) :: conditions(:)
      !> A guess.
      real(wp), intent(in) :: point(:)
      !> Out: b(1, j): residual j, or huge where the symbols cannot be followed; a(:, j): its
      !! gradient with respect to the coordinates.
      real(wp), intent(inout) :: b(2, most), a(most, most)
      type(rest_period_type) :: period
      type(measure_type) :: measure
      real(wp) :: c(n_parameters)
      integer :: j, m, n

      m = unknown_count(curve%frame)
      n = m + size(conditions)
      b(1, :n) = at_fault
      a(:size(point), :n) = 0
      c = parameters_of(curve, point)
      call rest_period(curve%frame%rest, point(:m), c, period, touching_in(conditions))
      if (.not. period%right) return
      do j = 1, n
         if (j <= m) then
            measure = period%equations(j)
         else
            measure = measure_in_period(period, c, conditions(j - m))
         end if
         b(1, j) = measure%value
         a(:m + 2, j) = measure%by(:m + 2)
         call to_point(curve, a(:, j))
      end do
      do j = 1, size(conditions)
         if (conditions(j)%kind > neimark_sacker) cycle
         call differences(curve, conditions(j), point, 1, a(:size(point), m + j))
      end do
      if (any(curve%active > by_clearance)) call rest_differences(curve, conditions, point, a)
   end subroutine rest_equations

   !> As `equations`, for motions of a structure.
   pure subroutine structure_equations(curve, conditions, point, b, a)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Conditions that are to be zero.
      type(condition_type), intent(in) :: conditions(:)
      !> A guess.
      real(wp), intent(in) :: point(:)
      !> Out: b(1, j): residual j, or huge where there is no motion; a(:, j): its gradient with
      !! respect to the coordinates.
      real(wp), intent(inout) :: b(2, most), a(most, most)
      type(member_type) :: member
      real(wp) :: c(n_parameters), slope(unknown_count(curve%frame)), &
         jacobian(size(slope), size(slope))
      integer :: j, k, m
      logical :: good

      m = size(slope)
      b(1, :m + size(conditions)) = at_fault
      a(:size(point), :m + size(conditions)) = 0
      c = parameters_of(curve, point)
      associate (s => curve%frame%structure, family => curve%frame%family, &
         shares => c(:size(curve%frame%structure%path%changes)))
         call set_member(s, family, point(:m), shares, member)
         if (.not. member%exists) return
         call member_equations(s, family, member, slope, jacobian)
         b(1, :m) = slope
         a(:m, :m) = jacobian
         do k = 1, size(curve%active)
            call equations_by_parameter(s, family, point(:m), shares, member, curve%active(k), &
               slope, good)
            if (.not. good) b(1, :m) = at_fault
            if (.not. good) return
            a(m + k, :m) = curve%scale(k)*slope
         end do
      end associate
      do j = 1, size(conditions)
         call member_slope(curve, conditions(j), point, member, b(1, m + j), &
            a(:size(point), m + j))
      end do
   end subroutine structure_equations

   !> The derivatives of the equations of motions with rest with respect to parameters other than r
   !! and log(D), by central differences.
   pure subroutine rest_differences(curve, conditions, point, a)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Conditions that are to be zero.
      type(condition_type), intent(in) :: conditions(:)
      !> A guess.
      real(wp), intent(in) :: point(:)
      !> In and out: gradients, a column each; the rows of such parameters are set.
      real(wp), intent(inout) :: a(most, most)
      real(wp), parameter :: h = 1.0e-6_wp
      real(wp) :: moved(size(point)), ahead(unknown_count(curve%frame) + size(conditions))
      integer :: k, m

      m = unknown_count(curve%frame)
      do k = 1, size(curve%active)
         if (curve%active(k) <= by_clearance) cycle
         moved = point
         moved(m + k) = point(m + k) + h
         ahead = rest_values(curve, conditions, moved)
         moved(m + k) = point(m + k) - h
         a(m + k, :size(ahead)) = (ahead - rest_values(curve, conditions, moved))/(2*h)
      end do
   end subroutine rest_differences

   !> Residual of a period with rest, and the conditions that the same period gives.
   pure function rest_values(curve, conditions, point) result(values)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Conditions whose values are wanted.
      type(condition_type), intent(in) :: conditions(:)
      !> A guess.
      real(wp), intent(in) :: point(:)
      real(wp) :: values(unknown_count(curve%frame) + size(conditions))
      type(rest_period_type) :: period
      type(measure_type) :: measure
      real(wp) :: c(n_parameters)
      integer :: j, m

      m = unknown_count(curve%frame)
      values = at_fault
      c = parameters_of(curve, point)
      call rest_period(curve%frame%rest, point(:m), c, period)
      if (.not. period%right) return
      values(:m) = period%equations%value
      do j = 1, size(conditions)
         measure = measure_in_period(period, c, conditions(j))
         values(m + j) = measure%value
      end do
   end function rest_values

   !> Value of a condition, and its gradient with respect to the coordinates of a point.
   pure subroutine condition_slope(curve, condition, point, value, slope)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> The condition.
      type(condition_type), intent(in) :: condition
      !> A point of the curve.
      real(wp), intent(in) :: point(:)
      !> The value, and the gradient (as `point`).
      real(wp), intent(out) :: value, slope(:)
      type(member_type) :: member
      type(orbit_type) :: o
      real(wp) :: c(n_parameters), whole(most)

      c = parameters_of(curve, point)
      if (curve%frame%resting) then
         call rest_slope(curve, condition, point, c, value, slope)
      else if (allocated(curve%frame%structure)) then
         if (condition%kind == edge) then
            call member_slope(curve, condition, point, member, value, slope)
         else
            call set_member(curve%frame%structure, curve%frame%family, unknowns_of(curve, point), &
               c(:size(curve%frame%structure%path%changes)), member)
            call member_slope(curve, condition, point, member, value, slope)
         end if
      else
         call set_orbit(curve%frame%family, unknowns_of(curve, point), c, o)
         call orbit_slope(curve, condition, point, c, o, value, whole)
         slope = whole(:size(slope))
      end if
   end subroutine condition_slope

   !> As `condition_slope`, for a motion of a structure.
   pure subroutine member_slope(curve, condition, point, member, value, slope)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> The condition.
      type(condition_type), intent(in) :: condition
      !> A point of the curve.
      real(wp), intent(in) :: point(:)
      !> In and out: the motion, as in `structure_slope`; not used for an edge.
      type(member_type), intent(inout) :: member
      !> The value, and the gradient (as `point`).
      real(wp), intent(out) :: value, slope(:)
      real(wp) :: c(n_parameters)

      c = parameters_of(curve, point)
      associate (by => slope(size(slope) - size(curve%active) + 1:))
         if (condition%kind == edge) then
            value = condition_value(curve%frame, unknowns_of(curve, point), c, condition)
            slope = 0
            where (curve%active == condition%index) by = condition%side*curve%scale
         else
            call structure_slope(curve%frame, unknowns_of(curve, point), c, condition, &
               curve%active, member, value, slope)
            by = curve%scale*by
         end if
      end associate
   end subroutine member_slope

   !> As `condition_slope`, for a motion with rest.
   pure subroutine rest_slope(curve, condition, point, c, value, slope)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> The condition.
      type(condition_type), intent(in) :: condition
      !> A point of the curve, and the parameters there.
      real(wp), intent(in) :: point(:), c(:)
      !> The value, and the gradient (as `point`).
      real(wp), intent(out) :: value, slope(:)
      type(rest_period_type) :: period
      type(measure_type) :: measure
      real(wp) :: whole(most)
      integer :: m

      m = unknown_count(curve%frame)
      call rest_period(curve%frame%rest, point(:m), c, period)
      measure = measure_in_period(period, c, condition)
      value = measure%value
      whole(:m + 2) = measure%by(:m + 2)
      call to_point(curve, whole)
      slope = whole(:size(slope))
      if (condition%kind <= neimark_sacker .or. any(curve%active > by_clearance)) then
         call differences(curve, condition, point, 1, slope)
      end if
   end subroutine rest_slope

   !> As `condition_slope`, from the orbit of the point; central differences where no closed form
   !! is known.
   pure subroutine orbit_slope(curve, condition, point, c, o, value, slope)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> The condition.
      type(condition_type), intent(in) :: condition
      !> A point of the curve, and the parameters there.
      real(wp), intent(in) :: point(:), c(:)
      !> The orbit of the point.
      type(orbit_type), intent(in) :: o
      !> The value, and the gradient (the first elements, as `point`).
      real(wp), intent(out) :: value, slope(most)
      integer :: n

      n = unknown_count(curve%frame)
      if (has_slope(condition)) then
         call value_and_slope(curve%frame, point(:n), c, o, condition, value, slope(:n + 2))
         call to_point(curve, slope)
         if (any(curve%active > by_clearance)) call differences(curve, condition, point, n + 1, &
            slope(:size(point)))
      else
         value = condition_value(curve%frame, point(:n), c, condition)
         call differences(curve, condition, point, 1, slope(:size(point)))
      end if
   end subroutine orbit_slope

   !> The derivatives of a condition with respect to all coordinates from a given one on, by central
   !! differences.
   pure subroutine differences(curve, condition, point, first, slope)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> The condition.
      type(condition_type), intent(in) :: condition
      !> A point of the curve.
      real(wp), intent(in) :: point(:)
      !> Number of the first coordinate.
      integer, intent(in) :: first
      !> (as `point`) In and out: elements from `first` on are set.
      real(wp), intent(inout) :: slope(:)
      real(wp) :: moved(size(point)), h
      integer :: j

      h = 1.0e-6_wp
      do j = first, size(point)
         moved = point
         moved(j) = point(j) + h
         slope(j) = at(moved)
         moved(j) = point(j) - h
         slope(j) = (slope(j) - at(moved))/(2*h)
      end do
   contains
      !> The value of the condition at a nearby point.
      pure real(wp) function at(place)
         !> The point.
         real(wp), intent(in) :: place(:)

         at = condition_value(curve%frame, unknowns_of(curve, place), parameters_of(curve, place), &
            condition)
      end function at
   end subroutine differences

   !> The unit tangent of a curve at a point of it, in the direction of a given vector.
   pure subroutine tangent_at(curve, conditions, point, along, tangent, regular, orientation)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> One condition fewer than there are active parameters.
      type(condition_type), intent(in) :: conditions(:)
      !> A point of the curve, and a vector to which the tangent is not orthogonal.
      real(wp), intent(in) :: point(:), along(:)
      !> The unit tangent, on the side of `along`; 0 if it is not defined.
      real(wp), intent(out) :: tangent(:)
      !> False if the tangent is not defined, for example where curves cross.
      logical, intent(out) :: regular
      !> As in `correction_type`, with `along` as the direction of travel.
      integer, intent(out), optional :: orientation
      real(wp) :: a(most, most), b(2, most), unused
      integer :: n, sign

      n = size(point)
      call equations(curve, conditions, point, b, a)
      a(:n, n) = along
      b(:, n) = [0, 1]
      call eliminate(n, a, b, regular, unused, sign)
      tangent = 0
      if (regular) tangent = b(2, :n)/norm2(b(2, :n))
      if (present(orientation)) orientation = sign
   end subroutine tangent_at

end module vi_curve
