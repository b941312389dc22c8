"""Two impacts with given phases at constant r, stability ignored: the quantities of Figure 4."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import Pattern, periodic_batch
from . import canvas
from .paper import SADEK

#: Frequency ratios of the curves; the paper's text discusses 0.999.
CURVES = (0.90, 0.95, 0.98, 0.999, 1.02, 1.05, 1.10)
#: Ratios of durations of the points B and B' (and A, A') drawn on the curve r = 0.999.
POINTS = (0.40, 0.85)


class Curve(NamedTuple):
    """Motions at one r: ratio of the first duration to the second, d K/F0, sin(tau), admissible or not."""

    r: float
    ratio: NDArray[np.float64]
    clearance: NDArray[np.float64]
    sin_tau: NDArray[np.float64]
    admissible: NDArray[np.bool_]


def curve(r: float, ratio: NDArray[np.float64]) -> Curve:
    """The motions RL whose first duration (right wall to left) is `ratio` times the second."""
    second = 2 * np.pi * ratio / (1 + ratio)
    found = periodic_batch(SADEK, r, [np.zeros_like(second), second], Pattern("RL"))
    return Curve(r, ratio, found.clearance, np.sin(found.tau), found.admissible == 1)


def curves(resolution: float = 1.0) -> list[Curve]:
    """All curves of Figure 4."""
    ratio = np.linspace(0.02, 0.999, max(40, round(800 * resolution)))
    return [curve(r, ratio) for r in CURVES]


def draw(ax: Any, found: list[Curve], column: str) -> None:
    """Draw a column of the curves against the ratio of durations; thin where a motion passes through a wall."""
    for one, (colour, _, mark) in zip(found, canvas.LOOKS, strict=True):
        values = getattr(one, column)
        ax.plot(values, one.ratio, color=colour, lw=0.5, ls=(0, (2, 2)))
        # the marks at the upper end distinguish the curves without colour
        ax.plot(np.where(one.admissible, values, np.nan), one.ratio, color=colour, lw=1.2, marker=mark,
                ms=4, mew=0, markevery=[-1], clip_on=False, label=f"$r$ = {one.r:g}")  # fmt: skip
    ax.set_ylabel("ratio of durations")
    ax.set_ylim(0, 1)
    canvas.identify(ax, SADEK)


def mark(ax: Any, column: str, names: tuple[str, str], beside: float = 5.0) -> None:
    """Mark the two points on r = 0.999 between which only the load changes, their letters `beside` them."""
    points = curve(0.999, np.array(POINTS))
    for value, ratio, name in zip(getattr(points, column), points.ratio, names, strict=True):
        ax.plot(value, ratio, "ko", ms=3, zorder=5)
        ax.annotate(name, (value, ratio), textcoords="offset points", xytext=(beside, -3), fontsize=8,
                    ha="left" if beside > 0 else "right")  # fmt: skip
