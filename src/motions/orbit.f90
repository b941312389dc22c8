!> A periodic motion as a root of equations in its positions, phases and parameters.
!!
!! The equations require that every flight ends with the position and velocity with which the next
!! impact begins: (26) and (30) with A known. For motions that are their own mirror image half a
!! period later, a fold has the multiplier +1 of the half-period map, and the pitchfork, where the
!! symmetry is lost, has -1.
module vi_orbit
   use vi_flight, only: flight_type, new_flight
   use vi_impact_map, only: impact_map
   use vi_kinds, only: wp
   use vi_member, only: by_clearance, by_left, by_mu, by_r, by_right, by_xi, family_type, &
      most_impacts, n_parameters, oscillator_of, oscillator_parameters, orbit_type, set_orbit, &
      span_of
   use vi_oscillator, only: eta
   implicit none (type, external)
   private

   public :: set_orbit, orbit_residual, orbit_slopes, orbit_by_parameter
   public :: by_forced, by_law, by_speed, by_time, by_position, by_velocity, flight_at, &
      period_parts, span_of, split_part, transfer_by_xi
   public :: by_clearance, by_left, by_mu, by_r, by_right, by_xi, n_parameters, most_impacts
   public :: family_type, orbit_type, oscillator_of, oscillator_parameters

