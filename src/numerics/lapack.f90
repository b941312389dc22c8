!> The three LAPACK drivers of the reference path behind three plain procedures.
!!
!! For a small system that needs no scaling most of the time of xGELS and xGEEV goes into checks.
!! The routines that they call are therefore called here directly, in the same order. The results
!! are the same bit for bit and take a tenth less time.
!!
!! The 1983 computations used IMSL: LEQT1F (Gaussian elimination) is DGESV here, LLSQF (least
!! squares) is DGELS and EIGRF (Hessenberg and QR) is DGEEV.
module vi_lapack
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use vi_kinds, only: wp
   use vi_lapack_routines, only: gebal, geev, gehd2, gels, geqr2, gesv, getf2, getrs, &
      lahqr, orm2r, trtrs
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: solve, least_squares, least_squares_work, eigenvalues, eigenvector

   !> A diagonal entry of the triangular factor below this fraction of the largest one counts as
   !! zero.
   real(wp), parameter :: rank_tolerance = 16*epsilon(1.0_wp)
   !> Most unknowns of a small system, and limits on entries that need no scaling.
   integer, parameter :: small = 24
   real(wp), parameter :: largest_entry = sqrt(huge(1.0_wp))*epsilon(1.0_wp), &
      smallest_entry = 1/largest_entry

