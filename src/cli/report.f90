!> Results as text: a table for machines (CSV) and a printout for people.
module vi_report
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use vi_case, only: case_type, echo
   use vi_kinds, only: wp
   use vi_motion, only: motion_type, unknown, yes
   use vi_oscillator, only: lag
   use vi_pattern, only: side_letters
   use vi_simulate, only: event_type, state_time, state_type
   use vi_stability, only: leading_kind
   use vi_status, only: stat, status_text
   use vi_text, only: append, columns, exact, exact_list, line_type, shown, whole
   implicit none (type, external)
   private

   public :: csv_lines, describe_verdicts, event_lines, table_lines, verdict_word

   real(wp), parameter :: pi = acos(-1.0_wp)

contains

   !> The motions of a case as CSV: one row an impact, motion by motion.
   !!
   !! The header is the complete case as a namelist behind `#`, so that the file is an input that
   !! reproduces itself. Numbers have 17 digits.
   pure subroutine csv_lines(case, motions, lines)
      type(case_type), intent(in) :: case
      type(motion_type), intent(in) :: motions(:)
      type(line_type), allocatable, intent(out) :: lines(:)
      character(:), allocatable :: text
      integer :: i, j

      call echo(case, lines)
      if (none(motions)) call append(lines, '# ! '//status_text(motions(1)%status))
      do i = 1, size(motions)
         if (none(motions) .or. motions(i)%status == stat%ok) cycle
         call append(lines, '# ! motion '//whole(i)//': '//status_text(motions(i)%status))
      end do
      call append(lines, 'motion,impact,side,restitution,phase,X,Z,X_dot_before,X_dot_after,'// &
         'Z_dot_before,Z_dot_after,r,clearance,A,tau,residual,consistent,admissible,stable,'// &
         'x_min,x_max,attenuation,multiplier_1_re,multiplier_1_im,multiplier_2_re,'// &
         'multiplier_2_im,multiplier_3_re,multiplier_3_im,multiplier_4_re,multiplier_4_im')
      do i = 1, size(motions)
         if (motions(i)%status /= stat%ok) cycle
         do j = 1, size(motions(i)%x)
            text = whole(i)//','//whole(j)
            call add_impact(motions(i), j, text)
            call add_motion(motions(i), text)
            call append(lines, text)
         end do
      end do
   end subroutine csv_lines

   !> The events of a simulation as CSV; header as in `csv_lines`, and the final state.
   pure subroutine event_lines(case, events, state, complete, lines)
      type(case_type), intent(in) :: case
      type(event_type), intent(in) :: events(:)
      type(state_type), intent(in) :: state
      !> False if the limit of events was reached before the end.
      logical, intent(in) :: complete
      type(line_type), allocatable, intent(out) :: lines(:)
      type(line_type), allocatable :: head(:)
      character(7), parameter :: kinds(3) = [character(7) :: 'impact', 'stick', 'release']
      integer :: i, n

      call echo(case, head)
      if (.not. complete) call append(head, '# ! cut short: max_events was reached')
      call append(head, '# ! final state: t, x, x_dot, z, z_dot = '//exact_list([ &
         state_time(state%cycle, state%phase, case%r), state%x, state%x_dot, state%z, state%z_dot]))
      call append(head, 'time,kind,side,phase,x,x_dot_before,x_dot_after,z_dot_before,z_dot_after')
      n = size(head)
      allocate (lines(n + size(events)))
      lines(:n) = head
      do i = 1, size(events)
         associate (e => events(i))
            lines(n + i)%text = exact(state_time(e%cycle, e%phase, case%r))//',' &
               //trim(kinds(e%kind))// &
               ','//side_letters([e%side])//columns([e%phase, e%x, e%x_dot_before, e%x_dot_after, &
               e%z_dot_before, e%z_dot_after])
         end associate
      end do
   end subroutine event_lines

   !> Whether no motion of a case could be computed; the reason is that of the first then.
   pure logical function none(motions)
      type(motion_type), intent(in) :: motions(:)

      none = all(motions%status /= stat%ok)
   end function none

   !> Adds the columns of one impact.
   pure subroutine add_impact(motion, j, text)
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: j
      character(:), allocatable, intent(inout) :: text

      text = text//','//side_letters(motion%pattern%sides(j:j))//columns([motion%restitution(j), &
         motion%phases(j), motion%x(j), motion%z(j), motion%x_dot_before(j), &
         motion%x_dot_after(j), &
         motion%z_dot_before(j), motion%z_dot_after(j)])
   end subroutine add_impact

   !> Adds the columns that all impacts of a motion share.
   pure subroutine add_motion(motion, text)
      type(motion_type), intent(in) :: motion
      character(:), allocatable, intent(inout) :: text
      integer :: i

      text = text//columns([motion%r, motion%clearance, motion%amplitude, motion%tau, &
         motion%residual])
      text = text//','//verdict_word(motion%consistent)//','//verdict_word(motion%admissible) &
         //','// &
         verdict_word(motion%stable)
      text = text//columns([motion%x_min, motion%x_max, attenuation(motion)])
      do i = 1, 4
         if (ieee_is_nan(motion%multipliers(i)%re)) then
            text = text//',nan,nan'
         else
            text = text//columns([motion%multipliers(i)%re, motion%multipliers(i)%im])
         end if
      end do
   end subroutine add_motion

   !> A verdict as true, false or unknown.
   pure function verdict_word(verdict) result(word)
      integer, intent(in) :: verdict
      character(merge(7, merge(4, 5, verdict == yes), verdict == unknown)) :: word

      word = merge('unknown', merge('true   ', 'false  ', verdict == yes), verdict == unknown)
   end function verdict_word

   pure real(wp) function attenuation(motion)
      type(motion_type), intent(in) :: motion

      attenuation = max(-motion%x_min, motion%x_max)/motion%amplitude
   end function attenuation

   !> The verdicts of a motion in words.
   pure subroutine describe_verdicts(motion, text)
      type(motion_type), intent(in) :: motion
      character(:), allocatable, intent(out) :: text

      text = said(motion%consistent, 'consistent')//', '//said(motion%admissible, 'admissible') &
         //', '//trim(merge('stable?  ', merge('stable   ', 'unstable ', motion%stable == yes), &
         motion%stable == unknown))
      if (ieee_is_nan(motion%multipliers(1)%re)) then
         text = text//' (no multipliers)'
      else
         text = text//' (max|lambda| = '//shown(abs(motion%multipliers(1)), 'g0.4')// &
            ', '//trim(leading_kind(motion%multipliers))//')'
      end if
   end subroutine describe_verdicts

   pure function said(verdict, word) result(text)
      integer, intent(in) :: verdict
      character(*), intent(in) :: word
      character(len(word) + merge(0, merge(1, 4, verdict == unknown), verdict == yes)) :: text

      text = word
      if (verdict == unknown) text = word//'?'
      if (verdict /= unknown .and. verdict /= yes) text = 'not '//word
   end function said

   !> The motions of a case as a printout with the rows of Table 1 of the 1983 paper.
   pure subroutine table_lines(case, motions, lines)
      type(case_type), intent(in) :: case
      type(motion_type), intent(in) :: motions(:)
      type(line_type), allocatable, intent(out) :: lines(:)
      integer :: i

      call append(lines, case%name)
      call append(lines, '')
      call append(lines, 'Parameters of primary and secondary system')
      call append(lines, '  xi = '//shown(case%osc%xi, 'g0.6')//', r = '//shown(case%r, 'g0.6')// &
         ', mu = '//shown(case%osc%mu, 'g0.6')//', R1 = '//shown(case%osc%restitution(1), &
         'g0.6')// &
         ', R2 = '//shown(case%osc%restitution(2), 'g0.6'))
      call append(lines, '  lengths in F0/K, velocities in omega F0/K')
      do i = 1, size(motions)
         call append(lines, '')
         if (motions(i)%status == stat%ok) then
            call table_of(motions(i), lines)
         else
            call append(lines, status_text(motions(i)%status))
            if (none(motions)) exit
         end if
      end do
   end subroutine table_lines

   pure subroutine table_of(motion, lines)
      type(motion_type), intent(in) :: motion
      type(line_type), allocatable, intent(inout) :: lines(:)
      character(:), allocatable :: text

      call append(lines, whole(size(motion%x))//' impacts in '//whole(motion%pattern%cycles) &
         //' cycle(s), sides '// &
         side_letters(motion%pattern%sides))
      call append(lines, row('alpha_i/pi', motion%phases/pi, 'f12.4'))
      call append(lines, row('Omega t_1/pi', [wrapped(motion%tau + lag(motion%osc%xi, &
         motion%r))/pi], 'f12.4'))
      call append(lines, row('tau/pi', [motion%tau/pi], 'f12.4'))
      call append(lines, row('d/(F0/K)', [motion%clearance], 'f12.4'))
      call append(lines, row('X_i', motion%x, 'f12.4'))
      call append(lines, row('Z_i', motion%z, 'f12.4'))
      call append(lines, row('X''_ia', motion%x_dot_after, 'f12.4'))
      call append(lines, row('X''_ib', motion%x_dot_before, 'f12.4'))
      call append(lines, row('Z''_ia', motion%z_dot_after, 'f12.4'))
      call append(lines, row('X_max', [motion%x_min, motion%x_max], 'f12.4'))
      call append(lines, row('X_max/A', [attenuation(motion)], 'f12.4'))
      call append(lines, row('|eigenvalues|', abs(motion%multipliers), 'f12.4'))
      call append(lines, row('residual', [motion%residual], 'es12.2'))
      call describe_verdicts(motion, text)
      call append(lines, text)
   end subroutine table_of

   !> A row of the printout: its name, then its numbers.
   pure function row(name, values, format) result(text)
      character(*), intent(in) :: name, format
      real(wp), intent(in) :: values(:)
      character(16 + 12*size(values)) :: text
      integer :: i

      text = name
      do i = 1, size(values)
         write (text(12*i + 5:12*i + 16), '('//format//')') values(i)
      end do
   end function row

   !> An angle in (-pi, pi].
   pure real(wp) function wrapped(angle)
      real(wp), intent(in) :: angle

      wrapped = atan2(sin(angle), cos(angle))
   end function wrapped

end module vi_report
