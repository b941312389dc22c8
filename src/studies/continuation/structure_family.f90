!> Families of motions of a structure.
!!
!! With multipliers lambda_i, the numbers of fold, flip and Neimark-Sacker have the signs of the
!! products of all 1 - lambda_i, of all 1 + lambda_i, and of all 1 - lambda_i lambda_j with i < j.
!! Their magnitude is that of the two least factors, which does not underflow for large structures;
!! of two, since two multipliers that meet are not smooth, unlike their symmetric functions.
module vi_structure_family
   use vi_family, only: add_distance_slope, repetition_distance, whole_unknowns
   use vi_impact_family, only: impact_family_type, list_conditions
   use vi_kinds, only: wp
   use vi_linear, only: most
   use vi_motion_family, only: alike, at_fault, condition_type, coordinates_type, edge, flip, &
      fold, grazing, neimark_sacker, parameters_at, repetition, together, zero_approach
   use vi_orbit, only: n_parameters
   use vi_spectrum, only: outside_circle, spectrum_type
   use vi_structure_members, only: flight_duration, free_unknowns, member_equations, &
      member_multipliers, member_type, move_member, set_flights, set_member, &
      structure_members_type, whole_sides
   use vi_structure_slopes, only: equations_by_parameter
   use vi_structure_together, only: multipliers_beside
   use vi_structure_touches, only: least_gap, touch_value
   implicit none (type, external)
   private

   public :: numbers_of

   !> The unknowns are those of vi_structure_members; each parameter is a share of the way between
   !! its bounds.
   type, extends(impact_family_type), public :: structure_family_type
      type(structure_members_type) :: members
   contains
      procedure :: unknown_count, set_equations
      procedure :: condition_count, set_conditions, condition_value, whole_of, image_of_side
   end type structure_family_type

