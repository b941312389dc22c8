!> Families of motions of a structure with rests, stops and friction: the equations of
!! vi_structure_rests, and the conditions that can bound them.
!!
!! Besides those of motions without rest these are: a rest vanishes, because its accumulation just
!! fails to be completed; and it splits, because the contact force touches zero before the release.
!! A force that falls to zero at the release has, over the time that is left until then, a least
!! value at any time of the rest, which is positive if the rest does not end before.
!!
!! With stops and friction each row has to stay within its limits between the events, so that no
!! stop is touched and no friction changes in between; the time between two events is positive; and
!! where friction changes its sense, what would hold it is above the stick level.
module vi_structure_resting_family
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
   use vi_family, only: repetition_type
   use vi_kinds, only: two_pi, wp
   use vi_lapack_routines, only: geev
   use vi_linear, only: most
   use vi_motion_family, only: at_fault, condition_type, contact_vanishes, coordinates_type, &
      edge, event_vanishes, events_meet, flight_vanishes, flip, fold, grazing, &
      motion_family_type, neimark_sacker, parameters_at, repetition, rest_splits, rest_vanishes, &
      stick_begins, stick_vanishes, zero_approach
   use vi_orbit, only: n_parameters
   use vi_spectrum, only: outside_circle, spectrum_type
   use vi_structure, only: factor_along
   use vi_structure_family, only: numbers_of
   use vi_structure_rests, only: course_type, first, follow_period, follows_itself, monodromy, &
      release,       rests_type, segment_type, switch, unit_of_row
   use vi_structure_touches, only: least_gap, rows_at, touch_value, wide
   implicit none (type, external)
   private

   !> The unknowns are those of vi_structure_rests; each parameter is a share of the way between its
   !! bounds.
   type, extends(motion_family_type), public :: structure_resting_type
      type(rests_type) :: rests
   contains
      procedure :: unknown_count, wrap_phases, set_equations
      procedure :: condition_count, set_conditions, condition_value
      procedure :: whole_of, part_of, has_other_symbols, image_of, phases_of
   end type structure_resting_type

   !> In place of the number of a flight: the event after an accumulation comes at its end.
   integer, parameter :: exchange = -1

