!> Motions that begin at bifurcations of other motions.
module studies_switching
   use checks, only: check, check_close
   use random_numbers, only: random_type
   use random_systems, only: random_motion
   use vi_assess, only: assess_exact, assess_linear, paper_acceptance
   use vi_branch_switching, only: at_flip, at_grazing, at_pitchfork, most_switched, switch_branch
   use vi_chain, only: equispaced_chain
   use vi_exact, only: setting_type, solve_exact
   use vi_kinds, only: wp
   use vi_motion, only: motion_type, yes
   use vi_orbit, only: by_clearance, by_r, by_right, by_xi
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: new_pattern, pattern_type
   use vi_periodic, only: linear_system_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: test_switching

   type(random_type) :: random

contains

   subroutine test_switching()
      call test_two_touches()
      call test_pitchfork()
      call test_flip()
      call test_nothing_begins()
   end subroutine test_switching

   !> The first equispaced motion of a cycle at a clearance, which is its own mirror image.
   subroutine equispaced(xi, restitution, clearance, motion)
      real(wp), intent(in) :: xi, restitution, clearance
      type(motion_type), intent(out) :: motion
      type(linear_system_type) :: system
      type(motion_type) :: motions(2)

      call equispaced_chain(oscillator_type(xi, 0.1_wp, [restitution, restitution]), 0.8_wp, &
         clearance, 1, paper_acceptance, .true., system, motions)
      motion = motions(1)
      call check(motion%status == stat%ok, 'switching: an equispaced motion')
   end subroutine equispaced

   !> Where a motion and its mirror image both touch a wall, a motion with one more impact
   !! starts for each touch, and one with both, whichever of the two touches is given.
   subroutine test_two_touches()
      real(wp), parameter :: critical = 1.7919869460695672_wp, &
         elastic = 0.98940371755490175_wp
      type(motion_type) :: motion, found(most_switched), others(most_switched)
      integer :: n, m

      call equispaced(0.05_wp, 0.6_wp, critical, motion)
      call switch_branch(motion, at_grazing, 1, 1, by_clearance, .false., found, n)
      call switch_branch(motion, at_grazing, 2, -1, by_clearance, .false., others, m)
      call check(n == 2 .and. m == 2, 'switching: one touch, and both')
      if (n /= 2 .or. m /= 2) return
      call check(all(found(1)%pattern%sides == [1, 1, -1]) .and. &
         all(others(1)%pattern%sides == [1, -1, -1]), 'switching: the impact at a touch')
      call check(all(found(2)%pattern%sides == [1, 1, -1, -1]) .and. &
         all(others(2)%pattern%sides == [1, 1, -1, -1]), 'switching: the impacts at both touches')
      call check_close(maxval(abs(found(2)%x - others(2)%x)), 0.0_wp, 1e-12_wp, &
         'switching: the same motion from either touch')
      ! the second half mirrors the first
      call check_close(maxval(abs(found(2)%x(3:) + found(2)%x(:2))), 0.0_wp, 1e-9_wp, &
         'switching: both touches keep the symmetry')
      call check(all([found%admissible, others%admissible] == yes), 'switching: it is admissible')
      ! without losses they start near this touch, but not where impacts would add energy
      call equispaced(0.05_wp, 1.0_wp, elastic, motion)
      call switch_branch(motion, at_grazing, 1, 1, by_clearance, .true., found, n)
      call check(n == 2, 'switching: one touch, and both, of elastic impacts')
      call switch_branch(motion, at_grazing, 1, 1, by_right, .true., found, n)
      call check(n == 0, 'switching: restitution is at most 1')
   end subroutine test_two_touches

   !> At a pitchfork, two motions start that are mirror images of each other, at another value of
   !! one parameter. There are none at a value that the parameter cannot have: at this pitchfork,
   !! the damping would have to be negative.
   subroutine test_pitchfork()
      real(wp), parameter :: critical = 15.408624800244240_wp
      type(motion_type) :: motion, found(most_switched)
      integer :: n, p

      call equispaced(0.0_wp, 0.6_wp, critical, motion)
      do p = by_r, by_right
         n = 99
         call switch_branch(motion, at_pitchfork, 0, 0, p, p == by_right, found, n)
         call check(n == merge(0, 2, p == by_xi), 'switching: two motions at a pitchfork')
         if (n /= 2) cycle
         call check(all(found%status == stat%ok), 'switching: motions at a pitchfork')
         call check_close(maxval(abs(found(2)%x + cshift(found(1)%x, 1))), 0.0_wp, 1e-9_wp, &
            'switching: mirror images')
         call check(abs(sum(found(1)%x)) > 1e-3_wp, 'switching: not their own images')
         associate (f => found(1), m => motion)
            call check_close(abs(f%r/m%r - 1) + abs(f%clearance/m%clearance - 1) + &
               abs(f%osc%mu/m%osc%mu - 1) + abs(f%osc%restitution(1)/0.6_wp - 1), 1e-4_wp, &
               1e-12_wp, 'switching: one parameter changes')
            call check(abs(f%osc%restitution(1) - f%osc%restitution(2)) <= 0, &
               'switching: both walls remain alike')
         end associate
      end do
   end subroutine test_pitchfork

   !> At a flip a motion of twice the period starts, even if the motion at the flip is given over
   !! two periods. If the periods of such a motion differ, it is not at a flip.
   subroutine test_flip()
      real(wp), parameter :: critical = 7.7233155664012489_wp, x(3) = [3.2523283181522382_wp, &
         3.8648459233151695e-2_wp, -2.6337093125603341_wp], phases(3) = [0.0_wp, &
         1.7277799484434833_wp, 3.8882027285236607_wp], tau = 1.6069162791150013_wp
      real(wp), parameter :: turn = 2*acos(-1.0_wp)
      type(motion_type) :: motion, twice, found(most_switched), again(most_switched)
      integer :: n, m, p

      call solve('RRL', critical, x, phases + tau, motion)
      twice = motion
      twice%pattern = new_pattern('RRLRRL', 2)
      twice%x = [motion%x, motion%x]
      twice%phases = [motion%phases, motion%phases + turn]
      twice%restitution = [motion%restitution, motion%restitution]
      do p = by_r, by_right
         call switch_branch(motion, at_flip, 0, 0, p, p == by_right, found, n)
         call switch_branch(twice, at_flip, 0, 0, p, p == by_right, again, m)
         call check(n == 1 .and. m == 1, 'switching: one motion at a flip')
         if (n /= 1 .or. m /= 1) cycle
         associate (f => found(1), g => again(1))
            call check(f%status == stat%ok .and. f%pattern%cycles == 2 .and. &
               all(f%pattern%sides == [1, 1, -1, 1, 1, -1]), 'switching: twice the period')
            call check(maxval(abs(f%x(4:) - f%x(:3))) > 1e-2_wp, 'switching: periods that differ')
            call check_close(min(maxval(abs(g%x - f%x)), maxval(abs(g%x - cshift(f%x, 3)))), &
               0.0_wp, 1e-6_wp, 'switching: the same from two periods')
            call check(abs(f%osc%restitution(1) - f%osc%restitution(2)) <= 0, &
               'switching: both walls remain alike at a flip')
         end associate
         call switch_branch(found(1), at_flip, 0, 0, p, p == by_right, again, m)
         call check(m == 0, 'switching: no flip where periods differ')
         call switch_branch(motion, at_pitchfork, 0, 0, p, p == by_right, again, m)
         call check(m == 0, 'switching: a flip is no pitchfork')
      end do
   end subroutine test_flip

   !> The motion near a guess, for r = 0.8, xi = 0.05, mu = 0.1, R = 0.6.
   subroutine solve(symbols, clearance, x, theta, motion)
      character(*), intent(in) :: symbols
      real(wp), intent(in) :: clearance, x(:), theta(:)
      type(motion_type), intent(out) :: motion
      type(pattern_type) :: pattern
      real(wp) :: x_now(size(x)), theta_now(size(x)), none(2*size(x), 0)
      integer :: iterations

      pattern = new_pattern(symbols, size(x)/3)
      x_now = x
      theta_now = theta
      call solve_exact(setting_type(oscillator_type(0.05_wp, 0.1_wp, [0.6_wp, 0.6_wp]), 0.8_wp, &
         1.0_wp, clearance, pattern, spread(0.6_wp, 1, size(x))), x_now, theta_now, 50, none, &
         motion, iterations)
      call check(motion%status == stat%ok, 'switching: a motion at a flip')
      call assess_exact(motion)
   end subroutine solve

   !> Without a critical multiplier, or without multipliers at all, no motion starts.
   subroutine test_nothing_begins()
      type(motion_type) :: motion, found(most_switched)
      integer :: i, n, tried

      tried = 0
      do i = 1, 200
         call random_motion(random, 2 + mod(i, 3), motion)
         if (motion%status /= stat%ok) cycle
         call assess_linear(motion, paper_acceptance)
         if (any(abs(abs(motion%multipliers%re) - 1) < 0.05_wp)) cycle
         call switch_branch(motion, at_pitchfork, 0, 0, by_clearance, .false., found, n)
         call check(n == 0, 'switching: no pitchfork')
         call switch_branch(motion, at_flip, 0, 0, by_clearance, .false., found, n)
         call check(n == 0, 'switching: no flip')
         tried = tried + 1
      end do
      ! no approach speed at the second impact
      call equispaced(0.05_wp, 0.6_wp, 2.0_wp, motion)
      motion%z_dot_after(1) = motion%x_dot_before(2)
      call switch_branch(motion, at_pitchfork, 0, 0, by_clearance, .false., found, n)
      call check(n == 0, 'switching: an impact without approach speed')
      call check(tried > 50, 'switching: motions without a critical multiplier')
   end subroutine test_nothing_begins

end module studies_switching
