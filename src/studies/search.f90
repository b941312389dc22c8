!> All exact motions of one pattern that a spread of guesses leads to.
!!
!! A guess is a set of phases from a low-discrepancy sequence, with positions and tau from the
!! paper's linear problem for these phases. Newton's method is repelled by the motions found before,
!! so that each further success is another motion.
module vi_search
   use vi_exact, only: setting_type, solve_exact
   use vi_kinds, only: wp
   use vi_motion, only: motion_type
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
      real(wp), dimension(size(found, 1)/2) :: phases, x, theta
      integer :: i, n, iterations, first

      n = size(phases)
      first = 0
      if (present(skip)) first = skip
      n_found = 0
      tried = 0
      found = 0
      do i = 1, guesses
         if (n_found == size(found, 2)) return
         phases = spread_phases(first + i, n)*two_pi*setting%pattern%cycles
         call solve_periodic(setting%osc, setting%r, setting%pattern, setting%restitution, phases, &
            system, motion)
         if (motion%status /= stat%ok) cycle
         tried = tried + 1
         x = motion%x*setting%clearance/motion%clearance
         theta = phases + motion%tau
         call solve_exact(setting, x, theta, most_iterations, found(:, :n_found), motion, &
            iterations)
         if (motion%status /= stat%ok) cycle
         n_found = n_found + 1
         found(:, n_found) = [x, theta]
      end do
   end subroutine search_pattern

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
