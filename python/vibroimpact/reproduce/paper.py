"""The parameters of the paper's captions, and its names of motions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import Oscillator

#: Oscillators of Figure 3 and Table 1, of Figure 4, of Figures 6 and 7, of Figure 8 (and 9, 10b).
MASRI = Oscillator(xi=0.005, mu=0.042, restitution=0.75)
SADEK = Oscillator(xi=0.004, mu=0.0484, restitution=0.6)
EQUAL = Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
UNEQUAL = Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
#: Figure 10b exchanges the names of the walls: it is the mirror image of Figure 8's.
DAMPER = Oscillator(xi=0.0114, mu=0.028, restitution=(0.61, 0.75))

#: The rig: natural frequency (Hz), and how long a motion had to last to count as stable (s).
NATURAL_FREQUENCY, HOLD = 19.87, 120.0


#: Colour of each kind of motion (Okabe and Ito's) and its name in a legend.
KINDS = {
    "2e": ("#0072B2", "2 equispaced"),
    "2u": ("#D55E00", "2 unequispaced"),
    "2": ("#D55E00", "2 impacts/cycle"),
    "3": ("#009E73", "3 impacts/cycle"),
    "4": ("#CC79A7", "4 impacts/cycle"),
    "5": ("#56B4E9", "5 impacts/cycle"),
    "rest": ("#E69F00", "accumulation and rest"),
}
#: Frequency ratios of the bars: 12 to 29 Hz.
RATIOS = (0.60, 0.65, 0.70, 0.75, 0.80, 0.85, 0.90, 0.94, 0.96, 0.98, 1.00, 1.02, 1.04,
          1.06, 1.10, 1.15, 1.20, 1.25, 1.30, 1.35, 1.40, 1.45)  # fmt: skip
#: F0/(dK) of the zones, in units of `scale`.
LOADS = (0.04, 3.5)


def scale(r: Any) -> Any:
    """Approximate dependence of F0/(dK) of the zones on r; it is lowest near r = 0.975."""
    return np.hypot(np.square(r) - 0.95, 0.04)


def ratios(low: float, high: float, resolution: float = 1.0) -> NDArray[np.float64]:
    """Frequency ratios of a figure: evenly spaced, denser near the minimum of the zones, and including those of
    the bars."""
    count = max(9, round(110 * resolution))
    near = np.geomspace(0.002, 0.2, count // 3)
    even, bars = np.linspace(low, high, count), np.array(RATIOS)
    joined = np.unique(np.round(np.concatenate([even, 0.975 - near, 0.975 + near, bars]), 6))
    inside: NDArray[np.float64] = joined[(joined >= low) & (joined <= high)]
    return inside


def kind_of(sides: str, cycles: int, phases: Any = None, *, alike: bool = False) -> str:
    """The name of a motion in the paper: impacts per cycle, and e or u for two impacts on equal walls.

    Motions over several cycles are called N/k, as in "N impacts/k cycles".

    Parameters
    ----------
    phases : sequence of two floats, optional
        Impact phases, to distinguish equispaced from unequispaced motions if the walls are equal (`alike`).
    """
    if "*" in sides:
        return "rest"
    if cycles != 1:
        return f"{len(sides)}/{cycles}"
    if len(sides) == 2 and alike:
        return "2e" if abs(phases[1] - phases[0] - math.pi) < 1e-3 else "2u"
    return str(len(sides))
