!> The cases of a namelist file, checked.
!!
!! Each group but `&system` and `&output` makes a case. It uses the `&system` before it, and the
!! `&output` that follows it, if one does. A `&branch` starts from the
!! `&motion` before it; a `&motion` with a `&branch` right behind it is this start and nothing else.
!! The ranges are those of the Python package.
module vi_case
   use vi_case_atlas, only: take_atlas
   use vi_case_attractor, only: take_bifurcation, take_lyapunov
   use vi_case_basins, only: take_basins
   use vi_case_branch, only: take_branch, take_start
   use vi_case_chart, only: take_chart
   use vi_case_motion, only: take_motion
   use vi_case_response, only: take_response
   use vi_case_simulation, only: take_simulation
   use vi_case_type, only: case_type
   use vi_case_zone, only: take_zone
   use vi_keys, only: complain, forbid, given, group_list, has_own_r, makes_case, read_group
   use vi_kinds, only: wp
   use vi_namelist, only: group_type, scan_namelist
   use vi_oscillator, only: oscillator_type
   use vi_raw, only: blank, is_blank, raw_type
   use vi_text, only: brief, lower, whole, whole_width
   implicit none (type, external)
   private

   public :: read_cases

   !> Names of results.
   integer, parameter :: longest_name = 100
   character(*), parameter :: allowed = &
      'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.'

