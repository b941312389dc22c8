"""Zones of stable motions by scanning: at each frequency ratio, the clearances at which a motion is stable.

The equispaced motions have a closed form; two impacts with given phases are the paper's linear problem, which
gives the clearance; motions with more impacts (or with rest) are continued by Newton's method from a motion that
was found. Here, stable means consistent, admissible, and with all multipliers inside the unit circle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import (
    Motion,
    Motions,
    Oscillator,
    Pattern,
    Trajectory,
    equispaced_batch,
    exact,
    periodic_batch,
    simulate,
)
from ..base.errors import VibroimpactError
from .paper import LOADS, scale

Array = NDArray[np.float64]
Test = Callable[[Array, Array], NDArray[np.bool_]]
#: Number of bisections with which an edge is located within a step of a scan.
HALVINGS = 30
#: Largest relative distance of two intervals at successive r that count as one thin zone.
ROOM = 0.02


class Strip(NamedTuple):
    """A piece of a zone: low < clearance < high at each r, r increasing."""

    r: Array
    low: Array
    high: Array

    @property
    def ring(self) -> Array:
        """The piece as a closed ring, (M, 2): r, clearance."""
        r = np.concatenate([self.r, self.r[::-1], self.r[:1]])
        return np.stack([r, np.concatenate([self.low, self.high[::-1], self.low[:1]])], axis=1)

    def contains(self, r: float, clearance: float) -> bool:
        """Whether a point lies in the piece."""
        if not self.r[0] <= r <= self.r[-1]:
            return False
        return bool(np.interp(r, self.r, self.low) < clearance < np.interp(r, self.r, self.high))


def is_good(motions: Motions) -> NDArray[np.bool_]:
    """Where the motions are consistent, admissible and stable."""
    good: NDArray[np.bool_] = (
        (motions.consistent == 1) & (motions.admissible == 1) & (motions.stable == 1)
    )
    return good


def equispaced_verdict(osc: Oscillator, precision: str = "double") -> Test:
    """Whether one of the two equispaced motions is stable, at many points (r, clearance)."""

    def test(r: Array, gap: Array) -> NDArray[np.bool_]:
        first, second = equispaced_batch(osc, r, gap, precision=precision)
        good: NDArray[np.bool_] = is_good(first) | is_good(second)
        return good

    return test


def grid(count: int, loads: tuple[float, float] = LOADS) -> Array:
    """Logarithms of d K/F0 in units of 1/scale(r); by default over the loads of the sweeps."""
    return np.linspace(-math.log(loads[1]), -math.log(loads[0]), count)


def clearance(r: Any, p: Any) -> Any:
    """The clearance at a point of `grid`."""
    return np.exp(p) / scale(r)


def equispaced_zone(
    osc: Oscillator, r: Array, count: int = 200, precision: str = "double"
) -> list[Strip]:
    """The zone of stable equispaced motions, from their closed form."""
    test = equispaced_verdict(osc, precision)
    rows, begins, ends = edges(lambda r, p: test(r, clearance(r, p)), r, grid(count))
    return join(r, rows, clearance(r[rows], begins), clearance(r[rows], ends))


def pair_zone(osc: Oscillator, r: Array, count: int = 1200) -> list[Strip]:
    """The zone of two stable unequispaced impacts per cycle: all phases are tried, as in the paper."""
    pair = Pattern("RL")
    # with equal walls each motion has a mirror image, whose second phase is 2 pi - alpha_2
    first = math.pi if osc.restitution[0] == osc.restitution[1] else 0.0
    step = (2 * math.pi - first) / count
    grid = (first + step * (np.arange(count) + 0.5)).astype(np.float64)

    def motions(r: Array, second: Array) -> tuple[NDArray[np.bool_], Array]:
        found = periodic_batch(osc, r, [np.zeros_like(second), second], pair)
        return (found.stable == 1) & (found.admissible == 1), found.clearance

    rows, begins, ends = edges(lambda r, p: motions(r, p)[0], r, grid)
    at = np.linspace(0, 1, 33)
    inside = begins[:, None] + (ends - begins)[:, None] * at
    _, clearance = motions(np.repeat(r[rows], at.size), inside.ravel())
    clearance = clearance.reshape(inside.shape)
    return join(r, rows, clearance.min(axis=1), clearance.max(axis=1))


def traced_zone(
    osc: Oscillator,
    seeds: Iterable[Motion],
    r: Array,
    count: int = 240,
    window: tuple[float, float] | None = None,
) -> list[Strip]:
    """The zone of stable motions of the seeds' pattern, continued from the seeds over a grid.

    Parameters
    ----------
    count : int
        Points of the grid over the loads of the sweeps.
    window : (float, float), optional
        Lowest and highest clearance of the grid; by default the grid spans the loads of the sweeps.
    """
    points = grid(count)
    if window is not None:
        ends = np.log(np.outer(window, scale(r)))
        step = float(points[1] - points[0])
        below, above = (
            math.ceil(max(0.0, float(beyond)) / step)
            for beyond in (points[0] - ends.min(), ends.max() - points[-1])
        )
        points = points[0] + step * np.arange(-below, points.size + above)
    count = points.size
    seeds = list(seeds)
    sides = seeds[0].pattern.sides if seeds else ""

    def at(guess: Motion | Trajectory, i: int, p: float) -> Motion | None:
        if window is not None and not window[0] <= clearance(r[i], p) <= window[1]:
            return None
        try:
            motion = exact(osc, float(r[i]), float(clearance(r[i], p)), guess)
        except VibroimpactError:
            return None
        same = motion.pattern.sides == sides
        return motion if same and motion.admissible and motion.stable else None

    known: dict[tuple[int, int], Motion] = {}
    tried: set[tuple[int, int]] = set()
    front = []
    for seed in seeds:
        i = int(np.argmin(abs(r - seed.r)))
        j = int(np.argmin(abs(clearance(r[i], points) - seed.clearance)))
        front += [(seed, i, j + k, True) for k in (1, -1, 0)]
    while front:
        guess, i, j, near = front.pop()
        if not (0 <= i < r.size and 0 <= j < count) or (i, j) in known:
            continue
        # thin zones may not contain the same j in the next column, so a guess from farther away is needed
        motion = at(guess, i, points[j]) if near or (i, j) not in tried else None
        if motion is None and near and guess.pattern.has_rest and (i, j) not in tried:
            motion = at(
                settled(guess, float(r[i]), float(clearance(r[i], points[j]))), i, points[j]
            )
        tried.add((i, j))
        if motion is not None:
            known[i, j] = motion
            front += [
                (motion, i + step, j + k, k == 0) for step in (1, -1) for k in (2, -2, 1, -1, 0)
            ]
            front += [(motion, i, j + 1, True), (motion, i, j - 1, True)]
    rows: list[int] = []
    lows: list[float] = []
    highs: list[float] = []
    for i in range(r.size):
        inside = [(i, j) in known for j in range(count)]
        for begin, end in runs(np.array(inside)):
            rows.append(i)
            for into, j, step in ((lows, begin, -1), (highs, end - 1, 1)):
                motion, good, bad = (
                    known[i, j],
                    points[j],
                    points[j] + step * (points[1] - points[0]),
                )
                for _ in range(HALVINGS // 3):
                    middle = 0.5 * (good + bad)
                    nearer = at(motion, i, middle)
                    motion, good, bad = (
                        (nearer, middle, bad) if nearer is not None else (motion, good, middle)
                    )
                into.append(float(clearance(r[i], good)))
    return join(r, np.array(rows, dtype=int), np.array(lows), np.array(highs))


def settled(motion: Motion, r: float, gap: float) -> Trajectory:
    """The motion on which a simulation from a motion settles at other parameters; for large steps of motions with
    rest this works better than Newton's method."""
    first = motion.events[0]
    side = 0.5 if first["side"] == "R" else -0.5
    unit = gap / motion.clearance
    state = {
        "t": first["phase"] / r, "x": unit * first["x"], "x_dot": unit * first["x_dot_after"],
        "z": unit * first["x"] + side * gap, "z_dot": unit * first["z_dot_after"],
    }  # fmt: skip
    return simulate(motion.osc, r, gap, 4, state=state, discard=100)


