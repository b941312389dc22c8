!> Branches as plain arrays: the motion at every point, and the special points among them.
module vi_branch_table
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_branch, only: branch_type, end_simultaneous, end_stopped, end_stuck, follow_branch
   use vi_curve, only: curve_type, parameters_of, unknowns_of
   use vi_exact, only: setting_type
   use vi_kinds, only: two_pi, wp
   use vi_motion, only: no, unknown
   use vi_motion_family, only: condition_type, edge, zero_approach
   use vi_orbit, only: by_clearance, by_left, by_r, by_right, n_parameters, oscillator_of
   use vi_oscillator_families, only: choose_family
   use vi_pattern, only: default_restitution, pattern_type
   use vi_points, only: member_point
   use vi_status, only: stat
   use vi_steps, only: stride_type
   use vi_progress, only: is_stopped, report_share
   implicit none (type, external)
   private

   public :: branch_arrays, follow_both

   !> Units of work of one branch in the progress counters, and the part of them for following it in
   !! both directions; the rest is for the motions at its points.
   integer, parameter, public :: branch_work = 1000, follow_work = 300

   !> The motion to follow (x_i/D and theta_i) at parameters c, and the parameter that changes.
   type, public :: branch_request_type
      type(pattern_type) :: pattern
      logical :: symmetric = .false.
      !> r, log(D), xi, mu, R1, R2
      real(wp) :: c(n_parameters) = 0
      integer :: parameter = by_clearance
      !> Whether R2 always equals R1.
      logical :: tied = .false.
      real(wp) :: bounds(2) = 0
      !> Longest step: of the parameter over its range, and of the unknowns.
      real(wp) :: longest = 0.05_wp
   end type branch_request_type

