!> The impact law: momentum is conserved, the relative velocity is reversed and multiplied by R.
module vi_impact
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: impact, primary_velocities

contains

   !> Velocities just after an impact from those just before it, by equations (11), (12).
   elemental subroutine impact(mu, restitution, x_dot_before, z_dot_before, x_dot_after, &
      z_dot_after)
      !> Mass ratio m/M, coefficient of restitution of the wall, velocities of the primary and the
      !! free mass just before the impact (omega F0/K).
      real(wp), intent(in) :: mu, restitution, x_dot_before, z_dot_before
      !> Velocities of the primary and the free mass just after it.
      real(wp), intent(out) :: x_dot_after, z_dot_after

      x_dot_after = ((1 - mu*restitution)*x_dot_before + mu*(1 + restitution)*z_dot_before)/(1 + mu)
      z_dot_after = ((1 + restitution)*x_dot_before + (mu - restitution)*z_dot_before)/(1 + mu)
   end subroutine impact

   !> Velocities of the primary mass around an impact from those of the free mass: (13), (28).
   elemental subroutine primary_velocities(mu, restitution, z_dot_before, z_dot_after, &
         x_dot_before, x_dot_after)
      !> Mass ratio m/M, coefficient of restitution of the wall, velocities of the free mass just
      !! before and after the impact (omega F0/K).
      real(wp), intent(in) :: mu, restitution, z_dot_before, z_dot_after
      !> Velocities of the primary mass just before and after it.
      real(wp), intent(out) :: x_dot_before, x_dot_after

      x_dot_after = ((1 + mu)*restitution*z_dot_before + (1 - mu*restitution)*z_dot_after) &
         /(1 + restitution)
      x_dot_before = ((restitution - mu)*z_dot_before + (1 + mu)*z_dot_after)/(1 + restitution)
   end subroutine primary_velocities

end module vi_impact
