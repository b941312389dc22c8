!> A periodic motion as a root of equations in its positions, phases and parameters.
!!
!! The unknowns are u_i = x_i/d and theta_i = alpha_i + tau; the parameters are r, log(D), xi, mu,
!! R1 and R2 with D = dK/F0. The equations say that every flight ends where and as fast as the next
!! impact starts: (26) and (30) with A known. A motion that is its own mirror image half a period
!! later is described by its first half; then a fold and the pitchfork, where the symmetry is lost,
!! are two different multipliers (+1 and -1) of the half-period map.
module vi_orbit
   use vi_impact, only: primary_velocities
   use vi_impact_map, only: impact_map
   use vi_kinds, only: wp
   use vi_oscillator, only: eta, gain
   implicit none (type, external)
   private

   public :: set_orbit, orbit_residual, orbit_matrix, orbit_by_parameter, period_map

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
      real(wp), dimension(0:most_impacts + 1) :: u, theta, z, restitution
      !> Forced motion A sin(theta) and its velocity A r cos(theta).
      real(wp), dimension(0:most_impacts + 1) :: forced, forced_dot
      !> Of flight i: duration, velocity of the free mass, C_1, C_2 of (9), (10), S_1..S_4 of (A6).
      real(wp), dimension(0:most_impacts + 1) :: time, speed, c1, c2
      real(wp) :: s(4, most_impacts)
      !> Velocity of the primary mass around impact i.
      real(wp), dimension(0:most_impacts + 1) :: before, after
      integer, dimension(0:most_impacts + 1) :: side
   end type orbit_type

