"""Performance figures of many systems on their attractors in one call, as needed for a design."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..base import checks
from ..base.interrupt import new_counters, stoppable
from . import door

#: Rows of the parameters of `perform`.
PARAMETERS = ("r", "clearance", "xi", "mu", "R1", "R2")
#: Rows of its figures.
FIGURES = (
    "displacement", "rms", "acceleration", "force", "speed", "multiplier", "least_speed", "least_gap",
    "amplitude",
)  # fmt: skip
#: Figures that can be limited, and the power of the load amplitude with which they grow.
LIMITED = {
    "displacement": 1, "rms": 1, "acceleration": 1, "force": 1, "speed": 1, "multiplier": 0, "least_speed": 1,
    "least_gap": 1,
}  # fmt: skip
#: Figures that must be above their limits.
LEAST = ("least_speed", "least_gap")


@dataclass(frozen=True, eq=False, slots=True)
class Performance:
    """Performance figures of many systems, each on the attractor that one initial state reaches.

    Lengths are in F0/K and times in 1/omega. Forces and accelerations are those between impacts and just before
    and after them, without the impulses.

    Attributes
    ----------
    displacement, rms, acceleration : ndarray (n,)
        Greatest |x|, root mean square of x, greatest |x''| of the primary mass.
    force : ndarray (n,)
        Greatest |x + 2 xi x'|: the force on the base by spring and dashpot.
    speed : ndarray (n,)
        Greatest approach speed of an impact.
    multiplier : ndarray (n,)
        Greatest modulus of the multipliers; NaN without a period or without impacts.
    least_speed, least_gap : ndarray (n,)
        Distances to boundaries: least approach speed of an impact, and least distance to a wall that the free mass
        approaches without an impact. Both are inf if there is no such impact or approach, and 0 for motions with
        rest.
    amplitude : ndarray (n,)
        Amplitude A of the motion without impacts.
    states : ndarray (5, n)
        t, x, x', z, z' of a state on the attractor.
    cycles, impacts : ndarray (n,) of int
        Load cycles of the period (0: none was found), and the number of impacts in it or in the cycles examined.
    status : ndarray (n,) of int
        0 if done; see `status_text` for other values, for which the figures are NaN.
    """

    displacement: NDArray[np.float64]
    rms: NDArray[np.float64]
    acceleration: NDArray[np.float64]
    force: NDArray[np.float64]
    speed: NDArray[np.float64]
    multiplier: NDArray[np.float64]
    least_speed: NDArray[np.float64]
    least_gap: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    states: NDArray[np.float64]
    cycles: NDArray[np.int32]
    impacts: NDArray[np.int32]
    status: NDArray[np.int32]


def _marks(wanted: tuple[str, ...]) -> NDArray[np.int32]:
    """The requested figures, as flags for the core."""
    return np.array([name in wanted for name in FIGURES], dtype=np.int32)


def perform(
    parameters: NDArray[np.float64], places: NDArray[np.float64], settling: int = 400, keep: int = 64,
    max_events: int = 1_000_000, threads: int | None = None, progress: door.Progress | None = None,
    note: str = "", wanted: Iterable[str] = FIGURES,
) -> Performance:  # fmt: skip
    """The performance figures of many systems.

    Parameters
    ----------
    parameters : ndarray (6, n)
        r, clearance, xi, mu, R1, R2, all within their ranges.
    places : ndarray (4, n)
        Initial states in the box of the random states of `basins`, from -1 to 1.
    settling, keep : int
        Load cycles after which a simulation without a period counts as settled, and the number of load cycles
        examined after that.
    max_events : int
        Events after which a simulation is abandoned.
    threads : int, optional
        Default: one for each processor. The result does not depend on it.
    progress : callable, optional
        As for the studies; it receives `note` as its text.
    wanted : iterable of str
        The figures to compute, keys of `FIGURES`; the other figures are NaN.

    Raises
    ------
    KeyboardInterrupt
        After Ctrl-C.
    """
    count = os.cpu_count() or 1 if threads is None else threads
    (found, states, counts, status), complete = stoppable(
        _core.perform, np.asfortranarray(parameters), np.asfortranarray(places), settling, keep, max_events,
        checks.integer(count, "threads", 1, 1024), _marks(tuple(wanted)),
        counters=new_counters(), progress=progress, note=note,
    )  # fmt: skip
    if not complete:
        raise KeyboardInterrupt
    figures = dict(zip(FIGURES, found, strict=True))
    return Performance(**figures, states=states, cycles=counts[0], impacts=counts[1], status=status)
