!> A case: the input of one computation, from the groups of a namelist.
module vi_case
   use vi_key, only: a_word, key_type, of_oscillator, of_structure
   use vi_kinds, only: wp
   use vi_oscillator, only: at_resonance, oscillator_type
   use vi_text, only: append, letter_length, line_type
   use vi_values, only: values_type
   use vi_version, only: version
   implicit none (type, external)
   private

   public :: check_output, check_system, echo, name_part

   !> A case with the values of its groups, defaults included.
   type, public :: case_type
      !> Name of the result, and the place where it was given, for messages.
      character(:), allocatable :: name
      integer :: line = 0
      !> The model of its system, and the group &system or &structure.
      integer :: model = of_oscillator
      type(values_type) :: system
      !> The oscillator; its frequency ratio is 0 if the study has its own.
      type(oscillator_type) :: osc
      real(wp) :: r = 0
      !> Of a structure: its number of coordinates, and the groups that belong to it, its gaps and
      !! then its load, if it has one.
      integer :: coordinates = 0
      type(values_type), allocatable :: parts(:)
      !> The group that asks for the result, and the name of its study.
      type(values_type) :: study, output
      !> The &sweep after it, which makes a campaign of the case; without a name if there is none.
      type(values_type) :: sweep
      character(:), allocatable :: study_name
      !> The group that the study starts from, such as the &motion of a &branch.
      type(values_type) :: start
   end type case_type

   !> Units of length, force and time.
   character(*), parameter :: lengths = 'm mm cm um km in ft', forces = 'N mN kN MN lbf kgf', &
      times = 's ms us min h'
   character(*), parameter :: known(3) = [character(24) :: lengths, forces, times]

   type(key_type), parameter, public :: system_keys(*) = [ &
      key_type('xi', low=0.0_wp, high=1.0_wp, below=.true., &
      meaning='damping ratio C/(2 sqrt(K M))'), &
      key_type('mu', low=0.0_wp, high=1.0e6_wp, meaning='mass ratio m/M'), &
      key_type('restitution', most=2, low=0.0_wp, high=1.0_wp, &
      takes='one number for both walls or two (right, left), each with 0 <= R <= 1', &
      meaning='coefficient of restitution of both walls, or of the right and the left one'), &
      key_type('r', low=1.0e-6_wp, high=1.0e6_wp, may_miss=.true., &
      meaning='frequency ratio Omega/omega, unless the study has its own frequency ratios'), &
      key_type('mass', low=0.0_wp, above=.true., may_miss=.true., only='stiffness', &
      option='-', unit='unit_names', &
      meaning='primary mass M, by which a result is known in physical units, too'), &
      key_type('stiffness', low=0.0_wp, above=.true., may_miss=.true., only='mass', option='-', &
      unit='unit_names', &
      meaning='stiffness K, for physical units'), &
      key_type('force', low=0.0_wp, above=.true., may_miss=.true., only='mass', option='-', &
      unit='unit_names', &
      meaning='load amplitude F0, for physical units'), &
      key_type('unit_names', a_word, may_miss=.true., only='mass', option='-', &
      takes='units of length, force and time, as ''mm N s'', of '//lengths//', '//forces// &
      ' and '//times, &
      meaning='units of mass, stiffness and force; ''m N s'' if it is not given')]

   type(key_type), parameter, public :: output_keys(*) = [ &
      key_type('name', a_word, may_miss=.true., &
      takes='at most 100 letters, digits, _, - or . (100 bytes in UTF-8), the first one no .', &
      meaning='name of the result; else that of the file, numbered if it holds several cases'), &
      key_type('format', a_word, default='''csv''', words='csv table both', &
      meaning='a table for programs, a printout like Table 1 of the 1983 paper, or both')]

   !> The start of the first line of a result; the end of that line tells whether the file is an
   !! input. A structure has the units of its user.
   character(*), parameter, public :: first_line = '# ! vibroimpact '//version// &
      '; lengths in F0/K, time in 1/omega, angles in radians; ', &
      first_line_of_structure = '# ! vibroimpact '//version//'; units as in the case; '
   !> Largest number of bytes of the name of a result.
   integer, parameter, public :: longest_name = 100
   character(*), parameter :: name_letters = &
      'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.'

