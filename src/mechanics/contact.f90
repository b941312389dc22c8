!> First contact: the first instant at which the free mass reaches a wall. No contact is missed.
!!
!! This is the reference method, which handles any flight. vi_march is the fast one for ordinary
!! flights, falls back on this one where it cannot decide, and is tested against it.
!!
!! At any instant a bound on the fourth derivative of the gaps gives a time within which neither
!! gap can close. Steps of that length cannot jump over a contact, however short it is, and converge
!! to it with third order. Just after departure from a wall the gap to that wall is a small
!! difference of large numbers. There its Taylor series is used instead: g(t) = t k(t) with k(0) the
!! departure speed, so that flights in an accumulation of impacts keep their relative accuracy.
module vi_contact
   use vi_advance, only: safe_step
   use vi_flight, only: flight_type
   use vi_kinds, only: wp
   use vi_oscillation, only: derivative_bound, derivatives
   implicit none (type, external)
   private

   public :: first_contact

   !> How a flight begins: on a wall (side +1 right, -1 left) with a departure speed relative to it
   !! (omega F0/K), or between the walls (side 0). A negative speed means that it begins with a
   !! contact.
   type, public :: departure_type
      integer :: side = 0
      real(wp) :: speed = 0
      !> Whether the gap opens from rest, where its second derivative is 0: the end of a rest on the
      !! wall.
      logical :: released = .false.
   end type departure_type

   !> A contact of a flight with a wall.
   type, public :: contact_type
      !> +1 or -1; 0 if there is no contact within the limit.
      integer :: side = 0
      !> Time of the contact after the start of the flight, and approach speed.
      real(wp) :: time = 0, speed = 0
      !> x and its derivatives at the contact. Assigned by name: flang 19 shifts an array that
      !> starts at 0 when a structure constructor fills it.
      real(wp) :: d(0:5) = 0
      !> False if the step budget ran out.
      logical :: complete = .true.
   end type contact_type

   integer, parameter :: step_budget = 10000000
   !> Terms of the Taylor series of k, and the time (over the shortest time scale) for which it is
   !> used: the omitted terms are below 0.1^10/10! = 3e-17 of the amplitude.
   integer, parameter :: terms = 9
   real(wp), parameter :: taylor_time = 0.1_wp

