!> The LAPACK routines that are called, in both precisions.
module vi_lapack_routines
   use, intrinsic :: iso_fortran_env, only: real32, real64
   implicit none (type, external)
   private

   public :: gebal, geev, gehd2, gels, geqr2, gesv, getf2, getrs, lahqr, orm2r, trtrs

   interface gesv
      pure subroutine sgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: real32
         implicit none (type, external)
         !> Equations, right sides, leading dimensions of a and b.
         integer, intent(in) :: n, nrhs, lda, ldb
         !> In: the matrix and the right sides. Out: its LU factors and the solutions.
         real(real32), intent(inout) :: a(lda, *), b(*)
         !> Row interchanges (n); 0, or the number of a zero pivot, or minus the number of an
         !! illegal argument.
         integer, intent(out) :: ipiv(*), info
      end subroutine sgesv
      pure subroutine dgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: real64
         implicit none (type, external)
         !> Equations, right sides, leading dimensions of a and b.
         integer, intent(in) :: n, nrhs, lda, ldb
         !> In: the matrix and the right sides. Out: its LU factors and the solutions.
         real(real64), intent(inout) :: a(lda, *), b(*)
         !> Row interchanges (n); 0, or the number of a zero pivot, or minus the number of an
         !! illegal argument.
         integer, intent(out) :: ipiv(*), info
      end subroutine dgesv
   end interface gesv

   interface gels
      pure subroutine sgels(trans, m, n, nrhs, a, lda, b, ldb, work, lwork, info)
         import :: real32
         implicit none (type, external)
         !> 'N' for a itself, 'T' for its transpose.
         character, intent(in) :: trans
         !> Rows, columns, right sides, leading dimensions of a and b, length of `work`.
         integer, intent(in) :: m, n, nrhs, lda, ldb, lwork
         !> In: the matrix and the right sides. Out: its QR factors, the solutions in rows 1..n of b
         !! and the transformed residuals in the other rows. `work` is scratch.
         real(real32), intent(inout) :: a(lda, *), b(*), work(*)
         !> 0, or the number of a zero diagonal entry, or minus the number of an illegal argument.
         integer, intent(out) :: info
      end subroutine sgels
      pure subroutine dgels(trans, m, n, nrhs, a, lda, b, ldb, work, lwork, info)
         import :: real64
         implicit none (type, external)
         !> 'N' for a itself, 'T' for its transpose.
         character, intent(in) :: trans
         !> Rows, columns, right sides, leading dimensions of a and b, length of `work`.
         integer, intent(in) :: m, n, nrhs, lda, ldb, lwork
         !> In: the matrix and the right sides. Out: its QR factors, the solutions in rows 1..n of b
         !! and the transformed residuals in the other rows. `work` is scratch.
         real(real64), intent(inout) :: a(lda, *), b(*), work(*)
         !> 0, or the number of a zero diagonal entry, or minus the number of an illegal argument.
         integer, intent(out) :: info
      end subroutine dgels
   end interface gels

   interface geev
      pure subroutine sgeev(jobvl, jobvr, n, a, lda, wr, wi, vl, ldvl, vr, ldvr, work, lwork, info)
         import :: real32
         implicit none (type, external)
         !> 'V' if the left (right) eigenvectors are wanted, otherwise 'N'.
         character, intent(in) :: jobvl, jobvr
         !> Order, leading dimensions of a, vl and vr, length of `work`.
         integer, intent(in) :: n, lda, ldvl, ldvr, lwork
         !> In: the matrix. Out: overwritten. `work` is scratch.
         real(real32), intent(inout) :: a(lda, *), work(*)
         !> Real and imaginary parts of the eigenvalues (n); conjugate pairs are adjacent.
         real(real32), intent(out) :: wr(*), wi(*)
         !> Left and right eigenvectors; not referenced where they are not wanted.
         real(real32), intent(inout) :: vl(ldvl, *), vr(ldvr, *)
         !> 0, or i > 0 if only the eigenvalues after the i-th one were found.
         integer, intent(out) :: info
      end subroutine sgeev
      pure subroutine dgeev(jobvl, jobvr, n, a, lda, wr, wi, vl, ldvl, vr, ldvr, work, lwork, info)
         import :: real64
         implicit none (type, external)
         !> 'V' if the left (right) eigenvectors are wanted, otherwise 'N'.
         character, intent(in) :: jobvl, jobvr
         !> Order, leading dimensions of a, vl and vr, length of `work`.
         integer, intent(in) :: n, lda, ldvl, ldvr, lwork
         !> In: the matrix. Out: overwritten. `work` is scratch.
         real(real64), intent(inout) :: a(lda, *), work(*)
         !> Real and imaginary parts of the eigenvalues (n); conjugate pairs are adjacent.
         real(real64), intent(out) :: wr(*), wi(*)
         !> Left and right eigenvectors; not referenced where they are not wanted.
         real(real64), intent(inout) :: vl(ldvl, *), vr(ldvr, *)
         !> 0, or i > 0 if only the eigenvalues after the i-th one were found.
         integer, intent(out) :: info
      end subroutine dgeev
   end interface geev

   ! what xGESV calls for a small system

   interface getf2
      pure subroutine sgetf2(m, n, a, lda, ipiv, info)
         import :: real32
         implicit none (type, external)
         !> Rows, columns, leading dimension of a.
         integer, intent(in) :: m, n, lda
         !> In: the matrix. Out: its LU factors.
         real(real32), intent(inout) :: a(lda, *)
         !> Row interchanges (min(m, n)); 0, or the number of a zero pivot.
         integer, intent(out) :: ipiv(*), info
      end subroutine sgetf2
      pure subroutine dgetf2(m, n, a, lda, ipiv, info)
         import :: real64
         implicit none (type, external)
         !> Rows, columns, leading dimension of a.
         integer, intent(in) :: m, n, lda
         !> In: the matrix. Out: its LU factors.
         real(real64), intent(inout) :: a(lda, *)
         !> Row interchanges (min(m, n)); 0, or the number of a zero pivot.
         integer, intent(out) :: ipiv(*), info
      end subroutine dgetf2
   end interface getf2

   interface getrs
      pure subroutine sgetrs(trans, n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: real32
         implicit none (type, external)
         !> 'N' for a itself, 'T' for its transpose.
         character, intent(in) :: trans
         !> Order, right sides, leading dimensions of a and b, row interchanges of getf2.
         integer, intent(in) :: n, nrhs, lda, ldb, ipiv(*)
         !> LU factors of getf2.
         real(real32), intent(in) :: a(lda, *)
         !> In: the right sides. Out: the solutions.
         real(real32), intent(inout) :: b(*)
         !> 0, or minus the number of an illegal argument.
         integer, intent(out) :: info
      end subroutine sgetrs
      pure subroutine dgetrs(trans, n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: real64
         implicit none (type, external)
         !> 'N' for a itself, 'T' for its transpose.
         character, intent(in) :: trans
         !> Order, right sides, leading dimensions of a and b, row interchanges of getf2.
         integer, intent(in) :: n, nrhs, lda, ldb, ipiv(*)
         !> LU factors of getf2.
         real(real64), intent(in) :: a(lda, *)
         !> In: the right sides. Out: the solutions.
         real(real64), intent(inout) :: b(*)
         !> 0, or minus the number of an illegal argument.
         integer, intent(out) :: info
      end subroutine dgetrs
   end interface getrs

   ! what xGELS calls for a small system

   interface geqr2
      pure subroutine sgeqr2(m, n, a, lda, tau, work, info)
         import :: real32
         implicit none (type, external)
         !> Rows, columns, leading dimension of a.
         integer, intent(in) :: m, n, lda
         !> In: the matrix. Out: R and the Householder vectors, and their factors (n). `work` is
         !! scratch (n).
         real(real32), intent(inout) :: a(lda, *), tau(*), work(*)
         !> 0, or minus the number of an illegal argument.
         integer, intent(out) :: info
      end subroutine sgeqr2
      pure subroutine dgeqr2(m, n, a, lda, tau, work, info)
         import :: real64
         implicit none (type, external)
         !> Rows, columns, leading dimension of a.
         integer, intent(in) :: m, n, lda
         !> In: the matrix. Out: R and the Householder vectors, and their factors (n). `work` is
         !! scratch (n).
         real(real64), intent(inout) :: a(lda, *), tau(*), work(*)
         !> 0, or minus the number of an illegal argument.
         integer, intent(out) :: info
      end subroutine dgeqr2
   end interface geqr2

   interface orm2r
      pure subroutine sorm2r(side, trans, m, n, k, a, lda, tau, c, ldc, work, info)
         import :: real32
         implicit none (type, external)
         !> 'L' or 'R': Q is multiplied from the left or the right; 'N' for Q, 'T' for its
         !! transpose.
         character, intent(in) :: side, trans
         !> Rows and columns of c, number of reflections, leading dimensions of a and c.
         integer, intent(in) :: m, n, k, lda, ldc
         !> Householder vectors of geqr2; in: the matrix c, out: Q c; `work` is scratch.
         real(real32), intent(inout) :: a(lda, *), c(*), work(*)
         !> Factors of the reflections (k).
         real(real32), intent(in) :: tau(*)
         !> 0, or minus the number of an illegal argument.
         integer, intent(out) :: info
      end subroutine sorm2r
      pure subroutine dorm2r(side, trans, m, n, k, a, lda, tau, c, ldc, work, info)
         import :: real64
         implicit none (type, external)
         !> 'L' or 'R': Q is multiplied from the left or the right; 'N' for Q, 'T' for its
         !! transpose.
         character, intent(in) :: side, trans
         !> Rows and columns of c, number of reflections, leading dimensions of a and c.
         integer, intent(in) :: m, n, k, lda, ldc
         !> Householder vectors of geqr2; in: the matrix c, out: Q c; `work` is scratch.
         real(real64), intent(inout) :: a(lda, *), c(*), work(*)
         !> Factors of the reflections (k).
         real(real64), intent(in) :: tau(*)
         !> 0, or minus the number of an illegal argument.
         integer, intent(out) :: info
      end subroutine dorm2r
   end interface orm2r

   interface trtrs
      pure subroutine strtrs(uplo, trans, diag, n, nrhs, a, lda, b, ldb, info)
         import :: real32
         implicit none (type, external)
         !> 'U' or 'L' triangle; 'N' for a itself or 'T' for its transpose; 'U' for a unit diagonal,
         !! otherwise 'N'.
         character, intent(in) :: uplo, trans, diag
         !> Order, right sides, leading dimensions of a and b.
         integer, intent(in) :: n, nrhs, lda, ldb
         !> The triangular matrix.
         real(real32), intent(in) :: a(lda, *)
         !> In: the right sides. Out: the solutions.
         real(real32), intent(inout) :: b(*)
         !> 0, or the number of a zero diagonal entry, or minus the number of an illegal argument.
         integer, intent(out) :: info
      end subroutine strtrs
      pure subroutine dtrtrs(uplo, trans, diag, n, nrhs, a, lda, b, ldb, info)
         import :: real64
         implicit none (type, external)
         !> 'U' or 'L' triangle; 'N' for a itself or 'T' for its transpose; 'U' for a unit diagonal,
         !! otherwise 'N'.
         character, intent(in) :: uplo, trans, diag
         !> Order, right sides, leading dimensions of a and b.
         integer, intent(in) :: n, nrhs, lda, ldb
         !> The triangular matrix.
         real(real64), intent(in) :: a(lda, *)
         !> In: the right sides. Out: the solutions.
         real(real64), intent(inout) :: b(*)
         !> 0, or the number of a zero diagonal entry, or minus the number of an illegal argument.
         integer, intent(out) :: info
      end subroutine dtrtrs
   end interface trtrs

   ! what xGEEV calls for a small matrix

   interface gebal
      pure subroutine sgebal(job, n, a, lda, ilo, ihi, scale, info)
         import :: real32
         implicit none (type, external)
         !> 'B': permute and scale.
         character, intent(in) :: job
         !> Order, leading dimension of a.
         integer, intent(in) :: n, lda
         !> In: the matrix. Out: balanced.
         real(real32), intent(inout) :: a(lda, *)
         !> Rows and columns outside ilo..ihi are isolated eigenvalues; 0, or minus the number of an
         !! illegal argument.
         integer, intent(out) :: ilo, ihi, info
         !> The interchanges and scale factors (n).
         real(real32), intent(out) :: scale(*)
      end subroutine sgebal
      pure subroutine dgebal(job, n, a, lda, ilo, ihi, scale, info)
         import :: real64
         implicit none (type, external)
         !> 'B': permute and scale.
         character, intent(in) :: job
         !> Order, leading dimension of a.
         integer, intent(in) :: n, lda
         !> In: the matrix. Out: balanced.
         real(real64), intent(inout) :: a(lda, *)
         !> Rows and columns outside ilo..ihi are isolated eigenvalues; 0, or minus the number of an
         !! illegal argument.
         integer, intent(out) :: ilo, ihi, info
         !> The interchanges and scale factors (n).
         real(real64), intent(out) :: scale(*)
      end subroutine dgebal
   end interface gebal

   interface gehd2
      pure subroutine sgehd2(n, ilo, ihi, a, lda, tau, work, info)
         import :: real32
         implicit none (type, external)
         !> Order, range that is not yet triangular, leading dimension of a.
         integer, intent(in) :: n, ilo, ihi, lda
         !> In: the matrix. Out: its upper Hessenberg form. `work` is scratch (n).
         real(real32), intent(inout) :: a(lda, *), work(*)
         !> Factors of the reflections (n - 1).
         real(real32), intent(out) :: tau(*)
         !> 0, or minus the number of an illegal argument.
         integer, intent(out) :: info
      end subroutine sgehd2
      pure subroutine dgehd2(n, ilo, ihi, a, lda, tau, work, info)
         import :: real64
         implicit none (type, external)
         !> Order, range that is not yet triangular, leading dimension of a.
         integer, intent(in) :: n, ilo, ihi, lda
         !> In: the matrix. Out: its upper Hessenberg form. `work` is scratch (n).
         real(real64), intent(inout) :: a(lda, *), work(*)
         !> Factors of the reflections (n - 1).
         real(real64), intent(out) :: tau(*)
         !> 0, or minus the number of an illegal argument.
         integer, intent(out) :: info
      end subroutine dgehd2
   end interface gehd2

   interface lahqr
      pure subroutine slahqr(wantt, wantz, n, ilo, ihi, h, ldh, wr, wi, iloz, ihiz, z, ldz, info)
         import :: real32
         implicit none (type, external)
         !> Whether the Schur form and the Schur vectors are wanted.
         logical, intent(in) :: wantt, wantz
         !> Order, range that is not yet triangular, leading dimension of h, rows of z that are
         !! transformed, leading dimension of z.
         integer, intent(in) :: n, ilo, ihi, ldh, iloz, ihiz, ldz
         !> In: the Hessenberg matrix. Out: overwritten; z is not referenced where it is not wanted.
         real(real32), intent(inout) :: h(ldh, *), z(ldz, *)
         !> Real and imaginary parts of the eigenvalues ilo..ihi.
         real(real32), intent(inout) :: wr(*), wi(*)
         !> 0, or i > 0 if only the eigenvalues after the i-th one were found.
         integer, intent(out) :: info
      end subroutine slahqr
      pure subroutine dlahqr(wantt, wantz, n, ilo, ihi, h, ldh, wr, wi, iloz, ihiz, z, ldz, info)
         import :: real64
         implicit none (type, external)
         !> Whether the Schur form and the Schur vectors are wanted.
         logical, intent(in) :: wantt, wantz
         !> Order, range that is not yet triangular, leading dimension of h, rows of z that are
         !! transformed, leading dimension of z.
         integer, intent(in) :: n, ilo, ihi, ldh, iloz, ihiz, ldz
         !> In: the Hessenberg matrix. Out: overwritten; z is not referenced where it is not wanted.
         real(real64), intent(inout) :: h(ldh, *), z(ldz, *)
         !> Real and imaginary parts of the eigenvalues ilo..ihi.
         real(real64), intent(inout) :: wr(*), wi(*)
         !> 0, or i > 0 if only the eigenvalues after the i-th one were found.
         integer, intent(out) :: info
      end subroutine dlahqr
   end interface lahqr

end module vi_lapack_routines
