!> Periodic responses of a structure to impulses on its gaps.
!!
!! A unit impulse -G_j, repeated after each period T, gives each pair a periodic motion in closed
!! form, so that the gaps and approach speeds at given impact times are linear functions of the
!! impulses. A pair of frequency 0 has none of its own: the impulses on it and the constant forces
!! must balance over a period, and its mean position (its offset) is free. Its response is that to
!! the impulse less its mean over the period.
module vi_responses
   use vi_kinds, only: wp
   use vi_modes, only: departure, step_functions
   use vi_structure, only: regime_type, structure_type
   implicit none (type, external)
   private

   public :: forced_row, jumps_of, offset_pairs, pair_response, periodic_pair, ripple_row, &
      row_of_gap, steady_pairs, stretched_response

   !> A pair and a period, and what all its periodic responses share.
   type, public :: periodic_pair_type
      !> omega^2 and sigma of the pair, and the period.
      real(wp) :: stiffness = 0, damping = 0, period = 0
      !> x and v just after a jump by 1 of x, and of v: the columns of (I - Phi(T))^-1, for a pair
      !! with a frequency.
      real(wp) :: from_x(2) = 0, from_v(2) = 0
      !> Whether there is no response, because an undamped pair resonates with the period.
      logical :: resonant = .false.
   end type periodic_pair_type

