!> Letters of a pattern with rest: an impact, or the impacts that accumulate on a wall and the rest.
!!
!! As numbers: +1 and -1 for an impact on the right and the left wall, +2 and -2 for accumulation
!! and rest there. As text: R, L, R* and L*.
module vi_letters
   use vi_pattern, only: starred_letters
   implicit none (type, external)
   private

   public :: standard_letters

contains

   !> The same pattern from the letter on, and mirrored if that is the same, whose text is last in
   !> the alphabet: the one name that all turns of a pattern share.
   pure subroutine standard_letters(letters, may_mirror, standard, shift, mirrored)
      !> +1, -1 for an impact on the right, left wall; +2, -2 for accumulation and rest there.
      integer, intent(in) :: letters(:)
      !> R1 = R2: a pattern and its mirror image are one.
      logical, intent(in) :: may_mirror
      !> (as `letters`) The pattern in standard form.
      integer, intent(out) :: standard(:)
      !> Number of letters left of the new first one.
      integer, intent(out) :: shift
      !> Whether all letters are mirrored.
      logical, intent(out) :: mirrored
      integer :: j, k, turned(size(letters))

      standard = letters
      shift = 0
      mirrored = .false.
      do k = 1, merge(2, 1, may_mirror)
         do j = 0, size(letters) - 1
            turned = merge(1, -1, k == 1)*cshift(letters, j)
            if (.not. lgt(starred_letters(turned), starred_letters(standard))) cycle
            standard = turned
            shift = j
            mirrored = k == 2
         end do
      end do
   end subroutine standard_letters

end module vi_letters
