"""Figure 8a: zones of two and three impacts a cycle, unequal coefficients of restitution."""

from __future__ import annotations

from pathlib import Path

from . import canvas
from .figure9 import PANELS
from .paper import UNEQUAL, ratios
from .scan import Strip, pair_zone, traced_zone
from .sweeps import bars, read_sweeps, seeds
from .traced import compared, outline

#: The axis of F0/(d K).
LOADS = (0.006, 1.5)


def zones(folder: Path, resolution: float = 1.0) -> dict[str, list[Strip]]:
    """Zones of two and of three impacts, the latter traced from the motions at the ends of the simulated holds."""
    r = ratios(0.55, 1.5, resolution)
    threes = [x for x in seeds(read_sweeps(folder, "unequal"), UNEQUAL).items() if len(x[0]) == 3]
    plain = [motion for sides, motions in threes if "*" not in sides for motion in motions]
    return {
        "2": pair_zone(UNEQUAL, r, round(1600 * resolution)),
        "3": traced_zone(UNEQUAL, plain, r, max(60, round(300 * resolution))),
    }


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Draw figure8a.png and .svg, write figure8a.csv; True if both zones are there."""
    found = zones(folder, resolution)
    sweeps = read_sweeps(folder, "unequal")
    figure, ax = canvas.panels(height=4.0)
    for kind, strips in found.items():
        sides = {"2": "RL", "3": "RLL"}[kind]
        # extended to the edge of the axes, since the topmost strip is not scanned
        edges = (1 / LOADS[1], 1 / LOADS[0])
        traced = outline(UNEQUAL, sides, (0.55, 1.5), strips, clearance=edges)
        canvas.zone(ax, strips, kind, traced=traced)
        canvas.bars(ax, bars(sweeps, kind), kind)
        print(f"Figure 8a: {canvas.inside(sweeps, kind, strips)}; {compared(traced, strips)}")
    canvas.letters(ax, {name: PANELS[name][2:] for name in ("a", "b", "c")})
    canvas.axes_of_zones(ax)
    ax.set(xlim=(0.55, 1.5), ylim=LOADS)
    canvas.identify(ax, UNEQUAL)
    canvas.legend(ax, loc="lower right")
    canvas.save(figure, folder, "figure8a")
    canvas.table(folder, "figure8a", canvas.STRIP_HEADER, canvas.strip_rows(found))
    return bool(found["2"] and found["3"])
