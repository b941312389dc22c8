"""Candidates that are judged only as far as needed: by some units and frequencies their level is bounded below."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .problem import Problem

_Array = NDArray[np.float64]
_Mask = NDArray[np.bool_]
_Indices = NDArray[np.intp]
#: Penalty on the level of a design per unit of excess of a figure over its limit.
PENALTY = 10.0
#: A level or a risk that is taken for infinite: differences and variances of such numbers are finite.
HUGE = 1e150


@dataclass(frozen=True)
class Grid:
    """The units, frequencies and initial states by which candidates are judged."""

    shares: _Array
    nodes: _Array
    places: _Array


class Pool:
    """Candidates, and their targets and excesses for the (frequency, unit) pairs that were simulated.

    With targets of -inf and excesses of 0 for the other pairs, the quantile is a lower bound of the level. Pairs
    are simulated in order of risk, that is, of their targets for other candidates.

    Attributes
    ----------
    values : ndarray (candidates, free)
    target, excess : ndarray (candidates, nodes, units, states)
    known : ndarray of bool (candidates, nodes, units)
        Which pairs were simulated; these arrays have room for further candidates.
    bounds : ndarray (candidates,)
        Levels of complete candidates, and lower bounds of the levels of other candidates.
    risk : ndarray (nodes, units)
    """

    def __init__(self, problem: Problem, grid: Grid, risk: _Array | None = None) -> None:
        self.problem, self.grid = problem, grid
        pairs = len(grid.nodes), grid.shares.shape[1]
        shape = *pairs, grid.places.shape[1]
        self.values = np.empty((0, len(problem.free)))
        self.target, self.excess = np.empty((2, 0, *shape))
        self.known = np.empty((0, *pairs), bool)
        self.bounds = np.empty(0)
        self.risk = np.zeros(pairs) if risk is None else np.minimum(risk, HUGE)
        # how many units at a frequency may be above the level
        states = shape[2] if problem.weighted else 1
        many = pairs[1] * states - 1
        self.spare = int((many - np.ceil(problem.quantile * many)) // states)

    def add(self, values: _Array, bounds: _Array | float = -np.inf) -> _Indices:
        """Adds candidates (n, free), with what is known of their levels; returns their indices."""
        first, n = len(self.values), len(values)
        self.values = np.concatenate([self.values, values])
        self.bounds = np.concatenate([self.bounds, np.broadcast_to(bounds, n)])
        if first + n > len(self.known):
            more = np.full((first + 2 * n, *self.target.shape[1:]), -np.inf)
            self.target = np.concatenate([self.target, more])
            self.excess = np.concatenate([self.excess, np.zeros(more.shape)])
            self.known = np.concatenate([self.known, np.zeros(more.shape[:3], bool)])
        return np.arange(first, first + n)

    def learn(self, some: _Indices, pairs: _Mask) -> None:
        """Simulates pairs (nodes, units) of some candidates that are not known yet."""
        where = pairs & ~self.known[some]
        if not where.any():
            return
        grid, problem = self.grid, self.problem
        target, excess = problem.outcomes(
            self.values[some], grid.shares, grid.nodes, grid.places, where
        )
        i, *pair = np.nonzero(where)
        at = some[i], *pair
        self.target[at], self.excess[at] = target[where], excess[where]
        self.known[at] = True
        level = problem.levels(self.target[some])
        whole = self.known[some].all(axis=(1, 2))
        if problem.limited:
            # only a level above 0 certainly increases with the target and the excess
            over = problem.levels(self.excess[some])
            known = whole | (level > 0)
            level[known] = penalised(level[known], over[known])
            level[~known] = -np.inf
        level = np.where(whole, level, np.maximum(level, self.bounds[some]))
        self.bounds[some] = np.minimum(level, HUGE)

    @property
    def complete(self) -> _Indices:
        """Indices of the candidates that were judged by all pairs."""
        return np.flatnonzero(self.known[: len(self.values)].all(axis=(1, 2)))

    def order(self) -> _Indices:
        """All pairs, as indices into (nodes, units), in order of decreasing risk.

        Units that together determine the level at a frequency are adjacent.
        """
        falling = -np.sort(-self.risk, axis=1)
        key = np.minimum(self.risk, falling[:, [self.spare]])
        node = np.broadcast_to(np.arange(len(key))[:, None], key.shape)
        return np.lexsort((-self.risk.ravel(), node.ravel(), -key.ravel()))

    @property
    def few(self) -> int:
        """Number of pairs that decide the level at some frequencies."""
        return max(64, 8 * (self.spare + 2), self.risk.size // 16)

    def look_at(self, candidate: int, weight: float = 0.5) -> None:
        """Takes the targets of a candidate, as far as they are known, for a part of the risk."""
        known = self.known[candidate]
        # the target of a failed run is inf
        target = np.minimum(self.target[candidate].max(axis=-1), HUGE)
        self.risk[known] += weight * (target[known] - self.risk[known])

    def first(self, many: int) -> _Mask:
        """The pairs (nodes, units) of the greatest risk."""
        pairs = np.zeros(self.risk.size, bool)
        pairs[self.order()[:many]] = True
        return pairs.reshape(self.risk.shape)

    def race(
        self, some: _Indices, limits: _Array | float, within: _Mask | None = None, least: int = 1
    ) -> _Array:  # fmt: skip
        """Evaluate candidates pair by pair until no pair is left or a level is certainly above its limit; return
        their `bounds`.

        The batches that are simulated together start with `least` pairs and triple in size; without limits there
        is a single batch.
        """
        order, begin = self.order(), 0
        if within is not None:
            order = order[within.ravel()[order]]
        limits = np.broadcast_to(limits, len(some))
        going = self.bounds[some] <= limits
        if np.all(np.isposinf(limits)):
            least = len(order)
        while begin < len(order) and going.any():
            end = max(least, 3 * begin)
            pairs = np.zeros(self.risk.size, bool)
            pairs[order[begin:end]] = True
            self.learn(some[going], pairs.reshape(self.risk.shape))
            going &= self.bounds[some] <= limits
            begin = end
        return self.bounds[some]


def penalised(level: _Array, over: _Array) -> _Array:
    """Levels with the penalty on an excess over limits; a target can be negative: the damping."""
    beyond = np.maximum(0, over - 1)
    # inf, of failed runs, times 0 is not a number
    more = np.multiply(
        np.abs(level),
        PENALTY * beyond,
        out=np.zeros(np.shape(level)),
        where=(beyond > 0) & (level != 0),
    )
    return np.asarray(level + more)
