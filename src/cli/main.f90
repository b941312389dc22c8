!> The stand-alone program: namelists in, tables out, no Python.
program vibroimpact_batch
   use, intrinsic :: iso_fortran_env, only: error_unit
   use vi_batch, only: failed, wrong
   use vi_command, only: run_command
   use vi_interrupt, only: catch_signals, progress
   use vi_processor, only: stack_left, stack_needed
   implicit none (type, external)
   integer :: status

   ! before anything is read: the reader needs stack space too
   if (stack_left() < stack_needed()) then
      write (error_unit, '(a, i0, a)') 'the stack is too small: must be at least ', &
         int(stack_needed()/1024), ' kB (ulimit -s)'
      stop 2, quiet=.true.
   end if
   call catch_signals()
   call run_command(progress, status)
   if (status == failed) stop 1, quiet=.true.
   if (status == wrong) stop 2, quiet=.true.
end program vibroimpact_batch
