!> Letters read from the events of a simulation, and whether they repeat themselves.
module vi_readings
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_drive, only: drive_type, event_type, impact_event, release_event, state_type, &
      stick_event, two_pi
   use vi_kinds, only: wp
   use vi_simulate, only: simulate
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: last_of_period, mismatch, read_window, run, total_phase

   !> Letters of the events of some cycles, and the event that begins and that ends each.
   type, public :: reading_type
      integer :: n = 0
      !> +1 and -1 for an impact, +2 and -2 for accumulation and rest, as in vi_letters.
      integer, allocatable :: letters(:), first(:), last(:)
   end type reading_type

contains

   !> Simulates some cycles from a state, whatever the number of events.
   pure subroutine run(drive, state, cycles, events, n, status)
      type(drive_type), intent(in) :: drive
      !> Out: the end.
      type(state_type), intent(inout) :: state
      integer, intent(in) :: cycles
      !> Room for events, of which the last ones are kept, and their number.
      type(event_type), intent(inout) :: events(:)
      integer, intent(out) :: n
      integer, intent(out) :: status
      type(state_type) :: final
      integer(int64) :: last_cycle
      real(wp) :: last_phase
      integer :: calls

      last_cycle = state%cycle + cycles
      last_phase = state%phase
      do calls = 1, 100000
         call simulate(drive, state, last_cycle, last_phase, events, n, final, status)
         if (status /= stat%more_events) exit
      end do
      state = final
   end subroutine run

   !> Load phase of an event since the start.
   elemental real(wp) function total_phase(event)
      type(event_type), intent(in) :: event

      total_phase = two_pi*real(event%cycle, wp) + event%phase
   end function total_phase

   !> The event with which a period ends: the last release, or the last event if there is none.
   pure integer function last_of_period(events) result(last)
      type(event_type), intent(in) :: events(:)

      last = findloc(events%kind, release_event, dim=1, back=.true.)
      if (last == 0) last = size(events)
   end function last_of_period

   !> The letters of the events after one load phase and up to another.
   pure subroutine read_window(events, begin, finish, reading)
      type(event_type), intent(in) :: events(:)
      real(wp), intent(in) :: begin, finish
      type(reading_type), intent(inout) :: reading
      integer :: i, run_length
      logical :: goes_on

      if (allocated(reading%letters)) then
         if (size(reading%letters) < size(events)) deallocate (reading%letters, reading%first, &
            reading%last)
      end if
      if (.not. allocated(reading%letters)) allocate (reading%letters(size(events)), &
         reading%first(size(events)), reading%last(size(events)))
      reading%n = 0
      run_length = 0
      do i = 1, size(events)
         if (total_phase(events(i)) <= begin .or. total_phase(events(i)) > finish) cycle
         associate (n => reading%n)
            select case (events(i)%kind)
            case (impact_event)
               goes_on = n > 0 .and. run_length > 0
               if (goes_on) goes_on = reading%letters(n) == events(i)%side
               run_length = merge(run_length + 1, 1, goes_on)
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

   !> The greatest difference in phase of the letters of two windows some cycles apart; huge where
   !! the letters differ, or are all on one wall.
   pure real(wp) function mismatch(events, now, before, cycles)
      type(event_type), intent(in) :: events(:)
      type(reading_type), intent(in) :: now, before
      integer, intent(in) :: cycles

      mismatch = huge(1.0_wp)
      if (now%n < 2 .or. now%n /= before%n) return
      associate (n => now%n)
         if (any(now%letters(:n) /= before%letters(:n))) return
         if (all(now%letters(:n) > 0) .or. all(now%letters(:n) < 0)) return
         mismatch = maxval(abs(total_phase(events(now%first(:n))) &
            - total_phase(events(before%first(:n))) - two_pi*cycles))
      end associate
   end function mismatch

end module vi_readings
