!> What this processor can do.
module vi_processor
   use, intrinsic :: iso_c_binding, only: c_int
   implicit none (type, external)
   private

   public :: runs_wide

   interface
      !> Not 0 if this processor runs the vi_*_wide procedures.
      integer(c_int) function runs_wide() bind(c, name='vibroimpact_runs_wide')
         import :: c_int
         implicit none (type, external)
      end function runs_wide
   end interface

end module vi_processor
