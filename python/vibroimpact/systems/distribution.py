"""Uncertain parameters: a value, a range, quantiles, or a normal distribution."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError
from .oscillator import Oscillator, Stops

#: Parameters of an oscillator and its clearance that may be uncertain, and the names of their ranges.
RANGE_OF = {
    "xi": "xi", "mu": "mu", "R1": "restitution", "R2": "restitution", "restitution": "restitution",
    "clearance": "clearance",
}  # fmt: skip
#: Standard deviations beyond which a normal distribution is cut off.
CUT = 6.0
#: Number of quantiles that represent a SciPy distribution that is neither normal nor uniform, and the probability
#: that is cut off at each of its ends.
QUANTILES, TAIL = 1001, 1e-9
#: Parameters whose nominal values are those of a point, and that may be uncertain by a factor.
FACTORS = ("r", "clearance", "load")
#: Friction in the slot over F0, and stiffness over K and damping over sqrt(K M) of the compliant walls, or of both
#: if none does.
ELEMENTS = ("friction", "wall_stiffness", "wall_damping")
#: Rows of `systems`.
ROWS = ("r", "clearance", "xi", "mu", "R1", "R2")


@dataclass(frozen=True)
class Uncertain:
    """A random variable.

    Attributes
    ----------
    numbers : tuple of float
        Quantiles at evenly spaced probabilities, linear in between; two numbers are the range of a uniform
        distribution. For a normal distribution, mean and standard deviation.
    normal : bool
        Whether it is a normal distribution, which is cut off at 6 standard deviations.
    """

    numbers: tuple[float, ...]
    normal: bool = False

    @property
    def low(self) -> float:
        """The smallest value."""
        return self.numbers[0] - CUT * self.numbers[1] if self.normal else self.numbers[0]

    @property
    def high(self) -> float:
        """The largest value."""
        return self.numbers[0] + CUT * self.numbers[1] if self.normal else self.numbers[-1]

    @property
    def middle(self) -> float:
        """Its median."""
        return float(self.at(np.array([0.5]))[0])

    @property
    def text(self) -> str:
        """The distribution in words."""
        if self.normal:
            return f"normal, mean {self.numbers[0]:.6g}, standard deviation {self.numbers[1]:.6g}"
        count = f" by {len(self.numbers)} quantiles" if len(self.numbers) > 2 else ""
        return f"{self.low:.6g} to {self.high:.6g}{count}"

    @property
    def meaning(self) -> str:
        """How `around` interprets the values: as factors or deviations."""
        return " (factors)" if self.low > 0 else " (deviations)"

    def around(self, nominal: Any, values: Any) -> Any:
        """Values of a parameter around its nominal value: factors if all are positive, otherwise deviations.

        Deviations include 0 and factors are above 0, so the two cannot be confused.
        """
        return nominal * values if self.low > 0 else nominal + values

    def require_around(self, name: str) -> None:
        """Reject values that are neither deviations from a nominal value nor factors of it.

        Raises
        ------
        ParameterError
            Gives the name, the values and what is allowed.
        """
        zero = 1.0 if self.low > 0 else 0.0
        if not (self.numbers[0] == zero if self.normal else self.low <= zero <= self.high):
            raise ParameterError(
                f"{name} = {self.numbers}: must be deviations with 0 among them, or factors above 0 with 1 among "
                "them; if normal, with mean 0 or 1"
            )

    def at(self, shares: NDArray[np.float64]) -> NDArray[np.float64]:
        """The quantiles for probabilities between 0 and 1."""
        if not self.normal:
            return np.interp(shares, np.linspace(0, 1, len(self.numbers)), self.numbers)
        from scipy.special import ndtri

        mean, deviation = self.numbers
        return np.asarray(mean + deviation * np.clip(ndtri(shares), -CUT, CUT))


def uncertain(value: Any, name: str) -> Uncertain:
    """An uncertain parameter from the value that a caller gives.

    Parameters
    ----------
    value : float, sequence or distribution
        A number, a range (low, high) in which all values are equally likely, three or more quantiles at evenly
        spaced probabilities, or a frozen distribution of scipy.stats. A distribution that is neither normal nor
        uniform is represented by 1001 quantiles, of which the outermost are at probabilities 1e-9 and 1 - 1e-9.
    name : str
        For messages.

    Raises
    ------
    ParameterError, ParameterTypeError
        If it has none of these forms, or is not finite.

    Examples
    --------
    >>> from vibroimpact.systems.distribution import uncertain
    >>> uncertain((0.6, 0.8), "restitution").middle
    0.7
    """
    wanted = (
        "a number, a range (low, high), quantiles in order, or a frozen distribution of scipy.stats"
    )
    if hasattr(value, "ppf"):
        found = _of_scipy(value)
    else:
        if isinstance(value, str) or np.ndim(value) > 1 or np.size(value) == 0:
            raise ParameterTypeError(f"{name} = {value!r}: must be {wanted}")
        items = np.atleast_1d(np.asarray(value, dtype=object)).tolist()
        numbers = tuple(checks.to_float(item, name, wanted) for item in items)
        found = Uncertain(numbers if len(numbers) > 1 else 2 * numbers)
    steps = found.numbers[1:] if found.normal else np.diff(found.numbers)
    if not (np.isfinite(found.numbers).all() and np.min(steps) >= 0):
        raise ParameterError(f"{name} = {value!r}: must be {wanted}, finite and with low <= high")
    return found


def _of_scipy(distribution: Any) -> Uncertain:
    """A frozen distribution of scipy.stats."""
    kind = getattr(getattr(distribution, "dist", None), "name", "")
    if kind == "norm":
        return Uncertain((float(distribution.mean()), float(distribution.std())), normal=True)
    if kind == "uniform":
        return Uncertain((float(distribution.ppf(0)), float(distribution.ppf(1))))
    shares = np.clip(np.linspace(0, 1, QUANTILES), TAIL, 1 - TAIL)
    return Uncertain(tuple(float(value) for value in distribution.ppf(shares)))


def uncertain_parameters(
    given: Any, name: str, factors: bool = False, elements: bool = False, stops: Stops | None = None
) -> dict[str, Uncertain]:
    """Uncertain parameters by name; `restitution` is one value that applies to both walls.

    With `factors`, values of r, clearance and load are factors of their nominal values. With `elements`,
    parameters listed in `ELEMENTS` may be among them; `stops` are then the nominal walls, as in `Point`.

    Raises
    ------
    ParameterError, ParameterTypeError
        If there is no such parameter, or a value is not allowed.
    """
    if not isinstance(given, Mapping):
        raise ParameterTypeError(
            f"{name} = {given!r}: must be a dict of parameters, not {type(given).__name__}"
        )
    names = tuple(RANGE_OF | dict.fromkeys(FACTORS)) if factors else tuple(RANGE_OF)
    names += ELEMENTS if elements else ()
    for key in given:
        if key in ELEMENTS and not elements:
            raise ParameterError(
                f"{name}: parameter {key!r}: must be left out; uncertainty (without bands), limit_probability and "
                "design vary it"
            )
        if key not in names:
            raise ParameterError(
                f"{name}: unknown parameter {key!r}: must be one of {', '.join(names)}"
            )
    if "restitution" in given and ("R1" in given or "R2" in given):
        raise ParameterError(f"{name}: must have restitution, or R1 and R2, not both")
    if elements:
        require_rigid(given, name, stops)
    found = {key: uncertain(value, f"{name}[{key!r}]") for key, value in given.items()}
    for key, item in found.items() if factors else ():
        if key in ELEMENTS:
            for value in (item.low, item.high):
                checks.number(value, key, f"{name}[{key!r}]")
        elif key not in FACTORS:
            in_range(key, item.low, item.high, f"{name}[{key!r}]")
        elif not 0 < item.low <= 1 <= item.high:
            raise ParameterError(
                f"{name}[{key!r}] = {given[key]!r}: must be factors of the nominal {key}, above 0, "
                f"with low <= 1 <= high; here {item.low:g} to {item.high:g}"
            )
    return found


def require_rigid(names: Iterable[str], name: str, stops: Stops | None = None) -> None:
    """Reject coefficients of restitution of compliant walls, and damping of rigid walls.

    Parameters
    ----------
    names : iterable of str
        The parameters that vary.
    name : str
        For messages.
    stops : tuple or None
        As in `Point`.

    Raises
    ------
    ParameterError
        Names the parameter.
    """
    names = {*names}
    soft = [wall is not None for wall in stops] if stops else 2 * ["wall_stiffness" in names]
    if "wall_damping" in names and not any(soft):
        raise ParameterError(
            f"{name}: parameter 'wall_damping': must be given with a wall_stiffness, since rigid walls have none"
        )
    for key, walls in (("R1", soft[:1]), ("R2", soft[1:]), ("restitution", soft)):
        if key in names and all(walls):
            raise ParameterError(
                f"{name}: parameter {key!r}: must be left out for a compliant wall, which has no restitution"
            )


def require_free_mass(mu: NDArray[np.float64]) -> None:
    """Reject samples without a free mass where friction or compliant walls act on it.

    Parameters
    ----------
    mu : ndarray (n,)
        The mass ratios of the samples.

    Raises
    ------
    ParameterError
        If one of them is 0.
    """
    if (mu <= 0).any():
        raise ParameterError(
            f"mu = {float(mu.min())!r}: must be above 0 in all samples with friction in the slot or compliant "
            "walls, which act on the free mass"
        )


def shares(count: int, items: int, random: np.random.Generator) -> NDArray[np.float64]:
    """A Latin hypercube: (items, count) numbers between 0 and 1, one in each of `count` equal parts of each row.

    The variance of a mean over its columns is at most count/(count - 1) times that over independent samples.
    """
    order = random.permuted(np.tile(np.arange(count), (items, 1)), axis=1)
    return np.asarray((order + random.random((items, count))) / count)


def systems(
    osc: Oscillator, parameters: Mapping[str, Uncertain], where: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Systems whose uncertain parameters have the values at given quantiles.

    Parameters
    ----------
    osc : Oscillator
        The oscillator with the nominal values.
    parameters : dict of Uncertain
        As in `uncertain_parameters` with `factors`.
    where : ndarray (parameters, n)
        Probabilities between 0 and 1.

    Returns
    -------
    ndarray (6, n)
        Rows `ROWS`: factors of r and of the clearance over the load, then xi, mu, R1, R2.
    """
    nominal = np.array([1.0, 1.0, osc.xi, osc.mu, *osc.restitution])
    found = np.repeat(nominal[:, None], where.shape[1], axis=1)
    for share, (key, item) in zip(where, parameters.items(), strict=True):
        values = item.at(share)
        if key in ELEMENTS:
            continue
        if key == "load":
            found[1] /= values
        elif key in FACTORS:
            found[ROWS.index(key)] *= values
        else:
            for row in ("R1", "R2") if key == "restitution" else (key,):
                found[ROWS.index(row)] = values
    return found


