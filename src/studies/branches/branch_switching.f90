!> The motions that begin at a bifurcation of another motion, each at parameters near it.
!!
!! At a pitchfork, two motions without mirror symmetry begin; at a flip, one of twice the period; at
!! a grazing, one in which the touch is an impact. Newton's method starts from the motion at the
!! bifurcation, changed along the critical eigenvector of [P], or with the touch inserted.
module vi_branch_switching
   use vi_assess, only: assess_exact, assess_flights
   use vi_branch_of, only: is_symmetric
   use vi_exact, only: member, setting_type, solve_exact
   use vi_extrema, only: relative_extrema
   use vi_flight, only: flight_state, flight_type
   use vi_impact_map, only: impact_maps
   use vi_kinds, only: pi, wp
   use vi_lapack, only: eigenvector
   use vi_motion, only: flight_of, motion_type, yes
   use vi_orbit, only: by_clearance, by_left, by_mu, by_r, by_right, by_xi, n_parameters, &
      oscillator_of
   use vi_oscillator, only: at_resonance
   use vi_pattern, only: default_restitution, pattern_type
   use vi_points, only: store_motion
   use vi_stability, only: stability_matrix
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: switch_arrays, switch_branch

   !> Kinds of bifurcations at which motions begin, and largest number of motions that begin at one.
   integer, parameter, public :: at_pitchfork = 1, at_flip = 2, at_grazing = 3
   integer, parameter, public :: most_switched = 2

   !> Changes of the parameter, over its value, at which a motion is sought, and sizes of the first
   !! change along the eigenvector (of positions over the clearance, of phases).
   real(wp), parameter :: offsets(4) = [1.0e-4_wp, 1.0e-3_wp, 5.0e-3_wp, 2.0e-2_wp], &
      sizes(4) = [0.003_wp, 0.01_wp, 0.03_wp, 0.1_wp]
   !> Largest distance of a multiplier from 1 or -1 at which it still counts as the critical one.
   real(wp), parameter :: critical = 1.0e-2_wp