contains

   !> Everything at the impacts and flights of unknowns (u_i, theta_i) at parameters c.
   pure subroutine set_orbit(family, unknowns, c, o)
      type(family_type), intent(in) :: family
      !> (2n)
      real(wp), intent(in) :: unknowns(:)
      !> (6) r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      type(orbit_type), intent(inout) :: o
      real(wp) :: shrink, h
      integer :: n, i

      n = size(family%sides)
      o%n = n
      o%sign = merge(-1.0_wp, 1.0_wp, family%mirror)
      o%span = merge(pi, 2*pi, family%mirror)*family%cycles
      o%r = c(by_r)
      o%xi = c(by_xi)
      o%mu = c(by_mu)
      o%amplitude = gain(o%xi, o%r)*exp(-c(by_clearance))
      h = eta(o%xi)
      o%u(1:n) = unknowns(:n)
      o%theta(1:n) = unknowns(n + 1:)
      o%side(1:n) = family%sides
      o%restitution(1:n) = merge(c(by_right), c(by_left), family%sides > 0)
      o%forced(1:n) = o%amplitude*sin(o%theta(1:n))
      o%forced_dot(1:n) = o%amplitude*o%r*cos(o%theta(1:n))
      o%theta(n + 1) = o%theta(1) + o%span
      o%u(n + 1) = o%sign*o%u(1)
      o%side(n + 1) = nint(o%sign)*o%side(1)
      o%restitution(n + 1) = merge(c(by_right), c(by_left), o%side(n + 1) > 0)
      o%forced(n + 1) = o%sign*o%forced(1)
      o%forced_dot(n + 1) = o%sign*o%forced_dot(1)
      o%z(1:n + 1) = o%u(1:n + 1) + 0.5_wp*o%side(1:n + 1)
      do i = 1, n
         o%time(i) = (o%theta(i + 1) - o%theta(i))/o%r
         o%speed(i) = (o%z(i + 1) - o%z(i))/o%time(i)                                       ! (16)
         shrink = exp(-o%xi*o%time(i))
         o%c1(i) = shrink*sin(h*o%time(i))                                                  ! (9)
         o%c2(i) = shrink*cos(h*o%time(i))                                                  ! (10)
         o%s(:, i) = [o%c2(i) + o%xi*o%c1(i)/h, o%c1(i)/h, -o%c1(i)/h, &
            o%c2(i) - o%xi*o%c1(i)/h]                                                       ! (A6)
      end do
      o%speed(0) = o%sign*o%speed(n)
      call primary_velocities(o%mu, o%restitution(1:n), o%speed(0:n - 1), o%speed(1:n), &
         o%before(1:n), o%after(1:n))
      o%before(n + 1) = o%sign*o%before(1)
   end subroutine set_orbit

   !> Position and velocity at the end of each flight less those just before the next impact (2n).
   pure function orbit_residual(o) result(residual)
      type(orbit_type), intent(in) :: o
      real(wp) :: residual(2*o%n)
      real(wp) :: free(2)
      integer :: i

      do i = 1, o%n
         free = [o%u(i) - o%forced(i), o%after(i) - o%forced_dot(i)]
         residual(i) = o%s(1, i)*free(1) + o%s(2, i)*free(2) + o%forced(i + 1) - o%u(i + 1)
         residual(o%n + i) = o%s(3, i)*free(1) + o%s(4, i)*free(2) + o%forced_dot(i + 1) &
            - o%before(i + 1)
      end do
   end function orbit_residual

   !> Derivative of the residual by the unknowns (2n, 2n).
   pure subroutine orbit_matrix(o, matrix)
      type(orbit_type), intent(in) :: o
      real(wp), intent(out) :: matrix(:, :)
      real(wp) :: speed(2*o%n, 0:o%n), before(2*o%n, o%n + 1), after(2*o%n, o%n)
      real(wp) :: free(2), drift(2), turned
      integer :: n, i, next

      n = o%n
      speed = 0
      do i = 1, n
         next = merge(1, i + 1, i == n)
         turned = merge(o%sign, 1.0_wp, i == n)
         speed(next, i) = speed(next, i) + turned/o%time(i)
         speed(i, i) = speed(i, i) - 1/o%time(i)
         speed(n + next, i) = speed(n + next, i) - o%speed(i)/(o%time(i)*o%r)
         speed(n + i, i) = speed(n + i, i) + o%speed(i)/(o%time(i)*o%r)
      end do
      speed(:, 0) = o%sign*speed(:, n)
      do i = 1, n
         call primary_velocities(o%mu, o%restitution(i), speed(:, i - 1), speed(:, i), &
            before(:, i), after(:, i))
      end do
      before(:, n + 1) = o%sign*before(:, 1)
      do i = 1, n
         next = merge(1, i + 1, i == n)
         turned = merge(o%sign, 1.0_wp, i == n)
         call free_end(o, i, free, drift)
         associate (s => o%s(:, i), x => matrix(i, :), v => matrix(n + i, :))
            x = s(2)*after(:, i)
            v = s(4)*after(:, i) - before(:, i + 1)
            x(i) = x(i) + s(1)
            v(i) = v(i) + s(3)
            x(next) = x(next) - turned
            ! the phases: through the duration, and through the forced motion at both ends
            x(n + i) = x(n + i) - drift(1)/o%r - s(1)*o%forced_dot(i)/o%r + s(2)*o%r*o%forced(i)
            v(n + i) = v(n + i) - drift(2)/o%r - s(3)*o%forced_dot(i)/o%r + s(4)*o%r*o%forced(i)
            x(n + next) = x(n + next) + drift(1)/o%r + o%forced_dot(i + 1)/o%r
            v(n + next) = v(n + next) + drift(2)/o%r - o%r*o%forced(i + 1)
         end associate
      end do
   end subroutine orbit_matrix

   !> The free part of the motion at the end of a flight, and its change with the duration.
   pure subroutine free_end(o, i, free, drift)
      type(orbit_type), intent(in) :: o
      integer, intent(in) :: i
      real(wp), intent(out) :: free(2), drift(2)

      associate (x => o%u(i) - o%forced(i), v => o%after(i) - o%forced_dot(i))
         free = [o%s(1, i)*x + o%s(2, i)*v, o%s(3, i)*x + o%s(4, i)*v]
      end associate
      drift = [free(2), -2*o%xi*free(2) - free(1)]
   end subroutine free_end

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
      real(wp) :: shifted(n_parameters), relative(2)

      select case (which)
      case (by_r)
         associate (a => (1 - o%r)*(1 + o%r), b => 2*o%xi*o%r)
            ! of log A and of log(A r)
            relative(1) = (2*o%r*a - 2*o%xi*b)/(a**2 + b**2)
            relative(2) = relative(1) + 1/o%r
         end associate
         slope = change(o, relative, 1/o%r)
      case (by_clearance)
         slope = change(o, [-1.0_wp, -1.0_wp], 0.0_wp)
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

   !> Change of the residual when the forced motion grows and the flights get shorter, relatively.
   pure function change(o, growth, faster) result(slope)
      type(orbit_type), intent(in) :: o
      !> Of A and of A r.
      real(wp), intent(in) :: growth(2)
      !> All flights take less time by this share, so all velocities of the free mass are greater.
      real(wp), intent(in) :: faster
      real(wp) :: slope(2*o%n)
      real(wp) :: free(2), drift(2), start(2)
      integer :: i, n

      n = o%n
      do i = 1, n
         call free_end(o, i, free, drift)
         start = [-growth(1)*o%forced(i), faster*o%after(i) - growth(2)*o%forced_dot(i)]
         slope(i) = o%s(1, i)*start(1) + o%s(2, i)*start(2) - faster*o%time(i)*drift(1) &
            + growth(1)*o%forced(i + 1)
         slope(n + i) = o%s(3, i)*start(1) + o%s(4, i)*start(2) - faster*o%time(i)*drift(2) &
            + growth(2)*o%forced_dot(i + 1) - faster*o%before(i + 1)
      end do
   end function change

   !> Derivative of the map of the period, [P] = P_n .. P_1, or of the half period Q.
   pure subroutine period_map(o, p, regular)
      type(orbit_type), intent(in) :: o
      real(wp), intent(out) :: p(4, 4)
      !> False if an impact has no approach speed.
      logical, intent(out) :: regular
      real(wp) :: part(4, 4)
      integer :: i

      do i = 1, o%n
         call impact_map(o%xi, o%mu, o%r, o%restitution(i + 1), o%time(i)*o%r, o%c1(i), o%c2(i), &
            o%forced(i:i + 1), o%forced_dot(i:i + 1)/o%r, o%u(i), o%after(i), o%speed(i), part, &
            regular)
         if (.not. regular) return
         if (i == 1) then
            p = part
         else
            p = matmul(part, p)
         end if
      end do
      ! back from the mirror image: x, x' and z' change sign, the phase does not
      p(:3, :) = o%sign*p(:3, :)
   end subroutine period_map

end module vi_orbit
