!> The values of one namelist group, read with the table of its keys, checked and completed.
!!
!! The first fault is kept, with its line. The reader does not read the text after it. A study may
!! still run its own checks; their faults do not replace the first one.
module vi_values
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_buffer, only: add, buffer_type
   use vi_key, only: a_number, a_whole, a_word, describe_key, key_type, of_axes, of_axis, &
      of_parameter, of_state, of_target, place_of
   use vi_kinds, only: wp
   use vi_matrix_file, only: beside
   use vi_namelist, only: assignment_type, group_type
   use vi_parse, only: parse_numbers, parse_subscript, parse_words
   use vi_text, only: append, exact, lengthen, line_type, lower, number_text, whole
   use vi_units, only: dimensionless, has_two_readings, in_units, to_own_unit, units_type
   implicit none (type, external)
   private

   public :: read_values

   !> The value of a key.
   type :: value_type
      !> Whether it has a value, which may be the default, and whether it is given in the file.
      logical :: there = .false., given = .false.
      !> Its numbers, or its words.
      real(wp), allocatable :: numbers(:)
      type(line_type), allocatable :: words(:)
      !> The assignment from which each value came.
      integer, allocatable :: origin(:)
   end type value_type

   type, public :: values_type
      !> Name of the group.
      character(:), allocatable :: name
      !> Line at which the group begins; 0 if it is not in the file.
      integer :: line = 0
      !> The first fault, empty if there is none, and its line.
      character(:), allocatable :: fault
      integer :: fault_line = 0
      type(key_type), allocatable, private :: keys(:)
      type(value_type), allocatable, private :: values(:)
      type(assignment_type), allocatable, private :: items(:)
   contains
      procedure :: count_numbers, count_words, drop, echo, find_files, given, has, is, number, &
         numbers, refuse, forbid, set, set_word, text, whole_number, whole_numbers, word
   end type values_type

