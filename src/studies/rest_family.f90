!> Families of motions with rest: one period from a release on a wall to the next one.
!!
!! The unknowns are the load phase and the velocity over D at the release that ends the last letter.
!! A letter is an impact, or all the impacts that accumulate on a wall and the rest there. The
!! family ends where a rest vanishes, since then the accumulation is not completed, and where a wall
!! is touched once more. On the far side of these conditions the map of the period is another one:
!! they count as zero a little before.
module vi_rest_family
   use vi_extrema, only: relative_extrema
   use vi_flight, only: flight_position, flight_state, flight_type, new_flight
   use vi_kinds, only: wp
   use vi_orbit, only: by_clearance, by_left, by_mu, by_r, by_right, by_xi
   use vi_oscillator, only: oscillator_type
   use vi_rest_motion, only: release_state, return_map
   use vi_simulate, only: drive_type, event_type, impact_event, new_drive, release_event, &
      state_type, stick_event
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: new_rest_family, rest_period, rest_derivative, last_release

   !> How far from zero the one-sided conditions count as zero: rest in time, gap and speed over D.
   real(wp), parameter, public :: least_rest = 2.0e-3_wp, least_gap = 1.0e-4_wp

   integer, parameter :: event_room = 1500
   real(wp), parameter :: two_pi = 2*acos(-1.0_wp)

   type, public :: rest_family_type
      !> +1, -1 for an impact, +2, -2 for accumulation and rest; the last letter is one of these.
      integer, allocatable :: letters(:)
      integer :: cycles = 1
      !> Letters by which the pattern that was asked for is turned to make this order.
      integer :: turned = 0
   end type rest_family_type

   !> What happens in one period.
   type, public :: rest_period_type
      !> Phase (less 2 pi k) and velocity over D at the next release.
      real(wp) :: finish(2) = 0
      !> Of each letter: approach speed of its first impact over D, duration of the rest (of an
      !> impact: 1), least gap over D in the flight after it.
      real(wp), allocatable :: approach(:), rest(:), gap(:)
      !> Whether the letters are those of the family.
      logical :: right = .false.
   end type rest_period_type

