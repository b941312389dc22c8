!> Progress counters of a computation. The caller reads them during it, and sets one to stop it.
!!
!! The three numbers are the work done, the work known so far, and a flag to stop (not 0). Threads
!! add to the first two. Results do not depend on them, unless the computation is stopped.
module vi_progress
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: add_expected_work, add_done_work, is_stopped, report_share

contains

   !> Adds to the work known so far.
   subroutine add_expected_work(work, progress)
      !> Units of work to add.
      integer, intent(in) :: work
      !> Progress counters; nothing is done without them.
      integer, intent(inout), optional :: progress(3)

      if (present(progress)) call add(work, progress(2))
   end subroutine add_expected_work

   !> Adds to the work done.
   subroutine add_done_work(work, progress)
      !> Units of work to add.
      integer, intent(in) :: work
      !> Progress counters; nothing is done without them.
      integer, intent(inout), optional :: progress(3)

      if (present(progress)) call add(work, progress(1))
   end subroutine add_done_work

   !> Reports progress within one task: adds the work that is done but not yet reported.
   subroutine report_share(share, work, reported, progress)
      !> Share of the task that is done, from 0; more than 1 counts as 1.
      real(wp), intent(in) :: share
      !> Units of work of the whole task.
      integer, intent(in) :: work
      !> In: units reported so far. Out: with those of this call.
      integer, intent(inout) :: reported
      !> Progress counters; nothing is done without them.
      integer, intent(inout), optional :: progress(3)
      integer :: more

      if (.not. present(progress)) return
      more = max(0, nint(work*min(1.0_wp, share)) - reported)
      reported = reported + more
      call add(more, progress(1))
   end subroutine report_share

   !> Adds to one of the sums; several threads may do so at once.
   subroutine add(work, total)
      !> Units of work to add.
      integer, intent(in) :: work
      !> In and out: the sum.
      integer, intent(inout) :: total

      !$omp atomic update
      total = total + work
   end subroutine add

   !> Whether the caller has asked the computation to stop.
   logical function is_stopped(progress, flag)
      !> Progress counters; only read here.
      integer, intent(inout), optional :: progress(3)
      !> Value of the flag from which the computation stops; if absent, any but 0.
      integer, intent(in), optional :: flag
      integer :: stop_now

      is_stopped = .false.
      if (.not. present(progress)) return
      !$omp atomic read
      stop_now = progress(3)
      is_stopped = stop_now /= 0
      if (present(flag)) is_stopped = stop_now >= flag
   end function is_stopped

end module vi_progress
