!> From phases to the verdicts `consistent` and `stable`, many points at a time.
!!
!! A lane gives a verdict only where rounding cannot change it; otherwise the verdict is `unsure`.
module vi_lane_verdicts
   use vi_kinds, only: wp
   use vi_lane_motion, only: lane_chain
   use vi_lanes, only: largest_exponent, shrinkage
   use vi_lane_spectrum, only: audit, lane_circle, lane_polynomial, lane_radius
   use vi_plan, only: lanes, plan_type, unsure
   implicit none (type, external)
   private

   public :: lane_verdicts

   !> Largest estimated relative error of a spectral radius that is returned.
   real(wp), parameter :: radius_error = 4.0e-12_wp
   !> A residual this near to the acceptance limit is left to the reference chain.
   real(wp), parameter :: residual_margin = 1.0e-9_wp

contains

   !> Verdicts on the motions with given frequency ratios and phases.
   pure subroutine lane_verdicts(plan, n, m, r, phases, with_radius, system, x, flight, &
      consistent, stable, radius)
      !> Data that all points share: pattern, acceptance, xi, eta and the weights of the impact law.
      type(plan_type), intent(in) :: plan
      !> N impacts, m = 2N equations.
      integer, intent(in) :: n, m
      !> Frequency ratio and impact phases (rad, the first one 0) of each lane.
      real(wp), intent(in) :: r(lanes), phases(lanes, n)
      !> Whether `radius` is wanted; otherwise it is not set.
      logical, intent(in) :: with_radius
      !> Scratch.
      real(wp), intent(inout) :: system(lanes, m, n + 3), x(lanes, n + 2), flight(lanes, 7, n)
      !> 1, 0, or `unsure`.
      integer, intent(out) :: consistent(lanes), stable(lanes)
      !> Largest modulus of a multiplier, if it is wanted; where it is not certain, `stable` is
      !! `unsure`.
      real(wp), intent(out) :: radius(lanes)
      real(wp) :: p(lanes, 4, 4), e(lanes, 4)
      real(wp), dimension(lanes) :: residual, quality, largest, least, doubt, slope, law, &
         terms
      real(wp) :: noise, rest
      integer :: l

      call lane_chain(plan, n, m, r, phases, system, x, flight, p, residual, quality)
      if (n == 2) residual = 0                        ! as many equations as unknowns
      call lane_polynomial(p, e, largest, terms)
      call lane_circle(e, largest, least, doubt)
      slope = min(plan%xi*plan%period/r, largest_exponent)
      call shrinkage(slope, law)
      law = law**2*plan%squares
      do l = 1, lanes
         rest = sqrt(residual(l))
         consistent(l) = merge(1, 0, rest <= plan%acceptance)
         if (n > 2 .and. .not. abs(rest - plan%acceptance) > residual_margin) then
            consistent(l) = unsure
         end if
         stable(l) = merge(1, 0, least(l) > 0)
         if (.not. abs(least(l))*quality(l) > doubt(l)) stable(l) = unsure
         ! stricter than vi_law; phases that are not those of a motion obey no law
         if (consistent(l) /= 0 .and. .not. abs(e(l, 4) - law(l)) <= 50*rest*law(l) &
            + audit*terms(l)) stable(l) = unsure
      end do
      if (.not. with_radius) return
      call lane_radius(e, radius, slope)
      do l = 1, lanes
         ! error of the zero of the polynomial due to errors of its coefficients and of [P]
         associate (q => max(largest(l), radius(l)), s => radius(l))
            ! times the slope, s and the quality; if the quality is 0, nothing is certain
            noise = (q*s**3 + q**2*s**2 + q**3*(s + 1))*quality(l) + (q*s**2 + slope(l))*s
            if (.not. noise*epsilon(1.0_wp) < radius_error*slope(l)*s*quality(l)) stable(l) = unsure
         end associate
      end do
   end subroutine lane_verdicts

end module vi_lane_verdicts
