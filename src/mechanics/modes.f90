!> Motion of the modes of a linear structure in closed form.
!!
!! A mode is a pair (x, v) with
!!
!!     x' = v + p,    v' = -omega^2 x - 2 sigma v + f
!!
!! and constant p and f, or p and f that grow linearly. With classical damping x is a modal
!! coordinate, v its velocity, and p = 0.
!! Other damping couples the modes of the undamped structure, but not the pairs made of its complex
!! eigenvectors. Under-, critically and over-damped pairs and those of frequency 0 differ only in
!! the functions u(t) (x if x = 1 and v = 0 at the start) and w(t) (x if x = 0 and v = 1 at the
!! start).
module vi_modes
   use vi_kinds, only: wp
   use vi_lane_rows, only: advance_pairs
   use vi_lane_rows_wide, only: advance_pairs_wide => advance_pairs
   use vi_lanes, only: largest_angle
   use vi_processor, only: runs_wide
   implicit none (type, external)
   private

   public :: advance, advance_in_place, advance_pair, bound_on, departure, new_interval, &
      new_steps, prepare, step_functions, steady_response, steady_slope

   !> Pairs of a structure.
   type, public :: modes_type
      !> (n) omega^2 >= 0 and sigma >= 0.
      real(wp), allocatable :: stiffness(:), damping(:)
      !> (n) The constant terms p and f.
      real(wp), allocatable :: drift(:), force(:)
      !> (n) The rates at which p and f grow.
      real(wp), allocatable :: drift_rate(:), force_rate(:)
      !> (n) What follows from them: omega, 1/omega (0 for omega = 0), sqrt(omega^2 - sigma^2) if it
      !! is real, and the formula that applies.
      real(wp), allocatable, dimension(:) :: omega, inverse, turn
      integer, allocatable :: kind(:)
      !> The pairs with constant terms or no special formula, the largest of `turn`, and whether
      !! enough pairs are no such ones to be advanced side by side; whether the processor has wide
      !! registers.
      integer, allocatable :: others(:)
      real(wp) :: fastest = 0
      logical :: abreast = .false., wide = .false.
      !> Numbers of pairs up to the last one with a frequency, and up to the last one that is no
      !! free mass without a force.
      integer :: turning = 0, bent = 0
      !> Whether any of the former is damped.
      logical :: damps = .false.
      !> Whether no pair is damped or has constant terms.
      logical :: conserves = .false.
   end type modes_type

   !> Formulas: a free mass; an oscillation below critical damping, without and with constant
   !! terms; any other pair.
   integer, parameter :: free_mass = 1, oscillating = 2, pushed = 3, other = 4
   !> Share of the time scale of a pair below which its responses are summed as series.
   real(wp), parameter :: short = 0.5_wp
   !> Number of pairs from which on they are advanced side by side.
   integer, parameter :: many = 8

   !> Number of step lengths of a table.
   integer, parameter, public :: levels = 24

   !> Coefficients that advance all pairs by one of several step lengths, each half the one before.
   type, public :: steps_type
      !> Step lengths.
      real(wp) :: length(levels) = 0
      !> (n, 6, levels) x from x = 1, from v = 1 and from the constant terms; v from the same.
      real(wp), allocatable :: map(:, :, :)
      !> (n, levels) x from f = 1 and from f = t.
      real(wp), allocatable, dimension(:, :) :: s2, s3
   end type steps_type

   !> What advances the pairs by an interval between two samples of a record.
   type, public :: interval_type
      !> (12, m) x from x = 1, v = 1, f = 1, f = t, p = 1 and p = t; v from the same.
      real(wp), allocatable :: map(:, :)
   end type interval_type

