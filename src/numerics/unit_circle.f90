!> Whether the eigenvalues of a 4 x 4 matrix lie inside the unit circle, without computing them.
module vi_unit_circle
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: locate_spectrum

   !> Answers of `locate_spectrum`.
   integer, parameter, public :: all_inside = 1, some_outside = 0, near_circle = -1

   !> With entries below `large`, rounding changes a coefficient of the polynomial by far less than
   !! the margin; with entries below `huge_entry` it changes the trace by less than the margin.
   real(wp), parameter :: large = 50, huge_entry = 1.0e8_wp, margin = 1.0e-6_wp

contains

   !> Schur-Cohn test of the characteristic polynomial; `near_circle` where it cannot decide.
   pure integer function locate_spectrum(a) result(place)
      !> The matrix.
      real(wp), intent(in) :: a(4, 4)
      real(wp) :: c(0:4), k, largest
      integer :: n

      place = near_circle
      largest = maxval(abs(a))
      if (largest < huge_entry .and. abs(a(1, 1) + a(2, 2) + a(3, 3) + a(4, &
         4)) > 4 + margin) place = some_outside
      if (place == some_outside .or. .not. largest < large) return
      c = characteristic_polynomial(a)
      do n = 4, 1, -1
         ! the product of the zeros of a polynomial of degree n with leading coefficient 1
         k = c(0)
         if (abs(abs(k) - 1) < margin) return
         if (abs(k) > 1) then
            place = some_outside
            return
         end if
         ! the next polynomial has one zero fewer inside the circle
         c(0:n - 1) = (c(1:n) - k*c(n - 1:0:-1))/((1 - k)*(1 + k))
      end do
      place = all_inside
   end function locate_spectrum

   !> Coefficients of det(lambda - a), constant term first, from the minors of the first two and the
   !! last two rows.
   pure function characteristic_polynomial(a) result(c)
      !> The matrix.
      real(wp), intent(in) :: a(4, 4)
      real(wp) :: c(0:4), s(6), t(6)

      s = minors(a(1, :), a(2, :))
      t = minors(a(3, :), a(4, :))
      c(3:) = [-(a(1, 1) + a(2, 2) + a(3, 3) + a(4, 4)), 1.0_wp]
      c(2) = s(1) + t(6) + a(1, 1)*a(3, 3) - a(1, 3)*a(3, 1) + a(1, 1)*a(4, 4) &
         - a(1, 4)*a(4, 1) + a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2) + a(2, 2)*a(4, 4) - a(2, 4)*a(4, 2)
      c(1) = -(a(3, 1)*s(4) - a(3, 2)*s(2) + a(3, 3)*s(1) + a(4, 1)*s(5) - a(4, 2)*s(3) &
         + a(4, 4)*s(1) + a(1, 1)*t(6) - a(1, 3)*t(3) + a(1, 4)*t(2) + a(2, 2)*t(6) &
         - a(2, 3)*t(5) + a(2, 4)*t(4))
      c(0) = s(1)*t(6) - s(2)*t(5) + s(3)*t(4) + s(4)*t(3) - s(5)*t(2) + s(6)*t(1)
   end function characteristic_polynomial

   !> The minors of two rows: columns 12, 13, 14, 23, 24, 34.
   pure function minors(u, v) result(m)
      !> The two rows.
      real(wp), intent(in) :: u(4), v(4)
      real(wp) :: m(6)

      m = [u(1)*v(2) - u(2)*v(1), u(1)*v(3) - u(3)*v(1), u(1)*v(4) - u(4)*v(1), &
         u(2)*v(3) - u(3)*v(2), u(2)*v(4) - u(4)*v(2), u(3)*v(4) - u(4)*v(3)]
   end function minors

end module vi_unit_circle
