!> The least and greatest values of the coordinates of a structure over a period.
module vi_structure_extremes
   use vi_kinds, only: wp
   use vi_orbit, only: family_type
   use vi_structure, only: regime_type
   use vi_structure_members, only: flight_duration, member_type
   use vi_structure_touches, only: rows_at
   implicit none (type, external)
   private

   public :: coordinate_extremes, extend_extremes, turning_share

   !> Nodes per time unit of the structure, and limits on their number.
   integer, parameter :: density = 4, fewest = 16, most = 20000

contains

   !> The extremes of a motion without rest.
   pure subroutine coordinate_extremes(family, member, extremes)
      !> The impacts of the family; with `mirror` those of half a period.
      type(family_type), intent(in) :: family
      !> The motion, with its flights.
      type(member_type), intent(in) :: member
      !> (n, 2) Least and greatest value.
      real(wp), intent(out) :: extremes(:, :)
      real(wp) :: least(size(extremes, 1))
      integer :: i

      extremes(:, 1) = huge(1.0_wp)
      extremes(:, 2) = -huge(1.0_wp)
      do i = 1, size(family%sides)
         call extend_extremes(member%regime, member%x_after(:, i), member%v_after(:, i), &
            member%equations%times(i), flight_duration(member, i), extremes)
      end do
      if (.not. family%mirror) return
      least = extremes(:, 1)
      extremes(:, 1) = min(least, -extremes(:, 2))
      extremes(:, 2) = max(extremes(:, 2), -least)
   end subroutine coordinate_extremes

   !> Extends extremes by those of a flight or a rest, from nodes close together and, where a
   !! velocity changes its sign between two of them, from the motion where a cubic through positions
   !! and velocities turns.
   pure subroutine extend_extremes(regime, x, v, time, duration, extremes)
      !> The regime of the flight or rest.
      type(regime_type), intent(in) :: regime
      !> (m) The pairs at the beginning, the time there, and the duration.
      real(wp), intent(in) :: x(:), v(:), time, duration
      !> In and out: (n, 2) least and greatest value.
      real(wp), intent(inout) :: extremes(:, :)
      real(wp), dimension(size(extremes, 1)) :: q, rate, before, rate_before, there, rate_there
      real(wp) :: h, share, value
      integer :: j, k, nodes

      nodes = max(fewest, min(most, ceiling(density*duration/regime%unit)))
      h = duration/nodes
      do k = 0, nodes
         call rows_at(regime, regime%coordinates, x, v, time, k*h, q, rate)
         extremes(:, 1) = min(extremes(:, 1), q)
         extremes(:, 2) = max(extremes(:, 2), q)
         if (k > 0) then
            do j = 1, size(q)
               if (.not. rate_before(j)*rate(j) < 0) cycle
               call turning_share(before(j), q(j), h*rate_before(j), h*rate(j), share)
               call rows_at(regime, regime%coordinates, x, v, time, (k - 1 + share)*h, there, &
                  rate_there)
               ! the velocity that is left there changes the extreme by its square
               value = there(j) - 0.5_wp*rate_there(j)**2*h/(rate(j) - rate_before(j))
               extremes(j, 1) = min(extremes(j, 1), value)
               extremes(j, 2) = max(extremes(j, 2), value)
            end do
         end if
         before = q
         rate_before = rate
      end do
   end subroutine extend_extremes

   !> Where a cubic turns between two nodes at which its slopes have opposite signs.
   pure subroutine turning_share(a, b, slope_a, slope_b, share)
      !> Values and slopes at both nodes, their distance being 1.
      real(wp), intent(in) :: a, b, slope_a, slope_b
      !> The share of the way.
      real(wp), intent(out) :: share
      real(wp) :: low, high, c2, c3
      integer :: i

      c2 = 3*(b - a) - 2*slope_a - slope_b
      c3 = 2*(a - b) + slope_a + slope_b
      low = 0
      high = 1
      do i = 1, 50
         share = 0.5_wp*(low + high)
         if ((slope_a + share*(2*c2 + 3*share*c3))*slope_a > 0) then
            low = share
         else
            high = share
         end if
      end do
   end subroutine turning_share

end module vi_structure_extremes
