!> The law of a gap that closes: the coefficient of restitution R as a function of the approach
!! speed v, or an elastic stop; and the levels of dry friction.
!!
!! Power law: R(v) = R0 (1 + (v/v0)^k)^(-p/k). Far below the speed v0 it tends to R0, and far above
!! to R0 (v/v0)^(-p). p = 1/4 is the exponent of plastic contact of spheres (K. L. Johnson, Contact
!! mechanics, 1985, section 11.5). A large k approaches the law min(R0, R0 (v/v0)^(-p)), with p =
!! 0.234 for ice at low temperature (F. G. Bridges, A. Hatzes and D. N. C. Lin, Nature 309, 1984).
!! k = 1/5 and R0 = 1 give 1 - R ~ v^(1/5) at low speeds, as for viscoelastic spheres.
!!
!! Stop: a spring and a dashpot that press with p = p0 + k d + c d' at a depth d > 0. The contact of
!! one kind ends where d returns to 0; the other one cannot pull, p = max(0, ..).
!!
!! Table: a monotone piecewise cubic interpolant with continuous slope (F. N. Fritsch and J.
!! Butland, SIAM J. Sci. Stat. Comput. 5, 1984). Outside the table R keeps its first and its last
!! value.
module vi_restitution
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: greatest_below, new_restitution, restitution_at

   !> Kinds of laws.
   integer, parameter, public :: constant_law = 0, power_law = 1, table_law = 2, &
      stop_law = 3, pushing_law = 4, friction_law = 5

   !> A law.
   type, public :: restitution_type
      integer :: kind = constant_law
      !> Power law: R0, v0, p and k. Constant: R first. Stop: k, c and p0.
      !! Friction: slip level, stick level and speed of a belt.
      real(wp) :: numbers(4) = 1
      !> Table: speeds in ascending order, values, and slopes there.
      real(wp), allocatable :: speeds(:), values(:), slopes(:)
   end type restitution_type

