!> Signals in the stand-alone program: after Ctrl-C the running study stops, and what is finished is
!! written; a file that becomes too large is an error.
module vi_interrupt
   use, intrinsic :: iso_c_binding, only: c_funloc, c_funptr, c_int, c_intptr_t, c_null_funptr
   use vi_batch, only: give_up_file, writing
   implicit none (type, external)
   private

   public :: catch_signals

   !> Progress counters of the running study, see vi_progress.
   integer, public, target :: progress(3) = 0

   !> SIGINT and SIGTERM, the same numbers on Linux, macOS and Windows.
   integer(c_int), parameter :: signals(2) = [2_c_int, 15_c_int]
   !> SIG_IGN.
   integer(c_intptr_t), parameter :: ignored = 1

   interface
      !> The C library's signal().
      type(c_funptr) function c_signal(number, handler) bind(c, name='signal')
         import :: c_funptr, c_int
         implicit none (type, external)
         !> Number of the signal.
         integer(c_int), value, intent(in) :: number
         !> The function to call, or null for the default action.
         type(c_funptr), value, intent(in) :: handler
      end function c_signal
      !> The C library's raise().
      integer(c_int) function c_raise(number) bind(c, name='raise')
         import :: c_int
         implicit none (type, external)
         !> Number of the signal.
         integer(c_int), value, intent(in) :: number
      end function c_raise
      subroutine ignore_size_signal() bind(c, name='vibroimpact_ignore_size_signal')
         implicit none (type, external)
      end subroutine ignore_size_signal
   end interface

contains

   !> From now on the first Ctrl-C (or SIGTERM) stops the study, and the second ends the program.
   !! While a file is written, each of them makes the program give up and remove that file. While
   !! cases are read, the first one ends it. A write beyond the file size limit is an error.
   subroutine catch_signals()
      type(c_funptr) :: before
      integer :: i

      call ignore_size_signal()
      do i = 1, size(signals)
         before = c_signal(signals(i), c_funloc(stop_study))
         ! a signal that the caller has set to be ignored, as nohup does, stays ignored
         if (transfer(before, ignored) == ignored) before = c_signal(signals(i), before)
      end do
   end subroutine catch_signals

   !> The signal handler. The flag that stops the study also shows what the program is doing, see
   !! vi_batch.
   subroutine stop_study(number) bind(c)
      !> Number of the signal.
      integer(c_int), value, intent(in) :: number
      type(c_funptr) :: before
      integer(c_int) :: ended
      integer :: flag

      !$omp atomic read
      flag = progress(3)
      if (flag == 0 .or. flag >= writing) then
         before = c_signal(number, c_funloc(stop_study))    ! some systems set the default action
         !$omp atomic write
         progress(3) = merge(1, give_up_file, flag == 0)
      else
         before = c_signal(number, c_null_funptr)
         ended = c_raise(number)
      end if
   end subroutine stop_study

end module vi_interrupt
