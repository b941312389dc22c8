!> The start and the end of a simulation: departures from a wall, and the changes of a final state.
module studies_spans
   use, intrinsic :: iso_fortran_env, only: int64
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, random_type
   use vi_contact, only: departure_type
   use vi_forced_system, only: departure_from, event_type, forced_system_type, initial_state, &
      new_forced_system, state_type
   use vi_kinds, only: wp
   use vi_oscillator, only: oscillator_type
   use vi_simulate, only: simulate
   use vi_status, only: stat
   use vi_variation, only: columns, contact_derivative, moment_type, of_load, of_mu, of_xi, &
      through_span, variation_type
   implicit none (type, external)
   private

   public :: test_spans

   !> Parameters that vary: x, x', z' and load phase at the start, r, clearance, xi, mu, load
   !! amplitude, and the load phase at the end.
   integer, parameter :: varied = 10, by_z_dot = 3, by_phase = 4, by_r = 5, by_clearance = 6, &
      by_xi = 7, by_mu = 8, by_load = 9, by_end = 10

   type(random_type) :: random

contains

   subroutine test_spans()
      integer :: compared(3), i, kind

      call test_departures()
      call test_no_approach()
      compared = 0
      do i = 1, 300
         kind = mod(i, 3) + 1
         call compare(kind, compared(kind))
      end do
      call check(all(compared > 50), 'spans: from a wall, from inside, and at rest')
   end subroutine test_spans

   !> A flight that starts on a wall departs at the rate at which the distance from that wall grows,
   !! however small; if the distance decreases, the flight starts with an impact.
   subroutine test_departures()
      type(forced_system_type) :: system
      type(state_type) :: state
      type(departure_type) :: departure
      real(wp) :: start(5), speed
      integer :: i, side

      do i = 1, 400
         side = merge(1, -1, mod(i, 2) == 0)
         system = new_forced_system(oscillator_type(0.02_wp, 0.1_wp, [0.7_wp, 0.6_wp]), &
            draw(random, 0.5_wp, 0.9_wp), 1.0_wp, draw(random, 0.5_wp, 5.0_wp))
         speed = draw(random, -1.0_wp, 1.0_wp)*10.0_wp**draw_integer(random, -3, 1)
         start(1) = draw(random, 0.0_wp, 50.0_wp)
         start(2) = draw(random, -2.0_wp, 2.0_wp)
         start(3) = draw(random, -2.0_wp, 2.0_wp)
         start(4) = start(2) + 0.5_wp*side*system%clearance
         start(5) = start(3) - side*speed
         state = initial_state(system, start)
         departure = departure_from(state, 0.5_wp*system%clearance)
         call check(.not. state%resting .and. departure%side == side, 'a flight begins on its wall')
         call check_close(departure%speed, speed, 1e-14_wp*(4 + abs(speed)), 'a departure speed')
         ! as after a short flight from the wall, or with a flight that does not leave it
         state%side = 0
         state%speed = 0
         state%z_dot = state%x_dot - side*merge(0.0_wp, abs(speed), mod(i, 3) == 0)
         departure = departure_from(state, 0.5_wp*system%clearance)
         call check(departure%side == 0, 'a flight beside a wall, from which the masses part')
      end do
   end subroutine test_departures

   !> An impact has a derivative unless its approach speed is rounding of the velocities of both
   !! masses, whatever their signs.
   subroutine test_no_approach()
      type(forced_system_type) :: system
      real(wp) :: p(4, 4), velocity
      logical :: regular
      integer :: i, roundings, side

      system = new_forced_system(oscillator_type(0.02_wp, 0.1_wp, [0.7_wp, 0.6_wp]), 0.8_wp, &
         1.0_wp, 3.0_wp)
      do i = 1, 400
         side = merge(1, -1, mod(i, 2) == 0)
         velocity = draw(random, 10.0_wp, 100.0_wp)*merge(1, -1, mod(i, 4) < 2)
         do roundings = -40, 40
            ! the limit is at 16, and the velocities have one or two rounding errors
            if (abs(roundings) > 12 .and. abs(roundings) < 20) cycle
            call contact_derivative(system, moment_type(0.1_wp, velocity, velocity*(1 + roundings* &
               epsilon(velocity)), draw(random, 0.0_wp, 6.0_wp), side), 0.0_wp, side, 0.7_wp, p, &
               regular)
            call check(regular .eqv. abs(roundings) > 16, 'spans: an impact without approach')
         end do
      end do
   end subroutine test_no_approach

   !> The changes of the state at a load phase, before any event, compared with differences of
   !! simulations.
   subroutine compare(kind, compared)
      !> 1: a flight from a wall, 2: a flight from between the walls, 3: a rest.
      integer, intent(in) :: kind
      integer, intent(inout) :: compared
      real(wp), parameter :: h = 1.0e-3_wp, weight(4) = [1, -8, 8, -1]/(12*h)
      type(forced_system_type) :: system
      type(variation_type) :: change
      real(wp) :: p(varied), moved(varied), y0, ends(4, 4), until(columns), y(columns), slope(4)
      logical :: quiet
      integer :: i, j, side

      side = merge(1, -1, draw_integer(random, 0, 1) == 0)
      p(1) = draw(random, -1.0_wp, 1.0_wp)
      if (kind == 3) p(1) = side*draw(random, 1.5_wp, 3.0_wp)
      p(2) = draw(random, -1.0_wp, 1.0_wp)
      p(by_z_dot) = p(2)
      if (kind == 1) p(by_z_dot) = p(2) - side*draw(random, 0.1_wp, 1.0_wp)
      if (kind == 2) p(by_z_dot) = draw(random, -1.0_wp, 1.0_wp)
      p(by_phase) = draw(random, 0.1_wp, 4.0_wp)
      p(by_r) = draw(random, 0.5_wp, 0.9_wp)
      p(by_clearance) = draw(random, 4.0_wp, 8.0_wp)
      p(by_xi) = draw(random, 0.02_wp, 0.2_wp)
      p(by_mu) = draw(random, 0.05_wp, 0.5_wp)
      p(by_load) = draw(random, 0.5_wp, 1.5_wp)
      p(by_end) = p(by_phase) + draw(random, 0.2_wp, 1.5_wp)
      y0 = draw(random, -0.5_wp, 0.5_wp)

      change%n = varied
      change%with_others = .true.
      until = 0
      do j = 1, 4
         change%state(j, j) = 1
      end do
      ! at rest both masses have one velocity
      if (kind == 3) change%state(3, 2) = 1
      change%r(by_r) = 1
      change%clearance(by_clearance) = 1
      change%others(of_xi, by_xi) = 1
      change%others(of_mu, by_mu) = 1
      change%others(of_load, by_load) = 1
      until(by_end) = 1
      system = system_of(p)
      call through_span(system, moment_type(p(1), p(2), p(by_z_dot), p(by_phase), &
         merge(0, side, kind == 2)), (p(by_end) - p(by_phase))/p(by_r), kind == 3, until, change, y)
      do j = 1, varied
         if (kind == 3 .and. j == by_z_dot) cycle
         do i = 1, 4
            moved = p
            moved(j) = moved(j) + h*merge(i - 3, i - 2, i < 3)
            if (kind == 3) moved(by_z_dot) = moved(2)
            call simulate_to_end(moved, kind, side, y0, ends(:, i), quiet)
            if (.not. quiet) return
         end do
         slope = matmul(ends, weight)
         do i = 1, 3
            call check_close(change%state(i, j), slope(i), 1e-9_wp*(1 + maxval(abs(ends))), &
               'spans: a change of the state at a load phase')
         end do
         call check_close(y(j), slope(4), 1e-9_wp*(1 + maxval(abs(ends))), &
            'spans: a change of the distance of the masses')
      end do
      compared = compared + 1
   end subroutine compare

   pure function system_of(p) result(system)
      real(wp), intent(in) :: p(varied)
      type(forced_system_type) :: system

      system = new_forced_system(oscillator_type(p(by_xi), p(by_mu), [0.7_wp, 0.6_wp]), p(by_r), &
         p(by_load), p(by_clearance))
   end function system_of

   !> x, x', z' and z - x at the end of a simulation without events.
   subroutine simulate_to_end(p, kind, side, y0, at_end, quiet)
      real(wp), intent(in) :: p(varied)
      !> As in `compare`; the wall; z - x at a start between the walls.
      integer, intent(in) :: kind, side
      real(wp), intent(in) :: y0
      real(wp), intent(out) :: at_end(4)
      !> Whether there is no event.
      logical, intent(out) :: quiet
      type(forced_system_type) :: system
      type(state_type) :: state, final
      type(event_type) :: events(4)
      integer :: n, status

      system = system_of(p)
      state = initial_state(system, [p(by_phase)/p(by_r), p(1), p(2), p(1) + merge(y0, &
         0.5_wp*side*p(by_clearance), kind == 2), p(by_z_dot)])
      quiet = state%resting .eqv. kind == 3
      call simulate(system, state, 0_int64, p(by_end), events, n, final, status)
      quiet = quiet .and. status == stat%ok .and. n == 0
      at_end = [final%x, final%x_dot, final%z_dot, final%z - final%x]
   end subroutine simulate_to_end

end module studies_spans
