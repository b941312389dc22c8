!> What the tracer of branches and zones knows of a family of periodic motions: its unknowns, its
!! equations, and the conditions that can bound it.
!!
!! A point of a curve or surface of motions is the unknowns of a motion, then the active parameters
!! in units of their scale. Bounds on parameters are no matter of the family: vi_conditions adds
!! them.
module vi_motion_family
   use vi_family, only: repetition_type
   use vi_kinds, only: wp
   use vi_linear, only: most
   use vi_orbit, only: by_clearance, by_left, by_right, n_parameters
   use vi_releases, only: release_type
   use vi_spectrum, only: spectrum_type
   implicit none (type, external)
   private

   public :: is_exchange, is_inside, parameters_at, repeats, set_differences, to_point

   !> Kinds of conditions; `flip` of a symmetric family is the pitchfork. Those of stability have
   !! the index 0, or `together` and `alike` for disturbances after which impacts at one instant
   !! occur one by one: `together` where a symmetry exchanges their gaps.
   integer, parameter, public :: fold = 1, flip = 2, neimark_sacker = 3, zero_approach = 4, &
      grazing = 5, repetition = 6, edge = 7, rest_vanishes = 8

   !> Not a condition: the straight piece between two loose ends of a boundary that were joined.
   integer, parameter, public :: joint = 9

   !> Grazing of a motion with rest where the contact force touches zero before the release.
   integer, parameter, public :: rest_splits = 10

   !> With friction and stops: friction that changes its sense begins to stick, or time between two
   !! events falls to zero, of which the first may begin a stick or a contact that the other ends,
   !! or end a contact with the stop that the other touches.
   integer, parameter, public :: stick_begins = 11, stick_vanishes = 12, contact_vanishes = 13, &
      events_meet = 14, flight_vanishes = 16

   !> With friction: the speed or force that brings a halt or a slip about only touches its limit.
   integer, parameter, public :: event_vanishes = 15

   integer, parameter, public :: together = 1, alike = 2

   !> A residual that makes Newton's method fail: there is no motion, or not of this family.
   real(wp), parameter, public :: at_fault = huge(1.0_wp)

   !> One condition. `index` is the impact, the flight, the repetition or the parameter.
   type, public :: condition_type
      integer :: kind = 0, index = 0
      !> Grazing: the wall and the share of the flight's duration; edge: +1 below, -1 above.
      integer :: side = 0
      real(wp) :: share = 0
      !> Edge: the bound on the parameter; repetition: the distance that counts as zero.
      real(wp) :: bound = 0
   end type condition_type

   !> How the parameters follow from the last coordinates of a point.
   type, public :: coordinates_type
      !> All parameters; those that are active are given by the point.
      real(wp) :: c(n_parameters) = 0
      !> Whether R2 is always R1.
      logical :: tied = .false.
      !> Which parameters are active, their values where the coordinate is 0, and its unit.
      integer, allocatable :: active(:)
      real(wp), allocatable :: origin(:), scale(:)
   end type coordinates_type

   !> The motions that a search from guesses has found at a point, for all families of a pattern:
   !! x_i/D and theta_i of all impacts (2N, m); not allocated before the search.
   type, public :: searched_type
      real(wp), allocatable :: motions(:, :)
   end type searched_type

   !> A family of motions. To follow another kind of motions, extend this type.
   type, abstract, public :: motion_family_type
      !> Ways in which motions can repeat themselves, where the family ends; and images of every
      !! motion, which are the same motion or its mirror image.
      type(repetition_type), allocatable :: repetitions(:), images(:)
      !> Whether the motions are their own images half a period later.
      logical :: symmetric = .false.
      !> Distance in (u, theta) at which a motion counts as one that repeats itself. The parameters
      !! there differ from those of the bifurcation by the order of its square. Much nearer,
      !! rounding spoils the equations too much to find the corner of a fold that begins there.
      real(wp) :: apart = 3.0e-3_wp
      !> Whether a Neimark-Sacker point counts if another multiplier is already outside the unit
      !! circle: it does on a branch; for a zone only the boundary matters.
      logical :: every_crossing = .false.
      !> Whether motions can end where no condition is zero, because the next one has other symbols.
      !! Near there the equations are not smooth, and Newton's method does not converge
      !! quadratically.
      logical :: jumps = .false.
      !> Whether motions are found by simulation, not from guesses.
      logical :: simulated = .false.
   contains
      ! the unknowns and equations of a motion
      procedure(count_in), deferred :: unknown_count
      procedure(wrap_phases_in), deferred :: wrap_phases
      procedure(set_equations_in), deferred :: set_equations
      ! the conditions that can bound a family, without the bounds on parameters
      procedure(count_in), deferred :: condition_count
      procedure(set_conditions_in), deferred :: set_conditions
      procedure(condition_value_in), deferred :: condition_value
      ! motions as others give and take them
      procedure(whole_of_in), deferred :: whole_of
      procedure(part_of_in), deferred :: part_of
      procedure :: from_vertex, motions_at
      ! what not every family needs: the order of impacts, jumps, and motions that repeat themselves
      procedure :: in_order, has_other_symbols, halve, image_of, image_of_side
   end type motion_family_type

   abstract interface
      !> A number of unknowns or conditions.
      pure integer function count_in(family)
         import :: motion_family_type
         implicit none (type, external)
         !> The family.
         class(motion_family_type), intent(in) :: family
      end function count_in

      !> Removes whole load cycles that all phases of a difference have in common.
      pure subroutine wrap_phases_in(family, offset)
         import :: motion_family_type, wp
         implicit none (type, external)
         !> The family.
         class(motion_family_type), intent(in) :: family
         !> In and out: a difference of unknowns, or of points, which begin with them.
         real(wp), intent(inout) :: offset(:)
      end subroutine wrap_phases_in

      !> Residuals of the motion and of conditions, each with its gradient.
      pure subroutine set_equations_in(family, coordinates, conditions, point, b, a)
         import :: condition_type, coordinates_type, most, motion_family_type, wp
         implicit none (type, external)
         !> The family.
         class(motion_family_type), intent(in) :: family
         !> The parameters.
         type(coordinates_type), intent(in) :: coordinates
         !> Conditions that are to be zero; the columns of bounds on parameters may be left as they
         !! are.
         type(condition_type), intent(in) :: conditions(:)
         !> A guess.
         real(wp), intent(in) :: point(:)
         !> Out: b(1, j): residual j, or `at_fault` where there is no motion; a(:, j): its gradient
         !! with respect to the coordinates.
         real(wp), intent(inout) :: b(2, most), a(most, most)
      end subroutine set_equations_in

      !> The values of all conditions.
      pure subroutine set_conditions_in(family, unknowns, c, values, found, spectrum)
         import :: condition_type, motion_family_type, spectrum_type, wp
         implicit none (type, external)
         !> The family.
         class(motion_family_type), intent(in) :: family
         !> Unknowns of the motion, and the parameters.
         real(wp), intent(in) :: unknowns(:), c(:)
         !> (m) Value of each condition, positive where it is met; -1 where there is no motion.
         real(wp), intent(out) :: values(:)
         !> (m) The conditions: fold, flip, Neimark-Sacker first; grazing with its wall and place.
         type(condition_type), intent(out) :: found(:)
         !> Sums of the multipliers; of motions that may jump, nothing.
         type(spectrum_type), intent(out) :: spectrum
      end subroutine set_conditions_in

      !> The value of one condition; for grazing, at the stationary point given in it.
      pure real(wp) function condition_value_in(family, unknowns, c, condition) result(value)
         import :: condition_type, motion_family_type, wp
         implicit none (type, external)
         !> The family.
         class(motion_family_type), intent(in) :: family
         !> Unknowns of the motion, and the parameters.
         real(wp), intent(in) :: unknowns(:), c(:)
         !> The condition, not a bound on a parameter.
         type(condition_type), intent(in) :: condition
      end function condition_value_in

      !> What a table shows of a motion: a number and the load phase of each impact.
      pure function whole_of_in(family, unknowns) result(whole)
         import :: motion_family_type, wp
         implicit none (type, external)
         !> The family.
         class(motion_family_type), intent(in) :: family
         !> Its unknowns.
         real(wp), intent(in) :: unknowns(:)
         !> (2N) All numbers (x/D, the approach speed, or v/D at a release), then all phases.
         real(wp), allocatable :: whole(:)
      end function whole_of_in

      !> The unknowns of a family from those of the whole pattern.
      pure function part_of_in(family, c, whole) result(unknowns)
         import :: motion_family_type, wp
         implicit none (type, external)
         !> The family.
         class(motion_family_type), intent(in) :: family
         !> The parameters.
         real(wp), intent(in) :: c(:)
         !> x_i/D, theta_i of all impacts (2N); with rest, the phase and v/D of a release.
         real(wp), intent(in) :: whole(:)
         real(wp), allocatable :: unknowns(:)
      end function part_of_in
   end interface

