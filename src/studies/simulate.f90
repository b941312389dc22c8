!> Event by event simulation in closed form: no impact is missed, accumulations are completed.
module vi_simulate
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_contact, only: contact_type, departure_type, first_contact
   use vi_flight, only: flight_position, flight_type, new_flight
   use vi_kinds, only: wp
   use vi_march, only: march, touch_type
   use vi_oscillation, only: derivatives, oscillation_type
   use vi_oscillator, only: gain, lag, left, oscillator_type, right
   use vi_rest, only: new_rest, release_time
   use vi_status, only: stat
   use vi_transition, only: moment_type, new_transition, transition_type
   implicit none (type, external)
   private

   public :: new_drive, simulate, state_time

   !> Kinds of events.
   integer, parameter, public :: impact_event = 1, stick_event = 2, release_event = 3

   real(wp), parameter :: two_pi = 2*acos(-1.0_wp)

   !> The system in motion: oscillator, frequency ratio, load amplitude f, clearance (same unit).
   type, public :: drive_type
      type(oscillator_type) :: osc
      real(wp) :: r = 1, load = 1, clearance = 1
      !> Amplitude of the motion without impacts, and its lag behind the load, equation (4).
      real(wp) :: amplitude = 0, lag = 0
      type(transition_type) :: transition
   end type drive_type

   !> Where the system is. The load phase r t is kept as whole cycles and the rest, so that its
   !! error
   !> does not grow with time.
   type, public :: state_type
      integer(int64) :: cycle = 0
      !> In [0, 2 pi).
      real(wp) :: phase = 0
      real(wp) :: x = 0, x_dot = 0, z = 0, z_dot = 0
      !> +1 or -1 while on a wall, 0 inside.
      integer :: side = 0
      !> On a wall: the departure speed, whether the free mass rests there or was just released.
      real(wp) :: speed = 0
      logical :: resting = .false., released = .false.
   end type state_type

   type, public :: event_type
      integer :: kind, side
      integer(int64) :: cycle
      real(wp) :: phase, x, x_dot_before, x_dot_after, z_dot_before, z_dot_after
   end type event_type

