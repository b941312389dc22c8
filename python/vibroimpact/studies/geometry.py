"""Closed curves in the plane: areas and winding numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import _core

_Array = NDArray[np.float64]


def signed_area(ring: _Array) -> float:
    """Area inside a polygon, positive if it goes counter-clockwise."""
    x, y = (ring - ring[0]).T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def winding(ring: _Array, points: _Array) -> NDArray[np.int64]:
    """Winding numbers of a polygon of (r, D) around points (M, 2), counter-clockwise in the plane (r, log D)."""
    return _core.winding(ring.T, points.T).astype(np.int64)