contains

   !> The first contact of a flight with a wall within a time limit.
   pure function first_contact(flight, half, departure, limit, from) result(contact)
      !> Closed-form motion of both masses; its time 0 is the start of the flight.
      type(flight_type), intent(in) :: flight
      !> Half the clearance (F0/K): the walls are at y = z - x = -half and y = +half.
      real(wp), intent(in) :: half
      !> Wall that the free mass leaves at time 0, and its speed relative to it.
      type(departure_type), intent(in) :: departure
      !> Latest time (1/omega after the start) of a contact that is reported.
      real(wp), intent(in) :: limit
      !> Time (1/omega) before which there is certainly no contact; 0 by default.
      real(wp), intent(in), optional :: from
      type(contact_type) :: contact

      if (departure%side /= 0 .and. departure%speed < 0) then
         contact = contact_type(departure%side, 0.0_wp, -departure%speed)
         contact%d = derivatives(flight, 0.0_wp)
      else if (present(from)) then
         contact = contact_after(flight, half, departure, limit, from)
      else
         contact = contact_after(flight, half, departure, limit, 0.0_wp)
      end if
   end function first_contact

   !> The first contact of a flight that is known to have none before the time `from`.
   pure function contact_after(flight, half, departure, limit, from) result(contact)
      !> Closed-form motion of both masses; its time 0 is the start of the flight.
      type(flight_type), intent(in) :: flight
      !> Half the clearance (F0/K).
      real(wp), intent(in) :: half
      !> Wall that the free mass leaves at time 0, and its speed >= 0 relative to it.
      type(departure_type), intent(in) :: departure
      !> Latest time (1/omega after the start) of a contact that is reported.
      real(wp), intent(in) :: limit
      !> Time (1/omega) at which the search starts.
      real(wp), intent(in) :: from
      type(contact_type) :: contact
      real(wp) :: t, step, other, reach, bound, near, far(2), k(0:terms - 1), d(0:5)
      integer :: n, first, side

      t = from
      near = 0
      if (departure%side /= 0) near = taylor_time/max(1.0_wp, flight%r)
      k = gap_series(flight, departure)
      reach = 3/max(1.0_wp, flight%r)
      bound = derivative_bound(flight, 4, t)
      far = out_of_reach(flight, half, t)
      do n = 1, step_budget
         if (mod(n, 16) == 0) then
            bound = derivative_bound(flight, 4, t)
            far = max(far, out_of_reach(flight, half, t))
         end if
         d = derivatives(flight, t)
         ! the wall that is approached comes first: the step for the other one need not be longer
         first = merge(1, -1, flight%z_dot >= d(1))
         step = gap_step(first, reach)
         other = gap_step(-first, min(step, reach))
         side = merge(first, -first, step <= other)
         step = min(step, other)
         if (step <= 2*epsilon(1.0_wp)*t) then
            contact = contact_type(side, t, max(0.0_wp, side*(flight%z_dot - d(1))))
            contact%d = d
            if (side == departure%side .and. t < near) then
               contact%speed = max(0.0_wp, series_speed(k, t))
            end if
            return
         end if
         t = t + step
         if (t > limit) return
      end do
      contact%complete = .false.
   contains
      !> A safe step for the gap to the wall of a side, no longer than needed.
      pure real(wp) function gap_step(side, longest) result(h)
         !> Wall: +1 right, -1 left.
         integer, intent(in) :: side
         !> Longest step (1/omega) that is wanted.
         real(wp), intent(in) :: longest
         real(wp) :: gap

         if (side == departure%side .and. t < near) then
            h = series_step(flight, k, departure, t, near)
         else
            gap = max(0.0_wp, half - side*(flight%z + flight%z_dot*t - d(0)))
            h = safe_step(gap, side*(d(1) - flight%z_dot), side*d(2), side*d(3), bound, longest)
            h = max(h, far(merge(1, 2, side > 0)) - t)
         end if
      end function gap_step
   end function contact_after

   !> Times before which no contact with the right and the left wall is possible, as certain at time
   !! t.
   pure function out_of_reach(flight, half, t) result(time)
      !> Closed-form motion of both masses.
      type(flight_type), intent(in) :: flight
      !> Half the clearance (F0/K).
      real(wp), intent(in) :: half
      !> Time (1/omega) from which the bound on |x| holds.
      real(wp), intent(in) :: t
      real(wp) :: time(2), reserve, speed
      integer :: i, side

      do i = 1, 2
         side = 3 - 2*i
         reserve = half - side*(flight%z + flight%z_dot*t) - derivative_bound(flight, 0, t)
         speed = side*flight%z_dot
         time(i) = 0
         if (.not. reserve > 0) cycle
         time(i) = huge(1.0_wp)
         if (speed > 0 .and. reserve < speed*(huge(1.0_wp)*epsilon(1.0_wp))) then
            time(i) = t + reserve/speed
         end if
      end do
   end function out_of_reach

   !> Coefficients of k(t) = g(t)/t, the gap to the wall just left over time.
   pure function gap_series(flight, departure) result(k)
      !> Closed-form motion of both masses.
      type(flight_type), intent(in) :: flight
      !> Wall just left, the departure speed k(0), and whether the gap opens from rest.
      type(departure_type), intent(in) :: departure
      real(wp) :: k(0:terms - 1)
      real(wp) :: free(0:terms), forced(0:terms), factorial
      integer :: n

      free(0) = flight%b
      free(1) = flight%frequency*flight%a - flight%decay*flight%b
      forced(0) = flight%amplitude*sin(flight%phase)
      forced(1) = flight%amplitude*flight%r*cos(flight%phase)
      k(0) = departure%speed
      factorial = 1
      do n = 2, terms
         free(n) = -2*flight%decay*free(n - 1) - (flight%decay**2 + flight%frequency**2)*free(n - 2)
         forced(n) = -flight%r**2*forced(n - 2)
         factorial = factorial*n
         k(n - 1) = departure%side*(free(n) + forced(n))/factorial
      end do
      if (departure%released) k(1) = 0
   end function gap_series

   !> A safe step for the gap to the wall just left, from its series.
   !!
   !! |k''''| <= B/5 with B a bound on the fifth derivative of the gap.
   pure real(wp) function series_step(flight, k, departure, t, near) result(step)
      !> Closed-form motion of both masses, for the bounds on its derivatives.
      type(flight_type), intent(in) :: flight
      !> Taylor coefficients of g(t)/t from `gap_series`.
      real(wp), intent(in) :: k(0:)
      !> Only `released` is read: whether the gap opens from rest.
      type(departure_type), intent(in) :: departure
      !> Time after the start of the flight (1/omega).
      real(wp), intent(in) :: t
      !> End of the time (1/omega after the start) in which the series is used.
      real(wp), intent(in) :: near
      real(wp) :: value, slope, curvature, jerk, bound
      integer :: n

      if (t <= 0 .and. departure%released) then
         ! k = k2 t^2 + ..: positive as long as the fourth derivative of the gap cannot outweigh
         ! this term
         bound = derivative_bound(flight, 4, 0.0_wp)
         step = min(near, 23.9_wp*max(0.0_wp, k(2))/max(bound, tiny(bound)))
         return
      end if
      bound = 0.2_wp*derivative_bound(flight, 5, 0.0_wp)
      value = 0
      slope = 0
      curvature = 0
      jerk = 0
      do n = ubound(k, 1), 0, -1
         jerk = jerk*t + 3*curvature
         curvature = curvature*t + 2*slope
         slope = slope*t + value
         value = value*t + k(n)
      end do
      step = safe_step(max(0.0_wp, value), slope, curvature, jerk, bound, 2*near)
   end function series_step

   !> Approach speed -g' = -t k' at a zero of k.
   pure real(wp) function series_speed(k, t) result(speed)
      !> Taylor coefficients of g(t)/t from `gap_series`.
      real(wp), intent(in) :: k(0:)
      !> Time of the zero of k (1/omega after the start).
      real(wp), intent(in) :: t
      integer :: n

      speed = 0
      do n = ubound(k, 1), 1, -1
         speed = speed*t + n*k(n)
      end do
      speed = -t*speed
   end function series_speed

end module vi_contact
