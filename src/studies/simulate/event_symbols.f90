!> Symbols of simulated events: those of a period, of a ring of events, or between two phases.
!!
!! A single impact is one symbol. The impacts that accumulate on a wall form one symbol together
!! with the rest in which they end; see vi_symbols for how symbols are written as numbers.
module vi_event_symbols
   use vi_forced_system, only: event_type, impact_event, release_event, stick_event
   use vi_kinds, only: two_pi, wp
   implicit none (type, external)
   private

   public :: last_of_period, symbol_endings, mismatch, read_periods, read_symbols, &
      symbols_between, total_phase

   !> Symbols of some events, and the event that begins and that ends each.
   type, public :: symbol_sequence_type
      integer :: n = 0
      !> +1 and -1 for an impact, +2 and -2 for accumulation and rest.
      integer, allocatable :: symbols(:), first(:), last(:)
   end type symbol_sequence_type

   !> A period at the end of a list of events.
   type, public :: period_type
      !> Load cycles, and the number of the event with which it ends.
      integer :: cycles = 0, last = 0
      !> Its symbols, and the greatest difference in phase (rad) from the previous period.
      type(symbol_sequence_type) :: reading
      real(wp) :: mismatch = huge(1.0_wp)
   end type period_type

   !> A longer period is listed after a shorter one if its mismatch is less than this factor times
   !! that of the shorter one; none is sought if that product (rad) is as small as rounding.
   real(wp), parameter :: nearer = 0.3_wp, certain = 1.0e-9_wp

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

   !> The periods at the end of a list of events, the shortest one first.
   !!
   !! A period repeats the symbols of the previous one, at about the same phases. After a period
   !! doubling, the shorter period also nearly repeats itself; a longer one is listed if it does so
   !! better. The motion probably has the last period listed; if the simulation has not settled yet,
   !! the motion may turn out to have a shorter one.
   pure subroutine read_periods(events, longest, most_symbols, tolerance, periods, begin)
      !> (n) In the order of time.
      type(event_type), intent(in) :: events(:)
      !> Longest period in load cycles, and most symbols of a period.
      integer, intent(in) :: longest, most_symbols
      !> Largest mismatch (rad).
      real(wp), intent(in) :: tolerance
      !> The periods; none if the events do not repeat themselves.
      type(period_type), allocatable, intent(out) :: periods(:)
      !> Load phase (rad) from which all events are known; by default there is no such limit.
      real(wp), intent(in), optional :: begin
      type(period_type) :: found(longest), next
      type(symbol_sequence_type) :: before
      real(wp) :: finish, least
      integer :: n

      allocate (periods(0))
      if (size(events) == 0) return
      next%last = last_of_period(events)
      ! a motion with rest has a release in each period: an older one belongs to the transient
      n = size(events)
      if (total_phase(events(n)) - total_phase(events(next%last)) > two_pi*longest) next%last = n
      ! a thousandth of a cycle is added, so that the event one period earlier belongs to the
      ! earlier window
      finish = total_phase(events(next%last)) + 1.0e-3_wp*two_pi
      least = tolerance
      n = 0
      do while (next%cycles < longest .and. least > certain)
         next%cycles = next%cycles + 1
         associate (span => two_pi*next%cycles, upto => events(:next%last))
            if (present(begin)) then
               if (finish - 2*span < begin) exit
            end if
            call symbols_between(upto, finish - span, finish, next%reading)
            call symbols_between(upto, finish - 2*span, finish - span, before)
            if (next%reading%n > most_symbols) exit
            next%mismatch = mismatch(upto, next%reading, before, next%cycles)
         end associate
         if (.not. next%mismatch < least) cycle
         n = n + 1
         found(n) = next
         least = nearer*next%mismatch
      end do
      periods = found(:n)
   end subroutine read_periods

   !> The symbol that ends with each event: 0 for a release, and for an impact that is part of an
   !! accumulation.
   pure function symbol_endings(events, ring) result(symbols)
      !> (n) In the order of time.
      type(event_type), intent(in) :: events(:)
      !> Whether the first event follows the last one, as in a period.
      logical, intent(in) :: ring
      integer :: symbols(size(events))
      integer :: i, side, rounds

      symbols = 0
      side = 0
      ! backwards, since a rest shows that the impacts before it on its wall were accumulating
      do rounds = 1, merge(2, 1, ring)
         do i = size(events), 1, -1
            select case (events(i)%kind)
            case (impact_event)
               if (events(i)%side /= side) side = 0
               symbols(i) = merge(events(i)%side, 0, side == 0)
            case (stick_event)
               side = events(i)%side
               symbols(i) = 2*side
            case default                                                      ! a release
               side = 0
            end select
         end do
      end do
   end function symbol_endings

   !> The symbols of all events, one after the other. An accumulation whose first impacts are not
   !! among the events is still a symbol; without its rest, each of its impacts is one.
   pure subroutine read_symbols(events, reading)
      !> (n) In the order of time.
      type(event_type), intent(in) :: events(:)
      !> The symbols, and the first and last event of each (numbers in `events`).
      type(symbol_sequence_type), intent(out) :: reading
      integer :: endings(size(events)), i, first

      endings = symbol_endings(events, .false.)
      reading%symbols = pack(endings, endings /= 0)
      allocate (reading%first(size(reading%symbols)), reading%last(size(reading%symbols)))
      first = 1
      associate (n => reading%n)
         do i = 1, size(events)
            if (endings(i) /= 0) then
               n = n + 1
               reading%first(n) = first
            else if (events(i)%kind == impact_event) then
               cycle
            end if
            ! also a release: it belongs to the symbol before it
            first = i + 1
            if (n > 0) reading%last(n) = i
         end do
      end associate
   end subroutine read_symbols

   !> The symbols of the events after one load phase and up to another.
   pure subroutine symbols_between(events, begin, finish, reading)
      !> (n) In the order of time.
      type(event_type), intent(in) :: events(:)
      !> Load phases since the start (rad); an event at `begin` is left out, one at `finish` is not.
      real(wp), intent(in) :: begin, finish
      !> The symbols, and the first and last event of each (numbers in `events`).
      type(symbol_sequence_type), intent(out) :: reading
      integer :: before

      before = count(total_phase(events) <= begin)
      call read_symbols(events(before + 1:count(total_phase(events) <= finish)), reading)
      reading%first = reading%first + before
      reading%last = reading%last + before
   end subroutine symbols_between

   !> The greatest difference in phase of the symbols of two windows some cycles apart; huge where
   !! the symbols differ, or are all on one wall.
   pure real(wp) function mismatch(events, now, before, cycles)
      !> (n) All events, in the order of time.
      type(event_type), intent(in) :: events(:)
      !> Symbols of the later and of the earlier window.
      type(symbol_sequence_type), intent(in) :: now, before
      !> Load cycles from the earlier window to the later one.
      integer, intent(in) :: cycles

      mismatch = huge(1.0_wp)
      if (now%n < 2 .or. now%n /= before%n) return
      if (any(now%symbols /= before%symbols)) return
      if (all(now%symbols > 0) .or. all(now%symbols < 0)) return
      mismatch = maxval(abs(total_phase(events(now%first)) - total_phase(events(before%first)) &
         - two_pi*cycles))
   end function mismatch

end module vi_event_symbols
