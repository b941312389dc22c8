"""Conversion of results to plain values and JSON, and back, with the same bits."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable
from dataclasses import replace
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError, VibroimpactError
from ..results.namelist import has_scales, has_structure
from ..results.noun import FORMER
from ..results.tables import (
    STORED,
    Column,
    Found,
    Result,
    Table,
    column_from,
    declared,
    present,
    row_of,
)  # fmt: skip
from .rows import places_of

#: Characters that no word may contain: the core keeps words as lines.
CONTROL = re.compile(r"[\0-\x1f\x7f]")
#: Columns of words that have a value in every row.
NEEDED = ("kind", "law", "moment", "run")
#: Largest number of dimensions of a table.
MOST_DIMENSIONS = 3
#: The smallest and the largest code of verdicts and of logical values.
LIMITS = {"verdict": (-1, 1), "truth": (0, 1)}
#: The fields of a record besides its tables, with their types.
HEAD = {"case": str, "cut": str, "empty": bool, "remarks": list, "notes": list}


def to_dict(noun: Any) -> dict[str, Any]:
    """The case, the notes and remarks, and the tables with their columns."""
    result: Result = noun._result
    tables: dict[str, dict[str, Any]] = {}
    for name, table in result.tables.items():
        columns = {key: encoded(column) for key, column in table.columns.items()}
        tables[name] = {"dims": dict(table.dims), "columns": columns}
        if table.owners is not None:
            tables[name] |= {"parent": table.parent, "owners": table.owners.tolist()}
    return {
        "type": type(noun).__name__, "study": result.study, "vibroimpact": version("vibroimpact"),
        "case": result.case, "cut": result.cut, "empty": result.empty, "remarks": list(result.remarks),
        "notes": [list(note) for note in result.notes], "tables": tables,
    }  # fmt: skip


def encoded(column: Column) -> Any:
    """The values of a column; words are given as texts, so that no list of them is needed."""
    if column.kind == "complex":
        pairs = np.stack([column.values.real, column.values.imag], axis=-1)
        return no_nan(pairs.tolist())
    if column.kind == "real":
        return no_nan(column.values.tolist())
    values = column.values if column.kind == "verdict" else column.decoded()
    return values.tolist()


def no_nan(item: Any) -> Any:
    """NaN replaced by None, and infinite numbers by texts: JSON has neither."""
    if isinstance(item, list):
        return [no_nan(inner) for inner in item]
    if math.isfinite(item):
        return item
    return None if math.isnan(item) else repr(item)


def to_json(noun: Any) -> str:
    """`to_dict` as JSON text."""
    return json.dumps(to_dict(noun), allow_nan=False)


def from_json(kind: Any, text: str) -> Any:
    """The inverse of `to_json`."""
    try:
        data = json.loads(text)
    except RecursionError:
        raise ParameterError(
            f"text of {len(text)} characters: must be JSON; it is nested too deeply"
        ) from None
    except ValueError as error:
        raise ParameterError(f"text of {len(text)} characters: must be JSON; {error}") from None
    return from_dict(kind, data)


def from_dict(kind: Any, data: Any) -> Any:
    """The inverse of `to_dict`."""
    name = mapping(data, "record").get("type", kind.__name__)
    named = present(str(data.get("study", kind.study)))
    if FORMER.get(name, kind) is not kind or (name != kind.__name__ and name not in FORMER):
        raise ParameterError(f"type = {name!r}: must be {kind.__name__!r}")
    if named != kind.study:
        raise ParameterError(f"study = {named!r}: must be {kind.study!r}")
    for key, wanted in HEAD.items():
        if not isinstance(data.get(key), wanted):
            raise ParameterError(f"{key} = {data.get(key)!r}: must be of type {wanted.__name__}")
    given = mapping(data.get("tables"), "tables")
    structure = has_structure(data["case"]) or "matrices" in given
    known = declared(named, structure, has_scales(data["case"]))
    system = "a structure" if structure else "an oscillator"
    columns: dict[str, dict[str, Any]] = {}
    for (table, column), item in known.items():
        columns.setdefault(table, {})[column] = item
    for key in ("case", "cut", "remarks", "notes"):
        check_texts(key, data[key])
    tables = {}
    for name, table in given.items():
        check_name(name, "tables")
        tables[name] = table_of(name, mapping(table, name), columns.get(name, {}), system)
    widen_empty(tables)
    check_sizes(tables)
    check_parents(tables)
    if not all(isinstance(note, list) and len(note) == 2 for note in data["notes"]):
        raise ParameterError(
            f"notes = {data['notes']!r}: must be pairs of a boolean, True for a fault, and a text"
        )
    notes = tuple((bool(note[0]), str(note[1])) for note in data["notes"])
    result = Result(
        named, data["case"], data["cut"], data["empty"], tuple(map(str, data["remarks"])), notes,
        row_of(named, structure), Found(tables, "tables"),
    )  # fmt: skip
    if not result.empty:
        check_rows(result, known.values())
    try:
        noun = kind.of_result(result)
        noun._check_read()
        repr(noun)  # which needs the columns that all its tables share
    except VibroimpactError:
        raise
    except Exception as error:
        raise ParameterError(
            f"tables: must be those of a {kind.__name__} and be consistent with each other; "
            f"{type(error).__name__}: {error}"
        ) from None
    return noun


def widen_empty(tables: dict[str, Table]) -> None:
    """Sets the own dimension of columns in tables without rows to its size in other columns; empty lists do not
    show it."""
    sizes = {
        column.each: column.values.shape[-1]
        for table in tables.values() if math.prod(table.dims.values())
        for column in table.columns.values() if column.each
    }  # fmt: skip
    for table in tables.values():
        if math.prod(table.dims.values()):
            continue
        for key, column in table.columns.items():
            if column.each in sizes:
                shape = (*column.values.shape[:-1], sizes[column.each])
                table.columns[key] = replace(column, values=np.empty(shape, column.values.dtype))


def check_sizes(tables: dict[str, Table]) -> None:
    """Raises an error if a table has neither columns nor owners, or if a dimension has different sizes in two
    places."""
    sizes: dict[str, int] = {}
    for name, table in tables.items():
        if not table.columns and table.owners is None:
            raise ParameterError(f"{name}.columns: must have at least one column")
        own = [
            (column.each, column.values.shape[-1])
            for column in table.columns.values()
            if column.each
        ]
        for dim, size in [*table.dims.items(), *own]:
            if sizes.setdefault(dim, size) != size:
                raise ParameterError(
                    f"{name}: {dim} = {size}: must be {sizes[dim]}, its size elsewhere in the record"
                )


def check_parents(tables: dict[str, Table]) -> None:
    """Raises an error unless the parent of each table exists and the owners are rows of it, in order."""
    for name, table in tables.items():
        if not table.parent:
            continue
        above = name
        for _ in tables:
            if above in tables:
                above = tables[above].parent
        if table.parent not in tables or above:
            raise ParameterError(
                f"{name}.parent = {table.parent!r}: must be another table, and not one that belongs to this table"
            )
        owners = np.zeros(0) if table.owners is None else table.owners
        rows = math.prod(tables[table.parent].dims.values())
        if owners.size and not (
            0 <= owners.min() and owners.max() < rows and (np.diff(owners) >= 0).all()
        ):
            raise ParameterError(f"{name}.owners: must be rows of {table.parent}, in order, from 0")


def check_rows(result: Result, columns: Iterable[dict[str, Any]]) -> None:
    """Raises an error unless every cell in the rows of the CSV has a value."""
    if result.row not in result.tables:
        raise ParameterError(f"tables.{result.row}: must be present; it is missing")
    places = places_of(result, result.row)
    for item in columns:
        name = item["table"]
        # a structure without outputs has no column for them
        absent = item["each"] == "output" and item["name"] not in result.tables[name].columns
        if absent or not item["listed"]:
            continue
        result.column(name, item["name"])
        rows = math.prod(result.tables[name].dims.values())
        if name not in places or (places[name].size and places[name].max() >= rows):
            raise ParameterError(f"{name}: must have a row for each row of {result.row}")


def mapping(data: Any, name: str) -> dict[str, Any]:
    """Check that data are a JSON object."""
    if not isinstance(data, dict):
        raise ParameterError(f"{name} = {str(data)[:60]!r}: must be an object with names")
    return data


def check_name(name: str, label: str) -> str:
    """Checks the name of a table or a dimension; the core allows few characters."""
    if not re.fullmatch("[a-z][a-z0-9_]{0,14}", name):
        wanted = "must be a name of 1 to 15 small letters, digits and underscores"
        raise ParameterError(f"{label}: {name[:40]!r} {wanted}")
    return name


def check_texts(label: str, item: Any) -> None:
    """Raises an error if a text, or a text in a list, cannot be written to a file."""
    for inner in item if isinstance(item, list) else ():
        check_texts(label, inner)
    if isinstance(item, str):
        try:
            item.encode(errors="surrogateescape")
        except UnicodeEncodeError:
            raise ParameterError(f"{label} = {item[:60]!r}: must be valid Unicode text") from None


def table_of(name: str, data: dict[str, Any], declared: dict[str, Any], system: str) -> Table:
    """A table from its record; `system` is the kind of system of its case."""
    dims = {
        check_name(key, f"{name}.dims"): checks.integer(size, f"{name}.dims.{key}", 0, 2**31 - 1)
        for key, size in mapping(data.get("dims"), f"{name}.dims").items()
    }
    shape = tuple(dims.values())
    owners = None
    if data.get("parent"):
        owners = array_of(f"{name}.owners", data.get("owners"), shape, "<i4")
    if len(dims) > MOST_DIMENSIONS:
        raise ParameterError(
            f"{name}.dims = {list(dims)}: must be at most {MOST_DIMENSIONS} dimensions"
        )
    columns = {}
    for key, values in mapping(data.get("columns"), f"{name}.columns").items():
        if key not in declared:
            wanted = f"one of {', '.join(declared)}" if declared else "left out"
            raise ParameterError(f"{name}.{key}: must be {wanted}; the case is that of {system}")
        if declared[key]["label"] == "=" and not dims:
            raise ParameterError(
                f"{name}.dims: must contain the dimension along which {key} names rows"
            )
        columns[key] = column_of(f"{name}.{key}", declared[key], values, shape)
    return Table(dims, str(data.get("parent", "")), owners, Found(columns, name))


def column_of(label: str, declared: dict[str, Any], data: Any, shape: tuple[int, ...]) -> Column:
    """A column from its record."""
    kind, own = declared["kind"], bool(declared["each"])
    if kind == "word":
        values = array_of(label, data, shape, object)
        known = declared["words"].split(",") if declared["words"] else None
        check_words(label, values, known)
    elif kind in STORED:
        if kind == "complex":
            pairs = array_of(label, data, (*shape, -1, 2) if own else (*shape, 2), "<f8")
            values = np.ascontiguousarray(pairs).view("<c16")[..., 0]
        else:
            values = array_of(label, data, (*shape, -1) if own else shape, "<f8")
    else:
        values = array_of(label, data, (*shape, -1) if own else shape, "<i4")
        low, high = LIMITS.get(kind, (None, None))
        if values.size and low is not None and not low <= values.min() <= values.max() <= high:
            raise ParameterError(f"{label} = {str(data)[:60]}: must be codes from {low} to {high}")
    return column_from(declared, values)


def check_words(label: str, values: NDArray[Any], known: list[str] | None) -> None:
    """Raises an error unless all values are texts, and among the declared words if the core declares any."""
    texts = values.ravel().tolist()
    strange = [text for text in texts if not isinstance(text, str)]
    if strange:
        raise ParameterError(f"{label} = {strange[0]!r}: must be a text")
    check_texts(label, texts)
    strange = sorted({text for text in texts if CONTROL.search(text)})
    if strange:
        raise ParameterError(f"{label} = {strange[0]!r}: must be a text without line ends")
    absent = set() if label.rpartition(".")[2] in NEEDED else {""}
    strange = [] if known is None else sorted(set(texts) - absent.union(known))
    if strange:
        raise ParameterError(f"{label} = {strange[0]!r}: must be one of {', '.join(known or ())}")


def numbers_of(data: Any, stored: str) -> NDArray[Any]:
    """An array of numbers without rounding; texts are accepted only for the values that JSON lacks (infinities).

    Raises
    ------
    ValueError, TypeError, OverflowError
        If the array contains another value.
    """
    array = np.array(data)
    if array.size == 0 or array.dtype.kind in ("iuf" if stored == "<f8" else "iub"):
        found = array.astype(stored)
        if stored == "<i4" and (found != array).any():
            raise OverflowError
        return found
    if stored == "<i4":
        raise TypeError
    array = np.array(data, dtype=object)
    for item in array.ravel().tolist():
        if not (item is None or type(item) in (int, float) or item in ("inf", "-inf")):
            raise TypeError
    return np.where(array == None, np.nan, array).astype(stored)  # noqa: E711 (elementwise)


def array_of(label: str, data: Any, shape: tuple[int, ...], stored: Any) -> NDArray[Any]:
    """An array of a given shape, with -1 for any size."""
    try:
        array = np.array(data, dtype=object) if stored is object else numbers_of(data, stored)
        fits = array.ndim == len(shape) and all(
            want in (-1, size) for want, size in zip(shape, array.shape, strict=True)
        )
        if fits:
            return array
        if array.size == 0 and 0 in shape:
            return array.reshape([max(0, size) for size in shape])
    except (OverflowError, TypeError, ValueError):
        pass
    raise ParameterError(f"{label} = {str(data)[:60]}: must be numbers of shape {shape}")
