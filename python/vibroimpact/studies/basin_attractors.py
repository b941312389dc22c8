"""The attractors at a point, as the core finds them, with their exact motions."""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import SingularError, VibroimpactError
from ..model import Oscillator
from ..motion import Motion
from ..newton import attractor_at_end
from ..trajectory import simulate
from .lyapunov import Lyapunov, lyapunov

if TYPE_CHECKING:
    from .basins import Basins

_Array = NDArray[np.float64]
#: Load cycles from which exponents are computed, tried in turn: impacts may be rare. Load cycles before them.
EXPONENT_CYCLES, EXPONENT_DISCARD = (4000, 40_000, 400_000), 500


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class BasinAttractor:
    """An attractor.

    Attributes
    ----------
    kind : str
        "periodic" or "rest" (periodic, with accumulation and rest): Newton's method confirms a stable motion that
        states reach; "chaotic": the largest exponent is positive by its error; "quasi-periodic": it is zero by
        its error, and no stable motion is found nearby; "no impacts"; or "periodic?" where a simulation repeats
        itself to rounding for long but no stable exact motion was found.
    name : str
        Sides and load cycles, as "RL/1", or the kind; equal names get a number.
    motion : Motion or None
        The exact motion.
    state : dict
        A state on it.
    lyapunov : Lyapunov or None
        Exponents of an attractor that is not periodic.
    radius, contraction : float
        Radius of the largest neighbourhood used to decide, in its own norm, and the contraction of the
        derivative over a period in that norm; 0 and 1 if there is none.
    growth : float
        Of a periodic attractor the largest modulus of a multiplier, from the simulation; of another one the
        largest exponent per load cycle; NaN if neither exists.
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
            exponents = exponents_at(osc, r, clearance, load, state)
        found.append(BasinAttractor(kind, name, motion, state, exponents, *balls))
    return found


def exponents_at(
    osc: Oscillator, r: float, clearance: float, load: float, state: dict[str, float]
) -> Lyapunov | None:
    """The exponents of a motion that is not periodic, or None."""
    for cycles in EXPONENT_CYCLES:
        with contextlib.suppress(SingularError):
            return lyapunov(osc, r, clearance, cycles, state, load, EXPONENT_DISCARD)
    return None


def as_state(values: _Array, clearance: float) -> dict[str, float]:
    """A state of the core as a mapping, with the free mass between the walls within the allowed rounding."""
    t, x, x_dot, z, z_dot = values.tolist()
    half = 0.5 * clearance
    if abs(z - x) > half * (1 + 1e-9):
        z = x + math.copysign(half, z - x)
    return {"t": t, "x": x, "x_dot": x_dot, "z": z, "z_dot": z_dot}


def motion_at(
    osc: Oscillator, r: float, clearance: float, load: float, end: _Array, cycles: int
) -> Motion | None:
    """The exact stable motion with a period of some load cycles on which a final state is, or None."""
    # the state may still approach the motion
    for length in (2 * cycles + 3, 20 * cycles):
        run = simulate(osc, r, clearance, length, state=as_state(end, clearance), load=load)
        with contextlib.suppress(VibroimpactError):
            found = attractor_at_end(run, cycles)
            if found is not None:
                return found
    return None
