!> The complete case as a namelist, for the header of its result.
module vi_echo
   use vi_case_type, only: case_type
   use vi_echo_attractors, only: echo_attractor
   use vi_kinds, only: wp
   use vi_pattern, only: side_letters, starred_letters
   use vi_text, only: append, exact, exact_width, line_type, whole
   use vi_version, only: version
   implicit none (type, external)
   private

   public :: echo, list

contains

   !> The complete case as a namelist, each line behind `#`.
   pure subroutine echo(case, lines)
      type(case_type), intent(in) :: case
      type(line_type), allocatable, intent(out) :: lines(:)

      call append(lines, '# ! vibroimpact '//version &
         //'; lengths in F0/K, time in 1/omega, angles in &
         &radians; this file is an input too')
      call append(lines, '# &system')
      call append(lines, '#   xi = '//exact(case%osc%xi))
      call append(lines, '#   mu = '//exact(case%osc%mu))
      call append(lines, '#   restitution = '//list(case%osc%restitution))
      if (.not. has_own_r(case)) call append(lines, '#   r = '//exact(case%r))
      call append(lines, '# /')
      select case (case%kind)
      case ('simulate')
         call echo_simulation(case, lines)
      case ('chart')
         call echo_chart(case, lines)
      case ('zone')
         call echo_zone(case, lines)
      case ('atlas')
         call echo_atlas(case, lines)
      case ('lyapunov', 'bifurcation', 'response', 'basins')
         call echo_attractor(case, lines)
      case default
         call echo_motion(case, lines)
         if (case%kind == 'branch') call echo_branch(case, lines)
      end select
      call append(lines, '# &output')
      call append(lines, '#   name = '''//case%name//'''')
      call append(lines, '#   format = '''//case%format//'''')
      call append(lines, '# /')
   end subroutine echo

   !> Whether a case has frequency ratios of its own: a window, or values of r.
   pure logical function has_own_r(case)
      type(case_type), intent(in) :: case

      has_own_r = any(case%kind == [character(8) :: 'chart', 'zone', 'atlas', 'response'])
      if (any(case%kind == [character(11) :: 'lyapunov', 'bifurcation'])) then
         has_own_r = case%parameter == 'r'
      end if
   end function has_own_r

   pure subroutine echo_motion(case, lines)
      type(case_type), intent(in) :: case
      type(line_type), allocatable, intent(inout) :: lines(:)

      call append(lines, '# &motion')
      call append(lines, '#   kind = '''//case%motion_kind//'''')
      call append(lines, '#   cycles = '//whole(case%pattern%cycles))
      if (case%motion_kind /= 'periodic') call append(lines, '#   clearance = ' &
         //exact(case%clearance))
      if (case%motion_kind /= 'equispaced') then
         call append(lines, '#   sides = '''//side_letters(case%pattern%sides)//'''')
         call append(lines, '#   phases = '//list(case%phases))
      end if
      if (case%own_restitution) call append(lines, '#   impact_restitution = ' &
         //list(case%restitution))
      call append(lines, '#   precision = '//trim(merge('''single''', '''double''', case%single)))
      if (case%motion_kind /= 'exact') call append(lines, '#   acceptance = ' &
         //exact(case%acceptance))
      call append(lines, '# /')
   end subroutine echo_motion

   pure subroutine echo_simulation(case, lines)
      type(case_type), intent(in) :: case
      type(line_type), allocatable, intent(inout) :: lines(:)
      character(5), parameter :: names(5) = [character(5) :: 't', 'x', 'x_dot', 'z', 'z_dot']
      integer :: i

      call append(lines, '# &simulate')
      call append(lines, '#   clearance = '//exact(case%clearance))
      call append(lines, '#   cycles = '//exact(case%duration))
      call append(lines, '#   discard = '//exact(case%discard))
      call append(lines, '#   load = '//exact(case%load))
      do i = 1, 5
         call append(lines, '#   '//trim(names(i))//' = '//exact(case%start(i)))
      end do
      call append(lines, '#   max_events = '//whole(case%max_events))
      call append(lines, '# /')
   end subroutine echo_simulation

   pure subroutine echo_chart(case, lines)
      type(case_type), intent(in) :: case
      type(line_type), allocatable, intent(inout) :: lines(:)
      character(4), parameter :: symmetric(-1:1) = ['no  ', 'both', 'yes ']

      associate (w => case%window)
         call append(lines, '# &chart')
         call append(lines, '#   sides = '''//side_letters(case%pattern%sides)//'''')
         call append(lines, '#   cycles = '//whole(case%pattern%cycles))
         call append(lines, '#   r_min = '//exact(w%r_min))
         call append(lines, '#   r_max = '//exact(w%r_max))
         call append(lines, '#   r_points = '//whole(w%r_points))
         call append(lines, '#   clearance_min = '//exact(w%clearance_min))
         call append(lines, '#   clearance_max = '//exact(w%clearance_max))
         call append(lines, '#   clearance_points = '//whole(w%clearance_points))
         call append(lines, '#   spacing = '//trim(merge('''geometric''', '''linear''   ', &
            w%geometric)))
         call append(lines, '#   symmetric = '''//trim(symmetric(w%symmetry))//'''')
         call append(lines, '#   room = '//whole(w%room))
         call append(lines, '#   guesses = '//whole(w%guesses))
         call append(lines, '#   seeds = '//whole(w%seeds))
         call append(lines, '# /')
      end associate
   end subroutine echo_chart

   pure subroutine echo_branch(case, lines)
      type(case_type), intent(in) :: case
      type(line_type), allocatable, intent(inout) :: lines(:)

      call append(lines, '# &branch')
      call append(lines, '#   parameter = '''//case%parameter//'''')
      call append(lines, '#   low = '//exact(case%bounds(1)))
      call append(lines, '#   high = '//exact(case%bounds(2)))
      call append(lines, '#   longest_step = '//exact(case%longest_step))
      call append(lines, '#   max_points = '//whole(case%max_points))
      call append(lines, '# /')
   end subroutine echo_branch

   pure subroutine echo_zone(case, lines)
      type(case_type), intent(in) :: case
      type(line_type), allocatable, intent(inout) :: lines(:)

      call append(lines, '# &zone')
      call append(lines, '#   sides = '''//starred_letters(case%pattern%sides)//'''')
      call append(lines, '#   cycles = '//whole(case%pattern%cycles))
      call append(lines, '#   symmetric = '''//case%symmetric//'''')
      call echo_zone_window(case, lines)
   end subroutine echo_zone

   pure subroutine echo_atlas(case, lines)
      type(case_type), intent(in) :: case
      type(line_type), allocatable, intent(inout) :: lines(:)

      call append(lines, '# &atlas')
      call append(lines, '#   max_impacts = '//whole(case%atlas%max_impacts))
      call append(lines, '#   max_cycles = '//whole(case%atlas%max_cycles))
      call append(lines, '#   survey = '//whole(case%atlas%survey))
      call append(lines, '#   settling = '//whole(case%atlas%settling))
      call echo_zone_window(case, lines)
   end subroutine echo_atlas

   !> What &zone and &atlas have in common: the window and the limits of the search.
   pure subroutine echo_zone_window(case, lines)
      type(case_type), intent(in) :: case
      type(line_type), allocatable, intent(inout) :: lines(:)

      associate (zone => case%zone)
         call append(lines, '#   r_min = '//exact(zone%r(1)))
         call append(lines, '#   r_max = '//exact(zone%r(2)))
         call append(lines, '#   clearance_min = '//exact(zone%clearance(1)))
         call append(lines, '#   clearance_max = '//exact(zone%clearance(2)))
         call append(lines, '#   lines = '//whole(zone%lines))
         call append(lines, '#   guesses = '//whole(zone%guesses))
         call append(lines, '#   max_points = '//whole(zone%points))
         call append(lines, '# /')
      end associate
   end subroutine echo_zone_window

   !> Numbers with all their digits, as a list.
   pure function list(values) result(text)
      real(wp), intent(in) :: values(:)
      character(list_width(values)) :: text
      integer :: i, last

      text = exact(values(1))
      last = exact_width(values(1))
      do i = 2, size(values)
         text(last + 1:) = ', '//exact(values(i))
         last = last + 2 + exact_width(values(i))
      end do
   end function list

   !> Letters of `list`.
   pure integer function list_width(values) result(width)
      real(wp), intent(in) :: values(:)
      integer :: i

      width = sum([(exact_width(values(i)) + 2, i=1, size(values))]) - 2
   end function list_width

end module vi_echo
