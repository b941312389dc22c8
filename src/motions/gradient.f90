!> The derivatives of an exact motion with respect to its parameters.
!!
!! The equations of the motion, E(u, theta; c) = 0, define u and theta as functions of the
!! parameters c: du/dc = -(dE/du)^-1 dE/dc. Every other quantity is an explicit function of all of
!! these. A multiplier is a simple eigenvalue of [P]: its derivative is y.[P]'.x/(y.x), where x and
!! y are the right and the left eigenvector.
module vi_gradient
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_exact, only: setting_type
   use vi_extrema, only: relative_extrema
   use vi_flight, only: flight_type
   use vi_kinds, only: wp
   use vi_lapack, only: solve
   use vi_lapack_routines, only: geev
   use vi_orbit, only: by_clearance, by_left, by_position, by_r, by_right, by_speed, by_velocity, &
      by_xi, family_type, flight_at, most_impacts, n_parameters, orbit_slopes, orbit_type, &
      oscillator_parameters, period_parts, set_orbit
   use vi_oscillation, only: derivatives
   use vi_oscillator, only: gain, lag
   use vi_period_slope, only: add_period_slope
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: motion_gradient, quantities_of

   !> Number of parameters: r, D, xi, mu, R1, R2, R on both walls, and the load amplitude f.
   integer, parameter, public :: gradient_parameters = n_parameters + 2
   !> Groups of quantities with one entry an impact: phase, x, z, x' before and after, z' before and
   !! after, approach speed, and the least gaps to the right and to the left wall in the flight
   !! after it.
   integer, parameter :: of_impact = 10
   integer, parameter :: by_both = n_parameters + 1, by_load = n_parameters + 2
   !> Single quantities: A, tau, load phase, x_max, x_min, attenuation, rms of x, amplitude and
   !! phase of its fundamental, 1 - |lambda_1|.
   integer, parameter :: of_motion = 10
   !> Real and imaginary parts of the multipliers.
   integer, parameter :: of_multipliers = 8

   !> A Newton step from an exact motion is no longer than this.
   real(wp), parameter :: exactness = 1.0e-8_wp
   !> Condition number of the equations from which a motion counts as one at a fold.
   real(wp), parameter :: singular = 1.0e10_wp
   !> Approach speeds, over the largest velocity, and gaps, over the clearance, that count as zero.
   real(wp), parameter :: touching = 1.0e-9_wp
   !> Extremes that differ by no more than this share of their size count as equal.
   real(wp), parameter :: alike = 1.0e-10_wp
   !> Derivatives with respect to a parameter that differ by no more than this share of their size,
   !! and this one of the terms in them, count as equal. Each parameter is judged alone: derivatives
   !! with respect to the restitution of a wall may be small compared with others, and with the
   !! number itself, and still differ.
   real(wp), parameter :: same = 1.0e-6_wp, rounding = 1.0e-10_wp
   !> Cosine of the angle between the right and the left eigenvector below which a multiplier counts
   !! as a double one.
   real(wp), parameter :: defect = 1.0e-5_wp

   !> A motion and the derivatives of its unknowns.
   type :: solved_type
      type(orbit_type) :: o
      real(wp) :: clearance = 1, load = 1
      !> (2n, 6) Derivatives of u_i, theta_i with respect to r, log(D), xi, mu, R1, R2.
      real(wp), allocatable :: by(:, :)
   end type solved_type

   !> A number with its derivatives, and the sums of the absolute terms in these, of which their
   !! rounding errors are a share.
   type :: quantity_type
      real(wp) :: value = 0, by(gradient_parameters) = 0
      integer :: status = stat%not_computed
      real(wp) :: terms(gradient_parameters) = 0
   end type quantity_type

