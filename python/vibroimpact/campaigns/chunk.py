"""A chunk: some cases of a campaign, computed and packed into a few arrays."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..base.errors import ParameterError, VibroimpactError
from ..base.interrupt import new_counters
from ..cases.case import case_of
from ..results import door
from ..results.namelist import has_scales, has_structure
from ..results.noun import Noun, result_class
from ..results.tables import STORED, Found, Result, Table, declared, declared_column, language

__all__ = ["Chunk", "compute", "core_digest", "name_of"]

#: The value that fills lists shorter than the longest one of the chunk.
FILL = {"real": np.nan, "complex": complex(np.nan, np.nan)}


@dataclass(frozen=True)
class Chunk:
    """The packed results of a group of cases.

    Attributes
    ----------
    study : str
        The study, the same for all cases.
    heads : list of dict
        For each case, its text and the parts of its result that are not tables; `error` for a rejected case.
    arrays : dict
        For each table, the columns by name, with all rows of all cases; `case` is the case of each row (from 0
        within the chunk), and `owner` the row of the parent table within this case.
    words : dict
        The words of each column (table, name), in the order of their codes, which start at 1.
    """

    study: str
    heads: list[dict[str, Any]]
    arrays: dict[str, dict[str, NDArray[Any]]]
    words: dict[tuple[str, str], tuple[str, ...]]

    @property
    def errors(self) -> dict[int, str]:
        """The reasons for which cases were rejected, by their number in the chunk."""
        return {i: head["error"] for i, head in enumerate(self.heads) if "error" in head}

    def noun(self, number: int) -> Noun:
        """The result of one case; the error of a rejected case is raised."""
        head = self.heads[number]
        if "error" in head:
            raise ParameterError(head["error"])
        known = declared(self.study, has_structure(head["case"]), has_scales(head["case"]))
        tables = {}
        for name, about in head["tables"].items():
            packed = self.arrays[name]
            first, last = np.searchsorted(packed["case"], (number, number + 1)).tolist()
            shape = tuple(about["dims"].values())
            columns = {}
            for key, inner in about["columns"].items():
                item = known[name, key]
                values = packed[key][first:last]
                values = (
                    values[:, :inner].reshape(*shape, inner)
                    if item["each"]
                    else values.reshape(shape)
                )
                columns[key] = declared_column(item, self.words.get((name, key), ()), values)
            owners = packed["owner"][first:last].reshape(shape) if about["parent"] else None
            tables[name] = Table(about["dims"], about["parent"], owners, Found(columns, name))
        result = Result(
            self.study, head["case"], head["cut"], head["empty"], tuple(head["remarks"]),
            tuple((bool(fault), text) for fault, text in head["notes"]), head["row"], Found(tables, "tables"),
        )  # fmt: skip
        return result_class(self.study).of_result(result)


def compute(
    study: str, texts: Sequence[str], digest: str = "", threads: int = 1,
    counters: NDArray[np.int32] | None = None,
) -> Chunk:  # fmt: skip
    """The results of some cases; `digest` identifies the caller's core.

    Another thread can stop the computation with the flag of the progress counters; KeyboardInterrupt is then
    raised.
    """
    counters = new_counters() if counters is None else counters
    if digest and core_digest() != digest:
        raise ParameterError(
            "a worker has a different build of the core from this process; install the same vibroimpact on both"
        )

    def found() -> Iterator[Result | str]:
        """Yields the results, or errors; none is kept, since each one holds everything that the core computed for
        it."""
        for text in texts:
            counters[:2] = 0
            result: Result | str
            try:
                result = result_of(study, text, threads, counters)
            except MemoryError:  # a later call may have more memory
                raise
            except VibroimpactError as error:
                result = str(error)
            except Exception as error:  # a defect affects only its own case
                result = f"{type(error).__name__}: {error}"
            if counters[2]:
                raise KeyboardInterrupt
            yield result

    return packed(study, texts, found())


def result_of(study: str, text: str, threads: int, counters: NDArray[np.int32]) -> Result:
    """The result of one case."""
    noun = result_class(study)
    if language()["results"][study]["in_python"]:
        result: Result = noun.computed(case_of(text), None)._result
    else:
        result = door.run_text(noun, text, threads, counters=counters)._result
    return result


def packed(study: str, texts: Sequence[str], found: Iterable[Result | str]) -> Chunk:
    """The results, or errors, of several cases in one set of arrays."""
    heads: list[dict[str, Any]] = []
    rows: dict[str, dict[str, list[Any]]] = {}
    words: dict[tuple[str, str], dict[str, int]] = {}
    for number, (text, result) in enumerate(zip(texts, found, strict=True)):
        if isinstance(result, str):
            heads.append({"text": text, "error": result})
            continue
        tables = {}
        for name, table in result.tables.items():
            size = math.prod(table.dims.values())
            inner = {}
            into = rows.setdefault(name, {})
            into.setdefault("case", []).append(np.full(size, number, "<i4"))
            if table.owners is not None:
                into.setdefault("owner", []).append(np.array(table.owners, "<i4").ravel())
            for key, column in table.columns.items():
                inner[key] = column.values.shape[-1] if column.each else 1
                values = (
                    column.values.reshape(size, inner[key]) if size else np.empty((0, inner[key]))
                )
                if column.kind == "word":
                    values = recoded(column.words, values, words.setdefault((name, key), {}))
                else:
                    values = values.copy()
                into.setdefault(key, []).append((number, values))
            tables[name] = {"dims": table.dims, "parent": table.parent, "columns": inner}
        heads.append({
            "text": text, "case": result.case, "cut": result.cut, "empty": result.empty,
            "remarks": list(result.remarks), "notes": [list(note) for note in result.notes], "row": result.row,
            "tables": tables,
        })  # fmt: skip
    known = declared(study, has_structure(texts[0]))
    arrays = {
        name: {key: joined(known, name, key, parts, columns["case"]) for key, parts in columns.items()}
        for name, columns in rows.items()
    }  # fmt: skip
    return Chunk(study, heads, arrays, {place: tuple(codes) for place, codes in words.items()})


def recoded(words: Sequence[str], values: NDArray[Any], codes: dict[str, int]) -> NDArray[np.int32]:
    """The codes of words in a list that several tables share; new words are appended to it."""
    new = [0, *(codes.setdefault(word, len(codes) + 1) for word in words)]
    return np.asarray(np.array(new, "<i4")[values.astype(int)])


def joined(
    known: Mapping[tuple[str, str], Mapping[str, Any]], table: str, key: str, parts: Sequence[Any],
    cases: Sequence[NDArray[Any]],
) -> NDArray[Any]:  # fmt: skip
    """All rows of a column; shorter lists, and rows of cases without this column, are filled."""
    if key in ("case", "owner"):
        return np.concatenate(parts)
    item = known[table, key]
    kind = STORED.get(item["kind"], "<i4")
    widths = {values.shape[1] for _, values in parts}
    width = max(widths)
    if len(widths) == 1 and len(parts) == len(cases):  # no list is shorter
        whole = np.concatenate([values for _, values in parts]).astype(kind, copy=False)
        return whole if item["each"] else whole[:, 0]
    sizes = [len(part) for part in cases]
    numbers = [int(part[0]) if len(part) else -1 for part in cases]
    given = dict(parts)
    blocks = []
    for number, size in zip(numbers, sizes, strict=True):
        block = np.full(
            (size, width), FILL.get(item["kind"], -1 if item["kind"] == "verdict" else 0), kind
        )
        if number in given:
            block[:, : given[number].shape[1]] = given[number]
        blocks.append(block)
    whole = np.concatenate(blocks)
    return whole if item["each"] else whole[:, 0]


@cache
def core_digest() -> str:
    """Identifies the compiled core, so that results of different versions are not mixed."""
    return hashlib.sha256(Path(_core.__file__).read_bytes()).hexdigest()


def name_of(study: str, first: int, texts: Sequence[str]) -> str:
    """The name of a chunk: the number of its first case, and a hash of the core and of the cases."""
    body = json.dumps([core_digest(), study, *texts]).encode()
    return f"{first:012d}-{hashlib.sha256(body).hexdigest()[:40]}"
