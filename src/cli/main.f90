!> The stand-alone program: namelists in, tables out, no Python.
program vibroimpact_batch
   use vi_batch, only: failed, wrong
   use vi_command, only: run_command
   use vi_interrupt, only: catch_interrupts, progress
   implicit none (type, external)
   integer :: status

   call catch_interrupts()
   call run_command(progress, status)
   if (status == failed) stop 1, quiet=.true.
   if (status == wrong) stop 2, quiet=.true.
end program vibroimpact_batch
