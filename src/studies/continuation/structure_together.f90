!> Motions of a structure whose impacts on several gaps are at one instant along their whole
!! family, as those of equal units that do the same.
!!
!! Such motions stay within q = V y, where the columns of V span all that the load and these
!! impacts together reach by M^-1 C and M^-1 K, if on it gaps that close together are the same one.
!! y is then the motion of a structure with fewer coordinates, V^T M V, .., whose gaps close one by
!! one, and is followed as any other motion is.
!!
!! The impulses commute, so that [P] of the whole structure exists. It maps V y onto such
!! displacements, where it is [P] of the smaller structure, and what is orthogonal to them with
!! respect to M onto itself: the latter disturbances part the impacts.
module vi_structure_together
   use vi_columns, only: solve_columns
   use vi_kinds, only: two_pi, wp
   use vi_lapack_routines, only: geev
   use vi_orbit, only: family_type
   use vi_responses, only: offset_pairs
   use vi_status, only: stat
   use vi_structure, only: check_structure, load_type, structure_type, to_pairs
   use vi_structure_assess, only: coupling_at_instants, none
   use vi_structure_members, only: flight_duration, member_type, set_flights, structure_members_type
   use vi_structure_map, only: apply_flight, apply_impact, from_coordinates, to_coordinates
   use vi_structure_motion, only: impulse_of, state_after
   use vi_structure_path, only: changed_whole, moves_alike, reduce, same_law, &
      structure_path_type
   use vi_structure_return, only: settled_type
   use vi_structure_symmetry, only: add_direction, near
   use vi_text, only: whole
   implicit none (type, external)
   private

   public :: are_multiple, multipliers_beside, set_together, whole_family, whole_member

   !> Impacts nearer than this in load phase are at one instant; lengths relative to those of the
   !! motion, and openings relative to each other, that count as 0.
   real(wp), parameter :: instant = 1.0e-9_wp, same = 1.0e-6_wp, same_opening = 1.0e-12_wp

   !> A structure as given, its M^-1 C and M^-1 K, and its accelerations under the load.
   type :: sample_type
      type(structure_type) :: structure
      real(wp), allocatable :: maps(:, :, :), forces(:, :)
   end type sample_type

