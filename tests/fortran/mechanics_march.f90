!> The march along a flight compared with the plain search for the first contact.
module mechanics_march
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, draw_log, random_type
   use random_systems, only: pi
   use vi_contact, only: contact_type, departure_type, first_contact
   use vi_extrema, only: relative_extrema
   use vi_flight, only: flight_type, new_flight
   use vi_bounce, only: bounce
   use vi_kinds, only: wp
   use vi_march, only: march, sine_cosine, touch_type
   use vi_oscillation, only: derivative_bound, derivatives
   use vi_oscillator, only: gain, lag
   use vi_transition, only: new_transition, transition_type
   implicit none (type, external)
   private

   public :: test_march

   !> A flight away from a wall.
   type :: case_type
      type(flight_type) :: flight
      type(transition_type) :: transition
      !> The load, and its phase at the start.
      real(wp) :: load, load_phase
      type(departure_type) :: departure
      real(wp) :: half, limit
   end type case_type

contains

   subroutine test_march()
      type(random_type) :: random
      real(wp) :: decided

      call test_sine_cosine(random)
      call compare_flights(random, 20000, .false., decided)
      call check(decided > 0.7_wp, 'most flights are decided by the march')
      call compare_flights(random, 5000, .true., decided)
      call test_long_drift()
      call test_idle()
   end subroutine test_march

   !> Sine and cosine of load phases, including both ends and the limits of the pieces.
   subroutine test_sine_cosine(random)
      type(random_type), intent(inout) :: random
      real(wp) :: phase, s, c
      integer :: i

      do i = 0, 20000
         phase = draw(random, 0.0_wp, 2*pi)
         if (i <= 128) phase = nearest(i*(2*pi/128), 1.0_wp - mod(i, 3))
         call sine_cosine(max(0.0_wp, phase), s, c)
         call check_close(s, sin(max(0.0_wp, phase)), 1.5_wp*epsilon(s), 'sine of a phase')
         call check_close(c, cos(max(0.0_wp, phase)), 1.5_wp*epsilon(c), 'cosine of a phase')
      end do
   end subroutine test_sine_cosine

   !> Random flights; `grazing` ones pass or miss the other wall by 1e-2 to 1e-12 of the
   !! clearance.
   subroutine compare_flights(random, count, grazing, decided)
      type(random_type), intent(inout) :: random
      integer, intent(in) :: count
      logical, intent(in) :: grazing
      !> Fraction of flights that the march decides.
      real(wp), intent(out) :: decided
      type(case_type) :: c
      integer :: i, n

      n = 0
      do i = 1, count
         call random_case(random, c)
         if (grazing) then
            call graze(random, c)
            if (.not. c%half > 0) cycle
         end if
         call compare(c, n)
      end do
      decided = real(n, wp)/count
   end subroutine compare_flights

   !> A flight that leaves a wall, slowly or fast, with any clearance.
   subroutine random_case(random, c)
      type(random_type), intent(inout) :: random
      type(case_type), intent(out) :: c
      real(wp) :: xi, r, load, x, x_dot, phase, size

      xi = draw_log(random, 1e-4_wp, 0.95_wp)
      if (draw_integer(random, 1, 6) == 1) xi = 0
      do
         r = draw_log(random, 0.05_wp, 20.0_wp)
         if (abs(r - 1) > 1e-3_wp) exit
      end do
      load = real(min(1, draw_integer(random, 0, 6)), wp)
      size = draw_log(random, 0.1_wp, 10.0_wp)
      x = size*draw(random, -1.0_wp, 1.0_wp)
      x_dot = size*draw(random, -1.0_wp, 1.0_wp)
      phase = draw(random, 0.0_wp, 2*pi)
      c%half = size*draw_log(random, 1e-4_wp, 1e2_wp)
      if (draw_integer(random, 1, 2) == 1) c%half = size*draw(random, 0.1_wp, 3.0_wp)
      c%departure%side = 2*draw_integer(random, 0, 1) - 1
      c%departure%speed = size*draw_log(random, 1e-9_wp, 1e3_wp)
      if (draw_integer(random, 1, 2) == 1) c%departure%speed = size*draw(random, 0.0_wp, 3.0_wp)
      c%limit = draw_log(random, 0.1_wp, 300.0_wp)
      c%flight = new_flight(xi, r, load*gain(xi, r), phase, x, x_dot, &
         x + c%departure%side*c%half, x_dot - c%departure%side*c%departure%speed, c%limit)
      call begin(c, load*gain(xi, r), lag(xi, r))
   end subroutine random_case

   !> The tables and the start of a case.
   subroutine begin(c, amplitude, lag)
      type(case_type), intent(inout) :: c
      real(wp), intent(in) :: amplitude, lag

      call new_transition(c%flight%decay, c%flight%r, amplitude*cos(lag), amplitude*sin(lag), &
         c%transition)
      c%load_phase = c%flight%phase + lag
      c%load = amplitude/gain(c%flight%decay, c%flight%r)
   end subroutine begin

   !> The bounce, or the march.
   subroutine run(c, touch)
      type(case_type), intent(in) :: c
      type(touch_type), intent(out) :: touch
      real(wp) :: d(0:5), time, approach

      d = derivatives(c%flight, 0.0_wp)
      call bounce(c%transition, c%load, sin(c%load_phase), cos(c%load_phase), d(0), d(1), &
         c%departure%side, c%departure%speed, 2*c%half, time, approach)
      touch = touch_type(c%departure%side, time, d(0) + c%flight%z_dot*time, &
         c%flight%z_dot - c%departure%side*approach)
      if (.not. time > 0) then
         call march(c%transition, sin(c%load_phase), cos(c%load_phase), d(0), d(1), c%flight%z, &
            c%flight%z_dot, c%half, c%departure%side, c%departure%speed, c%limit, touch)
      end if
   end subroutine run

   !> Puts the other wall slightly before or beyond the farthest point of the mass.
   subroutine graze(random, c)
      type(random_type), intent(inout) :: random
      type(case_type), intent(inout) :: c
      real(wp) :: lowest, highest, far, clearance, d(0:5)
      logical :: complete

      call relative_extrema(c%flight, lowest, highest, complete)
      ! the distance from the wall to the farthest stationary point
      far = c%departure%side*c%half - lowest
      if (c%departure%side < 0) far = highest + c%half
      c%half = -1
      if (.not. (far > 1e-3_wp .and. far < 1e3_wp)) return
      clearance = far*(1 + (2*draw_integer(random, 0, 1) - 1)*draw_log(random, 1e-12_wp, 1e-2_wp))
      c%half = 0.5_wp*clearance
      d = derivatives(c%flight, 0.0_wp)
      c%flight%z = d(0) + c%departure%side*c%half
   end subroutine graze

   !> Finds the contact with both methods, and counts the flights that the march decides.
   subroutine compare(c, n)
      type(case_type), intent(in) :: c
      integer, intent(inout) :: n
      type(contact_type) :: plain, careful
      type(touch_type) :: touch
      real(wp) :: d(0:5), size, slack

      plain = first_contact(c%flight, c%half, c%departure, c%limit)
      call run(c, touch)
      if (touch%side /= 0 .or. touch%time > c%limit) n = n + 1
      if (touch%side == 0 .and. touch%time <= c%limit) then
         careful = first_contact(c%flight, c%half, c%departure, c%limit, touch%time)
         touch = touch_type(careful%side, careful%time, careful%d(0), careful%d(1))
      else if (touch%time > c%limit) then
         touch%side = 0
      end if
      if (abs(plain%time - c%limit) < 1e-9_wp) return
      call check(touch%side == plain%side, 'the same wall')
      if (touch%side == 0 .or. touch%side /= plain%side) return
      d = derivatives(c%flight, touch%time)
      size = abs(c%flight%z) + abs(c%flight%z_dot)*touch%time + c%half &
         + derivative_bound(c%flight, 0, 0.0_wp)
      slack = 32*epsilon(1.0_wp)*(size + derivative_bound(c%flight, 1, 0.0_wp)*touch%time)
      call check_close(touch%x, d(0), slack, 'x')
      call check_close(touch%x_dot, d(1), slack*max(1.0_wp, c%flight%r), 'velocity')
      call check_close((touch%time - plain%time)*plain%speed, 0.0_wp, slack, 'time times speed')
      if (touch%side /= c%departure%side .or. touch%time*max(1.0_wp, c%flight%r) > 0.06_wp) return
      slack = (1 + derivative_bound(c%flight, 2, 0.0_wp)*plain%time/c%departure%speed)*plain%time
      call check_close(touch%time, plain%time, 32*epsilon(1.0_wp)*slack, &
         'relative time of a bounce')
   end subroutine compare

   !> A slow drift with an oscillation: the first of many thousands of crests to reach the wall.
   subroutine test_long_drift()
      type(case_type) :: c
      real(wp) :: a
      integer :: i, n

      n = 0
      a = gain(0.1_wp, 1.3_wp)
      do i = 1, 20
         c%half = 1.5_wp*a
         c%limit = 1e6_wp
         c%departure = departure_type(-1, 1e-4_wp*i)
         c%flight = new_flight(0.1_wp, 1.3_wp, a, 0.5_wp*pi, a, 0.0_wp, a - c%half, 1e-4_wp*i, &
            c%limit)
         call begin(c, a, lag(0.1_wp, 1.3_wp))
         call compare(c, n)
      end do
   end subroutine test_long_drift

   !> A drift for millions of time units after the oscillation has decayed.
   subroutine test_idle()
      type(case_type) :: c
      type(touch_type) :: touch
      integer :: n

      n = 0
      c%half = 3
      c%limit = 1e9_wp
      c%departure = departure_type(-1, 1 + 1e-7_wp)
      c%flight = new_flight(0.1_wp, 0.9_wp, 0.0_wp, 0.0_wp, 1.0_wp, -1.0_wp, -2.0_wp, 1e-7_wp, &
         c%limit)
      call begin(c, 0.0_wp, 1.0_wp)
      call compare(c, n)
      call run(c, touch)
      call check(touch%side == 1, 'a drift to the right ends at the right wall')
      call check_close(1e-7_wp*touch%time, 5.0_wp, 1e-13_wp, 'and lasts as long as it has to')
   end subroutine test_idle

end module mechanics_march
