!> The gradients of conditions on motions, without difference quotients.
!!
!! The derivatives are with respect to u_i, theta_i, r and log D, in this order. Motions with rest
!! are not handled here.
module vi_slopes
   use vi_conditions, only: fails_jury, polish_touch
   use vi_family, only: add_distance_slope, repetition_distance
   use vi_frame, only: condition_type, edge, flip, fold, frame_type, grazing, neimark_sacker, &
      repetition, zero_approach
   use vi_kinds, only: wp
   use vi_orbit, only: by_clearance, by_position, by_speed, orbit_type
   use vi_spectrum, only: spectrum_type, sums_with_slope
   implicit none (type, external)
   private

   public :: has_slope, value_and_slope

contains

   !> Whether `value_and_slope` gives the gradient of a condition.
   pure elemental logical function has_slope(condition)
      !> The condition.
      type(condition_type), intent(in) :: condition

      select case (condition%kind)
      case (fold, flip, neimark_sacker, zero_approach, grazing, repetition)
         has_slope = .true.
      case (edge)
         has_slope = condition%index <= by_clearance
      case default
         has_slope = .false.
      end select
   end function has_slope

   !> The value of a condition and its gradient, if `has_slope` is true for it.
   pure subroutine value_and_slope(frame, unknowns, c, o, condition, value, slope)
      !> The family, and its repetitions.
      type(frame_type), intent(in) :: frame
      !> u_i, theta_i (2n), and the parameters r, log(D), xi, mu, R1, R2.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> The orbit of these unknowns and parameters.
      type(orbit_type), intent(in) :: o
      !> The condition.
      type(condition_type), intent(in) :: condition
      !> Its value.
      real(wp), intent(out) :: value
      !> (2n + 2) Its gradient.
      real(wp), contiguous, intent(out) :: slope(:)

      slope = 0
      associate (i => condition%index)
         select case (condition%kind)
         case (fold, flip, neimark_sacker)
            call stability_slope(frame, unknowns, o, condition%kind, value, slope)
         case (grazing)
            call touch_slope(o, condition, value, slope)
         case (zero_approach)
            value = o%side(i)*(o%speed(i - 1) - o%before(i))
            call approach_slope(o, i, 1.0_wp, slope)
         case (repetition)
            value = repetition_distance(frame%family, frame%repetitions(i), unknowns) - &
               condition%bound
            call add_distance_slope(frame%family, frame%repetitions(i), unknowns, 1.0_wp, slope)
         case default
            value = condition%side*(c(i) - condition%bound)
            slope(size(unknowns) + i) = condition%side
         end select
      end associate
   end subroutine value_and_slope

   !> Value and gradient of one of the three numbers of `stability_values`.
   pure subroutine stability_slope(frame, unknowns, o, kind, value, slope)
      !> The family, and its repetitions.
      type(frame_type), intent(in) :: frame
      !> u_i, theta_i (2n).
      real(wp), intent(in) :: unknowns(:)
      !> The orbit of these.
      type(orbit_type), intent(in) :: o
      !> `fold`, `flip` or `neimark_sacker`.
      integer, intent(in) :: kind
      !> The value; 0 where an impact has no approach speed.
      real(wp), intent(out) :: value
      !> (2n + 2) In: 0. Out: the gradient.
      real(wp), contiguous, intent(inout) :: slope(:)
      type(spectrum_type) :: spectrum
      real(wp) :: distance
      integer :: i

      call sums_with_slope(o, kind, spectrum, value, slope)
      if (.not. spectrum%regular) return
      select case (kind)
      case (neimark_sacker)
         if (frame%every_crossing) return
         if (.not. fails_jury(spectrum)) return
         if (value > 0) slope = -slope
         value = -abs(value)
         ! a zero that the value only touches does not count
         if (abs(value) < 1.0e-6_wp*maxval(abs(slope))) slope = 0
      case (fold)
         do i = 1, size(frame%repetitions)
            distance = repetition_distance(frame%family, frame%repetitions(i), unknowns)
            value = value/max(0.1_wp*frame%apart, distance)**2
            slope = slope/max(0.1_wp*frame%apart, distance)**2
         end do
         do i = 1, size(frame%repetitions)
            distance = repetition_distance(frame%family, frame%repetitions(i), unknowns)
            if (distance > 0.1_wp*frame%apart) call add_distance_slope(frame%family, &
               frame%repetitions(i), unknowns, -2*value/distance, slope)
         end do
      case default
         ! a flip: nothing else matters
      end select
   end subroutine stability_slope

   !> Adds the gradient of the approach speed of an impact, times a weight.
   pure subroutine approach_slope(o, i, weight, slope)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> Number of the impact.
      integer, intent(in) :: i
      !> Factor of the gradient.
      real(wp), intent(in) :: weight
      !> (2n + 2) In and out: the gradient to which it is added.
      real(wp), contiguous, intent(inout) :: slope(:)

      call by_speed(o, i - 1, o%side(i)*weight*(1 - o%of_before(1, i)), slope)
      call by_speed(o, i, -o%side(i)*weight*o%of_before(2, i), slope)
   end subroutine approach_slope

   !> Value and gradient of the gap at a stationary point, where its time derivative is zero.
   pure subroutine touch_slope(o, condition, value, slope)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> Flight, wall, and approximate share of its duration.
      type(condition_type), intent(in) :: condition
      !> The gap over the clearance.
      real(wp), intent(out) :: value
      !> (2n + 2) In: 0. Out: the gradient.
      real(wp), contiguous, intent(inout) :: slope(:)
      type(condition_type) :: touch
      real(wp) :: t, side
      integer :: i

      touch = condition
      call polish_touch(o, touch, value)
      i = touch%index
      side = touch%side
      t = touch%share*o%time(i)
      ! gap = 1/2 - side (z_i + z' t - x)
      slope(i) = slope(i) - side
      call by_speed(o, i, -side*t, slope)
      call by_position(o, i, t, side, slope)
   end subroutine touch_slope

end module vi_slopes
