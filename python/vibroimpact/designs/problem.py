"""The design problem: candidates, uncertain units, the band, the target and the limits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ParameterError, SingularError
from ..motions.exact import exact
from ..motions.reached import perform_points
from ..motions.trajectory import simulate
from ..results import door
from ..results.performance import LEAST, LIMITED, PARAMETERS, perform
from ..systems.distribution import ELEMENTS, Uncertain, elements_of
from ..systems.oscillator import Oscillator

_Array = NDArray[np.float64]

#: The targets that can be minimised; the attenuation is max|X|/A.
TARGETS = ("attenuation", "displacement", "rms", "acceleration", "force")
#: Targets with derivatives in closed form, and the parameters.
SLOPED = ("attenuation", "displacement")
SLOPE_NAMES = ("r", "clearance", "xi", "mu", "R1", "R2", "restitution")


@dataclass(frozen=True, eq=False)
class Outcome:
    """The performance of units: the target, and the excess: the largest ratio of a figure to its limit, or of a
    lower limit to its figure (0 without limits). Both are inf for runs that failed.

    Attributes
    ----------
    target, excess : ndarray (n,)
    """

    target: _Array
    excess: _Array


class Host(Protocol):
    """The vibrating system: it computes the performance of units whose parameters are given by name."""

    def outcome(
        self, values: Mapping[str, _Array], r: _Array, load: _Array, places: _Array,
        progress: door.Progress | None, note: str,
    ) -> Outcome:  # fmt: skip
        """The outcome of each unit (n,) at a frequency, a load and an initial state (4, n)."""

    def slopes(
        self, values: Mapping[str, float], r: float, load: float, place: _Array
    ) -> dict[str, float] | None:
        """Derivatives of the target of one unit with respect to its parameters, NaN for a derivative that does not
        exist; None if there is no periodic motion."""


@dataclass(frozen=True)
class OscillatorHost:
    """The oscillator of the 1983 paper under a harmonic load.

    Attributes
    ----------
    osc : Oscillator
        Provides the parameters that are neither free nor uncertain.
    clearance : float or None
        d K/F0 at load 1.
    target : str
        A key of `TARGETS`.
    limits : mapping
        Largest allowed figures, or smallest ones for those in `LEAST`, at the load of each unit.
    settling, keep : int
        As for `perform`.
    """

    osc: Oscillator
    clearance: float | None
    target: str
    limits: Mapping[str, float]
    settling: int
    keep: int
    threads: int | None

    @property
    def wanted(self) -> tuple[str, ...]:
        """The figures that target and limits need."""
        target = ("displacement", "amplitude") if self.target == "attenuation" else (self.target,)
        return (*target, *self.limits)

    def outcome(
        self, values: Mapping[str, _Array], r: _Array, load: _Array, places: _Array,
        progress: door.Progress | None, note: str,
    ) -> Outcome:  # fmt: skip
        """As for all hosts."""
        parameters = parameters_of(self.osc, self.clearance, values, r, load)
        elements = elements_of(values, load)
        found = perform_points(
            parameters, elements, places, self.settling, self.keep, threads=self.threads, progress=progress,
            note=note, wanted=self.wanted,
        )  # fmt: skip
        if self.target == "attenuation":
            target = found.displacement / found.amplitude
        else:
            target = getattr(found, self.target) * load
        excess = np.zeros(r.shape)
        for name, limit in self.limits.items():
            figure = getattr(found, name) * load ** LIMITED[name]
            if name == "multiplier":
                # a motion with impacts but without a period has no multiplier, and violates the limit
                figure = np.where(
                    np.isnan(figure), np.where(found.impacts > 0, math.inf, 0), figure
                )
            if name in LEAST:
                over = np.divide(limit, figure, out=np.full(r.shape, math.inf), where=figure > 0)
            else:
                over = figure / limit
            excess = np.maximum(excess, over)
        failed = found.status != 0
        return Outcome(np.where(failed, math.inf, target), np.where(failed, math.inf, excess))

    def slopes(
        self, values: Mapping[str, float], r: float, load: float, place: _Array
    ) -> dict[str, float] | None:
        """As for all hosts; friction and compliant walls have none."""
        if {*ELEMENTS} & {*values}:
            return None
        one = {name: np.array([value]) for name, value in values.items()}
        numbers = parameters_of(self.osc, self.clearance, one, np.array([r]), np.array([load]))
        found = perform(
            numbers, place[:, None], self.settling, self.keep, threads=1, wanted=("multiplier",)
        )
        if self.target not in SLOPED or found.cycles[0] == 0 or found.impacts[0] == 0:
            return None
        r, clearance, xi, mu, right, left = numbers[:, 0].tolist()
        osc = Oscillator(xi=xi, mu=mu, restitution=(right, left))
        state = dict(
            zip(("t", "x", "x_dot", "z", "z_dot"), found.states[:, 0].tolist(), strict=True)
        )
        try:
            run = simulate(osc, r, clearance, cycles=4 * int(found.cycles[0]), state=state)
            motion = exact(osc, r, clearance, run)
            gradient = motion.gradient()
        except (ParameterError, SingularError):  # such as a motion with rest
            return None
        if self.target == "attenuation":
            of, sign = "attenuation", 1.0
        else:
            of, sign = ("x_max", load) if motion.x_max >= -motion.x_min else ("x_min", -load)
        slopes = {
            name: float(sign * gradient[of, {"restitution": "R"}.get(name, name)])
            for name in SLOPE_NAMES
        }
        slopes["clearance"] /= load
        return slopes


def parameters_of(
    osc: Oscillator, clearance: float | None, values: Mapping[str, _Array], r: _Array, load: _Array
) -> _Array:
    """The parameters of `perform` (6, n): lengths are in F0/K of each unit's own load."""
    right, left = osc.restitution
    known: dict[str, Any] = {
        "xi": osc.xi, "mu": osc.mu, "R1": right, "R2": left, "clearance": clearance, **values, "r": r,
    }  # fmt: skip
    if "restitution" in known:
        known["R1"] = known["R2"] = known["restitution"]
    known["clearance"] = known["clearance"] / load
    return np.stack([np.broadcast_to(known[name], r.shape) for name in PARAMETERS])


