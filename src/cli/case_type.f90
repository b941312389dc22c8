!> A case: everything that one computation of the batch program needs.
module vi_case_type
   use vi_kinds, only: wp
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: pattern_type
   use vi_window, only: window_type
   implicit none (type, external)
   private

   type, public :: case_type
      character(:), allocatable :: name
      type(oscillator_type) :: osc
      real(wp) :: r = 0
      !> 'periodic' (phases given), 'equispaced' (clearance given), 'simulate' or 'chart'
      character(:), allocatable :: kind
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
      !> Where the name was given, for messages.
      integer :: line = 0
   end type case_type

end module vi_case_type
