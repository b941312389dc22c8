!> The uncoupled pairs into which the free motion of a linear structure separates.
!!
!! M q'' + C q' + K q = 0 separates into bodies, the connected parts of the graph of nonzeros, and
!! each body into modes (DSYGV). Where damping couples the modes, the complex eigenvectors of the
!! body (DGEEV) give pairs that damping does not couple. At critical damping the two eigenvectors of
!! a pair coincide; near it, the pair comes from the plane that they span.
module vi_decoupling
   use vi_columns, only: solve_columns
   use vi_eigen_routines, only: dsygv
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

   !> Largest relative error by rounding of omega^2, and of the coupling of modes by stiffness.
   real(wp), parameter :: largest_error = 1.0e-7_wp
   !> Largest coupling by damping, over sqrt(omega_i omega_j), of modes that count as uncoupled.
   real(wp), parameter :: no_coupling = 1.0e-12_wp
   !> Least damping of a mode, over the largest omega or damping, of structures that may grow.
   real(wp), parameter :: least_damping = -1.0e-3_wp
   !> Two eigenvalues of a pair that are closer, relative to their size, have nearly the same
   !! eigenvector.
   real(wp), parameter :: close = 1.0e-2_wp
   !> Largest condition number of the change from pairs to coordinates and velocities: flights then
   !! have errors below 1e-12.
   real(wp), parameter :: largest_condition = 1.0e4_wp

