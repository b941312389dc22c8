!> The motions of one pattern at a point (r, D), from guesses there and along two lines through it.
!!
!! Newton's method misses motions whose neighbourhood of convergence is small. However, the lines of
!! constant D and of constant r through a motion, followed through their folds, often return to the
!! point on another sheet. Each passage through the point gives a further motion, and both its lines
!! are followed as well. Where a motion grazes a wall, a line of another pattern begins, in which
!! that touch is an additional impact.
module vi_passages
   use vi_curve, only: correct, curve_type, tangent_at
   use vi_kinds, only: pi, wp
   use vi_motion_family, only: condition_type, edge, grazing
   use vi_symbols, only: standard_symbols
   use vi_likeness, only: distance, same
   use vi_orbit, only: by_clearance, by_left, by_r, by_right, by_xi, family_type, orbit_type, &
      set_orbit
   use vi_oscillator, only: gain
   use vi_pair_family, only: gap_of_flight, pair_family_type, polish_touch
   use vi_pattern, only: pattern_type
   use vi_progress, only: is_stopped
   use vi_search, only: search_pattern
   use vi_steps, only: place_type, stride_type, take_step
   implicit none (type, external)
   private

   public :: begin_lines, follow_birth

   !> Guesses between two looks at the progress counters.
   integer, parameter :: between = 256
   !> Units of length along r and log D, those of the 1983 charts, and how far a line is followed.
   real(wp), parameter :: unit(2) = [0.4_wp, log(100.0_wp)], reach = 0.3_wp
   !> Births are not sought on a motion that is farther beyond a wall (over D) than this. Lines of
   !! births beyond a wall can lead to admissible motions; this was observed from 0.38 beyond.
   real(wp), parameter :: depth = 0.5_wp
   !> Largest number of motions and of births kept for a pattern, and of steps along its lines; a
   !! search with few guesses makes at most as many steps as the square of their number.
   integer, parameter :: capacity = 128, most_births = 32, most_steps = 3000

   !> A motion that just touches a wall, written with the touch as an impact: in standard order.
   type, public :: birth_type
      type(pattern_type) :: pattern
      !> The parameter that changes along the line where it was found, its place there, and the
      !! unknowns (x_i/D, theta_i).
      integer :: direction = 0
      real(wp) :: place = 0
      real(wp), allocatable :: unknowns(:)
   end type birth_type

   !> The known motions of a pattern at a point, and the lines through them.
   type, public :: lines_type
      private
      type(pattern_type) :: pattern
      type(family_type) :: impacts
      type(curve_type) :: curve
      !> Unit of x_i/D.
      real(wp) :: scale = 1
      !> Steps made, and their largest number.
      integer :: steps = 0, most_steps = 0
      !> Largest number of impacts of a pattern that begins at a grazing, and whether the walls are
      !! alike.
      integer :: symbols = 0
      logical :: alike = .false.
      integer, public :: n = 0, n_births = 0
      !> For each motion: x_i/D and theta_i (2N, capacity), and whether its lines of constant D and
      !! of constant r have been followed (2, capacity).
      real(wp), allocatable, public :: unknowns(:, :)
      logical, allocatable :: followed(:, :)
      type(birth_type), public :: births(most_births)
   end type lines_type

