!> The study &lyapunov: all Lyapunov exponents, at a point or along a line of points.
module vi_lyapunov_study
   use vi_attractor_lyapunov, only: lyapunov_points
   use vi_case, only: case_type
   use vi_common_keys, only: check_parameter, check_start, clearance_key, load_key, parameter_of, &
      parameter_values, spacing_key, state_keys, state_of
   use vi_drive, only: initial_state, new_drive, two_pi
   use vi_key, only: a_whole, a_word, key_type
   use vi_kinds, only: wp
   use vi_result, only: column_type, result_type, wholes
   use vi_status, only: stat, status_text
   use vi_text, only: counted, whole
   use vi_trajectory, only: pack_state
   implicit none (type, external)
   private

   public :: check_lyapunov, run_lyapunov

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

   type(column_type), parameter, public :: lyapunov_columns(*) = [ &
      column_type('points', 'r', meaning='frequency ratio'), &
      column_type('points', 'clearance', unit='F0/K', meaning='clearance d K/F0'), &
      column_type('points', 'exponents', each='exponent', label='exponent_#', &
      unit='1/load cycle', meaning='Lyapunov exponents, the greatest first'), &
      column_type('points', 'errors', each='exponent', label='error_#', unit='1/load cycle', &
      meaning='their standard errors'), &
      column_type('points', 'dimension', meaning='Kaplan-Yorke dimension'), &
      column_type('points', 'identity_error', &
      meaning='of the sum of the exponents, which follows from damping and impacts'), &
      column_type('points', 'impacts', wholes, meaning='impacts in the cycles averaged over'), &
      column_type('points', 'rests', wholes, meaning='rests in the cycles averaged over'), &
      column_type('points', 'status', wholes, listed=.false., &
      meaning='code of what failed; 0: none')]

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

   !> Computes the exponents along a line of points, or at one.
   subroutine run_lyapunov(case, threads, result, tally)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Threads; the answer does not depend on them.
      integer, intent(in) :: threads
      !> Started.
      type(result_type), intent(inout) :: result
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      real(wp), allocatable :: r(:), clearance(:), states(:, :), loads(:), exponents(:, :), &
         deviations(:, :), dimensions(:), errors(:), cycle_times(:, :)
      integer, allocatable :: contacts(:, :), counts(:, :), status(:)
      character(:), allocatable :: reason
      integer :: j, n, lost, batches

      call line_points(case, r, clearance)
      n = size(r)
      allocate (states(7, n), contacts(3, n), loads(n), exponents(4, n), deviations(4, n), &
         dimensions(n), errors(n), counts(2, n), status(n))
      associate (s => case%study)
         loads = s%number('load')
         batches = s%whole_number('batches')
         do j = 1, n
            call pack_state(initial_state(new_drive(case%osc, r(j), loads(j), clearance(j)), &
               state_of(s)), states(:, j), contacts(:, j))
         end do
         call lyapunov_points(case%osc, r, loads, clearance, states, contacts, &
            s%whole_number('discard'), s%whole_number('cycles')/batches, batches, threads, &
            exponents, deviations, dimensions, counts, errors, status, tally)
      end associate
      allocate (cycle_times, source=spread(two_pi/r, 1, 4))
      call result%open('points', 'point', [n])
      call result%put('points', 'r', r)
      call result%put('points', 'clearance', clearance)
      call result%put('points', 'exponents', [exponents*cycle_times])
      call result%put('points', 'errors', [deviations*cycle_times])
      call result%put('points', 'dimension', dimensions)
      call result%put('points', 'identity_error', errors)
      call result%put('points', 'impacts', counts(1, :))
      call result%put('points', 'rests', counts(2, :))
      call result%put('points', 'status', status)
      lost = count(status /= stat%ok)
      result%empty = lost == n
      if (.not. result%empty) call result%say(counted(n, 'point')//', '//whole(count( &
         exponents(1, :) > 3*deviations(1, :)))//' with a positive exponent')
      if (lost == 0) return
      j = findloc(status /= stat%ok, .true., 1)
      if (status(j) == stat%no_motion) then
         reason = 'no impacts in a batch'
      else
         reason = status_text(status(j))
      end if
      call result%fail('no exponents at '//whole(lost)//' of '//counted(n, 'point')//': '//reason)
   end subroutine run_lyapunov

end module vi_lyapunov_study
