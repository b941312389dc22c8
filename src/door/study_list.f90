!> The studies: the only file that lists all of them.
module vi_study_list
   use vi_atlas_study, only: declare_atlas
   use vi_basins_study, only: declare_basins
   use vi_bifurcation_study, only: declare_bifurcation
   use vi_branch_study, only: declare_branch
   use vi_case, only: case_type, echo, outputs_of, shown_of
   use vi_chart_study, only: declare_chart
   use vi_decay_study, only: declare_decay
   use vi_design_study, only: declare_design
   use vi_find_study, only: declare_find
   use vi_identify_study, only: declare_identify
   use vi_kinds, only: wp
   use vi_lyapunov_study, only: declare_lyapunov
   use vi_motion_study, only: declare_motion
   use vi_processor, only: has_memory, stack_left, stack_needed, usable_threads
   use vi_response_study, only: declare_response
   use vi_result, only: column_type, result_type, start_result
   use vi_simulate_study, only: declare_simulate
   use vi_status, only: stat, status_text
   use vi_study, only: declare_type, study_type
   use vi_text, only: line_type, whole
   use vi_zone_study, only: declare_zone
   implicit none (type, external)
   private

   public :: find_study, list_studies, run_study

   !> Bytes that are available wherever the program runs; a case that needs less is not checked.
   real(wp), parameter :: little = 2.0e6_wp
   !> Bytes for a number of a case: its digits in the echo, in the result, in the header of the CSV,
   !! and in the lines from which these are put together.
   real(wp), parameter :: echo_bytes = 320

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
         declare_type(declare_design), &
         declare_type(declare_basins), &
         declare_type(declare_identify)], studies)
   end subroutine list_studies

   !> The declarations of some studies.
   subroutine collect(each, studies)
      !> The procedures that fill them in.
      type(declare_type), intent(in) :: each(:)
      !> The declarations.
      type(study_type), allocatable, intent(out) :: studies(:)
      integer :: i

      allocate (studies(size(each)))
      do i = 1, size(each)
         call each(i)%declare(studies(i))
         studies(i)%list => each(i)%declare
      end do
   end subroutine collect

   !> The study with a given name.
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
      !> The case, checked.
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

      call find_study(case%study_name, study)
      call study%columns_of(case%model, columns)
      allocate (lines(0))
      if (has_room(echo_bytes*case%study%count_numbers())) call echo(case, lines)
      call start_result(lines, columns, study%row(case%model), result, outputs_of(case), &
         shown_of(case))
      if (allocated(case%sweep%name)) then
         result%empty = .true.
         call result%fail('a case with &sweep is a campaign, which the Python package runs: &
            &vibroimpact campaign FILE.nml --store FOLDER')
         return
      end if
      if (study%in_python) then
         result%empty = .true.
         call result%fail('&'//trim(study%name)//' is computed by the Python package: &
            &vibroimpact run FILE.nml')
         return
      end if
      call check_room(study, case, result)
      if (result%empty) return
      call study%run(case, usable_threads(threads), result, progress)
   end subroutine run_study

   !> Checks that memory and stack are sufficient for a case.
   subroutine check_room(study, case, result)
      !> The study.
      type(study_type), intent(in) :: study
      !> Its case.
      type(case_type), intent(in) :: case
      !> The result; empty, with a fault, if they are not.
      type(result_type), intent(inout) :: result
      real(wp) :: bytes

      if (stack_left() < stack_needed()) then
         result%empty = .true.
         result%no_memory = .true.
         call result%fail('the stack of this thread is too small: '// &
            whole(int(stack_left()/1024))//' kB are left; must be at least '// &
            whole(int(stack_needed()/1024))//' kB (ulimit -s, threading.stack_size)')
         return
      end if
      bytes = echo_bytes*case%study%count_numbers()
      if (associated(study%memory)) bytes = bytes + study%memory(case)
      if (has_room(bytes)) return
      result%empty = .true.
      result%no_memory = .true.
      call result%fail(status_text(stat%no_memory)//': the case needs up to '// &
         whole(int(bytes/1.0e6_wp))//' MB, which cannot be allocated; divide it into smaller cases')
   end subroutine check_room

   !> Whether there is memory for a case.
   logical function has_room(bytes)
      !> Bytes that it takes.
      real(wp), intent(in) :: bytes

      has_room = bytes < little
      if (.not. has_room) has_room = has_memory(bytes)
   end function has_room

end module vi_study_list
