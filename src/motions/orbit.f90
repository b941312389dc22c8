!> A periodic motion as a root of equations in its positions, phases and parameters.
!!
!! The unknowns are u_i = x_i/d and theta_i = alpha_i + tau; the parameters are r, log(D), xi, mu,
!! R1 and R2 with D = dK/F0. The equations say that every flight ends where and as fast as the next
!! impact starts: (26) and (30) with A known. A motion that is its own mirror image half a period
!! later is described by its first half; then a fold and the pitchfork, where the symmetry is lost,
!! are two different multipliers (+1 and -1) of the half-period map.
module vi_orbit
   use vi_impact_map, only: impact_map
   use vi_kinds, only: wp
   use vi_oscillator, only: eta, gain
   implicit none (type, external)
   private

   public :: set_orbit, orbit_residual, orbit_slopes, orbit_matrix, orbit_by_parameter, period_map
   public :: by_forced, by_speed, by_time, period_parts, span_of

   !> Most impacts of an orbit.
   integer, parameter, public :: most_impacts = 24
   !> Places of the parameters.
   integer, parameter, public :: by_r = 1, by_clearance = 2, by_xi = 3, by_mu = 4, by_right = 5, &
      by_left = 6
   integer, parameter, public :: n_parameters = 6

   real(wp), parameter :: pi = acos(-1.0_wp)

   !> What the members of a family of motions have in common.
   type, public :: family_type
      !> Sides of the impacts: all of them, or the first half of a symmetric motion.
      integer, allocatable :: sides(:)
      !> Load cycles k of the whole period.
      integer :: cycles = 1
      !> The impacts given are followed by their mirror images half a period later; k is odd then.
      logical :: mirror = .false.
   end type family_type

   !> One member: everything at its impacts and flights. Entries 0 and n+1 continue the list.
   type, public :: orbit_type
      integer :: n = 0
      !> -1 if the impacts repeat mirrored, and the phase after which they do.
      real(wp) :: sign = 1, span = 0
      real(wp) :: xi = 0, mu = 0, r = 1, amplitude = 0
      !> Derivative of log(A) by r, and 1/r.
      real(wp) :: growth = 0, per_r = 1
      real(wp), dimension(0:most_impacts + 1) :: u, theta, z, restitution
      !> Forced motion A sin(theta) and its velocity A r cos(theta).
      real(wp), dimension(0:most_impacts + 1) :: forced, forced_dot
      !> Of flight i: duration and its inverse, velocity of the free mass, C_1, C_2 of (9), (10), S_1..S_4 of (A6).
      real(wp), dimension(0:most_impacts + 1) :: time, rate, speed, c1, c2
      real(wp) :: s(4, most_impacts)
      !> Velocity of the primary mass around impact i.
      real(wp), dimension(0:most_impacts + 1) :: before, after
      !> Their parts: derivatives by the velocities of the free mass before and after the impact.
      real(wp), dimension(2, most_impacts) :: of_before, of_after
      integer, dimension(0:most_impacts + 1) :: side
   end type orbit_type

