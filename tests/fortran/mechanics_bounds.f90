!> Each bound used in a proof, compared with the extreme that it bounds, from dense samples or
!! another formula. A bound must hold, and must not be much too large.
module mechanics_bounds
   use checks, only: check
   use random_numbers, only: draw, draw_integer, draw_log, random_type
   use random_systems, only: pi
   use vi_bounce, only: bounce, falls, series
   use vi_flight, only: flight_type, new_flight
   use vi_march, only: bounds_after, direction, moment_of
   use vi_kinds, only: wp
   use vi_oscillation, only: derivative_bound, derivatives
   use vi_transition, only: first_cell, idle_time, largest, moment_type, new_transition, nodes, &
      transition_type
   implicit none (type, external)
   private

   public :: test_bounds

   type(random_type) :: random

   !> A flight in closed form, and the same flight in the form of the march.
   type :: both_type
      type(flight_type) :: flight
      type(transition_type) :: m
      type(moment_type) :: at
      !> Sine and cosine of the load phase, and the load, at the start.
      real(wp) :: s, c, load
      real(wp) :: x, x_dot
   end type both_type

contains

   subroutine test_bounds()
      integer :: i

      do i = 1, 300
         call check_amplitudes(free=mod(i, 3) /= 0, forced=mod(i, 3) /= 1)
         call check_cubics(free=mod(i, 3) /= 0, forced=mod(i, 3) /= 1)
      end do
      call check_falls()
      call check_bounces()
      call check_idle()
      call check_worst_gaps()
      call check_worst_slopes()
   end subroutine test_bounds

   !> A random flight with a free part, a forced one, or both.
   subroutine draw_both(free, forced, most_damped, b)
      logical, intent(in) :: free, forced
      !> Largest damping ratio.
      real(wp), intent(in) :: most_damped
      type(both_type), intent(out) :: b
      real(wp) :: xi, r, amplitude, lag, phase

      xi = draw_log(random, 1e-4_wp, most_damped)
      r = draw_log(random, 0.1_wp, 10.0_wp)
      amplitude = merge(draw_log(random, 0.01_wp, 10.0_wp), 0.0_wp, forced)
      ! the tables do not require that gain and lag are those of the oscillator
      lag = draw(random, 0.0_wp, pi)
      phase = draw(random, 0.0_wp, 2*pi)
      b%s = sin(phase)
      b%c = cos(phase)
      b%x = amplitude*sin(phase - lag)
      b%x_dot = amplitude*r*cos(phase - lag)
      if (free) then
         b%x = b%x + draw(random, -1.0_wp, 1.0_wp)
         b%x_dot = b%x_dot + draw(random, -1.0_wp, 1.0_wp)
      end if
      b%flight = new_flight(xi, r, amplitude, phase - lag, b%x, b%x_dot, 0.0_wp, 0.0_wp, 1.0_wp)
      call new_transition(xi, r, amplitude*cos(lag), amplitude*sin(lag), b%m)
      b%at = moment_of(b%m, b%s, b%c, b%x, b%x_dot, 0.0_wp, 0.0_wp)
   end subroutine draw_both

   !> Bounds on derivatives from a time on, compared with many samples after it.
   subroutine check_amplitudes(free, forced)
      logical, intent(in) :: free, forced
      integer, parameter :: samples = 1500
      type(both_type) :: b
      real(wp) :: d(0:5), most(0:5), bounds(0:2), bound(0:5), t, span
      integer :: i, n

      call draw_both(free, forced, merge(0.9_wp, 0.01_wp, free .and. forced), b)
      ! two cycles of the slower part
      span = 4*pi/min(1.0_wp, b%m%r)
      if (.not. forced) span = 4*pi
      if (.not. free) span = 4*pi/b%m%r
      most = 0
      do i = 0, samples
         d = derivatives(b%flight, i*span/samples)
         most = max(most, abs(d))
      end do
      bounds = bounds_after(b%m, b%at)
      t = 0
      bound = [(derivative_bound(b%flight, n, t), n=0, 5)]
      call check(all(most <= bound*(1 + 1e-12_wp)), 'bounds: of every derivative')
      call check(all(most([0, 4, 5]) <= bounds*(1 + 1e-12_wp)), 'bounds: of orders 0, 4 and 5')
      call check(maxval(abs(bounds/bound([0, 4, 5]) - 1)) < 1e-9_wp, 'bounds: one and the other')
      if (free .and. forced) return
      ! a single, nearly undamped part comes near its amplitude
      call check(all(bound <= 1.1_wp*most), 'bounds: of one part are its amplitudes')
      t = 0.5_wp*span
      most = 0
      do i = 0, samples
         d = derivatives(b%flight, t + i*span/samples)
         most = max(most, abs(d))
      end do
      bound = [(derivative_bound(b%flight, n, t), n=0, 5)]
      call check(all(most <= bound*(1 + 1e-12_wp)), 'bounds: from a later time on')
      call check(all(bound <= 1.1_wp*most), 'bounds: which are no larger than needed')
   end subroutine check_amplitudes

   !> The cubics of all cells, compared with x, x' and the quotient at the start: their errors are
   !! within the bounds, and come near them in some cell.
   subroutine check_cubics(free, forced)
      logical, intent(in) :: free, forced
      integer, parameter :: samples = 24
      type(both_type) :: b
      real(wp) :: bounds(0:2), ratio(3), worst(3), d(0:5), t, slack, first(0:5)
      integer :: size, i, j, cell

      call draw_both(free, forced, merge(0.9_wp, 0.01_wp, free .and. forced), b)
      bounds = bounds_after(b%m, b%at)
      first = derivatives(b%flight, 0.0_wp)
      slack = 64*epsilon(1.0_wp)*(bounds(0) + bounds(2))
      worst = 0
      do size = 0, largest
         do i = 0, nodes/2**(size + 1) - 1
            cell = first_cell(size) + i
            do j = 0, samples
               t = (i + real(j, wp)/samples)*2**(size + 1)*b%m%h
               d = derivatives(b%flight, t)
               ratio = 0
               ratio(1) = excess(d(0), cubic(b%m%position(:, :, cell), b%at, j), slack, bounds(1))
               ratio(2) = excess(d(1), cubic(b%m%velocity(:, :, cell), b%at, j), slack, bounds(2))
               if (i == 0 .and. j > samples/4) ratio(3) = excess((d(0) - first(0) - first(1)*t)/t, &
                  cubic(b%m%departure(:, :, size), b%at, j), 4*slack/t, 0.2_wp*bounds(2))
               worst = max(worst, ratio/b%m%error(size))
            end do
         end do
      end do
      call check(all(worst <= 1), 'bounds: of the errors of cubics')
      ! the table covers half a cycle of the only part
      if (free .and. forced) return
      if (merge(b%m%r <= 2, b%m%r >= 0.5_wp, free)) then
         call check(all(worst(:2) > 0.5_wp), 'bounds: which some cubic needs')
      end if
   end subroutine check_cubics

   !> |value - approximation| beyond rounding, divided by a bound.
   pure real(wp) function excess(value, approximation, slack, bound)
      real(wp), intent(in) :: value, approximation, slack, bound

      excess = max(0.0_wp, abs(value - approximation) - slack)/bound
   end function excess

   !> A cubic at j/24 of its cell, by de Casteljau's scheme.
   pure real(wp) function cubic(matrix, at, j) result(value)
      real(wp), intent(in) :: matrix(4, 4)
      type(moment_type), intent(in) :: at
      integer, intent(in) :: j
      real(wp) :: b(4), u
      integer :: n

      u = j/24.0_wp
      b = matmul(matrix, [at%free, at%free_dot, at%sine, at%cosine])
      do n = 3, 1, -1
         b(:n) = (1 - u)*b(:n) + u*b(2:n + 1)
      end do
      value = b(1)
   end function cubic

   !> What `falls` proves of k = gap/t is true, and clearly true cases are proven.
   subroutine check_falls()
      integer, parameter :: samples = 200
      type(both_type) :: b
      real(wp) :: k(0:8), end, speed, t, steepest, last, value, d(0:5), doubt
      integer :: i, j, n, side, proved, clear

      proved = 0
      clear = 0
      do i = 1, 8000
         call draw_system(b)
         side = 2*draw_integer(random, 0, 1) - 1
         ! much longer than a bounce: the bound on the remainder decides there
         end = draw_log(random, 0.02_wp, 5.0_wp)/max(1.0_wp, b%m%r)
         speed = draw_log(random, 0.01_wp, 2.0_wp)*0.5_wp*end*abs(acceleration(b))
         k = series(b%m, b%load, b%s, b%c, b%x, b%x_dot, side, speed)
         steepest = k(1)
         do j = samples/10, samples
            t = j*end/samples
            d = derivatives(b%flight, t)
            last = side*(d(0) - b%x - b%x_dot*t)/t + speed
            steepest = max(steepest, (side*(d(1) - b%x_dot) + speed - last)/t)
         end do
         value = 0
         do n = 8, 0, -1
            value = value*end + k(n)
         end do
         call check(abs(value - last) <= derivative_bound(b%flight, 10, 0.0_wp)*end**9/3628800 &
            + 1e-14_wp*(speed + derivative_bound(b%flight, 0, 0.0_wp)/end), &
            'bounce: k is the gap over time')
         if (falls(b%m, k, end, b%s, b%c, b%x, b%x_dot)) then
            proved = proved + 1
            call check(steepest < 1e-9_wp*abs(k(1)), 'bounce: k falls where this is proved')
            call check(last < 0, 'bounce: and passes zero')
         end if
         ! twice the remainders, by the amplitudes
         doubt = 0.4_wp*derivative_bound(b%flight, 5, 0.0_wp)
         ! the slope of the quadratic lies this far below its Bernstein coefficients
         if (steepest + doubt*end**3/6 + 3*abs(k(3))*end**2 < 0 .and. &
            last + doubt*end**4/24 < 0) then
            clear = clear + 1
            call check(falls(b%m, k, end, b%s, b%c, b%x, b%x_dot), &
               'bounce: what is clear is proved')
         end if
      end do
      call check(proved > 800 .and. clear > 400, 'bounce: both were seen')
   end subroutine check_falls

   !> The worst k that four Taylor coefficients and the bound on k'''' allow decides the answer of
   !! `falls` where only the first two coefficients may be negative.
   subroutine check_worst_gaps()
      type(both_type) :: b
      real(wp) :: k(0:8), end, rest, room(2)
      integer :: i, proved

      proved = 0
      do i = 1, 2000
         call draw_system(b)
         end = draw_log(random, 0.02_wp, 5.0_wp)
         ! k'''' is bounded by a fifth of the bound on x'''''
         rest = 0.2_wp*derivative_bound(b%flight, 5, 0.0_wp)*end**3
         ! possible growth of k' and k at the end beyond their cubics, over what the bound allows
         room = [draw_log(random, 0.2_wp, 5.0_wp), draw_log(random, 0.2_wp, 5.0_wp)]
         k = 0
         k(2) = draw(random, 0.0_wp, 1.0_wp)*rest/end
         k(3) = draw(random, 0.0_wp, 1.0_wp)*rest/end**2
         k(1) = -(2*k(2)*end + 3*k(3)*end**2) - room(1)*rest/6
         k(0) = -(k(1)*end + k(2)*end**2 + k(3)*end**3) - room(2)*rest*end/24
         if (any(abs(room - 1) < 1e-8_wp)) cycle
         call check(falls(b%m, k, end, b%s, b%c, b%x, b%x_dot) .eqv. all(room > 1), &
            'bounce: the worst k decides')
         if (all(room > 1)) proved = proved + 1
      end do
      call check(proved > 200, 'bounce: some are proved')
   end subroutine check_worst_gaps

   !> Where the cubic of x' in a cell is a constant, x' differs from it by its whole error. A
   !! direction of z - x is returned only where its slope has this sign throughout the cell, and
   !! is returned where the slope exceeds twice the bound on the error.
   subroutine check_worst_slopes()
      integer, parameter :: samples = 24
      type(both_type) :: b
      real(wp) :: differences(3, 4), level, error, bounds(0:2), slope, given, least, most, d(0:5), h
      integer :: a, cell, i, j, size, wrong

      wrong = 0
      do i = 1, 2000
         call new_transition(draw_log(random, 1e-4_wp, 0.9_wp), draw_log(random, 0.1_wp, 10.0_wp), &
            1.0_wp, 0.0_wp, b%m)
         size = draw_integer(random, 0, largest)
         cell = draw_integer(random, 0, nodes/2**(size + 1) - 1)
         a = cell*2**(size + 1)
         associate (cubics => b%m%velocity(:, :, first_cell(size) + cell))
            differences = cubics(2:, :) - cubics(:3, :)
            call null_vector(differences, b%at)
            level = dot_product(cubics(1, :), [b%at%free, b%at%free_dot, b%at%sine, b%at%cosine])
         end associate
         b%flight = new_flight(b%m%xi, b%m%r, hypot(b%at%sine, b%at%cosine), &
            atan2(b%at%sine, b%at%cosine), b%at%free + b%at%sine, &
            b%at%free_dot + b%m%r*b%at%cosine, 0.0_wp, 0.0_wp, 1.0_wp)
         bounds = bounds_after(b%m, b%at)
         error = bounds(2)*b%m%error(size)
         ! rounding decides below it
         if (error < 1e-12_wp*(abs(level) + bounds(0))) cycle
         slope = draw_log(random, 1e-3_wp, 10.0_wp)*error
         if (draw_integer(random, 0, 1) == 1) slope = -slope
         b%at%z_dot = level + slope
         h = 2**(size + 1)*b%m%h
         least = huge(1.0_wp)
         most = -huge(1.0_wp)
         do j = 0, samples
            d = derivatives(b%flight, a*b%m%h + j*h/samples)
            least = min(least, b%at%z_dot - d(1))
            most = max(most, b%at%z_dot - d(1))
         end do
         given = direction(b%m, b%at, a, size, bounds(2))
         if (least < 0 .and. most > 0) then
            wrong = wrong + 1
            call check(.not. abs(given) > 0, 'march: no direction where the slope changes sign')
         else
            call check(given*slope >= 0, 'march: the sign of the slope')
         end if
         if (abs(slope) > 2*error) call check(abs(given) > 0, 'march: a clear direction')
         call check_ratio(b, a, size)
      end do
      call check(wrong > 200, 'march: slopes that change sign were seen')
   end subroutine check_worst_slopes

   !> A direction is returned only where the slope of z - x does not fall below an eighth of its
   !! maximum within the cell.
   subroutine check_ratio(b, a, size)
      type(both_type), intent(inout) :: b
      integer, intent(in) :: a, size
      integer, parameter :: samples = 24
      real(wp) :: bounds(0:2), slopes(0:samples), d(0:5), h, given
      integer :: j

      b%at%free = draw(random, -1.0_wp, 1.0_wp)
      b%at%free_dot = draw(random, -1.0_wp, 1.0_wp)
      b%at%sine = draw(random, -1.0_wp, 1.0_wp)
      b%at%cosine = draw(random, -1.0_wp, 1.0_wp)
      b%flight = new_flight(b%m%xi, b%m%r, hypot(b%at%sine, b%at%cosine), &
         atan2(b%at%sine, b%at%cosine), b%at%free + b%at%sine, &
         b%at%free_dot + b%m%r*b%at%cosine, 0.0_wp, 0.0_wp, 1.0_wp)
      bounds = bounds_after(b%m, b%at)
      h = 2**(size + 1)*b%m%h
      do j = 0, samples
         d = derivatives(b%flight, a*b%m%h + j*h/samples)
         slopes(j) = d(1)
      end do
      ! the least slope is zero, or a fraction of the greatest one
      b%at%z_dot = minval(slopes) - draw(random, -0.2_wp, 0.3_wp)*(maxval(slopes) - minval(slopes))
      if (draw_integer(random, 0, 1) == 1) b%at%z_dot = maxval(slopes) + minval(slopes) - b%at%z_dot
      slopes = b%at%z_dot - slopes
      given = direction(b%m, b%at, a, size, bounds(2))
      if (abs(given) > 0) call check(minval(given*slopes) > maxval(given*slopes)/8 &
         - 1e-12_wp*bounds(0), 'march: no slope is much smaller than another one')
   end subroutine check_ratio

   !> A state that satisfies three equations, scaled to 1: the minors of the matrix, with signs.
   pure subroutine null_vector(equations, at)
      real(wp), intent(in) :: equations(3, 4)
      type(moment_type), intent(out) :: at
      real(wp) :: v(4), rest(3, 3), scaled(3, 4)
      integer :: i, j

      do i = 1, 3
         scaled(i, :) = equations(i, :)/maxval(abs(equations(i, :)))
      end do
      do j = 1, 4
         rest = scaled(:, pack([1, 2, 3, 4], [1, 2, 3, 4] /= j))
         v(j) = (-1)**j*(rest(1, 1)*(rest(2, 2)*rest(3, 3) - rest(2, 3)*rest(3, 2)) &
            - rest(1, 2)*(rest(2, 1)*rest(3, 3) - rest(2, 3)*rest(3, 1)) &
            + rest(1, 3)*(rest(2, 1)*rest(3, 2) - rest(2, 2)*rest(3, 1)))
      end do
      v = v/norm2(v)
      at%free = v(1)
      at%free_dot = v(2)
      at%sine = v(3)
      at%cosine = v(4)
   end subroutine null_vector

   !> A short flight that provably returns to its wall is found by its own series, to the last
   !! digits of its duration.
   subroutine check_bounces()
      type(both_type) :: b
      real(wp) :: k(0:8), t, speed, back, time, approach, rounding
      integer :: i, n, side, found

      found = 0
      do i = 1, 10000
         call draw_system(b)
         side = merge(1, -1, acceleration(b) > 0)
         speed = draw_log(random, 1e-9_wp, 0.06_wp)*0.5_wp*abs(acceleration(b))/max(1.0_wp, b%m%r)
         t = 3*speed/abs(acceleration(b))
         k = series(b%m, b%load, b%s, b%c, b%x, b%x_dot, -side, speed)
         call bounce(b%m, b%load, b%s, b%c, b%x, b%x_dot, -side, speed, t*speed*(1 - 1e-9_wp), &
            time, approach)
         call check(.not. (time > 0 .or. approach > 0), 'bounce: the other wall may be near')
         call bounce(b%m, b%load, b%s, b%c, b%x, b%x_dot, side, speed, 10.0_wp, time, approach)
         call check(.not. (time > 0 .or. approach > 0), 'bounce: from the wall that it leaves')
         call bounce(b%m, b%load, b%s, b%c, b%x, b%x_dot, -side, speed, t*speed*(1 + 1e-9_wp), &
            time, approach)
         call check((time > 0) .eqv. falls(b%m, k, t, b%s, b%c, b%x, b%x_dot), &
            'bounce: found where it is proved')
         if (.not. time > 0) cycle
         found = found + 1
         back = 0
         do n = 8, 1, -1
            back = back*time + n*k(n)
         end do
         back = -time*back
         rounding = 64*epsilon(1.0_wp)*speed
         call check(abs(approach - back) <= rounding, 'bounce: approach speed')
         back = 0
         do n = 8, 0, -1
            back = back*time + k(n)
         end do
         call check(abs(back) <= rounding, 'bounce: the gap is closed')
      end do
      call check(found > 5000, 'bounce: most are found')
   end subroutine check_bounces

   !> A flight of a forced oscillator: here the load has to be that of the forced motion.
   subroutine draw_system(b)
      type(both_type), intent(out) :: b
      complex(wp) :: response
      real(wp) :: xi, r, phase

      xi = draw_log(random, 1e-4_wp, 0.9_wp)
      r = draw_log(random, 0.1_wp, 10.0_wp)
      phase = draw(random, 0.0_wp, 2*pi)
      b%load = real(draw_integer(random, 0, 1), wp)
      response = b%load/cmplx(1 - r**2, 2*xi*r, wp)
      b%s = sin(phase)
      b%c = cos(phase)
      b%x = draw(random, -1.0_wp, 1.0_wp)
      b%x_dot = draw(random, -1.0_wp, 1.0_wp)
      b%flight = new_flight(xi, r, abs(response), phase + atan2(response%im, response%re), b%x, &
         b%x_dot, 0.0_wp, 0.0_wp, 1.0_wp)
      call new_transition(xi, r, response%re, -response%im, b%m)
      b%at = moment_of(b%m, b%s, b%c, b%x, b%x_dot, 0.0_wp, 0.0_wp)
   end subroutine draw_system

   !> The acceleration at the start.
   pure real(wp) function acceleration(b)
      type(both_type), intent(in) :: b
      real(wp) :: d(0:5)

      d = derivatives(b%flight, 0.0_wp)
      acceleration = d(2)
   end function acceleration

   !> No contact in an idle time, which ends where the greatest amplitude touches a wall.
   subroutine check_idle()
      type(both_type) :: b
      real(wp) :: half, time, t, reach, d(0:5), bounds(0:2)
      integer :: i, j, idle

      idle = 0
      do i = 1, 2000
         call draw_system(b)
         bounds = bounds_after(b%m, b%at)
         half = bounds(0)*draw(random, 0.8_wp, 3.0_wp)
         b%at%z = half*draw(random, -1.0_wp, 1.0_wp)
         b%at%z_dot = draw(random, -1.0_wp, 1.0_wp)
         time = idle_time(b%m, b%at, half)
         reach = half - bounds(0)
         call check((time > 0) .eqv. (abs(b%at%z) < reach), 'idle: where no wall is in reach')
         if (.not. time > 0) cycle
         idle = idle + 1
         call check(abs(abs(b%at%z + b%at%z_dot*time) - reach) < 1e-12_wp*half, &
            'idle: until one may be')
         do j = 0, 50
            t = j*time/50
            d = derivatives(b%flight, t)
            call check(abs(b%at%z + b%at%z_dot*t - d(0)) < half*(1 + 1e-12_wp), 'idle: no contact')
         end do
         ! a free mass without velocity reaches no wall
         b%at%z_dot = 0
         call check(idle_time(b%m, b%at, half) >= huge(1.0_wp), 'idle: for ever')
      end do
      call check(idle > 200, 'idle: such times were seen')
   end subroutine check_idle

end module mechanics_bounds
