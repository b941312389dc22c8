!> The study &decay: the peaks and the damping of free vibration, of an oscillator for one or
!! several clearances, or of a structure.
module vi_decay_study
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_common_keys, only: check_product, clearance_key, half_gap, max_events_key, &
      most_numbers, most_state, state_keys
   use vi_kinds, only: two_pi, wp
   use vi_peaks, only: find_peaks, peak_type
   use vi_status, only: stat, status_text
   use vi_structure, only: load_type, structure_type
   use vi_structure_gaps, only: start_fault
   use vi_structure_groups, only: complete_coordinates, load_frequency, most_coordinates, &
      record_end, structure_of
   use vi_structure_keys, only: check_start_state, start_keys
   use vi_structure_peaks, only: find_structure_peaks
   use vi_structure_run, only: longest_natural_period
   use vi_text, only: counted, shown, whole
   use vi_study, only: a_whole, case_type, column_type, every_model, key_type, list_for, &
      of_oscillator, of_structure, result_type, study_type, wholes
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
      meaning='velocity of the free mass at the start')]

   type(key_type), parameter :: structure_keys(*) = [start_keys(:2), &
      key_type('direction', most=most_coordinates, may_miss=.true., low=-1.0e40_wp, &
      high=1.0e40_wp, takes='numbers from -1e40 to 1e40, one per coordinate, not all 0', &
      meaning='coefficients of the coordinates in the displacement whose peaks are found; the &
      &first coordinate if it is left out')]

   type(key_type), parameter :: further_keys(*) = [ &
      key_type('cycles', a_whole, default='20', low=1.0_wp, high=1.0e6_wp, &
      meaning='oscillations; there are 2 cycles + 1 peaks'), &
      max_events_key]

   type(column_type), parameter :: decay_columns(*) = [ &
      column_type('runs', 'clearance', unit='F0/K', &
      meaning='clearance d K/F0; d is the whole travel of m between the walls'), &
      column_type('peaks', 'time', unit='1/omega', meaning='time'), &
      column_type('peaks', 'x', unit='F0/K', &
      meaning='greatest displacement of the primary mass between two zeros'), &
      column_type('peaks', 'energy', unit='F0^2/K', &
      meaning='energy of both masses and the spring'), &
      column_type('peaks', 'impacts', wholes, meaning='impacts since the previous peak'), &
      column_type('peaks', 'rests', wholes, meaning='rests that began since the previous peak')]

   type(column_type), parameter :: structure_columns(*) = [ &
      column_type('peaks', 'time', meaning='time'), &
      column_type('peaks', 'x', meaning='greatest displacement between two zeros'), &
      column_type('peaks', 'energy', meaning='energy of masses, springs and pressed stops'), &
      column_type('peaks', 'impacts', wholes, &
      meaning='impacts, and contacts with stops, since the previous peak'), &
      column_type('peaks', 'rests', wholes, &
      meaning='rests and halts by friction since the previous peak')]

   type(column_type), parameter :: further_columns(*) = [ &
      column_type('peaks', 'decrement', &
      meaning='logarithmic decrement from this peak to the next one on the same side'), &
      column_type('peaks', 'damping', &
      meaning='damping ratio of a linear oscillator with this decrement'), &
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

      if (present(keys)) then
         call list_for(of_oscillator, decay_keys, keys)
         call list_for(of_structure, structure_keys, keys)
         call list_for(every_model, further_keys, keys)
      end if
      if (present(columns)) then
         call list_for(of_oscillator, decay_columns, columns)
         call list_for(of_structure, structure_columns, columns)
         call list_for(every_model, further_columns, columns)
      end if
      if (.not. present(study)) return
      study%name = 'decay'
      study%meaning = 'find the peaks and the damping of free vibration'
      study%has_load = .false.
      study%takes_elements = .true.
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
         if (case%model == of_structure) then
            call check_structure(case)
            return
         end if
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

   !> Checks those of a structure.
   subroutine check_structure(case)
      !> The case.
      type(case_type), intent(inout) :: case
      real(wp), allocatable :: first(:)

      call check_start_state(case)
      if (.not. case%study%has('direction')) then
         allocate (first(case%coordinates), source=0.0_wp)
         first(1) = 1
         call case%study%set('direction', first)
      end if
      call complete_coordinates(case%study, 'direction', case%coordinates)
      associate (study => case%study)
         if (len(study%fault) > 0) return
         if (.not. any(abs(study%numbers('direction')) > 0)) then
            call study%refuse('direction', '')
         else if (load_frequency(case) > 0 .or. record_end(case) >= 0) then
            study%fault = '&decay: the vibration is free, so the &load must be constant or left out'
            study%fault_line = study%line
         else if (.not. any(abs([study%numbers('q'), study%numbers('q_dot')]) > 0)) then
            call study%refuse('q', 'it must not be 0 if all masses start at rest')
         else
            call check_product(study, 'cycles', [2*study%whole_number('cycles') + 1], &
               '2 cycles + 1 must be at most '//whole(most_numbers))
         end if
      end associate
   end subroutine check_structure

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

      bytes = 160.0_wp*(2*case%study%whole_number('cycles') + 1)
      if (case%model == of_oscillator) then
         bytes = bytes*size(clearance_values(case))
      else
         bytes = bytes + 400.0_wp*real(case%coordinates, wp)**2
      end if
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
      type(peak_type), allocatable :: peaks(:, :)
      real(wp), allocatable :: clearance(:)
      integer, allocatable :: counts(:), status(:), done(:)
      integer :: most, n, j

      if (case%model == of_structure) then
         call run_structure(case, result, progress)
         return
      end if
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
      call put_peaks(result, peaks(:, done), counts(done), status(done), clearance(done))
      call add_summary(result, most, counts(done), status(done), 'clearance')
   end subroutine run_decay

   !> Finds the peaks of a structure.
   subroutine run_structure(case, result, progress)
      !> As of `run_decay`.
      type(case_type), intent(in) :: case
      type(result_type), intent(inout) :: result
      integer, intent(inout), optional :: progress(3)
      type(structure_type) :: structure
      type(load_type) :: load
      type(peak_type), allocatable :: peaks(:, :)
      character(:), allocatable :: text
      real(wp) :: unit
      integer :: n, status

      call structure_of(case, structure, load)
      call longest_natural_period(structure, load, unit, status)
      if (status == stat%ok .and. .not. unit > 0) then
         result%empty = .true.
         call result%fail('no oscillation: no spring holds the structure')
         return
      end if
      n = 0
      associate (s => case%study)
         allocate (peaks(2*s%whole_number('cycles') + 1, 1))
         if (status == stat%ok) call find_structure_peaks(structure, load, s%numbers('q'), &
            s%numbers('q_dot'), s%numbers('direction'), unit, s%whole_number('max_events'), &
            peaks(:, 1), n, status, progress)
      end associate
      if (status == stat%not_computed) result%cut = whole(n)//' of '//whole(size(peaks))// &
         ' peaks were reached'
      if (status /= stat%ok .and. status /= stat%not_computed .and. n == 0) then
         result%empty = .true.
         call start_fault(structure, load, case%study%numbers('q'), status, text)
         call result%fail(text)
         return
      end if
      call put_peaks(result, peaks, [n], [status])
      call add_summary(result, size(peaks), [n], [status], 'run')
   end subroutine run_structure

   !> Fills the tables.
   subroutine put_peaks(result, peaks, counts, status, clearance)
      !> The result.
      type(result_type), intent(inout) :: result
      !> (most, runs) The peaks.
      type(peak_type), intent(in) :: peaks(:, :)
      !> (runs) Their numbers, codes of vi_status, and, for an oscillator, clearances.
      integer, intent(in) :: counts(:), status(:)
      real(wp), intent(in), optional :: clearance(:)
      type(peak_type), allocatable :: listed(:)
      real(wp), allocatable :: decrement(:)
      character(:), allocatable :: where_found
      integer, allocatable :: owners(:)
      integer :: i, j

      allocate (owners(sum(counts)), listed(sum(counts)), decrement(sum(counts)))
      i = 0
      do j = 1, size(counts)
         associate (m => counts(j))
            owners(i + 1:i + m) = j
            listed(i + 1:i + m) = peaks(:m, j)
            decrement(i + 1:i + m) = decrements(peaks(:m, j)%x)
            i = i + m
         end associate
      end do
      call result%open('runs', 'run', [size(counts)])
      if (present(clearance)) call result%put('runs', 'clearance', clearance)
      call result%put('runs', 'status', status)
      call result%open('peaks', 'peak', [size(listed)], 'runs', owners)
      call result%put('peaks', 'time', listed%time)
      call result%put('peaks', 'x', listed%x)
      call result%put('peaks', 'decrement', decrement)
      call result%put('peaks', 'damping', decrement/hypot(two_pi, decrement))
      call result%put('peaks', 'energy', listed%energy)
      call result%put('peaks', 'impacts', listed%impacts)
      call result%put('peaks', 'rests', listed%rests)
      result%empty = size(listed) == 0
      where_found = ''
      if (present(clearance)) where_found = ' at '//counted(size(counts), 'clearance')
      decrement = pack(decrement/hypot(two_pi, decrement), decrement <= huge(decrement))
      if (size(decrement) > 0) call result%add_note('damping ratio of a cycle from '// &
         shown(minval(decrement), 'f12.5')//' to '//shown(maxval(decrement), 'f12.5')//where_found)
   end subroutine put_peaks

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

   !> Reports what is missing: peaks that were not reached, or an oscillation that ends before them,
   !! as friction or rounding ends it, of which all peaks are known.
   subroutine add_summary(result, most, counts, status, noun)
      !> The result.
      type(result_type), intent(inout) :: result
      !> Number of peaks requested in each run.
      integer, intent(in) :: most
      !> (runs) Peaks found, and codes of vi_status.
      integer, intent(in) :: counts(:), status(:)
      !> What the runs are called.
      character(*), intent(in) :: noun
      character(:), allocatable :: text

      if (all(counts == most)) return
      text = whole(count(counts < most))//' of '//counted(size(counts), noun)// &
         ' with fewer than '//whole(most)//' peaks: '
      if (any(status /= stat%ok)) then
         call result%fail(text//status_text(maxval(status)))
      else
         call result%add_note(text//'the oscillation ends, or stays on one side of 0')
      end if
   end subroutine add_summary

end module vi_decay_study
