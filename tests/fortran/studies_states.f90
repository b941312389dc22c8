!> Laws of states: starts of motions, free vibrations, and periodic motions as fixed points.
module studies_states
   use, intrinsic :: iso_fortran_env, only: int64
   use checks, only: check, check_close
   use random_numbers, only: draw, random_type
   use vi_attractor_basin, only: decide, event_limited, not_reached
   use vi_attractor_known, only: alike, ball, exact_period, identify, is_free, known_type, periodic
   use vi_attractor_list, only: attractor_list_type, label_states
   use vi_attractor_performance, only: figures, perform
   use vi_attractor_target, only: target_type
   use vi_contact, only: departure_type
   use vi_exponents, only: average_type, exponents_along, exponents_type
   use vi_forced_system, only: departure_from, event_type, forced_system_type, impact_event, &
      initial_state, new_forced_system, state_time, state_type, stick_event
   use vi_kinds, only: two_pi, wp
   use vi_oscillator, only: eta, oscillator_type
   use vi_peaks, only: find_peaks, peak_type
   use vi_simulate, only: simulate, simulate_cycles
   use vi_simulated_pair, only: new_simulated_pair, simulated_pair_type
   use vi_status, only: stat
   use vi_survey, only: attractor_type, limits_type, settle_from
   use vi_survey_outcome, only: not_settled, stable_period
   implicit none (type, external)
   private

   public :: test_states

   type(random_type) :: random

