!> Integrals over a flight or a rest of a structure in closed form.
!!
!! All signals are linear in one vector b: the pairs (x, v), the cosines and sines of the harmonics
!! of the load, 1, and the time t since the beginning. It obeys b' = A b, and b(t) = F(t) b(0) in
!! closed form. The integral W of b b^T follows from its Taylor series for a short time, where
!! W'' = A W' + W' A^T, and from W(2t) = W(t) + F(t) W(t) F(t)^T; those of b e^(-i k Omega t)
!! likewise. Nothing is divided by differences of exponents: pairs may be damped in any way, have
!! frequency 0, or resonate.
module vi_moments
   use vi_kinds, only: wp
   use vi_modes, only: advance, interval_type, new_interval
   use vi_structure, only: regime_type
   implicit none (type, external)
   private

   public :: moments_of, numbers_in, rate_of, rates_in, vector_at

contains

   !> The number of entries of b.
   pure integer function numbers_in(regime) result(n)
      !> The regime.
      type(regime_type), intent(in) :: regime

      n = 2*size(regime%modes%stiffness) + 2*size(regime%steady, 2) + 2
   end function numbers_in

   !> The greatest rate of change of b: of the pairs, and of the harmonics of the load.
   pure real(wp) function rates_in(regime) result(rate)
      !> The regime.
      type(regime_type), intent(in) :: regime

      rate = max(1/regime%unit, size(regime%steady, 2)*regime%frequency)
   end function rates_in

   !> b at a time after the beginning.
   pure subroutine vector_at(regime, x, v, phase, t, b)
      !> The regime, with the forces of the interval if there is a record.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at the beginning.
      real(wp), contiguous, intent(in) :: x(:), v(:)
      !> The load phase there, and the time.
      real(wp), intent(in) :: phase, t
      !> The vector.
      real(wp), contiguous, intent(out) :: b(:)
      integer :: h, m, n

      m = size(x)
      n = size(regime%steady, 2)
      call advance(regime%modes, t, x, v, b(:m), b(m + 1:2*m))
      b(2*m + 1:) = [(cos(h*(phase + regime%frequency*t)), h=1, n), &
         (sin(h*(phase + regime%frequency*t)), h=1, n), 1.0_wp, t]
   end subroutine vector_at

   !> A times columns.
   pure function rate_of(regime, b) result(rate)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (b, columns)
      real(wp), intent(in) :: b(:, :)
      real(wp), allocatable :: rate(:, :)
      integer :: h, j, m, n

      m = size(regime%modes%stiffness)
      n = size(regime%steady, 2)
      allocate (rate(size(b, 1), size(b, 2)))
      associate (modes => regime%modes, one => size(b, 1) - 1, time => size(b, 1))
         do j = 1, size(b, 2)
            rate(:m, j) = b(m + 1:2*m, j) + modes%drift*b(one, j) + modes%drift_rate*b(time, j)
            rate(m + 1:2*m, j) = modes%force*b(one, j) + modes%force_rate*b(time, j) &
               - modes%stiffness*b(:m, j) - 2*modes%damping*b(m + 1:2*m, j)
            do h = 1, n
               rate(2*m + h, j) = -h*regime%frequency*b(2*m + n + h, j)
               rate(2*m + n + h, j) = h*regime%frequency*b(2*m + h, j)
            end do
            rate(one, j) = 0
            rate(time, j) = b(one, j)
         end do
      end associate
   end function rate_of

   !> F times columns.
   pure subroutine carry(regime, interval, time, b)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> What advances the pairs by the time, and the time.
      type(interval_type), intent(in) :: interval
      real(wp), intent(in) :: time
      !> (b, columns) In and out.
      real(wp), intent(inout) :: b(:, :)
      real(wp), dimension(size(regime%modes%stiffness)) :: force, force_rate, drift, drift_rate, x
      real(wp) :: c, s, before
      integer :: h, j, m, n

      m = size(x)
      n = size(regime%steady, 2)
      associate (modes => regime%modes, map => interval%map, one => size(b, 1) - 1, &
         last => size(b, 1))
         do j = 1, size(b, 2)
            force = modes%force*b(one, j) + modes%force_rate*b(last, j)
            drift = modes%drift*b(one, j) + modes%drift_rate*b(last, j)
            force_rate = modes%force_rate*b(one, j)
            drift_rate = modes%drift_rate*b(one, j)
            x = b(:m, j)
            associate (v => b(m + 1:2*m, j))
               b(:m, j) = map(1, :)*x + map(2, :)*v + map(3, :)*force + map(4, :)*force_rate &
                  + map(5, :)*drift + map(6, :)*drift_rate
               v = map(7, :)*x + map(8, :)*v + map(9, :)*force + map(10, :)*force_rate &
                  + map(11, :)*drift + map(12, :)*drift_rate
            end associate
            b(last, j) = b(last, j) + time*b(one, j)
         end do
      end associate
      do h = 1, n
         c = cos(h*regime%frequency*time)
         s = sin(h*regime%frequency*time)
         do j = 1, size(b, 2)
            before = b(2*m + h, j)
            b(2*m + h, j) = c*before - s*b(2*m + n + h, j)
            b(2*m + n + h, j) = s*before + c*b(2*m + n + h, j)
         end do
      end do
   end subroutine carry

   !> The integrals over a time.
   pure subroutine moments_of(regime, start, time, squares, parts)
      !> The regime, with the forces of the interval if there is a record.
      type(regime_type), intent(in) :: regime
      !> b at the beginning, and the time > 0.
      real(wp), intent(in) :: start(:), time
      !> (b, b) The integral of b b^T.
      real(wp), intent(out) :: squares(:, :)
      !> (b, orders) Those of b e^(-i k Omega t).
      complex(wp), intent(out) :: parts(:, :)
      real(wp), allocatable, dimension(:, :) :: b, next, rate, term
      type(interval_type) :: interval
      real(wp) :: before(size(start)), c, length, left, ratio, s, turn(size(parts, 2))
      integer :: i, j, k, levels

      k = size(parts, 2)
      turn = [(i*regime%frequency, i=1, k)]
      ratio = 4*time*max(rates_in(regime), maxval([0.0_wp, turn]))
      levels = max(0, exponent(ratio))
      length = scale(time, -levels)
      ratio = scale(ratio, -levels)
      term = length*spread(start, 2, size(start))*spread(start, 1, size(start))
      squares = term
      allocate (next(size(start), 2*k), source=0.0_wp)
      next(:, :k) = length*spread(start, 2, k)
      b = next
      left = 1
      i = 1
      ! the powers of the time up to the sixth come first from a constant force that grows
      do while (left > 0)
         i = i + 1
         term = rate_of(regime, term)
         term = (length/i)*(term + transpose(term))
         squares = squares + term
         rate = rate_of(regime, next)
         do j = 1, k
            before = next(:, j)
            next(:, j) = (length/i)*(rate(:, j) + turn(j)*next(:, k + j))
            next(:, k + j) = (length/i)*(rate(:, k + j) - turn(j)*before)
         end do
         b = b + next
         if (i > 7) left = left*ratio/i
         if (left < 0.1_wp*epsilon(left)) left = 0
      end do
      do i = 1, levels
         call new_interval(regime%modes, length, interval)
         term = squares
         call carry(regime, interval, length, term)
         term = transpose(term)
         call carry(regime, interval, length, term)
         squares = squares + term
         next = b
         call carry(regime, interval, length, next)
         do j = 1, k
            c = cos(turn(j)*length)
            s = sin(turn(j)*length)
            b(:, j) = b(:, j) + c*next(:, j) + s*next(:, k + j)
            b(:, k + j) = b(:, k + j) + c*next(:, k + j) - s*next(:, j)
         end do
         length = 2*length
      end do
      parts = cmplx(b(:, :k), b(:, k + 1:), wp)
   end subroutine moments_of

end module vi_moments
