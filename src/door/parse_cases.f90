!> The cases of a namelist, checked.
!!
!! Each group that names a study makes a case. It uses the `&system` before it, or the `&structure`
!! with its gaps and its load, and the `&output` after it, if there is one. A study can start from a
!! group before it, as a `&branch` does from a `&motion`; a group directly before that study is only
!! its start and not a case of its own.
module vi_parse_cases
   use vi_case, only: case_type, check_output, check_system, longest_name, name_part, &
      output_keys, read_system, system_keys
   use vi_common_keys, only: most_numbers
   use vi_key, only: is_for, key_type, of_axes, of_axis, of_oscillator, of_parameter, of_state, &
      of_structure, of_target, place_of
   use vi_kinds, only: wp
   use vi_namelist, only: group_type, scan_namelist
   use vi_oscillator, only: oscillator_type
   use vi_parse, only: parse_subscript, repeats
   use vi_processor, only: has_memory
   use vi_status, only: stat, status_text
   use vi_structure_groups, only: element_besides_gaps, has_moving_wall, most_coordinates, &
      read_parts, read_structure
   use vi_sweep, only: sweep_keys
   use vi_study, only: join_groups, place_of_study, study_type
   use vi_study_list, only: list_studies
   use vi_text, only: brief, lower, printable, whole, whole_width
   use vi_units, only: dimensionless, has_two_readings, units_type
   use vi_values, only: read_values, values_type
   implicit none (type, external)
   private

   public :: find_name, parse_cases

   !> Bytes that reading takes for each byte of a namelist, and for each number of a list that
   !! repeats and subscripts make longer than its text, at most; from `large` on it is checked that
   !! they are available.
   real(wp), parameter :: reading_bytes = 24, number_bytes = 32, large = 2.0e6_wp

   !> The longest list that a key may have.
   integer, parameter :: longest_list = 5*most_numbers

   !> The groups that are not studies.
   character(9), parameter :: other_groups(*) = [character(9) :: 'system', 'structure', 'gap', &
      'stop', 'friction', 'load', 'sweep', 'output']

   !> The system of the cases that follow.
   type :: system_type
      !> &system or &structure; without a name before the first of them.
      type(values_type) :: values
      integer :: model = of_oscillator
      !> Of a &system: its units; of a structure not allocated, since it has those of its user.
      type(units_type), allocatable :: units
      !> Of a structure: its number of coordinates, gaps and load.
      integer :: coordinates = 0
      type(values_type), allocatable :: parts(:)
   end type system_type

