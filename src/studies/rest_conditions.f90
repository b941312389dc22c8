!> The conditions of motions with rest.
module vi_rest_conditions
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_frame, only: condition_at, condition_type, edge, frame_type, grazing, rest_vanishes, &
      zero_approach
   use vi_kinds, only: wp
   use vi_rest_family, only: least_gap, least_rest, rest_derivative, rest_period, rest_period_type
   implicit none (type, external)
   private

   public :: rest_condition, rest_conditions, value_in_period

contains

   !> The values of all conditions of a motion with rest; -1 where its letters are others.
   pure subroutine rest_conditions(frame, unknowns, c, values, found)
      type(frame_type), intent(in) :: frame
      real(wp), intent(in) :: unknowns(:), c(:)
      real(wp), intent(out) :: values(:)
      type(condition_type), intent(out) :: found(:)
      type(rest_period_type) :: period
      integer :: j, n

      n = size(frame%rest%letters)
      found = [(condition_at(frame, j), j=1, size(values))]
      values(:3) = rest_stability(frame, unknowns, c)
      values(4:3 + 3*n) = -1
      call rest_period(frame%rest, unknowns, c, period)
      if (period%right) then
         values(4:3 + n) = period%approach - least_gap
         values(4 + n:3 + 2*n) = period%gap - least_gap
         values(4 + 2*n:3 + 3*n) = rest_left(period%rest)
      end if
      do j = 4 + 3*n, size(values)
         values(j) = found(j)%side*(c(found(j)%index) - found(j)%bound)
      end do
   end subroutine rest_conditions

   !> The value of one condition of a motion with rest; not a number where its letters are others.
   pure real(wp) function rest_condition(frame, unknowns, c, condition) result(value)
      type(frame_type), intent(in) :: frame
      real(wp), intent(in) :: unknowns(:), c(:)
      type(condition_type), intent(in) :: condition
      type(rest_period_type) :: period
      real(wp) :: three(3)

      value = ieee_value(1.0_wp, ieee_quiet_nan)
      if (condition%kind <= 3) then
         three = rest_stability(frame, unknowns, c)
         if (any(three > -1)) value = three(condition%kind)
         return
      end if
      call rest_period(frame%rest, unknowns, c, period)
      if (period%right) value = value_in_period(period, c, condition)
   end function rest_condition

   !> The value of a condition, not one of stability, in a period.
   pure real(wp) function value_in_period(period, c, condition) result(value)
      type(rest_period_type), intent(in) :: period
      real(wp), intent(in) :: c(:)
      type(condition_type), intent(in) :: condition

      associate (i => condition%index)
         select case (condition%kind)
         case (zero_approach)
            value = period%approach(i) - least_gap
         case (grazing)
            value = period%gap(i) - least_gap
         case (rest_vanishes)
            value = rest_left(period%rest(i))
         case (edge)
            value = condition%side*(c(i) - condition%bound)
         case default
            value = 0
         end select
      end associate
   end function value_in_period

   !> A measure of the rest that is left: about linear in the parameters.
   !!
   !! Near the end of the family the duration goes about like the power 0.6 of the distance to it.
   elemental real(wp) function rest_left(duration)
      real(wp), intent(in) :: duration

      rest_left = duration**1.7_wp - least_rest**1.7_wp
   end function rest_left

   !> det(I - J), det(I + J) and 1 - det J of the map of the plane of releases; all -1 where a
   !! neighbour has other letters.
   pure function rest_stability(frame, unknowns, c) result(values)
      type(frame_type), intent(in) :: frame
      real(wp), intent(in) :: unknowns(:), c(:)
      real(wp) :: values(3)
      real(wp) :: trace, determinant
      logical :: right

      call rest_derivative(frame%rest, unknowns, c, trace, determinant, right)
      values = -1
      if (right) values = [1 - trace + determinant, 1 + trace + determinant, 1 - determinant]
   end function rest_stability

end module vi_rest_conditions
