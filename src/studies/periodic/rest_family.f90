!> Families of motions with rest: one period from a release on a wall to the next one.
!!
!! Where a rest ends both masses have the same velocity v and the primary mass has no acceleration,
!! so x = f sin(phase) - 2 xi v: two numbers describe the state at a release. A symbol is an impact,
!! or all the impacts that accumulate on a wall and the rest there. The unknowns are the load phase
!! and asinh(v/D) at the release that ends the last symbol (v/D grows without bound as D falls; its
!! logarithm changes at about the same rate as log D), and the load phases of the first impacts of
!! all symbols. The equations state that the free mass is at the wall at each of these phases, and
!! that the state at the end of the period is that at its start.
!!
!! The equations stay smooth where the free mass touches a wall during a flight and where an
!! approach speed falls to zero. An accumulation that just fails to complete is still treated as
!! complete. The ends of the family are zeros of smooth measures: the gap of a flight, an approach
!! speed, the duration of the rest after an accumulation, and the contact force before a release.
!! Derivatives with respect to the unknowns, r and log D are computed along with them
!! (vi_variation).
!!
!! A rest splits into two where the contact force touches zero before the release, or where the gap
!! closes again after it. Both meet at a cusp, where the force has an inflection at the release.
!! With t before the release the force is F(-t), and with t after it the gap is g(t), whose second
!! derivative is -F at first: F(-t)/t and 6 g(t)/t**3 begin with the same value and rate of change,
!! so the lesser of their minima is a measure that is smooth across the cusp.
!!
!! Without restitution (R = 0) the first impact of an accumulation is also the last one.
module vi_rest_family
   use vi_contact, only: contact_type, departure_type, first_contact
   use vi_forced_system, only: forced_system_type, event_type, release_event, set_forced_system
   use vi_extrema, only: relative_extrema
   use vi_flight, only: flight_position, flight_state, flight_type, new_flight
   use vi_bounce, only: bounce, series
   use vi_kinds, only: two_pi, wp
   use vi_orbit, only: by_clearance, by_r, oscillator_of
   use vi_oscillation, only: derivatives, oscillation_type
   use vi_oscillator, only: left, right
   use vi_rest, only: new_rest, release_time
   use vi_variation, only: columns, gap_change, moment_type, release, through_contact, &
      through_flight, through_rest, through_stick, variation_type
   implicit none (type, external)
   private

   public :: critical, follow_symbols, last_release, new_rest_family, plane_map, rest_period, &
      rest_stability, rest_unknowns, set_system

   !> Largest number of impacts followed in one accumulation.
   integer, parameter :: most_hops = 20000

   !> What the motions of one family with rest have in common.
   type, public :: rest_family_type
      !> +1, -1 for an impact, +2, -2 for accumulation and rest; the last symbol is +2 or -2.
      integer, allocatable :: symbols(:)
      integer :: cycles = 1
      !> Number of symbols by which the given pattern was rotated to get this order.
      integer :: turned = 0
   end type rest_family_type

   !> A number and its derivatives with respect to the unknowns, r and log D.
   type, public :: measure_type
      real(wp) :: value = 0, by(columns) = 0
   end type measure_type

   !> The equations and measures of one period.
   type, public :: rest_period_type
      !> Residuals: phase (minus 2 pi k) and asinh(v/D) at the next release, minus those at the
      !! start; then the distance, over D, of the free mass beyond its wall at the first impact of
      !! each symbol.
      type(measure_type), allocatable :: equations(:)
      !> For each symbol: approach speed of its first impact over D; a measure of the duration of
      !! the rest, negative where the accumulation is not completed (for an impact 1 or, without
      !! restitution, the acceleration with which the masses separate); least gap over D at a
      !! stationary point of its flights, to either wall, or the measure of a rest that splits.
      type(measure_type), allocatable :: approach(:), rest(:), gap(:)
      !> Where that gap is: the wall, and the flight (0 after the last event of the symbol, 1, 2 ..
      !! after its impacts) plus the share of its duration; for a force that touches zero, minus the
      !! share of the rest that is left.
      integer, allocatable :: touched(:)
      real(wp), allocatable :: touched_at(:)
      !> Whether all accumulations are completed, so that the other components are defined.
      logical :: right = .false.
   end type rest_period_type

   !> State within a period: just after an event, with its derivatives, and how the next flight
   !! begins.
   type :: place_type
      type(moment_type) :: at
      type(variation_type) :: change
      !> Relative speed at which the masses separate.
      real(wp) :: speed = 0
      !> Whether a rest has just ended, and how much later in phase the contact force passes zero.
      logical :: released = .false.
      real(wp) :: lag = 0
   end type place_type

   !> What is known of the release that ends a rest: its own load phase (side 0), or the wall and
   !! the load phase of the impact after it.
   type :: ending_type
      integer :: side = 0
      real(wp) :: phase = 0
      !> Whether a bounce of the accumulation is known to touch the wall without an impact.
      logical :: touches = .false.
   end type ending_type

   !> A course of an accumulation: state, measures as in `rest_period_type`, and how it ends.
   type :: course_type
      type(place_type) :: here
      type(measure_type) :: rest, gap
      integer :: touched = 0
      real(wp) :: touched_at = 0
      !> Whether it ends with a release; how far that is from the known one (see `miss_at`), and
      !! whether the contact force passes zero again later.
      logical :: good = .false.
      real(wp) :: miss = 0
      logical :: later = .false.
      !> Number of places so far where it could have been continued in another way.
      integer :: forks = 0
   end type course_type

   !> Largest number of forks at which both continuations are tried.
   integer, parameter :: most_forks = 3
   !> `touched_at` of a first rest that is about to be there (see `follow_course`).
   real(wp), parameter :: first_rest = -2

   !> Time after a release (over the shortest time scale) until which the gap is followed by its
   !! series.
   real(wp), parameter :: soon = 0.1_wp

