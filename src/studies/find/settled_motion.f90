!> The periodic motion on which a state settles, confirmed by Newton's method.
!!
!! A simulation that repeats itself for two periods is no proof: near a fold, or between bursts of
!! intermittent chaos, it does so for a long time. A state counts as settled only if Newton's
!! method, started from its last period, leads to an admissible, stable motion near that period.
!! That motion can also be computed by itself, for a simulation that is given.
module vi_settled_motion
   use vi_attractor_known, only: is_free
   use vi_event_symbols, only: period_type, read_periods, total_phase
   use vi_exponents, only: is_chaotic
   use vi_forced_system, only: event_type, forced_system_type, initial_state, release_event, &
      state_type
   use vi_found_motion, only: describe_motion, described_type, found_type, in_standard_form, &
      new_found, new_resting, scale_of
   use vi_kinds, only: two_pi, wp
   use vi_motion, only: yes
   use vi_pattern, only: pattern_type
   use vi_simulate, only: simulate_cycles
   use vi_simulated_pair, only: new_simulated_pair, simulated_pair_type
   use vi_status, only: stat
   use vi_trajectory, only: read_events
   implicit none (type, external)
   private

   public :: end_arrays, settle_on

   !> Outcomes of a state: a confirmed motion; a motion that is confirmed but not stable (or not
   !! admissible, or this is unknown); a simulation that repeats itself although Newton's method
   !! finds no motion near it; one that does not repeat itself; one that ends with the free mass at
   !! rest where no wall reaches it; one that could not be completed, or had too many events.
   integer, parameter, public :: settled = 1, not_stable = 2, unconfirmed = 3, wandering = 4, &
      no_impacts = 5, unfinished = 6
   integer, parameter, public :: n_outcomes = 6

   !> Longest period considered, in load cycles, and its largest number of symbols.
   integer, parameter, public :: longest = 16
   integer, parameter :: most_symbols = 100
   !> Events kept of the end of a simulation, and of a period with rest.
   integer, parameter :: capacity = 40000, rest_capacity = 20000
   !> Largest difference of impact phases (rad) from period to period, and the largest distance
   !! (rad, or over the scale) of Newton's solution from the simulation.
   real(wp), parameter :: about = 0.05_wp, near = 0.1_wp
   !> Most examinations after the first one, the factor by which the simulation before each is
   !! longer, and load cycles of each of ten batches for a Lyapunov exponent before the first of
   !! them.
   integer, parameter :: most_looks = 3, longer = 3, batch = 20

