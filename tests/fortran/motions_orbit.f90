!> Orbits in (u, theta): derivatives compared with differences, other results with other code.
module motions_orbit
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, draw_log, fill, random_type
   use random_systems, only: determinant, pi, random_motion, random_oscillator, random_sides
   use vi_characteristic, only: characteristic
   use vi_equispaced, only: solve_equispaced
   use vi_exact, only: newton_equations, setting_type
   use vi_family, only: add_distance_slope, repetition_distance, repetition_type, whole_unknowns
   use vi_kinds, only: wp
   use vi_motion, only: motion_type
   use vi_orbit, only: by_clearance, by_left, by_mu, by_r, by_right, by_xi, family_type, &
      most_impacts, n_parameters, orbit_by_parameter, orbit_residual, orbit_slopes, orbit_type, &
      period_parts, set_orbit
   use vi_oscillator, only: gain, left, oscillator_type, right
   use vi_pattern, only: default_restitution
   use vi_period_slope, only: add_period_slope
   use vi_periodic, only: linear_system_type
   use vi_spectrum, only: spectrum_type, sums_with_slope
   use vi_stability, only: stability_matrix
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: random_member, test_orbits

   type(random_type) :: random

contains

   subroutine test_orbits()
      call test_anywhere()
      call test_map_anywhere()
      call test_exact_motions()
      call test_half_period()
      call test_distances()
      call test_no_approach()
   end subroutine test_orbits

   !> A family and unknowns that need not be a motion, away from resonance and very short flights.
   subroutine random_member(stream, family, unknowns, c)
      type(random_type), intent(inout) :: stream
      type(family_type), intent(out) :: family
      real(wp), allocatable, intent(out) :: unknowns(:)
      real(wp), intent(out) :: c(n_parameters)
      real(wp), allocatable :: gaps(:)
      integer :: i, n

      family%mirror = draw_integer(stream, 1, 2) == 1
      n = draw_integer(stream, merge(1, 2, family%mirror), 4)
      allocate (family%sides(n), gaps(n), unknowns(2*n))
      family%sides = 1
      if (n > 1) call random_sides(stream, family%sides)
      family%cycles = 2*draw_integer(stream, 0, 1) + 1
      c(by_r) = draw(stream, 0.4_wp, 0.9_wp)
      if (draw_integer(stream, 1, 2) == 1) c(by_r) = 1/c(by_r)
      c(by_xi) = draw(stream, 0.02_wp, 0.3_wp)
      c(by_clearance) = log(gain(c(by_xi), c(by_r))*draw_log(stream, 0.3_wp, 20.0_wp))
      c(by_mu) = draw_log(stream, 1e-2_wp, 1.0_wp)
      c(by_right) = draw(stream, 0.1_wp, 0.95_wp)
      c(by_left) = draw(stream, 0.1_wp, 0.95_wp)
      if (family%mirror) c(by_left) = c(by_right)
      call fill(stream, 0.4_wp, 1.0_wp, gaps)
      gaps = gaps*merge(pi, 2*pi, family%mirror)*family%cycles/sum(gaps)
      call fill(stream, -2.0_wp, 2.0_wp, unknowns(:n))
      unknowns(n + 1) = draw(stream, -pi, pi)
      do i = 2, n
         unknowns(n + i) = unknowns(n + i - 1) + gaps(i - 1)
      end do
   end subroutine random_member

   function residual_at(family, unknowns, c) result(residual)
      type(family_type), intent(in) :: family
      real(wp), intent(in) :: unknowns(:), c(:)
      real(wp) :: residual(size(unknowns))
      type(orbit_type) :: o

      call set_orbit(family, unknowns, c, o)
      residual = orbit_residual(o)
   end function residual_at

   !> Laws that hold at any unknowns, not only at motions.
   subroutine test_anywhere()
      type(family_type) :: family
      real(wp), allocatable :: unknowns(:)
      real(wp) :: c(n_parameters)
      integer :: i

      do i = 1, 1000
         call random_member(random, family, unknowns, c)
         call check_derivatives(family, unknowns, c)
         call check_newton_equations(family, unknowns, c, whole_unknowns(family, unknowns))
      end do
   end subroutine test_anywhere

   !> The gradient of a weighted sum of the entries of the period's map, by the unknowns and by
   !! every parameter, compared with fourth-order differences.
   subroutine test_map_anywhere()
      real(wp), parameter :: h = 3.0e-5_wp, factors(-2:2) = [1, -8, 0, 8, -1]/(12*h)
      type(family_type) :: family
      type(orbit_type) :: o
      real(wp), allocatable :: unknowns(:), all(:), moved(:), slope(:)
      real(wp) :: c(n_parameters), weights(16), p(4, 4), parts(4, 4, most_impacts), difference
      integer :: examined, i, j, k, n
      logical :: regular

      examined = 0
      do i = 1, 1500
         call random_member(random, family, unknowns, c)
         call set_orbit(family, unknowns, c, o)
         ! [P] grows like 1 over an approach speed
         if (any(abs(o%speed(1:o%n) - o%before(2:o%n + 1)) < 0.3_wp)) cycle
         call period_parts(o, parts, p, regular)
         if (.not. regular .or. maxval(abs(p)) > 1.0e2_wp) cycle
         examined = examined + 1
         call fill(random, -1.0_wp, 1.0_wp, weights)
         n = size(unknowns)
         if (allocated(all)) deallocate (all, slope)
         allocate (all, source=[unknowns, c])
         allocate (slope(size(all)), source=0.0_wp)
         o%varied = n_parameters
         call add_period_slope(o, parts, reshape(weights, [4, 4]), slope)
         do j = 1, size(all)
            difference = 0
            do k = -2, 2
               if (k == 0) cycle
               moved = all
               moved(j) = all(j) + k*h
               call set_orbit(family, moved(:n), moved(n + 1:), o)
               call period_parts(o, parts, p, regular)
               difference = difference + factors(k)*dot_product(weights, reshape(p, [16]))
            end do
            call check_close(slope(j), difference, 1.0e-7_wp*max(1.0_wp, maxval(abs(slope)), &
               maxval(abs(p))), 'orbit: a slope of the map')
         end do
      end do
      call check(examined > 300, 'orbit: slopes of maps are examined')
   end subroutine test_map_anywhere

   !> By the unknowns and by every parameter, compared with fourth-order differences.
   subroutine check_derivatives(family, unknowns, c)
      type(family_type), intent(in) :: family
      real(wp), intent(in) :: unknowns(:), c(:)
      real(wp), parameter :: h = 1.0e-4_wp
      real(wp), parameter :: weights(-2:2) = [1, -8, 0, 8, -1]/(12*h)
      type(orbit_type) :: o
      real(wp), dimension(size(unknowns) + n_parameters) :: all, moved
      real(wp) :: slopes(size(unknowns) + 2, size(unknowns))
      real(wp), dimension(size(unknowns)) :: difference, slope, residual
      real(wp) :: scale
      integer :: j, k, n

      n = size(unknowns)
      all(:n) = unknowns
      all(n + 1:) = c
      call set_orbit(family, unknowns, c, o)
      call orbit_slopes(o, slopes, residual)
      do j = 1, size(all)
         difference = 0
         do k = -2, 2
            if (k == 0) cycle
            moved = all
            moved(j) = all(j) + k*h
            difference = difference + weights(k)*residual_at(family, moved(:n), moved(n + 1:))
         end do
         slope = slopes(min(j, n), :)
         if (j > n) slope = orbit_by_parameter(o, j - n)
         scale = max(1.0_wp, maxval(abs(slope)), maxval(abs(o%speed(1:o%n))), o%amplitude)
         call check_close(maxval(abs(difference - slope)), 0.0_wp, 1.0e-7_wp*scale, &
            'orbit: a column of the derivative')
      end do
   end subroutine check_derivatives

   !> Residual and derivative equal those of the other code, divided by D.
   subroutine check_newton_equations(family, unknowns, c, whole)
      type(family_type), intent(in) :: family
      real(wp), intent(in) :: unknowns(:), c(:), whole(:)
      type(setting_type) :: setting
      type(orbit_type) :: o
      real(wp) :: scaled(size(whole)), residual(size(whole)), jacobian(size(whole), size(whole))
      real(wp) :: slopes(size(unknowns) + 2, size(unknowns)), rest(size(unknowns)), scale
      integer :: n, m

      n = size(unknowns)/2
      m = size(whole)/2
      setting%osc = oscillator_type(c(by_xi), c(by_mu), c([by_right, by_left]))
      setting%r = c(by_r)
      setting%clearance = exp(c(by_clearance))
      setting%pattern%cycles = family%cycles
      allocate (setting%pattern%sides(m))
      setting%pattern%sides(:n) = family%sides
      if (family%mirror) setting%pattern%sides(n + 1:) = -family%sides
      setting%restitution = default_restitution(setting%pattern%sides, c(by_right), c(by_left))
      scaled = whole
      scaled(:m) = whole(:m)*setting%clearance
      call newton_equations(setting, scaled, residual, jacobian)
      residual = residual/setting%clearance
      call set_orbit(family, unknowns, c, o)
      rest = orbit_residual(o)
      scale = max(1.0_wp, maxval(abs(o%speed(1:n))), o%amplitude)
      call check_close(max(maxval(abs(rest(:n) - residual(:n))), &
         maxval(abs(rest(n + 1:) - residual(m + 1:m + n)))), 0.0_wp, 1.0e-13_wp*scale, &
         'orbit: the residual of the other code')
      if (family%mirror) return
      call orbit_slopes(o, slopes, rest)
      jacobian(:, n + 1:) = jacobian(:, n + 1:)/setting%clearance
      call check_close(maxval(abs(transpose(slopes(:2*n, :)) - jacobian)), 0.0_wp, &
         1.0e-13_wp*max(scale, maxval(abs(jacobian))), 'orbit: the derivative of the other code')
   end subroutine check_newton_equations

   !> Exact motions of two impacts: no residual, the [P] of the stability analysis, and det[P].
   subroutine test_exact_motions()
      type(motion_type) :: motion
      type(orbit_type) :: o
      real(wp) :: c(n_parameters), p(4, 4), other(4, 4), parts(4, 4, most_impacts), law, scale
      integer :: i, status, examined
      logical :: regular

      examined = 0
      do i = 1, 4000
         call random_motion(random, 2, motion)
         associate (osc => motion%osc)
            if (any(abs(motion%restitution - default_restitution(motion%pattern%sides, &
               osc%restitution(right), osc%restitution(left))) > 0)) cycle
         end associate
         call orbit_of(motion, .false., o, c)
         scale = max(1.0_wp, maxval(abs(o%u(1:2))), maxval(abs(o%speed(1:2))), &
            o%amplitude*max(1.0_wp, o%r), maxval(abs(o%after(1:2))))
         call check_close(maxval(abs(orbit_residual(o))), 0.0_wp, 1.0e-11_wp*scale, &
            'orbit: an exact motion leaves no residual')
         call period_parts(o, parts, p, regular)
         call stability_matrix(motion, other, status)
         call check(regular .eqv. status == stat%ok, 'orbit: both maps are regular')
         if (.not. regular) cycle
         if (maxval(abs(p)) > 1.0e4_wp) cycle
         examined = examined + 1
         ! lengths over D here
         other(4, :3) = other(4, :3)*motion%clearance
         other(:3, 4) = other(:3, 4)/motion%clearance
         call check_close(maxval(abs(p - other)), 0.0_wp, 1.0e-9_wp*maxval(abs(p)), &
            'orbit: the [P] of stability')
         law = exp(-4*pi*o%xi*motion%pattern%cycles/o%r)*product(motion%restitution)**2
         call check_close(determinant(p), law, 1.0e-12_wp*max(1.0_wp, maxval(abs(p)))**3, &
            'orbit: det[P]')
      end do
      call check(examined > 500, 'orbit: most exact motions are examined')
   end subroutine test_exact_motions

   !> The map of half a period of equispaced motions: its square has the multipliers of [P].
   subroutine test_half_period()
      type(oscillator_type) :: osc
      type(linear_system_type) :: system
      type(motion_type) :: motions(2)
      type(orbit_type) :: o
      real(wp) :: c(n_parameters), q(4, 4), p(4, 4), parts(4, 4, most_impacts), r, clearance, law
      real(wp) :: size_q
      integer :: i, j, cycles, status, examined
      logical :: regular

      examined = 0
      do i = 1, 2000
         call random_oscillator(random, osc)
         osc%restitution = osc%restitution(1)
         r = draw(random, 0.4_wp, 0.9_wp)
         cycles = 2*draw_integer(random, 0, 1) + 1
         clearance = gain(osc%xi, r)*draw_log(random, 0.3_wp, 20.0_wp)
         call solve_equispaced(osc, r, clearance, cycles, system, motions)
         do j = 1, 2
            if (motions(j)%status /= stat%ok) cycle
            call orbit_of(motions(j), .true., o, c)
            call check_close(maxval(abs(orbit_residual(o))), 0.0_wp, 1.0e-11_wp* &
               max(1.0_wp, abs(o%u(1)), abs(o%speed(1)), o%amplitude), &
               'orbit: an equispaced motion leaves no residual')
            call period_parts(o, parts, q, regular)
            call stability_matrix(motions(j), p, status)
            if (.not. regular .or. status /= stat%ok) cycle
            size_q = max(1.0_wp, maxval(abs(q)))
            if (size_q > 1.0e2_wp) cycle
            examined = examined + 1
            call check_close(maxval(abs(characteristic(matmul(q, q)) - characteristic(p))), &
               0.0_wp, 1.0e-11_wp*size_q**4*max(1.0_wp, maxval(abs(characteristic(p)))), &
               'orbit: the square of the half')
            law = exp(-2*pi*o%xi*cycles/r)*osc%restitution(1)**2
            call check_close(abs(determinant(q)), law, 1.0e-12_wp*size_q**3, 'orbit: det[Q]')
         end do
      end do
      call check(examined > 500, 'orbit: most equispaced motions are examined')
   end subroutine test_half_period

   !> The orbit of a motion, of half its period if it is its own mirror image.
   subroutine orbit_of(motion, mirror, o, c)
      type(motion_type), intent(in) :: motion
      logical, intent(in) :: mirror
      type(orbit_type), intent(out) :: o
      real(wp), intent(out) :: c(n_parameters)
      type(family_type) :: family
      integer :: n

      n = size(motion%x)
      if (mirror) n = n/2
      family = family_type(motion%pattern%sides(:n), motion%pattern%cycles, mirror)
      c = [motion%r, log(motion%clearance/(motion%amplitude/gain(motion%osc%xi, motion%r))), &
         motion%osc%xi, motion%osc%mu, motion%osc%restitution([right, left])]
      call set_orbit(family, [motion%x(:n)/motion%clearance, motion%phases(:n) + motion%tau], c, o)
   end subroutine orbit_of

   !> Where an impact has no approach speed, the maps and dependent quantities are not regular:
   !! no gradient is added.
   subroutine test_no_approach()
      type(family_type) :: family
      type(orbit_type) :: o
      type(spectrum_type) :: spectrum
      real(wp), allocatable :: unknowns(:)
      real(wp) :: c(n_parameters), range(2), slope(60), before(60), value, parts(4, 4, &
         most_impacts), p(4, 4)
      integer :: found, i, kind
      logical :: regular, signs(2)

      found = 0
      do i = 1, 200
         call random_member(random, family, unknowns, c)
         if (size(family%sides) < 2) cycle
         range = [-9.0_wp, 9.0_wp]
         signs = [approaches(range(1)), approaches(range(2))]
         if (signs(1) .eqv. signs(2)) cycle
         do while (abs(range(2) - range(1)) > 2*spacing(maxval(abs(range))))
            value = 0.5_wp*sum(range)
            range(merge(1, 2, approaches(value) .eqv. signs(1))) = value
         end do
         regular = approaches(range(1))
         call period_parts(o, parts, p, regular)
         ! it may be just above the rounding limit
         if (regular) cycle
         found = found + 1
         do kind = 1, 3
            call fill(random, -1.0_wp, 1.0_wp, before)
            slope = before
            call sums_with_slope(o, kind, spectrum, value, slope)
            call check(.not. spectrum%regular .and. abs(value) <= 0 .and. all(abs(slope - before) &
               <= 0), 'no approach: no sums')
         end do
      end do
      call check(found > 20, 'no approach: found')
   contains
      !> Whether the masses approach each other before the second impact, for a position there.
      logical function approaches(position)
         real(wp), intent(in) :: position
         real(wp) :: rest(2*size(family%sides))

         unknowns(2) = position
         call set_orbit(family, unknowns, c, o)
         rest = orbit_residual(o)
         ! the map takes the velocity at the end of the flight
         approaches = o%speed(1) - o%before(2) - rest(size(rest)/2 + 1) > 0
      end function approaches
   end subroutine test_no_approach

   !> The gradient of the distance of an orbit from its image, compared with differences; also for
   !! structures with further displacements. Array entries after the unknowns do not change.
   subroutine test_distances()
      type(family_type) :: family
      type(repetition_type) :: repetition
      real(wp), allocatable :: unknowns(:), all_unknowns(:), moved(:)
      real(wp) :: c(n_parameters), slope(60), before(60), difference, weight
      real(wp), parameter :: h = 1e-5_wp
      integer :: trial, further, i, n

      do trial = 1, 200
         call random_member(random, family, unknowns, c)
         further = draw_integer(random, 0, 3)
         n = size(unknowns) + further
         repetition = repetition_type(draw_integer(random, 0, size(family%sides) - 1), &
            real(2*draw_integer(random, 0, 1) - 1, wp), draw(random, 0.0_wp, 6.0_wp), &
            draw_integer(random, 0, further))
         allocate (all_unknowns(n))
         all_unknowns(:size(unknowns)) = unknowns
         call fill(random, 0.5_wp, 2.0_wp, all_unknowns(size(unknowns) + 1:))
         call fill(random, -1.0_wp, 1.0_wp, before)
         slope = before
         weight = draw(random, 0.5_wp, 2.0_wp)
         call add_distance_slope(family, repetition, all_unknowns, weight, slope)
         call check(all(abs(slope(n + 1:) - before(n + 1:)) <= 0), 'behind the unknowns')
         if (further == 0) then
            ! an orbit is its own image after zero time
            slope = before
            call add_distance_slope(family, repetition_type(0, 1.0_wp, 0.0_wp, 0), all_unknowns, &
               weight, slope)
            call check(all(abs(slope - before) <= 0), 'no slope where there is no distance')
            slope = before
            call add_distance_slope(family, repetition, all_unknowns, weight, slope)
         end if
         moved = all_unknowns
         do i = 1, n
            moved(i) = all_unknowns(i) + h
            difference = repetition_distance(family, repetition, moved)
            moved(i) = all_unknowns(i) - h
            difference = (difference - repetition_distance(family, repetition, moved))/(2*h)
            moved(i) = all_unknowns(i)
            call check_close(slope(i) - before(i), weight*difference, 1e-7_wp, 'slope of distance')
         end do
         deallocate (all_unknowns)
      end do
   end subroutine test_distances

end module motions_orbit
