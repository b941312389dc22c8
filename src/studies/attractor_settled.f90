!> What simulations settle on: the last impacts, the period if there is one, extreme positions.
!!
!! Simulations stand in chains. Along a chain the parameters change from link to link and the state
!! goes on, so that a chain is a sweep; chains of one link are independent initial states.
module vi_attractor_settled
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_drive, only: drive_type, event_type, impact_event, initial_state, new_drive, &
      state_time, state_type, stick_event
   use vi_event_letters, only: letter_endings
   use vi_kinds, only: wp
   use vi_oscillator, only: oscillator_type
   use vi_simulate, only: simulate
   use vi_status, only: stat
   use vi_tally, only: add_sight, add_work, is_stopped
   use vi_trajectory, only: extreme_positions, later, store_events
   implicit none (type, external)
   private

   public :: settle_chains

   !> Events kept of a simulation, and events in which a simulation has to be done.
   integer, parameter :: room = 4096, most_events = 50000000
   !> States one period apart are the same within this part of the clearance.
   real(wp), parameter :: same = 1.0e-5_wp

   !> The end of a simulation.
   type :: settled_type
      !> Load cycles of the period, 0 if there is none; letters, impacts and rests in it.
      integer :: period = 0, letters = 0, impacts = 0, rests = 0
      real(wp) :: x_min = 0, x_max = 0
      !> Events of the last cycles.
      integer :: n = 0
      type(event_type), allocatable :: events(:)
      integer :: status = stat%ok
   end type settled_type

