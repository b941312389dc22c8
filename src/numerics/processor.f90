!> What the processor and the process allow: wide registers, threads, stack space, memory.
module vi_processor
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   !$ use omp_lib, only: omp_get_max_threads, omp_get_num_procs
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: available_threads, has_memory, runs_wide, stack_left, stack_needed, usable_threads

   !> Number of threads that a caller may always request, even if there are fewer processors.
   integer, parameter :: few = 8

   interface
      !> Not 0 if this processor runs the vi_*_wide procedures.
      pure integer(c_int) function runs_wide() bind(c, name='vibroimpact_runs_wide')
         import :: c_int
         implicit none (type, external)
      end function runs_wide

      !> Largest number of threads of a computation: 1 in a child of fork, and where their stacks
      !! would be too small.
      integer(c_int) function thread_limit() bind(c, name='vibroimpact_thread_limit')
         import :: c_int
         implicit none (type, external)
      end function thread_limit

      !> Bytes left on the stack of this thread; a large number if that is not known.
      real(c_double) function stack_left() bind(c, name='vibroimpact_stack_size')
         import :: c_double
         implicit none (type, external)
      end function stack_left

      !> Bytes of stack that a computation needs.
      real(c_double) function stack_needed() bind(c, name='vibroimpact_stack_needed')
         import :: c_double
         implicit none (type, external)
      end function stack_needed

      !> Whether memory can be allocated: 1 or 0.
      integer(c_int) function c_has_memory(bytes) bind(c, name='vibroimpact_has_memory')
         import :: c_double, c_int
         implicit none (type, external)
         !> How many bytes.
         real(c_double), value, intent(in) :: bytes
      end function c_has_memory
   end interface

contains

   !> Number of OpenMP threads, at most one for each processor; results do not depend on it.
   integer function available_threads() result(threads)
      threads = 1
      !$ threads = min(omp_get_max_threads(), omp_get_num_procs())
      threads = usable_threads(threads)
   end function available_threads

   !> Number of OpenMP threads that a computation uses.
   integer function usable_threads(wanted) result(threads)
      !> Number that the caller requests.
      integer, intent(in) :: wanted

      threads = few
      !$ threads = max(few, omp_get_num_procs())
      threads = max(1, min(wanted, threads, thread_limit()))
   end function usable_threads

   !> Whether memory can be allocated.
   logical function has_memory(bytes)
      !> How many bytes.
      real(wp), intent(in) :: bytes

      has_memory = c_has_memory(real(bytes, c_double)) /= 0
   end function has_memory

end module vi_processor
