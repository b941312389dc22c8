!> Letters of simulated events: those of a period, of a ring of events, or between two phases.
!!
!! An impact is a letter of its own. The impacts that accumulate on a wall make one letter with the
!! rest that they end in; see vi_letters for how letters are written as numbers.
module vi_event_letters
   use vi_drive, only: event_type, impact_event, release_event, stick_event, two_pi
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: last_of_period, letter_endings, mismatch, read_letters, read_window, total_phase

   !> Letters of some events, and the event that begins and that ends each.
   type, public :: reading_type
      integer :: n = 0
      !> +1 and -1 for an impact, +2 and -2 for accumulation and rest.
      integer, allocatable :: letters(:), first(:), last(:)
   end type reading_type

contains

   !> Load phase of an event since the start.
   elemental real(wp) function total_phase(event)
      !> The event.
      type(event_type), intent(in) :: event

      total_phase = two_pi*real(event%cycle, wp) + event%phase
   end function total_phase

   !> The event with which a period ends: the last release, or the last event if there is none.
   pure integer function last_of_period(events) result(last)
      !> (n) In the order of time.
      type(event_type), intent(in) :: events(:)

      last = findloc(events%kind, release_event, dim=1, back=.true.)
      if (last == 0) last = size(events)
   end function last_of_period

   !> The letter that is complete with each event: 0 for a release, and for an impact that is part
   !! of an accumulation.
   pure function letter_endings(events, ring) result(letters)
      !> (n) In the order of time.
      type(event_type), intent(in) :: events(:)
      !> Whether the first event follows on the last one, as in a period.
      logical, intent(in) :: ring
      integer :: letters(size(events))
      integer :: i, side, rounds

      letters = 0
      side = 0
      ! backwards, since the rest tells that the impacts before it on its wall were accumulating
      do rounds = 1, merge(2, 1, ring)
         do i = size(events), 1, -1
            select case (events(i)%kind)
            case (impact_event)
               if (events(i)%side /= side) side = 0
               letters(i) = merge(events(i)%side, 0, side == 0)
            case (stick_event)
               side = events(i)%side
               letters(i) = 2*side
            case default                                                      ! a release
               side = 0
            end select
         end do
      end do
   end function letter_endings

   !> The letters of all events, one after the other. An accumulation whose first impacts are not
   !! among the events is a letter all the same; without its rest it is as many letters as impacts.
   pure subroutine read_letters(events, reading)
      !> (n) In the order of time.
      type(event_type), intent(in) :: events(:)
      !> The letters, and the first and last event of each (numbers in `events`).
      type(reading_type), intent(out) :: reading
      integer :: endings(size(events)), i, first

      endings = letter_endings(events, .false.)
      reading%letters = pack(endings, endings /= 0)
      allocate (reading%first(size(reading%letters)), reading%last(size(reading%letters)))
      first = 1
      associate (n => reading%n)
         do i = 1, size(events)
            if (endings(i) /= 0) then
               n = n + 1
               reading%first(n) = first
            else if (events(i)%kind == impact_event) then
               cycle
            end if
            ! also a release: it belongs to the letter before it
            first = i + 1
            if (n > 0) reading%last(n) = i
         end do
      end associate
   end subroutine read_letters

   !> The letters of the events after one load phase and up to another.
   pure subroutine read_window(events, begin, finish, reading)
      !> (n) In the order of time.
      type(event_type), intent(in) :: events(:)
      !> Load phases since the start (rad); an event at `begin` is left out, one at `finish` is not.
      real(wp), intent(in) :: begin, finish
      !> The letters, and the first and last event of each (numbers in `events`).
      type(reading_type), intent(out) :: reading
      integer :: before

      before = count(total_phase(events) <= begin)
      call read_letters(events(before + 1:count(total_phase(events) <= finish)), reading)
      reading%first = reading%first + before
      reading%last = reading%last + before
   end subroutine read_window

   !> The greatest difference in phase of the letters of two windows some cycles apart; huge where
   !! the letters differ, or are all on one wall.
   pure real(wp) function mismatch(events, now, before, cycles)
      !> (n) All events, in the order of time.
      type(event_type), intent(in) :: events(:)
      !> Letters of the later and of the earlier window.
      type(reading_type), intent(in) :: now, before
      !> Load cycles from the earlier window to the later one.
      integer, intent(in) :: cycles

      mismatch = huge(1.0_wp)
      if (now%n < 2 .or. now%n /= before%n) return
      if (any(now%letters /= before%letters)) return
      if (all(now%letters > 0) .or. all(now%letters < 0)) return
      mismatch = maxval(abs(total_phase(events(now%first)) - total_phase(events(before%first)) &
         - two_pi*cycles))
   end function mismatch

end module vi_event_letters
