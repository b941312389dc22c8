!> The verdicts on a motion: is it consistent, admissible, stable? No other module sets them.
!!
!! Zones and surveys evaluate conditions that are zero on their boundary, to find on which side of
!! it a motion lies; they give no verdicts.
module vi_assess
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_doubt, only: modulus_doubt, spread_of_orders, unknowns_doubt
   use vi_exact, only: exact_acceptance
   use vi_extrema, only: relative_extrema
   use vi_flight, only: flight_type
   use vi_kinds, only: wp
   use vi_law, only: holds
   use vi_motion, only: audited, flight_of, motion_type, no, rounding_margin, unknown, &
      worst_rounding, yes
   use vi_parting, only: in_contact, leaves_together, parting, uncertain
   use vi_stability, only: multipliers_of_matrix, stability_matrix
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: admission, assess_exact, assess_flights, assess_linear, assess_rest, consistency, &
      is_doubtful, is_near_circle, refuse_rounding, stability

   !> The residual that the 1983 paper accepted for N > 2.
   real(wp), parameter, public :: paper_acceptance = 0.03_wp

   !> A leading multiplier this close to the unit circle is on it, to rounding.
   real(wp), parameter :: neutral = 1000*epsilon(1.0_wp)

   !> For an exact motion with a leading multiplier this close to the unit circle, the effect of
   !! rounding on its modulus is estimated; `stable` is given only if `reserve` times that effect
   !! does not reach the circle.
   real(wp), parameter :: near_circle = 1.0e-3_wp, reserve = 10.0_wp

