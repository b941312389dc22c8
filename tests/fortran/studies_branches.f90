!> Branches without a family or a motion at their start, and branches along which both walls
!! change.
module studies_branches
   use checks, only: check, check_close
   use vi_assess, only: paper_acceptance
   use vi_branch, only: end_bound, end_stuck
   use vi_branch_table, only: branch_arrays, branch_request_type
   use vi_chain, only: equispaced_chain
   use vi_kinds, only: wp
   use vi_motion, only: motion_type
   use vi_orbit, only: by_left, by_r, by_right
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: new_pattern, pattern_type
   use vi_periodic, only: linear_system_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: test_branches

   !> Most points.
   integer, parameter :: most = 100

contains

   subroutine test_branches()
      call test_no_family()
      call test_no_start()
      call test_both_walls()
   end subroutine test_branches

   !> Follows a branch from some unknowns, for r = 0.8, D = 2, xi = 0.05, mu = 0.1.
   subroutine follow(pattern, symmetric, walls, parameter, tied, bounds, unknowns, n, reasons, &
      status, found)
      type(pattern_type), intent(in) :: pattern
      logical, intent(in) :: symmetric, tied
      real(wp), intent(in) :: walls(2), bounds(2), unknowns(:)
      integer, intent(in) :: parameter
      integer, intent(out) :: n, reasons(2), status
      !> r, D, xi, mu, R1, R2 of the points.
      real(wp), allocatable, intent(out), optional :: found(:, :)
      real(wp) :: parameters(6, most), phases(size(unknowns)/2, most), scalars(6, most)
      real(wp) :: impacts(size(unknowns)/2, 6, most)
      complex(wp) :: multipliers(4, most)
      integer :: verdicts(3, most), codes(most), special(3, most)

      call branch_arrays(branch_request_type(pattern, symmetric, [0.8_wp, log(2.0_wp), 0.05_wp, &
         0.1_wp, walls], parameter, tied, bounds), unknowns, parameters, phases, impacts, scalars, &
         multipliers, verdicts, codes, special, n, reasons, status)
      if (present(found)) found = parameters(:, :n)
   end subroutine follow

   !> Symmetric motions need a pattern whose second half mirrors the first, an odd number of load
   !! cycles, and equal walls all along the branch.
   subroutine test_no_family()
      real(wp), parameter :: alike(2) = 0.6_wp, other(2) = [0.6_wp, 0.5_wp], range(2) = [0.5, 0.9]
      real(wp), parameter :: swapped(2) = [0.5_wp, 0.6_wp]
      real(wp) :: four(4), six(6)
      integer :: n, reasons(2), status, i

      four = [0.3_wp, -0.3_wp, 1.0_wp, 4.0_wp]
      six = [0.3_wp, 0.3_wp, -0.3_wp, 1.0_wp, 2.0_wp, 4.0_wp]
      do i = 1, 5
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
         case (4)
            call follow(new_pattern('RL', 1), .true., swapped, by_r, .false., range, four, n, &
               reasons, status)
         case default
            call follow(new_pattern('RL', 1), .true., alike, by_right, .false., range, four, n, &
               reasons, status)
         end select
         call check(status == stat%no_motion .and. n == 0 .and. all(reasons == 0), &
            'branches: no such family')
      end do
      ! if both walls change together, there is such a branch
      call follow(new_pattern('RL', 1), .true., alike, by_right, .true., range, four, n, reasons, &
         status)
      call check(status == stat%ok, 'branches: walls that remain alike')
   end subroutine test_no_family

   !> From unknowns that are far from all motions, a branch cannot be followed in either direction:
   !! it has no point except its start.
   subroutine test_no_start()
      real(wp), parameter :: range(2) = [0.5_wp, 0.9_wp]
      real(wp) :: unknowns(4)
      integer :: n, reasons(2), status, i

      do i = 1, 10
         unknowns = [10.0_wp**i, 10.0_wp**i, 0.0_wp, 1.0e-3_wp]
         call follow(new_pattern('RL', 1), .false., [0.6_wp, 0.5_wp], by_r, .false., range, &
            unknowns, n, reasons, status)
         call check(status == stat%ok .and. n == 1 .and. all(reasons == end_stuck), &
            'branches: no motion at the start')
      end do
   end subroutine test_no_start

   !> If the restitution of both walls changes together, it is the same at each point, from one
   !! bound to the other; if that of one wall changes, the other one stays.
   subroutine test_both_walls()
      real(wp), parameter :: range(2) = [0.55_wp, 0.65_wp]
      type(linear_system_type) :: system
      type(motion_type) :: motions(2)
      real(wp), allocatable :: found(:, :)
      integer :: n, reasons(2), status, i, wall
      logical :: tied

      call equispaced_chain(oscillator_type(0.05_wp, 0.1_wp, [0.6_wp, 0.6_wp]), 0.8_wp, 2.0_wp, 1, &
         paper_acceptance, .true., system, motions)
      do i = 0, 2
         tied = i == 0
         wall = merge(by_left, by_right, i == 2)
         associate (m => motions(1))
            call follow(new_pattern('RL', 1), tied, [0.6_wp, 0.6_wp], wall, tied, range, &
               [m%x/2, m%phases + m%tau], n, reasons, status, found)
         end associate
         call check(status == stat%ok .and. n > 2 .and. all(reasons == end_bound), &
            'branches: from bound to bound')
         if (n < 3) cycle
         call check_close(abs(found(wall, 1) - range(1)) + abs(found(wall, n) - range(2)), 0.0_wp, &
            0.0_wp, 'branches: the bounds')
         call check(all(found(wall, 2:) > found(wall, :n - 1)), 'branches: between them')
         if (tied) call check_close(maxval(abs(found(by_left, :) - found(by_right, :))), 0.0_wp, &
            0.0_wp, 'branches: both walls')
         if (.not. tied) call check_close(maxval(abs(found(by_left + by_right - wall, :) &
            - 0.6_wp)), 0.0_wp, 0.0_wp, 'branches: the other wall')
      end do
   end subroutine test_both_walls

end module studies_branches
