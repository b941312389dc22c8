!> The study &decay: the peaks and the damping of free vibration, for one or several clearances.
module vi_decay_study
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_common_keys, only: check_product, clearance_key, half_gap, max_events_key, &
      most_numbers, most_state, state_keys
   use vi_kinds, only: two_pi, wp
   use vi_peaks, only: find_peaks, peak_type
   use vi_status, only: stat, status_text
   use vi_text, only: counted, shown, whole
   use vi_study, only: a_whole, case_type, column_type, key_type, of_oscillator, result_type, &
      study_type, wholes
   implicit none (type, external)
   private

   public :: declare_decay

   type(key_type), parameter :: decay_keys(*) = [ &
      key_type('clearance', most=100000, low=clearance_key%low, high=clearance_key%high, &
      or='inverse_clearance', unit='F0/K', &
      meaning='clearances d K/F0 (d is the whole travel of m); F0/K is the unit of length'), &
      key_type('inverse_clearance', most=100000, low=1.0e-12_wp, high=1.0e12_wp, &
      or='clearance', unit='K/F0', meaning='F0/(d K) of each clearance'), &
      key_type('amplitude', default='1', low=-1.0e9_wp, high=1.0e9_wp, unit='F0/K', &
      meaning='displacement of the primary mass at the start'), &
      key_type('x_dot', default='0', low=-most_state, high=most_state, &
      unit=state_keys(3)%unit, &
      meaning='velocity of the primary mass at the start'), &
      key_type('y', default='0', unit='F0/K', &
      meaning='position z - x of the free mass between the walls at the start'), &
      key_type('z_dot', default='0', low=-most_state, high=most_state, &
      unit=state_keys(5)%unit, &
      meaning='velocity of the free mass at the start'), &
      key_type('cycles', a_whole, default='20', low=1.0_wp, high=1.0e6_wp, &
      meaning='oscillations of the primary mass; there are 2 cycles + 1 peaks'), &
      max_events_key]

   type(column_type), parameter :: decay_columns(*) = [ &
      column_type('runs', 'clearance', unit='F0/K', &
      meaning='clearance d K/F0; d is the whole travel of m between the walls'), &
      column_type('peaks', 'time', unit='1/omega', meaning='time'), &
      column_type('peaks', 'x', unit='F0/K', &
      meaning='greatest displacement of the primary mass between two zeros'), &
      column_type('peaks', 'decrement', &
      meaning='logarithmic decrement from this peak to the next one on the same side'), &
      column_type('peaks', 'damping', &
      meaning='damping ratio of a linear oscillator with this decrement'), &
      column_type('peaks', 'energy', unit='F0^2/K', &
      meaning='energy of both masses and the spring'), &
      column_type('peaks', 'impacts', wholes, meaning='impacts since the previous peak'), &
      column_type('peaks', 'rests', wholes, meaning='rests that began since the previous peak'), &
      column_type('runs', 'status', wholes, listed=.false., &
      meaning='code of the failure; 0: none')]

