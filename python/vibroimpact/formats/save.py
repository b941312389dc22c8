"""Writes results to files, in the format of the extension."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .. import _core
from ..base.errors import ParameterError
from ..base.files import place_for, write_text
from ..base.interrupt import new_counters, stoppable
from ..results import namelist
from ..results.tables import STORED, Handle, Result, message_of
from ..systems.units import chosen_units, units_to_show
from . import matlab, netcdf


def save(noun: Any, path: str | Path, units: str | None = None) -> None:
    """Write a file, completely or not at all, in the requested units."""
    place = place_for(path, WRITERS)
    if place.suffix.lower() == ".csv":
        write_csv(noun, place, units)
    else:
        shown = noun if units in (None, "dimensionless") else noun.physical(units)
        WRITERS[place.suffix.lower()](shown, place)


def write_csv(noun: Any, path: Path, units: str | None = None) -> None:
    """Write the rows with the case in the header; the core writes them, and Ctrl-C stops it.

    A `Physical` and a result without a case are written in Python, because the core takes the units from the case.
    """
    if hasattr(noun, "_csv"):
        write_text(path, noun._csv())
        return
    result, known = noun._result, units_to_show(noun._system)
    if result.study == "identify":
        known = None  # its numbers are in units of SI
    elif units not in (None, "dimensionless"):
        known = chosen_units(noun, noun._system, units)
    if known is not None and units != "dimensionless" and not result.case:
        write_text(path, noun.physical(known)._csv())
        return
    if units is not None and result.case:
        names = units if known is None or units == "dimensionless" else known.names
        result = replace(result, case=namelist.shown_in(result.case, names), handle=None)
    handle = result.handle or restored(result)
    message, complete = stoppable(
        _core.write_result, handle.number, file_name(path), counters=new_counters()
    )
    if not complete:
        raise KeyboardInterrupt
    check_written(message, path)


def write_printout(noun: Any, path: Path) -> None:
    """Write the motions of a case as a printout, by the core."""
    handle = handle_of(noun)
    check_written(_core.write_printout(handle.number, file_name(path)), path)


def handle_of(noun: Any) -> Handle:
    """The handle of the result in the core; a result that the core does not hold is transferred to it."""
    handle: Handle = noun._result.handle or restored(noun._result)
    return handle


def file_name(path: Path) -> Any:
    """A path in the form that the core expects."""
    return np.frombuffer(os.fsencode(path), "S1")


def check_written(message: Any, path: Path) -> None:
    """Raises an error if the core could not write a file."""
    reason = bytes(message.tobytes()).decode(errors="replace").strip()
    if reason:
        raise OSError(errno.ENOSPC if "full" in reason else errno.EIO, reason, str(path))


def restored(result: Result) -> Handle:
    """Transfers a result to the core that the core does not hold."""
    study = characters(f"{result.study:24}")
    number, status = _core.new_result(
        characters(result.case or " "), study, 1 + result.of_structure
    )
    handle = Handle(number)
    if status:
        raise ParameterError(f"case: {message_of(handle)}")
    _core.add_notes_of(number, characters("\n".join([result.cut, *result.remarks]) + "\n"))
    for name, table in result.tables.items():
        names = f"{name:16}{table.parent:16}{' '.join(reversed(table.dims)):64}"
        sizes = np.array(list(table.dims.values()), np.int32)[::-1]
        owners = np.array([], np.int32) if table.owners is None else table.owners + 1
        _core.open_table(number, characters(names), sizes, owners)
        for column in table.columns.values():
            place = characters(f"{name:16}{column.name:24}")
            values = column.values.ravel()
            if column.kind in STORED:
                _core.fill_reals(number, place, values.view(np.float64))
            else:
                words = "".join(f"{word}\n" for word in column.words) or " "
                _core.fill_wholes(number, place, values, characters(words))
    return handle


def characters(text: str) -> Any:
    """A text in the form that the core expects; a file name that is not UTF-8 keeps its bytes."""
    return np.frombuffer(text.encode(errors="surrogateescape"), "S1")


WRITERS: dict[str, Callable[[Any, Path], None]] = {
    ".json": lambda noun, path: write_text(path, noun.to_json()),
    ".csv": write_csv,
    ".nc": netcdf.write_netcdf,
    ".mat": matlab.write_matlab,
}
