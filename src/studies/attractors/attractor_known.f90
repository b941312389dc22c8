!> An attractor at a point (r, D); a periodic one is refined to a fixed point of the simulation.
module vi_attractor_known
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_attractor_neighbourhood, only: find_neighbourhoods
   use vi_attractor_tangent, only: period_derivative
   use vi_attractor_target, only: difference, over_period, start_target, target_type
   use vi_forced_system, only: forced_system_type, event_type, impact_event, initial_state, &
      release_event, state_type
   use vi_event_symbols, only: symbol_endings
   use vi_kinds, only: two_pi, wp
   use vi_lapack, only: eigenvalues, solve
   use vi_oscillator, only: eta
   use vi_symbols, only: standard_symbols
   use vi_simulate, only: simulate
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: alike, ball, exact_period, identify, is_free, periods_in, shortest_period, within

   !> Kinds of attractors. The last one is a simulation that repeats itself although no stable
   !! motion is confirmed.
   integer, parameter, public :: periodic = 1, resting = 2, quasi_periodic = 3, chaotic = 4, &
      no_impacts = 5, repeating = 6

   !> Largest number of events of a period, and largest distance of Newton's solution from a state
   !! that has settled: over the clearance, and of the phase (rad).
   integer, parameter :: capacity = 2048
   real(wp), parameter :: near = 1.0e-2_wp

   !> An attractor.
   type, public :: known_type
      integer :: kind = 0
      !> Load cycles, and symbols of a period: sides, doubled where impacts accumulate, in the
      !! rotation that comes last in alphabetical order.
      integer :: cycles = 0
      integer, allocatable :: symbols(:)
      !> t, x, x', z, z' of a state on it.
      real(wp) :: state(5) = 0
      !> For a periodic one: its impacts, or its releases, with their neighbourhoods.
      type(target_type), allocatable :: targets(:)
      !> For a periodic one: greatest modulus of its multipliers; for others: largest exponent per
      !! load cycle.
      real(wp) :: largest = 0
   end type known_type

