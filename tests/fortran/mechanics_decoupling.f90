!> The pairs of a structure compared with its matrices, and the matrices that are refused.
module mechanics_decoupling
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, draw_log, random_type
   use vi_columns, only: solve_columns
   use vi_decoupling, only: decouple, decoupled_type
   use vi_kinds, only: wp
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: test_decoupling

   type(random_type) :: random

contains

   subroutine test_decoupling()
      call test_pairs()
      call test_free_masses()
      call test_pairs_of_two()
      call test_units_of_time()
      call test_refusals()
      call test_too_stiff()
      call test_columns()
   end subroutine test_decoupling

   !> Random springs and dampers between masses, or to the ground.
   subroutine add_links(links, least, most, grounded, matrix)
      integer, intent(in) :: links
      !> Range of their numbers.
      real(wp), intent(in) :: least, most
      !> Whether some of them are connected to the ground.
      logical, intent(in) :: grounded
      real(wp), intent(inout) :: matrix(:, :)
      real(wp) :: along(size(matrix, 1))
      integer :: i, j, k, n

      n = size(matrix, 1)
      do k = 1, links
         along = 0
         i = draw_integer(random, 1, n)
         j = draw_integer(random, 1, n)
         if (i == j .and. .not. grounded) cycle
         along(i) = 1
         if (i /= j) along(j) = -1
         matrix = matrix + draw_log(random, least, most)*spread(along, 2, n)*spread(along, 1, n)
      end do
   end subroutine add_links

   !> Structures with few links have several bodies and modes of frequency 0; those with strong
   !! dampers have real eigenvalues.
   subroutine test_pairs()
      real(wp), parameter :: dampers(4) = [0.0_wp, 0.1_wp, 3.0_wp, 30.0_wp]
      type(decoupled_type) :: parts
      real(wp), allocatable :: mass(:, :), damping(:, :), stiffness(:, :)
      integer :: i, k, n, refused, status

      refused = 0
      do i = 1, 2000
         n = draw_integer(random, 1, 5)
         allocate (mass(n, n), damping(n, n), stiffness(n, n), source=0.0_wp)
         do k = 1, n
            mass(k, k) = draw_log(random, 0.1_wp, 10.0_wp)
         end do
         if (mod(i, 3) == 0) call add_links(1, 0.1_wp, 1.0_wp, .false., mass)
         call add_links(draw_integer(random, 0, 2*n), 0.1_wp, 10.0_wp, mod(i, 2) == 0, stiffness)
         k = mod(i, size(dampers)) + 1
         if (k > 1) call add_links(draw_integer(random, 1, n), 0.1_wp*dampers(k), dampers(k), &
            mod(i, 5) > 1, damping)
         if (mod(i, 7) == 0) damping = 0.3_wp*stiffness + 0.2_wp*mass
         call decouple(mass, damping, stiffness, parts, status)
         if (status == stat%ok) then
            call check_pairs(mass, damping, stiffness, parts)
            if (mod(i, 7) == 0) call check(parts%classical, 'pairs: damping as mass and stiffness')
         else
            call check(status == stat%defective, 'pairs: refused only where eigenvectors coincide')
            refused = refused + 1
         end if
         deallocate (mass, damping, stiffness)
      end do
      call check(refused < 20, 'pairs: few are refused')
   end subroutine test_pairs

   !> x' = v, v' = -omega^2 x - 2 sigma v solves M q'' + C q' + K q = 0, q' is the derivative of q,
   !! and the change of coordinates has its inverse.
   subroutine check_pairs(mass, damping, stiffness, parts)
      real(wp), intent(in) :: mass(:, :), damping(:, :), stiffness(:, :)
      type(decoupled_type), intent(in) :: parts
      real(wp), parameter :: rounding = 1e-9_wp
      real(wp), dimension(size(mass, 1), size(mass, 1)) :: of_x, of_v, terms, unit
      integer :: i, j, n

      n = size(mass, 1)
      call check(all(parts%stiffness >= 0) .and. all(parts%damping >= 0), 'pairs: not negative')
      associate (omega2 => spread(parts%stiffness, 1, n), drag => spread(2*parts%damping, 1, n), &
         qx => parts%qx, qv => parts%qv, dx => parts%dx, dv => parts%dv)
         call check(all(abs(dx + omega2*qv) <= rounding*maxval(abs(qx) + abs(dv))*max(omega2, &
            drag, 1.0_wp)), 'pairs: velocities from x')
         call check(all(abs(dv - qx + drag*qv) <= rounding*(maxval(abs(dv)) + maxval(abs(qx)) &
            + drag*maxval(abs(qv)))), 'pairs: velocities from v')
         of_x = matmul(mass, -omega2*dv) + matmul(damping, dx) + matmul(stiffness, qx)
         terms = matmul(mass, omega2*abs(dv)) + matmul(abs(damping), abs(dx)) &
            + matmul(abs(stiffness), abs(qx))
         call check(all(abs(of_x) <= rounding*(terms + maxval(terms))), 'pairs: forces of x')
         of_v = matmul(mass, dx - drag*dv) + matmul(damping, dv) + matmul(stiffness, qv)
         terms = matmul(abs(mass), abs(dx) + drag*abs(dv)) + matmul(abs(damping), abs(dv)) &
            + matmul(abs(stiffness), abs(qv))
         call check(all(abs(of_v) <= rounding*(terms + maxval(terms))), 'pairs: forces of v')
         unit = 0
         do i = 1, n
            unit(i, i) = 1
         end do
         call check(all(abs(matmul(qx, parts%xq) + matmul(qv, parts%vq) - unit) < rounding) .and. &
            all(abs(matmul(dx, parts%xd) + matmul(dv, parts%vd) - unit) < rounding), &
            'pairs: to pairs and back')
         do j = 1, n
            do i = 1, n
               if (parts%body(i) == parts%body(j)) cycle
               call check(abs(qx(i, j)) + abs(qv(i, j)) + abs(dx(i, j)) + abs(dv(i, j)) <= 0 .and. &
                  abs(stiffness(i, j)) + abs(damping(i, j)) + abs(mass(i, j)) <= 0, &
                  'pairs: bodies are separate')
            end do
         end do
         if (parts%classical) call check(all(abs(qv) + abs(dx) + abs(parts%xd) + abs(parts%vq) &
            <= 0), 'pairs: classical')
      end associate
   end subroutine check_pairs

   !> Masses without springs, coupled by dampers: one pair for each, with the sum of the decay rates
   !! of the dampers over the masses, and one drag fewer than masses in each body.
   subroutine test_free_masses()
      type(decoupled_type) :: parts
      real(wp) :: mass(4, 4), damping(4, 4), stiffness(4, 4)
      integer :: i, k, status

      do i = 1, 200
         mass = 0
         damping = 0
         stiffness = 0
         do k = 1, 4
            mass(k, k) = draw_log(random, 0.1_wp, 10.0_wp)
         end do
         call add_links(draw_integer(random, 0, 6), 0.1_wp, 10.0_wp, .false., damping)
         call decouple(mass, damping, stiffness, parts, status)
         call check(status == stat%ok, 'free masses: status')
         call check_pairs(mass, damping, stiffness, parts)
         call check(all(parts%stiffness <= 0), 'free masses: no frequency')
         call check_close(2*sum(parts%damping), sum([(damping(k, k)/mass(k, k), k=1, 4)]), &
            1e-11_wp*sum(parts%damping), 'free masses: the sum of the drags')
         call check(count(.not. parts%damping > 0) == maxval(parts%body), &
            'free masses: each body moves on without drag')
      end do
   end subroutine test_free_masses

   !> Two masses with one damper of the strength at which two complex pairs coincide, with their
   !! eigenvectors: (lambda^2 + 0.2 lambda + 1)^2 = 0. They are refused; a little farther away they
   !! are not.
   subroutine test_pairs_of_two()
      type(decoupled_type) :: parts
      real(wp), parameter :: offsets(4) = [0.0_wp, 1e-12_wp, 1e-2_wp, -1e-2_wp]
      real(wp) :: mass(2, 2), damping(2, 2), stiffness(2, 2)
      integer :: i, status

      mass = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2])
      stiffness = reshape([1.04_wp, 0.2_wp, 0.2_wp, 1.0_wp], [2, 2])
      do i = 1, size(offsets)
         damping = reshape([0.4_wp + offsets(i), 0.0_wp, 0.0_wp, 0.0_wp], [2, 2])
         call decouple(mass, damping, stiffness, parts, status)
         call check(status == merge(stat%defective, stat%ok, i <= 2), 'two pairs that coincide')
         if (status == stat%ok) call check_pairs(mass, damping, stiffness, parts)
      end do
   end subroutine test_pairs_of_two

   !> Free bodies with springs and dampers of all sizes: pairs in another unit of time have omega^2,
   !! sigma and velocities in that unit, digit by digit if it is a power of 2, and none is refused.
   subroutine test_units_of_time()
      integer, parameter :: powers(4) = [-40, -10, 10, 40]
      type(decoupled_type) :: parts, scaled
      real(wp), allocatable :: mass(:, :), damping(:, :), stiffness(:, :)
      real(wp) :: unit
      integer :: i, j, k, n, status

      do i = 1, 300
         n = draw_integer(random, 2, 8)
         allocate (mass(n, n), damping(n, n), stiffness(n, n), source=0.0_wp)
         do k = 1, n
            mass(k, k) = draw_log(random, 0.01_wp, 100.0_wp)
         end do
         call add_links(draw_integer(random, 0, 3*n), 0.01_wp, 100.0_wp, .false., stiffness)
         call add_links(draw_integer(random, 1, 3*n), 0.01_wp, 100.0_wp, .false., damping)
         call decouple(mass, damping, stiffness, parts, status)
         call check(status == stat%ok, 'units of time: not refused')
         do k = 1, size(powers)
            unit = 2.0_wp**powers(k)
            call decouple(mass, damping*unit, stiffness*unit**2, scaled, status)
            call check(status == stat%ok, 'units of time: not refused in another unit')
            if (status /= stat%ok) cycle
            call check(alike(reshape(scaled%stiffness, [n, 1]), unit**2* &
               reshape(parts%stiffness, [n, 1])) .and. alike(reshape(scaled%damping, [n, 1]), &
               unit*reshape(parts%damping, [n, 1])), 'units of time: rates')
            ! the unit of a pair is arbitrary: its share in positions and velocities is the same
            do j = 1, n
               call check(alike(share(scaled%qx, scaled%xq, j), share(parts%qx, parts%xq, j)) &
                  .and. alike(share(scaled%dv, scaled%vd, j), share(parts%dv, parts%vd, j)) .and. &
                  alike(share(scaled%dx, scaled%xq, j), unit*share(parts%dx, parts%xq, j)), &
                  'units of time: shapes')
            end do
         end do
         deallocate (mass, damping, stiffness)
      end do
   end subroutine test_units_of_time

   !> Whether two matrices are equal but for a few rounding errors of the largest entry.
   pure logical function alike(a, b)
      !> The matrices.
      real(wp), intent(in) :: a(:, :), b(:, :)

      alike = all(abs(a - b) <= 64*epsilon(1.0_wp)*maxval(abs(b)))
   end function alike

   !> The contribution of a pair from one quantity to another one.
   pure function share(from_pairs, to_pairs, j) result(product)
      !> From pairs, and to them.
      real(wp), intent(in) :: from_pairs(:, :), to_pairs(:, :)
      !> The number of the pair.
      integer, intent(in) :: j
      real(wp) :: product(size(from_pairs, 1), size(to_pairs, 2))

      product = spread(from_pairs(:, j), 2, size(to_pairs, 2))*spread(to_pairs(j, :), 1, &
         size(from_pairs, 1))
   end function share

   !> Refused bodies, each before or after a valid one, and bodies just inside the limits.
   subroutine test_refusals()
      real(wp), parameter :: unit(2, 2) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2]), &
         none(2, 2) = 0
      real(wp) :: near
      integer :: k

      do k = -1, 1
         ! the least eigenvalue is -0.1, 0, or 0.1
         near = 1 - 0.1_wp*k
         call expect(pair(near), none, unit, merge(stat%ok, stat%mass_not_definite, k > 0))
         call expect(unit, none, pair(near), merge(stat%ok, stat%negative_stiffness, k >= 0))
         if (k >= 0) call expect(unit, pair(near), unit, stat%ok)
         call expect(unit, pair(near), none, merge(stat%ok, stat%negative_stiffness, k >= 0))
         call expect(diagonal(0.1_wp*k), none, unit, merge(stat%ok, stat%mass_not_definite, k > 0))
         call expect(unit, none, diagonal(0.1_wp*k), merge(stat%ok, stat%negative_stiffness, &
            k >= 0))
         call expect(unit, diagonal(0.1_wp*k), unit, merge(stat%ok, stat%negative_stiffness, &
            k >= 0))
      end do
   contains
      !> Eigenvalues 1 - off and 1 + off.
      pure function pair(off)
         real(wp), intent(in) :: off
         real(wp) :: pair(2, 2)

         pair = reshape([1.0_wp, off, off, 1.0_wp], [2, 2])
      end function pair

      !> Eigenvalues 1 and another.
      pure function diagonal(other)
         real(wp), intent(in) :: other
         real(wp) :: diagonal(2, 2)

         diagonal = reshape([1.0_wp, 0.0_wp, 0.0_wp, other], [2, 2])
      end function diagonal

      subroutine expect(mass, damping, stiffness, status)
         real(wp), intent(in) :: mass(2, 2), damping(2, 2), stiffness(2, 2)
         integer, intent(in) :: status
         type(decoupled_type) :: parts
         integer :: found, at

         do at = 1, 3, 2
            call decouple(beside(mass, 1.0_wp, at), beside(damping, 0.1_wp, at), &
               beside(stiffness, 1.0_wp, at), parts, found)
            call check(found == status, 'refusals: status')
            if (found == stat%ok) call check_pairs(beside(mass, 1.0_wp, at), beside(damping, &
               0.1_wp, at), beside(stiffness, 1.0_wp, at), parts)
         end do
      end subroutine expect

      !> A matrix with another body at the beginning or at the end.
      pure function beside(matrix, other, at) result(both)
         real(wp), intent(in) :: matrix(2, 2), other
         !> Where the other body is: 1 or 3.
         integer, intent(in) :: at
         real(wp) :: both(3, 3)

         both = 0
         both(at, at) = other
         if (at == 1) both(2:, 2:) = matrix
         if (at == 3) both(:2, :2) = matrix
      end function beside
   end subroutine test_refusals

   !> Two masses coupled by a stiff spring, on a soft one: the slow mode loses the digits by which
   !! the springs differ. With too few digits left it is refused, and with none it has frequency 0.
   subroutine test_too_stiff()
      type(decoupled_type) :: parts
      real(wp) :: mass(2, 2), stiffness(2, 2), none(2, 2)
      real(wp), parameter :: stiff(5) = [1e3_wp, 1e6_wp, 1e10_wp, 1e12_wp, 1e18_wp]
      integer :: i, status

      mass = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2])
      none = 0
      do i = 1, size(stiff)
         stiffness = stiff(i)*reshape([1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp], [2, 2])
         stiffness(2, 2) = stiffness(2, 2) + 1
         call decouple(mass, none, stiffness, parts, status)
         call check(status == merge(stat%too_stiff, stat%ok, i == 3 .or. i == 4), 'too stiff')
         if (status /= stat%ok) cycle
         call check_close(minval(parts%stiffness), merge(0.0_wp, 0.5_wp, i == 5), &
            0.2_wp/stiff(i) + 1e-15_wp*stiff(i)*merge(0, 1, i == 5), 'stiff: the slow mode')
      end do
      ! damping that couples a slow mode and one that is faster by eleven orders of magnitude; with
      ! eight orders there are digits left
      do i = 1, 2
         stiffness = reshape([merge(1e16_wp, 1e22_wp, i == 1), 0.0_wp, 0.0_wp, 1.0_wp], [2, 2])
         call decouple(mass, reshape([1e6_wp, 0.1_wp, 0.1_wp, 0.2_wp], [2, 2]), stiffness, parts, &
            status)
         call check(status == merge(stat%ok, stat%too_stiff, i == 1), 'too stiff for the damping')
      end do
   end subroutine test_too_stiff

   !> Systems of equations: a diagonal divides exactly, and a singular matrix is refused.
   subroutine test_columns()
      real(wp) :: right(2, 3), matrix(2, 2)
      integer :: status

      right = reshape([1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 5.0_wp, 6.0_wp], [2, 3])
      call solve_columns(reshape([3.0_wp, 0.0_wp, 0.0_wp, 7.0_wp], [2, 2]), right, status)
      call check(status == stat%ok .and. all(abs(right - reshape([1/3.0_wp, 2/7.0_wp, 1.0_wp, &
         4/7.0_wp, 5/3.0_wp, 6/7.0_wp], [2, 3])) <= 0), 'columns: a diagonal')
      matrix = reshape([1.0_wp, 2.0_wp, 3.0_wp, 5.0_wp], [2, 2])
      right(:, 1:2) = matmul(matrix, reshape([1.0_wp, -1.0_wp, 2.0_wp, 0.5_wp], [2, 2]))
      right(:, 3) = 0
      call solve_columns(matrix, right, status)
      call check(status == stat%ok .and. maxval(abs(right - reshape([1.0_wp, -1.0_wp, 2.0_wp, &
         0.5_wp, 0.0_wp, 0.0_wp], [2, 3]))) < 1e-14_wp, 'columns: solutions')
      call solve_columns(reshape([1.0_wp, 2.0_wp, 2.0_wp, 4.0_wp], [2, 2]), right, status)
      call check(status == stat%singular, 'columns: rows that depend on each other')
      call solve_columns(reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [2, 2]), right, status)
      call check(status == stat%singular, 'columns: a row of zeros')
   end subroutine test_columns

end module mechanics_decoupling
