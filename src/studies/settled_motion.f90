!> The periodic motion on which a state settles, confirmed by Newton's method.
!!
!! A simulation that repeats itself for two periods is no proof: near a fold, or between bursts of
!! intermittent chaos, it does so for a long time. A state counts as settled only if Newton's
!! method, started from its last period, leads to an admissible, stable motion near that period.
module vi_settled_motion
   use vi_forced_system, only: forced_system_type, event_type, initial_state, state_type, two_pi
   use vi_event_symbols, only: last_of_period, mismatch, symbols_between, symbol_sequence_type, &
      total_phase
   use vi_found_motion, only: found_type, new_found, new_resting
   use vi_kinds, only: wp
   use vi_motion, only: yes
   use vi_pattern, only: pattern_type
   use vi_simulate, only: simulate_cycles
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: settle_on

   !> Outcomes of a state: a confirmed motion; one that is confirmed but not stable (or not
   !! admissible, or where that is unknown); a simulation that repeats itself, but Newton's method
   !! leads to no motion near it; one that does not repeat itself; no impacts occur any more; the
   !! simulation could not be completed.
   integer, parameter, public :: settled = 1, not_stable = 2, unconfirmed = 3, wandering = 4, &
      no_impacts = 5, unfinished = 6
   integer, parameter, public :: n_outcomes = 6

   !> Longest period considered, in load cycles, and its largest number of symbols.
   integer, parameter :: longest = 16, most_symbols = 100
   !> Events kept of the end of a simulation, and of a period with rest.
   integer, parameter :: capacity = 40000, rest_capacity = 20000
   !> Largest number of events of a simulation.
   integer, parameter :: most_events = 100000000
   !> Largest difference of impact phases (rad) from period to period; the factor by which it must
   !! be smaller for a longer period that is tried after a shorter one; and the largest distance
   !! (rad, or over the scale) of Newton's solution from the simulation.
   real(wp), parameter :: about = 0.05_wp, nearer = 0.3_wp, near = 0.1_wp

contains

   !> Simulates a state, and confirms the motion on which it settles.
   pure subroutine settle_on(system, start, settling, scale, outcome, found, n_found)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> t, x, x', z, z'
      real(wp), intent(in) :: start(5)
      !> Load cycles of the transient.
      integer, intent(in) :: settling
      !> Unit of positions, as `length_scale`.
      real(wp), intent(in) :: scale
      !> One of the outcomes above.
      integer, intent(out) :: outcome
      !> The admissible motions to which Newton's method led, the one settled on last.
      type(found_type), intent(out) :: found(:)
      !> Number of motions in `found`.
      integer, intent(out) :: n_found
      type(state_type) :: state
      type(event_type), allocatable :: events(:)
      type(symbol_sequence_type) :: now, before
      type(found_type) :: motion
      real(wp) :: finish, apart, least
      integer :: cycles, last, left, n, status
      logical :: nearby

      allocate (events(capacity))
      n_found = 0
      outcome = unfinished
      state = initial_state(system, start)
      left = most_events
      call simulate_cycles(system, state, settling, left, events(:1000), n, status)
      if (status /= stat%ok) return
      call simulate_cycles(system, state, 2*longest + 2, left, events, n, status)
      if (status /= stat%ok) return
      outcome = no_impacts
      if (n == 0) return
      outcome = wandering
      last = last_of_period(events(:n))
      ! a thousandth of a cycle: the event one period before belongs to the window before
      finish = total_phase(events(last)) + 1.0e-3_wp*two_pi
      least = about
      do cycles = 1, longest
         call symbols_between(events(:last), finish - two_pi*cycles, finish, now)
         call symbols_between(events(:last), finish - 2*two_pi*cycles, finish - two_pi*cycles, &
            before)
         if (now%n > most_symbols) exit
         apart = mismatch(events, now, before, cycles)
         if (.not. apart < least) cycle
         least = nearer*apart
         call confirm(system, events(:last), now, cycles, scale, motion, nearby)
         if (motion%status == stat%ok .and. motion%admissible == yes .and. &
            n_found < size(found)) then
            n_found = n_found + 1
            found(n_found) = motion
         end if
         if (.not. nearby) then
            if (outcome == wandering) outcome = unconfirmed
            cycle
         end if
         outcome = not_stable
         if (motion%stable /= yes .or. motion%admissible /= yes) cycle
         outcome = settled
         return
      end do
   end subroutine settle_on

   !> Newton's method from the last period of a simulation.
   pure subroutine confirm(system, events, reading, cycles, scale, motion, nearby)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Events up to the end of the period.
      type(event_type), intent(in) :: events(:)
      !> Symbols of the last period among these events.
      type(symbol_sequence_type), intent(in) :: reading
      !> Load cycles of the period.
      integer, intent(in) :: cycles
      !> Unit of positions, as `length_scale`.
      real(wp), intent(in) :: scale
      !> The motion to which Newton's method leads, or its status.
      type(found_type), intent(out) :: motion
      !> Whether the motion is near the simulation.
      logical, intent(out) :: nearby
      real(wp) :: x(reading%n), theta(reading%n)
      integer :: n

      n = reading%n
      if (any(abs(reading%symbols(:n)) == 2)) then
         associate (release => events(size(events)))
            call new_resting(system, release%side, cycles, [release%phase, release%x_dot_after], &
               rest_capacity, motion)
            nearby = motion%status == stat%ok
            if (.not. nearby) return
            associate (at => motion%releases(:, size(motion%releases, 2)))
               nearby = abs(modulo(at(2) - release%phase + 0.5_wp*two_pi, two_pi) - 0.5_wp*two_pi) &
                  < near .and. abs(at(3) - release%x_dot_after) < near*scale
            end associate
         end associate
         return
      end if
      x = events(reading%first(:n))%x
      theta = total_phase(events(reading%first(:n))) - system%lag
      theta = theta - two_pi*floor(theta(1)/two_pi)
      call new_found(system, pattern_type(reading%symbols(:n), cycles), x, theta, motion)
      nearby = motion%status == stat%ok
      if (nearby) nearby = all(abs(motion%unknowns(:n) - x) < near*scale) .and. &
         all(abs(motion%unknowns(n + 1:) - theta) < near)
   end subroutine confirm

end module vi_settled_motion
