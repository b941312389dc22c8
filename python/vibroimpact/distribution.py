"""What is known of an uncertain parameter: its value, a range, or a distribution of SciPy."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import checks
from .errors import ParameterError, ParameterTypeError

#: Parameters of an oscillator and its clearance that may be uncertain, and the names of their ranges.
RANGE_OF = {
    "xi": "xi", "mu": "mu", "R1": "restitution", "R2": "restitution", "restitution": "restitution",
    "clearance": "clearance",
}  # fmt: skip


@dataclass(frozen=True)
class Uncertain:
    """A random variable: uniform in a range, or any frozen distribution of scipy.stats.

    Attributes
    ----------
    low, high : float
        Its range; of a distribution without bounds its quantiles 1e-9 and 1 - 1e-9, beyond which it is cut off.
    distribution : object, optional
        Has a method `ppf`; None where it is uniform.
    """

    low: float
    high: float
    distribution: Any = None

    @property
    def middle(self) -> float:
        """Its median."""
        return float(self.at(np.array(0.5)))

    def at(self, shares: NDArray[np.float64]) -> NDArray[np.float64]:
        """The quantiles of shares between 0 and 1."""
        if self.distribution is None:
            return self.low + (self.high - self.low) * shares
        found: NDArray[np.float64] = np.clip(self.distribution.ppf(shares), self.low, self.high)
        return found


def uncertain(value: Any, name: str) -> Uncertain:
    """An uncertain parameter from what a caller gives: a number, a pair (low, high), or a distribution.

    Raises
    ------
    ParameterError, ParameterTypeError
        If it is none of these, or not finite.

    Examples
    --------
    >>> from vibroimpact.distribution import uncertain
    >>> uncertain((0.6, 0.8), "restitution").middle
    0.7
    """
    wanted = "a number, a pair (low, high), or a frozen distribution of scipy.stats"
    if hasattr(value, "ppf"):
        ends = [float(end) for end in value.ppf([0, 1e-9, 1 - 1e-9, 1])]
        low, high = (
            inner if math.isinf(outer) else outer
            for outer, inner in ((ends[0], ends[1]), (ends[3], ends[2]))
        )
        found = Uncertain(low, high, value)
    else:
        if isinstance(value, str) or np.ndim(value) > 1 or np.size(value) not in (1, 2):
            raise ParameterTypeError(f"{name} = {value!r}: must be {wanted}")
        pair = np.atleast_1d(np.asarray(value, dtype=object))
        found = Uncertain(*(checks.to_float(item, name, wanted) for item in (pair[0], pair[-1])))
    if not (math.isfinite(found.low) and math.isfinite(found.high) and found.low <= found.high):
        raise ParameterError(f"{name} = {value!r}: must be {wanted}, with finite low <= high")
    return found


def uncertain_parameters(given: Any, name: str) -> dict[str, Uncertain]:
    """Uncertain parameters by name; `restitution` stands for that of both walls, which is then the same.

    Raises
    ------
    ParameterError, ParameterTypeError
        If there is no such parameter, or a value is not allowed.
    """
    if not isinstance(given, Mapping):
        raise ParameterTypeError(
            f"{name} = {given!r}: must be a dict of parameters, not {type(given).__name__}"
        )
    for key in given:
        if key not in RANGE_OF:
            raise ParameterError(
                f"{name}: unknown parameter {key!r}: must be one of {', '.join(RANGE_OF)}"
            )
    if "restitution" in given and ("R1" in given or "R2" in given):
        raise ParameterError(f"{name}: must have restitution, or R1 and R2, not both")
    return {key: uncertain(value, f"{name}[{key!r}]") for key, value in given.items()}


def in_range(key: str, low: float, high: float, name: str) -> None:
    """Refuses values outside the range of a parameter.

    Raises
    ------
    ParameterError
        With the parameter, the value and its range.
    """
    for value in (low, high):
        checks.number(value, RANGE_OF[key], name)
