"""Results as plain values that JSON knows, and back to the last bit.

A result becomes a dictionary with the names of its attributes; arrays are lists, complex numbers [re, im]
pairs on the last axis, the events of a motion or trajectory a list a column, NaN null and an infinity
"inf" or "-inf". What is read is checked against the types that the classes declare.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import types
import typing
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ParameterError, VibroimpactError
from ..events import EVENT_TYPE, KINDS
from ..model import Oscillator, Pattern

#: Dimensions of the arrays of each class; an array of another class may have any.
DIMENSIONS: dict[str, dict[str, tuple[str, ...]]] = {
    "Motion": {
        **dict.fromkeys(
            ("restitution", "phases", "X", "Z", "X_dot_before", "X_dot_after", "Z_dot_before",
             "Z_dot_after"), ("impact",),
        ),
        "multipliers": ("multiplier",), "guess": ("impact",), "rest_events": ("event",),
    },
    "Trajectory": {"events": ("event",)},
    "Piece": {
        "r": ("vertex",), "clearance": ("vertex",), "x": ("unknown", "vertex"),
        "theta": ("unknown", "vertex"),
    },
    "Zone": {"loops": ("vertex", "coordinate")},
    "Survey": dict.fromkeys(("r", "clearance", "outcome"), ("point",)),
}  # fmt: skip
#: Those that always have the same size.
SIZES = {"multiplier": 4, "parameter": 6, "scalar": 6, "verdict": 3, "coordinate": 2}


def encode(value: Any) -> Any:
    """Any value of a result as plain values."""
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, np.ndarray):
        return encode_array(value)
    if isinstance(value, np.generic):
        return encode(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None if value != value else str(value)
    if isinstance(value, Oscillator):
        own = {"xi": value.xi, "mu": value.mu, "restitution": list(value.restitution)}
        return own | ({} if value.M is None else {"M": value.M, "K": value.K})
    if isinstance(value, Pattern):
        return {"sides": value.sides, "cycles": value.cycles}
    if dataclasses.is_dataclass(value):
        return {item.name: encode(getattr(value, item.name)) for item in dataclasses.fields(value)}
    if hasattr(value, "_asdict"):
        return encode(value._asdict())
    if isinstance(value, Mapping):
        return {str(name): encode(item) for name, item in value.items()}
    return [encode(item) for item in value]


def encode_array(array: NDArray[Any]) -> Any:
    """An array as lists, those of its records by name."""
    if array.dtype.names:
        return {name: encode_array(array[name]) for name in array.dtype.names}
    if array.dtype.kind == "c":
        array = np.stack([array.real, array.imag], axis=-1)
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        return encode(array.tolist())
    return array.tolist()


def decode(hint: Any, value: Any, label: str, dimensions: Dimensions | None = None) -> Any:
    """What `encode` made, as the type that is wanted; `label` is what messages call it."""
    hint = without_alias(hint)
    origin, parts = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        if value is None:
            return None
        choices = [without_alias(item) for item in parts if item is not type(None)]
        # of a number and an array of them, the array is the one with a list
        arrays = [item for item in choices if typing.get_origin(item) is np.ndarray]
        hint = arrays[0] if arrays and isinstance(value, list) else choices[0]
        return decode(hint, value, label, dimensions)
    if hint is np.ndarray or origin is np.ndarray:
        return decode_array(parts, value, label, dimensions or Dimensions())
    if hint is float:
        return decode_float(value, label)
    if hint in (bool, int, str):
        if type(value) is not hint:
            refuse(
                label, value, {bool: "true or false", int: "a whole number", str: "a text"}[hint]
            )
        return value
    if origin is tuple:
        items = sequence(value, label, len(parts))
        return tuple(
            decode(part, item, f"{label}[{i}]")
            for i, (part, item) in enumerate(zip(parts, items, strict=True))
        )
    if origin is list:
        return [
            decode(parts[0], item, f"{label}[{i}]", dimensions and dimensions.of_item())
            for i, item in enumerate(sequence(value, label))
        ]
    if hint is dict or origin is dict:  # a state
        return {
            name: decode_state(item, f"{label}.{name}")
            for name, item in mapping(value, label).items()
        }
    if isinstance(hint, type) and (dataclasses.is_dataclass(hint) or hasattr(hint, "_fields")):
        return record(hint, value, label)
    return value


def without_alias(hint: Any) -> Any:
    """What a name of a type stands for: from numpy 2.5 on, NDArray is such a name."""
    meaning = getattr(typing.get_origin(hint), "__value__", None)
    return hint if meaning is None else meaning[typing.get_args(hint)]


def record(kind: type, value: Any, label: str) -> Any:
    """A dataclass or named tuple from a dictionary with the names of its attributes."""
    data = mapping(value, label)
    dimensions = Dimensions(DIMENSIONS.get(kind.__name__, {}))
    given = {}
    for name, (hint, needed) in attributes(kind).items():
        if name in data:
            given[name] = decode(hint, data[name], f"{label}.{name}" if label else name,
                                 dimensions.called(name))  # fmt: skip
            dimensions.bind("impact", given[name])
        elif needed:
            raise ParameterError(f"{label or kind.__name__}: must have {name!r}; it is missing")
    try:
        return kind(**given)
    except VibroimpactError as error:
        raise ParameterError(f"{label or kind.__name__}: {error}") from None


@functools.cache
def attributes(kind: type) -> dict[str, tuple[Any, bool]]:
    """Name, type and whether it is needed, of each attribute that makes an object."""
    hints = typing.get_type_hints(kind)
    if dataclasses.is_dataclass(kind):
        return {
            item.name: (
                hints[item.name],
                item.default is dataclasses.MISSING and item.default_factory is dataclasses.MISSING,
            )
            for item in dataclasses.fields(kind) if item.init
        }  # fmt: skip
    defaults = getattr(kind, "_field_defaults", {})
    return {name: (hints[name], name not in defaults) for name in kind._fields}  # type: ignore[attr-defined]


class Dimensions:
    """Sizes of the dimensions of one record, as they become known, and those of the array at hand."""

    def __init__(self, names: Mapping[str, tuple[str, ...]] | None = None) -> None:
        self.names = names or {}
        self.sizes = dict(SIZES)
        self.wanted: tuple[str, ...] | None = None

    def called(self, name: str) -> Dimensions:
        """For the attribute of this name."""
        self.wanted = self.names.get(name)
        return self

    def of_item(self) -> Dimensions:
        """For one of several arrays, of sizes of their own."""
        item = Dimensions()
        item.wanted = self.wanted
        return item

    def bind(self, name: str, pattern: Any) -> None:
        """There are as many impacts as the pattern has letters."""
        if isinstance(pattern, Pattern):
            self.sizes[name] = len(pattern)

    def fit(self, array: NDArray[Any], label: str) -> None:
        """Error unless the array has the dimensions that are wanted."""
        if self.wanted is None:
            return
        wanted = tuple(self.sizes.get(name, name) for name in self.wanted)
        good = array.ndim == len(wanted) and all(
            isinstance(want, str) or want == size
            for want, size in zip(wanted, array.shape, strict=True)
        )
        if not good:
            said = ", ".join(f"{name} {self.sizes.get(name, '')}".strip() for name in self.wanted)
            raise ParameterError(f"{label} of shape {array.shape}: must be ({said})")
        self.sizes.update(zip(self.wanted, array.shape, strict=True))


def decode_array(
    parts: tuple[Any, ...], value: Any, label: str, dimensions: Dimensions
) -> NDArray[Any]:
    """An array of numbers, or of the records of events; read-only."""
    (wanted,) = typing.get_args(parts[1]) if len(parts) > 1 else (Any,)
    if isinstance(value, Mapping):
        return decode_events(value, label, dimensions)
    dtype = np.dtype(np.float64 if wanted is Any else wanted)
    plain = numbers(value, dtype.kind, label)
    try:
        array = np.array(plain, dtype=np.float64 if dtype.kind == "c" else dtype)
    except (ValueError, TypeError, OverflowError):
        refuse(label, value, "lists of numbers, all of one length")
    if dtype.kind == "c":
        if array.ndim < 1 or array.shape[-1] != 2:
            refuse(label, value, "pairs [re, im]")
        array = np.ascontiguousarray(array).view(np.complex128)[..., 0]
    dimensions.fit(array, label)
    array.flags.writeable = False
    return array


def decode_events(value: Mapping[str, Any], label: str, dimensions: Dimensions) -> NDArray[Any]:
    """The events of a trajectory or of a motion with rest."""
    record_type = EVENT_TYPE
    names = record_type.names or ()
    missing = [name for name in names if name not in value]
    if missing:
        raise ParameterError(
            f"{label}: must have {', '.join(map(repr, names))}; missing: {missing}"
        )
    size = len(sequence(value[names[0]], f"{label}.{names[0]}"))
    table = np.empty(size, dtype=record_type)
    words = {"kind": KINDS[1:].tolist(), "side": ["R", "L", "R*", "L*"]}
    for name in names:
        column = sequence(value[name], f"{label}.{name}", size)
        if name in words:
            strange = [item for item in column if item not in words[name]]
            if strange:
                refuse(f"{label}.{name}", strange[0], " or ".join(map(repr, words[name])))
            table[name] = column
        else:
            table[name] = numbers(column, record_type[name].kind, f"{label}.{name}")
    dimensions.fit(table, label)
    table.flags.writeable = False
    return table


def numbers(value: Any, kind: str, label: str) -> Any:
    """Lists of numbers, with NaN and infinity as such."""
    if isinstance(value, list):
        return [numbers(item, kind, label) for item in value]
    if kind in "fc":
        return decode_float(value, label)
    if isinstance(value, bool) != (kind == "b") or not isinstance(value, int):
        refuse(label, value, "lists of whole numbers")
    return value


def decode_float(value: Any, label: str) -> float:
    """A number; null is NaN."""
    if value is None:
        return math.nan
    if isinstance(value, str) and value in ("inf", "-inf"):
        return float(value)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        refuse(label, value, "a number")
    return float(value)


def decode_state(value: Any, label: str) -> Any:
    """A number of a state, or its history: whole numbers stay whole."""
    if isinstance(value, list):
        return tuple(decode_state(item, label) for item in value)
    return value if type(value) is int else decode_float(value, label)


def sequence(value: Any, label: str, size: int | None = None) -> list[Any]:
    """A list, of this size if one is told."""
    if not isinstance(value, list) or size not in (None, len(value)):
        refuse(label, value, "a list" if size is None else f"a list of {size}")
    return list(value)


def mapping(value: Any, label: str) -> Mapping[str, Any]:
    """A dictionary."""
    if not isinstance(value, Mapping):
        refuse(label or "data", value, "an object with named values")
    return typing.cast("Mapping[str, Any]", value)


def known(kind: Any, names: Iterable[str]) -> str:
    """One of some names."""
    if kind not in (*names,):
        refuse("type", kind, " or ".join(map(repr, names)))
    return str(kind)


def refuse(label: str, value: Any, wanted: str) -> typing.NoReturn:
    """The error for a value that is not what it should be."""
    shown = repr(value)
    if len(shown) > 60:
        shown = f"{shown[:50]} ..."
    raise ParameterError(f"{label} = {shown}: must be {wanted}")
