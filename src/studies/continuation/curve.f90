!> Curves of motions: Newton's method and tangents.
!!
!! With one active parameter, the motions of a family form a curve; with two active parameters, the
!! motions on which one condition is zero (for example, a fold) form a curve.
module vi_curve
   use vi_conditions, only: edge_value
   use vi_curve_point, only: curve_type, parameters_of, point_size, unknowns_of
   use vi_kinds, only: wp
   use vi_linear, only: eliminate, most
   use vi_motion_family, only: condition_type, edge, repeats
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
         if (done .and. .not. curve%family%jumps .and. i < most_iterations) then
            done = moved*(moved/before)**2 < 1.0e-13_wp .or. moved > 0.5_wp*before
            ! motions that repeat themselves are such singular points
            if (i == 1 .and. moved >= 1.0e-11_wp) done = .not. repeats(curve%family, &
               unknowns_of(curve, point), 10*curve%family%apart)
         end if
         if (done .or. (residual < rounding .and. moved < 1.0e-4_wp .and. &
            moved > 0.9_wp*before)) then
            if (curve%family%in_order(unknowns_of(curve, point))) iterations = i
            if (present(tangent)) tangent = b(2, :n)/norm2(b(2, :n))
            return
         end if
      end do
   end subroutine correct

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
      call curve%family%wrap_phases(offset)
      place = guess + dot_product(offset, normal)*normal
      distance_from = huge(1.0_wp)
      call correct(curve, conditions, place, iterations, normal)
      if (iterations == 0) return
      offset = point - place
      call curve%family%wrap_phases(offset)
      distance_from = norm2(offset)
   end function distance_from

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
      real(wp) :: c(size(curve%c))
      integer :: j, n

      n = size(point) - size(curve%active)
      b(2, :size(point)) = 0
      call curve%family%set_equations(curve%coordinates_type, conditions, point, b, a)
      do j = 1, size(conditions)
         if (conditions(j)%kind /= edge) cycle
         c = parameters_of(curve, point)
         b(1, n + j) = edge_value(conditions(j), c(conditions(j)%index))
         a(:n, n + j) = 0
         a(n + 1:size(point), n + j) = merge(conditions(j)%side*curve%scale, 0.0_wp, &
            curve%active == conditions(j)%index)
      end do
   end subroutine equations

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
      real(wp) :: a(most, most), b(2, most)
      integer :: n

      n = size(point) - size(curve%active)
      call equations(curve, [condition], point, b, a)
      value = b(1, n + 1)
      slope = a(:size(slope), n + 1)
   end subroutine condition_slope

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
