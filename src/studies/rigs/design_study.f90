!> The study &design: clearance, mass and restitution of an impact damper for the best worst case.
!!
!! Optimisers of SciPy search, so that the Python package computes it; keys and columns are declared
!! here as of any other study. Simulations and their figures are those of
!! vi_attractor_performance.
module vi_design_study
   use vi_common_keys, only: least_gap, least_r, most_gap, most_r
   use vi_kinds, only: wp
   use vi_study, only: a_whole, a_word, case_type, column_type, key_type, of_oscillator, &
      of_target, result_type, study_type, truths, verdicts, wholes, words
   use vi_text, only: lower
   implicit none (type, external)
   private

   public :: declare_design

   !> Parameters that can be free or uncertain.
   character(14), parameter :: names(9) = [character(14) :: 'clearance', 'mu', 'xi', &
      'restitution', 'R1', 'R2', 'friction', 'wall_stiffness', 'wall_damping']
   !> Those of them with which units are simulated as structures.
   character(14), parameter :: elements(3) = names(7:)
   character(*), parameter :: of_walls = 'two numbers from 0 to 1, the lower one first', &
      spread = 'two numbers (all values in between are equally likely) or more (quantiles at even &
      &steps, in order); with the name in `normal`, mean and standard deviation', &
      of_free = 'uncertain values; for a free parameter deviations from its chosen value, &
      &including 0, or factors above 0, including 1'
   real(wp), parameter :: tiny_value = 1.0e-300_wp, least_stiffness = 1.0e-12_wp, most_element = &
      1.0e12_wp

   type(key_type), parameter :: design_keys(*) = [ &
      key_type('band', most=2, low=least_r, high=most_r, or='amplitude', &
      takes='one frequency ratio, or the lowest and the highest one', &
      unit='omega', meaning='frequency ratios at which the damper works'), &
      key_type('amplitude', most=2, low=1.0e-9_wp, high=1.0e9_wp, or='band', unit='F0/K', &
      takes='one displacement, or the least and the greatest one', &
      meaning='displacements from which free vibration starts, for target = ''damping'''), &
      key_type('target', a_word, default='''attenuation''', &
      words='attenuation displacement rms acceleration force damping', &
      meaning='what is minimised (max|X|/A, max|X|, rms, acceleration, force on the base), or&
      & maximised (damping)'), &
      key_type('limit', low=tiny_value, may_miss=.true., takes='a number > 0', unit=of_target, &
      meaning='required value of the target'), &
      key_type('quantile', default='0.99', low=0.5_wp, high=1.0_wp, &
      meaning='share of the units that must meet the limit; the search uses the same share'), &
      key_type('over', a_word, default='''worst''', words='worst basins', &
      meaning='''worst'': the worst attractor of a unit counts; ''basins'': each counts by its &
      &share of the initial states'), &
      key_type('clearance', low=least_gap, high=most_gap, may_miss=.true., unit='F0/K', &
      never='free_clearance', meaning='clearance d K/F0 at load 1 (d is the whole travel of m),&
      & if it is not free'), &
      key_type('load', most=1001, default='1', low=tiny_value, high=1.0e6_wp, &
      never='amplitude', takes='one load amplitude, or as for a tolerance', unit='F0', &
      meaning='load amplitude'), &
      key_type('free_clearance', least=2, most=2, low=least_gap, high=most_gap, may_miss=.true., &
      unit='F0/K', takes='two numbers from 1e-12 to 1e12, the lower one first', &
      meaning='range from which d K/F0 is chosen'), &
      key_type('free_mu', least=2, most=2, low=0.0_wp, high=1.0e6_wp, may_miss=.true., unit='M', &
      takes='two numbers from 0 to 1e6, the lower one first', &
      meaning='range from which the mass ratio m/M is chosen'), &
      key_type('free_xi', least=2, most=2, low=0.0_wp, high=1.0_wp, below=.true., &
      may_miss=.true., takes='two numbers from 0 to below 1, the lower one first', &
      meaning='range from which the damping ratio is chosen'), &
      key_type('free_restitution', least=2, most=2, low=0.0_wp, high=1.0_wp, may_miss=.true., &
      takes=of_walls, never='free_r1 free_r2', &
      meaning='range from which the restitution of both walls is chosen'), &
      key_type('free_r1', least=2, most=2, low=0.0_wp, high=1.0_wp, may_miss=.true., &
      takes=of_walls, meaning='range for the right wall only'), &
      key_type('free_r2', least=2, most=2, low=0.0_wp, high=1.0_wp, may_miss=.true., &
      takes=of_walls, meaning='range for the left wall only'), &
      key_type('free_friction', least=2, most=2, low=0.0_wp, high=most_element, may_miss=.true., &
      unit='F0', never='amplitude', takes='two numbers from 0 to 1e12, the lower one first', &
      meaning='range from which the friction between the free mass and its slot is chosen'), &
      key_type('free_wall_stiffness', least=2, most=2, low=least_stiffness, high=most_element, &
      may_miss=.true., unit='K', never='amplitude', &
      takes='two numbers from 1e-12 to 1e12, the lower one first', &
      meaning='range from which the stiffness of both walls is chosen, as elastic stops'), &
      key_type('free_wall_damping', least=2, most=2, low=0.0_wp, high=most_element, &
      may_miss=.true., unit='K/omega', never='amplitude', &
      takes='two numbers from 0 to 1e12, the lower one first', &
      meaning='range from which the damping of both walls is chosen, if they are elastic'), &
      key_type('tolerance_clearance', least=2, most=1001, may_miss=.true., unit='F0/K', &
      takes=spread, meaning=of_free), &
      key_type('tolerance_mu', least=2, most=1001, may_miss=.true., unit='M', takes=spread, &
      meaning=of_free), &
      key_type('tolerance_xi', least=2, most=1001, may_miss=.true., takes=spread, &
      meaning=of_free), &
      key_type('tolerance_restitution', least=2, most=1001, may_miss=.true., takes=spread, &
      never='tolerance_r1 tolerance_r2', meaning=of_free), &
      key_type('tolerance_r1', least=2, most=1001, may_miss=.true., takes=spread, &
      meaning=of_free), &
      key_type('tolerance_r2', least=2, most=1001, may_miss=.true., takes=spread, &
      meaning=of_free), &
      key_type('tolerance_friction', least=2, most=1001, may_miss=.true., never='amplitude', &
      takes=spread, meaning=of_free), &
      key_type('tolerance_wall_stiffness', least=2, most=1001, may_miss=.true., &
      never='amplitude', takes=spread, meaning=of_free), &
      key_type('tolerance_wall_damping', least=2, most=1001, may_miss=.true., never='amplitude', &
      takes=spread, meaning=of_free), &
      key_type('normal', a_word, most=10, may_miss=.true., words='clearance mu xi restitution R1 &
      &R2 friction wall_stiffness wall_damping load', takes='names of parameters or ''load''', &
      meaning='parameters whose tolerance gives mean and standard deviation of a normal &
      &distribution'), &
      key_type('limit_displacement', low=tiny_value, may_miss=.true., never='amplitude', &
      unit='F0/K', &
      takes='a number > 0', meaning='greatest allowed |X|'), &
      key_type('limit_rms', low=tiny_value, may_miss=.true., never='amplitude', &
      unit='F0/K', takes='a number > 0', &
      meaning='greatest allowed root mean square of X'), &
      key_type('limit_acceleration', low=tiny_value, may_miss=.true., never='amplitude', &
      unit='omega^2 F0/K', &
      takes='a number > 0', meaning='greatest allowed acceleration between impacts'), &
      key_type('limit_force', low=tiny_value, may_miss=.true., never='amplitude', &
      unit='F0', takes='a number > 0', &
      meaning='greatest allowed force on the base'), &
      key_type('limit_speed', low=tiny_value, may_miss=.true., never='amplitude', &
      unit='omega F0/K', &
      takes='a number > 0', meaning='greatest allowed approach speed of an impact'), &
      key_type('limit_multiplier', low=tiny_value, may_miss=.true., never='amplitude', &
      takes='a number > 0', meaning='greatest allowed modulus of the multipliers; a motion &
      &without a period exceeds it'), &
      key_type('limit_least_speed', low=tiny_value, may_miss=.true., never='amplitude', &
      unit='omega F0/K', takes='a number > 0', meaning='least allowed approach speed of an impact &
      &(margin from zero approach); 0 with rest'), &
      key_type('limit_least_gap', low=tiny_value, may_miss=.true., never='amplitude', &
      unit='F0/K', takes='a number > 0', meaning='least allowed distance from a wall that the free &
      &mass approaches without impact (margin from grazing); 0 with rest'), &
      key_type('cycles', a_whole, default='5', low=1.0_wp, high=1.0e4_wp, only='amplitude', &
      meaning='oscillations over which the damping of free vibration is averaged'), &
      key_type('states', a_whole, default='2', low=1.0_wp, high=64.0_wp, &
      meaning='initial states of each unit; the search uses more if there are few units'), &
      key_type('samples', a_whole, default='100000', low=0.0_wp, high=1.0e9_wp, &
      takes='0 or a whole number from 10 to 1e9', &
      meaning='independent samples of the confirmation; 0 for none'), &
      key_type('evaluations', a_whole, default='96', low=8.0_wp, high=1.0e6_wp, &
      meaning='initial candidates of each global search'), &
      key_type('searches', a_whole, default='8', low=1.0_wp, high=1000.0_wp, &
      meaning='largest number of independent global searches; they end when three find one &
      &design'), &
      key_type('specimens', a_whole, default='16', low=1.0_wp, high=1.0e5_wp, &
      meaning='units by which the best candidates are judged'), &
      key_type('nodes', a_whole, default='9', low=2.0_wp, high=1.0e4_wp, &
      meaning='frequencies, or displacements, at which these units are judged'), &
      key_type('settling', a_whole, default='400', low=8.0_wp, high=1.0e6_wp, &
      never='amplitude', &
      meaning='load cycles after which a simulation without a period counts as settled'), &
      key_type('keep', a_whole, default='32', low=1.0_wp, high=1.0e6_wp, never='amplitude', &
      meaning='load cycles examined afterwards'), &
      key_type('seed', a_whole, default='0', low=0.0_wp, high=2.0e9_wp, &
      meaning='seed of the searches and of the samples of the confirmation')]

   type(column_type), parameter :: design_columns(*) = [ &
      column_type('chosen', 'name', words, meaning='the free parameter'), &
      column_type('chosen', 'value', unit='mixed', meaning='its chosen value'), &
      column_type('chosen', 'low', unit='mixed', meaning='lower end of its range'), &
      column_type('chosen', 'high', unit='mixed', meaning='upper end of its range'), &
      column_type('design', 'target', words, listed=.false., meaning='what was minimised'), &
      column_type('design', 'limit', unit='mixed', listed=.false., &
      meaning='required value; NaN if there is none'), &
      column_type('design', 'quantile', listed=.false., &
      meaning='required share of the units that reach it'), &
      column_type('design', 'first', listed=.false., meaning='lower end of the band'), &
      column_type('design', 'last', listed=.false., meaning='upper end of the band'), &
      column_type('design', 'level', unit='mixed', listed=.false., &
      meaning='quantile of the target over the units of the search, at the worst frequency'), &
      column_type('design', 'excess', listed=.false., &
      meaning='the same quantile of the largest ratio of a quantity to its limit; 0 without &
      &limits'), &
      column_type('design', 'worst', unit='mixed', listed=.false., &
      meaning='worst target of all samples and of the units of the search'), &
      column_type('design', 'samples', wholes, listed=.false., &
      meaning='samples of the confirmation'), &
      column_type('design', 'failed', wholes, listed=.false., &
      meaning='samples whose simulation was abandoned; they count as bad'), &
      column_type('design', 'probability', listed=.false., &
      meaning='share of the samples within all limits; without limits, of those at most 2 % &
      &worse than the level'), &
      column_type('design', 'low', listed=.false., &
      meaning='lower end of its 95 % interval (Clopper-Pearson)'), &
      column_type('design', 'high', listed=.false., meaning='upper end'), &
      column_type('design', 'feasible', verdicts, listed=.false., meaning='whether the limit &
      &holds for the quantile of the units in every part of the band'), &
      column_type('design', 'converged', verdicts, listed=.false., &
      meaning='whether three searches ended at the best design, not known with fewer; false, &
      &whatever their number, if samples contradict its level'), &
      column_type('design', 'contradicted', verdicts, listed=.false., meaning='whether samples &
      &contradict its level; not known without such samples'), &
      column_type('searches', 'candidates', wholes, listed=.false., &
      meaning='candidates of a search'), &
      column_type('searches', 'level', unit='mixed', listed=.false., meaning='its best level'), &
      column_type('bands', 'from', listed=.false., meaning='lowest r of a part of the band'), &
      column_type('bands', 'to', listed=.false., meaning='highest r'), &
      column_type('bands', 'samples', wholes, listed=.false., meaning='samples in it'), &
      column_type('bands', 'good', wholes, listed=.false., meaning='those counted as good'), &
      column_type('bands', 'probability', listed=.false., meaning='their share'), &
      column_type('bands', 'low', listed=.false., meaning='lower end of its interval, with a joint &
      &confidence of 95 % for all parts'), &
      column_type('bands', 'high', listed=.false., meaning='upper end'), &
      column_type('bands', 'worst', unit='mixed', listed=.false., meaning='worst target'), &
      column_type('sensitivities', 'name', words, listed=.false., meaning='a parameter'), &
      column_type('sensitivities', 'slope', unit='mixed', listed=.false., &
      meaning='derivative of the target of the worst unit with respect to it'), &
      column_type('candidates', 'values', unit='mixed', each='choice', listed=.false., &
      meaning='the free parameters'), &
      column_type('candidates', 'nominal', unit='mixed', listed=.false., &
      meaning='level of the unit without deviations; NaN if not judged by all runs'), &
      column_type('candidates', 'level', unit='mixed', listed=.false., &
      meaning='level of all units; a bound of it for a candidate judged by fewer runs'), &
      column_type('candidates', 'runs', wholes, listed=.false., &
      meaning='runs by which it was judged'), &
      column_type('candidates', 'front', truths, listed=.false., &
      meaning='whether no other candidate is better in both')]

contains

   !> Declares the study, with its keys and columns.
   pure subroutine declare_design(study, keys, columns)
      !> The study.
      type(study_type), intent(out), optional :: study
      !> The keys of the group.
      type(key_type), allocatable, intent(out), optional :: keys(:)
      !> The columns of the result.
      type(column_type), allocatable, intent(out), optional :: columns(:)

      if (present(keys)) keys = design_keys
      if (present(columns)) columns = design_columns
      if (.not. present(study)) return
      study%name = 'design'
      study%models = of_oscillator
      study%meaning = 'design an impact damper for a frequency band, with tolerances'
      study%finds_r = .true.
      study%in_python = .true.
      study%row = 'chosen'
      study%check => check_design
   end subroutine declare_design

   !> Checks the rules that involve several keys.
   subroutine check_design(case)
      !> The case.
      type(case_type), intent(inout) :: case
      character(:), allocatable :: name
      character(2), parameter :: wall(2) = ['r1', 'r2']
      real(wp) :: least_xi
      integer :: i

      associate (study => case%study)
         if (len(study%fault) > 0) return
         if (study%is('target', 'damping') .neqv. study%has('amplitude')) call study%refuse( &
            'target', '''damping'' needs an amplitude, and the others a band')
         if (study%has('band')) call check_order(case, 'band')
         if (study%has('amplitude')) call check_order(case, 'amplitude')
         least_xi = case%osc%xi
         if (study%has('free_xi')) least_xi = minval(study%numbers('free_xi'))
         if (study%has('tolerance_xi') .and. .not. study%has('free_xi')) then
            least_xi = minval(study%numbers('tolerance_xi'))
         end if
         if (study%has('band') .and. .not. least_xi > 0) then
            associate (band => study%numbers('band'))
               if (band(1) <= 1 .and. band(size(band)) >= 1) call study%refuse('band', &
                  'without damping r = 1 is resonance')
            end associate
         end if
         do i = 1, size(names)
            name = 'free_'//lower(trim(names(i)))
            if (study%has(name)) call check_order(case, name)
            call check_spread(case, trim(names(i)))
         end do
         ! what is said of both walls would replace what is said of one
         do i = 1, 2
            if (study%has('free_restitution') .and. study%has('tolerance_'//wall(i))) call &
               study%forbid('tolerance_'//wall(i), ' if free_restitution is given')
            if (study%has('tolerance_restitution') .and. study%has('free_'//wall(i))) call &
               study%forbid('free_'//wall(i), ' if tolerance_restitution is given')
         end do
         call check_walls(case)
         if (.not. any([(study%has('free_'//lower(trim(names(i)))), i=1, size(names))])) call &
            study%refuse('free_clearance', 'at least one parameter must be free')
         if (.not. (study%has('clearance') .or. study%has('free_clearance') .or. &
            study%has('tolerance_clearance'))) call study%refuse('clearance', &
            'it must be given, be free, or have a tolerance')
         if (study%has('tolerance_clearance') .and. study%has('clearance')) then
            call study%forbid('clearance', ' if tolerance_clearance is given, unless it is free')
         end if
         if (study%whole_number('samples') > 0 .and. study%whole_number('samples') < 10) then
            call study%refuse('samples')
         end if
      end associate
   end subroutine check_design

   !> Refuses coefficients of restitution of compliant walls, the damping of walls that do not, and
   !! the figure that structures lack.
   subroutine check_walls(case)
      !> The case.
      type(case_type), intent(inout) :: case
      character(:), allocatable :: key
      integer :: i, j
      character(10), parameter :: groups(2) = [character(10) :: 'free_', 'tolerance_']

      associate (study => case%study)
         do j = 1, 2
            do i = 1, 3
               key = trim(groups(j))//lower(trim(elements(i)))
               if (.not. study%has(key)) cycle
               if (study%has('limit_least_gap')) call study%forbid('limit_least_gap', &
                  ' with '//key)
               if (elements(i) == 'wall_damping' .and. .not. (study%has('free_wall_stiffness') &
                  .or. study%has('tolerance_wall_stiffness'))) call study%forbid(key, &
                  ' without a wall_stiffness, since rigid walls have no damping')
               if (elements(i) == 'wall_stiffness') call forbid_restitution(case, key)
            end do
         end do
      end associate
   end subroutine check_walls

   !> Refuses coefficients of restitution of compliant walls.
   subroutine forbid_restitution(case, key)
      !> The case.
      type(case_type), intent(inout) :: case
      !> The key of the stiffness.
      character(*), intent(in) :: key
      character(11), parameter :: rigid(3) = [character(11) :: 'restitution', 'r1', 'r2']
      integer :: i

      do i = 1, 3
         if (case%study%has('free_'//trim(rigid(i)))) call case%study%forbid('free_'// &
            trim(rigid(i)), ' with '//key)
         if (case%study%has('tolerance_'//trim(rigid(i)))) call case%study%forbid('tolerance_'// &
            trim(rigid(i)), ' with '//key)
      end do
   end subroutine forbid_restitution

   !> Refuses a range whose ends are not in order.
   subroutine check_order(case, name)
      !> The case.
      type(case_type), intent(inout) :: case
      !> The key.
      character(*), intent(in) :: name

      associate (values => case%study%numbers(name))
         if (size(values) < 2) return
         if (values(1) > values(2)) call case%study%refuse(name)
         if (name(1:4) == 'free' .and. .not. values(1) < values(2)) call case%study%refuse(name)
      end associate
   end subroutine check_order

   !> Refuses a tolerance that leads out of the range of its parameter.
   subroutine check_spread(case, name)
      !> The case.
      type(case_type), intent(inout) :: case
      !> The parameter.
      character(*), intent(in) :: name
      character(:), allocatable :: key
      real(wp) :: ends(2), most
      logical :: centred

      associate (study => case%study)
         key = lower(name)
         if (.not. study%has('tolerance_'//key)) return
         associate (values => study%numbers('tolerance_'//key))
            if (study%is('normal', name)) then
               if (size(values) /= 2 .or. .not. values(size(values)) > 0) then
                  call study%refuse('tolerance_'//key)
                  return
               end if
               ends = values(1) + 6*values(2)*[-1, 1]
               centred = .not. abs(values(1) - merge(1, 0, ends(1) > 0)) > 0
            else
               if (any(values(2:) < values(:size(values) - 1))) call study%refuse( &
                  'tolerance_'//key)
               ends = [values(1), values(size(values))]
               centred = .true.
            end if
         end associate
         if (study%has('free_'//key)) then
            ! factors, or deviations
            if (ends(1) > 0) then
               centred = centred .and. ends(1) <= 1 .and. ends(2) >= 1
               ends = ends*study%numbers('free_'//key)
            else
               centred = centred .and. ends(2) >= 0
               ends = ends + study%numbers('free_'//key)
            end if
            if (.not. centred) then
               call study%refuse('tolerance_'//key, name//' is free, so these are deviations with &
                  &0 among them, or factors above 0 with 1 among them; if normal, with mean 0 or 1')
               return
            end if
         end if
         most = 1
         if (name == 'clearance') most = most_gap
         if (name == 'mu') most = 1.0e6_wp
         if (any(name == elements)) most = most_element
         if (ends(1) < 0 .or. ends(2) > most .or. (name == 'clearance' .and. ends(1) < least_gap) &
            .or. (name == 'wall_stiffness' .and. ends(1) < least_stiffness) &
            .or. (name == 'xi' .and. .not. ends(2) < 1)) call study%refuse('tolerance_'//key, &
            'the resulting values (up to 6 standard deviations if normal) must be in the range of &
            &'// &
            name)
      end associate
   end subroutine check_spread

end module vi_design_study
