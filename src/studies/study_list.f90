!> The studies by name: the only file that knows them all.
module vi_study_list
   use vi_atlas_study, only: atlas_columns, atlas_keys, check_atlas, run_atlas
   use vi_basins_study, only: basins_columns, basins_keys, check_basins, run_basins
   use vi_bifurcation_study, only: bifurcation_columns, bifurcation_keys, check_bifurcation, &
      run_bifurcation
   use vi_branch_study, only: branch_columns, branch_keys, check_branch, run_branch
   use vi_case, only: case_type, echo
   use vi_chart_study, only: chart_columns, chart_keys, check_chart, run_chart
   use vi_decay_study, only: check_decay, decay_columns, decay_keys, run_decay
   use vi_find_study, only: find_columns, find_keys, run_find
   use vi_key, only: key_type
   use vi_lyapunov_study, only: check_lyapunov, lyapunov_columns, lyapunov_keys, run_lyapunov
   use vi_motion_study, only: check_motion, motion_columns, motion_keys, run_motion
   use vi_response_study, only: check_response, response_columns, response_keys, run_response
   use vi_result, only: column_type, result_type, start_result
   use vi_simulate_study, only: check_simulate, run_simulate, simulate_columns, simulate_keys
   use vi_text, only: line_type
   use vi_zone_study, only: check_zone, run_zone, zone_columns, zone_keys
   implicit none (type, external)
   private

   public :: check_study, list_columns_of, list_keys_of, run_study

   !> The groups that ask for a result.
   character(11), parameter, public :: study_names(12) = [character(11) :: 'motion', 'simulate', &
      'find', 'chart', 'branch', 'zone', 'atlas', 'lyapunov', 'bifurcation', 'response', 'decay', &
      'basins']
   !> Those without a load, which have no frequency ratio.
   character(11), parameter, public :: without_load(1) = [character(11) :: 'decay']

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
      case ('find')
         keys = find_keys
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
      case ('decay')
         keys = decay_keys
      case default
         keys = basins_keys
      end select
   end subroutine list_keys_of

   !> Checks what depends on several keys.
   subroutine check_study(case)
      !> In: with its groups read. Out: complete, or with a fault in one of them.
      type(case_type), intent(inout) :: case

      select case (case%study%name)
      case ('motion')
         call check_motion(case%osc, case%study)
      case ('simulate')
         call check_simulate(case)
      case ('find')
         continue
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
      case ('decay')
         call check_decay(case)
      case default
         call check_basins(case)
      end select
   end subroutine check_study

   !> The columns of the result of a study.
   pure subroutine list_columns_of(name, columns, row)
      !> One of `study_names`.
      character(*), intent(in) :: name
      !> The columns as the study declares them.
      type(column_type), allocatable, intent(out) :: columns(:)
      !> The table whose rows are those of the CSV.
      character(16), intent(out) :: row

      select case (name)
      case ('motion')
         columns = motion_columns
         row = 'impacts'
      case ('simulate')
         columns = simulate_columns
         row = 'events'
      case ('find')
         columns = find_columns
         row = 'impacts'
      case ('chart')
         columns = chart_columns
         row = 'motions'
      case ('branch')
         columns = branch_columns
         row = 'points'
      case ('zone')
         columns = zone_columns
         row = 'vertices'
      case ('atlas')
         columns = atlas_columns
         row = 'vertices'
      case ('lyapunov')
         columns = lyapunov_columns
         row = 'points'
      case ('bifurcation')
         columns = bifurcation_columns
         row = 'impacts'
      case ('response')
         columns = response_columns
         row = 'points'
      case ('decay')
         columns = decay_columns
         row = 'peaks'
      case default
         columns = basins_columns
         row = 'states'
      end select
   end subroutine list_columns_of

   !> Runs a case.
   subroutine run_study(case, threads, result, progress)
      !> Checked.
      type(case_type), intent(in) :: case
      !> Number of OpenMP threads; the result does not depend on it.
      integer, intent(in) :: threads
      !> The result, with notes on what failed.
      type(result_type), intent(out) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(column_type), allocatable :: columns(:)
      type(line_type), allocatable :: lines(:)
      character(16) :: row

      call echo(case, lines)
      call list_columns_of(case%study%name, columns, row)
      call start_result(lines, columns, row, result)
      select case (case%study%name)
      case ('motion')
         call run_motion(case, result)
      case ('simulate')
         call run_simulate(case, result, progress)
      case ('find')
         call run_find(case, threads, result, progress)
      case ('chart')
         call run_chart(case, result, progress)
      case ('branch')
         call run_branch(case, result, progress)
      case ('zone')
         call run_zone(case, result, progress)
      case ('atlas')
         call run_atlas(case, threads, result, progress)
      case ('lyapunov')
         call run_lyapunov(case, threads, result, progress)
      case ('bifurcation')
         call run_bifurcation(case, threads, result, progress)
      case ('response')
         call run_response(case, threads, result, progress)
      case ('decay')
         call run_decay(case, threads, result, progress)
      case default
         call run_basins(case, threads, result, progress)
      end select
   end subroutine run_study

end module vi_study_list
