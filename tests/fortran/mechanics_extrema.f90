!> Certified extrema compared with dense sampling, and in cases that sampling cannot resolve.
module mechanics_extrema
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_log, random_type
   use random_systems, only: pi, random_flight
   use vi_extrema, only: relative_extrema
   use vi_flight, only: flight_position, flight_state, flight_type, new_flight
   use vi_kinds, only: wp
   use vi_oscillation, only: derivative_bound
   implicit none (type, external)
   private

   public :: test_extrema

   type(random_type) :: random

contains

   subroutine test_extrema()
      call test_random_flights()
      call test_high_frequency()
      call test_long_flights()
      call test_narrow_pairs()
      call test_brief_flights()
      call test_exact_zeros()
      call test_symmetry()
   end subroutine test_extrema

   !> The relative position z - x at time t.
   real(wp) function relative(flight, t)
      type(flight_type), intent(in) :: flight
      real(wp), intent(in) :: t
      real(wp) :: x, x_dot, x_ddot

      call flight_state(flight, t, x, x_dot, x_ddot)
      relative = flight_position(flight, t) - x
   end function relative

   !> No sample leaves the range of the extrema and the ends, and the range is as narrow as
   !! possible: between two samples the position rises by at most B dt^2/8.
   subroutine compare_with_samples(flight, samples, what)
      type(flight_type), intent(in) :: flight
      integer, intent(in) :: samples
      character(*), intent(in) :: what
      real(wp) :: lowest, highest, least, greatest, value, slack, rounding, ends(2)
      logical :: complete
      integer :: i

      call relative_extrema(flight, lowest, highest, complete)
      call check(complete, what // ': complete')
      call check(lowest <= highest .or. highest < lowest - huge(1.0_wp), what // ': both or none')
      ends = [relative(flight, 0.0_wp), relative(flight, flight%duration)]
      least = minval(ends)
      greatest = maxval(ends)
      do i = 1, samples - 1
         value = relative(flight, i*flight%duration/samples)
         least = min(least, value)
         greatest = max(greatest, value)
      end do
      rounding = 1e-14_wp*(abs(flight%z) + abs(flight%z_dot)*flight%duration &
         + derivative_bound(flight, 2, 0.0_wp)*(1 + flight%duration) + flight%amplitude)
      slack = derivative_bound(flight, 2, 0.0_wp)*(flight%duration/samples)**2/8 + rounding
      call check(min(lowest, minval(ends)) <= least + rounding, what // ': no sample is lower')
      call check(max(highest, maxval(ends)) >= greatest - rounding, what // ': no sample is higher')
      call check(min(lowest, minval(ends)) >= least - slack, what // ': the least value is reached')
      call check(max(highest, maxval(ends)) <= greatest + slack, &
         what // ': the greatest is reached')
   end subroutine compare_with_samples

   subroutine test_random_flights()
      type(flight_type) :: flight
      integer :: i

      do i = 1, 3000
         call random_flight(random, flight)
         call compare_with_samples(flight, 400, 'random flight')
         flight%z = 0
         flight%z_dot = 0
         call compare_with_samples(flight, 400, 'primary mass alone')
      end do
   end subroutine test_random_flights

   !> A fast small ripple on a slow flight.
   subroutine test_high_frequency()
      type(flight_type) :: flight
      real(wp) :: r, amplitude, phase, z_dot
      integer :: i

      do i = 1, 300
         r = draw_log(random, 20.0_wp, 1e3_wp)
         amplitude = draw(random, 0.0_wp, 2.0_wp)/r
         phase = draw(random, 0.0_wp, 2*pi)
         z_dot = draw(random, -3.0_wp, 3.0_wp)
         flight = new_flight(0.01_wp, r, amplitude, phase, 1.0_wp, -0.5_wp, 0.0_wp, z_dot, 40/r)
         call compare_with_samples(flight, 2000, 'high frequency')
      end do
   end subroutine test_high_frequency

   !> Hundreds of oscillations, undamped and damped.
   subroutine test_long_flights()
      type(flight_type) :: flight
      real(wp) :: xi, r, z_dot
      integer :: i

      do i = 1, 20
         xi = merge(0.0_wp, 0.02_wp, i <= 10)
         r = draw(random, 0.5_wp, 2.0_wp)
         z_dot = draw(random, -0.01_wp, 0.01_wp)
         flight = new_flight(xi, r, 1.0_wp, 0.3_wp, 0.0_wp, 1.0_wp, 0.0_wp, z_dot, 1500.0_wp)
         call compare_with_samples(flight, 30000, 'long flight')
      end do
   end subroutine test_long_flights

   !> Two stationary points a time 2 delta apart, where x' nearly vanishes: none may be lost, and
   !! where x' misses z' by a similar amount, none may be found.
   subroutine test_narrow_pairs()
      type(flight_type) :: flight, whole
      real(wp) :: delta, t, state(3), third, lowest, highest, y, missed
      logical :: complete
      integer :: i, power

      do i = 1, 200
         call random_flight(random, whole)
         call find_inflection(whole, t, state, third)
         if (.not. abs(third) > 0.2_wp) cycle
         do power = 2, 6
            delta = 10.0_wp**(-power)
            flight = around(whole, t, state, state(2) + 0.5_wp*third*delta**2)
            y = relative(flight, 0.5_wp*flight%duration)
            call relative_extrema(flight, lowest, highest, complete)
            missed = max(1e-13_wp, 40*delta**3)*(1 + derivative_bound(whole, 3, 0.0_wp))
            call check_close(lowest, y, missed, 'narrow pair: lowest')
            call check_close(highest, y, missed, 'narrow pair: highest')
            flight = around(whole, t, state, state(2) - 0.5_wp*third*delta**2)
            call relative_extrema(flight, lowest, highest, complete)
            if (power <= 4) then
               call check(lowest > highest, 'a near miss is no stationary point')
            else if (lowest <= highest) then
               call check_close(lowest, y, 1e-9_wp, 'a near miss is at most taken for a touch')
            end if
         end do
      end do
   end subroutine test_narrow_pairs

   !> A zero of x'' by bisection, with the state and the third derivative there.
   subroutine find_inflection(flight, t, state, third)
      type(flight_type), intent(in) :: flight
      real(wp), intent(out) :: t, state(3), third
      real(wp) :: low, high, first(3), ahead(3), behind(3)
      integer :: i

      low = draw(random, 0.0_wp, 3.0_wp)
      high = low
      call flight_state(flight, low, first(1), first(2), first(3))
      do
         high = high + 0.01_wp
         call flight_state(flight, high, state(1), state(2), state(3))
         if (first(3)*state(3) <= 0 .or. high > 50) exit
      end do
      low = high - 0.01_wp
      do i = 1, 60
         t = 0.5_wp*(low + high)
         call flight_state(flight, t, state(1), state(2), state(3))
         if (first(3)*state(3) > 0) then
            low = t
         else
            high = t
         end if
      end do
      call flight_state(flight, t + 1e-3_wp, ahead(1), ahead(2), ahead(3))
      call flight_state(flight, t - 1e-3_wp, behind(1), behind(2), behind(3))
      third = (ahead(3) - behind(3))/2e-3_wp
      if (high > 50) third = 0                                                 ! none found
   end subroutine find_inflection

   !> The part of a flight around an instant, short enough for x'' to have no other zero there.
   type(flight_type) function around(whole, t, state, z_dot)
      type(flight_type), intent(in) :: whole
      real(wp), intent(in) :: t, state(3), z_dot
      real(wp) :: start(3), half

      ! |x''''| <= B, so x''' keeps its sign this long
      half = 0.1_wp/(1 + derivative_bound(whole, 4, 0.0_wp))
      half = max(half, 0.02_wp)
      call flight_state(whole, t - half, start(1), start(2), start(3))
      around = new_flight(whole%decay, whole%r, whole%amplitude, whole%phase + whole%r*(t - half), &
         start(1), start(2), state(1), z_dot, 2*half)
   end function around

   !> Flights shorter than the resolution, and of zero duration.
   subroutine test_brief_flights()
      type(flight_type) :: flight
      real(wp) :: lowest, highest
      logical :: complete
      integer :: i

      do i = 0, 30
         call random_flight(random, flight)
         flight%duration = 10.0_wp**(-i)
         call compare_with_samples(flight, 10, 'brief flight')
      end do
      flight%duration = 0
      call relative_extrema(flight, lowest, highest, complete)
      call check(complete .and. lowest > highest, 'a flight without duration has no extrema')
   end subroutine test_brief_flights

   !> The rate is exactly zero at the end of a step, and over the whole flight.
   subroutine test_exact_zeros()
      type(flight_type) :: flight
      real(wp) :: lowest, highest
      logical :: complete

      ! x = sin t, z = -t: the rate 1 + cos t touches zero at pi, and is 0 in floating point around
      ! it
      flight = new_flight(0.0_wp, 1.5_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, -1.0_wp, 6.0_wp)
      call relative_extrema(flight, lowest, highest, complete)
      call check_close(lowest, -pi, 1e-14_wp, 'a touch of the rate: lowest')
      call check_close(highest, -pi, 1e-14_wp, 'a touch of the rate: highest')
      ! x = sin t, z = t: the rate is zero at the start, together with its derivative
      flight = new_flight(0.0_wp, 1.5_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 1.0_wp, 6.0_wp)
      call relative_extrema(flight, lowest, highest, complete)
      call check(complete .and. highest < 1e-14_wp, 'a start from relative rest')
      ! nothing moves at all
      flight = new_flight(0.1_wp, 1.5_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 6.0_wp)
      call relative_extrema(flight, lowest, highest, complete)
      call check(complete .and. .not. highest > 1.0_wp, 'rest')
      ! only the free mass moves
      flight%z_dot = 2
      call relative_extrema(flight, lowest, highest, complete)
      call check(complete .and. lowest > highest, 'a straight line has no extrema')
   end subroutine test_exact_zeros

   !> The mirror image of a flight has the mirrored extrema.
   subroutine test_symmetry()
      type(flight_type) :: flight, mirror
      real(wp) :: lowest, highest, mirror_lowest, mirror_highest
      logical :: complete
      integer :: i

      do i = 1, 500
         call random_flight(random, flight)
         mirror = flight
         mirror%a = -flight%a
         mirror%b = -flight%b
         mirror%amplitude = -flight%amplitude
         mirror%z = -flight%z
         mirror%z_dot = -flight%z_dot
         call relative_extrema(flight, lowest, highest, complete)
         call relative_extrema(mirror, mirror_lowest, mirror_highest, complete)
         if (lowest > highest) then
            call check(mirror_lowest > mirror_highest, 'neither has extrema')
            cycle
         end if
         call check_close(lowest, -mirror_highest, 1e-13_wp*(1 + abs(lowest)), 'mirrored extrema')
         call check_close(highest, -mirror_lowest, 1e-13_wp*(1 + abs(highest)), 'mirrored extrema')
      end do
   end subroutine test_symmetry

end module mechanics_extrema
