!> Products of dense matrices with vectors, and flights of pairs, for structures.
!!
!! The loops over rows and over pairs are for vector instructions. Sums are taken in a fixed order,
!! so that the results do not depend on the instructions.
module vi_lane_rows
   use vi_kinds, only: wp
   use vi_lanes, only: largest_exponent, shrinkage, sines_cosines
   use vi_plan, only: lanes
   implicit none (type, external)
   private

   public :: add_product, add_products, advance_pairs, mark_doubts, start_free_series, &
      start_series, step_pairs, subtract

   !> Pairs that are summed side by side; lists of pairs are filled up to a multiple of it.
   integer, parameter, public :: side_by_side = 4

contains

   !> y = y + a x.
   pure subroutine add_product(n, m, a, x, y)
      !> Rows and columns.
      integer, intent(in) :: n, m
      !> The matrix, and x (m).
      real(wp), intent(in) :: a(n, m), x(m)
      !> (n)
      real(wp), intent(inout) :: y(n)
      integer :: i, k

      do k = 1, m - 3, 4
         do i = 1, n
            y(i) = y(i) + ((a(i, k)*x(k) + a(i, k + 1)*x(k + 1)) &
               + (a(i, k + 2)*x(k + 2) + a(i, k + 3)*x(k + 3)))
         end do
      end do
      do k = m - mod(m, 4) + 1, m
         do i = 1, n
            y(i) = y(i) + a(i, k)*x(k)
         end do
      end do
   end subroutine add_product

   !> y = y + a x and z = z + a v.
   pure subroutine add_products(n, m, a, x, v, y, z)
      !> Rows and columns.
      integer, intent(in) :: n, m
      !> The matrix, and x and v (m).
      real(wp), intent(in) :: a(n, m), x(m), v(m)
      !> (n)
      real(wp), intent(inout) :: y(n), z(n)
      integer :: i, k

      do k = 1, m - 3, 4
         do i = 1, n
            y(i) = y(i) + ((a(i, k)*x(k) + a(i, k + 1)*x(k + 1)) &
               + (a(i, k + 2)*x(k + 2) + a(i, k + 3)*x(k + 3)))
            z(i) = z(i) + ((a(i, k)*v(k) + a(i, k + 1)*v(k + 1)) &
               + (a(i, k + 2)*v(k + 2) + a(i, k + 3)*v(k + 3)))
         end do
      end do
      do k = m - mod(m, 4) + 1, m
         do i = 1, n
            y(i) = y(i) + a(i, k)*x(k)
            z(i) = z(i) + a(i, k)*v(k)
         end do
      end do
   end subroutine add_products

   !> Pairs without constant terms after a given time: free masses, and oscillations with damping
   !! below the critical one.
   pure subroutine advance_pairs(n, turning, damps, t, turn, damping, stiffness, x, v, x_new, &
      v_new)
      !> Number of pairs, and of those up to the last one that is no free mass; whether any is
      !! damped.
      integer, intent(in) :: n, turning
      logical, intent(in) :: damps
      !> The time, at most `largest_angle` over the largest frequency.
      real(wp), intent(in) :: t
      !> (n) sqrt(omega^2 - sigma^2), sigma and omega^2; all 0 for a free mass.
      real(wp), intent(in) :: turn(n), damping(n), stiffness(n)
      !> (n) The pairs at the start.
      real(wp), intent(in) :: x(n), v(n)
      !> (n) After that time.
      real(wp), intent(out) :: x_new(n), v_new(n)
      real(wp), dimension(lanes) :: angle, exponent, sine, cosine, shrink, turned, w
      real(wp) :: u
      integer :: j, k, m

      angle = 0
      exponent = 0
      shrink = 1
      do k = 0, turning - 1, lanes
         m = min(lanes, turning - k)
         do j = 1, m
            angle(j) = turn(k + j)*t
         end do
         ! as many as fill registers
         call sines_cosines(side_by_side*((m + side_by_side - 1)/side_by_side), angle, sine, cosine)
         if (damps) then
            do j = 1, m
               exponent(j) = min(damping(k + j)*t, largest_exponent)
            end do
            call shrinkage(exponent, shrink)
         end if
         ! factors of 0 and 1: after a choice each pair would be divided alone; the smallest number
         ! changes no quotient that is used
         do j = 1, m
            turned(j) = merge(1.0_wp, 0.0_wp, angle(j) > 1.0e-8_wp)
         end do
         do j = 1, m
            w(j) = turned(j)*(sine(j)/(turn(k + j) + tiny(u))) + (1 - turned(j))*t
         end do
         if (.not. damps) then
            do j = 1, m
               x_new(k + j) = cosine(j)*x(k + j) + w(j)*v(k + j)
               v_new(k + j) = cosine(j)*v(k + j) - stiffness(k + j)*w(j)*x(k + j)
            end do
            cycle
         end if
         do j = 1, m
            u = shrink(j)*(cosine(j) + damping(k + j)*w(j))
            w(j) = shrink(j)*w(j)
            x_new(k + j) = u*x(k + j) + w(j)*v(k + j)
            v_new(k + j) = (u - 2*damping(k + j)*w(j))*v(k + j) - stiffness(k + j)*w(j)*x(k + j)
         end do
      end do
      do k = turning + 1, n
         x_new(k) = x(k) + t*v(k)
         v_new(k) = v(k)
      end do
   end subroutine advance_pairs

   !> x = x - factor a.
   pure subroutine subtract(n, factor, a, x)
      !> Number of entries.
      integer, intent(in) :: n
      !> The factor, and a.
      real(wp), intent(in) :: factor, a(n)
      !> In and out: x.
      real(wp), intent(inout) :: x(n)
      integer :: i

      do i = 1, n
         x(i) = x(i) - factor*a(i)
      end do
   end subroutine subtract

   !> A sum over pairs and its derivative without constants, in the order of the pairs, and the sum
   !! of the moduli of the terms of the former; the first derivatives of the pairs.
   pure subroutine start_series(n, m, run, t, touched, stiffness, damping, drift, drift_rate, &
      force, force_rate, of_x, of_v, x0, v0, x, v, terms, total, sizes)
      !> Number of pairs that occur, a multiple of `side_by_side`; of all pairs; and of the first
      !! ones that occur with numbers that follow each other.
      integer, intent(in) :: n, m, run
      !> The time since the constant terms had their values.
      real(wp), intent(in) :: t
      !> (n) The numbers of the pairs.
      integer, intent(in) :: touched(n)
      !> (m) As in `modes_type` of vi_modes.
      real(wp), dimension(m), intent(in) :: stiffness, damping, drift, drift_rate, force, force_rate
      !> (n) Factors of x and v.
      real(wp), intent(in) :: of_x(n), of_v(n)
      !> (m) The pairs.
      real(wp), intent(in) :: x0(m), v0(m)
      !> (n) The first derivatives.
      real(wp), intent(out) :: x(n), v(n)
      !> Room.
      real(wp), intent(out) :: terms(n, 4)
      !> In and out: the sums are added to these.
      real(wp), intent(inout) :: total(2), sizes
      real(wp) :: part(0:side_by_side - 1)
      integer :: first, j, k

      ! pairs that follow each other need no list: most do
      first = touched(1) - 1
      do j = 1, run
         terms(j, 3) = of_x(j)*x0(first + j)
         terms(j, 4) = of_v(j)*v0(first + j)
         x(j) = v0(first + j) + drift(first + j) + t*drift_rate(first + j)
         v(j) = -stiffness(first + j)*x0(first + j) - 2*damping(first + j)*v0(first + j) &
            + force(first + j) + t*force_rate(first + j)
         terms(j, 1) = terms(j, 3) + terms(j, 4)
         terms(j, 2) = of_x(j)*x(j) + of_v(j)*v(j)
      end do
      do j = run + 1, n
         k = touched(j)
         terms(j, 3) = of_x(j)*x0(k)
         terms(j, 4) = of_v(j)*v0(k)
         x(j) = v0(k) + drift(k) + t*drift_rate(k)
         v(j) = -stiffness(k)*x0(k) - 2*damping(k)*v0(k) + force(k) + t*force_rate(k)
         terms(j, 1) = terms(j, 3) + terms(j, 4)
         terms(j, 2) = of_x(j)*x(j) + of_v(j)*v(j)
      end do
      part = 0
      do j = 1, n, side_by_side
         do k = 0, side_by_side - 1
            total(1) = total(1) + terms(j + k, 1)
            total(2) = total(2) + terms(j + k, 2)
            part(k) = part(k) + (abs(terms(j + k, 3)) + abs(terms(j + k, 4)))
         end do
      end do
      sizes = sizes + ((part(0) + part(1)) + (part(2) + part(3)))
   end subroutine start_series

   !> `start_series` of pairs without damping and constant terms, of which v does not occur, with
   !! the same bits.
   pure subroutine start_free_series(n, m, run, touched, stiffness, of_x, x0, v0, x, v, terms, &
      total, sizes)
      !> As in `start_series`.
      integer, intent(in) :: n, m, run, touched(n)
      real(wp), intent(in) :: stiffness(m), of_x(n), x0(m), v0(m)
      real(wp), intent(out) :: x(n), v(n), terms(n, 2)
      real(wp), intent(inout) :: total(2), sizes
      real(wp) :: part(0:side_by_side - 1)
      integer :: first, j, k

      first = touched(1) - 1
      do j = 1, run
         x(j) = v0(first + j)
         v(j) = -stiffness(first + j)*x0(first + j)
         terms(j, 1) = of_x(j)*x0(first + j)
         terms(j, 2) = of_x(j)*v0(first + j)
      end do
      do j = run + 1, n
         k = touched(j)
         x(j) = v0(k)
         v(j) = -stiffness(k)*x0(k)
         terms(j, 1) = of_x(j)*x0(k)
         terms(j, 2) = of_x(j)*v0(k)
      end do
      part = 0
      do j = 1, n, side_by_side
         do k = 0, side_by_side - 1
            total(1) = total(1) + terms(j + k, 1)
            total(2) = total(2) + terms(j + k, 2)
            part(k) = part(k) + abs(terms(j + k, 1))
         end do
      end do
      sizes = sizes + ((part(0) + part(1)) + (part(2) + part(3)))
   end subroutine start_free_series

   !> The pairs after a step.
   pure subroutine step_pairs(n, map, x, v, x_new, v_new)
      !> Number of pairs.
      integer, intent(in) :: n
      !> The table of the step, as in `steps_type` of vi_modes.
      real(wp), intent(in) :: map(n, 6)
      !> The pairs before it.
      real(wp), intent(in) :: x(n), v(n)
      !> The pairs after it.
      real(wp), intent(out) :: x_new(n), v_new(n)
      integer :: k

      do k = 1, n
         x_new(k) = map(k, 1)*x(k) + map(k, 2)*v(k) + map(k, 3)
         v_new(k) = map(k, 4)*x(k) + map(k, 5)*v(k) + map(k, 6)
      end do
   end subroutine step_pairs

   !> Which rows are not proved to stay within their limits over a cell, by the Bernstein
   !! coefficients of their cubic Hermite interpolations and a bound on their fourth derivatives.
   pure subroutine mark_doubts(n, h, y, rate, y_next, rate_next, bound, reserve, upper, lower, &
      above, below)
      !> Number of rows, and length of the cell.
      integer, intent(in) :: n
      real(wp), intent(in) :: h
      !> (n) Values and rates at its ends.
      real(wp), dimension(n), intent(in) :: y, rate, y_next, rate_next
      !> (n) Bounds on the fourth derivatives and on the rounding errors; the limits.
      real(wp), dimension(n), intent(in) :: bound, reserve, upper, lower
      !> (n) 0 where the upper or the lower limit is not reached, else 1.
      real(wp), dimension(n), intent(out) :: above, below
      real(wp) :: second, third, fourth, middle, top, bottom, quarter, sixth, sag
      integer :: i

      quarter = 0.25_wp*h
      sixth = h/6
      sag = (h*h)**2/144
      do i = 1, n
         top = upper(i) - reserve(i)
         bottom = lower(i) + reserve(i)
         second = y(i) + quarter*rate(i)
         third = 0.5_wp*(y(i) + y_next(i)) + sixth*(rate(i) - rate_next(i))
         middle = sag*bound(i)
         fourth = y_next(i) - quarter*rate_next(i)
         ! written so that a NaN counts as reached
         above(i) = merge(0.0_wp, 1.0_wp, y(i) < top .and. second < top &
            .and. third + middle < top .and. fourth < top .and. y_next(i) < top)
         below(i) = merge(0.0_wp, 1.0_wp, y(i) > bottom .and. second > bottom &
            .and. third - middle > bottom .and. fourth > bottom .and. y_next(i) > bottom)
      end do
   end subroutine mark_doubts

end module vi_lane_rows
