!> A pattern of impacts: which walls are hit, in which order, in how many load cycles.
module vi_pattern
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: new_pattern, side_symbols, default_restitution, starred_symbols, starred_pattern

   !> The impacts of a period, in order.
   type, public :: pattern_type
      !> Side s of each impact (n): +1 for the right wall, -1 for the left; y = s d/2 there.
      integer, allocatable :: sides(:)
      !> Load cycles k in one period of the motion.
      integer :: cycles = 1
   end type pattern_type

contains

   !> A pattern from symbols, R for the right wall and L for the left; other symbols give side 0.
   pure function new_pattern(symbols, cycles) result(pattern)
      !> Sides of the impacts in order: R or r, L or l.
      character(*), intent(in) :: symbols
      !> Load cycles k in one period.
      integer, intent(in) :: cycles
      type(pattern_type) :: pattern
      integer :: i

      allocate (pattern%sides(len(symbols)))
      do i = 1, len(symbols)
         select case (symbols(i:i))
         case ('R', 'r')
            pattern%sides(i) = 1
         case ('L', 'l')
            pattern%sides(i) = -1
         case default
            pattern%sides(i) = 0
         end select
      end do
      pattern%cycles = cycles
   end function new_pattern

   !> The symbols of the sides, the inverse of `new_pattern`.
   pure function side_symbols(sides) result(symbols)
      !> +1 right, any other number left.
      integer, intent(in) :: sides(:)
      character(size(sides)) :: symbols
      integer :: i

      do i = 1, size(sides)
         symbols(i:i) = merge('R', 'L', sides(i) > 0)
      end do
   end function side_symbols

   !> The pattern of symbols R and L; a star after a symbol stands for accumulation and rest (2,
   !! -2).
   pure function starred_pattern(symbols, cycles) result(pattern)
      !> Symbols R and L in order, each followed by a star if it stands for accumulation and rest.
      character(*), intent(in) :: symbols
      !> Load cycles k in one period.
      integer, intent(in) :: cycles
      type(pattern_type) :: pattern
      integer :: sides(len(symbols)), i, n

      pattern = new_pattern(symbols, cycles)
      n = 0
      do i = 1, len(symbols)
         if (symbols(i:i) == '*' .and. n > 0) then
            if (abs(sides(n)) == 1) then
               sides(n) = 2*sides(n)
               cycle
            end if
         end if
         n = n + 1
         sides(n) = pattern%sides(i)
      end do
      pattern%sides = sides(:n)
   end function starred_pattern

   !> The symbols of the sides, the inverse of `starred_pattern`.
   pure function starred_symbols(sides) result(symbols)
      !> +1 right, -1 left; +2, -2 for accumulation and rest there.
      integer, intent(in) :: sides(:)
      character(size(sides) + count(abs(sides) > 1)) :: symbols
      integer :: i, n

      n = 0
      do i = 1, size(sides)
         n = n + 1
         symbols(n:n) = merge('R', 'L', sides(i) > 0)
         if (abs(sides(i)) < 2) cycle
         n = n + 1
         symbols(n:n) = '*'
      end do
   end function starred_symbols

   !> The coefficient of restitution of each impact if it depends on the wall alone.
   elemental real(wp) function default_restitution(side, right_value, &
      left_value) result(restitution)
      !> +1 right, -1 left.
      integer, intent(in) :: side
      !> Coefficients of restitution R1 (right wall), R2 (left wall).
      real(wp), intent(in) :: right_value, left_value

      restitution = merge(right_value, left_value, side > 0)
   end function default_restitution

end module vi_pattern
