!> A linear structure with gaps and elastic stops under a load, and its motion while a given set of
!! them is closed.
!!
!! M q'' + C q' + K q = f(t) + g with q in R^n; all bodies are treated alike. Gap j stays open: e_j
!! - G_j.q >= 0. While a set of gaps is at rest, G_j.q = e_j for each of them, the structure has one
!! coordinate fewer for each, and each pushes back with a force p_j >= 0. A stop is a gap that can
!! be compressed beyond closure: it adds k G_j G_j^T to K and c G_j G_j^T to C while it presses.
!!
!! Dry friction is in the same lists. Along D_j, with s = D_j.q' - V, the force -h sgn(s) D_j
!! acts while it slips; while it sticks, D_j.q' = V, a force of at most H holds it. The place D_j.q,
!! which moves with the belt, is then one more pair of frequency 0. Along a gap at rest, friction
!! without a belt holds too: the gap pushes with p >= -H.
module vi_structure
   use vi_columns, only: solve_columns
   use vi_decoupling, only: decouple, decoupled_type
   use vi_eigen_routines, only: dgeqrf, dorgqr
   use vi_kinds, only: wp
   use vi_modes, only: interval_type, levels, modes_type, new_interval, new_steps, prepare, &
      steady_response, steps_type
   use vi_restitution, only: constant_law, friction_law, new_restitution, pushing_law, &
      restitution_at, restitution_type, stop_law
   use vi_rows, only: add_harmonic, free_value, free_values, new_rows, renew_rows, rows_type
   use vi_status, only: stat
   implicit none (type, external)
   private

   public :: acts_on, check_structure, coordinate_of, factor_along, find_narrow, inputs_of, &
      is_absorbed, is_extreme, linked_elements, new_load, new_regime, new_structure, opening_at, &
      project, renew_regime, restitution_of, state_of, to_pairs

   !> The shortest time scale, and the sizes of lengths and masses, for which the powers in bounds
   !! on derivatives up to the 21st are represented; an opening from which on a gap never closes.
   real(wp), parameter :: shortest_unit = 1.0e-12_wp, smallest = 1.0e-40_wp, &
      largest = 1.0e40_wp, never = 1.0e290_wp

   !> What follows where coupled gaps close at one instant: a status, Newton's law at all of them at
   !! once, or impacts one after the other.
   integer, parameter, public :: refused = 0, by_newton = 1, in_sequence = 2
   !> Factor with which these are added to the kind of the law of each gap, in addition to 10 times
   !! its number of harmonics.
   integer, parameter, public :: law_unit = 10000

   !> A structure and its gaps.
   type, public :: structure_type
      !> (n, n) M, C and K.
      real(wp), allocatable, dimension(:, :) :: mass, damping, stiffness
      !> (n, gaps) G_j.
      real(wp), allocatable :: directions(:, :)
      !> (gaps) Openings e_j, coefficients of restitution at speed 0, and effective masses
      !! 1/(G_j.M^-1 G_j).
      real(wp), allocatable :: openings(:), restitution(:), effective(:)
      !> (gaps) The coefficients of restitution as functions of the approach speed.
      type(restitution_type), allocatable :: laws(:)
      !> (n, gaps) M^-1 G_j: the change of q' due to an impulse of -1.
      real(wp), allocatable :: mobility(:, :)
      !> (gaps) The channel of each gap, and whether it is the upper wall (+1) or the lower one
      !! (-1).
      integer, allocatable :: channel(:), wall(:)
      !> The coordinates that close each gap and their parts of its direction: those of gap j are
      !! at(begins(j):begins(j + 1) - 1).
      integer, allocatable :: begins(:), at(:)
      real(wp), allocatable :: part(:)
      !> The other gaps whose speed an impulse on gap j changes: coupled(coupled_begins(j):
      !! coupled_begins(j + 1) - 1).
      integer, allocatable :: coupled_begins(:), coupled(:)
      !> Number of channels: directions along which a stop, one gap or two opposite ones lie, and
      !! then the forces of stops that cannot pull, and the speeds of friction; number of the first
      !! kind.
      integer :: channels = 0, positions = 0
      !> (gaps) Whether each is an elastic stop, and whether any is.
      logical, allocatable :: elastic(:)
      logical :: has_stops = .false.
      !> (gaps) Whether each is dry friction, and whether any is.
      logical, allocatable :: rubs(:)
      logical :: has_friction = .false.
      !> (gaps) The channel of the force of each stop that cannot pull; else 0.
      integer, allocatable :: push(:)
      !> (harmonics, gaps) Walls that move: the opening of gap j is e_j + the sum over h of
      !! Re(motion(h, j) e^(i h Omega t)), with Omega of the load. Whether any wall does.
      complex(wp), allocatable :: motion(:, :)
      logical :: moves = .false.
      !> What follows where coupled gaps close at one instant: `refused`, `by_newton` or
      !! `in_sequence`.
      integer :: simultaneous = 0
      !> Whether damping may be slightly below 0, as in `decouple`.
      logical :: may_grow = .false.
   end type structure_type

   !> A load f(t) = sum over h of cosine_h cos(h Omega t) + sine_h sin(h Omega t), plus a constant.
   type, public :: load_type
      !> Omega; 0 if there are no harmonics.
      real(wp) :: frequency = 0
      !> (n, harmonics)
      real(wp), allocatable, dimension(:, :) :: cosine, sine
      !> (n)
      real(wp), allocatable :: constant(:)
      !> A record that is added: (n, samples) forces, linear between samples, from time 0 on; 0
      !! after the last one. The time between samples; 0 without a record.
      real(wp), allocatable :: record(:, :)
      real(wp) :: step = 0
   end type load_type

   !> What of a regime follows from the matrices, directions and laws alone, and these.
   type, public :: shape_type
      !> (n, n) M, and C and K with the stops that press; (n, gaps) G_j.
      real(wp), allocatable, dimension(:, :) :: mass, damping, stiffness, directions
      !> (2, gaps) Stiffness and damping of the stops that cannot pull; whether friction has a belt.
      real(wp), allocatable :: pushing(:, :)
      logical, allocatable :: belts(:)
      !> (n, k) and (k, k) As in `complete_regime`: the basis, and M in it; (m, k) x and v of its
      !! pairs from velocities.
      real(wp), allocatable, dimension(:, :) :: basis, reduced, xd, vd
      !> (rows, n) Coefficients of q, q' and the forces in the rows.
      real(wp), allocatable, dimension(:, :) :: of_q, of_rate, of_force
   end type shape_type

   !> The structure while a set of gaps is at rest and a set of stops presses; free without any.
   !!
   !! A row is a channel or the force of a closed gap, as a sum over the pairs (x, v), the harmonics
   !! of the load and a constant. Rows are watched: a channel must stay between its walls and a
   !! force above 0.
   type, public :: regime_type
      !> The gaps at rest, in ascending order.
      integer, allocatable :: resting(:)
      !> These and the gaps of friction that sticks.
      integer, allocatable :: held(:)
      !> Gaps at rest, stops that press, and friction that sticks; -j for a stop j that is closed
      !! without a force, and for friction that slips with s < 0. In ascending order.
      integer, allocatable :: closed(:)
      !> Number of channels that are positions.
      integer :: positions = 0
      !> The pairs.
      type(modes_type) :: modes
      !> q = offset + qx x + qv v + steady part, and q' likewise: (n, m).
      real(wp), allocatable, dimension(:, :) :: qx, qv, dx, dv
      !> The inverse relation: (m, n).
      real(wp), allocatable, dimension(:, :) :: xq, xd, vq, vd
      !> (n) The point about which the closed gaps hold the structure.
      real(wp), allocatable :: offset(:)
      !> (n, harmonics) Steady motion and its velocity: Re(.. e^(i h Omega t)).
      complex(wp), allocatable, dimension(:, :) :: steady, steady_rate
      !> (m, harmonics) Complex amplitudes of p and f of the pairs under the harmonics.
      complex(wp), allocatable, dimension(:, :) :: wave_drift, wave_force
      !> (rows, m) Coefficients of x and v in each row, and in its rate.
      real(wp), allocatable, dimension(:, :) :: position, velocity, rate_position, rate_velocity
      !> (rows) Constants of each row and of its rate.
      real(wp), allocatable, dimension(:) :: row_offset, rate_offset
      !> (rows, harmonics)
      complex(wp), allocatable :: ripple(:, :)
      !> (rows) Limits between which a row has to stay, and the gaps that close there; 0 if none
      !! does.
      real(wp), allocatable, dimension(:) :: upper, lower
      integer, allocatable, dimension(:) :: upper_gap, lower_gap
      !> The rows and the coordinates, for fast evaluation.
      type(rows_type) :: rows, coordinates
      !> (m, gaps) Change of x and v due to an impulse of -1 on each gap.
      real(wp), allocatable, dimension(:, :) :: kick_x, kick_v
      !> (rows, rows) Bounds on the change of the rates of the rows for some time after an impulse
      !! of 1 on a gap of each row, filled in by vi_watch at the first impact there; below 0 before.
      real(wp), allocatable :: reach(:, :)
      !> (rows) Roots of the sums of squares of the second derivatives of the pairs after such an
      !! impulse, filled in likewise.
      real(wp), allocatable :: bend(:)
      !> The shortest time scale: 1 over the largest of omega, 2 sigma and Omega; if all are 0, the
      !! time between the samples of a record, or 1.
      real(wp) :: unit = 1
      !> Tables for steps in time, and (harmonics, levels) e^(i h Omega h_j).
      type(steps_type) :: steps
      complex(wp), allocatable :: turns(:, :)
      !> Omega of the load.
      real(wp) :: frequency = 0
      !> With a record: (m, n) from forces to p and to f, (rows, n) to the rows; p, f and the
      !! constants of the rows without the record.
      real(wp), allocatable, dimension(:, :) :: to_drift, to_force, to_rows
      real(wp), allocatable, dimension(:) :: base_drift, base_force, base_offset
      !> Whether p of any pair depends on the record, and whether an impulse changes any x.
      logical :: drifts = .false., kicks_x = .true.
      !> What advances the pairs from one sample to the next one.
      type(interval_type) :: interval
      !> What `renew_regime` needs.
      type(shape_type), allocatable :: shape
   end type regime_type

