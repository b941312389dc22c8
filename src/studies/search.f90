!> All exact motions of one pattern that a spread of guesses leads to.
!!
!! A guess is a set of phases from a low-discrepancy sequence, with positions and tau from the
!! paper's linear problem for these phases. Newton's method is repelled by the motions found before,
!! so that each further success is another motion.
module vi_search
   use vi_exact, only: deflation, setting_type, solve_exact, step_share
   use vi_kinds, only: wp
   use vi_linear, only: eliminate, most
   use vi_motion, only: motion_type
   use vi_orbit, only: family_type, most_impacts, n_parameters, orbit_slopes, orbit_type, set_orbit
   use vi_oscillator, only: left, right
   use vi_periodic, only: linear_system_type, solve_periodic
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: search_pattern

   real(wp), parameter :: two_pi = 2*acos(-1.0_wp)
   integer, parameter :: most_iterations = 40

contains

   !> Exact motions of a pattern from a number of guesses.
   pure subroutine search_pattern(setting, guesses, found, n_found, tried, skip)
      type(setting_type), intent(in) :: setting
      !> Guesses to start from.
      integer, intent(in) :: guesses
      !> Unknowns (x_i, theta_i) of the motions found (2N, room); the search ends when it is full.
      real(wp), intent(out) :: found(:, :)
      integer, intent(out) :: n_found
      !> Newton iterations that were started.
      integer, intent(out) :: tried
      !> Guesses of the sequence to leave out, at neighbouring points others each time.
      integer, intent(in), optional :: skip
      type(linear_system_type) :: system
      type(motion_type) :: motion
      type(family_type) :: family
      real(wp), dimension(size(found, 1)/2) :: phases, x, theta
      real(wp) :: known(size(found, 1), size(found, 2)), unknowns(size(found, 1)), c(n_parameters)
      logical :: on_orbits, good
      integer :: i, n, iterations, first

      n = size(phases)
      first = 0
      if (present(skip)) first = skip
      n_found = 0
      tried = 0
      found = 0
      associate (sides => setting%pattern%sides, walls => setting%osc%restitution)
         on_orbits = setting%load > 0 .and. n <= most_impacts .and. &
            all(abs(setting%restitution - walls(merge(right, left, sides > 0))) <= 0)
         if (on_orbits) then
            family%sides = sides
            family%cycles = setting%pattern%cycles
            c = [setting%r, log(setting%clearance/setting%load), setting%osc%xi, setting%osc%mu, &
               walls(right), walls(left)]
         end if
      end associate
      do i = 1, guesses
         if (n_found == size(found, 2)) return
         phases = spread_phases(first + i, n)*two_pi*setting%pattern%cycles
         call solve_periodic(setting%osc, setting%r, setting%pattern, setting%restitution, phases, &
            system, motion)
         if (motion%status /= stat%ok) cycle
         tried = tried + 1
         x = motion%x*setting%clearance/motion%clearance
         theta = phases + motion%tau
         if (on_orbits) then
            unknowns = [x/setting%clearance, theta]
            call approach(setting, family, c, unknowns, known(:, :n_found), good)
            if (.not. good) cycle
            x = unknowns(:n)*setting%clearance
            theta = unknowns(n + 1:)
            call solve_exact(setting, x, theta, most_iterations, found(:, :0), motion, iterations)
         else
            call solve_exact(setting, x, theta, most_iterations, found(:, :n_found), motion, &
               iterations)
         end if
         if (motion%status /= stat%ok) cycle
         n_found = n_found + 1
         found(:, n_found) = [x, theta]
         known(:, n_found) = [x/setting%clearance, theta]
      end do
   end subroutine search_pattern

   !> Newton's method on the equations of vi_orbit, which are evaluated faster than those of
   !> vi_exact: near enough to a motion that the steps shrink quadratically.
   pure subroutine approach(setting, family, c, unknowns, known, good)
      type(setting_type), intent(in) :: setting
      type(family_type), intent(in) :: family
      !> (6) r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> (2N) x_i/D and theta_i. In: a guess.
      real(wp), intent(inout) :: unknowns(:)
      !> (2N, m) motions that repel the iteration.
      real(wp), intent(in) :: known(:, :)
      logical, intent(out) :: good
      type(orbit_type) :: o
      real(wp) :: a(most, most), b(2, most), step(size(unknowns)), residual, share
      integer :: i, n

      n = size(unknowns)
      good = .false.
      do i = 1, most_iterations
         call set_orbit(family, unknowns, c, o)
         b(2, :n) = 0
         call orbit_slopes(o, a, b(1, :n))
         call eliminate(n, a, b, good, residual)
         if (.not. good) return
         step = -b(1, :n)
         good = all(abs(step) <= huge(1.0_wp))
         if (.not. good) return
         step = step*deflation(unknowns, step, known, 1.0_wp)
         share = step_share(setting, unknowns, step)
         good = .false.
         if (share < 1.0e-6_wp) return
         unknowns = unknowns + share*step
         good = maxval(abs(step)) < 1.0e-7_wp
         if (good) return
      end do
   end subroutine approach

   !> Phases of one guess over the period: 0, then increasing numbers below 1.
   !!
   !! An additive recurrence with the powers of the generalised golden ratio fills the simplex
   !! evenly.
   pure function spread_phases(i, n) result(phases)
      integer, intent(in) :: i, n
      real(wp) :: phases(n)
      real(wp) :: golden, item
      integer :: j, k

      golden = 1.5_wp
      do j = 1, 30
         golden = (1 + golden)**(1.0_wp/n)
      end do
      phases(1) = 0
      do j = 2, n
         item = modulo(0.5_wp + i/golden**(j - 1), 1.0_wp)
         k = j
         do while (k > 2)
            if (phases(k - 1) <= item) exit
            phases(k) = phases(k - 1)
            k = k - 1
         end do
         phases(k) = item
      end do
   end function spread_phases

end module vi_search
