!> The keys of the namelist groups: what each takes, and reading them one at a time.
module vi_keys
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_kinds, only: wp
   use vi_namelist, only: group_type
   use vi_text, only: whole
   implicit none (type, external)
   private

   public :: blank, complain, given, read_group

   !> Impacts that a list of the namelist has room for.
   integer, parameter, public :: most_impacts = 1000

   !> The variables of the three namelist groups, as read.
   type, public :: raw_type
      real(wp) :: xi, mu, restitution(2), r, clearance, acceptance
      real(wp), dimension(most_impacts) :: phases, phases_over_pi, impact_restitution
      character(most_impacts + 1) :: sides
      character(20) :: kind, precision, format
      character(101) :: name
      integer :: cycles
      !> &simulate: load cycles kept and discarded, load amplitude, initial state, limit of events.
      real(wp) :: duration, discard, load, t, x, x_dot, z, z_dot
      integer :: max_events
   end type raw_type

contains

   !> Nothing given yet.
   subroutine blank(raw)
      type(raw_type), intent(inout) :: raw
      real(wp) :: nan

      nan = ieee_value(1.0_wp, ieee_quiet_nan)
      raw%xi = nan
      raw%mu = nan
      raw%restitution = nan
      raw%r = nan
      call blank_motion(raw)
   end subroutine blank

   subroutine blank_motion(raw)
      type(raw_type), intent(inout) :: raw
      real(wp) :: nan

      nan = ieee_value(1.0_wp, ieee_quiet_nan)
      raw%phases = nan
      raw%phases_over_pi = nan
      raw%impact_restitution = nan
      raw%clearance = nan
      raw%acceptance = 0.03_wp
      raw%sides = ''
      raw%kind = 'periodic'
      raw%precision = 'double'
      raw%cycles = 1
      raw%name = ''
      raw%format = 'csv'
      raw%duration = nan
      raw%discard = 0
      raw%load = 1
      raw%t = 0
      raw%x = 0
      raw%x_dot = 0
      raw%z = 0
      raw%z_dot = 0
      raw%max_events = 10000000
   end subroutine blank_motion

   !> What a key of a group takes; empty if the group has no such key.
   pure function wanted(group, key) result(text)
      character(*), intent(in) :: group, key
      character(:), allocatable :: text

      text = ''
      select case (group//' '//key)
      case ('system xi')
         text = 'a number with 0 <= xi < 1'
      case ('system mu')
         text = 'a number with 0 <= mu <= 1e6'
      case ('system restitution')
         text = 'one number for both walls or two (right, left), each with 0 <= R <= 1'
      case ('system r')
         text = 'a number with 1e-6 <= r <= 1e6'
      case ('motion kind')
         text = '''periodic'' (phases given) or ''equispaced'' (clearance given)'
      case ('motion sides')
         text = 'letters R and L, one an impact, 2 to 1000 of them, each wall at least once'
      case ('motion cycles')
         text = 'a whole number with 1 <= cycles <= 10000'
      case ('motion phases')
         text = 'one number an impact, increasing from 0 to below 2 pi cycles'
      case ('motion phases_over_pi')
         text = 'one number an impact, increasing from 0 to below 2 cycles'
      case ('motion impact_restitution')
         text = 'one number an impact, each with 0 <= R <= 1'
      case ('motion clearance')
         text = 'a number with 1e-12 <= clearance <= 1e12'
      case ('motion precision')
         text = '''double'' or ''single'''
      case ('motion acceptance')
         text = 'a number with 0 <= acceptance <= 1'
      case ('simulate clearance')
         text = 'a number with 1e-12 <= clearance <= 1e12'
      case ('simulate cycles')
         text = 'a number of load cycles with 0 <= cycles <= 1e9'
      case ('simulate discard')
         text = 'a number of load cycles with 0 <= discard <= 1e9'
      case ('simulate load')
         text = 'a number with 0 <= load <= 1e12'
      case ('simulate t', 'simulate x', 'simulate x_dot', 'simulate z', 'simulate z_dot')
         text = 'a finite number'
      case ('simulate max_events')
         text = 'a whole number with 1 <= max_events <= 1000000000'
      case ('output name')
         text = 'at most 100 letters, digits, _, - or ., the first one no .'
      case ('output format')
         text = '''csv'', ''table'' or ''both'''
      end select
   end function wanted

   !> The keys of a group, for messages.
   pure function keys(group) result(text)
      character(*), intent(in) :: group
      character(:), allocatable :: text

      select case (group)
      case ('system')
         text = 'xi, mu, restitution, r'
      case ('motion')
         text = 'kind, sides, cycles, phases, phases_over_pi, impact_restitution, clearance, &
            &precision, acceptance'
      case ('simulate')
         text = 'clearance, cycles, discard, load, t, x, x_dot, z, z_dot, max_events'
      case default
         text = 'name, format'
      end select
   end function keys

   !> Reads the assignments of a group one at a time, so that a fault has a line and a key.
   subroutine read_group(group, raw, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(inout) :: raw
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: i, j, status

      if (group%name == 'motion' .or. group%name == 'simulate') call blank_motion(raw)
      if (group%name == 'system') call blank(raw)
      do i = 1, size(group%items)
         associate (item => group%items(i))
            line = item%line
            if (len(wanted(group%name, item%key)) == 0) then
               message = '&'//group%name//' '//item%key//' = '//item%value &
                  //': is not a key of &'// &
                  group%name//'; must be one of '//keys(group%name)
               return
            end if
            do j = 1, i - 1
               if (group%items(j)%target == item%target) then
                  message = '&'//group%name//' '//item%target//' = '//item%value// &
                     ': was given before, in line '//whole(group%items(j)%line)
                  return
               end if
            end do
            status = 1
            if (len(item%value) > 0) call read_value('&'//group%name//' '//item%target//' = '// &
               item%value//' /', group%name, raw, status)
            if (status /= 0) then
               call complain(group, item%key, line, message)
               return
            end if
         end associate
      end do
      line = group%line
   end subroutine read_group

   !> One assignment through the compiler's namelist input.
   subroutine read_value(text, group, raw, status)
      character(*), intent(in) :: text, group
      type(raw_type), intent(inout) :: raw
      integer, intent(out) :: status

      select case (group)
      case ('system')
         call read_system(text, raw, status)
      case ('motion')
         call read_motion(text, raw, status)
      case ('simulate')
         call read_simulate(text, raw, status)
      case default
         call read_output(text, raw, status)
      end select
   end subroutine read_value

   subroutine read_system(text, raw, status)
      character(*), intent(in) :: text
      type(raw_type), intent(inout) :: raw
      integer, intent(out) :: status
      real(wp) :: xi, mu, restitution(2), r
      namelist /system/ xi, mu, restitution, r

      xi = raw%xi
      mu = raw%mu
      restitution = raw%restitution
      r = raw%r
      read (text, nml=system, iostat=status)
      raw%xi = xi
      raw%mu = mu
      raw%restitution = restitution
      raw%r = r
   end subroutine read_system

   subroutine read_motion(text, raw, status)
      character(*), intent(in) :: text
      type(raw_type), intent(inout) :: raw
      integer, intent(out) :: status
      real(wp) :: clearance, acceptance
      real(wp), dimension(most_impacts) :: phases, phases_over_pi, impact_restitution
      character(most_impacts + 1) :: sides
      character(20) :: kind, precision
      integer :: cycles
      namelist /motion/ kind, sides, cycles, phases, phases_over_pi, impact_restitution, &
         clearance, &
         precision, acceptance

      kind = raw%kind
      sides = raw%sides
      cycles = raw%cycles
      phases = raw%phases
      phases_over_pi = raw%phases_over_pi
      impact_restitution = raw%impact_restitution
      clearance = raw%clearance
      precision = raw%precision
      acceptance = raw%acceptance
      read (text, nml=motion, iostat=status)
      raw%kind = kind
      raw%sides = sides
      raw%cycles = cycles
      raw%phases = phases
      raw%phases_over_pi = phases_over_pi
      raw%impact_restitution = impact_restitution
      raw%clearance = clearance
      raw%precision = precision
      raw%acceptance = acceptance
   end subroutine read_motion

   subroutine read_simulate(text, raw, status)
      character(*), intent(in) :: text
      type(raw_type), intent(inout) :: raw
      integer, intent(out) :: status
      real(wp) :: clearance, cycles, discard, load, t, x, x_dot, z, z_dot
      integer :: max_events
      namelist /simulate/ clearance, cycles, discard, load, t, x, x_dot, z, z_dot, max_events

      clearance = raw%clearance
      cycles = raw%duration
      discard = raw%discard
      load = raw%load
      t = raw%t
      x = raw%x
      x_dot = raw%x_dot
      z = raw%z
      z_dot = raw%z_dot
      max_events = raw%max_events
      read (text, nml=simulate, iostat=status)
      raw%clearance = clearance
      raw%duration = cycles
      raw%discard = discard
      raw%load = load
      raw%t = t
      raw%x = x
      raw%x_dot = x_dot
      raw%z = z
      raw%z_dot = z_dot
      raw%max_events = max_events
   end subroutine read_simulate

   subroutine read_output(text, raw, status)
      character(*), intent(in) :: text
      type(raw_type), intent(inout) :: raw
      integer, intent(out) :: status
      character(20) :: format
      character(101) :: name
      namelist /output/ name, format

      name = raw%name
      format = raw%format
      read (text, nml=output, iostat=status)
      raw%name = name
      raw%format = format
   end subroutine read_output

   !> The message for a key that is missing or has a wrong value; `why` adds to what is allowed.
   pure subroutine complain(group, key, line, message, why)
      type(group_type), intent(in) :: group
      character(*), intent(in) :: key
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      character(*), intent(in), optional :: why
      integer :: i

      message = '&'//group%name//' '//key//': is missing; must be '//wanted(group%name, key)
      do i = 1, size(group%items)
         if (group%items(i)%key == key) then
            line = group%items(i)%line
            message = '&'//group%name//' '//key//' = '//group%items(i)%value//': must be '// &
               wanted(group%name, key)
         end if
      end do
      if (present(why)) message = message//'; '//why
   end subroutine complain

   pure logical function given(group, key)
      type(group_type), intent(in) :: group
      character(*), intent(in) :: key
      integer :: i

      given = .false.
      do i = 1, size(group%items)
         given = given .or. group%items(i)%key == key
      end do
   end function given

end module vi_keys
