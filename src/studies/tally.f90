!> Progress counters of a computation. The caller reads them while it runs, and sets one to stop it.
!!
!! The three numbers are the work done, the work known so far, and a flag to stop (not 0). Threads
!! add to the first two. Results do not depend on them, unless the computation is stopped.
module vi_tally
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: add_sight, add_work, is_stopped, tell_share

contains

   !> Adds to the work known so far.
   subroutine add_sight(work, tally)
      !> Units of work to add.
      integer, intent(in) :: work
      !> Progress counters; nothing is done without them.
      integer, intent(inout), optional :: tally(3)

      if (present(tally)) call add(work, tally(2))
   end subroutine add_sight

   !> Adds to the work done.
   subroutine add_work(work, tally)
      !> Units of work to add.
      integer, intent(in) :: work
      !> Progress counters; nothing is done without them.
      integer, intent(inout), optional :: tally(3)

      if (present(tally)) call add(work, tally(1))
   end subroutine add_work

   !> Reports progress within one task: adds the work that is done but not yet reported.
   subroutine tell_share(share, work, told, tally)
      !> Share of the task that is done, from 0; more than 1 counts as 1.
      real(wp), intent(in) :: share
      !> Units of work of the whole task.
      integer, intent(in) :: work
      !> In: units reported so far. Out: with those of this call.
      integer, intent(inout) :: told
      !> Progress counters; nothing is done without them.
      integer, intent(inout), optional :: tally(3)
      integer :: more

      if (.not. present(tally)) return
      more = max(0, nint(work*min(1.0_wp, share)) - told)
      told = told + more
      call add(more, tally(1))
   end subroutine tell_share

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
   logical function is_stopped(tally)
      !> Progress counters; only read here.
      integer, intent(inout), optional :: tally(3)
      integer :: stop_now

      is_stopped = .false.
      if (.not. present(tally)) return
      !$omp atomic read
      stop_now = tally(3)
      is_stopped = stop_now /= 0
   end function is_stopped

end module vi_tally