contains

   !> Checks that there is memory to read a namelist.
   subroutine check_memory(bytes, message)
      !> Bytes that it takes.
      real(wp), intent(in) :: bytes
      !> Set if there is not.
      character(:), allocatable, intent(inout) :: message

      if (bytes < large) return
      if (.not. has_memory(bytes)) message = status_text(stat%no_memory)// &
         ': reading takes up to '//whole(int(bytes/1.0e6_wp))//' MB'
   end subroutine check_memory

   !> Bytes for lists that repeats and subscripts make long.
   pure real(wp) function list_bytes(groups) result(bytes)
      !> The groups.
      type(group_type), intent(in) :: groups(:)
      integer :: first, last, reached, i, j
      logical :: good

      bytes = 0
      do i = 1, size(groups)
         reached = 0                             ! by the subscripts of a key
         do j = 1, size(groups(i)%items)
            associate (item => groups(i)%items(j))
               if (j > 1) then
                  if (item%key /= groups(i)%items(j - 1)%key) reached = 0
               end if
               call parse_subscript(item%target(len(item%key) + 1:), longest_list, first, last, &
                  good)
               first = max(reached, merge(first, 0, good))
               bytes = bytes + number_bytes*min(first - reached + repeats(item%value), &
                  real(longest_list, wp))
               reached = first
            end associate
         end do
      end do
   end function list_bytes

   !> All cases of a namelist; `message` names file, line, key and remedy of the first fault.
   subroutine parse_cases(text, path, cases, message, fault_line)
      !> The namelist, its lines separated by line feeds.
      character(*), intent(in) :: text
      !> The file of the namelist; empty if there is none.
      character(*), intent(in) :: path
      !> Its cases, in order.
      type(case_type), allocatable, intent(out) :: cases(:)
      !> Empty if there is no fault.
      character(:), allocatable, intent(out) :: message
      !> Line of the fault; 0 if there is none, or if it has no line.
      integer, intent(out), optional :: fault_line
      type(group_type), allocatable :: groups(:)
      type(study_type), allocatable :: studies(:)
      type(system_type) :: system
      character(:), allocatable :: names
      integer, allocatable :: models(:)
      integer :: line, i, n, n_before

      allocate (cases(0))
      line = 0
      message = ''
      call check_memory(reading_bytes*len(text), message)
      call list_studies(studies)
      if (len(message) == 0) call scan_namelist(text, groups, line, message)
      if (len(message) == 0) call check_memory(reading_bytes*len(text) + list_bytes(groups), &
         message)
      if (len(message) == 0) call check_names(studies, groups, line, message)
      if (len(message) == 0) then
         deallocate (cases)
         allocate (models, source=models_of(groups))
         allocate (cases(count([(is_case(studies, groups(i:), models(i)), i=1, size(groups))])))
         n = 0
         do i = 1, size(groups)
            line = groups(i)%line
            select case (groups(i)%name)
            case ('system')
               call take_system(studies, groups(i:), system, line, message)
            case ('structure')
               call take_structure(studies, path, groups(i:), system, line, message)
            case ('gap', 'stop', 'friction', 'load')
               call check_place(groups(:i), message)
            case ('sweep', 'output')
               n_before = i - 1
               if (groups(i)%name == 'output' .and. n_before > 0) n_before = n_before - &
                  merge(1, 0, groups(n_before)%name == 'sweep')
               if (.not. ends_in_case(studies, groups(:n_before))) then
                  call join_groups(studies%name, names)
                  message = '&'//groups(i)%name//': no '//names//' precedes it'
                  if (n_before > 0 .and. groups(i)%name == 'sweep') then
                     if (any(groups(n_before)%name == [character(6) :: 'sweep', 'output'])) then
                        message = '&sweep: follows &'//groups(n_before)%name// &
                           '; must occur once, directly after the group of a study'
                     end if
                  end if
               end if
            case default
               if (.not. allocated(system%values%name)) then
                  message = '&'//groups(i)%name//': no &system precedes it'
                  if (place_of_study(studies, groups(i)%name, of_structure) > 0) message = &
                     '&'//groups(i)%name//': no &system or &structure precedes it'
               else if (place_of_study(studies, groups(i)%name, system%model) == 0) then
                  call join_groups(pack(studies%name, is_for(studies%models, system%model)), names)
                  message = '&'//groups(i)%name//': is not a study of a &'// &
                     system%values%name//'; must be '//names
               else if (is_case(studies, groups(i:), system%model)) then
                  n = n + 1
                  call take_case(studies, path, groups, i, system, cases(n), line, message)
                  n_before = i
                  if (len(message) == 0) call take_sweep(studies, groups, n_before, system, &
                     cases(n), line, message)
                  if (len(message) == 0) call take_output(path, groups(n_before:), n, &
                     size(cases), cases(n), line, message)
               end if
            end select
            if (len(message) > 0) exit
         end do
      end if
      if (present(fault_line)) fault_line = merge(line, 0, len(message) > 0)
      if (len(message) == 0) return
      message = brief(printable(message))
      if (len(path) > 0) message = place(path, line)//message
   end subroutine parse_cases

   !> Checks the names of all groups first, because a wrong name changes the meaning of other
   !! groups.
   pure subroutine check_names(studies, groups, line, message)
      !> All studies.
      type(study_type), intent(in) :: studies(:)
      !> All groups of the file.
      type(group_type), intent(in) :: groups(:)
      !> Out: line of the fault; not changed if there is none.
      integer, intent(inout) :: line
      !> Out: the fault.
      character(:), allocatable, intent(inout) :: message
      character(:), allocatable :: names
      integer :: i

      do i = 1, size(groups)
         associate (name => groups(i)%name)
            if (any(other_groups == name) .or. any(studies%name == name)) cycle
            line = groups(i)%line
            call join_groups(studies%name, names)
            message = '&'//name//': is not a group; must be &system, &output, '//names// &
               ', or &structure, &gap, &stop, &friction, &load'
            return
         end associate
      end do
   end subroutine check_names

   !> Reads and checks &system, which must be followed by a case.
   pure subroutine take_system(studies, groups, system, line, message)
      !> All studies.
      type(study_type), intent(in) :: studies(:)
      !> The group, and all after it.
      type(group_type), intent(in) :: groups(:)
      !> The system.
      type(system_type), intent(out) :: system
      !> Out: line of the fault; not changed if there is none.
      integer, intent(inout) :: line
      !> Out: the fault; empty if there is none.
      character(:), allocatable, intent(inout) :: message
      character(:), allocatable :: names
      logical :: needed

      if (.not. ends_in_case(studies, groups(2:min(2, size(groups))))) then
         call join_groups(pack(studies%name, studies%starts_from(of_oscillator) == '' .and. &
            is_for(studies%models, of_oscillator)), names)
         message = '&system: no '//names//' follows'
         if (size(groups) == 1) return
         if (all(other_groups(3:6) /= groups(2)%name)) return
         line = groups(2)%line
         message = '&'//groups(2)%name//': must follow a &structure, not a &system'
         return
      end if
      allocate (system%units)
      associate (values => system%values)
         call read_system(groups(1), values, system%units)
         needed = needs_r(studies, groups(2:))
         names = ''
         if (.not. needed .and. values%has('r')) call explain_own_r(studies, names)
         call check_system(values, needed, names)
         call pass_on(values, line, message)
      end associate
   end subroutine take_system

   !> Reads and checks &structure with its gaps and its load, which must be followed by a case.
   subroutine take_structure(studies, path, groups, system, line, message)
      !> All studies.
      type(study_type), intent(in) :: studies(:)
      !> The file; empty if there is none.
      character(*), intent(in) :: path
      !> The group, and all after it.
      type(group_type), intent(in) :: groups(:)
      !> The structure.
      type(system_type), intent(out) :: system
      !> Out: line of the fault; not changed if there is none.
      integer, intent(inout) :: line
      !> Out: the fault; empty if there is none.
      character(:), allocatable, intent(inout) :: message
      character(:), allocatable :: names
      integer :: i, gaps, loads, n

      gaps = 0
      loads = 0
      do n = 1, size(groups) - 1
         select case (groups(n + 1)%name)
         case ('gap', 'stop', 'friction')
            gaps = gaps + 1
         case ('load')
            loads = loads + 1
         case default
            exit
         end select
         if (gaps <= most_coordinates .and. loads <= 1) cycle
         line = groups(n + 1)%line
         message = '&load: is the second of this &structure; must be the only one'
         if (loads <= 1) message = '&'//groups(n + 1)%name//': is number '//whole(gaps)// &
            ' of this &structure; must be at most '//whole(most_coordinates)
         return
      end do
      system%model = of_structure
      if (gaps == 0) then
         message = '&structure: no &gap, &stop or &friction follows'
      else if (.not. ends_in_case(studies, groups(n + 1:min(n + 1, size(groups))))) then
         call join_groups(pack(studies%name, studies%starts_from(of_structure) == '' .and. &
            is_for(studies%models, of_structure)), names)
         message = '&structure: no '//names//' follows its gaps and its load'
      end if
      if (len(message) > 0) return
      call read_structure(path, groups(1), system%values)
      if (len(system%values%fault) == 0) call read_parts(path, groups(2:n), system%values, &
         system%parts, system%coordinates)
      call pass_on(system%values, line, message)
      if (.not. allocated(system%parts)) return
      do i = 1, size(system%parts)
         if (len(message) == 0) call pass_on(system%parts(i), line, message)
      end do
   end subroutine take_structure

   !> Checks that a &gap or &load directly follows its &structure.
   pure subroutine check_place(groups, message)
      !> The group, and all before it.
      type(group_type), intent(in) :: groups(:)
      !> Out: the fault; not changed if there is none.
      character(:), allocatable, intent(inout) :: message
      integer :: i

      do i = size(groups) - 1, 1, -1
         select case (groups(i)%name)
         case ('gap', 'stop', 'friction', 'load')
            cycle
         case ('structure')
            return
         case default
            exit
         end select
      end do
      message = '&'//groups(size(groups))%name// &
         ': must follow a &structure and precede its studies'
   end subroutine check_place

   !> Whether a case of this system uses the frequency ratio of &system.
   pure logical function needs_r(studies, groups)
      !> All studies.
      type(study_type), intent(in) :: studies(:)
      !> All groups after the system.
      type(group_type), intent(in) :: groups(:)
      integer :: i, place

      needs_r = .false.
      do i = 1, size(groups)
         if (groups(i)%name == 'system' .or. groups(i)%name == 'structure') return
         place = place_of_study(studies, groups(i)%name, of_oscillator)
         if (place == 0) cycle
         needs_r = needs_r .or. .not. has_own_r(studies(place), groups(i))
      end do
   end function needs_r

   !> Why studies do not need the frequency ratio of &system, for messages.
   pure subroutine explain_own_r(studies, text)
      !> All studies.
      type(study_type), intent(in) :: studies(:)
      !> The groups that have their own window, or no load.
      character(:), allocatable, intent(out) :: text
      character(:), allocatable :: names
      integer :: i

      call join_groups(pack(studies%name, [(has_window(studies(i)), i=1, size(studies))]), names)
      text = 'it does not apply to a '//names//', which has r_min and r_max, nor to parameter &
         &= ''r'''
      call join_groups(pack(studies%name, .not. studies%has_load), names)
      if (len(names) > 0) text = text//', nor to a '//names//', which has no load'
      call join_groups(pack(studies%name, studies%finds_r), names)
      if (len(names) > 0) text = text//', nor to a '//names//', which finds it'
   end subroutine explain_own_r

   !> Whether the frequency ratios of a study are those of a window.
   pure logical function has_window(study)
      !> The study.
      type(study_type), intent(in) :: study
      type(key_type), allocatable :: keys(:)

      call study%keys_of(of_oscillator, keys)
      has_window = place_of(keys, 'r_min') > 0
   end function has_window

   !> Whether a study has frequency ratios of its own, a window or values of r, or needs none.
   pure logical function has_own_r(study, group)
      !> The study.
      type(study_type), intent(in) :: study
      !> Its group.
      type(group_type), intent(in) :: group
      integer :: i

      has_own_r = has_window(study) .or. .not. study%has_load .or. study%finds_r
      ! a study that starts from a group may have r as its parameter: it starts at the r of &system
      if (has_own_r .or. study%starts_from(of_oscillator) /= '') return
      do i = 1, size(group%items)
         associate (value => group%items(i)%value)
            if (group%items(i)%key == 'r') has_own_r = .true.
            if (group%items(i)%key /= 'parameter' .or. len(value) < 3) cycle
            has_own_r = has_own_r .or. lower(value(2:len(value) - 1)) == 'r'
         end associate
      end do
   end function has_own_r

   !> Reads and checks the groups of one case.
   subroutine take_case(studies, path, groups, i, system, case, line, message)
      !> All studies.
      type(study_type), intent(in) :: studies(:)
      !> The file; empty if there is none.
      character(*), intent(in) :: path
      !> All groups of the file.
      type(group_type), intent(in) :: groups(:)
      !> Place of the group that requests the result.
      integer, intent(in) :: i
      !> The system before it.
      type(system_type), intent(in) :: system
      !> The case.
      type(case_type), intent(inout) :: case
      !> Out: line of the fault; not changed if there is none.
      integer, intent(inout) :: line
      !> Out: the fault; empty if there is none.
      character(:), allocatable, intent(inout) :: message
      type(key_type), allocatable :: keys(:)
      character(:), allocatable :: element, names
      integer :: j

      associate (study => studies(place_of_study(studies, groups(i)%name, system%model)), &
         model => system%model)
         case%system = system%values
         case%model = model
         case%study_name = trim(study%name)
         if (model == of_structure) then
            case%coordinates = system%coordinates
            case%parts = system%parts
            call element_besides_gaps(case, element)
            if (has_moving_wall(case) .and. .not. study%takes_walls) then
               call join_groups(pack(studies%name, studies%takes_walls), names)
               message = '&'//trim(study%name)//': does not take moving walls (cosine or sine of &
                  &&gap or &stop); must be '//names
               return
            end if
            if (len(element) > 0 .and. .not. study%takes_elements) then
               call join_groups(pack(studies%name, studies%takes_elements), names)
               message = '&'//trim(study%name)//': does not take the &'//element//' of this &
                  &&structure; must be '//names
               return
            end if
         else
            associate (values => system%values)
               case%osc = oscillator_type(values%number('xi'), values%number('mu'), &
                  values%numbers('restitution'))
               if (values%has('r') .and. .not. has_own_r(study, groups(i))) case%r = &
                  values%number('r')
            end associate
         end if
         if (study%starts_from(model) /= '') then
            do j = i - 1, 1, -1
               if (groups(j)%name == study%starts_from(model) .or. groups(j)%name == 'system' &
                  .or. groups(j)%name == 'structure') exit
            end do
            if (groups(j)%name == 'system' .or. groups(j)%name == 'structure') then
               message = '&'//trim(study%name)//': no &'//trim(study%starts_from(model))// &
                  ' of this &'//groups(j)%name//' precedes it'
               return
            end if
            associate (start => studies(place_of_study(studies, study%starts_from(model), model)))
               call start%keys_of(model, keys)
               call read_values(trim(start%name), keys, groups(j), case%start, system%units)
            end associate
            call study%check_start(case, groups(i)%line)
            call pass_on(case%start, line, message)
            if (len(message) > 0) return
         end if
         call study%keys_of(model, keys)
         call read_values(groups(i)%name, keys, groups(i), case%study, system%units, &
            system_keys(:merge(size(system_keys), 0, model == of_oscillator)))
         call case%study%find_files(path)
         if (associated(study%check)) call study%check(case)
      end associate
      call pass_on(case%study, line, message)
   end subroutine take_case

   !> Reads the &sweep after a study, if there is one.
   subroutine take_sweep(studies, groups, last, system, case, line, message)
      !> All studies.
      type(study_type), intent(in) :: studies(:)
      !> All groups of the file.
      type(group_type), intent(in) :: groups(:)
      !> In: place of the study. Out: that of its &sweep, if it has one.
      integer, intent(inout) :: last
      !> The system of the case.
      type(system_type), intent(in) :: system
      !> The case.
      type(case_type), intent(inout) :: case
      !> Out: line of the fault; not changed if there is none.
      integer, intent(inout) :: line
      !> Out: the fault; empty if there is none.
      character(:), allocatable, intent(inout) :: message
      type(key_type), allocatable :: keys(:)
      character(24) :: name
      integer :: i, place

      if (last == size(groups)) return
      if (groups(last + 1)%name /= 'sweep') return
      last = last + 1
      call read_values('sweep', sweep_keys, groups(last), case%sweep)
      if (len(case%sweep%fault) == 0 .and. allocated(system%units)) then
         call studies(place_of_study(studies, case%study_name, system%model))%keys_of( &
            system%model, keys)
         do i = 1, case%sweep%count_words('keys')
            name = case%sweep%word('keys', i)
            place = place_of(keys, trim(name(index(name, '.') + 1:)))
            if (place == 0 .or. system%units%bare == dimensionless) cycle
            if (is_ambiguous(case, keys(place))) call case%sweep%refuse('keys', 'values of '// &
               trim(name)//' in a &sweep are dimensionless, so &system must have units = &
               &''dimensionless''')
         end do
      end if
      call pass_on(case%sweep, line, message)
   end subroutine take_sweep

   !> Whether numbers of a key without a unit can be dimensionless or physical.
   pure logical function is_ambiguous(case, key)
      !> The case.
      type(case_type), intent(in) :: case
      !> A key of its study.
      type(key_type), intent(in) :: key

      if (key%unit == of_target) then
         is_ambiguous = .not. (case%study%is('target', 'attenuation') .or. &
            case%study%is('target', 'damping'))
      else if (key%unit == of_parameter) then
         is_ambiguous = case%study%is('parameter', 'clearance')
      else
         is_ambiguous = has_two_readings(key%unit) .or. key%unit == of_state .or. &
            key%unit == of_axes .or. any(key%unit == of_axis)
      end if
   end function is_ambiguous

   !> Name and format of the result; the name is that of the file (numbered) unless given.
   subroutine take_output(path, groups, number, total, case, line, message)
      !> The file.
      character(*), intent(in) :: path
      !> The group of the case, and all after it.
      type(group_type), intent(in) :: groups(:)
      !> Number of the case, and how many there are.
      integer, intent(in) :: number, total
      !> The case.
      type(case_type), intent(inout) :: case
      !> Out: line of the fault; not changed if there is none.
      integer, intent(inout) :: line
      !> Out: the fault; empty if there is none.
      character(:), allocatable, intent(inout) :: message
      character(:), allocatable :: name
      logical :: follows
      integer :: i

      follows = size(groups) > 1
      if (follows) follows = groups(2)%name == 'output'
      case%line = groups(1)%line
      if (follows) then
         call read_values('output', output_keys, groups(2), case%output)
         call check_output(case%output)
         if (len(case%output%fault) == 0 .and. .not. has_units(case)) call case%output%refuse( &
            'units', 'without mass, stiffness and force in &system it must be left out or &
            &''dimensionless''')
         call pass_on(case%output, line, message)
         if (len(message) > 0) return
         do i = 1, size(groups(2)%items)
            if (groups(2)%items(i)%key == 'name') case%line = groups(2)%items(i)%line
         end do
      else
         call read_values('output', output_keys, values=case%output)
      end if
      if (.not. case%output%has('name')) then
         call find_name(path, number, total, name)
         call case%output%set_word('name', name)
      end if
      call case%output%text('name', case%name)
   end subroutine take_output

   !> Whether a result can be shown in the units that are asked for.
   pure logical function has_units(case)
      !> The case.
      type(case_type), intent(in) :: case
      character(:), allocatable :: names

      has_units = .not. case%output%has('units')
      if (has_units) return
      call case%output%text('units', names)
      has_units = names == 'dimensionless'
      if (.not. has_units) has_units = case%system%has(trim(merge('force ', 'scales', &
         case%model == of_oscillator)))
   end function has_units

   !> Passes on the fault of a group.
   pure subroutine pass_on(values, line, message)
      !> The group.
      type(values_type), intent(in) :: values
      !> Out: line of the fault; not changed if there is none.
      integer, intent(inout) :: line
      !> The fault.
      character(:), allocatable, intent(inout) :: message

      message = values%fault
      if (len(message) > 0) line = values%fault_line
   end subroutine pass_on

   !> Whether the last of some groups is a case.
   pure logical function ends_in_case(studies, groups)
      !> All studies.
      type(study_type), intent(in) :: studies(:)
      !> Some groups of the file.
      type(group_type), intent(in) :: groups(:)

      ends_in_case = .false.
      if (size(groups) > 0) ends_in_case = any(studies%name == groups(size(groups))%name)
   end function ends_in_case

   !> The model of the system to which each group belongs.
   pure function models_of(groups) result(models)
      !> All groups of the file.
      type(group_type), intent(in) :: groups(:)
      integer :: models(size(groups)), i, model

      model = of_oscillator
      do i = 1, size(groups)
         if (groups(i)%name == 'system') model = of_oscillator
         if (groups(i)%name == 'structure') model = of_structure
         models(i) = model
      end do
   end function models_of

   !> Whether a group is a case; one that is only the start of the study after it is not.
   pure logical function is_case(studies, groups, model)
      !> All studies.
      type(study_type), intent(in) :: studies(:)
      !> The group, and all after it.
      type(group_type), intent(in) :: groups(:)
      !> The model of its system.
      integer, intent(in) :: model
      integer :: place

      is_case = any(studies%name == groups(1)%name)
      if (.not. is_case .or. size(groups) == 1) return
      place = place_of_study(studies, groups(2)%name, model)
      if (place > 0) is_case = studies(place)%starts_from(model) /= groups(1)%name
   end function is_case

   !> The place of a fault: file and line.
   pure function place(path, line) result(text)
      !> The file.
      character(*), intent(in) :: path
      !> Line of the fault; 0 if it is not in one particular line.
      integer, intent(in) :: line
      character(len(path) + 2 + merge(1 + whole_width(line), 0, line > 0)) :: text

      text = path//': '
      if (line > 0) text = path//':'//whole(line)//': '
   end function place

   !> The name of a result from that of the file, numbered if it holds several cases.
   pure subroutine find_name(path, number, total, name)
      !> The file.
      character(*), intent(in) :: path
      !> Number of the case, and how many there are.
      integer, intent(in) :: number, total
      !> The name.
      character(:), allocatable, intent(out) :: name
      character(:), allocatable :: stem, suffix
      integer :: i, n

      stem = path(index(path, '/', back=.true.) + 1:)
      i = index(stem, '.', back=.true.)
      if (i > 1) stem = stem(:i - 1)
      suffix = ''
      if (total > 1) suffix = '_'//whole(number)
      name = ''
      i = 1
      do while (i <= len(stem))
         n = name_part(stem(i:))
         if (len(name) + max(1, n) > longest_name - len(suffix)) exit
         if (n == 0) name = name//'_'
         name = name//stem(i:i + n - 1)
         i = i + max(1, n)
      end do
      name = name//suffix
      if (index(name, '.') == 1) name(1:1) = '_'
      if (len(name) == 0) name = 'case'
   end subroutine find_name

end module vi_parse_cases
