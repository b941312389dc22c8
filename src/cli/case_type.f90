!> A case: everything that one computation of the batch program needs.
module vi_case_type
   use vi_atlas, only: atlas_request_type
   use vi_kinds, only: wp
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_raw_attractors, only: attractor_keys_type
   use vi_window, only: window_type
   use vi_sheet, only: zone_request_type
   implicit none (type, external)
   private

   !> A case with all that its groups told, and what was missing filled in.
   type, public :: case_type
      character(:), allocatable :: name
      type(oscillator_type) :: osc
      real(wp) :: r = 0
      !> 'periodic' (phases given), 'equispaced' (clearance given), 'exact' (clearance given, phases
      !! guessed), 'simulate', 'chart', 'branch', 'zone', 'atlas',
      !! 'lyapunov', 'bifurcation', 'response' or 'basins'
      character(:), allocatable :: kind
      !> The kind of the motion, also of that which a branch starts from.
      character(:), allocatable :: motion_kind
      type(pattern_type) :: pattern
      real(wp), allocatable :: phases(:), restitution(:)
      logical :: own_restitution = .false.
      real(wp) :: clearance = 0, acceptance = 0
      logical :: single = .false.
      !> 'csv', 'table' or 'both'
      character(:), allocatable :: format
      !> Of a simulation: load cycles kept and discarded, load amplitude, t, x, x', z, z' at the
      !! start.
      real(wp) :: duration = 0, discard = 0, load = 1, start(5) = 0
      integer :: max_events = 0
      !> Of a chart.
      type(window_type) :: window
      !> Of a branch: the parameter and its bounds, longest step, most points each way. Of a line
      !! of points: the parameter, empty if there is only one point.
      character(:), allocatable :: parameter
      real(wp) :: bounds(2) = 0, longest_step = 0
      integer :: max_points = 0
      !> Of a zone; which motions: 'yes', 'no' or 'both'.
      type(zone_request_type) :: zone
      character(:), allocatable :: symmetric
      !> Of an atlas.
      type(atlas_request_type) :: atlas
      !> Of a study of attractors, its keys as they were read.
      type(attractor_keys_type), allocatable :: attractor
      !> Of a bifurcation diagram: 'up', 'down', 'both' or 'states', and whether a state was given.
      character(:), allocatable :: sweep
      logical :: started = .false.
      !> Where the name was given, for messages.
      integer :: line = 0
   end type case_type

end module vi_case_type
