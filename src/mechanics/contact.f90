!> First contact: the first instant at which the free mass reaches a wall. No contact is missed.
!!
!! This is the reference method, which handles any flight: the search of vi_series along Taylor
!! series of the relative position. vi_march is the fast one for ordinary flights, falls back on
!! this one where it cannot decide, and is tested against it.
module vi_contact
   use vi_advance, only: patience
   use vi_flight, only: flight_position, flight_type
   use vi_kinds, only: wp
   use vi_oscillation, only: derivative_bound, derivatives
   use vi_parting, only: leading_order
   use vi_series, only: follow, new_opening, opening_type, order, series_type, step_budget, &
      tolerated
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
      !! wall. Otherwise a gap without speed opens by the first of its derivatives that is not 0.
      logical :: released = .false.
   end type departure_type

   !> A contact of a flight with a wall.
   type, public :: contact_type
      !> +1 or -1; 0 if there is no contact within the limit.
      integer :: side = 0
      !> Time of the contact after the start of the flight, and approach speed.
      real(wp) :: time = 0, speed = 0
      !> x and its derivatives at the contact. Assigned by name: flang 19 shifts an array that
      !! starts at 0 when a structure constructor fills it.
      real(wp) :: d(0:5) = 0
      !> False if the step budget ran out.
      logical :: complete = .true.
   end type contact_type

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
      type(series_type) :: series
      type(opening_type) :: opening
      real(wp) :: t, far(2), speed, value
      integer :: steps, wall
      logical :: near(2)

      if (departure%side /= 0 .and. departure%speed < 0) then
         contact = contact_type(departure%side, 0.0_wp, -departure%speed)
         contact%d = derivatives(flight, 0.0_wp)
         return
      end if
      t = 0
      opening%upper = half
      opening%lower = -half
      if (departure%side /= 0) then
         opening%wall = departure%side
         opening%speed = departure%speed
         opening%fourth = derivative_bound(flight, 4, t)
         if (.not. departure%speed > 0) call leading_order(flight, t, merge(3, &
            2, departure%released), opening%order, value)
         call expand(flight, t, series)
         call new_opening(series, opening)
      end if
      if (present(from)) t = from
      steps = 0
      do while (t <= limit .and. steps < step_budget)
         steps = steps + 1
         far = out_of_reach(flight, half, t)
         t = max(t, minval(far))
         if (t > limit) return
         call expand(flight, t, series)
         near = far <= t + series%reach
         call follow(series, opening, sum([1, 2], near), derivative_bound(flight, 4, t), &
            series%reach, limit, t, steps, wall, speed)
         if (wall == 0) then
            ! the last step may end beyond the reach of the series
            t = min(t, minval(far, .not. near))
            cycle
         end if
         contact%side = wall
         contact%time = t
         contact%d = derivatives(flight, t)
         contact%speed = max(0.0_wp, wall*(flight%z_dot - contact%d(1)))
         if (wall == departure%side .and. t < opening%near) contact%speed = speed
         return
      end do
      contact%complete = steps < step_budget
   end function first_contact

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
         reserve = half - side*flight_position(flight, t) - derivative_bound(flight, 0, t)
         speed = side*flight%z_dot
         time(i) = 0
         if (.not. reserve > 0) cycle
         time(i) = huge(1.0_wp)
         if (speed > 0 .and. reserve < speed*(huge(1.0_wp)*epsilon(1.0_wp))) then
            time(i) = t + reserve/speed
         end if
      end do
   end function out_of_reach

   !> The Taylor series of z - x about a time.
   pure subroutine expand(flight, t, series)
      !> Closed-form motion of both masses.
      type(flight_type), intent(in) :: flight
      !> The time (1/omega after the start of the flight).
      real(wp), intent(in) :: t
      !> The series, of all orders.
      type(series_type), intent(out) :: series
      real(wp) :: free(0:order), forced(0:order), z, shrink, s, c, factor
      integer :: n

      shrink = exp(-flight%decay*t)
      s = shrink*sin(flight%frequency*t)
      c = shrink*cos(flight%frequency*t)
      free(0) = flight%a*s + flight%b*c
      free(1) = flight%frequency*(flight%a*c - flight%b*s) - flight%decay*free(0)
      forced(0) = flight%amplitude*sin(flight%r*t + flight%phase)
      forced(1) = flight%amplitude*flight%r*cos(flight%r*t + flight%phase)
      factor = flight%decay**2 + flight%frequency**2
      do n = 2, order
         free(n) = -2*flight%decay*free(n - 1) - factor*free(n - 2)
         forced(n) = -flight%r**2*forced(n - 2)
      end do
      z = flight_position(flight, t)
      series%c = -(free + forced)
      series%c(0) = z + series%c(0)
      series%c(1) = flight%z_dot + series%c(1)
      factor = 1
      do n = 2, order
         factor = factor/n
         series%c(n) = series%c(n)*factor
      end do
      series%centre = t
      series%fifth = derivative_bound(flight, 5, t)
      series%beyond = derivative_bound(flight, order + 1, t)
      series%reach = tolerated(0.5_wp*epsilon(1.0_wp)*(abs(z) + derivative_bound(flight, 0, t)), &
         series%beyond, order + 1)
      ! beyond one time scale the terms would cancel each other, unless those of the free part are
      ! small
      if (t < patience) series%reach = min(1/max(1.0_wp, flight%r), series%reach)
   end subroutine expand

end module vi_contact
