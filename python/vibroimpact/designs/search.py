"""The search for a design: global searches on few units, then descent along the gradients of the worst units."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ..base.libraries import scipy
from ..results import door
from .order import Order
from .pool import Grid, Pool, penalised
from .problem import Problem

_Array = NDArray[np.float64]
_Indices = NDArray[np.intp]
#: Largest relative difference of the levels of two searches that agree, and largest difference of their designs,
#: as a share of the ranges. Searches that end at different designs agree only if their levels differ by less than
#: the last number: with many local minima, levels may nearly agree by chance.
AGREEMENT, NEAR, EQUAL = 0.02, 0.02, 0.002
#: Relative gain below which a better candidate is not worth its evaluation.
SETTLED = 5e-4
#: The same before the descent, or if there are more than `MANY` runs; and half of the share within which a search
#: that comes near the best level ends.
ROUGHLY, MANY = 5e-3, 600
#: Number of candidates around which a search continues, and number of points tried in a step around each of them.
HEADS, TRIALS = 6, 6
#: With fewer pairs of a frequency and a unit than this, each unit has more initial states, for twice as many runs
#: in all, but at most `MOST`. Otherwise some candidates appear best by chance: their runs miss a bad attractor.
LEAST, MOST = 280, 200
#: Number of runs from other initial states by which the best candidates are verified, and the least share of the
#: runs at a frequency that may be above the level.
VERIFIED, RARE = 4000, 0.005
#: Number of runs by which the best candidates of repeated searches are judged if those leave the level uncertain.
SETTLING = 10 * VERIFIED
#: Number of steps after which the better half of these candidates is kept, and of all steps.
HALVED, STEPS = 3, 12
#: Number of descents by the worst runs of a candidate, each followed by a judgement by all runs.
TURNS = 4


@dataclass
class Archive:
    """All candidates of some searches.

    Attributes
    ----------
    values : list of ndarray (free,)
    level : list of float
        Level of all units, with a penalty for a design above its limits; of candidates that were not evaluated for
        all runs, a lower bound of it.
    runs : list of int
        Number of runs by which they were evaluated.
    nominal, excess, worst : list of float
        Level of the unit without deviations, level of the largest ratio of a figure to its limit, and the largest
        target; NaN for candidates that were not evaluated for all runs.
    searches : list of (int, float)
        For each search: the number of its candidates, and the best level.
    stopped : bool
        Whether Ctrl-C ended the searches.
    refuted : str
        What samples of the best candidate contradict, "level" or "limits"; empty if neither or not drawn.
    contradicted : bool or None
        Whether these samples contradict the level; None if they do not check it.
    grid, targets : Grid, ndarray (nodes, units, states)
        Of the best candidate.
    """

    values: list[_Array] = field(default_factory=list)
    level: list[float] = field(default_factory=list)
    runs: list[int] = field(default_factory=list)
    nominal: list[float] = field(default_factory=list)
    excess: list[float] = field(default_factory=list)
    worst: list[float] = field(default_factory=list)
    searches: list[tuple[int, float]] = field(default_factory=list)
    stopped: bool = False
    refuted: str = ""
    contradicted: bool | None = None
    grid: Grid | None = None
    targets: _Array | None = None

    def add(self, pool: Pool) -> None:
        """Adds the candidates of a further search, of which one at least was evaluated for all runs."""
        done = pool.complete
        found = np.full((4, len(pool.values)), np.nan)
        found[1] = pool.bounds
        found[:, done] = levels_of(pool.problem, pool.target[done], pool.excess[done])
        # figures from other initial states may be worse
        found[1, done] = pool.bounds[done]
        if pool.other is not None:
            for one in pool.lucky:
                found[2:, one] = np.maximum(found[2:, one], _figures(pool.other, pool.twins[one]))
        best = int(done[np.argmin(found[1, done])])
        if not self.level or found[1, best] < self.level[self.best]:
            self.grid, self.targets = pool.grid, pool.target[best]
        self.values.extend(pool.values)
        self.runs.extend(map(int, pool.judged))
        for name, numbers in zip(("nominal", "level", "excess", "worst"), found, strict=True):
            getattr(self, name).extend(map(float, numbers))
        self.searches.append((len(pool.values), float(found[1, best])))

    def settle(self, problem: Problem) -> bool:
        """If the level of the best candidate is uncertain, judge those that may be the best by `SETTLING` runs.

        Where motions are chaotic, a level depends on the initial states, and the lowest one of many candidates is
        too low by chance. Their level becomes the one from these states if it is higher. Returns whether levels
        were settled.
        """
        grid = self.grid
        if grid is None or not _uncertain(problem, grid, self.values[self.best]):
            return False
        more, least = elsewhere(problem, grid, many=SETTLING), np.inf
        level = np.where(self.complete, self.level, np.inf)
        judged: list[int] = []
        while (here := int(np.argmin(level))) not in judged:
            twin = int(more.add(self.values[here][None])[0])
            level[here] = max(
                level[here], more.race(np.array([twin]), least, more.order(twin), 8)[0]
            )
            more.look_at(twin, 0.5 if judged else 1.0)
            judged.append(here)
            least = min(least, level[here])
        one = self.values[here][None]
        targets, _ = problem.outcomes(one, grid.shares, grid.nodes, grid.places)
        # all at once, so that an interrupted comparison leaves the levels as they were
        self.targets = targets[0]
        for twin, each in enumerate(judged):
            self.level[each] = float(level[each])
            figures = np.maximum((self.excess[each], self.worst[each]), _figures(more, twin))
            self.excess[each], self.worst[each] = map(float, figures)
        self.searches = [
            (many, self.level[self.best_of(number)])
            for number, (many, _) in enumerate(self.searches)
        ]
        return True

    def promising(self, width: _Array, most: int = HEADS) -> _Array:
        """The best candidates (n, free) of all searches, those evaluated for all runs first."""
        order = np.lexsort((np.array(self.level), ~self.complete))
        return _apart(np.array(self.values)[order], width, most)

    def of(self, number: int) -> slice:
        """The candidates of a search."""
        begin = sum(many for many, _ in self.searches[:number])
        return slice(begin, begin + self.searches[number][0])

    def best_of(self, number: int) -> int:
        """Index of the best candidate of a search."""
        some = self.of(number)
        level = np.where(self.complete[some], self.level[some], np.inf)
        return int(some.start + np.argmin(level))

    @property
    def complete(self) -> NDArray[np.bool_]:
        """Whether candidates were evaluated for all runs."""
        runs = np.array(self.runs)
        return np.asarray(runs == runs.max())

    def converged(self, problem: Problem) -> bool | None:
        """Whether three searches ended at the best design, see `alike`, and samples do not contradict its level.

        False if they do, whatever the number of searches; otherwise None for fewer, since two may agree by chance.
        """
        return False if self.contradicted else self.agree(problem)

    def agree(self, problem: Problem) -> bool | None:
        """Whether three searches ended at the best design; None for fewer."""
        if len(self.searches) < 3:
            return None
        ends = [self.best_of(number) for number in range(len(self.searches))]
        return sum(alike(problem, self.at(end), self.at(self.best)) for end in ends) > 2

    def at(self, candidate: int) -> tuple[float, _Array]:
        """The level and the values of a candidate."""
        return self.level[candidate], self.values[candidate]

    @property
    def best(self) -> int:
        """Index of the best candidate."""
        return int(np.argmin(np.where(self.complete, self.level, np.inf)))

    @property
    def front(self) -> NDArray[np.bool_]:
        """For each candidate, whether it was evaluated for all runs and no other one is better in both levels; of
        equal candidates the first one."""
        pairs = np.stack([self.nominal, self.level], axis=1)
        some = np.flatnonzero(self.complete)
        _, first = np.unique(np.array(self.values)[some], axis=0, return_index=True)
        some = np.sort(some[first])
        pairs = pairs[some]
        best = [
            not (np.all(pairs <= pair, axis=1) & np.any(pairs < pair, axis=1)).any()
            for pair in pairs
        ]
        front = np.zeros(len(self.level), bool)
        front[some[best]] = True
        return front

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
    frequencies = np.unique(np.linspace(*problem.band, nodes))
    if problem.quick:
        states = max(states, min(MOST, 2 * (LEAST // (len(frequencies) * units))))
    places = 2 * qmc.Sobol(4, seed=1).random(1 << (states - 1).bit_length())[:states].T - 1
    return Grid(shares, frequencies, places)


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


def search(
    problem: Problem, order: Order, progress: door.Progress | None, earlier: Archive | None = None,
    begun: Archive | None = None,
) -> Archive:  # fmt: skip
    """Run the searches; return the candidates evaluated for all units. The best one has the lowest level.

    Independent searches are run one after another until three of them end at the best design: searches that
    missed the best region are unlikely to end at the same design. As long as they do not, their number of
    candidates doubles after every third search.

    Parameters
    ----------
    order : Order
        Units, frequencies and initial states for which candidates are evaluated, see `grid`.
    earlier : Archive, optional
        Searches with other units: the first search starts from their best candidates. The others start anew, so
        that at least two of the three that must agree are independent of earlier ones.
    begun : Archive, optional
        Searches with the same units, to which as many are added.
    """
    archive, risk, other, states = begun or Archive(), None, None, order.states
    if earlier is not None and earlier.grid is not None:
        # with fewer states than these, more attractors would not count, see `elsewhere`
        states = earlier.grid.places.shape[1]
    fine = grid(problem, order.specimens, order.nodes, states)
    if earlier is not None and earlier.grid is not None and earlier.targets is not None:
        risk = foreseen(earlier.grid, earlier.targets, fine)
    first = len(archive.searches)
    for number in range(first, first + order.searches):
        pool = Pool(problem, fine, risk)
        pool.other = elsewhere(problem, fine, other.risk if other else None)
        # the random numbers depend only on the seed of the order and the number of the search; those of a repeated
        # set also on its number of units, which differs from set to set
        rng = np.random.default_rng(
            (order.seed, number) if earlier is None else (order.seed, number, order.specimens)
        )
        report = part_of(progress, number - first, 1, order.searches)
        try:
            if earlier is not None and not number:
                pool.add(earlier.promising(np.subtract(*problem.ends[::-1])))
            else:
                many = max(order.evaluations, 8 * len(problem.free))
                doubled = (number - first) // 3
                pool.add(problem.at(_even_start(len(problem.free), many << doubled, rng)))
            explored(pool, rng, report)
            refined(pool, rng, archive.at(archive.best) if archive.level else None, report)
            archive.add(pool)
        except KeyboardInterrupt:
            # if the first search was stopped: its candidates so far
            if not archive.level:
                if not len(pool.complete):
                    raise
                archive.add(pool)
            archive.stopped = True
        if archive.agree(problem) or archive.stopped:
            break
        risk, other = pool.risk, pool.other
    return archive


def explored(pool: Pool, rng: np.random.Generator, progress: door.Progress | None) -> None:
    """A global search from the candidates of a pool.

    The candidates are compared by a few runs and the best third is kept; this is repeated with more runs until few
    are left. Then random steps are made around these, judged by the runs that are worst where a step begins. The
    first steps are as long as evenly spread candidates would be apart: from the few best ones of an earlier search
    they reach regions that were bad with its units.
    """
    if not pool.risk.any():
        # a candidate that is judged by all runs shows which runs are at risk
        pool.race(np.arange(1), np.inf)
        pool.look_at(0, 1.0)
    alive, runs = np.arange(len(pool.values)), 3 * pool.least
    while len(alive) > HEADS and runs < 3 * pool.risk.size:
        told(progress, 0.1, "global search")
        pool.learn(alive, pool.first(runs))
        alive = alive[np.argsort(pool.bounds[alive], kind="stable")]
        alive = alive[: max(HEADS, len(alive) // 3)]
        for one in alive[2::-1]:
            pool.look_at(one)
        runs *= 3
    width = np.subtract(*pool.problem.ends[::-1])
    best = _apart(pool.values[alive[np.argsort(pool.bounds[alive], kind="stable")]], width, HEADS)
    heads = np.array([alive[(pool.values[alive] == one).all(axis=1)][0] for one in best])
    radius = np.full(len(heads), max(0.02, len(pool.values) ** (-1 / pool.values.shape[1])))
    for step in range(STEPS):
        told(progress, 0.2 + 0.4 * step / STEPS, "global search")
        heads, radius = stepped(pool, heads, radius, rng)
        if step % HALVED == HALVED - 1:
            kept = np.argsort(pool.bounds[heads], kind="stable")[: (len(heads) + 1) // 2]
            heads, radius = heads[kept], radius[kept]


def alike(
    problem: Problem,
    one: tuple[float, _Array],
    best: tuple[float, _Array],
    share: float = AGREEMENT,
) -> bool:
    """Whether a level and its design agree with the best ones: a level within a share and a design within `NEAR`,
    or a level within `EQUAL`."""
    apart = abs(problem.shares(one[1]) - problem.shares(best[1])).max()
    share = share if apart <= NEAR else EQUAL
    return bool(one[0] <= best[0] + share * abs(best[0]))


def refined(
    pool: Pool, rng: np.random.Generator, best: tuple[float, _Array] | None,
    progress: door.Progress | None,
) -> None:  # fmt: skip
    """Find the best candidate of a pool, judged by all runs, and descend from it.

    There is no descent if it is close to the best one of other searches.
    """
    told(progress, 0.6, "best candidates")
    here = verified(pool, ROUGHLY)
    found = float(pool.bounds[here]), pool.values[here]
    if best is not None and best[0] <= found[0] and alike(pool.problem, found, best, 2 * ROUGHLY):
        return
    turns = TURNS if pool.risk.size <= MANY else TURNS // 2
    for turn in range(turns):
        told(progress, 0.7 + 0.3 * turn / turns, "steps down the gradient")
        pool.look_at(here, 1.0)
        if descended(pool, here, rng) == here:
            break
        before, here = here, verified(pool, _settled(pool))
        if here == before:
            break


def stepped(
    pool: Pool, heads: _Indices, radius: _Array, rng: np.random.Generator
) -> tuple[_Indices, _Array]:
    """The best of some random points near each of some candidates, or the candidate itself; and the radius
    (heads,) of the next points, as a share of the ranges."""
    problem, few = pool.problem, pool.few
    order = np.array([pool.order(head)[:few] for head in heads])
    for head, own in zip(heads, order, strict=True):
        pool.race(head[None], np.inf, own)
    places = problem.shares(pool.values[heads])[:, None]
    size = len(heads), TRIALS, places.shape[2]
    trials = np.clip(places + radius[:, None, None] * rng.uniform(-1, 1, size), 0, 1)
    there = pool.add(problem.at(trials.reshape(-1, size[2])))
    owner = np.repeat(np.arange(len(heads)), TRIALS)
    found = pool.race(there, pool.bounds[heads][owner], order[owner], 8).reshape(size[:2])
    best = found.argmin(axis=1)
    better = found.min(axis=1) < pool.bounds[heads]
    there = there.reshape(size[:2])[np.arange(len(heads)), best]
    return np.where(better, there, heads), radius * np.where(better, 1.2, 0.6)


def _settled(pool: Pool) -> float:
    """The share of a level below which a gain is not worth the evaluations that it takes."""
    return SETTLED if pool.risk.size <= MANY else ROUGHLY


def verified(pool: Pool, share: float) -> int:
    """The best candidate, as `_least`, of those that are as good from other initial states.

    If a bad attractor makes many candidates unreliable, some of them appear best by chance. Their levels become
    those from these states.
    """
    while True:
        here = _least(pool, share)
        known = float(pool.bounds[here])
        limit = known + AGREEMENT * abs(known)
        if not pool.problem.quick:
            return here
        if other_level(pool, here, limit) <= limit and pool.bounds[here] == known:
            return here


def other_level(pool: Pool, candidate: int, limit: float) -> float:
    """The level of a candidate from other initial states, or a lower bound of it that is above a limit.

    From then on it is the level of the candidate if it is above the limit.
    """
    if pool.other is None:
        pool.other = elsewhere(pool.problem, pool.grid)
    other = pool.other
    if candidate not in pool.twins:
        pool.twins[candidate] = int(other.add(pool.values[[candidate]])[0])
    twin = pool.twins[candidate]
    level = float(other.race(np.array([twin]), limit, other.order(twin), 8)[0])
    other.look_at(twin)
    if level > limit or candidate in pool.lucky:
        pool.lucky.add(candidate)
        pool.bounds[candidate] = max(level, pool.bounds[candidate])
    return level


def _uncertain(problem: Problem, grid: Grid, value: _Array) -> bool:
    """Whether the level of a candidate from other initial states depends on these by a part of `AGREEMENT`.

    The number of runs that rare attractors lift above a level scatters by the root of its mean: the levels that
    are exceeded by twice this root more, or fewer, runs are compared.
    """
    other = elsewhere(problem, grid)
    other.race(other.add(value[None]), np.inf)
    runs = -np.sort(-other.target[0].reshape(len(grid.nodes), -1), axis=1)
    apart = math.ceil(2 * math.sqrt(max(1, RARE * runs.shape[1])))
    most = runs[:, max(0, other.spare - apart)].max()
    least = runs[:, min(other.spare + apart, runs.shape[1] - 1)].max()
    return bool(most > least + AGREEMENT / 2 * abs(least))


def _figures(pool: Pool, candidate: int) -> _Array:
    """Level of the excess, and the greatest target, of a candidate by the runs that are known."""
    some = [candidate]
    _, _, over, worst = levels_of(pool.problem, pool.target[some], pool.excess[some])
    return np.concatenate([over, worst])


def elsewhere(
    problem: Problem, grid: Grid, risk: _Array | None = None, many: int = VERIFIED
) -> Pool:
    """A pool for the same units and frequencies, but about `many` runs from other initial states."""
    units, states = grid.shares.shape[1], -(-many // (len(grid.nodes) * grid.shares.shape[1]))
    few = Pool(problem, grid)
    # as rare as the grid can show
    many, rare = units * states - 1, max(RARE, 1 / (units * grid.places.shape[1]))
    if problem.weighted:
        spare = int(max(1 - problem.quantile, rare) * many)
    else:
        spare = few.spare * states + int(rare * many)
    # the half keeps the quantile away from the next run
    quantile = min(1.0, (many - spare - 0.5) / many) if spare else 1.0
    places = np.random.default_rng(2).uniform(-1, 1, (4, states))
    return Pool(
        replace(problem, weighted=True, quantile=quantile), replace(grid, places=places), risk
    )


def _least(pool: Pool, share: float) -> int:
    """The best candidate, judged by all runs: no other one is better by more than a share of its level."""
    new = np.flatnonzero(np.isneginf(pool.bounds))
    pool.learn(new, pool.first(pool.few))
    while True:
        level, done = pool.bounds, pool.complete
        best = int(done[np.argmin(level[done])]) if len(done) else -1
        limit = level[best] - share * abs(level[best]) if len(done) else np.inf
        others = np.setdiff1d(np.flatnonzero(level < limit), done)
        if not len(others):
            return best
        # always the most promising ones: none is judged further than the level that is found
        others = others[np.argsort(level[others], kind="stable")[:2]]
        pool.go_on(others)
        pool.look_at(others[np.argmin(pool.bounds[others])])


def descended(pool: Pool, here: int, rng: np.random.Generator, steps: int = 8) -> int:
    """Step from a candidate so as to reduce the largest of the linearized targets, within a trust region; return
    the candidate that is best for the worst runs.

    The level jumps where motions appear or vanish: besides the best point by the linearized targets, some others
    are tried at which these are also lower; without derivatives, only random points are tried.
    """
    problem = pool.problem
    low, high = problem.ends
    k, radius, found = len(low), 0.05, None
    for _ in range(steps):
        if found is None:
            found = gradients(problem, pool.grid, pool.values[here], pool.target[here])
            values = np.array([value for value, _ in found])
            slopes = np.array([[each[name] for name in problem.free] for _, each in found])
        at, level = pool.values[here], pool.bounds[here]
        reach = radius * (high - low)
        tried = np.clip(at + reach * rng.uniform(-1, 1, (TRIALS, k)), low, high)
        if len(values):
            points = tried
            least, most = np.maximum(low, at - reach), np.minimum(high, at + reach)
            for closer in (1, 0.1, 0.01):
                # beyond the reach, so that points lie on the sides and at the corners as well
                about = points[0] if closer < 1 else at
                more = about + 1.5 * closer * reach * rng.uniform(-1, 1, (256, k))
                points = np.vstack([points, np.clip(more, least, most)])
                linear = (values + (points - at) @ slopes.T).max(axis=1)
                points = points[np.argsort(linear, kind="stable")]
            linear.sort()
            if not linear[0] < level - _settled(pool) * abs(level):
                break
            tried = np.vstack([points[0], rng.permutation(points[linear < level])[: TRIALS - 1]])
        # the best point alone, and the others if it is not better
        for some in (tried[:1], tried[1:]):
            there = pool.add(problem.rounded(some))
            limit = level - _settled(pool) * abs(level)
            levels = pool.race(there, limit, pool.order(here), 4)
            if levels.min(initial=np.inf) < limit:
                here, found = int(there[np.argmin(levels)]), None
                break
        radius *= 1.5 if found is None else 0.4
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


def _apart(candidates: _Array, width: _Array, most: int) -> _Array:
    """The first ones of some candidates (n, free) that are not too close to each other."""
    chosen = candidates[:1]
    for one in candidates[1:]:
        if len(chosen) < most and (np.abs((one - chosen) / width).max(axis=1) > 0.02).all():
            chosen = np.vstack([chosen, one])
    return chosen


def foreseen(known: Grid, target: _Array, grid: Grid) -> _Array:
    """Targets (nodes, units, states) of a candidate as the worst ones of the nearest unit and frequency of another
    grid, where its targets (nodes, units, states) are known."""
    node = np.abs(grid.nodes[:, None] - known.nodes).argmin(axis=1)
    apart = grid.shares[:, :, None] - known.shares[:, None, :]
    unit = np.square(apart).sum(axis=0).argmin(axis=1)
    worst = target.max(axis=2)[np.ix_(node, unit)]
    return np.repeat(worst[:, :, None], grid.places.shape[1], axis=2)


def part_of(
    progress: door.Progress | None, begin: float, share: float, whole: float
) -> door.Progress | None:
    """The progress of a part of the work."""
    if progress is None:
        return None
    return lambda done, note: progress((begin + done * share) / whole, note)


def told(progress: door.Progress | None, done: float, note: str) -> None:
    """Calls the progress, if there is one."""
    if progress is not None:
        progress(done, note)
