!> The conditions under which a motion is stable and admissible, as numbers that are positive where
!! they are met.
!!
!! Each is smooth along a family, and zero where a bifurcation of its kind bounds the zone.
module vi_conditions
   use vi_extrema, only: relative_extrema
   use vi_family, only: repetition_distance
   use vi_flight, only: flight_position, flight_type
   use vi_frame, only: condition_at, condition_type, edge, flip, fold, frame_type, grazing, &
      neimark_sacker, repetition, rest_vanishes, zero_approach
   use vi_kinds, only: wp
   use vi_orbit, only: flight_at, orbit_type, set_orbit
   use vi_oscillation, only: derivatives
   use vi_rest_conditions, only: rest_condition, rest_conditions
   use vi_structure_conditions, only: structure_condition, structure_conditions
   use vi_spectrum, only: multiplier_sums, outside_circle, pair_product, spectrum_type
   implicit none (type, external)
   private

   public :: all_conditions, condition_value, fails_jury, gap_of_flight, polish_touch

contains

   !> The values of all conditions: 3 of stability, n approaches, n gaps, repetitions, edges.
   pure subroutine all_conditions(frame, unknowns, c, values, found, spectrum)
      !> The family, its repetitions, and its edges.
      type(frame_type), intent(in) :: frame
      !> Unknowns of the motion (see vi_frame), and the parameters r, log(D), xi, mu, R1, R2.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> (m) Value of each condition, positive where it is met.
      real(wp), intent(out) :: values(:)
      !> (m) The conditions; grazing with its wall and the share of the flight.
      type(condition_type), intent(out) :: found(:)
      !> Sums of the multipliers; not set for motions with rest.
      type(spectrum_type), intent(out), optional :: spectrum
      type(spectrum_type) :: sums
      type(orbit_type) :: o
      integer :: j

      if (frame%resting) then
         call rest_conditions(frame, unknowns, c, values, found)
         return
      else if (allocated(frame%structure)) then
         call structure_conditions(frame, unknowns, c, values, found, sums)
         if (present(spectrum)) spectrum = sums
         return
      end if
      call set_orbit(frame%family, unknowns, c, o)
      call stability_values(frame, unknowns, o, values(:3), sums)
      if (present(spectrum)) spectrum = sums
      if (.not. frame%every_crossing .and. all(values(:3) > 0)) then
         ! only stable motions are inside; where fold and flip are positive, the number of
         ! multipliers outside is even, and one alone is on the circle to rounding
         if (sums%e(0) > 0 .and. outside_circle(sums, 0) > 1) then
            values(neimark_sacker) = -values(neimark_sacker)
         end if
      end if
      do j = 1, size(values)
         found(j) = condition_at(frame, j)
         select case (found(j)%kind)
         case (fold, flip, neimark_sacker)
         case (grazing)
            call gap_of_flight(o, found(j), values(j))
         case default
            values(j) = simple_value(frame, unknowns, o, c, found(j))
         end select
      end do
   end subroutine all_conditions

   !> The value of one condition; for grazing, at the stationary point given in it.
   pure real(wp) function condition_value(frame, unknowns, c, condition) result(value)
      !> The family, its repetitions, and its edges.
      type(frame_type), intent(in) :: frame
      !> Unknowns of the motion (see vi_frame), and the parameters r, log(D), xi, mu, R1, R2.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> The condition.
      type(condition_type), intent(in) :: condition
      type(orbit_type) :: o
      type(condition_type) :: touch
      type(spectrum_type) :: spectrum
      real(wp) :: three(3)

      if (condition%kind == edge) then
         value = condition%side*(c(condition%index) - condition%bound)
         return
      else if (frame%resting) then
         value = rest_condition(frame, unknowns, c, condition)
         return
      else if (allocated(frame%structure)) then
         value = structure_condition(frame, unknowns, c, condition)
         return
      end if
      call set_orbit(frame%family, unknowns, c, o)
      select case (condition%kind)
      case (fold, flip, neimark_sacker)
         call stability_values(frame, unknowns, o, three, spectrum)
         value = three(condition%kind)
      case (grazing)
         touch = condition
         call polish_touch(o, touch, value)
      case default
         value = simple_value(frame, unknowns, o, c, condition)
      end select
   end function condition_value

   !> The value of a condition other than those of stability and grazing.
   pure real(wp) function simple_value(frame, unknowns, o, c, condition) result(value)
      !> The family, and its repetitions.
      type(frame_type), intent(in) :: frame
      !> u_i, theta_i (2n), and the parameters r, log(D), xi, mu, R1, R2.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> The orbit of these unknowns and parameters.
      type(orbit_type), intent(in) :: o
      !> The condition.
      type(condition_type), intent(in) :: condition

      associate (i => condition%index)
         select case (condition%kind)
         case (zero_approach)
            value = o%side(i)*(o%speed(i - 1) - o%before(i))
         case (repetition)
            value = repetition_distance(frame%family, frame%repetitions(i), unknowns) - &
               condition%bound
         case (rest_vanishes)
            value = departure(o, i)
         case default
            value = condition%side*(c(i) - condition%bound)
         end select
      end associate
   end function simple_value

   !> The relative acceleration at which the masses separate after an impact with R = 0.
   pure real(wp) function departure(o, i)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> Number of the impact.
      integer, intent(in) :: i
      real(wp) :: d(0:5)

      d = derivatives(flight_at(o, i), 0.0_wp)
      departure = o%side(i)*d(2)
   end function departure

   !> det(I - Q), det(I + Q) and the product of all 1 - lambda_i lambda_j, i < j.
   !!
   !! All three are computed from the normalised sums of vi_spectrum. The first is divided by the
   !! squared distances to motions that repeat themselves, because a multiplier approaches 1 there,
   !! and its distance to 1 is proportional to that square.
   pure subroutine stability_values(frame, unknowns, o, values, spectrum)
      !> The family, and its repetitions.
      type(frame_type), intent(in) :: frame
      !> u_i, theta_i (2n).
      real(wp), intent(in) :: unknowns(:)
      !> The orbit of these unknowns.
      type(orbit_type), intent(in) :: o
      !> Values of fold, flip, Neimark-Sacker; 0 where an impact has no approach speed.
      real(wp), intent(out) :: values(3)
      !> Sums of the multipliers.
      type(spectrum_type), intent(out) :: spectrum
      integer :: i

      values = 0
      call multiplier_sums(o, spectrum)
      if (.not. spectrum%regular) return
      associate (e => spectrum%e)
         values = [e(0) - e(1) + e(2) - e(3) + e(4), sum(e), pair_product(spectrum)]
      end associate
      if (.not. frame%every_crossing) then
         if (fails_jury(spectrum)) values(neimark_sacker) = -abs(values(neimark_sacker))
      end if
      do i = 1, size(frame%repetitions)
         values(fold) = values(fold)/max(0.1_wp*frame%apart, &
            repetition_distance(frame%family, frame%repetitions(i), unknowns))**2
      end do
   end subroutine stability_values

   !> Whether the remaining Jury condition fails.
   !!
   !! The three numbers of `stability_values` can all be positive where several multipliers have
   !! crossed the unit circle. There this condition fails by a wide margin. On the boundary of the
   !! stable motions it is met, but only just where three multipliers lie on the circle.
   pure logical function fails_jury(spectrum)
      !> Sums of the multipliers.
      type(spectrum_type), intent(in) :: spectrum

      associate (e => spectrum%e, q => spectrum%product)
         fails_jury = abs(e(3) - e(1)*q) > 1.001_wp*(1 - q**2)*abs(e(0))
      end associate
   end function fails_jury

   !> The least gap at a stationary point inside a flight, at most one half. After an impact with
   !! R = 0, the departure counts as well.
   pure subroutine gap_of_flight(o, touch, gap)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> In: the flight. Out: also the wall and the share of its duration; the kind becomes
      !! `rest_vanishes` if the departure is less.
      type(condition_type), intent(inout) :: touch
      !> The gap over the clearance; negative beyond the wall.
      real(wp), intent(out) :: gap
      real(wp) :: lowest, highest, lowest_at, highest_at
      logical :: complete

      call relative_extrema(flight_at(o, touch%index), lowest, highest, complete, lowest_at, &
         highest_at)
      gap = 0.5_wp
      touch%side = 0
      if (0.5_wp - highest < gap) then
         gap = 0.5_wp - highest
         touch%side = 1
         touch%share = highest_at/o%time(touch%index)
      end if
      if (lowest + 0.5_wp < gap) then
         gap = lowest + 0.5_wp
         touch%side = -1
         touch%share = lowest_at/o%time(touch%index)
      end if
      if (o%restitution(touch%index) > 0) return
      lowest = departure(o, touch%index)
      if (lowest >= gap) return
      gap = lowest
      touch = condition_type(rest_vanishes, touch%index, o%side(touch%index))
   end subroutine gap_of_flight

   !> The gap at the stationary point near a given share of the flight.
   pure subroutine polish_touch(o, touch, gap)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> In: flight, wall, and approximate share of its duration. Out: with the exact share.
      type(condition_type), intent(inout) :: touch
      !> The gap over the clearance; negative beyond the wall.
      real(wp), intent(out) :: gap
      type(flight_type) :: flight
      real(wp) :: d(0:5), t, step
      integer :: i

      flight = flight_at(o, touch%index)
      t = touch%share*flight%duration
      do i = 1, 6
         d = derivatives(flight, t)
         if (abs(d(2)) <= tiny(1.0_wp)) exit
         step = (flight%z_dot - d(1))/d(2)
         t = t + max(-0.05_wp, min(0.05_wp, step))
         if (abs(step) < 1.0e-9_wp) exit
      end do
      d = derivatives(flight, t)
      touch%share = t/flight%duration
      gap = 0.5_wp - touch%side*(flight_position(flight, t) - d(0))
   end subroutine polish_touch

end module vi_conditions