contains

   !> As `switch_branch`, with results in arrays.
   pure subroutine switch_arrays(motion, kind, flight, side, parameter, tied, n, lengths, cycles, &
      sides, systems, phases, impacts, scalars, multipliers, verdicts)
      !> As in `switch_branch`.
      type(motion_type), intent(in) :: motion
      !> As in `switch_branch`.
      integer, intent(in) :: kind, flight, side, parameter
      !> As in `switch_branch`.
      logical, intent(in) :: tied
      !> Number m of motions found.
      integer, intent(out) :: n
      !> Impacts of each (m), load cycles (m), and sides (capacity, m).
      integer, intent(out) :: lengths(:), cycles(:), sides(:, :)
      !> r, D, xi, mu, R1, R2 of each (6, m); (capacity, m), (capacity, 6, m), (6, m) as in
      !! vi_points.
      real(wp), intent(out) :: systems(:, :), phases(:, :), impacts(:, :, :), scalars(:, :)
      !> (4, m) By decreasing modulus.
      complex(wp), intent(out) :: multipliers(:, :)
      !> (3, m) consistent, admissible, stable.
      integer, intent(out) :: verdicts(:, :)
      type(motion_type) :: found(most_switched)
      integer :: i, unused

      call switch_branch(motion, kind, flight, side, parameter, tied, found, n)
      lengths = 0
      do i = 1, n
         associate (m => lengths(i))
            m = size(found(i)%x)
            cycles(i) = found(i)%pattern%cycles
            sides(:m, i) = found(i)%pattern%sides
            systems(:, i) = parameters_of(found(i))
            phases(:m, i) = found(i)%phases
            call store_motion(found(i), .true., impacts(:m, :, i), scalars(:, i), &
               multipliers(:, i), verdicts(:, i), unused)
         end associate
      end do
   end subroutine switch_arrays

   !> The motions that begin at a bifurcation, each at a nearby parameter value where it exists.
   pure subroutine switch_branch(motion, kind, flight, side, parameter, tied, found, n)
      !> The motion at the bifurcation, with clearance and oscillator.
      type(motion_type), intent(in) :: motion
      !> One of the kinds above.
      integer, intent(in) :: kind
      !> For a grazing: the flight that touches a wall, and the wall (+1 or -1).
      integer, intent(in) :: flight, side
      !> Place of the parameter in the core (`by_r` .. `by_left`).
      integer, intent(in) :: parameter
      !> Whether R2 always equals R1.
      logical, intent(in) :: tied
      !> (most_switched) Out: the motions 1 to n, with their verdicts.
      type(motion_type), intent(out) :: found(:)
      !> Number of motions found.
      integer, intent(out) :: n
      type(motion_type) :: once
      integer :: half
      logical :: good

      n = 0
      select case (kind)
      case (at_pitchfork)
         call part(motion, motion%pattern, 1.0_wp, parameter, tied, found(1), good)
         if (good) call mirror(found(1), found(2), good)
         if (good) n = 2
      case (at_flip)
         call undouble(motion, once)
         call part(once, pattern_type([once%pattern%sides, once%pattern%sides], &
            2*once%pattern%cycles), -1.0_wp, parameter, tied, found(1), good)
         if (good) n = 1
      case default
         call with_touches(motion, [flight], [side], parameter, tied, found(1), good)
         if (good) n = 1
         if (.not. is_symmetric(motion)) return
         ! the mirror image of the flight touches the other wall at the same point
         half = size(motion%x)/2
         if (flight <= half) then
            call with_touches(motion, [flight, flight + half], [side, -side], parameter, tied, &
               found(n + 1), good)
         else
            call with_touches(motion, [flight - half, flight], [-side, side], parameter, tied, &
               found(n + 1), good)
         end if
         if (good) n = n + 1
      end select
   end subroutine switch_branch

   !> The motion itself, or the motion of half its period if it repeats itself after that time, as
   !! at the end of a branch of doubled motions, a small distance from the flip.
   pure subroutine undouble(motion, once)
      !> A motion.
      type(motion_type), intent(in) :: motion
      !> The same, without verdicts.
      type(motion_type), intent(out) :: once
      real(wp), parameter :: near = 1.0e-4_wp
      real(wp), dimension(size(motion%x)/2) :: x, theta, of_x, of_theta
      integer :: n, half

      once = motion
      n = size(motion%x)
      half = n/2
      associate (pattern => motion%pattern)
         if (modulo(n, 2) /= 0 .or. modulo(pattern%cycles, 2) /= 0) return
         if (any(pattern%sides(:half) /= pattern%sides(half + 1:))) return
         of_x = motion%x(half + 1:) - motion%x(:half)
         of_theta = motion%phases(half + 1:) - motion%phases(:half) - pi*pattern%cycles
         if (any(abs(of_x) > near*motion%clearance) .or. any(abs(of_theta) > near)) return
         x = motion%x(:half) + 0.5_wp*of_x
         theta = motion%tau + motion%phases(:half) + 0.5_wp*of_theta
         call member(setting_type(motion%osc, motion%r, 1.0_wp, motion%clearance, &
            pattern_type(pattern%sides(:half), pattern%cycles/2), motion%restitution(:half)), x, &
            theta, once)
      end associate
   end subroutine undouble

   !> A motion that branches off from another one along the eigenvector of a multiplier 1 or -1.
   pure subroutine part(motion, pattern, multiplier, parameter, tied, found, good)
      !> The motion at the bifurcation.
      type(motion_type), intent(in) :: motion
      !> Pattern of the motion that branches off: the same, or the same twice.
      type(pattern_type), intent(in) :: pattern
      !> The critical multiplier, 1 or -1: the factor of the change from period to period.
      real(wp), intent(in) :: multiplier
      !> As in `switch_branch`.
      integer, intent(in) :: parameter
      !> As in `switch_branch`.
      logical, intent(in) :: tied
      !> The motion.
      type(motion_type), intent(out) :: found
      !> Whether it was found.
      logical, intent(out) :: good
      real(wp), dimension(size(pattern%sides)) :: x, theta, of_x, of_theta, apart
      real(wp) :: change(size(motion%x), 2), c(n_parameters), along
      integer :: i, j, n, sign, times

      call critical_change(motion, multiplier, change, good)
      if (.not. good) return
      n = size(motion%x)
      times = size(pattern%sides)/n
      do i = 1, times
         x((i - 1)*n + 1:i*n) = motion%x
         theta((i - 1)*n + 1:i*n) = motion%phases + motion%tau + 2*pi*motion%pattern%cycles*(i - 1)
         of_x((i - 1)*n + 1:i*n) = multiplier**(i - 1)*change(:, 1)
         of_theta((i - 1)*n + 1:i*n) = multiplier**(i - 1)*change(:, 2)
      end do
      do i = 1, size(offsets)
         do sign = 1, -1, -2
            call move_beside(motion, parameter, tied, sign*offsets(i), c, good)
            if (.not. good) cycle
            do j = 1, size(sizes)
               call solve_at(c, pattern, x + sizes(j)*of_x*c(by_clearance), &
                  theta + sizes(j)*of_theta, found)
               good = found%status == stat%ok
               if (.not. good) cycle
               apart = found%phases + found%tau - theta
               apart = modulo(apart + pi, 2*pi) - pi
               along = dot_product((found%x - x)/c(by_clearance), of_x) + dot_product(apart, &
                  of_theta)
               good = abs(along) > 0.3_wp*sizes(j)*(sum(of_x**2) + sum(of_theta**2))
               if (good) return
            end do
         end do
      end do
      good = .false.
   end subroutine part

   !> The change of x_i/D and alpha_i along the eigenvector of a multiplier, its largest entry 1.
   pure subroutine critical_change(motion, multiplier, change, good)
      !> The motion at the bifurcation.
      type(motion_type), intent(in) :: motion
      !> The critical multiplier.
      real(wp), intent(in) :: multiplier
      !> (N, 2) of x_i/D and of alpha_i.
      real(wp), intent(out) :: change(:, :)
      !> False if no multiplier is near the critical one.
      logical, intent(out) :: good
      real(wp) :: maps(4, 4, size(motion%x)), p(4, 4), state(4)
      complex(wp) :: value
      integer :: i, status

      change = 0
      call stability_matrix(motion, p, status)
      good = status == stat%ok
      if (.not. good) return
      call eigenvector(p, multiplier, value, state, status)
      good = status == stat%ok .and. abs(value - multiplier) < critical
      if (.not. good) return
      call impact_maps(motion, maps, good)
      do i = 1, size(motion%x)
         change(i, :) = [state(1)/motion%clearance, state(4)]
         state = matmul(maps(:, :, i), state)
      end do
      change = change/maxval(abs(change))
   end subroutine critical_change

   !> The mirror image of a motion of a pattern whose second half mirrors the first.
   pure subroutine mirror(motion, image, good)
      !> The motion.
      type(motion_type), intent(in) :: motion
      !> Its mirror image, of the same pattern.
      type(motion_type), intent(out) :: image
      !> Whether Newton's method confirms it.
      logical, intent(out) :: good
      real(wp), dimension(size(motion%x)) :: theta
      integer :: half

      half = size(motion%x)/2
      theta = cshift(motion%phases + motion%tau, half)
      theta(half + 1:) = theta(half + 1:) + 2*pi*motion%pattern%cycles
      call solve_at(parameters_of(motion), motion%pattern, -cshift(motion%x, half), &
         theta - pi*motion%pattern%cycles, image)
      good = image%status == stat%ok
   end subroutine mirror

   !> The motion near a grazing with one more impact in each of the given flights that touch a wall.
   pure subroutine with_touches(motion, flights, walls, parameter, tied, found, good)
      !> The motion at the grazing.
      type(motion_type), intent(in) :: motion
      !> The flights in rising order, and the wall that each touches (+1 or -1).
      integer, intent(in) :: flights(:), walls(:)
      !> As in `switch_branch`.
      integer, intent(in) :: parameter
      !> As in `switch_branch`.
      logical, intent(in) :: tied
      !> The motion, which is admissible.
      type(motion_type), intent(out) :: found
      !> Whether it was found.
      logical, intent(out) :: good
      real(wp), dimension(size(motion%x) + size(flights)) :: x, theta
      real(wp) :: c(n_parameters), time, position
      integer :: sides(size(x)), i, j, n, m, sign

      n = size(motion%x)
      m = 0
      do i = 1, n
         x(i + m) = motion%x(i)
         theta(i + m) = motion%phases(i) + motion%tau
         sides(i + m) = motion%pattern%sides(i)
         do j = 1, size(flights)
            if (flights(j) /= i) cycle
            call find_touch(flight_of(motion, i), walls(j), time, position)
            good = time > 0
            if (.not. good) return
            m = m + 1
            x(i + m) = position
            theta(i + m) = theta(i + m - 1) + motion%r*time
            sides(i + m) = walls(j)
         end do
      end do
      do i = 1, size(offsets)
         do sign = 1, -1, -2
            call move_beside(motion, parameter, tied, sign*offsets(i), c, good)
            if (.not. good) cycle
            call solve_at(c, pattern_type(sides, motion%pattern%cycles), &
               x*(c(by_clearance)/motion%clearance), theta, found)
            good = found%status == stat%ok
            if (good) good = found%admissible == yes .and. &
               all(abs(found%phases - theta + theta(1)) < 0.2_wp)
            if (good) return
         end do
      end do
   end subroutine with_touches

   !> Where a flight is nearest to a wall, from certified extrema.
   pure subroutine find_touch(flight, wall, time, position)
      !> The flight.
      type(flight_type), intent(in) :: flight
      !> +1 or -1.
      integer, intent(in) :: wall
      !> Time after its start (1/omega), negative if it has no extremum; and x then (F0/K).
      real(wp), intent(out) :: time, position
      real(wp) :: lowest, highest, lowest_at, highest_at, x_dot, x_ddot
      logical :: complete

      call relative_extrema(flight, lowest, highest, complete, lowest_at, highest_at)
      time = merge(highest_at, lowest_at, wall > 0)
      if (.not. complete) time = -1
      call flight_state(flight, max(time, 0.0_wp), position, x_dot, x_ddot)
   end subroutine find_touch

   !> The parameters r, D, xi, mu, R1, R2 of a motion.
   pure function parameters_of(motion) result(c)
      !> The motion.
      type(motion_type), intent(in) :: motion
      real(wp) :: c(n_parameters)

      c([by_r, by_clearance, by_xi, by_mu, by_right, by_left]) = [motion%r, motion%clearance, &
         motion%osc%xi, motion%osc%mu, motion%osc%restitution]
   end function parameters_of

   !> The parameters of a motion, with a small change of one of them.
   pure subroutine move_beside(motion, parameter, tied, offset, c, allowed)
      !> The motion.
      type(motion_type), intent(in) :: motion
      !> As in `switch_branch`.
      integer, intent(in) :: parameter
      !> As in `switch_branch`.
      logical, intent(in) :: tied
      !> Change of the parameter over its value (over 0.01 if the value is less).
      real(wp), intent(in) :: offset
      !> r, D, xi, mu, R1, R2
      real(wp), intent(out) :: c(:)
      !> Whether these parameters are allowed.
      logical, intent(out) :: allowed

      c = parameters_of(motion)
      c(parameter) = c(parameter) + offset*max(c(parameter), 0.01_wp)
      if (tied) c(by_left) = c(by_right)
      allowed = c(by_xi) >= 0 .and. c(by_xi) < 1 .and. c(by_mu) >= 0 .and. &
         all(c([by_right, by_left]) >= 0 .and. c([by_right, by_left]) <= 1) .and. &
         .not. at_resonance(c(by_xi), c(by_r))
   end subroutine move_beside

   !> The exact motion of a pattern near a guess, with its verdicts.
   pure subroutine solve_at(c, pattern, x, theta, motion)
      !> r, D, xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> Sides of the N impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> (N) Guess: positions x_i (F0/K) and theta_i = alpha_i + tau (rad).
      real(wp), intent(in) :: x(:), theta(:)
      !> The motion, or its status.
      type(motion_type), intent(out) :: motion
      integer, parameter :: most_iterations = 50
      real(wp) :: x_now(size(x)), theta_now(size(x)), none(2*size(x), 0)
      integer :: iterations

      x_now = x
      theta_now = theta
      call solve_exact(setting_type(oscillator_of(c), c(by_r), 1.0_wp, c(by_clearance), pattern, &
         default_restitution(pattern%sides, c(by_right), c(by_left))), x_now, theta_now, &
         most_iterations, none, motion, iterations)
      call assess_exact(motion)
      call assess_flights(motion)
   end subroutine solve_at

end module vi_branch_switching
