"""Design of an impact damper: clearance, mass and restitution for the best worst case."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import checks, door
from ..design_hosts import FIGURES, DecayHost, StructureHost
from ..design_hosts import TARGETS as OF_STRUCTURES
from ..design_problem import LIMITED, OscillatorHost, Problem, parameters_of
from ..design_search import Archive, grid, refined, search
from ..distribution import Uncertain, interval, uncertain
from ..errors import ParameterError, ParameterTypeError
from ..model import Oscillator, of_numbers
from ..namelist import keys_of
from ..noun import Noun
from ..performance import PARAMETERS
from ..status import VERDICT
from ..tables import Result, made

__all__ = ["Design", "design"]

_Array = NDArray[np.float64]
#: Parameters of an oscillator that can be free or uncertain.
NAMES = ("clearance", "mu", "xi", "restitution", "R1", "R2")
#: Confidence of all intervals, and parts of the band whose shares are stated.
CONFIDENCE, BANDS = 0.95, 10
#: Samples that are simulated at once.
CHUNK = 10_000
#: Samples by which the choice of units in the search is checked, and how often more units are taken.
FEW, ROUNDS = 2000, 2
#: The core's codes of verdicts.
CODE_OF = {verdict: code for code, verdict in VERDICT.items()}


@dataclass(frozen=True)
class Order:
    """What is asked for besides the problem.

    Attributes
    ----------
    target : str
    limit : float or None
    evaluations, specimens, nodes, states, samples, seed : int
    """

    target: str
    limit: float | None
    evaluations: int
    specimens: int
    nodes: int
    states: int
    samples: int
    seed: int

    @property
    def sign(self) -> int:
        """The damping is maximised: the search minimises it with the opposite sign."""
        return -1 if self.target == "damping" else 1


EXAMPLE = "--xi .0114 --mu .028 --restitution .75 --band 1 1.02 --free-clearance 20 40 --limit .55 --samples 1000"


class Design(Noun, study="design", example=EXAMPLE):
    """A design, and what it achieves.

    Attributes
    ----------
    values : dict
        The chosen values by name.
    ranges : dict
        The ranges (low, high) from which they were chosen.
    target, limit, quantile : str, float or None, float
        What was minimised (the damping: maximised), and what had to be reached by which share of the units.
    level : float
        The quantile of the target over the units of the search, at the worst frequency.
    excess : float
        The same of the greatest figure over its limit: above 1 no candidate met all limits.
    worst : float
        The worst target of all samples of the confirmation, and of the units of the search.
    samples, failed : int
        Samples of the confirmation, and those whose simulation was given up; these count as bad.
    probability : float
        Share of the samples within the limit and all other limits; NaN without samples.
    interval : (float, float)
        Its 95 % confidence interval, by Clopper and Pearson.
    bands : dict of ndarray
        The same for parts of the band: ``from, to, samples, good, probability, low, high, worst``. These intervals
        hold for all parts at once with 95 %. Shares of parts without samples are NaN.
    feasible : bool or None
        True if the lower ends of `interval` and of the intervals of all parts of the band are at least `quantile`,
        False if one of the upper ends is below it, None if the samples do not tell.
    spread : dict
        Least, middle and greatest clearance, xi, mu, R1 and R2 of the units; an error for a host that is a
        function.
    sensitivity : dict
        Derivatives of the target of the worst unit by its parameters; empty where it has no periodic motion.
    candidates, front : ndarray
        Structured arrays of all candidates that were judged by all units, and of those that no other one beats
        both in ``nominal`` (level of the unit without deviations) and ``level``.
    case : str
        The case as a namelist; empty for a host that is a function.
    """

    __slots__ = ("_asked",)
    _asked: tuple[Problem, Order] | None

    def __init__(self, result: Result, asked: tuple[Problem, Order] | None = None) -> None:
        super().__init__(result)
        object.__setattr__(self, "_asked", asked)

    def _one(self, name: str) -> Any:
        return self._result.column("design", name).decoded().item()

    def _list(self, table: str, name: str) -> list[Any]:
        values: list[Any] = self._result.column(table, name).decoded().tolist()
        return values

    @property
    def values(self) -> dict[str, float]:
        return dict(zip(self._list("chosen", "name"), self._list("chosen", "value"), strict=True))

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        ends = zip(self._list("chosen", "low"), self._list("chosen", "high"), strict=True)
        return dict(zip(self._list("chosen", "name"), ends, strict=True))

    @property
    def target(self) -> str:
        target: str = self._one("target")
        return target

    @property
    def limit(self) -> float | None:
        limit: float = self._one("limit")
        return None if math.isnan(limit) else limit

    @property
    def quantile(self) -> float:
        quantile: float = self._one("quantile")
        return quantile

    @property
    def level(self) -> float:
        level: float = self._one("level")
        return level

    @property
    def excess(self) -> float:
        excess: float = self._one("excess")
        return excess

    @property
    def worst(self) -> float:
        worst: float = self._one("worst")
        return worst

    @property
    def samples(self) -> int:
        samples: int = self._one("samples")
        return samples

    @property
    def failed(self) -> int:
        failed: int = self._one("failed")
        return failed

    @property
    def probability(self) -> float:
        probability: float = self._one("probability")
        return probability

    @property
    def interval(self) -> tuple[float, float]:
        return self._one("low"), self._one("high")

    @property
    def feasible(self) -> bool | None:
        return VERDICT[self._one("feasible")]

    @property
    def bands(self) -> dict[str, NDArray[Any]]:
        names = ("from", "to", "samples", "good", "probability", "low", "high", "worst")
        return {name: self._result.column("bands", name).decoded() for name in names}

    @property
    def ends(self) -> tuple[float, float]:
        """The ends of the band."""
        return self._one("first"), self._one("last")

    @property
    def spread(self) -> dict[str, tuple[float, float, float]]:
        """Least, middle and greatest clearance (d K/F0 of each load), xi, mu, R1 and R2 of the units.

        Those of normal distributions are 3 standard deviations from the middle.
        """
        if self._asked is None and not self.case:
            raise ParameterError(f"{self!r}: has no host, since it was read from a file")
        problem, order = self._asked or asked_by(self.osc, self.keys)
        if not isinstance(problem.host, OscillatorHost):
            raise ParameterError(
                f"target = {order.target!r} of the design: must be one of an Oscillator under a load"
            )
        values = {name: np.full(3, value) for name, value in self.values.items()}
        for name, item in problem.tolerance.items():
            values[name] = values.get(name, 0.0) + reach(item)
        # the least clearance in F0/K is that of the greatest load
        load = reach(problem.load)[::-1]
        numbers = parameters_of(problem.host.osc, problem.host.clearance, values, np.ones(3), load)
        return {
            name: (float(low), float(middle), float(high))
            for name, (low, middle, high) in zip(PARAMETERS[1:], numbers[1:], strict=True)
        }

    @property
    def sensitivity(self) -> dict[str, float]:
        names = self._list("sensitivities", "name")
        return dict(zip(names, self._list("sensitivities", "slope"), strict=True))

    @property
    def candidates(self) -> NDArray[Any]:
        values = self._result.column("candidates", "values").decoded()
        levels = [
            self._result.column("candidates", name).decoded() for name in ("nominal", "level")
        ]
        found = np.empty(len(values), [(name, "f8") for name in (*self.values, "nominal", "level")])
        for name, numbers in zip(found.dtype.names or (), (*values.T, *levels), strict=True):
            found[name] = numbers
        return found

    @property
    def front(self) -> NDArray[Any]:
        chosen = self.candidates[self._result.column("candidates", "front").decoded().astype(bool)]
        return np.sort(chosen, order="nominal")

    @property
    def verdict(self) -> str:
        """The answer in words."""
        above = ""
        if self.excess > 1:
            above = (
                f"; no candidate meets all limits: a figure is {self.excess:.4g} times its limit"
            )
        share = f"{100 * self.quantile:.6g} % of the units"
        symbol = ">=" if self.target == "damping" else "<="
        if self.limit is None:
            return f"{self.target} {symbol} {self.level:.4g} for {share} of the search{above}"
        wanted = f"{self.target} {symbol} {self.limit:.6g} for {share}"
        if not self.samples:
            return f"{wanted}: {self.level:.4g} in the search, not confirmed by samples{above}"
        low, high = self.interval
        weak = int(np.nanargmin(self.bands["probability"]))
        met = self.level <= self.limit if symbol == "<=" else self.level >= self.limit
        failed = "does not hold" if met else "was not reached by any candidate"
        answer = {True: "holds", False: failed, None: "is not decided"}
        return (
            f"{wanted} {answer[self.feasible]}: {100 * self.probability:.4g} % of {self.samples} samples "
            f"(95 % interval {100 * low:.4g} to {100 * high:.4g} %), "
            f"{100 * self.bands['probability'][weak]:.4g} % from {self.bands['from'][weak]:.5g} to "
            f"{self.bands['to'][weak]:.5g}{above}"
        )

    def __repr__(self) -> str:
        chosen = ", ".join(f"{name} = {value:.6g}" for name, value in self.values.items())
        return f"<Design {chosen}: {self.verdict}>"

    def confirm(
        self, samples: int = 100_000, seed: int = 1, progress: door.Progress | None = None
    ) -> Design:
        """The same design, judged by other samples: each is a unit at a random frequency and load.

        Parameters
        ----------
        samples : int
            At least 10.
        seed : int
            From which the random numbers follow.
        progress : callable, optional
            Called a few times a second with the share done and the present task.

        Raises
        ------
        ParameterError, ParameterTypeError
            If an argument is not allowed, or the host, a function, is not known since the design was read from a
            file.
        KeyboardInterrupt
            After Ctrl-C.
        """
        if self._asked is None and not self.case:
            raise ParameterError(f"{self!r}: has no host, since it was read from a file")
        problem, order = self._asked or asked_by(self.osc, self.keys)
        samples = checks.integer(samples, "samples", 10, 10**9)
        seed = checks.integer(seed, "seed", 0, 2**31 - 1)
        tables = {
            name: (tuple(table.dims), {key: item.decoded() for key, item in table.columns.items()})
            for name, table in self._result.tables.items()
        }
        design, bands = confirmed(problem, order, self.values, samples, seed, progress)
        worst = max(order.sign * self.worst, order.sign * design["worst"])
        tables["design"] = (), tables["design"][1] | design | {"worst": order.sign * worst}
        tables["bands"] = ("part",), bands
        return answered(self.case, tables, (problem, order))

    @classmethod
    def computed(cls, case: Any, progress: door.Progress | None) -> Design:
        """The result of a case."""
        return designed(*asked_by(case.osc, case.keys), case.text, progress)

    def plot(self, ax: Any = None) -> Any:
        """Draw the candidates, the share of good samples along the band, and the sensitivities (extra `plot`).

        Returns the four Axes; with `ax` only the share of good samples is drawn, and its Axes is returned.
        """
        return self._draw(ax)

    def report(self, path: Any) -> None:
        """Write a page with the answer, the chosen values and the pictures; the extension sets the format (.pdf,
        .png, .svg; extra `plot`).

        Raises
        ------
        ParameterError
            If the extension is none of these.
        """
        from ..plot.design import report

        report(self, path)


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
        each = [
            problem.host.outcome(
                units, place, load, starts[:, :, i],
                part_of(progress, begin + i * n / states, n / states, samples), "confirmation",
            )
            for i in range(states)
        ]  # fmt: skip
        target = np.max([one.target for one in each], axis=0)
        bad = ~np.isfinite(target)
        within = (target <= limit) & (np.max([one.excess for one in each], axis=0) <= 1) & ~bad
        part = np.clip(np.searchsorted(edges, place, side="right") - 1, 0, parts - 1)
        good += np.bincount(part[within], minlength=parts)
        count += np.bincount(part, minlength=parts)
        failed += int(bad.sum())
        np.maximum.at(worst, part[~bad], target[~bad])
    total = int(good.sum())
    low, high = interval(total, samples)
    # at a confidence that holds for all parts at once
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


def answered(case: str, tables: Mapping[str, Any], asked: tuple[Problem, Order]) -> Design:
    """A design whose files and messages begin with its answer."""
    verdict = Design(made("design", case, tables)).verdict
    return Design(made("design", case, tables, (verdict,), notes=((False, verdict),)), asked)


def part_of(
    progress: door.Progress | None, begin: float, share: float, whole: float
) -> door.Progress | None:
    """The progress of a part of the work."""
    if progress is None:
        return None
    return lambda done, note: progress((begin + done * share) / whole, note)


def designed(problem: Problem, order: Order, case: str, progress: door.Progress | None) -> Design:
    """Searches, and confirms what was found."""
    searching = part_of(progress, 0, 1, 2 if order.samples else 1)
    archive = search(
        problem, max(order.evaluations, 8 * len(problem.free)), order.specimens, order.nodes, order.states,
        order.seed, searching,
    )  # fmt: skip
    archive, order = firmer(problem, order, archive)
    best = archive.best
    names = list(problem.free)
    low, high = np.array(list(problem.free.values())).T
    level = archive.level[best]
    tables: dict[str, Any] = {
        "chosen": (("choice",), {"name": names, "value": archive.values[best], "low": low, "high": high}),
        "design": ((), {
            "target": order.target, "limit": math.nan if order.limit is None else order.limit,
            "quantile": problem.quantile, "first": problem.band[0], "last": problem.band[1],
            "level": order.sign * level, "excess": archive.excess[best],
            "worst": order.sign * archive.worst[best], "samples": 0, "failed": 0, "probability": math.nan,
            "low": math.nan, "high": math.nan, "feasible": CODE_OF[None],
        }),
        "sensitivities": (("parameter",), {
            "name": list(archive.sensitivity), "slope": list(archive.sensitivity.values()),
        }),
        "candidates": (("candidate", "choice"), {
            "nominal": order.sign * np.array(archive.nominal), "level": order.sign * np.array(archive.level),
            "values": np.array(archive.values), "front": archive.front.astype(np.int32),
        }),
    }  # fmt: skip
    bands = ("from", "to", "samples", "good", "probability", "low", "high", "worst")
    tables["bands"] = ("part",), {name: np.zeros(0) for name in bands}
    found = answered(case, tables, (problem, order))
    if not order.samples:
        return found
    return found.confirm(order.samples, order.seed + 1, part_of(progress, 1, 1, 2))


def firmer(problem: Problem, order: Order, archive: Archive) -> tuple[Archive, Order]:
    """The candidates judged by more units, frequencies and states, where those of the search were too few.

    They were if the chosen candidate meets the limit in the search, but too few of some samples meet it.
    """
    for _ in range(ROUNDS):
        best = archive.best
        limit = math.inf if order.limit is None else order.sign * order.limit
        if (
            not order.samples
            or archive.level[best] > limit
            or (order.limit is None and not problem.limited)
        ):
            break
        chosen = dict(zip(problem.free, archive.values[best], strict=True))
        tried, bands = confirmed(problem, order, chosen, FEW, order.seed + 2, None)
        shares = bands["good"] / np.maximum(1, bands["samples"])
        if min(tried["probability"], shares.min()) >= problem.quantile:
            break
        order = replace(
            order, specimens=3 * order.specimens, nodes=2 * order.nodes, states=order.states + 1
        )
        fine = grid(problem, order.specimens, order.nodes, order.states, order.seed)
        archive = refined(problem, fine, np.array(archive.values), np.array(archive.level), None)
    return archive, order


def asked_by(
    osc: Oscillator, keys: Mapping[str, Any], threads: int | None = None
) -> tuple[Problem, Order]:
    """What a checked case asks for."""
    normal = keys.get("normal", ())
    normal = (normal,) if isinstance(normal, str) else normal

    def spread(name: str, key: str) -> Uncertain:
        return uncertain_by(keys[key], name in normal)

    free = {
        name: tuple(keys[f"free_{name.lower()}"])
        for name in NAMES
        if f"free_{name.lower()}" in keys
    }
    tolerance = {
        name: spread(name, f"tolerance_{name.lower()}")
        for name in NAMES
        if f"tolerance_{name.lower()}" in keys
    }
    limits = {name: keys[f"limit_{name}"] for name in LIMITED if f"limit_{name}" in keys}
    target = keys["target"]
    host: Any
    if target == "damping":
        host = DecayHost(osc, keys.get("clearance"), keys["cycles"], threads)
    else:
        host = OscillatorHost(
            osc, keys.get("clearance"), target, limits, keys["settling"], keys["keep"], threads
        )
    band = np.atleast_1d(keys["amplitude" if target == "damping" else "band"])
    problem = Problem(
        host, free, tolerance, (float(band[0]), float(band[-1])), spread("load", "load"), keys["quantile"],
        keys["over"] == "basins", bool(limits),
    )  # fmt: skip
    names = ("evaluations", "specimens", "nodes", "states", "samples", "seed")
    return problem, Order(target, keys.get("limit"), *(keys[name] for name in names))


def reach(item: Uncertain) -> _Array:
    """Least, middle and greatest value; of a normal distribution within 3 standard deviations."""
    if item.normal:
        mean, deviation = item.numbers
        return np.array([mean - 3 * deviation, mean, mean + 3 * deviation])
    return np.array([item.low, item.middle, item.high])


def numbers_of(item: Uncertain) -> list[float]:
    """The numbers of a key for what is known of a parameter."""
    return list(item.numbers[:1] if item.low == item.high else item.numbers)


def uncertain_by(numbers: Any, normal: bool) -> Uncertain:
    """What is known of a parameter, from the numbers of a key."""
    values = tuple(float(value) for value in np.atleast_1d(numbers))
    return Uncertain(values if len(values) > 1 else 2 * values, normal)


def design(
    host: Oscillator | Callable[..., Any], *, r: ArrayLike | None = None, free: Mapping[str, Any],
    clearance: float | None = None, load: Any = 1.0, tolerance: Mapping[str, Any] | None = None,
    target: str = "attenuation", limit: float | None = None, quantile: float = 0.99,
    limits: Mapping[str, float] | None = None, over: str = "worst", amplitude: ArrayLike | None = None,
    cycles: int = 5, coordinate: int = 0, states: int = 2, samples: int = 100_000, evaluations: int = 48,
    specimens: int = 16, nodes: int = 9, settling: int = 200, keep: int = 32, seed: int = 0,
    threads: int | None = None, progress: door.Progress | None = None,
) -> Design:  # fmt: skip
    """The clearance, mass and restitution for which an impact damper works best over a band, tolerances included.

    A candidate is judged by the `quantile` of the target over uncertain units, at the worst frequency of the band
    and over the attractors that initial states reach. A global search finds the region, and steps down the
    gradients of the worst units refine it (extra `design`). The result is then confirmed by independent samples:
    each is a unit with random parameters at a random frequency and load of the band.

    Parameters
    ----------
    host : Oscillator or callable
        An oscillator gives all parameters that are neither free nor uncertain. A function
        ``host(r=..., load=..., **parameters)`` returns a Structure and its Load or Record; its parameters have the
        names of `free` and `tolerance`.
    r : float or (float, float)
        The band of frequency ratios (of a function: of what it takes as r).
    free : dict
        Ranges (low, high) of what is chosen: ``clearance`` (d K/F0 at load 1, where d is the whole travel of the
        free mass), ``mu``, ``xi``, ``restitution`` (the same on both walls), ``R1``, ``R2``. Of a function any
        names; a ``range`` of whole numbers is for a number of units.
    clearance : float, optional
        If it is not free.
    load : float, range, quantiles or distribution
        Load amplitude, 1 where lengths are in F0/K.
    tolerance : dict, optional
        Uncertain parameters: a range (low, high) in which all values are equally likely, quantiles at even steps,
        or a frozen distribution of scipy.stats. Of a free parameter it is the deviation from the chosen value, of
        others the value.
    target : {'attenuation', 'displacement', 'rms', 'acceleration', 'force', 'damping'}
        What is minimised: max|X|/A, max|X|, root mean square of X, greatest acceleration of the primary mass
        between impacts, greatest force on the base; all but the first in F0/K, omega^2 F0/K and F0. The damping
        ratio in free vibration is maximised. A function has the first three.
    limit : float, optional
        Value of the target that has to be reached.
    quantile : float
        Share of the units that has to reach it, 0.5 to 1. With 1 the search judges by its worst unit.
    limits : dict, optional
        Greatest allowed ``speed`` of an impact, ``displacement``, ``rms``, ``acceleration``, ``force``, or modulus
        of the ``multiplier``; a simulation without a period is above a limit of the multiplier.
    over : {'worst', 'basins'}
        Whether the worst attractor of a unit counts, or each by the share of initial states that reach it.
    amplitude : float or (float, float), optional
        For the damping: displacements from which free vibration starts, instead of `r`.
    cycles : int
        Oscillations over which that damping is averaged.
    coordinate : int
        Of a structure: the coordinate whose motion counts.
    states : int
        Initial states of each unit.
    samples : int
        Samples of the confirmation, at least 10; 0 for none.
    evaluations : int
        Candidates of the global search.
    specimens, nodes : int
        Units and frequencies by which the best candidates are judged.
    settling, keep : int
        Load cycles after which a simulation without a period counts as settled, and those then examined.
    seed : int
        From which the random numbers follow.
    threads : int, optional
        Default: one for each processor. The result does not depend on it.
    progress : callable, optional
        Called a few times a second with the share done and the present task.

    Returns
    -------
    Design

    Raises
    ------
    ParameterError, ParameterTypeError
        The parameter, its value and what it must be.
    MissingExtraError
        Without SciPy.
    KeyboardInterrupt
        After Ctrl-C.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> found = vi.design(osc, r=(1.0, 1.02), free={"clearance": (20, 40)}, limit=0.55, samples=500)
    >>> found.feasible, 20 < found.values["clearance"] < 40
    (None, True)
    """
    if not hasattr(free, "items"):
        raise ParameterTypeError(
            f"free = {free!r}: must be a dict of ranges, not {type(free).__name__}"
        )
    if not free:
        raise ParameterError("free = {}: must have at least one parameter")
    spread = {} if tolerance is None else tolerance
    if not hasattr(spread, "items"):
        raise ParameterTypeError(
            f"tolerance = {spread!r}: must be a dict, not {type(spread).__name__}"
        )
    bounds = {} if limits is None else limits
    if not hasattr(bounds, "items"):
        raise ParameterTypeError(
            f"limits = {limits!r}: must be a dict, not {type(limits).__name__}"
        )
    uncertain_ones = {
        name: uncertain(value, f"tolerance[{name!r}]") for name, value in spread.items()
    }
    loads = uncertain(load, "load")
    keys: dict[str, Any] = {
        "target": target, "limit": limit, "quantile": quantile, "over": over, "clearance": clearance,
        "load": numbers_of(loads), "states": states, "samples": samples, "evaluations": evaluations,
        "specimens": specimens, "nodes": nodes, "settling": settling, "keep": keep, "seed": seed,
    }  # fmt: skip
    workers = None if threads is None else checks.integer(threads, "threads", 1, 1024)
    if progress is not None and not callable(progress):
        raise ParameterTypeError(f"progress = {progress!r}: must be None or callable")
    if not isinstance(host, Oscillator):
        return _designed_structure(
            host, r, free, uncertain_ones, bounds, loads, coordinate, keys, workers, progress
        )
    of_numbers(host, "host")
    checks.integer(coordinate, "coordinate", 0, 0)
    keys |= {"band": r, "amplitude": amplitude, "cycles": cycles}
    names = {"band": "r"}
    for group, given in (("free", free), ("tolerance", uncertain_ones), ("limit", bounds)):
        known = tuple(LIMITED) if group == "limit" else NAMES
        label = "limits" if group == "limit" else group
        for name, value in given.items():
            if name not in known:
                raise ParameterError(
                    f"{label}: unknown parameter {name!r}: must be one of {', '.join(known)}"
                )
            key = f"{group}_{name.lower()}"
            keys[key] = list(value.numbers) if isinstance(value, Uncertain) else value
            names[key] = f"{label}[{name!r}]"
    normal = [name for name, item in {**uncertain_ones, "load": loads}.items() if item.normal]
    # the core checks the case and completes it
    text = door.run(
        Design, host, keys | {"normal": normal or None}, parameters=names, little=True
    ).case
    problem, order = asked_by(host, keys_of(text), workers)
    return designed(problem, order, text, progress)


def _designed_structure(
    host: Any, r: Any, free: Mapping[str, Any], tolerance: dict[str, Uncertain], limits: Mapping[str, Any],
    load: Uncertain, coordinate: int, keys: dict[str, Any], threads: int | None, progress: door.Progress | None,
) -> Design:  # fmt: skip
    """The design of a structure that a function builds."""
    if not callable(host):
        raise ParameterTypeError(
            f"host = {host!r}: must be an Oscillator, or a function that returns a Structure and its load"
        )
    target = checks.choice(keys["target"], "target", OF_STRUCTURES)
    checks.choice(keys["over"], "over", ("worst", "basins"))
    for name in limits:
        checks.choice(name, "limits", FIGURES)
    if keys["clearance"] is not None:
        raise ParameterError(f"clearance = {keys['clearance']!r}: must be left out for a function")
    numbers = {"quantile": keys["quantile"], "limit": keys["limit"]}
    numbers |= {f"limits[{name!r}]": value for name, value in limits.items()}
    for name, value in numbers.items():
        wanted = (
            "a number with 0.5 <= quantile <= 1" if name == "quantile" else "a finite number > 0"
        )
        if value is None:
            continue
        item = checks.to_float(value, name, wanted)
        if not (0.5 <= item <= 1 if name == "quantile" else 0 < item < math.inf):
            raise ParameterError(f"{name} = {value!r}: must be {wanted}")
    low = {"evaluations": 8, "nodes": 2, "settling": 1, "seed": 0, "samples": 0}
    for name in ("states", "specimens", "keep", *low):
        checks.integer(keys[name], name, low.get(name, 1), 10**9)
    band = uncertain(r, "r")
    ranges = {}
    for name, value in free.items():
        ends = uncertain(
            (value[0], value[-1]) if isinstance(value, range) and value else value,
            f"free[{name!r}]",
        )
        if not ends.low < ends.high:
            raise ParameterError(f"free[{name!r}] = {value!r}: must be a pair with low < high")
        ranges[name] = ends.low, ends.high
    whole = tuple(name for name, value in free.items() if isinstance(value, range))
    system = StructureHost(
        host, checks.integer(coordinate, "coordinate", 0, 499), target, dict(limits), keys["settling"],
        keys["keep"], threads,
    )  # fmt: skip
    problem = Problem(
        system, ranges, tolerance, (band.low, band.high), load, float(keys["quantile"]), keys["over"] == "basins",
        bool(limits), whole,
    )  # fmt: skip
    names = ("evaluations", "specimens", "nodes", "states", "samples", "seed")
    order = Order(target, keys["limit"], *(keys[name] for name in names))
    return designed(problem, order, "", progress)
