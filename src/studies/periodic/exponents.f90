!> What Lyapunov exponents of oscillators and of structures have in common: directions that are
!! orthonormalised, weights of averages, and what follows from the exponents.
module vi_exponents
   use, intrinsic :: ieee_arithmetic, only: ieee_negative_inf, ieee_value
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: bump, kaplan_yorke, orthonormalise, scatter, sign_by_error

   !> The sign of a largest exponent: that which it has by its error, or none as long as the error
   !! is
   !! too large for that.
   integer, parameter, public :: negative = -1, zero = 0, positive = 1, unclear = 2

contains

   !> Gram-Schmidt orthonormalisation, applied twice.
   !!
   !! A column that depends linearly on those before it, to rounding, gets length 0 and is replaced
   !! by another direction, so that the columns stay linearly independent.
   pure subroutine orthonormalise(q, lengths)
      !> In: columns, at most as many as rows. Out: orthonormal columns.
      real(wp), contiguous, intent(inout) :: q(:, :)
      !> Length of each column orthogonal to those before it: the diagonal of the triangular factor.
      real(wp), intent(out) :: lengths(:)
      real(wp) :: whole, rest
      integer :: j, least

      do j = 1, size(q, 2)
         whole = norm2(q(:, j))
         call project_out(q, j)
         rest = norm2(q(:, j))
         lengths(j) = rest
         if (.not. rest > 4*epsilon(1.0_wp)*whole) then
            lengths(j) = 0
            least = minloc(sum(q(:, :j - 1)**2, dim=2), dim=1)
            q(:, j) = 0
            q(least, j) = 1
            call project_out(q, j)
            rest = norm2(q(:, j))
         end if
         q(:, j) = q(:, j)/rest
         call project_out(q, j)
         q(:, j) = q(:, j)/sqrt(sum(q(:, j)**2))                  ! of the order of 1: no overflow
      end do
   end subroutine orthonormalise

   !> Subtracts from a column its components along the columns before it.
   pure subroutine project_out(q, j)
      !> In and out: column j changes; those before it are orthonormal.
      real(wp), contiguous, intent(inout) :: q(:, :)
      !> Number of the column.
      integer, intent(in) :: j
      integer :: i

      do i = 1, j - 1
         q(:, j) = q(:, j) - dot_product(q(:, i), q(:, j))*q(:, i)
      end do
   end subroutine project_out

   !> Standard errors of exponents from their batches, and the greatest exponent first; directions
   !! that are lost have exponent -inf.
   pure subroutine scatter(each, rank, exponents, deviations)
      !> (n, batches) The exponents of each batch.
      real(wp), intent(in) :: each(:, :)
      !> Number of directions that are not lost.
      integer, intent(in) :: rank
      !> (n) In: the exponents over all batches together. Out: in order, -inf where the direction is
      !! lost.
      real(wp), intent(inout) :: exponents(:)
      !> (n) Their standard errors.
      real(wp), intent(out) :: deviations(:)
      real(wp) :: mean(size(exponents)), pair(2)
      integer :: i, j, batches

      batches = size(each, 2)
      mean = sum(each, dim=2)/batches
      deviations = 0
      do i = 1, batches
         deviations = deviations + (each(:, i) - mean)**2
      end do
      deviations = sqrt(deviations/(batches - 1))/sqrt(real(batches, wp))
      exponents(rank + 1:) = ieee_value(1.0_wp, ieee_negative_inf)
      deviations(rank + 1:) = 0
      ! equal exponents, as of a pair of multipliers, change places by the error of the average
      do i = 2, rank
         pair = [exponents(i), deviations(i)]
         do j = i, 2, -1
            if (.not. exponents(j - 1) < pair(1)) exit
            exponents(j) = exponents(j - 1)
            deviations(j) = deviations(j - 1)
         end do
         exponents(j) = pair(1)
         deviations(j) = pair(2)
      end do
   end subroutine scatter

   !> The dimension of Kaplan and Yorke: the number of directions whose volume does not shrink, and
   !! the fraction of the next direction that balances the growth.
   pure real(wp) function kaplan_yorke(exponents) result(dimension)
      !> All exponents, the greatest first.
      real(wp), intent(in) :: exponents(:)
      real(wp) :: sum_before
      integer :: i

      dimension = 0
      sum_before = 0
      do i = 1, size(exponents)
         if (.not. sum_before + exponents(i) >= 0) exit
         sum_before = sum_before + exponents(i)
         dimension = dimension + 1
      end do
      if (i <= size(exponents)) dimension = dimension - sum_before/exponents(i)
   end function kaplan_yorke

   !> The sign of the largest exponent of an average, by its error.
   !!
   !! Besides the scatter of the batches there is an error of the order of 1 over the length of the
   !! average: on a torus small changes grow as a power of the time.
   pure integer function sign_by_error(exponent, deviation, periods) result(sign_of_it)
      !> The exponent per period of the load, and its standard error.
      real(wp), intent(in) :: exponent, deviation
      !> Number of periods of the average.
      integer, intent(in) :: periods
      !> Standard errors that count as a certain difference; logarithm of a growth as a power of the
      !! time, and of one that is none; largest error of a zero, with the growth and without.
      real(wp), parameter :: certain = 4, slow = 8, still = 1, coarse = 2.0e-3_wp, fine = 1.0e-4_wp

      if (exponent > certain*deviation + slow/periods) then
         sign_of_it = positive
      else if (exponent < -certain*deviation - still/periods) then
         sign_of_it = negative
      else if (certain*deviation < fine .and. slow/periods < coarse) then
         sign_of_it = zero
      else
         sign_of_it = unclear
      end if
   end function sign_by_error

   !> A weight that rises smoothly from 0 and falls smoothly back to 0 over [0, 1].
   !!
   !! With this weight, averages over periodic and quasi-periodic motions converge faster than any
   !! power of the time; those over chaotic motions converge as fast as without it.
   pure real(wp) function bump(s)
      !> Place in the interval.
      real(wp), intent(in) :: s

      bump = 0
      if (s > 1.0e-3_wp .and. s < 1 - 1.0e-3_wp) bump = exp(-1/(s*(1 - s)))
   end function bump

end module vi_exponents