contains

   !> The family of a pattern: its symbols rotated so that a rest is last.
   pure function new_rest_family(symbols, cycles) result(family)
      !> +1, -1, +2, -2
      integer, intent(in) :: symbols(:)
      !> Load cycles k of the period.
      integer, intent(in) :: cycles
      type(rest_family_type) :: family

      family%turned = findloc(abs(symbols) == 2, .true., dim=1, back=.true.)
      allocate (family%symbols(size(symbols)), source=cshift(symbols, family%turned))
      family%cycles = cycles
   end function new_rest_family

   !> Unknowns of a family: the release, and the first impact of each symbol.
   pure integer function rest_unknowns(family)
      !> The family.
      type(rest_family_type), intent(in) :: family

      rest_unknowns = 2 + size(family%symbols)
   end function rest_unknowns

   !> One period from a release.
   pure subroutine rest_period(family, unknowns, c, period, touching)
      !> The family.
      type(rest_family_type), intent(in) :: family
      !> (2 + n) phase and asinh(v/D) at the release, phases of the first impacts.
      real(wp), intent(in) :: unknowns(:)
      !> (6) r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> Equations and measures; `right` is false, and they are undefined, where the symbols cannot
      !! be followed.
      type(rest_period_type), intent(out) :: period
      !> The symbol in which a bounce is known to touch the wall without an impact.
      integer, intent(in), optional :: touching
      type(forced_system_type) :: system
      type(place_type) :: here
      type(ending_type) :: end_of
      real(wp) :: last
      logical :: good
      integer :: i, n, m, before

      n = size(family%symbols)
      m = rest_unknowns(family)
      call set_system(c, .false., system)
      allocate (period%equations(m), period%approach(n), period%rest(n), period%gap(n), &
         period%touched(n), period%touched_at(n))
      period%rest%value = 1
      period%gap%value = 0.5_wp
      period%touched = 0
      period%touched_at = 0
      here = start_of(system, sign(1, family%symbols(n)), unknowns, m)
      last = unknowns(1) + 2*two_pi*family%cycles
      do i = 1, n
         before = modulo(i - 2, n) + 1
         if (.not. unknowns(2 + i) > here%at%phase) return
         call fly(system, sign(1, family%symbols(i)), 2 + i, unknowns(2 + i), here, &
            period%equations(2 + i), period%approach(i), period%gap(before), &
            period%touched(before), period%touched_at(before))
         if (abs(family%symbols(i)) == 1) then
            if (.not. here%speed > 0) period%rest(i) = departure_of(system, here)
            cycle
         end if
         if (i < n) then
            end_of = ending_type(sign(1, family%symbols(i + 1)), unknowns(3 + i))
         else
            end_of = ending_type(0, unknowns(1) + two_pi*family%cycles)
         end if
         if (present(touching)) end_of%touches = touching == i
         call accumulate(system, last, here, period%rest(i), period%gap(i), period%touched(i), &
            period%touched_at(i), good, end_of)
         if (.not. good) return
      end do
      period%equations(1) = measure_type(here%at%phase + here%lag - two_pi*family%cycles &
         - unknowns(1), here%change%state(4, :))
      associate (d => system%clearance, v => here%at%x_dot)
         period%equations(2) = measure_type(asinh(v/d) - unknowns(2), (here%change%state(2, :) &
            - v/d*here%change%clearance)/hypot(v, d))
      end associate
      do i = 1, 2
         period%equations(i)%by(i) = period%equations(i)%by(i) - 1
      end do
      period%right = .true.
   end subroutine rest_period

   !> The derivative of the map from release to release, the phases of the impacts eliminated.
   pure function plane_map(period) result(j)
      !> Equations and measures of the period, with `right` true.
      type(rest_period_type), intent(in) :: period
      real(wp) :: j(2, 2)
      real(wp) :: by(2, size(period%equations)), last(2, size(period%equations))
      integer :: i, k, m

      m = size(period%equations)
      ! derivative of each phase with respect to the release, from the equation that fixes the phase
      ! and from the earlier phases
      by = 0
      do i = 3, m
         associate (e => period%equations(i)%by)
            by(:, i) = -e(:2)
            do k = 3, i - 1
               by(:, i) = by(:, i) - e(k)*by(:, k)
            end do
            by(:, i) = by(:, i)/e(i)
         end associate
      end do
      do i = 1, 2
         last(i, :) = period%equations(i)%by(:m)
         last(i, i) = last(i, i) + 1
         j(i, :) = last(i, :2)
         do k = 3, m
            j(i, :) = j(i, :) + last(i, k)*by(:, k)
         end do
      end do
   end function plane_map

   !> det(I - J), det(I + J) and 1 - det J of the map of the plane of releases, each times the
   !! approach speeds: a multiplier grows like the inverse of such a speed.
   pure function rest_stability(period) result(values)
      !> Equations and measures of the period, with `right` true.
      type(rest_period_type), intent(in) :: period
      real(wp) :: values(3)
      real(wp), dimension(size(period%equations), size(period%equations)) :: a, b
      real(wp) :: phases, plain
      integer :: i, m

      m = size(period%equations)
      do i = 1, m
         a(i, :) = period%equations(i)%by(:m)
      end do
      ! the equations of the phases alone are triangular: their determinant is the product of the
      ! a(i, i), each an approach speed over r
      phases = 1
      do i = 3, m
         phases = phases*(period%approach(i - 2)%value/a(i, i))
      end do
      values(1) = determinant(a)*phases
      b = a
      do i = 1, 2
         b(i, i) = a(i, i) + 2
      end do
      values(2) = determinant(b)*phases
      do i = 1, 2
         b(i, i) = a(i, i) + 1
      end do
      plain = determinant(b)*phases
      values(3) = product(period%approach%value) - plain
   end function rest_stability

   !> The determinant of a matrix, by elimination with partial pivoting.
   pure real(wp) function determinant(matrix)
      !> (n, n)
      real(wp), intent(in) :: matrix(:, :)
      real(wp) :: a(size(matrix, 1), size(matrix, 1)), row(size(matrix, 1))
      integer :: i, k, n, pivot

      a = matrix
      n = size(a, 1)
      determinant = 1
      do k = 1, n
         pivot = k - 1 + maxloc(abs(a(k:, k)), dim=1)
         if (pivot /= k) then
            row = a(k, :)
            a(k, :) = a(pivot, :)
            a(pivot, :) = row
            determinant = -determinant
         end if
         determinant = determinant*a(k, k)
         if (.not. abs(a(k, k)) > 0) return
         do i = k + 1, n
            a(i, k + 1:) = a(i, k + 1:) - a(i, k)/a(k, k)*a(k, k + 1:)
         end do
      end do
   end function determinant

   !> The forced system with given parameters, for a load amplitude of 1.
   pure subroutine set_system(c, marched, system)
      !> (6) r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> As in `set_forced_system`.
      logical, intent(in) :: marched
      !> Out: the system.
      type(forced_system_type), intent(inout) :: system

      call set_forced_system(oscillator_of(c), c(by_r), 1.0_wp, exp(c(by_clearance)), marched, &
         system)
   end subroutine set_system

   !> The release with which a period starts.
   pure function start_of(system, side, unknowns, m) result(start)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The wall, +1 or -1.
      integer, intent(in) :: side
      !> Phase and asinh(v/D).
      real(wp), intent(in) :: unknowns(:)
      !> Total number of unknowns.
      integer, intent(in) :: m
      type(place_type) :: start

      associate (d => system%clearance, f => system%load, at => start%at, change => start%change)
         at%phase = unknowns(1)
         at%x_dot = sinh(unknowns(2))*d
         at%z_dot = at%x_dot
         at%x = f*sin(at%phase) - 2*system%osc%xi*at%x_dot
         at%side = side
         change%n = m + 2
         change%r(m + 1) = 1
         change%clearance(m + 2) = d
         change%state(4, 1) = 1
         change%state(2, [2, m + 2]) = [hypot(at%x_dot, d), at%x_dot]
         change%state(3, :) = change%state(2, :)
         change%state(1, :) = f*cos(at%phase)*change%state(4, :) &
            - 2*system%osc%xi*change%state(2, :)
      end associate
      start%released = .true.
   end function start_of

   !> Advances to an impact at a given load phase, and through it.
   pure subroutine fly(system, side, column, phase, here, equation, approach, gap, touched, &
      touched_at)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Wall of the impact: +1 right, -1 left.
      integer, intent(in) :: side
      !> Number of the unknown that is this phase.
      integer, intent(in) :: column
      !> Load phase of the impact (rad).
      real(wp), intent(in) :: phase
      !> In: after the last event. Out: after the impact.
      type(place_type), intent(inout) :: here
      !> Distance of the free mass beyond the wall, and approach speed, both over D.
      type(measure_type), intent(out) :: equation, approach
      !> Least gap so far of the symbol that the flight belongs to.
      type(measure_type), intent(inout) :: gap
      !> Wall of that gap: +1 right, -1 left; changed with it.
      integer, intent(inout) :: touched
      !> Flight of that gap, and share of its duration; changed with it.
      real(wp), intent(inout) :: touched_at
      type(flight_type) :: flight
      real(wp), dimension(columns) :: longer, y, before
      real(wp) :: time, d(0:5), speed, restitution
      integer :: n

      time = (phase - here%at%phase)/system%r
      flight = flight_from(system, here%at, time)
      d = derivatives(flight, time)
      call note_gap(system, here, time, 0, gap, touched, touched_at)
      n = here%change%n
      longer = 0
      longer(:n) = -(here%change%state(4, :n) + time*here%change%r(:n))/system%r
      longer(column) = longer(column) + 1/system%r
      restitution = system%osc%restitution(merge(right, left, side > 0))
      call through_flight(system, here%at, time, longer, restitution, here%change, y, before)
      associate (at => here%at, clearance => system%clearance, mu => system%osc%mu)
         equation%value = side*(flight_position(flight, time) - d(0))/clearance - 0.5_wp
         equation%by = (side*y - (equation%value + 0.5_wp)*here%change%clearance)/clearance
         speed = side*(at%z_dot - d(1))
         approach = measure_type(speed/clearance, (side*before - speed/clearance &
            *here%change%clearance)/clearance)
         here%speed = restitution*speed
         at%x = d(0)
         at%x_dot = d(1) + mu/(1 + mu)*(side*(speed + here%speed))
         at%z_dot = at%x_dot - side*here%speed
         at%phase = phase
         at%side = side
      end associate
      here%released = .false.
   end subroutine fly

   !> All unknowns from those of a release: the motion is followed from there to the first impacts
   !! of the symbols.
   pure subroutine follow_symbols(family, release, c, unknowns, good)
      !> The family.
      type(rest_family_type), intent(in) :: family
      !> Phase and asinh(v/D).
      real(wp), intent(in) :: release(2)
      !> (6) r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> (2 + n) phase and asinh(v/D) at the release, phases of the first impacts.
      real(wp), intent(out) :: unknowns(:)
      !> False where a symbol of the family does not follow from the release.
      logical, intent(out) :: good
      type(forced_system_type) :: system
      type(place_type) :: here
      type(contact_type) :: contact
      type(measure_type) :: rest, gap
      real(wp) :: limit, touched_at
      integer :: i, touched

      call set_system(c, .false., system)
      unknowns(:2) = release
      here = start_of(system, sign(1, family%symbols(size(family%symbols))), release, 2)
      touched = 0
      touched_at = 0
      do i = 1, size(family%symbols)
         associate (side => sign(1, family%symbols(i)))
            limit = (release(1) + 2*two_pi*family%cycles - here%at%phase)/system%r
            call next_contact(system, flight_from(system, here%at, limit), here, side, limit, &
               contact, good)
            if (good) call impact_at(system, here, side, contact%time, contact%d(0), contact%d(1), &
               contact%speed, good)
            if (.not. good) return
         end associate
         unknowns(2 + i) = here%at%phase
         if (abs(family%symbols(i)) == 1) cycle
         call accumulate(system, release(1) + 2*two_pi*family%cycles, here, rest, gap, touched, &
            touched_at, good)
         if (.not. good) return
      end do
   end subroutine follow_symbols

   !> The next contact with one wall.
   pure subroutine next_contact(system, flight, here, side, limit, contact, found, from)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The flight that begins at `here`.
      type(flight_type), intent(in) :: flight
      !> State after the last event.
      type(place_type), intent(in) :: here
      !> Wall: +1 right, -1 left; the other wall is ignored, up to twice the clearance beyond it.
      integer, intent(in) :: side
      !> Latest time of a contact (1/omega after the start of the flight).
      real(wp), intent(in) :: limit
      !> The contact.
      type(contact_type), intent(out) :: contact
      !> Whether there is one.
      logical, intent(out) :: found
      !> Time of the flight before which contacts do not count; the gap is open there.
      real(wp), intent(in), optional :: from
      type(flight_type) :: moved
      type(departure_type) :: departure
      real(wp) :: beyond

      ! the other wall is moved so far away that a motion that reaches it does not count
      beyond = 2*system%clearance
      moved = flight
      moved%z = moved%z + side*beyond
      if (here%at%side == side .and. .not. present(from)) departure = departure_type(side, &
         here%speed, here%released)
      contact = first_contact(moved, 0.5_wp*system%clearance + beyond, departure, limit, from)
      found = contact%side == side
   end subroutine next_contact

   !> Advances through an impact a given time after the start of a flight.
   pure subroutine impact_at(system, here, side, time, x, x_dot, speed, good)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: after the last event. Out: after the impact.
      type(place_type), intent(inout) :: here
      !> Wall of the impact: +1 right, -1 left.
      integer, intent(in) :: side
      !> Time of the impact (1/omega after the start of the flight).
      real(wp), intent(in) :: time
      !> Position and velocity of the primary mass at the impact, and the approach speed.
      real(wp), intent(in) :: x, x_dot, speed
      !> False if there is no approach speed.
      logical, intent(out) :: good
      real(wp) :: before(columns), restitution

      associate (at => here%at, mu => system%osc%mu)
         restitution = system%osc%restitution(merge(right, left, side > 0))
         call through_contact(system, at, time, side, restitution, here%change, before, good)
         ! velocities from the approach speed, which keeps its relative accuracy
         here%speed = restitution*speed
         at%x = x
         at%x_dot = x_dot + mu/(1 + mu)*(side*(speed + here%speed))
         at%z_dot = at%x_dot - side*here%speed
         at%phase = at%phase + system%r*time
         at%side = side
      end associate
      here%released = .false.
   end subroutine impact_at

   !> All impacts that accumulate on a wall, and the rest there, from the first impact on.
   !!
   !! The number of impacts is not given. Near an end of the family the same first impact has
   !! several continuations (see `follow_course`); the one is taken that ends as the unknowns do.
   pure subroutine accumulate(system, last, here, rest, gap, touched, touched_at, good, end_of)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Load phase (rad) at which the search ends.
      real(wp), intent(in) :: last
      !> In: after the first impact of the accumulation. Out: after the release.
      type(place_type), intent(inout) :: here
      !> Measure of the duration of the rest.
      type(measure_type), intent(out) :: rest
      !> Least gap so far of the symbol; lowered where a bounce has a smaller one.
      type(measure_type), intent(inout) :: gap
      !> Wall of that gap.
      integer, intent(inout) :: touched
      !> Flight of that gap, and share of its duration.
      real(wp), intent(inout) :: touched_at
      !> False if the accumulation does not come near to completion, or the rest does not end.
      logical, intent(out) :: good
      !> What is known of the release; without it the motion is the one that a simulation follows.
      type(ending_type), intent(in), optional :: end_of
      type(course_type) :: first, course, other
      integer :: choices

      first%here = here
      first%gap = gap
      first%touched = touched
      first%touched_at = touched_at
      course = first
      call follow_course(system, last, 0, course, end_of)
      if (course%forks > 0 .and. present(end_of)) then
         choices = 1
         do while (choices < 2**min(most_forks, course%forks))
            other = first
            call follow_course(system, last, choices, other, end_of)
            other%forks = max(other%forks, course%forks)
            if (other%good .and. .not. (course%good .and. course%miss <= other%miss)) then
               course = other
            else
               course%forks = other%forks
            end if
            choices = choices + 1
         end do
      end if
      good = course%good
      if (.not. good) return
      here = course%here
      rest = course%rest
      gap = course%gap
      touched = course%touched
      touched_at = course%touched_at
   end subroutine accumulate

   !> One of the continuations of an accumulation.
   !!
   !! The accumulation is cut off where this changes the state by less than rounding, or, if it is
   !! not completed, where it comes nearest to that. There are two continuations
   !!
   !! - where a bounce just touches the wall while the acceleration opens the gap: an impact, or
   !!   none, as beyond the grazing boundary of the motions that do not touch it there;
   !! - where the accumulation is completed, or nearly, shortly before the contact force falls
   !!   through zero and will be positive again: the symbol ends with the next release, or further
   !!   impacts follow. The measure of that first rest is positive where the rest is there, and
   !!   the motion then has one more symbol; it falls through zero where the impacts go on.
   pure subroutine follow_course(system, last, choices, course, end_of)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Load phase (rad) at which the search ends.
      real(wp), intent(in) :: last
      !> A bit for each fork, in the order of time: whether the second continuation is taken.
      integer, intent(in) :: choices
      !> In: after the first impact of the accumulation. Out: after the release.
      type(course_type), intent(inout) :: course
      !> What is known of the release.
      type(ending_type), intent(in), optional :: end_of
      !> Largest relative error of cutting off: for a motion, and beyond the end of the family.
      real(wp), parameter :: fine = 1.0e-17_wp, coarse = 1.0e-6_wp
      !> A bounce that is lower than this (over the clearance) has no dip that can be resolved.
      real(wp), parameter :: low = 1.0e-4_wp
      type(place_type) :: best
      real(wp) :: restitution, cost, least, time, x, x_dot, speed, scale, closing, highest
      integer :: bounces
      logical :: good, complete, ends, long

      associate (here => course%here)
         restitution = system%osc%restitution(merge(right, left, here%at%side > 0))
         least = huge(1.0_wp)
         course%good = here%speed >= 0
         if (.not. course%good) return
         if (.not. restitution > 0) then
            call rest_on(system, restitution, last, course, end_of)
            return
         end if
         do bounces = 1, most_hops
            closing = closing_acceleration(system, here%at)
            cost = huge(1.0_wp)
            if (closing > 1.0e-15_wp*(1 + here%speed**2) .and. .not. here%released) cost = &
               here%speed**3/closing**2/max(1.0e-3_wp, 1 - restitution**3)
            scale = system%clearance + abs(here%at%x) + abs(here%at%x_dot)
            if (cost < least) then
               least = cost
               best = here
            end if
            complete = cost <= fine*scale
            ! it was nearly completed, and now the bounces become longer again
            if (complete .or. (least <= coarse*scale .and. 1.0e-3_wp*cost > least)) then
               call end_course(system, restitution, last, complete, choices, best, course, ends, &
                  end_of)
               if (ends) return
               least = huge(1.0_wp)
            end if
            call next_hop(system, here, last, time, x, x_dot, speed)
            if (.not. time > 0) exit
            ! no bounce is higher than this: the gap's acceleration is that of the primary mass,
            ! which may open the gap for a while
            highest = here%speed*time + (system%load + abs(here%at%x) + abs(here%at%x_dot))*time**2
            long = highest > low*system%clearance
            if (long .and. present(end_of)) call pass_by(system, last, choices, &
               end_of%touches, course, time, x, x_dot, speed)
            if (long) call note_gap(system, here, time, bounces, course%gap, course%touched, &
               course%touched_at)
            call impact_at(system, here, here%at%side, time, x, x_dot, speed, good)
            if (.not. good) exit
         end do
         course%good = least <= coarse*(system%clearance + abs(best%at%x) + abs(best%at%x_dot))
         if (.not. course%good) return
         here = best
         call rest_on(system, restitution, last, course, end_of)
      end associate
   end subroutine follow_course

   !> Ends a course with a rest where its accumulation is completed, or nearly, or goes on with it.
   pure subroutine end_course(system, restitution, last, complete, choices, best, course, ends, &
      end_of)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Coefficient of restitution of the wall, and load phase (rad) at which the search ends.
      real(wp), intent(in) :: restitution, last
      !> Whether the accumulation is completed.
      logical, intent(in) :: complete
      !> As in `follow_course`.
      integer, intent(in) :: choices
      !> The impact at which it comes nearest to completion.
      type(place_type), intent(in) :: best
      !> In: after an impact. Out: after the release if it ends; else where further impacts follow.
      type(course_type), intent(inout) :: course
      !> Whether it ends.
      logical, intent(out) :: ends
      !> What is known of the release.
      type(ending_type), intent(in), optional :: end_of
      type(course_type) :: first, final

      first = course
      first%here = best
      final = first
      ends = complete
      if (complete .or. present(end_of)) call rest_on(system, restitution, last, final, end_of)
      if (present(end_of)) ends = .not. (final%good .and. final%later)
      if (complete .and. ends) then
         course = final
         return
      end if
      ! the rest before the contact force first falls through zero
      call rest_on(system, restitution, last, first)
      if (.not. complete) then
         ! in time: the accumulation is not interrupted, its impacts only become slower
         ends = ends .and. first%good .and. first%rest%value <= 0
         if (.not. (first%good .and. first%rest%value <= 0)) return
      end if
      if (.not. ends .and. present(end_of)) then
         ends = .not. btest(choices, course%forks)
         course%forks = course%forks + 1
         final%forks = course%forks
      end if
      if (ends) then
         course = final
         return
      end if
      if (complete) course%here = first%here
      course%good = first%good
      ends = .not. course%good
      if (-first%rest%value < course%gap%value) then
         course%gap = measure_type(-first%rest%value, -first%rest%by)
         course%touched = course%here%at%side
         course%touched_at = first_rest
      end if
   end subroutine end_course

   !> The next impact of a bounce that just touches the wall, if it is not to count as an impact.
   !!
   !! The gap is then negative for a while, and the flight goes on.
   pure subroutine pass_by(system, last, choices, touches, course, time, x, x_dot, speed)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Load phase (rad) at which the search ends.
      real(wp), intent(in) :: last
      !> As in `follow_course`, and whether a touch that is not deep is known not to be an impact.
      integer, intent(in) :: choices
      logical, intent(in) :: touches
      !> In: after an impact. Out: with one more fork, if there is one here.
      type(course_type), intent(inout) :: course
      !> In: the next contact, as in `next_hop`. Out: the next impact.
      real(wp), intent(inout) :: time, x, x_dot, speed
      !> Largest depth of such a touch, over the clearance; of one that is not deep; and of one that
      !! is not distinguished from a mere touch.
      real(wp), parameter :: deepest = 0.05_wp, shallow = 1.0e-3_wp, none = 1.0e-9_wp
      !> First and longest step of the search for its end (over the shortest time scale), and growth
      !! of the steps.
      real(wp), parameter :: first = 1.0e-3_wp, longest = 0.05_wp, growth = 1.1_wp
      type(flight_type) :: flight
      type(contact_type) :: contact
      real(wp) :: limit, step, t, depth, touch, d(0:5)
      logical :: found, opens, passes

      associate (here => course%here, side => course%here%at%side)
         limit = (last - here%at%phase)/system%r
         flight = flight_from(system, here%at, limit)
         d = derivatives(flight, time)
         if (.not. side*d(2) > 0) return
         touch = speed**2/(2*side*d(2))/system%clearance
         ! the gap, which is negative, first closes further and then opens
         step = first/max(1.0_wp, system%r)
         t = time
         opens = .false.
         do
            t = t + step
            step = min(growth*step, longest/max(1.0_wp, system%r))
            if (t > limit) return
            d = derivatives(flight, t)
            depth = side*(flight_position(flight, t) - d(0))/system%clearance - 0.5_wp
            if (depth > deepest) return
            found = side*(flight%z_dot - d(1)) < 0
            if (opens .and. .not. found) exit
            opens = found
         end do
         if (side*(flight_position(flight, t) - d(0)) >= 0.5_wp*system%clearance) return
         call next_contact(system, flight, here, side, limit, contact, found, t)
         if (.not. found) return
         passes = touch < none .or. (touches .and. touch < shallow)
         if (.not. passes) then
            passes = btest(choices, course%forks)
            course%forks = course%forks + 1
         end if
         if (.not. passes) return
         time = contact%time
         x = contact%d(0)
         x_dot = contact%d(1)
         speed = contact%speed
      end associate
   end subroutine pass_by

   !> The acceleration that closes the gap after an impact.
   pure real(wp) function closing_acceleration(system, at) result(a)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> State just after the impact.
      type(moment_type), intent(in) :: at

      a = -at%side*(system%load*sin(at%phase) - 2*system%osc%xi*at%x_dot - at%x)
   end function closing_acceleration

   !> The next impact on the wall just left; a time of 0 if there is none.
   pure subroutine next_hop(system, here, last, time, x, x_dot, speed)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> State just after an impact.
      type(place_type), intent(in) :: here
      !> Load phase (rad) at which the search ends.
      real(wp), intent(in) :: last
      !> Time of the next impact (1/omega after this one), position and velocity of the primary mass
      !! there, approach speed.
      real(wp), intent(out) :: time, x, x_dot, speed
      type(contact_type) :: contact
      real(wp) :: limit
      logical :: found

      associate (at => here%at)
         time = 0
         if (.not. here%released) call bounce(system%transition, system%load, sin(at%phase), &
            cos(at%phase), at%x, at%x_dot, at%side, here%speed, 4*system%clearance, time, speed)
         if (time > 0) then
            x = at%x + at%z_dot*time
            x_dot = at%z_dot - at%side*speed
            return
         end if
         x = at%x
         x_dot = at%x_dot
         limit = (last - at%phase)/system%r
         call next_contact(system, flight_from(system, at, limit), here, at%side, limit, &
            contact, found)
         if (.not. found) return
         time = contact%time
         x = contact%d(0)
         x_dot = contact%d(1)
         speed = contact%speed
      end associate
   end subroutine next_hop

   !> The rest, from the last impact that is computed to the release.
   !!
   !! The measure of its duration passes zero almost linearly where the accumulation just fails to
   !! complete (see `critical`).
   pure subroutine rest_on(system, restitution, last, course, end_of)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Coefficient of restitution of the wall, and load phase (rad) at which the search ends.
      real(wp), intent(in) :: restitution, last
      !> In: after the last impact. Out: after the release; the least gap is lowered where the rest
      !! splits, or nearly does. `good` is false if the rest does not end before `last`, or its end
      !! has no derivative.
      type(course_type), intent(inout) :: course
      !> What is known of the release.
      type(ending_type), intent(in), optional :: end_of
      type(oscillation_type) :: joint
      type(moment_type) :: from
      type(variation_type) :: start
      real(wp), dimension(columns) :: closing_by, speed_by, instant
      real(wp) :: closing, speed, time, duration, d(0:5), limit, power, share

      associate (here => course%here, rest => course%rest, good => course%good, &
         at => course%here%at, change => course%here%change, side => course%here%at%side, &
         mu => system%osc%mu)
         closing = closing_acceleration(system, at)
         closing_by = -side*(system%load*cos(at%phase)*change%state(4, :) &
            - 2*system%osc%xi*change%state(2, :) - change%state(1, :))
         speed = here%speed
         speed_by = side*(change%state(2, :) - change%state(3, :))
         call through_stick(system, at, change)
         at%x_dot = at%x_dot - side*mu/(1 + mu)*speed
         at%z_dot = at%x_dot
         joint = new_rest(system%osc%xi, mu, system%r, system%load, at%phase, at%x, at%x_dot)
         call find_release(system, joint, here, restitution, last, time, good, course%miss, &
            course%later, end_of)
         if (.not. good) return
         from = at
         start = change
         call through_rest(system, at, time, change)
         d = derivatives(joint, time)
         at%x = d(0)
         at%x_dot = d(1)
         at%z_dot = d(1)
         at%phase = at%phase + system%r*time
         call release(system, at, change, instant, good)
         if (.not. good) return
         here%speed = 0
         here%released = .true.
         ! the force passes zero so much later than at the given phase
         duration = time - d(2)/d(3)
         here%lag = system%r*(duration - time)
         if (present(end_of)) call note_force(system, joint, from, start, time, here, instant, &
            course%gap, course%touched, course%touched_at)
         call critical(restitution, limit, power)
         rest%value = 0
         if (.not. restitution > 0) then
            rest = measure_type(duration, instant)
            return
         end if
         if (.not. duration > 0) return
         share = 0
         if (speed > 0) share = speed/(closing*duration)/limit
         rest%value = (1 - share)*duration**power
         rest%by = (power*(1 - share) + share)*duration**(power - 1)*instant
         if (speed > 0) rest%by = rest%by - share*duration**power*(speed_by/speed &
            - closing_by/closing)
      end associate
   end subroutine rest_on

   !> The duration of a rest.
   !!
   !! Beyond the end of the family the contact force may pass zero several times. The release is
   !! then the passage that belongs to the unknowns. A given phase at which the force is nearly zero
   !! is taken as it is, so that the equations remain smooth where several passages merge.
   pure subroutine find_release(system, joint, here, restitution, last, time, good, miss, later, &
      end_of)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The common motion of both masses, and the state with which it begins.
      type(oscillation_type), intent(in) :: joint
      type(place_type), intent(in) :: here
      !> Coefficient of restitution of the wall, and load phase (rad) at which the search ends.
      real(wp), intent(in) :: restitution, last
      !> Time from the start of the rest (1/omega); negative for a release without restitution that
      !! precedes the impact.
      real(wp), intent(out) :: time
      !> Whether there is a release.
      logical, intent(out) :: good
      !> How far it is from what is known, see `miss_at`.
      real(wp), intent(out) :: miss
      !> Whether the force passes zero again later, before the known release.
      logical, intent(out) :: later
      !> What is known of the release.
      type(ending_type), intent(in), optional :: end_of
      !> Time (over the shortest time scale) within which passages are about to merge.
      real(wp), parameter :: near = 0.1_wp
      real(wp) :: d(0:5), limit, before, other, least, span
      integer :: i
      logical :: found

      miss = 0
      later = .false.
      associate (at => here%at, side => here%at%side)
         good = .false.
         if (present(end_of)) good = end_of%side == 0
         if (good) then
            time = (end_of%phase - at%phase)/system%r
            span = near/max(1.0_wp, system%r)
            d = derivatives(joint, time)
            good = time > 0 .and. abs(d(3)) < 0.5_wp*span**2*abs(d(5)) .and. &
               6*abs(d(2)) < span**3*abs(d(5))
            if (good) return
         end if
         limit = (last - at%phase)/system%r
         call next_release(system, joint, at, 0.0_wp, limit, time, good)
         d = derivatives(joint, 0.0_wp)
         if (.not. restitution > 0 .and. side*d(2) >= 0) then
            ! without restitution the force at the impact has to be positive; beyond that limit the
            ! common motion is continued backward
            if (.not. present(end_of)) good = .false.
            if (good .and. side*d(3) > 0) call earlier_release(joint, side, time, good)
         end if
         if (.not. (good .and. present(end_of))) return
         other = time
         miss = miss_at(time)
         do i = 1, 4
            least = miss
            if (end_of%side == 0) then
               ! a nearer one is not farther beyond the given phase
               limit = (end_of%phase - at%phase)/system%r
               limit = min(limit + (limit - time), (last - at%phase)/system%r)
               if (least < 1.0e-4_wp) exit
            else
               limit = (end_of%phase - at%phase)/system%r
               if (least < 1.0e-4_wp*system%clearance) exit
            end if
            before = other
            if (.not. limit > before) exit
            call next_release(system, joint, at, before, limit, other, found)
            if (.not. found) exit
            later = .true.
            miss = min(least, miss_at(other))
            if (miss < least) time = other
         end do
      end associate
   contains
      !> How far a release is from the given phase, or the free mass from the wall at the next
      !! impact.
      pure real(wp) function miss_at(duration) result(miss)
         !> Duration of the rest.
         real(wp), intent(in) :: duration
         type(moment_type) :: at
         type(flight_type) :: flight
         real(wp) :: state(0:5), span

         miss = abs(end_of%phase - here%at%phase - system%r*duration)
         if (end_of%side == 0) return
         miss = huge(1.0_wp)
         state = derivatives(joint, duration)
         at = moment_type(state(0), state(1), state(1), here%at%phase + system%r*duration, &
            here%at%side)
         span = (end_of%phase - at%phase)/system%r
         if (.not. span > 0) return
         flight = flight_from(system, at, span)
         state = derivatives(flight, span)
         miss = abs(flight_position(flight, span) - state(0) - 0.5_wp*end_of%side*system%clearance)
      end function miss_at
   end subroutine find_release

   !> The instant before an impact at which the contact force would have fallen through zero, had
   !! both masses moved together.
   pure subroutine earlier_release(joint, side, time, good)
      !> The common motion, in which the force is negative and falls at time 0.
      type(oscillation_type), intent(in) :: joint
      !> The wall, +1 or -1.
      integer, intent(in) :: side
      !> The instant, not after 0.
      real(wp), intent(out) :: time
      !> Whether there is one, and the force falls from there on.
      logical, intent(out) :: good
      real(wp) :: d(0:5), step
      integer :: i

      time = 0
      good = .false.
      do i = 1, 30
         d = derivatives(joint, time)
         if (.not. side*d(3) > 0) return
         step = d(2)/d(3)
         time = time - step
         ! the next step would be of the order of the square of this one
         good = abs(step) < 1.0e-10_wp .and. time <= 0
         if (good) return
      end do
   end subroutine earlier_release

   !> The next instant at which the contact force falls through zero in the common motion.
   pure subroutine next_release(system, joint, from, after, limit, time, good)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The common motion, and the state at its time 0.
      type(oscillation_type), intent(in) :: joint
      type(moment_type), intent(in) :: from
      !> Time of the previous such instant (negative before the impact), 0 for the first one, and
      !! end of the search.
      real(wp), intent(in) :: after, limit
      !> The instant.
      real(wp), intent(out) :: time
      !> Whether there is one.
      logical, intent(out) :: good
      type(oscillation_type) :: moved
      real(wp) :: begin, rise, d(0:5)
      logical :: opens

      begin = max(after, 0.0_wp)
      d = derivatives(joint, begin)
      opens = from%side*d(2) > 0 .and. from%side*d(3) < 0
      if (abs(after) > 0 .or. opens) then
         ! the force has to become positive first
         moved = joint
         if (begin > 0) moved = shifted(begin)
         call release_time(moved, -from%side, limit - begin, rise, good)
         good = good .and. begin + rise <= limit
         if (.not. good) return
         begin = begin + rise
      end if
      moved = joint
      if (begin > 0) moved = shifted(begin)
      call release_time(moved, from%side, limit - begin, time, good)
      time = begin + time
      good = good .and. time <= limit
   contains
      !> The common motion, from a later time.
      pure type(oscillation_type) function shifted(begin)
         !> That time.
         real(wp), intent(in) :: begin
         real(wp) :: d(0:5)

         d = derivatives(joint, begin)
         shifted = new_rest(system%osc%xi, system%osc%mu, system%r, system%load, from%phase &
            + system%r*begin, d(0), d(1))
      end function shifted
   end subroutine next_release

   !> Lowers the least gap of a symbol to the least ratio of the contact force to the time left
   !! before the release, at a minimum of that ratio or at the start of the rest.
   pure subroutine note_force(system, joint, from, start, time, here, instant, gap, touched, &
      touched_at)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The common motion, its state at the start and the changes there, and its duration.
      type(oscillation_type), intent(in) :: joint
      type(moment_type), intent(in) :: from
      type(variation_type), intent(in) :: start
      real(wp), intent(in) :: time
      !> The place of the release, and changes of its instant.
      type(place_type), intent(in) :: here
      real(wp), intent(in) :: instant(columns)
      !> In: least gap so far. Out: lowered if this is less.
      type(measure_type), intent(inout) :: gap
      !> Wall and place of that gap, see `rest_period_type`.
      integer, intent(inout) :: touched
      real(wp), intent(inout) :: touched_at
      type(variation_type) :: change
      real(wp) :: at_release(0:5), left, before, step, slope, slope_before, ratio, least
      real(wp) :: low, high, best, phase
      integer :: i, n, pass

      at_release = derivatives(joint, time)
      n = 0
      step = 0
      if (time > 0) then
         n = ceiling(4*max(1.0_wp, system%r)*time)
         step = time/n
      end if
      least = side_by(at_release(3))
      best = 0
      before = 0
      slope_before = -0.5_wp*side_by(at_release(4))
      do i = 1, n
         left = i*step
         if (i == n) left = time
         call at_left(left, ratio, slope)
         if (i == n .and. ratio < least) then
            least = ratio
            best = time
         end if
         if (slope_before < 0 .and. slope > 0) then
            low = before
            high = left
            do pass = 1, 60
               left = 0.5_wp*(low + high)
               call at_left(left, ratio, slope_before)
               if (slope_before < 0) low = left
               if (.not. slope_before < 0) high = left
               if (high - low < 1.0e-9_wp*step) exit
            end do
            if (ratio < least) then
               least = ratio
               best = left
            end if
            left = i*step
         end if
         before = left
         slope_before = slope
      end do
      if (least >= gap%value) return
      gap%value = least
      touched = from%side
      touched_at = 0
      associate (state => here%change%state)
         if (.not. best > 0) then
            gap%by = from%side*(system%load*cos(here%at%phase)*here%change%r - system%load &
               *system%r*sin(here%at%phase)*state(4, :) - state(2, :))
            return
         end if
      end associate
      touched_at = -best/time
      change = start
      call through_rest(system, from, time - best, change)
      phase = from%phase + system%r*(time - best)
      gap%by = (-from%side*(system%load*cos(phase)*change%state(4, :) - 2*system%osc%xi &
         *change%state(2, :) - change%state(1, :)) - least*instant)/best
   contains
      !> A derivative of the acceleration of the primary mass, as one of the force on the wall's
      !! side that opens the gap.
      pure real(wp) function side_by(derivative)
         !> The derivative.
         real(wp), intent(in) :: derivative

         side_by = from%side*(1 + system%osc%mu)*derivative
      end function side_by

      !> The ratio of the force to the time left, and its slope.
      pure subroutine at_left(left, ratio, slope)
         !> Time left before the release.
         real(wp), intent(in) :: left
         !> The ratio and its derivative with respect to that time.
         real(wp), intent(out) :: ratio, slope
         real(wp) :: d(0:5)

         if (left < 1.0e-4_wp) then
            ratio = side_by(at_release(3) + left*(-at_release(4)/2 + left*at_release(5)/6))
            slope = side_by(-at_release(4)/2 + left*at_release(5)/3)
            return
         end if
         d = derivatives(joint, time - left)
         ratio = -side_by(d(2) - at_release(2))/left
         slope = (side_by(d(3)) - ratio)/left
      end subroutine at_left
   end subroutine note_force

   !> The acceleration with which the masses separate after an impact without restitution.
   pure type(measure_type) function departure_of(system, here) result(departure)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The place just after the impact.
      type(place_type), intent(in) :: here

      associate (at => here%at, state => here%change%state)
         departure%value = -closing_acceleration(system, at)
         departure%by = at%side*(system%load*cos(at%phase)*state(4, :) - 2*system%osc%xi &
            *state(2, :) - state(1, :))
      end associate
   end function departure_of

   !> The limit between accumulations that are and are not completed before the gap's acceleration a
   !! changes sign.
   !!
   !! With a = j s, where s is the time until a changes sign, the next impact follows after
   !! t = 3/2 s (1 - sqrt(1 - 8/3 w)), w = u/(j s**2) = u/(a s). The step from w to the next one has
   !! a fixed point, tau = t/s with (3 - tau) (1 - tau)**2 = R (3 - 2 tau). Below it the
   !! accumulation is completed in time; above it, it is not. A distance from the fixed point grows
   !! by the factor L from impact to impact while s shrinks by the factor 1 - tau, so that
   !! (1 - w/w_c) s**power with (1 - tau)**power = 1/L has the same value at each impact.
   pure subroutine critical(restitution, limit, power)
      !> Coefficient of restitution of the wall.
      real(wp), intent(in) :: restitution
      !> w_c and the power.
      real(wp), intent(out) :: limit, power
      real(wp) :: low, high, tau, growth
      integer :: i

      low = 0
      high = 1
      do i = 1, 60
         tau = 0.5_wp*(low + high)
         if ((3 - tau)*(1 - tau)**2 > restitution*(3 - 2*tau)) then
            low = tau
         else
            high = tau
         end if
      end do
      limit = tau*(0.5_wp - tau/6)
      power = 1
      if (.not. (tau > 0 .and. tau < 1 - 1.0e-6_wp)) return
      growth = (3 - tau)**2/((1 - tau)*(3 - 2*tau)**2)
      power = log(growth)/(-log(1 - tau))
   end subroutine critical

   !> The flight that begins after an event.
   pure function flight_from(system, at, duration) result(flight)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> State after the event.
      type(moment_type), intent(in) :: at
      !> Time until the end of the flight (1/omega).
      real(wp), intent(in) :: duration
      type(flight_type) :: flight

      flight = new_flight(system%osc%xi, system%r, system%amplitude, at%phase - system%lag, at%x, &
         at%x_dot, at%x + 0.5_wp*at%side*system%clearance, at%z_dot, duration)
   end function flight_from

   !> Updates the least gap with those at the stationary points inside a flight.
   pure subroutine note_gap(system, here, duration, flight_number, gap, touched, touched_at)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> State at the start of the flight.
      type(place_type), intent(in) :: here
      !> Duration of the flight (1/omega).
      real(wp), intent(in) :: duration
      !> Number of the flight, as in `rest_period_type`.
      integer, intent(in) :: flight_number
      !> In: least gap so far (over D). Out: lowered if this flight has a smaller one.
      type(measure_type), intent(inout) :: gap
      !> Wall of that gap: +1 right, -1 left.
      integer, intent(inout) :: touched
      !> Flight of that gap, and share of its duration.
      real(wp), intent(inout) :: touched_at
      type(flight_type) :: flight
      real(wp) :: extreme(2), at(2), x, x_dot, x_ddot, least, begin, y, d(0:5)
      logical :: complete
      integer :: i, side

      flight = flight_from(system, here%at, duration)
      begin = 0
      if (here%released) then
         ! a release is itself a stationary point
         begin = min(0.9_wp*soon/max(1.0_wp, system%r), 0.5_wp*duration)
         call note_opening(system, here, duration, gap, touched, touched_at)
      else if (.not. here%speed > 0) then
         ! so is an impact without restitution
         begin = min(1.0e-3_wp, 0.5_wp*duration)
      end if
      if (begin > 0) then
         call flight_state(flight, begin, x, x_dot, x_ddot)
         flight = new_flight(system%osc%xi, system%r, system%amplitude, flight%phase &
            + system%r*begin, x, x_dot, flight_position(flight, begin), flight%z_dot, &
            duration - begin)
      end if
      call relative_extrema(flight, extreme(2), extreme(1), complete, at(2), at(1))
      do i = 1, 2
         if (at(i) < 0) cycle
         side = 3 - 2*i
         least = 0.5_wp - side*extreme(i)/system%clearance
         if (least >= gap%value) cycle
         ! only where the free mass turns back from the wall
         d = derivatives(flight, at(i))
         if (.not. side*d(2) > 0) cycle
         y = side*extreme(i)/system%clearance
         gap = measure_type(least, -(side*gap_change(system, here%at, begin + at(i), here%change) &
            - y*here%change%clearance)/system%clearance)
         touched = side
         touched_at = flight_number + (begin + at(i))/duration
      end do
   end subroutine note_gap

   !> Lowers the least gap of a symbol to that of the flight soon after its release, as 6 g/t**3.
   pure subroutine note_opening(system, here, duration, gap, touched, touched_at)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The release.
      type(place_type), intent(in) :: here
      !> Duration of the flight after it (1/omega).
      real(wp), intent(in) :: duration
      !> In: least gap so far. Out: lowered if this is less.
      type(measure_type), intent(inout) :: gap
      !> Wall and place of that gap, see `rest_period_type`.
      integer, intent(inout) :: touched
      real(wp), intent(inout) :: touched_at
      real(wp) :: k(0:8), t, low, high, value, by(columns)
      integer :: i

      associate (at => here%at, state => here%change%state)
         k = 6*series(system%transition, system%load, sin(at%phase), cos(at%phase), at%x, &
            at%x_dot, at%side, 0.0_wp)
         high = min(soon/max(1.0_wp, system%r), duration)
         ! the ratio is k(2) + k(3) t + ...
         if (.not. (k(3) < 0 .and. slope(high) > 0)) return
         low = 0
         do i = 1, 60
            t = 0.5_wp*(low + high)
            if (slope(t) < 0) low = t
            if (.not. slope(t) < 0) high = t
            if (high - low < 1.0e-12_wp) exit
         end do
         value = 0
         do i = 8, 2, -1
            value = value*t + k(i)
         end do
         if (value >= gap%value) return
         by = at%side*(system%load*cos(at%phase)*here%change%r - system%load*system%r &
            *sin(at%phase)*state(4, :) - state(2, :))
         ! rounding spoils the ratio at short times, where it is that of the third derivatives
         if (t > 3.0e-4_wp) by = 6*(0.5_wp*here%change%clearance - at%side*gap_change(system, at, &
            t, here%change))/t**3
         gap = measure_type(value, by)
         touched = at%side
         touched_at = t/duration
      end associate
   contains
      !> The rate of change of the ratio.
      pure real(wp) function slope(t)
         !> Time after the release.
         real(wp), intent(in) :: t
         integer :: j

         slope = 0
         do j = 8, 3, -1
            slope = slope*t + (j - 2)*k(j)
         end do
      end function slope
   end subroutine note_opening

   !> The last release from a wall in a list of events, as unknowns.
   pure subroutine last_release(side, events, clearance, unknowns, found)
      !> The wall: +1 right, -1 left.
      integer, intent(in) :: side
      !> (n) In the order of time.
      type(event_type), intent(in) :: events(:)
      !> Clearance D = d K/F0.
      real(wp), intent(in) :: clearance
      !> Phase and asinh(v/D).
      real(wp), intent(out) :: unknowns(2)
      !> Whether there is one.
      logical, intent(out) :: found
      integer :: i

      unknowns = 0
      found = .false.
      do i = size(events), 1, -1
         found = events(i)%kind == release_event .and. events(i)%side == side
         if (.not. found) cycle
         unknowns = [events(i)%phase, asinh(events(i)%x_dot_after/clearance)]
         return
      end do
   end subroutine last_release

end module vi_rest_family
