"""A result as named tables: arrays that share the memory of the core, or were read from a file."""

from __future__ import annotations

import json
import weakref
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..base.errors import ParameterError
from ..systems.units import GAP, MIXED, OF_STRUCTURE, RATIO, powers_of, unit_of_state
from .namelist import has_scales, has_structure, keys_of, parts_of

#: The models of systems, as the core calls them.
MODELS = ("oscillator", "structure")
#: How values are stored, by the kind of their column.
STORED = {"real": "<f8", "complex": "<c16"}


#: Columns of a design with the unit of its target, and these units.
OF_TARGET = ("limit", "level", "nominal", "worst")
UNIT_OF = {
    "attenuation": "", "displacement": "F0/K", "rms": "F0/K", "acceleration": "omega^2 F0/K", "force": "F0",
    "damping": "",
}  # fmt: skip


def text_of(function: Any, *arguments: Any, capacity: int = 16_384) -> str:
    """A text that a function of the core writes into a buffer."""
    text, length = function(*arguments, capacity)
    if length > capacity:
        text, length = function(*arguments, length)
    return bytes(text[:length].tobytes()).decode(errors="surrogateescape")


@cache
def language() -> Any:
    """The keys of all groups and the columns of all results, as the core declares them."""
    return json.loads(text_of(_core.describe_language, capacity=200_000))


def is_for(declared: Mapping[str, Any], of_structure: bool) -> bool:
    """Whether a key or column belongs to cases of structures, or to all other cases."""
    return declared["model"] in ("", MODELS[of_structure])


@cache
def keys_for(group: str, of_structure: bool = False) -> list[dict[str, Any]]:
    """The keys of a group in cases of oscillators, or of structures."""
    return [key for key in language()["groups"][group] if is_for(key, of_structure)]


def present(study: str) -> str:
    """The present name of a study in a file; earlier versions had two names for a study of oscillators and
    structures."""
    return study if study in language()["results"] else study.removesuffix("_structure")


#: Columns of results of structures whose unit depends on a parameter or an axis.
OF_PARAMETERS = ("value", "place", "x", "y")


class Handle:
    """Owns a result of the core; the result is freed together with the last array that shares its memory."""

    def __init__(self, number: int) -> None:
        self.number = number
        weakref.finalize(self, _core.free_result, number)


def message_of(handle: Handle) -> str:
    """The error of a case that the core rejected, or the text of a handle; bytes that are not UTF-8 stay
    unchanged."""
    message: str = json.loads(text_of(_core.describe_result, handle.number))["message"]
    return message


class Memory:
    """Memory of a result in NumPy's array interface: read-only, and valid as long as an array uses it."""

    def __init__(self, owner: Handle, address: int, shape: tuple[int, ...], stored: str) -> None:
        self.owner = owner
        self.__array_interface__ = {
            "version": 3, "data": (address, True), "shape": shape, "typestr": stored,
        }  # fmt: skip


def shown(owner: Handle, address: int, shape: tuple[int, ...], stored: str = "<i4") -> NDArray[Any]:
    """An array of the core, without copying."""
    if 0 in shape:
        empty: NDArray[Any] = np.empty(shape, stored)
        empty.flags.writeable = False
        return empty
    return np.asarray(Memory(owner, address, shape, stored))


@dataclass(frozen=True, slots=True, eq=False)
class Column:
    """A column with its declaration; `values` has the dimensions of its table, then its own."""

    name: str
    kind: str
    each: str
    unit: str
    meaning: str
    label: str
    listed: bool
    words: tuple[str, ...]
    values: NDArray[Any]

    def decoded(self) -> NDArray[Any]:
        """Converts words to texts and logical values to bool; verdicts stay codes, and numbers are unchanged."""
        if self.kind == "word":
            texts: NDArray[Any] = np.array(("", *self.words))[self.values]
            return texts
        return self.values == 1 if self.kind == "truth" else self.values


def column_from(description: dict[str, Any], values: Any) -> Column:
    """A column from its declaration and its values, with words as texts; verdicts are codes."""
    words = tuple(word for word in description["words"].split(",") if word)
    if description["kind"] == "word":
        texts = np.asarray(values, dtype=object)
        flat = texts.ravel().tolist()
        words += tuple(dict.fromkeys(text for text in flat if text and text not in words))
        places = {text: i for i, text in enumerate(("", *words))}
        codes = np.fromiter((places[text] for text in flat), "<i4", len(flat))
        values = codes.reshape(texts.shape)
    # a view, so that the array of a caller keeps its own flags
    array = np.asarray(values, STORED.get(description["kind"], "<i4")).view()
    array.flags.writeable = False
    return declared_column(description, words, array)


def declared_column(
    description: dict[str, Any], words: tuple[str, ...], values: NDArray[Any]
) -> Column:
    """A column from its declaration."""
    name, kind, each, unit, meaning, label, listed = (
        description[key]
        for key in ("name", "kind", "each", "unit", "meaning", "label", "listed")
    )  # fmt: skip
    return Column(name, kind, each, unit, meaning, label, listed, words, values)