contains

   !> Number of unknowns.
   pure integer function unknown_count(family)
      !> The family.
      class(structure_resting_type), intent(in) :: family

      unknown_count = 2*size(family%rests%path%structure%mass, 1) + size(family%rests%kinds)
   end function unknown_count

   !> Removes whole load cycles that all phases of a difference have in common.
   pure subroutine wrap_phases(family, offset)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> In and out: a difference of unknowns, or of points, which begin with them.
      real(wp), intent(inout) :: offset(:)
      integer :: m, n

      ! the phases of self-excited motions begin at 0
      if (family%rests%free) return
      n = 2*size(family%rests%path%structure%mass, 1)
      m = size(family%rests%kinds)
      offset(n + 1:n + m) = offset(n + 1:n + m) - two_pi*nint(offset(n + 1)/two_pi)
   end subroutine wrap_phases

   !> Residuals of the motion and of conditions, each with its gradient.
   pure subroutine set_equations(family, coordinates, conditions, point, b, a)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> The parameters.
      type(coordinates_type), intent(in) :: coordinates
      !> Conditions that are to be zero.
      type(condition_type), intent(in) :: conditions(:)
      !> A guess.
      real(wp), intent(in) :: point(:)
      !> Out: as in vi_motion_family.
      real(wp), intent(inout) :: b(2, most), a(most, most)
      real(wp), parameter :: h = 1.0e-6_wp
      type(course_type) :: course
      real(wp) :: c(n_parameters), shares(size(family%rests%path%changes)), &
         residuals(size(point) - size(coordinates%active)), slopes(size(residuals), size(residuals))
      integer :: i, j, k, m
      logical :: along

      m = size(point) - size(coordinates%active)
      b(1, :m + size(conditions)) = at_fault
      a(:size(point), :m + size(conditions)) = 0
      c = parameters_at(coordinates, point(m + 1:))
      associate (s => family%rests, active => coordinates%active)
         call follow_period(s, point(:m), c(:size(shares)), .true., course)
         if (.not. course%exists) return
         residuals = course%residuals
         slopes = course%slopes(:m, :)
         do k = 1, size(active)
            do i = 1, 2
               shares = c(:size(shares))
               shares(active(k)) = shares(active(k)) + (3 - 2*i)*h
               call follow_period(s, point(:m), shares, .false., course)
               if (i == 2) exit
               if (.not. course%exists) return
               a(m + k, :m) = course%residuals
            end do
            if (course%exists) then
               a(m + k, :m) = coordinates%scale(k)*((a(m + k, :m) - course%residuals)/(2*h))
            else
               ! no motion follows below, as at a stiffness of 0; Newton's method alone uses this
               a(m + k, :m) = coordinates%scale(k)*((a(m + k, :m) - residuals)/h)
            end if
         end do
         b(1, :m) = residuals
         a(:m, :m) = slopes
      end associate
      if (all(conditions%kind == edge)) return
      along = .false.
      if (allocated(family%rests%rows)) call along_motions(family, coordinates, conditions, point, &
         course, b(1, :m + size(conditions)), a(:size(point), :m + size(conditions)), along)
      if (along) return
      call follow_period(family%rests, point(:m), c(:size(shares)), .true., course)
      do j = 1, size(conditions)
         if (conditions(j)%kind /= edge) call value_in(family, point(:m), course, conditions(j), &
            b(1, m + j))
      end do
      ! derivatives with respect to unknowns first: their parameters are those of the period
      do j = 1, size(conditions)
         if (conditions(j)%kind /= edge) call by_unknowns(family, point(:m), c(:size(shares)), &
            conditions(j), course, a(:m, m + j))
      end do
      do j = 1, size(conditions)
         if (conditions(j)%kind /= edge) call by_parameters(family, coordinates, conditions(j), &
            point, course, a(m + 1:size(point), m + j))
      end do
   end subroutine set_equations

   !> Conditions and their gradients at the nearest motion: where one step of Newton's method for
   !! the equations of the motion leads, on the shortest way.
   !!
   !! For points that are no motions, a condition can be anything between motions: if a stiff stop
   !! is touched at a phase at which it is still open by a small distance, or has yielded, its force
   !! jumps by the stiffness times that, and derivatives with respect to single unknowns are so
   !! large that differences are too coarse for them. At the nearest motion a condition depends only
   !! on the component of a change along the motions, and differences are taken in these directions.
   pure subroutine along_motions(family, coordinates, conditions, point, course, b, a, good)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> The parameters.
      type(coordinates_type), intent(in) :: coordinates
      !> Conditions; edges are left out.
      type(condition_type), intent(in) :: conditions(:)
      !> A guess.
      real(wp), intent(in) :: point(:)
      !> In and out: a period of the family at any parameters.
      type(course_type), intent(inout) :: course
      !> (m + conditions) In: residuals of the m equations. Out: also of the conditions.
      real(wp), intent(inout) :: b(:)
      !> (coordinates, m + conditions) The gradients, in the same way.
      real(wp), intent(inout) :: a(:, :)
      !> False if a condition is not defined there, or motions have no direction of their own.
      logical, intent(out) :: good
      real(wp), parameter :: h = 1.0e-6_wp
      !> Longest way to the nearest motion.
      real(wp), parameter :: far = 0.1_wp
      real(wp) :: basis(size(point), size(point)), factors(size(point), size(point)), &
         ways(size(point), size(conditions)), values(size(conditions), 2), residuals(size(point))
      integer :: i, j, k, m

      m = size(point) - size(coordinates%active)
      call orthogonal_basis(a(:, :m), basis, factors, good)
      if (.not. good) return
      residuals(:m) = b(:m)
      call conditions_near(point, residuals(:m), course, values(:, 1), good)
      if (.not. good) return
      where (conditions%kind /= edge) b(m + 1:) = values(:, 1)
      ways = 0
      do k = m + 1, size(point)
         do i = 1, 2
            associate (moved => point + (3 - 2*i)*h*basis(:, k))
               call follow_at(moved, .false., course)
               good = course%exists
               if (good) residuals(:m) = course%residuals
               if (good) call conditions_near(moved, residuals(:m), course, values(:, i), good)
            end associate
            if (.not. good) return
         end do
         do j = 1, size(conditions)
            ways(:, j) = ways(:, j) + (values(j, 1) - values(j, 2))/(2*h)*basis(:, k)
         end do
      end do
      do j = 1, size(conditions)
         if (conditions(j)%kind /= edge) a(:, m + j) = ways(:, j)
      end do
   contains
      !> The period at a point.
      pure subroutine follow_at(place, sloped, course)
         !> The point, and whether derivatives are wanted.
         real(wp), intent(in) :: place(:)
         logical, intent(in) :: sloped
         !> In: a period, or none. Out: that at the point.
         type(course_type), intent(inout) :: course
         real(wp) :: c(n_parameters)

         c = parameters_at(coordinates, place(m + 1:))
         call follow_period(family%rests, place(:m), c(:size(family%rests%path%changes)), sloped, &
            course)
      end subroutine follow_at

      !> The conditions at the motion that is nearest to a point.
      pure subroutine conditions_near(place, residuals, course, results, good)
         !> The point, and its residuals.
         real(wp), intent(in) :: place(:), residuals(:)
         !> In: a period, or none. Out: that of the motion.
         type(course_type), intent(inout) :: course
         !> The values; 1 of edges.
         real(wp), intent(out) :: results(:)
         !> Whether they are defined.
         logical, intent(out) :: good
         real(wp) :: way(size(place)), parts(size(place))
         integer :: p

         results = 1
         ! a^T way = residuals with a = basis factors
         way = 0
         do p = 1, m
            parts(p) = (residuals(p) - dot_product(factors(:p - 1, p), parts(:p - 1)))/factors(p, p)
            way = way + parts(p)*basis(:, p)
         end do
         good = norm2(way) < far
         if (.not. good) return
         call follow_at(place - way, any(conditions%kind <= neimark_sacker), course)
         good = course%exists
         if (.not. good) return
         associate (there => place - way)
            do p = 1, size(conditions)
               if (conditions(p)%kind /= edge) call value_in(family, there(:m), course, &
                  conditions(p), results(p))
            end do
         end associate
         good = all(abs(results) <= huge(1.0_wp))
      end subroutine conditions_near
   end subroutine along_motions

   !> An orthonormal basis that begins with one of the space of some gradients.
   pure subroutine orthogonal_basis(gradients, basis, factors, good)
      !> (n, m) The gradients, less than n.
      real(wp), intent(in) :: gradients(:, :)
      !> (n, n) The basis; gradients = basis(:, :m) factors, with an upper triangle of factors.
      real(wp), intent(out) :: basis(:, :), factors(:, :)
      !> False if they are not independent.
      logical, intent(out) :: good
      !> Least component of a gradient orthogonal to the others, over its length, for it to be
      !! independent of them.
      real(wp), parameter :: least = 1.0e-9_wp
      real(wp) :: left(size(basis, 1)), best(size(basis, 1)), part
      integer :: i, j, m, pass

      m = size(gradients, 2)
      basis = 0
      factors = 0
      do j = 1, m
         left = gradients(:, j)
         ! twice is enough
         do pass = 1, 2
            do i = 1, j - 1
               part = dot_product(basis(:, i), left)
               left = left - part*basis(:, i)
               factors(i, j) = factors(i, j) + part
            end do
         end do
         factors(j, j) = norm2(left)
         good = factors(j, j) > least*norm2(gradients(:, j))
         if (.not. good) return
         basis(:, j) = left/factors(j, j)
      end do
      do j = m + 1, size(basis, 1)
         best = 0
         do i = 1, size(basis, 1)
            left = 0
            left(i) = 1
            left = left - matmul(basis(:, :j - 1), matmul(left, basis(:, :j - 1)))
            left = left - matmul(basis(:, :j - 1), matmul(left, basis(:, :j - 1)))
            if (norm2(left) > norm2(best)) best = left
         end do
         basis(:, j) = best/norm2(best)
      end do
      good = .true.
   end subroutine orthogonal_basis

   !> The derivatives of a condition with respect to the parameters, by central differences, or
   !! one-sided ones where there are periods on one side only, as at the least or greatest value of
   !! a parameter.
   pure subroutine by_parameters(family, coordinates, condition, point, course, slope)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> The parameters.
      type(coordinates_type), intent(in) :: coordinates
      !> The condition, not an edge.
      type(condition_type), intent(in) :: condition
      !> A point.
      real(wp), intent(in) :: point(:)
      !> In and out: a period at any parameters; another one on return.
      type(course_type), intent(inout) :: course
      !> (parameters) The derivatives.
      real(wp), intent(out) :: slope(:)
      real(wp), parameter :: h = 1.0e-6_wp
      real(wp) :: moved(size(slope)), both(2), here
      integer :: i, j, m

      m = size(point) - size(slope)
      do j = 1, size(slope)
         moved = point(m + 1:)
         do i = 1, 2
            moved(j) = point(m + j) + (3 - 2*i)*h
            call value_at(family, point(:m), parameters_at(coordinates, moved), condition, course, &
               both(i))
         end do
         slope(j) = (both(1) - both(2))/(2*h)
         if (count(ieee_is_nan(both)) /= 1) cycle
         call value_at(family, point(:m), parameters_at(coordinates, point(m + 1:)), condition, &
            course, here)
         slope(j) = merge(here - both(2), both(1) - here, ieee_is_nan(both(1)))/h
      end do
   end subroutine by_parameters

   !> The derivatives of a condition with respect to the unknowns, by central differences.
   pure subroutine by_unknowns(family, unknowns, shares, condition, course, slope)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> Unknowns of the motion, and the parameters as shares.
      real(wp), intent(in) :: unknowns(:), shares(:)
      !> The condition, not an edge.
      type(condition_type), intent(in) :: condition
      !> In and out: a period at these parameters; another one on return.
      type(course_type), intent(inout) :: course
      !> The derivatives.
      real(wp), intent(out) :: slope(:)
      real(wp), parameter :: h = 1.0e-6_wp
      real(wp) :: moved(size(unknowns)), both(2)
      integer :: i, j

      do j = 1, size(unknowns)
         moved = unknowns
         do i = 1, 2
            moved(j) = unknowns(j) + (3 - 2*i)*h
            call value_at(family, moved, shares, condition, course, both(i))
         end do
         slope(j) = (both(1) - both(2))/(2*h)
      end do
   end subroutine by_unknowns

   !> Number of conditions.
   pure integer function condition_count(family)
      !> The family.
      class(structure_resting_type), intent(in) :: family

      condition_count = 3 + 3*size(family%rests%kinds) + size(family%repetitions)
   end function condition_count

   !> The values of all conditions: fold, flip, Neimark-Sacker, then approaches, gaps and forces,
   !! and rests by symbol; -1 where the symbols cannot be followed.
   pure subroutine set_conditions(family, unknowns, c, values, found, spectrum)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> Unknowns of the motion, and the parameters as shares.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> (m) Value of each condition, positive where it is met.
      real(wp), intent(out) :: values(:)
      !> (m) The conditions; grazing with its wall and the share of the flight.
      type(condition_type), intent(out) :: found(:)
      !> The multipliers.
      type(spectrum_type), intent(out) :: spectrum
      type(course_type) :: course
      integer :: i, n

      n = size(family%rests%kinds)
      found(:3) = [condition_type(fold), condition_type(flip), condition_type(neimark_sacker)]
      do i = 1, n
         found(3 + i) = condition_type(zero_approach, i)
         if (family%rests%kinds(i) == switch) found(3 + i)%kind = stick_begins
         ! not of a zone under a load, which would follow what rounding makes of multipliers near
         ! such a point
         if (family%every_crossing .or. family%rests%free) then
            if (halts_or_slips(family, i)) found(3 + i) = condition_type(event_vanishes, i)
         end if
         found(3 + n + i) = condition_type(grazing, i)
         found(3 + 2*n + i) = condition_type(end_of(family, i), i)
      end do
      do i = 1, size(family%repetitions)
         found(3 + 3*n + i) = condition_type(repetition, i, bound=family%apart)
      end do
      values = -1
      call follow_period(family%rests, unknowns, c(:size(family%rests%path%changes)), .true., &
         course)
      if (.not. course%exists) return
      call stability_values(family, unknowns, course, values(:3), spectrum)
      if (.not. family%every_crossing .and. all(values(:3) > 0)) then
         ! only stable motions are inside
         if (outside_circle(spectrum, 0) > 0) values(neimark_sacker) = -values(neimark_sacker)
      end if
      do i = 1, n
         call least_of_symbol(family, course, found(3 + n + i), values(3 + n + i))
      end do
      do i = 4, size(values)
         if (i > 3 + n .and. i <= 3 + 2*n) cycle
         call value_in(family, unknowns, course, found(i), values(i))
      end do
   end subroutine set_conditions

   !> The value of one condition; for grazing, at the stationary point given in it.
   pure real(wp) function condition_value(family, unknowns, c, condition) result(value)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> Unknowns of the motion, and the parameters as shares.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> The condition, not an edge.
      type(condition_type), intent(in) :: condition
      type(course_type) :: course

      call value_at(family, unknowns, c, condition, course, value)
   end function condition_value

   !> The same; the period is kept.
   pure subroutine value_at(family, unknowns, c, condition, course, value)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> Unknowns of the motion, and at least the parameters as shares.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> The condition, not an edge.
      type(condition_type), intent(in) :: condition
      !> In: a period at any parameters, or none. Out: that of the motion.
      type(course_type), intent(inout) :: course
      !> The value, NaN where there is no such period.
      real(wp), intent(out) :: value

      call follow_period(family%rests, unknowns, c(:size(family%rests%path%changes)), &
         condition%kind <= neimark_sacker, course)
      value = ieee_value(1.0_wp, ieee_quiet_nan)
      if (course%exists) call value_in(family, unknowns, course, condition, value)
   end subroutine value_at

   !> The value of one condition in a period.
   pure subroutine value_in(family, unknowns, course, condition, value)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> Unknowns of the motion.
      real(wp), intent(in) :: unknowns(:)
      !> The period, for conditions of stability with its derivatives.
      type(course_type), intent(in) :: course
      !> The condition, not an edge.
      type(condition_type), intent(in) :: condition
      !> The value.
      real(wp), intent(out) :: value
      type(spectrum_type) :: spectrum
      type(condition_type) :: touch
      real(wp) :: three(3)
      integer :: i

      associate (s => family%rests, symbol => condition%index)
         select case (condition%kind)
         case (fold, flip, neimark_sacker)
            call stability_values(family, unknowns, course, three, spectrum)
            value = three(condition%kind)
         case (zero_approach)
            value = 1
            if (s%kinds(symbol) < release) value = course%speeds(symbol)/s%speed
         case (stick_begins)
            value = 1
            if (.not. halts_or_slips(family, symbol)) value = course%excess(symbol)
         case (event_vanishes)
            value = course%excess(symbol)
         case (stick_vanishes, contact_vanishes, flight_vanishes, events_meet)
            i = findloc(course%segments(:course%parts)%symbol, symbol, dim=1)
            value = course%run%load%frequency*course%segments(i)%duration
         case (rest_vanishes)
            value = course%rests(symbol)
         case (repetition)
            value = distance(family, family%repetitions(symbol), unknowns) - condition%bound
         case default
            value = -1
            do i = 1, course%parts
               associate (part => course%segments(i))
                  if (part%symbol /= symbol .or. part%number /= max(0, nint(condition%bound))) cycle
                  value = wide
                  if (nint(condition%bound) == exchange) then
                     value = course%run%load%frequency*part%duration
                  else if (condition%kind == rest_splits) then
                     touch = condition
                     call least_force(family, course, part, touch, value)
                  else if (part%duration > 0) then
                     value = touch_value(course%run%regimes(part%regime), part%x, part%v, &
                        part%time, part%duration, units_of(family, course, part), condition)
                  end if
               end associate
               exit
            end do
         end select
      end associate
   end subroutine value_in

   !> The numbers of fold, flip and Neimark-Sacker.
   pure subroutine stability_values(family, unknowns, course, values, spectrum)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> Unknowns of the motion.
      real(wp), intent(in) :: unknowns(:)
      !> The period, with its derivatives.
      type(course_type), intent(in) :: course
      !> The numbers; 0 where an impact has no approach speed.
      real(wp), intent(out) :: values(3)
      !> The multipliers.
      type(spectrum_type), intent(out) :: spectrum
      real(wp), allocatable :: p(:, :), re(:), im(:), work(:)
      real(wp) :: continued, unused(1, 1)
      integer :: info, n

      values = 0
      n = 2*size(course%run%structure%mass, 1)
      allocate (p(n, n))
      call monodromy(family%rests, course, p, spectrum%regular)
      if (.not. spectrum%regular) return
      if (family%rests%free) call leave_trivial(course%flow, p)
      n = size(p, 1)
      allocate (re(n), im(n), work(66*n))
      call geev('N', 'N', n, p, n, re, im, unused, 1, unused, 1, work, size(work), info)
      spectrum%regular = info == 0
      if (.not. spectrum%regular) return
      spectrum%multipliers = cmplx(re, im, wp)
      ! where an approach speed passes zero, a multiplier passes infinity and another one zero
      continued = product(sign(1.0_wp, pack(course%speeds, family%rests%kinds < release)))
      call numbers_of(spectrum%multipliers, continued, values)
      ! a multiplier approaches 1 where the motion repeats itself, as the square of the distance
      do info = 1, size(family%repetitions)
         values(fold) = values(fold)/max(0.1_wp*family%apart, distance(family, &
            family%repetitions(info), unknowns))**2
      end do
   end subroutine stability_values

   !> Leaves the trivial multiplier 1 of a self-excited motion out of the derivative of its period.
   !!
   !! In an orthonormal basis that begins with the flow f, with [P] f = f, the first column of [P]
   !! is that of the unit matrix, and the other rows and columns have the other multipliers: so it
   !! is not confused with another one that passes 1.
   pure subroutine leave_trivial(flow, p)
      !> (n) f.
      real(wp), intent(in) :: flow(:)
      !> In: [P] (n, n). Out: the rest of it (n - 1, n - 1).
      real(wp), allocatable, intent(inout) :: p(:, :)
      real(wp), allocatable :: rest(:, :)
      real(wp) :: mirror(size(flow)), turned(size(flow))
      integer :: i, n

      n = size(flow)
      ! the reflection I - 2 u u^T that takes the first unit vector to -+f
      mirror = flow/norm2(flow)
      mirror(1) = mirror(1) + sign(1.0_wp, mirror(1))
      mirror = mirror/norm2(mirror)
      do i = 1, n
         p(:, i) = p(:, i) - 2*dot_product(mirror, p(:, i))*mirror
      end do
      turned = matmul(p, mirror)
      allocate (rest(n - 1, n - 1))
      do i = 2, n
         rest(:, i - 1) = p(2:, i) - 2*turned(2:)*mirror(i)
      end do
      call move_alloc(rest, p)
   end subroutine leave_trivial

   !> The distance of a motion from one that repeats itself, in load phase (rad).
   pure real(wp) function distance(family, way, unknowns)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> The way.
      type(repetition_type), intent(in) :: way
      !> Unknowns of the motion.
      real(wp), intent(in) :: unknowns(:)

      distance = norm2(family%image_of(way, unknowns) - unknowns)
   end function distance

   !> The load phases of the image of a motion, which begins half a period later; its state is not
   !! that of the image.
   pure function image_of(family, way, unknowns) result(image)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> The way of repeating itself.
      type(repetition_type), intent(in) :: way
      !> The motion.
      real(wp), intent(in) :: unknowns(:)
      real(wp) :: image(size(unknowns))
      integer :: half, n

      half = size(family%rests%kinds)/2
      n = size(unknowns) - 2*half
      image = unknowns
      if (family%rests%free) then
         ! the period remains, and phases are those after the middle event
         associate (middle => unknowns(n + 1 + half))
            image(n + 2:n + half) = unknowns(n + half + 2:) - middle
            image(n + half + 1:) = unknowns(n + 1) - middle + [0.0_wp, unknowns(n + 2:n + half)]
         end associate
         return
      end if
      image(n + 1:n + half) = unknowns(n + half + 1:) - way%phase
      image(n + half + 1:) = unknowns(n + 1:n + half) + way%phase
   end function image_of

   !> Whether a symbol is a halt after which friction sticks, or its slip.
   pure logical function halts_or_slips(family, symbol) result(does)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> The symbol.
      integer, intent(in) :: symbol

      associate (s => family%rests)
         does = s%kinds(symbol) == switch
         if (does) does = s%path%structure%rubs(s%gaps(symbol)) .and. size(s%stuck(symbol)%set) == 0
      end associate
   end function halts_or_slips

   !> The condition at which a symbol and the next one come together, or its rest vanishes.
   pure integer function end_of(family, symbol) result(kind)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> The symbol.
      integer, intent(in) :: symbol
      integer :: gap, next

      kind = rest_vanishes
      associate (s => family%rests)
         if (.not. allocated(s%rows)) return
         kind = events_meet
         if (s%kinds(symbol) == first) kind = rest_vanishes
         next = modulo(symbol, size(s%kinds)) + 1
         if (s%kinds(symbol) /= switch .or. s%kinds(next) /= switch) return
         gap = s%gaps(symbol)
         ! the last symbol is the event that begins the period, or its mirror image
         if (next == 1) gap = s%first_gap
         if (gap /= s%gaps(next) .or. (symbol == next .and. .not. s%halved)) return
         if (any(s%closed(modulo(symbol, size(s%kinds)))%set == gap)) then
            kind = merge(stick_vanishes, contact_vanishes, s%path%structure%rubs(gap))
         else if (s%path%structure%elastic(gap) .and. follows_itself(s, next)) then
            kind = flight_vanishes
         end if
      end associate
   end function end_of

   !> The units of all rows in a flight or a rest: lengths without stops and friction.
   pure function units_of(family, course, part) result(units)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> The period.
      type(course_type), intent(in) :: course
      !> The flight or rest.
      type(segment_type), intent(in) :: part
      real(wp) :: units(size(course%run%regimes(part%regime)%upper))
      integer :: number, row

      units = family%rests%length
      if (.not. allocated(family%rests%rows)) return
      associate (regime => course%run%regimes(part%regime))
         do row = 1, size(units)
            number = max(abs(regime%upper_gap(row)), abs(regime%lower_gap(row)))
            if (number > 0) units(row) = unit_of_row(family%rests, course%run%structure, row, &
               number, course%run%load%frequency)
         end do
      end associate
   end function units_of

   !> The least gap, or contact force, after a symbol and before the next one.
   pure subroutine least_of_symbol(family, course, touch, value)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> The period.
      type(course_type), intent(in) :: course
      !> In: with the symbol. Out: what is least, with its side, the number of the flight as its
      !! bound, and the share of it.
      type(condition_type), intent(inout) :: touch
      !> The value.
      real(wp), intent(out) :: value
      type(condition_type) :: here
      real(wp) :: least
      integer :: i

      value = wide
      do i = 1, course%parts
         associate (part => course%segments(i))
            if (part%symbol /= touch%index) cycle
            if (part%number == 0 .and. family%rests%kinds(touch%index) == first .and. &
               part%ends /= family%rests%gaps(touch%index)) then
               ! the next event is not the release
               least = course%run%load%frequency*part%duration
               if (least < value) then
                  value = least
                  touch = condition_type(grazing, touch%index, share=1.0_wp, bound=real( &
                     exchange, wp))
                  touch%side = course%run%structure%channel(part%ends)* &
                     course%run%structure%wall(part%ends)
               end if
            end if
            if (.not. part%duration > 0) cycle
            here = condition_type(grazing, touch%index, bound=real(part%number, wp))
            if (allocated(family%rests%rows)) then
               associate (next => modulo(part%symbol, size(family%rests%kinds)) + 1)
                  call least_gap(course%run%regimes(part%regime), part%x, part%v, part%time, &
                     part%duration, along(family, course, part, part%begins), along(family, &
                     course, part, part%ends), units_of(family, course, part), here, least, &
                     merge(family%rests%rows(next)*family%rests%walls(next), 0, &
                     part%number == 0))
               end associate
            else
               call least_gap(course%run%regimes(part%regime), part%x, part%v, part%time, &
                  part%duration, [part%begins], [part%ends], units_of(family, course, part), &
                  here, least)
            end if
            if (least < value) then
               value = least
               touch = here
            end if
            here = condition_type(rest_splits, touch%index, bound=real(part%number, wp))
            call least_force(family, course, part, here, least)
            if (least < value) then
               value = least
               touch = here
            end if
         end associate
      end do
   end subroutine least_of_symbol

   !> What is at its limit where a flight begins or ends: in bounces of an accumulation and after a
   !! release also the friction along the gap, whose speed is that of the gap.
   pure function along(family, course, part, number) result(numbers)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> The period.
      type(course_type), intent(in) :: course
      !> The flight or rest.
      type(segment_type), intent(in) :: part
      !> The gap, stop or friction that it begins or ends with; 0 if there is none.
      integer, intent(in) :: number
      integer, allocatable :: numbers(:)
      integer :: gap, j

      numbers = [number]
      if (all(family%rests%kinds(part%symbol) /= [first, release])) return
      gap = number
      ! where friction turns in a bounce, the gap is open by as little as rounding
      if (part%number > 0) gap = family%rests%gaps(part%symbol)
      if (gap == 0) return
      associate (structure => course%run%structure)
         if (structure%has_friction) numbers = [gap, pack([(j, j=1, size(structure%openings))], &
            [(abs(factor_along(structure, j, gap)) > 0, j=1, size(structure%openings))])]
      end associate
   end function along

   !> The least contact force of a rest, or, of a gap that is released at its end, the least ratio
   !! of its force to the time that is left.
   pure subroutine least_force(family, course, part, touch, value)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> The period.
      type(course_type), intent(in) :: course
      !> The rest.
      type(segment_type), intent(in) :: part
      !> In and out: side and share are set; the side is the number of channels plus the gap.
      type(condition_type), intent(inout) :: touch
      !> The value; `wide` where nothing rests.
      real(wp), intent(out) :: value
      !> Nodes per time unit of the structure, and limits on their number.
      integer, parameter :: density = 4, fewest = 16, most_nodes = 4000
      real(wp) :: before, ratio, share, slope, unit, low, high
      logical :: ends
      integer :: j, k, nodes, pass, row

      value = wide
      associate (regime => course%run%regimes(part%regime), structure => course%run%structure, &
         frequency => course%run%load%frequency)
         if (size(regime%resting) == 0 .or. .not. part%duration > 0) return
         nodes = max(fewest, min(most_nodes, ceiling(density*part%duration/regime%unit)))
         do j = 1, size(regime%resting)
            row = structure%channels + j
            ends = regime%resting(j) == part%ends
            unit = structure%effective(regime%resting(j))*family%rests%speed*frequency
            if (ends) unit = unit*frequency
            before = -1
            do k = 0, nodes
               call at(k/real(nodes, wp), ratio, slope)
               if ((k == 0 .or. k == nodes) .and. ratio < value) then
                  value = ratio
                  touch%side = structure%channels + regime%resting(j)
                  touch%share = k/real(nodes, wp)
                  ! at the release itself this is no exchange of events
                  if (ends) touch%share = 0.5_wp*touch%share
               end if
               if (k > 0 .and. before < 0 .and. slope > 0) then
                  low = (k - 1)/real(nodes, wp)
                  high = k/real(nodes, wp)
                  do pass = 1, 50
                     share = 0.5_wp*(low + high)
                     call at(share, ratio, slope)
                     if (slope < 0) low = share
                     if (.not. slope < 0) high = share
                  end do
                  if (ratio < value) then
                     value = ratio
                     touch%side = structure%channels + regime%resting(j)
                     touch%share = share
                  end if
                  call at(k/real(nodes, wp), ratio, slope)
               end if
               before = slope
            end do
         end do
      end associate
   contains
      !> The force, or its ratio to the time that is left, and a number with the sign of its rate.
      pure subroutine at(share, ratio, slope)
         !> Share of the duration.
         real(wp), intent(in) :: share
         !> The results.
         real(wp), intent(out) :: ratio, slope
         real(wp), dimension(size(course%run%regimes(part%regime)%upper)) :: y, rate
         real(wp) :: left

         associate (regime => course%run%regimes(part%regime))
            call rows_at(regime, regime%rows, part%x, part%v, part%time, share*part%duration, y, &
               rate)
         end associate
         ratio = y(row)/unit
         slope = rate(row)
         if (.not. ends) return
         left = (1 - share)*part%duration
         slope = rate(row)*left + y(row)
         if (share < 1) then
            ratio = ratio/left
         else
            ratio = -rate(row)/unit
            slope = 0
         end if
      end subroutine at
   end subroutine least_force

   !> The load phases of all symbols, in order.
   pure function phases_of(family, unknowns) result(phases)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> Its unknowns.
      real(wp), intent(in) :: unknowns(:)
      real(wp) :: phases(size(family%rests%kinds))

      ! the one that begins the period is last
      associate (first => size(unknowns) - size(phases) + 1, last => &
         family%rests%end_of_turn(unknowns))
         phases = [unknowns(first + 1:), last]
         ! of a self-excited motion shares of the period
         if (family%rests%free) phases = (family%rests%whole_turn()/last)*phases
      end associate
   end function phases_of

   !> The load phases of all symbols but releases; their approach speeds are not known here.
   pure function whole_of(family, unknowns) result(whole)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> Its unknowns.
      real(wp), intent(in) :: unknowns(:)
      real(wp), allocatable :: whole(:)

      associate (s => family%rests)
         whole = pack(family%phases_of(unknowns), s%kinds /= release)
         if (s%halved) whole = [whole, whole + s%whole_turn()]
         whole = [spread(ieee_value(1.0_wp, ieee_quiet_nan), 1, size(whole)), whole]
      end associate
   end function whole_of

   !> No motion: load phases of impacts do not give one.
   pure function part_of(family, c, whole) result(unknowns)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> The parameters.
      real(wp), intent(in) :: c(:)
      !> What a table shows of a motion.
      real(wp), intent(in) :: whole(:)
      real(wp), allocatable :: unknowns(:)

      associate (not_used => c, nor => whole)
         allocate (unknowns(family%unknown_count()), source=0.0_wp)
      end associate
   end function part_of

   !> Whether the period at a place has other symbols than the family: all values are -1 at once.
   pure logical function has_other_symbols(family, values)
      !> The family.
      class(structure_resting_type), intent(in) :: family
      !> The values of all conditions there.
      real(wp), intent(in) :: values(:)

      has_other_symbols = count(values <= -1) > size(family%rests%kinds)
   end function has_other_symbols

end module vi_structure_resting_family
