!> Attractors that are not periodic, distinguished by where their impacts lie.
module vi_attractor_wandering
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_attractor_cells, only: best_group, count_impact, group_type, new_group, owner_of
   use vi_attractor_settled, only: advance
   use vi_attractor_known, only: chaotic, known_type, periodic, quasi_periodic, shortest_period
   use vi_exponents, only: average_type, cycles_to_settle, decays, exponents_along, &
      exponents_type, positive, sign_by_error, zero
   use vi_forced_system, only: forced_system_type, event_type, impact_event, state_type
   use vi_kinds, only: wp
   use vi_simulate, only: simulate_on
   use vi_simulated_pair, only: new_simulated_pair, simulated_pair_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: find_cells, group_of, measure_kind, search_near

   !> Load cycles whose impacts mark the cells of an attractor; the impacts that are enough, and the
   !! most load cycles until then; number of batches of an average.
   integer, parameter :: cell_cycles = 4000, few_impacts = 200, most_cell_cycles = 100000, &
      batches = 20
   !> Load cycles before which a motion does not count as settled.
   integer, parameter :: least_cycles = 12000
   !> Load cycles of an average with which an exponent may count as zero.
   integer, parameter :: zero_cycles = 16000
   !> The numbers of the walls in cells: +1 right, -1 left.
   integer, parameter :: sides_of_walls(2) = [-1, 1]

