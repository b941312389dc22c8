"""Checks of arguments: a single error that names the parameter, its value and the range.

All checks run before any Fortran code. The ranges are those of the namelist program.
"""

from __future__ import annotations

import math
import operator
import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import ParameterError, ParameterTypeError

#: Least and greatest allowed value of each number, and whether the greatest itself is allowed.
RANGES: dict[str, tuple[float, float, bool]] = {
    "xi": (0.0, 1.0, False),
    "mu": (0.0, 1e6, True),
    "restitution": (0.0, 1.0, True),
    "r": (1e-6, 1e6, True),
    "clearance": (1e-12, 1e12, True),
    "acceptance": (0.0, 1.0, True),
    "load": (0.0, 1e12, True),
    "friction": (0.0, 1e12, True),
    "wall_stiffness": (1e-12, 1e12, True),
    "wall_damping": (0.0, 1e12, True),
    "cycles_simulated": (0.0, 1e9, True),
    "longest_step": (1e-6, 1.0, True),
}
MAX_IMPACTS = 1000
MAX_CYCLES = 10_000
#: Greatest length of the values that a message repeats.
MOST_SHOWN = 300
#: The argument `rng` of functions that draw random numbers (SPEC 7): a seed, a generator, or None.
Rng: TypeAlias = int | np.random.Generator | None
#: A text that is a number.
NUMERAL = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*")
#: Largest number of values that a study may keep at once.
MOST_NUMBERS = 12_500_000


def allowed(name: str, label: str | None = None) -> str:
    """The range of a parameter in words, for messages; `label` is the caller's name of it."""
    low, high, closed = RANGES[name]
    shown = name if label is None else label
    kind = "a number of load cycles" if name == "cycles_simulated" else "a number"
    return f"{kind} with {low:g} <= {shown} {'<=' if closed else '<'} {high:g}"


def number(value: Any, name: str, label: str | None = None) -> float:
    """A float within the range of `name`; `label` is its name in the message."""
    item: float = value
    if type(value) is int and abs(value) < 2**53:
        item = float(value)
    elif type(value) is not float:
        item = to_float(value, label or name, allowed(name, label))
    low, high, closed = RANGES[name]
    if not (low <= item < high or (closed and item == high)):
        raise ParameterError(f"{label or name} = {value!r}: must be {allowed(name, label)}")
    return item


def to_float(value: Any, label: str, wanted: str) -> float:
    """A float from any real number; bool, str, None and complex are rejected."""
    if isinstance(value, (bool, str, bytes, complex)) or not hasattr(type(value), "__float__"):
        quoted = isinstance(value, str) and NUMERAL.fullmatch(value)
        note = " (a number without a unit has no quotes)" if quoted else ""
        raise ParameterTypeError(
            f"{label} = {value!r}: must be {wanted}, not {type(value).__name__}{note}"
        )
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError) as error:
        kind = ParameterTypeError if isinstance(error, TypeError) else ParameterError
        raise kind(f"{label} = {value!r}: must be {wanted}") from None


def shown(values: Any) -> str:
    """The text of values for a message, without the middle of a long one."""
    text = repr(values)
    return text if len(text) <= MOST_SHOWN else f"{text[: MOST_SHOWN - 60]} ... {text[-40:]}"


def finite(value: Any, label: str) -> float:
    """A finite float."""
    number = to_float(value, label, "a finite number")
    if not math.isfinite(number):
        raise ParameterError(f"{label} = {value!r}: must be a finite number")
    return number


def read_number(text: str) -> float:
    """The number in a text; ValueError also for numbers that no float can represent, such as 1e400 or 1e-400.

    Examples
    --------
    >>> from vibroimpact.base.checks import read_number
    >>> read_number("1e-3"), read_number("-inf")
    (0.001, -inf)
    >>> read_number("1e400")
    Traceback (most recent call last):
    ValueError: 1e400: must be a number representable in double precision
    """
    value = float(text)
    digits = text.strip().lower().lstrip("+-")
    too_large = math.isinf(value) and not digits.startswith("inf")
    too_small = value == 0 and any(digit in "123456789" for digit in digits.partition("e")[0])
    if too_large or too_small:
        raise ValueError(f"{text.strip()}: must be a number representable in double precision")
    if "_" in text or not text.isascii():
        raise ValueError(f"{text.strip()}: must be a number")
    return value