contains

   !> A law from numbers.
   pure function new_restitution(kind, numbers) result(law)
      !> Its kind, as a whole number.
      real(wp), intent(in) :: kind
      !> Constant: R. Power law: R0, v0, p, k. Table: the number of points, their speeds, and their
      !! values. Stop, friction: as in `restitution_type`. More numbers do not count.
      real(wp), intent(in) :: numbers(:)
      type(restitution_type) :: law
      integer :: n

      law%kind = nint(kind)
      select case (law%kind)
      case (power_law)
         law%numbers = numbers(:4)
      case (table_law)
         n = nint(numbers(1))
         allocate (law%speeds, source=numbers(2:n + 1))
         allocate (law%values, source=numbers(n + 2:2*n + 1))
         allocate (law%slopes(n))
         call monotone_slopes(law%speeds, law%values, law%slopes)
         law%numbers(1) = law%values(1)
      case (stop_law, pushing_law, friction_law)
         law%numbers(:3) = numbers(:3)
      case default
         law%numbers(1) = numbers(1)
      end select
   end function new_restitution

   !> Slopes of a monotone piecewise cubic interpolant.
   pure subroutine monotone_slopes(speeds, values, slopes)
      !> (n >= 2) Speeds in ascending order, and values.
      real(wp), intent(in) :: speeds(:), values(:)
      !> (n) The slopes: 0 at extrema, and where a constant value follows.
      real(wp), intent(out) :: slopes(:)
      real(wp), dimension(size(speeds) - 1) :: h, chord
      integer :: i, n

      n = size(speeds)
      h = speeds(2:) - speeds(:n - 1)
      chord = (values(2:) - values(:n - 1))/h
      slopes = 0
      do i = 2, n - 1
         if (chord(i - 1)*chord(i) > 0) then
            slopes(i) = 3*(h(i - 1) + h(i))/((2*h(i) + h(i - 1))/chord(i - 1) &
               + (h(i) + 2*h(i - 1))/chord(i))
         end if
      end do
      if (speeds(1) > 0) return
      ! no speeds lie below 0: the first slope is free. The slope of the parabola through three
      ! points, limited so that the interpolant remains monotone
      slopes(1) = chord(1)
      if (n == 2) return
      slopes(1) = ((2*h(1) + h(2))*chord(1) - h(1)*chord(2))/(h(1) + h(2))
      if (.not. slopes(1)*chord(1) > 0) slopes(1) = 0
      if (abs(slopes(1)) > 3*abs(chord(1))) slopes(1) = 3*chord(1)
   end subroutine monotone_slopes

   !> R and dR/dv at an approach speed.
   pure subroutine restitution_at(law, speed, value, slope)
      !> The law.
      type(restitution_type), intent(in) :: law
      !> Approach speed v >= 0.
      real(wp), intent(in) :: speed
      !> R and dR/dv. The slope is -huge(1.0) where it is infinite, at v = 0 for k < 1.
      real(wp), intent(out) :: value, slope

      slope = 0
      value = law%numbers(1)
      if (law%kind == power_law) call power(law%numbers, speed, value, slope)
      if (law%kind == table_law) call interpolated(law, speed, value, slope)
   end subroutine restitution_at

   !> R and dR/dv by a power law.
   pure subroutine power(numbers, speed, value, slope)
      !> R0, v0, p and k.
      real(wp), intent(in) :: numbers(4)
      !> Approach speed.
      real(wp), intent(in) :: speed
      !> As in `restitution_at`.
      real(wp), intent(out) :: value, slope
      real(wp) :: ratio, share

      associate (r0 => numbers(1), v0 => numbers(2), p => numbers(3), k => numbers(4))
         value = r0
         slope = 0
         if (.not. speed > 0) then
            if (p > 0 .and. r0 > 0 .and. k <= 1) slope = merge(-huge(1.0_wp), -r0*p/v0, k < 1)
            return
         end if
         ! the smaller one of z = (v/v0)^k and 1/z, which cannot overflow
         if (speed <= v0) then
            ratio = (speed/v0)**k
            value = r0*(1 + ratio)**(-p/k)
            share = ratio/(1 + ratio)
         else
            ratio = (v0/speed)**k
            value = r0*(v0/speed)**p*(1 + ratio)**(-p/k)
            share = 1/(1 + ratio)
         end if
         slope = -p*share*value/speed
      end associate
   end subroutine power

   !> R and dR/dv by a table.
   pure subroutine interpolated(law, speed, value, slope)
      !> The law.
      type(restitution_type), intent(in) :: law
      !> Approach speed.
      real(wp), intent(in) :: speed
      !> As in `restitution_at`.
      real(wp), intent(out) :: value, slope
      real(wp) :: t, rise, left, right
      integer :: i, first, last

      slope = 0
      last = size(law%speeds)
      if (speed < law%speeds(1)) then
         value = law%values(1)
         return
      else if (.not. speed < law%speeds(last)) then
         value = law%values(last)
         return
      end if
      first = 1
      do while (last - first > 1)
         i = (first + last)/2
         if (speed < law%speeds(i)) then
            last = i
         else
            first = i
         end if
      end do
      associate (h => law%speeds(first + 1) - law%speeds(first))
         t = (speed - law%speeds(first))/h
         rise = law%values(first + 1) - law%values(first)
         left = h*law%slopes(first)
         right = h*law%slopes(first + 1)
         value = law%values(first) + t*(left + t*(3*rise - 2*left - right &
            + t*(left + right - 2*rise)))
         slope = (left + t*(2*(3*rise - 2*left - right) + 3*t*(left + right - 2*rise)))/h
      end associate
      ! a monotone interpolant lies between its neighbours but for rounding
      value = max(min(law%values(first), law%values(first + 1)), &
         min(max(law%values(first), law%values(first + 1)), value))
   end subroutine interpolated

   !> The greatest R at speeds from 0 to a given one.
   pure real(wp) function greatest_below(law, speed) result(greatest)
      !> The law.
      type(restitution_type), intent(in) :: law
      !> The speed.
      real(wp), intent(in) :: speed
      real(wp) :: slope
      integer :: i

      ! a power law falls with the speed
      greatest = law%numbers(1)
      if (law%kind /= table_law) return
      ! between its points a table is monotone
      call interpolated(law, speed, greatest, slope)
      do i = 1, size(law%speeds)
         if (law%speeds(i) < speed) greatest = max(greatest, law%values(i))
      end do
   end function greatest_below

end module vi_restitution
