!> The equispaced pair at one frequency ratio and many clearances: quantities that depend only on r
!! are computed once.
!!
!! The motion is its own mirror image half a period later, so one flight, from the right wall to the
!! left one, determines it. Where the nodes of the flight cannot decide, the motion is examined by
!! the general procedures.
module vi_equispaced_row
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_assess, only: admission, assess_flights, consistency, is_doubtful, paper_acceptance, &
      stability
   use vi_bernstein, only: sag, stays_within
   use vi_equispaced, only: line_type, new_line, symmetric_pair
   use vi_impact, only: primary_velocities
   use vi_impact_map, only: impact_map
   use vi_kinds, only: pi, wp
   use vi_law, only: holds
   use vi_motion, only: complete_motion, motion_type, start_motion, unknown
   use vi_lane_half, only: lane_halves
   use vi_lane_half_wide, only: lane_halves_wide => lane_halves
   use vi_nodes, only: find_largest, most_nodes, new_nodes, nodes_type
   use vi_new_plan, only: new_plan
   use vi_oscillator, only: eta, oscillator_type
   use vi_pattern, only: new_pattern
   use vi_periodic, only: linear_system_type
   use vi_plan, only: lanes, plan_type, unsure
   use vi_stability, only: multipliers_of_half
   use vi_status, only: stat
   use vi_unit_circle, only: all_inside, locate_spectrum, near_circle
   implicit none (type, external)
   private

   public :: new_row, row_pair, row_pairs

   !> What the motions of a row of a chart have in common.
   type, public :: row_type
      type(line_type) :: line
      !> A motion of the row; only its given data are set.
      type(motion_type) :: motion
      !> What the lanes of a block have in common.
      type(plan_type) :: plan
      !> Whether rounding has no effect on the motions of the row: far from a resonance without
      !! damping.
      logical :: certain = .false.
      !> Time from an impact to the next one, and the nodes of such a flight.
      real(wp) :: flight_time = 0
      type(nodes_type) :: nodes
   end type row_type

   !> The results of a motion that a chart keeps.
   type, public :: summary_type
      !> x_1, tau, x_min, x_max
      real(wp) :: x = 0, tau = 0, x_min = 0, x_max = 0
      complex(wp) :: multipliers(4) = 0
      integer :: consistent = unknown, admissible = unknown, stable = unknown
      integer :: status = stat%no_motion
   end type summary_type

   !> One motion: its state after the impact on the right wall, and the components of its flight.
   type :: half_type
      real(wp) :: clearance, x, x_dot, z_dot
      !> Coefficients of the four functions at the nodes; the last two are A cos(tau), A sin(tau).
      real(wp) :: parts(4)
      !> Bound on the fourth derivative of x.
      real(wp) :: bound
   end type half_type

