!> Families of motions that are a sequence of impacts: two unknowns for each, a number and its load
!! phase. A motion that is its own image half a period later is described by its first half.
module vi_impact_family
   use vi_family, only: impacts_image => image_of, repetition_type, whole_unknowns
   use vi_kinds, only: two_pi, wp
   use vi_motion_family, only: condition_type, flip, fold, grazing, motion_family_type, &
      neimark_sacker, repetition, zero_approach
   use vi_orbit, only: family_type, span_of
   implicit none (type, external)
   private

   public :: list_conditions

   !> The unknowns are those numbers, the phases, and others that a family may have.
   type, abstract, extends(motion_family_type), public :: impact_family_type
      type(family_type) :: impacts
      !> Phase by which an impact may be earlier than the one before it: impacts on two gaps may
      !! change their order, which is located like a touch.
      real(wp) :: slack = 0
   contains
      procedure :: wrap_phases, condition_count, whole_of, part_of, in_order, halve, image_of
   end type impact_family_type

contains

   !> Removes whole load cycles that all phases of a difference have in common.
   pure subroutine wrap_phases(family, offset)
      !> The family.
      class(impact_family_type), intent(in) :: family
      !> In and out: a difference of unknowns, or of points, which begin with them.
      real(wp), intent(inout) :: offset(:)
      integer :: n

      n = size(family%impacts%sides)
      offset(n + 1:2*n) = offset(n + 1:2*n) - two_pi*nint(offset(n + 1)/two_pi)
   end subroutine wrap_phases

   !> Number of conditions.
   pure integer function condition_count(family)
      !> The family and its repetitions.
      class(impact_family_type), intent(in) :: family

      condition_count = 3 + 2*size(family%impacts%sides) + size(family%repetitions)
   end function condition_count

   !> The conditions, without the details of a touch: fold, flip, Neimark-Sacker, the approach of
   !! each impact, the gap of each flight, the repetitions.
   pure subroutine list_conditions(family, found)
      !> The family and its repetitions.
      class(impact_family_type), intent(in) :: family
      !> Out: the first ones are set.
      type(condition_type), intent(inout) :: found(:)
      integer :: j, n

      n = size(family%impacts%sides)
      found(:3) = [condition_type(fold), condition_type(flip), condition_type(neimark_sacker)]
      do j = 1, n
         found(3 + j) = condition_type(zero_approach, j)
         found(3 + n + j) = condition_type(grazing, j)
      end do
      do j = 1, size(family%repetitions)
         found(3 + 2*n + j) = condition_type(repetition, j, bound=family%apart)
      end do
   end subroutine list_conditions

   !> x_i and theta_i of all impacts of a period.
   pure function whole_of(family, unknowns) result(whole)
      !> The family.
      class(impact_family_type), intent(in) :: family
      !> Its unknowns.
      real(wp), intent(in) :: unknowns(:)
      real(wp), allocatable :: whole(:)

      allocate (whole, source=whole_unknowns(family%impacts, unknowns))
   end function whole_of

   !> The unknowns of the family from x_i and theta_i of all impacts.
   pure function part_of(family, c, whole) result(unknowns)
      !> The family.
      class(impact_family_type), intent(in) :: family
      !> The parameters.
      real(wp), intent(in) :: c(:)
      !> (2N)
      real(wp), intent(in) :: whole(:)
      real(wp), allocatable :: unknowns(:)
      integer :: n, total

      n = size(family%impacts%sides)
      total = size(whole)/2
      associate (not_used => c)
         unknowns = [whole(:n), whole(total + 1:total + n)]
      end associate
   end function part_of

   !> Whether each impact is later than the one before it.
   pure logical function in_order(family, unknowns)
      !> The family.
      class(impact_family_type), intent(in) :: family
      !> Its unknowns.
      real(wp), intent(in) :: unknowns(:)
      integer :: n

      associate (impacts => family%impacts, slack => family%slack)
         n = size(impacts%sides)
         in_order = all(unknowns(n + 2:2*n) > unknowns(n + 1:2*n - 1) - slack) .and. &
            unknowns(2*n) - unknowns(n + 1) < span_of(impacts) + slack
      end associate
   end function in_order

   !> Turns a family into that of the motions that repeat themselves after half the impacts.
   pure subroutine halve(family, way)
      !> In and out: the family.
      class(impact_family_type), intent(inout) :: family
      !> The way in which they do.
      type(repetition_type), intent(in) :: way

      associate (impacts => family%impacts)
         impacts%sides = impacts%sides(:way%shift)
         impacts%mirror = way%sign < 0
         if (.not. impacts%mirror) impacts%cycles = impacts%cycles/2
         family%symmetric = impacts%mirror
      end associate
      deallocate (family%repetitions)
      allocate (family%repetitions(0))
   end subroutine halve

   !> The unknowns of the image of a motion under a repetition.
   pure function image_of(family, way, unknowns) result(image)
      !> The family.
      class(impact_family_type), intent(in) :: family
      !> The way of repeating itself.
      type(repetition_type), intent(in) :: way
      !> Its unknowns.
      real(wp), intent(in) :: unknowns(:)
      real(wp) :: image(size(unknowns))

      image = impacts_image(family%impacts, way, unknowns)
   end function image_of

end module vi_impact_family