@dataclass(frozen=True)
class Problem:
    """A design problem.

    Attributes
    ----------
    host : Host
    free : dict
        Ranges (low, high) of the parameters to choose, by name.
    tolerance : dict
        Uncertain parameters: deviations or factors for free ones (see `Uncertain.around`), values for others.
    band : (float, float)
        Frequency ratios, or initial displacements.
    load : Uncertain
        Amplitude of the load.
    quantile : float
        The quantile over the units by which a design is evaluated; 1 for the worst unit.
    weighted : bool
        Whether each initial state counts separately (by basins), or only the worst state of a unit.
    limited : bool
        Whether figures have limits.
    whole : tuple of str
        Free parameters that are whole numbers.
    """

    host: Host
    free: dict[str, tuple[float, float]]
    tolerance: dict[str, Uncertain]
    band: tuple[float, float]
    load: Uncertain
    quantile: float
    weighted: bool
    limited: bool = False
    whole: tuple[str, ...] = ()

    @property
    def dimensions(self) -> int:
        """Number of uncertain parameters, including the load."""
        return len(self.tolerance) + 1

    @property
    def quick(self) -> bool:
        """Whether the core simulates many units at once; a free decay has no attractors."""
        return isinstance(self.host, OscillatorHost) and not {*ELEMENTS} & {
            *self.free,
            *self.tolerance,
        }

    @property
    def ends(self) -> tuple[_Array, _Array]:
        """Lower and upper ends (free,) of the ranges of the free parameters."""
        low, high = np.array(list(self.free.values()), dtype=float).T
        return low, high

    def at(self, shares: _Array) -> _Array:
        """Candidates (..., free) at shares from 0 to 1 of the ranges."""
        low, high = self.ends
        return self.rounded(low + (high - low) * shares)

    def shares(self, candidates: _Array) -> _Array:
        """Shares of the ranges, from 0 to 1, at which candidates (..., free) lie."""
        low, high = self.ends
        return np.asarray((candidates - low) / (high - low))

    def rounded(self, candidates: _Array) -> _Array:
        """Candidates (..., free) whose whole numbers are whole."""
        whole = [name in self.whole for name in self.free]
        return np.asarray(np.where(whole, np.rint(candidates), candidates))

    def units(self, candidates: _Array, shares: _Array) -> tuple[dict[str, _Array], _Array]:
        """Parameters (..., n) by name, and loads (n,), of units of candidates.

        Parameters
        ----------
        candidates : ndarray (..., free)
        shares : ndarray (dimensions, n)
            Probabilities whose quantiles are the uncertain parameters and the load.
        """
        shape = *candidates.shape[:-1], shares.shape[1]
        values = {
            name: np.broadcast_to(
                value[..., None].astype(int if name in self.whole else float), shape
            )
            for name, value in zip(self.free, np.moveaxis(candidates, -1, 0), strict=True)
        }
        for (name, uncertain), share in zip(self.tolerance.items(), shares, strict=False):
            these = uncertain.at(share)
            values[name] = (
                uncertain.around(values[name], these)
                if name in values
                else np.broadcast_to(these, shape)
            )
        return values, self.load.at(shares[-1])

    def outcomes(
        self, candidates: _Array, shares: _Array, nodes: _Array, places: _Array,
        runs: NDArray[np.bool_] | None = None,
    ) -> tuple[_Array, _Array]:  # fmt: skip
        """Target and excess (candidates, nodes, units, states) of each candidate, unit, frequency and initial
        state.

        Parameters
        ----------
        runs : ndarray (candidates, nodes, units, states), optional
            Which of them are simulated; the targets of the others are -inf, and their excesses 0.
        """
        shape = len(candidates), len(nodes), shares.shape[1], places.shape[1]
        # the runs of a unit are consecutive: the core keeps the data that depend only on the unit
        which = np.nonzero(np.ones(shape, bool) if runs is None else runs)
        i, node, unit, state = which
        values, load = self.units(candidates, shares)
        found = self.host.outcome(
            {name: value[i, unit] for name, value in values.items()}, nodes[node], load[unit], places[:, state],
            None, "",
        )  # fmt: skip
        target, excess = np.full(shape, -np.inf), np.zeros(shape)
        target[which], excess[which] = found.target, found.excess
        return target, excess

    def levels(self, figures: _Array) -> _Array:
        """The quantile of figures (candidates, nodes, units, states) at the worst frequency."""
        if self.weighted:
            each = figures.reshape(*figures.shape[:2], -1)
        else:
            each = _at(figures, spare_states(figures.shape[3]))
        many = each.shape[-1] - 1
        # the next higher figure, so that inf, from a failed run, is never averaged
        return np.asarray(_at(each, many - math.ceil(self.quantile * many)).max(axis=-1))


def spare_states(states: int) -> int:
    """How many initial states of a unit may be above its figure: one of 200 states."""
    return states // 200


def _at(figures: _Array, above: int) -> _Array:
    """The figure on the last axis that a number of others may be above."""
    k = figures.shape[-1] - 1 - above
    return np.asarray(np.partition(figures, k, axis=-1)[..., k])
