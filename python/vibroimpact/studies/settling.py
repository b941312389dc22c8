"""What simulations settle on: initial states, chains of parameters, and exact motions of the ends."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import _core, checks
from ..errors import VibroimpactError
from ..model import Oscillator
from ..motion import Motion
from ..newton import exact
from ..trajectory import NEEDED, _checked, simulate

_Array = NDArray[np.float64]
#: The core's parameters, in its order.
PARAMETERS = ("r", "clearance", "xi", "mu", "R1", "R2")


@dataclass(frozen=True, eq=False)
class Settled:
    """Ends of chains of simulations: arrays (..., links, chains).

    Attributes
    ----------
    values : ndarray (7, room, links, chains)
        time, phase, x, x_dot_before, x_dot_after, z_dot_before, z_dot_after of the kept impacts.
    sides : ndarray (room, links, chains)
    found : ndarray (links, chains)
        How many impacts were kept.
    cycles, letters, impacts, rests : ndarray (links, chains)
        Load cycles of the period (0: none was seen), and what is in it; letters count an accumulation as
        one. Without a period, impacts and rests of all kept cycles.
    x_min, x_max : ndarray (links, chains)
        Extreme positions over the period, or over the kept cycles.
    ends : ndarray (5, links, chains)
        t, x, x_dot, z, z_dot.
    status : ndarray (links, chains)
    """

    values: _Array
    sides: NDArray[np.int32]
    found: NDArray[np.int32]
    cycles: NDArray[np.int32]
    letters: NDArray[np.int32]
    impacts: NDArray[np.int32]
    rests: NDArray[np.int32]
    x_min: _Array
    x_max: _Array
    ends: _Array
    status: NDArray[np.int32]


def settle_chains(
    parameters: _Array, load: float, starts: _Array, settling: int, keep: int, room: int, threads: int
) -> Settled:  # fmt: skip
    """Simulate chains: `parameters` (6, links, chains) from `starts` (5, chains)."""
    values, labels, found, periods, extremes, ends, status = _core.settle_chains(
        np.asfortranarray(parameters),
        load,
        np.asfortranarray(starts),
        settling,
        keep,
        0.0,
        room,
        threads,
    )
    cycles, letters, impacts, rests = periods
    return Settled(
        values,
        labels[1],
        found,
        cycles,
        letters,
        impacts,
        rests,
        extremes[0],
        extremes[1],
        ends,
        status,
    )


def thread_count(threads: int | None) -> int:
    """Threads that were asked for, or one for each processor."""
    return checks.integer(os.cpu_count() or 1 if threads is None else threads, "threads", 1, 1024)


def column(osc: Oscillator, r: float, clearance: float) -> _Array:
    """The six parameters of the core."""
    return np.array([r, clearance, osc.xi, osc.mu, *osc.restitution])


def scale(osc: Oscillator, r: float, clearance: float, load: float) -> float:
    """A length that initial states are spread over: that of the motion without impacts, within limits."""
    return float(_core.spread_scale(osc.xi, r, load, clearance))


def one_state(state: Mapping[str, float], clearance: float) -> _Array:
    """t, x, x', z, z' of a state given by the caller."""
    given = _checked(state, clearance)
    return np.array([given[name] for name in NEEDED])


def as_state(values: _Array, clearance: float) -> dict[str, float]:
    """A state of the core as a mapping, within the walls."""
    t, x, x_dot, z, z_dot = values.tolist()
    half = 0.5 * clearance
    return {"t": t, "x": x, "x_dot": x_dot, "z": x + min(max(z - x, -half), half), "z_dot": z_dot}


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
