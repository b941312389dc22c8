!> Periodic motions in which impacts accumulate and the free mass rests on a wall.
!!
!! A motion is a fixed point of the map from one release to the release k load cycles later, a map
!! of the plane (phase, v). The multipliers are its two eigenvalues and two zeros, which come from
!! the accumulation. The events of a simulated period give the symbols; the map along these symbols
!! (vi_rest_family) is smooth where the simulated one is not, and its derivative is known in closed
!! form. A solution is accepted if the simulation that starts from it returns to it.
module vi_rest_motion
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_assess, only: assess_rest, is_near_circle
   use vi_attractor_tangent, only: period_derivative
   use vi_doubt, only: caution, greater, worst_change
   use vi_forced_system, only: forced_system_type, event_type, impact_event, release_event, &
      state_time, state_type, stick_event
   use vi_event_symbols, only: read_symbols, symbol_sequence_type, total_phase
   use vi_kinds, only: two_pi, wp
   use vi_lapack, only: eigenvalues, solve
   use vi_motion, only: motion_type
   use vi_orbit, only: most_impacts, n_parameters, oscillator_parameters
   use vi_oscillator, only: left, right
   use vi_pattern, only: default_restitution, pattern_type
   use vi_rest_family, only: new_rest_family, plane_map, rest_family_type, rest_period, &
      rest_period_type
   use vi_simulate, only: simulate
   use vi_status, only: stat
   use vi_trajectory, only: extreme_positions
   implicit none (type, external)
   private

   public :: find_rest_motion, release_state, return_map, solve_rest_motion

