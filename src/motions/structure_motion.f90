!> Periodic motions of a structure from presumed impact times, the idea of the 1983 paper: given the
!! times, all else is linear.
!!
!! Unknown are the approach speeds of N impacts and the offsets of pairs of frequency 0. Equations:
!! each gap is closed at its impact, its approach speed is that of the motion, and the impulses on
!! each pair of frequency 0 balance the constant forces. DGELS solves them; the residual measures
!! how far the times are from those of a motion. `solve_in_full` keeps the state after the first
!! impact as unknown instead, with the periodicity among the equations.
module vi_structure_motion
   use vi_kinds, only: two_pi, wp
   use vi_lapack, only: least_squares, least_squares_work
   use vi_modes, only: advance, departure, step_functions
   use vi_restitution, only: constant_law
   use vi_responses, only: forced_row, jumps_of, offset_pairs, pair_response, periodic_pair, &
      periodic_pair_type, ripple_row, row_of_gap, steady_pairs
   use vi_status, only: stat
   use vi_structure, only: regime_type, restitution_of, structure_type
   implicit none (type, external)
   private

   public :: impulse_of, new_equations, relative, residuals, since, solve_in_full, solve_linear, &
      state_after, transitions

   !> The equations of a periodic motion with given gaps, and their derivatives with respect to the
   !! times.
   type, public :: equations_type
      !> The gaps of the impacts, and the times of the impacts in ascending order.
      integer, allocatable :: gaps(:)
      real(wp), allocatable :: times(:)
      !> The period.
      real(wp) :: period = 0
      !> (N, N, 0:2) Derivatives of G_i.q at impact i due to a unit impulse at impact j.
      real(wp), allocatable :: response(:, :, :)
      !> (N, 0:2) The same due to the load and the constant forces.
      real(wp), allocatable :: forced(:, :)
      !> (N, p) Coefficients of the offsets in G_i.q.
      real(wp), allocatable :: by_offset(:, :)
      !> (p, N) What a unit impulse adds to the balance of each pair of frequency 0, and (p) what
      !! the constant forces add within a period.
      real(wp), allocatable :: balance(:, :), supplied(:)
      !> (p) Whether no impact acts on a pair of frequency 0 or depends on it, as for a free mass
      !! that hits nothing: its offset is any, and 0 here.
      logical, allocatable :: apart(:)
   end type equations_type

