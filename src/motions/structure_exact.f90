!> Exact periodic motions of a structure: Newton's method on the impact times, the approach speeds
!! and the offsets of pairs of frequency 0, all derivatives in closed form.
module vi_structure_exact
   use vi_exact, only: exact_acceptance
   use vi_kinds, only: wp
   use vi_lapack, only: solve
   use vi_status, only: stat
   use vi_structure, only: regime_type, structure_type
   use vi_structure_motion, only: equations_type, new_equations, relative, residuals, since
   implicit none (type, external)
   private

   public :: solve_structure_exact

   !> A step that is negligible, one below which rounding may be reached, and relative residuals
   !! that
   !! are due to rounding.
   real(wp), parameter :: negligible = 16*epsilon(1.0_wp), small = 1.0e-7_wp, &
      at_rounding = 64*epsilon(1.0_wp)
   !> Impacts nearer to each other, relative to the period, are at one instant.
   real(wp), parameter, public :: instant = 1.0e-12_wp

contains

   !> Newton's method from a guess.
   !!
   !! A step changes no flight by more than half of its duration. It ends after a negligible step,
   !! or
   !! once steps are small and no longer shrink: then rounding is reached.
   pure subroutine solve_structure_exact(structure, regime, gaps, times, period, speeds, offsets, &
      most, residual, steps, status)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Its regime without resting gaps.
      type(regime_type), intent(in) :: regime
      !> (N) The gaps of the impacts.
      integer, intent(in) :: gaps(:)
      !> (N) In: guess of the times of the impacts, in ascending order. Out: the last iterate.
      real(wp), intent(inout) :: times(:)
      !> The period.
      real(wp), intent(in) :: period
      !> (N) Approach speeds and (p) offsets, likewise.
      real(wp), intent(inout) :: speeds(:), offsets(:)
      !> Most steps.
      integer, intent(in) :: most
      !> The largest residual, over the sum of the absolute terms of its equation.
      real(wp), intent(out) :: residual
      !> Number of steps made.
      integer, intent(out) :: steps
      !> `stat%ok`, `stat%no_convergence`, `stat%singular`, `stat%resonance`, `stat%not_finite`.
      integer, intent(out) :: status
      type(equations_type) :: equations
      real(wp), dimension(2*size(times) + size(offsets)) :: value, scale, step
      real(wp), dimension(2*size(times) + size(offsets), 2*size(times) + size(offsets)) :: jacobian
      real(wp) :: change, before, share, flight, closing
      integer :: i, n, next

      n = size(times)
      before = huge(1.0_wp)
      do steps = 0, most
         call new_equations(structure, regime, gaps, times, period, equations, status)
         if (status /= stat%ok) return
         call residuals(structure, equations, speeds, offsets, value, scale, jacobian)
         residual = relative(value, scale)
         if (.not. residual <= huge(1.0_wp)) then
            status = stat%not_finite
            return
         end if
         call scaled_solve(jacobian, value, scale, step, status)
         if (status == stat%singular .and. residual <= exact_acceptance) then
            ! a motion at a fold or a pitchfork
            status = stat%ok
            return
         end if
         if (status /= stat%ok) return
         share = 1
         do i = 1, n
            next = modulo(i, n) + 1
            flight = since(times, period, next, i)
            closing = step(i) - step(next)
            ! impacts at one instant keep their order
            if (n > 1 .and. closing > 0.5_wp*flight .and. flight > instant*period) then
               share = min(share, 0.5_wp*flight/closing)
            end if
         end do
         step = share*step
         change = maxval(abs(step(:n)))/period
         if (maxval(abs(speeds)) > 0) change = max(change, maxval(abs(step(n + 1:2*n)))/ &
            maxval(abs(speeds)))
         ! near a fold or a pitchfork rounding alone gives such a step
         if (residual <= at_rounding .and. change > small) exit
         times = times + step(:n)
         speeds = speeds + step(n + 1:2*n)
         offsets = offsets + step(2*n + 1:)
         if (share < 1) then
            before = huge(1.0_wp)
            cycle
         end if
         if (change <= negligible) exit
         if ((change <= small .or. residual <= at_rounding) .and. change >= before) exit
         before = change
      end do
      ! a step from a poor guess can exchange impacts that nearly coincide: that is no motion
      if (steps > most .or. any(times(2:) - times(:n - 1) < -instant*period) .or. &
         times(n) - times(1) > (1 + instant)*period) then
         status = stat%no_convergence
         return
      end if
      do i = 2, n
         ! impacts at one instant keep their order in spite of rounding
         if (times(i) - times(i - 1) > instant*period) cycle
         if (abs(dot_product(structure%directions(:, gaps(i)), structure%mobility(:, &
            gaps(i - 1)))) <= 0) times(i) = times(i - 1)
      end do
      call new_equations(structure, regime, gaps, times, period, equations, status)
      if (status /= stat%ok) return
      call residuals(structure, equations, speeds, offsets, value, scale)
      residual = relative(value, scale)
   end subroutine solve_structure_exact

   !> The Newton step, with equations and unknowns scaled to size 1.
   pure subroutine scaled_solve(jacobian, value, scale, step, status)
      !> The Jacobian.
      real(wp), intent(in) :: jacobian(:, :)
      !> The residuals, and their scales.
      real(wp), intent(in) :: value(:), scale(:)
      !> The step.
      real(wp), intent(out) :: step(:)
      !> `stat%ok` or `stat%singular`.
      integer, intent(out) :: status
      real(wp), allocatable :: a(:, :), b(:)
      real(wp) :: columns(size(value))
      integer :: i, j

      allocate (a, source=jacobian)
      allocate (b(size(value)))
      b = -value
      do i = 1, size(value)
         if (.not. scale(i) > 0) cycle
         a(i, :) = a(i, :)/scale(i)
         b(i) = b(i)/scale(i)
      end do
      do j = 1, size(value)
         columns(j) = maxval(abs(a(:, j)))
         if (columns(j) > 0) a(:, j) = a(:, j)/columns(j)
      end do
      call solve(a, b, status)
      step = 0
      if (status == stat%ok) step = b/columns
   end subroutine scaled_solve

end module vi_structure_exact
