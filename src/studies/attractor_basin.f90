!> To which attractor a state goes: simulated until it is in a neighbourhood of a known one.
module vi_attractor_basin
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_attractor_target, only: difference, target_type
   use vi_drive, only: drive_type, event_type, initial_state, new_drive, release_event, state_type
   use vi_kinds, only: wp
   use vi_oscillator, only: oscillator_type
   use vi_simulate, only: simulate
   use vi_status, only: stat
   use vi_tally, only: add_work, is_stopped
   implicit none (type, external)
   private

   public :: decide

   !> The label of a state that was not come to.
   integer, parameter, public :: not_reached = -1

contains

   !> Initial states to the numbers of their attractors; 0 if not decided within the cycles, and
   !! `not_reached` if it was stopped before.
   subroutine decide(osc, r, load, clearance, targets, starts, cycles, threads, labels, impacts, &
      ends, tally)
      type(oscillator_type), intent(in) :: osc
      real(wp), intent(in) :: r, load, clearance
      type(target_type), intent(in) :: targets(:)
      !> (5, m): t, x, x', z, z'
      real(wp), intent(in) :: starts(:, :)
      integer, intent(in) :: cycles, threads
      !> (m)
      integer, intent(out) :: labels(:), impacts(:)
      !> (5, m): where a state is when it is decided or given up.
      real(wp), intent(out) :: ends(:, :)
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      type(drive_type) :: drive
      integer :: j

      labels = not_reached
      impacts = 0
      ends = starts
      drive = new_drive(osc, r, load, clearance)
      !$omp parallel do schedule(dynamic, 64) num_threads(threads)
      do j = 1, size(starts, 2)
         if (is_stopped(tally)) cycle
         call follow(drive, targets, starts(:, j), cycles, labels(j), impacts(j), ends(:, j))
         call add_work(1, tally)
      end do
      !$omp end parallel do
   end subroutine decide

   !> Simulates one state until it is in a neighbourhood.
   pure subroutine follow(drive, targets, start, cycles, label, impacts, finish)
      type(drive_type), intent(in) :: drive
      type(target_type), intent(in) :: targets(:)
      real(wp), intent(in) :: start(5)
      integer, intent(in) :: cycles
      integer, intent(out) :: label, impacts
      real(wp), intent(out) :: finish(5)
      integer, parameter :: chunk = 8
      type(state_type) :: state, final
      type(event_type) :: events(chunk)
      integer(int64) :: last
      real(wp) :: phase
      integer :: n, i, status

      state = initial_state(drive, start)
      last = state%cycle + cycles
      phase = state%phase
      label = 0
      impacts = 0
      do
         call simulate(drive, state, last, phase, events, n, final, status)
         do i = 1, n
            impacts = impacts + 1
            label = neighbourhood_of(targets, events(i))
            if (label > 0) exit
         end do
         if (label > 0 .or. status /= stat%more_events) exit
      end do
      finish = [final%phase/drive%r, final%x, final%x_dot, final%z, final%z_dot]
   end subroutine follow

   !> The attractor in whose neighbourhood an event is, or 0.
   pure integer function neighbourhood_of(targets, event) result(label)
      type(target_type), intent(in) :: targets(:)
      type(event_type), intent(in) :: event
      real(wp) :: d(4)

      do label = 1, size(targets)
         associate (t => targets(label))
            if (t%side /= event%side .or. .not. t%radius > 0) cycle
            if (t%release .neqv. event%kind == release_event) cycle
            if (t%n == 4) then
               if (abs(event%x - t%middle(1)) > t%box(1)) cycle
               if (abs(event%x_dot_after - t%middle(2)) > t%box(2)) cycle
            end if
            d = difference(t, event)
            if (all(abs(d) <= t%box) .and. sum(matmul(t%metric, d)**2) < t%radius**2) return
         end associate
      end do
      label = 0
   end function neighbourhood_of

end module vi_attractor_basin
