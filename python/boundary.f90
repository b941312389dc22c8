!> The only file that f2py reads: plain arrays and C kinds, no state, no defaults, no checks.
!!
!! Everything is checked in Python before it comes here. Shapes come first, results last, points are
!! on the last axis; the rows of the results are those of vi_points.

!> Motions with given phases at many points.
subroutine periodic(n, m, xi, mu, walls, r, cycles, sides, restitution, phases, acceptance, &
   single, flights, impacts, scalars, multipliers, verdicts, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_int
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_points, only: periodic_points
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, m, cycles, sides(n), single, flights
   real(c_double), intent(in) :: xi, mu, walls(2), r(m), restitution(n), phases(n, m), acceptance
   real(c_double), intent(out) :: impacts(n, 6, m), scalars(6, m)
   complex(c_double_complex), intent(out) :: multipliers(4, m)
   integer(c_int), intent(out) :: verdicts(3, m), status(m)

   call periodic_points(oscillator_type(xi, mu, walls), r, pattern_type(sides, cycles), &
      restitution, &
      phases, acceptance, single /= 0, flights /= 0, impacts, scalars, multipliers, verdicts, &
      status)
end subroutine periodic

!> Verdicts alone on motions with given phases (m, n) at many points; see vi_flags.
subroutine stability_flags(n, m, xi, mu, walls, r, cycles, sides, restitution, phases, acceptance, &
   with_radius, threads, wide, consistent, stable, radius, status, referred)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_flags, only: flags => stability_flags
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_processor, only: usable_threads
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, m, cycles, sides(n), with_radius, threads, wide
   real(c_double), intent(in) :: xi, mu, walls(2), r(m), restitution(n), phases(m, n), acceptance
   integer(c_int), intent(out) :: consistent(m), stable(m)
   real(c_double), intent(out) :: radius(m)
   integer(c_int), intent(out) :: status(m), referred

   call flags(oscillator_type(xi, mu, walls), r, pattern_type(sides, cycles), restitution, &
      phases, acceptance, with_radius /= 0, usable_threads(threads), wide /= 0, consistent, &
      stable, radius, status, referred)
end subroutine stability_flags

!> Both equispaced motions at many points; two columns a point.
subroutine equispaced(m, xi, mu, walls, r, clearance, cycles, acceptance, single, flights, &
   impacts, scalars, multipliers, verdicts, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_int
   use vi_oscillator, only: oscillator_type
   use vi_points, only: equispaced_points
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: m, cycles, single, flights
   real(c_double), intent(in) :: xi, mu, walls(2), r(m), clearance(m), acceptance
   real(c_double), intent(out) :: impacts(2, 6, 2*m), scalars(6, 2*m)
   complex(c_double_complex), intent(out) :: multipliers(4, 2*m)
   integer(c_int), intent(out) :: verdicts(3, 2*m), status(2*m)

   call equispaced_points(oscillator_type(xi, mu, walls), r, clearance, cycles, acceptance, &
      single /= 0, flights /= 0, impacts, scalars, multipliers, verdicts, status)
end subroutine equispaced

!> The equations (26), (30) for given phases, with clearance 1.
subroutine linear_system(n, xi, mu, r, cycles, sides, restitution, phases, matrix, rhs)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_motion, only: motion_type, start_motion
   use vi_periodic, only: assemble, linear_system_type
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, cycles, sides(n)
   real(c_double), intent(in) :: xi, mu, r, restitution(n), phases(n)
   real(c_double), intent(out) :: matrix(2*n, n + 2), rhs(2*n)
   type(linear_system_type) :: system
   type(motion_type) :: motion

   call start_motion(motion, oscillator_type(xi, mu), r, pattern_type(sides, cycles), restitution, &
      phases)
   call assemble(motion, system)
   matrix = system%matrix
   rhs = system%rhs
end subroutine linear_system

!> The matrices [P_i] of a motion.
subroutine impact_maps(n, xi, mu, r, cycles, sides, restitution, phases, impacts, amplitude, tau, &
   p, regular)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_impact_map, only: maps => impact_maps
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_points, only: recall
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, cycles, sides(n)
   real(c_double), intent(in) :: xi, mu, r, restitution(n), phases(n), impacts(n, 6), amplitude, tau
   real(c_double), intent(out) :: p(4, 4, n)
   integer(c_int), intent(out) :: regular
   logical :: good

   call maps(recall(oscillator_type(xi, mu), r, pattern_type(sides, cycles), restitution, phases, &
      impacts, amplitude, tau), p, good)
   regular = merge(1, 0, good)
end subroutine impact_maps

!> The quantities of an exact motion with n impacts and their derivatives; see vi_gradient.
subroutine motion_gradient(n, m, xi, mu, walls, r, load, clearance, cycles, sides, restitution, x, &
   theta, multipliers, values, slopes, codes, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_int
   use vi_exact, only: setting_type
   use vi_gradient, only: gradient => motion_gradient
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, m, cycles, sides(n)
   real(c_double), intent(in) :: xi, mu, walls(2), r, load, clearance, restitution(n), x(n), &
      theta(n)
   complex(c_double_complex), intent(in) :: multipliers(4)
   real(c_double), intent(out) :: values(m), slopes(8, m)
   integer(c_int), intent(out) :: codes(m), status

   call gradient(setting_type(oscillator_type(xi, mu, walls), r, load, clearance, &
      pattern_type(sides, cycles), restitution), x, theta, multipliers, values, slopes, codes, &
      status)
end subroutine motion_gradient

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

!> The time history of a motion: x, x', z, z', y and load at the given times.
subroutine sample(n, m, xi, mu, r, cycles, sides, restitution, phases, impacts, amplitude, tau, &
   times, values)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_points, only: recall
   use vi_sample, only: sample_motion
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, m, cycles, sides(n)
   real(c_double), intent(in) :: xi, mu, r, restitution(n), phases(n), impacts(n, 6), amplitude, tau
   real(c_double), intent(in) :: times(m)
   real(c_double), intent(out) :: values(6, m)

   call sample_motion(recall(oscillator_type(xi, mu), r, pattern_type(sides, cycles), restitution, &
      phases, impacts, amplitude, tau), times, values)
end subroutine sample

!> The sentence for a status code, as `length` bytes of `text`.
subroutine status_text(code, text, length)
   use, intrinsic :: iso_c_binding, only: c_char, c_int
   use vi_status, only: sentence => status_text
   implicit none (type, external)
   integer(c_int), intent(in) :: code
   character(kind=c_char), intent(out) :: text(200)
   integer(c_int), intent(out) :: length
   character(200) :: line

   line = sentence(code)
   text = transfer(line, text)
   length = len_trim(line)
end subroutine status_text

!> Runs namelist files; `paths` are separated by null characters, and so are the lines of what was
!! said (see vi_log), which is the message of the handle. `only` names the kind of cases to run
!! (blank: all).
subroutine run_namelists(n_paths, paths, n_folder, folder, only, progress, handle, status)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_batch, only: log_type, run_file
   use vi_buffer, only: add
   use vi_door, only: new_text
   use vi_text, only: line_type, split
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n_paths, n_folder
   character(kind=c_char), intent(in) :: paths(n_paths), folder(n_folder), only(16)
   integer(c_int), intent(inout) :: progress(3)
   integer(c_int64_t), intent(out) :: handle
   integer(c_int), intent(out) :: status
   type(log_type) :: log
   type(line_type), allocatable :: files(:)
   character(n_paths) :: all_paths
   character(n_folder) :: one_folder
   character(16) :: kind
   integer :: i

   all_paths = transfer(paths, all_paths)
   one_folder = transfer(folder, one_folder)
   kind = transfer(only, kind)
   allocate (files, source=split(all_paths, achar(0)))
   do i = 1, size(files)
      call run_file(files(i)%text, one_folder, log, trim(kind), progress)
   end do
   call add(log%said, '')
   call new_text(log%said%text(:log%said%n), handle)
   status = log%status
end subroutine run_namelists

!> The cases of a namelist file, each in the form that the header of its result has, as the message
!! of the handle. If the file is wrong, `status` is 2 and the message says why.
subroutine read_namelist(n_path, path, handle, status)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_batch, only: done, wrong
   use vi_buffer, only: add, buffer_type
   use vi_case, only: case_type, echo
   use vi_door, only: new_text
   use vi_read_cases, only: read_cases
   use vi_text, only: join, line_type, printable
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n_path
   character(kind=c_char), intent(in) :: path(n_path)
   integer(c_int64_t), intent(out) :: handle
   integer(c_int), intent(out) :: status
   type(case_type), allocatable :: cases(:)
   type(line_type), allocatable :: lines(:)
   type(buffer_type) :: text
   character(n_path) :: one_path
   character(:), allocatable :: message
   integer :: i

   one_path = transfer(path, one_path)
   call read_cases(one_path, cases, message)
   status = merge(wrong, done, len(message) > 0)
   call add(text, printable(message))
   do i = 1, size(cases)
      if (status == wrong) exit
      call echo(cases(i), lines)
      call add(text, join(lines, achar(10))//achar(10))
   end do
   call new_text(text%text(:text%n), handle)
end subroutine read_namelist

!> Runs the one case of a namelist text; see vi_door. Who gets the handle frees it, once.
subroutine run_case(n, text, threads, progress, handle, status)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_door, only: run_text
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, threads
   character(kind=c_char), intent(in) :: text(n)
   integer(c_int), intent(inout) :: progress(3)
   integer(c_int64_t), intent(out) :: handle
   integer(c_int), intent(out) :: status
   character(n) :: one_case

   one_case = transfer(text, one_case)
   call run_text(one_case, threads, handle, status, progress)
end subroutine run_case

!> What a result holds, as JSON: `text` has room for `capacity` bytes, `length` tells how many are
!! wanted.
subroutine describe_result(handle, capacity, text, length)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_door, only: describe => describe_result
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int64_t), intent(in) :: handle
   integer(c_int), intent(in) :: capacity
   character(kind=c_char), intent(out) :: text(capacity)
   integer(c_int), intent(out) :: length
   character(:), allocatable :: json
   integer :: i

   call describe(handle, json)
   length = len(json)
   text = ' '
   do i = 1, min(length, capacity)
      text(i) = json(i:i)
   end do
end subroutine describe_result

!> Frees a result.
subroutine free_result(handle)
   use, intrinsic :: iso_c_binding, only: c_int64_t
   use vi_door, only: free => free_result
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int64_t), intent(in) :: handle

   call free(handle)
end subroutine free_result

!> A result without tables for the case of a namelist text, or for a study if no namelist gives the
!! result and the text is blank; see vi_door.
subroutine new_result(n, text, study, handle, status)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_door, only: done, new => new_result, new_bare_result
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n
   character(kind=c_char), intent(in) :: text(n), study(20)
   integer(c_int64_t), intent(out) :: handle
   integer(c_int), intent(out) :: status
   character(n) :: one_case
   character(20) :: name

   one_case = transfer(text, one_case)
   name = transfer(study, name)
   status = done
   if (len_trim(one_case) == 0) then
      call new_bare_result(trim(name), handle)
   else
      call new(one_case, handle, status)
   end if
end subroutine new_result

!> Opens a table: `names` are its own, its parent's (blank if it has none) and its dimensions'.
subroutine open_table(handle, names, n, sizes, m, owners)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_door, only: open_one => open_table
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int64_t), intent(in) :: handle
   character(kind=c_char), intent(in) :: names(96)
   integer(c_int), intent(in) :: n, sizes(n), m, owners(m)
   character(96) :: line

   line = transfer(names, line)
   call open_one(handle, trim(line(:16)), trim(line(33:)), sizes, trim(line(17:32)), owners)
end subroutine open_table

!> Fills a column of numbers: `names` are its table's and its own.
subroutine fill_reals(handle, names, n, values)
   use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_int64_t
   use vi_door, only: fill => fill_reals
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int64_t), intent(in) :: handle
   character(kind=c_char), intent(in) :: names(40)
   integer(c_int), intent(in) :: n
   real(c_double), intent(in) :: values(n)
   character(40) :: line

   line = transfer(names, line)
   call fill(handle, trim(line(:16)), trim(line(17:)), values)