contains

   !> Follows a branch in both directions; the points are in order along it. What arrays hold after
   !! the last point is not set.
   subroutine branch_arrays(request, unknowns, parameters, phases, impacts, scalars, multipliers, &
      verdicts, codes, special, n, reasons, status, progress)
      !> What to follow.
      type(branch_request_type), intent(in) :: request
      !> (2N) x_i/D and theta_i at the start.
      real(wp), intent(in) :: unknowns(:)
      !> (6, capacity): r, D, xi, mu, R1, R2.
      real(wp), intent(out) :: parameters(:, :)
      !> (N, capacity), (N, 6, capacity), (6, capacity) as in vi_points.
      real(wp), intent(out) :: phases(:, :), impacts(:, :, :), scalars(:, :)
      !> (4, capacity) By decreasing modulus.
      complex(wp), intent(out) :: multipliers(:, :)
      !> (3, capacity) consistent, admissible, stable; (capacity) codes of vi_status.
      integer, intent(out) :: verdicts(:, :), codes(:)
      !> (3, capacity): kind of the condition that is zero (0: none), its index, its side.
      integer, intent(out) :: special(:, :)
      !> Number of points; 0 if the start is a singular point.
      integer, intent(out) :: n
      !> The reasons why it ends, at its first and at its last point, as in vi_branch.
      integer, intent(out) :: reasons(2)
      !> `stat%ok`, or `stat%no_motion` if the pattern has no such family.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; the caller has already added the work.
      integer, intent(inout), optional :: progress(3)
      type(curve_type) :: curve
      type(condition_type), allocatable :: conditions(:)
      real(wp), allocatable :: start(:), points(:, :)
      logical :: cut
      integer :: origin, reported

      n = 0
      reasons = 0
      reported = 0
      call make_curve(request, unknowns, curve, start, status)
      if (status == stat%ok) then
         call follow_both(curve, stride_type(longest=request%longest, turn=0.3_wp), start, &
            size(codes)/2, points, conditions, reasons, progress, origin)
         reported = follow_work
         ! the points found before a stop are written
         cut = is_stopped(progress)
         do n = 1, size(conditions)
            call write_point(request, curve, points(:, n), conditions(n), parameters(:, n), &
               phases(:, n), impacts(:, :, n), scalars(:, n), multipliers(:, n), verdicts(:, n), &
               codes(n))
            special(:, n) = [conditions(n)%kind, conditions(n)%index, conditions(n)%side]
            call report_share((follow_work + (branch_work - follow_work)*n/real(size(conditions), &
               wp))/branch_work, branch_work, reported, progress)
            if (is_stopped(progress) .and. .not. cut .and. n < size(conditions)) then
               reasons(2) = end_stopped
               exit
            end if
         end do
         n = min(n, size(conditions))
         call cut_ends(request, curve, points, min(origin, n), parameters, phases, impacts, &
            scalars, multipliers, verdicts, codes, special, n, reasons)
      end if
      call report_share(1.0_wp, branch_work, reported, progress)
   end subroutine branch_arrays

   !> The points of a branch in both directions from its start; none if the start is a singular
   !! point.
   subroutine follow_both(curve, stride, start, most, points, conditions, reasons, progress, &
      origin)
      !> The curve of motions, with edges at the bounds of the parameter.
      type(curve_type), intent(in) :: curve
      !> Limits on steps.
      type(stride_type), intent(in) :: stride
      !> The point at the start.
      real(wp), intent(in) :: start(:)
      !> Largest number of points in each direction.
      integer, intent(in) :: most
      !> (size of a point, n) The points in order.
      real(wp), allocatable, intent(out) :: points(:, :)
      !> (n) The condition that is zero at each point; kind 0 if none.
      type(condition_type), allocatable, intent(out) :: conditions(:)
      !> The reasons why it ends, at its first and at its last point.
      integer, intent(out) :: reasons(2)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      !> Number of the point at the start.
      integer, intent(out), optional :: origin
      type(branch_type) :: half(2)
      integer :: i, n, reported, work(2)

      ! each direction gets a share of the work equal to its share of the range
      work(1) = nint(follow_work*start(size(start)))
      work(2) = follow_work - work(1)
      do i = 1, 2
         reported = 0
         call follow_branch(curve, stride, start, 2*i - 3, most, half(i), work(i), reported, &
            progress)
         call report_share(1.0_wp, work(i), reported, progress)
         reasons(i) = half(i)%reason
      end do
      n = max(0, half(1)%n + half(2)%n - 1)
      if (present(origin)) origin = half(1)%n
      if (any(half%n == 0)) n = 0
      allocate (points(size(start), n), conditions(n))
      if (n == 0) return
      points(:, :half(1)%n) = half(1)%points(:, half(1)%n:1:-1)
      points(:, half(1)%n:) = half(2)%points(:, :half(2)%n)
      conditions = [half(1)%special(half(1)%n:2:-1), half(2)%special(:half(2)%n)]
      if (half(1)%special(1)%kind > 0) conditions(half(1)%n) = half(1)%special(1)
   end subroutine follow_both

   !> Cuts a branch where rounding leaves no digits of its motions.
   !!
   !! Two impacts on the same wall come together there, for example where a coefficient of
   !! restitution approaches 0: the flight between them and the approach speed of the second one
   !! approach 0. The last motion with correct digits is marked as the end.
   pure subroutine cut_ends(request, curve, points, origin, parameters, phases, impacts, scalars, &
      multipliers, verdicts, codes, special, n, reasons)
      !> What is followed.
      type(branch_request_type), intent(in) :: request
      !> The curve of motions.
      type(curve_type), intent(in) :: curve
      !> The points (size of a point, n), and the number of the one at the start.
      real(wp), intent(in) :: points(:, :)
      integer, intent(in) :: origin
      !> In and out: as in `branch_arrays`.
      real(wp), intent(inout) :: parameters(:, :), phases(:, :), impacts(:, :, :), scalars(:, :)
      complex(wp), intent(inout) :: multipliers(:, :)
      integer, intent(inout) :: verdicts(:, :), codes(:), special(:, :), n, reasons(2)
      type(condition_type) :: condition
      integer :: ends(2), i, m

      if (n == 0) return
      ends(1) = findloc(codes(:origin), stat%no_convergence, dim=1, back=.true.) + 1
      ends(2) = findloc(codes(origin:n), stat%no_convergence, dim=1) + origin - 2
      if (ends(2) < origin) ends(2) = n
      if (ends(1) > origin .or. (ends(1) == 1 .and. ends(2) == n)) return
      do i = 1, 2
         if (ends(i) == merge(1, n, i == 1)) cycle
         reasons(i) = end_stuck
         call last_flight(curve, points(:, ends(i)), request%pattern%cycles, condition)
         if (condition%kind == 0) cycle
         reasons(i) = end_simultaneous
         special(:, ends(i)) = [condition%kind, condition%index, condition%side]
         call write_point(request, curve, points(:, ends(i)), condition, parameters(:, ends(i)), &
            phases(:, ends(i)), impacts(:, :, ends(i)), scalars(:, ends(i)), &
            multipliers(:, ends(i)), verdicts(:, ends(i)), codes(ends(i)))
      end do
      m = ends(2) - ends(1) + 1
      associate (a => ends(1), b => ends(2))
         parameters(:, :m) = parameters(:, a:b)
         phases(:, :m) = phases(:, a:b)
         impacts(:, :, :m) = impacts(:, :, a:b)
         scalars(:, :m) = scalars(:, a:b)
         multipliers(:, :m) = multipliers(:, a:b)
         verdicts(:, :m) = verdicts(:, a:b)
         codes(:m) = codes(a:b)
         special(:, :m) = special(:, a:b)
      end associate
      n = m
   end subroutine cut_ends

   !> The impact that comes together with the one before it at an end of a branch.
   pure subroutine last_flight(curve, point, cycles, condition)
      !> The curve of motions.
      type(curve_type), intent(in) :: curve
      !> The last point.
      real(wp), intent(in) :: point(:)
      !> Load cycles of the period.
      integer, intent(in) :: cycles
      !> The zero approach of the second impact; kind 0 if no flight is short.
      type(condition_type), intent(out) :: condition
      !> Rounding hides the speed of a flight (rad) that is shorter than about this.
      real(wp), parameter :: short = 1.0e-2_wp
      real(wp), allocatable :: whole(:), theta(:)
      integer :: i, n

      allocate (whole, source=curve%family%whole_of(unknowns_of(curve, point)))
      n = size(whole)/2
      theta = [whole(n + 1:), whole(n + 1) + two_pi*cycles]
      i = minloc(theta(2:) - theta(:n), dim=1)
      ! of a symmetric motion the impacts of the first half are counted
      if (theta(i + 1) - theta(i) < short) condition = condition_type(zero_approach, &
         modulo(i, size(unknowns_of(curve, point))/2) + 1)
   end subroutine last_flight

   !> One point of a branch as a motion in arrays.
   pure subroutine write_point(request, curve, point, condition, parameters, phases, impacts, &
      scalars, multipliers, verdicts, code)
      !> What is followed.
      type(branch_request_type), intent(in) :: request
      !> The curve of motions.
      type(curve_type), intent(in) :: curve
      !> A point of it.
      real(wp), intent(in) :: point(:)
      !> The condition that is zero there, if any; on a bound the parameter is set to the bound
      !! exactly.
      type(condition_type), intent(in) :: condition
      !> (6) r, D, xi, mu, R1, R2; (N), (N, 6), (6) as in vi_points.
      real(wp), intent(out) :: parameters(:), phases(:), impacts(:, :), scalars(:)
      !> (4) By decreasing modulus.
      complex(wp), intent(out) :: multipliers(:)
      !> (3) consistent, admissible, stable; a code of vi_status.
      integer, intent(out) :: verdicts(:), code
      type(setting_type) :: setting
      real(wp) :: whole(2*size(request%pattern%sides)), c(n_parameters)
      integer :: m

      c = parameters_of(curve, point)
      c(by_clearance) = exp(c(by_clearance))
      if (condition%kind == edge) c(request%parameter) = request%bounds(merge(1, 2, &
         condition%side > 0))
      if (curve%tied) c(by_left) = c(by_right)
      parameters = c
      setting = setting_type(oscillator_of(c), c(by_r), 1.0_wp, c(by_clearance), request%pattern, &
         default_restitution(request%pattern%sides, c(by_right), c(by_left)))
      whole = curve%family%whole_of(unknowns_of(curve, point))
      m = size(whole)/2
      call member_point(setting, whole(:m)*c(by_clearance), whole(m + 1:), phases, impacts, &
         scalars, multipliers, verdicts, code)
      if (condition%kind == zero_approach) then
         ! without an approach speed there is no impact, and [P] does not exist: the computed one
         ! contains a rounding error divided by another
         multipliers = cmplx(ieee_value(1.0_wp, ieee_quiet_nan), 0.0_wp, wp)
         verdicts(2:) = [no, unknown]
      end if
   end subroutine write_point

   !> The curve and the start on it.
   subroutine make_curve(request, unknowns, curve, start, status)
      !> What to follow.
      type(branch_request_type), intent(in) :: request
      !> (2N) x_i/D and theta_i at the start.
      real(wp), intent(in) :: unknowns(:)
      !> The curve; its parameter is 0 and 1 at the bounds.
      type(curve_type), intent(out) :: curve
      !> The point at the start.
      real(wp), allocatable, intent(out) :: start(:)
      !> `stat%ok`, or `stat%no_motion` if the pattern has no such family.
      integer, intent(out) :: status
      real(wp) :: low, high
      logical :: possible, equal

      associate (c => request%c, p => request%parameter)
         equal = abs(c(by_right) - c(by_left)) <= 0
         call choose_family(request%pattern, request%symmetric, equal .and. (request%tied .or. &
            p /= by_right .and. p /= by_left), curve%family, possible)
         status = merge(stat%ok, stat%no_motion, possible)
         if (.not. possible) return
         low = request%bounds(1)
         high = request%bounds(2)
         if (p == by_clearance) then
            low = log(low)
            high = log(high)
         end if
         curve%c = c
         curve%active = [p]
         curve%tied = request%tied
         curve%origin = [low]
         curve%scale = [high - low]
         curve%family%apart = 1.0e-5_wp
         curve%family%every_crossing = .true.
         allocate (curve%edges(2))
         curve%edges(1) = condition_type(edge, p, 1, bound=low)
         curve%edges(2) = condition_type(edge, p, -1, bound=high)
         start = [curve%family%part_of(c, unknowns), (c(p) - low)/(high - low)]
      end associate
   end subroutine make_curve

end module vi_branch_table
