"""Design of an impact damper: clearance, mass and restitution for the best worst case."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.actions import ACTIONS
from ..base.checks import Rng
from ..base.errors import ParameterError, ParameterTypeError, StudyInterrupted
from ..base.progress import with_progress
from ..base.spacing import in_order
from ..base.status import VERDICT
from ..results import door
from ..results.namelist import keys_of
from ..results.noun import Noun
from ..results.performance import LEAST, LIMITED, PARAMETERS
from ..results.tables import Result, made
from ..systems.distribution import ELEMENTS, Uncertain, uncertain
from ..systems.oscillator import Oscillator, of_numbers
from ..systems.units import range_text, units_to_show, value_text, wanted_figure
from ..systems.verbs import physical_arguments
from .confirmation import CODE_OF, confirmed, firmer
from .order import NAMES, Order, asked_by, numbers_of
from .problem import OscillatorHost, Problem, parameters_of
from .search import AGREEMENT, part_of, search, told
from .structure import asked_of

if TYPE_CHECKING:
    from ..systems.units import Units

__all__ = ["Design", "design"]

_Array = NDArray[np.float64]
#: Arguments without meaning for free vibration, and for a load: they must have their defaults.
DRIVEN = {"load": [1.0], "settling": 400, "keep": 32}
FREE = {"cycles": 5}
EXAMPLE = (
    "--xi .0114 --mu .028 --restitution .75 --band 1 1.02 --free-clearance 20 40 --limit .55 --quantile .9 "
    "--samples 1000"
)


class Design(Noun, study="design", example=EXAMPLE):
    """A design and its performance.

    Attributes
    ----------
    values : dict
        The chosen values by name.
    ranges : dict
        The ranges (low, high) from which they were chosen.
    target, limit, quantile : str, float or None, float
        The quantity that was minimised (the damping: maximised), the limit, and the share of the units that must
        meet it.
    level : float
        The quantile of the target over the units of the search, at the worst of its frequencies. If a larger share
        of 4,000 runs of these units from other initial states than stated at `states` of `design` is more than 2 %
        above it, the corresponding quantile of these runs instead; if these leave the level of repeated searches
        uncertain, that of 40,000 runs if it is higher.
    excess : float
        The same quantile of the largest ratio of a quantity to its limit; above 1, no candidate met all limits.
    converged : bool or None
        Whether three of the independent searches ended at the best design: at its level within 2 % and its values
        within 2 % of their ranges, or at another design whose level differs by less than 0.2 %. None with fewer
        than three searches. False, whatever their number, if samples contradict the level even with more units,
        see `contradicted`. Whether limits hold is stated by `feasible`.
    contradicted : bool or None
        Whether, of 10,000 samples of an oscillator in the whole band, a larger share than `quantile` allows (or
        0.5 % if that is more) is more than 2 % worse than `level`. None without such samples: for a structure,
        for friction or compliant walls, for the damping, if no candidate meets all `limits`, or after Ctrl-C.
    searches : dict of ndarray
        For each search: the number of its ``candidates``, and the best ``level``.
    worst : float
        The worst target among all samples of the confirmation and all units of the search.
    samples, failed : int
        Number of samples of the confirmation, and number of samples whose simulation was abandoned; the latter
        count as violating the limits.
    probability : float
        Share of the samples that meet all limits; without limits, of those at most 2 % worse than `level`. NaN
        without samples.
    interval : (float, float)
        The 95 % confidence interval of the probability (Clopper–Pearson).
    bands : dict of ndarray
        The results for parts of the band: ``from, to, samples, good, probability, low, high, worst``. The
        intervals hold for all parts simultaneously at 95 %. Shares of parts without samples are NaN.
    feasible : bool or None
        True if the lower ends of `interval` and of the intervals of all parts of the band are at least `quantile`,
        False if one of the upper ends is below `quantile`, None if the samples do not decide.
    spread : dict
        Smallest, median and largest clearance, xi, mu, R1 and R2 of the units, and friction and properties of the
        walls if they vary; it raises an error for a host that is a function.
    sensitivity : dict
        Derivatives of the target of the worst unit with respect to its parameters; empty if it has no periodic
        motion.
    candidates, front : ndarray
        Structured arrays of all candidates that were evaluated for all units, and of the Pareto front: the
        candidates that no other candidate beats both in ``nominal`` (level of the unit without deviations) and in
        ``level``.
    tried : ndarray
        Structured array of all candidates, with the number of ``runs`` by which each was judged.
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
        """The chosen values by name."""
        return dict(zip(self._list("chosen", "name"), self._list("chosen", "value"), strict=True))

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """The range (low, high) from which each value was chosen, by name."""
        ends = zip(self._list("chosen", "low"), self._list("chosen", "high"), strict=True)
        return dict(zip(self._list("chosen", "name"), ends, strict=True))

    @property
    def target(self) -> str:
        """Name of the quantity that was minimised; "damping" was maximised."""
        target: str = self._one("target")
        return target

    @property
    def limit(self) -> float | None:
        """The limit of the target; None without one."""
        limit: float = self._one("limit")
        return None if math.isnan(limit) else limit

    @property
    def quantile(self) -> float:
        """The share of the units, from 0 to 1, that must meet the limit."""
        quantile: float = self._one("quantile")
        return quantile

    @property
    def level(self) -> float:
        """The quantile of the target over the units of the search, at the worst frequency.

        If too many of 4,000 runs from other initial states are more than 2 % above it, that of these runs, or of
        more of them, see the class.
        """
        level: float = self._one("level")
        return level

    @property
    def excess(self) -> float:
        """The quantile of the largest ratio of a quantity to its limit; above 1, a limit is not met."""
        excess: float = self._one("excess")
        return excess

    @property
    def converged(self) -> bool | None:
        """Whether three of the independent searches ended at the best design, see the class; None with fewer.

        False if samples contradict the level, whatever the number of searches.
        """
        return VERDICT[self._one("converged")]

    @property
    def contradicted(self) -> bool | None:
        """Whether samples contradict the level, see the class; None if they do not check it."""
        return VERDICT[self._one("contradicted")]

    @property
    def searches(self) -> dict[str, NDArray[Any]]:
        """For each search, the number of ``candidates`` and the best ``level``, each as an array (searches,)."""
        return {
            name: self._result.column("searches", name).decoded()
            for name in ("candidates", "level")
        }

    @property
    def worst(self) -> float:
        """The worst target among the samples of the confirmation and the units of the search."""
        worst: float = self._one("worst")
        return worst

    @property
    def samples(self) -> int:
        """Number of samples of the confirmation; 0 without one."""
        samples: int = self._one("samples")
        return samples

    @property
    def failed(self) -> int:
        """Number of samples whose simulation was abandoned; they count as violating the limits."""
        failed: int = self._one("failed")
        return failed

    @property
    def probability(self) -> float:
        """Share of the samples within all limits, from 0 to 1; NaN without samples.

        Without limits it is the share of those that are at most 2 % worse than `level`.
        """
        probability: float = self._one("probability")
        return probability

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % confidence interval (low, high) of the probability (Clopper–Pearson)."""
        return self._one("low"), self._one("high")

    @property
    def feasible(self) -> bool | None:
        """Whether the quantile is met in all parts of the band; None if the samples do not decide."""
        return VERDICT[self._one("feasible")]

    @property
    def bands(self) -> dict[str, NDArray[Any]]:
        """The samples by parts of the band: arrays (parts,) by name, as the class lists them."""
        names = ("from", "to", "samples", "good", "probability", "low", "high", "worst")
        return {name: self._result.column("bands", name).decoded() for name in names}

    @property
    def ends(self) -> tuple[float, float]:
        """The ends of the band."""
        return self._one("first"), self._one("last")

    @property
    def spread(self) -> dict[str, tuple[float, float, float]]:
        """Smallest, median and largest clearance (d K/F0 at each load), xi, mu, R1 and R2 of the units.

        Also friction, wall_stiffness and wall_damping if they vary. For normal distributions, the outer values are
        3 standard deviations from the median.
        """
        if self._asked is None and not self.case:
            raise ParameterError(f"{self!r}: has no host, since it was read from a file")
        problem, order = self._asked or asked_by(self.osc, self.keys)
        if not isinstance(problem.host, OscillatorHost):
            raise ParameterError(
                f"target = {order.target!r} of the design: must be a target for an Oscillator under a load"
            )
        values = {name: np.full(3, value) for name, value in self.values.items()}
        for name, item in problem.tolerance.items():
            values[name] = item.around(values[name], reach(item)) if name in values else reach(item)
        # the smallest clearance in F0/K is that at the largest load
        load = reach(problem.load)[::-1]
        numbers = parameters_of(problem.host.osc, problem.host.clearance, values, np.ones(3), load)
        found = dict(zip(PARAMETERS[1:], numbers[1:], strict=True))
        found |= {name: values[name] for name in ELEMENTS if name in values}
        return {
            name: (float(low), float(middle), float(high))
            for name, (low, middle, high) in found.items()
        }

    @property
    def sensitivity(self) -> dict[str, float]:
        """Derivative of the target of the worst unit with respect to each of its parameters, by name."""
        names = self._list("sensitivities", "name")
        return dict(zip(names, self._list("sensitivities", "slope"), strict=True))

    @property
    def candidates(self) -> NDArray[Any]:
        """All candidates that were judged by all units: their values, ``nominal`` and ``level``, one row each."""
        tried = self.tried
        names = [*self.values, "nominal", "level"]
        return np.array(tried[names][tried["runs"] == tried["runs"].max()])

    @property
    def tried(self) -> NDArray[Any]:
        """All candidates in their order, one row each: their values, ``nominal``, ``level``, and ``runs``.

        A candidate is judged run by run (a unit at a frequency from an initial state), and is dropped when its
        level is certainly too high: ``runs`` is the number of runs it was judged by. If these are not all,
        ``level`` is a bound (the level is not better), and ``nominal`` is NaN.
        """
        names = ("nominal", "level", "runs")
        columns = [self._result.column("candidates", name).decoded() for name in ("values", *names)]
        types = [*((name, "f8") for name in (*self.values, *names[:2])), ("runs", "i4")]
        found = np.empty(len(columns[0]), types)
        for name, numbers in zip(
            (*self.values, *names), (*columns[0].T, *columns[1:]), strict=True
        ):
            found[name] = numbers
        return found

    @property
    def front(self) -> NDArray[Any]:
        """The candidates that no other beats both in ``nominal`` and in ``level``, sorted by ``nominal``."""
        front = self._result.column("candidates", "front").decoded().astype(bool)
        return np.sort(
            np.array(self.tried[[*self.values, "nominal", "level"]][front]), order="nominal"
        )

    @property
    def _output(self) -> str:
        """The output of a structure whose motion counts; empty if it is a coordinate or not known."""
        coordinate = getattr(self._asked[0].host, "coordinate", 0) if self._asked else 0
        return coordinate if isinstance(coordinate, str) else ""

    @property
    def _target_text(self) -> str:
        """The target in words."""
        return f"{self.target} of {self._output}" if self._output else self.target

    @property
    def verdict(self) -> str:
        """The answer as a text."""
        above = ""
        if self.excess > 1:
            above = f"; no candidate meets all limits: the worst quantity is {self.excess:.4g} times its limit"
        share = f"{100 * self.quantile:.6g} % of the units"
        symbol = ">=" if self.target == "damping" else "<="
        osc = self.osc if self.case else None
        if self.contradicted:
            above += (
                "; not converged: samples contradict the search; more nodes or states would help, and more "
                "specimens if units differ"
            )
        elif self.converged is False:
            levels = ", ".join(
                value_text(osc, self.target, x, 4)
                for x in sorted(self.searches["level"], reverse=symbol == ">=")
            )
            above += (
                "; not converged: fewer than three searches ended at this design; their levels: "
                f"{levels}; more evaluations or searches would help"
            )
        low, high = self.interval
        sampled = (
            f"{100 * self.probability:.4g} % of {self.samples} samples "
            f"(95 % interval {100 * low:.4g} to {100 * high:.4g} %)"
        )
        weakest = self._weakest if self.samples else ""
        if self.limit is None:
            level = value_text(osc, self.target, self.level, 4)
            found = f"{self._target_text} {symbol} {level} for {share} of the search"
            if self.samples:
                asked = self._asked or (asked_by(self.osc, self.keys) if self.case else None)
                limited = asked[0].limited if asked else self.excess > 0
                found += f"; {sampled} {'meet all limits' if limited else 'are at most 2 % worse'}"
            return f"{found}{weakest}{above}"
        wanted = (
            f"{self._target_text} {symbol} {value_text(osc, self.target, self.limit)} for {share}"
        )
        if not self.samples:
            level = value_text(osc, self.target, self.level, 4)
            return f"{wanted}: {level} in the search, not confirmed by samples{above}"
        met = self.level <= self.limit if symbol == "<=" else self.level >= self.limit
        failed = "does not hold" if met else "was not reached"
        answer = {True: "holds", False: failed, None: "is not decided"}
        return f"{wanted} {answer[self.feasible]}: {sampled}{weakest}{above}"

    @property
    def _weakest(self) -> str:
        """The part of the band with the smallest share of good samples, as a text."""
        bands = self.bands
        weak = int(np.nanargmin(bands["probability"]))
        along = "amplitude" if self.target == "damping" else "r"
        osc = self.osc if self.case else None
        return (
            f"; weakest part of the band: {100 * bands['probability'][weak]:.4g} % "
            f"({100 * bands['low'][weak]:.4g} to {100 * bands['high'][weak]:.4g} %) from "
            f"{range_text(osc, along, bands['from'][weak], bands['to'][weak], 5)}"
        )

    @property
    def asked(self) -> list[str]:
        """The requirements other than the limit of the target, as sentences.

        These are the band, the tolerances and the limits; for a host that is a function and a design that was read
        from a file, only the band.
        """
        first, last = self.ends
        along = "Initial displacements" if self.target == "damping" else "Frequency ratios"
        osc = self.osc if self.case else None
        kind = "amplitude" if self.target == "damping" else "r"
        if units_to_show(osc) is not None and kind == "r":
            along = "Load frequencies"
        found = [f"{along} {range_text(osc, kind, first, last)}."]
        if self._asked is None and not self.case:
            return found
        problem, _ = self._asked or asked_by(self.osc, self.keys)
        spread = problem.tolerance | {"load": problem.load}
        free = problem.free
        texts = [
            f"{name} {spread_text(osc, name, item, name in free)}{item.meaning if name in free else ''}"
            for name, item in spread.items()
            if item.low < item.high
        ]
        if texts:
            found.append("Tolerances: " + ", ".join(texts) + ".")
        limits = getattr(problem.host, "limits", {})
        if limits:
            parts = (
                f"{name} {'>=' if name in LEAST else '<='} {value_text(osc, name, value)}"
                for name, value in limits.items()
            )
            found.append("Limits: " + ", ".join(parts) + ".")
        return found

    def __repr__(self) -> str:
        osc = self.osc if self.case else None
        chosen = ", ".join(
            f"{name} = {value_text(osc, name, value)}" for name, value in self.values.items()
        )
        cut = "" if self.complete else f"; {self.cut}"
        return f"<Design {chosen}: {self.verdict}{cut}>"

    def confirm(
        self, samples: int = 100_000, rng: Rng = 1, progress: door.Progress | None = None
    ) -> Design:
        """The same design confirmed by new samples: each is a unit at a random frequency and load.

        Parameters
        ----------
        samples : int
            At least 10.
        rng : int, numpy.random.Generator or None
            Seed of the random numbers, from 0 to 2**31 - 1, or a generator from which a seed is drawn; None:
            another seed in each call.
        progress : callable, optional
            Called a few times a second with the fraction done and the current task; by default a bar on a terminal
            or in a notebook.

        Returns
        -------
        Design
            The same values with the new samples; `worst` also covers the earlier units.

        Raises
        ------
        ParameterError, ParameterTypeError
            If an argument is not allowed, or the host is a function that is not known because the design was read
            from a file.
        KeyboardInterrupt
            After Ctrl-C.
        """
        if self._asked is None and not self.case:
            raise ParameterError(f"{self!r}: has no host, since it was read from a file")
        problem, order = self._asked or asked_by(self.osc, self.keys)
        samples = checks.integer(samples, "samples", 10, 10**9)
        seed = checks.seed_of(rng)
        tables = {
            name: (tuple(table.dims), {key: item.decoded() for key, item in table.columns.items()})
            for name, table in self._result.tables.items()
        }
        level = order.sign * self.level
        known = None
        if order.limit is None and not problem.limited:
            # without limits, the samples show whether the level of the search is that of other units
            known = level + AGREEMENT * abs(level)
        design, bands = confirmed(problem, order, self.values, samples, seed, progress, known)
        worst = max(order.sign * self.worst, order.sign * design["worst"])
        tables["design"] = (), tables["design"][1] | design | {"worst": order.sign * worst}
        tables["bands"] = ("part",), bands
        return answered(self.case, tables, (problem, order))

    @classmethod
    def computed(cls, case: Any, progress: door.Progress | None) -> Design:
        """The result of a case.

        Parameters
        ----------
        case : Case
            A case with a &design.
        progress : callable or None
            As in `design`.

        Returns
        -------
        Design
            The best design, confirmed by the samples of the case.
        """
        return designed(*asked_by(case.osc, case.keys), case.text, progress)

    def plot(self, ax: Any = None, units: Units | str | None = None) -> Any:
        """Draw the candidates, the samples along the band, the sensitivities and the searches (extra `plot`).

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes for the share of samples that meet all limits along the band; only this panel is then drawn.
        units : Units or str, optional
            As in `Trajectory.plot`.

        Returns
        -------
        Axes, or an array of Axes
            All five Axes, or `ax` if it is given.
        """
        return self._draw(ax, units=units)

    def report(self, path: Any) -> None:
        """Write a page with the verdict, the chosen values and the pictures (extra `plot`).

        Parameters
        ----------
        path : str or Path
            The file; its extension sets the format: .pdf, .png or .svg.

        Raises
        ------
        ParameterError
            If the extension is not one of these, or the folder does not exist.
        """
        ACTIONS["report"](self, path)


def spread_text(osc: Oscillator | None, name: str, item: Uncertain, free: bool) -> str:
    """The uncertainty of a parameter as a text, in the units of the oscillator if it has units."""
    plain = item.normal or len(item.numbers) != 2 or (free and "factors" in item.meaning)
    return item.text if plain else range_text(osc, name, item.low, item.high)


def answered(
    case: str, tables: Mapping[str, Any], asked: tuple[Problem, Order], cut: str = ""
) -> Design:
    """Put the answer of a design at the beginning of its files and messages; `cut` says where it was
    interrupted."""
    verdict = Design(made("design", case, tables), asked).verdict
    return Design(made("design", case, tables, (verdict,), cut, ((False, verdict),)), asked)


def designed(problem: Problem, order: Order, case: str, progress: door.Progress | None) -> Design:
    """Searches, and confirms the result."""
    searching = part_of(progress, 0, 1, 2 if order.samples else 1)
    archive = search(problem, order, part_of(searching, 0, 1, 2))
    if not archive.stopped:
        archive, order = firmer(problem, order, archive, part_of(searching, 1, 1, 2))
        told(searching, 1.0, "best candidates")
    best = archive.best
    names = list(problem.free)
    low, high = np.array(list(problem.free.values())).T
    level = archive.level[best]
    slopes = archive.sensitivity(problem)
    tables: dict[str, Any] = {
        "chosen": (("choice",), {"name": names, "value": archive.values[best], "low": low, "high": high}),
        "design": ((), {
            "target": order.target, "limit": math.nan if order.limit is None else order.limit,
            "quantile": problem.quantile, "first": problem.band[0], "last": problem.band[1],
            "level": order.sign * level, "excess": archive.excess[best],
            "worst": order.sign * archive.worst[best], "samples": 0, "failed": 0, "probability": math.nan,
            "low": math.nan, "high": math.nan, "feasible": CODE_OF[None],
            "converged": CODE_OF[archive.converged(problem)], "contradicted": CODE_OF[archive.contradicted],
        }),
        "searches": (("search",), {
            "candidates": [many for many, _ in archive.searches],
            "level": [order.sign * least for _, least in archive.searches],
        }),
        "sensitivities": (("parameter",), {
            "name": list(slopes), "slope": list(slopes.values()),
        }),
        "candidates": (("candidate", "choice"), {
            "nominal": order.sign * np.array(archive.nominal), "level": order.sign * np.array(archive.level),
            "values": np.array(archive.values), "runs": archive.runs, "front": archive.front.astype(np.int32),
        }),
    }  # fmt: skip
    bands = ("from", "to", "samples", "good", "probability", "low", "high", "worst")
    tables["bands"] = ("part",), {name: np.zeros(0) for name in bands}
    if order.samples and not archive.stopped:
        found = answered(case, tables, (problem, order))
        try:
            return found.confirm(order.samples, order.seed + 1, part_of(progress, 1, 1, 2))
        except KeyboardInterrupt:
            raise StudyInterrupted(
                answered(
                    case, tables, (problem, order), "interrupted before the confirmation ended"
                )
            ) from None
    if archive.stopped:
        ended = f"interrupted with {int(archive.complete.sum())} candidates judged"
        if archive.refuted:
            ended += f", before a search with more units: samples contradict the {archive.refuted}"
        raise StudyInterrupted(answered(case, tables, (problem, order), ended))
    return answered(case, tables, (problem, order))


def reach(item: Uncertain) -> _Array:
    """Smallest, median and largest value; for a normal distribution within 3 standard deviations."""
    if item.normal:
        mean, deviation = item.numbers
        return np.array([mean - 3 * deviation, mean, mean + 3 * deviation])
    return np.array([item.low, item.middle, item.high])


@physical_arguments
@with_progress
def design(
    host: Oscillator | Callable[..., Any], *, r: ArrayLike | None = None, free: Mapping[str, Any],
    clearance: float | None = None, load: Any = 1.0, tolerance: Mapping[str, Any] | None = None,
    target: str = "attenuation", limit: float | None = None, quantile: float = 0.99,
    limits: Mapping[str, float] | None = None, over: str = "worst", amplitude: ArrayLike | None = None,
    cycles: int = 5, coordinate: int | str = 0, states: int = 2, samples: int = 100_000, evaluations: int = 96,
    searches: int = 8, specimens: int = 16, nodes: int = 9, settling: int = 400, keep: int = 32, rng: Rng = 0,
    threads: int | None = None, progress: door.Progress | None = None,
) -> Design:  # fmt: skip
    """The clearance, mass and restitution for which an impact damper works best over a band, including tolerances.

    A candidate is evaluated by the `quantile` of the target over uncertain units, at the worst frequency of the
    band and over the attractors that initial states reach. Global searches find the region, and descent along the
    gradients of the worst units refines it (extra `design`); the searches end when three of them find one design.
    The result is then confirmed by independent samples: each is a unit with random parameters at a random
    frequency and load of the band.

    Parameters
    ----------
    host : Oscillator or callable
        An oscillator provides all parameters that are neither free nor uncertain. A function
        ``host(r=..., load=..., **parameters)`` returns a Structure and its Load or Record; its parameters are
        those named in `free` and `tolerance`.
    r : float or (float, float)
        The band of frequency ratios (for a function: of its argument r).
    free : dict
        Ranges (low, high) of the parameters to choose: ``clearance`` (d K/F0 at load 1, where d is the whole
        travel of the free mass), ``mu`` (m/M, or the free mass, such as "0.05 kg"), ``xi``, ``restitution`` (the
        same on both walls), ``R1``, ``R2``; ``friction`` in the slot (over F0), ``wall_stiffness`` and
        ``wall_damping`` of both walls (over K and sqrt(K M)), with which units are simulated as structures. For a
        function, any names; a ``range`` stands for a whole number, such as a number of units.
    clearance : float, optional
        The clearance d K/F0, if it is not free.
    load : float, range, quantiles or distribution
        Load amplitude, 1 if lengths are in F0/K.
    tolerance : dict, optional
        Uncertain parameters: a range (low, high) in which all values are equally likely, quantiles at evenly
        spaced probabilities, or a frozen distribution of scipy.stats. For a parameter that is not free, these are
        its values. For a free parameter they refer to the chosen value: (-1, 1), with 0 in the range, are
        deviations from it; (0.95, 1.05), above 0 and with 1 in the range, are factors of it, as in `uncertainty`.
    target : {'attenuation', 'displacement', 'rms', 'acceleration', 'force', 'damping'}
        The quantity to minimise: max|X|/A, max|X|, root mean square of X, greatest acceleration of the primary
        mass between impacts, greatest force on the base; all but the first in F0/K, omega^2 F0/K and F0. The
        target 'damping', the damping ratio of free vibration, is maximised instead. A function supports all
        targets but this one, for one coordinate; the force is then that of springs and dashpots on this
        coordinate.
    limit : float, optional
        Value of the target that must be reached.
    quantile : float
        Share of the units that must meet the limit, 0.5 to 1. With 1, the worst unit counts in the search.
    limits : dict, optional
        Largest allowed ``speed`` of an impact, ``displacement``, ``rms``, ``acceleration``, ``force``, or modulus
        of the ``multiplier``; a simulation without a period violates a limit of the multiplier. Smallest allowed
        distances to boundaries: ``least_speed`` at an impact, and ``least_gap``, the distance from a wall that the
        free mass approaches without an impact; a simulation with rest violates both. A function supports all but
        ``least_gap``, and under a Record no limit of the multiplier.
    over : {'worst', 'basins'}
        Whether the worst attractor of a unit counts, or each attractor weighted by the share of initial states
        that reach it.
    amplitude : float or (float, float), optional
        For the damping: displacements from which free vibration starts, instead of `r`.
    cycles : int
        Oscillations over which this damping is averaged.
    coordinate : int or str
        For a structure: the coordinate whose motion counts, or the name of one of its outputs.
    states : int
        Number of initial states of each unit. If there are few units and frequencies, the search uses more states,
        up to 200, since a few would miss bad attractors; of 200 states, the worst one does not count. The best
        candidates of an oscillator are verified by 4,000 further runs. The level is raised if the share of these
        runs above it exceeds both 0.5 % and 1/N, where N is the number of runs of the search at a frequency.
    samples : int
        Number of samples of the confirmation, at least 10; 0 for none.
    evaluations : int
        Number of initial candidates of each global search, at least 8 for each free parameter; as long as the
        searches do not agree, it doubles after every third search.
    searches : int
        Largest number of independent global searches, which end when three of them find the best design; otherwise
        `Design.converged` is False. If up to 10,000 samples (of structures at most `samples`) contradict the level
        (`Design.contradicted`), or do not meet limits that the search meets, up to two further sets of searches
        follow, each with at most this number, unless a limit was not reached: each set has twice as many
        frequencies as the previous one and, with tolerances or an uncertain load, twice as many units. If the last
        one of them does not agree, at most this number of searches is added to it (not for structures).
    specimens, nodes : int
        Numbers of units and frequencies for which the best candidates are evaluated.
    settling, keep : int
        Load cycles after which a simulation without a period counts as settled, and load cycles examined then.
    rng : int, numpy.random.Generator or None
        Seed of the searches and of the samples of the confirmation, or a generator from which a seed is drawn;
        None: another seed in each call. The seed that was used is in the case of the result.
    threads : int, optional
        Default: one for each processor. The result does not depend on it.
    progress : callable, optional
        Called a few times a second with the fraction done and the current task; by default a bar on a terminal
        or in a notebook.

    Returns
    -------
    Design
        The best design that was found, with its confirmation.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; the message names the parameter, its value and what is allowed.
    MissingExtraError
        If SciPy is not installed.
    KeyboardInterrupt
        After Ctrl-C, once candidates have been evaluated: its attribute `result` is the best design so far,
        without samples; if the first search was stopped, this design was evaluated for few units only.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> found = vi.design(osc, r=1.0, free={"clearance": (50, 78)}, limit=0.1, samples=500)
    >>> found.feasible, round(found.values["clearance"])
    (True, 78)
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
    for where, bound, figure in [
        ("limit", limit, target), *((f"limits[{key!r}]", item, key) for key, item in bounds.items())
    ]:  # fmt: skip
        if isinstance(bound, str):
            raise ParameterTypeError(
                f"{where} = {bound!r}: must be {wanted_figure(figure)}, not str"
            )
    uncertain_ones = {
        name: uncertain(value, f"tolerance[{name!r}]") for name, value in spread.items()
    }
    loads = uncertain(load, "load")
    keys: dict[str, Any] = {
        "target": target, "limit": limit, "quantile": quantile, "over": over, "clearance": clearance,
        "load": numbers_of(loads), "states": states, "samples": samples, "evaluations": evaluations,
        "searches": searches, "specimens": specimens, "nodes": nodes, "settling": settling, "keep": keep,
        "seed": checks.seed_of(rng, 2 * 10**9),
        "amplitude": amplitude, "cycles": cycles,
    }  # fmt: skip
    workers = None if threads is None else checks.integer(threads, "threads", 1, 1024)
    checks.progress(progress)
    if not isinstance(host, Oscillator):
        asked = asked_of(host, r, free, uncertain_ones, bounds, loads, coordinate, keys, workers)
        return designed(*asked, "", progress)
    of_numbers(host, "host")
    checks.integer(coordinate, "coordinate", 0, 0)
    # arguments without meaning are left out at their defaults; the core rejects other values
    meaningless: Mapping[str, Any] = FREE if amplitude is None else DRIVEN
    keys = {
        name: value
        for name, value in keys.items()
        if not (name in meaningless and np.array_equal(value, meaningless[name]))
    }
    keys["band"] = in_order(*r) if isinstance(r, (list, tuple)) and len(r) == 2 else r
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
