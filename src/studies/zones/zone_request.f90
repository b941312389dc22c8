!> The surface of motions over a window of the plane (r, log D), on which zones are sought.
module vi_zone_request
   use vi_curve, only: curve_type
   use vi_kinds, only: wp
   use vi_motion_family, only: condition_type, edge
   use vi_orbit, only: by_clearance, by_r
   use vi_oscillator, only: left, oscillator_type, right
   use vi_oscillator_families, only: choose_family
   use vi_pattern, only: pattern_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: is_neutral, make_surface

   !> What to search, and the effort.
   type, public :: zone_request_type
      !> What is searched for; not needed around a motion that is known.
      type(oscillator_type) :: osc = oscillator_type()
      !> Sides; +2 and -2 for accumulation and rest.
      type(pattern_type) :: pattern = pattern_type()
      logical :: symmetric = .false.
      real(wp) :: r(2) = 0, clearance(2) = 0
      !> Lattice lines in each direction (more in a large window), guesses at each node where
      !! motions are sought.
      integer :: lines = 17, guesses = 12
      !> Largest number of points of a loop.
      integer :: points = 20000
      !> Simulations at first that show motions without rest; there are more of them if they show
      !! motions that Newton's method has not found.
      integer :: simulations = 0
   end type zone_request_type

   !> Units of length along r and log D: the window of the 1983 charts, unless it is smaller.
   real(wp), parameter :: unit(2) = [0.4_wp, log(100.0_wp)]

contains

   !> Whether no motion of an oscillator is asymptotically stable: nothing dissipates.
   !!
   !! With mu = 0 the primary mass loses energy by damping alone, and the free mass by impacts
   !! alone.
   pure logical function is_neutral(osc)
      !> Oscillator.
      type(oscillator_type), intent(in) :: osc
      logical :: undamped, elastic

      undamped = osc%xi <= 0
      elastic = all(osc%restitution >= 1)
      is_neutral = (undamped .and. elastic) .or. (osc%mu <= 0 .and. (undamped .or. elastic))
   end function is_neutral

   !> The family in the window, with both parameters active.
   subroutine make_surface(request, surface, status)
      !> The request.
      type(zone_request_type), intent(in) :: request
      !> The family; r and log D are 0 at the lower corner of the window.
      type(curve_type), intent(out) :: surface
      !> `stat%ok`, or `stat%no_motion` if the pattern cannot have such motions.
      integer, intent(out) :: status
      real(wp) :: low(2), high(2)
      logical :: possible
      integer :: i

      associate (osc => request%osc, walls => request%osc%restitution)
         call choose_family(request%pattern, request%symmetric, abs(walls(1) - walls(2)) <= 0, &
            surface%family, possible)
         status = merge(stat%ok, stat%no_motion, possible)
         low = [request%r(1), log(request%clearance(1))]
         high = [request%r(2), log(request%clearance(2))]
         surface%c = [low, osc%xi, osc%mu, walls(right), walls(left)]
      end associate
      surface%active = [by_r, by_clearance]
      surface%origin = low
      surface%scale = min(high - low, unit)
      allocate (surface%edges(4))
      do i = 1, 2
         surface%edges(2*i - 1) = condition_type(edge, i, 1, bound=low(i))
         surface%edges(2*i) = condition_type(edge, i, -1, bound=high(i))
      end do
   end subroutine make_surface

end module vi_zone_request
