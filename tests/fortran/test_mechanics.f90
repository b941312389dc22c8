!> Tests of mechanics: the oscillator, impacts, flights and their extrema.
program test_mechanics
   use checks, only: check, check_close, finish
   use mechanics_bounds, only: test_bounds
   use mechanics_channels, only: test_channels
   use mechanics_decoupling, only: test_decoupling
   use mechanics_extrema, only: test_extrema
   use mechanics_march, only: test_march
   use mechanics_moments, only: test_moments
   use mechanics_rest, only: test_rest
   use mechanics_simultaneous, only: test_simultaneous
   use mechanics_structure, only: test_structure
   use random_numbers, only: draw, random_type
   use random_systems, only: pi, random_flight, random_frequency, random_oscillator
   use vi_flight, only: flight_position, flight_state, flight_type, new_flight
   use vi_impact, only: impact, primary_velocities
   use vi_kinds, only: wp
   use vi_oscillation, only: derivative_bound, derivatives, square_integral
   use vi_oscillator, only: eta, gain, lag, oscillator_type
   implicit none (type, external)

   type(random_type) :: random

   call test_oscillator()
   call test_impact()
   call test_flight()
   call test_equation_of_motion()
   call test_derivative_bound()
   call test_square_integral()
   call test_extrema()
   call test_march()
   call test_bounds()
   call test_rest()
   call test_simultaneous()
   call test_structure()
   call test_channels()
   call test_decoupling()
   call test_moments()
   call finish()

