!> What basins of the oscillator and of structures have in common: a plane of initial states, names
!! of attractors, and their shares of the states.
module vi_basin_tables
   use vi_common_keys, only: check_product, most_numbers, turn_upwards
   use vi_kinds, only: wp
   use vi_spacing, only: even
   use vi_study, only: result_type, values_type
   use vi_text, only: counted, line_type, shown, whole
   implicit none (type, external)
   private

   public :: check_uneven, find_shares, is_even, open_states, plane_values, plane_sizes, set_axes, &
      tell_apart

   !> The keys of the values along both axes of a plane, where they are not evenly spaced.
   character(13), parameter, public :: uneven_keys(2) = [character(13) :: 'first_values', &
      'second_values']

contains

   !> Whether the values along both axes of a plane are evenly spaced.
   pure logical function is_even(study)
      !> The group.
      type(values_type), intent(in) :: study

      is_even = .not. study%has(trim(uneven_keys(1)))
   end function is_even

   !> Numbers of values along both axes of a plane.
   pure function plane_sizes(study) result(sizes)
      !> The group.
      type(values_type), intent(in) :: study
      integer :: sizes(2), i

      if (is_even(study)) then
         sizes = study%whole_numbers('values')
      else
         sizes = [(size(study%numbers(trim(uneven_keys(i)))), i=1, 2)]
      end if
   end function plane_sizes

   !> The values along an axis of a plane.
   pure function plane_values(study, i) result(axis)
      !> The group.
      type(values_type), intent(in) :: study
      !> Number of the axis, 1 or 2.
      integer, intent(in) :: i
      real(wp), allocatable :: axis(:)
      real(wp) :: low(2), high(2)
      integer :: sizes(2)

      if (is_even(study)) then
         sizes = study%whole_numbers('values')
         low = study%numbers('low')
         high = study%numbers('high')
         allocate (axis(sizes(i)))
         axis = even(low(i), high(i), sizes(i))
      else
         axis = study%numbers(trim(uneven_keys(i)))
      end if
   end function plane_values

   !> Checks the values along the axes of a plane where they are not evenly spaced, and the number
   !! of its states.
   pure subroutine check_uneven(study)
      !> The group.
      type(values_type), intent(inout) :: study
      character(:), allocatable :: most
      real(wp), allocatable :: axis(:)
      integer :: i, sizes(2)

      if (len(study%fault) > 0) return
      most = 'together at most '//whole(most_numbers)//' states'
      if (is_even(study)) then
         call check_product(study, 'values', study%whole_numbers('values'), most)
         return
      end if
      if (.not. study%has(trim(uneven_keys(2)))) then
         call study%refuse(trim(uneven_keys(2)), 'give the values of both axes or of neither')
         return
      end if
      do i = 1, 2
         call turn_upwards(study, trim(uneven_keys(i)), [character(1) ::])
         axis = study%numbers(trim(uneven_keys(i)))
         if (.not. all(axis(2:) > axis(:size(axis) - 1))) then
            call study%refuse(trim(uneven_keys(i)))
         end if
      end do
      sizes = plane_sizes(study)
      if (product(real(sizes, wp)) > most_numbers) call study%refuse(trim(uneven_keys(2)), most)
   end subroutine check_uneven

   !> Sets the values along both axes of a plane; the second axis varies fastest.
   pure subroutine set_axes(study, places, states)
      !> The group.
      type(values_type), intent(in) :: study
      !> The places of both axes in a state.
      integer, intent(in) :: places(2)
      !> (size of a state, values of the second axis times those of the first one) In and out.
      real(wp), intent(inout) :: states(:, :)
      integer :: sizes(2), i

      sizes = plane_sizes(study)
      do i = 1, sizes(1)
         states(places(2), (i - 1)*sizes(2) + 1:i*sizes(2)) = plane_values(study, 2)
      end do
      do i = 1, sizes(2)
         states(places(1), i::sizes(2)) = plane_values(study, 1)
      end do
   end subroutine set_axes

   !> Opens the tables of the states, and of the axes of a plane.
   pure subroutine open_states(study, dimension, n, result)
      !> The group.
      type(values_type), intent(in) :: study
      !> The name of the dimension of states that do not form a plane.
      character(*), intent(in) :: dimension
      !> Number of states.
      integer, intent(in) :: n
      !> The result.
      type(result_type), intent(inout) :: result
      character(*), parameter :: tables(2) = [character(6) :: 'first', 'second']
      integer :: sizes(2), i

      if (.not. study%has('axes')) then
         call result%open('states', dimension, [n])
         return
      end if
      sizes = plane_sizes(study)
      call result%open('states', trim(study%word('axes', 2))//' '//study%word('axes', 1), &
         sizes(2:1:-1))
      do i = 1, 2
         call result%open(trim(tables(i)), trim(study%word('axes', i)), [sizes(i)])
         call result%put(trim(tables(i)), 'place', plane_values(study, i))
      end do
   end subroutine open_states

   !> Numbers equal names.
   pure subroutine tell_apart(names)
      !> In and out: the names.
      type(line_type), intent(inout) :: names(:)
      type(line_type) :: plain(size(names))
      integer :: i, j, before, alike

      plain = names
      do i = 1, size(names)
         alike = 0
         before = 0
         do j = 1, size(names)
            if (plain(j)%text /= plain(i)%text) cycle
            alike = alike + 1
            if (j <= i) before = before + 1
         end do
         if (alike > 1) names(i)%text = plain(i)%text//' ('//whole(before)//')'
      end do
   end subroutine tell_apart

   !> The shares of the states that approach each attractor.
   pure subroutine find_shares(labels, reached, names, shares, errors, text)
      !> (states) Number of the attractor of each state.
      integer, intent(in) :: labels(:)
      !> Number of states that were reached.
      integer, intent(in) :: reached
      !> (attractors) Their names.
      type(line_type), intent(in) :: names(:)
      !> (attractors) The shares, and their standard errors for independent states; these are upper
      !! bounds for states of a plane.
      real(wp), intent(out) :: shares(:), errors(:)
      !> The shares in words.
      character(:), allocatable, intent(out) :: text
      integer :: i

      text = counted(reached, 'state')
      do i = 1, size(names)
         shares(i) = real(count(labels == i), wp)/reached
         errors(i) = sqrt(shares(i)*(1 - shares(i))/reached)
         text = text//', '//names(i)%text//' '//shown(100*shares(i), 'f12.2')//'% +- '// &
            shown(100*errors(i), 'f12.2')//'%'
      end do
   end subroutine find_shares

end module vi_basin_tables