contains

   !> The map from one release on a wall to the release k load cycles later.
   pure subroutine return_map(system, side, cycles, start, finish, events, n, status)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The wall, +1 or -1, and the load cycles k.
      integer, intent(in) :: side, cycles
      !> (phase, v) at the first release.
      real(wp), intent(in) :: start(2)
      !> (phase minus 2 pi k, v) at that release.
      real(wp), intent(out) :: finish(2)
      !> Events of the period, the last one the release; room for one more period is needed.
      type(event_type), intent(inout) :: events(:)
      !> Number of events of the period; 0 if there is no release near its end.
      integer, intent(out) :: n
      !> `stat%ok`, or `stat%no_motion` if there is no release near that time.
      integer, intent(out) :: status
      type(state_type) :: state, final
      real(wp) :: lapse, nearest, horizon
      integer :: i, found

      finish = 0
      n = 0
      ! most periods end close to their start: a search farther ahead finds no nearer release
      horizon = 0.1_wp
      do while (n == 0)
         state = release_state(system, side, start)
         call simulate(system, state, int(cycles, int64), start(1) + horizon, events, found, &
            final, status)
         if (status /= stat%ok) return
         nearest = horizon
         do i = 1, found
            if (events(i)%kind /= release_event .or. events(i)%side /= side) cycle
            lapse = two_pi*real(events(i)%cycle - cycles, wp) + events(i)%phase - start(1)
            if (abs(lapse) >= nearest) cycle
            nearest = abs(lapse)
            n = i
            finish = [start(1) + lapse, events(i)%x_dot_after]
         end do
         if (horizon > 1) exit
         horizon = 0.5_wp*two_pi
      end do
      if (n == 0) status = stat%no_motion
   end subroutine return_map

   !> The state at a release. The phase may lie a little outside [0, 2 pi).
   pure function release_state(system, side, start) result(state)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The wall, +1 or -1.
      integer, intent(in) :: side
      !> (phase, v)
      real(wp), intent(in) :: start(2)
      type(state_type) :: state

      state%phase = start(1)
      state%x_dot = start(2)
      state%z_dot = start(2)
      state%x = system%load*sin(start(1)) - 2*system%osc%xi*start(2)
      state%z = state%x + 0.5_wp*side*system%clearance
      state%side = side
      state%released = .true.
   end function release_state

   !> Newton's method for a fixed point of the return map.
   pure subroutine solve_rest_motion(system, side, cycles, point, motion, events, n)
      !> The system.
      type(forced_system_type), intent(in) :: system
      !> The wall, +1 or -1, and the load cycles k.
      integer, intent(in) :: side, cycles
      !> In: a guess of (phase, v) at the release. Out: the fixed point.
      real(wp), intent(inout) :: point(2)
      !> Its multipliers, the last two 0, its residual, the greatest change of phase and v/D over a
      !! simulated period, its verdicts, and its status: `stat%ok`, `stat%no_motion`,
      !! `stat%no_convergence`, or that of the simulation. No impacts.
      type(motion_type), intent(out) :: motion
      !> Events of the period (n of them), the last one the release.
      type(event_type), intent(inout) :: events(:)
      !> Number of events of the period.
      integer, intent(out) :: n
      !> Largest number of Newton steps, and of solutions with fixed symbols.
      integer, parameter :: most = 40, most_rounds = 4
      !> A simulated period that changes the state by less than this has the symbols of the motion.
      real(wp), parameter :: close_by = 0.02_wp
      type(rest_family_type) :: family
      type(rest_period_type) :: period
      real(wp), allocatable :: unknowns(:)
      real(wp) :: c(n_parameters), map(2, 2), matrix(2, 2), step(2), image(2), doubt
      logical :: good
      integer :: i, rounds

      n = 0
      motion%residual = huge(1.0_wp)
      motion%status = stat%no_motion
      if (.not. system%load > 0) return
      c = oscillator_parameters(system%osc, system%r, system%clearance/system%load)
      rounds = 0
      do i = 1, most
         call simulate_period(system, side, cycles, point, image, motion%residual, events, n, &
            family, unknowns, motion%status)
         if (motion%status /= stat%ok) return
         ! there is no solution with fixed symbols for a long period
         if ((rounds > 0 .or. is_long(family)) .and. motion%residual < 1.0e-11_wp) exit
         if (motion%residual < close_by .and. rounds < most_rounds .and. .not. is_long(family)) then
            rounds = rounds + 1
            call hold_symbols(family, c, unknowns, good)
            if (good) then
               point = [unknowns(1), sinh(unknowns(2))*system%clearance]
               cycle
            end if
         end if
         call map_of_period(system, cycles, family, unknowns, c, events(:n), period, map, good)
         motion%status = stat%no_convergence
         if (.not. good) return
         matrix = -map
         matrix(1, 1) = matrix(1, 1) + 1
         matrix(2, 2) = matrix(2, 2) + 1
         step = [image(1), asinh(image(2)/system%clearance)] - unknowns(:2)
         call solve(matrix, step, motion%status)
         if (motion%status /= stat%ok) return
         step = unknowns(:2) + step*min(1.0_wp, 0.3_wp/maxval(abs(step)))
         point = [step(1), sinh(step(2))*system%clearance]
      end do
      motion%status = merge(stat%ok, stat%no_convergence, motion%residual < 1.0e-10_wp)
      if (motion%status /= stat%ok) return
      point(1) = modulo(point(1), two_pi)
      call simulate_period(system, side, cycles, point, image, motion%residual, events, n, family, &
         unknowns, motion%status)
      if (motion%status /= stat%ok) return
      motion%status = stat%no_convergence
      call map_of_period(system, cycles, family, unknowns, c, events(:n), period, map, good)
      if (.not. good) return
      call plane_multipliers(map, motion%multipliers(:2), motion%status)
      doubt = 0
      if (is_near_circle(motion%multipliers(1))) then
         doubt = huge(1.0_wp)
         if (.not. is_long(family)) doubt = modulus_doubt(family, unknowns, c, period, &
            motion%multipliers(1))
      end if
      call assess_rest(map, doubt, motion)
   end subroutine solve_rest_motion

   !> Whether a period has more symbols than a family can have.
   pure logical function is_long(family)
      !> The family, as `read_period` returns it.
      type(rest_family_type), intent(in) :: family

      is_long = .not. allocated(family%symbols)
   end function is_long

   !> The derivative of the return map with respect to phase and asinh(v/D) at the release.
   pure subroutine map_of_period(system, cycles, family, unknowns, c, events, period, map, good)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Load cycles of the period.
      integer, intent(in) :: cycles
      !> The symbols.
      type(rest_family_type), intent(in) :: family
      !> Unknowns (m) as in vi_rest_family, and r, log(D), xi, mu, R1, R2.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> (n) Events of the period.
      type(event_type), intent(in) :: events(:)
      !> The period of the unknowns; not set if it is long.
      type(rest_period_type), intent(out) :: period
      !> (2, 2)
      real(wp), intent(out) :: map(2, 2)
      !> False if there is no derivative.
      logical, intent(out) :: good
      real(wp) :: p(4, 4), ends(2)

      if (.not. is_long(family)) then
         call rest_period(family, unknowns, c, period)
         good = period%right
         if (good) map = plane_map(period)
         return
      end if
      ! the simulated map, event by event; it is that of the symbols except where one vanishes
      call period_derivative(system, cycles, events, p, good)
      ! d(asinh(v/D)) = dv/sqrt(v^2 + D^2), at the end and at the start
      ends = sqrt([events(size(events))%x_dot_after, sinh(unknowns(2))*system%clearance]**2 &
         + system%clearance**2)
      map(1, :) = [p(2, 2), p(2, 1)*ends(2)]
      map(2, :) = [p(1, 2)/ends(1), p(1, 1)*ends(2)/ends(1)]
   end subroutine map_of_period

   !> The eigenvalues of the map of the plane, by decreasing modulus.
   pure subroutine plane_multipliers(map, pair, status)
      !> The map.
      real(wp), intent(in) :: map(2, 2)
      !> Both eigenvalues.
      complex(wp), intent(out) :: pair(2)
      !> As in `eigenvalues`.
      integer, intent(out) :: status
      real(wp) :: scratch(2, 2)

      scratch = map
      call eigenvalues(scratch, pair, status)
      if (abs(pair(2)) > abs(pair(1))) pair = pair([2, 1])
   end subroutine plane_multipliers

   !> Largest error of the modulus of the leading multiplier due to rounding of the unknowns. As in
   !! vi_doubt, their worst change is applied forward and backward; huge where nothing is certain.
   pure real(wp) function modulus_doubt(family, unknowns, c, period, leading) result(doubt)
      !> The symbols.
      type(rest_family_type), intent(in) :: family
      !> Unknowns (m) as in vi_rest_family, and r, log(D), xi, mu, R1, R2.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> The period of these.
      type(rest_period_type), intent(in) :: period
      !> Its leading multiplier.
      complex(wp), intent(in) :: leading
      type(rest_period_type) :: other
      real(wp) :: jacobian(size(unknowns), size(unknowns))
      real(wp), dimension(size(unknowns)) :: rounding, units, change
      complex(wp) :: pair(2)
      integer :: i, side, status
      logical :: regular

      do i = 1, size(unknowns)
         associate (equation => period%equations(i))
            jacobian(i, :) = equation%by(:size(unknowns))
            rounding(i) = caution*(epsilon(1.0_wp)*dot_product(abs(jacobian(i, :)), &
               abs(unknowns)) + abs(equation%value))
         end associate
      end do
      units = 1
      call worst_change(jacobian, rounding, units, change, regular)
      doubt = 0
      do side = -1, 1, 2
         if (.not. regular) exit
         call rest_period(family, unknowns + side*change, c, other)
         status = stat%no_convergence
         if (other%right) call plane_multipliers(plane_map(other), pair, status)
         regular = status == stat%ok
         if (regular) doubt = greater(doubt, abs(abs(pair(1)) - abs(leading)))
      end do
      if (.not. regular) doubt = huge(1.0_wp)
   end function modulus_doubt

   !> The periodic motion with rest near a release, complete with its events.
   pure subroutine find_rest_motion(system, side, cycles, guess, capacity, motion, events)
      !> The system.
      type(forced_system_type), intent(in) :: system
      !> The wall of the release, +1 or -1, and the load cycles of the period.
      integer, intent(in) :: side, cycles
      !> (phase, v) at the release.
      real(wp), intent(in) :: guess(2)
      !> Largest number of events of the period.
      integer, intent(in) :: capacity
      !> Its impacts are the first ones of the symbols, counted from the first symbol after the
      !! release; +2 and -2 among the sides are accumulation and rest.
      type(motion_type), intent(out) :: motion
      !> Events of the period, the last one the release.
      type(event_type), allocatable, intent(out) :: events(:)
      type(event_type), allocatable :: found(:)
      type(symbol_sequence_type) :: reading
      real(wp) :: point(2), period
      real(wp), allocatable :: times(:)
      logical :: complete
      integer :: n

      allocate (found(capacity))
      point = guess
      call solve_rest_motion(system, side, cycles, point, motion, found, n)
      if (motion%status /= stat%ok) return
      allocate (events, source=found(:n))
      call read_symbols(events, reading)
      motion%osc = system%osc
      motion%r = system%r
      motion%clearance = system%clearance
      motion%amplitude = system%amplitude
      motion%pattern = pattern_type(reading%symbols, cycles)
      times = event_times(system, events)
      associate (first => events(reading%first), symbols => reading%symbols)
         motion%restitution = default_restitution(symbols, system%osc%restitution(right), &
            system%osc%restitution(left))
         motion%phases = times(reading%first)*system%r
         motion%tau = first(1)%phase - system%lag
         motion%tau = motion%tau - two_pi*anint(motion%tau/two_pi)
         motion%x = first%x
         motion%z = first%x + 0.5_wp*sign(1, symbols)*system%clearance
         motion%x_dot_before = first%x_dot_before
         motion%x_dot_after = first%x_dot_after
         motion%z_dot_before = first%z_dot_before
         motion%z_dot_after = first%z_dot_after
      end associate
      period = two_pi*cycles/system%r
      call extreme_positions(system, transpose(reshape([times, events%phase, events%x, &
         events%x_dot_after, events%x + 0.5_wp*events%side*system%clearance, events%z_dot_after], &
         [n, 6])), merge(events%side, 0, events%kind == stick_event), period, motion%x_min, &
         motion%x_max, complete)
      if (.not. complete) then
         motion%x_min = ieee_value(1.0_wp, ieee_quiet_nan)
         motion%x_max = motion%x_min
      end if
   end subroutine find_rest_motion

   !> Times of events since the first one, in 1/omega.
   pure function event_times(system, events) result(times)
      !> The system.
      type(forced_system_type), intent(in) :: system
      !> In the order of time (n).
      type(event_type), intent(in) :: events(:)
      real(wp) :: times(size(events))
      integer :: i

      do i = 1, size(events)
         times(i) = state_time(events(i)%cycle, events(i)%phase, system%r)
      end do
      times = times - times(1)
   end function event_times

   !> Simulates a period: the state at its end, its events, symbols and unknowns.
   pure subroutine simulate_period(system, side, cycles, point, image, residual, events, n, &
      family, unknowns, status)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The wall, +1 or -1, and the load cycles k.
      integer, intent(in) :: side, cycles
      !> (phase, v) at the release.
      real(wp), intent(in) :: point(2)
      !> (phase minus 2 pi k, v) at the release k load cycles later.
      real(wp), intent(out) :: image(2)
      !> Greatest change of phase and v/D.
      real(wp), intent(out) :: residual
      !> Out: events 1 to n of the period, the last one the release.
      type(event_type), intent(inout) :: events(:)
      !> Number of events of the period; 0 if there is no such release.
      integer, intent(out) :: n
      !> Symbols of the period.
      type(rest_family_type), intent(out) :: family
      !> As in vi_rest_family: phase and asinh(v/D) at the release, phases of the first impacts.
      real(wp), allocatable, intent(out) :: unknowns(:)
      !> `stat%ok`, `stat%no_motion`, or the status of the simulation.
      integer, intent(out) :: status
      logical :: good

      residual = huge(1.0_wp)
      call return_map(system, side, cycles, point, image, events, n, status)
      if (status /= stat%ok) return
      residual = maxval(abs(image - point)/[1.0_wp, system%clearance])
      call read_period(events(:n), cycles, [point(1), asinh(point(2)/system%clearance)], family, &
         unknowns, good)
      if (.not. good) status = stat%no_motion
   end subroutine simulate_period

   !> Newton's method for the motion of given symbols.
   pure subroutine hold_symbols(family, c, unknowns, good)
      !> The symbols.
      type(rest_family_type), intent(in) :: family
      !> r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> In: a guess, as in vi_rest_family. Out: the motion; not changed if the iteration does not
      !! converge.
      real(wp), intent(inout) :: unknowns(:)
      !> Whether it converged.
      logical, intent(out) :: good
      integer, parameter :: most = 12
      type(rest_period_type) :: period
      real(wp) :: matrix(size(unknowns), size(unknowns)), step(size(unknowns)), moved, before
      real(wp) :: here(size(unknowns))
      integer :: i, j, status

      here = unknowns
      moved = huge(1.0_wp)
      good = .false.
      do i = 1, most
         call rest_period(family, here, c, period)
         if (.not. period%right) return
         do j = 1, size(here)
            matrix(j, :) = -period%equations(j)%by(:size(here))
         end do
         step = period%equations%value
         call solve(matrix, step, status)
         if (status /= stat%ok) return
         before = moved
         moved = maxval(abs(step))
         if (.not. moved < 0.3_wp) return
         here = here + step
         ! the steps are down to rounding
         good = moved < 1.0e-14_wp .or. (moved < 1.0e-9_wp .and. moved > 0.3_wp*before)
         if (good) exit
      end do
      if (good) unknowns = here
   end subroutine hold_symbols

   !> The family and the unknowns of a period from one release to the next, from its events.
   pure subroutine read_period(events, cycles, start, family, unknowns, good)
      !> (n) Events of the period, from just after the first release to the last one.
      type(event_type), intent(in) :: events(:)
      !> Load cycles of the period.
      integer, intent(in) :: cycles
      !> Phase and asinh(v/D) at the first release.
      real(wp), intent(in) :: start(2)
      !> Symbols in the order of the events; not allocated if a family cannot have so many.
      type(rest_family_type), intent(out) :: family
      !> As in vi_rest_family: the release, and the phases of the first impacts.
      real(wp), allocatable, intent(out) :: unknowns(:)
      !> False if the last symbol has no rest, or if a rest begins without an impact.
      logical, intent(out) :: good
      type(symbol_sequence_type) :: reading

      call read_symbols(events, reading)
      good = reading%n > 1
      ! the unknowns of a family do not distinguish a rest that begins without an impact
      if (good) good = abs(reading%symbols(reading%n)) == 2 .and. &
         all(events(reading%first)%kind == impact_event)
      if (.not. good) return
      if (reading%n <= most_impacts) family = new_rest_family(reading%symbols, cycles)
      unknowns = [start, total_phase(events(reading%first))]
   end subroutine read_period

end module vi_rest_motion
