"""Figure 6a: the zone of two equispaced impacts a cycle, in double and in single precision."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from . import canvas
from .paper import EQUAL, ratios
from .scan import Array, Strip, equispaced_zone
from .sweeps import bars, read_sweeps
from .traced import compared, outline


def zones(r: Array, resolution: float = 1.0) -> dict[str, list[Strip]]:
    """The zone in both precisions."""
    count = max(60, round(240 * resolution))
    return {kind: equispaced_zone(EQUAL, r, count, kind) for kind in ("double", "single")}


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Draw figure6a.png and .svg, write figure6a.csv; True if the zone is there in both precisions."""
    found = zones(ratios(0.55, 1.5, resolution), resolution)
    sweeps = read_sweeps(folder, "equal")
    figure, (ax, near) = canvas.panels(2, width_ratios=(1.6, 1))
    traced = outline(EQUAL, "RL", (0.55, 1.5), found["double"], symmetric=True)
    canvas.zone(ax, found["double"], "2e", "computed, double precision", traced=traced)
    canvas.zone(ax, found["single"], "2e", "computed, single precision", color="k", alpha=0, ls=":")
    canvas.bars(ax, bars(sweeps, "2e"), "2e")
    canvas.axes_of_zones(ax)
    ax.set(xlim=(0.55, 1.5), ylim=(0.005, 1.0))
    canvas.legend(ax, loc="upper left")
    steps = np.concatenate([[0], np.geomspace(1e-9, 4e-3, max(5, round(24 * resolution)))])
    close = zones(np.unique(np.concatenate([1 - steps, 1 + steps])), resolution)
    for kind, colour, line in (("double", "#0072B2", "-"), ("single", "k", ":")):
        for strip in close[kind]:
            near.plot(
                1e3 * (strip.r - 1), 1 / strip.low, color=colour, ls=line, label=f"{kind} precision"
            )
    canvas.axes_of_zones(near)
    near.set_yscale("linear")
    near.yaxis.set_major_formatter("{x:g}")
    near.set(xlabel=r"$10^3\,(r - 1)$")
    near.set_title("upper boundary at $r = 1$", fontsize=8)
    canvas.identify(ax, EQUAL)
    canvas.legend(near, loc="upper left")
    canvas.save(figure, folder, "figure6a")
    rows = canvas.strip_rows({**found, **{f"{name} near 1": close[name] for name in close}})
    canvas.table(folder, "figure6a", canvas.STRIP_HEADER, rows)
    print(
        f"Figure 6a: {canvas.inside(sweeps, '2e', found['double'])}; {compared(traced, found['double'])}"
    )
    return bool(found["double"] and found["single"])
