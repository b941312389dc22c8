!> Units of physical quantities: numbers with a unit as texts, such as '4 mm', and numbers in the
!! units of a &system, as the dimensionless numbers of a case.
module vi_units
   use vi_kinds, only: wp
   use vi_parse, only: parse_numbers
   implicit none (type, external)
   private

   public :: are_units, has_two_readings, make_plain, show_frequency, show_unit, shown_in, &
      to_own_unit, units_type_of

   !> Units of length, force and time that may be those of a &system.
   character(*), parameter, public :: lengths = 'm mm cm um km in ft mil', &
      forces = 'N mN uN kN MN lbf kgf', times = 's ms us min h'
   character(*), parameter :: known(3) = [character(24) :: lengths, forces, times]
   !> Names of all units, for messages.
   character(*), parameter :: all_names = lengths//' '//forces//' '//times// &
      ' kg g mg t lb slug rad deg rev Hz kHz mHz rpm %'
   real(wp), parameter :: pi = acos(-1.0_wp)

   !> A unit: its size in SI is `above`/`below`, so that decimal fractions are rounded once.
   type :: unit_type
      character(4) :: name
      real(wp) :: above, below
      !> Powers of length, force and time.
      integer :: powers(3)
      !> Whether it counts an angle.
      logical :: angular = .false.
   end type unit_type

   type(unit_type), parameter :: named(*) = [ &
      unit_type('m', 1.0_wp, 1.0_wp, [1, 0, 0]), unit_type('mm', 1.0_wp, 1.0e3_wp, [1, 0, 0]), &
      unit_type('cm', 1.0_wp, 1.0e2_wp, [1, 0, 0]), unit_type('um', 1.0_wp, 1.0e6_wp, [1, 0, 0]), &
      unit_type('km', 1.0e3_wp, 1.0_wp, [1, 0, 0]), &
      unit_type('in', 254.0_wp, 1.0e4_wp, [1, 0, 0]), &
      unit_type('ft', 3048.0_wp, 1.0e4_wp, [1, 0, 0]), &
      unit_type('mil', 254.0_wp, 1.0e7_wp, [1, 0, 0]), &
      unit_type('N', 1.0_wp, 1.0_wp, [0, 1, 0]), unit_type('uN', 1.0_wp, 1.0e6_wp, [0, 1, 0]), &
      unit_type('mN', 1.0_wp, 1.0e3_wp, [0, 1, 0]), unit_type('kN', 1.0e3_wp, 1.0_wp, [0, 1, 0]), &
      unit_type('MN', 1.0e6_wp, 1.0_wp, [0, 1, 0]), &
      unit_type('lbf', 44482216152605.0_wp, 1.0e13_wp, [0, 1, 0]), &
      unit_type('kgf', 980665.0_wp, 1.0e5_wp, [0, 1, 0]), &
      unit_type('s', 1.0_wp, 1.0_wp, [0, 0, 1]), unit_type('ms', 1.0_wp, 1.0e3_wp, [0, 0, 1]), &
      unit_type('us', 1.0_wp, 1.0e6_wp, [0, 0, 1]), unit_type('min', 60.0_wp, 1.0_wp, [0, 0, 1]), &
      unit_type('h', 3600.0_wp, 1.0_wp, [0, 0, 1]), unit_type('kg', 1.0_wp, 1.0_wp, [-1, 1, 2]), &
      unit_type('g', 1.0_wp, 1.0e3_wp, [-1, 1, 2]), unit_type('mg', 1.0_wp, 1.0e6_wp, [-1, 1, 2]), &
      unit_type('t', 1.0e3_wp, 1.0_wp, [-1, 1, 2]), &
      unit_type('slug', 45359237.0_wp*980665.0_wp, 1.0e13_wp*0.3048_wp, [-1, 1, 2]), &
      unit_type('lb', 45359237.0_wp, 1.0e8_wp, [-1, 1, 2]), &
      unit_type('rad', 1.0_wp, 1.0_wp, [0, 0, 0], .true.), &
      unit_type('deg', pi, 180.0_wp, [0, 0, 0], .true.), &
      unit_type('rev', 2*pi, 1.0_wp, [0, 0, 0], .true.), &
      unit_type('Hz', 2*pi, 1.0_wp, [0, 0, -1], .true.), &
      unit_type('kHz', 2*pi, 1.0e-3_wp, [0, 0, -1], .true.), &
      unit_type('mHz', 2*pi, 1.0e3_wp, [0, 0, -1], .true.), &
      unit_type('rpm', pi, 30.0_wp, [0, 0, -1], .true.), &
      unit_type('%', 1.0_wp, 1.0e2_wp, [0, 0, 0])]

   !> How a number without a unit is read: it is dimensionless, it is in the units of the &system,
   !! or it is rejected because the &system leaves both possible.
   integer, parameter, public :: dimensionless = 0, in_units = 1, undecided = 2

   !> What the dimensionless numbers of a case are in physical units.
   type, public :: units_type
      !> M, K and F0 in SI; 0 if they are not known.
      real(wp) :: mass = 0, stiffness = 0, force = 0
      !> The units of length, force and time of the &system in SI.
      real(wp) :: sizes(3) = 1
      !> One of the three above.
      integer :: bare = dimensionless
   end type units_type

   !> The units in which people read the numbers of a result.
   type, public :: shown_type
      !> Names of units of length, force and time; without them numbers stay dimensionless.
      character(4) :: names(3) = ''
      !> What dimensionless numbers are, with the sizes of these units in SI.
      type(units_type) :: units
   end type shown_type

