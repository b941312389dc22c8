"""Distances on a lattice of points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def distance_to_other(
    inside: NDArray[np.bool_], first: float, second: float
) -> NDArray[np.float64]:
    """Distance of each point of a lattice to the nearest one that is not inside, or beyond its edge.

    Along the first axis, with spacing `first`, distances are counted up and down; along the second the
    least of the parabolas over all columns is the exact answer.
    """
    padded = np.pad(inside, 1)
    n, m = padded.shape
    away = np.where(padded, np.inf, 0.0)
    for i in range(1, n):
        away[i] = np.minimum(away[i], away[i - 1] + first)
    for i in range(n - 2, -1, -1):
        away[i] = np.minimum(away[i], away[i + 1] + first)
    best = away**2
    for step in range(1, m):
        shift = (step * second) ** 2
        best[:, step:] = np.minimum(best[:, step:], away[:, :-step] ** 2 + shift)
        best[:, :-step] = np.minimum(best[:, :-step], away[:, step:] ** 2 + shift)
    distance: NDArray[np.float64] = np.sqrt(best)[1:-1, 1:-1]
    return distance