contains

   !> Solves the square system a x = b by Gaussian elimination (xGESV).
   pure subroutine solve(a, b, status, pivots)
      !> In: the matrix (n, n). Out: its LU factors.
      real(wp), intent(inout), contiguous :: a(:, :)
      !> In: the right side (n). Out: the solution.
      real(wp), intent(inout), contiguous :: b(:)
      !> `stat%ok`, or `stat%singular` where the matrix does not have full rank.
      integer, intent(out) :: status
      !> Smallest and largest diagonal entry of the triangular factor in modulus.
      real(wp), intent(out), optional :: pivots(2)
      integer :: n, info, pivot(small)
      integer, allocatable :: long_pivot(:)

      n = size(b)
      if (n <= small) then
         call getf2(n, n, a, n, pivot, info)
         if (info == 0) call getrs('N', n, 1, a, n, pivot, b, n, info)
      else
         allocate (long_pivot(n))
         call gesv(n, 1, a, n, long_pivot, b, n, info)
      end if
      call judge_rank(a, n, info, status, pivots)
   end subroutine solve

   !> The length of the work array that `least_squares` wants for m equations in n unknowns.
   pure integer function least_squares_work(m, n) result(length)
      !> Number of equations and of unknowns.
      integer, intent(in) :: m, n
      !> Columns that LAPACK's blocked QR treats together; small systems are not blocked at all.
      integer, parameter :: block = 32

      length = min(m, n) + max(m, n)*block
   end function least_squares_work

   !> Minimises the 2-norm of a x - b (xGELS, QR with Householder reflections).
   pure subroutine least_squares(a, b, work, residual, status, pivots)
      !> In: the matrix (m, n), m >= n. Out: its QR factors.
      real(wp), intent(inout), contiguous :: a(:, :)
      !> In: the right side (m). Out: the solution in 1..n.
      real(wp), intent(inout), contiguous :: b(:)
      !> Scratch of at least `least_squares_work(m, n)` numbers.
      real(wp), intent(inout), contiguous :: work(:)
      !> The 2-norm of a x - b.
      real(wp), intent(out) :: residual
      !> `stat%ok`, or `stat%singular` where the matrix does not have full rank.
      integer, intent(out) :: status
      !> Smallest and largest diagonal entry of the triangular factor in modulus.
      real(wp), intent(out), optional :: pivots(2)
      real(wp) :: tau(small)
      integer :: m, n, info

      m = size(a, 1)
      n = size(a, 2)
      if (n <= small .and. well_scaled(maxval(abs(a))) .and. well_scaled(maxval(abs(b)))) then
         call geqr2(m, n, a, m, tau, work, info)
         call orm2r('L', 'T', m, 1, n, a, m, tau, b, m, work, info)
         call trtrs('U', 'N', 'N', n, 1, a, m, b, m, info)
      else
         call gels('N', m, n, 1, a, m, b, m, work, size(work), info)
      end if
      residual = norm2(b(n + 1:m))
      call judge_rank(a, n, info, status, pivots)
   end subroutine least_squares

   !> Whether the LAPACK drivers would not scale a matrix with this largest entry.
   pure logical function well_scaled(largest)
      !> Largest absolute entry of the matrix.
      real(wp), intent(in) :: largest

      well_scaled = largest > smallest_entry .and. largest < largest_entry
   end function well_scaled

   !> Judges the rank from the diagonal of a triangular factor.
   pure subroutine judge_rank(factor, n, info, status, pivots)
      !> Triangular factor; only its diagonal is read.
      real(wp), intent(in) :: factor(:, :)
      !> Number of diagonal entries, and LAPACK's error code.
      integer, intent(in) :: n, info
      !> As in `solve`.
      integer, intent(out) :: status
      !> As in `solve`.
      real(wp), intent(out), optional :: pivots(2)
      real(wp) :: smallest, largest
      integer :: i

      smallest = huge(1.0_wp)
      largest = 0.0_wp
      do i = 1, n
         smallest = min(smallest, abs(factor(i, i)))
         largest = max(largest, abs(factor(i, i)))
      end do
      if (present(pivots)) pivots = [smallest, largest]
      status = stat%ok
      if (info > 0 .or. .not. smallest > rank_tolerance*largest) status = stat%singular
   end subroutine judge_rank

   !> The eigenvalues of a real matrix, at most 4 x 4 (xGEEV), in the order LAPACK finds them.
   !!
   !! LAPACK is not asked about a matrix that is not finite: where an entry is not a number, newer
   !! versions end the program.
   pure subroutine eigenvalues(a, lambda, status)
      !> In: the matrix (n, n). Out: overwritten.
      real(wp), intent(inout), contiguous :: a(:, :)
      !> (n) The eigenvalues, in the order in which LAPACK finds them; 0 of a matrix not finite.
      complex(wp), intent(out) :: lambda(:)
      !> `stat%ok`, `stat%not_finite`, or `stat%lapack_failed` where the iteration did not converge.
      integer, intent(out) :: status
      !> No matrix here is larger.
      integer, parameter :: most = 4
      real(wp) :: real_part(most), imaginary_part(most), work(8*most), scale(most), unused(1, 1)
      real(wp) :: h(most, most)
      integer :: i, n, info, first, last

      n = size(lambda)
      lambda = 0
      status = stat%not_finite
      if (.not. all(ieee_is_finite(a))) return
      info = 1
      if (well_scaled(maxval(abs(a)))) then
         h(:n, :n) = a
         call gebal('B', n, h, most, first, last, scale, info)
         call gehd2(n, first, last, h, most, scale, work, info)
         do i = 1, n
            ! balancing may have isolated some eigenvalues
            real_part(i) = h(i, i)
            imaginary_part(i) = 0
         end do
         if (first < last) call lahqr(.false., .false., n, first, last, h, most, real_part, &
            imaginary_part, 1, n, unused, 1, info)
      end if
      ! the driver tries other iterations before it gives up
      if (info /= 0) call geev('N', 'N', n, a, n, real_part, imaginary_part, unused, 1, unused, 1, &
         work, size(work), info)
      lambda = cmplx(real_part(:n), imaginary_part(:n), wp)
      status = merge(stat%ok, stat%lapack_failed, info == 0)
   end subroutine eigenvalues

   !> The eigenvector (xGEEV) of a real matrix, at most 4 x 4, whose eigenvalue is nearest to a
   !! number.
   pure subroutine eigenvector(a, near, lambda, vector, status)
      !> In: the matrix (n, n). Out: overwritten.
      real(wp), intent(inout), contiguous :: a(:, :)
      !> Number to which the eigenvalue is nearest.
      real(wp), intent(in) :: near
      !> The eigenvalue.
      complex(wp), intent(out) :: lambda
      !> (n) Its eigenvector, of length 1; its real part if the eigenvalue is complex.
      real(wp), intent(out) :: vector(:)
      !> `stat%ok`, `stat%not_finite` (all results are 0 then), or `stat%lapack_failed` where the
      !! iteration did not converge.
      integer, intent(out) :: status
      !> No matrix here is larger.
      integer, parameter :: most = 4
      real(wp) :: real_part(most), imaginary_part(most), vectors(most, most), unused(1, 1), &
         work(8*most)
      integer :: i, n, info

      n = size(vector)
      lambda = 0
      vector = 0
      status = stat%not_finite
      if (.not. all(ieee_is_finite(a))) return
      call geev('N', 'V', n, a, n, real_part, imaginary_part, unused, 1, vectors, most, work, &
         size(work), info)
      ! for a conjugate pair the first column holds the real part
      i = minloc(hypot(real_part(:n) - near, imaginary_part(:n)), 1)
      lambda = cmplx(real_part(i), imaginary_part(i), wp)
      vector = vectors(:n, i)
      status = merge(stat%ok, stat%lapack_failed, info == 0)
   end subroutine eigenvector

end module vi_lapack
