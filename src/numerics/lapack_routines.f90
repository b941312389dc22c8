!> The LAPACK routines that are called, in both kinds.
module vi_lapack_routines
   use, intrinsic :: iso_fortran_env, only: real32, real64
   implicit none (type, external)
   private

   public :: gebal, geev, gehd2, gels, geqr2, gesv, getf2, getrs, lahqr, orm2r, trtrs

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

   ! what xGESV calls for a small system

   interface getf2
      pure subroutine sgetf2(m, n, a, lda, ipiv, info)
         import :: real32
         implicit none (type, external)
         integer, intent(in) :: m, n, lda
         real(real32), intent(inout) :: a(lda, *)
         integer, intent(out) :: ipiv(*), info
      end subroutine sgetf2
      pure subroutine dgetf2(m, n, a, lda, ipiv, info)
         import :: real64
         implicit none (type, external)
         integer, intent(in) :: m, n, lda
         real(real64), intent(inout) :: a(lda, *)
         integer, intent(out) :: ipiv(*), info
      end subroutine dgetf2
   end interface getf2

   interface getrs
      pure subroutine sgetrs(trans, n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: real32
         implicit none (type, external)
         character, intent(in) :: trans
         integer, intent(in) :: n, nrhs, lda, ldb, ipiv(*)
         real(real32), intent(in) :: a(lda, *)
         real(real32), intent(inout) :: b(*)
         integer, intent(out) :: info
      end subroutine sgetrs
      pure subroutine dgetrs(trans, n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: real64
         implicit none (type, external)
         character, intent(in) :: trans
         integer, intent(in) :: n, nrhs, lda, ldb, ipiv(*)
         real(real64), intent(in) :: a(lda, *)
         real(real64), intent(inout) :: b(*)
         integer, intent(out) :: info
      end subroutine dgetrs
   end interface getrs

   ! what xGELS calls for a small system

   interface geqr2
      pure subroutine sgeqr2(m, n, a, lda, tau, work, info)
         import :: real32
         implicit none (type, external)
         integer, intent(in) :: m, n, lda
         real(real32), intent(inout) :: a(lda, *), tau(*), work(*)
         integer, intent(out) :: info
      end subroutine sgeqr2
      pure subroutine dgeqr2(m, n, a, lda, tau, work, info)
         import :: real64
         implicit none (type, external)
         integer, intent(in) :: m, n, lda
         real(real64), intent(inout) :: a(lda, *), tau(*), work(*)
         integer, intent(out) :: info
      end subroutine dgeqr2
   end interface geqr2

   interface orm2r
      pure subroutine sorm2r(side, trans, m, n, k, a, lda, tau, c, ldc, work, info)
         import :: real32
         implicit none (type, external)
         character, intent(in) :: side, trans
         integer, intent(in) :: m, n, k, lda, ldc
         real(real32), intent(inout) :: a(lda, *), c(*), work(*)
         real(real32), intent(in) :: tau(*)
         integer, intent(out) :: info
      end subroutine sorm2r
      pure subroutine dorm2r(side, trans, m, n, k, a, lda, tau, c, ldc, work, info)
         import :: real64
         implicit none (type, external)
         character, intent(in) :: side, trans
         integer, intent(in) :: m, n, k, lda, ldc
         real(real64), intent(inout) :: a(lda, *), c(*), work(*)
         real(real64), intent(in) :: tau(*)
         integer, intent(out) :: info
      end subroutine dorm2r
   end interface orm2r

   interface trtrs
      pure subroutine strtrs(uplo, trans, diag, n, nrhs, a, lda, b, ldb, info)
         import :: real32
         implicit none (type, external)
         character, intent(in) :: uplo, trans, diag
         integer, intent(in) :: n, nrhs, lda, ldb
         real(real32), intent(in) :: a(lda, *)
         real(real32), intent(inout) :: b(*)
         integer, intent(out) :: info
      end subroutine strtrs
      pure subroutine dtrtrs(uplo, trans, diag, n, nrhs, a, lda, b, ldb, info)
         import :: real64
         implicit none (type, external)
         character, intent(in) :: uplo, trans, diag
         integer, intent(in) :: n, nrhs, lda, ldb
         real(real64), intent(in) :: a(lda, *)
         real(real64), intent(inout) :: b(*)
         integer, intent(out) :: info
      end subroutine dtrtrs
   end interface trtrs

   ! what xGEEV calls for a small matrix

   interface gebal
      pure subroutine sgebal(job, n, a, lda, ilo, ihi, scale, info)
         import :: real32
         implicit none (type, external)
         character, intent(in) :: job
         integer, intent(in) :: n, lda
         real(real32), intent(inout) :: a(lda, *)
         integer, intent(out) :: ilo, ihi, info
         real(real32), intent(out) :: scale(*)
      end subroutine sgebal
      pure subroutine dgebal(job, n, a, lda, ilo, ihi, scale, info)
         import :: real64
         implicit none (type, external)
         character, intent(in) :: job
         integer, intent(in) :: n, lda
         real(real64), intent(inout) :: a(lda, *)
         integer, intent(out) :: ilo, ihi, info
         real(real64), intent(out) :: scale(*)
      end subroutine dgebal
   end interface gebal

   interface gehd2
      pure subroutine sgehd2(n, ilo, ihi, a, lda, tau, work, info)
         import :: real32
         implicit none (type, external)
         integer, intent(in) :: n, ilo, ihi, lda
         real(real32), intent(inout) :: a(lda, *), work(*)
         real(real32), intent(out) :: tau(*)
         integer, intent(out) :: info
      end subroutine sgehd2
      pure subroutine dgehd2(n, ilo, ihi, a, lda, tau, work, info)
         import :: real64
         implicit none (type, external)
         integer, intent(in) :: n, ilo, ihi, lda
         real(real64), intent(inout) :: a(lda, *), work(*)
         real(real64), intent(out) :: tau(*)
         integer, intent(out) :: info
      end subroutine dgehd2
   end interface gehd2

   interface lahqr
      pure subroutine slahqr(wantt, wantz, n, ilo, ihi, h, ldh, wr, wi, iloz, ihiz, z, ldz, info)
         import :: real32
         implicit none (type, external)
         logical, intent(in) :: wantt, wantz
         integer, intent(in) :: n, ilo, ihi, ldh, iloz, ihiz, ldz
         real(real32), intent(inout) :: h(ldh, *), z(ldz, *)
         real(real32), intent(inout) :: wr(*), wi(*)
         integer, intent(out) :: info
      end subroutine slahqr
      pure subroutine dlahqr(wantt, wantz, n, ilo, ihi, h, ldh, wr, wi, iloz, ihiz, z, ldz, info)
         import :: real64
         implicit none (type, external)
         logical, intent(in) :: wantt, wantz
         integer, intent(in) :: n, ilo, ihi, ldh, iloz, ihiz, ldz
         real(real64), intent(inout) :: h(ldh, *), z(ldz, *)
         real(real64), intent(inout) :: wr(*), wi(*)
         integer, intent(out) :: info
      end subroutine dlahqr
   end interface lahqr

end module vi_lapack_routines
