"""Exact motions by Newton's method, and the periodic part of a trajectory."""

from __future__ import annotations

import contextlib
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _core, checks
from .errors import ParameterError, ParameterTypeError, SingularError
from .events import event_table
from .model import Oscillator, Pattern
from .motion import Motion
from .solve import frozen, impact_restitution, periodic
from .states import TWO_PI
from .status import MORE_EVENTS, VERDICT, raise_status
from .trajectory import Trajectory

__all__ = ["exact"]

MOST_ITERATIONS = 50
#: Impacts and rests that a period of a motion with rest may have: most have few.
REST_EVENTS = (200, 20_000)
#: Load phase within which one period and the next are the same.
SETTLED = 1e-9
#: How much better a longer period must repeat to be tried after a shorter one.
NEARER = 0.3


class Period(NamedTuple):
    """One period of a trajectory: its pattern and the events that start its symbols."""

    pattern: Pattern
    events: NDArray[Any]
    symbols: NDArray[Any]
    mismatch: float


def exact(
    osc: Oscillator,
    r: float,
    clearance: float,
    guess: Motion | Trajectory | tuple[Any, Pattern],
    load: float = 1.0,
) -> Motion:
    """The exact periodic motion near a guess, by Newton's method with the analytic derivative.

    Without rest the unknowns are the N positions and N phases of the impacts. With accumulation and rest they are
    the phase and velocity at a release, a fixed point of the return map there.

    Parameters
    ----------
    osc, r, clearance, load
        As in `simulate`.
    guess : Motion, Trajectory or (phases, Pattern)
        A motion at other parameters; a trajectory whose last cycles are about periodic; or impact phases, for
        which the linear equations of 1983 give the rest of the guess.

    Returns
    -------
    Motion
        `admissible` is False if the equations are solved by a motion that would pass through a wall.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed, or the trajectory is not about periodic.
    SingularError
        If the iteration does not converge.

    Examples
    --------
    The motion that belongs beside the third column of Table 1, at d K/F0 = 37 exactly:

    >>> import math, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motion = vi.exact(osc, 0.94, 37.0, ([0, 1.37 * math.pi], vi.Pattern("RL")))
    >>> round(float(motion.phases[1]) / math.pi, 6), motion.stable
    (1.382026, True)

    From a simulation, with rest on the left wall:

    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    >>> vi.exact(osc, 0.9, 6.0, vi.simulate(osc, 0.9, 6.0, cycles=8, discard=200))
    <Motion RL*/1 at r = 0.9, d K/F0 = 6: consistent, admissible, stable (max|lambda| = 0.9189, complex)>
    """
    checks.instance(osc, "osc", Oscillator)
    r = checks.frequency_ratio(r, osc.xi)
    clearance = checks.number(clearance, "clearance")
    load = checks.number(load, "load")
    each = given = None
    if isinstance(guess, Motion):
        pattern = guess.pattern
        if pattern.has_rest:
            return rest_motion(osc, r, clearance, load, pattern.cycles, guess.events)
        each = None if guess.osc.restitution != osc.restitution else guess.restitution
        scale = clearance / guess.clearance
        if (
            guess.kind == "periodic"
            and (guess.osc, guess.r) == (osc, r)
            and guess.precision == "double"
        ):
            given = guess.phases
        x, theta = scale * guess.X, guess.phases + guess.tau
    elif isinstance(guess, Trajectory):
        return from_simulation(osc, r, clearance, load, guess)
    elif isinstance(guess, tuple) and len(guess) == 2 and isinstance(guess[1], Pattern):
        linear = periodic(osc, r, guess[0], guess[1])
        pattern = linear.pattern
        given = linear.phases
        x, theta = linear.X * (clearance / linear.clearance), linear.phases + linear.tau
    else:
        raise ParameterTypeError(
            f"guess = {guess!r}: must be a Motion, a Trajectory or a tuple (phases, Pattern)"
        )
    return newton(osc, r, clearance, load, pattern, x, theta, each, given)


