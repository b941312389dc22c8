!> Motions with rest: the gradients of the equations and of all measures of a period.
module studies_rest
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use checks, only: check, check_close
   use random_numbers, only: fill, random_type
   use vi_conditions, only: all_conditions, condition_count, condition_value
   use vi_curve, only: condition_slope, curve_type
   use vi_forced_system, only: event_type, new_forced_system
   use vi_found_motion, only: are_same, described_type, found_type, store_described
   use vi_kinds, only: two_pi, wp
   use vi_likeness, only: same
   use vi_motion, only: motion_type, unknown, yes
   use vi_motion_family, only: condition_type, edge
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: new_pattern
   use vi_rest_family, only: follow_symbols, measure_type, new_rest_family, plane_map, &
      rest_family_type, rest_period, rest_period_type, rest_stability, rest_unknowns
   use vi_rest_motion, only: find_rest_motion, solve_rest_motion
   use vi_resting_family, only: new_resting_family
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: test_rest

   !> Measures of a period of n symbols: equations, approaches, rests, gaps.
   integer, parameter :: most = 40
   type(random_type) :: random

contains

   subroutine test_rest()
      type(rest_family_type) :: family
      real(wp) :: u(8), c(6)
      integer :: i, followed

      followed = 0
      do i = 1, 8000
         call fill(random, 0.0_wp, 1.0_wp, u)
         c = [0.5_wp + u(1), log(1 + 9*u(2)), 0.1_wp*u(3), 0.3_wp*u(4), 0.3_wp + 0.5_wp*u(5), &
            0.3_wp + 0.5_wp*u(6)]
         if (mod(i, 5) == 0) c(6) = 0
         select case (mod(i, 3))
         case (0)
            family = new_rest_family([1, -2], 1)
         case (1)
            family = new_rest_family([1, 1, -2], 1)
         case default
            family = new_rest_family([2, -2], 1)
         end select
         call check_period(family, [6.283_wp*u(7), asinh(3*(u(8) - 0.5_wp))], c, followed)
      end do
      call check(followed > 30, 'rest: periods that could be followed')
      call test_guessed_phases()
      call test_solved_again()
      call test_room()
      call test_repeated_periods()
      call test_same_releases()
   end subroutine test_rest

   !> At guessed phases of the impacts, which need not be those of a motion, a period can be
   !! followed only if impacts that accumulate begin with an approach, and it ends with a release
   !! within two periods.
   subroutine test_guessed_phases()
      type(rest_family_type) :: family
      type(rest_period_type) :: period
      real(wp) :: u(10), c(6), unknowns(5)
      integer :: i, m, right, departing

      right = 0
      departing = 0
      do i = 1, 3000
         call fill(random, 0.0_wp, 1.0_wp, u)
         c = [0.2_wp + 2*u(1), log(0.2_wp + 3*u(2)), 0.3_wp*u(3), u(4), 0.9_wp*u(5), 0.9_wp*u(6)]
         ! impacts without rebound
         if (mod(i, 5) == 0) c(5:) = 0
         select case (mod(i, 3))
         case (0)
            family = new_rest_family([1, -2], 1)
         case (1)
            family = new_rest_family([1, 2, -2], 1)
         case default
            family = new_rest_family([2, -2], 1)
         end select
         m = rest_unknowns(family)
         unknowns(:2) = [two_pi*u(7), asinh(3*(u(8) - 0.5_wp))]
         unknowns(3) = unknowns(1) + two_pi*u(9)
         unknowns(4) = unknowns(3) + two_pi*u(10)
         unknowns(5) = unknowns(4) + 0.5_wp*two_pi*u(1)
         call rest_period(family, unknowns(:m), c, period)
         if (period%right) then
            right = right + 1
            associate (release => period%equations(1)%value + unknowns(1) + two_pi)
               ! without restitution the release of a rest that has vanished precedes the impact
               call check((release >= unknowns(m) .or. period%rest(size(period%rest))%value < 0) &
                  .and. release <= unknowns(1) + 2*two_pi, &
                  'rest: a release after the last impact, within two periods')
            end associate
            call check(all(period%approach%value >= 0 .or. abs(family%symbols) == 1 .or. &
               c(5) <= 0), 'rest: no accumulation begins with a departure')
         else
            departing = departing + 1
         end if
      end do
      call check(right > 100 .and. departing > 100, 'rest: periods of guessed phases')
   end subroutine test_guessed_phases

   !> The search from its own release finds a motion with rest again; its last two
   !! multipliers are 0.
   subroutine test_solved_again()
      type(motion_type) :: motion, again
      type(event_type) :: events(100)
      real(wp) :: u(8), point(2), other(2)
      integer :: i, n, m, solved, side

      solved = 0
      do i = 1, 1500
         call fill(random, 0.0_wp, 1.0_wp, u)
         side = 3 - 2*(1 + mod(i, 2))
         associate (system => new_forced_system(oscillator_type(0.3_wp*u(1), u(2), [0.9_wp*u(3), &
            merge(0.0_wp, 0.6_wp, mod(i, 4) == 0)]), 0.1_wp + 1.5_wp*u(4), 1.0_wp, 0.1_wp + 4*u(5)))
            point = [6.283_wp*u(6), 4*(u(7) - 0.5_wp)]
            call solve_rest_motion(system, side, 1, point, motion, events, n)
            if (motion%status /= stat%ok) cycle
            solved = solved + 1
            other = point
            call solve_rest_motion(system, side, 1, other, again, events, m)
            call check(again%status == stat%ok .and. m == n, 'rest: solved again')
            call check_close(maxval(abs(other - point)), 0.0_wp, 1.0e-9_wp, &
               'rest: the same release')
            call check(all(abs(motion%multipliers(3:)) <= 0), 'rest: multipliers')
         end associate
      end do
      call check(solved > 40, 'rest: motions are found')
   end subroutine test_solved_again

   !> A motion with rest is stored if there is memory for all of its events; otherwise only their
   !! number is returned.
   subroutine test_room()
      type(described_type) :: described
      real(wp), allocatable :: restitution(:), phases(:), impacts(:, :), values(:, :)
      integer, allocatable :: sides(:), labels(:, :)
      real(wp) :: scalars(6)
      complex(wp) :: multipliers(4)
      integer :: n, cycles, verdicts(3), events, status, needed, room

      associate (system => new_forced_system(oscillator_type(0.00359_wp, 0.05224_wp, [0.6257_wp, &
         0.371_wp]), 0.986630084605407_wp, 1.0_wp, 10.8_wp))
         call find_rest_motion(system, -1, 1, [2.663216_wp, 30.01765_wp], 400, described%motion, &
            described%events)
      end associate
      call check(described%motion%status == stat%ok, 'rest: a motion to store')
      needed = size(described%events)
      call check(needed > size(described%motion%x), 'rest: more events than symbols')
      do room = needed - 1, needed + 1
         allocate (sides(room), restitution(room), phases(room), impacts(room, 6), &
            values(7, room), labels(2, room))
         call store_described(described, n, cycles, sides, restitution, phases, impacts, scalars, &
            multipliers, verdicts, events, values, labels, status)
         call check(status == merge(stat%ok, stat%more_events, room >= needed), 'rest: room')
         call check(n == size(described%motion%x) .and. events == needed, 'rest: what is needed')
         if (status == stat%ok) then
            call check(cycles == 1 .and. all(sides(:n) == described%motion%pattern%sides), &
               'rest: stored symbols')
            call check_close(maxval(abs(phases(:n) - described%motion%phases)), 0.0_wp, 0.0_wp, &
               'rest: stored phases')
         end if
         deallocate (sides, restitution, phases, impacts, values, labels)
      end do
   end subroutine test_room

   !> Motions with rest are the same if a release of one is a release of the other, in a later load
   !! cycle or not: a difference in side, phase or velocity alone distinguishes them.
   subroutine test_same_releases()
      real(wp), parameter :: scale = 3.0_wp, off = 2*same, near = 0.5_wp*same
      real(wp), parameter :: release(3) = [1.0_wp, 0.4_wp, -2.0_wp]

      call compare([0.0_wp, 0.0_wp, 0.0_wp], .true.)
      call compare([0.0_wp, -3*two_pi + near, 0.0_wp], .true.)
      call compare([0.0_wp, 0.0_wp, -near*scale], .true.)
      call compare([-2.0_wp, 0.0_wp, 0.0_wp], .false.)
      call compare([0.0_wp, off, 0.0_wp], .false.)
      call compare([0.0_wp, -off, 0.0_wp], .false.)
      call compare([0.0_wp, 0.5_wp*two_pi, 0.0_wp], .false.)
      call compare([0.0_wp, 0.0_wp, off*scale], .false.)
      call compare([0.0_wp, 0.0_wp, -off*scale], .false.)

   contains

      !> A motion with this release, and another motion whose second release differs.
      subroutine compare(difference, expected)
         real(wp), intent(in) :: difference(3)
         logical, intent(in) :: expected
         type(found_type) :: one, other

         one%pattern = new_pattern('', 1)
         other%pattern = one%pattern
         one%releases = reshape(release, [3, 1])
         other%releases = reshape([1.0_wp, 2.0_wp, 5.0_wp, release + difference], [3, 2])
         call check(are_same(one, other, scale) .eqv. expected, 'rest: the same releases')
         other%pattern%cycles = 2
         call check(.not. are_same(one, other, scale), 'rest: other periods')
      end subroutine compare

   end subroutine test_same_releases

   !> A motion with rest, and the same motion as one of seven times the period: its multipliers are
   !! the seventh powers, although they come from the derivative of a simulation and not of symbols,
   !! of which no family has so many.
   !!
   !! At the clearance `critical` both leading multipliers lie on the unit circle. Near it the
   !! effect of rounding decides whether there is a verdict; without symbols it is unknown, and so
   !! is the verdict.
   subroutine test_repeated_periods()
      real(wp), parameter :: r = 0.986630084605407_wp, critical = 10.85053457697103_wp
      real(wp), parameter :: offsets(3) = [-1.0e-3_wp, -1.0e-4_wp, 0.0_wp]
      integer, parameter :: times = 7, once_stable(3) = [yes, yes, unknown], &
         repeated_stable(3) = [yes, unknown, unknown]
      type(motion_type) :: once, repeated
      type(event_type) :: events(400)
      real(wp) :: point(2), again(2)
      integer :: i, n, m

      do i = 1, size(offsets)
         associate (system => new_forced_system(oscillator_type(0.00359_wp, 0.05224_wp, &
            [0.6257_wp, 0.371_wp]), r, 1.0_wp, critical*(1 + offsets(i))))
            point = [2.663216_wp, 30.01765_wp]
            call solve_rest_motion(system, -1, 1, point, once, events, n)
            again = point
            call solve_rest_motion(system, -1, times, again, repeated, events, m)
         end associate
         call check(once%status == stat%ok .and. repeated%status == stat%ok, 'rest: both periods')
         call check(m == times*n, 'rest: events of a repeated period')
         call check_close(maxval(abs(again - point)), 0.0_wp, 1e-10_wp, &
            'rest: a repeated period begins with the same release')
         call check_close(abs(once%multipliers(1)) - 1, offsets(i), 0.1_wp*abs(offsets(i)) &
            + 1e-12_wp, 'rest: a place near the unit circle')
         call check_close(aimag(repeated%multipliers(1))**2, aimag(once%multipliers(1)**times)**2, &
            1e-8_wp, 'rest: a multiplier of a repeated period')
         call check_close(real(sum(repeated%multipliers(:2))), &
            real(sum(once%multipliers(:2)**times)), 1e-8_wp, 'rest: both multipliers')
         call check(once%stable == once_stable(i), 'rest: a verdict near the unit circle')
         call check(repeated%stable == repeated_stable(i), 'rest: a verdict without symbols')
      end do
   end subroutine test_repeated_periods

   !> The conditions of a motion that is cut by edges, and the conditions that remain if its symbols
   !! cannot be followed.
   subroutine check_conditions(family, unknowns, c)
      type(rest_family_type), intent(in) :: family
      real(wp), intent(in) :: unknowns(:), c(6)
      type(curve_type) :: curve
      type(condition_type), allocatable :: found(:)
      real(wp), allocatable :: values(:), lost(:)
      real(wp) :: room, slope(size(unknowns) + 2), value, wanted(size(slope))
      integer :: i, n, side

      allocate (curve%family, source=new_resting_family(family%symbols, family%cycles))
      curve%c = c
      curve%active = [1, 2]
      curve%origin = c(:2)
      curve%scale = [1.0_wp, 1.0_wp]
      allocate (curve%edges(12))
      do i = 1, 6
         do side = 1, -1, -2
            curve%edges(2*i - (side + 1)/2) = condition_type(edge, i, side, &
               bound=c(i) - side*0.1_wp*i)
         end do
      end do
      n = condition_count(curve)
      allocate (values(n), lost(n), found(n))
      call all_conditions(curve, unknowns, c, values, found)
      do i = 1, n
         associate (condition => found(i))
            call check_close(condition_value(curve, unknowns, c, condition), values(i), &
               1e-14_wp*abs(values(i)), 'rest: one condition and all')
            if (condition%kind /= edge) cycle
            room = 0.1_wp*condition%index
            call check_close(values(i), room, 1e-14_wp, 'rest: the room up to an edge')
            call condition_slope(curve, condition, [unknowns, 0.0_wp, 0.0_wp], value, slope)
            wanted = 0
            if (condition%index <= 2) wanted(size(unknowns) + condition%index) = condition%side
            call check(all(abs(slope - wanted) <= 0), 'rest: how it changes')
         end associate
      end do
      ! impacts in the wrong order
      call all_conditions(curve, [unknowns(:2), unknowns(3:) - 100], c, lost, found)
      do i = 1, n
         call check_close(lost(i), merge(values(i), -1.0_wp, found(i)%kind == edge), 0.0_wp, &
            'rest: edges alone have a value where no motion is')
         if (found(i)%kind == edge) cycle
         call check(ieee_is_nan(condition_value(curve, [unknowns(:2), unknowns(3:) - 100], c, &
            found(i))), 'rest: one condition where no motion is')
      end do
   end subroutine check_conditions

   !> Derivatives of one period compared with differences; the map of the plane and its symbols.
   subroutine check_period(family, release, c, followed)
      type(rest_family_type), intent(in) :: family
      !> Phase and asinh(v/D) at the release.
      real(wp), intent(in) :: release(2)
      !> r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(6)
      integer, intent(inout) :: followed
      real(wp), parameter :: h = 2.0e-5_wp, weight(4) = [1, -8, 8, -1]/12.0_wp
      type(rest_period_type) :: period
      real(wp) :: unknowns(rest_unknowns(family)), point(rest_unknowns(family) + 2), moved(6)
      real(wp) :: values(most, 4), slopes(most, size(point)), base(most), slope
      logical :: good(4)
      integer :: i, j, k, n, m

      m = size(unknowns)
      call follow_symbols(family, release, c, unknowns, good(1))
      if (.not. good(1)) return
      call rest_period(family, unknowns, c, period)
      call check(period%right, 'rest: what was followed is a period')
      call check_conditions(family, unknowns, c)
      if (.not. period%right .or. .not. is_generic(period)) return
      followed = followed + 1
      call check_stability(period)
      call list(period, base, n, slopes)
      do j = 1, m + 2
         do i = 1, 4
            point = [unknowns, c(:2)]
            point(j) = point(j) + h*merge(i - 3, i - 2, i < 3)
            moved = c
            moved(:2) = point(m + 1:)
            call rest_period(family, point(:m), moved, period)
            good(i) = period%right
            if (good(i)) call list(period, values(:, i), k)
         end do
         if (.not. all(good)) cycle
         do k = 1, n
            slope = dot_product(weight, values(k, :))/h
            call check_close(slopes(k, j), slope, 2.0e-7_wp*(1 + maxval(abs(slopes(k, :m + 2))) &
               + maxval(abs(base(:n)))), 'rest: a derivative by '//achar(48 + j)//' of ' &
               //achar(48 + k))
         end do
      end do
   end subroutine check_period

   !> Jury's conditions from determinants of all equations, and from the map of the plane.
   subroutine check_stability(period)
      type(rest_period_type), intent(in) :: period
      real(wp) :: j(2, 2), trace, determinant, conditions(3)
      integer :: i

      j = plane_map(period)
      trace = j(1, 1) + j(2, 2)
      determinant = j(1, 1)*j(2, 2) - j(1, 2)*j(2, 1)
      conditions = product(period%approach%value)*[1 - trace + determinant, &
         1 + trace + determinant, 1 - determinant]
      associate (values => rest_stability(period))
         do i = 1, 3
            call check_close(values(i), conditions(i), 1.0e-9_wp*(1 + maxval(abs(j))**2 &
               *product(period%approach%value)), 'rest: a condition of stability')
         end do
      end associate
   end subroutine check_stability

   !> Whether no event of the period is about to vanish, which differences would cross, and no
   !! contact force is negative: such a period is not a motion, and an accumulation interrupted by
   !! the force is cut off at varying impacts, between which the measures jump.
   pure logical function is_generic(period)
      type(rest_period_type), intent(in) :: period

      is_generic = all(period%approach%value > 1.0e-2_wp) .and. all(period%rest%value > 1.0e-2_wp) &
         .and. all(period%gap%value > 1.0e-2_wp .or. period%touched_at >= 0)
   end function is_generic

   !> Equations, approach speeds, rests and gaps in a row, with their derivatives.
   subroutine list(period, values, n, slopes)
      type(rest_period_type), intent(in) :: period
      real(wp), intent(out) :: values(:)
      integer, intent(out) :: n
      real(wp), intent(out), optional :: slopes(:, :)
      type(measure_type) :: measures(size(period%equations) + 3*size(period%rest))
      integer :: i

      measures = [period%equations, period%approach, period%rest, period%gap]
      n = size(measures)
      values(:n) = measures%value
      if (.not. present(slopes)) return
      do i = 1, n
         slopes(i, :) = measures(i)%by(:size(slopes, 2))
      end do
   end subroutine list

end module studies_rest
