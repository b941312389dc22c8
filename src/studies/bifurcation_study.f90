!> The study &bifurcation: the impacts that are left along a parameter.
module vi_bifurcation_study
   use vi_case, only: case_type
   use vi_common_keys, only: check_parameter, check_product, check_start, clearance_key, load_key, &
      parameter_takes, parameter_words, range_takes, spacing_key, state_keys, &
      state_of
   use vi_key, only: a_whole, a_word, key_type
   use vi_kinds, only: wp
   use vi_text, only: whole
   use vi_window, only: most_numbers
   implicit none (type, external)
   private

   public :: check_bifurcation, start_state

   character(*), parameter :: own = '=: sweep = ''states'' has states of its own', states = &
      'sweep=states'
   type(key_type), parameter, public :: bifurcation_keys(*) = [ &
      key_type('clearance', low=clearance_key%low, high=clearance_key%high, &
      never='parameter=clearance', why='=: it is the parameter', unit='F0/K', &
      meaning=clearance_key%meaning), &
      key_type('parameter', a_word, words=parameter_words, takes=parameter_takes, &
      meaning='what changes'), &
      key_type('low', takes=range_takes, meaning='first value'), &
      key_type('high', over='low', takes=range_takes, meaning='last value'), &
      key_type('values', a_whole, low=2.0_wp, high=1.0e6_wp, meaning='how many'), &
      spacing_key, &
      key_type('sweep', a_word, default='''both''', words='up down both states', &
      meaning='up, down, both: the state is carried from value to value; states: each value starts &
      &anew from many states'), &
      key_type('states', a_whole, default='12', low=1.0_wp, high=1.0e6_wp, only=states, &
      meaning='how many, spread evenly'), &
      key_type('settling', a_whole, default='300', low=0.0_wp, high=1.0e7_wp, &
      meaning='load cycles simulated at each value before anything is looked at'), &
      key_type('keep', a_whole, default='33', low=3.0_wp, high=1.0e4_wp, &
      meaning='load cycles then looked at: periods of up to half of them are seen'), &
      key_type('points', a_whole, default='100', low=1.0_wp, high=4096.0_wp, &
      meaning='impacts kept of each run and value'), &
      key_type('t', may_miss=.true., never=states, why=own, unit='1/omega', &
      meaning=state_keys(1)%meaning), &
      key_type('x', may_miss=.true., never=states, why=own, unit='F0/K', &
      meaning=state_keys(2)%meaning), &
      key_type('x_dot', may_miss=.true., never=states, why=own, unit='omega F0/K', &
      meaning=state_keys(3)%meaning), &
      key_type('z', may_miss=.true., never=states, why=own, unit='F0/K', &
      meaning=state_keys(4)%meaning), &
      key_type('z_dot', may_miss=.true., never=states, why=own, unit='omega F0/K', &
      meaning=state_keys(5)%meaning), &
      load_key]

contains

   !> Checks what depends on several keys.
   subroutine check_bifurcation(case)
      !> The case; a state that is given in part is completed with zeros.
      type(case_type), intent(inout) :: case
      integer :: runs, i

      call check_parameter(case)
      associate (study => case%study)
         if (len(study%fault) > 0) return
         runs = merge(2, 1, study%is('sweep', 'both'))
         if (study%has('states')) runs = study%whole_number('states')
         call check_product(study, 'points', [study%whole_number('values'), runs, &
            study%whole_number('points')], 'values x runs x points must be at most '//whole( &
            most_numbers))
         if (.not. any([(study%has(trim(state_keys(i)%name)), i=1, 5)])) return
         do i = 1, 5
            if (.not. study%has(trim(state_keys(i)%name))) call &
               study%set(trim(state_keys(i)%name), &
               [0.0_wp])
         end do
         if (study%has('clearance')) then
            call check_start(study, study%number('clearance'))
         else
            call check_start(study, study%number(trim(merge('high', 'low ', study%is('sweep', &
               'down')))))
         end if
      end associate
   end subroutine check_bifurcation

   !> The state that sweeps start from: t, x, x', z, z'; empty if none was given.
   pure function start_state(case) result(state)
      !> The case, checked.
      type(case_type), intent(in) :: case
      real(wp), allocatable :: state(:)

      allocate (state(0))
      if (case%study%has('t')) state = state_of(case%study)
   end function start_state

end module vi_bifurcation_study
