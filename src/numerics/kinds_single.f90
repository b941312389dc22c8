!> The one real kind of the second build of the core, which repeats single-precision runs.
!!
!! `single_source.py` renames the modules of every other core file to `vi_*_single`; this file is
!! the only one that exists twice.
module vi_kinds_single
   use, intrinsic :: iso_fortran_env, only: real32
   implicit none (type, external)
   private

   integer, parameter, public :: wp = real32
   real(wp), parameter, public :: pi = acos(-1.0_wp), two_pi = 2*pi
end module vi_kinds_single
