!> The keys that name a parameter of a structure in a case, and their checks.
module vi_structure_parameter
   use vi_kinds, only: wp
   use vi_structure, only: load_type, structure_type
   use vi_structure_path, only: change_type, new_change, new_function
   use vi_study, only: a_whole, key_type, values_type
   use vi_text, only: number_text
   implicit none (type, external)
   private

   public :: check_parameter, parameter_change

   integer, parameter :: most_entries = 20000, most_numbers = 500000
   character(*), parameter :: is_function = 'parameter=function'

   !> The keys of a parameter that is a function.
   type(key_type), parameter, public :: function_keys(*) = [ &
      key_type('entries', a_whole, most=3*most_entries, low=0.0_wp, only=is_function, &
      takes='three whole numbers for each entry: kind (1 mass, 2 damping, 3 stiffness, 4 direction, &
      &5 opening, 6 restitution, 7 frequency, 8 cosine, 9 sine, 10 constant), and row and column or &
      &the like from 1, or 0', &
      meaning='entries that depend on the parameter, with coordinate and gap of a direction, &
      &coordinate and harmonic of the load'), &
      key_type('series', most=most_numbers, only=is_function, &
      takes='the same number of coefficients for each entry', &
      meaning='Chebyshev coefficients of each entry over the bounds of the parameter'), &
      key_type('at', only=is_function, meaning='value of the parameter at the motion')]

contains

   !> Checks a parameter and its bounds.
   subroutine check_parameter(group, name, low, high, structure, load, change)
      !> In and out: the group, in which a fault is recorded.
      type(values_type), intent(inout) :: group
      !> The keys of the parameter and of its bounds.
      character(*), intent(in) :: name, low, high
      !> The structure of the case.
      type(structure_type), intent(in) :: structure
      !> Its load.
      type(load_type), intent(in) :: load
      !> The parameter, if there is no fault.
      type(change_type), intent(out) :: change
      character(:), allocatable :: message
      logical :: as_function

      if (len(group%fault) > 0) return
      as_function = group%is(name, 'function')
      if (as_function) then
         if (modulo(size(group%numbers('entries')), 3) /= 0) then
            call group%refuse('entries')
         else if (modulo(size(group%numbers('series')), size(group%numbers('entries'))/3) /= 0) then
            call group%refuse('series')
         end if
         if (len(group%fault) > 0) return
      end if
      if (.not. group%number(high) > group%number(low)) then
         call group%refuse(high)
         return
      end if
      call parameter_change(group, name, low, high, structure, load, change, message)
      if (len(message) > 0) then
         call group%refuse(trim(merge('entries  ', name//repeat(' ', max(0, 9 - len(name))), &
            as_function)), message)
      else if (change%low > change%start) then
         call group%refuse(low, 'the motion has '//trim(group%word(name))//' = '// &
            trim(number_text(change%start, .false., 10)))
      else if (change%high < change%start) then
         call group%refuse(high, 'the motion has '//trim(group%word(name))//' = '// &
            trim(number_text(change%start, .false., 10)))
      end if
   end subroutine check_parameter

   !> The parameter of a case.
   pure subroutine parameter_change(group, name, low, high, structure, load, change, message)
      !> The group.
      type(values_type), intent(in) :: group
      !> The keys of the parameter and of its bounds.
      character(*), intent(in) :: name, low, high
      !> The structure of the case.
      type(structure_type), intent(in) :: structure
      !> Its load.
      type(load_type), intent(in) :: load
      !> The parameter.
      type(change_type), intent(out) :: change
      !> What is wrong with it; empty if nothing is.
      character(:), allocatable, intent(out) :: message
      character(:), allocatable :: word
      real(wp) :: bounds(2)
      integer :: m

      bounds = [group%number(low), group%number(high)]
      call group%text(name, word)
      if (word == 'function') then
         m = size(group%numbers('entries'))/3
         call new_function(reshape(nint(group%numbers('entries')), [3, m]), &
            reshape(group%numbers('series'), [size(group%numbers('series'))/m, m]), bounds, &
            group%number('at'), structure, load, change, message)
      else
         call new_change(word, bounds, structure, load, change, message)
      end if
   end subroutine parameter_change

end module vi_structure_parameter
