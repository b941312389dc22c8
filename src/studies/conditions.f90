!> The conditions under which a motion is stable and admissible, as numbers that are positive there.
!!
!! Each is smooth along a family, and zero where a bifurcation of its own kind ends the zone.
module vi_conditions
   use vi_extrema, only: relative_extrema
   use vi_family, only: kinship, repetition_type
   use vi_flight, only: flight_position, flight_type, new_flight
   use vi_kinds, only: wp
   use vi_orbit, only: family_type, n_parameters, orbit_type, period_map, set_orbit
   use vi_oscillation, only: derivatives
   implicit none (type, external)
   private

   public :: all_conditions, condition_value, condition_at, characteristic, is_contraction, &
      is_inside

   !> Kinds of conditions; `flip` of a symmetric family is the pitchfork.
   integer, parameter, public :: fold = 1, flip = 2, neimark_sacker = 3, zero_approach = 4, &
      grazing = 5, repetition = 6, edge = 7, rest_vanishes = 8

   !> Distance in (u, theta) at which a motion counts as one that repeats itself.
   real(wp), parameter, public :: apart = 1.0e-4_wp

   !> One condition. After an impact with R = 0 the masses stay together unless the primary mass
   !! moves away at once: there a motion with rest ends (`rest_vanishes`). `index` is the impact, the flight, the repetition or the parameter.
   type, public :: condition_type
      integer :: kind = 0, index = 0
      !> Grazing: the wall and the share of the flight's duration; edge: +1 below, -1 above.
      integer :: side = 0
      real(wp) :: share = 0
      !> Edge: the bound on the parameter.
      real(wp) :: bound = 0
   end type condition_type

   !> What is fixed along a curve or sheet of motions.
   type, public :: frame_type
      type(family_type) :: family
      type(repetition_type), allocatable :: repetitions(:)
      !> Bounds on parameters.
      type(condition_type), allocatable :: edges(:)
   end type frame_type

