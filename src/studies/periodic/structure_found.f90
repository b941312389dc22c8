!> Lists of different periodic motions of a structure, and their tables in a result.
module vi_structure_found
   use vi_kinds, only: two_pi, wp
   use vi_motion, only: yes
   use vi_status, only: stat
   use vi_structure, only: load_type, structure_type
   use vi_structure_return, only: settled_type, shorten
   use vi_study, only: column_type, complexes, result_type, verdicts, wholes
   implicit none (type, external)
   private

   public :: add_motion, put_found, same_impacts

   !> Different motions.
   type, public :: found_list_type
      !> The first n of them are there.
      type(settled_type), allocatable :: motions(:)
      integer :: n = 0
   end type found_list_type

   !> The columns of the impacts, and those of multipliers, derivative and rests.
   type(column_type), parameter, public :: impact_columns(*) = [ &
      column_type('impacts', 'impact', wholes, meaning='number of the impact'), &
      column_type('impacts', 'gap', wholes, meaning='number of the gap, from 0'), &
      column_type('impacts', 'phase', unit='rad', meaning='load phase'), &
      column_type('impacts', 'speed', unit='omega F0/K', meaning='approach speed'), &
      column_type('impacts', 'impulse', unit='F0/omega', meaning='impulse'), &
      column_type('impacts', 'q', unit='F0/K', each='coordinate', label='q_#', &
      meaning='coordinates'), &
      column_type('impacts', 'q_dot', unit='omega F0/K', each='coordinate', label='q_dot_#', &
      meaning='velocities just after the impact')], &
      derivative_columns(*) = [ &
      column_type('multipliers', 'multiplier', complexes, listed=.false., &
      meaning='eigenvalues of [P], in order of decreasing modulus'), &
      column_type('derivative', 'P', each='state', listed=.false., &
      meaning='[P], the derivative of the map of coordinates and velocities over a period'), &
      column_type('rests', 'gap', wholes, listed=.false., meaning='gap that rests, from 0'), &
      column_type('rests', 'begin', unit='rad', listed=.false., &
      meaning='load phase at which it begins to rest'), &
      column_type('rests', 'end', unit='rad', listed=.false., &
      meaning='load phase at which it opens')]

   !> The columns of the motions of a list.
   type(column_type), parameter, public :: found_columns(*) = [ &
      column_type('motions', 'motion', wholes, meaning='number of the motion'), &
      column_type('motions', 'cycles', wholes, meaning='load cycles in a period'), &
      column_type('motions', 'stable', verdicts, meaning='whether disturbances decay'), &
      column_type('motions', 'frequency', unit='omega', listed=.false., &
      meaning='of self-excited motions: 2 pi over the period'), &
      impact_columns, &
      column_type('motions', 'residual', listed=.false., &
      meaning='largest relative residual of the equations'), &
      column_type('motions', 'determinant', listed=.false., meaning='det[P]'), &
      column_type('motions', 'law', listed=.false., &
      meaning='value of det[P] that follows from damping and impacts'), &
      column_type('motions', 'consistent', verdicts, listed=.false., &
      meaning='whether it solves all equations'), &
      column_type('motions', 'admissible', verdicts, listed=.false., &
      meaning='whether all gaps stay open between the impacts'), &
      derivative_columns]