contains

   !> The flight after impact i, lengths in units of the clearance.
   pure function flight_at(o, i) result(flight)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> Number of the impact.
      integer, intent(in) :: i
      type(flight_type) :: flight

      flight = new_flight(o%xi, o%r, o%amplitude, o%theta(i), o%u(i), o%after(i), o%z(i), &
         o%speed(i), o%time(i))
   end function flight_at

   !> Position and velocity at the end of each flight less those just before the next impact (2n).
   pure function orbit_residual(o) result(residual)
      !> The orbit; lengths in units of the clearance.
      type(orbit_type), intent(in) :: o
      real(wp) :: residual(2*o%n)
      real(wp) :: free(2)
      integer :: i

      do i = 1, o%n
         free = free_end(o, i)
         residual(i) = free(1) + o%forced(i + 1) - o%u(i + 1)
         residual(o%n + i) = free(2) + o%forced_dot(i + 1) - o%before(i + 1)
      end do
   end function orbit_residual

   !> Position and velocity of the free part of the motion at the end of a flight.
   pure function free_end(o, i) result(free)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> Number of the flight.
      integer, intent(in) :: i
      real(wp) :: free(2)

      associate (x => o%u(i) - o%forced(i), v => o%after(i) - o%forced_dot(i), s => o%s(:, i))
         free = [s(1)*x + s(2)*v, s(3)*x + s(4)*v]
      end associate
   end function free_end

   !> The residuals, and the gradient of each with respect to u_i, theta_i and the parameters that
   !! are varied.
   pure subroutine orbit_slopes(o, slopes, residual)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> (at least 2n + o%varied, 2n) slopes(:, j): gradient of residual j.
      real(wp), contiguous, intent(out) :: slopes(:, :)
      !> (2n) As `orbit_residual`.
      real(wp), intent(out) :: residual(:)
      real(wp) :: free(2), d(4)
      integer :: n, i, next

      n = o%n
      do i = 1, n
         next = merge(1, i + 1, i == n)
         free = free_end(o, i)
         residual(i) = free(1) + o%forced(i + 1) - o%u(i + 1)
         residual(n + i) = free(2) + o%forced_dot(i + 1) - o%before(i + 1)
         slopes(:2*n + o%varied, i) = 0
         slopes(:2*n + o%varied, n + i) = 0
         associate (s => o%s(:, i), x => slopes(:, i), v => slopes(:, n + i), &
            after => o%of_after(:, i), before => o%of_before(:, next))
            x(i) = s(1)
            v(i) = s(3)
            x(next) = x(next) - merge(o%sign, 1.0_wp, i == n)
            call by_speed(o, i - 1, s(2)*after(1), x)
            call by_speed(o, i - 1, s(4)*after(1), v)
            call by_speed(o, i, s(2)*after(2), x)
            call by_speed(o, i, s(4)*after(2) - before(1), v)
            call by_speed(o, i + 1, -before(2), v)
            call by_time(o, i, free(2), x)
            call by_time(o, i, -2*o%xi*free(2) - free(1), v)
            call by_forced(o, i, -s(1), -s(2), x)
            call by_forced(o, i, -s(3), -s(4), v)
            call by_forced(o, i + 1, 1.0_wp, 0.0_wp, x)
            call by_forced(o, i + 1, 0.0_wp, 1.0_wp, v)
            if (o%varied <= by_clearance) cycle
            d = transfer_by_xi(o, i, o%time(i))
            free = [o%u(i) - o%forced(i), o%after(i) - o%forced_dot(i)]
            x(2*n + by_xi) = x(2*n + by_xi) + dot_product(d(:2), free)
            v(2*n + by_xi) = v(2*n + by_xi) + dot_product(d(3:), free)
            call by_law(o, i, s(2), 0.0_wp, x)
            call by_law(o, i, s(4), 0.0_wp, v)
            call by_law(o, i + 1, 0.0_wp, -1.0_wp, v)
         end associate
      end do
   end subroutine orbit_slopes

   !> Derivatives of S_1 .. S_4 of (A6) with respect to xi.
   pure function transfer_by_xi(o, i, t) result(d)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> Number of the flight, 1 to n.
      integer, intent(in) :: i
      !> Time after its start (1/omega).
      real(wp), intent(in) :: t
      real(wp) :: d(4)
      real(wp) :: h, s2, c2, by(2)

      h = eta(o%xi)
      if (t < o%time(i)) then
         s2 = exp(-o%xi*t)*sin(h*t)/h
         c2 = exp(-o%xi*t)*cos(h*t)
      else
         s2 = o%s(2, i)
         c2 = o%c2(i)
      end if
      ! of S_2 and C_2, the frequency being sqrt(1 - xi^2)
      by = [-t*s2 - o%xi*(t*c2 - s2)/h**2, -t*c2 + t*o%xi*s2]
      d = [by(2) + s2 + o%xi*by(1), by(1), -by(1), by(2) - s2 - o%xi*by(1)]
   end function transfer_by_xi

   !> Adds the effect of mu and R on the velocity of the primary mass around an impact, times
   !! weights, to a gradient; the velocities of the free mass are fixed.
   pure subroutine by_law(o, i, after, before, slope)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> Number of the impact, 1 to n + 1.
      integer, intent(in) :: i
      !> Derivatives of the quantity with respect to the velocities just after and just before it.
      real(wp), intent(in) :: after, before
      !> (at least 2n + o%varied) In and out: gradient with respect to u_i, theta_i, parameters.
      real(wp), contiguous, intent(inout) :: slope(:)
      real(wp) :: change
      integer :: j, at

      if (o%varied <= by_clearance) return
      j = merge(1, i, i > o%n)
      change = merge(o%sign, 1.0_wp, i > o%n)*(o%speed(j - 1) - o%speed(j))
      associate (rest => o%restitution(j), mu => o%mu)
         at = 2*o%n + by_mu
         slope(at) = slope(at) + (after*rest - before)*change/(1 + rest)
         at = 2*o%n + merge(by_right, by_left, o%side(j) > 0)
         slope(at) = slope(at) + (1 + mu)*(after + before)*change/(1 + rest)**2
      end associate
   end subroutine by_law

   !> Adds the effect of the velocities of the primary mass just after and just before an impact,
   !! times weights, to a gradient.
   pure subroutine by_velocity(o, i, after, before, slope)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> Number of the impact, 1 to n.
      integer, intent(in) :: i
      !> Derivatives of the quantity with respect to the velocities just after and just before it.
      real(wp), intent(in) :: after, before
      !> (at least 2n + o%varied) In and out: gradient with respect to u_i, theta_i, parameters.
      real(wp), contiguous, intent(inout) :: slope(:)

      call by_speed(o, i - 1, after*o%of_after(1, i) + before*o%of_before(1, i), slope)
      call by_speed(o, i, after*o%of_after(2, i) + before*o%of_before(2, i), slope)
      call by_law(o, i, after, before, slope)
   end subroutine by_velocity

   !> Adds the effect of the position of the primary mass a given time after an impact, times a
   !! weight, to a gradient; the time is fixed.
   pure subroutine by_position(o, i, t, weight, slope)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> Number of the impact, 1 to n.
      integer, intent(in) :: i
      !> Time after it (1/omega).
      real(wp), intent(in) :: t
      !> Derivative of the quantity with respect to that position.
      real(wp), intent(in) :: weight
      !> (at least 2n + o%varied) In and out: gradient with respect to u_i, theta_i, parameters.
      real(wp), contiguous, intent(inout) :: slope(:)
      real(wp) :: h, c1, c2, free(2), sine, cosine, d(4)
      integer :: n

      n = o%n
      h = eta(o%xi)
      c1 = exp(-o%xi*t)*sin(h*t)/h
      c2 = exp(-o%xi*t)*cos(h*t)
      free = weight*[c2 + o%xi*c1, c1]
      sine = weight*o%amplitude*sin(o%r*t + o%theta(i))
      cosine = weight*o%amplitude*cos(o%r*t + o%theta(i))
      slope(i) = slope(i) + free(1)
      call by_velocity(o, i, free(2), 0.0_wp, slope)
      call by_forced(o, i, -free(1), -free(2), slope)
      slope(n + i) = slope(n + i) + cosine
      slope(2*n + by_r) = slope(2*n + by_r) + cosine*t + o%growth*sine
      slope(2*n + by_clearance) = slope(2*n + by_clearance) - sine
      if (o%varied <= by_clearance) return
      d = transfer_by_xi(o, i, t)
      slope(2*n + by_xi) = slope(2*n + by_xi) + o%fading*sine + weight*(d(1)*(o%u(i) &
         - o%forced(i)) + d(2)*(o%after(i) - o%forced_dot(i)))
   end subroutine by_position

   !> Adds the effect of the duration of flight i, times a weight, to a gradient.
   pure subroutine by_time(o, i, weight, slope)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> Number of the flight, 1 to n.
      integer, intent(in) :: i
      !> Derivative of the quantity with respect to that duration.
      real(wp), intent(in) :: weight
      !> (at least 2n + o%varied) In and out: gradient with respect to u_i, theta_i, parameters.
      real(wp), contiguous, intent(inout) :: slope(:)
      real(wp) :: w
      integer :: n, next

      n = o%n
      next = merge(1, i + 1, i == n)
      w = weight*o%per_r
      slope(n + i) = slope(n + i) - w
      slope(n + next) = slope(n + next) + w
      slope(2*n + by_r) = slope(2*n + by_r) - w*o%time(i)
   end subroutine by_time

   !> Adds the effect of the velocity of the free mass in flight i, times a weight, to a gradient.
   pure subroutine by_speed(o, i, weight, slope)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> Number of the flight, 0 to n + 1; those beyond the ends are continued periodically or
      !! mirrored.
      integer, intent(in) :: i
      !> Derivative of the quantity with respect to that velocity.
      real(wp), intent(in) :: weight
      !> (at least 2n + o%varied) In and out: gradient with respect to u_i, theta_i, parameters.
      real(wp), contiguous, intent(inout) :: slope(:)
      real(wp) :: w
      integer :: n, j, next

      n = o%n
      j = merge(n, merge(1, i, i > n), i < 1)
      w = merge(weight, o%sign*weight, j == i)*o%rate(j)
      next = merge(1, j + 1, j == n)
      slope(j) = slope(j) - w
      slope(next) = slope(next) + merge(o%sign, 1.0_wp, j == n)*w
      ! through the duration: the speed is proportional to its inverse
      w = w*o%speed(j)*o%per_r
      slope(n + j) = slope(n + j) + w
      slope(n + next) = slope(n + next) - w
      slope(2*n + by_r) = slope(2*n + by_r) + w*o%time(j)
   end subroutine by_speed

   !> Adds the effect of the forced motion and its velocity at impact i, times weights, to a
   !! gradient.
   pure subroutine by_forced(o, i, weight, weight_dot, slope)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> Number of the impact, 1 to n + 1.
      integer, intent(in) :: i
      !> Derivatives of the quantity with respect to the forced motion and its velocity.
      real(wp), intent(in) :: weight, weight_dot
      !> (at least 2n + o%varied) In and out: gradient with respect to u_i, theta_i, parameters.
      real(wp), contiguous, intent(inout) :: slope(:)
      real(wp) :: cosine, grown
      integer :: n, j

      n = o%n
      j = merge(1, i, i > n)
      cosine = o%forced_dot(i)*o%per_r
      grown = weight*o%forced(i) + weight_dot*o%forced_dot(i)
      slope(n + j) = slope(n + j) + weight*cosine - weight_dot*o%r*o%forced(i)
      slope(2*n + by_r) = slope(2*n + by_r) + o%growth*grown + weight_dot*cosine
      slope(2*n + by_clearance) = slope(2*n + by_clearance) - grown
      if (o%varied > by_clearance) slope(2*n + by_xi) = slope(2*n + by_xi) + o%fading*grown
   end subroutine by_forced

   !> Derivative of the residual with respect to one parameter (2n).
   pure function orbit_by_parameter(o, which) result(slope)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> Place of the parameter: `by_r` .. `by_left`.
      integer, intent(in) :: which
      real(wp) :: slope(2*o%n)
      type(orbit_type) :: all
      real(wp) :: slopes(2*o%n + n_parameters, 2*o%n), residual(2*o%n)

      all = o
      all%varied = n_parameters
      call orbit_slopes(all, slopes, residual)
      slope = slopes(2*o%n + which, :)
   end function orbit_by_parameter

   !> All [P_i], and the derivative of the map of the period, [P] = P_n .. P_1, or of that of the
   !! half period, [Q].
   pure subroutine period_parts(o, parts, p, regular)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> parts(:, :, i): [P_i]; p: the map of the period or half period. Lengths in units of the
      !! clearance; undefined where `regular` is false.
      real(wp), intent(out) :: parts(4, 4, most_impacts), p(4, 4)
      !> False if an impact has no approach speed.
      logical, intent(out) :: regular
      integer :: i

      do i = 1, o%n
         call impact_map(o%xi, o%mu, o%r, o%restitution(i + 1), o%time(i)*o%r, o%c1(i), o%c2(i), &
            [o%forced(i), o%forced(i + 1)], [o%forced_dot(i), o%forced_dot(i + 1)]/o%r, o%u(i), &
            o%after(i), o%speed(i), parts(:, :, i), regular)
         if (.not. regular) return
         if (i == 1) then
            p = parts(:, :, i)
         else
            p = matmul(parts(:, :, i), p)
         end if
      end do
      ! back from the mirror image: x, x' and z' change sign, the phase does not
      p(:3, :) = o%sign*p(:3, :)
   end subroutine period_parts

   !> [P_i] without the part that grows as the approach speed at its end goes to 0: rows 1 to 3 are
   !! base + column times row 4. The mirror at the end of a half period is included.
   pure subroutine split_part(o, i, base, column)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> Number of the flight, 1 to n.
      integer, intent(in) :: i
      !> Rows 1 to 3 without their multiples of row 4, and the factors of row 4 in them.
      real(wp), intent(out) :: base(3, 4), column(3)
      real(wp) :: free(2), sine(2), cosine(2), s13, rest

      associate (s => o%s(:, i), mu => o%mu, r => o%r)
         sine = [o%forced(i), o%forced(i + 1)]
         cosine = [o%forced_dot(i), o%forced_dot(i + 1)]*o%per_r
         free = [o%u(i) - sine(1), o%after(i) - r*cosine(1)]
         rest = o%restitution(i + 1)
         ! S_6 and S_13 of (A6)
         base(1, :) = [s(1), s(2), 0.0_wp, -s(1)*cosine(1) + r*s(2)*sine(1) &
            - (s(3)*free(1) + s(4)*free(2))*o%per_r]
         s13 = -(s(4)*free(1) + (s(2) + 2*o%xi*s(4))*free(2))*o%per_r
         base(2, :) = [s(3), s(4), 0.0_wp, -s(3)*cosine(1) + r*s(4)*sine(1) - s13]
         column(1) = cosine(2) + (s(3)*free(1) + s(4)*free(2))*o%per_r
         column(2) = s13 - r*sine(2)
         ! rows 2 and 3 share the change of x' just before the impact: k_1 .. k_4 of (A5)
         base(3, :) = (1 + rest)/(1 + mu)*base(2, :)
         column(3) = (1 + rest)/(1 + mu)*column(2)
         base(2, :) = (1 - mu*rest)/(1 + mu)*base(2, :)
         column(2) = (1 - mu*rest)/(1 + mu)*column(2)
         base(2, 3) = base(2, 3) + mu*(1 + rest)/(1 + mu)
         base(3, 3) = base(3, 3) + (mu - rest)/(1 + mu)
      end associate
      if (i < o%n) return
      base = o%sign*base
      column = o%sign*column
   end subroutine split_part

end module vi_orbit
