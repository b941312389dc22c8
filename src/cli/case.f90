!> A case: everything that one computation of the batch program needs, checked.
!!
!! Each `&motion` makes a case. It uses the `&system` before it, and the `&output` that follows
!! it, if
!! one does. The ranges are those of the Python package.
module vi_case
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
   use vi_keys, only: blank, complain, given, most_impacts, raw_type, read_group
   use vi_kinds, only: wp
   use vi_namelist, only: group_type, scan_namelist
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: default_restitution, new_pattern, pattern_type
   use vi_text, only: line_type, lower, shown, split, whole
   implicit none (type, external)
   private

   public :: read_cases

   type, public :: case_type
      character(:), allocatable :: name
      type(oscillator_type) :: osc
      real(wp) :: r = 0
      !> 'periodic' (phases given), 'equispaced' (clearance given) or 'simulate'
      character(:), allocatable :: kind
      type(pattern_type) :: pattern
      real(wp), allocatable :: phases(:), restitution(:)
      logical :: own_restitution = .false.
      real(wp) :: clearance = 0, acceptance = 0
      logical :: single = .false.
      !> 'csv', 'table' or 'both'
      character(:), allocatable :: format
      !> Of a simulation: load cycles kept and discarded, load amplitude, t, x, x', z, z' at the
      !! start.
      real(wp) :: duration = 0, discard = 0, load = 1, start(5) = 0
      integer :: max_events = 0
      !> Where the name was given, for messages.
      integer :: line = 0
   end type case_type

   integer, parameter :: most_cycles = 10000
   real(wp), parameter :: two_pi = 2*acos(-1.0_wp)

