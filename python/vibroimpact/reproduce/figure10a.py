"""Figure 10a: F0/(dK) over max|X|/A at constant r near 1, equal coefficients of restitution."""

from __future__ import annotations

from pathlib import Path

from .damper import draw
from .paper import EQUAL


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Draw figure10a.png and .svg, write figure10a.csv; True if there are motions at every r."""
    found = draw(EQUAL, folder, "figure10a", "equal", resolution)
    return all(one.load.size for one in found)