contains

   !> The equations for given times.
   pure subroutine new_equations(structure, regime, gaps, times, period, equations, status)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Its regime without resting gaps.
      type(regime_type), intent(in) :: regime
      !> (N) The gaps of the impacts.
      integer, intent(in) :: gaps(:)
      !> (N) Their times, in ascending order, within less than a period; the period.
      real(wp), intent(in) :: times(:), period
      !> The equations.
      type(equations_type), intent(out) :: equations
      !> `stat%ok`; `stat%resonance` where an undamped pair resonates with the period;
      !! `stat%unbalanced` where no impulses balance a constant force on a pair of frequency 0.
      integer, intent(out) :: status
      real(wp), dimension(size(regime%modes%stiffness), size(gaps)) :: in_x, in_v, of_x, of_v
      integer, allocatable :: pairs(:)
      real(wp) :: x(0:2), v(0:2), least
      type(periodic_pair_type) :: pair
      logical, allocatable :: participates(:)
      integer :: i, j, k, n

      n = size(gaps)
      status = stat%ok
      equations%gaps = gaps
      equations%times = times
      equations%period = period
      allocate (pairs, source=offset_pairs(regime))
      allocate (equations%response(n, n, 0:2), equations%forced(n, 0:2))
      do i = 1, n
         call jumps_of(structure, regime, gaps(i), in_x(:, i), in_v(:, i))
         call row_of_gap(structure, regime, gaps(i), of_x(:, i), of_v(:, i))
         call forced_row(structure, regime, gaps(i), regime%frequency*times(i), &
            equations%forced(i, :))
      end do
      equations%response = 0
      do k = 1, size(regime%modes%stiffness)
         pair = periodic_pair(regime%modes%stiffness(k), regime%modes%damping(k), period)
         do j = 1, n
            if (.not. abs(in_x(k, j)) + abs(in_v(k, j)) > 0) cycle
            do i = 1, n
               if (.not. abs(of_x(k, i)) + abs(of_v(k, i)) > 0) cycle
               call pair_response(pair, in_x(k, j), in_v(k, j), since(times, period, i, j), x, v)
               if (pair%resonant) status = stat%resonance
               equations%response(i, j, :) = equations%response(i, j, :) + of_x(k, i)*x &
                  + of_v(k, i)*v
            end do
         end do
      end do
      equations%by_offset = transpose(of_x(pairs, :))
      allocate (equations%balance(size(pairs), n), equations%supplied(size(pairs)))
      do k = 1, size(pairs)
         associate (drag => 2*regime%modes%damping(pairs(k)))
            equations%balance(k, :) = drag*in_x(pairs(k), :) + in_v(pairs(k), :)
            equations%supplied(k) = period*(drag*regime%modes%drift(pairs(k)) &
               + regime%modes%force(pairs(k)))
         end associate
      end do
      least = 1.0e-12_wp*period*(norm2(regime%modes%force) &
         + 2*norm2(regime%modes%damping*regime%modes%drift))
      allocate (participates(size(pairs)))
      do k = 1, size(pairs)
         ! the sum over all pairs of the coefficient times the jump is 1/m of the gap: a share of it
         ! that is a square of rounding errors is 0
         participates(k) = any(abs(equations%by_offset(:, k)*equations%balance(k, :))* &
            structure%effective(gaps) > (64*size(of_x, 1)*epsilon(1.0_wp))**2)
         if (.not. participates(k)) then
            equations%by_offset(:, k) = 0
            equations%balance(k, :) = 0
         end if
         ! impulses are never negative
         if (all(equations%balance(k, :)*equations%supplied(k) >= 0) .and. &
            abs(equations%supplied(k)) > least) status = stat%unbalanced
         if (.not. participates(k)) equations%supplied(k) = 0
      end do
      if (norm2(equations%supplied) > least .and. .not. is_in_span(equations%balance, &
         equations%supplied)) status = stat%unbalanced
      equations%apart = .not. participates
   end subroutine new_equations

   !> Whether a vector is a combination of others, except for rounding.
   pure logical function is_in_span(vectors, vector)
      !> (p, N) The others.
      real(wp), intent(in) :: vectors(:, :)
      !> (p) The vector.
      real(wp), intent(in) :: vector(:)
      real(wp), parameter :: rounding = 1.0e-10_wp
      real(wp) :: basis(size(vector), size(vector)), part(size(vector)), rest(size(vector))
      integer :: j, n

      n = 0
      rest = vector
      do j = 1, size(vectors, 2)
         if (n == size(vector)) exit
         part = vectors(:, j)
         ! once more, against rounding
         part = part - matmul(basis(:, :n), matmul(part, basis(:, :n)))
         part = part - matmul(basis(:, :n), matmul(part, basis(:, :n)))
         if (norm2(part) <= rounding*norm2(vectors(:, j))) cycle
         n = n + 1
         basis(:, n) = part/norm2(part)
         rest = rest - dot_product(rest, basis(:, n))*basis(:, n)
      end do
      is_in_span = norm2(rest) <= rounding*norm2(vector)
   end function is_in_span

   !> Time from impact j to the next instant of impact i; the whole period for the same impact, so
   !! that what acts there is what arrives.
   pure real(wp) function since(times, period, i, j) result(time)
      !> The times of the impacts, and the period.
      real(wp), intent(in) :: times(:), period
      !> Two impacts.
      integer, intent(in) :: i, j

      time = times(i) - times(j)
      if (i <= j) time = time + period
   end function since

   !> The impulse of an impact with a given approach speed, and its derivative.
   pure subroutine impulse_of(structure, gap, speed, impulse, slope)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The gap.
      integer, intent(in) :: gap
      !> The approach speed.
      real(wp), intent(in) :: speed
      !> The impulse, and its derivative with respect to the approach speed.
      real(wp), intent(out) :: impulse, slope
      real(wp) :: restitution, by_speed

      call restitution_of(structure, gap, max(0.0_wp, speed), restitution, by_speed)
      impulse = (1 + restitution)*structure%effective(gap)*speed
      slope = (1 + restitution + by_speed*speed)*structure%effective(gap)
   end subroutine impulse_of

   !> The residuals of the equations, each with the sum of the absolute terms in it, and the
   !! derivatives.
   pure subroutine residuals(structure, equations, speeds, offsets, value, scale, jacobian)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The equations.
      type(equations_type), intent(in) :: equations
      !> (N) Approach speeds; (p) offsets.
      real(wp), intent(in) :: speeds(:), offsets(:)
      !> (2N + p) Residuals: gaps, approach speeds, balances.
      real(wp), intent(out) :: value(:)
      !> (2N + p) Their scales.
      real(wp), intent(out) :: scale(:)
      !> (2N + p, 2N + p) Derivatives with respect to the times, the speeds, the offsets.
      real(wp), intent(out), optional :: jacobian(:, :)
      real(wp), dimension(size(speeds)) :: impulses, slopes, usual
      integer :: i, j, n

      n = size(speeds)
      do i = 1, n
         call impulse_of(structure, equations%gaps(i), speeds(i), impulses(i), slopes(i))
      end do
      associate (response => equations%response, forced => equations%forced, &
         openings => structure%openings(equations%gaps))
         value(:n) = matmul(response(:, :, 0), impulses) + matmul(equations%by_offset, offsets) &
            + forced(:, 0) - openings
         scale(:n) = matmul(abs(response(:, :, 0)), abs(impulses)) &
            + matmul(abs(equations%by_offset), abs(offsets)) + abs(forced(:, 0)) + abs(openings)
         value(n + 1:2*n) = speeds - matmul(response(:, :, 1), impulses) - forced(:, 1)
         ! where all speeds vanish, displacements over the time of a radian remain
         usual = two_pi/equations%period*(abs(forced(:, 0)) + abs(openings))
         scale(n + 1:2*n) = abs(speeds) + matmul(abs(response(:, :, 1)), abs(impulses)) &
            + abs(forced(:, 1)) + usual
         value(2*n + 1:) = matmul(equations%balance, impulses) + equations%supplied
         scale(2*n + 1:) = matmul(abs(equations%balance), abs(impulses) &
            + structure%effective(equations%gaps)*usual) + abs(equations%supplied)
         do i = 1, size(offsets)
            if (equations%apart(i)) value(2*n + i) = offsets(i)
            if (equations%apart(i)) scale(2*n + i) = 1
         end do
         if (.not. present(jacobian)) return
         jacobian = 0
         do i = 1, n
            jacobian(i, i) = forced(i, 1)
            jacobian(n + i, i) = -forced(i, 2)
            do j = 1, n
               if (j == i) cycle
               jacobian(i, i) = jacobian(i, i) + response(i, j, 1)*impulses(j)
               jacobian(n + i, i) = jacobian(n + i, i) - response(i, j, 2)*impulses(j)
               jacobian(i, j) = -response(i, j, 1)*impulses(j)
               jacobian(n + i, j) = response(i, j, 2)*impulses(j)
            end do
            jacobian(:n, n + i) = response(:, i, 0)*slopes(i)
            jacobian(n + 1:2*n, n + i) = -response(:, i, 1)*slopes(i)
            jacobian(n + i, n + i) = jacobian(n + i, n + i) + 1
            jacobian(2*n + 1:, n + i) = equations%balance(:, i)*slopes(i)
         end do
         jacobian(:n, 2*n + 1:) = equations%by_offset
         do i = 1, size(offsets)
            if (equations%apart(i)) jacobian(2*n + i, 2*n + i) = 1
         end do
      end associate
   end subroutine residuals

   !> Approach speeds and offsets that satisfy the equations best (DGELS); repeated about the last
   !! speeds where coefficients of restitution depend on them.
   !!
   !! Approach speeds are compared with gaps as if they lasted for a radian of the period.
   pure subroutine solve_linear(structure, equations, speeds, offsets, residual, status)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The equations.
      type(equations_type), intent(in) :: equations
      !> (N) Approach speeds; (p) offsets.
      real(wp), intent(out) :: speeds(:), offsets(:)
      !> The largest residual, over the sum of the absolute terms of its equation.
      real(wp), intent(out) :: residual
      !> `stat%ok`, or `stat%singular`.
      integer, intent(out) :: status
      real(wp), dimension(2*size(speeds) + size(offsets)) :: value, scale, right
      real(wp), dimension(2*size(speeds) + size(offsets), 2*size(speeds) + size(offsets)) :: &
         jacobian
      real(wp), allocatable :: a(:, :), work(:)
      integer, parameter :: most = 40
      real(wp) :: unit(size(right)), columns(size(speeds) + size(offsets)), length
      integer :: i, n, pass

      n = size(speeds)
      speeds = 0
      offsets = 0
      allocate (work(least_squares_work(size(value), size(columns))))
      do pass = 1, merge(1, most, all(structure%laws(equations%gaps)%kind == constant_law))
         call residuals(structure, equations, speeds, offsets, value, scale, jacobian)
         unit(:n) = 1
         unit(n + 1:2*n) = equations%period/two_pi
         do i = 2*n + 1, size(unit)
            length = maxval(abs(jacobian(i, n + 1:)))
            unit(i) = unit(n + 1)
            if (length > 0) unit(i) = unit(n + 1)/length
         end do
         a = jacobian(:, n + 1:)
         right = -unit*value
         do i = 1, size(a, 2)
            a(:, i) = unit*a(:, i)
            columns(i) = norm2(a(:, i))
            if (columns(i) > 0) a(:, i) = a(:, i)/columns(i)
         end do
         call least_squares(a, right, work, length, status)
         if (status /= stat%ok) return
         right(:size(columns)) = right(:size(columns))/columns
         speeds = speeds + right(:n)
         offsets = offsets + right(n + 1:size(columns))
         if (maxval(abs(right(:n))) <= 1.0e-13_wp*maxval(abs(speeds))) exit
      end do
      call residuals(structure, equations, speeds, offsets, value, scale)
      residual = relative(value, scale)
   end subroutine solve_linear

   !> The largest residual over its scale.
   pure real(wp) function relative(value, scale)
      !> Residuals and scales.
      real(wp), intent(in) :: value(:), scale(:)

      relative = maxval(abs(value)/max(scale, tiny(1.0_wp)))
   end function relative

   !> The pairs just after an impact.
   pure subroutine state_after(structure, regime, equations, speeds, offsets, at, x, v)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Its regime without resting gaps.
      type(regime_type), intent(in) :: regime
      !> The equations.
      type(equations_type), intent(in) :: equations
      !> (N) Approach speeds; (p) offsets.
      real(wp), intent(in) :: speeds(:), offsets(:)
      !> The impact.
      integer, intent(in) :: at
      !> (m) The pairs.
      real(wp), intent(out) :: x(:), v(:)
      real(wp), dimension(size(x)) :: in_x, in_v
      real(wp) :: impulse, slope, of_x(0:2), of_v(0:2), time
      type(periodic_pair_type) :: pair(size(x))
      integer, allocatable :: pairs(:)
      integer :: j, k

      call steady_pairs(regime%modes%stiffness, regime%modes%damping, regime%modes%drift, &
         regime%modes%force, x, v)
      allocate (pairs, source=offset_pairs(regime))
      x(pairs) = offsets
      pair = periodic_pair(regime%modes%stiffness, regime%modes%damping, equations%period)
      do j = 1, size(speeds)
         call impulse_of(structure, equations%gaps(j), speeds(j), impulse, slope)
         call jumps_of(structure, regime, equations%gaps(j), in_x, in_v)
         time = 0
         if (j /= at) time = since(equations%times, equations%period, at, j)
         do k = 1, size(x)
            if (.not. abs(in_x(k)) + abs(in_v(k)) > 0) cycle
            call pair_response(pair(k), in_x(k), in_v(k), time, of_x, of_v)
            x(k) = x(k) + impulse*of_x(0)
            v(k) = v(k) + impulse*of_v(0)
         end do
      end do
   end subroutine state_after

   !> The same motion with the state just after the first impact among the unknowns: 2N + 2n
   !! equations (gaps, approach speeds, periodicity) in N + 2n unknowns.
   pure subroutine solve_in_full(structure, regime, equations, speeds, x, v, status)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Its regime without resting gaps.
      type(regime_type), intent(in) :: regime
      !> Gaps, times and period.
      type(equations_type), intent(in) :: equations
      !> (N) Approach speeds.
      real(wp), intent(out) :: speeds(:)
      !> (m) The pairs just after the first impact.
      real(wp), intent(out) :: x(:), v(:)
      !> `stat%ok`, or `stat%singular`.
      integer, intent(out) :: status
      real(wp), allocatable :: state(:, :), a(:, :), right(:), work(:), columns(:)
      integer, allocatable :: pairs(:)
      real(wp), dimension(size(x)) :: in_x, in_v, of_x, of_v, to_x, to_v
      real(wp) :: d(0:2), impulse, slope, length, unit
      integer :: i, j, m, n, unknowns, next

      m = size(x)
      n = size(speeds)
      unknowns = 2*m + n
      ! how the pairs depend on the unknowns, and in the last column what does not
      allocate (pairs, source=pack(offset_pairs(regime), equations%apart))
      allocate (state(2*m, unknowns + 1), a(2*m + 2*n + size(pairs), unknowns), &
         right(2*m + 2*n + size(pairs)), source=0.0_wp)
      allocate (columns(unknowns))
      do i = 1, size(pairs)
         a(2*m + 2*n + i, pairs(i)) = 1
      end do
      do i = 1, 2*m
         state(i, i) = 1
      end do
      unit = equations%period/two_pi
      do i = 1, n
         call row_of_gap(structure, regime, equations%gaps(i), of_x, of_v)
         call ripple_row(structure, regime, equations%gaps(i), regime%frequency* &
            equations%times(i), d)
         a(i, :) = matmul(of_x, state(:m, :unknowns)) + matmul(of_v, state(m + 1:, :unknowns))
         right(i) = structure%openings(equations%gaps(i)) - d(0) &
            - dot_product(of_x, state(:m, unknowns + 1)) &
            - dot_product(of_v, state(m + 1:, unknowns + 1))
         next = modulo(i, n) + 1
         call propagate(regime, since(equations%times, equations%period, next, i), state)
         ! the approach speed, with x' = v + p, v' = -omega^2 x - 2 sigma v + f
         call row_of_gap(structure, regime, equations%gaps(next), of_x, of_v)
         call ripple_row(structure, regime, equations%gaps(next), regime%frequency* &
            equations%times(next), d)
         associate (modes => regime%modes)
            to_x = -of_v*modes%stiffness
            to_v = of_x - 2*of_v*modes%damping
            d(1) = d(1) + dot_product(of_x, modes%drift) + dot_product(of_v, modes%force)
         end associate
         a(n + next, :) = unit*(matmul(to_x, state(:m, :unknowns)) &
            + matmul(to_v, state(m + 1:, :unknowns)))
         a(n + next, 2*m + next) = a(n + next, 2*m + next) - unit
         right(n + next) = -unit*(d(1) + dot_product(to_x, state(:m, unknowns + 1)) &
            + dot_product(to_v, state(m + 1:, unknowns + 1)))
         call impulse_of(structure, equations%gaps(next), 1.0_wp, impulse, slope)
         call jumps_of(structure, regime, equations%gaps(next), in_x, in_v)
         state(:m, 2*m + next) = state(:m, 2*m + next) + impulse*in_x
         state(m + 1:, 2*m + next) = state(m + 1:, 2*m + next) + impulse*in_v
      end do
      ! in the periodicity, 1 is taken from the diagonal without loss of digits near a resonance
      call transitions(regime, equations%period, in_x, in_v, of_x, of_v)
      associate (lack => departure(regime%modes%stiffness, regime%modes%damping, equations%period))
         do i = 1, m
            state(i, [i, m + i]) = [-lack(i), in_v(i)]
            state(m + i, [i, m + i]) = [of_x(i), -lack(i) - 2*regime%modes%damping(i)*in_v(i)]
         end do
      end associate
      do i = 1, 2*m
         length = merge(1.0_wp, unit, i <= m)
         a(2*n + i, :) = length*state(i, :unknowns)
         right(2*n + i) = -length*state(i, unknowns + 1)
      end do
      do j = 1, unknowns
         columns(j) = norm2(a(:, j))
         if (columns(j) > 0) a(:, j) = a(:, j)/columns(j)
      end do
      allocate (work(least_squares_work(size(a, 1), size(a, 2))))
      call least_squares(a, right, work, length, status)
      if (status /= stat%ok) return
      right(:unknowns) = right(:unknowns)/columns
      x = right(:m)
      v = right(m + 1:2*m)
      speeds = right(2*m + 1:unknowns)
   end subroutine solve_in_full

   !> Advances all columns of a linear dependence of the pairs; the last one with the constant
   !! terms.
   pure subroutine propagate(regime, time, state)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> How long.
      real(wp), intent(in) :: time
      !> (2m, columns) In and out.
      real(wp), intent(inout) :: state(:, :)
      real(wp), dimension(size(state, 1)/2) :: xx, xv, vx, vv, zero, x, v
      real(wp) :: before
      integer :: j, k, m

      m = size(zero)
      zero = 0
      call advance(regime%modes, time, zero, zero, x, v)
      call transitions(regime, time, xx, xv, vx, vv)
      do j = 1, size(state, 2)
         do k = 1, m
            before = state(k, j)
            state(k, j) = xx(k)*before + xv(k)*state(m + k, j)
            state(m + k, j) = vx(k)*before + vv(k)*state(m + k, j)
         end do
      end do
      j = size(state, 2)
      state(:m, j) = state(:m, j) + x
      state(m + 1:, j) = state(m + 1:, j) + v
   end subroutine propagate

   !> The coefficients by which a flight takes pairs to pairs.
   pure subroutine transitions(regime, time, xx, xv, vx, vv)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> Duration of the flight.
      real(wp), intent(in) :: time
      !> (m) x from x and from v; v from x and from v.
      real(wp), intent(out) :: xx(:), xv(:), vx(:), vv(:)
      integer :: k

      do k = 1, size(xx)
         associate (stiffness => regime%modes%stiffness(k), damping => regime%modes%damping(k))
            call step_functions(stiffness, damping, time, xx(k), xv(k))
            vx(k) = -stiffness*xv(k)
            vv(k) = xx(k) - 2*damping*xv(k)
         end associate
      end do
   end subroutine transitions

end module vi_structure_motion