contains

   !> The stable periodic motion on which a state lies, and its neighbourhoods.
   subroutine identify(system, end, cycles, threads, known, good, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> t, x, x', z, z'
      real(wp), intent(in) :: end(5)
      !> Load cycles of the period, and number of OpenMP threads.
      integer, intent(in) :: cycles, threads
      !> The motion, if there is one.
      type(known_type), intent(out) :: known
      !> False if there is none.
      logical, intent(out) :: good
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)

      call shortest_period(system, end, cycles, known, good)
      if (good) call find_neighbourhoods(system%osc, system%r, system%load, system%clearance, &
         known%targets, threads, progress)
   end subroutine identify

   !> The stable periodic motion on which a state lies, with its shortest period: while a simulation
   !! still approaches a motion, it may seem to repeat itself only after several periods.
   pure subroutine shortest_period(system, end, cycles, known, good, farthest)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> t, x, x', z, z'
      real(wp), intent(in) :: end(5)
      !> Load cycles of one or more periods.
      integer, intent(in) :: cycles
      !> Its targets have no neighbourhoods yet.
      type(known_type), intent(out) :: known
      !> False if there is none.
      logical, intent(out) :: good
      !> As in `exact_period`.
      real(wp), intent(in), optional :: farthest
      integer :: parts

      call exact_period(system, end, cycles, known, good, farthest)
      if (.not. good) return
      parts = periods_in(system, known)
      known%cycles = known%cycles/parts
      known%largest = known%largest**(1.0_wp/parts)
      known%symbols = known%symbols(:size(known%symbols)/parts)
      known%targets = known%targets(:size(known%targets)/parts)
      known%targets%cycles = known%cycles
   end subroutine shortest_period

   !> How many times a motion repeats itself within its load cycles.
   pure integer function periods_in(system, known) result(parts)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The motion.
      type(known_type), intent(in) :: known
      integer :: n

      n = size(known%targets)
      do parts = known%cycles, 2, -1
         if (modulo(known%cycles, parts) /= 0 .or. modulo(n, parts) /= 0) cycle
         if (coincide(known%targets(1), known%targets(1 + n/parts), system%clearance)) return
      end do
      parts = 1
   end function periods_in

   !> The stable periodic motion on which a state lies.
   pure subroutine exact_period(system, end, cycles, known, good, farthest)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> t, x, x', z, z'
      real(wp), intent(in) :: end(5)
      !> Load cycles of the period.
      integer, intent(in) :: cycles
      !> Its targets have no neighbourhoods yet.
      type(known_type), intent(out) :: known
      !> False if there is none.
      logical, intent(out) :: good
      !> How far the motion may be from the state, over the clearance and in phase (rad); by default
      !! as near as to a state that has settled.
      real(wp), intent(in), optional :: farthest
      type(event_type), allocatable :: events(:)
      type(state_type) :: state, final
      type(target_type) :: target
      complex(wp) :: lambda(4)
      real(wp) :: p(4, 4), phase, distance
      integer, allocatable :: ring(:)
      integer :: n, i, status, turns
      logical :: mirrored

      allocate (events(capacity))
      state = initial_state(system, within(end, system%clearance))
      state%cycle = 0
      phase = state%phase                               ! of the start: `state` changes
      call simulate(system, state, int(cycles, int64), phase, events, n, final, status)
      i = n
      if (any(events(:n)%kind /= impact_event)) i = findloc(events(:n)%kind, release_event, 1, &
         back=.true.)
      good = status == stat%ok .and. i > 0
      if (.not. good) return
      call start_target(system, events(i), cycles, target)
      distance = near
      if (present(farthest)) distance = farthest
      call converge(system, target, distance, events, n, p, good)
      if (.not. good) return
      call eigenvalues(p, lambda, status)
      known%largest = maxval(abs(lambda))
      good = status == stat%ok .and. known%largest < 1
      known%kind = merge(resting, periodic, target%release)
      known%cycles = cycles
      known%state = within(end, system%clearance)
      ring = symbol_endings(events(:n), .true.)
      ring = pack(ring, ring /= 0)
      allocate (known%symbols(size(ring)))
      call standard_symbols(ring, .false., known%symbols, turns, mirrored)
      allocate (known%targets(count(events(:n)%kind == events(n)%kind)))
      n = 0
      do i = 1, size(known%targets)
         n = n + findloc(events(n + 1:)%kind, merge(release_event, impact_event, target%release), 1)
         call start_target(system, events(n), cycles, known%targets(i))
      end do
   end subroutine exact_period

   !> Whether the free mass is at rest and no wall ever reaches it.
   !!
   !! The primary mass moves as A sin(rt - lag) plus a decaying free vibration: the sum of their
   !! present amplitudes bounds |x| from now on.
   pure logical function is_free(system, state)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The present state.
      type(state_type), intent(in) :: state
      real(wp) :: x, x_dot, most

      is_free = .false.
      if (state%side /= 0 .or. state%resting .or. abs(state%z_dot) > 0) return
      associate (osc => system%osc, angle => state%phase - system%lag)
         x = state%x - system%amplitude*sin(angle)
         x_dot = state%x_dot - system%r*system%amplitude*cos(angle)
         most = system%amplitude + hypot(x, (x_dot + osc%xi*x)/eta(osc%xi))
      end associate
      is_free = abs(state%z) + most < 0.5_wp*system%clearance
   end function is_free

   !> A state with its free mass moved back between the walls if rounding has put it outside.
   pure function within(state, clearance) result(inside)
      !> t, x, x', z, z'
      real(wp), intent(in) :: state(5)
      !> The clearance.
      real(wp), intent(in) :: clearance
      real(wp) :: inside(5)

      inside = state
      inside(4) = state(2) + min(max(state(4) - state(2), -0.5_wp*clearance), 0.5_wp*clearance)
   end function within

   !> Newton's method on the map over a period, from a state that is almost periodic.
   pure subroutine converge(system, target, farthest, events, n, p, good)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: event and period of a motion that is almost periodic. Out: of the exact motion.
      type(target_type), intent(inout) :: target
      !> How far the motion may be from the start.
      real(wp), intent(in) :: farthest
      !> Out: events 1 to n of the period.
      type(event_type), intent(inout) :: events(:)
      !> Number of events of the period.
      integer, intent(out) :: n
      !> Derivative of the map over the period.
      real(wp), intent(out) :: p(4, 4)
      !> False if it did not converge to a motion near the start.
      logical, intent(out) :: good
      real(wp) :: zero(4), off, before, scale(4), matrix(4, 4), step(4), begin(4)
      integer :: i, j, status

      zero = 0
      begin = target%middle
      scale = system%clearance
      scale(target%n:) = 1
      before = huge(1.0_wp)
      associate (m => target%n)
         do i = 1, 20
            call over_period(system, target, zero, events, n, good)
            if (.not. good) return
            call period_derivative(system, target%cycles, events(:n), p, good)
            if (.not. good) return
            step = difference(target, events(n))
            off = maxval(abs(step(:m)/scale(:m)))
            ! until only rounding errors are left
            if (off < 1.0e-9_wp .and. off >= 0.5_wp*before) exit
            before = off
            matrix = -p
            do j = 1, 4
               matrix(j, j) = matrix(j, j) + 1
            end do
            call solve(matrix, step, status)
            good = status == stat%ok
            if (.not. good) return
            target%middle(:m) = target%middle(:m) + step(:m)
            target%middle(m) = modulo(target%middle(m), two_pi)
         end do
         begin = begin - target%middle
         begin(m) = begin(m) - two_pi*anint(begin(m)/two_pi)
         good = off < 1.0e-9_wp .and. all(abs(begin(:m)) < farthest*scale(:m))
      end associate
   end subroutine converge

   !> Radius and contraction of the largest neighbourhood; 0 and 1 if there is none.
   pure function ball(known) result(numbers)
      !> A periodic motion.
      type(known_type), intent(in) :: known
      real(wp) :: numbers(2)
      integer :: i

      numbers = [0.0_wp, 1.0_wp]
      do i = 1, size(known%targets)
         associate (t => known%targets(i))
            if (t%radius > numbers(1)) numbers = [t%radius, t%contraction]
         end associate
      end do
   end function ball

   !> Whether two periodic motions are the same: the first event of one is an event of the other.
   pure logical function alike(one, other, clearance)
      !> The motions.
      type(known_type), intent(in) :: one, other
      !> The clearance, unit of the comparison.
      real(wp), intent(in) :: clearance
      integer :: i

      alike = .false.
      if (one%cycles /= other%cycles .or. size(one%symbols) /= size(other%symbols)) return
      alike = any([(coincide(one%targets(1), other%targets(i), clearance), i=1, &
         size(other%targets))])
   end function alike

   !> Whether two events of periodic motions are the same but for rounding.
   pure logical function coincide(one, other, clearance)
      !> The events.
      type(target_type), intent(in) :: one, other
      !> The clearance, unit of the comparison.
      real(wp), intent(in) :: clearance
      real(wp) :: off(4)

      coincide = .false.
      if (one%side /= other%side .or. (one%release .neqv. other%release)) return
      off = (one%middle - other%middle)/clearance
      off(one%n) = one%middle(one%n) - other%middle(one%n)
      off(one%n) = off(one%n) - two_pi*anint(off(one%n)/two_pi)
      coincide = all(abs(off) < 1.0e-6_wp)
   end function coincide

end module vi_attractor_known
