!> The study &simulate: a simulation from a state.
module vi_simulate_study
   use vi_case, only: case_type
   use vi_common_keys, only: check_start, clearance_key, load_key, state_keys
   use vi_key, only: a_whole, key_type
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: check_simulate

   type(key_type), parameter, public :: simulate_keys(*) = [clearance_key, &
      key_type('cycles', low=0.0_wp, high=1.0e9_wp, &
      takes='a number of load cycles with 0 <= cycles <= 1e9', &
      meaning='load cycles to simulate; fractions are allowed'), &
      key_type('discard', default='0', low=0.0_wp, high=1.0e9_wp, &
      takes='a number of load cycles with 0 <= discard <= 1e9', &
      meaning='load cycles simulated before those'), &
      load_key, state_keys, &
      key_type('max_events', a_whole, default='10000000', low=1.0_wp, high=1.0e9_wp, &
      meaning='events after which it is cut short')]

contains

   !> Checks what depends on several keys.
   subroutine check_simulate(case)
      !> The case.
      type(case_type), intent(inout) :: case

      if (len(case%study%fault) == 0) call check_start(case%study, case%study%number('clearance'))
   end subroutine check_simulate

end module vi_simulate_study
