!> Trajectories as arrays: their events, time history and derivatives, the motions at their ends,
!! and the figures of the attractors that they reach.
module studies_trajectories
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use, intrinsic :: iso_fortran_env, only: int64
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_log, random_type
   use vi_attractor_performance, only: acceleration, displacement, figures, force, least_gap, &
      least_speed, perform, rms, speed
   use vi_bundle, only: simulate_bundle
   use vi_contact, only: contact_type, first_contact
   use vi_forced_system, only: departure_from, event_type, flight_from, forced_system_type, &
      impact_event, initial_state, new_forced_system, release_event, state_time, state_type, &
      stick_event
   use vi_found_motion, only: described_type, scale_of
   use vi_kinds, only: wp
   use vi_oscillator, only: oscillator_type
   use vi_settled_motion, only: end_arrays
   use vi_simulate, only: simulate
   use vi_status, only: stat
   use vi_trajectory, only: pack_state, sample_segments, simulate_arrays, simulate_case, &
      store_events
   use vi_trajectory_gradient, only: trajectory_gradient, varied
   implicit none (type, external)
   private

   public :: test_trajectories

   real(wp), parameter :: pi = acos(-1.0_wp)

   !> The end of a simulation that has settled, in the form for `end_arrays`.
   type :: end_type
      real(wp) :: of(4) = 0
      real(wp), allocatable :: values(:, :)
      integer, allocatable :: labels(:, :)
   end type end_type

