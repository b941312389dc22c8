!> How far the boundary of a zone moves along its normal when parameters change: to first order, and
!! exactly.
!!
!! At each vertex one condition is zero. Eliminating the unknowns of the motion from the equations
!! of the motion and this condition leaves one equation of r, log D and the other parameters, whose
!! gradient gives the normal and the displacement to first order. The displaced boundary itself is
!! found by Newton's method on the line along the normal, continued from the vertex.
module vi_boundary_shift
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_condition_names, only: condition_name
   use vi_conditions, only: all_conditions, condition_count
   use vi_curve, only: correct, curve_type, equations, parameters_of
   use vi_kinds, only: wp
   use vi_linear, only: most
   use vi_motion_family, only: condition_type, edge, grazing, repetition
   use vi_orbit, only: by_clearance, by_left, by_mu, by_r, by_right, by_xi, n_parameters
   use vi_pair_family, only: fails_jury
   use vi_progress, only: add_done_work, add_expected_work, is_stopped
   use vi_spectrum, only: spectrum_type
   use vi_status, only: stat
   use vi_zone_request, only: make_surface, zone_request_type
   implicit none (type, external)
   private

   public :: shift_boundary

   !> The types of conditions, by the numbers that callers use.
   character(14), parameter, public :: shift_types(*) = [character(14) :: 'fold', 'flip', &
      'neimark_sacker', 'zero_approach', 'grazing', 'pitchfork', 'rest_vanishes', &
      'rest_splits']

   !> Outcomes of a displaced vertex: found, on the boundary; found, but another condition fails
   !! there; not found.
   integer, parameter, public :: shift_found = 1, shift_hidden = 2, shift_lost = 0

   !> Value of another condition below which it fails.
   real(wp), parameter :: slack = -1.0e-9_wp

   !> A vertex, prepared.
   type :: vertex_type
      type(condition_type) :: condition
      real(wp), allocatable :: point(:)
      !> Unit normal in the scaled plane, and derivatives of the displacement.
      real(wp) :: normal(2) = 0, slopes(n_parameters) = 0
   end type vertex_type

