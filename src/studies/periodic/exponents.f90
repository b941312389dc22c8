!> Lyapunov exponents: averages of the growth of directions along a simulated motion, and what
!! follows from them.
module vi_exponents
   use, intrinsic :: ieee_arithmetic, only: ieee_negative_inf, ieee_quiet_nan, ieee_value
   use vi_kinds, only: wp
   use vi_progress, only: add_done_work
   use vi_simulated_motion, only: growth_type, simulated_motion_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: cycles_to_settle, exponents_along, is_chaotic, kaplan_yorke, orthonormalise, &
      scatter, sign_by_error

   !> What an average needs.
   type, public :: average_type
      !> Load cycles before the first batch and in each; batches that count, at least 2.
      integer :: discard = 0, cycles = 0, batches = 2
      !> Number of directions; 0 for all.
      integer :: directions = 0
      !> Units of work of a batch in the progress counters.
      integer :: work = 0
   end type average_type

   !> The exponents of a simulation.
   type, public :: exponents_type
      !> (directions) Per unit of time, the greatest first; -inf for directions that are lost. Their
      !! standard errors from the scatter of the batches.
      real(wp), allocatable :: exponents(:), deviations(:)
      !> Number of directions that are not lost.
      integer :: rank = 0
      !> Dimension of Kaplan and Yorke, and the error of the sum of the exponents per unit of time;
      !! NaN unless all directions are carried.
      real(wp) :: dimension = 0, error = 0
      !> Mean rate at which volumes contract; of directions that are lost only what the damping
      !! contributes.
      real(wp) :: contraction = 0
      !> Impacts and rests in the batches that count; a period of the load.
      integer :: impacts = 0, rests = 0
      real(wp) :: period = 0
   end type exponents_type

   !> The sign of a largest exponent: that which it has by its error, or none as long as the error
   !! is too large for that.
   integer, parameter, public :: negative = -1, zero = 0, positive = 1, unclear = 2

   !> A motion counts as settled after this many of the times in which volumes contract by a factor
   !! e in each direction, and of those in which the slowest vibration decays by a factor e.
   real(wp), parameter :: contractions = 40
   real(wp), parameter, public :: decays = 10

   !> Chaos: least values of the largest exponent per load cycle, and of its ratio to its standard
   !! error.
   real(wp), parameter :: least_chaos = 2.0e-3_wp, least_ratio = 4