def from_simulation(
    osc: Oscillator, r: float, clearance: float, load: float, run: Trajectory
) -> Motion:
    """The exact motion that a trajectory ends with.

    After a period doubling the shorter period nearly repeats too, and Newton's method finds its unstable motion:
    a longer period that repeats better is tried first, and taken unless it is the shorter one repeated.
    """
    period = last_period(run)
    if period.mismatch < SETTLED:
        return from_period(osc, r, clearance, load, run, period)
    try:
        longer = last_period(run, tolerance=NEARER * period.mismatch)
    except ParameterError:
        return from_period(osc, r, clearance, load, run, period)
    with contextlib.suppress(SingularError):
        motion = from_period(osc, r, clearance, load, run, longer)
        n = len(period.pattern)
        repeated = np.roll(motion.X, -n) - motion.X
        if np.abs(repeated).max() > 1e-6 * max(1.0, clearance):
            return motion
    return from_period(osc, r, clearance, load, run, period)


def from_period(
    osc: Oscillator, r: float, clearance: float, load: float, run: Trajectory, period: Period
) -> Motion:
    """The exact motion near one period of a trajectory."""
    if period.pattern.has_rest:
        return rest_motion(osc, r, clearance, load, period.pattern.cycles, period.events)
    start = period.symbols[0]
    phases = np.mod(period.symbols["phase"] - start["phase"], TWO_PI)
    whole = np.rint((period.symbols["time"] - start["time"]) * run.r - phases)
    phases = phases + TWO_PI * np.rint(whole / TWO_PI)
    x = period.symbols["x"] * (clearance / run.clearance)
    theta = phases + start["phase"] - lag(osc, r)
    return newton(osc, r, clearance, load, period.pattern, x, theta, None, None)


def lag(osc: Oscillator, r: float) -> float:
    """Phase by which the motion without impacts lags the load."""
    return math.atan2(2 * osc.xi * r, (1 - r) * (1 + r))


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

    `given` are phases from which these are a solution of the linear equations, for the record.
    """
    each = impact_restitution(osc, pattern, None) if restitution is None else restitution
    phases, impacts, scalars, multipliers, verdicts, status, _ = _core.exact(
        osc.xi, osc.mu, osc.restitution, r, load, clearance, pattern.cycles, pattern.signs, each,
        x, theta,
        MOST_ITERATIONS,
    )  # fmt: skip
    raise_status(int(status))
    return impact_motion(
        osc, r, clearance, load, pattern, each, phases, impacts, scalars, multipliers, verdicts, given
    )  # fmt: skip


def impact_motion(
    osc: Oscillator, r: float, clearance: float, load: float, pattern: Pattern,
    restitution: NDArray[np.float64], phases: NDArray[np.float64], impacts: NDArray[np.float64],
    scalars: NDArray[np.float64], multipliers: NDArray[np.complex128], verdicts: NDArray[np.int32],
    given: NDArray[np.float64] | None = None, rest_events: NDArray[Any] | None = None,
) -> Motion:  # fmt: skip
    """A motion from what the core tells of it; `given` as in `newton`."""
    impacts.flags.writeable = False
    multipliers.flags.writeable = False
    _, amplitude, tau, residual, x_min, x_max = scalars.tolist()
    consistent, admissible, stable = verdicts.tolist()
    return Motion(
        osc, r, clearance, pattern, restitution, frozen(phases),
        impacts[:, 0], impacts[:, 1], impacts[:, 2], impacts[:, 3], impacts[:, 4], impacts[:, 5],
        amplitude, tau, residual, multipliers,
        VERDICT[consistent], VERDICT[admissible], VERDICT[stable], x_min, x_max, load=load,
        guess=given, rest_events=rest_events,
    )  # fmt: skip


def rest_motion(
    osc: Oscillator, r: float, clearance: float, load: float, cycles: int, events: NDArray[Any]
) -> Motion:
    """Newton's method on the return map from the last release among some events."""
    release = events[events["kind"] == "release"][-1]
    side = 1 if release["side"] == "R" else -1
    guess = np.array([release["phase"], release["x_dot_after"]])
    return release_motion(osc, r, clearance, load, cycles, side, guess)


