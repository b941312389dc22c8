!> Simulations and periodic motions of structures.

!> Simulates a structure with gaps from a state to an end of time, or until there are more than
!! `capacity` events.
!!
!! `matrices` are M, C, K; `gap_values` as in `new_structure`; `loads` the cosine and sine parts of
!! each harmonic; `record` samples of a force every `step` (0: no record). A column of `table` is
!! time, approach speed, impulse, coordinates and velocities just after an event; one of `labels`
!! its kind and gap. Events are kept from the time `first` on, when the state is `first_state`;
!! `resting` tells which gaps rest from then on to the end.
subroutine simulate_structure(n, gaps, width, harmonics, samples, matrices, directions, &
   gap_values, frequency, loads, constant, step, record, start, state, first, last, capacity, &
   table, labels, n_events, first_state, end_state, end_time, resting, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_structure, only: new_load, new_structure
   use vi_structure_trajectory, only: simulate_structure_arrays
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, gaps, width, harmonics, samples, capacity
   real(c_double), intent(in) :: matrices(n, n, 3), directions(n, gaps), gap_values(width, gaps), &
      frequency, loads(n, 2, harmonics), constant(n), step, record(n, samples), start, &
      state(2*n), first, last
   real(c_double), intent(inout) :: table(2*n + 3, capacity)
   integer(c_int), intent(inout) :: labels(2, capacity)
   integer(c_int), intent(out) :: n_events, resting(gaps), status
   real(c_double), intent(out) :: first_state(2*n), end_state(2*n), end_time

   call simulate_structure_arrays(new_structure(matrices, directions, gap_values), &
      new_load(frequency, loads, constant, step, record), start, state(:n), state(n + 1:), last, &
      table, labels, n_events, end_state, end_time, status, first, first_state, resting)
end subroutine simulate_structure

!> The first gap, from 1, that is too narrow for a simulation from a state, and the least opening,
!! or sum of openings, that is allowed; 0 if there is none.
subroutine narrow_gap(n, gaps, width, harmonics, matrices, directions, gap_values, frequency, &
   loads, constant, q, gap, least)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_structure, only: new_load, new_structure
   use vi_structure_gaps, only: narrow_gap_of => narrow_gap
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, gaps, width, harmonics
   real(c_double), intent(in) :: matrices(n, n, 3), directions(n, gaps), gap_values(width, gaps), &
      frequency, loads(n, 2, harmonics), constant(n), q(n)
   integer(c_int), intent(out) :: gap
   real(c_double), intent(out) :: least

   call narrow_gap_of(new_structure(matrices, directions, gap_values), &
      new_load(frequency, loads, constant), q, gap, least)
end subroutine narrow_gap

!> Coordinates, velocities and, with `parts` 3 and not 2, accelerations of a structure at the given
!! times, which ascend.
subroutine sample_structure(n, gaps, width, harmonics, samples, m, k, matrices, directions, &
   gap_values, frequency, loads, constant, step, record, starts, labels, times, parts, values, &
   status)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_structure, only: new_load, new_structure
   use vi_structure_trajectory, only: sample_structure_arrays
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, gaps, width, harmonics, samples, m, k, labels(2, m), parts
   real(c_double), intent(in) :: matrices(n, n, 3), directions(n, gaps), gap_values(width, gaps), &
      frequency, loads(n, 2, harmonics), constant(n), step, record(n, samples), &
      starts(2*n + 1, m), times(k)
   real(c_double), intent(out) :: values(parts*n, k)
   integer(c_int), intent(out) :: status

   call sample_structure_arrays(new_structure(matrices, directions, gap_values), &
      new_load(frequency, loads, constant, step, record), starts, labels, times, values, status)
end subroutine sample_structure

!> Response quantities of a structure over a window of time, as of `quantities_of`.
!!
!! A row of `numbers` is mean, rms, least and greatest value, one of `parts` the complex amplitudes
!! of the harmonics; the rows are coordinates, velocities, accelerations and forces of springs and
!! dashpots. `energies` are the work of the load and of belts, the losses of dashpots and where
!! rests begin, the change of energy, and the loss of friction. With `share` less than 1, nothing
!! was computed: so much of the window would not be too long.
subroutine structure_quantities(n, gaps, width, harmonics, samples, m, matrices, directions, &
   gap_values, frequency, loads, constant, step, record, starts, labels, window, orders, numbers, &
   parts, energies, share, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_int
   use vi_quantities, only: quantities_of
   use vi_structure, only: new_load, new_structure
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, gaps, width, harmonics, samples, m, labels(2, m), orders
   real(c_double), intent(in) :: matrices(n, n, 3), directions(n, gaps), gap_values(width, gaps), &
      frequency, loads(n, 2, harmonics), constant(n), step, record(n, samples), &
      starts(2*n + 1, m), window(2)
   real(c_double), intent(out) :: numbers(4*n, 4), energies(5), share
   complex(c_double_complex), intent(out) :: parts(4*n, orders)
   integer(c_int), intent(out) :: status

   call quantities_of(new_structure(matrices, directions, gap_values), &
      new_load(frequency, loads, constant, step, record), starts, labels, window, numbers, parts, &
      energies, share, status)
end subroutine structure_quantities

!> Derivatives of a simulated motion of a structure by its start and by parameters, as of
!! `gradient_arrays`; number 1 of the parameters changes nothing.
!!
!! `starts` and `labels` are as of `sample_structure`, `speeds` approach speeds. `first` is the gap
!! of the impact just before a period, of which the clock shows the load phase, and 0 of other
!! motions; `touched` is the event after the first flight that touches a wall, 0 for none.
subroutine structure_gradient(n, gaps, width, harmonics, samples, e, p, m, matrices, directions, &
   gap_values, frequency, loads, constant, step, record, entries, by_entries, by_record, by_start, &
   starts, labels, speeds, last, first, touched, sizes, values, finals, products, slopes, rates, &
   opens, good, code, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_structure, only: new_load, new_structure
   use vi_structure_gradient, only: events_type, gradient_arrays
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, gaps, width, harmonics, samples, e, p, m, entries(3, e), &
      labels(2, m), first, touched
   real(c_double), intent(in) :: matrices(n, n, 3), directions(n, gaps), gap_values(width, gaps), &
      frequency, loads(n, 2, harmonics), constant(n), step, record(n, samples), &
      by_entries(e, p), by_record(p), by_start(2*n, p), starts(2*n + 1, m), speeds(m), last, &
      sizes(2*n)
   real(c_double), intent(out) :: values(2*n + 3, m, p), finals(2*n, p), products(2*n, 2*n, p), &
      slopes(2*n + 3, 2*n, m), rates(2*n, 2)
   integer(c_int), intent(out) :: opens(p), good, code, status
   type(events_type) :: events
   logical :: open(p)

   allocate (events%starts, source=starts)
   allocate (events%labels, source=labels)
   allocate (events%speeds, source=speeds)
   allocate (events%sizes, source=sizes)
   events%end = last
   events%first = first
   events%touched = touched
   call gradient_arrays(new_structure(matrices, directions, gap_values), new_load(frequency, &
      loads, constant, step, record), entries, by_entries, by_record, by_start, events, values, &
      finals, products, slopes, rates, open, good, code, status)
   opens = merge(1, 0, open)
end subroutine structure_gradient

!> Fills in the states (time, coordinates and velocities) of a motion where rests begin and end.
subroutine complete_rests(n, gaps, width, harmonics, m, matrices, directions, gap_values, &
   frequency, loads, constant, labels, starts, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_structure, only: new_load, new_structure
   use vi_structure_trajectory, only: complete => complete_rests
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, gaps, width, harmonics, m, labels(2, m)
   real(c_double), intent(in) :: matrices(n, n, 3), directions(n, gaps), gap_values(width, gaps), &
      frequency, loads(n, 2, harmonics), constant(n)
   real(c_double), intent(inout) :: starts(2*n + 1, m)
   integer(c_int), intent(out) :: status

   call complete(new_structure(matrices, directions, gap_values), &
      new_load(frequency, loads, constant), labels, starts, status)
end subroutine complete_rests

!> Whether each gap rests from the start of a trajectory, given by time, coordinates and velocities:
!! 1 or 0.
subroutine resting_at_start(n, gaps, width, harmonics, samples, matrices, directions, gap_values, &
   frequency, loads, constant, step, record, start, rests, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_structure, only: new_load, new_structure
   use vi_structure_trajectory, only: at_start => resting_at_start
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, gaps, width, harmonics, samples
   real(c_double), intent(in) :: matrices(n, n, 3), directions(n, gaps), gap_values(width, gaps), &
      frequency, loads(n, 2, harmonics), constant(n), step, record(n, samples), start(2*n + 1)
   integer(c_int), intent(out) :: rests(gaps), status
   logical :: found(gaps)

   call at_start(new_structure(matrices, directions, gap_values), &
      new_load(frequency, loads, constant, step, record), start, found, status)
   rests = merge(1, 0, found)
end subroutine resting_at_start

!> A periodic motion of a structure from presumed load phases of its impacts: from the linear
!! problem (`wanted` 0; 1 with the state among the unknowns), or exact (2).
!!
!! Columns of `impacts` are load phases, approach speeds, impulses; a column of `states` is the
!! coordinates and velocities just after an impact; `scalars` are the residual, det[P] and the value
!! that it must have.
subroutine periodic_structure(n, gaps, width, harmonics, m, matrices, directions, gap_values, &
   frequency, loads, constant, at, phases, cycles, wanted, impacts, states, p, multipliers, &
   scalars, &
   verdicts, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_int
   use vi_structure, only: new_load, new_structure
   use vi_structure_period, only: periodic_structure_arrays
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, gaps, width, harmonics, m, at(m), cycles, wanted
   real(c_double), intent(in) :: matrices(n, n, 3), directions(n, gaps), gap_values(width, gaps), &
      frequency, loads(n, 2, harmonics), constant(n), phases(m)
   real(c_double), intent(out) :: impacts(m, 3), states(2*n, m), p(2*n, 2*n), &
      scalars(3)
   complex(c_double_complex), intent(out) :: multipliers(2*n)
   integer(c_int), intent(out) :: verdicts(3), status

   call periodic_structure_arrays(new_structure(matrices, directions, gap_values), &
      new_load(frequency, loads, constant), at, phases, cycles, wanted, impacts, states, p, &
      multipliers, scalars, verdicts, status)
end subroutine periodic_structure

!> The periodic motion of a structure on which a simulation from a state settles, with rest too.
!!
!! `counts` are its impacts, load cycles, and rests; impacts and states as in `periodic_structure`.
!! `labels` holds the gaps of the impacts and of the rests, a column of `rests` the load phases at
!! which one begins and ends.
subroutine settle_structure(n, gaps, width, harmonics, matrices, directions, gap_values, &
   frequency, &
   loads, constant, start, state, settling, most_cycles, cycles, capacity, counts, labels, &
   impacts, states, rests, p, multipliers, scalars, verdicts, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_int
   use vi_structure, only: new_load, new_structure
   use vi_structure_return, only: settle_arrays
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, gaps, width, harmonics, settling, most_cycles, cycles, &
      capacity
   real(c_double), intent(in) :: matrices(n, n, 3), directions(n, gaps), gap_values(width, gaps), &
      frequency, loads(n, 2, harmonics), constant(n), start, state(2*n)
   integer(c_int), intent(out) :: counts(3), labels(2, capacity), verdicts(3), status
   real(c_double), intent(out) :: impacts(capacity, 3), states(2*n, capacity), rests(2, capacity), &
      p(2*n, 2*n), scalars(3)
   complex(c_double_complex), intent(out) :: multipliers(2*n)

   call settle_arrays(new_structure(matrices, directions, gap_values), &
      new_load(frequency, loads, constant), start, state, settling, most_cycles, cycles, counts, &
      labels, impacts, states, rests, p, multipliers, scalars, verdicts, status)
end subroutine settle_structure

!> Whether the impacts of two periodic motions of a structure are the same: 1 or 0.
subroutine same_impacts(n, m, gaps, phases, speeds, other_gaps, other_phases, other_speeds, &
   cycles, rests, same)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_structure_found, only: motions_match => same_impacts
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, m, gaps(n), other_gaps(m), cycles, rests
   real(c_double), intent(in) :: phases(n), speeds(n), other_phases(m), other_speeds(m)
   integer(c_int), intent(out) :: same

   same = merge(1, 0, motions_match(gaps, phases, speeds, other_gaps, other_phases, other_speeds, &
      cycles, rests > 0))
end subroutine same_impacts

!> R(v) and its slope at m speeds, for a law given as in `new_restitution`.
subroutine restitution_values(width, m, kind, numbers, speeds, values, slopes)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_restitution, only: new_restitution, restitution_at, restitution_type
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: width, m
   real(c_double), intent(in) :: kind, numbers(width), speeds(m)
   real(c_double), intent(out) :: values(m), slopes(m)
   type(restitution_type) :: law
   integer :: i

   law = new_restitution(kind, numbers)
   do i = 1, m
      call restitution_at(law, speeds(i), values(i), slopes(i))
   end do
end subroutine restitution_values
