"""The variables of MATLAB files of version 5."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import MissingExtraError, ParameterError
from .sizes import NUMBERS, TEXT, check_file, check_size

#: The types of a part that is compressed, of a matrix, and of sizes and names.
COMPRESSED, MATRIX, INT8, INT32, UINT32 = 15, 14, 1, 5, 6
#: How numbers are stored, and texts, by the type of their part.
NUMBERS_OF = {
    1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8",
}  # fmt: skip
TEXTS_OF = {1: "latin-1", 2: "latin-1", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
#: Classes of a matrix: cells, structs, texts, and dense numbers; the others cannot occur in a record.
CELLS, STRUCT, CHARACTERS, NUMERIC, COMPLEX = 1, 2, 4, range(6, 16), 0x800
#: How deeply cells and structs may be nested, and the most dimensions of a matrix.
DEEPEST, DIMENSIONS = 50, 32


def scipy_io() -> Any:
    """scipy.io, or an error that says how to get it."""
    try:
        import scipy.io
    except ImportError:
        raise MissingExtraError(
            "MATLAB files need scipy: pip install 'vibroimpact[matlab]'"
        ) from None
    return scipy.io


def read_variables(path: Path) -> dict[str, Any]:
    """The variables of a MATLAB file of version 5; each tag is checked before it is used.

    scipy does not check tags, so a corrupted byte can crash the interpreter. The declared sizes of compressed
    parts are checked before they are inflated.

    Returns
    -------
    dict
        By name: arrays of numbers, texts (a list of texts if there are several rows), structs as dicts, and lists
        of structs and cells in MATLAB's order; None for sparse matrices, functions and objects.

    Raises
    ------
    ParameterError
        If a part does not match its checksum, is truncated, or has the wrong type or size.
    """
    check_file(path, NUMBERS)
    data = path.read_bytes()
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    if 0 in data[:4]:  # version 4, which scipy reads in Python
        found = scipy_io().loadmat(path)
        return {name: value for name, value in found.items() if not name.startswith("__")}
    if order is None:
        raise ParameterError("it is not a MATLAB file")
    if struct.unpack(f"{order}H", data[124:126])[0] >> 8 != 1:
        raise ParameterError("it is not of version 5: save it in MATLAB with the option '-v7'")
    variables: dict[str, Any] = {}
    inflated = 0
    for kind, body in elements(memoryview(data)[128:], order, 1):
        parts = [(kind, body)]
        if kind == COMPRESSED:
            try:
                begin = zlib.decompressobj().decompress(body, 8)
                if len(begin) < 8:
                    raise ParameterError("a compressed part is damaged: it is truncated")
                declared = 8 + struct.unpack(f"{order}II", begin)[1]
                inflated += declared
                check_size(inflated, TEXT, "the content, by the sizes of its compressed parts,")
                parts = list(elements(memoryview(inflate(body, declared)), order))
            except zlib.error as error:
                raise ParameterError(f"a compressed part is damaged: {error}") from None
        for part in parts:
            variables |= [matrix_of(*part, order)]
    return variables


def inflate(packed: memoryview, size: int) -> bytearray:
    """The content of a compressed part, at most of the declared size."""
    stream, found = zlib.decompressobj(), bytearray()
    for i in range(0, len(packed), 2**14):  # at most 17 MB at a time
        found += stream.decompress(packed[i : i + 2**14])
        if len(found) > size:
            raise ParameterError(
                f"a compressed part is damaged: it declares {size} bytes and has more"
            )
    if not stream.eof:
        raise ParameterError("a compressed part is damaged: it is truncated")
    return found


def elements(data: memoryview, order: str, align: int = 8) -> Iterator[tuple[int, memoryview]]:
    """The consecutive elements, each with its type and content."""
    at = 0
    while at + 8 <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        if kind >> 16:  # a small one, with its size in the tag
            kind, size = kind & 0xFFFF, kind >> 16
            if size > 4:
                raise ParameterError(f"a part is damaged: it declares {size} bytes, but has 4")
            yield kind, data[at + 4 : at + 4 + size]
            at += 8
            continue
        body = data[at + 8 : at + 8 + size]
        if len(body) < size:
            raise ParameterError(f"a part is damaged: it declares {size} bytes and has {len(body)}")
        yield kind, body
        at += 8 + size + -size % align


def matrix_of(kind: int, body: memoryview, order: str, depth: int = 0) -> tuple[str, Any]:
    """The name and the content of a matrix, as in `read_variables`."""
    if kind != MATRIX:
        raise ParameterError(f"a part is damaged: it is of type {kind} and must be a matrix")
    if not len(body):
        return "", np.zeros(0)
    if depth > DEEPEST:
        raise ParameterError(f"its cells and structs are nested too deeply: at most {DEEPEST}")
    parts = elements(body, order)

    def part(what: str, *kinds: int) -> tuple[int, memoryview]:
        """The next part, which must be of one of the given types."""
        found = next(parts, None)
        if found is None:
            raise ParameterError(f"a part is damaged: a matrix has no {what}")
        if found[0] not in kinds:
            raise ParameterError(f"a part is damaged: {what} of a matrix is of type {found[0]}")
        return found

    flags = numbers_of(*part("flags", UINT32), order)
    dims = numbers_of(*part("size", INT32), order).tolist()
    name = bytes(part("name", INT8)[1]).decode("latin-1")
    if len(flags) != 2 or not 2 <= len(dims) <= DIMENSIONS or min(dims) < 0:
        raise ParameterError(f"a part is damaged: a matrix of flags {flags} and size {dims}")
    of_class, count = int(flags[0]) & 0xFF, math.prod(dims)
    if of_class not in (CELLS, STRUCT, CHARACTERS, *NUMERIC):
        return name, None
    if count > len(body):
        raise ParameterError(f"a matrix declares {count} entries and has {len(body)} bytes")

    def inner(many: int) -> list[Any]:
        """The next matrices."""
        found = [part("entries", MATRIX) for _ in range(many)]
        return [matrix_of(*one, order, depth + 1)[1] for one in found]

    if of_class in NUMERIC:
        real = numbers_of(*part("numbers", *NUMBERS_OF), order)
        values = real
        if int(flags[0]) & COMPLEX:
            imaginary = numbers_of(*part("imaginary part", *NUMBERS_OF), order)
            if real.shape != imaginary.shape:
                raise ParameterError("a part is damaged: an imaginary part has a different size")
            values = real + 1j * imaginary.astype(np.float64)
        if values.size != count:
            raise ParameterError(f"a matrix declares {count} entries and has {values.size}")
        return name, values.reshape(dims, order="F") if count else np.zeros(0)
    if of_class == CHARACTERS:
        return name, text_of(*part("text", *TEXTS_OF), order, dims) if count else ""
    if of_class == CELLS:
        return name, inner(count)
    width = numbers_of(*part("length of names", INT32), order)
    names = bytes(part("names", INT8)[1])
    if len(width) != 1 or width[0] < 1 or len(names) % int(width[0]):
        raise ParameterError(f"a part is damaged: names of {len(names)} bytes, {width} each")
    fields = [
        names[at : at + int(width[0])].split(b"\0")[0].decode("latin-1")
        for at in range(0, len(names), int(width[0]))
    ]
    structs = [dict(zip(fields, inner(len(fields)), strict=True)) for _ in range(count)]
    return name, structs[0] if count == 1 else structs


def numbers_of(kind: int, body: memoryview, order: str) -> NDArray[Any]:
    """The numbers of a part."""
    stored = np.dtype(order + NUMBERS_OF[kind])
    if len(body) % stored.itemsize:
        raise ParameterError(
            f"a part is damaged: {len(body)} bytes of numbers of {stored.itemsize} bytes"
        )
    return np.frombuffer(body, stored)


def text_of(kind: int, body: memoryview, order: str, dims: list[int]) -> Any:
    """A text, or the rows of a matrix of characters."""
    code = TEXTS_OF[kind]
    ending = {"<": "-le", ">": "-be"}[order] if code in ("utf-16", "utf-32") else ""
    try:
        text = bytes(body).decode(code + ending)
    except UnicodeDecodeError as error:
        raise ParameterError(f"a part is damaged: a text that is not {code}; {error}") from None
    rows, width = dims[0], math.prod(dims[1:])
    # MATLAB counts UTF-16 code units, scipy counts characters
    if width not in (len(text) // rows, len(text.encode("utf-16-le")) // 2 // rows):
        raise ParameterError(f"a text declares size {dims} and has {len(text)} characters")
    return text if rows == 1 else [text[i::rows] for i in range(rows)]