contains

   !> The steady motion is the complex response 1/(1 - r^2 + 2 i xi r).
   subroutine test_oscillator()
      type(oscillator_type) :: osc
      complex(wp) :: response
      real(wp) :: r
      integer :: i

      do i = 1, 2000
         call random_oscillator(random, osc)
         r = random_frequency(random)
         response = 1/cmplx(1 - r**2, 2*osc%xi*r, wp)
         call check_close(gain(osc%xi, r), abs(response), 1e-12_wp*abs(response), 'gain')
         call check_close(lag(osc%xi, r), atan2(-aimag(response), real(response)), 1e-12_wp, 'lag')
         call check_close(eta(osc%xi)**2 + osc%xi**2, 1.0_wp, 1e-15_wp, 'eta^2 + xi^2 = 1')
      end do
      call check_close(lag(0.1_wp, 1.0_wp), pi/2, 1e-15_wp, 'a quarter of a period at resonance')
      call check_close(gain(0.1_wp, 1.0_wp), 5.0_wp, 1e-14_wp, '1/(2 xi) at resonance')
   end subroutine test_oscillator

   !> Momentum, restitution and energy at an impact, and the inverse.
   subroutine test_impact()
      type(oscillator_type) :: osc
      real(wp) :: before(2), after(2), back(2), mu, restitution, gained, lost
      integer :: i

      do i = 1, 5000
         call random_oscillator(random, osc)
         mu = osc%mu
         restitution = osc%restitution(1)
         before(1) = draw(random, -2.0_wp, 2.0_wp)
         before(2) = draw(random, -2.0_wp, 2.0_wp)
         call impact(mu, restitution, before(1), before(2), after(1), after(2))
         call check_close(after(1) + mu*after(2), before(1) + mu*before(2), 1e-14_wp*(1 + mu), &
            'momentum')
         call check_close(after(2) - after(1), -restitution*(before(2) - before(1)), 1e-14_wp, &
            'restitution')
         gained = after(1)**2 + mu*after(2)**2 - before(1)**2 - mu*before(2)**2
         lost = mu/(1 + mu)*(1 - restitution**2)*(before(2) - before(1))**2
         call check_close(-gained, lost, 1e-13_wp*(1 + mu), 'energy')
         call primary_velocities(mu, restitution, before(2), after(2), back(1), back(2))
         ! the velocity before is (V (1 + R) + rounding)/(1 + R): well determined for every R
         call check_close(back(1), before(1), 1e-14_wp*(1 + mu), 'x_dot before, from z_dot')
         call check_close(back(2), after(1), 1e-14_wp*(1 + mu), 'x_dot after, from z_dot')
      end do
      call impact(0.0_wp, 0.5_wp, 1.0_wp, 3.0_wp, after(1), after(2))
      call check(after(1) >= 1 .and. after(1) <= 1, 'mu = 0: the primary mass feels nothing')
      call check_close(after(2), 0.0_wp, 1e-15_wp, 'mu = 0: the free mass bounces')
   end subroutine test_impact

   !> The integral of x^2 by Simpson's rule, over short and long times.
   subroutine test_square_integral()
      integer, parameter :: n = 2000
      type(flight_type) :: flight
      real(wp) :: d(0:5), total, t
      integer :: i, j

      do i = 1, 300
         call random_flight(random, flight)
         t = flight%duration*10.0_wp**draw(random, -6.0_wp, 0.0_wp)
         total = 0
         do j = 0, n
            d = derivatives(flight, j*t/n)
            total = total + d(0)**2*merge(1, 2 + 2*mod(j, 2), j == 0 .or. j == n)*t/(3*n)
         end do
         call check_close(square_integral(flight%oscillation_type, t), total, &
            1e-7_wp*t*derivative_bound(flight, 0, 0.0_wp)**2, 'integral of x^2')
      end do
   end subroutine test_square_integral

   !> A flight starts in its state, and continues as a flight from any later state of it.
   subroutine test_flight()
      type(flight_type) :: flight, rest
      real(wp) :: x(3), start(3), later(3), t, u
      integer :: i

      do i = 1, 3000
         call random_flight(random, flight)
         call flight_state(flight, 0.0_wp, start(1), start(2), start(3))
         rest = new_flight(flight%decay, flight%r, flight%amplitude, flight%phase, start(1), &
            start(2), flight%z, flight%z_dot, flight%duration)
         call check_close(rest%a, flight%a, 1e-12_wp*(1 + abs(flight%a)), 'the state gives a')
         call check_close(rest%b, flight%b, 1e-12_wp*(1 + abs(flight%b)), 'the state gives b')
         t = draw(random, 0.0_wp, flight%duration)
         u = draw(random, 0.0_wp, flight%duration)
         call flight_state(flight, t, x(1), x(2), x(3))
         rest = new_flight(flight%decay, flight%r, flight%amplitude, flight%phase + flight%r*t, &
            x(1), &
            x(2), flight_position(flight, t), flight%z_dot, flight%duration)
         call flight_state(flight, t + u, later(1), later(2), later(3))
         call flight_state(rest, u, x(1), x(2), x(3))
         call check_close(maxval(abs(x - later)), 0.0_wp, 1e-11_wp*scale_of_flight(flight), &
            'two flights in a row are one')
         call check_close(flight_position(flight, t + u), flight_position(rest, u), &
            1e-13_wp*(3 + 3*flight%duration), 'z is linear')
      end do
   end subroutine test_flight

   !> x'' + 2 xi x' + x = (A/gain) sin(r t + phase + lag), and the derivatives are consistent.
   subroutine test_equation_of_motion()
      type(flight_type) :: flight
      real(wp) :: x(3), ahead(3, 3), behind(3, 3), load, t, scale, h, slope(3)
      integer :: i, j

      do i = 1, 3000
         call random_flight(random, flight)
         t = draw(random, 0.0_wp, flight%duration)
         call flight_state(flight, t, x(1), x(2), x(3))
         load = flight%amplitude/gain(flight%decay, flight%r)
         scale = scale_of_flight(flight)
         call check_close(x(3) + 2*flight%decay*x(2) + x(1), &
            load*sin(flight%r*t + flight%phase + lag(flight%decay, flight%r)), 1e-13_wp*scale, &
            'equation of motion')
         h = 0.02_wp/max(1.0_wp, flight%r)
         do j = 1, 3
            call flight_state(flight, t + j*h, ahead(1, j), ahead(2, j), ahead(3, j))
            call flight_state(flight, t - j*h, behind(1, j), behind(2, j), behind(3, j))
         end do
         ! central differences of sixth order
         slope = (45*(ahead(:, 1) - behind(:, 1)) - 9*(ahead(:, 2) - behind(:, 2)) &
            + (ahead(:, 3) - behind(:, 3)))/(60*h)
         call check_close(slope(1), x(2), 1e-10_wp*scale, 'x_dot is the derivative of x')
         call check_close(slope(2), x(3), 1e-10_wp*scale, 'x_ddot is the derivative of x_dot')
      end do
   end subroutine test_equation_of_motion

   !> No derivative of x exceeds its bound from then on, and no bound grows.
   subroutine test_derivative_bound()
      type(flight_type) :: flight
      real(wp) :: x(4), t, s, load, angle, bound(0:3)
      integer :: i, j, n

      do i = 1, 1000
         call random_flight(random, flight)
         t = draw(random, 0.0_wp, flight%duration)
         do n = 0, 3
            bound(n) = derivative_bound(flight, n, t)
            call check(bound(n) <= derivative_bound(flight, n, 0.5_wp*t), 'a bound does not grow')
         end do
         load = flight%amplitude/gain(flight%decay, flight%r)
         do j = 0, 40
            s = t + j*0.05_wp*flight%duration
            call flight_state(flight, s, x(1), x(2), x(3))
            angle = flight%r*s + flight%phase + lag(flight%decay, flight%r)
            x(4) = load*flight%r*cos(angle) - 2*flight%decay*x(3) - x(2)
            call check(all(abs(x) <= bound*(1 + 1e-12_wp)), 'derivatives stay below their bounds')
         end do
      end do
      ! a single free oscillation attains them
      flight = new_flight(0.0_wp, 2.0_wp, 0.0_wp, 0.0_wp, 3.0_wp, 4.0_wp, 0.0_wp, 0.0_wp, 1.0_wp)
      call check_close(derivative_bound(flight, 3, 7.0_wp), 5.0_wp, 1e-14_wp, &
         'the bound is attained')
   end subroutine test_derivative_bound

   !> The largest number of a flight.
   real(wp) function scale_of_flight(flight)
      type(flight_type), intent(in) :: flight

      scale_of_flight = 1 + abs(flight%a) + abs(flight%b) + flight%amplitude*max(1.0_wp, &
         flight%r)**3
   end function scale_of_flight

end program test_mechanics
