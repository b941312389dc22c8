!> The motions of a case as a printout with the rows of Table 1 of the 1983 paper.
module vi_printout
   use vi_kinds, only: pi, wp
   use vi_oscillator, only: lag
   use vi_result, only: filled_type, result_type
   use vi_status, only: stat, status_text
   use vi_text, only: append, counted, line_type, shown
   implicit none (type, external)
   private

   public :: print_motions

contains

   !> All motions, one below the other.
   pure subroutine print_motions(name, result, lines)
      !> Name of the case.
      character(*), intent(in) :: name
      !> Result of a &motion.
      type(result_type), intent(in) :: result
      !> The printout.
      type(line_type), allocatable, intent(out) :: lines(:)
      character(2), parameter :: shared(5) = [character(2) :: 'xi', 'r', 'mu', 'R1', 'R2']
      integer, allocatable :: status(:)
      real(wp), allocatable :: values(:)
      character(:), allocatable :: text
      integer :: i, found

      call append(lines, name)
      call append(lines, '')
      call append(lines, 'Parameters of primary and secondary system')
      text = ''
      do i = 1, size(shared)
         call result%get_reals('motions', trim(shared(i)), values)
         text = text//', '//trim(shared(i))//' = '//shown(values(1), 'g0.6')
      end do
      call append(lines, '  '//text(3:))
      call append(lines, '  lengths in F0/K, velocities in omega F0/K')
      call result%get_wholes('motions', 'status', status)
      found = 0
      do i = 1, size(status)
         call append(lines, '')
         if (status(i) == stat%ok) then
            found = found + 1
            call print_motion(result, i, result%notes(found)%text, lines)
         else
            call append(lines, status_text(status(i)))
            if (all(status /= stat%ok)) exit
         end if
      end do
   end subroutine print_motions

   !> One motion.
   pure subroutine print_motion(result, i, verdicts, lines)
      !> Result of a &motion.
      type(result_type), intent(in) :: result
      !> Number of the motion.
      integer, intent(in) :: i
      !> Its verdicts in words.
      character(*), intent(in) :: verdicts
      !> The printout so far.
      type(line_type), allocatable, intent(inout) :: lines(:)
      real(wp), allocatable :: multipliers(:)
      real(wp) :: tau
      integer :: impacts

      tau = one('tau')
      impacts = size(each('X'))
      associate (sides => result%columns(result%place('motions', 'sides')), &
         cycles => result%columns(result%place('motions', 'cycles')))
         call append(lines, counted(impacts, 'impact')//' in '//counted(cycles%k(i), 'cycle')// &
            ', sides '//sides%words(sides%k(i))%text)
      end associate
      call append(lines, row('alpha_i/pi', each('phase')/pi, 'f12.4'))
      call append(lines, row('Omega t_1/pi', [wrapped(tau + lag(one('xi'), one('r')))/pi], 'f12.4'))
      call append(lines, row('tau/pi', [tau/pi], 'f12.4'))
      call append(lines, row('d/(F0/K)', [one('clearance')], 'f12.4'))
      call append(lines, row('X_i', each('X'), 'f12.4'))
      call append(lines, row('Z_i', each('Z'), 'f12.4'))
      call append(lines, row('X''_ia', each('X_dot_after'), 'f12.4'))
      call append(lines, row('X''_ib', each('X_dot_before'), 'f12.4'))
      call append(lines, row('Z''_ia', each('Z_dot_after'), 'f12.4'))
      call append(lines, row('X_max', [one('x_min'), one('x_max')], 'f12.4'))
      call append(lines, row('X_max/A', [one('attenuation')], 'f12.4'))
      call result%get_reals('motions', 'multipliers', multipliers)
      call append(lines, row('|eigenvalues|', hypot(multipliers(8*i - 7:8*i:2), &
         multipliers(8*i - 6:8*i:2)), 'f12.4'))
      call append(lines, row('residual', [one('residual')], 'es12.2'))
      call append(lines, verdicts)

   contains

      !> A number of the motion.
      pure real(wp) function one(name)
         !> Name of the column.
         character(*), intent(in) :: name

         associate (column => result%columns(result%place('motions', name)))
            one = column%x(i)
         end associate
      end function one

      !> The numbers of its impacts.
      pure function each(name) result(values)
         !> Name of the column.
         character(*), intent(in) :: name
         real(wp), allocatable :: values(:)
         type(filled_type) :: column

         column = result%columns(result%place('impacts', name))
         values = pack(column%x, result%tables(column%table)%owners == i)
      end function each

   end subroutine print_motion

   !> A row of the printout: its name, then its numbers.
   pure function row(name, values, format) result(text)
      !> Name of the row, and the edit descriptor of a number, 12 characters wide.
      character(*), intent(in) :: name, format
      !> Number of the state or task, and of the draw.
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
      !> An angle (rad).
      real(wp), intent(in) :: angle

      wrapped = atan2(sin(angle), cos(angle))
   end function wrapped

end module vi_printout
