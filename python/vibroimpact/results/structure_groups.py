"""The groups of a namelist that describe a structure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..base.errors import ParameterError, VibroimpactError
from ..systems.record import Record
from ..systems.restitution import law_of_keys
from ..systems.structure import Gap, Load, Structure
from . import namelist
from .tables import Result

__all__ = ["check_gap_numbers", "from_groups", "system_of"]


def system_of(case: str) -> tuple[Structure, Load | Record | None]:
    """The structure and the load of the case of a study, as the core has completed it.

    Raises
    ------
    ParameterError
        If it is not complete, as that of a file may be.
    """
    try:
        return from_groups(namelist.parts_of(case)[:-1])
    except VibroimpactError as error:
        raise ParameterError(f"case: {error}") from None
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        raise ParameterError(
            f"case = {case[:60]!r}: must be that of a structure; {type(error).__name__}: {error}"
        ) from None


def from_groups(
    groups: Sequence[tuple[str, Mapping[str, Any]]],
) -> tuple[Structure, Load | Record | None]:
    """The structure and the load of the groups of a namelist, as the core has completed them."""
    (_, keys), *parts = groups
    gaps = [
        Gap(np.atleast_1d(part["direction"]), part["opening"], law_of_keys(part))
        for name, part in parts if name == "gap"
    ]  # fmt: skip
    if "frequencies" in keys:
        omega = np.atleast_1d(keys["frequencies"])
        shapes = np.reshape(keys["shapes"], (-1, len(omega)))
        structure = Structure.from_modes(omega, np.atleast_1d(keys["damping_ratios"]), shapes, gaps)
    else:
        n = len(gaps[0].direction)
        mass, damping, stiffness = (
            _square(keys[name], n) for name in ("mass", "damping", "stiffness")
        )
        structure = Structure(mass, damping, stiffness, gaps)
    load: Load | Record | None = None
    for part in (part for name, part in parts if name == "load"):
        n = structure.coordinates
        constant = np.atleast_1d(part["constant"]) if "constant" in part else None
        if "record" in part:
            weights = (
                np.reshape(part["weights"], (-1, n)) if "weights" in part
                else np.eye(n)[np.atleast_1d(part.get("acts_on", np.arange(n)))]
            )  # fmt: skip
            samples = np.reshape(part["record"], (-1, len(weights)))
            return structure, Record(part["step"], samples, constant, weights)
        harmonics = {
            name: np.reshape(part[name], (-1, n)) for name in ("sine", "cosine") if name in part
        }
        load = Load(part.get("frequency"), **harmonics, constant=constant)
    return structure, load


def check_gap_numbers(result: Result, structure: Structure) -> None:
    """An error if a column of gaps has a number that is none of the structure's, with which the core would read
    beyond its arrays."""
    many = len(structure.gaps)
    for name, table in result.tables.items():
        for key in {"gap", "gaps"} & set(table.columns):
            numbers = table.columns[key].values
            wrong = numbers[~((numbers >= 0) & (numbers < many))]
            if wrong.size:
                raise ParameterError(
                    f"{name}.{key} = {wrong[0]}: must be the number of one of {many} gaps, from 0"
                )
        for key, column in table.columns.items():
            if column.each == "coordinate" and column.values.shape[-1] != structure.coordinates:
                raise ParameterError(
                    f"{name}.{key} of shape {column.values.shape}: must be for {structure.coordinates} coordinates"
                )


def _square(numbers: Any, n: int) -> Any:
    """A matrix, or its diagonal, from a list."""
    array = np.atleast_1d(numbers)
    return array if len(array) == n else array.reshape(n, n)
