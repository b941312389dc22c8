!> Conditions that end a zone: both methods of computing them, and their slopes.
module studies_conditions
   use checks, only: check, check_close
   use motions_orbit, only: random_member
   use random_numbers, only: draw, draw_integer, fill, random_type
   use vi_conditions, only: all_conditions, condition_count, condition_value
   use vi_curve, only: condition_slope, curve_type, parameters_of, unknowns_of
   use vi_family, only: new_family, whole_unknowns
   use vi_kinds, only: wp
   use vi_motion_family, only: condition_type, grazing
   use vi_orbit, only: by_clearance, by_r, family_type, most_impacts, n_parameters, orbit_type, &
      period_parts, set_orbit, split_part
   use vi_pair_family, only: pair_family_type
   use vi_pattern, only: pattern_type
   use vi_spectrum, only: multiplier_sums, spectrum_type
   implicit none (type, external)
   private

   public :: test_conditions

   !> Quadruple precision.
   integer, parameter :: qp = selected_real_kind(30)

   type(random_type) :: random

contains

   subroutine test_conditions()
      type(curve_type) :: curve
      type(pair_family_type) :: pair
      real(wp), allocatable :: unknowns(:)
      integer :: i, smooth, rough

      smooth = 0
      rough = 0
      allocate (pair%repetitions(0), curve%edges(0), curve%origin(2))
      allocate (curve%active, source=[by_r, by_clearance])
      allocate (curve%scale, source=[0.3_wp, 0.7_wp])
      do i = 1, 300
         call random_member(random, pair%impacts, unknowns, curve%c)
         if (allocated(curve%family)) deallocate (curve%family)
         allocate (curve%family, source=pair)
         curve%origin(:) = curve%c(curve%active) - 0.5_wp*curve%scale
         call check_conditions(curve, [unknowns, 0.5_wp, 0.5_wp], smooth, rough)
         if (pair%impacts%mirror) call check_nearly_symmetric(pair%impacts, curve, unknowns, &
            smooth, rough)
      end do
      call check(smooth > 9*rough, 'conditions: most are smooth')
      call test_hardly_any_approach()
   end subroutine test_conditions

   !> The numbers that decide stability, where approach speeds are tiny and the map of
   !! the period is large, compared with the same product in quadruple precision.
   subroutine check_spectrum(family, unknowns, c)
      type(family_type), intent(in) :: family
      real(wp), intent(in) :: unknowns(:), c(:)
      type(orbit_type) :: o
      type(spectrum_type) :: spectrum
      real(wp) :: parts(4, 4, most_impacts), p(4, 4), base(3, 4), column(3)
      real(qp) :: product(4, 4), part(4, 4), power(4, 4), sums(4), e(0:4), traces(4), sign_e
      logical :: regular
      integer :: i, j

      call set_orbit(family, unknowns, c, o)
      call multiplier_sums(o, spectrum)
      if (.not. spectrum%regular) return
      call period_parts(o, parts, p, regular)
      sign_e = 1
      do i = 1, o%n
         call split_part(o, i, base, column)
         do j = 1, 3
            part(j, :) = base(j, :) + real(column(j), qp)*parts(4, :, i)
         end do
         part(4, :) = parts(4, :, i)
         if (i == 1) product = part
         if (i > 1) product = matmul(part, product)
         sign_e = sign(sign_e, sign_e*o%side(i)*(o%speed(i - 1) - o%before(i)))
      end do
      ! Newton's identities
      power = product
      do i = 1, 4
         traces(i) = power(1, 1) + power(2, 2) + power(3, 3) + power(4, 4)
         power = matmul(power, product)
      end do
      e(0) = 1
      do i = 1, 4
         sums(i) = 0
         do j = 1, i
            sums(i) = sums(i) + merge(1, -1, mod(j, 2) == 1)*e(i - j)*traces(j)
         end do
         e(i) = sums(i)/i
      end do
      e = sign_e*e/norm2(real(e(:3), wp))
      call check_close(maxval(abs(spectrum%e(:3) - real(e(:3), wp))), 0.0_wp, 1.0e-9_wp, &
         'conditions: the sums of the multipliers')
   end subroutine check_spectrum

   !> Motions with tiny approach speeds at one or two impacts.
   subroutine test_hardly_any_approach()
      type(family_type) :: family
      real(wp), allocatable :: unknowns(:)
      type(orbit_type) :: o
      real(wp) :: wanted, step, h, speed(2), c(n_parameters)
      integer :: i, j, k, n

      do i = 1, 500
         call random_member(random, family, unknowns, c)
         n = size(unknowns)/2
         wanted = 10.0_wp**draw(random, -9.0_wp, -3.0_wp)
         ! the position of an impact changes its approach in proportion
         k = draw_integer(random, 1, n)
         h = 1.0e-3_wp
         do j = 1, 4
            call set_orbit(family, unknowns, c, o)
            speed(1) = o%side(k)*(o%speed(k - 1) - o%before(k))
            unknowns(k) = unknowns(k) + h
            call set_orbit(family, unknowns, c, o)
            speed(2) = o%side(k)*(o%speed(k - 1) - o%before(k))
            unknowns(k) = unknowns(k) - h
            step = h*(wanted - speed(1))/(speed(2) - speed(1))
            if (.not. abs(step) < 10) exit
            unknowns(k) = unknowns(k) + step
         end do
         call check_spectrum(family, unknowns, c)
      end do
   end subroutine test_hardly_any_approach

   !> Where the motion is close to its mirror image, their distance matters too.
   subroutine check_nearly_symmetric(family, symmetric, half, smooth, rough)
      type(family_type), intent(in) :: family
      type(curve_type), intent(in) :: symmetric
      real(wp), intent(in) :: half(:)
      integer, intent(inout) :: smooth, rough
      type(curve_type) :: curve
      type(pair_family_type) :: pair
      type(pattern_type) :: pattern
      real(wp) :: away(2*size(half))
      logical :: possible

      curve = symmetric
      allocate (pattern%sides, source=[family%sides, -family%sides])
      pattern%cycles = family%cycles
      call new_family(pattern, .false., .true., pair%impacts, pair%repetitions, possible)
      call check(possible .and. size(pair%repetitions) > 0, 'conditions: a repetition')
      deallocate (curve%family)
      allocate (curve%family, source=pair)
      call fill(random, -0.1_wp, 0.1_wp, away)
      call check_conditions(curve, [whole_unknowns(family, half) + away, 0.5_wp, 0.5_wp], &
         smooth, rough)
   end subroutine check_nearly_symmetric

   !> All values together equal those of single conditions; slopes equal wider differences.
   subroutine check_conditions(curve, point, smooth, rough)
      type(curve_type), intent(in) :: curve
      real(wp), intent(in) :: point(:)
      !> Conditions whose slope could be examined, and conditions that are not smooth there.
      integer, intent(inout) :: smooth, rough
      type(condition_type) :: found(condition_count(curve))
      real(wp) :: values(size(found)), value, scale
      real(wp), dimension(size(point)) :: slope, wide, wider
      integer :: j

      call all_conditions(curve, unknowns_of(curve, point), parameters_of(curve, point), &
         values, found)
      do j = 1, size(found)
         if (found(j)%kind == grazing .and. found(j)%side == 0) cycle
         call condition_slope(curve, found(j), point, value, slope)
         call check_close(value, values(j), 1.0e-12_wp*max(1.0_wp, abs(value)), &
            'conditions: one and all')
         wide = difference(curve, found(j), point, 2.0e-5_wp)
         wider = difference(curve, found(j), point, 4.0e-5_wp)
         scale = max(1.0e-3_wp, maxval(abs(wide)))
         ! the differences themselves show a kink, or a pole nearby
         if (maxval(abs(wide - wider)) > 1.0e-7_wp*scale) then
            rough = rough + 1
            cycle
         end if
         smooth = smooth + 1
         call check_close(maxval(abs(slope - wide)), 0.0_wp, 1.0e-5_wp*scale, 'conditions: slope')
      end do
   end subroutine check_conditions

   !> Differences of the fourth order.
   function difference(curve, condition, point, h) result(slope)
      type(curve_type), intent(in) :: curve
      type(condition_type), intent(in) :: condition
      real(wp), intent(in) :: point(:), h
      real(wp) :: slope(size(point)), moved(size(point)), weights(-2:2)
      integer :: j, k

      weights = [1, -8, 0, 8, -1]/(12*h)
      slope = 0
      do j = 1, size(point)
         do k = -2, 2
            if (k == 0) cycle
            moved = point
            moved(j) = point(j) + k*h
            slope(j) = slope(j) + weights(k)*condition_value(curve, unknowns_of(curve, &
               moved), parameters_of(curve, moved), condition)
         end do
      end do
   end function difference

end module studies_conditions
