"""The cases of a namelist file, read and computed by the core."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..base.errors import ParameterError, ParameterTypeError
from ..motions.motion import Motion, MotionSet
from ..results import door
from ..results.namelist import keys_of, parts_of, system_keys
from ..results.noun import Noun, result_class
from ..results.systems import from_groups
from ..results.tables import Handle, keys_for, language, message_of
from ..systems.oscillator import Oscillator
from ..systems.record import Record
from ..systems.structure import Load, Structure

__all__ = ["Case", "read_namelist"]


@cache
def kinds(structures: bool = True) -> tuple[str, ...]:
    """Kinds of cases: the words of the key `kind` of a study, or the name of its group."""
    words = []
    for study in language()["results"]:
        keys = keys_for(study) + (keys_for(study, True) if structures else [])
        words += [key["words"] for key in keys if key["name"] == "kind"] or [study]
    return tuple(dict.fromkeys(" ".join(words).split()))


class Case(NamedTuple):
    """A case of a namelist file.

    Attributes
    ----------
    name : str
        Name of the result.
    kind : str
        The kind of a &motion ("periodic", "equispaced", "exact"), otherwise the name of the group.
    osc : Oscillator or None
        None for a case of a structure.
    r : float or None
        The frequency ratio; None for a case that has several.
    keys : dict
        All other keys of its groups, with defaults filled in; for a branch also motion_kind, the kind of its
        &motion. For a structure, the keys of the study and of &output.
    text : str
        The complete case as a namelist, as in the header of its result.
    structure : Structure or None
        The structure of a &structure, with its gaps.
    load : Load, Record or None
        The load of its &load, if it has one.
    """

    name: str
    kind: str
    osc: Oscillator | None
    r: Any
    keys: dict[str, Any]
    text: str
    structure: Structure | None = None
    load: Load | Record | None = None

    @property
    def motion_kind(self) -> str:
        """The kind of the motion, including the motion from which a branch starts."""
        kind: str = self.keys.get("motion_kind", self.kind)
        return kind

    @property
    def study(self) -> str:
        """Name of the study."""
        return study_of(self.text)

    @property
    def missing_units(self) -> str:
        """What its system lacks for results in physical units; empty if it lacks nothing."""
        if self.structure is not None:
            return "" if self.structure._units is not None else "&structure has no scales"
        known = self.osc is not None and self.osc.F0 is not None
        return "" if known else "&system has no mass, stiffness and force"

    @property
    def in_python(self) -> bool:
        """Whether the Python package computes the case, and not the core."""
        computed: bool = language()["results"][self.study]["in_python"]
        return computed

    def compute(self, progress: Callable[[float, str], None] | None = None) -> Noun:
        """The result of the case as one object.

        It includes motions that do not exist or whose computation failed.

        Parameters
        ----------
        progress : callable, optional
            Called with the fraction done and the current task; by default a bar on a terminal or in a notebook.

        Returns
        -------
        a result of the study
            A Branch, a Zone or an Atlas, for example.
        """
        noun = result_class(self.study)
        if self.in_python:
            return noun.computed(self, progress)
        return door.run_text(noun, self.text, progress=progress)

    def run(self, progress: Callable[[float, str], None] | None = None) -> list[Any]:
        """The results of the case: its motions, branches, or one trajectory, zone, atlas, chart or other result.

        Parameters
        ----------
        progress : callable, optional
            Called with the fraction done and the current task; by default a bar on a terminal or in a notebook.

        Returns
        -------
        list
            One result for each motion or branch; otherwise a single one.
        """
        found = self.compute(progress)
        found.require()
        return found.parts()

    def to_namelist(self) -> str:
        """The case as a namelist, with defaults filled in.

        Returns
        -------
        str
            The groups of the case; the same as `text`.
        """
        return self.text

    def motions(self) -> list[Motion]:
        """The motions that its &motion defines, including those from which a branch starts.

        Returns
        -------
        list of Motion
            Empty if the case defines no motion.
        """
        system, motion, *_, output = re.findall(r"(?ms)^&.*?^/$\n?", self.text)
        found = door.run_text(MotionSet, system + motion + output)
        found.require()
        return found.parts()


def study_of(text: str) -> str:
    """The name of the study of a case: that of its last group before &sweep and &output."""
    *_, last = (name for name in groups_of(text) if name not in ("sweep", "output"))
    return last


def groups_of(text: str) -> list[str]:
    """The names of the groups of a case, in order."""
    return re.findall(r"(?m)^&(\w+)$", text)


def read_namelist(path: str | os.PathLike[str]) -> list[Case]:
    """The cases of a namelist file, read by the compiled reader, which also fills in defaults.

    Parameters
    ----------
    path : path
        A file with the groups &system, &motion, … (see inputs/README.md), or an earlier result.

    Returns
    -------
    list of Case
        The method `run` of each case returns its motions, branches, trajectory, zone, atlas or chart, with the
        same digits that `run_namelists` writes.

    Raises
    ------
    ParameterError
        If the file is invalid; the message names file, line, key, value and what is allowed.

    Examples
    --------
    >>> import pathlib, tempfile, vibroimpact as vi
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "pair.nml"
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> _ = path.write_text(vi.equispaced(osc, r=0.94, clearance=37.0)[0].to_namelist())
    >>> (case,) = vi.read_namelist(path)
    >>> case.run()
    [<Motion RL/1 at r = 0.94, ...unstable...>, <Motion RL/1 at r = 0.94, ...unstable...>]
    """
    name = path_bytes(path)
    handle, status = _core.read_namelist(characters(name))
    echo = message_of(Handle(handle))
    if status:
        raise ParameterError(echo)
    texts: list[str] = []
    # the reader returns each case as in the header of its result: one `# key = value` per line
    for line in echo.split("\n"):
        if line in ("# &system", "# &structure"):
            texts.append("")
        if texts and not line.startswith("# !"):
            texts[-1] += line[2:] + "\n"
    return [case_of(text.strip("\n") + "\n") for text in texts]


def case_of(text: str) -> Case:
    """A case from a complete and checked text with one `key = value` per line."""
    return _structure_case(text) if text.startswith("&structure") else _case(text)


def _case(text: str) -> Case:
    keys, system = keys_of(text), system_keys(text)
    name, kind, r = (keys.pop(key, None) for key in ("name", "kind", "r"))
    # keys of &system are in `osc`; a study's own key of the same name stays
    others = {
        key for group, items in parts_of(text) if group not in ("system", "sweep") for key in items
    }
    keys = {key: value for key, value in keys.items() if key not in system or key in others}
    return Case(name, kind, Oscillator._of_keys(system), r, keys, text)


def _structure_case(text: str) -> Case:
    *parts, (kind, keys) = [part for part in parts_of(text) if part[0] not in ("sweep", "output")]
    output = dict(parts_of(text))["output"]
    structure, load = from_groups(parts)
    name = output.pop("name")
    return Case(name, kind, None, None, keys | output, text, structure, load)


def path_bytes(path: str | os.PathLike[str], name: str = "path") -> bytes:
    """A path in the form for the compiled reader; `name` is the name of the argument."""
    try:
        found = os.fsencode(path)
    except TypeError:
        raise ParameterTypeError(
            f"{name} = {path!r}: must be a path, not {type(path).__name__}"
        ) from None
    except UnicodeEncodeError:
        raise ParameterError(
            f"{name} = {path!r}: must be text that can be encoded as a path"
        ) from None
    if not found or b"\0" in found:
        raise ParameterError(
            f"{name} = {os.fsdecode(found)!r}: must not be empty or contain a null byte"
        )
    return found


def characters(text: bytes) -> NDArray[np.bytes_]:
    return np.frombuffer(text, "S1")