def release_motion(
    osc: Oscillator, r: float, clearance: float, load: float, cycles: int, side: int,
    guess: NDArray[np.float64],
) -> Motion:  # fmt: skip
    """Newton's method on the return map from a guess of (phase, v) at a release on a wall."""
    for capacity in REST_EVENTS:
        answer = _core.rest_motion(
            osc.xi, osc.mu, osc.restitution, r, load, clearance, side, cycles, guess, capacity
        )
        if answer[-1] != MORE_EVENTS:
            break
    n, sides, each, phases, impacts, scalars, multipliers, verdicts, m, values, labels, status = (
        answer
    )
    raise_status(int(status))
    table = event_table(values[:, :m].copy(), labels[:, :m]).copy()
    table["time"] -= table["time"][0]
    table.flags.writeable = False
    symbols = (f"{'RL'[one < 0]}{'*' * (abs(one) - 1)}" for one in sides[:n].tolist())
    return impact_motion(
        osc, r, clearance, load, Pattern("".join(symbols), cycles), frozen(each[:n].copy()),
        phases[:n].copy(), impacts[:n].copy(order="F"), scalars, multipliers, verdicts,
        rest_events=table,
    )  # fmt: skip


def letters_of(events: NDArray[Any]) -> tuple[list[str], NDArray[Any]]:
    """The symbols of some events and the event that starts each.

    A run of impacts on one wall that ends in rest is one starred symbol.
    """
    symbols: list[str] = []
    first: list[int] = []
    run = 0
    for i, (kind, side) in enumerate(
        zip(events["kind"].tolist(), events["side"].tolist(), strict=True)
    ):
        if kind == "stick":
            start = first[-run] if run else i
            del symbols[len(symbols) - run :], first[len(first) - run :]
            symbols.append(side + "*")
            first.append(start)
            run = 0
        elif kind == "impact":
            run = run + 1 if symbols and symbols[-1] == side and run else 1
            symbols.append(side)
            first.append(i)
        else:
            run = 0
    return symbols, events[first]


def last_period(trajectory: Trajectory, most_cycles: int = 16, tolerance: float = 0.05) -> Period:
    """The shortest period, in load cycles, with which a trajectory ends.

    The last k cycles are compared with the k before; the pattern has to be the same and the phases within the
    tolerance.
    """
    events = trajectory.events
    r = trajectory.r
    releases = np.flatnonzero(events["kind"] == "release")
    end = len(events) if not releases.size else int(releases[-1]) + 1
    last = float(events["time"][end - 1]) if end else trajectory.final_state["t"]
    # a thousandth of a cycle: the event one period before the last belongs to the window before
    border = 1e-3 * TWO_PI / r
    for cycles in range(1, most_cycles + 1):
        span = TWO_PI * cycles / r
        middle, begin = last - span + border, last - 2 * span + border
        if begin < trajectory.initial_state["t"]:
            break
        i, j = np.searchsorted(events["time"][:end], [begin, middle])
        before, after = letters_of(events[i:j]), letters_of(events[j:end])
        if not after[0] or before[0] != after[0]:
            continue
        shift = (after[1]["time"] - before[1]["time"] - span) * r
        mismatch = float(np.abs(shift).max())
        if mismatch < tolerance and len(set("".join(after[0])) & {"R", "L"}) == 2:
            return Period(Pattern("".join(after[0]), cycles), events[j:end], after[1], mismatch)
    raise ParameterError(
        f"guess = {trajectory!r}: must end about periodic; its last cycles do not repeat within "
        f"{most_cycles} load cycles. Simulate longer (discard more), or give phases and a pattern"
    )
