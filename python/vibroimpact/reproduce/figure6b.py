"""Figure 6b: the zone of two unequispaced impacts a cycle, equal coefficients of restitution."""

from __future__ import annotations

from pathlib import Path

from . import canvas
from .paper import EQUAL, ratios
from .scan import pair_zone
from .sweeps import bars, read_sweeps
from .traced import compared, outline


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Draw figure6b.png and .svg, write figure6b.csv; True if the zone is there."""
    found = pair_zone(EQUAL, ratios(0.55, 1.5, resolution), round(1200 * resolution))
    sweeps = read_sweeps(folder, "equal")
    figure, ax = canvas.panels()
    traced = outline(EQUAL, "RL", (0.55, 1.5), found, symmetric=False)
    canvas.zone(ax, found, "2u", "2 unequispaced, computed", traced=traced)
    canvas.bars(ax, bars(sweeps, "2u"), "2u")
    canvas.axes_of_zones(ax)
    ax.set(xlim=(0.55, 1.5), ylim=(0.005, 1.0))
    canvas.identify(ax, EQUAL)
    canvas.legend(ax, loc="upper left")
    canvas.save(figure, folder, "figure6b")
    canvas.table(folder, "figure6b", canvas.STRIP_HEADER, canvas.strip_rows({"2u": found}))
    print(f"Figure 6b: {canvas.inside(sweeps, '2u', found)}; {compared(traced, found)}")
    return bool(found)
