"""Results as MATLAB files: one struct with the names of the columns."""

from __future__ import annotations

import io
import threading
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import ParameterError
from ..base.files import write_bytes
from ..base.matlab import read_variables, scipy_io
from ..results.tables import Result

#: scipy keeps the tag of the array being written in its class, which all threads share; hence the lock.
ONE_AT_A_TIME = threading.Lock()


def write_matlab(noun: Any, path: Path) -> None:
    """Write a struct named after the kind of result, with a field for each column; `load` reads its `record`."""
    result: Result = noun._result
    fields: dict[str, Any] = {"case": result.case}
    names = [column.name for _, column in result.columns()]
    for name, table in result.tables.items():
        for column in table.columns.values():
            key = column.name if names.count(column.name) == 1 else f"{name}_{column.name}"
            values = column.decoded()
            fields[key] = cells(values.tolist()) if column.kind == "word" else values
        if table.owners is not None:
            fields[f"{name}_{table.parent}"] = table.owners + 1  # MATLAB counts from 1
    buffer = io.BytesIO()
    content = {type(noun).__name__.lower(): {**fields, "record": noun.to_json()}}
    with ONE_AT_A_TIME:
        scipy_io().savemat(
            buffer,
            content,
            long_field_names=True,
            do_compression=True,
            oned_as="column",
        )
    write_bytes(path, buffer.getvalue())


def cells(items: Any) -> Any:
    """A text, or a cell array of texts with one row."""
    if isinstance(items, str):
        return items
    array = np.empty((1, len(items)), dtype=object)
    for i, item in enumerate(items):
        array[0, i] = cells(item)
    return array


def read_matlab(path: Path) -> str:
    """The record of a file that `write_matlab` wrote."""
    path.open("rb").close()  # an OSError with the reason
    for found in read_variables(path).values():
        if not isinstance(found, dict) or "record" not in found:
            continue
        record = found["record"]
        if not isinstance(record, str) or not record:
            raise ParameterError("its field 'record' is not a text")
        return record
    raise ParameterError("there is no struct with a field 'record'")
