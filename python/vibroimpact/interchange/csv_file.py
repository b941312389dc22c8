"""Tables as CSV files, with the case and what else there is to say in the header."""

from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from ..errors import ParameterError
from ..files import write_text
from .table import Columns, columns

#: Values of a column whose text is kept for when they come again.
MOST_KNOWN = 10_000


def notes(result: Any, number: int = 1) -> list[str]:
    """What the header tells beside the case; first of all that a study was cut short."""
    return [*cut_of(result), *remarks_of(result, number)]


def cut_of(result: Any) -> list[str]:
    """How far a study came that Ctrl-C cut short; nothing of any other result."""
    cut = getattr(result, "cut", "")
    return [f"cut short: {cut}"] if cut else []


def remarks_of(result: Any, number: int) -> list[str]:
    """What else it tells of a result, which has a number if there are several."""
    name = type(result).__name__
    if name == "Trajectory":
        cut = [] if result.complete else ["cut short: max_events was reached"]
        state = ", ".join(
            exact(result.final_state[key]) for key in ("t", "x", "x_dot", "z", "z_dot")
        )
        return [*cut, f"final state: t, x, x_dot, z, z_dot = {state}"]
    return []


def counted(number: int, noun: str) -> str:
    """A number of things."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def csv_text(result: Any, name: str) -> str:
    """The bytes of the result that `vibroimpact run` writes for its case: an input again."""
    try:
        case = complete(result.to_namelist(), name)
    except ParameterError:
        case = []
    table = columns(result)
    head = head_text(case, notes(result))
    return head + rows_text(table)


def head_text(case: Sequence[str], remarks: Sequence[str] = ()) -> str:
    """The header of a table: the lines of its case, and remarks."""
    from .. import __version__

    last = "this file is an input too" if case else "no namelist tells how it began"
    title = (
        f"! vibroimpact {__version__}; lengths in F0/K, time in 1/omega, angles in radians; {last}"
    )
    return "".join(f"# {line}\n" for line in (title, *case, *(f"! {note}" for note in remarks)))


def complete(namelist: str, name: str) -> list[str]:
    """The lines of a namelist as the compiled reader completes it."""
    from ..case import read_namelist

    clean = re.sub(r"[^\w.-]|^\.", "_", name, flags=re.ASCII)[:100] or "case"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.nml"
        path.write_text(f"{namelist}&output\n  name = '{clean}'\n/\n", encoding="utf-8")
        (case,) = read_namelist(path)
    return case.text.splitlines()


def rows_text(table: Columns) -> str:
    """Names of columns and rows as CSV."""
    lines = map(",".join, zip(*map(shown, table.values()), strict=True))
    return "".join(f"{line}\n" for line in (",".join(table), *lines))


def shown(column: Iterable[Any]) -> Iterable[str]:
    """A column as text: 17 digits, true, false or unknown. What stands there often is made once."""
    known: dict[Any, str] = {}
    for item in column:
        # 0.0 and -0.0 are equal, and so are 1, 1.0 and true
        key = item if item and type(item) is float else (type(item), str(item))
        text = known.get(key)
        if text is None:
            text = cell(item)
            if len(known) < MOST_KNOWN:
                known[key] = text
        yield text


def cell(item: Any) -> str:
    """A value as text."""
    if isinstance(item, float):
        return exact(item)
    if item is None or isinstance(item, bool):
        return {True: "true", False: "false", None: "unknown"}[item]
    text = str(item)
    return '"' + text.replace('"', '""') + '"' if re.search(r'[",\r\n]', text) else text


def exact(value: float) -> str:
    """A number as the compiled program writes it."""
    if not math.isfinite(value):
        return "nan" if value != value else ("inf" if value > 0 else "-inf")
    text = f"{value:.16E}"
    return text if text[-4] != "E" else f"{text[:-2]}0{text[-2:]}"  # three digits of the exponent


def write_csv(result: Any, path: Path) -> None:
    """Write the table with its case in the header."""
    write_text(path, csv_text(result, path.stem))
