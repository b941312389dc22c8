"""Candidates that are judged only as far as needed: some runs of units bound their level below."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .problem import Problem, spare_states

_Array = NDArray[np.float64]
_Mask = NDArray[np.bool_]
_Indices = NDArray[np.intp]
#: Most runs of a candidate that are simulated at once: rare ones that reject it may be anywhere.
BATCH = 400
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
    """Candidates, and their targets and excesses for the runs that were simulated: a run is that of a unit at a
    frequency from an initial state.

    With targets of -inf and excesses of 0 for the other runs, the quantile is a lower bound of the level. Runs are
    simulated in order of risk, that is, of their targets for other candidates.

    Attributes
    ----------
    values : ndarray (candidates, free)
    target, excess : ndarray (candidates, nodes, units, states)
    known : ndarray of bool (candidates, nodes, units, states)
        Which runs were simulated; these arrays have room for further candidates.
    bounds : ndarray (candidates,)
        Levels of complete candidates, and lower bounds of the levels of other candidates, or of complete ones that
        are worse from other initial states.
    risk : ndarray (nodes, units, states)
    """

    def __init__(self, problem: Problem, grid: Grid, risk: _Array | None = None) -> None:
        self.problem, self.grid = problem, grid
        shape = len(grid.nodes), grid.shares.shape[1], grid.places.shape[1]
        self.values = np.empty((0, len(problem.free)))
        self.target, self.excess = np.empty((2, 0, *shape))
        self.known = np.empty((0, *shape), bool)
        self.bounds = np.empty(0)
        self.risk = np.zeros(shape) if risk is None else np.minimum(risk, HUGE)
        #: The pool that judges candidates from other initial states.
        self.other: Pool | None = None
        #: The index in that pool of each candidate that it has judged.
        self.twins: dict[int, int] = {}
        #: The candidates that are worse there.
        self.lucky: set[int] = set()
        # how many units, or initial states of units, may be above the level at a frequency
        many = shape[1] * (shape[2] if problem.weighted else 1) - 1
        self.spare: int = many - math.ceil(problem.quantile * many)
        # how many initial states of a unit may be above its figure
        self.spare_states: int = 0 if problem.weighted else spare_states(shape[2])

    def add(self, values: _Array) -> _Indices:
        """Adds candidates (n, free); returns their indices."""
        first, n = len(self.values), len(values)
        self.values = np.concatenate([self.values, values])
        self.bounds = np.concatenate([self.bounds, np.full(n, -np.inf)])
        if first + n > len(self.known):
            more = np.full((first + 2 * n, *self.risk.shape), -np.inf)
            self.target = np.concatenate([self.target, more])
            self.excess = np.concatenate([self.excess, np.zeros(more.shape)])
            self.known = np.concatenate([self.known, np.zeros(more.shape, bool)])
        return np.arange(first, first + n)

    def learn(self, some: _Indices, runs: _Mask) -> None:
        """Simulates those of some runs (nodes, units, states) that are not known yet.

        `runs` may differ from candidate to candidate: (some, nodes, units, states).
        """
        where = runs & ~self.known[some]
        if not where.any():
            return
        grid, problem = self.grid, self.problem
        target, excess = problem.outcomes(
            self.values[some], grid.shares, grid.nodes, grid.places, where
        )
        i, *run = np.nonzero(where)
        at = some[i], *run
        self.target[at], self.excess[at] = target[where], excess[where]
        self.known[at] = True
        level = problem.levels(self.target[some])
        if problem.limited:
            # only a level above 0 certainly increases with the target and the excess
            over = problem.levels(self.excess[some])
            known = self.known[some].all(axis=(1, 2, 3)) | (level > 0)
            level[known] = penalised(level[known], over[known])
            level[~known] = -np.inf
        self.bounds[some] = np.minimum(level, HUGE)

    @property
    def judged(self) -> _Indices:
        """For each candidate, the number of runs by which it was judged."""
        return np.asarray(self.known[: len(self.values)].sum(axis=(1, 2, 3)))

    @property
    def complete(self) -> _Indices:
        """Indices of the candidates that were judged by all runs."""
        return np.flatnonzero(self.judged == self.risk.size)

    @property
    def few(self) -> int:
        """Number of runs that decide the level at some frequencies."""
        return min(self.risk.size, max(32, 8 * self.least, self.risk.size // 32))

    @property
    def least(self) -> int:
        """Least number of runs that decide the level at a frequency."""
        return (self.spare + 1) * (self.spare_states + 1)

    def order(self, candidate: int | None = None) -> _Indices:
        """All runs, as indices into (nodes, units, states), in order of decreasing risk.

        Units that together determine the level at a frequency are adjacent, each with its worst initial state. For
        a candidate, its own targets count as the risk as far as they are known.
        """
        risk = self.risk
        number: NDArray[Any] = np.arange(risk.size).reshape(risk.shape)
        if candidate is not None:
            own = np.minimum(self.target[candidate], HUGE)
            risk = np.where(self.known[candidate], own, risk)
        if self.problem.weighted:
            risk, number = (each.reshape(len(each), -1, 1) for each in (risk, number))
        worst = np.argsort(-risk, axis=2, kind="stable")
        risk, number = (np.take_along_axis(each, worst, axis=2) for each in (risk, number))
        key = np.minimum(risk, risk[:, :, [self.spare_states]])
        key = np.minimum(key, -np.sort(-key, axis=1)[:, [self.spare]])
        node, _, rank = np.indices(key.shape)
        keys = -risk, node, rank, -key
        return number.ravel()[np.lexsort([each.ravel() for each in keys])]

    def look_at(self, candidate: int, weight: float = 0.5) -> None:
        """Takes the targets of a candidate, as far as they are known, for a part of the risk."""
        known = self.known[candidate]
        # the target of a failed run is inf
        target = np.minimum(self.target[candidate], HUGE)
        self.risk[known] += weight * (target[known] - self.risk[known])

    def first(self, many: int) -> _Mask:
        """The runs (nodes, units, states) of the greatest risk."""
        return self._mask(self.order()[:many])

    def race(
        self, some: _Indices, limits: _Array | float, order: _Indices | None = None, least: int = 1
    ) -> _Array:  # fmt: skip
        """Evaluate candidates run by run until no run is left or a level is certainly above its limit.

        Returns their `bounds`.

        The runs follow in an order (runs,), or for each candidate another one (some, runs). The batches that are
        simulated together start with `least` runs and triple in size; without limits there is a single batch.
        """
        order = np.atleast_2d(self.order() if order is None else order)
        order = np.broadcast_to(order, (len(some), order.shape[1]))
        limits, begin = np.broadcast_to(limits, len(some)), 0
        going = self.bounds[some] <= limits
        if np.all(np.isposinf(limits)):
            least = order.shape[1]
        while begin < order.shape[1] and going.any():
            end = max(least, min(3 * begin, begin + BATCH))
            self.learn(some[going], self._mask(order[going, begin:end]))
            going &= self.bounds[some] <= limits
            begin = end
        return self.bounds[some]

    def go_on(self, some: _Indices) -> None:
        """Simulates the next runs of some candidates, at most twice as many as are known, in order of risk."""
        order = self.order()
        known = self.known[some].reshape(len(some), -1)[:, order]
        most = np.clip(2 * known.sum(axis=1, keepdims=True), 8, BATCH)
        runs = np.zeros_like(known)
        runs[:, order] = ~known & ((~known).cumsum(axis=1) <= most)
        self.learn(some, runs.reshape(len(some), *self.risk.shape))

    def _mask(self, order: _Indices) -> _Mask:
        """The runs (..., nodes, units, states) of indices (..., many)."""
        runs = np.zeros((*order.shape[:-1], self.risk.size), bool)
        np.put_along_axis(runs, order, True, axis=-1)
        return runs.reshape(*order.shape[:-1], *self.risk.shape)


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
