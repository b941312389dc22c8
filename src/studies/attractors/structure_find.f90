!> Periodic motions of a structure with all orders of a few impacts, and random states from which
!! others are looked for.
module vi_structure_find
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_kinds, only: two_pi, wp
   use vi_philox, only: philox
   use vi_progress, only: add_done_work, add_expected_work, is_stopped
   use vi_restitution, only: table_law
   use vi_status, only: stat
   use vi_structure, only: load_type, structure_type
   use vi_structure_found, only: add_motion, found_list_type
   use vi_structure_period, only: exact, periodic_structure
   use vi_structure_return, only: settled_type
   use vi_structure_run, only: new_run, run_event_type, run_state_type, run_type, &
      simulate_structure, start_at, state_now
   implicit none (type, external)
   private

   public :: count_orders, open_gaps, random_structure_states, search_orders

   !> Which orders of impacts are tried.
   type, public :: orders_type
      !> Most impacts and load cycles, sets of impact times for each order and number of cycles.
      integer :: max_impacts = 0, max_cycles = 1, guesses = 1
      !> Seed of the times; number of OpenMP threads.
      integer :: seed = 0, threads = 1
   end type orders_type

   !> Tasks between which the list of motions is brought up to date.
   integer, parameter :: block = 512

contains

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
      !> Seed, and number of the stream: each use of random numbers has its own.
      integer, intent(in) :: seed, stream
      !> Number of the state or task, and of the draw.
      integer, intent(in) :: i, j
      integer(int64) :: words(4)

      words = philox([int(i, int64), int(j, int64), 0_int64, 0_int64], [int(seed, int64), &
         int(stream, int64)])
      uniform = (words(1) + 0.5_wp)*2.0_wp**(-32)
   end function uniform

end module vi_structure_find
