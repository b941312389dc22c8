!> Periodic motions of the oscillator: from given phases, exact, their derivatives, comparisons.
!! The rows of the results are those of vi_points.

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