contains

   !> All cases of a namelist file; at the first fault `message` says file, line, key and remedy.
   subroutine read_cases(path, cases, message)
      character(*), intent(in) :: path
      type(case_type), allocatable, intent(out) :: cases(:)
      !> Empty if there is no fault.
      character(:), allocatable, intent(out) :: message
      type(group_type), allocatable :: groups(:)
      type(raw_type), allocatable :: raw
      integer :: line, i, n
      logical :: has_system

      call scan_namelist(path, groups, line, message)
      if (len(message) == 0) call check_names(groups, line, message)
      if (len(message) > 0) then
         message = place(path, line)//brief(message)
         allocate (cases(0))
         return
      end if
      allocate (cases(count([(is_case(groups(i:)), i=1, size(groups))])))
      allocate (raw)
      call blank(raw)
      n = 0
      has_system = .false.
      do i = 1, size(groups)
         line = groups(i)%line
         select case (groups(i)%name)
         case ('system')
            call take_system(groups(i:), raw, line, message)
            has_system = .true.
         case ('output')
            if (.not. ends_in_case(groups(:i - 1))) message = '&output: no '//group_list('')// &
               ' stands before it'
         case default
            if (.not. has_system) then
               message = '&'//groups(i)%name//': no &system stands before it'
            else if (is_case(groups(i:))) then
               n = n + 1
               cases(n)%osc = oscillator_type(raw%xi, raw%mu, raw%restitution)
               cases(n)%r = raw%r
               if (groups(i)%name == 'branch') call take_start(groups(:i), raw, cases(n), line, &
                  message)
               if (len(message) == 0) call take_case(path, n, groups(i:), size(cases), raw, &
                  cases(n), line, message)
            end if
         end select
         if (len(message) > 0) exit
      end do
      if (len(message) > 0) message = place(path, line)//brief(message)
   end subroutine read_cases

   !> The names of all groups come first: a wrong one changes what the other groups mean.
   pure subroutine check_names(groups, line, message)
      type(group_type), intent(in) :: groups(:)
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: i

      do i = 1, size(groups)
         associate (name => groups(i)%name)
            if (name == 'system' .or. name == 'output' .or. makes_case(name)) cycle
            line = groups(i)%line
            message = '&'//name//': is not a group; must be &system, &output, '//group_list('')
            return
         end associate
      end do
   end subroutine check_names

   !> One case from its group, and the &output group that may follow it.
   subroutine take_case(path, number, groups, total, raw, case, line, message)
      character(*), intent(in) :: path
      integer, intent(in) :: number, total
      !> The group of the case, and all after it.
      type(group_type), intent(in) :: groups(:)
      type(raw_type), intent(inout) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      type(group_type) :: output

      call read_group(groups(1), raw, line, message)
      if (len(message) > 0) return
      if (any(groups(1)%name == [character(11) :: 'lyapunov', 'bifurcation', 'response', &
         'basins'])) allocate (case%attractor, source=raw%attractor)
      if (groups(1)%name /= 'motion') case%kind = groups(1)%name
      select case (groups(1)%name)
      case ('motion')
         call take_motion(groups(1), raw, case, line, message)
      case ('simulate')
         call take_simulation(groups(1), raw, case, line, message)
      case ('branch')
         call take_branch(groups(1), raw, case, line, message)
      case ('zone')
         call take_zone(groups(1), raw, case, line, message)
      case ('atlas')
         call take_atlas(groups(1), raw, case, line, message)
      case ('lyapunov')
         call take_lyapunov(groups(1), case, line, message)
      case ('bifurcation')
         call take_bifurcation(groups(1), case, line, message)
      case ('basins')
         call take_basins(groups(1), case, line, message)
      case ('response')
         call take_response(groups(1), case, line, message)
      case default
         call take_chart(groups(1), raw, case, line, message)
      end select
      if (len(message) > 0) return
      allocate (output%items(0))
      if (size(groups) > 1) then
         if (groups(2)%name == 'output') output = groups(2)
      end if
      if (output%line > 0) then
         line = output%line
         call read_group(output, raw, line, message)
      end if
      if (len(message) == 0) call take_output(path, number, total, groups(1)%line, output, raw, &
         case, line, message)
   end subroutine take_case

   !> Reads and checks &system, which needs a case after it.
   subroutine take_system(groups, raw, line, message)
      type(group_type), intent(in) :: groups(:)
      type(raw_type), intent(inout) :: raw
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message

      if (.not. ends_in_case(groups(2:min(2, size(groups))))) message = '&system: no '// &
         group_list('branch')//' follows'
      if (len(message) == 0) call read_group(groups(1), raw, line, message)
      if (len(message) == 0) call check_system(groups(1), needs_r(groups(2:)), raw, line, message)
   end subroutine take_system

   !> Whether a case of this system has one frequency ratio, and not a window of them.
   pure logical function needs_r(rest)
      type(group_type), intent(in) :: rest(:)
      integer :: i

      needs_r = .false.
      do i = 1, size(rest)
         if (rest(i)%name == 'system') return
         needs_r = needs_r .or. (makes_case(rest(i)%name) .and. .not. has_own_r(rest(i)))
      end do
   end function needs_r

   !> Whether the last of some groups is a case.
   pure logical function ends_in_case(groups)
      type(group_type), intent(in) :: groups(:)

      ends_in_case = .false.
      if (size(groups) > 0) ends_in_case = makes_case(groups(size(groups))%name)
   end function ends_in_case

   !> Whether a group is a case: not a &motion that is but the start of a &branch.
   pure logical function is_case(groups)
      !> The group, and all after it.
      type(group_type), intent(in) :: groups(:)

      is_case = makes_case(groups(1)%name)
      if (groups(1)%name == 'motion' .and. size(groups) > 1) is_case = groups(2)%name /= 'branch'
   end function is_case

   pure function place(path, line) result(text)
      character(*), intent(in) :: path
      integer, intent(in) :: line
      character(len(path) + 2 + merge(1 + whole_width(line), 0, line > 0)) :: text

      text = path//': '
      if (line > 0) text = path//':'//whole(line)//': '
   end function place

   subroutine check_system(group, with_r, raw, line, message)
      type(group_type), intent(in) :: group
      logical, intent(in) :: with_r
      type(raw_type), intent(inout) :: raw
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message

      if (.not. (raw%xi >= 0 .and. raw%xi < 1)) then
         call complain(group, 'xi', line, message)
      else if (.not. (raw%mu >= 0 .and. raw%mu <= 1.0e6_wp)) then
         call complain(group, 'mu', line, message)
      else if (with_r) then
         call check_r(group, raw, line, message)
      else if (given(group, 'r')) then
         call forbid(group, 'r', line, message, &
            'must be left out: it is not for a &chart, &zone, &atlas or &response, which has &
            &r_min and r_max, nor for parameter = ''r''')
      end if
      if (len(message) == 0) then
         if (is_blank(raw%restitution(2))) raw%restitution(2) = raw%restitution(1)
         if (.not. all(raw%restitution >= 0 .and. raw%restitution <= 1)) then
            call complain(group, 'restitution', line, message)
         end if
      end if
   end subroutine check_system

   subroutine check_r(group, raw, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message

      if (.not. (raw%r >= 1.0e-6_wp .and. raw%r <= 1.0e6_wp)) then
         call complain(group, 'r', line, message)
      else if (raw%xi <= 0 .and. abs(raw%r - 1) <= 0) then
         call complain(group, 'r', line, message, &
            'must differ from 1 when xi = 0 (resonance without damping)')
      end if
   end subroutine check_r

   !> Name and format of the result; the name is that of the file (numbered) unless given.
   subroutine take_output(path, number, total, motion_line, group, raw, case, line, message)
      character(*), intent(in) :: path
      integer, intent(in) :: number, total, motion_line
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: i

      case%line = motion_line
      case%format = trim(lower(raw%format))
      case%name = trim(raw%name)
      if (group%line > 0 .and. given(group, 'name')) then
         do i = 1, size(group%items)
            if (group%items(i)%key == 'name') case%line = group%items(i)%line
         end do
         if (len(case%name) == 0 .or. len(case%name) > longest_name .or. &
            verify(case%name, allowed) > 0 .or. index(case%name, '.') == 1) then
            call complain(group, 'name', line, message)
            return
         end if
      else
         call find_name(path, number, total, case%name)
      end if
      if (case%format /= 'csv' .and. case%format /= 'table' .and. case%format /= 'both') then
         call complain(group, 'format', line, message)
      end if
   end subroutine take_output

   !> The name of a result from that of the file, numbered if it holds several cases.
   pure subroutine find_name(path, number, total, name)
      character(*), intent(in) :: path
      integer, intent(in) :: number, total
      character(:), allocatable, intent(out) :: name
      character(:), allocatable :: suffix
      integer :: i

      name = path(index(path, '/', back=.true.) + 1:)
      i = index(name, '.', back=.true.)
      if (i > 1) name = name(:i - 1)
      suffix = ''
      if (total > 1) suffix = '_'//whole(number)
      name = name(:min(len(name), longest_name - len(suffix)))//suffix
      do i = 1, len(name)
         if (verify(name(i:i), allowed) > 0) name(i:i) = '_'
      end do
      if (index(name, '.') == 1) name(1:1) = '_'
      if (len(name) == 0) name = 'case'
   end subroutine find_name

end module vi_case
