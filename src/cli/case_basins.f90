!> The case of a &basins group, checked, and its states.
module vi_case_basins
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_attractor_spread, only: random_states
   use vi_case_attractor, only: check_number, check_whole
   use vi_case_type, only: case_type
   use vi_keys, only: complain, forbid, given
   use vi_kinds, only: wp
   use vi_namelist, only: group_type
   use vi_text, only: lower, whole
   use vi_window, only: even, most_numbers
   implicit none (type, external)
   private

   public :: fixed_value, initial_states, take_basins

   !> Coordinates of a state; y is z - x.
   character(5), parameter, public :: axis_names(5) = [character(5) :: 't', 'x', 'x_dot', 'y', &
      'z_dot']

contains

   !> Checks the variables of &basins, which are in the case.
   subroutine take_basins(group, case, line, message)
      type(group_type), intent(in) :: group
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message

      associate (a => case%attractor)
         a%axes = [lower(a%axes(1)), lower(a%axes(2))]
         call check_number(group, 'clearance', a%clearance, 1.0e-12_wp, 1.0e12_wp, line, message)
         if (given(group, 'states')) then
            call check_random(group, case, line, message)
         else
            if (len(message) == 0) call forbid(group, 'seed', line, message, &
               'must be left out: it goes with states')
            if (len(message) == 0) call check_plane(group, case, line, message)
            if (len(message) == 0) call check_fixed(group, case, line, message)
         end if
         call check_number(group, 'load', a%load, 0.0_wp, 1.0e12_wp, line, message)
         call check_whole(group, 'cycles', a%cycles, 1, 10**7, line, message)
         call check_whole(group, 'probes', a%probes, 1, 10**6, line, message)
         call check_whole(group, 'max_cycles', a%max_cycles, 1, 100, line, message)
      end associate
   end subroutine take_basins

   !> Checks random states: nothing of a plane is beside them.
   subroutine check_random(group, case, line, message)
      type(group_type), intent(in) :: group
      type(case_type), intent(in) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      character(6), parameter :: others(9) = [character(6) :: 'axes', 'low', 'high', 'values', &
         axis_names]
      integer :: i

      do i = 1, size(others)
         if (len(message) == 0) call forbid(group, trim(others(i)), line, message, &
            'must be left out beside states: they are random in all coordinates, at t = 0')
      end do
      call check_whole(group, 'states', case%attractor%states, 1, most_numbers, line, message)
      call check_whole(group, 'seed', case%attractor%seed, 0, huge(1), line, message)
   end subroutine check_random

   !> Checks the axes and their values.
   subroutine check_plane(group, case, line, message)
      type(group_type), intent(in) :: group
      type(case_type), intent(in) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: i

      associate (a => case%attractor)
         do i = 1, 2
            if (all(axis_names /= a%axes(i)) .or. a%axes(1) == a%axes(2)) then
               call complain(group, 'axes', line, message)
            else if (.not. ieee_is_finite(a%low(i))) then
               call complain(group, 'low', line, message)
            else if (.not. (a%high(i) > a%low(i) .and. ieee_is_finite(a%high(i)))) then
               call complain(group, 'high', line, message)
            else if (a%values(i) < 2 .or. a%values(i) > 100000) then
               call complain(group, 'values', line, message)
            else if (a%axes(i) == 'y' .and. max(-a%low(i), a%high(i)) > half_gap(case)) then
               call complain(group, trim(merge('low ', 'high', -a%low(i) > half_gap(case))), line, &
                  message, 'y must be within half the clearance')
            end if
            if (len(message) > 0) return
         end do
         if (product(int(a%values, int64)) > most_numbers) call complain(group, 'values', line, &
            message, 'together at most '//whole(most_numbers)//' states')
      end associate
   end subroutine check_plane

   !> Checks the coordinates that no axis has.
   subroutine check_fixed(group, case, line, message)
      type(group_type), intent(in) :: group
      type(case_type), intent(in) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: i

      do i = 1, size(axis_names)
         if (.not. given(group, trim(axis_names(i)))) cycle
         if (any(case%attractor%axes == axis_names(i))) then
            call forbid(group, trim(axis_names(i)), line, message, &
               'must be left out: it is an axis')
         else if (.not. ieee_is_finite(fixed_value(case, i))) then
            call complain(group, trim(axis_names(i)), line, message)
         else if (axis_names(i) == 'y' .and. abs(fixed_value(case, i)) > half_gap(case)) then
            call complain(group, 'y', line, message, 'y must be within half the clearance')
         end if
         if (len(message) > 0) return
      end do
   end subroutine check_fixed

   !> How far the free mass may be from the middle.
   pure real(wp) function half_gap(case)
      type(case_type), intent(in) :: case

      half_gap = 0.5_wp*case%attractor%clearance*(1 + 1.0e-9_wp)
   end function half_gap

   !> A coordinate that no axis has.
   pure real(wp) function fixed_value(case, i) result(value)
      type(case_type), intent(in) :: case
      !> Of `axis_names`.
      integer, intent(in) :: i

      value = case%attractor%start(i)
      if (axis_names(i) == 'y') value = case%attractor%y
   end function fixed_value

   !> The states: t, x, x', z, z' of each.
   pure function initial_states(case) result(states)
      type(case_type), intent(in) :: case
      real(wp), allocatable :: states(:, :)

      associate (a => case%attractor)
         if (a%states > 0) then
            states = random_states(case%osc%xi, case%r, a%load, a%clearance, a%states, a%seed)
         else
            states = plane_states(case)
         end if
      end associate
   end function initial_states

   !> The states (5, n m) of the plane; the second axis varies first.
   pure function plane_states(case) result(states)
      type(case_type), intent(in) :: case
      real(wp), allocatable :: states(:, :)
      integer :: i, j, n, m, first, second

      associate (a => case%attractor)
         n = a%values(1)
         m = a%values(2)
         allocate (states(5, n*m))
         do i = 1, 5
            states(i, :) = fixed_value(case, i)
         end do
         first = findloc(axis_names == a%axes(1), .true., 1)
         second = findloc(axis_names == a%axes(2), .true., 1)
         do j = 1, n
            states(second, (j - 1)*m + 1:j*m) = even(a%low(2), a%high(2), m)
         end do
         do j = 1, m
            states(first, j::m) = even(a%low(1), a%high(1), n)
         end do
         states(4, :) = states(4, :) + states(2, :)
      end associate
   end function plane_states

end module vi_case_basins
