"""The attractors of a point, as the core finds them, with their exact motions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import VibroimpactError
from ..model import Oscillator
from ..motion import Motion
from ..newton import exact
from ..trajectory import simulate
from .lyapunov import Lyapunov, lyapunov

if TYPE_CHECKING:
    from .basins import Basins

_Array = NDArray[np.float64]
#: Load cycles after which the core tells a largest Lyapunov exponent from 0, and those before it.
EXPONENT_CYCLES, EXPONENT_DISCARD = 4000, 500


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class BasinAttractor:
    """An attractor.

    Attributes
    ----------
    kind : str
        "periodic", "rest" (periodic, with accumulation and rest), "quasi-periodic", "chaotic", "no impacts",
        or "periodic?" where a simulation repeats itself but no stable exact motion was found.
    name : str
        Sides and load cycles, as "RL/1", or the kind; a number tells those of one name apart.
    motion : Motion or None
        The exact motion.
    state : dict
        A state on it.
    lyapunov : Lyapunov or None
        Exponents of what is not periodic.
    radius, contraction : float
        Of the largest neighbourhood that decides, in its own norm, and by what the derivative over a period
        contracts in that norm; 0 and 1 if there is none.
    growth : float
        Greatest modulus of a multiplier of what is periodic, as the simulation has it; largest exponent per load
        cycle of what is not; NaN of what is neither.
    """

    kind: str
    name: str
    motion: Motion | None
    state: dict[str, float]
    lyapunov: Lyapunov | None = None
    radius: float = 0.0
    contraction: float = 1.0
    growth: float = math.nan

    def __repr__(self) -> str:
        return f"<{self.kind} attractor {self.name}>"


def attractors_of(basins: Basins) -> list[BasinAttractor]:
    """The attractors that the core found, with the exact motion or the exponents of each."""
    osc, r, clearance, load = basins.osc, basins.r, basins.clearance, basins.load
    columns = basins._result.tables["attractors"].columns
    names = ("name", "kind", "cycles", "state", "radius", "contraction", "growth")
    found = []
    for name, kind, cycles, end, *balls in zip(
        *(columns[name].decoded().tolist() for name in names), strict=True
    ):
        motion, exponents, state = None, None, as_state(np.array(end), clearance)
        if kind in ("periodic", "rest"):
            motion = motion_at(osc, r, clearance, load, np.array(end), cycles)
        if kind in ("quasi-periodic", "chaotic"):
            exponents = lyapunov(osc, r, clearance, EXPONENT_CYCLES, state, load, EXPONENT_DISCARD)
        found.append(BasinAttractor(kind, name, motion, state, exponents, *balls))
    return found


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
