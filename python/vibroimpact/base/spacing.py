"""Values along an axis, spaced as in namelists."""

from __future__ import annotations

from typing import Any, NamedTuple

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
    """The numbers from low to high, both included, identical to the last bit to those of a namelist.

    Parameters
    ----------
    low, high : float
        The ends: low below high, and above 0 for geometric spacing.
    n : int
        Number of values, at least 2.
    spacing : {"linear", "geometric"}
        Equal differences or equal ratios.

    Returns
    -------
    ndarray (n,)
        The numbers, in ascending order.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.

    Examples
    --------
    A sweep of the clearance with equal ratios, and its case as a namelist:

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


def range_values(values: Any, name: str, points: Any, label: str = "points") -> Any:
    """The values of a sweep: the given ones, or, with `points`, that number of evenly spaced values in a range
    (lo, hi).

    Parameters
    ----------
    values
        An array, or with `points` a pair (lo, hi); a single number is not a range and is returned unchanged.
    name, label : str
        The caller's names for `values` and `points`, for messages.
    points : int or None

    Raises
    ------
    ParameterError, ParameterTypeError
        With `points`, if the values are not a pair of different finite numbers, or `points` is below 2.

    Examples
    --------
    >>> from vibroimpact.base.spacing import range_values
    >>> range_values((1.0, 2.0), "r", 5).tolist(), range_values((2, 1), "r", 3).tolist()
    ([1.0, 1.25, 1.5, 1.75, 2.0], [2.0, 1.5, 1.0])
    >>> range_values([3, 5, 4], "r", None)
    [3, 5, 4]
    """
    if points is None or (not isinstance(values, (list, tuple)) and np.ndim(values) == 0):
        return values
    n = checks.integer(points, label, 2, 10**8)
    wanted = f"a range (lo, hi) of two different finite numbers with {label} = {n}"
    array = checks.real_array(values, name, wanted)
    if array.shape != (2,) or not np.isfinite(array).all() or array[0] == array[1]:
        shown = f"= {values!r}" if array.size < 5 else f"of shape {array.shape}"
        raise ParameterError(f"{name} {shown}: must be {wanted}; an array is given without {label}")
    first, last = array.tolist()
    return spaced(first, last, n) if first < last else spaced(last, first, n)[::-1]


def range_axes(r: Any, clearance: Any, points: Any) -> tuple[Any, Any]:
    """Frequency ratios and clearances, each as in `range_values`; `points` is one number for both, or two."""
    both = isinstance(points, (list, tuple)) and len(points) == 2
    n, m = points if both else (points, points)
    first, second = ("points[0]", "points[1]") if both else ("points", "points")
    return range_values(r, "r", n, first), range_values(clearance, "clearance", m, second)


def ascending(values: Any) -> Any:
    """The numbers in ascending order if they fall throughout, for an axis of a map; otherwise unchanged."""
    array = np.asarray(values)
    falls = array.ndim == 1 and array.size > 1 and array.dtype.kind in "fiu"
    return array[::-1].copy() if falls and (np.diff(array) < 0).all() else values


def ends_of(values: Any, name: str, wanted: str) -> tuple[Any, Any]:
    """The ends of a window: a pair (lo, hi), or an array that rises or falls throughout.

    A pair is not checked further; if it falls, it is reversed. For a falling array, the ends are its last and its
    first number.

    Raises
    ------
    ParameterError, ParameterTypeError
        If the argument is neither.

    Examples
    --------
    >>> from vibroimpact.base.spacing import ends_of
    >>> ends_of((0.8, 1.2), "r", "a window"), ends_of([3, 2, 1], "r", "a window")
    ((0.8, 1.2), (1.0, 3.0))
    """
    try:
        low, high = values
    except (TypeError, ValueError):
        pass
    else:
        return in_order(low, high)
    if isinstance(values, str) or np.ndim(values) != 1 or np.size(values) < 2:
        raise ParameterError(f"{name} = {values!r}: must be {wanted}")
    array = checks.real_array(values, name, wanted)
    steps = np.diff(array)
    if not ((steps > 0).all() or (steps < 0).all()):
        raise ParameterError(f"{name} of shape {array.shape}: must rise or fall throughout")
    return float(array.min()), float(array.max())


def in_order(low: Any, high: Any) -> tuple[Any, Any]:
    """The ends of a range, the lower one first; ends that are not real numbers are unchanged.

    Examples
    --------
    >>> from vibroimpact.base.spacing import in_order
    >>> in_order(2.0, 1.0)
    (1.0, 2.0)
    """
    numbers = all(
        isinstance(one, (int, float, np.number)) and not isinstance(one, (bool, np.bool_))
        for one in (low, high)
    )
    return (high, low) if numbers and high < low else (low, high)


def spacing_of(values: _Array) -> str | None:
    """The spacing that reproduces values bit for bit; None if no namelist spacing does."""
    if values.size < 2 or not np.isfinite(values).all() or not values[0] < values[-1]:
        return None
    for name in SPACINGS if values[0] > 0 else SPACINGS[:1]:
        if np.array_equal(values, spaced(values[0], values[-1], values.size, name)):
            return name
    return None


def axis_of(given: Any, points: Any, label: str) -> Axis:
    """An axis of a plane: (name, low, high, n), or (name, values) of an array or of a range.

    Values count as evenly spaced if they deviate by less than 1e-9 of their range.

    Raises
    ------
    TypeError, ValueError
        If the argument has another form.
    ParameterError, ParameterTypeError
        If the values do not rise or fall throughout.
    """
    if len(given) != 2:
        return Axis(*given)
    name, values = given
    wanted = "an array that rises or falls throughout, or a range (lo, hi) with points"
    array = checks.real_array(range_values(values, label, points), label, wanted)
    steps = np.diff(array) if array.ndim == 1 else np.zeros(0)
    if not (steps.size and np.isfinite(array).all() and ((steps > 0).all() or (steps < 0).all())):
        raise ParameterError(f"{label} of shape {array.shape}: must be {wanted}")
    rising = np.sort(array)
    low, high, n = float(rising[0]), float(rising[-1]), rising.size
    if np.abs(rising - np.linspace(low, high, n)).max() <= 1e-9 * (high - low):
        return Axis(name, low, high, n)
    return Axis(name, low, high, n, tuple(rising.tolist()))


class Axis(NamedTuple):
    """One direction of a plane of initial states: n of them from low to high, evenly spaced or `listed`."""

    name: str
    low: float
    high: float
    n: int
    listed: tuple[float, ...] | None = None

    @property
    def values(self) -> _Array:
        """The values along the axis."""
        if self.listed is not None:
            return np.array(self.listed)
        return spaced(self.low, self.high, self.n)
