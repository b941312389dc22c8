!> Curves of motions: Newton's method and tangents for the motions under some conditions.
!!
!! A point of a curve is (u_i, theta_i, q_j): the unknowns of the motion, then one or two active
!! parameters in units of their scale. With one active parameter the motions alone are a curve; with
!! two, those that meet one condition (a fold, say).
module vi_curve
   use vi_conditions, only: condition_value
   use vi_frame, only: condition_type, frame_type, neimark_sacker, unknown_count
   use vi_kinds, only: wp
   use vi_linear, only: add, eliminate, linear_type, most_free, most_numbers
   use vi_orbit, only: by_left, by_right, n_parameters, orbit_by_parameter, orbit_matrix, &
      orbit_residual, orbit_type, set_orbit
   use vi_rest_conditions, only: value_in_period
   use vi_rest_family, only: rest_period, rest_period_type
   implicit none (type, external)
   private

   public :: parameters_of, point_size, correct, gradient, tangent_at, unknowns_of

   type, public :: curve_type
      type(frame_type) :: frame
      !> All parameters; those that are active are given by the point.
      real(wp) :: c(n_parameters) = 0
      !> Whether R2 is always R1.
      logical :: tied = .false.
      !> Which parameters are active, where their coordinate is 0, and its unit.
      integer, allocatable :: active(:)
      real(wp), allocatable :: origin(:), scale(:)
   end type curve_type

   integer, parameter :: most_iterations = 8
   !> A residual that no Newton step survives: the period has other letters.
   real(wp), parameter :: at_fault = huge(1.0_wp)

