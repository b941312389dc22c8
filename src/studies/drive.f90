!> What a simulation is about: the system in motion, its state, and what happens to it.
module vi_drive
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: wp
   use vi_oscillator, only: gain, lag, oscillator_type
   use vi_transition, only: new_transition, transition_type
   implicit none (type, external)
   private

   public :: new_drive, state_time, on_wall

   !> Kinds of events.
   integer, parameter, public :: impact_event = 1, stick_event = 2, release_event = 3

   real(wp), parameter, public :: two_pi = 2*acos(-1.0_wp)

   !> The system in motion: oscillator, frequency ratio, load amplitude f, clearance (same unit).
   type, public :: drive_type
      type(oscillator_type) :: osc
      real(wp) :: r = 1, load = 1, clearance = 1
      !> Amplitude of the motion without impacts, and its lag behind the load, equation (4).
      real(wp) :: amplitude = 0, lag = 0
      !> How both parts of x move on.
      type(transition_type) :: transition
   end type drive_type

   !> Where the system is. The load phase r t is kept as whole cycles and the rest, so that its
   !! error does not grow with time.
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

   type, public :: event_type
      integer :: kind, side
      integer(int64) :: cycle
      real(wp) :: phase, x, x_dot_before, x_dot_after, z_dot_before, z_dot_after
   end type event_type

contains

   pure function new_drive(osc, r, load, clearance) result(drive)
      type(oscillator_type), intent(in) :: osc
      real(wp), intent(in) :: r, load, clearance
      type(drive_type) :: drive

      drive%osc = osc
      drive%r = r
      drive%load = load
      drive%clearance = clearance
      drive%amplitude = load*gain(osc%xi, r)
      drive%lag = lag(osc%xi, r)
      call new_transition(osc%xi, r, drive%amplitude*cos(drive%lag), &
         drive%amplitude*sin(drive%lag), drive%transition)
   end function new_drive

   !> Time of a state in 1/omega.
   pure real(wp) function state_time(cycle, phase, r) result(time)
      integer(int64), intent(in) :: cycle
      real(wp), intent(in) :: phase, r

      time = (two_pi*real(cycle, wp) + phase)/r
   end function state_time

   !> Whether the relative position of a state given from outside is that of a wall.
   elemental logical function on_wall(y, half)
      real(wp), intent(in) :: y, half

      on_wall = abs(y) > half*(1 - 1.0e-12_wp)
   end function on_wall

end module vi_drive
