!> The studies by name: the only file that knows them all.
module vi_study_list
   use vi_atlas_study, only: atlas_keys, check_atlas
   use vi_basins_study, only: basins_keys, check_basins
   use vi_bifurcation_study, only: bifurcation_keys, check_bifurcation
   use vi_branch_study, only: branch_keys, check_branch
   use vi_case, only: case_type
   use vi_chart_study, only: chart_keys, check_chart
   use vi_key, only: key_type
   use vi_lyapunov_study, only: check_lyapunov, lyapunov_keys
   use vi_motion_study, only: check_motion, motion_keys
   use vi_response_study, only: check_response, response_keys
   use vi_simulate_study, only: check_simulate, simulate_keys
   use vi_zone_study, only: check_zone, zone_keys
   implicit none (type, external)
   private

   public :: check_study, list_keys_of

   !> The groups that ask for a result.
   character(11), parameter, public :: study_names(10) = [character(11) :: 'motion', 'simulate', &
      'chart', 'branch', 'zone', 'atlas', 'lyapunov', 'bifurcation', 'response', 'basins']

contains

   !> The keys of a study.
   pure subroutine list_keys_of(name, keys)
      !> One of `study_names`.
      character(*), intent(in) :: name
      !> Its table.
      type(key_type), allocatable, intent(out) :: keys(:)

      select case (name)
      case ('motion')
         keys = motion_keys
      case ('simulate')
         keys = simulate_keys
      case ('chart')
         keys = chart_keys
      case ('branch')
         keys = branch_keys
      case ('zone')
         keys = zone_keys
      case ('atlas')
         keys = atlas_keys
      case ('lyapunov')
         keys = lyapunov_keys
      case ('bifurcation')
         keys = bifurcation_keys
      case ('response')
         keys = response_keys
      case default
         keys = basins_keys
      end select
   end subroutine list_keys_of

   !> Checks what depends on several keys.
   subroutine check_study(case)
      !> With its groups read; complete on return, or with a fault in one of them.
      type(case_type), intent(inout) :: case

      select case (case%study%name)
      case ('motion')
         call check_motion(case%osc, case%study)
      case ('simulate')
         call check_simulate(case)
      case ('chart')
         call check_chart(case)
      case ('branch')
         call check_branch(case)
      case ('zone')
         call check_zone(case)
      case ('atlas')
         call check_atlas(case)
      case ('lyapunov')
         call check_lyapunov(case)
      case ('bifurcation')
         call check_bifurcation(case)
      case ('response')
         call check_response(case)
      case default
         call check_basins(case)
      end select
   end subroutine check_study

end module vi_study_list
