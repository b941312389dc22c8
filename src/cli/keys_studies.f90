!> The keys of &chart, &branch, &zone and &atlas: what each takes.
module vi_keys_studies
   implicit none (type, external)
   private

   public :: list_study_keys, wanted_of_chart, wanted_of_study

contains

   !> What a key takes; empty if the group has no such key.
   pure subroutine wanted_of_study(group, key, text)
      character(*), intent(in) :: group, key
      character(:), allocatable, intent(out) :: text

      select case (group//' '//key)
      case default
         text = ''
      case ('branch parameter')
         text = '''r'', ''clearance'', ''xi'', ''mu'', ''R1'', ''R2'' or ''restitution'' (both &
            &walls)'
      case ('branch low')
         text = 'a number, at most the value that the motion has'
      case ('branch high')
         text = 'a number above low, at least the value that the motion has'
      case ('branch longest_step')
         text = 'a number with 1e-6 <= longest_step <= 1'
      case ('branch max_points')
         text = 'a whole number with 10 <= max_points <= 100000'
      case ('zone sides')
         text = 'letters R and L, one an impact, 2 to 24 of them, each wall at least once; a &
            &star after a letter for impacts that accumulate and end in rest'
      case ('zone cycles')
         text = 'a whole number with 1 <= cycles <= 10000'
      case ('zone symmetric')
         text = '''yes'' (only motions that are their own mirror image), ''no'' (only others) or &
            &''both'''
      case ('zone r_min', 'zone r_max', 'atlas r_min', 'atlas r_max')
         text = 'a number with 1e-6 <= '//key//' <= 1e6, and r_min below r_max'
      case ('zone clearance_min', 'zone clearance_max', 'atlas clearance_min', &
         'atlas clearance_max')
         text = 'a number with 1e-12 <= '//key//' <= 1e12, and clearance_min below clearance_max'
      case ('zone lines', 'atlas lines')
         text = 'a whole number with 5 <= lines <= 129'
      case ('zone guesses', 'atlas guesses')
         text = 'a whole number with 0 <= guesses <= 100000'
      case ('zone max_points', 'atlas max_points')
         text = 'a whole number with 100 <= max_points <= 200000'
      case ('atlas max_impacts')
         text = 'a whole number with 2 <= max_impacts <= 8'
      case ('atlas max_cycles')
         text = 'a whole number with 1 <= max_cycles <= 4'
      case ('atlas survey')
         text = 'a whole number with 0 <= survey <= 1000000'
      case ('atlas settling')
         text = 'a whole number with 1 <= settling <= 1000000'
      end select
   end subroutine wanted_of_study

   !> What a key of &chart takes; empty if there is no such key.
   pure subroutine wanted_of_chart(key, text)
      character(*), intent(in) :: key
      character(:), allocatable, intent(out) :: text

      select case (key)
      case default
         text = ''
      case ('sides')
         text = 'letters R and L, one an impact, 2 to 12 of them, each wall at least once'
      case ('cycles')
         text = 'a whole number with 1 <= cycles <= 10000'
      case ('r_min', 'r_max')
         text = 'a number with 1e-6 <= '//key//' <= 1e6, and r_min below r_max'
      case ('clearance_min', 'clearance_max')
         text = 'a number with 1e-12 <= '//key//' <= 1e12, and clearance_min below clearance_max'
      case ('r_points', 'clearance_points')
         text = 'a whole number of at least 2, with r_points x clearance_points <= 1000000'
      case ('spacing')
         text = '''linear'' or ''geometric'' (of the clearances)'
      case ('symmetric')
         text = '''yes'' (only motions that are their own mirror image), ''no'' (only others) or &
            &''both'''
      case ('room')
         text = 'a whole number with 1 <= room <= 32'
      case ('guesses', 'seeds')
         text = 'a whole number with 1 <= '//key//' <= 10000'
      end select
   end subroutine wanted_of_chart

   !> The keys of a group, for messages; empty for other groups.
   pure subroutine list_study_keys(group, text)
      character(*), intent(in) :: group
      character(:), allocatable, intent(out) :: text

      select case (group)
      case ('chart')
         text = 'sides, cycles, r_min, r_max, r_points, clearance_min, clearance_max, &
            &clearance_points, spacing, symmetric, room, guesses, seeds'
      case ('branch')
         text = 'parameter, low, high, longest_step, max_points'
      case ('zone')
         text = 'sides, cycles, symmetric, r_min, r_max, clearance_min, clearance_max, lines, &
            &guesses, max_points'
      case ('atlas')
         text = 'r_min, r_max, clearance_min, clearance_max, max_impacts, max_cycles, survey, &
            &settling, lines, guesses, max_points'
      case default
         text = ''
      end select
   end subroutine list_study_keys

end module vi_keys_studies
