!> The conditions of motions of structures, where there is no motion, no approach, no wall, or more
!! than one pair of multipliers outside the unit circle.
module studies_structure_conditions
   use checks, only: check, check_close
   use random_numbers, only: draw, fill, random_type
   use vi_conditions, only: all_conditions, condition_count, condition_value
   use vi_curve, only: condition_slope, curve_type
   use vi_kinds, only: wp
   use vi_motion_family, only: condition_type, edge, flip, fold, grazing, neimark_sacker
   use vi_orbit, only: n_parameters
   use vi_spectrum, only: spectrum_type
   use vi_status, only: stat
   use vi_structure, only: check_structure, new_load, new_structure
   use vi_structure_family, only: structure_family_type
   use vi_structure_members, only: member_type, set_member, set_sides
   use vi_structure_path, only: change_type, new_change
   implicit none (type, external)
   private

   public :: test_structure_conditions

   type(random_type) :: random

contains

   subroutine test_structure_conditions()
      call test_absent()
      call test_no_approach()
      call test_crossings()
      call test_touches()
      call test_range_of_restitution()
   end subroutine test_structure_conditions

   !> Two masses, the second one of them between two walls, and the mass that couples them as the
   !! parameter: from 0.8 to 1.2 times the geometric mean of the masses.
   subroutine new_motions(damping, family)
      real(wp), intent(in) :: damping(2)
      type(structure_family_type), intent(out) :: family
      real(wp) :: matrices(2, 2, 3), harmonics(2, 2, 1)
      type(change_type) :: change
      character(:), allocatable :: message
      integer :: i, status

      matrices = 0
      do i = 1, 2
         matrices(i, i, :) = [1.0_wp, damping(i), draw(random, 0.5_wp, 2.0_wp)]
      end do
      matrices(1, 2, 1) = 0.8_wp
      matrices(2, 1, 1) = 0.8_wp
      call fill(random, -1.0_wp, 1.0_wp, harmonics(:, 1, 1))
      call fill(random, -1.0_wp, 1.0_wp, harmonics(:, 2, 1))
      allocate (family%repetitions(0))
      associate (s => family%members)
         s%path%structure = new_structure(matrices, reshape([0.0_wp, 1.0_wp, 0.0_wp, -1.0_wp], &
            [2, 2]), reshape([0.7_wp, 0.98_wp, 0.9_wp, 0.99_wp], [2, 2]))
         call check_structure(s%path%structure, status)
         call check(status == stat%ok, 'conditions of structures: a structure')
         s%path%load = new_load(1.3_wp, harmonics, [0.0_wp, 0.0_wp])
         call new_change('mass_0_1', [0.8_wp, 1.2_wp], s%path%structure, s%path%load, change, &
            message)
         call check(len(message) == 0, 'conditions of structures: a parameter')
         s%path%changes = [change]
         call set_sides(s)
         allocate (s%free(2, 0))
      end associate
      family%impacts%sides = [1, -1]
      family%impacts%cycles = 1
   end subroutine new_motions

   !> The curve of these motions along their parameter, between its bounds.
   subroutine new_curve(family, curve)
      type(structure_family_type), intent(in) :: family
      type(curve_type), intent(out) :: curve

      allocate (curve%family, source=family)
      curve%edges = [condition_type(edge, 1, 1, bound=0.0_wp), condition_type(edge, 1, -1, &
         bound=1.0_wp)]
      curve%active = [1]
      curve%origin = [0.0_wp]
      curve%scale = [1.0_wp]
   end subroutine new_curve

   !> Where the masses are not positive definite there is no motion: no condition is met there but
   !! those on the parameter, and none changes.
   subroutine test_absent()
      type(structure_family_type) :: family
      type(curve_type) :: curve
      type(condition_type) :: found(9)
      type(spectrum_type) :: spectrum
      type(member_type) :: member
      real(wp), parameter :: unknowns(4) = [0.5_wp, -0.6_wp, 0.3_wp, 3.5_wp]
      real(wp) :: values(9), c(n_parameters), value, slope(5)
      integer :: i, j

      call new_motions([0.1_wp, 0.2_wp], family)
      call new_curve(family, curve)
      call check(condition_count(curve) == 9, 'conditions of structures: number')
      do i = 1, 4
         c = 0
         c(1) = 0.4_wp + 0.2_wp*i
         call all_conditions(curve, unknowns, c, values, found, spectrum)
         call check(all(abs(values(:7) + 1) <= 0), 'no motion: no condition is met')
         call check_close(values(8), c(1), 1e-15_wp, 'no motion: the lower bound')
         call check_close(values(9), 1 - c(1), 1e-15_wp, 'no motion: the upper bound')
         call check(all(found(8:)%kind == edge), 'no motion: kinds of conditions')
         call set_member(family%members, family%impacts, unknowns, c(:1), member)
         call check(.not. member%exists, 'no motion: there is none')
         do j = 1, 7
            call check_close(condition_value(curve, unknowns, c, found(j)), -1.0_wp, 0.0_wp, &
               'no motion: one condition is not met')
            call condition_slope(curve, found(j), [unknowns, c(1)], value, slope)
            call check(value > 1 .and. all(abs(slope) <= 0), 'no motion: no slope')
         end do
      end do
   end subroutine test_absent

   !> An impact without approach speed: the numbers of stability are 0, and so is its approach.
   subroutine test_no_approach()
      type(structure_family_type) :: family
      type(curve_type) :: curve
      type(condition_type) :: found(9)
      type(spectrum_type) :: spectrum
      real(wp) :: unknowns(4), values(9)
      integer :: j, k

      call new_motions([0.1_wp, 0.2_wp], family)
      call new_curve(family, curve)
      do k = 1, 2
         unknowns = [0.5_wp, -0.6_wp, 0.3_wp, 3.5_wp]
         unknowns(k) = 0
         call all_conditions(curve, unknowns, spread(0.2_wp, 1, n_parameters), values, &
            found, spectrum)
         call check(.not. spectrum%regular, 'no approach: no multipliers')
         call check(all(abs(values(:3)) <= 0), 'no approach: numbers of stability')
         do j = 1, 2
            call check_close(values(3 + j), merge(0.0_wp, abs(unknowns(j)), j == k), 1e-15_wp, &
               'no approach: approach speeds')
         end do
      end do
   end subroutine test_no_approach

   !> The numbers of fold, flip and Neimark-Sacker have the signs of their products. For a zone all
   !! of them are positive only at stable motions, even if two pairs of multipliers are outside
   !! the unit circle.
   subroutine test_crossings()
      type(structure_family_type) :: family
      type(curve_type) :: curve
      type(condition_type) :: found(9)
      type(spectrum_type) :: spectrum
      real(wp) :: values(9, 2), c(n_parameters), unknowns(4)
      complex(wp) :: products(3)
      integer :: i, j, k, hidden, stable

      hidden = 0
      stable = 0
      do i = 1, 2000
         call new_motions(spread(draw(random, -0.3_wp, 0.3_wp), 1, 2), family)
         call new_curve(family, curve)
         unknowns = [draw(random, 0.5_wp, 5.0_wp), -draw(random, 0.5_wp, 5.0_wp), 0.3_wp, &
            draw(random, 2.0_wp, 5.0_wp)]
         c = draw(random, 0.0_wp, 0.3_wp)
         do j = 1, 2
            curve%family%every_crossing = j == 2
            call all_conditions(curve, unknowns, c, values(:, j), found, spectrum)
         end do
         if (.not. spectrum%regular) cycle
         associate (lambda => spectrum%multipliers)
            products = 1
            do j = 1, size(lambda)
               products(fold) = products(fold)*(1 - lambda(j))
               products(flip) = products(flip)*(1 + lambda(j))
               do k = j + 1, size(lambda)
                  products(neimark_sacker) = products(neimark_sacker)*(1 - lambda(j)*lambda(k))
               end do
            end do
            call check(all(products%re > 0 .eqv. values(:3, 2) > 0), 'crossings: products')
            call check(all(values(:3, 1) > 0) .eqv. all(abs(lambda) < 1), &
               'crossings: stable motions alone are inside a zone')
            call check(all(abs(abs(values(:, 1)) - abs(values(:, 2))) <= 0), &
               'crossings: a zone and a branch differ in one sign at most')
            if (all(values(:3, 2) > 0) .and. any(abs(lambda) > 1)) hidden = hidden + 1
            if (all(abs(lambda) < 1)) stable = stable + 1
         end associate
      end do
      call check(hidden > 5 .and. stable > 100, 'crossings: two pairs are outside')
   end subroutine test_crossings

   !> The gap of a particle that flies freely changes in proportion to the time; a flight that
   !! touches no wall counts as one with a wide gap.
   subroutine test_touches()
      type(structure_family_type) :: family
      type(curve_type) :: curve
      type(condition_type) :: touch
      type(change_type) :: change
      character(:), allocatable :: message
      real(wp), parameter :: opening(2) = [0.7_wp, 0.9_wp]
      real(wp) :: c(n_parameters), ends(2), values(2), unknowns(5), slope(6)
      type(member_type) :: member
      integer :: i, status

      allocate (family%repetitions(0))
      associate (s => family%members)
         s%path%structure = new_structure(reshape([1.0_wp, 0.0_wp, 0.0_wp], [1, 1, 3]), &
            reshape([1.0_wp, -1.0_wp], [1, 2]), reshape([opening(1), 0.6_wp, opening(2), 0.8_wp], &
            [2, 2]))
         call check_structure(s%path%structure, status)
         s%path%load = new_load(1.0_wp, reshape([0.0_wp, 0.0_wp], [1, 2, 1]), [0.0_wp])
         call new_change('opening_0', [0.5_wp, 0.9_wp], s%path%structure, s%path%load, change, &
            message)
         s%path%changes = [change]
         call set_sides(s)
         s%p = 1
         s%free = reshape([1.0_wp], [1, 1])
      end associate
      family%impacts%sides = [1, -1]
      family%impacts%cycles = 1
      call new_curve(family, curve)
      c = 0.5_wp
      unknowns = [0.4_wp, -0.3_wp, 0.5_wp, 2.5_wp, 0.2_wp]
      touch = condition_type(grazing, 1, 0)
      call set_member(family%members, family%impacts, unknowns, c(:1), member)
      call check(member%exists, 'touches: a flight')
      call condition_slope(curve, touch, [unknowns, c(1)], values(1), slope)
      call check(abs(values(1) - 1) <= 0 .and. all(abs(slope) <= 0), 'touches: no wall')
      do i = 1, 9
         touch%share = 0.1_wp*i
         touch%side = 1
         values(1) = condition_value(curve, unknowns, c, touch)
         touch%side = -1
         values(2) = condition_value(curve, unknowns, c, touch)
         call check_close(sum(values), sum(opening), 1e-14_wp, 'touches: both gaps')
         touch%share = 0
         ends(1) = condition_value(curve, unknowns, c, touch)
         touch%share = 1
         ends(2) = condition_value(curve, unknowns, c, touch)
         call check_close(values(2), ends(1) + 0.1_wp*i*(ends(2) - ends(1)), 1e-14_wp, &
            'touches: in proportion')
         call check(abs(ends(2) - ends(1)) > 0.1_wp, 'touches: the particle moves')
      end do
   end subroutine test_touches

   !> Coefficients of restitution lie between 0 and 1, bounds included, whether or not the wrong
   !! bound is tested.
   subroutine test_range_of_restitution()
      type(structure_family_type) :: family
      type(change_type) :: change
      character(:), allocatable :: message
      real(wp), parameter :: bounds(2, 4) = reshape([0.0_wp, 1.0_wp, -1.0e-9_wp, 1.0_wp, 0.0_wp, &
         1 + 1.0e-9_wp, -0.1_wp, 1.1_wp], [2, 4])
      integer, parameter :: wrong(4) = [0, 1, 2, 1]
      integer :: bound, i

      call new_motions([0.1_wp, 0.2_wp], family)
      associate (path => family%members%path)
         do i = 1, size(wrong)
            call new_change('restitution_1', bounds(:, i), path%structure, path%load, change, &
               message, bound)
            call check(bound == wrong(i) .and. (len(message) > 0 .eqv. wrong(i) > 0), &
               'range of restitution: the bound that is wrong')
            call new_change('restitution_1', bounds(:, i), path%structure, path%load, change, &
               message)
            call check(len(message) > 0 .eqv. wrong(i) > 0, 'range of restitution')
         end do
      end associate
   end subroutine test_range_of_restitution

end module studies_structure_conditions
