!> Integrity of the basins in a plane of initial states: pairs of states with different attractors,
!! and the largest disc inside a basin. The second axis of a plane is the first dimension of its
!! labels.
module vi_attractor_integrity
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: largest_disc, uncertain_pairs, uncertainty_exponent

   !> Distances in cells at which pairs are compared, up to an eighth of the plane.
   integer, parameter, public :: distances(8) = [1, 2, 3, 4, 6, 8, 12, 16]

contains

   !> Distances of pairs along either axis, and the share of the pairs with different attractors.
   pure function uncertain_pairs(labels) result(pairs)
      !> (second axis, first axis) Number of the attractor of each state.
      integer, intent(in) :: labels(:, :)
      !> (2, distances)
      real(wp), allocatable :: pairs(:, :)
      integer(int64) :: different, all_pairs
      integer :: i, s, m, n

      m = size(labels, 1)
      n = size(labels, 2)
      allocate (pairs(2, count(distances <= min(m, n)/8)))
      do i = 1, size(pairs, 2)
         s = distances(i)
         different = count(labels(s + 1:, :) /= labels(:m - s, :), kind=int64) + &
            count(labels(:, s + 1:) /= labels(:, :n - s), kind=int64)
         all_pairs = int(m - s, int64)*n + int(n - s, int64)*m
         pairs(:, i) = [real(s, wp), real(different, wp)/real(all_pairs, wp)]
      end do
   end function uncertain_pairs

   !> The exponent a if the share of pairs with different attractors grows as distance**a; NaN if
   !! there is no boundary.
   pure real(wp) function uncertainty_exponent(pairs) result(a)
      !> (2, distances) as from `uncertain_pairs`.
      real(wp), intent(in) :: pairs(:, :)
      real(wp), allocatable :: x(:), y(:)

      allocate (x, source=log(pack(pairs(1, :), pairs(2, :) > 0)))
      allocate (y, source=log(pack(pairs(2, :), pairs(2, :) > 0)))
      a = ieee_value(1.0_wp, ieee_quiet_nan)
      if (size(x) < 2) return
      x = x - sum(x)/size(x)
      a = dot_product(x, y)/dot_product(x, x)
   end function uncertainty_exponent

   !> The largest disc inside a basin. Its radius is the distance from a state to the nearest one
   !! with another attractor, or to the edge, which is one cell beyond the last states.
   pure subroutine largest_disc(labels, label, cells, radius, place)
      !> (second axis, first axis) Number of the attractor of each state; number of the attractor
      !! whose basin is examined.
      integer, intent(in) :: labels(:, :), label
      !> Distances between neighbours along the first and the second dimension.
      real(wp), intent(in) :: cells(2)
      !> Radius of the disc, in the unit of `cells`.
      real(wp), intent(out) :: radius
      !> Place of its centre along both dimensions.
      integer, intent(out) :: place(2)
      real(wp) :: squares(size(labels, 1), 0:size(labels, 2) + 1), steps(2)
      integer :: i, j, up, down

      steps = cells/maxval(cells)
      squares(:, [0, size(labels, 2) + 1]) = 0
      do j = 1, size(labels, 2)
         up = 0
         do i = 1, size(labels, 1)
            up = merge(up + 1, 0, labels(i, j) == label)
            squares(i, j) = (up*steps(1))**2
         end do
         down = 0
         do i = size(labels, 1), 1, -1
            down = merge(down + 1, 0, labels(i, j) == label)
            squares(i, j) = min(squares(i, j), (down*steps(1))**2)
         end do
      end do
      do i = 1, size(labels, 1)
         call lower_envelope(squares(i, :), steps(2))
      end do
      place = maxloc(squares(:, 1:size(labels, 2)))
      radius = maxval(cells)*sqrt(squares(place(1), place(2)))
   end subroutine largest_disc

   !> The minimum over q of f(q) + (cell (p - q))**2 for each place p, for all places in one pass
   !! (Felzenszwalb and Huttenlocher, Distance transforms of sampled functions, 2012).
   pure subroutine lower_envelope(f, cell)
      !> In: the values f(q). Out: the envelope.
      real(wp), intent(inout) :: f(:)
      !> Distance between neighbouring places.
      real(wp), intent(in) :: cell
      real(wp) :: least(size(f)), from(size(f)), crossing
      integer :: lowest(size(f)), k, p, q

      k = 1
      lowest(1) = 1
      from(1) = -huge(1.0_wp)
      do q = 2, size(f)
         do
            p = lowest(k)
            crossing = 0.5_wp*((f(q) - f(p))/(cell**2*(q - p)) + (q + p))
            if (k == 1 .or. crossing > from(k)) exit
            k = k - 1
         end do
         k = k + 1
         lowest(k) = q
         from(k) = crossing
      end do
      do p = size(f), 1, -1
         do while (from(k) > p)
            k = k - 1
         end do
         least(p) = f(lowest(k)) + (cell*(p - lowest(k)))**2
      end do
      f = least
   end subroutine lower_envelope

end module vi_attractor_integrity
