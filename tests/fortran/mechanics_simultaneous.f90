!> Impulses where several coupled gaps close simultaneously: touching balls that are free.
module mechanics_simultaneous
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, draw_log, random_type
   use vi_kinds, only: wp
   use vi_simultaneous, only: newton_impulses
   use vi_status, only: stat
   use vi_structure, only: check_structure, new_structure, structure_type
   implicit none (type, external)
   private

   public :: test_simultaneous

contains

   subroutine test_simultaneous()
      type(random_type) :: random
      integer :: i

      do i = 1, 2000
         call test_row(random, .true.)
         call test_row(random, .false.)
      end do
      call test_cradle()
   end subroutine test_simultaneous

   !> A row of balls with a gap between each two of them.
   subroutine new_row(masses, restitution, structure)
      real(wp), intent(in) :: masses(:), restitution(:)
      type(structure_type), intent(out) :: structure
      real(wp) :: matrices(size(masses), size(masses), 3)
      real(wp) :: directions(size(masses), size(restitution)), values(2, size(restitution))
      integer :: i, status

      matrices = 0
      directions = 0
      do i = 1, size(masses)
         matrices(i, i, 1) = masses(i)
      end do
      do i = 1, size(restitution)
         directions(i:i + 1, i) = [1.0_wp, -1.0_wp]
      end do
      values(1, :) = 0
      values(2, :) = restitution
      structure = new_structure(matrices, directions, values)
      call check_structure(structure, status)
      call check(status == stat%ok, 'balls: the structure')
   end subroutine new_row

   !> Newton's law at all gaps of a touching row, momentum, and energy: it is conserved if R = 1,
   !! not gained if all R are equal, and where it would be gained the status reports it.
   subroutine test_row(random, equal)
      type(random_type), intent(inout) :: random
      logical, intent(in) :: equal
      type(structure_type) :: structure
      real(wp), allocatable, dimension(:) :: masses, restitution, rate, after, closing, parting, &
         impulses
      real(wp) :: before, gained, left
      integer :: i, n, status

      n = draw_integer(random, 3, 7)
      allocate (masses(n), rate(n), restitution(n - 1), impulses(n - 1))
      do i = 1, n
         masses(i) = draw_log(random, 0.1_wp, 10.0_wp)
         rate(i) = draw(random, -1.0_wp, 1.0_wp)
      end do
      do i = 1, n - 1
         restitution(i) = draw(random, 0.0_wp, 1.0_wp)
      end do
      if (equal) restitution = restitution(1)
      if (equal .and. rate(1) > 0.5_wp) restitution = 1
      call new_row(masses, restitution, structure)
      closing = matmul(transpose(structure%directions), rate)
      call newton_impulses(structure, [(i, i=1, n - 1)], closing, [(1.0e-14_wp, i=1, n - 1)], &
         impulses, status)
      after = rate - matmul(structure%mobility, impulses)
      parting = matmul(transpose(structure%directions), after)
      before = 0.5_wp*sum(masses*rate**2)
      gained = 0.5_wp*sum(masses*after**2) - before
      call check(status == stat%ok .or. status == stat%gains_energy, 'balls: the status')
      call check(all(impulses >= 0), 'balls: impulses push')
      ! a gap without an impulse may separate faster
      left = maxval(parting + restitution*closing)
      call check(left <= 1.0e-12_wp, 'balls: each gap parts at R times its speed at least')
      left = maxval(abs(impulses*(parting + restitution*closing)))
      call check_close(left, 0.0_wp, 1.0e-12_wp*max(1.0_wp, maxval(impulses)), &
         'balls: an impulse goes with R times the speed')
      call check_close(sum(masses*after), sum(masses*rate), 1.0e-13_wp*sum(masses), &
         'balls: momentum')
      ! Kelvin and Tait: the work of impulses at the mean of the speeds before and after
      call check_close(gained, -0.5_wp*dot_product(impulses, closing + parting), &
         1.0e-12_wp*before, 'balls: the work of the impulses')
      if (equal) call check(gained <= 1.0e-13_wp*before, 'balls: equal R gain no energy')
      if (equal .and. restitution(1) >= 1) call check_close(gained, 0.0_wp, 1.0e-12_wp*before, &
         'balls: R = 1 keeps energy')
      if (abs(gained) > 1.0e-9_wp*before) call check((status == stat%gains_energy) .eqv. &
         gained > 0, 'balls: an impact that gains energy is named')
   end subroutine test_row

   !> One ball at speed 1 against two equal touching ones: -1/3, 2/3, 2/3 for R = 1, and in
   !! general (1 - 2 R)/3, (1 + R)/3, (1 + R)/3, by w = -R v and momentum.
   subroutine test_cradle()
      type(structure_type) :: structure
      real(wp) :: after(3), impulses(2), r
      integer :: i, status

      do i = 0, 10
         r = 0.1_wp*i
         call new_row([1.0_wp, 1.0_wp, 1.0_wp], [r, r], structure)
         call newton_impulses(structure, [1, 2], [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], impulses, &
            status)
         after = [1.0_wp, 0.0_wp, 0.0_wp] - matmul(structure%mobility, impulses)
         call check(status == stat%ok, 'cradle: the status')
         call check_close(after(1), (1 - 2*r)/3, 1.0e-15_wp, 'cradle: the first ball')
         call check_close(after(2), (1 + r)/3, 1.0e-15_wp, 'cradle: the second ball')
         call check_close(after(3), (1 + r)/3, 1.0e-15_wp, 'cradle: the third ball')
      end do
   end subroutine test_cradle

end module mechanics_simultaneous
