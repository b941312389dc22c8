!> Families of motions of a pair with rest: unknowns, equations and conditions of vi_rest_family.
module vi_resting_family
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_kinds, only: two_pi, wp
   use vi_linear, only: most
   use vi_motion_family, only: at_fault, condition_type, coordinates_type, edge, flip, fold, &
      grazing, motion_family_type, neimark_sacker, parameters_at, rest_splits, rest_vanishes, &
      searched_type, set_differences, to_point, zero_approach
   use vi_orbit, only: by_clearance
   use vi_oscillator, only: left, right
   use vi_releases, only: most_simulations, release_type, simulate_releases
   use vi_rest_family, only: follow_symbols, measure_type, new_rest_family, rest_family_type, &
      rest_period, rest_period_type, rest_stability, rest_unknowns
   use vi_spectrum, only: spectrum_type
   implicit none (type, external)
   private

   public :: new_resting_family

   !> The unknowns are the load phase and asinh(v/D) at the release that begins a period, and the
   !! phases of the first impacts of its symbols; the parameters are r, log(D), xi, mu, R1, R2.
   type, extends(motion_family_type), public :: resting_family_type
      type(rest_family_type) :: rest
   contains
      procedure :: unknown_count, wrap_phases, set_equations
      procedure :: condition_count, set_conditions, condition_value
      procedure :: whole_of, part_of, from_vertex, motions_at, has_other_symbols
   end type resting_family_type

