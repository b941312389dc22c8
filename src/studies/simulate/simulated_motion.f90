!> What averages and sweeps know of a simulation that goes on: load cycles, the growth of small
!! changes meanwhile, and the motion on which it settles. The oscillator and structures extend its
!! type.
module vi_simulated_motion
   use vi_kinds, only: wp
   use vi_status, only: stat
   implicit none (type, external)
   private

   !> The growth of some directions, averaged over batches of load cycles.
   type, public :: growth_type
      !> Batch -1 is a transient, and batch 0 is the last one that does not count: directions still
      !! settle in it. Number of batches that count, and load cycles in each of them.
      integer :: batch = -1, batches = 2, cycles = 0
      !> (2, 0:directions) Weighted sums over all batches together, and over the present one: of the
      !! time, and of the logarithms of the growth.
      real(wp), allocatable :: sums(:, :)
      !> Number of directions that are not lost.
      integer :: rank = 0
      !> Time; what damping and impacts make of the logarithm of the volume; the difference between
      !! the sum of all logarithms and that.
      real(wp) :: time = 0, volume = 0, difference = 0
      integer :: impacts = 0, rests = 0
   contains
      procedure :: add
   end type growth_type

   !> How a motion is examined once it has settled.
   type, public :: examination_type
      !> Load cycles before, those that are examined, most impacts that are kept, and events until
      !! the simulation is given up.
      integer :: settling = 0, keep = 3, points = 0, max_events = huge(1)
      !> Whether a state is kept for each load cycle, not only the last one.
      logical :: strobes = .false.
   end type examination_type

   !> What was found when a motion was examined.
   type, public :: cell_type
      !> `stat%ok`, or why there is nothing.
      integer :: status = stat%not_computed
      !> Load cycles of the period, 0 if none is confirmed; symbols, impacts and rests in it, or in
      !! all cycles that were examined. Structures have no symbols; with stops or friction all
      !! events but rests and releases count as impacts.
      integer :: cycles = 0, symbols = 0, impacts = 0, rests = 0
      !> (coordinates, 3) Least and greatest values, and roots of the mean squares; of the
      !! oscillator the least and greatest x.
      real(wp), allocatable :: extent(:, :)
      !> (numbers, states) States at the ends of load cycles, the last one at the end: q and q', or
      !! t, x, x', z, z'.
      real(wp), allocatable :: strobes(:, :)
      !> (impacts) Gaps, or sides (+1 right, -1 left), and (numbers, impacts) load phases within a
      !! cycle and approach speeds, or numbers as in `store_events`.
      integer, allocatable :: gaps(:)
      real(wp), allocatable :: hits(:, :)
      !> (impacts) Their kinds, of a structure, whose stops and friction have other events.
      integer, allocatable :: kinds(:)
   end type cell_type

   !> A motion that is simulated.
   type, abstract, public :: simulated_motion_type
      !> Number of events that it may still have.
      integer :: left = huge(1)
      !> A period of the load, and the unit of time of its growth.
      real(wp) :: period = 1, unit = 1
      !> Number of directions in which a state can change.
      integer :: dimensions = 0
   contains
      procedure(grow_in), deferred :: grow
      procedure(examine_in), deferred :: examine
   end type simulated_motion_type

   abstract interface
      !> Simulates whole load cycles, and adds the growth of the directions in them.
      subroutine grow_in(motion, cycles, growth, status, progress)
         import :: growth_type, simulated_motion_type
         implicit none (type, external)
         !> In and out: the motion.
         class(simulated_motion_type), intent(inout) :: motion
         !> Load cycles.
         integer, intent(in) :: cycles
         !> In and out: the growth.
         type(growth_type), intent(inout) :: growth
         !> `stat%ok`; `stat%event_limit`, `stat%not_computed` if it was stopped, or a status of the
         !! simulation.
         integer, intent(out) :: status
         !> Progress counters, see vi_progress; read to stop.
         integer, intent(inout), optional :: progress(3)
      end subroutine grow_in

      !> Simulates a transient, and examines the load cycles after it.
      subroutine examine_in(motion, how, cell, progress)
         import :: cell_type, examination_type, simulated_motion_type
         implicit none (type, external)
         !> In: the motion. Out: at the end of the last load cycle.
         class(simulated_motion_type), intent(inout) :: motion
         !> How it is examined.
         type(examination_type), intent(in) :: how
         !> In: empty. Out: what was found.
         type(cell_type), intent(inout) :: cell
         !> Progress counters, see vi_progress; read to stop.
         integer, intent(inout), optional :: progress(3)
      end subroutine examine_in
   end interface

contains

   !> Adds the growth over some time.
   pure subroutine add(growth, logs, duration, place)
      !> In and out: the growth.
      class(growth_type), intent(inout) :: growth
      !> (directions that are not lost, or all) Logarithms of the growth.
      real(wp), intent(in) :: logs(:)
      !> The time, in the unit of the motion.
      real(wp), intent(in) :: duration
      !> Load cycles from the beginning of the batch.
      real(wp), intent(in) :: place
      real(wp) :: weights(2)
      integer :: j

      associate (cycles => real(growth%cycles, wp))
         weights = [bump((place + (growth%batch - 1)*cycles)/(cycles*growth%batches)), &
            bump(place/cycles)]
      end associate
      do j = 1, size(logs)
         growth%sums(:, j) = growth%sums(:, j) + weights*logs(j)
      end do
      growth%sums(:, 0) = growth%sums(:, 0) + weights*duration
   end subroutine add

   !> A weight that rises smoothly from 0 and falls smoothly back to 0 over [0, 1].
   !!
   !! With this weight, averages over periodic and quasi-periodic motions converge faster than any
   !! power of the time; those over chaotic motions converge as fast as without it.
   pure real(wp) function bump(s)
      !> Place in the interval.
      real(wp), intent(in) :: s

      bump = 0
      if (s > 1.0e-3_wp .and. s < 1 - 1.0e-3_wp) bump = exp(-1/(s*(1 - s)))
   end function bump

end module vi_simulated_motion
