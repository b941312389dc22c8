!> Capabilities of this processor.
module vi_processor
   use, intrinsic :: iso_c_binding, only: c_int
   !$ use omp_lib, only: omp_get_max_threads
   implicit none (type, external)
   private

   public :: available_threads, runs_wide

   interface
      !> Not 0 if this processor runs the vi_*_wide procedures.
      integer(c_int) function runs_wide() bind(c, name='vibroimpact_runs_wide')
         import :: c_int
         implicit none (type, external)
      end function runs_wide
   end interface

contains

   !> Number of OpenMP threads; results do not depend on it.
   integer function available_threads() result(threads)
      threads = 1
      !$ threads = omp_get_max_threads()
   end function available_threads

end module vi_processor