contains

   !> The family of a pattern: its letters turned so that a rest is last.
   pure function new_rest_family(letters, cycles) result(family)
      integer, intent(in) :: letters(:)
      integer, intent(in) :: cycles
      type(rest_family_type) :: family

      family%turned = findloc(abs(letters) == 2, .true., dim=1, back=.true.)
      allocate (family%letters(size(letters)), source=cshift(letters, family%turned))
      family%cycles = cycles
   end function new_rest_family

   !> One period from a release.
   pure subroutine rest_period(family, unknowns, c, period)
      type(rest_family_type), intent(in) :: family
      !> Phase and velocity over D.
      real(wp), intent(in) :: unknowns(:)
      !> r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      type(rest_period_type), intent(out) :: period
      type(drive_type) :: drive
      type(event_type), allocatable :: events(:)
      real(wp) :: finish(2)
      integer :: first(size(family%letters)), last(size(family%letters)), n, status

      drive = drive_of(c)
      allocate (events(event_room))
      call return_map(drive, sign(1, family%letters(size(family%letters))), family%cycles, &
         [unknowns(1), unknowns(2)*drive%clearance], finish, events, n, status)
      if (status /= stat%ok) return
      period%finish = [finish(1), finish(2)/drive%clearance]
      call read_letters(events(:n), family%letters, first, last, period%right)
      if (period%right) call examine(drive, family, unknowns, events(:n), first, last, period)
   end subroutine rest_period

   pure function drive_of(c) result(drive)
      real(wp), intent(in) :: c(:)
      type(drive_type) :: drive

      drive = new_drive(oscillator_type(c(by_xi), c(by_mu), c([by_right, by_left])), c(by_r), &
         1.0_wp, exp(c(by_clearance)))
   end function drive_of

   !> Groups events into letters and compares them with those wanted.
   pure subroutine read_letters(events, wanted, first, last, right)
      type(event_type), intent(in) :: events(:)
      integer, intent(in) :: wanted(:)
      !> Events that begin and end each letter.
      integer, intent(out) :: first(:), last(:)
      logical, intent(out) :: right
      integer :: i, j, letter

      right = .false.
      first = 0
      last = 0
      i = 1
      do letter = 1, size(wanted)
         if (i > size(events)) return
         first(letter) = i
         if (abs(wanted(letter)) == 2) then
            ! impacts on one wall, a stick, a release
            j = i
            do while (j < size(events))
               if (events(j)%side /= sign(1, wanted(letter))) return
               if (events(j)%kind == stick_event) exit
               if (events(j)%kind /= impact_event) return
               j = j + 1
            end do
            if (j + 1 > size(events)) return
            if (events(j + 1)%kind /= release_event) return
            last(letter) = j + 1
         else
            if (events(i)%kind /= impact_event .or. events(i)%side /= wanted(letter)) return
            last(letter) = i
         end if
         i = last(letter) + 1
      end do
      right = i == size(events) + 1
   end subroutine read_letters

   !> Speeds, rests and gaps of a period.
   pure subroutine examine(drive, family, unknowns, events, first, last, period)
      type(drive_type), intent(in) :: drive
      type(rest_family_type), intent(in) :: family
      real(wp), intent(in) :: unknowns(:)
      type(event_type), intent(in) :: events(:)
      integer, intent(in) :: first(:), last(:)
      type(rest_period_type), intent(inout) :: period
      type(state_type) :: start
      type(event_type) :: begin
      integer :: i, n

      n = size(family%letters)
      allocate (period%approach(n), period%rest(n), period%gap(n))
      period%rest = 1
      do i = 1, n
         associate (e => events(first(i)))
            period%approach(i) = e%side*(e%z_dot_before - e%x_dot_before)/drive%clearance
         end associate
         if (abs(family%letters(i)) == 2) period%rest(i) = lapse(events(last(i) - 1), &
            events(last(i)))/drive%r
         if (i < n) then
            period%gap(i) = flight_gap(drive, events(last(i)), events(last(i) + 1))
         else
            ! the flight after the release with which the period starts
            start = release_state(drive, sign(1, family%letters(n)), [unknowns(1), &
               unknowns(2)*drive%clearance])
            begin = events(last(n))
            begin%cycle = 0
            begin%phase = start%phase
            begin%x = start%x
            begin%x_dot_after = start%x_dot
            begin%z_dot_after = start%z_dot
            period%gap(n) = flight_gap(drive, begin, events(1))
         end if
      end do
   end subroutine examine

   !> Load phase between two events.
   pure real(wp) function lapse(a, b)
      type(event_type), intent(in) :: a, b

      lapse = two_pi*real(b%cycle - a%cycle, wp) + b%phase - a%phase
   end function lapse

   !> Least gap, over D, at a stationary point strictly inside the flight between two events.
   !!
   !! In a flight that returns to its wall the only stationary point may be the farthest from it:
   !! the gap to the other wall is what counts then.
   pure real(wp) function flight_gap(drive, a, b) result(gap)
      type(drive_type), intent(in) :: drive
      type(event_type), intent(in) :: a, b
      real(wp), parameter :: early = 1.0e-3_wp
      type(flight_type) :: flight
      real(wp) :: lowest, highest, x, x_dot, x_ddot
      logical :: complete

      flight = new_flight(drive%osc%xi, drive%r, drive%amplitude, a%phase - drive%lag, a%x, &
         a%x_dot_after, a%x + 0.5_wp*a%side*drive%clearance, a%z_dot_after, lapse(a, b)/drive%r)
      if (a%kind == release_event .and. flight%duration > 2*early) then
         ! a release is a stationary point itself, and not one that touches the wall anew
         call flight_state(flight, early, x, x_dot, x_ddot)
         flight = new_flight(drive%osc%xi, drive%r, drive%amplitude, flight%phase &
            + drive%r*early, x, x_dot, flight_position(flight, early), flight%z_dot, &
            flight%duration - early)
      end if
      call relative_extrema(flight, lowest, highest, complete)
      gap = 0.5_wp
      if (a%side < 0 .or. b%side < 0) gap = min(gap, 0.5_wp - highest/drive%clearance)
      if (a%side > 0 .or. b%side > 0) gap = min(gap, 0.5_wp + lowest/drive%clearance)
   end function flight_gap

   !> Trace and determinant of the derivative of the map, by central differences.
   !!
   !! Near an end of the family shorter differences are taken, which stay on its side.
   pure subroutine rest_derivative(family, unknowns, c, trace, determinant, right)
      type(rest_family_type), intent(in) :: family
      real(wp), intent(in) :: unknowns(:), c(:)
      real(wp), intent(out) :: trace, determinant
      logical, intent(out) :: right
      real(wp) :: j(2, 2), h
      integer :: i

      do i = 5, 7
         h = 0.1_wp**i
         call differences(family, unknowns, c, h, j, right)
         if (right) exit
      end do
      trace = j(1, 1) + j(2, 2)
      determinant = j(1, 1)*j(2, 2) - j(1, 2)*j(2, 1)
   end subroutine rest_derivative

   !> The derivative of the map by differences over a step h each way.
   pure subroutine differences(family, unknowns, c, h, j, right)
      type(rest_family_type), intent(in) :: family
      real(wp), intent(in) :: unknowns(:), c(:), h
      real(wp), intent(out) :: j(2, 2)
      logical, intent(out) :: right
      type(rest_period_type) :: period
      real(wp) :: moved(2)
      integer :: i, way

      j = 0
      do i = 1, 2
         do way = -1, 1, 2
            moved = unknowns
            moved(i) = moved(i) + way*h
            call rest_period(family, moved, c, period)
            right = period%right
            if (.not. right) return
            j(:, i) = j(:, i) + way*period%finish/(2*h)
         end do
      end do
   end subroutine differences

   !> The last release of the family among events, as unknowns; none gives found = .false.
   pure subroutine last_release(family, events, clearance, unknowns, found)
      type(rest_family_type), intent(in) :: family
      type(event_type), intent(in) :: events(:)
      real(wp), intent(in) :: clearance
      real(wp), intent(out) :: unknowns(2)
      logical, intent(out) :: found
      integer :: i, n

      n = size(family%letters)
      unknowns = 0
      found = .false.
      do i = size(events), 1, -1
         found = events(i)%kind == release_event .and. events(i)%side == sign(1, family%letters(n))
         if (.not. found) cycle
         unknowns = [events(i)%phase, events(i)%x_dot_after/clearance]
         return
      end do
   end subroutine last_release

end module vi_rest_family
