"""Confirmation of a design by independent samples, and a search with more units if it is not confirmed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..base.status import VERDICT
from ..results import door
from ..systems.distribution import interval
from .order import Order
from .problem import Problem
from .search import Archive, explored, grids, part_of, refined

#: Confidence of all intervals, and number of parts of the band for which shares are stated.
CONFIDENCE, BANDS = 0.95, 10
#: Number of samples that are simulated together.
CHUNK = 10_000
#: Number of samples that check the choice of units in the search, and how often the number of units is increased.
FEW, ROUNDS = 2000, 2
#: The seed of these samples, which no confirmation uses.
CHECK = 2**32
#: The core's codes of verdicts.
CODE_OF = {verdict: code for code, verdict in VERDICT.items()}


def confirmed(
    problem: Problem, order: Order, values: Mapping[str, float], samples: int, seed: int,
    progress: door.Progress | None,
) -> tuple[dict[str, Any], dict[str, Any]]:  # fmt: skip
    """Columns of the tables `design` and `bands` from independent samples."""
    rng = np.random.default_rng(seed)
    candidate = np.array(list(values.values()))
    first, last = problem.band
    parts = BANDS if first < last else 1
    edges = np.linspace(first, last, parts + 1)
    good, count, failed = np.zeros(parts, int), np.zeros(parts, int), 0
    worst = np.full(parts, -math.inf)
    states = 1 if problem.weighted else order.states
    limit = math.inf if order.limit is None else order.sign * order.limit
    for begin in range(0, samples, CHUNK):
        n = min(CHUNK, samples - begin)
        units, load = problem.units(candidate, rng.random((problem.dimensions, n)))
        place = rng.uniform(first, last, n)
        starts = rng.uniform(-1, 1, (4, n, states))
        # the runs of a unit are consecutive: the core keeps the data that depend only on the unit
        found = problem.host.outcome(
            {name: np.repeat(each, states) for name, each in units.items()}, np.repeat(place, states),
            np.repeat(load, states), starts.reshape(4, -1), part_of(progress, begin, n, samples), "confirmation",
        )  # fmt: skip
        target = found.target.reshape(n, states).max(axis=1)
        bad = ~np.isfinite(target)
        within = (target <= limit) & (found.excess.reshape(n, states).max(axis=1) <= 1) & ~bad
        part = np.clip(np.searchsorted(edges, place, side="right") - 1, 0, parts - 1)
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


def firmer(problem: Problem, order: Order, archive: Archive) -> tuple[Archive, Order]:
    """The candidates judged by more units, frequencies and states, if those of the search were too few.

    They were too few if the chosen candidate meets the limit in the search, but too few samples meet it.
    """
    for turn in range(ROUNDS):
        best = archive.best
        limit = math.inf if order.limit is None else order.sign * order.limit
        if archive.level[best] > limit or (order.limit is None and not problem.limited):
            break
        chosen = dict(zip(problem.free, archive.values[best], strict=True))
        tried, bands = confirmed(problem, order, chosen, FEW, CHECK, None)
        shares = bands["good"] / np.maximum(1, bands["samples"])
        if min(tried["probability"], shares.min()) >= problem.quantile:
            break
        # the new sets contain the previous units, states and frequencies
        order = replace(
            order, specimens=3 * order.specimens, nodes=2 * order.nodes - 1, states=order.states + 1
        )
        fine, coarse = grids(problem, order)
        values, levels = np.array(archive.values), np.array(archive.level)
        judged = Archive()
        refined(problem, fine, values, levels, None, judged)
        if judged.excess[judged.best] > 1:
            # a candidate that met the limits with fewer units does not meet them now: the search is repeated
            number = order.searches + turn
            found = explored(problem, coarse, order, number, None, Archive())
            further = Archive()
            refined(problem, fine, *found, None, further)
            judged.add(further)
        judged.searches, judged.judged_again = archive.searches, True
        archive = judged
    return archive, order
