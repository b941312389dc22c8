!> The study &response: the greatest displacement of the primary mass along the frequency ratio.
module vi_response_study
   use vi_case, only: case_type
   use vi_common_keys, only: check_product, clearance_key, resonance, window_keys
   use vi_key, only: a_whole, key_type
   use vi_kinds, only: wp
   use vi_text, only: whole
   use vi_window, only: even, most_numbers
   implicit none (type, external)
   private

   public :: check_response, r_values, response_clearance

   type(key_type), parameter, public :: response_keys(*) = [window_keys(1:2), &
      key_type('r_points', a_whole, low=2.0_wp, high=1.0e6_wp, meaning='frequency ratios'), &
      key_type('clearance', low=clearance_key%low, high=clearance_key%high, &
      or='inverse_clearance', unit='F0/K', meaning='clearance d K/F0'), &
      key_type('inverse_clearance', low=1.0e-12_wp, high=1.0e12_wp, or='clearance', &
      unit='K/F0', meaning='F0/(d K)'), &
      key_type('states', a_whole, default='24', low=1.0_wp, high=1.0e6_wp, &
      meaning='initial states at each, spread evenly'), &
      key_type('settling', a_whole, default='600', low=0.0_wp, high=1.0e7_wp, &
      meaning='load cycles simulated before anything is looked at'), &
      key_type('keep', a_whole, default='33', low=3.0_wp, high=1.0e4_wp, &
      meaning='load cycles then looked at'), &
      key_type('load', default='1', low=0.0_wp, above=.true., high=1.0e12_wp, &
      meaning='load amplitude')]

contains

   !> Checks what depends on several keys.
   subroutine check_response(case)
      !> The case.
      type(case_type), intent(inout) :: case

      associate (study => case%study)
         if (len(study%fault) > 0) return
         if (case%osc%xi <= 0) then
            if (any(abs(r_values(case) - 1) <= 0)) call study%refuse('r_min', resonance// &
               'among the values')
         end if
         call check_product(study, 'states', [study%whole_number('r_points'), &
            study%whole_number('states')], 'r_points x states must be at most '// &
            whole(most_numbers))
      end associate
   end subroutine check_response

   !> The frequency ratios.
   pure function r_values(case) result(r)
      !> The case.
      type(case_type), intent(in) :: case
      real(wp), allocatable :: r(:)

      r = even(case%study%number('r_min'), case%study%number('r_max'), &
         case%study%whole_number('r_points'))
   end function r_values

   !> The clearance of a case that has it or its inverse.
   pure real(wp) function response_clearance(case) result(clearance)
      !> The case.
      type(case_type), intent(in) :: case

      if (case%study%has('clearance')) then
         clearance = case%study%number('clearance')
      else
         clearance = 1/case%study%number('inverse_clearance')
      end if
   end function response_clearance

end module vi_response_study
