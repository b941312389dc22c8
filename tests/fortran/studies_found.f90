!> Motions as a search stores them, their continuation over a grid, and times of recorded loads.
module studies_found
   use checks, only: check, check_close
   use vi_assess, only: paper_acceptance
   use vi_branch_switching, only: at_grazing, most_switched, switch_branch
   use vi_chain, only: equispaced_chain
   use vi_exact, only: setting_type
   use vi_forced_system, only: forced_system_type, new_forced_system
   use vi_found_motion, only: are_alike, are_same, described_type, find_in_form, found_from, &
      found_type, mirrored, new_found, store_described
   use vi_grid_continuation, only: sweep_grid
   use vi_kinds, only: two_pi, wp
   use vi_motion, only: motion_type
   use vi_namelist, only: group_type, scan_namelist
   use vi_orbit, only: by_clearance
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: new_pattern
   use vi_periodic, only: linear_system_type
   use vi_status, only: stat
   use vi_structure_loads, only: complete_record, load_keys
   use vi_values, only: read_values, values_type
   implicit none (type, external)
   private

   public :: test_found

contains

   subroutine test_found()
      call test_forms()
      call test_releases()
      call test_nothing_found()
      call test_extrapolation()
      call test_times_of_a_record()
   end subroutine test_found

   !> The first equispaced motion at r = 0.8 with a clearance, of a damped system.
   subroutine equispaced(clearance, motion)
      real(wp), intent(in) :: clearance
      type(motion_type), intent(out) :: motion
      type(linear_system_type) :: system
      type(motion_type) :: motions(2)

      call equispaced_chain(oscillator_type(0.05_wp, 0.1_wp, [0.6_wp, 0.6_wp]), 0.8_wp, &
         clearance, 1, paper_acceptance, .true., system, motions)
      motion = motions(1)
      call check(motion%status == stat%ok, 'found: an equispaced motion')
   end subroutine equispaced

   !> A motion RRL that is not its own mirror image, and its system.
   subroutine asymmetric(system, motion)
      type(forced_system_type), intent(out) :: system
      type(motion_type), intent(out) :: motion
      type(motion_type) :: grazing, found(most_switched)
      integer :: n

      call equispaced(1.7919869460695672_wp, grazing)
      call switch_branch(grazing, at_grazing, 1, 1, by_clearance, .false., found, n)
      call check(n == 2, 'found: motions beside a touch')
      motion = found(1)
      system = new_forced_system(motion%osc, motion%r, 1.0_wp, motion%clearance)
   end subroutine asymmetric

   !> A motion over some of its periods, starting at one of its impacts.
   function from_impact(motion, first, periods) result(found)
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: first, periods
      type(found_type) :: found
      real(wp), allocatable :: x(:), theta(:)
      integer, allocatable :: sides(:)
      integer :: i, n, at

      n = size(motion%x)
      allocate (x(n*periods), theta(n*periods), sides(n*periods))
      do i = 1, n*periods
         at = modulo(first + i - 2, n) + 1
         x(i) = motion%x(at)
         sides(i) = motion%pattern%sides(at)
         theta(i) = motion%tau + motion%phases(at) + two_pi*motion%pattern%cycles &
            *((first + i - 2)/n)
      end do
      found = found_from(periods*motion%pattern%cycles, sides, [x, theta], &
         reshape([0.0_wp, 0.0_wp, 0.0_wp], [3, 1]))
   end function from_impact

   !> A motion is the same from any impact, and over any number of periods. Its standard form
   !! is RRL over one period, that of its mirror image RLL, and only the standard form
   !! does not change.
   subroutine test_forms()
      type(forced_system_type) :: system
      type(motion_type) :: motion
      type(found_type) :: base, other
      type(described_type) :: described
      logical :: changed
      integer :: first, periods

      call asymmetric(system, motion)
      base = from_impact(motion, 1, 1)
      call check(.not. are_alike(system, base, base, .true.), 'found: not its own mirror image')
      do periods = 1, 3
         do first = 1, 3
            other = from_impact(motion, first, periods)
            call check(size(other%releases, 2) == 0, 'found: no rest')
            call check(are_alike(system, base, other, .false.) .and. are_alike(system, other, &
               base, .false.), 'found: the same motion')
            call check(are_alike(system, base, mirrored(other), .true.) .and. .not. &
               are_alike(system, base, mirrored(other), .false.), 'found: a mirror image')
            call find_in_form(system, other, 0, changed, described)
            call check(.not. changed .and. described%motion%status == stat%ok, &
               'found: as it is given')
            call check(all(described%motion%pattern%sides == other%pattern%sides) .and. &
               described%motion%pattern%cycles == periods, 'found: its own symbols')
            call find_in_form(system, other, 1, changed, described)
            call check(changed .eqv. first*periods > 1, 'found: whether it changes')
            associate (m => described%motion)
               call check(size(m%x) == 3 .and. m%pattern%cycles == 1, 'found: one period')
               if (size(m%x) == 3) then
                  call check(all(m%pattern%sides == [1, 1, -1]), 'found: its standard form')
                  call check_close(maxval(abs(m%x - motion%x)) + maxval(abs(m%phases - &
                     motion%phases)), 0.0_wp, 1.0e-10_wp, 'found: the motion in that form')
               end if
            end associate
            call find_in_form(system, other, 2, changed, described)
            associate (m => described%motion)
               call check(changed .and. size(m%x) == 3, 'found: a mirror image changes')
               if (size(m%x) == 3) then
                  call check(all(m%pattern%sides == [1, -1, -1]), 'found: form of the image')
                  call check_close(maxval(abs(m%x + cshift(motion%x, 2))), 0.0_wp, 1.0e-10_wp, &
                     'found: the image in that form')
               end if
            end associate
         end do
      end do
   end subroutine test_forms

   !> Releases are the columns with a wall, whichever it is. Two are the same if wall, phase and
   !! velocity agree, whichever is greater.
   subroutine test_releases()
      real(wp), parameter :: velocity = 2.0_wp, scale = 3.0_wp
      real(wp) :: releases(3, 3), by
      type(found_type) :: one, other
      integer :: i, k, side, sign

      do side = -1, 1, 2
         do k = 0, 3
            releases = 0
            do i = 1, k
               releases(:, i) = [real(side*(-1)**i, wp), 0.5_wp*i, velocity]
            end do
            one = found_from(1, [0], [0.0_wp, 0.0_wp], releases)
            call check(size(one%releases, 2) == k .and. size(one%pattern%sides) == 0 .and. &
               size(one%unknowns) == 0, 'found: releases of both walls')
         end do
         releases(:, 1) = [real(side, wp), 0.1_wp, side*velocity]
         one = found_from(1, [0], [0.0_wp, 0.0_wp], releases(:, :1))
         do sign = -1, 1, 2
            do i = 0, 2
               by = sign*merge(0.0_wp, 0.05_wp, i == 0)
               other = one
               other%releases(2, 1) = one%releases(2, 1) + two_pi*sign
               if (i == 1) other%releases(2, 1) = other%releases(2, 1) + by
               if (i == 2) other%releases(3, 1) = other%releases(3, 1) + by*scale
               call check(are_same(one, other, scale) .eqv. i == 0, 'found: the same release')
            end do
            other = one
            other%releases(1, 1) = sign*side
            call check(are_same(one, other, scale) .eqv. sign > 0, 'found: another wall')
         end do
      end do
   end subroutine test_releases

   !> Far from any motion, none is kept; without a motion none is stored.
   subroutine test_nothing_found()
      type(found_type) :: found
      type(described_type) :: described
      real(wp) :: restitution(2), phases(2), impacts(2, 6), scalars(6), values(7, 2)
      complex(wp) :: multipliers(4)
      integer :: n, cycles, sides(2), verdicts(3), n_events, labels(3, 2), status

      associate (system => new_forced_system(oscillator_type(0.05_wp, 0.1_wp, [0.6_wp, 0.6_wp]), &
         0.8_wp, 1.0_wp, 1000.0_wp))
         call new_found(system, new_pattern('RL', 1), [0.0_wp, 0.0_wp], [0.0_wp, 3.0_wp], found)
      end associate
      call check(found%status /= stat%ok .and. .not. allocated(found%unknowns), &
         'found: no motion of so wide a gap')
      n = -1
      n_events = -1
      described%motion%status = stat%no_convergence
      call store_described(described, n, cycles, sides, restitution, phases, impacts, scalars, &
         multipliers, verdicts, n_events, values, labels, status)
      call check(n == 0 .and. n_events == 0 .and. status == stat%no_convergence, &
         'found: nothing to store')
   end subroutine test_nothing_found

   !> A motion is continued to the next points of a grid from its neighbour alone if the motion
   !! one step further away is a different one, in any respect.
   subroutine test_extrapolation()
      real(wp), parameter :: clearance(3) = [1.9_wp, 2.0_wp, 2.1_wp]
      type(setting_type) :: setting
      type(motion_type) :: motions(3)
      real(wp) :: unknowns(4, 8, 3, 1), by(4)
      integer :: marks(2, 8, 3, 1), counts(2, 3, 1), gained, i, j, k

      do i = 1, 3
         call equispaced(clearance(i), motions(i))
      end do
      setting = setting_type(motions(1)%osc, 0.8_wp, 1.0_wp, 1.0_wp, motions(1)%pattern, &
         motions(1)%restitution)
      do i = -1, 1
         do j = -1, 1
            if (i == 0 .and. j == 0) cycle
            by = [20.0_wp*i, 20.0_wp*i, 2.5_wp*j, 2.5_wp*j]
            unknowns = 0
            marks = 0
            counts = 0
            associate (m => motions(2))
               unknowns(:, 1, 2, 1) = [m%x, m%phases + m%tau]
               unknowns(:, 1, 3, 1) = unknowns(:, 1, 2, 1) + by
            end associate
            counts(:, 2, 1) = [0, 1]
            counts(:, 3, 1) = [1, 1]
            call sweep_grid(setting, [0.8_wp], clearance, 1, 0, 1, unknowns, marks, counts, gained)
            call check(gained == 2 .and. all(counts(2, :, 1) == [1, 1, 2]), &
               'grid: a motion is continued')
            do k = 1, 3, 2
               if (counts(2, k, 1) /= (k + 1)/2) cycle
               associate (u => unknowns(:, (k + 1)/2, k, 1), m => motions(k))
                  call check_close(maxval(abs(u - [m%x, m%phases + m%tau])), 0.0_wp, 1.0e-9_wp, &
                     'grid: the same motion at the next clearance')
               end associate
            end do
         end do
      end do
   end subroutine test_extrapolation

   !> Times of samples may differ from equal steps by a twentieth of a step, early or late.
   subroutine test_times_of_a_record()
      real(wp), parameter :: shift(7) = [-0.4_wp, -0.051_wp, -0.049_wp, 0.0_wp, 0.049_wp, &
         0.051_wp, 0.4_wp]
      character(*), parameter :: path = 'studies_found.tmp.csv'
      type(group_type), allocatable :: groups(:)
      type(values_type) :: structure, load
      character(:), allocatable :: message
      integer :: i, j, line, unit

      do j = 1, 3
         do i = 1, size(shift)
            open (newunit=unit, file=path, status='replace', action='write')
            write (unit, '(a)') 'time,load'
            write (unit, '(f6.3, a, i0)') (merge(line + shift(i), real(line, wp), line == j), &
               ', ', line, line=0, 4)
            close (unit)
            call scan_namelist('&load record_file = '''//path//''', acts_on = 0 /', groups, line, &
               message)
            call read_values('load', load_keys, groups(1), load)
            call complete_record('', structure, 1, load)
            call check((load%fault == '') .eqv. abs(shift(i)) < 0.05_wp, &
               'record: a time between two steps')
            if (load%fault /= '') cycle
            call check_close(load%number('step'), 1.0_wp, 1.0e-15_wp, 'record: the step')
            call check_close(sum(load%numbers('record')), 10.0_wp, 0.0_wp, 'record: its samples')
         end do
      end do
      open (newunit=unit, file=path)
      close (unit, status='delete')
   end subroutine test_times_of_a_record

end module studies_found
