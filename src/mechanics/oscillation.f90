!> A damped oscillation plus a forced one, in closed form with all derivatives.
!!
!! The primary mass moves in this way between impacts, and, with other constants, while the free
!! mass rests on a wall: x = exp(-decay t) (a sin(nu t) + b cos(nu t)) + A sin(r t + phase).
module vi_oscillation
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: combination, derivatives, derivative_bound, derivative_bounds, new_oscillation, &
      square_integral

   !> The constants of one oscillation.
   type, public :: oscillation_type
      !> Decay rate and frequency of the free part, both over omega.
      real(wp) :: decay, frequency
      !> Free part, equations (5), (6).
      real(wp) :: a, b
      !> Forced part: frequency ratio, amplitude, and the argument of its sine at time 0.
      real(wp) :: r, amplitude, phase
   end type oscillation_type

contains

   !> The oscillation with position x and velocity x_dot at time 0.
   pure function new_oscillation(decay, frequency, r, amplitude, phase, x, x_dot) result(o)
      !> Decay rate and frequency nu of the free part (both over omega), frequency ratio, forced
      !! amplitude A (F0/K), argument of its sine at time 0 (rad), and the position (F0/K) and
      !! velocity (omega F0/K) at time 0.
      real(wp), intent(in) :: decay, frequency, r, amplitude, phase, x, x_dot
      type(oscillation_type) :: o

      o%decay = decay
      o%frequency = frequency
      o%r = r
      o%amplitude = amplitude
      o%phase = phase
      o%b = x - amplitude*sin(phase)                                                          ! (6)
      o%a = (x_dot - amplitude*r*cos(phase) + decay*o%b)/frequency                            ! (5)
   end function new_oscillation

   !> x and its first five derivatives at time t: equations (2), (27) and their derivatives.
   pure function derivatives(o, t, known) result(d)
      !> Constants of the oscillation.
      class(oscillation_type), intent(in) :: o
      !> Time (1/omega).
      real(wp), intent(in) :: t
      !> exp(-decay t), if the caller has it already.
      real(wp), intent(in), optional :: known
      real(wp) :: d(0:5)
      real(wp) :: shrink, s, c, forced, forced_dot, stiffness, free(0:5)

      if (present(known)) then
         shrink = known
      else
         shrink = exp(-o%decay*t)
      end if
      s = shrink*sin(o%frequency*t)
      c = shrink*cos(o%frequency*t)
      stiffness = o%decay**2 + o%frequency**2
      free(0) = o%a*s + o%b*c
      free(1) = o%frequency*(o%a*c - o%b*s) - o%decay*free(0)
      free(2) = -2*o%decay*free(1) - stiffness*free(0)
      free(3) = -2*o%decay*free(2) - stiffness*free(1)
      free(4) = -2*o%decay*free(3) - stiffness*free(2)
      free(5) = -2*o%decay*free(4) - stiffness*free(3)
      forced = o%amplitude*sin(o%r*t + o%phase)
      forced_dot = o%amplitude*o%r*cos(o%r*t + o%phase)
      d = free + [forced, forced_dot, -o%r**2*forced, -o%r**2*forced_dot, o%r**4*forced, &
         o%r**4*forced_dot]
   end function derivatives

   !> A bound on the absolute n-th derivative of x from time t on.
   !!
   !! The free part is Re(c exp(lambda t)) with |c| = |(a, b)|: a derivative multiplies its
   !! amplitude by |lambda|, and that of the forced part by r.
   pure real(wp) function derivative_bound(o, n, t) result(bound)
      !> Constants of the oscillation.
      class(oscillation_type), intent(in) :: o
      !> Order of the derivative, 0 for x itself.
      integer, intent(in) :: n
      !> Time (1/omega) from which the bound holds.
      real(wp), intent(in) :: t

      real(wp) :: parts(2)

      parts = derivative_bounds(o, n)
      bound = parts(1)*exp(-o%decay*t) + parts(2)
   end function derivative_bound

   !> The two terms of that bound: for the free part at time 0, to be multiplied by exp(-decay t),
   !! and for the forced part.
   pure function derivative_bounds(o, n) result(bounds)
      !> Constants of the oscillation.
      class(oscillation_type), intent(in) :: o
      !> Order of the derivative, 0 for x itself.
      integer, intent(in) :: n
      real(wp) :: bounds(2)

      bounds = [hypot(o%a, o%b)*sqrt(o%decay**2 + o%frequency**2)**n, abs(o%amplitude)*o%r**n]
   end function derivative_bounds

   !> The oscillation w(0) x + w(1) x' + w(2) x''.
   !!
   !! With x = Re(c exp(lambda t)) + Re(d exp(i r t)) it multiplies c by w(lambda) and d by w(i r).
   pure function combination(o, w) result(combined)
      !> Constants of x.
      type(oscillation_type), intent(in) :: o
      !> Coefficients of x, x' and x''.
      real(wp), intent(in) :: w(0:2)
      type(oscillation_type) :: combined
      complex(wp) :: lambda, c, d

      lambda = cmplx(-o%decay, o%frequency, wp)
      c = cmplx(o%b, -o%a, wp)*(w(0) + lambda*(w(1) + lambda*w(2)))
      d = cmplx(w(0) - o%r**2*w(2), o%r*w(1), wp)
      combined = o
      combined%a = -aimag(c)
      combined%b = real(c)
      combined%amplitude = o%amplitude*abs(d)
      combined%phase = o%phase
      if (abs(d) > 0) combined%phase = o%phase + atan2(aimag(d), real(d))
   end function combination

   !> The integral of x^2 from time 0 to t.
   pure real(wp) function square_integral(o, t) result(integral)
      !> Constants of x.
      type(oscillation_type), intent(in) :: o
      !> Time (1/omega).
      real(wp), intent(in) :: t
      complex(wp) :: lambda, c, d, turn

      ! x = Re(c exp(lambda t)) + Re(d exp(i r t)); Re(u) Re(v) = (Re(u v) + Re(u conjg(v)))/2
      lambda = cmplx(-o%decay, o%frequency, wp)
      turn = cmplx(0, o%r, wp)
      c = cmplx(o%b, -o%a, wp)
      d = o%amplitude*cmplx(sin(o%phase), -cos(o%phase), wp)
      integral = 0.5_wp*real(c**2*growth(2*lambda, t) + abs(c)**2*growth(lambda + conjg(lambda), &
         t) + d**2*growth(2*turn, t) + abs(d)**2*t) + real(c*d*growth(lambda + turn, t) + &
         c*conjg(d)*growth(lambda - turn, t))
   end function square_integral

   !> The integral of exp(k t) from time 0 to t.
   pure complex(wp) function growth(k, t)
      !> Exponent per unit of time, and time.
      complex(wp), intent(in) :: k
      !> As in `k`.
      real(wp), intent(in) :: t
      complex(wp) :: z, term
      integer :: i

      z = k*t
      if (abs(z) > 0.5_wp) then
         growth = t*(exp(z) - 1)/z
      else
         ! the difference would lose digits
         term = 1
         growth = 1
         do i = 2, 16
            term = term*z/i
            growth = growth + term
         end do
         growth = t*growth
      end if
   end function growth

end module vi_oscillation
