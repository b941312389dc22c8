!> Steps along a curve of motions.
module vi_steps
   use vi_conditions, only: all_conditions, condition_count
   use vi_curve, only: correct, correction_type, curve_type, parameters_of, tangent_at, unknowns_of
   use vi_kinds, only: wp
   use vi_linear, only: most
   use vi_motion_family, only: condition_type, neimark_sacker, repetition
   use vi_spectrum, only: spectrum_type
   implicit none (type, external)
   private

   public :: begin_walk, can_shorten, exchange, survey, take_step

   !> A point of a curve with the direction of travel and all conditions.
   type, public :: place_type
      real(wp), allocatable :: point(:), tangent(:), values(:)
      type(condition_type), allocatable :: conditions(:)
      !> The curve departs from the tangent by bend(:, 1) s^2 + bend(:, 2) s^3, extrapolated from
      !! the last step.
      real(wp), allocatable :: bend(:, :)
      !> Length of the step that led here, and of the next one to be tried.
      real(wp) :: came = 0, step = 0
      !> Whether that step jumped over a point where curves cross.
      logical :: leapt = .false.
      !> As in `correction_type`; 0 if not known.
      integer :: orientation = 0
      !> Sums of its multipliers.
      type(spectrum_type) :: spectrum
   end type place_type

   !> Limits on steps: longest and shortest length, largest turn (rad), and the length of a jump
   !! over a crossing.
   type, public :: stride_type
      real(wp) :: longest = 0.05_wp, shortest = 1.0e-7_wp, turn = 0.2_wp, leap = 2.0e-4_wp
   end type stride_type