contains

   !> The exponents of a motion that goes on, from batches of load cycles.
   subroutine exponents_along(motion, average, found, status, progress)
      !> In and out: the motion.
      class(simulated_motion_type), intent(inout) :: motion
      !> How long to average.
      type(average_type), intent(in) :: average
      !> The exponents; without any unless the status is `stat%ok`.
      type(exponents_type), intent(out) :: found
      !> As of `grow`; `stat%no_motion` if a batch has too few events.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(growth_type) :: growth
      real(wp), allocatable :: each(:, :)
      integer :: batch, n

      n = merge(average%directions, motion%dimensions, average%directions > 0)
      growth%batches = average%batches
      growth%cycles = average%cycles
      growth%rank = n
      allocate (growth%sums(2, 0:n), each(n, average%batches), source=0.0_wp)
      do batch = -1, average%batches
         growth%batch = batch
         growth%sums(2, :) = 0
         call motion%grow(merge(average%discard, average%cycles, batch < 0), growth, status, &
            progress)
         if (status /= stat%ok) exit
         if (batch >= 0) call add_done_work(average%work, progress)
         if (batch == 0) call forget(growth)
         if (batch < 1) cycle
         if (.not. growth%sums(2, 0) > 0) status = stat%no_motion
         if (status /= stat%ok) exit
         each(:, batch) = growth%sums(2, 1:)/(growth%sums(2, 0)*motion%unit)
      end do
      if (growth%batch < 1) call forget(growth)
      found%period = motion%period
      found%rank = growth%rank
      found%impacts = growth%impacts
      found%rests = growth%rests
      associate (time => max(growth%time, tiny(1.0_wp))*motion%unit)
         found%error = abs(growth%difference)/time
         found%contraction = -growth%volume/(time*motion%dimensions)
      end associate
      if (status /= stat%ok) return
      allocate (found%exponents, source=growth%sums(1, 1:)/(growth%sums(1, 0)*motion%unit))
      allocate (found%deviations(n))
      call scatter(each, growth%rank, found%exponents, found%deviations)
      found%dimension = kaplan_yorke(found%exponents)
      if (n == motion%dimensions) return
      found%dimension = ieee_value(1.0_wp, ieee_quiet_nan)
      found%error = found%dimension
   end subroutine exponents_along

   !> Makes the sums empty that do not count while the directions still settle.
   pure subroutine forget(growth)
      !> In and out: the growth.
      type(growth_type), intent(inout) :: growth

      growth%sums = 0
      growth%time = 0
      growth%volume = 0
      growth%difference = 0
      growth%impacts = 0
      growth%rests = 0
   end subroutine forget

   !> Whether the largest Lyapunov exponent of a motion is positive by more than its error.
   subroutine is_chaotic(motion, cycles, chaos, status, progress)
      !> In and out: the motion.
      class(simulated_motion_type), intent(inout) :: motion
      !> Load cycles of each of ten batches.
      integer, intent(in) :: cycles
      !> Whether it is chaotic; false also if the simulation failed.
      logical, intent(out) :: chaos
      !> As of `exponents_along`.
      integer, intent(out) :: status
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(exponents_type) :: found

      call exponents_along(motion, average_type(cycles=cycles, batches=10), found, status, progress)
      chaos = status == stat%ok
      if (chaos) chaos = found%exponents(1)*found%period > least_chaos .and. &
         found%exponents(1) > least_ratio*found%deviations(1)
   end subroutine is_chaotic

   !> Load cycles after which any motion nearby counts as settled.
   !!
   !! A transient may look chaotic or quasi-periodic for a long time. Volumes contract at a known
   !! rate, and nothing settles faster; the slowest vibration may last much longer than that.
   !! Without contraction there are no transients.
   pure integer function cycles_to_settle(contraction, decay) result(cycles)
      !> The rates, per load cycle, at which volumes contract in each direction, and at which the
      !! slowest vibration decays.
      real(wp), intent(in) :: contraction, decay
      !> A rate below this is rounding.
      real(wp), parameter :: rounding = 1.0e-12_wp
      real(wp) :: most

      most = 0
      if (contraction > rounding) most = contractions/contraction
      if (decay > rounding) most = max(most, decays/decay)
      cycles = ceiling(min(1.0e9_wp, most))
   end function cycles_to_settle

   !> Gram-Schmidt orthonormalisation, applied twice.
   !!
   !! A column that depends linearly on those before it, to rounding, gets length 0 and is replaced
   !! by another direction, so that the columns stay linearly independent.
   pure subroutine orthonormalise(q, lengths)
      !> In: columns, at most as many as rows. Out: orthonormal columns.
      real(wp), contiguous, intent(inout) :: q(:, :)
      !> Length of each column orthogonal to those before it: the diagonal of the triangular factor.
      real(wp), intent(out) :: lengths(:)
      real(wp) :: whole, rest
      integer :: j, least

      do j = 1, size(q, 2)
         whole = norm2(q(:, j))
         call project_out(q, j)
         rest = norm2(q(:, j))
         lengths(j) = rest
         if (.not. rest > 4*epsilon(1.0_wp)*whole) then
            lengths(j) = 0
            least = minloc(sum(q(:, :j - 1)**2, dim=2), dim=1)
            q(:, j) = 0
            q(least, j) = 1
            call project_out(q, j)
            rest = norm2(q(:, j))
         end if
         q(:, j) = q(:, j)/rest
         call project_out(q, j)
         q(:, j) = q(:, j)/sqrt(sum(q(:, j)**2))                  ! of the order of 1: no overflow
      end do
   end subroutine orthonormalise

   !> Subtracts from a column its components along the columns before it.
   pure subroutine project_out(q, j)
      !> In and out: column j changes; those before it are orthonormal.
      real(wp), contiguous, intent(inout) :: q(:, :)
      !> Number of the column.
      integer, intent(in) :: j
      integer :: i

      do i = 1, j - 1
         q(:, j) = q(:, j) - dot_product(q(:, i), q(:, j))*q(:, i)
      end do
   end subroutine project_out

   !> Standard errors of exponents from their batches, and the greatest exponent first; directions
   !! that are lost have exponent -inf.
   pure subroutine scatter(each, rank, exponents, deviations)
      !> (n, batches) The exponents of each batch.
      real(wp), intent(in) :: each(:, :)
      !> Number of directions that are not lost.
      integer, intent(in) :: rank
      !> (n) In: the exponents over all batches together. Out: in order, -inf where the direction is
      !! lost.
      real(wp), intent(inout) :: exponents(:)
      !> (n) Their standard errors.
      real(wp), intent(out) :: deviations(:)
      real(wp) :: mean(size(exponents)), pair(2)
      integer :: i, j, batches

      batches = size(each, 2)
      mean = sum(each, dim=2)/batches
      deviations = 0
      do i = 1, batches
         deviations = deviations + (each(:, i) - mean)**2
      end do
      deviations = sqrt(deviations/(batches - 1))/sqrt(real(batches, wp))
      exponents(rank + 1:) = ieee_value(1.0_wp, ieee_negative_inf)
      deviations(rank + 1:) = 0
      ! equal exponents, as of a pair of multipliers, change places by the error of the average
      do i = 2, rank
         pair = [exponents(i), deviations(i)]
         do j = i, 2, -1
            if (.not. exponents(j - 1) < pair(1)) exit
            exponents(j) = exponents(j - 1)
            deviations(j) = deviations(j - 1)
         end do
         exponents(j) = pair(1)
         deviations(j) = pair(2)
      end do
   end subroutine scatter

   !> The dimension of Kaplan and Yorke: the number of directions whose volume does not shrink, and
   !! the fraction of the next direction that balances the growth.
   pure real(wp) function kaplan_yorke(exponents) result(dimension)
      !> All exponents, the greatest first.
      real(wp), intent(in) :: exponents(:)
      real(wp) :: sum_before
      integer :: i

      dimension = 0
      sum_before = 0
      do i = 1, size(exponents)
         if (.not. sum_before + exponents(i) >= 0) exit
         sum_before = sum_before + exponents(i)
         dimension = dimension + 1
      end do
      if (i <= size(exponents)) dimension = dimension - sum_before/exponents(i)
   end function kaplan_yorke

   !> The sign of the largest exponent of an average, by its error.
   !!
   !! Besides the scatter of the batches there is an error of the order of 1 over the length of the
   !! average: on a torus small changes grow as a power of the time.
   pure integer function sign_by_error(exponent, deviation, periods) result(sign_of_it)
      !> The exponent per period of the load, and its standard error.
      real(wp), intent(in) :: exponent, deviation
      !> Number of periods of the average.
      integer, intent(in) :: periods
      !> Standard errors that count as a certain difference; logarithm of a growth as a power of the
      !! time, and of one that is none; largest error of a zero, with the growth and without.
      real(wp), parameter :: certain = 4, slow = 8, still = 1, coarse = 2.0e-3_wp, fine = 1.0e-4_wp

      if (exponent > certain*deviation + slow/periods) then
         sign_of_it = positive
      else if (exponent < -certain*deviation - still/periods) then
         sign_of_it = negative
      else if (certain*deviation < fine .and. slow/periods < coarse) then
         sign_of_it = zero
      else
         sign_of_it = unclear
      end if
   end function sign_by_error

end module vi_exponents
