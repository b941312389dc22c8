"""The period with which a trajectory ends."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _core, checks
from .errors import ParameterError
from .events import event_arrays
from .model import Pattern

if TYPE_CHECKING:
    from .trajectory import Trajectory

__all__ = ["Period"]

_Array = NDArray[np.float64]

#: Longest period in load cycles, and largest difference of its phases from the period before.
MOST_CYCLES, TOLERANCE = 16, 0.05


class Period(NamedTuple):
    """The period with which a trajectory ends.

    Attributes
    ----------
    pattern : Pattern
    events : structured ndarray
        The event that begins each letter of the pattern, with the columns of `Trajectory.events`: an impact, the
        first one of an accumulation.
    mismatch : float
        Largest difference of their phases from those of the period before (radians).
    """

    pattern: Pattern
    events: NDArray[Any]
    mismatch: float


def last_period(
    trajectory: Trajectory, most_cycles: int = MOST_CYCLES, tolerance: float = TOLERANCE
) -> Period:
    """The shortest period with which a trajectory ends; see `Trajectory.period`."""
    osc, r = trajectory.osc, trajectory.r
    most_cycles = checks.integer(most_cycles, "most_cycles", 1, 1000)
    end = end_of(trajectory, most_cycles, tolerance)
    cycles, n, symbols, first, mismatch, *_ = _core.end_of_trajectory(
        osc.xi, osc.mu, osc.restitution, r, trajectory.load, trajectory.clearance, *end, 0, 1
    )
    if not cycles:
        raise not_periodic(trajectory, most_cycles)
    events = trajectory.events[len(trajectory.events) - len(first) + first[:n] - 1]
    return Period(Pattern(letters_of(symbols[:n]), cycles), events, mismatch)


def end_of(
    trajectory: Trajectory, most_cycles: int = MOST_CYCLES, tolerance: float = TOLERANCE
) -> tuple[_Array, _Array, NDArray[np.int32], int, float]:
    """The end of a trajectory as the core takes it, with what a period is."""
    events, r = trajectory.events, trajectory.r
    # two periods, and as many cycles after the last release
    begin = trajectory.final_state["t"] - (3 * most_cycles + 1) * 2 * math.pi / r
    begin = max(begin, trajectory.initial_state["t"])
    values, labels = event_arrays(events[np.searchsorted(events["time"], begin) :])
    if not labels.size:
        raise without_impacts(trajectory, begin)
    of_simulation = np.array([r, trajectory.load, trajectory.clearance, begin])
    return of_simulation, values, labels, most_cycles, tolerance


def letters_of(symbols: NDArray[np.int32]) -> str:
    """The letters of the core's symbols: 1 and -1 for an impact, 2 and -2 for accumulation and rest."""
    return "".join(f"{'RL'[one < 0]}{'*' * (abs(one) - 1)}" for one in symbols.tolist())


def without_impacts(trajectory: Trajectory, begin: float) -> ParameterError:
    """The error for a trajectory that has no impacts from some time on."""
    osc, r, half = trajectory.osc, trajectory.r, 0.5 * trajectory.clearance
    when = f"since t = {begin:.6g}" if len(trajectory.events) else "in it"
    # the steady amplitude of the primary mass alone; at resonance without damping it is unbounded
    squared = (1 - r * r) ** 2 + (2 * osc.xi * r) ** 2
    amplitude = trajectory.load / math.sqrt(squared) if squared > 0 else math.inf
    if amplitude < half:
        reason = (
            f"Without impacts |X| settles to A = {amplitude:.6g}, below D/2 = {half:.6g}, and a free mass at rest "
            "in the middle is never reached. Start from another state, as state=dict(t=0, x=0, x_dot=0, z=0, "
            "z_dot=v) with a velocity v"
        )
    else:
        reason = (
            f"|X| grows to A = {amplitude:.6g}, above D/2 = {half:.6g}: simulate longer (discard more), or start "
            "from another state"
        )
    return ParameterError(
        f"{trajectory!r}: must have impacts at its end; no impact happened {when}. {reason}"
    )


def not_periodic(trajectory: Trajectory, most_cycles: int = MOST_CYCLES) -> ParameterError:
    """The error for a trajectory that does not end about periodic."""
    return ParameterError(
        f"{trajectory!r}: must end about periodic; its last cycles do not repeat within {most_cycles} load "
        f"cycles. Simulate longer (discard more)"
    )
