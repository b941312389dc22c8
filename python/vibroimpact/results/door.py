"""The interface to all studies: a case is the text of a namelist, which the core reads, checks and runs."""

from __future__ import annotations

import operator
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..base import checks
from ..base.errors import OutOfMemoryError, ParameterError, ParameterTypeError, StudyInterrupted
from ..base.interrupt import new_counters, stoppable
from ..base.progress import reported
from ..base.spacing import spacing_of
from ..systems.oscillator import Oscillator, of_numbers
from ..systems.structure import Load, Structure, check_load
from . import namelist
from .states import coordinates_of
from .tables import Handle, Result, from_core, keys_for, message_of

#: The status that the core returns for a case that needs more memory or stack than is available.
NO_MEMORY = 4

Progress = Callable[[float, str], None]
Found = TypeVar("Found")


def run(
    noun: Callable[[Result], Found], osc: Oscillator, keys: Mapping[str, Any], r: float | None = None,
    threads: int | None = None, progress: Progress | None = None,
    parameters: Mapping[str, str] | None = None, start: Mapping[str, Any] | None = None,
    little: bool = False,
) -> Found:  # fmt: skip
    """Run a study in the core and return its result object.

    Parameters
    ----------
    noun : class
        Class of the result; its `study` names the group.
    keys : mapping
        Keys of the group; None for a key that is omitted. `r` belongs to &system.
    parameters : mapping, optional
        The caller's names for keys and words of the core, where they differ.
    start : mapping, optional
        Keys of the &motion that the study starts from.
    little : bool
        Whether the study takes so little time that neither progress nor Ctrl-C needs handling.

    Raises
    ------
    ParameterError, ParameterTypeError
        With the message of the core and the caller's name of the parameter.
    OutOfMemoryError
        If the case needs more memory than is available.
    StudyInterrupted
        After Ctrl-C, with the part that was finished.
    """
    of_numbers(osc)
    before = [] if start is None else [("motion", start)]
    groups = [("system", osc._keys(r)), *before]
    return run_groups(noun, groups, keys, False, threads, progress, parameters, little)


def run_structure(
    noun: type[Found], structure: Structure, load: Load | None, keys: Mapping[str, Any],
    threads: int | None = None, progress: Progress | None = None,
    parameters: Mapping[str, str] | None = None, needs_frequency: bool = True, stops: bool = False,
) -> Found:  # fmt: skip
    """Run a study of a structure in the core and return its result object.

    Parameters
    ----------
    noun : class
        Class of the result; its `study` names the group.
    keys : mapping
        Keys of the group; None for a key that is omitted.
    threads, progress, parameters
        As in `run`.
    needs_frequency : bool
        Whether the load must have a frequency.
    stops : bool
        Whether the study accepts stops and friction.
    """
    kinds = (Load,) if needs_frequency else (Load, type(None))
    check_load(structure, load, frequency=needs_frequency, kinds=kinds, stops=stops)
    groups = [*structure._groups(), *([] if load is None else load._groups())]
    given = {key: value for key, value in keys.items() if value is not None}
    return run_groups(noun, groups, given, True, threads, progress, parameters)


def run_groups(
    noun: Callable[[Result], Found], groups: Iterable[tuple[str, Mapping[str, Any]]], keys: Mapping[str, Any],
    of_structure: bool, threads: int | None = None, progress: Progress | None = None,
    parameters: Mapping[str, str] | None = None, little: bool = False,
) -> Found:  # fmt: skip
    """Runs a study in the core; `groups` describe the system and the motion or state from which the study
    starts."""
    study: str = noun.study  # type: ignore[attr-defined]
    names, known = parameters or {}, keys_for(study, of_structure)
    values = {key: plain(known, key, value, names.get(key, key)) for key, value in keys.items()}
    text = namelist.text([*groups, (study, values)])
    try:
        return run_text(noun, text, threads, progress, little)
    except ParameterError as error:
        message = str(error)
        for name in (study, "system", "structure", "load"):
            message = message.removeprefix(f"&{name} ")
        raise ParameterError(translated(message, names)) from None


def start_keys(structure: Any, state: Any, start: Any) -> dict[str, Any]:
    """The keys of an initial state."""
    checks.instance(structure, "structure", Structure)
    q, rate = coordinates_of(state, structure.coordinates)
    return {"q": np.array(q), "q_dot": np.array(rate), "start": start}


def translated(message: str, names: Mapping[str, str]) -> str:
    """A message of the core in the caller's names; a name such as state['x'] is used only at its beginning."""
    for word, name in names.items():
        whole_word = rf"\b{word}\b" if word.isidentifier() else re.escape(word)
        if ":" in name or "'" in name:
            whole_word = rf"^{word}\b"
        message = re.sub(whole_word, lambda _, name=name: name, message)  # type: ignore[misc]
    return message


