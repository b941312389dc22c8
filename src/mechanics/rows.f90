!> Rows of numbers that are sums over the pairs of a structure (vi_modes): its channels, or its
!! coordinates.
!!
!! y_i = offset_i + sum over k of position_ik x_k + velocity_ik v_k + the harmonics of the load.
!! Pairs that occur in most rows of a range form dense blocks; the others are listed one by one.
module vi_rows
   use vi_kinds, only: wp
   use vi_lane_groups, only: add_rows, add_stacked, bound_row, group
   use vi_lane_groups_wide, only: add_rows_wide => add_rows, add_stacked_wide => add_stacked, &
      bound_row_wide => bound_row
   use vi_lane_rows, only: add_product, add_products, side_by_side
   use vi_lane_rows_wide, only: add_product_wide => add_product, add_products_wide => add_products
   use vi_modes, only: modes_type
   use vi_processor, only: runs_wide
   implicit none (type, external)
   private

   public :: add_harmonic, add_ripple, bound_of_row, bound_values, free_sums, free_value, &
      free_values, new_rows, renew_rows, rough_values, row_values, values_of_row

   !> Pairs (first_pair to last_pair) that occur in most rows from first_row to last_row.
   type, public :: block_type
      integer :: first_row = 1, last_row = 0, first_pair = 1, last_pair = 0
      !> (rows, pairs) Coefficients of x and v in the rows, and in their rates.
      real(wp), allocatable, dimension(:, :) :: position, velocity, rate_position, rate_velocity
      !> Absolute values of the first two.
      real(wp), allocatable, dimension(:, :) :: position_size, velocity_size
      !> (pairs, rows) The coefficients of x by rows, where no row depends on v.
      real(wp), allocatable :: by_row(:, :)
   end type block_type

   !> The rows.
   type, public :: rows_type
      !> Number of pairs.
      integer :: pairs = 0
      !> Whether the processor runs the procedures for wide registers, which give the same bits.
      logical :: wide = .false.
      type(block_type), allocatable :: blocks(:)
      !> Row and pair of each coefficient that is in no block, and the coefficients.
      integer, allocatable, dimension(:) :: row, pair
      real(wp), allocatable, dimension(:) :: position, velocity, rate_position, rate_velocity
      !> Whether single rows are evaluated where certificates do not cover them (vi_watch); where no
      !! row depends on v, the coefficients that are in no block by rows: listed(listed_begins(i):
      !! listed_begins(i + 1) - 1) of row i.
      logical :: alone = .false.
      !> Number of pairs up to the last one in a block.
      integer :: dense = 0
      !> The largest norm of positions and size of constants.
      real(wp) :: most_norm = 0, most_constant = 0
      !> (rows) As position_norm, of the pairs that are no free masses; the largest of them.
      real(wp), allocatable :: bent_norm(:)
      real(wp) :: most_bent_norm = 0
      !> (harmonics) The largest ripples.
      real(wp), allocatable :: most_ripple(:)
      integer, allocatable, dimension(:) :: listed, listed_begins
      !> (rows) Constants of each row and of its rate.
      real(wp), allocatable, dimension(:) :: offset, rate_offset
      !> (rows) The rates at which these constants grow, and whether any does.
      real(wp), allocatable, dimension(:) :: offset_rate, rate_offset_rate
      logical :: grows = .false.
      !> (rows, harmonics)
      complex(wp), allocatable :: ripple(:, :)
      !> (rows, harmonics) Absolute values of the latter; (rows) their sum with that of the offset.
      real(wp), allocatable :: ripple_size(:, :), constant_size(:)
      !> Whether no row depends on v.
      logical :: by_position = .true.
      !> (rows) Root of the sum of squares of position and of velocity.
      real(wp), allocatable, dimension(:) :: position_norm, velocity_norm
      !> The pairs of each row: those of row i are touched(begins(i):begins(i + 1) - 1), filled up
      !! to a multiple of `side_by_side` by pairs with coefficients 0.
      integer, allocatable, dimension(:) :: touched, begins
      !> (rows) How many of the first pairs of each row have numbers that follow each other.
      integer, allocatable :: runs(:)
      !> (as touched) omega^2, 2 sigma, and the coefficients of x and of v.
      real(wp), allocatable, dimension(:) :: stiffness, drag, of_x, of_v
      !> Whether all of drag and of of_v are 0.
      logical :: bare = .false.
      !> (rows) No derivative grows faster than by this factor an order; the largest of them.
      real(wp), allocatable :: fastest(:)
      real(wp) :: most_fastest = 0
   end type rows_type

   !> Rows from which on they are evaluated alone: with less there is little to leave out.
   integer, parameter :: many = 16

