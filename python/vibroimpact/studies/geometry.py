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
    """How often a polygon goes round points (M, 2), counter-clockwise."""
    following = np.roll(ring, -1, axis=0)
    lower = np.minimum(ring[:, 1], following[:, 1])
    upper = np.maximum(ring[:, 1], following[:, 1])
    result = np.zeros(len(points), dtype=np.int64)
    inside = (
        (points >= ring.min(axis=0)) & (points <= ring.max(axis=0)) & np.isfinite(points)
    ).all(axis=1)
    for i in np.flatnonzero(inside).tolist():
        x, y = points[i]
        edges = np.flatnonzero((lower <= y) & (y < upper))
        a, b = ring[edges], following[edges]
        left = (b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (x - a[:, 0]) * (b[:, 1] - a[:, 1])
        up = b[:, 1] > a[:, 1]
        result[i] = np.count_nonzero(up & (left > 0)) - np.count_nonzero(~up & (left < 0))
    return result
def distance_to_other(inside: NDArray[np.bool_], first: float, second: float) -> NDArray[np.float64]:
def distance_to_other(inside: NDArray[np.bool_], first: float, second: float) -> _Array:
    """Distance of each point of a lattice to the nearest one that is not inside, or beyond its edge.
    Along the first axis distances are counted up and down; along the second the lower envelope of
    parabolas is the exact answer.
    """
    padded = np.pad(inside, 1)
    n, m = padded.shape
    away = np.where(padded, np.inf, 0.0)
    for i in range(1, n):
        away[i] = np.minimum(away[i], away[i - 1] + first)
    for i in range(n - 2, -1, -1):
        away[i] = np.minimum(away[i], away[i + 1] + first)
    best = np.full((n, m), np.inf)
    for step in range(m):
        shift = (step * second) ** 2
        if step:
            best[:, step:] = np.minimum(best[:, step:], away[:, :-step] ** 2 + shift)
            best[:, :-step] = np.minimum(best[:, :-step], away[:, step:] ** 2 + shift)
        else:
            best = away**2
    distance: _Array = np.sqrt(best)[1:-1, 1:-1]
    return distance
