"""Confirmation of a design by independent samples, and a search with more units if it is not confirmed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.status import VERDICT
from ..results import door
from ..systems.distribution import interval
from .order import Order
from .problem import Problem
from .search import AGREEMENT, RARE, Archive, part_of, search

_Array = NDArray[np.float64]
#: Confidence of all intervals, and number of parts of the band for which shares are stated.
CONFIDENCE, BANDS = 0.95, 10
#: Number of samples that are simulated together.
CHUNK = 10_000
#: Number of samples that check the choice of units in the search, and how often the number of units is increased.
FEW, ROUNDS = 10_000, 2
#: The seed of these samples, which no confirmation uses.
CHECK = 2**32
#: The core's codes of verdicts.
CODE_OF = {verdict: code for code, verdict in VERDICT.items()}


@dataclass(frozen=True)
class Samples:
    """Random units of a candidate at random points of the band.

    Attributes
    ----------
    units : dict of ndarray (n,)
    load, place : ndarray (n,)
    starts : ndarray (4, n, states)
        Initial states.
    part : ndarray (n,) of int
        The part of the band.
    """

    units: Mapping[str, _Array]
    load: _Array
    place: _Array
    starts: _Array
    part: NDArray[np.intp]

    @classmethod
    def drawn(
        cls, problem: Problem, order: Order, values: Mapping[str, float], n: int, rng: np.random.Generator
    ) -> Samples:  # fmt: skip
        """Random samples."""
        candidate = np.array(list(values.values()))
        units, load = problem.units(candidate, rng.random((problem.dimensions, n)))
        place = rng.uniform(*problem.band, n)
        starts = rng.uniform(-1, 1, (4, n, 1 if problem.weighted else order.states))
        edges = edges_of(problem)
        part = np.searchsorted(edges, place, side="right") - 1
        return cls(units, load, place, starts, np.clip(part, 0, len(edges) - 2))

    def judged(
        self, problem: Problem, order: Order, some: slice, progress: door.Progress | None,
        level: float | None = None,
    ) -> tuple[_Array, NDArray[np.bool_]]:  # fmt: skip
        """The target of some samples, and whether they are within all limits, and not above a level."""
        n, states = len(self.place[some]), self.starts.shape[2]
        limit = math.inf if order.limit is None else order.sign * order.limit
        limit = limit if level is None else min(limit, level)
        # the runs of a unit are consecutive: the core keeps the data that depend only on the unit
        found = problem.host.outcome(
            {name: np.repeat(each[some], states) for name, each in self.units.items()},
            np.repeat(self.place[some], states), np.repeat(self.load[some], states),
            self.starts[:, some].reshape(4, -1), progress, "confirmation",
        )  # fmt: skip
        target = found.target.reshape(n, states).max(axis=1)
        excess = found.excess.reshape(n, states).max(axis=1)
        return target, np.isfinite(target) & (target <= limit) & (excess <= 1)


def edges_of(problem: Problem) -> _Array:
    """Ends (parts + 1,) of the parts of the band."""
    first, last = problem.band
    return np.linspace(first, last, (BANDS if first < last else 1) + 1)


def refuted(
    problem: Problem, order: Order, values: Mapping[str, float], level: float, limited: bool
) -> str:
    """What up to `FEW` samples refute: "level" if in the whole band more than the quantile allows are more than
    2 % worse than it; "limits" if a design is limited and too few are within all limits in some part of the
    band; empty if neither.

    A share of `RARE` may always be worse: the search does not count rarer attractors. The test ends as soon as too
    many samples are worse or beyond limits, or, without limits, when clearly few are worse. Structures, whose
    samples take long, are checked by at most as many samples as confirm the design.
    """
    most = FEW if problem.quick else min(FEW, order.samples)
    samples = Samples.drawn(problem, order, values, most, np.random.default_rng(CHECK))
    count = np.bincount(samples.part, minlength=len(edges_of(problem)) - 1)
    bad, worse = np.zeros(len(count), int), 0
    level += AGREEMENT * abs(level)
    for begin in range(0, most, FEW // 20):
        some = slice(begin, min(begin + FEW // 20, most))
        target, within = samples.judged(problem, order, some, None)
        bad += np.bincount(samples.part[some][~within], minlength=len(bad))
        worse += int(np.count_nonzero(~(target <= level)))
        allowed = max(1 - problem.quantile, RARE)
        if worse > allowed * most:
            return "level"
        # fewer than allowed by three standard deviations of their number
        few = allowed * some.stop
        if not limited and worse <= few - 3 * math.sqrt(few):
            return ""
        # rounded up: of few samples, one is a larger share; what rounding adds is not
        if limited and np.any(bad > np.ceil((1 - problem.quantile) * count - 1e-9)):
            return "limits"
    return ""


def confirmed(
    problem: Problem, order: Order, values: Mapping[str, float], samples: int, seed: int,
    progress: door.Progress | None, level: float | None = None,
) -> tuple[dict[str, Any], dict[str, Any]]:  # fmt: skip
    """Columns of the tables `design` and `bands` from independent samples; those above a level count as bad."""
    rng = np.random.default_rng(seed)
    edges = edges_of(problem)
    parts = len(edges) - 1
    good, count, failed = np.zeros(parts, int), np.zeros(parts, int), 0
    worst = np.full(parts, -math.inf)
    for begin in range(0, samples, CHUNK):
        n = min(CHUNK, samples - begin)
        drawn = Samples.drawn(problem, order, values, n, rng)
        target, within = drawn.judged(
            problem, order, slice(n), part_of(progress, begin, n, samples), level
        )
        bad = ~np.isfinite(target)
        part = drawn.part
        good += np.bincount(part[within], minlength=parts)
        count += np.bincount(part, minlength=parts)
        failed += int(bad.sum())
        np.maximum.at(worst, part[~bad], target[~bad])
    total = int(good.sum())
    low, high = interval(total, samples)
    # at a confidence that holds for all parts simultaneously
    each_part = [
        interval(int(g), int(n), 1 - (1 - CONFIDENCE) / parts)
        for g, n in zip(good, count, strict=True)
    ]
    ends = np.array(each_part).T
    feasible = None
    if order.limit is not None or problem.limited:
        lows, highs = min(low, ends[0].min()), min(high, ends[1].min())
        feasible = False if highs < problem.quantile else True if lows >= problem.quantile else None
    design = {
        "worst": order.sign * float(worst.max()), "samples": samples, "failed": failed,
        "probability": total / samples, "low": low, "high": high, "feasible": CODE_OF[feasible],
    }  # fmt: skip
    bands = {
        "from": edges[:-1], "to": edges[1:], "samples": count, "good": good,
        "probability": np.divide(good, count, out=np.full(parts, math.nan), where=count > 0),
        "low": ends[0], "high": ends[1],
        "worst": order.sign * np.where(np.isfinite(worst), worst, math.nan),
    }  # fmt: skip
    return design, bands


def firmer(
    problem: Problem, order: Order, archive: Archive, progress: door.Progress | None
) -> tuple[Archive, Order]:
    """Repeat the searches with more units and frequencies, at first from their best candidates.

    They had too few of these if samples of the chosen candidate are worse than its level, or do not meet the
    limits that it meets in the search, see `refuted`. Structures are checked for limits only: their samples take
    long. In the end an uncertain level of repeated searches is settled. If they do not agree, as many are added
    until they do, and the level is settled again. If it changes, it is checked again. After Ctrl-C the last
    candidates are returned of which one was judged by all runs.
    """
    limit = math.inf if order.limit is None else order.sign * order.limit
    for turn in range(ROUNDS + 1):
        best = archive.best
        level = archive.level[best]
        # a level with a penalty is not one of units, so that samples cannot check it
        if archive.excess[best] > 1:
            break
        met = level <= limit
        # after the last set a confirmation tells whether the limits hold, and only the level is checked
        limited = turn < ROUNDS and met and (order.limit is not None or problem.limited)
        if not (limited or problem.quick):
            break
        chosen = dict(zip(problem.free, archive.values[best], strict=True))
        try:
            near = level if problem.quick else math.inf
            archive.refuted = refuted(problem, order, chosen, near, limited)
            # samples beyond the limits may end the check of the level too early
            if problem.quick and archive.refuted != "limits":
                archive.contradicted = archive.refuted == "level"
            # nothing better is known where no candidate meets the limit
            if not archive.refuted or not met or turn == ROUNDS:
                break
            # the new sets contain the previous units, frequencies and initial states
            more = replace(order, specimens=2 * order.specimens, nodes=2 * order.nodes - 1)
            part = part_of(progress, turn, 1, ROUNDS + 1)
            found = search(problem, more, part, archive)
        except KeyboardInterrupt:
            archive.stopped = True
            break
        archive, order, before = found, more, archive
        if archive.stopped:
            break
    if turn and problem.quick and not archive.stopped:
        archive.refuted = ""
        try:
            best, level = archive.best, archive.level[archive.best]
            archive.settle(problem)
            if archive.agree(problem) is False and not archive.contradicted:
                part = part_of(progress, turn, 1, ROUNDS + 1)
                archive = search(problem, order, part, before, archive)
                if archive.stopped:
                    return archive, order
                archive.settle(problem)
            same = archive.best == best and archive.level[best] == level
            if not same and archive.contradicted is not None:
                best = archive.best
                chosen = dict(zip(problem.free, archive.values[best], strict=True))
                wrong = refuted(problem, order, chosen, archive.level[best], False)
                archive.contradicted = None if archive.excess[best] > 1 else wrong == "level"
        except KeyboardInterrupt:
            archive.stopped = True
    return archive, order
