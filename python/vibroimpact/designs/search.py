"""The search for a design: global searches on few units, then descent along the gradients of the worst units."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..base.libraries import scipy
from ..results import door
from .order import Order
from .problem import Problem

_Array = NDArray[np.float64]
#: Penalty on the level of a design per unit of excess of a figure over its limit.
PENALTY = 10.0
#: Largest relative difference of the levels of two searches that agree.
AGREEMENT = 0.02


@dataclass
class Archive:
    """All candidates that were judged by all units of the search.

    Attributes
    ----------
    values : list of ndarray (free,)
    nominal, level : list of float
        Level of the unit without deviations, and level of all units; a design above its limits has a penalty.
    excess, worst : list of float
        Level of the largest ratio of a figure to its limit, and the largest target.
    sensitivity : dict
        Derivatives of the target of the worst unit of the best candidate with respect to its parameters.
    searches : list of (int, float)
        For each search: the number of its candidates here, and the best level.
    stopped : bool
        Whether Ctrl-C ended the searches.
    judged_again : bool
        Whether the candidates are those of searches by fewer units.
    targets : ndarray (nodes, units, states) or None
        Targets of the best candidate.
    """

    values: list[_Array] = field(default_factory=list)
    nominal: list[float] = field(default_factory=list)
    level: list[float] = field(default_factory=list)
    excess: list[float] = field(default_factory=list)
    worst: list[float] = field(default_factory=list)
    sensitivity: dict[str, float] = field(default_factory=dict)
    searches: list[tuple[int, float]] = field(default_factory=list)
    stopped: bool = False
    judged_again: bool = False
    targets: _Array | None = None

    def add(self, other: Archive) -> None:
        """Adds the candidates of a further search."""
        if not self.level or min(other.level) < min(self.level):
            self.sensitivity = other.sensitivity
        for name in ("values", "nominal", "level", "excess", "worst"):
            getattr(self, name).extend(getattr(other, name))
        self.searches.append((len(other.level), min(other.level)))

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


@dataclass(frozen=True)
class Grid:
    """The units, frequencies and initial states by which candidates are judged."""

    shares: _Array
    nodes: _Array
    places: _Array


def grid(problem: Problem, units: int, nodes: int, states: int) -> Grid:
    """Units from a Sobol sequence, the first without deviations, and frequencies including both ends of the band.

    They do not depend on the seed of a design: levels of designs with different seeds can be compared.
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
        level = problem.levels(target[:, :, units])
        # a target can be negative: the damping
        found.append(level + np.abs(level) * PENALTY * np.maximum(0, over - 1))
    return *found, over, target.max(axis=(1, 2, 3))


def search(problem: Problem, order: Order, progress: door.Progress | None) -> Archive:
    """Run the searches; returns the candidates judged by all units. The best one has the lowest level.

    Independent global searches are run one after another until the best levels of three of them agree: searches
    that missed the best region are unlikely to end at one level.

    Parameters
    ----------
    order : Order
        Units, nodes and initial states by which the best candidates are judged, see `grid`; the global search uses
        few units.
    """
    fine, coarse = grids(problem, order)
    archive = Archive()
    for number in range(order.searches):
        report = part_of(progress, number, 1, order.searches)
        tried, best = Archive(), Archive()
        try:
            found = explored(problem, coarse, order, number, report, tried)
            refined(problem, fine, *found, report, best)
            archive.add(best)
        except KeyboardInterrupt:
            # if the first search was stopped: its candidates, judged by all units or by few
            if not archive.level:
                if not tried.level:
                    raise
                archive.add(best if best.level else tried)
            archive.stopped = True
        if archive.agree or archive.stopped:
            break
    return archive


