!> The symmetric pair: two equally spaced impacts in k load cycles (k odd), equal restitution.
!!
!! The phases 0, k pi leave the equations (26), (30) with rank 3: any amplitude A is possible. With
!! x_2 = -x_1 they reduce to two equations in x_1, A cos(tau), A sin(tau). For a given clearance,
!! and hence A, these mean that (A cos(tau), A sin(tau)) lies on a line and on a circle: 0, 1 or 2
!! motions.
module vi_equispaced
   use vi_kinds, only: pi, wp
   use vi_motion, only: audited, complete_motion, motion_type, start_motion, worst_rounding
   use vi_oscillator, only: gain, oscillator_type
   use vi_pattern, only: new_pattern, pattern_type
   use vi_periodic, only: assemble, linear_system_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: new_line, solve_equispaced, symmetric_pair

   !> The line, for clearance 1: all data that depend on the frequency ratio alone.
   type, public :: line_type
      !> Unit normal of the line in the plane (A cos(tau), A sin(tau)), its distance from the origin
      !! over the clearance, and the radius A of the circle.
      real(wp) :: normal(2) = 0, distance = 0, amplitude = 0
      !> x_1 = x_forced . (A cos(tau), A sin(tau)) + x_walls * clearance
      real(wp) :: x_forced(2) = 0, x_walls = 0
      !> Relative error of the normal that rounding causes.
      real(wp) :: rounding = 0
      !> `stat%ok`; `stat%singular` at and `stat%lost_digits` near a resonance without damping.
      integer :: status = stat%ok
   end type line_type

contains

   !> Both equispaced motions at a frequency ratio and a clearance, without verdicts.
   !!
   !! A motion that does not exist has the status `stat%no_motion`. Where the two coincide, the
   !! second one does not exist.
   pure subroutine solve_equispaced(osc, r, clearance, cycles, system, motions)
      !> Oscillator; its two coefficients of restitution are equal.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio, and clearance d K/F0.
      real(wp), intent(in) :: r, clearance
      !> Load cycles k in a period, odd.
      integer, intent(in) :: cycles
      !> Scratch, kept between calls.
      type(linear_system_type), intent(inout) :: system
      !> Out: both motions, or their status; their arrays are reused between calls.
      type(motion_type), intent(inout) :: motions(2)
      type(line_type) :: line
      type(pattern_type) :: pattern
      real(wp) :: phases(2), x(2), forced(2, 2)
      integer :: i, status(2)

      pattern = new_pattern('RL', cycles)
      phases = [0.0_wp, cycles*pi]
      do i = 1, 2
         call start_motion(motions(i), osc, r, pattern, osc%restitution, phases)
      end do
      call new_line(motions(1), system, line)
      call symmetric_pair(line, clearance, x, forced, status)
      do i = 1, 2
         motions(i)%status = status(i)
         if (status(i) /= stat%ok) cycle
         motions(i)%residual = 0
         if (audited) motions(i)%rounding = line%rounding
         call complete_motion(motions(i), [x(i), -x(i)], forced(1, i), forced(2, i), clearance)
         motions(i)%clearance = clearance           ! exactly as given, without rounding errors
      end do
   end subroutine solve_equispaced

   !> The line of a frequency ratio. With x_2 = -x_1 both rows of a flight have one coefficient of
   !! x_1; eliminating x_1 leaves the line.
   pure subroutine new_line(motion, system, line)
      !> An equispaced motion of which only the given data are set.
      type(motion_type), intent(in) :: motion
      !> Scratch; out: the equations of this motion for d = 1.
      type(linear_system_type), intent(inout) :: system
      !> The line, or its status.
      type(line_type), intent(out) :: line
      real(wp) :: x_row(2), normal(2), length, noise

      call assemble(motion, system)
      associate (w => system%matrix(1, :), v => system%matrix(3, :), rhs => system%rhs)
         x_row = [w(1) - w(2), v(1) - v(2)]
         normal = x_row(2)*w(3:4) - x_row(1)*v(3:4)
         length = norm2(normal)
         line%amplitude = gain(motion%osc%xi, motion%r)
         ! the coefficients are sums of terms of about 1 and r; at a resonance without damping the
         ! terms cancel, and the line consists of their rounding errors only
         noise = epsilon(1.0_wp)*((1 + sum(abs(w)))*norm2([x_row(2), v(3:4)]) &
            + (motion%r + sum(abs(v)))*norm2([x_row(1), w(3:4)]))
         if (.not. line%amplitude <= huge(1.0_wp)) line%status = stat%singular
         if (.not. length*worst_rounding > noise) line%status = merge(stat%lost_digits, &
            stat%singular, length > 100*noise)
         if (line%status /= stat%ok) return
         line%rounding = noise/length
         line%normal = normal/length
         line%distance = (x_row(2)*rhs(1) - x_row(1)*rhs(3))/length
         if (abs(x_row(1)) >= abs(x_row(2))) then
            line%x_forced = -w(3:4)/x_row(1)
            line%x_walls = rhs(1)/x_row(1)
         else
            line%x_forced = -v(3:4)/x_row(2)
            line%x_walls = rhs(3)/x_row(2)
         end if
      end associate
   end subroutine new_line

   !> x_1 and (A cos(tau), A sin(tau)) of both motions: tau is that of the normal plus and minus
   !! arccos(distance/A).
   pure subroutine symmetric_pair(line, clearance, x, forced, status)
      !> The line of this frequency ratio.
      type(line_type), intent(in) :: line
      !> Clearance D = d K/F0.
      real(wp), intent(in) :: clearance
      !> x(i): x_1 of motion i (F0/K); forced(:, i): A cos(tau), A sin(tau) of motion i; 0 where it
      !! does not exist.
      real(wp), intent(out) :: x(2), forced(2, 2)
      !> `stat%ok`, `stat%no_motion` or `stat%singular`.
      integer, intent(out) :: status(2)
      real(wp) :: distance, half_chord
      integer :: i

      x = 0
      forced = 0
      status = merge(stat%no_motion, line%status, line%status == stat%ok)
      distance = line%distance*clearance
      if (line%status /= stat%ok .or. .not. abs(distance) <= line%amplitude) return
      half_chord = sqrt((line%amplitude - abs(distance))*(line%amplitude + abs(distance)))
      do i = 1, merge(2, 1, half_chord > 0)
         forced(:, i) = distance*line%normal + merge(half_chord, -half_chord, i == 1) &
            *[-line%normal(2), line%normal(1)]
         x(i) = dot_product(line%x_forced, forced(:, i)) + line%x_walls*clearance
         status(i) = stat%ok
      end do
   end subroutine symmetric_pair

end module vi_equispaced