def drawn(
    parameters: Mapping[str, Uncertain], where: NDArray[np.float64]
) -> dict[str, NDArray[np.float64]]:
    """Values (n,) by name at the quantiles of `systems`, with a load in any case."""
    found = {
        key: item.at(share) for share, (key, item) in zip(where, parameters.items(), strict=True)
    }
    return {"load": np.ones(where.shape[1])} | found


def elements_of(
    values: Mapping[str, Any],
    load: NDArray[np.float64],
    friction: float = 0.0,
    stops: Stops | None = None,
) -> dict[str, NDArray[np.float64]]:
    """Friction and compliant walls of units, in the form that `perform_points` takes.

    Parameters
    ----------
    values : mapping
        Values (n,) by name; only parameters listed in `ELEMENTS` are used.
    load : ndarray (n,)
        The loads; friction is divided by them.
    friction : float
        The nominal friction.
    stops : tuple or None
        The nominal walls, as in `Point`.

    Returns
    -------
    dict of ndarray
        Friction (n,), and stiffness and damping (2, n), NaN for a rigid wall; empty if there is neither friction
        nor a compliant wall.
    """
    soft = bool(stops) or "wall_stiffness" in values
    if not (soft or friction or "friction" in values):
        return {}
    found = {"friction": np.asarray(values.get("friction", friction) / load)}
    for j, key in enumerate(ELEMENTS[1:]) if soft else ():
        nominal = np.array(
            [wall[j] if wall else np.nan for wall in stops or ((0.0, 0.0), (0.0, 0.0))]
        )
        own = np.broadcast_to(values.get(key, nominal[:, None]), (2, len(load)))
        found[key] = np.where(np.isnan(nominal)[:, None], np.nan, own)
    return found


