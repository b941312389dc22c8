!> The bounds that prove that a row of a structure stays within its limits, compared with the
!! extremes that they bound, and the search that uses them, compared with dense samples.
module mechanics_channels
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, draw_log, fill, random_type
   use vi_channels, only: bound_fourth, bound_second, first_event, leaving_type, pace_type, &
      reached_type, row_derivatives, space_type
   use vi_kinds, only: wp
   use vi_lane_groups, only: add_derivatives, bound_free_pairs, bound_pairs, sizes_of_free_pairs, &
      sizes_of_pairs, sum_bounds
   use vi_lane_groups_wide, only: add_derivatives_wide => add_derivatives, &
      bound_free_pairs_wide => bound_free_pairs, bound_pairs_wide => bound_pairs, &
      sizes_of_free_pairs_wide => sizes_of_free_pairs, sizes_of_pairs_wide => sizes_of_pairs
   use vi_lane_rows, only: advance_pairs, side_by_side, start_free_series, start_series, step_pairs
   use vi_lane_rows_wide, only: advance_pairs_wide => advance_pairs, &
      start_free_series_wide => start_free_series, step_pairs_wide => step_pairs
   use vi_modes, only: advance, advance_in_place, advance_pair, bound_on, modes_type, prepare, &
      step_functions
   use vi_processor, only: runs_wide
   use vi_series, only: order, step_budget, tolerated
   use vi_status, only: stat
   use vi_structure, only: check_structure, load_type, new_load, new_regime, new_structure, &
      regime_type, state_of, structure_type, to_pairs
   implicit none (type, external)
   private

   public :: test_channels

   type(random_type) :: random
   real(wp), parameter :: pi = acos(-1.0_wp)

