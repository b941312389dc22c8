!> Coarse cells in which a motion that is not periodic has its impacts: they tell one attractor from
!! another.
module vi_attractor_cells
   use vi_kinds, only: two_pi, wp
   implicit none (type, external)
   private

   public :: best_group, count_impact, new_group, owner_of

   !> Number of cells of the phase, which is also that of a value per unit, and number of cells of
   !! the value on either side of 0.
   integer, parameter :: cells = 24, reach = 240

   !> Numbers of impacts of an attractor in cells of (phase, value, wall). The value is the position
   !! or the speed of an impact, in a unit in which it is about 1.
   type, public :: group_type
      integer :: owner = 0
      integer, allocatable :: hits(:, :, :)
   end type group_type

contains

   !> A group without impacts.
   pure function new_group(walls) result(group)
      !> The least and the greatest number of a wall.
      integer, intent(in) :: walls(2)
      type(group_type) :: group

      allocate (group%hits(0:cells - 1, -reach:reach - 1, walls(1):walls(2)), source=0)
   end function new_group

   !> Counts an impact in its cell.
   pure subroutine count_impact(group, phase, value, wall)
      !> In and out: the cells.
      type(group_type), intent(inout) :: group
      !> Load phase (rad), and the value.
      real(wp), intent(in) :: phase, value
      !> Number of the wall.
      integer, intent(in) :: wall
      real(wp) :: place

      place = min(max(value*cells, -real(reach, wp)), reach - 1.0_wp)
      associate (hits => group%hits(modulo(floor(phase*(cells/two_pi)), cells), floor(place), wall))
         hits = hits + 1
      end associate
   end subroutine count_impact

   !> The attractor to which the impacts of a trajectory belong: most of them are in its cells, and
   !! in those of no other one; 0 if there is none.
   pure integer function owner_of(own, groups) result(owner)
      !> The impacts of the trajectory.
      type(group_type), intent(in) :: own
      !> Those of the known attractors.
      type(group_type), intent(in) :: groups(:)
      integer :: best, n

      owner = 0
      if (size(groups) == 0) return
      call best_group(own, groups, best, n)
      if (n == 1) owner = groups(best)%owner
   end function owner_of

   !> Compares a trajectory with the known attractors.
   pure subroutine best_group(own, groups, best, n)
      !> Impacts of the trajectory.
      type(group_type), intent(in) :: own
      !> Impacts of the known attractors, at least one.
      type(group_type), intent(in) :: groups(:)
      !> Place of the attractor whose cells have most of them, and number of attractors whose cells
      !! have more than half of them.
      integer, intent(out) :: best, n
      integer :: shared(size(groups)), i

      do i = 1, size(groups)
         shared(i) = sum(own%hits, mask=groups(i)%hits > 0)
      end do
      best = maxloc(shared, 1)
      n = count(2*shared > sum(own%hits))
   end subroutine best_group

end module vi_attractor_cells
