!> Motions whose impact phases are given: the linear equations (26) and (30).
!!
!! N impacts in k load cycles give 2N equations in the N + 2 unknowns x_1 .. x_N, A cos(tau), A
!! sin(tau). They are proportional to the clearance, so they are solved with d = 1 and converted to
!! units of F0/K afterwards. N = 2 is a square system (DGESV); N > 2 is overdetermined (DGELS) and
!! consistent only if the phases are those of a motion.
module vi_periodic
   use vi_kinds, only: wp
   use vi_lapack, only: least_squares, least_squares_work, solve
   use vi_motion, only: audited, complete_motion, motion_type, start_motion
   use vi_oscillator, only: eta, oscillator_type
   use vi_pattern, only: pattern_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: assemble, solve_periodic

   !> The equations (26), i = 1..N, then (30), i = 1..N, with the scratch that solves them.
   type, public :: linear_system_type
      !> Coefficients (2N, N + 2) and right side (2N), for d = 1.
      real(wp), allocatable :: matrix(:, :), rhs(:)
      real(wp), allocatable :: work(:)
   end type linear_system_type

contains

   !> The motion with the given impact phases, without verdicts.
   pure subroutine solve_periodic(osc, r, pattern, restitution, phases, system, motion)
      !> Oscillator; its walls' coefficients are not read, `restitution` is.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio Omega/omega.
      real(wp), intent(in) :: r
      !> Sides of the N impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> Coefficient of restitution (N) and phase (N, increasing from 0, below 2 pi k) of each
      !! impact.
      real(wp), intent(in) :: restitution(:), phases(:)
      !> Scratch, kept between calls.
      type(linear_system_type), intent(inout) :: system
      !> Out: the motion, or its status; its arrays are reused between calls.
      type(motion_type), intent(inout) :: motion
      real(wp) :: size_of_rhs, residual, pivots(2), condition
      integer :: n

      n = size(phases)
      call start_motion(motion, osc, r, pattern, restitution, phases)
      if (free_amplitude(motion)) then
         motion%status = stat%free_amplitude
         return
      end if
      call assemble(motion, system)
      size_of_rhs = sqrt(sum(system%rhs**2))
      if (.not. size_of_rhs <= huge(1.0_wp)) then
         motion%status = stat%not_finite
         return
      end if
      if (n == 2) then
         residual = 0
         call solve(system%matrix, system%rhs, motion%status, pivots)
      else
         call least_squares(system%matrix, system%rhs, system%work, residual, motion%status, &
            pivots)
      end if
      if (motion%status /= stat%ok) return
      if (.not. all(abs(system%rhs(:n + 2)) <= huge(1.0_wp))) then
         motion%status = stat%not_finite
         return
      end if
      motion%residual = residual/size_of_rhs
      ! the error of a least squares solution grows with the residual
      condition = pivots(2)/pivots(1)
      if (audited) motion%rounding = epsilon(1.0_wp)*condition*(1 + condition*residual/(pivots(2) &
         *max(norm2(system%rhs(:n + 2)), tiny(1.0_wp))))
      call complete_motion(motion, system%rhs(:n), system%rhs(n + 1), system%rhs(n + 2), 1.0_wp)
   end subroutine solve_periodic

   !> Whether this is an equispaced pair with equal restitution, which leaves A free (rank 3).
   !!
   !! Rounding hides the missing rank in the factors, so its cause is tested instead.
   pure logical function free_amplitude(motion)
      !> With phases, pattern and restitution.
      type(motion_type), intent(in) :: motion

      free_amplitude = .false.
      if (size(motion%phases) /= 2 .or. modulo(motion%pattern%cycles, 2) == 0) return
      free_amplitude = abs(motion%restitution(1) - motion%restitution(2)) <= epsilon(1.0_wp) .and. &
         abs(motion%length(1) - motion%length(2)) <= 100*epsilon(1.0_wp)*sum(motion%length)
   end function free_amplitude

   !> Builds the equations (26) and (30) with the coefficients (A1)-(A4), omega = 1, Omega = r, d
   !! = 1.
   pure subroutine assemble(motion, system)
      !> Only the given data of this motion are read: oscillator, r, pattern, restitution, phases.
      type(motion_type), intent(in) :: motion
      !> Out: coefficients and right side for d = 1; its arrays are reused between calls.
      type(linear_system_type), intent(inout) :: system
      real(wp) :: w(6), v(7), y(4), h
      integer :: n, i, previous, next, after_next

      n = size(motion%phases)
      call enlarge(system, n)
      system%matrix = 0
      h = eta(motion%osc%xi)
      do i = 1, n
         previous = modulo(i - 2, n) + 1
         next = modulo(i, n) + 1
         after_next = modulo(i + 1, n) + 1
         y = 0.5_wp*motion%pattern%sides([previous, i, next, after_next])                 ! (18)
         call coefficients(motion%osc, h, motion%r, motion%restitution([i, next]), &
            motion%length([previous, i, next]), motion%c1(i), motion%c2(i), &
            motion%sine([i, next]), motion%cosine([i, next]), y(2:4) - y(1:3), w, v)
         ! the columns may coincide (N = 2), so the terms are added
         associate (m => system%matrix)
            m(i, i) = m(i, i) + w(1)                                                      ! (26)
            m(i, next) = m(i, next) + w(2)
            m(i, previous) = m(i, previous) + w(3)
            m(i, n + 1:) = w(4:5)
            m(n + i, i) = m(n + i, i) + v(1)                                              ! (30)
            m(n + i, next) = m(n + i, next) + v(2)
            m(n + i, after_next) = m(n + i, after_next) + v(3)
            m(n + i, previous) = m(n + i, previous) + v(4)
            m(n + i, n + 1:) = v(5:6)
         end associate
         system%rhs(i) = w(6)
         system%rhs(n + i) = v(7)
      end do
   end subroutine assemble

   !> W_1i..W_6i of (26) and V_1i..V_7i of (30) for one flight.
   pure subroutine coefficients(osc, h, r, restitution, length, c1, c2, sine, cosine, y_step, w, v)
      !> xi and mu are read.
      type(oscillator_type), intent(in) :: osc
      !> eta of (3), and the frequency ratio.
      real(wp), intent(in) :: h, r
      !> R of impacts i and i+1; phase lengths of flights i-1, i, i+1; C_1i, C_2i of (9), (10); sine
      !! and cosine of the phases alpha_i and alpha_(i+1); change of y in flights i-1, i, i+1.
      real(wp), intent(in) :: restitution(2), length(3), c1, c2, sine(2), cosine(2), y_step(3)
      !> W_1i .. W_6i, and V_1i .. V_7i.
      real(wp), intent(out) :: w(6), v(7)
      real(wp) :: c3, c4, g1, g2, g3, g4, sine_term, cosine_term, pull, c1h, c3h

      associate (xi => osc%xi, mu => osc%mu)
         c3 = h*c2 - xi*c1                                                                ! (A4)
         c4 = -(h*c1 + xi*c2)
         g1 = (1 + mu)*restitution(1)*r/((1 + restitution(1))*length(1))                  ! (A1)
         g2 = (1 - mu*restitution(1))*r/((1 + restitution(1))*length(2))
         g3 = (restitution(2) - mu)*r/((1 + restitution(2))*length(2))
         g4 = (1 + mu)*r/((1 + restitution(2))*length(3))
         c1h = c1/h
         c3h = c3/h
         sine_term = (r*cosine(1) + xi*sine(1))/h
         cosine_term = (-r*sine(1) + xi*cosine(1))/h
         pull = g1*y_step(1) + g2*y_step(2)

         w(1) = c1h*(g2 - g1 - xi) - c2                                                   ! (A2)
         w(2) = 1 - c1h*g2
         w(3) = c1h*g1
         w(4) = c1*sine_term + c2*sine(1) - sine(2)
         w(5) = c1*cosine_term + c2*cosine(1) - cosine(2)
         w(6) = c1h*pull

         v(1) = -g3 - c4 - c3h*(g1 - g2 + xi)                                             ! (A3)
         v(2) = g3 - g4 - c3h*g2
         v(3) = g4
         v(4) = c3h*g1
         v(5) = c3*sine_term + c4*sine(1) - r*cosine(2)
         v(6) = c3*cosine_term + c4*cosine(1) + r*sine(2)
         v(7) = -g3*y_step(2) - g4*y_step(3) + c3h*pull
      end associate
   end subroutine coefficients

   !> Allocates the arrays of a system for n impacts, unless they have that size already.
   pure subroutine enlarge(system, n)
      !> In and out: the system; the contents of its arrays are undefined afterwards.
      type(linear_system_type), intent(inout) :: system
      !> Number of impacts.
      integer, intent(in) :: n

      if (allocated(system%rhs)) then
         if (size(system%rhs) == 2*n) return
         deallocate (system%matrix, system%rhs, system%work)
      end if
      allocate (system%matrix(2*n, n + 2), system%rhs(2*n), &
         system%work(least_squares_work(2*n, n + 2)))
   end subroutine enlarge

end module vi_periodic
