!> The variables of &lyapunov, &bifurcation, &response and &basins, as the compiler's namelist input
!! reads them.
module vi_raw_attractors
   use vi_kinds, only: wp
   use vi_room, only: most_letters
   implicit none (type, external)
   private

   public :: blank_attractor, read_attractor

   !> Stands for a whole number that was not given.
   integer, parameter, public :: no_number = -huge(1)

   !> A key means the same in every group that has it.
   type, public :: attractor_keys_type
      character(most_letters) :: parameter = '', spacing = 'linear', sweep = 'both', axes(2) = ''
      real(wp) :: clearance = 0, inverse_clearance = 0, load = 1
      !> Two for the axes of a plane.
      real(wp), dimension(2) :: low = 0, high = 0
      integer :: values(2) = no_number
      real(wp) :: r_min = 0, r_max = 0
      integer :: r_points = 0
      !> t, x, x', z, z', and z - x.
      real(wp) :: start(5) = 0, y = 0
      integer :: cycles = 0, discard = 0, batches = 0, states = 0, settling = 0, keep = 0, &
         points = 0, probes = 0, max_cycles = 0, seed = 0
   end type attractor_keys_type

contains

   !> Nothing given yet: what is not told is as a call from Python has it.
   pure subroutine blank_attractor(not_given, group, raw)
      !> The number that stands for one that was not given.
      real(wp), intent(in) :: not_given
      character(*), intent(in) :: group
      type(attractor_keys_type), intent(out) :: raw

      raw%clearance = not_given
      raw%inverse_clearance = not_given
      raw%low = not_given
      raw%high = not_given
      raw%r_min = not_given
      raw%r_max = not_given
      raw%discard = 1000
      raw%batches = 20
      raw%points = 100
      raw%keep = 33
      raw%probes = 200
      raw%max_cycles = 16
      select case (group)
      case ('lyapunov')
         raw%cycles = 10000
      case ('bifurcation')
         raw%states = 12
         raw%settling = 300
      case ('response')
         raw%states = 24
         raw%settling = 600
      case default
         raw%cycles = 1000
      end select
   end subroutine blank_attractor

   !> The text of one assignment, whatever the group: that it has the key is known.
   subroutine read_attractor(text, raw, status)
      !> key = value
      character(*), intent(in) :: text
      type(attractor_keys_type), intent(inout), target :: raw
      integer, intent(out) :: status
      character(most_letters), pointer :: parameter, spacing, sweep, axes(:)
      real(wp), pointer :: clearance, inverse_clearance, load, low(:), high(:), r_min, r_max, &
         t, x, x_dot, y, z, z_dot
      integer, pointer :: values(:), r_points, cycles, discard, batches, states, settling, keep, &
         points, probes, max_cycles, seed
      namelist /attractor/ parameter, spacing, sweep, axes, clearance, inverse_clearance, load, &
         low, high, values, r_min, r_max, r_points, t, x, x_dot, y, z, z_dot, cycles, discard, &
         batches, states, settling, keep, points, probes, max_cycles, seed

      parameter => raw%parameter
      spacing => raw%spacing
      sweep => raw%sweep
      axes => raw%axes
      clearance => raw%clearance
      inverse_clearance => raw%inverse_clearance
      load => raw%load
      low => raw%low
      high => raw%high
      values => raw%values
      r_min => raw%r_min
      r_max => raw%r_max
      r_points => raw%r_points
      t => raw%start(1)
      x => raw%start(2)
      x_dot => raw%start(3)
      z => raw%start(4)
      z_dot => raw%start(5)
      y => raw%y
      cycles => raw%cycles
      discard => raw%discard
      batches => raw%batches
      states => raw%states
      settling => raw%settling
      keep => raw%keep
      points => raw%points
      probes => raw%probes
      max_cycles => raw%max_cycles
      seed => raw%seed
      read (text, nml=attractor, iostat=status)
   end subroutine read_attractor

end module vi_raw_attractors