end subroutine fill_reals

!> Fills a column of all else; `words` with line feeds between, one blank if there are none.
subroutine fill_wholes(handle, names, n, values, m, words)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_door, only: fill => fill_wholes
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int64_t), intent(in) :: handle
   character(kind=c_char), intent(in) :: names(40)
   integer(c_int), intent(in) :: n, values(n), m
   character(kind=c_char), intent(in) :: words(m)
   character(40) :: line
   character(m) :: list

   line = transfer(names, line)
   list = transfer(words, list)
   call fill(handle, trim(line(:16)), trim(line(17:)), values, trim(list))
end subroutine fill_wholes

!> Says what there is to say of a result: a line on how it was cut short (or none), then remarks; a
!! line feed stands behind each.
subroutine add_notes_of(handle, n, text)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_door, only: add_notes => add_notes_of
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int64_t), intent(in) :: handle
   integer(c_int), intent(in) :: n
   character(kind=c_char), intent(in) :: text(n)
   character(n) :: lines
   integer :: first

   lines = transfer(text, lines)
   first = index(lines, new_line('a'))
   call add_notes(handle, lines(:first - 1), lines(first + 1:))
end subroutine add_notes_of

!> Writes a result as CSV; `message` says what went wrong, with blanks behind it.
subroutine write_result(handle, n, path, progress, message)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_door, only: name_after, result_of
   use vi_result, only: result_type
   use vi_text, only: line_type
   use vi_write_csv, only: write_csv
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int64_t), intent(in) :: handle
   integer(c_int), intent(in) :: n
   character(kind=c_char), intent(in) :: path(n)
   integer(c_int), intent(inout) :: progress(3)
   character(kind=c_char), intent(out) :: message(400)
   type(result_type), pointer :: result
   type(line_type), allocatable :: case(:)
   character(n) :: name
   character(400) :: line
   character(:), allocatable :: reason

   name = transfer(path, name)
   result => result_of(handle)
   call name_after(result, name, case)
   call write_csv(result, name, reason, progress, case=case)
   line = reason
   message = transfer(line, message)
