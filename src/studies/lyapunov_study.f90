!> The study &lyapunov: all Lyapunov exponents, at a point or along a line of points.
module vi_lyapunov_study
   use vi_case, only: case_type
   use vi_common_keys, only: check_parameter, check_start, clearance_key, load_key, parameter_of, &
      parameter_values, spacing_key, state_keys
   use vi_key, only: a_whole, a_word, key_type
   use vi_kinds, only: wp
   use vi_text, only: whole
   implicit none (type, external)
   private

   public :: check_lyapunov, line_points

   character(*), parameter :: with = 'parameter', range_takes = 'a number in the range of the &
      &parameter (1e-6 <= r <= 1e6, 1e-12 <= clearance <= 1e12)'
   type(key_type), parameter, public :: lyapunov_keys(*) = [ &
      key_type('clearance', low=clearance_key%low, high=clearance_key%high, &
      never='parameter=clearance', why='=: it is the parameter', unit='F0/K', &
      meaning=clearance_key%meaning), &
      key_type('parameter', a_word, may_miss=.true., words='r clearance', &
      takes='''r'' or ''clearance''; low, high and values go with it', &
      meaning='a line of points'), &
      key_type('low', only=with, meaning='first value', &
      takes=range_takes), &
      key_type('high', only=with, over='low', meaning='last value', &
      takes=range_takes), &
      key_type('values', a_whole, low=2.0_wp, high=1.0e6_wp, only=with, meaning='how many'), &
      key_type('spacing', a_word, default=spacing_key%default, words=spacing_key%words, &
      takes='''linear'' or ''geometric'' (of the values); it goes with parameter', only=with, &
      meaning='of the values'), &
      key_type('cycles', a_whole, default='10000', low=4.0_wp, high=1.0e9_wp, &
      takes='a whole number, 2 batches <= cycles <= 1e9', &
      meaning='load cycles averaged over'), &
      key_type('discard', a_whole, default='1000', low=0.0_wp, high=1.0e9_wp, &
      meaning='load cycles simulated before'), &
      key_type('batches', a_whole, default='20', low=2.0_wp, high=1000.0_wp, &
      meaning='parts of the cycles whose scatter gives the standard errors'), &
      state_keys, load_key]

contains

   !> Checks what depends on several keys.
   subroutine check_lyapunov(case)
      !> The case.
      type(case_type), intent(inout) :: case

      call check_parameter(case)
      associate (study => case%study)
         if (len(study%fault) > 0) return
         if (study%whole_number('cycles') < 2*study%whole_number('batches')) call &
            study%refuse('cycles', 'batches is '//whole(study%whole_number('batches')))
         ! the walls may move with the parameter: the state is between the nearest of them
         if (study%has('clearance')) then
            call check_start(study, study%number('clearance'))
         else
            call check_start(study, study%number('low'))
         end if
      end associate
   end subroutine check_lyapunov

   !> The points of a line along r or the clearance, or the one of the case.
   pure subroutine line_points(case, r, clearance)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> The points (n).
      real(wp), allocatable, intent(out) :: r(:), clearance(:)
      integer :: n

      n = 1
      if (case%study%has('parameter')) n = case%study%whole_number('values')
      allocate (r(n), source=case%r)
      allocate (clearance(n))
      if (case%study%has('clearance')) clearance = case%study%number('clearance')
      if (parameter_of(case) == 'r') r = parameter_values(case)
      if (parameter_of(case) == 'clearance') clearance = parameter_values(case)
   end subroutine line_points

end module vi_lyapunov_study
