!> Keys that several studies of structures share, and the checks that go with them.
module vi_structure_keys
   use vi_common_keys, only: most_state
   use vi_kinds, only: wp
   use vi_structure_groups, only: complete_coordinates, load_frequency, most_coordinates
   use vi_study, only: case_type, key_type
   implicit none (type, external)
   private

   public :: check_start_state, needs_frequency, place_in_state

   !> The longest time that a simulation may take.
   real(wp), parameter, public :: longest = 1.0e12_wp
   character(*), parameter, public :: of_coordinates = &
      'one number from -1e100 to 1e100 for each coordinate'

   !> An initial state.
   type(key_type), parameter, public :: start_keys(3) = [ &
      key_type('q', most=most_coordinates, may_miss=.true., low=-most_state, high=most_state, &
      takes=of_coordinates, meaning='coordinates at the start; 0 if it is left out'), &
      key_type('q_dot', most=most_coordinates, may_miss=.true., low=-most_state, &
      high=most_state, takes=of_coordinates, &
      meaning='velocities at the start; 0 if it is left out'), &
      key_type('start', low=0.0_wp, high=longest, default='0', meaning='time at the start')]

contains

   !> Completes the initial state of a case, and checks its length.
   subroutine check_start_state(case)
      !> The case.
      type(case_type), intent(inout) :: case

      call complete_coordinates(case%study, 'q', case%coordinates)
      call complete_coordinates(case%study, 'q_dot', case%coordinates)
   end subroutine check_start_state

   !> Checks that the load has a frequency.
   subroutine needs_frequency(case, key)
      !> The case.
      type(case_type), intent(inout) :: case
      !> The key that is refused if it has none.
      character(*), intent(in) :: key

      if (.not. load_frequency(case) > 0) call case%study%refuse(key, &
         'it requires a &load with a frequency')
   end subroutine needs_frequency

   !> The place in a state (q, q') of a coordinate or velocity by its name: q_0, q_1, .. or q_dot_0,
   !! ..; 0 if there is none.
   pure integer function place_in_state(name, coordinates) result(place)
      !> The name.
      character(*), intent(in) :: name
      !> Number of coordinates.
      integer, intent(in) :: coordinates
      character(*), parameter :: digits = '0123456789'
      integer :: first, i, number

      place = 0
      if (index(name, 'q_') /= 1) return
      first = 3
      if (index(name, 'q_dot_') == 1) first = 7
      if (len_trim(name) < first .or. verify(trim(name(first:)), digits) > 0) return
      number = 0
      do i = first, len_trim(name)
         ! beyond all coordinates it stays there
         number = min(10*number + index(digits, name(i:i)) - 1, coordinates)
      end do
      if (number < coordinates) place = number + 1 + merge(coordinates, 0, first == 7)
   end function place_in_state

end module vi_structure_keys
