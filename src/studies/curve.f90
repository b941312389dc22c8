!> Curves of motions: Newton's method and tangents for the motions under some conditions.
!!
!! A point of a curve is (u_i, theta_i, q_j): the unknowns of the motion, then one or two active
!! parameters in units of their scale. With one active parameter the motions alone are a curve; with
!! two, those that meet one condition (a fold, say).
module vi_curve
   use vi_conditions, only: condition_value
   use vi_frame, only: condition_type, frame_type, neimark_sacker, unknown_count
   use vi_kinds, only: wp
   use vi_orbit, only: by_left, by_right, n_parameters, orbit_by_parameter, orbit_matrix, &
      orbit_residual, orbit_type, set_orbit
   use vi_rest_conditions, only: value_in_period
   use vi_rest_family, only: rest_period, rest_period_type
   implicit none (type, external)
   private

   public :: parameters_of, point_size, correct, condition_slope, tangent_at, unknowns_of

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
      real(wp) :: matrix(size(point), size(point)), step(size(point)), moved
      real(wp) :: start(size(point))
      logical :: regular, simulated
      integer :: i

      start = point
      iterations = 0
      simulated = curve%frame%resting .and. any(conditions%kind <= neimark_sacker)
      do i = 1, most_iterations
         call equations(curve, conditions, point, step, matrix)
         if (present(normal)) then
            matrix(size(point), :) = normal
            step(size(point)) = dot_product(normal, point - start)
         end if
         call eliminate(matrix, step, regular)
         if (.not. regular) return
         moved = maxval(abs(step))
         if (.not. moved < 0.5_wp) return
         point = point - step
         ! the matrix is right to 1e-8 or better: what is left after this step is below rounding;
         ! the multipliers of a simulated map are differences, and so less sharp
         if (moved < merge(1.0e-6_wp, 1.0e-8_wp, simulated)) then
            if (in_order(curve, point)) iterations = i
            return
         end if
      end do
   end subroutine correct

   !> Whether the impacts follow each other in time: the equations have other roots as well.
   pure logical function in_order(curve, point)
      type(curve_type), intent(in) :: curve
      real(wp), intent(in) :: point(:)
      type(orbit_type) :: o
      integer :: n

      in_order = .true.
      if (curve%frame%resting) return
      n = unknown_count(curve%frame)
      call set_orbit(curve%frame%family, point(:n), parameters_of(curve, point), o)
      in_order = all(o%time(1:o%n) > 0)
   end function in_order

   !> Residuals of the motion and of the conditions, with their derivatives.
   pure subroutine equations(curve, conditions, point, residual, matrix)
      type(curve_type), intent(in) :: curve
      type(condition_type), intent(in) :: conditions(:)
      real(wp), intent(in) :: point(:)
      real(wp), intent(out) :: residual(:), matrix(:, :)
      type(orbit_type) :: o
      real(wp) :: c(n_parameters)
      integer :: n, j

      n = unknown_count(curve%frame)
      if (curve%frame%resting) then
         call rest_equations(curve, conditions, point, residual, matrix)
         return
      end if
      do j = 1, size(conditions)
         call condition_slope(curve, conditions(j), point, residual(n + j), matrix(n + j, :))
      end do
      c = parameters_of(curve, point)
      call set_orbit(curve%frame%family, point(:n), c, o)
      residual(:n) = orbit_residual(o)
      call orbit_matrix(o, matrix(:n, :n))
      do j = 1, size(curve%active)
         matrix(:n, n + j) = curve%scale(j)*orbit_by_parameter(curve%frame%family, point(:n), c, &
            o, curve%active(j))
         if (curve%tied .and. curve%active(j) == by_right) matrix(:n, n + j) = matrix(:n, n + j) &
            + curve%scale(j)*orbit_by_parameter(curve%frame%family, point(:n), c, o, by_left)
      end do
   end subroutine equations

   !> The same for motions with rest, whose map is simulated: the derivatives are differences.
   pure subroutine rest_equations(curve, conditions, point, residual, matrix)
      type(curve_type), intent(in) :: curve
      type(condition_type), intent(in) :: conditions(:)
      real(wp), intent(in) :: point(:)
      real(wp), intent(out) :: residual(:), matrix(:, :)
      real(wp), parameter :: h = 1.0e-7_wp
      real(wp) :: moved(size(point))
      integer :: j, n

      n = 2 + size(conditions)
      residual(:n) = rest_values(curve, conditions, point)
      do j = 1, size(point)
         moved = point
         moved(j) = point(j) + h
         matrix(:n, j) = (rest_values(curve, conditions, moved) - residual(:n))/h
      end do
      do j = 1, size(conditions)
         if (conditions(j)%kind > neimark_sacker) cycle
         call condition_slope(curve, conditions(j), point, residual(2 + j), matrix(2 + j, :))
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

   !> Value and derivative (by central differences) of a condition.
   pure subroutine condition_slope(curve, condition, point, value, slope)
      type(curve_type), intent(in) :: curve
      type(condition_type), intent(in) :: condition
      real(wp), intent(in) :: point(:)
      real(wp), intent(out) :: value, slope(:)
      real(wp) :: moved(size(point)), h
      integer :: i, j

      value = at(point)
      h = 1.0e-6_wp
      if (curve%frame%resting) h = merge(1.0e-4_wp, 1.0e-7_wp, condition%kind <= neimark_sacker)
      ! the derivative of a simulated map is a difference itself, and so less smooth; near the end
      ! of a family with rest only a shorter step stays on its side
      do i = 1, merge(3, 1, h > 1.0e-5_wp)
         do j = 1, size(point)
            moved = point
            moved(j) = point(j) + h
            slope(j) = at(moved)
            moved(j) = point(j) - h
            slope(j) = (slope(j) - at(moved))/(2*h)
         end do
         if (all(abs(slope) <= huge(h))) return
         h = 0.1_wp*h
      end do
   contains
      pure real(wp) function at(place)
         real(wp), intent(in) :: place(:)

         at = condition_value(curve%frame, unknowns_of(curve, place), parameters_of(curve, place), &
            condition)
      end function at
   end subroutine condition_slope

   !> The unit tangent of a curve at a point of it, in the direction of a given vector.
   pure subroutine tangent_at(curve, conditions, point, along, tangent, regular)
      type(curve_type), intent(in) :: curve
      !> One condition less than there are active parameters.
      type(condition_type), intent(in) :: conditions(:)
      real(wp), intent(in) :: point(:), along(:)
      real(wp), intent(out) :: tangent(:)
      logical, intent(out) :: regular
      real(wp) :: matrix(size(point), size(point)), unused(size(point))

      call equations(curve, conditions, point, unused, matrix)
      matrix(size(point), :) = along
      tangent = 0
      tangent(size(point)) = 1
      call eliminate(matrix, tangent, regular)
      if (regular) tangent = tangent/norm2(tangent)
   end subroutine tangent_at

   !> Solves a small square system by Gaussian elimination with scaled partial pivoting.
   !!
   !! At these sizes the calls of a library would take most of the time.
   pure subroutine eliminate(a, b, regular)
      real(wp), intent(inout) :: a(:, :), b(:)
      logical, intent(out) :: regular
      real(wp) :: row(size(b)), factor
      integer :: n, i, j, k

      n = size(b)
      regular = .false.
      do i = 1, n
         factor = maxval(abs(a(i, :)))
         if (.not. (factor > 0 .and. factor <= huge(factor))) return
         a(i, :) = a(i, :)/factor
         b(i) = b(i)/factor
      end do
      do k = 1, n
         j = k - 1 + maxloc(abs(a(k:, k)), dim=1)
         if (.not. abs(a(j, k)) > 1.0e-14_wp) return
         if (j /= k) then
            row = a(k, :)
            a(k, :) = a(j, :)
            a(j, :) = row
            b([k, j]) = b([j, k])
         end if
         do i = k + 1, n
            factor = a(i, k)/a(k, k)
            if (abs(factor) > 0) then
               a(i, k + 1:) = a(i, k + 1:) - factor*a(k, k + 1:)
               b(i) = b(i) - factor*b(k)
            end if
         end do
      end do
      do k = n, 1, -1
         b(k) = (b(k) - dot_product(a(k, k + 1:), b(k + 1:)))/a(k, k)
      end do
      regular = .true.
   end subroutine eliminate

end module vi_curve
