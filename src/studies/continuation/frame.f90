!> What is fixed along a curve or surface of motions, and the conditions that can bound a zone on
!! it.
module vi_frame
   use vi_family, only: repetition_type
   use vi_kinds, only: wp
   use vi_orbit, only: family_type
   use vi_rest_family, only: rest_family_type, rest_unknowns
   use vi_structure_family, only: free_unknowns, structure_family_type
   implicit none (type, external)
   private

   public :: condition_at, condition_count, is_inside, unknown_count, wrap_phases

   !> Kinds of conditions; `flip` of a symmetric family is the pitchfork. Those of stability have
   !! the index 0, or `together` and `alike` for disturbances after which impacts at one instant
   !! occur one by one: `together` where a symmetry exchanges their gaps.
   integer, parameter, public :: fold = 1, flip = 2, neimark_sacker = 3, zero_approach = 4, &
      grazing = 5, repetition = 6, edge = 7, rest_vanishes = 8

   !> Not a condition: the straight piece between two loose ends of a boundary that were joined.
   integer, parameter, public :: joint = 9

   !> Grazing of a motion with rest where the contact force touches zero before the release.
   integer, parameter, public :: rest_splits = 10

   integer, parameter, public :: together = 1, alike = 2

   !> One condition. `index` is the impact, the flight, the repetition or the parameter.
   type, public :: condition_type
      integer :: kind = 0, index = 0
      !> Grazing: the wall and the share of the flight's duration; edge: +1 below, -1 above.
      integer :: side = 0
      real(wp) :: share = 0
      !> Edge: the bound on the parameter; repetition: the distance that counts as zero.
      real(wp) :: bound = 0
   end type condition_type

   !> What is fixed along a curve or surface of motions.
   type, public :: frame_type
      type(family_type) :: family
      type(repetition_type), allocatable :: repetitions(:)
      !> Images of every motion, which are the same motion or its mirror image; not set along a
      !! branch.
      type(repetition_type), allocatable :: images(:)
      !> Bounds on parameters.
      type(condition_type), allocatable :: edges(:)
      !> Distance in (u, theta) at which a motion counts as one that repeats itself. The parameters
      !! there differ from those of the bifurcation by the order of its square. Much nearer,
      !! rounding spoils the equations too much to find the corner of a fold that begins there.
      real(wp) :: apart = 3.0e-3_wp
      !> Whether a Neimark-Sacker point counts if another multiplier is already outside the unit
      !! circle: it does on a branch; for a zone only the boundary matters.
      logical :: every_crossing = .false.
      !> Motions with rest: another family, with its own unknowns.
      logical :: resting = .false.
      type(rest_family_type) :: rest
      !> Motions of a structure.
      type(structure_family_type), allocatable :: structure
   end type frame_type

contains

   !> Number of unknowns of a motion: (u_i, theta_i), or those of vi_rest_family or
   !! vi_structure_family.
   pure integer function unknown_count(frame)
      !> The family, of either kind.
      type(frame_type), intent(in) :: frame

      if (frame%resting) then
         unknown_count = rest_unknowns(frame%rest)
      else
         unknown_count = 2*size(frame%family%sides)
         if (allocated(frame%structure)) unknown_count = unknown_count + free_unknowns( &
            frame%structure, frame%family)
      end if
   end function unknown_count

   !> Removes whole load cycles that all phases of a difference have in common.
   pure subroutine wrap_phases(frame, offset)
      !> The family, of either kind.
      type(frame_type), intent(in) :: frame
      !> In and out: a difference of unknowns, or of points, which begin with them.
      real(wp), intent(inout) :: offset(:)
      real(wp), parameter :: two_pi = 2*acos(-1.0_wp)
      integer :: n

      if (frame%resting) then
         n = size(frame%rest%symbols)
         offset(3:2 + n) = offset(3:2 + n) - two_pi*nint(offset(1)/two_pi)
         offset(1) = offset(1) - two_pi*nint(offset(1)/two_pi)
      else
         n = size(frame%family%sides)
         offset(n + 1:2*n) = offset(n + 1:2*n) - two_pi*nint(offset(n + 1)/two_pi)
      end if
   end subroutine wrap_phases

   !> Number of conditions.
   pure integer function condition_count(frame)
      !> The family, its repetitions, and its edges.
      type(frame_type), intent(in) :: frame

      if (frame%resting) then
         condition_count = 3 + 3*size(frame%rest%symbols) + size(frame%edges)
      else
         condition_count = 3 + 2*size(frame%family%sides) + size(frame%repetitions) &
            + merge(3, 0, has_together(frame)) + size(frame%edges)
      end if
   end function condition_count

   !> Whether several gaps of a structure close at one instant along the whole family.
   pure logical function has_together(frame)
      !> The family, of either kind.
      type(frame_type), intent(in) :: frame

      has_together = allocated(frame%structure)
      if (has_together) has_together = allocated(frame%structure%impact_of)
   end function has_together

   !> Condition number j of a frame, without the details that `all_conditions` finds.
   pure function condition_at(frame, j) result(condition)
      !> The family, its repetitions, and its edges.
      type(frame_type), intent(in) :: frame
      !> 1 to 3: fold, flip, Neimark-Sacker; then zero approach, grazing, and repetition or
      !! vanishing rest, by impact, flight, symbol or repetition; then those of stability for
      !! impacts at one instant, if there are any; then the edges.
      integer, intent(in) :: j
      type(condition_type) :: condition
      integer :: n, m

      if (frame%resting) then
         n = size(frame%rest%symbols)
         m = n
      else
         n = size(frame%family%sides)
         m = size(frame%repetitions)
      end if
      if (j <= 3) then
         condition = condition_type(j, 0)
      else if (j <= 3 + n) then
         condition = condition_type(zero_approach, j - 3)
      else if (j <= 3 + 2*n) then
         condition = condition_type(grazing, j - 3 - n)
      else if (j <= 3 + 2*n + m) then
         condition = condition_type(merge(rest_vanishes, repetition, frame%resting), j - 3 - 2*n, &
            bound=frame%apart)
      else if (has_together(frame) .and. j <= 6 + 2*n + m) then
         condition = condition_type(j - 3 - 2*n - m, merge(together, alike, &
            frame%structure%exchanged))
      else
         condition = frame%edges(j - 3 - 2*n - m - merge(3, 0, has_together(frame)))
      end if
   end function condition_at

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

end module vi_frame