contains

   !> Number of quantities of a motion with n impacts.
   pure integer function quantities_of(n)
      !> Number of impacts.
      integer, intent(in) :: n

      quantities_of = of_impact*n + of_motion + of_multipliers
   end function quantities_of

   !> All quantities of a motion with their derivatives.
   pure subroutine motion_gradient(setting, x, theta, multipliers, values, slopes, codes, status)
      !> The oscillator, r, load, clearance, pattern and restitution of each impact.
      type(setting_type), intent(in) :: setting
      !> (n) Positions x_i (F0/K), and theta_i = alpha_i + tau (rad).
      real(wp), intent(in) :: x(:), theta(:)
      !> (4) The multipliers, in the order in which their derivatives are wanted.
      complex(wp), intent(in) :: multipliers(:)
      !> (quantities_of(n)) Values: the groups of `of_impact`, then those of `of_motion`, then the
      !! real parts and the imaginary parts of the multipliers. NaN if there is no such number.
      real(wp), intent(out) :: values(:)
      !> (8, quantities_of(n)) Derivatives with respect to r, D, xi, mu, R1, R2, both R alike, f;
      !! NaN where there are none.
      real(wp), intent(out) :: slopes(:, :)
      !> (quantities_of(n)) `stat%ok`, or why a number has no derivatives.
      integer, intent(out) :: codes(:)
      !> `stat%ok`, or why the whole motion has no derivatives.
      integer, intent(out) :: status
      type(solved_type) :: solved
      type(quantity_type) :: quantities(size(values))
      integer :: i, n

      n = size(x)
      call differentiate(setting, x, theta, solved, status)
      if (status == stat%ok) call of_impacts(solved, quantities(:of_impact*n), status)
      if (status == stat%ok) then
         i = of_impact*n
         call of_response(setting, solved, quantities(i + 1:i + 6))
         call of_history(solved, quantities(i + 7:i + 9))
         quantities(i + 9)%value = quantities(i + 9)%value - lag(setting%osc%xi, setting%r)
         quantities(i + 9)%by = quantities(i + 9)%by + quantities(i + 2)%by - quantities(i + 3)%by
         call of_stability(solved, multipliers, quantities(i + 10), quantities(i + of_motion + 1:))
      end if
      do i = 1, size(values)
         values(i) = quantities(i)%value
         slopes(:, i) = quantities(i)%by
         codes(i) = quantities(i)%status
         if (codes(i) /= stat%ok .and. codes(i) /= stat%not_smooth) slopes(:, i) = nan()
      end do
   end subroutine motion_gradient

   !> The orbit of an exact motion and the derivatives of its unknowns.
   pure subroutine differentiate(setting, x, theta, solved, status)
      !> As in `motion_gradient`.
      type(setting_type), intent(in) :: setting
      !> As in `motion_gradient`.
      real(wp), intent(in) :: x(:), theta(:)
      !> The orbit, after one more Newton step, and the derivatives.
      type(solved_type), intent(out) :: solved
      !> `stat%ok`, `stat%not_exact` or `stat%fold`.
      integer, intent(out) :: status
      real(wp), dimension(2*size(x), 2*size(x)) :: inverse, factors
      real(wp), dimension(2*size(x)) :: unknowns, residual, step
      real(wp) :: slopes(2*size(x) + n_parameters, 2*size(x)), c(n_parameters)
      integer :: i, n, pass, failed

      n = size(x)
      solved%clearance = setting%clearance
      solved%load = setting%load
      c = oscillator_parameters(setting%osc, setting%r, setting%clearance/setting%load)
      unknowns = [x/setting%clearance, theta]
      solved%o%varied = n_parameters
      do pass = 1, 2
         call set_orbit(family_type(setting%pattern%sides, setting%pattern%cycles), unknowns, c, &
            solved%o, setting%restitution)
         call orbit_slopes(solved%o, slopes, residual)
         status = stat%fold
         do i = 1, 2*n
            factors = transpose(slopes(:2*n, :))
            inverse(:, i) = 0
            inverse(i, i) = 1
            call solve(factors, inverse(:, i), failed)
            if (failed /= stat%ok) return
         end do
         if (.not. norm2(slopes(:2*n, :))*norm2(inverse) < singular) return
         status = stat%not_exact
         step = matmul(inverse, residual)
         if (.not. max(maxval(abs(step(:n)))/max(1.0_wp, maxval(abs(unknowns(:n)))), &
            maxval(abs(step(n + 1:)))) < exactness) return
         if (pass == 1) unknowns = unknowns - step
      end do
      allocate (solved%by(2*n, n_parameters))
      solved%by = -matmul(inverse, transpose(slopes(2*n + 1:, :)))
      status = stat%ok
   end subroutine differentiate

   !> A quantity from its value and its explicit gradient, lengths in units of the clearance.
   pure function quantity(solved, value, slope, is_length)
      !> The motion.
      type(solved_type), intent(in) :: solved
      !> Value, and gradient with respect to u_i, theta_i and the six parameters (2n + 6).
      real(wp), intent(in) :: value, slope(:)
      !> Whether the quantity is a length or a velocity, not a pure number.
      logical, intent(in) :: is_length
      type(quantity_type) :: quantity
      real(wp) :: by(n_parameters), unit, log_clearance
      integer :: m

      m = 2*solved%o%n
      by = slope(m + 1:m + n_parameters) + matmul(slope(:m), solved%by)
      unit = merge(solved%clearance, 1.0_wp, is_length)
      quantity%terms(:n_parameters) = unit*(abs(slope(m + 1:m + n_parameters)) &
         + matmul(abs(slope(:m)), abs(solved%by)))
      quantity%terms(by_both) = quantity%terms(by_right) + quantity%terms(by_left)
      quantity%terms(by_load) = quantity%terms(by_clearance)/solved%load
      quantity%terms(by_clearance) = quantity%terms(by_clearance)/solved%clearance
      log_clearance = unit*by(by_clearance)
      quantity%value = unit*value
      quantity%by(:n_parameters) = unit*by
      quantity%by(by_clearance) = log_clearance/solved%clearance
      if (is_length) quantity%by(by_clearance) = quantity%by(by_clearance) + value
      quantity%by(by_both) = quantity%by(by_right) + quantity%by(by_left)
      ! lengths over f depend on D/f alone
      quantity%by(by_load) = -log_clearance/solved%load
      quantity%status = stat%ok
   end function quantity

   !> The quantities with one entry an impact.
   pure subroutine of_impacts(solved, quantities, status)
      !> The motion.
      type(solved_type), intent(in) :: solved
      !> (10 n) By group, as `of_impact` lists them.
      type(quantity_type), intent(out) :: quantities(:)
      !> `stat%ok`, or `stat%graze` where an impact has no approach speed, or a gap closes in a
      !! flight.
      integer, intent(out) :: status
      real(wp) :: slope(2*most_impacts + n_parameters), lowest, highest, lowest_at, highest_at, &
         fastest
      logical :: complete
      integer :: i, n, m

      status = stat%ok
      n = solved%o%n
      m = 2*n + n_parameters
      associate (o => solved%o)
         fastest = max(maxval(abs(o%speed(1:n))), maxval(abs(o%before(1:n))), &
            maxval(abs(o%after(1:n))))
         do i = 1, n
            slope = 0
            slope(n + i) = 1
            slope(n + 1) = slope(n + 1) - 1
            quantities(i) = quantity(solved, o%theta(i) - o%theta(1), slope(:m), .false.)
            slope = 0
            slope(i) = 1
            quantities(n + i) = quantity(solved, o%u(i), slope(:m), .true.)
            quantities(2*n + i) = quantity(solved, o%z(i), slope(:m), .true.)
            slope = 0
            call by_velocity(o, i, 0.0_wp, 1.0_wp, slope)
            quantities(3*n + i) = quantity(solved, o%before(i), slope(:m), .true.)
            slope = 0
            call by_velocity(o, i, 1.0_wp, 0.0_wp, slope)
            quantities(4*n + i) = quantity(solved, o%after(i), slope(:m), .true.)
            slope = 0
            call by_speed(o, i - 1, 1.0_wp, slope)
            quantities(5*n + i) = quantity(solved, o%speed(i - 1), slope(:m), .true.)
            slope = 0
            call by_speed(o, i, 1.0_wp, slope)
            quantities(6*n + i) = quantity(solved, o%speed(i), slope(:m), .true.)
            quantities(7*n + i)%status = stat%ok
            quantities(7*n + i)%value = o%side(i)*(quantities(5*n + i)%value &
               - quantities(3*n + i)%value)
            quantities(7*n + i)%by = o%side(i)*(quantities(5*n + i)%by - quantities(3*n + i)%by)
            if (abs(quantities(7*n + i)%value) <= touching*fastest*solved%clearance) then
               status = stat%graze
            end if
            call relative_extrema(flight_at(o, i), lowest, highest, complete, lowest_at, highest_at)
            quantities(8*n + i) = gap(solved, i, 1, highest, highest_at)
            quantities(9*n + i) = gap(solved, i, -1, lowest, lowest_at)
            if (any(abs(quantities(8*n + i:9*n + i:n)%value) <= touching*solved%clearance)) then
               status = stat%graze
            end if
         end do
      end associate
   end subroutine of_impacts

   !> The least gap to a wall inside a flight; NaN if the relative position is not stationary there.
   pure function gap(solved, i, side, extreme, at)
      !> The motion.
      type(solved_type), intent(in) :: solved
      !> Number of the impact that begins the flight; the wall: +1 right, -1 left.
      integer, intent(in) :: i, side
      !> The extreme relative position over the clearance, and its time after the impact.
      real(wp), intent(in) :: extreme, at
      type(quantity_type) :: gap
      real(wp) :: slope(2*most_impacts + n_parameters), t

      gap%value = nan()
      gap%status = stat%no_extremum
      if (at < 0) return
      slope = 0
      t = stationary(flight_at(solved%o, i), at)
      slope(i) = -side
      call by_speed(solved%o, i, -side*t, slope)
      call by_position(solved%o, i, t, real(side, wp), slope)
      gap = quantity(solved, 0.5_wp - side*extreme, slope(:2*solved%o%n + n_parameters), .true.)
   end function gap

   !> The time at which the relative position is stationary, which the search for it leaves with
   !! half of the digits.
   pure real(wp) function stationary(flight, near) result(t)
      !> The flight.
      type(flight_type), intent(in) :: flight
      !> The time, approximately.
      real(wp), intent(in) :: near
      real(wp) :: d(0:5)
      integer :: i

      t = near
      do i = 1, 3
         d = derivatives(flight, t)
         if (abs(d(2)) > abs(d(1) - flight%z_dot)) t = t - (d(1) - flight%z_dot)/d(2)
      end do
   end function stationary

   !> A, tau, load phase, x_max, x_min and attenuation.
   pure subroutine of_response(setting, solved, quantities)
      !> Oscillator and r are read.
      type(setting_type), intent(in) :: setting
      !> The motion.
      type(solved_type), intent(in) :: solved
      !> (6)
      type(quantity_type), intent(out) :: quantities(:)
      real(wp) :: slope(2*most_impacts + n_parameters)
      type(quantity_type) :: lower
      integer :: n, m

      n = solved%o%n
      m = 2*n + n_parameters
      associate (o => solved%o, xi => setting%osc%xi, r => setting%r)
         slope = 0
         slope(2*n + by_r) = o%growth*o%amplitude
         slope(2*n + by_clearance) = -o%amplitude
         slope(2*n + by_xi) = o%fading*o%amplitude
         quantities(1) = quantity(solved, o%amplitude, slope(:m), .true.)
         slope = 0
         slope(n + 1) = 1
         quantities(2) = quantity(solved, atan2(sin(o%theta(1)), cos(o%theta(1))), slope(:m), &
            .false.)
         slope(2*n + by_r) = 2*xi*(1 + r**2)*gain(xi, r)**2
         slope(2*n + by_xi) = 2*r*(1 - r)*(1 + r)*gain(xi, r)**2
         quantities(3) = quantity(solved, quantities(2)%value + lag(xi, r), slope(:m), .false.)
      end associate
      quantities(4) = extreme_position(solved, 1)
      quantities(5) = extreme_position(solved, -1)
      quantities(6) = quantities(4)
      lower = negative(quantities(5))
      call take_greater(quantities(6), lower)
      associate (q => quantities(6), a => quantities(1))
         q%by = (q%by - q%value/a%value*a%by)/a%value
         q%value = q%value/a%value
      end associate
   end subroutine of_response

   !> The rms of x, and amplitude a and phase p of its part a sin(theta + p), by Gauss's quadrature.
   !!
   !! At a fixed theta = alpha + tau the integrals over a period do not depend on where the flights
   !! begin, since x is continuous.
   pure subroutine of_history(solved, quantities)
      !> The motion.
      type(solved_type), intent(in) :: solved
      !> (3)
      type(quantity_type), intent(out) :: quantities(:)
      !> Nodes and weights of ten points, for the half that is positive.
      real(wp), parameter :: nodes(5) = [0.14887433898163122_wp, 0.43339539412924719_wp, &
         0.67940956829902441_wp, 0.86506336668898451_wp, 0.97390652851717172_wp], &
         weights(5) = [0.29552422471475287_wp, 0.26926671930999636_wp, 0.21908636251598204_wp, &
         0.14945134915058059_wp, 0.06667134430868814_wp]
      !> Panels of a flight, of a radian of the faster of load and free vibration each, above which
      !! this takes too long.
      real(wp), parameter :: most_panels = 1.0e5_wp
      type(flight_type) :: flight
      real(wp), dimension(2*most_impacts + n_parameters, 3) :: slopes
      real(wp) :: d(0:5), half, t, theta, share, by_x(3), sums(3), panels
      integer :: i, j, k, m, panel, side

      m = 2*solved%o%n + n_parameters
      sums = 0
      slopes = 0
      associate (o => solved%o)
         do i = 1, o%n
            flight = flight_at(o, i)
            panels = max(1.0_wp, o%time(i)*max(1.0_wp, o%r))
            if (panels > most_panels) return
            half = 0.5_wp*o%time(i)/ceiling(panels)
            do panel = 1, ceiling(panels)
               do j = 1, size(nodes)
                  do side = -1, 1, 2
                     t = half*(2*panel - 1 + side*nodes(j))
                     theta = o%theta(i) + o%r*t
                     share = weights(j)*half*o%r/o%span
                     d = derivatives(flight, t)
                     by_x = share*[d(0), 2*sin(theta), 2*cos(theta)]
                     sums = sums + d(0)*by_x
                     by_x(1) = 2*by_x(1)
                     do k = 1, 3
                        call by_position(o, i, t, by_x(k), slopes(:, k))
                        slopes(o%n + i, k) = slopes(o%n + i, k) - by_x(k)*d(1)/o%r
                        slopes(2*o%n + by_r, k) = slopes(2*o%n + by_r, k) - by_x(k)*d(1)*t/o%r
                     end do
                  end do
               end do
            end do
         end do
      end associate
      associate (rms => sqrt(sums(1)), amplitude => norm2(sums(2:)))
         quantities(1) = quantity(solved, rms, slopes(:m, 1)/(2*rms), .true.)
         quantities(2) = quantity(solved, amplitude, matmul(slopes(:m, 2:), sums(2:))/amplitude, &
            .true.)
         quantities(3) = quantity(solved, atan2(sums(3), sums(2)), (slopes(:m, 3)*sums(2) &
            - slopes(:m, 2)*sums(3))/amplitude**2, .false.)
      end associate
   end subroutine of_history

   !> The greatest (side 1) or least (side -1) position of the primary mass.
   pure function extreme_position(solved, side) result(extreme)
      !> The motion.
      type(solved_type), intent(in) :: solved
      !> Which one.
      integer, intent(in) :: side
      type(quantity_type) :: extreme
      type(flight_type) :: flight
      real(wp) :: slope(2*most_impacts + n_parameters), lowest, highest, at(2)
      logical :: complete
      integer :: i, m

      m = 2*solved%o%n + n_parameters
      extreme%value = -huge(1.0_wp)
      associate (o => solved%o)
         do i = 1, o%n
            slope = 0
            slope(i) = side
            call take_greater(extreme, quantity(solved, side*o%u(i), slope(:m), .true.))
            flight = flight_at(o, i)
            flight%z = 0
            flight%z_dot = 0
            call relative_extrema(flight, lowest, highest, complete, at(1), at(2))
            if (side > 0) then
               at(2) = at(1)
               highest = -lowest
            end if
            if (at(2) < 0) cycle
            slope = 0
            call by_position(o, i, stationary(flight, at(2)), real(side, wp), slope)
            call take_greater(extreme, quantity(solved, highest, slope(:m), .true.))
         end do
      end associate
      if (side < 0) extreme = negative(extreme)
   end function extreme_position

   !> Not a number.
   pure real(wp) function nan()

      nan = ieee_value(1.0_wp, ieee_quiet_nan)
   end function nan

   !> A quantity with the opposite sign.
   pure function negative(a) result(b)
      !> The quantity.
      type(quantity_type), intent(in) :: a
      type(quantity_type) :: b

      b = quantity_type(-a%value, -a%by, a%status, a%terms)
   end function negative

   !> The greater of two quantities. If they are equal, it has derivatives only with respect to the
   !! parameters by which they change alike.
   pure subroutine take_greater(a, b)
      !> In: one of them. Out: the greater one.
      type(quantity_type), intent(inout) :: a
      !> The other one.
      type(quantity_type), intent(in) :: b
      integer :: k

      if (abs(a%value - b%value) <= alike*max(abs(a%value), abs(b%value))) then
         if (any(a%status == [stat%ok, stat%not_smooth])) a%status = max(a%status, b%status)
         do k = 1, size(a%by)
            if (abs(a%by(k) - b%by(k)) <= same*max(abs(a%by(k)), abs(b%by(k))) &
               + rounding*max(a%terms(k), b%terms(k))) cycle
            a%by(k) = nan()
            if (a%status == stat%ok) a%status = stat%not_smooth
         end do
      else if (b%value > a%value) then
         a = b
      end if
   end subroutine take_greater

   !> The multipliers, and 1 - |lambda_1|.
   pure subroutine of_stability(solved, multipliers, margin, quantities)
      !> The motion.
      type(solved_type), intent(in) :: solved
      !> (4) The multipliers in their order.
      complex(wp), intent(in) :: multipliers(:)
      !> 1 - |lambda_1|.
      type(quantity_type), intent(out) :: margin
      !> (8) Real parts, then imaginary parts.
      type(quantity_type), intent(out) :: quantities(:)
      real(wp) :: parts(4, 4, most_impacts), p(4, 4), matrix(4, 4), real_part(4), &
         imaginary_part(4), left_vectors(4, 4), right_vectors(4, 4), work(64)
      complex(wp) :: lambda(4), x(4), y(4), overlap, weights(4, 4)
      real(wp) :: slope(2*most_impacts + n_parameters), apart(4)
      logical :: regular, free(4)
      integer :: i, j, k, m, info

      quantities%value = nan()
      margin%value = nan()
      quantities%status = stat%zero_approach
      margin%status = stat%zero_approach
      m = 2*solved%o%n + n_parameters
      call period_parts(solved%o, parts, p, regular)
      if (.not. regular) return
      quantities%status = stat%lapack_failed
      margin%status = stat%lapack_failed
      if (.not. all(abs(p) <= huge(1.0_wp))) return
      matrix = p
      call geev('V', 'V', 4, matrix, 4, real_part, imaginary_part, left_vectors, 4, right_vectors, &
         4, work, size(work), info)
      if (info /= 0) return
      lambda = cmplx(real_part, imaginary_part, wp)
      free = .true.
      do k = 1, 4
         ! the eigenvalue next to the multiplier of this place
         j = minloc(abs(lambda - multipliers(k)), 1, free)
         free(j) = .false.
         quantities(k)%value = lambda(j)%re
         quantities(4 + k)%value = lambda(j)%im
         call vector_of(right_vectors, imaginary_part, j, x)
         call vector_of(left_vectors, imaginary_part, j, y)
         overlap = dot_product(y, x)
         apart = abs(lambda - lambda(j))
         apart(j) = huge(1.0_wp)
         quantities([k, 4 + k])%status = stat%coincident
         if (abs(overlap) < defect .or. minval(apart) < 1.0e-9_wp*maxval(abs(lambda)) &
            + 1.0e-7_wp*abs(lambda(j))) cycle
         do i = 1, 4
            weights(:, i) = conjg(y)*x(i)/overlap
         end do
         slope = 0
         call add_period_slope(solved%o, parts, weights%re, slope)
         quantities(k) = quantity(solved, lambda(j)%re, slope(:m), .false.)
         slope = 0
         if (abs(lambda(j)%im) > 0) call add_period_slope(solved%o, parts, weights%im, slope)
         quantities(4 + k) = quantity(solved, lambda(j)%im, slope(:m), .false.)
      end do
      margin = modulus(quantities(1), quantities(5))
      do k = 2, 4
         call take_greater(margin, modulus(quantities(k), quantities(4 + k)))
      end do
      margin = negative(margin)
      margin%value = 1 + margin%value
   end subroutine of_stability

   !> The modulus of a multiplier.
   pure function modulus(real_part, imaginary_part)
      !> Its parts.
      type(quantity_type), intent(in) :: real_part, imaginary_part
      type(quantity_type) :: modulus

      modulus%value = hypot(real_part%value, imaginary_part%value)
      modulus%status = real_part%status
      if (.not. modulus%value > 0) return
      modulus%by = (real_part%value*real_part%by + imaginary_part%value*imaginary_part%by) &
         /modulus%value
      modulus%terms = (abs(real_part%value)*real_part%terms + abs(imaginary_part%value) &
         *imaginary_part%terms)/modulus%value
   end function modulus

   !> Eigenvector j of a real matrix.
   pure subroutine vector_of(vectors, imaginary_part, j, vector)
      !> (4, 4) As LAPACK stores them: a pair of conjugates by real and imaginary part.
      real(wp), intent(in) :: vectors(:, :)
      !> (4) Imaginary parts of the eigenvalues.
      real(wp), intent(in) :: imaginary_part(:)
      !> Its number.
      integer, intent(in) :: j
      !> (4)
      complex(wp), intent(out) :: vector(:)

      if (imaginary_part(j) > 0) then
         vector = cmplx(vectors(:, j), vectors(:, j + 1), wp)
      else if (imaginary_part(j) < 0) then
         vector = cmplx(vectors(:, j - 1), -vectors(:, j), wp)
      else
         vector = cmplx(vectors(:, j), 0.0_wp, wp)
      end if
   end subroutine vector_of

end module vi_gradient
