!> Simulations of the oscillator.

!> The state (7), (3) of the core from t, x, x', z, z'; on a wall it may depart, rest or be about
!! to collide.
subroutine start_state(xi, r, load, clearance, start, state, contact)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_oscillator, only: oscillator_type
   use vi_simulate, only: new_forced_system
   use vi_trajectory, only: initial_state, pack_state
   implicit none (type, external)
   real(c_double), intent(in) :: xi, r, load, clearance, start(5)
   real(c_double), intent(out) :: state(7)
   integer(c_int), intent(out) :: contact(3)

   call pack_state(initial_state(new_forced_system(oscillator_type(xi), r, load, clearance), &
      start), state, contact)
end subroutine start_state

!> The least clearance of a simulation that starts with displacement x.
subroutine least_clearance(xi, r, load, x, least)
   use, intrinsic :: iso_c_binding, only: c_double
   use vi_forced_system, only: least_of => least_clearance, new_forced_system
   use vi_oscillator, only: oscillator_type
   implicit none (type, external)
   real(c_double), intent(in) :: xi, r, load, x
   real(c_double), intent(out) :: least

   least = least_of(new_forced_system(oscillator_type(xi), r, load, 1.0_c_double), x)
end subroutine least_clearance

!> Simulates from a state to an end of time, or until there are more than `capacity` events.
!!
!! `state` is (cycle, phase, x, x', z, z', departure speed), `contact` (side, resting, released).
!! `last_*` is where the last flight or rest began (going on from there is bit for bit), `end_*` the
!! end. A column of `table` is a record of an event: time, four words of `names` (right and left,
!! kind), phase, x, x' before and after, z' before and after.
subroutine simulate(xi, mu, walls, r, load, clearance, state, contact, last_cycle, last_phase, &
   names, capacity, table, n_events, last_state, last_contact, end_state, end_contact, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_trajectory, only: simulate_arrays
   use vi_oscillator, only: oscillator_type
   use vi_simulate, only: new_forced_system
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: contact(3), capacity
   real(c_double), intent(in) :: xi, mu, walls(2), r, load, clearance, state(7), last_cycle, &
      last_phase, names(4, 2, 3)
   real(c_double), intent(inout) :: table(11, capacity)
   real(c_double), intent(out) :: last_state(7), end_state(7)
   integer(c_int), intent(out) :: n_events, last_contact(3), end_contact(3), status

   last_state = state
   last_contact = contact
   call simulate_arrays(new_forced_system(oscillator_type(xi, mu, walls), r, load, clearance), &
      last_state, last_contact, last_cycle, last_phase, names, table, n_events, end_state, &
      end_contact, status)
end subroutine simulate

!> The time history of a trajectory: x, x', z, z', y and load at the given times.
subroutine sample_trajectory(n, m, xi, mu, r, load, clearance, starts, resting, times, values)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_oscillator, only: oscillator_type
   use vi_simulate, only: new_forced_system
   use vi_trajectory, only: sample_segments
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, m, resting(n)
   real(c_double), intent(in) :: xi, mu, r, load, clearance, starts(6, n), times(m)
   real(c_double), intent(out) :: values(6, m)

   call sample_segments(new_forced_system(oscillator_type(xi, mu), r, load, clearance), starts, &
      resting, times, values)
end subroutine sample_trajectory

!> The derivatives of a simulated trajectory; see vi_trajectory_gradient. The states at both ends as
!! `simulate` has them, the events as `end_of_trajectory`; the first `most` are read.
subroutine trajectory_gradient(n, most, xi, mu, walls, r, load, clearance, start, contact, finish, &
   finish_contact, values, labels, by_events, by_finish, good)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_forced_system, only: event_type, new_forced_system
   use vi_oscillator, only: oscillator_type
   use vi_trajectory, only: read_events, unpack_state
   use vi_trajectory_gradient, only: gradient => trajectory_gradient
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, most, contact(3), finish_contact(3), labels(2, n)
   real(c_double), intent(in) :: xi, mu, walls(2), r, load, clearance, start(7), finish(7), &
      values(7, n)
   real(c_double), intent(out) :: by_events(12, 6, n), by_finish(12, 5)
   integer(c_int), intent(out) :: good
   type(event_type), allocatable :: events(:)

   allocate (events(n))
   call read_events(values, labels, r, events)
   call gradient(new_forced_system(oscillator_type(xi, mu, walls), r, load, clearance), &
      unpack_state(start, contact), unpack_state(finish, finish_contact), events(:most), &
      by_events, by_finish, good)
end subroutine trajectory_gradient

!> The shortest period with which a trajectory ends, and its exact motion as `solve` asks for it.
!!
!! `of_simulation`, `values`, `labels` (its events), `solve`, and from `cycles` to `apart` (the
!! period) as of `end_arrays` in vi_settled_motion; then the motion as of `find_motion`.
subroutine end_of_trajectory(m, xi, mu, walls, r, load, clearance, of_simulation, values, labels, &
   most_cycles, tolerance, solve, capacity, cycles, n, symbols, first, apart, n_own, own_cycles, &
   own_sides, restitution, phases, impacts, scalars, multipliers, verdicts, n_events, own_values, &
   own_labels, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_int
   use vi_forced_system, only: new_forced_system
   use vi_found_motion, only: described_type, store_described
   use vi_oscillator, only: oscillator_type
   use vi_settled_motion, only: end_arrays
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: m, labels(2, m), most_cycles, solve, capacity
   real(c_double), intent(in) :: xi, mu, walls(2), r, load, clearance, of_simulation(4), &
      values(7, m), tolerance
   integer(c_int), intent(out) :: cycles, n, symbols(m), first(m), n_own, own_cycles, &
      own_sides(capacity), verdicts(3), n_events, own_labels(2, capacity), status
   real(c_double), intent(out) :: apart, restitution(capacity), phases(capacity), &
      impacts(capacity, 6), scalars(6), own_values(7, capacity)
   complex(c_double_complex), intent(out) :: multipliers(4)
   type(described_type) :: described

   call end_arrays(new_forced_system(oscillator_type(xi, mu, walls), r, load, clearance), &
      of_simulation, values, labels, most_cycles, tolerance, solve, cycles, n, symbols, first, &
      apart, described)
   call store_described(described, n_own, own_cycles, own_sides, restitution, phases, impacts, &
      scalars, multipliers, verdicts, n_events, own_values, own_labels, status)
end subroutine end_of_trajectory

!> Simulates many systems from t, x, x', z, z' for a number of load cycles: the final states as of
!! `simulate`, impacts and rests of each.
subroutine simulate_bundle(m, xi, mu, walls, r, load, clearance, cycles, most_events, threads, &
   starts, progress, ends, counts, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_bundle, only: run => simulate_bundle
   use vi_oscillator, only: oscillator_type
   use vi_processor, only: usable_threads
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: m, most_events, threads
   integer(c_int), intent(inout) :: progress(3)
   real(c_double), intent(in) :: xi, mu, walls(2), r(m), load(m), clearance(m), cycles, starts(5, m)
   real(c_double), intent(out) :: ends(7, m)
   integer(c_int), intent(out) :: counts(2, m), status(m)

   call run(oscillator_type(xi, mu, walls), r, load, clearance, cycles, most_events, &
      usable_threads(threads), starts, ends, counts, status, progress)
end subroutine simulate_bundle

!> What many systems do on the attractors of one initial state each.
subroutine perform(n, parameters, places, settling, keep, max_events, threads, wanted, progress, &
   found, ends, counts, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_attractor_performance, only: run => perform
   use vi_processor, only: usable_threads
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, settling, keep, max_events, threads, wanted(9)
   integer(c_int), intent(inout) :: progress(3)
   real(c_double), intent(in) :: parameters(6, n), places(4, n)
   real(c_double), intent(out) :: found(9, n), ends(5, n)
   integer(c_int), intent(out) :: counts(2, n), status(n)

   call run(parameters, places, settling, keep, max_events, usable_threads(threads), found, &
      ends, counts, status, progress, wanted /= 0)
end subroutine perform