contains

   !> The motions of a pattern at a point, admissible or not, and their lines.
   subroutine begin_lines(pattern, c, guesses, symbols, lines, tried, progress)
      !> Sides of the N impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> Number of guesses for Newton's method.
      integer, intent(in) :: guesses
      !> Largest number of impacts of a pattern that begins where another one grazes.
      integer, intent(in) :: symbols
      !> Out: the motions found, their lines and births.
      type(lines_type), intent(inout) :: lines
      !> Number of Newton iterations that were started.
      integer, intent(out) :: tried
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      integer :: done, more

      call new_lines(pattern, c, lines)
      lines%symbols = symbols
      lines%most_steps = min(most_steps, min(guesses, most_steps)**2)
      lines%alike = abs(c(by_right) - c(by_left)) <= 0
      tried = 0
      do done = 0, guesses - 1, between
         if (is_stopped(progress)) return
         call search_pattern(pattern, c, min(between, guesses - done), lines%unknowns, lines%n, &
            more, done)
         tried = tried + more
      end do
      call follow_all(lines, 1)
   end subroutine begin_lines

   !> Follows the line that begins at a birth, and the lines of all motions at the point that it
   !! reaches.
   pure subroutine follow_birth(lines, birth)
      !> In and out: motions and births of the pattern of the birth.
      type(lines_type), intent(inout) :: lines
      !> The birth.
      type(birth_type), intent(in) :: birth
      integer :: way, first

      first = lines%n + 1
      do way = -1, 1, 2
         call walk(lines, birth%direction, birth%unknowns, birth%place, way)
      end do
      call follow_all(lines, first)
   end subroutine follow_birth

   !> Follows both lines through every motion at the point, from one of them on.
   pure subroutine follow_all(lines, first)
      !> In and out: motions and births of the pattern.
      type(lines_type), intent(inout) :: lines
      !> Number of the first motion whose lines are followed.
      integer, intent(in) :: first
      real(wp) :: unknowns(2*size(lines%pattern%sides))
      integer :: i, direction, way

      i = first
      do while (i <= lines%n)
         unknowns = lines%unknowns(:, i)
         do direction = 1, 2
            if (lines%followed(direction, i)) cycle
            lines%followed(direction, i) = .true.
            do way = -1, 1, 2
               call walk(lines, direction, unknowns, 0.0_wp, way)
            end do
         end do
         i = i + 1
      end do
   end subroutine follow_all

   !> The lines of a pattern before any motion is known.
   pure subroutine new_lines(pattern, c, lines)
      !> Sides of the N impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> Out: without motions.
      type(lines_type), intent(inout) :: lines
      type(pair_family_type) :: pair

      lines%pattern = pattern
      lines%scale = max(1.0_wp, min(huge(1.0_wp), gain(c(by_xi), c(by_r)))*exp(-c(by_clearance)))
      allocate (lines%curve%edges(0))
      pair%impacts%sides = pattern%sides
      pair%impacts%cycles = pattern%cycles
      allocate (pair%repetitions(0))
      lines%impacts = pair%impacts
      allocate (lines%curve%family, source=pair)
      lines%curve%c = c
      lines%curve%active = [by_r]
      lines%curve%origin = [0.0_wp]
      lines%curve%scale = [1.0_wp]
      allocate (lines%unknowns(2*size(pattern%sides), capacity))
      allocate (lines%followed(2, capacity), source=.false.)
   end subroutine new_lines

   !> Follows a line in one direction, until it leaves the range of the parameter, an impact loses
   !! its approach speed, or the line reaches a part that has been followed before.
   pure subroutine walk(lines, direction, unknowns, place, way)
      !> In and out: motions and births of the pattern.
      type(lines_type), intent(inout) :: lines
      !> Place of the parameter that changes along the line (`by_r` or `by_clearance`), and the sign
      !! of its change at the start.
      integer, intent(in) :: direction, way
      !> Unknowns of the motion at the start (2N), and its coordinate on the line, 0 at the point.
      real(wp), intent(in) :: unknowns(:), place
      type(condition_type) :: none(0), touches(size(unknowns)/2), touches_next(size(unknowns)/2)
      type(place_type) :: now, next
      type(orbit_type) :: o
      real(wp) :: along(size(unknowns) + 1)
      real(wp), dimension(size(unknowns)/2) :: gaps, gaps_next
      integer :: n
      logical :: good, known, looks, right

      n = size(along)
      lines%curve%active = direction
      lines%curve%origin = lines%curve%c(direction)
      lines%curve%scale = unit(direction)
      now%point = [unknowns, place]
      looks = size(gaps) < lines%symbols
      call look(lines, now%point, looks, o, right, gaps, touches)
      ! at a birth the approach speed of the new impact is zero
      if (.not. (right .or. abs(place) > 0)) return
      along = 0
      along(n) = way
      allocate (now%tangent(n))
      allocate (now%bend(n, 2), source=0.0_wp)
      call tangent_at(lines%curve, none, now%point, along, now%tangent, good)
      now%step = 0.02_wp
      do while (good .and. lines%steps < lines%most_steps)
         lines%steps = lines%steps + 1
         call take_step(lines%curve, none, stride_type(longest=0.06_wp, turn=0.4_wp), now, next, &
            good, blind=.true.)
         if (.not. good) return
         if (.not. next%came < now%step) next%step = 1.6_wp*next%came
         call look(lines, next%point, looks, o, right, gaps_next, touches_next)
         if (looks) call note_births(lines, now, next, gaps, gaps_next, touches_next)
         call note_passages(lines, now, next, known)
         if (known .or. abs(next%point(n)) > reach .or. .not. right) return
         now = next
         gaps = gaps_next
      end do
   end subroutine walk

   !> The orbit of a point of a line: whether the masses approach each other at every impact, and
   !! the gaps of its flights.
   pure subroutine look(lines, point, looks, o, right, gaps, touches)
      !> The line.
      type(lines_type), intent(in) :: lines
      !> A point of it.
      real(wp), intent(in) :: point(:)
      !> Whether the gaps are wanted.
      logical, intent(in) :: looks
      !> Out: the orbit, if r > 0.
      type(orbit_type), intent(inout) :: o
      !> Whether the masses approach each other at every impact.
      logical, intent(out) :: right
      !> The least gap inside each flight over D, and where it is.
      real(wp), intent(inout) :: gaps(:)
      !> The grazing condition of each gap, with its wall and share of the flight.
      type(condition_type), intent(inout) :: touches(:)
      real(wp) :: c(size(lines%curve%c))
      integer :: i

      associate (curve => lines%curve)
         c = curve%c
         c(curve%active(1)) = curve%origin(1) + curve%scale(1)*point(size(point))
      end associate
      right = .false.
      gaps = 0
      if (.not. c(by_r) > 0) return
      call set_orbit(lines%impacts, point(:size(point) - 1), c, o)
      right = all(o%side(1:o%n)*(o%speed(0:o%n - 1) - o%before(1:o%n)) > 0)
      if (.not. (looks .and. right)) return
      do i = 1, o%n
         touches(i) = condition_type(grazing, i)
         call gap_of_flight(o, touches(i), gaps(i))
      end do
   end subroutine look

   !> Notes where a motion grazes a wall within a step: a longer pattern begins there.
   pure subroutine note_births(lines, now, next, gaps, gaps_next, touches)
      !> In and out: births are added.
      type(lines_type), intent(inout) :: lines
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      !> Gap of each flight over D before and after the step.
      real(wp), intent(in) :: gaps(:), gaps_next(:)
      !> The grazing conditions of the gaps after the step.
      type(condition_type), intent(in) :: touches(:)
      type(birth_type) :: birth
      real(wp) :: point(size(now%point))
      integer :: i, iterations

      do i = 1, size(gaps)
         if (.not. gaps(i)*gaps_next(i) < 0 .or. touches(i)%kind /= grazing) cycle
         if (lines%n_births == most_births .or. minval(gaps) < -depth) return
         point = now%point + gaps(i)/(gaps(i) - gaps_next(i))*(next%point - now%point)
         call correct(lines%curve, [touches(i)], point, iterations)
         if (iterations == 0 .or. norm2(point - now%point) > 2*next%came) cycle
         call insert(lines, point, touches(i), birth)
         if (.not. is_known(lines%births(:lines%n_births), birth)) then
            lines%n_births = lines%n_births + 1
            lines%births(lines%n_births) = birth
         end if
      end do
   end subroutine note_births

   !> Whether a birth is among those noted.
   pure logical function is_known(births, birth)
      !> Known births, and the one in question.
      type(birth_type), intent(in) :: births(:), birth
      integer :: i

      is_known = .false.
      do i = 1, size(births)
         if (births(i)%direction /= birth%direction) cycle
         is_known = abs(births(i)%place - birth%place) < same .and. &
            all(births(i)%pattern%sides == birth%pattern%sides)
         if (is_known) return
      end do
   end function is_known

   !> A motion that touches a wall, with the touch as an additional impact, in standard order.
   pure subroutine insert(lines, point, touch, birth)
      !> Pattern and line of the motion.
      type(lines_type), intent(in) :: lines
      !> A point of the line that touches a wall.
      real(wp), intent(in) :: point(:)
      !> Flight, wall and approximate share of the flight's duration.
      type(condition_type), intent(in) :: touch
      !> The motion with the touch as an impact.
      type(birth_type), intent(out) :: birth
      type(orbit_type) :: o
      type(condition_type) :: there
      real(wp), dimension(size(point)/2 + 1) :: x, theta
      real(wp) :: c(size(lines%curve%c)), gap, z
      integer, dimension(size(x)) :: sides, symbols
      integer :: i, n, shift
      logical :: mirrored

      n = size(x) - 1
      c = lines%curve%c
      birth%direction = lines%curve%active(1)
      birth%place = point(size(point))
      c(birth%direction) = lines%curve%origin(1) + lines%curve%scale(1)*birth%place
      call set_orbit(lines%impacts, point(:2*n), c, o)
      ! the touch of a motion a step away happens at another time; from there the longer pattern
      ! does not solve the equations, and its line would not be found
      there = touch
      call polish_touch(o, there, gap)
      i = touch%index
      z = o%z(i) + there%share*(o%z(i + 1) - o%z(i))
      x = [point(:i), z - 0.5_wp*touch%side, point(i + 1:n)]
      theta = [point(n + 1:n + i), o%theta(i) + there%share*(o%theta(i + 1) - o%theta(i)), &
         point(n + i + 1:2*n)]
      sides = [lines%pattern%sides(:i), touch%side, lines%pattern%sides(i + 1:)]
      call standard_symbols(sides, lines%alike, symbols, shift, mirrored)
      theta(:shift) = theta(:shift) + 2*pi*lines%pattern%cycles
      x = cshift(x, shift)
      theta = cshift(theta, shift)
      if (mirrored) then
         x = -x
         theta = theta + pi
      end if
      birth%pattern = pattern_type(symbols, lines%pattern%cycles)
      birth%unknowns = [x, theta]
   end subroutine insert

   !> Adds the motions where a step passes the point.
   !!
   !! A step around a fold may pass the point twice: on the way to the fold and on the way back.
   pure subroutine note_passages(lines, now, next, known)
      !> In and out: motions are added.
      type(lines_type), intent(inout) :: lines
      !> Start and end of the step.
      type(place_type), intent(in) :: now, next
      !> Whether the line has been followed there before.
      logical, intent(out) :: known
      real(wp) :: a, b
      integer :: n

      known = .false.
      n = size(now%point)
      a = now%point(n)
      b = next%point(n)
      if (a*b < 0) then
         call note(lines, now%point - a/(b - a)*(next%point - now%point), next%came, known)
      else if (now%tangent(n)*next%tangent(n) < 0) then
         ! the first passage may be the beginning itself
         if (passes(a, -now%tangent(n), next%came)) call note(lines, &
            now%point - a/now%tangent(n)*now%tangent, next%came, known)
         if (known) return
         if (passes(b, next%tangent(n), next%came)) call note(lines, &
            next%point - b/next%tangent(n)*next%tangent, next%came, known)
      end if
   end subroutine note_passages

   !> Whether the tangent at a place passes coordinate 0 within one step before the place.
   pure logical function passes(q, slope, step)
      !> Coordinate at the place, its derivative along the tangent, and the length of the step.
      real(wp), intent(in) :: q, slope, step

      passes = q*slope > 0 .and. abs(q) < step*abs(slope)
   end function passes

   !> Adds the motion at the point that Newton's method finds from a guess, if it is near the guess.
   pure subroutine note(lines, guess, step, known)
      !> In and out: the motion is added, and its line marked as followed.
      type(lines_type), intent(inout) :: lines
      !> A guess for the motion: a point of the line.
      real(wp), intent(in) :: guess(:)
      !> The length of the step that passes the point.
      real(wp), intent(in) :: step
      !> Whether the line has been followed there before.
      logical, intent(inout) :: known
      real(wp) :: point(size(guess))
      integer :: i, n, iterations

      n = size(point)
      point = guess
      associate (curve => lines%curve)
         call correct(curve, [condition_type(edge, curve%active(1), 1, bound=curve%origin(1))], &
            point, iterations)
      end associate
      if (iterations == 0 .or. norm2(point - guess) > step) return
      do i = 1, lines%n
         if (distance(lines%pattern, lines%scale, point(:n - 1), lines%unknowns(:, i)) < same) exit
      end do
      if (i > lines%n) then
         if (i > capacity) return
         lines%n = i
         lines%unknowns(:, i) = point(:n - 1)
      end if
      known = lines%followed(lines%curve%active(1), i)
      lines%followed(lines%curve%active(1), i) = .true.
   end subroutine note

end module vi_passages
