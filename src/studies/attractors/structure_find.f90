!> Periodic motions of a structure: those on which states settle, and those of all orders of a few
!! impacts.
module vi_structure_find
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_exponents, only: average_type, cycles_to_settle, exponents_along, exponents_type, &
      negative, positive, sign_by_error, zero
   use vi_kinds, only: two_pi, wp
   use vi_motion, only: no
   use vi_philox, only: philox
   use vi_progress, only: add_done_work, add_expected_work, is_stopped
   use vi_restitution, only: table_law
   use vi_simulated_structure, only: new_simulated_structure, simulated_structure_type
   use vi_status, only: stat
   use vi_structure, only: load_type, structure_type
   use vi_structure_found, only: add_motion, found_list_type
   use vi_structure_period, only: exact, periodic_structure
   use vi_structure_return, only: is_attractor, settle_on, settled_type
   use vi_structure_run, only: find_regime, new_run, run_event_type, run_state_type, run_type, &
      simulate_structure, start_at, state_now
   implicit none (type, external)
   private

   public :: count_orders, open_gaps, random_structure_states, search_orders, settle_states

   !> How states are simulated.
   type, public :: settling_type
      !> Load cycles simulated first, most load cycles of a period, and events until it is given up.
      integer :: settling = 0, max_cycles = 1, max_events = huge(1)
      !> Number of OpenMP threads.
      integer :: threads = 1
   end type settling_type

   !> Which orders of impacts are tried.
   type, public :: orders_type
      !> Most impacts and load cycles, sets of impact times for each order and number of cycles.
      integer :: max_impacts = 0, max_cycles = 1, guesses = 1
      !> Seed of the times; number of OpenMP threads.
      integer :: seed = 0, threads = 1
   end type orders_type

   !> Kinds of motions that are not periodic.
   integer, parameter, public :: chaotic = 1, quasi_periodic = 2

   !> Load cycles of the first average of a state that is followed, which doubles from one to the
   !! next; those after which it is left undecided, with which an exponent may count as zero, and
   !! before which a motion does not count as settled; batches of an average.
   integer, parameter :: first_average = 1000, most_followed = 30000, zero_cycles = 8000, &
      least_cycles = 3000, batches = 20
   !> Tasks between which the list of motions is brought up to date.
   integer, parameter :: block = 512