contains

   !> Chains of simulations, each chain a task of its own.
   subroutine settle_chains(parameters, load, starts, settling, keep, kick, threads, values, &
      labels, found, periods, extremes, ends, status, tally)
      !> (6, links, chains): r, D, xi, mu, R1, R2
      real(wp), intent(in) :: parameters(:, :, :)
      real(wp), intent(in) :: load
      !> (5, chains): t, x, x', z, z'
      real(wp), intent(in) :: starts(:, :)
      !> Load cycles simulated first, and those that are kept.
      integer, intent(in) :: settling, keep
      !> Added to x' from link to link, over D: a sweep leaves what is unstable.
      real(wp), intent(in) :: kick
      integer, intent(in) :: threads
      !> (7, room, links, chains), (2, ..): the kept impacts as in `store_events`, and their number.
      real(wp), intent(inout) :: values(:, :, :, :)
      integer, intent(inout) :: labels(:, :, :, :), found(:, :)
      !> (4, links, chains): period, letters, impacts, rests; (2, ..): least and greatest x.
      integer, intent(inout) :: periods(:, :, :)
      real(wp), intent(inout) :: extremes(:, :, :)
      !> (5, links, chains): states at the end, as `starts`.
      real(wp), intent(inout) :: ends(:, :, :)
      !> `stat%not_computed` from the link on at which it was stopped.
      integer, intent(inout) :: status(:, :)
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      type(settled_type) :: settled
      type(state_type) :: state
      type(drive_type) :: drive
      integer :: i, j

      call add_sight(size(parameters, 2)*size(starts, 2), tally)
      status = stat%not_computed
      found = 0
      periods = 0
      extremes = ieee_value(load, ieee_quiet_nan)
      !$omp parallel do schedule(dynamic, 1) num_threads(threads) private(settled, state, drive, i)
      do j = 1, size(starts, 2)
         do i = 1, size(parameters, 2)
            if (is_stopped(tally)) exit
            associate (c => parameters(:, i, j))
               drive = new_drive(oscillator_type(c(3), c(4), c(5:6)), c(1), load, c(2))
            end associate
            if (i == 1) then
               state = initial_state(drive, starts(:, j))
            else
               state = carried(drive, state, parameters(2, max(1, i - 1), j), kick)
            end if
            call settle_on(drive, state, settling, keep, settled)
            call store(settled, values(:, :, i, j), labels(:, :, i, j), drive%r, found(i, j))
            periods(:, i, j) = [settled%period, settled%letters, settled%impacts, settled%rests]
            extremes(:, i, j) = [settled%x_min, settled%x_max]
            ends(:, i, j) = [state%phase/drive%r, state%x, state%x_dot, state%z, state%z_dot]
            status(i, j) = settled%status
            call add_work(1, tally)
         end do
      end do
      !$omp end parallel do
   end subroutine settle_chains

   !> A state under new parameters: the free mass keeps its place between the walls.
   pure function carried(drive, state, clearance, kick) result(next)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(in) :: state
      !> That before.
      real(wp), intent(in) :: clearance
      real(wp), intent(in) :: kick
      type(state_type) :: next
      real(wp) :: y, half

      half = 0.5_wp*drive%clearance
      y = (state%z - state%x)*(drive%clearance/clearance)
      if (state%side /= 0) y = state%side*half
      y = max(-half, min(half, y))
      next = initial_state(drive, [state%phase/drive%r, state%x, state%x_dot + kick*half, &
         state%x + y, state%z_dot + merge(kick*half, 0.0_wp, state%side /= 0)])
   end function carried

   !> Simulates until the transient is over, and looks at what is left.
   pure subroutine settle_on(drive, state, settling, keep, settled)
      type(drive_type), intent(in) :: drive
      !> Out: the end.
      type(state_type), intent(inout) :: state
      integer, intent(in) :: settling, keep
      type(settled_type), intent(inout) :: settled
      type(state_type) :: last(0:keep)
      integer :: n, first(0:keep), i, k
      integer :: total, stored

      if (.not. allocated(settled%events)) allocate (settled%events(room))
      settled%period = 0
      settled%n = 0
      total = 0
      state%cycle = 0
      last(0) = state
      ! states are compared at a phase that the start has nothing to do with: not at an impact
      call advance(drive, state, last(0), settling + 0.6180339887_wp, settled%events, n, total, &
         settled%status)
      first = 1
      stored = 0
      n = 0
      do i = 1, keep
         if (settled%status /= stat%ok) exit
         last(i) = last(i - 1)
         call advance(drive, state, last(i), 1.0_wp, settled%events(first(i - 1):), n, total, &
            settled%status)
         first(i) = first(i - 1) + n
         stored = stored + n
      end do
      if (settled%status == stat%ok) then
         settled%n = stored
         do k = 1, (keep - 1)/2
            if (.not. (alike(last(keep), last(keep - k), drive%clearance) .and. &
               alike(last(keep - k), last(keep - 2*k), drive%clearance))) cycle
            settled%period = k
            exit
         end do
         k = merge(keep, settled%period, settled%period == 0)
         call read_period(settled, first(keep - k), settled%n)
         call find_extremes(drive, last(keep - k), last(keep), &
            settled%events(first(keep - k):settled%n), settled)
      end if
      state = last(merge(keep, 0, settled%status == stat%ok))
   end subroutine settle_on

   !> Goes on some cycles; the events of the end are kept if there is room.
   pure subroutine advance(drive, state, final, cycles, events, n, total, status)
      type(drive_type), intent(in) :: drive
      !> Where the last flight or rest began, and the end from which the cycles count.
      type(state_type), intent(inout) :: state, final
      real(wp), intent(in) :: cycles
      type(event_type), intent(inout) :: events(:)
      integer, intent(out) :: n
      integer, intent(inout) :: total
      integer, intent(out) :: status
      integer(int64) :: cycle
      real(wp) :: phase

      call later(final, cycles, cycle, phase)
      do
         call simulate(drive, state, cycle, phase, events, n, final, status)
         total = total + n
         if (status /= stat%more_events .or. total > most_events) exit
         if (.not. cycles > 1) exit
      end do
   end subroutine advance

   !> Whether two states at one phase are the same.
   pure logical function alike(a, b, clearance)
      type(state_type), intent(in) :: a, b
      real(wp), intent(in) :: clearance

      alike = maxval(abs([a%x - b%x, a%x_dot - b%x_dot, a%z - b%z, a%z_dot - b%z_dot])) <= &
         same*clearance
   end function alike

   !> Counts letters, impacts and rests of a period, which has no beginning: its events are a ring.
   pure subroutine read_period(settled, first, last)
      type(settled_type), intent(inout) :: settled
      integer, intent(in) :: first, last

      associate (events => settled%events(first:last))
         settled%impacts = count(events%kind == impact_event)
         settled%rests = count(events%kind == stick_event)
         settled%letters = count(letter_endings(events, .true.) /= 0)
      end associate
   end subroutine read_period

   !> Extreme positions of the primary mass between two states.
   pure subroutine find_extremes(drive, begin, finish, events, settled)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(in) :: begin, finish
      type(event_type), intent(in) :: events(:)
      type(settled_type), intent(inout) :: settled
      real(wp) :: starts(6, 0:size(events))
      integer :: resting(0:size(events)), i
      logical :: complete

      starts(:, 0) = [state_time(begin%cycle, begin%phase, drive%r), begin%phase, begin%x, &
         begin%x_dot, begin%z, begin%z_dot]
      resting(0) = merge(begin%side, 0, begin%resting)
      do i = 1, size(events)
         associate (e => events(i))
            starts(:, i) = [state_time(e%cycle, e%phase, drive%r), e%phase, e%x, e%x_dot_after, &
               0.0_wp, e%z_dot_after]
            resting(i) = merge(e%side, 0, e%kind == stick_event)
         end associate
      end do
      call extreme_positions(drive, starts, resting, &
         state_time(finish%cycle, finish%phase, drive%r), settled%x_min, settled%x_max, complete)
      if (.not. complete) settled%status = stat%budget
   end subroutine find_extremes

   !> The kept impacts as columns, as many as there is room for.
   pure subroutine store(settled, values, labels, r, n)
      type(settled_type), intent(in) :: settled
      real(wp), intent(inout) :: values(:, :)
      integer, intent(inout) :: labels(:, :)
      real(wp), intent(in) :: r
      integer, intent(out) :: n
      type(event_type), allocatable :: impacts(:)

      impacts = pack(settled%events(:settled%n), settled%events(:settled%n)%kind == impact_event)
      n = min(size(impacts), size(values, 2))
      call store_events(impacts(:n), r, values(:, :n), labels(:, :n))
   end subroutine store

end module vi_attractor_settled