end subroutine write_result

!> Writes the motions of a result as a printout; `message` as of `write_result`.
subroutine write_printout(handle, n, path, message)
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t
   use vi_door, only: result_of
   use vi_files, only: write_file
   use vi_parse_cases, only: find_name
   use vi_printout, only: print_motions
   use vi_result, only: result_type
   use vi_text, only: line_type
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int64_t), intent(in) :: handle
   integer(c_int), intent(in) :: n
   character(kind=c_char), intent(in) :: path(n)
   character(kind=c_char), intent(out) :: message(400)
   type(result_type), pointer :: result
   type(line_type), allocatable :: lines(:)
   character(n) :: name
   character(400) :: line
   character(:), allocatable :: stem, reason

   name = transfer(path, name)
   result => result_of(handle)
   call find_name(name, 1, 1, stem)
   call print_motions(stem, result, lines)
   call write_file(name, lines, reason)
   line = reason
   message = transfer(line, message)
end subroutine write_printout

!> The language of namelists and the columns of all results, as JSON.
subroutine describe_language(capacity, text, length)
   use, intrinsic :: iso_c_binding, only: c_char, c_int
   use vi_describe, only: describe_all
   use vi_text, only: join, line_type
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: capacity
   character(kind=c_char), intent(out) :: text(capacity)
   integer(c_int), intent(out) :: length
   type(line_type), allocatable :: lines(:)
   character(:), allocatable :: json
   integer :: i

   call describe_all(lines)
   json = join(lines, new_line('a'))
   length = len(json)
   text = ' '
   do i = 1, min(length, capacity)
      text(i) = json(i:i)
   end do
