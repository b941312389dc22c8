!> The families of motions of an oscillator: where a further kind of motions is chosen.
module vi_oscillator_families
   use vi_family, only: images_of, new_family, repetition_type
   use vi_motion_family, only: motion_family_type
   use vi_pair_family, only: pair_family_type
   use vi_pattern, only: pattern_type
   use vi_resting_family, only: new_resting_family
   use vi_kinds, only: pi, wp
   implicit none (type, external)
   private

   public :: choose_family

contains

   !> The family of a pattern.
   subroutine choose_family(pattern, symmetric, equal_walls, family, possible)
      !> Sides, +2 and -2 for accumulation and rest, and the load cycles k of the whole period.
      type(pattern_type), intent(in) :: pattern
      !> Only motions that are their own mirror image half a period later.
      logical, intent(in) :: symmetric
      !> R1 = R2: there are mirror images.
      logical, intent(in) :: equal_walls
      !> The family; not allocated where `possible` is false.
      class(motion_family_type), allocatable, intent(out) :: family
      !> False if this pattern has no such motions.
      logical, intent(out) :: possible
      type(pair_family_type) :: pair

      if (any(abs(pattern%sides) == 2)) then
         possible = .not. symmetric
         if (possible) allocate (family, source=new_resting_family(pattern%sides, pattern%cycles))
      else
         call new_family(pattern, symmetric, equal_walls, pair%impacts, pair%repetitions, possible)
         if (.not. possible) return
         pair%symmetric = symmetric
         pair%images = images_of(pair%impacts, repetition_type(sign=merge(-1.0_wp, 1.0_wp, &
            equal_walls), phase=pi))
         allocate (family, source=pair)
      end if
   end subroutine choose_family

end module vi_oscillator_families
