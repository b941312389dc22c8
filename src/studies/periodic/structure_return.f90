!> The periodic motion on which a simulation of a structure settles, with accumulation and rest as
!! well.
!!
!! A motion with rest is a fixed point of the map of one period, started in the middle of its
!! longest flight without rest, and so is one with stops or friction; Newton's method uses the
!! derivative of the simulation in closed form. Without a load the period is unknown, too.
module vi_structure_return
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_assess, only: admission, consistency
   use vi_channels, only: first_event, leading_term, leaving_type, pace_type, reached_type, &
      row_derivatives, space_type
   use vi_exact, only: exact_acceptance
   use vi_kinds, only: two_pi, wp
   use vi_lapack, only: solve
   use vi_motion, only: unknown, yes
   use vi_progress, only: is_stopped
   use vi_restitution, only: table_law
   use vi_status, only: stat
   use vi_structure, only: load_type, regime_type, state_of, structure_type
   use vi_structure_assess, only: assess_multipliers
   use vi_structure_period, only: exact, periodic_structure, structure_motion_type
   use vi_structure_map, only: accelerations
   use vi_structure_run, only: at_once, impact_event, is_listed, new_run, release_event, &
      run_event_type, run_state_type, run_type, simulate_structure, start_at, state_now, &
      stick_event, time_of, whole_periods
   use vi_structure_variation, only: derivative_of_run, limit_of, project, start_tangent, &
      tangent_type, through_event
   implicit none (type, external)
   private

   public :: confirmed_cycles, is_attractor, is_steady, keep_period, one_cycle, repetition, &
      self_excited, settle, settle_arrays, settle_on, shorten, some_cycles

   !> Largest number of events of a period.
   integer, parameter, public :: most_events = 2000

   !> What is closed in a regime, as in `regime_type`.
   type, public :: closed_type
      integer, allocatable :: set(:)
   end type closed_type

   !> A motion as it was found.
   type, public :: settled_type
      type(structure_motion_type) :: motion
      !> (N) The gaps of its impacts, and load cycles in a period.
      integer, allocatable :: gaps(:)
      integer :: cycles = 0
      !> Whether the simulation on it repeated itself to rounding.
      logical :: repeats = .false.
      !> Whether it is self-excited, so that its phase is free, and then 2 pi over its period.
      logical :: free = .false.
      real(wp) :: frequency = 0
      !> (m) Gaps that rest, and the load phases (rad) at which each rest begins and ends.
      integer, allocatable :: resting(:)
      real(wp), allocatable :: rests(:, :)
      !> With stops or friction: all events, and what is closed after each of them; (2, events) the
      !! row of the regime before each that is at its limit, and +1 or -1 for its upper or lower
      !! one, or 0 where no row is.
      type(run_event_type), allocatable :: events(:)
      type(closed_type), allocatable :: closed(:)
      integer, allocatable :: limits(:, :)
      !> Where a branch starts with them: (3, events) kind and gap of each event in the order of the
      !! branch, and the number in `gaps` of the one at whose instant it comes.
      integer, allocatable :: sequence(:, :)
   end type settled_type

