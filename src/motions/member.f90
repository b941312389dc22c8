!> A member of a family of periodic motions, with everything at its impacts and flights.
!!
!! Its unknowns are u_i = x_i/d and theta_i = alpha_i + tau, its parameters r, log(D), xi, mu, R1
!! and R2 with D = dK/F0. A motion that is its own mirror image half a period later is described by
!! its first half.
module vi_member
   use vi_kinds, only: pi, wp
   use vi_oscillator, only: eta, gain, left, oscillator_type, right
   implicit none (type, external)
   private

   public :: oscillator_of, oscillator_parameters, set_orbit, span_of

   !> Largest number of impacts of an orbit.
   integer, parameter, public :: most_impacts = 24
   !> Places of the parameters.
   integer, parameter, public :: by_r = 1, by_clearance = 2, by_xi = 3, by_mu = 4, by_right = 5, &
      by_left = 6
   integer, parameter, public :: n_parameters = 6

   !> The data that the members of a family of motions have in common.
   type, public :: family_type
      !> Sides of the impacts: all of them, or the first half of a symmetric motion.
      integer, allocatable :: sides(:)
      !> Load cycles k of the whole period.
      integer :: cycles = 1
      !> Whether the given impacts are followed by their mirror images half a period later; k is
      !! then odd.
      logical :: mirror = .false.
   end type family_type

   !> One member: everything at its impacts and flights. Entries 0 and n+1 continue the list.
   type, public :: orbit_type
      integer :: n = 0
      !> -1 if the impacts repeat mirrored, else 1; and the phase after which they repeat.
      real(wp) :: sign = 1, span = 0
      real(wp) :: xi = 0, mu = 0, r = 1, amplitude = 0
      !> Derivatives of log(A) with respect to r and xi, and 1/r.
      real(wp) :: growth = 0, fading = 0, per_r = 1
      !> Number of parameters in gradients: r and log(D), or all six.
      integer :: varied = 2
      real(wp), dimension(0:most_impacts + 1) :: u, theta, z, restitution
      !> Forced motion A sin(theta) and its velocity A r cos(theta).
      real(wp), dimension(0:most_impacts + 1) :: forced, forced_dot
      !> Of flight i: duration and its inverse, velocity of the free mass, C_1, C_2 of (9), (10),
      !! S_1..S_4 of (A6).
      real(wp), dimension(0:most_impacts + 1) :: time, rate, speed, c1, c2
      real(wp) :: s(4, most_impacts)
      !> Velocity of the primary mass before and after impact i.
      real(wp), dimension(0:most_impacts + 1) :: before, after
      !> Derivatives of these velocities with respect to those of the free mass before and after the
      !! impact.
      real(wp), dimension(2, most_impacts) :: of_before, of_after
      integer, dimension(0:most_impacts + 1) :: side
   end type orbit_type

contains

   !> The parameters of an oscillator at a point.
   pure function oscillator_parameters(osc, r, clearance) result(c)
      !> The oscillator.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio, and D = dK/F0.
      real(wp), intent(in) :: r, clearance
      real(wp) :: c(n_parameters)

      c([by_r, by_clearance, by_xi, by_mu, by_right, by_left]) = [r, log(clearance), osc%xi, &
         osc%mu, osc%restitution([right, left])]
   end function oscillator_parameters

   !> The oscillator with given parameters.
   pure type(oscillator_type) function oscillator_of(c) result(osc)
      !> (6) r and D, or log(D), which are not read, xi, mu, R1, R2
      real(wp), intent(in) :: c(:)

      osc = oscillator_type(c(by_xi), c(by_mu), c([by_right, by_left]))
   end function oscillator_of

   !> Load phase after which the impacts repeat, or are mirrored.
   pure real(wp) function span_of(family)
      !> Only `mirror` and `cycles` are read.
      type(family_type), intent(in) :: family

      span_of = merge(pi, 2*pi, family%mirror)*family%cycles
   end function span_of

   !> Everything at the impacts and flights of unknowns (u_i, theta_i) at parameters c.
   pure subroutine set_orbit(family, unknowns, c, o, restitution)
      !> Sides of the impacts, load cycles, and whether only the first half is given.
      type(family_type), intent(in) :: family
      !> (2n) u_i = x_i/d, theta_i = alpha_i + tau (rad).
      real(wp), intent(in) :: unknowns(:)
      !> (6) r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> Out: everything at impacts and flights; lengths in units of the clearance d.
      type(orbit_type), intent(inout) :: o
      !> (n) Coefficient of restitution of each impact, if it is not that of its wall.
      real(wp), intent(in), optional :: restitution(:)
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
      o%fading = -4*o%xi*(o%r*h)**2
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
      if (present(restitution)) o%restitution(1:n + 1) = [restitution, restitution(1)]
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

end module vi_member
