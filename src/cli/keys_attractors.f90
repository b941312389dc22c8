!> The keys of &lyapunov, &bifurcation, &response and &basins: what each takes.
module vi_keys_attractors
   implicit none (type, external)
   private

   public :: list_attractor_keys, wanted_of_attractor

contains

   !> What one of the keys of a group takes.
   pure subroutine wanted_of_attractor(group, key, text)
      character(*), intent(in) :: group, key
      character(:), allocatable, intent(out) :: text

      select case (key)
      case ('parameter')
         text = '''r'', ''clearance'', ''xi'', ''mu'', ''R1'', ''R2'' or ''restitution'' (both &
            &walls)'
         if (group == 'lyapunov') text = '''r'' or ''clearance''; low, high and values go with it'
      case ('low', 'high')
         text = 'a number in the range of the parameter (1e-6 <= r <= 1e6, 1e-12 <= clearance <= &
            &1e12, 0 <= xi < 1, 0 <= mu <= 1e6, 0 <= R <= 1), low below high'
         if (group == 'basins') text = 'two finite numbers, one an axis, low below high'
      case ('values')
         text = 'a whole number with 2 <= values <= 1000000'
         if (group == 'basins') text = 'two whole numbers, one an axis, each with 2 <= values <= &
            &100000'
      case ('spacing')
         text = '''linear'' or ''geometric'' (of the values)'
         if (group == 'lyapunov') text = text//'; it goes with parameter'
      case ('axes')
         text = 'two of ''x'', ''x_dot'', ''y'' (z - x), ''z_dot'' and ''t'', or states = N &
            &instead of a plane'
      case ('sweep')
         text = '''up'', ''down'', ''both'' or ''states'''
      case ('clearance', 'inverse_clearance')
         text = 'a number with 1e-12 <= '//key//' <= 1e12'
      case ('load')
         text = 'a number with 0 <= load <= 1e12'
         if (group == 'response') text = 'a number with 0 < load <= 1e12'
      case ('r_min', 'r_max')
         text = 'a number with 1e-6 <= '//key//' <= 1e6, and r_min below r_max'
      case ('r_points')
         text = 'a whole number with 2 <= r_points <= 1000000'
      case ('t', 'x', 'x_dot', 'y', 'z', 'z_dot')
         text = 'a finite number'
      case ('cycles')
         text = 'a whole number with 1 <= cycles <= 10000000'
         if (group == 'lyapunov') text = 'a whole number, 2 batches <= cycles <= 1e9 (batches: 20)'
      case ('discard')
         text = 'a whole number with 0 <= discard <= 1000000000'
      case ('batches')
         text = 'a whole number with 2 <= batches <= 1000'
      case ('states', 'probes')
         text = 'a whole number with 1 <= '//key//' <= 1000000'
         if (group//key == 'basinsstates') text = 'a whole number with 1 <= states <= 12500000'
      case ('seed')
         text = 'a whole number with 0 <= seed <= 2147483647'
      case ('settling')
         text = 'a whole number with 0 <= settling <= 10000000'
      case ('keep')
         text = 'a whole number with 3 <= keep <= 10000'
      case ('points')
         text = 'a whole number with 1 <= points <= 4096'
      case default                                                            ! max_cycles
         text = 'a whole number with 1 <= max_cycles <= 100'
      end select
   end subroutine wanted_of_attractor

   !> The keys of a group, for messages; empty for other groups.
   pure subroutine list_attractor_keys(group, text)
      character(*), intent(in) :: group
      character(:), allocatable, intent(out) :: text

      select case (group)
      case ('lyapunov')
         text = 'clearance, parameter, low, high, values, spacing, cycles, discard, batches, load, &
            &t, x, x_dot, z, z_dot'
      case ('bifurcation')
         text = 'parameter, low, high, values, spacing, clearance, sweep, states, load, settling, &
            &keep, points, t, x, x_dot, z, z_dot'
      case ('basins')
         text = 'clearance, axes, low, high, values, t, x, x_dot, y, z_dot, states, seed, load, &
            &cycles, probes, max_cycles'
      case ('response')
         text = 'r_min, r_max, r_points, clearance, inverse_clearance, states, load, settling, keep'
      case default
         text = ''
      end select
   end subroutine list_attractor_keys

end module vi_keys_attractors
