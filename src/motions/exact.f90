!> Exact motions: Newton's method on the 2N unknowns x_i, alpha_i at a given clearance.
!!
!! The equations (26), (30) with A known and the phases unknown (the footnote on the paper's page
!! 45). They require that every flight ends with the position and velocity with which the next
!! impact begins. The unknown phases are theta_i = alpha_i + tau, the arguments of the forced motion
!! A sin(theta).
module vi_exact
   use vi_flight, only: flight_type, new_flight
   use vi_impact, only: primary_velocities
   use vi_kinds, only: two_pi, wp
   use vi_lapack, only: solve
   use vi_motion, only: motion_type, set_phases, start_motion
   use vi_oscillation, only: derivatives
   use vi_oscillator, only: eta, gain, oscillator_type
   use vi_pattern, only: pattern_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: deflation, member, newton_equations, solve_exact, step_share

   !> Newton step (positions over the clearance, and phases) below which rounding may be reached, a
   !! step that is negligible, and relative residuals that are due to rounding.
   real(wp), parameter :: small = max(1.0e-7_wp, 100*epsilon(1.0_wp)), &
      negligible = 4000*epsilon(1.0_wp), at_rounding = 200*epsilon(1.0_wp)

   !> Relative residual up to which an exact motion counts as consistent.
   real(wp), parameter, public :: exact_acceptance = 1.0e-9_wp

   !> The given data of an exact motion.
   type, public :: setting_type
      type(oscillator_type) :: osc
      real(wp) :: r = 1, load = 1, clearance = 1
      type(pattern_type) :: pattern
      real(wp), allocatable :: restitution(:)
   end type setting_type

