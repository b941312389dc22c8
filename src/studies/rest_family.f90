!> Families of motions with rest: one period from a release on a wall to the next one.
!!
!! Where a rest ends both masses have one velocity v and the primary mass has no acceleration, so x
!! = f sin(phase) - 2 xi v: the state at a release is two numbers. A letter is an impact, or all
!! the impacts that accumulate on a wall and the rest there. The unknowns are the load phase and
!! asinh(v/D) at the release that ends the last letter (v/D grows without bound as D falls; its
!! logarithm changes at the pace of log D), and the load phases of the first impacts of all
!! letters. The equations say that the free mass is at the wall at each of these phases, and that
!! the period ends as it began.
!!
!! The equations stay smooth where the free mass touches a wall during a flight and where an
!! approach speed falls to zero, and an accumulation that just fails to be completed is completed
!! all the same: the ends of the family are zeros of smooth measures, the gap of a flight, an
!! approach speed, and the rest that an accumulation leaves. Derivatives by the unknowns, r and log
!! D are carried along (vi_variation).
module vi_rest_family
   use vi_contact, only: contact_type, departure_type, first_contact
   use vi_drive, only: drive_type, event_type, new_drive, release_event, two_pi
   use vi_extrema, only: relative_extrema
   use vi_flight, only: flight_position, flight_state, flight_type, new_flight
   use vi_hop, only: hop
   use vi_kinds, only: wp
   use vi_orbit, only: by_clearance, by_left, by_mu, by_r, by_right, by_xi
   use vi_oscillation, only: derivatives, oscillation_type
   use vi_oscillator, only: left, oscillator_type, right
   use vi_rest, only: new_rest, release_time
   use vi_variation, only: columns, gap_change, moment_type, release, through_contact, &
      through_flight, through_rest, through_stick, variation_type
   implicit none (type, external)
   private

   public :: follow_letters, last_release, new_rest_family, plane_map, rest_period, &
      rest_stability, rest_unknowns

   !> Impacts of one accumulation that are followed.
   integer, parameter :: most_hops = 20000

   type, public :: rest_family_type
      !> +1, -1 for an impact, +2, -2 for accumulation and rest; the last letter is one of these.
      integer, allocatable :: letters(:)
      integer :: cycles = 1
      !> Letters by which the pattern that was asked for is turned to make this order.
      integer :: turned = 0
   end type rest_family_type

   !> A number and its derivatives by the unknowns, r and log D.
   type, public :: measure_type
      real(wp) :: value = 0, by(columns) = 0
   end type measure_type

   !> What happens in one period.
   type, public :: rest_period_type
      !> Of the equations: the unknowns at the next release, the phase less 2 pi k, less those at
      !! the start; then how far beyond its wall, over D, the free mass is at the first impact of
      !! each letter.
      type(measure_type), allocatable :: equations(:)
      !> Of each letter: approach speed of its first impact over D; the rest that is left (1 for an
      !! impact); least gap over D at a stationary point of its flights, to either wall.
      type(measure_type), allocatable :: approach(:), rest(:), gap(:)
      !> Where that gap is: the wall, and the flight (0 after the last event of the letter, 1, 2 ..
      !! after its impacts) plus the share of its duration.
      integer, allocatable :: touched(:)
      real(wp), allocatable :: touched_at(:)
      !> Whether all accumulations come to an end.
      logical :: right = .false.
   end type rest_period_type

   !> A place on the way through a period: the state after an event, its changes, and the flight
   !! that begins there.
   type :: place_type
      type(moment_type) :: at
      type(variation_type) :: change
      !> Speed at which the masses part.
      real(wp) :: speed = 0
      !> Whether a rest has just ended.
      logical :: released = .false.
   end type place_type

