!> Event by event simulation in closed form: no impact is missed, accumulations are completed.
module vi_simulate
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_contact, only: contact_type, first_contact
   use vi_drive, only: departure_from, drive_type, event_type, flight_from, impact_event, &
      new_drive, release_event, rest_from, state_time, state_type, stick_event, two_pi
   use vi_hop, only: hop
   use vi_kinds, only: wp
   use vi_march, only: march, touch_type
   use vi_oscillation, only: derivatives
   use vi_oscillator, only: left, oscillator_type, right
   use vi_rest, only: release_time
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: simulate, simulate_cycles
   public :: drive_type, event_type, new_drive, state_time, state_type
   public :: impact_event, stick_event, release_event

contains

   !> Goes on from a state to an end of time, or until there are more events than room for them.
   !!
   !! Ending because the events are full loses nothing: calling again goes on bit for bit.
   pure subroutine simulate(drive, state, last_cycle, last_phase, events, n, final, status)
      type(drive_type), intent(in) :: drive
      !> Out: where the last flight or rest began; going on from there is going on bit for bit.
      type(state_type), intent(inout) :: state
      !> The end: load cycles and the phase above them.
      integer(int64), intent(in) :: last_cycle
      real(wp), intent(in) :: last_phase
      type(event_type), intent(inout) :: events(:)
      !> Events found.
      integer, intent(out) :: n
      !> The state at the end (if there are more events: that after the last one).
      type(state_type), intent(out) :: final
      !> `stat%ok`, `stat%more_events` or `stat%budget`.
      integer, intent(out) :: status
      type(state_type) :: next
      type(event_type) :: extra
      real(wp) :: remaining
      logical :: found

      n = 0
      status = stat%ok
      do
         remaining = time_left(drive, state, last_cycle, last_phase)
         if (n < size(events)) then
            call go_on(drive, state, remaining, events(n + 1), found, status)
         else
            next = state
            call go_on(drive, next, remaining, extra, found, status)
            if (found) status = stat%more_events
         end if
         if (.not. found .or. status /= stat%ok) exit
         n = n + 1
      end do
      final = state
      if (status /= stat%ok) return
      call move_on(drive, remaining, final)
      final%cycle = last_cycle
      final%phase = last_phase
   end subroutine simulate

   !> Goes on for some load cycles, whatever the number of events, of which the last ones are kept.
   pure subroutine simulate_cycles(drive, state, cycles, left, events, n, status)
      type(drive_type), intent(in) :: drive
      !> Out: the end.
      type(state_type), intent(inout) :: state
      integer, intent(in) :: cycles
      !> How many events there may be; out: fewer by those there were.
      integer, intent(inout) :: left
      type(event_type), intent(inout) :: events(:)
      !> Events kept.
      integer, intent(out) :: n
      !> `stat%ok`, `stat%more_events` if there are too many, or `stat%budget`.
      integer, intent(out) :: status
      type(state_type) :: final
      integer(int64) :: last_cycle
      real(wp) :: last_phase

      last_cycle = state%cycle + cycles
      last_phase = state%phase
      do
         call simulate(drive, state, last_cycle, last_phase, events, n, final, status)
         left = left - n
         if (status /= stat%more_events .or. left <= 0) exit
      end do
      state = final
   end subroutine simulate_cycles

   !> Time from a state to the end.
   pure real(wp) function time_left(drive, state, last_cycle, last_phase)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(in) :: state
      integer(int64), intent(in) :: last_cycle
      real(wp), intent(in) :: last_phase

      time_left = (two_pi*real(last_cycle - state%cycle, wp) + (last_phase - state%phase))/drive%r
   end function time_left

   !> Goes on to the next event and through it. If none is found, the state is left as it is.
   pure subroutine go_on(drive, state, remaining, event, found, status)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(inout) :: state
      real(wp), intent(in) :: remaining
      type(event_type), intent(inout) :: event
      logical, intent(out) :: found
      integer, intent(inout) :: status
      real(wp) :: s, c
      logical :: over

      if (state%resting) then
         call rest_on(drive, state, remaining, event, found, status)
         return
      end if
      s = sin(state%phase)
      c = cos(state%phase)
      found = .false.
      over = .false.
      if (state%side /= 0 .and. .not. state%released) then
         call accumulate(drive, state, s, c, remaining, event, found, over)
      end if
      if (.not. (found .or. over)) call fly_on(drive, state, s, c, remaining, event, found, status)
   end subroutine go_on

   !> Flies to the next impact and through it, as far as possible by marching.
   pure subroutine fly_on(drive, state, s, c, remaining, event, found, status)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(inout) :: state
      !> Sine and cosine of the load phase.
      real(wp), intent(in) :: s, c
      real(wp), intent(in) :: remaining
      type(event_type), intent(inout) :: event
      logical, intent(out) :: found
      integer, intent(inout) :: status
      type(touch_type) :: touch
      real(wp) :: half, time, approach

      found = .false.
      half = 0.5_wp*drive%clearance
      if (state%side /= 0 .and. state%speed > 0) then
         call hop(drive%transition, drive%load, s, c, state%x, state%x_dot, state%side, &
            state%speed, drive%clearance, time, approach)
         if (time > 0) then
            touch = touch_type(state%side, time, state%x + state%z_dot*time, &
               state%z_dot - state%side*approach)
         else
            call march(drive%transition, s, c, state%x, state%x_dot, state%z, state%z_dot, half, &
               state%side, state%speed, remaining, touch)
            approach = max(0.0_wp, touch%side*(state%z_dot - touch%x_dot))
         end if
         if (touch%time > remaining) return
      end if
      if (touch%side == 0) call search(drive, state, half, remaining, touch, approach, status)
      if (touch%side == 0) return
      found = .true.
      state%released = .false.
      call move(state, drive%r*touch%time)
      state%x = touch%x
      state%side = touch%side
      state%z = touch%x + touch%side*half
      call collide(drive%osc, touch%side, approach, touch%x_dot, state, event)
   end subroutine fly_on

   !> The plain search for the next contact, from where the march has ended.
   pure subroutine search(drive, state, half, remaining, touch, approach, status)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(in) :: state
      real(wp), intent(in) :: half, remaining
      type(touch_type), intent(inout) :: touch
      real(wp), intent(out) :: approach
      integer, intent(inout) :: status
      type(contact_type) :: contact

      contact = first_contact(flight_from(drive, state, remaining), half, &
         departure_from(state, half), remaining, touch%time)
      if (.not. contact%complete) status = stat%budget
      touch = touch_type(contact%side, contact%time, contact%d(0), contact%d(1))
      approach = contact%speed
   end subroutine search

   !> Velocities through an impact, from the momentum and the reversed approach speed: (11), (12).
   !!
   !! The departure speed R v is kept as a number of its own: as the difference of two velocities it
   !! would lose its relative accuracy when impacts accumulate.
   pure subroutine collide(osc, side, approach, x_dot, state, event)
      type(oscillator_type), intent(in) :: osc
      integer, intent(in) :: side
      real(wp), intent(in) :: approach, x_dot
      type(state_type), intent(inout) :: state
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

   !> Completes an accumulation of impacts, where the rest of it is short enough.
   !!
   !! With departure speed u and a gap that closes with acceleration a > 0, the remaining impacts
   !! take T = 2u/(a (1 - R)), to first order. The centre of mass moves smoothly meanwhile. The next
   !! order is relatively |j| T/a, j being the rate of a, so the time is wrong by |j| T^2/a at most:
   !! that has to be below 1e-16.
   pure subroutine accumulate(drive, state, s, c, remaining, event, found, over)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(inout) :: state
      !> Sine and cosine of the load phase.
      real(wp), intent(in) :: s, c
      !> Time to the end.
      real(wp), intent(in) :: remaining
      type(event_type), intent(inout) :: event
      !> Completed; or it would be after the end, and until then the gap stays below 1e-12 x''.
      logical, intent(inout) :: found, over
      real(wp), parameter :: longest = 1.0e-6_wp, time_error = 1.0e-16_wp
      real(wp) :: x_ddot, closing, jerk, lost, duration, velocity

      associate (osc => drive%osc)
         x_ddot = drive%load*s - 2*osc%xi*state%x_dot - state%x
         closing = -state%side*x_ddot
         if (.not. closing > 0) return
         duration = 0
         if (state%speed > 0) then
            lost = closing*(1 - osc%restitution(merge(right, left, state%side > 0)))
            if (.not. 2*state%speed <= longest*lost) return
            duration = 2*state%speed/lost
            jerk = abs(drive%load*drive%r*c) + 2*osc%xi*abs(x_ddot) + abs(state%x_dot)
            if (jerk*duration**2 > time_error*closing) return
            over = duration > remaining
            if (over) return
         end if
         velocity = (state%x_dot + osc%mu*state%z_dot)/(1 + osc%mu)
         state%x = state%x + (velocity + 0.5_wp*x_ddot/(1 + osc%mu)*duration)*duration
         state%x_dot = velocity + x_ddot/(1 + osc%mu)*duration
         state%z_dot = state%x_dot
         state%z = state%x + 0.5_wp*state%side*drive%clearance
         state%speed = 0
         state%resting = .true.
         call move(state, drive%r*duration)
         event = event_type(stick_event, state%side, state%cycle, state%phase, state%x, &
            state%x_dot, state%x_dot, state%z_dot, state%z_dot)
         found = .true.
      end associate
   end subroutine accumulate

   !> Rests on the wall until the release.
   pure subroutine rest_on(drive, state, remaining, event, found, status)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(inout) :: state
      real(wp), intent(in) :: remaining
      type(event_type), intent(inout) :: event
      logical, intent(out) :: found
      integer, intent(inout) :: status
      real(wp) :: time
      logical :: complete

      call release_time(rest_from(drive, state), state%side, remaining, time, complete)
      if (.not. complete) status = stat%budget
      found = complete .and. time <= remaining
      if (.not. found) return
      call move_on(drive, time, state)
      call move(state, drive%r*time)
      state%resting = .false.
      state%released = .true.
      event = event_type(release_event, state%side, state%cycle, state%phase, state%x, &
         state%x_dot, state%x_dot, state%z_dot, state%z_dot)
   end subroutine rest_on

   !> Moves both masses on for a time in which nothing happens.
   pure subroutine move_on(drive, time, state)
      type(drive_type), intent(in) :: drive
      real(wp), intent(in) :: time
      type(state_type), intent(inout) :: state
      real(wp) :: d(0:5)

      if (state%resting) then
         d = derivatives(rest_from(drive, state), time)
         state%z = d(0) + 0.5_wp*state%side*drive%clearance
         state%z_dot = d(1)
      else
         d = derivatives(flight_from(drive, state, time), time)
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
      type(state_type), intent(inout) :: state
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
