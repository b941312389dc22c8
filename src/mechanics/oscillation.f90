!> A damped oscillation plus a forced one, in closed form with all derivatives.
!!
!! The primary mass moves in this way between impacts, and, with other constants, while the free
!! mass rests on a wall: x = exp(-decay t) (a sin(nu t) + b cos(nu t)) + A sin(r t + phase).
module vi_oscillation
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: new_oscillation, derivatives, derivative_bound, derivative_bounds

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

end module vi_oscillation
