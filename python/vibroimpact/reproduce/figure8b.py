"""Figure 8b: zones of motions with completed accumulation and rest ("sliding-like"), unequal restitution."""

from __future__ import annotations

from pathlib import Path

from . import canvas
from .figure9 import PANELS
from .paper import UNEQUAL, ratios
from .scan import Strip, traced_zone
from .sweeps import bars, read_sweeps, seeds
from .traced import compared, outline

#: The window of the figure.
R, CLEARANCE = (0.55, 1.5), (0.4, 60.0)


def zones(folder: Path, resolution: float = 1.0) -> dict[str, list[Strip]]:
    """Zones of each pattern with rest that was found at the end of a simulated hold; the paper had no theory for
    these.

    The scan continues a motion from point to point through the window of the figure, which contains higher loads
    than the simulated sweeps.
    """
    found = seeds(read_sweeps(folder, "unequal"), UNEQUAL)
    r, count = ratios(*R, 0.7 * resolution), max(40, round(200 * resolution))
    return {
        sides: traced_zone(UNEQUAL, motions, r, count, CLEARANCE)
        for sides, motions in sorted(found.items(), key=lambda item: (len(item[0]), item[0]))
        if sides.endswith("RL*") and set(sides[:-2]) == {"R"}
    }


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Draw figure8b.png and .svg, write figure8b.csv; True if RL* (Figure 9c) is among them."""
    found = zones(folder, resolution)
    sweeps = read_sweeps(folder, "unequal")
    figure, ax = canvas.panels(height=4.0)
    for (sides, strips), (colour, line, _) in zip(found.items(), canvas.LOOKS, strict=False):
        count = sides.count("R")
        name = f"{sides}: {count} on steel, rest on tape"
        traced = outline(UNEQUAL, sides, R, strips, clearance=CLEARANCE)
        canvas.zone(ax, strips, "rest", name, color=colour, ls=line, traced=traced)
        print(f"Figure 8b, {sides}: {compared(traced, strips)}")
    canvas.bars(ax, bars(sweeps, "rest"), "rest")
    canvas.letters(ax, {name: PANELS[name][2:] for name in ("c", "d")})
    canvas.axes_of_zones(ax)
    ax.set(xlim=R, ylim=(0.02, 2.5))
    canvas.identify(ax, UNEQUAL)
    canvas.legend(ax, loc="lower right")
    canvas.save(figure, folder, "figure8b")
    canvas.table(folder, "figure8b", canvas.STRIP_HEADER, canvas.strip_rows(found))
    strips = [strip for one in found.values() for strip in one]
    print(f"Figure 8b: {', '.join(found)}: {canvas.inside(sweeps, 'rest', strips)}")
    return "RL*" in found
