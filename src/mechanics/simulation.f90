!> The data of a simulation: the forced system, its state, and its events.
module vi_simulation
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   use vi_oscillator, only: oscillator_type
   use vi_transition, only: transition_type
   implicit none (type, external)
   private

   !> Kinds of events.
   integer, parameter, public :: impact_event = 1, stick_event = 2, release_event = 3

   !> The system in motion: oscillator, frequency ratio, load amplitude f, clearance (same unit).
   type, public :: forced_system_type
      type(oscillator_type) :: osc
      real(wp) :: r = 1, load = 1, clearance = 1
      !> Amplitude of the motion without impacts, and its lag behind the load, equation (4).
      real(wp) :: amplitude = 0, lag = 0
      !> Whether this processor runs what is compiled for wide registers.
      logical :: wide = .false.
      !> Tables that advance both parts of x in time.
      type(transition_type) :: transition
   end type forced_system_type

   !> State of the system (lengths in F0/K, velocities in omega F0/K). The load phase r t is kept as
   !! whole cycles and the remainder, so that its error does not grow with time.
   type, public :: state_type
      integer(int64) :: cycle = 0
      !> In [0, 2 pi).
      real(wp) :: phase = 0
      real(wp) :: x = 0, x_dot = 0, z = 0, z_dot = 0
      !> +1 or -1 while on a wall, 0 inside.
      integer :: side = 0
      !> On a wall: the departure speed, whether the free mass rests there or was just released.
      real(wp) :: speed = 0
      logical :: resting = .false., released = .false.
   end type state_type

   !> An impact, or the beginning or the end of a rest.
   type, public :: event_type
      integer :: kind, side
      integer(int64) :: cycle
      real(wp) :: phase, x, x_dot_before, x_dot_after, z_dot_before, z_dot_after
   end type event_type

end module vi_simulation
