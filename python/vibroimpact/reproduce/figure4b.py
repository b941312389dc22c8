"""Figure 4b: sin(tau) and the ratio of durations of two impacts a cycle at constant r, stability ignored."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from . import canvas
from .phases import POINTS, curve, curves, draw, mark


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Draw figure4b.png and .svg, write figure4b.csv; True if tau depends on the load at r = 0.999."""
    found = curves(resolution)
    figure, ax = canvas.panels(height=3.8)
    draw(ax, found, "sin_tau")
    mark(ax, "sin_tau", ("$A'$", "$A$"))
    ax.set_xlabel(r"$\sin\,\tau$")
    ax.set_xlim(-1.05, 1.05)
    canvas.legend(ax, loc="best")
    canvas.save(figure, folder, "figure4b")
    rows = [row for one in found for row in zip([one.r] * one.ratio.size, *one[1:], strict=True)]
    canvas.table(folder, "figure4b", ("r", "ratio", "clearance", "sin_tau", "admissible"), rows)
    two = curve(0.999, np.array(POINTS))
    print(
        f"Figure 4b: r = 0.999: dK/F0 from {two.clearance[1]:.4g} to {two.clearance[0]:.4g} moves sin(tau) "
        f"from {two.sin_tau[1]:.4f} to {two.sin_tau[0]:.4f}: tau depends on F0"
    )
    return abs(float(two.sin_tau[0] - two.sin_tau[1])) > 1e-3