def edges(test: Test, r: Array, grid: Array) -> tuple[NDArray[np.intp], Array, Array]:
    """Rows with r and the ends of the intervals of the grid where a test holds, located by bisection."""
    good = test(np.repeat(r, grid.size), np.tile(grid, r.size)).reshape(r.size, grid.size)
    found = [(i, begin, end) for i in range(r.size) for begin, end in runs(good[i])]
    rows, begin, end = np.array(found, dtype=int).reshape(-1, 3).T
    # an interval that reaches the end of the grid ends there
    inner = np.concatenate([grid[begin], grid[end - 1]])
    outer = np.concatenate([grid[np.maximum(begin - 1, 0)], grid[np.minimum(end, grid.size - 1)]])
    at = np.concatenate([r[rows], r[rows]])
    for _ in range(HALVINGS if rows.size else 0):
        middle = 0.5 * (inner + outer)
        holds = test(at, middle)
        inner, outer = np.where(holds, middle, inner), np.where(holds, outer, middle)
    return rows, inner[: rows.size], inner[rows.size :]


def runs(good: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Beginning and end (one past) of each sequence of True."""
    change = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(np.int8)))
    return list(zip(change[::2].tolist(), change[1::2].tolist(), strict=True))


def join(r: Array, rows: NDArray[np.intp], low: Array, high: Array) -> list[Strip]:
    """Strips of intervals at successive r that overlap, each with at most one."""
    # in these units the zones are roughly horizontal
    floor, roof = np.log(low * scale(r[rows])), np.log(high * scale(r[rows]))
    strips: list[list[int]] = []  # indices of intervals

    def overlap(strip: list[int], k: int) -> float:
        """The overlap of interval k with the strip, if the strip continues horizontally or as one of its edges
        did."""
        last, before = strip[-1], strip[-2:][0]
        ahead = (r[rows[k]] - r[rows[last]]) / max(r[rows[last]] - r[rows[before]], 1e-300)
        moves = [0.0, *(ahead * (edge[last] - edge[before]) for edge in (floor, roof))]
        common = [min(roof[last] + m, roof[k]) - max(floor[last] + m, floor[k]) for m in moves]
        return float(max(common)) + ROOM

    for i in range(r.size):
        here = np.flatnonzero(rows == i).tolist()
        before = [strip for strip in strips if rows[strip[-1]] == i - 1]
        pairs = [(overlap(strip, k), n, k) for n, strip in enumerate(before) for k in here]
        taken: set[int] = set()
        for common, n, k in sorted(pairs, reverse=True):
            if common > 0 and k not in taken and rows[before[n][-1]] == i - 1:
                before[n].append(k)
                taken.add(k)
        strips += [[k] for k in here if k not in taken]
    return [Strip(r[rows[strip]], low[strip], high[strip]) for strip in strips]