contains

   !> Finds the pairs of a structure.
   !!
   !! Entries as small as their rounding errors count as 0. The entries of the matrices may be sums
   !! of larger terms, as where a closed gap holds both ends of a spring: then their own size does
   !! not indicate their errors.
   pure subroutine decouple(mass, damping, stiffness, decoupled, status, terms, may_grow)
      !> (n, n) Symmetric matrices M (positive definite), C and K (semidefinite).
      real(wp), intent(in) :: mass(:, :), damping(:, :), stiffness(:, :)
      !> The pairs.
      type(decoupled_type), intent(out) :: decoupled
      !> `stat%ok`; `stat%mass_not_definite`; `stat%negative_stiffness` where K has a negative
      !! eigenvalue, or C alone would make a mode of M and K grow (a C with a negative eigenvalue
      !! may pass); `stat%defective` where complex eigenvectors nearly coincide;
      !! `stat%too_stiff` where rounding leaves too few digits; `stat%extreme_units`; or
      !! `stat%lapack_failed`.
      integer, intent(out) :: status
      !> (n, n, 2) The sums of the moduli of the terms of which the entries of C and K were
      !! computed; the moduli of the entries if it is left out.
      real(wp), intent(in), optional :: terms(:, :, :)
      !> Whether damping may be below 0, down to `least_damping`: differences of parameters and
      !! steps along branches go beyond the bound 0. Not by default.
      logical, intent(in), optional :: may_grow
      real(wp) :: sizes(size(mass, 1), size(mass, 1), 2), least
      integer :: body(size(mass, 1))
      integer :: i, n

      n = size(mass, 1)
      sizes(:, :, 1) = abs(damping)
      sizes(:, :, 2) = abs(stiffness)
      if (present(terms)) sizes = terms
      least = -no_coupling
      if (present(may_grow)) then
         if (may_grow) least = least_damping
      end if
      call find_bodies(mass, damping, stiffness, body)
      allocate (decoupled%stiffness(n), decoupled%damping(n), decoupled%body(n))
      allocate (decoupled%qx(n, n), decoupled%qv(n, n), decoupled%dx(n, n), decoupled%dv(n, n), &
         decoupled%xq(n, n), decoupled%xd(n, n), decoupled%vq(n, n), decoupled%vd(n, n), &
         source=0.0_wp)
      status = stat%ok
      do i = 1, maxval(body)
         call decouple_body(pack([(n, n=1, size(body))], body == i), i, mass, damping, stiffness, &
            sizes, least, decoupled, status)
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
   pure subroutine decouple_body(at, body, mass, damping, stiffness, terms, least, decoupled, &
      status)
      !> (m) Its coordinates, and its number.
      integer, intent(in) :: at(:), body
      !> (n, n) Matrices of the structure; (n, n, 2) the sums of the moduli of the terms of C and K.
      real(wp), intent(in) :: mass(:, :), damping(:, :), stiffness(:, :), terms(:, :, :)
      !> Least damping of a mode, over the largest omega or damping.
      real(wp), intent(in) :: least
      !> In and out: filled in.
      type(decoupled_type), intent(inout) :: decoupled
      !> As in `decouple`.
      integer, intent(out) :: status
      real(wp) :: shapes(size(at), size(at)), factor(size(at), size(at)), &
         coupling(size(at), size(at)), noise(size(at), size(at)), omega_squared(size(at)), &
         work(max(66*size(at), 8))
      real(wp) :: scale
      integer :: i, j, m, info, order(size(at))

      m = size(at)
      status = stat%mass_not_definite
      if (any([(mass(at(i), at(i)) <= 0, i=1, m)])) return
      ! the eigenvalue solver keeps the digits of slow modes if fast coordinates come last
      call order_by_speed([(stiffness(at(i), at(i))/mass(at(i), at(i)), i=1, m)], order)
      shapes = stiffness(at(order), at(order))
      factor = mass(at(order), at(order))
      call dsygv(1, 'V', 'U', m, shapes, m, factor, m, omega_squared, work, size(work), info)
      status = stat%ok
      if (info > m) status = stat%mass_not_definite
      if (info /= 0 .and. status == stat%ok) status = stat%lapack_failed
      if (status /= stat%ok) return
      shapes(order, :) = shapes
      scale = maxval(abs(omega_squared))
      call find_zeros(stiffness(at, at), terms(at, at, 2), shapes, omega_squared, status)
      if (status /= stat%ok) return
      call refine_free(stiffness(at, at), omega_squared, shapes)
      coupling = 0
      noise = 0
      if (any(abs(damping(at, at)) > 0)) then
         coupling = matmul(transpose(shapes), matmul(damping(at, at), shapes))
         call decouple_free(omega_squared, shapes, coupling, info)
         if (info /= 0) then
            status = stat%lapack_failed
            return
         end if
         noise = epsilon(1.0_wp)*matmul(transpose(abs(shapes)), matmul(terms(at, at, 1), &
            abs(shapes)))
         ! damping across a closed gap, or in proportion to the stiffness, leaves rounding errors
         where (abs(coupling) <= 64*m*noise) coupling = 0
      end if
      do i = 1, m
         associate (unit => max(sqrt(scale), maxval(abs(coupling))))
            if (coupling(i, i) < least*unit) status = stat%negative_stiffness
            if (coupling(i, i) >= -no_coupling*unit) coupling(i, i) = max(0.0_wp, coupling(i, i))
         end associate
         if (.not. omega_squared(i) > 0 .and. coupling(i, i) <= 64*m*epsilon(1.0_wp)*maxval(abs( &
            coupling))) coupling(i, i) = 0
      end do
      if (status /= stat%ok) return
      decoupled%body(at) = body
      if (any([(omega_squared(i) + coupling(i, i) > 0 .and. noise(i, i) > largest_error* &
         max(sqrt(omega_squared(i)), coupling(i, i)), i=1, m)])) then
         status = stat%too_stiff
         return
      end if
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
         call decouple_damping(at, mass(at, at), shapes, omega_squared, coupling, &
            noise/epsilon(1.0_wp), decoupled, status)
      end if
   end subroutine decouple_body

   !> The order of coordinates from the slowest to the fastest; those within a factor of about 256
   !! keep theirs, and with it a banded matrix its form.
   pure subroutine order_by_speed(squares, order)
      !> (m) K_ii/M_ii of the coordinates.
      real(wp), intent(in) :: squares(:)
      !> (m) Their indices.
      integer, intent(out) :: order(:)
      integer :: level(size(squares)), i, j
      real(wp) :: least

      least = max(tiny(1.0_wp), epsilon(1.0_wp)**2*maxval(squares))
      level = exponent(maxval(squares)/max(squares, least))/8
      do i = 1, size(squares)
         j = i
         do while (j > 1)
            if (level(order(j - 1)) >= level(i)) exit
            order(j) = order(j - 1)
            j = j - 1
         end do
         order(j) = i
      end do
   end subroutine order_by_speed

   !> Sets omega^2 of modes of frequency 0 to 0: where x^T K x is as small as its rounding error.
   pure subroutine find_zeros(stiffness, terms, shapes, omega_squared, status)
      !> (m, m) K, the sums of the moduli of the terms of its entries, and the modes with
      !! x^T M x = 1.
      real(wp), intent(in) :: stiffness(:, :), terms(:, :), shapes(:, :)
      !> (m) In and out: omega^2 of the modes.
      real(wp), intent(inout) :: omega_squared(:)
      !> `stat%ok`; `stat%negative_stiffness`; `stat%too_stiff` where another omega^2 may have a
      !! relative error above `largest_error`.
      integer, intent(out) :: status
      real(wp), dimension(size(shapes, 1), size(shapes, 1)) :: elastic
      real(wp) :: noise(size(shapes, 1)), share
      integer :: i, j, m

      m = size(shapes, 1)
      elastic = matmul(transpose(shapes), matmul(stiffness, shapes))
      noise = epsilon(1.0_wp)*sum(abs(shapes)*matmul(terms, abs(shapes)), 1)
      status = stat%ok
      do i = 1, m
         if (abs(elastic(i, i)) <= 64*m*noise(i)) then
            omega_squared(i) = 0
         else if (elastic(i, i) < 0) then
            status = stat%negative_stiffness
         end if
      end do
      if (status /= stat%ok) return
      do i = 1, m
         if (.not. abs(omega_squared(i)) > 0) cycle
         share = largest_error*omega_squared(i)
         if (noise(i) > share .or. abs(elastic(i, i) - omega_squared(i)) > share) then
            status = stat%too_stiff
         end if
         do j = 1, m
            if (j /= i .and. omega_squared(j) <= omega_squared(i) .and. &
               abs(elastic(i, j)) > share) status = stat%too_stiff
         end do
      end do
   end subroutine find_zeros

   !> Corrects the modes of frequency 0 and the others so that the stiffness has no effect on the
   !! former.
   !!
   !! The eigenvalue solver leaves errors in proportion to the ratio of the stiffnesses. With them
   !! impulses between two masses of a free structure would seem to change its momentum.
   pure subroutine refine_free(stiffness, omega_squared, shapes)
      !> (m, m) K, and (m) omega^2 of the modes.
      real(wp), intent(in) :: stiffness(:, :), omega_squared(:)
      !> (m, m) In and out: the modes.
      real(wp), intent(inout) :: shapes(:, :)
      real(wp) :: force(size(shapes, 1)), free(size(shapes, 1)), turn
      integer :: i, j, pass

      do pass = 1, 2
         do i = 1, size(omega_squared)
            if (abs(omega_squared(i)) > 0) cycle
            do j = 1, size(force)
               force(j) = fine_product(stiffness(:, j), shapes(:, i))
            end do
            do j = 1, size(omega_squared)
               if (.not. abs(omega_squared(j)) > 0) cycle
               turn = dot_product(shapes(:, j), force)/omega_squared(j)
               free = shapes(:, i)
               shapes(:, i) = free - turn*shapes(:, j)
               shapes(:, j) = shapes(:, j) + turn*free
            end do
         end do
      end do
   end subroutine refine_free

   !> The sum of products as if it had twice as many digits: the rounding errors of all products and
   !! sums are exact numbers, which are added.
   pure real(wp) function fine_product(a, b) result(total)
      !> The factors.
      real(wp), intent(in) :: a(:), b(:)
      real(wp) :: product, error, sum, share, high(2), low(2)
      integer :: i

      total = 0
      error = 0
      do i = 1, size(a)
         product = a(i)*b(i)
         high = (scale(1.0_wp, ceiling(0.5*digits(1.0_wp))) + 1)*[a(i), b(i)]
         high = high - (high - [a(i), b(i)])
         low = [a(i), b(i)] - high
         error = error + (low(1)*low(2) - (((product - high(1)*high(2)) - low(1)*high(2)) &
            - high(1)*low(2)))
         sum = total + product
         share = sum - total
         error = error + ((total - (sum - share)) + (product - share))
         total = sum
      end do
      total = total + error
   end function fine_product

   !> Takes combinations of the modes of frequency 0 that damping does not couple: without stiffness
   !! any combination is a mode, and those that damping couples could have a defective eigenvalue 0.
   pure subroutine decouple_free(omega_squared, shapes, coupling, info)
      !> (m) omega^2 of the modes.
      real(wp), intent(in) :: omega_squared(:)
      !> (m, m) In and out: the modes, and C between them.
      real(wp), intent(inout) :: shapes(:, :), coupling(:, :)
      !> That of LAPACK: 0 if all is well.
      integer, intent(out) :: info
      real(wp), allocatable :: turn(:, :), unit(:, :), drag(:), work(:), columns(:, :)
      integer, allocatable :: free(:)
      integer :: i, n

      free = pack([(i, i=1, size(omega_squared))], .not. abs(omega_squared) > 0)
      n = size(free)
      info = 0
      if (n < 2) return
      allocate (turn, source=coupling(free, free))
      allocate (unit(n, n), source=0.0_wp)
      allocate (drag(n), work(66*n))
      do i = 1, n
         unit(i, i) = 1
      end do
      call dsygv(1, 'V', 'U', n, turn, n, unit, n, drag, work, size(work), info)
      if (info /= 0) return
      columns = shapes(:, free)
      shapes(:, free) = matmul(columns, turn)
      columns = coupling(:, free)
      columns = matmul(columns, turn)
      coupling(:, free) = columns
      coupling(free, :) = transpose(columns)
      coupling(free, free) = 0
      do i = 1, n
         coupling(free(i), free(i)) = drag(i)
      end do
   end subroutine decouple_free

   !> The pairs of a body whose modes are coupled by damping.
   pure subroutine decouple_damping(at, mass, shapes, omega_squared, coupling, terms, decoupled, &
      status)
      !> (m) Coordinates of the body.
      integer, intent(in) :: at(:)
      !> (m, m) M, the undamped modes, omega^2 of each (m), and C between them (m, m).
      real(wp), intent(in) :: mass(:, :), shapes(:, :), omega_squared(:), coupling(:, :)
      !> (m, m) The sums of the moduli of the terms of `coupling`.
      real(wp), intent(in) :: terms(:, :)
      !> In and out: filled in.
      type(decoupled_type), intent(inout) :: decoupled
      !> As in `decouple`.
      integer, intent(out) :: status
      real(wp), allocatable, dimension(:, :) :: a, matrix, sizes, vectors, back
      real(wp), allocatable :: re(:), im(:), work(:), speeds(:), omega2(:), sigma(:), plane(:, :)
      !> Least share of a drag's eigenvector that is used as a combination of modes of frequency 0.
      real(wp), parameter :: least_share = 0.1_wp, least_part = 0.01_wp
      real(wp), allocatable :: known(:, :), part(:)
      real(wp) :: unused(1, 1), to_pairs(size(at), size(at))
      integer, allocatable :: rigid(:), others(:), reals(:), list(:), free(:)
      integer :: i, j, k, m, n, info
      logical :: coincide
      logical, allocatable :: zero(:)

      m = size(at)
      ! an undamped mode of frequency 0 would have a defective eigenvalue: it is a pair already
      rigid = pack([(i, i=1, m)], .not. omega_squared > 0 .and. &
         maxval(abs(coupling), 1) <= no_coupling*maxval(abs(coupling)))
      others = pack([(i, i=1, m)], [(.not. any(rigid == i), i=1, m)])
      n = size(others)
      allocate (a(2*n, 2*n), vectors(2*n, 2*n), back(2*n, 2*n), re(2*n), im(2*n), work(16*n), &
         omega2(n), sigma(n))
      ! positions times a frequency are comparable with velocities, in any unit of time
      speeds = sqrt(omega_squared(others))
      where (.not. speeds > 0) speeds = [(coupling(others(i), others(i)), i=1, n)]
      a = 0
      do i = 1, n
         a(i, n + i) = speeds(i)
         a(n + i, i) = -omega_squared(others(i))/speeds(i)
         a(n + i, n + 1:) = -coupling(others(i), others)
      end do
      allocate (matrix, source=a)
      status = stat%extreme_units
      if (.not. all(abs(a) <= huge(1.0_wp))) return
      call geev('N', 'V', 2*n, a, 2*n, re, im, unused, 1, vectors, 2*n, work, size(work), info)
      status = merge(stat%ok, stat%lapack_failed, info == 0)
      if (info /= 0) return
      decoupled%stiffness(at(rigid)) = 0
      decoupled%damping(at(rigid)) = 0
      decoupled%qx(at, at(rigid)) = shapes(:, rigid)
      decoupled%dv(at, at(rigid)) = shapes(:, rigid)
      a = 0
      k = 1
      ! the columns of the modes of frequency 0 are 0, and so are as many eigenvalues, exactly
      free = pack([(i, i=1, n)], .not. omega_squared(others) > 0)
      zero = .not. hypot(re, im) > 0
      list = pack([(i, i=1, 2*n)], .not. (im < 0 .or. zero))
      allocate (reals(0))
      do while (size(list) > 0)
         i = list(1)
         list = list(2:)
         plane = vectors(:, [i, min(i + 1, 2*n)])
         coincide = .false.
         if (im(i) > 0) then
            if (2*im(i) <= close*abs(re(i))) call coinciding_pair(matrix, re(i), 2*im(i), plane, &
               omega2(k), sigma(k), coincide)
            if (.not. coincide) then
               ! the columns are Re and Im of an eigenvector c: q = Re(c e^(lambda t))
               omega2(k) = re(i)**2 + im(i)**2
               sigma(k) = -re(i)
               plane(:, 1) = vectors(:, i) - re(i)/im(i)*vectors(:, i + 1)
               plane(:, 2) = vectors(:, i + 1)/im(i)
            end if
         else
            do m = 1, size(list)
               j = list(m)
               if (im(j) > 0 .or. abs(re(j) - re(i)) > close*abs(re(i))) cycle
               plane = vectors(:, [i, j])
               call coinciding_pair(matrix, 0.5_wp*(re(j) + re(i)), abs(re(j) - re(i)), plane, &
                  omega2(k), sigma(k), coincide)
               if (coincide) exit
            end do
            if (.not. coincide) then
               ! pairs of lengths of 1 in positions are as well conditioned in any unit of time
               vectors(:, i) = vectors(:, i)/norm2(vectors(:n, i))
               reals = [reals, i]
               cycle
            end if
            list = pack(list, list /= j)
         end if
         a(:, [k, n + k]) = plane
         k = k + 1
      end do
      ! each 0 is paired with a real eigenvalue, and any combination of modes of frequency 0 is at
      ! rest: best the one which a drag slows down, unless it is lost in rounding or not a new one.
      ! More zeros than such modes are eigenvalues that a much greater one has swallowed
      allocate (known(size(free), size(free)))
      do m = 1, min(count(zero), size(free), size(reals))
         j = reals(maxloc(norm2(vectors(free, reals), 1), 1))
         reals = pack(reals, reals /= j)
         part = vectors(free, j)
         known(:, m) = without(part, known(:, :m - 1))
         if (norm2(known(:, m)) < least_share*max(least_part, norm2(part))) then
            part = 0
            part(minloc(sum(known(:, :m - 1)**2, 2))) = 1
            known(:, m) = without(part, known(:, :m - 1))
            part = known(:, m)*(least_part/norm2(known(:, m)))
         end if
         known(:, m) = known(:, m)/norm2(known(:, m))
         omega2(k) = 0
         sigma(k) = -0.5_wp*re(j)
         a(free, k) = part
         a(:, n + k) = (vectors(:, j) - a(:, k))/re(j)
         k = k + 1
      end do
      if (k + size(reals)/2 /= n + 1) then
         status = merge(stat%too_stiff, stat%defective, count(zero) > size(free))
         return
      end if
      ! the other real eigenvalues are paired: the slowest with the fastest
      do while (size(reals) > 0)
         i = reals(minloc(abs(re(reals)), 1))
         reals = pack(reals, reals /= i)
         j = reals(maxloc(abs(re(reals)), 1))
         reals = pack(reals, reals /= j)
         omega2(k) = re(i)*re(j)
         sigma(k) = -0.5_wp*(re(i) + re(j))
         ! their difference is small only if they nearly coincide
         if (dot_product(vectors(:n, i), vectors(:n, j)) < 0) vectors(:, j) = -vectors(:, j)
         a(:, k) = (re(i)*vectors(:, j) - re(j)*vectors(:, i))/(re(i) - re(j))
         a(:, n + k) = (vectors(:, i) - vectors(:, j))/(re(i) - re(j))
         k = k + 1
      end do
      decoupled%stiffness(at(others)) = max(0.0_wp, omega2)
      decoupled%damping(at(others)) = max(0.0_wp, sigma)
      back = 0
      do i = 1, 2*n
         back(i, i) = 1
      end do
      call solve_columns(a, back, status)
      if (status /= stat%ok .or. .not. condition(a, back) <= largest_condition) then
         status = stat%defective
      else
         allocate (sizes, source=abs(matrix))
         sizes(n + 1:, n + 1:) = terms(others, others)
         if (.not. are_separate(matrix, sizes, a, back, omega2, sigma)) status = stat%too_stiff
      end if
      if (status /= stat%ok) return
      a(:n, :) = a(:n, :)/spread(speeds, 2, 2*n)
      back(:, :n) = back(:, :n)*spread(speeds, 1, 2*n)
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

   !> A vector without its parts along others.
   pure function without(vector, others) result(rest)
      !> The vector, and (:, others) orthonormal vectors.
      real(wp), intent(in) :: vector(:), others(:, :)
      real(wp) :: rest(size(vector))

      rest = vector - matmul(others, matmul(vector, others))
   end function without

   !> Whether the pairs are those of A: A between the pairs, but for rounding, leaves each of them
   !! its omega^2 and sigma, and couples none of them.
   !!
   !! The eigenvalue solver has errors in proportion to the fastest mode, which slow modes may not
   !! survive.
   pure logical function are_separate(matrix, terms, a, inverse, omega2, sigma) result(separate)
      !> (2n, 2n) A, the sums of the moduli of the terms of its entries, and the pairs with the
      !! inverse.
      real(wp), intent(in) :: matrix(:, :), terms(:, :), a(:, :), inverse(:, :)
      !> (n) omega^2 and sigma of the pairs.
      real(wp), intent(in) :: omega2(:), sigma(:)
      real(wp), dimension(size(a, 1), size(a, 1)) :: rest, noise
      real(wp), dimension(size(a, 1)) :: rate, units
      integer :: i, k, n

      n = size(omega2)
      rest = matmul(inverse, matmul(matrix, a))
      noise = matmul(abs(inverse), matmul(terms, abs(a)))
      do k = 1, n
         rest(n + k, k) = rest(n + k, k) + omega2(k)
         rest(k, n + k) = rest(k, n + k) - 1
         rest(n + k, n + k) = rest(n + k, n + k) + 2*sigma(k)
      end do
      ! positions times a rate are comparable with velocities
      rate(:n) = sqrt(max(0.0_wp, omega2))
      where (.not. rate(:n) > 0) rate(:n) = 2*abs(sigma)
      rate(n + 1:) = rate(:n)
      units = [rate(:n), spread(1.0_wp, 1, n)]
      separate = .true.
      do i = 1, 2*n
         separate = separate .and. all((abs(rest(i, :)) + epsilon(1.0_wp)*noise(i, :))*units(i) &
            <= largest_error*units*max(rate(i), rate))
      end do
   end function are_separate

   !> The pair of two eigenvalues that nearly coincide, and whose eigenvectors also do: x and v are
   !! coordinates in the plane that is spanned by both.
   !!
   !! The span of two vectors tends to the plane if they are multiplied again and again by the
   !! inverse of A less a number near the eigenvalues. A in this plane is a 2 x 2 matrix T. With
   !! columns a and b of the change of coordinates, A b = a - 2 sigma b and A a = -omega^2 b.
   pure subroutine coinciding_pair(matrix, mean, apart, plane, omega2, sigma, good)
      !> (2n, 2n) A.
      real(wp), intent(in) :: matrix(:, :)
      !> Mean real part of the eigenvalues, and the distance between them.
      real(wp), intent(in) :: mean, apart
      !> (2n, 2) In: two vectors near the plane. Out: a and b, if the eigenvectors nearly coincide.
      real(wp), intent(inout) :: plane(:, :)
      !> omega^2 and sigma of the pair.
      real(wp), intent(out) :: omega2, sigma
      !> Whether they do.
      logical, intent(out) :: good
      integer, parameter :: turns = 20
      !> The shift is not too near the eigenvalues, so that one vector does not outgrow the other.
      real(wp), parameter :: offset = 0.02_wp, accuracy = 1.0e-14_wp
      real(wp) :: factor(size(matrix, 1), size(matrix, 1)), q(size(matrix, 1), 2), t(2, 2), &
         part(2, 2), y(2)
      integer :: i, status

      q = plane
      do i = 1, turns
         ! a product with the inverse would lose digits: only a solution is that of a matrix which
         ! differs by rounding
         factor = matrix
         call add_to_diagonal(factor, -(1 + offset)*mean)
         call solve_columns(factor, q, status)
         if (status /= stat%ok) exit
         call make_orthonormal(q)
      end do
      t = matmul(transpose(q), matmul(matrix, q))
      good = status == stat%ok .and. norm2(matmul(matrix, q) - matmul(q, t)) &
         <= accuracy*norm2(matrix)
      sigma = -0.5_wp*(t(1, 1) + t(2, 2))
      part = t
      call add_to_diagonal(part, sigma)
      good = good .and. sum(part**2) > apart*abs(mean)
      omega2 = t(1, 1)*t(2, 2) - t(1, 2)*t(2, 1)
      if (.not. good) return
      y = merge([1, 0], [0, 1], norm2(part(:, 1)) > norm2(part(:, 2)))
      plane(:, 2) = matmul(q, y)
      plane(:, 1) = matmul(q, matmul(part, y) + sigma*y)
   end subroutine coinciding_pair

   !> Adds a number to the diagonal of a matrix.
   pure subroutine add_to_diagonal(a, number)
      !> In and out: the matrix.
      real(wp), intent(inout) :: a(:, :)
      !> The number.
      real(wp), intent(in) :: number
      integer :: i

      do i = 1, size(a, 1)
         a(i, i) = a(i, i) + number
      end do
   end subroutine add_to_diagonal

   !> Makes two vectors orthogonal and of length 1.
   pure subroutine make_orthonormal(q)
      !> (n, 2) In and out: the vectors.
      real(wp), intent(inout) :: q(:, :)
      integer :: i

      q(:, 1) = q(:, 1)/norm2(q(:, 1))
      do i = 1, 2
         q(:, 2) = q(:, 2)/norm2(q(:, 2))
         q(:, 2) = q(:, 2) - dot_product(q(:, 1), q(:, 2))*q(:, 1)
      end do
      q(:, 2) = q(:, 2)/norm2(q(:, 2))
   end subroutine make_orthonormal

   !> A bound on the least condition number of a matrix in any units of its rows and columns, in the
   !! maximum norm; the inverse is given.
   !!
   !! It is the spectral radius of |A| |A^-1| (Bauer). The quotients of products with a positive
   !! vector bound it from above (Collatz).
   pure real(wp) function condition(a, inverse)
      !> (n, n) The matrix and its inverse.
      real(wp), intent(in) :: a(:, :), inverse(:, :)
      integer, parameter :: turns = 20
      real(wp), dimension(size(a, 1)) :: x, y
      integer :: i

      x = 1
      do i = 1, turns
         y = matmul(abs(a), matmul(abs(inverse), x))
         condition = maxval(y/x)
         x = max(y/maxval(y), sqrt(tiny(1.0_wp)))
      end do
   end function condition

end module vi_decoupling
