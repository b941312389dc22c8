!> Distances between motions of one pattern, given by their unknowns (x_i, theta_i).
!!
!! The same motion has several sets of unknowns: it can begin with any impact that leaves the
!! pattern unchanged, and whole load cycles can be added to all theta_i.
module vi_likeness
   use vi_kinds, only: pi, wp
   use vi_oscillator, only: gain, oscillator_type
   use vi_pattern, only: pattern_type
   implicit none (type, external)
   private

   public :: distance, is_repeated, is_symmetric, length_scale, shortest_repetition

   !> Motions closer than this distance are the same.
   real(wp), parameter, public :: same = 1.0e-6_wp

contains

   !> The scale of positions: the clearance, or the amplitude without impacts if that is larger.
   elemental real(wp) function length_scale(osc, r, clearance)
      !> Oscillator; xi is read.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio, and clearance (F0/K).
      real(wp), intent(in) :: r, clearance

      length_scale = max(clearance, min(gain(osc%xi, r), huge(1.0_wp)))
   end function length_scale

   !> The least distance over all sets of unknowns of the other motion. A distance is the largest
   !! difference of any x_i, over a scale, or of any theta_i (rad).
   pure real(wp) function distance(pattern, scale, one, other)
      !> Pattern of both.
      type(pattern_type), intent(in) :: pattern
      !> Unit of positions, as `length_scale`.
      real(wp), intent(in) :: scale
      !> (2N) x_i and theta_i of each.
      real(wp), intent(in) :: one(:), other(:)
      integer :: j

      distance = huge(1.0_wp)
      do j = 0, size(pattern%sides) - 1
         distance = min(distance, turned_distance(pattern, scale, one, other, j, 1))
      end do
   end function distance

   !> Whether a motion consists of several periods of a shorter one.
   pure logical function is_repeated(pattern, scale, unknowns)
      !> The pattern.
      type(pattern_type), intent(in) :: pattern
      !> Unit of positions, as `length_scale`; x_i and theta_i (2N).
      real(wp), intent(in) :: scale, unknowns(:)
      integer :: j

      is_repeated = .false.
      do j = 1, size(pattern%sides) - 1
         is_repeated = is_repeated .or. &
            turned_distance(pattern, scale, unknowns, unknowns, j, 1) < same
      end do
   end function is_repeated

   !> Number of impacts after which a motion first repeats itself: all of them, unless it consists
   !! of several periods of a shorter one.
   pure integer function shortest_repetition(pattern, scale, unknowns) result(impacts)
      !> The pattern.
      type(pattern_type), intent(in) :: pattern
      !> Unit of positions, as `length_scale`; x_i and theta_i (2N).
      real(wp), intent(in) :: scale, unknowns(:)
      integer :: j, n

      n = size(pattern%sides)
      impacts = n
      do j = n/2, 2, -1
         if (modulo(n, j) /= 0 .or. modulo(pattern%cycles*j, n) /= 0) cycle
         if (turned_distance(pattern, scale, unknowns, unknowns, j, 1) < same) impacts = j
      end do
   end function shortest_repetition

   !> Whether a motion is its own mirror image: x -> -x, R <-> L, half a load cycle later.
   pure logical function is_symmetric(pattern, scale, unknowns)
      !> The pattern.
      type(pattern_type), intent(in) :: pattern
      !> Unit of positions, as `length_scale`; x_i and theta_i (2N).
      real(wp), intent(in) :: scale, unknowns(:)
      integer :: j

      is_symmetric = .false.
      do j = 1, size(pattern%sides) - 1
         is_symmetric = is_symmetric .or. &
            turned_distance(pattern, scale, unknowns, unknowns, j, -1) < same
      end do
   end function is_symmetric

   !> The distance of a motion from another one, or from its mirror image, whose impacts are counted
   !! from number j + 1 on; huge if the sides differ.
   pure real(wp) function turned_distance(pattern, scale, one, other, j, mirror) result(distance)
      !> Pattern of both.
      type(pattern_type), intent(in) :: pattern
      !> Unit of positions, as `length_scale`; x_i and theta_i (2N) of each.
      real(wp), intent(in) :: scale, one(:), other(:)
      !> Number of impacts left out; +1 for the other motion, -1 for its mirror image.
      integer, intent(in) :: j, mirror
      real(wp) :: gap, shift
      integer :: i, k, n

      n = size(pattern%sides)
      distance = huge(1.0_wp)
      do i = 1, n
         if (pattern%sides(i) /= mirror*pattern%sides(modulo(i + j - 1, n) + 1)) return
      end do
      distance = 0
      shift = 0
      do i = 1, n
         k = modulo(i + j - 1, n) + 1
         gap = other(n + k) - one(n + i)
         if (i + j > n) gap = gap + 2*pi*pattern%cycles
         if (mirror < 0) gap = gap - pi
         if (i == 1) shift = 2*pi*nint(gap/(2*pi))
         distance = max(distance, abs(gap - shift), abs(mirror*other(k) - one(i))/scale)
      end do
   end function turned_distance

end module vi_likeness
