"""Figure 4a: dK/F0 and the ratio of durations of two impacts a cycle at constant r, stability ignored."""

from __future__ import annotations

from pathlib import Path

from ..plot import style
from . import canvas
from .phases import curves, draw, mark


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Draw figure4a.png and .svg, write figure4a.csv."""
    found = curves(resolution)
    figure, ax = canvas.panels(height=3.8)
    draw(ax, found, "clearance")
    mark(ax, "clearance", ("$B'$", "$B$"), -5.0)  # no other curve is near on the left
    style.log_scale(ax, "x")
    ax.set_xlabel(canvas.GAP)
    canvas.legend(ax, loc="upper left")
    canvas.save(figure, folder, "figure4a")
    rows = [row for one in found for row in zip([one.r] * one.ratio.size, *one[1:], strict=True)]
    canvas.table(folder, "figure4a", ("r", "ratio", "clearance", "sin_tau", "admissible"), rows)
    for one in found:
        good = one.clearance[one.admissible]
        says = f"{good.min():.4g} to {good.max():.4g}" if good.size else "no admissible motion"
        print(f"Figure 4a: r = {one.r:g}: dK/F0 of admissible motions: {says}")
    return True