contains

   subroutine test_states()
      call test_times()
      call test_contacts()
      call test_kept_speed()
      call test_free_mass()
      call test_free_vibration()
      call test_mirrored_peaks()
      call test_fixed_point()
      call test_likeness()
      call test_neighbourhoods()
      call test_largest_ball()
      call test_accumulation()
      call test_stop()
      call test_limited_states()
   end subroutine test_states

   !> The load phase of a state is in [0, 2 pi), however little before a whole cycle it starts.
   subroutine test_times()
      type(forced_system_type) :: system
      type(state_type) :: state
      real(wp) :: times(9)
      integer :: i

      system = new_forced_system(oscillator_type(0.05_wp, 0.3_wp, [0.6_wp, 0.7_wp]), 0.8_wp, &
         1.0_wp, 3.0_wp)
      times = [-1.0e-20_wp, -1.0e-17_wp, -1.0_wp, 0.0_wp, 1.0e-20_wp, 7.0_wp, &
         100*two_pi/system%r, -100*two_pi/system%r, -1.0e4_wp]
      do i = 1, size(times)
         state = initial_state(system, [times(i), 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp])
         call check(state%phase >= 0 .and. state%phase < two_pi, 'a phase within a cycle')
         call check_close(state_time(state%cycle, state%phase, system%r), times(i), &
            1.0e-14_wp*(1 + abs(times(i))), 'the time of a state')
      end do
   end subroutine test_times

   !> On either wall a state departs, rests where the load presses, or is about to collide; to
   !! rounding, only a free mass on a wall does.
   subroutine test_contacts()
      real(wp), parameter :: half = 1.5_wp, speeds(3) = [-0.5_wp, 0.0_wp, 0.5_wp], &
         places(3) = [1.0_wp, 1 - 1.0e-13_wp, 1 - 1.0e-11_wp]
      type(forced_system_type) :: system
      type(state_type) :: state
      type(departure_type) :: departure
      real(wp) :: x, x_dot, z_dot, leaving, pressing
      integer :: i, j, k, l, side

      system = new_forced_system(oscillator_type(0.05_wp, 0.3_wp, [0.6_wp, 0.7_wp]), 0.8_wp, &
         1.0_wp, 2*half)
      do side = -1, 1, 2
         do l = -2, 2
            do k = 1, 3
               do j = 1, 3
                  do i = 1, 3
                     x = 0.75_wp*l
                     x_dot = speeds(i)
                     z_dot = speeds(j)
                     state = initial_state(system, [1.0_wp, x, x_dot, x + side*half*places(k), &
                        z_dot])
                     departure = departure_from(state, half)
                     leaving = side*(x_dot - z_dot)
                     pressing = side*(sin(0.8_wp) - 0.1_wp*x_dot - x)
                     if (k == 3) then
                        call check(state%side == 0 .and. departure%side == 0, 'near a wall')
                        call check(.not. state%resting, 'no rest near a wall')
                     else if (leaving < 0) then
                        call check(state%side == 0 .and. .not. state%resting, 'before an impact')
                        call check(departure%side == side, 'the wall of an impact at the start')
                        call check_close(departure%speed, leaving, 0.0_wp, 'its approach speed')
                     else
                        call check(state%side == side .and. departure%side == side, 'on a wall')
                        call check_close(state%speed, leaving, 0.0_wp, 'a departure speed')
                        call check_close(departure%speed, leaving, 0.0_wp, 'the same speed')
                        if (leaving > 0) then
                           state%side = 0
                           departure = departure_from(state, half)
                           call check(departure%side == 0, 'no impact of masses that separate')
                        end if
                        call check(state%resting .eqv. .not. (leaving > 0 .or. pressing > 0), &
                           'rest where the load presses')
                     end if
                  end do
               end do
            end do
         end do
      end do
   end subroutine test_contacts

   !> A departure speed below the rounding errors of the velocities is kept.
   subroutine test_kept_speed()
      type(state_type) :: state
      type(departure_type) :: departure
      integer :: side

      do side = -1, 1, 2
         state%side = side
         state%x_dot = 1
         state%z_dot = 1 + 8*side*epsilon(1.0_wp)
         state%z = 1.5_wp*side
         state%speed = 1.0e-20_wp
         departure = departure_from(state, 1.5_wp)
         call check(departure%side == side, 'the wall of a slow departure')
         call check_close(departure%speed, 1.0e-20_wp, 0.0_wp, 'a slow departure')
      end do
   end subroutine test_kept_speed

   !> A free mass that is never touched has no impacts, in either orientation of the system; a mass
   !! that moves, or is on a wall, is not free.
   subroutine test_free_mass()
      type(forced_system_type) :: system
      type(state_type) :: state, other
      type(event_type) :: events(4)
      real(wp) :: r
      integer :: i, n, free, left, status

      free = 0
      do i = 1, 200
         r = draw(random, 1.3_wp, 3.0_wp)
         system = new_forced_system(oscillator_type(0.05_wp, 0.3_wp, [0.6_wp, 0.7_wp]), r, &
            1.0_wp, 6.0_wp)
         state = state_type()
         state%phase = draw(random, 0.0_wp, 3.0_wp)
         state%x = draw(random, -1.0_wp, 1.0_wp)
         state%x_dot = draw(random, -1.0_wp, 1.0_wp)
         state%z = draw(random, -2.5_wp, 2.5_wp)
         other = state
         other%phase = state%phase + two_pi/2
         other%x = -state%x
         other%x_dot = -state%x_dot
         other%z = -state%z
         call check(is_free(system, state) .eqv. is_free(system, other), 'a mirrored free mass')
         if (.not. is_free(system, state)) cycle
         free = free + 1
         other = state
         other%z_dot = 1.0e-3_wp
         call check(.not. is_free(system, other), 'a mass that moves to the right')
         other%z_dot = -1.0e-3_wp
         call check(.not. is_free(system, other), 'a mass that moves to the left')
         other = state
         other%side = -1
         call check(.not. is_free(system, other), 'a mass on a wall')
         other = state
         other%resting = .true.
         call check(.not. is_free(system, other), 'a mass that rests')
         left = 100
         call simulate_cycles(system, state, 50, left, events, n, status)
         call check(status == stat%ok .and. n == 0, 'a free mass has no impacts')
      end do
      call check(free > 20 .and. free < 180, 'masses that are free and others')
   end subroutine test_free_mass

   !> If the walls are out of reach, peaks are half a period apart, and each is less than the
   !! previous one by the same factor; a start beyond a peak has no peak before the next zero.
   subroutine test_free_vibration()
      integer, parameter :: most = 9
      real(wp), parameter :: starts(2, 6) = reshape([1.0_wp, 0.0_wp, -1.0_wp, 0.0_wp, 1.0_wp, &
         0.5_wp, -1.0_wp, -0.5_wp, 1.0_wp, -0.5_wp, -1.0_wp, 0.5_wp], [2, 6])
      type(oscillator_type) :: osc
      type(peak_type) :: peaks(most, 1)
      real(wp) :: x, x_dot
      integer :: i, j, counts(1), status(1)

      osc = oscillator_type(0.05_wp, 0.3_wp, [0.6_wp, 0.7_wp])
      do j = 1, size(starts, 2)
         x = starts(1, j)
         x_dot = starts(2, j)
         call find_peaks(osc, [1000.0_wp], [x, x_dot, 0.0_wp, 0.0_wp], 1000, 1, peaks, counts, &
            status)
         call check(counts(1) == most .and. status(1) == stat%ok, 'as many peaks as wanted')
         call check((peaks(1, 1)%x*x > 0) .eqv. x*x_dot >= 0, 'the side of the first peak')
         call check(peaks(1, 1)%time < two_pi/2/eta(osc%xi), 'the first peak is soon')
         do i = 2, most
            call check_close(peaks(i, 1)%x, -exp(-osc%xi*(two_pi/2)/eta(osc%xi)) &
               *peaks(i - 1, 1)%x, 1.0e-13_wp, 'peaks decay')
            call check_close(peaks(i, 1)%time - peaks(i - 1, 1)%time, two_pi/2/eta(osc%xi), &
               1.0e-12_wp, 'half a period')
            call check(peaks(i, 1)%impacts == 0 .and. peaks(i, 1)%rests == 0, 'no impacts')
         end do
      end do
   end subroutine test_free_vibration

   !> A mirrored free vibration has mirrored peaks, with the same impacts and rests; a limit of
   !! events keeps the peaks before it.
   subroutine test_mirrored_peaks()
      integer, parameter :: most = 12
      type(oscillator_type) :: osc, turned
      type(peak_type) :: peaks(most, 2), mirrored(most, 2), some(most, 2)
      real(wp) :: start(4)
      integer :: i, j, k, counts(2), other_counts(2), status(2), other_status(2), rests

      osc = oscillator_type(0.02_wp, 0.2_wp, [0.3_wp, 0.7_wp])
      turned = osc
      turned%restitution = osc%restitution(2:1:-1)
      rests = 0
      do k = 1, 60
         start = [(draw(random, -1.0_wp, 1.0_wp), i=1, 4)]
         start(3) = 0.15_wp*start(3)
         call find_peaks(osc, [0.3_wp, 3.0_wp], start, 100000, 1, peaks, counts, status)
         call find_peaks(turned, [0.3_wp, 3.0_wp], -start, 100000, 1, mirrored, other_counts, &
            other_status)
         call check(all(counts == other_counts) .and. all(status == other_status), &
            'mirrored peaks: their number')
         call check(all(counts > 3), 'some peaks')
         call find_peaks(osc, [0.3_wp, 3.0_wp], start, 4*k, 1, some, other_counts, other_status)
         do j = 1, 2
            call check(other_counts(j) <= counts(j), 'not more peaks with less events')
            call check(other_status(j) == status(j) .or. other_status(j) == stat%event_limit, &
               'peaks: a limit of events')
            call check(all(peaks(2:counts(j), j)%time > peaks(:counts(j) - 1, j)%time), &
               'peaks in the order of time')
            call check(all(peaks(2:counts(j), j)%x*peaks(:counts(j) - 1, j)%x < 0), &
               'peaks on both sides in turn')
            do i = 1, min(counts(j), other_counts(j))
               call check_close(some(i, j)%x, peaks(i, j)%x, 0.0_wp, 'peaks before a limit')
            end do
            do i = 1, counts(j)
               associate (a => peaks(i, j), b => mirrored(i, j))
                  call check_close(a%x, -b%x, 1.0e-12_wp, 'mirrored peaks: x')
                  call check_close(a%time, b%time, 1.0e-9_wp, 'mirrored peaks: time')
                  call check_close(a%energy, b%energy, 1.0e-12_wp, 'mirrored peaks: energy')
                  call check(a%impacts == b%impacts .and. a%rests == b%rests, &
                     'mirrored peaks: impacts and rests')
                  rests = rests + a%rests
               end associate
            end do
         end do
      end do
      call check(rests > 10, 'free vibrations with rests')
      ! without impacts there are no different rounding errors
      do k = 1, 60
         start = [(draw(random, -1.0_wp, 1.0_wp), i=1, 4)]
         start(4) = 0
         call find_peaks(osc, [1.0e3_wp, 1.0e4_wp], start, 100000, 1, peaks, counts, status)
         call find_peaks(turned, [1.0e3_wp, 1.0e4_wp], -start, 100000, 1, mirrored, counts, status)
         call check(all(counts == most) .and. all(status == stat%ok), 'all peaks')
         call check(.not. any(abs(peaks%x + mirrored%x) > 0 .or. abs(peaks%time - mirrored%time) &
            > 0), 'mirrored peaks to the last bit')
      end do
   end subroutine test_mirrored_peaks

   !> A system that settles on a motion with two impacts per cycle, and a state on that motion.
   subroutine settled(system, state)
      type(forced_system_type), intent(out) :: system
      type(state_type), intent(out) :: state
      type(event_type) :: events(100)
      integer :: n, left, status

      system = new_forced_system(oscillator_type(0.0114_wp, 0.028_wp, [0.75_wp, 0.75_wp]), &
         1.05_wp, 1.0_wp, 30.0_wp)
      state = initial_state(system, [0.0_wp, 0.1_wp, 0.0_wp, 0.1_wp, 0.5_wp])
      left = 10000
      call simulate_cycles(system, state, 1500, left, events, n, status)
      call check(status == stat%ok .and. n > 2, 'a simulation that settles')
   end subroutine settled

   !> The exact motion of a state exists if the last event of the next period is within a
   !! hundredth of the clearance of that of the motion, in all coordinates and both directions.
   subroutine test_fixed_point()
      type(forced_system_type) :: system
      type(state_type) :: state, moved, final
      type(known_type) :: known, again
      type(event_type) :: events(100)
      real(wp) :: end(5), nearby(5), off(4), size_of_step
      integer, allocatable :: symbols(:)
      integer :: i, j, k, n, status, near, far
      logical :: good, shorter

      call settled(system, state)
      end = [state%phase/system%r, state%x, state%x_dot, state%z, state%z_dot]
      call exact_period(system, end, 1, known, good)
      call check(good, 'a fixed point')
      if (.not. good) return
      call check(known%kind == periodic .and. size(known%targets) == 2 .and. &
         all(known%symbols == [1, -1]), 'its impacts')
      call check(known%largest < 1, 'it is stable')
      call stable_period(system, state, 1, symbols, shorter)
      call check(.not. shorter .and. size(symbols) == 2, 'its period')
      do k = 2, 3
         call stable_period(system, state, k, symbols, shorter)
         call check(shorter .and. size(symbols) == 2*k, 'a multiple of its period')
         call exact_period(system, end, k, again, good)
         call check(good .and. .not. alike(again, known, system%clearance), 'not the same period')
         call check_close(again%largest, known%largest**k, 1.0e-6_wp, 'multiplier of a multiple')
      end do
      near = 0
      far = 0
      do k = 1, 40
         size_of_step = 1.0e-3_wp*1.15_wp**k*system%clearance
         do j = -1, 1, 2
            do i = 2, 5
               nearby = end
               nearby(i) = nearby(i) + j*size_of_step
               if (abs(nearby(4) - nearby(2)) > 0.49_wp*system%clearance) cycle
               moved = initial_state(system, nearby)
               moved%cycle = 0
               call simulate(system, moved, 1_int64, end(1)*system%r, events, n, final, status)
               if (n /= 2) cycle
               if (events(n)%side /= known%targets(2)%side) cycle
               associate (e => events(n), middle => known%targets(2)%middle)
                  off = [[e%x, e%x_dot_after, e%z_dot_after] - middle(:3), e%phase - middle(4)]
               end associate
               off(4) = off(4) - two_pi*anint(off(4)/two_pi)
               off(:3) = off(:3)/system%clearance
               call exact_period(system, nearby, 1, again, good)
               if (any(abs(off) > 1.001e-2_wp)) then
                  far = far + 1
                  call check(.not. good, 'a motion that is not near')
               else if (all(abs(off) < 0.999e-2_wp)) then
                  near = near + 1
                  call check(good, 'a motion that is near')
                  if (good) call check(alike(again, known, system%clearance), 'the same motion')
               end if
            end do
         end do
      end do
      call check(near > 50 .and. far > 20, 'states near and far')
      system%clearance = 100
      call exact_period(system, end, 1, known, good)
      call check(.not. good, 'no fixed point without events')
   end subroutine test_fixed_point

   !> Motions are equal if the first event of one is an event of the other: on the same wall, of
   !! the same kind, and at the same position, with a phase up to whole cycles.
   subroutine test_likeness()
      type(known_type) :: one, other
      real(wp) :: offsets(4)
      integer :: i, j

      one%cycles = 1
      one%symbols = [1, -1]
      allocate (one%targets(3))
      one%targets(1) = target_type(side=1, middle=[0.3_wp, 0.2_wp, -0.4_wp, 1.0_wp])
      one%targets(2) = target_type(side=-1, middle=[-0.2_wp, 0.1_wp, 0.5_wp, 4.0_wp])
      one%targets(3) = target_type(side=1, middle=[0.6_wp, 0.1_wp, -0.3_wp, 2.0_wp])
      call check(alike(one, one, 2.0_wp), 'a motion is like itself')
      other = one
      other%targets = one%targets([2, 3, 1])
      call check(alike(one, other, 2.0_wp), 'a motion from another event on')
      offsets = [2.0_wp, 2.0_wp, 2.0_wp, 1.0_wp]*1.0e-6_wp
      do j = -1, 1, 2
         do i = 1, 4
            other = one
            other%targets(1)%middle(i) = one%targets(1)%middle(i) + 0.9_wp*j*offsets(i)
            call check(alike(one, other, 2.0_wp), 'a motion that hardly differs')
            other%targets(1)%middle(i) = one%targets(1)%middle(i) + 1.1_wp*j*offsets(i)
            call check(.not. alike(one, other, 2.0_wp), 'a motion that differs')
         end do
         other = one
         other%targets%middle(4) = one%targets%middle(4) + j*two_pi
         call check(alike(one, other, 2.0_wp), 'a whole cycle apart')
      end do
      other = one
      other%targets(1)%side = -1
      call check(.not. alike(one, other, 2.0_wp), 'on another wall')
      other = one
      other%targets(1)%release = .true.
      call check(.not. alike(one, other, 2.0_wp), 'another kind of event')
      other = one
      other%cycles = 2
      call check(.not. alike(one, other, 2.0_wp), 'another period')
      other = one
      other%symbols = [1, 1, -1]
      call check(.not. alike(one, other, 2.0_wp), 'other symbols')
   end subroutine test_likeness

   !> A state approaches a motion if one of its events is in the box and in the ball of the motion.
   subroutine test_neighbourhoods()
      type(forced_system_type) :: system
      type(state_type) :: state, final
      type(event_type) :: events(20)
      type(target_type) :: target, targets(2)
      real(wp) :: start(5), ends(5, 1), box(4), d(4)
      integer :: i, k, labels(1), impacts(1), n, status, inside, expected

      system = new_forced_system(oscillator_type(0.05_wp, 0.2_wp, [0.7_wp, 0.6_wp]), 1.05_wp, &
         1.0_wp, 6.0_wp)
      start = [0.0_wp, 1.0_wp, 0.3_wp, 1.5_wp, 2.0_wp]
      state = initial_state(system, start)
      call simulate(system, state, 1_int64, 0.0_wp, events, n, final, status)
      call check(n == 1 .and. status == stat%ok, 'one event')
      target = target_type(side=events(1)%side)
      do i = 1, 4
         target%metric(i, i) = 1
         target%inverse(i, i) = 1
      end do
      box = [1.0e-3_wp, 2.0e-3_wp, 3.0e-3_wp, 4.0e-3_wp]
      inside = 0
      do k = 1, 500
         target%radius = draw(random, 2.0e-3_wp, 5.0e-3_wp)
         target%box = box
         d = [(1.5_wp*box(i)*draw(random, -1.0_wp, 1.0_wp), i=1, 4)]
         if (modulo(k, 5) > 0) then                ! a single coordinate decides
            d = 0
            i = modulo(k, 5)
            d(i) = 2*box(i)*draw(random, -1.0_wp, 1.0_wp)
         end if
         target%middle = [events(1)%x, events(1)%x_dot_after, events(1)%z_dot_after, &
            events(1)%phase + merge(two_pi, 0.0_wp, modulo(k, 2) == 0)] - d
         expected = merge(1, 0, all(abs(d) < box) .and. norm2(d) < target%radius)
         call decide(system%osc, system%r, system%load, system%clearance, [target], &
            reshape(start, [5, 1]), 1, 100, 1, labels, impacts, ends)
         call check(labels(1) == expected, 'in a neighbourhood or not')
         call check(impacts(1) == 1, 'events until it is decided')
         inside = inside + expected
         call decide(system%osc, system%r, system%load, system%clearance, [target], &
            reshape(start, [5, 1]), 9, 1, 1, labels, impacts, ends)
         call check(labels(1) == merge(1, event_limited, expected == 1), 'one event is allowed')
         if (expected == 0) cycle
         targets = target
         targets(1)%side = -target%side
         call decide(system%osc, system%r, system%load, system%clearance, targets, &
            reshape(start, [5, 1]), 1, 100, 1, labels, impacts, ends)
         call check(labels(1) == 2, 'a neighbourhood on the other wall')
         targets(1) = target
         targets(1)%radius = 0
         call decide(system%osc, system%r, system%load, system%clearance, targets, &
            reshape(start, [5, 1]), 1, 100, 1, labels, impacts, ends)
         call check(labels(1) == 2, 'no neighbourhood')
         targets(1) = target
         targets(1)%release = .true.
         call decide(system%osc, system%r, system%load, system%clearance, targets, &
            reshape(start, [5, 1]), 1, 100, 1, labels, impacts, ends)
         call check(labels(1) == 2, 'a neighbourhood of releases')
      end do
      call check(inside > 50 .and. inside < 450, 'neighbourhoods with and without the event')
   end subroutine test_neighbourhoods

   !> The largest neighbourhood of a motion counts; without a neighbourhood, nothing contracts.
   subroutine test_largest_ball()
      type(known_type) :: known
      integer :: k

      allocate (known%targets(3))
      call check(all(abs(ball(known) - [0.0_wp, 1.0_wp]) <= 0), 'no neighbourhood')
      do k = 0, 2
         known%targets%radius = cshift([0.1_wp, 0.3_wp, 0.2_wp], k)
         known%targets%contraction = cshift([0.5_wp, 0.6_wp, 0.9_wp], k)
         call check(all(abs(ball(known) - [0.3_wp, 0.6_wp]) <= 0), 'the largest neighbourhood')
      end do
   end subroutine test_largest_ball

   !> An accumulation is completed at once only if it lasts at most a millionth of 1/omega, however
   !! steady the acceleration is, and only if it ends before the simulation does.
   subroutine test_accumulation()
      type(forced_system_type) :: system
      type(state_type) :: begin, state, final
      type(event_type) :: events(2)
      real(wp) :: speed, lasts, last
      integer :: n, status, side, k

      ! at the crest of the load, and without damping, the acceleration hardly changes
      system = new_forced_system(oscillator_type(0.0_wp, 0.2_wp, [0.6_wp, 0.6_wp]), 0.5_wp, &
         1.0_wp, 6.0_wp)
      do side = -1, 1, 2
         do k = -9, -4
            speed = 10.0_wp**k
            lasts = speed/0.4_wp                              ! 2 u/(a (1 - R)) with a = 2
            begin = initial_state(system, [side*two_pi/4/system%r, 3.0_wp*side, 0.0_wp, &
               6.0_wp*side, -side*speed])
            begin%cycle = 0
            last = begin%phase + 2*system%r*lasts
            state = begin
            call simulate(system, state, 0_int64, last, events, n, final, status)
            call check(n == merge(1, 2, lasts < 1.0e-6_wp), 'events of an accumulation')
            call check(events(1)%side == side .and. (events(1)%kind == stick_event .eqv. &
               lasts < 1.0e-6_wp), 'a short accumulation is completed')
            if (lasts > 1.0e-6_wp) cycle
            call check(final%resting, 'rest after an accumulation')
            call check_close(events(1)%phase - begin%phase, system%r*lasts, 1.0e-4_wp*lasts &
               + 1.0e-15_wp, 'the time of an accumulation')
            last = begin%phase + 0.5_wp*system%r*lasts
            state = begin
            call simulate(system, state, 0_int64, last, events, n, final, status)
            call check(n == 0 .and. .not. final%resting, 'the end before that of an accumulation')
         end do
      end do
   end subroutine test_accumulation

   !> Work that is stopped before it starts is not computed.
   subroutine test_stop()
      type(forced_system_type) :: system
      type(state_type) :: state
      type(known_type) :: known, stopped
      type(peak_type) :: peaks(4, 2)
      type(attractor_type) :: attractor
      real(wp) :: end(5, 1), ends(5, 1), parameters(6, 1), found(figures, 1)
      type(simulated_pair_type) :: motion
      type(exponents_type) :: exponents
      integer :: progress(3), counts(2), status(2), labels(1), impacts(1), pairs(2, 1)
      logical :: good

      call settled(system, state)
      end(:, 1) = [state%phase/system%r, state%x, state%x_dot, state%z, state%z_dot]
      parameters(:, 1) = [system%r, system%clearance, system%osc%xi, system%osc%mu, &
         system%osc%restitution]
      progress = [0, 0, 1]
      call find_peaks(system%osc, [1.0_wp, 2.0_wp], end(2:, 1), 1000, 1, peaks, counts, status, &
         progress)
      call check(all(status == stat%not_computed) .and. all(counts == 0), 'stop: peaks')
      call decide(system%osc, system%r, system%load, system%clearance, [target_type()], end, 10, &
         1000, 1, labels, impacts, ends, progress)
      call check(labels(1) == not_reached .and. impacts(1) == 0, 'stop: basins')
      call perform(parameters, reshape([0.4_wp, 0.1_wp, 0.9_wp, 0.8_wp], [4, 1]), 10, 4, 1000, 1, &
         found, ends, pairs, status(:1), progress)
      call check(status(1) == stat%not_computed, 'stop: figures')
      motion = new_simulated_pair(system, state, 1000)
      call exponents_along(motion, average_type(cycles=3, batches=4), exponents, status(1))
      call check(status(1) == stat%ok, 'an exponent')
      motion = new_simulated_pair(system, state, 1000)
      call exponents_along(motion, average_type(cycles=3, batches=4), exponents, status(1), &
         progress)
      call check(status(1) == stat%not_computed, 'stop: an exponent')
      attractor%r = system%r
      attractor%clearance = system%clearance
      call settle_from(system%osc, 1, 20, limits_type(6, 2, 10000), attractor, progress)
      call check(.not. attractor%found .and. attractor%outcome == not_settled, 'stop: a survey')
      call identify(system, end(:, 1), 1, 1, known, good)
      call check(good .and. all(known%targets%radius > 0), 'neighbourhoods')
      call identify(system, end(:, 1), 1, 1, stopped, good, progress)
      call check(all(abs(stopped%targets%radius) <= 0), 'stop: neighbourhoods')
      call check(all(progress(::2) == [0, 1]), 'stop: no work is done')
   end subroutine test_stop

   !> If the longest period has too many events before states are decided, they count as limited.
   subroutine test_limited_states()
      type(attractor_list_type) :: list
      type(state_type) :: state
      real(wp) :: starts(5, 3), events
      integer :: labels(3), i

      call settled(list%system, state)
      list%max_events = 20
      do i = 1, 3
         starts(:, i) = [0.0_wp, 0.1_wp*i, 0.0_wp, 0.1_wp*i, 0.5_wp]
      end do
      call label_states(list, starts, 2, 1, labels, events)
      call check(all(labels == event_limited) .and. list%n == 0, 'too many events to be decided')
   end subroutine test_limited_states

end module studies_states
