!> Neighbourhoods of periodic motions from which all states converge to the motion.
!!
!! In the norm of M = sum of (P'/g)^n (P/g)^n, with g between the spectral radius of the derivative
!! P over a period and 1, P contracts at least by g. A ball of that norm counts as a neighbourhood
!! if the map itself, not only P, brings each of many states spread over it nearer to the centre,
!! with the same number of events. Half of the largest such radius found is used.
module vi_attractor_neighbourhood
   use vi_attractor_tangent, only: period_derivative
   use vi_attractor_target, only: difference, over_period, target_type
   use vi_forced_system, only: forced_system_type, event_type, new_forced_system
   use vi_kinds, only: two_pi, wp
   use vi_lapack, only: eigenvalues
   use vi_oscillator, only: oscillator_type
   use vi_progress, only: is_stopped
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: factorise, find_neighbourhoods

   !> States on which a neighbourhood is tested, and largest number of events of a period.
   integer, parameter :: trials = 1024, capacity = 2048

contains

   !> The neighbourhoods of motions whose event and period are given.
   subroutine find_neighbourhoods(osc, r, load, clearance, targets, threads, progress)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      !> Frequency ratio, load amplitude f, clearance.
      real(wp), intent(in) :: r, load, clearance
      !> In: event and period of each motion. Out: with metric and radius; radius 0 if there is no
      !! neighbourhood.
      type(target_type), intent(inout) :: targets(:)
      !> Number of OpenMP threads.
      integer, intent(in) :: threads
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      type(forced_system_type) :: system
      integer :: i

      system = new_forced_system(osc, r, load, clearance)
      !$omp parallel do schedule(dynamic, 1) num_threads(threads)
      do i = 1, size(targets)
         call find_neighbourhood(system, targets(i), progress)
      end do
      !$omp end parallel do
   end subroutine find_neighbourhoods

   !> The neighbourhood of one motion.
   subroutine find_neighbourhood(system, target, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In: event and period of the motion. Out: with metric and radius; without a neighbourhood if
      !! the study was stopped.
      type(target_type), intent(inout) :: target
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      real(wp), parameter :: finer = 0.5_wp**0.25_wp
      real(wp) :: p(4, 4), zero(4), extent(4)
      type(event_type) :: events(capacity)
      logical :: good
      integer :: i

      target%radius = 0
      zero = 0
      call over_period(system, target, zero, events, target%events, good)
      if (.not. good) return
      call period_derivative(system, target%cycles, events(:target%events), p, good)
      if (.not. good) return
      call find_metric(system, target, p, good)
      if (.not. good) return
      ! start with a ball that covers the whole space between the walls, and shrink it
      extent = 0
      extent(:target%n) = system%clearance
      extent(target%n) = 1
      target%radius = sqrt(real(target%n, wp))*norm2(matmul(target%metric, extent))
      do i = 1, 160
         call contract(system, target, events, good, progress)
         if (good) exit
         target%radius = finer*target%radius
      end do
      target%radius = merge(0.5_wp*target%radius, 0.0_wp, good)
      target%box = target%radius*norm2(target%inverse, dim=2)
   end subroutine find_neighbourhood

   !> Whether all tested states of a ball come nearer to its centre over a period.
   subroutine contract(system, target, events, contracts, progress)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> The motion with its metric; the ball has its radius.
      type(target_type), intent(in) :: target
      !> Scratch.
      type(event_type), intent(inout) :: events(:)
      !> Whether they do; false if the study was stopped.
      logical, intent(out) :: contracts
      !> Progress counters, see vi_progress; read to stop.
      integer, intent(inout), optional :: progress(3)
      real(wp) :: u(5), direction(4), d(4), distance, next, pair(4)
      real(wp), parameter :: steps(5) = [0.8566749_wp, 0.7338918_wp, 0.6287066_wp, 0.5385973_wp, &
         0.4614030_wp]
      integer :: i, n
      logical :: good

      contracts = .false.
      do i = 1, trials
         if (is_stopped(progress)) return
         u = modulo(0.5_wp + i*steps, 1.0_wp)
         pair = [sqrt(-2*log(max(u(1), tiny(1.0_wp))))*[cos(two_pi*u(2)), sin(two_pi*u(2))], &
            sqrt(-2*log(max(u(3), tiny(1.0_wp))))*[cos(two_pi*u(4)), sin(two_pi*u(4))]]
         pair(target%n + 1:) = 0
         direction = pair/norm2(pair)
         ! every second state lies on the surface
         distance = target%radius*merge(1.0_wp, u(5)**0.25_wp, modulo(i, 2) == 0)
         d = distance*matmul(target%inverse, direction)
         call over_period(system, target, d, events, n, good)
         if (.not. good .or. n /= target%events) return
         next = norm2(matmul(target%metric, difference(target, events(n))))
         if (.not. next <= 0.5_wp*(1 + target%contraction)*distance) return
      end do
      contracts = .true.
   end subroutine contract

   !> The norm in which the derivative contracts.
   pure subroutine find_metric(system, target, p, good)
      !> The forced system.
      type(forced_system_type), intent(in) :: system
      !> In and out: metric, inverse and contraction are set.
      type(target_type), intent(inout) :: target
      !> The derivative over a period.
      real(wp), intent(in) :: p(4, 4)
      !> False if the motion is not stable, or the metric could not be factorised.
      logical, intent(out) :: good
      real(wp), dimension(4, 4) :: a, m
      real(wp) :: scale(4), radius
      complex(wp) :: lambda(4)
      integer :: i, n, status

      n = target%n
      scale = system%clearance
      scale(n) = 1
      a = 0
      do i = 1, n
         a(:n, i) = p(:n, i)*scale(i)/scale(:n)
      end do
      m = a
      call eigenvalues(m, lambda, status)
      radius = maxval(abs(lambda))
      good = status == stat%ok .and. radius < 1
      if (.not. good) return
      target%contraction = max(0.1_wp, sqrt(radius), 0.5_wp*(1 + radius))
      a = a/target%contraction
      m = 0
      do i = 1, 4
         m(i, i) = 1
      end do
      do i = 1, 40
         m = m + matmul(transpose(a), matmul(m, a))
         a = matmul(a, a)
         if (maxval(abs(a)) < epsilon(1.0_wp)) exit
      end do
      call factorise(m, n, scale, target, good)
   end subroutine find_metric

   !> The metric from m = L L': it is L' over the scale; its inverse is the scale times (L')^-1.
   pure subroutine factorise(m, n, scale, target, good)
      !> A symmetric positive matrix, and the units of the coordinates.
      real(wp), intent(in) :: m(4, 4), scale(4)
      !> Its order: 4, or 2 for a release.
      integer, intent(in) :: n
      !> In and out: metric and inverse are set.
      type(target_type), intent(inout) :: target
      !> False if the matrix is not positive definite.
      logical, intent(out) :: good
      real(wp) :: u(4, 4), v(4, 4)
      integer :: i, j

      u = 0
      v = 0
      good = .true.
      do i = 1, n
         do j = i, n
            u(i, j) = m(i, j) - dot_product(u(:i - 1, i), u(:i - 1, j))
         end do
         good = good .and. u(i, i) > 0
         if (.not. good) return
         u(i, i:n) = u(i, i:n)/sqrt(u(i, i))
      end do
      do j = 1, n
         v(j, j) = 1/u(j, j)
         do i = j - 1, 1, -1
            v(i, j) = -dot_product(u(i, i + 1:j), v(i + 1:j, j))/u(i, i)
         end do
      end do
      target%metric = 0
      target%inverse = 0
      do i = 1, n
         target%metric(:n, i) = u(:n, i)/scale(i)
         target%inverse(i, :n) = v(i, :n)*scale(i)
      end do
   end subroutine factorise

end module vi_attractor_neighbourhood
