!> Derivatives of the equations of a structure's motions with respect to a parameter, while the
!! unknowns are constant.
!!
!! At constant phases a higher frequency shortens all times by the same factor. Openings, motions of
!! walls, forces and coefficients of restitution act linearly. Masses, damping, stiffness and
!! directions of gaps change the modes: there the derivatives are central differences.
module vi_structure_slopes
   use vi_kinds, only: wp
   use vi_modes, only: steady_response, steady_slope
   use vi_orbit, only: family_type
   use vi_responses, only: jumps_of, offset_pairs, periodic_pair, periodic_pair_type, row_of_gap, &
      steady_pairs, stretched_response
   use vi_restitution, only: restitution_at, restitution_type
   use vi_structure, only: inputs_of
   use vi_structure_members, only: member_equations, member_type, of_family, set_member, &
      structure_members_type
   use vi_structure_motion, only: impulse_of, since
   use vi_structure_path, only: rates_of, rates_type
   implicit none (type, external)
   private

   public :: by_differences, equations_by_parameter

contains

   !> The derivatives of the equations with respect to a parameter.
   pure subroutine equations_by_parameter(s, family, unknowns, shares, member, k, slope, good)
      !> The structure.
      type(structure_members_type), intent(in) :: s
      !> The impacts.
      type(family_type), intent(in) :: family
      !> Unknowns of a motion, and the parameters as shares.
      real(wp), intent(in) :: unknowns(:), shares(:)
      !> The member with these unknowns and parameters.
      type(member_type), intent(in) :: member
      !> Number of the parameter.
      integer, intent(in) :: k
      !> (unknowns) The derivatives with respect to its share.
      real(wp), intent(out) :: slope(:)
      !> False if there are no such motions nearby.
      logical, intent(out) :: good
      type(rates_type) :: rates
      real(wp) :: whole(2*size(member%speeds) + size(member%offsets))

      call rates_of(s%path, k, shares(k), rates)
      good = .true.
      if (rates%modes) then
         call by_differences(s, family, unknowns, shares, k, slope, good)
      else
         call in_closed_form(member, rates, whole)
         slope = of_family(family, member, whole, size(slope))
      end if
   end subroutine equations_by_parameter

   !> The same by central differences.
   pure subroutine by_differences(s, family, unknowns, shares, k, slope, good)
      !> The structure.
      type(structure_members_type), intent(in) :: s
      !> The impacts.
      type(family_type), intent(in) :: family
      !> Unknowns of a motion, and the parameters as shares.
      real(wp), intent(in) :: unknowns(:), shares(:)
      !> Number of the parameter.
      integer, intent(in) :: k
      !> (unknowns) The derivatives with respect to its share.
      real(wp), intent(out) :: slope(:)
      !> False if there are no such motions nearby.
      logical, intent(out) :: good
      real(wp), parameter :: h = 1.0e-6_wp
      real(wp) :: moved(size(shares)), values(size(slope), 2)
      type(member_type) :: member
      integer :: i

      slope = 0
      do i = 1, 2
         moved = shares
         moved(k) = shares(k) + (3 - 2*i)*h
         call set_member(s, family, unknowns, moved, member)
         good = member%exists
         if (.not. good) return
         call member_equations(s, family, member, values(:, i))
      end do
      slope = (values(:, 1) - values(:, 2))/(2*h)
   end subroutine by_differences

   !> The derivatives of all equations where the modes and the directions of the gaps are constant.
   pure subroutine in_closed_form(member, rates, slope)
      !> The member.
      type(member_type), intent(in) :: member
      !> The derivatives of its structure and load.
      type(rates_type), intent(in) :: rates
      !> (2N + p) As the residuals of `vi_structure_motion`.
      real(wp), intent(out) :: slope(:)
      real(wp), dimension(size(member%speeds)) :: impulses, by_impulse, unused
      real(wp) :: forced(size(impulses), 0:1), response(size(impulses), size(impulses), 0:1), &
         supplied(size(member%offsets))
      type(restitution_type) :: law
      real(wp) :: by_first
      integer :: h, i, n
      complex(wp) :: here
      real(wp) :: phase

      n = size(impulses)
      call load_rates(member, rates, forced, supplied)
      do i = 1, n
         ! a wall that moves by more widens its gap
         do h = 1, size(rates%walls, 1)
            phase = h*member%regime%frequency*member%equations%times(i)
            here = rates%walls(h, member%equations%gaps(i))*cmplx(cos(phase), sin(phase), wp)
            forced(i, :) = forced(i, :) - [here%re, -h*member%regime%frequency*here%im]
         end do
      end do
      associate (equations => member%equations, gaps => member%equations%gaps)
         do i = 1, n
            call impulse_of(member%structure, gaps(i), member%speeds(i), impulses(i), unused(i))
            ! R is proportional to its value at speed 0
            law = member%structure%laws(gaps(i))
            law%numbers(1) = 1
            call restitution_at(law, max(0.0_wp, member%speeds(i)), by_first, unused(i))
            by_impulse(i) = rates%restitution(gaps(i))*by_first* &
               member%structure%effective(gaps(i))*member%speeds(i)
         end do
         slope(:n) = matmul(equations%response(:, :, 0), by_impulse) + forced(:, 0) &
            - rates%openings(gaps)
         slope(n + 1:2*n) = -matmul(equations%response(:, :, 1), by_impulse) - forced(:, 1)
         slope(2*n + 1:) = matmul(equations%balance, by_impulse) + supplied
         if (.not. abs(rates%frequency) > 0) return
         call stretched(member, response)
         associate (factor => -rates%frequency/member%regime%frequency)
            slope(:n) = slope(:n) + factor*matmul(response(:, :, 0), impulses)
            slope(n + 1:2*n) = slope(n + 1:2*n) - factor*matmul(response(:, :, 1), impulses)
            slope(2*n + 1:) = slope(2*n + 1:) + factor*equations%supplied
         end associate
      end associate
   end subroutine in_closed_form

   !> The derivatives of the responses with respect to the logarithm of a factor of all times.
   pure subroutine stretched(member, response)
      !> The member.
      type(member_type), intent(in) :: member
      !> (N, N, 0:1) As in `equations_type`.
      real(wp), intent(out) :: response(:, :, 0:)
      real(wp), dimension(size(member%regime%modes%stiffness), size(response, 1)) :: in_x, in_v, &
         of_x, of_v
      real(wp) :: x(0:1), v(0:1)
      type(periodic_pair_type) :: pair
      integer :: i, j, k

      response = 0
      associate (regime => member%regime, gaps => member%equations%gaps, &
         times => member%equations%times, period => member%equations%period)
         do i = 1, size(gaps)
            call jumps_of(member%structure, regime, gaps(i), in_x(:, i), in_v(:, i))
            call row_of_gap(member%structure, regime, gaps(i), of_x(:, i), of_v(:, i))
         end do
         do k = 1, size(regime%modes%stiffness)
            pair = periodic_pair(regime%modes%stiffness(k), regime%modes%damping(k), period)
            do j = 1, size(gaps)
               if (.not. abs(in_x(k, j)) + abs(in_v(k, j)) > 0) cycle
               do i = 1, size(gaps)
                  if (.not. abs(of_x(k, i)) + abs(of_v(k, i)) > 0) cycle
                  call stretched_response(pair, in_x(k, j), in_v(k, j), since(times, period, i, &
                     j), x, v)
                  response(i, j, :) = response(i, j, :) + of_x(k, i)*x + of_v(k, i)*v
               end do
            end do
         end do
      end associate
   end subroutine stretched

   !> The derivatives of what the load contributes to the equations.
   pure subroutine load_rates(member, rates, forced, supplied)
      !> The member.
      type(member_type), intent(in) :: member
      !> The derivatives of its load.
      type(rates_type), intent(in) :: rates
      !> (N, 0:1), (p): as in `equations_type`.
      real(wp), intent(out) :: forced(:, 0:), supplied(:)
      real(wp), dimension(size(member%regime%modes%stiffness)) :: of_x, of_v
      complex(wp), dimension(size(of_x)) :: x, v, by_x, by_v
      real(wp), allocatable :: drifts(:, :), inputs(:, :)
      integer, allocatable :: pairs(:)
      logical :: resonant(size(of_x))
      complex(wp) :: here, turn
      real(wp) :: omega
      integer :: given, h, harmonics, i, status

      forced = 0
      supplied = 0
      if (.not. any(abs(rates%forces) > 0) .and. .not. abs(rates%frequency) > 0) return
      associate (regime => member%regime, structure => member%structure, &
         equations => member%equations)
         harmonics = size(regime%ripple, 2)
         given = (size(rates%forces, 2) - 1)/2
         ! a wall can move with more harmonics than the load has
         allocate (inputs(size(rates%forces, 1), 1 + 2*harmonics), source=0.0_wp)
         inputs(:, :1 + given) = rates%forces(:, :1 + given)
         inputs(:, 2 + harmonics:1 + harmonics + given) = rates%forces(:, 2 + given:)
         ! this succeeds: the same mass matrix was solved when the member was made
         call inputs_of(structure%mass, regime%xd, regime%vd, inputs, drifts, status)
         allocate (pairs, source=offset_pairs(regime))
         supplied = equations%period*(2*regime%modes%damping(pairs)*drifts(pairs, 1) &
            + inputs(pairs, 1))
         where (equations%apart) supplied = 0
         do h = 0, harmonics
            omega = h*regime%frequency
            if (h == 0) then
               call steady_pairs(regime%modes%stiffness, regime%modes%damping, drifts(:, 1), &
                  inputs(:, 1), x%re, v%re)
               x%im = 0
               v%im = 0
            else
               call steady_response(regime%modes%stiffness, regime%modes%damping, omega, &
                  cmplx(drifts(:, 1 + h), -drifts(:, 1 + harmonics + h), wp), &
                  cmplx(inputs(:, 1 + h), -inputs(:, 1 + harmonics + h), wp), x, v, resonant)
               call steady_slope(regime%modes%stiffness, regime%modes%damping, omega, &
                  regime%wave_drift(:, h), regime%wave_force(:, h), by_x, by_v)
               x = x + h*rates%frequency*by_x
               v = v + h*rates%frequency*by_v
            end if
            do i = 1, size(equations%gaps)
               associate (gap => equations%gaps(i), phase => regime%frequency*equations%times(i))
                  call row_of_gap(structure, regime, gap, of_x, of_v)
                  turn = cmplx(cos(h*phase), sin(h*phase), wp)
                  here = turn*sum(of_x*x + of_v*v)
                  forced(i, :) = forced(i, :) + [here%re, -omega*here%im]
                  if (h == 0) cycle
                  here = turn*regime%ripple(structure%channel(gap), h)*structure%wall(gap)
                  forced(i, 1) = forced(i, 1) - h*rates%frequency*here%im
               end associate
            end do
         end do
      end associate
   end subroutine load_rates

end module vi_structure_slopes