contains

   !> Simulates a state, and confirms the motion on which it settles.
   !!
   !! A simulation that is then neither on a confirmed motion nor certainly chaotic goes on, each
   !! time `longer` times as long as before.
   subroutine settle_on(system, start, settling, max_events, scale, outcome, found, n_found, &
      progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> t, x, x', z, z'
      real(wp), intent(in) :: start(5)
      !> Load cycles of the transient, and largest number of events of the simulation.
      integer, intent(in) :: settling, max_events
      !> Unit of positions, as `length_scale`.
      real(wp), intent(in) :: scale
      !> One of the outcomes above; 0 if the study was stopped.
      integer, intent(out) :: outcome
      !> The admissible motions that Newton's method found, the longest period first.
      type(found_type), intent(out) :: found(:)
      !> Number of motions in `found`.
      integer, intent(out) :: n_found
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(state_type) :: state
      type(simulated_pair_type) :: motion
      type(event_type), allocatable :: events(:)
      integer :: left, look, n, status
      logical :: chaos

      allocate (events(capacity))
      n_found = 0
      state = initial_state(system, start)
      left = max_events
      do look = 0, most_looks
         if (look > 0) then
            motion = new_simulated_pair(system, state, left)
            call is_chaotic(motion, batch*longer**(look - 1), chaos, status, progress)
            if (status == stat%event_limit) outcome = unfinished
            if (status == stat%not_computed) outcome = 0
            if (chaos .or. any(status == [stat%event_limit, stat%not_computed])) return
         end if
         call simulate_cycles(system, state, max(settling, look)*longer**look, left, &
            events(:1000), n, status, progress)
         if (status == stat%ok) call simulate_cycles(system, state, 2*longest + 2, left, events, &
            n, status, progress)
         if (status /= stat%ok) then
            outcome = merge(0, unfinished, status == stat%not_computed)
            return
         end if
         ! a free mass that moves slowly hits a wall later
         outcome = merge(no_impacts, wandering, is_free(system, state))
         if (n > 0) call examine(system, events(:n), scale, outcome, found, n_found)
         if (any(outcome == [settled, no_impacts])) return
      end do
   end subroutine settle_on

   !> Confirms the motion at the end of a simulation.
   pure subroutine examine(system, events, scale, outcome, found, n_found)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> (n) The last events, at least one.
      type(event_type), intent(in) :: events(:)
      !> As in `settle_on`.
      real(wp), intent(in) :: scale
      !> As in `settle_on`.
      integer, intent(out) :: outcome
      !> In and out: motions are added while there is room.
      type(found_type), intent(inout) :: found(:)
      !> In and out: their number.
      integer, intent(inout) :: n_found
      type(period_type), allocatable :: periods(:)
      type(found_type) :: motion
      integer :: i
      logical :: nearby

      outcome = wandering
      call read_periods(events, longest, most_symbols, about, periods)
      do i = size(periods), 1, -1
         call confirm(system, events, periods(i), [1.0_wp, 1.0_wp], scale, motion, nearby)
         if (i > 1 .and. motion%status == stat%ok) then
            if (is_repeated(motion, scale)) cycle
         end if
         if (motion%status == stat%ok .and. motion%admissible == yes .and. &
            n_found < size(found)) then
            n_found = n_found + 1
            found(n_found) = motion
         end if
         if (nearby .and. motion%stable == yes .and. motion%admissible == yes) outcome = settled
         if (nearby .and. outcome /= settled) outcome = not_stable
         if (outcome == wandering) outcome = unconfirmed
      end do
   end subroutine examine

   !> The shortest period at the end of a trajectory, and its exact motion, from and to arrays.
   pure subroutine end_arrays(system, of_simulation, values, labels, most_cycles, tolerance, &
      solve, cycles, n, symbols, first, apart, described)
      !> The forced system of the motion.
      type(forced_system_type), intent(in) :: system
      !> Of the simulation: frequency ratio, load, clearance, and the time (1/omega) from which all
      !! its events are given.
      real(wp), intent(in) :: of_simulation(4)
      !> (7, m), (2, m) Its events as in `store_events`.
      real(wp), intent(in) :: values(:, :)
      !> As in `values`.
      integer, intent(in) :: labels(:, :)
      !> Longest period (load cycles), and largest difference of its phases from the previous period
      !! (rad).
      integer, intent(in) :: most_cycles
      !> As in `most_cycles`.
      real(wp), intent(in) :: tolerance
      !> What else is wanted: nothing (0), the exact motion at the end of the trajectory (1), or
      !! that motion if its shortest period is `most_cycles` and it is stable, admissible and
      !! near (2).
      integer, intent(in) :: solve
      !> Load cycles of the period, 0 if there is none; its n symbols, the number of the first event
      !! of each (m), and the difference from the previous period (rad).
      integer, intent(out) :: cycles, n, symbols(:), first(:)
      !> As in `cycles`.
      real(wp), intent(out) :: apart
      !> The motion, or its status.
      type(described_type), intent(out) :: described
      type(event_type) :: events(size(labels, 2))
      type(period_type), allocatable :: periods(:)

      cycles = 0
      n = 0
      apart = huge(1.0_wp)
      described%motion%status = stat%no_motion
      associate (r => of_simulation(1), load => of_simulation(2), clearance => of_simulation(3), &
         begin => of_simulation(4))
         call read_events(values, labels, r, events)
         call read_periods(events, most_cycles, size(events), tolerance, periods, r*begin)
         if (size(periods) == 0) return
         cycles = periods(1)%cycles
         n = periods(1)%reading%n
         symbols(:n) = periods(1)%reading%symbols(:n)
         first(:n) = periods(1)%reading%first(:n)
         apart = periods(1)%mismatch
         if (solve == 1) call motion_at_end(system, events, periods, [system%clearance/clearance, &
            system%load/max(load, tiny(load))], described)
         if (solve == 2) call attractor_at_end(system, events, periods, most_cycles, described)
      end associate
   end subroutine end_arrays

   !> The exact motion at the end of a simulation, over its shortest period.
   !!
   !! The periods at its end are tried, the one that repeats itself best first, until a motion is
   !! near the simulation and does not repeat itself within that period. A simulation that settles
   !! slowly, as near a flip, may repeat itself only after several periods of the motion: then its
   !! shortest period is taken. The system may differ from the one simulated: if no motion is near,
   !! the first motion found is taken.
   pure subroutine motion_at_end(system, events, periods, factor, described)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> (n) In the order of time.
      type(event_type), intent(in) :: events(:)
      !> At least one, as from `read_periods`.
      type(period_type), intent(in) :: periods(:)
      !> Clearance and load over those of the simulation.
      real(wp), intent(in) :: factor(2)
      !> The motion, or its status.
      type(described_type), intent(out) :: described
      type(found_type) :: motion, chosen
      real(wp) :: scale
      logical :: nearby
      integer :: i

      scale = scale_of(system)
      do i = size(periods), 1, -1
         call confirm(system, events, periods(i), factor, scale, motion, nearby)
         if (motion%status /= stat%ok) cycle
         if (is_repeated(motion, scale)) then
            if (i > 1) cycle
            motion = once(motion, scale)
         end if
         if (nearby .or. chosen%status /= stat%ok) chosen = motion
         if (nearby) exit
      end do
      if (chosen%status /= stat%ok) then
         described%motion%status = motion%status
         ! a motion whose period does not close to rounding is still described, as not consistent
         if (allocated(motion%releases)) chosen = motion
      end if
      if (allocated(chosen%releases)) call describe_chosen(system, chosen, described)
   end subroutine motion_at_end

   !> The exact motion at the end of a simulation, if it is an attractor of a known period.
   pure subroutine attractor_at_end(system, events, periods, cycles, described)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> (n) In the order of time.
      type(event_type), intent(in) :: events(:)
      !> As from `read_periods`.
      type(period_type), intent(in) :: periods(:)
      !> Load cycles of its period.
      integer, intent(in) :: cycles
      !> The motion, or the status `stat%no_motion`.
      type(described_type), intent(out) :: described
      type(found_type) :: motion
      real(wp) :: scale
      logical :: nearby
      integer :: i

      described%motion%status = stat%no_motion
      scale = scale_of(system)
      do i = 1, size(periods)
         if (modulo(periods(i)%cycles, cycles) /= 0) cycle
         call confirm(system, events, periods(i), [1.0_wp, 1.0_wp], scale, motion, nearby)
         if (.not. nearby .or. motion%stable /= yes .or. motion%admissible /= yes) cycle
         motion = once(motion, scale)
         if (motion%pattern%cycles /= cycles) cycle
         call describe_chosen(system, motion, described)
         return
      end do
   end subroutine attractor_at_end

   !> A motion with its full description, from the release of the simulation on.
   pure subroutine describe_chosen(system, motion, described)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The motion.
      type(found_type), intent(in) :: motion
      !> The same, or its status.
      type(described_type), intent(out) :: described
      type(found_type) :: turned

      turned = motion
      ! the release of the simulation is the last one
      turned%releases = cshift(motion%releases, -1, dim=2)
      call describe_motion(system, turned, described)
   end subroutine describe_chosen

   !> Whether a motion repeats itself within its period.
   pure logical function is_repeated(motion, scale)
      !> The motion.
      type(found_type), intent(in) :: motion
      !> Unit of positions, as `length_scale`.
      real(wp), intent(in) :: scale
      type(found_type) :: standard

      standard = in_standard_form(motion, scale)
      is_repeated = standard%pattern%cycles < motion%pattern%cycles
   end function is_repeated

   !> A motion that repeats itself within its period, over its shortest period, which begins with
   !! the
   !! same impact.
   pure function once(motion, scale)
      !> The motion.
      type(found_type), intent(in) :: motion
      !> Unit of positions, as `length_scale`.
      real(wp), intent(in) :: scale
      type(found_type) :: once, standard
      integer :: m, n

      once = motion
      standard = in_standard_form(motion, scale)
      once%pattern%cycles = standard%pattern%cycles
      m = size(standard%pattern%sides)
      n = size(motion%pattern%sides)
      once%pattern%sides = motion%pattern%sides(:m)
      once%unknowns = [motion%unknowns(:m), motion%unknowns(n + 1:n + m)]
      ! the release that was solved for is the last one
      n = size(motion%releases, 2)
      m = n*once%pattern%cycles/motion%pattern%cycles
      once%releases = motion%releases(:, n - m + 1:)
   end function once

   !> Newton's method from a period of a simulation.
   pure subroutine confirm(system, events, period, factor, scale, motion, nearby)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> (n) In the order of time.
      type(event_type), intent(in) :: events(:)
      !> One of the periods at their end.
      type(period_type), intent(in) :: period
      !> Clearance and load over those of the simulation.
      real(wp), intent(in) :: factor(2)
      !> Unit of positions, as `length_scale`.
      real(wp), intent(in) :: scale
      !> The motion that Newton's method finds, or its status.
      type(found_type), intent(out) :: motion
      !> Whether the motion is near the simulation.
      logical, intent(out) :: nearby
      real(wp), dimension(period%reading%n) :: x, theta
      integer :: n

      nearby = .false.
      n = period%reading%n
      if (any(abs(period%reading%symbols(:n)) == 2)) then
         associate (release => events(period%last), v => factor(2)*events(period%last)%x_dot_after)
            if (release%kind /= release_event) return
            call new_resting(system, release%side, period%cycles, [release%phase, v], &
               rest_capacity, motion)
            nearby = motion%status == stat%ok
            if (.not. nearby) return
            associate (at => motion%releases(:, size(motion%releases, 2)))
               nearby = abs(modulo(at(2) - release%phase + 0.5_wp*two_pi, two_pi) - 0.5_wp*two_pi) &
                  < near .and. abs(at(3) - v) < near*scale
            end associate
         end associate
         return
      end if
      x = factor(1)*events(period%reading%first(:n))%x
      theta = total_phase(events(period%reading%first(:n))) - system%lag
      theta = theta - two_pi*floor(theta(1)/two_pi)
      call new_found(system, pattern_type(period%reading%symbols(:n), period%cycles), x, theta, &
         motion)
      nearby = motion%status == stat%ok
      if (nearby) nearby = all(abs(motion%unknowns(:n) - x) < near*scale) .and. &
         all(abs(motion%unknowns(n + 1:) - theta) < near)
   end subroutine confirm

end module vi_settled_motion