contains

   !> The unknowns from what a table shows of a motion.
   pure function from_vertex(family, c, x, theta) result(unknowns)
      !> The family.
      class(motion_family_type), intent(in) :: family
      !> The parameters.
      real(wp), intent(in) :: c(:)
      !> (N) The numbers and phases of `whole_of`.
      real(wp), intent(in) :: x(:), theta(:)
      real(wp), allocatable :: unknowns(:)

      allocate (unknowns, source=family%part_of(c, [x, theta]))
   end function from_vertex

   !> Unknowns, or guesses of them, of motions at a point.
   subroutine motions_at(family, c, guesses, skip, found, releases, progress, longer, searched)
      !> The family; no way is known to search for its motions.
      class(motion_family_type), intent(in) :: family
      !> The parameters.
      real(wp), intent(in) :: c(:)
      !> Number of guesses, or of simulations, and number of guesses of the sequence to leave out;
      !! neighbouring points take different ones.
      integer, intent(in) :: guesses, skip
      !> (unknowns, m) The motions.
      real(wp), allocatable, intent(out) :: found(:, :)
      !> The last releases of simulations at this point, if they have been made already.
      type(release_type), intent(in), optional :: releases(:)
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      !> Factor of the load cycles simulated; 1 by default.
      integer, intent(in), optional :: longer
      !> In: the motions of the pattern, if another of its families has been searched at this point
      !! by the same guesses. Out: them.
      type(searched_type), intent(inout), optional :: searched

      associate (not_used => [size(c), guesses, skip], nor => [present(releases), &
         present(progress), present(longer), present(searched)])
         allocate (found(family%unknown_count(), 0))
      end associate
   end subroutine motions_at

   !> Whether the impacts are in the order of time; the equations can have other roots as well.
   pure logical function in_order(family, unknowns)
      !> The family; none has such roots.
      class(motion_family_type), intent(in) :: family
      !> A root of its equations.
      real(wp), intent(in) :: unknowns(:)

      associate (not_used => family%apart, nor => unknowns)
         in_order = .true.
      end associate
   end function in_order

   !> Whether the period at a place has other symbols than the family.
   pure logical function has_other_symbols(family, values)
      !> The family; its motions do not jump.
      class(motion_family_type), intent(in) :: family
      !> The values of all conditions there.
      real(wp), intent(in) :: values(:)

      associate (not_used => family%apart, nor => values)
         has_other_symbols = .false.
      end associate
   end function has_other_symbols

   !> Turns a family into that of the motions that repeat themselves after half the impacts.
   pure subroutine halve(family, way)
      !> In and out: the family; it has no such motions.
      class(motion_family_type), intent(inout) :: family
      !> The way.
      type(repetition_type), intent(in) :: way

      associate (not_used => family%apart, nor => way)
      end associate
   end subroutine halve

   !> The unknowns of the image of a motion under a repetition: it begins at a later impact, and is
   !! mirrored if the repetition is.
   pure function image_of(family, way, unknowns) result(image)
      !> The family; it has no repetitions.
      class(motion_family_type), intent(in) :: family
      !> The way of repeating itself.
      type(repetition_type), intent(in) :: way
      !> The motion.
      real(wp), intent(in) :: unknowns(:)
      real(wp) :: image(size(unknowns))

      associate (not_used => family%apart, nor => way)
         image = unknowns
      end associate
   end function image_of

   !> The wall that the symmetry exchanges with a given one.
   pure integer function image_of_side(family, side) result(image)
      !> The family; its walls are opposite ones.
      class(motion_family_type), intent(in) :: family
      !> The wall.
      integer, intent(in) :: side

      associate (not_used => family%apart)
         image = -side
      end associate
   end function image_of_side

   !> Whether a motion repeats itself within its period, up to some distance.
   pure logical function repeats(family, unknowns, distance)
      !> The family.
      class(motion_family_type), intent(in) :: family
      !> Unknowns of the motion, and the distance in (u, theta).
      real(wp), intent(in) :: unknowns(:), distance
      integer :: i

      repeats = any([(norm2(family%image_of(family%repetitions(i), unknowns) - unknowns) < &
         distance, i=1, size(family%repetitions))])
   end function repeats

   !> Whether two events come at one instant where a condition is zero, beyond which their order is
   !! another.
   elemental logical function is_exchange(condition)
      !> The condition.
      type(condition_type), intent(in) :: condition

      ! within an accumulation the share counts flights as well
      is_exchange = condition%kind == events_meet .or. ((condition%kind == grazing .or. &
         condition%kind == rest_splits) .and. .not. abs(condition%share - 1) > 0)
   end function is_exchange

   !> Whether all conditions are met; of the edges only those of one parameter count.
   pure logical function is_inside(conditions, values, parameter) result(inside)
      !> (m) The conditions.
      type(condition_type), intent(in) :: conditions(:)
      !> (m) Their values, positive where they are met.
      real(wp), intent(in) :: values(:)
      !> Place of the parameter whose edges count.
      integer, intent(in) :: parameter

      inside = all(values > 0 .or. (conditions%kind == edge .and. conditions%index /= parameter))
   end function is_inside

   !> The parameters at a point.
   pure function parameters_at(coordinates, at) result(c)
      !> The parameters.
      type(coordinates_type), intent(in) :: coordinates
      !> The last coordinates of the point.
      real(wp), intent(in) :: at(:)
      real(wp) :: c(n_parameters)
      integer :: j

      c = coordinates%c
      do j = 1, size(coordinates%active)
         c(coordinates%active(j)) = coordinates%origin(j) + coordinates%scale(j)*at(j)
      end do
      if (coordinates%tied) c(by_left) = c(by_right)
   end function parameters_at

   !> Converts a gradient with respect to all unknowns, r and log(D) to one with respect to the
   !! coordinates of a point.
   pure subroutine to_point(coordinates, n, slope)
      !> The parameters.
      type(coordinates_type), intent(in) :: coordinates
      !> Number of unknowns.
      integer, intent(in) :: n
      !> In: with respect to the unknowns, r, log(D). Out: with respect to the coordinates; 0 for
      !! active parameters other than r and log(D).
      real(wp), intent(inout) :: slope(most)
      real(wp) :: by(2)
      integer :: k

      by = slope(n + 1:n + 2)
      do k = 1, size(coordinates%active)
         slope(n + k) = 0
         if (coordinates%active(k) <= by_clearance) slope(n + k) = coordinates%scale(k) &
            *by(coordinates%active(k))
      end do
   end subroutine to_point

   !> The derivatives of a condition with respect to all coordinates from a given one on, by central
   !! differences.
   pure subroutine set_differences(family, coordinates, condition, point, first, slope)
      !> The family.
      class(motion_family_type), intent(in) :: family
      !> The parameters.
      type(coordinates_type), intent(in) :: coordinates
      !> The condition, not a bound on a parameter.
      type(condition_type), intent(in) :: condition
      !> A point.
      real(wp), intent(in) :: point(:)
      !> Number of the first coordinate.
      integer, intent(in) :: first
      !> (as `point`) In and out: elements from `first` on are set.
      real(wp), intent(inout) :: slope(:)
      real(wp), parameter :: h = 1.0e-6_wp
      real(wp) :: moved(size(point))
      integer :: j, n

      n = size(point) - size(coordinates%active)
      do j = first, size(point)
         moved = point
         moved(j) = point(j) + h
         slope(j) = family%condition_value(moved(:n), parameters_at(coordinates, moved(n + 1:)), &
            condition)
         moved(j) = point(j) - h
         slope(j) = (slope(j) - family%condition_value(moved(:n), parameters_at(coordinates, &
            moved(n + 1:)), condition))/(2*h)
      end do
   end subroutine set_differences

end module vi_motion_family
