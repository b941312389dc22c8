!> Boundaries in the plane (r, D), and values along its axes.

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
