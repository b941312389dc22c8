!> The spectra of 4 x 4 matrices, one matrix per lane: whether they lie inside the unit circle, and
!! the spectral radii.
module vi_lane_spectrum
   use vi_kinds, only: wp
   use vi_plan, only: lanes
   implicit none (type, external)
   private

   integer, parameter :: long = selected_int_kind(18)

   public :: lane_circle, lane_polynomial, lane_radius

   !> Safety factor on estimates of rounding errors before a verdict is given.
   real(wp), parameter :: caution = 100.0_wp

   !> A determinant whose error exceeds this times its terms is left to the audit of vi_law.
   real(wp), parameter, public :: audit = 1000*epsilon(1.0_wp)

contains

   !> The elementary symmetric functions of the eigenvalues, as in `characteristic`, and the largest
   !! entry of each matrix, with the last variable scaled so that its row and its column have equal
   !! largest entries; the eigenvalues do not depend on this scaling.
   pure subroutine lane_polynomial(p, e, largest, terms)
      !> One matrix per lane, p(lane, row, column).
      real(wp), intent(in) :: p(lanes, 4, 4)
      !> e(lane, i): e_1 to e_4; largest(lane): largest absolute entry, row and column 4 scaled as
      !! described.
      real(wp), intent(out) :: e(lanes, 4), largest(lanes)
      !> Sum of the moduli of the terms of e_4.
      real(wp), intent(out) :: terms(lanes)
      real(wp), dimension(lanes) :: row, column
      real(wp) :: m12, m13, m14, m23, m24, m34, n12, n13, n14, n23, n24, n34
      integer :: i, j, l

      do l = 1, lanes
         ! 2 x 2 minors of rows 1, 2 and of rows 3, 4
         m12 = p(l, 1, 1)*p(l, 2, 2) - p(l, 1, 2)*p(l, 2, 1)
         m13 = p(l, 1, 1)*p(l, 2, 3) - p(l, 1, 3)*p(l, 2, 1)
         m14 = p(l, 1, 1)*p(l, 2, 4) - p(l, 1, 4)*p(l, 2, 1)
         m23 = p(l, 1, 2)*p(l, 2, 3) - p(l, 1, 3)*p(l, 2, 2)
         m24 = p(l, 1, 2)*p(l, 2, 4) - p(l, 1, 4)*p(l, 2, 2)
         m34 = p(l, 1, 3)*p(l, 2, 4) - p(l, 1, 4)*p(l, 2, 3)
         n12 = p(l, 3, 1)*p(l, 4, 2) - p(l, 3, 2)*p(l, 4, 1)
         n13 = p(l, 3, 1)*p(l, 4, 3) - p(l, 3, 3)*p(l, 4, 1)
         n14 = p(l, 3, 1)*p(l, 4, 4) - p(l, 3, 4)*p(l, 4, 1)
         n23 = p(l, 3, 2)*p(l, 4, 3) - p(l, 3, 3)*p(l, 4, 2)
         n24 = p(l, 3, 2)*p(l, 4, 4) - p(l, 3, 4)*p(l, 4, 2)
         n34 = p(l, 3, 3)*p(l, 4, 4) - p(l, 3, 4)*p(l, 4, 3)
         e(l, 1) = p(l, 1, 1) + p(l, 2, 2) + p(l, 3, 3) + p(l, 4, 4)
         e(l, 2) = m12 + n34 + (p(l, 1, 1) + p(l, 2, 2))*(p(l, 3, 3) + p(l, 4, 4)) &
            - p(l, 1, 3)*p(l, 3, 1) - p(l, 1, 4)*p(l, 4, 1) - p(l, 2, 3)*p(l, 3, 2) &
            - p(l, 2, 4)*p(l, 4, 2)
         e(l, 3) = (p(l, 3, 3) + p(l, 4, 4))*m12 - p(l, 3, 2)*m13 + p(l, 3, 1)*m23 &
            - p(l, 4, 2)*m14 + p(l, 4, 1)*m24 + (p(l, 1, 1) + p(l, 2, 2))*n34 - p(l, 1, 3)*n14 &
            + p(l, 1, 4)*n13 - p(l, 2, 3)*n24 + p(l, 2, 4)*n23
         e(l, 4) = m12*n34 - m13*n24 + m14*n23 + m23*n14 - m24*n13 + m34*n12
         terms(l) = abs(m12*n34) + abs(m13*n24) + abs(m14*n23) + abs(m23*n14) + abs(m24*n13) &
            + abs(m34*n12)
      end do
      row = 0
      column = 0
      largest = abs(p(:, 4, 4))
      do j = 1, 3
         row = max(row, abs(p(:, 4, j)))
         column = max(column, abs(p(:, j, 4)))
         do i = 1, 3
            largest = max(largest, abs(p(:, i, j)))
         end do
      end do
      largest = max(largest, sqrt(row*column))
   end subroutine lane_polynomial

   !> The least of Jury's conditions for all eigenvalues to lie inside the unit circle: positive
   !! inside, negative outside.
   pure subroutine lane_circle(e, largest, least, noise)
      !> As from `lane_polynomial`.
      real(wp), intent(in) :: e(lanes, 4), largest(lanes)
      !> Least condition of each lane, and the error that rounding may cause in it if the entries of
      !! the matrix are accurate to rounding.
      real(wp), intent(out) :: least(lanes), noise(lanes)
      real(wp) :: a1, a2, a3, a4, d
      integer :: l

      do l = 1, lanes
         a1 = e(l, 1)
         a2 = e(l, 2)
         a3 = e(l, 3)
         a4 = e(l, 4)
         d = 1 + a4
         ! the last one is the product of all 1 - lambda_i lambda_j, i < j
         least(l) = min(1 - abs(a4), (d + a2) - abs(a1 + a3), (1 - a4)*d - abs(a3 - a1*a4), &
            ((d - a2)*d + a1*a3 - 4*a4)*d - (a1*a1*a4 - 4*a2*a4 + a3*a3))
         noise(l) = caution*epsilon(1.0_wp)*max(largest(l), 1.0_wp)**3 &
            *(1 + abs(a1) + abs(a2) + abs(a3))
      end do
   end subroutine lane_circle

   !> The largest modulus of the zeros of x^4 - e1 x^3 + e2 x^2 - e3 x + e4, from its factors x^2 +
   !! a x + b and x^2 + c x + d.
   pure subroutine lane_radius(e, radius, slope)
      !> e(lane, i): e_1 to e_4 from `lane_polynomial`.
      real(wp), intent(in) :: e(lanes, 4)
      !> Largest modulus of a zero in each lane.
      real(wp), intent(out) :: radius(lanes)
      !> Modulus of the polynomial's derivative at that zero: small where zeros nearly coincide, and
      !! 0 where the iteration has not settled.
      real(wp), intent(out) :: slope(lanes)
      real(wp), dimension(lanes) :: a, b, sum
      !> Largest relative change of the factor by a further iteration.
      real(wp), parameter :: settled = 1.0e-13_wp
      real(wp) :: c, d, g, h, r0, r1, rest(2), determinant, first, second, other, spread, apart
      integer :: l, turn

      call largest_resolvent(e, sum)
      call split(e, sum, a, b)
      do turn = 1, 2
         do l = 1, lanes                     ! Bairstow's iteration
            c = -e(l, 1) - a(l)
            d = e(l, 2) - b(l) - a(l)*c
            r1 = -e(l, 3) - a(l)*d - b(l)*c
            r0 = e(l, 4) - b(l)*d
            g = a(l) - c
            h = b(l) - d
            determinant = 1/(h*(h - a(l)*g) + b(l)*g*g)
            c = (h*r1 - g*r0)*determinant
            b(l) = b(l) - ((h - a(l)*g)*r0 + b(l)*g*r1)*determinant
            a(l) = a(l) - c
         end do
      end do
      do l = 1, lanes
         c = -e(l, 1) - a(l)
         d = e(l, 2) - b(l) - a(l)*c
         g = a(l) - c
         h = b(l) - d
         determinant = h*(h - a(l)*g) + b(l)*g*g
         r1 = -e(l, 3) - a(l)*d - b(l)*c
         r0 = e(l, 4) - b(l)*d
         rest(1) = abs(h*r1 - g*r0)
         rest(2) = abs((h - a(l)*g)*r0 + b(l)*g*r1)
         spread = 0.25_wp*a(l)*a(l) - b(l)
         apart = 0.25_wp*c*c - d
         first = merge(0.5_wp*abs(a(l)) + sqrt(abs(spread)), sqrt(abs(b(l))), spread > 0)
         second = merge(0.5_wp*abs(c) + sqrt(abs(apart)), sqrt(abs(d)), apart > 0)
         radius(l) = max(first, second)
         if (second > first) then
            spread = apart
            other = -sign(second, c)
            other = other*(other + a(l)) + b(l)
         else
            other = -sign(first, a(l))
            other = other*(other + c) + d
         end if
         ! the other factor has the same modulus at both zeros of a complex pair
         other = merge(other*other, determinant, spread > 0)
         slope(l) = 2*sqrt(abs(spread*other))
         if (.not. rest(1)*radius(l) + rest(2) < settled*abs(determinant)*radius(l)**2) slope(l) = 0
      end do
   end subroutine lane_radius

   !> The largest real zero of the resolvent cubic, b + d.
   pure subroutine largest_resolvent(e, sum)
      !> e(lane, i): e_1 to e_4.
      real(wp), intent(in) :: e(lanes, 4)
      !> b + d of each lane.
      real(wp), intent(out) :: sum(lanes)
      !> Number of Halley iterations from outside; each triples the number of correct digits.
      integer, parameter :: iterations = 5
      real(wp), parameter :: third = 1/3.0_wp
      real(wp), dimension(lanes) :: p, q
      real(wp) :: t, f, slope
      integer(long) :: bits
      integer :: l, i

      do l = 1, lanes
         f = e(l, 1)*e(l, 3) - 4*e(l, 4)
         p(l) = f - third*e(l, 2)**2
         q(l) = third*e(l, 2)*(f - 2*third*third*e(l, 2)**2) - (e(l, 1)**2*e(l, 4) &
            - 4*e(l, 2)*e(l, 4) + e(l, 3)**2)
         ! a third of the exponent gives the cube root, at most 6 % too small
         bits = transfer(abs(q(l)), bits)/3 + 3071306043645493248_long
         sum(l) = sqrt(abs(p(l))) + 1.07_wp*transfer(bits, t)
      end do
      do l = 1, lanes
         ! where there is only one real zero, its sign is that of -q
         if (4*p(l)**3 + 27*q(l)**2 > 0 .and. q(l) > 0) sum(l) = -sum(l)
      end do
      do i = 1, iterations
         do l = 1, lanes
            t = sum(l)
            f = (t*t + p(l))*t + q(l)
            slope = 3*t*t + p(l)
            sum(l) = t - f*slope/(slope*slope - 3*f*t)
         end do
      end do
      sum = sum + third*e(:, 2)
   end subroutine largest_resolvent

   !> The coefficients a and b of the factor x^2 + a x + b, |b| >= |d|, from b + d.
   pure subroutine split(e, sum, a, b)
      !> e(lane, i): e_1 to e_4, and b + d of each lane.
      real(wp), intent(in) :: e(lanes, 4), sum(lanes)
      !> Coefficients of the factor in each lane.
      real(wp), intent(out) :: a(lanes), b(lanes)
      real(wp) :: gap, root, product, d
      integer :: l

      do l = 1, lanes
         gap = sum(l)**2 - 4*e(l, 4)
         root = sign(sqrt(max(gap, 0.0_wp)), sum(l))
         b(l) = 0.5_wp*(sum(l) + root)
         d = e(l, 4)/b(l)
         root = b(l) - d
         product = 2*e(l, 3) - e(l, 1)*sum(l)                    ! (a - c)(b - d)
         gap = merge(product/root, sign(sqrt(abs(e(l, 1)**2 - 4*(e(l, 2) - sum(l)))), &
            product*root), gap > 1.0e-3_wp*sum(l)**2)
         a(l) = 0.5_wp*(gap - e(l, 1))
      end do
   end subroutine split

end module vi_lane_spectrum
