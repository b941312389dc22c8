!> The only file that f2py reads: plain arrays and C kinds, no state, no defaults, no checks.
!!
!! Everything is checked in Python before it comes here. Shapes come first, results last, points are on
!! the last axis; the rows of the results are those of vi_points.

!> Motions with given phases at many points.
subroutine periodic(n, m, xi, mu, walls, r, cycles, sides, restitution, phases, acceptance, single, &
      flights, impacts, scalars, multipliers, verdicts, status)
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

   call periodic_points(oscillator_type(xi, mu, walls), r, pattern_type(sides, cycles), restitution, &
      phases, acceptance, single /= 0, flights /= 0, impacts, scalars, multipliers, verdicts, status)
end subroutine periodic

!> Both equispaced motions at many points; two columns a point.
subroutine equispaced(m, xi, mu, walls, r, clearance, cycles, acceptance, single, flights, impacts, &
      scalars, multipliers, verdicts, status)
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
   use vi_periodic, only: assemble, linear_system_type
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n, cycles, sides(n)
   real(c_double), intent(in) :: xi, mu, r, restitution(n), phases(n)
   real(c_double), intent(out) :: matrix(2*n, n + 2), rhs(2*n)
   type(linear_system_type) :: system

   call assemble(oscillator_type(xi, mu), r, pattern_type(sides, cycles), restitution, phases, system)
   matrix = system%matrix
   rhs = system%rhs
end subroutine linear_system

!> The matrices [P_i] of a motion.
subroutine impact_maps(n, xi, mu, r, cycles, sides, restitution, phases, impacts, amplitude, tau, p, &
      regular)
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
subroutine sample(n, m, xi, mu, r, cycles, sides, restitution, phases, impacts, amplitude, tau, times, &
      values)
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

!> Runs namelist files; `paths` are separated by line feeds, and so are the lines of `text`.
!!
!! `text` has room for `room` bytes; `length` tells how many were wanted.
subroutine run_namelists(n_paths, paths, n_folder, folder, room, text, length, status)
   use, intrinsic :: iso_c_binding, only: c_char, c_int
   use vi_batch, only: log_type, run_file
   use vi_text, only: join, line_type, split
   implicit none (type, external)
   !f2py threadsafe
   integer(c_int), intent(in) :: n_paths, n_folder, room
   character(kind=c_char), intent(in) :: paths(n_paths), folder(n_folder)
   character(kind=c_char), intent(out) :: text(room)
   integer(c_int), intent(out) :: length, status
   type(log_type) :: log
   type(line_type), allocatable :: files(:)
   character(n_paths) :: all_paths
   character(n_folder) :: one_folder
   character(:), allocatable :: said
   integer :: i

   all_paths = transfer(paths, all_paths)
   one_folder = transfer(folder, one_folder)
   allocate (files, source=split(all_paths, achar(10)))
   do i = 1, size(files)
      call run_file(files(i)%text, one_folder, log)
   end do
   said = join(log%lines, achar(10))
   length = len(said)
   text = ' '
   do i = 1, min(length, room)
      text(i) = said(i:i)
   end do
   status = log%status
end subroutine run_namelists
