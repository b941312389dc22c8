!> Periodic motions in which impacts accumulate and the free mass comes to rest on a wall.
!!
!! A motion is a fixed point of the map from one release to the release k load cycles later, a map
!! of the plane (phase, v). Its two eigenvalues and two zeros, which the accumulation brings, are
!! the multipliers. What a simulation does in a period gives the letters; the map along these
!! letters (vi_rest_family) is smooth where the simulated one is not, and its derivative is known
!! in closed form. A solution counts if the simulation from it comes back to it.
module vi_rest_motion
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_assess, only: plane_stability
   use vi_event_letters, only: read_letters, reading_type, total_phase
   use vi_kinds, only: wp
   use vi_lapack, only: eigenvalues, solve
   use vi_motion, only: unknown
   use vi_orbit, only: by_clearance, by_left, by_mu, by_r, by_right, by_xi, most_impacts, &
      n_parameters
   use vi_oscillator, only: left, right
   use vi_rest_family, only: new_rest_family, plane_map, rest_family_type, rest_period, &
      rest_period_type
   use vi_simulate, only: drive_type, event_type, impact_event, release_event, simulate, &
      state_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: release_state, return_map, solve_rest_motion

   real(wp), parameter :: two_pi = 2*acos(-1.0_wp)

contains

   !> From one release on a wall to the release k load cycles later.
   pure subroutine return_map(drive, side, cycles, start, finish, events, n, status)
      type(drive_type), intent(in) :: drive
      !> The wall, +1 or -1, and the load cycles k.
      integer, intent(in) :: side, cycles
      !> (phase, v) at the release; `finish` has the phase less 2 pi k.
      real(wp), intent(in) :: start(2)
      real(wp), intent(out) :: finish(2)
      !> Events of the period, the last one the release; room for one more period is needed.
      type(event_type), intent(inout) :: events(:)
      integer, intent(out) :: n
      !> `stat%ok`, or `stat%no_motion` if there is no release near that time.
      integer, intent(out) :: status
      type(state_type) :: state, final
      real(wp) :: lapse, nearest, horizon
      integer :: i, found

      finish = 0
      n = 0
      ! most releases come back at once: what is farther ahead than one that is found is not nearer
      horizon = 0.1_wp
      do while (n == 0)
         state = release_state(drive, side, start)
         call simulate(drive, state, int(cycles, int64), start(1) + horizon, events, found, final, &
            status)
         if (status /= stat%ok) return
         nearest = horizon
         do i = 1, found
            if (events(i)%kind /= release_event .or. events(i)%side /= side) cycle
            lapse = two_pi*real(events(i)%cycle - cycles, wp) + events(i)%phase - start(1)
            if (abs(lapse) >= nearest) cycle
            nearest = abs(lapse)
            n = i
            finish = [start(1) + lapse, events(i)%x_dot_after]
         end do
         if (horizon > 1) exit
         horizon = 0.5_wp*two_pi
      end do
      if (n == 0) status = stat%no_motion
   end subroutine return_map

   !> The state at a release. The phase may lie a little outside [0, 2 pi).
   pure function release_state(drive, side, start) result(state)
      type(drive_type), intent(in) :: drive
      !> The wall, +1 or -1.
      integer, intent(in) :: side
      !> (phase, v)
      real(wp), intent(in) :: start(2)
      type(state_type) :: state

      state%phase = start(1)
      state%x_dot = start(2)
      state%z_dot = start(2)
      state%x = drive%load*sin(start(1)) - 2*drive%osc%xi*start(2)
      state%z = state%x + 0.5_wp*side*drive%clearance
      state%side = side
      state%released = .true.
   end function release_state

   !> Newton's method for a fixed point of the return map.
   pure subroutine solve_rest_motion(drive, side, cycles, point, lambda, residual, events, n, &
      status, stable)
      type(drive_type), intent(in) :: drive
      !> The wall, +1 or -1, and the load cycles k.
      integer, intent(in) :: side, cycles
      !> In: a guess of (phase, v) at the release. Out: the fixed point.
      real(wp), intent(inout) :: point(2)
      !> Multipliers by falling modulus, the last two 0.
      complex(wp), intent(out) :: lambda(4)
      !> Greatest change of phase and v/D over a simulated period.
      real(wp), intent(out) :: residual
      !> Events of the period (n of them), the last one the release.
      type(event_type), intent(inout) :: events(:)
      integer, intent(out) :: n
      !> `stat%ok`, `stat%no_motion`, `stat%no_convergence`, or what the simulation says.
      integer, intent(out) :: status
      !> The verdict: `yes`, `no` or `unknown` of vi_motion.
      integer, intent(out), optional :: stable
      !> Newton steps in all, and times that letters are held.
      integer, parameter :: most = 40, most_rounds = 4
      !> A simulated period that changes the state by less holds the letters of the motion.
      real(wp), parameter :: close_by = 0.02_wp
      type(rest_family_type) :: family
      type(rest_period_type) :: period
      real(wp), allocatable :: unknowns(:)
      real(wp) :: c(n_parameters), matrix(2, 2), step(2), image(2)
      complex(wp) :: pair(2)
      logical :: good
      integer :: i, rounds

      lambda = 0
      n = 0
      if (present(stable)) stable = unknown
      residual = huge(1.0_wp)
      status = stat%no_motion
      if (.not. drive%load > 0) return
      c([by_r, by_clearance, by_xi, by_mu, by_right, by_left]) = [drive%r, &
         log(drive%clearance/drive%load), drive%osc%xi, drive%osc%mu, &
         drive%osc%restitution([right, left])]
      rounds = 0
      do i = 1, most
         call simulate_period(drive, side, cycles, point, image, residual, events, n, family, &
            unknowns, status)
         if (status /= stat%ok) return
         if (rounds > 0 .and. residual < 1.0e-11_wp) exit
         if (residual < close_by .and. rounds < most_rounds) then
            rounds = rounds + 1
            call hold_letters(family, c, unknowns, good)
            if (good) then
               point = [unknowns(1), sinh(unknowns(2))*drive%clearance]
               cycle
            end if
         end if
         call rest_period(family, unknowns, c, period)
         status = stat%no_convergence
         if (.not. period%right) return
         matrix = -plane_map(period)
         matrix(1, 1) = matrix(1, 1) + 1
         matrix(2, 2) = matrix(2, 2) + 1
         step = [image(1), asinh(image(2)/drive%clearance)] - unknowns(:2)
         call solve(matrix, step, status)
         if (status /= stat%ok) return
         step = unknowns(:2) + step*min(1.0_wp, 0.3_wp/maxval(abs(step)))
         point = [step(1), sinh(step(2))*drive%clearance]
      end do
      status = merge(stat%ok, stat%no_convergence, residual < 1.0e-10_wp)
      if (status /= stat%ok) return
      point(1) = modulo(point(1), two_pi)
      call simulate_period(drive, side, cycles, point, image, residual, events, n, family, &
         unknowns, status)
      if (status /= stat%ok) return
      status = stat%no_convergence
      call rest_period(family, unknowns, c, period)
      if (.not. period%right) return
      matrix = plane_map(period)
      if (present(stable)) stable = plane_stability(matrix)
      call eigenvalues(matrix, pair, status)
      if (abs(pair(2)) > abs(pair(1))) pair = pair([2, 1])
      lambda(:2) = pair
   end subroutine solve_rest_motion

   !> A simulated period: where it ends, its events, letters and unknowns.
   pure subroutine simulate_period(drive, side, cycles, point, image, residual, events, n, family, &
      unknowns, status)
      type(drive_type), intent(in) :: drive
      !> The wall, +1 or -1, and the load cycles k.
      integer, intent(in) :: side, cycles
      !> (phase, v) at the release, and at the release k load cycles later.
      real(wp), intent(in) :: point(2)
      real(wp), intent(out) :: image(2)
      !> Greatest change of phase and v/D.
      real(wp), intent(out) :: residual
      type(event_type), intent(inout) :: events(:)
      integer, intent(out) :: n
      type(rest_family_type), intent(out) :: family
      real(wp), allocatable, intent(out) :: unknowns(:)
      !> `stat%ok`, `stat%no_motion`, or what the simulation says.
      integer, intent(out) :: status
      logical :: good

      residual = huge(1.0_wp)
      call return_map(drive, side, cycles, point, image, events, n, status)
      if (status /= stat%ok) return
      residual = maxval(abs(image - point)/[1.0_wp, drive%clearance])
      call read_period(events(:n), cycles, [point(1), asinh(point(2)/drive%clearance)], family, &
         unknowns, good)
      if (.not. good) status = stat%no_motion
   end subroutine simulate_period

   !> Newton's method along given letters.
   pure subroutine hold_letters(family, c, unknowns, good)
      type(rest_family_type), intent(in) :: family
      !> r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> Those of vi_rest_family; as they were if it does not converge.
      real(wp), intent(inout) :: unknowns(:)
      logical, intent(out) :: good
      integer, parameter :: most = 12
      type(rest_period_type) :: period
      real(wp) :: matrix(size(unknowns), size(unknowns)), step(size(unknowns)), moved, before
      real(wp) :: here(size(unknowns))
      integer :: i, j, status

      here = unknowns
      moved = huge(1.0_wp)
      good = .false.
      do i = 1, most
         call rest_period(family, here, c, period)
         if (.not. period%right) return
         do j = 1, size(here)
            matrix(j, :) = -period%equations(j)%by(:size(here))
         end do
         step = period%equations%value
         call solve(matrix, step, status)
         if (status /= stat%ok) return
         before = moved
         moved = maxval(abs(step))
         if (.not. moved < 0.3_wp) return
         here = here + step
         ! the steps have come down to rounding
         good = moved < 1.0e-14_wp .or. (moved < 1.0e-9_wp .and. moved > 0.3_wp*before)
         if (good) exit
      end do
      if (good) unknowns = here
   end subroutine hold_letters

   !> The family whose letters the events of a period from a release to a release are, and the
   !! unknowns that go with them.
   pure subroutine read_period(events, cycles, start, family, unknowns, good)
      type(event_type), intent(in) :: events(:)
      integer, intent(in) :: cycles
      !> Phase and asinh(v/D) at the first release.
      real(wp), intent(in) :: start(2)
      type(rest_family_type), intent(out) :: family
      real(wp), allocatable, intent(out) :: unknowns(:)
      !> False if the last letter is none with rest, if a rest begins without an impact, or if
      !! there are too many letters.
      logical, intent(out) :: good
      type(reading_type) :: reading

      call read_letters(events, reading)
      good = reading%n > 1 .and. reading%n <= most_impacts
      ! the unknowns tell no rest from a start without impact
      if (good) good = abs(reading%letters(reading%n)) == 2 .and. &
         all(events(reading%first)%kind == impact_event)
      if (.not. good) return
      family = new_rest_family(reading%letters, cycles)
      unknowns = [start, total_phase(events(reading%first))]
   end subroutine read_period

end module vi_rest_motion