contains

   !> The first place of a walk along a curve, from a point and a direction.
   pure subroutine begin_walk(curve, conditions, point, along, step, place, regular)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Conditions that are zero along the curve.
      type(condition_type), intent(in) :: conditions(:)
      !> A point of the curve, a vector to which the tangent is not orthogonal, and the length of
      !! the first step.
      real(wp), intent(in) :: point(:), along(:), step
      !> The place.
      type(place_type), intent(out) :: place
      !> False if the tangent is not defined there.
      logical, intent(out) :: regular

      place%point = point
      allocate (place%tangent(size(point)))
      allocate (place%bend(size(point), 2), source=0.0_wp)
      call tangent_at(curve, conditions, point, along, place%tangent, regular, place%orientation)
      ! with a condition the orientation may change at the start
      if (size(conditions) > 0) place%orientation = 0
      place%step = step
      call survey(curve, place)
   end subroutine begin_walk

   !> Exchanges two places.
   pure subroutine exchange(a, b)
      !> In and out: exchanged, without copying their arrays.
      type(place_type), intent(inout) :: a, b
      type(place_type) :: c

      call move(a, c)
      call move(b, a)
      call move(c, b)
   end subroutine exchange

   !> Moves a place, without copying its arrays.
   pure subroutine move(from, to)
      !> `from`: in: the place, out: without its arrays; `to`: out: the place.
      type(place_type), intent(inout) :: from, to

      call move_alloc(from%point, to%point)
      call move_alloc(from%tangent, to%tangent)
      call move_alloc(from%values, to%values)
      call move_alloc(from%conditions, to%conditions)
      call move_alloc(from%bend, to%bend)
      to%came = from%came
      to%step = from%step
      to%leapt = from%leapt
      to%orientation = from%orientation
      to%spectrum = from%spectrum
   end subroutine move

   !> Evaluates all conditions at a place.
   pure subroutine survey(curve, place)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> In: with its point. Out: values, conditions and spectrum are set.
      type(place_type), intent(inout) :: place
      integer :: n

      n = condition_count(curve)
      if (.not. allocated(place%values)) allocate (place%values(n), place%conditions(n))
      call all_conditions(curve, unknowns_of(curve, place%point), parameters_of(curve, &
         place%point), place%values, place%conditions, place%spectrum)
   end subroutine survey

   !> One step along a curve, shortened until Newton's method converges and the turn is small.
   pure subroutine take_step(curve, conditions, stride, from, to, good, blind)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Conditions that are zero along the curve.
      type(condition_type), intent(in) :: conditions(:)
      !> Limits on the step.
      type(stride_type), intent(in) :: stride
      !> The place where the step begins.
      type(place_type), intent(in) :: from
      !> Out: the place where it ends; its arrays are reused.
      type(place_type), intent(inout) :: to
      !> False if the curve could not be followed.
      logical, intent(out) :: good
      !> Whether the other conditions are not evaluated.
      logical, intent(in), optional :: blind
      type(correction_type) :: correction
      real(wp) :: step, turn
      integer :: iterations
      logical :: leaps

      leaps = .false.
      step = min(from%step, stride%longest)
      turn = 0
      good = .false.
      if (.not. allocated(to%point)) allocate (to%point, mold=from%point)
      if (.not. allocated(to%tangent)) allocate (to%tangent, mold=from%tangent)
      do
         to%point = from%point + step*from%tangent
         if (.not. leaps) call bend_over(from, step, to%point)
         call correct(curve, conditions, to%point, iterations, from%tangent, to%tangent, correction)
         if (iterations > 0 .and. curve%family%jumps) then
            call survey(curve, to)
            if (curve%family%has_other_symbols(to%values)) iterations = 0
         end if
         if (iterations > 0) then
            turn = turn_of(from%tangent, to%tangent, size(curve%active))
            good = turn < merge(0.5_wp, stride%turn, leaps) .or. step <= 64*stride%shortest
            if (good .and. .not. leaps) good = keeps_to_curve(curve, conditions, from, to, step, &
               correction)
         end if
         if (good) exit
         if (leaps) return
         step = 0.5_wp*step
         if (step < stride%shortest) then
            ! where curves cross, no step is short enough, but a longer one passes the crossing
            leaps = .true.
            step = stride%leap
         end if
      end do
      to%came = step
      to%step = step
      to%leapt = leaps
      to%orientation = correction%orientation
      call look_back(from, to)
      if (present(blind)) then
         if (blind) return
      end if
      if (iterations <= 4 .and. turn < 0.5_wp*stride%turn) to%step = 1.6_wp*step
      if (.not. curve%family%jumps) call survey(curve, to)
      call mark_passage(curve, from, to)
   end subroutine take_step

   !> Whether the end of a step appears to lie on the curve on which the step began.
   pure logical function keeps_to_curve(curve, conditions, from, to, step, correction) result(keeps)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Conditions that are zero along the curve.
      type(condition_type), intent(in) :: conditions(:)
      !> Start and end of the step.
      type(place_type), intent(in) :: from, to
      !> Its length along the tangent.
      real(wp), intent(in) :: step
      !> How Newton's method converged at its end.
      type(correction_type), intent(in) :: correction

      real(wp), parameter :: large = 0.1_wp, slow = 0.3_wp
      real(wp), dimension(most) :: chord, middle, start
      integer :: iterations, n
      real(wp) :: length

      keeps = .true.
      if (curve%family%jumps) return
      if (.not. any(conditions%kind == neimark_sacker)) keeps = &
         from%orientation*correction%orientation >= 0
      if (.not. keeps) return
      associate (moved => correction%moved)
         if (moved(1) < 1.0e-3_wp*step) return
         if (moved(1) < large*step .and. moved(2) < slow*moved(1)) return
      end associate
      ! the cubic that joins both ends
      n = size(from%point)
      chord(:n) = to%point - from%point
      length = norm2(chord(:n))
      middle(:n) = from%point + 0.5_wp*chord(:n) + 0.125_wp*length*(from%tangent - to%tangent)
      start(:n) = middle(:n)
      chord(:n) = chord(:n)/length
      call correct(curve, conditions, middle(:n), iterations, chord(:n))
      keeps = iterations > 0 .and. norm2(middle(:n) - start(:n)) < 0.05_wp*length
   end function keeps_to_curve

   !> Whether the step that led to a place can be repeated with a shorter length. A step that jumped
   !! over a crossing is the shortest that passes it.
   pure logical function can_shorten(place, shortest)
      !> The end of the step.
      type(place_type), intent(in) :: place
      !> Least length of a step.
      real(wp), intent(in) :: shortest

      can_shorten = place%came > shortest .and. .not. place%leapt
   end function can_shorten

   !> Corrects a point on the tangent by the expected curvature of the curve, if that is small.
   pure subroutine bend_over(from, step, point)
      !> The place where the tangent begins.
      type(place_type), intent(in) :: from
      !> Distance along the tangent.
      real(wp), intent(in) :: step
      !> In: the point on the tangent. Out: corrected.
      real(wp), intent(inout) :: point(:)
      integer :: j

      if (maxval(abs(from%bend(:, 1))) + step*maxval(abs(from%bend(:, 2))) > 0.3_wp/step) return
      do j = 1, size(point)
         point(j) = point(j) + step**2*(from%bend(j, 1) + step*from%bend(j, 2))
      end do
   end subroutine bend_over

   !> The cubic through both ends of a step with the tangents there, in powers of the distance from
   !! its end.
   pure subroutine look_back(from, to)
      !> The place where the step begins.
      type(place_type), intent(in) :: from
      !> The place where it ends. Out: `bend` is set; 0 if the step turned too much.
      type(place_type), intent(inout) :: to
      real(wp) :: length, cosine, off, slope
      integer :: j

      if (.not. allocated(to%bend)) allocate (to%bend(size(to%point), 2))
      to%bend = 0
      if (to%leapt) return
      length = dot_product(to%tangent, to%point - from%point)
      cosine = dot_product(to%tangent, from%tangent)
      if (length < 0.5_wp*to%came .or. cosine < 0.5_wp) return
      do j = 1, size(to%point)
         off = (from%point(j) - to%point(j))/length + to%tangent(j)
         slope = from%tangent(j)/cosine - to%tangent(j)
         to%bend(j, 1) = (3*off + slope)/length
         to%bend(j, 2) = (2*off + slope)/length**2
      end do
   end subroutine look_back

   !> Makes the distance to a motion that repeats itself negative, if the step has passed that
   !! motion.
   pure subroutine mark_passage(curve, from, to)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> The place where the step begins.
      type(place_type), intent(in) :: from
      !> The place where it ends. Out: the values of such conditions may be negative.
      type(place_type), intent(inout) :: to
      real(wp), dimension(size(to%point) - size(curve%active)) :: a, b
      integer :: j

      do j = 1, size(to%values)
         if (to%conditions(j)%kind /= repetition .or. to%values(j) < 0) cycle
         associate (family => curve%family, &
            way => curve%family%repetitions(to%conditions(j)%index))
            a = unknowns_of(curve, from%point)
            a = family%image_of(way, a) - a
            b = unknowns_of(curve, to%point)
            b = family%image_of(way, b) - b
         end associate
         if (dot_product(a, b) < 0) to%values(j) = -to%values(j) - 2*to%conditions(j)%bound
      end do
   end subroutine mark_passage

   !> The greater of the turns in the whole space and in the plane of two parameters.
   pure real(wp) function turn_of(a, b, active) result(turn)
      !> Unit tangents at both ends of a step.
      real(wp), intent(in) :: a(:), b(:)
      !> Number of active parameters, the last coordinates.
      integer, intent(in) :: active
      real(wp) :: lengths
      integer :: n

      turn = acos(max(-1.0_wp, min(1.0_wp, dot_product(a, b))))
      if (active < 2) return
      n = size(a)
      lengths = norm2(a(n - 1:))*norm2(b(n - 1:))
      ! at a cusp of the projection the curve itself is smooth: where the curve hardly moves in the
      ! plane, its turn in the plane counts less
      if (lengths > 1.0e-6_wp) turn = max(turn, min(1.0_wp, 10*sqrt(lengths))* &
         asin(min(1.0_wp, abs(a(n - 1)*b(n) - a(n)*b(n - 1))/lengths)))
   end function turn_of

end module vi_steps
