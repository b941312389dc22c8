!> A tally of work, read from outside while the work goes on, and written there to stop it.
!!
!! Its three numbers are the work done, the work in sight, and whether to stop (not 0). Threads add
!! to it; what is computed does not depend on it, unless it is stopped.
module vi_tally
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: add_sight, add_work, is_stopped, tell_share

contains

   !> More work has come in sight.
   subroutine add_sight(work, tally)
      integer, intent(in) :: work
      integer, intent(inout), optional :: tally(3)

      if (present(tally)) call add(work, tally(2))
   end subroutine add_sight

   !> Some work is done.
   subroutine add_work(work, tally)
      integer, intent(in) :: work
      integer, intent(inout), optional :: tally(3)

      if (present(tally)) call add(work, tally(1))
   end subroutine add_work

   !> Brings what is told of one piece of work up to the share of it that is done.
   subroutine tell_share(share, work, told, tally)
      real(wp), intent(in) :: share
      !> What the whole piece counts, and what of it has been told so far.
      integer, intent(in) :: work
      integer, intent(inout) :: told
      integer, intent(inout), optional :: tally(3)
      integer :: more

      if (.not. present(tally)) return
      more = max(0, nint(work*min(1.0_wp, share)) - told)
      told = told + more
      call add(more, tally(1))
   end subroutine tell_share

   !> One of the sums becomes larger, whichever threads add to it.
   subroutine add(work, total)
      integer, intent(in) :: work
      integer, intent(inout) :: total

      !$omp atomic update
      total = total + work
   end subroutine add

   !> Whether the rest is no longer wanted.
   logical function is_stopped(tally)
      integer, intent(inout), optional :: tally(3)
      integer :: stop_now

      is_stopped = .false.
      if (.not. present(tally)) return
      !$omp atomic read
      stop_now = tally(3)
      is_stopped = stop_now /= 0
   end function is_stopped

end module vi_tally
