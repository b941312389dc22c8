!> Motions whose impact phases are given, many at a time: one point per lane.
!!
!! The same equations as in vi_periodic and vi_impact_map, with d = 1 throughout, since no
!! multiplier depends on the unit of length. Every step is a loop over the lanes.
module vi_lane_motion
   use vi_kinds, only: wp
   use vi_lane_least_squares, only: lane_least_squares
   use vi_lanes, only: largest_angle, largest_exponent, shrinkage, sine_cosine
   use vi_plan, only: lanes, plan_type
   implicit none (type, external)
   private

   public :: lane_chain, rows

contains

   !> From phases to [P] in every lane.
   pure subroutine lane_chain(plan, n, m, r, phases, system, x, flight, p, residual, quality)
      !> Data that all points share: pattern, xi, eta and the weights of the impact law.
      type(plan_type), intent(in) :: plan
      !> N impacts, m = 2N equations.
      integer, intent(in) :: n, m
      !> Frequency ratio and impact phases (rad) of each lane; the first phase is 0.
      real(wp), intent(in) :: r(lanes), phases(lanes, n)
      !> Scratch: equations with the right side in the last column; their solution x_1 .. x_N, A
      !! cos(tau), A sin(tau) for d = 1; of each flight c_1, c_2, sine and cosine of its first
      !! phase, duration, 1/duration, z'.
      real(wp), intent(inout) :: system(lanes, m, n + 3), x(lanes, n + 2), flight(lanes, 7, n)
      !> [P] of each lane, for d = 1.
      real(wp), intent(out) :: p(lanes, 4, 4)
      !> Square of the relative residual of (26), (30).
      real(wp), intent(out) :: residual(lanes)
      !> The estimated error of [P], relative to its largest entry, is epsilon/quality; 0 if no
      !! digit is certain.
      real(wp), intent(out) :: quality(lanes)
      real(wp) :: total(lanes), clear(lanes), worst(lanes)
      integer :: i

      call flights(plan, n, r, phases, flight, clear)
      call assemble(plan, n, m, r, flight, system)
      call lane_least_squares(m, n + 2, system, x, residual, total, quality)
      ! as `rounding` of vi_periodic; what is near the limit is left to the reference chain
      worst = quality*(quality*plan%accepted - 1)
      where (.not. (worst > 0 .and. residual <= (total - residual)*worst**2)) quality = 0
      residual = residual/total
      quality = quality*clear
      call velocities(plan, n, x, flight, clear)
      quality = quality*clear
      worst = 1
      do i = 1, n
         call advance(plan, n, i, r, x, flight, p, clear)
         worst = min(worst, clear)
      end do
      quality = quality*worst
   end subroutine lane_chain

   !> Sets the quantities that depend on the phases alone: entries 1 to 6 of each flight.
   pure subroutine flights(plan, n, r, phases, flight, clear)
      !> Data that all points share.
      type(plan_type), intent(in) :: plan
      !> Number of impacts.
      integer, intent(in) :: n
      !> Frequency ratio and impact phases (rad) of each lane.
      real(wp), intent(in) :: r(lanes), phases(lanes, n)
      !> Out: entries 1 to 6 of each flight, as in `lane_chain`; entry 7 is not changed.
      real(wp), intent(inout) :: flight(lanes, 7, n)
      !> 1, or 0 where an angle or exponent is too large for the series.
      real(wp), intent(out) :: clear(lanes)
      real(wp), dimension(lanes) :: time, angle, shrink, worst
      integer :: i

      worst = plan%period
      do i = 1, n
         if (i < n) time = (phases(:, i + 1) - phases(:, i))/r
         if (i == n) time = (phases(:, 1) + plan%period - phases(:, n))/r                 ! (25)
         flight(:, 5, i) = time
         flight(:, 6, i) = 1/time
         worst = max(worst, time, plan%xi*time*(largest_angle/largest_exponent))
         angle = plan%frequency*time
         call sine_cosine(angle, flight(:, 1, i), flight(:, 2, i))
         time = plan%xi*time
         call shrinkage(time, shrink)
         flight(:, 1, i) = shrink*flight(:, 1, i)                                         ! (9)
         flight(:, 2, i) = shrink*flight(:, 2, i)                                         ! (10)
         if (i == 1) then
            flight(:, 3, i) = 0
            flight(:, 4, i) = 1
         else
            call sine_cosine(phases(:, i), flight(:, 3, i), flight(:, 4, i))
         end if
      end do
      clear = merge(1.0_wp, 0.0_wp, worst < largest_angle)
   end subroutine flights

   !> The equations (26), then (30), with the right side as the last column.
   pure subroutine assemble(plan, n, m, r, flight, system)
      !> Data that all points share.
      type(plan_type), intent(in) :: plan
      !> N impacts, m = 2N equations.
      integer, intent(in) :: n, m
      !> Frequency ratio, and entries 1 to 6 of each flight.
      real(wp), intent(in) :: r(lanes), flight(lanes, 7, n)
      !> Out: coefficients, and the right side in the last column.
      real(wp), intent(inout) :: system(lanes, m, n + 3)
      real(wp), dimension(lanes, 7) :: w, v
      integer :: i, previous, next, after_next

      system(:, :, :n) = 0
      do i = 1, n
         previous = modulo(i - 2, n) + 1
         next = modulo(i, n) + 1
         after_next = modulo(i + 1, n) + 1
         associate (y => plan%y([previous, i, next, after_next]))
            call coefficients(plan, r, flight(:, :, i), flight(:, 3:4, next), &
               flight(:, 6, previous), flight(:, 6, next), plan%x_dot_after(:, i), &
               plan%x_dot_before(:, next), y(2:4) - y(1:3), w, v)
         end associate
         ! the columns may coincide (N = 2), so the terms are added
         call add(w(:, 1), system(:, i, i))                                               ! (26)
         call add(w(:, 2), system(:, i, next))
         call add(w(:, 3), system(:, i, previous))
         call add(v(:, 1), system(:, n + i, i))                                           ! (30)
         call add(v(:, 2), system(:, n + i, next))
         call add(v(:, 3), system(:, n + i, after_next))
         call add(v(:, 4), system(:, n + i, previous))
         system(:, i, n + 1) = w(:, 4)
         system(:, i, n + 2) = w(:, 5)
         system(:, i, n + 3) = w(:, 6)
         system(:, n + i, n + 1) = v(:, 5)
         system(:, n + i, n + 2) = v(:, 6)
         system(:, n + i, n + 3) = v(:, 7)
      end do
   end subroutine assemble

   !> Adds a term to a sum in every lane.
   pure subroutine add(term, sum)
      !> What is added.
      real(wp), intent(in) :: term(lanes)
      !> In and out: the sum.
      real(wp), intent(inout) :: sum(lanes)

      sum = sum + term
   end subroutine add

   !> W_1i..W_6i and V_1i..V_7i, as in vi_periodic, for one flight.
   pure subroutine coefficients(plan, r, flight, ahead, before, after, first, second, y_step, w, v)
      !> Data that all points share.
      type(plan_type), intent(in) :: plan
      !> Frequency ratio; the flight i (as in `lane_chain`); sine and cosine of the impact that ends
      !! it; 1/duration of flights i - 1 and i + 1.
      real(wp), intent(in) :: r(lanes), flight(lanes, 7), ahead(lanes, 2), before(lanes), &
         after(lanes)
      !> Weights of z' before and after in x' after impact i and before impact i + 1; changes of y
      !! in flights i - 1, i, i + 1.
      real(wp), intent(in) :: first(2), second(2), y_step(3)
      !> W_1i .. W_6i (entry 7 is not set), and V_1i .. V_7i.
      real(wp), intent(out) :: w(lanes, 7), v(lanes, 7)
      real(wp) :: h, xi, inverse, c1, c2, c3, c4, g1, g2, g3, g4, sine_term, cosine_term, pull
      integer :: l

      h = plan%frequency
      xi = plan%xi
      inverse = 1/h
      do l = 1, lanes
         c1 = flight(l, 1)
         c2 = flight(l, 2)
         c3 = h*c2 - xi*c1                                                                ! (A4)
         c4 = -(h*c1 + xi*c2)
         g1 = first(1)*before(l)                                                          ! (A1)
         g2 = first(2)*flight(l, 6)
         g3 = second(1)*flight(l, 6)
         g4 = second(2)*after(l)
         sine_term = (r(l)*flight(l, 4) + xi*flight(l, 3))*inverse
         cosine_term = (-r(l)*flight(l, 3) + xi*flight(l, 4))*inverse
         pull = g1*y_step(1) + g2*y_step(2)
         w(l, 4) = c1*sine_term + c2*flight(l, 3) - ahead(l, 1)                           ! (A2)
         w(l, 5) = c1*cosine_term + c2*flight(l, 4) - ahead(l, 2)
         v(l, 5) = c3*sine_term + c4*flight(l, 3) - r(l)*ahead(l, 2)                      ! (A3)
         v(l, 6) = c3*cosine_term + c4*flight(l, 4) + r(l)*ahead(l, 1)
         c1 = c1*inverse
         c3 = c3*inverse
         w(l, 1) = c1*(g2 - g1 - xi) - c2
         w(l, 2) = 1 - c1*g2
         w(l, 3) = c1*g1
         w(l, 6) = c1*pull
         v(l, 1) = -g3 - c4 - c3*(g1 - g2 + xi)
         v(l, 2) = g3 - g4 - c3*g2
         v(l, 3) = g4
         v(l, 4) = c3*g1
         v(l, 7) = -g3*y_step(2) - g4*y_step(3) + c3*pull
      end do
   end subroutine coefficients

   !> The velocity of the free mass in every flight.
   pure subroutine velocities(plan, n, x, flight, clear)
      !> Data that all points share.
      type(plan_type), intent(in) :: plan
      !> Number of impacts.
      integer, intent(in) :: n
      !> Solution: x_1 .. x_N, A cos(tau), A sin(tau) for d = 1.
      real(wp), intent(in) :: x(lanes, n + 2)
      !> In: entry 6, 1/duration. Out: entry 7, z', is set.
      real(wp), intent(inout) :: flight(lanes, 7, n)
      !> 1, or 0 where the load is negligible or far exceeds the motion.
      real(wp), intent(out) :: clear(lanes)
      real(wp), parameter :: disparity = 1.0e6_wp
      real(wp), dimension(lanes) :: largest, amplitude
      integer :: i, next

      largest = 1
      do i = 1, n
         next = modulo(i, n) + 1
         largest = max(largest, abs(x(:, i)))
         flight(:, 7, i) = (x(:, next) - x(:, i) + (plan%y(next) - plan%y(i))) &
            *flight(:, 6, i)                                                              ! (16)
      end do
      amplitude = abs(x(:, n + 1)) + abs(x(:, n + 2))
      clear = merge(1.0_wp, 0.0_wp, disparity*amplitude > largest .and. &
         amplitude < disparity*largest)
   end subroutine velocities

   !> Multiplies [P] by [P_i] from the left; the first flight sets [P] = [P_1].
   pure subroutine advance(plan, n, i, r, x, flight, p, clear)
      !> Data that all points share.
      type(plan_type), intent(in) :: plan
      !> Number of impacts, and of the flight.
      integer, intent(in) :: n, i
      !> Frequency ratio, solution, and all flights.
      real(wp), intent(in) :: r(lanes), x(lanes, n + 2), flight(lanes, 7, n)
      !> In: the product of the maps of flights 1 to i - 1. Out: that of flights 1 to i.
      real(wp), intent(inout) :: p(lanes, 4, 4)
      !> Approach speed over the size of its terms: small where digits cancel.
      real(wp), intent(out) :: clear(lanes)
      real(wp), dimension(lanes, 4) :: t, u, v
      integer :: j, l, next, previous

      next = modulo(i, n) + 1
      previous = modulo(i - 2, n) + 1
      call rows(plan, r, x(:, i), x(:, n + 1:), flight(:, :, i), flight(:, 3:4, next), &
         plan%x_dot_after(1, i)*flight(:, 7, previous) + plan%x_dot_after(2, i)*flight(:, 7, i), &
         t, u, v, clear)
      associate (k => plan%x_row(:, next), q => plan%z_row(:, next))
         if (i == 1) then
            do j = 1, 4
               p(:, 1, j) = u(:, j)
               p(:, 2, j) = k(1)*v(:, j)
               p(:, 3, j) = q(1)*v(:, j)
               p(:, 4, j) = t(:, j)
            end do
            p(:, 2, 3) = p(:, 2, 3) + k(2)
            p(:, 3, 3) = p(:, 3, 3) + q(2)
            return
         end if
         do j = 1, 4
            do l = 1, lanes
               block
                  real(wp) :: p1, p2, p3, p4, rise
                  p1 = p(l, 1, j)
                  p2 = p(l, 2, j)
                  p3 = p(l, 3, j)
                  p4 = p(l, 4, j)
                  p(l, 1, j) = u(l, 1)*p1 + u(l, 2)*p2 + u(l, 3)*p3 + u(l, 4)*p4
                  rise = v(l, 1)*p1 + v(l, 2)*p2 + v(l, 3)*p3 + v(l, 4)*p4
                  p(l, 2, j) = k(1)*rise + k(2)*p3
                  p(l, 3, j) = q(1)*rise + q(2)*p3
                  p(l, 4, j) = t(l, 1)*p1 + t(l, 2)*p2 + t(l, 3)*p3 + t(l, 4)*p4
               end block
            end do
         end do
      end associate
   end subroutine advance

   !> Derivatives of the next phase, of x and of x' just before the next impact: (A6), (A7).
   pure subroutine rows(plan, r, x, forced, flight, ahead, x_dot, t, u, v, clear)
      !> Data that all points share; xi and eta are read.
      type(plan_type), intent(in) :: plan
      !> Frequency ratio; x_i; A cos(tau), A sin(tau); the flight; sine and cosine of the phase of
      !! the impact that ends it; x' just after impact i.
      real(wp), intent(in) :: r(lanes), x(lanes), forced(lanes, 2), flight(lanes, 7), &
         ahead(lanes, 2), x_dot(lanes)
      !> Derivatives of the next phase, and of x and x' there, with respect to (x, x', z', alpha) of
      !! impact i.
      real(wp), intent(out), dimension(lanes, 4) :: t, u, v
      !> Approach speed over the size of its terms: small where digits cancel.
      real(wp), intent(out) :: clear(lanes)
      real(wp) :: h, xi, inverse, per_r, c1, c2, c3, c4, sine, cosine, sine_next, cosine_next
      real(wp) :: b, free_dot, s1, s2, s4, s5, s6, s12, s13, s14, z, share
      integer :: l

      h = plan%frequency
      xi = plan%xi
      inverse = 1/h
      do l = 1, lanes
         per_r = 1/r(l)
         c1 = flight(l, 1)
         c2 = flight(l, 2)
         c3 = h*c2 - xi*c1                                                                ! (A4)
         c4 = -(h*c1 + xi*c2)
         sine = flight(l, 3)*forced(l, 1) + flight(l, 4)*forced(l, 2)
         cosine = flight(l, 4)*forced(l, 1) - flight(l, 3)*forced(l, 2)
         sine_next = ahead(l, 1)*forced(l, 1) + ahead(l, 2)*forced(l, 2)
         cosine_next = ahead(l, 2)*forced(l, 1) - ahead(l, 1)*forced(l, 2)
         b = x(l) - sine                                                                  ! (6)
         free_dot = x_dot(l) - r(l)*cosine
         s1 = xi*c1*inverse + c2                                                          ! (A6)
         s2 = c1*inverse
         s4 = c3*inverse
         s6 = (free_dot*s4 - b*s2)*per_r
         z = flight(l, 7)*per_r
         s5 = z - cosine_next - s6
         clear(l) = abs(s5)/(((1 + abs(x(l)))*flight(l, 6) + abs(free_dot*s4) + abs(b*s2))*per_r &
            + abs(forced(l, 1)) + abs(forced(l, 2)))
         share = 1/s5
         s12 = cosine_next + s6
         s13 = ((h*c4 - xi*c3)*free_dot - b*c3)*(per_r*inverse)
         s14 = s13 - r(l)*sine_next
         u(l, 4) = r(l)*s2*sine - s1*cosine - s6
         v(l, 4) = s2*cosine + r(l)*s4*sine - s13
         t(l, 1) = (s1 - 1)*share                                                         ! (A7)
         t(l, 2) = s2*share
         t(l, 3) = -flight(l, 5)*share
         t(l, 4) = (u(l, 4) + z)*share
         u(l, 1) = s1 + s12*t(l, 1)
         u(l, 2) = s2 + s12*t(l, 2)
         u(l, 3) = s12*t(l, 3)
         u(l, 4) = u(l, 4) + s12*t(l, 4)
         v(l, 1) = s14*t(l, 1) - s2
         v(l, 2) = s14*t(l, 2) + s4
         v(l, 3) = s14*t(l, 3)
         v(l, 4) = v(l, 4) + s14*t(l, 4)
      end do
   end subroutine rows

end module vi_lane_motion
