!> Families of periodic motions: one pattern, or the mirror-symmetric motions of one pattern.
module vi_family
   use vi_kinds, only: pi, wp
   use vi_orbit, only: family_type, most_impacts, span_of
   use vi_pattern, only: pattern_type
   implicit none (type, external)
   private

   public :: can_be_symmetric, new_family, image_of, images_of, repetition_distance, &
      add_distance_slope, whole_unknowns

   !> A way in which a motion can repeat itself within its period.
   type, public :: repetition_type
      !> Number of impacts after which it repeats, the sign of positions there, and the load phase
      !! that has passed.
      integer :: shift = 0
      real(wp) :: sign = 1, phase = 0
      !> Of a structure: how many of the further displacements keep their sign in any case.
      integer :: even = 0
      !> Whether it repeats after half the impacts: such motions are reached with a multiplier -1 of
      !! the shorter period.
      logical :: halves = .false.
   end type repetition_type

contains

   !> The family of a pattern, and the ways in which its members could repeat themselves.
   !!
   !! A motion that repeats itself belongs not to this family but to one with a shorter pattern, or
   !! to one with the mirror symmetry: the motions of this pattern branch off from those.
   pure subroutine new_family(pattern, symmetric, equal_walls, family, repetitions, possible)
      !> Sides of the impacts, and the load cycles k of the whole period.
      type(pattern_type), intent(in) :: pattern
      !> Only motions that are their own mirror image half a period later.
      logical, intent(in) :: symmetric
      !> R1 = R2: there are mirror images.
      logical, intent(in) :: equal_walls
      !> What the members have in common; undefined where `possible` is false.
      type(family_type), intent(out) :: family
      !> Ways in which a member could repeat itself within its period; empty if there are none.
      type(repetition_type), allocatable, intent(out) :: repetitions(:)
      !> False if this pattern has no such motions.
      logical, intent(out) :: possible
      type(repetition_type) :: found(most_impacts)
      integer :: n, m, half, count
      logical :: mirrored

      n = size(pattern%sides)
      half = n/2
      mirrored = equal_walls .and. mirrors_itself(pattern)
      possible = n <= most_impacts .and. (mirrored .or. .not. symmetric)
      count = 0
      allocate (repetitions(0))
      if (.not. possible) return
      family%cycles = pattern%cycles
      family%mirror = symmetric
      if (symmetric) then
         family%sides = pattern%sides(:half)
      else
         family%sides = pattern%sides
         if (mirrored) then
            count = 1
            found(1) = repetition_type(half, -1.0_wp, pi*pattern%cycles, halves=.true.)
         end if
      end if
      do m = 2, n
         if (mod(n, m) /= 0 .or. mod(pattern%cycles, m) /= 0) cycle
         if (.not. is_prime(m)) cycle
         if (any(cshift(pattern%sides, n/m) /= pattern%sides)) cycle
         count = count + 1
         found(count) = repetition_type(n/m, 1.0_wp, 2*pi*pattern%cycles/m, halves=m == 2)
      end do
      deallocate (repetitions)
      allocate (repetitions(count), source=found(:count))
   end subroutine new_family

   !> Whether a pattern has motions that are their own mirror image half a period later.
   pure logical function can_be_symmetric(pattern, walls)
      !> Sides of the impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> Coefficients of restitution R1 (right), R2 (left).
      real(wp), intent(in) :: walls(2)

      can_be_symmetric = abs(walls(1) - walls(2)) <= 0 .and. all(abs(pattern%sides) == 1)
      if (can_be_symmetric) can_be_symmetric = mirrors_itself(pattern)
   end function can_be_symmetric

   !> Whether the impacts half a period later are on the opposite walls.
   pure logical function mirrors_itself(pattern)
      !> Sides of the impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      integer :: n

      n = size(pattern%sides)
      mirrors_itself = mod(n, 2) == 0 .and. mod(pattern%cycles, 2) == 1
      if (mirrors_itself) mirrors_itself = all(cshift(pattern%sides, n/2) == -pattern%sides)
   end function mirrors_itself

   !> Whether a number is prime.
   pure logical function is_prime(m)
      !> A number >= 2.
      integer, intent(in) :: m
      integer :: i

      is_prime = all([(mod(m, i) /= 0, i=2, m - 1)])
   end function is_prime

   !> The distance in (u, theta) of an orbit from its image under a repetition.
   pure real(wp) function repetition_distance(family, repetition, unknowns) result(distance)
      !> The family of the orbit.
      type(family_type), intent(in) :: family
      !> The way of repeating itself.
      type(repetition_type), intent(in) :: repetition
      !> (2n) u_i = x_i/d and theta_i = alpha_i + tau of the orbit.
      real(wp), intent(in) :: unknowns(:)

      distance = norm2(image_of(family, repetition, unknowns) - unknowns)
   end function repetition_distance

   !> Adds the gradient of that distance, times a weight, to a gradient.
   pure subroutine add_distance_slope(family, repetition, unknowns, weight, slope)
      !> The family of the orbit.
      type(family_type), intent(in) :: family
      !> The way of repeating itself.
      type(repetition_type), intent(in) :: repetition
      !> (2n) u_i and theta_i of the orbit, and the factor of the gradient.
      real(wp), intent(in) :: unknowns(:), weight
      !> (at least 2n) In and out: a gradient with respect to u_i and theta_i, to which the term is
      !! added; unchanged where the distance is 0.
      real(wp), intent(inout) :: slope(:)
      real(wp) :: away(size(unknowns)), length, sign
      integer :: i, j, n, turns

      away = image_of(family, repetition, unknowns) - unknowns
      length = norm2(away)
      if (.not. length > 0) return
      away = weight/length*away
      n = size(family%sides)
      sign = merge(-1.0_wp, 1.0_wp, family%mirror)
      slope(:2*n) = slope(:2*n) - away(:2*n)
      do i = 1, n
         j = i + repetition%shift
         turns = (j - 1)/n
         j = j - turns*n
         slope(j) = slope(j) + repetition%sign*sign**turns*away(i)
         slope(n + j) = slope(n + j) + away(n + i)
      end do
      i = 2*n + repetition%even + 1
      j = size(unknowns)
      slope(i:j) = slope(i:j) + (repetition%sign - 1)*away(i:)
   end subroutine add_distance_slope

   !> The unknowns of the image of a motion under a repetition: it begins at a later impact, and is
   !! mirrored if the repetition is.
   pure function image_of(family, repetition, unknowns) result(image)
      !> The family of the orbit.
      type(family_type), intent(in) :: family
      !> The way of repeating itself.
      type(repetition_type), intent(in) :: repetition
      !> (2n) u_i and theta_i of the orbit; of a structure, further displacements follow.
      real(wp), intent(in) :: unknowns(:)
      real(wp) :: image(size(unknowns))
      real(wp) :: sign, span
      integer :: i, j, n, turns

      n = size(family%sides)
      sign = merge(-1.0_wp, 1.0_wp, family%mirror)
      span = span_of(family)
      do i = 1, n
         j = i + repetition%shift
         turns = (j - 1)/n
         j = j - turns*n
         image(i) = repetition%sign*sign**turns*unknowns(j)
         image(n + i) = unknowns(n + j) + turns*span - repetition%phase
      end do
      image(2*n + 1:) = unknowns(2*n + 1:)
      j = 2*n + repetition%even + 1
      image(j:) = repetition%sign*unknowns(j:)
   end function image_of

   !> The images of a motion in its family: the impacts of the same motion, or of its mirror image,
   !! counted from another one of them, where the walls are again those of the pattern.
   !!
   !! A motion and its images have the same zone. A motion that is one of its own images repeats
   !! itself.
   pure function images_of(family, mirror) result(images)
      !> The family.
      type(family_type), intent(in) :: family
      !> The mirror image, of which `shift` is not used; without a mirror image the sign is 1.
      type(repetition_type), intent(in) :: mirror
      type(repetition_type), allocatable :: images(:)
      type(repetition_type) :: found(2*most_impacts)
      integer :: i, n, shift, sign, count
      integer :: later(2*size(family%sides))

      n = size(family%sides)
      count = 0
      ! the impacts of one more half period, if the family is symmetric, or of one more period
      later = [family%sides, merge(-1, 1, family%mirror)*family%sides]
      do sign = 1, -1, -2
         if (sign < 0 .and. mirror%sign > 0) exit
         do shift = merge(1, 0, sign > 0), n - 1
            if (any([(sign*later(shift + i) /= family%sides(i), i=1, n)])) cycle
            count = count + 1
            found(count) = repetition_type(shift, 1.0_wp, 0.0_wp)
            if (sign < 0) found(count) = repetition_type(shift, -1.0_wp, mirror%phase, mirror%even)
         end do
      end do
      allocate (images(count), source=found(:count))
   end function images_of

   !> The unknowns of all impacts of a family's pattern.
   pure function whole_unknowns(family, unknowns) result(whole)
      !> The family of the orbit.
      type(family_type), intent(in) :: family
      !> (2n) u_i and theta_i; for a symmetric family those of the first half period, and of a
      !! structure further displacements, which are left out.
      real(wp), intent(in) :: unknowns(:)
      real(wp), allocatable :: whole(:)
      integer :: n

      n = size(family%sides)
      if (family%mirror) then
         whole = [unknowns(:n), -unknowns(:n), unknowns(n + 1:2*n), unknowns(n + 1:2*n) &
            + pi*family%cycles]
      else
         whole = unknowns
      end if
   end function whole_unknowns

end module vi_family