def run_text(
    noun: Callable[[Result], Found], text: str, threads: int | None = None,
    progress: Progress | None = None, little: bool = False, counters: NDArray[np.int32] | None = None,
) -> Found:  # fmt: skip
    """The result object of the study whose case is `text`; errors as in `run`, in the terms of a namelist.

    With `counters` the call runs in this thread, and another thread can stop it by setting the stop flag among the
    counters.
    """
    study: str = noun.study  # type: ignore[attr-defined]
    checks.progress(progress)
    workers = checks.integer(
        os.cpu_count() or 1 if threads is None else threads, "threads", 1, 1024
    )
    call = (_core.run_case, np.frombuffer(text.encode(), "S1"), workers)
    if little or counters is not None:
        counters = new_counters() if counters is None else counters
        (handle, status), complete = call[0](*call[1:], counters), True
    else:
        with reported(progress, study) as told:
            (handle, status), complete = stoppable(
                *call, counters=new_counters(), progress=told, note=study
            )
    if status == 2:
        raise ParameterError(message_of(Handle(handle)))
    result = from_core(study, handle)
    if status == NO_MEMORY:
        raise OutOfMemoryError(result.notes[-1][1])
    if result.cut and result.empty:
        raise KeyboardInterrupt
    found = noun(result)
    if not complete:
        raise StudyInterrupted(found)
    return found


def plain(known: Sequence[Mapping[str, Any]], key: str, value: Any, name: str) -> Any:
    """The value of a key in a form for a namelist: float, int, str, or a list of them; the core checks its range.

    `known` are the declarations of all keys."""
    declared = next(item for item in known if item["name"] == key)
    wanted = declared["takes"]
    if value is None:
        # None never stands for a default, even where the core has one
        if declared["default"]:
            raise ParameterTypeError(f"{name} = None: must be {wanted}")
        return None
    kind = {"number": number, "whole": whole, "word": word}[declared["kind"]]
    several = isinstance(value, (list, tuple))  # of any shape
    if declared["most"] == 1 or (not several and np.ndim(value) == 0):
        return kind(value, name, wanted)
    if declared["kind"] != "number":
        return [kind(item, name, wanted) for item in value]
    array = checks.real_array(value, name, wanted)
    if array.ndim != 1 or array.size == 0:
        raise ParameterError(f"{name} of shape {array.shape}: must be {wanted}, one list")
    return array.tolist()


def number(value: Any, name: str, wanted: str) -> float:
    """Any real number as a float."""
    return checks.to_float(value, name, wanted)


def whole(value: Any, name: str, wanted: str) -> int:
    """Any whole number as an int."""
    if isinstance(value, (bool, np.bool_)):
        raise ParameterTypeError(f"{name} = {value!r}: must be {wanted}, not bool")
    try:
        return operator.index(value)
    except TypeError:
        kind = ParameterError if isinstance(value, float) else ParameterTypeError
        raise kind(f"{name} = {value!r}: must be {wanted}") from None


def word(value: Any, name: str, wanted: str) -> str:
    """A text."""
    if not isinstance(value, str):
        raise ParameterTypeError(f"{name} = {value!r}: must be {wanted}")
    return value


def line(name: str, values: Any, geometric: bool = False) -> dict[str, Any]:
    """The values along an axis as namelist keys: both ends and the number, if these reproduce the values
    exactly."""
    array = np.atleast_1d(checks.real_array(values, name, "numbers"))
    if array.ndim != 1 or array.size == 0:
        raise ParameterError(
            f"{name} of shape {array.shape}: must be a number or a list of numbers"
        )
    spacing = spacing_of(array)
    if spacing == "linear" or (geometric and spacing == "geometric"):
        low, high = float(array[0]), float(array[-1])
        ends = {f"{name}_min": low, f"{name}_max": high, f"{name}_points": array.size}
        return ends | ({"spacing": spacing} if geometric else {})
    return {name: array}


def swept(values: NDArray[np.float64], parameter: str) -> dict[str, Any] | None:
    """The namelist keys of the values of a parameter: ends, number and spacing, if these reproduce the values
    exactly."""
    for end in (values.min(), values.max()):
        checks.number(float(end), "restitution" if parameter[0] == "R" else parameter, parameter)
    spacing = spacing_of(values) if values.ndim == 1 else None
    if spacing is None:
        return None
    low, high = float(values[0]), float(values[-1])
    return {"low": low, "high": high, "values": values.size, "spacing": spacing}
