!> The study &atlas: the zones of all patterns in a window.
module vi_atlas_study
   use vi_atlas, only: atlas_request_type
   use vi_case, only: case_type
   use vi_common_keys, only: check_window, window_keys
   use vi_key, only: a_whole, key_type
   use vi_kinds, only: wp
   use vi_zone_study, only: lines_key, vertices_key
   implicit none (type, external)
   private

   public :: atlas_request, check_atlas

   type(key_type), parameter, public :: atlas_keys(*) = [ &
      key_type('max_impacts', a_whole, default='5', low=2.0_wp, high=8.0_wp, &
      meaning='most impacts of a pattern; an accumulation counts as one'), &
      key_type('max_cycles', a_whole, default='1', low=1.0_wp, high=4.0_wp, &
      meaning='most load cycles of a pattern'), &
      key_type('survey', a_whole, default='400', low=0.0_wp, high=1.0e6_wp, &
      meaning='points of the window at which simulations are left to settle'), &
      key_type('settling', a_whole, default='400', low=1.0_wp, high=1.0e6_wp, &
      meaning='load cycles simulated at each before its motion is looked at'), &
      window_keys, lines_key, &
      key_type('guesses', a_whole, default='24', low=0.0_wp, high=1.0e5_wp, &
      meaning='guesses for motions at every second node each way, for each pattern'), &
      vertices_key]

contains

   !> Checks what depends on several keys.
   subroutine check_atlas(case)
      !> The case.
      type(case_type), intent(inout) :: case

      call check_window(case)
   end subroutine check_atlas

   !> What is asked of the search.
   pure function atlas_request(case, threads) result(request)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Threads; the answer does not depend on them.
      integer, intent(in) :: threads
      type(atlas_request_type) :: request

      associate (s => case%study)
         request = atlas_request_type(case%osc, [s%number('r_min'), s%number('r_max')], [s%number( &
            'clearance_min'), s%number('clearance_max')], s%whole_number('max_impacts'), &
            s%whole_number('max_cycles'), s%whole_number('survey'), s%whole_number('settling'), &
            s%whole_number('lines'), s%whole_number('guesses'), s%whole_number('max_points'), &
            threads)
      end associate
   end function atlas_request

end module vi_atlas_study
