"""Closed curves in the plane: dense polygons, areas, winding numbers."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]
#: Farthest that a polygon may lie from its curve, the window being the unit square.
SAG = 1e-7


def dense_ring(
    vertices: _Array, window: tuple[tuple[float, float], tuple[float, float]], closed: bool = True
) -> _Array:
    """A ring of (r, D) from vertices r, D, derivatives of r and log D by length, length to the next.

    Between two vertices the curve is the cubic with these derivatives; the polygon follows it to `SAG`.
    """
    low = np.array([window[0][0], math.log(window[1][0])])
    scale = np.array([window[0][1], math.log(window[1][1])]) - low
    place = (np.c_[vertices[0], np.log(vertices[1])] - low) / scale
    slope = vertices[2:4].T / scale
    parts = []
    count = len(place) if closed else len(place) - 1
    for i in range(count):
        j = (i + 1) % len(place)
        length = vertices[4, i]
        if not length > 0:
            continue
        a, b = length * slope[i], length * slope[j]
        chord = place[j] - place[i]
        sag = max(np.abs(a - chord).max(), np.abs(b - chord).max()) / 4
        t = np.linspace(0, 1, 1 + max(1, math.ceil(math.sqrt(sag / SAG))))[:-1, None]
        parts.append(place[i] + t * (a + t * (3 * chord - 2 * a - b + t * (a + b - 2 * chord))))
    if not closed:
        parts.append(place[-1:])
    if not parts:
        parts = [place]
    points = low + scale * np.concatenate(parts)
    return np.column_stack([points[:, 0], np.exp(points[:, 1])])


def signed_area(ring: _Array) -> float:
    """Area inside a polygon, positive if it goes counter-clockwise."""
    x, y = (ring - ring[0]).T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def winding(ring: _Array, points: _Array) -> NDArray[np.int64]:
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
