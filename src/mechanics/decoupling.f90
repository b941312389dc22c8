!> The uncoupled pairs into which the free motion of a linear structure separates.
!!
!! M q'' + C q' + K q = 0 separates into bodies, the connected parts of the graph of nonzeros, and
!! each body into modes (DSYGV). Where damping couples the modes, the complex eigenvectors of the
!! body (DGEEV) give pairs that damping does not couple.
module vi_decoupling
   use vi_eigen_routines, only: dgesv, dsygv
   use vi_kinds, only: wp
   use vi_lapack_routines, only: geev
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: decouple

   !> The change between coordinates and pairs: q = qx x + qv v, q' = dx x + dv v, and back
   !! x = xq q + xd q', v = vq q + vd q'.
   type, public :: decoupled_type
      !> (m) omega^2 and sigma of the pairs, see vi_modes, and the body of each, from 1.
      real(wp), allocatable :: stiffness(:), damping(:)
      integer, allocatable :: body(:)
      !> (n, m)
      real(wp), allocatable, dimension(:, :) :: qx, qv, dx, dv
      !> (m, n)
      real(wp), allocatable, dimension(:, :) :: xq, xd, vq, vd
      !> Whether all damping is classical: then qv, dx, xd and vq are 0.
      logical :: classical = .true.
   end type decoupled_type

   !> A frequency counts as 0 if its omega^2 is below this fraction of the largest one of the body.
   real(wp), parameter :: zero_frequency = 1.0e-13_wp
   !> Largest coupling by damping, over sqrt(omega_i omega_j), of modes that count as uncoupled.
   real(wp), parameter :: no_coupling = 1.0e-12_wp
   !> Largest condition number of the matrix of complex eigenvectors.
   real(wp), parameter :: largest_condition = 1.0e5_wp

