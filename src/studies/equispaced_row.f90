!> The equispaced pair at one frequency ratio and many clearances: what depends on r is done once.
!!
!! The motion is its own mirror image half a period later, so one flight, from the right wall to the
!! left one, tells all. Every motion of a row has the same flight time; the free and the forced
!! oscillation are known at fixed nodes, and each motion is a combination of those. A bound on the
!! fourth derivative certifies what happens between the nodes. Where the bound cannot decide, the
!! motion goes through the general procedures.
module vi_equispaced_row
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_assess, only: admission, assess_flights, consistency, paper_acceptance, stability
   use vi_bernstein, only: stays_positive
   use vi_equispaced, only: line_type, new_line, symmetric_pair
   use vi_impact, only: primary_velocities
   use vi_impact_map, only: impact_map
   use vi_kinds, only: wp
   use vi_motion, only: complete_motion, motion_type, start_motion, unknown, yes
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
   !> Nodes in half a load cycle or half a free oscillation; with more than `most_nodes` in a flight
   !! the general procedures are as fast.
   integer, parameter :: density = 12, most_nodes = 240

   type, public :: row_type
      type(line_type) :: line
      !> A motion of the row without its numbers.
      type(motion_type) :: motion
      !> Time from an impact to the next one and from a node to the next one.
      real(wp) :: flight_time = 0, step = 0
      integer :: n = 0
      !> (4, 0:n): position of the free parts and the forced parts at the nodes, and velocities:
      !! exp(-xi t) sin(eta t), exp(-xi t) cos(eta t), sin(r t), cos(r t).
      real(wp), allocatable :: position(:, :), velocity(:, :)
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
      real(wp) :: t, shrink, s, c, nodes
      integer :: j

      call start_motion(row%motion, osc, r, new_pattern('RL', cycles), osc%restitution, &
         [0.0_wp, cycles*pi])
      call new_line(row%motion, system, row%line)
      row%flight_time = cycles*pi/r
      nodes = density*row%flight_time*max(1.0_wp, r)/pi
      row%n = 0
      if (nodes > most_nodes) return
      row%n = ceiling(nodes)
      row%step = row%flight_time/row%n
      if (allocated(row%position)) deallocate (row%position, row%velocity)
      allocate (row%position(4, 0:row%n), row%velocity(4, 0:row%n))
      associate (h => eta(osc%xi), xi => osc%xi)
         do j = 0, row%n
            t = j*row%step
            shrink = exp(-xi*t)
            s = shrink*sin(h*t)
            c = shrink*cos(h*t)
            row%position(:, j) = [s, c, sin(r*t), cos(r*t)]
            row%velocity(:, j) = [h*c - xi*s, -h*s - xi*c, r*cos(r*t), -r*sin(r*t)]
         end do
      end associate
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
      integer :: i

      call symmetric_pair(row%line, clearance, x, forced, pair%status)
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
         half%bound = hypot(a, b) + row%line%amplitude*r**4
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
      if (.not. with_multipliers) &
         summary%multipliers = cmplx(ieee_value(1.0_wp, ieee_quiet_nan), 0.0_wp, wp)
   end subroutine find_stability

   !> `admissible`, x_min and x_max where the nodes and the bound between them decide.
   pure subroutine find_extremes(row, half, summary, certain)
      type(row_type), intent(in) :: row
      type(half_type), intent(in) :: half
      type(summary_type), intent(inout) :: summary
      logical, intent(out) :: certain
      real(wp), dimension(0:row%n) :: x, x_dot, y, y_dot
      real(wp) :: largest
      logical :: approaches, inside
      integer :: j

      certain = row%n > 0
      if (.not. certain) return
      do j = 0, row%n
         x(j) = dot_product(half%parts, row%position(:, j))
         x_dot(j) = dot_product(half%parts, row%velocity(:, j))
         y(j) = half%x + 0.5_wp*half%clearance + half%z_dot*(j*row%step) - x(j)
         y_dot(j) = half%z_dot - x_dot(j)
      end do
      ! at the ends the masses touch
      x(0) = half%x
      x(row%n) = -half%x
      y(0) = 0.5_wp*half%clearance
      y(row%n) = -y(0)
      approaches = half%z_dot + half%x_dot_before < 0
      inside = .false.
      if (approaches) call stay_between(row%step, 0.5_wp*half%clearance, half%bound, y, y_dot, &
         inside, certain)
      if (certain) call largest_position(row, half, x, x_dot, largest, certain)
      if (.not. certain) return
      summary%admissible = admission(approaches .and. inside, .true.)
      summary%x_min = -largest
      summary%x_max = largest
   end subroutine find_extremes

   !> Whether |y| < half the clearance inside the flight, where that is certain.
   pure subroutine stay_between(h, wall, bound, y, y_dot, inside, certain)
      real(wp), intent(in) :: h, wall, bound
      real(wp), intent(in) :: y(0:), y_dot(0:)
      logical, intent(out) :: inside, certain
      integer :: j, n

      n = ubound(y, 1)
      inside = .false.
      certain = any(abs(y(1:n - 1)) > wall*(1 + 1.0e-12_wp))
      if (certain) return
      do j = 1, n
         if (.not. (stays_positive(wall - y(j - 1), -y_dot(j - 1), wall - y(j), -y_dot(j), h, &
            bound, 0.0_wp) .and. stays_positive(wall + y(j - 1), y_dot(j - 1), wall + y(j), &
            y_dot(j), h, bound, 0.0_wp))) return
      end do
      inside = .true.
      certain = .true.
   end subroutine stay_between

   !> The largest |x| of the flight: Newton from the largest node, then a proof that it is the
   !! largest.
   pure subroutine largest_position(row, half, x, x_dot, largest, certain)
      type(row_type), intent(in) :: row
      type(half_type), intent(in) :: half
      real(wp), intent(in) :: x(0:), x_dot(0:)
      real(wp), intent(out) :: largest
      logical, intent(out) :: certain
      real(wp) :: shift, time, before, after, peak, rounding
      integer :: j, top

      top = maxloc(abs(x), 1) - 1
      peak = x(top)
      shift = 0
      ! the flight ends at its end, even if |x| would grow beyond
      if (top == 0) then
         if (peak*x_dot(0) > 0) call climb(row, half, top, shift, peak)
      else if (top < row%n .or. peak*x_dot(row%n) < 0) then
         call climb(row, half, top, shift, peak)
      end if
      time = top*row%step + shift
      largest = abs(peak)
      rounding = 100*epsilon(1.0_wp)*(half%bound + largest)
      certain = time >= 0 .and. time <= row%flight_time .and. abs(shift) < row%step
      do j = 1, row%n
         if (.not. certain) return
         before = time - (j - 1)*row%step
         after = row%step - before
         if (before > 0 .and. after > 0) then
            certain = within(largest, x(j - 1), x_dot(j - 1), peak, 0.0_wp, before, half%bound, &
               rounding) .and. within(largest, peak, 0.0_wp, x(j), x_dot(j), after, half%bound, &
               rounding)
         else
            certain = within(largest, x(j - 1), x_dot(j - 1), x(j), x_dot(j), row%step, &
               half%bound, rounding)
         end if
      end do
   end subroutine largest_position

   !> Whether |x| <= limit between two points is certain.
   pure logical function within(limit, x, x_dot, x_end, x_dot_end, h, bound, rounding)
      real(wp), intent(in) :: limit, x, x_dot, x_end, x_dot_end, h, bound, rounding

      within = stays_positive(limit - x, -x_dot, limit - x_end, -x_dot_end, h, bound, rounding)
      if (within) within = stays_positive(limit + x, x_dot, limit + x_end, x_dot_end, h, bound, &
         rounding)
   end function within

   !> The stationary point of x nearest to a node: its time from there, and x.
   pure subroutine climb(row, half, j, shift, x)
      type(row_type), intent(in) :: row
      type(half_type), intent(in) :: half
      integer, intent(in) :: j
      real(wp), intent(out) :: shift, x
      !> Terms of the Taylor series about the node; they are below rounding within half a step.
      integer, parameter :: terms = 12
      real(wp) :: free(0:terms), forced(0:terms), d(0:terms), slope, curvature
      integer :: i, n

      associate (p => half%parts, q => row%position(:, j), v => row%velocity(:, j))
         free(0:1) = [p(1)*q(1) + p(2)*q(2), p(1)*v(1) + p(2)*v(2)]
         forced(0:1) = [p(3)*q(3) + p(4)*q(4), p(3)*v(3) + p(4)*v(4)]
      end associate
      do n = 2, terms
         free(n) = -2*row%motion%osc%xi*free(n - 1) - free(n - 2)
         forced(n) = -row%motion%r**2*forced(n - 2)
      end do
      d = free + forced
      shift = 0
      do i = 1, 6
         slope = 0
         curvature = 0
         do n = terms, 2, -1
            slope = (d(n) + slope*shift/n)
            curvature = (d(n) + curvature*shift/(n - 1))
         end do
         slope = d(1) + slope*shift
         if (.not. abs(slope) < huge(1.0_wp)*abs(curvature)) exit
         shift = shift - slope/curvature
         if (abs(slope) <= 1.0e-9_wp*abs(curvature)*row%step .or. abs(shift) > row%step) exit
      end do
      x = 0
      do n = terms, 1, -1
         x = (d(n) + x)*shift/n
      end do
      x = d(0) + x
   end subroutine climb

end module vi_equispaced_row
