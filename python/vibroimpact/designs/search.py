"""The search for a design: global searches on few units, then descent along the gradients of the worst units."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..base.libraries import scipy
from ..results import door
from .order import Order
from .pool import Grid, Pool, penalised
from .problem import Problem

_Array = NDArray[np.float64]
_Mask = NDArray[np.bool_]
#: Largest relative difference of the levels of two searches that agree.
AGREEMENT = 0.02
#: Relative gain below which a candidate that is judged completely is left as it is.
SETTLED = 5e-4
#: The same if it takes more than `MANY` pairs of a frequency and a unit to judge one.
ROUGHLY = 5e-3
#: Number of descents by active pairs, each followed by a judgement of the best candidates by all.
TURNS = 4
#: Points tried in a step besides the best one of the linear program.
OTHERS = 4
#: Number of pairs of a frequency and a unit above which judging a candidate by all of them is costly.
MANY = 256


@dataclass
class Archive:
    """All candidates that were evaluated for all units of the search.

    Attributes
    ----------
    values : list of ndarray (free,)
    nominal, level : list of float
        Level of the unit without deviations, and level of all units, with a penalty for a design above its limits.
    excess, worst : list of float
        Level of the largest ratio of a figure to its limit, and the largest target.
    tried, bounds : list of ndarray (free,), and of float
        All candidates that were evaluated for some of these units, and lower bounds of their levels.
    searches : list of (int, float)
        For each search: the number of its candidates in this archive, and the best level.
    stopped : bool
        Whether Ctrl-C ended the searches.
    judged_again : bool
        Whether the candidates come from searches with fewer units.
    grid, targets : Grid, ndarray (nodes, units, states)
        Of the best candidate.
    """

    values: list[_Array] = field(default_factory=list)
    nominal: list[float] = field(default_factory=list)
    level: list[float] = field(default_factory=list)
    excess: list[float] = field(default_factory=list)
    worst: list[float] = field(default_factory=list)
    tried: list[_Array] = field(default_factory=list)
    bounds: list[float] = field(default_factory=list)
    searches: list[tuple[int, float]] = field(default_factory=list)
    stopped: bool = False
    judged_again: bool = False
    grid: Grid | None = None
    targets: _Array | None = None

    def add(self, pool: Pool) -> None:
        """Adds the candidates of a further search."""
        done = pool.complete
        found = levels_of(pool.problem, pool.target[done], pool.excess[done])
        best = int(np.argmin(found[1]))
        if not self.level or found[1][best] < min(self.level):
            self.grid, self.targets = pool.grid, pool.target[done[best]]
        self.values.extend(pool.values[done])
        for name, numbers in zip(("nominal", "level", "excess", "worst"), found, strict=True):
            getattr(self, name).extend(map(float, numbers))
        self.tried.extend(pool.values)
        self.bounds.extend(map(float, pool.bounds))
        self.searches.append((len(done), float(found[1][best])))

    @property
    def agree(self) -> bool:
        """Whether the three best searches ended within `AGREEMENT` of one level; two searches may do so by
        chance."""
        levels = sorted(level for _, level in self.searches)
        return len(levels) > 2 and levels[2] - levels[0] <= AGREEMENT * abs(levels[0])

    @property
    def best(self) -> int:
        """Index of the best candidate."""
        return int(np.argmin(self.level))

    @property
    def front(self) -> NDArray[np.bool_]:
        """For each candidate, whether no other one is better in both levels."""
        pairs = np.stack([self.nominal, self.level], axis=1)
        beaten = [
            (np.all(pairs <= pair, axis=1) & np.any(pairs < pair, axis=1)).any() for pair in pairs
        ]
        return ~np.array(beaten)

    def sensitivity(self, problem: Problem) -> dict[str, float]:
        """Derivatives of the target of the worst unit of the best candidate with respect to its parameters."""
        assert self.grid is not None
        assert self.targets is not None
        found = gradients(problem, self.grid, self.values[self.best], self.targets, 1)
        return {
            name: slope for _, each in found for name, slope in each.items() if np.isfinite(slope)
        }


def grid(problem: Problem, units: int, nodes: int, states: int) -> Grid:
    """Units from a Sobol sequence, the first without deviations, and frequencies including both ends of the band.

    They do not depend on the seed of a design, so that the levels of designs with different seeds can be compared.
    """
    qmc = scipy("stats", "a design", "design").qmc

    if all(item.low == item.high for item in (*problem.tolerance.values(), problem.load)):
        units = 1
    shares = np.full((problem.dimensions, units), 0.5)
    if units > 1:
        many = qmc.Sobol(problem.dimensions, seed=0).random(1 << (units - 1).bit_length())
        shares[:, 1:] = many[: units - 1].T
        if problem.quantile == 1:
            # the worst unit is often at a corner
            corners = np.indices((2,) * min(problem.dimensions, 4)).reshape(
                min(problem.dimensions, 4), -1
            )
            many = min(corners.shape[1], units - 1)
            shares[: len(corners), 1 : many + 1] = corners[:, ::-1][:, :many]
    places = 2 * qmc.Sobol(4, seed=1).random(1 << (states - 1).bit_length())[:states].T - 1
    return Grid(shares, np.unique(np.linspace(*problem.band, nodes)), places)


def grids(problem: Problem, order: Order) -> tuple[Grid, Grid]:
    """The grid that judges the best candidates, and the grid for all candidates of a global search."""
    few = min(order.specimens, 4), max(2, (order.nodes + 1) // 2), order.states
    return grid(problem, order.specimens, order.nodes, order.states), grid(problem, *few)


def judged(problem: Problem, grid: Grid, candidates: _Array) -> tuple[_Array, ...]:
    """Levels of candidates (n, free) for the unit without deviations and for all units, with penalties; the level
    of the excess, and the greatest target."""
    return levels_of(problem, *problem.outcomes(candidates, grid.shares, grid.nodes, grid.places))


def levels_of(problem: Problem, target: _Array, excess: _Array) -> tuple[_Array, ...]:
    """As `judged`, from targets and excesses (candidates, nodes, units, states)."""
    found = []
    for units in (slice(1), slice(None)):
        over = problem.levels(excess[:, :, units])
        found.append(penalised(problem.levels(target[:, :, units]), over))
    return *found, over, target.max(axis=(1, 2, 3))


def search(problem: Problem, order: Order, progress: door.Progress | None) -> Archive:
    """Run the searches; return the candidates evaluated for all units. The best one has the lowest level.

    Independent global searches are run one after another until the best levels of three of them agree: searches
    that missed the best region are unlikely to end at the same level.

    Parameters
    ----------
    order : Order
        Units, nodes and initial states for which the best candidates are evaluated, see `grid`; the global search
        uses few units.
    """
    fine, coarse = grids(problem, order)
    archive = Archive()
    for number in range(order.searches):
        report = part_of(progress, number, 1, order.searches)
        pools = [Pool(problem, coarse)]
        try:
            explored(pools[0], order, number, report)
            pools.append(finer(pools[0], fine))
            refined(pools[1], *complete_of(pools[0]), report)
            archive.add(pools[1])
        except KeyboardInterrupt:
            # if the first search was stopped: its candidates, judged by all units or by few
            if not archive.level:
                judged = [pool for pool in pools if len(pool.complete)]
                if not judged:
                    raise
                archive.add(judged[-1])
            archive.stopped = True
        if archive.agree or archive.stopped:
            break
    return archive


def explored(pool: Pool, order: Order, number: int, progress: door.Progress | None) -> None:
    """One global search by differential evolution.

    Each candidate replaces an earlier candidate if it is not worse: it is evaluated until its level is certainly
    above that of the earlier one. The random numbers depend only on the seed of the order and the number of the
    search.
    """
    problem = pool.problem
    low, high = np.array(list(problem.free.values()), dtype=float).T
    whole = np.array([name in problem.whole for name in problem.free])
    evaluations = max(order.evaluations, 8 * len(low))
    size, before = max(8, 8 * len(low)), len(pool.values)
    rng = np.random.default_rng((order.seed, number))

    def values(shares: _Array) -> _Array:
        found = low + (high - low) * shares
        return np.asarray(np.where(whole, np.rint(found), found))

    def report() -> None:
        if progress is not None:
            done = (len(pool.values) - before) / (evaluations + size)
            progress(min(0.7, 0.7 * done), "global search")

    place = _even_start(len(low), size, rng)
    # the first ones in small parts, so that Ctrl-C soon finds some that are judged
    ends = [0, *range(1, size, 4), size]
    at, level = np.empty(0, int), np.empty(0)
    for begin, end in pairwise(ends):
        some = pool.add(values(place[begin:end]))
        # a level far above the best one need not be known
        limit = level.min() + abs(level.min()) if begin else np.inf
        at, level = np.append(at, some), np.append(level, pool.race(some, limit))
        report()
    for _ in range(max(1, evaluations // size - 1)):
        if np.std(level) <= 1e-3 * abs(np.mean(level)):
            break
        best = int(np.argmin(level))
        pool.look_at(at[best], 1.0)
        others = np.array([rng.permutation(np.delete(np.arange(size), i))[:2] for i in range(size)])
        scale = rng.uniform(0.5, 1)
        mutant = place[best] + scale * (place[others[:, 0]] - place[others[:, 1]])
        outside = (mutant < 0) | (mutant > 1)
        mutant = np.where(outside, rng.random(mutant.shape), mutant)
        taken = rng.random(mutant.shape) < 0.7
        taken[np.arange(size), rng.integers(len(low), size=size)] = True
        trial = np.where(taken, mutant, place)
        some = pool.add(values(trial))
        found = pool.race(some, level)
        better = found <= level
        at = np.where(better, some, at)
        place, level = np.where(better[:, None], trial, place), np.where(better, found, level)
        report()


def complete_of(pool: Pool) -> tuple[_Array, _Array]:
    """The candidates that were judged completely, and their levels."""
    done = pool.complete
    return pool.values[done], pool.bounds[done]


def finer(coarse: Pool, grid: Grid) -> Pool:
    """A pool for more units and frequencies, whose risk is that at the best candidate of another one."""
    done = coarse.complete
    best = done[np.argmin(coarse.bounds[done])]
    return Pool(coarse.problem, grid, foreseen(coarse.grid, coarse.target[best], grid))


def foreseen(known: Grid, target: _Array, grid: Grid) -> _Array:
    """Targets (nodes, units) of a candidate as those of the nearest unit and frequency of another grid, where its
    targets (nodes, units, states) are known."""
    node = np.abs(grid.nodes[:, None] - known.nodes).argmin(axis=1)
    apart = grid.shares[:, :, None] - known.shares[:, None, :]
    unit = np.square(apart).sum(axis=0).argmin(axis=1)
    return np.asarray(target.max(axis=2)[np.ix_(node, unit)])


def refined(pool: Pool, candidates: _Array, levels: _Array, progress: door.Progress | None) -> None:
    """Find the best candidate, and descend from it; at least one candidate is evaluated for all (frequency, unit)
    pairs.

    More units and frequencies hardly lower a level, so the known levels of candidates count as lower bounds. Steps
    use only the active pairs, which are those of the greatest risk. The best candidates are then evaluated for all
    pairs, and pairs that raise a level become active.
    """
    low, high = np.array(list(pool.problem.free.values()), dtype=float).T
    pool.add(*_promising(candidates, levels, high - low, 64))
    if progress is not None:
        progress(0.7, "best candidates")
    here = _least(pool, pool.first(max(pool.few, pool.risk.size // 4)))
    turns = TURNS if pool.risk.size <= MANY else 2
    for turn in range(turns):
        if progress is not None:
            progress(0.7 + 0.3 * turn / turns, "steps down the gradient")
        pool.look_at(here, 1.0)
        last = descended(pool, here, pool.first(pool.few))
        if last == here and pool.known[here].all():
            return
        here = _least(pool, np.ones(pool.risk.shape, bool))


def _below(pool: Pool, level: float, other: float) -> bool:
    """Whether a level is below another one by more than candidates of a pool are worth."""
    share = SETTLED if pool.risk.size <= MANY else ROUGHLY
    return level < other - share * abs(other)


def _least(pool: Pool, pairs: _Mask) -> int:
    """The best candidate, judged by some pairs (nodes, units) at least: no other one is better by more than
    candidates are worth, see `_below`."""
    while True:
        level = pool.bounds
        here = int(np.argmin(level))
        done = np.flatnonzero((pool.known[: len(level)] | ~pairs).all(axis=(1, 2)))
        if len(done):
            best = int(done[np.argmin(level[done])])
            if not _below(pool, level[here], level[best]):
                return best
        others = np.delete(level, here)
        pool.race(np.array([here]), others.min(initial=np.inf), pairs, 32)
        pool.look_at(here)


def descended(pool: Pool, here: int, active: _Mask, steps: int = 8) -> int:
    """Step from a candidate so as to reduce the largest of the linearized targets, within a trust region; return
    the candidate that is best for the active pairs.

    Each step is a linear program over the worst units. The level jumps where motions appear or vanish: after the
    optimum of the linear program, some other points are tried at which the linearized targets are also lower;
    without derivatives, only random points are tried.
    """
    linprog = scipy("optimize", "a design", "design").linprog

    problem, rng = pool.problem, np.random.default_rng(len(pool.values))
    low, high = np.array(list(problem.free.values()), dtype=float).T
    whole = [name in problem.whole for name in problem.free]
    k, radius, slopes = len(low), 0.05, None
    worse: list[_Array] = []
    for _ in range(0 if all(whole) else steps):
        if slopes is None:
            found = gradients(problem, pool.grid, pool.values[here], pool.target[here])
            values = np.array([value for value, _ in found])
            slopes = np.array([[each[name] for name in problem.free] for _, each in found])
        at, level = pool.values[here], pool.bounds[here]
        reach = np.where(whole, 0, radius * (high - low))
        least, most = np.maximum(low - at, -reach), np.minimum(high - at, reach)
        tried = rng.uniform(least, most, (8 * OTHERS, k))
        if len(values):
            solved = linprog(
                np.append(np.zeros(k), 1.0), A_ub=np.hstack([slopes, -np.ones((len(values), 1))]), b_ub=-values,
                bounds=[*zip(least, most, strict=True), (None, None)],
            )  # fmt: skip
            if solved.status != 0 or not _below(pool, solved.x[-1], level):
                break
            lower = (values + tried @ slopes.T).max(axis=1) < level
            tried = np.vstack([solved.x[:k], tried[lower][:OTHERS]])
        start = here
        for share in tried[: 1 + OTHERS] / (high - low):
            # a point nearer to one that was worse than to the present one is likely to be worse
            if any(np.sum((share - other) ** 2) < np.sum(share**2) for other in worse):
                continue
            there = pool.add((at + share * (high - low))[None])
            if pool.race(there, level, active, 4)[0] < level:
                here, slopes = int(there[0]), None
                worse = [other - share for other in worse]
                break
            worse.append(share)
        radius *= 0.4 if here == start else 1.5
    return here


def gradients(
    problem: Problem, grid: Grid, here: _Array, target: _Array, most: int = 6
) -> list[tuple[float, dict[str, float]]]:
    """Targets of the worst units of a candidate (free,), and their derivatives with respect to the parameters;
    derivatives with respect to free parameters are finite.

    Empty if the units have no periodic motions that can be followed.

    Parameters
    ----------
    target : ndarray (nodes, units, states)
        Targets, as far as they are known.
    """
    level = problem.levels(target[None])[0]
    order = np.argsort(np.where(target <= level, -target, np.inf), axis=None)[: 4 * most]
    found: list[tuple[float, dict[str, float]]] = []
    units, load = problem.units(here, grid.shares)
    for node, unit, state in zip(*np.unravel_index(order, target.shape), strict=True):
        value = float(target[node, unit, state])
        if not value > 0.95 * level or len(found) == most:
            break
        if any(abs(value - other) < 1e-9 for other, _ in found):
            continue
        slopes = problem.host.slopes(
            {name: float(each[unit]) for name, each in units.items()}, grid.nodes[node], float(load[unit]),
            grid.places[:, state],
        )  # fmt: skip
        if slopes is not None and all(np.isfinite(slopes[name]) for name in problem.free):
            found.append((value, slopes))
    return found


def _even_start(dimensions: int, size: int, rng: np.random.Generator) -> _Array:
    """Shares (size, dimensions) of the first candidates of the global search: the centre, and points spread
    evenly."""
    qmc = scipy("stats", "a design", "design").qmc

    shares = qmc.Halton(dimensions, seed=rng).random(size)
    shares[0] = 0.5
    return np.asarray(shares)


def _promising(
    candidates: _Array, levels: _Array, width: _Array, many: int
) -> tuple[_Array, _Array]:
    """Some of the best candidates, not too close to each other, and their levels."""
    chosen: list[int] = []
    for number in np.argsort(levels, kind="stable"):
        apart = np.abs(candidates[number] - candidates[chosen]) / width
        if np.all(np.max(apart, axis=1, initial=0) > 0.02):
            chosen.append(int(number))
        if len(chosen) == many:
            break
    return candidates[chosen], levels[chosen]


def part_of(
    progress: door.Progress | None, begin: float, share: float, whole: float
) -> door.Progress | None:
    """The progress of a part of the work."""
    if progress is None:
        return None
    return lambda done, note: progress((begin + done * share) / whole, note)
