"""Figure 6a, proven: where equispaced motions are stable and admissible, in ball arithmetic.

The proof takes a few minutes, so it is computed only if it is named.
"""

from __future__ import annotations

import math
from pathlib import Path

from .. import zone
from . import canvas
from .paper import EQUAL

R, CLEARANCE = (0.55, 1.5), (1.0, 200.0)
#: Width in log D, relative to the window, of the strip that may remain undecided, and the same at a coarse
#: resolution.
TOLERANCE, COARSE = 5e-4, 0.1


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Draw proof6a.png and .svg, write the certificate, proof6a.json; True if no proof contradicts the zone."""
    found = zone(EQUAL, "RL", r=R, clearance=CLEARANCE, symmetric=True)
    proof = found.prove(tolerance=min(COARSE, TOLERANCE / resolution))
    figure, ax = canvas.panels()
    proof.plot(ax)
    canvas.axes_of_zones(ax, inverse=False)
    canvas.legend(ax, loc="upper left")
    canvas.identify(ax, EQUAL)
    canvas.save(figure, folder, "proof6a")
    proof.save(folder / "proof6a.json")
    shares = proof.shares()
    # of the area of the zone, and of the rest of the window
    part = found.area / ((R[1] - R[0]) * math.log(CLEARANCE[1] / CLEARANCE[0]))
    inside, outside = shares["inside"] / part, shares["outside"] / (1 - part)
    print(
        f"Figure 6a, proven: {100 * inside:.2f} % of the area of the zone hold a stable, admissible motion, "
        f"{100 * outside:.2f} % of the rest hold none ({proof.seconds:.0f} s)"
    )
    return bool(inside <= 1 and outside <= 1)
