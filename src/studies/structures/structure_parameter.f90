!> The keys that name a parameter of a structure in a case, and their checks.
module vi_structure_parameter
   use vi_kinds, only: wp
   use vi_structure, only: load_type, structure_type
   use vi_structure_path, only: change_type, new_change, new_function
   use vi_study, only: a_whole, key_type, values_type
   use vi_text, only: counted, number_text, whole
   implicit none (type, external)
   private

   public :: bounds_of, check_parameter, parameter_change

   integer, parameter :: most_entries = 20000, most_numbers = 500000
   character(*), parameter :: &
      entry_takes = 'three whole numbers for each entry: kind (1 mass, 2 damping, 3 stiffness, 4 &
      &direction, 5 opening, 6 restitution, 7 frequency, 8 cosine, 9 sine, 10 constant, &
      &11 number of a stop or of friction, 12 cosine and 13 sine of the motion of a wall), and two &
      &indices from 1, or 0', &
      entry_meaning = 'entries that depend on the parameter; indices: row and column, coordinate &
      &and gap, coordinate and harmonic, or element and number of its law', &
      series_takes = 'the same number of coefficients for each entry', &
      series_meaning = 'Chebyshev coefficients of each entry over the bounds of the parameter', &
      at_meaning = 'value of the parameter at the motion'

   !> The keys of a parameter that is a function: of a branch, and of both axes of a zone.
   type(key_type), parameter, public :: function_keys(*) = [ &
      key_type('entries', a_whole, most=3*most_entries, low=0.0_wp, only='parameter=function', &
      takes=entry_takes, meaning=entry_meaning), &
      key_type('series', most=most_numbers, only='parameter=function', takes=series_takes, &
      meaning=series_meaning), &
      key_type('at', only='parameter=function', meaning=at_meaning)], &
      x_function_keys(*) = [ &
      key_type('x_entries', a_whole, most=3*most_entries, low=0.0_wp, only='x=function', &
      takes=entry_takes, meaning=entry_meaning), &
      key_type('x_series', most=most_numbers, only='x=function', takes=series_takes, &
      meaning=series_meaning), &
      key_type('x_at', only='x=function', meaning=at_meaning)], &
      y_function_keys(*) = [ &
      key_type('y_entries', a_whole, most=3*most_entries, low=0.0_wp, only='y=function', &
      takes=entry_takes, meaning=entry_meaning), &
      key_type('y_series', most=most_numbers, only='y=function', takes=series_takes, &
      meaning=series_meaning), &
      key_type('y_at', only='y=function', meaning=at_meaning)]

contains

   !> Checks a parameter and its bounds.
   subroutine check_parameter(group, name, prefix, structure, load, change)
      !> In and out: the group, in which a fault is recorded.
      type(values_type), intent(inout) :: group
      !> The key of the parameter, and what its other keys begin with.
      character(*), intent(in) :: name, prefix
      !> The structure of the case.
      type(structure_type), intent(in) :: structure
      !> Its load.
      type(load_type), intent(in) :: load
      !> The parameter, if there is no fault.
      type(change_type), intent(out) :: change
      character(:), allocatable :: message, word
      integer :: bound, m

      if (len(group%fault) > 0) return
      call group%text(name, word)
      if (.not. load%frequency > 0 .and. (word == 'frequency' .or. word == 'load' .or. &
         index(word, 'wall') == 1)) then
         group%fault = '&'//group%name//' '//name//' = '''//word//''': must be another one, as a &
            &self-excited motion has no load with a frequency'
         group%fault_line = group%line
         return
      end if
      if (word == 'function') then
         m = size(group%numbers(prefix//'entries'))
         if (modulo(m, 3) /= 0) then
            call group%refuse(prefix//'entries', counted(m, 'number')//' in all')
         else if (modulo(size(group%numbers(prefix//'series')), m/3) /= 0) then
            call group%refuse(prefix//'series', 'there are '//counted(m/3, 'place')//' and '// &
               counted(size(group%numbers(prefix//'series')), 'number'))
         end if
      end if
      if (.not. group%number(prefix//'high') > group%number(prefix//'low')) then
         call group%refuse(prefix//'high')
      end if
      if (len(group%fault) > 0) return
      call parameter_change(group, name, prefix, structure, load, change, message, bound)
      if (len(message) > 0) then
         ! the first fault counts
         if (bound == 1) call group%refuse(prefix//'low', message)
         if (bound == 2) call group%refuse(prefix//'high', message)
         if (word == 'function') call group%refuse(prefix//'entries', message)
         call group%refuse(name, message)
         return
      end if
      message = 'the motion'
      if (group%name == 'atlas') message = 'the structure'
      message = message//' has '//word//' = '//trim(number_text(change%start, .false., 10))
      if (change%low > change%start) call group%refuse(prefix//'low', message)
      if (change%high < change%start) call group%refuse(prefix//'high', message)
   end subroutine check_parameter

   !> The parameter of a case.
   pure subroutine parameter_change(group, name, prefix, structure, load, change, message, bound)
      !> The group.
      type(values_type), intent(in) :: group
      !> The key of the parameter, and what its other keys begin with.
      character(*), intent(in) :: name, prefix
      !> The structure of the case.
      type(structure_type), intent(in) :: structure
      !> Its load.
      type(load_type), intent(in) :: load
      !> The parameter.
      type(change_type), intent(out) :: change
      !> What is wrong with it; empty if nothing is.
      character(:), allocatable, intent(out) :: message
      !> The bound that is wrong, 1 or 2; 0 if another key is.
      integer, intent(out), optional :: bound
      character(:), allocatable :: word
      real(wp) :: bounds(2)
      integer :: m

      bounds = bounds_of(group, prefix)
      call group%text(name, word)
      if (present(bound)) bound = 0
      if (word == 'function') then
         associate (entries => group%numbers(prefix//'entries'), &
            series => group%numbers(prefix//'series'))
            m = size(entries)/3
            call new_function(reshape(nint(entries), [3, m]), reshape(series, [size(series)/m, &
               m]), bounds, group%number(prefix//'at'), structure, load, change, message)
         end associate
      else
         call new_change(word, bounds, structure, load, change, message, bound)
      end if
   end subroutine parameter_change

   !> The least and the greatest value of a parameter: its bounds, or the ends of a list.
   pure function bounds_of(group, prefix) result(bounds)
      !> The group.
      type(values_type), intent(in) :: group
      !> What the keys of the parameter begin with.
      character(*), intent(in) :: prefix
      real(wp) :: bounds(2)

      if (group%has(prefix//'list')) then
         associate (list => group%numbers(prefix//'list'))
            bounds = list([1, size(list)])
         end associate
      else
         bounds = [group%number(prefix//'low'), group%number(prefix//'high')]
      end if
   end function bounds_of

end module vi_structure_parameter