def element_of(elements: Mapping[str, NDArray[np.float64]], i: int) -> tuple[float, Stops | None]:
    """Friction and walls of one unit, as `Oscillator.at` takes them, from what `elements_of` returns."""
    friction = elements["friction"][i].item() if "friction" in elements else 0.0
    if ELEMENTS[1] not in elements:
        return friction, None
    right, left = (
        None if np.isnan(k) else (float(k), float(c))
        for k, c in zip(*(elements[name][:, i] for name in ELEMENTS[1:]), strict=True)
    )
    return friction, (right, left) if right or left else None


def interval(holds: int, count: int, confidence: float = 0.95) -> tuple[float, float]:
    """The Clopper–Pearson interval for a probability, from independent trials.

    Parameters
    ----------
    holds, count : int
        Number of successes, and of trials (at least one).
    confidence : float
        Lower bound of the probability that such an interval contains the true probability.

    Examples
    --------
    >>> from vibroimpact.systems.distribution import interval
    >>> [round(end, 4) for end in interval(95, 100)]
    [0.8872, 0.9836]
    """
    logs = np.concatenate([[0.0], np.cumsum(np.log(np.arange(1, count + 1)))])
    rest = 0.5 * (1 - confidence)

    def at_least(successes: int, p: float) -> float:
        """The probability of at least this number of successes."""
        j = np.arange(successes, count + 1)
        exponents = (
            logs[-1] - logs[j] - logs[count - j] + j * np.log(p) + (count - j) * np.log1p(-p)
        )
        return float(np.exp(exponents).sum())

    def solved(successes: int, wanted: float) -> float:
        """The success probability of a trial at which `at_least` (an increasing function of it) has the given
        value."""
        low, high = 0.0, 1.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if at_least(successes, middle) > wanted else (middle, high)
        return 0.5 * (low + high)

    low = 0.0 if holds == 0 else solved(holds, rest)
    return low, 1.0 if holds == count else solved(holds + 1, 1 - rest)


def in_range(key: str, low: float, high: float, name: str) -> None:
    """Reject values outside the range of a parameter.

    Raises
    ------
    ParameterError
        Names the parameter, the value and its range.
    """
    for value in (low, high):
        checks.number(value, RANGE_OF[key], name)