contains

   !> Adds a motion over its shortest period, if it is admissible, to those that are known.
   pure subroutine add_motion(structure, load, found, list, place)
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      !> The motion.
      type(settled_type), intent(in) :: found
      !> In and out: the motions.
      type(found_list_type), intent(inout) :: list
      !> Its place among them; 0 if it is not consistent and admissible.
      integer, intent(out) :: place
      type(settled_type), allocatable :: longer(:)
      type(settled_type) :: shorter

      place = 0
      associate (verdicts => found%motion%verdicts)
         if (verdicts%consistent /= yes .or. verdicts%admissible /= yes) return
      end associate
      if (found%free) then
         shorter = found
      else
         call shorten(structure, load, found, shorter)
      end if
      do place = 1, list%n
         if (same_motion(list%motions(place), shorter, load%frequency)) return
      end do
      if (.not. allocated(list%motions)) allocate (list%motions(8))
      if (list%n == size(list%motions)) then
         allocate (longer(2*list%n))
         longer(:list%n) = list%motions
         call move_alloc(longer, list%motions)
      end if
      list%n = place
      list%motions(place) = shorter
   end subroutine add_motion

   !> Whether two motions are the same, whatever impact each is counted from.
   pure logical function same_motion(one, other, frequency)
      !> The motions.
      type(settled_type), intent(in) :: one, other
      !> That of the load.
      real(wp), intent(in) :: frequency

      real(wp), parameter :: near = 1.0e-6_wp

      same_motion = one%cycles == other%cycles .and. size(one%resting) == size(other%resting)
      if (same_motion .and. one%free) same_motion = abs(one%frequency - other%frequency) <= &
         near*one%frequency
      if (.not. same_motion) return
      if (allocated(one%events) .and. allocated(other%events)) then
         same_motion = same_impacts(one%gaps, one%motion%phases, one%motion%speeds, other%gaps, &
            other%motion%phases, other%motion%speeds, one%cycles, size(one%resting) > 0, &
            in_one_unit(one%motion%states), in_one_unit(other%motion%states), one%free)
      else
         same_motion = same_impacts(one%gaps, one%motion%phases, one%motion%speeds, other%gaps, &
            other%motion%phases, other%motion%speeds, one%cycles, size(one%resting) > 0)
      end if

   contains

      !> States with velocities over the frequency.
      pure function in_one_unit(states) result(scaled)
         !> (2n, N) Coordinates and velocities.
         real(wp), intent(in) :: states(:, :)
         real(wp) :: scaled(size(states, 1), size(states, 2))

         associate (n => size(states, 1)/2)
            scaled(:n, :) = states(:n, :)
            scaled(n + 1:, :) = states(n + 1:, :)/merge(one%frequency, frequency, one%free)
         end associate
      end function in_one_unit

   end function same_motion

   !> Whether the impacts of two motions are the same: gaps in order, phases within 1e-6 rad and
   !! speeds within 1e-6 of the largest one. Impacts of accumulations count down to 1e-3 of it. The
   !! speeds of halts and reversals are 0, so with stops or friction the states count, too.
   pure logical function same_impacts(gaps, phases, speeds, other_gaps, other_phases, &
      other_speeds, cycles, rests, states, other_states, free) result(same)
      !> (N) Gaps, load phases (rad) and approach speeds of one motion.
      integer, intent(in) :: gaps(:)
      !> As in `gaps`.
      real(wp), intent(in) :: phases(:), speeds(:)
      !> (M) The same of the other.
      integer, intent(in) :: other_gaps(:)
      !> As in `other_gaps`.
      real(wp), intent(in) :: other_phases(:), other_speeds(:)
      !> Load cycles in the period of both.
      integer, intent(in) :: cycles
      !> Whether they have accumulations.
      logical, intent(in) :: rests
      !> (2n, N) and (2n, M) Coordinates and velocities just after each, in one unit.
      real(wp), intent(in), optional :: states(:, :), other_states(:, :)
      !> Whether both are self-excited, so that the phase of one does not count.
      logical, intent(in), optional :: free
      real(wp), parameter :: near = 1.0e-6_wp, small = 1.0e-3_wp
      integer, allocatable :: first(:), second(:)
      real(wp) :: largest, whole
      real(wp), allocatable :: apart(:)
      integer :: i, n, turn

      first = pack([(i, i=1, size(gaps))], .not. rests .or. speeds > small*maxval(speeds))
      second = pack([(i, i=1, size(other_gaps))], .not. rests .or. other_speeds > &
         small*maxval(other_speeds))
      n = size(first)
      same = n == size(second)
      if (.not. same .or. n == 0) return
      allocate (apart(n))
      largest = max(maxval(speeds), maxval(other_speeds))
      whole = two_pi*cycles
      do turn = 0, cycles - 1
         do i = 1, n
            second = cshift(second, 1)
            if (any(other_gaps(second) /= gaps(first))) cycle
            if (any(abs(other_speeds(second) - speeds(first)) > near*largest)) cycle
            if (present(states) .and. present(other_states)) then
               if (any(abs(other_states(:, second) - states(:, first)) > near* &
                  maxval(abs(states(:, first))))) cycle
            end if
            apart = other_phases(second) + two_pi*turn - phases(first)
            if (present(free)) apart = apart - merge(apart(1), 0.0_wp, free)
            if (all(abs(modulo(apart + 0.5_wp*whole, whole) - 0.5_wp*whole) < near)) return
         end do
      end do
      same = .false.
   end function same_impacts

   !> Fills the tables of some motions.
   pure subroutine put_found(result, found, at, n)
      !> The result.
      type(result_type), intent(inout) :: result
      !> The motions, and places of those that are put, in this order. A copy of some of them would
      !! not be freed by gfortran 12.
      type(settled_type), intent(in) :: found(:)
      !> As in `found`.
      integer, intent(in) :: at(:)
      !> Number of coordinates.
      integer, intent(in) :: n
      integer :: impacts(size(at)), rests(size(at)), i, j, m

      m = size(at)
      impacts = [(size(found(at(i))%gaps), i=1, m)]
      rests = [(size(found(at(i))%resting), i=1, m)]
      call result%open('motions', 'motion', [m])
      call result%put('motions', 'motion', [(i, i=1, m)])
      call result%put('motions', 'cycles', [(found(at(i))%cycles, i=1, m)])
      call result%put('motions', 'stable', [(found(at(i))%motion%verdicts%stable, i=1, m)])
      call result%put('motions', 'residual', [(found(at(i))%motion%residual, i=1, m)])
      call result%put('motions', 'determinant', [(found(at(i))%motion%verdicts%determinant, &
         i=1, m)])
      call result%put('motions', 'law', [(found(at(i))%motion%verdicts%law, i=1, m)])
      call result%put('motions', 'consistent', [(found(at(i))%motion%verdicts%consistent, i=1, m)])
      call result%put('motions', 'admissible', [(found(at(i))%motion%verdicts%admissible, i=1, m)])
      call result%open('impacts', 'impact', [sum(impacts)], 'motions', [(spread(i, 1, &
         impacts(i)), i=1, m)])
      call result%put('impacts', 'impact', [((j, j=1, impacts(i)), i=1, m)])
      call result%put('impacts', 'gap', [(found(at(i))%gaps - 1, i=1, m)])
      call result%put('impacts', 'phase', [(found(at(i))%motion%phases, i=1, m)])
      call result%put('impacts', 'speed', [(found(at(i))%motion%speeds, i=1, m)])
      call result%put('impacts', 'impulse', [(found(at(i))%motion%impulses, i=1, m)])
      call result%put('impacts', 'q', [(found(at(i))%motion%states(:n, :), i=1, m)], n)
      call result%put('impacts', 'q_dot', [(found(at(i))%motion%states(n + 1:, :), i=1, m)], n)
      call result%open('multipliers', 'multiplier', [2*n*m], 'motions', [(spread(i, 1, 2*n), &
         i=1, m)])
      call result%put('multipliers', 'multiplier', [(found(at(i))%motion%verdicts%multipliers, &
         i=1, m)])
      call result%open('derivative', 'state_row', [2*n*m], 'motions', [(spread(i, 1, 2*n), i=1, m)])
      call result%put('derivative', 'P', [(transpose(found(at(i))%motion%verdicts%p), i=1, m)], 2*n)
      call result%open('rests', 'rest', [sum(rests)], 'motions', [(spread(i, 1, rests(i)), i=1, m)])
      call result%put('rests', 'gap', [(found(at(i))%resting - 1, i=1, m)])
      call result%put('rests', 'begin', [(found(at(i))%rests(1, :), i=1, m)])
      call result%put('rests', 'end', [(found(at(i))%rests(2, :), i=1, m)])
   end subroutine put_found

end module vi_structure_found
