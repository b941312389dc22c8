!> The LAPACK routines for structures of any size, in double precision.
!!
!! Those that the core needs in both precisions are in vi_lapack_routines.
module vi_eigen_routines
   use, intrinsic :: iso_fortran_env, only: real64
   implicit none (type, external)
   private

   public :: dgeqrf, dgesv, dorgqr, dsygv

   interface
      !> Eigenvalues and eigenvectors of A x = lambda B x, A symmetric, B symmetric positive
      !! definite.
      pure subroutine dsygv(itype, jobz, uplo, n, a, lda, b, ldb, w, work, lwork, info)
         import :: real64
         implicit none (type, external)
         !> 1 for A x = lambda B x; order, leading dimensions of a and b, length of `work`.
         integer, intent(in) :: itype, n, lda, ldb, lwork
         !> 'V' if eigenvectors are wanted; 'U' or 'L', the triangle that is read.
         character, intent(in) :: jobz, uplo
         !> In: both matrices. Out: the eigenvectors with x.B.x = 1, and the factor of B. `work` is
         !! scratch.
         real(real64), intent(inout) :: a(lda, *), b(ldb, *), work(*)
         !> The eigenvalues (n), in ascending order.
         real(real64), intent(out) :: w(*)
         !> 0; i <= n if the iteration did not converge; n + i if B is not positive definite.
         integer, intent(out) :: info
      end subroutine dsygv

      !> Solves n equations for several right sides by Gaussian elimination.
      pure subroutine dgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: real64
         implicit none (type, external)
         !> Equations, right sides, leading dimensions of a and b.
         integer, intent(in) :: n, nrhs, lda, ldb
         !> In: the matrix and the right sides. Out: its LU factors and the solutions.
         real(real64), intent(inout) :: a(lda, *), b(ldb, *)
         !> Row interchanges (n); 0, or the number of a zero pivot.
         integer, intent(out) :: ipiv(*), info
      end subroutine dgesv

      !> QR factorisation with Householder reflections.
      pure subroutine dgeqrf(m, n, a, lda, tau, work, lwork, info)
         import :: real64
         implicit none (type, external)
         !> Rows, columns, leading dimension of a, length of `work`.
         integer, intent(in) :: m, n, lda, lwork
         !> In: the matrix. Out: R and the reflections. `work` is scratch.
         real(real64), intent(inout) :: a(lda, *), work(*)
         !> Factors of the reflections (n).
         real(real64), intent(out) :: tau(*)
         !> 0, or minus the number of an illegal argument.
         integer, intent(out) :: info
      end subroutine dgeqrf

      !> The orthogonal matrix of a QR factorisation.
      pure subroutine dorgqr(m, n, k, a, lda, tau, work, lwork, info)
         import :: real64
         implicit none (type, external)
         !> Rows, columns, number of reflections, leading dimension of a, length of `work`.
         integer, intent(in) :: m, n, k, lda, lwork
         !> In: the reflections. Out: the first n columns of Q. `work` is scratch.
         real(real64), intent(inout) :: a(lda, *), work(*)
         !> Factors of the reflections (k).
         real(real64), intent(in) :: tau(*)
         !> 0, or minus the number of an illegal argument.
         integer, intent(out) :: info
      end subroutine dorgqr
   end interface

end module vi_eigen_routines
