!> The tracer follows any family of motions: here one with a closed form, which none of
!! its files knows.
module studies_families
   use checks, only: check, check_close
   use vi_branch, only: branch_type, follow_branch
   use vi_curve, only: curve_type
   use vi_kinds, only: wp
   use vi_linear, only: most
   use vi_loop, only: loop_type
   use vi_motion_family, only: condition_type, coordinates_type, edge, flip, fold, &
      motion_family_type, neimark_sacker, parameters_at
   use vi_spectrum, only: spectrum_type
   use vi_steps, only: stride_type
   use vi_trace, only: trace_loop
   implicit none (type, external)
   private

   public :: test_families

   !> One unknown, y = x**2 + 2 z**2 at the parameters x and z; stable where y < 1.
   type, extends(motion_family_type) :: bowl_type
   contains
      procedure :: unknown_count, wrap_phases, set_equations
      procedure :: condition_count, set_conditions, condition_value, whole_of, part_of
   end type bowl_type

contains

   subroutine test_families()
      type(curve_type) :: surface, line
      type(loop_type) :: loop
      type(branch_type) :: branch
      real(wp) :: area
      integer :: i, next, reported, way

      call new_bowl([1, 2], surface)
      call trace_loop(surface, stride_type(longest=0.02_wp, turn=0.15_wp), [1.0_wp, 1.0_wp, &
         0.0_wp], condition_type(flip), 2000, 1, loop)
      call check(loop%closed, 'another family: a closed boundary')
      area = 0
      do i = 1, loop%n
         next = modulo(i, loop%n) + 1
         associate (y => loop%points(1, i), at => loop%points(2:, i), to => loop%points(2:, next))
            call check_close(y, 1.0_wp, 1e-12_wp, 'another family: the unknown on the boundary')
            call check_close(at(1)**2 + 2*at(2)**2, 1.0_wp, 1e-12_wp, &
               'another family: the boundary')
            area = area + 0.5_wp*(at(1)*to(2) - at(2)*to(1))
         end associate
      end do
      call check_close(abs(area), acos(-1.0_wp)/sqrt(2.0_wp), 1e-3_wp, 'another family: its area')
      call new_bowl([1], line)
      do way = -1, 1, 2
         reported = 0
         call follow_branch(line, stride_type(longest=0.05_wp, turn=0.3_wp), [0.0_wp, 0.0_wp], &
            way, 500, branch, 1000, reported)
         i = findloc(branch%special(:branch%n)%kind, flip, dim=1)
         call check(i > 0, 'another family: where a branch becomes unstable')
         if (i == 0) cycle
         call check_close(branch%points(2, i), real(way, wp), 1e-9_wp, 'another family: that place')
         call check_close(branch%points(2, branch%n), 2.0_wp*way, 1e-9_wp, &
            'another family: a branch ends at its bound')
      end do
   end subroutine test_families

   !> The surface or curve of all motions with |x| < 2 and |z| < 2.
   subroutine new_bowl(active, curve)
      integer, intent(in) :: active(:)
      type(curve_type), intent(out) :: curve
      type(bowl_type) :: bowl
      integer :: i, side

      allocate (bowl%repetitions(0), bowl%images(0))
      allocate (curve%family, source=bowl)
      curve%active = active
      curve%origin = 0*active
      curve%scale = [(1.0_wp, i=1, size(active))]
      curve%edges = [((condition_type(edge, active(i), side, bound=-2.0_wp*side), side=1, -1, -2), &
         i=1, size(active))]
   end subroutine new_bowl

   pure integer function unknown_count(family)
      class(bowl_type), intent(in) :: family

      unknown_count = 1 + size(family%repetitions)
   end function unknown_count

   pure subroutine wrap_phases(family, offset)
      class(bowl_type), intent(in) :: family
      real(wp), intent(inout) :: offset(:)

      offset(:size(family%repetitions)) = 0
   end subroutine wrap_phases

   pure subroutine set_equations(family, coordinates, conditions, point, b, a)
      class(bowl_type), intent(in) :: family
      type(coordinates_type), intent(in) :: coordinates
      type(condition_type), intent(in) :: conditions(:)
      real(wp), intent(in) :: point(:)
      real(wp), intent(inout) :: b(2, most), a(most, most)
      real(wp) :: c(size(coordinates%c)), by(2)
      integer :: j

      c = parameters_at(coordinates, point(2:))
      by = [2*c(1), 4*c(2)]
      b(1, 1) = c(1)**2 + 2*c(2)**2 - point(1)
      a(:size(point), 1) = [-1.0_wp, coordinates%scale*by(coordinates%active)]
      do j = 1, size(conditions)
         b(1, 1 + j) = family%condition_value(point(:1), c, conditions(j))
         a(:size(point), 1 + j) = 0
         if (conditions(j)%kind == flip) a(1, 1 + j) = -1
      end do
   end subroutine set_equations

   pure integer function condition_count(family)
      class(bowl_type), intent(in) :: family

      condition_count = 3 + size(family%repetitions)
   end function condition_count

   pure subroutine set_conditions(family, unknowns, c, values, found, spectrum)
      class(bowl_type), intent(in) :: family
      real(wp), intent(in) :: unknowns(:), c(:)
      real(wp), intent(out) :: values(:)
      type(condition_type), intent(out) :: found(:)
      type(spectrum_type), intent(out) :: spectrum
      integer :: j

      spectrum%regular = .false.
      found = [condition_type(fold), condition_type(flip), condition_type(neimark_sacker)]
      values = [(family%condition_value(unknowns, c, found(j)), j=1, 3)]
   end subroutine set_conditions

   pure real(wp) function condition_value(family, unknowns, c, condition) result(value)
      class(bowl_type), intent(in) :: family
      real(wp), intent(in) :: unknowns(:), c(:)
      type(condition_type), intent(in) :: condition

      value = 1 + 0*c(1)*family%apart
      if (condition%kind == flip) value = 1 - unknowns(1)
   end function condition_value

   pure function whole_of(family, unknowns) result(whole)
      class(bowl_type), intent(in) :: family
      real(wp), intent(in) :: unknowns(:)
      real(wp), allocatable :: whole(:)

      whole = [unknowns(:family%unknown_count()), 0.0_wp]
   end function whole_of

   pure function part_of(family, c, whole) result(unknowns)
      class(bowl_type), intent(in) :: family
      real(wp), intent(in) :: c(:), whole(:)
      real(wp), allocatable :: unknowns(:)

      unknowns = whole(:family%unknown_count()) + 0*c(1)
   end function part_of

end module studies_families
