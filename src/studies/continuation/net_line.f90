!> Lines over the surface of motions in a window, along which one parameter is constant.
module vi_net_line
   use vi_curve, only: correct, curve_type
   use vi_kinds, only: wp
   use vi_motion_family, only: condition_type, edge, flip, fold, grazing, is_exchange, &
      neimark_sacker, repetition, rest_splits, rest_vanishes, zero_approach
   use vi_spectrum, only: pair_product
   use vi_steps, only: place_type
   implicit none (type, external)
   private

   public :: leaves, line_of, may_pass, pass

   !> Start of a line: a motion, its place in the window, and the lattice lines it lies on.
   type, public :: start_type
      real(wp), allocatable :: unknowns(:)
      real(wp) :: at(2) = 0
      !> Their numbers; 0 for none.
      integer :: lattice(2) = 0
   end type start_type

   !> A motion that would be this far beyond a wall (over d) is not followed any farther.
   real(wp), parameter :: depth = 1.0_wp

contains

   !> The curve of motions along a line through a place, parallel to the lattice lines.
   subroutine line_of(surface, begin, direction, line)
      !> The surface of motions over the window.
      type(curve_type), intent(in) :: surface
      !> Start of the line.
      type(start_type), intent(in) :: begin
      !> Number of the parameter that changes along the line: 1 for r, 2 for log D.
      integer, intent(in) :: direction
      !> The curve.
      type(curve_type), intent(out) :: line
      integer :: other

      other = 3 - direction
      line = surface
      line%active = surface%active([direction])
      line%origin = surface%origin([direction])
      line%scale = surface%scale([direction])
      line%c(surface%active(other)) = surface%origin(other) + surface%scale(other)*begin%at(other)
   end subroutine line_of

   !> Whether a line has left the window, or its motions are far from physical.
   pure logical function leaves(place, line)
      !> The place reached.
      type(place_type), intent(in) :: place
      !> The line; motions with rest are followed only as long as every rest lasts.
      type(curve_type), intent(in) :: line

      associate (v => place%values, kind => place%conditions%kind)
         leaves = any(v < 0 .and. (kind == zero_approach .or. kind == repetition)) .or. &
            any(v < 0 .and. kind == edge .and. place%conditions%index == line%active(1)) .or. &
            any(v < -depth .and. kind == grazing) .or. &
            (line%family%jumps .and. any(v < 0 .and. (kind == rest_vanishes .or. &
            kind == rest_splits .or. is_exchange(place%conditions))))
      end associate
   end function leaves

   !> Whether a step may pass through a zone: the conditions violated at its start are met at its
   !! end, where other conditions are violated.
   pure logical function may_pass(line, now, next)
      !> The line.
      type(curve_type), intent(in) :: line
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      logical, dimension(size(now%values)) :: at_start, at_end

      at_start = violated(line, now)
      at_end = violated(line, next)
      may_pass = any(at_start) .and. any(at_end) .and. .not. any(at_start .and. at_end)
   end function may_pass

   !> Which conditions are violated.
   pure function violated(line, place)
      !> The line.
      type(curve_type), intent(in) :: line
      !> The place.
      type(place_type), intent(in) :: place
      logical :: violated(size(place%values))

      violated = place%values < 0
      if (line%family%jumps) return
      ! where a fold or a flip has been passed, the condition of Neimark-Sacker is also called
      ! violated if more multipliers may be outside the unit circle: near a point where both
      ! are zero that is so next to a zone
      if (any(violated([fold, flip]))) violated(neimark_sacker) = violated(neimark_sacker) .and. &
         pair_product(place%spectrum) < 0
   end function violated

   !> The point at which a step passes a level of the line's parameter.
   pure subroutine pass(line, level, now, next, point, passes)
      !> The line.
      type(curve_type), intent(in) :: line
      !> The level, as coordinate of the line.
      real(wp), intent(in) :: level
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      !> The point, if the level is passed.
      real(wp), intent(out) :: point(:)
      !> Whether the level is passed.
      logical, intent(out) :: passes
      type(condition_type) :: at
      real(wp) :: a, b
      integer :: iterations

      a = now%point(size(point))
      b = next%point(size(point))
      point = now%point
      passes = (level - a)*(level - b) < 0 .and. .not. abs(level - a) < 1.0e-9_wp
      if (.not. passes) return
      point = now%point + (level - a)/(b - a)*(next%point - now%point)
      at = condition_type(edge, line%active(1), 1, bound=line%origin(1) + line%scale(1)*level)
      call correct(line, [at], point, iterations)
      passes = iterations > 0
   end subroutine pass

end module vi_net_line