def explored(
    problem: Problem, coarse: Grid, order: Order, number: int, progress: door.Progress | None,
    archive: Archive,
) -> tuple[_Array, _Array]:  # fmt: skip
    """The candidates of one global search by differential evolution, and their levels; all are added to the
    archive.

    Its random numbers depend only on the seed of the order and the number of the search.
    """
    differential_evolution = scipy("optimize", "a design", "design").differential_evolution

    low, high = np.array(list(problem.free.values()), dtype=float).T
    evaluations = max(order.evaluations, 8 * len(low))
    size = max(8, 8 * len(low))

    def level(shares: _Array) -> _Array:
        candidates = np.atleast_2d(shares.T)
        # the first ones in small parts, so that Ctrl-C soon finds some that are judged
        ends = [1, *range(5, len(candidates), 4)] if not archive.level else []
        for some in np.split(candidates, [end for end in ends if end < len(candidates)]):
            _judge(problem, coarse, some, archive)
        done = len(archive.level) / (evaluations + size)
        if progress is not None:
            progress(min(0.7, 0.7 * done), "global search")
        # an infinite level, from failed runs, would make differences and variances of levels undefined
        return np.minimum(archive.level[-len(candidates) :], 1e150)

    try:
        rng = np.random.default_rng((order.seed, number))
        differential_evolution(
            level, list(zip(low, high, strict=True)), vectorized=True, updating="deferred", polish=False,
            popsize=size, init=_even_start(low, high, size, rng), seed=rng, tol=1e-3,
            maxiter=max(1, evaluations // size - 1), integrality=[name in problem.whole for name in problem.free],
        )  # fmt: skip
    except (RuntimeError, TypeError) as error:
        raise cause_of(error) from None
    return np.array(archive.values), np.array(archive.level)


def cause_of(error: BaseException) -> BaseException:
    """The first of a chain of errors: SciPy replaces a ValueError or TypeError by its own."""
    return error if error.__cause__ is None else cause_of(error.__cause__)


def refined(
    problem: Problem, fine: Grid, candidates: _Array, levels: _Array, progress: door.Progress | None,
    archive: Archive,
) -> None:  # fmt: skip
    """Judge the best candidates by all units of a grid, descend from there, and add the results to the archive.

    More units and frequencies hardly lower a level: a candidate is skipped if its known level is above a level
    already reached.
    """
    low, high = np.array(list(problem.free.values()), dtype=float).T
    promising, known = _promising(candidates, levels, high - low, 8)
    for begin in range(0, len(promising), 2):
        if begin and known[begin] > min(archive.level):
            break
        _judge(problem, fine, promising[begin : begin + 2], archive)
        if progress is not None:
            progress(0.7 + 0.1 * begin / len(promising), "best candidates")
    descend(problem, fine, archive, low, high, progress)


def _even_start(low: _Array, high: _Array, size: int, rng: np.random.Generator) -> _Array:
    """First candidates of the global search: the centre, and points spread evenly."""
    qmc = scipy("stats", "a design", "design").qmc

    shares = qmc.Halton(len(low), seed=rng).random(size)
    shares[0] = 0.5
    return np.asarray(low + (high - low) * shares)


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


def _judge(problem: Problem, fine: Grid, candidates: _Array, archive: Archive) -> None:
    """Adds candidates to the archive."""
    outcomes = problem.outcomes(candidates, fine.shares, fine.nodes, fine.places)
    _add(problem, candidates, *outcomes, archive)


def _add(
    problem: Problem, candidates: _Array, target: _Array, excess: _Array, archive: Archive
) -> None:
    """Adds candidates with known targets and excesses to the archive."""
    before = len(archive.level)
    archive.values.extend(candidates)
    found = levels_of(problem, target, excess)
    for name, numbers in zip(("nominal", "level", "excess", "worst"), found, strict=True):
        getattr(archive, name).extend(map(float, numbers))
    if archive.best >= before:
        archive.targets = target[archive.best - before]


def _try(problem: Problem, fine: Grid, candidate: _Array, archive: Archive) -> bool:
    """Adds a candidate to the archive and returns whether it is the best one.

    The frequencies at which the best candidate so far performs worst are evaluated first, beginning with its worst
    units. The level is that of the worst frequency: a candidate that exceeds the best level there need not be
    evaluated at the others, and is not added.
    """
    assert archive.targets is not None
    order = np.argsort(-archive.targets.max(axis=(1, 2)), kind="stable")
    first = len(order) // 3
    best = min(archive.level)
    # a penalty raises levels above 0
    if first and best > 0:
        worst = archive.targets, order[:first]
        if _worst_units_exceed(problem, fine, candidate, *worst, best):
            return False
    parts = []
    for some in (order[:first], order[first:]):
        if len(some) == 0:
            continue
        parts.append(problem.outcomes(candidate[None], fine.shares, fine.nodes[some], fine.places))
        level = levels_of(problem, *parts[-1])[1][0]
        if len(parts) == 1 and first and 0 < best < level:
            return False
    back = np.argsort(order)
    target, excess = (np.concatenate(both, axis=1)[:, back] for both in zip(*parts, strict=True))
    best = archive.best
    _add(problem, candidate[None], target, excess, archive)
    return archive.best != best


def _worst_units_exceed(
    problem: Problem, fine: Grid, candidate: _Array, targets: _Array, nodes: NDArray[np.intp], best: float
) -> bool:  # fmt: skip
    """Whether a candidate exceeds a level on a few units alone: those with the largest targets of another
    candidate.

    The quantile with targets of -inf and excesses of 0 for the other units is a lower bound of its level.
    """
    units = fine.shares.shape[1]
    # as many units as may be above the quantile, and some more
    few = int(np.ceil((1 - problem.quantile) * units)) + units // 8 + 1
    if 2 * few > units:
        return False
    some = np.argsort(-targets[nodes].max(axis=(0, 2)), kind="stable")[:few]
    found = problem.outcomes(candidate[None], fine.shares[:, some], fine.nodes[nodes], fine.places)
    shape = 1, len(nodes), units, targets.shape[2]
    target, excess = np.full(shape, -np.inf), np.zeros(shape)
    target[:, :, some], excess[:, :, some] = found
    # a level above 0 increases with both
    if not problem.levels(target)[0] > 0:
        return False
    return bool(levels_of(problem, np.maximum(target, 0), excess)[1][0] > best)


def descend(
    problem: Problem, fine: Grid, archive: Archive, low: _Array, high: _Array,
    progress: door.Progress | None, steps: int = 8,
) -> None:  # fmt: skip
    """Steps from the best candidate that reduce the largest of the linearized targets, within a trust region.

    Each step is a linear program over the worst units. The level jumps where motions appear or vanish; a step that
    does not lower it halves the region.
    """
    linprog = scipy("optimize", "a design", "design").linprog

    radius = 0.05
    active = active_slopes(problem, fine, archive)
    for step in range(steps):
        if active is None or radius < 1e-4:
            return
        if progress is not None:
            progress(0.8 + 0.2 * step / steps, "steps down the gradient")
        here = archive.values[archive.best]
        values, slopes = active
        k = len(here)
        reach = np.where([name in problem.whole for name in problem.free], 0, radius * (high - low))
        ends = zip(np.maximum(low - here, -reach), np.minimum(high - here, reach), strict=True)
        solved = linprog(
            np.append(np.zeros(k), 1.0), A_ub=np.hstack([slopes, -np.ones((len(values), 1))]), b_ub=-values,
            bounds=[*ends, (None, None)],
        )  # fmt: skip
        if solved.status != 0 or np.max(np.abs(solved.x[:k]) / (high - low)) < 1e-6:
            return
        if _try(problem, fine, here + solved.x[:k], archive):
            radius *= 1.5
            active = active_slopes(problem, fine, archive)
        else:
            radius *= 0.3


def active_slopes(
    problem: Problem, fine: Grid, archive: Archive, most: int = 6
) -> tuple[_Array, _Array] | None:
    """Targets of the worst units of the best candidate, and their derivatives with respect to the free parameters.

    None if they have no periodic motions that can be followed. The archive stores the sensitivities of the worst
    unit.
    """
    archive.sensitivity = {}
    here = archive.values[archive.best]
    assert archive.targets is not None
    target = archive.targets[None]
    level = problem.levels(target)[0]
    order = np.argsort(np.where(target[0] <= level, -target[0], np.inf), axis=None)[: 4 * most]
    values: list[float] = []
    slopes: list[_Array] = []
    units, load = problem.units(here, fine.shares)
    for node, unit, state in zip(*np.unravel_index(order, target.shape[1:]), strict=True):
        value = float(target[0, node, unit, state])
        if not value > 0.95 * level or len(values) == most:
            break
        if any(abs(value - other) < 1e-9 for other in values):
            continue
        gradient = problem.host.slopes(
            {name: float(each[unit]) for name, each in units.items()}, fine.nodes[node], float(load[unit]),
            fine.places[:, state],
        )  # fmt: skip
        if gradient is None:
            continue
        if not values:
            archive.sensitivity = {
                name: slope for name, slope in gradient.items() if np.isfinite(slope)
            }
        slope = np.array([gradient[name] for name in problem.free])
        if np.isfinite(slope).all():
            values.append(value)
            slopes.append(slope)
    return (np.array(values), np.array(slopes)) if values else None


def part_of(
    progress: door.Progress | None, begin: float, share: float, whole: float
) -> door.Progress | None:
    """The progress of a part of the work."""
    if progress is None:
        return None
    return lambda done, note: progress((begin + done * share) / whole, note)