contains

   !> Simulates from a state, and finds the periodic motion on which it settles.
   subroutine settle(structure, load, start, q, rate, settling, most_cycles, cycles, found, &
      status, progress)
      !> The structure and its load, with a frequency > 0.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> Time, coordinates (n) and velocities (n) at the start.
      real(wp), intent(in) :: start, q(:), rate(:)
      !> As in `settle_on`.
      integer, intent(in) :: settling, most_cycles, cycles
      !> The motion.
      type(settled_type), intent(out) :: found
      !> As in `settle_on`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(run_type) :: run

      call new_run(structure, load, run, status)
      if (status == stat%ok) call settle_on(structure, run, start, q, rate, settling, most_cycles, &
         cycles, .false., huge(1), found, status, progress)
   end subroutine settle

   !> As `settle`, with regimes that are known, a limit of events, and until it is stopped.
   subroutine settle_on(structure, run, start, q, rate, settling, most_cycles, cycles, early, &
      max_events, found, status, progress, finish, nearness)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The structure under its load; regimes are added.
      type(run_type), intent(inout) :: run
      !> Time, coordinates (n) and velocities (n) at the start.
      real(wp), intent(in) :: start, q(:), rate(:)
      !> Load cycles simulated first, and largest number of load cycles in a period.
      integer, intent(in) :: settling, most_cycles
      !> Load cycles in a period if they are known: then the state need not be on the motion; 0 if
      !! they are not.
      integer, intent(in) :: cycles
      !> Whether a state that repeats to rounding on a stable motion is not simulated any further.
      logical, intent(in) :: early
      !> Events after which the simulation is given up.
      integer, intent(in) :: max_events
      !> The motion.
      type(settled_type), intent(out) :: found
      !> `stat%ok`; `stat%no_period` where the motion does not repeat within `most_cycles`;
      !! `stat%no_impacts` or `stat%permanent_rest`, once it is steady; `stat%permanent_stick` where
      !! friction sticks through the period; `stat%no_motion` where it
      !! has more than `most_events` events in a period, or no flight without rest;
      !! `stat%event_limit`, `stat%not_computed` if it was stopped; or a status of the simulation
      !! or of Newton's method.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> (2n) Coordinates and velocities some load cycles after the start, where the motion was
      !! looked for.
      real(wp), intent(inout), optional :: finish(:)
      !> How nearly a motion repeats that has settled, if not as usual.
      real(wp), intent(in), optional :: nearness
      !> How nearly a motion repeats once it has settled, and before that.
      real(wp), parameter :: usual = 1.0e-4_wp, at_rounding = 1.0e-9_wp
      real(wp) :: near
      type(run_state_type) :: state, at
      type(run_event_type), allocatable :: events(:)
      real(wp), allocatable :: strobes(:, :)
      real(wp) :: elapsed
      integer :: done, left

      near = usual
      if (present(nearness)) near = nearness
      call start_at(run, start, q, rate, state, status)
      if (status /= stat%ok) return
      allocate (events(most_events), strobes(2*size(q), 0:2*most_cycles))
      elapsed = state%elapsed
      left = max_events
      done = 0
      do while (early .and. done + 2*most_cycles <= settling)
         call some_cycles(run, state, elapsed, 2*most_cycles, left, events, strobes, status, &
            progress)
         if (status /= stat%ok) return
         done = done + 2*most_cycles
         call repetition(strobes, most_cycles, at_rounding, found%cycles)
         if (found%cycles == 0) cycle
         at = state
         call conclude(structure, run, at, elapsed, events, found, status, progress)
         if (any(status == [stat%no_impacts, stat%permanent_rest, stat%permanent_stick])) return
         if (status == stat%ok) then
            if (found%motion%verdicts%stable == yes) then
               call take_shortest(structure, run, at, elapsed, events, found, progress)
               return
            end if
         end if
         ! it passes by a motion that is not stable
         call forget(found)
      end do
      call some_cycles(run, state, elapsed, settling - done, left, events, strobes(:, :0), status, &
         progress)
      if (status /= stat%ok) return
      found%cycles = cycles
      if (cycles == 0) then
         call some_cycles(run, state, elapsed, 2*most_cycles, left, events, strobes, status, &
            progress)
         if (status /= stat%ok) return
         call repetition(strobes, most_cycles, at_rounding, found%cycles)
         found%repeats = found%cycles > 0
         if (.not. found%repeats) call repetition(strobes, most_cycles, near, found%cycles)
      end if
      if (present(finish)) call state_now(run, state, finish(:size(q)), finish(size(q) + 1:))
      if (found%cycles == 0) then
         status = stat%no_period
         return
      end if
      call conclude(structure, run, state, elapsed, events, found, status, progress)
      if (cycles == 0 .and. status == stat%ok) call take_shortest(structure, run, state, elapsed, &
         events, found, progress)
   end subroutine settle_on

   !> Load cycles of the shortest period of the stable motion near a state that repeats; 0 if none
   !! is
   !! confirmed. A motion of which it is not known whether it is stable, as where a mass may stay
   !! anywhere, counts if the state repeats to rounding.
   subroutine confirmed_cycles(structure, run, state, elapsed, cycles, repeats, events, period, &
      impacts, progress)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> The state.
      type(run_state_type), intent(in) :: state
      !> Time within the cycle.
      real(wp), intent(in) :: elapsed
      !> Load cycles after which it repeats.
      integer, intent(in) :: cycles
      !> Whether it does so to rounding.
      logical, intent(in) :: repeats
      !> Room for events.
      type(run_event_type), intent(inout) :: events(:)
      !> The result, and the number of impacts of the motion; -1 with rest, where the number of
      !! impacts of an accumulation depends on rounding, and where friction sticks throughout.
      integer, intent(out) :: period, impacts
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(run_state_type) :: at
      type(settled_type) :: found
      integer :: status

      period = 0
      impacts = 0
      at = state
      found%cycles = cycles
      call conclude(structure, run, at, elapsed, events, found, status, progress)
      if (status == stat%permanent_stick .and. repeats) then
         period = cycles
         impacts = -1
      end if
      if (status /= stat%ok) return
      found%repeats = repeats
      if (.not. is_attractor(found)) return
      call take_shortest(structure, run, at, elapsed, events, found, progress)
      period = found%cycles
      impacts = merge(-1, size(found%gaps), size(found%resting) > 0)
   end subroutine confirmed_cycles

   !> Whether a simulation that ends near a motion has settled on it.
   pure logical function is_attractor(found)
      !> The motion.
      type(settled_type), intent(in) :: found

      associate (verdicts => found%motion%verdicts)
         is_attractor = verdicts%admissible == yes .and. (verdicts%stable == yes .or. &
            (verdicts%stable == unknown .and. found%repeats))
      end associate
   end function is_attractor

   !> A motion over its shortest period: a simulation that settles slowly may repeat itself only
   !! after
   !! several of them.
   subroutine take_shortest(structure, run, state, elapsed, events, found, progress)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> The state at the end of the simulated period.
      type(run_state_type), intent(in) :: state
      !> Time within the cycle.
      real(wp), intent(in) :: elapsed
      !> Room for events.
      type(run_event_type), intent(inout) :: events(:)
      !> In: the motion. Out: over its shortest period.
      type(settled_type), intent(inout) :: found
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      real(wp), parameter :: near = 1.0e-6_wp
      type(settled_type) :: shorter
      type(run_state_type) :: at
      integer :: n, parts, status

      if (size(found%resting) == 0 .and. .not. has_elements(structure)) then
         call shorten(structure, run%load, found, shorter)
         found = shorter
         return
      end if
      do parts = found%cycles, 2, -1
         if (modulo(found%cycles, parts) > 0) cycle
         if (.not. repeats(found%resting, found%rests, two_pi*found%cycles, parts, near)) cycle
         ! the number of impacts before a rest depends on rounding
         if (size(found%resting) == 0) then
            if (.not. repeats(found%gaps, reshape(found%motion%phases, [1, size(found%gaps)]), &
               two_pi*found%cycles, parts, near)) cycle
         end if
         at = state
         shorter%cycles = found%cycles/parts
         call one_cycle(run, at, shorter%cycles, elapsed, events, n, status, progress)
         if (status == stat%ok) call by_return(run, at, elapsed, events, n, shorter, status)
         if (status == stat%ok) found = shorter
         return
      end do
   end subroutine take_shortest

   !> Whether events come again after an equal part of a period.
   pure logical function repeats(gaps, phases, period, parts, near)
      !> (n) Gap of each event, and (k, n) its load phases (rad).
      integer, intent(in) :: gaps(:)
      real(wp), intent(in) :: phases(:, :)
      !> The period (rad), and the number of its parts.
      real(wp), intent(in) :: period
      integer, intent(in) :: parts
      !> Largest difference of phases (rad).
      real(wp), intent(in) :: near
      integer :: m, n

      n = size(gaps)
      m = n/parts
      repeats = modulo(n, parts) == 0
      if (repeats) repeats = all(gaps(m + 1:) == gaps(:n - m)) .and. &
         all(abs(phases(:, m + 1:) - phases(:, :n - m) - period/parts) < near)
   end function repeats

   !> A motion over its shortest period, if its impacts repeat within the period given.
   pure subroutine shorten(structure, load, found, shorter)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> The motion.
      type(settled_type), intent(in) :: found
      !> The same one.
      type(settled_type), intent(out) :: shorter
      real(wp), parameter :: near = 1.0e-7_wp
      type(structure_type) :: own
      integer :: parts, m, n, status

      shorter = found
      n = size(found%gaps)
      if (size(found%resting) > 0 .or. has_elements(structure)) return
      do parts = n, 2, -1
         if (modulo(found%cycles, parts) > 0) cycle
         if (.not. repeats(found%gaps, reshape(found%motion%phases, [1, n]), two_pi*found%cycles, &
            parts, near)) cycle
         m = n/parts
         own = structure
         shorter%gaps = found%gaps(:m)
         shorter%cycles = found%cycles/parts
         call periodic_structure(own, load, shorter%gaps, found%motion%phases(:m), shorter%cycles, &
            exact, shorter%motion, status)
         if (status /= stat%ok) shorter = found
         return
      end do
   end subroutine shorten

   !> Resets a motion that was sought too early.
   pure subroutine forget(found)
      !> The motion.
      type(settled_type), intent(out) :: found

      found%cycles = 0
   end subroutine forget

   !> Simulates some cycles, one by one.
   subroutine some_cycles(run, state, elapsed, cycles, left, events, strobes, status, progress)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> Time within the cycle at which each ends.
      real(wp), intent(in) :: elapsed
      !> How many.
      integer, intent(in) :: cycles
      !> In and out: events until it is given up.
      integer, intent(inout) :: left
      !> Room for events.
      type(run_event_type), intent(inout) :: events(:)
      !> (2n, 0:) The states before and after the cycles, as many as there is room for.
      real(wp), intent(inout) :: strobes(:, 0:)
      !> As of `settle_on`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      integer :: i, m, n

      status = stat%ok
      m = size(strobes, 1)/2
      call state_now(run, state, strobes(:m, 0), strobes(m + 1:, 0))
      do i = 1, cycles
         call one_cycle(run, state, 1, elapsed, events, n, status, progress)
         left = left - n
         if (status == stat%ok .and. left < 0) status = stat%event_limit
         if (is_stopped(progress)) status = stat%not_computed
         if (status /= stat%ok) return
         if (i <= ubound(strobes, 2)) call state_now(run, state, strobes(:m, i), strobes(m + 1:, i))
      end do
   end subroutine some_cycles

   !> The motion near a state that repeats.
   subroutine conclude(structure, run, state, elapsed, events, found, status, progress)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> Time within the cycle.
      real(wp), intent(in) :: elapsed
      !> Room for events.
      type(run_event_type), intent(inout) :: events(:)
      !> In: with its cycles. Out: the motion.
      type(settled_type), intent(inout) :: found
      !> As of `settle_on`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> How far the motion may be from the simulated one: in phase (rad), and in speed relative to
      !! the largest one.
      real(wp), parameter :: near = 0.05_wp
      type(structure_type) :: own
      real(wp), allocatable :: apart(:)
      integer :: n

      call one_cycle(run, state, found%cycles, elapsed, events, n, status, progress)
      if (status /= stat%ok) return
      ! a gap may rest while others are hit
      if (any(events(:n)%kind /= impact_event .or. events(:n)%regime /= 1 .or. &
         events(:n)%together) .or. (n > 0 .and. has_elements(structure))) then
         if (sticks_throughout(run, state, events(:n))) then
            status = stat%permanent_stick
         else
            call by_return(run, state, elapsed, events, n, found, status)
         end if
      else if (n == 0) then
         ! a mass that still moves slowly will hit a gap
         associate (rests => size(run%regimes(state%regime)%held) > 0)
            status = merge(merge(stat%permanent_rest, stat%no_impacts, rests), stat%no_period, &
               is_steady(run, state))
         end associate
      else
         found%gaps = events(:n)%gap
         allocate (found%resting(0), found%rests(2, 0))
         own = structure
         call periodic_structure(own, run%load, found%gaps, phases_of(run, events(:n)), &
            found%cycles, exact, found%motion, status)
         if (status /= stat%ok) return
         ! another motion is not the one on which the simulation settles
         apart = found%motion%phases - phases_of(run, events(:n))
         if (any(abs(apart - two_pi*nint(apart(1)/two_pi)) > near) .or. &
            any(abs(found%motion%speeds - events(:n)%speed) > near*maxval(events(:n)%speed))) then
            status = stat%no_convergence
         end if
      end if
   end subroutine conclude

   !> Whether friction without a belt sticks through a whole period, at whatever position it came to
   !! a halt.
   pure logical function sticks_throughout(run, last, events) result(sticks)
      !> The run.
      type(run_type), intent(in) :: run
      !> The state at its end.
      type(run_state_type), intent(in) :: last
      !> Its events.
      type(run_event_type), intent(in) :: events(:)
      integer :: i, j

      sticks = .false.
      do j = 1, size(run%structure%laws)
         if (.not. run%structure%rubs(j)) cycle
         if (abs(run%structure%laws(j)%numbers(3)) > 0) cycle
         sticks = any(run%regimes(last%regime)%held == j) .and. all([(any(run%regimes(events(i)% &
            regime)%held == j), i=1, size(events))])
         if (sticks) return
      end do
   end function sticks_throughout

   !> Whether a motion without impacts has settled: near the steady motion of its regime, where what
   !! has no stiffness is at rest, as is friction that sticks without a belt.
   pure logical function is_steady(run, state, scale)
      !> The run.
      type(run_type), intent(in) :: run
      !> The state.
      type(run_state_type), intent(in) :: state
      !> What its coordinates and velocities are compared with, if not with themselves.
      real(wp), intent(in), optional :: scale(2)
      real(wp), parameter :: near = 1.0e-3_wp, at_rounding = 1.0e-9_wp
      real(wp), dimension(size(run%structure%mass, 1)) :: q, rate, steady, steady_rate
      real(wp), dimension(size(state%x)) :: x, v
      real(wp) :: sizes(2)
      integer :: m

      associate (regime => run%regimes(state%regime), stiff => &
         run%regimes(state%regime)%modes%stiffness > 0)
         v = -regime%modes%drift
         x = regime%modes%force + 2*regime%modes%damping*regime%modes%drift
         associate (sticks => regime%held(size(regime%resting) + 1:))
            ! the places where it sticks come last; what rounding leaves of their speed is no motion
            m = size(v) - size(sticks)
            if (all(abs(run%structure%laws(sticks)%numbers(3)) <= 0)) v(m + 1:) = state%v(m + 1:)
         end associate
         is_steady = .not. any(abs(x) > 0 .and. .not. stiff)
         if (.not. is_steady) return
         where (stiff)
            x = x/regime%modes%stiffness
         else where
            ! such a coordinate may be anywhere
            x = state%x
         end where
         call state_of(regime, run%load%frequency*state%elapsed, x, v, steady, steady_rate)
         call state_now(run, state, q, rate)
         sizes = [maxval(abs(q)), maxval(abs(rate))]
         if (present(scale)) then
            ! what nothing damps does not settle: it is compared with itself
            if (all(regime%modes%damping > 0 .or. .not. stiff)) sizes = scale
         end if
         is_steady = maxval(abs(q - steady)) <= near*sizes(1) .and. &
            maxval(abs(rate - steady_rate)) <= near*sizes(2) .and. .not. &
            any(abs(state%v - v) > at_rounding*maxval(abs(state%v)) .and. .not. stiff)
      end associate
   end function is_steady

   !> Load phases of events, from the beginning of the cycle of the first one.
   pure function phases_of(run, events) result(phases)
      !> The run.
      type(run_type), intent(in) :: run
      !> Events.
      type(run_event_type), intent(in) :: events(:)
      real(wp) :: phases(size(events))
      integer :: i

      do i = 1, size(events)
         phases(i) = (real(events(i)%cycle - events(1)%cycle, wp)*run%period + events(i)%elapsed)* &
            (two_pi/run%period)
      end do
   end function phases_of

   !> Simulates some cycles.
   subroutine one_cycle(run, state, cycles, elapsed, events, n, status, progress)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> In and out: the state.
      type(run_state_type), intent(inout) :: state
      !> How many; time within the cycle at the end.
      integer, intent(in) :: cycles
      !> As in `cycles`.
      real(wp), intent(in) :: elapsed
      !> The events, and their number.
      type(run_event_type), intent(inout) :: events(:)
      integer, intent(out) :: n
      !> `stat%ok`, `stat%no_motion` for too many events, `stat%not_computed` if it was stopped, or
      !! a status of the simulation.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      integer(int64) :: last
      integer :: more

      ! rounding may leave the state just before or after the section
      last = nint((real(state%cycle, wp)*run%period + state%elapsed - elapsed)/run%period, int64) &
         + cycles
      n = 0
      do
         call simulate_structure(run, state, last, elapsed, events(n + 1:), more, status, .true.)
         n = n + more
         if (status /= stat%more_events) return
         if (n == size(events)) status = stat%no_motion
         if (is_stopped(progress)) status = stat%not_computed
         if (status /= stat%more_events) return
      end do
   end subroutine one_cycle

   !> The period in cycles that repeats best; 0 if none does.
   !!
   !! Just past a period doubling the shorter period repeats approximately, too. Of the periods that
   !! repeat about as well as the best one, the shortest is taken.
   pure subroutine repetition(strobes, most, near, cycles)
      !> (2n, 0:2 most) States once a cycle.
      real(wp), intent(in) :: strobes(:, 0:)
      !> Most cycles.
      integer, intent(in) :: most
      !> How nearly it repeats, relative to the largest coordinate or velocity.
      real(wp), intent(in) :: near
      !> The period.
      integer, intent(out) :: cycles
      real(wp), parameter :: at_rounding = 1.0e-9_wp
      real(wp) :: apart(most), scale(2)
      integer :: k, n

      n = size(strobes, 1)/2
      scale = [maxval(abs(strobes(:n, :))), maxval(abs(strobes(n + 1:, :)))]
      scale = max(scale, tiny(1.0_wp))
      do k = 1, most
         apart(k) = max(maxval(abs(strobes(:n, k:2*most) - strobes(:n, :2*most - k)))/scale(1), &
            maxval(abs(strobes(n + 1:, k:2*most) - strobes(n + 1:, :2*most - k)))/scale(2))
      end do
      cycles = findloc(apart <= min(near, max(at_rounding, 10*minval(apart))), .true., 1)
   end subroutine repetition

   !> The motion with rest near a simulated period.
   subroutine by_return(run, first, section, events, n, found, status)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> The state at the end of the simulated period.
      type(run_state_type), intent(in) :: first
      !> Time within the cycle at which the simulated period began and ended.
      real(wp), intent(in) :: section
      !> In: the events of the period. Out: those of the motion.
      type(run_event_type), intent(inout) :: events(:)
      !> In: their number. Out: meaningless.
      integer, intent(inout) :: n
      !> In: with its cycles. Out: the motion.
      type(settled_type), intent(inout) :: found
      !> As in `settle`.
      integer, intent(out) :: status
      type(run_state_type) :: at
      real(wp) :: s(2*size(run%structure%mass, 1)), wait, elapsed
      integer :: i

      at = first
      elapsed = section
      do i = 1, 2
         call middle_of_flight(run, at, elapsed, events(:n), found%cycles, wait)
         if (.not. wait >= 0) then
            status = stat%no_motion
            return
         end if
         elapsed = at%elapsed + wait
         call simulate_structure(run, at, at%cycle + int(elapsed/run%period, int64), &
            modulo(elapsed, run%period), events, n, status)
         if (status /= stat%ok) return
         elapsed = at%elapsed
         if (size(run%regimes(at%regime)%resting) == 0 .or. i == 2) exit
         ! a period that begins at an event may lack it, since it is not the motion's yet
         call one_cycle(run, at, found%cycles, elapsed, events, n, status)
         if (status /= stat%ok) return
      end do
      call state_now(run, at, s(:size(s)/2), s(size(s)/2 + 1:))
      call close_period(run, elapsed, .false., s, events, found, status)
      if (status == stat%ok .and. has_elements(run%structure)) call doubt_marginal(found%motion)
   end subroutine by_return

   !> The motion by Newton's method for a state to which a period returns, and for the period T of
   !! the run where it is unknown.
   subroutine close_period(run, section, free, s, events, found, status, progress)
      !> In and out: regimes are added; the period of its load is changed if it is free.
      type(run_type), intent(inout) :: run
      !> Time within the cycle at which the period begins and ends.
      real(wp), intent(in) :: section
      !> Whether the period is unknown.
      logical, intent(in) :: free
      !> (2n) In: coordinates and velocities nearly at the beginning. Out: those of the motion.
      real(wp), intent(inout) :: s(:)
      !> Room for events.
      type(run_event_type), intent(inout) :: events(:)
      !> In: with its cycles. Out: the motion.
      type(settled_type), intent(inout) :: found
      !> As of `settle_on` or `self_excited`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> Steps of Newton's method, and periods that are simulated where it has no derivative.
      integer, parameter :: most_steps = 30, most_periods = 1000
      type(structure_type) :: structure
      type(load_type) :: load
      type(run_state_type) :: begun, state
      real(wp) :: p(size(s), size(s)), step(size(s)), change, before, largest, period
      integer :: m, most, n, steps
      logical :: ordered

      m = size(s)/2
      period = run%period
      before = huge(1.0_wp)
      most = most_steps
      do steps = 0, most_periods
         if (steps > most) exit
         n = 0
         call start_at(run, section, s(:m), s(m + 1:), begun, status)
         ! the step led into a gap
         if (status == stat%gap_closed) status = stat%no_convergence
         if (status /= stat%ok) return
         state = begun
         call one_cycle(run, state, found%cycles, section, events, n, status, progress)
         if (status /= stat%ok) return
         if (size(run%regimes(state%regime)%resting) + size(run%regimes(begun%regime)%resting) &
            > 0) status = stat%no_convergence
         if (status /= stat%ok) return
         call derivative_of_run(run, begun, events(:n), state, p, largest, &
            found%motion%verdicts%law, status)
         ! the derivative of one order of changes at one instant leads to the motion as well
         ordered = status == stat%no_derivative .and. .not. any(events(:n)%together)
         if (ordered) status = stat%ok
         call state_now(run, state, step(:m), step(m + 1:))
         step = s - step
         found%motion%residual = maxval(abs(step)/scales(s))
         if (status == stat%zero_approach .and. has_elements(run%structure) .and. &
            found%motion%residual <= exact_acceptance .and. .not. free) then
            ! a motion at which the period has no derivative
            p = ieee_value(1.0_wp, ieee_quiet_nan)
            exit
         end if
         if (status == stat%no_derivative .and. .not. free) then
            ! impacts on coupled gaps at one instant: the periods of a simulation settle
            p = ieee_value(1.0_wp, ieee_quiet_nan)
            most = most_periods
            if (found%motion%residual <= exact_acceptance .and. (found%motion%residual <= &
               4*epsilon(1.0_wp) .or. found%motion%residual >= before)) exit
            before = found%motion%residual
            s = s - step
            cycle
         end if
         if (status /= stat%ok) return
         ! also if the state repeats: a motion without a unique Newton step is not determined
         call newton_step(run, begun, state, s, p, free, step, period, change, status)
         if (status /= stat%ok) return
         if (found%motion%residual <= 4*epsilon(1.0_wp)) exit
         if (change <= 1.0e-7_wp .and. change >= before) exit
         before = change
         s = s + step
         if (.not. free) cycle
         structure = run%structure
         load = run%load
         load%frequency = two_pi/period
         call new_run(structure, load, run, status)
         if (status /= stat%ok) return
      end do
      status = merge(stat%ok, stat%no_convergence, steps <= most)
      if (status == stat%ok .and. ordered) then
         if (.not. is_common(run, section, begun, s, p, found%cycles)) p = ieee_value(1.0_wp, &
            ieee_quiet_nan)
      end if
      if (status == stat%ok) call keep_period(run, begun, events(:n), state, p, largest, free, &
         found)
   end subroutine close_period

   !> Whether the multipliers of a motion are the same for each order of changes at one instant, as
   !! in a symmetric structure: those of nearby simulations, in which the changes are apart.
   logical function is_common(run, section, begun, s, p, cycles) result(alike)
      !> In and out: regimes are added.
      type(run_type), intent(inout) :: run
      !> As of `close_period`.
      real(wp), intent(in) :: section
      !> The beginning, (2n) its coordinates and velocities, and (2n, 2n) the derivative of one
      !! order.
      type(run_state_type), intent(in) :: begun
      real(wp), intent(in) :: s(:), p(:, :)
      !> Load cycles in a period.
      integer, intent(in) :: cycles
      !> How far the simulations are apart, as a share of the largest coordinate or velocity; and
      !! how near multipliers must be.
      real(wp), parameter :: apart = 1.0e-7_wp, near = 1.0e-5_wp
      integer, parameter :: directions = 3
      type(run_state_type) :: nearby, state
      type(run_event_type), allocatable :: events(:)
      real(wp) :: other(size(s), size(s)), step(size(s), 1), largest, law
      integer :: i, j, m, n, side, status

      alike = .false.
      m = size(s)/2
      allocate (events(most_events))
      do i = 1, directions
         do side = -1, 1, 2
            step(:, 1) = side*apart*scales(s)*[(cos(real(i*j*j, wp)), j=1, 2*m)]
            ! friction that sticks keeps its speed
            call project(run%structure, run%regimes(begun%regime)%held, step(m + 1:, :))
            call start_at(run, section, s(:m) + step(:m, 1), s(m + 1:) + step(m + 1:, 1), nearby, &
               status)
            if (status /= stat%ok) return
            state = nearby
            n = 0
            call one_cycle(run, state, cycles, section, events, n, status)
            if (status == stat%ok) call derivative_of_run(run, nearby, events(:n), state, other, &
               largest, law, status)
            if (status /= stat%ok) return
            if (.not. have_same_powers(p, other, near)) return
         end do
      end do
      alike = .true.
   end function is_common

   !> Whether the sums of all powers of the eigenvalues of two matrices are the same.
   pure logical function have_same_powers(a, b, near) result(same)
      !> (k, k) The matrices.
      real(wp), intent(in) :: a(:, :), b(:, :)
      !> How near they must be for entries of 1 or less.
      real(wp), intent(in) :: near
      real(wp), dimension(size(a, 1), size(a, 1)) :: first, second
      real(wp) :: scale
      integer :: i, j

      same = .true.
      scale = max(1.0_wp, maxval(sum(abs(a), 2)))
      first = a/scale
      second = b/scale
      do i = 1, size(a, 1)
         if (i > 1) then
            first = matmul(first, a/scale)
            second = matmul(second, b/scale)
         end if
         same = same .and. abs(sum([(first(j, j) - second(j, j), j=1, size(a, 1))])) <= near
      end do
   end function have_same_powers

   !> The largest coordinate and the largest velocity of a state, by which others are compared.
   pure function scales(s) result(scale)
      !> (2n) Coordinates and velocities.
      real(wp), intent(in) :: s(:)
      real(wp) :: scale(size(s))
      integer :: m

      m = size(s)/2
      scale(:m) = max(maxval(abs(s(:m))), tiny(1.0_wp))
      scale(m + 1:) = max(maxval(abs(s(m + 1:))), tiny(1.0_wp))
   end function scales

   !> Keeps a period that returns to its beginning, and gives the verdicts on it.
   subroutine keep_period(run, begun, events, state, p, largest, free, found)
      !> The run.
      type(run_type), intent(in) :: run
      !> The state at the beginning, the events, and the state at the end.
      type(run_state_type), intent(in) :: begun
      type(run_event_type), intent(in) :: events(:)
      type(run_state_type), intent(in) :: state
      !> (2n, 2n) The derivative of the period, and its factor of rounding errors.
      real(wp), intent(in) :: p(:, :), largest
      !> Whether its phase is free, so that one multiplier is 1.
      logical, intent(in) :: free
      !> In: with residual and law. Out: the motion.
      type(settled_type), intent(inout) :: found
      logical :: complete, push

      found%free = free
      call store_period(run, events, found)
      if (has_elements(run%structure)) call store_events(run, begun, events, found)
      found%motion%verdicts%consistent = consistency(found%motion%residual, exact_acceptance)
      call examine_rests(run, events, state, push, complete)
      if (.not. push .and. any(events%together)) then
         ! some of the contacts among impacts at one instant last no longer than rounding
         push = .true.
         complete = .false.
      end if
      if (found%motion%verdicts%consistent == yes) found%motion%verdicts%admissible = &
         admission(push, complete)
      found%motion%verdicts%p = p
      allocate (found%motion%verdicts%multipliers(size(p, 1)))
      found%motion%verdicts%multipliers = cmplx(p(1, 1) - p(1, 1), 0.0_wp, wp)
      found%motion%verdicts%determinant = p(1, 1) - p(1, 1)
      ! an accumulation of many impacts costs digits: entries are accurate to about 1e-10
      call assess_multipliers(largest*merge(1.0e-12_wp, epsilon(1.0_wp), &
         any(events%kind == stick_event)), found%motion%verdicts, free)
   end subroutine keep_period

   !> The motion on which a simulation without a load settles, whose period T is unknown, too.
   !!
   !! Newton's method finds the state s and T of phi_T(s) = s in the middle of the longest flight,
   !! with a step at right angles to the velocity of the state:
   !!
   !!     [ P - I, f T ; f^T, 0 ] (ds, dT/T) = (s - phi_T(s), 0)
   subroutine self_excited(structure, load, q, rate, duration, guess, found, frequency, status, &
      progress, left, scale, finish, steady)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Constant forces; without a frequency.
      type(load_type), intent(in) :: load
      !> Coordinates (n) and velocities (n) at the start.
      real(wp), intent(in) :: q(:), rate(:)
      !> Time that is simulated first, in which the motion must repeat; not if its period is known.
      real(wp), intent(in) :: duration
      !> The period nearly, or 0.
      real(wp), intent(in) :: guess
      !> The motion, with phases from its first event.
      type(settled_type), intent(out) :: found
      !> 2 pi/T.
      real(wp), intent(out) :: frequency
      !> `stat%ok`; `stat%no_period`, `stat%no_impacts`, `stat%permanent_rest` or `stat%singular`
      !! where there is no such motion, or as in `settle_on`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> In and out: events until the simulation is given up, with `stat%event_limit`.
      integer, intent(inout), optional :: left
      !> A coordinate and a velocity in comparison with which an equilibrium is reached.
      real(wp), intent(in), optional :: scale(2)
      !> (2n) Coordinates and velocities at the end of the simulation.
      real(wp), intent(out), optional :: finish(:)
      !> Whether it ends in an equilibrium, with `stat%no_impacts` or `stat%permanent_rest`.
      logical, intent(out), optional :: steady
      type(run_type) :: run
      type(load_type) :: own
      type(run_state_type) :: state
      type(run_event_type), allocatable :: events(:)
      real(wp), allocatable :: s(:)
      real(wp) :: period, wait
      integer :: n

      frequency = 0
      allocate (events(most_events), s(2*size(q)))
      s = [q, rate]
      period = guess
      status = stat%ok
      if (.not. period > 0) call find_period(structure, load, duration, events, s, period, status, &
         progress, left, scale, steady)
      if (present(finish)) finish = s
      if (status /= stat%ok) return
      own = load
      own%frequency = two_pi/period
      call new_run(structure, own, run, status)
      if (status == stat%ok) call start_at(run, 0.0_wp, s(:size(q)), s(size(q) + 1:), state, status)
      if (status == stat%ok) call one_cycle(run, state, 1, 0.0_wp, events, n, status, progress)
      if (status /= stat%ok) return
      found%cycles = 1
      if (n == 0) status = stat%no_impacts
      if (sticks_throughout(run, state, events(:n))) status = stat%permanent_stick
      if (status /= stat%ok) return
      call middle_of_flight(run, state, 0.0_wp, events(:n), 1, wait)
      if (.not. wait >= 0) status = stat%no_motion
      if (status /= stat%ok) return
      associate (whole => int(wait/period))
         call simulate_structure(run, state, state%cycle + whole, wait - whole*period, events, n, &
            status)
      end associate
      if (status /= stat%ok) return
      call state_now(run, state, s(:size(q)), s(size(q) + 1:))
      call close_period(run, 0.0_wp, .true., s, events, found, status, progress)
      if (status /= stat%ok) return
      if (.not. guess > 0) call take_part(run, s, events, found, progress)
      frequency = run%load%frequency
      found%frequency = frequency
      if (size(found%resting) > 0) found%rests = found%rests - found%motion%phases(1)
      found%motion%phases = found%motion%phases - found%motion%phases(1)
   end subroutine self_excited

   !> A self-excited motion over its shortest period: a simulation that settles slowly may repeat
   !! itself best after several of them.
   subroutine take_part(run, s, events, found, progress)
      !> In and out: the run over the period, the longer one or the shortest.
      type(run_type), intent(inout) :: run
      !> (2n) In and out: coordinates and velocities of the motion, between events.
      real(wp), intent(inout) :: s(:)
      !> Room for events.
      type(run_event_type), intent(inout) :: events(:)
      !> In and out: the motion.
      type(settled_type), intent(inout) :: found
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      real(wp), parameter :: near = 1.0e-6_wp
      type(settled_type) :: shorter
      type(run_type) :: own
      type(load_type) :: load
      real(wp) :: from(size(s))
      integer :: n, parts, status

      n = size(found%gaps)
      do parts = n, 2, -1
         if (.not. repeats(found%gaps, reshape(found%motion%phases, [1, n]), two_pi, parts, &
            near)) cycle
         load = run%load
         load%frequency = parts*load%frequency
         call new_run(run%structure, load, own, status)
         from = s
         shorter%cycles = 1
         if (status == stat%ok) call close_period(own, 0.0_wp, .true., from, events, shorter, &
            status, progress)
         if (status /= stat%ok) return
         run = own
         s = from
         found = shorter
         return
      end do
   end subroutine take_part

   !> A step of Newton's method for a state, and for its period if that is free.
   pure subroutine newton_step(run, begun, state, s, p, free, step, period, change, status)
      !> The run.
      type(run_type), intent(in) :: run
      !> The states at the beginning and the end of the period.
      type(run_state_type), intent(in) :: begun, state
      !> (2n) Coordinates and velocities at the beginning, and (2n, 2n) the derivative of the end.
      real(wp), intent(in) :: s(:), p(:, :)
      !> Whether the period is free.
      logical, intent(in) :: free
      !> (2n) In: s - phi_T(s). Out: the step.
      real(wp), intent(inout) :: step(:)
      !> In and out: T.
      real(wp), intent(inout) :: period
      !> The largest relative step.
      real(wp), intent(out) :: change
      !> `stat%ok`; `stat%singular` where more than the phase is free, `stat%no_convergence` where
      !! T would not be positive.
      integer, intent(out) :: status
      real(wp), dimension(size(s) + merge(1, 0, free)) :: x
      real(wp) :: a(size(x), size(x)), scale(size(s))
      real(wp), dimension(size(s)/2) :: acceleration
      integer :: i, m

      m = size(s)/2
      ! positions and velocities are compared by their scales
      scale = scales(s)
      a = 0
      x = 0
      x(:2*m) = step/scale
      do i = 1, 2*m
         a(:2*m, i) = p(:, i)
         a(i, i) = a(i, i) - 1
      end do
      a(:m, m + 1:2*m) = a(:m, m + 1:2*m)*(scale(2*m)/scale(1))
      a(m + 1:2*m, :m) = a(m + 1:2*m, :m)*(scale(1)/scale(2*m))
      if (free) then
         call accelerations(run%regimes(state%regime), 0.0_wp, state%x, state%v, acceleration)
         a(:2*m, 2*m + 1) = period*[s(m + 1:) - step(m + 1:), acceleration]/scale
         call accelerations(run%regimes(begun%regime), 0.0_wp, begun%x, begun%v, acceleration)
         a(2*m + 1, :2*m) = period*[s(m + 1:), acceleration]/scale
      end if
      call solve(a, x, status)
      change = maxval(abs(x))
      if (status /= stat%ok) return
      step = scale*x(:2*m)
      if (.not. free) return
      if (.not. x(2*m + 1) > -1) status = stat%no_convergence
      period = period*(1 + x(2*m + 1))
   end subroutine newton_step

   !> Simulates without a load for some time, and finds the period with which the last events
   !! repeat.
   subroutine find_period(structure, load, duration, events, s, period, status, progress, left, &
      scale, steady)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Constant forces; without a frequency.
      type(load_type), intent(in) :: load
      !> How long.
      real(wp), intent(in) :: duration
      !> Room for events.
      type(run_event_type), intent(inout) :: events(:)
      !> (2n) In: coordinates and velocities at the start. Out: those at the end.
      real(wp), intent(inout) :: s(:)
      !> The period.
      real(wp), intent(out) :: period
      !> As of `self_excited`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> As of `self_excited`.
      integer, intent(inout), optional :: left
      !> As of `self_excited`.
      real(wp), intent(in), optional :: scale(2)
      !> As of `self_excited`.
      logical, intent(out), optional :: steady
      real(wp), parameter :: near = 1.0e-3_wp, at_rounding = 1.0e-9_wp
      type(run_type) :: run
      type(run_state_type) :: state
      real(wp) :: apart(size(events)/2)
      integer(int64) :: last
      integer :: half, k, more, n

      period = 0
      half = size(events)/2
      if (present(steady)) steady = .false.
      call new_run(structure, load, run, status)
      associate (m => size(s)/2)
         if (status == stat%ok) call start_at(run, 0.0_wp, s(:m), s(m + 1:), state, status)
         if (status /= stat%ok) return
         last = whole_periods(run, duration)
         n = 0
         do
            call simulate_structure(run, state, last, max(0.0_wp, duration - real(last, wp)* &
               run%period), events(n + 1:), more, status, .true.)
            n = n + more
            if (present(left)) then
               left = left - more
               if (left < 0 .and. any(status == [stat%ok, stat%more_events])) status = &
                  stat%event_limit
            end if
            if (status /= stat%more_events) exit
            if (is_stopped(progress)) status = stat%not_computed
            if (status /= stat%more_events) exit
            if (n < size(events)) cycle
            ! the last ones count
            events(:n - half) = events(half + 1:n)
            n = n - half
         end do
         if (status /= stat%ok) return
         call state_now(run, state, s(:m), s(m + 1:))
      end associate
      if (n == 0) status = merge(stat%permanent_rest, stat%no_impacts, size(run%regimes( &
         state%regime)%held) > 0)
      if (n == 0 .and. present(steady)) steady = is_steady(run, state, scale)
      if (n == 0) return
      apart = huge(1.0_wp)
      do k = 1, n/2
         apart(k) = mismatch(events(n - k + 1:n), events(n - 2*k + 1:n - k))
      end do
      k = findloc(apart <= min(near, max(at_rounding, 10*minval(apart))), .true., 1)
      if (k == 0) status = stat%no_period
      if (k == 0) return
      period = time_of(run, events(n)) - time_of(run, events(n - k))
      if (.not. period > 0) status = stat%no_period
   end subroutine find_period

   !> The largest difference of the states after two series of events, relative to the largest
   !! coordinate or velocity; huge where the events differ.
   pure real(wp) function mismatch(now, before)
      !> (k) The events.
      type(run_event_type), intent(in) :: now(:), before(:)
      real(wp) :: size_of_q, size_of_rate
      integer :: i

      mismatch = huge(1.0_wp)
      if (any(now%kind /= before%kind .or. now%gap /= before%gap .or. now%regime /= &
         before%regime)) return
      size_of_q = tiny(1.0_wp)
      size_of_rate = tiny(1.0_wp)
      do i = 1, size(now)
         size_of_q = max(size_of_q, maxval(abs(now(i)%q)))
         size_of_rate = max(size_of_rate, maxval(abs(now(i)%rate)))
      end do
      mismatch = 0
      do i = 1, size(now)
         mismatch = max(mismatch, maxval(abs(now(i)%q - before(i)%q))/size_of_q, &
            maxval(abs(now(i)%rate - before(i)%rate))/size_of_rate)
      end do
   end function mismatch

   !> Near a continuum of motions, or a fold, a state is known to the residual over 1 - lambda, and
   !! lambda changes by as much: where that is all of 1 - lambda, nothing is known.
   pure subroutine doubt_marginal(motion)
      !> In and out: the motion.
      type(structure_motion_type), intent(inout) :: motion
      real(wp), parameter :: reserve = 100

      associate (verdicts => motion%verdicts)
         if (verdicts%stable /= yes) return
         if (minval(abs(verdicts%multipliers - 1))**2 <= reserve*max(motion%residual, &
            epsilon(1.0_wp))) verdicts%stable = unknown
      end associate
   end subroutine doubt_marginal

   !> Whether a structure has stops or friction.
   pure logical function has_elements(structure)
      !> The structure; it need not be complete.
      type(structure_type), intent(in) :: structure

      has_elements = any(structure%laws%kind > table_law)
   end function has_elements

   !> Whether no contact pulls while it rests, apart from the simulation: at the beginning of each
   !! rest, after each event during it, and in between.
   pure subroutine examine_rests(run, events, last, push, complete)
      !> The run.
      type(run_type), intent(in) :: run
      !> The events of a period.
      type(run_event_type), intent(in) :: events(:)
      !> The state at its end.
      type(run_state_type), intent(in) :: last
      !> Whether all contacts push; whether all rests could be examined.
      logical, intent(out) :: push, complete
      real(wp) :: duration
      integer :: i

      push = .true.
      complete = .true.
      do i = 1, size(events)
         if (size(run%regimes(events(i)%regime)%resting) == 0) cycle
         if (i < size(events)) then
            duration = real(events(i + 1)%cycle - events(i)%cycle, wp)*run%period &
               + (events(i + 1)%elapsed - events(i)%elapsed)
         else
            duration = real(last%cycle - events(i)%cycle, wp)*run%period + (last%elapsed &
               - events(i)%elapsed)
         end if
         ! what is released next may be released by rounding later
         if (.not. at_once(run, duration)) call examine_rest(run%regimes(events(i)%regime), &
            run%structure%channels, run%load%frequency*events(i)%elapsed, events(i)%x, &
            events(i)%v, duration, push, complete)
      end do
   end subroutine examine_rests

   !> Whether no force of a regime falls below 0 between two events.
   pure subroutine examine_rest(regime, channels, phase, x, v, duration, push, complete)
      !> The regime, and the number of channels.
      type(regime_type), intent(in) :: regime
      integer, intent(in) :: channels
      !> Load phase (rad) and pairs (m) after the first event.
      real(wp), intent(in) :: phase
      real(wp), contiguous, intent(in) :: x(:), v(:)
      !> Time to the second one.
      real(wp), intent(in) :: duration
      !> In and out: set to false where one does; where the search is not complete.
      logical, intent(inout) :: push, complete
      !> A release may be early by this share.
      real(wp), parameter :: agreement = 1.0e-8_wp
      type(regime_type) :: alone
      type(leaving_type) :: rising(size(regime%resting))
      type(reached_type) :: reached
      type(space_type) :: space
      type(pace_type) :: pace
      real(wp) :: d(0:3)
      integer :: i, sense

      do i = 1, size(rising)
         call leading_term(regime, x, v, phase, channels + i, 0, rising(i)%order, sense)
         push = push .and. sense >= 0
         if (rising(i)%order == 0) cycle
         rising(i)%row = channels + i
         rising(i)%wall = -1
         call row_derivatives(regime, x, v, phase, channels + i, d)
         if (rising(i)%order == 1) rising(i)%speed = d(1)
      end do
      if (.not. push) return
      ! the gaps were watched by the simulation
      alone = regime
      alone%upper(:channels) = huge(1.0_wp)
      alone%lower(:channels) = -huge(1.0_wp)
      call first_event(alone, x, v, phase, leaving_type(), duration*(1 - agreement), pace, &
         reached, space, partings=rising)
      complete = complete .and. reached%complete
      push = reached%row == 0
   end subroutine examine_rest

   !> How long after the end of a simulated period the middle of its longest flight without rest
   !! comes; negative if there is none.
   pure subroutine middle_of_flight(run, first, section, events, cycles, wait)
      !> The run.
      type(run_type), intent(in) :: run
      !> The state at its end.
      type(run_state_type), intent(in) :: first
      !> Time within the cycle at its beginning and its end.
      real(wp), intent(in) :: section
      !> Its events.
      type(run_event_type), intent(in) :: events(:)
      !> Its length in cycles.
      integer, intent(in) :: cycles
      !> The result.
      real(wp), intent(out) :: wait
      real(wp) :: times(size(events)), flight, longest
      integer :: i, n, next
      logical :: only_free

      n = size(events)
      do i = 1, n
         ! since the beginning of the period
         times(i) = real(events(i)%cycle - first%cycle + cycles, wp)*run%period &
            + (events(i)%elapsed - section)
      end do
      wait = -1
      longest = 0
      ! where friction always sticks, what sticks has one speed less to be found
      only_free = any([(size(run%regimes(events(i)%regime)%held) == 0, i=1, n)])
      do i = 1, n
         associate (regime => run%regimes(events(i)%regime))
            if (size(regime%resting) > 0 .or. (only_free .and. size(regime%held) > 0)) cycle
         end associate
         next = modulo(i, n) + 1
         flight = times(next) - times(i)
         if (next <= i) flight = flight + cycles*run%period
         if (flight <= longest) cycle
         longest = flight
         wait = times(i) + 0.5_wp*flight
      end do
   end subroutine middle_of_flight

   !> Keeps the impacts and rests of a period.
   pure subroutine store_period(run, events, found)
      !> The run.
      type(run_type), intent(in) :: run
      !> The events.
      type(run_event_type), intent(in) :: events(:)
      !> In and out: filled in.
      type(settled_type), intent(inout) :: found
      integer, allocatable :: impacts(:), sticks(:)
      real(wp) :: phases(size(events)), whole
      integer :: i, j, n

      phases = phases_of(run, events)
      whole = two_pi*found%cycles
      impacts = pack([(i, i=1, size(events))], is_listed(events))
      sticks = pack([(i, i=1, size(events))], events%kind == stick_event)
      n = size(run%structure%mass, 1)
      found%gaps = events(impacts)%gap
      found%motion%phases = phases(impacts)
      found%motion%speeds = events(impacts)%speed
      found%motion%impulses = events(impacts)%impulse
      allocate (found%motion%states(2*n, size(impacts)))
      do i = 1, size(impacts)
         associate (event => events(impacts(i)))
            call state_of(run%regimes(event%regime), run%load%frequency*event%elapsed, event%x, &
               event%v, found%motion%states(:n, i), found%motion%states(n + 1:, i))
         end associate
      end do
      found%resting = events(sticks)%gap
      allocate (found%rests(2, size(sticks)))
      do i = 1, size(sticks)
         found%rests(:, i) = phases(sticks(i))
         do j = 1, size(events)
            ! the first release of this gap after it
            associate (at => modulo(sticks(i) + j - 1, size(events)) + 1)
               if (events(at)%kind /= release_event .or. events(at)%gap /= found%resting(i)) cycle
               found%rests(2, i) = phases(at) + merge(whole, 0.0_wp, at < sticks(i))
            end associate
            exit
         end do
      end do
   end subroutine store_period

   !> Keeps all events of a period with stops or friction.
   pure subroutine store_events(run, begun, events, found)
      !> The run.
      type(run_type), intent(in) :: run
      !> The state at the beginning, and the events.
      type(run_state_type), intent(in) :: begun
      type(run_event_type), intent(in) :: events(:)
      !> In and out: filled in.
      type(settled_type), intent(inout) :: found
      type(tangent_type) :: tangent
      real(wp) :: none(2*size(run%structure%mass, 1), 0)
      integer :: i, status

      if (allocated(found%closed)) deallocate (found%closed, found%limits)
      found%events = events
      allocate (found%closed(size(events)), found%limits(2, size(events)))
      call start_tangent(run, begun, none, tangent)
      do i = 1, size(events)
         call limit_of(run, events(i), tangent, found%limits(:, i))
         call through_event(run, events(i), tangent, status)
         found%closed(i)%set = run%regimes(events(i)%regime)%closed
      end do
   end subroutine store_events

   !> The motion as arrays.
   subroutine settle_arrays(structure, load, start, state, settling, most_cycles, cycles, &
      counts, &
      labels, impacts, states, rests, p, multipliers, scalars, verdicts, status)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> Time, coordinates and velocities (2n) at the start.
      real(wp), intent(in) :: start, state(:)
      !> As in `settle`.
      integer, intent(in) :: settling, most_cycles, cycles
      !> Numbers of impacts, load cycles, and rests.
      integer, intent(out) :: counts(3)
      !> (2, capacity) Gaps of the impacts, and of the rests.
      integer, intent(out) :: labels(:, :)
      !> (capacity, 3) Load phases, approach speeds, impulses.
      real(wp), intent(out) :: impacts(:, :)
      !> (2n, capacity) Coordinates and velocities just after each impact.
      real(wp), intent(out) :: states(:, :)
      !> (2, capacity) Load phases at which each rest begins and ends.
      real(wp), intent(out) :: rests(:, :)
      !> (2n, 2n) The derivative of the period.
      real(wp), intent(out) :: p(:, :)
      !> (2n) Its eigenvalues.
      complex(wp), intent(out) :: multipliers(:)
      !> The residual, det[P], and the value that it must have.
      real(wp), intent(out) :: scalars(3)
      !> Consistent, admissible, stable.
      integer, intent(out) :: verdicts(3)
      !> As in `settle`; `stat%more_events` if the capacity is too small.
      integer, intent(out) :: status
      type(settled_type) :: found
      integer :: m, n

      counts = 0
      labels = 0
      impacts = 0
      states = 0
      rests = 0
      p = 0
      multipliers = 0
      scalars = 0
      verdicts = unknown
      n = size(state)/2
      call settle(structure, load, start, state(:n), state(n + 1:), settling, most_cycles, cycles, &
         found, status)
      if (status /= stat%ok) return
      n = size(found%gaps)
      m = size(found%resting)
      counts = [n, found%cycles, m]
      if (max(n, m) > size(labels, 2)) status = stat%more_events
      if (status /= stat%ok) return
      labels(1, :n) = found%gaps
      labels(2, :m) = found%resting
      impacts(:n, 1) = found%motion%phases
      impacts(:n, 2) = found%motion%speeds
      impacts(:n, 3) = found%motion%impulses
      states(:, :n) = found%motion%states
      rests(:, :m) = found%rests
      p = found%motion%verdicts%p
      multipliers = found%motion%verdicts%multipliers
      scalars = [found%motion%residual, found%motion%verdicts%determinant, &
         found%motion%verdicts%law]
      verdicts = [found%motion%verdicts%consistent, found%motion%verdicts%admissible, &
         found%motion%verdicts%stable]
   end subroutine settle_arrays

end module vi_structure_return
