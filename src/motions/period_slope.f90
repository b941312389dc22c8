!> The gradient of a number that depends on the multipliers, without difference quotients.
!!
!! The derivatives of the number with respect to the entries of the map of the period are called
!! weights here. The chain rule is applied backwards: from the weights of the whole product to those
!! of each [P_i], and from these through (A5)-(A7) to the unknowns and parameters.
module vi_period_slope
   use vi_kinds, only: wp
   use vi_orbit, only: by_clearance, by_forced, by_left, by_mu, by_r, by_right, by_speed, &
      by_time, by_velocity, by_xi, most_impacts, orbit_type, transfer_by_xi
   implicit none (type, external)
   private

   public :: add_part_slope, add_period_slope

contains

   !> Adds the effect of the map of the period to a gradient with respect to u_i, theta_i and the
   !! parameters that are varied.
   pure subroutine add_period_slope(o, parts, weights, slope)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> All [P_i].
      real(wp), intent(in) :: parts(4, 4, most_impacts)
      !> Derivatives of the number with respect to the entries of the map of the period.
      real(wp), intent(in) :: weights(4, 4)
      !> (at least 2n + o%varied) In and out: gradient with respect to u_i, theta_i, parameters.
      real(wp), contiguous, intent(inout) :: slope(:)
      real(wp) :: w(4, 4), before(4, 4, most_impacts)
      integer :: i

      w(:3, :) = o%sign*weights(:3, :)
      w(4, :) = weights(4, :)
      do i = 2, o%n
         if (i == 2) before(:, :, i) = parts(:, :, 1)
         if (i > 2) before(:, :, i) = matmul(parts(:, :, i - 1), before(:, :, i - 1))
      end do
      do i = o%n, 1, -1
         if (i > 1) then
            call add_part_slope(o, i, parts(:, :, i), matmul(w, transpose(before(:, :, i))), slope)
            w = matmul(transpose(parts(:, :, i)), w)
         else
            call add_part_slope(o, i, parts(:, :, i), w, slope)
         end if
      end do
   end subroutine add_period_slope

   !> Adds the effect of [P_i] to a gradient.
   !!
   !! The fourth row is (S_1 - 1, S_2, -time, ..)/S_5; the first one and the change of x' just
   !! before the impact are rows of S_1 to S_4 plus S_12 and S_14 times it.
   pure subroutine add_part_slope(o, i, p, w, slope)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> Number of the flight, 1 to n.
      integer, intent(in) :: i
      !> [P_i] and the weights of its entries.
      real(wp), intent(in) :: p(4, 4), w(4, 4)
      !> (at least 2n + o%varied) In and out: gradient with respect to u_i, theta_i, parameters.
      real(wp), contiguous, intent(inout) :: slope(:)
      real(wp), dimension(4) :: v, last, row, w_s, w_k, d, arrival
      real(wp), dimension(2) :: f, g, m, w_f, w_g
      real(wp) :: x, v_free, s5, s6, s13, s15, r, w5, w6, w13, w15, w_r, w_speed, w_time
      integer :: wall

      r = o%r
      f = [o%forced(i), o%forced(i + 1)]
      g = [o%forced_dot(i), o%forced_dot(i + 1)]/r
      x = o%u(i) - f(1)
      v_free = o%after(i) - r*g(1)
      associate (s => o%s(:, i), rest => o%restitution(i + 1), mu => o%mu)
         s15 = -s(2) - 2*o%xi*s(4)
         s6 = (x*s(3) + v_free*s(4))/r
         s5 = o%speed(i)/r - g(2) - s6
         s13 = (s15*v_free - x*s(4))/r
         ! rows 2 and 3 share the change of x' just before the impact
         v = ((1 - mu*rest)*w(2, :) + (1 + rest)*w(3, :))/(1 + mu)
         last = w(4, :) + (g(2) + s6)*w(1, :) + (s13 - r*f(2))*v
         row = last/s5
         ! S_5, S_12 = g2 + S_6 and S_14 = S_13 - r f2
         w5 = -dot_product(row, p(4, :))
         w_g(2) = dot_product(w(1, :), p(4, :)) - w5
         w6 = w_g(2) - w(1, 4) - row(4)
         w13 = dot_product(v, p(4, :))
         w_f(2) = -r*w13
         w_r = -f(2)*w13
         w13 = w13 - v(4)
         w_speed = (w5 + row(4))/r
         w_time = -row(3)
         ! S_1 to S_4 in the rows, and -S g1 + r S' f1 at their ends
         m = [w(1, 4) + row(4), v(4)]
         w_s = [w(1, 1:2) + row(1:2), v(1:2)] + [-g(1)*m(1), r*f(1)*m(1), -g(1)*m(2), r*f(1)*m(2)]
         w_g(1) = -s(1)*m(1) - s(3)*m(2)
         w_f(1) = r*(s(2)*m(1) + s(4)*m(2))
         ! S_6 and S_13
         w_s(3) = w_s(3) + x*w6/r
         w_s(4) = w_s(4) + (v_free*w6 - x*w13)/r
         w15 = v_free*w13/r
         w_r = w_r + (f(1)*w_f(1) - s6*w6 - s13*w13 - o%speed(i)*w_speed - dot_product(g, w_g))/r
         ! the derivatives of S_1 to S_4 with respect to time
         w_time = w_time + w_s(1)*s(3) + w_s(2)*s(4) - w_s(3)*(s(1) + 2*o%xi*s(3)) &
            + (w_s(4) - 2*o%xi*w15)*s15 - w15*s(4)
         ! the free part of x and x'
         m = [s(3)*w6 - s(4)*w13, s(4)*w6 + s15*w13]/r
         if (o%varied > by_clearance) then
            d = transfer_by_xi(o, i, o%time(i))
            slope(2*o%n + by_xi) = slope(2*o%n + by_xi) + dot_product(w_s, d) &
               - w15*(d(2) + 2*s(4) + 2*o%xi*d(4))
            ! k_1 .. k_4 of (A5); row 3 less k_4 is k_3 times the change of x' before the impact
            arrival = p(3, :)*(1 + mu)/(1 + rest)
            arrival(3) = arrival(3) - (mu - rest)/(1 + rest)
            w_k = [dot_product(w(2, :), arrival), w(2, 3), dot_product(w(3, :), arrival), w(3, 3)]
            slope(2*o%n + by_mu) = slope(2*o%n + by_mu) + (1 + rest)/(1 + mu)**2 &
               *(w_k(2) + w_k(4) - w_k(1) - w_k(3))
            wall = 2*o%n + merge(by_right, by_left, o%side(i + 1) > 0)
            slope(wall) = slope(wall) + (mu*(w_k(2) - w_k(1)) + w_k(3) - w_k(4))/(1 + mu)
         end if
      end associate
      slope(i) = slope(i) + m(1)
      slope(2*o%n + by_r) = slope(2*o%n + by_r) + w_r
      call by_time(o, i, w_time, slope)
      call by_speed(o, i, w_speed, slope)
      call by_velocity(o, i, m(2), 0.0_wp, slope)
      call by_forced(o, i, w_f(1) - m(1), w_g(1)/r - m(2), slope)
      call by_forced(o, i + 1, w_f(2), w_g(2)/r, slope)
   end subroutine add_part_slope

end module vi_period_slope
