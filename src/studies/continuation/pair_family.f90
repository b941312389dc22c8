!> Families of motions of a pair without rest: one pattern, or the mirror-symmetric motions of one.
!!
!! Each condition is smooth along a family, and zero where a bifurcation of its kind bounds the
!! zone. Gradients are computed without difference quotients, with respect to u_i, theta_i, r and
!! log D.
module vi_pair_family
   use vi_extrema, only: relative_extrema
   use vi_family, only: add_distance_slope, repetition_distance
   use vi_flight, only: flight_position, flight_type
   use vi_impact_family, only: impact_family_type, list_conditions
   use vi_kinds, only: wp
   use vi_linear, only: most
   use vi_motion_family, only: condition_type, coordinates_type, edge, flip, fold, grazing, &
      neimark_sacker, parameters_at, repetition, rest_vanishes, searched_type, set_differences, &
      to_point, zero_approach
   use vi_orbit, only: by_clearance, by_left, by_position, by_right, by_speed, flight_at, &
      n_parameters, orbit_by_parameter, orbit_slopes, orbit_type, set_orbit
   use vi_oscillation, only: derivatives
   use vi_pattern, only: pattern_type
   use vi_releases, only: release_type
   use vi_search, only: search_pattern
   use vi_spectrum, only: multiplier_sums, outside_circle, pair_product, spectrum_type, &
      sums_with_slope
   implicit none (type, external)
   private

   public :: fails_jury, gap_of_flight, polish_touch

   !> The unknowns are u_i = x_i/D and theta_i; the parameters are r, log(D), xi, mu, R1, R2.
   type, extends(impact_family_type), public :: pair_family_type
   contains
      procedure :: unknown_count, set_equations, set_conditions, condition_value, motions_at
   end type pair_family_type

