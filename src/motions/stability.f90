!> Multipliers of a periodic motion: the eigenvalues of [P] = [P_N] .. [P_1], equations (31), (32).
module vi_stability
   use vi_impact_map, only: impact_maps
   use vi_kinds, only: wp
   use vi_lapack, only: eigenvalues
   use vi_motion, only: motion_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: stability_matrix, multipliers

contains

   !> [P] of a motion.
   pure subroutine stability_matrix(motion, p, status)
      type(motion_type), intent(in) :: motion
      real(wp), intent(out) :: p(4, 4)
      !> `stat%ok`, `stat%zero_approach` or `stat%not_finite`.
      integer, intent(out) :: status
      real(wp) :: part(4, 4, size(motion%phases))
      logical :: regular
      integer :: i

      call impact_maps(motion, part, regular)
      status = stat%zero_approach
      if (.not. regular) return
      p = part(:, :, 1)
      do i = 2, size(part, 3)
         p = matmul(part(:, :, i), p)
      end do
      status = merge(stat%ok, stat%not_finite, all(abs(p) <= huge(1.0_wp)))
   end subroutine stability_matrix

   !> The four multipliers, by falling modulus.
   pure subroutine multipliers(motion, lambda, status)
      type(motion_type), intent(in) :: motion
      complex(wp), intent(out) :: lambda(4)
      integer, intent(out) :: status
      real(wp) :: p(4, 4)

      lambda = 0
      call stability_matrix(motion, p, status)
      if (status /= stat%ok) return
      call eigenvalues(p, lambda, status)
      call sort_by_modulus(lambda)
   end subroutine multipliers

   !> Insertion sort; equal moduli keep their order, so that conjugates stay together.
   pure subroutine sort_by_modulus(lambda)
      complex(wp), intent(inout) :: lambda(:)
      real(wp) :: modulus(size(lambda)), m
      complex(wp) :: item
      integer :: i, j

      modulus = abs(lambda)
      do i = 2, size(lambda)
         item = lambda(i)
         m = modulus(i)
         j = i - 1
         do while (j >= 1)
            if (modulus(j) >= m) exit
            lambda(j + 1) = lambda(j)
            modulus(j + 1) = modulus(j)
            j = j - 1
         end do
         lambda(j + 1) = item
         modulus(j + 1) = m
      end do
   end subroutine sort_by_modulus

end module vi_stability
