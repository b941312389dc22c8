"""Figure 10b: F0/(dK) over max|X|/A at constant r near 1, R1 = 0.61, R2 = 0.75."""

from __future__ import annotations

from pathlib import Path

from .damper import draw
from .paper import DAMPER


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Draw figure10b.png and .svg, write figure10b.csv; True if there are motions at every r."""
    # the walls of the rig are exchanged: this is the mirror image, with the same max|X|
    found = draw(DAMPER, folder, "figure10b", "unequal", resolution)
    return all(one.load.size for one in found)
