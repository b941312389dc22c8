"""Closed curves in the plane: dense polygons, areas, winding numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import _core

_Array = NDArray[np.float64]


def dense_ring(
    vertices: _Array, window: tuple[tuple[float, float], tuple[float, float]], inside: _Array
) -> _Array:
    """A ring of (r, D) along a closed loop, counter-clockwise around a zone and clockwise around a hole.

    The polygon is within 1e-7 of the curve, the window being the unit square. Rows of `vertices` are r, D,
    derivatives of r and log D by length, length to the next; `inside` is a point of the zone beside the loop.
    """
    room = 32 * vertices.shape[1]
    ring, count = _core.dense_ring(vertices, *window, inside, room)
    if count > room:
        ring, count = _core.dense_ring(vertices, *window, inside, count)
    return np.ascontiguousarray(ring[:, :count].T)


def signed_area(ring: _Array) -> float:
    """Area inside a polygon, positive if it goes counter-clockwise."""
    x, y = (ring - ring[0]).T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def winding(ring: _Array, points: _Array) -> NDArray[np.int64]:
    """How often a polygon of (r, D) goes round points (M, 2), counter-clockwise in the plane (r, log D)."""
    return _core.winding(ring.T, points.T).astype(np.int64)