def integer(value: Any, name: str, low: int, high: int) -> int:
    """An int with low <= value <= high."""
    if type(value) is int and low <= value <= high:
        return value
    wanted = f"a whole number with {low} <= {name} <= {high}"
    if isinstance(value, (bool, np.bool_)):
        raise ParameterTypeError(f"{name} = {value!r}: must be {wanted}, not bool")
    try:
        item = operator.index(value)
    except TypeError:
        kind = ParameterError if isinstance(value, float) else ParameterTypeError
        raise kind(f"{name} = {value!r}: must be {wanted}") from None
    if not low <= item <= high:
        raise ParameterError(f"{name} = {value!r}: must be {wanted}")
    return item


def seed_of(rng: Any, high: int = 2**31 - 1) -> int:
    """The seed for an argument `rng`: the whole number itself, a number drawn from a NumPy Generator, or a new one
    for None.

    Parameters
    ----------
    rng : int, numpy.random.Generator or None
        A Generator advances, so that the next call with it returns another seed.
    high : int
        The largest seed.

    Examples
    --------
    >>> import numpy as np
    >>> from vibroimpact.base.checks import seed_of
    >>> rng = np.random.default_rng(7)
    >>> seed_of(7), seed_of(rng) == seed_of(rng), seed_of(np.random.default_rng(7)) == seed_of(7)
    (7, False, False)
    """
    if rng is None or isinstance(rng, np.random.Generator):
        generator = np.random.default_rng() if rng is None else rng
        # namelists have no larger ones
        return int(generator.integers(min(high, 2**31 - 1), endpoint=True))
    wanted = f"a whole number with 0 <= rng <= {high}, a numpy.random.Generator or None"
    try:
        return integer(rng, "rng", 0, high)
    except (ParameterError, ParameterTypeError) as error:
        raise type(error)(f"rng = {rng!r}: must be {wanted}") from None


def place(index: Any, n: int, what: str) -> int | range:
    """The index of an item among n, or the indices of a slice; IndexError outside the range, as for a list."""
    wanted = "a whole number or a slice of whole numbers"
    try:
        if isinstance(index, slice):
            return range(n)[index]
        if isinstance(index, (bool, np.bool_)):
            raise TypeError
        i = operator.index(index)
    except (TypeError, ValueError):
        raise ParameterTypeError(f"index = {index!r}: must be {wanted}") from None
    if not -n <= i < n:
        raise IndexError(f"{what} {i} of {n}")
    return i % n


def truth(value: Any, name: str) -> bool:
    """True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise ParameterTypeError(
            f"{name} = {value!r}: must be True or False, not {type(value).__name__}"
        )
    return bool(value)


def choice(value: Any, name: str, choices: Sequence[str]) -> str:
    """One of a few words."""
    wanted = " or ".join(map(repr, choices))
    if not isinstance(value, str):
        raise ParameterTypeError(f"{name} = {value!r}: must be {wanted}")
    if value not in choices:
        raise ParameterError(f"{name} = {value!r}: must be {wanted}")
    return value


def path(value: Any, name: str = "path") -> Path:
    """A valid path of a file."""
    try:
        text = os.fspath(value)
        if not isinstance(text, str):
            raise TypeError
    except TypeError:
        raise ParameterTypeError(
            f"{name} = {value!r}: must be a path, not {type(value).__name__}"
        ) from None
    try:
        if b"\0" in os.fsencode(text):
            raise ParameterError(f"{name} = {text!r}: must not contain a null byte")
    except UnicodeEncodeError:
        raise ParameterError(
            f"{name} = {text!r}: must be text that can be encoded as a path"
        ) from None
    return Path(text)


def progress(value: Any) -> None:
    """None, or a function that reports the progress of a computation."""
    if value is not None and not callable(value):
        raise ParameterTypeError(f"progress = {value!r}: must be None or callable")


def instance(value: Any, name: str, kind: type) -> Any:
    """A value of one of the package's own classes."""
    if not isinstance(value, kind):
        raise ParameterTypeError(
            f"{name} = {value!r}: must be a vibroimpact.{kind.__name__}, not {type(value).__name__}"
        )
    return value


def real_array(values: ArrayLike, name: str, wanted: str) -> NDArray[np.float64]:
    """A float64 array from real numbers."""
    try:
        array = np.asarray(values)
    except ValueError:
        raise ParameterError(f"{name} = {shown(values)}: must be {wanted}") from None
    if np.ma.is_masked(values):
        raise ParameterError(f"{name} = {shown(values)}: must be {wanted}, none of them masked")
    if array.size and (array.dtype.kind not in "iuf" or has_truth(values)):
        raise ParameterTypeError(f"{name} = {shown(values)}: must be {wanted}")
    return array.astype(np.float64, copy=False)