contains

   subroutine test_channels()
      integer :: i

      call test_tolerated()
      do i = 1, 300
         call check_sizes()
         call check_driven()
         call test_heavy_damping()
      end do
      do i = 1, 300
         call test_pair()
         call check_advance()
         call check_registers()
         if (mod(i, 2) == 0) call check_rows(mod(i/2, 3))
         if (mod(i, 2) == 0) call check_constants()
      end do
      do i = 1, 300
         call check_search()
      end do
      do i = 1, 300
         call test_interrupted()
         call test_tiny_stiffness()
         call test_budget()
         call test_plain_registers()
      end do
   end subroutine test_channels

   !> bound t^n/(order + 1)! is the tolerance.
   subroutine test_tolerated()
      real(wp) :: tolerance, bound, t
      integer :: i, n

      do i = 1, 1000
         tolerance = draw_log(random, 1e-20_wp, 1.0_wp)
         bound = draw_log(random, 1e-10_wp, 1e30_wp)
         n = draw_integer(random, order - 2, order + 1)
         t = tolerated(tolerance, bound, n)
         call check_close(log(bound) + n*log(t) - log_gamma(order + 2.0_wp), log(tolerance), &
            1e-11_wp, 'tolerated: a term as large as the tolerance')
      end do
      call check(tolerated(1.0_wp, 0.0_wp, order) >= huge(t), 'tolerated: nothing is omitted')
   end subroutine test_tolerated

   !> Bounds on a pair x' = v, v' = -omega^2 x - 2 sigma v from its start on.
   subroutine test_pair()
      integer, parameter :: samples = 400
      real(wp) :: stiffness, damping, x, v, of_x, of_v, omega, rate, t, most(2)
      complex(wp) :: c, lambda
      integer :: i

      stiffness = draw_log(random, 1e-2_wp, 1e2_wp)
      omega = sqrt(stiffness)
      damping = omega*draw_log(random, 1e-4_wp, 0.95_wp)
      x = draw(random, -1.0_wp, 1.0_wp)
      v = omega*draw(random, -1.0_wp, 1.0_wp)
      call bound_on(stiffness, 2*damping, x, v, of_x, of_v)
      rate = sqrt(stiffness - damping**2)
      lambda = cmplx(-damping, rate, wp)
      c = cmplx(x, -(v + damping*x)/rate, wp)
      most = 0
      do i = 0, samples
         t = i*(2*pi/omega)/samples
         most(1) = max(most(1), abs(real(c*exp(lambda*t))))
         most(2) = max(most(2), abs(real(lambda*c*exp(lambda*t))))
      end do
      call check(all(most <= [of_x, of_v]*(1 + 1e-12_wp)), 'pair: bounds on x and v')
      if (damping < 1e-2_wp*omega) call check(all(1.1_wp*most >= [of_x, of_v]), &
         'pair: which are the amplitudes')
      call bound_on(0.0_wp, 2*damping, x, v, of_x, of_v)
      call check_close(of_x, abs(x), 0.0_wp, 'pair: a free mass keeps x')
      call check_close(of_v, abs(v), 0.0_wp, 'pair: and v')
   end subroutine test_pair

   !> A pair far above critical damping: its bounds hold from its start on, are at most some times
   !! its extremes, however small its stiffness is, and tend to those without stiffness. They
   !! shrink by no more than the factor with which the search estimates bounds of higher orders.
   subroutine test_heavy_damping()
      integer, parameter :: samples = 400
      real(wp) :: stiffness, damping, drag, x(6), v(6), before, of_x, of_v, slow, t, u, w, &
         most, free, of_fourth(1), unused(1)
      integer :: i, n

      damping = draw_log(random, 1e-2_wp, 1e2_wp)
      drag = 2*damping
      stiffness = damping**2*draw_log(random, 1e-70_wp, 0.99_wp)
      x(1) = draw(random, -1.0_wp, 1.0_wp)
      v(1) = damping*draw(random, -1.0_wp, 1.0_wp)
      do n = 2, size(x)
         x(n) = v(n - 1)
         v(n) = -stiffness*x(n - 1) - drag*v(n - 1)
      end do
      call bound_on(stiffness, drag, x(1), v(1), of_x, of_v)
      slow = stiffness/(damping + sqrt(damping**2 - stiffness))
      most = abs(x(1))
      do i = 0, samples
         ! several of the time of each exponential
         t = min(10.0_wp**(-3 + i*6.0_wp/samples), 40.0_wp)/merge(damping, slow, mod(i, 2) == 0)
         call step_functions(stiffness, damping, t, u, w)
         most = max(most, abs(u*x(1) + w*v(1)))
      end do
      call check(most <= of_x*(1 + 1e-12_wp), 'heavy damping: a bound on x')
      call check(of_x <= (2*abs(x(1)) + abs(v(1))/drag)*(1 + 1e-12_wp), &
         'heavy damping: from x and v')
      call check(of_x <= 6*most, 'heavy damping: not much more than needed')
      ! from the second order on x is the v of the order below
      do n = 2, size(x)
         call bound_on(stiffness, drag, x(n), v(n), of_x, of_v)
         call bound_on(0.0_wp, drag, x(n), v(n), free, unused(1))
         if (stiffness < 1e-20_wp*damping**2 .and. abs(x(n)) > 0) call check_close(of_x/free, &
            1.0_wp, 1e-12_wp, 'heavy damping: as without stiffness')
         if (n > 2) call check(of_x <= (sqrt(stiffness) + drag)*before*(1 + 1e-12_wp), &
            'heavy damping: bounds of higher orders')
         before = of_x
      end do
      call bound_pairs(1, [stiffness], [damping], [1/sqrt(stiffness)], [0.0_wp], [0.0_wp], &
         [0.0_wp], [0.0_wp], x(1:1), v(1:1), of_fourth, unused)
      call bound_on(stiffness, drag, x(5), v(5), of_x, of_v)
      call check_close(of_fourth(1)/of_x, 1.0_wp, 1e-9_wp, 'heavy damping: fourth derivatives')
   end subroutine test_heavy_damping

   !> A mass with a tiny stiffness, with and without a dashpot and a constant force, hits a wall, or
   !! misses it, as without stiffness, at the same time, and in as few steps.
   subroutine test_tiny_stiffness()
      type(structure_type) :: structure
      type(load_type) :: load
      type(regime_type) :: regime
      type(space_type) :: space
      type(pace_type) :: pace
      type(reached_type) :: free, reached
      real(wp) :: matrices(1, 1, 3), damping, force, speed, limit, x(1), v(1)
      integer :: i, status

      damping = merge(0.0_wp, draw_log(random, 1e-2_wp, 1e1_wp), draw_integer(random, 0, 1) == 0)
      force = merge(0.0_wp, draw(random, -1.0_wp, 1.0_wp), draw_integer(random, 0, 1) == 0)
      speed = draw(random, 0.1_wp, 2.0_wp)
      limit = draw_log(random, 1.0_wp, 1e3_wp)
      load = new_load(0.0_wp, reshape([real(wp) ::], [1, 2, 0]), [force])
      do i = 0, 3
         matrices = reshape([1.0_wp, damping, merge(10.0_wp**(-22*i), 0.0_wp, i > 0)], [1, 1, 3])
         structure = new_structure(matrices, reshape([1.0_wp], [1, 1]), &
            reshape([1.0_wp, 0.5_wp], [2, 1]))
         call check_structure(structure, status)
         call new_regime(structure, load, [integer ::], regime, status)
         call check(status == stat%ok, 'tiny stiffness: a structure')
         call to_pairs(regime, 0.0_wp, [0.0_wp], [speed], x, v)
         pace = pace_type()
         call first_event(regime, x, v, 0.0_wp, leaving_type(), limit, pace, reached, space)
         call check(reached%complete, 'tiny stiffness: the search ends')
         if (i == 0) free = reached
         call check(reached%row == free%row, 'tiny stiffness: the same wall')
         call check_close(reached%time, free%time, 1e-9_wp*(1 + free%time), &
            'tiny stiffness: at the same time')
         call check(reached%steps <= 2*free%steps + 20, 'tiny stiffness: in as few steps')
      end do
   end subroutine test_tiny_stiffness

   !> Pairs side by side, compared with one by one and with the functions of a pair, with the same
   !! bits in wide registers.
   subroutine check_advance()
      type(modes_type) :: modes
      real(wp), allocatable, dimension(:) :: x, v, x_now, v_now, x_wide, v_wide
      real(wp) :: x_one, v_one, t, scale, u, w, s2, s3
      integer :: k, n

      n = draw_integer(random, 8, 70)
      allocate (modes%stiffness(n), modes%damping(n), modes%drift(n), modes%force(n), x(n), v(n))
      allocate (x_now(n), v_now(n), x_wide(n), v_wide(n))
      do k = 1, n
         modes%stiffness(k) = draw_log(random, 1e-6_wp, 1e4_wp)
         if (draw_integer(random, 1, 4) == 1) modes%stiffness(k) = 0
         ! free, undamped, damped and over-damped pairs, and some with constant terms
         modes%damping(k) = draw(random, 0.0_wp, 1.1_wp)*sqrt(modes%stiffness(k))
         if (draw_integer(random, 1, 2) == 1) modes%damping(k) = 0
         modes%drift(k) = 0
         modes%force(k) = 0
         if (draw_integer(random, 1, 6) == 1) modes%drift(k) = draw(random, -1.0_wp, 1.0_wp)
         if (draw_integer(random, 1, 6) == 1) modes%force(k) = draw(random, -1.0_wp, 1.0_wp)
         x(k) = draw(random, -1.0_wp, 1.0_wp)
         v(k) = draw(random, -1.0_wp, 1.0_wp)
      end do
      call prepare(modes, .false.)
      t = draw_log(random, 1e-9_wp, 1e4_wp)
      call advance(modes, t, x, v, x_now, v_now)
      do k = 1, n
         call advance_pair(modes, k, t, x(k), v(k), x_one, v_one)
         scale = abs(x(k)) + (abs(v(k)) + abs(modes%drift(k)) + abs(modes%force(k))*t)*t + 1
         ! the angle is rounded in both
         scale = scale*(1 + sqrt(modes%stiffness(k))*(1 + sqrt(modes%stiffness(k))*t))
         call check_close(x_now(k), x_one, 8*epsilon(t)*scale, 'advance: x side by side')
         call check_close(v_now(k), v_one, 8*epsilon(t)*scale, 'advance: v side by side')
         associate (stiffness => modes%stiffness(k), damping => modes%damping(k), &
            drift => modes%drift(k), force => modes%force(k))
            ! t is short for some pairs, and long for others
            call step_functions(stiffness, damping, t, u, w, s2, s3)
            call check_close(x_one, u*x(k) + w*v(k) + force*s2 + drift*(w + 2*damping*s2), &
               8*epsilon(t)*scale, 'advance: x by the functions of a pair')
            call check_close(v_one, (u - 2*damping*w)*v(k) - stiffness*w*x(k) + force*w &
               - stiffness*drift*s2, 8*epsilon(t)*scale, 'advance: v by the functions of a pair')
         end associate
      end do
      x_wide = x
      v_wide = v
      call advance_in_place(modes, t, x_wide, v_wide)
      call check(all(transfer(x_wide, [0]) == transfer(x_now, [0])) .and. &
         all(transfer(v_wide, [0]) == transfer(v_now, [0])), 'advance: in place')
      t = min(t, 1/(1.0e-3_wp + maxval(modes%damping)))
      call advance(modes, t, x, v, x_now, v_now)
      call advance(modes, -t, x_now, v_now, x_wide, v_wide)
      scale = 1 + t*(1 + t)
      scale = scale*(1 + sqrt(maxval(modes%stiffness))*(1 + sqrt(maxval(modes%stiffness))*t))
      call check(maxval(abs(x_wide - x)) < 100*epsilon(t)*scale .and. &
         maxval(abs(v_wide - v)) < 100*epsilon(t)*scale, 'advance: there and back')
      if (runs_wide() == 0) return
      t = min(t, 1.0e3_wp)
      call advance_pairs(n, modes%turning, modes%damps, t, modes%turn, modes%damping, &
         modes%stiffness, x, v, x_now, v_now)
      call advance_pairs_wide(n, modes%turning, modes%damps, t, modes%turn, modes%damping, &
         modes%stiffness, x, v, x_wide, v_wide)
      call check(all(transfer(x_wide, [0]) == transfer(x_now, [0])) .and. &
         all(transfer(v_wide, [0]) == transfer(v_now, [0])), 'advance: the same bits')
   end subroutine check_advance

   !> All other procedures for pairs give the same bits in wide registers; their sums are those of
   !! the derivatives, in any order.
   subroutine check_registers()
      real(wp), allocatable :: pair(:, :), map(:, :), x(:, :), v(:, :)
      real(wp) :: duration, sums(2, 2), total(0:4, 2), exact(4), most(4)
      integer :: i, k, n

      if (runs_wide() == 0) return
      n = side_by_side*draw_integer(random, 1, 9)
      allocate (pair(n, 9), map(n, 6), x(n, 2), v(n, 2))
      do k = 1, n
         pair(k, 1) = merge(0.0_wp, draw_log(random, 1e-3_wp, 1e3_wp), &
            draw_integer(random, 1, 4) == 1)
         pair(k, 2) = draw(random, 0.0_wp, 1.1_wp)*sqrt(pair(k, 1))
         pair(k, 3) = merge(1/sqrt(max(pair(k, 1), tiny(duration))), 0.0_wp, pair(k, 1) > 0)
         call fill(random, -1.0_wp, 1.0_wp, pair(k, 4:))
         call fill(random, -1.0_wp, 1.0_wp, map(k, :))
      end do
      duration = draw_log(random, 1e-2_wp, 1e2_wp)
      associate (stiffness => pair(:, 1), damping => pair(:, 2), inverse => pair(:, 3), &
         drift => pair(:, 4), drift_rate => pair(:, 5), force => pair(:, 6), &
         force_rate => pair(:, 7), x0 => pair(:, 8), v0 => pair(:, 9))
         call step_pairs(n, map, x0, v0, x(:, 1), v(:, 1))
         call step_pairs_wide(n, map, x0, v0, x(:, 2), v(:, 2))
         call check_bits('step')
         call bound_pairs(n, stiffness, damping, inverse, drift, drift_rate, force, force_rate, &
            x0, v0, x(:, 1), v(:, 1))
         call bound_pairs_wide(n, stiffness, damping, inverse, drift, drift_rate, force, &
            force_rate, x0, v0, x(:, 2), v(:, 2))
         call check_bits('bound')
         call sizes_of_pairs(n, duration, stiffness, damping, inverse, drift, drift_rate, force, &
            force_rate, x0, v0, sums(1, 1), sums(2, 1))
         call sizes_of_pairs_wide(n, duration, stiffness, damping, inverse, drift, drift_rate, &
            force, force_rate, x0, v0, sums(1, 2), sums(2, 2))
         call check(all(transfer(sums(:, 1), [0]) == transfer(sums(:, 2), [0])), &
            'sizes: the same bits')
         x(:, 1) = x0
         v(:, 1) = v0
         do i = 1, size(exact)
            x(:, 2) = v(:, 1)
            v(:, 2) = -stiffness*x(:, 1) - 2*damping*v(:, 1)
            x(:, 1) = x(:, 2)
            v(:, 1) = v(:, 2)
            exact(i) = dot_product(map(:, 1), x(:, 1)) + dot_product(map(:, 2), v(:, 1))
            most(i) = sum(abs(x(:, 1)) + abs(v(:, 1)))
         end do
         x = spread(x0, 2, 2)
         v = spread(v0, 2, 2)
         total = 0
         call add_derivatives(n, 1, 4, .false., stiffness, 2*damping, map(:, 1), map(:, 2), &
            x(:, 1), v(:, 1), total(:, 1))
         call add_derivatives_wide(n, 1, 4, .false., stiffness, 2*damping, map(:, 1), map(:, 2), &
            x(:, 2), v(:, 2), total(:, 2))
         call check_bits('derivatives')
         call check(all(transfer(total(:, 1), [0]) == transfer(total(:, 2), [0])), &
            'derivatives: the same bits of their sums')
         call check(all(abs(total(1:, 1) - exact) <= 1e-13_wp*most), 'derivatives: their sums')
         ! without damping and v in the sums, four orders at a time give what one by one do
         total = 0
         x = spread(x0, 2, 2)
         v = spread(v0, 2, 2)
         call add_derivatives(n, 1, 4, .true., stiffness, 0*damping, map(:, 1), 0*damping, &
            x(:, 1), v(:, 1), total(:, 1))
         call add_derivatives_wide(n, 1, 4, .false., stiffness, 0*damping, map(:, 1), 0*damping, &
            x(:, 2), v(:, 2), total(:, 2))
         call check(all(abs(x(:, 1) - x(:, 2)) + abs(v(:, 1) - v(:, 2)) <= 0), &
            'derivatives: without damping')
         call check(all(abs(total(:, 1) - total(:, 2)) <= 0), 'derivatives: their sums without it')
         k = draw_integer(random, 0, n)
         call check_free_pairs(n - draw_integer(random, 0, 3), duration, [stiffness(:k), &
            0*stiffness(k + 1:)], [inverse(:k), 0*inverse(k + 1:)], x0, v0)
         call check_free_series(n, draw_integer(random, 0, n), stiffness, map(:, 1), x0, v0)
      end associate
   contains
      !> Both give the same x and v.
      subroutine check_bits(what)
         character(*), intent(in) :: what

         call check(all(transfer(x(:, 1), [0]) == transfer(x(:, 2), [0])) .and. &
            all(transfer(v(:, 1), [0]) == transfer(v(:, 2), [0])), what//': the same bits')
      end subroutine check_bits
   end subroutine check_registers

   !> Where no pair is damped or has constant terms, the procedures for such pairs give the bits of
   !! those for all pairs.
   subroutine check_free_pairs(n, duration, stiffness, inverse, x0, v0)
      !> Number of pairs, as many as are used of the others, and a time.
      integer, intent(in) :: n
      real(wp), intent(in) :: duration, stiffness(n), inverse(n), x0(n), v0(n)
      real(wp) :: none(n), bounds(n, 4), sums(5, 3)
      integer :: bent

      none = 0
      bent = findloc(stiffness > 0, .true., 1, back=.true.)
      call bound_pairs(n, stiffness, none, inverse, none, none, none, none, x0, v0, bounds(:, 1), &
         bounds(:, 4))
      call sum_bounds(n, stiffness, none, inverse, none, none, x0, v0, bounds(:, 1), sums(1, 1), &
         sums(2, 1), sums(3, 1))
      call sizes_of_pairs(n, duration, stiffness, none, inverse, none, none, none, none, x0, v0, &
         sums(4, 1), sums(5, 1))
      call bound_free_pairs(n, stiffness, inverse, x0, v0, bounds(:, 2), sums(1, 2), sums(2, 2), &
         sums(3, 2))
      call sizes_of_free_pairs(n, bent, duration, stiffness, inverse, x0, v0, sums(4, 2), &
         sums(5, 2))
      call bound_free_pairs_wide(n, stiffness, inverse, x0, v0, bounds(:, 3), sums(1, 3), &
         sums(2, 3), sums(3, 3))
      call sizes_of_free_pairs_wide(n, bent, duration, stiffness, inverse, x0, v0, sums(4, 3), &
         sums(5, 3))
      call check(all(abs(bounds(:, 2:3) - spread(bounds(:, 1), 2, 2)) <= 0), &
         'free pairs: the bounds of all pairs')
      call check(all(abs(sums(:, 2:3) - spread(sums(:, 1), 2, 2)) <= 0), &
         'free pairs: the sums of all pairs')
   end subroutine check_free_pairs

   !> The same of the beginning of a series.
   subroutine check_free_series(n, run, stiffness, of_x, x0, v0)
      !> Number of pairs, and of the first ones that are taken without a list.
      integer, intent(in) :: n, run
      real(wp), intent(in) :: stiffness(n), of_x(n), x0(n), v0(n)
      real(wp) :: none(n), terms(n, 4), x(n, 3), v(n, 3), total(3, 3)
      integer :: touched(n), k

      none = 0
      touched = [(k, k=1, run), (n + run + 1 - k, k=run + 1, n)]
      total = 0.5_wp
      call start_series(n, n, run, 1.0_wp, touched, stiffness, none, none, none, none, none, of_x, &
         none, x0, v0, x(:, 1), v(:, 1), terms, total(:2, 1), total(3, 1))
      call start_free_series(n, n, run, touched, stiffness, of_x, x0, v0, x(:, 2), v(:, 2), &
         terms(:, :2), total(:2, 2), total(3, 2))
      call start_free_series_wide(n, n, run, touched, stiffness, of_x, x0, v0, x(:, 3), v(:, 3), &
         terms(:, :2), total(:2, 3), total(3, 3))
      call check(all(abs(x(:, 2:) - spread(x(:, 1), 2, 2)) + abs(v(:, 2:) - spread(v(:, 1), 2, 2)) &
         <= 0), 'free pairs: the derivatives of all pairs')
      call check(all(abs(total(:, 2:) - spread(total(:, 1), 2, 2)) <= 0), &
         'free pairs: the series of all pairs')
   end subroutine check_free_series

   !> Sums of squares of bounds on pairs: of no force, and of a free mass with forces, they bound
   !! the extremes of the pairs; signs do not matter, and many pairs have the sum of each.
   subroutine check_sizes()
      type(modes_type) :: modes
      real(wp), allocatable, dimension(:) :: x, v, x_now, v_now, sign_of
      real(wp) :: duration, sums(2), other(2), one(2), total(2)
      integer :: i, k, n
      logical :: driven

      n = draw_integer(random, 1, 70)
      allocate (modes%stiffness(n), modes%damping(n), modes%drift(n), modes%force(n), x(n), v(n))
      allocate (x_now(n), v_now(n), sign_of(n))
      driven = draw_integer(random, 0, 1) == 1
      do k = 1, n
         modes%stiffness(k) = merge(0.0_wp, draw_log(random, 1e-2_wp, 1e2_wp), driven)
         modes%damping(k) = draw(random, 0.0_wp, 1.1_wp)*sqrt(modes%stiffness(k))
         modes%force(k) = merge(draw(random, -1.0_wp, 1.0_wp), 0.0_wp, driven)
         modes%drift(k) = merge(draw(random, -1.0_wp, 1.0_wp), 0.0_wp, driven)
         x(k) = draw(random, -1.0_wp, 1.0_wp)
         v(k) = draw(random, -1.0_wp, 1.0_wp)
         sign_of(k) = 2*draw_integer(random, 0, 1) - 1
      end do
      call prepare(modes, driven)
      if (driven) then
         do k = 1, n
            modes%force_rate(k) = draw(random, -1.0_wp, 1.0_wp)
            modes%drift_rate(k) = draw(random, -1.0_wp, 1.0_wp)
         end do
      end if
      duration = draw_log(random, 1e-2_wp, 1e2_wp)
      call sizes(1, n, sums)
      do i = 0, 20
         call advance(modes, i*duration/20, x, v, x_now, v_now)
         call check(all([sum(x_now**2), sum(v_now**2)] <= sums*(1 + 1e-12_wp)), &
            'sizes: bounds on all pairs')
      end do
      total = 0
      do k = 1, n
         call sizes(k, k, one)
         total = total + one
      end do
      call check(all(abs(total - sums) <= 1e-13_wp*sums), 'sizes: the sum of each')
      modes%force = sign_of*modes%force
      modes%force_rate = sign_of(n:1:-1)*modes%force_rate
      modes%drift = sign_of*modes%drift
      modes%drift_rate = sign_of(n:1:-1)*modes%drift_rate
      x = -x
      v = sign_of*v
      call sizes(1, n, other)
      call check(.not. any(abs(other - sums) > 0), 'sizes: of either sign')
   contains
      !> Both sums for some of the pairs.
      subroutine sizes(first, last, of)
         integer, intent(in) :: first, last
         real(wp), intent(out) :: of(2)

         call sizes_of_pairs(last - first + 1, duration, modes%stiffness(first:last), &
            modes%damping(first:last), modes%inverse(first:last), modes%drift(first:last), &
            modes%drift_rate(first:last), modes%force(first:last), modes%force_rate(first:last), &
            x(first:last), v(first:last), of(1), of(2))
      end subroutine sizes
   end subroutine check_sizes

   !> Bounds on the fourth derivatives of pairs under growing forces, compared with derivatives from
   !! the equations; an undamped pair comes near them.
   subroutine check_driven()
      integer, parameter :: n = 7, samples = 200
      type(modes_type) :: modes
      real(wp), dimension(n) :: x, v, x_now, v_now, of_x, of_v, x1, v1, x2, v2, v3
      real(wp) :: most(n, 2), t
      integer :: i, k

      allocate (modes%stiffness(n), modes%damping(n), modes%drift(n), modes%force(n))
      do k = 1, n
         modes%stiffness(k) = draw_log(random, 1e-1_wp, 1e1_wp)
         modes%damping(k) = merge(0.0_wp, draw(random, 0.0_wp, 1.2_wp), mod(k, 2) == 0) &
            *sqrt(modes%stiffness(k))
         modes%force(k) = draw(random, -1.0_wp, 1.0_wp)
         modes%drift(k) = draw(random, -1.0_wp, 1.0_wp)
         x(k) = draw(random, -1.0_wp, 1.0_wp)
         v(k) = draw(random, -1.0_wp, 1.0_wp)
      end do
      call prepare(modes, .true.)
      do k = 1, n
         modes%force_rate(k) = draw(random, -1.0_wp, 1.0_wp)
         modes%drift_rate(k) = draw(random, -1.0_wp, 1.0_wp)
      end do
      call bound_pairs(n, modes%stiffness, modes%damping, modes%inverse, modes%drift, &
         modes%drift_rate, modes%force, modes%force_rate, x, v, of_x, of_v)
      most = 0
      do i = 0, samples
         ! a cycle of the slowest pair
         t = i*2*pi/(samples*sqrt(minval(modes%stiffness)))
         call advance(modes, t, x, v, x_now, v_now)
         x1 = v_now + modes%drift + t*modes%drift_rate
         v1 = -modes%stiffness*x_now - 2*modes%damping*v_now + modes%force + t*modes%force_rate
         x2 = v1 + modes%drift_rate
         v2 = -modes%stiffness*x1 - 2*modes%damping*v1 + modes%force_rate
         v3 = -modes%stiffness*x2 - 2*modes%damping*v2
         most(:, 1) = max(most(:, 1), abs(v3))
         most(:, 2) = max(most(:, 2), abs(modes%stiffness*v2 + 2*modes%damping*v3))
      end do
      call check(all(most(:, 1) <= of_x*(1 + 1e-10_wp) .and. most(:, 2) <= of_v*(1 + 1e-10_wp)), &
         'driven: bounds on fourth derivatives')
      call check(all(1.02_wp*most(2:n:2, 1) >= of_x(2:n:2) .and. 1.02_wp*most(2:n:2, 2) >= &
         of_v(2:n:2)), 'driven: which are reached without damping')
   end subroutine check_driven

   !> A chain of two masses with gaps, under some harmonics; the state of its pairs.
   subroutine draw_chain(harmonics, state, most_damped, regime, x, v, phase, resting)
      integer, intent(in) :: harmonics
      !> Size of the state, and the largest damping.
      real(wp), intent(in) :: state, most_damped
      !> Gaps that rest.
      integer, intent(in) :: resting(:)
      type(regime_type), intent(out) :: regime
      real(wp), allocatable, intent(out) :: x(:), v(:)
      real(wp), intent(out) :: phase
      integer, parameter :: n = 2
      type(structure_type) :: structure
      type(load_type) :: load
      real(wp) :: matrices(n, n, 3), directions(n, 2), opening(2, 2), force(n, 2, harmonics), s(2)
      integer :: i, j, status

      s = [draw_log(random, 0.3_wp, 3.0_wp), draw_log(random, 0.3_wp, 3.0_wp)]
      matrices = 0
      matrices(1, 1, 1) = 1
      matrices(2, 2, 1) = draw_log(random, 0.1_wp, 1.0_wp)
      matrices(:, :, 3) = reshape([s(1) + s(2), -s(2), -s(2), s(2)], [n, n])
      matrices(:, :, 2) = draw_log(random, 1e-6_wp, most_damped)*matrices(:, :, 3)
      directions = reshape([1.0_wp, -1.0_wp, 0.0_wp, 1.0_wp], [n, 2])
      opening(1, :) = 100
      opening(2, :) = 0.5_wp
      structure = new_structure(matrices, directions, opening)
      call check_structure(structure, status)
      do j = 1, harmonics
         do i = 1, n
            force(i, :, j) = [draw(random, -1.0_wp, 1.0_wp), draw(random, -1.0_wp, 1.0_wp)]
         end do
      end do
      load = new_load(draw_log(random, 0.3_wp, 3.0_wp), force, [draw(random, -1.0_wp, 1.0_wp), &
         0.0_wp])
      call new_regime(structure, load, resting, regime, status)
      call check(status == stat%ok, 'rows: a chain')
      allocate (x(size(regime%modes%stiffness)), v(size(regime%modes%stiffness)))
      do i = 1, size(x)
         x(i) = state*draw(random, -1.0_wp, 1.0_wp)
         v(i) = state*draw(random, -1.0_wp, 1.0_wp)
      end do
      phase = draw(random, 0.0_wp, 2*pi)
   end subroutine draw_chain

   !> Bounds on the fourth derivatives, by differences of the third ones, and on the second ones at
   !! any phase.
   subroutine check_rows(kind)
      !> 0 free motion, 1 with one harmonic, 2 with two.
      integer, intent(in) :: kind
      integer, parameter :: samples = 2000
      type(regime_type) :: regime
      real(wp), allocatable :: x(:), v(:), now_x(:), now_v(:), of_x(:), of_v(:), bound(:)
      real(wp) :: phase, d(0:3), before, most, second, h
      integer :: i, row

      call draw_chain(kind, merge(1.0_wp, draw(random, 0.0_wp, 1.0_wp), kind == 0), &
         merge(1e-5_wp, 0.5_wp, kind < 2), regime, x, v, phase, [integer ::])
      ! then only the harmonic is left
      if (kind == 1) then
         x = regime%modes%force/regime%modes%stiffness
         v = 0
      end if
      allocate (now_x, now_v, of_x, of_v, mold=x)
      allocate (bound(size(regime%upper)))
      call bound_fourth(regime, size(x), x, v, of_x, of_v, bound)
      h = 0.01_wp*regime%unit
      if (kind == 1) h = 2*pi/regime%frequency/samples
      do row = 1, size(bound)
         most = 0
         second = 0
         do i = 0, samples
            call advance(regime%modes, i*merge(50*h, h, kind == 0), x, v, now_x, now_v)
            call row_derivatives(regime, now_x, now_v, phase, row, d)
            ! the free motion needs many cycles to come near its bound
            if (kind == 0) then
               before = d(3)
               call advance(regime%modes, (50*i + 1)*h, x, v, now_x, now_v)
               call row_derivatives(regime, now_x, now_v, phase, row, d)
               most = max(most, abs(d(3) - before)/h)
            else
               call row_derivatives(regime, now_x, now_v, phase + i*h*regime%frequency, row, d)
               if (i > 0) most = max(most, abs(d(3) - before)/h)
               before = d(3)
            end if
            call row_derivatives(regime, x, v, i*2*pi/samples, row, d)
            second = max(second, abs(d(2)))
         end do
         call check(most <= bound(row)*(1 + 1e-6_wp), 'rows: bounds on fourth derivatives')
         if (kind < 2) call check(bound(row) <= 1.5_wp*most, 'rows: no larger than needed')
         call check(second <= bound_second(regime, x, v, row)*(1 + 1e-12_wp), &
            'rows: bounds on second derivatives')
         if (kind < 2) call check(bound_second(regime, x, v, row) <= 1.01_wp*second, &
            'rows: reached at some phase')
      end do
   end subroutine check_rows

   !> The size of what a row holds without its pairs, of either sign, while a gap rests.
   subroutine check_constants()
      integer, parameter :: samples = 1000
      type(regime_type) :: regime
      real(wp), allocatable :: x(:), v(:)
      real(wp) :: phase, d(0:3), most
      integer :: i, row

      call draw_chain(1, 0.0_wp, 0.5_wp, regime, x, v, phase, [draw_integer(random, 1, 2)])
      do row = 1, size(regime%rows%constant_size)
         most = 0
         do i = 0, samples
            call row_derivatives(regime, x, v, i*2*pi/samples, row, d)
            most = max(most, abs(d(0)))
         end do
         call check(most <= regime%rows%constant_size(row)*(1 + 1e-12_wp), 'rows: constants')
         call check(regime%rows%constant_size(row) <= 1.01_wp*most, 'rows: size of constants')
      end do
   end subroutine check_constants

   !> A search that is interrupted and resumed repeatedly finds the same event with the same bits,
   !! and leaves the same pace for the next flight; each of its parts is short.
   subroutine test_interrupted()
      integer, parameter :: samples = 3000, patience = 100, most_in_cells = 64*30
      type(regime_type) :: regime
      type(space_type) :: space
      type(pace_type) :: pace, other_pace
      type(reached_type) :: reached, other
      real(wp), allocatable :: x(:), v(:), now_x(:), now_v(:)
      real(wp) :: phase, d(0:3), span, greatest
      integer :: i, parts, row, steps

      call draw_chain(draw_integer(random, 0, 2), 1.0_wp, 1e-4_wp, regime, x, v, phase, &
         [integer ::])
      allocate (now_x, now_v, mold=x)
      row = draw_integer(random, 1, size(regime%upper))
      span = 1000*regime%unit
      greatest = 0
      do i = 0, samples
         call advance(regime%modes, i*span/samples, x, v, now_x, now_v)
         call row_derivatives(regime, now_x, now_v, phase + regime%frequency*i*span/samples, row, &
            d)
         greatest = max(greatest, d(0))
      end do
      regime%upper = 1e3_wp*greatest
      regime%lower = -1e3_wp*greatest
      ! reached late or not at all
      regime%upper(row) = draw(random, 0.99_wp, 1.01_wp)*greatest
      call row_derivatives(regime, x, v, phase, row, d)
      if (d(0) >= regime%upper(row)) return
      pace%level = draw_integer(random, 1, 8)
      other_pace = pace
      call first_event(regime, x, v, phase, leaving_type(), span, pace, reached, space)
      parts = 0
      steps = 0
      do
         call first_event(regime, x, v, phase, leaving_type(), span, other_pace, other, space, &
            patience)
         parts = parts + 1
         steps = steps + other%steps
         if (.not. other%interrupted) exit
         call check(other%row == 0 .and. other%steps >= patience, 'interrupted: not too early')
         call check(other%steps <= patience + most_in_cells, 'interrupted: nor too late')
         call check(other_pace%from > 0 .and. (reached%row == 0 .or. other_pace%from <= &
            reached%time), 'interrupted: before the event')
         if (parts > reached%steps) exit
      end do
      call check(parts > 1 .or. reached%steps < patience + most_in_cells, &
         'interrupted: in several parts')
      call check(steps == reached%steps, 'interrupted: the same steps')
      call check(other%row == reached%row .and. other%wall == reached%wall, &
         'interrupted: the same event')
      call check(all(transfer([other%time, other%speed], [0]) == &
         transfer([reached%time, reached%speed], [0])), 'interrupted: the same bits')
      call check(other_pace%level == pace%level .and. other_pace%hold == pace%hold .and. &
         .not. other_pace%from > 0, 'interrupted: the same pace')
   end subroutine test_interrupted

   !> A search without wide registers finds the same event with the same bits, with and without rows
   !! that depend on velocities.
   subroutine test_plain_registers()
      type(regime_type) :: regime
      type(space_type) :: space
      type(pace_type) :: pace, other_pace
      type(reached_type) :: reached, other
      real(wp), allocatable :: x(:), v(:), q(:, :), rate(:, :)
      real(wp) :: phase
      integer :: i

      call draw_chain(draw_integer(random, 0, 2), 1.0_wp, 0.5_wp, regime, x, v, phase, &
         [(i, i=1, draw_integer(random, 0, 1))])
      regime%upper = min(regime%upper, draw_log(random, 1.0_wp, 10.0_wp))
      allocate (q(2, 2), rate(2, 2))
      call first_event(regime, x, v, phase, leaving_type(), 50*regime%unit, pace, reached, space)
      call state_of(regime, phase, x, v, q(:, 1), rate(:, 1))
      regime%modes%wide = .false.
      regime%rows%wide = .false.
      regime%coordinates%wide = .false.
      call first_event(regime, x, v, phase, leaving_type(), 50*regime%unit, other_pace, other, &
         space)
      call state_of(regime, phase, x, v, q(:, 2), rate(:, 2))
      call check(reached%row == other%row .and. reached%wall == other%wall .and. reached%steps == &
         other%steps .and. pace%level == other_pace%level, 'plain registers: the same search')
      call check(all(transfer([reached%time, reached%speed], [0]) == transfer([other%time, &
         other%speed], [0])), 'plain registers: the same bits of an event')
      call check(all(transfer([q(:, 1), rate(:, 1)], [0]) == transfer([q(:, 2), rate(:, 2)], &
         [0])), 'plain registers: the same bits of a state')
   end subroutine test_plain_registers

   !> A resumed search ends within its budget of steps, without an event.
   subroutine test_budget()
      type(regime_type) :: regime
      type(space_type) :: space
      type(pace_type) :: pace
      type(reached_type) :: reached
      real(wp), allocatable :: x(:), v(:)
      real(wp) :: phase
      integer :: left

      call draw_chain(1, 1.0_wp, 0.5_wp, regime, x, v, phase, [integer ::])
      regime%upper = 1e30_wp
      regime%lower = -1e30_wp
      do left = 1, 3
         pace = pace_type(cells=step_budget - left)
         ! within the first cell, far from all walls
         call first_event(regime, x, v, phase, leaving_type(), 0.5_wp*regime%steps%length(8), &
            pace, reached, space)
         call check(reached%complete .eqv. left > 1, 'budget: a step is left, or none')
         call check(reached%row == 0 .and. .not. reached%interrupted, 'budget: no event')
      end do
   end subroutine test_budget

   !> A row whose limit is a little above, or below, its greatest value: the search from a state
   !! within the limits finds no event, or the first time at which the limit is reached.
   subroutine check_search()
      integer, parameter :: samples = 1500
      type(regime_type) :: regime
      type(space_type) :: space
      type(pace_type) :: pace
      type(reached_type) :: reached
      real(wp), allocatable :: x(:), v(:), now_x(:), now_v(:)
      real(wp) :: phase, d(0:3), span, most, greatest, beyond, h, t, at
      integer :: i, k, row
      logical :: rising, top

      call draw_chain(draw_integer(random, 1, 2), 1.0_wp, 0.5_wp, regime, x, v, phase, [integer ::])
      allocate (now_x, now_v, mold=x)
      row = draw_integer(random, 1, size(regime%upper))
      span = 30*regime%unit
      h = span/samples
      most = 0
      greatest = -huge(1.0_wp)
      at = 0
      rising = .false.
      do i = 0, samples
         call value_at(i*h)
         most = max(most, abs(d(0)))
         call note(i*h)
         top = rising .and. d(1) <= 0
         rising = d(1) > 0
         if (.not. top) cycle
         ! a maximum lies between samples, and is found by Newton's method
         t = i*h
         do k = 1, 5
            t = min(max(t - d(1)/d(2), (i - 1)*h), i*h)
            call value_at(t)
         end do
         call note(t)
      end do
      if (at <= h .or. at > span - h) return
      beyond = draw_log(random, 1e-9_wp, 1e-2_wp)*most
      regime%upper = 1e3_wp*most
      regime%lower = -1e3_wp*most
      pace%level = draw_integer(random, 1, 8)
      regime%upper(row) = greatest + beyond
      call first_event(regime, x, v, phase, leaving_type(), span, pace, reached, space)
      call check(reached%row == 0, 'search: no event where the limit is not reached')
      regime%upper(row) = greatest - beyond
      call value_at(0.0_wp)
      if (d(0) >= regime%upper(row)) return
      call first_event(regime, x, v, phase, leaving_type(), span, pace, reached, space)
      call check(reached%row == row .and. reached%wall == 1, 'search: an event, however brief')
      if (reached%row /= row) return
      call value_at(reached%time)
      call check_close(d(0), regime%upper(row), 1e-12_wp*most*(1 + 1/regime%unit), &
         'search: at the limit')
      call check_close(reached%speed, d(1), 1e-9_wp*most/regime%unit, 'search: approach speed')
      do i = 0, int(reached%time/h)
         call value_at(i*h)
         call check(d(0) <= regime%upper(row) + 1e-12_wp*most, 'search: the first one')
      end do
   contains
      !> Keeps the greatest value, and its position.
      subroutine note(time)
         real(wp), intent(in) :: time

         if (d(0) <= greatest) return
         greatest = d(0)
         at = time
      end subroutine note

      !> The row and its derivatives at a time.
      subroutine value_at(time)
         real(wp), intent(in) :: time

         call advance(regime%modes, time, x, v, now_x, now_v)
         call row_derivatives(regime, now_x, now_v, phase + regime%frequency*time, row, d)
      end subroutine value_at
   end subroutine check_search

end module mechanics_channels