contains

   !> The attractor to which the impacts of a trajectory belong: most of them are in its cells, and
   !! in those of no other one; 0 if there is none.
   pure integer function group_of(system, values, sides, groups) result(owner)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> Impacts of the trajectory, as in `store_events`.
      real(wp), intent(in) :: values(:, :)
      !> (n) Walls of these impacts: +1 right, -1 left.
      integer, intent(in) :: sides(:)
      !> Cells of the known attractors.
      type(group_type), intent(in) :: groups(:)
      type(group_type) :: own
      integer :: i

      own = new_group(sides_of_walls)
      do i = 1, size(sides)
         call count_impact(own, values(2, i), values(3, i)/system%clearance, sides(i))
      end do
      owner = owner_of(own, groups)
   end function group_of

   !> The cells in which a long simulation has impacts, and the known attractor with most of them.
   subroutine find_cells(system, state, left, groups, own, owner, status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: state at the start. Out: at the end.
      type(state_type), intent(inout) :: state
      !> As in `simulate_on`.
      integer, intent(inout) :: left
      !> Cells of the known attractors.
      type(group_type), intent(in) :: groups(:)
      !> The cells.
      type(group_type), intent(out) :: own
      !> The known attractor whose cells have most of these impacts, and more than half of them; 0
      !! if
      !! there is none.
      integer, intent(out) :: owner
      !> As in `simulate_on`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(event_type) :: events(64)
      type(state_type) :: final
      integer(int64) :: first, last
      real(wp) :: phase
      integer :: n, i, best

      owner = 0
      own = new_group(sides_of_walls)
      first = state%cycle
      last = first + cell_cycles
      phase = state%phase
      do
         call simulate_on(system, state, last, phase, events, n, final, left, status, progress)
         do i = 1, n
            if (events(i)%kind == impact_event) call count_impact(own, events(i)%phase, &
               events(i)%x/system%clearance, events(i)%side)
         end do
         if (status == stat%more_events) cycle
         ! the free mass may drift from wall to wall for long
         if (status /= stat%ok .or. sum(own%hits) >= few_impacts .or. last - first >= &
            most_cell_cycles) exit
         last = last + cell_cycles
      end do
      state = final
      if (size(groups) == 0 .or. status /= stat%ok) return
      call best_group(own, groups, best, n)
      if (n > 0) owner = groups(best)%owner
   end subroutine find_cells

   !> The kind of a motion, from its largest exponent: chaotic if this is positive by its error,
   !! quasi-periodic if it is zero by its error, `periodic` if it is so negative that the motion has
   !! settled during the average, and 0 as long as it is none of these.
   !!
   !! The kind is 0 until the motion has gone on for as long as transients may last; a free
   !! vibration decays slowest while both masses move together.
   subroutine measure_kind(system, state, cycles, before, left, kind, largest, settling, status, &
      progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: state at the start. Out: at the end.
      type(state_type), intent(inout) :: state
      !> Load cycles of the average, and those that were simulated before.
      integer, intent(in) :: cycles, before
      !> As in `simulate_on`.
      integer, intent(inout) :: left
      !> `chaotic`, `quasi_periodic`, `periodic` or 0.
      integer, intent(out) :: kind
      !> Largest exponent per load cycle.
      real(wp), intent(out) :: largest
      !> Load cycles after which any motion nearby counts as settled.
      integer, intent(out) :: settling
      !> As in `exponents_along`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(simulated_pair_type) :: motion
      type(exponents_type) :: found
      real(wp) :: deviation
      integer :: sign_of_it

      kind = 0
      settling = 0
      largest = 0
      motion = new_simulated_pair(system, state, left)
      call exponents_along(motion, average_type(cycles=cycles/batches, batches=batches), found, &
         status, progress)
      state = motion%final
      left = motion%left
      if (status /= stat%ok) return
      largest = found%exponents(1)*found%period
      deviation = found%deviations(1)*found%period
      associate (osc => system%osc)
         settling = cycles_to_settle(-sum(found%exponents(:found%rank))*found%period/found%rank, &
            osc%xi/(1 + osc%mu)*found%period)
      end associate
      if (before + cycles < max(settling, least_cycles)) return
      sign_of_it = sign_by_error(largest, deviation, cycles)
      if (sign_of_it == positive) kind = chaotic
      if ((largest + 4*deviation)*cycles < -2*decays) kind = periodic
      if (sign_of_it == zero .and. cycles >= zero_cycles) kind = quasi_periodic
   end subroutine measure_kind

   !> A stable periodic motion around which a trajectory may wind, by Newton's method from where the
   !! trajectory nearly returns, and from the mean of its states.
   subroutine search_near(system, state, max_cycles, left, motion, good, repeats, status, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: state at the start. Out: at the end.
      type(state_type), intent(inout) :: state
      !> Longest period considered, in load cycles.
      integer, intent(in) :: max_cycles
      !> As in `simulate_on`.
      integer, intent(inout) :: left
      !> The motion; its targets have no neighbourhoods yet.
      type(known_type), intent(out) :: motion
      !> Whether there is one.
      logical, intent(out) :: good
      !> Load cycles after which the states repeat themselves to rounding; 0 if they do not.
      integer, intent(out) :: repeats
      !> As in `advance`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> Returns looked for, for each period; largest number of events of a load cycle; periods that
      !! are tried.
      integer, parameter :: returns = 8, room = 2048, most_tries = 6
      !> How near a trajectory returns to be tried, how far the motion may be from there, and how
      !! nearly states repeat themselves to rounding, over the clearance.
      real(wp), parameter :: loose = 0.3_wp, rounding = 1.0e-9_wp
      type(event_type), allocatable :: events(:)
      type(state_type) :: final
      real(wp) :: strobes(5, 0:returns*max_cycles), apart(0:returns*max_cycles - 1), least, most
      integer :: i, k, m, n, tries

      good = .false.
      repeats = 0
      allocate (events(room))
      final = state
      m = ubound(strobes, 2)
      ! a phase unrelated to that of the start, which may be an impact
      do i = 0, m
         call advance(system, state, final, merge(1.0_wp, 0.6180339887_wp, i > 0), events, n, &
            left, status, progress)
         if (status /= stat%ok) exit
         strobes(:, i) = [final%phase/system%r, final%x, final%x_dot, final%z, final%z_dot]
      end do
      state = final
      if (status /= stat%ok) return
      tries = 0
      do k = 1, max_cycles
         apart(:m - k) = maxval(abs(strobes(2:, k:) - strobes(2:, :m - k)), 1)/system%clearance
         most = maxval(apart(:m - k))
         if (repeats == 0 .and. most < rounding) repeats = k
         i = minloc(apart(:m - k), 1) - 1
         least = apart(i)
         if (least > loose .or. tries == most_tries) cycle
         tries = tries + 1
         call shortest_period(system, strobes(:, i), k, motion, good, loose)
         if (good) return
         i = modulo(i, k)
         call shortest_period(system, sum(strobes(:, i::k), 2)/size(strobes(1, i::k)), k, motion, &
            good, loose)
         if (good) return
      end do
   end subroutine search_near

end module vi_attractor_wandering