contains

   !> The motion on which each of some states settles.
   subroutine settle_states(structure, load, start, states, how, list, labels, kinds, status, &
      progress)
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
      !> (m) The place of the motion in the list; 0 if there is none, or if it is not stable.
      integer, intent(out) :: labels(:)
      !> (m) The kind of a motion that is not periodic, with the status `stat%no_period`; otherwise
      !! 0.
      integer, intent(out) :: kinds(:)
      !> (m) As of `settle_on`, and `stat%not_stable`.
      integer, intent(out) :: status(:)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(run_type) :: run
      type(settled_type), allocatable :: found(:)
      integer :: first, i, last, ready

      labels = 0
      kinds = 0
      status = stat%not_computed
      call add_expected_work(size(labels), progress)
      call new_run(structure, load, run, ready)
      if (ready /= stat%ok) status = ready
      if (ready /= stat%ok) return
      do first = 1, size(labels), block
         last = min(first + block - 1, size(labels))
         if (allocated(found)) deallocate (found)
         allocate (found(first:last))
         !$omp parallel do schedule(dynamic, 1) num_threads(how%threads)
         do i = first, last
            if (.not. is_stopped(progress)) call settle_one(structure, run, start, states(:, i), &
               how, found(i), kinds(i), status(i), progress)
            call add_done_work(1, progress)
         end do
         !$omp end parallel do
         do i = first, last
            if (status(i) /= stat%ok) cycle
            call add_motion(structure, load, found(i), list, labels(i))
            if (labels(i) == 0 .or. found(i)%motion%verdicts%stable /= no) cycle
            labels(i) = 0
            status(i) = stat%not_stable
         end do
      end do
   end subroutine settle_states

   !> The motion on which a state settles.
   subroutine settle_one(structure, run, start, state, how, found, kind, status, progress)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The structure under its load.
      type(run_type), intent(in) :: run
      !> Time at the start; (2n) coordinates and velocities.
      real(wp), intent(in) :: start, state(:)
      !> How it is simulated.
      type(settling_type), intent(in) :: how
      !> The motion.
      type(settled_type), intent(out) :: found
      !> As of `settle_states`.
      integer, intent(out) :: kind
      !> As of `settle_on`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(run_type) :: own
      real(wp) :: finish(size(state))
      integer :: n

      kind = 0
      n = size(state)/2
      ! a copy, since regimes are added
      own = run
      finish = state
      call settle_on(structure, own, start, state(:n), state(n + 1:), how%settling, &
         how%max_cycles, 0, .true., how%max_events, found, status, progress, finish)
      if (is_decided(found, status)) return
      call follow_on(structure, own, start, finish, how, found, kind, status, progress)
   end subroutine settle_one

   !> Whether it is known on what a simulation settles, or that it cannot go on.
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

   !> Follows a state on which nothing is decided yet: its motion is chaotic if the largest exponent
   !! is positive by its error, and quasi-periodic if that is zero by its error and no stable motion
   !! is near. A negative one tells that it settles.
   !!
   !! There is no kind until the motion has gone on for as long as transients may last; the slowest
   !! vibration may be one with a gap at rest.
   subroutine follow_on(structure, run, start, state, how, found, kind, status, progress)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The structure under its load; regimes are added.
      type(run_type), intent(inout) :: run
      !> Time at the start.
      real(wp), intent(in) :: start
      !> (2n) In: coordinates and velocities. Out: whole load cycles later.
      real(wp), intent(inout) :: state(:)
      !> How it was simulated.
      type(settling_type), intent(in) :: how
      !> In and out: the motion.
      type(settled_type), intent(inout) :: found
      !> As of `settle_states`.
      integer, intent(out) :: kind
      !> In and out: as of `settle_on`; of the last simulation.
      integer, intent(inout) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> How nearly a motion repeats that is approached.
      real(wp), parameter :: usual = 1.0e-4_wp, loose = 1.0e-2_wp
      type(exponents_type) :: average
      type(simulated_structure_type) :: motion
      real(wp) :: here(size(state)), slowest
      integer :: cycles, least, left, n, settling, sign_of_it, spent, ended

      kind = 0
      call find_slowest(run, slowest)
      settling = 0
      n = size(state)/2
      cycles = first_average
      spent = how%settling
      left = how%max_events
      do while (spent + cycles <= how%settling + most_followed)
         call new_simulated_structure(run, start, state, left, motion, ended)
         if (ended == stat%ok) call exponents_along(motion, average_type(0, cycles/batches, &
            batches, 1), average, ended, progress)
         if (ended /= stat%ok) exit
         call state_now(motion%run, motion%state, state(:n), state(n + 1:))
         spent = spent + cycles
         left = motion%left
         sign_of_it = sign_by_error(average%exponents(1)*average%period, average%deviations(1)* &
            average%period, cycles)
         least = max(least_cycles, cycles_to_settle(average%contraction*average%period, &
            slowest*average%period))
         if (spent >= least .and. sign_of_it == positive) kind = chaotic
         status = stat%no_period
         if (kind > 0) return
         here = state
         call settle_on(structure, run, start, here(:n), here(n + 1:), 0, how%max_cycles, 0, &
            .false., left, found, status, progress, state, merge(loose, usual, sign_of_it == &
            negative))
         spent = spent + 2*how%max_cycles
         if (is_decided(found, status)) return
         ! it settles on what is not looked for, such as a longer period
         if (sign_of_it == negative .and. spent >= least) settling = settling + 1
         if (settling == 2) exit
         if (status == stat%no_period .and. sign_of_it == zero .and. cycles >= zero_cycles .and. &
            spent >= least) then
            kind = quasi_periodic
            status = stat%no_period
            return
         end if
         cycles = 2*cycles
      end do
      if (any(ended == [stat%event_limit, stat%not_computed])) status = ended
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

   !> Newton's method from random impact times, for all orders of a few impacts.
   subroutine search_orders(structure, load, how, list, failures, progress)
      !> The structure and its load, with a frequency > 0.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> Which orders.
      type(orders_type), intent(in) :: how
      !> In and out: the motions that are known.
      type(found_list_type), intent(inout) :: list
      !> (0:) In and out: how often each status occurred.
      integer, intent(inout) :: failures(0:)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(settled_type), allocatable :: found(:)
      integer, allocatable :: orders(:, :), lengths(:), status(:)
      integer :: first, i, last, order, place, tasks

      call list_orders(size(structure%openings), how%max_impacts, orders, lengths)
      tasks = size(lengths)*how%max_cycles*how%guesses
      call add_expected_work(tasks, progress)
      do first = 1, tasks, block
         last = min(first + block - 1, tasks)
         if (allocated(found)) deallocate (found, status)
         allocate (found(first:last), status(first:last))
         status = stat%not_computed
         !$omp parallel do schedule(dynamic, 1) num_threads(how%threads) private(order)
         do i = first, last
            order = (i - 1)/(how%max_cycles*how%guesses) + 1
            if (.not. is_stopped(progress)) call try_order(structure, load, &
               orders(:lengths(order), order), modulo((i - 1)/how%guesses, how%max_cycles) + 1, &
               how%seed, i, found(i), status(i))
            call add_done_work(1, progress)
         end do
         !$omp end parallel do
         do i = first, last
            failures(status(i)) = failures(status(i)) + 1
            if (status(i) == stat%ok) call add_motion(structure, load, found(i), list, place)
         end do
         if (is_stopped(progress)) return
      end do
   end subroutine search_orders

   !> The motion of an order of impacts near random times.
   pure subroutine try_order(structure, load, gaps, cycles, seed, task, found, status)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> The gaps of the impacts; load cycles in a period.
      integer, intent(in) :: gaps(:), cycles
      !> Seed of the times, and number of the task.
      integer, intent(in) :: seed, task
      !> The motion.
      type(settled_type), intent(out) :: found
      !> As of `periodic_structure`.
      integer, intent(out) :: status
      type(structure_type) :: own
      real(wp) :: phases(size(gaps)), one
      integer :: i, j

      do i = 1, size(gaps)
         one = two_pi*cycles*uniform(seed, 1, task, i)
         ! in ascending order
         do j = i - 1, 1, -1
            if (phases(j) <= one) exit
            phases(j + 1) = phases(j)
         end do
         phases(j + 1) = one
      end do
      own = structure
      found%gaps = gaps
      found%cycles = cycles
      allocate (found%resting(0), found%rests(2, 0))
      call periodic_structure(own, load, gaps, phases, cycles, exact, found%motion, status)
   end subroutine try_order

   !> Number of orders of at most `most` impacts up to rotation: the necklaces of Moreau.
   pure real(wp) function count_orders(gaps, most) result(number)
      !> Numbers of gaps, and of impacts.
      integer, intent(in) :: gaps, most
      real(wp) :: words(most)
      integer :: d, n

      number = 0
      do n = 1, most
         ! words that do not repeat a shorter one, each of which has n rotations
         words(n) = real(gaps, wp)**n
         do d = 1, n - 1
            if (modulo(n, d) == 0) words(n) = words(n) - words(d)
         end do
         ! and those that repeat one of them
         number = number + words(n)/n*(most/n)
      end do
   end function count_orders

   !> All orders of impacts up to rotation. Of those that repeat a shorter one, as after a flip, the
   !! times do not.
   pure subroutine list_orders(gaps, most, orders, lengths)
      !> Numbers of gaps, and of impacts.
      integer, intent(in) :: gaps, most
      !> (most, orders) The gaps of each.
      integer, allocatable, intent(out) :: orders(:, :)
      !> (orders) Number of impacts of each.
      integer, allocatable, intent(out) :: lengths(:)
      integer :: i, n, number, word(most)

      number = nint(count_orders(gaps, most))
      allocate (orders(most, number), lengths(number))
      number = 0
      do n = 1, most
         word = 1
         do
            if (is_first(word(:n))) then
               number = number + 1
               orders(:, number) = word
               lengths(number) = n
            end if
            ! the next word, the last gap fastest
            do i = n, 1, -1
               word(i) = word(i) + 1
               if (word(i) <= gaps) exit
               word(i) = 1
            end do
            if (i == 0) exit
         end do
      end do
   end subroutine list_orders

   !> Whether none of the rotations of a word comes before it.
   pure logical function is_first(word)
      !> The word.
      integer, intent(in) :: word(:)
      integer :: turned(size(word)), i, j

      is_first = .true.
      do i = 1, size(word) - 1
         turned = cshift(word, i)
         j = findloc(turned /= word, .true., 1)
         if (j > 0) is_first = turned(j) > word(j)
         if (.not. is_first) return
      end do
   end function is_first

   !> Rest, and random states of the size of a simulated motion from rest, with all gaps open.
   pure subroutine random_structure_states(structure, load, seed, states, status)
      !> The structure and its load, with a frequency > 0.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> Seed of the states; each depends on it and its number only.
      integer, intent(in) :: seed
      !> (2n, m) Coordinates and velocities.
      real(wp), intent(out) :: states(:, :)
      !> `stat%ok`, or `stat%gap_closed` where a gap is closed at q = 0.
      integer, intent(out) :: status
      real(wp) :: sizes(size(states, 1)), span
      integer :: i, j, n

      n = size(states, 1)/2
      states = 0
      status = merge(stat%gap_closed, stat%ok, any(structure%openings < 0 .and. &
         structure%laws%kind <= table_law))
      if (status /= stat%ok .or. size(states, 2) < 2) return
      call reached_sizes(structure, load, sizes)
      sizes(:n) = sizes(:n) + 1.0e-3_wp*maxval(sizes(:n))
      sizes(n + 1:) = sizes(n + 1:) + 1.0e-3_wp*maxval(sizes(n + 1:))
      span = max(0.0_wp, maxval(structure%openings))
      sizes(:n) = sizes(:n) + span
      sizes(n + 1:) = sizes(n + 1:) + span*load%frequency
      do i = 2, size(states, 2)
         do j = 1, 2*n
            states(j, i) = 0.7_wp*sizes(j)*sqrt(-2*log(uniform(seed, 2, i, j)))* &
               cos(two_pi*uniform(seed, 3, i, j))
         end do
         call open_gaps(structure, states(:n, i))
      end do
   end subroutine random_structure_states

   !> Moves coordinates towards q = 0, as far as needed to open all gaps, if they are open there.
   pure subroutine open_gaps(structure, q)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> (n) In and out: the coordinates.
      real(wp), intent(inout) :: q(:)
      !> Share of the size of a gap that is rounding, as of a gap at rest.
      real(wp), parameter :: rounding = 1.0e-13_wp
      real(wp) :: closing, share
      integer :: j

      share = 1
      do j = 1, size(structure%openings)
         ! a stop may be closed
         if (structure%laws(j)%kind > table_law) cycle
         associate (direction => structure%directions(:, j), opening => structure%openings(j))
            closing = dot_product(direction, q)
            if (closing - opening <= rounding*(opening + sum(abs(direction*q)))) cycle
            if (opening >= 0) share = min(share, 0.95_wp*opening/closing)
         end associate
      end do
      q = share*q
   end subroutine open_gaps

   !> The largest coordinates and velocities at the events and the end of a simulation from rest.
   pure subroutine reached_sizes(structure, load, sizes)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> (2n)
      real(wp), intent(out) :: sizes(:)
      integer(int64), parameter :: cycles = 40
      integer, parameter :: chunk = 256, most_chunks = 100
      type(run_type) :: run
      type(run_state_type) :: state
      type(run_event_type), allocatable :: events(:)
      real(wp), allocatable :: q(:), rate(:)
      integer :: events_here, i, j, n, status

      sizes = 0
      n = size(sizes)/2
      call new_run(structure, load, run, status)
      if (status /= stat%ok) return
      allocate (q(n), rate(n), source=0.0_wp)
      call start_at(run, 0.0_wp, q, rate, state, status)
      if (status /= stat%ok) return
      allocate (events(chunk))
      do j = 1, most_chunks
         call simulate_structure(run, state, cycles, 0.0_wp, events, events_here, status)
         do i = 1, events_here
            sizes = max(sizes, abs([events(i)%q, events(i)%rate]))
         end do
         if (status /= stat%more_events) exit
      end do
      call state_now(run, state, q, rate)
      sizes = max(sizes, abs([q, rate]))
   end subroutine reached_sizes

   !> A random number between 0 and 1, neither of them included.
   pure real(wp) function uniform(seed, stream, i, j)
      !> Seed, and what it is for.
      integer, intent(in) :: seed, stream
      !> Its numbers.
      integer, intent(in) :: i, j
      integer(int64) :: words(4)

      words = philox([int(i, int64), int(j, int64), 0_int64, 0_int64], [int(seed, int64), &
         int(stream, int64)])
      uniform = (words(1) + 0.5_wp)*2.0_wp**(-32)
   end function uniform

end module vi_structure_find