class Found(dict[str, Any]):
    """Tables or columns of a file by name; a missing one raises an error that names it."""

    def __init__(self, items: Mapping[str, Any], place: str) -> None:
        super().__init__(items)
        self.place = place

    def __missing__(self, name: str) -> Any:
        raise ParameterError(f"{self.place}.{name}: must be present; it is missing")

    def __reduce__(self) -> Any:
        return Found, (dict(self), self.place)


@cache
def declared(
    study: str, of_structure: bool = False, scaled: bool = False
) -> dict[tuple[str, str], dict[str, Any]]:
    """The declarations of the columns of a study of oscillators, or of structures, by table and name.

    A structure is in the units of the user, so its columns have dimensionless units only if it is `scaled`.
    """
    columns = language()["results"][study]["columns"]
    own = {(item["table"], item["name"]): item for item in columns if is_for(item, of_structure)}
    if not of_structure or scaled:
        return own
    return {
        place: item | {"unit": "" if powers_of(item["unit"]) else item["unit"]}
        for place, item in own.items()
    }


def row_of(study: str, of_structure: bool) -> str:
    """The table whose rows are those of the CSV."""
    row: str = language()["results"][study]["rows"][MODELS[of_structure]]
    return row


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A table: columns with one number of rows, and for each row the row (from 0) of the parent table, if there is
    one."""

    dims: dict[str, int]
    parent: str = ""
    owners: NDArray[np.int32] | None = None
    columns: dict[str, Column] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """The result of a study: case, notes, remarks and tables.

    `cut` says how far the study got if it was stopped; `row` names the table whose rows are the rows of the CSV
    file.
    """

    study: str
    case: str
    cut: str
    empty: bool
    remarks: tuple[str, ...]
    notes: tuple[tuple[bool, str], ...]
    row: str
    tables: dict[str, Table]
    handle: Handle | None = None

    def __reduce__(self) -> Any:
        items = [getattr(self, name) for name in self.__slots__[:-1]]
        return Result, tuple(items)

    @property
    def of_structure(self) -> bool:
        """Whether the system is a structure, according to the case or, without a case, to the tables."""
        return has_structure(self.case) or "matrices" in self.tables

    def column(self, table: str, name: str) -> Column:
        """One column; an error if it is missing, as may happen with a file."""
        try:
            return self.tables[table].columns[name]
        except KeyError:
            raise ParameterError(f"{table}.{name}: must be present; it is missing") from None

    def columns(self) -> Iterator[tuple[Table, Column]]:
        """All columns with their tables, in the order of their declaration."""
        for place, name in declared(self.study, self.of_structure):
            table = self.tables.get(place)
            if table is not None and name in table.columns:
                yield table, table.columns[name]

    def part(self, table: str, row: int, study: str, case: str, remark: str) -> Result:
        """One row of a table with all rows that belong to it, as a result of another study; the arrays are
        views."""
        known = declared(study, self.of_structure)
        rows = {table: slice(row, row + 1)}
        tables = {}
        for name, item in self.tables.items():
            if item.parent in rows and item.owners is not None:
                # rows are in the order of their owners
                own = rows[item.parent]
                first, last = np.searchsorted(item.owners, (own.start, own.stop)).tolist()
                rows[name] = slice(first, last)
            elif self.of_structure and name not in (table, "points"):
                tables[name] = item  # of the structure itself
        for name, here in rows.items():
            item = self.tables[name]
            owners = None
            if item.parent in rows and item.owners is not None:
                owners = item.owners[here] - rows[item.parent].start
            columns = {
                key: replace(column, values=column.values[here])
                for key, column in item.columns.items()
                if (name, key) in known
            }
            (dim,) = item.dims
            size = {dim: here.stop - here.start}
            parent = item.parent if owners is not None else ""
            tables[name] = Table(size, parent, owners, Found(columns, name))
        return Result(
            study,
            case,
            self.cut,
            False,
            (remark,),
            (),
            row_of(study, self.of_structure),
            Found(tables, "tables"),
        )

    def narrowed(self, each: str, number: int) -> Result:
        """The same table, with columns that have one value per impact (or the like) cut to the first values."""
        tables = {
            name: replace(item, columns=Found({
                key: replace(column, values=column.values[..., :number]) if column.each == each else column
                for key, column in item.columns.items()
            }, name))
            for name, item in self.tables.items()
        }  # fmt: skip
        return replace(self, tables=Found(tables, "tables"))


def made(
    study: str, case: str, tables: Mapping[str, tuple[Sequence[str], Mapping[str, Any]]],
    remarks: tuple[str, ...] = (), cut: str = "", notes: Sequence[tuple[bool, str]] = (),
) -> Result:  # fmt: skip
    """A result made from arrays that were not computed by the core.

    Parameters
    ----------
    study : str
        The study that declares the columns.
    case : str
        A namelist that gives the result, or "" if none does.
    tables : mapping
        For each table, the names of its dimensions and its columns; columns that are None are omitted.
    notes : sequence of (bool, str)
        Lines for the user, each with a flag (True for a fault) and a text.
    """
    structure = has_structure(case) or "matrices" in tables
    about = declared(study, structure, has_scales(case))
    filled = {}
    for name, (dims, values) in tables.items():
        columns = {
            key: column_from(about[name, key], item)
            for key, item in values.items() if item is not None
        }  # fmt: skip
        shape = next(iter(columns.values())).values.shape
        filled[name] = Table(dict(zip(dims, shape, strict=False)), columns=columns)
    row = row_of(study, structure)
    return Result(study, case, cut, False, remarks, tuple(notes), row, filled)


def settled(result: Result) -> Result:
    """The result with the units of the values of a parameter and of the values along an axis of initial states
    set."""
    found = {}
    scaled = has_scales(result.case)
    for name, table in result.tables.items():
        columns = {}
        for key, column in table.columns.items():
            about = decided(result, name, key) if column.unit == MIXED else {}
            if scaled and key in OF_PARAMETERS:
                about = decided_for_structure(result, name, key)
            columns[key] = replace(column, **about) if about else column
        found[name] = replace(table, columns=Found(columns, name))
    return replace(result, tables=Found(found, "tables"))


def decided(result: Result, table: str, name: str) -> dict[str, Any]:
    """Unit and meaning of a column where they depend on the case; empty if its numbers have several units."""
    keys = keys_of(result.case)
    if result.study == "design":
        return {"unit": UNIT_OF[keys["target"]]} if name in OF_TARGET and keys else {}
    if table in ("first", "second") and "axes" in keys:
        axis = keys["axes"][table == "second"]
        units = {"t": "1/omega", "x": "F0/K", "y": "F0/K"}
        return {"unit": units.get(axis, "omega F0/K"), "meaning": f"{axis} of the states"}
    if name not in ("value", "low", "high") or "parameter" not in keys:
        return {}
    parameter = keys["parameter"]
    meaning = {"r": RATIO, "clearance": GAP}.get(parameter, parameter)
    return {"unit": "F0/K" if parameter == "clearance" else "", "meaning": meaning}


def decided_for_structure(result: Result, table: str, name: str) -> dict[str, Any]:
    """As `decided`, for a dimensionless structure."""
    keys = parts_of(result.case)[-1][1]
    if name == "place":
        axis = keys["axes"][table == "second"] if "axes" in keys else ""
        return {"unit": unit_of_state(axis)}
    own = {"value": "parameter", "x": "x", "y": "y"}[name]
    parameter = keys.get("label", keys.get(own, "frequency" if name == "value" else ""))
    unit = OF_STRUCTURE.get(parameter.split("_")[0], "")
    return {"unit": "", "meaning": RATIO} if unit == "omega" else {"unit": unit}


def runs(table: Table, parents: int | None = None) -> list[slice]:
    """The rows of a table grouped by owner (owners are in order); all rows if the table has no owners."""
    owners = table.owners
    if owners is None:
        return [slice(None)]
    number = (int(owners[-1]) + 1 if owners.size else 0) if parents is None else parents
    ends = np.searchsorted(owners, np.arange(number + 1)).tolist()
    return [slice(first, last) for first, last in pairwise(ends)]


def from_core(study: str, number: int) -> Result:
    """The result of a handle; it is freed with the handle."""
    handle = Handle(number)
    described = json.loads(text_of(_core.describe_result, number))
    lines = [line[2:] for line in described["case"] if not line.startswith("# !")]
    case = "".join(f"{line}\n" for line in lines[: lines.index("&output")])
    known = declared(study, has_structure(case), has_scales(case))
    tables = {}
    for item in described["tables"]:
        # the core counts rows from 1, and its first dimension varies fastest
        dims = dict(reversed(item["dims"]))
        owners = None
        if item["parent"]:
            owners = shown(handle, item["owners"], tuple(dims.values())) - 1
        tables[item["name"]] = Table(dims, item["parent"], owners)
    for item in described["columns"]:
        if item["address"] is None:
            continue
        table = tables[item["table"]]
        about = known[item["table"], item["name"]]
        own = (item["inner"],) if about["each"] else ()
        stored = STORED.get(about["kind"], "<i4")
        values = shown(handle, item["address"], (*table.dims.values(), *own), stored)
        table.columns[item["name"]] = declared_column(about, tuple(item["words"]), values)
    return Result(
        study, case, described["cut"], described["empty"], tuple(described["remarks"]),
        tuple((bool(fault), text) for fault, text in described["notes"]), described["row"], tables, handle,
    )  # fmt: skip