contains

   !> The family of a pattern: its letters turned so that a rest is last.
   pure function new_rest_family(letters, cycles) result(family)
      !> +1, -1, +2, -2
      integer, intent(in) :: letters(:)
      !> Load cycles k of the period.
      integer, intent(in) :: cycles
      type(rest_family_type) :: family

      family%turned = findloc(abs(letters) == 2, .true., dim=1, back=.true.)
      allocate (family%letters(size(letters)), source=cshift(letters, family%turned))
      family%cycles = cycles
   end function new_rest_family

   !> Unknowns of a family: the release, and the first impact of each letter.
   pure integer function rest_unknowns(family)
      type(rest_family_type), intent(in) :: family

      rest_unknowns = 2 + size(family%letters)
   end function rest_unknowns

   !> One period from a release.
   pure subroutine rest_period(family, unknowns, c, period)
      type(rest_family_type), intent(in) :: family
      !> (2 + n) phase and asinh(v/D) at the release, phases of the first impacts.
      real(wp), intent(in) :: unknowns(:)
      !> (6) r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      type(rest_period_type), intent(out) :: period
      type(drive_type) :: drive
      type(place_type) :: here
      real(wp) :: last
      logical :: good
      integer :: i, n, m, before

      n = size(family%letters)
      m = rest_unknowns(family)
      drive = drive_of(c)
      allocate (period%equations(m), period%approach(n), period%rest(n), period%gap(n), &
         period%touched(n), period%touched_at(n))
      period%rest%value = 1
      period%gap%value = 0.5_wp
      period%touched = 0
      period%touched_at = 0
      here = start_of(drive, sign(1, family%letters(n)), unknowns, m)
      last = unknowns(1) + 2*two_pi*family%cycles
      do i = 1, n
         before = modulo(i - 2, n) + 1
         if (.not. unknowns(2 + i) > here%at%phase) return
         call fly(drive, sign(1, family%letters(i)), 2 + i, unknowns(2 + i), here, &
            period%equations(2 + i), period%approach(i), period%gap(before), &
            period%touched(before), period%touched_at(before))
         if (abs(family%letters(i)) == 1) cycle
         call accumulate(drive, last, here, period%rest(i), period%gap(i), period%touched(i), &
            period%touched_at(i), good)
         if (.not. good) return
      end do
      period%equations(1) = measure_type(here%at%phase - two_pi*family%cycles - unknowns(1), &
         here%change%state(4, :))
      associate (d => drive%clearance, v => here%at%x_dot)
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
      type(rest_period_type), intent(in) :: period
      real(wp) :: j(2, 2)
      real(wp) :: by(2, size(period%equations)), last(2, size(period%equations))
      integer :: i, k, m

      m = size(period%equations)
      ! each phase by the release, from the equation that fixes it and the phases before
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
      type(rest_period_type), intent(in) :: period
      real(wp) :: values(3)
      real(wp), dimension(size(period%equations), size(period%equations)) :: a, b
      real(wp) :: phases, plain
      integer :: i, m

      m = size(period%equations)
      do i = 1, m
         a(i, :) = period%equations(i)%by(:m)
      end do
      ! the determinant of the equations of the phases alone: approach speeds, each by r
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

   !> By elimination with partial pivoting.
   pure real(wp) function determinant(matrix)
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

   pure function drive_of(c) result(drive)
      !> (6) r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      type(drive_type) :: drive

      drive = new_drive(oscillator_type(c(by_xi), c(by_mu), c([by_right, by_left])), c(by_r), &
         1.0_wp, exp(c(by_clearance)))
   end function drive_of

   !> The release with which a period starts.
   pure function start_of(drive, side, unknowns, m) result(start)
      type(drive_type), intent(in) :: drive
      !> The wall, +1 or -1.
      integer, intent(in) :: side
      !> Phase and asinh(v/D).
      real(wp), intent(in) :: unknowns(:)
      !> Unknowns in all.
      integer, intent(in) :: m
      type(place_type) :: start

      associate (d => drive%clearance, f => drive%load, at => start%at, change => start%change)
         at%phase = unknowns(1)
         at%x_dot = sinh(unknowns(2))*d
         at%z_dot = at%x_dot
         at%x = f*sin(at%phase) - 2*drive%osc%xi*at%x_dot
         at%side = side
         change%n = m + 2
         change%r(m + 1) = 1
         change%clearance(m + 2) = d
         change%state(4, 1) = 1
         change%state(2, [2, m + 2]) = [hypot(at%x_dot, d), at%x_dot]
         change%state(3, :) = change%state(2, :)
         change%state(1, :) = f*cos(at%phase)*change%state(4, :) &
            - 2*drive%osc%xi*change%state(2, :)
      end associate
      start%released = .true.
   end function start_of

   !> Flies to an impact at a given load phase, and through it.
   pure subroutine fly(drive, side, column, phase, here, equation, approach, gap, touched, &
      touched_at)
      type(drive_type), intent(in) :: drive
      integer, intent(in) :: side
      !> Which unknown the phase is.
      integer, intent(in) :: column
      real(wp), intent(in) :: phase
      type(place_type), intent(inout) :: here
      !> How far beyond the wall the free mass is, and the approach speed, over D.
      type(measure_type), intent(out) :: equation, approach
      !> Least gap so far of the letter that the flight belongs to.
      type(measure_type), intent(inout) :: gap
      integer, intent(inout) :: touched
      real(wp), intent(inout) :: touched_at
      type(flight_type) :: flight
      real(wp), dimension(columns) :: longer, y, before
      real(wp) :: time, d(0:5), speed, restitution
      integer :: n

      time = (phase - here%at%phase)/drive%r
      flight = flight_from(drive, here%at, time)
      d = derivatives(flight, time)
      call note_gap(drive, here, time, 0, gap, touched, touched_at)
      n = here%change%n
      longer = 0
      longer(:n) = -(here%change%state(4, :n) + time*here%change%r(:n))/drive%r
      longer(column) = longer(column) + 1/drive%r
      restitution = drive%osc%restitution(merge(right, left, side > 0))
      call through_flight(drive, here%at, time, longer, restitution, here%change, y, before)
      associate (at => here%at, clearance => drive%clearance, mu => drive%osc%mu)
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

   !> The unknowns that go with a release: the first impacts of the letters follow from it.
   pure subroutine follow_letters(family, release, c, unknowns, good)
      type(rest_family_type), intent(in) :: family
      !> Phase and asinh(v/D).
      real(wp), intent(in) :: release(2)
      !> (6) r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> (2 + n)
      real(wp), intent(out) :: unknowns(:)
      logical, intent(out) :: good
      type(drive_type) :: drive
      type(place_type) :: here
      type(contact_type) :: contact
      type(measure_type) :: rest, gap
      real(wp) :: limit, touched_at
      integer :: i, touched

      drive = drive_of(c)
      unknowns = 0
      unknowns(:2) = release
      here = start_of(drive, sign(1, family%letters(size(family%letters))), release, 2)
      touched = 0
      touched_at = 0
      do i = 1, size(family%letters)
         associate (side => sign(1, family%letters(i)))
            limit = (release(1) + 2*two_pi*family%cycles - here%at%phase)/drive%r
            call next_contact(drive, flight_from(drive, here%at, limit), here, side, limit, &
               contact, good)
            if (good) call impact_at(drive, here, side, contact%time, contact%d(0), contact%d(1), &
               contact%speed, good)
            if (.not. good) return
         end associate
         unknowns(2 + i) = here%at%phase
         if (abs(family%letters(i)) == 1) cycle
         call accumulate(drive, release(1) + 2*two_pi*family%cycles, here, rest, gap, touched, &
            touched_at, good)
         if (.not. good) return
      end do
   end subroutine follow_letters

   !> The next contact with one wall.
   pure subroutine next_contact(drive, flight, here, side, limit, contact, found)
      type(drive_type), intent(in) :: drive
      type(flight_type), intent(in) :: flight
      type(place_type), intent(in) :: here
      integer, intent(in) :: side
      !> No contact is looked for after this time.
      real(wp), intent(in) :: limit
      type(contact_type), intent(out) :: contact
      logical, intent(out) :: found
      type(flight_type) :: moved
      type(departure_type) :: departure
      real(wp) :: beyond

      ! the other wall is put so far away that a motion that reaches it is none
      beyond = 2*drive%clearance
      moved = flight
      moved%z = moved%z + side*beyond
      if (here%at%side == side) departure = departure_type(side, here%speed, here%released)
      contact = first_contact(moved, 0.5_wp*drive%clearance + beyond, departure, limit)
      found = contact%side == side
   end subroutine next_contact

   !> Through an impact a given time after the beginning of a flight.
   pure subroutine impact_at(drive, here, side, time, x, x_dot, speed, good)
      type(drive_type), intent(in) :: drive
      type(place_type), intent(inout) :: here
      integer, intent(in) :: side
      real(wp), intent(in) :: time
      !> The primary mass at the impact, and the speed at which the masses approach each other.
      real(wp), intent(in) :: x, x_dot, speed
      logical, intent(out) :: good
      real(wp) :: before(columns), restitution

      associate (at => here%at, mu => drive%osc%mu)
         restitution = drive%osc%restitution(merge(right, left, side > 0))
         call through_contact(drive, at, time, side, restitution, here%change, before, good)
         ! velocities from the approach speed, which keeps its relative accuracy
         here%speed = restitution*speed
         at%x = x
         at%x_dot = x_dot + mu/(1 + mu)*(side*(speed + here%speed))
         at%z_dot = at%x_dot - side*here%speed
         at%phase = at%phase + drive%r*time
         at%side = side
      end associate
      here%released = .false.
   end subroutine impact_at

   !> All impacts that accumulate on a wall, and the rest there, from the first impact on.
   !!
   !! The accumulation is cut off where this changes the state by less than rounding, or, if it is
   !! not completed, where it comes nearest to that.
   pure subroutine accumulate(drive, last, here, rest, gap, touched, touched_at, good)
      type(drive_type), intent(in) :: drive
      !> Load phase after which nothing is looked for.
      real(wp), intent(in) :: last
      type(place_type), intent(inout) :: here
      !> The rest that is left.
      type(measure_type), intent(out) :: rest
      type(measure_type), intent(inout) :: gap
      integer, intent(inout) :: touched
      real(wp), intent(inout) :: touched_at
      logical, intent(out) :: good
      !> What cutting off may cost, relative to the motion: of a motion, and beyond its end.
      real(wp), parameter :: fine = 1.0e-17_wp, coarse = 1.0e-6_wp
      type(place_type) :: best
      real(wp) :: restitution, cost, least, time, x, x_dot, speed, scale, closing
      integer :: hops

      restitution = drive%osc%restitution(merge(right, left, here%at%side > 0))
      least = huge(1.0_wp)
      good = here%speed >= 0
      if (.not. good) return
      do hops = 1, most_hops
         closing = closing_acceleration(drive, here%at)
         cost = huge(1.0_wp)
         if (closing > 1.0e-15_wp*(1 + here%speed**2)) cost = here%speed**3/closing**2 &
            /max(1.0e-3_wp, 1 - restitution**3)
         scale = drive%clearance + abs(here%at%x) + abs(here%at%x_dot)
         if (cost < least) then
            least = cost
            best = here
         end if
         if (cost <= fine*scale) exit
         ! it has come near to its end, and goes away from it again
         if (least <= coarse*scale .and. 1.0e-3_wp*cost > least) exit
         call next_hop(drive, here, last, time, x, x_dot, speed)
         if (.not. time > 0) exit
         if (here%speed*time > 0.2_wp*drive%clearance) call note_gap(drive, here, time, hops, gap, &
            touched, touched_at)
         call impact_at(drive, here, here%at%side, time, x, x_dot, speed, good)
         if (.not. good) exit
      end do
      good = least <= coarse*(drive%clearance + abs(best%at%x) + abs(best%at%x_dot))
      if (.not. good) return
      here = best
      call rest_on(drive, restitution, last, here, rest, good)
   end subroutine accumulate

   !> The acceleration that closes the gap after an impact.
   pure real(wp) function closing_acceleration(drive, at) result(a)
      type(drive_type), intent(in) :: drive
      type(moment_type), intent(in) :: at

      a = -at%side*(drive%load*sin(at%phase) - 2*drive%osc%xi*at%x_dot - at%x)
   end function closing_acceleration

   !> The next impact on the wall just left; a time of 0 if there is none.
   pure subroutine next_hop(drive, here, last, time, x, x_dot, speed)
      type(drive_type), intent(in) :: drive
      type(place_type), intent(in) :: here
      real(wp), intent(in) :: last
      real(wp), intent(out) :: time, x, x_dot, speed
      type(contact_type) :: contact
      real(wp) :: limit
      logical :: found

      associate (at => here%at)
         call hop(drive%transition, drive%load, sin(at%phase), cos(at%phase), at%x, at%x_dot, &
            at%side, here%speed, 4*drive%clearance, time, speed)
         if (time > 0) then
            x = at%x + at%z_dot*time
            x_dot = at%z_dot - at%side*speed
            return
         end if
         x = at%x
         x_dot = at%x_dot
         limit = (last - at%phase)/drive%r
         call next_contact(drive, flight_from(drive, at, limit), here, at%side, limit, &
            contact, found)
         if (.not. found) return
         time = contact%time
         x = contact%d(0)
         x_dot = contact%d(1)
         speed = contact%speed
      end associate
   end subroutine next_hop

   !> The rest from the last impact that is followed to the release.
   !!
   !! What is left of it is measured so that it goes through zero about linearly where the
   !! accumulation just fails to be completed (see `critical`).
   pure subroutine rest_on(drive, restitution, last, here, rest, good)
      type(drive_type), intent(in) :: drive
      real(wp), intent(in) :: restitution, last
      type(place_type), intent(inout) :: here
      type(measure_type), intent(out) :: rest
      logical, intent(out) :: good
      type(oscillation_type) :: joint
      real(wp), dimension(columns) :: closing_by, speed_by, instant
      real(wp) :: closing, speed, time, d(0:5), limit, power, share
      logical :: complete

      associate (at => here%at, change => here%change, side => here%at%side, mu => drive%osc%mu)
         closing = closing_acceleration(drive, at)
         closing_by = -side*(drive%load*cos(at%phase)*change%state(4, :) &
            - 2*drive%osc%xi*change%state(2, :) - change%state(1, :))
         speed = here%speed
         speed_by = side*(change%state(2, :) - change%state(3, :))
         at%x_dot = at%x_dot - side*mu/(1 + mu)*speed
         at%z_dot = at%x_dot
         call through_stick(drive, change)
         joint = new_rest(drive%osc%xi, mu, drive%r, drive%load, at%phase, at%x, at%x_dot)
         call release_time(joint, side, (last - at%phase)/drive%r, time, complete)
         good = complete .and. time <= (last - at%phase)/drive%r
         if (.not. good) return
         call through_rest(drive, at, time, change)
         d = derivatives(joint, time)
         at%x = d(0)
         at%x_dot = d(1)
         at%z_dot = d(1)
         at%phase = at%phase + drive%r*time
         call release(drive, at, change, instant, good)
         here%speed = 0
         here%released = .true.
         call critical(restitution, limit, power)
         rest%value = 0
         if (.not. time > 0) return
         share = 0
         if (speed > 0) share = speed/(closing*time)/limit
         rest%value = (1 - share)*time**power
         rest%by = (power*(1 - share) + share)*time**(power - 1)*instant
         if (speed > 0) rest%by = rest%by - share*time**power*(speed_by/speed - closing_by/closing)
      end associate
   end subroutine rest_on

   !> Where an accumulation just is, or is not, completed before the gap's acceleration a turns.
   !!
   !! With a = j s, s being the time until it turns, the next impact comes after t = 3/2 s (1 -
   !! sqrt(1 - 8/3 w)), w = u/(j s**2) = u/(a s). The step from w to the next one has a fixed
   !! point, tau = t/s with (3 - tau) (1 - tau)**2 = R (3 - 2 tau): below it impacts accumulate
   !! while there is time left, above it they do not. A distance from it grows by L from impact to
   !! impact while s shrinks by 1 - tau, so that (1 - w/w_c) s**power with (1 - tau)**power = 1/L
   !! is the same number at each of them.
   pure subroutine critical(restitution, limit, power)
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

   !> The flight that begins at a place.
   pure function flight_from(drive, at, duration) result(flight)
      type(drive_type), intent(in) :: drive
      type(moment_type), intent(in) :: at
      real(wp), intent(in) :: duration
      type(flight_type) :: flight

      flight = new_flight(drive%osc%xi, drive%r, drive%amplitude, at%phase - drive%lag, at%x, &
         at%x_dot, at%x + 0.5_wp*at%side*drive%clearance, at%z_dot, duration)
   end function flight_from

   !> Takes the least gap at a stationary point inside a flight, if it is less than the one so far.
   pure subroutine note_gap(drive, here, duration, flight_number, gap, touched, touched_at)
      type(drive_type), intent(in) :: drive
      type(place_type), intent(in) :: here
      real(wp), intent(in) :: duration
      integer, intent(in) :: flight_number
      type(measure_type), intent(inout) :: gap
      integer, intent(inout) :: touched
      real(wp), intent(inout) :: touched_at
      real(wp), parameter :: early = 1.0e-3_wp
      type(flight_type) :: flight
      real(wp) :: extreme(2), at(2), x, x_dot, x_ddot, least, begin, y, d(0:5)
      logical :: complete
      integer :: i, side

      flight = flight_from(drive, here%at, duration)
      begin = 0
      if (here%released .and. duration > 2*early) then
         ! a release is a stationary point itself, and not one that touches the wall anew
         begin = early
         call flight_state(flight, early, x, x_dot, x_ddot)
         flight = new_flight(drive%osc%xi, drive%r, drive%amplitude, flight%phase &
            + drive%r*early, x, x_dot, flight_position(flight, early), flight%z_dot, &
            duration - early)
      end if
      call relative_extrema(flight, extreme(2), extreme(1), complete, at(2), at(1))
      do i = 1, 2
         if (at(i) < 0) cycle
         side = 3 - 2*i
         least = 0.5_wp - side*extreme(i)/drive%clearance
         if (least >= gap%value) cycle
         ! only where the free mass turns back from the wall
         d = derivatives(flight, at(i))
         if (.not. side*d(2) > 0) cycle
         y = side*extreme(i)/drive%clearance
         gap = measure_type(least, -(side*gap_change(drive, here%at, begin + at(i), here%change) &
            - y*here%change%clearance)/drive%clearance)
         touched = side
         touched_at = flight_number + (begin + at(i))/duration
      end do
   end subroutine note_gap

   !> The last release from a wall among events, as unknowns; none gives found = .false.
   pure subroutine last_release(side, events, clearance, unknowns, found)
      !> The wall, +1 or -1.
      integer, intent(in) :: side
      type(event_type), intent(in) :: events(:)
      real(wp), intent(in) :: clearance
      !> Phase and asinh(v/D).
      real(wp), intent(out) :: unknowns(2)
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
