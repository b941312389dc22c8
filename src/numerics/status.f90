!> Status codes of computations: one integer and one text for each kind of failure.
!!
!! The core never prints and never stops. A procedure that can fail returns one of these codes; a
!! point of a chart that fails gets its code and NaN, and the rest of the chart is still computed.
module vi_status
   implicit none (type, external)
   private

   public :: status_text

   type :: status_codes
      integer :: ok = 0
      !> The linear equations, (26) and (30) for the oscillator, have no unique solution.
      integer :: singular = 1
      !> Equal durations and equal restitution: A is free (rank 3); the clearance must be given.
      integer :: free_amplitude = 2
      !> The solution needs no load (A = 0).
      integer :: no_load = 3
      !> An impact has no approach speed: the impact map has no derivative there.
      integer :: zero_approach = 4
      !> LAPACK reported a failure (an illegal value, or QR iterations that did not converge).
      integer :: lapack_failed = 5
      !> A result is not a finite number.
      integer :: not_finite = 6
      !> There is no such motion for these parameters.
      integer :: no_motion = 7
      !> The list of events is full; another call continues.
      integer :: more_events = 8
      !> A search for the next event exceeded its step budget.
      integer :: budget = 9
      !> Newton's method did not converge.
      integer :: no_convergence = 10
      !> Rounding leaves too few digits.
      integer :: lost_digits = 11
      !> The computation was stopped before it reached this point.
      integer :: not_computed = 12
      !> A simulation exceeded its limit on the number of events.
      integer :: event_limit = 13
      !> There is not enough memory.
      integer :: no_memory = 14
      !> The mass matrix of a structure is not positive definite.
      integer :: mass_not_definite = 15
      !> The stiffness or the damping matrix of a structure has a negative eigenvalue.
      integer :: negative_stiffness = 16
      !> Damping makes modes of a structure nearly coincide.
      integer :: defective = 17
      !> A mode without damping resonates with the load or the period.
      integer :: resonance = 18
      !> Coupled gaps close at the same instant.
      integer :: coupled_impacts = 19
      !> A gap is negative in the initial state.
      integer :: gap_closed = 20
      !> The motion on which a simulation settles has no impacts.
      integer :: no_impacts = 21
      !> A simulation does not repeat within the load cycles allowed.
      integer :: no_period = 22
      !> Lengths, masses or frequencies of a structure are so small or large that powers of them
      !! are not represented.
      integer :: extreme_units = 23
      !> A simulation repeats near a motion that is not stable.
      integer :: not_stable = 24
      !> A motion at a fold or a pitchfork has no derivatives.
      integer :: fold = 25
      !> A motion with an impact or a gap that only touches has no derivatives.
      integer :: graze = 26
      !> The equations of a motion do not hold.
      integer :: not_exact = 27
      !> Multipliers coincide: they are not smooth functions of the parameters.
      integer :: coincident = 28
      !> A greatest value is reached twice, and the two change differently.
      integer :: not_smooth = 29
      !> The relative position is not stationary in a flight.
      integer :: no_extremum = 30
      !> Newton's method leads from a motion to one of a shorter period, or to one that is its own
      !! mirror image.
      integer :: shorter_period = 31, symmetric = 32
      !> The directions of gaps that are at rest together depend on each other.
      integer :: dependent_rests = 33
      !> A mean force acts on a mode of frequency 0 of a structure, and no impulses balance it.
      integer :: unbalanced = 34
      !> Stiffnesses or masses of a structure differ so much that slow modes are lost in rounding.
      integer :: too_stiff = 35
      !> The motion on which a simulation settles is one in which gaps stay at rest.
      integer :: permanent_rest = 36
      !> An opening is so small that rounding errors of the displacements decide when it closes.
      integer :: narrow_gap = 37
      !> A stop with a preload holds what touches it at zero speed.
      integer :: stop_holds = 38
      !> Friction moves with impacts that accumulate, but not along their gap.
      integer :: friction_rests = 39
      !> No states of friction fit the forces, or a belt drags a mass that nothing holds.
      integer :: friction_undecided = 40
      !> Friction sticks through the whole period of the motion on which a simulation settles.
      integer :: permanent_stick = 41
      !> Simultaneous impacts on coupled gaps: the motion that follows has no derivative.
      integer :: no_derivative = 42
      !> Successive impacts at the same instant do not end.
      integer :: endless_sequence = 43
      !> Newton's law at all coupled gaps at once would add energy.
      integer :: gains_energy = 44
      !> The directions of friction that sticks, and of gaps that rest, depend on each other.
      integer :: dependent_friction = 45
   end type status_codes

   !> The codes by name, for example stat%no_motion.
   type(status_codes), parameter, public :: stat = status_codes()

