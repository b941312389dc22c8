!> The study &basins: to which attractor states go.
module vi_basins_study
   use vi_attractor_spread, only: random_states
   use vi_case, only: case_type
   use vi_common_keys, only: check_product, clearance_key, half_gap, load_key
   use vi_key, only: a_whole, a_word, key_type
   use vi_kinds, only: wp
   use vi_text, only: whole
   use vi_values, only: values_type
   use vi_window, only: even, most_numbers
   implicit none (type, external)
   private

   public :: check_basins, initial_states

   !> Coordinates of a state; y is z - x.
   character(5), parameter, public :: axis_names(5) = [character(5) :: 't', 'x', 'x_dot', 'y', &
      'z_dot']

   character(*), parameter :: beside = 'states', random = &
      ': they are random in all coordinates, at t = 0'
   type(key_type), parameter, public :: basins_keys(*) = [clearance_key, &
      key_type('states', a_whole, may_miss=.true., low=1.0_wp, high=real(most_numbers, wp), &
      meaning='instead of a plane: this many random states'), &
      key_type('seed', a_whole, default='0', low=0.0_wp, high=real(huge(1), wp), only='states', &
      meaning='which random states'), &
      key_type('axes', a_word, least=2, most=2, words='x x_dot y z_dot t', never=beside, &
      why=random, takes='two of ''x'', ''x_dot'', ''y'' (z - x), ''z_dot'' and ''t'', or states = &
      &N instead of a plane', meaning='the plane of initial states'), &
      key_type('low', least=2, most=2, never=beside, why=random, &
      takes='two finite numbers, one an axis', meaning='first values'), &
      key_type('high', least=2, most=2, over='low', never=beside, why=random, &
      takes='two finite numbers, one an axis', meaning='last values'), &
      key_type('values', a_whole, least=2, most=2, low=2.0_wp, high=1.0e5_wp, never=beside, &
      why=random, takes='two whole numbers, one an axis, each with 2 <= values <= 100000', &
      meaning='how many'), &
      key_type('t', default='0', never=beside, why=random, unit='1/omega', &
      meaning='time, unless it is an axis'), &
      key_type('x', default='0', never=beside, why=random, unit='F0/K', &
      meaning='displacement of the primary mass, unless it is an axis'), &
      key_type('x_dot', default='0', never=beside, why=random, unit='omega F0/K', &
      meaning='velocity of the primary mass, unless it is an axis'), &
      key_type('y', default='0', never=beside, why=random, unit='F0/K', &
      meaning='z - x, unless it is an axis'), &
      key_type('z_dot', default='0', never=beside, why=random, unit='omega F0/K', &
      meaning='velocity of the free mass, unless it is an axis'), &
      key_type('cycles', a_whole, default='1000', low=1.0_wp, high=1.0e7_wp, &
      meaning='load cycles in which a state should be decided'), &
      key_type('probes', a_whole, default='200', low=1.0_wp, high=1.0e6_wp, &
      meaning='states simulated first, to find attractors'), &
      key_type('max_cycles', a_whole, default='16', low=1.0_wp, high=100.0_wp, &
      meaning='longest period that is looked for, in load cycles'), &
      load_key]

contains

   !> Checks what depends on several keys.
   subroutine check_basins(case)
      !> The case; coordinates that are axes lose their values.
      type(case_type), intent(inout) :: case
      real(wp) :: low(2), high(2)
      integer :: i

      associate (study => case%study)
         if (len(study%fault) > 0 .or. study%has('states')) return
         low = study%numbers('low')
         high = study%numbers('high')
         if (study%word('axes', 1) == study%word('axes', 2)) call study%refuse('axes')
         do i = 1, 2
            if (study%word('axes', i) /= 'y') cycle
            if (-low(i) > reach(study)) call study%refuse('low', &
               'y must be within half the clearance')
            if (high(i) > reach(study)) call study%refuse('high', &
               'y must be within half the clearance')
         end do
         call check_product(study, 'values', study%whole_numbers('values'), 'together at most '// &
            whole(most_numbers)//' states')
         do i = 1, 2
            call study%forbid(trim(study%word('axes', i)), ': it is an axis')
            call study%drop(trim(study%word('axes', i)))
         end do
         if (.not. study%has('y')) return
         if (abs(study%number('y')) > reach(study)) call study%refuse('y', &
            'y must be within half the clearance')
      end associate
   end subroutine check_basins

   !> How far the free mass may be from the middle.
   pure real(wp) function reach(study)
      !> The group.
      type(values_type), intent(in) :: study

      reach = half_gap(study%number('clearance'))
   end function reach

   !> The states: t, x, x', z, z' of each.
   pure function initial_states(case) result(states)
      !> The case, checked.
      type(case_type), intent(in) :: case
      real(wp), allocatable :: states(:, :)

      associate (s => case%study)
         if (s%has('states')) then
            states = random_states(case%osc%xi, case%r, s%number('load'), s%number('clearance'), &
               s%whole_number('states'), s%whole_number('seed'))
         else
            states = plane_states(s)
         end if
      end associate
   end function initial_states

   !> The states (5, n m) of the plane; the second axis varies first.
   pure function plane_states(study) result(states)
      !> The group.
      type(values_type), intent(in) :: study
      real(wp), allocatable :: states(:, :)
      real(wp) :: low(2), high(2)
      integer :: n(2), i, j, first, second

      n = study%whole_numbers('values')
      low = study%numbers('low')
      high = study%numbers('high')
      allocate (states(5, n(1)*n(2)))
      do i = 1, 5
         if (study%has(trim(axis_names(i)))) states(i, :) = study%number(trim(axis_names(i)))
      end do
      first = findloc(axis_names == study%word('axes', 1), .true., 1)
      second = findloc(axis_names == study%word('axes', 2), .true., 1)
      do j = 1, n(1)
         states(second, (j - 1)*n(2) + 1:j*n(2)) = even(low(2), high(2), n(2))
      end do
      do j = 1, n(2)
         states(first, j::n(2)) = even(low(1), high(1), n(1))
      end do
      states(4, :) = states(4, :) + states(2, :)
   end function plane_states

end module vi_basins_study
