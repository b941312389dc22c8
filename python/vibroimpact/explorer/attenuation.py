"""max|X|/A of the worst attractor that a set of initial states reaches, at the points of a map and of a box."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import Oscillator
from ..results.performance import perform
from .limits import Progress
from .state import Box
from .zones import Window

__all__ = ["Judged", "box_points", "judged", "map_parts"]

_Array = NDArray[np.float64]
#: Points of the map along r and along the clearance, and the spacing of the points in each pass.
SIZE, PASSES = (60, 40), (4, 2, 1)
#: Points that are computed between two updates of the picture.
CHUNK = 400
#: Points of a box.
SAMPLES = 400
#: Load cycles after which a simulation without a period counts as settled, and the load cycles then examined.
SETTLING, KEEP = 200, 32
#: Initial states in the box of the random states of `basins`: the same at all points.
PLACES = np.random.default_rng(1).uniform(-1, 1, (4, 2))


@dataclass(frozen=True, eq=False)
class Judged:
    """The outcome of the simulations at some points.

    Attributes
    ----------
    r, clearance : ndarray (n,)
    attenuation : ndarray (n,)
        max|X|/A on the worst attractor; NaN if a simulation was abandoned.
    stable : ndarray (n,) of bool
        Whether all initial states settle on periodic motions.
    """

    r: _Array
    clearance: _Array
    attenuation: _Array
    stable: NDArray[np.bool_]


def judged(
    osc: Oscillator, r: _Array, clearance: _Array, progress: Progress | None = None
) -> Judged:
    """Simulate at some points; an exception raised by `progress` ends the simulations.

    Examples
    --------
    >>> import numpy as np, vibroimpact as vi
    >>> from vibroimpact.explorer.attenuation import judged
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> found = judged(osc, np.array([1.04, 1.04]), np.array([25.0, 30.0]))
    >>> found.attenuation.round(4).tolist(), found.stable.tolist()
    ([0.5424, 0.4977], [True, True])
    """
    n, states = len(r), PLACES.shape[1]
    numbers = np.empty((6, n))
    numbers[:2] = r, clearance
    numbers[2:] = np.array([osc.xi, osc.mu, *osc.restitution])[:, None]
    found = perform(
        np.repeat(numbers, states, axis=1), np.tile(PLACES, n), SETTLING, KEEP, progress=progress
    )
    # a motion without impacts has no multipliers, and is stable
    settled = (found.cycles > 0) & ((found.impacts == 0) | (found.multiplier < 1))
    each = np.where(found.status == 0, found.displacement / found.amplitude, np.nan)
    return Judged(
        r, clearance, each.reshape(n, states).max(axis=1), settled.reshape(n, states).all(axis=1)
    )


def map_parts(window: Window) -> Iterator[tuple[_Array, _Array, NDArray[np.intp], int]]:
    """The points of a map in the order of computation: part by part, from a coarse grid to a fine one.

    Each part consists of r and clearance of its points, their indices (2, n) in the picture (rows along the
    clearance), and the width of the squares that each point fills until the points in between are known.

    Examples
    --------
    >>> from vibroimpact.explorer.attenuation import map_parts
    >>> parts = list(map_parts(((0.8, 1.2), (2.0, 200.0))))
    >>> sum(len(part[0]) for part in parts), parts[0][3], parts[-1][3]
    (2400, 4, 1)
    """
    wide, high = SIZE
    (r0, r1), (d0, d1) = window
    r = r0 + (r1 - r0) * (np.arange(wide) + 0.5) / wide
    clearance = d0 * (d1 / d0) ** ((np.arange(high) + 0.5) / high)
    known = np.zeros((high, wide), bool)
    for step in PASSES:
        here = np.zeros_like(known)
        here[::step, ::step] = True
        places = np.argwhere(here & ~known)
        known |= here
        for part in np.array_split(places, -(-len(places) // CHUNK)):
            i, j = part.T
            yield r[j], clearance[i], part.T, step


def filled(picture: _Array, places: NDArray[np.intp], values: _Array, step: int) -> None:
    """Put the values of points into a picture; each fills the square whose first corner it is."""
    for i, j, value in zip(*places.tolist(), values.tolist(), strict=True):
        picture[i : i + step, j : j + step] = value


def box_points(box: Box) -> tuple[_Array, _Array]:
    """r and clearance of points in a box: random, evenly spread, and at the same relative positions in every
    box."""
    rng = np.random.default_rng(7)
    # Latin hypercube: one point in each of n equal strips, in both directions
    places = [(rng.permutation(SAMPLES) + rng.random(SAMPLES)) / SAMPLES for _ in range(2)]
    (r0, r1), (d0, d1) = box.ends
    return r0 + (r1 - r0) * places[0], d0 + (d1 - d0) * places[1]