contains

   !> The list of conditions of a frame, without the details that `all_conditions` finds.
   pure function condition_at(frame, j) result(condition)
      type(frame_type), intent(in) :: frame
      integer, intent(in) :: j
      type(condition_type) :: condition
      integer :: n, m

      n = size(frame%family%sides)
      m = size(frame%repetitions)
      if (j <= 3) then
         condition = condition_type(j, 0)
      else if (j <= 3 + n) then
         condition = condition_type(zero_approach, j - 3)
      else if (j <= 3 + 2*n) then
         condition = condition_type(grazing, j - 3 - n)
      else if (j <= 3 + 2*n + m) then
         condition = condition_type(repetition, j - 3 - 2*n)
      else
         condition = frame%edges(j - 3 - 2*n - m)
      end if
   end function condition_at

   !> The values of all conditions: 3 of stability, n approaches, n gaps, repetitions, edges.
   pure subroutine all_conditions(frame, unknowns, c, values, found)
      type(frame_type), intent(in) :: frame
      real(wp), intent(in) :: unknowns(:), c(:)
      real(wp), intent(out) :: values(:)
      !> The conditions with their details.
      type(condition_type), intent(out) :: found(:)
      type(orbit_type) :: o
      integer :: j, n

      n = size(frame%family%sides)
      call set_orbit(frame%family, unknowns, c, o)
      values(:3) = stability_values(frame, unknowns, o)
      do j = 1, size(values)
         found(j) = condition_at(frame, j)
         select case (found(j)%kind)
         case (fold, flip, neimark_sacker)
         case (grazing)
            call least_gap(o, found(j), values(j))
         case default
            values(j) = simple_value(frame, unknowns, o, c, found(j))
         end select
      end do
   end subroutine all_conditions

   !> The value of one condition; of grazing, at the stationary point it tells.
   pure real(wp) function condition_value(frame, unknowns, c, condition) result(value)
      type(frame_type), intent(in) :: frame
      real(wp), intent(in) :: unknowns(:), c(:)
      type(condition_type), intent(in) :: condition
      type(orbit_type) :: o
      type(condition_type) :: touch
      real(wp) :: three(3)

      if (condition%kind == edge) then
         value = condition%side*(c(condition%index) - condition%bound)
         return
      end if
      call set_orbit(frame%family, unknowns, c, o)
      select case (condition%kind)
      case (fold, flip, neimark_sacker)
         three = stability_values(frame, unknowns, o)
         value = three(condition%kind)
      case (grazing)
         touch = condition
         call polish_touch(o, touch, value)
      case default
         value = simple_value(frame, unknowns, o, c, condition)
      end select
   end function condition_value

   pure real(wp) function simple_value(frame, unknowns, o, c, condition) result(value)
      type(frame_type), intent(in) :: frame
      real(wp), intent(in) :: unknowns(:), c(:)
      type(orbit_type), intent(in) :: o
      type(condition_type), intent(in) :: condition

      associate (i => condition%index)
         select case (condition%kind)
         case (zero_approach)
            value = o%side(i)*(o%speed(i - 1) - o%before(i))
         case (repetition)
            value = kinship(frame%family, frame%repetitions(i), unknowns) - apart
         case (rest_vanishes)
            value = departure(o, i)
         case default
            value = condition%side*(c(i) - condition%bound)
         end select
      end associate
   end function simple_value

   !> How fast the masses part after an impact with R = 0: their relative acceleration.
   pure real(wp) function departure(o, i)
      type(orbit_type), intent(in) :: o
      integer, intent(in) :: i
      real(wp) :: d(0:5)

      d = derivatives(flight_at(o, i), 0.0_wp)
      departure = o%side(i)*d(2)
   end function departure

   !> det(I - Q), det(I + Q) and the product of all 1 - lambda_i lambda_j, i < j.
   !!
   !! The first is divided by the squared distances to motions that repeat themselves, since these
   !! are reached with a multiplier 1 whose distance to 1 goes with that square; the first two are
   !! multiplied by the approach speeds, since a multiplier grows like the inverse of such a speed.
   pure function stability_values(frame, unknowns, o) result(values)
      type(frame_type), intent(in) :: frame
      real(wp), intent(in) :: unknowns(:)
      type(orbit_type), intent(in) :: o
      real(wp) :: values(3)
      real(wp) :: p(4, 4), e(4), speeds
      logical :: regular
      integer :: i

      call period_map(o, p, regular)
      values = 0
      if (.not. regular) return
      e = characteristic(p)
      speeds = product(o%side(1:o%n)*(o%speed(0:o%n - 1) - o%before(1:o%n)))
      values(fold) = (1 - e(1) + e(2) - e(3) + e(4))*speeds
      values(flip) = (1 + e(1) + e(2) + e(3) + e(4))*speeds
      do i = 1, size(frame%repetitions)
         values(fold) = values(fold)/max(0.1_wp*apart, &
            kinship(frame%family, frame%repetitions(i), unknowns))**2
      end do
      ! the resolvent cubic of the characteristic polynomial at 1 + e4
      associate (d => 1 + e(4))
         values(neimark_sacker) = ((d - e(2))*d + e(1)*e(3) - 4*e(4))*d &
            - (e(1)**2*e(4) - 4*e(2)*e(4) + e(3)**2)
      end associate
      ! all three can be positive where several multipliers have crossed the unit circle; this one
      ! of Jury's conditions fails there by far, and on the edge of the stable ones it is met, or
      ! just so where three multipliers are on the circle
      if (abs(e(3) - e(1)*e(4)) > 1.001_wp*(1 - e(4)**2)) values(neimark_sacker) = &
         -abs(values(neimark_sacker))
   end function stability_values

   !> The elementary symmetric functions of the eigenvalues of a matrix.
   pure function characteristic(p) result(e)
      real(wp), intent(in) :: p(4, 4)
      real(wp) :: e(4)
      real(wp) :: m12, m13, m14, m23, m24, m34, n12, n13, n14, n23, n24, n34

      ! 2 x 2 minors of rows 1, 2 and of rows 3, 4
      m12 = p(1, 1)*p(2, 2) - p(1, 2)*p(2, 1)
      m13 = p(1, 1)*p(2, 3) - p(1, 3)*p(2, 1)
      m14 = p(1, 1)*p(2, 4) - p(1, 4)*p(2, 1)
      m23 = p(1, 2)*p(2, 3) - p(1, 3)*p(2, 2)
      m24 = p(1, 2)*p(2, 4) - p(1, 4)*p(2, 2)
      m34 = p(1, 3)*p(2, 4) - p(1, 4)*p(2, 3)
      n12 = p(3, 1)*p(4, 2) - p(3, 2)*p(4, 1)
      n13 = p(3, 1)*p(4, 3) - p(3, 3)*p(4, 1)
      n14 = p(3, 1)*p(4, 4) - p(3, 4)*p(4, 1)
      n23 = p(3, 2)*p(4, 3) - p(3, 3)*p(4, 2)
      n24 = p(3, 2)*p(4, 4) - p(3, 4)*p(4, 2)
      n34 = p(3, 3)*p(4, 4) - p(3, 4)*p(4, 3)
      e(1) = p(1, 1) + p(2, 2) + p(3, 3) + p(4, 4)
      e(2) = m12 + n34 + p(1, 1)*(p(3, 3) + p(4, 4)) + p(2, 2)*(p(3, 3) + p(4, 4)) &
         - p(1, 3)*p(3, 1) - p(1, 4)*p(4, 1) - p(2, 3)*p(3, 2) - p(2, 4)*p(4, 2)
      e(3) = p(3, 3)*m12 - p(3, 2)*m13 + p(3, 1)*m23 + p(4, 4)*m12 - p(4, 2)*m14 + p(4, 1)*m24 &
         + p(1, 1)*n34 - p(1, 3)*n14 + p(1, 4)*n13 + p(2, 2)*n34 - p(2, 3)*n24 + p(2, 4)*n23
      e(4) = m12*n34 - m13*n24 + m14*n23 + m23*n14 - m24*n13 + m34*n12
   end function characteristic

   !> Whether all eigenvalues lie inside the unit circle, by Jury's conditions.
   pure logical function is_contraction(e)
      !> As `characteristic` gives them.
      real(wp), intent(in) :: e(4)
      real(wp) :: resolvent

      associate (d => 1 + e(4))
         resolvent = ((d - e(2))*d + e(1)*e(3) - 4*e(4))*d &
            - (e(1)**2*e(4) - 4*e(2)*e(4) + e(3)**2)
      end associate
      is_contraction = abs(e(4)) < 1 .and. 1 + e(2) + e(4) > abs(e(1) + e(3)) .and. &
         abs(e(3) - e(1)*e(4)) < 1 - e(4)**2 .and. resolvent > 0
   end function is_contraction

   !> Whether all conditions are met, those on the edges of one parameter included.
   pure logical function is_inside(conditions, values, parameter) result(inside)
      type(condition_type), intent(in) :: conditions(:)
      real(wp), intent(in) :: values(:)
      integer, intent(in) :: parameter

      inside = all(values > 0 .or. (conditions%kind == edge .and. conditions%index /= parameter))
   end function is_inside

   !> The least gap at a stationary point inside a flight; one half where there is none nearer.
   !! After an impact with R = 0 the departure counts as well.
   pure subroutine least_gap(o, touch, gap)
      type(orbit_type), intent(in) :: o
      !> In: the flight. Out: also the wall and when.
      type(condition_type), intent(inout) :: touch
      real(wp), intent(out) :: gap
      real(wp) :: lowest, highest, lowest_at, highest_at
      logical :: complete

      call relative_extrema(flight_at(o, touch%index), lowest, highest, complete, lowest_at, &
         highest_at)
      gap = 0.5_wp
      touch%side = 0
      if (0.5_wp - highest < gap) then
         gap = 0.5_wp - highest
         touch%side = 1
         touch%share = highest_at/o%time(touch%index)
      end if
      if (lowest + 0.5_wp < gap) then
         gap = lowest + 0.5_wp
         touch%side = -1
         touch%share = lowest_at/o%time(touch%index)
      end if
      if (o%restitution(touch%index) > 0) return
      lowest = departure(o, touch%index)
      if (lowest >= gap) return
      gap = lowest
      touch = condition_type(rest_vanishes, touch%index, o%side(touch%index))
   end subroutine least_gap

   !> The gap at the stationary point near a given share of the flight.
   pure subroutine polish_touch(o, touch, gap)
      type(orbit_type), intent(in) :: o
      type(condition_type), intent(inout) :: touch
      real(wp), intent(out) :: gap
      type(flight_type) :: flight
      real(wp) :: d(0:5), t, step
      integer :: i

      flight = flight_at(o, touch%index)
      t = touch%share*flight%duration
      do i = 1, 6
         d = derivatives(flight, t)
         if (abs(d(2)) <= tiny(1.0_wp)) exit
         step = (flight%z_dot - d(1))/d(2)
         t = t + max(-0.05_wp, min(0.05_wp, step))
         if (abs(step) < 1.0e-9_wp) exit
      end do
      d = derivatives(flight, t)
      touch%share = t/flight%duration
      gap = 0.5_wp - touch%side*(flight_position(flight, t) - d(0))
   end subroutine polish_touch

   pure function flight_at(o, i) result(flight)
      type(orbit_type), intent(in) :: o
      integer, intent(in) :: i
      type(flight_type) :: flight

      flight = new_flight(o%xi, o%r, o%amplitude, o%theta(i), o%u(i), o%after(i), o%z(i), &
         o%speed(i), o%time(i))
   end function flight_at

end module vi_conditions
