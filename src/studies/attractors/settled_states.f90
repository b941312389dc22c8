!> The motions on which states of a structure settle: periodic ones, and attractors that are not
!! periodic.
!!
!! Each state is simulated by itself until Newton's method confirms a stable motion there, or its
!! largest exponent says that it is chaotic or quasi-periodic. A chaotic transient looks the same
!! until it ends. So states with impacts in the same cells are watched together: they are on an
!! attractor if none of them settles in two million events. If one does, each of the others is
!! simulated until it settles, or for so long that it is left undecided.
module vi_settled_states
   use vi_attractor_cells, only: count_impact, group_type, new_group, owner_of
   use vi_exponents, only: average_type, cycles_to_settle, exponents_along, exponents_type, &
      negative, positive, sign_by_error, zero
   use vi_kinds, only: wp
   use vi_motion, only: no
   use vi_progress, only: add_done_work, add_expected_work, is_stopped
   use vi_simulated_structure, only: new_simulated_structure, simulated_structure_type
   use vi_status, only: stat
   use vi_structure, only: load_type, structure_type
   use vi_structure_found, only: add_motion, found_list_type
   use vi_structure_return, only: is_attractor, most_events, one_cycle, settle_on, settled_type
   use vi_structure_run, only: find_regime, is_listed, new_run, run_event_type, run_state_type, &
      run_type, start_at, state_now
   implicit none (type, external)
   private

   public :: settle_states

   !> How states are simulated.
   type, public :: settling_type
      !> Load cycles simulated first, most load cycles of a period, and events until it is given up.
      integer :: settling = 0, max_cycles = 1, max_events = huge(1)
      !> Number of OpenMP threads.
      integer :: threads = 1
      !> Whether a motion that seems chaotic or quasi-periodic is watched, as it may be a transient.
      logical :: watched = .true.
   end type settling_type

   !> What became of a state.
   type, public :: outcome_type
      !> The place of its motion in the list; 0 if there is none, or if it is not stable.
      integer :: label = 0
      !> The kind of a motion that is not periodic, with the status `stat%no_period`; otherwise 0.
      !! Its attractor among those that are not periodic; 0 if these were not distinguished.
      integer :: kind = 0, group = 0
      !> As of `settle_on`, and `stat%not_stable`.
      integer :: status = stat%not_computed
      !> For a motion that is not periodic: coordinates and velocities some load cycles later (2n),
      !! events that it may still have and its events per load cycle; 0 if nothing contracts, so
      !! that there are no transients.
      real(wp), allocatable, private :: finish(:)
      integer, private :: left = 0
      real(wp), private :: pace = 0
   end type outcome_type

   !> Kinds of motions that are not periodic.
   integer, parameter, public :: chaotic = 1, quasi_periodic = 2

   !> Load cycles of the first average of a state that is followed, which doubles from one to the
   !! next; those after which it is left undecided, with which an exponent may count as zero, and
   !! before which a motion does not count as settled; batches of an average.
   integer, parameter :: first_average = 1000, most_followed = 30000, zero_cycles = 8000, &
      least_cycles = 3000, batches = 20
   !> States of a set that is not periodic that are watched, their events altogether, and the most
   !! load cycles for which a state is watched.
   integer, parameter :: most_watched = 8, watched_cycles = 400000
   real(wp), parameter :: watched_events = 2.0e6_wp
   !> Load cycles whose events mark the cells of an attractor; events by which a motion is assigned
   !! to one, and the most load cycles until there are so many; most attractors that are not
   !! periodic.
   integer, parameter :: cell_cycles = 4000, sampled_events = 200, most_cell_cycles = 100000, &
      most_groups = 30
   !> States between which the list of motions is brought up to date.
   integer, parameter :: block = 512
   !> Least units of work that stand for the watch of motions that are not periodic.
   integer, parameter :: least_room = 8

   !> Greatest speed of events, and greatest |G_j.q| at events.
   type :: scales_type
      real(wp) :: speed = tiny(1.0_wp), place = tiny(1.0_wp)
   end type scales_type

