!> Which periodic motions simulations settle on, over a window.
!!
!! A simulation that repeats itself after some cycles gives a guess; Newton's method makes the
!! motion exact, and only a stable, admissible one counts.
module vi_survey
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_conditions, only: all_conditions
   use vi_curve, only: correct, curve_type
   use vi_family, only: new_family
   use vi_frame, only: condition_count, condition_type, edge, repetition, unknown_count
   use vi_kinds, only: wp
   use vi_letters, only: standard_letters
   use vi_orbit, only: by_clearance, by_r, most_impacts, n_parameters
   use vi_oscillator, only: left, oscillator_type, right
   use vi_pattern, only: pattern_type
   use vi_rest_family, only: new_rest_family
   use vi_simulate, only: drive_type, event_type, impact_event, new_drive, release_event, &
      simulate, state_type, stick_event
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: survey

   !> Events kept of the end of a simulation.
   integer, parameter :: room = 4000
   real(wp), parameter :: two_pi = 2*acos(-1.0_wp)

   !> A stable motion: its letters in standard order, and its unknowns.
   type, public :: attractor_type
      logical :: found = .false.
      real(wp) :: r = 0, clearance = 0
      integer :: cycles = 0
      integer, allocatable :: letters(:)
      !> x_i/D and theta_i of the whole pattern; with rest phase and velocity over D at the last
      !> release, then zeros.
      real(wp), allocatable :: unknowns(:)
   end type attractor_type

   !> Letters of the events of some cycles, and the event that begins and that ends each.
   type :: reading_type
      integer :: n = 0
      integer, dimension(room) :: letters, first, last
   end type reading_type

