!> The exact motions of one pattern that Newton's method finds from a spread of guesses.
!!
!! A guess is a set of phases from a low-discrepancy sequence, with positions and tau from the
!! paper's linear problem for these phases. Newton's method is repelled by the motions already
!! found, so that each further success is another motion.
module vi_search
   use vi_exact, only: deflation, exact_acceptance, step_share
   use vi_kinds, only: two_pi, wp
   use vi_linear, only: eliminate, most
   use vi_motion, only: motion_type
   use vi_orbit, only: by_left, by_r, by_right, family_type, orbit_residual, orbit_slopes, &
      orbit_type, oscillator_of, set_orbit
   use vi_pattern, only: default_restitution, pattern_type
   use vi_periodic, only: linear_system_type, solve_periodic
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: search_pattern

   integer, parameter :: most_iterations = 40
   !> Load phase of a flight so short that no iteration with a shorter one was seen to succeed.
   real(wp), parameter :: shortest_flight = 1.0e-4_wp
   !> Impacts closer than this in load phase count as simultaneous.
   real(wp), parameter :: at_once = 1.0e-6_wp

contains

   !> Exact motions of a pattern from a number of guesses.
   pure subroutine search_pattern(pattern, c, guesses, found, n_found, tried, skip)
      !> Sides of the N impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> Number of guesses to start from.
      integer, intent(in) :: guesses
      !> Unknowns (x_i/D, theta_i) of motions (2N, capacity): those known beforehand, then those
      !! found; the search ends when it is full.
      real(wp), intent(inout) :: found(:, :)
      !> In: number of motions known beforehand. Out: number of all motions.
      integer, intent(inout) :: n_found
      !> Number of Newton iterations that were started.
      integer, intent(out) :: tried
      !> Number of guesses of the sequence to leave out; neighbouring points take different ones.
      integer, intent(in) :: skip
      type(linear_system_type) :: system
      type(motion_type) :: motion
      type(family_type) :: family
      real(wp) :: phases(size(found, 1)/2), restitution(size(found, 1)/2), unknowns(size(found, 1))
      real(wp) :: golden
      integer :: i, n
      logical :: good

      n = size(phases)
      family%sides = pattern%sides
      family%cycles = pattern%cycles
      restitution = default_restitution(pattern%sides, c(by_right), c(by_left))
      golden = golden_ratio(n)
      tried = 0
      do i = 1, guesses
         if (n_found == size(found, 2)) return
         phases = spread_phases(skip + i, n, golden)*two_pi*pattern%cycles
         call solve_periodic(oscillator_of(c), c(by_r), pattern, restitution, phases, system, &
            motion)
         if (motion%status /= stat%ok) cycle
         tried = tried + 1
         unknowns = [motion%x/motion%clearance, phases + motion%tau]
         call iterate(family, c, found(:, :n_found), unknowns, good)
         if (.not. good) cycle
         n_found = n_found + 1
         found(:, n_found) = unknowns
      end do
   end subroutine search_pattern

   !> Newton's method from a guess, repelled by known motions.
   pure subroutine iterate(family, c, known, unknowns, good)
      !> The family of all motions of the pattern.
      type(family_type), intent(in) :: family
      !> r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> (2N, m) Unknowns of known motions, which repel the iteration.
      real(wp), intent(in) :: known(:, :)
      !> In: the guess (2N). Out: the motion.
      real(wp), intent(inout) :: unknowns(:)
      !> Whether the iteration converged to a motion with impacts at distinct times.
      logical, intent(out) :: good
      type(orbit_type) :: o
      real(wp) :: a(most, most), b(2, most), step(size(unknowns)), share, unused
      integer :: i, n
      logical :: last, regular

      n = size(unknowns)
      good = .false.
      last = .false.
      do i = 1, most_iterations
         call set_orbit(family, unknowns, c, o)
         if (any(o%time(1:o%n)*o%r < shortest_flight)) return
         call orbit_slopes(o, a, b(1, :n))
         b(2, :n) = 0
         call eliminate(n, a, b, regular, unused)
         if (.not. regular) return
         step = -b(1, :n)
         if (.not. all(abs(step) <= huge(1.0_wp))) return
         if (.not. last) step = step*deflation(unknowns, step, known, 1.0_wp)
         share = step_share(family%cycles, unknowns, step)
         if (share < 1.0e-6_wp) return
         unknowns = unknowns + share*step
         if (last) exit
         ! quadratic convergence: after a step of 1e-7 the next one ends at rounding
         last = maxval(abs(step)) < 1.0e-7_wp
      end do
      if (i > most_iterations) return
      call set_orbit(family, unknowns, c, o)
      good = norm2(orbit_residual(o)) < exact_acceptance*max(1.0_wp, &
         maxval(abs(o%after(1:o%n))), maxval(abs(o%speed(1:o%n))))
      ! two impacts on one wall at one instant also solve the equations
      good = good .and. all(o%time(1:o%n)*o%r > at_once)
   end subroutine iterate

   !> The generalised golden ratio of n phases: the root of x**n = 1 + x.
   pure real(wp) function golden_ratio(n) result(golden)
      !> Number of phases.
      integer, intent(in) :: n
      integer :: j

      golden = 1.5_wp
      do j = 1, 30
         golden = (1 + golden)**(1.0_wp/n)
      end do
   end function golden_ratio

   !> Phases of one guess over the period: 0, then increasing numbers below 1.
   !!
   !! An additive recurrence with the powers of the generalised golden ratio fills the simplex
   !! evenly.
   pure function spread_phases(i, n, golden) result(phases)
      !> Number of the guess, and phases.
      integer, intent(in) :: i, n
      !> `golden_ratio` of n, which takes longer to compute than the rest.
      real(wp), intent(in) :: golden
      real(wp) :: phases(n)
      real(wp) :: item
      integer :: j, k

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