contains

   !> Finds the pairs of a structure.
   pure subroutine decouple(mass, damping, stiffness, decoupled, status)
      !> (n, n) Symmetric matrices M (positive definite), C and K (semidefinite).
      real(wp), intent(in) :: mass(:, :), damping(:, :), stiffness(:, :)
      !> The pairs.
      type(decoupled_type), intent(out) :: decoupled
      !> `stat%ok`; `stat%mass_not_definite`; `stat%negative_stiffness` where K or C has a
      !! negative eigenvalue; `stat%defective` where complex eigenvectors nearly coincide; or
      !! `stat%lapack_failed`.
      integer, intent(out) :: status
      integer :: body(size(mass, 1))
      integer :: i, n

      n = size(mass, 1)
      call find_bodies(mass, damping, stiffness, body)
      allocate (decoupled%stiffness(n), decoupled%damping(n), decoupled%body(n))
      allocate (decoupled%qx(n, n), decoupled%qv(n, n), decoupled%dx(n, n), decoupled%dv(n, n), &
         decoupled%xq(n, n), decoupled%xd(n, n), decoupled%vq(n, n), decoupled%vd(n, n), &
         source=0.0_wp)
      status = stat%ok
      do i = 1, maxval(body)
         call decouple_body(pack([(n, n=1, size(body))], body == i), i, mass, damping, stiffness, &
            decoupled, status)
         if (status /= stat%ok) return
      end do
   end subroutine decouple

   !> Numbers the connected parts of a structure.
   pure subroutine find_bodies(mass, damping, stiffness, body)
      !> (n, n) Its matrices.
      real(wp), intent(in) :: mass(:, :), damping(:, :), stiffness(:, :)
      !> (n) The body of each coordinate, from 1 in the order of their first coordinates.
      integer, intent(out) :: body(:)
      integer :: waiting(size(body)), bodies, here, i, j, n
      logical :: linked

      body = 0
      bodies = 0
      do i = 1, size(body)
         if (body(i) > 0) cycle
         bodies = bodies + 1
         body(i) = bodies
         waiting(1) = i
         n = 1
         do while (n > 0)
            here = waiting(n)
            n = n - 1
            do j = 1, size(body)
               if (body(j) > 0) cycle
               linked = abs(mass(j, here)) + abs(damping(j, here)) + abs(stiffness(j, here)) > 0
               if (.not. linked) cycle
               body(j) = bodies
               n = n + 1
               waiting(n) = j
            end do
         end do
      end do
   end subroutine find_bodies

   !> The pairs of one body, stored at the indices of its coordinates.
   pure subroutine decouple_body(at, body, mass, damping, stiffness, decoupled, status)
      !> (m) Its coordinates, and its number.
      integer, intent(in) :: at(:), body
      !> (n, n) Matrices of the structure.
      real(wp), intent(in) :: mass(:, :), damping(:, :), stiffness(:, :)
      !> In and out: filled in.
      type(decoupled_type), intent(inout) :: decoupled
      !> As in `decouple`.
      integer, intent(out) :: status
      real(wp) :: shapes(size(at), size(at)), factor(size(at), size(at)), &
         coupling(size(at), size(at)), omega_squared(size(at)), work(max(66*size(at), 8))
      real(wp) :: scale
      integer :: i, j, m, info

      m = size(at)
      shapes = stiffness(at, at)
      factor = mass(at, at)
      call dsygv(1, 'V', 'U', m, shapes, m, factor, m, omega_squared, work, size(work), info)
      status = stat%ok
      if (info > m) status = stat%mass_not_definite
      if (info /= 0 .and. status == stat%ok) status = stat%lapack_failed
      if (status /= stat%ok) return
      scale = maxval(abs(omega_squared))
      where (abs(omega_squared) <= zero_frequency*scale) omega_squared = 0
      coupling = 0
      if (any(abs(damping(at, at)) > 0)) coupling = matmul(transpose(shapes), &
         matmul(damping(at, at), shapes))
      do i = 1, m
         if (coupling(i, i) < -no_coupling*max(sqrt(scale), maxval(abs(coupling)))) then
            status = stat%negative_stiffness
         end if
         coupling(i, i) = max(0.0_wp, coupling(i, i))
         ! damping that is proportional to the stiffness leaves rounding errors for a drag at
         ! frequency 0
         if (.not. omega_squared(i) > 0 .and. coupling(i, i) <= 64*m*epsilon(1.0_wp)*maxval(abs( &
            coupling))) coupling(i, i) = 0
      end do
      if (any(omega_squared < 0)) status = stat%negative_stiffness
      if (status /= stat%ok) return
      decoupled%body(at) = body
      if (all([((i == j .or. abs(coupling(i, j)) <= no_coupling*max(sqrt(sqrt(omega_squared(i)* &
         omega_squared(j))), coupling(i, i), coupling(j, j)), i=1, m), j=1, m)])) then
         decoupled%stiffness(at) = omega_squared
         decoupled%damping(at) = [(0.5_wp*coupling(i, i), i=1, m)]
         decoupled%qx(at, at) = shapes
         decoupled%dv(at, at) = shapes
         shapes = matmul(transpose(shapes), mass(at, at))
         decoupled%xq(at, at) = shapes
         decoupled%vd(at, at) = shapes
      else
         decoupled%classical = .false.
         call decouple_damping(at, mass(at, at), shapes, omega_squared, coupling, decoupled, status)
      end if
   end subroutine decouple_body

   !> The pairs of a body whose modes are coupled by damping.
   pure subroutine decouple_damping(at, mass, shapes, omega_squared, coupling, decoupled, status)
      !> (m) Coordinates of the body.
      integer, intent(in) :: at(:)
      !> (m, m) M, the undamped modes, omega^2 of each (m), and C between them (m, m).
      real(wp), intent(in) :: mass(:, :), shapes(:, :), omega_squared(:), coupling(:, :)
      !> In and out: filled in.
      type(decoupled_type), intent(inout) :: decoupled
      !> As in `decouple`.
      integer, intent(out) :: status
      real(wp), allocatable, dimension(:, :) :: a, vectors, back, factor
      real(wp), allocatable :: re(:), im(:), work(:)
      real(wp) :: unused(1, 1), to_pairs(size(at), size(at))
      integer, allocatable :: rigid(:), others(:), pivot(:), reals(:), list(:)
      integer :: i, j, k, m, n, info

      m = size(at)
      ! an undamped mode of frequency 0 would have a defective eigenvalue: it is a pair already
      rigid = pack([(i, i=1, m)], .not. omega_squared > 0 .and. &
         maxval(abs(coupling), 1) <= no_coupling*maxval(abs(coupling)))
      others = pack([(i, i=1, m)], [(.not. any(rigid == i), i=1, m)])
      n = size(others)
      allocate (a(2*n, 2*n), vectors(2*n, 2*n), back(2*n, 2*n), re(2*n), im(2*n), work(16*n), &
         pivot(2*n))
      a = 0
      do i = 1, n
         a(i, n + i) = 1
         a(n + i, i) = -omega_squared(others(i))
         a(n + i, n + 1:) = -coupling(others(i), others)
      end do
      call geev('N', 'V', 2*n, a, 2*n, re, im, unused, 1, vectors, 2*n, work, size(work), info)
      status = merge(stat%ok, stat%lapack_failed, info == 0)
      if (info /= 0) return
      ! real eigenvalues are paired: the slowest with the fastest
      list = pack([(i, i=1, 2*n)], .not. abs(im) > 0)
      allocate (reals(0))
      do while (size(list) > 0)
         j = minloc(abs(re(list)), 1)
         reals = [reals, list(j)]
         list = pack(list, list /= list(j))
         j = maxloc(abs(re(list)), 1)
         reals = [reals, list(j)]
         list = pack(list, list /= list(j))
      end do
      decoupled%stiffness(at(rigid)) = 0
      decoupled%damping(at(rigid)) = 0
      decoupled%qx(at, at(rigid)) = shapes(:, rigid)
      decoupled%dv(at, at(rigid)) = shapes(:, rigid)
      a = 0
      k = 0
      do i = 1, 2*n
         if (.not. im(i) > 0) cycle
         ! the columns are Re and Im of an eigenvector c: q = Re(c e^(lambda t))
         k = k + 1
         decoupled%stiffness(at(others(k))) = re(i)**2 + im(i)**2
         decoupled%damping(at(others(k))) = max(0.0_wp, -re(i))
         a(:, k) = vectors(:, i) - re(i)/im(i)*vectors(:, i + 1)
         a(:, n + k) = vectors(:, i + 1)/im(i)
      end do
      do i = 1, size(reals), 2
         k = k + 1
         associate (slow => re(reals(i)), fast => re(reals(i + 1)))
            decoupled%stiffness(at(others(k))) = max(0.0_wp, slow*fast)
            decoupled%damping(at(others(k))) = max(0.0_wp, -0.5_wp*(slow + fast))
            if (abs(slow) <= 16*n*epsilon(1.0_wp)*maxval(hypot(re, im))) then
               decoupled%stiffness(at(others(k))) = 0
            end if
            a(:, k) = (slow*vectors(:, reals(i + 1)) - fast*vectors(:, reals(i)))/(slow - fast)
            a(:, n + k) = (vectors(:, reals(i)) - vectors(:, reals(i + 1)))/(slow - fast)
         end associate
      end do
      back = 0
      do i = 1, 2*n
         back(i, i) = 1
      end do
      factor = a
      call dgesv(2*n, 2*n, factor, 2*n, pivot, back, 2*n, info)
      if (info /= 0) then
         status = stat%defective
      else if (condition(a, back) > largest_condition) then
         status = stat%defective
      end if
      if (status /= stat%ok) return
      decoupled%qx(at, at(others)) = matmul(shapes(:, others), a(:n, :n))
      decoupled%qv(at, at(others)) = matmul(shapes(:, others), a(:n, n + 1:))
      decoupled%dx(at, at(others)) = matmul(shapes(:, others), a(n + 1:, :n))
      decoupled%dv(at, at(others)) = matmul(shapes(:, others), a(n + 1:, n + 1:))
      to_pairs = matmul(transpose(shapes), mass)
      decoupled%xq(at(rigid), at) = to_pairs(rigid, :)
      decoupled%vd(at(rigid), at) = to_pairs(rigid, :)
      decoupled%xq(at(others), at) = matmul(back(:n, :n), to_pairs(others, :))
      decoupled%xd(at(others), at) = matmul(back(:n, n + 1:), to_pairs(others, :))
      decoupled%vq(at(others), at) = matmul(back(n + 1:, :n), to_pairs(others, :))
      decoupled%vd(at(others), at) = matmul(back(n + 1:, n + 1:), to_pairs(others, :))
   end subroutine decouple_damping

   !> The condition number, in the Frobenius norm, of a matrix with its columns scaled to length 1;
   !! the inverse is given.
   pure real(wp) function condition(a, inverse)
      !> (n, n) The matrix and its inverse.
      real(wp), intent(in) :: a(:, :), inverse(:, :)
      real(wp) :: lengths(size(a, 1))
      integer :: i

      lengths = [(norm2(a(:, i)), i=1, size(lengths))]
      condition = sqrt(real(size(lengths), wp))*norm2([(lengths(i)*norm2(inverse(i, :)), &
         i=1, size(lengths))])
   end function condition

end module vi_decoupling
