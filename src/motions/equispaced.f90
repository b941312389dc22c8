!> The symmetric pair: two equally spaced impacts in k load cycles (k odd), equal restitution.
!!
!! The phases 0, k pi leave the equations (26), (30) with rank 3: any amplitude A is possible. With
!! x_2 = -x_1 they are two equations in x_1, A cos(tau), A sin(tau). Given the clearance, and so A,
!! they say that (A cos(tau), A sin(tau)) lies on a line and on a circle: 0, 1 or 2 motions.
module vi_equispaced
   use vi_kinds, only: wp
   use vi_motion, only: complete_motion, motion_type, start_motion, worst_rounding
   use vi_oscillator, only: gain, oscillator_type
   use vi_pattern, only: new_pattern, pattern_type
   use vi_periodic, only: assemble, linear_system_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: solve_equispaced

contains

   !> Both equispaced motions at a frequency ratio and a clearance, without verdicts.
   !!
   !! A motion that does not exist has the status `stat%no_motion`. Where the two coincide, the
   !! second
   !! one does not exist.
   pure subroutine solve_equispaced(osc, r, clearance, cycles, system, motions)
      !> Its two coefficients of restitution are equal.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio, and clearance d K/F0.
      real(wp), intent(in) :: r, clearance
      !> Load cycles k in a period, odd.
      integer, intent(in) :: cycles
      !> Scratch, kept between calls.
      type(linear_system_type), intent(inout) :: system
      type(motion_type), intent(inout) :: motions(2)
      type(pattern_type) :: pattern
      real(wp) :: phases(2), line(2), noise, amplitude, distance, half_chord, foot(2), along(2)
      real(wp) :: x_row(2), x, point(2)
      integer :: i, row

      pattern = new_pattern('RL', cycles)
      phases = [0.0_wp, cycles*acos(-1.0_wp)]
      do i = 1, 2
         call start_motion(motions(i), osc, r, pattern, osc%restitution, phases)
         motions(i)%status = stat%no_motion
      end do
      call assemble(motions(1), system)
      associate (w => system%matrix(1, :), v => system%matrix(3, :), rhs => system%rhs*clearance)
         ! with x_2 = -x_1 both rows have one coefficient of x_1; eliminating x_1 leaves the line
         x_row = [w(1) - w(2), v(1) - v(2)]
         line = x_row(2)*w(3:4) - x_row(1)*v(3:4)
         amplitude = gain(osc%xi, r)
         ! the coefficients are sums of terms of about 1 and r; at a resonance without damping the
         ! terms cancel, and the line is what is left of their rounding
         noise = epsilon(1.0_wp)*((1 + sum(abs(w)))*norm2([x_row(2), v(3:4)]) &
            + (r + sum(abs(v)))*norm2([x_row(1), w(3:4)]))
         if (.not. norm2(line)*worst_rounding > noise) then
            motions%status = merge(stat%lost_digits, stat%singular, norm2(line) > 100*noise)
            return
         end if
         distance = (x_row(2)*rhs(1) - x_row(1)*rhs(3))/norm2(line)
         line = line/norm2(line)
         if (abs(distance) > amplitude) return
         half_chord = sqrt((amplitude - abs(distance))*(amplitude + abs(distance)))
         foot = distance*line
         along = [-line(2), line(1)]
         row = merge(1, 2, abs(x_row(1)) >= abs(x_row(2)))
         do i = 1, 2
            if (i == 2 .and. .not. half_chord > 0) exit
            point = foot + merge(half_chord, -half_chord, i == 1)*along
            if (row == 1) then
               x = (rhs(1) - dot_product(w(3:4), point))/x_row(1)
            else
               x = (rhs(3) - dot_product(v(3:4), point))/x_row(2)
            end if
            motions(i)%status = stat%ok
            motions(i)%residual = 0
            call complete_motion(motions(i), [x, -x], point(1), point(2), clearance)
         end do
      end associate
   end subroutine solve_equispaced

end module vi_equispaced
