"""Figure 3: zones of two equispaced, two unequispaced and three impacts a cycle, dK/F0 over r."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .. import Motion, find, standard_motion
from . import canvas
from .paper import MASRI, ratios
from .scan import Strip, equispaced_zone, pair_zone, traced_zone
from .traced import compared, outline

#: Frequency ratios at which motions with three impacts are searched, at d K/F0 just below the zone of two.
LOOK = ((0.82, 7.0), (0.88, 10.0), (0.93, 23.0), (1.02, 20.0), (1.06, 10.0), (1.15, 4.5))


def zones(resolution: float = 1.0) -> dict[str, list[Strip]]:
    """The three zones, by kind."""
    r = ratios(0.8, 1.2, resolution)
    seeds: list[Motion] = []
    for at, clearance in LOOK:
        found = find(MASRI, at, clearance, max_impacts=3, max_cycles=1, guesses=24, states=6)
        seeds += [m for m in map(standard_motion, found) if m.stable and m.pattern.sides == "RRL"]
    return {
        "2e": equispaced_zone(MASRI, r, round(300 * resolution)),
        "2u": pair_zone(MASRI, r, round(1600 * resolution)),
        "3": traced_zone(MASRI, seeds, r, round(300 * resolution)),
    }


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Draw figure3.png and .svg, write figure3.csv; True if all three zones are there."""
    found = zones(resolution)
    figure, ax = canvas.panels(height=4.2)
    for kind, strips in found.items():
        sides = "RRL" if kind == "3" else "RL"
        traced = outline(MASRI, sides, (0.8, 1.2), strips, {"2e": True, "2u": False}.get(kind))
        canvas.zone(ax, strips, kind, inverse=False, traced=traced)
        lowest = min(float(np.min(strip.low)) for strip in strips)
        highest = max(float(np.max(strip.high)) for strip in strips)
        print(
            f"Figure 3: zone {kind}: dK/F0 {lowest:.3g} to {highest:.4g}; {compared(traced, strips)}"
        )
    ax.axhline(37, color="0.4", lw=0.7, ls=(0, (5, 3)))
    ax.annotate("$d = 37\\,F_0/K$ (Masri)", (0.803, 38), fontsize=6.5, color="0.3")
    ax.plot(0.94, 37, "k+", ms=6)
    ax.annotate("Table 1", (0.937, 37.6), fontsize=6.5, ha="right", va="bottom")
    canvas.axes_of_zones(ax, inverse=False)
    ax.set(xlim=(0.8, 1.2), ylim=(2, 150))
    canvas.identify(ax, MASRI)
    canvas.legend(ax, loc="upper right")
    canvas.save(figure, folder, "figure3")
    canvas.table(folder, "figure3", canvas.STRIP_HEADER, canvas.strip_rows(found))
    return all(found.values())
