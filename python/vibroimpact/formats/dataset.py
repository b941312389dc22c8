"""Results as xarray datasets, with named dimensions and the unit and meaning of each variable."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.libraries import xarray
from ..results.namelist import keys_of
from ..results.tables import settled


def to_xarray(noun: Any) -> Any:
    """All tables as one dataset; a column with the name of its dimension is a coordinate.

    A table with a parent has a variable with the name of the table; it contains the row of the parent for each row
    ("indexed ragged arrays" of the CF conventions). If a column name occurs in several tables, or is also the name
    of a dimension, the name of its table is added to it.
    """
    result = settled(noun._result)
    names = [column.name for _, column in result.columns()]
    names += {dim for table in result.tables.values() for dim in table.dims}
    data: dict[str, Any] = {}
    coords: dict[str, Any] = {}
    for name, table in result.tables.items():
        for column in table.columns.values():
            key = column.name if names.count(column.name) == 1 else f"{name}_{column.name}"
            if column.label == "=" or list(table.dims) == [column.name]:
                key = next(iter(table.dims))
            dims = (*table.dims, *([column.each] if column.each else []))
            attributes: dict[str, Any] = {"long_name": column.meaning, "units": column.unit or "1"}
            if column.kind == "complex":
                for part, values in (("real", column.values.real), ("imag", column.values.imag)):
                    data[f"{key}_{part}"] = (dims, values, attributes)
                continue
            values = column.decoded()
            if column.kind == "word":
                values = values.astype(object)
            elif column.kind == "truth":
                values = values.astype(np.int8)
            elif column.kind == "verdict":
                values = values.astype(np.int8)
                flags = np.array([1, 0, -1], np.int8)
                attributes |= {"flag_values": flags, "flag_meanings": "yes no unknown"}
            target = coords if dims == (key,) else data
            target[key] = (dims, values, attributes)
        if table.owners is not None:
            parent = next(iter(result.tables[table.parent].dims))
            about = {
                "long_name": f"{parent} that it belongs to",
                "units": "1",
                "instance_dimension": parent,
            }
            data[f"{name}_{table.parent}"] = (tuple(table.dims), table.owners, about)
    return xarray().Dataset(data, coords, common(noun))


def common(noun: Any) -> dict[str, Any]:
    """Attributes of every dataset: its kind, its case, and whether it is complete."""
    from .. import __version__

    result = noun._result
    if hasattr(noun, "structure"):
        return structure_attributes(noun)
    osc = noun.osc
    keys = {
        key: value for key, value in keys_of(result.case).items()
        if key not in ("xi", "mu", "restitution", "name", "format") and np.ndim(value) == 0
    }  # fmt: skip
    right, left = osc.restitution
    return {
        **keys, "xi": osc.xi, "mu": osc.mu, "R1": right, "R2": left, "complete": int(not result.cut),
        "Conventions": "CF-1.11", "title": repr(noun), "case": result.case,
        "source": f"vibroimpact {__version__}", "result": type(noun).__name__,
        "comment": "SI units, angles in radians" if noun.study == "identify"
        else "lengths in F0/K, time in 1/omega, angles in radians",
    }  # fmt: skip


def structure_attributes(noun: Any) -> dict[str, Any]:
    """Attributes of a dataset of a structure."""
    from .. import __version__

    result = noun._result
    return {
        "complete": int(not result.cut), "Conventions": "CF-1.11", "title": repr(noun), "case": result.case,
        "source": f"vibroimpact {__version__}", "result": type(noun).__name__, "comment": "units as in the case",
    }  # fmt: skip
