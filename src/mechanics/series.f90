!> Search along the Taylor series of a function for the first time at which it reaches one of two
!! limits. No such time is missed.
!!
!! At any time a bound on the fourth derivative gives a step within which neither limit can be
!! reached (vi_advance). Such steps cannot jump over a contact, however short it is, and converge to
!! it with third order. Just after departure from a limit the distance g to it is a small difference
!! of large numbers. There g(t) = t k(t), with k(0) the departure speed, is evaluated by the series
!! of k, so that flights in an accumulation of impacts keep their relative accuracy.
module vi_series
   use vi_advance, only: safe_step
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: new_opening, tolerated, follow

   !> Order of the last term of a series.
   integer, parameter, public :: order = 20
   !> Steps after which a search is abandoned.
   integer, parameter, public :: step_budget = 10000000

   !> A Taylor series.
   type, public :: series_type
      !> Time about which it is, and how far it is valid.
      real(wp) :: centre = 0, reach = -1
      real(wp) :: c(0:order) = 0
      !> The last order that is used.
      integer :: last = order
      !> Bounds on the fifth derivative and on the one after the last, if all orders are used.
      real(wp) :: fifth = 0, beyond = 0
   end type series_type

   !> The limits of the function, and the distance g to the one that it leaves at time 0.
   type, public :: opening_type
      real(wp) :: upper = 0, lower = 0
      !> The limit that is left: +1 upper, -1 lower; 0 none. The order of the first derivative of g
      !! that is not 0: 1 with a speed of departure > 0, which is kept here.
      integer :: wall = 0, order = 1
      real(wp) :: speed = 0
      !> k(t) = g(t)/t, and the time up to which this series is valid.
      real(wp) :: k(0:order - 1) = 0, near = 0
      !> Bounds on the fourth and on the fifth derivative of g.
      real(wp) :: fourth = 0, fifth = 0
   end type opening_type

