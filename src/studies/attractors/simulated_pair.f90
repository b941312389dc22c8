!> A simulation of the oscillator that goes on, through impacts, accumulations and rests, and chains
!! of such simulations.
!!
!! Four directions are carried from event to event by the exact derivatives and orthonormalised
!! after each. The sums of the logarithms of their lengths, over the time, are the exponents. They
!! belong to the map from impact to impact in (x, x', z', alpha), which has no direction along the
!! flow. They are therefore also the four exponents of the map over one load cycle.
!!
!! The contraction of volume is a check: the flux |y'| dx dx' dz' dalpha through a wall shrinks by
!! exp(-2 xi t) over a flight, and an impact multiplies dx' dz' by R, hence
!! |det P_i| = exp(-2 xi t) R u/v with the departure speed u at the start and the approach speed v
!! at the end of the flight. As u = R v at each impact, the sum of the logarithms telescopes to
!! -2 xi t + 2 sum(log R) + log(u_first/u_last).
module vi_simulated_pair
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_attractor_settled, only: settle_on
   use vi_attractor_tangent, only: departure_speed, event_derivative, lapse, restitution_at
   use vi_chains, only: chains_type
   use vi_exponents, only: orthonormalise
   use vi_forced_system, only: forced_system_type, event_type, impact_event, &
      initial_state, new_forced_system, release_event, state_type
   use vi_kinds, only: two_pi, wp
   use vi_oscillator, only: oscillator_type
   use vi_progress, only: is_stopped
   use vi_simulate, only: simulate_on
   use vi_simulated_motion, only: cell_type, examination_type, growth_type, simulated_motion_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: new_pair_chains, new_simulated_pair

   !> The oscillator, where it is, and its directions.
   type, extends(simulated_motion_type), public :: simulated_pair_type
      type(forced_system_type) :: system
      !> At the start of the last flight or rest, and at the end of the last load cycle.
      type(state_type) :: state, final
      !> The last event, its directions, and whether there is one.
      type(event_type), private :: event
      real(wp), private :: q(4, 4) = 0
      logical, private :: begun = .false.
   contains
      procedure :: grow
      procedure :: examine
   end type simulated_pair_type

   !> Chains of simulations of the oscillator.
   type, extends(chains_type), public :: pair_chains_type
      !> (6, links, chains) r, D, xi, mu, R1, R2; (5, chains) t, x, x', z, z' at the start.
      real(wp), allocatable :: parameters(:, :, :), starts(:, :)
      !> Load amplitude f.
      real(wp) :: load = 1
      !> Added to x' from link to link, over half the clearance, so that a sweep leaves unstable
      !! motions.
      real(wp) :: kick = 0
   contains
      procedure :: go_to
   end type pair_chains_type

   !> Events simulated at a time.
   integer, parameter :: chunk = 64

