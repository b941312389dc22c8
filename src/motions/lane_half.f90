!> Motions that are their own mirror image half a period later, many at a time: one per lane.
!!
!! One frequency ratio, many clearances: the flights have one duration and common nodes (vi_nodes).
!! A lane gives a verdict only where that is certain.
module vi_lane_half
   use vi_kinds, only: wp
   use vi_lane_motion, only: rows
   use vi_lane_peak, only: find_largest, raise
   use vi_lane_spectrum, only: audit, lane_circle, lane_polynomial
   use vi_plan, only: lanes, plan_type, unsure
   implicit none (type, external)
   private

   public :: lane_halves

contains

   !> Verdicts on a block of motions, and the largest |x| of each.
   pure subroutine lane_halves(plan, r, duration, amplitude, c, n, step, position, rise, block, &
      stable, admissible, largest)
      !> Data that all points share: xi, eta and the weights of the impact law.
      type(plan_type), intent(in) :: plan
      !> Frequency ratio, duration of a flight (1/omega), A (F0/K), and C_1, C_2 of (9), (10).
      real(wp), intent(in) :: r, duration, amplitude, c(2)
      !> Number n of the last node; the first one is 0.
      integer, intent(in) :: n
      !> Time between the nodes (1/omega), and the tables of vi_nodes: the four functions at the
      !! nodes, and their derivatives times `step`.
      real(wp), intent(in) :: step, position(4, 0:n), rise(4, 0:n)
      !> block(lane, :): clearance, x_1, A cos(tau), A sin(tau) (F0/K).
      real(wp), intent(in) :: block(lanes, 4)
      !> 1, 0 or `unsure`; where `admissible` is `unsure`, `largest` is not certain either.
      integer, intent(out) :: stable(lanes), admissible(lanes)
      !> Largest |x| of each lane (F0/K).
      real(wp), intent(out) :: largest(lanes)
      !> Coefficients of the four functions at the nodes.
      real(wp) :: parts(lanes, 4)
      real(wp), dimension(lanes) :: z_dot, bound
      logical :: approaches(lanes)

      associate (clearance => block(:, 1), x => block(:, 2), forced => block(:, 3:4))
         z_dot = -2*(x + 0.5_wp*clearance)/duration
         ! by (28) the approach speed is 2 (1 + mu)/(1 + R) times that of the free mass
         approaches = z_dot < 0
         parts(:, 2) = x - forced(:, 2)                                                   ! (6)
         parts(:, 1) = ((plan%x_dot_after(2, 1) - plan%x_dot_after(1, 1))*z_dot &
            + plan%xi*parts(:, 2) - r*forced(:, 1))/plan%frequency                        ! (5)
         parts(:, 3:4) = forced
         bound = sqrt(parts(:, 1)**2 + parts(:, 2)**2) + amplitude*(r**2)**2
         call lane_stability(plan, r, duration, c, clearance, x, z_dot, parts, stable)
         call lane_extremes(n, step, plan%xi, r, position, rise, bound, clearance, x, z_dot, &
            approaches, parts, admissible, largest)
         where (.not. bound <= huge(1.0_wp)) admissible = unsure
      end associate
   end subroutine lane_halves

   !> Whether the map of half a period, and so [P], is a contraction: 1, 0 or `unsure`.
   pure subroutine lane_stability(plan, r, duration, c, clearance, x, z_dot, parts, stable)
      !> Data that all points share.
      type(plan_type), intent(in) :: plan
      !> Frequency ratio, duration of a flight (1/omega), and C_1, C_2 of (9), (10).
      real(wp), intent(in) :: r, duration, c(2)
      !> Clearance, position x_1 (F0/K), and velocity of the free mass in the flight (omega F0/K).
      real(wp), intent(in), dimension(lanes) :: clearance, x, z_dot
      !> parts(lane, :): coefficients of the four functions; 3 and 4 are A cos(tau), A sin(tau).
      real(wp), intent(in) :: parts(lanes, 4)
      !> 1, 0 or `unsure`.
      integer, intent(out) :: stable(lanes)
      real(wp), dimension(lanes) :: unit, ratio, place, x_dot, clear, largest, least, noise, &
         terms
      real(wp) :: forced(lanes, 2), flight(lanes, 7), ahead(lanes, 2), t(lanes, 4), u(lanes, 4), &
         v(lanes, 4), q(lanes, 4, 4), e(lanes, 4)
      real(wp) :: law
      integer :: j, l

      ! lengths in units of the clearance
      unit = 1/clearance
      ratio = r
      place = x*unit
      forced(:, 1) = parts(:, 3)*unit
      forced(:, 2) = parts(:, 4)*unit
      x_dot = (plan%x_dot_after(2, 1) - plan%x_dot_after(1, 1))*z_dot*unit
      flight(:, 1) = c(1)
      flight(:, 2) = c(2)
      flight(:, 3) = 0
      flight(:, 4) = 1
      flight(:, 5) = duration
      flight(:, 6) = 1/duration
      flight(:, 7) = z_dot*unit
      ahead(:, 1) = 0
      ahead(:, 2) = -1
      call rows(plan, ratio, place, forced, flight, ahead, x_dot, t, u, v, clear)
      ! mirror: positions and velocities change sign, phases do not
      do j = 1, 4
         q(:, 1, j) = -u(:, j)
         q(:, 2, j) = -plan%x_row(1, 1)*v(:, j)
         q(:, 3, j) = -plan%z_row(1, 1)*v(:, j)
         q(:, 4, j) = t(:, j)
      end do
      q(:, 2, 3) = q(:, 2, 3) - plan%x_row(2, 1)
      q(:, 3, 3) = q(:, 3, 3) - plan%z_row(2, 1)
      call lane_polynomial(q, e, largest, terms)
      call lane_circle(e, largest, least, noise)
      law = exp(-2*plan%xi*duration)*sqrt(plan%squares)
      do l = 1, lanes
         stable(l) = merge(1, 0, least(l) > 0)
         if (.not. abs(least(l))*clear(l) > noise(l)) stable(l) = unsure
         if (.not. abs(e(l, 4) - law) <= audit*terms(l)) stable(l) = unsure
      end do
   end subroutine lane_stability

   !> Whether the flight stays between the walls, and the largest |x|, as in vi_equispaced_row.
   pure subroutine lane_extremes(n, step, xi, r, position, rise, bound, clearance, x_first, z_dot, &
      approaches, parts, admissible, largest)
      !> Number n of the last node; the first one is 0.
      integer, intent(in) :: n
      !> Time between the nodes (1/omega), damping ratio, frequency ratio, and the tables of
      !! vi_nodes.
      real(wp), intent(in) :: step, xi, r, position(4, 0:n), rise(4, 0:n)
      !> Bound on the fourth derivative of x.
      real(wp), intent(in) :: bound(lanes)
      !> Clearance, position x_1 (F0/K), and velocity of the free mass in the flight (omega F0/K).
      real(wp), intent(in), dimension(lanes) :: clearance, x_first, z_dot
      !> Whether the masses approach each other before the impacts.
      logical, intent(in) :: approaches(lanes)
      !> parts(lane, :): coefficients of the four functions.
      real(wp), intent(in) :: parts(lanes, 4)
      !> 1, 0 or `unsure`; in the last case `largest` is not certain either.
      integer, intent(out) :: admissible(lanes)
      !> Largest |x| of each lane (F0/K).
      real(wp), intent(out) :: largest(lanes)
      real(wp), dimension(lanes, 0:n) :: x, x_rise, y, y_rise
      real(wp), dimension(lanes) :: highest, farthest, dip
      logical :: certain(lanes)
      integer :: j, l

      dip = bound*(step*step)**2/144
      do j = 0, n
         do l = 1, lanes
            x(l, j) = parts(l, 1)*position(1, j) + parts(l, 2)*position(2, j) &
               + parts(l, 3)*position(3, j) + parts(l, 4)*position(4, j)
            x_rise(l, j) = parts(l, 1)*rise(1, j) + parts(l, 2)*rise(2, j) &
               + parts(l, 3)*rise(3, j) + parts(l, 4)*rise(4, j)
            y(l, j) = x_first(l) + 0.5_wp*clearance(l) + z_dot(l)*(j*step) - x(l, j)
            y_rise(l, j) = z_dot(l)*step - x_rise(l, j)
         end do
      end do
      ! at both ends of the flight the masses touch
      x(:, 0) = x_first
      x(:, n) = -x_first
      y(:, 0) = 0.5_wp*clearance
      y(:, n) = -y(:, 0)
      highest = y(:, 0)
      farthest = 0
      do j = 1, n
         call raise(highest, y(:, j - 1), y_rise(:, j - 1), y(:, j), y_rise(:, j), dip)
         if (j < n) farthest = max(farthest, abs(y(:, j)))
      end do
      call find_largest(n, step, xi, r, position, rise, bound, parts, x, x_rise, largest, certain)
      do l = 1, lanes
         admissible(l) = merge(1, 0, approaches(l) .and. highest(l) <= y(l, 0))
         if (approaches(l) .and. highest(l) > y(l, 0) &
            .and. .not. farthest(l) > y(l, 0)*(1 + 1.0e-12_wp)) admissible(l) = unsure
         if (.not. certain(l)) admissible(l) = unsure
      end do
   end subroutine lane_extremes

end module vi_lane_half
