!> The study &identify: the parameters of a rig from records of its load and its motion.
!!
!! Impacts are picked by filters of SciPy, so that the Python package computes it; keys and columns
!! are declared here as of any other study.
module vi_identify_study
   use vi_kinds, only: wp
   use vi_study, only: a_whole, a_word, case_type, column_type, complexes, key_type, &
      of_oscillator, result_type, study_type, wholes, words
   implicit none (type, external)
   private

   public :: declare_identify

   !> Quantities of which a record has channels.
   character(*), parameter :: channel_words = 'load acceleration velocity displacement none'
   character(*), parameter :: with_times = 'impact_times'
   !> Known values of a rig that may be keys of &system instead.
   character(14), parameter :: of_rig(3) = [character(14) :: 'mass', 'stiffness', &
      'load_amplitude'], of_system(3) = [character(14) :: 'mass', 'stiffness', 'force']
   real(wp), parameter :: tiny_value = 1.0e-12_wp, huge_value = 1.0e12_wp
   !> What the keys of known values take, after 'one number from 1e-12'.
   character(*), parameter :: or_two = ' to 1e12, or two, of which the second is its standard &
      &error; both as texts with units, or both plain'

   type(key_type), parameter :: identify_keys(*) = [ &
      key_type('impact_times', least=2, most=100000, or='records', unit='s', &
      takes='increasing finite numbers', meaning='times of impacts, instead of a record'), &
      key_type('records', a_word, most=50, file=.true., or=with_times, &
      takes='paths of records: .csv, .wav, .mat, .nc, .json (SEP005) or .uff', &
      meaning='records of load and motion; relative to the folder of the namelist, or else to the &
      &working directory'), &
      key_type('impact_sides', a_word, only=with_times, may_miss=.true., &
      takes='one letter R or L for each of the impact_times', meaning='walls of the impacts'), &
      key_type('frequency', low=tiny_value, high=huge_value, may_miss=.true., &
      unit='Hz', &
      meaning='load frequency; by default that of the load channel, or else of the motion'), &
      key_type('load_phase', only=with_times, may_miss=.true., unit='rad', &
      meaning='phase of the load at time 0, if it is known'), &
      key_type('channels', a_word, most=64, words=channel_words, never=with_times, &
      may_miss=.true., takes='''load'', ''acceleration'', ''velocity'', ''displacement'' or &
      &''none'', one for each channel', meaning='quantities of the channels of the record; by &
      &default taken from their names'), &
      key_type('channel_units', a_word, most=64, never=with_times, may_miss=.true., &
      takes='units such as ''N'', ''m/s^2'', ''g'' or ''mm'', one for each channel', &
      meaning='units of the channels; by default those of the record'), &
      key_type('rate', low=tiny_value, high=huge_value, never=with_times, may_miss=.true., &
      unit='Hz', meaning='sampling rate of a record that does not state it'), &
      key_type('bandwidth', low=0.0_wp, high=huge_value, most=64, never=with_times, &
      may_miss=.true., unit='Hz', takes='one number for the motion, or one for each channel, 0 if &
      &it is not known', meaning='-3 dB frequency of the low-pass (Butterworth, order 4) of &
      &the motion sensor, or of each channel in order; by default none'), &
      key_type('delay', low=-1.0_wp, high=1.0_wp, most=64, never=with_times, may_miss=.true., &
      unit='s', takes='one number for the motion, or one for each channel', &
      meaning='delay of the motion channel, or of each channel in order, beyond that of its &
      &low-pass; fitted by default'), &
      key_type('range', low=0.0_wp, high=huge_value, most=64, never=with_times, &
      may_miss=.true., takes='one number for the motion, or one for each channel, 0 if it is not &
      &known', meaning='full scale of the motion sensor, or of each channel in order, in its &
      &unit'), &
      key_type('noise', low=0.0_wp, high=huge_value, most=64, never=with_times, &
      may_miss=.true., takes='one number for the motion, or one for each channel, 0 if it is not &
      &known', meaning='root mean square of the noise of the motion channel, or of each &
      &channel in order, in its unit'), &
      key_type('calibration', low=0.0_wp, high=0.5_wp, never=with_times, may_miss=.true., &
      meaning='relative standard error of the calibration of each sensor; by default 0.01'), &
      key_type('mass', most=2, low=tiny_value, high=huge_value, may_miss=.true., &
      unit='kg', &
      takes='one number from 1e-12'//or_two, &
      meaning='primary mass M, if it is known, and its standard error'), &
      key_type('stiffness', most=2, low=tiny_value, high=huge_value, may_miss=.true., &
      unit='N/m', takes='one number from 1e-12'//or_two, &
      meaning='stiffness K, if it is known, and its standard error'), &
      key_type('damping', most=2, low=0.0_wp, high=huge_value, may_miss=.true., unit='N s/m', &
      takes='one number from 0'//or_two, &
      meaning='damping coefficient C, if it is known, and its standard error'), &
      key_type('free_mass', most=2, low=tiny_value, high=huge_value, may_miss=.true., unit='kg', &
      takes='one number from 1e-12'//or_two, &
      meaning='free mass m, if it is known, and its standard error'), &
      key_type('clearance', most=2, low=tiny_value, high=huge_value, may_miss=.true., &
      unit='m', takes='one number from 1e-12'//or_two, &
      meaning='d, the whole travel of m between the walls, if it is known, and its &
      &standard error'), &
      key_type('natural_frequency', most=2, low=tiny_value, high=huge_value, may_miss=.true., &
      unit='Hz', &
      takes='one number from 1e-12'//or_two, &
      meaning='omega/(2 pi), if it is known, and its standard error'), &
      key_type('load_amplitude', most=2, low=tiny_value, high=huge_value, may_miss=.true., &
      unit='N', &
      takes='one number from 1e-12'//or_two, &
      meaning='load amplitude F0, if it is known, and its standard error; by default that of the &
      &load channel'), &
      key_type('fixed', a_word, most=4, words='xi mu R1 R2', may_miss=.true., &
      takes='some of ''xi'', ''mu'', ''R1'' and ''R2''', &
      meaning='parameters of &system that are known; the others are starting values of the fit'), &
      key_type('law', a_word, may_miss=.true., &
      words='constant power powers knee knees table tables', &
      meaning='restitution at speed v: constant, R (v/v0)^-p, with a knee, or a table; plural: &
      &one for each wall; by default constant or powers'), &
      key_type('law_speed', low=tiny_value, high=huge_value, only='law', never='law=constant', &
      may_miss=.true., unit='m/s', meaning='speed v0 to which R1 and R2 apply; by default the &
      &geometric mean of the speeds of all impacts'), &
      key_type('law_exponent', low=-10.0_wp, high=10.0_wp, least=1, most=2, only='law', &
      never='law=constant', &
      may_miss=.true., takes='one number, or two if each wall has its own', &
      meaning='exponent p, if it is known; one, or one for the right and one for the left wall'), &
      key_type('law_knee', low=tiny_value, high=huge_value, least=1, most=2, only='law', &
      never='law=constant', &
      may_miss=.true., unit='m/s', takes='one speed, or two with law = ''knees''', &
      meaning='speed at which the power law begins, if it is known; one, or one for the right and &
      &one for the left wall'), &
      key_type('law_knots', a_whole, low=2.0_wp, high=20.0_wp, may_miss=.true., &
      meaning='number of knots of a table, between the speeds of the impacts; by default 3'), &
      key_type('friction', a_word, never=with_times, may_miss=.true., &
      takes='''fit'', a fraction of F0 such as ''0.01'', or a force such as ''0.3 N''', &
      meaning='dry friction of the free mass in its slot, known or fitted; by default none is &
      &assumed, and this is tested')]

   type(column_type), parameter :: identify_columns(*) = [ &
      column_type('parameters', 'name', words, meaning='the parameter'), &
      column_type('parameters', 'value', &
      meaning='its value; if it is undetermined, the starting value of the fit'), &
      column_type('parameters', 'error', meaning='its standard error; 0 if it is known exactly'), &
      column_type('parameters', 'low', meaning='lower end of its 95 % interval'), &
      column_type('parameters', 'high', meaning='upper end of its 95 % interval'), &
      column_type('parameters', 'unit', words, meaning='its unit'), &
      column_type('parameters', 'state', words, words='fitted,known,undetermined', &
      meaning='whether it was fitted, is known, or cannot be determined from the records'), &
      column_type('records', 'status', words, listed=.false., &
      words='periodic,not periodic,accumulation,rest,no impacts', meaning='how the impacts &
      &repeat'), &
      column_type('records', 'quantity', words, listed=.false., &
      words='acceleration,velocity,displacement,impact times', meaning='what was measured'), &
      column_type('records', 'sides', words, listed=.false., &
      meaning='walls of the impacts of a period, in order'), &
      column_type('records', 'cycles', wholes, listed=.false., &
      meaning='load cycles in a period; 0 if there is none'), &
      column_type('records', 'frequency', unit='Hz', listed=.false., meaning='load frequency'), &
      column_type('records', 'load', unit='N', listed=.false., &
      meaning='load amplitude; NaN if it is not known'), &
      column_type('records', 'load_phase', unit='rad', listed=.false., &
      meaning='phase of the load at the first sample'), &
      column_type('records', 'r', listed=.false., meaning='frequency ratio'), &
      column_type('records', 'clearance', unit='F0/K', listed=.false., &
      meaning='clearance d K/F0'), &
      column_type('records', 'static', unit='m', listed=.false., meaning='F0/K'), &
      column_type('records', 'first', unit='s', listed=.false., &
      meaning='time of the first impact of the fitted motion'), &
      column_type('records', 'misfit', listed=.false., &
      meaning='sum of squares of the weighted residuals over the degrees of freedom'), &
      column_type('records', 'multipliers', complexes, each='multiplier', listed=.false., &
      meaning='multipliers of the identified motion'), &
      column_type('records', 'harmonics', complexes, each='harmonic', listed=.false., &
      meaning='c of the harmonics n = 2, 3, ... of the load over its fundamental, which add &
      &the real part of c exp(i n p) to sin(p); 0 if they are not significant'), &
      column_type('impacts', 'number', wholes, listed=.false., meaning='number of the record'), &
      column_type('impacts', 'side', words, words='R,L', listed=.false., meaning='wall'), &
      column_type('impacts', 'picked', unit='rad', listed=.false., &
      meaning='load phase of the impact of a period, as detected, to a fraction of a sample'), &
      column_type('impacts', 'picked_error', unit='rad', listed=.false., &
      meaning='its standard error'), &
      column_type('impacts', 'fitted', unit='rad', listed=.false., &
      meaning='load phase in the fitted motion'), &
      column_type('impacts', 'speed', unit='m/s', listed=.false., &
      meaning='approach speed in the fitted motion'), &
      column_type('impacts', 'restitution', listed=.false., &
      meaning='coefficient of restitution in the fitted motion'), &
      column_type('picks', 'number', wholes, listed=.false., meaning='number of the record'), &
      column_type('picks', 'time', unit='s', listed=.false., meaning='time of each impact'), &
      column_type('picks', 'side', words, words='R,L', listed=.false., meaning='wall'), &
      column_type('samples', 'number', wholes, listed=.false., meaning='number of the record'), &
      column_type('samples', 'time', unit='s', listed=.false., &
      meaning='time of samples of the first periods'), &
      column_type('samples', 'load', unit='N', listed=.false., meaning='load, as recorded'), &
      column_type('samples', 'load_fit', unit='N', listed=.false., meaning='fitted load'), &
      column_type('samples', 'motion', listed=.false., meaning='motion, as recorded'), &
      column_type('samples', 'motion_fit', listed=.false., &
      meaning='the fitted motion as the sensor shows it')]

contains

   !> Declares the study, with its keys and columns.
   pure subroutine declare_identify(study, keys, columns)
      !> The study.
      type(study_type), intent(out), optional :: study
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) keys = identify_keys
      if (present(columns)) columns = identify_columns
      if (.not. present(study)) return
      study%name = 'identify'
      study%models = of_oscillator
      study%meaning = 'identify the parameters of a rig from its records'
      study%finds_r = .true.
      study%in_python = .true.
      study%row = 'parameters'
      study%check => check_identify
   end subroutine declare_identify

   !> Checks the rules that involve several keys.
   subroutine check_identify(case)
      !> The case.
      type(case_type), intent(inout) :: case

      integer :: i

      associate (study => case%study)
         if (len(study%fault) > 0) return
         do i = 1, size(of_rig)
            if (case%system%has(trim(of_system(i)))) call study%forbid(trim(of_rig(i)), &
               ' if '//trim(of_system(i))//' is given in &system: both are one value')
         end do
         if (len(study%fault) > 0 .or. .not. study%has(with_times)) return
         associate (times => study%numbers(with_times))
            if (any(times(2:) <= times(:size(times) - 1))) call study%refuse(with_times)
         end associate
         if (.not. study%has('frequency')) call study%refuse('frequency', &
            'given with impact_times')
      end associate
   end subroutine check_identify

end module vi_identify_study
