!> Impulses where several coupled gaps close at one instant, by Newton's law at all of them at once.
!!
!! With A = G^T M^-1 G of the closed gaps, speeds v = G^T q' at which they close, and impulses p,
!! the speeds after the impact are w = v - A p, and Newton's law of restitution is, in the form of
!! J. J. Moreau (Unilateral contact and dry friction in finite freedom dynamics, 1988) and
!! C. Glocker (Set-valued force laws, 2001),
!!
!!     p >= 0,   w + R v <= 0,   p.(w + R v) = 0
!!
!! A gap without an impulse may open faster than by R. These are the conditions of the least p.A.p/2
!! - (1 + R) v.p over p >= 0, which the method of C. L. Lawson and R. J. Hanson (Solving least
!! squares problems, 1974, chapter 23) finds by exchange of the gaps with an impulse.
module vi_simultaneous
   use vi_columns, only: solve_columns
   use vi_kinds, only: wp
   use vi_status, only: stat
   use vi_structure, only: restitution_of, structure_type
   implicit none (type, external)
   private

   public :: newton_impulses

contains

   !> The impulses at closed gaps.
   pure subroutine newton_impulses(structure, gaps, speeds, rounding, impulses, status)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> (k) The closed gaps.
      integer, intent(in) :: gaps(:)
      !> (k) The speeds at which they close, and those that are rounding.
      real(wp), intent(in) :: speeds(:), rounding(:)
      !> (k) The impulses, >= 0.
      real(wp), intent(out) :: impulses(:)
      !> `stat%ok`, `stat%dependent_rests` where the impulses are not determined, or
      !! `stat%gains_energy` where gaps with different R would add energy.
      integer, intent(out) :: status
      !> Share of an energy that is rounding, and of a speed that a solution must give.
      real(wp), parameter :: share = 1.0e-12_wp, solved = 1.0e-8_wp
      real(wp), dimension(size(gaps)) :: wanted, excess, trial, after
      real(wp) :: matrix(size(gaps), size(gaps)), restitution, slope, way
      integer, allocatable :: active(:)
      logical :: pushes(size(gaps))
      integer :: i, j, next, round

      do i = 1, size(gaps)
         do j = 1, size(gaps)
            matrix(j, i) = dot_product(structure%directions(:, gaps(j)), &
               structure%mobility(:, gaps(i)))
         end do
         call restitution_of(structure, gaps(i), max(speeds(i), 0.0_wp), restitution, slope)
         wanted(i) = (1 + restitution)*speeds(i)
      end do
      impulses = 0
      pushes = .false.
      status = stat%ok
      do round = 1, 100*size(gaps)
         excess = wanted - matmul(matrix, impulses)
         next = maxloc(excess - rounding, 1, .not. pushes)
         if (next == 0) exit
         if (.not. excess(next) > rounding(next)) exit
         pushes(next) = .true.
         do
            active = pack([(i, i=1, size(gaps))], pushes)
            if (size(active) == 0) exit
            call solve_active(matrix, wanted, active, trial, status)
            if (status /= stat%ok) return
            if (any(abs(wanted(active) - matmul(matrix(active, active), trial(active))) > &
               solved*maxval(abs(wanted)))) status = stat%dependent_rests
            if (status /= stat%ok) return
            if (all(trial(active) > 0)) exit
            ! as far as all impulses stay >= 0
            way = 1
            do i = 1, size(active)
               associate (here => impulses(active(i)), there => trial(active(i)))
                  if (.not. there > 0) way = min(way, here/(here - there))
               end associate
            end do
            impulses(active) = impulses(active) + way*(trial(active) - impulses(active))
            where (.not. trial > 0 .and. .not. impulses > epsilon(1.0_wp)*maxval(impulses))
               pushes = .false.
               impulses = 0
            end where
            if (count(pushes) == size(active)) then
               ! rounding: the one nearest to 0
               i = active(minloc(impulses(active), 1, .not. trial(active) > 0))
               pushes(i) = .false.
               impulses(i) = 0
            end if
         end do
         impulses = 0
         if (size(active) > 0) impulses(active) = trial(active)
      end do
      ! the change of energy is -p.(v + w)/2
      after = speeds - matmul(matrix, impulses)
      if (dot_product(impulses, speeds + after) < -share*dot_product(impulses, abs(speeds) &
         + abs(after))) status = stat%gains_energy
   end subroutine newton_impulses

   !> Impulses at some of the gaps for which these have no excess.
   pure subroutine solve_active(matrix, wanted, active, impulses, status)
      !> (k, k) A, and (k) (1 + R) v.
      real(wp), intent(in) :: matrix(:, :), wanted(:)
      !> The gaps.
      integer, intent(in) :: active(:)
      !> (k) The impulses; 0 of the others.
      real(wp), intent(out) :: impulses(:)
      !> `stat%ok` or `stat%dependent_rests`.
      integer, intent(out) :: status
      real(wp) :: right(size(active), 1)

      right(:, 1) = wanted(active)
      impulses = 0
      call solve_columns(matrix(active, active), right, status)
      if (status /= stat%ok) status = stat%dependent_rests
      if (status == stat%ok) impulses(active) = right(:, 1)
   end subroutine solve_active

end module vi_simultaneous
