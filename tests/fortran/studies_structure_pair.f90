!> The oscillator of 1983 among structures, from its two masses in any units, and similar ones.
module studies_structure_pair
   use, intrinsic :: iso_fortran_env, only: int64
   use checks, only: check
   use random_numbers, only: draw, draw_integer, draw_log, random_type
   use vi_kinds, only: wp
   use vi_status, only: stat
   use vi_structure, only: load_type, new_load, new_structure, structure_type
   use vi_structure_pair, only: pair_type, recognise
   use vi_structure_run, only: new_run, run_event_type, run_state_type, run_type, &
      simulate_structure, start_at
   implicit none (type, external)
   private

   public :: test_structure_pair

contains

   subroutine test_structure_pair()
      call test_recognised()
      call test_not_recognised()
   end subroutine test_structure_pair

   !> The oscillator of 1983 in any units: its own procedures and those for any structure find the
   !! same events, as long as a change of the initial state does not grow to ten times its size.
   subroutine test_recognised()
      type(random_type) :: random
      type(run_type) :: run, general
      real(wp) :: apart, start(2, 2), length, speed, scale(2)
      integer :: compared, i, status, with_rest
      real(wp), parameter :: small = 1.0e-9_wp
      type(run_event_type) :: events(20), same(20), moved(20)
      integer :: j, n, n_same, n_moved

      compared = 0
      with_rest = 0
      do i = 1, 1000
         call random_pair(random, run, start)
         general = run
         general%pair%known = .false.
         call simulate(run, start, events, n)
         call simulate(general, start, same, n_same)
         start = start + small*spread(maxval(abs(start), 1), 1, 2)*reshape([1, -1, -1, 1], [2, 2])
         call simulate(general, start, moved, n_moved)
         length = maxval(abs(start(:, 1))) + maxval(run%structure%openings)
         speed = maxval(abs(start(:, 2)))
         scale = 0
         do j = 1, min(n, n_same, n_moved)
            length = max(length, maxval(abs(same(j)%q)))
            speed = max(speed, maxval(abs(same(j)%rate)), same(j)%speed)
            scale = max(scale, [maxval(abs(same(j)%x)), maxval(abs(same(j)%v))])
            if (moved(j)%kind /= same(j)%kind .or. moved(j)%gap /= same(j)%gap) exit
            if (difference(same(j), moved(j)) > 10*small) exit
            call check(events(j)%kind == same(j)%kind .and. events(j)%gap == same(j)%gap, &
               'the same event')
            apart = difference(events(j), same(j))
            call check(apart < 1.0e-12_wp, 'the same state')
            compared = compared + 1
            if (events(j)%kind /= 1) with_rest = with_rest + 1
         end do
      end do
      call check(compared > 5000 .and. with_rest > 100, 'enough events')
   contains
      !> The events from a state, at most as many as the array holds.
      subroutine simulate(run, start, events, n)
         !> The run.
         type(run_type), intent(inout) :: run
         !> Coordinates and velocities (2, 2).
         real(wp), intent(in) :: start(:, :)
         !> The events, and their number.
         type(run_event_type), intent(inout) :: events(:)
         integer, intent(out) :: n
         type(run_state_type) :: state

         call start_at(run, 0.3_wp*run%period, start(:, 1), start(:, 2), state, status)
         call check(status == stat%ok, 'a state between the walls')
         call simulate_structure(run, state, 20_int64, 0.0_wp, events, n, status)
         call check(status == stat%ok .or. status == stat%more_events, 'a simulation')
      end subroutine simulate

      !> The largest difference between two events, relative to the largest numbers so far.
      real(wp) function difference(one, other)
         !> The events.
         type(run_event_type), intent(in) :: one, other

         difference = max(maxval(abs(one%q - other%q))/length, maxval(abs(one%rate &
            - other%rate))/speed, abs(one%speed - other%speed)/speed, &
            abs(one%impulse - other%impulse)/(speed*maxval(run%structure%effective)), &
            abs(real(one%cycle - other%cycle, wp) + (one%elapsed - other%elapsed)/run%period), &
            maxval(abs(one%x - other%x))/scale(1), maxval(abs(one%v - other%v))/scale(2))
      end function difference
   end subroutine test_recognised

   !> Any other force on the particle, or between it and the host, in either direction, makes a
   !! structure a different one.
   subroutine test_not_recognised()
      type(random_type) :: random
      type(run_type) :: run
      type(structure_type) :: structure
      type(load_type) :: load
      type(pair_type) :: pair
      real(wp) :: start(2, 2), part
      integer :: i, kind, p

      do i = 1, 40
         call random_pair(random, run, start)
         p = run%pair%particle
         part = draw_log(random, 1.0e-6_wp, 0.1_wp)*merge(1, -1, mod(i, 2) == 0)
         do kind = 0, 13
            structure = run%structure
            load = run%load
            select case (kind)
            case (1)
               structure%mass(1, 2) = part
            case (2)
               structure%mass(2, 1) = part
            case (3)
               structure%damping(1, 2) = part
            case (4)
               structure%damping(2, 1) = part
            case (5)
               structure%damping(p, p) = part
            case (6)
               structure%stiffness(1, 2) = part
            case (7)
               structure%stiffness(2, 1) = part
            case (8)
               ! a spring of the particle, if the host is the first coordinate
               structure%stiffness(p, p) = merge(part, -abs(part), p == 2)
            case (9)
               structure%directions(1, 1) = structure%directions(1, 1)*(1 + part)
            case (10)
               structure%openings(1) = structure%openings(1)*(1 + part)
            case (11)
               load%constant(3 - p) = part
            case (12)
               load%cosine(p, 1) = part
            case (13)
               load%sine(p, 1) = part
            case default
               ! the pair itself
            end select
            call recognise(structure, load, pair)
            call check(pair%known .eqv. kind == 0, 'another structure is not the pair')
         end do
      end do
   end subroutine test_not_recognised

   !> A random host with a free particle, in random units, and a state between the walls.
   subroutine random_pair(random, run, start)
      !> In and out: random numbers are drawn.
      type(random_type), intent(inout) :: random
      !> The run.
      type(run_type), intent(out) :: run
      !> (2, 2) Coordinates and velocities.
      real(wp), intent(out) :: start(2, 2)
      real(wp) :: matrices(2, 2, 3), gaps(3, 2), directions(2, 2), harmonics(2, 2, 1), nothing(2), &
         mass, omega, r, force, opening
      integer :: h, status

      h = draw_integer(random, 1, 2)
      mass = draw_log(random, 1.0e-2_wp, 1.0e2_wp)
      omega = draw_log(random, 1.0e-2_wp, 1.0e2_wp)
      force = draw_log(random, 1.0e-2_wp, 1.0e2_wp)
      r = draw_log(random, 0.3_wp, 4.0_wp)
      matrices = 0
      matrices(h, h, :) = mass*[1.0_wp, 2*omega*draw_log(random, 1.0e-2_wp, 0.6_wp), omega**2]
      matrices(3 - h, 3 - h, 1) = mass*draw_log(random, 1.0e-2_wp, 1.0_wp)
      opening = force/matrices(h, h, 3)*draw_log(random, 0.2_wp, 20.0_wp)
      directions(h, 1) = -draw_log(random, 0.1_wp, 10.0_wp)*(2*draw_integer(random, 0, 1) - 1)
      directions(3 - h, 1) = -directions(h, 1)
      directions(:, 2) = -directions(:, 1)
      gaps = 0
      gaps(1, :) = opening*abs(directions(h, 1))
      gaps(3, :) = [draw(random, 0.2_wp, 1.0_wp), draw(random, 0.2_wp, 1.0_wp)]
      harmonics = 0
      harmonics(h, :, 1) = force*[cos(r*mass), sin(r*mass)]
      nothing = 0
      call new_run(new_structure(matrices, directions, gaps), &
         new_load(r*omega, harmonics, nothing), run, status)
      call check(status == stat%ok .and. run%pair%known, 'a host with a particle is recognised')
      start(h, :) = force/matrices(h, h, 3)*[draw(random, -1.0_wp, 1.0_wp), &
         omega*draw(random, -1.0_wp, 1.0_wp)]
      start(3 - h, :) = start(h, :) + 0.9_wp*opening*[draw(random, -1.0_wp, 1.0_wp), &
         omega*draw(random, -1.0_wp, 1.0_wp)]
   end subroutine random_pair

end module studies_structure_pair