contains

   !> A structure from arrays.
   pure function new_structure(matrices, directions, gap_values) result(structure)
      !> (n, n, 3) M, C and K; (n, gaps) G_j; (2, gaps) opening and restitution of each gap, or with
      !! laws (3 or more, gaps): opening, and kind and numbers of its law as in `new_restitution`.
      !! Where a wall moves with H harmonics, 10 H is added to the kind, and their cosines and sines
      !! in turns come before the numbers; `law_unit` times `simultaneous` is added, too.
      real(wp), intent(in) :: matrices(:, :, :), directions(:, :), gap_values(:, :)
      type(structure_type) :: structure
      integer :: harmonics(size(gap_values, 2)), kinds(size(gap_values, 2)), h, j

      allocate (structure%mass, source=matrices(:, :, 1))
      allocate (structure%damping, source=matrices(:, :, 2))
      allocate (structure%stiffness, source=matrices(:, :, 3))
      allocate (structure%directions, source=directions)
      allocate (structure%openings, source=gap_values(1, :))
      allocate (structure%laws(size(gap_values, 2)), structure%restitution(size(gap_values, 2)))
      harmonics = 0
      kinds = constant_law
      if (size(gap_values, 1) > 2) then
         kinds = nint(gap_values(2, :))
         structure%simultaneous = maxval([refused, kinds/law_unit])
         kinds = modulo(kinds, law_unit)
         harmonics = kinds/10
         kinds = modulo(kinds, 10)
      end if
      structure%moves = any(harmonics > 0)
      allocate (structure%motion(maxval([0, harmonics]), size(harmonics)), source=(0.0_wp, 0.0_wp))
      do j = 1, size(gap_values, 2)
         if (size(gap_values, 1) == 2) then
            structure%laws(j) = new_restitution(real(constant_law, wp), gap_values(2:, j))
         else
            structure%laws(j) = new_restitution(real(kinds(j), wp), &
               gap_values(3 + 2*harmonics(j):, j))
            do h = 1, harmonics(j)
               structure%motion(h, j) = cmplx(gap_values(1 + 2*h, j), -gap_values(2 + 2*h, j), wp)
            end do
         end if
         structure%restitution(j) = structure%laws(j)%numbers(1)
         if (is_element(structure%laws(j))) structure%restitution(j) = 0
      end do
   end function new_structure

   !> The opening of a gap at q = 0 and an instant, with its first two derivatives with respect to
   !! time.
   pure function opening_at(structure, gap, phase, frequency) result(opening)
      !> The structure, and the number of the gap.
      type(structure_type), intent(in) :: structure
      integer, intent(in) :: gap
      !> Load phase (rad), and Omega.
      real(wp), intent(in) :: phase, frequency
      real(wp) :: opening(0:2)
      complex(wp) :: here
      integer :: h

      opening = [structure%openings(gap), 0.0_wp, 0.0_wp]
      if (.not. structure%moves) return
      do h = 1, size(structure%motion, 1)
         here = structure%motion(h, gap)*cmplx(cos(h*phase), sin(h*phase), wp)
         opening = opening + [here%re, -h*frequency*here%im, -(h*frequency)**2*here%re]
      end do
   end function opening_at

   !> Whether a law is that of an elastic stop or of friction, not one of restitution.
   elemental logical function is_element(law)
      !> The law.
      type(restitution_type), intent(in) :: law

      is_element = is_stop(law) .or. law%kind == friction_law
   end function is_element

   !> Whether a law is that of an elastic stop.
   elemental logical function is_stop(law)
      !> The law.
      type(restitution_type), intent(in) :: law

      is_stop = law%kind == stop_law .or. law%kind == pushing_law
   end function is_stop

   !> The coefficient of restitution of a gap at an approach speed, and its derivative.
   pure subroutine restitution_of(structure, gap, speed, value, slope)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The gap.
      integer, intent(in) :: gap
      !> Approach speed v >= 0.
      real(wp), intent(in) :: speed
      !> R and dR/dv, as in `restitution_at`.
      real(wp), intent(out) :: value, slope

      if (structure%laws(gap)%kind == constant_law) then
         value = structure%restitution(gap)
         slope = 0
      else
         call restitution_at(structure%laws(gap), speed, value, slope)
      end if
   end subroutine restitution_of

   !> A load from arrays.
   pure function new_load(frequency, harmonics, constant, step, record) result(load)
      !> Omega; (n, 2, harmonics) cosine and sine part of each; (n) constant part.
      real(wp), intent(in) :: frequency, harmonics(:, :, :), constant(:)
      !> Time between the samples of a record (0 without one); (n, samples) the forces.
      real(wp), intent(in), optional :: step, record(:, :)
      type(load_type) :: load

      load%frequency = frequency
      allocate (load%cosine, source=harmonics(:, 1, :))
      allocate (load%sine, source=harmonics(:, 2, :))
      allocate (load%constant, source=constant)
      if (.not. present(step) .or. .not. present(record)) return
      load%step = step
      if (step > 0) allocate (load%record, source=record)
   end function new_load

   !> Completes a structure: effective masses and channels.
   pure subroutine check_structure(structure, status)
      !> In: M, C, K, directions, openings and restitution. Out: also what follows from them, anew
      !! if it was set.
      type(structure_type), intent(inout) :: structure
      !> `stat%ok`, `stat%mass_not_definite`, or `stat%extreme_units` where a mass is.
      integer, intent(out) :: status
      integer :: i, j

      status = stat%ok
      if (allocated(structure%channel)) deallocate (structure%channel, structure%wall, &
         structure%begins, structure%at, structure%part, structure%coupled_begins, &
         structure%coupled, structure%push)
      if (any([(is_extreme(structure%mass(i, i)), i=1, size(structure%mass, 1))])) status = &
         stat%extreme_units
      if (status /= stat%ok) return
      if (.not. allocated(structure%motion)) allocate (structure%motion(0, &
         size(structure%openings)))
      structure%mobility = structure%directions
      call solve_columns(structure%mass, structure%mobility, status)
      if (status /= stat%ok) status = stat%mass_not_definite
      if (status /= stat%ok) return
      associate (gaps => size(structure%directions, 2))
         structure%effective = 1/sum(structure%directions*structure%mobility, 1)
         structure%elastic = is_stop(structure%laws)
         structure%has_stops = any(structure%elastic)
         structure%rubs = structure%laws%kind == friction_law
         structure%has_friction = any(structure%rubs)
         allocate (structure%channel(gaps), structure%wall(gaps))
         allocate (structure%push(gaps), source=0)
         structure%channels = 0
         do i = 1, gaps
            structure%wall(i) = 1
            structure%channel(i) = 0
            if (structure%rubs(i)) cycle
            do j = 1, i - 1
               if (structure%elastic(i) .or. structure%elastic(j) .or. structure%rubs(j)) cycle
               if (structure%moves) then
                  if (any(abs(structure%motion(:, [i, j])) > 0)) cycle
               end if
               if (any(abs(structure%directions(:, i) + structure%directions(:, j)) > 0)) cycle
               if (count(structure%channel(:i - 1) == structure%channel(j)) > 1) cycle
               structure%channel(i) = structure%channel(j)
               structure%wall(i) = -1
               exit
            end do
            if (structure%channel(i) > 0) cycle
            structure%channels = structure%channels + 1
            structure%channel(i) = structure%channels
         end do
         structure%positions = structure%channels
         do i = 1, gaps
            if (structure%rubs(i)) then
               structure%channels = structure%channels + 1
               structure%channel(i) = structure%channels
            end if
            ! without a dashpot a closed stop always pushes
            if (structure%laws(i)%kind /= pushing_law) cycle
            if (.not. structure%laws(i)%numbers(2) > 0) cycle
            structure%channels = structure%channels + 1
            structure%push(i) = structure%channels
         end do
      end associate
      call set_lists(structure)
   end subroutine check_structure

   !> The lists of coordinates that close gaps, and of gaps that are coupled.
   pure subroutine set_lists(structure)
      !> In and out: filled in.
      type(structure_type), intent(inout) :: structure
      !> Coupling over the roots of the effective masses that counts as none.
      real(wp), parameter :: no_coupling = 1.0e-12_wp
      integer, allocatable :: here(:)
      real(wp), allocatable :: speeds(:)
      integer :: gaps, i, j, n

      n = size(structure%directions, 1)
      gaps = size(structure%directions, 2)
      allocate (structure%begins(gaps + 1), structure%coupled_begins(gaps + 1), source=1)
      allocate (structure%at(count(abs(structure%directions) > 0)))
      allocate (structure%part(size(structure%at)), structure%coupled(0))
      do j = 1, gaps
         here = pack([(i, i=1, n)], abs(structure%directions(:, j)) > 0)
         i = structure%begins(j)
         structure%begins(j + 1) = i + size(here)
         structure%at(i:i + size(here) - 1) = here
         structure%part(i:i + size(here) - 1) = structure%directions(here, j)
      end do
      allocate (speeds(gaps))
      do j = 1, gaps
         do i = 1, gaps
            associate (first => structure%begins(i), last => structure%begins(i + 1) - 1)
               speeds(i) = abs(dot_product(structure%part(first:last), &
                  structure%mobility(structure%at(first:last), j)))*sqrt(structure%effective(i) &
                  *structure%effective(j))
            end associate
         end do
         speeds(j) = 0
         ! no impulse acts on a stop, nor by friction
         if (structure%elastic(j) .or. structure%rubs(j)) speeds = 0
         where (structure%elastic .or. structure%rubs) speeds = 0
         structure%coupled = [structure%coupled, pack([(i, i=1, gaps)], speeds > no_coupling)]
         structure%coupled_begins(j + 1) = size(structure%coupled) + 1
      end do
   end subroutine set_lists

   !> Whether a length or a mass is so small or large that bounds on derivatives may not be
   !! represented.
   elemental logical function is_extreme(size)
      !> The length or mass, >= 0.
      real(wp), intent(in) :: size

      is_extreme = size > 0 .and. .not. (size >= smallest .and. size <= largest)
   end function is_extreme

   !> The motion of a structure while a set of gaps and stops is closed.
   pure subroutine new_regime(structure, load, closed, regime, status, searched, renewed)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Its load.
      type(load_type), intent(in) :: load
      !> The gaps at rest and the stops that are closed, as in `regime_type`.
      integer, intent(in) :: closed(:)
      !> The motion.
      type(regime_type), intent(out) :: regime
      !> As of `complete_regime`.
      integer, intent(out) :: status
      !> As in `complete_regime`.
      logical, intent(in), optional :: searched
      !> Whether `renew_regime` will be called; not by default.
      logical, intent(in), optional :: renewed
      type(structure_type) :: pressed
      type(load_type) :: pressed_load
      complex(wp) :: force
      logical :: presses
      integer :: h, i

      if (present(renewed)) then
         if (renewed) allocate (regime%shape)
      end if
      regime%closed = closed
      regime%positions = structure%positions
      if (.not. (structure%has_stops .or. structure%has_friction .or. structure%moves)) then
         regime%resting = closed
         regime%held = closed
         call complete_regime(structure, load, regime, status, searched)
         return
      end if
      regime%resting = pack(closed, [(closed(i) > 0 .and. .not. (structure%elastic(abs( &
         closed(i))) .or. structure%rubs(abs(closed(i)))), i=1, size(closed))])
      regime%held = [regime%resting, pack(closed, [(closed(i) > 0 .and. structure%rubs(abs( &
         closed(i))) .and. .not. is_absorbed(structure, abs(closed(i)), regime%resting), i=1, &
         size(closed))])]
      presses = .false.
      do i = 1, size(closed)
         if (closed(i) > 0) presses = presses .or. structure%elastic(closed(i))
      end do
      if (presses) pressed = structure
      pressed_load = load
      if (structure%moves) then
         h = max(size(load%sine, 2), size(structure%motion, 1))
         pressed_load%cosine = reshape([load%cosine], [size(load%constant), h], pad=[0.0_wp])
         pressed_load%sine = reshape([load%sine], [size(load%constant), h], pad=[0.0_wp])
      end if
      do i = 1, size(closed)
         if (closed(i) < 0) cycle
         if (.not. structure%elastic(closed(i))) cycle
         associate (g => structure%directions(:, closed(i)), law => structure%laws(closed(i)))
            pressed%stiffness = pressed%stiffness + law%numbers(1)*outer(g)
            pressed%damping = pressed%damping + law%numbers(2)*outer(g)
            if (.not. structure%moves) cycle
            do h = 1, size(structure%motion, 1)
               force = cmplx(law%numbers(1), h*load%frequency*law%numbers(2), wp) &
                  *structure%motion(h, closed(i))
               pressed_load%cosine(:, h) = pressed_load%cosine(:, h) + g*force%re
               pressed_load%sine(:, h) = pressed_load%sine(:, h) - g*force%im
            end do
         end associate
      end do
      call add_contacts(structure, closed, regime%resting, pressed_load%constant)
      if (presses) then
         call complete_regime(pressed, pressed_load, regime, status, searched)
      else
         call complete_regime(structure, pressed_load, regime, status, searched)
      end if
   end subroutine new_regime

   !> Adds the constant forces of stops that press and of friction that slips.
   pure subroutine add_contacts(structure, closed, resting, constant)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> As in `regime_type`.
      integer, intent(in) :: closed(:), resting(:)
      !> (n) In and out: constant forces.
      real(wp), intent(inout) :: constant(:)
      integer :: i

      do i = 1, size(closed)
         if (closed(i) < 0) cycle
         if (.not. structure%elastic(closed(i))) cycle
         associate (g => structure%directions(:, closed(i)), law => structure%laws(closed(i)), &
            opening => structure%openings(closed(i)))
            constant = constant + g*(law%numbers(1)*opening - law%numbers(3))
         end associate
      end do
      do i = 1, size(structure%openings)
         if (.not. structure%rubs(i) .or. any(closed == i)) cycle
         if (is_absorbed(structure, i, resting)) cycle
         constant = constant + structure%directions(:, i)*merge(structure%laws(i)%numbers(1), &
            -structure%laws(i)%numbers(1), any(closed == -i))
      end do
   end subroutine add_contacts

   !> A regime at another load, other openings or other levels of friction, in place: the digits are
   !! those of `new_regime`, but the modes are kept.
   pure subroutine renew_regime(structure, load, regime, good)
      !> The structure, whose gaps are in the same channels as before.
      type(structure_type), intent(in) :: structure
      !> Its load.
      type(load_type), intent(in) :: load
      !> In and out: a regime of `new_regime` for which this was announced; incomplete if `good` is
      !! false.
      type(regime_type), intent(inout) :: regime
      !> False where the matrices or the directions are others, or another formula applies, so that
      !! `new_regime` has to be called.
      logical, intent(out) :: good
      real(wp), allocatable, dimension(:, :) :: basis, inverse, pushes
      real(wp) :: constant(size(load%constant)), forces(size(load%constant), 1 + 2*size( &
         load%sine, 2))
      integer :: h, status
      logical :: same

      good = allocated(regime%shape)
      if (good) good = .not. (structure%moves .or. load%step > 0)
      if (good) good = size(load%sine, 2) == size(regime%wave_force, 2)
      if (good) good = has_shape(structure, regime%closed, regime%shape)
      if (.not. good) return
      regime%frequency = load%frequency
      if (size(regime%held) > 0) then
         if (any(abs(structure%openings(regime%held)) > 0) .or. any(abs(regime%offset) > 0)) then
            call constraint(structure, regime%held, basis, inverse, regime%offset, pushes, status)
            good = status == stat%ok
            if (.not. good) return
         end if
      end if
      constant = load%constant
      call add_contacts(structure, regime%closed, regime%resting, constant)
      associate (shape => regime%shape, harmonics => size(load%sine, 2))
         forces(:, 1) = constant - matmul(shape%stiffness, regime%offset)
         forces(:, 2:harmonics + 1) = load%cosine
         forces(:, harmonics + 2:) = load%sine
         if (size(regime%held) > 0) then
            call renew_inputs(shape, matmul(transpose(shape%basis), forces), regime, same, good)
         else
            call renew_inputs(shape, forces, regime, same, good)
         end if
         if (.not. good) return
         do h = 1, harmonics
            call steady_motion(regime, size(shape%xd, 1), h, status)
            good = status == stat%ok
            if (.not. good) return
         end do
         call set_row_constants(structure, constant, load%cosine, load%sine, shape%of_q, &
            shape%of_rate, shape%of_force, regime)
      end associate
      if (allocated(regime%reach)) deallocate (regime%reach, regime%bend)
      call renew_rows(regime%modes, regime%position, regime%velocity, regime%row_offset, &
         regime%ripple, regime%frequency, .false., regime%rows)
      if (allocated(regime%coordinates%offset)) call renew_rows(regime%modes, regime%qx, &
         regime%qv, regime%offset, regime%steady, regime%frequency, .true., regime%coordinates)
      call set_unit(regime, load%step)
      good = regime%unit >= shortest_unit .and. .not. has_extremes(structure, regime)
      if (good .and. allocated(regime%turns)) call set_tables(regime, same)
   end subroutine renew_regime

   !> Whether a regime of a structure has a known shape.
   pure logical function has_shape(structure, closed, shape) result(has)
      !> The structure, and what is closed.
      type(structure_type), intent(in) :: structure
      integer, intent(in) :: closed(:)
      !> The shape.
      type(shape_type), intent(in) :: shape
      real(wp), dimension(size(structure%mass, 1), size(structure%mass, 1)) :: damping, stiffness
      integer :: i, j

      has = .not. (any(abs(structure%mass - shape%mass) > 0) .or. any(abs(structure%directions &
         - shape%directions) > 0))
      if (.not. has) return
      damping = structure%damping
      stiffness = structure%stiffness
      do i = 1, size(closed)
         if (closed(i) < 0) cycle
         if (.not. structure%elastic(closed(i))) cycle
         associate (g => structure%directions(:, closed(i)), law => structure%laws(closed(i)))
            stiffness = stiffness + law%numbers(1)*outer(g)
            damping = damping + law%numbers(2)*outer(g)
         end associate
      end do
      has = .not. (any(abs(damping - shape%damping) > 0) .or. any(abs(stiffness &
         - shape%stiffness) > 0))
      do j = 1, size(structure%openings)
         if (structure%rubs(j)) has = has .and. (abs(structure%laws(j)%numbers(3)) > 0 .eqv. &
            shape%belts(j))
         if (structure%push(j) > 0) has = has .and. .not. any(abs(structure%laws(j)%numbers(:2) &
            - shape%pushing(:, j)) > 0)
      end do
   end function has_shape

   !> The constant terms and the harmonics of the pairs due to other forces.
   pure subroutine renew_inputs(shape, forces, regime, same, good)
      !> The shape.
      type(shape_type), intent(in) :: shape
      !> (k, 1 + 2 harmonics) Constant forces, cosines and sines on the coordinates of its basis.
      real(wp), intent(in) :: forces(:, :)
      !> In and out: the regime.
      type(regime_type), intent(inout) :: regime
      !> Whether the constant terms are the same as before; and false where another one is zero than
      !! before, for which the pairs have special formulas.
      logical, intent(out) :: same, good
      real(wp) :: rates(size(forces, 1), size(forces, 2)), drifts(size(shape%xd, 1), &
         size(forces, 2)), impulses(size(shape%xd, 1), size(forces, 2))
      integer :: harmonics, m, status

      m = size(drifts, 1)
      harmonics = size(forces, 2)/2
      rates = forces
      call solve_columns(shape%reduced, rates, status)
      drifts = matmul(shape%xd, rates)
      impulses = matmul(shape%vd, rates)
      associate (modes => regime%modes)
         good = status == stat%ok .and. all(abs(drifts(:, 1)) + abs(impulses(:, 1)) > 0 .eqv. &
            abs(modes%drift(:m)) + abs(modes%force(:m)) > 0)
         same = .not. any(abs(modes%drift(:m) - drifts(:, 1)) + abs(modes%force(:m) &
            - impulses(:, 1)) > 0)
         modes%drift(:m) = drifts(:, 1)
         modes%force(:m) = impulses(:, 1)
      end associate
      regime%wave_drift = cmplx(drifts(:, 2:harmonics + 1), -drifts(:, harmonics + 2:), wp)
      regime%wave_force = cmplx(impulses(:, 2:harmonics + 1), -impulses(:, harmonics + 2:), wp)
   end subroutine renew_inputs

   !> The factor of the direction of a gap that gives that of friction along it; 0 if it is not
   !! along it, or has a belt.
   pure real(wp) function factor_along(structure, friction, gap) result(factor)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Numbers of the friction and of the gap.
      integer, intent(in) :: friction, gap
      real(wp), parameter :: rounding = 1.0e-12_wp

      factor = 0
      if (.not. structure%rubs(friction)) return
      if (structure%rubs(gap) .or. structure%elastic(gap)) return
      if (abs(structure%laws(friction)%numbers(3)) > 0) return
      if (structure%moves) then
         ! what rests on a wall that moves slides along with it
         if (any(abs(structure%motion(:, gap)) > 0)) return
      end if
      associate (d => structure%directions(:, friction), g => structure%directions(:, gap))
         factor = dot_product(d, g)/dot_product(g, g)
         if (any(abs(d - factor*g) > rounding*maxval(abs(d)))) factor = 0
      end associate
   end function factor_along

   !> Whether an impulse along one element changes the speed along another one or, by dashpots, its
   !! acceleration.
   pure logical function acts_on(structure, one, other, by_dashpots)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The numbers of the elements.
      integer, intent(in) :: one, other
      !> Whether an acceleration counts; if it is left out, it does not.
      logical, intent(in), optional :: by_dashpots
      !> Share of the terms of a speed that counts as rounding.
      real(wp), parameter :: rounding = 1.0e-9_wp

      associate (direction => structure%directions(:, other), kick => structure%mobility(:, one), &
         back => structure%mobility(:, other))
         acts_on = abs(dot_product(direction, kick)) > rounding*dot_product(abs(direction), &
            abs(kick))
         if (acts_on .or. .not. present(by_dashpots)) return
         if (by_dashpots) acts_on = abs(dot_product(back, matmul(structure%damping, kick))) > &
            rounding*dot_product(abs(back), abs(matmul(structure%damping, kick)))
      end associate
   end function acts_on

   !> The elements of which forces change the force that holds one of them, or by dashpots its rate:
   !! directly, or through others that are held.
   pure function linked_elements(structure, first, elements, by_dashpots) result(linked)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The one, and those that are held, press or change at an instant.
      integer, intent(in) :: first, elements(:)
      !> As of `acts_on`.
      logical, intent(in), optional :: by_dashpots
      integer, allocatable :: linked(:)
      integer :: i, k

      allocate (linked, source=[first])
      i = 1
      do while (i <= size(linked))
         do k = 1, size(elements)
            if (any(linked == elements(k))) cycle
            if (acts_on(structure, linked(i), elements(k), by_dashpots)) linked = [linked, &
               elements(k)]
         end do
         i = i + 1
      end do
   end function linked_elements

   !> Whether friction is along a gap at rest, so that it holds together with the gap.
   pure logical function is_absorbed(structure, friction, resting)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Number of the friction, and the gaps at rest.
      integer, intent(in) :: friction, resting(:)
      integer :: k

      is_absorbed = any([(abs(factor_along(structure, friction, resting(k))) > 0, k=1, &
         size(resting))])
   end function is_absorbed

   !> G G^T.
   pure function outer(g) result(product)
      !> (n) G.
      real(wp), intent(in) :: g(:)
      real(wp) :: product(size(g), size(g))

      product = spread(g, 2, size(g))*spread(g, 1, size(g))
   end function outer

   !> The motion of a structure with the springs and dashpots of stops that press while gaps are at
   !! rest.
   pure subroutine complete_regime(structure, load, regime, status, searched)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Its load.
      type(load_type), intent(in) :: load
      !> In: which gaps and stops are closed. Out: the motion.
      type(regime_type), intent(inout) :: regime
      !> `stat%ok`; a status of `decouple`; `stat%resonance` where an undamped mode resonates;
      !! `stat%dependent_rests` or `stat%dependent_friction`; `stat%extreme_units`.
      integer, intent(out) :: status
      !> Whether contacts will be searched in it and its coordinates evaluated, which takes tables;
      !! true if it is left out.
      logical, intent(in), optional :: searched
      type(decoupled_type) :: parts
      real(wp), allocatable :: basis(:, :), inverse(:, :), forces(:, :), drifts(:, :)
      real(wp), allocatable, dimension(:, :) :: mass, damping, stiffness, pushes
      real(wp), allocatable :: terms(:, :, :), terms_of_mass(:, :)
      complex(wp) :: carried(size(structure%mass, 1), size(load%sine, 2))
      complex(wp) :: force(size(structure%mass, 1))
      logical :: with_tables
      integer :: h

      regime%frequency = load%frequency
      call constraint(structure, regime%held, basis, inverse, regime%offset, pushes, status)
      if (status == stat%singular) status = merge(stat%dependent_friction, stat%dependent_rests, &
         any(structure%rubs(regime%held)))
      if (status /= stat%ok) return
      if (size(regime%held) == 0) then
         mass = structure%mass
         call decouple(mass, structure%damping, structure%stiffness, parts, status, &
            may_grow=structure%may_grow)
      else
         allocate (terms(size(basis, 2), size(basis, 2), 2), &
            terms_of_mass(size(basis, 2), size(basis, 2)))
         call project(structure%mass, basis, mass, terms_of_mass)
         call project(structure%damping, basis, damping, terms(:, :, 1))
         call project(structure%stiffness, basis, stiffness, terms(:, :, 2))
         call decouple(mass, damping, stiffness, parts, status, terms, &
            structure%may_grow)
      end if
      if (status /= stat%ok) return
      regime%modes%stiffness = parts%stiffness
      regime%modes%damping = parts%damping
      if (size(regime%held) == 0) then
         regime%qx = parts%qx
         regime%qv = parts%qv
         regime%dx = parts%dx
         regime%dv = parts%dv
         regime%xq = parts%xq
         regime%xd = parts%xd
         regime%vq = parts%vq
         regime%vd = parts%vd
      else
         regime%qx = matmul(basis, parts%qx)
         regime%qv = matmul(basis, parts%qv)
         regime%dx = matmul(basis, parts%dx)
         regime%dv = matmul(basis, parts%dv)
         regime%xq = matmul(parts%xq, inverse)
         regime%xd = matmul(parts%xd, inverse)
         regime%vq = matmul(parts%vq, inverse)
         regime%vd = matmul(parts%vd, inverse)
      end if
      ! the constant force and the harmonics as accelerations, and as inputs of the pairs
      associate (harmonics => size(load%sine, 2))
         allocate (forces(size(load%constant), 1 + 2*harmonics))
         forces(:, 1) = load%constant - matmul(structure%stiffness, regime%offset)
         forces(:, 2:harmonics + 1) = load%cosine
         forces(:, harmonics + 2:) = load%sine
         call carry_along(structure, regime%held, pushes, carried, status)
         if (status /= stat%ok) return
         if (structure%moves) then
            do h = 1, harmonics
               force = matmul(structure%stiffness, carried(:, h)) + cmplx(0.0_wp, &
                  h*load%frequency, wp)*matmul(structure%damping, carried(:, h))
               forces(:, 1 + h) = forces(:, 1 + h) - force%re
               forces(:, 1 + harmonics + h) = forces(:, 1 + harmonics + h) + force%im
            end do
         end if
         if (size(regime%held) > 0) forces = matmul(transpose(basis), forces)
         call inputs_of(mass, parts%xd, parts%vd, forces, drifts, status)
         if (status /= stat%ok) return
         regime%modes%drift = drifts(:, 1)
         regime%modes%force = forces(:, 1)
         regime%wave_drift = cmplx(drifts(:, 2:harmonics + 1), -drifts(:, harmonics + 2:), wp)
         regime%wave_force = cmplx(forces(:, 2:harmonics + 1), -forces(:, harmonics + 2:), wp)
         allocate (regime%steady(size(basis, 1), harmonics), &
            regime%steady_rate(size(basis, 1), harmonics))
         do h = 1, harmonics
            call steady_motion(regime, size(parts%stiffness), h, status)
            if (status == stat%resonance) call check_resonance(regime, parts, mass, &
               matmul(transpose(abs(basis)), abs(load%cosine(:, h)) + abs(load%sine(:, h))), h, &
               status)
            if (status /= stat%ok) return
            if (.not. structure%moves) cycle
            regime%steady(:, h) = regime%steady(:, h) + carried(:, h)
            regime%steady_rate(:, h) = regime%steady(:, h)*cmplx(0.0_wp, h*regime%frequency, wp)
         end do
      end associate
      if (size(regime%held) > size(regime%resting)) then
         call add_places(structure, pushes, parts, basis, mass, stiffness, regime, status)
         if (status /= stat%ok) return
      end if
      call prepare(regime%modes, load%step > 0)
      if (load%step > 0) then
         forces = transpose(basis)
         ! this succeeds: inputs_of has solved with the same matrix
         call solve_columns(mass, forces, status)
         regime%to_drift = padded(matmul(parts%xd, forces), size(regime%modes%stiffness))
         regime%drifts = any(abs(regime%to_drift) > 0)
         regime%to_force = padded(matmul(parts%vd, forces), size(regime%modes%stiffness))
         call new_interval(regime%modes, load%step, regime%interval)
         regime%base_drift = regime%modes%drift
         regime%base_force = regime%modes%force
      end if
      if (allocated(regime%shape)) then
         associate (shape => regime%shape)
            shape%mass = structure%mass
            shape%damping = structure%damping
            shape%stiffness = structure%stiffness
            shape%directions = structure%directions
            shape%basis = basis
            shape%reduced = mass
            shape%xd = parts%xd
            shape%vd = parts%vd
            allocate (shape%pushing(2, size(structure%openings)))
            do h = 1, size(structure%openings)
               shape%pushing(:, h) = structure%laws(h)%numbers(:2)
            end do
            shape%belts = [(abs(structure%laws(h)%numbers(3)) > 0, h=1, size(structure%laws))]
         end associate
      end if
      call set_rows(structure, load, pushes, regime, status)
      if (status /= stat%ok) return
      regime%kick_x = sparse_product(regime%xd, structure%mobility)
      regime%kick_v = sparse_product(regime%vd, structure%mobility)
      regime%kicks_x = any(abs(regime%kick_x) > 0)
      ! of motions with stops and friction the extremes are evaluated in their regimes
      with_tables = .true.
      if (present(searched)) with_tables = searched
      call set_rates(regime, with_tables .or. structure%has_stops .or. structure%has_friction, &
         load%step)
      if (.not. regime%unit >= shortest_unit) status = stat%extreme_units
      if (has_extremes(structure, regime)) status = stat%extreme_units
      if (status /= stat%ok) return
      if (with_tables) call set_tables(regime, .false.)
   end subroutine complete_regime

   !> Whether lengths or masses are so small or large that powers of them are not represented.
   pure logical function has_extremes(structure, regime)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The regime.
      type(regime_type), intent(in) :: regime
      real(wp) :: widest
      integer :: j

      widest = 0
      do j = 1, size(structure%openings)
         if (abs(structure%openings(j)) < never) widest = max(widest, abs(structure%openings(j)))
      end do
      has_extremes = is_extreme(widest) .or. any(is_extreme(structure%effective) .or. &
         .not. structure%effective > 0)
      if (size(regime%steady) > 0) has_extremes = has_extremes .or. &
         is_extreme(maxval(abs(regime%steady)))
   end function has_extremes

   !> The motion M^-1 G (G^T M^-1 G)^-1 w with which walls carry what rests on them; what is left is
   !! free of it, as it does not move along G.
   pure subroutine carry_along(structure, held, pushes, carried, status)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The gaps.
      integer, intent(in) :: held(:)
      !> As of `constraint`.
      real(wp), allocatable, intent(in) :: pushes(:, :)
      !> (n, harmonics)
      complex(wp), intent(out) :: carried(:, :)
      !> `stat%ok` or `stat%singular`.
      integer, intent(out) :: status
      real(wp), allocatable :: forces(:, :)
      integer :: h, k

      carried = 0
      status = stat%ok
      if (.not. structure%moves .or. size(held) == 0) return
      call forces_of_held(structure, held, pushes, forces, status)
      if (status /= stat%ok) return
      do h = 1, size(structure%motion, 1)
         do k = 1, size(held)
            carried(:, h) = carried(:, h) + forces(k, :)*structure%motion(h, held(k))
         end do
      end do
   end subroutine carry_along

   !> The forces of held gaps and of friction that sticks, due to forces on the coordinates.
   pure subroutine forces_of_held(structure, held, pushes, forces, status)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The gaps.
      integer, intent(in) :: held(:)
      !> As of `constraint`.
      real(wp), allocatable, intent(in) :: pushes(:, :)
      !> (held, n) (G^T M^-1 G)^-1 G^T M^-1.
      real(wp), allocatable, intent(out) :: forces(:, :)
      !> `stat%ok` or `stat%singular`.
      integer, intent(out) :: status
      real(wp), allocatable :: gram(:, :)

      status = stat%ok
      if (allocated(pushes)) then
         forces = pushes
         return
      end if
      gram = matmul(transpose(structure%directions(:, held)), structure%mobility(:, held))
      forces = transpose(structure%mobility(:, held))
      call solve_columns(gram, forces, status)
   end subroutine forces_of_held

   !> Adds the places D.q of friction that sticks, each a pair of frequency 0.
   !!
   !! q = basis.xi + W sigma, where sigma are the places and D^T W = 1. With xi = eta + a sigma + b
   !! sigma', K_B a = -B^T K W and K_B b = -C_B a - B^T C W, eta does not depend on sigma, since
   !! sigma'' = 0. B stands for the basis, and K_B for B^T K B.
   pure subroutine add_places(structure, pushes, parts, basis, mass, stiffness, regime, status)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> As of `constraint`.
      real(wp), allocatable, intent(in) :: pushes(:, :)
      !> The pairs of the reduced structure.
      type(decoupled_type), intent(in) :: parts
      !> (n, k) The basis; (k, k) M and K of the reduced structure.
      real(wp), intent(in) :: basis(:, :), mass(:, :), stiffness(:, :)
      !> In and out: the regime.
      type(regime_type), intent(inout) :: regime
      !> `stat%ok`, `stat%singular`, or `stat%friction_undecided` where a belt drags a mass that
      !! nothing holds.
      integer, intent(out) :: status
      !> Share of the terms that counts as rounding.
      real(wp), parameter :: rounding = 1.0e-9_wp
      real(wp), allocatable, dimension(:, :) :: forces, d, w, a, b, shape, by_speed, held, target
      real(wp) :: scale
      integer, allocatable :: sticks(:)
      integer :: k, m, s

      associate (n => size(basis, 1))
         s = size(regime%held) - size(regime%resting)
         m = size(regime%modes%stiffness)
         allocate (sticks, source=regime%held(size(regime%resting) + 1:))
         call forces_of_held(structure, regime%held, pushes, forces, status)
         if (status /= stat%ok) return
         d = transpose(structure%directions(:, sticks))
         w = transpose(forces(size(regime%resting) + 1:, :))
         shape = w
         allocate (by_speed(n, s), source=0.0_wp)
         if (size(basis, 2) > 0) then
            ! what nothing holds has no part: its shape is added to K_B
            held = stiffness
            do k = 1, size(parts%stiffness)
               if (parts%stiffness(k) > 0) cycle
               b = matmul(mass, parts%qx(:, k:k))
               scale = maxval(abs(b))**2
               if (.not. scale > 0) cycle
               scale = merge(maxval(abs(stiffness)), 1.0_wp, maxval(abs(stiffness)) > 0)/scale
               held = held + scale*matmul(b, transpose(b))
            end do
            target = -matmul(transpose(basis), matmul(structure%stiffness, w))
            a = target
            call solve_columns(held, a, status)
            if (status /= stat%ok) return
            shape = w + matmul(basis, a)
            if (any(abs(structure%laws(sticks)%numbers(3)) > 0)) then
               target = -matmul(transpose(basis), matmul(structure%damping, shape))
               b = target
               call solve_columns(held, b, status)
               if (status /= stat%ok) return
               if (any(abs(matmul(stiffness, b) - target) > rounding*(maxval(abs(target)) &
                  + maxval(abs(stiffness))*maxval(abs(b))))) status = stat%friction_undecided
               if (status /= stat%ok) return
               by_speed = matmul(basis, b)
            end if
         end if
         ! eta from what is left of q and q'
         regime%xd = regime%xd - matmul(matmul(regime%xd, shape) + matmul(regime%xq, by_speed), d)
         regime%vd = regime%vd - matmul(matmul(regime%vd, shape) + matmul(regime%vq, by_speed), d)
         regime%xq = regime%xq - matmul(matmul(regime%xq, shape), d)
         regime%vq = regime%vq - matmul(matmul(regime%vq, shape), d)
         regime%qx = joined(regime%qx, shape)
         regime%qv = joined(regime%qv, by_speed)
         regime%dx = joined(regime%dx, 0*shape)
         regime%dv = joined(regime%dv, shape)
         regime%xq = padded(regime%xq, m + s)
         regime%xd = padded(regime%xd, m + s)
         regime%vq = padded(regime%vq, m + s)
         regime%vd = padded(regime%vd, m + s)
         regime%xq(m + 1:, :) = d
         regime%vd(m + 1:, :) = d
         regime%modes%stiffness = [regime%modes%stiffness, spread(0.0_wp, 1, s)]
         regime%modes%damping = [regime%modes%damping, spread(0.0_wp, 1, s)]
         regime%modes%drift = [regime%modes%drift, spread(0.0_wp, 1, s)]
         regime%modes%force = [regime%modes%force, spread(0.0_wp, 1, s)]
      end associate
   end subroutine add_places

   !> Two matrices side by side.
   pure function joined(left, right) result(both)
      !> (n, m) and (n, k)
      real(wp), intent(in) :: left(:, :), right(:, :)
      real(wp) :: both(size(left, 1), size(left, 2) + size(right, 2))

      both(:, :size(left, 2)) = left
      both(:, size(left, 2) + 1:) = right
   end function joined

   !> A matrix with more rows, of zeros.
   pure function padded(matrix, rows) result(longer)
      !> (k, n)
      real(wp), intent(in) :: matrix(:, :)
      !> Number of rows, at least k.
      integer, intent(in) :: rows
      real(wp) :: longer(rows, size(matrix, 2))

      longer = 0
      longer(:size(matrix, 1), :) = matrix
   end function padded

   !> A symmetric matrix between vectors, V^T A V; an entry as small as its rounding error is 0.
   pure subroutine project(matrix, vectors, projected, terms)
      !> (n, n) A; (n, m) the columns of V.
      real(wp), intent(in) :: matrix(:, :), vectors(:, :)
      !> (m, m) V^T A V.
      real(wp), allocatable, intent(out) :: projected(:, :)
      !> (m, m) The sums of the moduli of its terms.
      real(wp), intent(out) :: terms(:, :)

      projected = matmul(transpose(vectors), matmul(matrix, vectors))
      projected = 0.5_wp*(projected + transpose(projected))
      terms = matmul(transpose(abs(vectors)), matmul(abs(matrix), abs(vectors)))
      terms = 0.5_wp*(terms + transpose(terms))
      where (abs(projected) <= 8*epsilon(1.0_wp)*terms) projected = 0
   end subroutine project

   !> A gap that is too narrow for a simulation: the rounding error of the displacements that close
   !! it, half of epsilon, is more than a millionth of the way between its walls or, where it has
   !! only one, of its opening and of its distance from the wall at the start.
   pure subroutine find_narrow(structure, regime, q, gap, least)
      !> The structure, checked.
      type(structure_type), intent(in) :: structure
      !> Its regime without resting gaps.
      type(regime_type), intent(in) :: regime
      !> (n) Coordinates at the start.
      real(wp), intent(in) :: q(:)
      !> The first such gap; 0 if there is none.
      integer, intent(out) :: gap
      !> The least way, or the least opening that is not 0.
      real(wp), intent(out) :: least
      !> The rounding error of a displacement of 1, times a million.
      real(wp), parameter :: share = 0.5e6_wp*epsilon(1.0_wp)
      real(wp), dimension(size(regime%modes%stiffness)) :: x, v
      real(wp) :: sizes(size(q)), way
      integer :: other

      ! displacements of the start, and under the harmonics and the constant forces
      x = 0
      where (regime%modes%stiffness > 0) x = (regime%modes%force + 2*regime%modes%damping &
         *regime%modes%drift)/regime%modes%stiffness
      v = merge(-regime%modes%drift, 0.0_wp, regime%modes%stiffness > 0)
      sizes = max(abs(q), sum(abs(regime%steady), 2), abs(matmul(regime%qx, x) &
         + matmul(regime%qv, v)))
      do gap = 1, size(structure%openings)
         if (structure%elastic(gap) .or. structure%rubs(gap)) cycle
         least = share*dot_product(abs(structure%directions(:, gap)), sizes)
         other = findloc(structure%channel == structure%channel(gap) .and. &
            structure%wall /= structure%wall(gap), .true., 1)
         if (other > 0) then
            way = structure%openings(gap) + structure%openings(other)
         else
            way = abs(structure%openings(gap))
            if (way > 0) way = max(way, abs(structure%openings(gap) - dot_product( &
               structure%directions(:, gap), q)))
         end if
         if (way > 0 .and. way < least) return
      end do
      gap = 0
      least = 0
   end subroutine find_narrow

   !> The inputs p and f of the pairs due to forces.
   pure subroutine inputs_of(mass, xd, vd, forces, drifts, status)
      !> (n, n) M; (m, n) x and v of the pairs from velocities.
      real(wp), intent(in) :: mass(:, :), xd(:, :), vd(:, :)
      !> In: (n, columns) forces. Out: (m, columns) f.
      real(wp), allocatable, intent(inout) :: forces(:, :)
      !> (m, columns) p.
      real(wp), allocatable, intent(out) :: drifts(:, :)
      !> `stat%ok` or `stat%singular`.
      integer, intent(out) :: status

      call solve_columns(mass, forces, status)
      if (status /= stat%ok) return
      drifts = matmul(xd, forces)
      forces = matmul(vd, forces)
   end subroutine inputs_of

   !> A matrix times one that consists mostly of zeros.
   pure function sparse_product(left, right) result(product)
      !> The matrices.
      real(wp), intent(in) :: left(:, :), right(:, :)
      real(wp) :: product(size(left, 1), size(right, 2))
      integer :: j, k

      product = 0
      do j = 1, size(right, 2)
         do k = 1, size(right, 1)
            if (abs(right(k, j)) > 0) product(:, j) = product(:, j) + right(k, j)*left(:, k)
         end do
      end do
   end function sparse_product

   !> The motions that closed gaps allow: q = offset + basis.xi.
   !!
   !! Coordinates are scaled by the square roots of their masses, so that the digits do not depend
   !! on
   !! their units.
   pure subroutine constraint(structure, resting, basis, inverse, offset, pushes, status)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The closed gaps.
      integer, intent(in) :: resting(:)
      !> (n, n - gaps) Columns, orthonormal in scaled coordinates; (n - gaps, n) xi from vectors in
      !! their span, not set without closed gaps.
      real(wp), allocatable, intent(out) :: basis(:, :), inverse(:, :)
      !> (n) The shortest q, in scaled coordinates, at which these gaps are closed.
      real(wp), allocatable, intent(out) :: offset(:)
      !> (gaps, n) The forces of the gaps due to forces on the coordinates, by the factors of the
      !! directions; not set where `set_rows` keeps the digits without them.
      real(wp), allocatable, intent(out) :: pushes(:, :)
      !> `stat%ok`, or `stat%singular` where the gaps cannot be closed independently.
      integer, intent(out) :: status
      !> Least independent part of a direction of length 1 for which products of directions may be
      !! formed: they lose twice the digits. A light body between heavy ones has less.
      real(wp), parameter :: well_apart = 0.1_wp
      real(wp), allocatable :: directions(:, :), q(:, :), gram(:, :), needed(:, :), factor(:, :)
      real(wp) :: lengths(size(resting)), unit(size(structure%mass, 1))
      integer :: part(size(structure%mass, 1)), columns, i, j, n, s

      n = size(structure%mass, 1)
      s = size(resting)
      status = stat%ok
      allocate (offset(n), source=0.0_wp)
      if (s == 0) then
         allocate (basis(n, n), source=0.0_wp)
         do i = 1, n
            basis(i, i) = 1
         end do
         return
      end if
      unit = [(1/sqrt(structure%mass(i, i)), i=1, n)]
      if (s > n) then                               ! more directions than coordinates
         status = stat%singular
         return
      end if
      allocate (directions(n, s), q(n, s), factor(s, s), basis(n, n - s), source=0.0_wp)
      do i = 1, s
         directions(:, i) = unit*structure%directions(:, resting(i))
         lengths(i) = norm2(directions(:, i))
         directions(:, i) = directions(:, i)/lengths(i)
      end do
      ! part by part, so that what a closed gap does not hold stays apart from what it holds
      part = [(i, i=1, n)]
      do j = 1, s
         columns = minval(part, abs(directions(:, j)) > 0)
         do i = 1, n
            if (abs(directions(i, j)) > 0) where (part == part(i)) part = columns
         end do
      end do
      columns = 0
      do i = 1, n
         if (part(i) /= i) cycle
         call split_part(pack([(j, j=1, n)], part == i), directions, q, factor, basis, columns, &
            status)
         if (status /= stat%ok) return
      end do
      allocate (inverse, source=transpose(basis))
      do i = 1, n
         basis(i, :) = unit(i)*basis(i, :)
         inverse(:, i) = inverse(:, i)/unit(i)
      end do
      allocate (needed(s, 1))
      needed(:, 1) = structure%openings(resting)/lengths
      if (all([(abs(factor(i, i)) >= well_apart, i=1, s)])) then
         gram = matmul(transpose(directions), directions)
         call solve_columns(gram, needed, status)
         if (status == stat%ok) offset = unit*matmul(directions, needed(:, 1))
         return
      end if
      call solve_columns(transpose(factor), needed, status)
      if (status /= stat%ok) return
      offset = unit*matmul(q, needed(:, 1))
      ! with W = L^-1 G = Q F, where L is diagonal and M = L N L, the forces of the gaps are
      ! F^-1 (Q^T N^-1 Q)^-1 Q^T N^-1 L^-1 f
      needed = q
      call solve_columns(structure%mass*spread(unit, 1, n)*spread(unit, 2, n), needed, status)
      if (status /= stat%ok) return
      gram = matmul(transpose(q), needed)
      pushes = transpose(needed*spread(unit, 2, s))
      call solve_columns(gram, pushes, status)
      if (status == stat%ok) call solve_columns(factor, pushes, status)
      pushes = pushes/spread(lengths, 2, n)
   end subroutine constraint

   !> The directions of closed gaps between some coordinates, and the vectors normal to them.
   pure subroutine split_part(at, directions, q, factor, basis, columns, status)
      !> The coordinates, which no direction links with others.
      integer, intent(in) :: at(:)
      !> (n, gaps) The directions of all closed gaps.
      real(wp), intent(in) :: directions(:, :)
      !> In and out: filled in where it concerns these coordinates. (n, gaps) and (gaps, gaps)
      !! directions = q factor with orthonormal columns of q; (n, n - gaps) normal vectors.
      real(wp), intent(inout) :: q(:, :), factor(:, :), basis(:, :)
      !> In and out: the number of columns of the basis so far.
      integer, intent(inout) :: columns
      !> `stat%ok`, or `stat%singular` where directions depend on each other.
      integer, intent(out) :: status
      real(wp) :: local(size(at), size(at)), tau(size(at)), work(64*size(at))
      integer, allocatable :: gaps(:)
      integer :: i, m, s, info

      m = size(at)
      gaps = pack([(i, i=1, size(directions, 2))], sum(abs(directions(at, :)), 1) > 0)
      s = size(gaps)
      status = stat%singular
      ! there are more normal vectors where directions elsewhere depend on each other
      if (s > m .or. columns + m - s > size(basis, 2)) return
      local = 0
      local(:, :s) = directions(at, gaps)
      if (s == 0) local = 1                         ! a coordinate that no gap holds
      if (s > 0) call dgeqrf(m, s, local, m, tau, work, size(work), info)
      do i = 1, s
         ! the part of this direction that is independent of those before it
         if (abs(local(i, i)) <= 1.0e-10_wp) return
         factor(gaps(:i), gaps(i)) = local(:i, i)
      end do
      status = stat%ok
      if (s > 0) call dorgqr(m, m, s, local, m, tau, work, size(work), info)
      q(at, gaps) = local(:, :s)
      where (abs(local) <= 4*epsilon(1.0_wp)) local = 0
      basis(at, columns + 1:columns + m - s) = local(:, s + 1:)
      columns = columns + m - s
   end subroutine split_part

   !> The steady motion under one harmonic of the load.
   pure subroutine steady_motion(regime, m, h, status)
      !> In and out: filled in.
      type(regime_type), intent(inout) :: regime
      !> Number of pairs without the places of friction that sticks, and the harmonic, from 1.
      integer, intent(in) :: m, h
      !> `stat%ok`, `stat%resonance` where an undamped mode resonates, or `stat%extreme_units`.
      integer, intent(out) :: status
      complex(wp), dimension(m) :: x, v
      logical :: resonant(m)

      call steady_response(regime%modes%stiffness(:m), regime%modes%damping(:m), &
         h*regime%frequency, regime%wave_drift(:, h), regime%wave_force(:, h), x, v, resonant)
      status = merge(stat%resonance, stat%ok, any(resonant))
      if (is_extreme(h*regime%frequency)) status = stat%extreme_units
      associate (qx => regime%qx(:, :m), qv => regime%qv(:, :m))
         regime%steady(:, h) = cmplx(matmul(qx, x%re) + matmul(qv, v%re), matmul(qx, x%im) &
            + matmul(qv, v%im), wp)
      end associate
      regime%steady_rate(:, h) = regime%steady(:, h)*cmplx(0.0_wp, h*regime%frequency, wp)
   end subroutine steady_motion

   !> Whether the forces on pairs that resonate are more than rounding errors, as where a load does
   !! not act on a mode.
   pure subroutine check_resonance(regime, parts, mass, sizes, h, status)
      !> The regime, with its steady motion, in which the pairs that resonate have no part.
      type(regime_type), intent(in) :: regime
      !> Its pairs.
      type(decoupled_type), intent(in) :: parts
      !> (m, m) M, and (m) the sums of the moduli of the terms of the forces.
      real(wp), intent(in) :: mass(:, :), sizes(:)
      !> The harmonic, from 1.
      integer, intent(in) :: h
      !> `stat%ok` or `stat%resonance`.
      integer, intent(out) :: status
      !> Largest factor of rounding errors between pairs that counts: with more, a load on a mode
      !! cannot be distinguished from one on another.
      real(wp), parameter :: most_turn = 1.0e3_wp
      complex(wp), dimension(size(sizes)) :: x, v
      real(wp), dimension(size(sizes)) :: of_x, of_v
      real(wp) :: turn(size(sizes), size(sizes)), largest
      logical :: resonant(size(sizes))
      integer :: i, j

      largest = maxval(regime%modes%stiffness)
      of_x = largest_error(parts%xd)
      of_v = largest_error(parts%vd)
      call steady_response(regime%modes%stiffness, regime%modes%damping, h*regime%frequency, &
         regime%wave_drift(:, h), regime%wave_force(:, h), x, v, resonant)
      ! a pair also takes a share of each other one, as much as rounding errors turn it
      do i = 1, size(sizes)
         turn(:, i) = [(largest/max(tiny(1.0_wp), largest/most_turn, &
            abs(regime%modes%stiffness(i) - regime%modes%stiffness(j))), j=1, size(sizes))]
         turn(i, i) = 1
      end do
      status = merge(stat%resonance, stat%ok, any(resonant .and. (abs(regime%wave_drift(:, h)) &
         > matmul(of_x, turn) .or. abs(regime%wave_force(:, h)) > matmul(of_v, turn))))
   contains
      !> Bounds on the rounding errors of a linear function of the accelerations.
      pure function largest_error(of_rates) result(bounds)
         !> (m, m) The function.
         real(wp), intent(in) :: of_rates(:, :)
         real(wp) :: bounds(size(sizes))
         real(wp), allocatable :: of_forces(:, :)
         integer :: i, not_used

         ! this succeeds: inputs_of has solved with the same matrix
         allocate (of_forces, source=transpose(of_rates))
         call solve_columns(mass, of_forces, not_used)
         bounds = [(dot_product(abs(of_forces(:, i)), sizes), i=1, size(sizes))]
         bounds = 64*size(sizes)*epsilon(1.0_wp)*bounds
      end function largest_error
   end subroutine check_resonance

   !> The rows: channels, and forces of closed gaps.
   pure subroutine set_rows(structure, load, pushes, regime, status)
      !> The structure, with the stops that press.
      type(structure_type), intent(in) :: structure
      !> Its load.
      type(load_type), intent(in) :: load
      !> As of `constraint`.
      real(wp), allocatable, intent(in) :: pushes(:, :)
      !> In and out: filled in.
      type(regime_type), intent(inout) :: regime
      !> `stat%ok` or `stat%singular`.
      integer, intent(out) :: status
      real(wp), allocatable :: of_force(:, :), of_q(:, :), of_rate(:, :), forces(:, :)
      integer :: k, rows, m

      rows = structure%channels + size(regime%held)
      m = size(regime%modes%stiffness)
      status = stat%ok
      allocate (of_q(rows, size(structure%mass, 1)), of_rate(rows, size(structure%mass, 1)), &
         of_force(rows, size(structure%mass, 1)), source=0.0_wp)
      do k = 1, size(structure%openings)
         associate (i => structure%channel(k), direction => structure%directions(:, k), &
            push => structure%push(k))
            if (structure%rubs(k)) then
               of_rate(i, :) = direction
            else if (structure%elastic(k) .or. structure%wall(k) > 0) then
               of_q(i, :) = direction
            end if
            if (push > 0) of_q(push, :) = structure%laws(k)%numbers(1)*direction
            if (push > 0) of_rate(push, :) = structure%laws(k)%numbers(2)*direction
         end associate
      end do
      if (size(regime%held) > 0) then
         call forces_of_held(structure, regime%held, pushes, forces, status)
         if (status /= stat%ok) return
         of_force(structure%channels + 1:, :) = forces
         of_q(structure%channels + 1:, :) = -matmul(forces, structure%stiffness)
         of_rate(structure%channels + 1:, :) = -matmul(forces, structure%damping)
      end if
      regime%position = transpose(sparse_product(transpose(regime%qx), transpose(of_q)) &
         + sparse_product(transpose(regime%dx), transpose(of_rate)))
      regime%velocity = transpose(sparse_product(transpose(regime%qv), transpose(of_q)) &
         + sparse_product(transpose(regime%dv), transpose(of_rate)))
      allocate (regime%upper(rows), regime%lower(rows), regime%upper_gap(rows), &
         regime%lower_gap(rows), regime%row_offset(rows), regime%ripple(rows, size(load%sine, 2)), &
         regime%rate_position(rows, m), regime%rate_velocity(rows, m), regime%rate_offset(rows))
      call set_row_constants(structure, load%constant, load%cosine, load%sine, of_q, of_rate, &
         of_force, regime)
      if (load%step > 0) then
         regime%base_offset = regime%row_offset
         regime%to_rows = of_force
      end if
      if (structure%moves) call add_walls(structure, forces, regime)
      do k = 1, m
         regime%rate_position(:, k) = -regime%modes%stiffness(k)*regime%velocity(:, k)
         regime%rate_velocity(:, k) = regime%position(:, k) &
            - 2*regime%modes%damping(k)*regime%velocity(:, k)
      end do
      if (.not. allocated(regime%shape)) return
      call move_alloc(of_q, regime%shape%of_q)
      call move_alloc(of_rate, regime%shape%of_rate)
      call move_alloc(of_force, regime%shape%of_force)
   end subroutine set_rows

   !> The limits of the rows, and their constants and harmonics but for walls that move.
   pure subroutine set_row_constants(structure, forces, cosine, sine, of_q, of_rate, of_force, &
      regime)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> (n) Constant forces, with those of contacts; (n, harmonics) harmonics of the load.
      real(wp), intent(in) :: forces(:), cosine(:, :), sine(:, :)
      !> (rows, n) Coefficients of q, q' and the forces in the rows.
      real(wp), intent(in) :: of_q(:, :), of_rate(:, :), of_force(:, :)
      !> In and out: filled in.
      type(regime_type), intent(inout) :: regime
      real(wp) :: constant(size(regime%upper))
      integer :: h, i, j, k

      regime%upper = huge(1.0_wp)
      regime%lower = -huge(1.0_wp)
      regime%upper_gap = 0
      regime%lower_gap = 0
      constant = 0
      do j = 1, size(structure%openings)
         i = structure%channel(j)
         if (structure%rubs(j)) then
            constant(i) = -structure%laws(j)%numbers(3)
            if (is_absorbed(structure, j, regime%resting)) cycle
            if (any(regime%closed == -j)) then
               regime%upper(i) = 0
               regime%upper_gap(i) = j
            else if (all(regime%closed /= j)) then
               regime%lower(i) = 0
               regime%lower_gap(i) = j
            end if
         else if (structure%elastic(j)) then
            call set_stop(structure, j, constant, regime)
         else if (structure%wall(j) > 0) then
            regime%upper(i) = structure%openings(j)
            regime%upper_gap(i) = j
         else
            regime%lower(i) = -structure%openings(j)
            regime%lower_gap(i) = j
         end if
      end do
      do k = 1, size(regime%resting)
         ! a closed channel does not move
         i = structure%channel(regime%resting(k))
         regime%upper(i) = huge(1.0_wp)
         regime%lower(i) = -huge(1.0_wp)
         regime%lower(structure%channels + k) = 0
         regime%lower_gap(structure%channels + k) = -regime%resting(k)
         if (.not. structure%has_friction) cycle
         do j = 1, size(structure%openings)
            i = structure%channels + k
            constant(i) = constant(i) + abs(factor_along(structure, j, regime%resting(k))) &
               *structure%laws(j)%numbers(2)
         end do
      end do
      do k = size(regime%resting) + 1, size(regime%held)
         ! what holds friction that sticks, up to its stick level
         i = structure%channels + k
         regime%upper(i) = structure%laws(regime%held(k))%numbers(2)
         regime%lower(i) = -regime%upper(i)
         regime%upper_gap(i) = -regime%held(k)
         regime%lower_gap(i) = -regime%held(k)
      end do
      regime%row_offset = matmul(of_q, regime%offset) + matmul(of_force, forces)
      if (structure%has_stops .or. structure%has_friction) regime%row_offset = regime%row_offset &
         + constant
      do h = 1, size(sine, 2)
         regime%ripple(:, h) = matmul(of_q, regime%steady(:, h)) &
            + matmul(of_rate, regime%steady_rate(:, h)) &
            + matmul(of_force, cmplx(cosine(:, h), -sine(:, h), wp))
      end do
      regime%rate_offset = 0
      do k = 1, size(regime%modes%drift)
         regime%rate_offset = regime%rate_offset + regime%position(:, k)*regime%modes%drift(k) &
            + regime%velocity(:, k)*regime%modes%force(k)
      end do
   end subroutine set_row_constants

   !> Adds the motions of walls to the rows: these are the distances to the mean positions of the
   !! walls, less the motions of the walls; the acceleration of a wall adds to the contact force.
   pure subroutine add_walls(structure, forces, regime)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> (held, n) As of `forces_of_held`; not set where nothing is held.
      real(wp), allocatable, intent(in) :: forces(:, :)
      !> In and out: the regime.
      type(regime_type), intent(inout) :: regime
      real(wp), allocatable :: inertia(:, :)
      integer :: h, j, k

      do h = 1, size(structure%motion, 1)
         associate (ripple => regime%ripple(:, h), motion => structure%motion(h, :))
            do j = 1, size(structure%openings)
               if (structure%rubs(j)) cycle
               ripple(structure%channel(j)) = ripple(structure%channel(j)) - motion(j)
               if (structure%push(j) == 0) cycle
               associate (numbers => structure%laws(j)%numbers, push => structure%push(j))
                  ripple(push) = ripple(push) - cmplx(numbers(1), h*regime%frequency*numbers(2), &
                     wp)*motion(j)
               end associate
            end do
         end associate
      end do
      if (size(regime%held) == 0) return
      ! (G^T M^-1 G)^-1
      inertia = matmul(matmul(forces, structure%mass), transpose(forces))
      do h = 1, size(structure%motion, 1)
         do k = 1, size(regime%held)
            associate (row => structure%channels + k)
               do j = 1, size(regime%held)
                  regime%ripple(row, h) = regime%ripple(row, h) + (h*regime%frequency)**2 &
                     *inertia(k, j)*structure%motion(h, regime%held(j))
               end do
            end associate
         end do
      end do
   end subroutine add_walls

   !> The limits of a stop, and the constant of its force.
   pure subroutine set_stop(structure, j, constant, regime)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Number of the stop.
      integer, intent(in) :: j
      !> (rows) In and out: constants of the rows.
      real(wp), intent(inout) :: constant(:)
      !> In and out: the regime, with limits.
      type(regime_type), intent(inout) :: regime

      associate (row => structure%channel(j), opening => structure%openings(j))
         if (any(abs(regime%closed) == j)) then
            regime%lower(row) = opening
            regime%lower_gap(row) = j
         else
            regime%upper(row) = opening
            regime%upper_gap(row) = j
         end if
         if (structure%push(j) == 0) return
         associate (push => structure%push(j), numbers => structure%laws(j)%numbers)
            constant(push) = numbers(3) - numbers(1)*opening
            if (any(regime%closed == j)) then
               regime%lower(push) = 0
               regime%lower_gap(push) = j
            else if (any(regime%closed == -j)) then
               regime%upper(push) = 0
               regime%upper_gap(push) = j
            end if
         end associate
      end associate
   end subroutine set_stop

   !> The rows for fast evaluation, and the shortest time scale.
   pure subroutine set_rates(regime, coordinates, step)
      !> In and out: filled in.
      type(regime_type), intent(inout) :: regime
      !> Whether the coordinates are wanted, too.
      logical, intent(in) :: coordinates
      !> Time between the samples of a record; 0 without one.
      real(wp), intent(in) :: step

      call new_rows(regime%modes, regime%position, regime%velocity, regime%row_offset, &
         regime%ripple, regime%frequency, regime%rows)
      if (coordinates) call new_rows(regime%modes, regime%qx, regime%qv, regime%offset, &
         regime%steady, regime%frequency, regime%coordinates, regime%dx, regime%dv)
      call set_unit(regime, step)
   end subroutine set_rates

   !> The shortest time scale.
   pure subroutine set_unit(regime, step)
      !> In and out: the regime.
      type(regime_type), intent(inout) :: regime
      !> As in `set_rates`.
      real(wp), intent(in) :: step
      real(wp) :: fastest
      integer :: k

      fastest = regime%frequency
      do k = 1, size(regime%modes%stiffness)
         fastest = max(fastest, sqrt(regime%modes%stiffness(k)), 2*regime%modes%damping(k))
      end do
      regime%unit = 1
      if (fastest > 0) then
         regime%unit = 1/fastest
      else if (step > 0) then
         regime%unit = step
      end if
   end subroutine set_unit

   !> The tables for steps in time.
   pure subroutine set_tables(regime, same)
      !> In and out: filled in.
      type(regime_type), intent(inout) :: regime
      !> Whether there are tables for the same pairs with the same constant terms.
      logical, intent(in) :: same
      !> Of the longest step and the shortest time scale: the shortest step is then a 64th of it.
      real(wp), parameter :: largest_ratio = 2.0_wp**(levels - 7)
      real(wp) :: speeds(2*size(regime%modes%stiffness) + 1), longest
      integer :: h, j

      speeds = [sqrt(regime%modes%stiffness), 2*regime%modes%damping, regime%frequency]
      longest = 64*time_of_free(regime)
      if (any(speeds > 0)) longest = min(4/minval(speeds, speeds > 0), &
         largest_ratio/maxval(speeds))
      if (.not. same .or. abs(regime%steps%length(1) - longest) > 0) call new_steps(regime%modes, &
         longest, regime%steps)
      if (.not. allocated(regime%turns)) allocate (regime%turns(size(regime%ripple, 2), levels))
      if (allocated(regime%to_force)) then
         ! all constant terms come with the record
         regime%steps%map(:, [3, 6], :) = 0
         regime%rows%grows = .true.
      end if
      do j = 1, levels
         do h = 1, size(regime%turns, 1)
            associate (angle => h*regime%frequency*regime%steps%length(j))
               regime%turns(h, j) = cmplx(cos(angle), sin(angle), wp)
            end associate
         end do
      end do
   end subroutine set_tables

   !> A time scale of free masses: the time between the samples of a record, or that in which the
   !! constant forces close the widest gap.
   pure real(wp) function time_of_free(regime) result(time)
      !> The regime.
      type(regime_type), intent(in) :: regime
      real(wp) :: way, acceleration
      integer :: channels

      channels = regime%positions
      associate (upper => regime%upper(:channels), lower => regime%lower(:channels))
         way = maxval([0.0_wp, pack(abs(upper), abs(upper) < never), pack(abs(lower), &
            abs(lower) < never)])
      end associate
      acceleration = maxval([0.0_wp, abs(matmul(regime%position(:channels, :), &
         regime%modes%force))])
      if (allocated(regime%to_force)) then
         time = regime%unit
      else if (way > 0 .and. acceleration > 0) then
         time = sqrt(way/acceleration)
      else
         time = 1
      end if
   end function time_of_free

   !> The pairs of a state: its free part.
   pure subroutine to_pairs(regime, phase, q, rate, x, v)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> Load phase Omega t (rad).
      real(wp), intent(in) :: phase
      !> (n) Coordinates and velocities.
      real(wp), contiguous, intent(in) :: q(:), rate(:)
      !> (m) The pairs.
      real(wp), contiguous, intent(out) :: x(:), v(:)
      !> Numbers for which there is room without memory of their own.
      integer, parameter :: few = 16
      real(wp) :: room(2*few)
      real(wp), allocatable :: more(:)

      if (size(q) <= few) then
         call convert(regime, size(q), size(x), phase, q, rate, room, x, v)
      else
         allocate (more(2*size(q)))
         call convert(regime, size(q), size(x), phase, q, rate, more, x, v)
      end if
   end subroutine to_pairs

   !> As `to_pairs`, with room.
   pure subroutine convert(regime, n, m, phase, q, rate, free, x, v)
      !> The regime, and its numbers of coordinates and of pairs.
      type(regime_type), intent(in) :: regime
      integer, intent(in) :: n, m
      !> As in `to_pairs`.
      real(wp), intent(in) :: phase, q(n), rate(n)
      !> Room.
      real(wp), intent(out) :: free(n, 2)
      !> The pairs.
      real(wp), intent(out) :: x(m), v(m)
      complex(wp) :: turn
      integer :: h, i

      do i = 1, n
         free(i, 1) = q(i) - regime%offset(i)
         free(i, 2) = rate(i)
      end do
      do h = 1, size(regime%steady, 2)
         turn = cmplx(cos(h*phase), sin(h*phase), wp)
         do i = 1, n
            free(i, 1) = free(i, 1) - real(regime%steady(i, h)*turn)
            free(i, 2) = free(i, 2) - real(regime%steady_rate(i, h)*turn)
         end do
      end do
      call multiply(m, n, regime%xq, regime%xd, free, x)
      call multiply(m, n, regime%vq, regime%vd, free, v)
   end subroutine convert

   !> y = a x + b v, each of the two sums in the order of the columns.
   pure subroutine multiply(n, m, a, b, x, y)
      !> Rows and columns.
      integer, intent(in) :: n, m
      !> The matrices; x and v.
      real(wp), intent(in) :: a(n, m), b(n, m), x(m, 2)
      !> (n)
      real(wp), intent(out) :: y(n)
      !> Rows whose sums stay in registers.
      integer, parameter :: rows = 4
      real(wp) :: p(rows), q(rows)
      integer :: i, k, l

      do i = 1, n - rows + 1, rows
         p = 0
         q = 0
         do k = 1, m
            do l = 1, rows
               p(l) = p(l) + a(i + l - 1, k)*x(k, 1)
               q(l) = q(l) + b(i + l - 1, k)*x(k, 2)
            end do
         end do
         y(i:i + rows - 1) = p + q
      end do
      do i = n - mod(n, rows) + 1, n
         p(1) = 0
         q(1) = 0
         do k = 1, m
            p(1) = p(1) + a(i, k)*x(k, 1)
            q(1) = q(1) + b(i, k)*x(k, 2)
         end do
         y(i) = p(1) + q(1)
      end do
   end subroutine multiply

   !> Coordinates and velocities from the pairs.
   pure subroutine state_of(regime, phase, x, v, q, rate, turns)
      !> The regime.
      type(regime_type), intent(in) :: regime
      !> Load phase Omega t (rad).
      real(wp), intent(in) :: phase
      !> (m) The pairs.
      real(wp), contiguous, intent(in) :: x(:), v(:)
      !> (n) Coordinates and velocities.
      real(wp), contiguous, intent(out) :: q(:), rate(:)
      !> (harmonics) e^(i h phase).
      complex(wp), intent(out), optional :: turns(:)
      integer :: h

      call free_values(regime%coordinates, x, v, q, rate)
      do h = 1, size(regime%steady, 2)
         associate (turn => cmplx(cos(h*phase), sin(h*phase), wp))
            call add_harmonic(size(q), regime%coordinates%ripple(:, h), h*regime%frequency, turn, &
               q, rate)
            if (present(turns)) turns(h) = turn
         end associate
      end do
   end subroutine state_of

   !> As `state_of`, of one coordinate, with the same bits, where no coordinate depends on v.
   pure subroutine coordinate_of(regime, i, phase, x, v, q, rate)
      !> The regime, and the number of the coordinate.
      type(regime_type), intent(in) :: regime
      integer, intent(in) :: i
      !> As in `state_of`.
      real(wp), intent(in) :: phase
      real(wp), contiguous, intent(in) :: x(:), v(:)
      !> The coordinate and its velocity.
      real(wp), intent(out) :: q, rate
      real(wp) :: values(2)
      integer :: h

      call free_value(regime%coordinates, i, x, v, values(1), values(2))
      do h = 1, size(regime%steady, 2)
         call add_harmonic(1, regime%coordinates%ripple(i, h), h*regime%frequency, &
            cmplx(cos(h*phase), sin(h*phase), wp), values(1), values(2))
      end do
      q = values(1)
      rate = values(2)
   end subroutine coordinate_of

end module vi_structure
