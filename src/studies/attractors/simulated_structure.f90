!> A simulation of a structure that goes on, through impacts, accumulations and rests.
!!
!! Directions are carried from event to event by the exact derivatives and orthonormalised after
!! each. The logarithms of their growth over whole periods of the load give the exponents of the map
!! over a period. The contraction of volume is a check: the sum of all logarithms is that of
!! exp(-tr(M^-1 C) t) and of R (R + R' v) over the impacts. With stops and friction it is that of
!! exp(-tr(M^-1 C) t) over the regimes and of the determinants of the saltation matrices.
module vi_simulated_structure
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_exponents, only: orthonormalise
   use vi_kinds, only: wp
   use vi_progress, only: is_stopped
   use vi_simulated_motion, only: cell_type, examination_type, growth_type, simulated_motion_type
   use vi_status, only: stat
   use vi_structure, only: regime_type, restitution_of
   use vi_structure_map, only: from_coordinates, to_coordinates
   use vi_structure_run, only: impact_event, is_listed, run_event_type, run_state_type, run_type, &
      simulate_structure, start_at, stick_event
   use vi_structure_settled, only: settle_structure
   use vi_structure_variation, only: start_tangent, tangent_type, through_event, to_state
   implicit none (type, external)
   private

   public :: new_simulated_structure

   !> The structure, where it is, and its directions.
   type, extends(simulated_motion_type), public :: simulated_structure_type
      type(run_type) :: run
      type(run_state_type) :: state
      !> (outputs, n) Outputs whose sizes are measured, as sums of the coordinates.
      real(wp), allocatable :: outputs(:, :)
      type(run_event_type), allocatable, private :: events(:)
      type(tangent_type), private :: tangent
      !> (directions) Logarithms of their growth in the present period, and what the impacts make of
      !! that of the volume; with stops or friction with what the damping makes of it.
      real(wp), allocatable, private :: logs(:)
      real(wp), private :: shrinking = 0
   contains
      procedure :: grow
      procedure :: examine
   end type simulated_structure_type

   !> Events simulated at a time.
   integer, parameter :: chunk = 64

contains

   !> A simulation that begins at a state.
   pure subroutine new_simulated_structure(run, start, state, left, motion, status)
      !> The structure under its load.
      type(run_type), intent(in) :: run
      !> Time at the start; (2n) coordinates and velocities.
      real(wp), intent(in) :: start, state(:)
      !> Number of events that it may have.
      integer, intent(in) :: left
      !> The simulation.
      type(simulated_structure_type), intent(out) :: motion
      !> As of `start_at`.
      integer, intent(out) :: status

      motion%run = run
      motion%left = left
      motion%period = run%period
      motion%unit = run%period
      motion%dimensions = size(state)
      associate (n => size(state)/2)
         allocate (motion%events(chunk), motion%outputs(0, n))
         call start_at(motion%run, start, state(:n), state(n + 1:), motion%state, status)
      end associate
   end subroutine new_simulated_structure

   !> Simulates whole periods of the load.
   subroutine grow(motion, cycles, growth, status, progress)
      !> In and out: the motion.
      class(simulated_structure_type), intent(inout) :: motion
      !> Periods.
      integer, intent(in) :: cycles
      !> In and out: the growth.
      type(growth_type), intent(inout) :: growth
      !> `stat%ok`, `stat%event_limit`, `stat%not_computed`, or a status of the simulation.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      integer :: i

      ! a rest in the transient may have lost directions that the attractor has
      if (growth%batch < 0 .or. (growth%batch == 0 .and. growth%rank < ubound(growth%sums, 2))) then
         motion%logs = growth%sums(1, 1:)
         call begin(motion%run, motion%state, motion%tangent, growth)
      end if
      status = stat%ok
      do i = 1, cycles
         motion%logs = 0
         motion%shrinking = 0
         call one_period(motion, growth, status, progress)
         if (status /= stat%ok) return
         call growth%add(motion%logs, 1.0_wp, i - 0.5_wp)
         associate (volume => motion%shrinking - merge(0.0_wp, 2*sum(motion%run%regimes(1)% &
            modes%damping)*motion%period, has_elements(motion)))
            growth%volume = growth%volume + volume
            growth%difference = growth%difference + sum(motion%logs) - volume
         end associate
         if (growth%rank < motion%dimensions) growth%difference = ieee_value(1.0_wp, ieee_quiet_nan)
         growth%time = growth%time + 1
      end do
   end subroutine grow

   !> Simulates a transient, and examines the load cycles after it.
   subroutine examine(motion, how, cell, progress)
      !> In: the motion, at load phase 0. Out: at the end of the last load cycle.
      class(simulated_structure_type), intent(inout) :: motion
      !> How it is examined.
      type(examination_type), intent(in) :: how
      !> In: empty. Out: what was found.
      type(cell_type), intent(inout) :: cell
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)

      call settle_structure(motion%run, motion%state, motion%outputs, how, cell, progress)
   end subroutine examine

   !> Directions at a state; none is along a single coordinate, which could be independent of all
   !! others.
   pure subroutine begin(run, state, tangent, growth)
      !> The run.
      type(run_type), intent(in) :: run
      !> The state.
      type(run_state_type), intent(in) :: state
      !> The directions.
      type(tangent_type), intent(out) :: tangent
      !> In and out: the growth, with the number of directions.
      type(growth_type), intent(inout) :: growth
      real(wp) :: p(2*size(run%structure%mass, 1), ubound(growth%sums, 2))
      real(wp) :: lengths(size(p, 2))
      integer :: i, j

      do j = 1, size(p, 2)
         do i = 1, size(p, 1)
            p(i, j) = cos(real(i*j, wp))
         end do
      end do
      call orthonormalise(p, lengths)
      call start_tangent(run, state, p, tangent)
      growth%rank = min(size(p, 2), free_directions(run%regimes(state%regime)))
   end subroutine begin

   !> Simulates a period of the load, and carries the directions along.
   subroutine one_period(motion, growth, status, progress)
      !> In and out: the motion.
      type(simulated_structure_type), intent(inout) :: motion
      !> In and out: the growth.
      type(growth_type), intent(inout) :: growth
      !> As of `grow`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      integer(int64) :: last
      real(wp) :: elapsed
      integer :: derivative, ended, i, n

      last = motion%state%cycle + 1
      elapsed = motion%state%elapsed
      do
         motion%state%bare = .true.
         call simulate_structure(motion%run, motion%state, last, elapsed, motion%events, n, ended, &
            .true.)
         motion%state%bare = .false.
         status = merge(stat%ok, ended, ended == stat%more_events)
         motion%left = motion%left - n
         do i = 1, n
            call follow(motion, motion%events(i), growth, derivative)
            if (status == stat%ok) status = derivative
         end do
         if (status == stat%ok .and. motion%left < 0) status = stat%event_limit
         if (is_stopped(progress)) status = stat%not_computed
         if (status /= stat%ok) return
         if (ended /= stat%more_events) exit
      end do
      if (has_elements(motion)) call add_damping(motion, motion%state%cycle, motion%state%elapsed)
      call to_state(motion%run, motion%state, motion%tangent)
      call measure(motion, growth%rank)
   end subroutine one_period

   !> Carries the directions through an event.
   subroutine follow(motion, event, growth, derivative)
      !> In and out: the motion.
      type(simulated_structure_type), intent(inout) :: motion
      !> The event.
      type(run_event_type), intent(in) :: event
      !> In and out: the growth.
      type(growth_type), intent(inout) :: growth
      !> `stat%ok`, or `stat%zero_approach` where an event of a structure with stops or friction
      !! that counts has no derivative.
      integer, intent(out) :: derivative
      real(wp) :: restitution, slope, factor
      integer :: status

      derivative = stat%ok
      if (has_elements(motion)) call add_damping(motion, event%cycle, event%elapsed)
      call through_event(motion%run, event, motion%tangent, status)
      if (has_elements(motion)) then
         if (growth%batch > 0 .or. status == stat%no_derivative) derivative = status
         factor = abs(motion%tangent%jump)
         if (factor > 0) motion%shrinking = motion%shrinking + log(factor)
         if (event%kind == impact_event .and. .not. factor > 0) growth%rank = min(growth%rank, &
            motion%dimensions - 1)
      else if (status == stat%no_derivative) then
         derivative = status
      else if (event%kind == impact_event .and. status == stat%ok) then
         call restitution_of(motion%run%structure, event%gap, event%speed, restitution, slope)
         factor = abs(restitution*(restitution + slope*event%speed))
         if (factor > 0) then
            motion%shrinking = motion%shrinking + log(factor)
         else
            growth%rank = min(growth%rank, motion%dimensions - 1)
         end if
      end if
      if (is_listed(event)) growth%impacts = growth%impacts + 1
      if (event%kind == stick_event) growth%rests = growth%rests + 1
      growth%rank = min(growth%rank, free_directions(motion%run%regimes(event%regime)))
      call measure(motion, growth%rank)
   end subroutine follow

   !> Whether the structure of a motion has stops or friction.
   pure logical function has_elements(motion)
      !> The motion.
      type(simulated_structure_type), intent(in) :: motion

      has_elements = motion%run%structure%has_stops .or. motion%run%structure%has_friction
   end function has_elements

   !> Number of directions in which a state of a regime can change: at rest there are fewer pairs,
   !! and of friction that sticks only the place is free.
   pure integer function free_directions(regime)
      !> The regime.
      type(regime_type), intent(in) :: regime

      free_directions = 2*size(regime%modes%stiffness) - (size(regime%held) - size(regime%resting))
   end function free_directions

   !> Adds what damping makes of the volume up to a time in the present regime.
   pure subroutine add_damping(motion, cycle, elapsed)
      !> In and out: the motion, whose tangent is at the beginning.
      type(simulated_structure_type), intent(inout) :: motion
      !> The time, as whole periods and the remainder.
      integer(int64), intent(in) :: cycle
      real(wp), intent(in) :: elapsed

      associate (tangent => motion%tangent)
         motion%shrinking = motion%shrinking - 2*sum(motion%run%regimes(tangent%number)% &
            modes%damping)*max(0.0_wp, real(cycle - tangent%cycle, wp)*motion%run%period &
            + (elapsed - tangent%elapsed))
      end associate
   end subroutine add_damping

   !> Adds the logarithms of the growth of the directions, and makes these orthonormal in the pairs
   !! of the structure without rest.
   subroutine measure(motion, rank)
      !> In and out: the motion.
      type(simulated_structure_type), intent(inout) :: motion
      !> Number of directions that are not lost.
      integer, intent(in) :: rank
      real(wp), allocatable :: p(:, :), free(:, :)
      real(wp) :: lengths(size(motion%logs))

      associate (d => motion%tangent%d, regimes => motion%run%regimes, at => motion%tangent%number)
         if (at == 1) then
            call orthonormalise(d, lengths)
         else
            allocate (p(motion%dimensions, size(d, 2)))
            allocate (free(2*size(regimes(1)%xq, 1), size(d, 2)))
            call to_coordinates(regimes(at), d, p)
            call from_coordinates(regimes(1), p, free)
            call orthonormalise(free, lengths)
            call to_coordinates(regimes(1), free, p)
            call from_coordinates(regimes(at), p, d)
            ! friction that sticks keeps its speed; what rounding leaves would not decay
            associate (held => regimes(at)%held, resting => regimes(at)%resting)
               d(size(d, 1) - (size(held) - size(resting)) + 1:, :) = 0
            end associate
         end if
      end associate
      motion%logs(:rank) = motion%logs(:rank) + log(max(lengths(:rank), tiny(1.0_wp)))
   end subroutine measure

end module vi_simulated_structure
