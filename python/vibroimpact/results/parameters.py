"""Structures and loads as functions of parameters: entries by name, or any smooth function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError
from ..systems.restitution import at_rest, from_columns, to_columns
from ..systems.structure import Friction, Gap, Load, Stop, Structure
from .tables import Result

#: A parameter: its name, or a name with a function of it that gives the structure and the load, and its value.
Wanted = str | tuple[str, Callable[[float], tuple[Structure, Load]], float]

__all__: list[str] = []

_Array = NDArray[np.float64]
#: A parameter: its name, or a function of it that gives the structure and the load.
Parameter = str | Callable[[float], tuple[Structure, Load]]
#: An axis of a plane: a parameter with its range.
Span = tuple[Parameter, tuple[float, float]] | tuple[Parameter, float, float]
#: Kinds of entries, numbered as in the core.
MATRICES = {1: "mass", 2: "damping", 3: "stiffness"}
DIRECTION, OPENING, RESTITUTION, FREQUENCY, COSINE, SINE, CONSTANT, LAW = range(4, 12)
WALLS = {12: "cosine", 13: "sine"}
#: The numbers of a stop and of friction, as the core has them.
LAWS = {Stop: ("stiffness", "damping", "preload"), Friction: ("slip", "stick", "speed")}
#: Degrees of the Chebyshev series that are tried, and the largest relative remainder of an entry.
DEGREES, NEGLIGIBLE = (8, 16, 32, 64, 128), 1e-14


def entries_of(structure: Structure, load: Load) -> tuple[NDArray[np.int64], _Array]:
    """All entries (m, 3) of a structure and its load by kind and place from 1, and their values (m,)."""
    n = structure.coordinates
    rows, columns = np.tril_indices(n)
    parts: list[tuple[int, Any, Any, Any]] = [
        (kind, rows, columns, getattr(structure, name)[rows, columns])
        for kind, name in MATRICES.items()
    ]
    for j, part in enumerate(structure._parts):
        parts.append((DIRECTION, np.arange(n), np.full(n, j), part.direction))
        if not isinstance(part, Friction):
            parts.append((OPENING, [j], [-1], [part.opening]))
            for kind, name in WALLS.items():
                amplitudes = getattr(part, name)
                parts.append(
                    (kind, np.full(len(amplitudes), j), np.arange(len(amplitudes)), amplitudes)
                )
        if isinstance(part, Gap):
            parts.append((RESTITUTION, [j], [-1], [at_rest(part.restitution)]))
        else:
            names = LAWS[type(part)]
            parts.append((LAW, [j] * 3, np.arange(3), [getattr(part, name) for name in names]))
    parts += [
        (FREQUENCY, [-1], [-1], [load.frequency]),
        (CONSTANT, np.arange(n), np.full(n, -1), load.constant),
    ]
    for kind, values in ((COSINE, load.cosine), (SINE, load.sine)):
        for h, amplitudes in enumerate(values):
            parts.append((kind, np.arange(n), np.full(n, h), amplitudes))
    places = np.concatenate(
        [np.stack([np.full(len(v), kind), i, j], axis=1) for kind, i, j, v in parts]
    )
    places[:, 1:] += 1
    return places, np.concatenate([np.asarray(v, dtype=float) for *_, v in parts])


def laws_of(structure: Structure) -> list[object]:
    """The properties of the laws of all gaps, stops and friction that a parameter cannot change."""
    return [
        to_columns(part.restitution) | {"restitution": None}
        if isinstance(part, Gap)
        else (type(part), getattr(part, "release", ""))
        for part in structure._parts
    ]


def with_entries(
    structure: Structure, load: Load, places: NDArray[np.int64], values: _Array
) -> tuple[Structure, Load]:
    """The structure and the load after some of their entries were set."""
    matrices = {kind: getattr(structure, name).copy() for kind, name in MATRICES.items()}
    changes: list[dict[str, Any]] = [
        {"direction": part.direction.copy()} for part in structure._parts
    ]
    frequency, constant = load.frequency, load.constant.copy()
    harmonics = {COSINE: load.cosine.copy(), SINE: load.sine.copy()}
    for (kind, i, j), value in zip((places - (0, 1, 1)).tolist(), values.tolist(), strict=True):
        if kind in matrices:
            matrices[kind][i, j] = matrices[kind][j, i] = value
        elif kind == DIRECTION:
            changes[j]["direction"][i] = value
        elif kind == OPENING:
            changes[i]["opening"] = value
        elif kind in WALLS:
            name = WALLS[kind]
            changes[i].setdefault(name, getattr(structure.gaps[i], name).copy())[j] = value
        elif kind == LAW:
            changes[i][LAWS[type(structure._parts[i])][j]] = value
        elif kind == RESTITUTION:
            law = to_columns(structure.gaps[i].restitution)
            changes[i]["restitution"] = from_columns(law | {"restitution": value})
        elif kind == FREQUENCY:
            frequency = value
        elif kind == CONSTANT:
            constant[i] = value
        else:
            harmonics[kind][j, i] = value
    gaps = [replace(part, **each) for part, each in zip(structure.gaps, changes, strict=False)]
    friction = [
        replace(part, **each)
        for part, each in zip(structure.friction, changes[len(gaps) :], strict=True)
    ]
    changed = Structure(
        matrices[1], matrices[2], matrices[3], gaps, friction, outputs=structure.outputs,
        simultaneous=structure.simultaneous,
    )._with_units(structure._units)  # fmt: skip
    return changed, Load(
        frequency, cosine=harmonics[COSINE], sine=harmonics[SINE], constant=constant
    )


def keys_of_parameter(
    structure: Structure, load: Load, parameter: Any, bounds: Any, at: Any, word: str, prefix: str = ""
) -> dict[str, Any]:  # fmt: skip
    """The keys of a parameter and its bounds; `word` is the key of its name, the other keys begin with
    `prefix`."""
    try:
        low, high = bounds
    except (TypeError, ValueError):
        raise ParameterError(
            f"{prefix}bounds = {bounds!r}: must be (lowest, highest) values of the parameter"
        ) from None
    low, high = (checks.to_float(x, f"{prefix}bounds", "finite numbers") for x in (low, high))
    ends = {f"{prefix}low": low, f"{prefix}high": high}
    if isinstance(parameter, str):
        if at is not None:
            raise ParameterError(
                f"{prefix}at = {at!r}: must be left out unless the parameter is a function"
            )
        return {word: parameter, **ends}
    if not callable(parameter):
        raise ParameterTypeError(
            f"{word} = {parameter!r}: must be a name, or a function that gives a structure and a load"
        )
    if at is None:
        raise ParameterError(f"{prefix}at = None: must be the value of the parameter at the motion")
    at = checks.to_float(at, f"{prefix}at", "a finite number")
    if not low < high or not low <= at <= high:
        raise ParameterError(
            f"bounds = {(low, high)!r}: must be (lowest, highest) with at = {at!r} between them"
        )
    places, series = series_of(structure, load, parameter, low, high, at)
    return {
        word: "function", **ends, f"{prefix}entries": places.ravel().tolist(),
        f"{prefix}series": series.ravel().tolist(), f"{prefix}at": at,
    }  # fmt: skip


def checked_pair(pair: Any, p: float) -> tuple[Structure, Load]:
    """The structure and load that a function of a parameter returns at a value; an error if it returns anything
    else."""
    if not (
        isinstance(pair, tuple)
        and len(pair) == 2
        and isinstance(pair[0], Structure)
        and isinstance(pair[1], Load)
    ):
        raise ParameterTypeError(
            f"the parameter gives {pair!r} at {p!r}: must be (Structure, Load)"
        )
    return pair


def of_constant_load(
    function: Callable[[float], tuple[Structure, Load]],
) -> Callable[[float], tuple[Structure, Load]]:
    """Wraps a function of a parameter so that each load without a frequency has a constant force, 0 if none is
    given."""

    def at(value: float) -> tuple[Structure, Load]:
        structure, load = checked_pair(function(value), value)
        return structure, load + Load(constant=np.zeros(structure.coordinates))

    return at


def series_of(
    structure: Structure, load: Load, function: Callable[[float], Any], low: float, high: float, at: float
) -> tuple[NDArray[np.int64], _Array]:  # fmt: skip
    """The entries (m, 3) that a function changes, and their Chebyshev coefficients (m, degree + 1)."""
    places, expected = entries_of(structure, load)

    def values(p: float) -> _Array:
        pair = checked_pair(function(p), p)
        found, numbers = entries_of(*pair)
        if found.shape != places.shape or (found != places).any():
            raise ParameterError(
                "the parameter returns a structure with a different number of coordinates, gaps or harmonics "
                f"(of the load or of a wall) at {p!r}"
            )
        if laws_of(pair[0]) != laws_of(structure):
            raise ParameterError(
                f"the parameter returns a different law of restitution at {p!r}: it may "
                "change only R and R0"
            )
        return numbers

    scale = np.abs(expected)
    if (np.abs(values(at) - expected) > 1e-12 * np.maximum(scale, scale.max() * 1e-6)).any():
        raise ParameterError(
            f"at = {at!r}: the structure and load that the parameter returns there differ from those of the motion"
        )
    for degree in DEGREES:
        nodes = np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
        table = np.array(
            [values(float(0.5 * (low + high) + 0.5 * (high - low) * s)) for s in nodes]
        )
        # the discrete orthogonality of the polynomials at these nodes
        series = 2 / (degree + 1) * chebyshev.chebvander(nodes, degree).T @ table
        series[0] /= 2
        largest = np.abs(table).max(axis=0)
        if (np.abs(series[-2:]) <= NEGLIGIBLE * largest).all():
            break
    else:
        raise ParameterError(
            f"the parameter is not a smooth function between {low!r} and {high!r}: a polynomial of degree "
            f"{DEGREES[-1]} does not describe it; choose bounds without a corner between them"
        )
    changes = (np.abs(series[1:]) > 1e-15 * np.maximum(largest, 1e-300)).any(axis=0)
    if not changes.any():
        raise ParameterError("the parameter changes nothing between its bounds")
    return places[changes], series[:, changes].T


class Path:
    """The structures and loads of a branch or a zone, from the tables of its result."""

    def __init__(
        self, result: Result, structure: Structure, load: Load, bounds: list[tuple[float, float]]
    ) -> None:
        columns = {name: item.decoded() for name, item in result.tables["path"].columns.items()}
        self.axis, self.entry = columns["axis"], columns["entry"].astype(np.int64)
        self.series, self.chebyshev = columns["series"], columns["chebyshev"].astype(bool)
        self.structure, self.load, self.bounds = structure, load, bounds

    def start(self, given: list[float | None]) -> list[float]:
        """The values of the parameters at the start; for parameters that are functions they are given."""
        places, values = entries_of(self.structure, self.load)
        found = []
        for axis, value in enumerate(given, 1):
            if value is None:
                i = int(np.flatnonzero((self.axis == axis) & (self.series[:, 1] != 0))[0])
                here = values[(places == self.entry[i]).all(axis=1)][0]
                value = float((here - self.series[i, 0]) / self.series[i, 1])
            found.append(value)
        return found

    def at(self, *parameters: float) -> tuple[Structure, Load]:
        """The structure and the load at values of the parameters."""
        values = np.empty(len(self.axis))
        for i, axis in enumerate(self.axis.tolist()):
            low, high = self.bounds[axis - 1]
            p = parameters[axis - 1]
            if self.chebyshev[i]:
                values[i] = chebyshev.chebval((2 * p - low - high) / (high - low), self.series[i])
            else:
                values[i] = self.series[i, 0] + self.series[i, 1] * p
        return with_entries(self.structure, self.load, self.entry, values)
