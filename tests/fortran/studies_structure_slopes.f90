!> Derivatives of the equations of a structure's motions by parameters: closed forms compared with
!! differences.
module studies_structure_slopes
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, fill, random_type
   use vi_family, only: new_family, repetition_type
   use vi_kinds, only: wp
   use vi_orbit, only: family_type
   use vi_pattern, only: pattern_type
   use vi_restitution, only: power_law
   use vi_status, only: stat
   use vi_structure, only: check_structure, load_type, new_load, new_structure, structure_type
   use vi_structure_members, only: free_unknowns, member_type, set_member, set_sides, &
      structure_members_type
   use vi_structure_path, only: change_type, new_change, new_function
   use vi_structure_slopes, only: by_differences, equations_by_parameter
   implicit none (type, external)
   private

   public :: test_structure_slopes

   character(11), parameter :: names(6) = [character(11) :: 'frequency', 'load', 'constant', &
      'opening_0', 'restitution', 'function']

   type(random_type) :: random

contains

   subroutine test_structure_slopes()
      type(structure_members_type) :: s
      type(family_type) :: family
      integer :: compared(size(names)), i, k

      compared = 0
      do i = 1, 300
         call random_family(i, s, family)
         do k = 1, size(names)
            call compare(s, family, k, compared(k))
         end do
      end do
      call check(all(compared > 100), 'slopes of structures: all parameters are compared')
   end subroutine test_structure_slopes

   !> A chain of hosts with a particle between two walls on the last one, with and without springs
   !! and drags on the particle.
   subroutine random_family(number, s, family)
      integer, intent(in) :: number
      type(structure_members_type), intent(out) :: s
      type(family_type), intent(out) :: family
      type(repetition_type), allocatable :: repetitions(:)
      type(pattern_type) :: pattern
      real(wp), allocatable :: matrices(:, :, :), directions(:, :), harmonics(:, :, :), constant(:)
      real(wp), parameter :: link(2, 2) = reshape([1, -1, -1, 1], [2, 2])
      real(wp) :: laws(6, 2)
      integer :: i, n, status
      logical :: mirror, possible

      n = draw_integer(random, 2, 4)
      mirror = mod(number, 4) == 0
      allocate (matrices(n, n, 3), directions(n, 2), harmonics(n, 2, 2), constant(n), source=0.0_wp)
      do i = 1, n
         matrices(i, i, 1) = draw(random, 0.2_wp, 2.0_wp)
         if (i == n) exit
         matrices(i, i, 2) = draw(random, 0.01_wp, 0.2_wp)
         matrices(i, i, 3) = draw(random, 0.5_wp, 2.0_wp)
      end do
      do i = 1, n - 2
         call connect(i, i + 1)
      end do
      ! a drag that is small or large over a period, a dashpot or a spring to the host, or none
      if (mod(number, 3) == 0) matrices(n, n, 2) = 10**draw(random, -3.0_wp, 0.5_wp)
      if (mod(number, 5) == 0) call connect(n - 1, n)
      if (mod(number, 7) == 0) call damp(n - 1, n)
      directions(n - 1, 1) = -1
      directions(n, 1) = 1
      directions(:, 2) = -directions(:, 1)
      call fill(random, -1.0_wp, 1.0_wp, harmonics(:, 1, 1))
      call fill(random, -1.0_wp, 1.0_wp, harmonics(:, 2, 1))
      if (.not. mirror) then
         call fill(random, -1.0_wp, 1.0_wp, harmonics(:, 1, 2))
         call fill(random, -1.0_wp, 1.0_wp, constant)
      end if
      laws(:, 1) = [draw(random, 0.5_wp, 3.0_wp), real(power_law, wp), draw(random, 0.3_wp, &
         0.9_wp), 1.3_wp, 0.25_wp, 1.0_wp]
      laws(:, 2) = laws(:, 1)
      s%path%structure = new_structure(matrices, directions, laws)
      call check_structure(s%path%structure, status)
      call check(status == stat%ok, 'slopes of structures: a structure')
      s%path%load = new_load(draw(random, 0.5_wp, 2.5_wp), harmonics, constant)
      call set_sides(s)
      s%speed = 0.7_wp
      s%length = 1.3_wp
      s%p = merge(0, 1, mod(number, 5) == 0)
      allocate (s%free(n, s%p), source=0.0_wp)
      if (s%p > 0) s%free(n, 1) = 1
      pattern%sides = merge([1, 1, -1, -1], [1, -1, 1, -1], mirror)
      pattern%cycles = merge(1, 2, mirror)
      call new_family(pattern, mirror, mirror, family, repetitions, possible)
   contains
      !> A spring and a dashpot between two coordinates.
      subroutine connect(i, j)
         integer, intent(in) :: i, j
         real(wp) :: k

         k = draw(random, 0.3_wp, 1.0_wp)
         matrices([i, j], [i, j], 3) = matrices([i, j], [i, j], 3) + k*link
         call damp(i, j)
      end subroutine connect

      !> A dashpot between two coordinates.
      subroutine damp(i, j)
         integer, intent(in) :: i, j

         matrices([i, j], [i, j], 2) = matrices([i, j], [i, j], 2) &
            + draw(random, 0.01_wp, 0.2_wp)*link
      end subroutine damp
   end subroutine random_family

   !> One parameter at random unknowns, which need not be those of a motion.
   subroutine compare(s, family, k, compared)
      type(structure_members_type), intent(inout) :: s
      type(family_type), intent(in) :: family
      integer, intent(in) :: k
      integer, intent(inout) :: compared
      type(change_type) :: change
      type(member_type) :: member
      real(wp) :: unknowns(2*size(family%sides) + free_unknowns(s, family)), share(1)
      real(wp), dimension(size(unknowns)) :: closed, differences
      character(:), allocatable :: message
      integer :: i, n
      logical :: good

      n = size(family%sides)
      call start_at(s, k, change, message)
      if (names(k) == 'constant' .and. len(message) > 0) return
      call check(len(message) == 0, 'slopes of structures: '//trim(names(k))//message)
      if (allocated(s%path%changes)) deallocate (s%path%changes)
      allocate (s%path%changes(1))
      s%path%changes(1) = change
      share = draw(random, 0.1_wp, 0.9_wp)
      do i = 1, n
         unknowns(i) = sign(1, family%sides(i))*draw(random, 0.1_wp, 2.0_wp)
         unknowns(n + i) = (i + draw(random, 0.1_wp, 0.9_wp))*1.5_wp
      end do
      call fill(random, -1.0_wp, 1.0_wp, unknowns(2*n + 1:))
      call set_member(s, family, unknowns, share, member)
      if (.not. member%exists) return
      call equations_by_parameter(s, family, unknowns, share, member, 1, closed, good)
      call check(good, 'slopes of structures: there are closed forms')
      call by_differences(s, family, unknowns, share, 1, differences, good)
      call check_close(maxval(abs(closed - differences)), 0.0_wp, 3.0e-8_wp*(1 + maxval(abs( &
         differences))), 'slopes of structures: '//trim(names(k)))
      compared = compared + 1
   end subroutine compare

   !> A parameter of a family; a function changes many entries.
   subroutine start_at(s, k, change, message)
      type(structure_members_type), intent(in) :: s
      integer, intent(in) :: k
      type(change_type), intent(out) :: change
      character(:), allocatable, intent(out) :: message
      ! kinds opening, restitution, frequency, cosine, sine and constant
      integer, parameter :: entries(3, 6) = reshape([5, 2, 0, 6, 1, 0, 7, 0, 0, 8, 1, 2, 9, 2, 1, &
         10, 2, 0], [3, 6])
      real(wp) :: series(4, 6)

      if (names(k) /= 'function') then
         call new_change(trim(names(k)), [0.5_wp, 0.9_wp], s%path%structure, s%path%load, change, &
            message)
         return
      end if
      call fill(random, -0.1_wp, 0.1_wp, series(2, :))
      call fill(random, -0.1_wp, 0.1_wp, series(4, :))
      series(3, :) = 0.05_wp
      ! at the middle of the bounds the polynomials are 1, 0, -1 and 0
      associate (structure => s%path%structure, load => s%path%load)
         series(1, :) = series(3, :) + [structure%openings(2), structure%restitution(1), &
            load%frequency, load%cosine(1, 2), load%sine(2, 1), load%constant(2)]
      end associate
      call new_function(entries, series, [0.0_wp, 2.0_wp], 1.0_wp, s%path%structure, s%path%load, &
         change, message)
   end subroutine start_at

end module studies_structure_slopes
