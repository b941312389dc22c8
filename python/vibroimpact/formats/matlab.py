"""Results as MATLAB files: one struct with the names of the columns."""

from __future__ import annotations

import io
import math
import struct
import threading
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import MissingExtraError, ParameterError
from ..files import write_bytes
from ..sizes import NUMBERS, TEXT, check_file, check_size
from ..tables import Result

#: scipy keeps the tag of the array that is being written in its class, which all threads share.
ONE_AT_A_TIME = threading.Lock()
#: The types of a part that is compressed, and of a matrix.
COMPRESSED, MATRIX = 15, 14
#: Classes of a matrix whose size is not that of its content: sparse ones, functions, and objects of MATLAB.
UNSIZED = (5, 16, 17)
#: Classes of numbers, the sparse one of them, and what says that there are imaginary parts, too.
NUMERIC, SPARSE, COMPLEX = range(5, 16), 5, 0x800
#: How deeply cells and structs may be nested.
DEEPEST = 50


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
    """Refuse a file of version 5 on which scipy could crash or hang, or that does not fit into memory.

    The sizes that compressed parts declare are checked before they are inflated.

    Raises
    ------
    ParameterError
        If a part does not inflate to what its checksum says, is cut, or declares more than it holds.
    """
    check_file(path, NUMBERS)
    data = path.read_bytes()
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    inflated = 0
    if order is None:
        return
    try:
        for kind, body in elements(memoryview(data)[128:], order, 1):
            if kind != COMPRESSED:
                check_matrix(kind, body, order)
                continue
            declared = 8 + struct.unpack(f"{order}II", zlib.decompressobj().decompress(body, 8))[1]
            inflated += declared
            check_size(inflated, TEXT, "what it holds, by the sizes of its compressed parts,")
            for item in elements(memoryview(inflate(body, declared)), order):
                check_matrix(*item, order)
    except struct.error:
        raise ParameterError("a part is damaged: it is cut") from None
    except zlib.error as error:
        raise ParameterError(f"a compressed part is damaged: {error}") from None


def inflate(packed: memoryview, size: int) -> bytearray:
    """What a compressed part holds, which is at most what it declares."""
    stream, found = zlib.decompressobj(), bytearray()
    for i in range(0, len(packed), 2**14):  # at most 17 MB at a time
        found += stream.decompress(packed[i : i + 2**14])
        if len(found) > size:
            raise ParameterError(
                f"a compressed part is damaged: it declares {size} bytes and has more"
            )
    if not stream.eof:
        raise ParameterError("a compressed part is damaged: it is cut")
    return found


def elements(data: memoryview, order: str, align: int = 8) -> Iterator[tuple[int, memoryview]]:
    """The elements that stand one after the other, each as its type and its content."""
    at = 0
    while at + 8 <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        if kind >> 16:  # a small one, with its size in the tag
            yield kind & 0xFFFF, data[at + 4 : at + 4 + min(4, kind >> 16)]
            at += 8
            continue
        body = data[at + 8 : at + 8 + size]
        if len(body) < size:
            raise ParameterError(f"a part is damaged: it declares {size} bytes and has {len(body)}")
        yield kind, body
        at += 8 + size + -size % align


def check_matrix(kind: int, body: memoryview, order: str, depth: int = 0) -> None:
    """Refuse a matrix that declares more entries than it can hold, for which scipy makes room first, or that lacks
    parts, which scipy takes for granted."""
    if kind != MATRIX or not len(body):
        return
    if depth > DEEPEST:
        raise ParameterError(f"its cells and structs are nested too deeply: at most {DEEPEST}")
    parts = elements(body, order)
    try:
        (_, flags), (_, dims) = next(parts), next(parts)
    except StopIteration:
        raise ParameterError("a part is damaged: a matrix has no size") from None
    word = struct.unpack_from(f"{order}I", flags)[0]
    of_class = word & 0xFF
    rest = list(parts)
    # its name, places of a sparse one, numbers, and imaginary parts
    least = {SPARSE: 4}.get(of_class, 2) + bool(word & COMPLEX)
    if of_class in NUMERIC and len(rest) < least:
        raise ParameterError(
            f"a part is damaged: a matrix has {len(rest)} parts after its size and must have {least}"
        )
    if of_class in UNSIZED:
        return
    count = math.prod(size for (size,) in struct.iter_unpack(f"{order}i", dims))
    if not 0 <= count <= len(body):
        raise ParameterError(f"a matrix declares {count} entries and has {len(body)} bytes")
    for item in rest:
        check_matrix(*item, order, depth + 1)


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
