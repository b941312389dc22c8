!> The self-excited motions, or states of equilibrium, on which states of a structure without a
!! periodic load settle.
module vi_free_states
   use vi_kinds, only: two_pi, wp
   use vi_motion, only: no, yes
   use vi_progress, only: add_done_work, add_expected_work, is_stopped
   use vi_settled_states, only: outcome_type, settling_type
   use vi_status, only: stat, status_text
   use vi_structure, only: load_type, structure_type
   use vi_structure_found, only: add_motion, found_list_type
   use vi_structure_groups, only: load_frequency, record_end
   use vi_structure_return, only: self_excited, settled_type
   use vi_structure_run, only: longest_natural_period
   use vi_study, only: case_type
   implicit none (type, external)
   private

   public :: check_settling, find_pace, is_free, settle_free_states

   !> States between which the list of motions is brought up to date.
   integer, parameter :: block = 512

contains

   !> Whether the motions of a structure are self-excited: without a load, or under constant forces.
   logical function is_free(case)
      !> The case; its load is used.
      type(case_type), intent(in) :: case

      is_free = .not. load_frequency(case) > 0 .and. record_end(case) < 0
   end function is_free

   !> Refuses simulations of no duration where motions are self-excited: they have no period of the
   !! load in which they could repeat.
   subroutine check_settling(case)
      !> The case; its study has the key `settling`.
      type(case_type), intent(inout) :: case

      if (.not. is_free(case)) return
      if (case%study%whole_number('settling') == 0) call case%study%refuse('settling', &
         'without a periodic load at least 1')
   end subroutine check_settling

   !> The time that stands for a load cycle, which is the longest natural period.
   subroutine find_pace(structure, load, unit, paced, fault)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Constant forces.
      type(load_type), intent(in) :: load
      !> The time.
      real(wp), intent(out) :: unit
      !> The load with this period, under which random states are drawn; it does not act.
      type(load_type), intent(out) :: paced
      !> Empty, or why there is no such time.
      character(:), allocatable, intent(out) :: fault
      integer :: status

      fault = ''
      call longest_natural_period(structure, load, unit, status)
      if (status /= stat%ok) then
         fault = status_text(status)
      else if (.not. unit > 0) then
         fault = 'without a periodic load, settling counts natural periods, and the structure has &
            &none: no spring holds it'
      else
         paced = load
         paced%frequency = two_pi/unit
      end if
   end subroutine find_pace

   !> The motion on which each of some states settles.
   subroutine settle_free_states(structure, load, unit, states, how, list, outcomes, progress)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Constant forces; without a frequency.
      type(load_type), intent(in) :: load
      !> The time that stands for a load cycle.
      real(wp), intent(in) :: unit
      !> (2n, m) Coordinates and velocities.
      real(wp), intent(in) :: states(:, :)
      !> How they are simulated.
      type(settling_type), intent(in) :: how
      !> In and out: the motions that are known.
      type(found_list_type), intent(inout) :: list
      !> (m) What became of each: its motion, or a status as of `self_excited`.
      type(outcome_type), intent(out) :: outcomes(:)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(settled_type), allocatable :: found(:)
      real(wp) :: scale(2)
      integer :: first, i, last, n

      n = size(states, 1)/2
      call add_expected_work(size(outcomes), progress)
      scale = [maxval(abs(states(:n, :))), maxval(abs(states(n + 1:, :)))]
      ! the only state is rest
      where (.not. scale > 0) scale = 1.0e-3_wp
      do first = 1, size(outcomes), block
         last = min(first + block - 1, size(outcomes))
         if (allocated(found)) deallocate (found)
         allocate (found(first:last))
         !$omp parallel do schedule(dynamic, 1) num_threads(how%threads)
         do i = first, last
            if (is_stopped(progress)) cycle
            call settle_free(structure, load, unit*how%settling, scale, states(:n, i), &
               states(n + 1:, i), how%max_events, found(i), outcomes(i)%status, progress)
            call add_done_work(1, progress)
         end do
         !$omp end parallel do
         do i = first, last
            if (outcomes(i)%status /= stat%ok) cycle
            call add_motion(structure, load, found(i), list, outcomes(i)%label)
            if (outcomes(i)%label == 0 .or. found(i)%motion%verdicts%stable /= no) cycle
            outcomes(i)%label = 0
            outcomes(i)%status = stat%not_stable
         end do
      end do
   end subroutine settle_free_states

   !> The motion on which a state settles: simulated for some time, and then for longer from where
   !! that ended, until a stable motion or an equilibrium is there.
   subroutine settle_free(structure, load, duration, scale, q, rate, max_events, found, status, &
      progress)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Constant forces.
      type(load_type), intent(in) :: load
      !> How long at first.
      real(wp), intent(in) :: duration
      !> As of `self_excited`.
      real(wp), intent(in) :: scale(2)
      !> Coordinates (n) and velocities (n) at the start.
      real(wp), intent(in) :: q(:), rate(:)
      !> Events after which the simulation is given up.
      integer, intent(in) :: max_events
      !> The motion.
      type(settled_type), intent(out) :: found
      !> `stat%ok`; `stat%no_impacts` or `stat%permanent_rest` in an equilibrium; `stat%no_period`
      !! where it does not repeat itself, or as of `self_excited`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> Simulations, each twice as long as the one before.
      integer, parameter :: rounds = 5
      type(settled_type) :: again
      real(wp) :: s(2*size(q)), finish(2*size(q)), frequency
      integer :: left, n, round
      logical :: steady, wanders

      n = size(q)
      s = [q, rate]
      left = max_events
      wanders = .false.
      do round = 0, rounds - 1
         call self_excited(structure, load, s(:n), s(n + 1:), 2**round*duration, 0.0_wp, again, &
            frequency, status, progress, left, scale, finish, steady)
         if (is_stopped(progress)) status = stat%not_computed
         select case (status)
         case (stat%ok)
            found = again
            associate (verdicts => found%motion%verdicts)
               if (verdicts%admissible == yes .and. verdicts%stable == yes) return
            end associate
         case (stat%no_impacts, stat%permanent_rest)
            if (steady) return
            ! it still vibrates
            wanders = .true.
         case (stat%no_period)
            wanders = .true.
         case (stat%no_convergence, stat%singular, stat%no_motion, stat%no_derivative, &
            stat%zero_approach, stat%extreme_units)
            ! there may be one later
         case default
            return
         end select
         s = finish
      end do
      if (status /= stat%ok .and. wanders) status = stat%no_period
   end subroutine settle_free

end module vi_free_states
