!> The derivative of a simulated motion of a structure by its initial state, event by event in
!! closed
!! form, through impacts, rests and releases.
module vi_structure_variation
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_eigen_routines, only: dgesv
   use vi_kinds, only: wp
   use vi_modes, only: advance
   use vi_status, only: stat
   use vi_structure, only: structure_type
   use vi_structure_map, only: apply_flight, apply_impact, from_coordinates, to_coordinates
   use vi_structure_run, only: impact_event, release_event, run_event_type, run_state_type, &
      run_type, &
      stick_event
   implicit none (type, external)
   private

   public :: derivative_of_run

contains

   !> The derivative of the final state by the initial one.
   pure subroutine derivative_of_run(run, first, events, last, p, largest, status)
      !> The structure, its load and its regimes.
      type(run_type), intent(in) :: run
      !> The state at the beginning.
      type(run_state_type), intent(in) :: first
      !> All events from there.
      type(run_event_type), intent(in) :: events(:)
      !> The state at the end.
      type(run_state_type), intent(in) :: last
      !> (2n, 2n) Derivatives of (q, q') by (q, q').
      real(wp), intent(out) :: p(:, :)
      !> The largest approach speed over the least one of impacts outside accumulations; 1 if there
      !! are none.
      real(wp), intent(out) :: largest
      !> `stat%ok`, `stat%zero_approach` or `stat%singular`.
      integer, intent(out) :: status
      real(wp), allocatable :: d(:, :), x(:), v(:), x_before(:), v_before(:)
      real(wp) :: elapsed, time, phase
      integer(int64) :: cycle
      integer :: i, number

      p = 0
      do i = 1, size(p, 1)
         p(i, i) = 1
      end do
      status = stat%ok
      largest = 1
      number = first%regime
      cycle = first%cycle
      elapsed = first%elapsed
      allocate (d(2*size(first%x), size(p, 2)))
      call from_coordinates(run%regimes(number), p, d)
      x = first%x
      v = first%v
      do i = 1, size(events)
         associate (event => events(i), regime => run%regimes(number))
            time = max(0.0_wp, real(event%cycle - cycle, wp)*run%period + (event%elapsed - elapsed))
            select case (event%kind)
            case (impact_event)
               phase = run%load%frequency*event%elapsed
               x_before = x
               v_before = v
               call advance(regime%modes, time, x, v, x_before, v_before)
               call apply_flight(regime, time, d)
               call apply_impact(run%structure, regime, event%gap, phase, event%speed, x_before, &
                  v_before, event%x, event%v, d, status)
               if (status /= stat%ok) return
            case (stick_event)
               ! the accumulation is completed at its last impact, and the rest begins there
               call to_coordinates(regime, d, p)
               call apply_rest(run%structure, run%regimes(event%regime)%resting, event%gap, p, &
                  status)
               if (status /= stat%ok) return
               deallocate (d)
               allocate (d(2*size(event%x), size(p, 2)))
               call from_coordinates(run%regimes(event%regime), p, d)
               call apply_flight(run%regimes(event%regime), time, d)
            case (release_event)
               call apply_flight(regime, time, d)
               call to_coordinates(regime, d, p)
               deallocate (d)
               allocate (d(2*size(event%x), size(p, 2)))
               call from_coordinates(run%regimes(event%regime), p, d)
            case default    ! there is no other kind
            end select
            number = event%regime
            cycle = event%cycle
            elapsed = event%elapsed
            x = event%x
            v = event%v
         end associate
      end do
      time = max(0.0_wp, real(last%cycle - cycle, wp)*run%period + (last%elapsed - elapsed))
      call apply_flight(run%regimes(number), time, d)
      call to_coordinates(run%regimes(number), d, p)
      largest = spread_of_speeds(events)
   end subroutine derivative_of_run

   !> The largest approach speed over the least one, without impacts that an accumulation follows.
   pure real(wp) function spread_of_speeds(events) result(spread)
      !> The events.
      type(run_event_type), intent(in) :: events(:)
      real(wp) :: least, largest
      integer :: i, j

      least = huge(1.0_wp)
      largest = 0
      do i = 1, size(events)
         if (events(i)%kind /= impact_event) cycle
         largest = max(largest, events(i)%speed)
         ! the next event of the same gap other than an impact is the end of its accumulation
         do j = i + 1, size(events)
            if (events(j)%gap == events(i)%gap .and. events(j)%kind /= impact_event) exit
         end do
         if (j > size(events)) least = min(least, events(i)%speed)
      end do
      spread = 1
      if (least < largest) spread = largest/least
   end function spread_of_speeds

   !> Multiplies a derivative by that of the end of an accumulation: with the projection Pi onto
   !! velocities that keep the gaps closed,
   !!
   !!     Q = [ Pi, 0 ; Pi M^-1 C M^-1 G m G^T, Pi ]
   pure subroutine apply_rest(structure, resting, gap, p, status)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The gaps that rest from now on, and the one that began to.
      integer, intent(in) :: resting(:), gap
      !> (2n, columns) In and out: derivatives of q, then of q'.
      real(wp), intent(inout) :: p(:, :)
      !> `stat%ok` or `stat%singular`.
      integer, intent(out) :: status
      real(wp), allocatable :: carried(:, :), mass(:, :)
      integer, allocatable :: pivot(:)
      integer :: i, n, info

      n = size(p, 1)/2
      allocate (carried(n, 1), pivot(n))
      allocate (mass, source=structure%mass)
      carried(:, 1) = matmul(structure%damping, structure%mobility(:, gap))
      call dgesv(n, 1, mass, n, pivot, carried, n, info)
      status = merge(stat%ok, stat%singular, info == 0)
      if (info /= 0) return
      do i = 1, size(p, 2)
         p(n + 1:, i) = p(n + 1:, i) + carried(:, 1)*structure%effective(gap)* &
            dot_product(structure%directions(:, gap), p(:n, i))
      end do
      call project(structure, resting, p(:n, :), status)
      if (status == stat%ok) call project(structure, resting, p(n + 1:, :), status)
   end subroutine apply_rest

   !> Removes from vectors the part that closes or opens some gaps.
   pure subroutine project(structure, gaps, vectors, status)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The gaps.
      integer, intent(in) :: gaps(:)
      !> (n, columns) In and out.
      real(wp), intent(inout) :: vectors(:, :)
      !> `stat%ok` or `stat%singular`.
      integer, intent(out) :: status
      real(wp) :: gram(size(gaps), size(gaps)), parts(size(gaps), size(vectors, 2))
      real(wp), dimension(size(vectors, 1), size(gaps)) :: directions, kicks
      integer :: pivot(size(gaps)), info

      directions = structure%directions(:, gaps)
      kicks = structure%mobility(:, gaps)
      gram = matmul(transpose(directions), kicks)
      parts = matmul(transpose(directions), vectors)
      call dgesv(size(gaps), size(parts, 2), gram, size(gaps), pivot, parts, size(gaps), info)
      status = merge(stat%ok, stat%singular, info == 0)
      if (info == 0) vectors = vectors - matmul(kicks, parts)
   end subroutine project

end module vi_structure_variation