def one_shape(**values: ArrayLike) -> list[NDArray[np.float64]]:
    """Arrays of real numbers, broadcast to one shape."""
    arrays = [real_array(given, name, "real numbers") for name, given in values.items()]
    try:
        return [np.asarray(array) for array in np.broadcast_arrays(*arrays)]
    except ValueError:
        shapes = ", ".join(str(array.shape) for array in arrays)
        raise ParameterError(
            f"{', '.join(values)} of shapes {shapes}: must be broadcastable"
        ) from None


def has_truth(values: Any) -> bool:
    """Whether nested lists of numbers contain True or False, which NumPy would convert to 1 or 0."""
    if not isinstance(values, (list, tuple)):
        return getattr(getattr(values, "dtype", None), "kind", "") == "b"
    kinds = set(map(type, values))
    if bool in kinds or np.bool_ in kinds:
        return True
    return not kinds <= {float, int} and any(map(has_truth, values))


#: The 1/A of the motion without impacts below which the difference of free and forced vibration keeps less than
#: four digits; the core has the same number.
LEAST_INVERSE = 1e-12


def at_resonance(xi: float, r: float) -> bool:
    """Whether r is near 1 with hardly any damping."""
    return math.hypot((1 - r) * (1 + r), 2 * xi * r) < LEAST_INVERSE


def frequency_ratio(value: Any, xi: float, near: bool = False) -> float:
    """Checks a frequency ratio r: the motion without impacts must be finite and, with `near`, accurate to some
    digits."""
    r = number(value, "r")
    if (near or r == 1.0) and at_resonance(xi, r):
        raise ParameterError(
            f"r = {r!r}: must differ from 1 when xi = 0 (resonance without damping: the amplitude is infinite)"
        )
    return r


def phases(values: Any, n: int, cycles: int) -> NDArray[np.float64]:
    """Checks n impact phases: increasing, and all within less than 2 pi k."""
    period = 2 * math.pi * cycles
    wanted = f"{n} increasing numbers within less than 2 pi k = {period:.6g}, one for each impact"
    array = real_array(values, "phases", wanted)
    if array.ndim != 1 or array.size != n:
        raise ParameterError(
            f"phases = {shown(values)}: must be {wanted}; the shape is {array.shape}"
        )
    items = array.tolist()
    if not math.isfinite(items[0]):
        raise ParameterError(f"phases[0] = {items[0]!r}: must be finite")
    for i in range(1, n):
        if not (items[i - 1] < items[i] and items[i] - items[0] < period):
            raise ParameterError(
                f"phases[{i}] = {items[i]!r}: must be finite, above phases[{i - 1}] and below phases[0] + 2 pi k, "
                f"with 2 pi k = {period:.6g}"
            )
    shifted: NDArray[np.float64] = array - items[0]
    return shifted


def phase_table(values: Any, n: int, cycles: int, first: int = 0) -> NDArray[np.float64]:
    """Many sets of impact phases (n, m), each as in `phases`; messages count columns from `first`."""
    period = 2 * math.pi * cycles
    wanted = (
        f"an array (N = {n}, M), each column increasing, within less than 2 pi k = {period:.6g}"
    )
    array = real_array(values, "phases", wanted)
    if array.ndim != 2 or array.shape[0] != n or array.shape[1] == 0:
        raise ParameterError(f"phases of shape {array.shape}: must be {wanted}, M at least 1")
    with np.errstate(invalid="ignore"):  # infinite phases
        shifted = array - array[0] if array[0].any() else array
        bad = ~((np.diff(array, axis=0) > 0).all(axis=0) & (shifted[-1] < period))
    if bad.any():
        j = int(np.argmax(bad))
        raise ParameterError(f"phases[:, {first + j}] = {array[:, j].tolist()!r}: must be {wanted}")
    return shifted


def restitution_list(values: Any, n: int) -> NDArray[np.float64]:
    """One coefficient of restitution for each of n impacts."""
    wanted = f"{n} numbers with 0 <= R <= 1, one for each impact"
    array = real_array(values, "restitution", wanted)
    if array.ndim != 1 or array.size != n:
        raise ParameterError(
            f"restitution = {shown(values)}: must be {wanted}; the shape is {array.shape}"
        )
    for i, item in enumerate(array.tolist()):
        number(item, "restitution", f"restitution[{i}]")
    return array
