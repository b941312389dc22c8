"""Results as MATLAB files: one struct with the names of the attributes."""

from __future__ import annotations

import dataclasses
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import MissingExtraError, ParameterError
from ..files import write_bytes


def scipy_io() -> Any:
    """scipy.io, or an error that says how to get it."""
    try:
        import scipy.io
    except ImportError:
        raise MissingExtraError(
            "MATLAB files need scipy: pip install 'vibroimpact[matlab]'"
        ) from None
    return scipy.io


def value_of(item: Any) -> Any:
    """Anything of a result as MATLAB has it: struct, cell array, matrix, text, logical; [] for None."""
    if item is None:
        return np.zeros((0, 0))
    if isinstance(item, np.ndarray):
        if item.dtype.names:
            return {name: value_of(item[name]) for name in item.dtype.names}
        return cells(item.tolist()) if item.dtype.kind == "U" else item
    if dataclasses.is_dataclass(item):
        return {
            field.name: value_of(getattr(item, field.name))
            for field in dataclasses.fields(item) if field.init
        }  # fmt: skip
    if hasattr(item, "_asdict"):
        return value_of(item._asdict())
    if isinstance(item, Mapping):
        return {str(name): value_of(inner) for name, inner in item.items()}
    if isinstance(item, (list, tuple)):
        if item and all(isinstance(inner, (int, float)) for inner in item):
            return np.array(item, dtype=float)
        return cells(item)
    return item


def cells(items: Any) -> Any:
    """A cell array, one row."""
    array = np.empty((1, len(items)), dtype=object)
    for i, item in enumerate(items):
        array[0, i] = value_of(item)
    return array


def write_matlab(result: Any, path: Path) -> None:
    """Write a struct named after the kind of result; `record` in it is for reading it back."""
    write_struct(type(result).__name__, value_of(result), result.to_json(), path)


def write_struct(kind: str, fields: Mapping[str, Any], record: str, path: Path) -> None:
    """Write a struct with these fields and the record."""
    buffer = io.BytesIO()
    scipy_io().savemat(
        buffer,
        {kind.lower(): {**fields, "record": record}},
        long_field_names=True,
        do_compression=True,
        oned_as="column",
    )
    write_bytes(path, buffer.getvalue())


def read_matlab(path: Path) -> str:
    """The record of a file that `write_matlab` wrote."""
    loadmat = scipy_io().loadmat
    try:
        data = loadmat(path)
    except OSError:
        raise
    except Exception as error:  # whatever scipy stumbles on in a file that is broken
        raise ParameterError(str(error)) from None
    for name, struct in data.items():
        if not name.startswith("__") and struct.dtype.names and "record" in struct.dtype.names:
            return str(struct["record"][0, 0][0])
    raise ParameterError("there is no struct with a field 'record'")
