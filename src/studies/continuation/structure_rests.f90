!> One period of a motion of a structure with rests, stops and friction, for given load phases of
!! its events.
!!
!! The period begins just after a release, or with stops and friction just after any event. A symbol
!! is an impact; the first of impacts that accumulate on one gap, with all that follow and the rest
!! there; a release; or a switch: a stop is touched or left, lets go or presses again, or friction
!! sticks, slips or changes its sense. Positions and velocities at the start and the load phases of
!! all symbols are unknown. The equations state that each gap is closed at its phase, that each
!! contact force is zero at the phase of its release, that a row is at its limit at each switch, and
!! that the state at the end is that at the start. Impacts within an accumulation are simulated.
!!
!! So the equations stay smooth where a gap is touched during a flight, where an approach speed
!! falls to zero and where a contact force touches zero before its release. An accumulation that
!! just fails to complete is still treated as complete, at the impact that comes nearest to that.
!! Friction along the gap that accumulates turns in each bounce, and is simulated with it.
!! Between two switches of one row its mean rate is zero instead of its second value: so a contact,
!! or a flight between two contacts, that becomes infinitely short and then negative is followed as
!! well. If all events are switches of one row, it is at its limit after the longest interval.
!!
!! Without restitution (R = 0) the first impact of an accumulation is also the last one.
!!
!! Of self-excited motions the period T is unknown and the phase is free. Then phases are times over
!! the fixed unit 1/Omega of the load, which has no harmonics, and in place of the phase of the
!! event that begins the period, which is 0, Omega T is the unknown, or its half if half a period is
!! followed.
module vi_structure_rests
   use vi_channels, only: leaving_type, row_derivatives
   use vi_columns, only: solve_columns
   use vi_kinds, only: two_pi, wp
   use vi_modes, only: advance
   use vi_rest_family, only: critical
   use vi_status, only: stat
   use vi_structure, only: check_structure, factor_along, new_regime, opening_at, regime_type, &
      renew_regime, restitution_of, state_of, structure_type, to_pairs
   use vi_structure_map, only: accelerations, apply_flight, from_coordinates, to_coordinates
   use vi_structure_motion, only: impulse_of
   use vi_structure_path, only: change_again, changed, keeps_gaps, keeps_matrices, &
      structure_path_type
   use vi_structure_return, only: closed_type
   use vi_structure_run, only: find_regime, halt_event, impact_event, run_event_type, &
      run_state_type, run_type, simulate_structure, stick_event, whole_periods
   use vi_structure_variation, only: project, tangent_type, through_event
   implicit none (type, external)
   private

   public :: follow_period, follows_itself, keep_regimes, monodromy, symbols_to_state, unit_of_row

   !> Kinds of symbols: an impact, the first impact of an accumulation, a release, a switch.
   integer, parameter, public :: single = 1, first = 2, release = 3, switch = 4

   !> Largest number of impacts in one accumulation.
   integer, parameter :: most_bounces = 2000

   !> The regimes of a family at one place, from which those elsewhere are renewed.
   type, public :: known_type
      type(run_type) :: run
      !> (0:N) and (N) As in `course_type`; not set if the matrices change.
      integer, allocatable :: after(:), stuck(:), bounces(:)
   end type known_type

   !> What the motions of a family with rests, or with stops and friction, have in common.
   type, public :: rests_type
      type(structure_path_type) :: path
      integer :: cycles = 1
      !> (N) Kind and gap of each symbol, the one that begins the period last.
      integer, allocatable :: kinds(:), gaps(:)
      !> (0:N) What is closed after each symbol, with the rest of an accumulation.
      type(closed_type), allocatable :: closed(:)
      !> (N) Of switches: the row of the regime before that is at its limit, and +1 or -1 for its
      !! upper or lower one; what would be closed if friction stuck where it changes its sense, with
      !! its friction as the last element, else nothing.
      integer, allocatable :: rows(:), walls(:)
      type(closed_type), allocatable :: stuck(:)
      !> (N) With stops and friction: what is closed after the first impact of an accumulation.
      type(closed_type), allocatable :: bounces(:)
      !> Units of length and of speed.
      real(wp) :: length = 1, speed = 1
      !> The gap of the event that begins the period: that of the last symbol, or its image.
      integer :: first_gap = 0
      !> Of motions that are their own mirror images, q(t + T/2) = -q(t), the symbols are those of
      !! half a period, at the end of which the state is minus that at the start. Whether they are.
      logical :: halved = .false.
      !> Whether the motions are self-excited, so that the period is unknown.
      logical :: free = .false.
      type(known_type) :: known
   contains
      procedure :: whole_turn, begin_of, end_of_turn
   end type rests_type

   !> A flight or a rest between two events.
   type, public :: segment_type
      !> The symbol that it belongs to, and its number there: 0 of the only one of a symbol; 1, 2 ..
      !! of the flights within an accumulation, 0 of the rest.
      integer :: symbol = 0, number = 0
      !> The regime, time and pairs at its beginning, and its duration.
      integer :: regime = 1
      real(wp) :: time = 0, duration = 0
      real(wp), allocatable :: x(:), v(:)
      !> The gaps in contact at its beginning and at its end besides those that rest, or 0.
      integer :: begins = 0, ends = 0
   end type segment_type

   !> A period.
   type, public :: course_type
      !> The structure under its load at these parameters, the regime after each symbol (0:N), that
      !! of friction that sticks there, and that of the bounces of an accumulation, if they change
      !! it.
      real(wp), allocatable :: shares(:)
      type(run_type) :: run
      integer, allocatable :: after(:), stuck(:), bounces(:)
      !> (2n + N) Residuals: positions and velocities, gaps and forces, in units of the family; and
      !! the derivative (i, j) of residual j by unknown i. The last i is the load phase of the last
      !! symbol at the end of the period alone, where the time of the state at the end is kept.
      real(wp), allocatable :: residuals(:), slopes(:, :)
      !> (N) Approach speeds and impulses of the symbols; 0 of releases, and impulses of switches.
      real(wp), allocatable :: speeds(:), impulses(:)
      !> (N) A measure of the rest after an accumulation, negative where the accumulation is not
      !! completed; 1 for other symbols.
      real(wp), allocatable :: rests(:)
      !> (N) By how much the force that would hold friction where it changes its sense is above the
      !! stick level, in units of the family; of its halts and slips how fast the row comes to its
      !! limit; 1 for other symbols.
      real(wp), allocatable :: excess(:)
      !> What the determinant of the derivative of the period must be: 0 where a direction is lost.
      real(wp) :: volume = 1
      !> (N) Load phases (rad) at which the rests begin.
      real(wp), allocatable :: begins(:)
      !> (2n) The rate of the state at the start by the load phase, in units of the family.
      real(wp), allocatable :: flow(:)
      !> The symbol that is at its limit by itself although it follows another of its row, or 0; and
      !! the derivatives of the value of the first symbol, whose mean rate depends on the start.
      integer :: level = 0
      real(wp), allocatable :: first_slopes(:)
      !> The longest duration of a flight, and the scale with which a negative one is compared.
      real(wp) :: longest = 0, whole = 0
      !> The flights and rests in order.
      type(segment_type), allocatable :: segments(:)
      integer :: parts = 0
      !> Whether the symbols can be followed, so that the other components are defined.
      logical :: exists = .false.
   end type course_type

   !> How far a period has been followed.
   type :: here_type
      integer :: regime = 1
      real(wp) :: phase = 0
      real(wp), allocatable :: x(:), v(:)
      !> (2m, unknowns) Changes of the pairs at this instant.
      real(wp), allocatable :: d(:, :)
      !> The next segment.
      integer :: symbol = 0, begins = 0
      !> The unknown that the load phase is.
      integer :: column = 0
   end type here_type