contains

   !> Reads a group; without a group, all keys get their defaults.
   pure subroutine read_values(name, keys, group, values, units, of_system)
      !> Name of the group.
      character(*), intent(in) :: name
      !> The table of its keys.
      type(key_type), intent(in) :: keys(:)
      !> The group as read from the file.
      type(group_type), intent(in), optional :: group
      !> The values of the group, or its first fault.
      type(values_type), intent(out) :: values
      !> What is known of the units of the system, if it is a &system.
      type(units_type), intent(in), optional :: units
      !> The keys of the &system before the group, which a message points to.
      type(key_type), intent(in), optional :: of_system(:)
      character(:), allocatable :: why
      integer :: i

      values%name = name
      values%fault = ''
      values%keys = keys
      allocate (values%values(size(keys)))
      if (present(group)) then
         values%line = group%line
         values%items = group%items
      else
         allocate (values%items(0))
      end if
      do i = 1, size(values%items)
         call assign(values, i, units, of_system)
         if (len(values%fault) > 0) return
      end do
      do i = 1, size(keys)
         if (values%values(i)%given) then
            call check_list(values, i)
         else if (len_trim(keys(i)%default) > 0) then
            call interpret(keys(i), trim(keys(i)%default), values%values(i)%numbers, &
               values%values(i)%words, why)
            values%values(i)%there = .true.
         end if
      end do
      if (len(values%fault) == 0) call check_order(values, units)
      do i = 1, size(keys)
         if (len(values%fault) == 0) call check_company(values, i)
      end do
      if (len(values%fault) == 0) call resolve_units(values)
   end subroutine read_values

   !> Stores one assignment in its key.
   pure subroutine assign(values, i, units, of_system)
      !> The group, read up to this assignment.
      type(values_type), intent(inout) :: values
      !> The assignment.
      integer, intent(in) :: i
      !> What is known of the units of the system.
      type(units_type), intent(in), optional :: units
      !> The keys of the &system before the group.
      type(key_type), intent(in), optional :: of_system(:)
      real(wp), allocatable :: numbers(:)
      type(line_type), allocatable :: words(:)
      character(:), allocatable :: text, why
      integer :: place, first, last, n, j
      logical :: good

      associate (item => values%items(i))
         place = place_of(values%keys, item%key)
         if (place == 0) then
            call list_keys(values%keys, text)
            if (values%name == 'system' .and. index(item%key, 'law') == 1) text = text// &
               '; a law of restitution belongs in a &gap of a &structure'
            if (present(of_system)) then
               ! a study over a range of r has its limits as keys
               if (place_of(of_system, item%key) > 0 .and. place_of(values%keys, item%key// &
                  '_min') == 0) text = text//'; '//item%key//' belongs in &system'
            end if
            call blame(values, item, 'is not a key of &'//values%name//'; must be one of '//text)
            return
         end if
         associate (key => values%keys(place), value => values%values(place))
            call parse_subscript(item%target(len(item%key) + 1:), key%most, first, last, good)
            why = ''
            if (good) then
               call interpret(key, item%value, numbers, words, why, cshift(units_of(values, key), &
                  first - 1), units)
               good = .not. allocated(why)
            end if
            n = 0
            if (good .and. key%kind == a_word) n = size(words)
            if (good .and. key%kind /= a_word) n = size(numbers)
            if (.not. good .or. n > last - first + 1) then
               call describe_key(values%keys, place, text)
               if (key%kind == a_number .and. vanishes(item%value)) text = text// &
                  '; a number this close to 0 cannot be represented; write 0'
               if (allocated(why)) text = text//why
               call blame(values, item, 'must be '//text)
               return
            end if
            if (.not. value%given) then
               allocate (value%numbers(0), value%words(0), value%origin(0))
            end if
            call enlarge(value, first + n - 1, key%kind)
            value%given = .true.
            value%there = .true.
            do j = 1, n
               associate (origin => value%origin(first + j - 1))
                  if (origin > 0) then
                     call blame(values, item, 'was given before, in line '//whole( &
                        values%items(origin)%line))
                     return
                  end if
                  origin = i
               end associate
               if (key%kind == a_word) then
                  value%words(first + j - 1) = words(j)
               else
                  value%numbers(first + j - 1) = numbers(j)
               end if
            end do
         end associate
      end associate
   end subroutine assign

   !> Whether a text is one number that is not 0, but so small that it would be rounded to 0.
   pure logical function vanishes(text)
      !> The value as written in the file.
      character(*), intent(in) :: text
      integer :: power, status

      power = scan(text, 'eEdD')
      ! a mantissa with a digit that is not 0, and a negative whole number as exponent
      vanishes = verify(text(:power - 1), ' +-.0123456789') == 0 .and. &
         scan(text(:power - 1), '123456789') > 0 .and. index(text(power + 1:), '-') == 1 .and. &
         verify(trim(text(power + 2:)), '0123456789') == 0 .and. len_trim(text) < power + 8
      if (.not. vanishes) return
      read (text(power + 1:), *, iostat=status) power
      vanishes = status == 0 .and. power < -300
   end function vanishes

   !> Extends the list of a key.
   pure subroutine enlarge(value, n, kind)
      !> In and out: the value of the key so far.
      type(value_type), intent(inout) :: value
      !> Smallest new length of the list.
      integer, intent(in) :: n
      !> Kind of the value of the key.
      integer, intent(in) :: kind
      integer, allocatable :: origin(:)
      real(wp), allocatable :: numbers(:)
      integer :: old

      old = size(value%origin)
      if (n <= old) return
      allocate (origin(n), source=0)
      origin(:old) = value%origin
      call move_alloc(origin, value%origin)
      if (kind == a_word) then
         call lengthen(value%words, n - old)
      else
         allocate (numbers(n), source=0.0_wp)
         numbers(:old) = value%numbers
         call move_alloc(numbers, value%numbers)
      end if
   end subroutine enlarge

   !> The units of the numbers of a key, from the first one on; the last ones follow each other.
   pure function units_of(values, key) result(units)
      !> The group.
      type(values_type), intent(in) :: values
      !> The key.
      type(key_type), intent(in) :: key
      character(20), allocatable :: units(:)
      character(*), parameter :: state(5) = [character(20) :: '1/omega', 'F0/K', 'omega F0/K', &
         'F0/K', 'omega F0/K'], names(5) = [character(20) :: 't', 'x', 'x_dot', 'y', 'z_dot'], &
         targets(4) = [character(20) :: 'displacement', 'rms', 'acceleration', 'force'], &
         of_targets(4) = [character(20) :: 'F0/K', 'F0/K', 'omega^2 F0/K', 'F0']
      type(line_type), allocatable :: words(:)
      character(:), allocatable :: deciding
      integer :: i, j, at
      logical :: good

      units = [key%unit]
      if (key%unit == of_state) units = state
      deciding = 'axes'
      if (key%unit == of_parameter) deciding = 'parameter'
      if (key%unit == of_target) deciding = 'target'
      if (deciding == 'axes' .and. key%unit /= of_axes .and. all(key%unit /= of_axis)) return
      units = ['']
      do i = 1, size(values%items)
         ! the key that decides may stand behind this one
         if (values%items(i)%key /= deciding) cycle
         call parse_words(values%items(i)%value, 2, words, good)
         units = [(repeat(' ', 20), j=1, size(words))]
         do j = 1, size(words)
            if (deciding == 'axes') then
               do at = 1, size(names)
                  if (names(at) == lower(words(j)%text)) units(j) = state(at)
               end do
            else if (deciding == 'target') then
               do at = 1, size(targets)
                  if (targets(at) == lower(words(j)%text)) units(j) = of_targets(at)
               end do
            else
               if (lower(words(j)%text) == 'r') units(j) = 'omega'
               if (lower(words(j)%text) == 'clearance') units(j) = 'F0/K'
            end if
         end do
         do j = 1, min(2, size(words))
            if (key%unit == of_axis(j)) units = units([j])
         end do
         return
      end do
   end function units_of

   !> Converts the text of a value for a key.
   pure subroutine interpret(key, text, numbers, words, why, own, units)
      !> The key.
      type(key_type), intent(in) :: key
      !> The text as written in the file.
      character(*), intent(in) :: text
      !> The value of a number or list of numbers.
      real(wp), allocatable, intent(out) :: numbers(:)
      !> The value of a word or list of words, spelled as in the table of keys.
      type(line_type), allocatable, intent(out) :: words(:)
      !> Allocated if the key does not accept it: empty, or the end of the message, which starts
      !! with a semicolon.
      character(:), allocatable, intent(out) :: why
      !> The units of its numbers.
      character(*), intent(in), optional :: own(:)
      !> What is known of the units of the system.
      type(units_type), intent(in), optional :: units
      logical :: good, understood
      integer :: i

      if (key%kind == a_word) then
         call parse_words(text, key%most, words, good)
         do i = 1, size(words)
            if (good .and. len_trim(key%words) > 0) call match_word(key%words, words(i)%text, good)
         end do
      else
         if (key%kind == a_number .and. scan(text, '''"') > 0 .and. present(own)) then
            call parse_words(text, min(key%most, len(text)), words, good)
            allocate (numbers(size(words)), source=0.0_wp)
            good = good .and. size(words) > 0 .and. (present(units) .or. any(own /= ''))
         else
            call parse_numbers(text, key%kind == a_whole, key%most, numbers, good)
         end if
         if (good .and. key%kind == a_number .and. present(own)) call convert(words, own, units, &
            numbers, why)
         if (allocated(why)) return
         understood = good
         good = good .and. all(numbers >= key%low .and. numbers <= key%high)
         if (key%above) good = good .and. all(numbers > key%low)
         if (key%below) good = good .and. all(numbers < key%high)
         if (understood .and. .not. good .and. allocated(words) .and. present(own)) call &
            name_converted(key, words, own, numbers, why)
      end if
      if (.not. good .and. .not. allocated(why)) why = ''
   end subroutine interpret

   !> Converts numbers to the units of their key.
   pure subroutine convert(words, own, units, numbers, why)
      !> The numbers with their units as texts, if they are texts.
      type(line_type), allocatable, intent(in) :: words(:)
      !> The units of the key, in turn.
      character(*), intent(in) :: own(:)
      !> What is known of the units of the system.
      type(units_type), intent(in), optional :: units
      !> In: if they are no texts, the numbers. Out: in the units of the key.
      real(wp), intent(inout) :: numbers(:)
      !> Allocated if one has another unit: the end of the message, from a semicolon on.
      character(:), allocatable, intent(out) :: why
      character(:), allocatable :: reason
      integer :: i

      if (.not. allocated(words)) then
         if (.not. present(units)) return
         if (units%bare == dimensionless) return
      end if
      do i = 1, size(numbers)
         associate (unit => own(modulo(i - 1, size(own)) + 1))
            if (allocated(words)) then
               call to_own_unit(unit, units, numbers(i), reason, words(i)%text)
            else
               call to_own_unit(unit, units, numbers(i), reason)
            end if
         end associate
         if (len(reason) == 0) cycle
         why = '; '//reason
         return
      end do
   end subroutine convert

   !> Names the first number beyond the range of its key, as given and in the unit of the range.
   pure subroutine name_converted(key, words, own, numbers, why)
      !> The key.
      type(key_type), intent(in) :: key
      !> The numbers with their units as texts.
      type(line_type), intent(in) :: words(:)
      !> The units of the key, in turn.
      character(*), intent(in) :: own(:)
      !> The numbers in the units of the key.
      real(wp), intent(in) :: numbers(:)
      !> The end of the message, from a semicolon on; not allocated if none is beyond the range.
      character(:), allocatable, intent(out) :: why
      integer :: i

      do i = 1, size(numbers)
         if (numbers(i) > key%low .and. numbers(i) < key%high) cycle
         if (.not. key%above .and. .not. abs(numbers(i) - key%low) > 0) cycle
         if (.not. key%below .and. .not. abs(numbers(i) - key%high) > 0) cycle
         if (.not. abs(key%low) > 0 .and. numbers(i) <= 0) return   ! 0 is the same in all units
         why = '; '//words(i)%text//' is '//trim(number_text(numbers(i), .false., 6))//' '// &
            trim(own(modulo(i - 1, size(own)) + 1))
         why = trim(why)
         return
      end do
   end subroutine name_converted

   !> Finds a word among those that a key accepts, ignoring case.
   pure subroutine match_word(words, text, good)
      !> Words separated by blanks.
      character(*), intent(in) :: words
      !> The word; spelled as in `words` if it is one of them.
      character(:), allocatable, intent(inout) :: text
      !> Whether it is one of them.
      logical, intent(out) :: good
      integer :: at

      at = index(' '//lower(words)//' ', ' '//lower(text)//' ')
      good = at > 0 .and. len(text) > 0 .and. index(text, ' ') == 0
      if (good) text = words(at:at + len(text) - 1)
   end subroutine match_word

   !> Checks that a list has no gaps and is long enough.
   pure subroutine check_list(values, place)
      !> The group.
      type(values_type), intent(inout) :: values
      !> Place of the key in its table.
      integer, intent(in) :: place
      integer :: n

      associate (key => values%keys(place), value => values%values(place))
         n = findloc(value%origin > 0, .true., 1, back=.true.)
         if (n < key%least .or. any(value%origin(:n) == 0)) then
            call values%refuse(trim(key%name))
         else if (key%kind == a_word) then
            value%words = value%words(:n)
            deallocate (value%numbers)
         else
            value%numbers = value%numbers(:n)
            deallocate (value%words)
         end if
      end associate
   end subroutine check_list

   !> Checks that a key is given if it is required, and only if it is allowed.
   pure subroutine check_company(values, place)
      !> The group.
      type(values_type), intent(inout) :: values
      !> Place of the key in its table.
      integer, intent(in) :: place
      character(:), allocatable :: why
      logical :: missing

      associate (key => values%keys(place), value => values%values(place))
         call find_reason(values, key, why)
         if (len(why) > 0) then
            if (value%given) call values%forbid(trim(key%name), why)
            value%there = .false.
            return
         end if
         missing = .not. (value%there .or. key%may_miss) .and. len_trim(key%is) == 0
         if (len_trim(key%or) > 0) then
            if (values%given(trim(key%or)) .and. value%given) then
               call values%forbid(trim(key%name), ' if '//trim(key%or)//' is given')
            else if (missing .and. .not. values%given(trim(key%or))) then
               call values%refuse(trim(key%name), 'or give '//trim(key%or))
            end if
         else if (missing) then
            call values%refuse(trim(key%name))
         end if
      end associate
   end subroutine check_company

   !> The reason why a key must be left out, as the end of a message; empty if it may be given.
   pure subroutine find_reason(values, key, why)
      !> The group.
      type(values_type), intent(in) :: values
      !> The key.
      type(key_type), intent(in) :: key
      !> The reason.
      character(:), allocatable, intent(out) :: why
      integer :: first, last

      why = ''
      if (len_trim(key%only) > 0) then
         if (.not. holds(values, trim(key%only))) why = ': it requires '//condition(key%only)
      end if
      last = 0
      do while (last < len_trim(key%never) .and. len(why) == 0)
         first = last + 1
         last = first + index(key%never(first:)//' ', ' ') - 2
         associate (other => key%never(first:last))
            if (holds(values, other)) then
               why = ': it does not apply to '//condition(other)
               if (index(other, '=') == 0) why = ' if '//condition(other)//' is given'
            end if
         end associate
         last = last + 1
      end do
      if (len(why) == 0) return
      if (key%why(1:1) == '=') then
         why = trim(key%why(2:))
      else
         why = why//trim(key%why)
      end if
   end subroutine find_reason

   !> Whether a key has a certain word, or is given at all.
   pure logical function holds(values, text)
      !> The group.
      type(values_type), intent(in) :: values
      !> 'key=word' or 'key'.
      character(*), intent(in) :: text
      integer :: equals

      equals = index(text, '=')
      if (equals == 0) then
         holds = values%given(text)
      else
         holds = values%is(text(:equals - 1), text(equals + 1:))
      end if
   end function holds

   !> A condition as written in a file: key = 'word', or key.
   pure function condition(text) result(words)
      !> 'key=word' or 'key'.
      character(*), intent(in) :: text
      character(len_trim(text) + merge(4, 0, index(text, '=') > 0)) :: words
      integer :: equals

      equals = index(text, '=')
      words = text
      if (equals > 0) words = text(:equals - 1)//' = '''//trim(text(equals + 1:))//''''
   end function condition

   !> Converts keys in another unit to the keys that they specify.
   pure subroutine resolve_units(values)
      !> The group.
      type(values_type), intent(inout) :: values
      integer :: i, j

      do i = 1, size(values%keys)
         if (len_trim(values%keys(i)%is) == 0 .or. .not. values%values(i)%there) cycle
         j = place_of(values%keys, values%keys(i)%is)
         values%values(j)%numbers = values%values(i)%numbers*values%keys(i)%factor
         values%values(j)%there = .true.
         values%values(i)%there = .false.
      end do
   end subroutine resolve_units

   !> Checks the keys whose values must be above those of others.
   pure subroutine check_order(values, units)
      !> The group.
      type(values_type), intent(inout) :: values
      !> What is known of the units of the system.
      type(units_type), intent(in), optional :: units
      integer :: i, n
      character(:), allocatable :: text
      logical :: good

      do i = 1, size(values%keys)
         if (len_trim(values%keys(i)%over) == 0 .or. .not. values%values(i)%there) cycle
         associate (low => values%values(place_of(values%keys, values%keys(i)%over)), &
            high => values%values(i))
            if (.not. low%there) cycle
            if (low%given .and. high%given) then
               ! 0 is the same in all units, and a number in the units of the &system has one
               if ((is_bare(values, low) .neqv. is_bare(values, high)) .and. &
                  abs(low%numbers(1)*high%numbers(1)) > 0 .and. .not. &
                  has_one_reading(units_of(values, values%keys(i)), units)) then
                  call values%refuse(trim(values%keys(i)%name), trim(values%keys(i)%over)// &
                     ' and '//trim(values%keys(i)%name)//' must both have a unit, or neither; '// &
                     trim(values%keys(i)%over)//' is '// &
                     values%items(low%origin(1))%value)
                  return
               end if
            end if
            n = min(size(low%numbers), size(high%numbers))
            good = all(high%numbers(:n) > low%numbers(:n))
            if (.not. good .and. size(low%numbers) > 1) then
               call values%refuse(trim(values%keys(i)%name))
            else if (.not. good) then
               call name_as_given(values, low, &
                  has_one_reading(units_of(values, values%keys(i)), units), text)
               text = trim(values%keys(i)%over)//' is '//text
               call values%refuse(trim(values%keys(i)%name), text)
            end if
         end associate
      end do
   end subroutine check_order

   !> The number of a key for messages: as written in the file if it has a unit.
   pure subroutine name_as_given(values, value, has_unit, text)
      !> The group.
      type(values_type), intent(in) :: values
      !> The value of the key, a number.
      type(value_type), intent(in) :: value
      !> Whether numbers without a unit are in units of the &system.
      logical, intent(in) :: has_unit
      !> The text for messages.
      character(:), allocatable, intent(out) :: text

      text = trim(number_text(value%numbers(1), .false.))
      if (.not. value%given) return
      if (has_unit .or. .not. is_bare(values, value)) text = values%items(value%origin(1))%value
   end subroutine name_as_given

   !> Whether numbers without a unit are in units of the &system.
   pure logical function has_one_reading(own, units) result(one)
      !> The units of the key, in turn.
      character(*), intent(in) :: own(:)
      !> What is known of the units of the system.
      type(units_type), intent(in), optional :: units
      integer :: i

      one = .false.
      if (present(units)) one = units%bare == in_units
      do i = 1, size(own)
         one = one .and. has_two_readings(own(i))
      end do
   end function has_one_reading

   !> Whether the number of a key is given without a unit.
   pure logical function is_bare(values, value)
      !> The group.
      type(values_type), intent(in) :: values
      !> The value of the key, which is given.
      type(value_type), intent(in) :: value

      is_bare = scan(values%items(value%origin(1))%value, '''"') == 0
   end function is_bare

   !> Records a fault of an assignment, if it is the first one.
   pure subroutine blame(values, item, why)
      !> The group.
      type(values_type), intent(inout) :: values
      !> The assignment.
      type(assignment_type), intent(in) :: item
      !> The fault, or the requirement.
      character(*), intent(in) :: why

      if (len(values%fault) > 0) return
      values%fault = '&'//values%name//' '//item%target//' = '//item%value//': '//why
      values%fault_line = item%line
   end subroutine blame

   !> Records that the value of a key is wrong or missing, if it is the first fault.
   pure subroutine refuse(values, name, why)
      !> The group.
      class(values_type), intent(inout) :: values
      !> The key.
      character(*), intent(in) :: name
      !> A requirement in addition to those of the table of keys.
      character(*), intent(in), optional :: why
      character(:), allocatable :: text
      integer :: place, i

      if (len(values%fault) > 0) return
      place = written_as(values, name)
      call describe_key(values%keys, place, text)
      if (present(why)) text = text//'; '//why
      do i = 1, size(values%items)
         if (values%items(i)%key /= values%keys(place)%name) cycle
         call blame(values, values%items(i), 'must be '//text)
         return
      end do
      values%fault = &
         '&'//values%name//' '//trim(values%keys(place)%name)//': is missing; must be ' &
         //text
      values%fault_line = values%line
   end subroutine refuse

   !> Records that a key must not be given, if it is, and if it is the first fault.
   pure subroutine forbid(values, name, why)
      !> The group.
      class(values_type), intent(inout) :: values
      !> The key.
      character(*), intent(in) :: name
      !> The text after 'must be left out', such as ' if states is given' or ': it is an axis'.
      character(*), intent(in) :: why
      integer :: i

      do i = 1, size(values%items)
         if (values%items(i)%key /= name) cycle
         call blame(values, values%items(i), 'must be left out'//why)
         return
      end do
   end subroutine forbid

   !> Place of the key, or of the key in another unit that is given for it.
   pure integer function written_as(values, name) result(place)
      !> The group.
      type(values_type), intent(in) :: values
      !> The key.
      character(*), intent(in) :: name
      integer :: i

      place = place_of(values%keys, name)
      do i = 1, size(values%keys)
         if (values%keys(i)%is == name .and. values%values(i)%given) place = i
      end do
   end function written_as

   !> Names of the keys, for messages.
   pure subroutine list_keys(keys, text)
      !> The table.
      type(key_type), intent(in) :: keys(:)
      !> The names, separated by commas.
      character(:), allocatable, intent(out) :: text
      integer :: i

      text = trim(keys(1)%name)
      do i = 2, size(keys)
         text = text//', '//trim(keys(i)%name)
      end do
   end subroutine list_keys

   !> Whether a key is given in the file.
   pure logical function given(values, name)
      !> The group.
      class(values_type), intent(in) :: values
      !> The key.
      character(*), intent(in) :: name

      given = values%values(place_of(values%keys, name))%given
   end function given

   !> Whether a key has a value, given or its default.
   pure logical function has(values, name)
      !> The group.
      class(values_type), intent(in) :: values
      !> The key; the group may have no such key.
      character(*), intent(in) :: name
      integer :: place

      has = .false.
      place = place_of(values%keys, name)
      if (place > 0) has = values%values(place)%there
   end function has

   !> Whether a key has a certain word.
   pure logical function is(values, name, word)
      !> The group.
      class(values_type), intent(in) :: values
      !> The key; the group may have no such key.
      character(*), intent(in) :: name
      !> The word, as spelled in the table.
      character(*), intent(in) :: word
      integer :: i

      is = .false.
      if (.not. values%has(name)) return
      associate (words => values%values(place_of(values%keys, name))%words)
         do i = 1, size(words)
            is = is .or. words(i)%text == word
         end do
      end associate
   end function is

   !> The number that a key has.
   pure real(wp) function number(values, name)
      !> The group.
      class(values_type), intent(in) :: values
      !> The key, which has a value.
      character(*), intent(in) :: name

      number = values%values(place_of(values%keys, name))%numbers(1)
   end function number

   !> The numbers that a key has.
   pure function numbers(values, name)
      !> The group.
      class(values_type), intent(in) :: values
      !> The key, which has values.
      character(*), intent(in) :: name
      real(wp), allocatable :: numbers(:)

      numbers = values%values(place_of(values%keys, name))%numbers
   end function numbers

   !> The whole number that a key has.
   pure integer function whole_number(values, name)
      !> The group.
      class(values_type), intent(in) :: values
      !> The key, which has a value.
      character(*), intent(in) :: name

      whole_number = nint(values%number(name))
   end function whole_number

   !> The whole numbers that a key has.
   pure function whole_numbers(values, name)
      !> The group.
      class(values_type), intent(in) :: values
      !> The key, which has values.
      character(*), intent(in) :: name
      integer, allocatable :: whole_numbers(:)

      whole_numbers = nint(values%numbers(name))
   end function whole_numbers

   !> A word of a key, padded with blanks; blank if the key has none.
   pure function word(values, name, i)
      !> The group.
      class(values_type), intent(in) :: values
      !> The key.
      character(*), intent(in) :: name
      !> Number of the word, if the key has several; 1 by default.
      integer, intent(in), optional :: i
      character(24) :: word
      integer :: which

      word = ''
      which = 1
      if (present(i)) which = i
      if (values%has(name)) word = values%values(place_of(values%keys, name))%words(which)%text
   end function word

   !> A word of any length.
   pure subroutine text(values, name, words)
      !> The group.
      class(values_type), intent(in) :: values
      !> The key, which has a value.
      character(*), intent(in) :: name
      !> The word.
      character(:), allocatable, intent(out) :: words

      words = values%values(place_of(values%keys, name))%words(1)%text
   end subroutine text

   !> Sets the numbers of a key; studies use it to complete keys that were left out.
   pure subroutine set(values, name, numbers)
      !> The group.
      class(values_type), intent(inout) :: values
      !> The key.
      character(*), intent(in) :: name
      !> The numbers of the key.
      real(wp), intent(in) :: numbers(:)

      associate (value => values%values(place_of(values%keys, name)))
         value%numbers = numbers
         value%there = .true.
      end associate
   end subroutine set

   !> Sets the word of a key.
   pure subroutine set_word(values, name, word)
      !> The group.
      class(values_type), intent(inout) :: values
      !> The key.
      character(*), intent(in) :: name
      !> The word of the key.
      character(*), intent(in) :: word

      associate (value => values%values(place_of(values%keys, name)))
         if (allocated(value%words)) deallocate (value%words)
         allocate (value%words(1))
         value%words(1)%text = word
         value%there = .true.
      end associate
   end subroutine set_word

   !> Replaces the names of files by their paths where the files are in the folder of the namelist.
   subroutine find_files(values, namelist)
      !> The group.
      class(values_type), intent(inout) :: values
      !> Path of the namelist; empty if there is none.
      character(*), intent(in) :: namelist
      character(:), allocatable :: full
      logical :: there
      integer :: i, j

      do i = 1, size(values%keys)
         if (.not. (values%keys(i)%file .and. values%values(i)%given)) cycle
         do j = 1, size(values%values(i)%words)
            associate (line => values%values(i)%words(j))
               call beside(namelist, line%text, full)
               inquire (file=full, exist=there)
               if (there) line%text = full
            end associate
         end do
      end do
   end subroutine find_files

   !> Removes the value of a key.
   pure subroutine drop(values, name)
      !> The group.
      class(values_type), intent(inout) :: values
      !> The key.
      character(*), intent(in) :: name

      values%values(place_of(values%keys, name))%there = .false.
   end subroutine drop

   !> The group with all its values, each line after `#`, in a form that can be read again.
   pure subroutine echo(values, lines)
      !> The group.
      class(values_type), intent(in) :: values
      !> The header so far.
      type(line_type), allocatable, intent(inout) :: lines(:)
      character(:), allocatable :: text
      integer :: i, j

      call append(lines, '# &'//values%name)
      do i = 1, size(values%keys)
         associate (key => values%keys(i), value => values%values(i))
            if (.not. value%there) cycle
            text = '#   '//trim(key%name)//' = '
            if (key%kind == a_number) then
               call add_numbers(value%numbers, text)
            else if (key%kind == a_word) then
               do j = 1, size(value%words)
                  if (j > 1) text = text//', '
                  call add_word(value%words(j)%text, text)
               end do
            else
               do j = 1, size(value%numbers)
                  if (j > 1) text = text//', '
                  text = text//whole(nint(value%numbers(j)))
               end do
            end if
            call append(lines, text)
         end associate
      end do
      call append(lines, '# /')
   end subroutine echo

   !> Adds a word to a text, in quotes; a quote in it is doubled.
   pure subroutine add_word(word, text)
      !> The word.
      character(*), intent(in) :: word
      !> The text so far.
      character(:), allocatable, intent(inout) :: text
      integer :: i

      text = text//''''
      do i = 1, len(word)
         if (word(i:i) == '''') text = text//''''
         text = text//word(i:i)
      end do
      text = text//''''
   end subroutine add_word

   !> Adds a list of numbers to a text; three or more equal numbers in a row are one repeat.
   pure subroutine add_numbers(numbers, text)
      !> The numbers, at least one.
      real(wp), intent(in) :: numbers(:)
      !> The text so far.
      character(:), allocatable, intent(inout) :: text
      integer(int64), parameter :: bits = 0
      type(buffer_type) :: buffer
      integer :: first, last

      call add(buffer, text)
      first = 1
      do while (first <= size(numbers))
         last = first
         do while (last < size(numbers))
            ! also the sign of a zero is part of the number
            if (transfer(numbers(last + 1), bits) /= transfer(numbers(first), bits)) exit
            last = last + 1
         end do
         if (last < first + 2) last = first
         if (first > 1) call add(buffer, ', ')
         if (last > first) call add(buffer, whole(last - first + 1)//'*')
         call add(buffer, exact(numbers(first)))
         first = last + 1
      end do
      text = buffer%text(:buffer%n)
   end subroutine add_numbers

   !> Number of words of a key.
   pure integer function count_words(values, name) result(n)
      !> The group.
      class(values_type), intent(in) :: values
      !> The key.
      character(*), intent(in) :: name

      n = 0
      if (values%has(name)) n = size(values%values(place_of(values%keys, name))%words)
   end function count_words

   !> Number of all numbers of a group.
   pure integer function count_numbers(values) result(n)
      !> The group.
      class(values_type), intent(in) :: values
      integer :: i

      n = 0
      do i = 1, size(values%keys)
         if (values%values(i)%there .and. allocated(values%values(i)%numbers)) then
            n = n + size(values%values(i)%numbers)
         end if
      end do
   end function count_numbers

end module vi_values
