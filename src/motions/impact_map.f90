!> The derivative of the map from one impact to the next, [P_i] of (A5)-(A7).
!!
!! The state is (x, x', z', alpha) just after an impact, alpha being the load phase of the impact.
!! Three terms of the printed formulas are corrected here (see the comments); with them [P_i] is the
!! exact derivative, also for unequal restitution.
module vi_impact_map
   use vi_kinds, only: wp
   use vi_motion, only: motion_type
   use vi_oscillator, only: eta
   implicit none (type, external)
   private

   public :: forced_part, impact_map, impact_map_of, impact_maps

contains

   !> All [P_i], i = 1..N, of a motion.
   pure subroutine impact_maps(motion, p, regular)
      !> A motion with its positions, velocities, A and tau.
      type(motion_type), intent(in) :: motion
      !> (4, 4, N)
      real(wp), intent(out) :: p(:, :, :)
      !> False if an impact has no approach speed: there the map has no derivative.
      logical, intent(out) :: regular
      logical :: good
      integer :: i

      regular = .true.
      do i = 1, size(motion%phases)
         call impact_map_of(motion, i, forced_part(motion), p(:, :, i), good)
         regular = regular .and. good
      end do
   end subroutine impact_maps

   !> A cos(tau) and A sin(tau).
   pure function forced_part(motion) result(forced)
      !> A motion; A and tau are read.
      type(motion_type), intent(in) :: motion
      real(wp) :: forced(2)

      forced = motion%amplitude*[cos(motion%tau), sin(motion%tau)]
   end function forced_part

   !> [P_i] of a motion.
   pure subroutine impact_map_of(motion, i, forced, p, regular)
      !> A motion with its positions, velocities, A and tau.
      type(motion_type), intent(in) :: motion
      !> Number of the impact that begins the flight.
      integer, intent(in) :: i
      !> A cos(tau), A sin(tau), as `forced_part` gives them.
      real(wp), intent(in) :: forced(2)
      !> [P_i]; rows and columns (x, x', z', alpha); 0 where `regular` is false.
      real(wp), intent(out) :: p(4, 4)
      !> False if impact i+1 has no approach speed: there the map has no derivative.
      logical, intent(out) :: regular
      real(wp) :: sine(2), cosine(2)
      integer :: next

      next = modulo(i, size(motion%phases)) + 1
      sine = motion%sine([i, next])*forced(1) + motion%cosine([i, next])*forced(2)
      cosine = motion%cosine([i, next])*forced(1) - motion%sine([i, next])*forced(2)
      call impact_map(motion%osc%xi, motion%osc%mu, motion%r, motion%restitution(next), &
         motion%length(i), motion%c1(i), motion%c2(i), sine, cosine, motion%x(i), &
         motion%x_dot_after(i), motion%z_dot_after(i), p, regular)
   end subroutine impact_map_of

   !> [P_i] of one flight from (A5)-(A7), omega = 1, Omega = r.
   pure subroutine impact_map(xi, mu, r, restitution, length, c1, c2, sine, cosine, x, x_dot, &
      z_dot, p, regular)
      !> Damping ratio, mass ratio, frequency ratio; `restitution` is R_(i+1), `length` is
      !! alpha_(i+1) - alpha_i (rad); C_1i, C_2i of (9), (10).
      real(wp), intent(in) :: xi, mu, r, restitution, length, c1, c2
      !> A sin and A cos of alpha + tau at impacts i and i+1.
      real(wp), intent(in) :: sine(2), cosine(2)
      !> State just after impact i: position of the primary mass (F0/K), velocities of both (omega
      !! F0/K).
      real(wp), intent(in) :: x, x_dot, z_dot
      !> [P_i]; rows and columns (x, x', z', alpha); 0 where `regular` is false.
      real(wp), intent(out) :: p(4, 4)
      !> False if impact i+1 has no approach speed: there the map has no derivative.
      logical, intent(out) :: regular
      real(wp) :: h, b, c3, c4, k1, k2, k3, k4
      real(wp) :: s1, s2, s3, s4, s5, s6, s7, s8, s9, s10, s11, s12, s13, s14, free_dot

      h = eta(xi)
      b = x - sine(1)                                                                     ! (6)
      c3 = h*c2 - xi*c1                                                                   ! (A4)
      c4 = -(h*c1 + xi*c2)
      k1 = (1 - mu*restitution)/(1 + mu)                                                  ! (A5)
      k2 = mu*(1 + restitution)/(1 + mu)
      k3 = (1 + restitution)/(1 + mu)
      k4 = (mu - restitution)/(1 + mu)
      free_dot = x_dot - r*cosine(1)
      s1 = (xi*c1 + h*c2)/h                                                               ! (A6)
      s2 = c1/h
      s3 = -c1/h
      s4 = c3/h
      s6 = (b*s3 + free_dot*c3/h)/r
      s5 = z_dot/r - cosine(2) - s6                    ! corrected: z' in place of the printed x'
      regular = abs(s5) > 8*epsilon(1.0_wp)*(abs(z_dot)/r + abs(cosine(2)) + abs(s6))
      if (.not. regular) then
         p = 0
         return
      end if
      s7 = s1/s5
      s8 = s2/s5
      s9 = -1/s5
      s10 = -length/(r*s5)
      s11 = (-s6 - s1*cosine(1) + r*s2*sine(1) + z_dot/r)/s5     ! corrected: z' in place of x'
      s12 = cosine(2) + s6
      s13 = (-b*c3 + (h*c4 - xi*c3)*free_dot)/(r*h)
      s14 = s13 - r*sine(2)
      p(1, 1) = s1 + s12*(s7 + s9)                                                        ! (A7)
      p(1, 2) = s2 + s8*s12
      p(1, 3) = s10*s12
      p(1, 4) = -s1*cosine(1) + r*s2*sine(1) - s6 + s11*s12
      p(4, 1) = s7 + s9
      p(4, 2) = s8
      p(4, 3) = s10
      p(4, 4) = s11
      ! the change of x' just before the impact is shared by rows 2 and 3
      p(2, 1) = s3 + s14*(s7 + s9)         ! corrected in row 3: s3 in place of the printed s6
      p(2, 2) = s4 + s8*s14
      p(2, 3) = s10*s14
      p(2, 4) = -s3*cosine(1) + r*s4*sine(1) - s13 + s11*s14
      p(3, :) = k3*p(2, :)
      p(2, :) = k1*p(2, :)
      p(2, 3) = p(2, 3) + k2
      p(3, 3) = p(3, 3) + k4
   end subroutine impact_map

end module vi_impact_map
