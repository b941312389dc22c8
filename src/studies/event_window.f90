!> Simulated cycles as letters: those of the events between two phases, and whether they come back
!! after a period.
module vi_event_window
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_drive, only: drive_type, event_type, impact_event, state_type, stick_event, two_pi
   use vi_kinds, only: wp
   use vi_simulate, only: simulate
   use vi_status, only: stat
   use vi_tally, only: is_stopped
   implicit none (type, external)
   private

   public :: read_window, repeats, run, total_phase

   !> Events kept of the end of a simulation.
   integer, parameter, public :: room = 4000
   !> Times that so many events are simulated at most, and load cycles between two looks at whether
   !! to stop.
   integer, parameter :: most_calls = 1000, between_looks = 10000

   !> Letters of the events of some cycles, and the event that begins and that ends each.
   type, public :: reading_type
      integer :: n = 0
      integer, dimension(room) :: letters, first, last
   end type reading_type

contains

   !> Simulates some cycles from a state; out: the state there, and the last events.
   subroutine run(drive, state, cycles, events, n, status, tally)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(inout) :: state
      integer, intent(in) :: cycles
      type(event_type), intent(inout) :: events(:)
      !> Status `stat%more_events` if there are too many, `stat%not_computed` if it was stopped.
      integer, intent(out) :: n, status
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      type(state_type) :: final
      integer(int64) :: last_cycle, cycle
      real(wp) :: last_phase
      integer :: calls

      last_cycle = state%cycle + cycles
      last_phase = state%phase
      cycle = state%cycle
      calls = 0
      do
         cycle = min(last_cycle, cycle + between_looks)
         do
            calls = calls + 1
            call simulate(drive, state, cycle, last_phase, events, n, final, status)
            if (status /= stat%more_events .or. calls == most_calls) exit
         end do
         if (status /= stat%ok .or. cycle == last_cycle) exit
         if (is_stopped(tally)) then
            status = stat%not_computed
            exit
         end if
      end do
      state = final
   end subroutine run

   !> Load phase with all its cycles.
   pure real(wp) function total_phase(event)
      type(event_type), intent(in) :: event

      total_phase = two_pi*real(event%cycle, wp) + event%phase
   end function total_phase

   !> The letters of the events between two phases.
   pure subroutine read_window(events, begin, finish, reading)
      type(event_type), intent(in) :: events(:)
      real(wp), intent(in) :: begin, finish
      type(reading_type), intent(out) :: reading
      integer :: i, run_length

      run_length = 0
      do i = 1, size(events)
         if (total_phase(events(i)) <= begin .or. total_phase(events(i)) > finish) cycle
         associate (n => reading%n)
            select case (events(i)%kind)
            case (impact_event)
               run_length = merge(run_length + 1, 1, n > 0 .and. run_length > 0)
               if (n > 0) then
                  if (reading%letters(n) /= events(i)%side) run_length = 1
               end if
               n = n + 1
               reading%letters(n) = events(i)%side
               reading%first(n) = i
               reading%last(n) = i
            case (stick_event)
               ! the run of impacts on this wall becomes one letter
               if (run_length > 0) n = n - run_length + 1
               if (run_length == 0) then
                  n = n + 1
                  reading%first(n) = i
               end if
               reading%letters(n) = 2*events(i)%side
               reading%last(n) = i
               run_length = 0
            case default                                                      ! a release
               if (n > 0) reading%last(n) = i
               run_length = 0
            end select
         end associate
      end do
   end subroutine read_window

   !> Whether two windows hold the same letters at the same phases, on both walls.
   pure logical function repeats(events, now, before, cycles)
      type(event_type), intent(in) :: events(:)
      type(reading_type), intent(in) :: now, before
      integer, intent(in) :: cycles
      integer :: j

      repeats = now%n > 1 .and. now%n == before%n
      if (.not. repeats) return
      associate (letters => now%letters(:now%n))
         repeats = all(letters == before%letters(:now%n)) .and. any(letters > 0) .and. &
            any(letters < 0)
      end associate
      do j = 1, now%n
         if (.not. repeats) return
         repeats = abs(total_phase(events(now%first(j))) - total_phase(events(before%first(j))) &
            - two_pi*cycles) < 1.0e-3_wp
      end do
   end function repeats

end module vi_event_window