contains

   !> The text of a status code.
   pure function status_text(code) result(text)
      !> A status code, as in `stat`.
      integer, intent(in) :: code
      character(len_trim(sentence(code))) :: text

      text = sentence(code)
   end function status_text

   !> The text of a status code, padded with blanks.
   pure function sentence(code) result(text)
      !> A status code, as in `stat`.
      integer, intent(in) :: code
      character(160) :: text

      select case (code)
      case (stat%ok)
         text = 'done'
      case (stat%singular)
         text = 'the linear equations have no unique solution for these phases, or the position of &
            &a body without spring and damper is not determined'
      case (stat%free_amplitude)
         text = 'two equally spaced impacts with equal restitution do not determine the load &
            &amplitude: compute the equispaced motions for a clearance instead'
      case (stat%no_load)
         text = 'no clearance d > 0 and load F0 > 0 give these phases (the load of the solution is &
            &zero)'
      case (stat%zero_approach)
         text = 'an impact has no approach speed, so the motion has no multipliers'
      case (stat%lapack_failed)
         text = 'a LAPACK routine failed'
      case (stat%not_finite)
         text = 'the result is not a finite number: the parameters are extreme'
      case (stat%no_motion)
         text = 'there is no such motion for these parameters'
      case (stat%more_events)
         text = 'the list of events is full before the end of the simulation'
      case (stat%budget)
         text = 'a flight lasts millions of oscillations and takes more steps than are allowed'
      case (stat%lost_digits)
         text = 'rounding leaves too few digits: large terms cancel near a resonance without &
            &damping, far above it, and where phases nearly coincide; change r or add damping'
      case (stat%not_computed)
         text = 'the computation was stopped before this point'
      case (stat%event_limit)
         text = 'the simulation reached max_events events before its end'
      case (stat%no_memory)
         text = 'out of memory'
      case (stat%no_convergence)
         text = 'the iteration did not converge; a closer guess may help'
      case (stat%mass_not_definite)
         text = 'the mass matrix is not positive definite'
      case (stat%negative_stiffness)
         text = 'the stiffness or the damping matrix has a negative eigenvalue'
      case (stat%defective)
         text = 'damping makes two modes of the structure nearly coincide, so that digits are &
            &lost; change a damping coefficient by a millionth of its size'
      case (stat%resonance)
         text = 'a mode without damping resonates with the load or the period, or so nearly that &
            &digits are lost'
      case (stat%coupled_impacts)
         text = 'two coupled gaps close at the same instant: set simultaneous = ''newton'' or &
            &''sequence'' in the structure, or change one opening by a relative 1e-12'
      case (stat%gap_closed)
         text = 'a gap is negative in the initial state'
      case (stat%no_impacts)
         text = 'the simulation settles on a motion without impacts; start from another state'
      case (stat%extreme_units)
         text = 'a frequency is above 1e12, or a mass, opening, forced motion or state is outside &
            &1e-40 to 1e40: choose other units'
      case (stat%no_period)
         text = 'the simulation does not repeat within the longest period that is considered: it &
            &may be chaotic; otherwise simulate longer first, or allow more load cycles'
      case (stat%not_stable)
         text = 'the simulation is still near an unstable periodic motion; simulate longer first'
      case (stat%fold)
         text = 'the motion is at a fold or a pitchfork, where it has no derivatives'
      case (stat%graze)
         text = 'an impact has no approach speed, or a gap closes without one: at such a graze the &
            &motion has no derivatives'
      case (stat%not_exact)
         text = 'the equations of the motion do not hold to rounding: find the exact motion first'
      case (stat%coincident)
         text = 'multipliers coincide, so that they have no derivatives'
      case (stat%not_smooth)
         text = 'two maxima are equally large and change differently, so the greatest value has no &
            &derivative'
      case (stat%no_extremum)
         text = 'the relative position is not stationary inside the flight'
      case (stat%shorter_period)
         text = 'the iteration leads to a motion of a shorter period: the guess is too far away, &
            &or beyond the flip where motions of its period end'
      case (stat%symmetric)
         text = 'the iteration leads to a motion that is its own mirror image: the guess is too &
            &far away, or beyond the pitchfork where motions like it end'
      case (stat%dependent_rests)
         text = 'gaps with linearly dependent directions are closed together, as on both sides of &
            &a slot without play: their forces are not determined'
      case (stat%unbalanced)
         text = 'a constant force acts on a mode of frequency 0, and impacts on these gaps cannot &
            &balance it: there is no periodic motion'
      case (stat%too_stiff)
         text = 'masses or stiffnesses differ so much that slow modes keep fewer than 7 digits: &
            &make stiff springs rigid, or give the structure by its modes'
      case (stat%permanent_rest)
         text = 'the simulation settles on a permanent rest of gaps or stick of friction without &
            &further events; start from another state'
      case (stat%narrow_gap)
         text = 'an opening is below a million times the rounding error of the displacements'
      case (stat%stop_holds)
         text = 'a stop is touched at zero speed by a force below its preload, which would hold &
            &the structure there: start with a speed, or without a preload'
      case (stat%friction_rests)
         text = 'impacts accumulate on a gap and move friction that acts across it, on a belt or &
            &along a moving wall, or R of the gap is a law: what follows cannot be computed'
      case (stat%friction_undecided)
         text = 'friction elements have no consistent state at this instant, or a belt drags a &
            &mass that no spring holds: the motion that follows cannot be computed'
      case (stat%permanent_stick)
         text = 'friction sticks permanently wherever it stops, so there is a continuum of &
            &motions: make what sticks rigid, or start from another state'
      case (stat%no_derivative)
         text = 'coupled gaps close, or coupled friction elements change, at the same instant: the &
            &motion that follows depends on their order and has no derivatives'
      case (stat%endless_sequence)
         text = 'coupled gaps close at the same instant, and 20000 successive impacts do not &
            &separate them: set simultaneous = ''newton'' in the structure'
      case (stat%gains_energy)
         text = 'coupled gaps with different restitution close at the same instant, and Newton''s &
            &law would add energy: set simultaneous = ''sequence'' in the structure'
      case (stat%dependent_friction)
         text = 'friction elements with linearly dependent directions stick at once: their forces &
            &are not determined; combine those along one direction into one'
      case default
         text = 'unknown status code'
      end select
   end function sentence

end module vi_status
