!> Points of a curve of motions: (u_i, theta_i, q_j), the unknowns of the motion, then one or two
!! active parameters in units of their scale.
module vi_curve_point
   use vi_frame, only: frame_type, unknown_count
   use vi_kinds, only: wp
   use vi_linear, only: most
   use vi_orbit, only: by_clearance, by_left, by_right, n_parameters
   implicit none (type, external)
   private

   public :: parameters_of, point_size, to_point, unknowns_of

   !> What is fixed along a curve, and how its points are scaled.
   type, public :: curve_type
      type(frame_type) :: frame
      !> All parameters; those that are active are given by the point.
      real(wp) :: c(n_parameters) = 0
      !> Whether R2 is always R1.
      logical :: tied = .false.
      !> Which parameters are active, their values where the coordinate is 0, and its unit.
      integer, allocatable :: active(:)
      real(wp), allocatable :: origin(:), scale(:)
   end type curve_type

contains

   !> Number of coordinates of a point.
   pure integer function point_size(curve)
      !> The curve.
      type(curve_type), intent(in) :: curve

      point_size = unknown_count(curve%frame) + size(curve%active)
   end function point_size

   !> The parameters at a point.
   pure function parameters_of(curve, point) result(c)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> A point of it.
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
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> A point of it.
      real(wp), intent(in) :: point(:)
      real(wp) :: unknowns(unknown_count(curve%frame))

      unknowns = point(:size(unknowns))
   end function unknowns_of

   !> Converts a gradient with respect to all unknowns, r and log(D) to one with respect to the
   !! coordinates of a point.
   pure subroutine to_point(curve, slope)
      !> The curve.
      type(curve_type), intent(in) :: curve
      !> In: with respect to the unknowns, r, log(D). Out: with respect to the coordinates; 0 for
      !! active parameters other than r and log(D).
      real(wp), intent(inout) :: slope(most)
      real(wp) :: by(2)
      integer :: k, n

      n = unknown_count(curve%frame)
      by = slope(n + 1:n + 2)
      do k = 1, size(curve%active)
         slope(n + k) = 0
         if (curve%active(k) <= by_clearance) slope(n + k) = curve%scale(k)*by(curve%active(k))
      end do
   end subroutine to_point

end module vi_curve_point