contains

   !> A row of the chart; k = `cycles` is odd, and both walls have the same coefficient of
   !! restitution.
   pure subroutine new_row(osc, r, cycles, row)
      !> Oscillator with equal coefficients of restitution.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio.
      real(wp), intent(in) :: r
      !> Load cycles k in a period, odd.
      integer, intent(in) :: cycles
      !> Out: the row; its arrays are reused.
      type(row_type), intent(inout) :: row
      type(linear_system_type) :: system

      call start_motion(row%motion, osc, r, new_pattern('RL', cycles), osc%restitution, &
         [0.0_wp, cycles*pi])
      call new_line(row%motion, system, row%line)
      row%plan = new_plan(osc, row%motion%pattern, osc%restitution, paper_acceptance)
      row%certain = row%line%rounding < 1.0e-11_wp
      row%flight_time = cycles*pi/r
      call new_nodes(osc%xi, r, row%flight_time, row%nodes)
   end subroutine new_row

   !> Both motions of a row at a clearance, with their verdicts.
   pure subroutine row_pair(row, clearance, with_multipliers, pair)
      !> The row; its motion is used as scratch.
      type(row_type), intent(inout) :: row
      !> Clearance D = d K/F0.
      real(wp), intent(in) :: clearance
      !> Whether the multipliers are wanted, or only the verdict on them.
      logical, intent(in) :: with_multipliers
      !> Both motions; status `stat%no_motion` where one does not exist.
      type(summary_type), intent(out) :: pair(2)
      real(wp) :: x(2), forced(2, 2)
      integer :: i, status(2)

      call symmetric_pair(row%line, clearance, x, forced, status)
      pair%status = status
      do i = 1, 2
         if (pair(i)%status == stat%ok) call summarize(row, clearance, x(i), forced(:, i), &
            with_multipliers, pair(i))
      end do
   end subroutine row_pair

   !> Both motions of a row at many clearances, with their verdicts: as `row_pair`, but many points
   !! side by side.
   pure subroutine row_pairs(row, clearance, with_multipliers, wide, pairs)
      !> The row; its motion is used as scratch.
      type(row_type), intent(inout) :: row
      !> (m) Clearances D = d K/F0.
      real(wp), intent(in) :: clearance(:)
      !> Whether the multipliers are wanted, and whether the processor runs the wide procedures.
      logical, intent(in) :: with_multipliers, wide
      !> (2, size(clearance))
      type(summary_type), intent(out) :: pairs(:, :)
      real(wp) :: x(2), forced(2, 2), block(lanes, 4)
      integer :: i, j, n, status(2), place(2, lanes)

      n = 0
      do j = 1, size(clearance)
         call symmetric_pair(row%line, clearance(j), x, forced, status)
         pairs(:, j)%status = status
         do i = 1, 2
            if (status(i) /= stat%ok) cycle
            n = n + 1
            place(:, n) = [i, j]
            block(n, :) = [clearance(j), x(i), forced(:, i)]
            if (n == lanes) call row_block(row, n, block, place, with_multipliers, wide, &
               pairs)
         end do
      end do
      if (n > 0) call row_block(row, n, block, place, with_multipliers, wide, pairs)
   end subroutine row_pairs

   !> Computes the first n lanes of a block.
   pure subroutine row_block(row, n, block, place, with_multipliers, wide, pairs)
      !> The row; its motion is used as scratch.
      type(row_type), intent(inout) :: row
      !> In: number of lanes. Out: 0.
      integer, intent(inout) :: n
      !> (lanes, 4): clearance, x_1, A cos(tau), A sin(tau).
      real(wp), intent(inout) :: block(:, :)
      !> (2, lanes): where in `pairs` a lane belongs.
      integer, intent(in) :: place(:, :)
      !> As in `row_pairs`.
      logical, intent(in) :: with_multipliers, wide
      !> (2, m) In and out: the motions of these lanes are set.
      type(summary_type), intent(inout) :: pairs(:, :)
      real(wp) :: largest(lanes)
      integer :: l, stable(lanes), admissible(lanes)

      do l = n + 1, lanes
         block(l, :) = block(n, :)
      end do
      admissible = unsure
      if (row%nodes%n > 0 .and. row%certain) then
         if (wide) then
            call lane_halves_wide(row%plan, row%motion%r, row%flight_time, row%line%amplitude, &
               [row%motion%c1(1), row%motion%c2(1)], row%nodes%n, row%nodes%step, &
               row%nodes%position, row%nodes%rise, block, stable, admissible, largest)
         else
            call lane_halves(row%plan, row%motion%r, row%flight_time, row%line%amplitude, &
               [row%motion%c1(1), row%motion%c2(1)], row%nodes%n, row%nodes%step, &
               row%nodes%position, row%nodes%rise, block, stable, admissible, largest)
         end if
      end if
      do l = 1, n
         associate (summary => pairs(place(1, l), place(2, l)))
            if (admissible(l) == unsure .or. stable(l) == unsure) then
               call summarize(row, block(l, 1), block(l, 2), block(l, 3:4), with_multipliers, &
                  summary)
               cycle
            end if
            summary%x = block(l, 2)
            summary%tau = atan2(block(l, 4), block(l, 3))
            summary%x_min = -largest(l)
            summary%x_max = largest(l)
            summary%multipliers = cmplx(ieee_value(1.0_wp, ieee_quiet_nan), 0.0_wp, wp)
            summary%consistent = consistency(0.0_wp, paper_acceptance)
            summary%admissible = admission(admissible(l) == 1, .true.)
            summary%stable = stability(merge(0.0_wp, huge(1.0_wp), stable(l) == 1))
            if (with_multipliers) call find_stability(row, new_half(row, block(l, 1), &
               block(l, 2), block(l, 3:4)), .true., summary)
         end associate
      end do
      n = 0
   end subroutine row_block

   !> One motion of a row, with its verdicts.
   pure subroutine summarize(row, clearance, x, forced, with_multipliers, summary)
      !> The row; its motion is used as scratch.
      type(row_type), intent(inout) :: row
      !> Clearance D, x_1, and A cos(tau), A sin(tau) (F0/K).
      real(wp), intent(in) :: clearance, x, forced(2)
      !> Whether the multipliers are wanted, or only the verdict on them.
      logical, intent(in) :: with_multipliers
      !> Out: results and verdicts.
      type(summary_type), intent(inout) :: summary
      type(half_type) :: half
      logical :: certain

      half = new_half(row, clearance, x, forced)
      ! two equations for two unknowns leave no residual
      summary%consistent = consistency(0.0_wp, paper_acceptance)
      summary%x = x
      summary%tau = atan2(forced(2), forced(1))
      call find_stability(row, half, with_multipliers, summary)
      call find_extremes(row, half, summary, certain)
      if (certain) return
      call complete_motion(row%motion, [x, -x], forced(1), forced(2), clearance)
      call assess_flights(row%motion)
      summary%admissible = row%motion%admissible
      summary%x_min = row%motion%x_min
      summary%x_max = row%motion%x_max
   end subroutine summarize

   !> The flight of a motion of a row.
   pure type(half_type) function new_half(row, clearance, x, forced) result(half)
      !> The row.
      type(row_type), intent(in) :: row
      !> Clearance D, x_1, and A cos(tau), A sin(tau) (F0/K).
      real(wp), intent(in) :: clearance, x, forced(2)
      real(wp) :: a, b, before

      associate (osc => row%motion%osc, r => row%motion%r)
         half%clearance = clearance
         half%x = x
         half%z_dot = -2*(x + 0.5_wp*clearance)/row%flight_time
         call primary_velocities(osc%mu, osc%restitution(1), -half%z_dot, half%z_dot, before, &
            half%x_dot)
         b = x - forced(2)                                                                ! (6)
         a = (half%x_dot + osc%xi*b - r*forced(1))/eta(osc%xi)                            ! (5)
         half%parts = [a, b, forced]
         half%bound = sqrt(a**2 + b**2) + row%line%amplitude*(r**2)**2
      end associate
   end function new_half

   !> Sets `stable`, and the multipliers if they are wanted, from half a period.
   pure subroutine find_stability(row, half, with_multipliers, summary)
      !> The row.
      type(row_type), intent(in) :: row
      !> The flight of the motion.
      type(half_type), intent(in) :: half
      !> Whether the multipliers are wanted; otherwise they are NaN.
      logical, intent(in) :: with_multipliers
      !> Out: `stable` and multipliers; not changed where the map has no derivative.
      type(summary_type), intent(inout) :: summary
      !> Mirror: positions and velocities change sign, phases do not.
      real(wp), parameter :: mirror(4) = [-1, -1, -1, 1]
      real(wp) :: q(4, 4), unit(4)
      integer :: j, place, status
      logical :: regular, lawful

      summary%multipliers = cmplx(ieee_value(1.0_wp, ieee_quiet_nan), 0.0_wp, wp)
      associate (m => row%motion, forced => half%parts(3:4))
         call impact_map(m%osc%xi, m%osc%mu, m%r, m%restitution(1), m%length(1), m%c1(1), &
            m%c2(1), [forced(2), -forced(2)], [forced(1), -forced(1)], half%x, half%x_dot, &
            half%z_dot, q, regular)
      end associate
      if (.not. regular) return
      ! lengths in units of the clearance keep the eigenvalues and make the entries similar in size
      unit = [half%clearance, half%clearance, half%clearance, 1.0_wp]
      do j = 1, 4
         q(:, j) = q(:, j)*mirror*(unit(j)/unit)
      end do
      ! by (28) the approach speed, by which the map divides, is not below either velocity
      lawful = holds(q, exp(-2*row%motion%osc%xi*row%flight_time)*row%motion%restitution(1)**2, &
         row%line%rounding)
      place = near_circle
      if (.not. with_multipliers) place = locate_spectrum(q)
      if (place /= near_circle .and. lawful .and. row%certain) then
         summary%stable = stability(merge(0.0_wp, huge(1.0_wp), place == all_inside))
         return
      end if
      call multipliers_of_half(q, summary%multipliers, status)
      if (status == stat%ok .and. lawful .and. .not. is_doubtful(summary%multipliers(1), &
         row%line%rounding)) summary%stable = stability(abs(summary%multipliers(1)))
      if (with_multipliers) return
      summary%multipliers = cmplx(ieee_value(1.0_wp, ieee_quiet_nan), 0.0_wp, wp)
   end subroutine find_stability

   !> Sets `admissible`, x_min and x_max where the nodes and the bound between them decide.
   pure subroutine find_extremes(row, half, summary, certain)
      !> The row.
      type(row_type), intent(in) :: row
      !> The flight of the motion.
      type(half_type), intent(in) :: half
      !> Out: `admissible`, x_min and x_max, if `certain`.
      type(summary_type), intent(inout) :: summary
      !> Whether the nodes decide.
      logical, intent(out) :: certain
      real(wp), dimension(0:most_nodes) :: x, x_rise, y, y_rise
      real(wp) :: largest, wall, dip
      logical :: approaches, inside
      integer :: j, n

      n = row%nodes%n
      certain = n > 0
      if (.not. certain) return
      wall = 0.5_wp*half%clearance
      associate (h => row%nodes%step)
         do j = 0, n
            x(j) = dot_product(half%parts, row%nodes%position(:, j))
            x_rise(j) = dot_product(half%parts, row%nodes%rise(:, j))
            y(j) = half%x + wall + half%z_dot*(j*h) - x(j)
            y_rise(j) = half%z_dot*h - x_rise(j)
         end do
      end associate
      ! at the ends the masses touch
      x(0) = half%x
      x(n) = -half%x
      y(0) = wall
      y(n) = -wall
      dip = sag(half%bound, row%nodes%step)
      ! by (28) the approach speed is 2 (1 + mu)/(1 + R) times that of the free mass
      approaches = half%z_dot < 0
      inside = stays_within(wall, y(:n), y_rise(:n), dip)
      certain = inside .or. .not. approaches
      if (.not. certain) certain = any(abs(y(1:n - 1)) > wall*(1 + 1.0e-12_wp))
      if (certain) call find_largest(row%nodes, half%parts, half%bound, x(:n), x_rise(:n), &
         largest, certain)
      if (.not. certain) return
      summary%admissible = admission(approaches .and. inside, .true.)
      summary%x_min = -largest
      summary%x_max = largest
   end subroutine find_extremes

end module vi_equispaced_row
