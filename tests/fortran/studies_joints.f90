!> Open ends of boundaries are joined if they are close, whatever the directions of the arcs; and
!! names of the conditions along them.
module studies_joints
   use checks, only: check
   use vi_borders, only: zone_type
   use vi_condition_names, only: condition_detail, condition_name
   use vi_join, only: join_loose_ends
   use vi_kinds, only: wp
   use vi_loop, only: begins, ends, loop_type, picked, reversed
   use vi_motion_family, only: alike, condition_type, contact_vanishes, edge, event_vanishes, &
      events_meet, flight_vanishes, flip, fold, grazing, joint, neimark_sacker, repetition, &
      rest_splits, rest_vanishes, stick_begins, stick_vanishes, together, zero_approach
   use vi_resting_family, only: new_resting_family
   implicit none (type, external)
   private

   public :: test_condition_names, test_corners_at_joints, test_joints, test_short_curves

   real(wp), parameter :: pi = acos(-1.0_wp)

contains

   !> Two arcs of a circle with two gaps between them.
   subroutine test_joints()
      type(zone_type) :: zone
      real(wp) :: gaps(2)
      integer :: turned, i

      do turned = 0, 3
         ! both gaps are small: one ring
         gaps = [5.0e-5_wp, 8.0e-5_wp]
         call two_arcs(gaps, turned, zone)
         call join_loose_ends(zone)
         call check(zone%n == 1 .and. zone%loops(1)%closed, 'two arcs become one ring')
         associate (loop => zone%loops(1))
            call check(count(loop%conditions%kind == joint) == 4, 'two joints, each with two ends')
            call check(abs(sum([(abs(step(loop, i)), i=1, loop%n)], loop%conditions%kind == joint &
               .and. loop%corner == begins) - sum(gaps)) < 1.0e-12_wp, 'joints are as long as gaps')
            call check(abs(sum([(step(loop, i), i=1, loop%n)]) - sign(2*pi, step(loop, 1))) &
               < 1.0e-9_wp, 'the ring goes round once')
            call check(all(pack(loop%corner, cshift(loop%corner, 1) == begins) == ends .or. &
               pack(loop%corner, cshift(loop%corner, 1) == begins) == 0) .and. &
               count(loop%corner == begins) == count(loop%corner == ends), &
               'a piece ends where the next begins')
            call check(all(abs(norm2(loop%tangents, 1) - 1) < 1.0e-12_wp), &
               'tangents of joints are unit vectors, too')
         end associate
         ! one gap is not: the arcs make a longer arc, which stays open
         call two_arcs([5.0e-5_wp, 1.0e-3_wp], turned, zone)
         call join_loose_ends(zone)
         call check(zone%n == 1 .and. .not. zone%loops(1)%closed, 'a wide gap stays open')
         call check(count(zone%loops(1)%conditions%kind == joint) == 2, 'one joint')
         ! different motions are not joined, whatever the parameters
         call two_arcs(gaps, turned, zone)
         zone%loops(2)%points(1, :) = 1
         call join_loose_ends(zone)
         call check(zone%n == 2 .and. .not. any(zone%loops(:2)%closed), 'other motions')
         ! a line whose end is near the gap, but farther away than the gap is wide, stays separate
         call two_arcs([5.0e-5_wp, 1.0e-3_wp], turned, zone)
         zone%n = 3
         zone%loops(3) = arc(0.0_wp, 1.0_wp, flip)
         do i = 1, zone%loops(3)%n
            zone%loops(3)%points(3:, i) = [1 + 9.0e-5_wp + 0.01_wp*(i - 1), 0.0_wp]
         end do
         call join_loose_ends(zone)
         call check(zone%n == 2 .and. count(zone%loops(1)%conditions%kind == joint) == 2 .and. &
            all(zone%loops(2)%conditions%kind == flip), 'the nearest ends are joined first')
         ! a complete ring has no ends, wherever its first and last vertices are
         do i = 1, 2
            call two_arcs(gaps, turned, zone)
            zone%loops(i)%closed = .true.
            call join_loose_ends(zone)
            call check(zone%n == 2 .and. .not. any(zone%loops(1)%conditions%kind == joint) .and. &
               .not. any(zone%loops(2)%conditions%kind == joint), 'a closed loop is not joined')
         end do
      end do
   end subroutine test_joints

   !> A curve is joined with itself if it goes farther from its start than ten times the distance of
   !! ends that are joined, in whichever direction.
   subroutine test_short_curves()
      type(zone_type) :: zone
      real(wp) :: angle, size_of
      integer :: i, k

      do i = 1, 16
         do k = 1, 2
            ! out and back, along the first half
            angle = 0.25_wp*pi*i/2
            size_of = merge(0.9e-3_wp, 1.6e-3_wp, k == 1)
            call two_arcs([1.0_wp, 1.0_wp], 0, zone)
            zone%n = 1
            associate (loop => zone%loops(1))
               loop = picked(loop, [1, 2, 3])
               loop%points(3:, 1) = [0.5_wp, 0.5_wp]
               loop%points(3:, 2) = 0.5_wp + size_of*[cos(angle), sin(angle)]
               loop%points(3:, 3) = 0.5_wp + 5.0e-5_wp*[-sin(angle), cos(angle)]
            end associate
            call join_loose_ends(zone)
            call check(zone%loops(1)%closed .eqv. k == 2, &
               'a curve is closed if it is larger than a gap, whatever its direction')
         end do
      end do
   end subroutine test_short_curves

   !> Where a corner could not be turned, one vertex represents both pieces, at either end and
   !! whatever the directions of the arcs; a joint without length has no direction.
   subroutine test_corners_at_joints()
      type(zone_type) :: zone
      integer :: turned, first, last, i

      do turned = 0, 3
         do first = 1, 2
            do last = 1, 2
               call two_arcs([5.0e-5_wp, 8.0e-5_wp], turned, zone)
               do i = 1, 2
                  zone%loops(i)%corner(1) = merge(ends, 0, first == 1)
                  zone%loops(i)%corner(zone%loops(i)%n) = merge(begins, 0, last == 1)
               end do
               call join_loose_ends(zone)
               associate (loop => zone%loops(1))
                  call check(zone%n == 1 .and. loop%closed .and. count(loop%conditions%kind &
                     == joint) == 4, 'corners at joints: one ring')
                  call check(count(loop%conditions%kind /= joint) == 82 - 2*count([first, last] &
                     == 1), 'corners at joints: one vertex stands for two pieces')
                  call check(count(loop%corner == begins) == 4 .and. count(loop%corner == ends) &
                     == 4, 'corners at joints: four pieces')
               end associate
            end do
         end do
         ! the second arc begins where the first one ends
         call two_arcs([5.0e-5_wp, 8.0e-5_wp], turned, zone)
         zone%loops(2)%points(:, merge(41, 1, btest(turned, 1))) = &
            zone%loops(1)%points(:, merge(1, 41, btest(turned, 0)))
         call join_loose_ends(zone)
         associate (length => norm2(zone%loops(1)%tangents, 1))
            call check(count(length <= 0) == 2 .and. count(abs(length - 1) < 1.0e-12_wp) == 84, &
               'a joint without length has no direction')
         end associate
      end do
   end subroutine test_corners_at_joints

   !> Two arcs of the unit circle, of a fold and of a flip.
   subroutine two_arcs(gaps, turned, zone)
      !> Angles of the gaps at angle 0 and about pi.
      real(wp), intent(in) :: gaps(2)
      !> Which arcs go clockwise: bits 0 and 1.
      integer, intent(in) :: turned
      !> The zone.
      type(zone_type), intent(out) :: zone

      zone%n = 2
      allocate (zone%loops(4))
      allocate (zone%surface%family, source=new_resting_family([integer :: ], 1))
      zone%loops(1) = arc(0.5_wp*gaps(1), pi - 0.5_wp*gaps(2), fold)
      zone%loops(2) = arc(pi + 0.5_wp*gaps(2), 2*pi - 0.5_wp*gaps(1), flip)
      if (btest(turned, 0)) zone%loops(1) = reversed(zone%loops(1))
      if (btest(turned, 1)) zone%loops(2) = reversed(zone%loops(2))
   end subroutine two_arcs

   !> A part of the unit circle.
   function arc(low, high, kind) result(loop)
      real(wp), intent(in) :: low, high
      integer, intent(in) :: kind
      type(loop_type) :: loop
      integer :: i
      real(wp) :: angle

      loop%n = 41
      allocate (loop%points(4, loop%n), loop%tangents(4, loop%n), source=0.0_wp)
      allocate (loop%conditions(loop%n), source=condition_type(kind))
      allocate (loop%corner(loop%n), source=0)
      do i = 1, loop%n
         angle = low + (high - low)*(i - 1)/40
         loop%points(3:, i) = [cos(angle), sin(angle)]
         loop%tangents(3:, i) = [-sin(angle), cos(angle)]
      end do
   end function arc

   !> The angle from a vertex to the next.
   pure real(wp) function step(loop, i)
      type(loop_type), intent(in) :: loop
      integer, intent(in) :: i

      associate (a => loop%points(3:, i), b => loop%points(3:, modulo(i, loop%n) + 1))
         step = atan2(a(1)*b(2) - a(2)*b(1), dot_product(a, b))
      end associate
   end function step

   !> The name and the detail of each kind of condition.
   subroutine test_condition_names()
      integer, parameter :: plain(7) = [neimark_sacker, zero_approach, grazing, edge, &
         rest_vanishes, rest_splits, joint]
      character(14), parameter :: names(7) = [character(14) :: 'neimark_sacker', 'zero_approach', &
         'grazing', 'bound', 'rest_vanishes', 'rest_splits', 'joint']
      logical :: symmetric, mirrored
      integer :: i, k

      do k = 0, 3
         symmetric = mod(k, 2) == 1
         mirrored = k > 1
         do i = 1, size(plain)
            call named(plain(i), 1, names(i))
         end do
         call named(flight_vanishes + 1, 1, 'unknown')
         call named(stick_begins, 1, 'stick_begins')
         call named(stick_vanishes, 1, 'stick_vanishes')
         call named(contact_vanishes, 1, 'contact_vanishes')
         call named(event_vanishes, 1, 'event_vanishes')
         call named(events_meet, 1, 'simultaneous')
         call named(flight_vanishes, 1, 'flight_vanishes')
         call named(fold, 0, 'fold')
         call named(fold, together, 'pitchfork')
         call named(fold, alike, 'branch_point')
         call named(flip, 0, merge('pitchfork', 'flip     ', symmetric))
         call named(flip, together, 'flip')
         call named(repetition, 1, merge('pitchfork', 'flip     ', mirrored))
         call named(repetition, 2, 'flip')
      end do
      call check(condition_detail(grazing, 9, 1) == 'flight 9 touches R', 'a flight')
      call check(condition_detail(grazing, 10, -1) == 'flight 10 touches L', 'two digits')
      call check(condition_detail(zero_approach, 24, 0) == 'impact 24', 'an impact')
      call check(condition_detail(edge, 1, 1) == 'lowest r', 'the lowest bound')
      call check(condition_detail(edge, 6, -1) == 'highest R2', 'the highest bound')
      call check(condition_detail(edge, 6, 1) == 'lowest R2', 'another lowest bound')
      call check(condition_detail(fold, 1, 1) == '', 'no detail')

   contains

      !> Checks the name of a condition.
      subroutine named(kind, index, name)
         integer, intent(in) :: kind, index
         character(*), intent(in) :: name

         call check(condition_name(kind, index, symmetric, mirrored) == name, &
            'the name of a condition: '//name)
      end subroutine named
   end subroutine test_condition_names

end module studies_joints
