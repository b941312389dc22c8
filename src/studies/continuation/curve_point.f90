!> Points of a curve of motions: the unknowns of the motion, then one or two active parameters in
!! units of their scale.
module vi_curve_point
   use vi_kinds, only: wp
   use vi_motion_family, only: condition_type, coordinates_type, motion_family_type, parameters_at
   use vi_orbit, only: n_parameters
   implicit none (type, external)
   private

   public :: parameters_of, point_size, unknowns_of

   !> What is fixed along a curve or surface of motions, and how its points are scaled.
   type, extends(coordinates_type), public :: curve_type
      class(motion_family_type), allocatable :: family
      !> Bounds on parameters.
      type(condition_type), allocatable :: edges(:)
   end type curve_type

contains

   !> Number of coordinates of a point.
   pure integer function point_size(curve)
      !> The curve.
      type(curve_type), intent(in) :: curve

      point_size = curve%family%unknown_count() + size(curve%active)
   end function point_size

   !> The parameters at a point.
   pure function parameters_of(curve, point) result(c)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> A point of it.
      real(wp), intent(in) :: point(:)
      real(wp) :: c(n_parameters)

      c = parameters_at(curve%coordinates_type, point(size(point) - size(curve%active) + 1:))
   end function parameters_of

   !> The unknowns of the motion at a point.
   pure function unknowns_of(curve, point) result(unknowns)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> A point of it.
      real(wp), intent(in) :: point(:)
      real(wp) :: unknowns(size(point) - size(curve%active))

      unknowns = point(:size(unknowns))
   end function unknowns_of

end module vi_curve_point
