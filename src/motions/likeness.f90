!> How far two sets of unknowns (x_i, theta_i) of one pattern are apart, as motions.
!!
!! A motion can be written in several ways: from any impact on that leaves the pattern as it is, and
!! with whole load cycles added to all theta_i.
module vi_likeness
   use vi_kinds, only: wp
   use vi_oscillator, only: gain, oscillator_type
   use vi_pattern, only: pattern_type
   implicit none (type, external)
   private

   public :: allows_symmetry, distance, is_repeated, is_symmetric, length_scale, &
      shortest_repetition

   !> Motions nearer than this are one motion.
   real(wp), parameter, public :: same = 1.0e-6_wp
   real(wp), parameter :: pi = acos(-1.0_wp)

contains

   !> The scale of positions: the clearance, or the amplitude without impacts if that is larger.
   elemental real(wp) function length_scale(osc, r, clearance)
      type(oscillator_type), intent(in) :: osc
      real(wp), intent(in) :: r, clearance

      length_scale = max(clearance, min(gain(osc%xi, r), huge(1.0_wp)))
   end function length_scale

   !> Whether a motion of a pattern can be its own mirror image half a period later.
   pure logical function allows_symmetry(osc, pattern)
      type(oscillator_type), intent(in) :: osc
      type(pattern_type), intent(in) :: pattern

      allows_symmetry = modulo(pattern%cycles, 2) == 1 .and. &
         abs(osc%restitution(1) - osc%restitution(2)) <= 0 .and. &
         all(cshift(pattern%sides, size(pattern%sides)/2) == -pattern%sides)
   end function allows_symmetry

   !> The least distance over all ways to write the other motion: the largest difference of any
   !! x_i over a scale, or of any theta_i.
   pure real(wp) function distance(pattern, scale, one, other)
      type(pattern_type), intent(in) :: pattern
      real(wp), intent(in) :: scale
      !> (2N) each
      real(wp), intent(in) :: one(:), other(:)
      integer :: j

      distance = huge(1.0_wp)
      do j = 0, size(pattern%sides) - 1
         distance = min(distance, turned_distance(pattern, scale, one, other, j, 1))
      end do
   end function distance

   !> Whether a motion is a shorter one written several times over.
   pure logical function is_repeated(pattern, scale, unknowns)
      type(pattern_type), intent(in) :: pattern
      real(wp), intent(in) :: scale, unknowns(:)
      integer :: j

      is_repeated = .false.
      do j = 1, size(pattern%sides) - 1
         is_repeated = is_repeated .or. &
            turned_distance(pattern, scale, unknowns, unknowns, j, 1) < same
      end do
   end function is_repeated

   !> After how many impacts a motion repeats itself first: all of them, unless it is a shorter one
   !! written several times over.
   pure integer function shortest_repetition(pattern, scale, unknowns) result(impacts)
      type(pattern_type), intent(in) :: pattern
      !> Of positions, as `length_scale`; x_i and theta_i (2N).
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
      type(pattern_type), intent(in) :: pattern
      real(wp), intent(in) :: scale, unknowns(:)
      integer :: j

      is_symmetric = .false.
      do j = 1, size(pattern%sides) - 1
         is_symmetric = is_symmetric .or. &
            turned_distance(pattern, scale, unknowns, unknowns, j, -1) < same
      end do
   end function is_symmetric

   !> The distance of a motion from another one (mirror = 1), or from its mirror image (-1), that is
   !! counted from its impact j + 1 on.
   pure real(wp) function turned_distance(pattern, scale, one, other, j, mirror) result(distance)
      type(pattern_type), intent(in) :: pattern
      real(wp), intent(in) :: scale, one(:), other(:)
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
