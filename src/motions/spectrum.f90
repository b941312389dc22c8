!> Properties of the multipliers of a motion without computing them: their elementary symmetric
!! functions, and how many lie outside the unit circle.
!!
!! A multiplier grows like the inverse of an approach speed. The functions e_0 = 1, e_1 .. e_4 are
!! therefore multiplied by a common factor so that the squares of the first four sum to 1: where an
!! approach speed passes zero, they stay smooth and e_0 passes zero.
module vi_spectrum
   use vi_characteristic, only: characteristic, characteristic_slope
   use vi_compound, only: factor_weights, minors_of_split, minors_type, product_sums
   use vi_kinds, only: wp
   use vi_orbit, only: by_r, most_impacts, orbit_type, period_parts, split_part
   use vi_period_slope, only: add_part_slope, add_period_slope
   implicit none (type, external)
   private

   public :: is_neutral_saddle, multiplier_sums, outside_circle, pair_product, sums_with_slope

   !> The elementary symmetric functions ("sums") of a motion's multipliers.
   type, public :: spectrum_type
      !> e_0 .. e_4, normalised.
      real(wp) :: e(0:4) = 0
      !> The product of all multipliers, known in closed form.
      real(wp) :: product = 0
      !> False if an impact has no approach speed at all.
      logical :: regular = .false.
      !> Of a structure, in place of the sums: the multipliers themselves.
      complex(wp), allocatable :: multipliers(:)
   end type spectrum_type

   !> Size of the entries of [P] above which its minors are computed from those of the [P_i]:
   !! rounding changes a minor of three rows by the square of the largest entry.
   real(wp), parameter :: large = 1.0e3_wp

