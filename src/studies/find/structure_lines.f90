!> Further motions of a structure, along two lines through the point.
!!
!! The lines of constant amplitude and of constant frequency of the load through a motion, followed
!! through their folds, often return to the point on another sheet. Each passage gives a motion
!! with impacts in the same order, and both its lines are followed as well. The mirror images of
!! motions are motions too, if the structure has that symmetry.
module vi_structure_lines
   use vi_curve_point, only: curve_type
   use vi_kinds, only: pi, wp
   use vi_lattice, only: lattice_of
   use vi_net, only: add_seed, cover, net_type, new_net
   use vi_progress, only: add_done_work, add_expected_work, is_stopped
   use vi_status, only: stat
   use vi_structure, only: check_structure, load_type, structure_type
   use vi_structure_found, only: add_motion, found_list_type
   use vi_structure_path, only: change_type, is_odd, new_change, opposite_gap, structure_path_type
   use vi_structure_period, only: exact, periodic_structure
   use vi_structure_return, only: settled_type
   use vi_structure_start, only: phases_at, start_curve
   implicit none (type, external)
   private

   public :: follow_lines

   !> How far lines are followed: frequency and amplitude of the load over those at the point.
   real(wp), parameter :: low(2) = [0.88_wp, 0.25_wp], high(2) = [1.12_wp, 2.5_wp]
   !> Largest number of steps along the lines through a motion; a search with few guesses makes at
   !! most as many as the square of their number.
   integer, parameter :: most_steps = 3000

contains

   !> Adds the motions that the lines through those of a list meet, and their mirror images.
   subroutine follow_lines(structure, load, guesses, list, progress)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Its load, with a frequency > 0.
      type(load_type), intent(in) :: load
      !> Sets of impact times of the search.
      integer, intent(in) :: guesses
      !> In and out: the motions that are known.
      type(found_list_type), intent(inout) :: list
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(structure_path_type) :: path
      type(change_type) :: changes(2)
      type(settled_type) :: start
      logical, allocatable :: followed(:)
      character(:), allocatable :: message
      integer :: i, j, place, status

      path%structure = structure
      path%load = load
      call check_structure(path%structure, status)
      if (status /= stat%ok) return
      call new_change('frequency', load%frequency*[low(1), high(1)], path%structure, load, &
         changes(1), message)
      if (len(message) == 0) call new_change('load', [low(2), high(2)], path%structure, load, &
         changes(2), message)
      path%changes = changes(:merge(2, 0, len(message) == 0))
      allocate (followed(0))
      i = 0
      do while (i < list%n)
         i = i + 1
         if (is_stopped(progress)) return
         call add_expected_work(1, progress)
         ! a copy, as the list grows
         start = list%motions(i)
         if (size(start%resting) == 0) then
            if (is_odd(path)) call add_at(path, [(opposite_gap(path%structure, start%gaps(j)), &
               j=1, size(start%gaps))], start%motion%phases + pi, start%cycles, list, place)
            call mark(followed, i, .false.)
            if (size(path%changes) > 0 .and. .not. followed(i)) call follow_motion(path, start, &
               min(most_steps, min(guesses, most_steps)**2), list, followed, progress)
         end if
         call add_done_work(1, progress)
      end do
   end subroutine follow_lines

   !> Adds the motions that the lines through a motion meet.
   subroutine follow_motion(path, start, steps, list, followed, progress)
      !> The structure and its load, and the two parameters of the lines.
      type(structure_path_type), intent(in) :: path
      !> In and out: the motion.
      type(settled_type), intent(inout) :: start
      !> Largest number of steps.
      integer, intent(in) :: steps
      !> In and out: the motions that are known.
      type(found_list_type), intent(inout) :: list
      !> In and out: as of `mark`.
      logical, allocatable, intent(inout) :: followed(:)
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(curve_type) :: surface
      type(net_type) :: net
      real(wp), allocatable :: point(:)
      character(:), allocatable :: message
      integer :: node, place
      logical :: mirrored

      call start_curve(path%structure, path%load, start, path%changes, surface, point, mirrored, &
         message)
      if (len(message) > 0) return
      associate (m => size(point) - 2)
         call new_net(surface, lattice_of(point(m + 1:)), net, .false.)
         net%most_steps = steps
         call add_seed(net, 1, 1, point(:m), node)
         call cover(net, 1, progress)
         do node = 1, net%n
            call add_at(path, start%gaps, phases_at(surface, [net%unknowns(:, node), &
               point(m + 1:)]), start%cycles, list, place)
            if (place > 0) call mark(followed, place, .true.)
         end do
      end associate
   end subroutine follow_motion

   !> Marks a motion of the list, for which there may be no place yet.
   pure subroutine mark(followed, place, value)
      !> In and out: whether the lines through each motion have been followed.
      logical, allocatable, intent(inout) :: followed(:)
      !> The place of the motion.
      integer, intent(in) :: place
      !> Whether they have been now.
      logical, intent(in) :: value

      if (place > size(followed)) followed = [followed, spread(.false., 1, place - size(followed))]
      followed(place) = followed(place) .or. value
   end subroutine mark

   !> Adds the motion near given impacts.
   subroutine add_at(path, gaps, phases, cycles, list, place)
      !> The structure and its load.
      type(structure_path_type), intent(in) :: path
      !> (N) The gaps of the impacts, and load cycles in a period.
      integer, intent(in) :: gaps(:), cycles
      !> (N) Load phases of the impacts.
      real(wp), intent(in) :: phases(:)
      !> In and out: the motions that are known.
      type(found_list_type), intent(inout) :: list
      !> Its place among them; 0 if there is none, or if it is not admissible.
      integer, intent(out) :: place
      type(structure_type) :: own
      type(settled_type) :: found
      integer :: status

      place = 0
      own = path%structure
      found%gaps = gaps
      found%cycles = cycles
      allocate (found%resting(0), found%rests(2, 0))
      call periodic_structure(own, path%load, gaps, phases, cycles, exact, found%motion, status)
      if (status == stat%ok) call add_motion(path%structure, path%load, found, list, place)
   end subroutine add_at

end module vi_structure_lines
