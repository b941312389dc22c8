!> The response of the primary mass over all coexisting attractors.
module vi_attractor_response
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_attractor_settled, only: settle_chains
   use vi_attractor_spread, only: spread_states
   use vi_kinds, only: wp
   use vi_oscillator, only: gain, oscillator_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: respond

contains

   !> max|X|/A of the motions on which evenly spread initial states settle, at n points.
   subroutine respond(osc, r, clearance, load, settling, keep, max_events, threads, attenuation, &
      envelope, periods, status, progress)
      !> Oscillator, the same at all points.
      type(oscillator_type), intent(in) :: osc
      !> (n) each
      real(wp), intent(in) :: r(:), clearance(:)
      !> Load amplitude f.
      real(wp), intent(in) :: load
      !> Load cycles simulated first, and load cycles examined.
      integer, intent(in) :: settling, keep
      !> Largest number of events of a simulation, and number of OpenMP threads.
      integer, intent(in) :: max_events, threads
      !> (states, n): NaN where a simulation failed.
      real(wp), intent(out) :: attenuation(:, :)
      !> (2, n): least and greatest over the states; NaN if all failed.
      real(wp), intent(out) :: envelope(:, :)
      !> (4, states, n): period (0 where none is confirmed), symbols, impacts, rests; (states, n):
      !! status of each simulation.
      integer, intent(out) :: periods(:, :, :), status(:, :)
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      integer, parameter :: capacity = 1
      real(wp), allocatable :: parameters(:, :, :), starts(:, :), impacts(:, :, :, :), &
         extremes(:, :, :), ends(:, :, :)
      integer, allocatable :: labels(:, :, :, :), found(:, :), counts(:, :, :), ends_status(:, :)
      real(wp) :: nan
      integer :: states, n, j, m

      nan = ieee_value(load, ieee_quiet_nan)
      states = size(attenuation, 1)
      n = size(r)
      m = states*n
      allocate (parameters(6, 1, m), starts(5, m), impacts(7, capacity, 1, m), labels(2, capacity, &
         1, m), found(1, m), counts(4, 1, m), extremes(2, 1, m), ends(5, 1, m), ends_status(1, m))
      do j = 1, n
         parameters(:, 1, (j - 1)*states + 1:j*states) = spread([r(j), clearance(j), osc%xi, &
            osc%mu, osc%restitution], 2, states)
         starts(:, (j - 1)*states + 1:j*states) = spread_states(osc, r(j), load, clearance(j), &
            states)
      end do
      call settle_chains(parameters, load, starts, settling, keep, 0.0_wp, max_events, threads, &
         impacts, labels, found, counts, extremes, ends, ends_status, progress)
      status = reshape(ends_status, [states, n])
      periods = reshape(counts, [4, states, n])
      periods(1, :, :) = max(0, periods(1, :, :))
      attenuation = reshape(max(-extremes(1, 1, :), extremes(2, 1, :)), [states, n])
      do j = 1, n
         associate (each => attenuation(:, j), good => status(:, j) == stat%ok)
            each = merge(each/(load*gain(osc%xi, r(j))), nan, good)
            envelope(:, j) = nan
            if (any(good)) envelope(:, j) = [minval(each, good), maxval(each, good)]
         end associate
      end do
   end subroutine respond

end module vi_attractor_response
