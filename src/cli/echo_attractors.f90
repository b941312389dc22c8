!> The groups of studies of attractors, for the header of the result.
module vi_echo_attractors
   use vi_case_basins, only: axis_names, fixed_value
   use vi_case_type, only: case_type
   use vi_raw, only: is_blank
   use vi_text, only: append, exact, line_type, lower, whole
   implicit none (type, external)
   private

   public :: echo_attractor

contains

   !> The complete group, each line behind `#`.
   pure subroutine echo_attractor(case, lines)
      type(case_type), intent(in) :: case
      type(line_type), allocatable, intent(inout) :: lines(:)

      call append(lines, '# &'//case%kind)
      associate (a => case%attractor)
         select case (case%kind)
         case ('lyapunov')
            call echo_line(case, lines)
            call append(lines, '#   cycles = '//whole(a%cycles))
            call append(lines, '#   discard = '//whole(a%discard))
            call append(lines, '#   batches = '//whole(a%batches))
            call echo_start(case, lines)
         case ('bifurcation')
            call echo_line(case, lines)
            call append(lines, '#   sweep = '''//case%sweep//'''')
            call echo_settling(case, lines)
            call append(lines, '#   points = '//whole(a%points))
            if (case%started) call echo_start(case, lines)
         case ('basins')
            call echo_basins(case, lines)
         case default
            call append(lines, '#   r_min = '//exact(a%r_min))
            call append(lines, '#   r_max = '//exact(a%r_max))
            call append(lines, '#   r_points = '//whole(a%r_points))
            if (is_blank(a%inverse_clearance)) then
               call append(lines, '#   clearance = '//exact(a%clearance))
            else
               call append(lines, '#   inverse_clearance = '//exact(a%inverse_clearance))
            end if
            call echo_settling(case, lines)
         end select
         call append(lines, '#   load = '//exact(a%load))
      end associate
      call append(lines, '# /')
   end subroutine echo_attractor

   !> The initial states, and what decides.
   pure subroutine echo_basins(case, lines)
      type(case_type), intent(in) :: case
      type(line_type), allocatable, intent(inout) :: lines(:)
      integer :: i

      associate (a => case%attractor)
         call append(lines, '#   clearance = '//exact(a%clearance))
         if (a%states > 0) then
            call append(lines, '#   states = '//whole(a%states))
            call append(lines, '#   seed = '//whole(a%seed))
         else
            call append(lines, '#   axes = '''//trim(a%axes(1))//''', '''//trim(a%axes(2))//'''')
            call append(lines, '#   low = '//exact(a%low(1))//', '//exact(a%low(2)))
            call append(lines, '#   high = '//exact(a%high(1))//', '//exact(a%high(2)))
            call append(lines, '#   values = '//whole(a%values(1))//', '//whole(a%values(2)))
            do i = 1, size(axis_names)
               if (all(a%axes /= axis_names(i))) call append(lines, '#   '//trim(axis_names(i))// &
                  ' = '//exact(fixed_value(case, i)))
            end do
         end if
         call append(lines, '#   cycles = '//whole(a%cycles))
         call append(lines, '#   probes = '//whole(a%probes))
         call append(lines, '#   max_cycles = '//whole(a%max_cycles))
      end associate
   end subroutine echo_basins

   !> How many states are simulated, and how long.
   pure subroutine echo_settling(case, lines)
      type(case_type), intent(in) :: case
      type(line_type), allocatable, intent(inout) :: lines(:)

      associate (a => case%attractor)
         if (case%kind == 'response' .or. case%sweep == 'states') call append(lines, &
            '#   states = '//whole(a%states))
         call append(lines, '#   settling = '//whole(a%settling))
         call append(lines, '#   keep = '//whole(a%keep))
      end associate
   end subroutine echo_settling

   !> The parameter with its values, and the clearance.
   pure subroutine echo_line(case, lines)
      type(case_type), intent(in) :: case
      type(line_type), allocatable, intent(inout) :: lines(:)

      associate (a => case%attractor)
         if (case%parameter /= 'clearance') call append(lines, '#   clearance = ' &
            //exact(a%clearance))
         if (len(case%parameter) == 0) return
         call append(lines, '#   parameter = '''//case%parameter//'''')
         call append(lines, '#   low = '//exact(a%low(1)))
         call append(lines, '#   high = '//exact(a%high(1)))
         call append(lines, '#   values = '//whole(a%values(1)))
         call append(lines, '#   spacing = '''//trim(lower(a%spacing))//'''')
      end associate
   end subroutine echo_line

   !> The initial state.
   pure subroutine echo_start(case, lines)
      type(case_type), intent(in) :: case
      type(line_type), allocatable, intent(inout) :: lines(:)
      character(5), parameter :: names(5) = [character(5) :: 't', 'x', 'x_dot', 'z', 'z_dot']
      integer :: i

      do i = 1, 5
         call append(lines, '#   '//trim(names(i))//' = '//exact(case%attractor%start(i)))
      end do
   end subroutine echo_start

end module vi_echo_attractors
