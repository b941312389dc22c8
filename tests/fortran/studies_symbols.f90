!> Symbols of events: laws on artificial and on simulated events.
module studies_symbols
   use checks, only: check
   use random_numbers, only: draw_integer, random_type
   use vi_forced_system, only: forced_system_type, event_type, impact_event, new_forced_system, &
      release_event, state_type, &
      stick_event
   use vi_event_symbols, only: last_of_period, symbol_endings, mismatch, period_type, &
      read_periods, read_symbols, symbols_between, symbol_sequence_type, total_phase
   use vi_kinds, only: two_pi, wp
   use vi_oscillator, only: oscillator_type
   use vi_simulate, only: simulate_cycles
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: test_symbols

   type(random_type) :: random

contains

   subroutine test_symbols()
      type(event_type), allocatable :: events(:)
      integer :: i

      call test_cases()
      call test_window()
      call test_simulated()
      call test_periods()
      do i = 1, 300
         events = random_events(draw_integer(random, 1, 12))
         call check_ring(events)
         call check_mirror(events)
         call check_counts(events)
      end do
   end subroutine test_symbols

   !> Events one phase unit apart: R and L are impacts, > and < a rest on the right and the left
   !! wall, + and - the release from it.
   pure function events_of(text) result(events)
      character(*), intent(in) :: text
      type(event_type) :: events(len(text))
      integer :: i

      do i = 1, len(text)
         events(i) = event_type(impact_event, merge(1, -1, scan(text(i:i), 'R>+') > 0), 0, &
            real(i, wp), 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp)
         if (scan(text(i:i), '<>') > 0) events(i)%kind = stick_event
         if (scan(text(i:i), '+-') > 0) events(i)%kind = release_event
      end do
   end function events_of

   !> Impacts and rests in any order; each rest is followed by its release.
   function random_events(n) result(events)
      integer, intent(in) :: n
      type(event_type), allocatable :: events(:)
      character(2*n) :: text
      integer :: i, used

      used = 0
      do i = 1, n
         select case (draw_integer(random, 1, 8))
         case (1:3)
            text(used + 1:) = 'R'
         case (4:6)
            text(used + 1:) = 'L'
         case (7)
            text(used + 1:) = '>+'
         case default
            text(used + 1:) = '<-'
         end select
         used = len_trim(text)
      end do
      events = events_of(text(:used))
   end function random_events

   !> The symbols of events, and the events that begin and end each symbol.
   subroutine check_case(text, symbols, first, last)
      !> In the form of `events_of`.
      character(*), intent(in) :: text
      integer, intent(in) :: symbols(:), first(:), last(:)
      type(symbol_sequence_type) :: reading
      logical :: right

      call read_symbols(events_of(text), reading)
      right = reading%n == size(symbols)
      if (right) right = all(reading%symbols == symbols) .and. all(reading%first == first) .and. &
         all(reading%last == last)
      call check(right, 'symbols of '//text)
   end subroutine check_case

   subroutine test_cases()
      integer, parameter :: none(0) = 0

      call check_case('', none, none, none)                                  ! nothing happened
      call check_case('RL', [1, -1], [1, 2], [1, 2])
      ! accumulating impacts, their rest and its release are one symbol
      call check_case('RRRR>+', [2], [1], [6])
      call check_case('LRRR>+L', [-1, 2, -1], [1, 2, 7], [1, 6, 7])
      call check_case('RRLLL<-', [1, 1, -2], [1, 2, 3], [1, 2, 7])
      ! a rest without impacts
      call check_case('>+', [2], [1], [2])
      call check_case('L>+L', [-1, 2, -1], [1, 2, 4], [1, 3, 4])
      ! a contact that is lost and immediately made again ends one symbol and begins another
      call check_case('RR>+>+L', [2, 2, -1], [1, 5, 7], [4, 6, 7])
      call check_case('RR>+R>+', [2, 2], [1, 5], [4, 7])
      ! impacts before a release are not part of a later accumulation
      call check_case('-RR>', [2], [2], [4])
      call check_case('R>+RR', [2, 1, 1], [1, 4, 5], [3, 4, 5])
   end subroutine test_cases

   !> A window cuts an accumulation: only a rest inside the window makes a symbol.
   subroutine test_window()
      type(event_type) :: events(9)
      type(symbol_sequence_type) :: reading

      events = events_of('LRRRR>+LL')
      call check(last_of_period(events) == 7, 'symbols: a period ends with the last release')
      call check(last_of_period(events_of('LRL')) == 3, 'symbols: or with the last event')
      call symbols_between(events, 3.5_wp, 8.0_wp, reading)
      call check(all(reading%symbols == [2, -1]) .and. all(reading%first == [4, 8]) .and. &
         all(reading%last == [7, 8]), 'symbols: an accumulation whose beginning is cut off')
      call symbols_between(events, 1.0_wp, 4.5_wp, reading)
      call check(reading%n == 3 .and. all(reading%symbols == 1) .and. &
         all(reading%first == [2, 3, 4]), 'symbols: an accumulation whose rest is cut off')
      call symbols_between(events, 6.5_wp, 7.5_wp, reading)
      call check(reading%n == 0, 'symbols: a release alone')
      call symbols_between(events, 20.0_wp, 30.0_wp, reading)
      call check(reading%n == 0, 'symbols: nothing happened in a window')
   end subroutine test_window

   !> A cyclic shift of the events of a period shifts its symbols.
   subroutine check_ring(events)
      type(event_type), intent(in) :: events(:)
      integer :: endings(size(events)), i

      endings = symbol_endings(events, .true.)
      do i = 1, size(events) - 1
         call check(all(symbol_endings(cshift(events, i), .true.) == cshift(endings, i)), &
            'symbols: of a period that begins elsewhere')
      end do
   end subroutine check_ring

   !> R <-> L.
   subroutine check_mirror(events)
      type(event_type), intent(in) :: events(:)
      type(event_type) :: images(size(events))
      type(symbol_sequence_type) :: reading, image

      images = events
      images%side = -events%side
      call read_symbols(events, reading)
      call read_symbols(images, image)
      call check(all(image%symbols == -reading%symbols) .and. all(image%first == reading%first) &
         .and. all(image%last == reading%last), 'symbols: of the mirror image')
   end subroutine check_mirror

   !> Each event but an initial release is in one symbol; each rest makes a starred symbol.
   subroutine check_counts(events)
      type(event_type), intent(in) :: events(:)
      type(symbol_sequence_type) :: reading
      integer :: i, n

      call read_symbols(events, reading)
      n = reading%n
      call check(count(abs(reading%symbols) == 2) == count(events%kind == stick_event), &
         'symbols: one starred symbol for each rest')
      if (n == 0) return
      call check(reading%first(1) == 1 .and. reading%last(n) == size(events) .and. &
         all(reading%first(2:) == reading%last(:n - 1) + 1), 'symbols: each event is in one')
      do i = 1, n
         associate (inside => events(reading%first(i):reading%last(i)))
            call check(all(inside%side*reading%symbols(i) > 0 .or. inside%kind == release_event), &
               'symbols: each has the wall of its events')
         end associate
      end do
   end subroutine check_counts

   !> A motion with rest from simulation: all its periods have the same symbols, cyclically too.
   subroutine test_simulated()
      type(forced_system_type) :: system
      type(state_type) :: state
      type(event_type) :: events(400)
      type(symbol_sequence_type) :: now, before
      real(wp) :: finish
      integer, allocatable :: ring(:)
      integer :: last, left, n, status

      ! R*L, with more than ten impacts in the accumulation
      system = new_forced_system(oscillator_type(0.0114_wp, 0.028_wp, [0.61_wp, 0.75_wp]), &
         1.100088_wp, &
         1.0_wp, 3.904359_wp)
      state%x_dot = 1
      left = 100000
      call simulate_cycles(system, state, 1000, left, events, n, status)
      call check(status == stat%ok .and. left < 100000, 'symbols: simulated')
      call simulate_cycles(system, state, 6, left, events, n, status)
      last = last_of_period(events(:n))
      finish = total_phase(events(last)) + 1.0e-3_wp
      call symbols_between(events(:last), finish - two_pi, finish, now)
      call symbols_between(events(:last), finish - 2*two_pi, finish - two_pi, before)
      call check(now%n == 2 .and. any(now%symbols == -1) .and. any(now%symbols == 2), &
         'symbols: R*L settled')
      call check(now%last(2) - now%first(1) > 10, 'symbols: many impacts in one symbol')
      call check(mismatch(events, now, before, 1) < 1.0e-6_wp, 'symbols: two periods are alike')
      call check(mismatch(events, now, before, 2) > 1, 'symbols: but not two cycles apart')
      ring = symbol_endings(events(now%first(1):now%last(2)), .true.)
      call check(all(pack(ring, ring /= 0) == now%symbols), 'symbols: of the ring')
      left = 3
      call simulate_cycles(system, state, 6, left, events(:2), n, status)
      call check(status == stat%event_limit .and. left == 0, &
         'symbols: a limit of events')
   end subroutine test_simulated

   !> Two impacts per cycle, the second one later by some angle in every other cycle: both periods
   !! are listed, or only that of two cycles, or the simple one if nothing differs.
   subroutine test_periods()
      type(event_type) :: events(24), early(25)
      type(period_type), allocatable :: periods(:)

      call make_doubled(0.0_wp, events)
      call read_periods(events, 5, 100, 0.05_wp, periods)
      call check(size(periods) == 1, 'periods: one')
      call check(periods(1)%cycles == 1 .and. all(periods(1)%reading%symbols == [1, -1]) .and. &
         all(periods(1)%reading%first == [23, 24]) .and. periods(1)%last == 24 .and. &
         periods(1)%mismatch < 1.0e-12_wp, 'periods: the simple one')
      call make_doubled(0.01_wp, events)
      call read_periods(events, 5, 100, 0.05_wp, periods)
      call check(all(periods%cycles == [1, 2]), 'periods: both')
      call check(abs(periods(1)%mismatch - 0.01_wp) < 1.0e-12_wp, 'periods: the angle between them')
      call check(all(periods(2)%reading%symbols == [1, -1, 1, -1]), 'periods: doubled')
      call make_doubled(0.1_wp, events)
      call read_periods(events, 5, 100, 0.05_wp, periods)
      call check(all(periods%cycles == [2]), 'periods: the longer one')
      call read_periods(events, 5, 3, 0.05_wp, periods)
      call check(size(periods) == 0, 'periods: at most three symbols')
      call read_periods(events, 1, 100, 0.05_wp, periods)
      call check(size(periods) == 0, 'periods: at most one cycle')
      ! the windows end a thousandth of a cycle after the last event
      call read_periods(events, 5, 100, 0.05_wp, periods, total_phase(events(24)) - 4*two_pi)
      call check(size(periods) == 1, 'periods: two of two cycles')
      call read_periods(events, 5, 100, 0.05_wp, periods, total_phase(events(24)) - 3.9_wp*two_pi)
      call check(size(periods) == 0, 'periods: less than two of two cycles')
      ! an early release belongs to the transient
      early = [event_type(release_event, 1, 0, 0.1_wp, 0, 0, 0, 0, 0), events]
      call read_periods(early, 5, 100, 0.05_wp, periods)
      call check(all(periods%cycles == [2]) .and. periods(1)%last == 25, 'periods: old release')
      call read_periods(early(:0), 5, 100, 0.05_wp, periods)
      call check(size(periods) == 0, 'periods: no events')
   end subroutine test_periods

   !> Impacts on the right wall at phase 1 and on the left one at phase 4, later in even cycles.
   subroutine make_doubled(later, events)
      !> The angle (rad).
      real(wp), intent(in) :: later
      !> An even number of cycles.
      type(event_type), intent(out) :: events(:)
      integer :: i

      do i = 1, size(events), 2
         events(i) = event_type(impact_event, 1, i/2, 1.0_wp, 0, 0, 0, 0, 0)
         events(i + 1) = event_type(impact_event, -1, i/2, 4 + modulo(i/2, 2)*later, 0, 0, 0, 0, 0)
      end do
   end subroutine make_doubled

end module studies_symbols
