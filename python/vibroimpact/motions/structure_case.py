"""Cases of structures for the studies of the core."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np

from ..base import checks
from ..base.errors import ParameterError
from ..results import door, namelist
from ..results.tables import language
from ..systems.structure import Load, Structure
from .structure_trajectory import _state

_Found = TypeVar("_Found")


def run_structure(
    noun: type[_Found], structure: Structure, load: Load | None, keys: Mapping[str, Any],
    threads: int | None = None, progress: door.Progress | None = None,
    parameters: Mapping[str, str] | None = None, needs_frequency: bool = True,
) -> _Found:  # fmt: skip
    """Runs a study of a structure in the core and returns its result object.

    Parameters
    ----------
    noun : class
        Class of the result; the last of its `studies` is that of structures.
    keys : mapping
        Keys of the group; None for a key that is left out.
    threads, progress, parameters
        As of `door.run`.
    needs_frequency : bool
        Whether the load must have a frequency.
    """
    study: str = noun.studies[-1]  # type: ignore[attr-defined]
    check_load(structure, load, needs_frequency)
    names = parameters or {}
    values = {
        key: door.plain(study, key, value, names.get(key, key))
        for key, value in keys.items() if value is not None
    }  # fmt: skip
    group = language()["results"][study]["group"]
    forces = [] if load is None else load._groups()
    text = namelist.text([*structure._groups(), *forces, (group, values)])
    try:
        return door.run_text(noun, text, threads, progress, study=study)
    except ParameterError as error:
        message = str(error)
        for name in (group, "structure", "load"):
            message = message.removeprefix(f"&{name} ")
        raise ParameterError(door.translated(message, names)) from None


def check_load(structure: Any, load: Any, needs_frequency: bool) -> None:
    """Checks that a load is one for a structure."""
    checks.instance(structure, "structure", Structure)
    if load is None and not needs_frequency:
        return
    checks.instance(load, "load", Load)
    if load.coordinates != structure.coordinates:
        raise ParameterError(
            f"load for {load.coordinates} coordinates: must be for {structure.coordinates} as the structure is"
        )
    if needs_frequency and not load.frequency:
        raise ParameterError(f"load = {load!r}: must have a frequency, which gives the period")


def start_keys(structure: Any, state: Any, start: Any) -> dict[str, Any]:
    """The keys of an initial state."""
    checks.instance(structure, "structure", Structure)
    q, rate = _state(state, structure.coordinates)
    return {"q": np.array(q), "q_dot": np.array(rate), "start": start}