contains

   !> The family of a pattern.
   pure function new_resting_family(symbols, cycles) result(family)
      !> +1, -1, +2, -2
      integer, intent(in) :: symbols(:)
      !> Load cycles k of the period.
      integer, intent(in) :: cycles
      type(resting_family_type) :: family

      family%rest = new_rest_family(symbols, cycles)
      family%jumps = .true.
      family%simulated = .true.
      allocate (family%repetitions(0), family%images(0))
   end function new_resting_family

   !> Number of unknowns.
   pure integer function unknown_count(family)
      !> The family.
      class(resting_family_type), intent(in) :: family

      unknown_count = rest_unknowns(family%rest)
   end function unknown_count

   !> Removes whole load cycles that all phases of a difference have in common.
   pure subroutine wrap_phases(family, offset)
      !> The family.
      class(resting_family_type), intent(in) :: family
      !> In and out: a difference of unknowns, or of points, which begin with them.
      real(wp), intent(inout) :: offset(:)
      integer :: n

      n = size(family%rest%symbols)
      offset(3:2 + n) = offset(3:2 + n) - two_pi*nint(offset(1)/two_pi)
      offset(1) = offset(1) - two_pi*nint(offset(1)/two_pi)
   end subroutine wrap_phases

   !> Residuals of the motion and of conditions, each with its gradient.
   pure subroutine set_equations(family, coordinates, conditions, point, b, a)
      !> The family.
      class(resting_family_type), intent(in) :: family
      !> The parameters.
      type(coordinates_type), intent(in) :: coordinates
      !> Conditions that are to be zero.
      type(condition_type), intent(in) :: conditions(:)
      !> A guess.
      real(wp), intent(in) :: point(:)
      !> Out: as in vi_motion_family.
      real(wp), intent(inout) :: b(2, most), a(most, most)
      type(rest_period_type) :: period
      type(measure_type) :: measure
      integer :: j, m, n

      m = rest_unknowns(family%rest)
      n = m + size(conditions)
      b(1, :n) = at_fault
      a(:size(point), :n) = 0
      call rest_period(family%rest, point(:m), parameters_at(coordinates, point(m + 1:)), period, &
         touching_in(conditions))
      if (.not. period%right) return
      do j = 1, n
         if (j <= m) then
            measure = period%equations(j)
         else
            measure = measure_in_period(period, conditions(j - m))
         end if
         b(1, j) = measure%value
         a(:m + 2, j) = measure%by(:m + 2)
         call to_point(coordinates, m, a(:, j))
      end do
      do j = 1, size(conditions)
         if (conditions(j)%kind <= neimark_sacker) call set_differences(family, coordinates, &
            conditions(j), point, 1, a(:size(point), m + j))
      end do
      if (any(coordinates%active > by_clearance)) call differences(family, coordinates, &
         conditions, point, a)
   end subroutine set_equations

   !> The derivatives of the equations with respect to parameters other than r and log(D), by
   !! central differences.
   pure subroutine differences(family, coordinates, conditions, point, a)
      !> The family.
      class(resting_family_type), intent(in) :: family
      !> The parameters.
      type(coordinates_type), intent(in) :: coordinates
      !> Conditions that are to be zero.
      type(condition_type), intent(in) :: conditions(:)
      !> A guess.
      real(wp), intent(in) :: point(:)
      !> In and out: gradients, a column each; the rows of such parameters are set.
      real(wp), intent(inout) :: a(most, most)
      real(wp), parameter :: h = 1.0e-6_wp
      real(wp) :: moved(size(point)), ahead(rest_unknowns(family%rest) + size(conditions))
      integer :: k, m

      m = rest_unknowns(family%rest)
      do k = 1, size(coordinates%active)
         if (coordinates%active(k) <= by_clearance) cycle
         moved = point
         moved(m + k) = point(m + k) + h
         ahead = residuals_at(moved)
         moved(m + k) = point(m + k) - h
         a(m + k, :size(ahead)) = (ahead - residuals_at(moved))/(2*h)
      end do
   contains
      !> Residual of the period at a point, and the conditions that the same period gives.
      pure function residuals_at(point) result(values)
         !> The point.
         real(wp), intent(in) :: point(:)
         real(wp) :: values(size(ahead))
         type(rest_period_type) :: period
         type(measure_type) :: measure
         integer :: j

         values = at_fault
         call rest_period(family%rest, point(:m), parameters_at(coordinates, point(m + 1:)), period)
         if (.not. period%right) return
         values(:m) = period%equations%value
         do j = 1, size(conditions)
            measure = measure_in_period(period, conditions(j))
            values(m + j) = measure%value
         end do
      end function residuals_at
   end subroutine differences

   !> Number of conditions.
   pure integer function condition_count(family)
      !> The family.
      class(resting_family_type), intent(in) :: family

      condition_count = 3 + 3*size(family%rest%symbols)
   end function condition_count

   !> The values of all conditions: fold, flip, Neimark-Sacker, then approaches, gaps and rests by
   !! symbol; -1 where the symbols cannot be followed.
   pure subroutine set_conditions(family, unknowns, c, values, found, spectrum)
      !> The family.
      class(resting_family_type), intent(in) :: family
      !> Phase and asinh(v/D) at the release, phases of the first impacts; the parameters.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> (m) Value of each condition, positive where it is met.
      real(wp), intent(out) :: values(:)
      !> (m) The conditions; grazing with its wall and flight.
      type(condition_type), intent(out) :: found(:)
      !> Not set.
      type(spectrum_type), intent(out) :: spectrum
      type(rest_period_type) :: period
      type(measure_type) :: measure
      integer :: j, n

      spectrum%regular = .false.
      n = size(family%rest%symbols)
      found(:3) = [condition_type(fold), condition_type(flip), condition_type(neimark_sacker)]
      do j = 1, n
         found(3 + j) = condition_type(zero_approach, j)
         found(3 + n + j) = condition_type(grazing, j)
         found(3 + 2*n + j) = condition_type(rest_vanishes, j, bound=family%apart)
      end do
      call rest_period(family%rest, unknowns, c, period)
      values = -1
      if (.not. period%right) return
      do j = 1, size(values)
         if (found(j)%kind == grazing) then
            found(j)%side = period%touched(found(j)%index)
            found(j)%share = period%touched_at(found(j)%index)
            if (found(j)%share < 0) found(j)%kind = rest_splits
         end if
         measure = measure_in_period(period, found(j))
         values(j) = measure%value
      end do
   end subroutine set_conditions

   !> The value of one condition; not a number where the symbols cannot be followed.
   pure real(wp) function condition_value(family, unknowns, c, condition) result(value)
      !> The family.
      class(resting_family_type), intent(in) :: family
      !> Phase and asinh(v/D) at the release, phases of the first impacts; the parameters.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> The condition.
      type(condition_type), intent(in) :: condition
      type(rest_period_type) :: period
      type(measure_type) :: measure

      call rest_period(family%rest, unknowns, c, period, touching_in([condition]))
      value = ieee_value(1.0_wp, ieee_quiet_nan)
      if (.not. period%right) return
      measure = measure_in_period(period, condition)
      value = measure%value
   end function condition_value

   !> The symbol in which one of the conditions has a bounce touch the wall; 0 if there is none.
   pure integer function touching_in(conditions) result(symbol)
      !> The conditions that are zero.
      type(condition_type), intent(in) :: conditions(:)

      symbol = findloc(conditions%kind == grazing .and. conditions%share > 1, .true., dim=1)
      if (symbol > 0) symbol = conditions(symbol)%index
   end function touching_in

   !> The value of a condition in a period, and its gradient; the gradients of fold, flip and
   !! Neimark-Sacker are left at 0.
   pure type(measure_type) function measure_in_period(period, condition) result(measure)
      !> The period; without a value if `right` is false.
      type(rest_period_type), intent(in) :: period
      !> The condition.
      type(condition_type), intent(in) :: condition
      real(wp) :: stability(3)

      if (.not. period%right) return
      associate (i => condition%index)
         select case (condition%kind)
         case (fold, flip, neimark_sacker)
            stability = rest_stability(period)
            measure%value = stability(condition%kind)
         case (zero_approach)
            measure = period%approach(i)
         case (grazing, rest_splits)
            measure = period%gap(i)
         case (rest_vanishes)
            measure = period%rest(i)
         case default
            continue
         end select
      end associate
   end function measure_in_period

   !> Whether the period at a place has other symbols than the family: all values are -1 at once.
   pure logical function has_other_symbols(family, values)
      !> The family.
      class(resting_family_type), intent(in) :: family
      !> The values of all conditions there.
      real(wp), intent(in) :: values(:)

      has_other_symbols = count(values <= -1) > size(family%rest%symbols)
   end function has_other_symbols

   !> v/D and the load phase at the release.
   pure function whole_of(family, unknowns) result(whole)
      !> The family.
      class(resting_family_type), intent(in) :: family
      !> Its unknowns.
      real(wp), intent(in) :: unknowns(:)
      real(wp), allocatable :: whole(:)

      associate (not_used => family%apart)
         whole = [sinh(unknowns(2)), unknowns(1)]
      end associate
   end function whole_of

   !> The unknowns from the load phase and v/D at the release; where the symbols cannot be followed
   !! they are those of no motion.
   pure function part_of(family, c, whole) result(unknowns)
      !> The family.
      class(resting_family_type), intent(in) :: family
      !> The parameters.
      real(wp), intent(in) :: c(:)
      !> Phase and v/D; what follows is not used.
      real(wp), intent(in) :: whole(:)
      real(wp), allocatable :: unknowns(:)
      logical :: good

      allocate (unknowns(rest_unknowns(family%rest)))
      call follow_symbols(family%rest, [whole(1), asinh(whole(2))], c, unknowns, good)
      if (.not. good) unknowns(3:) = unknowns(1)
   end function part_of

   !> The unknowns from v/D and the load phase at the release.
   pure function from_vertex(family, c, x, theta) result(unknowns)
      !> The family.
      class(resting_family_type), intent(in) :: family
      !> The parameters.
      real(wp), intent(in) :: c(:)
      !> (1) v/D and the phase.
      real(wp), intent(in) :: x(:), theta(:)
      real(wp), allocatable :: unknowns(:)

      allocate (unknowns, source=family%part_of(c, [theta(1), x(1)]))
   end function from_vertex

   !> Guesses of motions, from the last releases of some simulations.
   subroutine motions_at(family, c, guesses, skip, found, releases, progress, longer, searched)
      !> The family.
      class(resting_family_type), intent(in) :: family
      !> r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> Largest number of simulations; `skip` is not used.
      integer, intent(in) :: guesses, skip
      !> (unknowns, m) The guesses whose symbols can be followed.
      real(wp), allocatable, intent(out) :: found(:, :)
      !> The last releases of each simulation, if they have been made already.
      type(release_type), intent(in), optional :: releases(:)
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> Factor of the load cycles simulated; 1 by default.
      integer, intent(in), optional :: longer
      !> Not used.
      type(searched_type), intent(inout), optional :: searched
      type(release_type), allocatable :: simulated(:)
      integer :: k, kept, wall
      logical :: good

      associate (not_used => skip, nor => present(searched))
      end associate
      if (present(releases)) then
         allocate (simulated, source=releases)
      else
         allocate (simulated(min(guesses, most_simulations)))
         call simulate_releases(c, simulated, progress=progress, longer=longer)
      end if
      allocate (found(family%unknown_count(), size(simulated)))
      associate (last => family%rest%symbols(size(family%rest%symbols)))
         wall = merge(right, left, last > 0)
      end associate
      kept = 0
      do k = 1, size(simulated)
         if (.not. simulated(k)%there(wall)) cycle
         call follow_symbols(family%rest, simulated(k)%at(:, wall), c, found(:, kept + 1), good)
         if (good) kept = kept + 1
      end do
      found = found(:, :kept)
   end subroutine motions_at

end module vi_resting_family
