"""Figure 7: zones of three, four and five impacts a cycle, equal coefficients of restitution."""

from __future__ import annotations

from pathlib import Path

from . import canvas
from .paper import EQUAL, ratios
from .scan import Strip, traced_zone
from .sweeps import bars, read_sweeps, seeds
from .traced import compared, outline


def zones(folder: Path, resolution: float = 1.0) -> dict[str, list[Strip]]:
    """Zones by pattern, traced from motions at the ends of simulated holds; the paper used measured motions."""
    found = seeds(read_sweeps(folder, "equal"), EQUAL)
    r, count = ratios(0.55, 1.5, resolution), max(60, round(300 * resolution))
    return {
        sides: traced_zone(EQUAL, motions, r, count)
        for sides, motions in sorted(found.items(), key=lambda item: (len(item[0]), item[0]))
        if len(sides) in (3, 4, 5) and "*" not in sides
    }


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Draw figure7.png and .svg, write figure7.csv; True if three, four and five are there."""
    found = zones(folder, resolution)
    sweeps = read_sweeps(folder, "equal")
    figure, ax = canvas.panels(height=4.2)
    for kind in ("3", "4", "5"):
        names = [sides for sides in found if len(sides) == int(kind)]
        strips = [strip for sides in names for strip in found[sides]]
        for sides in names:
            traced = outline(EQUAL, sides, (0.55, 1.5), found[sides])
            title = f"{kind} impacts/cycle ({', '.join(names)})" if sides == names[0] else "_"
            canvas.zone(ax, found[sides], kind, title, traced=traced)
            print(f"Figure 7: {sides}: {compared(traced, found[sides])}")
        canvas.bars(ax, bars(sweeps, kind), kind)
        print(f"Figure 7: {', '.join(names)}: {canvas.inside(sweeps, kind, strips)}")
    canvas.axes_of_zones(ax)
    ax.set(xlim=(0.55, 1.5), ylim=(0.01, 5.0))
    canvas.identify(ax, EQUAL)
    canvas.legend(ax, loc="lower right")
    canvas.save(figure, folder, "figure7")
    canvas.table(folder, "figure7", canvas.STRIP_HEADER, canvas.strip_rows(found))
    return {len(sides) for sides in found} == {3, 4, 5}