contains

   !> The units in which the numbers of a rig are shown: those that are asked for, or its own, where
   !! mm take the place of m if F0/K is less than a decimetre.
   pure type(shown_type) function shown_in(mass, stiffness, force, own, wanted) result(shown)
      !> M, K and F0 in the units of the rig; 0 if they are not known.
      real(wp), intent(in) :: mass, stiffness, force
      !> Names of its units of length, force and time, and of those wanted: as 'mm N s', SI, or
      !! dimensionless; empty for its own.
      character(*), intent(in) :: own, wanted
      character(:), allocatable :: names
      integer :: i, last, place

      if (.not. (mass > 0 .and. stiffness > 0 .and. force > 0)) return
      if (.not. are_units(own) .or. wanted == 'dimensionless') return
      shown%units = units_type_of(mass, stiffness, force, own, in_units)
      names = own
      if (own(:2) == 'm ') then
         if (shown%units%force/shown%units%stiffness < 0.1_wp) names = 'mm'//own(2:)
      end if
      if (len_trim(wanted) > 0) names = trim(wanted)
      if (names == 'SI') names = 'm N s'
      do i = 1, 3
         last = index(names//' ', ' ')
         shown%names(i) = names(:last - 1)
         names = names(min(last, len(names)) + 1:)
         place = place_of_unit(trim(shown%names(i)))
         shown%units%sizes(i) = named(place)%above/named(place)%below
      end do
   end function shown_in

   !> The factor of dimensionless numbers that shows them in a unit, and the name of the unit.
   pure subroutine show_unit(unit, shown, scale, name)
      !> Their unit: a product of powers of F0, K and omega; any other is kept.
      character(*), intent(in) :: unit
      !> The units to show them in.
      type(shown_type), intent(in) :: shown
      !> The factor.
      real(wp), intent(out) :: scale
      !> As N, mm/s or mm/s^2.
      character(:), allocatable, intent(out) :: name
      character(:), allocatable :: why, part
      integer, parameter :: order(3) = [2, 1, 3]
      integer :: powers(3), i, sign
      logical :: angular

      scale = 1
      name = trim(unit)
      if (len_trim(shown%names(1)) == 0 .or. is_fixed(unit) .or. unit == 'mixed') return
      call scale_of(unit, shown%units, scale, powers, angular, why)
      scale = scale/in_sizes(powers, shown%units%sizes)
      name = ''
      do sign = 1, -1, -2
         do i = 1, 3
            if (sign*powers(order(i)) <= 0) cycle
            part = trim(shown%names(order(i)))
            if (abs(powers(order(i))) > 1) part = &
               part//'^'//achar(iachar('0') + abs(powers(order(i))))
            if (sign < 0) part = '/'//part
            if (sign > 0 .and. len(name) > 0) part = ' '//part
            name = name//part
         end do
         if (sign > 0 .and. len(name) == 0) name = '1'
      end do
   end subroutine show_unit

   !> The factor of frequency ratios that shows them as cycles per unit of time, and its name.
   pure subroutine show_frequency(shown, scale, name)
      !> The units to show them in.
      type(shown_type), intent(in) :: shown
      !> The factor.
      real(wp), intent(out) :: scale
      !> As Hz.
      character(:), allocatable, intent(out) :: name

      scale = sqrt(shown%units%stiffness/shown%units%mass)*shown%units%sizes(3)/(2*pi)
      select case (shown%names(3))
      case ('s')
         name = 'Hz'
      case ('ms')
         name = 'kHz'
      case ('us')
         name = 'MHz'
      case default
         name = '1/'//trim(shown%names(3))
      end select
   end subroutine show_frequency

   !> The units of a &system.
   pure type(units_type) function units_type_of(mass, stiffness, force, names, bare) result(units)
      !> M, K and F0 in the units; 0 if they are not known.
      real(wp), intent(in) :: mass, stiffness, force
      !> Names of units of length, force and time, which are known.
      character(*), intent(in) :: names
      !> How numbers without a unit are read.
      integer, intent(in) :: bare
      real(wp) :: sizes(3)
      integer :: i, first, last, place

      first = 1
      do i = 1, 3
         last = first + index(names(first:)//' ', ' ') - 2
         place = place_of_unit(names(first:last))
         sizes(i) = named(place)%above/named(place)%below
         first = last + 2
      end do
      units = units_type(mass*in_sizes([-1, 1, 2], sizes), stiffness*in_sizes([-1, 1, 0], sizes), &
         force*sizes(2), sizes, bare)
   end function units_type_of

   !> The place of a unit in the list, 0 if it is not there.
   pure integer function place_of_unit(name) result(place)
      !> Its name.
      character(*), intent(in) :: name

      do place = size(named), 1, -1
         if (named(place)%name == name) return
      end do
   end function place_of_unit

   !> The size in SI of the unit of some powers of length, force and time.
   pure real(wp) function in_sizes(powers, sizes) result(size)
      !> Powers of length, force and time.
      integer, intent(in) :: powers(3)
      !> The units of length, force and time in SI.
      real(wp), intent(in) :: sizes(3)

      size = product(sizes**powers)
   end function in_sizes

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
         if (last <= 1) return
         if (index(' '//trim(known(i))//' ', ' '//rest(:last)) == 0) return
         rest = rest(last + 1:)
      end do
      are_units = len(rest) == 0
   end function are_units

   !> Names of units in ASCII: u for micro, and m N s for SI.
   pure subroutine make_plain(names)
      !> In and out: names of units of length, force and time.
      character(:), allocatable, intent(inout) :: names
      character(:), allocatable :: plain

      call in_ascii(names, plain)
      if (plain == 'SI') plain = 'm N s'
      call move_alloc(plain, names)
   end subroutine make_plain

   !> A number with or without a unit, as a number in the unit of its key.
   pure subroutine to_own_unit(unit, units, value, why, text)
      !> The unit of the key: a product of powers of F0, K and omega or of units of SI, or empty.
      character(*), intent(in) :: unit
      !> What is known of them; without it numbers have no unit but those of SI of their key.
      type(units_type), intent(in), optional :: units
      !> In: the number, if there is no text. Out: the number in the unit of the key.
      real(wp), intent(inout) :: value
      !> Why it cannot be converted; empty if it can be.
      character(:), allocatable, intent(out) :: why
      !> The number with its unit, such as 4 mm, if it was given as a text.
      character(*), intent(in), optional :: text
      character(:), allocatable :: missing
      type(units_type) :: own
      real(wp) :: scale
      integer :: powers(3), wanted(3)
      logical :: angular, is_angle

      why = ''
      if (present(units)) own = units
      if (.not. present(text) .and. own%bare == dimensionless) return
      call scale_of(unit, own, scale, wanted, is_angle, why)
      if (.not. present(text)) then
         if (unit == 'omega' .and. seems_hertz(value, own)) then
            why = 'a number without a unit is the ratio r, but this is about the natural frequency &
               &in Hz: write a frequency with its unit, such as ''20 Hz'''
            return
         end if
         if (is_fixed(unit) .and. own%bare == in_units .and. .not. is_angle .and. len(why) == 0) &
            then
            ! such as a known mass in kg; a factor that differs from 1 by rounding alone is 1
            scale = in_sizes(wanted, own%sizes)/scale
            if (abs(scale - 1) > 1.0e-12_wp) value = value*scale
         else if (.not. has_two_readings(unit) .or. .not. abs(value) > 0) then
            why = ''
         else if (own%bare == undecided) then
            why = 'a number without a unit can be read in two ways: write it as ''4 mm'', or give &
               &units in &system (numbers are in these units, or dimensionless with units = &
               &''dimensionless'')'
         else if (len(why) == 0) then
            value = value*in_sizes(wanted, own%sizes)/scale
         end if
         return
      end if
      missing = why
      call read_quantity(text, value, powers, angular, why)
      if (len(why) > 0) return
      if (unit == 'M' .and. all(powers == 0) .and. .not. angular) return ! a share of M, in %
      if (any(powers /= wanted) .or. (angular .neqv. is_angle)) then
         why = 'its unit is not that of '//trim(kind_of(wanted, is_angle))
      else if (len(missing) > 0) then
         why = missing
      else
         value = value/scale
      end if
   end subroutine to_own_unit

   !> Whether a frequency without a unit, which is a ratio, was almost certainly meant in Hz: it is
   !! large, and about the natural frequency in Hz.
   pure logical function seems_hertz(value, units)
      !> The frequency.
      real(wp), intent(in) :: value
      !> M and K of the &system.
      type(units_type), intent(in) :: units
      real(wp) :: natural

      seems_hertz = .false.
      if (.not. (units%mass > 0 .and. units%stiffness > 0)) return
      natural = sqrt(units%stiffness/units%mass)/(2*pi)
      seems_hertz = value > 5 .and. value > natural/2 .and. value < 2*natural
   end function seems_hertz

   !> Whether a number without a unit can be dimensionless or physical. A frequency is always a
   !! ratio to omega then, and a free mass one to M.
   pure logical function has_two_readings(unit)
      !> The unit of a key.
      character(*), intent(in) :: unit

      has_two_readings = .not. is_fixed(unit) .and. unit /= 'omega' .and. unit /= 'M'
   end function has_two_readings

   !> Whether a unit does not depend on the &system.
   pure logical function is_fixed(unit)
      !> The unit of a key.
      character(*), intent(in) :: unit

      is_fixed = index(unit, 'F0') == 0 .and. index(unit, 'K') == 0 .and. &
         index(unit, 'omega') == 0 .and. unit /= 'M'
   end function is_fixed

   !> The size in SI of the unit of a key, and what it measures.
   pure subroutine scale_of(unit, units, scale, powers, angular, why)
      !> The unit of a key.
      character(*), intent(in) :: unit
      !> What is known of F0, K and omega.
      type(units_type), intent(in) :: units
      !> Its size in SI.
      real(wp), intent(out) :: scale
      !> Powers of length, force and time, and whether it counts an angle.
      integer, intent(out) :: powers(3)
      logical, intent(out) :: angular
      !> What is missing in &system.
      character(:), allocatable, intent(out) :: why
      character(:), allocatable :: factor
      integer :: first, last, sign, power

      why = ''
      scale = 1
      powers = 0
      angular = unit == 'omega'
      if (len_trim(unit) == 0) return
      if (is_fixed(unit)) then
         call read_quantity('1 '//trim(unit), scale, powers, angular, why)
         return
      end if
      sign = 1
      first = 1
      do while (first <= len_trim(unit))
         last = first + scan(unit(first:)//' ', ' /') - 2
         factor = unit(first:last)
         power = sign
         if (index(factor, '^2') > 0) power = 2*sign
         select case (factor(:max(0, scan(factor//'^', '^') - 1)))
         case ('F0')
            powers = powers + power*[0, 1, 0]
            if (units%force > 0) scale = scale*units%force**power
            if (.not. units%force > 0) why = '&system must have mass, stiffness and force'
         case ('K')
            powers = powers + power*[-1, 1, 0]
            if (units%stiffness > 0) scale = scale*units%stiffness**power
         case ('M')
            powers = powers + power*[-1, 1, 2]
            if (units%mass > 0) scale = scale*units%mass**power
         case ('omega')
            powers = powers + power*[0, 0, -1]
            if (units%mass > 0) scale = scale*sqrt(units%stiffness/units%mass)**power
         case default
            continue
         end select
         if (last < len(unit)) sign = merge(-1, sign, unit(last + 1:last + 1) == '/')
         first = last + 2
      end do
      if (.not. units%mass > 0 .and. len(why) == 0) why = '&system must have mass and stiffness'
   end subroutine scale_of

   !> A number with a unit in SI.
   pure subroutine read_quantity(text, value, powers, angular, why)
      !> Such as 19.5 Hz, 42 kN/m or 9.81 m/s^2.
      character(*), intent(in) :: text
      !> The number in SI.
      real(wp), intent(out) :: value
      !> Powers of length, force and time, and whether it counts an angle.
      integer, intent(out) :: powers(3)
      logical, intent(out) :: angular
      !> What is wrong with it; empty if nothing is.
      character(:), allocatable, intent(out) :: why
      character(:), allocatable :: plain
      real(wp), allocatable :: numbers(:)
      type(unit_type) :: one
      real(wp) :: above, below
      integer :: first, last, i, power, sign, place, mark
      logical :: good

      call in_ascii(text, plain)
      value = 0
      powers = 0
      angular = .false.
      why = 'a text must be a number with its unit, such as ''4 mm'''
      first = verify(plain//'x', '+-.0123456789eEdD')
      call parse_numbers(plain(:first - 1), .false., 1, numbers, good)
      if (.not. good) return
      plain = trim(adjustl(plain(first:)))
      if (len(plain) == 0) return
      why = ''
      above = numbers(1)
      below = 1
      sign = 1
      first = 1
      do while (first <= len(plain))
         if (plain(first:first) == '/') then
            sign = -1
            first = first + 1
            cycle
         else if (scan(plain(first:first), ' *') > 0) then
            first = first + 1
            cycle
         end if
         last = first + scan(plain(first:)//' ', ' */') - 2
         if (plain(first:last) /= '1') then
            mark = scan(plain(first:last)//'^', '^-0123456789')
            place = place_of_unit(plain(first:first + mark - 2))
            power = 1
            i = first + mark - 1
            if (i <= last) then
               if (plain(i:i) == '^') i = i + 1
               call parse_numbers(plain(i:last), .true., 1, numbers, good)
               if (good) power = nint(max(-9.0_wp, min(9.0_wp, numbers(1))))
            end if
            if (place == 0 .or. .not. good .or. sign == 0) then
               why = 'unknown unit '//plain(first:last)//'; units are made of '//all_names
               return
            end if
            power = sign*power
            one = named(place)
            if (power > 0) then
               above = above*one%above**power
               below = below*one%below**power
            else
               above = above*one%below**(-power)
               below = below*one%above**(-power)
            end if
            powers = powers + power*one%powers
            angular = angular .or. one%angular
         end if
         ! one unit after each slash
         if (sign < 0) sign = 0
         first = last + 1
      end do
      value = above/below
   end subroutine read_quantity

   !> A text of units with u for micro, ^2 for a raised 2 and blanks for points.
   pure subroutine in_ascii(text, plain)
      !> In UTF-8.
      character(*), intent(in) :: text
      !> Without them.
      character(:), allocatable, intent(out) :: plain
      character(*), parameter :: micro(2) = [char(194)//char(181), char(206)//char(188)], &
         raised = char(194)//char(178), point = char(194)//char(183)
      integer :: i

      plain = ''
      i = 1
      do while (i <= len(text))
         if (any(text(i:min(len(text), i + 1)) == micro)) then
            plain = plain//'u'
         else if (text(i:min(len(text), i + 1)) == raised) then
            plain = plain//'^2'
         else if (text(i:min(len(text), i + 1)) == point) then
            plain = plain//' '
         else
            plain = plain//text(i:i)
            i = i - 1
         end if
         i = i + 2
      end do
      plain = trim(adjustl(plain))
   end subroutine in_ascii

   !> What some powers of length, force and time measure.
   pure character(32) function kind_of(powers, angular) result(text)
      !> Powers of length, force and time, and whether an angle is counted.
      integer, intent(in) :: powers(3)
      logical, intent(in) :: angular

      text = 'this quantity'
      if (all(powers == [1, 0, 0])) text = 'a length'
      if (all(powers == [0, 1, 0])) text = 'a force'
      if (all(powers == [0, 0, 1])) text = 'a time'
      if (all(powers == [1, 0, -1])) text = 'a velocity'
      if (all(powers == [1, 0, -2])) text = 'an acceleration'
      if (all(powers == [-1, 1, 2])) text = 'a mass'
      if (all(powers == [-1, 1, 0])) text = 'a stiffness'
      if (all(powers == [-1, 1, 1])) text = 'a damping coefficient'
      if (all(powers == 0)) text = 'a number without a dimension'
      if (angular) text = 'a frequency (Hz, rpm or rad/s)'
   end function kind_of

end module vi_units