contains

   !> Newton's method from a guess; the motion is without verdicts.
   !!
   !! It ends at rounding: after a negligible step, or, once the steps or the residuals are small,
   !! after a step that is no shorter than the one before. Near a singular Jacobian, that is near a
   !! fold or a pitchfork, the steps shrink slowly at first, and rounding has a large effect on the
   !! unknowns.
   pure subroutine solve_exact(setting, x, theta, most, known, motion, iterations)
      !> Given data of the motion.
      type(setting_type), intent(in) :: setting
      !> In: guess of x_i and theta_i (N). Out: the last iterate.
      real(wp), intent(inout) :: x(:), theta(:)
      !> Most iterations.
      integer, intent(in) :: most
      !> Motions already known (2N, m), in the unknowns (x, theta): they repel the iteration.
      real(wp), intent(in) :: known(:, :)
      !> Out: the motion without verdicts, or its status; its arrays are reused.
      type(motion_type), intent(inout) :: motion
      !> Number of Newton steps made.
      integer, intent(out) :: iterations
      real(wp), allocatable :: jacobian(:, :), step(:), unknowns(:), best(:)
      real(wp) :: size_step, size_before, residual, least, share, scale
      integer :: n, status
      logical :: worse

      n = size(x)
      call start_motion(motion, setting%osc, setting%r, setting%pattern, setting%restitution, &
         theta - theta(1))
      motion%status = stat%no_convergence
      allocate (jacobian(2*n, 2*n), step(2*n), unknowns(2*n))
      unknowns = [x, theta]
      best = unknowns
      scale = setting%clearance
      size_step = huge(1.0_wp)
      least = huge(1.0_wp)
      worse = .false.
      call newton_equations(setting, unknowns, step, jacobian)
      do iterations = 1, most
         call solve(jacobian, step, status)
         if (status /= stat%ok .or. .not. all(abs(step) <= huge(1.0_wp))) then
            motion%status = stat%singular
            return
         end if
         step = -step*deflation(unknowns, -step, known, scale)
         share = step_share(setting%pattern%cycles, unknowns, step)
         if (share < 1.0e-6_wp) return
         unknowns = unknowns + share*step
         x = unknowns(:n)
         theta = unknowns(n + 1:)
         size_before = size_step
         size_step = max(maxval(abs(step(:n)))/scale, maxval(abs(step(n + 1:))))
         if (size_step < negligible) exit
         call newton_equations(setting, unknowns, step, jacobian)
         residual = maxval(abs(step))/(scale + maxval(abs(x)))
         if (size_step > 0.9_wp*size_before) then
            if (size_step < small .or. residual < at_rounding) exit
         end if
         worse = residual >= least
         if (.not. worse) then
            least = residual
            best = unknowns
         end if
      end do
      if (iterations > most) then
         ! near a singular Jacobian the last step may lead away from the solution
         if (.not. (worse .and. least < at_rounding)) return
         x = best(:n)
         theta = best(n + 1:)
      end if
      call finish(setting, x, theta, motion)
   end subroutine solve_exact

   !> Residuals E_i of all flights, position then velocity, and their derivatives.
   pure subroutine newton_equations(setting, unknowns, residual, jacobian)
      !> Given data of the motion.
      type(setting_type), intent(in) :: setting
      !> x_i, theta_i (2N)
      real(wp), intent(in) :: unknowns(:)
      !> (2N): x and x' at the end of flight i less those just before impact i+1.
      real(wp), intent(out) :: residual(:)
      !> (2N, 2N)
      real(wp), intent(out) :: jacobian(:, :)
      real(wp), dimension(size(unknowns)/2) :: x, theta, z, time, speed, before, after
      real(wp), dimension(size(unknowns)/2, size(unknowns)) :: d_speed, d_before, d_after
      real(wp) :: d_time(size(unknowns)), end_d(0:5), s(4), forced(2), amplitude
      type(flight_type) :: flight
      integer :: n, i, next, previous

      n = size(x)
      x = unknowns(:n)
      theta = unknowns(n + 1:)
      z = x + 0.5_wp*setting%clearance*setting%pattern%sides
      amplitude = setting%load*gain(setting%osc%xi, setting%r)
      d_speed = 0
      do i = 1, n
         next = modulo(i, n) + 1
         time(i) = (theta(next) - theta(i) + merge(two_pi*setting%pattern%cycles, 0.0_wp, i == n)) &
            /setting%r
         speed(i) = (z(next) - z(i))/time(i)                                              ! (16)
         d_speed(i, next) = d_speed(i, next) + 1/time(i)
         d_speed(i, i) = d_speed(i, i) - 1/time(i)
         d_speed(i, n + next) = d_speed(i, n + next) - speed(i)/(time(i)*setting%r)
         d_speed(i, n + i) = d_speed(i, n + i) + speed(i)/(time(i)*setting%r)
      end do
      call primary_velocities(setting%osc%mu, setting%restitution, cshift(speed, -1), speed, &
         before, after)
      do i = 1, n
         previous = modulo(i - 2, n) + 1
         call primary_velocities(setting%osc%mu, setting%restitution(i), d_speed(previous, :), &
            d_speed(i, :), d_before(i, :), d_after(i, :))
      end do
      do i = 1, n
         next = modulo(i, n) + 1
         flight = new_flight(setting%osc%xi, setting%r, amplitude, theta(i), x(i), after(i), z(i), &
            speed(i), time(i))
         end_d = derivatives(flight, time(i))
         residual(i) = end_d(0) - x(next)
         residual(n + i) = end_d(1) - before(next)
         call transfer(flight, time(i), s, forced)
         d_time = 0
         d_time(n + next) = d_time(n + next) + 1/setting%r
         d_time(n + i) = d_time(n + i) - 1/setting%r
         jacobian(i, :) = s(2)*d_after(i, :) + end_d(1)*d_time
         jacobian(i, i) = jacobian(i, i) + s(1)
         jacobian(i, n + i) = jacobian(i, n + i) + forced(1)
         jacobian(i, next) = jacobian(i, next) - 1
         jacobian(n + i, :) = s(4)*d_after(i, :) + end_d(2)*d_time - d_before(next, :)
         jacobian(n + i, i) = jacobian(n + i, i) + s(3)
         jacobian(n + i, n + i) = jacobian(n + i, n + i) + forced(2)
      end do
   end subroutine newton_equations

   !> Derivatives of x and x' after a given time with respect to x and x' at the start (S_1..S_4 of
   !! (A6)), and with respect to the phase of the forced motion.
   pure subroutine transfer(flight, t, s, forced)
      !> The flight.
      type(flight_type), intent(in) :: flight
      !> Time after its start (1/omega).
      real(wp), intent(in) :: t
      !> S_1 .. S_4: derivatives of x with respect to x and x' at the start, then those of x'; and
      !! the derivatives of x and x' with respect to the phase (rad).
      real(wp), intent(out) :: s(4), forced(2)
      real(wp) :: h, c1, c2, start(2), finish(2)

      h = eta(flight%decay)
      c2 = exp(-flight%decay*t)
      c1 = c2*sin(h*t)
      c2 = c2*cos(h*t)
      s = [c2 + flight%decay*c1/h, c1/h, -c1/h, c2 - flight%decay*c1/h]
      start = flight%amplitude*[cos(flight%phase), -flight%r*sin(flight%phase)]
      finish = flight%amplitude*[cos(flight%phase + flight%r*t), &
         -flight%r*sin(flight%phase + flight%r*t)]
      forced = finish - [s(1)*start(1) + s(2)*start(2), s(3)*start(1) + s(4)*start(2)]
   end subroutine transfer

   !> The fraction of a Newton step that leaves every flight at least half its duration.
   pure real(wp) function step_share(cycles, unknowns, step) result(share)
      !> Load cycles k of the period.
      integer, intent(in) :: cycles
      !> x_i, theta_i, and the step in them (2N).
      real(wp), intent(in) :: unknowns(:), step(:)
      real(wp) :: length, shrinks
      integer :: i, n, next

      n = size(unknowns)/2
      share = 1
      do i = 1, n
         next = merge(1, i + 1, i == n)
         length = unknowns(n + next) - unknowns(n + i)
         if (i == n) length = length + two_pi*cycles
         shrinks = step(n + i) - step(n + next)
         if (shrinks > 0) share = min(share, 0.5_wp*length/shrinks)
      end do
   end function step_share

   !> The factor on a Newton step that makes known motions repel it.
   !!
   !! For the equations multiplied by m(u) = prod (1/|u - u_j|^2 + 1) the Newton step is the plain
   !! step divided by 1 - step . grad(log m) (Farrell, Birkisson and Funke, SIAM J. Sci. Comput. 37,
   !! 2015).
   pure real(wp) function deflation(unknowns, step, known, scale) result(factor)
      !> x_i, theta_i, and the plain step in them (2N); motions already known (2N, m).
      real(wp), intent(in) :: unknowns(:), step(:), known(:, :)
      !> Unit of x_i.
      real(wp), intent(in) :: scale
      real(wp) :: along(2), distance, square, slope, turns
      integer :: i, j, n

      n = size(unknowns)/2
      slope = 0
      do j = 1, size(known, 2)
         square = 0
         along = 0
         do i = 1, n
            distance = (unknowns(i) - known(i, j))/scale
            square = square + distance**2
            along(1) = along(1) + distance*step(i)
         end do
         turns = two_pi*nint((unknowns(n + 1) - known(n + 1, j))/two_pi)
         do i = n + 1, 2*n
            distance = unknowns(i) - known(i, j) - turns
            square = square + distance**2
            along(2) = along(2) + distance*step(i)
         end do
         square = max(square, tiny(1.0_wp)**0.25_wp)
         slope = slope - 2*(along(1)/scale + along(2))/(square*(1 + square))
      end do
      factor = 1 - slope
      factor = 1/merge(factor, sign(1.0e-3_wp, factor), abs(factor) > 1.0e-3_wp)
   end function deflation

   !> The motion, without verdicts, given unknowns that solve the equations.
   pure subroutine member(setting, x, theta, motion)
      !> Given data of the motion.
      type(setting_type), intent(in) :: setting
      !> (N) Positions x_i (F0/K) and theta_i = alpha_i + tau (rad) that solve the equations.
      real(wp), intent(in) :: x(:), theta(:)
      !> Out: the motion without verdicts, or its status; its arrays are reused.
      type(motion_type), intent(inout) :: motion

      call start_motion(motion, setting%osc, setting%r, setting%pattern, setting%restitution, &
         theta - theta(1))
      call finish(setting, x, theta, motion)
   end subroutine member

   !> Writes a converged solution into a motion.
   pure subroutine finish(setting, x, theta, motion)
      !> Given data of the motion.
      type(setting_type), intent(in) :: setting
      !> (N) Positions x_i (F0/K) and theta_i = alpha_i + tau (rad).
      real(wp), intent(in) :: x(:), theta(:)
      !> In: as `start_motion` leaves it. Out: complete; status `stat%no_convergence` if the
      !! residual is too large.
      type(motion_type), intent(inout) :: motion
      real(wp) :: residual(2*size(x)), unused(2*size(x), 2*size(x))
      real(wp) :: time(size(x))
      integer :: n, i, next

      n = size(x)
      call set_phases(motion, theta - theta(1))
      motion%tau = atan2(sin(theta(1)), cos(theta(1)))
      motion%amplitude = setting%load*gain(setting%osc%xi, setting%r)
      motion%clearance = setting%clearance
      motion%x = x
      motion%z = x + 0.5_wp*setting%clearance*setting%pattern%sides
      do i = 1, n
         next = modulo(i, n) + 1
         time(i) = (theta(next) - theta(i) + merge(two_pi*setting%pattern%cycles, 0.0_wp, i == n)) &
            /setting%r
         motion%z_dot_after(i) = (motion%z(next) - motion%z(i))/time(i)
      end do
      motion%z_dot_before = cshift(motion%z_dot_after, -1)
      call primary_velocities(motion%osc%mu, motion%restitution, motion%z_dot_before, &
         motion%z_dot_after, motion%x_dot_before, motion%x_dot_after)
      call newton_equations(setting, [x, theta], residual, unused)
      motion%residual = norm2(residual)/max(setting%clearance, maxval(abs(motion%x_dot_after)), &
         maxval(abs(motion%z_dot_after)))
      motion%status = merge(stat%ok, stat%no_convergence, motion%residual &
         < exact_acceptance)
   end subroutine finish

end module vi_exact
