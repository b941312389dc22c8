"""Values along an axis, spaced in the same way as by namelists."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from . import checks
from .errors import ParameterError

__all__ = ["spaced"]

_Array = NDArray[np.float64]
#: Names of the spacings in namelists, in the order of the core's codes.
SPACINGS = ("linear", "geometric")


def spaced(low: float, high: float, n: int, spacing: str = "linear") -> _Array:
    """Numbers from low to high, both included, with the same bits as those of a namelist.

    Parameters
    ----------
    low, high : float
        low below high, and above 0 if the ratios are to be equal.
    n : int
        How many, at least 2.
    spacing : {"linear", "geometric"}
        Equal differences or equal ratios.

    Returns
    -------
    ndarray (n,)

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.

    Examples
    --------
    A line along the clearance with equal ratios, and its case as a namelist:

    >>> import vibroimpact as vi
    >>> vi.spaced(2.0, 32.0, 5, "geometric")
    array([ 2.,  4.,  8., 16., 32.])
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> line = vi.spaced(15.0, 60.0, 3, "geometric")
    >>> diagram = vi.bifurcation_diagram(osc, "clearance", line, r=1.04, sweep="up")
    >>> "spacing = 'geometric'" in diagram.to_namelist()
    True
    """
    checks.choice(spacing, "spacing", SPACINGS)
    low = checks.to_float(low, "low", "a finite number")
    high = checks.to_float(high, "high", "a finite number")
    if not np.isfinite([low, high]).all() or low >= high:
        raise ParameterError(f"low = {low!r}, high = {high!r}: must be finite, low below high")
    if spacing == "geometric" and low <= 0:
        raise ParameterError(f"low = {low!r}: must be positive with spacing = 'geometric'")
    n = checks.integer(n, "n", 2, 10**8)
    return _core.spaced(n, low, high, SPACINGS.index(spacing))


def spacing_of(values: _Array) -> str | None:
    """The spacing that reproduces the bits of values; None if no namelist can express them."""
    if values.size < 2 or not np.isfinite(values).all() or not values[0] < values[-1]:
        return None
    for name in SPACINGS if values[0] > 0 else SPACINGS[:1]:
        if np.array_equal(values, spaced(values[0], values[-1], values.size, name)):
            return name
    return None


class Axis(NamedTuple):
    """One direction of a plane of initial states: n of them from low to high."""

    name: str
    low: float
    high: float
    n: int

    @property
    def values(self) -> _Array:
        """The values along the axis."""
        return spaced(self.low, self.high, self.n)
