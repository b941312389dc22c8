!> Rows of a chart of equispaced motions: in lanes, and one by one; the largest
!! displacement of a flight.
module studies_rows
   use checks, only: check, check_close
   use random_numbers, only: draw, draw_integer, draw_log, random_type
   use random_systems, only: random_frequency, random_oscillator
   use vi_equispaced_row, only: new_row, row_pair, row_pairs, row_type, summary_type
   use vi_kinds, only: wp
   use vi_motion, only: no, yes
   use vi_nodes, only: find_largest, most_nodes, new_nodes, nodes_type
   use vi_oscillator, only: eta, gain, oscillator_type
   use vi_processor, only: runs_wide
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: test_largest, test_rows

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
                  ! each may exceed the true value by 100 units in the last place of the bound
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

   !> The largest |x| of random flights whose ends are equally far from 0 equals that of many
   !! samples; it is certain for nearly all of them, with either sign and at any position.
   subroutine test_largest()
      integer, parameter :: samples = 4000
      type(nodes_type) :: nodes
      real(wp) :: xi, r, duration, parts(4), ends(4), largest, sampled, bound, scale
      real(wp), allocatable :: x(:), x_rise(:)
      integer :: certain_ones, i, j, n, tried
      logical :: certain

      certain_ones = 0
      tried = 0
      do i = 1, 3000
         xi = draw_log(random, 1.0e-3_wp, 0.5_wp)
         r = draw_log(random, 0.1_wp, 5.0_wp)
         duration = draw_log(random, 0.05_wp, 40.0_wp)
         call new_nodes(xi, r, duration, nodes)
         n = nodes%n
         call check((n == 0) .eqv. 8*duration*max(1.0_wp, r) > most_nodes*acos(-1.0_wp), &
            'flights that need too many nodes have none')
         if (n == 0) cycle
         do j = 1, 4
            parts(j) = draw(random, -1.0_wp, 1.0_wp)
         end do
         if (mod(i, 4) == 0) parts(:2) = 0.01_wp*parts(:2)
         if (mod(i, 4) == 1) parts(3:) = 0.01_wp*parts(3:)
         ! x(0) = x(T) or -x(T)
         ends = functions(0.0_wp) + merge(1, -1, mod(i, 2) == 0)*functions(duration)
         j = maxloc(abs(ends), dim=1)
         parts(j) = parts(j) - dot_product(parts, ends)/ends(j)
         if (norm2(parts) > 10) cycle
         call check_close(maxval(abs(nodes%position(:, n) - functions(duration))), 0.0_wp, &
            1.0e-13_wp, 'the last node is at the end')
         bound = norm2(parts(:2)) + r**4*norm2(parts(3:))
         x = matmul(parts, nodes%position)
         x_rise = matmul(parts, nodes%rise)
         call find_largest(nodes, parts, bound, x, x_rise, largest, certain)
         tried = tried + 1
         if (.not. certain) cycle
         certain_ones = certain_ones + 1
         sampled = maxval([(abs(dot_product(parts, functions(duration*j/samples))), j=0, samples)])
         scale = max(1.0_wp, r**2)*norm2(parts)
         call check_close(largest, sampled, 0.2_wp*scale*(duration/samples)**2 + 1.0e-12_wp*scale, &
            'the largest displacement of a flight')
         call check(largest >= sampled - 1.0e-12_wp*bound, 'none is larger')
      end do
      call check(tried > 1500 .and. 100*certain_ones > 95*tried, 'nearly all are certain')

   contains

      !> The four functions at a time.
      pure function functions(t) result(f)
         real(wp), intent(in) :: t
         real(wp) :: f(4)

         f = [exp(-xi*t)*sin(eta(xi)*t), exp(-xi*t)*cos(eta(xi)*t), sin(r*t), cos(r*t)]
      end function functions

   end subroutine test_largest

end module studies_rows
