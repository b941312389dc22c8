!> Many simulations in one call: initial states or parameters spread over threads.
!!
!! Each simulation is one task that writes to its own place, so the results are identical to the
!! last bit for any number of threads.
module vi_bundle
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   use vi_oscillator, only: oscillator_type
   use vi_progress, only: add_done_work, add_expected_work
   use vi_simulate, only: forced_system_type, event_type, impact_event, new_forced_system, &
      simulate_on, state_type, stick_event
   use vi_status, only: stat
   use vi_trajectory, only: initial_state, later, pack_state
   implicit none (type, external)
   private

   public :: simulate_bundle

   !> Number of events found at a time; the events themselves are not kept.
   integer, parameter :: chunk = 256

contains

   !> Simulates m systems for a number of load cycles each.
   subroutine simulate_bundle(osc, r, load, clearance, cycles, most_events, threads, starts, ends, &
      counts, status, progress)
      !> Oscillator, the same for all.
      type(oscillator_type), intent(in) :: osc
      !> (m) Frequency ratios, load amplitudes f, clearances.
      real(wp), intent(in) :: r(:), load(:), clearance(:)
      !> Load cycles simulated, not necessarily whole.
      real(wp), intent(in) :: cycles
      !> Events after which a simulation ends, and number of OpenMP threads.
      integer, intent(in) :: most_events, threads
      !> (5, m) Initial states: t, x, x', z, z'.
      real(wp), intent(in) :: starts(:, :)
      !> (7, m) Final states, as in `pack_state`.
      real(wp), intent(out) :: ends(:, :)
      !> (2, m): impacts and rests.
      integer, intent(out) :: counts(:, :)
      !> (m): `stat%ok`, `stat%event_limit` if most_events were reached, `stat%budget`, or
      !! `stat%not_computed` if it was stopped.
      integer, intent(out) :: status(:)
      !> Progress counters, see vi_progress; each simulation is a unit of work.
      integer, intent(inout), optional :: progress(3)
      type(forced_system_type) :: system
      type(state_type) :: state
      integer :: contact(3), j

      call add_expected_work(size(r), progress)
      !$omp parallel do schedule(dynamic, 1) num_threads(threads) private(system, state, contact)
      do j = 1, size(r)
         system = new_forced_system(osc, r(j), load(j), clearance(j))
         state = initial_state(system, starts(:, j))
         call simulate_counting(system, state, cycles, most_events, counts(:, j), status(j), &
            progress)
         call pack_state(state, ends(:, j), contact)
         call add_done_work(1, progress)
      end do
      !$omp end parallel do
   end subroutine simulate_bundle

   !> One simulation; only the final state and the numbers of impacts and rests are kept.
   subroutine simulate_counting(system, state, cycles, most_events, counts, status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: the initial state. Out: the final one; if `most_events` were reached, the state after
      !! the last event.
      type(state_type), intent(inout) :: state
      !> Load cycles simulated.
      real(wp), intent(in) :: cycles
      !> Events after which the simulation ends.
      integer, intent(in) :: most_events
      !> Numbers of impacts and of rests; the status is that of `simulate_on`.
      integer, intent(out) :: counts(2), status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(event_type) :: events(chunk)
      type(state_type) :: final
      integer(int64) :: last_cycle
      real(wp) :: last_phase
      integer :: n, left

      call later(state, cycles, last_cycle, last_phase)
      counts = 0
      left = most_events
      do
         call simulate_on(system, state, last_cycle, last_phase, events, n, final, left, status, &
            progress)
         counts(1) = counts(1) + count(events(:n)%kind == impact_event)
         counts(2) = counts(2) + count(events(:n)%kind == stick_event)
         if (status /= stat%more_events) exit
      end do
      state = final
   end subroutine simulate_counting

end module vi_bundle
