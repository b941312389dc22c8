"""Results as MATLAB files: one struct with the names of the columns."""

from __future__ import annotations

import io
import struct
import threading
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import MissingExtraError, ParameterError
from ..files import write_bytes
from ..tables import Result

#: scipy keeps the tag of the array that is being written in its class, which all threads share.
ONE_AT_A_TIME = threading.Lock()


#: The type of a part that is compressed.
COMPRESSED = 15


def scipy_io() -> Any:
    """scipy.io, or an error that says how to get it."""
    try:
        import scipy.io
    except ImportError:
        raise MissingExtraError(
            "MATLAB files need scipy: pip install 'vibroimpact[matlab]'"
        ) from None
    return scipy.io


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


def check_parts(path: Path) -> None:
    """Refuse a file of version 5 whose compressed parts are damaged: scipy can crash on them.

    Raises
    ------
    ParameterError
        If a part does not inflate to what its checksum says.
    """
    data = path.read_bytes()
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    at = 128
    while order and at + 8 <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        if kind == COMPRESSED:
            inflate = zlib.decompressobj()
            rest = data[at + 8 : at + 8 + size]
            try:
                while rest and not inflate.eof:
                    inflate.decompress(rest, 2**20)
                    rest = inflate.unconsumed_tail
                inflate.flush()
            except zlib.error as error:
                raise ParameterError(f"a compressed part is damaged: {error}") from None
            if not inflate.eof:
                raise ParameterError("a compressed part is damaged: it is cut")
        at += 8 + size


def read_matlab(path: Path) -> str:
    """The record of a file that `write_matlab` wrote."""
    loadmat = scipy_io().loadmat
    path.open(
        "rb"
    ).close()  # an OSError with the reason; scipy would also try the name with .mat appended
    check_parts(path)
    try:
        data = loadmat(path)
    except Exception as error:  # any exception that scipy raises on a broken file
        raise ParameterError(str(error)) from None
    for name, found in data.items():
        if name.startswith("__") or not found.dtype.names or "record" not in found.dtype.names:
            continue
        # savemat writes a 1 x 1 struct, and a text as one row
        record = found["record"].ravel()[0] if found.size else None
        if not isinstance(record, np.ndarray) or record.dtype.kind != "U" or record.size != 1:
            raise ParameterError("its field 'record' is not a text")
        return str(record.ravel()[0])
    raise ParameterError("there is no struct with a field 'record'")
