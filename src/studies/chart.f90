!> Charts: the motions of one pattern on a grid of frequency ratios and clearances.
!!
!! Results have a column for each r, and in it a place for each clearance and each slot. Every column
!! or point is one task that writes to its own place: the answer is the same to the last bit for any
!! number of threads.
module vi_chart
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_equispaced_row, only: new_row, row_pair, row_type, summary_type
   use vi_kinds, only: wp
   use vi_oscillator, only: oscillator_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: equispaced_chart

contains

   !> Both equispaced motions at every point of a grid; a slot holds one of them throughout.
   subroutine equispaced_chart(osc, r, clearance, cycles, with_multipliers, threads, scalars, &
      multipliers, verdicts, status)
      !> Its two coefficients of restitution are equal, and `cycles` is odd.
      type(oscillator_type), intent(in) :: osc
      !> (n), (m)
      real(wp), intent(in) :: r(:), clearance(:)
      integer, intent(in) :: cycles
      !> Whether the multipliers are wanted, or only the verdict on them; they cost the most.
      logical, intent(in) :: with_multipliers
      integer, intent(in) :: threads
      !> (4, 2, m, n): x_1, tau, x_min, x_max
      real(wp), intent(out) :: scalars(:, :, :, :)
      !> (4, 2, m, n), by falling modulus
      complex(wp), intent(out) :: multipliers(:, :, :, :)
      !> (3, 2, m, n): consistent, admissible, stable
      integer, intent(out) :: verdicts(:, :, :, :)
      !> (2, m, n)
      integer, intent(out) :: status(:, :, :)
      type(row_type) :: row
      type(summary_type) :: pair(2)
      integer :: i, j, k

      !$omp parallel do schedule(dynamic, 1) num_threads(threads) private(row, pair, i, j)
      do k = 1, size(r)
         call new_row(osc, r(k), cycles, row)
         do j = 1, size(clearance)
            call row_pair(row, clearance(j), with_multipliers, pair)
            do i = 1, 2
               call store(pair(i), scalars(:, i, j, k), multipliers(:, i, j, k), &
                  verdicts(:, i, j, k), status(i, j, k))
            end do
         end do
      end do
      !$omp end parallel do
   end subroutine equispaced_chart

   !> Writes one motion into its place.
   pure subroutine store(summary, scalars, multipliers, verdicts, status)
      type(summary_type), intent(in) :: summary
      real(wp), intent(out) :: scalars(:)
      complex(wp), intent(out) :: multipliers(:)
      integer, intent(out) :: verdicts(:), status
      real(wp) :: nan

      status = summary%status
      verdicts = [summary%consistent, summary%admissible, summary%stable]
      if (status == stat%ok) then
         scalars = [summary%x, summary%tau, summary%x_min, summary%x_max]
         multipliers = summary%multipliers
      else
         nan = ieee_value(1.0_wp, ieee_quiet_nan)
         scalars = nan
         multipliers = cmplx(nan, nan, wp)
      end if
   end subroutine store

end module vi_chart
