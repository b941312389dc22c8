"""Runs namelist files with the compiled reader and writer that the batch program also uses."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

from .. import _core
from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError, StudyInterrupted
from ..base.interrupt import new_counters, stoppable
from ..results.tables import Handle, message_of
from .case import characters, kinds, path_bytes

__all__ = ["RunLog", "run_namelists"]


class RunLog(NamedTuple):
    """The messages of a run of namelist files.

    Attributes
    ----------
    lines : list of (bool, str)
        Whether the line reports an error, and the line.
    status : int
        0: done; 1: ran, but a motion failed or does not exist; 2: an input is invalid.
    results : list of Path
        The tables (CSV) that were written.
    """

    lines: list[tuple[bool, str]]
    status: int
    results: list[Path]


def run_namelists(
    paths: Iterable[str | os.PathLike[str]],
    folder: str | os.PathLike[str] = "results",
    only: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> RunLog:
    """Run namelist files and write one result per case into a folder.

    Parameters
    ----------
    paths : iterable of path
        Namelist files (inputs/README.md describes their groups), or earlier results.
    folder : path
        Created if it does not exist.
    only : str, optional
        The kind of cases to run; a file without such a case is then an invalid input.
    progress : callable, optional
        Called a few times per second with the completed fraction of the cases begun so far.

    Returns
    -------
    RunLog
        The messages, the exit status, and the files that were written.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.
    StudyInterrupted
        On Ctrl-C; its `result` is the log. The finished part of the interrupted case is written; a second
        Ctrl-C abandons it.

    Examples
    --------
    >>> import pathlib, tempfile, vibroimpact as vi
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> namelist = folder / "pair.nml"
    >>> _ = namelist.write_text(
    ...     "&system xi = 0.005, mu = 0.042, restitution = 0.75, r = 0.94 /\\n"
    ...     "&motion sides = 'RL', phases_over_pi = 0, 1.37 /\\n"
    ... )
    >>> log = vi.run_namelists([namelist], folder)
    >>> log.status, log.lines[0]
    (0, (False, 'pair: consistent, admissible, stable (max|lambda| = 0.9347, complex)'))
    >>> (folder / "pair.csv").exists()
    True
    """
    if isinstance(paths, (str, bytes, os.PathLike)) or not isinstance(paths, Iterable):
        raise ParameterTypeError(f"paths = {paths!r}: must be a list of files")
    try:
        files = [path_bytes(path) for path in paths]
    except TypeError as error:
        if isinstance(error, ParameterTypeError):
            raise
        raise ParameterTypeError(f"paths = {paths!r}: must be a list of files") from None
    checks.progress(progress)
    target = path_bytes(folder, "folder")
    if not files:
        raise ParameterError("paths = []: must name at least one file")
    kind = "" if only is None else checks.choice(only, "only", kinds())
    counters = new_counters()
    arguments = (
        characters(b"\0".join(files)), characters(target), characters(kind.ljust(16).encode()),
    )  # fmt: skip

    def told(*_: Any) -> None:
        """Progress: the fraction of the work that is known so far, which may fall with the next case."""
        if progress is not None:
            progress(float(counters[0] / max(1, counters[1])))

    (handle, status), complete = stoppable(
        _core.run_namelists, *arguments, counters=counters, progress=told, writes=True
    )
    log = message_of(Handle(handle)).split("\0")[:-1]
    lines = [(line.startswith("!"), line[1:]) for line in log if line[0] in "-!"]
    found = RunLog(lines, int(status), [Path(line[1:]) for line in log if line[0] == ">"])
    if not complete:
        raise StudyInterrupted(found)
    return found
