!> The possible outcomes of a point of a survey, and the tests for them.
module vi_survey_outcome
   use vi_attractor_known, only: exact_period, known_type, periods_in
   use vi_forced_system, only: forced_system_type, state_type
   use vi_kinds, only: wp
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: count_outcomes, stable_period

   !> A stable periodic motion within the limits of symbols and cycles; one beyond them; the free
   !! mass at rest and never touched; a positive Lyapunov exponent; none of these so far; a
   !! simulation that repeats itself although Newton's method confirms no stable motion; too many
   !! events; of a structure, a stable periodic motion with rest.
   integer, parameter, public :: periodic = 1, beyond = 2, no_impacts = 3, chaotic = 4, &
      not_settled = 5, not_confirmed = 6, event_limit = 7, with_rest = 8
   character(20), parameter, public :: outcome_names(8) = [character(20) :: 'periodic', &
      'beyond the limits', 'without impacts', 'chaotic', 'not settled', 'not confirmed', &
      'event limit reached', 'with rest']

   !> Largest number of symbols of a pattern.
   integer, parameter :: most_symbols = 1000

contains

   !> Number of points of each outcome.
   pure function count_outcomes(outcomes) result(counts)
      !> (points) The outcome of each point.
      integer, intent(in) :: outcomes(:)
      integer :: counts(size(outcome_names))
      integer :: i

      counts = [(count(outcomes == i), i=1, size(counts))]
   end function count_outcomes

   !> The symbols of the stable periodic motion on which a state lies, by Newton's method on the map
   !! over the period.
   subroutine stable_period(system, state, cycles, symbols, shorter)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The state.
      type(state_type), intent(in) :: state
      !> Load cycles of the period.
      integer, intent(in) :: cycles
      !> As in vi_symbols; empty if there is no such motion.
      integer, allocatable, intent(out) :: symbols(:)
      !> Whether its period is only a part of these cycles; this can happen if the simulation
      !! approaches the motion slowly.
      logical, intent(out) :: shorter
      type(known_type) :: known
      logical :: good

      call exact_period(system, [state%phase/system%r, state%x, state%x_dot, state%z, &
         state%z_dot], cycles, known, good)
      if (good) good = size(known%symbols) <= most_symbols
      if (good) good = any(known%symbols > 0) .and. any(known%symbols < 0)
      shorter = .false.
      if (good) shorter = periods_in(system, known) > 1
      allocate (symbols(0))
      if (good) symbols = known%symbols
   end subroutine stable_period

end module vi_survey_outcome
