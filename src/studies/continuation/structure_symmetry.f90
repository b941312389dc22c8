!> Symmetries of a structure that a motion can have half a period later: q(t + T/2) = S q(t).
!!
!! S is its own inverse. It keeps M, C and K, maps each gap onto one with the same opening and law,
!! and the load onto the load at that time: exchanged units or a reversed chain, also with the
!! opposite sign. The order of the impacts says which gaps it exchanges. With the load this
!! determines S on all that M^-1 C and M^-1 K reach from there; nothing acts on the remainder.
module vi_structure_symmetry
   use vi_columns, only: solve_columns
   use vi_kinds, only: wp
   use vi_structure, only: load_type, structure_type
   use vi_structure_path, only: changed, moves_alike, same_law, structure_path_type
   implicit none (type, external)
   private

   public :: add_direction, even_and_odd, find_symmetry, near

   !> Directions that differ by less are the same, relative to their length, and matrices that
   !! differ by less.
   real(wp), parameter :: same_direction = 1.0e-6_wp, same_matrix = 1.0e-8_wp

contains

   !> The symmetry that exchanges impacts.
   pure subroutine find_symmetry(path, gaps, partners, cycles, matrix, image)
      !> The structure, complete, and what changes it; it is examined at two places.
      type(structure_path_type), intent(in) :: path
      !> The gaps of the impacts, and those onto which they are mapped; twice the load cycles that
      !! pass until then.
      integer, intent(in) :: gaps(:), partners(:), cycles
      !> (n, n) S; not allocated if there is none, or only the identity.
      real(wp), allocatable, intent(out) :: matrix(:, :)
      !> (gaps) The gap onto which each gap is mapped.
      integer, allocatable, intent(out) :: image(:)
      integer :: exchanged(size(path%structure%openings))
      real(wp), dimension(size(path%structure%mass, 1), size(path%structure%mass, 1)) :: y, z, s, &
         projection
      integer :: i, m
      logical :: good

      exchanged = 0
      do i = 1, size(gaps)
         if (all(exchanged(gaps(i)) /= [0, partners(i)])) return
         exchanged(gaps(i)) = partners(i)
      end do
      call reach(path, exchanged, cycles, y, z, m)
      projection = matmul(matmul(y(:, :m), transpose(y(:, :m))), path%structure%mass)
      ! on what nothing acts on, S may be the identity or its opposite
      do i = 1, -1, -2
         s = matmul(matmul(z(:, :m), transpose(y(:, :m))), path%structure%mass) &
            + i*(identity(size(s, 1)) - projection)
         where (abs(s - anint(s)) < same_matrix) s = anint(s)
         if (.not. all(abs(s) < huge(1.0_wp))) return
         ! what the motion reaches would stay as it is: the motion repeats itself
         if (near(s, identity(size(s, 1)))) return
         call examine(path, s, cycles, exchanged, image, good)
         if (good) then
            allocate (matrix, source=s)
            return
         end if
      end do
   end subroutine find_symmetry

   !> An orthonormal basis of all that impacts and load reach, with respect to M, and its image.
   pure subroutine reach(path, exchanged, cycles, y, z, m)
      !> The structure, and its load.
      type(structure_path_type), intent(in) :: path
      !> (gaps) The images of the gaps that are hit, 0 for others; cycles as in `find_symmetry`.
      integer, intent(in) :: exchanged(:), cycles
      !> (n, n) The first m columns: the basis and its image.
      real(wp), intent(out) :: y(:, :), z(:, :)
      !> Its dimension.
      integer, intent(out) :: m
      real(wp), dimension(size(y, 1), 2*size(y, 1) + 1 + 2*size(path%load%sine, 2)) :: right
      real(wp) :: signs(1 + 2*size(path%load%sine, 2))
      integer :: h, j, k, n, harmonics, status

      n = size(y, 1)
      harmonics = size(path%load%sine, 2)
      right(:, :n) = path%structure%damping
      right(:, n + 1:2*n) = path%structure%stiffness
      right(:, 2*n + 1) = path%load%constant
      signs(1) = 1
      do h = 1, harmonics
         right(:, 2*n + 2*h) = path%load%cosine(:, h)
         right(:, 2*n + 2*h + 1) = path%load%sine(:, h)
         signs(2*h:2*h + 1) = (-1)**modulo(h*cycles, 2)
      end do
      m = 0
      y = 0
      z = 0
      ! this succeeds: the mass matrix has been checked
      call solve_columns(path%structure%mass, right, status)
      do j = 1, size(exchanged)
         if (exchanged(j) == 0) cycle
         call add_direction(path%structure%mass, path%structure%mobility(:, exchanged(j)), &
            path%structure%mobility(:, j), y, z, m)
      end do
      do k = 1, size(signs)
         call add_direction(path%structure%mass, right(:, 2*n + k), signs(k)*right(:, 2*n + k), y, &
            z, m)
      end do
      k = 0
      do while (k < m)
         k = k + 1
         do h = 0, n, n
            call add_direction(path%structure%mass, matmul(right(:, h + 1:h + n), y(:, k)), &
               matmul(right(:, h + 1:h + n), z(:, k)), y, z, m)
         end do
      end do
   end subroutine reach

   !> Adds a direction and its image, unless it lies in the basis.
   pure subroutine add_direction(mass, direction, turned, y, z, m)
      !> (n, n) M.
      real(wp), intent(in) :: mass(:, :)
      !> (n) The direction and its image.
      real(wp), intent(in) :: direction(:), turned(:)
      !> In and out: the basis and its image in the first columns.
      real(wp), intent(inout) :: y(:, :), z(:, :)
      !> In and out: its dimension.
      integer, intent(inout) :: m
      real(wp), dimension(size(direction)) :: one, other
      real(wp) :: length, part
      integer :: i, k

      length = norm_of(mass, direction)
      if (.not. length > 0 .or. m == size(y, 2)) return
      one = direction/length
      other = turned/length
      ! twice, so that rounding leaves the basis orthogonal
      do i = 1, 2
         do k = 1, m
            part = dot_product(y(:, k), matmul(mass, one))
            one = one - part*y(:, k)
            other = other - part*z(:, k)
         end do
      end do
      length = norm_of(mass, one)
      if (length < same_direction) return
      m = m + 1
      y(:, m) = one/length
      z(:, m) = other/length
   end subroutine add_direction

   !> The length of a vector with respect to M.
   pure real(wp) function norm_of(mass, vector)
      !> (n, n), (n)
      real(wp), intent(in) :: mass(:, :), vector(:)

      norm_of = sqrt(max(0.0_wp, dot_product(vector, matmul(mass, vector))))
   end function norm_of

   !> Whether a matrix is a symmetry of the structure along the whole path.
   pure subroutine examine(path, s, cycles, exchanged, image, good)
      !> The structure and what changes it.
      type(structure_path_type), intent(in) :: path
      !> (n, n) S.
      real(wp), intent(in) :: s(:, :)
      !> As in `find_symmetry`; (gaps) what is known of the images, 0 where nothing is.
      integer, intent(in) :: cycles, exchanged(:)
      !> (gaps) The image of each gap.
      integer, allocatable, intent(out) :: image(:)
      !> Whether it is one.
      logical, intent(out) :: good
      type(structure_type) :: structure
      type(load_type) :: load
      real(wp), parameter :: shares(2) = [0.23_wp, 0.81_wp]
      real(wp), dimension(size(s, 1), size(s, 2)) :: across
      real(wp) :: unit
      integer :: h, i, j, k

      allocate (image(size(exchanged)), source=0)
      across = transpose(s)
      good = near(matmul(s, s), identity(size(s, 1)))
      do k = 1, size(shares)
         if (.not. good) return
         call changed(path, spread(shares(k), 1, size(path%changes)), structure, load)
         good = keeps(structure%mass) .and. keeps(structure%damping) .and. &
            keeps(structure%stiffness) .and. near(reshape(matmul(across, load%constant), &
            [size(s, 1), 1]), reshape(load%constant, [size(s, 1), 1]))
         do h = 1, size(load%sine, 2)
            unit = (-1)**modulo(h*cycles, 2)
            good = good .and. near(unit*matmul(across, load%cosine(:, h:h)), load%cosine(:, h:h)) &
               .and. near(unit*matmul(across, load%sine(:, h:h)), load%sine(:, h:h))
         end do
         if (.not. good) return
         do i = 1, size(image)
            image(i) = 0
            do j = 1, size(image)
               if (exchanged(i) > 0 .and. exchanged(i) /= j) cycle
               if (abs(structure%openings(i) - structure%openings(j)) > 1.0e-12_wp* &
                  abs(structure%openings(i))) cycle
               if (.not. same_law(structure, i, j)) cycle
               if (.not. moves_alike(structure, i, j, merge(1, -1, modulo(cycles, 2) == 0))) cycle
               if (near(matmul(across, structure%directions(:, i:i)), &
                  structure%directions(:, j:j))) image(i) = j
               if (image(i) > 0) exit
            end do
         end do
         good = all(image > 0)
         if (good) good = all(image(image) == [(i, i=1, size(image))])
      end do
   contains
      !> Whether the symmetry keeps a matrix.
      pure logical function keeps(matrix)
         !> (n, n)
         real(wp), intent(in) :: matrix(:, :)

         keeps = near(matmul(matmul(across, matrix), s), matrix)
      end function keeps
   end subroutine examine

   !> Whether two matrices are the same up to rounding.
   pure logical function near(one, other)
      !> The matrices.
      real(wp), intent(in) :: one(:, :), other(:, :)

      near = maxval(abs(one - other)) <= same_matrix*maxval(abs(other))
   end function near

   !> The identity.
   pure function identity(n) result(matrix)
      !> Number of rows.
      integer, intent(in) :: n
      real(wp) :: matrix(n, n)
      integer :: i

      matrix = 0
      do i = 1, n
         matrix(i, i) = 1
      end do
   end function identity

   !> Another basis of displacements, of which the symmetry keeps the first ones and reverses the
   !! others.
   pure subroutine even_and_odd(mass, s, displacements, even)
      !> (n, n) M and S.
      real(wp), intent(in) :: mass(:, :), s(:, :)
      !> In and out: (n, p) the basis; greatest entries 1.
      real(wp), intent(inout) :: displacements(:, :)
      !> Number of those that it keeps.
      integer, intent(out) :: even
      real(wp) :: y(size(s, 1), size(s, 1)), unused(size(s, 1), size(s, 1)), part(size(s, 1))
      integer :: i, k, m

      m = 0
      y = 0
      do i = 1, -1, -2
         do k = 1, size(displacements, 2)
            part = displacements(:, k) + i*matmul(s, displacements(:, k))
            ! rounding is no direction
            if (norm_of(mass, part) < same_direction*norm_of(mass, displacements(:, k))) cycle
            call add_direction(mass, part, part, y, unused, m)
         end do
         if (i > 0) even = m
      end do
      do k = 1, size(displacements, 2)
         displacements(:, k) = y(:, k)/maxval(abs(y(:, k)))
      end do
   end subroutine even_and_odd

end module vi_structure_symmetry