contains

   pure function new_drive(osc, r, load, clearance) result(drive)
      type(oscillator_type), intent(in) :: osc
      real(wp), intent(in) :: r, load, clearance
      type(drive_type) :: drive

      drive%osc = osc
      drive%r = r
      drive%load = load
      drive%clearance = clearance
      drive%amplitude = load*gain(osc%xi, r)
      drive%lag = lag(osc%xi, r)
      call new_transition(osc%xi, r, drive%amplitude*cos(drive%lag), &
         drive%amplitude*sin(drive%lag), drive%transition)
   end function new_drive

   !> Time of a state in 1/omega.
   pure real(wp) function state_time(cycle, phase, r) result(time)
      integer(int64), intent(in) :: cycle
      real(wp), intent(in) :: phase, r

      time = (two_pi*real(cycle, wp) + phase)/r
   end function state_time

   !> Goes on from a state to an end of time, or until the events are full.
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
      !> The state at the end (if the events were full first: where that was).
      type(state_type), intent(out) :: final
      !> `stat%ok`, `stat%more_events` (full before the end) or `stat%budget`.
      integer, intent(out) :: status
      real(wp) :: remaining
      logical :: finished

      n = 0
      status = stat%ok
      do
         final = state
         remaining = time_left(drive, state, last_cycle, last_phase)
         if (n + 2 > size(events)) then
            status = stat%more_events
            return
         end if
         if (state%resting) then
            call rest_on(drive, state, remaining, events(n + 1), final, finished, status)
            if (.not. finished .and. status == stat%ok) n = n + 1
         else
            call fly_on(drive, state, remaining, events(n + 1), final, finished, status)
            if (.not. finished .and. status == stat%ok) then
               n = n + 1
               call accumulate(drive, state, time_left(drive, state, last_cycle, last_phase), &
                  events(n + 1))
               if (state%resting) n = n + 1
            end if
         end if
         if (status /= stat%ok) return
         if (finished) exit
      end do
      final%cycle = last_cycle
      final%phase = last_phase
   end subroutine simulate

   !> Time from a state to the end.
   pure real(wp) function time_left(drive, state, last_cycle, last_phase)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(in) :: state
      integer(int64), intent(in) :: last_cycle
      real(wp), intent(in) :: last_phase

      time_left = (two_pi*real(last_cycle - state%cycle, wp) + (last_phase - state%phase))/drive%r
   end function time_left

   !> Flies to the next impact and through it, or to the end of time.
   pure subroutine fly_on(drive, state, remaining, event, final, finished, status)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(inout) :: state
      real(wp), intent(in) :: remaining
      type(event_type), intent(inout) :: event
      !> The state at the end of time, if that comes first.
      type(state_type), intent(inout) :: final
      logical, intent(out) :: finished
      integer, intent(inout) :: status
      type(flight_type) :: flight
      type(contact_type) :: contact
      real(wp) :: d(0:5), half

      half = 0.5_wp*drive%clearance
      call find_contact(drive, state, half, remaining, contact)
      finished = contact%side == 0
      if (.not. contact%complete) then
         status = stat%budget
         return
      end if
      if (finished) then
         flight = flight_from(drive, state, remaining)
         d = derivatives(flight, remaining)
         final%x = d(0)
         final%x_dot = d(1)
         final%z = flight_position(flight, remaining)
         final%side = 0
         final%speed = 0
         final%released = .false.
         return
      end if
      state%released = .false.
      call move(state, drive%r*contact%time)
      state%x = contact%d(0)
      state%side = contact%side
      state%z = state%x + contact%side*half
      call collide(drive%osc, contact%side, contact%speed, contact%d(1), state, event)
   end subroutine fly_on

   !> The flight that begins at a state.
   pure function flight_from(drive, state, duration) result(flight)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(in) :: state
      real(wp), intent(in) :: duration
      type(flight_type) :: flight

      flight = new_flight(drive%osc%xi, drive%r, drive%amplitude, state%phase - drive%lag, &
         state%x, state%x_dot, state%z, state%z_dot, duration)
   end function flight_from

   !> The first contact of the flight from a state: by marching as far as that goes.
   pure subroutine find_contact(drive, state, half, remaining, contact)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(in) :: state
      real(wp), intent(in) :: half, remaining
      type(contact_type), intent(out) :: contact
      type(moment_type) :: start
      type(touch_type) :: touch
      real(wp) :: s, c

      if (state%side /= 0 .and. state%speed > 0) then
         s = sin(state%phase)
         c = cos(state%phase)
         start%sine = drive%transition%in_phase*s - drive%transition%behind*c
         start%cosine = drive%transition%in_phase*c + drive%transition%behind*s
         start%free = state%x - start%sine
         start%free_dot = state%x_dot - drive%r*start%cosine
         start%z = state%z
         start%z_dot = state%z_dot
         call march(drive%transition, start, half, state%side, state%speed, remaining, touch)
         if (touch%time > remaining) return
         if (touch%side /= 0) then
            contact%side = touch%side
            contact%time = touch%time
            contact%d(0:1) = [touch%x, touch%x_dot]
            contact%speed = max(0.0_wp, touch%side*(state%z_dot - touch%x_dot))
            return
         end if
      end if
      contact = first_contact(flight_from(drive, state, remaining), half, &
         departure_type(state%side, state%speed, state%released), remaining, touch%time)
   end subroutine find_contact

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
      real(wp) :: restitution, momentum

      restitution = osc%restitution(merge(right, left, side > 0))
      event = event_type(impact_event, side, state%cycle, state%phase, state%x, x_dot, 0.0_wp, &
         x_dot + side*approach, 0.0_wp)
      state%speed = restitution*approach
      momentum = x_dot + osc%mu*event%z_dot_before
      state%x_dot = (momentum + osc%mu*side*state%speed)/(1 + osc%mu)
      state%z_dot = state%x_dot - side*state%speed
      event%x_dot_after = state%x_dot
      event%z_dot_after = state%z_dot
   end subroutine collide

   !> Completes an accumulation of impacts, where the rest of it is short enough.
   !!
   !! With departure speed u and a gap that closes with acceleration a > 0, the remaining impacts
   !! take
   !! T = 2u/(a (1 - R)), to first order. The centre of mass moves smoothly meanwhile. The next
   !! order
   !! is relatively |j| T/a, j being the rate of a, so the time is wrong by |j| T^2/a at most:
   !! that has
   !! to be below 1e-16.
   pure subroutine accumulate(drive, state, remaining, event)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(inout) :: state
      !> Time to the end; an accumulation that would go on beyond it is not completed.
      real(wp), intent(in) :: remaining
      type(event_type), intent(inout) :: event
      real(wp), parameter :: time_error = 1.0e-16_wp
      real(wp) :: x_ddot, closing, jerk, restitution, duration, velocity

      associate (osc => drive%osc)
         x_ddot = drive%load*sin(state%phase) - 2*osc%xi*state%x_dot - state%x
         closing = -state%side*x_ddot
         if (.not. closing > 0) return
         restitution = osc%restitution(merge(right, left, state%side > 0))
         duration = 0
         if (state%speed > 0) then
            if (.not. restitution < 1) return
            duration = 2*state%speed/(closing*(1 - restitution))
            jerk = abs(drive%load*drive%r*cos(state%phase)) + 2*osc%xi*abs(x_ddot) &
               + abs(state%x_dot)
            if (duration > min(1.0e-6_wp, remaining)) return
            if (jerk*duration**2 > time_error*closing) return
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
            state%x_dot, &
            state%x_dot, state%z_dot, state%z_dot)
      end associate
   end subroutine accumulate

   !> Rests on the wall until the release, or the end of time.
   pure subroutine rest_on(drive, state, remaining, event, final, finished, status)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(inout) :: state
      real(wp), intent(in) :: remaining
      type(event_type), intent(inout) :: event
      !> The state at the end of time, if that comes first.
      type(state_type), intent(inout) :: final
      logical, intent(out) :: finished
      integer, intent(inout) :: status
      type(oscillation_type) :: rest
      real(wp) :: d(0:5), time
      logical :: complete

      rest = new_rest(drive%osc%xi, drive%osc%mu, drive%r, drive%load, state%phase, state%x, &
         state%x_dot)
      call release_time(rest, state%side, remaining, time, complete)
      finished = time > remaining
      if (.not. complete) then
         status = stat%budget
         return
      end if
      time = min(time, remaining)
      d = derivatives(rest, time)
      final%x = d(0)
      final%x_dot = d(1)
      final%z = d(0) + 0.5_wp*state%side*drive%clearance
      final%z_dot = d(1)
      if (finished) return
      state = final
      call move(state, drive%r*time)
      state%resting = .false.
      state%released = .true.
      event = event_type(release_event, state%side, state%cycle, state%phase, state%x, &
         state%x_dot, &
         state%x_dot, state%z_dot, state%z_dot)
   end subroutine rest_on

   !> Advances the load phase.
   pure subroutine move(state, phase_step)
      type(state_type), intent(inout) :: state
      real(wp), intent(in) :: phase_step
      integer(int64) :: cycles

      state%phase = state%phase + phase_step
      if (state%phase < two_pi) return
      cycles = int(state%phase/two_pi, int64)
      state%cycle = state%cycle + cycles
      state%phase = state%phase - two_pi*real(cycles, wp)
   end subroutine move

end module vi_simulate
