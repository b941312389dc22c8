"""What simulations settle on: initial states, and exact motions of the ends."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from .. import checks
from ..errors import VibroimpactError
from ..model import Oscillator
from ..motion import Motion
from ..newton import exact
from ..states import NEEDED, checked_state
from ..trajectory import simulate

_Array = NDArray[np.float64]
#: The core's parameters, in its order.
PARAMETERS = ("r", "clearance", "xi", "mu", "R1", "R2")


def thread_count(threads: int | None) -> int:
    """Threads that were asked for, or one for each processor."""
    return checks.integer(os.cpu_count() or 1 if threads is None else threads, "threads", 1, 1024)


def one_state(state: Mapping[str, float], clearance: float) -> _Array:
    """t, x, x', z, z' of a state given by the caller."""
    given = checked_state(state, clearance)
    return np.array([given[name] for name in NEEDED])


def as_state(values: _Array, clearance: float) -> dict[str, float]:
    """A state of the core as a mapping, between the walls but for what rounding is allowed."""
    t, x, x_dot, z, z_dot = values.tolist()
    half = 0.5 * clearance
    if abs(z - x) > half * (1 + 1e-9):
        z = x + math.copysign(half, z - x)
    return {"t": t, "x": x, "x_dot": x_dot, "z": z, "z_dot": z_dot}


def motion_at(
    osc: Oscillator, r: float, clearance: float, load: float, end: _Array, cycles: int
) -> Motion | None:
    """The exact stable motion of a period of some load cycles that an end is on, or None."""
    run = simulate(osc, r, clearance, 2 * cycles + 3, state=as_state(end, clearance), load=load)
    try:
        motion = exact(osc, r, clearance, run, load=load)
    except VibroimpactError:
        return None
    if motion.pattern.cycles != cycles or not motion.stable or not motion.admissible:
        return None
    events = run.events[run.events["time"] >= run.final_state["t"] - 2 * math.pi * cycles / r]
    size = min(len(events), len(motion.events))
    near = np.sort(events["x"])[:size] - np.sort(motion.events["x"])[:size]
    return motion if np.abs(near).max(initial=0.0) < 1e-2 * clearance else None