end subroutine describe_language

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

!> Simulates a structure with gaps from a state to an end of time, or until there are more than
!! `capacity` events.
!!
!! `matrices` are M, C, K; `gap_values` as in `new_structure`; `loads` the cosine and sine parts of
!! each harmonic; `record` samples of a force every `step` (0: no record). A column of `table` is
!! time, approach speed, impulse, coordinates and velocities just after an event; one of `labels`
!! its kind and gap.
subroutine simulate_structure(n, gaps, width, harmonics, samples, matrices, directions, &
   gap_values, frequency, loads, constant, step, record, start, state, last, capacity, table, &
   labels, n_events, end_state, end_time, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_structure, only: new_load, new_structure
   use vi_structure_trajectory, only: simulate_structure_arrays
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, gaps, width, harmonics, samples, capacity
   real(c_double), intent(in) :: matrices(n, n, 3), directions(n, gaps), gap_values(width, gaps), &
      frequency, loads(n, 2, harmonics), constant(n), step, record(n, samples), start, &
      state(2*n), last
   real(c_double), intent(inout) :: table(2*n + 3, capacity)
   integer(c_int), intent(inout) :: labels(2, capacity)
   integer(c_int), intent(out) :: n_events, status
   real(c_double), intent(out) :: end_state(2*n), end_time

   call simulate_structure_arrays(new_structure(matrices, directions, gap_values), &
      new_load(frequency, loads, constant, step, record), start, state(:n), state(n + 1:), last, &
      table, labels, n_events, end_state, end_time, status)
end subroutine simulate_structure

!> Coordinates and velocities of a structure at the given times, which ascend.
subroutine sample_structure(n, gaps, width, harmonics, samples, m, k, matrices, directions, &
   gap_values, frequency, loads, constant, step, record, starts, labels, times, values, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_structure, only: new_load, new_structure
   use vi_structure_trajectory, only: sample_structure_arrays
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, gaps, width, harmonics, samples, m, k, labels(2, m)
   real(c_double), intent(in) :: matrices(n, n, 3), directions(n, gaps), gap_values(width, gaps), &
      frequency, loads(n, 2, harmonics), constant(n), step, record(n, samples), &
      starts(2*n + 1, m), times(k)
   real(c_double), intent(out) :: values(2*n, k)
   integer(c_int), intent(out) :: status

   call sample_structure_arrays(new_structure(matrices, directions, gap_values), &
      new_load(frequency, loads, constant, step, record), starts, labels, times, values, status)
end subroutine sample_structure

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

!> The exact motion near a guess of x_i and theta_i = alpha_i + tau, by Newton's method.
subroutine exact(n, xi, mu, walls, r, load, clearance, cycles, sides, restitution, x, theta, &
   most, phases, impacts, scalars, multipliers, verdicts, status, iterations)
   use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_int
   use vi_exact, only: setting_type
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_points, only: exact_point
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, cycles, sides(n), most
   real(c_double), intent(in) :: xi, mu, walls(2), r, load, clearance, restitution(n), x(n), &
      theta(n)
   real(c_double), intent(out) :: phases(n), impacts(n, 6), scalars(6)
   complex(c_double_complex), intent(out) :: multipliers(4)
   integer(c_int), intent(out) :: verdicts(3), status, iterations

   call exact_point(setting_type(oscillator_type(xi, mu, walls), r, load, clearance, &
      pattern_type(sides, cycles), restitution), x, theta, most, phases, impacts, scalars, &
      multipliers, verdicts, status, iterations)
end subroutine exact

!> An exact motion near a guess, as it is given (form 0), in standard form (1) or as the mirror
!! image in standard form (2). `changed` is 0 if it is given in standard form.
!!
!! Without rest it is given by sides and x_i, theta_i of its n impacts (and `releases` is a column
!! of zeros), with rest by side, phase and velocity of its m releases (and one impact of side 0).
!! Its own arrays are those of `exact`, an impact for each of `n_own` symbols; with rest there are
!! the events of one period, too, the last one the release that is given last.
subroutine find_motion(n, m, xi, mu, walls, r, load, clearance, cycles, sides, unknowns, releases, &
   form, capacity, changed, n_own, own_cycles, own_sides, restitution, phases, impacts, scalars, &
   multipliers, verdicts, n_events, values, labels, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_int
   use vi_forced_system, only: new_forced_system
   use vi_found_motion, only: described_type, find_in_form, found_from, store_described
   use vi_oscillator, only: oscillator_type
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, m, cycles, sides(n), form, capacity
   real(c_double), intent(in) :: xi, mu, walls(2), r, load, clearance, unknowns(2*n), releases(3, m)
   integer(c_int), intent(out) :: changed, n_own, own_cycles, own_sides(capacity), verdicts(3), &
      n_events, labels(2, capacity), status
   real(c_double), intent(out) :: restitution(capacity), phases(capacity), impacts(capacity, 6), &
      scalars(6), values(7, capacity)
   complex(c_double_complex), intent(out) :: multipliers(4)
   type(described_type) :: described
   logical :: differs

   call find_in_form(new_forced_system(oscillator_type(xi, mu, walls), r, load, clearance), &
      found_from(cycles, sides, unknowns, releases), form, differs, described)
   changed = merge(1, 0, differs)
   call store_described(described, n_own, own_cycles, own_sides, restitution, phases, impacts, &
      scalars, multipliers, verdicts, n_events, values, labels, status)
end subroutine find_motion

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

!> The motions that begin at a bifurcation of a motion without rest: see vi_branch_switching.
!!
!! `kind`, `flight` and `side`, `parameter` and `tied` as there; `systems` has r, D, xi, mu, R1, R2.
subroutine switch_branch(n, xi, mu, r, cycles, sides, restitution, phases, impacts, amplitude, &
   tau, walls, clearance, kind, flight, side, parameter, tied, found, lengths, all_cycles, &
   all_sides, systems, all_phases, all_impacts, scalars, multipliers, verdicts)
   use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_int
   use vi_branch_switching, only: switch_arrays
   use vi_motion, only: motion_type
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_points, only: recall
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, cycles, sides(n), kind, flight, side, parameter, tied
   real(c_double), intent(in) :: xi, mu, r, restitution(n), phases(n), impacts(n, 6), amplitude, &
      tau, walls(2), clearance
   integer(c_int), intent(out) :: found, lengths(2), all_cycles(2), all_sides(2*n + 2, 2), &
      verdicts(3, 2)
   real(c_double), intent(out) :: systems(6, 2), all_phases(2*n + 2, 2), &
      all_impacts(2*n + 2, 6, 2), scalars(6, 2)
   complex(c_double_complex), intent(out) :: multipliers(4, 2)
   type(motion_type) :: motion

   motion = recall(oscillator_type(xi, mu, walls), r, pattern_type(sides, cycles), restitution, &
      phases, impacts, amplitude, tau)
   motion%clearance = clearance
   call switch_arrays(motion, kind, flight, side, parameter, tied /= 0, found, lengths, &
      all_cycles, all_sides, systems, all_phases, all_impacts, scalars, multipliers, verdicts)
end subroutine switch_branch

!> The patterns that a search goes through: impacts and load cycles of each, and its sides, 1 for
!! right and 2 for left.
subroutine side_patterns(max_impacts, max_cycles, alike, capacity, n, impacts, cycles, sides)
   use, intrinsic :: iso_c_binding, only: c_int
   use vi_pattern, only: pattern_type
   use vi_pattern_list, only: patterns_of => side_patterns
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: max_impacts, max_cycles, alike, capacity
   integer(c_int), intent(out) :: n, impacts(capacity), cycles(capacity), sides(max_impacts, &
      capacity)
   type(pattern_type), allocatable :: patterns(:)
   integer :: i

   allocate (patterns, source=patterns_of(max_impacts, max_cycles, alike /= 0))
   sides = 0
   n = min(capacity, size(patterns))
   do i = 1, n
      cycles(i) = patterns(i)%cycles
      impacts(i) = size(patterns(i)%sides)
      sides(:impacts(i), i) = merge(1, 2, patterns(i)%sides > 0)
   end do
end subroutine side_patterns

!> Whether two motions, each given as of `find_motion`, are one; or one and the mirror image of the
!! other.
subroutine same_motion(n, m, xi, r, load, clearance, cycles, sides, unknowns, releases, &
   other_sides, other_unknowns, other_releases, mirror, are_one)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_forced_system, only: new_forced_system
   use vi_found_motion, only: are_alike, found_from
   use vi_oscillator, only: oscillator_type
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, m, cycles, sides(n), other_sides(n), mirror
   real(c_double), intent(in) :: xi, r, load, clearance, unknowns(2*n), releases(3, m), &
      other_unknowns(2*n), other_releases(3, m)
   integer(c_int), intent(out) :: are_one

   are_one = merge(1, 0, are_alike(new_forced_system(oscillator_type(xi), r, load, clearance), &
      found_from(cycles, sides, unknowns, releases), &
      found_from(cycles, other_sides, other_unknowns, other_releases), mirror /= 0))
end subroutine same_motion

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

!> Simulates many systems for a number of load cycles: final states, impacts and rests of each.
subroutine simulate_bundle(m, xi, mu, walls, r, load, clearance, cycles, most_events, threads, &
   states, contacts, progress, end_states, end_contacts, counts, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_bundle, only: run => simulate_bundle
   use vi_oscillator, only: oscillator_type
   use vi_processor, only: usable_threads
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: m, most_events, threads, contacts(3, m)
   integer(c_int), intent(inout) :: progress(3)
   real(c_double), intent(in) :: xi, mu, walls(2), r(m), load(m), clearance(m), cycles, states(7, m)
   real(c_double), intent(out) :: end_states(7, m)
   integer(c_int), intent(out) :: end_contacts(3, m), counts(2, m), status(m)

   end_states = states
   end_contacts = contacts
   call run(oscillator_type(xi, mu, walls), r, load, clearance, cycles, most_events, &
      usable_threads(threads), end_states, end_contacts, counts, status, progress)
end subroutine simulate_bundle

!> What many systems do on the attractors of one initial state each.
subroutine perform(n, parameters, places, settling, keep, max_events, threads, progress, found, &
   ends, counts, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_attractor_performance, only: run => perform
   use vi_processor, only: usable_threads
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, settling, keep, max_events, threads
   integer(c_int), intent(inout) :: progress(3)
   real(c_double), intent(in) :: parameters(6, n), places(4, n)
   real(c_double), intent(out) :: found(7, n), ends(5, n)
   integer(c_int), intent(out) :: counts(2, n), status(n)

   call run(parameters, places, settling, keep, max_events, usable_threads(threads), found, &
      ends, counts, status, progress)
end subroutine perform

!> Displacements of vertices of a zone's boundary for changed parameters; rows and codes as in
!! vi_boundary_shift.
subroutine shift_boundary(n, v, most, s, xi, mu, walls, cycles, sides, symmetric, window, types, &
   indices, places, x, theta, changes, threads, progress, normals, slopes, shifts, outcomes, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_boundary_shift, only: run => shift_boundary
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_processor, only: usable_threads
   use vi_zone_request, only: zone_request_type
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, v, most, s, cycles, sides(n), symmetric, types(v), indices(v), &
      threads
   integer(c_int), intent(inout) :: progress(3)
   real(c_double), intent(in) :: xi, mu, walls(2), window(2, 2), places(2, v), x(most, v), &
      theta(most, v), changes(6, s)
   real(c_double), intent(out) :: normals(2, v), slopes(6, v), shifts(s, v)
   integer(c_int), intent(out) :: outcomes(s, v), status(v)

   call run(zone_request_type(oscillator_type(xi, mu, walls), pattern_type(sides, cycles), &
      symmetric /= 0, window(:, 1), window(:, 2)), types, indices, places, x, theta, changes, &
      usable_threads(threads), normals, slopes, shifts, outcomes, status, progress)
end subroutine shift_boundary

!> Both equispaced motions at each (clearance, r) of a grid; rows as in vi_chart.
subroutine equispaced_chart(m, n, xi, mu, walls, r, clearance, cycles, with_multipliers, threads, &
   scalars, multipliers, verdicts, status)
   use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_int
   use vi_chart, only: chart => equispaced_chart
   use vi_oscillator, only: oscillator_type
   use vi_processor, only: usable_threads
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: m, n, cycles, with_multipliers, threads
   real(c_double), intent(in) :: xi, mu, walls(2), r(n), clearance(m)
   real(c_double), intent(out) :: scalars(4, 2, m, n)
   complex(c_double_complex), intent(out) :: multipliers(4, 2, m, n)
   integer(c_int), intent(out) :: verdicts(3, 2, m, n), status(2, m, n)

   call chart(oscillator_type(xi, mu, walls), r, clearance, cycles, with_multipliers /= 0, &
      usable_threads(threads), scalars, multipliers, verdicts, status)
end subroutine equispaced_chart

!> How often a polygon goes round points, counter-clockwise in the plane (r, log D).
subroutine winding(n, m, ring, points, turns)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_rings, only: run => winding
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, m
   real(c_double), intent(in) :: ring(2, n), points(2, m)
   integer(c_int), intent(out) :: turns(m)

   turns = run(ring, points)
end subroutine winding


!> Numbers from low to high, with equal differences or (1) equal ratios.
subroutine spaced(n, low, high, geometric, values)
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use vi_spacing, only: spaced_values => spaced
   implicit none (type, external)
   integer(c_int), intent(in) :: n, geometric
   real(c_double), intent(in) :: low, high
   real(c_double), intent(out) :: values(n)

   values = spaced_values(low, high, n, geometric /= 0)
end subroutine spaced
