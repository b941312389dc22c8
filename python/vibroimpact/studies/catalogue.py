"""The attractors of a point, as the core finds them, with their exact motions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..interrupt import new_tally, stoppable
from ..model import Oscillator
from ..motion import Motion
from .lyapunov import Lyapunov, lyapunov
from .settling import as_state, motion_at

_Array = NDArray[np.float64]
#: What the core calls the kinds and the letters of an attractor.
KINDS = ("", "periodic", "rest", "quasi-periodic", "chaotic", "no impacts", "periodic?")
SIDES = {1: "R", -1: "L", 2: "R*", -2: "L*"}
#: Attractors and letters of each that there is room for: the core looks for no more.
MOST, LETTERS = 1000, 2048
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


def find_attractors(
    osc: Oscillator, r: float, clearance: float, load: float, starts: _Array, cycles: int,
    probes: int, max_cycles: int, threads: int, progress: Callable[[float, str], None] | None = None,
) -> tuple[list[BasinAttractor], NDArray[np.int32], int, bool]:  # fmt: skip
    """The attractors by falling share, that of each state (5, m) (-1: none), and the events simulated.

    And whether all were come to: Ctrl-C stops it.
    """
    (labels, events, n, kinds, letters, states, balls), complete = stoppable(
        _core.basins, MOST, LETTERS, osc.xi, osc.mu, osc.restitution, r, load, clearance, starts, cycles,
        probes, max_cycles, threads, tally=new_tally(), progress=progress, note="basins",
    )  # fmt: skip
    if n == 0 and not complete:
        raise KeyboardInterrupt
    found = []
    for j in range(n):
        kind, (_, k, size) = KINDS[kinds[0, j]], kinds[:, j].tolist()
        name = {"no impacts": kind, "periodic?": f"{size}/{k}?"}.get(kind, kind)
        motion, exponents, state = None, None, as_state(states[:, j], clearance)
        if kind in ("periodic", "rest"):
            name = "".join(SIDES[letter] for letter in letters[:size, j].tolist()) + f"/{k}"
            motion = motion_at(osc, r, clearance, load, states[:, j], k)
        if kind in ("quasi-periodic", "chaotic"):
            exponents = lyapunov(
                osc, r, clearance, EXPONENT_CYCLES, state, load, EXPONENT_DISCARD, threads=threads
            )
        radius, contraction, growth = balls[:, j].tolist()
        if kind in ("no impacts", "periodic?"):
            growth = math.nan
        found.append(
            BasinAttractor(kind, name, motion, state, exponents, radius, contraction, growth)
        )
    names = [item.name for item in found]
    numbered = [
        replace(item, name=f"{item.name} ({names[: i + 1].count(item.name)})")
        if names.count(item.name) > 1 else item
        for i, item in enumerate(found)
    ]  # fmt: skip
    return numbered, labels - np.int32(1), round(events), complete
