!> Rows of a chart of equispaced motions: in lanes, and one motion after the other.
module studies_rows
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, draw_log, random_type
   use random_systems, only: random_frequency, random_oscillator
   use vi_equispaced_row, only: new_row, row_pair, row_pairs, row_type, summary_type
   use vi_kinds, only: wp
   use vi_motion, only: no, yes
   use vi_oscillator, only: gain, oscillator_type
   use vi_processor, only: runs_wide
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: test_rows

   type(random_type) :: random

contains

   subroutine test_rows()
      integer, parameter :: m = 70
      type(oscillator_type) :: osc
      type(row_type) :: row
      type(summary_type) :: pairs(2, m), wide(2, m), pair(2)
      real(wp) :: r, clearance(m)
      integer :: i, j, k, seen(no:yes, 2)

      seen = 0
      do i = 1, 300
         call random_oscillator(random, osc)
         osc%restitution(2) = osc%restitution(1)
         r = random_frequency(random)
         if (mod(i, 2) == 0) r = draw(random, 0.8_wp, 1.2_wp)
         do j = 1, m
            clearance(j) = draw_log(random, 1.0e-2_wp, 4.0_wp)*gain(osc%xi, r)
         end do
         call new_row(osc, r, 2*draw_integer(random, 0, 2) + 1, row)
         call row_pairs(row, clearance, mod(i, 3) == 0, .false., pairs)
         if (runs_wide() /= 0) then
            call row_pairs(row, clearance, mod(i, 3) == 0, .true., wide)
            call check(all(pairs%admissible == wide%admissible .and. pairs%stable == wide%stable), &
               'rows: the same verdicts with wide registers')
            call check(all(transfer(pairs%x_max, [0]) == transfer(wide%x_max, [0])), &
               'rows: the same bits with wide registers')
         end if
         do j = 1, m
            call row_pair(row, clearance(j), mod(i, 3) == 0, pair)
            call check(all(pairs(:, j)%status == pair%status), 'rows: status')
            do k = 1, 2
               if (pair(k)%status /= stat%ok) cycle
               associate (one => pair(k), lane => pairs(k, j))
                  call check(one%consistent == lane%consistent .and. one%stable == lane%stable &
                     .and. one%admissible == lane%admissible, 'rows: verdicts')
                  call check_close(lane%x, one%x, 0.0_wp, 'rows: x_1')
                  call check_close(lane%tau, one%tau, 0.0_wp, 'rows: tau')
                  ! either may exceed the true value by 100 units in the last place of the bound
                  call check_close(lane%x_max, one%x_max, 1.0e-12_wp*(one%x_max + clearance(j) &
                     + gain(osc%xi, r)*(1 + r**4)), 'rows: x_max')
                  call check_close(lane%x_min, one%x_min, 1.0e-12_wp*(one%x_max + clearance(j) &
                     + gain(osc%xi, r)*(1 + r**4)), 'rows: x_min')
                  if (mod(i, 3) == 0) call check_close(maxval(abs(lane%multipliers &
                     - one%multipliers)), 0.0_wp, 0.0_wp, 'rows: multipliers')
                  if (lane%admissible >= no) seen(lane%admissible, 1) = seen(lane%admissible, 1) + 1
                  if (lane%stable >= no) seen(lane%stable, 2) = seen(lane%stable, 2) + 1
               end associate
            end do
         end do
      end do
      call check(all(seen > 500), 'rows: every verdict comes up')
   end subroutine test_rows

end module studies_rows
