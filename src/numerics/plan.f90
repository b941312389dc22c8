!> The data that all points of a batch have in common, for the procedures that compute them in
!! lanes.
module vi_plan
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   !> Number of points that are computed together, one per lane.
   integer, parameter, public :: lanes = 32
   !> Most impacts of a motion that is computed in lanes.
   integer, parameter, public :: most_impacts = 16
   !> A verdict that is left to the reference chain.
   integer, parameter, public :: unsure = -2

   !> Columns correspond to impacts.
   type, public :: plan_type
      integer :: n = 0
      !> Damping ratio, eta of (3), and 2 pi k.
      real(wp) :: xi = 0, frequency = 1, period = 0
      !> Largest residual that counts as consistent.
      real(wp) :: acceptance = 0
      !> Product of all R_i^2.
      real(wp) :: squares = 0
      !> A solution whose condition exceeds this may be refused.
      real(wp) :: accepted = 0
      !> y_i for d = 1.
      real(wp), dimension(most_impacts) :: y = 0
      !> Weights of the velocities z' before and after an impact in x' after and before it: (28).
      real(wp), dimension(2, most_impacts) :: x_dot_after = 0, x_dot_before = 0
      !> Weights of x' and z' before an impact in x' and z' after it: k_1, k_2 and k_3, k_4 of (A5).
      real(wp), dimension(2, most_impacts) :: x_row = 0, z_row = 0
   end type plan_type

end module vi_plan
