!> Motions as a search keeps them: each in a standard form, so that no motion is kept twice.
!!
!! A motion without rest is described by its pattern with positions and phases, one with rest by its
!! releases. A search may find a motion over several periods, beginning with any of its impacts, or
!! as the mirror image of a known one.
module vi_found_motion
   use vi_assess, only: assess_exact, assess_flights
   use vi_forced_system, only: forced_system_type, event_type, release_event
   use vi_exact, only: setting_type, solve_exact
   use vi_kinds, only: two_pi, wp
   use vi_symbols, only: standard_symbols
   use vi_likeness, only: distance, length_scale, same, shortest_repetition
   use vi_motion, only: motion_type, unknown, yes
   use vi_pattern, only: default_restitution, pattern_type
   use vi_points, only: store_motion
   use vi_rest_motion, only: find_rest_motion, solve_rest_motion
   use vi_status, only: stat
   use vi_trajectory, only: store_events
   implicit none (type, external)
   private

   public :: are_alike, are_same, describe_motion, find_in_form, found_from, in_standard_form, &
      mirrored, new_found, new_resting, scale_of, setting_of, store_described

   !> Newton iterations for a motion without rest.
   integer, parameter :: most_iterations = 50
   !> Largest numbers of events of a period with rest, tried in turn: most periods have few events.
   integer, parameter :: rooms(2) = [200, 20000]

   !> A motion that a search has found.
   type, public :: found_type
      !> The sides of the impacts (no sides with rest), and the load cycles.
      type(pattern_type) :: pattern
      !> x_i, theta_i (2n); none with rest.
      real(wp), allocatable :: unknowns(:)
      !> With rest: side, phase and velocity of the releases of a period (3, m).
      real(wp), allocatable :: releases(:, :)
      !> As in vi_motion.
      integer :: admissible = unknown, stable = unknown
      integer :: status = stat%no_motion
   end type found_type

   !> A motion with its full description.
   type, public :: described_type
      !> One with rest is as `find_rest_motion` returns it.
      type(motion_type) :: motion
      !> With rest: all events of a period.
      type(event_type), allocatable :: events(:)
   end type described_type