contains

   !> Reduces the path and a motion to y, if impacts of the motion are at one instant and remain so.
   subroutine set_together(s, found, reduced, message)
      !> In and out: the structure, complete, and the parameters; if there are such impacts, those
      !! of y, and which impacts these are.
      type(structure_members_type), intent(inout) :: s
      !> In and out: the motion, without rest; impacts at one instant become successive ones.
      type(settled_type), intent(inout) :: found
      !> The motion of y, or the same one; of it only what is needed to follow it.
      type(settled_type), intent(out) :: reduced
      !> Why there is no such family although impacts are at one instant; empty if there is.
      character(:), allocatable, intent(out) :: message
      type(sample_type) :: samples(3)
      integer, allocatable :: impact_of(:), kept(:), twin(:)
      real(wp), allocatable :: part(:, :), beside(:, :)
      integer :: first(size(found%gaps)), i, n, status

      message = ''
      reduced = found
      call join_ends(found)
      n = size(found%gaps)
      allocate (impact_of(n), source=1)
      do i = 2, n
         impact_of(i) = impact_of(i - 1)
         if (found%motion%phases(i) - found%motion%phases(i - 1) > instant) impact_of(i) &
            = impact_of(i) + 1
      end do
      if (impact_of(n) == n) return
      do i = 1, n
         first(i) = findloc(impact_of, impact_of(i), dim=1)
      end do
      do i = 1, size(samples)
         call set_sample(s%path, i, samples(i), status)
         if (status /= stat%ok) return
      end do
      call span_motion(samples(:1), found, impact_of, part, beside)
      call list_gaps(samples(:1), part, kept, twin)
      if (any(twin(found%gaps) /= twin(found%gaps(first)) .or. twin(found%gaps) == 0)) return
      if (size(beside, 2) == 0 .or. .not. stays(found, samples(1), part)) return
      call span_motion(samples, found, impact_of, part, beside)
      call list_gaps(samples, part, kept, twin)
      do i = 1, n
         if (twin(found%gaps(i)) == twin(found%gaps(first(i)))) cycle
         message = 'gaps '//whole(found%gaps(first(i)) - 1)//' and '//whole(found%gaps(i) - 1)// &
            ' close at the same instant, but would not for other values of the parameters; change &
            &both gaps in the same way'
         return
      end do
      if (any([(coupling_at_instants(samples(i)%structure, found%gaps, impact_of), i=1, 3)] /= &
         none)) then
         message = 'gaps that close at the same instant are coupled by damping, so the derivative &
            &of the map over a period depends on their order'
         return
      end if
      s%exchanged = all([(count(impact_of == impact_of(i)) <= 2 .and. abs(samples(1)%structure% &
         effective(found%gaps(i)) - samples(1)%structure%effective(found%gaps(first(i)))) <= &
         same*samples(1)%structure%effective(found%gaps(i)), i=1, n)])
      s%path%whole = s%path%structure
      s%path%whole_load = s%path%load
      call reduce(part, kept, s%path%structure, s%path%load)
      call check_structure(s%path%structure, status)
      call move_alloc(part, s%path%part)
      call move_alloc(kept, s%path%kept)
      call move_alloc(beside, s%beside)
      s%gaps = found%gaps
      call reduce_motion(s%path, impact_of, twin, found, reduced)
      call move_alloc(impact_of, s%impact_of)
   end subroutine set_together

   !> Begins the period with the first of impacts at one instant, if the last and the first one are.
   pure subroutine join_ends(found)
      !> In and out: the motion.
      type(settled_type), intent(inout) :: found
      integer :: i, n

      n = size(found%gaps)
      do i = 1, n - 1
         associate (motion => found%motion)
            if (motion%phases(1) + two_pi*found%cycles - motion%phases(n) > instant) return
            found%gaps = cshift(found%gaps, -1)
            motion%phases = [motion%phases(n) - two_pi*found%cycles, motion%phases(:n - 1)]
            motion%speeds = cshift(motion%speeds, -1)
            motion%impulses = cshift(motion%impulses, -1)
            motion%states = cshift(motion%states, -1, dim=2)
         end associate
      end do
   end subroutine join_ends

   !> The structure at the start or at one of two other values of the parameters.
   pure subroutine set_sample(path, place, sample, status)
      !> The path.
      type(structure_path_type), intent(in) :: path
      !> 1: the start; 2 and 3: elsewhere.
      integer, intent(in) :: place
      !> The structure there.
      type(sample_type), intent(out) :: sample
      !> `stat%ok`, or as in `check_structure`.
      integer, intent(out) :: status
      real(wp), parameter :: shares(2:3) = [0.23_wp, 0.81_wp]
      type(load_type) :: load
      integer :: n

      if (place == 1) then
         sample%structure = path%structure
         load = path%load
      else
         call changed_whole(path, spread(shares(place), 1, size(path%changes)), sample%structure, &
            load)
      end if
      call check_structure(sample%structure, status)
      if (status /= stat%ok) return
      n = size(sample%structure%mass, 1)
      allocate (sample%maps(n, n, 2))
      sample%maps(:, :, 1) = sample%structure%damping
      sample%maps(:, :, 2) = sample%structure%stiffness
      sample%forces = reshape([load%constant, load%cosine, load%sine], [n, 1 + 2*size(load%sine, &
         2)])
      ! these succeed: the mass matrix has been checked
      call solve_columns(sample%structure%mass, sample%maps(:, :, 1), status)
      call solve_columns(sample%structure%mass, sample%maps(:, :, 2), status)
      call solve_columns(sample%structure%mass, sample%forces, status)
   end subroutine set_sample

   !> Bases of what the impacts at one instant reach together, and of what they reach besides one by
   !! one.
   pure subroutine span_motion(samples, found, impact_of, part, beside)
      !> The structures.
      type(sample_type), intent(in) :: samples(:)
      !> The motion.
      type(settled_type), intent(in) :: found
      !> (N) Equal for impacts at one instant.
      integer, intent(in) :: impact_of(:)
      !> (n, k) V; some coordinates of q are those of y. (n, l) The remainder.
      real(wp), allocatable, intent(out) :: part(:, :), beside(:, :)
      real(wp), dimension(size(samples(1)%structure%mass, 1), size(samples(1)%structure%mass, 1)) &
         :: y, unused
      real(wp), dimension(size(y, 1)) :: direction, zero
      real(wp) :: mass(size(y, 1), size(y, 1))
      integer :: i, j, m, pass

      mass = samples(1)%structure%mass
      zero = 0
      m = 0
      do pass = 1, 2
         do i = 1, size(samples)
            associate (structure => samples(i)%structure)
               do j = 1, size(samples(i)%forces, 2)
                  call add_direction(mass, samples(i)%forces(:, j), zero, y, unused, m)
               end do
               do j = 1, size(impact_of)
                  direction = structure%mobility(:, found%gaps(j))
                  if (pass == 1) call sum_mobilities(structure, pack(found%gaps, impact_of &
                     == impact_of(j)), direction)
                  call add_direction(mass, direction, zero, y, unused, m)
               end do
            end associate
         end do
         j = 0
         do while (j < m)
            j = j + 1
            do i = 1, size(samples)
               call add_direction(mass, matmul(samples(i)%maps(:, :, 1), y(:, j)), zero, y, &
                  unused, m)
               call add_direction(mass, matmul(samples(i)%maps(:, :, 2), y(:, j)), zero, y, &
                  unused, m)
            end do
         end do
         if (pass == 1) allocate (part, source=y(:, :m))
      end do
      allocate (beside, source=y(:, size(part, 2) + 1:m))
      call to_echelon(part)
   end subroutine span_motion

   !> The change of q' by impacts at one instant with the same speed and restitution, but for a
   !! factor.
   pure subroutine sum_mobilities(structure, gaps, direction)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The gaps.
      integer, intent(in) :: gaps(:)
      !> (n)
      real(wp), intent(out) :: direction(:)
      integer :: i

      direction = 0
      do i = 1, size(gaps)
         direction = direction + structure%effective(gaps(i))*structure%mobility(:, gaps(i))
      end do
   end subroutine sum_mobilities

   !> Another basis of the same vectors: in one row each, a column is 1 and all others are 0.
   pure subroutine to_echelon(basis)
      !> (n, k) In and out.
      real(wp), intent(inout) :: basis(:, :)
      real(wp), parameter :: rounding = 1.0e-12_wp
      integer :: i, j, row

      do j = 1, size(basis, 2)
         row = maxloc(abs(basis(:, j)), dim=1)
         basis(:, j) = basis(:, j)/basis(row, j)
         do i = 1, size(basis, 2)
            if (i == j) cycle
            basis(:, i) = basis(:, i) - basis(row, i)*basis(:, j)
            basis(row, i) = 0
         end do
      end do
      where (abs(basis - anint(basis)) < rounding) basis = anint(basis)
   end subroutine to_echelon

   !> The gaps of y: of gaps that are the same one on V only the first, and none that V does not
   !! close.
   pure subroutine list_gaps(samples, part, kept, twin)
      !> The structures.
      type(sample_type), intent(in) :: samples(:)
      !> (n, k) V.
      real(wp), intent(in) :: part(:, :)
      !> The gaps.
      integer, allocatable, intent(out) :: kept(:)
      !> (gaps) The place of each gap among them; 0 if V does not close it.
      integer, allocatable, intent(out) :: twin(:)
      real(wp) :: closing(size(part, 2), size(samples(1)%structure%openings), size(samples))
      real(wp) :: size_of
      integer :: i, j, k

      do k = 1, size(samples)
         closing(:, :, k) = matmul(transpose(part), samples(k)%structure%directions)
      end do
      size_of = maxval(abs(closing))
      allocate (twin(size(closing, 2)), source=0)
      allocate (kept(0))
      do j = 1, size(twin)
         if (maxval(abs(closing(:, j, :))) <= same*size_of) cycle
         do i = 1, size(kept)
            if (all([(near(closing(:, j:j, k), closing(:, kept(i):kept(i), k)) .and. &
               abs(samples(k)%structure%openings(j) - samples(k)%structure%openings(kept(i))) <= &
               same_opening*abs(samples(k)%structure%openings(j)) .and. &
               same_law(samples(k)%structure, j, kept(i)) .and. moves_alike(samples(k)%structure, &
               j, kept(i), 1), k=1, size(samples))])) twin(j) = i
            if (twin(j) > 0) exit
         end do
         if (twin(j) > 0) cycle
         kept = [kept, j]
         twin(j) = size(kept)
      end do
   end subroutine list_gaps

   !> Whether a motion lies in q = V y.
   pure logical function stays(found, sample, part)
      !> The motion.
      type(settled_type), intent(in) :: found
      !> The structure.
      type(sample_type), intent(in) :: sample
      !> (n, k) V.
      real(wp), intent(in) :: part(:, :)
      real(wp), allocatable :: q(:, :), y(:, :)
      integer :: status

      allocate (q, source=found%motion%states(:size(part, 1), :))
      call coordinates_of(sample%structure%mass, part, q, y, status)
      stays = status == stat%ok
      if (stays) stays = maxval(abs(matmul(part, y) - q)) < same*maxval(abs(q))
   end function stays

   !> The coordinates of vectors in a basis, orthogonal to what it lacks with respect to M.
   pure subroutine coordinates_of(mass, basis, vectors, coordinates, status)
      !> (n, n), (n, k), (n, m)
      real(wp), intent(in) :: mass(:, :), basis(:, :), vectors(:, :)
      !> (k, m)
      real(wp), allocatable, intent(out) :: coordinates(:, :)
      !> `stat%ok` or `stat%singular`.
      integer, intent(out) :: status
      real(wp), allocatable :: across(:, :)

      across = matmul(transpose(basis), mass)
      coordinates = matmul(across, vectors)
      call solve_columns(matmul(across, basis), coordinates, status)
   end subroutine coordinates_of

   !> The motion of y.
   subroutine reduce_motion(path, impact_of, twin, found, reduced)
      !> The path, reduced.
      type(structure_path_type), intent(in) :: path
      !> (N) Equal for impacts at one instant; (gaps) the gap of y of each gap.
      integer, intent(in) :: impact_of(:), twin(:)
      !> The motion.
      type(settled_type), intent(in) :: found
      !> The motion of y: gaps, cycles, phases, speeds and states.
      type(settled_type), intent(out) :: reduced
      real(wp), allocatable :: q(:, :), rate(:, :)
      integer, allocatable :: last(:)
      integer :: i, n, status

      n = size(path%part, 1)
      allocate (last(impact_of(size(impact_of))))
      last = [(findloc(impact_of, i, dim=1, back=.true.), i=1, size(last))]
      reduced%gaps = twin(found%gaps(last))
      reduced%cycles = found%cycles
      allocate (reduced%resting(0))
      associate (mass => path%whole%mass, states => found%motion%states(:, last))
         call coordinates_of(mass, path%part, states(:n, :), q, status)
         call coordinates_of(mass, path%part, states(n + 1:, :), rate, status)
      end associate
      allocate (reduced%motion%states(2*size(q, 1), size(last)))
      reduced%motion%states(:size(q, 1), :) = q
      reduced%motion%states(size(q, 1) + 1:, :) = rate
      reduced%motion%phases = found%motion%phases(last)
      reduced%motion%speeds = found%motion%speeds(last)
   end subroutine reduce_motion

   !> The impacts of the whole structure.
   pure type(family_type) function whole_family(s, family)
      !> The structure.
      type(structure_members_type), intent(in) :: s
      !> The impacts of y.
      type(family_type), intent(in) :: family

      whole_family = family
      whole_family%mirror = .false.
      whole_family%sides = s%gaps
   end function whole_family

   !> The same motion of the whole structure.
   pure subroutine whole_member(s, member, all)
      !> The structure.
      type(structure_members_type), intent(in) :: s
      !> The motion of y, with its flights.
      type(member_type), intent(in) :: member
      !> The motion: gaps and times of its equations, speeds and offsets.
      type(member_type), intent(out) :: all
      real(wp), allocatable, dimension(:) :: y, y_rate, q, rate, x, v, x_here, v_here
      integer, allocatable :: pairs(:)
      real(wp) :: phase, impulse, slope
      integer :: h, i

      all%structure = member%whole_structure
      all%regime = member%whole_regime
      all%exists = .true.
      all%equations%gaps = s%gaps
      all%equations%times = member%equations%times(s%impact_of)
      all%equations%period = member%equations%period
      all%speeds = member%speeds(s%impact_of)
      allocate (pairs, source=offset_pairs(all%regime))
      allocate (all%offsets(size(pairs)), source=0.0_wp)
      if (size(pairs) == 0) return
      phase = all%regime%frequency*all%equations%times(1)
      associate (regime => member%regime, x_after => member%x_after(:, 1), &
         v_after => member%v_after(:, 1))
         y = matmul(regime%qx, x_after) + matmul(regime%qv, v_after)
         y_rate = matmul(regime%dx, x_after) + matmul(regime%dv, v_after)
         do h = 1, size(regime%steady, 2)
            associate (turn => cmplx(cos(h*phase), sin(h*phase), wp))
               y = y + real(regime%steady(:, h)*turn)
               y_rate = y_rate + real(regime%steady_rate(:, h)*turn)
            end associate
         end do
      end associate
      q = matmul(s%path%part, y)
      rate = matmul(s%path%part, y_rate)
      ! the offsets count from just after the first impact alone
      do i = 2, size(s%gaps)
         if (s%impact_of(i) > 1) exit
         call impulse_of(all%structure, s%gaps(i), all%speeds(i), impulse, slope)
         rate = rate + impulse*all%structure%mobility(:, s%gaps(i))
      end do
      allocate (x(size(all%regime%modes%stiffness)), v(size(all%regime%modes%stiffness)))
      allocate (x_here, v_here, mold=x)
      call to_pairs(all%regime, phase, q, rate, x, v)
      call state_after(all%structure, all%regime, all%equations, all%speeds, all%offsets, 1, &
         x_here, v_here)
      all%offsets = x(pairs) - x_here(pairs)
   end subroutine whole_member

   !> The multipliers of disturbances that part impacts at one instant, over a whole period.
   pure subroutine multipliers_beside(s, member, multipliers, good)
      !> The structure.
      type(structure_members_type), intent(in) :: s
      !> The motion of y, with its flights.
      type(member_type), intent(in) :: member
      !> (2l) The multipliers.
      complex(wp), allocatable, intent(out) :: multipliers(:)
      !> False if an impact has no approach speed, or DGEEV failed.
      logical, intent(out) :: good
      type(member_type) :: all
      type(family_type) :: family
      real(wp), allocatable, dimension(:, :) :: beside, y, d, p, q, rate, map
      real(wp) :: re(2*size(s%beside, 2)), im(2*size(s%beside, 2)), work(132*size(s%beside, 2)), &
         unused(1, 1)
      integer :: first, i, info, j, l, n, next, status

      n = size(s%beside, 1)
      l = size(s%beside, 2)
      call whole_member(s, member, all)
      family%sides = s%gaps
      call set_flights(family, all)
      call coordinates_of(all%structure%mass, s%path%part, s%beside, y, status)
      good = status == stat%ok
      if (.not. good) return
      beside = s%beside - matmul(s%path%part, y)
      allocate (p(2*n, 2*l), source=0.0_wp)
      p(:n, :l) = beside
      p(n + 1:, l + 1:) = beside
      allocate (d(2*size(all%x_after, 1), 2*l))
      call from_coordinates(all%regime, p, d)
      ! from just after all impacts of an instant
      first = count(s%impact_of == 1)
      do j = first, first + size(s%gaps) - 1
         i = modulo(j - 1, size(s%gaps)) + 1
         next = modulo(i, size(s%gaps)) + 1
         call apply_flight(all%regime, flight_duration(all, i), d)
         good = abs(all%speeds(next)) > 0
         if (.not. good) return
         call apply_impact(all%structure, all%regime, s%gaps(next), &
            all%regime%frequency*all%equations%times(next), all%speeds(next), &
            all%x_before(:, i + 1), all%v_before(:, i + 1), all%x_after(:, i + 1), &
            all%v_after(:, i + 1), d, status)
      end do
      call to_coordinates(all%regime, d, p)
      call coordinates_of(all%structure%mass, beside, p(:n, :), q, status)
      if (status == stat%ok) call coordinates_of(all%structure%mass, beside, p(n + 1:, :), rate, &
         status)
      good = status == stat%ok
      if (.not. good) return
      allocate (map(2*l, 2*l))
      map(:l, :) = q
      map(l + 1:, :) = rate
      good = all_finite(map)
      if (.not. good) return
      call geev('N', 'N', 2*l, map, 2*l, re, im, unused, 1, unused, 1, work, size(work), info)
      good = info == 0
      multipliers = cmplx(re, im, wp)
   end subroutine multipliers_beside

   !> Whether no entry is infinite or NaN.
   pure logical function all_finite(matrix)
      !> The matrix.
      real(wp), intent(in) :: matrix(:, :)

      all_finite = all(abs(matrix) <= huge(1.0_wp))
   end function all_finite

   !> Whether two multipliers are always equal: their crossings of the unit circle would not change
   !! the sign of a product.
   pure logical function are_multiple(multipliers)
      !> Those of disturbances that part impacts.
      complex(wp), intent(in) :: multipliers(:)
      real(wp), parameter :: equal = 1.0e-9_wp, least = 1.0e-3_wp
      integer :: i

      are_multiple = .false.
      do i = 1, size(multipliers)
         if (abs(multipliers(i)) < least) cycle
         are_multiple = are_multiple .or. count(abs(multipliers - multipliers(i)) < &
            equal*abs(multipliers(i))) > 1
      end do
   end function are_multiple

end module vi_structure_together
