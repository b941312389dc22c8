!> The variables of the namelist groups, as the compiler's namelist input reads them.
module vi_raw
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   use vi_raw_attractors, only: attractor_keys_type, blank_attractor, no_number, &
      read_attractor
   use vi_raw_studies, only: blank_studies, raw_atlas_type, raw_branch_type, raw_zone_type, &
      read_atlas, read_branch, read_zone
   use vi_room, only: most_impacts, most_letters
   use vi_window, only: window_type
   implicit none (type, external)
   private

   public :: blank, blank_motion, is_blank, most_impacts, most_letters, no_number, read_value

   !> A number that nobody can type stands for one that was not given.
   integer(int64), parameter :: not_given = int(z'7FF8C0DE0000C0DE', int64)

   !> The variables of the three namelist groups, as read.
   type, public :: raw_type
      real(wp) :: xi, mu, restitution(2), r, clearance, acceptance
      real(wp), dimension(most_impacts) :: phases, phases_over_pi, impact_restitution
      character(most_letters) :: sides
      character(most_letters) :: kind, precision, format, name
      integer :: cycles
      !> &simulate: load cycles kept and discarded, load amplitude, initial state, limit of events.
      real(wp) :: duration, discard, load, t, x, x_dot, z, z_dot
      integer :: max_events
      !> &chart
      type(window_type) :: window
      character(most_letters) :: spacing, symmetric
      type(raw_branch_type) :: branch
      type(raw_zone_type) :: zone
      type(raw_atlas_type) :: atlas
      type(attractor_keys_type) :: attractor
   end type raw_type

