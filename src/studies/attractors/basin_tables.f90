!> What basins of the oscillator and of structures have in common: a plane of initial states, names
!! of attractors, and their shares of the states.
module vi_basin_tables
   use vi_kinds, only: wp
   use vi_spacing, only: even
   use vi_study, only: result_type, values_type
   use vi_text, only: counted, line_type, shown, whole
   implicit none (type, external)
   private

   public :: find_shares, open_states, set_axes, tell_apart

contains

   !> Sets the values along both axes of a plane; the second axis varies fastest.
   pure subroutine set_axes(study, places, states)
      !> The group.
      type(values_type), intent(in) :: study
      !> The places of both axes in a state.
      integer, intent(in) :: places(2)
      !> (size of a state, values of the second axis times those of the first one) In and out.
      real(wp), intent(inout) :: states(:, :)
      real(wp) :: low(2), high(2)
      integer :: sizes(2), i

      sizes = study%whole_numbers('values')
      low = study%numbers('low')
      high = study%numbers('high')
      do i = 1, sizes(1)
         states(places(2), (i - 1)*sizes(2) + 1:i*sizes(2)) = even(low(2), high(2), sizes(2))
      end do
      do i = 1, sizes(2)
         states(places(1), i::sizes(2)) = even(low(1), high(1), sizes(1))
      end do
   end subroutine set_axes

   !> Opens the tables of the states, and of the axes of a plane.
   pure subroutine open_states(study, dimension, n, result)
      !> The group.
      type(values_type), intent(in) :: study
      !> The name of the dimension of states that are no plane.
      character(*), intent(in) :: dimension
      !> Number of states.
      integer, intent(in) :: n
      !> The result.
      type(result_type), intent(inout) :: result
      character(*), parameter :: tables(2) = [character(6) :: 'first', 'second']
      real(wp) :: low(2), high(2)
      integer :: sizes(2), i

      if (.not. study%has('axes')) then
         call result%open('states', dimension, [n])
         return
      end if
      sizes = study%whole_numbers('values')
      low = study%numbers('low')
      high = study%numbers('high')
      call result%open('states', trim(study%word('axes', 2))//' '//study%word('axes', 1), &
         sizes(2:1:-1))
      do i = 1, 2
         call result%open(trim(tables(i)), trim(study%word('axes', i)), [sizes(i)])
         call result%put(trim(tables(i)), 'place', even(low(i), high(i), sizes(i)))
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