contains

   !> The pairs of frequency 0, whose offsets are free.
   pure function offset_pairs(regime) result(pairs)
      !> The regime without resting gaps.
      type(regime_type), intent(in) :: regime
      integer, allocatable :: pairs(:)
      integer :: k

      pairs = pack([(k, k=1, size(regime%modes%stiffness))], .not. regime%modes%stiffness > 0)
   end function offset_pairs

   !> The jumps of all pairs due to a unit impulse on a gap.
   pure subroutine jumps_of(structure, regime, gap, in_x, in_v)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Its regime without resting gaps.
      type(regime_type), intent(in) :: regime
      !> The gap.
      integer, intent(in) :: gap
      !> (m) Jumps of x and of v.
      real(wp), intent(out) :: in_x(:), in_v(:)

      in_x = -matmul(regime%xd, structure%mobility(:, gap))
      in_v = -matmul(regime%vd, structure%mobility(:, gap))
   end subroutine jumps_of

   !> The coefficients of G_j.q in the pairs.
   pure subroutine row_of_gap(structure, regime, gap, of_x, of_v)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Its regime without resting gaps.
      type(regime_type), intent(in) :: regime
      !> The gap.
      integer, intent(in) :: gap
      !> (m) Coefficients of x and of v.
      real(wp), intent(out) :: of_x(:), of_v(:)

      of_x = structure%wall(gap)*regime%position(structure%channel(gap), :)
      of_v = structure%wall(gap)*regime%velocity(structure%channel(gap), :)
   end subroutine row_of_gap

   !> The constant part of the pairs under the constant forces; that of x at frequency 0 belongs to
   !! its offset.
   elemental subroutine steady_pairs(stiffness, damping, drift, force, x, v)
      !> omega^2, sigma, and the constant terms p and f of a pair.
      real(wp), intent(in) :: stiffness, damping, drift, force
      !> The constant part.
      real(wp), intent(out) :: x, v

      x = 0
      if (stiffness > 0) x = (force + 2*damping*drift)/stiffness
      v = -drift
   end subroutine steady_pairs

   !> G_j.q and its first two derivatives due to the steady response to the harmonics, and to what
   !! is constant in the row.
   pure subroutine ripple_row(structure, regime, gap, phase, d)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Its regime without resting gaps.
      type(regime_type), intent(in) :: regime
      !> The gap.
      integer, intent(in) :: gap
      !> Load phase (rad).
      real(wp), intent(in) :: phase
      !> The derivatives of order 0 to 2.
      real(wp), intent(out) :: d(0:2)
      complex(wp) :: here
      real(wp) :: omega
      integer :: h, row

      row = structure%channel(gap)
      d = 0
      d(0) = regime%row_offset(row)
      do h = 1, size(regime%ripple, 2)
         omega = h*regime%frequency
         here = regime%ripple(row, h)*cmplx(cos(h*phase), sin(h*phase), wp)
         d = d + [here%re, -omega*here%im, -omega**2*here%re]
      end do
      d = structure%wall(gap)*d
   end subroutine ripple_row

   !> The same with the constant part of the pairs: the motion without impacts.
   pure subroutine forced_row(structure, regime, gap, phase, d)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Its regime without resting gaps.
      type(regime_type), intent(in) :: regime
      !> The gap.
      integer, intent(in) :: gap
      !> Load phase (rad).
      real(wp), intent(in) :: phase
      !> The derivatives of order 0 to 2.
      real(wp), intent(out) :: d(0:2)
      real(wp), dimension(size(regime%modes%stiffness)) :: x, v, of_x, of_v

      call ripple_row(structure, regime, gap, phase, d)
      call steady_pairs(regime%modes%stiffness, regime%modes%damping, regime%modes%drift, &
         regime%modes%force, x, v)
      call row_of_gap(structure, regime, gap, of_x, of_v)
      d(0) = d(0) + dot_product(of_x, x) + dot_product(of_v, v)
   end subroutine forced_row

   !> The numbers of a pair and a period that its periodic responses depend on.
   elemental type(periodic_pair_type) function periodic_pair(stiffness, damping, period) &
      result(pair)
      !> omega^2 and sigma of the pair, and the period.
      real(wp), intent(in) :: stiffness, damping, period
      real(wp) :: u, w, lack, divisor

      pair%stiffness = stiffness
      pair%damping = damping
      pair%period = period
      if (.not. stiffness > 0) return
      lack = departure(stiffness, damping, period)
      call step_functions(stiffness, damping, period, u, w)
      divisor = lack*(lack + 2*damping*w) + stiffness*w**2
      pair%resonant = .not. divisor > (8*epsilon(1.0_wp)*max(1.0_wp, sqrt(stiffness)*period))**2
      if (pair%resonant) return
      pair%from_x = [lack + 2*damping*w, -stiffness*w]/divisor
      pair%from_v = [w, lack]/divisor
   end function periodic_pair

   !> The periodic response of one pair to jumps at time 0, at a time in (0, period], with its first
   !! two derivatives; 0 where the pair resonates with the period.
   pure subroutine pair_response(pair, in_x, in_v, time, x, v)
      !> The pair.
      type(periodic_pair_type), intent(in) :: pair
      !> The jumps.
      real(wp), intent(in) :: in_x, in_v
      !> The time after the jumps: 0 is just after them, the period just before.
      real(wp), intent(in) :: time
      !> Derivatives of order 0 to 2 of x and v.
      real(wp), intent(out) :: x(0:2), v(0:2)
      real(wp) :: u, w, first(2), share, slope

      if (pair%stiffness > 0) then
         first = in_x*pair%from_x + in_v*pair%from_v
         call step_functions(pair%stiffness, pair%damping, time, u, w)
         x(0) = u*first(1) + w*first(2)
         v(0) = (u - 2*pair%damping*w)*first(2) - pair%stiffness*w*first(1)
         x(1) = v(0)
         v(1) = -pair%stiffness*x(0) - 2*pair%damping*v(0)
      else
         share = time/pair%period
         call drifting_response(2*pair%damping, pair%period, share, x(0), v(0), slope)
         x(0) = in_v*x(0) - in_x*share
         v(0) = in_v*v(0) - in_x/pair%period
         x(1) = v(0)
         v(1) = -2*pair%damping*(v(0) + in_x/pair%period) - in_v/pair%period
      end if
      x(2) = v(1)
      v(2) = -pair%stiffness*x(1) - 2*pair%damping*v(1)
   end subroutine pair_response

   !> The derivatives of the response of a pair, and of its rate, with respect to the logarithm of a
   !! factor of all times.
   !!
   !! A longer period leaves more of a pair's motion at its end: the response changes by that to a
   !! jump by the rate just before the next jump.
   pure subroutine stretched_response(pair, in_x, in_v, time, by_x, by_v)
      !> As in `pair_response`.
      type(periodic_pair_type), intent(in) :: pair
      !> The jumps.
      real(wp), intent(in) :: in_x, in_v
      !> The time after the jumps.
      real(wp), intent(in) :: time
      !> The derivatives of x and v, and of their rates.
      real(wp), intent(out) :: by_x(0:1), by_v(0:1)
      real(wp), dimension(0:2) :: x, v, last_x, last_v
      real(wp) :: slope

      associate (period => pair%period, drag => 2*pair%damping)
         if (pair%stiffness > 0) then
            call pair_response(pair, in_x, in_v, period, last_x, last_v)
            call pair_response(pair, last_x(1), last_v(1), time, x, v)
            by_x = period*x(:1)
            by_v = period*v(:1)
            call pair_response(pair, in_x, in_v, time, x, v)
            by_x = by_x + time*x(1:)
            by_v = by_v + time*v(1:)
         else
            call drifting_response(drag, period, time/period, x(0), v(0), slope)
            by_v(0) = in_v*drag*period*slope + in_x/period
            by_x = [-in_v*period*slope, by_v(0)]
            by_v(1) = -drag*(by_v(0) - in_x/period) + in_v/period
         end if
      end associate
   end subroutine stretched_response

   !> x and v of a pair of frequency 0 after a unit jump of v, less its mean over the period; x up
   !! to a constant.
   !!
   !! With a drag c, v = e^(-c t)/(1 - e^(-c T)) - 1/(c T). For a small c T this is a series of
   !! Bernoulli polynomials B_n(1 - t/T) (c T)^(n - 1)/n! from n = 1, since z e^(s z)/(e^z - 1) is
   !! their generating function.
   pure subroutine drifting_response(drag, period, share, x, v, slope)
      !> c = 2 sigma, the period, and the part of it since the jump, 0 to 1.
      real(wp), intent(in) :: drag, period, share
      !> The response, and the derivative of v with respect to c T.
      real(wp), intent(out) :: x, v, slope
      integer, parameter :: terms = 15
      !> B_i/i! of the Bernoulli numbers B_0 to B_15.
      real(wp), parameter :: bernoulli(0:terms) = [1.0_wp, -0.5_wp, 1.0_wp/12, 0.0_wp, &
         -1.0_wp/720, 0.0_wp, 1.0_wp/30240, 0.0_wp, -1.0_wp/1209600, 0.0_wp, 1.0_wp/47900160, &
         0.0_wp, -691.0_wp/1307674368000.0_wp, 0.0_wp, 1.0_wp/74724249600.0_wp, 0.0_wp]
      real(wp) :: z, s, polynomial(0:terms), coefficient
      integer :: i, last, n

      z = drag*period
      if (z >= 0.5_wp) then
         v = exp(-z*share)/(1 - exp(-z)) - 1/z
         x = -(v + share - 0.5_wp)/drag
         slope = 1/z**2 - exp(-z*share)/(1 - exp(-z))*(share + exp(-z)/(1 - exp(-z)))
         return
      end if
      s = 1 - share
      ! without a drag only two terms count
      last = merge(terms, 2, z > 0)
      do n = 1, last
         ! B_n(s)/n! = sum over i of B_i/i! s^(n - i)/(n - i)!
         polynomial(n) = 0
         coefficient = 1
         do i = n, 0, -1
            polynomial(n) = polynomial(n) + bernoulli(i)*coefficient
            coefficient = coefficient*s/(n - i + 1)
         end do
      end do
      v = 0
      x = 0
      slope = 0
      do n = last, 2, -1
         slope = slope*z + (n - 1)*polynomial(n)
         v = v*z + polynomial(n)
         x = x*z - polynomial(n)
      end do
      v = v*z + polynomial(1)
      x = period*x
   end subroutine drifting_response

end module vi_responses