contains

   !> A simulation that begins at a state.
   pure function new_simulated_pair(system, state, left) result(motion)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state.
      type(state_type), intent(in) :: state
      !> Number of events that it may have.
      integer, intent(in) :: left
      type(simulated_pair_type) :: motion

      motion%system = system
      call begin(motion, state, left)
   end function new_simulated_pair

   !> Begins a simulation, once it has its system.
   pure subroutine begin(motion, state, left)
      !> In: with its system. Out: the simulation.
      class(simulated_pair_type), intent(inout) :: motion
      !> As of `new_simulated_pair`.
      type(state_type), intent(in) :: state
      integer, intent(in) :: left

      motion%state = state
      motion%final = state
      motion%left = left
      motion%period = two_pi/motion%system%r
      motion%dimensions = 4
   end subroutine begin

   !> Simulates whole load cycles; the transient without directions.
   subroutine grow(motion, cycles, growth, status, progress)
      !> In and out: the motion.
      class(simulated_pair_type), intent(inout) :: motion
      !> Load cycles.
      integer, intent(in) :: cycles
      !> In and out: the growth.
      type(growth_type), intent(inout) :: growth
      !> `stat%ok`, `stat%event_limit`, `stat%not_computed` or `stat%budget`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(event_type) :: events(chunk)
      integer(int64) :: first
      real(wp) :: phase
      integer :: i, n

      first = motion%final%cycle
      phase = motion%final%phase
      do
         call simulate_on(motion%system, motion%state, first + cycles, phase, events, n, &
            motion%final, motion%left, status, progress)
         do i = 1, merge(n, 0, growth%batch >= 0)
            call carry(motion, events(i), real(events(i)%cycle - first, wp) + (events(i)%phase - &
               phase)/two_pi, growth)
         end do
         if (is_stopped(progress)) status = stat%not_computed
         if (status /= stat%more_events) exit
      end do
   end subroutine grow

   !> Simulates a transient, and examines the load cycles after it.
   subroutine examine(motion, how, cell, progress)
      !> In: the motion. Out: at the end of the last load cycle.
      class(simulated_pair_type), intent(inout) :: motion
      !> How it is examined.
      type(examination_type), intent(in) :: how
      !> In: empty. Out: what was found.
      type(cell_type), intent(inout) :: cell
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)

      call settle_on(motion%system, motion%final, how, cell, progress)
      motion%state = motion%final
   end subroutine examine

   !> Chains of simulations; their parameters and starts are not set yet.
   pure function new_pair_chains(links, chains, load, kick) result(sweep)
      !> Numbers of links of each chain, and of chains.
      integer, intent(in) :: links, chains
      !> Load amplitude f, and as in `pair_chains_type`.
      real(wp), intent(in) :: load, kick
      type(pair_chains_type) :: sweep

      sweep%links = links
      sweep%chains = chains
      sweep%sizes = [1, 5, 7]
      sweep%load = load
      sweep%kick = kick
      allocate (sweep%parameters(6, links, chains), sweep%starts(5, chains))
   end function new_pair_chains

   !> Brings a simulation to a link: the free mass keeps its relative position between the walls.
   subroutine go_to(chains, link, chain, motion, status)
      !> The chains.
      class(pair_chains_type), intent(in) :: chains
      !> Numbers of the link and of the chain.
      integer, intent(in) :: link, chain
      !> In: the simulation at the link before, if there is one. Out: at this link.
      class(simulated_motion_type), allocatable, intent(inout) :: motion
      !> Out: `stat%ok`; a simulation that failed goes on, too.
      integer, intent(inout) :: status
      real(wp) :: before, half, y

      status = stat%ok
      if (.not. allocated(motion)) allocate (simulated_pair_type :: motion)
      select type (motion)
      type is (simulated_pair_type)
         before = motion%system%clearance
         ! in place: it holds large tables
         associate (c => chains%parameters(:, link, chain))
            motion%system = new_forced_system(oscillator_type(c(3), c(4), c(5:6)), c(1), &
               chains%load, c(2))
         end associate
         if (link == 1) then
            call begin(motion, initial_state(motion%system, chains%starts(:, chain)), 0)
            return
         end if
         associate (last => motion%final, system => motion%system, kick => chains%kick)
            half = 0.5_wp*system%clearance
            y = (last%z - last%x)*(system%clearance/before)
            if (last%side /= 0) y = last%side*half
            y = max(-half, min(half, y))
            call begin(motion, initial_state(system, [last%phase/system%r, last%x, last%x_dot + &
               kick*half, last%x + y, last%z_dot + merge(kick*half, 0.0_wp, last%side /= 0)]), 0)
         end associate
      end select
   end subroutine go_to

   !> Carries the directions to the next event and adds the logarithms of their growth.
   pure subroutine carry(motion, event, place, growth)
      !> In: at the previous event. Out: at this event.
      type(simulated_pair_type), intent(inout) :: motion
      !> The event.
      type(event_type), intent(in) :: event
      !> Load cycles from the beginning of the batch.
      real(wp), intent(in) :: place
      !> In and out: the growth.
      type(growth_type), intent(inout) :: growth
      real(wp) :: p(4, 4), lengths(4), logs(4)
      logical :: regular
      integer :: j

      if (.not. motion%begun) then
         motion%begun = .true.
         motion%q = reshape([(merge(1.0_wp, 0.0_wp, modulo(j, 5) == 0), j=0, 15)], [4, 4])
         motion%event = event
         return
      end if
      call event_derivative(motion%system, motion%event, event, p, regular)
      if (regular) then
         motion%q = matmul(p, motion%q)
         call orthonormalise(motion%q, lengths)
         if (event%kind == release_event) growth%rank = min(growth%rank, 2)
         if (event%kind == impact_event .and. .not. restitution_at(motion%system, event) > 0) then
            growth%rank = min(growth%rank, 3)
         end if
         logs = log(max(lengths, tiny(1.0_wp)))
         call growth%add(logs(:growth%rank), lapse(motion%system, motion%event, event), place)
         if (minval(lengths) > 0) call compare(motion, event, sum(logs), growth)
      end if
      growth%time = growth%time + lapse(motion%system, motion%event, event)
      if (event%kind == impact_event) growth%impacts = growth%impacts + 1
      if (event%kind == release_event) growth%rests = growth%rests + 1
      motion%event = event
   end subroutine carry

   !> Adds, over a flight, to the volume, and to the difference from the logarithms.
   pure subroutine compare(motion, event, total, growth)
      !> The motion, at the previous event.
      type(simulated_pair_type), intent(in) :: motion
      !> The impact that ends the flight.
      type(event_type), intent(in) :: event
      !> Sum of the logarithms of the growth of all directions over the flight.
      real(wp), intent(in) :: total
      !> In and out: the growth.
      type(growth_type), intent(inout) :: growth
      real(wp) :: speeds(2), restitution, volume

      if (event%kind /= impact_event .or. motion%event%kind == release_event) return
      restitution = restitution_at(motion%system, event)
      speeds = [departure_speed(motion%event), departure_speed(event)]
      if (.not. minval([restitution, speeds]) > 0) return
      volume = 2*log(restitution) + log(speeds(1)/speeds(2)) - 2*motion%system%osc%xi* &
         lapse(motion%system, motion%event, event)
      growth%volume = growth%volume + volume
      growth%difference = growth%difference + total - volume
   end subroutine compare

end module vi_simulated_pair
