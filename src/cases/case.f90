!> A case: the input of one computation, from the groups of a namelist.
module vi_case
   use vi_key, only: a_word, key_type, of_names, of_oscillator, of_structure, place_of
   use vi_kinds, only: wp
   use vi_namelist, only: group_type
   use vi_oscillator, only: at_resonance, oscillator_type
   use vi_text, only: append, letter_length, line_type
   use vi_units, only: are_units, dimensionless, forces, in_units, lengths, make_plain, shown_in, &
      shown_type, times, undecided, units_type, units_type_of
   use vi_values, only: read_values, values_type
   use vi_version, only: version
   implicit none (type, external)
   private

   public :: check_output, check_system, echo, name_part, outputs_of, read_system, shown_of

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
      !> The group that requests the result, and the name of its study.
      type(values_type) :: study, output
      !> The &sweep after it, which makes a campaign of the case; without a name if there is none.
      type(values_type) :: sweep
      character(:), allocatable :: study_name
      !> The group that the study starts from, such as the &motion of a &branch.
      type(values_type) :: start
   end type case_type

   type(key_type), parameter, public :: system_keys(*) = [ &
      key_type('xi', low=0.0_wp, high=1.0_wp, below=.true., or='damping', &
      meaning='damping ratio C/(2 sqrt(K M))'), &
      key_type('mu', low=0.0_wp, high=1.0e6_wp, or='free_mass', unit='M', &
      meaning='mass ratio m/M'), &
      key_type('restitution', most=2, low=0.0_wp, high=1.0_wp, &
      takes='one number for both walls or two (right, left), each with 0 <= R <= 1', &
      meaning='coefficient of restitution of both walls, or of the right and the left one'), &
      key_type('r', low=1.0e-6_wp, high=1.0e6_wp, may_miss=.true., unit='omega', &
      meaning='frequency ratio Omega/omega, unless the study has its own frequency ratios'), &
      key_type('mass', low=0.0_wp, above=.true., may_miss=.true., only='stiffness', &
      unit=of_names, &
      meaning='primary mass M, for results in physical units'), &
      key_type('stiffness', low=0.0_wp, above=.true., may_miss=.true., only='mass', &
      unit=of_names, &
      meaning='stiffness K, for physical units'), &
      key_type('damping', low=0.0_wp, may_miss=.true., only='mass', unit=of_names, &
      meaning='damping coefficient C, in place of xi'), &
      key_type('free_mass', low=0.0_wp, may_miss=.true., only='mass', unit=of_names, &
      meaning='free mass m, in place of mu'), &
      key_type('force', low=0.0_wp, above=.true., may_miss=.true., only='mass', &
      unit=of_names, &
      meaning='load amplitude F0, for physical units'), &
      key_type('units', a_word, may_miss=.true., only='mass', never='unit_names', &
      takes='units of length, force and time, as ''mm N s'', of '//lengths//', '//forces// &
      ' and '//times//', ''SI'', or ''dimensionless''', &
      meaning='units of plain numbers: clearance = 4 is 4 mm with ''mm N s'', 4 F0/K &
      &with ''dimensionless''; a plain frequency is the ratio r'), &
      key_type('unit_names', a_word, may_miss=.true., only='mass', option='-', &
      takes='units of length, force and time, as ''mm N s'', of '//lengths//', '//forces// &
      ' and '//times, &
      meaning='units of mass, stiffness and force in a result, whose other numbers are &
      &dimensionless; a &system written by hand needs units instead')]

   type(key_type), parameter, public :: output_keys(*) = [ &
      key_type('name', a_word, may_miss=.true., &
      takes='at most 100 letters, digits, _, - or . (100 bytes in UTF-8), not starting with .', &
      meaning='name of the result; by default that of the file, numbered if the file contains &
      &several cases'), &
      key_type('format', a_word, default='''csv''', words='csv table both', &
      meaning='a table for programs, a printout like Table 1 of the 1983 paper, or both'), &
      key_type('units', a_word, may_miss=.true., &
      takes='units of length, force and time, as ''mm N s'', ''SI'' or ''dimensionless''', &
      meaning='units of the table; by default those of &system, with mm for m, if it has mass, &
      &stiffness and force')]

   !> The start of the first line of a result; the end of that line shows whether the file is an
   !! input. A structure has the units of its user, and an identified rig those of SI.
   character(*), parameter, public :: first_line = '# ! vibroimpact '//version// &
      '; lengths in F0/K, time in 1/omega, angles in radians; ', &
      first_line_in_si = '# ! vibroimpact '//version//'; units of SI, angles in radians; ', &
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
   end subroutine check_system

   !> Reads &system and the units that it declares.
   pure subroutine read_system(group, system, units)
      !> The group as read from the file.
      type(group_type), intent(in) :: group
      !> Its values: xi and mu also where C and m are given, `unit_names` also where `units` is.
      type(values_type), intent(out) :: system
      !> The units of the cases that follow.
      type(units_type), intent(out) :: units
      type(key_type) :: keys(size(system_keys))
      type(values_type) :: part
      character(:), allocatable :: names
      integer :: bare

      ! the units of M, K and F0, then these: other keys may be texts with units
      keys = system_keys
      call read_part(group, keys, [character(10) :: 'units', 'unit_names'], part)
      names = 'm N s'
      bare = undecided
      if (part%has('unit_names')) then
         ! someone who writes units means them everywhere
         if (is_of_result(group)) bare = dimensionless
         call part%text('unit_names', names)
      else if (part%has('units')) then
         bare = in_units
         call part%text('units', names)
         if (names == 'dimensionless') then
            bare = dimensionless
            names = 'm N s'
         end if
      end if
      if (.not. (names == 'SI' .and. part%has('unit_names'))) call make_plain(names)
      if (.not. are_units(names)) names = 'm N s'
      call name_units(names, keys)
      call read_part(group, keys, [character(10) :: 'mass', 'stiffness', 'force'], part)
      if (part%has('mass') .and. part%has('stiffness')) units = units_type_of( &
         part%number('mass'), part%number('stiffness'), number_or_0(part, 'force'), names, bare)
      call read_values('system', keys, group, system, units)
      if (len(system%fault) > 0) return
      if (system%has('damping')) then
         call system%set('xi', [system%number('damping')/(2*sqrt(system%number('stiffness')* &
            system%number('mass')))])
         if (.not. system%number('xi') < 1) call system%refuse('damping', &
            'C/(2 sqrt(K M)) must be below 1')
         call system%drop('damping')
      end if
      if (system%has('free_mass')) then
         call system%set('mu', [system%number('free_mass')/system%number('mass')])
         if (system%number('mu') > 1.0e6_wp) call system%refuse('free_mass', &
            'm/M must be at most 1e6')
         call system%drop('free_mass')
      end if
      if (.not. system%has('mass')) return
      if (system%has('unit_names')) then
         call system%text('unit_names', names)
         if (names /= 'SI') call make_plain(names)
         if (.not. are_units(names)) call system%refuse('unit_names')
         call system%set_word('unit_names', names)
         return
      end if
      if (system%has('units')) then
         call system%text('units', names)
         if (names == 'dimensionless') names = 'SI'
         call make_plain(names)
         if (.not. are_units(names)) call system%refuse('units')
         call system%drop('units')
      end if
      ! the numbers of a result are dimensionless
      call system%set_word('unit_names', names)
   end subroutine read_system

   !> Reads some keys of a group alone; a fault in them is found again with all keys.
   pure subroutine read_part(group, keys, names, part)
      !> The group as read from the file.
      type(group_type), intent(in) :: group
      !> All its keys.
      type(key_type), intent(in) :: keys(:)
      !> Names of some of them.
      character(*), intent(in) :: names(:)
      !> Their values.
      type(values_type), intent(out) :: part
      type(group_type) :: some
      type(key_type) :: own(size(names))
      integer :: i

      some%name = group%name
      some%line = group%line
      some%items = group%items(pack([(i, i=1, size(group%items))], &
         [(any(names == group%items(i)%key), i=1, size(group%items))]))
      do i = 1, size(names)
         own(i) = keys(place_of(keys, trim(names(i))))
         own(i)%only = ''
         own(i)%never = ''
      end do
      call read_values(group%name, own, some, part)
   end subroutine read_part

   !> Whether a &system is written as in a result: numbers alone, both coefficients of restitution,
   !! and the keys in the order of `system_keys`.
   pure logical function is_of_result(group)
      !> The group as read from the file.
      type(group_type), intent(in) :: group
      integer :: i, place, last

      is_of_result = .false.
      last = 0
      do i = 1, size(group%items)
         associate (item => group%items(i))
            place = findloc(system_keys%name == item%key, .true., 1)
            if (place <= last) return
            last = place
            if (item%key == 'unit_names') cycle
            if (scan(item%value, '''"') > 0 .or. any(item%key == [character(9) :: 'damping', &
               'free_mass', 'units'])) return
            if (item%key == 'restitution' .and. scan(trim(adjustl(item%value)), ', ') == 0) return
         end associate
      end do
      is_of_result = .true.
   end function is_of_result

   !> The number of a key, 0 if it has none.
   pure real(wp) function number_or_0(values, name) result(number)
      !> The group.
      type(values_type), intent(in) :: values
      !> The key.
      character(*), intent(in) :: name

      number = 0
      if (values%has(name)) number = values%number(name)
   end function number_or_0

   !> Names the units of the keys of &system that are in `unit_names`.
   pure subroutine name_units(names, keys)
      !> Units of length, force and time.
      character(*), intent(in) :: names
      !> The keys.
      type(key_type), intent(inout) :: keys(:)
      integer :: i, second, third

      second = index(names, ' ')
      third = index(names, ' ', back=.true.)
      associate (length => names(:second - 1), force => names(second + 1:third - 1), &
         time => names(third + 1:))
         do i = 1, size(keys)
            if (keys(i)%unit /= of_names) cycle
            select case (keys(i)%name)
            case ('stiffness')
               keys(i)%unit = force//'/'//length
            case ('damping')
               keys(i)%unit = force//' '//time//'/'//length
            case ('force')
               keys(i)%unit = force
            case default
               keys(i)%unit = force//' '//time//'^2/'//length
            end select
         end do
      end associate
   end subroutine name_units

   !> Checks the name and the units of a result.
   pure subroutine check_output(output)
      !> The group.
      type(values_type), intent(inout) :: output
      character(:), allocatable :: name
      integer :: i, n

      if (len(output%fault) > 0) return
      if (output%has('units')) then
         call output%text('units', name)
         if (name /= 'SI' .and. name /= 'dimensionless') then
            call make_plain(name)
            if (.not. are_units(name)) call output%refuse('units')
            if (are_units(name)) call output%set_word('units', name)
         end if
      end if
      if (.not. output%has('name')) return
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
         if (case%study_name == 'identify') then
            call append(lines, first_line_in_si//'this file is an input too')
         else
            call append(lines, first_line//'this file is an input too')
         end if
         system = case%system
         if (case%r <= 0) call system%drop('r')
         call system%echo(lines)
      end if
      if (allocated(case%start%name)) call case%start%echo(lines)
      call case%study%echo(lines)
      if (allocated(case%sweep%name)) call case%sweep%echo(lines)
      call case%output%echo(lines)
   end subroutine echo

   !> The units in which the numbers of a result are shown.
   pure type(shown_type) function shown_of(case) result(shown)
      !> The case.
      type(case_type), intent(in) :: case
      character(:), allocatable :: own, wanted
      real(wp) :: scales(3)

      if (case%study_name == 'identify') return
      if (case%model == of_structure) then
         if (.not. case%system%has('scales')) return
         scales = case%system%numbers('scales')
      else
         if (.not. case%system%has('force')) return
         scales = [case%system%number('mass'), case%system%number('stiffness'), &
            case%system%number('force')]
      end if
      own = 'm N s'
      wanted = ''
      if (case%system%has('unit_names')) call case%system%text('unit_names', own)
      if (case%output%has('units')) call case%output%text('units', wanted)
      shown = shown_in(scales(1), scales(2), scales(3), own, wanted)
   end function shown_of

   !> The names of the outputs of a structure.
   pure function outputs_of(case) result(names)
      !> The case.
      type(case_type), intent(in) :: case
      type(line_type), allocatable :: names(:)
      integer :: i

      allocate (names(case%system%count_words('outputs')))
      do i = 1, size(names)
         names(i)%text = trim(case%system%word('outputs', i))
      end do
   end function outputs_of

end module vi_case
