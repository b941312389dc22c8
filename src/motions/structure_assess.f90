!> Multipliers of a periodic motion of a structure, and the verdicts on it.
module vi_structure_assess
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
   use vi_assess, only: admission, consistency, stability
   use vi_channels, only: first_event, leading_term, leaving_type, pace_type, reached_type, &
      space_type
   use vi_eigen_routines, only: dgesv
   use vi_exact, only: exact_acceptance
   use vi_kinds, only: wp
   use vi_lapack_routines, only: geev
   use vi_modes, only: advance
   use vi_motion, only: no, unknown, yes
   use vi_status, only: stat
   use vi_structure, only: regime_type, restitution_of, structure_type
   use vi_structure_exact, only: instant
   use vi_structure_map, only: apply_flight, apply_impact, from_coordinates, to_coordinates
   use vi_structure_motion, only: equations_type, impulse_of, since, state_after
   implicit none (type, external)
   private

   public :: assess_multipliers, assess_structure, coupling_at_instants

   !> How impacts at one instant are coupled: an impulse changes nothing on the other gap, its
   !! acceleration, or its speed.
   integer, parameter, public :: none = 0, by_damping = 1, by_mass = 2

   !> The multipliers of a motion, and the verdicts: consistent, admissible, stable.
   type, public :: structure_verdicts_type
      !> (2n, 2n) The derivative of the period of (q, q'), from just after the first impact.
      real(wp), allocatable :: p(:, :)
      !> (2n) Its eigenvalues, in order of decreasing modulus; NaN if there are none.
      complex(wp), allocatable :: multipliers(:)
      !> det[P], and what it must be.
      real(wp) :: determinant = 0, law = 0
      integer :: consistent = unknown, admissible = unknown, stable = unknown
   end type structure_verdicts_type

   !> The required agreement of times and speeds of the search for contacts with those of the
   !! motion, relative to the period and the largest speed.
   real(wp), parameter :: agreement = 1.0e-8_wp
   !> A leading multiplier this close to the unit circle is compared with the effect of rounding.
   real(wp), parameter :: near_circle = 1.0e-3_wp
   !> How close to 1 the multiplier of a free phase must be.
   real(wp), parameter :: trivial = 1.0e-7_wp

contains

   !> The multipliers of a motion without rest, and its verdicts.
   pure subroutine assess_structure(structure, regime, equations, speeds, offsets, residual, &
      verdicts)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Its regime without resting gaps.
      type(regime_type), intent(in) :: regime
      !> The equations of the motion, and their solution.
      type(equations_type), intent(in) :: equations
      !> (N) Approach speeds, (p) offsets, and the relative residual.
      real(wp), intent(in) :: speeds(:), offsets(:), residual
      !> The verdicts.
      type(structure_verdicts_type), intent(out) :: verdicts
      real(wp), dimension(size(regime%modes%stiffness)) :: x, v, x_after, v_after, x_here, v_here
      real(wp), dimension(2*size(x), 2*size(x)) :: d, unit
      real(wp) :: flight, rounding, impulse, slope
      type(reached_type) :: reached
      logical :: first, complete
      integer :: coupling, i, j, n, next, status

      n = size(speeds)
      allocate (verdicts%multipliers(2*size(x)), source=cmplx(ieee_value(1.0_wp, ieee_quiet_nan), &
         0.0_wp, wp))
      allocate (verdicts%p(2*size(x), 2*size(x)), source=ieee_value(1.0_wp, ieee_quiet_nan))
      verdicts%consistent = consistency(residual, exact_acceptance)
      unit = 0
      do i = 1, size(d, 1)
         unit(i, i) = 1
      end do
      call from_coordinates(regime, unit, d)
      first = .true.
      complete = .true.
      rounding = 0
      verdicts%law = exp(-2*sum(regime%modes%damping)*equations%period)
      call state_after(structure, regime, equations, speeds, offsets, 1, x_after, v_after)
      do j = 1, n
         next = modulo(j, n) + 1
         flight = since(equations%times, equations%period, next, j)
         x_here = x_after
         v_here = v_after
         if (verdicts%consistent == yes) then
            call first_contact(structure, regime, equations, speeds, j, x_here, v_here, flight, &
               reached)
            complete = complete .and. reached%complete
            first = first .and. agrees(regime, equations, next, flight, reached)
         end if
         call advance(regime%modes, flight, x_here, v_here, x, v)
         call state_after(structure, regime, equations, speeds, offsets, next, x_after, v_after)
         call apply_flight(regime, flight, d)
         call apply_impact(structure, regime, equations%gaps(next), &
            regime%frequency*equations%times(next), speeds(next), x, v, x_after, v_after, d, status)
         if (status /= stat%ok) then
            if (verdicts%consistent == yes) verdicts%admissible = no
            return
         end if
         call impulse_of(structure, equations%gaps(next), speeds(next), impulse, slope)
         associate (effective => structure%effective(equations%gaps(next)))
            verdicts%law = verdicts%law*(impulse/(effective*speeds(next)) - 1)*(slope/effective - 1)
         end associate
         rounding = max(rounding, maxval(speeds)/speeds(next))
      end do
      coupling = coupling_at_instants(structure, equations%gaps, [(findloc(are_together(equations, &
         i), .true., dim=1), i=1, n)])
      if (coupling == none) then
         call to_coordinates(regime, d, verdicts%p)
         call assess_multipliers(rounding*epsilon(1.0_wp), verdicts)
      else
         verdicts%determinant = ieee_value(1.0_wp, ieee_quiet_nan)
      end if
      if (verdicts%consistent == yes .and. coupling /= by_mass) then
         verdicts%admissible = admission(all(speeds > 0) .and. first, complete)
      end if
   end subroutine assess_structure

   !> How impacts at one instant are coupled.
   !!
   !! If an impulse changes the acceleration of the other gap, the speed of an impact that comes
   !! slightly later changes by the time between both, and a disturbance grows by a factor that
   !! depends on the order: the period has no derivative.
   pure integer function coupling_at_instants(structure, gaps, instants) result(coupling)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> (N) The gaps of the impacts; equal numbers for impacts at one instant.
      integer, intent(in) :: gaps(:), instants(:)
      real(wp), parameter :: rounding = 1.0e-12_wp
      integer :: i, j

      coupling = none
      do i = 1, size(gaps)
         do j = i + 1, size(gaps)
            if (instants(i) /= instants(j)) cycle
            associate (one => structure%mobility(:, gaps(i)), &
               other => structure%mobility(:, gaps(j)), &
               direction => structure%directions(:, gaps(i)), damping => structure%damping)
               if (abs(dot_product(direction, other)) > rounding*dot_product(abs(direction), &
                  abs(other))) then
                  coupling = by_mass
                  return
               else if (abs(dot_product(one, matmul(damping, other))) > rounding*dot_product( &
                  abs(one), matmul(abs(damping), abs(other)))) then
                  coupling = by_damping
               end if
            end associate
         end do
      end do
   end function coupling_at_instants

   !> The first contact of a flight of the motion.
   !!
   !! An impact with R = 0 leaves no speed. Then the acceleration of the gap has to open it; where
   !! rounding hides its sign, the search is not complete.
   pure subroutine first_contact(structure, regime, equations, speeds, i, x, v, flight, reached)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> The equations of the motion.
      type(equations_type), intent(in) :: equations
      !> (N) Approach speeds.
      real(wp), intent(in) :: speeds(:)
      !> The impact after which it begins.
      integer, intent(in) :: i
      !> (m) The pairs there.
      real(wp), intent(in) :: x(:), v(:)
      !> Its duration.
      real(wp), intent(in) :: flight
      !> The contact.
      type(reached_type), intent(out) :: reached
      type(space_type) :: space
      type(leaving_type) :: leaving
      real(wp) :: restitution, slope
      type(pace_type) :: pace
      integer :: sense

      associate (gap => equations%gaps(i), phase => regime%frequency*equations%times(i))
         call restitution_of(structure, gap, speeds(i), restitution, slope)
         leaving = leaving_type(structure%channel(gap), structure%wall(gap), restitution*speeds(i))
         if (.not. abs(leaving%speed) > 0) then
            call leading_term(regime, x, v, phase, leaving%row, 2, leaving%order, sense)
            if (.not. -leaving%wall*sense > 0) then
               reached = reached_type(leaving%row, leaving%wall)
               return
            end if
         end if
         call first_event(regime, x, v, phase, leaving, flight + agreement*equations%period, pace, &
            reached, space)
         if (leaving%order > 2) reached%complete = .false.
      end associate
   end subroutine first_contact

   !> Whether the first contact is the next impact of the motion.
   pure logical function agrees(regime, equations, next, flight, reached)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> The equations of the motion.
      type(equations_type), intent(in) :: equations
      !> The next impact.
      integer, intent(in) :: next
      !> Duration of the flight, and the first contact after its beginning.
      real(wp), intent(in) :: flight
      type(reached_type), intent(in) :: reached

      agrees = .false.
      if (reached%row == 0) return
      ! of impacts at one instant on gaps that are not coupled any may come first
      agrees = any(equations%gaps == merge(regime%upper_gap(reached%row), &
         regime%lower_gap(reached%row), reached%wall > 0) .and. are_together(equations, next)) &
         .and. abs(reached%time - flight) <= agreement*equations%period
   end function agrees

   !> Which impacts are at the instant of a given one.
   pure function are_together(equations, impact) result(together)
      !> The equations of the motion.
      type(equations_type), intent(in) :: equations
      !> The impact.
      integer, intent(in) :: impact
      logical :: together(size(equations%times))
      real(wp) :: apart(size(equations%times))

      apart = abs(equations%times - equations%times(impact))
      together = min(apart, abs(equations%period - apart)) <= instant*equations%period
   end function are_together

   !> Eigenvalues of [P] (DGEEV), its determinant, and the verdict on stability.
   !!
   !! The verdict is given only if [P] agrees with the law of its determinant, and only if rounding
   !! cannot move the leading multiplier across the unit circle. Where the phase is free, the
   !! trivial multiplier 1 does not count.
   pure subroutine assess_multipliers(rounding, verdicts, free)
      !> Relative rounding of [P], besides its own.
      real(wp), intent(in) :: rounding
      !> In: [P] and the law. Out: with multipliers, determinant and the verdict on stability.
      type(structure_verdicts_type), intent(inout) :: verdicts
      !> Whether the phase is free; not by default.
      logical, intent(in), optional :: free
      real(wp), allocatable, dimension(:, :) :: a, left, right
      real(wp), allocatable :: re(:), im(:), work(:)
      complex(wp), allocatable :: x(:), y(:)
      integer, allocatable :: order(:), pivot(:)
      real(wp) :: unused(1, 1), bound, condition, doubt
      integer :: i, info, j, leading, n

      n = size(verdicts%p, 1)
      if (.not. all(ieee_is_finite(verdicts%p))) return
      allocate (a, source=verdicts%p)
      allocate (left(n, n), right(n, n), re(n), im(n), work(66*n), pivot(n))
      call geev('V', 'V', n, a, n, re, im, left, n, right, n, work, size(work), info)
      if (info /= 0) return
      allocate (order(n))
      order = [(i, i=1, n)]
      do i = 2, n
         j = i
         do while (j > 1)
            if (hypot(re(order(j - 1)), im(order(j - 1))) >= hypot(re(i), im(i))) exit
            order(j) = order(j - 1)
            j = j - 1
         end do
         order(j) = i
      end do
      verdicts%multipliers = cmplx(re(order), im(order), wp)
      a = verdicts%p
      bound = 1
      do i = 1, n
         bound = bound*norm2(a(:, i))
      end do
      call dgesv(n, 0, a, n, pivot, unused, n, info)
      verdicts%determinant = 1
      do i = 1, n
         verdicts%determinant = verdicts%determinant*merge(a(i, i), -a(i, i), pivot(i) == i)
      end do
      if (.not. abs(verdicts%determinant - verdicts%law) <= 1.0e-9_wp*abs(verdicts%law) &
         + 1.0e3_wp*(epsilon(1.0_wp) + rounding)*bound) return
      leading = 1
      if (present(free)) then
         if (free) then
            j = minloc(abs(verdicts%multipliers - 1), 1)
            if (.not. abs(verdicts%multipliers(j) - 1) <= trivial) return
            leading = merge(2, 1, j == 1)
         end if
      end if
      i = order(leading)
      verdicts%stable = stability(abs(verdicts%multipliers(leading)))
      ! where rounding hides the law, a contraction still has a determinant below 1
      if (verdicts%stable == yes .and. .not. abs(verdicts%determinant) < 1) then
         verdicts%stable = unknown
      end if
      if (abs(abs(verdicts%multipliers(leading)) - 1) > near_circle) return
      ! |y^H x| of the unit eigenvectors is the inverse of the condition of the multiplier. DGEEV
      ! stores a complex pair with the positive imaginary part first; sorting keeps that order
      allocate (x(n), y(n))
      if (abs(im(i)) > 0) then
         x = cmplx(right(:, i), right(:, i + 1), wp)
         y = cmplx(left(:, i), left(:, i + 1), wp)
      else
         x = cmplx(right(:, i), 0.0_wp, wp)
         y = cmplx(left(:, i), 0.0_wp, wp)
      end if
      condition = abs(dot_product(y, x))
      doubt = 100*(epsilon(1.0_wp) + rounding)*norm2(verdicts%p)
      if (.not. abs(abs(verdicts%multipliers(leading)) - 1)*condition > doubt) verdicts%stable = &
         unknown
   end subroutine assess_multipliers

end module vi_structure_assess
