!> The attractor that a state approaches: the state is simulated until it enters a neighbourhood of
!! a known attractor.
module vi_attractor_basin
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_attractor_target, only: difference, target_type
   use vi_forced_system, only: forced_system_type, event_type, initial_state, new_forced_system, &
      release_event, state_type
   use vi_kinds, only: wp
   use vi_oscillator, only: oscillator_type
   use vi_simulate, only: simulate_on
   use vi_status, only: stat
   use vi_progress, only: add_done_work, is_stopped
   implicit none (type, external)
   private

   public :: decide

   !> The label of a state that was not simulated, because the computation was stopped.
   integer, parameter, public :: not_reached = -1
   !> The label of a state whose simulation had too many events.
   integer, parameter, public :: event_limited = -2

contains

   !> The number of the attractor of each initial state; 0 if it is not decided within the cycles,
   !! `event_limited` if the limit of events was reached first, and `not_reached` if the computation
   !! was stopped first.
   subroutine decide(osc, r, load, clearance, targets, starts, cycles, max_events, threads, &
      labels, impacts, ends, progress)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio, load amplitude f, clearance.
      real(wp), intent(in) :: r, load, clearance
      !> Motions with their neighbourhoods.
      type(target_type), intent(in) :: targets(:)
      !> (5, m): t, x, x', z, z'
      real(wp), intent(in) :: starts(:, :)
      !> Largest numbers of load cycles and of events of a simulation, and number of OpenMP threads.
      integer, intent(in) :: cycles, max_events, threads
      !> (m) Number of the target, or as above; (m) events simulated until then.
      integer, intent(out) :: labels(:), impacts(:)
      !> (5, m): the state at which the simulation ended.
      real(wp), intent(out) :: ends(:, :)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(forced_system_type) :: system
      integer :: j

      labels = not_reached
      impacts = 0
      ends = starts
      system = new_forced_system(osc, r, load, clearance)
      !$omp parallel do schedule(dynamic, 64) num_threads(threads)
      do j = 1, size(starts, 2)
         if (is_stopped(progress)) cycle
         call follow(system, targets, starts(:, j), cycles, max_events, labels(j), impacts(j), &
            ends(:, j), progress)
         call add_done_work(1, progress)
      end do
      !$omp end parallel do
   end subroutine decide

   !> Simulates one state until it is in a neighbourhood.
   subroutine follow(system, targets, start, cycles, max_events, label, impacts, finish, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Motions with their neighbourhoods.
      type(target_type), intent(in) :: targets(:)
      !> t, x, x', z, z'
      real(wp), intent(in) :: start(5)
      !> Largest numbers of load cycles and of events simulated.
      integer, intent(in) :: cycles, max_events
      !> Number of the target, or as in `decide`; events simulated.
      integer, intent(out) :: label, impacts
      !> t (below a load cycle), x, x', z, z' at the end of the simulation.
      real(wp), intent(out) :: finish(5)
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      integer, parameter :: chunk = 16
      type(state_type) :: state, final
      type(event_type) :: events(chunk)
      integer(int64) :: last
      real(wp) :: phase
      integer :: n, i, left, status

      state = initial_state(system, start)
      left = max_events
      last = state%cycle + cycles
      phase = state%phase
      label = 0
      impacts = 0
      do
         call simulate_on(system, state, last, phase, events, n, final, left, status, progress, &
            looks_on=.false.)
         do i = 1, n
            impacts = impacts + 1
            label = neighbourhood_of(targets, events(i))
            if (label > 0) exit
         end do
         if (label > 0 .or. status /= stat%more_events) exit
      end do
      if (label == 0 .and. status == stat%event_limit) label = event_limited
      if (label == 0 .and. status == stat%not_computed) label = not_reached
      finish = [final%phase/system%r, final%x, final%x_dot, final%z, final%z_dot]
   end subroutine follow

   !> The number of the attractor whose neighbourhood contains an event; 0 if none.
   pure integer function neighbourhood_of(targets, event) result(label)
      !> Motions with their neighbourhoods.
      type(target_type), intent(in) :: targets(:)
      !> The event.
      type(event_type), intent(in) :: event
      real(wp) :: d(4)

      do label = 1, size(targets)
         associate (t => targets(label))
            if (t%side /= event%side .or. .not. t%radius > 0) cycle
            if (t%release .neqv. event%kind == release_event) cycle
            if (t%n > 2) then
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
