!> The equispaced pair at one frequency ratio and many clearances: what depends on r is done once.
!!
!! The motion is its own mirror image half a period later, so one flight, from the right wall to the
!! left one, tells all. Where the nodes of the flight cannot decide, the motion goes through the
!! general procedures.
module vi_equispaced_row
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_assess, only: admission, assess_flights, consistency, paper_acceptance, stability
   use vi_bernstein, only: sag, stays_within
   use vi_equispaced, only: line_type, new_line, symmetric_pair
   use vi_impact, only: primary_velocities
   use vi_impact_map, only: impact_map
   use vi_kinds, only: wp
   use vi_motion, only: complete_motion, motion_type, start_motion, unknown, yes
   use vi_nodes, only: find_largest, most_nodes, new_nodes, nodes_type
   use vi_oscillator, only: eta, oscillator_type
   use vi_pattern, only: new_pattern
   use vi_periodic, only: linear_system_type
   use vi_stability, only: multipliers_of_half
   use vi_status, only: stat
   use vi_unit_circle, only: all_inside, locate_spectrum, near_circle
   implicit none (type, external)
   private

   public :: new_row, row_pair

   real(wp), parameter :: pi = acos(-1.0_wp)

   type, public :: row_type
      type(line_type) :: line
      !> A motion of the row without its numbers.
      type(motion_type) :: motion
      !> Time from an impact to the next one, and the nodes of such a flight.
      real(wp) :: flight_time = 0
      type(nodes_type) :: nodes
   end type row_type

   !> What a chart keeps of a motion.
   type, public :: summary_type
      !> x_1, tau, x_min, x_max
      real(wp) :: x = 0, tau = 0, x_min = 0, x_max = 0
      complex(wp) :: multipliers(4) = 0
      integer :: consistent = unknown, admissible = unknown, stable = unknown
      integer :: status = stat%no_motion
   end type summary_type

   !> One motion: its state after the impact on the right wall, and the parts of its flight.
   type :: half_type
      real(wp) :: clearance, x, x_dot, z_dot, x_dot_before
      !> Coefficients of the four functions at the nodes; the last two are A cos(tau), A sin(tau).
      real(wp) :: parts(4)
      !> Bound on the fourth derivative of x.
      real(wp) :: bound
   end type half_type

contains

   !> A row of the chart; k = `cycles` is odd and both walls have one coefficient of restitution.
   pure subroutine new_row(osc, r, cycles, row)
      type(oscillator_type), intent(in) :: osc
      real(wp), intent(in) :: r
      integer, intent(in) :: cycles
      type(row_type), intent(inout) :: row
      type(linear_system_type) :: system

      call start_motion(row%motion, osc, r, new_pattern('RL', cycles), osc%restitution, &
         [0.0_wp, cycles*pi])
      call new_line(row%motion, system, row%line)
      row%flight_time = cycles*pi/r
      call new_nodes(osc%xi, r, row%flight_time, row%nodes)
   end subroutine new_row

   !> Both motions of a row at a clearance, with their verdicts.
   pure subroutine row_pair(row, clearance, with_multipliers, pair)
      type(row_type), intent(inout) :: row
      real(wp), intent(in) :: clearance
      !> Whether the multipliers are wanted, or only the verdict on them.
      logical, intent(in) :: with_multipliers
      type(summary_type), intent(out) :: pair(2)
      type(half_type) :: half
      real(wp) :: x(2), forced(2, 2)
      logical :: certain
      integer :: i, status(2)

      call symmetric_pair(row%line, clearance, x, forced, status)
      pair%status = status
      do i = 1, 2
         if (pair(i)%status /= stat%ok) cycle
         half = new_half(row, clearance, x(i), forced(:, i))
         ! two equations for two unknowns leave no residual
         pair(i)%consistent = consistency(0.0_wp, paper_acceptance)
         pair(i)%x = x(i)
         pair(i)%tau = atan2(forced(2, i), forced(1, i))
         call find_stability(row, half, with_multipliers, pair(i))
         call find_extremes(row, half, pair(i), certain)
         if (certain) cycle
         call complete_motion(row%motion, [x(i), -x(i)], forced(1, i), forced(2, i), clearance)
         call assess_flights(row%motion)
         pair(i)%admissible = row%motion%admissible
         pair(i)%x_min = row%motion%x_min
         pair(i)%x_max = row%motion%x_max
      end do
   end subroutine row_pair

   pure type(half_type) function new_half(row, clearance, x, forced) result(half)
      type(row_type), intent(in) :: row
      real(wp), intent(in) :: clearance, x, forced(2)
      real(wp) :: a, b

      associate (osc => row%motion%osc, r => row%motion%r)
         half%clearance = clearance
         half%x = x
         half%z_dot = -2*(x + 0.5_wp*clearance)/row%flight_time
         call primary_velocities(osc%mu, osc%restitution(1), -half%z_dot, half%z_dot, &
            half%x_dot_before, half%x_dot)
         b = x - forced(2)                                                                ! (6)
         a = (half%x_dot + osc%xi*b - r*forced(1))/eta(osc%xi)                            ! (5)
         half%parts = [a, b, forced]
         half%bound = sqrt(a**2 + b**2) + row%line%amplitude*(r**2)**2
      end associate
   end function new_half

   !> `stable`, and the multipliers if they are wanted, from half a period.
   pure subroutine find_stability(row, half, with_multipliers, summary)
      type(row_type), intent(in) :: row
      type(half_type), intent(in) :: half
      logical, intent(in) :: with_multipliers
      type(summary_type), intent(inout) :: summary
      !> Mirror: positions and velocities change sign, phases do not.
      real(wp), parameter :: mirror(4) = [-1, -1, -1, 1]
      real(wp) :: q(4, 4), unit(4)
      integer :: j, place, status
      logical :: regular

      summary%multipliers = cmplx(ieee_value(1.0_wp, ieee_quiet_nan), 0.0_wp, wp)
      associate (m => row%motion, forced => half%parts(3:4))
         call impact_map(m%osc%xi, m%osc%mu, m%r, m%restitution(1), m%length(1), m%c1(1), &
            m%c2(1), [forced(2), -forced(2)], [forced(1), -forced(1)], half%x, half%x_dot, &
            half%z_dot, q, regular)
      end associate
      if (.not. regular) return
      ! lengths in units of the clearance leave the eigenvalues and bring the entries together
      unit = [half%clearance, half%clearance, half%clearance, 1.0_wp]
      do j = 1, 4
         q(:, j) = q(:, j)*mirror*(unit(j)/unit)
      end do
      place = near_circle
      if (.not. with_multipliers) place = locate_spectrum(q)
      if (place /= near_circle) then
         summary%stable = stability(merge(0.0_wp, huge(1.0_wp), place == all_inside))
         return
      end if
      call multipliers_of_half(q, summary%multipliers, status)
      if (status == stat%ok) summary%stable = stability(abs(summary%multipliers(1)))
      if (with_multipliers) return
      summary%multipliers = cmplx(ieee_value(1.0_wp, ieee_quiet_nan), 0.0_wp, wp)
   end subroutine find_stability

   !> `admissible`, x_min and x_max where the nodes and the bound between them decide.
   pure subroutine find_extremes(row, half, summary, certain)
      type(row_type), intent(in) :: row
      type(half_type), intent(in) :: half
      type(summary_type), intent(inout) :: summary
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
      approaches = half%z_dot + half%x_dot_before < 0
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