contains

   !> The functions u and w of a pair, and the responses to constant and linearly growing terms:
   !! s2'' + 2 sigma s2' + omega^2 s2 = 1, and s3 the integral of s2.
   elemental subroutine step_functions(stiffness, damping, t, u, w, s2, s3)
      !> omega^2 >= 0, sigma >= 0, and the time t, which may be negative.
      real(wp), intent(in) :: stiffness, damping, t
      !> x from x = 1, and x from v = 1.
      real(wp), intent(out) :: u, w
      !> x from a constant f = 1, and from f = t.
      real(wp), intent(out), optional :: s2, s3
      real(wp) :: square, rate, slow, fast, shrink

      square = (sqrt(stiffness) - damping)*(sqrt(stiffness) + damping)
      rate = sqrt(abs(square))
      slow = 0
      fast = 0
      if (.not. (stiffness > 0 .or. damping > 0)) then
         ! a free mass
         u = 1
         w = t
      else if (square > 0) then
         w = t
         if (abs(rate*t) > 1.0e-8_wp) w = sin(rate*t)/rate
         u = cos(rate*t) + damping*w
         if (damping > 0) then
            shrink = exp(-damping*t)
            u = shrink*u
            w = shrink*w
         end if
      else
         ! over-damped, and a free mass with a drag: exponentials with a slow and a fast rate
         fast = damping + rate
         slow = stiffness/fast
         shrink = exp(-slow*t)
         w = shrink*t*mean_decay(2*rate*t)
         u = shrink + slow*w
      end if
      if (.not. present(s2)) return
      if (.not. fast > 0 .and. .not. stiffness > 0) then
         s2 = 0.5_wp*t**2
         s3 = t**3/6
      else if (max(sqrt(stiffness), 2*damping)*abs(t) < short) then
         call short_responses(stiffness, damping, t, s2, s3)
      else if (fast > 0 .and. (rate*abs(t) > 0.25_wp .or. stiffness*t**2 < 0.05_wp)) then
         ! 1 - u would lose digits where the stiffness is small
         s2 = t*(mean_decay(slow*t) - mean_decay(fast*t))/(2*rate)
         s3 = t**2*(mean_lag(slow*t) - mean_lag(fast*t))/(2*rate)
      else
         s2 = (1 - u)/stiffness
         s3 = (t - w - 2*damping*s2)/stiffness
      end if
   end subroutine step_functions

   !> 1 - u of `step_functions` without loss of digits where u is near 1, as for a time that is
   !! nearly a multiple of the pair's own period.
   elemental real(wp) function departure(stiffness, damping, t)
      !> As in `step_functions`.
      real(wp), intent(in) :: stiffness, damping, t
      real(wp) :: u, w, s2, s3, rate

      call step_functions(stiffness, damping, t, u, w, s2, s3)
      departure = stiffness*s2
      if (.not. (sqrt(stiffness) > damping .and. u > 0.5_wp)) return
      rate = sqrt((sqrt(stiffness) - damping)*(sqrt(stiffness) + damping))
      ! u = e^(-sigma t) cos(rate t) + sigma w
      departure = damping*t*mean_decay(damping*t) + 2*exp(-damping*t)*sin(0.5_wp*rate*t)**2 &
         - damping*w
   end function departure

   !> (1 - exp(-z))/z, the mean of exp(-z) from 0 to z.
   elemental real(wp) function mean_decay(z)
      !> The argument.
      real(wp), intent(in) :: z

      if (abs(z) > 0.5_wp) then
         mean_decay = (1 - exp(-z))/z
      else
         mean_decay = power_series(z, 1)
      end if
   end function mean_decay

   !> (1 - mean_decay(z))/z.
   elemental real(wp) function mean_lag(z)
      !> The argument.
      real(wp), intent(in) :: z

      if (abs(z) > 0.5_wp) then
         mean_lag = (1 - (1 - exp(-z))/z)/z
      else
         mean_lag = power_series(z, 2)
      end if
   end function mean_lag

   !> The sum of (-z)^i/(i + first)! over i >= 0, for |z| up to 0.5.
   elemental real(wp) function power_series(z, first) result(total)
      !> The argument.
      real(wp), intent(in) :: z
      !> 1 or 2.
      integer, intent(in) :: first
      integer :: i

      total = 1
      do i = 14, 1, -1
         total = 1 - z/(i + first)*total
      end do
      total = total/first
   end function power_series

   !> s2 and s3 for short times, by their Taylor series.
   elemental subroutine short_responses(stiffness, damping, t, s2, s3)
      !> omega^2, sigma, t.
      real(wp), intent(in) :: stiffness, damping, t
      !> As in `step_functions`.
      real(wp), intent(out) :: s2, s3
      integer, parameter :: terms = 18
      integer :: i
      real(wp), parameter :: number(3:terms + 2) = [(real(i, wp), i=3, terms + 2)], &
         inverse(3:terms + 2) = 1/number
      real(wp) :: c, next

      ! the i-th term c of s3 is t^i/i! times its i-th derivative; s2 = s3'
      c = t**3/6
      next = -2*damping*c*(t*inverse(4))
      s3 = 0
      s2 = 0
      do i = 3, terms, 2
         s3 = s3 + c + next
         s2 = s2 + number(i)*c + number(i + 1)*next
         ! each further term is below half the sum of the last two over i
         if (abs(next) + abs(c) <= 0.25_wp*epsilon(1.0_wp)*abs(s2)) exit
         c = (-2*damping*next - stiffness*c*(t*inverse(i + 1)))*(t*inverse(i + 2))
         next = (-2*damping*c - stiffness*next*(t*inverse(i + 2)))*(t*inverse(i + 3))
      end do
      if (abs(t) > 0) s2 = s2/t
   end subroutine short_responses

   !> Completes pairs by what follows from their constants.
   pure subroutine prepare(modes, driven)
      !> In and out: the pairs.
      type(modes_type), intent(inout) :: modes
      !> Whether p and f are going to change.
      logical, intent(in) :: driven
      integer :: k, n

      n = size(modes%stiffness)
      allocate (modes%drift_rate(n), modes%force_rate(n), source=0.0_wp)
      modes%omega = sqrt(modes%stiffness)
      allocate (modes%inverse(n), modes%turn(n), source=0.0_wp)
      allocate (modes%kind(n), source=other)
      do k = 1, n
         associate (omega => modes%omega(k), damping => modes%damping(k))
            if (omega > 0) modes%inverse(k) = 1/omega
            if (omega > damping) modes%turn(k) = sqrt((omega - damping)*(omega + damping))
            if (driven) cycle
            if (abs(modes%force(k)) + abs(modes%drift(k)) > 0) then
               if (omega > damping .and. damping >= 0) modes%kind(k) = pushed
               cycle
            end if
            if (omega > damping) modes%kind(k) = oscillating
            if (.not. (omega > 0 .or. damping > 0)) modes%kind(k) = free_mass
         end associate
      end do
      modes%others = pack([(k, k=1, n)], modes%kind >= pushed)
      modes%abreast = n - size(modes%others) >= many
      modes%fastest = maxval([modes%turn, 0.0_wp])
      modes%turning = findloc(modes%turn > 0, .true., dim=1, back=.true.)
      modes%damps = any(modes%damping(:modes%turning) > 0)
      modes%bent = findloc(driven .or. modes%stiffness + modes%damping + abs(modes%force) &
         + abs(modes%drift) > 0, .true., dim=1, back=.true.)
      modes%conserves = all(modes%kind < pushed .and. .not. modes%damping > 0)
      modes%wide = runs_wide() /= 0
   end subroutine prepare

   !> The pairs after a given time, computed directly from their start.
   pure subroutine advance(modes, t, x, v, x_new, v_new)
      !> The pairs.
      type(modes_type), intent(in) :: modes
      !> Time; a negative one goes back.
      real(wp), intent(in) :: t
      !> (n) At the start.
      real(wp), contiguous, intent(in) :: x(:), v(:)
      !> (n) After that time.
      real(wp), contiguous, intent(out) :: x_new(:), v_new(:)
      integer :: i, k

      if (.not. (modes%abreast .and. t >= 0 .and. modes%fastest*t <= largest_angle)) then
         do k = 1, size(x)
            call advance_pair(modes, k, t, x(k), v(k), x_new(k), v_new(k))
         end do
         return
      end if
      if (modes%wide) then
         call advance_pairs_wide(size(x), modes%turning, modes%damps, t, modes%turn, &
            modes%damping, modes%stiffness, x, v, x_new, v_new)
      else
         call advance_pairs(size(x), modes%turning, modes%damps, t, modes%turn, modes%damping, &
            modes%stiffness, x, v, x_new, v_new)
      end if
      do i = 1, size(modes%others)
         k = modes%others(i)
         call advance_pair(modes, k, t, x(k), v(k), x_new(k), v_new(k))
      end do
   end subroutine advance

   !> As `advance`, with the pairs after the time in place of those at the start.
   pure subroutine advance_in_place(modes, t, x, v)
      !> The pairs.
      type(modes_type), intent(in) :: modes
      !> Time.
      real(wp), intent(in) :: t
      !> (n) In: at the start. Out: after that time.
      real(wp), contiguous, intent(inout) :: x(:), v(:)
      real(wp) :: x_old, v_old
      integer :: k

      if (modes%abreast) then
         call advance_copies(modes, t, x, v)
         return
      end if
      do k = 1, size(x)
         x_old = x(k)
         v_old = v(k)
         call advance_pair(modes, k, t, x_old, v_old, x(k), v(k))
      end do
   end subroutine advance_in_place

   !> As `advance_in_place`, from copies.
   pure subroutine advance_copies(modes, t, x, v)
      !> The pairs.
      type(modes_type), intent(in) :: modes
      !> Time.
      real(wp), intent(in) :: t
      !> (n) As in `advance_in_place`.
      real(wp), contiguous, intent(inout) :: x(:), v(:)
      real(wp) :: old(size(x), 2)

      old(:, 1) = x
      old(:, 2) = v
      call advance(modes, t, old(:, 1), old(:, 2), x, v)
   end subroutine advance_copies

   !> One pair after a given time.
   pure subroutine advance_pair(modes, k, t, x, v, x_new, v_new)
      !> The pairs.
      type(modes_type), intent(in) :: modes
      !> Number of the pair.
      integer, intent(in) :: k
      !> Time.
      real(wp), intent(in) :: t
      !> At the start.
      real(wp), intent(in) :: x, v
      !> After that time.
      real(wp), intent(out) :: x_new, v_new
      real(wp) :: damping, drift, force, shrink, stiffness, turn, u, w, s2, s3

      stiffness = modes%stiffness(k)
      damping = modes%damping(k)
      select case (modes%kind(k))
      case (free_mass)
         x_new = x + t*v
         v_new = v
      case (oscillating, pushed)
         turn = modes%turn(k)
         w = t
         if (abs(turn*t) > 1.0e-8_wp) w = sin(turn*t)/turn
         u = cos(turn*t)
         if (damping > 0) then
            shrink = exp(-damping*t)
            u = shrink*(u + damping*w)
            w = shrink*w
         end if
         x_new = u*x + w*v
         v_new = (u - 2*damping*w)*v - stiffness*w*x
         if (modes%kind(k) == oscillating) return
         if (max(modes%omega(k), 2*damping)*abs(t) < short) then
            call short_responses(stiffness, damping, t, s2, s3)
         else
            s2 = (1 - u)/stiffness
         end if
         force = modes%force(k)
         drift = modes%drift(k)
         x_new = x_new + force*s2 + drift*(w + 2*damping*s2)
         v_new = v_new + force*w - stiffness*drift*s2
      case default
         force = modes%force(k)
         drift = modes%drift(k)
         call step_functions(stiffness, damping, t, u, w, s2, s3)
         x_new = u*x + w*v + force*s2 + drift*(w + 2*damping*s2)
         v_new = (u - 2*damping*w)*v - stiffness*w*x + force*w - stiffness*drift*s2
         if (.not. abs(modes%force_rate(k)) + abs(modes%drift_rate(k)) > 0) return
         x_new = x_new + modes%force_rate(k)*s3 + modes%drift_rate(k)*(s2 + 2*damping*s3)
         v_new = v_new + modes%force_rate(k)*s2 - stiffness*modes%drift_rate(k)*s3
      end select
   end subroutine advance_pair

   !> Tables that advance the pairs by steps of given lengths.
   pure subroutine new_steps(modes, longest, steps)
      !> The pairs.
      type(modes_type), intent(in) :: modes
      !> The longest step.
      real(wp), intent(in) :: longest
      !> The tables.
      type(steps_type), intent(out) :: steps
      real(wp) :: u, w, s2, s3
      integer :: j, k, n

      n = size(modes%stiffness)
      allocate (steps%map(n, 6, levels), steps%s2(n, levels), steps%s3(n, levels))
      do j = 1, levels
         steps%length(j) = longest*0.5_wp**(j - 1)
         do k = 1, n
            associate (stiffness => modes%stiffness(k), damping => modes%damping(k))
               call step_functions(stiffness, damping, steps%length(j), u, w, s2, s3)
               steps%s2(k, j) = s2
               steps%s3(k, j) = s3
               steps%map(k, :3, j) = [u, w, modes%force(k)*s2 + modes%drift(k)*(w + 2*damping*s2)]
               steps%map(k, 4:, j) = [-stiffness*w, u - 2*damping*w, &
                  modes%force(k)*w - stiffness*modes%drift(k)*s2]
            end associate
         end do
      end do
   end subroutine new_steps

   !> The table of an interval.
   pure subroutine new_interval(modes, length, interval)
      !> The pairs.
      type(modes_type), intent(in) :: modes
      !> Length of the interval.
      real(wp), intent(in) :: length
      !> The table.
      type(interval_type), intent(out) :: interval
      real(wp) :: u, w, s2, s3
      integer :: k, m

      m = size(modes%force)
      allocate (interval%map(12, m))
      do k = 1, m
         associate (stiffness => modes%stiffness(k), drag => 2*modes%damping(k))
            call step_functions(stiffness, modes%damping(k), length, u, w, s2, s3)
            interval%map(:6, k) = [u, w, s2, s3, w + drag*s2, s2 + drag*s3]
            interval%map(7:, k) = [-stiffness*w, u - drag*w, w, s2, -stiffness*s2, -stiffness*s3]
         end associate
      end do
   end subroutine new_interval

   !> Bounds on |x| and |v| of a pair without constant terms, from now on.
   !!
   !! v^2 + omega^2 x^2 never grows. At frequency 0, x is the v of the derivative of the order
   !! below, and does not grow either. The bound on x that follows from v^2 + omega^2 x^2 is far too
   !! large where damping is far above the critical one: there x(t) = w' x + w (v + 2 sigma x), with
   !! |w'| <= 1 and 0 <= w <= 1/(2 sigma).
   elemental subroutine bound_on(stiffness, drag, x, v, of_x, of_v)
      !> omega^2 and 2 sigma.
      real(wp), intent(in) :: stiffness, drag
      !> Derivatives of order 2 or more of the pair.
      real(wp), intent(in) :: x, v
      !> The bounds.
      real(wp), intent(out) :: of_x, of_v
      real(wp) :: omega

      if (stiffness > 0) then
         omega = sqrt(stiffness)
         if (max(abs(v), omega*abs(x)) < 1.0e150_wp) then
            of_v = sqrt(v**2 + stiffness*x**2)
         else
            of_v = hypot(v, omega*x)              ! squares would overflow
         end if
         of_x = of_v/omega
         if (drag > 2*omega) of_x = min(of_x, abs(x) + abs(v + drag*x)/drag)
      else
         of_x = abs(x)
         of_v = abs(v)
      end if
   end subroutine bound_on

   !> The steady response of a pair to p = Re(drift e^(i h Omega t)), and f likewise.
   elemental subroutine steady_response(stiffness, damping, frequency, drift, force, x, v, resonant)
      !> omega^2, sigma, and the circular frequency of the load.
      real(wp), intent(in) :: stiffness, damping, frequency
      !> Complex amplitudes.
      complex(wp), intent(in) :: drift, force
      !> Complex amplitudes of x and v; 0 at a resonance.
      complex(wp), intent(out) :: x, v
      !> Whether an undamped mode resonates: then there is no steady response. Near a resonance it
      !! is so large that its difference from free vibration has lost digits.
      logical, intent(out) :: resonant
      !> Half of the least distance from a resonance; the relative errors grow as the inverse of the
      !! distance.
      real(wp), parameter :: nearest = 1.0e-9_wp
      complex(wp) :: divisor, turn

      x = 0
      v = 0
      turn = cmplx(0.0_wp, frequency, wp)
      divisor = cmplx(stiffness - frequency**2, 2*damping*frequency, wp)
      resonant = .false.
      if (.not. abs(drift) + abs(force) > 0) return
      resonant = .not. abs(divisor) > nearest*(stiffness + frequency**2)
      if (resonant) return
      x = ((turn + 2*damping)*drift + force)/divisor
      v = (turn*force - stiffness*drift)/divisor
   end subroutine steady_response

   !> The derivative of the steady response of a pair with respect to the frequency.
   elemental subroutine steady_slope(stiffness, damping, frequency, drift, force, x, v)
      !> As in `steady_response`.
      real(wp), intent(in) :: stiffness, damping, frequency
      !> Complex amplitudes of p and f.
      complex(wp), intent(in) :: drift, force
      !> The derivatives of x and v; 0 at a resonance.
      complex(wp), intent(out) :: x, v
      complex(wp), parameter :: i = (0.0_wp, 1.0_wp)
      complex(wp) :: divisor, slope
      logical :: resonant

      call steady_response(stiffness, damping, frequency, drift, force, x, v, resonant)
      if (resonant .or. .not. abs(drift) + abs(force) > 0) return
      divisor = cmplx(stiffness - frequency**2, 2*damping*frequency, wp)
      slope = cmplx(-2*frequency, 2*damping, wp)
      x = (i*drift - slope*x)/divisor
      v = (i*force - slope*v)/divisor
   end subroutine steady_slope

end module vi_modes
