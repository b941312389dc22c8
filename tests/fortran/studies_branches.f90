!> Branches that have no family.
module studies_branches
   use checks, only: check
   use vi_branch_table, only: branch_arrays, branch_request_type
   use vi_kinds, only: wp
   use vi_orbit, only: by_r, by_right
   use vi_pattern, only: new_pattern, pattern_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: test_branches

   !> Most points.
   integer, parameter :: most = 100

contains

   subroutine test_branches()
      call test_no_family()
   end subroutine test_branches

   !> Follows a branch from some unknowns, for r = 0.8, D = 2, xi = 0.05, mu = 0.1.
   subroutine follow(pattern, symmetric, walls, parameter, tied, bounds, unknowns, n, reasons, &
      status)
      type(pattern_type), intent(in) :: pattern
      logical, intent(in) :: symmetric, tied
      real(wp), intent(in) :: walls(2), bounds(2), unknowns(:)
      integer, intent(in) :: parameter
      integer, intent(out) :: n, reasons(2), status
      real(wp) :: parameters(6, most), phases(size(unknowns)/2, most), scalars(6, most)
      real(wp) :: impacts(size(unknowns)/2, 6, most)
      complex(wp) :: multipliers(4, most)
      integer :: verdicts(3, most), codes(most), special(3, most)

      call branch_arrays(branch_request_type(pattern, symmetric, [0.8_wp, log(2.0_wp), 0.05_wp, &
         0.1_wp, walls], parameter, tied, bounds), unknowns, parameters, phases, impacts, scalars, &
         multipliers, verdicts, codes, special, n, reasons, status)
   end subroutine follow

   !> Symmetric motions take a pattern whose second half mirrors the first, an odd number of load
   !! cycles, and walls that are alike all along the branch.
   subroutine test_no_family()
      real(wp), parameter :: alike(2) = 0.6_wp, other(2) = [0.6_wp, 0.5_wp], range(2) = [0.5, 0.9]
      real(wp) :: four(4), six(6)
      integer :: n, reasons(2), status, i

      four = [0.3_wp, -0.3_wp, 1.0_wp, 4.0_wp]
      six = [0.3_wp, 0.3_wp, -0.3_wp, 1.0_wp, 2.0_wp, 4.0_wp]
      do i = 1, 4
         select case (i)
         case (1)
            call follow(new_pattern('RRL', 1), .true., alike, by_r, .false., range, six, n, &
               reasons, status)
         case (2)
            call follow(new_pattern('RL', 2), .true., alike, by_r, .false., range, four, n, &
               reasons, status)
         case (3)
            call follow(new_pattern('RL', 1), .true., other, by_r, .false., range, four, n, &
               reasons, status)
         case default
            call follow(new_pattern('RL', 1), .true., alike, by_right, .false., range, four, n, &
               reasons, status)
         end select
         call check(status == stat%no_motion .and. n == 0 .and. all(reasons == 0), &
            'branches: no such family')
      end do
      ! if both walls change together, there is one
      call follow(new_pattern('RL', 1), .true., alike, by_right, .true., range, four, n, reasons, &
         status)
      call check(status == stat%ok, 'branches: walls that remain alike')
   end subroutine test_no_family

end module studies_branches
