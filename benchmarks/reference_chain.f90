!> The cost of the chain of the 1983 theory, relative to the LAPACK calls that it needs.
!!
!! For N = 2, 3, 5, 8 impacts, in microseconds a point: (a) only LAPACK calls of the same sizes
!! on the same matrices, (b) `periodic_points` without flights, (c) with flights. All three take
!! turns within one run, so that a slow moment of the machine affects all; the median of the
!! turns counts.
module bench_chain
   use vi_assess, only: paper_acceptance
   use vi_kinds, only: wp
   use vi_lapack, only: least_squares_work
   use vi_motion, only: motion_type, start_motion
   use vi_oscillator, only: oscillator_type
   use vi_pattern, only: new_pattern, pattern_type
   use vi_periodic, only: assemble, linear_system_type, solve_periodic
   use vi_points, only: periodic_points
   use vi_stability, only: stability_matrix
   implicit none (type, external)
   private

   public :: measure

   integer, parameter :: points = 1000, repetitions = 15
   !> Direct LAPACK calls, without the checks that vi_lapack adds.
   interface
      subroutine dgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: wp
         implicit none (type, external)
         integer, intent(in) :: n, nrhs, lda, ldb
         real(wp), intent(inout) :: a(lda, *), b(*)
         integer, intent(out) :: ipiv(*), info
      end subroutine dgesv
      subroutine dgels(trans, m, n, nrhs, a, lda, b, ldb, work, lwork, info)
         import :: wp
         implicit none (type, external)
         character, intent(in) :: trans
         integer, intent(in) :: m, n, nrhs, lda, ldb, lwork
         real(wp), intent(inout) :: a(lda, *), b(*), work(*)
         integer, intent(out) :: info
      end subroutine dgels
      subroutine dgeev(jobvl, jobvr, n, a, lda, wr, wi, vl, ldvl, vr, ldvr, work, lwork, info)
         import :: wp
         implicit none (type, external)
         character, intent(in) :: jobvl, jobvr
         integer, intent(in) :: n, lda, ldvl, ldvr, lwork
         real(wp), intent(inout) :: a(lda, *), vl(ldvl, *), vr(ldvr, *), work(*)
         real(wp), intent(out) :: wr(*), wi(*)
         integer, intent(out) :: info
      end subroutine dgeev
   end interface

   type(oscillator_type), parameter :: osc = oscillator_type(0.0114_wp, 0.028_wp, [0.75_wp, &
      0.61_wp])

   !> The points of one N, the matrices that belong to them, and room for the results.
   type :: work_type
      type(pattern_type) :: pattern
      real(wp), allocatable :: r(:), phases(:, :), restitution(:)
      real(wp), allocatable :: matrix(:, :, :), rhs(:, :), map(:, :, :)
      real(wp), allocatable :: impacts(:, :, :), scalars(:, :)
      complex(wp), allocatable :: multipliers(:, :)
      integer, allocatable :: verdicts(:, :), status(:)
   end type work_type