contains

   !> Rows from their coefficients.
   pure subroutine new_rows(modes, position, velocity, offset, ripple, frequency, rows, of_x, of_v)
      !> The pairs.
      type(modes_type), intent(in) :: modes
      !> (rows, pairs) Coefficients of x and of v.
      real(wp), intent(in) :: position(:, :), velocity(:, :)
      !> (rows)
      real(wp), intent(in) :: offset(:)
      !> (rows, harmonics) Complex amplitudes of the harmonics of the load, and Omega.
      complex(wp), intent(in) :: ripple(:, :)
      real(wp), intent(in) :: frequency
      !> The rows.
      type(rows_type), intent(out) :: rows
      !> (rows, pairs) Coefficients of x and of v in the rates, if they are known otherwise; the
      !! rates then have no constants.
      real(wp), intent(in), optional :: of_x(:, :), of_v(:, :)
      logical :: occurs(size(position, 1), size(position, 2)), dense(size(position, 2)), &
         ends(size(position, 2))
      real(wp), allocatable, dimension(:, :) :: rate_position, rate_velocity
      integer :: first(size(position, 2)), last(size(position, 2))
      integer :: i, j, k, m, n

      n = size(position, 1)
      m = size(position, 2)
      rows%pairs = m
      allocate (rows%rate_offset(n), rows%offset_rate(n), rows%rate_offset_rate(n), source=0.0_wp)
      allocate (rate_position(n, m), rate_velocity(n, m))
      do k = 1, m
         rate_position(:, k) = -modes%stiffness(k)*velocity(:, k)
         rate_velocity(:, k) = position(:, k) - 2*modes%damping(k)*velocity(:, k)
      end do
      call set_constants(modes, position, velocity, offset, ripple, present(of_x), rows)
      if (present(of_x) .and. present(of_v)) then
         rate_position = of_x
         rate_velocity = of_v
      end if
      rows%wide = runs_wide() /= 0
      rows%by_position = .not. any(abs(velocity) > 0)
      rows%position_norm = sqrt(sum(position**2, 2))
      rows%velocity_norm = sqrt(sum(velocity**2, 2))
      occurs = abs(position) + abs(velocity) > 0
      first = findloc(occurs, .true., 1)
      last = findloc(occurs, .true., 1, back=.true.)
      dense = count(occurs, 1) > 2 .and. 2*count(occurs, 1) > last - first
      ! a block ends where the next pair has another range of rows
      ends = dense
      do k = 1, m - 1
         ends(k) = dense(k) .and. .not. (dense(k + 1) .and. first(k + 1) == first(k) &
            .and. last(k + 1) == last(k))
      end do
      allocate (rows%blocks(count(ends)))
      j = 0
      i = 1
      do k = 1, m
         if (.not. dense(k)) i = k + 1
         if (.not. ends(k)) cycle
         j = j + 1
         associate (block => rows%blocks(j), from => first(k), to => last(k))
            block%first_row = from
            block%last_row = to
            block%first_pair = i
            block%last_pair = k
            block%position = position(from:to, i:k)
            block%velocity = velocity(from:to, i:k)
            block%rate_position = rate_position(from:to, i:k)
            block%rate_velocity = rate_velocity(from:to, i:k)
            block%position_size = abs(block%position)
            block%velocity_size = abs(block%velocity)
         end associate
         i = k + 1
      end do
      if (j > 0) rows%dense = rows%blocks(j)%last_pair
      rows%row = pack(spread([(i, i=1, n)], 2, m), occurs .and. .not. spread(dense, 1, n))
      rows%pair = pack(spread([(k, k=1, m)], 1, n), occurs .and. .not. spread(dense, 1, n))
      allocate (rows%position(size(rows%row)), rows%velocity(size(rows%row)), &
         rows%rate_position(size(rows%row)), rows%rate_velocity(size(rows%row)))
      do i = 1, size(rows%row)
         rows%position(i) = position(rows%row(i), rows%pair(i))
         rows%velocity(i) = velocity(rows%row(i), rows%pair(i))
         rows%rate_position(i) = rate_position(rows%row(i), rows%pair(i))
         rows%rate_velocity(i) = rate_velocity(rows%row(i), rows%pair(i))
      end do
      if (rows%by_position) then
         do j = 1, size(rows%blocks)
            rows%blocks(j)%by_row = transpose(rows%blocks(j)%position)
         end do
         rows%listed_begins = [1, (1 + count(rows%row <= i), i=1, n)]
         rows%listed = [(pack([(k, k=1, size(rows%row))], rows%row == i), i=1, n)]
      end if
      rows%alone = rows%by_position .and. n >= many .and. .not. present(of_x)
      if (rows%alone) call set_largest(modes, position, rows)
      call set_touched(modes, position, velocity, occurs, rows)
      call set_fastest(frequency, rows)
   end subroutine new_rows

   !> The same rows with other constants and harmonics: the digits are those of `new_rows`.
   pure subroutine renew_rows(modes, position, velocity, offset, ripple, frequency, rates_known, &
      rows)
      !> As in `new_rows`; omega^2 and sigma of the pairs, and the coefficients, are the same.
      type(modes_type), intent(in) :: modes
      real(wp), intent(in) :: position(:, :), velocity(:, :), offset(:)
      !> (rows, harmonics) As many as before, and Omega.
      complex(wp), intent(in) :: ripple(:, :)
      real(wp), intent(in) :: frequency
      !> Whether the coefficients of the rates were given.
      logical, intent(in) :: rates_known
      !> In and out: the rows.
      type(rows_type), intent(inout) :: rows

      call set_constants(modes, position, velocity, offset, ripple, rates_known, rows)
      if (rows%alone) call set_largest(modes, position, rows)
      call set_fastest(frequency, rows)
   end subroutine renew_rows

   !> The largest numbers of all rows, which certificates need.
   pure subroutine set_largest(modes, position, rows)
      !> As in `new_rows`.
      type(modes_type), intent(in) :: modes
      real(wp), intent(in) :: position(:, :)
      !> In and out: filled in.
      type(rows_type), intent(inout) :: rows

      rows%bent_norm = sqrt(sum(position(:, :modes%bent)**2, 2))
      rows%most_bent_norm = maxval(rows%bent_norm)
      rows%most_norm = maxval(rows%position_norm)
      rows%most_constant = maxval(rows%constant_size)
      rows%most_ripple = maxval(rows%ripple_size, 1)
   end subroutine set_largest

   !> The constants of the rows and their rates, and the harmonics.
   pure subroutine set_constants(modes, position, velocity, offset, ripple, rates_known, rows)
      !> As in `renew_rows`.
      type(modes_type), intent(in) :: modes
      real(wp), intent(in) :: position(:, :), velocity(:, :), offset(:)
      complex(wp), intent(in) :: ripple(:, :)
      logical, intent(in) :: rates_known
      !> In and out: filled in.
      type(rows_type), intent(inout) :: rows
      integer :: k

      rows%offset = offset
      rows%ripple = ripple
      rows%ripple_size = abs(ripple)
      rows%constant_size = abs(offset) + sum(rows%ripple_size, 2)
      rows%rate_offset = 0
      if (rates_known) return
      do k = 1, size(position, 2)
         rows%rate_offset = rows%rate_offset + position(:, k)*modes%drift(k) &
            + velocity(:, k)*modes%force(k)
      end do
   end subroutine set_constants

   !> The pairs of each row.
   pure subroutine set_touched(modes, position, velocity, occurs, rows)
      !> The pairs.
      type(modes_type), intent(in) :: modes
      !> (rows, pairs) Coefficients of x and of v.
      real(wp), intent(in) :: position(:, :), velocity(:, :)
      !> (rows, pairs) Whether a pair occurs in a row.
      logical, intent(in) :: occurs(:, :)
      !> In and out: filled in.
      type(rows_type), intent(inout) :: rows
      integer :: i, j, k, n

      n = sum([(filled(count(occurs(j, :))), j=1, size(occurs, 1))])
      allocate (rows%begins(size(occurs, 1) + 1), rows%fastest(size(occurs, 1)))
      allocate (rows%runs(size(occurs, 1)), source=0)
      allocate (rows%touched(n), source=1)
      allocate (rows%stiffness(n), rows%drag(n), rows%of_x(n), rows%of_v(n), source=0.0_wp)
      i = 1
      do j = 1, size(occurs, 1)
         rows%begins(j) = i
         do k = 1, size(occurs, 2)
            if (.not. occurs(j, k)) cycle
            rows%touched(i) = k
            rows%stiffness(i) = modes%stiffness(k)
            rows%drag(i) = 2*modes%damping(k)
            rows%of_x(i) = position(j, k)
            rows%of_v(i) = velocity(j, k)
            associate (run => rows%runs(j), begin => rows%begins(j))
               if (run == i - begin .and. k == rows%touched(begin) + run) run = run + 1
            end associate
            i = i + 1
         end do
         i = rows%begins(j) + filled(i - rows%begins(j))
      end do
      rows%begins(size(occurs, 1) + 1) = i
      rows%bare = .not. any(abs(rows%drag) + abs(rows%of_v) > 0)
   end subroutine set_touched

   !> The factors of the growth of derivatives.
   pure subroutine set_fastest(frequency, rows)
      !> Omega of the load.
      real(wp), intent(in) :: frequency
      !> In and out: the rows, with the pairs of each.
      type(rows_type), intent(inout) :: rows
      integer :: i, j

      do j = 1, size(rows%fastest)
         rows%fastest(j) = 0
         if (size(rows%ripple, 2) > 0) rows%fastest(j) = size(rows%ripple, 2)*frequency
         do i = rows%begins(j), rows%begins(j + 1) - 1
            rows%fastest(j) = max(rows%fastest(j), sqrt(rows%stiffness(i)) + rows%drag(i))
         end do
      end do
      rows%most_fastest = maxval(rows%fastest)
   end subroutine set_fastest

   !> A number of pairs, filled up.
   elemental integer function filled(n)
      !> The number.
      integer, intent(in) :: n

      filled = side_by_side*((n + side_by_side - 1)/side_by_side)
   end function filled

   !> The rows and their rates.
   pure subroutine row_values(rows, frequency, x, v, turn, y, rate, time)
      !> The rows.
      type(rows_type), intent(in) :: rows
      !> Omega of the load.
      real(wp), intent(in) :: frequency
      !> The pairs.
      real(wp), intent(in) :: x(rows%pairs), v(rows%pairs)
      !> (harmonics) e^(i h Omega t).
      complex(wp), intent(in) :: turn(size(rows%ripple, 2))
      !> (rows) Values and rates.
      real(wp), intent(out) :: y(size(rows%offset)), rate(size(rows%offset))
      !> Time since the constants had their values.
      real(wp), intent(in), optional :: time
      integer :: h

      call free_values(rows, x, v, y, rate, time)
      do h = 1, size(turn)
         call add_harmonic(size(y), rows%ripple(:, h), h*frequency, turn(h), y, rate)
      end do
   end subroutine row_values

   !> The rows and their rates without the harmonics of the load.
   pure subroutine free_values(rows, x, v, y, rate, time)
      !> The rows.
      type(rows_type), intent(in) :: rows
      !> The pairs.
      real(wp), intent(in) :: x(rows%pairs), v(rows%pairs)
      !> (rows) Values and rates.
      real(wp), intent(out) :: y(size(rows%offset)), rate(size(rows%offset))
      !> Time since the constants had their values.
      real(wp), intent(in), optional :: time
      real(wp) :: growth
      integer :: j, n, m

      growth = 0
      if (present(time)) growth = time
      call start_rows(size(y), growth, rows%offset, rows%offset_rate, rows%rate_offset, &
         rows%rate_offset_rate, y, rate)
      do j = 1, size(rows%blocks)
         associate (b => rows%blocks(j))
            n = b%last_row - b%first_row + 1
            m = b%last_pair - b%first_pair + 1
            if (rows%by_position .and. rows%wide) then
               call add_products_wide(n, m, b%position, x(b%first_pair:b%last_pair), &
                  v(b%first_pair:b%last_pair), y(b%first_row:b%last_row), &
                  rate(b%first_row:b%last_row))
            else if (rows%by_position) then
               call add_products(n, m, b%position, x(b%first_pair:b%last_pair), &
                  v(b%first_pair:b%last_pair), y(b%first_row:b%last_row), &
                  rate(b%first_row:b%last_row))
            else
               call add_one(rows%wide, n, m, b%position, x(b%first_pair:b%last_pair), &
                  y(b%first_row:b%last_row))
               call add_one(rows%wide, n, m, b%velocity, v(b%first_pair:b%last_pair), &
                  y(b%first_row:b%last_row))
               call add_one(rows%wide, n, m, b%rate_position, x(b%first_pair:b%last_pair), &
                  rate(b%first_row:b%last_row))
               call add_one(rows%wide, n, m, b%rate_velocity, v(b%first_pair:b%last_pair), &
                  rate(b%first_row:b%last_row))
            end if
         end associate
      end do
      if (rows%by_position) then
         call add_listed(size(rows%row), size(x), size(y), rows%row, rows%pair, rows%position, x, &
            v, y, rate)
      else
         call add_both(size(rows%row), size(x), size(y), rows%row, rows%pair, rows%position, &
            rows%velocity, rows%rate_position, rows%rate_velocity, x, v, y, rate)
      end if
   end subroutine free_values

   !> As `free_values`, of one row, with the same bits, where no row depends on v.
   pure subroutine free_value(rows, i, x, v, y, rate)
      !> The rows, and the number of the row.
      type(rows_type), intent(in) :: rows
      integer, intent(in) :: i
      !> The pairs.
      real(wp), intent(in) :: x(rows%pairs), v(rows%pairs)
      !> Value and rate.
      real(wp), intent(out) :: y, rate
      integer :: at, j, k, l, m

      y = rows%offset(i)
      rate = rows%rate_offset(i)
      do j = 1, size(rows%blocks)
         associate (b => rows%blocks(j))
            if (i < b%first_row .or. i > b%last_row) cycle
            at = i - b%first_row + 1
            m = b%last_pair - b%first_pair + 1
            l = b%first_pair - 1
            call add_row(m, b%by_row(:, at), x(l + 1), v(l + 1), y, rate)
         end associate
      end do
      do j = rows%listed_begins(i), rows%listed_begins(i + 1) - 1
         k = rows%listed(j)
         y = y + rows%position(k)*x(rows%pair(k))
         rate = rate + rows%position(k)*v(rows%pair(k))
      end do
   end subroutine free_value

   !> Adds the products of a row, with the sums of four of `add_products`.
   pure subroutine add_row(m, a, x, v, y, rate)
      !> Number of pairs; the row, and the pairs.
      integer, intent(in) :: m
      real(wp), intent(in) :: a(m), x(m), v(m)
      !> In and out: value and rate.
      real(wp), intent(inout) :: y, rate
      integer :: k

      do k = 1, m - 3, 4
         y = y + ((a(k)*x(k) + a(k + 1)*x(k + 1)) + (a(k + 2)*x(k + 2) + a(k + 3)*x(k + 3)))
         rate = rate + ((a(k)*v(k) + a(k + 1)*v(k + 1)) + (a(k + 2)*v(k + 2) + a(k + 3)*v(k + 3)))
      end do
      do k = m - mod(m, 4) + 1, m
         y = y + a(k)*x(k)
         rate = rate + a(k)*v(k)
      end do
   end subroutine add_row

   !> As `row_values`, of one row at two times, with the same bits, where no row depends on v. The
   !! constants must not grow.
   pure subroutine values_of_row(rows, frequency, i, stacked, x, v, x_next, v_next, turn, &
      turn_next, sums)
      !> The rows.
      type(rows_type), intent(in) :: rows
      !> Omega of the load.
      real(wp), intent(in) :: frequency
      !> The number of the row.
      integer, intent(in) :: i
      !> (group, m) The pairs of blocks at the two times, side by side; all pairs then.
      real(wp), intent(in) :: stacked(group, rows%pairs)
      real(wp), dimension(rows%pairs), intent(in) :: x, v, x_next, v_next
      !> (harmonics) e^(i h Omega t) at these.
      complex(wp), dimension(size(rows%ripple, 2)), intent(in) :: turn, turn_next
      !> Value and rate at the first time, and at the second one.
      real(wp), intent(out) :: sums(group)
      complex(wp) :: here, there
      integer :: at, h, j, k, m

      sums = [rows%offset(i), rows%rate_offset(i), rows%offset(i), rows%rate_offset(i)]
      do j = 1, size(rows%blocks)
         associate (b => rows%blocks(j))
            if (i < b%first_row .or. i > b%last_row) cycle
            at = i - b%first_row + 1
            m = size(b%by_row, 1)
            if (rows%wide) then
               call add_stacked_wide(m, b%by_row(:, at), stacked(1, b%first_pair), sums)
            else
               call add_stacked(m, b%by_row(:, at), stacked(1, b%first_pair), sums)
            end if
         end associate
      end do
      do j = rows%listed_begins(i), rows%listed_begins(i + 1) - 1
         k = rows%listed(j)
         m = rows%pair(k)
         sums = sums + rows%position(k)*[x(m), v(m), x_next(m), v_next(m)]
      end do
      do h = 1, size(turn)
         here = rows%ripple(i, h)*turn(h)
         there = rows%ripple(i, h)*turn_next(h)
         sums(1) = sums(1) + here%re
         sums(2) = sums(2) - (h*frequency)*here%im
         sums(3) = sums(3) + there%re
         sums(4) = sums(4) - (h*frequency)*there%im
      end do
   end subroutine values_of_row

   !> Values and first two derivatives of some rows, in an order of sums of their own: only for
   !! bounds. The constants must not grow.
   pure subroutine rough_values(rows, frequency, n, list, x, v, w, turn, y, rate, second)
      !> The rows.
      type(rows_type), intent(in) :: rows
      !> Omega of the load.
      real(wp), intent(in) :: frequency
      !> Number of rows that are wanted, and which.
      integer, intent(in) :: n, list(n)
      !> The pairs, and the rates of v.
      real(wp), dimension(rows%pairs), intent(in) :: x, v, w
      !> (harmonics) e^(i h Omega t).
      complex(wp), intent(in) :: turn(size(rows%ripple, 2))
      !> (n) Values and derivatives.
      real(wp), dimension(n), intent(out) :: y, rate, second
      complex(wp) :: here
      integer :: h, j

      call start_listed(n, list, size(rows%offset), size(rows%row), rows%pairs, rows%offset, &
         rows%rate_offset, rows%listed_begins, rows%listed, rows%pair, rows%position, x, v, w, y, &
         rate, second)
      do j = 1, size(rows%blocks)
         associate (b => rows%blocks(j), k => rows%blocks(j)%first_pair)
            if (rows%wide) then
               call add_rows_wide(n, list, b%first_row - 1, size(b%by_row, 2), &
                  size(b%by_row, 1), b%by_row, x(k), v(k), w(k), y, rate, second)
            else
               call add_rows(n, list, b%first_row - 1, size(b%by_row, 2), size(b%by_row, 1), &
                  b%by_row, x(k), v(k), w(k), y, rate, second)
            end if
         end associate
      end do
      do h = 1, size(turn)
         do j = 1, n
            here = rows%ripple(list(j), h)*turn(h)
            y(j) = y(j) + here%re
            rate(j) = rate(j) - (h*frequency)*here%im
            second(j) = second(j) - (h*frequency)**2*here%re
         end do
      end do
   end subroutine rough_values

   !> The constants of some rows, and their coefficients that are in no block.
   pure subroutine start_listed(n, list, rows, coefficients, pairs, offset, rate_offset, begins, &
      listed, pair, position, x, v, w, y, rate, second)
      !> Number of rows that are wanted, and which.
      integer, intent(in) :: n, list(n)
      !> Numbers of rows, of coefficients and of pairs.
      integer, intent(in) :: rows, coefficients, pairs
      !> The constants.
      real(wp), dimension(rows), intent(in) :: offset, rate_offset
      !> The coefficients by rows, as `listed_begins` and `listed`; their pairs, and their values.
      integer, intent(in) :: begins(rows + 1), listed(coefficients), pair(coefficients)
      real(wp), intent(in) :: position(coefficients)
      !> As in `rough_values`.
      real(wp), dimension(pairs), intent(in) :: x, v, w
      real(wp), dimension(n), intent(out) :: y, rate, second
      integer :: i, j, k

      do j = 1, n
         y(j) = offset(list(j))
         rate(j) = rate_offset(list(j))
         second(j) = 0
         do i = begins(list(j)), begins(list(j) + 1) - 1
            associate (a => position(listed(i)))
               k = pair(listed(i))
               y(j) = y(j) + a*x(k)
               rate(j) = rate(j) + a*v(k)
               second(j) = second(j) + a*w(k)
            end associate
         end do
      end do
   end subroutine start_listed

   !> As `bound_values`, of one row, with the same bits, where no row depends on v.
   pure real(wp) function bound_of_row(rows, i, of_x) result(bound)
      !> The rows, and the number of the row.
      type(rows_type), intent(in) :: rows
      integer, intent(in) :: i
      !> (m) Bounds on |x|.
      real(wp), intent(in) :: of_x(rows%pairs)
      integer :: at, j, k, m

      bound = 0
      do j = 1, size(rows%blocks)
         associate (b => rows%blocks(j))
            if (i < b%first_row .or. i > b%last_row) cycle
            at = i - b%first_row + 1
            m = size(b%by_row, 1)
            if (rows%wide) then
               call bound_row_wide(m, b%by_row(:, at), of_x(b%first_pair), bound)
            else
               call bound_row(m, b%by_row(:, at), of_x(b%first_pair), bound)
            end if
         end associate
      end do
      do j = rows%listed_begins(i), rows%listed_begins(i + 1) - 1
         k = rows%listed(j)
         bound = bound + abs(rows%position(k))*of_x(rows%pair(k))
      end do
   end function bound_of_row

   !> Adds the fourth derivatives of the harmonics of the load to the bounds of a range of rows.
   pure subroutine add_ripple(rows, frequency, before, here, bound)
      !> The rows.
      type(rows_type), intent(in) :: rows
      !> Omega of the load.
      real(wp), intent(in) :: frequency
      !> Number of rows before the range, and of rows in it.
      integer, intent(in) :: before, here
      !> In and out: the bounds.
      real(wp), intent(inout) :: bound(here)
      integer :: h

      do h = 1, size(rows%ripple, 2)
         bound = bound + rows%ripple_size(before + 1:before + here, h)*(h*frequency)**4
      end do
   end subroutine add_ripple

   !> The sums of the terms of x of all rows, where no row depends on v.
   pure subroutine free_sums(rows, x, y)
      !> The rows.
      type(rows_type), intent(in) :: rows
      !> The pairs.
      real(wp), contiguous, intent(in) :: x(:)
      !> (rows)
      real(wp), contiguous, intent(out) :: y(:)
      integer :: j

      y = 0
      do j = 1, size(rows%blocks)
         associate (b => rows%blocks(j))
            call add_one(rows%wide, b%last_row - b%first_row + 1, b%last_pair - b%first_pair + 1, &
               b%position, x(b%first_pair:b%last_pair), y(b%first_row:b%last_row))
         end associate
      end do
      do j = 1, size(rows%row)
         y(rows%row(j)) = y(rows%row(j)) + rows%position(j)*x(rows%pair(j))
      end do
   end subroutine free_sums

   !> y = y + a x.
   pure subroutine add_one(wide, n, m, a, x, y)
      !> Whether the processor has wide registers.
      logical, intent(in) :: wide
      !> Rows and columns.
      integer, intent(in) :: n, m
      !> The matrix, and x (m).
      real(wp), intent(in) :: a(n, m), x(m)
      !> (n)
      real(wp), intent(inout) :: y(n)

      if (wide) then
         call add_product_wide(n, m, a, x, y)
      else
         call add_product(n, m, a, x, y)
      end if
   end subroutine add_one

   !> The constants of the rows and of their rates.
   pure subroutine start_rows(n, time, offset, offset_rate, rate_offset, rate_offset_rate, y, rate)
      !> Number of rows.
      integer, intent(in) :: n
      !> Time since the constants had their values.
      real(wp), intent(in) :: time
      !> The constants, and the rates at which they grow.
      real(wp), dimension(n), intent(in) :: offset, offset_rate, rate_offset, rate_offset_rate
      !> Values and rates.
      real(wp), intent(out) :: y(n), rate(n)
      integer :: i

      do i = 1, n
         y(i) = offset(i) + time*offset_rate(i)
         rate(i) = rate_offset(i) + time*rate_offset_rate(i)
      end do
   end subroutine start_rows

   !> Adds the coefficients that are in no block, where no row depends on v.
   pure subroutine add_listed(n, m, rows, row, pair, position, x, v, y, rate)
      !> Numbers of coefficients, of pairs and of rows.
      integer, intent(in) :: n, m, rows
      !> Row and pair of each coefficient, and the coefficients.
      integer, intent(in) :: row(n), pair(n)
      !> As in `row`.
      real(wp), intent(in) :: position(n)
      !> The pairs.
      real(wp), intent(in) :: x(m), v(m)
      !> In and out: values and rates.
      real(wp), intent(inout) :: y(rows), rate(rows)
      integer :: i

      do i = 1, n
         y(row(i)) = y(row(i)) + position(i)*x(pair(i))
         rate(row(i)) = rate(row(i)) + position(i)*v(pair(i))
      end do
   end subroutine add_listed

   !> Adds the coefficients that are in no block, where rows depend on v.
   pure subroutine add_both(n, m, rows, row, pair, position, velocity, rate_position, &
      rate_velocity, x, v, y, rate)
      !> As in `add_listed`.
      integer, intent(in) :: n, m, rows, row(n), pair(n)
      !> The coefficients of x and of v.
      real(wp), dimension(n), intent(in) :: position, velocity, rate_position, rate_velocity
      !> The pairs.
      real(wp), intent(in) :: x(m), v(m)
      !> In and out: values and rates.
      real(wp), intent(inout) :: y(rows), rate(rows)
      integer :: i

      do i = 1, n
         y(row(i)) = y(row(i)) + (position(i)*x(pair(i)) + velocity(i)*v(pair(i)))
         rate(row(i)) = rate(row(i)) + (rate_position(i)*x(pair(i)) + rate_velocity(i)*v(pair(i)))
      end do
   end subroutine add_both

   !> Adds a harmonic of the load.
   pure subroutine add_harmonic(n, ripple, frequency, turn, y, rate)
      !> Number of rows.
      integer, intent(in) :: n
      !> Complex amplitudes, circular frequency of the harmonic, and e^(i h Omega t).
      complex(wp), intent(in) :: ripple(n), turn
      !> As in `ripple`.
      real(wp), intent(in) :: frequency
      !> In and out: values and rates.
      real(wp), intent(inout) :: y(n), rate(n)
      complex(wp) :: here
      integer :: i

      do i = 1, n
         here = ripple(i)*turn
         y(i) = y(i) + here%re
         rate(i) = rate(i) - frequency*here%im
      end do
   end subroutine add_harmonic

   !> Bounds on rows from bounds on the pairs, without the harmonics and the offset.
   pure subroutine bound_values(rows, of_x, of_v, bound)
      !> The rows.
      type(rows_type), intent(in) :: rows
      !> (m) Bounds on |x| and |v|.
      real(wp), contiguous, intent(in) :: of_x(:), of_v(:)
      !> (rows)
      real(wp), contiguous, intent(out) :: bound(:)
      integer :: i, j, n, m

      bound = 0
      do j = 1, size(rows%blocks)
         associate (b => rows%blocks(j))
            n = b%last_row - b%first_row + 1
            m = b%last_pair - b%first_pair + 1
            call add_one(rows%wide, n, m, b%position_size, of_x(b%first_pair:b%last_pair), &
               bound(b%first_row:b%last_row))
            if (rows%by_position) cycle
            call add_one(rows%wide, n, m, b%velocity_size, of_v(b%first_pair:b%last_pair), &
               bound(b%first_row:b%last_row))
         end associate
      end do
      do i = 1, size(rows%row)
         bound(rows%row(i)) = bound(rows%row(i)) + abs(rows%position(i))*of_x(rows%pair(i)) &
            + abs(rows%velocity(i))*of_v(rows%pair(i))
      end do
   end subroutine bound_values

end module vi_rows
