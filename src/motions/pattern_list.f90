!> All patterns of impacts up to a size.
module vi_pattern_list
   use vi_symbols, only: standard_symbols
   use vi_pattern, only: pattern_type
   implicit none (type, external)
   private

   public :: side_patterns

contains

   !> All patterns with impacts on both walls, with each number of load cycles, shortest first.
   !! Patterns that are rotations of each other are listed once, and so are mirror images where the
   !! walls are equal.
   !!
   !! A pattern that repeats a shorter one is listed too: it describes motions with a multiple of
   !! the period.
   pure function side_patterns(max_impacts, max_cycles, alike) result(patterns)
      !> Largest number of impacts, and of load cycles k in a period.
      integer, intent(in) :: max_impacts, max_cycles
      !> R1 = R2: a pattern and its mirror image count as one.
      logical, intent(in) :: alike
      type(pattern_type), allocatable :: patterns(:)
      integer :: n

      n = 0
      call list(patterns, n)
      allocate (patterns(n))
      n = 0
      call list(patterns, n)
   contains
      !> Counts them, and writes them where `patterns` is allocated.
      pure subroutine list(patterns, count)
         !> If allocated, large enough for all patterns. Out: filled.
         type(pattern_type), allocatable, intent(inout) :: patterns(:)
         !> In: 0. Out: number of patterns.
         integer, intent(inout) :: count
         integer :: sides(max_impacts), bits, cycles, i, m

         do m = 2, max_impacts
            do bits = 2**m - 2, 1, -1
               sides(:m) = [(merge(1, -1, btest(bits, m - i)), i=1, m)]
               if (.not. is_standard(sides(:m), alike)) cycle
               do cycles = 1, max_cycles
                  count = count + 1
                  if (allocated(patterns)) patterns(count) = pattern_type(sides(:m), cycles)
               end do
            end do
         end do
      end subroutine list
   end function side_patterns

   !> Whether a pattern is in standard form.
   pure logical function is_standard(sides, alike)
      !> +1 right, -1 left.
      integer, intent(in) :: sides(:)
      !> R1 = R2: a pattern and its mirror image count as one.
      logical, intent(in) :: alike
      integer :: standard(size(sides)), shift
      logical :: mirrored

      call standard_symbols(sides, alike, standard, shift, mirrored)
      is_standard = all(standard == sides)
   end function is_standard

end module vi_pattern_list