contains

   !> Number of unknowns.
   pure integer function unknown_count(family)
      !> The family.
      class(pair_family_type), intent(in) :: family

      unknown_count = 2*size(family%impacts%sides)
   end function unknown_count

   !> Residuals of the motion and of conditions, each with its gradient.
   pure subroutine set_equations(family, coordinates, conditions, point, b, a)
      !> The family.
      class(pair_family_type), intent(in) :: family
      !> The parameters.
      type(coordinates_type), intent(in) :: coordinates
      !> Conditions that are to be zero.
      type(condition_type), intent(in) :: conditions(:)
      !> A guess.
      real(wp), intent(in) :: point(:)
      !> Out: as in vi_motion_family.
      real(wp), intent(inout) :: b(2, most), a(most, most)
      type(orbit_type) :: o
      real(wp) :: slope(most)
      integer :: n, j, k

      n = size(point) - size(coordinates%active)
      call set_orbit(family%impacts, point(:n), parameters_at(coordinates, point(n + 1:)), o)
      call orbit_slopes(o, a, b(1, :n))
      do j = 1, n
         call to_point(coordinates, n, a(:, j))
      end do
      do k = 1, size(coordinates%active)
         if (coordinates%active(k) <= by_clearance) cycle
         slope(:n) = orbit_by_parameter(o, coordinates%active(k))
         if (coordinates%tied .and. coordinates%active(k) == by_right) slope(:n) = slope(:n) &
            + orbit_by_parameter(o, by_left)
         a(n + k, :n) = coordinates%scale(k)*slope(:n)
      end do
      do j = 1, size(conditions)
         if (conditions(j)%kind == edge) cycle
         call orbit_slope(family, coordinates, conditions(j), point, o, b(1, n + j), a(:, n + j))
      end do
   end subroutine set_equations

   !> The values of all conditions: 3 of stability, n approaches, n gaps, repetitions.
   pure subroutine set_conditions(family, unknowns, c, values, found, spectrum)
      !> The family, and its repetitions.
      class(pair_family_type), intent(in) :: family
      !> u_i, theta_i (2n), and the parameters r, log(D), xi, mu, R1, R2.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> (m) Value of each condition, positive where it is met.
      real(wp), intent(out) :: values(:)
      !> (m) The conditions; grazing with its wall and the share of the flight.
      type(condition_type), intent(out) :: found(:)
      !> Sums of the multipliers.
      type(spectrum_type), intent(out) :: spectrum
      type(orbit_type) :: o
      integer :: j

      call set_orbit(family%impacts, unknowns, c, o)
      call stability_values(family, unknowns, o, values(:3), spectrum)
      if (.not. family%every_crossing .and. all(values(:3) > 0)) then
         ! only stable motions are inside; where fold and flip are positive, the number of
         ! multipliers outside is even, and one alone is on the circle to rounding
         if (spectrum%e(0) > 0 .and. outside_circle(spectrum, 0) > 1) then
            values(neimark_sacker) = -values(neimark_sacker)
         end if
      end if
      call list_conditions(family, found)
      do j = 4, size(values)
         if (found(j)%kind == grazing) then
            call gap_of_flight(o, found(j), values(j))
         else
            values(j) = simple_value(family, unknowns, o, found(j))
         end if
      end do
   end subroutine set_conditions

   !> The value of one condition; for grazing, at the stationary point given in it.
   pure real(wp) function condition_value(family, unknowns, c, condition) result(value)
      !> The family, and its repetitions.
      class(pair_family_type), intent(in) :: family
      !> u_i, theta_i (2n), and the parameters r, log(D), xi, mu, R1, R2.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> The condition.
      type(condition_type), intent(in) :: condition
      type(orbit_type) :: o
      type(condition_type) :: touch
      type(spectrum_type) :: spectrum
      real(wp) :: three(3)

      call set_orbit(family%impacts, unknowns, c, o)
      select case (condition%kind)
      case (fold, flip, neimark_sacker)
         call stability_values(family, unknowns, o, three, spectrum)
         value = three(condition%kind)
      case (grazing)
         touch = condition
         call polish_touch(o, touch, value)
      case default
         value = simple_value(family, unknowns, o, condition)
      end select
   end function condition_value

   !> Value of a condition, and its gradient with respect to the coordinates of a point; central
   !! differences where no closed form is known.
   pure subroutine orbit_slope(family, coordinates, condition, point, o, value, slope)
      !> The family.
      class(pair_family_type), intent(in) :: family
      !> The parameters.
      type(coordinates_type), intent(in) :: coordinates
      !> The condition.
      type(condition_type), intent(in) :: condition
      !> A point.
      real(wp), intent(in) :: point(:)
      !> The orbit of the point.
      type(orbit_type), intent(in) :: o
      !> The value, and the gradient (the first elements, as `point`).
      real(wp), intent(out) :: value, slope(most)
      integer :: n

      n = size(point) - size(coordinates%active)
      if (condition%kind == rest_vanishes) then
         value = departure(o, condition%index)
         call set_differences(family, coordinates, condition, point, 1, slope(:size(point)))
         return
      end if
      call value_and_slope(family, point(:n), o, condition, value, slope(:n + 2))
      call to_point(coordinates, n, slope)
      if (any(coordinates%active > by_clearance)) call set_differences(family, coordinates, &
         condition, point, n + 1, slope(:size(point)))
   end subroutine orbit_slope

   !> The value of a condition other than those of stability and grazing.
   pure real(wp) function simple_value(family, unknowns, o, condition) result(value)
      !> The family, and its repetitions.
      class(pair_family_type), intent(in) :: family
      !> u_i, theta_i (2n).
      real(wp), intent(in) :: unknowns(:)
      !> The orbit of these unknowns.
      type(orbit_type), intent(in) :: o
      !> The condition.
      type(condition_type), intent(in) :: condition

      associate (i => condition%index)
         select case (condition%kind)
         case (zero_approach)
            value = o%side(i)*(o%speed(i - 1) - o%before(i))
         case (repetition)
            value = repetition_distance(family%impacts, family%repetitions(i), unknowns) - &
               condition%bound
         case default
            value = departure(o, i)
         end select
      end associate
   end function simple_value

   !> The value of a condition and its gradient with respect to u_i, theta_i, r and log(D), unless
   !! a rest vanishes there.
   pure subroutine value_and_slope(family, unknowns, o, condition, value, slope)
      !> The family, and its repetitions.
      class(pair_family_type), intent(in) :: family
      !> u_i, theta_i (2n).
      real(wp), intent(in) :: unknowns(:)
      !> The orbit of these unknowns.
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
            call stability_slope(family, unknowns, o, condition%kind, value, slope)
         case (grazing)
            call touch_slope(o, condition, value, slope)
         case (zero_approach)
            value = o%side(i)*(o%speed(i - 1) - o%before(i))
            call approach_slope(o, i, 1.0_wp, slope)
         case default
            value = repetition_distance(family%impacts, family%repetitions(i), unknowns) - &
               condition%bound
            call add_distance_slope(family%impacts, family%repetitions(i), unknowns, 1.0_wp, slope)
         end select
      end associate
   end subroutine value_and_slope

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
   pure subroutine stability_values(family, unknowns, o, values, spectrum)
      !> The family, and its repetitions.
      class(pair_family_type), intent(in) :: family
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
      if (.not. family%every_crossing) then
         if (fails_jury(spectrum)) values(neimark_sacker) = -abs(values(neimark_sacker))
      end if
      do i = 1, size(family%repetitions)
         values(fold) = values(fold)/max(0.1_wp*family%apart, &
            repetition_distance(family%impacts, family%repetitions(i), unknowns))**2
      end do
   end subroutine stability_values

   !> Value and gradient of one of the three numbers of `stability_values`.
   pure subroutine stability_slope(family, unknowns, o, kind, value, slope)
      !> The family, and its repetitions.
      class(pair_family_type), intent(in) :: family
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
         if (family%every_crossing) return
         if (.not. fails_jury(spectrum)) return
         if (value > 0) slope = -slope
         value = -abs(value)
         ! a zero that the value only touches does not count
         if (abs(value) < 1.0e-6_wp*maxval(abs(slope))) slope = 0
      case (fold)
         do i = 1, size(family%repetitions)
            distance = repetition_distance(family%impacts, family%repetitions(i), unknowns)
            value = value/max(0.1_wp*family%apart, distance)**2
            slope = slope/max(0.1_wp*family%apart, distance)**2
         end do
         do i = 1, size(family%repetitions)
            distance = repetition_distance(family%impacts, family%repetitions(i), unknowns)
            if (distance > 0.1_wp*family%apart) call add_distance_slope(family%impacts, &
               family%repetitions(i), unknowns, -2*value/distance, slope)
         end do
      case default
         ! a flip: nothing else matters
      end select
   end subroutine stability_slope

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

   !> The motions that Newton's method finds from guesses.
   subroutine motions_at(family, c, guesses, skip, found, releases, progress, longer, searched)
      !> The family.
      class(pair_family_type), intent(in) :: family
      !> r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> Number of guesses, and of those of the sequence to leave out.
      integer, intent(in) :: guesses, skip
      !> (unknowns, m) The motions.
      real(wp), allocatable, intent(out) :: found(:, :)
      !> Not used.
      type(release_type), intent(in), optional :: releases(:)
      !> Not used.
      integer, intent(inout), optional :: progress(3)
      !> Not used.
      integer, intent(in), optional :: longer
      !> In: the motions of the pattern, if another of its families has been searched at this point
      !! by the same guesses. Out: them.
      type(searched_type), intent(inout), optional :: searched
      !> Largest number of motions of a pattern at a point.
      integer, parameter :: capacity = 64
      type(pattern_type) :: pattern
      real(wp), allocatable :: whole(:, :)
      logical :: known
      integer :: k, n, tried

      associate (impacts => family%impacts, no => [present(releases), present(progress), &
         present(longer)])
         pattern = pattern_type(impacts%sides, impacts%cycles)
         if (impacts%mirror) pattern%sides = [impacts%sides, -impacts%sides]
      end associate
      known = .false.
      if (present(searched)) known = allocated(searched%motions)
      if (known) then
         whole = searched%motions
      else
         allocate (whole(2*size(pattern%sides), capacity))
         n = 0
         call search_pattern(pattern, c, guesses, whole, n, tried, skip)
         whole = whole(:, :n)
         if (present(searched)) searched%motions = whole
      end if
      allocate (found(family%unknown_count(), size(whole, 2)))
      do k = 1, size(whole, 2)
         found(:, k) = family%part_of(c, whole(:, k))
      end do
   end subroutine motions_at

end module vi_pair_family
