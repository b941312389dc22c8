!> Runs a case with a branch.
module vi_run_branch
   use vi_branch, only: end_full, end_stuck
   use vi_branch_of, only: branch_of, points_type
   use vi_branch_table, only: branch_work
   use vi_common_keys, only: parameter_of, parameter_place
   use vi_case, only: case_type
   use vi_chain, only: refine
   use vi_log, only: done, failed, log_type, say, write_table
   use vi_motion, only: motion_type
   use vi_report_branch, only: branch_lines, end_text, special_name
   use vi_status, only: stat, status_text
   use vi_tally, only: add_sight, add_work
   use vi_text, only: line_type, whole
   implicit none (type, external)
   private

   public :: run_branch

contains

   !> Follows the branches of the motions of a case and writes their points.
   subroutine run_branch(case, motions, folder, log, written, tally)
      type(case_type), intent(in) :: case
      !> The motions of its &motion.
      type(motion_type), intent(in) :: motions(:)
      character(*), intent(in) :: folder
      type(log_type), intent(inout) :: log
      !> False if the result could not be written.
      logical, intent(out) :: written
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      type(points_type), allocatable :: branches(:)
      type(line_type), allocatable :: lines(:)
      type(motion_type) :: start
      character(:), allocatable :: text
      integer :: i, n, place
      logical :: tied

      written = .true.
      call parameter_place(trim(parameter_of(case)), place, tied)
      allocate (branches(size(motions)))
      n = 0
      call add_sight(branch_work*size(motions), tally)
      do i = 1, size(motions)
         start = motions(i)
         if (start%status == stat%ok .and. .not. case%start%is('kind', 'exact')) then
            call refine(start%clearance, start)
         end if
         if (start%status /= stat%ok) then
            ! that there is neither of a pair is said once
            if (i == 1 .or. any(motions%status == stat%ok)) then
               call say(log, failed, case%name//': '//status_text(start%status))
            end if
            call add_work(branch_work, tally)
            cycle
         end if
         n = n + 1
         call branch_of(start, place, tied, [case%study%number('low'), case%study%number('high')], &
            case%study%number('longest_step'), case%study%whole_number('max_points'), &
            branches(n), tally)
         if (branches(n)%n > 0) cycle
         call say(log, failed, case%name// &
            ': the branch cannot be followed from this motion: it is at a singular point')
         n = n - 1
      end do
      if (n == 0) return
      call branch_lines(case, branches(:n), lines)
      call write_table(folder//'/'//case%name//'.csv', lines, log, written)
      if (.not. written) return
      do i = 1, n
         call summarize(branches(i), text)
         call say(log, done, case%name//': '//text)
         if (any(branches(i)%reasons == end_full)) then
            call say(log, failed, case%name//': cut short, max_points was reached')
         else if (any(branches(i)%reasons == end_stuck)) then
            call say(log, failed, case%name//': cut short, the branch cannot be followed further')
         end if
      end do
   end subroutine run_branch

   !> Points, special points and ends in words.
   pure subroutine summarize(branch, text)
      type(points_type), intent(in) :: branch
      character(:), allocatable, intent(out) :: text
      character(14), parameter :: names(6) = [character(14) :: 'fold', 'pitchfork', 'flip', &
         'neimark_sacker', 'grazing', 'zero_approach']
      integer :: i, k, count

      text = whole(branch%n)//' points'
      do i = 1, size(names)
         count = 0
         do k = 1, branch%n
            if (special_name(branch, k) == names(i)) count = count + 1
         end do
         if (count > 0) text = text//', '//whole(count)//' '//trim(names(i))
      end do
      text = text//'; ends: '//end_text(branch%reasons(1))//', '//end_text(branch%reasons(2))
   end subroutine summarize

end module vi_run_branch
