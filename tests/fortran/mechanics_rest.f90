!> Masses that leave an impact together, the contact that follows, and combinations of an
!! oscillation and its derivatives.
module mechanics_rest
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, draw_log, random_type
   use random_systems, only: pi, random_flight
   use vi_flight, only: flight_state, flight_type, new_flight
   use vi_kinds, only: wp
   use vi_oscillation, only: combination, derivative_bound, derivatives, oscillation_type
   use vi_parting, only: in_contact, leaves_together, parted, parting, uncertain
   use vi_rest, only: new_rest, release_time
   implicit none (type, external)
   private

   public :: test_rest

   type(random_type) :: random

contains

   subroutine test_rest()
      integer :: side

      do side = -1, 1, 2
         call test_parting(side)
         call test_release(side)
         call test_no_release(side)
      end do
      call test_together()
      call test_combination()
   end subroutine test_rest

   !> The gap between masses that leave together, compared with samples: it closes at once or soon,
   !! or stays open for the given time.
   subroutine test_parting(side)
      integer, intent(in) :: side
      integer, parameter :: samples = 200
      type(flight_type) :: flight
      real(wp) :: a, j, gap, least, until, t, x, x_dot, x_ddot, start(3)
      integer :: answer, i, k, found(uncertain:parted), soon

      found = 0
      soon = 0
      do i = 1, 3000
         ! the acceleration and its rate of the gap, without damping and load
         a = side*draw_log(random, 1e-6_wp, 1.0_wp)*draw_integer(random, -1, 1)
         j = side*draw_log(random, 1e-3_wp, 1.0_wp)*draw_integer(random, -1, 1)
         flight = new_flight(0.0_wp, 2.0_wp, 0.0_wp, 0.0_wp, -a, -j, 0.0_wp, 0.0_wp, 1.0_wp)
         call parting(flight, real(side, wp), answer, until)
         found(answer) = found(answer) + 1
         call flight_state(flight, 0.0_wp, start(1), start(2), start(3))
         a = side*a
         j = side*j
         ! the first two terms alone are 0 at 3 a/|j|
         if (answer == in_contact) until = 0.1_wp
         if (answer == in_contact .and. a*j < 0) until = merge(4, 2, a > 0)*abs(a/j)
         if (answer == in_contact .and. a > 0) soon = soon + 1
         least = huge(1.0_wp)
         do k = 1, samples
            t = k*until/samples
            call flight_state(flight, t, x, x_dot, x_ddot)
            gap = side*(x - start(1) - start(2)*t)
            least = min(least, gap)
         end do
         select case (answer)
         case (in_contact)
            call check(least < 0, 'parting: in contact')
         case (parted)
            call check(until > 0 .and. least > -1e-15_wp, 'parting: open')
         case default
            call check(abs(a) <= 0 .and. j >= 0, 'parting: not certain without an acceleration')
            if (j > 0) call check(gap > 0, 'parting: open after a possible contact')
            if (.not. j > 0) call check(until <= 0, 'parting: not certain without its rate')
         end select
      end do
      call check(all(found > 100) .and. soon > 100, 'parting: all answers')
   end subroutine test_parting

   !> The rebound is unresolved where the velocities differ by rounding of the largest one.
   subroutine test_together()
      real(wp), parameter :: e = epsilon(1.0_wp)

      call check(leaves_together(-1.0_wp, -1 - 15*e, 0.5_wp), 'together: by the first velocity')
      call check(.not. leaves_together(-1.0_wp, -1 - 20*e, 0.5_wp), 'apart')
      call check(leaves_together(0.0_wp, -15*e, -1.0_wp), 'together: by the velocity before')
      call check(.not. leaves_together(0.0_wp, 20*e, -1.0_wp), 'apart, as before')
      call check(leaves_together(0.0_wp, 0.0_wp, 0.0_wp), 'together at rest')
      call check(.not. leaves_together(0.0_wp, -1.0_wp, 0.0_wp), 'apart from rest')
   end subroutine test_together

   !> Both masses move as one; the contact ends where the force between them first becomes 0.
   subroutine test_release(side)
      integer, intent(in) :: side
      integer, parameter :: samples = 500
      type(oscillation_type) :: rest
      real(wp) :: xi, mu, r, load, phase, time, limit, d(0:5), t, scale
      integer :: i, k, released
      logical :: complete

      released = 0
      do i = 1, 500
         xi = draw(random, 0.0_wp, 0.5_wp)
         mu = draw_log(random, 1e-2_wp, 2.0_wp)
         r = draw_log(random, 0.2_wp, 4.0_wp)
         load = real(draw_integer(random, 0, 1), wp)
         phase = draw(random, 0.0_wp, 2*pi)
         rest = new_rest(xi, mu, r, load, phase, side*draw(random, 0.5_wp, 2.0_wp), &
            draw(random, -1.0_wp, 1.0_wp))
         scale = derivative_bound(rest, 2, 0.0_wp)
         do k = 0, 10
            t = 0.7_wp*k
            d = derivatives(rest, t)
            call check_close((1 + mu)*d(2) + 2*xi*d(1) + d(0), load*sin(r*t + phase), &
               1e-12_wp*(1 + mu)*(1 + scale), 'rest: both masses')
         end do
         d = derivatives(rest, 0.0_wp)
         if (.not. -side*d(2) > 1e-6_wp*scale) cycle
         limit = draw_log(random, 0.1_wp, 50.0_wp)
         call release_time(rest, side, limit, time, complete)
         call check(complete, 'release: complete')
         do k = 0, samples
            t = k*min(limit, time)/samples
            d = derivatives(rest, t)
            call check(-side*d(2) > -1e-11_wp*scale, 'release: not before')
         end do
         if (time >= huge(1.0_wp)) cycle
         released = released + 1
         d = derivatives(rest, time)
         call check_close(d(2), 0.0_wp, 1e-11_wp*scale, 'release: without force')
         call check(side*d(3) > 0, 'release: the force falls')
      end do
      call check(released > 100, 'release: seen often')
   end subroutine test_release

   !> Without load and motion the contact holds permanently, and so does one on the side that a slow
   !! oscillation does not reach.
   subroutine test_no_release(side)
      integer, intent(in) :: side
      type(oscillation_type) :: rest
      real(wp) :: time
      logical :: complete

      rest = new_rest(0.1_wp, 0.3_wp, 1.2_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp)
      call release_time(rest, side, 100.0_wp, time, complete)
      call check(complete .and. time >= huge(1.0_wp), 'no release from rest')
      rest = new_rest(0.1_wp, 0.3_wp, 1.2_wp, 0.0_wp, 0.0_wp, real(side, wp), 0.0_wp)
      call release_time(rest, side, 0.5_wp, time, complete)
      call check(complete .and. time >= huge(1.0_wp), 'no release in a short time')
   end subroutine test_no_release

   !> A weighted sum of x, x' and x'' is an oscillation; weights can remove its forced part.
   subroutine test_combination()
      type(flight_type) :: flight
      type(oscillation_type) :: sum_of
      real(wp) :: w(0:2), d(0:5), of_sum(0:5), t, scale
      integer :: i, k

      do i = 1, 500
         call random_flight(random, flight)
         do k = 0, 2
            w(k) = draw(random, -2.0_wp, 2.0_wp)
         end do
         if (mod(i, 5) == 0) then
            ! numbers that are squared exactly
            flight%r = 0.25_wp*draw_integer(random, 1, 20)
            w = [flight%r**2, 0.0_wp, 1.0_wp]
         end if
         sum_of = combination(flight%oscillation_type, w)
         if (mod(i, 5) == 0) then
            call check(abs(sum_of%amplitude) <= 0, 'combination: without its forced part')
            call check(abs(sum_of%phase - flight%phase) <= 0, 'combination: of the same phase')
         end if
         scale = sum([(derivative_bound(flight, k, 0.0_wp), k=0, 4)])
         do k = 0, 10
            t = 0.1_wp*k*flight%duration
            d = derivatives(flight, t)
            of_sum = derivatives(sum_of, t)
            call check_close(of_sum(0), sum(w*d(0:2)), 1e-12_wp*scale*(1 + t), 'combination')
            call check_close(of_sum(1), sum(w*d(1:3)), 1e-12_wp*scale*(1 + t), &
               'combination: its rate')
         end do
      end do
   end subroutine test_combination

end module mechanics_rest
