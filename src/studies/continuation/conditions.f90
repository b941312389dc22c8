!> The conditions under which a motion is stable and admissible, as numbers that are positive where
!! they are met: those of its family, then the bounds on parameters.
!!
!! Each is smooth along a family, and zero where a bifurcation of its kind bounds the zone.
module vi_conditions
   use vi_curve_point, only: curve_type
   use vi_kinds, only: wp
   use vi_motion_family, only: condition_type, edge
   use vi_spectrum, only: spectrum_type
   implicit none (type, external)
   private

   public :: all_conditions, condition_count, condition_value, edge_value

contains

   !> Number of conditions.
   pure integer function condition_count(curve)
      !> The curve.
      type(curve_type), intent(in) :: curve

      condition_count = curve%family%condition_count() + size(curve%edges)
   end function condition_count

   !> The values of all conditions.
   pure subroutine all_conditions(curve, unknowns, c, values, found, spectrum)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Unknowns of the motion, and the parameters.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> (m) Value of each condition, positive where it is met.
      real(wp), intent(out) :: values(:)
      !> (m) The conditions; grazing with its wall and the share of the flight.
      type(condition_type), intent(out) :: found(:)
      !> Sums of the multipliers; not set for motions that may jump.
      type(spectrum_type), intent(out), optional :: spectrum
      type(spectrum_type) :: sums
      integer :: n

      n = size(values) - size(curve%edges)
      call curve%family%set_conditions(unknowns, c, values(:n), found(:n), sums)
      if (present(spectrum)) spectrum = sums
      found(n + 1:) = curve%edges
      values(n + 1:) = edge_value(curve%edges, c(curve%edges%index))
   end subroutine all_conditions

   !> The value of one condition; for grazing, at the stationary point given in it.
   pure real(wp) function condition_value(curve, unknowns, c, condition) result(value)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> Unknowns of the motion, and the parameters.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> The condition.
      type(condition_type), intent(in) :: condition

      if (condition%kind == edge) then
         value = edge_value(condition, c(condition%index))
      else
         value = curve%family%condition_value(unknowns, c, condition)
      end if
   end function condition_value

   !> How far a parameter is inside a bound.
   pure elemental real(wp) function edge_value(bound, parameter)
      !> The bound.
      type(condition_type), intent(in) :: bound
      !> The parameter.
      real(wp), intent(in) :: parameter

      edge_value = bound%side*(parameter - bound%bound)
   end function edge_value

end module vi_conditions