contains

   !> `consistent` from the residual, the multipliers, and `stable` from them.
   pure subroutine assess_linear(motion, acceptance)
      !> In: a motion of the linear equations. Out: with its multipliers (NaN if there are none) and
      !! verdicts.
      type(motion_type), intent(inout) :: motion
      !> Largest relative residual of (26), (30) that counts as consistent.
      real(wp), intent(in) :: acceptance
      real(wp) :: p(4, 4)
      integer :: status
      logical :: lawful

      if (motion%status /= stat%ok) return
      motion%consistent = consistency(motion%residual, acceptance)
      motion%multipliers = cmplx(ieee_value(1.0_wp, ieee_quiet_nan), 0.0_wp, wp)
      call stability_matrix(motion, p, status)
      if (status /= stat%ok) return
      ! phases that are not those of a motion obey no law
      lawful = motion%consistent /= yes .or. .not. audited
      if (.not. lawful) lawful = holds(motion, p)
      call multipliers_of_matrix(p, motion%multipliers, status)
      if (lawful .and. status == stat%ok .and. .not. is_doubtful(motion%multipliers(1), &
         motion%rounding)) motion%stable = stability(abs(motion%multipliers(1)))
      if (motion%stable == unknown .or. .not. audited) return
      if (.not. is_near_circle(motion%multipliers(1))) return
      ! digits also cancel in the product of the [P_i]
      call doubt_stability(rounding_margin*motion%rounding &
         + spread_of_orders(motion, abs(motion%multipliers(1))), motion)
   end subroutine assess_linear

   !> Rejects an exact motion that has lost too many digits to rounding.
   !!
   !! Near a fold or a pitchfork, where a multiplier is near 1, positions are uncertain by nature;
   !! there `modulus_doubt` decides about the verdict.
   pure subroutine refuse_rounding(motion)
      !> With the verdicts of `assess_exact`; out: `stat%lost_digits` where it is rejected.
      type(motion_type), intent(inout) :: motion

      if (motion%status /= stat%ok .or. motion%stable == unknown) return
      if (any(abs(motion%multipliers - 1) <= near_circle)) return
      motion%rounding = unknowns_doubt(motion)
      if (.not. motion%rounding <= worst_rounding) motion%status = stat%lost_digits
   end subroutine refuse_rounding

   !> The verdicts of `assess_linear` on a motion that Newton's method has found.
   pure subroutine assess_exact(motion)
      !> With its impacts.
      type(motion_type), intent(inout) :: motion

      call assess_linear(motion, exact_acceptance)
      if (motion%stable == unknown .or. .not. is_near_circle(motion%multipliers(1))) return
      call doubt_stability(modulus_doubt(motion), motion)
   end subroutine assess_exact

   !> The verdicts on a motion with rest: a fixed point of the map from release to release.
   !!
   !! Its period was simulated, through every contact: a motion that returns to its beginning is
   !! admissible.
   pure subroutine assess_rest(map, doubt, motion)
      !> The derivative of the map, in the plane.
      real(wp), intent(in) :: map(2, 2)
      !> Possible error of the modulus of the leading multiplier, where that is near the unit
      !! circle.
      real(wp), intent(in) :: doubt
      !> With its residual and its multipliers.
      type(motion_type), intent(inout) :: motion

      if (motion%status /= stat%ok) return
      motion%consistent = consistency(motion%residual, exact_acceptance)
      motion%admissible = merge(yes, unknown, motion%consistent == yes)
      motion%stable = plane_stability(map)
      if (stability(abs(motion%multipliers(1))) == unknown) motion%stable = unknown
      if (is_near_circle(motion%multipliers(1))) call doubt_stability(doubt, motion)
   end subroutine assess_rest

   !> Whether rounding may decide on which side of the unit circle a multiplier lies.
   elemental logical function is_near_circle(multiplier)
      !> The leading multiplier.
      complex(wp), intent(in) :: multiplier

      is_near_circle = abs(abs(multiplier) - 1) <= near_circle
   end function is_near_circle

   !> Whether rounding of the motion may move its leading multiplier across the unit circle.
   elemental logical function is_doubtful(multiplier, rounding)
      !> The leading multiplier.
      complex(wp), intent(in) :: multiplier
      !> Estimated relative error of the motion.
      real(wp), intent(in) :: rounding

      is_doubtful = .not. abs(abs(multiplier) - 1) > reserve*rounding_margin*rounding
   end function is_doubtful

   !> Sets `stable` to `unknown` where rounding may move the leading multiplier to the unit circle.
   pure subroutine doubt_stability(doubt, motion)
      !> Possible error of the modulus of the leading multiplier.
      real(wp), intent(in) :: doubt
      !> With its multipliers, and `stable` from them.
      type(motion_type), intent(inout) :: motion

      ! a product with the largest number would overflow
      if (.not. abs(abs(motion%multipliers(1)) - 1)/reserve > doubt) motion%stable = unknown
   end subroutine doubt_stability

   !> `admissible`, and the extreme positions of the primary mass, from certified extrema.
   !!
   !! Admissible: at every impact the masses approach each other, s (z' - x') > 0 just before it,
   !! and inside every flight the free mass stays strictly between the walls, |y| < d/2. Masses that
   !! leave an impact together (R = 0) must part: the sign of the gap's acceleration decides, and
   !! where rounding hides it the verdict is `unknown`.
   pure subroutine assess_flights(motion)
      !> In: a complete motion. Out: with `admissible`, x_min and x_max.
      type(motion_type), intent(inout) :: motion
      type(flight_type) :: flight
      real(wp) :: lowest, highest, begin
      logical :: approaches, inside, complete, complete_x
      integer :: i, parts

      if (motion%status /= stat%ok) return
      approaches = all(motion%pattern%sides*(motion%z_dot_before - motion%x_dot_before) > 0)
      inside = .true.
      complete = .true.
      motion%x_min = minval(motion%x)
      motion%x_max = maxval(motion%x)
      do i = 1, size(motion%x)
         flight = flight_of(motion, i)
         begin = 0
         if (leaves_together(motion%x_dot_after(i), motion%z_dot_after(i), &
            max(abs(motion%x_dot_before(i)), abs(motion%z_dot_before(i))))) then
            call parting(flight, real(motion%pattern%sides(i), wp), parts, begin)
            inside = inside .and. parts /= in_contact
            complete = complete .and. parts /= uncertain
         end if
         call relative_extrema(flight, lowest, highest, complete_x, begin=begin)
         inside = inside .and. highest < 0.5_wp*motion%clearance .and. &
            lowest > -0.5_wp*motion%clearance
         complete = complete .and. complete_x
         flight%z = 0
         flight%z_dot = 0
         call relative_extrema(flight, lowest, highest, complete_x)
         motion%x_min = min(motion%x_min, -highest)
         motion%x_max = max(motion%x_max, -lowest)
         complete = complete .and. complete_x
      end do
      motion%admissible = admission(approaches .and. inside, complete)
   end subroutine assess_flights

   !> `consistent` from the relative residual of (26), (30).
   elemental integer function consistency(residual, acceptance)
      !> Relative residual, and the largest one that counts as consistent.
      real(wp), intent(in) :: residual, acceptance

      consistency = verdict(residual <= acceptance)
   end function consistency

   !> `stable` from the modulus of the leading multiplier.
   elemental integer function stability(largest)
      !> Modulus of the leading multiplier.
      real(wp), intent(in) :: largest

      stability = unknown
      if (abs(largest - 1) > neutral) stability = verdict(largest < 1)
   end function stability

   !> `stable` of a motion with rest, from the derivative of its map of the plane.
   !!
   !! Both eigenvalues lie inside the unit circle if all three of Jury's conditions hold. An
   !! accumulation of many impacts costs digits: the entries are accurate to about 1e-10 of the
   !! largest one.
   pure integer function plane_stability(j) result(stable)
      !> Derivative of the map of the plane.
      real(wp), intent(in) :: j(2, 2)
      real(wp) :: trace, determinant, conditions(3), doubt

      trace = j(1, 1) + j(2, 2)
      determinant = j(1, 1)*j(2, 2) - j(1, 2)*j(2, 1)
      conditions = [1 - trace + determinant, 1 + trace + determinant, 1 - determinant]
      doubt = 1.0e-9_wp*(1 + maxval(abs(j)))**2
      stable = unknown
      if (all(conditions > doubt)) stable = yes
      if (any(conditions < -doubt)) stable = no
   end function plane_stability

   !> `admissible` from whether all conditions hold, as far as the flights were examined.
   elemental integer function admission(holds, complete)
      !> Whether the conditions hold, and whether all flights could be examined.
      logical, intent(in) :: holds, complete

      admission = no
      if (holds) admission = merge(yes, unknown, complete)
   end function admission

   !> `yes` or `no`.
   elemental integer function verdict(condition)
      !> Whether the condition holds.
      logical, intent(in) :: condition

      verdict = merge(yes, no, condition)
   end function verdict

end module vi_assess
