!> The three LAPACK drivers of the reference path, in both kinds, behind three plain procedures.
!!
!! The 1983 computations used IMSL: LEQT1F (Gaussian elimination) is DGESV here, LLSQF (least
!! squares) is DGELS and EIGRF (Hessenberg and QR) is DGEEV.
module vi_lapack
   use, intrinsic :: iso_fortran_env, only: real32, real64
   use vi_kinds, only: wp
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: solve, least_squares, least_squares_work, eigenvalues

   interface gesv
      pure subroutine sgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: real32
         implicit none (type, external)
         integer, intent(in) :: n, nrhs, lda, ldb
         real(real32), intent(inout) :: a(lda, *), b(*)
         integer, intent(out) :: ipiv(*), info
      end subroutine sgesv
      pure subroutine dgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: real64
         implicit none (type, external)
         integer, intent(in) :: n, nrhs, lda, ldb
         real(real64), intent(inout) :: a(lda, *), b(*)
         integer, intent(out) :: ipiv(*), info
      end subroutine dgesv
   end interface gesv

   interface gels
      pure subroutine sgels(trans, m, n, nrhs, a, lda, b, ldb, work, lwork, info)
         import :: real32
         implicit none (type, external)
         character, intent(in) :: trans
         integer, intent(in) :: m, n, nrhs, lda, ldb, lwork
         real(real32), intent(inout) :: a(lda, *), b(*), work(*)
         integer, intent(out) :: info
      end subroutine sgels
      pure subroutine dgels(trans, m, n, nrhs, a, lda, b, ldb, work, lwork, info)
         import :: real64
         implicit none (type, external)
         character, intent(in) :: trans
         integer, intent(in) :: m, n, nrhs, lda, ldb, lwork
         real(real64), intent(inout) :: a(lda, *), b(*), work(*)
         integer, intent(out) :: info
      end subroutine dgels
   end interface gels

   interface geev
      pure subroutine sgeev(jobvl, jobvr, n, a, lda, wr, wi, vl, ldvl, vr, ldvr, work, lwork, info)
         import :: real32
         implicit none (type, external)
         character, intent(in) :: jobvl, jobvr
         integer, intent(in) :: n, lda, ldvl, ldvr, lwork
         real(real32), intent(inout) :: a(lda, *), work(*)
         real(real32), intent(out) :: wr(*), wi(*)
         real(real32), intent(inout) :: vl(ldvl, *), vr(ldvr, *)
         integer, intent(out) :: info
      end subroutine sgeev
      pure subroutine dgeev(jobvl, jobvr, n, a, lda, wr, wi, vl, ldvl, vr, ldvr, work, lwork, info)
         import :: real64
         implicit none (type, external)
         character, intent(in) :: jobvl, jobvr
         integer, intent(in) :: n, lda, ldvl, ldvr, lwork
         real(real64), intent(inout) :: a(lda, *), work(*)
         real(real64), intent(out) :: wr(*), wi(*)
         real(real64), intent(inout) :: vl(ldvl, *), vr(ldvr, *)
         integer, intent(out) :: info
      end subroutine dgeev
   end interface geev

   !> A diagonal of the triangular factor below this share of its largest counts as zero.
   real(wp), parameter :: rank_tolerance = 16*epsilon(1.0_wp)

contains

   !> Solves the square system a x = b by Gaussian elimination (xGESV).
   pure subroutine solve(a, b, status)
      !> In: the matrix (n, n). Out: its LU factors.
      real(wp), intent(inout), contiguous :: a(:, :)
      !> In: the right side (n). Out: the solution.
      real(wp), intent(inout), contiguous :: b(:)
      !> `stat%ok`, or `stat%singular` where the matrix has no full rank.
      integer, intent(out) :: status
      integer :: n, info
      integer :: pivot(size(b))

      n = size(b)
      call gesv(n, 1, a, n, pivot, b, n, info)
      status = rank_status(a, n, info)
   end subroutine solve

   !> The length of the work array that `least_squares` wants for m equations in n unknowns.
   pure integer function least_squares_work(m, n) result(length)
      integer, intent(in) :: m, n
      !> Columns that LAPACK's blocked QR treats together; small systems are not blocked at all.
      integer, parameter :: block = 32

      length = min(m, n) + max(m, n)*block
   end function least_squares_work

   !> Minimises the 2-norm of a x - b (xGELS, QR with Householder reflections).
   pure subroutine least_squares(a, b, work, residual, status)
      !> In: the matrix (m, n), m >= n. Out: its QR factors.
      real(wp), intent(inout), contiguous :: a(:, :)
      !> In: the right side (m). Out: the solution in 1..n.
      real(wp), intent(inout), contiguous :: b(:)
      !> Scratch of at least `least_squares_work(m, n)` numbers.
      real(wp), intent(inout), contiguous :: work(:)
      !> The 2-norm of a x - b.
      real(wp), intent(out) :: residual
      !> `stat%ok`, or `stat%singular` where the matrix has no full rank.
      integer, intent(out) :: status
      integer :: m, n, info

      m = size(a, 1)
      n = size(a, 2)
      call gels('N', m, n, 1, a, m, b, m, work, size(work), info)
      residual = sqrt(sum(b(n + 1:m)**2))
      status = rank_status(a, n, info)
   end subroutine least_squares

   !> Judges the rank from the diagonal of a triangular factor.
   pure integer function rank_status(factor, n, info) result(status)
      real(wp), intent(in) :: factor(:, :)
      integer, intent(in) :: n, info
      real(wp) :: smallest, largest
      integer :: i

      smallest = huge(1.0_wp)
      largest = 0.0_wp
      do i = 1, n
         smallest = min(smallest, abs(factor(i, i)))
         largest = max(largest, abs(factor(i, i)))
      end do
      status = stat%ok
      if (info < 0) then
         status = stat%lapack_failed
      else if (info > 0 .or. .not. smallest > rank_tolerance*largest) then
         status = stat%singular
      end if
   end function rank_status

   !> The eigenvalues of a general real matrix (xGEEV), in the order LAPACK finds them.
   pure subroutine eigenvalues(a, lambda, status)
      !> In: the matrix (n, n). Out: overwritten.
      real(wp), intent(inout), contiguous :: a(:, :)
      complex(wp), intent(out) :: lambda(:)
      integer, intent(out) :: status
      real(wp), dimension(size(lambda)) :: real_part, imaginary_part
      real(wp) :: work(8*size(lambda)), unused(1, 1)
      integer :: n, info

      n = size(lambda)
      call geev('N', 'N', n, a, n, real_part, imaginary_part, unused, 1, unused, 1, work, &
         size(work), info)
      lambda = cmplx(real_part, imaginary_part, wp)
      status = merge(stat%ok, stat%lapack_failed, info == 0)
   end subroutine eigenvalues

end module vi_lapack