contains

   !> All cases of a namelist file; at the first fault `message` says file, line, key and remedy.
   subroutine read_cases(path, cases, message)
      character(*), intent(in) :: path
      type(case_type), allocatable, intent(out) :: cases(:)
      !> Empty if there is no fault.
      character(:), allocatable, intent(out) :: message
      type(group_type), allocatable :: groups(:)
      type(group_type) :: output
      type(raw_type), allocatable :: raw
      integer :: line, i, n, system

      call scan_namelist(path, groups, line, message)
      allocate (cases(0))
      if (len(message) > 0) then
         message = place(path, line)//message
         return
      end if
      allocate (raw)
      allocate (output%items(0))
      deallocate (cases)
      allocate (cases(count([(makes_case(groups(i)%name), i=1, size(groups))])))
      n = 0
      system = 0
      call blank(raw)
      do i = 1, size(groups)
         line = groups(i)%line
         select case (groups(i)%name)
         case ('system')
            if (.not. motion_follows(groups(i &
               + 1:))) message = '&system: no &motion or &simulate follows'
            if (len(message) == 0) call read_group(groups(i), raw, line, message)
            if (len(message) == 0) call check_system(groups(i), raw, line, message)
            system = i
         case ('motion', 'simulate')
            if (system == 0) message = '&'//groups(i)%name//': no &system stands before it'
            if (len(message) == 0) call read_group(groups(i), raw, line, message)
            if (len(message) == 0) then
               n = n + 1
               if (groups(i)%name == 'motion') then
                  call take_motion(groups(i), raw, cases(n), line, message)
               else
                  call take_simulation(groups(i), raw, cases(n), line, message)
               end if
            end if
            if (len(message) == 0 .and. i < size(groups)) then
               if (groups(i + 1)%name == 'output') output = groups(i + 1)
            end if
            if (len(message) == 0) then
               line = groups(i)%line
               if (output%line > 0) line = output%line
               if (output%line > 0) call read_group(output, raw, line, message)
            end if
            if (len(message) == 0) call take_output(path, n, size(cases), groups(i)%line, output, &
               raw, &
               cases(n), line, message)
            output%line = 0
         case ('output')
            if (i == 1) then
               message = '&output: no &motion or &simulate stands before it'
            else if (.not. makes_case(groups(i - 1)%name)) then
               message = '&output: no &motion or &simulate stands before it'
            end if
         case default
            message = '&'//groups(i)%name &
               //': is not a group; must be &system, &motion, &simulate or &output'
         end select
         if (len(message) > 0) then
            message = place(path, line)//message
            return
         end if
      end do
   end subroutine read_cases

   !> Whether each group of this name is a case.
   pure logical function makes_case(name)
      character(*), intent(in) :: name

      makes_case = name == 'motion' .or. name == 'simulate'
   end function makes_case

   !> Whether the next group is &motion, or one whose name is wrong anyway.
   pure logical function motion_follows(rest)
      type(group_type), intent(in) :: rest(:)

      motion_follows = .false.
      if (size(rest) > 0) motion_follows = rest(1)%name /= 'system' .and. rest(1)%name /= 'output'
   end function motion_follows

   pure function place(path, line) result(text)
      character(*), intent(in) :: path
      integer, intent(in) :: line
      character(:), allocatable :: text

      text = path//': '
      if (line > 0) text = path//':'//whole(line)//': '
   end function place

   subroutine check_system(group, raw, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(inout) :: raw
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message

      if (.not. (raw%xi >= 0 .and. raw%xi < 1)) then
         call complain(group, 'xi', line, message)
      else if (.not. (raw%mu >= 0 .and. raw%mu <= 1.0e6_wp)) then
         call complain(group, 'mu', line, message)
      else if (.not. (raw%r >= 1.0e-6_wp .and. raw%r <= 1.0e6_wp)) then
         call complain(group, 'r', line, message)
      else if (raw%xi <= 0 .and. abs(raw%r - 1) <= 0) then
         call complain(group, 'r', line, message, &
            'must differ from 1 when xi = 0 (resonance without damping)')
      else
         if (ieee_is_nan(raw%restitution(2)) .and. single_number(group)) &
            raw%restitution(2) = raw%restitution(1)
         if (.not. all(raw%restitution >= 0 .and. raw%restitution <= 1)) &
            call complain(group, 'restitution', line, message)
      end if
   end subroutine check_system

   !> Whether `restitution` is given as one number, not as two of which one is not a number.
   pure logical function single_number(group)
      type(group_type), intent(in) :: group
      integer :: i

      single_number = .false.
      do i = 1, size(group%items)
         if (group%items(i)%target == 'restitution') single_number = &
            scan(group%items(i)%value, ',;* ') == 0
      end do
   end function single_number

   !> Checks the variables of &motion and puts them into a case.
   subroutine take_motion(group, raw, case, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message

      case%osc = oscillator_type(raw%xi, raw%mu, raw%restitution)
      case%r = raw%r
      case%kind = trim(lower(raw%kind))
      case%single = lower(raw%precision) == 'single'
      case%acceptance = raw%acceptance
      case%clearance = raw%clearance
      if (case%kind /= 'periodic' .and. case%kind /= 'equispaced') then
         call complain(group, 'kind', line, message)
      else if (.not. (case%single .or. lower(raw%precision) == 'double')) then
         call complain(group, 'precision', line, message)
      else if (.not. (raw%acceptance >= 0 .and. raw%acceptance <= 1)) then
         call complain(group, 'acceptance', line, message)
      else if (raw%cycles < 1 .or. raw%cycles > most_cycles) then
         call complain(group, 'cycles', line, message)
      else if (case%kind == 'equispaced') then
         call take_equispaced(group, raw, case, line, message)
      else
         call take_periodic(group, raw, case, line, message)
      end if
   end subroutine take_motion

   !> Checks the variables of &simulate and puts them into a case.
   subroutine take_simulation(group, raw, case, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      character(5), parameter :: names(5) = [character(5) :: 't', 'x', 'x_dot', 'z', 'z_dot']
      integer :: i

      case%osc = oscillator_type(raw%xi, raw%mu, raw%restitution)
      case%r = raw%r
      case%kind = 'simulate'
      case%clearance = raw%clearance
      case%duration = raw%duration
      case%discard = raw%discard
      case%load = raw%load
      case%start = [raw%t, raw%x, raw%x_dot, raw%z, raw%z_dot]
      case%max_events = raw%max_events
      if (.not. (raw%clearance >= 1.0e-12_wp .and. raw%clearance <= 1.0e12_wp)) then
         call complain(group, 'clearance', line, message)
      else if (.not. (raw%duration >= 0 .and. raw%duration <= 1.0e9_wp)) then
         call complain(group, 'cycles', line, message)
      else if (.not. (raw%discard >= 0 .and. raw%discard <= 1.0e9_wp)) then
         call complain(group, 'discard', line, message)
      else if (.not. (raw%load >= 0 .and. raw%load <= 1.0e12_wp)) then
         call complain(group, 'load', line, message)
      else if (raw%max_events < 1 .or. raw%max_events > 1000000000) then
         call complain(group, 'max_events', line, message)
      else
         do i = 1, 5
            if (ieee_is_finite(case%start(i))) cycle
            call complain(group, trim(names(i)), line, message)
            return
         end do
         if (abs(raw%z - raw%x) > 0.5_wp*raw%clearance*(1 + 1.0e-9_wp)) call complain(group, 'z', &
            line, &
            message, 'z - x must be within half the clearance')
      end if
   end subroutine take_simulation

   subroutine take_equispaced(group, raw, case, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      character(18), parameter :: foreign(4) = [character(18) :: 'sides', 'phases', &
         'phases_over_pi', &
         'impact_restitution']
      integer :: i

      do i = 1, size(foreign)
         if (.not. given(group, trim(foreign(i)))) cycle
         call complain(group, trim(foreign(i)), line, message, &
            'and is not for kind = ''equispaced'', which knows sides and phases')
         return
      end do
      case%pattern = new_pattern('RL', raw%cycles)
      case%phases = [0.0_wp, raw%cycles*acos(-1.0_wp)]
      case%restitution = case%osc%restitution
      if (.not. (raw%clearance >= 1.0e-12_wp .and. raw%clearance <= 1.0e12_wp)) then
         call complain(group, 'clearance', line, message)
      else if (modulo(raw%cycles, 2) == 0) then
         call complain(group, 'cycles', line, message, 'and must be odd for kind = ''equispaced''')
      else if (abs(case%osc%restitution(1) - case%osc%restitution(2)) > 0) then
         call complain(group, 'kind', line, message, &
            '''equispaced'' needs equal restitution on both walls')
      end if
   end subroutine take_equispaced

   subroutine take_periodic(group, raw, case, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: n

      n = len_trim(raw%sides)
      case%pattern = new_pattern(trim(raw%sides), raw%cycles)
      if (n < 2 .or. n > most_impacts .or. any(case%pattern%sides == 0) .or. &
         abs(sum(case%pattern%sides)) == n) then
         call complain(group, 'sides', line, message)
         return
      end if
      if (given(group, 'clearance')) then
         call complain(group, 'clearance', line, message, &
            'and is not for kind = ''periodic'', which finds the clearance')
         return
      end if
      if (given(group, 'phases') .eqv. given(group, 'phases_over_pi')) then
         call complain(group, 'phases', line, message, 'give either phases or phases_over_pi')
         return
      end if
      if (given(group, 'phases')) then
         call take_phases(group, 'phases', raw%phases, 1.0_wp, case, line, message)
      else
         call take_phases(group, 'phases_over_pi', raw%phases_over_pi, acos(-1.0_wp), case, line, &
            message)
      end if
      if (len(message) > 0) return
      case%own_restitution = given(group, 'impact_restitution')
      if (case%own_restitution) then
         case%restitution = raw%impact_restitution(:n)
         if (length_of(raw%impact_restitution) /= n .or. &
            .not. all(case%restitution >= 0 .and. case%restitution <= 1)) then
            call complain(group, 'impact_restitution', line, message, whole(n) &
               //' impacts are in sides')
         end if
      else
         case%restitution = default_restitution(case%pattern%sides, case%osc%restitution(1), &
            case%osc%restitution(2))
      end if
   end subroutine take_periodic

   !> Phases in the given unit into the case, sorted and within the period.
   subroutine take_phases(group, key, values, unit, case, line, message)
      type(group_type), intent(in) :: group
      character(*), intent(in) :: key
      real(wp), intent(in) :: values(:), unit
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: n, i

      n = size(case%pattern%sides)
      if (length_of(values) /= n) then
         call complain(group, key, line, message, whole(length_of(values))//' numbers for ' &
            //whole(n)// &
            ' impacts in sides')
         return
      end if
      case%phases = values(:n)*unit
      if (.not. all(ieee_is_finite(case%phases))) then
         call complain(group, key, line, message, 'each must be finite')
      else if (abs(case%phases(1)) > 0) then
         call complain(group, key, line, message, 'the first must be 0, it sets the origin')
      else if (.not. case%phases(n) < two_pi*case%pattern%cycles) then
         call complain(group, key, line, message, 'the last must be below '// &
            shown(two_pi*case%pattern%cycles/unit, 'g0.6'))
      else
         do i = 2, n
            if (case%phases(i) > case%phases(i - 1)) cycle
            call complain(group, key, line, message, 'number '//whole(i) &
               //' is not above number '// &
               whole(i - 1))
            return
         end do
      end if
   end subroutine take_phases

   !> Numbers given in a list that was all NaN before.
   pure integer function length_of(values)
      real(wp), intent(in) :: values(:)

      do length_of = size(values), 1, -1
         if (.not. ieee_is_nan(values(length_of))) return
      end do
      length_of = 0
   end function length_of

   !> Name and format of the result; the name is that of the file (numbered) unless given.
   subroutine take_output(path, number, total, motion_line, group, raw, case, line, message)
      character(*), intent(in) :: path
      integer, intent(in) :: number, total, motion_line
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      character(*), parameter :: allowed = &
         'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.'
      type(line_type), allocatable :: parts(:)
      integer :: i

      case%line = motion_line
      case%format = trim(lower(raw%format))
      case%name = trim(raw%name)
      if (group%line > 0 .and. given(group, 'name')) then
         do i = 1, size(group%items)
            if (group%items(i)%key == 'name') case%line = group%items(i)%line
         end do
         if (len(case%name) == 0 .or. len(case%name) > 100 .or. verify(case%name, allowed) > 0 &
            .or. &
            index(case%name, '.') == 1) then
            call complain(group, 'name', line, message)
            return
         end if
      else
         parts = split(path, '/')
         case%name = parts(size(parts))%text
         i = index(case%name, '.', back=.true.)
         if (i > 1) case%name = case%name(:i - 1)
         do i = 1, len(case%name)
            if (verify(case%name(i:i), allowed) > 0) case%name(i:i) = '_'
         end do
         if (total > 1) case%name = case%name//'_'//whole(number)
      end if
      if (case%format /= 'csv' .and. case%format /= 'table' .and. case%format /= 'both') &
         call complain(group, 'format', line, message)
   end subroutine take_output

end module vi_case
