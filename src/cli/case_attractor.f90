!> The cases of &lyapunov and &bifurcation, checked, and what the studies of attractors share.
module vi_case_attractor
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use, intrinsic :: iso_fortran_env, only: int64
   !$ use omp_lib, only: omp_get_max_threads
   use vi_case_branch, only: least, most, parameters
   use vi_case_type, only: case_type
   use vi_keys, only: complain, forbid, given
   use vi_kinds, only: wp
   use vi_namelist, only: group_type
   use vi_raw, only: is_blank, no_number
   use vi_text, only: exact, lower, whole
   use vi_window, only: most_numbers, spaced
   implicit none (type, external)
   private

   public :: available_threads, check_number, check_whole, line_points
   public :: parameter_values, take_bifurcation, take_lyapunov

   character(5), parameter :: coordinates(5) = [character(5) :: 't', 'x', 'x_dot', 'z', 'z_dot']

contains

   !> Checks the variables of &lyapunov, which are in the case.
   subroutine take_lyapunov(group, case, line, message)
      type(group_type), intent(in) :: group
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message

      call check_line(group, case, line, message)
      associate (a => case%attractor)
         call check_whole(group, 'batches', a%batches, 2, 1000, line, message)
         call check_whole(group, 'cycles', a%cycles, 2*a%batches, 10**9, line, message)
         call check_whole(group, 'discard', a%discard, 0, 10**9, line, message)
         call check_number(group, 'load', a%load, 0.0_wp, 1.0e12_wp, line, message)
         ! the walls may move with the parameter: the state is between the nearest of them
         call check_start(group, case, merge(a%low(1), a%clearance, case%parameter == &
            'clearance'), line, message)
      end associate
   end subroutine take_lyapunov

   !> Checks the variables of &bifurcation, which are in the case.
   subroutine take_bifurcation(group, case, line, message)
      type(group_type), intent(in) :: group
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: i, runs

      call check_line(group, case, line, message)
      associate (a => case%attractor)
         case%sweep = trim(lower(a%sweep))
         if (len(message) == 0 .and. all(case%sweep /= [character(6) :: 'up', 'down', 'both', &
            'states'])) call complain(group, 'sweep', line, message)
         do i = 1, 5
            if (.not. given(group, trim(coordinates(i)))) cycle
            case%started = .true.
            if (len(message) == 0 .and. case%sweep == 'states') call forbid(group, &
               trim(coordinates(i)), line, message, 'must be left out: sweep = ''states'' has &
               &states of its own')
         end do
         if (len(message) == 0 .and. case%sweep /= 'states') call forbid(group, 'states', line, &
            message, 'must be left out: it is for sweep = ''states''')
         call check_whole(group, 'states', a%states, 1, 1000000, line, message)
         call check_whole(group, 'settling', a%settling, 0, 10**7, line, message)
         call check_whole(group, 'keep', a%keep, 3, 10**4, line, message)
         call check_whole(group, 'points', a%points, 1, 4096, line, message)
         call check_number(group, 'load', a%load, 0.0_wp, 1.0e12_wp, line, message)
         runs = merge(a%states, merge(2, 1, case%sweep == 'both'), case%sweep == 'states')
         if (len(message) == 0 .and. int(a%values(1), int64)*a%points*runs > most_numbers) call &
            complain(group, 'points', line, message, 'values x runs x points must be at most '// &
            whole(most_numbers))
         call check_start(group, case, merge(merge(a%high(1), a%low(1), case%sweep == 'down'), &
            a%clearance, case%parameter == 'clearance'), line, message)
      end associate
   end subroutine take_bifurcation

   !> Checks the parameter with its values, and the clearance.
   subroutine check_line(group, case, line, message)
      type(group_type), intent(in) :: group
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      character(7), parameter :: companions(4) = [character(7) :: 'low', 'high', 'values', &
         'spacing']
      integer :: place, i

      associate (a => case%attractor)
         place = 0
         do i = 1, size(parameters)
            if (lower(parameters(i)) == lower(a%parameter)) place = i
         end do
         case%parameter = ''
         if (place > 0) case%parameter = trim(parameters(place))
         if (case%kind == 'lyapunov' .and. .not. given(group, 'parameter')) then
            do i = 1, size(companions)
               if (len(message) == 0) call forbid(group, trim(companions(i)), line, message, &
                  'must be left out: it goes with parameter')
            end do
         else if (place == 0 .or. case%kind == 'lyapunov' .and. place > 2) then
            call complain(group, 'parameter', line, message)
         else
            call check_values(group, case, place, line, message)
         end if
         if (case%parameter == 'clearance') then
            if (len(message) == 0) call forbid(group, 'clearance', line, message, &
               'must be left out: it is the parameter')
         else
            call check_number(group, 'clearance', a%clearance, 1.0e-12_wp, 1.0e12_wp, line, message)
         end if
      end associate
   end subroutine check_line

   !> Checks that the values of the parameter are in its range.
   subroutine check_values(group, case, place, line, message)
      type(group_type), intent(in) :: group
      type(case_type), intent(in) :: case
      !> Of the parameter.
      integer, intent(in) :: place
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message

      associate (a => case%attractor)
         if (all(lower(a%spacing) /= [character(9) :: 'linear', 'geometric'])) then
            call complain(group, 'spacing', line, message)
         else if (.not. (a%low(1) >= least(place) .and. is_blank(a%low(2)))) then
            call complain(group, 'low', line, message)
         else if (.not. (a%high(1) > a%low(1) .and. a%high(1) <= most(place) .and. &
            is_blank(a%high(2)))) then
            call complain(group, 'high', line, message)
         else if (a%values(1) < 2 .or. a%values(1) > 1000000 .or. a%values(2) /= no_number) then
            call complain(group, 'values', line, message)
         else if (lower(a%spacing) == 'geometric' .and. .not. a%low(1) > 0) then
            call complain(group, 'low', line, message, 'above 0 with spacing = ''geometric''')
         else if (.not. rise(parameter_values(case))) then
            call complain(group, 'values', line, message, 'so many between '//exact(a%low(1))// &
               ' and '//exact(a%high(1))//' do not differ')
         else if (case%parameter == 'r' .and. case%osc%xi <= 0) then
            if (any(abs(parameter_values(case) - 1) <= 0)) call complain(group, 'low', line, &
               message, &
               'r = 1 with xi = 0 (resonance without damping) must not be among the values')
         else if (case%parameter == 'xi' .and. a%low(1) <= 0 .and. abs(case%r - 1) <= 0) then
            call complain(group, 'low', line, message, &
               'r = 1 with xi = 0 (resonance without damping) must not be among the values')
         end if
      end associate
   end subroutine check_values

   !> Whether each number is above the one before.
   pure logical function rise(values)
      real(wp), intent(in) :: values(:)

      rise = all(values(2:) > values(:size(values) - 1))
   end function rise

   !> The values of the parameter.
   pure function parameter_values(case) result(values)
      type(case_type), intent(in) :: case
      real(wp), allocatable :: values(:)

      associate (a => case%attractor)
         values = spaced(a%low(1), a%high(1), a%values(1), lower(a%spacing) == 'geometric')
      end associate
   end function parameter_values

   !> The points of a line along r or the clearance, or the one of the case.
   pure subroutine line_points(case, r, clearance)
      type(case_type), intent(in) :: case
      real(wp), allocatable, intent(out) :: r(:), clearance(:)
      integer :: n

      n = 1
      if (len(case%parameter) > 0) n = case%attractor%values(1)
      allocate (r(n), source=case%r)
      allocate (clearance(n), source=case%attractor%clearance)
      if (case%parameter == 'r') r = parameter_values(case)
      if (case%parameter == 'clearance') clearance = parameter_values(case)
   end subroutine line_points

   !> The threads that there are; no answer depends on them.
   integer function available_threads() result(threads)
      threads = 1
      !$ threads = omp_get_max_threads()
   end function available_threads

   !> Checks the initial state.
   subroutine check_start(group, case, clearance, line, message)
      type(group_type), intent(in) :: group
      type(case_type), intent(in) :: case
      real(wp), intent(in) :: clearance
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: i

      if (len(message) > 0) return
      associate (start => case%attractor%start)
         do i = 1, 5
            if (ieee_is_finite(start(i))) cycle
            call complain(group, trim(coordinates(i)), line, message)
            return
         end do
         if (abs(start(4) - start(2)) > 0.5_wp*clearance*(1 + 1.0e-9_wp)) call complain(group, &
            'z', line, message, 'z - x must be within half the clearance')
      end associate
   end subroutine check_start

   !> Checks a whole number, unless there is a fault already.
   subroutine check_whole(group, key, value, low, high, line, message)
      type(group_type), intent(in) :: group
      character(*), intent(in) :: key
      integer, intent(in) :: value, low, high
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message

      if (len(message) > 0) return
      if (value < low .or. value > high) call complain(group, key, line, message)
   end subroutine check_whole

   !> The same of a number.
   subroutine check_number(group, key, value, low, high, line, message)
      type(group_type), intent(in) :: group
      character(*), intent(in) :: key
      real(wp), intent(in) :: value, low, high
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message

      if (len(message) > 0) return
      if (.not. (value >= low .and. value <= high)) call complain(group, key, line, message)
   end subroutine check_number

end module vi_case_attractor