contains

   !> Displacements of some vertices of the boundaries of one family, for many changes.
   subroutine shift_boundary(request, types, indices, places, x, theta, changes, threads, normals, &
      slopes, shifts, outcomes, status, progress)
      !> The zone: nominal system, pattern, whether its motions are symmetric, window.
      type(zone_request_type), intent(in) :: request
      !> (v) Place in `shift_types`; number of the impact or flight of the condition, 0 if not
      !! known.
      integer, intent(in) :: types(:), indices(:)
      !> (2, v): r and D of each vertex.
      real(wp), intent(in) :: places(:, :)
      !> (N, v) x_i/D and theta_i of the motions at the vertices; with rest (1, v) velocity over D
      !! and load phase of a release.
      real(wp), intent(in) :: x(:, :), theta(:, :)
      !> (6, s): factors of r and of D, and xi, mu, R1, R2.
      real(wp), intent(in) :: changes(:, :)
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> (2, v): a step of r and of log D along the normal, the unit of the displacements.
      real(wp), intent(out) :: normals(:, :)
      !> (6, v): derivatives of the displacement with respect to the logarithms of both factors, xi,
      !! mu, R1, R2.
      real(wp), intent(out) :: slopes(:, :)
      !> (s, v): displacements; NaN where they were not found.
      real(wp), intent(out) :: shifts(:, :)
      !> (s, v): outcomes as above.
      integer, intent(out) :: outcomes(:, :)
      !> (v): `stat%ok`, `stat%singular` where the boundary has no normal, `stat%no_motion` where
      !! the vertex has no such motion, `stat%not_computed` after a stop.
      integer, intent(out) :: status(:)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(curve_type) :: surface
      type(vertex_type) :: vertex
      integer :: i, j

      shifts = ieee_value(1.0_wp, ieee_quiet_nan)
      normals = shifts(1, 1)
      slopes = shifts(1, 1)
      outcomes = shift_lost
      call make_surface(request, surface, status(1))
      status = status(1)
      if (status(1) /= stat%ok) return
      status = stat%not_computed
      call add_expected_work(size(status), progress)
      !$omp parallel do num_threads(threads) schedule(dynamic) private(vertex, i)
      do j = 1, size(status)
         if (is_stopped(progress)) cycle
         call prepare(request, surface, types(j), indices(j), places(:, j), &
            [x(:, j), theta(:, j)], vertex, status(j))
         if (status(j) == stat%ok) then
            normals(:, j) = surface%scale*vertex%normal
            slopes(:, j) = vertex%slopes
            do i = 1, size(changes, 2)
               call displace(surface, vertex, changes(:, i), shifts(i, j), outcomes(i, j))
            end do
         end if
         call add_done_work(1, progress)
      end do
      !$omp end parallel do
   end subroutine shift_boundary

   !> The motion, condition, normal and derivatives of a vertex.
   subroutine prepare(request, surface, kind, index, place, whole, vertex, status)
      !> As in `shift_boundary`.
      type(zone_request_type), intent(in) :: request
      !> The surface of motions.
      type(curve_type), intent(in) :: surface
      !> Place in `shift_types`; number of the impact or flight, 0 if not known.
      integer, intent(in) :: kind, index
      !> r and D.
      real(wp), intent(in) :: place(2)
      !> x_i/D, theta_i; with rest velocity over D and load phase.
      real(wp), intent(in) :: whole(:)
      !> The vertex.
      type(vertex_type), intent(out) :: vertex
      !> As in `shift_boundary`.
      integer, intent(out) :: status
      type(curve_type) :: full
      type(condition_type) :: conditions(condition_count(surface))
      real(wp) :: values(size(conditions)), at(2), gradient(n_parameters), length
      real(wp), allocatable :: unknowns(:)
      integer :: i, m, n, iterations
      logical :: regular, mirrored
      logical :: fits(size(conditions))

      status = stat%no_motion
      m = surface%family%unknown_count()
      if (m + n_parameters > most) return
      at = [place(1), log(place(2))]
      at = (at - surface%origin)/surface%scale
      n = size(whole)/2
      allocate (unknowns, source=surface%family%from_vertex(parameters_of(surface, [(0.0_wp, i=1, &
         m), at]), whole(:n), whole(n + 1:)))
      vertex%point = [unknowns, at]
      call all_conditions(surface, unknowns, parameters_of(surface, vertex%point), values, &
         conditions)
      mirrored = .not. request%symmetric .and. size(surface%family%repetitions) > 0
      if (mirrored) mirrored = surface%family%repetitions(1)%sign < 0
      do i = 1, size(conditions)
         associate (c => conditions(i))
            fits(i) = c%kind /= edge .and. condition_name(c%kind, c%index, request%symmetric, &
               mirrored) == shift_types(kind) .and. (index == 0 .or. index == c%index)
         end associate
      end do
      if (.not. any(fits)) return
      vertex%condition = conditions(minloc(abs(values), dim=1, mask=fits))

      full = surface
      full%active = [by_r, by_clearance, by_xi, by_mu, by_right, by_left]
      full%origin = [surface%origin, spread(0.0_wp, 1, n_parameters - 2)]
      full%scale = [surface%scale, spread(1.0_wp, 1, n_parameters - 2)]
      call reduced_gradient(full, vertex%condition, [vertex%point, surface%c(by_xi:by_left)], &
         gradient, regular)
      status = stat%singular
      if (.not. regular) return
      length = norm2(gradient(:2))
      if (.not. length > 0) return
      vertex%normal = gradient(:2)/length
      ! the vertex itself, as precisely as the displaced ones
      call correct(surface, [vertex%condition], vertex%point, iterations, along(vertex, m))
      if (iterations == 0) return
      if (surface%family%jumps) then
         call difference_slopes(surface, vertex, regular)
         if (regular) status = stat%ok
         return
      end if
      vertex%slopes(:2) = -gradient(:2)/surface%scale*[place(1), 1.0_wp]/length
      vertex%slopes(3:) = -gradient(3:)/length
      status = stat%ok
   end subroutine prepare

   !> The derivatives of the displacement as central differences of displacements.
   !!
   !! An accumulation that is not completed is cut off earlier than one that is. Differences of the
   !! measure of the rest across that boundary are therefore accurate to a percent only, but its
   !! zeros are accurate.
   subroutine difference_slopes(surface, vertex, good)
      !> The nominal surface of motions.
      type(curve_type), intent(in) :: surface
      !> In: a vertex with its normal. Out: with the derivatives.
      type(vertex_type), intent(inout) :: vertex
      !> False if a displaced vertex was not found.
      logical, intent(out) :: good
      real(wp), parameter :: h = 1.0e-5_wp
      real(wp) :: change(n_parameters), shifts(2)
      integer :: k, side, outcome

      good = .false.
      do k = 1, n_parameters
         do side = 1, 2
            change = [1.0_wp, 1.0_wp, surface%c(by_xi:by_left)]
            change(k) = change(k) + merge(h, -h, side == 1)
            if (k <= by_clearance) change(k) = exp(merge(h, -h, side == 1))
            call displace(surface, vertex, change, shifts(side), outcome)
            if (outcome == shift_lost) return
         end do
         vertex%slopes(k) = (shifts(1) - shifts(2))/(2*h)
      end do
      good = .true.
   end subroutine difference_slopes

   !> Unit vector of a point's coordinates that is tangential to the boundary in the plane (r, log
   !! D): the plane with this normal contains the line along which the vertex is displaced.
   pure function along(vertex, m)
      !> The vertex, with its normal.
      type(vertex_type), intent(in) :: vertex
      !> Number of unknowns of the motion.
      integer, intent(in) :: m
      real(wp) :: along(m + 2)

      along(:m) = 0
      along(m + 1:) = [-vertex%normal(2), vertex%normal(1)]
   end function along

   !> The gradient of a condition on the motions of a family with respect to the active parameters,
   !! up to a factor.
   pure subroutine reduced_gradient(curve, condition, point, gradient, regular)
      !> The family, with its active parameters.
      type(curve_type), intent(in) :: curve
      !> The condition, zero at the point.
      type(condition_type), intent(in) :: condition
      !> A motion of the family.
      real(wp), intent(in) :: point(:)
      !> (active parameters) The gradient.
      real(wp), intent(out) :: gradient(:)
      !> False where there is none, for example where boundaries cross.
      logical, intent(out) :: regular
      real(wp) :: a(most, most), b(2, most), column(most)
      integer :: j, k, m, n

      call equations(curve, [condition], point, b, a)
      n = size(point)
      m = n - size(gradient)
      gradient = 0
      regular = .false.
      do j = 1, m + 1
         if (.not. maxval(abs(a(:n, j))) > 0) return
         a(:n, j) = a(:n, j)/maxval(abs(a(:n, j)))
      end do
      ! the combination of all gradients that does not depend on the unknowns
      do k = 1, m
         j = k - 1 + maxloc(abs(a(k, k:m + 1)), dim=1)
         if (.not. abs(a(k, j)) > 1.0e-12_wp) return
         column(:n) = a(:n, j)
         a(:n, j) = a(:n, k)
         a(:n, k) = column(:n)
         do j = k + 1, m + 1
            a(:n, j) = a(:n, j) - a(k, j)/column(k)*column(:n)
         end do
      end do
      gradient = a(m + 1:n, m + 1)
      regular = all(abs(gradient) <= huge(1.0_wp))
   end subroutine reduced_gradient

   !> The displacement of a vertex along its normal, by continuation from the nominal parameters.
   subroutine displace(surface, vertex, change, shift, outcome)
      !> The nominal surface of motions.
      type(curve_type), intent(in) :: surface
      !> The vertex.
      type(vertex_type), intent(in) :: vertex
      !> (6) Factors of r and of D, and xi, mu, R1, R2.
      real(wp), intent(in) :: change(:)
      !> The displacement; unchanged if it is not found.
      real(wp), intent(inout) :: shift
      !> As above.
      integer, intent(out) :: outcome
      real(wp), parameter :: shortest = 1.0_wp/64, largest = 0.2_wp
      type(curve_type) :: moved
      type(condition_type) :: conditions(condition_count(surface))
      real(wp) :: values(size(conditions)), part, step
      real(wp), dimension(size(vertex%point)) :: point, previous, guess, across
      type(spectrum_type) :: spectrum
      integer :: m, iterations

      m = size(vertex%point) - 2
      outcome = shift_lost
      moved = surface
      ! a multiplier that is on the circle to rounding must not count as outside
      moved%family%every_crossing = .true.
      point = vertex%point
      previous = point
      across = along(vertex, m)
      part = 0
      step = 1
      do while (part < 1)
         step = min(step, 1 - part)
         call change_by(surface, change, part + step, moved)
         guess = point
         if (part > 0) guess = point + step*previous
         call correct(moved, [vertex%condition], guess, iterations, across)
         if (iterations > 0 .and. maxval(abs(guess - point)) < largest) then
            previous = (guess - point)/step
            point = guess
            part = part + step
            step = 2*step
         else
            step = 0.5_wp*step
            if (step < shortest) return
         end if
      end do
      shift = dot_product(point(m + 1:) - vertex%point(m + 1:), vertex%normal)
      call all_conditions(moved, point(:m), parameters_of(moved, point), values, conditions, &
         spectrum)
      where (conditions%kind == edge .or. conditions%kind == repetition .or. &
         is_same(conditions, vertex%condition)) values = 0
      outcome = merge(shift_found, shift_hidden, all(values >= slack))
      if (outcome == shift_hidden .or. moved%family%jumps) return
      if (fails_jury(spectrum)) outcome = shift_hidden
   end subroutine displace

   !> The surface for a share of a change: the coordinates of its points stay nominal.
   pure subroutine change_by(surface, change, share, moved)
      !> The nominal surface.
      type(curve_type), intent(in) :: surface
      !> (6) Factors of r and of D, and xi, mu, R1, R2; share of the change, 0 to 1.
      real(wp), intent(in) :: change(:), share
      !> In and out: like `surface`; its parameters are set.
      type(curve_type), intent(inout) :: moved
      real(wp) :: factor(2)

      factor = change(:2)**share
      moved%c(by_xi:by_left) = surface%c(by_xi:by_left) &
         + share*(change(by_xi:) - surface%c(by_xi:by_left))
      moved%origin = [factor(1)*surface%origin(1), surface%origin(2) + log(factor(2))]
      moved%scale = [factor(1)*surface%scale(1), surface%scale(2)]
   end subroutine change_by

   !> Whether a condition is the given one; a graze may be found at another place of its flight.
   pure elemental logical function is_same(condition, given)
      !> Any condition, and the given one.
      type(condition_type), intent(in) :: condition, given

      is_same = condition%kind == given%kind .and. condition%index == given%index
      if (is_same .and. given%kind == grazing) is_same = condition%side == given%side
   end function is_same

end module vi_boundary_shift