contains

   !> Checks conditions on &system that depend on several keys, or on the studies that follow.
   pure subroutine check_system(system, needs_r, why)
      !> The group.
      type(values_type), intent(inout) :: system
      !> Whether a study that follows has no frequency ratio of its own.
      logical, intent(in) :: needs_r
      !> Why no study needs one, for the message.
      character(*), intent(in) :: why
      character(:), allocatable :: units

      if (len(system%fault) > 0) return
      if (needs_r .and. .not. system%has('r')) then
         call system%refuse('r')
      else if (.not. needs_r) then
         call system%forbid('r', ': '//why)
      else if (at_resonance(system%number('xi'), system%number('r'))) then
         call system%refuse('r', 'must differ from 1 when xi = 0 (resonance without damping)')
      end if
      if (size(system%numbers('restitution')) == 1) call system%set('restitution', &
         spread(system%number('restitution'), 1, 2))
      if (.not. system%has('unit_names')) return
      call system%text('unit_names', units)
      if (.not. are_units(units)) call system%refuse('unit_names')
   end subroutine check_system

   !> Whether a text names a unit of length, one of force and one of time.
   pure logical function are_units(text)
      !> The text.
      character(*), intent(in) :: text
      character(:), allocatable :: rest
      integer :: i, last

      rest = text//' '
      are_units = .false.
      do i = 1, 3
         last = index(rest, ' ')
         if (last == 1) return
         if (index(' '//trim(known(i))//' ', ' '//rest(:last)) == 0) return
         rest = rest(last + 1:)
      end do
      are_units = len(rest) == 0
   end function are_units

   !> Checks the name of a result.
   pure subroutine check_output(output)
      !> The group.
      type(values_type), intent(inout) :: output
      character(:), allocatable :: name
      integer :: i, n

      if (len(output%fault) > 0 .or. .not. output%has('name')) return
      call output%text('name', name)
      n = 0
      i = 1
      do while (i <= len(name))
         n = name_part(name(i:))
         if (n == 0) exit
         i = i + n
      end do
      if (n == 0 .or. len(name) > longest_name .or. name(:1) == '.') call output%refuse('name')
   end subroutine check_output

   !> Number of bytes of the first character of a text, if the name of a result may hold it, else 0.
   !! It may hold those of `name_letters` and all UTF-8 characters beyond ASCII except blanks,
   !! direction marks and other punctuation in U+2000 to U+206F.
   pure integer function name_part(text) result(n)
      !> At least one byte.
      character(*), intent(in) :: text
      character(*), parameter :: no_break_space = char(194)//char(160), &
         ideographic_space = char(227)//char(128)//char(128), &
         byte_order_mark = char(239)//char(187)//char(191)

      n = 1
      if (scan(text(1:1), name_letters) > 0) return
      n = letter_length(text(:min(4, len(text))))
      if (n == 1) n = 0                                 ! other ASCII characters, and Latin-1
      if (text(:n) == no_break_space .or. text(:n) == ideographic_space) n = 0
      if (text(:n) == byte_order_mark) n = 0
      if (n /= 3) return
      if (text(:2) == char(226)//char(128)) n = 0
      if (text(:2) == char(226)//char(129) .and. iachar(text(3:3)) <= 175) n = 0
   end function name_part

   !> The complete case as a namelist, each line after `#`.
   pure subroutine echo(case, lines)
      !> The case.
      type(case_type), intent(in) :: case
      !> The header of its result.
      type(line_type), allocatable, intent(out) :: lines(:)
      type(values_type) :: system
      integer :: i

      if (case%model == of_structure) then
         call append(lines, first_line_of_structure//'this file is an input too')
         call case%system%echo(lines)
         do i = 1, size(case%parts)
            call case%parts(i)%echo(lines)
         end do
      else
         call append(lines, first_line//'this file is an input too')
         system = case%system
         if (case%r <= 0) call system%drop('r')
         call system%echo(lines)
      end if
      if (allocated(case%start%name)) call case%start%echo(lines)
      call case%study%echo(lines)
      if (allocated(case%sweep%name)) call case%sweep%echo(lines)
      call case%output%echo(lines)
   end subroutine echo

end module vi_case