contains

   !> Number of unknowns.
   pure integer function unknown_count(family)
      !> The family.
      class(structure_family_type), intent(in) :: family

      unknown_count = 2*size(family%impacts%sides) + free_unknowns(family%members, family%impacts)
   end function unknown_count

   !> Residuals of the motion and of conditions, each with its gradient.
   pure subroutine set_equations(family, coordinates, conditions, point, b, a)
      !> The family.
      class(structure_family_type), intent(in) :: family
      !> The parameters.
      type(coordinates_type), intent(in) :: coordinates
      !> Conditions that are to be zero.
      type(condition_type), intent(in) :: conditions(:)
      !> A guess.
      real(wp), intent(in) :: point(:)
      !> Out: as in vi_motion_family.
      real(wp), intent(inout) :: b(2, most), a(most, most)
      type(member_type) :: member
      real(wp) :: c(n_parameters), slope(size(point) - size(coordinates%active)), &
         jacobian(size(slope), size(slope))
      integer :: j, k, m
      logical :: good

      m = size(slope)
      b(1, :m + size(conditions)) = at_fault
      a(:size(point), :m + size(conditions)) = 0
      c = parameters_at(coordinates, point(m + 1:))
      associate (s => family%members, shares => c(:size(family%members%path%changes)))
         call set_member(s, family%impacts, point(:m), shares, member)
         if (.not. member%exists) return
         call member_equations(s, family%impacts, member, slope, jacobian)
         b(1, :m) = slope
         a(:m, :m) = jacobian
         do k = 1, size(coordinates%active)
            call equations_by_parameter(s, family%impacts, point(:m), shares, member, &
               coordinates%active(k), slope, good)
            if (.not. good) b(1, :m) = at_fault
            if (.not. good) return
            a(m + k, :m) = coordinates%scale(k)*slope
         end do
      end associate
      do j = 1, size(conditions)
         if (conditions(j)%kind == edge) cycle
         call member_slope(family, coordinates, conditions(j), point, member, b(1, m + j), &
            a(:size(point), m + j))
      end do
   end subroutine set_equations

   !> Number of conditions.
   pure integer function condition_count(family)
      !> The family and its repetitions.
      class(structure_family_type), intent(in) :: family

      condition_count = 3 + 2*size(family%impacts%sides) + size(family%repetitions)
      if (allocated(family%members%impact_of)) condition_count = condition_count + 3
   end function condition_count

   !> The values of all conditions; -1 where there is no such motion. Those of stability for impacts
   !! at one instant are last, if there are any.
   pure subroutine set_conditions(family, unknowns, c, values, found, spectrum)
      !> The family, and its repetitions.
      class(structure_family_type), intent(in) :: family
      !> Unknowns of the motion, and the parameters as shares.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> (m) Value of each condition, positive where it is met.
      real(wp), intent(out) :: values(:)
      !> (m) The conditions; grazing with its wall and the share of the flight.
      type(condition_type), intent(out) :: found(:)
      !> The multipliers.
      type(spectrum_type), intent(out) :: spectrum
      type(member_type) :: member
      real(wp) :: three(3, 0:1)
      integer :: j

      call list_conditions(family, found)
      if (allocated(family%members%impact_of)) found(size(found) - 2:) = [(condition_type(j, &
         merge(together, alike, family%members%exchanged)), j=1, 3)]
      values = -1
      call set_member(family%members, family%impacts, unknowns, c(:size( &
         family%members%path%changes)), member)
      if (.not. member%exists) return
      call set_flights(family%impacts, member)
      call stability_values(family, unknowns, member, three, spectrum)
      if (.not. family%every_crossing .and. all(three > 0)) then
         ! only stable motions are inside
         if (outside_circle(spectrum, 0) > 0) three(neimark_sacker, 0) = -three(neimark_sacker, 0)
      end if
      do j = 1, size(values)
         associate (condition => found(j))
            if (condition%kind == grazing) then
               call least_gap_of(family, member, condition, values(j))
            else if (condition%kind <= neimark_sacker) then
               values(j) = three(condition%kind, min(condition%index, 1))
            else
               values(j) = simple_value(family, unknowns, member, condition)
            end if
         end associate
      end do
   end subroutine set_conditions

   !> The value of one condition; for grazing, at the stationary point given in it.
   pure real(wp) function condition_value(family, unknowns, c, condition) result(value)
      !> The family, and its repetitions.
      class(structure_family_type), intent(in) :: family
      !> Unknowns of the motion, and the parameters as shares.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> The condition.
      type(condition_type), intent(in) :: condition
      type(member_type) :: member

      call set_member(family%members, family%impacts, unknowns, c(:size( &
         family%members%path%changes)), member)
      call value_of_member(family, unknowns, member, condition, value)
   end function condition_value

   !> Value of a condition, and its gradient with respect to the coordinates of a point, by central
   !! differences.
   pure subroutine member_slope(family, coordinates, condition, point, member, value, slope)
      !> The family, and its repetitions.
      class(structure_family_type), intent(in) :: family
      !> The parameters.
      type(coordinates_type), intent(in) :: coordinates
      !> The condition.
      type(condition_type), intent(in) :: condition
      !> A point.
      real(wp), intent(in) :: point(:)
      !> In and out: the member there; its flights are others on return.
      type(member_type), intent(inout) :: member
      !> The value, and the gradient (as `point`).
      real(wp), intent(out) :: value, slope(:)
      real(wp), parameter :: h = 1.0e-6_wp
      type(member_type) :: near
      real(wp) :: moved(size(point) - size(coordinates%active)), both(2), c(n_parameters), &
         shares(size(family%members%path%changes))
      integer :: i, j, m

      m = size(moved)
      c = parameters_at(coordinates, point(m + 1:))
      shares = c(:size(shares))
      slope = 0
      associate (unknowns => point(:m), s => family%members, active => coordinates%active)
         do j = 1, size(active)
            do i = 1, 2
               shares(active(j)) = c(active(j)) + (3 - 2*i)*h
               call set_member(s, family%impacts, unknowns, shares, near)
               call value_of_member(family, unknowns, near, condition, both(i))
            end do
            shares(active(j)) = c(active(j))
            slope(m + j) = coordinates%scale(j)*((both(1) - both(2))/(2*h))
         end do
         call value_of_member(family, unknowns, member, condition, value)
         if (.not. member%exists) return
         if (condition%kind == zero_approach) then
            slope(condition%index) = sign(1, family%impacts%sides(condition%index))
         else if (condition%kind == repetition) then
            call add_distance_slope(family%impacts, family%repetitions(condition%index), unknowns, &
               1.0_wp, slope)
         else
            do j = 1, m
               do i = 1, 2
                  moved = unknowns
                  moved(j) = unknowns(j) + (3 - 2*i)*h
                  call move_member(s, family%impacts, moved, member)
                  call value_of_member(family, moved, member, condition, both(i))
               end do
               slope(j) = (both(1) - both(2))/(2*h)
            end do
            call move_member(s, family%impacts, unknowns, member)
         end if
      end associate
   end subroutine member_slope

   !> The approach speeds and load phases of all impacts of a period.
   pure function whole_of(family, unknowns) result(whole)
      !> The family.
      class(structure_family_type), intent(in) :: family
      !> Its unknowns.
      real(wp), intent(in) :: unknowns(:)
      real(wp), allocatable :: whole(:)
      real(wp), allocatable :: all(:)
      integer, allocatable :: rows(:)
      integer :: i, n

      allocate (all, source=whole_unknowns(family%impacts, unknowns))
      n = size(whole_sides(family%impacts))
      if (allocated(family%members%impact_of)) then
         allocate (rows, source=family%members%impact_of)
      else
         allocate (rows, source=[(i, i=1, n)])
      end if
      whole = [family%members%speed*abs(all(rows)), all(n + rows)]
   end function whole_of

   !> The wall that the symmetry exchanges with a given one.
   pure integer function image_of_side(family, side) result(image)
      !> The family.
      class(structure_family_type), intent(in) :: family
      !> The channel of the wall, negative for a lower wall.
      integer, intent(in) :: side
      integer :: gap, label

      image = -side
      if (.not. allocated(family%members%symmetry)) return
      associate (s => family%members, structure => family%members%path%structure)
         gap = findloc(structure%channel*structure%wall, side, dim=1)
         label = findloc(s%gap_of, gap, dim=1) + lbound(s%gap_of, 1) - 1
         gap = s%gap_of(-label)
         image = structure%channel(gap)*structure%wall(gap)
      end associate
   end function image_of_side

   !> The value of one condition of a member; -1 if there is none.
   pure subroutine value_of_member(family, unknowns, member, condition, value)
      !> The family.
      class(structure_family_type), intent(in) :: family
      !> Unknowns of the motion.
      real(wp), intent(in) :: unknowns(:)
      !> In and out: the member; its flights are set if they are needed.
      type(member_type), intent(inout) :: member
      !> The condition, not an edge.
      type(condition_type), intent(in) :: condition
      !> The value.
      real(wp), intent(out) :: value
      type(spectrum_type) :: spectrum
      real(wp) :: three(3, 0:1)

      value = -1
      if (.not. member%exists) return
      select case (condition%kind)
      case (fold, flip, neimark_sacker)
         call set_flights(family%impacts, member)
         call stability_values(family, unknowns, member, three, spectrum)
         value = three(condition%kind, min(condition%index, 1))
      case (grazing)
         call set_flights(family%impacts, member)
         associate (i => condition%index)
            value = touch_value(member%regime, member%x_after(:, i), member%v_after(:, i), &
               member%equations%times(i), flight_duration(member, i), units_of(family, &
               member), condition)
         end associate
      case default
         value = simple_value(family, unknowns, member, condition)
      end select
   end subroutine value_of_member

   !> The value of an approach speed or of the distance to a motion that repeats itself.
   pure real(wp) function simple_value(family, unknowns, member, condition) result(value)
      !> The family.
      class(structure_family_type), intent(in) :: family
      !> Unknowns of the motion.
      real(wp), intent(in) :: unknowns(:)
      !> The motion.
      type(member_type), intent(in) :: member
      !> The condition.
      type(condition_type), intent(in) :: condition

      if (condition%kind == zero_approach) then
         value = member%speeds(condition%index)/family%members%speed
      else
         value = repetition_distance(family%impacts, family%repetitions(condition%index), &
            unknowns) - condition%bound
      end if
   end function simple_value

   !> The numbers of fold, flip and Neimark-Sacker.
   pure subroutine stability_values(family, unknowns, member, values, spectrum)
      !> The family.
      class(structure_family_type), intent(in) :: family
      !> Unknowns of the motion.
      real(wp), intent(in) :: unknowns(:)
      !> The motion, with its flights.
      type(member_type), intent(in) :: member
      !> (3, 0:1) The numbers of the family, and those of disturbances after which its impacts at
      !! one instant occur one by one; 0 where an impact has no approach speed.
      real(wp), intent(out) :: values(:, 0:)
      !> The multipliers.
      type(spectrum_type), intent(out) :: spectrum
      complex(wp), allocatable :: beside(:)
      real(wp) :: signs(size(family%impacts%sides))
      integer :: i

      values = 0
      call member_multipliers(family%impacts, member, spectrum%multipliers, spectrum%regular)
      if (.not. spectrum%regular) return
      ! where an approach speed passes zero, a multiplier passes infinity and another one zero
      signs = sign(1.0_wp, member%speeds(:size(signs)))
      call numbers_of(spectrum%multipliers, product(signs), values(:, 0))
      values(:, 1) = 1
      associate (s => family%members)
         if (allocated(s%impact_of)) then
            call multipliers_beside(s, member, beside, spectrum%regular)
            if (.not. spectrum%regular) return
            call numbers_of(beside, product([(signs(modulo(s%impact_of(i) - 1, size(signs)) + 1), &
               i=1, size(s%impact_of))])*product(sign(1.0_wp, member%speeds)), values(:, 1))
            spectrum%multipliers = [spectrum%multipliers, beside]
         end if
      end associate
      ! a multiplier approaches 1 where the motion repeats itself, as the square of the distance
      do i = 1, size(family%repetitions)
         values(fold, 0) = values(fold, 0)/max(0.1_wp*family%apart, &
            repetition_distance(family%impacts, family%repetitions(i), unknowns))**2
      end do
   end subroutine stability_values

   !> The three numbers of some multipliers.
   pure subroutine numbers_of(lambda, continued, values)
      !> The multipliers; conjugate ones are in succession.
      complex(wp), intent(in) :: lambda(:)
      !> -1 where an odd number of them has passed infinity.
      real(wp), intent(in) :: continued
      !> Those of fold, flip and Neimark-Sacker.
      real(wp), intent(out) :: values(3)
      real(wp) :: least(2, 3)
      logical :: one, two
      integer :: i, j

      values = 1
      least = huge(1.0_wp)
      do i = 1, size(lambda)
         one = .not. abs(lambda(i)%im) > 0
         call include(lambda(i), one, values(fold), least(:, fold))
         call include(-lambda(i), one, values(flip), least(:, flip))
         do j = i + 1, size(lambda)
            two = one .and. .not. abs(lambda(j)%im) > 0
            ! DGEEV gives conjugate pairs in succession
            if (j == i + 1 .and. lambda(i)%im > 0) two = .true.
            call include(lambda(i)*lambda(j), two, values(neimark_sacker), &
               least(:, neimark_sacker))
         end do
      end do
      values = values*product(least, 1, least < huge(1.0_wp))
      values([fold, flip]) = continued*values([fold, flip])
   end subroutine numbers_of

   !> Multiplies the sign of a product by that of a factor 1 - z, and updates the two least factors.
   pure subroutine include(z, alone, sign_of, least)
      !> z.
      complex(wp), intent(in) :: z
      !> Whether z is real; otherwise the conjugate factor follows, and their product is positive.
      logical, intent(in) :: alone
      !> In and out: the sign, and the two least |1 - z|/(1 + |z|) in ascending order.
      real(wp), intent(inout) :: sign_of, least(2)
      real(wp) :: factor

      factor = abs(1 - z)/(1 + abs(z))
      if (alone) then
         factor = abs(1 - z%re)/(1 + abs(z%re))
         if (z%re > 1) sign_of = -sign_of
      end if
      if (factor < least(1)) then
         least = [factor, least(1)]
      else
         least(2) = min(least(2), factor)
      end if
   end subroutine include

   !> The least gap within a flight.
   pure subroutine least_gap_of(family, member, touch, gap)
      !> The family.
      class(structure_family_type), intent(in) :: family
      !> The motion, with its flights.
      type(member_type), intent(in) :: member
      !> In: the flight. Out: also the channel, with the sign of the wall, and the share.
      type(condition_type), intent(inout) :: touch
      !> The gap, in units of length; negative beyond the wall.
      real(wp), intent(out) :: gap

      associate (i => touch%index, gaps => member%equations%gaps)
         call least_gap(member%regime, member%x_after(:, i), member%v_after(:, i), &
            member%equations%times(i), flight_duration(member, i), gaps(i:i), &
            [gaps(modulo(i, size(gaps)) + 1)], units_of(family, member), touch, gap)
      end associate
   end subroutine least_gap_of

   !> The units of all rows.
   pure function units_of(family, member) result(units)
      !> The family.
      class(structure_family_type), intent(in) :: family
      !> The motion.
      type(member_type), intent(in) :: member
      real(wp) :: units(size(member%regime%upper))

      units = family%members%length
   end function units_of

end module vi_structure_family
