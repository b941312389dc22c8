"""The effect of uncertain parameters on zones of stable motions, and the probability of keeping limits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise, takewhile
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.actions import ACTIONS
from ..base.checks import Rng
from ..base.errors import ParameterError, ParameterTypeError, StudyInterrupted
from ..base.libraries import xarray
from ..base.progress import with_progress
from ..base.spacing import ascending, range_axes, range_values
from ..motions.reached import perform_points
from ..results import door
from ..results.performance import FIGURES, LEAST, LIMITED, Performance
from ..systems.distribution import (
    Uncertain,
    drawn,
    element_of,
    elements_of,
    interval,
    require_free_mass,
    shares,
    systems,
    uncertain_parameters,
)
from ..systems.oscillator import Oscillator, Pattern, Point, Stops, of_numbers, pattern_of
from ..systems.units import value_text, wanted_figure
from ..systems.verbs import physical_arguments
from .boundary_band import BoundaryBand, bands_of, keeps_symmetry, quantile_pair
from .chart import compute_chart
from .grid_motions import grid_verdicts
from .zone import Zone, zone

if TYPE_CHECKING:
    from ..systems.units import Units, Value

__all__ = [
    "LimitProbability", "Uncertainty", "limit_probability", "uncertainty",
]  # fmt: skip

_Array = NDArray[np.float64]
#: Quantities of a motion of a zone that can be limited.
OF_MOTION = ("attenuation", "displacement", "multiplier")
#: Quantities on an attractor that can be limited.
OF_ATTRACTOR = ("attenuation", *FIGURES[:-1])
#: The message of an interrupt before there is anything to keep.
UNFINISHED = "stopped before the first of {} was finished, so that there is no result"
#: The margin of the window of a zone with rest beyond the outermost points.
MARGIN = 1e-9
#: Number of samples that are simulated together; after Ctrl-C the finished ones are kept. The first ones are
#: simulated in smaller parts, so that some are finished soon.
BLOCK, FIRST = 500, (1, 8, 40, 160)


@dataclass(frozen=True, eq=False, repr=False)
class Uncertainty:
    """The probability that motions of a pattern are stable and admissible, and bands on the boundary.

    Attributes
    ----------
    osc : Oscillator
        The oscillator with the nominal values.
    pattern : Pattern
    symmetric : bool or None
        As in `Zone`.
    uncertain : dict of Uncertain
        The distributions by name.
    samples : int
        Number of samples.
    r, clearance : ndarray (m,), (n,)
        Nominal values at the points of the map.
    probability : ndarray (n, m)
        Share of the samples for which there is a stable and admissible motion.
    undecided : ndarray (n, m)
        Share of the samples without such a motion, but with one whose verdict is unknown.
    limit : dict of float
        Largest allowed quantities.
    within : ndarray (n, m) or None
        Share of the samples for which there are stable and admissible motions, all within the limits; None without
        limits.
    zone : Zone or None
        The nominal zone, if bands were requested.
    bands : list of BoundaryBand
    quantiles : (float, float)
        Quantiles at the ends of the bands.
    complete : bool
        False after Ctrl-C: `samples` is then the number of samples that were finished.
    """

    osc: Oscillator
    pattern: Pattern
    symmetric: bool | None
    uncertain: dict[str, Uncertain]
    samples: int
    r: _Array
    clearance: _Array
    probability: _Array
    undecided: _Array
    limit: dict[str, float]
    within: _Array | None
    zone: Zone | None
    bands: list[BoundaryBand]
    quantiles: tuple[float, float]
    complete: bool = True

    @property
    def standard_error(self) -> _Array:
        """An upper bound of the standard error of `probability`; 0 where all samples agree."""
        return error_of(self.probability, self.samples)

    def to_xarray(self) -> Any:
        """The maps as an xarray.Dataset with the coordinates clearance and r (extra `data`).

        The dimension `vertex` runs over the vertices of all bands; `band` is the number of the band of each
        vertex.

        Returns
        -------
        xarray.Dataset
            The maps, and the bands if there are any.
        """
        grid, vertex = ("clearance", "r"), ("vertex",)
        maps = {"probability": (self.probability, "share of samples with a stable motion"),
                "standard_error": (self.standard_error, "bound on the standard error of probability"),
                "undecided": (self.undecided, "share of samples without a verdict")}  # fmt: skip
        if self.within is not None:
            maps["within"] = self.within, "share of samples with stable motions within the limits"
        items: dict[str, Any] = {
            name: (grid, values, {"long_name": meaning, "units": "1"})
            for name, (values, meaning) in maps.items()
        }
        if self.bands:
            both = ("quantile", "vertex")
            for name in ("r", "clearance", "found", "holds"):
                values = np.concatenate([getattr(band, name) for band in self.bands])
                items[f"vertex_{name}" if name in grid else name] = (vertex, values)
            for name, dims in (
                ("normal", ("axis", "vertex")),
                ("first_order", both),
                ("sampled", both),
            ):
                items[name] = (
                    dims,
                    np.concatenate([getattr(band, name) for band in self.bands], axis=1),
                )
            for name in self.uncertain:
                values = np.concatenate([band.sensitivity[name] for band in self.bands])
                items[f"by_{name}"] = (vertex, values)
            number = np.repeat(np.arange(len(self.bands)), [len(band) for band in self.bands])
            items["band"] = (vertex, number)
            items["type"] = (vertex, np.array([self.bands[i].type for i in number]))
        coords: dict[str, Any] = {
            "r": ("r", self.r, {"long_name": "nominal frequency ratio Omega/omega", "units": "1"}),
            "clearance": ("clearance", self.clearance, {"long_name": "nominal d K/F0", "units": "1"}),
        }  # fmt: skip
        if self.bands:
            coords |= {"quantile": np.array(self.quantiles), "axis": ["r", "log clearance"]}
        right, left = self.osc.restitution
        attrs = {
            "xi": self.osc.xi, "mu": self.osc.mu, "R1": right, "R2": left, "sides": self.pattern.sides,
            "cycles": self.pattern.cycles, "samples": self.samples,
        }  # fmt: skip
        attrs |= {f"limit_{name}": value for name, value in self.limit.items()}
        return xarray("maps").Dataset(items, coords, attrs)

    def plot(
        self, ax: Any = None, inverse: bool = False, what: str = "probability", units: Units | str | None = None,
    ) -> Any:  # fmt: skip
        """Draw the map as colours, the nominal boundary, and the bands (extra `plot`).

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw on; by default those of a new figure.
        inverse : bool
            Draw F0/(d K) on the vertical axis, as in Figures 6 to 8 of the 1983 paper, instead of d K/F0.
        what : {"probability", "within"}
            The map that is drawn.
        units : Units or str, optional
            As in `Trajectory.plot`.

        Returns
        -------
        Axes
            The Axes with the picture.
        """
        return ACTIONS["draw"](self, ax, inverse, what, units=units)

    def __repr__(self) -> str:
        held = sum(int(band.holds.sum()) for band in self.bands)
        bands = f", first order holds at {held} of {sum(map(len, self.bands))} vertices"
        return (
            f"<Uncertainty of {self.pattern.sides}/{self.pattern.cycles}: {len(self.r)} frequency ratios, "
            f"{len(self.clearance)} clearances, {self.samples} samples{bands if self.bands else ''}"
            f"{'' if self.complete else '; interrupted'}>"
        )


@overload
def uncertainty(
    osc: Oscillator, pattern: Pattern | str, r: ArrayLike, clearance: ArrayLike, uncertain: Mapping[str, Any],
    symmetric: bool | None = None, **options: Any,
) -> Uncertainty: ...  # fmt: skip
@overload
def uncertainty(
    point: Point, /, pattern: Pattern | str, uncertain: Mapping[str, Any], symmetric: bool | None = None,
    **options: Any,
) -> Uncertainty: ...  # fmt: skip


@physical_arguments  # type: ignore[misc]  # the other form
@with_progress
def uncertainty(
    osc: Oscillator,
    pattern: Pattern | str,
    r: ArrayLike,
    clearance: ArrayLike,
    uncertain: Mapping[str, Any],
    symmetric: bool | None = None,
    *,
    friction: float = 0.0,
    stops: Stops | None = None,
    points: int | tuple[int, int] | None = None,
    limit: Mapping[str, float] | None = None,
    samples: int = 64,
    bands: bool = True,
    vertices: int = 40,
    quantiles: tuple[float, float] = (0.025, 0.975),
    rng: Rng = 0,
    threads: int | None = None,
    progress: door.Progress | None = None,
) -> Uncertainty:
    """The probability that motions of a pattern are stable if parameters are uncertain.

    The samples are a Latin hypercube, so that the standard error is at most that of independent samples. For each
    sample a chart of the pattern is computed, or its zone if the pattern has rest.

    With friction in the slot or compliant walls, each sample is treated as a structure. A motion has the pattern
    if its contacts do, whatever friction does in between; with equal walls the mirror image of the pattern counts
    as well. Newton's method starts from the motions of the chart without friction between rigid walls, and from
    simulations; each motion is followed from point to point of the map, and where no stable one is known,
    simulations start from the motions nearby. Motions that none of these lead to are missed.

    Parameters
    ----------
    osc : Oscillator
        The oscillator with the nominal values.
    pattern : Pattern or str
        The pattern, or a str such as "RL" or "RL/2" (sides/cycles).
    r, clearance : array_like, or (float, float)
        Nominal frequency ratios and clearances d K/F0 that rise or fall throughout; d is the whole travel of m
        between the walls. With `points` each is a range (lo, hi), or one number. Bands require at least two values
        of each: the outermost ones define the window of the nominal zone.
    uncertain : dict
        Uncertain parameters by name: values of xi, mu, R1, R2 or restitution (equal on both walls); for r,
        clearance and load, factors of the nominal values, above 0 and with 1 in their range, as in tolerances of
        `design`: a gap of 0.0105 +- 0.001 in is ``clearance=(0.0095 / 0.0105, 0.0115 / 0.0105)``. Deviations are
        rejected, since one deviation would not suit all clearances of a map. Where there is a single nominal
        value, a range with units, such as ("3.8 mm", "4.2 mm"), is converted to factors. Each is a pair (low,
        high) between which all values are equally probable, a frozen distribution of scipy.stats, or a number.
        They are independent. Also values of ``friction`` in the slot (over F0), and of ``wall_stiffness`` and
        ``wall_damping`` (over K and sqrt(K M)): of the compliant walls, or of both walls if `stops` is omitted.
    symmetric : bool, optional
        As in `zone` and `chart`.
    friction, stops : float, tuple or None
        Nominal friction in the slot and nominal walls, as in `Oscillator.at`; a `Point` provides both.
    points : int or (int, int), optional
        Numbers of evenly spaced values in these ranges.
    limit : dict, optional
        Largest allowed attenuation (max|x|/A), displacement (max|x|, in F0/K of the nominal load) or multiplier
        (modulus) of the motions.
    samples : int
        1 to 100000. Each takes as long as a chart.
    bands : bool
        Whether to trace the nominal zone and to find the bands, as `boundary_bands` does; False with friction or
        compliant walls.
    vertices : int
        Largest number of vertices of a piece that are examined, 2 to 10000.
    quantiles : (float, float)
        As in `boundary_bands`.
    rng : int, numpy.random.Generator or None
        Seed of the random numbers, from 0 to 2**31 - 1, or a generator from which a seed is drawn; None: another
        seed in each call. The same seed gives the same result, for any number of threads.
    threads : int, optional
        Default: one for each processor.
    progress : callable, optional
        As in `chart`; an exception that it raises ends the computation.

    Returns
    -------
    Uncertainty
        The map of probabilities, and the bands.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.
    StudyInterrupted
        After Ctrl-C, if a sample was finished: its attribute `result` contains the finished samples.
    KeyboardInterrupt
        After Ctrl-C before that; the message says so.

    Examples
    --------
    >>> import numpy as np, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> found = vi.uncertainty(
    ...     osc, "RL", np.linspace(0.9, 1.1, 11), np.geomspace(5, 100, 9),
    ...     dict(xi=(0.0109, 0.0119), clearance=(0.905, 1.095)), symmetric=True, samples=16,
    ... )
    >>> found.probability.shape, found.zone.closed
    ((9, 11), True)
    >>> bool((found.probability[found.zone.contains(found.r, found.clearance[:, None])] > 0.3).all())
    True
    """
    of_numbers(osc)
    pattern = pattern_of(pattern)
    nominal_point = osc.at(1.5, 1.0, friction=friction, stops=stops)
    rubs, walls = nominal_point.friction, nominal_point.stops
    parameters = uncertain_parameters(uncertain, "uncertain", True, True, walls)
    limits = limits_of(limit, OF_MOTION)
    count = checks.integer(samples, "samples", 1, 100_000)
    wanted = checks.truth(bands, "bands")
    ends = quantile_pair(quantiles)
    number = checks.seed_of(rng)
    r, clearance = map(ascending, range_axes(r, clearance, points))
    axes = axis(r, "r"), axis(clearance, "clearance")
    if limits and pattern.has_rest:
        raise ParameterError("limit: must be left out for a pattern with rest, which has no chart")
    where = shares(count, len(parameters), np.random.default_rng(number))
    changes, values_of = systems(osc, parameters, where), drawn(parameters, where)
    load, elements = values_of["load"], elements_of(values_of, values_of["load"], rubs, walls)
    if elements and wanted:
        raise ParameterError(
            "bands = True: must be False with friction in the slot or compliant walls, since bands of their zones "
            "have not been implemented"
        )
    if wanted and min(map(len, axes)) < 2:
        raise ParameterError(
            "bands = True: must be False where r or clearance has a single value; bands require a window with at "
            "least two values of each"
        )
    if elements and pattern.has_rest:
        raise ParameterError(
            f"pattern = {pattern.sides}/{pattern.cycles}: must be without rest with friction in the slot or "
            "compliant walls"
        )
    if elements:
        require_free_mass(changes[3])
    for values, factors, name in zip(axes, changes, ("r", "clearance"), strict=False):
        for value in (values[0] * factors.min(), values[-1] * factors.max()):
            checks.number(float(value), name)
    if wanted:
        keeps_symmetry(osc, changes)
    told = Told(progress, 0.8 if wanted else 1.0)
    _, first, times = np.unique(
        np.nan_to_num(np.vstack([changes, load, *elements.values()]), nan=-1.0), axis=1, return_index=True,
        return_counts=True,
    )  # fmt: skip
    total = np.zeros((3, len(axes[1]), len(axes[0])))
    nominal, found, done, stopped = None, [], 0, False
    try:
        # in the order in which they were drawn, so that the first ones are a valid sample, too
        for i, here in enumerate(np.argsort(first)):
            told.part(i, len(times), "samples")
            n = first[here]
            total += times[here] * verdicts(
                osc, pattern, axes, changes[:, n], load[n], element_of(elements, n), symmetric, limits,
                threads, told,
            )  # fmt: skip
            done += int(times[here])
        if wanted:
            nominal = zone(
                osc, pattern, window_of(axes[0]), window_of(axes[1]), symmetric=symmetric
            )
            found = bands_of(nominal, parameters, changes, vertices, ends, threads, told.last)
    except KeyboardInterrupt:
        if not done:
            # not that of a part, whose result is one sample or less
            raise KeyboardInterrupt(UNFINISHED.format(f"{count} samples")) from None
        stopped = True
    total /= done
    answer = Uncertainty(
        osc, pattern, symmetric, parameters, done, axes[0], axes[1], total[0], total[1], limits,
        total[2] if limits else None, nominal if found else None, found, ends, not stopped,
    )  # fmt: skip
    if stopped:
        raise StudyInterrupted(answer)
    return answer


@dataclass(frozen=True, eq=False, repr=False)
class LimitProbability:
    """The probability that a system stays within limits on the attractor on which it settles.

    Attributes
    ----------
    osc : Oscillator
        The nominal system.
    r, clearance : ndarray
        Nominal values of the points; all arrays have their shape.
    probability : ndarray
        Share of the samples that stay within all limits; NaN at points that were not computed because of Ctrl-C.
    low, high : ndarray
        The Clopper–Pearson interval; failed samples count as outside the limits for `low` and inside for `high`.
    failed : ndarray of int
        Samples without a result, for example because there were too many events.
    samples, starts : int
    confidence : float
        Confidence of the interval.
    limit : dict of float
        The limits, dimensionless.
    complete : bool
        False after Ctrl-C.
    """

    osc: Oscillator
    r: _Array
    clearance: _Array
    probability: _Array
    low: _Array
    high: _Array
    failed: NDArray[np.int64]
    samples: int
    starts: int
    confidence: float
    limit: dict[str, float]
    complete: bool = True

    def __repr__(self) -> str:
        shown = ", ".join(
            f"{name} {'>=' if name in LEAST else '<='} {value_text(self.osc, name, value)}"
            for name, value in self.limit.items()
        )
        of = f"{self.samples} samples{'' if self.complete else '; interrupted'}"
        if self.probability.size != 1:
            least, most = np.nanmin(self.probability), np.nanmax(self.probability)
            points = f"{least:.4g} to {most:.4g} at {self.probability.size} points"
            return f"<LimitProbability of {shown}: {points}, {of}>"
        share, low, high = (float(one.flat[0]) for one in (self.probability, self.low, self.high))
        return (
            f"<LimitProbability of {shown}: {share:.4g} ({100 * self.confidence:g} % interval {low:.4g} to "
            f"{high:.4g}), {of}>"
        )

    def to_xarray(self) -> Any:
        """The arrays as an xarray.Dataset with the dimension `point` (extra `data`).

        Returns
        -------
        xarray.Dataset
            The probability and its interval at each point.
        """
        items = {
            name: (("point",), np.ravel(getattr(self, name)))
            for name in ("probability", "low", "high", "failed", "r", "clearance")
        }
        attrs = {
            "samples": self.samples, "starts": self.starts, "confidence": self.confidence,
            **{f"limit_{name}": value for name, value in self.limit.items()},
        }  # fmt: skip
        return xarray("probabilities").Dataset(items, attrs=attrs)


@overload
def limit_probability(
    osc: Oscillator, r: ArrayLike, clearance: ArrayLike, uncertain: Mapping[str, Any],
    limit: Mapping[str, Value], **options: Any,
) -> LimitProbability: ...  # fmt: skip
@overload
def limit_probability(
    point: Point, /, uncertain: Mapping[str, Any], limit: Mapping[str, Value], **options: Any,
) -> LimitProbability: ...  # fmt: skip


@physical_arguments  # type: ignore[misc]  # the other form
@with_progress
def limit_probability(
    osc: Oscillator,
    r: ArrayLike,
    clearance: ArrayLike,
    uncertain: Mapping[str, Any],
    limit: Mapping[str, float],
    *,
    friction: float = 0.0,
    stops: Stops | None = None,
    samples: int = 1000,
    points: int | None = None,
    starts: int = 1,
    confidence: float = 0.95,
    settling: int = 400,
    max_events: int = 1_000_000,
    rng: Rng = 0,
    threads: int | None = None,
    progress: door.Progress | None = None,
) -> LimitProbability:
    """The probability that a system with uncertain parameters stays within limits.

    Each sample is an independent system, simulated from random initial states until it settles. With one start,
    the attractor of a sample is chosen at random, as by a disturbance; with more, all attractors that the starts
    reach must be within the limits.

    Parameters
    ----------
    osc : Oscillator
        The oscillator with the nominal values.
    r, clearance : array_like
        Nominal frequency ratios and clearances d K/F0 (d is the whole travel of m) of the points, broadcast
        against each other. With `points` each is a range (lo, hi), or one number.
    uncertain : dict
        As in `uncertainty`; also values of ``friction`` in the slot (over F0), and of ``wall_stiffness`` and
        ``wall_damping`` (over K and sqrt(K M)): of the compliant walls, or of both walls if `stops` is omitted.
        Samples with any of these are simulated as structures.
    limit : dict
        Largest allowed attenuation (max|x|/A), displacement, rms, acceleration or force of the primary mass,
        approach speed of impacts, or modulus of the multipliers (0 without impacts; a motion without a period
        violates this limit), in the units of `Motion` at the nominal load, whatever the load of a sample is; or
        smallest allowed distances to boundaries, least_speed and least_gap, as in `design`.
    friction, stops : float, tuple or None
        Nominal friction in the slot and nominal walls, as in `Oscillator.at`; a `Point` provides both.
    samples : int
        Number of samples for each point, 1 to 1000000.
    points : int, optional
        Number of evenly spaced values of a range.
    starts : int
        Number of initial states for each sample, 1 to 1000.
    confidence : float
        Confidence of the interval for the probability, between 0 and 1.
    settling : int
        Load cycles after which a simulation without a period counts as settled, 8 to 1000000.
    max_events : int
        Events after which a simulation fails, 1000 to 1000000000.
    rng : int, numpy.random.Generator or None
        Seed of the samples and initial states, as in `uncertainty`.
    threads : int, optional
        Default: one for each processor.
    progress : callable, optional
        As in `uncertainty`.

    Returns
    -------
    LimitProbability
        The probability at each point, with its interval.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.
    StudyInterrupted
        After Ctrl-C, if any samples were finished: its attribute `result` contains the finished points; if not
        even the first point was finished, it has this point with fewer samples.
    KeyboardInterrupt
        After Ctrl-C before that; the message says so.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> found = vi.limit_probability(
    ...     osc, 1.04, 25.0, dict(restitution=(0.68, 0.75)), dict(attenuation=0.6), samples=50
    ... )
    >>> float(found.probability), float(found.low) > 0.9
    (1.0, True)
    """
    of_numbers(osc)
    point = osc.at(1.5, 1.0, friction=friction, stops=stops)
    rubs, walls = point.friction, point.stops
    parameters = uncertain_parameters(uncertain, "uncertain", True, True, walls)
    limits = limits_of(limit, OF_ATTRACTOR)
    if not limits:
        raise ParameterError(
            f"limit = {limit!r}: must have at least one of {', '.join(OF_ATTRACTOR)}"
        )
    count = checks.integer(samples, "samples", 1, 1_000_000)
    tries = checks.integer(starts, "starts", 1, 1000)
    share = checks.to_float(confidence, "confidence", "a number between 0 and 1")
    if not 0 < share < 1:
        raise ParameterError(f"confidence = {confidence!r}: must be a number between 0 and 1")
    cycles = checks.integer(settling, "settling", 8, 1_000_000)
    events = checks.integer(max_events, "max_events", 1000, 10**9)
    random = np.random.default_rng(checks.seed_of(rng))
    r = range_values(r, "r", points)
    clearance = range_values(clearance, "clearance", points)
    places_of = checks.one_shape(r=r, clearance=clearance)
    if not 0 < places_of[0].size * count * tries <= checks.MOST_NUMBERS:
        raise ParameterError(
            f"r, clearance, samples, starts: {places_of[0].size} points, {count} samples and {tries} starts are "
            f"{places_of[0].size * count * tries} simulations: must be 1 to {checks.MOST_NUMBERS}"
        )
    where = random.random((len(parameters), count))
    changes, values_of = systems(osc, parameters, where), drawn(parameters, where)
    load, elements = values_of["load"], elements_of(values_of, values_of["load"], rubs, walls)
    if elements and "least_gap" in limits:
        raise ParameterError(
            f"limit['least_gap'] = {limits['least_gap']!r}: must be left out with friction or compliant walls"
        )
    for values, factors, name in zip(places_of, changes, ("r", "clearance"), strict=False):
        for value in (values.min() * factors.min(), values.max() * factors.max()):
            checks.number(float(value), name)
    places = random.uniform(-1, 1, (4, count * tries))
    ends = [*takewhile(lambda end: end < count, (0, *FIRST, *range(BLOCK, count, BLOCK))), count]
    told = Told(progress, 1.0)
    answers: list[tuple[float, ...]] = []
    stopped = False
    for i, (x, y) in enumerate(zip(places_of[0].flat, places_of[1].flat, strict=True)):
        here = changes.copy()
        here[0] *= x
        here[1] *= y
        if osc.xi == 0 or here[2].min() == 0:
            for value in here[0, here[2] == 0]:
                checks.frequency_ratio(float(value), 0.0)
        blocks = []
        try:
            for begin, end in pairwise(ends):
                part = slice(begin, end)
                length = (part.stop - begin) / count
                told.part(i + begin / count, places_of[0].size, "points", length)
                done = perform_points(
                    np.repeat(here[:, part], tries, axis=1),
                    {key: np.repeat(one[..., part], tries, axis=-1) for key, one in elements.items()},
                    places[:, part.start * tries : part.stop * tries], cycles, 64, events, threads, told.inner,
                    "simulate", figures_of(limits),
                )  # fmt: skip
                blocks.append(judged(done, limits, tries, np.repeat(load[part], tries)))
        except KeyboardInterrupt:
            stopped = True
            if answers or not blocks:
                break
            count = begin
        whole, lost = np.concatenate(blocks, axis=1)
        low, _ = interval(int(whole.sum()), count, share)
        _, high = interval(int((whole | lost).sum()), count, share)
        answers.append((whole.mean(), low, high, lost.sum()))
        if stopped:
            break
    if not answers:
        raise KeyboardInterrupt(UNFINISHED.format(f"{count} samples of the first point"))
    answers += [(np.nan, np.nan, np.nan, 0)] * (places_of[0].size - len(answers))
    table = np.array(answers, dtype=np.float64).T.reshape(4, *places_of[0].shape)
    found = LimitProbability(
        osc, places_of[0].copy(), places_of[1].copy(), table[0], table[1], table[2], table[3].astype(np.int64),
        count, tries, share, limits, not stopped,
    )  # fmt: skip
    if stopped:
        raise StudyInterrupted(found)
    return found


def figures_of(limits: Mapping[str, float]) -> set[str]:
    """The figures that `judged` needs."""
    return {"displacement", "amplitude"} | set(limits) if "attenuation" in limits else set(limits)


def judged(
    done: Performance, limits: Mapping[str, float], tries: int, load: _Array
) -> NDArray[np.bool_]:
    """Whether samples, each with some initial states, stay within all limits, and whether they failed so that this
    is not known; (2, n). The figures are those at load 1, and the load that of each initial state."""
    good = done.status == 0
    kept = good.copy()
    for name, limited in limits.items():
        values = (
            done.displacement / done.amplitude
            if name == "attenuation"
            else getattr(done, name) * load ** LIMITED[name]
        )
        if name == "multiplier":
            values = np.where(done.impacts == 0, 0.0, values)
        kept &= values >= limited if name in LEAST else values <= limited
    whole, known, may = (one.reshape(-1, tries).all(axis=1) for one in (kept, good, kept | ~good))
    return np.array([whole, may & ~known])


def error_of(probability: _Array, samples: int) -> _Array:
    """The standard error of a share of independent samples, an upper bound for a Latin hypercube."""
    return np.sqrt(probability * (1 - probability) / max(1, samples - 1))


def limits_of(limit: Any, names: tuple[str, ...]) -> dict[str, float]:
    """Limits by name, each a positive number."""
    if limit is None:
        return {}
    if not isinstance(limit, Mapping):
        raise ParameterTypeError(
            f"limit = {limit!r}: must be a dict of quantities with their limits, such as "
            f"{{'displacement': 3.0}}, not {type(limit).__name__}"
        )
    found = {}
    for key, value in limit.items():
        if key not in names:
            raise ParameterError(
                f"limit: unknown quantity {key!r}: must be one of {', '.join(names)}"
            )
        wanted = wanted_figure(key)
        found[key] = checks.to_float(value, f"limit[{key!r}]", wanted)
        if not 0 < found[key] < np.inf:
            raise ParameterError(f"limit[{key!r}] = {value!r}: must be {wanted}")
    return found


def axis(values: ArrayLike, name: str) -> _Array:
    """Increasing numbers, as an array that a caller cannot change."""
    wanted = "increasing or decreasing numbers, one list"
    found: _Array = np.atleast_1d(checks.real_array(values, name, wanted)).copy()
    if found.ndim != 1 or found.size == 0 or not (np.diff(found) > 0).all():
        raise ParameterError(f"{name} of shape {found.shape}: must be {wanted}")
    for value in (found[0], found[-1]):
        checks.number(float(value), name)
    found.flags.writeable = False
    return found


def window_of(values: _Array, margin: float = 0.0) -> tuple[float, float]:
    """The lowest and the highest value, moved apart by a fraction of themselves."""
    return float(values[0]) * (1 - margin), float(values[-1]) * (1 + margin)


def verdicts(
    osc: Oscillator, pattern: Pattern, axes: tuple[_Array, _Array], change: _Array, load: float,
    element: tuple[float, Stops | None], symmetric: bool | None, limits: Mapping[str, float],
    threads: int | None, told: Told,
) -> _Array:  # fmt: skip
    """For one sample: whether a stable motion exists, whether this is unknown, whether all are within the limits;
    (3, n, m). The load is a factor of the nominal one; the element: friction and walls as in `Oscillator.at`."""
    system = Oscillator(
        xi=float(change[2]), mu=float(change[3]), restitution=tuple(change[4:].tolist())
    )
    r, clearance = axes[0] * change[0], axes[1] * change[1]
    if any(element):
        return grid_verdicts(
            system, pattern, (r, clearance), *element, load, symmetric, limits, threads, told.inner
        )
    if pattern.has_rest:
        window = window_of(r, MARGIN), window_of(clearance, MARGIN)
        found = zone(system, pattern, *window, symmetric=symmetric, progress=told.inner)
        points = r[None, :], clearance[:, None]
        inside = found._turns(*points) > 0
        return np.stack([inside, found.undecided(*points), inside])
    chart = compute_chart(
        system, pattern, r, clearance, symmetric, "multiplier" in limits, threads, told.inner
    ).variables
    exists = chart["status"].values == 0
    admissible, stable = (chart[name].values for name in ("admissible", "stable"))
    good = exists & (chart["consistent"].values == 1) & (admissible == 1) & (stable == 1)
    unknown = exists & (admissible != 0) & (stable != 0) & ~good
    kept = np.ones_like(good)
    of_motion: dict[str, Callable[[], _Array]] = {
        "attenuation": lambda: chart["attenuation"].values,
        "displacement": lambda: load * np.maximum(-chart["x_min"].values, chart["x_max"].values),
        "multiplier": lambda: chart["multiplier_modulus"].values[0],
    }
    for name, greatest in limits.items():
        kept &= of_motion[name]() <= greatest
    there = good.any(axis=0)
    return np.stack(
        [there, ~there & unknown.any(axis=0), there & (kept | ~good).all(axis=0)]
    ).astype(np.float64)


class Told:
    """Reports the progress of a computation in parts to the caller's progress function."""

    def __init__(self, progress: door.Progress | None, first: float) -> None:
        checks.progress(progress)
        self.progress = progress
        self.first = first
        self.begin = self.length = 0.0
        self.note = ""

    def part(self, i: float, parts: int, note: str, length: float = 1.0) -> None:
        """Report that part i of several parts, or a fraction of a part, begins."""
        self.begin, self.length = self.first * i / parts, self.first * length / parts
        self.note = f"{note} {int(i) + 1}/{parts}"

    @property
    def inner(self) -> door.Progress | None:
        """A progress function for a part."""
        if self.progress is None:
            return None
        return lambda share, _: self._tell(self.begin + self.length * share, self.note)

    @property
    def last(self) -> door.Progress | None:
        """A progress function for the bands, which are computed last."""
        if self.progress is None:
            return None
        return lambda share, _: self._tell(self.first + (1 - self.first) * share, "bands")

    def _tell(self, share: float, note: str) -> None:
        assert self.progress is not None
        self.progress(share, note)