contains

   !> Completes what describes the departure from a limit.
   pure subroutine new_opening(series, opening)
      !> The series about the start, of all orders.
      type(series_type), intent(in) :: series
      !> In: limits, wall, order, speed and the bound on the fourth derivative. Out: complete.
      type(opening_type), intent(inout) :: opening
      integer :: m

      opening%fifth = series%fifth
      opening%k = -opening%wall*series%c(1:)
      ! the first term of k that is not 0
      m = opening%order - 1
      opening%k(:m - 1) = 0
      if (m == 0) opening%k(0) = opening%speed
      opening%near = 0
      if (.not. abs(opening%k(m)) > 0) return
      ! the omitted terms are below the rounding of the first one; twice this time must not overflow
      opening%near = min(0.25_wp*huge(1.0_wp), tolerated(epsilon(1.0_wp)*abs(opening%k(m)), &
         series%beyond, order - m))
   end subroutine new_opening

   !> The t at which bound t^n/(order + 1)! equals a tolerance.
   elemental real(wp) function tolerated(tolerance, bound, n) result(t)
      !> The tolerance, and the bound.
      real(wp), intent(in) :: tolerance, bound
      !> The power.
      integer, intent(in) :: n
      real(wp), parameter :: factorial = 51090942171709440000.0_wp

      t = huge(1.0_wp)
      if (bound > tiny(1.0_wp)) t = (tolerance*factorial/bound)**(1.0_wp/n)
   end function tolerated

   !> Searches for the first contact as far as a series is valid.
   pure subroutine follow(series, opening, walls, bound, longest, end, t, steps, wall, speed)
      !> The series.
      type(series_type), intent(in) :: series
      !> The limits, and the departure from one of them.
      type(opening_type), intent(in) :: opening
      !> Which limits may be reached: 1 the upper one, 2 the lower one, 3 both.
      integer, intent(in) :: walls
      !> Bound on the absolute fourth derivative.
      real(wp), intent(in) :: bound
      !> Longest step, and the end of the search.
      real(wp), intent(in) :: longest, end
      !> In: the time at which to begin. Out: that of the contact, or the time up to which there is
      !! none.
      real(wp), intent(inout) :: t
      !> In and out: steps so far; at `step_budget` the search ends.
      integer, intent(inout) :: steps
      !> Limit that is reached: +1 upper, -1 lower; 0 if none is. The approach speed.
      integer, intent(out) :: wall
      real(wp), intent(out) :: speed
      real(wp) :: d(0:3), h, step
      integer :: side

      wall = 0
      speed = 0
      do while (t <= end .and. t <= series%centre + series%reach .and. steps < step_budget)
         steps = steps + 1
         call evaluate(series, t, d)
         if (opening%wall /= 0 .and. t <= 0) d(:1) = [merge(opening%upper, opening%lower, &
            opening%wall > 0), -opening%wall*opening%speed]
         step = huge(1.0_wp)
         do side = 1, -1, -2
            if (iand(walls, merge(1, 2, side > 0)) == 0) cycle
            if (side == opening%wall .and. t < opening%near) then
               h = departure_step(opening, t)
               if (h <= 2*epsilon(1.0_wp)*t) speed = max(0.0_wp, departure_speed(opening%k, t))
            else
               h = safe_step(max(0.0_wp, side*(merge(opening%upper, opening%lower, side > 0) &
                  - d(0))), -side*d(1), -side*d(2), -side*d(3), bound, longest)
               if (h <= 2*epsilon(1.0_wp)*t) speed = max(0.0_wp, side*d(1))
            end if
            if (h <= 2*epsilon(1.0_wp)*t) then
               wall = side
               return
            end if
            step = min(step, h)
         end do
         t = t + step
      end do
   end subroutine follow

   !> Value and first three derivatives of a series.
   pure subroutine evaluate(series, t, d)
      !> The series.
      type(series_type), intent(in) :: series
      !> The time.
      real(wp), intent(in) :: t
      !> The derivatives of order 0 to 3.
      real(wp), intent(out) :: d(0:3)
      real(wp) :: s, value, slope, curvature, jerk
      integer :: i

      s = t - series%centre
      value = 0
      slope = 0
      curvature = 0
      jerk = 0
      ! at the centre the terms beyond the jerk do not count
      do i = merge(series%last, 3, abs(s) > 0), 0, -1
         jerk = jerk*s + curvature
         curvature = curvature*s + slope
         slope = slope*s + value
         value = value*s + series%c(i)
      end do
      d = [value, slope, 2*curvature, 6*jerk]
   end subroutine evaluate

   !> A safe step for the gap to the limit just left, from its series: |k''''| <= B/5 with B the
   !! bound on g'''''.
   pure real(wp) function departure_step(opening, t) result(step)
      !> The gap over time.
      type(opening_type), intent(in) :: opening
      !> Time after the start.
      real(wp), intent(in) :: t
      real(wp) :: value, slope, curvature, jerk, root
      integer :: n

      associate (k => opening%k, first => opening%order - 1, fourth => opening%fourth)
         if (t <= 0 .and. first > 0 .and. first < 3) then
            ! k/t >= k1 + k2 t - B/24 t^2: positive up to the first zero of this parabola; after a
            ! release k1 = 0
            root = sqrt(max(0.0_wp, k(2)**2 + k(1)*fourth/6))
            step = 0
            if (k(1) > 0 .and. k(2) <= 0) then
               step = 2*k(1)/max(root - k(2), 16*tiny(root)*max(1.0_wp, k(1)))
            else if (k(1) >= 0 .and. k(2) > 0) then
               step = 12*(k(2) + root)/max(fourth, 16*tiny(fourth)*max(1.0_wp, k(2) + root))
            end if
            step = min(opening%near, 0.99_wp*step)
            return
         else if (t <= 0 .and. first > 0) then
            ! up to this time the first term of k outweighs twice the sum of those that follow it
            step = 0
            if (k(first) > 0) step = opening%near
            do while (step > 0)
               value = 0
               do n = ubound(k, 1), first + 1, -1
                  value = (value + abs(k(n)))*step
               end do
               if (2*value <= k(first)) return
               step = 0.5_wp*step
            end do
            return
         end if
         value = 0
         slope = 0
         curvature = 0
         jerk = 0
         do n = ubound(k, 1), 0, -1
            jerk = jerk*t + curvature
            curvature = curvature*t + slope
            slope = slope*t + value
            value = value*t + k(n)
         end do
      end associate
      step = safe_step(max(0.0_wp, value), slope, 2*curvature, 6*jerk, 0.2_wp*opening%fifth, &
         2*opening%near)
   end function departure_step

   !> Approach speed -g' = -t k' at a zero of k.
   pure real(wp) function departure_speed(k, t) result(speed)
      !> Coefficients of g(t)/t.
      real(wp), intent(in) :: k(0:)
      !> Time of the zero.
      real(wp), intent(in) :: t
      integer :: n

      speed = 0
      do n = ubound(k, 1), 1, -1
         speed = speed*t + n*k(n)
      end do
      speed = -t*speed
   end function departure_speed

end module vi_series
