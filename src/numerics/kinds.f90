!> The one real kind that the core computes in.
module vi_kinds
   use, intrinsic :: iso_fortran_env, only: real64
   implicit none (type, external)
   private

   !> Double precision; the second build of the core has real32.
   integer, parameter, public :: wp = real64
   real(wp), parameter, public :: pi = acos(-1.0_wp), two_pi = 2*pi
end module vi_kinds
