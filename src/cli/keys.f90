!> The keys of the namelist groups: what each takes, and reading them one at a time.
module vi_keys
   use vi_keys_attractors, only: list_attractor_keys, wanted_of_attractor
   use vi_keys_studies, only: list_study_keys, wanted_of_chart, wanted_of_study
   use vi_namelist, only: group_type
   use vi_raw, only: blank, blank_motion, most_letters, raw_type, read_value
   use vi_text, only: lower, whole
   implicit none (type, external)
   private

   public :: complain, forbid, given, group_list, has_own_r, makes_case, read_group

   !> The groups that ask for a result.
   character(11), parameter :: case_groups(10) = [character(11) :: 'motion', 'simulate', 'chart', &
      'branch', 'zone', 'atlas', 'lyapunov', 'bifurcation', 'response', 'basins']

contains

   !> What a key of a group takes; empty if the group has no such key.
   pure subroutine wanted(group, key, text)
      character(*), intent(in) :: group, key
      character(:), allocatable, intent(out) :: text

      select case (group//' '//key)
      case default
         select case (group)
         case ('chart')
            call wanted_of_chart(key, text)
         case ('branch', 'zone', 'atlas')
            call wanted_of_study(group, key, text)
         case default
            call list_attractor_keys(group, text)
            if (index(', '//text//',', ', '//key//',') == 0) text = ''
            if (len(text) > 0) call wanted_of_attractor(group, key, text)
         end select
      case ('system xi')
         text = 'a number with 0 <= xi < 1'
      case ('system mu')
         text = 'a number with 0 <= mu <= 1e6'
      case ('system restitution')
         text = 'one number for both walls or two (right, left), each with 0 <= R <= 1'
      case ('system r')
         text = 'a number with 1e-6 <= r <= 1e6'
      case ('motion kind')
         text = '''periodic'' (phases given), ''equispaced'' (clearance given) or ''exact'' &
            &(clearance given, phases guessed)'
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
      case ('motion clearance', 'simulate clearance')
         text = 'a number with 1e-12 <= clearance <= 1e12'
      case ('motion precision')
         text = '''double'' or ''single'''
      case ('motion acceptance')
         text = 'a number with 0 <= acceptance <= 1'
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
   end subroutine wanted

   !> Whether a group of this name asks for a result.
   pure logical function makes_case(name)
      character(*), intent(in) :: name

      makes_case = any(name == case_groups)
   end function makes_case

   !> Whether a group has frequency ratios of its own: a window, or a parameter that is r.
   pure logical function has_own_r(group)
      type(group_type), intent(in) :: group
      integer :: i

      has_own_r = any(group%name == [character(8) :: 'chart', 'zone', 'atlas', 'response'])
      if (all(group%name /= [character(11) :: 'lyapunov', 'bifurcation'])) return
      do i = 1, size(group%items)
         associate (value => group%items(i)%value)
            if (group%items(i)%key /= 'parameter' .or. len(value) < 3) cycle
            has_own_r = lower(value(2:len(value) - 1)) == 'r'
         end associate
      end do
   end function has_own_r

   !> These groups for messages, without some: '&motion, &simulate or ...'.
   pure function group_list(without) result(text)
      character(*), intent(in) :: without
      character(len_trim(padded_list(without))) :: text

      text = padded_list(without)
   end function group_list

   !> The same with blanks behind it.
   pure function padded_list(without) result(text)
      character(*), intent(in) :: without
      character(15*size(case_groups)) :: text
      integer :: i

      text = ''
      do i = 1, size(case_groups)
         if (index(' '//without//' ', ' '//trim(case_groups(i))//' ') > 0) cycle
         if (i == size(case_groups)) then
            text = trim(text)//' or'
         else if (len_trim(text) > 0) then
            text = trim(text)//','
         end if
         text = adjustl(trim(text)//' &'//case_groups(i))
      end do
   end function padded_list

   !> The keys of a group, for messages.
   pure subroutine list_keys(group, text)
      character(*), intent(in) :: group
      character(:), allocatable, intent(out) :: text

      select case (group)
      case ('system')
         text = 'xi, mu, restitution, r'
      case ('motion')
         text = 'kind, sides, cycles, phases, phases_over_pi, impact_restitution, clearance, &
            &precision, acceptance'
      case ('simulate')
         text = 'clearance, cycles, discard, load, t, x, x_dot, z, z_dot, max_events'
      case ('chart', 'branch', 'zone', 'atlas')
         call list_study_keys(group, text)
      case ('output')
         text = 'name, format'
      case default
         call list_attractor_keys(group, text)
      end select
   end subroutine list_keys

   !> Reads the assignments of a group one at a time, so that a fault has a line and a key.
   subroutine read_group(group, raw, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(inout) :: raw
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      character(:), allocatable :: text
      integer :: i, j, status

      if (makes_case(group%name)) call blank_motion(raw, group%name)
      if (group%name == 'system') call blank(raw)
      do i = 1, size(group%items)
         associate (item => group%items(i))
            line = item%line
            call wanted(group%name, item%key, text)
            if (len(text) == 0) then
               call list_keys(group%name, text)
               message = '&'//group%name//' '//item%key//' = '//item%value &
                  //': is not a key of &'//group%name//'; must be one of '//text
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
            if (len(item%value) > 0 .and. .not. (too_long(item%value) .or. &
               has_name(item%value))) then
               call read_value('&'//group%name//' '//item%target//' = '//item%value//' /', &
                  group%name, raw, status)
            end if
            if (status /= 0) then
               call complain(group, item%key, line, message, at=i)
               return
            end if
         end associate
      end do
      line = group%line
   end subroutine read_group

   !> Whether a text in quotes would be cut off.
   pure logical function too_long(value)
      character(*), intent(in) :: value

      too_long = len(value) > most_letters + 2 .and. scan(value(1:1), '''"') == 1
   end function too_long

   !> Whether a word stands outside quotes: the compiler's reader takes the name of a variable for
   !! the next assignment, and leaves out the number.
   pure logical function has_name(value)
      character(*), intent(in) :: value
      character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyz'
      character(:), allocatable :: text
      character :: quote
      integer :: i, n

      text = ','//lower(value)//','
      has_name = .false.
      quote = ' '
      do i = 2, len(text)
         if (quote /= ' ') then
            if (text(i:i) == quote) quote = ' '
         else if (scan(text(i:i), '''"') > 0) then
            quote = text(i:i)
         else if (scan(text(i:i), letters) > 0 .and. scan(text(i - 1:i - 1), letters// &
            '0123456789_.') == 0) then
            n = verify(text(i:), letters//'0123456789_') - 1
            has_name = has_name .or. all(text(i:i + n - 1) /= [character(8) :: 'nan', 'inf', &
               'infinity'])
         end if
      end do
   end function has_name

   !> The message for a key that is missing or has a wrong value; `why` adds to what is allowed.
   pure subroutine complain(group, key, line, message, why, at)
      type(group_type), intent(in) :: group
      character(*), intent(in) :: key
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      character(*), intent(in), optional :: why
      !> Which of several assignments to the key is meant; the first unless given.
      integer, intent(in), optional :: at
      character(:), allocatable :: text
      integer :: i

      call wanted(group%name, key, text)
      message = '&'//group%name//' '//key//': is missing; must be '//text
      do i = 1, size(group%items)
         if (group%items(i)%key /= key) cycle
         if (present(at)) then
            if (i /= at) cycle
         end if
         line = group%items(i)%line
         message = '&'//group%name//' '//group%items(i)%target//' = '//group%items(i)%value// &
            ': must be '//text
         exit
      end do
      if (present(why)) message = message//'; '//why
   end subroutine complain

   !> The message for a key that does not belong here, whatever its value.
   pure subroutine forbid(group, key, line, message, why)
      type(group_type), intent(in) :: group
      character(*), intent(in) :: key, why
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: i

      do i = 1, size(group%items)
         if (group%items(i)%key /= key) cycle
         line = group%items(i)%line
         message = '&'//group%name//' '//group%items(i)%target//' = '//group%items(i)%value// &
            ': '//why
         return
      end do
   end subroutine forbid

   !> Whether a key stands in a group.
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
