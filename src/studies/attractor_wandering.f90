!> Attractors that are not periodic, distinguished by where their impacts lie.
module vi_attractor_wandering
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_attractor_basin, only: event_limited
   use vi_attractor_known, only: chaotic, known_type, quasi_periodic
   use vi_attractor_lyapunov, only: largest_exponent
   use vi_forced_system, only: forced_system_type, event_type, impact_event, initial_state, &
      state_type, two_pi
   use vi_kinds, only: wp
   use vi_simulate, only: simulate_on
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: separate_groups

   !> Largest number of such attractors.
   integer, parameter :: most_groups = 30
   !> Load cycles from which the largest Lyapunov exponent is computed, load cycles discarded before
   !! them, and number of batches.
   integer, parameter :: exponent_cycles = 4000, exponent_discard = 500, batches = 20
   !> The motion is chaotic if its largest exponent per load cycle exceeds this value.
   real(wp), parameter :: least_chaos = 2.0e-3_wp
   !> Number of cells of the phase, which is also that of x per clearance, and number of cells of x
   !! on either side of 0.
   integer, parameter :: cells = 24, reach = 240

   !> Numbers of impacts of an attractor in coarse cells (phase, x, wall).
   type, public :: group_type
      integer :: owner = 0
      integer :: hits(0:cells - 1, -reach:reach - 1, -1:1) = 0
   end type group_type

contains

   !> The attractor of a trajectory that does not repeat itself; it may be a new one.
   !!
   !! A trajectory is on a known attractor if most of its impacts are in cells of that one. The last
   !! impacts decide if they fit one attractor alone. Otherwise (there are few or none of them while
   !! the free mass is slow) a simulation as long as that of the known attractors decides.
   subroutine separate_groups(system, values, sides, known, groups, next, max_events, label, &
      progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Last impacts of the trajectory, as in `store_events`.
      real(wp), intent(in) :: values(:, :)
      !> (n) Walls of these impacts: +1 right, -1 left.
      integer, intent(in) :: sides(:)
      !> In: a state of the trajectory. Out: the attractor, if it is new.
      type(known_type), intent(inout) :: known
      !> In: cells of the attractors known so far. Out: with those of a new one.
      type(group_type), allocatable, intent(inout) :: groups(:)
      !> The number of a new attractor, and the largest number of events of a simulation.
      integer, intent(in) :: next, max_events
      !> Out: the number of the attractor, or `event_limited`; not changed if it cannot be
      !! determined.
      integer, intent(inout) :: label
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(group_type) :: own
      type(group_type), allocatable :: more(:)
      integer :: i, best, n, status

      do i = 1, size(sides)
         call mark(own, system, values(2, i), values(3, i), sides(i))
      end do
      call compare(own, groups, best, n)
      if (n /= 1) then
         own%owner = next
         own%hits = 0
         call find_cells(system, known%state, max_events, own, status, progress)
         if (status == stat%event_limit) label = event_limited
         if (status /= stat%ok) return
         call compare(own, groups, best, n)
      end if
      if (n > 0) then
         label = groups(best)%owner
         return
      end if
      if (size(groups) == most_groups) return
      call find_kind(system, max_events, known, status, progress)
      if (status == stat%event_limit) label = event_limited
      if (known%kind == 0) return
      label = next
      allocate (more(size(groups) + 1))
      more(:size(groups)) = groups
      more(size(more)) = own
      call move_alloc(more, groups)
   end subroutine separate_groups

   !> Compares a trajectory with the known attractors.
   pure subroutine compare(own, groups, best, n)
      !> Impacts of the trajectory.
      type(group_type), intent(in) :: own
      !> Impacts of the known attractors.
      type(group_type), intent(in) :: groups(:)
      !> Place of the attractor whose cells have most of them, and number of attractors whose cells
      !! have more than half of them.
      integer, intent(out) :: best, n
      integer :: shared(size(groups)), i

      do i = 1, size(groups)
         shared(i) = sum(own%hits, mask=groups(i)%hits > 0)
      end do
      best = maxloc(shared, 1)
      n = count(2*shared > sum(own%hits))
   end subroutine compare

   !> Marks the cell of an impact.
   pure subroutine mark(group, system, phase, x, side)
      !> In and out: the cells.
      type(group_type), intent(inout) :: group
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Load phase (rad), and position of the primary mass.
      real(wp), intent(in) :: phase, x
      !> Wall: +1 right, -1 left.
      integer, intent(in) :: side
      real(wp) :: place

      place = min(max(x*(cells/system%clearance), -real(reach, wp)), reach - 1.0_wp)
      associate (hits => group%hits(modulo(floor(phase*(cells/two_pi)), cells), floor(place), &
         side))
         hits = hits + 1
      end associate
   end subroutine mark

   !> The cells in which a long simulation has impacts.
   subroutine find_cells(system, start, max_events, group, status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> t, x, x', z, z'
      real(wp), intent(in) :: start(5)
      !> Largest number of events.
      integer, intent(in) :: max_events
      !> In and out: the cells.
      type(group_type), intent(inout) :: group
      !> As in `simulate_on`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(event_type) :: events(64)
      type(state_type) :: state, final
      integer(int64) :: last
      real(wp) :: phase
      integer :: n, i, left

      left = max_events
      state = initial_state(system, start)
      last = state%cycle + exponent_cycles
      phase = state%phase
      do
         call simulate_on(system, state, last, phase, events, n, final, left, status, progress)
         do i = 1, n
            if (events(i)%kind == impact_event) call mark(group, system, events(i)%phase, &
               events(i)%x, events(i)%side)
         end do
         if (status /= stat%more_events) exit
      end do
   end subroutine find_cells

   !> Whether a state is on a chaotic or a quasi-periodic attractor; kind 0 if it is on neither.
   subroutine find_kind(system, max_events, known, status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Largest number of events of the simulation.
      integer, intent(in) :: max_events
      !> In: with its state. Out: kind and largest exponent are set.
      type(known_type), intent(inout) :: known
      !> As in `lyapunov_points`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      real(wp) :: deviation

      known%kind = 0
      known%cycles = 0
      if (allocated(known%symbols)) deallocate (known%symbols)
      call largest_exponent(system, initial_state(system, known%state), exponent_discard, &
         exponent_cycles/batches, batches, max_events, known%largest, deviation, status, progress)
      if (status /= stat%ok) return                        ! for example, the impacts die out
      ! with a smaller exponent, the motion was a transient that has ended in the meantime
      if (known%largest > -least_chaos) known%kind = merge(chaotic, quasi_periodic, &
         known%largest > least_chaos)
   end subroutine find_kind

end module vi_attractor_wandering
