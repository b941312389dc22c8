"""Coefficients of restitution that depend on the approach speed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError
from .units import SI, plain_number

__all__ = ["PowerLaw", "TabulatedRestitution"]

_Array = NDArray[np.float64]


class ByValue:
    """Equality and hash of a frozen dataclass with arrays, by the values of its fields."""

    def _values(self) -> tuple[Any, ...]:
        """The fields; arrays with their shapes."""
        items = [getattr(self, item.name) for item in fields(self) if item.compare]  # type: ignore[arg-type]
        # adding 0.0 makes -0.0 equal to 0.0, as in a comparison of numbers
        return tuple(
            (item.shape, (item + 0.0).tobytes()) if isinstance(item, np.ndarray) else item
            for item in items
        )

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self._values() == other._values()

    def __hash__(self) -> int:
        return hash(self._values())


class Law(ABC):
    """A law R(v)."""

    @abstractmethod
    def _columns(self) -> dict[str, Any]:
        """The keys of a &gap that describe the law."""

    @abstractmethod
    def _scaled(self, factor: float) -> Restitution:
        """The law with all coefficients multiplied by a factor."""

    @abstractmethod
    def _in_speeds(self, unit: float) -> Restitution:
        """The law of speeds in another unit, in which the present one is `unit`."""

    def __call__(self, speed: ArrayLike) -> _Array:
        """R at approach speeds >= 0, of any shape."""
        return self._evaluate(speed)[0]

    def slope(self, speed: ArrayLike) -> _Array:
        """Derivative dR/dv at approach speeds >= 0.

        Parameters
        ----------
        speed : array_like
            Approach speeds, of any shape.

        Returns
        -------
        ndarray
            The derivative at each speed, in the shape of the speeds.
        """
        return self._evaluate(speed)[1]

    def _evaluate(self, speed: ArrayLike) -> tuple[_Array, _Array]:
        wanted = "numbers >= 0"
        speeds = np.array(checks.real_array(speed, "speed", wanted), dtype=np.float64)
        if not (speeds >= 0).all():
            raise ParameterError(f"speed: must be {wanted}")
        kind, *numbers = numbers_of(self)
        values, slopes = _core.restitution_values(kind, numbers, speeds.ravel())
        return values.reshape(speeds.shape), slopes.reshape(speeds.shape)


@dataclass(frozen=True)
class PowerLaw(Law):
    """A coefficient of restitution that falls with the approach speed: R0 (1 + (v/speed)^k)^(-exponent/k).

    It tends to `R0` far below `speed`, and to R0 (v/speed)^-exponent far above it.

    Parameters
    ----------
    R0 : float
        Coefficient at low speeds, 0 to 1. With 1, accumulating impacts never come to rest.
    speed : float
        The speed > 0 at which the two asymptotes meet, such as the speed of first yield.
    exponent : float
        Exponent >= 0; 1/4 for plastic contact of spheres.
    sharpness : float
        Exponent k > 0. A large value gives the smaller of R0 and R0 (v/speed)^-exponent, with a sharp corner at
        `speed`; 1/5 with ``R0=1`` gives 1 - R ~ v^(1/5) at low speeds, as for viscoelastic spheres.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> law = vi.PowerLaw(0.9, speed=0.1, exponent=0.25)
    >>> law([0.0, 0.1, 1.0]).round(4).tolist()
    [0.9, 0.8253, 0.5055]
    >>> vi.Gap([1.0], 0.5, law)
    Gap([1.0], 0.5, restitution=PowerLaw(R0=0.9, speed=0.1, exponent=0.25, sharpness=2.0))
    """

    R0: float
    speed: float
    exponent: float
    sharpness: float = 2.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "R0", checks.number(self.R0, "restitution", "R0"))
        for name, low in {"speed": "> 0", "exponent": ">= 0", "sharpness": "> 0"}.items():
            wanted = f"a finite number {low}"
            value = checks.to_float(getattr(self, name), name, wanted)
            if not (np.isfinite(value) and (value > 0 or (value == 0 and low == ">= 0"))):
                raise ParameterError(f"{name} = {value!r}: must be {wanted}")
            object.__setattr__(self, name, value)

    def _columns(self) -> dict[str, Any]:
        return {
            "restitution": self.R0, "law": "power", "law_speed": self.speed,
            "law_exponent": self.exponent, "law_sharpness": self.sharpness,
        }  # fmt: skip

    def _scaled(self, factor: float) -> PowerLaw:
        return replace(self, R0=self.R0 * factor)

    def _in_speeds(self, unit: float) -> PowerLaw:
        return replace(self, speed=self.speed * unit)


@dataclass(frozen=True, eq=False, repr=False)
class TabulatedRestitution(ByValue, Law):
    """A coefficient of restitution tabulated over the approach speed.

    Between the tabulated points R is a monotone cubic with continuous slope; below the first and above the last
    speed it is constant.

    Parameters
    ----------
    speeds : array_like (m,)
        At least two ascending speeds >= 0.
    values : array_like (m,)
        R at these speeds, 0 to 1.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> law = vi.TabulatedRestitution([0.0, 0.5, 2.0], [0.9, 0.8, 0.6])
    >>> law([0.0, 0.25, 0.5, 2.0, 10.0]).round(4).tolist()
    [0.9, 0.8468, 0.8, 0.6, 0.6]
    """

    speeds: _Array
    values: _Array

    def __init__(self, speeds: ArrayLike, values: ArrayLike) -> None:
        for name, given, wanted in (
            ("speeds", speeds, "at least two ascending finite numbers >= 0"),
            ("values", values, "numbers from 0 to 1, one per speed"),
        ):
            array = np.array(checks.real_array(given, name, wanted), dtype=np.float64)
            good = array.ndim == 1 and np.isfinite(array).all() and (array >= 0).all()
            if name == "speeds":
                good = good and len(array) >= 2 and (np.diff(array) > 0).all()
            else:
                good = good and array.shape == self.speeds.shape and (array <= 1).all()
            if not good:
                raise ParameterError(f"{name} = {array.tolist()!r}: must be {wanted}")
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    def _columns(self) -> dict[str, Any]:
        return {
            "law": "table", "law_speeds": self.speeds.tolist(), "law_values": self.values.tolist()
        }  # fmt: skip

    def _scaled(self, factor: float) -> TabulatedRestitution:
        return TabulatedRestitution(self.speeds, self.values * factor)

    def _in_speeds(self, unit: float) -> TabulatedRestitution:
        return TabulatedRestitution(self.speeds * unit, self.values)

    def __repr__(self) -> str:
        return f"TabulatedRestitution({self.speeds.tolist()}, {self.values.tolist()})"


#: The kinds of laws, by their numbers in the core.
KINDS = ("constant", "power", "table", "stop", "pushing", "friction")
#: The types that a coefficient of restitution of a gap may have.
Restitution: TypeAlias = float | Law


def checked(restitution: Restitution, label: str | None = None) -> Restitution:
    """A law, or a number from 0 to 1; `label` is its name in the message."""
    if isinstance(restitution, Law):
        return restitution
    if callable(restitution):
        wanted = checks.allowed("restitution", label)
        raise ParameterTypeError(
            f"{label or 'restitution'} = {restitution!r}: must be {wanted}, or a law: a vibroimpact.PowerLaw or "
            "TabulatedRestitution"
        )
    number = plain_number(restitution, label or "restitution", (0, 0, 0), SI)
    return checks.number(number, "restitution", label)


def to_columns(restitution: Restitution) -> dict[str, Any]:
    """A law as the keys of a &gap; files, parameters and the arrays of the core use this form."""
    return restitution._columns() if isinstance(restitution, Law) else {"restitution": restitution}


def from_columns(columns: Mapping[str, Any]) -> Restitution:
    """The inverse of `to_columns`; columns that are not those of the law are ignored."""
    law = columns.get("law", "constant")
    if law == "power":
        numbers = [columns[f"law_{name}"] for name in ("speed", "exponent", "sharpness")]
        return PowerLaw(columns["restitution"], *numbers)
    if law == "table":
        return TabulatedRestitution(columns["law_speeds"], columns["law_values"])
    restitution: float = columns["restitution"]
    return restitution


def numbers_of(restitution: Restitution) -> list[float]:
    """The kind and numbers of a law, for the core; for a table, its length, speeds and values."""
    columns = to_columns(restitution)
    kind = KINDS.index(columns.pop("law", "constant"))
    length = [len(columns["law_speeds"])] if KINDS[kind] == "table" else []
    return [float(kind), *length, *np.hstack(list(columns.values())).tolist()]


def at_rest(restitution: Restitution) -> float:
    """The coefficient of restitution as the speed tends to 0."""
    return float(restitution(0.0)) if isinstance(restitution, Law) else restitution