contains

   !> Times one N and prints its line.
   subroutine measure(n)
      integer, intent(in) :: n
      type(work_type) :: work
      real(wp) :: times(0:repetitions, 3), a, b, c, check
      integer :: i

      call prepare(n, work)
      check = 0
      do i = 0, repetitions                       ! turn 0 warms up
         a = seconds()
         call bare_lapack(n, work, check)
         b = seconds()
         call chain(work, .false.)
         c = seconds()
         times(i, :2) = [b - a, c - b]
         a = seconds()
         call chain(work, .true.)
         times(i, 3) = seconds() - a
      end do
      times = times*1e6_wp/points
      a = median(times(1:, 1))
      b = median(times(1:, 2))
      c = median(times(1:, 3))
      print '(i4, 3f12.3, 2f10.2, i10)', n, a, b, c, b/a, c/a, count(work%status == 0)
      if (.not. abs(check) > 0) print '(a)', 'the eigenvalues vanished'
   end subroutine measure

   !> Random points: impacts spread over one cycle, both walls in turn, around resonance.
   subroutine prepare(n, work)
      integer, intent(in) :: n
      type(work_type), intent(out) :: work
      type(linear_system_type) :: system
      type(motion_type) :: motion
      real(wp) :: gaps(n), random(points)
      real(wp), parameter :: two_pi = 2*acos(-1.0_wp)
      character(n) :: letters
      integer :: i, j, status

      do i = 1, n
         letters(i:i) = merge('R', 'L', mod(i, 2) == 1)
      end do
      work%pattern = new_pattern(letters, 1)
      work%restitution = osc%restitution([(2 - mod(i, 2), i=1, n)])
      allocate (work%r(points), work%phases(n, points), work%matrix(2*n, n + 2, points), &
         work%rhs(2*n, points), work%map(4, 4, points), work%impacts(n, 6, points), &
         work%scalars(6, points), work%multipliers(4, points), work%verdicts(3, points), &
         work%status(points))
      call repeatable()
      call random_number(random)
      work%r = 0.85_wp + 0.3_wp*random
      do j = 1, points
         call random_number(gaps)
         gaps = 0.5_wp + gaps
         gaps = two_pi*gaps/sum(gaps)
         work%phases(:, j) = [(sum(gaps(:i - 1)), i=1, n)]
         call start_motion(motion, osc, work%r(j), work%pattern, work%restitution, &
            work%phases(:, j))
         call assemble(motion, system)
         work%matrix(:, :, j) = system%matrix
         work%rhs(:, j) = system%rhs
         call solve_periodic(osc, work%r(j), work%pattern, work%restitution, work%phases(:, j), &
            system, motion)
         call stability_matrix(motion, work%map(:, :, j), status)
      end do
   end subroutine prepare

   !> The same points in every run.
   subroutine repeatable()
      integer :: length

      call random_seed(size=length)
      block
         integer :: seed(length)
         seed = 1983
         call random_seed(put=seed)
      end block
   end subroutine repeatable

   !> The linear solution and the eigenvalues, and the copies that LAPACK needs.
   subroutine bare_lapack(n, work, check)
      integer, intent(in) :: n
      type(work_type), intent(in) :: work
      real(wp), intent(inout) :: check
      real(wp) :: a(2*n, n + 2), b(2*n), map(4, 4), scratch(least_squares_work(2*n, n + 2))
      real(wp) :: real_part(4), imaginary_part(4), unused(1, 1), room(32)
      integer :: j, info, pivot(2*n)

      do j = 1, points
         a = work%matrix(:, :, j)
         b = work%rhs(:, j)
         if (n == 2) then
            call dgesv(4, 1, a, 4, pivot, b, 4, info)
         else
            call dgels('N', 2*n, n + 2, 1, a, 2*n, b, 2*n, scratch, size(scratch), info)
         end if
         map = work%map(:, :, j)
         call dgeev('N', 'N', 4, map, 4, real_part, imaginary_part, unused, 1, unused, 1, room, &
            size(room), info)
         check = check + abs(real_part(1))
      end do
   end subroutine bare_lapack

   subroutine chain(work, flights)
      type(work_type), intent(inout) :: work
      logical, intent(in) :: flights

      call periodic_points(osc, work%r, work%pattern, work%restitution, work%phases, &
         paper_acceptance, .false., flights, work%impacts, work%scalars, work%multipliers, &
         work%verdicts, work%status)
   end subroutine chain

   !> CPU time: other programs do not count.
   real(wp) function seconds()
      call cpu_time(seconds)
   end function seconds

   pure real(wp) function median(times)
      real(wp), intent(in) :: times(:)
      integer :: i

      do i = 1, size(times)
         median = times(i)
         if (2*count(times < median) > size(times)) cycle
         if (2*count(times > median) <= size(times)) return
      end do
   end function median

end module bench_chain

program reference_chain
   use bench_chain, only: measure
   implicit none (type, external)

   print '(a)', 'microseconds a point: (a) bare LAPACK, (b) chain without flights, (c) with flights'
   print '(a4, 3a12, 2a10, a10)', 'N', '(a)', '(b)', '(c)', '(b)/(a)', '(c)/(a)', 'computed'
   call measure(2)
   call measure(3)
   call measure(5)
   call measure(8)

end program reference_chain