contains

   subroutine test_trajectories()
      call test_flights()
      call test_records()
      call test_bundle()
      call test_history()
      call test_motion_at_end(.false.)
      call test_motion_at_end(.true.)
      call test_doubled_period()
      call test_nearby(.false.)
      call test_nearby(.true.)
      call test_gradient(.true.)
      call test_gradient(.false.)
      call test_no_gradient()
      call test_limits_of_events(0)
      call test_limits_of_events(8)
      call test_figures_with_rest()
      call test_figures(6.0_wp, 40, 0.75_wp, 0.6_wp)
      call test_figures(2.5_wp, 40, 0.75_wp, 0.6_wp)
      call test_figures(6.0_wp, 40, 0.6_wp, 0.75_wp)
      call test_touches()
   end subroutine test_trajectories

   !> A system that settles on RL/1, or on a motion with rest on both walls.
   pure type(forced_system_type) function settling_system(rests, wider, faster) result(system)
      logical, intent(in) :: rests
      !> Factors of the clearance and of the frequency.
      real(wp), intent(in) :: wider, faster

      if (rests) then
         system = new_forced_system(oscillator_type(0.1_wp, 0.1_wp, [0.3_wp, 0.3_wp]), &
            faster*1.132_wp, 1.0_wp, wider*1.2_wp)
      else
         system = new_forced_system(oscillator_type(0.0114_wp, 0.028_wp, [0.75_wp, 0.75_wp]), &
            faster*1.05_wp, 1.0_wp, wider*30.0_wp)
      end if
   end function settling_system

   !> Each impact of random systems is the first contact that the plain search finds from the
   !! previous one, and the code for wide registers gives the same bits.
   subroutine test_flights()
      integer, parameter :: systems = 60, room = 400
      type(random_type) :: random
      type(forced_system_type) :: system
      type(state_type) :: state, start, final
      type(event_type) :: events(room), plain(room)
      type(contact_type) :: contact
      real(wp) :: restitution(2), r, clearance, duration, half
      integer :: i, j, k, n, n_plain, status, seen

      seen = 0
      do k = 1, systems
         restitution = [draw(random, 0.3_wp, 1.0_wp), draw(random, 0.3_wp, 1.0_wp)]
         r = draw_log(random, 0.3_wp, 5.0_wp)
         clearance = draw_log(random, 0.2_wp, 40.0_wp)
         system = new_forced_system(oscillator_type(draw_log(random, 1e-3_wp, 0.5_wp), &
            draw_log(random, 1e-2_wp, 0.5_wp), restitution), r, 1.0_wp, clearance)
         half = 0.5_wp*clearance
         start = initial_state(system, [0.0_wp, 0.0_wp, 0.1_wp, 0.0_wp, draw(random, -2.0_wp, &
            2.0_wp)])
         state = start
         call simulate(system, state, 200_int64, 0.0_wp, events, n, final, status)
         state = start
         system%wide = .false.
         call simulate(system, state, 200_int64, 0.0_wp, plain, n_plain, final, status)
         call check(n == n_plain, 'as many impacts in wide registers')
         do i = 2, min(n, n_plain)
            associate (before => events(i - 1), e => events(i), p => plain(i))
               j = e%side
               call check(e%cycle == p%cycle .and. .not. any(abs([e%phase - p%phase, e%x - p%x, &
                  e%x_dot_before - p%x_dot_before, e%x_dot_after - p%x_dot_after, &
                  e%z_dot_before - p%z_dot_before, e%z_dot_after - p%z_dot_after]) > 0), &
                  'the same bits in wide registers')
               if (before%kind /= impact_event .or. e%kind /= impact_event) cycle
               duration = state_time(e%cycle - before%cycle, e%phase - before%phase, r)
               state = state_type(before%cycle, before%phase, before%x, before%x_dot_after, &
                  before%x + before%side*half, before%z_dot_after, before%side, &
                  before%side*(before%x_dot_after - before%z_dot_after))
               ! in shorter flights the departure speed has too few digits
               if (state%speed < 1e-3_wp) cycle
               contact = first_contact(flight_from(system, state, 2*duration + 1), half, &
                  departure_from(state, half), 2*duration + 1, 0.0_wp)
               call check(contact%side == j, 'a flight ends at its first contact')
               call check_close((contact%time - duration)*contact%speed, 0.0_wp, &
                  1e-12_wp*(clearance + abs(before%x) + system%amplitude), 'after its time')
               seen = seen + 1
            end associate
         end do
      end do
      call check(seen > 5000, 'flights were seen')
   end subroutine test_flights

   !> A bundle ends where its simulations end, with their numbers of impacts and rests, whatever
   !! the previous contents of its arrays.
   subroutine test_bundle()
      integer, parameter :: cycles = 100
      type(forced_system_type) :: system
      type(state_type) :: state, final
      type(event_type) :: events(4000)
      real(wp) :: ends(7, 2), last(7)
      integer :: counts(2, 2), status(2), contact(3), i, n, one

      counts = -7
      system = settling_system(.true., 1.0_wp, 1.0_wp)
      call simulate_bundle(system%osc, system%r*[1.0_wp, 1.01_wp], [1.0_wp, 1.0_wp], &
         system%clearance*[1.0_wp, 2.0_wp], real(cycles, wp), size(events), 1, &
         reshape([(0.0_wp, i=1, 10)], [5, 2]), ends, counts, status)
      do i = 1, 2
         system = settling_system(.true., real(i, wp), merge(1.0_wp, 1.01_wp, i == 1))
         state = initial_state(system, [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp])
         call simulate(system, state, int(cycles, int64), 0.0_wp, events, n, final, one)
         call pack_state(final, last, contact)
         call check(status(i) == one .and. n > 256, 'the simulation')
         call check(all(counts(:, i) == [count(events(:n)%kind == impact_event), &
            count(events(:n)%kind == stick_event)]), 'its impacts and rests')
         call check(all(abs(ends(:, i) - last) <= 0), 'its end')
      end do
   end subroutine test_bundle

   !> The records of a simulation are its events, however many there are, with the words of each.
   subroutine test_records()
      integer, parameter :: room = 300
      type(forced_system_type) :: system
      type(state_type) :: state, final
      type(event_type) :: events(room + 100)
      real(wp) :: start(5), now(7), last(7), names(4, 2, 3), table(11, room)
      integer :: contact(3), last_contact(3), i, k, n, found, status, cycles

      names = reshape([(real(i, wp), i=1, size(names))], shape(names))
      system = settling_system(.true., 1.0_wp, 1.0_wp)
      start = [0.3_wp, 0.2_wp, 0.1_wp, 0.3_wp, 0.5_wp]
      do cycles = 5, 50, 45
         state = initial_state(system, start)
         call pack_state(state, now, contact)
         call simulate(system, state, int(cycles, int64), 1.0_wp, events, n, final, status)
         table = 0
         call simulate_arrays(system, now, contact, real(cycles, wp), 1.0_wp, names, table, found, &
            last, last_contact, status)
         call check(found == min(n, room), 'as many records as there is room for')
         call check(status == merge(stat%more_events, stat%ok, n > room), 'whether there are more')
         do i = 1, found
            associate (e => events(i))
               k = merge(1, 2, e%side > 0)
               call check(.not. any(abs(table(:, i) - [state_time(e%cycle, e%phase, system%r), &
                  names(:, k, e%kind), e%phase, e%x, e%x_dot_before, e%x_dot_after, &
                  e%z_dot_before, e%z_dot_after]) > 0), 'a record is an event')
            end associate
         end do
         call check(.not. any(abs(table(:, found + 1:)) > 0), 'other columns are not touched')
         if (found == n) call check(.not. abs(last(3) - final%x) > 0, 'the end of a simulation')
      end do
   end subroutine test_records

   !> The time history ends each flight and rest where the next one begins; in a rest both masses
   !! have one velocity.
   subroutine test_history()
      type(forced_system_type) :: system
      type(state_type) :: moments(4)
      type(event_type), allocatable :: events(:)
      real(wp), allocatable :: starts(:, :)
      integer, allocatable :: resting(:)
      real(wp) :: values(6, 1), half, tolerance
      integer :: i, n, rests, status

      system = settling_system(.true., 1.0_wp, 1.0_wp)
      half = 0.5_wp*system%clearance
      call simulate_case(system, [0.3_wp, 0.2_wp, 0.1_wp, 0.3_wp, 0.5_wp], 6.0_wp, 0.0_wp, 10000, &
         moments, events, status)
      n = size(events)
      allocate (starts(6, 0:n), resting(0:n))
      starts(:, 0) = [0.3_wp, moments(1)%phase, 0.2_wp, 0.1_wp, 0.3_wp, 0.5_wp]
      resting(0) = 0
      rests = 0
      do i = 1, n
         associate (e => events(i), time => state_time(events(i)%cycle, events(i)%phase, system%r))
            call sample_segments(system, starts(:, :i - 1), resting(:i - 1), [time], values)
            call check_close(values(1, 1), e%x, 1.0e-12_wp, 'history: x')
            ! the last, tiny impacts of an accumulation are not events
            tolerance = merge(1.0e-7_wp, 1.0e-12_wp, e%kind == stick_event)
            call check_close(values(2, 1), e%x_dot_before, tolerance, 'history: velocity of x')
            call check_close(values(3, 1), e%x + e%side*half, 1.0e-11_wp, 'history: z at its wall')
            call check_close(values(4, 1), e%z_dot_before, tolerance, 'history: velocity of z')
            call check_close(values(5, 1), e%side*half, 1.0e-11_wp, 'history: y at its wall')
            call check_close(values(6, 1), system%load*sin(e%phase), 1.0e-12_wp, 'history: load')
            if (resting(i - 1) /= 0) then
               rests = rests + 1
               call check(.not. abs(values(2, 1) - values(4, 1)) > 0, 'history: a rest')
            end if
            starts(:, i) = [time, e%phase, e%x, e%x_dot_after, e%x + e%side*half, e%z_dot_after]
            resting(i) = merge(e%side, 0, e%kind == stick_event)
         end associate
      end do
      call check(status == stat%ok .and. rests > 4 .and. n > 3*rests, 'history: flights and rests')
   end subroutine test_history

   !> The last cycles of a simulation that is longer than chaotic transients, which last 600 cycles
   !! on average.
   subroutine settle(system, finish)
      type(forced_system_type), intent(in) :: system
      type(end_type), intent(out) :: finish
      type(state_type) :: moments(4)
      type(event_type), allocatable :: events(:)
      integer :: status

      call simulate_case(system, [0.0_wp, 0.1_wp, 0.0_wp, 0.1_wp, 0.5_wp], 12.0_wp, 9000.0_wp, &
         1000000, moments, events, status)
      call check(status == stat%ok .and. size(events) >= 24, 'a simulation with impacts')
      finish%of = [system%r, system%load, system%clearance, &
         state_time(moments(1)%cycle, moments(1)%phase, system%r)]
      allocate (finish%values(7, size(events)), finish%labels(2, size(events)))
      call store_events(events, system%r, finish%values, finish%labels)
   end subroutine settle

   !> The results of `end_arrays` that these tests need.
   subroutine read_end(system, finish, most_cycles, solve, cycles, symbols, described)
      type(forced_system_type), intent(in) :: system
      type(end_type), intent(in) :: finish
      integer, intent(in) :: most_cycles, solve
      integer, intent(out) :: cycles
      integer, allocatable, intent(out) :: symbols(:)
      type(described_type), intent(out) :: described
      integer, allocatable :: all_symbols(:), first(:)
      real(wp) :: apart
      integer :: n

      allocate (all_symbols(size(finish%labels, 2)), first(size(finish%labels, 2)))
      call end_arrays(system, finish%of, finish%values, finish%labels, most_cycles, 0.05_wp, &
         solve, cycles, n, all_symbols, first, apart, described)
      allocate (symbols, source=all_symbols(:n))
   end subroutine read_end

   !> The motion at the end of a simulation, also of a slightly different system; none where none
   !! exists, and an attractor only of the system itself and of the requested period.
   subroutine test_motion_at_end(rests)
      logical, intent(in) :: rests
      type(forced_system_type) :: system, other
      type(end_type) :: finish, finish_of_other
      type(described_type) :: described, again
      integer, allocatable :: symbols(:)
      integer :: cycles

      system = settling_system(rests, 1.0_wp, 1.0_wp)
      call settle(system, finish)
      call read_end(system, finish, 4, 0, cycles, symbols, described)
      call check(cycles == 1 .and. size(symbols) == 2 .and. sum(symbols) == 0 .and. &
         all(abs(symbols) == merge(2, 1, rests)), 'the period at an end')
      call check(described%motion%status == stat%no_motion, 'no motion that nobody asks for')
      call read_end(system, finish, 4, 1, cycles, symbols, described)
      call check(described%motion%status == stat%ok, 'the motion at an end')
      call check(described%motion%pattern%cycles == 1, 'the period of the motion at an end')
      call read_end(system, finish, 1, 2, cycles, symbols, again)
      call compare(again, described, 'an attractor is the motion at an end')
      call read_end(system, finish, 3, 2, cycles, symbols, again)
      call check(again%motion%status == stat%no_motion, 'no attractor of another period')

      other = settling_system(rests, 1.0_wp, merge(0.92_wp, 1.1_wp, rests))
      call settle(other, finish_of_other)
      call read_end(other, finish_of_other, 4, 1, cycles, symbols, described)
      call read_end(other, finish, 4, 1, cycles, symbols, again)
      call compare(again, described, 'a motion of another system')
      call read_end(other, finish, 1, 2, cycles, symbols, again)
      call check(again%motion%status == stat%no_motion, 'no attractor of another system')

      call read_end(settling_system(rests, 1.0e4_wp, 1.0_wp), finish, 4, 1, cycles, symbols, again)
      call check(again%motion%status /= stat%ok, 'no motion where the walls are out of reach')
   end subroutine test_motion_at_end

   !> Checks that two motions are the same, up to rounding.
   subroutine compare(a, b, what)
      type(described_type), intent(in) :: a, b
      character(*), intent(in) :: what

      call check(a%motion%status == stat%ok .and. b%motion%status == stat%ok, what)
      if (a%motion%status /= stat%ok .or. b%motion%status /= stat%ok) return
      call check_close(a%motion%x_max, b%motion%x_max, 1.0e-7_wp*b%motion%x_max, what//': x_max')
      call check_close(a%motion%x_min, b%motion%x_min, 1.0e-7_wp*b%motion%x_max, what//': x_min')
      call check_close(abs(a%motion%multipliers(1)), abs(b%motion%multipliers(1)), 1.0e-6_wp, &
         what//': multiplier')
   end subroutine compare

   !> Where the phases of every second cycle differ slightly, as before a simulation has settled,
   !! two cycles repeat themselves best; but the motion has one cycle.
   subroutine test_doubled_period()
      type(forced_system_type) :: system
      type(end_type) :: finish
      type(described_type) :: described, again
      integer, allocatable :: symbols(:)
      real(wp) :: off
      integer :: cycles, i

      system = settling_system(.false., 1.0_wp, 1.0_wp)
      call settle(system, finish)
      call read_end(system, finish, 4, 1, cycles, symbols, described)
      do i = 1, size(finish%labels, 2)
         associate (v => finish%values(:, i))
            off = 0.002_wp*(-1)**modulo(nint((system%r*v(1) - v(2))/(2*pi)), 2)
            v(:2) = v(:2) + off*[1/system%r, 1.0_wp]
         end associate
      end do
      call read_end(system, finish, 4, 1, cycles, symbols, again)
      call check(again%motion%pattern%cycles == 1, 'a motion does not repeat itself')
      call compare(again, described, 'a motion that seems to have twice its period')
      call read_end(system, finish, 2, 2, cycles, symbols, again)
      call check(again%motion%status == stat%no_motion, 'an attractor does not repeat itself')
   end subroutine test_doubled_period

   !> An attractor is near a simulation if their phases differ by less than 0.1, and positions by
   !! less than a tenth of the unit of length, in either direction.
   subroutine test_nearby(rests)
      logical, intent(in) :: rests
      type(forced_system_type) :: system
      type(end_type) :: finish, moved
      type(described_type) :: described
      integer, allocatable :: symbols(:)
      real(wp) :: off
      integer :: cycles, i, row

      system = settling_system(rests, 1.0_wp, 1.0_wp)
      call settle(system, finish)
      row = merge(5, 3, rests)                       ! x' after a release, or x of an impact
      do i = -3, 3
         ! by a part of 0.1; the examined cycles start later where phases are later
         off = 0.049_wp*i
         moved = finish
         moved%values(1, :) = finish%values(1, :) + off/system%r
         moved%values(2, :) = finish%values(2, :) + off
         moved%of(4) = finish%of(4) + off/system%r
         call read_end(system, moved, 1, 2, cycles, symbols, described)
         call check(cycles == 1 .and. (described%motion%status == stat%ok .eqv. abs(i) < 3), &
            'a motion near in phase')
         moved = finish
         off = 0.049_wp*i*scale_of(system)
         moved%values(row, :) = finish%values(row, :) + off
         call read_end(system, moved, 1, 2, cycles, symbols, described)
         call check(cycles == 1 .and. (described%motion%status == stat%ok .eqv. abs(i) < 3), &
            'a motion near in place')
      end do
      moved%values = finish%values(:, :0)
      moved%labels = finish%labels(:, :0)
      do i = 0, 2
         call read_end(system, moved, 1, i, cycles, symbols, described)
         call check(cycles == 0 .and. size(symbols) == 0 .and. &
            described%motion%status == stat%no_motion, 'no motion without events')
      end do
   end subroutine test_nearby

   !> A trajectory that depends on all varied parameters.
   subroutine follow(rests, p, events, n, finish, system, start)
      logical, intent(in) :: rests
      real(wp), intent(in) :: p(varied)
      type(event_type), intent(inout) :: events(:)
      integer, intent(out) :: n
      type(state_type), intent(out) :: finish, start
      type(forced_system_type), intent(out) :: system
      type(state_type) :: state
      real(wp) :: given(5)
      integer :: status

      system = new_forced_system(oscillator_type(p(8), p(9), p(10:11)), p(6), p(12), p(7))
      given = p(:5)
      if (rests) given(4:) = [p(2) + 0.5_wp*p(7), p(3)]
      start = initial_state(system, given)
      state = start
      call simulate(system, state, start%cycle + 2, start%phase, events, n, finish, status)
      call check(status == stat%ok .and. n <= size(events), 'a trajectory over some cycles')
   end subroutine follow

   !> The derivatives of events and of the end of a trajectory, compared with differences of
   !! simulations; from a rest, where both masses move together, and from between the walls.
   subroutine test_gradient(rests)
      logical, intent(in) :: rests
      integer, parameter :: room = 40
      real(wp), parameter :: h = 1.0e-5_wp, weight(4) = [1, -8, 8, -1]/(12*h), &
         p(varied) = [0.4_wp, 2.0_wp, 0.3_wp, 1.8_wp, -0.9_wp, 0.8_wp, 3.0_wp, 0.05_wp, 0.3_wp, &
         0.6_wp, 0.7_wp, 1.1_wp]
      type(forced_system_type) :: system
      type(state_type) :: start, finish, unused
      type(event_type) :: events(room), moved(room)
      real(wp) :: by_events(varied, 6, room), by_finish(varied, 5), q(varied), slope(6, room), &
         last(5)
      integer :: good, i, j, k, n, m

      call follow(rests, p, events, n, finish, system, start)
      call check(n > 2 .and. (start%resting .eqv. rests), 'gradient: a trajectory')
      call trajectory_gradient(system, start, finish, events(:n), by_events, by_finish, good)
      call check(good == n, 'gradient: of all events')
      do j = 1, varied
         if (rests .and. (j == 4 .or. j == 5)) cycle
         slope = 0
         last = 0
         do i = 1, 4
            q = p
            q(j) = p(j) + h*merge(i - 3, i - 2, i < 3)
            call follow(rests, q, moved, m, finish, system, unused)
            call check(m == n, 'gradient: the same events')
            do k = 1, min(m, n)
               associate (e => moved(k))
                  slope(:, k) = slope(:, k) + weight(i)*[state_time(e%cycle, e%phase, system%r), &
                     e%x, e%x_dot_before, e%x_dot_after, e%z_dot_before, e%z_dot_after]
               end associate
            end do
            last = last + weight(i)*[state_time(finish%cycle, finish%phase, system%r), finish%x, &
               finish%x_dot, finish%z, finish%z_dot]
         end do
         do k = 1, n
            do i = 1, 6
               call check_close(by_events(j, i, k), slope(i, k), 1.0e-6_wp*(1 + abs(slope(i, k))), &
                  'gradient: of an event')
            end do
         end do
         do i = 1, 5
            call check_close(by_finish(j, i), last(i), 1.0e-6_wp*(1 + abs(last(i))), &
               'gradient: of the end')
         end do
      end do
   end subroutine test_gradient

   !> There are no derivatives at a release where the contact force does not pass through 0, nor at
   !! an impact that neither mass moves towards.
   subroutine test_no_gradient()
      type(forced_system_type) :: system
      type(state_type) :: start, finish
      type(event_type) :: event
      real(wp) :: by_events(varied, 6, 1), by_finish(varied, 5)
      integer :: good

      system = new_forced_system(oscillator_type(0.05_wp, 0.3_wp, [0.6_wp, 0.7_wp]), 0.8_wp, &
         1.0_wp, 3.0_wp)
      start = initial_state(system, [0.0_wp, 2.0_wp, 0.0_wp, 3.5_wp, 0.0_wp])
      finish = start
      finish%cycle = 1
      event = event_type(release_event, 1, 0_int64, 0.5_wp*pi, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
         0.0_wp)
      call trajectory_gradient(system, start, finish, [event], by_events, by_finish, good)
      call check(good == 0 .and. .not. any(abs(by_finish) > 0), 'gradient: none of a release')
      event%phase = 1.0_wp
      call trajectory_gradient(system, start, finish, [event], by_events, by_finish, good)
      call check(good == 1 .and. any(abs(by_finish) > 0), 'gradient: of a release')
      system = new_forced_system(oscillator_type(0.05_wp, 0.3_wp, [0.6_wp, 0.7_wp]), 0.8_wp, &
         0.0_wp, 3.0_wp)
      start = initial_state(system, [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp])
      event = event_type(impact_event, 1, 0_int64, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp)
      call trajectory_gradient(system, start, finish, [event], by_events, by_finish, good)
      call check(good == 0 .and. .not. any(abs(by_finish) > 0), 'gradient: none of an impact')
   end subroutine test_no_gradient

   !> An impact has no derivatives if its approach speed is within 1e-10 of the velocities, whatever
   !! their directions, unless impacts accumulate there.
   subroutine test_touches()
      real(wp), parameter :: small = 1.0e-10_wp
      type(forced_system_type) :: system
      type(state_type) :: start, finish
      type(event_type) :: events(2)
      real(wp) :: by_events(varied, 6, 2), by_finish(varied, 5), v, approach
      integer :: good, side, i, j

      system = new_forced_system(oscillator_type(0.05_wp, 0.3_wp, [0.6_wp, 0.7_wp]), 0.8_wp, &
         1.0_wp, 3.0_wp)
      start = initial_state(system, [0.0_wp, 2.0_wp, 0.0_wp, 2.0_wp, 0.0_wp])
      finish = start
      finish%cycle = 1
      do side = -1, 1, 2
         do i = -1, 1, 2
            do j = -1, 1, 2
               v = 0.5_wp*i
               approach = (1 + 0.1_wp*j)*small
               events(1) = event_type(impact_event, side, 0_int64, 1.0_wp, 1.0_wp, v, v, v + &
                  side*approach, v - 0.5_wp*side*approach)
               call trajectory_gradient(system, start, finish, events(:1), by_events, by_finish, &
                  good)
               call check(good == merge(1, 0, j > 0), 'gradient: an impact that only touches')
               ! on the same wall again, after a departure that is fast or slow
               events(2) = events(1)
               events(2)%phase = 1.1_wp
               events(1)%z_dot_before = v + side
               events(1)%z_dot_after = v - 0.5_wp*side
               call trajectory_gradient(system, start, finish, events, by_events, by_finish, good)
               call check(good == merge(2, 1, j > 0), 'gradient: a touch after a fast departure')
               events(1)%z_dot_after = v - side*9*small
               call trajectory_gradient(system, start, finish, events, by_events, by_finish, good)
               call check(good == 2, 'gradient: impacts that accumulate')
            end do
         end do
      end do
   end subroutine test_touches

   !> The figures of an attractor do not depend on a limit of events that is not reached; if it
   !! is reached, there are none.
   subroutine test_limits_of_events(settling)
      integer, intent(in) :: settling
      integer, parameter :: keep = 3
      type(forced_system_type) :: system
      real(wp) :: parameters(6, 1), places(4, 1), all_found(figures, 1), found(figures, 1), &
         all_ends(5, 1), ends(5, 1)
      integer :: counts(2, 1), all_counts(2, 1), status(1), most, reached

      system = settling_system(.false., 1.0_wp, 1.0_wp)
      parameters(:, 1) = [system%r, system%clearance, system%osc%xi, system%osc%mu, &
         system%osc%restitution]
      places(:, 1) = [0.4_wp, 0.1_wp, 0.9_wp, 0.8_wp]
      call perform(parameters, places, settling, keep, 100000, 1, all_found, all_ends, all_counts, &
         status)
      call check(status(1) == stat%ok .and. all_counts(1, 1) == 0, 'figures of some cycles')
      reached = 0
      do most = 0, 60
         call perform(parameters, places, settling, keep, most, 1, found, ends, counts, status)
         if (status(1) == stat%event_limit) then
            reached = reached + 1
            call check(all(ieee_is_nan(found)) .and. all(ieee_is_nan(ends)), 'no figures')
         else
            call check(status(1) == stat%ok .and. all(counts == all_counts), 'figures: counts')
            call check_close(found(speed, 1), all_found(speed, 1), 0.0_wp, 'figures: speed')
            call check_close(found(least_speed, 1), all_found(least_speed, 1), 0.0_wp, &
               'figures: least speed')
            call check_close(found(rms, 1), all_found(rms, 1), 0.0_wp, 'figures: rms')
            call check_close(ends(2, 1), all_ends(2, 1), 0.0_wp, 'figures: the state')
         end if
      end do
      ! the limit is reached until the last event of the cycles is allowed
      call check(reached > 2 .and. reached < 55, 'figures: with and without a limit')
   end subroutine test_limits_of_events

   !> With rest, the greatest approach speed is that of the impacts only, and no boundary has a
   !! distance.
   subroutine test_figures_with_rest()
      type(forced_system_type) :: system
      type(state_type) :: moments(4)
      type(event_type), allocatable :: events(:)
      real(wp) :: parameters(6, 1), places(4, 1), found(figures, 1), ends(5, 1)
      integer :: counts(2, 1), status(1)

      system = settling_system(.true., 1.0_wp, 1.0_wp)
      parameters(:, 1) = [system%r, system%clearance, system%osc%xi, system%osc%mu, &
         system%osc%restitution]
      places(:, 1) = [0.4_wp, 0.1_wp, 0.9_wp, 0.8_wp]
      call perform(parameters, places, 100, 1, 100000, 1, found, ends, counts, status)
      call check(status(1) == stat%ok .and. counts(1, 1) == 1, 'figures of a period with rest')
      call simulate_case(system, [0.0_wp, 0.1_wp, 0.0_wp, 0.1_wp, 0.5_wp], 1.0_wp, 200.0_wp, &
         100000, moments, events, status(1))
      call check_close(found(speed, 1), maxval(abs(events%x_dot_before - events%z_dot_before), &
         events%kind == impact_event), 1.0e-8_wp, 'figures: the fastest impact')
      call check(counts(2, 1) == count(events%kind == impact_event), 'figures: impacts')
      call check(.not. any(abs(found([least_speed, least_gap], 1)) > 0), 'figures: boundaries')
   end subroutine test_figures_with_rest

   !> The figures of a periodic motion are those of samples of its time history and of its events:
   !! greatest values, approach speeds, and the least distance from a wall at a turn.
   subroutine test_figures(clearance, n, right, left)
      !> Clearance, number of frequency ratios, and coefficients of restitution.
      real(wp), intent(in) :: clearance, right, left
      integer, intent(in) :: n
      integer, parameter :: samples = 3000
      real(wp), parameter :: tolerance = 5.0e-5_wp
      type(forced_system_type) :: system
      type(state_type) :: moments(4)
      type(event_type), allocatable :: events(:)
      real(wp) :: parameters(6, n), places(4, n), found(figures, n), ends(5, n), period
      real(wp), allocatable :: starts(:, :), x(:), x_dot(:), x_ddot(:), approach(:), v(:, :)
      integer :: counts(2, n), status(n), i, j, code, periodic, turning

      do j = 1, n
         parameters(:, j) = [0.6_wp + 0.9_wp*j/n, clearance, 0.05_wp, 0.2_wp, right, left]
         places(:, j) = [0.4_wp, -0.1_wp, 0.9_wp, 0.8_wp]
      end do
      call perform(parameters, places, 200, 1, 100000, 1, found, ends, counts, status)
      periodic = 0
      turning = 0
      do j = 1, n
         if (status(j) /= stat%ok .or. counts(1, j) == 0) cycle
         if (.not. found(least_speed, j) > 0) cycle
         periodic = periodic + 1
         associate (c => parameters(:, j))
            system = new_forced_system(oscillator_type(c(3), c(4), c(5:6)), c(1), 1.0_wp, c(2))
         end associate
         call simulate_case(system, ends(:, j), counts(1, j) + 1.0e-6_wp, 0.0_wp, 10000, moments, &
            events, code)
         period = 2*pi*counts(1, j)/system%r
         call check(size(events) == counts(2, j), 'figures: events of a period')
         allocate (starts(6, 0:size(events)), v(6, samples))
         starts(:, 0) = [ends(1, j), system%r*ends(1, j), ends(2:, j)]
         do i = 1, size(events)
            associate (e => events(i))
               starts(:, i) = [state_time(e%cycle, e%phase, system%r), e%phase, e%x, &
                  e%x_dot_after, e%x + 0.5_wp*e%side*clearance, e%z_dot_after]
            end associate
         end do
         call sample_segments(system, starts, [(0, i=0, size(events))], [(ends(1, j) + &
            (i - 0.5_wp)*period/samples, i=1, samples)], v)
         if (allocated(x)) deallocate (x, x_dot, x_ddot, approach)
         allocate (x, source=[v(1, :), events%x, events%x])
         allocate (x_dot, source=[v(2, :), events%x_dot_before, events%x_dot_after])
         allocate (x_ddot, source=[v(6, :), sin(events%phase), sin(events%phase)] &
            - 2*system%osc%xi*x_dot - x)
         allocate (approach, source=events%side*(events%z_dot_before - events%x_dot_before))
         call check_close(found(displacement, j), maxval(abs(x)), tolerance, 'figures: x')
         call check_close(found(acceleration, j), maxval(abs(x_ddot)), tolerance, &
            'figures: acceleration')
         call check_close(found(force, j), maxval(abs(x + 2*system%osc%xi*x_dot)), tolerance, &
            'figures: force')
         call check_close(found(rms, j), sqrt(sum(v(1, :)**2)/samples), tolerance, 'figures: rms')
         call check_close(found(speed, j), maxval(approach), 1.0e-6_wp, 'figures: speed')
         call check_close(found(least_speed, j), minval(approach), 1.0e-6_wp, &
            'figures: least speed')
         associate (gap => least_turn(v(5, :), 0.5_wp*clearance, ends(1, j), period, starts(1, :)))
            call check((gap < huge(gap)) .eqv. (found(least_gap, j) < huge(gap)), &
               'figures: turns before a wall')
            if (gap < huge(gap)) then
               turning = turning + 1
               call check_close(found(least_gap, j), gap, tolerance, 'figures: distance of a turn')
            end if
         end associate
         deallocate (starts, v)
      end do
      call check(periodic > n/4 .and. turning > 2, 'figures: periods with turns and without')
   end subroutine test_figures

   !> The least distance from a wall at which samples of the relative position turn; huge without a
   !! turn.
   pure real(wp) function least_turn(y, half, begin, period, events) result(gap)
      !> Samples, half the clearance, the time they cover, and the times of events.
      real(wp), intent(in) :: y(:), half, begin, period, events(:)
      integer :: i

      gap = huge(gap)
      do i = 2, size(y) - 1
         associate (a => y(i - 1), b => y(i), c => y(i + 1), &
            time => begin + (i - 0.5_wp)*period/size(y))
            if (any(abs(events - time) <= period/size(y))) cycle
            if (b > a .and. b >= c) gap = min(gap, half - b)
            if (b < a .and. b <= c) gap = min(gap, half + b)
         end associate
      end do
   end function least_turn

end module studies_trajectories
