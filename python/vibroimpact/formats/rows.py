"""The rows of a result as in the CSV: the rows of one table, with the values of its parent tables repeated."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.errors import MissingExtraError
from ..results.namelist import parts_of
from ..results.systems import outputs_of
from ..results.tables import Column, Result
from ..systems.units import units_to_show

#: The meaning of the codes of verdicts.
VERDICTS = np.array([None, False, True], dtype=object)


def rows(result: Result) -> dict[str, NDArray[Any]]:
    """The listed columns by their names in the CSV, with one value for each row."""
    found = {name: values for name, _, values in listed_columns(result)}
    keep = listed(result, found)
    return {name: values[keep] for name, values in found.items()}


def listed_columns(result: Result) -> Iterator[tuple[str, Column, NDArray[Any]]]:
    """The name of each column of the CSV, the column of a table that it is from, and its values."""
    owned = places_of(result, result.row)
    for table, column in result.columns():
        if not column.listed:
            continue
        name = next(key for key, item in result.tables.items() if item is table)
        size = int(np.prod(list(table.dims.values())))
        inner = column.values.shape[-1] if column.each else 1
        values = column.values.reshape(size, inner)[owned[name]]
        # coordinates are numbered from 0, as in the names of keys
        start = 0 if column.each == "coordinate" else 1
        names = [str(i) for i in range(start, start + inner)]
        if column.each == "output":
            own_names = [*outputs_of(parts_of(result.case)[0][1])]
            names = own_names + names[len(own_names) :]
        own = next(iter(table.dims)) if column.label == "=" else column.label or column.name
        for label, part in zip(names, values.T, strict=True):
            for key, item in cells(column, part, own.replace("#", label)).items():
                yield key, column, item


def cells(column: Column, values: NDArray[Any], label: str) -> dict[str, NDArray[Any]]:
    """One column of the CSV, or two columns of a complex number."""
    if column.kind == "complex":
        if "modulus" in label:
            return {label: np.hypot(values.real, values.imag)}
        return {f"{label}_re": values.real, f"{label}_im": values.imag}
    if column.kind == "word":
        return {label: np.array(("", *column.words), dtype=object)[values]}
    if column.kind == "verdict":
        return {label: VERDICTS[values + 1]}
    return {label: values == 1 if column.kind == "truth" else values}


def listed(result: Result, found: dict[str, NDArray[Any]]) -> NDArray[np.bool_]:
    """The rows that the CSV contains; empty places of a chart are omitted."""
    from ..base.status import NO_MOTION, NOT_COMPUTED

    size = next(iter(found.values())).size
    if result.study != "chart":
        return np.ones(size, dtype=bool)
    return ~np.isin(found["status"], (NO_MOTION, NOT_COMPUTED))


def places_of(result: Result, name: str) -> dict[str, NDArray[np.intp]]:
    """For each table, the row to which each row of the given table belongs, by parent or by dimension."""
    table = result.tables[name]
    sizes = tuple(table.dims.values())
    own = np.arange(int(np.prod(sizes)))
    places: dict[str, NDArray[np.intp]] = {name: own}
    along = np.unravel_index(own, sizes) if sizes else ()
    for dim, place in zip(table.dims, along, strict=True):
        for other, item in result.tables.items():
            if other != name and list(item.dims) == [dim]:
                places[other] = place
    for other, item in result.tables.items():
        if not item.dims:
            places[other] = np.zeros_like(own)
    if table.owners is not None:
        upper = places_of(result, table.parent)
        places |= {other: place[table.owners] for other, place in upper.items()}
        places[name] = own
    return places


def to_pandas(noun: Any, units: str | None = None) -> Any:
    """The rows as a DataFrame, in the units in which a CSV file has them."""
    if units != "dimensionless" and noun.study != "identify":
        known = units_to_show(noun._system) if units is None else units
        shown = noun if known is None else noun.physical(known)
        if hasattr(shown, "units"):
            return shown.to_pandas()
        noun = shown
    return frame(noun)


def frame(noun: Any) -> Any:
    """The rows as they are, as a DataFrame."""
    try:
        import pandas
    except ImportError:
        raise MissingExtraError(
            "data frames need pandas: pip install 'vibroimpact[data]'"
        ) from None
    return pandas.DataFrame(rows(noun._result))
