!> The motions of one pattern at a point, from guesses there and along two lines through it.
!!
!! Newton's method misses motions whose neighbourhood of convergence is small. But the lines of
!! constant D and of constant r through a motion, followed through their folds, often come back to
!! the point on another sheet: each passage through the point is one more of its motions, and both
!! its lines are followed as well.
module vi_passages
   use vi_curve, only: correct, curve_type, tangent_at
   use vi_frame, only: condition_type, edge
   use vi_kinds, only: wp
   use vi_likeness, only: distance, same
   use vi_orbit, only: by_clearance, by_r, by_xi, orbit_type, set_orbit
   use vi_oscillator, only: gain
   use vi_pattern, only: pattern_type
   use vi_search, only: search_pattern
   use vi_steps, only: place_type, stride_type, take_step
   implicit none (type, external)
   private

   public :: motions_through

   !> Units of length along r and log D, those of the 1983 charts, and how far a line is followed.
   real(wp), parameter :: unit(2) = [0.4_wp, log(100.0_wp)], reach = 0.3_wp
   !> Motions kept of a pattern, and steps made along its lines.
   integer, parameter :: room = 128, most_steps = 3000

   !> What is known of a pattern at a point.
   type :: lines_type
      type(pattern_type) :: pattern
      type(curve_type) :: curve
      !> Unit of x_i/D.
      real(wp) :: scale = 1
      integer :: steps = 0, n = 0
      !> Of each motion (2N, room), and whether its lines of constant D and of constant r have been
      !> followed (2, room).
      real(wp), allocatable :: unknowns(:, :)
      logical, allocatable :: followed(:, :)
   end type lines_type

contains

   !> The motions of a pattern at a point, admissible or not.
   pure subroutine motions_through(pattern, c, guesses, found, tried)
      type(pattern_type), intent(in) :: pattern
      !> r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> Guesses for Newton's method.
      integer, intent(in) :: guesses
      !> Unknowns (x_i/D, theta_i) of each (2N, m).
      real(wp), allocatable, intent(out) :: found(:, :)
      !> Newton iterations that were started.
      integer, intent(out) :: tried
      type(lines_type) :: lines
      real(wp) :: unknowns(2*size(pattern%sides))
      integer :: i, direction, way

      call new_lines(pattern, c, lines)
      call search_pattern(pattern, c, guesses, lines%unknowns, lines%n, tried, 0)
      i = 1
      do while (i <= lines%n)
         unknowns = lines%unknowns(:, i)
         do direction = 1, 2
            if (lines%followed(direction, i)) cycle
            lines%followed(direction, i) = .true.
            do way = -1, 1, 2
               call walk(lines, direction, unknowns, way)
            end do
         end do
         i = i + 1
      end do
      allocate (found(size(unknowns), lines%n), source=lines%unknowns(:, :lines%n))
   end subroutine motions_through

   !> Nothing known yet.
   pure subroutine new_lines(pattern, c, lines)
      type(pattern_type), intent(in) :: pattern
      real(wp), intent(in) :: c(:)
      type(lines_type), intent(out) :: lines

      lines%pattern = pattern
      lines%scale = max(1.0_wp, min(huge(1.0_wp), gain(c(by_xi), c(by_r)))*exp(-c(by_clearance)))
      associate (frame => lines%curve%frame)
         frame%family%sides = pattern%sides
         frame%family%cycles = pattern%cycles
         allocate (frame%edges(0), frame%repetitions(0))
      end associate
      lines%curve%c = c
      lines%curve%active = [by_r]
      lines%curve%origin = [0.0_wp]
      lines%curve%scale = [1.0_wp]
      allocate (lines%unknowns(2*size(pattern%sides), room))
      allocate (lines%followed(2, room), source=.false.)
   end subroutine new_lines

   !> Follows a line one way from a motion at the point, until it leaves the reach or what is
   !! physical, or comes to where it has been followed before.
   pure subroutine walk(lines, direction, unknowns, way)
      type(lines_type), intent(inout) :: lines
      !> The parameter that changes along the line, and which way first.
      integer, intent(in) :: direction, way
      real(wp), intent(in) :: unknowns(:)
      type(condition_type) :: none(0)
      type(place_type) :: now, next
      real(wp) :: along(size(unknowns) + 1)
      integer :: n
      logical :: good, known

      n = size(along)
      lines%curve%active = direction
      lines%curve%origin = lines%curve%c(direction)
      lines%curve%scale = unit(direction)
      now%point = [unknowns, 0.0_wp]
      if (.not. approaches(lines%curve, now%point)) return
      along = 0
      along(n) = way
      allocate (now%tangent(n))
      allocate (now%bend(n, 2), source=0.0_wp)
      call tangent_at(lines%curve, none, now%point, along, now%tangent, good)
      now%step = 0.02_wp
      do while (good .and. lines%steps < most_steps)
         lines%steps = lines%steps + 1
         call take_step(lines%curve, none, stride_type(longest=0.06_wp, turn=0.4_wp), now, next, &
            good, blind=.true.)
         if (.not. good) return
         if (.not. next%came < now%step) next%step = 1.6_wp*next%came
         call note_passages(lines, now, next, known)
         if (known .or. abs(next%point(n)) > reach) return
         if (.not. approaches(lines%curve, next%point)) return
         now = next
      end do
   end subroutine walk

   !> Whether the masses approach each other at every impact.
   pure logical function approaches(curve, point)
      type(curve_type), intent(in) :: curve
      real(wp), intent(in) :: point(:)
      type(orbit_type) :: o
      real(wp) :: c(size(curve%c))

      c = curve%c
      c(curve%active(1)) = curve%origin(1) + curve%scale(1)*point(size(point))
      approaches = .false.
      if (.not. c(by_r) > 0) return
      call set_orbit(curve%frame%family, point(:size(point) - 1), c, o)
      approaches = all(o%side(1:o%n)*(o%speed(0:o%n - 1) - o%before(1:o%n)) > 0)
   end function approaches

   !> Adds the motions where a step passes the point.
   !!
   !! A step round a fold may pass it twice: away from its beginning and back towards its end.
   pure subroutine note_passages(lines, now, next, known)
      type(lines_type), intent(inout) :: lines
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

   !> Whether a tangent comes from the point within a step.
   pure logical function passes(q, slope, step)
      !> The parameter where the tangent begins, and how fast it grows along it.
      real(wp), intent(in) :: q, slope, step

      passes = q*slope > 0 .and. abs(q) < step*abs(slope)
   end function passes

   !> Adds the motion at the point to which a guess leads, if that is near.
   pure subroutine note(lines, guess, step, known)
      type(lines_type), intent(inout) :: lines
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
         if (i > room) return
         lines%n = i
         lines%unknowns(:, i) = point(:n - 1)
      end if
      known = lines%followed(lines%curve%active(1), i)
      lines%followed(lines%curve%active(1), i) = .true.
   end subroutine note

end module vi_passages