contains

   !> The load phase (rad) from the start to the end of what is followed.
   pure real(wp) function whole_turn(s)
      !> The family.
      class(rests_type), intent(in) :: s

      whole_turn = merge(0.5_wp, 1.0_wp, s%halved)*two_pi*s%cycles
   end function whole_turn

   !> The load phase (rad) of the event that begins the period.
   pure real(wp) function begin_of(s, unknowns)
      !> The family.
      class(rests_type), intent(in) :: s
      !> As in `follow_period`.
      real(wp), intent(in) :: unknowns(:)

      begin_of = unknowns(size(unknowns) - size(s%kinds) + 1)
      if (s%free) begin_of = 0
   end function begin_of

   !> The load phase (rad) at the end of what is followed.
   pure real(wp) function end_of_turn(s, unknowns)
      !> The family.
      class(rests_type), intent(in) :: s
      !> As in `follow_period`.
      real(wp), intent(in) :: unknowns(:)

      end_of_turn = unknowns(size(unknowns) - size(s%kinds) + 1)
      if (.not. s%free) end_of_turn = end_of_turn + s%whole_turn()
   end function end_of_turn

   !> One period.
   pure subroutine follow_period(s, unknowns, shares, sloped, course)
      !> The family.
      type(rests_type), intent(in) :: s
      !> (2n + N) Positions and velocities just after the release that begins the period, in units
      !! of the family; the load phases of it, or Omega T if that is free, and of all other symbols
      !! in their order (rad).
      real(wp), intent(in) :: unknowns(:)
      !> Each parameter, as a share of the way between its bounds.
      real(wp), intent(in) :: shares(:)
      !> Whether the derivatives with respect to the unknowns are wanted.
      logical, intent(in) :: sloped
      !> In: a period at any parameters, or none. Out: the period.
      type(course_type), intent(inout) :: course
      type(here_type) :: here
      real(wp), allocatable, dimension(:) :: q, rate, acceleration, unit, at_end
      real(wp), allocatable :: p(:, :)
      integer :: columns, i, m, n
      logical :: good

      n = size(s%path%structure%mass, 1)
      m = size(s%kinds)
      call begin_course(s, shares, merge(2*n + m + 1, 0, sloped), course, good)
      if (.not. good) return
      columns = 0
      if (sloped) columns = 2*n + m + 1
      unit = [spread(s%length, 1, n), spread(s%speed, 1, n)]
      q = s%length*unknowns(:n)
      rate = s%speed*unknowns(n + 1:2*n)
      allocate (acceleration(n))
      if (s%free) good = unknowns(2*n + 1) > 0
      if (.not. good) return
      course%whole = course%run%period
      if (s%free) course%whole = unknowns(2*n + 1)/course%run%load%frequency
      course%longest = (s%cycles + 1)*course%whole
      here%regime = course%after(0)
      here%phase = s%begin_of(unknowns)
      here%symbol = m
      here%begins = s%first_gap
      call choose_level(s, unknowns, course%level)
      here%column = 2*n + 1
      associate (regime => course%run%regimes(here%regime))
         allocate (here%x(size(regime%xq, 1)), here%v(size(regime%xq, 1)), here%d(2*size( &
            regime%xq, 1), columns), p(2*n, columns))
         p = 0
         if (sloped) then
            do i = 1, 2*n
               p(i, i) = unit(i)
            end do
         end if
         call hold(course%run%structure, regime, rate, p)
         call to_pairs(regime, here%phase, q, rate, here%x, here%v)
         call accelerations(regime, here%phase, here%x, here%v, acceleration)
         if (sloped) then
            p(:, 2*n + 1) = -[rate, acceleration]/regime%frequency
            course%flow = -p(:, 2*n + 1)/unit
         end if
         call from_coordinates(regime, p, here%d)
      end associate
      do i = 1, m
         associate (phase => merge(s%end_of_turn(unknowns), unknowns(2*n + 1 + modulo(i, m)), &
            i == m), column => 2*n + 1 + modulo(i, m))
            call next_symbol(s, i, phase, column, here, course, good)
         end associate
         if (.not. good) return
      end do
      allocate (at_end(2*n))
      associate (regime => course%run%regimes(here%regime))
         call state_of(regime, here%phase, here%x, here%v, q, rate)
         at_end = [q, rate]
         ! of half a period, the image of the end is the start
         if (s%halved) at_end = -at_end
         course%residuals(:2*n) = at_end/unit - unknowns(:2*n)
         if (sloped) then
            call to_coordinates(regime, here%d, p)
            call accelerations(regime, here%phase, here%x, here%v, acceleration)
            p(:, 2*n + 1) = p(:, 2*n + 1) + [rate, acceleration]/regime%frequency
            if (s%halved) p = -p
            do i = 1, 2*n
               course%slopes(:, i) = p(i, :)/unit(i)
               course%slopes(i, i) = course%slopes(i, i) - 1
            end do
            if (s%free) then
               ! the last event comes at T, and the state at the end is that just after it
               course%slopes(2*n + 1, :) = course%slopes(2*n + m + 1, :)
               course%slopes(2*n + 1, :2*n) = course%slopes(2*n + 1, :2*n) + merge(-1, 1, &
                  s%halved)*[rate, acceleration]/(regime%frequency*unit)
            end if
         end if
      end associate
      course%exists = all(abs(course%residuals) <= huge(1.0_wp))
   end subroutine follow_period

   !> The state just after the release that ends a period, from the state after a symbol.
   pure subroutine symbols_to_state(s, phases, shares, symbol, q, rate, unknowns, good)
      !> The family.
      type(rests_type), intent(in) :: s
      !> (0:N) The load phases of the symbols (rad), that of the last one also at the beginning.
      real(wp), intent(in) :: phases(0:)
      !> The parameters, as shares.
      real(wp), intent(in) :: shares(:)
      !> The symbol, an impact or the first impact of an accumulation.
      integer, intent(in) :: symbol
      !> (n) Coordinates and velocities just after it.
      real(wp), intent(in) :: q(:), rate(:)
      !> (2n + N) The unknowns.
      real(wp), intent(out) :: unknowns(:)
      !> Whether the symbols can be followed.
      logical, intent(out) :: good
      type(course_type) :: course
      type(here_type) :: here
      real(wp), dimension(size(q)) :: q_end, rate_end
      real(wp) :: opening(0:2)
      integer :: i, m, n

      unknowns = 0
      call begin_course(s, shares, 0, course, good)
      if (.not. good) return
      n = size(q)
      m = size(s%kinds)
      course%whole = course%run%period
      course%longest = (s%cycles + 1)*course%whole
      here%regime = course%after(symbol - 1)
      here%phase = phases(symbol)
      here%symbol = symbol
      here%begins = s%gaps(symbol)
      course%level = 0
      associate (regime => course%run%regimes(here%regime))
         allocate (here%x(size(regime%xq, 1)), here%v(size(regime%xq, 1)), here%d(2*size( &
            regime%xq, 1), 0))
         call to_pairs(regime, here%phase, q, rate, here%x, here%v)
      end associate
      if (s%kinds(symbol) == first) then
         associate (direction => course%run%structure%directions(:, s%gaps(symbol)))
            opening = opening_at(course%run%structure, s%gaps(symbol), phases(symbol), &
               course%run%load%frequency)
            call settle_down(s, symbol, max(0.0_wp, opening(1) - dot_product(direction, rate)), &
               here, course, good)
         end associate
         if (.not. good) return
      end if
      do i = symbol + 1, m
         call next_symbol(s, i, phases(i), 1, here, course, good)
         if (.not. good) return
      end do
      call state_of(course%run%regimes(here%regime), here%phase, here%x, here%v, q_end, rate_end)
      unknowns(:2*n) = [q_end/s%length, rate_end/s%speed]
      unknowns(2*n + 1:) = phases(:m - 1)
   end subroutine symbols_to_state

   !> An empty period, with the regimes of its parameters.
   pure subroutine begin_course(s, shares, columns, course, good)
      !> The family.
      type(rests_type), intent(in) :: s
      !> The parameters, as shares.
      real(wp), intent(in) :: shares(:)
      !> Number of unknowns by which derivatives are wanted.
      integer, intent(in) :: columns
      !> In: as in `follow_period`. Out: the period.
      type(course_type), intent(inout) :: course
      !> False if there are no such regimes.
      logical, intent(out) :: good
      integer :: m, n

      course%exists = .false.
      course%parts = 0
      good = allocated(course%shares)
      if (good) good = .not. any(abs(shares - course%shares) > 0)
      if (.not. good) then
         if (allocated(course%shares)) deallocate (course%shares)
         call set_regimes(s, shares, course, good)
         if (.not. good) return
         course%shares = shares
      end if
      n = size(s%path%structure%mass, 1)
      m = size(s%kinds)
      if (allocated(course%slopes)) then
         if (size(course%slopes, 1) /= columns) deallocate (course%slopes)
      end if
      if (.not. allocated(course%slopes)) allocate (course%slopes(columns, 2*n + m))
      if (.not. allocated(course%residuals)) allocate (course%residuals(2*n + m), &
         course%speeds(m), course%impulses(m), course%begins(m), course%rests(m), &
         course%excess(m), course%segments(4*m))
      course%speeds = 0
      course%impulses = 0
      course%begins = 0
      course%rests = 1
      course%excess = 1
      course%volume = 1
   end subroutine begin_course

   !> The structure with its load, and the regime after each symbol: those of other parameters are
   !! renewed where the matrices are the same.
   pure subroutine set_regimes(s, shares, course, good)
      !> The family.
      type(rests_type), intent(in) :: s
      !> The parameters, as shares.
      real(wp), intent(in) :: shares(:)
      !> In: as in `follow_period`. Out: with its run and the regimes after its symbols.
      type(course_type), intent(inout) :: course
      !> False if there are none.
      logical, intent(out) :: good
      integer, allocatable :: set(:)
      ! tables are for the simulation of accumulations
      logical :: simulates
      integer :: i, status

      simulates = any(s%kinds == first)
      if (allocated(s%known%after) .and. .not. allocated(course%after)) then
         course%run = s%known%run
         allocate (course%after(0:size(s%kinds)), source=s%known%after)
         allocate (course%stuck(size(s%kinds)), source=s%known%stuck)
         allocate (course%bounces(size(s%kinds)), source=s%known%bounces)
      end if
      if (.not. (allocated(course%after) .and. keeps_gaps(s%path))) then
         call first_regimes(s, shares, simulates, course, good)
         return
      end if
      associate (run => course%run)
         call change_again(s%path, shares, run%structure, run%load)
         good = run%load%frequency > 0
         if (.not. good) return
         run%period = two_pi/run%load%frequency
         do i = 1, size(run%regimes)
            if (.not. allocated(run%regimes(i)%closed)) exit
            if (i > maxval([course%after, course%stuck, course%bounces])) then
               ! met within an accumulation
               deallocate (run%regimes(i)%closed)
               cycle
            end if
            call renew_regime(run%structure, run%load, run%regimes(i), good)
            if (good) cycle
            set = run%regimes(i)%closed
            call new_regime(run%structure, run%load, set, run%regimes(i), status, simulates, .true.)
            good = status == stat%ok
            if (.not. good) exit
         end do
         if (.not. good) deallocate (course%after, course%stuck, course%bounces)
      end associate
   end subroutine set_regimes

   !> Keeps the regimes at some parameters, for a family that is complete.
   pure subroutine keep_regimes(s, shares)
      !> In and out: the family.
      type(rests_type), intent(inout) :: s
      !> The parameters, as shares.
      real(wp), intent(in) :: shares(:)
      type(course_type) :: course
      logical :: good

      if (.not. keeps_matrices(s%path)) return
      call first_regimes(s, shares, any(s%kinds == first), course, good)
      if (.not. good) return
      s%known%run = course%run
      allocate (s%known%after(0:size(s%kinds)), source=course%after)
      allocate (s%known%stuck(size(s%kinds)), source=course%stuck)
      allocate (s%known%bounces(size(s%kinds)), source=course%bounces)
   end subroutine keep_regimes

   !> The same without any regimes so far.
   pure subroutine first_regimes(s, shares, simulates, course, good)
      !> As in `set_regimes`.
      type(rests_type), intent(in) :: s
      real(wp), intent(in) :: shares(:)
      !> Whether contacts will be searched.
      logical, intent(in) :: simulates
      !> In and out: the period.
      type(course_type), intent(inout) :: course
      !> False if there are none.
      logical, intent(out) :: good
      integer :: after(0:size(s%kinds)), i, status
      integer, dimension(size(s%kinds)) :: bounces, stuck

      good = .false.
      if (allocated(course%after)) deallocate (course%after, course%stuck, course%bounces)
      associate (run => course%run)
         call changed(s%path, shares, run%structure, run%load)
         if (.not. run%load%frequency > 0) return
         run%period = two_pi/run%load%frequency
         call check_structure(run%structure, status)
         if (status /= stat%ok) return
         if (allocated(run%regimes)) deallocate (run%regimes)
         allocate (run%regimes(count_regimes(s)))
         call find_regime(run, [integer :: ], i, status, simulates, .true.)
         if (status /= stat%ok) return
         call find_regime(run, s%closed(0)%set, after(0), status, simulates, .true.)
         if (status /= stat%ok) return
         stuck = 0
         bounces = 0
         do i = 1, size(s%kinds)
            call find_regime(run, s%closed(i)%set, after(i), status, simulates, .true.)
            if (status /= stat%ok) return
            if (.not. allocated(s%stuck)) cycle
            if (size(s%stuck(i)%set) > 0) call find_regime(run, s%stuck(i)%set, stuck(i), &
               status, simulates, .true.)
            if (status == stat%ok .and. s%kinds(i) == first) call find_regime(run, &
               s%bounces(i)%set, bounces(i), status, simulates, .true.)
            if (status /= stat%ok) return
         end do
      end associate
      allocate (course%after(0:size(s%kinds)), source=after)
      allocate (course%stuck(size(s%kinds)), source=stuck)
      allocate (course%bounces(size(s%kinds)), source=bounces)
      good = .true.
   end subroutine first_regimes

   !> Number of regimes of a family, with that in which nothing is closed.
   pure integer function count_regimes(s) result(n)
      !> The family.
      type(rests_type), intent(in) :: s
      integer :: i

      n = 1
      do i = 0, size(s%kinds)
         if (size(s%closed(i)%set) == 0) cycle
         if (.not. any_before(s%closed(i)%set, i)) n = n + 1
      end do
      if (allocated(s%stuck)) n = n + count(s%kinds == first) + count([(size(s%stuck(i)%set) > 0, &
         i=1, size(s%stuck))])
   contains
      !> Whether a set is also one before.
      pure logical function any_before(set, i)
         !> The set, and its number.
         integer, intent(in) :: set(:), i
         integer :: j

         any_before = .false.
         do j = 0, i - 1
            if (size(s%closed(j)%set) /= size(set)) cycle
            any_before = any_before .or. all(s%closed(j)%set == set)
         end do
      end function any_before
   end function count_regimes

   !> Advances to a symbol and through it.
   pure subroutine next_symbol(s, symbol, phase, column, here, course, good)
      !> The family.
      type(rests_type), intent(in) :: s
      !> Its number.
      integer, intent(in) :: symbol
      !> Its load phase (rad), and the number of the unknown that it is.
      real(wp), intent(in) :: phase
      integer, intent(in) :: column
      !> In and out: how far the period has been followed.
      type(here_type), intent(inout) :: here
      !> In and out: the period.
      type(course_type), intent(inout) :: course
      !> Whether it can be followed.
      logical, intent(out) :: good
      real(wp), dimension(size(course%run%structure%mass, 1)) :: q, rate, acceleration, closing
      real(wp), allocatable, dimension(:) :: x, v, by
      real(wp), allocatable :: p(:, :), before(:, :)
      real(wp) :: turned(size(here%d, 2))
      real(wp) :: d(0:3), impulse, opening(0:2), restitution, slope, time, unit
      integer :: columns, equation, gap, i, n, row
      real(wp) :: steepness
      logical :: impacts

      n = size(q)
      columns = size(here%d, 2)
      gap = s%gaps(symbol)
      equation = 2*n + symbol
      good = .false.
      steepness = 1
      associate (run => course%run, regime => course%run%regimes(here%regime), &
         structure => course%run%structure, frequency => course%run%load%frequency)
         time = (phase - here%phase)/frequency
         ! beyond an exchange of two events, and where a rest has vanished, it is negative
         if (.not. (time > -0.25_wp*course%whole .and. time < course%longest)) return
         allocate (x, source=here%x)
         allocate (v, source=here%v)
         if (s%kinds(symbol) == switch) then
            allocate (before, source=here%d)
         else
            allocate (before(0, 0))
         end if
         call add_segment(course, here, 0, time, gap)
         call advance(regime%modes, time, here%x, here%v, x, v)
         course%volume = course%volume*exp(-2*sum(regime%modes%damping)*time)
         if (columns > 0) call apply_flight(regime, time, here%d)
         call state_of(regime, phase, x, v, q, rate)
         call accelerations(regime, phase, x, v, acceleration)
         allocate (p(2*n, columns))
         if (s%kinds(symbol) == switch) call set_switch(s, symbol, phase, column, [x, v], before, &
            here, course, steepness)
         here%phase = phase
         here%symbol = symbol
         here%begins = gap
         here%column = column
         impacts = s%kinds(symbol) < release
         if (s%kinds(symbol) == release) then
            row = structure%channels + findloc(regime%resting, gap, dim=1)
            call row_derivatives(regime, x, v, phase, row, d)
            unit = structure%effective(gap)*s%speed*frequency
            course%residuals(equation) = d(0)/unit
            if (columns > 0) then
               by = matmul(regime%position(row, :), here%d(:size(x), :)) + matmul( &
                  regime%velocity(row, :), here%d(size(x) + 1:, :))
               by(column) = by(column) + d(1)/frequency
               if (symbol == size(s%kinds)) by(columns) = d(1)/frequency
               course%slopes(:, equation) = by/unit
            end if
            call measure_rest(s, symbol, phase, course)
         end if
         call to_coordinates(regime, here%d, p)
         if (columns > 0) then
            p(:, column) = p(:, column) + [rate, acceleration]/frequency
            if (symbol == size(s%kinds)) p(:, columns) = [rate, acceleration]/frequency
         end if
         restitution = 0
         ! the change of the instant with each unknown, by which a wall that moves has moved on
         turned = 0
         if (columns > 0) then
            turned(column) = 1/frequency
            if (symbol == size(s%kinds)) turned(columns) = 1/frequency
         end if
         if (impacts) then
            associate (direction => structure%directions(:, gap), mobility => &
               structure%mobility(:, gap))
               opening = opening_at(structure, gap, phase, frequency)
               course%residuals(equation) = (dot_product(direction, q) - opening(0))/s%length
               course%speeds(symbol) = dot_product(direction, rate) - opening(1)
               associate (speed => course%speeds(symbol))
                  call impulse_of(structure, gap, speed, impulse, slope)
                  call restitution_of(structure, gap, max(0.0_wp, speed), restitution, d(0))
                  course%volume = course%volume*restitution*(restitution + d(0)*speed)
               end associate
               course%impulses(symbol) = impulse
               rate = rate - impulse*mobility
               if (columns > 0) course%slopes(:, equation) = (matmul(direction, p(:n, :)) &
                  - opening(1)*turned)/s%length
               do i = 1, columns
                  p(n + 1:, i) = p(n + 1:, i) - slope*(dot_product(direction, p(n + 1:, i)) &
                     - opening(2)*turned(i))*mobility
               end do
               if (s%kinds(symbol) == first) then
                  ! an accumulation begins exactly at its wall
                  closing = structure%effective(gap)*mobility
                  q = q - closing*(dot_product(direction, q) - opening(0))
                  do i = 1, columns
                     p(:n, i) = p(:n, i) - closing*(dot_product(direction, p(:n, i)) &
                        - opening(1)*turned(i))
                  end do
               end if
            end associate
         end if
      end associate
      if (s%kinds(symbol) /= first) then
         here%regime = course%after(symbol)
      else if (course%bounces(symbol) > 0) then
         here%regime = course%bounces(symbol)
      end if
      associate (regime => course%run%regimes(here%regime), frequency => &
         course%run%load%frequency)
         deallocate (here%x, here%v, here%d)
         allocate (here%x(size(regime%xq, 1)), here%v(size(regime%xq, 1)), &
            here%d(2*size(regime%xq, 1), columns))
         call hold(course%run%structure, regime, rate, p)
         call to_pairs(regime, phase, q, rate, here%x, here%v)
         call accelerations(regime, phase, here%x, here%v, acceleration)
         if (columns > 0) then
            p(:, column) = p(:, column) - [rate, acceleration]/frequency
            if (symbol == size(s%kinds)) p(:, columns) = p(:, columns) - [rate, acceleration] &
               /frequency
         end if
         call from_coordinates(regime, p, here%d)
      end associate
      good = .true.
      if (s%kinds(symbol) == switch) call change_volume(s, symbol, phase, steepness, here, course)
      if (s%kinds(symbol) == first) course%volume = 0
      if (s%kinds(symbol) == first) call settle_down(s, symbol, restitution*course%speeds(symbol), &
         here, course, good)
   end subroutine next_symbol

   !> The equation of a switch, and what is known of it.
   pure subroutine set_switch(s, symbol, phase, column, pairs, before, here, course, steepness)
      !> The family.
      type(rests_type), intent(in) :: s
      !> Its number, its load phase (rad), and the number of the unknown that that is.
      integer, intent(in) :: symbol, column
      real(wp), intent(in) :: phase
      !> (2m) The pairs just before it.
      real(wp), intent(in) :: pairs(:)
      !> (2m, unknowns) Changes of the pairs at the beginning of the flight.
      real(wp), intent(in) :: before(:, :)
      !> The beginning of the flight, with changes at its end.
      type(here_type), intent(in) :: here
      !> In and out: the period.
      type(course_type), intent(inout) :: course
      !> The rate of its row.
      real(wp), intent(out) :: steepness
      !> Shortest time, in units of the regime, over which a mean rate is a quotient.
      real(wp), parameter :: short = 1.0e-5_wp
      real(wp), dimension(size(before, 2)) :: by, by_begin
      real(wp), dimension(size(here%x)) :: x, v
      real(wp), dimension(0:3) :: d, d_begin
      real(wp) :: limit, time, unit
      integer :: equation, m, row

      associate (structure => course%run%structure, frequency => course%run%load%frequency, &
         regime => course%run%regimes(here%regime))
         m = size(here%x)
         row = s%rows(symbol)
         equation = size(course%residuals) - size(s%kinds) + symbol
         limit = merge(regime%upper(row), regime%lower(row), s%walls(symbol) > 0)
         x = pairs(:m)
         v = pairs(m + 1:)
         call row_derivatives(regime, x, v, phase, row, d)
         steepness = d(1)
         course%speeds(symbol) = 0
         if (structure%elastic(s%gaps(symbol))) course%speeds(symbol) = &
            abs(closing_speed(regime, phase, x, v))
         unit = unit_of_row(s, structure, row, s%gaps(symbol), frequency)
         by = matmul(regime%position(row, :), here%d(:m, :)) + matmul(regime%velocity(row, :), &
            here%d(m + 1:, :))
         if (size(by) > 0) then
            by(column) = by(column) + d(1)/frequency
            if (symbol == size(s%kinds)) by(size(by)) = d(1)/frequency
         end if
         if (symbol == 1) course%first_slopes = by/unit
         if (.not. follows_itself(s, symbol) .or. symbol == course%level) then
            course%residuals(equation) = (d(0) - limit)/unit
            if (size(by) > 0) course%slopes(:, equation) = by/unit
         else
            time = (phase - here%phase)/frequency
            call row_derivatives(regime, here%x, here%v, here%phase, row, d_begin)
            unit = unit*frequency
            if (abs(time) > short*regime%unit) then
               course%residuals(equation) = (d(0) - d_begin(0))/(time*unit)
               if (size(by) > 0) then
                  by_begin = matmul(regime%position(row, :), before(:m, :)) &
                     + matmul(regime%velocity(row, :), before(m + 1:, :))
                  by_begin(here%column) = by_begin(here%column) + d_begin(1)/frequency
                  by = (by - by_begin)/time
                  by(column) = by(column) - course%residuals(equation)*unit/(time*frequency)
                  by(here%column) = by(here%column) + course%residuals(equation)*unit &
                     /(time*frequency)
                  if (s%free .and. symbol == size(s%kinds)) by(size(by)) = by(size(by)) &
                     - course%residuals(equation)*unit/(time*frequency)
               end if
            else
               course%residuals(equation) = (d_begin(1) + 0.5_wp*time*(d_begin(2) &
                  + time*d_begin(3)/3))/unit
               if (size(by) > 0) then
                  by = matmul(regime%rate_position(row, :), before(:m, :)) &
                     + matmul(regime%rate_velocity(row, :), before(m + 1:, :))
                  by(column) = by(column) + 0.5_wp*d_begin(2)/frequency
                  by(here%column) = by(here%column) + 0.5_wp*d_begin(2)/frequency
                  if (symbol == size(s%kinds)) by(size(by)) = 0.5_wp*d_begin(2)/frequency
               end if
            end if
            if (size(by) > 0) course%slopes(:, equation) = by/unit
         end if
         if (course%stuck(symbol) == 0) then
            if (structure%rubs(s%gaps(symbol))) course%excess(symbol) = s%walls(symbol)*steepness/ &
               (unit_of_row(s, structure, row, s%gaps(symbol), frequency)*frequency)
            return
         end if
         call find_excess(s, symbol, phase, x, v, regime, course)
      end associate
   contains
      !> The approach speed of the stop.
      pure real(wp) function closing_speed(regime, phase, x, v) result(speed)
         !> The regime, the load phase (rad), and the pairs.
         type(regime_type), intent(in) :: regime
         real(wp), intent(in) :: phase
         real(wp), contiguous, intent(in) :: x(:), v(:)
         real(wp), dimension(size(course%run%structure%mass, 1)) :: q, rate
         real(wp) :: opening(0:2)

         call state_of(regime, phase, x, v, q, rate)
         opening = opening_at(course%run%structure, s%gaps(symbol), phase, regime%frequency)
         speed = dot_product(course%run%structure%directions(:, s%gaps(symbol)), rate) - opening(1)
      end function closing_speed
   end subroutine set_switch

   !> Multiplies the factor of volumes by that of a switch: the rate of the row after it over that
   !! before it, or 0 where friction sticks from now on.
   pure subroutine change_volume(s, symbol, phase, rate, here, course)
      !> The family.
      type(rests_type), intent(in) :: s
      !> The switch, its load phase (rad), and the rate of its row before it.
      integer, intent(in) :: symbol
      real(wp), intent(in) :: phase, rate
      !> The place just after it.
      type(here_type), intent(in) :: here
      !> In and out: the period.
      type(course_type), intent(inout) :: course
      real(wp) :: d(0:3)

      associate (structure => course%run%structure, row => s%rows(symbol))
         if (row > structure%channels) return
         call row_derivatives(course%run%regimes(here%regime), here%x, here%v, phase, row, d)
         course%volume = course%volume*(d(1)/rate)
         if (.not. structure%rubs(s%gaps(symbol))) return
         if (any(s%closed(symbol)%set == s%gaps(symbol))) course%volume = 0
      end associate
   end subroutine change_volume

   !> By how much the force that would hold friction where it changes its sense is above the stick
   !! level.
   pure subroutine find_excess(s, symbol, phase, x, v, regime, course)
      !> The family.
      type(rests_type), intent(in) :: s
      !> The switch, its load phase (rad), and (m) the pairs before it, with their regime.
      integer, intent(in) :: symbol
      real(wp), intent(in) :: phase, x(:), v(:)
      type(regime_type), intent(in) :: regime
      !> In and out: the period.
      type(course_type), intent(inout) :: course
      real(wp), dimension(size(course%run%structure%mass, 1)) :: q, rate
      real(wp), allocatable, dimension(:) :: x_held, v_held
      real(wp) :: d(0:3), none(2*size(q), 0)
      integer :: row

      associate (held => course%run%regimes(course%stuck(symbol)), structure => &
         course%run%structure, friction => s%gaps(symbol))
         row = structure%channels + findloc(held%held, friction, dim=1)
         call state_of(regime, phase, x, v, q, rate)
         call hold(structure, held, rate, none)
         allocate (x_held(size(held%xq, 1)), v_held(size(held%xq, 1)))
         call to_pairs(held, phase, q, rate, x_held, v_held)
         call row_derivatives(held, x_held, v_held, phase, row, d)
         ! it goes on to the other side than that from which it came
         course%excess(symbol) = (s%walls(symbol)*d(0) - held%upper(row)) &
            /unit_of_row(s, structure, row, friction, course%run%load%frequency)
      end associate
   end subroutine find_excess

   !> Whether a switch concerns the same row and limit as the one before it; the one before the
   !! first is the event that begins the period.
   pure logical function follows_itself(s, symbol) result(does)
      !> The family.
      type(rests_type), intent(in) :: s
      !> The switch.
      integer, intent(in) :: symbol
      integer :: before, gap

      before = modulo(symbol - 2, size(s%kinds)) + 1
      gap = s%gaps(before)
      ! that event is the last symbol, or its mirror image
      if (symbol == 1) gap = s%first_gap
      does = s%kinds(before) == switch .and. gap == s%gaps(symbol) .and. &
         s%rows(symbol) <= s%path%structure%channels
      if (.not. does) return
      does = s%rows(before) == s%rows(symbol)
      if (gap /= s%gaps(before)) does = all(s%rows([before, symbol]) == &
         s%path%structure%channel([s%gaps(before), gap]))
   end function follows_itself

   !> The symbol that is at its limit by itself if all others have mean rates: after the longest
   !! interval, since no interval may be one whose duration passes zero.
   pure subroutine choose_level(s, unknowns, level)
      !> The family.
      type(rests_type), intent(in) :: s
      !> As in `follow_period`.
      real(wp), intent(in) :: unknowns(:)
      !> The symbol; 0 where there is no need of one.
      integer, intent(out) :: level
      real(wp) :: phases(0:size(s%kinds))
      integer :: i, m

      level = 0
      m = size(s%kinds)
      if (any(s%kinds /= switch)) return
      if (.not. all([(follows_itself(s, i), i=1, m)])) return
      phases = [s%begin_of(unknowns), unknowns(size(unknowns) - m + 2:), s%end_of_turn(unknowns)]
      level = maxloc(phases(1:) - phases(:m - 1), dim=1)
   end subroutine choose_level

   !> The unit of a row: of a position, of a speed of friction, or of a force.
   pure real(wp) function unit_of_row(s, structure, row, number, frequency) result(unit)
      !> The family.
      type(rests_type), intent(in) :: s
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The row, and the gap, stop or friction that it concerns.
      integer, intent(in) :: row, number
      !> The frequency of the load.
      real(wp), intent(in) :: frequency

      if (row > structure%channels) then
         unit = max(structure%effective(number)*s%speed*frequency, &
            structure%laws(number)%numbers(2))
      else if (structure%rubs(number)) then
         unit = s%speed
      else if (row == structure%channel(number)) then
         unit = s%length
      else
         unit = structure%laws(number)%numbers(1)*s%length + structure%laws(number)%numbers(2) &
            *s%speed
      end if
   end function unit_of_row

   !> Sets the speed of friction that sticks to that of its belt, and removes its changes.
   pure subroutine hold(structure, regime, rate, p)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> (n) In and out: velocities.
      real(wp), intent(inout) :: rate(:)
      !> (2n, columns) In and out: changes of coordinates and velocities.
      real(wp), intent(inout) :: p(:, :)
      real(wp) :: columns(size(rate), 1), speeds(size(regime%held))
      integer :: i, n

      if (size(regime%held) == size(regime%resting)) return
      n = size(rate)
      speeds = 0
      do i = size(regime%resting) + 1, size(speeds)
         speeds(i) = structure%laws(regime%held(i))%numbers(3)
      end do
      columns(:, 1) = rate
      call project(structure, regime%held, columns, speeds)
      rate = columns(:, 1)
      call project(structure, regime%held, p(n + 1:, :))
   end subroutine hold

   !> Notes the flight or rest that begins here.
   pure subroutine add_segment(course, here, number, duration, ends)
      !> In and out: the period.
      type(course_type), intent(inout) :: course
      !> Where it begins.
      type(here_type), intent(in) :: here
      !> Its number within its symbol, and its duration.
      integer, intent(in) :: number
      real(wp), intent(in) :: duration
      !> The gap in contact at its end.
      integer, intent(in) :: ends
      type(segment_type), allocatable :: more(:)

      if (course%parts == size(course%segments)) then
         allocate (more(2*course%parts + 8))
         more(:course%parts) = course%segments
         call move_alloc(more, course%segments)
      end if
      course%parts = course%parts + 1
      course%segments(course%parts) = segment_type(here%symbol, number, here%regime, here%phase/ &
         course%run%load%frequency, duration, here%x, here%v, here%begins, ends)
   end subroutine add_segment

   !> From just after the first impact of an accumulation to the beginning of the rest.
   pure subroutine settle_down(s, symbol, departure, here, course, good)
      !> The family.
      type(rests_type), intent(in) :: s
      !> The symbol.
      integer, intent(in) :: symbol
      !> The departure speed.
      real(wp), intent(in) :: departure
      !> In and out: how far the period has been followed.
      type(here_type), intent(inout) :: here
      !> In and out: the period.
      type(course_type), intent(inout) :: course
      !> Whether the accumulation is completed, or nearly.
      logical, intent(out) :: good
      !> An accumulation comes near to completion if what is left of it changes the state by less
      !! than this, in units of length.
      real(wp), parameter :: coarse = 1.0e-6_wp
      type(run_state_type) :: state
      type(run_event_type), allocatable :: events(:)
      type(tangent_type) :: tangent
      logical :: cut
      real(wp), allocatable, dimension(:, :) :: lower, upper
      real(wp) :: cost, end_time, excess, least, opening(0:2), speed, unused
      integer :: best, bounces(2), gap, i, n, number, status

      good = .false.
      gap = s%gaps(symbol)
      if (departure < 0) return
      number = here%regime
      bounces = number
      excess = 1
      least = huge(1.0_wp)
      allocate (events(0:64))
      associate (run => course%run, after => course%after(symbol))
         state%cycle = whole_periods(run, here%phase/run%load%frequency)
         state%elapsed = here%phase/run%load%frequency - real(state%cycle, wp)*run%period
         state%regime = number
         state%x = here%x
         state%v = here%v
         allocate (state%q(size(run%structure%mass, 1)), state%rate(size(run%structure%mass, 1)))
         call state_of(run%regimes(number), here%phase, here%x, here%v, state%q, state%rate)
         events(0) = run_event_type(impact_event, gap, number, state%cycle, state%elapsed, &
            departure, 0.0_wp, state%x, state%v, state%q, state%rate)
         best = 0
         n = 0
         if (departure > 0) then
            call find_turned(run, number, gap, bounces(2), status)
            if (status /= stat%ok) return
            ! other gaps are examined later
            allocate (upper(size(run%regimes(number)%upper), 2), source=0.0_wp)
            allocate (lower, source=upper)
            do i = 1, merge(1, 2, bounces(2) == number)
               upper(:, i) = run%regimes(bounces(i))%upper
               lower(:, i) = run%regimes(bounces(i))%lower
               call watch_one(run%structure, gap, run%regimes(bounces(i)))
            end do
            state%leaving = leaving_type(run%structure%channel(gap), run%structure%wall(gap), &
               departure)
            do
               if (events(n)%kind == impact_event) then
                  call cost_of(run, events(n), gap, merge(departure, 0.0_wp, n == 0), cost)
                  if (cost < least) then
                     least = cost
                     best = n
                  end if
                  ! it was nearly completed, and now the bounces become longer again
                  if (least <= coarse*s%length .and. 1.0e-3_wp*cost > least) exit
               end if
               if (n == most_bounces .or. seconds(events(0), events(n)) > s%cycles*run%period) exit
               if (n == ubound(events, 1)) call grow(events)
               end_time = state%elapsed
               call simulate_structure(run, state, state%cycle + s%cycles + 1, end_time, &
                  events(n + 1:n + 1), i, status)
               if (.not. (i == 1 .and. (status == stat%more_events .or. status == stat%ok))) exit
               n = n + 1
               if (events(n)%kind == stick_event) then
                  best = n
                  exit
               end if
               if (events(n)%kind > halt_event .and. bounces(2) /= number) then
                  ! friction along the gap turns in each bounce
                  if (events(n)%regime == bounces(2)) excess = min(excess, excess_at(run, gap, &
                     events(n)))
                  cycle
               end if
               if (events(n)%kind /= impact_event .or. events(n)%gap /= gap) exit
            end do
            do i = 1, merge(1, 2, bounces(2) == number)
               run%regimes(bounces(i))%upper = upper(:, i)
               run%regimes(bounces(i))%lower = lower(:, i)
            end do
            if (events(best)%kind /= stick_event .and. .not. least <= coarse*s%length) return
         end if
         n = best
         cut = events(n)%kind /= stick_event
         if (cut) then
            ! the rest begins at once
            if (n == ubound(events, 1)) call grow(events)
            n = n + 1
            events(n) = events(n - 1)
            events(n)%kind = stick_event
            events(n)%regime = after
            opening = opening_at(run%structure, gap, run%load%frequency*events(n)%elapsed, &
               run%load%frequency)
            associate (mobility => run%structure%mobility(:, gap), rate => events(n)%rate)
               rate = rate - mobility*run%structure%effective(gap)*(dot_product( &
                  run%structure%directions(:, gap), rate) - opening(1))
            end associate
            associate (regime => run%regimes(after))
               deallocate (events(n)%x, events(n)%v)
               allocate (events(n)%x(size(regime%xq, 1)), events(n)%v(size(regime%xq, 1)))
               call to_pairs(regime, run%load%frequency*events(n)%elapsed, events(n)%q, &
                  events(n)%rate, events(n)%x, events(n)%v)
            end associate
         end if
         events(n)%regime = after
         if (size(here%d, 2) > 0) then
            tangent%number = number
            tangent%cycle = events(0)%cycle
            tangent%elapsed = events(0)%elapsed
            tangent%x = here%x
            tangent%v = here%v
            tangent%d = here%d
            allocate (tangent%later(size(here%d, 2)), source=0.0_wp)
            do i = 1, n
               call through_event(run, events(i), tangent, status)
               if (status /= stat%ok) return
            end do
            call move_alloc(tangent%d, here%d)
         else
            deallocate (here%d)
            allocate (here%d(2*size(events(n)%x), 0))
         end if
         do i = 1, n - 1
            call add_segment(course, here, i, seconds(events(i - 1), events(i)), events(i)%gap)
            call go_to(run, events(i), here)
            here%begins = events(i)%gap
         end do
         here%begins = gap
         ! what remains of the accumulation is no flight of its own
         call go_to(run, events(n), here)
         course%begins(symbol) = here%phase
         if (bounces(2) /= number) then
            ! friction holds before it is completed, or would hold the last of the bounces
            if (cut) excess = -(least/s%length)**(1.0_wp/3)
            if (.not. cut) excess = min(excess, excess_at(run, gap, events(n)))
            course%rests(symbol) = excess
            good = .true.
            return
         end if
         ! the last departure speed, over that of the critical accumulation: see `measure_rest`
         speed = 0
         if (n > 1 .or. departure > 0) then
            do i = n - 1, 1, -1
               if (events(i)%kind == impact_event) exit
            end do
            if (i == 0) then
               speed = departure
            else
               call restitution_of(run%structure, gap, events(i)%speed, speed, unused)
               speed = speed*events(i)%speed
            end if
            call closing_of(run, events(i), gap, unused)
            if (unused > 0) speed = speed/unused
            if (.not. unused > 0) return
         end if
         course%rests(symbol) = speed
      end associate
      good = .true.
   contains
      !> Time from one event to the next one.
      pure real(wp) function seconds(from, to)
         !> The events.
         type(run_event_type), intent(in) :: from, to

         seconds = real(to%cycle - from%cycle, wp)*course%run%period + (to%elapsed - from%elapsed)
      end function seconds

      !> What is left of an accumulation after an impact: the change of the state by cutting it off.
      pure subroutine cost_of(run, event, gap, start, cost)
         !> The run.
         type(run_type), intent(in) :: run
         !> The impact; for the first one its departure speed is `start`.
         type(run_event_type), intent(in) :: event
         integer, intent(in) :: gap
         real(wp), intent(in) :: start
         !> A length.
         real(wp), intent(out) :: cost
         real(wp) :: closing, restitution, slope, speed

         call restitution_of(run%structure, gap, event%speed, restitution, slope)
         speed = restitution*event%speed
         if (start > 0) speed = start
         call closing_of(run, event, gap, closing)
         cost = huge(1.0_wp)
         if (closing > 1.0e-12_wp*speed/run%regimes(event%regime)%unit) cost = speed*(speed/ &
            closing)**2/max(1.0e-3_wp, 1 - restitution**3)
      end subroutine cost_of

      !> Makes room for more events.
      pure subroutine grow(events)
         !> In and out: the events.
         type(run_event_type), allocatable, intent(inout) :: events(:)
         type(run_event_type), allocatable :: more(:)

         allocate (more(0:4*ubound(events, 1)))
         more(:ubound(events, 1)) = events
         call move_alloc(more, events)
      end subroutine grow
   end subroutine settle_down

   !> The regime in the second part of a bounce: friction along the gap slips to the other side.
   pure subroutine find_turned(run, number, gap, other, status)
      !> In and out: a regime may be added.
      type(run_type), intent(inout) :: run
      !> The regime after an impact, and the gap.
      integer, intent(in) :: number, gap
      !> The regime; the same one without such friction.
      integer, intent(out) :: other
      !> `stat%ok`, or as in `new_regime`.
      integer, intent(out) :: status
      integer, allocatable :: set(:)
      integer :: j

      status = stat%ok
      other = number
      if (.not. rubs_along(run%structure, gap)) return
      allocate (set, source=run%regimes(number)%closed)
      do j = 1, size(run%structure%openings)
         if (.not. abs(factor_along(run%structure, j, gap)) > 0) cycle
         if (any(set == -j)) then
            set = pack(set, set /= -j)
         else
            set = [pack(set, set < -j), -j, pack(set, set > -j)]
         end if
      end do
      call find_regime(run, set, other, status)
   end subroutine find_turned

   !> By how much the force that closes a gap is above what friction along it can hold, as a share
   !! of both: where friction turns in the bounces of an accumulation, and where the rest begins.
   pure real(wp) function excess_at(run, gap, event) result(excess)
      !> The run.
      type(run_type), intent(in) :: run
      !> The gap.
      integer, intent(in) :: gap
      !> The event.
      type(run_event_type), intent(in) :: event
      real(wp) :: d(0:3), force, levels(2)
      integer :: j, rest

      associate (structure => run%structure, regime => run%regimes(event%regime))
         levels = 0
         do j = 1, size(structure%openings)
            levels = levels + abs(factor_along(structure, j, gap))*structure%laws(j)%numbers(:2)
         end do
         rest = findloc(regime%resting, gap, dim=1)
         if (rest > 0) then
            call row_derivatives(regime, event%x, event%v, run%load%frequency*event%elapsed, &
               structure%channels + rest, d)
            force = d(0) - levels(2)
         else
            call closing_of(run, event, gap, force)
            force = structure%effective(gap)*force + levels(1)
         end if
         excess = force - levels(2)
         if (abs(excess) > 0) excess = excess/(abs(force) + levels(2))
      end associate
   end function excess_at

   !> Moves the place to an event.
   pure subroutine go_to(run, event, here)
      !> The run.
      type(run_type), intent(in) :: run
      !> The event.
      type(run_event_type), intent(in) :: event
      !> In and out: the place; its changes are not moved.
      type(here_type), intent(inout) :: here

      here%phase = (real(event%cycle, wp)*run%period + event%elapsed)*run%load%frequency
      here%regime = event%regime
      here%x = event%x
      here%v = event%v
   end subroutine go_to

   !> The acceleration with which a gap closes after an impact on it.
   pure subroutine closing_of(run, event, gap, closing)
      !> The run.
      type(run_type), intent(in) :: run
      !> The impact.
      type(run_event_type), intent(in) :: event
      !> The gap.
      integer, intent(in) :: gap
      !> The acceleration.
      real(wp), intent(out) :: closing
      real(wp) :: d(0:3)

      call row_derivatives(run%regimes(event%regime), event%x, event%v, &
         run%load%frequency*event%elapsed, run%structure%channel(gap), d)
      closing = run%structure%wall(gap)*d(2)
   end subroutine closing_of

   !> Ignores all gaps but one and the friction along it, and the contact forces.
   pure subroutine watch_one(structure, gap, regime)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The gap.
      integer, intent(in) :: gap
      !> In and out: the regime.
      type(regime_type), intent(inout) :: regime
      integer :: row

      do row = 1, size(regime%upper)
         if (.not. is_watched(regime%upper_gap(row))) regime%upper(row) = huge(1.0_wp)
         if (.not. is_watched(regime%lower_gap(row))) regime%lower(row) = -huge(1.0_wp)
      end do
   contains
      !> Whether a limit is that of the gap, or of friction along it.
      pure logical function is_watched(number)
         !> What the limit concerns; negative for a force, and 0 where there is none.
         integer, intent(in) :: number

         is_watched = number == gap
         if (number > 0 .and. structure%has_friction) is_watched = is_watched .or. &
            abs(factor_along(structure, number, gap)) > 0
      end function is_watched
   end subroutine watch_one

   !> The measure of the rest that ends with a release.
   !!
   !! It is a power of its duration, times a number that falls through zero where the accumulation
   !! just fails to complete: with both it passes zero almost linearly.
   pure subroutine measure_rest(s, symbol, phase, course)
      !> The family.
      type(rests_type), intent(in) :: s
      !> The release, and its load phase (rad).
      integer, intent(in) :: symbol
      real(wp), intent(in) :: phase
      !> In and out: the period; the measure of the accumulation is set.
      type(course_type), intent(inout) :: course
      real(wp) :: duration, left, limit, power, restitution, slope
      integer :: i

      do i = symbol - 1, 1, -1
         if (s%kinds(i) == first .and. s%gaps(i) == s%gaps(symbol)) exit
      end do
      if (i == 0) return
      associate (frequency => course%run%load%frequency)
         call restitution_of(course%run%structure, s%gaps(symbol), 0.0_wp, restitution, slope)
         duration = phase - course%begins(i)
         ! time that the last departure speed would need, over the closing acceleration
         left = frequency*course%rests(i)
         if (.not. restitution > 0) then
            course%rests(i) = duration
            return
         end if
         ! friction along the gap has its own measure
         if (rubs_along(course%run%structure, s%gaps(symbol))) return
         call critical(restitution, limit, power)
         if (.not. duration > 0) then
            course%rests(i) = -abs(duration)**power
         else
            course%rests(i) = (1 - left/duration/limit)*duration**power
         end if
      end associate
   end subroutine measure_rest

   !> Whether friction acts along a gap.
   pure logical function rubs_along(structure, gap)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The gap.
      integer, intent(in) :: gap
      integer :: j

      rubs_along = structure%has_friction
      if (rubs_along) rubs_along = any([(abs(factor_along(structure, j, gap)) > 0, j=1, &
         size(structure%openings))])
   end function rubs_along

   !> The derivative of the map of a period at fixed times, in units of the family.
   pure subroutine monodromy(s, course, p, good)
      !> The family.
      type(rests_type), intent(in) :: s
      !> The period, with its derivatives.
      type(course_type), intent(in) :: course
      !> (2n, 2n)
      real(wp), intent(out) :: p(:, :)
      !> False where an approach speed is zero.
      logical, intent(out) :: good
      real(wp), allocatable :: by(:, :), events(:, :)
      integer, allocatable :: moves(:)
      integer :: i, m, n, status

      n = size(p, 1)
      m = size(s%kinds)
      good = course%exists
      if (.not. good) return
      p = transpose(course%slopes(:n, :n))
      do i = 1, n
         p(i, i) = p(i, i) + 1
      end do
      ! accelerations do not jump at a release without friction
      if (s%kinds(m) == release .and. .not. rubs_along(course%run%structure, s%gaps(m))) m = m - 1
      moves = pack([(i, i=1, m)], .not. [(is_vanishing(s, course, i), i=1, m)])
      m = size(moves)
      if (m == 0) return
      ! the phases of the symbols follow from the state at the start
      allocate (by(m, n), events(m, m))
      by = transpose(course%slopes(:n, n + moves))
      events = transpose(course%slopes(n + 1 + moves, n + moves))
      if (moves(1) == 1 .and. s%kinds(1) == switch) then
         ! a state from which the period is disturbed need not be at the limit
         by(1, :) = course%first_slopes(:n)
         events(1, :) = course%first_slopes(n + 1 + moves)
      end if
      call solve_columns(events, by, status)
      good = status == stat%ok
      if (good) p = p - matmul(transpose(course%slopes(n + 1 + moves, :n)), by)
   end subroutine monodromy

   !> Whether a symbol begins or ends a contact with a stop, or a flight between two of them, that
   !! has vanished. Its instants have no derivative, but unless the force jumps, what a small
   !! interval changes is of the order of its duration.
   pure logical function is_vanishing(s, course, symbol)
      !> The family.
      type(rests_type), intent(in) :: s
      !> The period.
      type(course_type), intent(in) :: course
      !> The symbol.
      integer, intent(in) :: symbol
      !> The longest interval that counts as none, over the shortest time scale of its regime.
      real(wp), parameter :: none = 1.0e-6_wp
      integer :: before, i, next

      is_vanishing = .false.
      if (.not. allocated(s%rows)) return
      do i = symbol - 1, symbol
         before = modulo(i - 1, size(s%kinds)) + 1
         next = modulo(before, size(s%kinds)) + 1
         if (s%kinds(next) /= switch .or. .not. follows_itself(s, next)) cycle
         if (.not. course%run%structure%elastic(s%gaps(next))) cycle
         if (abs(course%run%structure%laws(s%gaps(next))%numbers(3)) > 0) cycle
         associate (part => course%segments(findloc(course%segments(:course%parts)%symbol, &
            before, 1)))
            is_vanishing = is_vanishing .or. abs(part%duration) < none* &
               course%run%regimes(part%regime)%unit
         end associate
      end do
   end function is_vanishing

end module vi_structure_rests
