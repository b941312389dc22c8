!> Multipliers of a periodic motion: the eigenvalues of [P] = [P_N] .. [P_1], equations (31), (32).
module vi_stability
   use vi_impact_map, only: forced_part, impact_map_of
   use vi_kinds, only: wp
   use vi_lapack, only: eigenvalues
   use vi_motion, only: motion_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: stability_matrix, multipliers, multipliers_of_half, multipliers_of_matrix, leading_kind

contains

   !> [P] of a motion.
   pure subroutine stability_matrix(motion, p, status)
      !> A complete motion.
      type(motion_type), intent(in) :: motion
      !> [P]; rows and columns (x, x', z', alpha); undefined unless the status is `stat%ok`.
      real(wp), intent(out) :: p(4, 4)
      !> `stat%ok`, `stat%zero_approach` or `stat%not_finite`.
      integer, intent(out) :: status
      real(wp) :: part(4, 4), forced(2)
      logical :: regular
      integer :: i

      status = stat%zero_approach
      forced = forced_part(motion)
      call impact_map_of(motion, 1, forced, p, regular)
      if (.not. regular) return
      do i = 2, size(motion%phases)
         call impact_map_of(motion, i, forced, part, regular)
         if (.not. regular) return
         p = matmul(part, p)
      end do
      status = merge(stat%ok, stat%not_finite, all(abs(p) <= huge(1.0_wp)))
   end subroutine stability_matrix

   !> The four multipliers, in order of decreasing modulus.
   pure subroutine multipliers(motion, lambda, status)
      !> A complete motion.
      type(motion_type), intent(in) :: motion
      !> In order of decreasing modulus; 0 unless the status is `stat%ok` or `stat%lapack_failed`.
      complex(wp), intent(out) :: lambda(4)
      !> As in `stability_matrix`, or `stat%lapack_failed`.
      integer, intent(out) :: status
      real(wp) :: p(4, 4)

      lambda = 0
      call stability_matrix(motion, p, status)
      if (status == stat%ok) call multipliers_of_matrix(p, lambda, status)
   end subroutine multipliers

   !> The eigenvalues of [P].
   pure subroutine multipliers_of_matrix(p, lambda, status)
      !> In: [P], finite. Out: overwritten.
      real(wp), intent(inout), contiguous :: p(:, :)
      !> (4) In order of decreasing modulus.
      complex(wp), intent(out) :: lambda(:)
      !> `stat%ok` or `stat%lapack_failed`.
      integer, intent(out) :: status

      call eigenvalues(p, lambda, status)
      call sort_by_modulus(lambda)
   end subroutine multipliers_of_matrix

   !> The four multipliers of a motion that is its own mirror image half a period later.
   !!
   !! With [Q] = the mirror times the map of half a period, [P] = [Q]^2.
   pure subroutine multipliers_of_half(q, lambda, status)
      !> In: [Q]. Out: overwritten.
      real(wp), intent(inout), contiguous :: q(:, :)
      !> In order of decreasing modulus; 0 if [Q] is not finite.
      complex(wp), intent(out) :: lambda(4)
      !> `stat%ok`, `stat%not_finite` or `stat%lapack_failed`.
      integer, intent(out) :: status

      lambda = 0
      status = merge(stat%ok, stat%not_finite, all(abs(q) <= huge(1.0_wp)))
      if (status /= stat%ok) return
      call eigenvalues(q, lambda, status)
      lambda = lambda**2
      call sort_by_modulus(lambda)
   end subroutine multipliers_of_half

   !> Where the leading multiplier lies: 'positive', 'negative' or 'complex'.
   !!
   !! If it crosses the unit circle there, the bifurcation is a fold or pitchfork, a flip, or a
   !! Neimark-Sacker bifurcation, respectively.
   pure function leading_kind(lambda) result(kind)
      !> (4) The multipliers in order of decreasing modulus.
      complex(wp), intent(in) :: lambda(:)
      character(8) :: kind

      if (abs(lambda(1)%im) > 0) then
         kind = 'complex'
      else if (lambda(1)%re < 0) then
         kind = 'negative'
      else
         kind = 'positive'
      end if
   end function leading_kind

   !> Insertion sort; equal moduli keep their order, so that conjugates stay together.
   pure subroutine sort_by_modulus(lambda)
      !> In and out: the numbers; sorted by decreasing modulus on return.
      complex(wp), intent(inout) :: lambda(:)
      real(wp) :: square(size(lambda)), item_square
      complex(wp) :: item
      integer :: i, j

      square = lambda%re**2 + lambda%im**2
      do i = 2, size(lambda)
         item = lambda(i)
         item_square = square(i)
         j = i
         do while (j > 1)
            if (square(j - 1) >= item_square) exit
            lambda(j) = lambda(j - 1)
            square(j) = square(j - 1)
            j = j - 1
         end do
         lambda(j) = item
         square(j) = item_square
      end do
   end subroutine sort_by_modulus

end module vi_stability
