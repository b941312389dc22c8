!> The study &lyapunov of a &structure: the Lyapunov exponents of a simulation.
module vi_lyapunov_structure_study
   use vi_common_keys, only: max_events_key
   use vi_kinds, only: wp
   use vi_status, only: stat
   use vi_structure_gaps, only: start_fault
   use vi_structure, only: load_type, structure_type
   use vi_structure_groups, only: load_frequency, most_coordinates, record_end, structure_of
   use vi_structure_keys, only: check_start_state, start_keys
   use vi_structure_lyapunov, only: average_type, exponents_type, structure_exponents
   use vi_study, only: a_whole, case_type, column_type, key_type, result_type, study_type, wholes
   use vi_text, only: shown, whole
   implicit none (type, external)
   private

   public :: declare_lyapunov_structure

   type(key_type), parameter :: lyapunov_keys(*) = [ &
      key_type('cycles', a_whole, default='2000', low=4.0_wp, high=1.0e9_wp, &
      takes='a whole number, 2 batches <= cycles <= 1e9', &
      meaning='load cycles averaged over; units of time if the load has no frequency'), &
      key_type('discard', a_whole, default='300', low=0.0_wp, high=1.0e9_wp, &
      meaning='load cycles simulated before the average begins'), &
      key_type('batches', a_whole, default='20', low=2.0_wp, high=1000.0_wp, &
      meaning='parts of the cycles whose scatter gives the standard errors'), &
      key_type('directions', a_whole, low=1.0_wp, high=2.0_wp*most_coordinates, may_miss=.true., &
      takes='a whole number, 1 <= directions <= 2n with n coordinates', &
      meaning='number of exponents, the greatest first; all 2n if it is left out'), &
      start_keys, max_events_key]

   type(column_type), parameter :: lyapunov_columns(*) = [ &
      column_type('exponents', 'number', wholes, meaning='number of the exponent'), &
      column_type('exponents', 'per_cycle', unit='1/load cycle', &
      meaning='Lyapunov exponent per load cycle (per unit of time if the load has no frequency), &
      &the greatest first'), &
      column_type('exponents', 'error_per_cycle', unit='1/load cycle', &
      meaning='standard error of per_cycle'), &
      column_type('exponents', 'exponent', meaning='Lyapunov exponent per unit of time'), &
      column_type('exponents', 'standard_error', meaning='standard error of exponent'), &
      column_type('run', 'dimension', listed=.false., &
      meaning='Kaplan-Yorke dimension; nan unless there are all 2n exponents'), &
      column_type('run', 'identity_error', listed=.false., &
      meaning='error of the sum of the exponents per unit of time, which is known from damping and &
      &impacts; nan unless there are all of them and no rest'), &
      column_type('run', 'impacts', wholes, listed=.false., &
      meaning='impacts in the cycles averaged over'), &
      column_type('run', 'rests', wholes, listed=.false., &
      meaning='rests in the cycles averaged over')]

contains

   !> Declares the study.
   subroutine declare_lyapunov_structure(study)
      !> The declaration of the study.
      type(study_type), intent(out) :: study

      study%name = 'lyapunov_structure'
      study%group = 'lyapunov'
      study%of_structure = .true.
      study%meaning = 'compute the Lyapunov exponents of a structure with gaps'
      study%list => list_lyapunov
      study%row = 'exponents'
      study%check => check_lyapunov
      study%memory => lyapunov_memory
      study%run => run_lyapunov
   end subroutine declare_lyapunov_structure

   !> Lists the keys and columns.
   pure subroutine list_lyapunov(keys, columns)
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) keys = lyapunov_keys
      if (present(columns)) columns = lyapunov_columns
   end subroutine list_lyapunov

   !> Checks the rules that involve several keys.
   subroutine check_lyapunov(case)
      !> The case.
      type(case_type), intent(inout) :: case

      associate (study => case%study)
         if (len(study%fault) > 0) return
         call check_start_state(case)
         if (record_end(case) >= 0) call study%refuse('cycles', 'the load must be periodic or &
            &constant, not a record')
         if (study%whole_number('cycles') < 2*study%whole_number('batches')) call &
            study%refuse('cycles', 'batches is '//whole(study%whole_number('batches')))
         if (.not. study%has('directions')) call study%set('directions', [2.0_wp* &
            case%coordinates])
         if (study%whole_number('directions') > 2*case%coordinates) call &
            study%refuse('directions', 'there are '//whole(case%coordinates)//' coordinates')
      end associate
   end subroutine check_lyapunov

   !> Bytes for the matrices of the structure and those that follow from them, and the batches.
   pure real(wp) function lyapunov_memory(case) result(bytes)
      !> The case, checked.
      type(case_type), intent(in) :: case

      bytes = 800.0_wp*real(case%coordinates, wp)**2 + 16.0_wp*case%coordinates* &
         case%study%whole_number('batches')
   end function lyapunov_memory

   !> Computes the exponents.
   subroutine run_lyapunov(case, threads, result, progress)
      !> The case, checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> In: the result without tables. Out: with its tables and notes.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(structure_type) :: structure
      type(load_type) :: load
      type(average_type) :: average
      type(exponents_type) :: found
      character(:), allocatable :: cycle, text
      integer :: i, status

      associate (not_used => threads)    ! one simulation has one thread
      end associate
      call structure_of(case, structure, load)
      load%frequency = load_frequency(case)
      associate (s => case%study)
         average%batches = s%whole_number('batches')
         average%cycles = s%whole_number('cycles')/average%batches
         average%discard = s%whole_number('discard')
         average%directions = s%whole_number('directions')
         average%max_events = s%whole_number('max_events')
         call structure_exponents(structure, load, s%number('start'), s%numbers('q'), &
            s%numbers('q_dot'), average, found, status, progress)
      end associate
      result%empty = status /= stat%ok
      if (status == stat%not_computed) then
         result%cut = 'the simulation was stopped before its end'
      else if (status /= stat%ok) then
         call start_fault(structure, load, case%study%numbers('q'), status, text)
         call result%fail('no exponents: '//text)
      end if
      if (result%empty) return
      call result%open('exponents', 'direction', [average%directions])
      call result%put('exponents', 'number', [(i, i=1, average%directions)])
      call result%put('exponents', 'per_cycle', found%exponents*found%period)
      call result%put('exponents', 'error_per_cycle', found%deviations*found%period)
      call result%put('exponents', 'exponent', found%exponents)
      call result%put('exponents', 'standard_error', found%deviations)
      call result%open('run', '', [integer ::])
      call result%put('run', 'dimension', [found%dimension])
      call result%put('run', 'identity_error', [found%error])
      call result%put('run', 'impacts', [found%impacts])
      call result%put('run', 'rests', [found%rests])
      cycle = merge('load cycle  ', 'unit of time', load%frequency > 0)
      call result%add_note('greatest exponent '//shown(found%exponents(1)*found%period, 'f14.6')// &
         ' +- '//shown(found%deviations(1)*found%period, 'f14.6')//' per '//trim(cycle))
   end subroutine run_lyapunov

end module vi_lyapunov_structure_study