contains

   !> The exact motion of a pattern near a guess, with its verdicts.
   pure subroutine new_found(system, pattern, x, theta, found)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Sides of the n impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> (n) Guess: positions x_i and theta_i = alpha_i + tau (rad).
      real(wp), intent(in) :: x(:), theta(:)
      !> The motion with its verdicts; without its arrays unless its status is `stat%ok` or
      !! `stat%no_convergence`.
      type(found_type), intent(out) :: found
      type(motion_type) :: motion
      real(wp) :: x_now(size(x)), theta_now(size(x)), none(2*size(x), 0)
      integer :: iterations

      x_now = x
      theta_now = theta
      call solve_exact(setting_of(system, pattern), x_now, theta_now, most_iterations, none, &
         motion, iterations)
      found%status = motion%status
      if (found%status /= stat%ok) return
      call assess_exact(motion)
      call assess_flights(motion)
      found%status = merge(stat%ok, stat%no_convergence, motion%consistent == yes)
      found%admissible = motion%admissible
      found%stable = motion%stable
      found%pattern = pattern
      found%unknowns = [x_now, theta_now]
      allocate (found%releases(3, 0))
   end subroutine new_found

   !> The periodic motion with rest near a release, with its verdicts.
   pure subroutine new_resting(system, side, cycles, guess, capacity, found)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The wall of the release, and the load cycles of the period.
      integer, intent(in) :: side, cycles
      !> (phase, v) at the release.
      real(wp), intent(in) :: guess(2)
      !> Largest number of events of the period.
      integer, intent(in) :: capacity
      !> The motion with its verdicts; without its arrays unless its status is `stat%ok`, or
      !! `stat%no_convergence` because its period does not close to rounding.
      type(found_type), intent(out) :: found
      type(event_type), allocatable :: events(:)
      type(motion_type) :: motion
      real(wp) :: point(2)
      integer :: i, n, m

      allocate (events(capacity))
      point = guess
      call solve_rest_motion(system, side, cycles, point, motion, events, n)
      found%status = motion%status
      if (found%status /= stat%ok) return
      found%status = merge(stat%ok, stat%no_convergence, motion%consistent == yes)
      found%admissible = motion%admissible
      found%stable = motion%stable
      allocate (found%pattern%sides(0), found%unknowns(0))
      found%pattern%cycles = cycles
      allocate (found%releases(3, count(events(:n)%kind == release_event)))
      ! the last one is the release that was solved for
      m = size(found%releases, 2)
      do i = n, 1, -1
         if (events(i)%kind /= release_event) cycle
         found%releases(:, m) = [real(events(i)%side, wp), events(i)%phase, events(i)%x_dot_after]
         m = m - 1
      end do
      m = size(found%releases, 2)
      found%releases(:, m) = [real(side, wp), point]
   end subroutine new_resting

   !> Solves for a motion again, and describes it in full.
   pure subroutine describe_motion(system, found, described)
      !> The system.
      type(forced_system_type), intent(in) :: system
      !> The motion.
      type(found_type), intent(in) :: found
      !> The same motion; its status says whether it could be confirmed.
      type(described_type), intent(out) :: described
      real(wp) :: unknowns(size(found%unknowns)), none(size(found%unknowns), 0)
      integer :: n, iterations

      n = size(found%pattern%sides)
      if (n == 0) then
         call describe_resting(system, nint(found%releases(1, 1)), found%pattern%cycles, &
            found%releases(2:, 1), described)
         return
      end if
      unknowns = found%unknowns
      call solve_exact(setting_of(system, found%pattern), unknowns(:n), unknowns(n + 1:), &
         most_iterations, none, described%motion, iterations)
      call assess_exact(described%motion)
      call assess_flights(described%motion)
   end subroutine describe_motion

   !> A motion from arrays of fixed shape.
   pure function found_from(cycles, sides, unknowns, releases) result(found)
      !> Load cycles of a period, and sides of the n impacts; with rest, a single 0.
      integer, intent(in) :: cycles, sides(:)
      !> (2n) x_i, theta_i; and with rest (3, m) side, phase and velocity of the releases, otherwise
      !! a column of zeros.
      real(wp), intent(in) :: unknowns(:), releases(:, :)
      type(found_type) :: found
      integer :: n

      n = count(sides /= 0)
      found = found_type(pattern_type(sides(:n), cycles), unknowns(:2*n), &
         releases(:, :count(abs(releases(1, :)) > 0)))
   end function found_from

   !> Whether two motions of one pattern, or one and the mirror image of the other, are the same.
   pure logical function are_alike(system, one, other, mirror) result(alike)
      !> The system.
      type(forced_system_type), intent(in) :: system
      !> The motions.
      type(found_type), intent(in) :: one, other
      !> Whether the mirror image of the other is meant.
      logical, intent(in) :: mirror
      type(found_type) :: second
      real(wp) :: scale

      scale = scale_of(system)
      second = other
      if (mirror) second = mirrored(other)
      alike = are_same(in_standard_form(one, scale), in_standard_form(second, scale), scale)
   end function are_alike

   !> Unit of positions, as `length_scale`.
   pure real(wp) function scale_of(system)
      !> The system.
      type(forced_system_type), intent(in) :: system

      scale_of = max(system%clearance, system%load*length_scale(system%osc, system%r, 0.0_wp))
   end function scale_of

   !> A motion near a given one, or its standard form, with its full description.
   pure subroutine find_in_form(system, found, form, changed, described)
      !> The system.
      type(forced_system_type), intent(in) :: system
      !> The approximate motion. With rest, the last release precedes the first impact described.
      type(found_type), intent(in) :: found
      !> 0 for the motion as it is given, 1 for its standard form, 2 for that of its mirror image.
      integer, intent(in) :: form
      !> Whether the given motion is not in that form.
      logical, intent(out) :: changed
      !> The motion, or its status.
      type(described_type), intent(out) :: described
      type(found_type) :: wanted
      real(wp) :: scale

      scale = scale_of(system)
      wanted = found
      if (form == 2) wanted = mirrored(found)
      if (form > 0) wanted = in_standard_form(wanted, scale)
      changed = form == 2 .or. wanted%pattern%cycles /= found%pattern%cycles
      ! the same positions in another order: if any is less, another is greater
      if (.not. changed) changed = any(wanted%unknowns > found%unknowns)
      wanted%releases = cshift(wanted%releases, -1, dim=2)
      call describe_motion(system, wanted, described)
   end subroutine find_in_form

   !> The motion with rest near a release.
   pure subroutine describe_resting(system, side, cycles, guess, described)
      !> The system.
      type(forced_system_type), intent(in) :: system
      !> The wall of the release, and the load cycles of the period.
      integer, intent(in) :: side, cycles
      !> (phase, v) at the release.
      real(wp), intent(in) :: guess(2)
      !> The motion.
      type(described_type), intent(out) :: described
      integer :: i

      do i = 1, size(rooms)
         call find_rest_motion(system, side, cycles, guess, rooms(i), described%motion, &
            described%events)
         if (described%motion%status /= stat%more_events) return
      end do
   end subroutine describe_resting

   !> A motion with its full description as arrays with capacity for some impacts and events.
   pure subroutine store_described(described, n, cycles, sides, restitution, phases, impacts, &
      scalars, multipliers, verdicts, n_events, values, labels, status)
      !> The motion, or its status.
      type(described_type), intent(in) :: described
      !> Number of impacts, or of symbols of one with rest, and load cycles.
      integer, intent(out) :: n, cycles
      !> Sides, 2 and -2 for accumulation and rest; coefficients of restitution; phases (rad).
      integer, intent(out) :: sides(:)
      !> As in `sides`.
      real(wp), intent(out) :: restitution(:), phases(:)
      !> (capacity, 6), (6), (4), (3) as in vi_points.
      real(wp), intent(out) :: impacts(:, :), scalars(:)
      !> As in `impacts`.
      complex(wp), intent(out) :: multipliers(:)
      !> As in `impacts`.
      integer, intent(out) :: verdicts(:)
      !> With rest: number of events of a period, and the events as in `store_events`.
      integer, intent(out) :: n_events
      !> As in `n_events`.
      real(wp), intent(out) :: values(:, :)
      !> As in `n_events`.
      integer, intent(out) :: labels(:, :)
      !> Status of the motion, or `stat%more_events` if the capacity is too small.
      integer, intent(out) :: status

      n = 0
      n_events = 0
      status = described%motion%status
      if (status /= stat%ok) return
      associate (motion => described%motion)
         if (allocated(described%events)) n_events = size(described%events)
         n = size(motion%x)
         if (max(n, n_events) > size(sides)) then
            status = stat%more_events
            return
         end if
         cycles = motion%pattern%cycles
         sides(:n) = motion%pattern%sides
         restitution(:n) = motion%restitution
         phases(:n) = motion%phases
         call store_motion(motion, .true., impacts(:n, :), scalars, multipliers, verdicts, status)
         if (n_events > 0) call store_events(described%events, motion%r, values, labels)
      end associate
   end subroutine store_described

   !> The given data of a motion of a pattern.
   pure function setting_of(system, pattern) result(setting)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Sides of the impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      type(setting_type) :: setting

      setting = setting_type(system%osc, system%r, system%load, system%clearance, pattern, &
         default_restitution(pattern%sides, system%osc%restitution(1), system%osc%restitution(2)))
   end function setting_of

   !> The same motion over its shortest period, beginning with the impact that `standard_symbols`
   !! puts first.
   pure function in_standard_form(found, scale) result(standard)
      !> The motion.
      type(found_type), intent(in) :: found
      !> Unit of positions, as `length_scale`.
      real(wp), intent(in) :: scale
      type(found_type) :: standard
      integer, allocatable :: symbols(:)
      integer :: i, n, m, parts, shift
      logical :: unused

      standard = found
      if (size(found%releases, 2) > 0) then
         parts = count([(near_release(found%releases(:, 1), found%releases(:, i), scale), &
            i=1, size(found%releases, 2))])
         standard%pattern%cycles = found%pattern%cycles/parts
         return
      end if
      n = size(found%pattern%sides)
      m = shortest_repetition(found%pattern, scale, found%unknowns)
      standard%pattern%sides = found%pattern%sides(:m)
      standard%pattern%cycles = found%pattern%cycles*m/n
      standard%unknowns = [found%unknowns(:m), found%unknowns(n + 1:n + m)]
      allocate (symbols(m))
      call standard_symbols(standard%pattern%sides, .false., symbols, shift, unused)
      standard%pattern%sides = symbols
      standard%unknowns(:m) = cshift(standard%unknowns(:m), shift)
      associate (theta => standard%unknowns(m + 1:))
         theta(:shift) = theta(:shift) + two_pi*standard%pattern%cycles
         theta = cshift(theta, shift)
      end associate
   end function in_standard_form

   !> The mirror image, where the walls are alike: x -> -x, R <-> L, half a load cycle later.
   pure function mirrored(found) result(image)
      !> The motion.
      type(found_type), intent(in) :: found
      type(found_type) :: image
      integer :: n

      image = found
      image%pattern%sides = -found%pattern%sides
      n = size(found%pattern%sides)
      image%unknowns(:n) = -found%unknowns(:n)
      image%unknowns(n + 1:) = found%unknowns(n + 1:) + 0.5_wp*two_pi
      image%releases(1, :) = -found%releases(1, :)
      image%releases(2, :) = modulo(found%releases(2, :) + 0.5_wp*two_pi, two_pi)
      image%releases(3, :) = -found%releases(3, :)
   end function mirrored

   !> Whether two motions in standard form are the same.
   pure logical function are_same(one, other, scale)
      !> The motions.
      type(found_type), intent(in) :: one, other
      !> Unit of positions, as `length_scale`.
      real(wp), intent(in) :: scale
      integer :: i

      are_same = .false.
      if (one%pattern%cycles /= other%pattern%cycles) return
      if (size(one%pattern%sides) /= size(other%pattern%sides)) return
      if (size(one%releases, 2) > 0) then
         are_same = any([(near_release(one%releases(:, 1), other%releases(:, i), scale), &
            i=1, size(other%releases, 2))])
      else if (all(one%pattern%sides == other%pattern%sides)) then
         are_same = distance(one%pattern, scale, one%unknowns, other%unknowns) < same
      end if
   end function are_same

   !> Whether two releases are the same except for whole load cycles.
   pure logical function near_release(one, other, scale) result(near)
      !> Side, phase and velocity of each.
      real(wp), intent(in) :: one(3), other(3)
      !> Unit of velocities.
      real(wp), intent(in) :: scale
      real(wp) :: gap

      gap = other(2) - one(2)
      gap = gap - two_pi*nint(gap/two_pi)
      near = one(1)*other(1) > 0 .and. abs(gap) < same .and. abs(other(3) - one(3)) < same*scale
   end function near_release

end module vi_found_motion