contains

   !> Declares the study, with its keys and columns.
   pure subroutine declare_decay(study, keys, columns)
      !> The study.
      type(study_type), intent(out), optional :: study
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) keys = decay_keys
      if (present(columns)) columns = decay_columns
      if (.not. present(study)) return
      study%name = 'decay'
      study%models = of_oscillator
      study%meaning = 'find the peaks and the damping of free vibration'
      study%has_load = .false.
      study%row = 'peaks'
      study%check => check_decay
      study%memory => decay_memory
      study%run => run_decay
   end subroutine declare_decay

   !> Checks the rules that involve several keys.
   subroutine check_decay(case)
      !> The case.
      type(case_type), intent(inout) :: case

      associate (study => case%study)
         if (len(study%fault) > 0) return
         if (abs(study%number('y')) > half_gap(minval(clearance_values(case)))) call &
            study%refuse('y', 'y must be within half of the smallest clearance')
         if (.not. (abs(study%number('amplitude')) > 0 .or. abs(study%number('x_dot')) > 0 .or. &
            abs(study%number('z_dot')) > 0)) call study%refuse('amplitude', &
            'it must not be 0 if both masses start at rest')
         call check_product(study, 'cycles', [size(clearance_values(case)), &
            2*study%whole_number('cycles') + 1], 'clearances x (2 cycles + 1) must be at most '// &
            whole(most_numbers))
      end associate
   end subroutine check_decay

   !> The clearances.
   pure function clearance_values(case) result(clearance)
      !> The case.
      type(case_type), intent(in) :: case
      real(wp), allocatable :: clearance(:)

      if (case%study%has('clearance')) then
         clearance = case%study%numbers('clearance')
      else
         clearance = 1/case%study%numbers('inverse_clearance')
      end if
   end function clearance_values

   !> Bytes for all peaks, about 20 numbers each.
   pure real(wp) function decay_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case

      bytes = 160.0_wp*(2*case%study%whole_number('cycles') + 1)*size(clearance_values(case))
   end function decay_memory

   !> Finds the peaks of each free vibration, and its damping from peak to peak.
   subroutine run_decay(case, threads, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(peak_type), allocatable :: peaks(:, :), listed(:)
      real(wp), allocatable :: clearance(:), decrement(:)
      integer, allocatable :: counts(:), status(:), done(:), owners(:)
      integer :: most, n, i, j

      allocate (clearance, source=clearance_values(case))
      n = size(clearance)
      associate (s => case%study)
         most = 2*s%whole_number('cycles') + 1
         allocate (peaks(most, n), counts(n), status(n))
         call find_peaks(case%osc, clearance, [s%number('amplitude'), s%number('x_dot'), &
            s%number('y'), s%number('z_dot')], s%whole_number('max_events'), threads, &
            peaks, counts, status, progress)
      end associate
      ! only the clearances that were completed before a stop
      done = pack([(j, j=1, n)], status /= stat%not_computed)
      if (size(done) < n) result%cut = whole(size(done))//' of '//whole(n)// &
         ' clearances were reached'
      owners = [(spread(i, 1, counts(done(i))), i=1, size(done))]
      allocate (listed(size(owners)), decrement(size(owners)))
      i = 0
      do j = 1, size(done)
         associate (m => counts(done(j)))
            listed(i + 1:i + m) = peaks(:m, done(j))
            decrement(i + 1:i + m) = decrements(peaks(:m, done(j))%x)
            i = i + m
         end associate
      end do
      call result%open('runs', 'run', [size(done)])
      call result%put('runs', 'clearance', clearance(done))
      call result%put('runs', 'status', status(done))
      call result%open('peaks', 'peak', [size(listed)], 'runs', owners)
      call result%put('peaks', 'time', listed%time)
      call result%put('peaks', 'x', listed%x)
      call result%put('peaks', 'decrement', decrement)
      call result%put('peaks', 'damping', decrement/hypot(two_pi, decrement))
      call result%put('peaks', 'energy', listed%energy)
      call result%put('peaks', 'impacts', listed%impacts)
      call result%put('peaks', 'rests', listed%rests)
      result%empty = size(listed) == 0
      call add_summary(result, most, decrement, counts(done), status(done))
   end subroutine run_decay

   !> The logarithmic decrement from each peak to the next one on the same side; NaN for the last
   !! two.
   pure function decrements(x) result(decrement)
      !> (n) Displacements at the peaks, on alternate sides.
      real(wp), intent(in) :: x(:)
      real(wp) :: decrement(size(x))

      decrement = ieee_value(x, ieee_quiet_nan)
      associate (n => size(x))
         if (n > 2) decrement(:n - 2) = log(x(:n - 2)/x(3:))
      end associate
   end function decrements

   !> Reports what was found, and what is missing.
   subroutine add_summary(result, most, decrement, counts, status)
      !> The result.
      type(result_type), intent(inout) :: result
      !> Number of peaks requested in each run.
      integer, intent(in) :: most
      !> (peaks) The decrements of all runs.
      real(wp), intent(in) :: decrement(:)
      !> (runs) Peaks found, and codes of vi_status.
      integer, intent(in) :: counts(:), status(:)
      real(wp), allocatable :: damping(:)
      character(:), allocatable :: reason

      damping = pack(decrement/hypot(two_pi, decrement), decrement <= huge(decrement))
      if (size(damping) > 0) call result%add_note('damping ratio of a cycle from '// &
         shown(minval(damping), 'f12.5')//' to '//shown(maxval(damping), 'f12.5')//' at '// &
         counted(size(counts), 'clearance'))
      if (all(counts == most)) return
      reason = 'the oscillation ends earlier'
      if (any(status /= stat%ok)) reason = status_text(maxval(status))
      call result%fail(whole(count(counts < most))//' of '//counted(size(counts), 'clearance')// &
         ' with fewer than '//whole(most)//' peaks: '//reason)
   end subroutine add_summary

end module vi_decay_study
