!> Whether two masses that leave an impact with the same velocity part or stay in contact.
!!
!! They leave with the same velocity if R = 0, or if the impact is too weak for its rebound to be
!! resolved. The gap between them then begins as a t^2/2 + j t^3/6: the sign of its acceleration
!! decides, and if that is zero, the sign of the next derivative does.
module vi_parting
   use vi_flight, only: flight_type
   use vi_kinds, only: wp
   use vi_oscillation, only: derivative_bound, derivative_bounds, derivatives, oscillation_type
   implicit none (type, external)
   private

   public :: leading_order, leaves_together, parting

   !> Error that rounding of the motion may cause in a derivative, over the amplitude of its parts;
   !! error of its computation from the state alone.
   real(wp), parameter :: noise = 1.0e4_wp*epsilon(1.0_wp), rounding = 64*epsilon(1.0_wp)

   !> Answers of `parting`.
   integer, parameter, public :: parted = 1, in_contact = 0, uncertain = -1

contains

   !> Whether the masses leave the impact at the start of a flight with the same velocity, to
   !! rounding.
   elemental logical function leaves_together(x_dot, z_dot, before)
      !> Velocities of the two masses after the impact, and the largest of those before it (omega
      !! F0/K).
      real(wp), intent(in) :: x_dot, z_dot, before

      leaves_together = abs(x_dot - z_dot) <= 16*epsilon(1.0_wp)*max(abs(x_dot), abs(z_dot), &
         abs(before))
   end function leaves_together

   !> The lowest derivative of x at a time that is not 0 to rounding.
   !!
   !! x'' obeys a linear equation of fourth order: if it and its next three derivatives are 0, it
   !! stays 0.
   pure subroutine leading_order(motion, t, first, order, value)
      !> The oscillation, or a flight.
      class(oscillation_type), intent(in) :: motion
      !> The time (1/omega).
      real(wp), intent(in) :: t
      !> The lowest order that is considered, 2 to 5.
      integer, intent(in) :: first
      !> The order; 5 if all are 0.
      integer, intent(out) :: order
      !> The derivative; 0 if all are.
      real(wp), intent(out) :: value
      real(wp) :: d(0:5)

      d = derivatives(motion, t)
      do order = first, 5
         value = d(order)
         if (abs(value) > rounding*derivative_bound(motion, order, t)) return
      end do
      order = 5
      value = 0
   end subroutine leading_order

   !> Whether the gap opens after an impact on a wall that the masses leave together.
   pure subroutine parting(flight, side, answer, until)
      !> Closed-form motion from the impact on, as if the masses parted.
      type(flight_type), intent(in) :: flight
      !> Wall of the impact: +1 right, -1 left.
      real(wp), intent(in) :: side
      !> `parted`, `in_contact` or `uncertain`.
      integer, intent(out) :: answer
      !> Time (1/omega) up to which the gap grows, if it opens; after an `uncertain` opening the gap
      !! is open at that time.
      real(wp), intent(out) :: until
      real(wp) :: a, j, root, d(0:5), fourth, error(2)

      d = derivatives(flight, 0.0_wp)
      ! the gap is d/2 - side (z - x), and z has no acceleration
      a = side*d(2)
      j = side*d(3)
      error = noise*[sum(derivative_bounds(flight, 2)), sum(derivative_bounds(flight, 3))]
      fourth = max(sum(derivative_bounds(flight, 4)), tiny(1.0_wp))
      until = 0
      answer = uncertain
      if (a < -error(1)) then
         answer = in_contact
      else if (j < -error(2) .and. 6*fourth*a < j**2) then
         ! whatever the sign of a, the gap closes again at about 3 a/|j|, before the next term
         ! matters
         answer = in_contact
      else if (a <= error(1)) then
         ! the next term opens the gap again after a possible contact
         until = max(1.5_wp*j/fourth, 0.0_wp)
      else
         answer = parted
         ! the gap's velocity is at least a t + j t^2/2 - fourth t^3/6
         root = sqrt((0.5_wp*j)**2 + 2*fourth*a/3)
         until = merge((root + 0.5_wp*j)*3/fourth, 2*a/(root - 0.5_wp*j), j > 0)
      end if
   end subroutine parting

end module vi_parting