contains

   !> Load phase after which the impacts repeat, or are mirrored.
   pure real(wp) function span_of(family)
      type(family_type), intent(in) :: family

      span_of = merge(pi, 2*pi, family%mirror)*family%cycles
   end function span_of

   !> Everything at the impacts and flights of unknowns (u_i, theta_i) at parameters c.
   pure subroutine set_orbit(family, unknowns, c, o)
      type(family_type), intent(in) :: family
      !> (2n)
      real(wp), intent(in) :: unknowns(:)
      !> (6) r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      type(orbit_type), intent(inout) :: o
      real(wp) :: shrink, h, c1, c2
      integer :: n, i

      n = size(family%sides)
      o%n = n
      o%sign = merge(-1.0_wp, 1.0_wp, family%mirror)
      o%span = span_of(family)
      o%r = c(by_r)
      o%per_r = 1/o%r
      o%xi = c(by_xi)
      o%mu = c(by_mu)
      h = gain(o%xi, o%r)
      o%amplitude = h*exp(-c(by_clearance))
      o%growth = 2*o%r*((1 - o%r)*(1 + o%r) - 2*o%xi**2)*h**2
      h = eta(o%xi)
      do i = 1, n
         o%u(i) = unknowns(i)
         o%theta(i) = unknowns(n + i)
         o%side(i) = family%sides(i)
         o%forced(i) = o%amplitude*sin(o%theta(i))
         o%forced_dot(i) = o%amplitude*o%r*cos(o%theta(i))
      end do
      o%theta(n + 1) = o%theta(1) + o%span
      o%u(n + 1) = o%sign*o%u(1)
      o%side(n + 1) = nint(o%sign)*o%side(1)
      o%forced(n + 1) = o%sign*o%forced(1)
      o%forced_dot(n + 1) = o%sign*o%forced_dot(1)
      do i = 1, n + 1
         o%restitution(i) = merge(c(by_right), c(by_left), o%side(i) > 0)
         o%z(i) = o%u(i) + 0.5_wp*o%side(i)
      end do
      do i = 1, n
         o%time(i) = (o%theta(i + 1) - o%theta(i))/o%r
         o%rate(i) = 1/o%time(i)
         o%speed(i) = (o%z(i + 1) - o%z(i))/o%time(i)                                       ! (16)
         shrink = exp(-o%xi*o%time(i))
         c1 = shrink*sin(h*o%time(i))                                                       ! (9)
         c2 = shrink*cos(h*o%time(i))                                                       ! (10)
         o%c1(i) = c1
         o%c2(i) = c2
         o%s(:, i) = [c2 + o%xi*c1/h, c1/h, -c1/h, c2 - o%xi*c1/h]                          ! (A6)
      end do
      o%speed(0) = o%sign*o%speed(n)
      do i = 1, n
         associate (r => o%restitution(i))
            o%of_after(:, i) = [(1 + o%mu)*r, 1 - o%mu*r]/(1 + r)                           ! (13)
            o%of_before(:, i) = [r - o%mu, 1 + o%mu]/(1 + r)                                ! (28)
         end associate
         o%after(i) = o%of_after(1, i)*o%speed(i - 1) + o%of_after(2, i)*o%speed(i)
         o%before(i) = o%of_before(1, i)*o%speed(i - 1) + o%of_before(2, i)*o%speed(i)
      end do
      o%before(n + 1) = o%sign*o%before(1)
   end subroutine set_orbit

   !> Position and velocity at the end of each flight less those just before the next impact (2n).
   pure function orbit_residual(o) result(residual)
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
      type(orbit_type), intent(in) :: o
      integer, intent(in) :: i
      real(wp) :: free(2)

      associate (x => o%u(i) - o%forced(i), v => o%after(i) - o%forced_dot(i), s => o%s(:, i))
         free = [s(1)*x + s(2)*v, s(3)*x + s(4)*v]
      end associate
   end function free_end

   !> The residuals again, and the gradient of each: by u_i, theta_i, r and log(D).
   pure subroutine orbit_slopes(o, slopes, residual)
      type(orbit_type), intent(in) :: o
      !> (at least 2n + 2, 2n)
      real(wp), contiguous, intent(out) :: slopes(:, :)
      !> (2n)
      real(wp), intent(out) :: residual(:)
      real(wp) :: free(2)
      integer :: n, i, next

      n = o%n
      do i = 1, n
         next = merge(1, i + 1, i == n)
         free = free_end(o, i)
         residual(i) = free(1) + o%forced(i + 1) - o%u(i + 1)
         residual(n + i) = free(2) + o%forced_dot(i + 1) - o%before(i + 1)
         slopes(:2*n + 2, i) = 0
         slopes(:2*n + 2, n + i) = 0
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
         end associate
      end do
   end subroutine orbit_slopes

   !> Adds to a gradient what changes through the duration of flight i, with a weight.
   pure subroutine by_time(o, i, weight, slope)
      type(orbit_type), intent(in) :: o
      integer, intent(in) :: i
      real(wp), intent(in) :: weight
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

   !> The same through the velocity of the free mass in flight i, 0 to n + 1.
   pure subroutine by_speed(o, i, weight, slope)
      type(orbit_type), intent(in) :: o
      integer, intent(in) :: i
      real(wp), intent(in) :: weight
      real(wp), contiguous, intent(inout) :: slope(:)
      real(wp) :: w
      integer :: n, j, next

      n = o%n
      j = merge(n, merge(1, i, i > n), i < 1)
      w = merge(weight, o%sign*weight, j == i)*o%rate(j)
      next = merge(1, j + 1, j == n)
      slope(j) = slope(j) - w
      slope(next) = slope(next) + merge(o%sign, 1.0_wp, j == n)*w
      ! through the duration: speed goes with its inverse
      w = w*o%speed(j)*o%per_r
      slope(n + j) = slope(n + j) + w
      slope(n + next) = slope(n + next) - w
      slope(2*n + by_r) = slope(2*n + by_r) + w*o%time(j)
   end subroutine by_speed

   !> The same through the forced motion and its velocity at impact i, 1 to n + 1.
   pure subroutine by_forced(o, i, weight, weight_dot, slope)
      type(orbit_type), intent(in) :: o
      integer, intent(in) :: i
      real(wp), intent(in) :: weight, weight_dot
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
   end subroutine by_forced

   !> Derivative of the residual by the unknowns (2n, 2n).
   pure subroutine orbit_matrix(o, matrix)
      type(orbit_type), intent(in) :: o
      real(wp), intent(out) :: matrix(:, :)
      real(wp) :: slopes(2*o%n + 2, 2*o%n), residual(2*o%n)

      call orbit_slopes(o, slopes, residual)
      matrix = transpose(slopes(:2*o%n, :))
   end subroutine orbit_matrix

   !> Derivative of the residual by one parameter (2n).
   pure function orbit_by_parameter(family, unknowns, c, o, which) result(slope)
      type(family_type), intent(in) :: family
      real(wp), intent(in) :: unknowns(:), c(:)
      !> The orbit of these unknowns and parameters.
      type(orbit_type), intent(in) :: o
      integer, intent(in) :: which
      real(wp) :: slope(size(unknowns))
      real(wp), parameter :: h = 1.0e-5_wp
      type(orbit_type) :: moved
      real(wp) :: shifted(n_parameters), slopes(2*o%n + 2, 2*o%n), residual(2*o%n)

      select case (which)
      case (by_r, by_clearance)
         call orbit_slopes(o, slopes, residual)
         slope = slopes(2*o%n + which, :)
      case default
         shifted = c
         shifted(which) = c(which) + h
         call set_orbit(family, unknowns, shifted, moved)
         slope = orbit_residual(moved)
         shifted(which) = c(which) - h
         call set_orbit(family, unknowns, shifted, moved)
         slope = (slope - orbit_residual(moved))/(2*h)
      end select
   end function orbit_by_parameter

   !> Derivative of the map of the period, [P] = P_n .. P_1, or of the half period Q.
   pure subroutine period_map(o, p, regular)
      type(orbit_type), intent(in) :: o
      real(wp), intent(out) :: p(4, 4)
      !> False if an impact has no approach speed.
      logical, intent(out) :: regular
      real(wp) :: parts(4, 4, most_impacts)

      call period_parts(o, parts, p, regular)
   end subroutine period_map

   !> The same with all [P_i].
   pure subroutine period_parts(o, parts, p, regular)
      type(orbit_type), intent(in) :: o
      real(wp), intent(out) :: parts(4, 4, most_impacts), p(4, 4)
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

end module vi_orbit
