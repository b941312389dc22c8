!> The studies: the only file that knows them all.
module vi_study_list
   use vi_atlas_study, only: declare_atlas
   use vi_basins_study, only: declare_basins
   use vi_bifurcation_study, only: declare_bifurcation
   use vi_branch_study, only: declare_branch
   use vi_case, only: case_type, echo
   use vi_chart_study, only: declare_chart
   use vi_decay_study, only: declare_decay
   use vi_find_study, only: declare_find
   use vi_lyapunov_study, only: declare_lyapunov
   use vi_motion_study, only: declare_motion
   use vi_response_study, only: declare_response
   use vi_result, only: column_type, result_type, start_result
   use vi_simulate_study, only: declare_simulate
   use vi_study, only: declare_type, study_type
   use vi_text, only: line_type
   use vi_zone_study, only: declare_zone
   implicit none (type, external)
   private

   public :: find_study, list_studies, run_study

contains

   !> All studies, in the order of messages and tables.
   subroutine list_studies(studies)
      !> Their declarations.
      type(study_type), allocatable, intent(out) :: studies(:)

      call collect([ &
         declare_type(declare_motion), &
         declare_type(declare_simulate), &
         declare_type(declare_find), &
         declare_type(declare_chart), &
         declare_type(declare_branch), &
         declare_type(declare_zone), &
         declare_type(declare_atlas), &
         declare_type(declare_lyapunov), &
         declare_type(declare_bifurcation), &
         declare_type(declare_response), &
         declare_type(declare_decay), &
         declare_type(declare_basins)], studies)
   end subroutine list_studies

   !> The declarations of some studies.
   subroutine collect(each, studies)
      !> What fills in each of them.
      type(declare_type), intent(in) :: each(:)
      !> The declarations.
      type(study_type), allocatable, intent(out) :: studies(:)
      integer :: i

      allocate (studies(size(each)))
      do i = 1, size(each)
         call each(i)%declare(studies(i))
      end do
   end subroutine collect

   !> The study of a name.
   subroutine find_study(name, study)
      !> The name of a study.
      character(*), intent(in) :: name
      !> Its declaration.
      type(study_type), intent(out) :: study
      type(study_type), allocatable :: studies(:)
      integer :: i

      call list_studies(studies)
      do i = 1, size(studies)
         if (studies(i)%name == name) study = studies(i)
      end do
   end subroutine find_study

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
      type(study_type) :: study
      type(column_type), allocatable :: columns(:)
      type(line_type), allocatable :: lines(:)

      call echo(case, lines)
      call find_study(case%study%name, study)
      call study%list(columns=columns)
      call start_result(lines, columns, study%row, result)
      call study%run(case, threads, result, progress)
   end subroutine run_study

end module vi_study_list