contains

   !> Numbers in a point.
   pure integer function point_size(curve)
      type(curve_type), intent(in) :: curve

      point_size = unknown_count(curve%frame) + size(curve%active)
   end function point_size

   !> The parameters at a point.
   pure function parameters_of(curve, point) result(c)
      type(curve_type), intent(in) :: curve
      real(wp), intent(in) :: point(:)
      real(wp) :: c(n_parameters)
      integer :: j, n

      c = curve%c
      n = unknown_count(curve%frame)
      do j = 1, size(curve%active)
         c(curve%active(j)) = curve%origin(j) + curve%scale(j)*point(n + j)
      end do
      if (curve%tied) c(by_left) = c(by_right)
   end function parameters_of

   !> The unknowns (u_i, theta_i) at a point.
   pure function unknowns_of(curve, point) result(unknowns)
      type(curve_type), intent(in) :: curve
      real(wp), intent(in) :: point(:)
      real(wp) :: unknowns(unknown_count(curve%frame))

      unknowns = point(:size(unknowns))
   end function unknowns_of

   !> Newton's method for a point under conditions and, if that is not enough, in a plane.
   !!
   !! Equations: those of the motion, the conditions, and normal . (point - start) = 0.
   pure subroutine correct(curve, conditions, point, iterations, normal)
      type(curve_type), intent(in) :: curve
      type(condition_type), intent(in) :: conditions(:)
      !> In: a guess. Out: the last iterate.
      real(wp), intent(inout) :: point(:)
      !> Iterations used; 0 if they did not converge.
      integer, intent(out) :: iterations
      real(wp), intent(in), optional :: normal(:)
      type(linear_type) :: linear
      real(wp), dimension(most_numbers) :: start, step
      real(wp) :: wanted(size(conditions)), moved
      logical :: regular, simulated
      integer :: i, j, n

      n = size(point)
      start(:n) = point
      iterations = 0
      simulated = curve%frame%resting .and. any(conditions%kind <= neimark_sacker)
      do i = 1, most_iterations
         call linear_equations(curve, conditions, point, linear)
         if (present(normal)) call add(linear, normal, dot_product(normal, point - start(:n)))
         call eliminate(linear, n, step, regular)
         if (.not. regular) return
         if (linear%n_free > 0) then
            wanted = [(value_at(curve, conditions(j), point - step(:n)), j=1, size(conditions))]
            call meet(curve, conditions, point - step(:n), wanted, linear, step(:n), regular)
            if (.not. regular) return
         end if
         moved = maxval(abs(step(:n)))
         if (.not. moved < 0.5_wp) return
         point = point - step(:n)
         ! the matrix is right to 1e-8 or better: what is left after this step is below rounding;
         ! the multipliers of a simulated map are differences, and so less sharp
         if (moved < merge(1.0e-6_wp, 1.0e-8_wp, simulated)) then
            iterations = i
            return
         end if
      end do
   end subroutine correct

   !> Adds to a step what changes the conditions by the values wanted, along the free directions.
   !!
   !! Only along these one or two directions are the slopes of a condition wanted, since it costs
   !! more than all the linear algebra.
   pure subroutine meet(curve, conditions, point, wanted, linear, step, regular)
      type(curve_type), intent(in) :: curve
      type(condition_type), intent(in) :: conditions(:)
      real(wp), intent(in) :: point(:), wanted(:)
      type(linear_type), intent(in) :: linear
      real(wp), intent(inout) :: step(:)
      logical, intent(out) :: regular
      type(linear_type) :: small
      real(wp) :: share(most_free), slope(most_free)
      integer :: j, k, n

      n = linear%n_free
      do j = 1, size(conditions)
         if (is_linear(curve, conditions(j))) cycle
         do k = 1, n
            slope(k) = slope_along(curve, conditions(j), point, linear%free(:size(step), k))
         end do
         call add(small, slope(:n), wanted(j))
      end do
      call eliminate(small, n, share, regular)
      if (regular) step = step + matmul(linear%free(:size(step), :n), share(:n))
   end subroutine meet

   !> Whether a condition is among the linear equations: a period with rest gives the values of all
   !! conditions but those of stability.
   elemental logical function is_linear(curve, condition)
      type(curve_type), intent(in) :: curve
      type(condition_type), intent(in) :: condition

      is_linear = curve%frame%resting .and. condition%kind > neimark_sacker
   end function is_linear

   !> The equations of the motion for a step of Newton's method.
   pure subroutine linear_equations(curve, conditions, point, linear)
      type(curve_type), intent(in) :: curve
      type(condition_type), intent(in) :: conditions(:)
      real(wp), intent(in) :: point(:)
      type(linear_type), intent(inout) :: linear
      type(orbit_type) :: o
      real(wp) :: c(n_parameters), matrix(size(point), size(point))
      integer :: n, j

      if (curve%frame%resting) then
         call rest_equations(curve, pack(conditions, is_linear(curve, conditions)), point, linear)
         return
      end if
      n = unknown_count(curve%frame)
      c = parameters_of(curve, point)
      call set_orbit(curve%frame%family, point(:n), c, o)
      call orbit_matrix(o, matrix(:n, :n))
      do j = 1, size(curve%active)
         matrix(:n, n + j) = curve%scale(j)*orbit_by_parameter(curve%frame%family, point(:n), c, &
            o, curve%active(j))
         if (curve%tied .and. curve%active(j) == by_right) matrix(:n, n + j) = matrix(:n, n + j) &
            + curve%scale(j)*orbit_by_parameter(curve%frame%family, point(:n), c, o, by_left)
      end do
      linear%m = n
      linear%right(:n) = orbit_residual(o)
      do j = 1, n
         linear%row(:size(point), j) = matrix(j, :)
      end do
   end subroutine linear_equations

   !> The same for motions with rest, whose map is simulated: the derivatives are differences.
   pure subroutine rest_equations(curve, conditions, point, linear)
      type(curve_type), intent(in) :: curve
      type(condition_type), intent(in) :: conditions(:)
      real(wp), intent(in) :: point(:)
      type(linear_type), intent(inout) :: linear
      real(wp), parameter :: h = 1.0e-7_wp
      real(wp) :: moved(size(point))
      integer :: j, n

      n = 2 + size(conditions)
      linear%m = n
      linear%right(:n) = rest_values(curve, conditions, point)
      do j = 1, size(point)
         moved = point
         moved(j) = point(j) + h
         linear%row(j, :n) = (rest_values(curve, conditions, moved) - linear%right(:n))/h
      end do
   end subroutine rest_equations

   !> Residual of a period with rest, and the conditions that the same period gives.
   pure function rest_values(curve, conditions, point) result(values)
      type(curve_type), intent(in) :: curve
      type(condition_type), intent(in) :: conditions(:)
      real(wp), intent(in) :: point(:)
      real(wp) :: values(2 + size(conditions))
      type(rest_period_type) :: period
      real(wp) :: c(n_parameters)
      integer :: j

      values = at_fault
      c = parameters_of(curve, point)
      call rest_period(curve%frame%rest, point(:2), c, period)
      if (.not. period%right) return
      values(:2) = period%finish - point(:2)
      do j = 1, size(conditions)
         values(2 + j) = value_in_period(period, c, conditions(j))
      end do
   end function rest_values

   !> The value of a condition at a point.
   pure real(wp) function value_at(curve, condition, point) result(value)
      type(curve_type), intent(in) :: curve
      type(condition_type), intent(in) :: condition
      real(wp), intent(in) :: point(:)

      value = condition_value(curve%frame, point(:unknown_count(curve%frame)), &
         parameters_of(curve, point), condition)
   end function value_at

   !> Derivative of a condition along a direction, by central differences.
   pure real(wp) function slope_along(curve, condition, point, direction) result(slope)
      type(curve_type), intent(in) :: curve
      type(condition_type), intent(in) :: condition
      real(wp), intent(in) :: point(:), direction(:)
      real(wp) :: h
      integer :: i

      h = 1.0e-6_wp
      if (curve%frame%resting) h = merge(1.0e-4_wp, 1.0e-7_wp, condition%kind <= neimark_sacker)
      ! the derivative of a simulated map is a difference itself, and so less smooth; near the end
      ! of a family with rest only a shorter step stays on its side
      do i = 1, merge(3, 1, h > 1.0e-5_wp)
         associate (way => h/maxval(abs(direction))*direction)
            slope = (value_at(curve, condition, point + way) &
               - value_at(curve, condition, point - way))*(maxval(abs(direction))/(2*h))
         end associate
         if (abs(slope) <= huge(slope)) return
         h = 0.1_wp*h
      end do
   end function slope_along

   !> The gradient of a condition.
   pure function gradient(curve, condition, point)
      type(curve_type), intent(in) :: curve
      type(condition_type), intent(in) :: condition
      real(wp), intent(in) :: point(:)
      real(wp) :: gradient(size(point)), axis(size(point))
      integer :: j

      do j = 1, size(point)
         axis = 0
         axis(j) = 1
         gradient(j) = slope_along(curve, condition, point, axis)
      end do
   end function gradient

   !> The unit tangent of a curve at a point of it, in the direction of a given vector.
   pure subroutine tangent_at(curve, conditions, point, along, tangent, regular)
      type(curve_type), intent(in) :: curve
      !> One condition less than there are active parameters.
      type(condition_type), intent(in) :: conditions(:)
      real(wp), intent(in) :: point(:), along(:)
      real(wp), intent(out) :: tangent(:)
      logical, intent(out) :: regular
      type(linear_type) :: linear
      real(wp) :: wanted(size(conditions))
      integer :: j

      call linear_equations(curve, conditions, point, linear)
      linear%right(:linear%m) = 0
      call add(linear, along, 1.0_wp)
      tangent = 0
      call eliminate(linear, size(point), tangent, regular)
      if (.not. regular) return
      if (linear%n_free > 0) then
         wanted = [(-slope_along(curve, conditions(j), point, tangent), j=1, size(conditions))]
         call meet(curve, conditions, point, wanted, linear, tangent, regular)
      end if
      if (regular) tangent = tangent/norm2(tangent)
   end subroutine tangent_at

end module vi_curve