contains

   !> Nothing given yet.
   subroutine blank(raw)
      type(raw_type), intent(inout) :: raw
      real(wp) :: nan

      nan = transfer(not_given, nan)
      raw%xi = nan
      raw%mu = nan
      raw%restitution = nan
      raw%r = nan
      call blank_motion(raw, '')
   end subroutine blank

   subroutine blank_motion(raw, group)
      type(raw_type), intent(inout) :: raw
      !> Some defaults depend on it.
      character(*), intent(in) :: group
      real(wp) :: nan

      nan = transfer(not_given, nan)
      raw%phases = nan
      raw%phases_over_pi = nan
      raw%impact_restitution = nan
      raw%clearance = nan
      raw%acceptance = 0.03_wp
      raw%sides = ''
      raw%kind = 'periodic'
      raw%precision = 'double'
      raw%cycles = 1
      raw%name = ''
      raw%format = 'csv'
      raw%duration = nan
      raw%discard = 0
      raw%load = 1
      raw%t = 0
      raw%x = 0
      raw%x_dot = 0
      raw%z = 0
      raw%z_dot = 0
      raw%max_events = 10000000
      raw%window = window_type(nan, nan, nan, nan)
      raw%spacing = 'linear'
      raw%symmetric = 'both'
      call blank_studies(nan, raw%branch, raw%zone, raw%atlas)
      call blank_attractor(nan, group, raw%attractor)
   end subroutine blank_motion

   !> One assignment through the compiler's namelist input.
   subroutine read_value(text, group, raw, status)
      character(*), intent(in) :: text, group
      type(raw_type), intent(inout) :: raw
      integer, intent(out) :: status

      select case (group)
      case ('system')
         call read_system(text, raw, status)
      case ('motion')
         call read_motion(text, raw, status)
      case ('simulate')
         call read_simulate(text, raw, status)
      case ('chart')
         call read_chart(text, raw, status)
      case ('branch')
         call read_branch(text, raw%branch, status)
      case ('zone')
         call read_zone(text, raw%zone, status)
      case ('atlas')
         call read_atlas(text, raw%atlas, status)
      case ('lyapunov', 'bifurcation', 'response', 'basins')
         call read_attractor('&attractor'//text(len(group) + 2:), raw%attractor, status)
      case default
         call read_output(text, raw, status)
      end select
   end subroutine read_value

   subroutine read_system(text, raw, status)
      character(*), intent(in) :: text
      type(raw_type), intent(inout) :: raw
      integer, intent(out) :: status
      real(wp) :: xi, mu, restitution(2), r
      namelist /system/ xi, mu, restitution, r

      xi = raw%xi
      mu = raw%mu
      restitution = raw%restitution
      r = raw%r
      read (text, nml=system, iostat=status)
      raw%xi = xi
      raw%mu = mu
      raw%restitution = restitution
      raw%r = r
   end subroutine read_system

   subroutine read_motion(text, raw, status)
      character(*), intent(in) :: text
      type(raw_type), intent(inout) :: raw
      integer, intent(out) :: status
      real(wp) :: clearance, acceptance
      real(wp), dimension(most_impacts) :: phases, phases_over_pi, impact_restitution
      character(most_letters) :: sides
      character(most_letters) :: kind, precision
      integer :: cycles
      namelist /motion/ kind, sides, cycles, phases, phases_over_pi, impact_restitution, &
         clearance, &
         precision, acceptance

      kind = raw%kind
      sides = raw%sides
      cycles = raw%cycles
      phases = raw%phases
      phases_over_pi = raw%phases_over_pi
      impact_restitution = raw%impact_restitution
      clearance = raw%clearance
      precision = raw%precision
      acceptance = raw%acceptance
      read (text, nml=motion, iostat=status)
      raw%kind = kind
      raw%sides = sides
      raw%cycles = cycles
      raw%phases = phases
      raw%phases_over_pi = phases_over_pi
      raw%impact_restitution = impact_restitution
      raw%clearance = clearance
      raw%precision = precision
      raw%acceptance = acceptance
   end subroutine read_motion

   subroutine read_simulate(text, raw, status)
      character(*), intent(in) :: text
      type(raw_type), intent(inout) :: raw
      integer, intent(out) :: status
      real(wp) :: clearance, cycles, discard, load, t, x, x_dot, z, z_dot
      integer :: max_events
      namelist /simulate/ clearance, cycles, discard, load, t, x, x_dot, z, z_dot, max_events

      clearance = raw%clearance
      cycles = raw%duration
      discard = raw%discard
      load = raw%load
      t = raw%t
      x = raw%x
      x_dot = raw%x_dot
      z = raw%z
      z_dot = raw%z_dot
      max_events = raw%max_events
      read (text, nml=simulate, iostat=status)
      raw%clearance = clearance
      raw%duration = cycles
      raw%discard = discard
      raw%load = load
      raw%t = t
      raw%x = x
      raw%x_dot = x_dot
      raw%z = z
      raw%z_dot = z_dot
      raw%max_events = max_events
   end subroutine read_simulate

   subroutine read_chart(text, raw, status)
      character(*), intent(in) :: text
      type(raw_type), intent(inout) :: raw
      integer, intent(out) :: status
      character(most_letters) :: sides, spacing, symmetric
      real(wp) :: r_min, r_max, clearance_min, clearance_max
      integer :: cycles, r_points, clearance_points, room, guesses, seeds
      namelist /chart/ sides, cycles, r_min, r_max, r_points, clearance_min, clearance_max, &
         clearance_points, spacing, symmetric, room, guesses, seeds

      sides = raw%sides
      cycles = raw%cycles
      spacing = raw%spacing
      symmetric = raw%symmetric
      associate (w => raw%window)
         r_min = w%r_min
         r_max = w%r_max
         r_points = w%r_points
         clearance_min = w%clearance_min
         clearance_max = w%clearance_max
         clearance_points = w%clearance_points
         room = w%room
         guesses = w%guesses
         seeds = w%seeds
         read (text, nml=chart, iostat=status)
         w = window_type(r_min, r_max, clearance_min, clearance_max, r_points, clearance_points, &
            room=room, guesses=guesses, seeds=seeds)
      end associate
      raw%sides = sides
      raw%cycles = cycles
      raw%spacing = spacing
      raw%symmetric = symmetric
   end subroutine read_chart

   subroutine read_output(text, raw, status)
      character(*), intent(in) :: text
      type(raw_type), intent(inout) :: raw
      integer, intent(out) :: status
      character(most_letters) :: name, format
      namelist /output/ name, format

      name = raw%name
      format = raw%format
      read (text, nml=output, iostat=status)
      raw%name = name
      raw%format = format
   end subroutine read_output

   !> Whether a number was not given. (A NaN that was typed is given.)
   elemental logical function is_blank(value)
      real(wp), intent(in) :: value

      is_blank = transfer(value, 0_int64) == not_given
   end function is_blank

end module vi_raw