contains

   !> The motion on which each of some states settles.
   subroutine settle_states(structure, load, start, states, how, list, outcomes, progress)
      !> The structure and its load, with a frequency > 0.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> Time at the start.
      real(wp), intent(in) :: start
      !> (2n, m) Coordinates and velocities.
      real(wp), intent(in) :: states(:, :)
      !> How they are simulated.
      type(settling_type), intent(in) :: how
      !> In and out: the motions that are known.
      type(found_list_type), intent(inout) :: list
      !> (m) What became of each.
      type(outcome_type), intent(out) :: outcomes(:)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(run_type) :: run
      integer :: first, i, ready, room

      ! how long motions must be watched is not known before: the bar leaves room for it
      room = 0
      if (how%watched) room = max(least_room, size(outcomes)/8)
      call add_expected_work(size(outcomes) + room, progress)
      call new_run(structure, load, run, ready)
      if (ready /= stat%ok) outcomes%status = ready
      if (ready /= stat%ok) return
      do i = 1, size(outcomes)
         outcomes(i)%finish = states(:, i)
         outcomes(i)%left = how%max_events
      end do
      do first = 1, size(outcomes), block
         call settle_each(structure, load, run, start, how, [(i, i=first, min(first + block - 1, &
            size(outcomes)))], 0, list, outcomes, progress)
      end do
      if (how%watched) call watch_wanderers(structure, load, run, start, how, list, outcomes, &
         progress)
      call add_done_work(room, progress)
   end subroutine settle_states

   !> Simulates some of the states, and adds the motions on which they settle to the list.
   subroutine settle_each(structure, load, run, start, how, members, cycles, list, outcomes, &
      progress)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> The structure under its load.
      type(run_type), intent(in) :: run
      !> Time at the start.
      real(wp), intent(in) :: start
      !> How they are simulated.
      type(settling_type), intent(in) :: how
      !> The numbers of the states, in ascending order.
      integer, intent(in) :: members(:)
      !> Load cycles for which they are simulated again; 0 for the first time.
      integer, intent(in) :: cycles
      !> In and out: the motions that are known.
      type(found_list_type), intent(inout) :: list
      !> In and out: what became of each state.
      type(outcome_type), intent(inout) :: outcomes(:)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(settled_type), allocatable :: found(:)
      integer :: i

      allocate (found(size(members)))
      !$omp parallel do schedule(dynamic, 1) num_threads(how%threads)
      do i = 1, size(members)
         if (is_stopped(progress)) cycle
         if (cycles == 0) then
            call settle_one(structure, run, start, how, found(i), outcomes(members(i)), progress)
         else
            call go_on(structure, run, start, how, cycles, found(i), outcomes(members(i)), progress)
         end if
         call add_done_work(1, progress)
      end do
      !$omp end parallel do
      do i = 1, size(members)
         call register(structure, load, found(i), list, outcomes(members(i)))
      end do
   end subroutine settle_each

   !> Adds the motion on which a state has settled to the list.
   pure subroutine register(structure, load, found, list, outcome)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> The motion.
      type(settled_type), intent(in) :: found
      !> In and out: the motions that are known.
      type(found_list_type), intent(inout) :: list
      !> In and out: what became of the state.
      type(outcome_type), intent(inout) :: outcome

      if (outcome%status /= stat%ok) return
      call add_motion(structure, load, found, list, outcome%label)
      if (outcome%label == 0 .or. found%motion%verdicts%stable /= no) return
      outcome%label = 0
      outcome%status = stat%not_stable
   end subroutine register

   !> The motion on which a state settles.
   subroutine settle_one(structure, run, start, how, found, outcome, progress)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The structure under its load.
      type(run_type), intent(in) :: run
      !> Time at the start.
      real(wp), intent(in) :: start
      !> How it is simulated.
      type(settling_type), intent(in) :: how
      !> The motion.
      type(settled_type), intent(out) :: found
      !> In: with the state. Out: what became of it.
      type(outcome_type), intent(inout) :: outcome
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(run_type) :: own
      real(wp) :: state(size(outcome%finish))
      integer :: n

      n = size(state)/2
      ! a copy, since regimes are added
      own = run
      state = outcome%finish
      call settle_on(structure, own, start, state(:n), state(n + 1:), how%settling, &
         how%max_cycles, 0, .true., how%max_events, found, outcome%status, progress, outcome%finish)
      if (is_decided(found, outcome%status)) return
      call follow_on(structure, own, start, how, found, outcome, progress)
   end subroutine settle_one

   !> Whether the motion on which a simulation settles is known, or the simulation cannot continue.
   pure logical function is_decided(found, status)
      !> The motion.
      type(settled_type), intent(in) :: found
      !> As of `settle_on`.
      integer, intent(in) :: status

      if (status == stat%ok) then
         is_decided = is_attractor(found)
      else
         is_decided = .not. any(status == [stat%no_period, stat%no_convergence, stat%singular, &
            stat%no_motion])
      end if
   end function is_decided

   !> Simulates a state on which nothing is decided for some more load cycles.
   subroutine go_on(structure, run, start, how, cycles, found, outcome, progress)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The structure under its load.
      type(run_type), intent(in) :: run
      !> Time at the start.
      real(wp), intent(in) :: start
      !> How it is simulated.
      type(settling_type), intent(in) :: how
      !> Load cycles, and a few periods more.
      integer, intent(in) :: cycles
      !> The motion, if it settles.
      type(settled_type), intent(out) :: found
      !> In and out: what became of it; without a kind if it settles or cannot continue.
      type(outcome_type), intent(inout) :: outcome
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(run_type) :: own
      real(wp) :: state(size(outcome%finish))
      integer :: n, status

      n = size(state)/2
      own = run
      state = outcome%finish
      call settle_on(structure, own, start, state(:n), state(n + 1:), cycles, how%max_cycles, 0, &
         .true., max(0, outcome%left), found, status, progress, outcome%finish)
      outcome%left = outcome%left - nint(min(0.5_wp*huge(1), outcome%pace*cycles))
      ! one that was stopped was reached before, and stays undecided
      if (status == stat%not_computed .or. .not. is_decided(found, status)) return
      outcome%status = status
      outcome%kind = 0
   end subroutine go_on

   !> Watches motions that seem chaotic or quasi-periodic, one set at a time.
   subroutine watch_wanderers(structure, load, run, start, how, list, outcomes, progress)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> The structure under its load.
      type(run_type), intent(in) :: run
      !> Time at the start.
      real(wp), intent(in) :: start
      !> How states are simulated.
      type(settling_type), intent(in) :: how
      !> In and out: the motions that are known.
      type(found_list_type), intent(inout) :: list
      !> In and out: what became of each state.
      type(outcome_type), intent(inout) :: outcomes(:)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(scales_type) :: scales
      integer, allocatable :: members(:), peers(:)
      integer :: i, n
      logical :: transient

      n = 0
      do
         members = pack([(i, i=1, size(outcomes))], outcomes%kind > 0 .and. outcomes%group == 0 &
            .and. outcomes%pace > 0)
         if (size(members) == 0) return
         if (is_stopped(progress)) exit
         if (n == most_groups) exit
         if (n == 0) call measure_scales(run, start, outcomes(members(1)), scales)
         call find_peers(run, start, how, scales, members, outcomes, peers)
         call watch(structure, load, run, start, how, peers, list, outcomes, transient, progress)
         if (is_stopped(progress)) exit
         peers = pack(peers, outcomes(peers)%kind > 0)
         if (transient) then
            outcomes(peers)%kind = 0
         else
            n = n + 1
            outcomes(peers)%group = n
         end if
      end do
      ! they are left undecided
      outcomes(members)%kind = 0
   end subroutine watch_wanderers

   !> The motions whose events lie in the cells of the first one, with this itself.
   subroutine find_peers(run, start, how, scales, members, outcomes, peers)
      !> The structure under its load.
      type(run_type), intent(in) :: run
      !> Time at the start.
      real(wp), intent(in) :: start
      !> How states are simulated.
      type(settling_type), intent(in) :: how
      !> Units of the speeds and places of events.
      type(scales_type), intent(in) :: scales
      !> Numbers of the motions.
      integer, intent(in) :: members(:)
      !> In and out: what became of each state.
      type(outcome_type), intent(inout) :: outcomes(:)
      !> Numbers of those found.
      integer, allocatable, intent(out) :: peers(:)
      type(group_type) :: first(1), other
      integer :: i, owner(size(members))

      call mark_cells(run, start, cell_cycles, scales, outcomes(members(1)), first(1))
      first%owner = 1
      owner(1) = 1
      !$omp parallel do schedule(dynamic, 1) num_threads(how%threads) private(other)
      do i = 2, size(members)
         call mark_cells(run, start, cycles_of_sample(outcomes(members(i))), scales, &
            outcomes(members(i)), other)
         owner(i) = owner_of(other, first)
      end do
      !$omp end parallel do
      peers = pack(members, owner == 1)
   end subroutine find_peers

   !> Watches motions with events in the same cells.
   !!
   !! A transient ends at random, so that several motions together show it as well as one does that
   !! is watched for as long.
   subroutine watch(structure, load, run, start, how, peers, list, outcomes, transient, progress)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> The structure under its load.
      type(run_type), intent(in) :: run
      !> Time at the start.
      real(wp), intent(in) :: start
      !> How states are simulated.
      type(settling_type), intent(in) :: how
      !> Numbers of the motions.
      integer, intent(in) :: peers(:)
      !> In and out: the motions that are known.
      type(found_list_type), intent(inout) :: list
      !> In and out: what became of each state; without a kind if it has settled.
      type(outcome_type), intent(inout) :: outcomes(:)
      !> Whether one has settled.
      logical, intent(out) :: transient
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      integer, allocatable :: watched(:)
      integer :: chunk, spent, total

      allocate (watched, source=peers(:min(size(peers), most_watched)))
      total = ceiling(min(real(watched_cycles, wp), watched_events/outcomes(peers(1))%pace/ &
         size(watched)))
      chunk = first_average
      spent = 0
      transient = .false.
      do while (spent < total .and. size(watched) > 0)
         chunk = min(chunk, total - spent)
         call add_expected_work(size(watched), progress)
         call settle_each(structure, load, run, start, how, watched, chunk, list, outcomes, &
            progress)
         if (is_stopped(progress)) return
         spent = spent + chunk
         if (.not. transient .and. any(outcomes(watched)%kind == 0)) then
            transient = .true.
            ! the others may leave it likewise
            watched = peers
            total = watched_cycles
            spent = 0
            chunk = first_average
         else
            chunk = 2*chunk
         end if
         watched = pack(watched, outcomes(watched)%kind > 0)
      end do
   end subroutine watch

   !> Load cycles of the events by which a motion is assigned to an attractor.
   pure integer function cycles_of_sample(outcome) result(cycles)
      !> What became of a state.
      type(outcome_type), intent(in) :: outcome

      cycles = ceiling(min(real(cell_cycles, wp), sampled_events/outcome%pace))
   end function cycles_of_sample

   !> The greatest speed and place of events of a motion.
   subroutine measure_scales(run, start, outcome, scales)
      !> The structure under its load.
      type(run_type), intent(in) :: run
      !> Time at the start.
      real(wp), intent(in) :: start
      !> What became of a state.
      type(outcome_type), intent(in) :: outcome
      !> Their sizes.
      type(scales_type), intent(out) :: scales
      type(outcome_type) :: other
      type(group_type) :: unused

      other = outcome
      call mark_cells(run, start, cycles_of_sample(outcome), scales_type(1.0_wp, 1.0_wp), other, &
         unused, scales)
   end subroutine measure_scales

   !> Simulates some load cycles, or more if there are few events, and marks the cells of these.
   subroutine mark_cells(run, start, cycles, scales, outcome, own, greatest)
      !> The structure under its load.
      type(run_type), intent(in) :: run
      !> Time at the start.
      real(wp), intent(in) :: start
      !> Load cycles.
      integer, intent(in) :: cycles
      !> Units of the speeds and places.
      type(scales_type), intent(in) :: scales
      !> In and out: with the state, which is advanced.
      type(outcome_type), intent(inout) :: outcome
      !> The cells.
      type(group_type), intent(out) :: own
      !> In and out: the greatest speed and place so far.
      type(scales_type), intent(inout), optional :: greatest
      type(run_type) :: mine
      type(run_state_type) :: state
      type(run_event_type), allocatable :: events(:)
      real(wp) :: elapsed, place
      integer :: i, j, n, events_here, marked, status

      marked = 0
      n = size(outcome%finish)/2
      own = new_group([1, size(run%structure%openings)])
      mine = run
      allocate (events(most_events))
      call start_at(mine, start, outcome%finish(:n), outcome%finish(n + 1:), state, status)
      if (status /= stat%ok) return
      elapsed = state%elapsed
      do j = 1, most_cell_cycles
         if (j > cycles .and. marked >= sampled_events) exit
         call one_cycle(mine, state, 1, elapsed, events, events_here, status)
         if (status /= stat%ok) return
         do i = 1, events_here
            if (.not. is_listed(events(i))) cycle
            marked = marked + 1
            place = dot_product(run%structure%directions(:, events(i)%gap), events(i)%q)
            call count_impact(own, run%load%frequency*events(i)%elapsed, events(i)%speed/ &
               scales%speed + place/scales%place, events(i)%gap)
            if (.not. present(greatest)) cycle
            greatest%speed = max(greatest%speed, abs(events(i)%speed))
            greatest%place = max(greatest%place, abs(place))
         end do
      end do
      call state_now(mine, state, outcome%finish(:n), outcome%finish(n + 1:))
      outcome%left = outcome%left - marked
   end subroutine mark_cells

   !> Follows a state on which nothing is decided yet: its motion is chaotic if the largest exponent
   !! is positive by its error, and quasi-periodic if that is zero by its error and no stable motion
   !! is near. If it is negative, the motion settles.
   !!
   !! There is no kind until the motion has gone on for as long as transients may last; the slowest
   !! vibration may be one with a gap at rest.
   subroutine follow_on(structure, run, start, how, found, outcome, progress)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The structure under its load; regimes are added.
      type(run_type), intent(inout) :: run
      !> Time at the start.
      real(wp), intent(in) :: start
      !> How it was simulated.
      type(settling_type), intent(in) :: how
      !> In and out: the motion.
      type(settled_type), intent(inout) :: found
      !> In and out: what became of it, with the state, which is advanced.
      type(outcome_type), intent(inout) :: outcome
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> Differences below which a state counts as one that repeats: as usual, and where a motion is
      !! still being approached.
      real(wp), parameter :: usual = 1.0e-4_wp, loose = 1.0e-2_wp
      !> A contraction per load cycle below this is rounding.
      real(wp), parameter :: rounding = 1.0e-12_wp
      type(exponents_type) :: average
      type(simulated_structure_type) :: motion
      real(wp) :: here(size(outcome%finish)), slowest
      integer :: cycles, least, n, settling, sign_of_it, spent, ended

      call find_slowest(run, slowest)
      settling = 0
      n = size(here)/2
      cycles = first_average
      spent = how%settling
      associate (state => outcome%finish, left => outcome%left, kind => outcome%kind)
         do while (spent + cycles <= how%settling + most_followed)
            call new_simulated_structure(run, start, state, left, motion, ended)
            if (ended == stat%ok) call exponents_along(motion, average_type(0, cycles/batches, &
               batches, 1), average, ended, progress)
            if (ended /= stat%ok) exit
            call state_now(motion%run, motion%state, state(:n), state(n + 1:))
            spent = spent + cycles
            outcome%pace = 0
            if (average%contraction*average%period > rounding) outcome%pace = &
               real(left - motion%left, wp)/cycles
            left = motion%left
            sign_of_it = sign_by_error(average%exponents(1)*average%period, &
               average%deviations(1)*average%period, cycles)
            least = max(least_cycles, cycles_to_settle(average%contraction*average%period, &
               slowest*average%period))
            if (spent >= least .and. sign_of_it == positive) kind = chaotic
            outcome%status = stat%no_period
            if (kind > 0) return
            here = state
            call settle_on(structure, run, start, here(:n), here(n + 1:), 0, how%max_cycles, 0, &
               .false., left, found, outcome%status, progress, state, merge(loose, usual, &
               sign_of_it == negative))
            spent = spent + 2*how%max_cycles
            if (is_decided(found, outcome%status)) return
            ! it settles on what is not looked for, such as a longer period
            if (sign_of_it == negative .and. spent >= least) settling = settling + 1
            if (settling == 2) exit
            if (outcome%status == stat%no_period .and. sign_of_it == zero .and. cycles >= &
               zero_cycles .and. spent >= least) then
               kind = quasi_periodic
               return
            end if
            cycles = 2*cycles
         end do
      end associate
      if (any(ended == [stat%event_limit, stat%not_computed])) outcome%status = ended
   end subroutine follow_on

   !> The rate at which the slowest damped vibration decays, without rest and with each gap at rest.
   pure subroutine find_slowest(run, slowest)
      !> The structure under its load; regimes are added.
      type(run_type), intent(inout) :: run
      !> The rate; 0 if nothing is damped.
      real(wp), intent(out) :: slowest
      real(wp) :: fast
      integer :: i, j, status

      do i = 1, size(run%structure%openings)
         ! a rest that is refused does not happen
         call find_regime(run, [i], j, status)
      end do
      slowest = huge(slowest)
      do i = 1, size(run%regimes)
         if (.not. allocated(run%regimes(i)%closed)) exit
         associate (modes => run%regimes(i)%modes)
            do j = 1, size(modes%damping)
               ! rounding alone damps nothing
               if (.not. modes%stiffness(j) > 0 .or. .not. modes%damping(j) > 1.0e-12_wp* &
                  modes%omega(j)) cycle
               fast = modes%damping(j) + sqrt(max(0.0_wp, modes%damping(j)**2 - &
                  modes%stiffness(j)))
               slowest = min(slowest, modes%damping(j), modes%stiffness(j)/fast)
            end do
         end associate
      end do
      if (slowest >= huge(slowest)) slowest = 0
   end subroutine find_slowest

end module vi_settled_states
