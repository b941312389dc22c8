!> Few linear equations in a few more unknowns: one solution, and the directions that are left free.
!!
!! At these sizes the calls of a library would take most of the time.
module vi_linear
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: add, eliminate

   !> Most unknowns, and most directions that may be left free.
   integer, parameter, public :: most_numbers = 50, most_free = 2

   type, public :: linear_type
      !> Equations so far: row(:, i) . step = right(i).
      integer :: m = 0
      real(wp) :: row(most_numbers, most_numbers), right(most_numbers)
      !> After elimination: changes of the unknowns along which all equations go on to hold.
      integer :: n_free = 0
      real(wp) :: free(most_numbers, most_free)
   end type linear_type

contains

   !> Adds an equation.
   pure subroutine add(linear, row, right)
      type(linear_type), intent(inout) :: linear
      real(wp), intent(in) :: row(:), right

      linear%m = linear%m + 1
      linear%row(:size(row), linear%m) = row
      linear%right(linear%m) = right
   end subroutine add

   !> Solves the equations, of which nothing is left, by Gauss-Jordan elimination.
   !!
   !! The greatest coefficient of an equation tells which unknown it gives; those that no equation
   !! gives are free, and zero in the solution.
   pure subroutine eliminate(linear, n, step, regular)
      type(linear_type), intent(inout) :: linear
      !> Unknowns.
      integer, intent(in) :: n
      real(wp), intent(out) :: step(:)
      logical, intent(out) :: regular
      real(wp) :: factor, scale(most_numbers)
      integer :: given(most_numbers), by(most_numbers), i, j, k

      regular = .false.
      do i = 1, linear%m
         scale(i) = maxval(abs(linear%row(:n, i)))
      end do
      by(:n) = 0
      do i = 1, linear%m
         k = maxloc(abs(linear%row(:n, i)), dim=1)
         ! also false where something is not a number
         factor = linear%row(k, i)
         if (.not. (abs(factor) > 1.0e-14_wp*scale(i) .and. abs(factor) <= huge(factor))) return
         given(i) = k
         by(k) = i
         linear%row(:n, i) = linear%row(:n, i)/factor
         linear%right(i) = linear%right(i)/factor
         do j = 1, linear%m
            factor = linear%row(k, j)
            if (j == i .or. .not. abs(factor) > 0) cycle
            linear%row(:n, j) = linear%row(:n, j) - factor*linear%row(:n, i)
            linear%row(k, j) = 0
            linear%right(j) = linear%right(j) - factor*linear%right(i)
         end do
      end do
      regular = .true.
      step(:n) = 0
      step(given(:linear%m)) = linear%right(:linear%m)
      linear%n_free = 0
      do k = 1, n
         if (by(k) > 0) cycle
         linear%n_free = linear%n_free + 1
         associate (free => linear%free(:, linear%n_free))
            free(:n) = 0
            free(given(:linear%m)) = -linear%row(k, :linear%m)
            free(k) = 1
         end associate
      end do
   end subroutine eliminate

end module vi_linear