contains

   !> What simulations at points spread evenly over a window settle on.
   subroutine survey(osc, r, clearance, settling, most_letters, most_cycles, threads, attractors)
      type(oscillator_type), intent(in) :: osc
      !> The window.
      real(wp), intent(in) :: r(2), clearance(2)
      !> Load cycles before an attractor is looked at.
      integer, intent(in) :: settling
      !> Limits of the motions kept.
      integer, intent(in) :: most_letters, most_cycles
      integer, intent(in) :: threads
      type(attractor_type), intent(inout) :: attractors(:)
      real(wp) :: u(5), c(2), golden
      integer :: i, j

      golden = 1
      do j = 1, 40
         golden = (1 + golden)**(1.0_wp/6)
      end do
      !$omp parallel do schedule(dynamic, 1) num_threads(threads) private(u, c)
      do i = 1, size(attractors)
         u = [(modulo(0.5_wp + i/golden**j, 1.0_wp), j=1, 5)]
         c = [r(1) + (r(2) - r(1))*u(1), clearance(1)*(clearance(2)/clearance(1))**u(2)]
         call settle(osc, c(1), c(2), u(3:5), settling, most_letters, most_cycles, attractors(i))
      end do
      !$omp end parallel do
   end subroutine survey

   !> The attractor of one simulation.
   pure subroutine settle(osc, r, clearance, u, settling, most_letters, most_cycles, attractor)
      type(oscillator_type), intent(in) :: osc
      real(wp), intent(in) :: r, clearance
      !> Three numbers in [0, 1) for the initial state.
      real(wp), intent(in) :: u(3)
      integer, intent(in) :: settling, most_letters, most_cycles
      type(attractor_type), intent(out) :: attractor
      type(drive_type) :: drive
      type(state_type) :: state
      type(event_type) :: events(room)
      type(reading_type) :: now, before
      real(wp) :: size_x, end_phase
      integer :: n, k, last, status

      attractor%r = r
      attractor%clearance = clearance
      drive = new_drive(osc, r, 1.0_wp, clearance)
      size_x = min(abs(drive%amplitude), 3*clearance)
      state%x = size_x*(2*u(1) - 1)
      state%x_dot = size_x*(2*u(2) - 1)
      state%z = state%x + 0.499_wp*clearance*(2*u(3) - 1)
      call run(drive, state, settling, events, n, status)
      if (status /= stat%ok) return
      call run(drive, state, 2*most_cycles + 2, events, n, status)
      if (status /= stat%ok) return
      ! a period ends with a release, if there is one
      last = findloc(events(:n)%kind, release_event, dim=1, back=.true.)
      if (last == 0) last = n
      if (last == 0) return
      do k = 1, most_cycles
         ! a thousandth of a cycle: the event one period before belongs to the window before
         end_phase = total_phase(events(last)) + 1.0e-3_wp*two_pi
         call read_window(events(:last), end_phase - two_pi*k, end_phase, now)
         call read_window(events(:last), end_phase - 2*two_pi*k, end_phase - two_pi*k, before)
         if (.not. repeats(events, now, before, k)) cycle
         if (now%n > most_letters) return
         call identify(osc, drive, events, now, k, attractor)
         return
      end do
   end subroutine settle

   !> Simulates some cycles from a state; out: the state there, and the last events.
   pure subroutine run(drive, state, cycles, events, n, status)
      type(drive_type), intent(in) :: drive
      type(state_type), intent(inout) :: state
      integer, intent(in) :: cycles
      type(event_type), intent(inout) :: events(:)
      integer, intent(out) :: n, status
      type(state_type) :: final
      integer(int64) :: last_cycle
      real(wp) :: last_phase
      integer :: calls

      last_cycle = state%cycle + cycles
      last_phase = state%phase
      do calls = 1, 1000
         call simulate(drive, state, last_cycle, last_phase, events, n, final, status)
         if (status /= stat%more_events) exit
      end do
      state = final
   end subroutine run

   pure real(wp) function total_phase(event)
      type(event_type), intent(in) :: event

      total_phase = two_pi*real(event%cycle, wp) + event%phase
   end function total_phase

   !> The letters of the events between two phases.
   pure subroutine read_window(events, begin, finish, reading)
      type(event_type), intent(in) :: events(:)
      real(wp), intent(in) :: begin, finish
      type(reading_type), intent(out) :: reading
      integer :: i, run_length

      run_length = 0
      do i = 1, size(events)
         if (total_phase(events(i)) <= begin .or. total_phase(events(i)) > finish) cycle
         associate (n => reading%n)
            select case (events(i)%kind)
            case (impact_event)
               run_length = merge(run_length + 1, 1, n > 0 .and. run_length > 0)
               if (n > 0) then
                  if (reading%letters(n) /= events(i)%side) run_length = 1
               end if
               n = n + 1
               reading%letters(n) = events(i)%side
               reading%first(n) = i
               reading%last(n) = i
            case (stick_event)
               ! the run of impacts on this wall becomes one letter
               if (run_length > 0) n = n - run_length + 1
               if (run_length == 0) then
                  n = n + 1
                  reading%first(n) = i
               end if
               reading%letters(n) = 2*events(i)%side
               reading%last(n) = i
               run_length = 0
            case default                                                      ! a release
               if (n > 0) reading%last(n) = i
               run_length = 0
            end select
         end associate
      end do
   end subroutine read_window

   !> Whether two windows hold the same letters at the same phases, on both walls.
   pure logical function repeats(events, now, before, cycles)
      type(event_type), intent(in) :: events(:)
      type(reading_type), intent(in) :: now, before
      integer, intent(in) :: cycles
      integer :: j

      repeats = now%n > 1 .and. now%n == before%n
      if (.not. repeats) return
      associate (letters => now%letters(:now%n))
         repeats = all(letters == before%letters(:now%n)) .and. any(letters > 0) .and. &
            any(letters < 0)
      end associate
      do j = 1, now%n
         if (.not. repeats) return
         repeats = abs(total_phase(events(now%first(j))) - total_phase(events(before%first(j))) &
            - two_pi*cycles) < 1.0e-3_wp
      end do
   end function repeats

   !> The exact motion that a window is about, in standard order, if it is stable and admissible.
   pure subroutine identify(osc, drive, events, reading, cycles, attractor)
      type(oscillator_type), intent(in) :: osc
      type(drive_type), intent(in) :: drive
      type(event_type), intent(in) :: events(:)
      type(reading_type), intent(in) :: reading
      integer, intent(in) :: cycles
      type(attractor_type), intent(inout) :: attractor
      integer :: order(reading%n), shift, n, i, side
      logical :: mirrored, resting
      real(wp) :: theta(reading%n), x(reading%n)

      n = reading%n
      allocate (attractor%letters(n))
      call standard_letters(reading%letters(:n), abs(osc%restitution(1) - osc%restitution(2)) &
         <= 0, attractor%letters, shift, mirrored)
      side = merge(-1, 1, mirrored)
      order = cshift([(i, i=1, n)], shift)
      attractor%cycles = cycles
      resting = any(abs(attractor%letters) == 2)
      allocate (attractor%unknowns(2*n), source=0.0_wp)
      if (resting) then
         i = reading%last(order(findloc(abs(attractor%letters), 2, dim=1, back=.true.)))
         attractor%unknowns(:2) = [events(i)%phase + merge(0.5_wp*two_pi, 0.0_wp, mirrored), &
            side*events(i)%x_dot_after/drive%clearance]
      else
         do i = 1, n
            x(i) = side*events(reading%first(order(i)))%x/drive%clearance
            theta(i) = total_phase(events(reading%first(order(i)))) - drive%lag
            if (order(i) < order(1)) theta(i) = theta(i) + two_pi*cycles
         end do
         theta = theta - two_pi*floor(theta(1)/two_pi) + merge(0.5_wp*two_pi, 0.0_wp, mirrored)
         attractor%unknowns = [x, theta]
      end if
      call polish(osc, attractor, resting)
   end subroutine identify

   !> Newton's method at the point, and the verdict.
   pure subroutine polish(osc, attractor, resting)
      type(oscillator_type), intent(in) :: osc
      type(attractor_type), intent(inout) :: attractor
      logical, intent(in) :: resting
      type(curve_type) :: sheet
      type(condition_type) :: fixed(2)
      type(condition_type), allocatable :: conditions(:)
      real(wp), allocatable :: point(:), values(:)
      real(wp) :: c(n_parameters)
      logical :: possible
      integer :: n, iterations

      allocate (sheet%frame%edges(0))
      sheet%frame%resting = resting
      if (resting) then
         sheet%frame%rest = new_rest_family(attractor%letters, attractor%cycles)
         allocate (sheet%frame%repetitions(0))
      else
         if (size(attractor%letters) > most_impacts) return
         call new_family(pattern_type(attractor%letters, attractor%cycles), .false., .true., &
            sheet%frame%family, sheet%frame%repetitions, possible)
      end if
      c = [attractor%r, log(attractor%clearance), osc%xi, osc%mu, osc%restitution(right), &
         osc%restitution(left)]
      sheet%c = c
      sheet%active = [by_r, by_clearance]
      sheet%origin = c(:2)
      sheet%scale = [1.0_wp, 1.0_wp]
      fixed = [condition_type(edge, by_r, 1, bound=c(1)), &
         condition_type(edge, by_clearance, 1, bound=c(2))]
      n = unknown_count(sheet%frame)
      allocate (point(n + 2), source=0.0_wp)
      point(:n) = attractor%unknowns(:n)
      call correct(sheet, fixed, point, iterations)
      if (iterations == 0) return
      allocate (values(condition_count(sheet%frame)), conditions(condition_count(sheet%frame)))
      call all_conditions(sheet%frame, point(:n), c, values, conditions)
      ! one that repeats itself is stable all the same
      if (any(values <= 0 .and. conditions%kind /= repetition)) return
      attractor%unknowns(:n) = point(:n)
      attractor%found = .true.
   end subroutine polish

end module vi_survey
