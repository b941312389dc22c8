"""Exact motions by Newton's method."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError, SingularError
from ..base.interrupt import with_stack
from ..base.status import MORE_EVENTS, SHORTER_PERIOD, SYMMETRIC, raise_status
from ..results import door
from ..results.events import event_table
from ..systems.oscillator import Oscillator, Pattern, Point, of_numbers, plain_pattern
from ..systems.structure import Load, Structure, check_load, without_none
from ..systems.verbs import every_system, physical_arguments
from .motion import Motion, MotionSet, motion_of_oscillator, motion_of_structure, rests_of
from .periodic import (
    EXACT,
    frozen,
    gap_pattern,
    impact_restitution,
    motion_from_phases,
    motion_with_events,
    periodic,
)
from .trajectory import FULL, Trajectory, core_arrays, end_of, letters_of, not_periodic

if TYPE_CHECKING:
    from ..systems.units import Value

__all__ = ["exact"]

MOST_ITERATIONS = 50
#: Limits on the impacts and rests in a period of a motion with rest, tried in turn: most motions have few.
REST_EVENTS = (200, 20_000)
#: Relative distance at which motions count as the same, as in the core.
ALIKE = 1e-6
#: Load cycles that are simulated for a motion with rest from q = 0, and how far its impacts may be from those of
#: the guess, in load phase.
SETTLING, NEAR = 500, 0.05
#: What may be the reason why no motion is found from a simulation.
UNSETTLED = (
    "the simulation may not have settled on a period; discard more load cycles, unless it is chaotic "
    "(see `lyapunov`)"
)


def _guess_by_gaps(given: dict[str, Any]) -> None:
    """Converts a guess for an oscillator to one for a structure: load phases, gaps, cycles."""
    guess = given.get("guess")
    if isinstance(guess, Motion) and not guess.of_structure:
        if guess.pattern.has_rest:
            raise ParameterError(
                f"guess = {guess!r}: must be a motion without rest where restitution depends on the speed, or a "
                "simulation with that restitution"
            )
        given["guess"] = (guess.phases, guess.gaps.tolist(), guess.cycles)
    elif isinstance(guess, tuple) and len(guess) == 2 and isinstance(guess[1], (Pattern, str)):
        pattern = plain_pattern(guess[1])
        given["guess"] = (guess[0], np.where(pattern.signs > 0, 0, 1).tolist(), pattern.cycles)


def exact_structure(
    structure: Structure, load: Load | None, guess: Motion | Trajectory | tuple[Any, ...]
) -> Motion:
    """As `exact`, for a structure."""
    if isinstance(guess, (Motion, Trajectory)) and not guess.of_structure:
        raise ParameterError(
            f"guess = {guess!r}: must be for a structure, since the system is a structure"
        )
    if isinstance(guess, (Motion, Trajectory)) and (
        load is None or (isinstance(load, Load) and not load.frequency)
    ):
        return self_excited(structure, without_none(load), guess)
    checks.instance(load, "load", Load)
    assert load is not None
    if isinstance(guess, Trajectory):
        check_load(structure, load, frequency=True, stops=True)
        try:
            return settled(structure, load, guess.end, guess.final_state)
        except SingularError as error:
            if guess.complete:
                raise SingularError(f"{error}; {UNSETTLED}") from None
            raise SingularError(
                f"{error}; the simulation was cut short, {guess.cut or FULL}"
            ) from None
    checks.instance(structure, "structure", Structure)
    elastic = not structure._is_rigid
    if isinstance(guess, Motion):
        if not guess.consistent and guess.request and guess.request.get("kinds"):
            # a simulation could not begin where presumed events leave a closed gap
            check_load(structure, load, frequency=True, stops=True)
            return motion_with_events(structure, load, **{**guess.request, "kind": "exact"})
        if elastic:
            check_load(structure, load, frequency=True, stops=True)
            start, state = guess._run()._between_events()
            start *= guess.load.frequency / load.frequency
            return of_same_kind(settled(structure, load, start, state, cycles=guess.cycles), guess)
        if structure.simultaneous and guess._is_settled:
            check_load(structure, load, frequency=True)
            start, state = guess._run()._between_events()
            start *= guess.load.frequency / load.frequency
            return settled(structure, load, start, state, cycles=guess.cycles)
        if len(guess.rests):
            check_load(structure, load, frequency=True)
            start = guess.phases[0] / guess.load.frequency * (guess.load.frequency / load.frequency)
            found = settled(structure, load, start, (guess.q, guess.q_dot), cycles=guess.cycles)
            return of_same_kind(found, guess)
        phases, gaps, cycles = guess.phases, guess.gaps.tolist(), guess.cycles
    elif elastic:
        raise ParameterError(
            f"guess = {guess!r}: must be a Trajectory, as from simulate, or a Motion with stops or friction, "
            "since their events are part of the motion"
        )
    elif isinstance(guess, tuple) and len(guess) in (2, 3):
        phases, gaps, cycles = guess if len(guess) == 3 else (*guess, 1)
    else:
        raise ParameterError(
            f"guess = {guess!r}: must be a Motion, a Trajectory, (phases, gaps) or (phases, gaps, cycles)"
        )
    numbers, phases, cycles = gap_pattern(structure, load, phases, gaps, cycles)
    if isinstance(guess, Motion):
        return of_same_kind(
            motion_from_phases(structure, load, numbers, phases, cycles, EXACT), guess
        )
    chain = accumulation(numbers, phases, cycles)
    try:
        found = motion_from_phases(structure, load, numbers, phases, cycles, EXACT)
        # impacts without approach speed solve the equations of an accumulation, too
        if chain is None or found.admissible or not np.isnan(found.multipliers).any():
            return found
    except SingularError:
        if chain is None:
            raise
    return resting_motion(structure, load, numbers, phases, cycles, chain)


def accumulation(
    labels: NDArray[np.int32], phases: NDArray[np.float64], cycles: int
) -> tuple[int, int] | None:
    """Index of the first and last impact of a series on one gap or wall that follow each other ever faster; None
    if there is none."""
    n = len(labels)
    time = np.diff(np.append(phases, phases[0] + 2 * np.pi * cycles))
    for last in range(n):
        flight = last - 1  # before the last impact
        while (
            last - flight < n - 1
            and labels[flight % n] == labels[last]
            and labels[(flight - 1) % n] == labels[last]
            and time[(flight - 1) % n] > time[flight % n]
        ):
            flight -= 1
        # four flights at least, the last of which is much shorter than the first
        if (
            last - flight > 3
            and labels[flight % n] == labels[last]
            and time[(last - 1) % n] < 0.1 * time[flight % n]
            and time[last] > time[flight % n]
        ):
            return flight % n, last
    return None


def resting_motion(
    structure: Structure, load: Load, numbers: NDArray[np.int32], phases: NDArray[np.float64],
    cycles: int, chain: tuple[int, int],
) -> Motion:  # fmt: skip
    """The motion with rest on which a simulation from q = 0 settles, if its impacts are those of a guess."""
    still = np.zeros(structure.coordinates)
    try:
        found = settled(structure, load, 0.0, (still, still), SETTLING, cycles=cycles)
    except (ParameterError, SingularError):
        raise rests_after(chain, f"gap {numbers[chain[1]]}") from None
    turn = 2 * np.pi * cycles
    off = np.subtract.outer(phases, found.phases) + turn / 2
    off = np.abs(np.mod(off, turn) - turn / 2)
    off[numbers[:, None] != found.gaps] = turn
    # the number of the last impacts of an accumulation depends on rounding
    sure = [alone(phases, turn), alone(found.phases, turn)]
    sure[0][chain[0]] = True
    # nor need the guess have all of them
    for gap, begin in found.rests[["gap", "begin"]].tolist():
        left = np.mod(begin - np.array([phases[chain[1]], *found.phases]) + NEAR, turn)
        sure[1] &= (found.gaps != gap) | (left[1:] > left[0])
    if (
        len(found.rests)
        and (off.min(axis=1)[sure[0]] < NEAR).all()
        and (off.min(axis=0)[sure[1]] < NEAR).all()
    ):
        return found
    raise rests_after(chain, f"gap {numbers[chain[1]]}")


def alone(phases: NDArray[np.float64], turn: float) -> NDArray[np.bool_]:
    """Which impacts are not near another one of the same motion."""
    flights = np.diff(np.append(phases, phases[0] + turn))
    return np.minimum(flights, np.roll(flights, 1)) > 2 * NEAR


def rests_after(chain: tuple[int, int], place: str) -> SingularError:
    """The error of a guess whose impacts accumulate."""
    return SingularError(
        f"guess: the impacts {chain[0]} to {chain[1]} on {place} accumulate, so the motion rests there, which "
        "phases of impacts do not describe; use a simulation on it, or a motion with rest at other parameters, as "
        "the guess"
    )


def self_excited(structure: Structure, load: Load | None, guess: Motion | Trajectory) -> Motion:
    """The motion of a structure without a periodic load, whose period is unknown."""
    check_load(structure, load, kinds=(Load, type(None)), stops=True)
    if isinstance(guess, Motion):
        _, state = guess._run()._between_events()
        known = {"period": guess.period}
    else:
        state = guess.final_state
        known = {"duration": guess.end - guess.start}
    n = structure.coordinates
    for values in state:
        if np.size(values) != n:
            raise ParameterError(
                f"guess = {guess!r}: must have {n} coordinates, as the structure has"
            )
    return self_excited_from(structure, load, state, **known)


def self_excited_from(
    structure: Structure, load: Load | None, state: tuple[ArrayLike, ArrayLike], **known: float
) -> Motion:
    """The self-excited motion near a state, with its period or the duration of a simulation."""
    groups = [*structure._groups(), *([] if load is None else load._groups())]
    keys = {"kind": "settled", "settling": 0, **known}
    for name, values in zip(("q", "q_dot"), state, strict=True):
        keys[name] = np.asarray(values).tolist()
    found = door.run_groups(MotionSet, groups, keys, True, little=True)
    found.require()
    return found.parts()[0]


def settled(
    structure: Structure,
    load: Load,
    start: float,
    state: tuple[ArrayLike, ArrayLike],
    settling: int = 0,
    most_cycles: int = 16,
    cycles: int = 0,
) -> Motion:
    """The motion of a structure on which a simulation from a state settles."""
    matrices, directions, values, _, harmonics, constant = core_arrays(structure, load, True)[:6]
    capacity = 500
    while True:
        counts, labels, impacts, states, rests, matrix, multipliers, scalars, verdicts, status = (
            with_stack(
                _core.settle_structure, matrices, directions, values, load.frequency, harmonics, constant, start,
                np.concatenate(state), settling, most_cycles, cycles, capacity,
            )
        )  # fmt: skip
        if status != MORE_EVENTS:
            break
        capacity = int(max(counts[0], counts[2]))
    structure._raise_status(status)
    known = {"cycles": cycles} if cycles else {}
    request: dict[str, Any] = {
        "kind": "settled", **known, "settling": settling, "max_cycles": most_cycles,
        "q": np.asarray(state[0]).tolist(), "q_dot": np.asarray(state[1]).tolist(), "start": float(start),
    }  # fmt: skip
    n, k, m = counts.tolist()
    return motion_of_structure(
        structure, load, labels[0, :n] - 1, k, impacts[:n], states[:, :n], matrix, multipliers,
        scalars, verdicts, rests_of(labels[1, :m] - 1, rests[:, :m]), request,
    )  # fmt: skip


@overload
def exact(
    osc: Oscillator, r: Value, clearance: Value, guess: Motion | Trajectory | tuple[Any, Pattern | str],
    load: Value | Load = 1.0,
) -> Motion: ...  # fmt: skip
@overload
def exact(
    structure: Structure, load: Load, guess: Motion | Trajectory | tuple[Any, ...]
) -> Motion: ...
@overload
def exact(point: Point, /, guess: Motion | Trajectory | tuple[Any, Pattern | str]) -> Motion: ...


@physical_arguments
@every_system(exact_structure, of_law=_guess_by_gaps)
def exact(
    osc: Oscillator,
    r: float,
    clearance: float,
    guess: Motion | Trajectory | tuple[Any, Pattern | str],
    load: float | Load = 1.0,
) -> Motion:
    """The exact periodic motion near a guess, by Newton's method with the analytic derivative.

    Without rest the unknowns are the N positions and N phases of the impacts. With accumulation and rest they are
    the phase and velocity at a release, as a fixed point of the return map.

    The system is `osc, r, clearance`, or a point from `Oscillator.at`, or `structure, load`. For a structure the
    unknowns are the phases and approach speeds of the impacts and the mean positions of modes of frequency 0; a
    guess given as numbers is (phases, gaps) or (phases, gaps, cycles), with the load phase and the gap of each
    impact. With rest the unknown is the state in the middle of the longest flight, as a fixed point of the map
    over the period. An oscillator whose restitution depends on the speed is solved as a structure: the phases of
    its guess are also load phases.

    Without a load, or with a constant load, the motion is self-excited, such as that of a mass on a belt that
    sticks and slips: the unknowns are the state in the middle of the longest flight and the period. `Motion.load`
    then has the frequency 2 pi/T of the motion and no harmonics, phases are measured from the first event, and one
    multiplier is the trivial 1 of a shift in time; its index is `Motion.trivial`, and `stable` ignores it.

    Parameters
    ----------
    osc : Oscillator
        The system: xi, mu and the coefficients of restitution of both walls.
    r, clearance : float
        As in `simulate`.
    structure, load : Structure, Load or None
        In place of `osc`, `r` and `clearance`; the load is None or `Load.none()` for no load.
    guess : Motion, Trajectory or (phases, pattern)
        A motion at other parameters; a trajectory whose last cycles are approximately periodic; or impact phases,
        for which the linear equations of the 1983 paper give the rest. Of the periods of up to 16 load cycles
        found at the end of a trajectory (see `Trajectory.period`), the one that repeats most accurately is used,
        because just past a period doubling the shorter period repeats approximately, too. A structure with stops
        or friction, or without a load, needs a motion or a trajectory; without a load the trajectory is continued
        for its own length once more, and its events must repeat at the end. If the impacts of a guess given as
        phases accumulate, the motion on which the structure settles from q = 0 is returned, provided that it has
        these impacts followed by rest.
    load : float
        As in `simulate`.

    Returns
    -------
    Motion
        `admissible` is False if the solution of the equations would pass through a wall.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed, or the trajectory has no impacts at its end or is not approximately
        periodic.
    SingularError
        If the iteration does not converge, or leads from a motion to one with a shorter period or to one that is
        its own mirror image: motions like the guess then end at a flip or a pitchfork. If the impacts of a guess
        given as phases accumulate and the motion with rest is not found, the message says so.

    Examples
    --------
    The motion that corresponds to the third column of Table 1, at d K/F0 = 37 exactly:

    >>> import math, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motion = vi.exact(osc, 0.94, 37.0, ([0, 1.37 * math.pi], vi.Pattern("RL")))
    >>> motion.phases / math.pi, motion.stable
    (array([0.51727213, 1.89929862]), True)

    From a simulation, with rest on the left wall:

    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    >>> vi.exact(osc, 0.9, 6.0, vi.simulate(osc, 0.9, 6.0, cycles=8, discard=200))
    <Motion RL*/1 at r = 0.9, d K/F0 = 6: admissible, stable (max|lambda| = 0.9189)>

    A mass on a spring that hits one wall, example 15.2 of H. Dankowicz and F. Schilder, Recipes for Continuation
    (SIAM, 2013):

    >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    >>> motion = vi.exact(wall, vi.Load(1.0, cosine=[1]), ([0.1], [0]))
    >>> round(float(motion.phases[0]), 8), round(float(motion.speeds[0]), 8), motion.stable
    (0.07595216, 1.69573294, True)

    A mass on a belt sticks and slips without a load; the period is known in closed form:

    >>> belt = vi.Friction([1], slip=0.6, stick=1.0, speed=0.2)
    >>> bow = vi.Structure(mass=[1], damping=[0], stiffness=[1], friction=[belt])
    >>> motion = vi.exact(bow, vi.Load.none(), vi.simulate(bow, duration=50))
    >>> motion.stable, motion.trivial, round(motion.period, 9)
    (True, 0, 8.068887872)
    >>> abs(motion.period - (4 + 2 * math.pi - 2 * math.atan(2))) < 1e-12
    True
    """
    of_numbers(osc)
    r = checks.frequency_ratio(r, osc.xi)
    clearance = checks.number(clearance, "clearance")
    load = checks.number(load, "load")
    each = given = None
    if isinstance(guess, (Motion, Trajectory)) and guess.of_structure:
        raise ParameterTypeError(
            f"guess = {guess!r}: must be for an oscillator, since the system is an oscillator"
        )
    if isinstance(guess, Motion):
        pattern = guess.pattern
        if pattern.has_rest:
            # the velocity at a release scales with the load and depends little on the clearance
            releases = of_releases(guess, load / guess.load)
            found = release_motion(osc, r, clearance, load, pattern.cycles, releases)
            return of_same_kind(found, guess)
        each = None if guess.osc.restitution != osc.restitution else guess.restitution
        if (
            guess.kind == "periodic"
            and (guess.osc, guess.r) == (osc, r)
            and guess.precision == "double"
        ):
            given = guess.alpha
        x, theta = guess.X * (clearance / guess.clearance), guess.alpha + guess.tau
    elif isinstance(guess, Trajectory):
        return motion_at_end(osc, r, clearance, load, guess)
    elif isinstance(guess, tuple) and len(guess) == 2 and isinstance(guess[1], (Pattern, str)):
        linear = periodic(osc, r, guess[0], guess[1])
        pattern = linear.pattern
        given = linear.alpha
        x, theta = linear.X * (clearance / linear.clearance), linear.alpha + linear.tau
    else:
        raise ParameterTypeError(
            f"guess = {guess!r}: must be a Motion, a Trajectory or a tuple (phases, pattern)"
        )
    if isinstance(guess, Motion):
        return of_same_kind(newton(osc, r, clearance, load, pattern, x, theta, each, given), guess)
    try:
        return newton(osc, r, clearance, load, pattern, x, theta, each, given)
    except SingularError:
        chain = accumulation(pattern.signs, theta, pattern.cycles)
        if chain is None:
            raise
        raise rests_after(chain, f"wall {pattern.sides[chain[1]]}") from None


def of_same_kind(found: Motion, guess: Motion) -> Motion:
    """Return a motion found from an exact motion; raise an error if it has a shorter period or a symmetry that the
    guess lacks.

    At a flip or a pitchfork two motions merge; beyond it Newton's method converges to the remaining one.
    """
    if guess.consistent:
        if is_repeated(found) and not is_repeated(guess):
            raise_status(SHORTER_PERIOD)
        if is_mirrored(found) and not is_mirrored(guess):
            raise_status(SYMMETRIC)
    return found


def is_repeated(motion: Motion) -> bool:
    """Whether a motion is described over several of its periods."""
    if motion.of_structure:
        return repeats(motion, 1)
    sides, cycles = motion.pattern.sides, motion.pattern.cycles
    # most patterns cannot repeat
    parts = (m for m in range(2, cycles + 1) if not cycles % m and not len(sides) % m)
    if not any(sides == sides[: len(sides) // m] * m for m in parts):
        return False
    system = (motion.osc, motion.r, motion.clearance, motion.load)
    _, _, shortest, *_ = found_motion(*system, cycles, *parts_of(motion), 1)
    return bool(shortest < cycles)


def is_mirrored(motion: Motion) -> bool:
    """Whether a motion is its own mirror image half a period later."""
    if motion.of_structure:
        return repeats(motion, -1)
    system = (motion.osc.xi, motion.r, motion.load, motion.clearance, motion.pattern.cycles)
    right, left = motion.osc.restitution
    parts = parts_of(motion)
    return right == left and bool(_core.same_motion(*system, *parts, *parts, True))


def repeats(motion: Motion, sign: int) -> bool:
    """Whether a motion of a structure repeats itself, or its mirror image -q (sign -1), after a fraction of its
    period."""
    many, cycles = len(motion.gaps), motion.cycles
    # where all gaps are closed at 0, the coordinates at the impacts are; where friction halts, the velocities
    q, rate = np.abs(motion.states).max(axis=(0, 2))
    length = max(q, rate / motion.load.frequency)
    sizes = length, length * motion.load.frequency
    for m in range(2, cycles + 1) if sign > 0 else range(2, 2 + cycles % 2):
        shift = many // m
        if many % m or (sign > 0 and cycles % m):
            continue
        later = np.roll(motion.phases, -shift)
        later[many - shift :] += 2 * np.pi * cycles
        off = [later - motion.phases - 2 * np.pi * cycles / m]
        for each, size in zip(motion.states.transpose(1, 0, 2), sizes, strict=True):
            off.append((np.roll(each, -shift, axis=0) - sign * each) / (size or 1.0))
        if all(np.abs(part).max() < ALIKE for part in off):
            return True
    return False


def attractor_at_end(run: Trajectory, cycles: int) -> Motion | None:
    """The exact motion on which a trajectory ends, if it is stable and has the given period in load cycles."""
    osc, r, clearance, load = run.osc, run.r, run.clearance, run.load
    system = (osc.xi, osc.mu, osc.restitution, r, load, clearance)
    answer = roomy(_core.end_of_trajectory, *system, *end_of(run, cycles), 2)
    return None if answer[-1] else described_motion(osc, r, clearance, load, answer[5:])


def motion_at_end(
    osc: Oscillator, r: float, clearance: float, load: float, run: Trajectory
) -> Motion:
    """The exact motion on which a trajectory ends."""
    system = (osc.xi, osc.mu, osc.restitution, r, load, clearance)
    try:
        answer = roomy(_core.end_of_trajectory, *system, *end_of(run), 1)
        if not answer[0]:
            raise not_periodic(run)
    except ParameterError as error:
        raise ParameterError(f"guess = {error}, or give phases and a pattern") from None
    try:
        return described_motion(osc, r, clearance, load, answer[5:])
    except SingularError as error:
        raise SingularError(f"{error}; {UNSETTLED}") from None


def newton(
    osc: Oscillator,
    r: float,
    clearance: float,
    load: float,
    pattern: Pattern,
    x: NDArray[np.float64],
    theta: NDArray[np.float64],
    restitution: NDArray[np.float64] | None = None,
    given: NDArray[np.float64] | None = None,
) -> Motion:
    """Newton's method on x_i and theta_i = alpha_i + tau of a pattern without rest.

    `given` contains the phases from which the linear equations gave these values; it is stored in the result.
    """
    each = impact_restitution(osc, pattern, None) if restitution is None else restitution
    phases, impacts, scalars, multipliers, verdicts, status, _ = _core.exact(
        osc.xi, osc.mu, osc.restitution, r, load, clearance, pattern.cycles, pattern.signs, each,
        x, theta,
        MOST_ITERATIONS,
    )  # fmt: skip
    raise_status(int(status))
    return motion_of_oscillator(
        osc, r, clearance, load, pattern, each, phases, impacts, scalars, multipliers, verdicts,
        guess=given,
    )  # fmt: skip


def of_releases(motion: Motion, factor: float) -> NDArray[np.float64]:
    """Side, phase and velocity, times a factor, of the releases of a motion with rest, (3, m)."""
    events = motion.events[motion.events["kind"] == "release"]
    sides = np.where(events["side"] == "R", 1.0, -1.0)
    return np.asfortranarray([sides, events["phase"], factor * events["x_dot_after"]])


class Parts(NamedTuple):
    """A motion in the form that the core compares: impacts of a motion without rest, releases of a motion with
    rest; the other parts are zero."""

    sides: NDArray[np.int32]
    unknowns: NDArray[np.float64]
    releases: NDArray[np.float64]


def parts_of(motion: Motion) -> Parts:
    """A motion in that form."""
    if motion.rest_events is None:
        unknowns = np.append(motion.X, motion.alpha + motion.tau)
        return Parts(motion.pattern.signs, unknowns, np.zeros((3, 1), order="F"))
    return Parts(np.zeros(1, np.int32), np.zeros(2), of_releases(motion, 1.0))


def release_motion(
    osc: Oscillator, r: float, clearance: float, load: float, cycles: int,
    releases: NDArray[np.float64],
) -> Motion:  # fmt: skip
    """Newton's method on the return map of releases (3, m): side, phase and velocity, starting with the last
    one."""
    _, *answer = found_motion(
        osc, r, clearance, load, cycles, np.zeros(1, np.int32), np.zeros(2), releases, 0
    )
    return described_motion(osc, r, clearance, load, answer)


def found_motion(
    osc: Oscillator, r: float, clearance: float, load: float, cycles: int, sides: NDArray[np.int32],
    unknowns: NDArray[np.float64], releases: NDArray[np.float64], form: int,
) -> Any:  # fmt: skip
    """The core's description of a motion, given by its impacts or releases, in one of its forms."""
    system = (osc.xi, osc.mu, osc.restitution, r, load, clearance)
    return roomy(_core.find_motion, *system, cycles, sides, unknowns, releases, form)


def roomy(procedure: Any, *arguments: Any) -> Any:
    """The result of a procedure of the core, with space for all events of a motion with rest."""
    for capacity in REST_EVENTS:
        answer = with_stack(procedure, *arguments, capacity)
        if answer[-1] != MORE_EVENTS:
            break
    return answer


def described_motion(
    osc: Oscillator, r: float, clearance: float, load: float, answer: Any
) -> Motion:
    """A motion from the core's arrays for the symbols and events of a period."""
    n, cycles, sides, each, phases, impacts, scalars, multipliers, verdicts, *rest, status = answer
    raise_status(int(status))
    m, values, labels = rest
    table = None
    if m:
        table = event_table(values[:, :m].copy(), labels[:, :m]).copy()
        table["time"] -= table["time"][0]
        table.flags.writeable = False
    return motion_of_oscillator(
        osc, r, clearance, load, Pattern(letters_of(sides[:n]), int(cycles)),
        frozen(each[:n].copy()), phases[:n].copy(), impacts[:n].copy(order="F"), scalars, multipliers,
        verdicts, rest_events=table,
    )  # fmt: skip
