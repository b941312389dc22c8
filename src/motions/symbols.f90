!> Symbols of a pattern with rest: an impact, or impacts that accumulate on a wall and the rest that
!! follows.
!!
!! As numbers: +1 and -1 for an impact on the right and the left wall, +2 and -2 for accumulation
!! and rest there. As text: R, L, R* and L*.
module vi_symbols
   use vi_pattern, only: starred_symbols
   implicit none (type, external)
   private

   public :: standard_symbols

contains

   !> The standard form of a pattern: of all its rotations, and of their mirror images if those are
   !! equivalent, the one whose text is last in alphabetical order.
   pure subroutine standard_symbols(symbols, may_mirror, standard, shift, mirrored)
      !> +1, -1 for an impact on the right, left wall; +2, -2 for accumulation and rest there.
      integer, intent(in) :: symbols(:)
      !> R1 = R2: a pattern and its mirror image are one.
      logical, intent(in) :: may_mirror
      !> (as `symbols`) The pattern in standard form.
      integer, intent(out) :: standard(:)
      !> Number of symbols before the new first one.
      integer, intent(out) :: shift
      !> Whether all symbols are mirrored.
      logical, intent(out) :: mirrored
      integer :: j, k, turned(size(symbols))

      standard = symbols
      shift = 0
      mirrored = .false.
      do k = 1, merge(2, 1, may_mirror)
         do j = 0, size(symbols) - 1
            turned = merge(1, -1, k == 1)*cshift(symbols, j)
            if (.not. lgt(starred_symbols(turned), starred_symbols(standard))) cycle
            standard = turned
            shift = j
            mirrored = k == 2
         end do
      end do
   end subroutine standard_symbols

end module vi_symbols
