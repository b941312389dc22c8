!> The motions on which simulations settle, from value to value of parameters.
!!
!! Simulations form chains. Along a chain the parameters change from link to link and the state is
!! carried over, so that a chain is a sweep; chains of one link are independent initial states.
module vi_chains
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_kinds, only: wp
   use vi_progress, only: add_done_work, add_expected_work, is_stopped
   use vi_simulated_motion, only: cell_type, examination_type, simulated_motion_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: settle_chains

   !> The parameters and initial states of simulations.
   type, abstract, public :: chains_type
      !> Numbers of links of each chain, and of chains.
      integer :: links = 1, chains = 1
      !> Numbers of coordinates that are measured, of numbers of a state, and of an impact.
      integer :: sizes(3) = 1
   contains
      procedure(go_to_in), deferred :: go_to
   end type chains_type

   abstract interface
      !> Brings a simulation to a link of a chain.
      subroutine go_to_in(chains, link, chain, motion, status)
         import :: chains_type, simulated_motion_type
         implicit none (type, external)
         !> The chains.
         class(chains_type), intent(in) :: chains
         !> Numbers of the link and of the chain.
         integer, intent(in) :: link, chain
         !> In: the simulation at the link before, if there is one. Out: at this link.
         class(simulated_motion_type), allocatable, intent(inout) :: motion
         !> In: the status at the link before. Out: `stat%ok`, or why there is no simulation.
         integer, intent(inout) :: status
      end subroutine go_to_in
   end interface

contains

   !> Settles and examines the motion at each link; each chain is a separate task.
   subroutine settle_chains(chains, how, threads, cells, progress)
      !> The chains.
      class(chains_type), intent(in) :: chains
      !> How each motion is examined.
      type(examination_type), intent(in) :: how
      !> Number of OpenMP threads.
      integer, intent(in) :: threads
      !> What was found; empty from the link at which the study was stopped.
      type(cell_type), intent(out) :: cells(chains%links, chains%chains)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      integer :: i

      call add_expected_work(size(cells), progress)
      !$omp parallel do schedule(dynamic, 1) num_threads(threads)
      do i = 1, chains%chains
         call along(chains, i, how, cells(:, i), progress)
      end do
      !$omp end parallel do
   end subroutine settle_chains

   !> Settles and examines the motions along a chain.
   subroutine along(chains, chain, how, cells, progress)
      !> The chains.
      class(chains_type), intent(in) :: chains
      !> Number of the chain.
      integer, intent(in) :: chain
      !> How each motion is examined.
      type(examination_type), intent(in) :: how
      !> (links) In: empty. Out: what was found.
      type(cell_type), intent(inout) :: cells(:)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      class(simulated_motion_type), allocatable :: motion
      integer :: i, status

      do i = 1, size(cells)
         associate (sizes => chains%sizes, cell => cells(i))
            allocate (cell%extent(sizes(1), 3), source=ieee_value(1.0_wp, ieee_quiet_nan))
            allocate (cell%strobes(sizes(2), 0), cell%gaps(0), cell%hits(sizes(3), 0))
         end associate
      end do
      status = stat%ok
      do i = 1, size(cells)
         if (is_stopped(progress)) return
         call chains%go_to(i, chain, motion, status)
         if (status == stat%ok) then
            call motion%examine(how, cells(i), progress)
            status = cells(i)%status
         end if
         cells(i)%status = status
         if (status == stat%not_computed) return
         call add_done_work(1, progress)
      end do
   end subroutine along

end module vi_chains
