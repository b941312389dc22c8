!> The vibrating system: a primary mass on a spring and a dashpot, and a free mass between two
!! walls.
!!
!! Everything is dimensionless: time in 1/omega, length in F0/K (equations (3), (4) of Popplewell,
!! Bapat and McLachlan, J. Sound Vib. 87, 1983). Between impacts
!!
!!     x'' + 2 xi x' + x = sin(r t),    z'' = 0.
module vi_oscillator
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: at_resonance, eta, gain, lag

   !> Index of each wall in `restitution`.
   integer, parameter, public :: right = 1, left = 2

   !> The system without its load.
   type, public :: oscillator_type
      !> Damping ratio C/(2 sqrt(K M)), 0 <= xi < 1.
      real(wp) :: xi = 0
      !> Mass ratio m/M, mu >= 0. With mu = 0 the primary mass does not feel the impacts.
      real(wp) :: mu = 0
      !> Coefficients of restitution (R1 on the right wall, R2 on the left), 0 <= R <= 1.
      real(wp) :: restitution(2) = 1
   end type oscillator_type

contains

   !> Damped natural frequency over omega, equation (3).
   elemental real(wp) function eta(xi)
      !> Damping ratio, 0 <= xi < 1.
      real(wp), intent(in) :: xi

      eta = sqrt((1 - xi)*(1 + xi))
   end function eta

   !> Amplitude A of the motion without impacts for F0/K = 1, equation (4).
   elemental real(wp) function gain(xi, r)
      !> Damping ratio, and frequency ratio Omega/omega; infinite for xi = 0, r = 1.
      real(wp), intent(in) :: xi, r

      gain = 1/hypot((1 - r)*(1 + r), 2*xi*r)
   end function gain

   !> Whether the motion without impacts has so large an amplitude that the free and the forced
   !! vibration nearly cancel and keep no more than four digits: r near 1 with almost no damping.
   elemental logical function at_resonance(xi, r)
      !> Damping ratio, and frequency ratio Omega/omega.
      real(wp), intent(in) :: xi, r

      at_resonance = hypot((1 - r)*(1 + r), 2*xi*r) < 1.0e-12_wp
   end function at_resonance

   !> Phase by which the motion without impacts lags the load, in [0, pi], equation (4).
   elemental real(wp) function lag(xi, r)
      !> Damping ratio, and frequency ratio Omega/omega.
      real(wp), intent(in) :: xi, r

      lag = atan2(2*xi*r, (1 - r)*(1 + r))
   end function lag

end module vi_oscillator