contains

   !> The sums of an orbit.
   pure subroutine multiplier_sums(o, spectrum)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> The normalised sums; undefined where `regular` is false.
      type(spectrum_type), intent(out) :: spectrum
      type(minors_type) :: factors(o%n)
      real(wp) :: parts(4, 4, most_impacts), p(4, 4), length

      call period_parts(o, parts, p, spectrum%regular)
      if (.not. spectrum%regular) return
      call sums_of_parts(o, parts, p, spectrum, length, factors)
   end subroutine multiplier_sums

   !> The sums, normalised, from the maps of the flights.
   pure subroutine sums_of_parts(o, parts, p, spectrum, length, factors)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> All [P_i] and their product.
      real(wp), intent(in) :: parts(4, 4, most_impacts), p(4, 4)
      !> Out: the normalised sums, the closed product, and `regular`.
      type(spectrum_type), intent(inout) :: spectrum
      !> 2-norm of the sums before they are normalised.
      real(wp), intent(out) :: length
      !> The minors of all factors, if the entries of the product are large.
      type(minors_type), intent(out) :: factors(o%n)
      integer :: i

      associate (e => spectrum%e)
         e(0) = 1
         do i = 1, o%n
            e(0) = e(0)*merge(approach(o, i), sign(1.0_wp, approach(o, i)), is_large(p))
         end do
         if (is_large(p)) then
            call minors_of_parts(o, parts, factors)
            e(1:3) = product_sums(factors)
         else
            e(1:) = e(0)*characteristic(p)
         end if
         length = norm2(e(:3))
         spectrum%product = closed_product(o)
         spectrum%regular = length > 0
         if (.not. spectrum%regular) return
         e(:3) = e(:3)/length
         e(4) = spectrum%product*e(0)
      end associate
   end subroutine sums_of_parts

   !> Whether the entries of [P] are so large that its minors lose too many digits.
   pure logical function is_large(p)
      !> [P].
      real(wp), intent(in) :: p(4, 4)

      is_large = maxval(abs(p)) > large
   end function is_large

   !> Approach speed of the masses before the impact that ends flight i.
   pure real(wp) function approach(o, i)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> Number of the flight, 1 to n.
      integer, intent(in) :: i

      approach = o%side(i + 1)*(o%speed(i) - o%before(i + 1))
   end function approach

   !> det[P] = exp(-4 pi xi k/r) times the squares of all R_i. The map of a half period, with the
   !! mirror, has a determinant of the same form and the same sign: its impacts change sides an odd
   !! number of times.
   pure real(wp) function closed_product(o)
      !> The orbit.
      type(orbit_type), intent(in) :: o

      closed_product = exp(-2*o%xi*o%span*o%per_r)*product(o%restitution(1:o%n))**2
   end function closed_product

   !> The minors of all [P_i], each times the approach speed at its end.
   pure subroutine minors_of_parts(o, parts, factors)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> All [P_i].
      real(wp), intent(in) :: parts(4, 4, most_impacts)
      !> factors(i): the minors of [P_i].
      type(minors_type), intent(out) :: factors(o%n)
      real(wp) :: base(3, 4), column(3)
      integer :: i

      do i = 1, o%n
         call split_part(o, i, base, column)
         factors(i) = minors_of_split(base, column, parts(4, :, i), approach(o, i))
      end do
   end subroutine minors_of_parts

   !> The sums, one of three numbers formed from them, and the gradient of that number.
   pure subroutine sums_with_slope(o, kind, spectrum, value, slope)
      !> The orbit.
      type(orbit_type), intent(in) :: o
      !> 1: det(I - P), 2: det(I + P), 3: `pair_product`, of the normalised sums.
      integer, intent(in) :: kind
      !> The normalised sums.
      type(spectrum_type), intent(out) :: spectrum
      !> The number; 0 where the sums are not regular.
      real(wp), intent(out) :: value
      !> (at least 2n + 2) In and out: gradient with respect to u_i, theta_i, r, log(D), to which
      !! that of `value` is added.
      real(wp), contiguous, intent(inout) :: slope(:)
      type(minors_type) :: factors(o%n)
      real(wp), dimension(4, 4, most_impacts) :: parts, by_entry
      real(wp) :: p(4, 4), w(0:3), by_product, length
      integer :: i

      value = 0
      call period_parts(o, parts, p, spectrum%regular)
      if (.not. spectrum%regular) return
      call sums_of_parts(o, parts, p, spectrum, length, factors)
      if (.not. spectrum%regular) return
      call weights_of(kind, spectrum, value, w, by_product)
      ! the length depends on the sums as well
      w = (w - dot_product(w, spectrum%e(:3))*spectrum%e(:3))/length
      if (is_large(p)) then
         call factor_weights(factors, w(1:3), by_entry(:, :, :o%n))
         do i = 1, o%n
            if (i == o%n) by_entry(:3, :, i) = o%sign*by_entry(:3, :, i)
            call add_part_slope(o, i, parts(:, :, i), by_entry(:, :, i), slope)
         end do
      else
         w = sign(1.0_wp, spectrum%e(0))*w
         call add_period_slope(o, parts, characteristic_slope(p, [w(1:3), 0.0_wp]), slope)
      end if
      slope(2*o%n + by_r) = slope(2*o%n + by_r) + by_product*2*o%xi*o%span*o%per_r**2 &
         *spectrum%product
   end subroutine sums_with_slope

   !> One of the three numbers that decide stability, with its derivatives.
   pure subroutine weights_of(kind, spectrum, value, by_sums, by_product)
      !> As in `sums_with_slope`.
      integer, intent(in) :: kind
      !> The normalised sums.
      type(spectrum_type), intent(in) :: spectrum
      !> The number.
      real(wp), intent(out) :: value
      !> Derivatives with respect to e_0 .. e_3, where e_4 is the product times e_0, and to the
      !! product.
      real(wp), intent(out) :: by_sums(0:3), by_product

      associate (e => spectrum%e, q => spectrum%product)
         select case (kind)
         case (1, 2)
            by_sums = [1.0_wp, -1.0_wp, 1.0_wp, -1.0_wp]
            if (kind == 2) by_sums = 1
            by_sums(0) = by_sums(0) + q
            value = dot_product(by_sums, e(:3))
            by_product = e(0)
         case default
            value = pair_product(spectrum)
            by_sums = [(1 - q)**2*(2*(1 + q)*e(0) - e(2)), e(3)*(1 + q) - 2*e(1)*q, &
               -(1 - q)**2*e(0), e(1)*(1 + q) - 2*e(3)]
            by_product = ((1 - q)**2*e(0) - 2*(1 - q)*((1 + q)*e(0) - e(2)))*e(0) &
               - e(1)*(e(1) - e(3))
         end select
      end associate
   end subroutine weights_of

   !> The product of all 1 - lambda_i lambda_j, i < j, times e_0^2.
   pure real(wp) function pair_product(spectrum)
      !> The normalised sums.
      type(spectrum_type), intent(in) :: spectrum

      associate (e => spectrum%e, q => spectrum%product)
         pair_product = (1 - q)**2*((1 + q)*e(0) - e(2))*e(0) + (e(1) - e(3))*(e(3) - e(1)*q)
      end associate
   end function pair_product

   !> Whether two real multipliers, not a complex pair, have the product 1 where `pair_product` is
   !! zero: (lambda^2 - t lambda + 1) is a factor there with t (1 - product) e_0 = e_1 - e_3.
   !! The multipliers themselves also show where no product is 1, but one of them passes infinity.
   pure logical function is_neutral_saddle(spectrum)
      !> The normalised sums, where `pair_product` is zero.
      type(spectrum_type), intent(in) :: spectrum

      real(wp), parameter :: close = 1.0e-3_wp
      integer :: at(2)

      if (allocated(spectrum%multipliers)) then
         at = nearest_to_one(spectrum%multipliers, 3)
         associate (pair => spectrum%multipliers(at))
            is_neutral_saddle = .not. (abs(pair(1)%im) > 0 .and. abs(product(pair) - 1) < close)
         end associate
         return
      end if
      associate (e => spectrum%e)
         is_neutral_saddle = abs(e(1) - e(3)) > 2*abs(e(0) - e(4))
      end associate
   end function is_neutral_saddle

   !> Number of multipliers outside the unit circle; one or two that lie on it do not count.
   pure integer function outside_circle(spectrum, kind) result(outside)
      !> The normalised sums.
      type(spectrum_type), intent(in) :: spectrum
      !> The number that is zero, as in `sums_with_slope`; 0 if none of them is.
      integer, intent(in) :: kind
      real(wp) :: c(0:4), t
      integer :: n, i

      if (allocated(spectrum%multipliers)) then
         outside = count(abs(spectrum%multipliers) > 1)
         if (kind > 0) outside = outside - count([(abs(spectrum%multipliers(i)) > 1, &
            i=1, size(spectrum%multipliers))] .and. are_critical(spectrum%multipliers, kind))
         return
      end if
      ! the characteristic polynomial, highest power first
      c = spectrum%e*[1, -1, 1, -1, 1]
      select case (kind)
      case (1, 2)
         ! divided by lambda - 1 or lambda + 1
         do i = 1, 3
            c(i) = c(i) + merge(1, -1, kind == 1)*c(i - 1)
         end do
         n = 3
      case (3)
         ! divided by lambda^2 - t lambda + 1
         t = -(c(1) - c(3))/(c(0) - c(4))
         c(1) = c(1) + t*c(0)
         c(2) = c(4)
         n = 2
      case default
         n = 4
      end select
      outside = zeros_outside(c(0:n))
   end function outside_circle

   !> Which multipliers lie on the unit circle where one of the three numbers is zero.
   pure function are_critical(multipliers, kind) result(critical)
      !> All of them.
      complex(wp), intent(in) :: multipliers(:)
      !> The number that is zero, as in `sums_with_slope`.
      integer, intent(in) :: kind
      logical :: critical(size(multipliers))
      integer :: at(2)

      at = nearest_to_one(multipliers, kind)
      critical = .false.
      critical(at(1)) = .true.
      critical(at(2)) = .true.
   end function are_critical

   !> The multiplier nearest to 1 (kind 1) or to -1 (kind 2), twice; or the pair of real or of
   !! conjugate multipliers whose product is nearest to 1 (kind 3).
   pure function nearest_to_one(multipliers, kind) result(at)
      !> All of them; conjugate ones are in succession.
      complex(wp), intent(in) :: multipliers(:)
      !> 1, 2 or 3.
      integer, intent(in) :: kind
      integer :: at(2)
      real(wp) :: least, apart
      integer :: i, j

      if (kind < 3) then
         at = minloc(abs(multipliers - merge(1, -1, kind == 1)), dim=1)
         return
      end if
      least = huge(least)
      at = 1
      do i = 1, size(multipliers)
         do j = i + 1, size(multipliers)
            if (abs(multipliers(i)%im) > 0 .or. abs(multipliers(j)%im) > 0) then
               if (.not. (j == i + 1 .and. multipliers(i)%im > 0)) cycle
            end if
            apart = abs(1 - multipliers(i)*multipliers(j))
            if (apart >= least) cycle
            least = apart
            at = [i, j]
         end do
      end do
   end function nearest_to_one

   !> Number of zeros of a polynomial outside the unit circle, by the Schur-Cohn recursion.
   pure integer function zeros_outside(coefficients) result(outside)
      !> Highest power first; at most 5.
      real(wp), intent(in) :: coefficients(:)
      real(wp) :: c(5), reversed(5), share
      integer :: i, n
      logical :: inverted

      c(:size(coefficients)) = coefficients
      outside = 0
      inverted = .false.
      do n = size(coefficients), 2, -1
         do i = 1, n
            reversed(i) = c(n + 1 - i)
         end do
         if (abs(c(n)) > abs(c(1))) then
            ! the zeros of the reversed polynomial are the inverses
            c(:n) = reversed(:n)
            do i = 1, n
               reversed(i) = c(n + 1 - i)
            end do
            inverted = .not. inverted
         end if
         if (inverted) outside = outside + 1
         if (.not. abs(c(1)) > 0) return
         ! one zero fewer inside the circle
         share = c(n)/c(1)
         c(:n - 1) = c(:n - 1) - share*reversed(:n - 1)
      end do
   end function zeros_outside

end module vi_spectrum
