!> Event-by-event simulation in closed form: no impact is missed, and accumulations are completed.
module vi_simulate
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_contact, only: contact_type, first_contact
   use vi_forced_system, only: departure_from, forced_system_type, event_type, flight_from, &
      impact_event, &
      new_forced_system, release_event, rest_from, state_time, state_type, stays_together, &
      stick_event
   use vi_bounce, only: bounce
   use vi_kinds, only: two_pi, wp
   use vi_march, only: fly, march, touch_type
   use vi_march_wide, only: fly_wide => fly
   use vi_oscillation, only: derivatives
   use vi_oscillator, only: left, oscillator_type, right
   use vi_progress, only: is_stopped
   use vi_rest, only: release_time
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: fly_on, free_mass_later, simulate, simulate_cycles, simulate_on, state_after, &
      state_later
   public :: forced_system_type, event_type, new_forced_system, state_time, state_type
   public :: impact_event, stick_event, release_event

contains

   !> Simulates from a state to a final time, or until the array of events is full.
   !!
   !! If the array is full, a further call continues, with results identical to those of one long
   !! call.
   pure subroutine simulate(system, state, last_cycle, last_phase, events, n, final, status, &
      looks_on)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: the initial state. Out: the state at which the last flight or rest began; a call that
      !! starts from there continues with identical results.
      type(state_type), intent(inout) :: state
      !> Whole load cycles at the end.
      integer(int64), intent(in) :: last_cycle
      !> Load phase beyond them at the end (rad).
      real(wp), intent(in) :: last_phase
      !> Out: events 1 to n, in the order of time; the other elements keep their values.
      type(event_type), intent(inout) :: events(:)
      !> Number of events found.
      integer, intent(out) :: n
      !> The state at the end; with `stat%more_events`, that after the last event.
      type(state_type), intent(out) :: final
      !> `stat%ok`, `stat%more_events` or `stat%budget`.
      integer, intent(out) :: status
      !> Whether to look for one more event when the array is full, so that `stat%more_events` means
      !! that there is one (the default); otherwise a further call may find none.
      logical, intent(in), optional :: looks_on
      type(state_type) :: next
      type(event_type) :: extra
      real(wp) :: remaining
      logical :: found, looks

      looks = .true.
      if (present(looks_on)) looks = looks_on
      n = 0
      status = stat%ok
      do
         if (system%wide) then
            call fly_wide(system, state, last_cycle, last_phase, events, n)
         else
            call fly(system, state, last_cycle, last_phase, events, n)
         end if
         remaining = time_left(system, state, last_cycle, last_phase)
         if (n < size(events)) then
            call go_on(system, state, remaining, events(n + 1), found, status)
         else
            next = state
            found = .false.
            if (looks) call go_on(system, next, remaining, extra, found, status)
            if (found .or. .not. looks) status = stat%more_events
         end if
         if (.not. found .or. status /= stat%ok) exit
         n = n + 1
      end do
      final = state
      if (status /= stat%ok) return
      call move_on(system, remaining, final)
      final%cycle = last_cycle
      final%phase = last_phase
   end subroutine simulate

   !> Simulates like `simulate`, unless the limit of events is reached or the study is stopped.
   !!
   !! All long simulations use this procedure, so that each of them has a limit of events, and
   !! notices a stop whenever the room for events or a span of time is used up. A flight or rest
   !! that does not end within a span is searched again from its start, so the span is then doubled.
   subroutine simulate_on(system, state, last_cycle, last_phase, events, n, final, left, status, &
      progress, looks_on)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> As in `simulate`.
      type(state_type), intent(inout) :: state
      !> Whole load cycles at the end.
      integer(int64), intent(in) :: last_cycle
      !> Load phase beyond them at the end (rad).
      real(wp), intent(in) :: last_phase
      !> Out: events 1 to n, as in `simulate`.
      type(event_type), intent(inout) :: events(:)
      !> Number of events found.
      integer, intent(out) :: n
      !> As in `simulate`.
      type(state_type), intent(out) :: final
      !> In: number of events that the simulation may still have, at least 0. Out: minus those
      !! found.
      integer, intent(inout) :: left
      !> As in `simulate`; instead of `stat%more_events`, `stat%event_limit` if no more events may
      !! occur, and `stat%not_computed` if the study was stopped.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> As in `simulate`.
      logical, intent(in), optional :: looks_on
      real(wp), parameter :: shortest_span = 1.0e6_wp       ! 1/omega; takes about 0.1 s
      integer(int64) :: cycle
      real(wp) :: span, phase
      integer :: found, capacity
      logical :: ends, looks

      n = 0
      span = shortest_span
      do
         phase = state%phase + system%r*span
         cycle = state%cycle + int(phase/two_pi, int64)
         phase = modulo(phase, two_pi)
         ends = cycle > last_cycle .or. (cycle == last_cycle .and. phase >= last_phase)
         if (ends) then
            cycle = last_cycle
            phase = last_phase
         end if
         capacity = min(size(events) - n, left)
         looks = .true.
         if (present(looks_on)) looks = looks_on .or. capacity == left
         call simulate(system, state, cycle, phase, events(n + 1:n + capacity), found, final, &
            status, looks)
         n = n + found
         left = left - found
         if ((ends .and. status == stat%ok) .or. .not. &
            any(status == [stat%ok, stat%more_events])) return
         if (status == stat%more_events .and. left == 0) status = stat%event_limit
         if (is_stopped(progress)) status = stat%not_computed
         if (status /= stat%ok) return
         span = merge(shortest_span, 2*span, found > 0)
      end do
   end subroutine simulate_on

   !> Simulates some load cycles with any number of events; only the last events are kept.
   subroutine simulate_cycles(system, state, cycles, left, events, n, status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: the initial state. Out: the state at the end.
      type(state_type), intent(inout) :: state
      !> Whole load cycles to simulate.
      integer, intent(in) :: cycles
      !> As in `simulate_on`.
      integer, intent(inout) :: left
      !> Scratch and out: elements 1 to n are the last events.
      type(event_type), intent(inout) :: events(:)
      !> Number of events kept.
      integer, intent(out) :: n
      !> `stat%ok`, `stat%event_limit`, `stat%not_computed` or `stat%budget`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(state_type) :: final
      integer(int64) :: last_cycle
      real(wp) :: last_phase

      last_cycle = state%cycle + cycles
      last_phase = state%phase
      do
         call simulate_on(system, state, last_cycle, last_phase, events, n, final, left, status, &
            progress)
         if (status /= stat%more_events) exit
      end do
      state = final
   end subroutine simulate_cycles

   !> The state just after an event, as `simulate` has it there, but for the departure speed.
   pure function state_after(system, event) result(state)
      !> The forced system, and the event.
      type(forced_system_type), intent(in) :: system
      type(event_type), intent(in) :: event
      type(state_type) :: state

      state = state_type(event%cycle, event%phase, event%x, event%x_dot_after, event%x &
         + event%side*(0.5_wp*system%clearance), event%z_dot_after, event%side, 0.0_wp, &
         event%kind == stick_event, event%kind == release_event)
   end function state_after

   !> The state at a time before which there is no further event.
   pure function state_later(system, state, cycle, phase) result(later)
      !> The forced system, and the state after the last event.
      type(forced_system_type), intent(in) :: system
      type(state_type), intent(in) :: state
      !> Whole load cycles at that time, and the load phase beyond them (rad).
      integer(int64), intent(in) :: cycle
      real(wp), intent(in) :: phase
      type(state_type) :: later

      later = state
      call move_on(system, time_left(system, state, cycle, phase), later)
      later%cycle = cycle
      later%phase = phase
   end function state_later

   !> z of `state_later`, with the same bits, for a state that does not rest.
   pure real(wp) function free_mass_later(system, state, cycle, phase) result(z)
      !> The forced system, and the state after the last event.
      type(forced_system_type), intent(in) :: system
      type(state_type), intent(in) :: state
      !> Whole load cycles at that time, and the load phase beyond them (rad).
      integer(int64), intent(in) :: cycle
      real(wp), intent(in) :: phase

      z = state%z + state%z_dot*time_left(system, state, cycle, phase)
   end function free_mass_later

   !> Time from a state to the end.
   pure real(wp) function time_left(system, state, last_cycle, last_phase)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state.
      type(state_type), intent(in) :: state
      !> Load cycles at the end.
      integer(int64), intent(in) :: last_cycle
      !> Load phase beyond them (rad).
      real(wp), intent(in) :: last_phase

      time_left = (two_pi*real(last_cycle - state%cycle, wp) + (last_phase - state%phase))/system%r
   end function time_left

   !> Advances to the next event and through it. If there is none, the state is not changed.
   pure subroutine go_on(system, state, remaining, event, found, status)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: the state. Out: just after the event, if one is found.
      type(state_type), intent(inout) :: state
      !> Time to the end (1/omega).
      real(wp), intent(in) :: remaining
      !> Out: the event, if one is found.
      type(event_type), intent(inout) :: event
      !> Whether there is an event before the end.
      logical, intent(out) :: found
      !> Set to `stat%budget` if the search ran out of steps; otherwise not changed.
      integer, intent(inout) :: status
      real(wp) :: s, c
      logical :: over

      if (state%resting) then
         call rest_on(system, state, remaining, event, found, status)
         return
      end if
      s = sin(state%phase)
      c = cos(state%phase)
      found = .false.
      over = .false.
      if (state%side /= 0 .and. .not. state%released) then
         call accumulate(system, state, s, c, remaining, event, found, over)
      end if
      if (.not. (found .or. over)) call fly_on(system, state, s, c, remaining, event, found, status)
   end subroutine go_on

   !> Advances to the next impact and through it, with vi_bounce or vi_march where they can decide.
   pure subroutine fly_on(system, state, s, c, remaining, event, found, status)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: the state. Out: just after the impact, if one is found.
      type(state_type), intent(inout) :: state
      !> Sine and cosine of the load phase.
      real(wp), intent(in) :: s, c
      !> Time to the end (1/omega).
      real(wp), intent(in) :: remaining
      !> Out: the impact, if one is found.
      type(event_type), intent(inout) :: event
      !> Whether there is an impact before the end.
      logical, intent(out) :: found
      !> Set to `stat%budget` if the search ran out of steps; otherwise not changed.
      integer, intent(inout) :: status
      type(touch_type) :: touch
      real(wp) :: half, time, approach

      found = .false.
      half = 0.5_wp*system%clearance
      if (state%side /= 0 .and. state%speed > 0) then
         call bounce(system%transition, system%load, s, c, state%x, state%x_dot, state%side, &
            state%speed, system%clearance, time, approach)
         if (time > 0) then
            touch = touch_type(state%side, time, state%x + state%z_dot*time, &
               state%z_dot - state%side*approach)
         else
            call march(system%transition, s, c, state%x, state%x_dot, state%z, state%z_dot, half, &
               state%side, state%speed, remaining, touch)
            approach = max(0.0_wp, touch%side*(state%z_dot - touch%x_dot))
         end if
         if (touch%time > remaining) return
      end if
      if (touch%side == 0) call search(system, state, half, remaining, touch, approach, status)
      if (touch%side == 0) return
      found = .true.
      state%released = .false.
      call move(state, system%r*touch%time)
      state%x = touch%x
      state%side = touch%side
      state%z = touch%x + touch%side*half
      call collide(system%osc, touch%side, approach, touch%x_dot, state, event)
   end subroutine fly_on

   !> The reference search for the next contact, from the time at which the march ended.
   pure subroutine search(system, state, half, remaining, touch, approach, status)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state at the start of the flight.
      type(state_type), intent(in) :: state
      !> Half the clearance, and the time to the end (1/omega).
      real(wp), intent(in) :: half, remaining
      !> In: the time before which there is no contact. Out: the contact; side 0 if there is none.
      type(touch_type), intent(inout) :: touch
      !> Approach speed at the contact.
      real(wp), intent(out) :: approach
      !> Set to `stat%budget` if the search ran out of steps; otherwise not changed.
      integer, intent(inout) :: status
      type(contact_type) :: contact

      contact = first_contact(flight_from(system, state, remaining), half, &
         departure_from(state, half), remaining, touch%time)
      if (.not. contact%complete) status = stat%budget
      touch = touch_type(contact%side, contact%time, contact%d(0), contact%d(1))
      approach = contact%speed
   end subroutine search

   !> Velocities through an impact, from the momentum and the reversed approach speed: (11), (12).
   !!
   !! The departure speed R v is kept as a separate number: as the difference of two velocities it
   !! would lose its relative accuracy when impacts accumulate.
   pure subroutine collide(osc, side, approach, x_dot, state, event)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      !> Wall of the impact: +1 right, -1 left.
      integer, intent(in) :: side
      !> Approach speed, and velocity of the primary mass just before the impact.
      real(wp), intent(in) :: approach, x_dot
      !> In: time and positions of the impact. Out: also the velocities just after it.
      type(state_type), intent(inout) :: state
      !> Out: the impact.
      type(event_type), intent(inout) :: event

      event%kind = impact_event
      event%side = side
      event%cycle = state%cycle
      event%phase = state%phase
      event%x = state%x
      event%x_dot_before = x_dot
      event%z_dot_before = x_dot + side*approach
      state%speed = osc%restitution(merge(right, left, side > 0))*approach
      state%x_dot = x_dot + osc%mu/(1 + osc%mu)*(side*((approach + state%speed)))
      state%z_dot = state%x_dot - side*state%speed
      event%x_dot_after = state%x_dot
      event%z_dot_after = state%z_dot
   end subroutine collide

   !> Completes an accumulation of impacts, if what remains of it is short enough.
   !!
   !! With departure speed u and a gap that closes with acceleration a > 0, the remaining impacts
   !! take T = 2u/(a (1 - R)), to first order. Meanwhile the centre of mass moves smoothly. The
   !! relative size of the next order is |j| T/a, where j is the rate of change of a, so the error
   !! of the time is at most |j| T^2/a: that has to be below 1e-16. Without a departure speed the
   !! masses stay together at once, or part.
   pure subroutine accumulate(system, state, s, c, remaining, event, found, over)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: just after an impact. Out: resting on the wall, if the accumulation is completed.
      type(state_type), intent(inout) :: state
      !> Sine and cosine of the load phase.
      real(wp), intent(in) :: s, c
      !> Time to the end (1/omega).
      real(wp), intent(in) :: remaining
      !> Out: the start of the rest, if the accumulation is completed.
      type(event_type), intent(inout) :: event
      !> In: false. Out: whether it is completed; whether it would be completed only after the end,
      !! and until then the gap stays below 1e-12 x''.
      logical, intent(inout) :: found, over
      real(wp), parameter :: longest = 1.0e-6_wp, time_error = 1.0e-16_wp
      real(wp) :: x_ddot, closing, jerk, lost, duration, velocity

      associate (osc => system%osc)
         x_ddot = system%load*s - 2*osc%xi*state%x_dot - state%x
         closing = -state%side*x_ddot
         duration = 0
         if (.not. state%speed > 0) then
            if (.not. stays_together(system, state)) return
         else
            if (.not. closing > 0) return
            lost = closing*(1 - osc%restitution(merge(right, left, state%side > 0)))
            if (.not. 2*state%speed <= longest*lost) return
            duration = 2*state%speed/lost
            jerk = abs(system%load*system%r*c) + 2*osc%xi*abs(x_ddot) + abs(state%x_dot)
            if (jerk*duration**2 > time_error*closing) return
            over = duration > remaining
            if (over) return
         end if
         velocity = (state%x_dot + osc%mu*state%z_dot)/(1 + osc%mu)
         state%x = state%x + (velocity + 0.5_wp*x_ddot/(1 + osc%mu)*duration)*duration
         state%x_dot = velocity + x_ddot/(1 + osc%mu)*duration
         state%z_dot = state%x_dot
         state%z = state%x + 0.5_wp*state%side*system%clearance
         state%speed = 0
         state%resting = .true.
         call move(state, system%r*duration)
         event = event_type(stick_event, state%side, state%cycle, state%phase, state%x, &
            state%x_dot, state%x_dot, state%z_dot, state%z_dot)
         found = .true.
      end associate
   end subroutine accumulate

   !> Advances through a rest on a wall to the release.
   pure subroutine rest_on(system, state, remaining, event, found, status)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: resting. Out: just released, if that happens before the end.
      type(state_type), intent(inout) :: state
      !> Time to the end (1/omega).
      real(wp), intent(in) :: remaining
      !> Out: the release, if it happens before the end.
      type(event_type), intent(inout) :: event
      !> Whether the release happens before the end.
      logical, intent(out) :: found
      !> Set to `stat%budget` if the search ran out of steps; otherwise not changed.
      integer, intent(inout) :: status
      real(wp) :: time
      logical :: complete

      call release_time(rest_from(system, state), state%side, remaining, time, complete)
      if (.not. complete) status = stat%budget
      found = complete .and. time <= remaining
      if (.not. found) return
      call move_on(system, time, state)
      call move(state, system%r*time)
      state%resting = .false.
      state%released = .true.
      event = event_type(release_event, state%side, state%cycle, state%phase, state%x, &
         state%x_dot, state%x_dot, state%z_dot, state%z_dot)
   end subroutine rest_on

   !> Advances both masses over a time without events; the load phase is not changed.
   pure subroutine move_on(system, time, state)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Time to advance (1/omega).
      real(wp), intent(in) :: time
      !> In: at the start. Out: positions and velocities after that time.
      type(state_type), intent(inout) :: state
      real(wp) :: d(0:5)

      if (state%resting) then
         d = derivatives(rest_from(system, state), time)
         state%z = d(0) + 0.5_wp*state%side*system%clearance
         state%z_dot = d(1)
      else
         d = derivatives(flight_from(system, state, time), time)
         state%z = state%z + state%z_dot*time
         state%side = 0
         state%speed = 0
         state%released = .false.
      end if
      state%x = d(0)
      state%x_dot = d(1)
   end subroutine move_on

   !> Advances the load phase.
   pure subroutine move(state, phase_step)
      !> In and out: only cycle and phase change.
      type(state_type), intent(inout) :: state
      !> Phase to add (rad), >= 0.
      real(wp), intent(in) :: phase_step
      integer(int64) :: cycles

      state%phase = state%phase + phase_step
      if (state%phase < two_pi) return
      cycles = 1
      if (state%phase >= 2*two_pi) cycles = int(state%phase/two_pi, int64)
      state%cycle = state%cycle + cycles
      state%phase = state%phase - two_pi*real(cycles, wp)
   end subroutine move

end module vi_simulate
